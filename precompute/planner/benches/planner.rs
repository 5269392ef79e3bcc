//! What do inverse kinematics, a look at the world and a plan cost, and how often does it succeed?
//! `cargo bench -p throng-planner --bench planner`.

use glam::{DQuat, DVec3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;
use std::time::Instant;
use throng_core::{NUM_JOINTS, Skeleton};
use throng_planner::body::BodyShape;
use throng_planner::collide::{Checker, EdgeCheck};
use throng_planner::driven::Driven;
use throng_planner::ik::LimbIk;
use throng_planner::limits::{BodyLimits, Coordinates, Sampler, Style};
use throng_planner::linkage::{Chain, Limb, LimbPose, Linkage};
use throng_planner::planner::{Budget, PlanConfig, Planner};
use throng_planner::problem::{Problem, Solid, State};
use throng_planner::rotation::{Rigid, angle, exp};
use throng_planner::setup::{Allowed, ProblemSpec};
use throng_planner::shape::{Mesh, Shape};
use throng_planner::track::Path;
use throng_synth::{SynthConfig, SynthSet};

fn main() {
    // `cargo test` runs benches too: a short look is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    // Names of scenes leave out the others.
    let named: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    inverse_kinematics(if whole { 1_000_000 } else { 200 });
    let seeds = if whole { 100 } else { 2 };
    let s = Somebody::standing();
    let walking = Somebody::walking();
    for (name, problem) in
        [("table", table(&s)), ("arm-static", arm_static(&s)), ("ring", ring(&s)), ("walk", walk(&walking))]
    {
        if !named.is_empty() && !named.iter().any(|n| n == name) {
            continue;
        }
        checks(name, &problem, if whole { 400_000 } else { 100 });
        for (how, edge) in
            [("proved", EdgeCheck::Conservative), ("bisected", EdgeCheck::Bisection { resolution_rad: 0.02 })]
        {
            plans(name, how, &problem, edge, seeds);
        }
    }
}

struct Somebody {
    skeleton: Skeleton,
    limits: BodyLimits,
    motion: Driven,
    shape: BodyShape,
    linkage: Linkage,
}

impl Somebody {
    fn of(skeleton: Skeleton, motion: Driven) -> Self {
        let limits = BodyLimits::built_in(&skeleton);
        let shape = BodyShape::fitted(&skeleton);
        Self { skeleton, limits, motion, shape, linkage: Linkage::limb(Limb::LeftArm) }
    }

    fn standing() -> Self {
        let skeleton = Skeleton::default();
        let motion = Driven::still(&skeleton, skeleton.offsets[0].as_dvec3(), [DQuat::IDENTITY; NUM_JOINTS]);
        Self::of(skeleton, motion)
    }

    fn walking() -> Self {
        let config = SynthConfig { minutes: 0.2, clip_seconds: 12.0, ..SynthConfig::default() };
        let set = throng_synth::make(SynthSet::Walk, &config).expect("a walk");
        let motion = Driven::of_clip(&set.clips[0], &set.skeleton, 0.0, 10.0);
        Self::of(set.skeleton, motion)
    }

    fn pose(&self, across: f64, up: f64, flexion: f64) -> LimbPose {
        let limits = self.limits.of_linkage(self.linkage).expect("limits");
        let mut pose = LimbPose::REST;
        pose.0[0] = limits[0].rotation(Coordinates { swing: [across, up], twist: 0.0 });
        pose.0[1] = limits[1].rotation(Coordinates { swing: [flexion, 0.0], twist: 0.0 });
        pose
    }

    /// The pose that puts the hand somewhere, pointing ahead, past what is in the way.
    fn reaching(&self, at: [f64; 3], solids: &[Solid]) -> LimbPose {
        let present = self.pose(0.0, -0.4, 1.2);
        let ends = [0.0, 1.0].map(|time_s| State { pose: present, time_s });
        let spec = ProblemSpec::new(&self.skeleton, self.linkage, &self.limits, &self.motion, &self.shape, ends);
        let problem = Problem::prepare(&ProblemSpec { solids, ..spec }).unwrap_or_else(|e| panic!("{e}"));
        let ahead = throng_planner::rotation::about(DVec3::Y, -1.3);
        let target = Rigid { position: DVec3::from(at), rotation: ahead };
        problem.reach(&mut Checker::default(), &target, 0.5, &present).unwrap_or_else(|e| panic!("{e}"))
    }

    fn problem(&self, ends: [(LimbPose, f64); 2], solids: &[Solid], allowed: &[Allowed]) -> Problem {
        let ends = ends.map(|(pose, time_s)| State { pose, time_s });
        let spec = ProblemSpec::new(&self.skeleton, self.linkage, &self.limits, &self.motion, &self.shape, ends);
        Problem::new(&ProblemSpec { solids, allowed, admit_ends: true, ..spec }).unwrap_or_else(|e| panic!("{e}"))
    }
}

fn solid(name: &str, shape: Shape, at: DVec3) -> Solid {
    Solid { name: name.into(), shape, path: Path::Still(Rigid::at(at)) }
}

/// From below a table to above it.
fn table(s: &Somebody) -> Problem {
    let plate = Shape::cuboid(DVec3::new(0.9, 0.03, 0.6));
    let ends = [(s.pose(0.0, -1.2, 0.2), 0.0), (s.pose(0.0, 0.1, 0.3), 1.5)];
    s.problem(ends, &[solid("table", plate, DVec3::new(0.65, 1.2, 0.55))], &[])
}

/// A ball of triangles: rings by twice as many (m).
fn ball(rings: usize, radius: f64) -> Vec<[Vec3; 3]> {
    let at = |i: usize, j: usize| {
        let (a, b) = (std::f64::consts::PI * i as f64 / rings as f64, std::f64::consts::PI * j as f64 / rings as f64);
        (DVec3::new(a.sin() * b.cos(), a.cos(), a.sin() * b.sin()) * radius).as_vec3()
    };
    let squares = (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j)));
    squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// Seven degrees of freedom through shelves with things on them, 26 000 triangles, and more time than it takes, for comparison with planners that know none.
