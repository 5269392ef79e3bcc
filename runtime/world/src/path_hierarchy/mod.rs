//! Path hierarchy: lower bounds of costs that planning uses, on open ground and within structures to climb or sit on.
//!
//! Tiles that fill a plane together are a *floor*; costs between them are those of the endless plane without obstacles,
//! one table a patch. A floor with corners consists of *regions*, with portals from one to another. Everything else
//! that overlaps is a *cluster*, with costs between its cells and its entrances and exits, one table for all alike
//! clusters. All costs are lower bounds.

mod cluster_costs;
mod clusters;
mod dial;
mod floors;
mod landmarks;
mod plane;
mod region_costs;
mod regions;

use super::WorldGraph;
use cluster_costs::{AdjacentPart, ClusterCosts, ClusterOutline};
use clusters::Clusters;
use dial::Dial;
use floors::Floors;
pub(crate) use landmarks::{Landmarks, ToLandmarks};
pub(crate) use plane::{CellCost, CostLookup, TilePlane, class_of};
use region_costs::RegionCosts;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use throng_core::patch::{NONE, PatchRecord};

/// No exit leads farther from its tile than this (copies).
const MAX_OFFSET: i32 = 1 << 25;

/// True where an exit may lead so far. The least number has no positive counterpart.
fn is_near(offset: [i32; 2]) -> bool {
    offset.iter().all(|o| (-MAX_OFFSET..=MAX_OFFSET).contains(o))
}

/// An entrance of a cluster or region: where a search comes into it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) enum Entrance {
    /// From some cells of a tile, into a cluster.
    Tile {
        /// The tile.
        tile: u32,
        /// The cells, see [`TilePlane`].
        goal: u32,
    },
    /// From another cluster into a cluster.
    Cluster {
        /// Number of the other cluster.
        from: u32,
        /// Number of the cluster that is entered.
        to: u32,
    },
    /// From one region into another one, to cells of a tile there that are entered across an edge.
    Portal {
        /// The region that it leads from.
        from: u32,
        /// The tile.
        tile: u32,
        /// The cells, see [`TilePlane`].
        goal: u32,
    },
}

impl Entrance {
    /// The region that it leads from where it is a portal, and the tile and its cells that it leads by; none where it leads
    /// from another cluster.
    pub fn tile(&self) -> Option<(Option<u32>, u32, u32)> {
        match *self {
            Self::Tile { tile, goal } => Some((None, tile, goal)),
            Self::Portal { from, tile, goal } => Some((Some(from), tile, goal)),
            Self::Cluster { .. } => None,
        }
    }
}

/// An exit of a cluster.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Exit {
    /// The cluster.
    pub cluster: u32,
    /// Tile whose links it leads along; none where it leads to another cluster.
    pub tile: Option<u32>,
    /// The other cluster.
    pub to: Option<u32>,
}

/// Costs of a world's parts, see the module.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct PathHierarchy {
    planes: Vec<Option<TilePlane>>,
    /// Floors: tiles that fill a plane together.
    pub floors: Floors,
    /// Clusters: everything else.
    pub clusters: Clusters,
    cluster_costs: Vec<ClusterCosts>,
    /// Number in `cluster_costs` of each cluster.
    #[serde(with = "crate::pod")]
    costs_of: Vec<u32>,
    /// First entrance and exit of each cluster (clusters + 1).
    #[serde(with = "crate::pod")]
    first: Vec<[u32; 2]>,
    /// Entrances of clusters, then the portals between regions.
    pub entrances: Vec<Entrance>,
    /// Exits of clusters.
    pub exits: Vec<Exit>,
    /// Exits that lead to tiles of each region, by the tile that they lead through.
    pub region_exits: Vec<Vec<u32>>,
    /// Portals that lead into each region.
    pub region_portals: Vec<Vec<u32>>,
    /// Costs from the latter to the former.
    pub region_costs: RegionCosts,
    /// Costs to some entrances from all entrances and exits.
    pub landmarks: Landmarks,
}

