//! Search for similar event frames.

use super::choose::{self, LinkChoice, MotionOutcome};
use super::connect::{EventLinks, GraphInputs};
use super::events::{EventFrame, EventFrameKind};
use super::tree::{PointTree, PointTreeWalk};
use crate::features::projection::{ProjectedPoint, project, squared_reach};
use crate::share::{exchange_values, gather_all, gather_rows, is_own, own_numbers};
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use throng_base::Comm;
use throng_core::{Planar, planar::wrap_angle};
use throng_motion::clip::{ClipSet, FrameId};
use throng_motion::{error::Result, progress::Progress};

/// A possible transition: the motion after event `event` may follow another event.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct TransitionLink {
    /// Event whose motion follows: 32 bits, as there are millions of links.
    to: u32,
    /// Distance between the two frames (rad).
    pub error: f32,
}

impl TransitionLink {
    /// - `event`: whose motion follows (< 2^32, as for frames).
    pub fn new(event: usize, error: f32) -> Self {
        Self { to: event as u32, error }
    }

    /// Event whose motion follows.
    pub fn event(&self) -> usize {
        self.to as usize
    }

    /// Sort key of the link, better first.
    pub fn rank(&self) -> LinkRank {
        LinkRank { error_bits: self.error.to_bits(), event: self.event() }
    }
}

/// Sort key of links, better first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct LinkRank {
    /// Bits of the distance of the poses, which is not negative.
    error_bits: u32,
    /// Event whose motion follows.
    event: usize,
}

impl LinkRank {
    /// The link that has this key.
    fn link(self) -> TransitionLink {
        TransitionLink::new(self.event, f32::from_bits(self.error_bits))
    }
}

/// A link with the event that it leaves.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct EventEdge {
    pub from: u32,
    pub link: TransitionLink,
}

impl EventEdge {
    /// Sort key: best first, on a tie from the earliest event to the earliest.
    pub fn rank(&self) -> (u32, u32, usize) {
        (self.link.error.to_bits(), self.from, self.link.event())
    }
}

/// Next event in the run of each event, to which motion continues (events.len()).
pub(super) fn successors(events: &[EventFrame]) -> Vec<Option<usize>> {
    let mut next: Vec<Option<usize>> =
        events.windows(2).enumerate().map(|(i, w)| (w[0].run == w[1].run).then_some(i + 1)).collect();
    next.resize(events.len(), None);
    next
}

/// Nearest links that every event keeps besides those that may be chosen, to join the parts of the graph.
pub(super) const NEAREST: usize = 64;
/// Events of a rank whose links are exchanged between ranks at once.
pub(super) const AT_ONCE: usize = 1 << 14;
/// Search radius that contains nothing.
const DONE: f32 = -1.0;
/// Events from which a threshold is estimated.
const SAMPLE: usize = 256;

/// Limits of the search for links.
#[derive(Clone, Copy)]
pub(super) struct LinkLimits {
    /// Largest distance (rad).
    pub error: f32,
    /// Events nearer to each other in the same run are not linked (frames).
    pub min_jump: u32,
    /// Most points compared for the best link of an event to each kind of outcome, nearest first, so that time grows
    /// with the number of events and not with its square.
    pub points_per_kind: usize,
    /// Most points compared for all other links of an event, likewise nearest first.
    pub points_per_event: usize,
}

/// Finds similar events through k-d trees over points whose distance never exceeds that of the frames: equal to
/// comparing all pairs if [`LinkLimits`] allow enough comparisons.
pub(super) struct LinkFinder<'a> {
    given: GraphInputs<'a>,
    limits: LinkLimits,
    points: Vec<ProjectedPoint>,
    /// Events with a successor, by their kind and that of their outcome.
    trees: BTreeMap<EventFrameKind, Vec<PointTree>>,
    /// Previous and next event in the standing run of each event (events.len()).
    beside: Vec<[Option<usize>; 2]>,
    next: Vec<Option<usize>>,
    /// Best link of each of this rank's events to each kind of outcome, best first (events.len(); empty for other
    /// events).
    of_kinds: EventLinks,
}