fn arm_static(s: &Somebody) -> Problem {
    let mut triangles = Vec::new();
    let mut things = Vec::new();
    for (i, y) in [1.05, 1.35, 1.65].into_iter().enumerate() {
        things.push(solid(&format!("board {i}"), Shape::cuboid(DVec3::new(1.2, 0.02, 0.4)), DVec3::new(0.6, y, 0.62)));
        for k in 0..3 {
            let at = DVec3::new(0.25 + 0.35 * f64::from(k), y + 0.07, 0.6).as_vec3();
            triangles.extend(ball(27, 0.05).into_iter().map(|t| t.map(|p| p + at)));
        }
    }
    println!("arm-static: {} triangles", triangles.len());
    let mesh = Arc::new(Mesh::new(triangles).expect("a mesh"));
    things.push(solid("things", Shape::Mesh(mesh), DVec3::ZERO));
    let ends = [(s.reaching([0.36, 1.24, 0.4], &things), 0.0), (s.reaching([0.36, 1.5, 0.42], &things), 30.0)];
    s.problem(ends, &things, &[])
}

/// A hand reaches through a ring of 20 000 triangles that moves.
fn ring(s: &Somebody) -> Problem {
    let n = 100;
    let at = |i: usize, j: usize| {
        let turn = std::f64::consts::TAU / f64::from(n as u32);
        let (a, b) = (turn * i as f64, turn * j as f64);
        let out = 0.2 + 0.02 * b.cos();
        DVec3::new(out * a.cos(), out * a.sin(), 0.02 * b.sin()).as_vec3()
    };
    let squares = (0..n * n).map(|k| (k % n, k / n));
    let triangles = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    let mesh = Arc::new(Mesh::new(triangles.collect()).expect("a mesh"));
    let ends = [(s.pose(0.3, -0.9, 1.8), 0.0), (s.pose(-0.1, 0.0, 0.2), 1.5)];
    let free = s.problem(ends, &[], &[]);
    let placed = free.place(free.goal());
    let along = (placed[2].position - placed[1].position).normalize();
    let rotation = throng_planner::rotation::between(DVec3::Z, along);
    let keys: Vec<(f64, Rigid)> = (0..=30)
        .map(|i| {
            let t = f64::from(i) * 0.05;
            let sway = rotation * DVec3::new(0.25 * (5.0 * (t - 1.5)).sin(), 0.1 * (1.5 - t), 0.0);
            (t, Rigid { position: placed[2].position - along * 0.08 + sway, rotation })
        })
        .collect();
    s.problem(ends, &[Solid { name: "ring".into(), shape: Shape::Mesh(mesh), path: Path::keys(&keys) }], &[])
}

/// A walker whose arm swings through a post of 30 000 triangles beside the path.
fn walk(s: &Somebody) -> Problem {
    let at = |t: f64| State { pose: s.motion.limb_pose(s.linkage, t), time_s: t };
    let ends = [3.0, 5.0].map(|t| (at(t).pose, t));
    let free = s.problem(ends, &[], &[]);
    let hand = free.place(&at(4.0));
    // Where the hand comes by, from outside, along the body's side.
    let aside = (hand[0].position - free.base_at(4.0).position).with_y(0.0).normalize();
    let post = hand[2].position + aside * 0.02;
    let triangles = ball(87, 0.05).into_iter().map(|t| t.map(|p| p * Vec3::new(1.0, 12.0, 1.0)));
    let mesh = Arc::new(Mesh::new(triangles.collect()).expect("a mesh"));
    println!("walk: {} triangles", mesh.corners().len());
    // Only the arm has to give way.
    let allowed: Vec<Allowed> = throng_core::Joint::ALL
        .into_iter()
        .filter(|j| s.linkage.position_of(*j).is_none())
        .map(|j| Allowed { part: Some(j.name().into()), with: "post".into(), window_s: None })
        .collect();
    s.problem(ends, &[solid("post", Shape::Mesh(mesh), post)], &allowed)
}

