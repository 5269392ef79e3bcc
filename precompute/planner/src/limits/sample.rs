//! Random poses within limits: bent elbows first, all of the range as the search goes on.

use super::joint::{AngleInterval, Coordinates, JointLimits, SwingLimit, ellipse_distance};
use crate::linkage::{LIMB_JOINTS, LimbPose};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Angles that the user wants, for each degree of freedom (rad); `None` leaves all of the limits.
///
/// # Source
/// Shapiro, Kallmann and Faloutsos 2007, section 4.2 and figure 2: low and high arms for one problem.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Style {
    /// About the first and the second axis of each joint of the limb.
    pub swing: [[Option<AngleInterval>; 2]; LIMB_JOINTS],
    /// Twist of each joint.
    pub twist: [Option<AngleInterval>; LIMB_JOINTS],
}

/// Share of their range from which elbows and knees are sampled at first: that nearest to full flexion.
const FLEXED: f64 = 0.1;
/// Share of their range from which wrists and ankles are sampled at first.
const NARROW: f64 = 0.5;

/// Draws poses of a limb.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSampler {
    limits: [JointLimits; LIMB_JOINTS],
    /// Swing around which the last joint is sampled.
    middle: [f64; 2],
    style: Style,
    widen_over: f64,
}

impl PoseSampler {
    /// The paper's heuristics: flexion of elbow and knee from 90 to 100 % of its range at first, wrist and ankle from half of
    /// theirs around the present pose, shoulder and hip from all of it.
    ///
    /// - `widen_over`: number of draws after which everything is sampled from its whole range (> 0).
    pub fn new(limits: [JointLimits; LIMB_JOINTS], present: &LimbPose, style: Style, widen_over: u32) -> Self {
        let middle = limits[2].coordinates(present.0[2]).swing;
        Self { limits, middle, style, widen_over: f64::from(widen_over.max(1)) }
    }

    /// A pose within limits.
    ///
    /// - `draw`: number of draws before: intervals widen with it.
    pub fn draw_pose(&self, rng: &mut Pcg64Mcg, draw: u32) -> LimbPose {
        let widened = (f64::from(draw) / self.widen_over).min(1.0);
        LimbPose(std::array::from_fn(|i| self.limits[i].rotation(self.coordinates(i, rng, widened))))
    }

    fn coordinates(&self, i: usize, rng: &mut Pcg64Mcg, widened: f64) -> Coordinates {
        let (limits, is_last) = (&self.limits[i], i + 1 == LIMB_JOINTS);
        let from = |least: f64| least + (1.0 - least) * widened;
        let wanted =
            |style: Option<AngleInterval>, whole: AngleInterval| style.map_or(whole, |s| s.intersection(whole));
        // Wrist and ankle only swing: the little twist that they have in clips is play.
        let twist = if is_last { 0.0 } else { draw_angle(rng, wanted(self.style.twist[i], limits.twist)) };
        let [first, second] = self.style.swing[i];
        let swing = match limits.swing {
            SwingLimit::Hinge { flexion, .. } => {
                let flexed = AngleInterval::new(flexion.angle_at(1.0 - from(FLEXED)), flexion.most);
                // Angles that the user wants come before those that look best.
                [draw_angle(rng, first.map_or(flexed, |s| s.intersection(flexion))), 0.0]
            }
            SwingLimit::Ellipse(radii) => {
                let box_of = |k: usize, style| {
                    let whole = AngleInterval::around_zero(radii[k]);
                    let half = 0.5 * from(NARROW) * whole.length();
                    let narrow = AngleInterval::new(self.middle[k] - half, self.middle[k] + half).intersection(whole);
                    wanted(style, if is_last { narrow } else { whole })
                };
                in_ellipse(rng, radii, [box_of(0, first), box_of(1, second)])
            }
        };
        Coordinates { swing, twist }
    }
}