impl PathHierarchy {
    /// Works it out, in a fraction of a second for worlds of a few thousand instances that are much alike.
    pub fn new(graph: &WorldGraph) -> Self {
        let patches = graph.patches();
        let mut search = Dial::default();
        let planes: Vec<_> = (0..patches.patches.len()).map(|p| TilePlane::new(patches, p, &mut search)).collect();
        let floors = Floors::new(graph, &planes);
        let clusters = Clusters::new(graph, &floors);
        let num_regions = floors.num_regions();
        let mut out = Self {
            planes,
            floors,
            clusters,
            first: vec![[0, 0]],
            region_exits: vec![Vec::new(); num_regions],
            region_portals: vec![Vec::new(); num_regions],
            ..Self::default()
        };
        out.add_clusters(graph);
        out.region_exits.iter_mut().for_each(|exits| exits.sort_by_key(|&o| out.exits[o as usize].tile));
        for tile in 0..graph.num_instances() as u32 {
            out.add_portals(graph, tile);
        }
        out.region_costs = RegionCosts::new(&out);
        out.landmarks = Landmarks::new(graph, &out);
        out
    }

    /// True where all entries of a hierarchy read from a file are in range.
    pub fn is_sound(&self, graph: &WorldGraph) -> bool {
        let records = &graph.patches().patches;
        let longest = graph.max_link_frames();
        let plane = |(p, plane): (&PatchRecord, &Option<TilePlane>)| {
            plane.as_ref().is_none_or(|plane| plane.is_sound(p.num_cells, p.num_edges))
        };
        let costs = |cluster: u32| self.cluster_costs.get(*self.costs_of.get(cluster as usize)? as usize);
        self.planes.len() == records.len()
            && records.iter().zip(&self.planes).all(plane)
            && self.floors.is_sound(graph, &self.planes)
            && self.cluster_costs.iter().all(|c| c.is_sound(longest))
            && (0..self.costs_of.len() as u32).all(|c| costs(c).is_some())
            && self.clusters.is_sound(graph, |cluster| costs(cluster).map(|c| c.num_cells))
            && self.numbers_are_sound()
            && self.entrances.iter().all(|e| self.is_entrance(graph, e))
            && (0..self.exits.len() as u32).all(|e| self.is_exit(graph, e))
            && self.regions_are_sound()
            && self.region_costs.is_sound(self)
            && self.landmarks.costs.len() == self.entrances.len() + self.exits.len()
    }

    /// True where clusters have the entrances and exits of their costs.
    fn numbers_are_sound(&self) -> bool {
        let counts = |(pair, &costs): (&[[u32; 2]], &u32)| {
            let c = &self.cluster_costs[costs as usize];
            let [[a, x], [b, y]] = [pair[0], pair[1]].map(|p| p.map(|n| n as usize));
            a.checked_add(c.entrances.len()) == Some(b) && x.checked_add(c.exits.len()) == Some(y)
        };
        let ends = |[entrances, exits]: [u32; 2]| {
            entrances as usize <= self.entrances.len() && exits as usize == self.exits.len()
        };
        self.first.len() == self.costs_of.len() + 1
            && self.first.windows(2).zip(&self.costs_of).all(counts)
            && self.first.last().is_some_and(|last| ends(*last))
    }

    /// True where the exits and portals of each region lead to tiles of it (entrances and exits are sound).
    fn regions_are_sound(&self) -> bool {
        let exit_to = |e: u32| self.exits.get(e as usize)?.tile;
        let portal_to = |e: u32| match self.entrances.get(e as usize)? {
            Entrance::Portal { tile, .. } => Some(*tile),
            _ => None,
        };
        let lead_there = |lists: &[Vec<u32>], to: &dyn Fn(u32) -> Option<u32>| {
            let is_there = |(region, list): (u32, &Vec<u32>)| {
                list.iter().all(|&e| to(e).is_some_and(|tile| self.floors.region(tile) == Some(region)))
            };
            lists.len() == self.floors.num_regions() && (0..).zip(lists).all(is_there)
        };
        lead_there(&self.region_exits, &exit_to) && lead_there(&self.region_portals, &portal_to)
    }

