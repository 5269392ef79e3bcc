//! How far the actions of a behaviour may be bent.

use crate::policy::SegmentMotion;
use throng_base::thresholds::WALKING_MPS;
use throng_core::policy::MAX_BEND;

/// How far walked actions may be bent towards the target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BendLimit {
    /// Largest change of heading over a metre of the path, 0 to play motion as captured (rad/m).
    pub rad_per_m: f64,
    /// Frame rate of the database (Hz).
    pub rate_hz: f64,
}

/// Acceleration to the side beyond which a path is not bent, as people lean into sharper arcs (m/s2).
const SIDEWAYS_MPS2: f64 = 1.0;
/// Least share of a path that leads ahead.
const AHEAD: f64 = 0.9;

impl BendLimit {
    /// The `heights` of a [`throng_core::policy::SegmentRecord`] in a polar grid.
    ///
    /// Steps to the side, backwards and on the spot are played as captured.
    pub fn of_segment(self, motion: &SegmentMotion) -> [f32; 2] {
        let path_m: f64 = motion.path.windows(2).map(|w| f64::from((w[1].x - w[0].x).hypot(w[1].z - w[0].z))).sum();
        let speed_mps = path_m * self.rate_hz / f64::from(motion.num_frames);
        let walks = f64::from(motion.displacement.z) >= AHEAD * path_m && speed_mps > f64::from(WALKING_MPS);
        if self.rad_per_m == 0.0 || !walks {
            return [0.0; 2];
        }
        let turn = path_m * self.rad_per_m.min(SIDEWAYS_MPS2 / (speed_mps * speed_mps));
        [turn.min(f64::from(MAX_BEND).atan()).tan() as f32, path_m.recip() as f32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Planar;

    #[test]
    fn steps_ahead_are_bent_and_runs_less_than_walks() {
        let limit = BendLimit { rad_per_m: 0.3, rate_hz: 30.0 };
        let of = |x: f32, z: f32, num_frames: u32| {
            let share = |f: u32| f as f32 / num_frames as f32;
            let path: Vec<Planar> = (0..=num_frames).map(|f| Planar::new(x * share(f), z * share(f), 0.0)).collect();
            limit.of_segment(&SegmentMotion { end: 0, num_frames, displacement: path[num_frames as usize], path })
        };
        let [most, per_m] = of(0.0, 0.7, 15);
        assert!((most - (0.3f32 * 0.7).tan()).abs() < 1e-5 && (per_m - 1.0 / 0.7).abs() < 1e-5, "{most} {per_m}");
        // 3 m/s: 1 m/s2 to the side is an arc of 9 m.
        assert!((of(0.0, 1.5, 15)[0] - (1.5f32 / 9.0).tan()).abs() < 1e-5);
        for (x, z) in [(0.7, 0.0), (0.0, -0.7), (0.5, 0.5), (0.0, 0.02)] {
            assert_eq!(of(x, z, 15), [0.0; 2], "{x} {z}");
        }
        let unbent = BendLimit { rad_per_m: 0.0, ..limit };
        let path = vec![Planar::IDENTITY, Planar::new(0.0, 0.04, 0.0)];
        let motion = SegmentMotion { end: 0, num_frames: 1, displacement: path[1], path };
        assert_eq!(unbent.of_segment(&motion), [0.0; 2]);
    }
}
