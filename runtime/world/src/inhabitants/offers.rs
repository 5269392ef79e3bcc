//! Offers of instances: motion with a tag that begins at a reachable cell and from which a character can come to rest.

use super::{InhabitantActivity, InhabitantGoal, Inhabitants};
use crate::{WorldGraph, WorldNode};
use throng_base::thresholds::WALK_SPEED_MPS;
use throng_core::patch::LinkRecord;

/// Instances that offer each tag, by `tag - 1`.
pub(super) fn offers_by_tag(graph: &WorldGraph) -> Vec<Vec<u32>> {
    let alone = |l: &&LinkRecord| !l.is_for_two();
    let num_tags = graph.patches().links.iter().filter(alone).map(|l| usize::from(l.tag)).max().unwrap_or(0);
    let mut out = vec![Vec::new(); num_tags];
    for instance in 0..graph.num_instances() as u32 {
        let mut come_to = None;
        for l in graph.links(instance).iter().filter(alone) {
            let Some(list) = usize::from(l.tag).checked_sub(1).map(|t| &mut out[t]) else { continue };
            let from = WorldNode { instance, cell: l.from };
            if list.last() == Some(&instance) || !graph.can_begin_tag(from, l.tag) {
                continue;
            }
            if come_to.get_or_insert_with(|| graph.node_of_cell(instance))[l.from as usize] {
                list.push(instance);
            }
        }
    }
    out
}

/// Assumed time that each character takes that goes to the same place (s).
const TURN_S: f32 = 20.0;
/// Assumed stay of a character that has arrived at its place (s).
const STAY_S: f32 = 60.0;

impl Inhabitants {
    /// The instance that offers a tag and is soonest to be had: near, and free or soon released.
    pub(super) fn nearest_offer(&self, graph: &WorldGraph, character: usize, tag: u16) -> Option<u32> {
        let list = self.offers.get(usize::from(tag).checked_sub(1)?)?;
        let here = graph.place(self.states[character].at).translation();
        let far = |i: u32| {
            let held_s = self.others_held_for_s(graph, character, i);
            // Who holds it is one of those who came for it.
            let num_before = self.num_bound_for(graph, character, i).saturating_sub(u32::from(held_s > 0.0));
            (graph.centre(i) - here).length() + WALK_SPEED_MPS * (held_s + TURN_S * num_before as f32)
        };
        list.iter().copied().min_by(|&a, &b| far(a).total_cmp(&far(b)))
    }

    /// About how long others will hold an instance; 0 where it is free (s).
    fn others_held_for_s(&self, graph: &WorldGraph, character: usize, instance: u32) -> f32 {
        let others =
            graph.resources(instance).iter().filter_map(|&u| self.reservations.holder_of(u)).map(|c| c as usize);
        let stays = |c: usize| {
            let (state, passes_s) = (&self.states[c], self.config.patience_s);
            match (state.activity, state.goal) {
                (InhabitantActivity::Performing, InhabitantGoal::Perform { seconds, .. }) => {
                    (seconds - state.performed as f32 / self.rate_hz).max(passes_s)
                }
                (InhabitantActivity::Arrived, _) => STAY_S,
                _ => passes_s,
            }
        };
        others.filter(|&c| c != character).map(stays).fold(0.0, f32::max)
    }
}
