//! Limits as files: `*.limits.toml`.

use super::joint::{AngleInterval, JointLimits, MAX_SWING, SwingLimit};
use crate::linkage::{LIMB_JOINTS, Limb};
use crate::rotation::exp;
use glam::{DQuat, DVec3};
use serde::Deserialize;
use std::{collections::BTreeMap, path::Path};
use throng_base::text::{TomlSource, did_you_mean};
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// Error of a limits file: [`throng_base::Error::Text`] with file, line and column, or the reason why it was not read.
pub type LimitsError = throng_base::Error;

const HELP: &str = "See data/skeletons/README.md for how limits are written.";
const BUILT_IN: &str = include_str!("../../../../data/skeletons/throng.limits.toml");

/// Greatest joint speed (degrees/s).
const MAX_SPEED_DPS: f64 = 10_000.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsFile {
    name: String,
    joints: BTreeMap<String, JointEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    kind: JointLimitKind,
    centre_deg: Option<[f64; 3]>,
    swing_deg: Option<[f64; 2]>,
    axis: Option<[f64; 3]>,
    flexion_deg: Option<[f64; 2]>,
    twist_deg: Option<[f64; 2]>,
    play_deg: Option<f64>,
    speed_dps: f64,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
enum JointLimitKind {
    SwingTwist,
    FlexionTwist,
    Swing,
}

/// Limits of the joints of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyLimits {
    /// Name in reports.
    pub name: String,
    /// Limits of each joint; `None` for joints that are never planned.
    pub joints: [Option<JointLimits>; NUM_JOINTS],
}

impl BodyLimits {
    /// The built-in limits of the database skeleton, for one of its proportions.
    ///
    /// # Panics
    /// Never: a test reads them.
    pub fn built_in(skeleton: &Skeleton) -> Self {
        Self::parse(BUILT_IN, Path::new("throng.limits.toml"), skeleton).expect("the built-in limits are read")
    }

    /// Reads a limits file.
    ///
    /// # Errors
    /// As [`BodyLimits::parse`], or why the file cannot be read.
    pub fn read(path: &Path, skeleton: &Skeleton) -> Result<Self, LimitsError> {
        Self::from_source(&TomlSource::read(path, "limits of joints")?, skeleton)
    }

    /// Reads limits from TOML text; `path` is what errors name.
    ///
    /// Each joint of the left side or of the middle once; the right side is the left one's mirror image. Twist is about the
    /// skeleton's own segments.
    ///
    /// # Errors
    /// With file and line: unknown joints and keys, missing keys, numbers that are not finite or out of range.
    pub fn parse(toml_text: &str, path: &Path, skeleton: &Skeleton) -> Result<Self, LimitsError> {
        Self::from_source(&TomlSource::new(toml_text, path), skeleton)
    }

    fn from_source(source: &TomlSource, skeleton: &Skeleton) -> Result<Self, LimitsError> {
        let file: LimitsFile = source.parse(HELP)?;
        let mut joints = [None; NUM_JOINTS];
        for (name, entry) in &file.joints {
            let fail = |key: &str, why: String| {
                source.error_at_key(&format!("joints.{name}{key}"), format!("{name}: {why}. {HELP}"))
            };
            let Some(joint) = Joint::from_name(name) else {
                let meant = did_you_mean(name, Joint::ALL.into_iter().map(Joint::name));
                return Err(fail("", format!("there is no such joint.{meant}")));
            };
            if name.starts_with("right") {
                return Err(fail("", "say it of the left side; the right one is its mirror image".into()));
            }
            for side in [joint, joint.mirrored()] {
                let limits = entry.limits(side, skeleton).map_err(|(key, why)| fail(&format!(".{key}"), why))?;
                joints[side.index()] = Some(limits);
            }
        }
        Ok(Self { name: file.name, joints })
    }

    /// The limits of a limb's joints, from the trunk outwards; the last one's repeated behind it. `None` where one of
    /// them has none.
    pub fn limb_limits(&self, limb: Limb) -> Option<[JointLimits; LIMB_JOINTS]> {
        let [a, b, c] = limb.joints().map(|joint| self.joints[joint.index()]);
        Some([a?, b?, c?])
    }
}

/// Direction of the segment behind a joint, at rest; for a swing, which has no segment behind it, that of the segment before
/// it.
fn segment_direction(joint: Joint, kind: JointLimitKind, skeleton: &Skeleton) -> Option<DVec3> {
    let main_child = match joint {
        Joint::UpperChest => Some(Joint::Neck),
        _ => Joint::ALL.into_iter().find(|c| c.parent() == Some(joint)),
    };
    let end = if kind == JointLimitKind::Swing { Some(joint) } else { main_child };
    end.map(|j| skeleton.offsets[j.index()].as_dvec3()).and_then(DVec3::try_normalize)
}

