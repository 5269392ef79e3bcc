//! Checks and prepares problems.

use super::{AllowedContact, ProblemError, ProblemSpec, Tether};
use crate::body::{BodyCapsule, BodyCapsules};
use crate::linkage::{Chain, LIMB_JOINTS, Limb};
use crate::problem::{
    BodyPart, CollisionPair, CollisionTarget, EXTERNAL_STEP_S, LimbPart, MovingSolid, PlacedSolid, Problem, TetherTrack,
};
use crate::{collide::Checker, correct::CollisionStretch, driven::DrivenMotion, limits::JointLimits};
use crate::{rotation::Rigid, track::MotionTrack};
use glam::DVec3;
use std::sync::atomic::{AtomicU64, Ordering};
use std::{f64::consts::PI, fmt::Arguments};
use throng_base::text::did_you_mean;
use throng_core::Joint;
use throng_geometry::Segment;

/// Interval at which the driven part is checked for collisions (s).
const DRIVEN_STEP_S: f64 = 1.0 / 60.0;
/// Longest plan (s).
const MAX_SECONDS: f64 = 3600.0;
/// Tolerated excess of both ends over limits (rad).
const AT_LIMIT: f64 = 1e-4;

/// Number of the next problem; only cached collision samples depend on it.
static NUMBERS: AtomicU64 = AtomicU64::new(1);

impl Problem {
    /// Checks a problem and prepares it.
    ///
    /// # Errors
    /// [`ProblemError`]: invalid numbers, driven parts that collide by themselves, ends that collide or are outside limits, too
    /// little time.
    pub fn new(spec: &ProblemSpec<'_>) -> Result<Self, ProblemError> {
        let problem = Self::prepare(spec)?;
        if !spec.admit_driven {
            problem.check_driven(spec)?;
        }
        problem.check_ends()?;
        Ok(problem)
    }

    /// Prepares a problem without checking its ends, so that these can be searched: whether they are free, or which pose
    /// reaches a target.
    ///
    /// # Errors
    /// [`ProblemError`]: invalid numbers, unknown names.
    pub fn prepare(spec: &ProblemSpec<'_>) -> Result<Self, ProblemError> {
        check_numbers(spec)?;
        Self::check_names(spec)?;
        let chain = Chain::new(spec.limb, spec.skeleton);
        let mut parts = limb_parts(spec, &chain);
        parts.extend(spec.held.iter().map(|h| limb_part(&chain, h.name.clone(), 2, h.core, h.radius)));
        let tether = spec.tether.map(|t| {
            let wrist = Segment::new(t.wrist, t.wrist);
            parts.push(limb_part(&chain, "the other hand".into(), 2, wrist, 0.0));
            let name = format!("the reach from {}", t.from.name());
            let from = MotionTrack::rigid(spec.motion.clock(), spec.motion.joint_places(t.from));
            TetherTrack { name, from, distances_m: t.distances_m }
        });
        parts.extend(spec.upright.map(|level| {
            let up = Segment::new(DVec3::ZERO, level.up);
            let part = limb_part(&chain, "what is held".into(), 2, up, 0.0);
            LimbPart { reach: [1.0; LIMB_JOINTS], base_reach: 1.0, ..part }
        }));
        let solids = spec.solids.iter().map(|solid| {
            let (middle, radius) = solid.shape.ball_around();
            PlacedSolid { solid: solid.clone(), middle, radius, reach: middle.length() + radius }
        });
        let mut bodies = driven_parts(None, spec.motion, spec.shape, |j| chain_link(&chain, j).is_none());
        bodies.extend(spec.others.iter().flat_map(|o| driven_parts(Some(o.name), o.motion, o.shape, |_| true)));
        let (start_s, goal_s) = (spec.init.time_s, spec.goal.time_s);
        let steps = ((goal_s - start_s) / EXTERNAL_STEP_S).ceil() as usize + 1;
        let present = (0..steps).map(|i| spec.motion.limb_pose(spec.limb, start_s + i as f64 * EXTERNAL_STEP_S));
        let mut problem = Self {
            number: NUMBERS.fetch_add(1, Ordering::Relaxed),
            chain,
            limits: limits_of(spec, &chain)?,
            base: MotionTrack::rigid(spec.motion.clock(), spec.motion.joint_places(spec.limb.base())),
            parts,
            solids: solids.collect(),
            bodies,
            tether,
            upright: spec.upright,
            pairs: Vec::new(),
            external_poses: present.collect(),
            init: spec.init,
            goal: spec.goal,
        };
        problem.pairs = problem.all_pairs(spec);
        Ok(problem)
    }

