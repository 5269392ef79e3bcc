//! Which event frames are alike.

use super::choose;
use super::config::GraphConfig;
use super::events::{Event, EventKind};
use super::tree::Tree;
use crate::features::Features;
use crate::features::projection::{Point, project, squared_reach};
use rayon::prelude::*;
use std::collections::BTreeMap;
use throng_core::Planar;
use throng_core::planar::wrap_angle;
use throng_motion::clip::{ClipSet, FrameId};
use throng_motion::progress::Progress;

/// A transition that is possible: the motion that follows event `event` may be laid after another event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// The event whose motion follows.
    pub event: usize,
    /// Distance between the two frames (rad).
    pub error: f32,
}

/// The event after each one in its run; motion goes on to it (events.len()).
pub(super) fn successors(events: &[Event]) -> Vec<Option<usize>> {
    let mut next: Vec<Option<usize>> =
        events.windows(2).enumerate().map(|(i, w)| (w[0].run == w[1].run).then_some(i + 1)).collect();
    next.resize(events.len(), None);
    next
}

/// Nearest links that every event keeps besides those that may be chosen: what may join the parts of the graph.
pub(super) const NEAREST: usize = 64;
/// By how much the radius of a search grows until it holds enough.
const GROWTH: f32 = 1.5;

/// Finds which events are alike, through k-d trees over points whose distance is never above that of the frames: the
/// same as by looking at all pairs.
pub(super) struct Finder<'a> {
    events: &'a [Event],
    features: &'a Features,
    outcomes: &'a [Planar],
    limit: f32,
    min_jump: u32,
    config: &'a GraphConfig,
    points: Vec<Point>,
    /// The events that motion goes on from, by their kind and that of their outcome.
    trees: BTreeMap<EventKind, Vec<Tree>>,
    /// Events before and after each in its standing run (events.len()).
    beside: Vec<[Option<usize>; 2]>,
    next: Vec<Option<usize>>,
    /// The best link of every event to each kind of outcome (events.len()).
    of_kinds: Vec<Vec<Link>>,
}

impl<'a> Finder<'a> {
    /// - `outcomes`: where the motion after each event leads.
    /// - `limit`: largest distance (rad).
    /// - `min_jump`: events nearer to each other in the same run are not linked (frames).
    pub fn new(
        events: &'a [Event],
        features: &'a Features,
        outcomes: &'a [Planar],
        limit: f32,
        min_jump: u32,
        config: &'a GraphConfig,
        progress: &dyn Progress,
    ) -> Self {
        let points = project(features, &events.iter().map(|e| e.frame).collect::<Vec<_>>());
        let next = successors(events);
        let mut parts = BTreeMap::<_, Vec<(u32, Point)>>::new();
        for i in (0..events.len()).filter(|&i| next[i].is_some()) {
            parts.entry((events[i].kind, choose::kind_of(&outcomes[i]))).or_default().push((i as u32, points[i]));
        }
        let mut trees = BTreeMap::<EventKind, Vec<Tree>>::new();
        parts.into_iter().for_each(|((kind, _), part)| trees.entry(kind).or_default().push(Tree::new(part)));
        let mut beside = vec![[None; 2]; events.len()];
        let standing: Vec<usize> = (0..events.len()).filter(|&i| events[i].standing_run.is_some()).collect();
        for pair in standing.windows(2).filter(|w| events[w[0]].standing_run == events[w[1]].standing_run) {
            beside[pair[0]][1] = Some(pair[1]);
            beside[pair[1]][0] = Some(pair[0]);
        }
        let of_kinds = Vec::new();
        let mut finder =
            Self { events, features, outcomes, limit, min_jump, config, points, trees, beside, next, of_kinds };
        progress.begin("graph", events.len() as u64, "event frames");
        let of_kinds = |i: usize| {
            let best = finder.trees_of(i).iter().filter_map(|tree| finder.nearest(i, tree)).collect();
            progress.advance(1);
            best
        };
        finder.of_kinds = (0..events.len()).into_par_iter().map(of_kinds).collect();
        progress.end();
        finder
    }

