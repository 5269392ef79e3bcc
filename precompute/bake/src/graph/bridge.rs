//! Keeps the component whole when only good links are chosen.

use super::choose;
use super::component::{EventGraph, components};
use super::matches::Link;

/// Adds links until all events alive reach each other again and ends of clips have two ways out.
///
/// As in Borůvka's algorithm, every part that nothing leads out of gets its best link out, every part that nothing
/// leads into its best link in, and that is repeated: then every part has a way in and a way out, so some of them
/// lie on a common cycle and grow together.
///
/// - `alive`: a component of the graph with all of `matches`.
/// - `most`: links a single event may have; where it has as many, no more are added.
pub(super) fn bridge(graph: &mut EventGraph, matches: &[Vec<Link>], alive: &[bool], most: usize) {
    loop {
        let parts = components(graph, alive);
        let more = if parts.len() > 1 { missing(graph, matches, alive, &parts, most) } else { Vec::new() };
        if more.is_empty() {
            break;
        }
        for (i, link) in more {
            graph.links[i].push(link);
        }
    }
    for i in (0..alive.len()).filter(|&i| alive[i]) {
        if !graph.goes_on(i, alive) {
            let missing = 2usize.saturating_sub(graph.jumps(i, alive).count());
            let more: Vec<Link> = candidates(graph, matches, alive, i).take(missing).copied().collect();
            graph.links[i].extend(more);
        }
        choose::sort(&mut graph.links[i]);
    }
}

/// Links of `i` that are not chosen and stay among the events alive, best first.
fn candidates<'a>(
    graph: &'a EventGraph,
    matches: &'a [Vec<Link>],
    alive: &'a [bool],
    i: usize,
) -> impl Iterator<Item = &'a Link> {
    matches[i]
        .iter()
        .filter(move |l| graph.goes_on(l.event(), alive) && graph.links[i].iter().all(|k| k.event() != l.event()))
}

/// The best link out of every part without a way out, and into every part without a way in; ascending, each once.
fn missing(
    graph: &EventGraph,
    matches: &[Vec<Link>],
    alive: &[bool],
    parts: &[Vec<usize>],
    most: usize,
) -> Vec<(usize, Link)> {
    let mut part_of = vec![usize::MAX; alive.len()];
    for (p, part) in parts.iter().enumerate() {
        part.iter().for_each(|&i| part_of[i] = p);
    }
    let (mut has_out, mut has_in) = (vec![false; parts.len()], vec![false; parts.len()]);
    let living = || (0..alive.len()).filter(|&i| alive[i]);
    for i in living() {
        for n in graph.targets(i).filter(|&n| alive[n] && part_of[n] != part_of[i]) {
            has_out[part_of[i]] = true;
            has_in[part_of[n]] = true;
        }
    }
    let (mut best_out, mut best_in) = (vec![None; parts.len()], vec![None; parts.len()]);
    for i in living().filter(|&i| graph.links[i].len() < most) {
        for link in &matches[i] {
            let Some(n) = graph.next[link.event()].filter(|&n| alive[n] && part_of[n] != part_of[i]) else { continue };
            // A link that is chosen already is a way out and a way in, so none is considered twice.
            if !has_out[part_of[i]] {
                keep_better(&mut best_out[part_of[i]], i, link);
            }
            if !has_in[part_of[n]] {
                keep_better(&mut best_in[part_of[n]], i, link);
            }
        }
    }
    let mut more: Vec<(usize, Link)> = best_out.into_iter().chain(best_in).flatten().collect();
    more.sort_unstable_by_key(|(i, link)| (*i, link.event()));
    more.dedup_by_key(|(i, link)| (*i, link.event()));
    more
}

fn keep_better(best: &mut Option<(usize, Link)>, i: usize, link: &Link) {
    if best.is_none_or(|(_, b)| link.error < b.error) {
        *best = Some((i, *link));
    }
}
