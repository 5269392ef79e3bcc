//! Actions of two: their offers, and how the partners come together, begin, continue in step, and part.
//!
//! Each of the two walks to the place where its capture begins, as to any other place, on units of its own. The first
//! one there waits. When both are there, the clips that they play are cut at the same moment, and both change to the
//! capture. Within [`ENTRY`] frames the distance of each from its place is removed; from then on the two are to each
//! other as they were captured. A character that gets another goal leaves as soon as both its feet stand near to a
//! place of rest.

use super::{InhabitantActivity, InhabitantEvent, InhabitantGoal, Inhabitants};
use super::{reservations::follow_nobody, snapshot::is_time};
use crate::plan::{PlanTarget, WorldPlanner};
use crate::{WorldGraph, WorldNode, WorldStep};
use serde::{Deserialize, Serialize};
use throng_base::{Error, Id, Result, error::check_value, maths};
use throng_core::patch::{LinkRecord, NONE, Placement};
use throng_core::{Contacts, Planar, characters::uniform_random, planar::wrap_angle};

/// Frames within which a character reaches the position that the capture has it at (frames).
const ENTRY: u16 = 15;
/// Time after the order at which two that have not begun give up: this, and so many times the time they need to walk
/// there (s).
const GIVE_UP_S: f64 = 60.0;
const GIVE_UP_WAYS: f32 = 2.0;
/// Distance from its place within which a resting character need not walk (m, rad).
const NEAR_START: (f32, f32) = (0.06, 0.1);
/// Distance from a place of rest within which a character may break off (m, rad).
const NEAR_REST: (f32, f32) = (0.06, 0.15);
/// Shortest and longest stay after an action of two, for a character with a next goal (s).
const LINGERS_S: [f32; 2] = [0.2, 0.5];
/// Delay of its next goal after which a character need not hurry any more (s).
const HURRIES_S: f64 = 1.0;
/// Heels and toes.
const BOTH_FEET: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
/// Places for two that are compared, the nearest ones.
const MOST_TRIED: usize = 16;
/// Factor by which another place must be reached sooner than the nearest one to be taken.
const SOON: f32 = 1.1;
/// A place that others hold or go to counts as so much farther away (m).
const TAKEN_M: f32 = 100.0;

/// Place for an action of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PairOffer {
    /// Tag of the action: 1 + index into [`throng_core::format::Meta::link_tags`].
    pub tag: u16,
    /// Node where each begins.
    pub starts: [WorldNode; 2],
    /// Node where each ends.
    pub ends: [WorldNode; 2],
    /// Step of each, as a whole.
    steps: [WorldStep; 2],
}

impl PairOffer {
    /// The first frames of what one of the two plays; it is still where it begins then.
    fn entry_step(&self, side: usize) -> WorldStep {
        let whole = self.steps[side];
        WorldStep { to: self.starts[side], to_offset: ENTRY.min(whole.to_offset / 2).max(1), ..whole }
    }
}

/// Stage of a meeting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum MeetingStage {
    /// The character is on its way.
    Coming,
    /// The character waits at its place for its partner.
    Ready,
    /// Changes to the capture at the end of what it plays, which was cut.
    Beginning,
    /// Plays the first frames.
    Entering,
    /// Plays the rest.
    Together,
}

/// Reason why two parted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum PartingReason {
    /// The two had not begun.
    GaveUp,
    /// The two had begun.
    BrokeOff,
}

/// Meeting, as one of the partners stores it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PairMeeting {
    /// Partner.
    with: Id,
    /// Number of the offer.
    offer: u32,
    /// Side of the offer that it takes.
    side: u8,
    stage: MeetingStage,
    /// Time at which they give up, if they have not begun (s).
    until_s: f64,
    /// Time at which it reached its place (s).
    ready_s: f64,
    /// Times that they have begun anew.
    rounds: u32,
}

/// Public state of a meeting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeetingState {
    /// Partner.
    pub with: Id,
    /// Tag of the action.
    pub tag: u16,
    /// Time that it has waited at its place, or waited before they began (s).
    pub waited_s: f32,
    /// True once they have begun.
    pub has_begun: bool,
    /// Root of the partner relative to its own, as it is and as it was captured; once both have reached their captured
    /// positions.
    pub partner: Option<[Planar; 2]>,
}

