//! Stop tables lead to a stand.

use super::{ASTRAY, LEAP, is_near, root_seen_from};
use crate::bundle::{Bundle, tags};
use crate::format::FormatError;
use crate::stops::{BODY_RADIUS_M, PIECE_FRAMES, REST, SLOW_DOWN, SweepNode, WALK_ON};
use throng_base::maths;

/// Most nodes of a segment, with those that bending adds, and of all segments on the way to a stand: characters that make way
/// have room for as many each.
const MOST_NODES: u64 = 2000;

/// Every segment has a sweep from its first frame to its last, every state a stop that is over after a bounded time.
pub fn stops(t: &Bundle) -> Result<(), FormatError> {
    let (g, s) = (t.graph(), t.stops());
    for (tag, got, expected, what) in [
        (tags::SWEEPS, s.sweeps.len(), g.segments.len(), "segments"),
        (tags::STOPS, s.stops.len(), g.states.len(), "states"),
    ] {
        if got != expected {
            return Err(FormatError::layout(format!("section {tag} has {got} elements for {expected} {what}")));
        }
    }
    let mut next = 0u64;
    for (i, sweep) in s.sweeps.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::SWEEPS, i, format!("{what}: {sweep:?}")));
        let end = next + u64::from(sweep.num_nodes);
        if u64::from(sweep.first_node) != next || sweep.num_nodes < 2 || end > s.nodes.len() as u64 {
            return wrong("its nodes do not follow those before");
        }
        if !(0.01..100.0).contains(&sweep.radius) {
            return wrong("its radius cannot be");
        }
        let nodes = s.nodes_of(i as u32);
        if nodes[0].frame != 0 || nodes[nodes.len() - 1].frame != g.segments[i].num_frames {
            return wrong("its nodes do not reach from its first frame to its last");
        }
        if !nodes.is_sorted_by(|a, b| a.frame < b.frame) {
            return wrong("its nodes do not ascend");
        }
        let most = nodes.len() as u64 + u64::from(g.segments[i].num_frames / PIECE_FRAMES);
        if most > MOST_NODES {
            return wrong(&format!(
                "its path may have {most} nodes, expected up to {MOST_NODES}: no action may take that long"
            ));
        }
        if nodes.windows(2).any(|w| !((w[0].x - w[1].x).abs() <= LEAP && (w[0].z - w[1].z).abs() <= LEAP)) {
            return wrong("it leaps");
        }
        let start = g.segments[i].start;
        if !nodes.iter().all(|n| is_near(root_seen_from(t, start, start + n.frame), n.x, n.z)) {
            return wrong("it does not go where its frames go");
        }
        next = end;
    }
    if next != s.nodes.len() as u64 {
        let got = s.nodes.len();
        return Err(FormatError::layout(format!("section {} has {got} elements, expected {next}", tags::SWEEP_NODES)));
    }
    if let Some(i) = s.nodes.iter().position(|n| !(n.x.abs() < 1e6 && n.z.abs() < 1e6)) {
        return Err(FormatError::value(tags::SWEEP_NODES, i, "it holds a number that cannot be"));
    }
    for (i, stop) in s.stops.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::STOPS, i, format!("{what}: {stop:?}")));
        if !g.segments_of(i as u32).contains(&stop.segment) {
            return wrong("its segment is no action of the state");
        }
        if !(0.01..100.0).contains(&stop.radius) || !(0.01..=stop.radius).contains(&stop.pose_radius) {
            return wrong("its radius cannot be");
        }
        let segment = &g.segments[stop.segment as usize];
        let after = &s.stops[segment.end as usize];
        let reach = stop.radius.min(s.sweeps[stop.segment as usize].radius) - BODY_RADIUS_M;
        let is_good = match stop.kind {
            REST => stop.frames == 0 && after.kind == REST && rests(s.nodes_of(stop.segment), reach),
            // The time grows with every segment, so that the chain has an end.
            WALK_ON => after.frames.checked_add(segment.num_frames) == Some(stop.frames),
            SLOW_DOWN => segment.num_frames.checked_mul(2) == Some(stop.frames),
            _ => return wrong("no such kind"),
        };
        if !is_good {
            return wrong("it does not lead to a stand in its time");
        }
    }
    match s.most_nodes(&g.segments) {
        n if n <= MOST_NODES as usize => Ok(()),
        n => Err(FormatError::layout(format!("a way to a stand has {n} nodes, expected up to {MOST_NODES}"))),
    }
}

/// True if a character at rest stays within its disc: any displacement is taken back evenly.
///
/// - `reach`: largest distance of the body's disc from its middle (m).
fn rests(nodes: &[SweepNode], reach: f32) -> bool {
    let end = nodes[nodes.len() - 1];
    nodes.iter().all(|n| {
        let share = n.frame as f32 / end.frame as f32;
        maths::hypot(n.x - end.x * share, n.z - end.z * share) <= reach + ASTRAY
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_rests_sways_no_farther_than_its_disc_reaches() {
        let way =
            |x: f32| [(0, 0.0, 0.0), (5, 0.1 + x, 0.0), (10, 0.2, 0.0)].map(|(frame, x, z)| SweepNode { frame, x, z });
        // The displacement to the end is taken back: the rest is the distance that it sways.
        assert!(rests(&way(0.0), 0.0) && rests(&way(0.3), 0.3) && !rests(&way(0.3), 0.2));
    }
}
