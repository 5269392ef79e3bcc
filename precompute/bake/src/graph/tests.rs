//! Matches, component, bridges and collapse of random event graphs against brute force.

use super::bridge::{IncomingLinks, KnownLinks, bridge};
use super::choose::{MotionOutcome, sort};
use super::collapse::collapse;
use super::component::{EventGraph, components, largest_component};
use super::connect::GraphInputs;
use super::events::{EventFrame, EventFrameKind};
use super::matches::{self, LinkFinder, LinkLimits, NEAREST, TransitionLink};
use super::{MotionGraphConfig, RawMotionGraph, StateId};
use crate::features::{self, Features, FeaturesConfig};
use glam::{Quat, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::sync::LazyLock;
use throng_base::{Comm, LocalComm, SingleRank};
use throng_core::{NUM_JOINTS, Planar, Skeleton};
use throng_motion::clip::{Clip, ClipSet, FrameId};
use throng_motion::progress::Silent;

/// Up to 14 events in runs, with random links; an event after which the clip ends cannot be entered.
fn event_graph() -> impl Strategy<Value = EventGraph> {
    (2usize..14).prop_flat_map(|n| {
        let ends = prop::collection::vec(prop::bool::weighted(0.3), n);
        let frames = prop::collection::vec(1u32..20, n);
        let worth = prop::collection::vec(1u32..20, n);
        let links = prop::collection::vec(prop::collection::btree_map(0..n, 0.0f32..1.0, 0..5), n);
        (ends, frames, worth, links).prop_map(move |(ends, frames, worth, links)| {
            let next: Vec<Option<usize>> = (0..n).map(|i| (i + 1 < n && !ends[i]).then_some(i + 1)).collect();
            let of_event = |i: usize, l: &std::collections::BTreeMap<usize, f32>| {
                let mut out: Vec<TransitionLink> =
                    l.iter().map(|(&event, &error)| TransitionLink::new(event, error)).collect();
                out.retain(|l| l.event() != i && next[l.event()].is_some());
                out.sort_by(|a, b| a.error.total_cmp(&b.error));
                out
            };
            let links = links.iter().enumerate().map(|(i, l)| of_event(i, l)).collect();
            EventGraph { next: next.clone(), frames, worth, rests: vec![false; next.len()], links }
        })
    })
}

/// Groups of ten events whose best links stay within the group; few lead from one to another.
fn groups() -> impl Strategy<Value = EventGraph> {
    (1usize..6, any::<u64>(), 0.0..0.2).prop_map(|(num_groups, seed, share)| {
        let mut rng = Pcg64::seed_from_u64(seed);
        let n = 10 * num_groups;
        let next: Vec<Option<usize>> = (0..n).map(|i| (i % 10 < 9 && !rng.random_bool(0.2)).then_some(i + 1)).collect();
        let mut of_event = |i: usize| {
            let mut links: Vec<TransitionLink> = Vec::new();
            for k in (0..n).filter(|&k| k != i && next[k].is_some()) {
                let is_same = k / 10 == i / 10;
                if rng.random_bool(if is_same { 0.95 } else { share }) {
                    links.push(TransitionLink::new(k, rng.random_range(0.0..1.0) + f32::from(u8::from(!is_same))));
                }
            }
            sort(&mut links);
            links
        };
        let links = (0..n).map(&mut of_event).collect();
        let numbers: Vec<[u32; 2]> = (0..n).map(|_| [0; 2].map(|_| rng.random_range(1..20))).collect();
        let [frames, worth] = [0, 1].map(|which| numbers.iter().map(|n| n[which]).collect());
        let rests = vec![false; next.len()];
        EventGraph { next, frames, worth, rests, links }
    })
}

fn targets(graph: &EventGraph, alive: &[bool], i: usize) -> Vec<usize> {
    graph.targets(i).filter(|&n| alive[i] && alive[n]).collect()
}

/// `out[i][j]`: a way of at least one step leads from i to j, through events alive.
fn reaches(graph: &EventGraph, alive: &[bool]) -> Vec<Vec<bool>> {
    let n = alive.len();
    let mut r: Vec<Vec<bool>> =
        (0..n).map(|i| (0..n).map(|j| targets(graph, alive, i).contains(&j)).collect()).collect();
    for k in 0..n {
        for i in 0..n {
            for j in 0..n {
                r[i][j] |= r[i][k] && r[k][j];
            }
        }
    }
    r
}

/// Frames from an event to the next one with a choice, as the clip goes on.
fn frames_to_choice(graph: &EventGraph, inside: &dyn Fn(usize) -> bool, from: usize) -> u32 {
    let arrives = |event: usize| graph.next[event].is_some_and(inside);
    let (mut at, mut frames) = (from, 0);
    while let Some(n) = graph.next[at].filter(|&n| inside(n)) {
        frames += graph.frames[n];
        at = n;
        if usize::from(arrives(n)) + graph.links[n].iter().filter(|l| arrives(l.event())).count() > 1 {
            break;
        }
    }
    frames
}

fn naive_component(graph: &EventGraph, most_frames: u32) -> Vec<bool> {
    let n = graph.next.len();
    let mut alive = vec![true; n];
    loop {
        let r = reaches(graph, &alive);
        let parts = (0..n).filter(|&i| r[i][i]).map(|i| (0..n).filter(|&j| r[i][j] && r[j][i]).collect::<Vec<_>>());
        let worth = |p: &[usize]| p.iter().map(|&i| graph.worth[i]).sum::<u32>();
        let best = parts.max_by_key(|p| (worth(p), std::cmp::Reverse(p[0]))).unwrap_or_default();
        let inside = |i: usize| best.contains(&i);
        let arrives = |event: usize| graph.next[event].is_some_and(inside);
        let stuck = |i: usize| !arrives(i) && graph.links[i].iter().filter(|l| arrives(l.event())).count() < 2;
        let deaf = |i: usize| {
            i > 0 && graph.next[i - 1] == Some(i) && { frames_to_choice(graph, &inside, i - 1) > most_frames }
        };
        alive = (0..n).map(|i| inside(i) && !stuck(i) && !deaf(i)).collect();
        if (0..n).all(|i| inside(i) == alive[i]) {
            return alive;
        }
    }
}

/// Adds the best link out of each part that nothing leads out of, and into each that nothing leads into, again and
/// again: of all links, in every round.
fn join_naively(graph: &mut EventGraph, matches: &[Vec<TransitionLink>], alive: &[bool], most: usize) {
    loop {
        let r = reaches(graph, alive);
        let same = |i: usize, j: usize| i == j || (r[i][j] && r[j][i]);
        let leads_on = |i: usize, link: &TransitionLink| graph.next[link.event()].filter(|&n| alive[n] && !same(i, n));
        let mut more = Vec::new();
        for part in (0..alive.len()).filter(|&i| alive[i]) {
            let is_out = |i: usize, n: usize| same(i, part) && !same(n, part);
            let is_in = |i: usize, n: usize| !same(i, part) && same(n, part);
            for leads in [&is_out as &dyn Fn(usize, usize) -> bool, &is_in] {
                if (0..alive.len()).any(|i| targets(graph, alive, i).iter().any(|&n| leads(i, n))) {
                    continue;
                }
                let all = (0..alive.len()).filter(|&i| alive[i] && graph.links[i].len() < most);
                let all = all.flat_map(|i| matches[i].iter().map(move |l| (i, *l)));
                let possible = all.filter(|(i, l)| leads_on(*i, l).is_some_and(|n| leads(*i, n)));
                more.extend(possible.min_by_key(|(i, l)| (l.error.to_bits(), *i, l.event())));
            }
        }
        more.sort_unstable_by_key(|(i, l)| (*i, l.event()));
        more.dedup();
        if more.is_empty() {
            return;
        }
        more.into_iter().for_each(|(i, link)| graph.links[i].push(link));
    }
}

/// One clip in which event i lies at frame 3 i.
fn clip_and_events(n: usize) -> (ClipSet, Vec<EventFrame>) {
    let num_frames = 3 * n;
    let clip = Clip::new("c", 30.0, vec![Vec3::ZERO; num_frames], vec![Quat::IDENTITY; num_frames * NUM_JOINTS]);
    let event = |i: usize| EventFrame {
        frame: FrameId(3 * i as u32),
        clip: 0,
        kind: EventFrameKind::LeavesBoth,
        run: 0,
        standing_run: None,
        is_rest: false,
        run_end: FrameId(num_frames as u32),
    };
    (ClipSet { skeleton: Skeleton::default(), clips: vec![clip] }, (0..n).map(event).collect())
}

fn ends_of(graph: &RawMotionGraph, state: usize) -> Vec<usize> {
    let actions = graph.actions_of(StateId(state as u32));
    actions.iter().map(|a| graph.segments[a.segment.0 as usize].end.0 as usize).collect()
}

/// Frames of poses that vary in a few ways and a little in all, events at every third one, and where each leads.
fn random_events(seed: u64, num_events: usize, variety: f32) -> (Features, Vec<EventFrame>, Vec<MotionOutcome>) {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut vector = |size: f32| Vec3::from_array([0; 3].map(|_| rng.random_range(-size..size)));
    let paths: Vec<Vec<Vec3>> = (0..3).map(|_| (0..NUM_JOINTS).map(|_| vector(0.5)).collect()).collect();
    let mut rotations = Vec::new();
    for frame in 0..3 * num_events {
        // Some poses are there twice.
        let pose = if frame % 11 == 10 { rotations[rotations.len() - NUM_JOINTS..].to_vec() } else { Vec::new() };
        let by = vector(variety).to_array();
        let joint = |j: usize, noise: Vec3| {
            Quat::from_scaled_axis(paths.iter().zip(by).map(|(way, by)| way[j] * by).sum::<Vec3>() + noise)
        };
        rotations.extend(if pose.is_empty() {
            (0..NUM_JOINTS).map(|j| joint(j, vector(0.02))).collect()
        } else {
            pose
        });
    }
    let clip = Clip::new("c", 30.0, vec![Vec3::Y; 3 * num_events], rotations);
    let set = ClipSet { skeleton: Skeleton::default(), clips: vec![clip] };
    let still = FeaturesConfig { horizon_s: 0.001, ..FeaturesConfig::default() };
    let events = (0..num_events).map(|i| {
        let standing = (i / 20) % 3 == 0;
        let kind =
            if standing { EventFrameKind::Standing } else { EventFrameKind::LeavesLeft { other_planted: i % 2 == 0 } };
        let standing_run = standing.then_some(i / 20);
        let frame = FrameId(3 * i as u32);
        let run_end = FrameId(3 * num_events as u32);
        EventFrame { frame, clip: 0, kind, run: i / 50, standing_run, is_rest: standing, run_end }
    });
    let outcomes = (0..num_events).map(|_| {
        let [x, z, turn] = vector(variety).to_array();
        MotionOutcome::new(Planar::new(x, 2.0 * z, turn))
    });
    let (events, outcomes): (Vec<EventFrame>, _) = (events.collect(), outcomes.collect());
    let frames: Vec<FrameId> = events.iter().map(|e| e.frame).collect();
    (features::extract_at(&set, &frames, &still, &SingleRank).unwrap(), events, outcomes)
}

fn given<'a>(
    events: &'a [EventFrame],
    features: &'a Features,
    outcomes: &'a [MotionOutcome],
    config: &'a MotionGraphConfig,
) -> GraphInputs<'a> {
    static NO_CLIPS: LazyLock<ClipSet> = LazyLock::new(|| ClipSet { skeleton: Skeleton::default(), clips: Vec::new() });
    GraphInputs { clips: &NO_CLIPS, config, events, features, outcomes, rate_hz: 30.0 }
}

