//! Active region of a behaviour.

use super::maths::angle_of;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::f32::consts::PI;
use throng_base::{Result, error::check_value};

/// Targets for which a behaviour is active, in the character's frame; for others its weight is 0 (Lee and Lee 2004,
/// section 6: the punch behaviour is activated only when the target is in the bounding box of effective hitting
/// points).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RegionRecord {
    /// Least and greatest distance over ground (m).
    pub distance: [f32; 2],
    /// Least and greatest angle from straight ahead (+Z) towards +X (rad, -pi to pi).
    pub angle: [f32; 2],
    /// Least and greatest height above ground, or time left in a space-time grid (m or s).
    pub height: [f32; 2],
}
const _: () = assert!(size_of::<RegionRecord>() == 24);

impl Default for RegionRecord {
    fn default() -> Self {
        Self::EVERYWHERE
    }
}

impl RegionRecord {
    /// Region that holds all targets.
    pub const EVERYWHERE: Self = Self { distance: [0.0, 1e6], angle: [-PI, PI], height: [-1e6, 1e6] };

    /// Checks the bounds.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for numbers that are not finite or bounds that do not ascend.
    pub fn check(&self) -> Result<()> {
        for (what, [low, high]) in
            [("region distance", self.distance), ("region angle", self.angle), ("region height", self.height)]
        {
            let good = low <= high && low >= -1e6 && high <= 1e6;
            check_value(what, None, low, good, "ascending bounds within 1e6")?;
        }
        Ok(())
    }

    /// True if the region contains a target.
    #[inline]
    pub fn contains(&self, target: Vec3) -> bool {
        let within = |v: f32, [low, high]: [f32; 2]| v >= low && v <= high;
        let distance = (target.x * target.x + target.z * target.z).sqrt();
        // The polynomial may exceed pi by a few millionths.
        let angle = angle_of(target.x, target.z).clamp(-PI, PI);
        within(distance, self.distance) && within(target.y, self.height) && within(angle, self.angle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contains_targets_within_all_bounds() {
        let r = RegionRecord { distance: [0.3, 1.3], angle: [-1.0, 0.5], height: [1.2, 1.7] };
        assert!(r.check().is_ok() && r.contains(Vec3::new(0.0, 1.5, 1.0)));
        for outside in
            [(0.0, 1.5, 1.4), (0.0, 1.1, 1.0), (0.0, 1.8, 1.0), (0.8, 1.5, 0.8), (-1.0, 1.5, 0.2), (0.0, 1.5, 0.1)]
        {
            assert!(!r.contains(outside.into()), "{outside:?}");
        }
        for x in [-1e5, -1.0, 0.0, 1e-9, 3.0] {
            assert!(RegionRecord::EVERYWHERE.contains(Vec3::new(x, -5.0, -1e3)));
        }
        assert!(RegionRecord { height: [2.0, 1.0], ..r }.check().is_err());
        assert!(RegionRecord { angle: [f32::NAN, 1.0], ..r }.check().is_err());
    }
}