impl<'a> LinkFinder<'a> {
    /// - `comm`: processes that search for the other events.
    ///
    /// # Errors
    /// [`throng_motion::error::BuildError::Stopped`] if the progress is stopped.
    pub fn new(given: GraphInputs<'a>, limits: LinkLimits, progress: &dyn Progress, comm: &dyn Comm) -> Result<Self> {
        let GraphInputs { events, features, outcomes, .. } = given;
        let points = project(features);
        let next = successors(events);
        let mut parts = BTreeMap::<_, Vec<(u32, ProjectedPoint)>>::new();
        for i in (0..events.len()).filter(|&i| next[i].is_some()) {
            parts.entry((events[i].kind, outcomes[i].kind)).or_default().push((i as u32, points[i]));
        }
        let mut trees = BTreeMap::<EventFrameKind, Vec<PointTree>>::new();
        parts.into_iter().for_each(|((kind, _), part)| trees.entry(kind).or_default().push(PointTree::new(part)));
        let mut beside = vec![[None; 2]; events.len()];
        let standing: Vec<usize> = (0..events.len()).filter(|&i| events[i].standing_run.is_some()).collect();
        for pair in standing.windows(2).filter(|w| events[w[0]].standing_run == events[w[1]].standing_run) {
            beside[pair[0]][1] = Some(pair[1]);
            beside[pair[1]][0] = Some(pair[0]);
        }
        let mut finder = Self { given, limits, points, trees, beside, next, of_kinds: Vec::new() };
        let own = own_numbers(comm, events.len());
        progress.begin("graph", own.len() as u64, "event frames");
        let of_kinds = |search: &mut LinkSearch, i: usize| {
            progress.check()?;
            let trees = finder.trees_of(i).iter();
            let mut best: Vec<TransitionLink> =
                trees.filter_map(|tree| finder.nearest_links(i, tree, search)).collect();
            choose::sort(&mut best);
            progress.advance(1);
            Ok(best)
        };
        let found = own.par_iter().map_init(LinkSearch::default, |search, &i| of_kinds(search, i));
        let found: Result<EventLinks> = found.collect();
        finder.of_kinds = scatter_to_all(events.len(), &own, found?);
        progress.end();
        Ok(finder)
    }

    /// Similar events of each of this rank's events that a graph may need, best first (events.len(); empty for other
    /// events).
    ///
    /// - `threshold`: largest one at which links will be chosen.
    ///
    /// A link is possible from any event to one of equal kind up to the limit, except events without a successor,
    /// events nearer than `min_jump` frames in the same run, and within one standing run all but the local minima of
    /// the distance. Kept are those of the compared links of an event that [`choose::choose`] may choose up to the
    /// threshold, the nearest 64, and the reverse of every link kept for another event, so that no event is lost
    /// because similar ones have many others.
    ///
    /// # Errors
    /// [`throng_base::Error::Rank`].
    pub fn links(&self, threshold: f32, comm: &dyn Comm) -> Result<EventLinks> {
        let events = self.given.events;
        let (own, num_ranks) = (own_numbers(comm, events.len()), comm.num_ranks());
        let kept = |search: &mut LinkSearch, &i: &usize| self.kept_links(i, threshold, NEAREST, search);
        let back = |(&i, links): (&usize, &Vec<TransitionLink>)| -> Vec<(u32, TransitionLink)> {
            let back = links.iter().map(|l| (l.to, TransitionLink::new(i, l.error)));
            back.filter(|(from, link)| self.is_possible(*from as usize, link)).collect()
        };
        let mut links: EventLinks = vec![Vec::new(); own.len()];
        for first in (0..events.len().div_ceil(num_ranks)).step_by(AT_ONCE) {
            let block = first.min(own.len())..(first + AT_ONCE).min(own.len());
            let found: EventLinks = own[block.clone()].par_iter().map_init(LinkSearch::default, kept).collect();
            let ways_back: Vec<Vec<(u32, TransitionLink)>> =
                own[block.clone()].par_iter().zip(&found).map(back).collect();
            links[block].iter_mut().zip(found).for_each(|(links, found)| links.extend(found));
            let mut to = vec![Vec::new(); num_ranks];
            for (from, link) in ways_back.into_iter().flatten() {
                to[from as usize % num_ranks].push(EventEdge { from, link });
            }
            for EventEdge { from, link } in exchange_values(comm, to)? {
                links[from as usize / num_ranks].push(link);
            }
        }
        links.par_iter_mut().for_each(|links| {
            choose::sort(links);
            links.dedup_by_key(|l| l.event());
            links.shrink_to_fit();
        });
        Ok(scatter_to_all(events.len(), &own, links))
    }

