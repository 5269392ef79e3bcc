//! Costs through a region, from every entrance into it to every exit from it.

use super::{Entrance, PathHierarchy, each, plane::TilePlane};
use crate::path_hierarchy::dial::{UNREACHED, whole};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_core::patch::NONE;

/// Most costs that are kept; in worlds of more each is worked out whenever it is asked for (costs).
const MAX_COSTS: usize = 1 << 26;
/// Most others that an exit of a region is compared with: more leave out more paths on, but each that stays is compared
/// with all of them.
const MAX_OTHERS: usize = 16;
/// Largest cost to go to a substitute: a higher one keeps more of them, each of which leaves out only paths on that
/// cost so much more (frames).
const MAX_DETOUR: f32 = 200.0;
/// Largest offset of substitutes: costs to most goals are in tables only for nearby offsets, which alone bound a path's
/// cost from above (copies).
const AROUND: i32 = 3;

/// Costs through regions.
///
/// A region is entered by exits of clusters and by portals, which stand in its *list*; it is left by paths into clusters
/// and by portals to other regions, each of which has a *row* of costs, one for each of the list. Beside its row each has
/// *others*, substitutes: near entrances by which the region may be left instead.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct RegionCosts {
    /// Start of each region's part of the list (regions + 1).
    #[serde(with = "crate::pod")]
    first: Vec<u32>,
    /// States that enter regions: entrances, and above them exits.
    #[serde(with = "crate::pod")]
    pub states: Vec<u32>,
    /// Place in the list by state; [`NONE`] for what enters no region.
    #[serde(with = "crate::pod")]
    place: Vec<u32>,
    /// Entrances that lead from each region.
    pub leaving: Vec<Vec<u32>>,
    /// Start of the row of each entrance; none where rows are not kept (entrances).
    rows: Vec<usize>,
    #[serde(with = "crate::pod")]
    costs: Vec<u16>,
    /// Others of each entrance: what it is, and what it costs at most to go there instead (entrances + 1).
    #[serde(with = "crate::pod")]
    first_other: Vec<u32>,
    others: Vec<(u32, u16)>,
}

impl RegionCosts {
    /// Computes the costs through regions, when a hierarchy has all its entrances and exits.
    pub fn new(hierarchy: &PathHierarchy) -> Self {
        let mut out = Self::without_costs(hierarchy);
        out.add_rows(hierarchy);
        out.add_others(hierarchy);
        out
    }

    /// Entrances and exits of each region, without costs.
    fn without_costs(hierarchy: &PathHierarchy) -> Self {
        let num_entrances = hierarchy.entrances.len() as u32;
        let mut out = Self { place: vec![NONE; hierarchy.entrances.len() + hierarchy.exits.len()], ..Self::default() };
        for (exits, portals) in hierarchy.region_exits.iter().zip(&hierarchy.region_portals) {
            out.first.push(out.states.len() as u32);
            out.states.extend(exits.iter().map(|o| num_entrances + o));
            out.states.extend(portals);
        }
        out.first.push(out.states.len() as u32);
        (0u32..).zip(&out.states).for_each(|(place, &state)| out.place[state as usize] = place);
        out.leaving = vec![Vec::new(); hierarchy.region_exits.len()];
        for entrance in 0..num_entrances {
            if let Some((region, ..)) = hierarchy.leads_from(entrance) {
                out.leaving[region as usize].push(entrance);
            }
        }
        out
    }

    /// True where costs read from a file are of the paths of a hierarchy whose paths are sound, and all entries are in
    /// range.
    pub fn is_sound(&self, hierarchy: &PathHierarchy) -> bool {
        let (expected, entrances) = (Self::without_costs(hierarchy), hierarchy.entrances.len());
        let has_same_paths = (&self.first, &self.states, &self.place, &self.leaving)
            == (&expected.first, &expected.states, &expected.place, &expected.leaving);
        let first = &self.first_other;
        let tiles = first.len() == entrances + 1
            && first.windows(2).all(|w| w[0] <= w[1])
            && first[entrances] as usize == self.others.len();
        if !has_same_paths || !tiles {
            return false;
        }
        let row = |e: usize| {
            let len = hierarchy.leads_from(e as u32).map_or(0, |(region, ..)| self.list(region).len());
            self.rows[e].checked_add(len).is_some_and(|end| end <= self.costs.len())
        };
        (self.rows.is_empty() || self.rows.len() == entrances && (0..entrances).all(row))
            && self.others.iter().all(|o| (o.0 as usize) < entrances)
    }

    /// Part of the list that leads into a region.
    pub fn list(&self, region: u32) -> std::ops::Range<usize> {
        self.first[region as usize] as usize..self.first[region as usize + 1] as usize
    }