    fn is_entrance(&self, graph: &WorldGraph, entrance: &Entrance) -> bool {
        let is_goal = |region: u32, goal: u32| {
            let exists = (region as usize) < self.floors.num_regions();
            exists && self.plane(region).is_some_and(|p| (goal as usize) < p.num_goals())
        };
        let is_tile = |tile: u32| (tile as usize) < graph.num_instances();
        match *entrance {
            Entrance::Tile { tile, goal } => {
                is_tile(tile) && self.floors.region(tile).is_none_or(|region| is_goal(region, goal))
            }
            Entrance::Portal { from, tile, goal } => {
                // The goal of a portal is the class of cells that are entered across an edge.
                let is_edge = |to: u32| {
                    let patch = self.floors.patches[to as usize];
                    patch == self.floors.patches[from as usize]
                        && goal < graph.patches().patches[patch as usize].num_edges
                };
                is_tile(tile) && is_goal(from, goal) && self.floors.region(tile).is_some_and(is_edge)
            }
            Entrance::Cluster { from, to } => from.max(to) < self.num_clusters() as u32,
        }
    }

    fn is_exit(&self, graph: &WorldGraph, number: u32) -> bool {
        let exit = &self.exits[number as usize];
        if exit.cluster as usize >= self.num_clusters() || !self.exits_of(exit.cluster).contains(&number) {
            return false;
        }
        let Some(tile) = exit.tile else { return true };
        let spots = self.costs_in(exit.cluster).exit_landings(number - self.exits_of(exit.cluster).start);
        (tile as usize) < graph.num_instances()
            && spots.into_iter().all(|(offset, cell, _)| cell < graph.num_cells(tile) && is_near(offset))
    }

    /// The plane of a region's tiles.
    pub fn plane(&self, region: u32) -> Option<&TilePlane> {
        self.planes[self.floors.patches[region as usize] as usize].as_ref()
    }

    /// The region of a tile, and its plane.
    pub fn region_and_plane(&self, tile: u32) -> Option<(u32, &TilePlane)> {
        let region = self.floors.region(tile)?;
        Some((region, self.plane(region)?))
    }

    /// The region that an entrance leads from, and the tile and its cells that it leads by; none where it leads from another
    /// cluster.
    pub fn leads_from(&self, entrance: u32) -> Option<(u32, u32, u32)> {
        let (from, tile, goal) = self.entrances[entrance as usize].tile()?;
        Some((from.or_else(|| self.floors.region(tile))?, tile, goal))
    }

    /// Cluster of an instance, and the number of its first cell there; none for a tile of a floor.
    pub fn cluster(&self, instance: u32) -> Option<(u32, u32)> {
        self.clusters.cluster_of(instance).map(|d| (d, self.clusters.first_cell[instance as usize]))
    }

    /// Number of clusters.
    pub fn num_clusters(&self) -> usize {
        self.costs_of.len()
    }

    /// Costs within a cluster.
    pub fn costs_in(&self, cluster: u32) -> &ClusterCosts {
        &self.cluster_costs[self.costs_of[cluster as usize] as usize]
    }

    /// Entrances of a cluster.
    pub fn entrances_of(&self, cluster: u32) -> std::ops::Range<u32> {
        self.first[cluster as usize][0]..self.first[cluster as usize + 1][0]
    }

    /// Exits of a cluster.
    pub fn exits_of(&self, cluster: u32) -> std::ops::Range<u32> {
        self.first[cluster as usize][1]..self.first[cluster as usize + 1][1]
    }

    fn add_clusters(&mut self, graph: &WorldGraph) {
        let (floors, clusters) = (&self.floors, &self.clusters);
        let outlines: Vec<_> = (0..clusters.members.len() as u32)
            .map(|cluster| ClusterOutline::new(graph, floors, clusters, cluster))
            .collect();
        let (mut known, mut kinds) = (BTreeMap::new(), Vec::new());
        for outline in &outlines {
            self.costs_of.push(*known.entry(outline.cost_key()).or_insert_with(|| {
                kinds.push(outline);
                kinds.len() as u32 - 1
            }));
        }
        self.cluster_costs = each(&kinds, |outline, search| ClusterCosts::new(outline, search));
        // Patches with the cells that entrances of clusters begin in.
        let mut goals = BTreeSet::new();
        for (outline, costs_in) in kinds.iter().zip(&self.cluster_costs) {
            for (beyond, cells) in &costs_in.entrances {
                let Some(tile) = outline.adjacent_parts[*beyond as usize].tile() else { continue };
                goals.insert((graph.instance(tile).patch, cells.clone()));
            }
        }
        let planes = (0u32..).zip(&self.planes).filter_map(|(patch, plane)| Some((patch, plane.as_ref()?)));
        goals.extend(planes.flat_map(|(patch, p)| p.is_rest_goal().into_iter().map(move |r| (patch, r))));
        add_goals(&mut self.planes, goals);
        for (outline, &costs_in) in outlines.iter().zip(&self.costs_of) {
            let costs_in = &self.cluster_costs[costs_in as usize];
            for &k in &costs_in.exits {
                let beyond = outline.adjacent_parts[k as usize];
                if let Some(region) = beyond.tile().and_then(|t| floors.region(t)) {
                    self.region_exits[region as usize].push(self.exits.len() as u32);
                }
                self.exits.push(Exit { cluster: outline.cluster, tile: beyond.tile(), to: beyond.cluster() });
            }
            for (k, cells) in &costs_in.entrances {
                self.entrances.push(match outline.adjacent_parts[*k as usize] {
                    AdjacentPart::Tile(tile) => {
                        let plane = self.planes[graph.instance(tile).patch as usize].as_ref();
                        Entrance::Tile { tile, goal: plane.and_then(|p| p.goal(cells)).unwrap_or(0) }
                    }
                    AdjacentPart::Cluster(from) => Entrance::Cluster { from, to: outline.cluster },
                });
            }
            self.first.push([self.entrances.len() as u32, self.exits.len() as u32]);
        }
    }