    /// Checks that every allowance names something.
    fn check_names(spec: &ProblemSpec<'_>) -> Result<(), ProblemError> {
        let joints = Joint::ALL.map(Joint::name);
        let parts: Vec<&str> = joints.into_iter().chain(spec.held.iter().map(|h| h.name.as_str())).collect();
        let solids = joints.into_iter().chain(spec.solids.iter().map(|s| s.name.as_str()));
        let targets: Vec<&str> = solids.chain(spec.others.iter().map(|o| o.name)).collect();
        for a in spec.allowed {
            let known = [(a.part.as_deref(), &parts), (Some(a.other.as_str()), &targets)];
            for (name, known) in known.into_iter().filter_map(|(name, known)| Some((name?, known))) {
                if !known.contains(&name) {
                    let meant = did_you_mean(name, known.iter().copied());
                    return Err(format!("allowed contact: there is no `{name}`.{meant}").into());
                }
            }
        }
        Ok(())
    }

    fn all_pairs(&self, spec: &ProblemSpec<'_>) -> Vec<CollisionPair> {
        let others_bend = spec.others.iter().map(|o| o.motion.bend_m(|_| true)).fold(0.0, f64::max);
        // The joint that carries the limb counts as trunk.
        let own_bend = spec.motion.bend_m(|j| Limb::ALL.iter().all(|l| !l.moves_joint(j)));
        let mut pairs = Vec::new();
        // Collisions of the other hand are checked for itself; here only its reach counts. An upright constraint has no body.
        let tether = self.tether.iter().map(|_| CollisionTarget::Tether);
        let asked: Vec<_> = tether.chain(self.upright.map(|_| CollisionTarget::Upright)).collect();
        let bodies = self.parts.len() - asked.len();
        let solids = (0..self.solids.len()).map(CollisionTarget::Solid);
        for target in solids.chain((0..self.bodies.len()).map(CollisionTarget::Body)) {
            for (i, part) in self.parts[..bodies].iter().enumerate() {
                let (with, gap) = match target {
                    CollisionTarget::Tether | CollisionTarget::Upright => continue,
                    CollisionTarget::Solid(s) => (self.solids[s].solid.name.as_str(), spec.clearance_m + own_bend),
                    CollisionTarget::Body(b) => match &self.bodies[b].character {
                        Some(who) => (who.as_str(), spec.clearance_m + own_bend + others_bend),
                        None => {
                            let joint = self.bodies[b].joint;
                            (joint.name(), own_bend + spec.motion.bend_m(|j| j == joint) - spec.self_press_m)
                        }
                    },
                };
                let allowance = spec.allowed.iter().find(|a| allows_contact(a, &part.name, with));
                let allowed = allowance.map(|a| a.window_s.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]));
                let always = allowed.is_some_and(|[a, b]| a <= spec.init.time_s && b >= spec.goal.time_s);
                let own = matches!(target, CollisionTarget::Body(b) if self.bodies[b].character.is_none());
                if !(always || own && self.touches_at_rest(spec, part, target)) {
                    pairs.push(CollisionPair { part: i, target, gap, allowed });
                }
            }
        }
        let more = asked.into_iter().enumerate();
        pairs.extend(more.map(|(i, target)| CollisionPair { part: bodies + i, target, gap: 0.0, allowed: None }));
        pairs
    }

    /// True for neighbours along the body, and for parts that overlap in the rest pose.
    fn touches_at_rest(&self, spec: &ProblemSpec<'_>, part: &LimbPart, target: CollisionTarget) -> bool {
        let CollisionTarget::Body(b) = target else { return false };
        let body = &self.bodies[b];
        let joints = self.chain.limb.joints();
        let joint = joints[part.link];
        // Clavicles have no capsules: upper arms are neighbours of the upper chest.
        let is_flesh = |j: &Joint| spec.shape.capsules.iter().any(|c| c.joint == *j);
        let carrier = |j: Joint| std::iter::successors(j.parent(), |p| p.parent()).find(is_flesh);
        if carrier(joint) == Some(body.joint) || carrier(body.joint) == Some(joint) {
            return true;
        }
        let rest = spec.skeleton.rest_positions();
        let at = |j: Joint| rest[j.index()].as_dvec3();
        let own = part.core.map(|p| p + at(joint));
        let overlaps = |c: &BodyCapsule| own.distance(&c.core.map(|p| p + at(c.joint))) < part.radius + c.radius;
        spec.shape.capsules.iter().any(|c| c.joint == body.joint && overlaps(c))
    }

    /// Checks that the joints that an external motion drives stay clear of solids and of other characters.
    fn check_driven(&self, spec: &ProblemSpec<'_>) -> Result<(), ProblemError> {
        let mut worst: Option<(f64, ProblemError)> = None;
        self.each_driven(spec, |joint, with, time_s, depth_m| {
            if depth_m > 0.0 && worst.as_ref().is_none_or(|(w, _)| depth_m > *w) {
                let (part, with) = (joint.name().into(), with());
                worst = Some((depth_m, ProblemError::DrivenCollides { part, with, time_s, depth_m }));
            }
        });
        worst.map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Stretches in which the driven part of the body collides by itself, each part with each thing apart, sampled 60 times a
    /// second from the start to the goal.
    pub fn driven_collisions(&self, spec: &ProblemSpec<'_>) -> Vec<CollisionStretch> {
        let mut spans: Vec<CollisionStretch> = Vec::new();
        self.each_driven(spec, |joint, with, time_s, depth_m| {
            if depth_m <= 0.0 {
                return;
            }
            let (part, with) = (joint.name().to_owned(), with());
            let is_same = |s: &CollisionStretch| s.part == part && s.with == with;
            match spans.iter_mut().rev().find(|s| is_same(s) && time_s - s.to_s < 1.5 * DRIVEN_STEP_S) {
                Some(span) => (span.to_s, span.depth_m) = (time_s, span.depth_m.max(depth_m)),
                None => spans.push(CollisionStretch { from_s: time_s, to_s: time_s, part, with, depth_m }),
            }
        });
        spans
    }

    /// Reports how deep each driven part is in each solid and each other character, time by time; where it is in none, or only
    /// by rounding, there is no call, or one with a depth of at most 0.
    ///
    /// - `tell`: receives the part, the obstacle's name, the time (s) and the depth (m).
    fn each_driven(&self, spec: &ProblemSpec<'_>, mut tell: impl FnMut(Joint, &dyn Fn() -> String, f64, f64)) {
        let [from, to] = [spec.init.time_s, spec.goal.time_s];
        let steps = ((to - from) / DRIVEN_STEP_S).ceil() as usize;
        for step in 0..=steps {
            let time_s = (from + step as f64 * DRIVEN_STEP_S).min(to);
            for body in self.bodies.iter().filter(|b| b.character.is_none()) {
                let core = body.track.sample_at(time_s);
                for solid in self.solids.iter().filter(|s| !may_touch(spec, body.joint, &s.solid.name, time_s)) {
                    let place = solid.solid.path.place_at(time_s);
                    let local = core.map(|p| place.local_point(p));
                    let gap = solid.solid.shape.distance(&local, body.radius) - body.radius;
                    tell(body.joint, &|| solid.solid.name.clone(), time_s, -gap);
                }
                let is_other = |who: &str| !may_touch(spec, body.joint, who, time_s);
                for other in self.bodies.iter().filter(|b| b.character.as_deref().is_some_and(is_other)) {
                    let gap = core.distance(&other.track.sample_at(time_s)) - body.radius - other.radius;
                    tell(body.joint, &|| other.name(), time_s, -gap);
                }
            }
        }
    }

    fn check_ends(&self) -> Result<(), ProblemError> {
        let joints = self.chain.limb.joints();
        let mut checker = Checker::default();
        for (end, state) in [("start", &self.init), ("goal", &self.goal)] {
            for i in 0..LIMB_JOINTS {
                let by_rad = self.limits[i].excess(state.pose.0[i]);
                if by_rad > AT_LIMIT {
                    return Err(ProblemError::EndOutOfLimits { end, joint: joints[i].name().into(), by_rad });
                }
            }
            if let Some(hit) = checker.deepest_hit(self, state) {
                let [part, with] = self.hit_names(&hit);
                return Err(ProblemError::EndCollides { end, part, with, depth_m: hit.depth_m });
            }
        }
        let (least_s, joint) = self.least_time(&self.init.pose, &self.goal.pose);
        let given_s = self.goal.time_s - self.init.time_s;
        if least_s > given_s {
            return Err(ProblemError::TooLittleTime { joint: joint.name().into(), least_s, given_s });
        }
        Ok(())
    }
}

