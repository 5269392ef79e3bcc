//! Blend request: a point of a blend space, and a body.

use throng_base::thresholds::WALK_SPEED_MPS;
use throng_core::blend::{BlendSpace, MAX_AXES, axis};

/// Sizes that a body may have (size of the database skeleton).
pub const SIZES: [f32; 2] = [0.7, 1.2];
/// Lengths of legs over that, as factors.
pub const LEGS: [f32; 2] = [0.85, 1.15];

/// Characters walking beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BlendCompanions {
    /// No companion.
    #[default]
    None,
    /// One companion: the same body with the other choice of retargeting.
    Retargeting,
    /// The smallest and the largest body.
    Sizes,
}

/// Blend request: a point of a blend space, and a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blending {
    /// Number of the blend space.
    pub space: usize,
    /// Point of its parameter box, axis by axis.
    pub point: [f32; MAX_AXES],
    /// Size of the body (size of the database skeleton, SIZES).
    pub size: f32,
    /// Length of the legs relative to the size (LEGS).
    pub legs: f32,
    /// Feet are planted and limbs reach; otherwise the blended joint angles are used.
    pub retarget: bool,
    /// Characters walking beside it.
    pub companions: BlendCompanions,
}

impl Blending {
    /// A walk straight ahead in a space, on the database skeleton.
    pub fn straight_walk(space: usize, blend: &BlendSpace) -> Self {
        let mut point = [0.0; MAX_AXES];
        for (p, axis) in point.iter_mut().zip(blend.axes()) {
            let wanted = if axis.kind == axis::SPEED { WALK_SPEED_MPS } else { 0.0 };
            *p = wanted.clamp(axis.low, axis.high);
        }
        Self { space, point, size: 1.0, legs: 1.0, retarget: true, companions: BlendCompanions::None }
    }

    /// The nearest one that can be shown (space < number of spaces).
    pub(super) fn limited(mut self, blend: &BlendSpace) -> Self {
        for (p, axis) in self.point.iter_mut().zip(blend.axes()) {
            *p = if *p > axis.low { p.min(axis.high) } else { axis.low };
        }
        let within = |v: f32, [low, high]: [f32; 2]| if v.is_finite() { v.clamp(low, high) } else { 1.0 };
        (self.size, self.legs) = (within(self.size, SIZES), within(self.legs, LEGS));
        self
    }

    /// All that walk: size, legs, retargeted; the selected one first.
    pub(super) fn people(&self) -> Vec<(f32, f32, bool)> {
        let own = (self.size, self.legs, self.retarget);
        match self.companions {
            BlendCompanions::None => vec![own],
            BlendCompanions::Retargeting => vec![own, (self.size, self.legs, !self.retarget)],
            BlendCompanions::Sizes => {
                vec![own, (SIZES[0], self.legs, self.retarget), (SIZES[1], self.legs, self.retarget)]
            }
        }
    }

    pub(super) fn has_same_people(&self, other: &Self) -> bool {
        self.space == other.space && self.people() == other.people()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::OpenBundle;
    use crate::fixtures::paces::Paces;

    #[test]
    fn values_out_of_range_are_limited() {
        let paces = Paces::new();
        let bundle = OpenBundle::open(&paces.bundle()).unwrap();
        let space = &bundle.blends[0];
        let [speed, turning] = [0, 1].map(|a| space.axes()[a]);
        let good = Blending::straight_walk(0, space);
        assert_eq!(good.limited(space), good);
        let mut wild = Blending { size: f32::NAN, legs: 9.0, ..good };
        (wild.point[0], wild.point[1]) = (f32::INFINITY, f32::NAN);
        let limited = wild.limited(space);
        assert_eq!((limited.size, limited.legs), (1.0, LEGS[1]));
        assert_eq!(limited.point[..2], [speed.high, turning.low]);
    }
}