/// Uniform sample of the intersection of an ellipse and a box; a point of the ellipse's rim behind one of the box where they
/// hardly meet.
fn in_ellipse(rng: &mut Pcg64Mcg, radii: [f64; 2], within: [AngleInterval; 2]) -> [f64; 2] {
    const TRIES: usize = 32;
    let mut point = [0.0; 2];
    for _ in 0..TRIES {
        point = within.map(|i| draw_angle(rng, i));
        if ellipse_distance(point, radii) <= 1.0 {
            return point;
        }
    }
    let far = ellipse_distance(point, radii);
    point.map(|x| x / far)
}

fn draw_angle(rng: &mut Pcg64Mcg, interval: AngleInterval) -> f64 {
    interval.angle_at(rng.random_range(0.0..1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::BodyLimits;
    use crate::linkage::Limb;
    use rand::SeedableRng;
    use throng_core::Skeleton;

    fn sampler(limb: Limb, style: Style) -> (PoseSampler, [JointLimits; LIMB_JOINTS]) {
        let limits = BodyLimits::built_in(&Skeleton::default()).limb_limits(limb).expect("limits");
        (PoseSampler::new(limits, &LimbPose::REST, style, 100), limits)
    }

    #[test]
    fn every_draw_is_within_limits() {
        for limb in Limb::ALL {
            let (s, limits) = sampler(limb, Style::default());
            let mut rng = Pcg64Mcg::seed_from_u64(1);
            for draw in 0..2000 {
                let pose = s.draw_pose(&mut rng, draw);
                for i in 0..LIMB_JOINTS {
                    assert!(limits[i].excess(pose.0[i]) < 1e-9, "{limb:?} {i}");
                }
            }
        }
    }

    #[test]
    fn elbows_are_bent_first_and_free_later() {
        let (s, limits) = sampler(Limb::LeftArm, Style::default());
        let mut rng = Pcg64Mcg::seed_from_u64(2);
        let most = 150f64.to_radians();
        let mut least = |draw: u32| {
            let flexion = (0..500).map(|_| limits[1].coordinates(s.draw_pose(&mut rng, draw).0[1]).swing[0]);
            flexion.fold(f64::INFINITY, f64::min)
        };
        assert!(least(0) >= 0.9 * most - 1e-9);
        assert!((0.4..0.46).contains(&(least(50) / most)));
        assert!(least(100) < 0.05 * most);
    }

    #[test]
    fn a_style_is_kept() {
        let mut style = Style::default();
        style.swing[0][1] = Some(AngleInterval::new(0.5, 1.0));
        style.swing[1][0] = Some(AngleInterval::new(0.2, 0.4));
        let (s, limits) = sampler(Limb::RightArm, style);
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        for draw in 0..500 {
            let pose = s.draw_pose(&mut rng, draw);
            assert!((0.5 - 1e-9..=1.0 + 1e-9).contains(&limits[0].coordinates(pose.0[0]).swing[1]));
            assert!((0.2 - 1e-9..=0.4 + 1e-9).contains(&limits[1].coordinates(pose.0[1]).swing[0]));
        }
    }

    #[test]
    fn samples_fill_an_ellipse_evenly() {
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let radii = [1.4, 0.7];
        let whole = radii.map(AngleInterval::around_zero);
        let inner = (0..20_000).filter(|_| {
            let [x, y] = in_ellipse(&mut rng, radii, whole);
            (x / 1.4).powi(2) + (y / 0.7).powi(2) < 0.25
        });
        // A quarter of the area.
        let share = inner.count() as f64 / 20_000.0;
        assert!((share - 0.25).abs() < 0.015, "{share}");
    }

    #[test]
    fn the_seed_decides() {
        let (s, _) = sampler(Limb::LeftLeg, Style::default());
        let drawn = |seed| s.draw_pose(&mut Pcg64Mcg::seed_from_u64(seed), 7);
        assert_eq!(drawn(5), drawn(5));
        assert_ne!(drawn(5), drawn(6));
    }
}
