//! Reactions: a body part that is struck gives way in the direction of the blow and comes back (Lee and Lee 2004, section 6).
//!
//! A push is a short force on a critically damped spring, so that place and velocity stay continuous. Two springs,
//! kept in world space, stand for the body: the *trunk*, which is shared out between a shift of the hips over the
//! ground and a bend of the spine, and the *head*, on top of it. Inverse kinematics moves the joints there: the spine
//! and the neck bend, arms follow the trunk, and the legs reach from the hips to where the feet were.

use super::hierarchy::{ModelPose, PARENTS};
use super::lane_body::{LEGS, LaneBody};
use super::lanes::{Lane, Lane3, get_lane, load, set_lane, store};
use super::{lanewise::lanewise_fields, limbs::move_leg, placement::PlacementLanes};
use crate::skeleton::Joint;
use glam::Vec3;
use throng_base::simd::{LANES, Lanes, Q, V};
use throng_base::{Result, error::check_range, maths};

/// Settings of the reaction of struck characters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReactionConfig {
    /// False leaves bodies as the clips move them.
    pub enabled: bool,
    /// Time in which a displacement halves, from its peak, which is reached after about three quarters of this time.
    /// (s, 0.001 to 10)
    pub half_life_s: f32,
    /// Largest displacement of the head over the trunk, and of the trunk (m, 0 to 1).
    pub max_displacement_m: f32,
    /// Share of a blow to the head that moves the trunk (0 to 1).
    pub trunk_share: f32,
    /// Share of the trunk's displacement over the ground that moves the hips (0 to 1).
    pub hips_share: f32,
    /// Share of a blow to an arm or leg that moves the trunk (0 to 1).
    pub limb_share: f32,
}

impl Default for ReactionConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            half_life_s: 0.12,
            max_displacement_m: 0.15,
            trunk_share: 0.4,
            hips_share: 0.4,
            limb_share: 0.3,
        }
    }
}

impl ReactionConfig {
    pub(crate) fn check(&self) -> Result<()> {
        check_range("reaction.half_life_s", self.half_life_s, 1e-3..=10.0, "between 0.001 and 10")?;
        for (what, got) in [
            ("reaction.max_displacement_m", self.max_displacement_m),
            ("reaction.trunk_share", self.trunk_share),
            ("reaction.hips_share", self.hips_share),
            ("reaction.limb_share", self.limb_share),
        ] {
            check_range(what, got, 0.0..=1.0, "between 0 and 1")?;
        }
        Ok(())
    }

    /// Decay rate of the spring (1/s).
    fn rate(&self) -> f32 {
        HALF_TIME / self.half_life_s
    }
}

/// Decay rate of the force of a push over that of the spring.
const FORCE_RATE: f32 = 4.0;
/// Time from the peak to half of it, of a spring of rate 1 after a force that fades at [`FORCE_RATE`].
const HALF_TIME: f32 = 1.694_567;
/// Force that gives a peak of 1, for the same spring.
const FORCE: f32 = 11.308_286;
/// Largest displacement that a velocity of 1 leads to, for the same spring: 1 / e.
const REACH_OF_VELOCITY: f32 = 0.367_879_44;
/// Displacement below which a spring is at rest (m).
const AT_REST_M: f32 = 1e-4;
/// Bounds that displacements and their velocities never reach, whatever the config (m, m/s).
const FARTHEST_M: f32 = 1e3;
const FASTEST_MPS: f32 = 1e4;
/// Turn of the face away from a displacement of the head (rad/m).
const TURN_RAD_PER_M: f32 = 4.0;
/// Joints that a reaction turns or carries: hips, spine, neck, head and both arms.
const NUM_UPPER: usize = Joint::RightHand.index() + 1;

/// A spring of each of eight characters, in world space.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize, bytemuck::Zeroable)]
pub(crate) struct ReactionSpring {
    /// (m)
    pub place: Lane3,
    /// (m/s)
    pub velocity: Lane3,
    /// Force by mass (m/s^2).
    pub force: Lane3,
}

impl ReactionSpring {
    const ZERO: Self = Self { place: [[0.0; LANES]; 3], velocity: [[0.0; LANES]; 3], force: [[0.0; LANES]; 3] };

