//! Links of the graph: the actions that lead into a state, and how many play a segment.

use throng_core::graph::MotionGraph;

/// An action, by the state that may take it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionLink {
    /// State that may take it.
    pub from: u32,
    /// Segment it plays.
    pub segment: u32,
    /// Difference of the frames at which the clip is left; 0 if the clip continues (rad).
    pub error: f32,
}

/// Actions by the state that they lead to.
#[derive(Clone, Debug, Default)]
pub struct ActionLinks {
    /// Actions that lead into each state, by the state that may take them (number of states).
    pub incoming: Vec<Vec<ActionLink>>,
    /// Actions that play each segment (number of segments).
    pub plays: Vec<u32>,
    /// The largest of them.
    pub max_plays: u32,
    /// The largest error of all actions (rad).
    pub max_error: f32,
}

impl ActionLinks {
    /// Goes through all actions of a graph.
    pub fn new(graph: &MotionGraph) -> Self {
        let mut incoming = vec![Vec::new(); graph.states.len()];
        let mut plays = vec![0; graph.segments.len()];
        for link in (0..graph.states.len() as u32).flat_map(|from| outgoing(graph, from)) {
            incoming[graph.segments[link.segment as usize].end as usize].push(link);
            plays[link.segment as usize] += 1;
        }
        let max_plays = plays.iter().copied().max().unwrap_or(0);
        let max_error = graph.action_errors.iter().copied().fold(0.0, f32::max);
        Self { incoming, plays, max_plays, max_error }
    }
}

/// Actions of a state, in order (state < number of states).
pub fn outgoing(graph: &MotionGraph, from: u32) -> impl Iterator<Item = ActionLink> {
    let first = graph.action_offsets[from as usize] as usize;
    let errors = &graph.action_errors[first..];
    graph.segments_of(from).iter().zip(errors).map(move |(&segment, &error)| ActionLink { from, segment, error })
}

#[cfg(test)]
mod tests {
    use super::super::tests::golden;
    use super::*;

    #[test]
    fn actions_into_a_state_are_those_that_a_search_finds() {
        let b = golden();
        let graph = b.tables().graph();
        let links = ActionLinks::new(graph);
        let mut total = 0;
        for to in 0..graph.states.len() as u32 {
            let leads = |l: &ActionLink| graph.segments[l.segment as usize].end == to;
            let searched: Vec<ActionLink> =
                (0..graph.states.len() as u32).flat_map(|s| outgoing(graph, s)).filter(leads).collect();
            assert_eq!(links.incoming[to as usize], searched);
            total += searched.len();
        }
        assert_eq!(total, graph.action_segments.len());
        assert_eq!(links.plays.iter().sum::<u32>() as usize, total);
    }
}
