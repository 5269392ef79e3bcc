//! Cameras as text: a preset's name, numbers, or both.

use super::OrbitCamera;
use glam::Vec3;
use std::str::FromStr;

/// A named view of a character at the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraPreset {
    /// Face to face.
    Front,
    /// From the character's left.
    Side,
    /// From straight above, +Z up in the picture.
    Top,
    /// From the front left and above.
    ThreeQuarter,
}

impl CameraPreset {
    /// Every preset, in the order of menus.
    pub const ALL: [Self; 4] = [Self::Front, Self::Side, Self::Top, Self::ThreeQuarter];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        self.definition().0
    }

    /// Name on the command line, yaw and pitch (degrees).
    const fn definition(self) -> (&'static str, f32, f32) {
        match self {
            Self::Front => ("front", 0.0, 6.0),
            Self::Side => ("side", 90.0, 6.0),
            Self::Top => ("top", 180.0, 90.0),
            Self::ThreeQuarter => ("three-quarter", 35.0, 18.0),
        }
    }

    /// The view of one character at the origin.
    pub fn camera(self) -> OrbitCamera {
        let (_, yaw, pitch) = self.definition();
        let [yaw, pitch, fov_y] = [yaw, pitch, 35.0].map(f32::to_radians);
        OrbitCamera { target: Vec3::new(0.0, 0.9, 0.0), distance: 4.5, yaw, pitch, fov_y }
    }

    /// Turns a camera into this direction and leaves its target and distance.
    pub fn turn(self, camera: &mut OrbitCamera) {
        let view = self.camera();
        (camera.yaw, camera.pitch) = (view.yaw, view.pitch);
        camera.limit();
    }
}

impl FromStr for OrbitCamera {
    type Err = String;

    /// A preset's name, or settings such as `yaw=30,pitch=20,distance=6,target=0:1:0,fov=35`, or a name followed by
    /// settings. Angles are in degrees; missing settings are those of the three-quarter view.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut camera = Self::default();
        for part in text.split(',').map(str::trim) {
            match part.split_once('=') {
                Some((key, value)) => set(&mut camera, key.trim(), value.trim())?,
                None => {
                    let preset = CameraPreset::ALL.into_iter().find(|p| p.name() == part);
                    let preset = preset.ok_or_else(|| {
                        format!("camera: `{part}` is no view; use front, side, top or three-quarter, or key=value")
                    })?;
                    preset.turn(&mut camera);
                }
            }
        }
        camera.limit();
        Ok(camera)
    }
}

fn set(camera: &mut OrbitCamera, key: &str, value: &str) -> Result<(), String> {
    match key {
        "yaw" => camera.yaw = number(key, value)?.to_radians(),
        "pitch" => camera.pitch = ranged(key, value, -80.0..=90.0, "-80 to 90 degrees")?.to_radians(),
        "distance" => camera.distance = ranged(key, value, 0.15..=2000.0, "0.15 to 2000 m")?,
        "fov" => camera.fov_y = ranged(key, value, 3.0..=135.0, "3 to 135 degrees")?.to_radians(),
        "target" => camera.target = point(value)?,
        _ => {
            return Err(format!(
                "camera: `{key}` is no setting; the settings are yaw, pitch, distance, target and fov"
            ));
        }
    }
    Ok(())
}

fn number(key: &str, value: &str) -> Result<f32, String> {
    let parsed = value.parse::<f32>().ok().filter(|v| v.is_finite());
    parsed.ok_or_else(|| format!("camera: {key}={value} is not a number"))
}

fn ranged(key: &str, value: &str, range: std::ops::RangeInclusive<f32>, expected: &str) -> Result<f32, String> {
    let v = number(key, value)?;
    if range.contains(&v) { Ok(v) } else { Err(format!("camera: {key}={v} is out of range; it must be {expected}")) }
}

fn point(value: &str) -> Result<Vec3, String> {
    let parts: Vec<f32> =
        value.split(':').filter_map(|p| p.trim().parse().ok()).filter(|v: &f32| v.is_finite()).collect();
    match parts[..] {
        [x, y, z] if value.split(':').count() == 3 => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("camera: target={value} is not three numbers x:y:z")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_names_of_views_are_read() {
        let read = |text: &str| text.parse::<OrbitCamera>().unwrap_or_else(|why| panic!("{text}: {why}"));
        let c = read("yaw=-171.5,pitch=90,distance=0.5,target=-3.25:0:2,fov=60");
        assert_eq!([c.yaw, c.pitch, c.fov_y], [-171.5_f32, 90.0, 60.0].map(f32::to_radians));
        assert_eq!((c.distance, c.target), (0.5, Vec3::new(-3.25, 0.0, 2.0)));
        for preset in CameraPreset::ALL {
            assert_eq!(read(preset.name()), preset.camera());
        }
        let side = read("side, distance=9");
        assert!(side.distance == 9.0 && side.yaw > 1.5);
    }

    #[test]
    fn says_what_is_wrong() {
        let error = |text: &str| text.parse::<OrbitCamera>().err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error("frnt").contains("three-quarter"));
        assert!(error("roll=3").contains("`roll` is no setting"));
        assert!(error("yaw=x").contains("yaw=x is not a number"));
        assert!(error("distance=0").contains("0.15 to 2000 m"));
        assert!(error("target=1:2").contains("x:y:z"));
        assert!(error("target=1:2:b:3").contains("x:y:z"));
        assert!(!error("").is_empty());
    }
}