    /// Adds a force that displaces one lane, as far as the limit allows.
    fn push(&mut self, lane: usize, config: &ReactionConfig, displacement: Vec3) {
        let length = displacement.length();
        if length < 1e-6 {
            return;
        }
        let (direction, rate) = (displacement / length, config.rate());
        // No more than what the spring does already and may still do in this direction, together.
        let along = |v: &Lane3| get_lane(v, lane).dot(direction).max(0.0);
        let ahead = along(&self.place)
            + along(&self.velocity) * (REACH_OF_VELOCITY / rate)
            + along(&self.force) / (FORCE * rate * rate);
        let most = (config.max_displacement_m - ahead).max(0.0);
        let force = get_lane(&self.force, lane) + direction * (length.min(most) * FORCE * rate * rate);
        set_lane(&mut self.force, lane, force);
    }

    /// Moves on, exactly; returns the new place and the squared size of what is left (m, m^2).
    #[inline(always)]
    fn step<F: Lanes>(&mut self, s: &ReactionStep) -> (V<F>, F) {
        let (x, v, f) = (load::<F>(&self.place), load::<F>(&self.velocity), load::<F>(&self.force));
        let forced = f * F::splat(s.forced);
        let free = x - forced;
        let slope = v + forced * F::splat(FORCE_RATE * s.rate) + free * F::splat(s.rate);
        let line = free + slope * F::splat(s.dt_s);
        let forced = forced * F::splat(s.keep_force);
        let place = forced + line * F::splat(s.keep);
        let velocity = (slope - line * F::splat(s.rate)) * F::splat(s.keep) - forced * F::splat(FORCE_RATE * s.rate);
        let force = f * F::splat(s.keep_force);
        store(&mut self.place, place);
        store(&mut self.velocity, velocity);
        store(&mut self.force, force);
        let (per_rate, per_rate2) = (F::splat(1.0 / s.rate), F::splat(1.0 / (s.rate * s.rate)));
        let (v, f) = (velocity * per_rate, force * per_rate2);
        (place, place.dot(place) + v.dot(v) + f.dot(f))
    }

    /// Stops lanes where `size` is below that of a spring at rest.
    #[inline(always)]
    fn stop<F: Lanes>(&mut self, size: F) {
        let (rest, zero) = (F::splat(AT_REST_M * AT_REST_M), V::splat(Vec3::ZERO));
        for v in [&mut self.place, &mut self.velocity, &mut self.force] {
            let kept = V::select_lt(size, rest, zero, load::<F>(v));
            store(v, kept);
        }
    }
}

/// Effect of a tick on every spring: `x'' + 2 r x' + r^2 x = f`, `f' = -4 r f`, solved in closed form.
pub(crate) struct ReactionStep {
    dt_s: f32,
    rate: f32,
    keep: f32,
    keep_force: f32,
    /// Place of the forced solution, per force (s^2).
    forced: f32,
}

impl ReactionStep {
    pub fn new(config: &ReactionConfig, dt_s: f32) -> Self {
        let rate = config.rate();
        let gap = (FORCE_RATE - 1.0) * rate;
        let keep = |rate: f32| maths::exp(-rate * dt_s);
        Self { dt_s, rate, keep: keep(rate), keep_force: keep(FORCE_RATE * rate), forced: 1.0 / (gap * gap) }
    }
}

/// The reactions of eight characters.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Reaction {
    /// 1 where a character reacts, else 0.
    pub(crate) active: Lane,
    /// Spring of the upper trunk.
    pub(crate) trunk: ReactionSpring,
    /// Spring of the head, relative to the trunk.
    pub(crate) head: ReactionSpring,
}

impl Reaction {
    pub const ZERO: Self = Self { active: [0.0; LANES], trunk: ReactionSpring::ZERO, head: ReactionSpring::ZERO };

    /// True where a lane is displaced as bodies are, not as what is damaged.
    pub(crate) fn is_moderate(&self, lane: usize) -> bool {
        let is_moderate = |s: &ReactionSpring| {
            get_lane(&s.place, lane).abs().max_element() < FARTHEST_M
                && get_lane(&s.velocity, lane).abs().max_element() < FASTEST_MPS
        };
        is_moderate(&self.trunk) && is_moderate(&self.head)
    }
}

/// True where any lane reacts.
#[inline(always)]
pub(crate) fn any_lane_reacts<F: Lanes>(reaction: &Reaction) -> bool {
    F::load(&reaction.active).any_gt(F::splat(0.5))
}

