//! A path walked in several styles, for pictures.

use super::report::config_error;
use glam::{Vec2, Vec3};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{CharacterGroup, Inline, NUM_JOINTS};
use throng_motion::error::Result;
use throng_simulation::{CompiledScene, scene::PictureStyle};

/// Time of a step (s).
const DT_S: f32 = 1.0 / 120.0;
/// Distance walked before the path begins, so that the gait is steady (m).
const RUN_UP_M: f32 = 4.0;

/// One style on the shown path.
#[derive(Clone, Debug)]
pub struct StyleWalk {
    /// Name of the style, with its speed.
    pub name: String,
    /// World positions of all joints at each moment (m).
    pub poses: Vec<[Vec3; NUM_JOINTS]>,
}

/// Walks a path in every style that the picture of a scene shows.
///
/// - `length_m`: length of the path (m).
/// - `apart_m`: distance along the path between recorded moments (m).
///
/// # Errors
/// [`throng_motion::error::BuildError::Config`] for a blend space that the bundle does not have.
pub fn walk_styles(scene: &CompiledScene, length_m: f32, apart_m: f32) -> Result<Vec<StyleWalk>> {
    let groups = &scene.scene().groups;
    let Some(bundle) = groups.iter().position(|g| !g.spaces.is_empty()).and_then(|g| scene.find_bundle(g)) else {
        return Ok(Vec::new());
    };
    let walk = |(i, style): (usize, &PictureStyle)| {
        let key = format!("picture.shown[{i}]");
        let wrong = |key: &str, e: throng_core::Error| config_error(scene.scene().fault(key, e));
        let space = bundle.blend(&style.space).map_err(|e| wrong(&format!("{key}.space"), e))?;
        let control = |along: f32| {
            let (position, heading) = if along < 0.0 { (Vec2::new(0.0, along), 0.0) } else { style_path(along) };
            let mut values = Control::default().style;
            values[0] = style.style;
            let velocity = Vec2::new(heading.sin(), heading.cos()) * style.speed;
            let (position, heading) = (Some(position), Some(heading));
            Control { position, velocity, heading, style: values, ..Control::default() }
        };
        let wrong = |e: throng_core::Error| wrong(&key, e);
        let mut walkers = Walkers::with_capacity(space, &[], WalkersConfig::default(), 1).map_err(wrong)?;
        let id = walkers.spawn(WalkerStart::default()).map_err(wrong)?;
        let (mut along, mut poses) = (-RUN_UP_M, Vec::new());
        while along < length_m {
            walkers.order(id, control(along)).and_then(|()| walkers.step(DT_S, &Inline)).map_err(wrong)?;
            if along >= poses.len() as f32 * apart_m {
                poses.push(walkers.joint_positions(0));
            }
            along += style.speed * DT_S;
        }
        Ok(StyleWalk { name: format!("{}, {:.1} m/s", style.name, style.speed), poses })
    };
    scene.scene().picture.shown.iter().enumerate().map(walk).collect()
}

/// The path that styles are shown on: straight, a turn to the left, one to the right, straight.
///
/// - `along`: distance along the path (m).
/// - returns position and heading (m, rad).
pub fn style_path(along: f32) -> (Vec2, f32) {
    const STEP_M: f32 = 0.02;
    let (mut at, mut heading) = (Vec2::ZERO, 0.0f32);
    let steps = (along / STEP_M).max(0.0);
    for i in 0..steps.ceil() as usize {
        let step = STEP_M * (steps - i as f32).min(1.0);
        let bend = match i as f32 * STEP_M {
            s if s < 2.0 => 0.0,
            s if s < 5.0 => 0.25,
            s if s < 11.0 => -0.25,
            s if s < 14.0 => 0.25,
            _ => 0.0,
        };
        heading += bend * step;
        at += Vec2::new(heading.sin(), heading.cos()) * step;
    }
    (at, heading)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_ends_in_the_direction_it_began_with() {
        let (at, heading) = style_path(16.0);
        assert!(heading.abs() < 1e-3 && at.y > 10.0, "{at} {heading}");
        assert_eq!(style_path(0.0), (Vec2::ZERO, 0.0));
        assert!((style_path(1.01).0.y - 1.01).abs() < 1e-5);
    }
}
