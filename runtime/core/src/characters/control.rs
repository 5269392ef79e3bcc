//! Control: a character at the end of its segment chooses the next action.

use super::avoid::{SegmentPlan, stop_of};
use super::block::{BodyBlock, MotionBlock, NO_STATE, SCHEDULED};
use super::manner::{MannerName, OrderedChoice};
use super::transition::{SegmentChange, StartTransitionsJob};
use super::{ActionChoice, Characters, CharactersConfig, pace};
use super::{bent, blow::PassedHits, order::PolicyOrder, step::CharactersTick};
use super::{idle::StandingChooser, motion_set::MotionSet, scheduled_clip::to_root};
use crate::policy::{self, BestActionJob, LookAheadJob, MAX_RANKED, NO_ACTION, PolicyTable, RankedActions};
use crate::{body::set_lane, graph::MotionSegment, planar::Planar};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_base::simd::{LANES, dispatch};

/// Characters that choose together; the batch lives on the stack.
pub(crate) const BATCH: usize = 64;
/// Choices after which a character likes other blows.
const SAME_TASTE: u32 = 4;
/// Difference of the scores of a blow that a character likes and of one that it does not, in temperatures.
const DISLIKE: f32 = 8.0;
/// Behaviours that may be weighed against each other.
pub(crate) const MAX_GOALS: usize = 4;

/// A behaviour that one character is asked.
#[derive(Clone, Copy, Default)]
pub(crate) struct OwnGoal {
    pub policy: usize,
    pub weight: f32,
    /// Target in the world (m).
    pub target: Vec3,
}

/// The number of behaviours that one character is asked, and those.
pub(crate) fn active_goals(order: &PolicyOrder, motion_set: &MotionSet) -> (usize, [OwnGoal; MAX_GOALS]) {
    let mut own = [OwnGoal::default(); MAX_GOALS];
    for (own, (&policy, &weight)) in own.iter_mut().zip(order.policies().iter().zip(order.weights())) {
        let policy = policy as usize;
        *own = OwnGoal { policy, weight, target: order.aim_of(&motion_set.policies[policy]) };
    }
    (order.policies().len(), own)
}

/// The characters of one range that wait for a choice.
struct PendingChoices {
    len: usize,
    characters: [u32; BATCH],
    states: [u32; BATCH],
    roots: [Planar; BATCH],
    targets: [[Vec3; BATCH]; MAX_GOALS],
    weights: [[f32; BATCH]; MAX_GOALS],
    actions: [u8; BATCH],
    /// Rate at which a turn on the spot is bent (rad/frame).
    bends: [f32; BATCH],
    /// Behaviours that all of them ask.
    policies: [usize; MAX_GOALS],
    num_goals: usize,
}

/// Lets every character of a range choose until each is inside a segment.
///
/// - `first`: number of the range's first character, on which random choices depend.
/// - `passed`: receives the hits at the start of new segments.
pub(crate) fn choose_all(
    blocks: &mut [MotionBlock],
    bodies: &mut [BodyBlock],
    passed: &mut PassedHits,
    first: usize,
    count: usize,
    tick: &CharactersTick<'_>,
) {
    let mut pending = PendingChoices {
        len: 0,
        characters: [0; BATCH],
        states: [0; BATCH],
        roots: [Planar::IDENTITY; BATCH],
        targets: [[Vec3::ZERO; BATCH]; MAX_GOALS],
        weights: [[0.0; BATCH]; MAX_GOALS],
        actions: [0; BATCH],
        bends: [0.0; BATCH],
        policies: [0; MAX_GOALS],
        num_goals: 0,
    };
    let mut from = 0;
    // Each pass handles up to a batch; a character whose next segment ends at once waits for another pass.
    while from < count {
        pending.len = 0;
        let mut next = from;
        while next < count && pending.len < BATCH {
            pending.collect(blocks, next, first, tick);
            next += 1;
        }
        if pending.len == 0 {
            from = next;
            continue;
        }
        pending.select_actions(blocks, first, tick);
        apply_choices(&pending, blocks, bodies, passed, first, tick);
    }
}

