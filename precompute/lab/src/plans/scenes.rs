//! Benchmark scenes for plans: one limb, from one pose to another.

use glam::{DQuat, DVec3, Quat, Vec3};
use std::{error::Error, sync::Arc};
use throng_core::{Joint, NUM_JOINTS, Skeleton};
use throng_geometry::{SolidShape, TriangleMesh};
use throng_motion::Clip;
use throng_planner::limits::{BodyLimits, Coordinates};
use throng_planner::linkage::{Limb, LimbPose};
use throng_planner::problem::{LimbState, MovingSolid, Problem};
use throng_planner::rotation::{Rigid, rotation_about, rotation_between};
use throng_planner::setup::{AllowedContact, ProblemSpec};
use throng_planner::{body::BodyCapsules, collide::Checker, driven::DrivenMotion, track::RigidPath};
use throng_synth::{SynthConfig, SynthSet, make_set};

/// Names of the scenes, and the time that the paper gives for a similar one (s).
pub const SCENES: [(&str, Option<f64>); 5] =
    [("table", Some(1.0)), ("arm-static", None), ("spheres", None), ("ring", Some(2.0)), ("walk", Some(2.0))];
/// Duration of the scenes without moving obstacles; longer than ever needed (s).
const STATIC_S: f64 = 4.0;

/// The character of a scene, moved by a clip.
pub struct SceneActor {
    /// Skeleton of the character.
    pub skeleton: Skeleton,
    /// How far its joints turn.
    pub limits: BodyLimits,
    /// Motion that the plan changes.
    pub clip: Clip,
    /// The same motion, for the planner.
    pub motion: DrivenMotion,
    /// Capsules of its body.
    pub shape: BodyCapsules,
    /// The limb that is planned.
    pub limb: Limb,
}

/// A benchmark scene.
pub struct PlanScene {
    /// The character whose limb is planned.
    pub actor: SceneActor,
    /// Solids in the way.
    pub solids: Vec<MovingSolid>,
    /// Contacts that are allowed.
    pub allowed: Vec<AllowedContact>,
    /// Poses of the limb and their times, at the start and at the goal.
    pub ends: [LimbState; 2],
}

type SceneResult<T> = Result<T, Box<dyn Error>>;

/// Makes the scene with a name.
pub fn find_scene(name: &str) -> SceneResult<Option<PlanScene>> {
    Ok(Some(match name {
        "table" => table(),
        "arm-static" => arm_static()?,
        "spheres" => spheres()?,
        "ring" => ring()?,
        "walk" => walk()?,
        _ => return Ok(None),
    }))
}

impl PlanScene {
    /// A standing character whose hand moves from the middle space between the boards of the shelf to the upper one.
    fn between_boards(solids: Vec<MovingSolid>) -> SceneResult<Self> {
        let actor = SceneActor::standing(STATIC_S);
        let low = actor.pose_reaching([0.36, 1.24, 0.4], &solids)?;
        let high = actor.pose_reaching([0.36, 1.5, 0.42], &solids)?;
        Ok(Self { actor, solids, allowed: Vec::new(), ends: states([(low, 0.0), (high, STATIC_S)]) })
    }

    /// The planning problem of the scene.
    pub fn problem(&self) -> SceneResult<Problem> {
        let spec = self.actor.spec(self.ends, &self.solids);
        Ok(Problem::new(&ProblemSpec { admit_ends: true, allowed: &self.allowed, ..spec })?)
    }
}

impl SceneActor {
    fn from_clip(skeleton: Skeleton, clip: Clip) -> Self {
        let end_s = (clip.num_frames() - 1) as f64 / clip.rate_hz;
        let motion = DrivenMotion::from_clip(&clip, &skeleton, 0.0, end_s);
        let (limits, shape) = (BodyLimits::built_in(&skeleton), BodyCapsules::fitted(&skeleton));
        Self { skeleton, limits, clip, motion, shape, limb: Limb::LeftArm }
    }

    fn standing(seconds: f64) -> Self {
        let (skeleton, frames) = (Skeleton::default(), (seconds * 30.0) as usize + 1);
        let rotations = vec![Quat::IDENTITY; frames * NUM_JOINTS];
        let clip = Clip::new("standing", 30.0, vec![skeleton.offsets[0]; frames], rotations);
        Self::from_clip(skeleton, clip)
    }

