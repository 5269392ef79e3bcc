//! Answers: an order takes effect at once where motion that obeys it fits the motion that is played.
//!
//! Characters choose at the ends of segments, half a second apart. When an order asks for something else, a character may
//! leave its segment at once: for another action of the state it comes from, as far into it, or for any frame from which a
//! clip comes to a stand. Transitions there are as near as those of the motion graph; where none is, it waits for its next
//! choice.

use super::block::{MotionBlock, NO_STATE, SCHEDULED};
use super::idle::{FACING, TURN_MISSES};
use super::order::{PolicyOrder, StandOrder};
use super::transition::{SegmentChange, StartTransitionsJob};
use super::{Characters, PolicyCharacters, control, pace};
use super::{control::active_goals, motion_set::MotionSet, scheduled_clip::to_root};
use crate::body::{BodyLayers, set_lane};
use crate::planar::{Planar, wrap_angle};
use crate::policy::{LookAheadGoal, LookAheadJob, NO_ACTION, RankedActions};
use crate::skeleton::Joint;
use glam::{Vec2, Vec3};
use throng_base::maths;
use throng_base::simd::{LANES, dispatch};

/// Largest difference of two frames between which a character may change, see [`FrameFit`] (m).
const FIT_M: f32 = 0.3;
/// Time in which a difference of velocities becomes one of places, and weight of the hands (s, 1).
const FIT_S: f32 = 0.15;
const HANDS: f32 = 0.3;
/// Cost of a difference of 1 m (s).
const FIT_COST_S: f32 = 1.5;
/// Cost of the way to a stand, and of heading that a turn leaves (s/m, s/rad).
const WAY_COST_S: f32 = 0.3;
const HEADING_COST_S: f32 = 1.5;
/// Least time that an answer saves (s).
const GAIN_S: f32 = 0.1;
/// Change of the direction to a target from which an order asks for something else, likewise of the distance (rad, m).
const OTHER_TARGET: [f32; 2] = [0.5, 1.0];
/// Frames by which motion may be ahead of, or behind, that which is left.
const SHIFTS: [i32; 5] = [0, 1, -1, 2, -2];

/// Pose and motion of a frame, as seen from its planar root.
#[derive(Clone, Copy, Debug)]
struct FrameFit {
    /// Places of ankles and hands, the latter weighted (m).
    places: [Vec3; 4],
    /// Velocities of ankles and hips over [`FIT_S`] (m).
    moves: [Vec3; 3],
    /// Feet on the ground: left 1, right 2.
    planted: u8,
}

impl FrameFit {
    fn new(motion_set: &MotionSet, frame: u32) -> Self {
        let [before, after] = motion_set.adjacent_frames(frame);
        let root = motion_set.planar_root(frame);
        let seen = |at: Vec3| {
            let p = root.inverse_transform_point(Vec2::new(at.x, at.z));
            Vec3::new(p.x, at.y, p.y)
        };
        let point = |frame: u32, joint| seen(motion_set.joint_point(frame, joint, Vec3::ZERO));
        let scale = FIT_S * motion_set.rate_hz / (after - before).max(1) as f32;
        let goes = |joint| (point(after, joint) - point(before, joint)) * scale;
        let [left, right] = [Joint::LeftFoot, Joint::RightFoot];
        let hand = |joint| HANDS * point(frame, joint);
        let contacts = motion_set.contacts_at(frame, 0.0);
        let planted =
            [crate::contacts::Contacts::LEFT, crate::contacts::Contacts::RIGHT].map(|foot| contacts.any(foot));
        Self {
            places: [point(frame, left), point(frame, right), hand(Joint::LeftHand), hand(Joint::RightHand)],
            moves: [goes(left), goes(right), goes(Joint::Hips)],
            planted: u8::from(planted[0]) | u8::from(planted[1]) << 1,
        }
    }

    /// Root of the sum of squares of all differences; no less than `limit` where it is at least that (m).
    fn distance(&self, other: &Self, limit: f32) -> f32 {
        if self.planted != other.planted {
            return f32::INFINITY;
        }
        let square = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)).sum::<f32>();
        let places = square(&self.places, &other.places);
        if places > limit * limit { f32::INFINITY } else { (places + square(&self.moves, &other.moves)).sqrt() }
    }
}

