//! Which instances offer what: motion with a tag that begins where a character can come to rest.

use super::Inhabitants;
use crate::world::{Node, WorldGraph};

/// Instances that offer each tag, by `tag - 1`.
pub(super) fn by_tag(graph: &WorldGraph<'_>) -> Vec<Vec<u32>> {
    let num_tags = graph.patches().links.iter().map(|l| usize::from(l.tag)).max().unwrap_or(0);
    let mut out = vec![Vec::new(); num_tags];
    for instance in 0..graph.num_instances() as u32 {
        for l in graph.links(instance) {
            let Some(list) = usize::from(l.tag).checked_sub(1).map(|t| &mut out[t]) else { continue };
            let from = Node { instance, cell: l.from };
            if list.last() != Some(&instance) && graph.begins(from, l.tag) {
                list.push(instance);
            }
        }
    }
    out
}

impl Inhabitants {
    /// The nearest instance that offers a tag, of those that nobody else holds where there are any.
    pub(super) fn nearest_offer(&self, graph: &WorldGraph<'_>, character: usize, tag: u16) -> Option<u32> {
        let list = self.offers.get(usize::from(tag).checked_sub(1)?)?;
        let here = graph.place(self.minds[character].at).translation();
        let far = |i: u32| {
            let held = !self.holders.are_free(graph.resources(i), character as u32);
            (held, (graph.centre(i) - here).length_squared())
        };
        list.iter().copied().min_by(|&a, &b| far(a).partial_cmp(&far(b)).unwrap_or(std::cmp::Ordering::Equal))
    }
}