fn may_touch(spec: &ProblemSpec<'_>, joint: Joint, with: &str, time_s: f64) -> bool {
    let open = |a: &AllowedContact| a.window_s.is_none_or(|[from, to]| (from..=to).contains(&time_s));
    spec.allowed.iter().any(|a| allows_contact(a, joint.name(), with) && open(a))
}

fn allows_contact(allowed: &AllowedContact, part: &str, with: &str) -> bool {
    allowed.part.as_ref().is_none_or(|p| p == part) && allowed.other == with
}

fn check_numbers(spec: &ProblemSpec<'_>) -> Result<(), ProblemError> {
    let check = |holds: bool, what: Arguments<'_>, expected: &str| {
        crate::refuse(!holds, format_args!("{what}: expected {expected}")).map_err(ProblemError::Invalid)
    };
    let [from, to] = [spec.init.time_s, spec.goal.time_s];
    let ascends = from.is_finite() && to.is_finite() && from < to && to - from <= MAX_SECONDS;
    check(ascends, format_args!("times {from} s to {to} s"), "the start before the goal, at most an hour")?;
    for (end, state) in [("start", &spec.init), ("goal", &spec.goal)] {
        let unit = |q: &glam::DQuat| q.is_finite() && (q.length() - 1.0).abs() < 1e-6;
        check(state.pose.0.iter().all(unit), format_args!("pose of the {end}"), "unit quaternions")?;
    }
    let (clearance_m, press_m) = (spec.clearance_m, spec.self_press_m);
    check((0.0..1.0).contains(&clearance_m), format_args!("clearance {clearance_m} m"), "0 to 1 m")?;
    check((0.0..0.2).contains(&press_m), format_args!("self_press {press_m} m"), "0 to 0.2 m")?;
    for MovingSolid { name, shape, path } in spec.solids {
        check(shape.is_valid(), format_args!("shape of `{name}`"), "finite numbers and positive sizes")?;
        let expected = "ascending times, finite places, unit rotations";
        check(path.is_valid(), format_args!("path of `{name}`"), expected)?;
    }
    let is_capsule =
        |core: &Segment, radius: f64| core.a.is_finite() && core.b.is_finite() && radius > 0.0 && radius < 10.0;
    let expected = "finite ends and a positive radius";
    for h in spec.held {
        check(is_capsule(&h.core, h.radius), format_args!("what is held: `{}`", h.name), expected)?;
    }
    if let Some(Tether { wrist: at, distances_m: [nearest, farthest], .. }) = spec.tether {
        let is_valid = at.is_finite() && 0.0 <= nearest && nearest < farthest;
        check(is_valid, format_args!("where the other hand is"), "a finite place and ascending distances")?;
    }
    if let Some(level) = spec.upright {
        let is_valid = (level.up.length() - 1.0).abs() < 1e-6 && level.within_rad > 0.0 && level.within_rad < PI;
        let expected = "a unit direction, and an angle of 0 to half a turn";
        check(is_valid, format_args!("what stays upright"), expected)?;
    }
    let shapes = spec.others.iter().map(|o| o.shape).chain([spec.shape]);
    for c in shapes.flat_map(|s| &s.capsules) {
        check(is_capsule(&c.core, c.radius), format_args!("capsule of {}", c.joint.name()), expected)?;
    }
    let is_valid = spec.motion.places().iter().flatten().all(Rigid::is_valid);
    check(is_valid, format_args!("the motion"), "finite places and unit rotations")
}