type Fault = (&'static str, String);

impl JointEntry {
    fn limits(&self, joint: Joint, skeleton: &Skeleton) -> Result<JointLimits, Fault> {
        let kind = ("kind", "the skeleton has no segment to turn there".to_owned());
        let mirrored = joint.name().starts_with("right");
        let bone = segment_direction(joint, self.kind, skeleton).ok_or(kind)?;
        let bone = if mirrored { bone.with_x(-bone.x) } else { bone };
        let axes = match self.kind {
            JointLimitKind::FlexionTwist => {
                let axis = DVec3::from(self.axis.ok_or(("", "a hinge needs `axis`".into()))?);
                let across = (axis - bone * axis.dot(bone)).try_normalize().filter(|_| axis.is_finite());
                let across = across.ok_or(("axis", "expected a direction that is not along the segment".to_owned()))?;
                [across, bone.cross(across)]
            }
            JointLimitKind::SwingTwist | JointLimitKind::Swing => perpendicular_axes(bone),
        };
        let twist = match (self.kind, self.twist_deg) {
            (JointLimitKind::Swing, None) => AngleInterval::around_zero(self.play()?),
            (JointLimitKind::Swing, Some(_)) => return Err(("twist_deg", "a swing has none; say `play_deg`".into())),
            (_, Some([least, most])) => interval("twist_deg", least, most, 179.0)?,
            (_, None) => return Err(("", "expected `twist_deg`".into())),
        };
        let (centre, swing) = (self.centre()?, self.swing()?);
        let speed = in_range("speed_dps", self.speed_dps, 1.0, MAX_SPEED_DPS)?.to_radians();
        let limits = JointLimits { centre, segment: bone, axes, swing, twist, speed, mirrored };
        let (is_wide, most) = (limits.widest_swing() > MAX_SWING, MAX_SWING.to_degrees().floor());
        refuse("", is_wide, format_args!("expected a swing of at most {most} degrees, found more"))?;
        Ok(limits)
    }

    fn centre(&self) -> Result<DQuat, Fault> {
        let v = DVec3::from(self.centre_deg.unwrap_or_default());
        let is_wrong = !v.is_finite() || v.length() > 180.0;
        refuse("centre_deg", is_wrong, format_args!("expected a rotation vector of at most 180 degrees"))?;
        Ok(exp(v * (std::f64::consts::PI / 180.0)))
    }

    fn swing(&self) -> Result<SwingLimit, Fault> {
        if self.kind == JointLimitKind::FlexionTwist {
            let swings = self.swing_deg.is_some() || self.centre_deg.is_some();
            refuse("", swings, format_args!("a hinge has `flexion_deg`, neither `swing_deg` nor `centre_deg`"))?;
            let [least, most] = self.flexion_deg.ok_or(("", "expected `flexion_deg`".into()))?;
            return Ok(SwingLimit::Hinge { flexion: interval("flexion_deg", least, most, 160.0)?, play: self.play()? });
        }
        let flexes = self.axis.is_some() || self.flexion_deg.is_some();
        refuse("", flexes, format_args!("only `flexion_twist` has `axis` and `flexion_deg`"))?;
        let radii = self.swing_deg.ok_or(("", "expected `swing_deg`, the two radii".into()))?;
        let [first, second] = radii.map(|r| in_range("swing_deg", r, 0.1, 160.0));
        Ok(SwingLimit::Ellipse([first?.to_radians(), second?.to_radians()]))
    }

    fn play(&self) -> Result<f64, Fault> {
        Ok(in_range("play_deg", self.play_deg.unwrap_or(0.0), 0.0, 45.0)?.to_radians())
    }
}

/// Two directions at right angles to a segment, near two of the model's axes, in the order of their letters.
fn perpendicular_axes(bone: DVec3) -> [DVec3; 2] {
    let along = bone.abs().max_position();
    let first = if along == 0 { DVec3::Y } else { DVec3::X };
    let first = (first - bone * first.dot(bone)).normalize();
    let second = bone.cross(first);
    let positive = if along == 2 { DVec3::Y } else { DVec3::Z };
    [first, if second.dot(positive) < 0.0 { -second } else { second }]
}

fn refuse(key: &'static str, is_wrong: bool, why: std::fmt::Arguments<'_>) -> Result<(), Fault> {
    crate::refuse(is_wrong, why).map_err(|why| (key, why))
}

fn in_range(key: &'static str, value: f64, least: f64, most: f64) -> Result<f64, Fault> {
    let is_outside = !(least..=most).contains(&value);
    refuse(key, is_outside, format_args!("expected {least} to {most}, found {value}")).map(|()| value)
}

fn interval(key: &'static str, least: f64, most: f64, widest: f64) -> Result<AngleInterval, Fault> {
    let (a, b) = (in_range(key, least, -widest, widest)?, in_range(key, most, -widest, widest)?);
    refuse(key, a > b, format_args!("expected the least angle first, found {least} before {most}"))?;
    Ok(AngleInterval::new(a.to_radians(), b.to_radians()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        BodyLimits::parse(text, Path::new("l.toml"), &Skeleton::default()).unwrap_err().to_string()
    }

    #[test]
    fn the_built_in_limits_have_every_joint_of_every_limb() {
        let limits = BodyLimits::built_in(&Skeleton::default());
        for limb in Limb::ALL {
            let of = limits.limb_limits(limb).expect("all joints");
            assert!(of.iter().all(|l| (l.segment.dot(l.axes[0])).abs() < 1e-9 && l.excess(DQuat::IDENTITY) <= 0.0));
        }
        assert_eq!(limits.joints[Joint::Head.index()], None);
    }

    #[test]
    fn axes_of_swings_are_across_the_segment() {
        assert_eq!(perpendicular_axes(DVec3::X), [DVec3::Y, DVec3::Z]);
        assert_eq!(perpendicular_axes(DVec3::NEG_Y), [DVec3::X, DVec3::Z]);
        assert_eq!(perpendicular_axes(DVec3::Z), [DVec3::X, DVec3::Y]);
    }

    #[test]
    fn faults_name_joint_line_and_way_out() {
        let joint = |body: &str| format!("name='a'\n[joints.left_forearm]\nspeed_dps=10.0\n{body}");
        let hinge = "kind='flexion_twist'\naxis=[0.0,-1.0,0.0]\nflexion_deg=[0.0,150.0]\ntwist_deg=[-9.0,9.0]\n";
        assert!(BodyLimits::parse(&joint(hinge), Path::new("l.toml"), &Skeleton::default()).is_ok());
        let cases = [
            (hinge.replace("[0.0,150.0]", "[0.0,nan]"), "l.toml:6", "expected -160 to 160, found NaN"),
            (hinge.replace("[-9.0,9.0]", "[9.0,-9.0]"), "l.toml:7", "least angle first"),
            (hinge.replace("[0.0,-1.0,0.0]", "[1.0,0.0,0.0]"), "l.toml:5", "not along the segment"),
            (hinge.replace("axis=[0.0,-1.0,0.0]\n", ""), "l.toml:2", "needs `axis`"),
            (hinge.replace("flexion_twist", "flexion"), "l.toml:4", "flexion_twist"),
            (format!("{hinge}swing_deg=[1.0,2.0]\n"), "l.toml:2", "neither `swing_deg`"),
            ("kind='swing'\n".into(), "l.toml:2", "expected `swing_deg`"),
            ("kind='swing'\nswing_deg=[1e9,2.0]\n".into(), "l.toml:5", "expected 0.1 to 160"),
        ];
        for (body, at, why) in cases {
            let e = error(&joint(&body));
            assert!(e.contains(at) && e.contains(why), "{at} {why}: {e}");
        }
        assert!(
            error("name='a'\n[joints.left_forarm]\nkind='swing'\nspeed_dps=1.0")
                .contains("Did you mean `left_forearm`?")
        );
        assert!(
            error("name='a'\n[joints.right_hand]\nkind='swing'\nspeed_dps=1.0").contains("say it of the left side")
        );
        assert!(error("name='a'\n[joints.head]\nkind='swing_twist'\nspeed_dps=1.0").contains("no segment to turn"));
    }

    proptest::proptest! {
        #[test]
        fn damaged_files_are_refused_or_hold_what_can_be_used(cut in 0usize..2600, with in "[\\[\\]=\\-0-9a-z.\"\n]{0,3}", skip in 0usize..6) {
            let bytes = BUILT_IN.len();
            let cut = cut % bytes;
            let after = (cut + skip).min(bytes);
            let text = format!("{}{with}{}", &BUILT_IN[..cut], &BUILT_IN[after..]);
            match BodyLimits::parse(&text, Path::new("l.toml"), &Skeleton::default()) {
                Ok(limits) => {
                    for l in limits.joints.iter().flatten() {
                        proptest::prop_assert!(l.stiffness().is_finite() && l.stiffness() > 0.0 && l.speed > 0.0);
                        proptest::prop_assert!(l.excess(DQuat::IDENTITY).is_finite());
                    }
                }
                Err(e) => proptest::prop_assert!(e.to_string().contains("l.toml:"), "{e}"),
            }
        }
    }
}