    /// Best link of every event to each kind of outcome, best first (events.len()).
    ///
    /// # Errors
    /// [`throng_base::Error::Rank`].
    pub fn best_of_kinds(mut self, comm: &dyn Comm) -> Result<EventLinks> {
        let own = own_numbers(comm, self.of_kinds.len());
        gather_rows(comm, self.of_kinds.len(), own.iter().map(|&i| std::mem::take(&mut self.of_kinds[i])).collect())
    }

    /// Threshold at which about so many links of an event are chosen; the limit if there are never as many.
    ///
    /// Estimated from a sample of this set, as useful distances differ much between sets.
    ///
    /// # Errors
    /// [`throng_base::Error::Rank`].
    pub fn threshold_for(&self, branching: f64, comm: &dyn Comm) -> Result<f32> {
        let events = self.given.events;
        let sample: Vec<usize> = (0..events.len()).step_by(events.len().div_ceil(SAMPLE).max(1)).collect();
        let own: Vec<usize> = sample.iter().copied().filter(|&i| is_own(comm, i)).collect();
        let chosen = |search: &mut LinkSearch, &i: &usize| self.kept_links(i, self.limits.error, 0, search);
        let mut links =
            gather_all(comm, own.par_iter().map_init(LinkSearch::default, chosen).flatten_iter().collect())?;
        choose::sort(&mut links);
        let enough = (branching * sample.len() as f64) as usize;
        Ok(links.get(enough).map_or(self.limits.error, |l| l.error))
    }

    /// Largest distance of links (rad).
    pub fn reach(&self) -> f32 {
        self.limits.error
    }

    /// Possible target events of an event, by kind of outcome.
    fn trees_of(&self, i: usize) -> &[PointTree] {
        self.trees.get(&self.given.events[i].kind).map_or(&[], Vec::as_slice)
    }

    /// The distance of two events where it is at most `limit`.
    fn distance_within(&self, i: usize, k: usize, limit: f32) -> Option<f32> {
        let (a, b) = (FrameId(i as u32), FrameId(k as u32));
        // An equally near event may still have a lower number.
        let squared = (limit * (1.0 + 1e-6)).min(self.limits.error).powi(2);
        self.given.features.squared_distance_within(a, b, squared).map(f32::sqrt)
    }

    /// True if motion may jump from event `i` along a link within the limit.
    fn is_possible(&self, i: usize, link: &TransitionLink) -> bool {
        let (a, b) = (&self.given.events[i], &self.given.events[link.event()]);
        let is_near = a.run == b.run && a.frame.0.abs_diff(b.frame.0) < self.limits.min_jump;
        // Neighbours in a standing run are nearly equal poses, so only local minima count.
        let [before, after] = self.beside[link.event()].map(|k| k.filter(|&k| k != i));
        let distance = |k: Option<usize>| k.and_then(|k| self.distance_within(i, k, self.limits.error));
        link.event() != i
            && self.next[link.event()].is_some()
            && !is_near
            && distance(before).is_none_or(|d| d > link.error)
            && distance(after).is_none_or(|d| d >= link.error)
    }