/// All places for actions of two in a world, by instance.
pub(super) fn pair_offers(graph: &WorldGraph) -> Vec<PairOffer> {
    let pairs = &graph.patches().pairs;
    let mut out = Vec::new();
    for instance in 0..graph.num_instances() as u32 {
        let record = graph.instance(instance);
        let first = pairs.partition_point(|p| p.patch < record.patch);
        for pair in pairs[first..].iter().take_while(|p| p.patch == record.patch) {
            let slot = record.first_neighbour + pair.edge;
            let beyond = graph.world().neighbours[slot as usize];
            if beyond == NONE || graph.instance(beyond).patch != record.patch || !graph.bounds.is_edge_open(slot) {
                continue;
            }
            let sides = [(instance, pair.link), (beyond, pair.partner_link)];
            let [Some(a), Some(b)] = sides.map(|(i, l)| graph.step_along(i, l)) else { continue };
            let start = |(i, l): (u32, u32)| WorldNode { instance: i, cell: graph.links(i)[l as usize].from };
            let tag = graph.links(instance)[pair.link as usize].tag & !LinkRecord::FOR_TWO;
            let offer = PairOffer { tag, starts: sides.map(start), ends: [a.to, b.to], steps: [a, b] };
            let can_stay = |n: &WorldNode| graph.is_enabled(*n) && graph.is_rest(*n) && graph.is_stop(*n);
            if offer.starts.iter().chain(&offer.ends).all(can_stay) && offer.starts.iter().all(|n| graph.is_entered(*n))
            {
                out.push(offer);
            }
        }
    }
    out
}

impl Inhabitants {
    /// True where two can do something together somewhere in the world.
    pub fn offers_pair(&self, tag: u16) -> bool {
        self.pair_offers.iter().any(|o| o.tag == tag)
    }

