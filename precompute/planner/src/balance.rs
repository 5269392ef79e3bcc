//! Centre of mass of a body, and its distance from the ground that the planted feet span.

use crate::rotation::Rigid;
use glam::{DVec2, DVec3};
use throng_base::thresholds::HEEL_PER_BALL;
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton};
use throng_geometry::Segment;

/// Segment from one joint to another: its share of the body's mass, and where along it the mass is.
///
/// # Source
/// Winter 2009, *Biomechanics and Motor Control of Human Movement*, table 4.1; the trunk is halved, hands and feet are at
/// their joints' segments.
const SEGMENTS: [(Joint, Joint, f64, f64); 14] = [
    (Joint::Hips, Joint::Spine, 0.142, 0.1),
    (Joint::Spine, Joint::UpperChest, 0.139, 0.44),
    (Joint::UpperChest, Joint::Neck, 0.216, 0.5),
    (Joint::Neck, Joint::Head, 0.081, 1.0),
    (Joint::LeftUpperArm, Joint::LeftForearm, 0.028, 0.436),
    (Joint::RightUpperArm, Joint::RightForearm, 0.028, 0.436),
    (Joint::LeftForearm, Joint::LeftHand, 0.022, 0.682),
    (Joint::RightForearm, Joint::RightHand, 0.022, 0.682),
    (Joint::LeftThigh, Joint::LeftShin, 0.1, 0.433),
    (Joint::RightThigh, Joint::RightShin, 0.1, 0.433),
    (Joint::LeftShin, Joint::LeftFoot, 0.0465, 0.433),
    (Joint::RightShin, Joint::RightFoot, 0.0465, 0.433),
    (Joint::LeftFoot, Joint::LeftToe, 0.0145, 0.5),
    (Joint::RightFoot, Joint::RightToe, 0.0145, 0.5),
];
/// Half width of a foot (m).
const HALF_WIDTH_M: f64 = 0.04;

/// Centre of mass of a body (m).
pub fn centre_of_mass(places: &[Rigid; NUM_JOINTS]) -> DVec3 {
    let at = |j: Joint| places[j.index()].position;
    let (sum, mass) = SEGMENTS.iter().fold((DVec3::ZERO, 0.0), |(sum, mass), (from, to, share, along)| {
        (sum + *share * at(*from).lerp(at(*to), *along), mass + share)
    });
    sum / mass
}

/// Distance of the centre of mass from the convex hull of the planted feet, seen from above; 0 inside it, `None` where no foot
/// is planted (m).
pub fn distance_off_feet(skeleton: &Skeleton, places: &[Rigid; NUM_JOINTS], contacts: Contacts) -> Option<f64> {
    let feet = [
        (Contacts::LEFT, Joint::LeftFoot, Joint::LeftToe, skeleton.tips[1]),
        (Contacts::RIGHT, Joint::RightFoot, Joint::RightToe, skeleton.tips[2]),
    ];
    let mut corners = Vec::new();
    for (_, ankle, toe, tip) in feet.into_iter().filter(|f| contacts.any(f.0)) {
        let flat = |p: DVec3| DVec2::new(p.x, p.z);
        let (ankle, ball) = (flat(places[ankle.index()].position), flat(places[toe.index()].position));
        let end = flat(places[toe.index()].transform_point(tip.as_dvec3()));
        let aside = (end - ankle).perp().normalize_or_zero() * HALF_WIDTH_M;
        let heel = ankle - f64::from(HEEL_PER_BALL) * (ball - ankle);
        corners.extend([heel, end].into_iter().flat_map(|p| [p + aside, p - aside]));
    }
    let com = centre_of_mass(places);
    (!corners.is_empty()).then(|| distance_outside(&hull(corners), DVec2::new(com.x, com.z)))
}

/// Convex hull of points, counter-clockwise.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut out: Vec<DVec2> = Vec::new();
    for half in 0..2 {
        let first = out.len();
        let all: Vec<DVec2> = if half == 0 { points.clone() } else { points.iter().rev().copied().collect() };
        for p in all {
            while out.len() >= first + 2
                && (out[out.len() - 1] - out[out.len() - 2]).perp_dot(p - out[out.len() - 1]) <= 0.0
            {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
    }
    out
}

/// Distance of a point from a convex polygon; 0 inside (m).
fn distance_outside(polygon: &[DVec2], p: DVec2) -> f64 {
    let edges = || (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
    if polygon.len() > 2 && edges().all(|(a, b)| (b - a).perp_dot(p - a) >= 0.0) {
        return 0.0;
    }
    let segment = |a: DVec2, b: DVec2| Segment::new(a.extend(0.0), b.extend(0.0));
    edges().map(|(a, b)| segment(a, b).distance(&segment(p, p))).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driven::place_joints;
    use crate::rotation::rotation_about;
    use glam::DQuat;

    #[test]
    fn masses_add_up_to_a_body() {
        let sum: f64 = SEGMENTS.iter().map(|s| s.2).sum();
        assert!((sum - 1.0).abs() < 0.03, "{sum}");
    }

    #[test]
    fn distances_from_a_square_are_those_worked_out() {
        let square = hull([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.4]].map(DVec2::from).to_vec());
        assert_eq!(square.len(), 4);
        for (p, far) in [([0.5, 0.5], 0.0), ([0.5, 1.25], 0.25), ([-0.3, -0.4], 0.5), ([1.0, 0.5], 0.0)] {
            assert!((distance_outside(&square, DVec2::from(p)) - far).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn who_stands_is_over_its_feet_and_who_leans_with_stiff_legs_is_not() {
        let s = Skeleton::default();
        let mut turns = [DQuat::IDENTITY; NUM_JOINTS];
        let root = s.offsets[0].as_dvec3();
        let feet = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
        let off = |turns: &[DQuat; NUM_JOINTS], feet| distance_off_feet(&s, &place_joints(&s, root, turns), feet);
        assert_eq!(off(&turns, feet), Some(0.0));
        // One foot alone does not carry somebody whose hips are between both.
        assert!(off(&turns, Contacts::LEFT).is_some_and(|m| m > 0.02));
        assert_eq!(off(&turns, Contacts::default()), None);
        let before = centre_of_mass(&place_joints(&s, root, &turns));
        let height = before.y;
        for j in [Joint::Spine, Joint::LeftUpperArm, Joint::RightUpperArm] {
            turns[j.index()] = rotation_about(DVec3::X, 0.8);
        }
        let ahead = centre_of_mass(&place_joints(&s, root, &turns)).z - before.z;
        // Two thirds of the mass, a third of a metre above the pivot.
        assert!((0.1..0.22).contains(&ahead), "{ahead}");
        // A little farther and it is past the toes.
        let past = (0..40).find(|i| {
            let places = place_joints(&s, root, &turns);
            let mut moved = places;
            let feet_back = DVec3::Z * -0.01 * f64::from(*i);
            for j in [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe] {
                moved[j.index()].position += feet_back;
            }
            distance_off_feet(&s, &moved, feet).is_some_and(|m| m > 0.0)
        });
        assert!(past.is_some_and(|i| i < 25), "{past:?}");
        // People's is at 55 % of their height.
        let places = place_joints(&s, root, &[DQuat::IDENTITY; NUM_JOINTS]);
        let top = places[Joint::Head.index()].transform_point(s.tips[0].as_dvec3()).y;
        assert!((0.52..0.62).contains(&(height / top)), "{height} of {top}");
    }
}