/// Pushes a joint of one lane (m).
pub(crate) fn push(reaction: &mut Reaction, lane: usize, config: &ReactionConfig, joint: Joint, displacement: Vec3) {
    use Joint::*;
    let (trunk, head) = match joint {
        Head | Neck => (config.trunk_share, 1.0 - config.trunk_share),
        Hips | Spine | Chest | UpperChest | LeftClavicle | RightClavicle => (1.0, 0.0),
        _ => (config.limb_share, 0.0),
    };
    reaction.trunk.push(lane, config, displacement * trunk);
    reaction.head.push(lane, config, displacement * head);
    reaction.active[lane] = 1.0;
}

/// Moves the springs on and the bodies with them. Lanes that do not react keep their pose to the last bit.
#[inline(always)]
pub(crate) fn react_lanes<F: Lanes>(
    body: &LaneBody,
    config: &ReactionConfig,
    step: &ReactionStep,
    place: &PlacementLanes<F>,
    reaction: &mut Reaction,
    pose: &mut ModelPose<F>,
) {
    let (trunk, trunk_size) = reaction.trunk.step::<F>(step);
    let (head, head_size) = reaction.head.step::<F>(step);
    let (size, active) = (trunk_size + head_size, F::load(&reaction.active));
    // Displacements of upper trunk and head in model space (m).
    let (trunk, head) = (place.vector_to_model(trunk), place.vector_to_model(head));
    let share = F::splat(config.hips_share);
    let hips = V::new(trunk.x * share, F::splat(0.0), trunk.z * share);
    let turns = upper_turns(body, trunk - hips, head, pose);
    let half = F::splat(0.5);
    let old = pose.positions;
    for j in 0..NUM_UPPER {
        let q = turns[j] * pose.rotations[j];
        let (was, parent) = (pose.rotations[j], PARENTS[j]);
        pose.rotations[j] = Q::new(V::select_lt(half, active, q.v, was.v), F::select_lt(half, active, q.w, was.w));
        let carried =
            if j == 0 { old[0] + hips } else { pose.positions[parent] + turns[parent].rotate(old[j] - old[parent]) };
        pose.positions[j] = V::select_lt(half, active, carried, old[j]);
    }
    // The feet stay: legs move with the hips, then reach back.
    let hips = V::select_lt(half, active, hips, V::splat(Vec3::ZERO));
    for (side, leg) in LEGS.into_iter().enumerate() {
        for j in leg.map(Joint::index) {
            pose.positions[j] = V::select_lt(half, active, old[j] + hips, old[j]);
        }
        move_leg(body, side, V::splat(Vec3::ZERO) - hips, pose);
    }
    reaction.trunk.stop(size);
    reaction.head.stop(size);
    let (rest, zero) = (F::splat(AT_REST_M * AT_REST_M), F::splat(0.0));
    F::select_lt(size, rest, zero, active).store(&mut reaction.active);
}

/// Turn of every joint of the upper body, in model space, that brings neck and head to their targets.
///
/// - `by`: displacement of the neck's base from the hips (m).
/// - `head`: displacement of the head (m).
#[inline(always)]
fn upper_turns<F: Lanes>(body: &LaneBody, by: V<F>, head: V<F>, pose: &ModelPose<F>) -> [Q<F>; NUM_UPPER] {
    use Joint::*;
    let p = &pose.positions;
    let at = |j: Joint| p[j.index()];
    let none = Q::new(V::splat(Vec3::ZERO), F::splat(1.0));

    // Three joints of the spine, bent alike, carry the base of the neck.
    let links = [at(Chest) - at(Spine), at(UpperChest) - at(Chest), at(Neck) - at(UpperChest)];
    let spine = bend(links, by);
    // Neck and head, bent alike, carry the middle of the head; the face turns away with the blow.
    let turned = pose.rotations[Head.index()];
    let centre = turned.rotate(load(&body.head_centre));
    let face = turned.rotate(V::splat(Vec3::Z));
    let away = turn(face.cross(head) * F::splat(TURN_RAD_PER_M));
    let carry = spine[2];
    let links = [carry.rotate(at(Head) - at(Neck)), (away * carry).rotate(centre)];
    let straight = at(Head) - at(Neck) + centre;
    let neck = bend(links, head + straight - links[0] - links[1]);

    let mut turns = [none; NUM_UPPER];
    for j in Joint::ALL.into_iter().take(NUM_UPPER) {
        turns[j.index()] = match j {
            Hips => none,
            Spine => spine[0],
            Chest => spine[1],
            Neck => neck[0] * carry,
            Head => neck[1] * away * carry,
            _ => carry,
        };
    }
    turns
}

