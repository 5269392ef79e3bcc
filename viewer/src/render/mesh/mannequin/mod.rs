//! A smooth figure in the manner of an artist's mannequin: lofts through tables of cross-sections.
//!
//! The tables are for the default skeleton; lengths follow the joints of the one at hand, widths its height. The surface
//! blends over knees, elbows, hips and shoulders; a ball inside each of these keeps the volume that a bend takes away.

mod head;
mod limb;
mod trunk;

use super::loft::{Loft, Ring};
use super::{BodyMesh, BodySide, Influence, LEVELS, SurfacePart};
use glam::Vec3;
use throng_core::{Joint, NUM_JOINTS, Skeleton};

/// A cross-section of a part: position along the part, two half axes, how far forward or to the outer side, and the
/// coarsest level of detail that has it. Units and directions are those of the part.
type BodySection = (f32, f32, f32, f32, usize);

/// Data shared by all parts of one mannequin.
struct MannequinPlan {
    /// Rest positions of the joints (m).
    rest: [Vec3; NUM_JOINTS],
    /// Ends of head and toes (m).
    tips: [Vec3; 3],
    /// Size relative to the default skeleton.
    scale: f32,
    /// Level of detail, 0 is the finest.
    level: usize,
}

impl MannequinPlan {
    fn joint_position(&self, joint: Joint) -> Vec3 {
        self.rest[joint.index()]
    }

    /// True at the coarsest level, which has no neck and no hands: head and arms extend to cover them.
    fn is_coarsest(&self) -> bool {
        self.level == LEVELS - 1
    }

    /// The points of a ring at this level. `by_level` is finest first.
    fn segments(&self, by_level: [usize; LEVELS]) -> usize {
        by_level[self.level]
    }

    /// Rings at the cross-sections that this level has.
    ///
    /// - `ring`: from position, half axes and offset.
    fn rings(&self, sections: &[BodySection], ring: impl Fn([f32; 4]) -> Ring) -> Vec<Ring> {
        let kept = sections.iter().filter(|section| section.4 >= self.level);
        kept.map(|&(at, u, v, offset, _)| ring([at, u, v, offset])).collect()
    }

    /// A ball around a joint, moved by the joint. It is round, so turns are not visible. Only at the finest level.
    fn ball(&self, joint: Joint, radius: f32, part: SurfacePart, mesh: &mut BodyMesh) {
        if self.level > 0 {
            return;
        }
        let (centre, radius) = (self.joint_position(joint), radius * self.scale);
        let bands = 4;
        let ring = |i: usize| {
            let (s, c) = (std::f32::consts::PI * ((i as f32 + 0.5) / bands as f32 - 0.5)).sin_cos();
            Ring::ellipse(centre + Vec3::Y * s * radius, Vec3::X * c * radius, Vec3::Z * c * radius)
        };
        let rings: Vec<Ring> = (0..bands).map(ring).collect();
        let poles = [centre - Vec3::Y * radius, centre + Vec3::Y * radius];
        let loft = Loft { rings: &rings, segments: 8, poles };
        let side = BodySide::of_joint(joint);
        loft.build(mesh, |_| Influence::rigid(joint), |_| (part, side));
    }
}

/// The body at one level of detail.
pub(super) fn build(skeleton: &Skeleton, level: usize) -> BodyMesh {
    let rest = skeleton.rest_positions();
    let [head, left_toe, right_toe] = [Joint::Head, Joint::LeftToe, Joint::RightToe].map(|j| rest[j.index()]);
    let tips = [head + skeleton.tips[0], left_toe + skeleton.tips[1], right_toe + skeleton.tips[2]];
    let scale = (tips[0].y / 1.785).clamp(0.2, 5.0);
    let plan = MannequinPlan { rest, tips, scale, level };
    let mut mesh = BodyMesh::default();
    trunk::build(&plan, &mut mesh);
    head::build(&plan, &mut mesh);
    for side in BodySide::BOTH {
        limb::leg(&plan, side, &mut mesh);
        limb::foot(&plan, side, &mut mesh);
        limb::arm(&plan, side, &mut mesh);
        if !plan.is_coarsest() {
            limb::hand(&plan, side, &mut mesh);
        }
    }
    mesh
}