/// A frame from which a clip comes to a stand soon.
#[derive(Clone, Copy, Debug)]
struct StandEntry {
    segment: u32,
    /// Frames after the segment's first one.
    offset: u32,
    /// Planar root at the stand as seen from there, and frames until then.
    by: Planar,
    frames: u32,
    fit: FrameFit,
}

/// The frames of a motion set from which its clips come to a stand.
#[derive(Clone, Debug, Default)]
pub(super) struct StandEntries(Vec<StandEntry>);

impl StandEntries {
    pub fn find(motion_set: &MotionSet) -> Self {
        let graph = &motion_set.graph;
        let mut out = Vec::new();
        for (number, (segment, turn)) in graph.segments.iter().zip(motion_set.turns.iter()).enumerate() {
            // Who stands already does not come to a stand.
            if turn.frames == 0 || segment.idle >= segment.num_frames {
                continue;
            }
            let first = motion_set.planar_root(segment.start);
            for offset in 0..segment.num_frames {
                let (frame, frames) = (segment.start + offset, turn.frames - offset);
                let by = first.to_local(motion_set.planar_root(frame)).to_local(turn.by);
                let fit = FrameFit::new(motion_set, frame);
                out.push(StandEntry { segment: number as u32, offset, by, frames, fit });
            }
        }
        Self(out)
    }
}

/// Motion to which a character changes.
#[derive(Clone, Copy, Debug)]
struct SegmentEntry {
    segment: u32,
    /// Frames after its first one.
    offset: u32,
}

/// A character that is given an order.
struct AnsweringCharacter<'a> {
    b: &'a MotionBlock,
    lane: usize,
    motion_set: &'a MotionSet,
    /// Frames that it has played, and its frame row.
    played: u32,
    fit: FrameFit,
}

impl AnsweringCharacter<'_> {
    /// Motion that comes to a stand, or turns, sooner than what is played.
    fn stand_entry(&self, order: &PolicyOrder) -> Option<SegmentEntry> {
        let (b, lane, r) = (self.b, self.lane, self.motion_set);
        let segment = &r.graph.segments[b.segment[lane] as usize];
        let per_frame = 1.0 / r.rate_hz;
        let left_s = (segment.num_frames - self.played) as f32 * per_frame;
        let turn = matches!(order.stands, StandOrder::Turn(_)).then(|| order.turn_left(b.root(lane).heading));
        let stands = segment.idle > 0;
        // Who stands turns all of the way.
        let most = if stands { TURN_MISSES } else { f32::INFINITY };
        let unturned = |by: f32| turn.map_or(0.0, |turn| HEADING_COST_S * wrap_angle(turn - by).abs());
        let mut least = match turn {
            Some(turn) if turn.abs() < FACING && stands => return None,
            None if stands => return None,
            _ if stands => unturned(0.0),
            _ => {
                let stop = &r.stops.stops[segment.end as usize];
                let d = b.root(lane).to_local(b.root_at_end(lane, r));
                left_s + stop.frames as f32 * per_frame + WAY_COST_S * maths::hypot(d.x, d.z) + unturned(d.heading)
            }
        } - GAIN_S;
        let mut best = None;
        for entry in &r.entries.0 {
            let spent = entry.frames as f32 * per_frame
                + WAY_COST_S * maths::hypot(entry.by.x, entry.by.z)
                + unturned(entry.by.heading);
            if spent >= least || turn.is_some_and(|turn| wrap_angle(turn - entry.by.heading).abs() > most) {
                continue;
            }
            if !r.manners.are_alike(segment.end, r.graph.segments[entry.segment as usize].end) {
                continue;
            }
            let fit = self.fit.distance(&entry.fit, FIT_M.min((least - spent) / FIT_COST_S));
            let cost = spent + FIT_COST_S * fit;
            if fit < FIT_M && cost < least {
                (least, best) = (cost, Some(SegmentEntry { segment: entry.segment, offset: entry.offset }));
            }
        }
        best
    }

    /// Another action that leads to a target better, as far into it as the character is into its own.
    fn goal_entry(&self, order: &PolicyOrder) -> Option<SegmentEntry> {
        let (b, lane, r) = (self.b, self.lane, self.motion_set);
        let current = b.segment[lane];
        let segment = &r.graph.segments[current as usize];
        let (state, root, played) = match (segment.idle > 0, b.choice_state[lane]) {
            // Who stands may go at once.
            (true, _) => (segment.end, b.root(lane), 0),
            (false, NO_STATE) => return None,
            (false, state) => (state, b.choice_root(lane), self.played as i32),
        };
        let (num_goals, goals) = active_goals(order, r);
        let policy = &r.policies[goals[0].policy];
        let local = root.inverse_transform_point(Vec2::new(goals[0].target.x, goals[0].target.z));
        let target = Vec3::new(local.x, goals[0].target.y, local.y);
        if num_goals != 1 || !policy.grid().is_polar() || !policy.region().contains(target) {
            return None;
        }
        let mut ranked = [RankedActions::NONE];
        let goals = [LookAheadGoal { policy, weights: &[goals[0].weight], targets: &[target] }];
        LookAheadJob { goals: &goals, states: &[state], ranked: &mut ranked }.run().ok()?;
        let segments = r.graph.segments_of(state);
        for action in ranked[0].actions.into_iter().filter(|a| *a != NO_ACTION) {
            let to = segments[usize::from(action)];
            let new = &r.graph.segments[to as usize];
            if to == current || new.start == segment.start + segment.num_frames && played == 0 {
                return None;
            }
            if !r.manners.are_alike(segment.end, new.end) {
                continue;
            }
            // A stand before it sets off is left out.
            let from = if played == 0 { new.idle.min(new.num_frames - 1) as i32 } else { played };
            let fits = |shift: &i32| {
                let offset = u32::try_from(from + shift).ok().filter(|o| *o + 1 < new.num_frames)?;
                let fit = FrameFit::new(r, new.start + offset).distance(&self.fit, FIT_M);
                (fit < FIT_M).then_some((fit, offset))
            };
            let best = SHIFTS.iter().filter_map(fits).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, offset)) = best {
                return Some(SegmentEntry { segment: to, offset });
            }
        }
        None
    }
}