impl PendingChoices {
    /// Adds a character that has played its segment to the end, unless it is to stay there.
    fn collect(&mut self, blocks: &[MotionBlock], character: usize, first: usize, tick: &CharactersTick<'_>) {
        let motion_set = tick.motion_set;
        let (b, lane) = (&blocks[character / LANES], character % LANES);
        if b.time[lane] < b.length[lane] as f32 || b.segment[lane] == SCHEDULED {
            return;
        }
        let (order, end) = (&tick.orders[first + character], motion_set.graph.segments[b.segment[lane] as usize].end);
        if b.pace[lane] == pace::HELD_STILL && order.is_to_stand() {
            return;
        }
        let (num_goals, goals) = active_goals(order, motion_set);
        let policies = goals.map(|g| g.policy);
        if self.len == 0 {
            (self.num_goals, self.policies) = (num_goals, policies);
        } else if (self.num_goals, self.policies) != (num_goals, policies) {
            // It is asked something else: its turn comes in another pass.
            return;
        }
        let root = b.root_at_end(lane, motion_set);
        let i = self.len;
        self.len += 1;
        self.characters[i] = character as u32;
        self.states[i] = end;
        self.roots[i] = root;
        for (g, goal) in goals[..num_goals].iter().enumerate() {
            let t = goal.target;
            let local = root.inverse_transform_point(Vec2::new(t.x, t.z));
            let target = Vec3::new(local.x, t.y, local.y);
            let active = motion_set.policies[goal.policy].region().contains(target);
            self.targets[g][i] = target;
            self.weights[g][i] = if active { goal.weight } else { 0.0 };
        }
    }

    /// Fills in the actions.
    fn select_actions(&mut self, blocks: &[MotionBlock], first: usize, tick: &CharactersTick<'_>) {
        let CharactersTick { motion_set, config, .. } = *tick;
        let (n, num_goals, policies) = (self.len, self.num_goals, self.policies);
        let states = &self.states[..n];
        self.bends[..n].fill(0.0);
        match config.choice {
            _ if num_goals == 0 => {
                for i in 0..n {
                    let order = &tick.orders[first + self.characters[i] as usize];
                    (self.actions[i], self.bends[i]) = self.standing_chooser(i, blocks, tick).choose_stand(order);
                }
            }
            ActionChoice::BestAction if num_goals == 1 => {
                let policy = &motion_set.policies[policies[0]];
                let (targets, actions) = (&self.targets[0][..n], &mut self.actions[..n]);
                let job = BestActionJob { policy, states, targets, choice: 0, actions };
                job.run().unwrap_or_else(|e| unreachable!("states come from the tables, targets were checked: {e}"));
            }
            _ => {
                let mut ranked = [RankedActions::NONE; BATCH];
                let jobs: [policy::LookAheadGoal<'_>; MAX_GOALS] = std::array::from_fn(|g| {
                    let g = g.min(num_goals - 1);
                    policy::LookAheadGoal {
                        policy: &motion_set.policies[policies[g]],
                        weights: &self.weights[g][..n],
                        targets: &self.targets[g][..n],
                    }
                });
                let job = LookAheadJob { goals: &jobs[..num_goals], states, ranked: &mut ranked[..n] };
                job.run().unwrap_or_else(|e| unreachable!("states come from the tables, targets were checked: {e}"));
                let temperature = match config.choice {
                    ActionChoice::LookAhead { temperature } => temperature,
                    ActionChoice::BestAction => 0.0,
                };
                for i in 0..n {
                    let c = self.characters[i] as usize;
                    let (b, lane) = (&blocks[c / LANES], c % LANES);
                    vary_blows(&mut ranked[i], motion_set, states[i], |hit| {
                        let number = config.first_number.wrapping_add(b.name[lane]);
                        let epoch = u64::from(b.num_choices[lane] / SAME_TASTE);
                        let taste = uniform_random(config.seed ^ u64::from(hit + 1).rotate_right(16), number, epoch);
                        temperature * DISLIKE * (taste - 0.5)
                    });
                    self.actions[i] = ranked[i].choose(temperature, draw_random(b, lane, config));
                }
            }
        }
        if num_goals == 1 {
            for i in 0..n {
                let (policy, weight, target) =
                    (&motion_set.policies[policies[0]], self.weights[0][i], self.targets[0][i]);
                let chooser = self.standing_chooser(i, blocks, tick);
                self.actions[i] = chooser.replace_action(policy, weight, target, self.actions[i]);
            }
        }
        for i in 0..n {
            let order = &tick.orders[first + self.characters[i] as usize];
            if order.manner == MannerName::NONE && order.speed_mps.is_none() {
                continue;
            }
            let chooser = self.standing_chooser(i, blocks, tick);
            let (state, chosen) = (self.states[i], self.actions[i]);
            let stays = chooser.stays(chosen);
            let aims = |g: usize| (&motion_set.policies[policies[g]], self.weights[g][i], self.targets[g][i]);
            let worth = |segment| (0..num_goals).map(|g| worth_after(segment, aims(g))).sum();
            let left = (num_goals == 1).then(|| way_left(motion_set, policies[0], self.targets[0][i])).flatten();
            let choice = OrderedChoice { motion_set, order, state, chosen, stays, left };
            let Some(ranked) = choice.preferred(worth) else { continue };
            if ranked[0] != NO_ACTION && (!stays || chooser.stays(ranked[0])) {
                (self.actions[i], self.bends[i]) = (ranked[0], 0.0);
            }
        }
    }

    fn standing_chooser<'a>(&self, i: usize, all: &'a [MotionBlock], tick: &CharactersTick<'a>) -> StandingChooser<'a> {
        let character = self.characters[i] as usize;
        let CharactersTick { motion_set, config, .. } = *tick;
        let b = &all[character / LANES];
        StandingChooser { b, lane: character % LANES, state: self.states[i], root: self.roots[i], motion_set, config }
    }
}

