//! Tables of a world that `stitch` computes, so that opening it takes no search: the path hierarchy with its costs,
//! paths to rest, narrow passages, open borders.

use super::{OpenConnections, WorldGraph};
use crate::{path_hierarchy::PathHierarchy, pod};
use serde::Deserialize;
use throng_core::format::FormatError;

/// Most bytes that may be asked for while path costs are decoded (bytes).
const LIMIT: usize = u32::MAX as usize;

/// Path costs of a world, as its file keeps them.
#[derive(Clone, Debug, Default)]
pub struct PathCosts(pub(crate) Vec<u8>);

impl PathCosts {
    /// Works out the costs of a world (seconds for a world of a few hundred instances, on all threads with the feature
    /// `rayon`).
    ///
    /// # Errors
    /// [`FormatError::Layout`] where they cannot be encoded.
    pub fn bake(graph: &WorldGraph) -> Result<Self, FormatError> {
        // The fields of `BakedCosts`, in their order.
        let to_rest: &[u8] = bytemuck::cast_slice(&graph.to_rest);
        let baked = (to_rest, &graph.narrow, &graph.bounds, graph.hierarchy());
        let bytes = bincode::serde::encode_to_vec(baked, bincode::config::legacy());
        bytes.map(Self).map_err(|e| FormatError::layout(format!("path costs cannot be written: {e}")))
    }

    /// Length (bytes).
    pub fn num_bytes(&self) -> usize {
        self.0.len()
    }
}

/// Baked tables, as read from a file.
#[derive(Deserialize)]
pub(crate) struct BakedCosts {
    #[serde(deserialize_with = "pod::deserialize")]
    pub to_rest: Vec<u32>,
    pub narrow: Vec<bool>,
    pub bounds: OpenConnections,
    pub hierarchy: PathHierarchy,
}

impl BakedCosts {
    /// Decodes a section. What it says is checked by [`WorldGraph::from_baked`].
    ///
    /// # Errors
    /// [`FormatError::Layout`] where it is damaged, asks for too much memory, or is followed by something else.
    pub fn decode(bytes: &[u8]) -> Result<Self, FormatError> {
        let config = bincode::config::legacy().with_limit::<LIMIT>();
        match bincode::serde::borrow_decode_from_slice(bytes, config) {
            Ok((baked, used)) if used == bytes.len() => Ok(baked),
            Ok((_, used)) => Err(FormatError::layout(format!("WPTH has {} bytes, expected {used}", bytes.len()))),
            Err(e) => Err(FormatError::layout(format!("WPTH cannot be read: {e}"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made_up::{Tile, nodes, places};
    use crate::made_up_floor;
    use crate::plan::{PlanTarget, WorldPlanner};
    use crate::{WorldData, WorldStep};
    use throng_core::patch::NONE;

    fn floor(tile: &Tile) -> (WorldData, PathCosts) {
        let world = tile.floor(&places([3, 4, 2]));
        let costs = PathCosts::bake(&WorldGraph::new(&tile.patches(), &world.tables()).unwrap()).unwrap();
        (world, costs)
    }

    #[test]
    fn planning_with_baked_costs_finds_the_same_paths() {
        let tile = Tile::crossed_in(20, 16);
        let (world, costs) = floor(&tile);
        let made = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
        let read =
            WorldGraph::from_baked(&tile.patches(), &world.tables(), BakedCosts::decode(&costs.0).unwrap()).unwrap();
        assert_eq!(PathCosts::bake(&read).unwrap().0, costs.0);
        let (mut a, mut b) = (WorldPlanner::new(&made), WorldPlanner::new(&read));
        let (mut steps_a, mut steps_b) = ([WorldStep::NONE; 64], [WorldStep::NONE; 64]);
        let all = nodes(&made);
        for (from, to) in all.iter().step_by(7).flat_map(|f| all.iter().step_by(11).map(move |t| (*f, *t))) {
            let plan = a.plan(&made, from, PlanTarget::Node(to), &mut steps_a);
            assert_eq!(plan, b.plan(&read, from, PlanTarget::Node(to), &mut steps_b));
            assert_eq!(steps_a, steps_b);
        }
    }

    #[test]
    fn ways_to_rest_along_links_that_are_not_there_are_refused() {
        let tables = made_up_floor::tables();
        let mut world = made_up_floor::world(&tables, &["##", "##"]);
        let graph = WorldGraph::new(tables.patches(), &world.tables()).unwrap();
        let costs = PathCosts::bake(&graph).unwrap();
        let open = |world: &WorldData| {
            WorldGraph::from_baked(tables.patches(), &world.tables(), BakedCosts::decode(&costs.0).unwrap()).map(|_| ())
        };
        open(&world).unwrap();
        let link = *graph.to_rest.iter().find(|l| **l != NONE).unwrap();
        world.link_words[link as usize / 64] &= !(1 << (link % 64));
        let e = open(&world).unwrap_err().to_string();
        assert!(e.contains("WPTH") && e.contains("throng stitch"), "{e}");
    }

    #[test]
    fn no_damage_to_costs_leads_out_of_their_tables() {
        let tile = Tile::crossed_in(20, 16);
        let (world, costs) = floor(&tile);
        let all = nodes(&WorldGraph::new(&tile.patches(), &world.tables()).unwrap());
        let (mut steps, mut refused) = ([WorldStep::NONE; 64], 0);
        for at in (0..costs.0.len()).step_by(costs.0.len() / 2000 + 1) {
            let mut bytes = costs.0.clone();
            bytes[at] ^= 0x80;
            let read =
                BakedCosts::decode(&bytes).and_then(|b| WorldGraph::from_baked(&tile.patches(), &world.tables(), b));
            let Ok(graph) = read else {
                refused += 1;
                continue;
            };
            let mut planner = WorldPlanner::new(&graph);
            for pair in all.windows(2).step_by(40) {
                let _ = planner.plan_soon(&graph, pair[0], PlanTarget::Node(all[all.len() - 1]), &mut steps);
                let _ = planner.plan_soon(&graph, all[0], PlanTarget::Node(pair[1]), &mut steps);
            }
        }
        assert!(refused > 20, "{refused}");
        assert!((0..costs.0.len()).step_by(97).all(|len| BakedCosts::decode(&costs.0[..len]).is_err()));
    }
}