fn limits_of(spec: &ProblemSpec<'_>, chain: &Chain) -> Result<[JointLimits; LIMB_JOINTS], ProblemError> {
    let joints = chain.limb.joints();
    let Some(mut limits) = spec.limits.limb_limits(chain.limb) else {
        let missing = joints.into_iter().find(|j| spec.limits.joints[j.index()].is_none());
        let (joint, how) = (missing.unwrap_or(joints[0]).name(), "data/skeletons/README.md says how");
        return Err(format!("{joint} has no limits; add it to the limits file ({how})").into());
    };
    if spec.admit_ends {
        for i in 0..LIMB_JOINTS {
            limits[i] = limits[i].widened_to_admit(spec.init.pose.0[i]).widened_to_admit(spec.goal.pose.0[i]);
        }
    }
    Ok(limits)
}

/// Index of the joint of the chain that carries a joint of the body: its own, or the last one for ends of hands and feet.
fn chain_link(chain: &Chain, joint: Joint) -> Option<usize> {
    std::iter::successors(Some(joint), |j| j.parent()).find_map(|j| chain.limb.index_of(j))
}

/// Capsules of the body that move with the limb.
fn limb_parts(spec: &ProblemSpec<'_>, chain: &Chain) -> Vec<LimbPart> {
    let rest = spec.skeleton.rest_positions();
    let of = |c: &BodyCapsule| {
        let link = chain_link(chain, c.joint)?;
        let carrier = chain.limb.joints()[link];
        // Toes stay in their rest pose.
        let shift = (rest[c.joint.index()] - rest[carrier.index()]).as_dvec3();
        Some(limb_part(chain, c.joint.name().into(), link, c.core.map(|p| p + shift), c.radius))
    };
    spec.shape.capsules.iter().filter_map(of).collect()
}

fn limb_part(chain: &Chain, name: String, link: usize, core: Segment, radius: f64) -> LimbPart {
    let end = core.a.length().max(core.b.length());
    let reach = std::array::from_fn(|i| if i <= link { chain.longest_span(i, link) + end } else { 0.0 });
    let base_reach = chain.offsets[0].length() + reach[0];
    LimbPart { name, link, core, half_length: core.half_length(), radius, reach, base_reach }
}

fn driven_parts(
    of: Option<&str>,
    motion: &DrivenMotion,
    shape: &BodyCapsules,
    keep: impl Fn(Joint) -> bool,
) -> Vec<BodyPart> {
    let one = |c: &BodyCapsule| {
        let places = motion.places().iter().map(|p| c.core.map(|x| p[c.joint.index()].transform_point(x)));
        let track = MotionTrack::segment(motion.clock(), places.collect());
        // Ends that move in straight lines are never farther apart than at samples, but for rounding.
        let half_length = c.core.half_length() * (1.0 + 1e-9) + 1e-9;
        BodyPart { character: of.map(Into::into), joint: c.joint, track, half_length, radius: c.radius }
    };
    shape.capsules.iter().filter(|c| keep(c.joint)).map(one).collect()
}