/// Way of a behaviour to its target, as the character sees it (m); none where that is not a place.
pub(super) fn way_left(motion_set: &MotionSet, policy: usize, seen: Vec3) -> Option<Vec2> {
    let policy = &motion_set.policies[policy];
    let is_place = policy.grid().is_polar() && policy.reward().record().offset == 0.0;
    is_place.then(|| (seen - policy.centre()).xz())
}

/// Value for a behaviour, with its weight and its target, of the end of a segment (m).
pub(super) fn worth_after(segment: u32, (policy, weight, target): (&PolicyTable, f32, Vec3)) -> f32 {
    let (_, [x, z, _]) = policy.target_along(segment, policy.to_grid(target));
    weight * policy.value(policy.segments()[segment as usize].end, Vec3::new(x, target.y, z) + policy.centre())
}

/// Changes the scores of blows by what a character likes at the moment, so that nobody throws the same one all the time.
///
/// - `dislike`: of a hit, as a share of the best score.
fn vary_blows(ranked: &mut RankedActions, motion_set: &MotionSet, state: u32, dislike: impl Fn(u32) -> f32) {
    if motion_set.hits.is_empty() {
        return;
    }
    let (segments, unit) = (motion_set.graph.segments_of(state), ranked.scores[0].abs());
    for k in 0..MAX_RANKED {
        let segment = segments.get(usize::from(ranked.actions[k]));
        let hit = segment.filter(|_| ranked.actions[k] != NO_ACTION).and_then(|s| motion_set.hits_of(*s).next());
        ranked.scores[k] -= hit.map_or(0.0, |hit| unit * dislike(hit));
        for i in (1..=k).rev() {
            if ranked.scores[i] > ranked.scores[i - 1] {
                ranked.scores.swap(i, i - 1);
                ranked.actions.swap(i, i - 1);
            }
        }
    }
}