fn limits(error: f32) -> LinkLimits {
    LinkLimits { error, min_jump: 9, points_per_kind: usize::MAX, points_per_event: usize::MAX }
}

#[test]
fn a_few_looks_find_links_nearly_as_good() {
    let (features, events, outcomes) = random_events(7, 1500, 0.4);
    let all = all_links(&events, &features, 0.5, 9);
    let (config, limits) =
        (MotionGraphConfig::default(), LinkLimits { points_per_kind: 32, points_per_event: 128, ..limits(0.5) });
    let given = given(&events, &features, &outcomes, &config);
    let found = LinkFinder::new(given, limits, &Silent, &SingleRank).unwrap().links(0.1, &SingleRank).unwrap();
    let mut sums = [0.0; 2];
    for (found, all) in found.iter().zip(&all) {
        assert!(found.iter().all(|l| all.contains(l)));
        assert_eq!(found.is_empty(), all.is_empty());
        for k in 0..all.len().min(8) {
            sums[0] += all[k].error;
            sums[1] += found.get(k).map_or(0.5, |l| l.error);
        }
    }
    assert!(sums[0] > 10.0 && sums[1] < 1.02 * sums[0], "{sums:?}");
}

/// Every possible link, from all pairs.
fn all_links(events: &[EventFrame], features: &Features, limit: f32, min_jump: u32) -> Vec<Vec<TransitionLink>> {
    let next = matches::successors(events);
    let error = |i: usize, k: usize| features.distance(FrameId(i as u32), FrameId(k as u32));
    let is_near = |a: &EventFrame, b: &EventFrame| a.run == b.run && a.frame.0.abs_diff(b.frame.0) < min_jump;
    let of_event = |i: usize| {
        let same = |k: usize, n: usize| {
            n != i && events[k].standing_run.is_some() && events[n].standing_run == events[k].standing_run
        };
        let is_minimum = |k: usize| {
            let better_before = k > 0 && same(k, k - 1) && error(i, k - 1) <= error(i, k);
            let better_after = k + 1 < events.len() && same(k, k + 1) && error(i, k + 1) < error(i, k);
            !better_before && !better_after
        };
        let possible = (0..events.len()).filter(|&k| {
            k != i
                && events[k].kind == events[i].kind
                && features.squared_distance(FrameId(i as u32), FrameId(k as u32)) <= limit * limit
                && next[k].is_some()
                && !is_near(&events[i], &events[k])
                && is_minimum(k)
        });
        let mut links: Vec<TransitionLink> =
            possible.map(|event| TransitionLink::new(event, error(i, event))).collect();
        sort(&mut links);
        links
    };
    (0..events.len()).map(of_event).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn links_are_those_that_all_pairs_give(
        seed in any::<u64>(),
        num_events in 1usize..400,
        variety in 0.02f32..1.0,
        limit in 0.01f32..0.8,
        share in 0.1f32..1.0,
        max_actions in 6usize..64,
    ) {
        let (features, events, outcomes) = random_events(seed, num_events, variety);
        let config = MotionGraphConfig { max_actions, ..MotionGraphConfig::default() };
        let all = all_links(&events, &features, limit, 9);
        let highest = share * limit;
        let given = given(&events, &features, &outcomes, &config);
        let found = LinkFinder::new(given, limits(limit), &Silent, &SingleRank).unwrap().links(highest, &SingleRank).unwrap();
        let mut kept = given.choose(&all, highest, &SingleRank).unwrap();
        kept.iter_mut().zip(&all).for_each(|(kept, all)| kept.extend(all.iter().take(NEAREST)));
        let back: Vec<(usize, TransitionLink)> = kept
            .iter()
            .enumerate()
            .flat_map(|(i, links)| links.iter().map(move |l| (l.event(), TransitionLink::new(i, l.error))))
            .filter(|(from, link)| all[*from].contains(link))
            .collect();
        back.into_iter().for_each(|(from, link)| kept[from].push(link));
        for links in &mut kept {
            sort(links);
            links.dedup();
        }
        prop_assert_eq!(&found, &kept);
        for share in [0.0, 0.2, 0.5, 0.8, 1.0] {
            let threshold = share * highest;
            prop_assert_eq!(given.choose(&found, threshold, &SingleRank).unwrap(), given.choose(&all, threshold, &SingleRank).unwrap());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn the_component_is_the_one_brute_force_finds(graph in event_graph(), most in 1u32..60) {
        for most in [most, u32::MAX] {
            let alive = largest_component(&graph, most, &SingleRank).unwrap();
            prop_assert_eq!(&alive, &naive_component(&graph, most));
            for i in (0..alive.len()).filter(|&i| graph.has_live_successor(i, &alive)) {
                prop_assert!(frames_to_choice(&graph, &|n| alive[n], i) <= most);
            }
        }
    }

    #[test]
    fn bridges_make_a_thinned_graph_whole_again(mut whole in event_graph(), keep in prop::collection::vec(any::<bool>(), 14)) {
        let alive = largest_component(&whole, u32::MAX, &SingleRank).unwrap();
        whole.restrict(&alive);
        let mut thin = whole.clone();
        for (i, links) in thin.links.iter_mut().enumerate() {
            links.retain(|l| keep[(i + l.event()) % 14]);
        }
        let chosen = thin.links.clone();
        let arrivals = &IncomingLinks::new(&whole.links, &SingleRank).unwrap();
        let known = KnownLinks { matches: &whole.links, arrivals, alive: &alive };
        bridge(&mut thin, known, 255, &SingleRank).unwrap();
        prop_assert_eq!(largest_component(&thin, u32::MAX, &SingleRank).unwrap(), alive);
        for i in 0..thin.links.len() {
            prop_assert!(chosen[i].iter().all(|l| thin.links[i].contains(l)));
            prop_assert!(thin.links[i].iter().all(|l| whole.links[i].contains(l)));
            prop_assert!(thin.links[i].is_sorted_by(|a, b| a.error <= b.error));
        }
    }

    #[test]
    fn parts_are_joined_by_the_links_that_brute_force_finds(
        mut whole in event_graph(),
        keep in prop::collection::vec(any::<bool>(), 14),
        most in 1usize..6,
    ) {
        // Many links are equally good.
        for links in &mut whole.links {
            *links = links.iter().map(|l| TransitionLink::new(l.event(), (4.0 * l.error).floor())).collect();
            sort(links);
        }
        let alive = largest_component(&whole, u32::MAX, &SingleRank).unwrap();
        whole.restrict(&alive);
        for most in [most, 255] {
            let mut thin = whole.clone();
            for (i, links) in thin.links.iter_mut().enumerate() {
                links.retain(|l| keep[(i + l.event()) % 14]);
            }
            let mut expected = thin.clone();
            join_naively(&mut expected, &whole.links, &alive, most);
            let arrivals = &IncomingLinks::new(&whole.links, &SingleRank).unwrap();
            let known = KnownLinks { matches: &whole.links, arrivals, alive: &alive };
            bridge(&mut thin, known, most, &SingleRank).unwrap();
            // Ends of clips may have been given more.
            for i in (0..alive.len()).filter(|&i| !alive[i] || thin.has_live_successor(i, &alive)) {
                sort(&mut expected.links[i]);
                prop_assert_eq!(&thin.links[i], &expected.links[i]);
            }
            for (got, expected) in thin.links.iter().zip(&expected.links) {
                prop_assert!(expected.iter().all(|l| got.contains(l)) && got.len() <= expected.len().max(2));
            }
        }
    }

    #[test]
    fn ranks_that_have_a_part_of_the_links_each_find_what_one_finds(
        mut whole in groups(), num_ranks in 2usize..5, most in 20u32..60, keep in 0.0f32..1.0, max_links in 10usize..16,
    ) {
        let alive = largest_component(&whole, most, &SingleRank).unwrap();
        let of_all = whole.clone();
        whole.restrict(&alive);
        let mut thin = whole.clone();
        thin.links.iter_mut().flatten().for_each(|l| l.error *= keep);
        thin.links.iter_mut().for_each(|links| links.retain(|l| l.error.fract() < 0.3));
        let chosen = thin.clone();
        let arrivals = &IncomingLinks::new(&whole.links, &SingleRank).unwrap();
        let known = KnownLinks { matches: &whole.links, arrivals, alive: &alive };
        bridge(&mut thin, known, max_links, &SingleRank).unwrap();
        let found = LocalComm::run(num_ranks, |comm| {
            let own = |graph: &EventGraph| {
                let mut own = graph.clone();
                (0..).zip(&mut own.links).filter(|(i, _)| i % num_ranks != comm.rank()).for_each(|(_, l)| l.clear());
                own
            };
            let found = largest_component(&own(&of_all), most, comm).unwrap();
            let (mut graph, whole) = (chosen.clone(), own(&whole));
            let arrivals = &IncomingLinks::new(&whole.links, comm).unwrap();
            let known = KnownLinks { matches: &whole.links, arrivals, alive: &alive };
            bridge(&mut graph, known, max_links, comm).unwrap();
            (found, graph)
        });
        for (found, graph) in found {
            prop_assert_eq!(&found, &alive);
            prop_assert_eq!(&graph, &thin);
        }
    }

    #[test]
    fn collapsing_keeps_every_way_and_nothing_else(graph in event_graph()) {
        let alive = largest_component(&graph, u32::MAX, &SingleRank).unwrap();
        let (clips, events) = clip_and_events(alive.len());
        let collapsed = collapse(&graph, &alive, &events, &clips);
        let r = reaches(&graph, &alive);
        let event_of: Vec<usize> = collapsed.states.iter().map(|f| f.0 as usize / 3).collect();
        prop_assert_eq!(event_of.is_empty(), !alive.contains(&true));
        for (s, &i) in event_of.iter().enumerate() {
            let paths = targets(&graph, &alive, i);
            prop_assert!(paths.len() > 1);
            let mut expected: Vec<usize> = paths.iter().map(|&n| {
                let mut at = n;
                while !event_of.contains(&at) {
                    let on = targets(&graph, &alive, at);
                    assert_eq!(on.len(), 1, "an event with a choice is no state");
                    at = on[0];
                }
                event_of.binary_search(&at).unwrap()
            }).collect();
            let mut got = ends_of(&collapsed, s);
            expected.sort_unstable();
            got.sort_unstable();
            prop_assert_eq!(got, expected);
            prop_assert!(event_of.iter().all(|&j| r[i][j]));
        }
        for segment in &collapsed.segments {
            prop_assert_eq!(segment.start.0 + segment.num_frames, collapsed.states[segment.end.0 as usize].0);
        }
    }
}

#[test]
fn components_of_a_chain_into_a_loop() {
    // 0 -> 1 -> 2 -> 3, and 3 jumps to where 2 goes on: 2 is only passed through.
    let graph = EventGraph {
        next: vec![Some(1), Some(2), Some(3), None],
        frames: vec![0, 5, 5, 5],
        worth: vec![0, 5, 5, 5],
        rests: vec![false; 4],
        links: vec![vec![], vec![], vec![], vec![TransitionLink::new(1, 0.1), TransitionLink::new(2, 0.2)]],
    };
    let mut parts = components(&graph.next, &graph.links, &[true; 4]);
    parts.sort();
    assert_eq!(parts, [vec![0], vec![1], vec![2, 3]]);
    assert_eq!(largest_component(&graph, u32::MAX, &SingleRank).unwrap(), [false, false, true, true]);
}

/// Links that are chosen up to an error of 0.5.
fn chosen(
    matches: &[Vec<TransitionLink>],
    outcomes: &[MotionOutcome],
    config: &MotionGraphConfig,
) -> Vec<Vec<TransitionLink>> {
    let features = Features::default();
    given(&[], &features, outcomes, config).choose(matches, 0.5, &SingleRank).unwrap()
}

fn links_of(errors: &[(usize, f32)]) -> Vec<TransitionLink> {
    errors.iter().map(|&(event, error)| TransitionLink::new(event, error)).collect()
}

fn targets_of(links: &[TransitionLink]) -> Vec<usize> {
    links.iter().map(|l| l.event()).collect()
}

#[test]
fn of_equal_outcomes_the_better_stays() {
    let mut matches = vec![Vec::new(); 6];
    matches[0] = links_of(&[(1, 0.1), (2, 0.2), (3, 0.3), (4, 0.4), (5, 0.9)]);
    let outcomes = [0.0, 1.0, 1.0, 1.02, 2.0, 3.0].map(|z| MotionOutcome::new(Planar::new(0.0, z, 0.0)));
    let rows = chosen(&matches, &outcomes, &MotionGraphConfig::default());
    assert_eq!(targets_of(&rows[0]), [1, 4]);
}

#[test]
fn the_best_of_each_kind_of_outcome_is_taken_beyond_the_threshold() {
    let mut matches = vec![Vec::new(); 7];
    matches[0] = links_of(&[(1, 0.1), (2, 0.6), (3, 0.7), (4, 0.8), (5, 0.9), (6, 0.95)]);
    let outcomes = [
        Planar::IDENTITY,
        Planar::new(0.0, 1.0, 0.0),
        Planar::new(0.0, 1.2, 0.0),
        Planar::new(0.0, 1.0, 1.0),
        Planar::new(0.0, 1.0, 2.0),
        Planar::new(0.0, -1.0, -1.0),
        Planar::new(0.1, 0.1, 0.0),
    ]
    .map(MotionOutcome::new);
    let rows = chosen(&matches, &outcomes, &MotionGraphConfig::default());
    assert_eq!(targets_of(&rows[0]), [1, 3, 5, 6]);
}

#[test]
fn leaves_room_below_the_most_actions() {
    let mut matches = vec![Vec::new(); 100];
    matches[0] = (1..100).map(|event| TransitionLink::new(event, 0.1)).collect();
    let outcomes: Vec<MotionOutcome> = (0..100).map(|z| MotionOutcome::new(Planar::new(0.0, z as f32, 0.0))).collect();
    let rows = chosen(&matches, &outcomes, &MotionGraphConfig { max_actions: 10, ..Default::default() });
    assert_eq!(rows[0].len(), 9 - super::choose::RESERVED);
}
