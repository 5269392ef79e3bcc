//! A problem as plain numbers, for planners outside of this workspace: everything stands still as at its beginning.

use serde::Serialize;
use throng_geometry::{Segment, SolidShape};
use throng_planner::collide::Checker;
use throng_planner::limits::{Coordinates, JointLimits, PoseSampler, Style, SwingLimit};
use throng_planner::linkage::{LIMB_JOINTS, LimbPose};
use throng_planner::planner::seeded_rng;
use throng_planner::problem::{CollisionTarget, LimbState, Problem};

/// A problem at its beginning. Metres, radians; Y is up; quaternions are x, y, z, w.
#[derive(Clone, Debug, Serialize)]
pub struct PlainProblem {
    /// Position and rotation of the joint that carries the first one.
    pub base: ([f64; 3], [f64; 4]),
    /// Joints, from the trunk outwards.
    pub joints: Vec<PlainJoint>,
    /// Capsules that move with the joints.
    pub parts: Vec<PlainPart>,
    /// Obstacles that the parts may not come near.
    pub obstacles: Vec<PlainObstacle>,
    /// Part, obstacle, and least distance between their surfaces (m).
    pub pairs: Vec<(usize, usize, f64)>,
    /// Coordinates of each joint at the start and at the goal: swing about both axes, and twist (rad).
    pub ends: [Vec<[f64; 3]>; 2],
    /// Poses within limits, and whether they are free.
    pub samples: Vec<(Vec<[f64; 3]>, bool)>,
}

/// A joint: its rotation is `centre * swing * twist`, in the mirror of x = 0 if it is mirrored; see [`JointLimits`].
#[derive(Clone, Debug, Serialize)]
pub struct PlainJoint {
    /// Offset from the joint before (m).
    pub offset: [f64; 3],
    /// Middle of the range.
    pub centre: [f64; 4],
    /// Twist axis.
    pub bone: [f64; 3],
    /// Swing axes.
    pub axes: [[f64; 3]; 2],
    /// Least and greatest value of each coordinate (rad).
    pub bounds: [[f64; 2]; 3],
    /// True where both swings together are within an ellipse.
    pub is_ellipse: bool,
    /// True for the mirror image.
    pub mirrored: bool,
}

/// A capsule that moves with a joint.
#[derive(Clone, Debug, Serialize)]
pub struct PlainPart {
    /// Index of the joint.
    pub joint: usize,
    /// Ends of its core, in the joint's frame (m).
    pub core: [[f64; 3]; 2],
    /// Radius (m).
    pub radius: f64,
}

/// An obstacle.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlainObstacle {
    /// Capsule in the world (m).
    Capsule {
        /// Ends of its core.
        core: [[f64; 3]; 2],
        /// Radius (m).
        radius: f64,
    },
    /// Box around its place (m).
    Box {
        /// Half size (m).
        half: [f64; 3],
        /// Position and rotation.
        at: ([f64; 3], [f64; 4]),
    },
    /// Triangles in the world (m).
    Mesh {
        /// Corners of each triangle.
        triangles: Vec<[[f64; 3]; 3]>,
    },
}

impl PlainProblem {
    /// Takes a problem at its beginning.
    ///
    /// - `samples`: number of random poses that are checked.
    pub fn from_problem(problem: &Problem, samples: u32) -> Self {
        let time_s = problem.init.time_s;
        let (chain, limits) = (&problem.chain, &problem.limits);
        let base = problem.base_at(time_s);
        let coordinates = |pose: &LimbPose| -> Vec<[f64; 3]> {
            let of = |Coordinates { swing: [x, y], twist }: Coordinates| [x, y, twist];
            (0..LIMB_JOINTS).map(|i| of(limits[i].coordinates(pose.0[i]))).collect()
        };
        let core = |s: &Segment| [s.a.to_array(), s.b.to_array()];
        let solids = problem.solids.iter().map(|s| {
            let at = s.solid.path.place_at(time_s);
            match &s.solid.shape {
                SolidShape::Round { core: c, radius } => {
                    PlainObstacle::Capsule { core: core(&c.map(|p| at.transform_point(p))), radius: *radius }
                }
                SolidShape::Cuboid { half } => {
                    PlainObstacle::Box { half: half.to_array(), at: (at.position.to_array(), at.rotation.to_array()) }
                }
                SolidShape::Mesh(mesh) => {
                    let corner = |c: glam::Vec3| at.transform_point(c.as_dvec3()).to_array();
                    PlainObstacle::Mesh { triangles: mesh.corners().iter().map(|t| t.map(corner)).collect() }
                }
            }
        });
        let bodies = problem.bodies.iter();
        let bodies =
            bodies.map(|b| PlainObstacle::Capsule { core: core(&b.track.sample_at(time_s)), radius: b.radius });
        let pair = |p: &throng_planner::problem::CollisionPair| match p.target {
            CollisionTarget::Solid(s) => Some((p.part, s, p.gap)),
            CollisionTarget::Body(b) => Some((p.part, problem.solids.len() + b, p.gap)),
            CollisionTarget::Tether | CollisionTarget::Upright => None,
        };
        let sampler = PoseSampler::new(*limits, &problem.init.pose, Style::default(), 1);
        let (mut rng, mut checker) = (seeded_rng(1), Checker::default());
        let samples = (0..samples).map(|i| {
            let pose = sampler.draw_pose(&mut rng, i + 1);
            (coordinates(&pose), checker.is_free(problem, &LimbState { pose, time_s }))
        });
        let part =
            |p: &throng_planner::problem::LimbPart| PlainPart { joint: p.link, core: core(&p.core), radius: p.radius };
        Self {
            base: (base.position.to_array(), base.rotation.to_array()),
            joints: (0..LIMB_JOINTS)
                .map(|i| PlainJoint::from_limits(&limits[i], chain.offsets[i].to_array()))
                .collect(),
            parts: problem.parts.iter().map(part).collect(),
            obstacles: solids.chain(bodies).collect(),
            pairs: problem.pairs.iter().filter_map(pair).collect(),
            ends: [&problem.init, &problem.goal].map(|s| coordinates(&s.pose)),
            samples: samples.collect(),
        }
    }
}