    /// Place of a state in the list.
    pub fn place(&self, state: u32) -> Option<usize> {
        Some(self.place[state as usize]).filter(|p| *p != NONE).map(|p| p as usize)
    }

    /// Row of an entrance that leads from a region, along the part of the list that leads there; none where it is not
    /// kept.
    pub fn row(&self, entrance: u32, region: u32) -> Option<&[u16]> {
        let first = *self.rows.get(entrance as usize)?;
        Some(&self.costs[first..first + self.list(region).len()])
    }

    /// True where rows are kept.
    pub fn keeps_rows(&self) -> bool {
        !self.rows.is_empty()
    }

    /// Cost in a row (frames).
    pub fn cost(&self, hierarchy: &PathHierarchy, entrance: u32, place: usize) -> u16 {
        let Some((region, tile, goal)) = hierarchy.leads_from(entrance) else { return UNREACHED };
        let Some(plane) = hierarchy.plane(region) else { return UNREACHED };
        let state = self.states[place];
        let cost = match state.checked_sub(hierarchy.entrances.len() as u32) {
            Some(out) => cost_from_exit(hierarchy, plane, out, tile, goal),
            None => match hierarchy.entrances[state as usize] {
                Entrance::Portal { tile: at, goal: into, .. } => {
                    plane.least(plane.lookup(goal, hierarchy.floors.offset(at, tile)), into)
                }
                _ => f32::INFINITY,
            },
        };
        whole(cost)
    }

    /// Others of an entrance: each with what it costs at most to go there instead (frames).
    pub fn substitutes(&self, entrance: u32) -> &[(u32, u16)] {
        let at = entrance as usize;
        &self.others[self.first_other[at] as usize..self.first_other[at + 1] as usize]
    }

    fn add_rows(&mut self, hierarchy: &PathHierarchy) {
        let entrances: Vec<u32> = (0..hierarchy.entrances.len() as u32).collect();
        let list = |entrance: u32| hierarchy.leads_from(entrance).map_or(0..0, |(region, ..)| self.list(region));
        if entrances.iter().map(|&i| list(i).len()).sum::<usize>() > MAX_COSTS {
            return;
        }
        let rows = each(&entrances, |&i, _| list(i).map(|place| self.cost(hierarchy, i, place)).collect::<Vec<_>>());
        for row in rows {
            self.rows.push(self.costs.len());
            self.costs.extend(row);
        }
    }

    fn add_others(&mut self, hierarchy: &PathHierarchy) {
        let mut by_place: BTreeMap<(u32, [i32; 2]), Vec<u32>> = BTreeMap::new();
        let entrances: Vec<u32> = (0..hierarchy.entrances.len() as u32).collect();
        for &i in &entrances {
            if let Some((region, tile, _)) = hierarchy.leads_from(i) {
                by_place.entry((region, hierarchy.floors.places[tile as usize])).or_default().push(i);
            }
        }
        let others = each(&entrances, |&i, _| {
            let mut found = Vec::new();
            let Some((region, tile, goal)) = hierarchy.leads_from(i) else { return found };
            let Some(plane) = hierarchy.plane(region) else { return found };
            let [u, v] = hierarchy.floors.places[tile as usize];
            let around = (-AROUND..=AROUND).flat_map(|du| (-AROUND..=AROUND).map(move |dv| [u + du, v + dv]));
            for &other in around.filter_map(|at| by_place.get(&(region, at))).flatten().filter(|o| **o != i) {
                let Some((_, to, into)) = hierarchy.leads_from(other) else { continue };
                let most = plane.most(into, hierarchy.floors.offset(tile, to), goal);
                if most <= MAX_DETOUR {
                    found.push((other, most.ceil() as u16));
                }
            }
            found.sort_by_key(|&(other, most)| (most, other));
            found.truncate(MAX_OTHERS);
            found
        });
        for list in others {
            self.first_other.push(self.others.len() as u32);
            self.others.extend(list);
        }
        self.first_other.push(self.others.len() as u32);
    }
}