/// True where an order asks for something else than the one before.
fn asks_anew(old: &PolicyOrder, new: &PolicyOrder, root: Planar) -> bool {
    if new.policies().is_empty() {
        return match (old.policies().is_empty(), old.stands, new.stands) {
            (_, _, StandOrder::Follow) => false,
            (true, StandOrder::Turn(a), StandOrder::Turn(b)) => wrap_angle(a - b).abs() > FACING,
            (true, a, b) => a != b,
            (false, _, _) => true,
        };
    }
    let seen = |order: &PolicyOrder| root.inverse_transform_point(Vec2::new(order.target().x, order.target().z));
    let (a, b) = (seen(old), seen(new));
    let [turn, way] = OTHER_TARGET;
    let turned = wrap_angle(maths::atan2(a.x, a.y) - maths::atan2(b.x, b.y)).abs() > turn;
    old.policies() != new.policies() || a.distance(b) > way && (turned || (a.length() - b.length()).abs() > way)
}

impl PolicyCharacters {
    /// Replaces an order that is fit to be given (at < number of characters).
    pub(super) fn give_order(&mut self, at: usize, mut order: PolicyOrder) {
        order.follow(&self.orders[at]);
        let old = std::mem::replace(&mut self.orders[at], order);
        // Of several orders between two steps the last one counts.
        if old.age_s > 0.0 {
            self.obeyed[at] = old.with_layers(BodyLayers::NONE);
        }
        if old.manner != order.manner {
            self.characters.enter_manner(&self.motion_set, &self.arrivals, at, order.manner);
        }
    }

    /// Answers the orders that were given since the last step.
    pub(super) fn answer_orders(&mut self) {
        let given = self.orders.iter().zip(&mut self.obeyed).enumerate().filter(|(_, (order, _))| order.age_s == 0.0);
        for (at, (order, obeyed)) in given {
            if asks_anew(obeyed, order, self.characters.root(at)) {
                self.characters.answer_order(&self.motion_set, at, order);
            }
            *obeyed = order.with_layers(BodyLayers::NONE);
        }
    }
}

