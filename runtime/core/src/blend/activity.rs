//! Activities: what bodies do when they stand, such as waving, shaking hands or sitting down.

use super::{BlendedPosture, channel};
use crate::format::{ActivityMeta, ClipRecord, Table};
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use crate::{body::ClipRows, contacts::Contacts, hits::striking_offset, planar::Planar};
use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use throng_base::maths::{self, nlerp};
use throng_base::{Error, Result};

/// Number of an activity in its [`ActivitySet`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ActivityId(pub u32);

/// Frames of a bundle that begin and end standing.
#[derive(Clone, Debug, PartialEq)]
pub struct Activity {
    /// Unique name.
    pub name: String,
    /// Tag by which the activity is requested; several activities may share one.
    pub tag: String,
    /// First row in [`crate::Bundle::frames`].
    pub first_frame: usize,
    /// Number of frames (>= 2).
    pub num_frames: usize,
    /// Length (s).
    pub duration_s: f32,
    /// Begin and end of the part that goes on until the activity is to end (s).
    pub looped_s: Option<[f32; 2]>,
    /// Interval in which the left and the right hand hold an object; infinite end where it stays in the hand (s).
    pub held_s: [Option<[f32; 2]>; 2],
    /// The body sits in the middle of it: it stands up before it walks away.
    pub is_seated: bool,
}

impl Activity {
    /// Activity of a clip with some frames a second (Hz).
    pub(crate) fn new(a: &ActivityMeta, clip: &ClipRecord, rate_hz: f32) -> Self {
        let seconds = |frames: u32| frames as f32 / rate_hz;
        let held = |[first, count]: [u32; 2]| {
            let stays = first + count == a.num_frames;
            [seconds(first), if stays { f32::INFINITY } else { seconds(first + count) }]
        };
        Self {
            name: a.name.clone(),
            tag: a.tag.clone(),
            first_frame: (clip.first_frame + a.first_frame) as usize,
            num_frames: a.num_frames as usize,
            duration_s: seconds(a.num_frames - 1),
            looped_s: a.looped.map(|[first, count]| [seconds(first), seconds(first + count)]),
            held_s: a.object_frames.map(|h| h.map(held)),
            is_seated: a.is_seated,
        }
    }
}

/// The activities of a bundle. A clone is cheap and keeps the bundle's file open.
#[derive(Clone, Debug, Default)]
pub struct ActivitySet {
    pub(crate) activities: Arc<[Activity]>,
    pub(crate) contacts: Table<Contacts>,
    pub(crate) skeleton: Skeleton,
    pub(crate) rows: ClipRows,
}

/// A body of an activity at one instant, from where its root stood when the activity began.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActivitySample {
    /// The hips' in that frame, the others' relative to their parents.
    pub rotations: [Quat; NUM_JOINTS],
    /// (m)
    pub hips: Vec3,
    /// Left and right foot: 1 on the ground.
    pub contacts: [f32; 2],
}

/// Position of an arm (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmPlaces {
    /// Upper end of the arm.
    pub shoulder: Vec3,
    /// Lower end of the arm.
    pub wrist: Vec3,
    /// Beyond the wrist along the forearm.
    pub palm: Vec3,
}

impl ActivitySet {
    /// All activities, by number.
    pub fn activities(&self) -> &[Activity] {
        &self.activities
    }

    /// Activity of an id.
    pub fn get(&self, id: ActivityId) -> Option<&Activity> {
        self.activities.get(id.0 as usize)
    }