    /// The problem's parts, for ends and surroundings of the caller's.
    pub fn spec<'a>(&'a self, ends: [LimbState; 2], solids: &'a [MovingSolid]) -> ProblemSpec<'a> {
        let spec = ProblemSpec::new(&self.skeleton, self.limb, &self.limits, &self.motion, &self.shape, ends);
        ProblemSpec { solids, ..spec }
    }

    /// Arm pose from the swing of the shoulder and the flexion of the elbow (rad).
    fn pose(&self, across: f64, up: f64, flexion: f64) -> LimbPose {
        let mut pose = LimbPose::REST;
        if let Some(limits) = self.limits.limb_limits(self.limb) {
            pose.0[0] = limits[0].rotation(Coordinates { swing: [across, up], twist: 0.0 });
            pose.0[1] = limits[1].rotation(Coordinates { swing: [flexion, 0.0], twist: 0.0 });
        }
        pose
    }

    /// Collision-free pose with the hand at a point, pointing ahead.
    fn pose_reaching(&self, at: [f64; 3], solids: &[MovingSolid]) -> SceneResult<LimbPose> {
        let present = self.pose(0.0, -0.4, 1.2);
        let ends = [0.0, 1.0].map(|time_s| LimbState { pose: present, time_s });
        let problem = Problem::prepare(&self.spec(ends, solids))?;
        let target = Rigid { position: DVec3::from(at), rotation: rotation_about(DVec3::Y, -1.3) };
        problem.solve_reach(&mut Checker::default(), &target, 0.5, &present).map_err(|e| e.to_string().into())
    }
}

fn solid(name: &str, shape: SolidShape, at: DVec3) -> MovingSolid {
    MovingSolid { name: name.into(), shape, path: RigidPath::Still(Rigid::from_position(at)) }
}

fn states(ends: [(LimbPose, f64); 2]) -> [LimbState; 2] {
    ends.map(|(pose, time_s)| LimbState { pose, time_s })
}

/// An arm moves from below a table to above it.
fn table() -> PlanScene {
    let actor = SceneActor::standing(1.5);
    let plate = SolidShape::cuboid(DVec3::new(0.9, 0.03, 0.6));
    let ends = states([(actor.pose(0.0, -1.2, 0.2), 0.0), (actor.pose(0.0, 0.1, 0.3), 1.5)]);
    let solids = vec![solid("table", plate, DVec3::new(0.65, 1.2, 0.55))];
    PlanScene { actor, solids, allowed: Vec::new(), ends }
}

/// Triangles of a ball: `rings` rings, each of twice as many segments (m).
fn ball(rings: usize, radius: f64) -> Vec<[Vec3; 3]> {
    let at = |i: usize, j: usize| {
        let (a, b) = (std::f64::consts::PI * i as f64 / rings as f64, std::f64::consts::PI * j as f64 / rings as f64);
        (DVec3::new(a.sin() * b.cos(), a.cos(), a.sin() * b.sin()) * radius).as_vec3()
    };
    let squares = (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j)));
    squares.flat_map(|(i, j)| halves_of_square(at, i, j)).collect()
}

/// The two triangles of a square of a grid of points.
fn halves_of_square(at: impl Fn(usize, usize) -> Vec3, i: usize, j: usize) -> [[Vec3; 3]; 2] {
    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
    [[a, b, c], [a, c, d]]
}

/// Heights of the boards of the shelf (m).
const BOARD_HEIGHTS_M: [f64; 3] = [1.05, 1.35, 1.65];

/// Boards of a shelf in front of the body.
fn shelf_boards() -> Vec<MovingSolid> {
    let size = DVec3::new(1.2, 0.02, 0.4);
    let board = |(i, y)| solid(&format!("board {i}"), SolidShape::cuboid(size), DVec3::new(0.6, y, 0.62));
    BOARD_HEIGHTS_M.into_iter().enumerate().map(board).collect()
}

/// An arm of seven degrees of freedom moves through shelves with objects, 26 000 triangles, for comparison with planners
/// without time.
fn arm_static() -> SceneResult<PlanScene> {
    let (mut triangles, mut solids) = (Vec::new(), shelf_boards());
    for y in BOARD_HEIGHTS_M {
        for k in 0..3 {
            let at = DVec3::new(0.25 + 0.35 * f64::from(k), y + 0.07, 0.6).as_vec3();
            triangles.extend(ball(27, 0.05).into_iter().map(|t| t.map(|p| p + at)));
        }
    }
    solids.push(solid("things", SolidShape::Mesh(Arc::new(TriangleMesh::new(triangles)?)), DVec3::ZERO));
    PlanScene::between_boards(solids)
}