    /// Links of an event kept for its own sake: those that may be chosen up to the threshold, and some of the nearest.
    fn kept_links(&self, i: usize, threshold: f32, num_nearest: usize, search: &mut LinkSearch) -> Vec<TransitionLink> {
        let threshold = threshold.min(self.limits.error);
        let LinkSearch { walk, nearest, known, others } = search;
        // Radius up to which nearest links are still wanted.
        let mut limit = if num_nearest > 0 { self.limits.error } else { 0.0 };
        let mut looks = self.limits.points_per_event;
        walk.visit(self.trees_of(i), &self.points[i], squared_reach(limit.max(threshold)), |k, gap| {
            looks = looks.saturating_sub(1);
            if gap > squared_reach(limit) {
                others.push((gap, k as usize));
                return if looks > 0 { squared_reach(limit.max(threshold)) } else { DONE };
            }
            let error = self.distance_within(i, k as usize, limit.max(threshold));
            let link = error.map(|error| TransitionLink::new(k as usize, error));
            if let Some(link) = link.filter(|l| self.is_possible(i, l)) {
                known.push(Reverse(link.rank()));
                nearest.push(link.rank());
                if nearest.len() > num_nearest {
                    nearest.pop();
                }
                if nearest.len() == num_nearest {
                    limit = nearest.peek().map_or(0.0, |worst| worst.link().error);
                }
            }
            if looks > 0 { squared_reach(limit.max(threshold)) } else { DONE }
        });
        let mut choice = LinkChoice::new(&self.of_kinds[i], &self.given);
        others.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Once a better link leads to a place, others to it are skipped without computing their distance.
        let take_before = |gap: f32, choice: &mut LinkChoice<'_>, known: &mut BinaryHeap<Reverse<LinkRank>>| {
            while let Some(link) = known.peek().map(|k| k.0.link()).filter(|l| squared_reach(l.error) < gap) {
                known.pop();
                if link.error <= threshold && choice.accepts(link.event()) && self.is_possible(i, &link) {
                    choice.chosen.push(link);
                }
            }
        };
        for (gap, k) in others.drain(..) {
            take_before(gap, &mut choice, known);
            if choice.accepts(k) {
                let error = self.distance_within(i, k, threshold);
                known.extend(error.map(|error| Reverse(TransitionLink::new(k, error).rank())));
            }
        }
        take_before(f32::INFINITY, &mut choice, known);
        nearest.drain().map(LinkRank::link).chain(choice.chosen).collect()
    }

    /// Nearest possible link to an event of a tree.
    fn nearest_links(&self, i: usize, tree: &PointTree, search: &mut LinkSearch) -> Option<TransitionLink> {
        let (mut best, mut limit): (Option<TransitionLink>, f32) = (None, self.limits.error);
        let (mut looks, trees) = (self.limits.points_per_kind, std::slice::from_ref(tree));
        search.walk.visit(trees, &self.points[i], squared_reach(limit), |k, _| {
            looks = looks.saturating_sub(1);
            let error = self.distance_within(i, k as usize, limit);
            let link = error.map(|error| TransitionLink::new(k as usize, error));
            let is_better = |l: &TransitionLink| best.is_none_or(|b| l.rank() < b.rank());
            if let Some(link) = link.filter(|l| is_better(l) && self.is_possible(i, l)) {
                (best, limit) = (Some(link), link.error);
            }
            if looks > 0 { squared_reach(limit) } else { DONE }
        });
        best
    }
}

/// Scatters the values of this rank's events to their indices among all.
fn scatter_to_all<T>(num_events: usize, own: &[usize], of_own: Vec<Vec<T>>) -> Vec<Vec<T>> {
    let mut all: Vec<Vec<T>> = std::iter::repeat_with(Vec::new).take(num_events).collect();
    own.iter().zip(of_own).for_each(|(&i, links)| all[i] = links);
    all
}

/// Scratch memory of the search for the links of an event, reused for the next.
#[derive(Default)]
struct LinkSearch {
    walk: PointTreeWalk,
    /// Ranks of the nearest possible links, worst on top.
    nearest: BinaryHeap<LinkRank>,
    /// Ranks of links with known distance, best on top.
    known: BinaryHeap<Reverse<LinkRank>>,
    /// Squared distances of points, with their events.
    others: Vec<(f32, usize)>,
}

/// Outcomes of the motion after each event, in the event's frame.
pub(super) fn motion_outcomes(events: &[EventFrame], clips: &ClipSet, horizon_s: f64) -> Vec<MotionOutcome> {
    let starts = clips.frame_starts();
    let of_event = |e: &EventFrame| {
        let clip = &clips.clips[e.clip];
        let horizon = ((horizon_s * clip.rate_hz).round() as u32).max(1);
        let last = FrameId((e.frame.0 + horizon).min(e.run_end.0 - 1));
        MotionOutcome::new(displacement(clips, &starts, e.clip, e.frame, last))
    };
    events.par_iter().map(of_event).collect()
}

/// Planar root of frame `to` relative to `from`, both of clip `clip`; the heading counts full turns.
pub(super) fn displacement(clips: &ClipSet, starts: &[u32], clip: usize, from: FrameId, to: FrameId) -> Planar {
    let c = &clips.clips[clip];
    let (from, to) = ((from.0 - starts[clip]) as usize, (to.0 - starts[clip]) as usize);
    let (first, mut previous) = (c.planar(from), c.planar(from));
    let mut turned = 0.0;
    for f in from + 1..=to {
        let p = c.planar(f);
        turned += wrap_angle(p.heading - previous.heading);
        previous = p;
    }
    Planar { heading: turned, ..first.to_local(previous) }
}