    /// Ids of all activities with a tag.
    pub fn ids_of_tag<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = ActivityId> + 'a {
        (0..).map(ActivityId).zip(self.activities()).filter(move |(_, a)| a.tag == tag).map(|(id, _)| id)
    }

    /// Id of the activity of a name.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn find_activity(&self, name: &str) -> Result<ActivityId> {
        let found = (0..).map(ActivityId).zip(self.activities()).find(|(_, a)| a.name == name);
        let known = || self.activities().iter().map(|a| a.name.clone()).collect();
        found.map(|(id, _)| id).ok_or_else(|| Error::Unknown { what: "activity", name: name.into(), known: known() })
    }

    /// Position of an arm of a body at a time of an activity, relative to the root at the start of the activity.
    ///
    /// - `side`: 0 left, 1 right.
    pub fn arm_places_at(&self, activity: &Activity, side: usize, seconds: f32, body: &Skeleton) -> ArmPlaces {
        let sample = self.sample_activity(activity, seconds);
        let [scale, lift] = body.hips_over(&self.skeleton);
        let place = |mut joint: Joint, mut point: Vec3| {
            while let Some(parent) = joint.parent() {
                point = maths::rotate(sample.rotations[joint.index()], point) + body.offsets[joint.index()];
                joint = parent;
            }
            maths::rotate(sample.rotations[0], point) + sample.hips * scale + Vec3::Y * lift
        };
        let [shoulder, hand] = [[Joint::LeftUpperArm, Joint::LeftHand], [Joint::RightUpperArm, Joint::RightHand]][side];
        ArmPlaces {
            shoulder: place(shoulder, Vec3::ZERO),
            wrist: place(hand, Vec3::ZERO),
            palm: place(hand, striking_offset(body, hand)),
        }
    }

    /// The body of an activity at a time (s, clamped to it).
    pub(crate) fn sample_activity(&self, activity: &Activity, seconds: f32) -> ActivitySample {
        let last = activity.num_frames - 1;
        let at = (seconds * self.rows.rate_hz).clamp(0.0, last as f32);
        let (first, frame) = (activity.first_frame, (at as usize).min(last - 1));
        let ratio = at - frame as f32;
        let rows = [first + frame, first + frame + 1];
        let [a, b] = rows.map(|r| &self.rows.frames[r]);
        let mix = |a: f32, b: f32| a + (b - a) * ratio;
        let root = Planar::from_array(std::array::from_fn(|k| mix(a.planar[k], b.planar[k])));
        let root = Planar::from_array(self.rows.frames[first].planar).to_local(root);
        let code = &self.rows.code[0];
        let mut rotations: [Quat; NUM_JOINTS] =
            std::array::from_fn(|j| nlerp(code.rotation(a, j), code.rotation(b, j), ratio));
        rotations[0] = maths::compose(maths::rotation_y(root.heading), rotations[0]);
        let down = |row: usize, foot| f32::from(u8::from(self.contacts[row].any(foot)));
        let contacts = [Contacts::LEFT, Contacts::RIGHT].map(|foot| mix(down(rows[0], foot), down(rows[1], foot)));
        ActivitySample { rotations, hips: Vec3::new(root.x, mix(a.height, b.height), root.z), contacts }
    }

    /// Blends a sample of an activity into a posture.
    ///
    /// - `share`: weight of the sample (0 to 1).
    pub(crate) fn overlay_sample(&self, sample: &ActivitySample, share: f32, posture: &mut BlendedPosture) {
        for (j, rotation) in sample.rotations.iter().enumerate() {
            posture.set_rotation(j, nlerp(posture.rotation(Joint::ALL[j]), *rotation, share));
        }
        let mut mix = |channel: usize, to: f32| {
            let value = &mut posture.channels[channel - channel::HIPS];
            *value += (to - *value) * share;
        };
        let left = self.ankle_from_hips(sample, [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot]);
        let right = self.ankle_from_hips(sample, [Joint::RightThigh, Joint::RightShin, Joint::RightFoot]);
        for (at, v) in [(channel::HIPS, sample.hips), (channel::LEFT_ANKLE, left), (channel::RIGHT_ANKLE, right)] {
            (at..).zip(v.to_array()).for_each(|(at, v)| mix(at, v));
        }
        mix(channel::LEFT_CONTACT, sample.contacts[0]);
        mix(channel::RIGHT_CONTACT, sample.contacts[1]);
        mix(channel::LEFT_TOUCH, 0.0);
        mix(channel::RIGHT_TOUCH, 0.0);
    }

    /// An ankle as seen from the hips (m).
    fn ankle_from_hips(&self, sample: &ActivitySample, leg: [Joint; 3]) -> Vec3 {
        let step = |(at, q): (Vec3, Quat), j: Joint| {
            (at + maths::rotate(q, self.skeleton.offsets[j.index()]), maths::compose(q, sample.rotations[j.index()]))
        };
        leg.into_iter().fold((Vec3::ZERO, sample.rotations[0]), step).0
    }
}

impl ActivitySample {
    /// Interpolation between this sample and another one.
    ///
    /// - `share`: weight of the other sample (0 to 1).
    pub fn mix(&self, other: &Self, share: f32) -> Self {
        let contact = |side: usize| self.contacts[side] + (other.contacts[side] - self.contacts[side]) * share;
        Self {
            rotations: std::array::from_fn(|j| nlerp(self.rotations[j], other.rotations[j], share)),
            hips: self.hips.lerp(other.hips, share),
            contacts: [contact(0), contact(1)],
        }
    }
}
