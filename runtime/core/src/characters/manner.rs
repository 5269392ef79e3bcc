//! Manners: a character keeps the manner of its motion until an order names another one.
//!
//! A character that is ordered to a manner takes the actions that lead there soon and to where its goals are worth most, and
//! no others that leave it from then on. Who was never ordered to one follows its policy.

use super::{idle::ERROR_FRAMES, motion_set::MotionSet, order::PolicyOrder};
use crate::bundle::Bundle;
use crate::format::{Gait, MotionClass};
use crate::graph::{MotionGraph, MotionSegment};
use crate::policy::{MAX_RANKED, NO_ACTION};
use crate::stops::{REST, StopRecord};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use throng_base::{Error, Result, maths};

/// Name in orders and errors of the manner of motion that nothing sets apart.
const PLAIN: &str = "normal";
/// Time on the way to a manner by which an action is e times worse (s).
const URGENCY_S: f32 = 0.5;
/// Time that a change of manner is worth on the way to a stand: a short one in the same manner is preferred to a long one in
/// another (frames).
const CHANGE_FRAMES: f32 = 600.0;
/// Gaits between which an order of a speed chooses.
const GAITS: [(Gait, &str); 2] = [(Gait::Walk, "walk"), (Gait::Run, "run")];
/// Difference of velocities by which an action is e times worse (m/s).
const SPEED_MPS: f32 = 0.5;
/// Share of the mean speed of running from which motion serves whoever is ordered to run.
const SERVES: f32 = 0.9;
/// Share of that speed beyond which no motion is sought.
const FASTER: f32 = 1.5;
/// Share of the time that a change of manner is worth on the way to a gait.
const OTHER_MANNER: f32 = 0.25;
/// Least worth of an action for goals, and share that it keeps which leaves the manner that is ordered.
const LEAST_WORTH: f32 = 1e-6;
/// Way before a stop within which speeds are those of the policy (m).
const NEAR_M: f32 = 1.0;
/// Delay from states from which no motion leads to a manner.
const NEVER: u16 = u16::MAX;

/// Name of a manner in an order, of which the first 24 bytes count; none where all are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct MannerName([u8; 24]);

impl MannerName {
    pub const NONE: Self = Self([0; 24]);

    pub fn new(name: &str) -> Self {
        let mut out = [0; 24];
        out.iter_mut().zip(name.bytes()).for_each(|(to, from)| *to = from);
        Self(out)
    }
}

/// Manners of the motion of a graph.
#[derive(Clone, Debug, Default)]
pub(super) struct Manners {
    /// Names, ascending but for that of plain motion.
    names: Vec<String>,
    /// Manner of the motion that leads to each state, by number (num_states, or 0 where all motion is alike).
    of_states: Vec<u16>,
    /// Least time from each state to motion that goes on in each manner, 0 there (frames, num_states each).
    delays: Vec<Vec<u16>>,
    rate_hz: f32,
}

impl Manners {
    pub fn find(bundle: &Bundle) -> Self {
        Self::by_class(bundle, |class| &class.manner).with_delays(
            bundle.graph(),
            bundle.meta().rate_hz as f32,
            &|_, _| 0.0,
        )
    }

    /// Motion sorted by a word on its class; that of clips without classes is of none.
    fn by_class(bundle: &Bundle, word: impl Fn(&MotionClass) -> &str) -> Self {
        let (clips, rows) = (&bundle.meta().clips, bundle.clips());
        let mut names: Vec<&str> = clips.iter().flat_map(|c| &c.classes).map(|span| word(&span.class)).collect();
        names.sort_unstable();
        names.dedup();
        if names.len() < 2 {
            return Self::default();
        }
        let of_state = |frame: u32| {
            let clip = rows.partition_point(|c| c.first_frame <= frame) - 1;
            let within = frame - rows[clip].first_frame;
            let span = clips[clip].classes.iter().find(|span| span.frames.contains(&within));
            span.and_then(|span| names.binary_search(&word(&span.class)).ok()).map_or(u16::MAX, |n| n as u16)
        };
        let of_states = bundle.graph().states.iter().map(|s| of_state(s.frame)).collect();
        let names = names.into_iter().map(|name| if name.is_empty() { PLAIN } else { name });
        Self { names: names.map(str::to_owned).collect(), of_states, ..Self::default() }
    }

