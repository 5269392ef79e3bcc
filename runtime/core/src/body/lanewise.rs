//! Copying and checking one character's share of data that holds eight.

use super::{gaze::Gaze, upper::LayerState};
use crate::contacts::Contacts;
use throng_base::simd::LANES;

/// Data with a value for each of eight characters.
pub(crate) trait Lanewise {
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
values!(|gaze: Gaze| gaze.is_sound(), Gaze);
values!(|layers: LayerState| layers.is_sound(), LayerState);

impl<T: Lanewise, const N: usize> Lanewise for [T; N] {
    fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        self.iter_mut().zip(from).for_each(|(to, from)| to.copy_lane(lane, from, from_lane));
    }

    fn is_near(&self, lane: usize) -> bool {
        self.iter().all(|v| v.is_near(lane))
    }
}

/// Implements [`Lanewise`] field by field; fields after a semicolon hold an array of numbers for each lane. The
/// destructuring names every field, so that none can be forgotten. A function after `if` checks more of a lane.
macro_rules! lanewise_fields {
    ($kind:ident { $($field:ident),+ $(; $($row:ident),+)? } $(if $is_sound:ident)?) => {
        impl $crate::body::Lanewise for $kind {
            fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
                let Self { $($field,)+ $($($row),+)? } = self;
                $($field.copy_lane(lane, &from.$field, from_lane);)+
                $($($row[lane] = from.$row[from_lane];)+)?
            }

            fn is_near(&self, lane: usize) -> bool {
                let Self { $($field,)+ $($($row),+)? } = self;
                $($field.is_near(lane))&&+ $($(&& $row[lane].iter().all(|v| v.abs() < 1e7))+)? $(&& self.$is_sound(lane))?
            }
        }
    };
}
pub(crate) use lanewise_fields;