impl PlainJoint {
    fn from_limits(limits: &JointLimits, offset: [f64; 3]) -> Self {
        let (x, y, is_ellipse) = match limits.swing {
            SwingLimit::Ellipse([x, y]) => ([-x, x], [-y, y], true),
            SwingLimit::Hinge { flexion, play } => ([flexion.least, flexion.most], [-play, play], false),
        };
        Self {
            offset,
            centre: limits.centre.to_array(),
            bone: limits.segment.to_array(),
            axes: limits.axes.map(|a| a.to_array()),
            bounds: [x, y, [limits.twist.least, limits.twist.most]],
            is_ellipse,
            mirrored: limits.mirrored,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Somebody, solid};
    use glam::{DQuat, DVec3};
    use throng_planner::rotation::{Rigid, exp, mirror_rotation_x, rotation_about};
    use throng_planner::setup::ProblemSpec;

    /// Rotation of a joint, from its plain numbers alone.
    fn turn(j: &PlainJoint, [x, y, twist]: [f64; 3]) -> DQuat {
        let [bone, first, second] = [j.bone, j.axes[0], j.axes[1]].map(DVec3::from);
        let q = DQuat::from_array(j.centre) * exp(first * x + second * y) * rotation_about(bone, twist);
        if j.mirrored { mirror_rotation_x(q) } else { q }
    }

    #[test]
    fn numbers_alone_say_what_is_free() {
        let s = Somebody::standing();
        let pose = s.pose(0.0, -1.2, 0.2);
        let solids = [
            solid("ball", SolidShape::ball(0.1), DVec3::new(0.35, 1.5, 0.25)),
            solid("box", SolidShape::cuboid(DVec3::new(0.4, 0.1, 0.3)), DVec3::new(0.4, 1.2, 0.4)),
        ];
        let spec = s.spec([(pose, 0.0), (pose, 1.0)]);
        let problem = Problem::prepare(&ProblemSpec { solids: &solids, ..spec }).expect("a problem");
        let plain = PlainProblem::from_problem(&problem, 300);
        let segment = |[a, b]: [[f64; 3]; 2]| Segment::new(DVec3::from(a), DVec3::from(b));
        let is_near = |placed: &[Rigid], &(part, obstacle, gap): &(usize, usize, f64)| {
            let part = &plain.parts[part];
            let core = segment(part.core).map(|p| placed[part.joint].transform_point(p));
            match &plain.obstacles[obstacle] {
                PlainObstacle::Capsule { core: other, radius } => {
                    core.distance(&segment(*other)) - radius < part.radius + gap
                }
                PlainObstacle::Box { half, at } => (0..=400).any(|i| {
                    let p = core.a.lerp(core.b, f64::from(i) / 400.0) - DVec3::from(at.0);
                    (p.abs() - DVec3::from(*half)).max(DVec3::ZERO).length() < part.radius + gap
                }),
                PlainObstacle::Mesh { .. } => false,
            }
        };
        let (mut num_free, mut others) = (0, 0);
        for (coordinates, free) in &plain.samples {
            let mut at = Rigid { position: DVec3::from(plain.base.0), rotation: DQuat::from_array(plain.base.1) };
            let placed: Vec<Rigid> = plain
                .joints
                .iter()
                .zip(coordinates)
                .map(|(j, c)| {
                    at = at.compose(Rigid { position: DVec3::from(j.offset), rotation: turn(j, *c) });
                    at
                })
                .collect();
            let is_free = !plain.pairs.iter().any(|pair| is_near(&placed, pair));
            num_free += usize::from(*free);
            // Boxes are looked at in steps of a millimetre.
            others += usize::from(is_free != *free);
        }
        assert!(others <= 1 && (50..250).contains(&num_free), "{others} of {num_free}");
    }
}
