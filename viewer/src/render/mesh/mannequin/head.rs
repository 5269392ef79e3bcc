//! Neck and head, with a nose and a visor that show where the face is.

use super::super::loft::{Loft, Ring, equal_area};
use super::super::{BodyMesh, BodySide, Influence, SurfacePart};
use super::{BodySection, MannequinPlan};
use glam::Vec3;
use throng_core::Joint;

/// Height above the head joint, half width, half depth, and how far forward, for a head 0.2 m high (m).
const SKULL: [BodySection; 11] = [
    (-0.040, 0.030, 0.034, 0.050, 1),
    (-0.026, 0.046, 0.055, 0.036, 0),
    (0.000, 0.058, 0.073, 0.024, 2),
    (0.030, 0.067, 0.087, 0.015, 0),
    (0.062, 0.073, 0.096, 0.008, 3),
    (0.092, 0.076, 0.100, 0.004, 1),
    (0.122, 0.077, 0.100, 0.000, 3),
    (0.150, 0.073, 0.094, -0.003, 0),
    (0.173, 0.063, 0.081, -0.004, 2),
    (0.189, 0.047, 0.060, -0.004, 0),
    (0.197, 0.028, 0.036, -0.004, 1),
];
const SKULL_ENDS: [(f32, f32); 2] = [(-0.046, 0.05), (0.2, -0.004)];
/// Between these heights the front of the skull is a visor (m).
const VISOR: std::ops::Range<f32> = 0.062..0.122;

const NECK: [BodySection; 4] = [
    (-0.150, 0.058, 0.056, -0.004, 1),
    (-0.085, 0.057, 0.055, -0.005, 2),
    (-0.040, 0.055, 0.057, -0.004, 0),
    (0.015, 0.046, 0.048, 0.000, 2),
];
/// Heights of its poles (m).
const NECK_ENDS: [f32; 2] = [-0.16, 0.03];

pub(super) fn build(plan: &MannequinPlan, mesh: &mut BodyMesh) {
    let (neck, head) = (plan.joint_position(Joint::Neck), plan.joint_position(Joint::Head));
    let size = ((plan.tips[0] - head).length() / 0.2).clamp(0.2, 5.0);
    let base = head + Vec3::Y * ((plan.tips[0].y - head.y) - 0.2 * size);
    let place = |y: f32, forward: f32| base + Vec3::new(0.0, y, forward) * size;
    let rings_at = |sections: &[BodySection], segments: usize| {
        let stout = size * equal_area(segments);
        plan.rings(sections, |[y, width, depth, forward]| Ring {
            square: [2.2, 2.2],
            ..Ring::ellipse(place(y, forward), Vec3::X * (width * stout), Vec3::Z * (depth * stout))
        })
    };

    let links = [
        (Joint::UpperChest, f32::NEG_INFINITY, 0.0),
        (Joint::Neck, neck.y, 0.04 * size),
        (Joint::Head, head.y - 0.01 * size, 0.04 * size),
    ];
    if !plan.is_coarsest() {
        let segments = plan.segments([12, 6, 4, 4]);
        let (rings, poles) = (rings_at(&NECK, segments), NECK_ENDS.map(|y| place(y, 0.0)));
        let loft = Loft { rings: &rings, segments, poles };
        loft.build(mesh, |p| Influence::chain(&links, p.y), |_| (SurfacePart::Skin, BodySide::Middle));
    }

    let segments = plan.segments([18, 8, 6, 4]);
    let rings = rings_at(&SKULL, segments);
    let [chin, crown] = SKULL_ENDS.map(|(y, forward)| place(y, forward));
    let chin = if plan.is_coarsest() { place(NECK_ENDS[0], 0.0) } else { chin };
    let loft = Loft { rings: &rings, segments, poles: [chin, crown] };
    let part = |middle: Vec3| {
        let p = (middle - base) / size;
        let visor = p.z > 0.045 && VISOR.contains(&p.y);
        (if visor { SurfacePart::Visor } else { SurfacePart::Skin }, BodySide::Middle)
    };
    loft.build(mesh, |_| Influence::rigid(Joint::Head), part);
    if plan.level == 0 {
        nose(&place, size, mesh);
    }
}

/// A small wedge below the visor.
fn nose(place: &impl Fn(f32, f32) -> Vec3, size: f32, mesh: &mut BodyMesh) {
    let ring = |y: f32, forward: f32, radius: f32| {
        Ring::ellipse(place(y, forward), Vec3::X * (radius * 0.8 * size), Vec3::Z * (radius * size))
    };
    let rings = [ring(0.030, 0.100, 0.010), ring(0.040, 0.103, 0.014), ring(0.062, 0.098, 0.011)];
    let loft = Loft { rings: &rings, segments: 6, poles: [place(0.026, 0.1), place(0.08, 0.096)] };
    loft.build(mesh, |_| Influence::rigid(Joint::Head), |_| (SurfacePart::Skin, BodySide::Middle));
}
