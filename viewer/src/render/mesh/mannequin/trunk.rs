//! Pelvis, waist, chest and the slope of the shoulders: one tube from crotch to neck.

use super::super::loft::{Loft, Ring, equal_area};
use super::super::weights::smooth;
use super::super::{BodyMesh, BodySide, Influence, SurfacePart, Vertex};
use super::{BodySection, MannequinPlan};
use glam::Vec3;
use throng_core::{Joint, Skeleton};

/// Height, half width, half depth, and how far forward, in a body of the default size (m).
const SECTIONS: [BodySection; 15] = [
    (0.838, 0.070, 0.050, -0.016, 1),
    (0.862, 0.128, 0.078, -0.018, 3),
    (0.900, 0.155, 0.100, -0.016, 0),
    (0.945, 0.163, 0.111, -0.012, 1),
    (0.990, 0.152, 0.108, -0.006, 0),
    (1.045, 0.136, 0.097, 0.000, 1),
    (1.100, 0.127, 0.092, 0.004, 3),
    (1.165, 0.131, 0.097, 0.007, 0),
    (1.235, 0.144, 0.106, 0.009, 1),
    (1.305, 0.156, 0.112, 0.010, 0),
    (1.370, 0.161, 0.108, 0.007, 3),
    (1.420, 0.166, 0.098, 0.002, 1),
    (1.458, 0.148, 0.080, -0.003, 0),
    (1.487, 0.108, 0.073, 0.001, 1),
    (1.509, 0.073, 0.070, 0.004, 0),
];
const BOTTOM: f32 = 0.828;
const TOP: f32 = 1.516;
/// Trousers below, shirt above (m).
const WAIST: f32 = 1.03;

/// Joints along the spine.
const SPINE: [Joint; 6] = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck, Joint::Head];

/// Maps heights of the default skeleton to those of another, joint by joint.
struct TrunkHeights {
    from: Vec<f32>,
    to: Vec<Vec3>,
}

impl TrunkHeights {
    fn new(plan: &MannequinPlan) -> Self {
        let default = Skeleton::default().rest_positions();
        let thigh = 0.5 * (plan.joint_position(Joint::LeftThigh) + plan.joint_position(Joint::RightThigh));
        let crotch = Vec3::new(thigh.x, thigh.y - 0.08 * plan.scale, thigh.z);
        let mut from = vec![default[Joint::LeftThigh.index()].y - 0.08];
        from.extend(SPINE.map(|j| default[j.index()].y));
        let to = std::iter::once(crotch).chain(SPINE.map(|j| plan.joint_position(j))).collect();
        Self { from, to }
    }

    /// The middle of the trunk at a height of the default body.
    fn middle(&self, height: f32) -> Vec3 {
        let last = self.from.len() - 2;
        let i = (0..=last).rev().find(|&i| height >= self.from[i]).unwrap_or(0);
        let t = (height - self.from[i]) / (self.from[i + 1] - self.from[i]);
        self.to[i] + (self.to[i + 1] - self.to[i]) * t
    }
}

pub(super) fn build(plan: &MannequinPlan, mesh: &mut BodyMesh) {
    let heights = TrunkHeights::new(plan);
    let s = plan.scale;
    let segments = plan.segments([18, 8, 6, 4]);
    let stout = s * equal_area(segments);
    let rings = plan.rings(&SECTIONS, |[y, width, depth, forward]| Ring {
        centre: heights.middle(y) + Vec3::Z * (forward * s),
        u: Vec3::X * (width * stout),
        v: Vec3::Z * (depth * stout),
        square: [2.35; 2],
    });
    let poles = [heights.middle(BOTTOM), heights.middle(TOP)];
    let waist = heights.middle(WAIST).y;
    // Trousers have two legs, which begin at the belt.
    let part = |middle: Vec3| match middle.y < waist {
        true if middle.x > 0.0 => (SurfacePart::Trousers, BodySide::Left),
        true => (SurfacePart::Trousers, BodySide::Right),
        false => (SurfacePart::Shirt, BodySide::Middle),
    };
    let loft = Loft { rings: &rings, segments, poles };
    let first = mesh.vertices.len();
    loft.build(mesh, |p| weigh(plan, p), part);
    mesh.vertices[first..].iter_mut().for_each(|v| hide_hem(plan, v));
}

/// Aligns the normals of the pelvis with those of the thighs, so that no edge is visible between them.
fn hide_hem(plan: &MannequinPlan, vertex: &mut Vertex) {
    let (p, normal, s) = (Vec3::from(vertex.position), Vec3::from(vertex.normal), plan.scale);
    let thigh = plan.joint_position(if p.x < 0.0 { Joint::RightThigh } else { Joint::LeftThigh });
    let low = 1.0 - smooth(thigh.y + 0.02 * s, thigh.y + 0.12 * s, p.y);
    let level = Vec3::new(normal.x, normal.y * (1.0 - low), normal.z).normalize_or(normal);
    // Thighs are deeper than wide. Between them the crotch is unchanged.
    let outward = Vec3::new(1.5 * (p.x - thigh.x), 0.0, p.z - thigh.z).normalize_or(level);
    let beside = smooth(0.0, 0.05 * s, p.x.abs());
    vertex.normal = level.lerp(outward, low * beside).normalize_or(level).to_array();
}

/// Along the spine by height; the lower flanks follow the thighs a little, the shoulders the clavicles.
fn weigh(plan: &MannequinPlan, p: Vec3) -> Influence {
    let s = plan.scale;
    let start = |j: Joint| plan.joint_position(j).y;
    let links = [
        (Joint::Hips, 0.0, 0.0),
        (Joint::Spine, start(Joint::Spine), 0.07 * s),
        (Joint::Chest, start(Joint::Chest), 0.07 * s),
        (Joint::UpperChest, start(Joint::UpperChest), 0.07 * s),
        (Joint::Neck, start(Joint::Neck) + 0.005 * s, 0.02 * s),
    ];
    let spine = Influence::chain(&links, p.y);
    let side = if p.x >= 0.0 { BodySide::Left } else { BodySide::Right };
    let (clavicle, thigh) = (side.joint_on_side(Joint::LeftClavicle), side.joint_on_side(Joint::LeftThigh));
    let out = p.x.abs() / s;
    let shoulder = smooth(0.05, 0.15, out) * smooth(start(clavicle) - 0.12 * s, start(clavicle) + 0.01 * s, p.y);
    let flank = smooth(0.03, 0.14, out) * (1.0 - smooth(start(thigh) - 0.05 * s, start(thigh) + 0.06 * s, p.y));
    spine.mix(Influence::rigid(clavicle), 0.65 * shoulder).mix(Influence::rigid(thigh), 0.5 * flank)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legs_move_nothing_above_the_hips() {
        let skeleton = Skeleton::default();
        let rest = skeleton.rest_positions();
        let moved_by = |v: &Vertex, joint: Joint| -> u32 {
            let pairs = v.joints.iter().zip(v.weights);
            pairs.filter(|(j, _)| usize::from(**j) == joint.index()).map(|(_, w)| u32::from(w)).sum()
        };
        for level in 0..super::super::LEVELS {
            let mesh = super::super::build(&skeleton, level);
            let by_legs = |v: &&Vertex| moved_by(v, Joint::LeftThigh) + moved_by(v, Joint::RightThigh) > 0;
            let highest = mesh.vertices.iter().filter(by_legs).map(|v| v.position[1]).fold(0.0, f32::max);
            let thigh = rest[Joint::LeftThigh.index()].y;
            assert!((thigh - 0.1..thigh + 0.1).contains(&highest), "{level}: {highest}");
        }
    }
}