    /// For every event the ones like it that a graph may need, best first (events.len()).
    ///
    /// - `threshold`: the largest one at which links will be chosen.
    ///
    /// A link is possible from any event to one of the same kind up to the limit. Left out are events after which no
    /// other event comes, events nearer than `min_jump` frames in the same run, and within one standing run all but the
    /// local minima of the distance. Of the possible links of an event, those are kept that [`choose::choose`] may choose
    /// up to the threshold, the nearest 64, and the way back of every link that is kept of another event: so that no
    /// event is lost because those like it have many others.
    pub fn links(&self, threshold: f32) -> Vec<Vec<Link>> {
        let mut links: Vec<Vec<Link>> =
            (0..self.events.len()).into_par_iter().map(|i| self.kept(i, threshold)).collect();
        let back = |(i, links): (usize, &Vec<Link>)| -> Vec<(usize, Link)> {
            let back = links.iter().map(|l| (l.event, Link { event: i, error: l.error }));
            back.filter(|(from, link)| self.is_possible(*from, link)).collect()
        };
        let ways_back: Vec<Vec<(usize, Link)>> = links.par_iter().enumerate().map(back).collect();
        ways_back.into_iter().flatten().for_each(|(from, link)| links[from].push(link));
        links.par_iter_mut().for_each(|links| {
            choose::sort(links);
            links.dedup_by_key(|l| l.event);
        });
        links
    }

    /// The events that an event may lead to, by kind of outcome.
    fn trees_of(&self, i: usize) -> &[Tree] {
        self.trees.get(&self.events[i].kind).map_or(&[], Vec::as_slice)
    }

    /// The distance of two events where it is at most `limit`.
    fn distance_within(&self, i: usize, k: usize, limit: f32) -> Option<f32> {
        let (a, b) = (self.events[i].frame, self.events[k].frame);
        self.features.squared_distance_within(a, b, limit * limit).map(f32::sqrt)
    }

    /// Whether motion may jump from event `i` along a link whose distance is within the limit.
    fn is_possible(&self, i: usize, link: &Link) -> bool {
        let (a, b) = (&self.events[i], &self.events[link.event]);
        let is_near = a.run == b.run && a.frame.0.abs_diff(b.frame.0) < self.min_jump;
        // Neighbours in a standing run are nearly the same pose: of each descent to a minimum only the bottom counts.
        let [before, after] = self.beside[link.event].map(|k| k.filter(|&k| k != i));
        let distance = |k: Option<usize>| k.and_then(|k| self.distance_within(i, k, self.limit));
        link.event != i
            && self.next[link.event].is_some()
            && !is_near
            && distance(before).is_none_or(|d| d > link.error)
            && distance(after).is_none_or(|d| d >= link.error)
    }

    /// The links of an event that are kept for its own sake.
    fn kept(&self, i: usize, threshold: f32) -> Vec<Link> {
        let threshold = threshold.min(self.limit);
        let mut radius = threshold;
        let mut links = self.within(i, radius);
        while links.len() < NEAREST && radius < self.limit {
            radius = (radius * GROWTH).min(self.limit);
            links = self.within(i, radius);
        }
        let num_within = links.len();
        links.extend(self.of_kinds[i].iter().filter(|l| l.error > radius));
        choose::sort(&mut links);
        let mut kept = choose::choose_of_one(&links, self.outcomes, threshold, self.config);
        kept.extend(&links[..num_within.min(NEAREST)]);
        kept
    }

    /// The nearest possible link to an event of a tree.
    fn nearest(&self, i: usize, tree: &Tree) -> Option<Link> {
        let (mut best, mut limit): (Option<Link>, f32) = (None, self.limit);
        tree.visit(&self.points[i], squared_reach(limit), &mut |k| {
            // As near as what was found may still have a lower number.
            let error = self.distance_within(i, k as usize, (limit * (1.0 + 1e-6)).min(self.limit));
            let link = error.map(|error| Link { event: k as usize, error });
            let is_better = |l: &Link| best.is_none_or(|b| (l.error, l.event) < (b.error, b.event));
            if let Some(link) = link.filter(|l| is_better(l) && self.is_possible(i, l)) {
                (best, limit) = (Some(link), link.error);
            }
            squared_reach(limit)
        });
        best
    }

    /// All possible links within a radius.
    fn within(&self, i: usize, radius: f32) -> Vec<Link> {
        let (reach, mut links) = (squared_reach(radius), Vec::new());
        for tree in self.trees_of(i) {
            tree.visit(&self.points[i], reach, &mut |k| {
                let error = self.distance_within(i, k as usize, radius);
                links.extend(error.map(|error| Link { event: k as usize, error }));
                reach
            });
        }
        links.retain(|l| self.is_possible(i, l));
        links
    }
}

/// Where the motion after an event leads, seen from the event.
pub(super) fn outcomes(events: &[Event], clips: &ClipSet, horizon_s: f64) -> Vec<Planar> {
    let starts = clips.frame_starts();
    let of_event = |e: &Event| {
        let clip = &clips.clips[e.clip];
        let horizon = ((horizon_s * clip.rate_hz).round() as u32).max(1);
        let last = FrameId((e.frame.0 + horizon).min(e.run_end.0 - 1));
        displacement(clips, &starts, e.clip, e.frame, last)
    };
    events.par_iter().map(of_event).collect()
}

/// The planar root of frame `to` as seen from `from`, both of clip `clip`; the heading counts full turns.
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