    /// Orders two characters to meet and perform an action together, again and again, then stay.
    ///
    /// Both get [`InhabitantGoal::Meet`]. If one of them gets another goal, or they do not begin in time (a minute, and twice the
    /// time to walk there), both are free ([`InhabitantEvent::BrokenOff`], [`InhabitantEvent::GaveUp`]).
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Value`] for a character that is to meet itself, a time out of its range or a tag that
    /// is not offered to two, [`Error::Occupied`] where all places for two are taken or cannot be reached. Nothing has
    /// changed then.
    pub fn order_meeting(&mut self, two: [Id; 2], tag: u16, seconds: f32) -> Result<()> {
        let rows = [self.roster.row(two[0])?, self.roster.row(two[1])?];
        let who = Some(two[0]);
        check_value("other", who, two[1].index, rows[0] != rows[1], "somebody else")?;
        check_value("seconds", who, seconds, (0.0..1e9).contains(&seconds), "not negative and below 1e9 (s)")?;
        check_value("tag", who, tag, self.offers_pair(tag), "one of motion of two that the world has room for")?;
        let Some((offer, flipped, frames)) = self.nearest_pair_offer(rows, tag) else {
            return Err(Error::Occupied {
                who: two[0],
                by: "every place for two is taken or out of reach: somebody".into(),
            });
        };
        self.num_orders = self.num_orders.wrapping_add(1);
        let until_s = self.time_s + GIVE_UP_S + f64::from(GIVE_UP_WAYS * frames / self.rate_hz);
        for (k, c) in rows.into_iter().enumerate() {
            self.part_pair(c);
            let side = k ^ usize::from(flipped);
            let target = PlanTarget::Node(self.pair_offers[offer as usize].starts[side]);
            self.set_target(self.world.clone().graph(), c, Some(target));
            self.states[c] = self.states[c].with_goal(InhabitantGoal::Meet { tag, seconds });
            let (with, side, stage) = (two[1 - k], side as u8, MeetingStage::Coming);
            let meeting = PairMeeting { with, offer, side, stage, until_s, ready_s: 0.0, rounds: 0 };
            self.states[c].meeting = Some(meeting);
            self.paths.request_path(c);
        }
        Ok(())
    }

    /// Meeting of a character, if there is one.
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn meeting_state(&self, id: Id) -> Result<Option<MeetingState>> {
        let c = self.roster.row(id)?;
        let Some(m) = self.states[c].meeting else { return Ok(None) };
        let other = self.roster.row(m.with)?;
        let has_begun = m.stage > MeetingStage::Ready;
        let waited_s = match m.stage {
            MeetingStage::Coming => 0.0,
            MeetingStage::Ready => self.time_s - m.ready_s,
            _ => self.states[other].meeting.map_or(0.0, |o| (o.ready_s - m.ready_s).max(0.0)),
        };
        let is_with = |c: usize| self.states[c].meeting.is_some_and(|m| m.stage == MeetingStage::Together);
        let partner = (is_with(c) && is_with(other)).then(|| {
            let motion_set = self.world.motion_set();
            let captured = [c, other].map(|c| {
                let (first, frames) = self.characters.scheduled_clip(c);
                motion_set.planar_at(first, frames)
            });
            let relative = |[own, other]: [Planar; 2]| {
                let p = own.to_local(other);
                Planar { heading: wrap_angle(p.heading), ..p }
            };
            [relative([self.roots[c], self.roots[other]]), relative(captured)]
        });
        let tag = self.pair_offers[m.offer as usize].tag;
        Ok(Some(MeetingState { with: m.with, tag, waited_s: waited_s as f32, has_begun, partner }))
    }

    /// Nearest place for two at which both arrive hardly later than at the one reached soonest, whether the first
    /// character takes the second part, and their time to walk there where nothing blocks them (frames).
    fn nearest_pair_offer(&mut self, rows: [usize; 2], tag: u16) -> Option<(u32, bool, f32)> {
        let world = self.world.clone();
        let graph = world.graph();
        let ends = rows.map(|c| self.end_node(c));
        let here = ends.map(|node| graph.place(node).translation());
        let (mut tried, mut num_tried) = ([(NONE, false); MOST_TRIED], 0);
        let mut frames = [f32::INFINITY; MOST_TRIED];
        while num_tried < MOST_TRIED {
            let mut best = (2.0 * TAKEN_M, None);
            for (k, offer) in (0u32..).zip(&self.pair_offers).filter(|(_, o)| o.tag == tag) {
                for flipped in [false, true] {
                    let node = |row: usize| offer.starts[row ^ usize::from(flipped)];
                    let far = |row: usize| {
                        let instance = node(row).instance;
                        let held = self.reservations.other_holder(graph, instance, rows[row] as u32, follow_nobody);
                        let is_taken = held.is_some_and(|c| c as usize != rows[1 - row]);
                        let is_wanted = self.num_bound_for(graph, rows[row], instance) > 0;
                        let away = graph.place(node(row)).translation().distance(here[row]);
                        if is_taken || is_wanted { away + TAKEN_M } else { away }
                    };
                    let cost = far(0).max(far(1));
                    // What is held now may be free by the time they come; what others go to is not.
                    if cost < best.0 && cost < TAKEN_M && !tried[..num_tried].contains(&(k, flipped)) {
                        best = (cost, Some((k, flipped)));
                    }
                }
            }
            let Some((k, flipped)) = best.1 else { break };
            // What is near may be far to walk to: on another floor, or behind a wall.
            let [a, b] = [0, 1].map(|row: usize| {
                let to = self.pair_offers[k as usize].starts[row ^ usize::from(flipped)];
                let least = |planner: &mut WorldPlanner| planner.least_frames(graph, ends[row], PlanTarget::Node(to));
                if ends[row] == to { 0.0 } else { least(&mut self.planner).unwrap_or(f32::INFINITY) }
            });
            frames[num_tried] = a.max(b);
            tried[num_tried] = (k, flipped);
            num_tried += 1;
        }
        let soonest = frames.iter().copied().fold(f32::INFINITY, f32::min);
        let is_soon = |f: &f32| f.is_finite() && *f <= SOON * soonest;
        frames.iter().position(is_soon).map(|at| (tried[at].0, tried[at].1, frames[at]))
    }

    /// Begins the action of two that are both at their places, and gives up meetings that take too long.
    pub(super) fn begin_meetings(&mut self, graph: &WorldGraph) {
        for c in 0..self.states.len() {
            let Some(m) = self.states[c].meeting.filter(|m| m.stage <= MeetingStage::Ready) else { continue };
            let partner = self.partner(c);
            let lost = partner.is_none() || self.states[c].activity == InhabitantActivity::Unreachable;
            let other = partner.unwrap_or(c);
            if lost || self.time_s > m.until_s {
                self.part_pair(c);
                self.finish_goal(c);
                continue;
            }
            let is_ready = |c: usize| self.states[c].meeting.is_some_and(|m| m.stage == MeetingStage::Ready);
            if m.side == 0 && is_ready(c) && is_ready(other) {
                let left = self.characters.frames_left(c).fract().clamp(0.0, 1.0);
                for (c, with) in [(c, m.with), (other, self.roster.ids()[c])] {
                    self.characters.shorten_clip(c, left);
                    self.set_stage(c, MeetingStage::Beginning);
                    self.events.push((self.roster.ids()[c], InhabitantEvent::Began { with }));
                }
            }
        }
        self.break_off(graph);
        self.allow_leaving(graph);
        self.report_parted();
    }

    /// True where the clip of a character has both feet on the ground, whatever step a foot takes by itself.
    fn stands_in_clip(&self, c: usize) -> bool {
        let (first, frames) = self.characters.scheduled_clip(c);
        self.world.motion_set().contacts_at(first, frames).all(BOTH_FEET)
    }

    /// Lets characters that rest after an action of two leave soon, once they have a next goal.
    fn allow_leaving(&mut self, graph: &WorldGraph) {
        for c in 0..self.states.len() {
            let state = &self.states[c];
            let Some(leaves_s) = state.leaves_s.filter(|&leaves_s| leaves_s <= self.time_s) else { continue };
            let knows = match self.paths.target(c) {
                Some(_) => !self.paths.steps_of(c).is_empty(),
                None => state.activity != InhabitantActivity::Arrived,
            };
            if self.time_s - leaves_s > HURRIES_S || !graph.is_rest(state.at) {
                self.states[c].leaves_s = None;
            } else if knows
                && stands_at(graph.place(state.at), self.roots[c])
                && self.stands_in_clip(c)
                && self.characters.frames_left(c) > 1.0
            {
                self.characters.shorten_clip(c, self.characters.frames_left(c).fract());
                self.states[c].leaves_s = None;
            }
        }
    }

    /// Ends the action of two for characters that got another goal, where both feet stand near to a place of rest.
    fn break_off(&mut self, graph: &WorldGraph) {
        for c in 0..self.states.len() {
            let state = &self.states[c];
            if !state.plays_pair || state.meeting.is_some() || self.characters.frames_left(c) <= 1.0 {
                continue;
            }
            if !self.stands_in_clip(c) {
                continue;
            }
            let root = self.roots[c];
            let near = graph.rest_cells(state.at.instance).find(|&node| stands_at(graph.place(node), root));
            if let Some(node) = near {
                let left = self.characters.frames_left(c).fract().clamp(0.0, 1.0);
                self.characters.shorten_clip(c, left);
                let state = &mut self.states[c];
                (state.at, state.plays_pair) = (node, false);
            }
        }
    }

    /// Instance in which the partner will stand, while one is on its way to it.
    pub(super) fn place_of_partner(&self, c: usize) -> Option<u32> {
        let m = self.states[c].meeting.filter(|m| m.stage == MeetingStage::Coming)?;
        Some(self.pair_offers[m.offer as usize].starts[1 - usize::from(m.side)].instance)
    }

    /// Next step of one of two; the inner `None` where it has to wait.
    ///
    /// - returns `None` where it is on its way, or has no partner.
    pub(super) fn decide_together(&mut self, graph: &WorldGraph, c: usize) -> Option<Option<WorldStep>> {
        let m = self.states[c].meeting?;
        let offer = self.pair_offers[m.offer as usize];
        let side = usize::from(m.side);
        let whole = offer.steps[side];
        match m.stage {
            MeetingStage::Coming if is_near(graph, self.states[c].at, offer.starts[side]) => {
                self.reset_patience(c);
                (self.states[c].activity, self.states[c].detour) = (InhabitantActivity::Meeting, 0);
                if let Some(m) = &mut self.states[c].meeting {
                    (m.stage, m.ready_s) = (MeetingStage::Ready, self.time_s);
                }
                Some(self.rest_step(graph, c))
            }
            MeetingStage::Coming => None,
            MeetingStage::Ready => Some(self.rest_step(graph, c)),
            MeetingStage::Beginning => {
                self.set_stage(c, MeetingStage::Entering);
                self.states[c].activity = InhabitantActivity::Performing;
                Some(Some(self.count_pair_step(c, offer.entry_step(side))))
            }
            MeetingStage::Entering => {
                self.set_stage(c, MeetingStage::Together);
                let entered = offer.entry_step(side).to_offset;
                Some(Some(self.count_pair_step(c, WorldStep { from_offset: entered, ..whole })))
            }
            MeetingStage::Together => Some(self.continue_together(graph, c, m)),
        }
    }

    /// Continues after one round: with another one that begins where this one ended, or at the end of the action.
    fn continue_together(&mut self, graph: &WorldGraph, c: usize, m: PairMeeting) -> Option<WorldStep> {
        let offer = self.pair_offers[m.offer as usize];
        let InhabitantGoal::Meet { seconds, .. } = self.states[c].goal else { return self.rest_step(graph, c) };
        let fits = |o: &PairOffer| o.tag == offer.tag && o.starts == offer.ends;
        let num = self.pair_offers.iter().filter(|o| fits(o)).count();
        if num == 0 || self.states[c].performed as f32 / self.rate_hz >= seconds {
            let [least, most] = LINGERS_S;
            let lingers_s = least + (most - least) * self.draw_random(c);
            let state = &mut self.states[c];
            (state.activity, state.meeting) = (InhabitantActivity::Arrived, None);
            state.leaves_s = Some(self.time_s + f64::from(lingers_s));
            state.num_fulfilled = state.num_fulfilled.wrapping_add(1);
            self.events.push((self.roster.ids()[c], InhabitantEvent::Fulfilled));
            return self.rest_step(graph, c);
        }
        // Both draw the same number.
        let both = self.name(c) ^ self.roster.row(m.with).map_or(0, |other| self.name(other));
        let drawn = (uniform_random(self.config.characters.seed, both, u64::from(m.rounds)) * num as f32) as usize;
        let next = (0u32..).zip(&self.pair_offers).filter(|(_, o)| fits(o)).nth(drawn.min(num - 1));
        let (number, next) = next.map(|(k, o)| (k, *o))?;
        if let Some(m) = &mut self.states[c].meeting {
            (m.offer, m.rounds, m.stage) = (number, m.rounds.wrapping_add(1), MeetingStage::Entering);
        }
        Some(self.count_pair_step(c, next.entry_step(usize::from(m.side))))
    }

    /// Counts what one of two plays.
    fn count_pair_step(&mut self, c: usize, step: WorldStep) -> WorldStep {
        let state = &mut self.states[c];
        state.plays_pair = true;
        state.performed = state.performed.saturating_add(step.num_frames());
        step
    }

    /// Ends the meeting of two: one of them does something else. The next step reports it.
    pub(super) fn part_pair(&mut self, c: usize) {
        let other = self.partner(c);
        let Some(m) = self.states[c].meeting.take() else { return };
        let parted = if m.stage <= MeetingStage::Ready { PartingReason::GaveUp } else { PartingReason::BrokeOff };
        self.states[c].parted = Some(parted);
        if let Some(other) = other {
            (self.states[other].meeting, self.states[other].parted) = (None, Some(parted));
            self.finish_goal(other);
        }
    }

    /// Reports the meetings that ended since the last step.
    fn report_parted(&mut self) {
        for c in 0..self.states.len() {
            let event = match self.states[c].parted.take() {
                None => continue,
                Some(PartingReason::GaveUp) => InhabitantEvent::GaveUp,
                Some(PartingReason::BrokeOff) => InhabitantEvent::BrokenOff,
            };
            self.events.push((self.roster.ids()[c], event));
        }
    }

    /// Marks its goal as reached, where it is.
    pub(super) fn finish_goal(&mut self, c: usize) {
        self.states[c].activity = InhabitantActivity::Arrived;
    }

    fn set_stage(&mut self, c: usize, stage: MeetingStage) {
        if let Some(m) = &mut self.states[c].meeting {
            m.stage = stage;
        }
    }

    /// Row of the partner, if the partner's meeting is with this character.
    fn partner(&self, c: usize) -> Option<usize> {
        let other = self.roster.row(self.states[c].meeting?.with).ok()?;
        self.states[other].meeting.is_some_and(|m| m.with == self.roster.ids()[c]).then_some(other)
    }
}

/// True where a root is so near to a place of rest that what is missing goes over.
fn stands_at(place: Placement, root: Planar) -> bool {
    maths::hypot(place.x - root.x, place.z - root.z) < NEAR_REST.0
        && wrap_angle(place.heading - root.heading).abs() < NEAR_REST.1
}

/// True where one rests at a node, or so near to it that the rest goes over when two begin.
fn is_near(graph: &WorldGraph, at: WorldNode, start: WorldNode) -> bool {
    let [a, b] = [at, start].map(|n| graph.place(n));
    let near =
        maths::hypot(a.x - b.x, a.z - b.z) < NEAR_START.0 && wrap_angle(a.heading - b.heading).abs() < NEAR_START.1;
    at == start || at.instance == start.instance && near && graph.is_rest(at)
}

impl PairMeeting {
    /// True where the offer exists, and the character is where the offer has it at this stage.
    ///
    /// - `at`: node that the character's motion leads to (the node exists).
    pub fn is_sound(&self, graph: &WorldGraph, at: WorldNode, offers: &[PairOffer]) -> bool {
        let Some(offer) = offers.get(self.offer as usize).filter(|_| self.side < 2) else { return false };
        let [start, end] = [offer.starts, offer.ends].map(|of| of[usize::from(self.side)]);
        let stands = match self.stage {
            MeetingStage::Coming => true,
            MeetingStage::Ready | MeetingStage::Beginning => is_near(graph, at, start),
            MeetingStage::Entering => at == start,
            MeetingStage::Together => at == end,
        };
        stands && is_time(self.until_s) && is_time(self.ready_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;
    use crate::inhabitants::InhabitantsConfig;
    use crate::made_up_floor::{GIVE, tables, world};
    use glam::Vec3;
    use throng_base::Inline;
    use throng_core::CharacterGroup;

    #[test]
    fn two_are_restored_only_where_they_have_come_to() {
        let tables = tables();
        let world = World::from_data(&world(&tables, &["########"; 3]), &tables).unwrap();
        let mut people = Inhabitants::new(&world, 2, InhabitantsConfig::default()).unwrap();
        let two =
            [0.0, 14.0].map(|x| people.spawn(world.nearest_place(Vec3::new(x, 0.9, 2.0), 1.0).unwrap().node).unwrap());
        people.order_meeting(two, GIVE, 1.0).unwrap();
        let save = |people: &Inhabitants| {
            let mut out = Vec::new();
            people.save(&mut out);
            out
        };
        let mut other = people.clone();
        for stage in [MeetingStage::Ready, MeetingStage::Beginning, MeetingStage::Entering, MeetingStage::Together] {
            people.set_stage(0, stage);
            let e = other.load(&save(&people)).unwrap_err().to_string();
            assert!(e.contains("where the world has no place for two"), "{stage:?}: {e}");
        }
        people.set_stage(0, MeetingStage::Coming);
        let mut seen = Vec::new();
        for _ in 0..300 {
            other.load(&save(&people)).unwrap();
            seen.extend(people.states[0].meeting.map(|m| m.stage));
            people.step(0.1, &Inline).unwrap();
        }
        seen.dedup();
        // It begins and enters within one step of time.
        assert_eq!(
            (seen.first(), seen.last()),
            (Some(&MeetingStage::Coming), Some(&MeetingStage::Together)),
            "{seen:?}"
        );
        assert!(two.iter().all(|&id| people.state(id).unwrap().num_fulfilled == 1), "{seen:?}");
    }
}