    /// Adds the portals that lead to a tile.
    fn add_portals(&mut self, graph: &WorldGraph, tile: u32) {
        let Some(region) = self.floors.region(tile) else { return };
        let (r, patches) = (graph.instance(tile), graph.patches());
        for (goal, edge) in (0u32..).zip(patches.edges_of(r.patch as usize)) {
            let other = graph.world().neighbours[(r.first_neighbour + goal) as usize];
            if other == NONE || !graph.bounds.is_edge_open(graph.instance(other).first_neighbour + edge.opposite) {
                continue;
            }
            if let Some(from) = self.floors.region(other).filter(|f| *f != region) {
                self.region_portals[region as usize].push(self.entrances.len() as u32);
                self.entrances.push(Entrance::Portal { from, tile, goal });
            }
        }
    }
}

/// Adds cells of patches to the goals of their planes.
fn add_goals(planes: &mut [Option<TilePlane>], goals: BTreeSet<(u32, Vec<CellCost>)>) {
    let goals: Vec<_> = goals.into_iter().filter(|(p, _)| planes[*p as usize].is_some()).collect();
    let cells: BTreeSet<_> = goals.iter().flat_map(|(p, cells)| cells.iter().map(|c| (*p, c.0))).collect();
    let cells: Vec<_> = cells.into_iter().collect();
    let rows = each(&cells, |&(p, cell), search| planes[p as usize].as_ref().map(|plane| plane.rows_to(cell, search)));
    let rows: BTreeMap<_, _> = cells.into_iter().zip(rows).filter_map(|(c, r)| Some((c, r?))).collect();
    for (patch, cells) in goals {
        let parts: Vec<_> = cells.iter().filter_map(|c| Some((rows.get(&(patch, c.0))?, c.1))).collect();
        if let Some(plane) = planes[patch as usize].as_mut().filter(|p| p.goal(&cells).is_none()) {
            let joined = plane.join_costs(&parts);
            plane.add_goal(joined);
        }
    }
}

/// Results of a search for each element of a list.
#[cfg(feature = "rayon")]
fn each<T: Sync, R: Send>(list: &[T], find: impl Fn(&T, &mut Dial) -> R + Sync) -> Vec<R> {
    use rayon::prelude::*;
    list.par_iter().map_init(Dial::default, |search, item| find(item, search)).collect()
}

/// Results of a search for each element of a list.
#[cfg(not(feature = "rayon"))]
fn each<T, R>(list: &[T], find: impl Fn(&T, &mut Dial) -> R) -> Vec<R> {
    let mut search = Dial::default();
    list.iter().map(|item| find(item, &mut search)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exits_lead_no_farther_than_can_be_counted() {
        assert!([0, MAX_OFFSET, -MAX_OFFSET].iter().all(|&o| is_near([o, 0]) && is_near([0, o])));
        let far = [MAX_OFFSET + 1, -MAX_OFFSET - 1, i32::MAX, i32::MIN];
        assert!(far.iter().all(|&o| !is_near([o, 0]) && !is_near([0, o])));
    }
}