/// Starts the chosen segments.
fn apply_choices(
    pending: &PendingChoices,
    blocks: &mut [MotionBlock],
    bodies: &mut [BodyBlock],
    passed: &mut PassedHits,
    first: usize,
    tick: &CharactersTick<'_>,
) {
    let CharactersTick { motion_set, config, .. } = *tick;
    let mut changes = [SegmentChange::default(); BATCH];
    let mut num_changes = 0;
    for i in 0..pending.len {
        let (character, state) = (pending.characters[i] as usize, pending.states[i]);
        let (b, lane) = (&mut blocks[character / LANES], character % LANES);
        let segment = motion_set.graph.segments_of(state)[usize::from(pending.actions[i])];
        let new = &motion_set.graph.segments[segment as usize];
        let bend = match pending.num_goals {
            0 => pending.bends[i],
            _ => motion_set.policies[pending.policies[0]].bend(segment, pending.targets[0][i]) / new.num_frames as f32,
        };
        let stands = tick.orders[first + character].is_to_stand();
        let pace = match b.pace[lane] {
            pace::SLOWING if stands => {
                // It came to its stand.
                (b.pace[lane], b.wait[lane], b.time[lane]) = (pace::HELD_STILL, 0.0, b.length[lane] as f32);
                continue;
            }
            pace::SLOWING | pace::HELD_STILL => pace::STARTING,
            _ if stands && new.idle == 0 && segment == motion_set.stops.stops[state as usize].segment => {
                stop_of(state, motion_set).pace
            }
            _ => pace_of(new),
        };
        let plan = SegmentPlan { segment, pace, bend };
        let left = b.time[lane] - b.length[lane] as f32;
        let begin_it = SegmentBegin { at: first + character, state, root: pending.roots[i], plan, left };
        let change = begin_segment(b, &begin_it, passed, motion_set);
        if let Some(change) = change.filter(|_| bodies[character / LANES].awake == 1) {
            changes[num_changes] = SegmentChange { character: character as u32, ..change };
            num_changes += 1;
        }
    }
    for group in changes[..num_changes].chunks(LANES) {
        dispatch(StartTransitionsJob { group, motion_set, half_life_s: config.half_life_s, bodies });
    }
}

/// Pace at which a segment is played that nothing holds up.
pub(crate) fn pace_of(segment: &MotionSegment) -> u32 {
    if segment.idle > 0 { pace::IDLING } else { pace::NORMAL }
}

/// A segment that begins.
pub(crate) struct SegmentBegin {
    /// Number of the character.
    pub at: usize,
    /// State in which it was chosen.
    pub state: u32,
    /// Planar root in the world at its first frame.
    pub root: Planar,
    pub plan: SegmentPlan,
    /// Time since then (frames).
    pub left: f32,
}

/// Starts a segment at the end of the last one; returns the jump of the pose to ease, if there is one.
pub(crate) fn begin_segment(
    b: &mut MotionBlock,
    begin: &SegmentBegin,
    passed: &mut PassedHits,
    motion_set: &MotionSet,
) -> Option<SegmentChange> {
    let (lane, id) = (begin.at % LANES, begin.plan.segment);
    let new = &motion_set.graph.segments[id as usize];
    let from = b.first[lane] + b.length[lane];
    b.set_clip_to_world(lane, begin.root.compose(motion_set.planar_root(new.start).inverse()));
    b.set_segment(lane, id, new);
    b.choice_state[lane] = begin.state;
    b.set_choice_root(lane, begin.root);
    b.pace[lane] = begin.plan.pace;
    b.bend[lane] = begin.plan.bend;
    if begin.plan.pace == pace::IN_PLACE {
        // What it goes is taken back evenly.
        let whole = begin.root.compose(new.displacement());
        let back = Vec3::new(begin.root.x - whole.x, 0.0, begin.root.z - whole.z);
        set_lane(&mut b.drift, lane, back / new.num_frames as f32);
    }
    b.time[lane] = pace::frame_at_time(begin.plan.pace, new.num_frames as f32, begin.left);
    if b.bend[lane] != 0.0 {
        bent::place_on_path(b, lane, motion_set);
    }
    b.num_choices[lane] = b.num_choices[lane].wrapping_add(1);
    if !passed.is_off() {
        passed.add_passed(motion_set, begin.at as u32, id, 0.0, b.time[lane], b.clip_to_world(lane));
    }
    if new.start == from {
        return None;
    }
    let left_s = begin.left / motion_set.rate_hz;
    let age_s = b.age_s[lane] - left_s;
    b.age_s[lane] = left_s;
    b.set_change(lane, from, new.start);
    Some(SegmentChange { from, to: new.start, age_s, ..SegmentChange::default() })
}