    /// Motion of which the first half of the states is calm and the other half sad.
    #[cfg(test)]
    pub fn made_up(graph: &MotionGraph) -> Self {
        let (names, num) = (["calm", "sad"].map(str::to_owned).to_vec(), graph.states.len());
        let of_states = (0..num).map(|s| u16::from(2 * s >= num)).collect();
        Self { names, of_states, ..Self::default() }.with_delays(graph, 30.0, &|_, _| 0.0)
    }

    /// - `extra`: time that an action from one state to another is worth besides (frames).
    fn with_delays(self, graph: &MotionGraph, rate_hz: f32, extra: &impl Fn(u32, u32) -> f32) -> Self {
        let delays = |manner| find_delays(graph, &self.of_states, manner as u16, extra);
        Self { delays: (0..self.names.len()).map(delays).collect(), rate_hz, ..self }
    }

    /// True where motion to one state is in the manner of that to another.
    pub fn are_alike(&self, a: u32, b: u32) -> bool {
        self.of_states.is_empty() || self.of_states[a as usize] == self.of_states[b as usize]
    }

    /// Cost of motion from one state to another on the way to a stand, beside its time (frames).
    pub fn change_frames(&self, from: u32, to: u32) -> f32 {
        if self.are_alike(from, to) { 0.0 } else { CHANGE_FRAMES }
    }

    /// True where motion to a state is in a manner, and can go on in it.
    fn goes_on(&self, state: u32, manner: usize) -> bool {
        self.delays[manner][state as usize] == 0
    }

    /// Number of a manner.
    fn find_name(&self, name: MannerName) -> Option<usize> {
        let position = self.names.iter().position(|known| MannerName::new(known) == name)?;
        self.delays[position].contains(&0).then_some(position)
    }

    /// Names of the manners in which motion goes on for ever.
    pub fn known(&self) -> impl Iterator<Item = &str> {
        let named = self.names.iter().zip(&self.delays);
        named.filter(|(_, delays)| delays.contains(&0)).map(|(name, _)| name.as_str())
    }

    /// Name of the manner of the motion that leads to a state; empty where no frame there has a class.
    pub fn name_of(&self, state: u32) -> &str {
        let number = self.of_states.get(state as usize).copied().unwrap_or(u16::MAX);
        self.names.get(usize::from(number)).map_or("", String::as_str)
    }

    /// Checks that there is a manner.
    ///
    /// # Errors
    /// [`throng_base::Error::Unknown`] with those there are.
    pub fn check(&self, name: MannerName) -> Result<()> {
        if name == MannerName::NONE || self.find_name(name).is_some() {
            return Ok(());
        }
        Err(self.unknown(String::from_utf8_lossy(&name.0).trim_end_matches('\0')))
    }

    /// The error of a name that is none.
    pub fn unknown(&self, name: &str) -> Error {
        Error::Unknown { what: "manner", name: name.to_owned(), known: self.known().map(str::to_owned).collect() }
    }

    /// The manner to which a character would still be on its way in a state, by number.
    #[inline]
    pub fn wanted(&self, name: MannerName, state: u32) -> Option<usize> {
        if name == MannerName::NONE {
            return None;
        }
        self.find_name(name).filter(|&manner| self.of_states[state as usize] != manner as u16)
    }