impl Characters {
    /// Lets a character leave its segment at once for motion that obeys an order, where there is such motion
    /// (at < num_characters).
    fn answer_order(&mut self, motion_set: &MotionSet, at: usize, order: &PolicyOrder) {
        let (b, lane) = (&self.blocks[at / LANES], at % LANES);
        let plays = b.segment[lane] != SCHEDULED && b.time[lane] < b.length[lane] as f32;
        if !plays || !matches!(b.pace[lane], pace::NORMAL | pace::IDLING) {
            return;
        }
        // Who has begun a blow strikes it.
        if motion_set.hits_after(b.segment[lane], b.time[lane]).next().is_some() {
            return;
        }
        let played = b.time[lane] as u32;
        let fit = FrameFit::new(motion_set, b.first[lane] + played);
        let who = AnsweringCharacter { b, lane, motion_set, played, fit };
        let found = if order.is_to_stand() { who.stand_entry(order) } else { who.goal_entry(order) };
        let Some(entry) = found else { return };
        let before = (*b, self.bodies[at / LANES]);
        let sweep = |segment: u32| motion_set.stops.sweeps[segment as usize].radius;
        let is_wide = self.avoiding.is_some() && sweep(b.segment[lane]) > sweep(entry.segment);
        if is_wide {
            return;
        }
        self.enter_segment(motion_set, at, entry);
        if !self.reserve_path(motion_set, at) {
            (self.blocks[at / LANES], self.bodies[at / LANES]) = before;
            self.reserve_path(motion_set, at);
        }
    }