/// Random number of a choice, in [0, 1).
pub(crate) fn draw_random(b: &MotionBlock, lane: usize, config: &CharactersConfig) -> f32 {
    let number = config.first_number.wrapping_add(b.name[lane]);
    uniform_random(config.seed, number, u64::from(b.num_choices[lane]))
}

impl Characters {
    /// Starts a segment now, from where the character stands (segment exists).
    pub(super) fn play_segment(&mut self, motion_set: &MotionSet, character: usize, segment: u32) {
        let (b, lane) = (&mut self.blocks[character / LANES], character % LANES);
        let new = motion_set.graph.segments[segment as usize];
        // The frame before it is in the same clip too.
        let from = b.first[lane] + (b.time[lane].round() as u32).clamp(1, b.length[lane]);
        let (lift, drift) = (b.lift_at(lane, b.time[lane]), to_root(b.root(lane), b.drift_per_frame(lane)));
        let change =
            SegmentChange { character: character as u32, from, to: new.start, age_s: b.age_s[lane], lift, drift };
        b.set_clip_to_world(lane, b.root(lane).compose(motion_set.planar_root(new.start).inverse()));
        b.set_choice_root(lane, b.root(lane));
        b.set_segment(lane, segment, &new);
        b.time[lane] = 0.0;
        b.age_s[lane] = 0.0;
        b.choice_state[lane] = NO_STATE;
        b.set_change(lane, from, new.start);
        if self.bodies[character / LANES].awake == 1 {
            let (half_life_s, bodies) = (self.config.half_life_s, &mut *self.bodies);
            dispatch(StartTransitionsJob { group: &[change], motion_set, half_life_s, bodies });
        }
    }
}

/// A number in [0, 1) that depends on nothing but its arguments.
pub fn uniform_random(seed: u64, character: u64, draw: u64) -> f32 {
    (random_bits(seed, character, draw) >> 40) as f32 / (1u64 << 24) as f32
}

/// Bits that depend on nothing but the arguments (SplitMix64 over their combination).
pub(super) fn random_bits(seed: u64, character: u64, draw: u64) -> u64 {
    let mut z = seed ^ character.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ draw.wrapping_mul(0xD1B5_4A32_D192_ED03);
    for _ in 0..2 {
        z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_numbers_are_spread_evenly() {
        let n = 100_000u64;
        let mean = (0..n).map(|i| f64::from(uniform_random(1, i % 100, i / 100))).sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert_ne!(uniform_random(1, 2, 3), uniform_random(1, 3, 2));
    }

    #[test]
    fn blows_that_a_character_dislikes_are_ranked_lower() {
        let hit = |frame| crate::hits::HitRecord {
            frame,
            force: 1.0,
            speed_mps: 5.0,
            direction: [0.0, 0.0, 1.0],
            ..Default::default()
        };
        let ranks = |hits: &[crate::hits::HitRecord]| {
            let tables = crate::characters::made_up::tables_with(hits);
            let (mut ranked, none) = (RankedActions::NONE, f32::NEG_INFINITY);
            ranked.scores = [2.0, 1.8, none, none];
            (ranked.actions[0], ranked.actions[1]) = (0, 1);
            vary_blows(&mut ranked, &MotionSet::new(&tables), 0, |hit| if hit == 0 { 0.2 } else { -0.05 });
            (ranked.actions[..2].to_vec(), ranked.scores[..2].to_vec())
        };
        assert_eq!(ranks(&[]), (vec![0, 1], vec![2.0, 1.8]));
        let (actions, scores) = ranks(&[hit(25), hit(85)]);
        assert_eq!(actions, [1, 0]);
        assert!((scores[0] - 1.9).abs() < 1e-6 && (scores[1] - 1.6).abs() < 1e-6, "{scores:?}");
    }
}