    /// The best actions on the way to a manner, or within it, best first; [`NO_ACTION`] beyond the last one.
    ///
    /// - `worth`: of the end of a segment, by its number, for what the character is about besides (> 0).
    pub fn ranked_actions(
        &self,
        graph: &MotionGraph,
        state: u32,
        manner: usize,
        worth: impl Fn(u32) -> f32,
    ) -> [u8; MAX_RANKED] {
        let (segments, errors) = graph.actions_of(state);
        let mut best = [(0.0, NO_ACTION); MAX_RANKED];
        for (action, (&s, error)) in segments.iter().zip(errors).enumerate() {
            let segment = &graph.segments[s as usize];
            let left = self.delays[manner][segment.end as usize];
            // Who goes on in it already leaves it no more.
            if left == NEVER || left > 0 && self.goes_on(state, manner) {
                continue;
            }
            let delay_s = (action_frames(segment, *error) + f32::from(left)) / self.rate_hz;
            let mut entry = (worth(s) * maths::exp(-delay_s / URGENCY_S), action as u8);
            for kept in &mut best {
                if kept.1 == NO_ACTION || kept.0 < entry.0 {
                    std::mem::swap(kept, &mut entry);
                }
            }
        }
        best.map(|kept| kept.1)
    }

    /// A state in which motion of a manner goes on, one in which characters rest where there is any.
    ///
    /// - `draw`: which of them (0 to 1).
    pub fn draw_state(&self, stops: &[StopRecord], manner: usize, draw: f32) -> Option<u32> {
        let goes_on = || (0..stops.len()).filter(|&s| self.delays[manner][s] == 0);
        let rests = || goes_on().filter(|&s| stops[s].kind == REST);
        let nth = |count: usize| (draw * count as f32) as usize;
        rests().nth(nth(rests().count())).or_else(|| goes_on().nth(nth(goes_on().count()))).map(|s| s as u32)
    }
}

/// Gaits of the motion of a graph: characters that are ordered a speed take that whose usual speed is nearest to it.
#[derive(Clone, Debug, Default)]
pub(super) struct Gaits {
    /// Motion sorted by [`GAITS`]; all other motion has no name.
    sorted: Manners,
    /// Mean speeds (m/s); none of a gait that leads nowhere.
    means: [Option<f32>; GAITS.len()],
}

impl Gaits {
    pub fn find(bundle: &Bundle, manners: &Manners) -> Self {
        let gait = |class: &MotionClass| GAITS.iter().position(|(gait, _)| *gait == class.gait);
        let (graph, rate_hz) = (bundle.graph(), bundle.meta().rate_hz as f32);
        let sorted = Manners::by_class(bundle, |class| gait(class).map_or("", |number| GAITS[number].1));
        let sorted = sorted.with_delays(graph, rate_hz, &|from, to| OTHER_MANNER * manners.change_frames(from, to));
        let means = GAITS.map(|(_, name)| {
            let number = sorted.find_name(MannerName::new(name))?;
            let own = || graph.segments.iter().filter(|s| sorted.goes_on(s.end, number));
            let way: f32 = own().map(|s| maths::hypot(s.displacement[0], s.displacement[1])).sum();
            Some(way * rate_hz / own().map(|s| s.num_frames as f32).sum::<f32>().max(1.0))
        });
        Self { sorted, means }
    }

    /// Number in `sorted` of the gait for a speed, the speed that is sought in it, and that from which its motion serves (m/s): whoever
    /// is to run does not jog where there is more.
    fn gait_at(&self, speed_mps: f32) -> Option<(usize, f32, f32)> {
        let known = (0..GAITS.len()).filter_map(|gait| Some((gait, self.means[gait]?)));
        let (gait, mean) = known.min_by(|a, b| (a.1 - speed_mps).abs().total_cmp(&(b.1 - speed_mps).abs()))?;
        let number = self.sorted.find_name(MannerName::new(GAITS[gait].1))?;
        Some(if GAITS[gait].0 == Gait::Run {
            (number, speed_mps.clamp(mean, FASTER * mean), SERVES * mean)
        } else {
            (number, mean, 0.0)
        })
    }
}

/// A character that follows an order, at its choice.
pub(super) struct OrderedChoice<'a> {
    pub motion_set: &'a MotionSet,
    pub order: &'a PolicyOrder,
    pub state: u32,
    /// The action that its policies, or its stand, would take, and whether it stands with that as before.
    pub chosen: u8,
    pub stays: bool,
    /// The way to its target as it sees it (m); none where that is no place.
    pub left: Option<Vec2>,
}

