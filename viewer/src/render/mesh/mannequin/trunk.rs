//! Pelvis, waist, chest and the slope of the shoulders: one tube from crotch to neck.

use super::super::loft::{Loft, Ring};
use super::super::weights::smooth;
use super::super::{Influence, Mesh, Part, Side};
use super::Plan;
use glam::Vec3;
use throng_runtime::{Joint, Skeleton};

/// A cross-section: height, half width, half depth and how far forward, in a body of the default size, and the
/// coarsest level of detail that has it. [Unit: m]
type Section = (f32, f32, f32, f32, usize);

const SECTIONS: [Section; 15] = [
    (0.842, 0.060, 0.062, -0.006, 1),
    (0.868, 0.118, 0.092, -0.008, 2),
    (0.905, 0.148, 0.108, -0.010, 0),
    (0.945, 0.158, 0.113, -0.010, 1),
    (0.990, 0.152, 0.108, -0.006, 0),
    (1.045, 0.136, 0.097, 0.000, 1),
    (1.100, 0.127, 0.092, 0.004, 2),
    (1.165, 0.131, 0.097, 0.007, 0),
    (1.235, 0.144, 0.106, 0.009, 1),
    (1.305, 0.156, 0.112, 0.010, 0),
    (1.370, 0.161, 0.108, 0.007, 2),
    (1.420, 0.154, 0.096, 0.002, 1),
    (1.455, 0.131, 0.078, -0.002, 0),
    (1.482, 0.094, 0.063, -0.003, 1),
    (1.503, 0.062, 0.054, -0.001, 0),
];
const BOTTOM: f32 = 0.832;
const TOP: f32 = 1.512;
/// Trousers below, shirt above. [Unit: m]
const WAIST: f32 = 1.03;

/// Joints along the spine.
const SPINE: [Joint; 6] = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck, Joint::Head];

/// Heights of the default skeleton onto those of another, joint by joint.
struct Heights {
    from: Vec<f32>,
    to: Vec<Vec3>,
}

impl Heights {
    fn new(plan: &Plan) -> Self {
        let default = Skeleton::default().rest_positions();
        let thigh = 0.5 * (plan.at(Joint::LeftThigh) + plan.at(Joint::RightThigh));
        let crotch = Vec3::new(thigh.x, thigh.y - 0.08 * plan.scale, thigh.z);
        let mut from = vec![default[Joint::LeftThigh.index()].y - 0.08];
        from.extend(SPINE.map(|j| default[j.index()].y));
        let to = std::iter::once(crotch).chain(SPINE.map(|j| plan.at(j))).collect();
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

pub(super) fn build(plan: &Plan, mesh: &mut Mesh) {
    let heights = Heights::new(plan);
    let s = plan.scale;
    let rings: Vec<Ring> = SECTIONS
        .iter()
        .filter(|section| section.4 >= plan.level)
        .map(|&(y, width, depth, forward, _)| Ring {
            centre: heights.middle(y) + Vec3::Z * (forward * s),
            u: Vec3::X * (width * s),
            v: Vec3::Z * (depth * s),
            square: [2.35; 2],
        })
        .collect();
    let poles = [heights.middle(BOTTOM), heights.middle(TOP)];
    let waist = heights.middle(WAIST).y;
    let part = |middle: Vec3, _| if middle.y < waist { Part::Trousers } else { Part::Shirt };
    let loft = Loft { rings: &rings, segments: plan.segments([18, 10, 5]), poles, side: Side::Middle };
    loft.build(mesh, |p| weigh(plan, p), part);
}

/// Along the spine by height; the lower flanks follow the thighs a little, the shoulders the clavicles.
fn weigh(plan: &Plan, p: Vec3) -> Influence {
    let s = plan.scale;
    let start = |j: Joint| plan.at(j).y;
    let links = [
        (Joint::Hips, 0.0, 0.0),
        (Joint::Spine, start(Joint::Spine), 0.07 * s),
        (Joint::Chest, start(Joint::Chest), 0.07 * s),
        (Joint::UpperChest, start(Joint::UpperChest), 0.07 * s),
        (Joint::Neck, start(Joint::Neck) + 0.005 * s, 0.02 * s),
    ];
    let spine = Influence::chain(&links, p.y);
    let side = if p.x >= 0.0 { Side::Left } else { Side::Right };
    let (clavicle, thigh) = (side.of(Joint::LeftClavicle), side.of(Joint::LeftThigh));
    let out = p.x.abs() / s;
    let shoulder = smooth(0.05, 0.15, out) * smooth(start(clavicle) - 0.12 * s, start(clavicle) + 0.01 * s, p.y);
    let flank = smooth(0.03, 0.14, out) * smooth(start(thigh) + 0.03 * s, start(thigh) - 0.05 * s, p.y);
    spine.mix(Influence::rigid(clavicle), 0.65 * shoulder).mix(Influence::rigid(thigh), 0.35 * flank)
}
