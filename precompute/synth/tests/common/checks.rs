//! Assertions shared by the tests of all sets, and data files that the rigs must agree with.

use glam::{Quat, Vec3};
use serde::Deserialize;
use std::ops::Range;
use throng_core::{Contacts, Joint, NUM_JOINTS};
use throng_motion::clip::{Clip, ClipSet};

/// Shin, foot and toe of each leg, and the contacts of heel and toe.
pub const FEET: [(Joint, Joint, Joint, Contacts, Contacts); 2] = [
    (Joint::LeftShin, Joint::LeftFoot, Joint::LeftToe, Contacts::LEFT_HEEL, Contacts::LEFT_TOE),
    (Joint::RightShin, Joint::RightFoot, Joint::RightToe, Contacts::RIGHT_HEEL, Contacts::RIGHT_TOE),
];

/// World positions of the joints of every frame (m).
pub fn positions(set: &ClipSet, clip: &Clip) -> Vec<[Vec3; NUM_JOINTS]> {
    (0..clip.num_frames()).map(|f| clip.joint_positions(&set.skeleton, f)).collect()
}

/// Asserts that planted heels and toes move slower than `most` (m/s).
pub fn assert_planted_feet_stand_still(set: &ClipSet, most: f32) {
    for clip in &set.clips {
        let (at, rate) = (positions(set, clip), clip.rate_hz as f32);
        for (_, foot, toe, heel_bit, toe_bit) in FEET {
            for (joint, bit) in [(foot, heel_bit), (toe, toe_bit)] {
                for f in 1..clip.num_frames() {
                    if clip.contacts[f].any(bit) && clip.contacts[f - 1].any(bit) {
                        let speed = at[f][joint.index()].distance(at[f - 1][joint.index()]) * rate;
                        assert!(speed < most, "{} frame {f} {}: {speed} m/s", clip.name, joint.name());
                    }
                }
            }
        }
    }
}

/// Asserts that knees only bend, and within a range (deg).
pub fn assert_knees_bend(clip: &Clip, range: &Range<f32>) {
    for f in 0..clip.num_frames() {
        for (shin, ..) in FEET {
            let q = clip.frame_rotations(f)[shin.index()];
            assert!(q.y.abs() < 1e-5 && q.z.abs() < 1e-5);
            let flexion = (2.0 * q.x.atan2(q.w)).to_degrees();
            assert!(range.contains(&flexion), "{} frame {f} {}: {flexion}", clip.name, shin.name());
        }
    }
}

/// Asserts that elbows bend within a range (deg), with forearms near the plane of the bend (m of 1 m).
pub fn assert_elbows_bend(clip: &Clip, range: &Range<f32>, most_aside: f32) {
    for f in 0..clip.num_frames() {
        for (forearm, along) in [(Joint::LeftForearm, Vec3::X), (Joint::RightForearm, Vec3::NEG_X)] {
            let bent = clip.frame_rotations(f)[forearm.index()] * along;
            assert!(bent.y.abs() < most_aside);
            let flexion = bent.z.atan2(bent.dot(along)).to_degrees();
            assert!(range.contains(&flexion), "{} frame {f} {}: {flexion}", clip.name, forearm.name());
        }
    }
}

/// Asserts that heels and tips of the feet are nowhere lower than `least` (m).
pub fn assert_soles_stay_above(set: &ClipSet, least: f32) {
    let rest = set.skeleton.rest_positions();
    for clip in &set.clips {
        for f in 0..clip.num_frames() {
            let t = clip.joint_transforms(&set.skeleton, f);
            for (_, foot, toe, ..) in FEET {
                let heel = Vec3::new(0.0, -rest[foot.index()].y, -0.045);
                let tip = Vec3::new(0.0, -rest[toe.index()].y, 0.07);
                for (joint, point) in [(foot, heel), (toe, tip)] {
                    let y = (t[joint.index()].0 + t[joint.index()].1 * point).y;
                    assert!(y > least, "{} frame {f} {}: {y}", clip.name, joint.name());
                }
            }
        }
    }
}

/// Asserts that no joint accelerates, relative to its parent, by `most` or more (rad/s^2).
pub fn assert_nothing_pops(clip: &Clip, most: impl Fn(Joint) -> f32) {
    let rate = clip.rate_hz as f32;
    let velocity = |from: Quat, to: Quat| (from.inverse() * to).to_scaled_axis() * rate;
    for f in 2..clip.num_frames() {
        let [a, b, c] = [f - 2, f - 1, f].map(|f| clip.frame_rotations(f));
        for j in Joint::ALL {
            let i = j.index();
            let acceleration = ((velocity(b[i], c[i]) - velocity(a[i], b[i])) * rate).length();
            assert!(acceleration < most(j), "{} frame {f} {}: {acceleration} rad/s^2", clip.name, j.name());
        }
    }
}

/// A file of unit objects, as far as the tests need it.
#[derive(Deserialize)]
pub struct UnitFile {
    pub units: Vec<CheckUnit>,
}

#[derive(Deserialize)]
pub struct CheckUnit {
    pub name: String,
    #[serde(default)]
    pub shapes: Vec<CheckShape>,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CheckShape {
    Box {
        at: [f32; 3],
        size: [f32; 3],
        #[serde(default)]
        heading_deg: f32,
        #[serde(default)]
        pitch_deg: f32,
    },
    Bar {
        from: [f32; 3],
        to: [f32; 3],
        radius: f32,
    },
}

/// An environment file, as far as the tests need it.
#[derive(Deserialize)]
pub struct CheckEnvironmentFile {
    pub place: Vec<CheckPlace>,
}

#[derive(Deserialize)]
pub struct CheckPlace {
    pub unit: String,
    pub at: [f32; 3],
    #[serde(default)]
    pub heading_deg: f32,
    #[serde(default = "single_count")]
    pub repeat: [u32; 3],
}

fn single_count() -> [u32; 3] {
    [1; 3]
}

/// Reads a file of the project's data folder.
pub fn data<T: serde::de::DeserializeOwned>(file: &str) -> T {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(file);
    let text = std::fs::read_to_string(&path).expect("a file of the project");
    toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}