impl OrderedChoice<'_> {
    /// Actions to try first, best first, for the manner and the speed that it is ordered; none where the chosen one serves.
    ///
    /// - `worth`: of the end of a segment, by its number, for its goals (>= 0).
    pub fn preferred(&self, worth: impl Fn(u32) -> f32) -> Option<[u8; MAX_RANKED]> {
        let Self { motion_set, order, state, .. } = *self;
        let (graph, manners, gaits) = (&motion_set.graph, &motion_set.manners, &motion_set.gaits);
        let segment = graph.segments_of(state).get(usize::from(self.chosen)).copied();
        let end = segment.map_or(state, |s| graph.segments[s as usize].end);
        // Who stands, or is to stand, does so in any manner.
        let may_change = self.stays || !order.is_to_stand();
        if let Some(manner) = manners.wanted(order.manner, end).filter(|_| may_change) {
            return Some(manners.ranked_actions(graph, state, manner, |s| worth(s).max(LEAST_WORTH)));
        }
        let speed = order.speed_mps.filter(|speed| *speed > 0.0 && !self.stays)?;
        let (left, (gait, wanted_mps, least)) = (self.left?, gaits.gait_at(speed)?);
        // Who is near slows down as its policy says.
        let stop_m = wanted_mps * motion_set.stops.stops[end as usize].frames as f32 / motion_set.rate_hz;
        let velocity = |segment: &MotionSegment| {
            let [x, z, _] = segment.displacement;
            Vec2::new(x, z) * (motion_set.rate_hz / segment.num_frames.max(1) as f32)
        };
        let is_fast = segment.is_some_and(|s| velocity(&graph.segments[s as usize]).length() >= least);
        if left.length() < stop_m + NEAR_M || is_fast && gaits.sorted.goes_on(end, gait) {
            return None;
        }
        let wanted = left.normalize_or_zero() * wanted_mps;
        let share = |s: u32| {
            let segment = &graph.segments[s as usize];
            let off = velocity(segment) - wanted;
            let change = OTHER_MANNER * manners.change_frames(state, segment.end) / motion_set.rate_hz;
            let keeps = order.manner == MannerName::NONE || manners.are_alike(end, segment.end);
            maths::exp(-off.length() / SPEED_MPS - change / URGENCY_S) * if keeps { 1.0 } else { LEAST_WORTH }
        };
        Some(gaits.sorted.ranked_actions(graph, state, gait, |s| worth(s).max(LEAST_WORTH) * share(s)))
    }
}

/// Time that an action takes, with what its transition is worth (frames).
fn action_frames(segment: &MotionSegment, error: f32) -> f32 {
    segment.num_frames as f32 + ERROR_FRAMES * error
}

