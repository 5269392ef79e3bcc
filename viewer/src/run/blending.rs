//! What is blended, and on what body.

use throng_runtime::blend::{BlendSpace, MAX_AXES, axis};

/// Sizes that a body may have. [Unit: size of the database skeleton]
pub const SIZES: [f32; 2] = [0.7, 1.2];
/// Lengths of legs over that, as factors.
pub const LEGS: [f32; 2] = [0.85, 1.15];

/// Speed that a walk begins with. [Unit: m/s]
const BEGIN_MPS: f32 = 1.3;

/// Who walks beside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Beside {
    /// Nobody.
    #[default]
    Nobody,
    /// The same body with the other choice of retargeting.
    Retargeting,
    /// The smallest and the largest body.
    Sizes,
}

/// What is blended, and on what body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blending {
    /// Number of the blend space.
    pub space: usize,
    /// Point of its parameter box, axis by axis.
    pub point: [f32; MAX_AXES],
    /// Size of the body. [Unit: size of the database skeleton] [Limit: SIZES]
    pub size: f32,
    /// Length of its legs over that. [Limit: LEGS]
    pub legs: f32,
    /// Feet are planted and limbs reach; else the joint angles are taken as they are blended.
    pub retarget: bool,
    /// Who walks beside.
    pub beside: Beside,
}

impl Blending {
    /// A walk straight ahead in a space, on the database skeleton.
    pub fn of(space: usize, blend: &BlendSpace<'_>) -> Self {
        let mut point = [0.0; MAX_AXES];
        for (p, axis) in point.iter_mut().zip(blend.axes()) {
            let wanted = if axis.kind == axis::SPEED { BEGIN_MPS } else { 0.0 };
            *p = wanted.clamp(axis.low, axis.high);
        }
        Self { space, point, size: 1.0, legs: 1.0, retarget: true, beside: Beside::Nobody }
    }

    /// The nearest one that can be shown. [Limit: space < number of spaces]
    pub(super) fn limited(mut self, blend: &BlendSpace<'_>) -> Self {
        for (p, axis) in self.point.iter_mut().zip(blend.axes()) {
            *p = if *p > axis.low { p.min(axis.high) } else { axis.low };
        }
        let within = |v: f32, [low, high]: [f32; 2]| if v.is_finite() { v.clamp(low, high) } else { 1.0 };
        (self.size, self.legs) = (within(self.size, SIZES), within(self.legs, LEGS));
        self
    }

    /// Everybody who walks: size, legs, retargeted; the one that is looked at first.
    pub(super) fn people(&self) -> Vec<(f32, f32, bool)> {
        let own = (self.size, self.legs, self.retarget);
        match self.beside {
            Beside::Nobody => vec![own],
            Beside::Retargeting => vec![own, (self.size, self.legs, !self.retarget)],
            Beside::Sizes => {
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
    use crate::document::Bundle;
    use crate::panels::tests::paces::Paces;

    #[test]
    fn what_is_out_of_range_is_limited() {
        let paces = Paces::new();
        let bundle = Bundle::open(&paces.bundle()).unwrap();
        let space = &bundle.blends()[0];
        let [speed, turning] = [0, 1].map(|a| space.axes()[a]);
        let good = Blending::of(0, space);
        assert_eq!(good.limited(space), good);
        let mut wild = Blending { size: f32::NAN, legs: 9.0, ..good };
        (wild.point[0], wild.point[1]) = (f32::INFINITY, f32::NAN);
        let limited = wild.limited(space);
        assert_eq!((limited.size, limited.legs), (1.0, LEGS[1]));
        assert_eq!(limited.point[..2], [speed.high, turning.low]);
    }
}
