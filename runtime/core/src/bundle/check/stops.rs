//! Stop tables lead to a stand.

use super::{ASTRAY, LEAP, is_near, refuse, root_seen_from};
use crate::bundle::{Bundle, tags};
use crate::format::FormatError;
use crate::stops::{BODY_RADIUS_M, PIECE_FRAMES, REST, SLOW_DOWN, SweepNode, WALK_ON};
use throng_base::{error::ensure, maths};

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
        let fault = || format!("section {tag} has {got} elements for {expected} {what}");
        ensure(got == expected, || FormatError::layout(fault()))?;
    }
    let mut next = 0u64;
    for (i, sweep) in s.sweeps.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::SWEEPS, i, format!("{fault}: {sweep:?}"));
        let end = next + u64::from(sweep.num_nodes);
        let follows = u64::from(sweep.first_node) == next && sweep.num_nodes >= 2 && end <= s.nodes.len() as u64;
        ensure(follows, || error("its nodes do not follow those before"))?;
        ensure((0.01..100.0).contains(&sweep.radius), || error("its radius cannot be"))?;
        let (nodes, segment) = (s.nodes_of(i as u32), &g.segments[i]);
        let whole = nodes[0].frame == 0 && nodes[nodes.len() - 1].frame == segment.num_frames;
        ensure(whole, || error("its nodes do not reach from its first frame to its last"))?;
        ensure(nodes.is_sorted_by(|a, b| a.frame < b.frame), || error("its nodes do not ascend"))?;
        let most = nodes.len() as u64 + u64::from(segment.num_frames / PIECE_FRAMES);
        let fault =
            || format!("its path may have {most} nodes, expected up to {MOST_NODES}: no action may take that long");
        ensure(most <= MOST_NODES, || error(&fault()))?;
        let is_step = |w: &[SweepNode]| (w[0].x - w[1].x).abs() <= LEAP && (w[0].z - w[1].z).abs() <= LEAP;
        ensure(nodes.windows(2).all(is_step), || error("it leaps"))?;
        let is_at = |n: &SweepNode| is_near(root_seen_from(t, segment.start, segment.start + n.frame), n.x, n.z);
        ensure(nodes.iter().all(is_at), || error("it does not go where its frames go"))?;
        next = end;
    }
    let got = s.nodes.len();
    let fault = || format!("section {} has {got} elements, expected {next}", tags::SWEEP_NODES);
    ensure(next == got as u64, || FormatError::layout(fault()))?;
    let far = s.nodes.iter().position(|n| !(n.x.abs() < 1e6 && n.z.abs() < 1e6));
    refuse(tags::SWEEP_NODES, far, "it holds a number that cannot be")?;
    for (i, stop) in s.stops.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::STOPS, i, format!("{fault}: {stop:?}"));
        let is_action = g.segments_of(i as u32).contains(&stop.segment);
        ensure(is_action, || error("its segment is no action of the state"))?;
        let round = (0.01..100.0).contains(&stop.radius) && (0.01..=stop.radius).contains(&stop.pose_radius);
        ensure(round, || error("its radius cannot be"))?;
        let segment = &g.segments[stop.segment as usize];
        let after = &s.stops[segment.end as usize];
        let reach = stop.radius.min(s.sweeps[stop.segment as usize].radius) - BODY_RADIUS_M;
        let is_good = match stop.kind {
            REST => stop.frames == 0 && after.kind == REST && rests(s.nodes_of(stop.segment), reach),
            // The time grows with every segment, so that the chain has an end.
            WALK_ON => after.frames.checked_add(segment.num_frames) == Some(stop.frames),
            SLOW_DOWN => segment.num_frames.checked_mul(2) == Some(stop.frames),
            _ => return Err(error("no such kind")),
        };
        ensure(is_good, || error("it does not lead to a stand in its time"))?;
    }
    let n = s.most_nodes(&g.segments);
    let fault = || format!("a way to a stand has {n} nodes, expected up to {MOST_NODES}");
    ensure(n <= MOST_NODES as usize, || FormatError::layout(fault()))
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