/// Least time from each state to motion of a manner from which the motion can go on in it for ever (frames).
fn find_delays(graph: &MotionGraph, of_states: &[u16], manner: u16, extra: &impl Fn(u32, u32) -> f32) -> Vec<u16> {
    let mut out: Vec<u16> = of_states.iter().map(|&m| if m == manner { 0 } else { NEVER }).collect();
    let ends = |s: usize| graph.segments_of(s as u32).iter().map(|&s| graph.segments[s as usize].end as usize);
    loop {
        let ended: Vec<usize> = (0..out.len()).filter(|&s| out[s] == 0 && ends(s).all(|end| out[end] != 0)).collect();
        if ended.is_empty() {
            break;
        }
        ended.into_iter().for_each(|s| out[s] = NEVER);
    }
    loop {
        let mut has_changed = false;
        for state in (0..out.len()).rev() {
            let (segments, errors) = graph.actions_of(state as u32);
            let after = |(&s, error): (&u32, &f32)| {
                let segment = &graph.segments[s as usize];
                (f32::from(out[segment.end as usize])
                    + action_frames(segment, *error)
                    + extra(state as u32, segment.end))
                .min(f32::from(NEVER)) as u16
            };
            let least = segments.iter().zip(errors).map(after).min().unwrap_or(NEVER);
            if least < out[state] {
                (out[state], has_changed) = (least, true);
            }
        }
        if !has_changed {
            return out;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::StateRecord;
    use crate::stops::WALK_ON;

    #[test]
    fn motion_without_classes_is_alike_and_manners_differ() {
        let none = Manners::find(&super::super::tests::tables());
        assert!(none.are_alike(0, 3) && none.check(MannerName::NONE).is_ok());
        let e = none.check(MannerName::new("sad")).unwrap_err().to_string();
        assert!(e.contains("sad"), "{e}");
        let two = Manners { of_states: vec![0, 1, 0], ..Manners::default() };
        assert!(two.are_alike(0, 2) && !two.are_alike(0, 1));
    }

    /// Five states, each of which leads to the next ones, of manners 0, 0, 1, 1 and 2.
    fn chain() -> (MotionGraph, Manners) {
        let state = |frame| StateRecord { frame, standing: u32::from(frame == 30) };
        let segment = |(start, end, num_frames)| MotionSegment {
            start,
            num_frames,
            end,
            clip: 0,
            displacement: [0.0, 0.1, 0.0],
            idle: 0,
        };
        let actions = [vec![1], vec![0, 2], vec![3, 4], vec![2, 0], vec![0]];
        let mut ends: Vec<u32> = actions.concat();
        ends.sort_unstable();
        ends.dedup();
        let graph = MotionGraph {
            states: (0..5).map(|s| state(10 * s)).collect::<Vec<_>>().into(),
            segments: ends.iter().map(|&end| segment((10 * end, end, 10))).collect::<Vec<_>>().into(),
            action_offsets: vec![0, 1, 3, 5, 7, 8].into(),
            action_segments: actions.concat().into(),
            action_errors: vec![0.0; 8].into(),
        };
        let names = ["angry", "normal", "sad"].map(str::to_owned).to_vec();
        let manners = Manners { names, of_states: vec![0, 0, 1, 1, 2], ..Manners::default() };
        let manners = manners.with_delays(&graph, 10.0, &|_, _| 0.0);
        (graph, manners)
    }

    #[test]
    fn the_shortest_way_to_a_manner_is_taken_and_left_no_more() {
        let (graph, manners) = chain();
        assert_eq!(manners.delays[..2], [vec![0, 0, 20, 10, 10], vec![20, 10, 0, 0, 30]]);
        // One state of "sad", which leads away from it: nobody stays in that manner.
        assert!(manners.delays[2].iter().all(|&d| d == NEVER));
        let e = manners.check(MannerName::new("sad")).unwrap_err().to_string();
        assert!(e.contains("angry") && e.contains("normal"), "{e}");
        let normal = MannerName::new("normal");
        assert!(manners.check(normal).is_ok());
        let wanted = [0, 1, 2, 3, 4].map(|state| manners.wanted(normal, state));
        assert_eq!(wanted, [Some(1), Some(1), None, None, Some(1)]);
        assert_eq!(manners.wanted(MannerName::NONE, 0), None);
        let ranked = |state| manners.ranked_actions(&graph, state, 1, |_| 1.0);
        assert_eq!(ranked(1), [1, 0, NO_ACTION, NO_ACTION], "on to the third state, then back");
        assert_eq!(
            manners.ranked_actions(&graph, 1, 1, |s| if graph.segments[s as usize].end == 0 { 1e3 } else { 1e-3 })[0],
            0,
            "far more worth"
        );
        let stop = |kind| StopRecord { kind, ..bytemuck::Zeroable::zeroed() };
        let drawn = |kinds: [u32; 5]| [0.0, 0.9].map(|draw| manners.draw_state(&kinds.map(stop), 1, draw));
        assert_eq!(drawn([REST, REST, WALK_ON, REST, REST]), [Some(3); 2], "the one that rests");
        assert_eq!(drawn([REST, REST, WALK_ON, WALK_ON, REST]), [Some(2), Some(3)]);
    }

    #[test]
    fn names_longer_than_an_order_holds_are_known_by_their_begin() {
        let long = "a".repeat(30);
        assert!(
            MannerName::new(&long) == MannerName::new(&long[..24]) && MannerName::new("a") != MannerName::new("ab")
        );
    }
}