/// An arm moves between the ends of `arm-static`, among 40 balls and the boards.
fn spheres() -> SceneResult<PlanScene> {
    let mut solids = shelf_boards();
    for k in 0..40u32 {
        // Spread evenly over a box in front of the body by golden steps.
        let [a, b, c] = [0.618_034, 0.754_878, 0.569_840].map(|g: f64| (f64::from(k) * g).fract());
        let at = DVec3::new(0.05 + 1.1 * a, 0.95 + 0.9 * b, 0.55 + 0.3 * c);
        solids.push(solid(&format!("ball {k}"), SolidShape::ball(0.03), at));
    }
    PlanScene::between_boards(solids)
}

/// A hand reaches through a ring of 20 000 triangles that moves.
fn ring() -> SceneResult<PlanScene> {
    let who = SceneActor::standing(1.5);
    let n = 100;
    let at = |i: usize, j: usize| {
        let turn = std::f64::consts::TAU / f64::from(n as u32);
        let (a, b) = (turn * i as f64, turn * j as f64);
        let out = 0.2 + 0.02 * b.cos();
        DVec3::new(out * a.cos(), out * a.sin(), 0.02 * b.sin()).as_vec3()
    };
    let triangles = (0..n * n).flat_map(|k| halves_of_square(at, k % n, k / n));
    let mesh = Arc::new(TriangleMesh::new(triangles.collect())?);
    let ends = states([(who.pose(0.3, -0.9, 1.8), 0.0), (who.pose(-0.1, 0.0, 0.2), 1.5)]);
    let placed = Problem::prepare(&who.spec(ends, &[]))?.place_chain(&ends[1]);
    let along = (placed[2].position - placed[1].position).normalize();
    let rotation: DQuat = rotation_between(DVec3::Z, along);
    let key = |i: u32| {
        let t = f64::from(i) * 0.05;
        let sway = rotation * DVec3::new(0.25 * (5.0 * (t - 1.5)).sin(), 0.1 * (1.5 - t), 0.0);
        (t, Rigid { position: placed[2].position - along * 0.08 + sway, rotation })
    };
    let keys: Vec<(f64, Rigid)> = (0..=30).map(key).collect();
    let solids =
        vec![MovingSolid { name: "ring".into(), shape: SolidShape::Mesh(mesh), path: RigidPath::from_keys(&keys) }];
    Ok(PlanScene { actor: who, solids, allowed: Vec::new(), ends })
}

/// A walker whose arm swings through a post of 30 000 triangles beside the path.
fn walk() -> SceneResult<PlanScene> {
    let config = SynthConfig { minutes: 0.2, clip_seconds: 12.0, ..SynthConfig::default() };
    let set = make_set(SynthSet::Walk, &config)?;
    let who = SceneActor::from_clip(set.skeleton, set.clips[0].clone());
    let at = |t: f64| LimbState { pose: who.motion.limb_pose(who.limb, t), time_s: t };
    let ends = [at(3.0), at(5.0)];
    let free = Problem::prepare(&who.spec(ends, &[]))?;
    let hand = free.place_chain(&at(4.0));
    // The post stands where the hand passes, on its outer side.
    let aside = (hand[0].position - free.base_at(4.0).position).with_y(0.0).normalize();
    let post = hand[2].position + aside * 0.02;
    let triangles = ball(87, 0.05).into_iter().map(|t| t.map(|p| p * Vec3::new(1.0, 12.0, 1.0)));
    let mesh = Arc::new(TriangleMesh::new(triangles.collect())?);
    // Only the arm has to avoid it.
    let others = Joint::ALL.into_iter().filter(|j| who.limb.index_of(*j).is_none());
    let allowed =
        others.map(|j| AllowedContact { part: Some(j.name().into()), other: "post".into(), window_s: None }).collect();
    Ok(PlanScene { actor: who, solids: vec![solid("post", SolidShape::Mesh(mesh), post)], allowed, ends })
}