/// Least cost from where an exit of a cluster leads to on to a goal on a tile.
fn cost_from_exit(hierarchy: &PathHierarchy, plane: &TilePlane, out: u32, tile: u32, goal: u32) -> f32 {
    let record = &hierarchy.exits[out as usize];
    let Some(through) = record.tile else { return f32::INFINITY };
    let [u, v] = hierarchy.floors.offset(through, tile);
    let spots = hierarchy.costs_in(record.cluster).exit_landings(out - hierarchy.exits_of(record.cluster).start);
    let cost =
        |([du, dv], cell, part): ([i32; 2], u32, f32)| part + plane.cost(plane.lookup(goal, [u - du, v - dv]), cell);
    spots.map(cost).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WorldGraph;
    use crate::made_up::{Tile, places, tiles};
    use crate::made_up_floor;
    use crate::path_hierarchy::Landmarks;
    use proptest::prelude::*;

    /// Checks that no path to the best cell of any other costs more than it says; how many there are.
    fn check_others(tile: &Tile, depths: [i32; 3]) -> usize {
        let world = tile.floor(&places(depths));
        let graph = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
        let hierarchy = graph.hierarchy();
        let mut count = 0;
        for entrance in 0..hierarchy.entrances.len() as u32 {
            let Some((region, at, goal)) = hierarchy.leads_from(entrance) else { continue };
            let (plane, others) = (hierarchy.plane(region).unwrap(), hierarchy.region_costs.substitutes(entrance));
            assert!(others.len() <= MAX_OTHERS && others.iter().all(|o| o.0 != entrance), "{entrance}: {others:?}");
            let found: Vec<_> = plane.cells(goal).iter().map(|&(cell, _)| tile.dijkstra(cell)).collect();
            for &(other, most) in others {
                let (from, to, into) = hierarchy.leads_from(other).unwrap();
                assert_eq!(from, region, "{entrance} {other}");
                let offset = hierarchy.floors.offset(at, to);
                for found in &found {
                    let costs = plane.cells(into).iter().filter_map(|c| found.get(&(offset, c.0)));
                    let least = costs.min().expect("a way leads there");
                    assert!(*least <= u32::from(most), "{entrance} to {other}: {least} {most}");
                }
                count += 1;
            }
        }
        count
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn others_are_no_farther_than_they_say(tile in tiles(), depths in prop::array::uniform3(0i32..4)) {
            check_others(&tile, depths);
        }
    }

    #[test]
    fn portals_beside_each_other_are_others() {
        assert!(check_others(&Tile::crossed_in(20, 16), [3, 4, 2]) > 0);
    }

    #[test]
    fn ways_of_other_regions_are_refused() {
        let tables = made_up_floor::tables();
        let data = made_up_floor::world(&tables, &["######", "####b#", "######", "###...", "#b#...", "###..."]);
        let graph = WorldGraph::new(tables.patches(), &data.tables()).unwrap();
        let is_sound = |forge: &dyn Fn(&mut PathHierarchy)| {
            let mut hierarchy = graph.hierarchy().clone();
            assert_eq!([hierarchy.region_exits.len(), hierarchy.region_portals.len()], [2; 2]);
            assert!(hierarchy.region_exits.iter().chain(&hierarchy.region_portals).all(|list| !list.is_empty()));
            forge(&mut hierarchy);
            hierarchy.is_sound(&graph)
        };
        assert!(is_sound(&|_| ()));
        assert!(!is_sound(&|h| h.region_exits.swap(0, 1)));
        assert!(!is_sound(&|h| h.region_portals.swap(0, 1)));
        assert!(!is_sound(&|h| h.region_costs.leaving.swap(0, 1)));
        assert!(!is_sound(&|h| h.region_costs.states.reverse()));
        assert!(!is_sound(&|h| h.region_costs.place.fill(0)));
        // The class of cells inside is entered across no edge; what is beyond is no class.
        for wrong in [4, 5] {
            assert!(!is_sound(&|h| {
                let portal = h.entrances.iter_mut().find_map(|e| match e {
                    Entrance::Portal { goal, .. } => Some(goal),
                    _ => None,
                });
                *portal.unwrap() = wrong;
            }));
        }
    }

    #[test]
    fn without_rows_costs_are_the_same_and_landmarks_say_nothing() {
        let tile = Tile::crossed_in(20, 16);
        let world = tile.floor(&places([3, 4, 2]));
        let graph = WorldGraph::new(&tile.patches(), &world.tables()).unwrap();
        let mut hierarchy = graph.hierarchy().clone();
        let num_entrances = hierarchy.entrances.len() as u32;
        for entrance in 0..num_entrances {
            let (region, ..) = hierarchy.leads_from(entrance).unwrap();
            let costs: Vec<_> = hierarchy
                .region_costs
                .list(region)
                .map(|p| hierarchy.region_costs.cost(&hierarchy, entrance, p))
                .collect();
            assert_eq!(hierarchy.region_costs.row(entrance, region), Some(&costs[..]));
        }
        let most = |landmarks: &Landmarks| {
            let all = (0..num_entrances).flat_map(|from| (0..num_entrances).map(move |to| (from, to)));
            let least = |(from, to)| {
                let mut near = Landmarks::UNKNOWN_DISTANCES;
                landmarks.note_distance(&mut near, from, 7.0);
                landmarks.least_cost(&near, to)
            };
            all.map(least).fold(0.0, f32::max)
        };
        assert!(most(&hierarchy.landmarks) > 0.0);
        hierarchy.region_costs.rows.clear();
        assert_eq!(most(&Landmarks::new(&graph, &hierarchy)), 0.0);
    }
}