    /// Goes on within another segment, from where the character is.
    fn enter_segment(&mut self, motion_set: &MotionSet, at: usize, entry: SegmentEntry) {
        let (b, lane) = (&mut self.blocks[at / LANES], at % LANES);
        let new = motion_set.graph.segments[entry.segment as usize];
        let part = b.time[lane].fract();
        let from = b.first[lane] + b.time[lane] as u32;
        let (root, time) = (b.root(lane), entry.offset as f32 + part);
        let drift = to_root(root, b.drift_per_frame(lane));
        let age_s = b.age_s[lane];
        let change =
            SegmentChange { character: at as u32, from, to: new.start + entry.offset, age_s, lift: 0.0, drift };
        let clip = root.compose(motion_set.planar_at(new.start, time).inverse());
        b.set_segment(lane, entry.segment, &new);
        b.set_clip_to_world(lane, clip);
        b.set_choice_root(lane, clip.compose(motion_set.planar_root(new.start)));
        b.choice_state[lane] = NO_STATE;
        b.pace[lane] = control::pace_of(&new);
        b.num_choices[lane] = b.num_choices[lane].wrapping_add(1);
        b.time[lane] = time;
        b.age_s[lane] = 0.0;
        set_lane(&mut b.root, lane, Vec3::new(root.x, root.z, root.heading));
        b.set_change(lane, from, change.to);
        if self.bodies[at / LANES].awake == 1 {
            let (half_life_s, bodies) = (self.config.half_life_s, &mut *self.bodies);
            dispatch(StartTransitionsJob { group: &[change], motion_set, half_life_s, bodies });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character_group::CharacterGroup;
    use crate::characters::tests::tables;
    use crate::characters::{AvoidConfig, CharactersConfig, Spawn};
    use crate::graph::{MotionGraph, StateRecord};
    use throng_base::{Id, Inline};

    /// The made-up motion, whose second clip stands at its first state.
    fn standing_set() -> MotionSet {
        let mut out = MotionSet::new(&tables());
        let states: Vec<StateRecord> = out.graph.states.to_vec();
        let stand = |(i, s): (usize, StateRecord)| StateRecord { standing: u32::from(i == 2), ..s };
        out.graph =
            MotionGraph { states: states.into_iter().enumerate().map(stand).collect::<Vec<_>>().into(), ..out.graph };
        out.turns = super::super::idle::find_turns(&out.graph, out.rate_hz).into();
        out.entries = StandEntries::find(&out).into();
        out
    }

    /// Somebody who has walked for some steps.
    fn walker(config: CharactersConfig, steps: usize) -> (PolicyCharacters, Id) {
        let mut group = PolicyCharacters::with_capacity(&tables(), 1, config).unwrap();
        group.motion_set = standing_set();
        let id = group.spawn(Spawn { root: Planar::new(3.0, -2.0, 1.0), state: Some(3), floor_m: 0.0 }).unwrap();
        group.order(id, PolicyOrder::towards(0, Vec3::new(30.0, 0.0, 0.0))).unwrap();
        (0..steps).for_each(|_| group.step(1.0 / 60.0, &Inline).unwrap());
        (group, id)
    }

    #[test]
    fn an_order_to_stop_is_answered_within_a_segment_without_a_jump() {
        let avoids = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
        let mut answered = 0;
        for config in [CharactersConfig::default(), avoids] {
            for steps in 12..30 {
                let (mut group, id) = walker(config, steps);
                let (before, played, root) =
                    (group.characters.joint_positions(0), group.characters.segment(0), group.characters.root(0));
                group.order(id, PolicyOrder::STOP).unwrap();
                group.answer_orders();
                let now = group.characters.segment(0);
                if now == played {
                    continue;
                }
                answered += 1;
                assert_eq!(now.0, 2, "the segment that comes to a stand");
                assert!((now.1.fract() - played.1.fract()).abs() < 1e-3 && group.characters.root(0) == root);
                let mut kept = Vec::new();
                group.save(&mut kept);
                group.step(1.0 / 60.0, &Inline).unwrap();
                let after = group.characters.joint_positions(0);
                let most = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
                assert!(most < 0.08, "a joint jumps by {most} m");
                // A snapshot goes on as what it was taken of.
                group.load(&kept).unwrap();
                group.step(1.0 / 60.0, &Inline).unwrap();
                assert_eq!(group.characters.joint_positions(0), after);
            }
        }
        assert!(answered > 12, "{answered} of 36 orders are answered at once");
    }

    #[test]
    fn frames_fit_where_places_motion_and_planted_feet_do() {
        let r = standing_set();
        let at = |frame| FrameFit::new(&r, frame);
        assert!(at(10).distance(&at(10), FIT_M) < 1e-6);
        assert!(at(10).distance(&at(11), FIT_M) < FIT_M && at(10).distance(&at(10 + 60), FIT_M) < FIT_M);
        let other = FrameFit { planted: 3 - at(10).planted, ..at(10) };
        assert_eq!(at(10).distance(&other, FIT_M), f32::INFINITY);
        let aside = FrameFit { places: at(10).places.map(|p| p + 0.2 * Vec3::X), ..at(10) };
        assert!(at(10).distance(&aside, FIT_M) > FIT_M);
        let faster = FrameFit { moves: at(10).moves.map(|v| v + 0.2 * Vec3::Z), ..at(10) };
        assert!(at(10).distance(&faster, FIT_M) > FIT_M);
    }

    #[test]
    fn orders_that_ask_for_the_same_are_no_new_ones() {
        let here = Planar::IDENTITY;
        let go = |x: f32, z: f32| PolicyOrder::towards(0, Vec3::new(x, 0.0, z));
        let anew = |old: PolicyOrder, new: PolicyOrder| asks_anew(&old, &new, here);
        assert!(!anew(go(0.0, 8.0), go(0.0, 8.5)) && anew(go(0.0, 8.0), go(0.0, 5.0)));
        assert!(!anew(go(0.0, 8.0), go(1.5, 8.0)) && anew(go(0.0, 8.0), go(8.0, 0.0)));
        assert!(!anew(go(0.0, 0.1), go(0.1, 0.0)), "nearly the same place");
        assert!(anew(go(0.0, 8.0), PolicyOrder::STOP) && !anew(PolicyOrder::STOP, PolicyOrder::STOP));
        assert!(anew(PolicyOrder::STOP, go(0.0, 8.0)) && !anew(go(0.0, 8.0), PolicyOrder::IDLE));
        let turn = PolicyOrder::turn_to;
        assert!(!anew(turn(1.0), turn(1.05)) && anew(turn(1.0), turn(2.0)) && anew(PolicyOrder::STOP, turn(2.0)));
    }
}