/// Newton steps of [`bend`]: the first is off by a few percent of a large displacement, the third by less than the
/// captured motion is.
const NEWTON_STEPS: usize = 3;

/// Turns each link of a chain by the same angle more than the one before it, so that the chain's end moves by `by`, as
/// far as links that keep their lengths can (m).
#[inline(always)]
fn bend<F: Lanes, const N: usize>(links: [V<F>; N], by: V<F>) -> [Q<F>; N] {
    let (mut straight, mut angle, mut bent) = (V::splat(Vec3::ZERO), V::splat(Vec3::ZERO), links);
    for link in links {
        straight = straight + link;
    }
    let aim = straight + by;
    let mut turns = [turn(angle); N];
    for _ in 0..NEWTON_STEPS {
        // The lever of a turn that is shared alike: the sum of all joints' ways to the end.
        let (mut way, mut lever) = (V::splat(Vec3::ZERO), V::splat(Vec3::ZERO));
        for link in bent.iter().rev() {
            way = way + *link;
            lever = lever + way;
        }
        let off = aim - way;
        angle = angle + lever.cross(off) * (F::splat(1.0) / lever.dot(lever).max(F::splat(1e-6)));
        let one = turn(angle);
        let mut all = one;
        for (i, t) in turns.iter_mut().enumerate() {
            *t = all;
            bent[i] = all.rotate(links[i]);
            all = one * all;
        }
    }
    turns
}

/// The rotation by a small vector (rad).
#[inline(always)]
fn turn<F: Lanes>(angle: V<F>) -> Q<F> {
    Q::from_mrp(angle * F::splat(0.25))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use throng_base::simd::ArrayLanes;

    /// The reaction of a trunk that was pushed.
    pub fn reaction_to_push(config: &ReactionConfig, by: Vec3) -> Reaction {
        let mut reaction = Reaction::ZERO;
        push(&mut reaction, 0, config, Joint::Chest, by);
        reaction
    }

    /// Displacement of the trunk after another time (m).
    pub fn trunk_after(reaction: &mut Reaction, config: &ReactionConfig, dt_s: f32) -> Vec3 {
        let (place, size) = reaction.trunk.step::<ArrayLanes>(&ReactionStep::new(config, dt_s));
        reaction.trunk.stop(size);
        Vec3::new(place.x.to_array()[0], place.y.to_array()[0], place.z.to_array()[0])
    }

    #[test]
    fn the_closed_form_is_that_of_the_spring() {
        let config = ReactionConfig { half_life_s: 0.15, ..ReactionConfig::default() };
        let rate = f64::from(config.rate());
        let mut reaction = reaction_to_push(&config, Vec3::Z * 0.1);
        let (mut x, mut v, mut f) = (0.0f64, 0.0, f64::from(reaction.trunk.force[2][0]));
        for step in 0..40 {
            let dt_s = 0.004 * (1 + step % 4) as f32;
            // Small Euler steps in double precision.
            let h = f64::from(dt_s) / 4000.0;
            for _ in 0..4000 {
                let a = f - 2.0 * rate * v - rate * rate * x;
                (x, v, f) = (x + h * v, v + h * a, f - h * f64::from(FORCE_RATE) * rate * f);
            }
            let got = trunk_after(&mut reaction, &config, dt_s).z;
            assert!((f64::from(got) - x).abs() < 2e-5, "{got} {x}");
        }
    }

    #[test]
    fn a_bent_chain_ends_where_it_should() {
        let links = [Vec3::new(0.0, 0.2, 0.01), Vec3::new(0.02, 0.15, 0.03), Vec3::new(0.0, 0.18, -0.02)];
        let by = Vec3::new(0.1, -0.03, 0.08);
        let turns = bend(links.map(V::<ArrayLanes>::splat), V::splat(by));
        let first = |f: ArrayLanes| f.to_array()[0];
        let end = links.iter().zip(turns).fold(Vec3::ZERO, |end, (&l, q)| {
            let l = q.rotate(V::splat(l));
            end + Vec3::new(first(l.x), first(l.y), first(l.z))
        });
        let want = links.iter().sum::<Vec3>() + by;
        assert!(end.distance(want) < 0.01, "{end} {want}");
    }
}

lanewise_fields!(ReactionSpring { place, velocity, force });
lanewise_fields!(Reaction { active, trunk, head } if is_moderate);
