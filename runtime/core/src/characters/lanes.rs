//! Moving one character from block to block.

use super::block::{BodyBlock, MotionBlock, Offsets};
use super::reaction::{Reaction, ReactionSpring};
use crate::contacts::Contacts;
use crate::pose::FootLock;
use throng_base::simd::LANES;

/// Data with a value for each of eight characters.
pub(super) trait Lanewise {
    /// Copies the value of one lane from another one.
    fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize);

    /// True where every number of a lane is finite and below 1e7.
    fn is_near(&self, lane: usize) -> bool;
}

macro_rules! values {
    ($is_near:expr, $($value:ty)+) => {$(
        impl Lanewise for [$value; LANES] {
            fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
                self[lane] = from[from_lane];
            }

            fn is_near(&self, lane: usize) -> bool {
                $is_near(self[lane])
            }
        }
    )+};
}

values!(|v: f32| v.abs() < 1e7, f32);
values!(|_| true, u32 u64 i16 Contacts);

impl<T: Lanewise, const N: usize> Lanewise for [T; N] {
    fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        self.iter_mut().zip(from).for_each(|(to, from)| to.copy_lane(lane, from, from_lane));
    }

    fn is_near(&self, lane: usize) -> bool {
        self.iter().all(|v| v.is_near(lane))
    }
}

/// The destructuring names every field, so that none can be forgotten.
macro_rules! fields {
    ($kind:ident { $($field:ident),+ }) => {
        impl Lanewise for $kind {
            fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
                let Self { $($field),+ } = self;
                $($field.copy_lane(lane, &from.$field, from_lane);)+
            }

            fn is_near(&self, lane: usize) -> bool {
                let Self { $($field),+ } = self;
                $($field.is_near(lane))&&+
            }
        }
    };
}

fields!(Offsets { rotation, rotation_velocity, root, root_velocity });
fields!(FootLock { correction, turn, ankle, toe, heel_down, toe_down });
fields!(ReactionSpring { place, velocity, force });
fields!(Reaction { active, trunk, head });
impl Lanewise for BodyBlock {
    fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        let Self { awake: _, unused: _, feet, offsets, reaction, fill: _ } = self;
        feet.copy_lane(lane, &from.feet, from_lane);
        offsets.copy_lane(lane, &from.offsets, from_lane);
        reaction.copy_lane(lane, &from.reaction, from_lane);
    }

    fn is_near(&self, lane: usize) -> bool {
        let Self { awake, unused: _, feet, offsets, reaction, fill: _ } = self;
        *awake <= 1 && feet.is_near(lane) && offsets.is_near(lane) && reaction.is_near(lane)
    }
}

fields!(MotionBlock {
    name,
    segment,
    first,
    length,
    time,
    clip_to_world,
    root,
    lift,
    drift,
    turn,
    drift_from,
    bend,
    pace,
    wait,
    blocked,
    age_s,
    num_choices,
    choice_state,
    choice_root,
    contacts,
    change
});
