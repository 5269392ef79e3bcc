//! Manners: motion of one manner is left for that of another only where a policy says so.

use crate::bundle::Bundle;

/// Manners of the motion of a graph.
#[derive(Clone, Debug, Default)]
pub(super) struct Manners {
    /// Manner of the motion that leads to each state, by number (num_states, or 0 where all motion is alike).
    of_states: Vec<u16>,
}

impl Manners {
    pub fn find(bundle: &Bundle) -> Self {
        let (clips, rows) = (&bundle.meta().clips, bundle.clips());
        let mut names: Vec<&str> = clips.iter().flat_map(|c| &c.classes).map(|span| &*span.class.manner).collect();
        names.sort_unstable();
        names.dedup();
        if names.len() < 2 {
            return Self::default();
        }
        let of_state = |frame: u32| {
            let clip = rows.partition_point(|c| c.first_frame <= frame) - 1;
            let within = frame - rows[clip].first_frame;
            let span = clips[clip].classes.iter().find(|span| span.frames.contains(&within));
            span.and_then(|span| names.binary_search(&&*span.class.manner).ok()).map_or(u16::MAX, |n| n as u16)
        };
        Self { of_states: bundle.graph().states.iter().map(|s| of_state(s.frame)).collect() }
    }

    /// True where motion to one state is in the manner of that to another.
    pub fn are_alike(&self, a: u32, b: u32) -> bool {
        self.of_states.is_empty() || self.of_states[a as usize] == self.of_states[b as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_without_classes_is_alike_and_manners_differ() {
        let none = Manners::find(&super::super::tests::tables());
        assert!(none.are_alike(0, 3));
        let two = Manners { of_states: vec![0, 1, 0] };
        assert!(two.are_alike(0, 2) && !two.are_alike(0, 1));
    }
}