fn inverse_kinematics(poses: u32) {
    let s = Somebody::standing();
    for limb in [Limb::LeftArm, Limb::RightLeg] {
        let linkage = Linkage::limb(limb);
        let chain = Chain::new(linkage, &s.skeleton);
        let limits = s.limits.of_linkage(linkage).expect("limits");
        let ik = LimbIk::new(&chain, &limits);
        let sampler = Sampler::new(linkage, limits, &LimbPose::REST, Style::default(), 1);
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let (mut solved, mut far, mut turned, mut ns, mut near_ns) = (0u32, 0.0f64, 0.0f64, 0.0, 0.0);
        for _ in 0..poses {
            let v: [f64; 3] = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
            let base = Rigid { position: DVec3::from(v), rotation: exp(DVec3::from(v)) };
            let (wanted, present) = (sampler.draw(&mut rng, 1), sampler.draw(&mut rng, 1));
            let goal = chain.place(&base, &wanted)[2];
            let began = Instant::now();
            let found = ik.solve_free(&base, &goal, &present);
            ns += began.elapsed().as_secs_f64() * 1e9;
            let began = Instant::now();
            std::hint::black_box(ik.solve_free(&base, &goal, &wanted).is_ok());
            near_ns += began.elapsed().as_secs_f64() * 1e9;
            if let Ok(pose) = found {
                solved += 1;
                let hand = chain.place(&base, &pose)[2];
                far = far.max(hand.position.distance(goal.position));
                turned = turned.max(angle(hand.rotation, goal.rotation));
            }
        }
        let n = f64::from(poses);
        println!(
            "ik {}: {:.0} ns from any swivel, {:.0} ns from a good one (clock included), solved {:.6}, error {far:.1e} m {turned:.1e} rad",
            limb.name(),
            ns / n,
            near_ns / n,
            f64::from(solved) / n
        );
    }
}

/// Poses at random against everything.
fn checks(name: &str, problem: &Problem, count: u32) {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let sampler = Sampler::new(problem.chain().linkage, *problem.limits(), &LimbPose::REST, Style::default(), 1);
    let [from, to] = [problem.init().time_s, problem.goal().time_s];
    let states: Vec<State> =
        (0..1000).map(|_| State { pose: sampler.draw(&mut rng, 1), time_s: rng.random_range(from..to) }).collect();
    let mut checker = Checker::default();
    let mut free = 0u32;
    let began = Instant::now();
    for i in 0..count {
        free += u32::from(checker.is_free(problem, &states[i as usize % states.len()]));
    }
    let ns = began.elapsed().as_secs_f64() * 1e9 / f64::from(count);
    println!("{name}: {ns:.0} ns a check of a pose at random, {:.2} of them free", f64::from(free) / f64::from(count));
}

fn plans(name: &str, how: &str, problem: &Problem, edge: EdgeCheck, seeds: u64) {
    let mut planner = Planner::new();
    let mut config = PlanConfig::default();
    config.search.edge = edge;
    let mut solved = Vec::new();
    let (mut checks, mut seconds) = (0, 0.0);
    for seed in 0..seeds {
        let outcome = planner.plan(problem, &config, &Budget { seed, ..Budget::default() });
        checks += outcome.checks;
        seconds += outcome.total_s;
        if outcome.is_solved() {
            solved.push(outcome);
        }
    }
    let rank = |mut all: Vec<f64>, share: f64| {
        all.sort_by(f64::total_cmp);
        all.get((share * all.len() as f64) as usize).or(all.last()).copied().unwrap_or(f64::NAN)
    };
    let first = |share| rank(solved.iter().map(|o| o.first_solution_s * 1e3).collect(), share);
    let total = |share| rank(solved.iter().map(|o| o.total_s * 1e3).collect(), share);
    let median = |f: fn(&throng_planner::planner::Outcome) -> f64| rank(solved.iter().map(f).collect(), 0.5);
    println!(
        "{name}, {how}: {} of {seeds}; first {:.2} ms (p95 {:.2}), total {:.2} ms (p95 {:.2}), {:.0} nodes, {:.0} ns a check in plans; \
         {:.2} rad, jerk {:.2} of before, fastest {:.1} rad/s",
        solved.len(),
        first(0.5),
        first(0.95),
        total(0.5),
        total(0.95),
        median(|o| o.nodes as f64),
        seconds * 1e9 / checks as f64,
        median(|o| o.roughness[1].length_rad),
        median(|o| o.roughness[1].jerk_rms / o.roughness[0].jerk_rms.max(1e-9)),
        median(|o| o.roughness[1].speed_max),
    );
}
