//! Roads: what it costs to go on through a room, from every way that leads into it to every one that leads out of it.

use super::plane::Plane;
use super::{Atlas, In, each};
use crate::patch::NONE;
use crate::world::atlas::dial::UNREACHED;
use std::collections::BTreeMap;

/// Most costs that are kept; in worlds of more each is worked out whenever it is asked for. [Unit: costs]
const MAX_COSTS: usize = 1 << 26;
/// Most others that a way out of a room is compared with: more leave out more ways on, but each that stays is compared
/// with all of them.
const MAX_OTHERS: usize = 16;
/// What it costs at most to go to others: a higher one keeps more of them, each of which leaves out only ways on that
/// cost so much more. [Unit: frames]
const MAX_DETOUR: f32 = 200.0;
/// How far away others are looked for: as far as costs to most goals are in tables of nearby offsets, which alone say
/// what a way costs at most. [Unit: copies]
const AROUND: i32 = 3;

/// Costs through rooms.
///
/// A room is entered by ways out of districts and by doors, which stand in its *list*; it is left by ways into districts
/// and by doors to other rooms, each of which has a *row* of costs, one for each of the list. Beside its row each has
/// *others*: ways to leave the room that are near.
#[derive(Clone, Debug, Default)]
pub(crate) struct Roads {
    /// Where each room's part of the list begins. [Size: rooms + 1]
    first: Vec<u32>,
    /// What rooms are entered by: ways in, and above them ways out.
    pub states: Vec<u32>,
    /// Place in the list by state; [`NONE`] for what enters no room.
    place: Vec<u32>,
    /// Ways that lead from each room.
    pub leaving: Vec<Vec<u32>>,
    /// Where the row of each way in begins; none where rows are not kept. [Size: ins]
    rows: Vec<usize>,
    costs: Vec<u16>,
    /// Others of each way in: what it is, and what it costs at most to go there instead. [Size: ins + 1]
    first_other: Vec<u32>,
    others: Vec<(u32, u16)>,
}

impl Roads {
    /// Works out what leads through rooms, when an atlas has all its ways.
    pub fn new(atlas: &Atlas) -> Self {
        let num_ins = atlas.ins.len() as u32;
        let mut out = Self { place: vec![NONE; atlas.ins.len() + atlas.outs.len()], ..Self::default() };
        for (outs, doors) in atlas.room_outs.iter().zip(&atlas.room_doors) {
            out.first.push(out.states.len() as u32);
            out.states.extend(outs.iter().map(|o| num_ins + o));
            out.states.extend(doors);
        }
        out.first.push(out.states.len() as u32);
        (0u32..).zip(&out.states).for_each(|(place, &state)| out.place[state as usize] = place);
        out.leaving = vec![Vec::new(); atlas.room_outs.len()];
        for way_in in 0..num_ins {
            if let Some((room, ..)) = atlas.leads_from(way_in) {
                out.leaving[room as usize].push(way_in);
            }
        }
        out.add_rows(atlas);
        out.add_others(atlas);
        out
    }

    /// Part of the list that leads into a room.
    pub fn list(&self, room: u32) -> std::ops::Range<usize> {
        self.first[room as usize] as usize..self.first[room as usize + 1] as usize
    }

    /// Place of a state in the list.
    pub fn place(&self, state: u32) -> Option<usize> {
        Some(self.place[state as usize]).filter(|p| *p != NONE).map(|p| p as usize)
    }

    /// Row of a way that leads from a room, along the part of the list that leads there; none where it is not kept.
    /// [Unit: frames]
    pub fn row(&self, way_in: u32, room: u32) -> Option<&[u16]> {
        let first = *self.rows.get(way_in as usize)?;
        Some(&self.costs[first..first + self.list(room).len()])
    }

    /// True where rows are kept.
    pub fn are_kept(&self) -> bool {
        !self.rows.is_empty()
    }

    /// One cost of a row. [Unit: frames]
    pub fn cost(&self, atlas: &Atlas, way_in: u32, place: usize) -> u16 {
        let Some((room, tile, goal)) = atlas.leads_from(way_in) else { return UNREACHED };
        let Some(plane) = atlas.plane(room) else { return UNREACHED };
        let state = self.states[place];
        let cost = match state.checked_sub(atlas.ins.len() as u32) {
            Some(out) => cost_from_out(atlas, plane, out, tile, goal),
            None => match atlas.ins[state as usize] {
                In::Door { tile: at, goal: into, .. } => {
                    plane.least(plane.look(goal, atlas.regions.way(at, tile)), into)
                }
                _ => f32::INFINITY,
            },
        };
        if cost == f32::INFINITY { UNREACHED } else { cost.clamp(0.0, f32::from(UNREACHED) - 1.0) as u16 }
    }

    /// Others of a way in: each with what it costs at most to go there instead. [Unit: frames]
    pub fn others(&self, way_in: u32) -> &[(u32, u16)] {
        let at = way_in as usize;
        &self.others[self.first_other[at] as usize..self.first_other[at + 1] as usize]
    }

    fn add_rows(&mut self, atlas: &Atlas) {
        let ins: Vec<u32> = (0..atlas.ins.len() as u32).collect();
        let list = |way_in: u32| atlas.leads_from(way_in).map_or(0..0, |(room, ..)| self.list(room));
        if ins.iter().map(|&i| list(i).len()).sum::<usize>() > MAX_COSTS {
            return;
        }
        let rows = each(&ins, |&i, _| list(i).map(|place| self.cost(atlas, i, place)).collect::<Vec<_>>());
        for row in rows {
            self.rows.push(self.costs.len());
            self.costs.extend(row);
        }
    }

    fn add_others(&mut self, atlas: &Atlas) {
        let mut by_place: BTreeMap<(u32, [i32; 2]), Vec<u32>> = BTreeMap::new();
        let ins: Vec<u32> = (0..atlas.ins.len() as u32).collect();
        for &i in &ins {
            if let Some((room, tile, _)) = atlas.leads_from(i) {
                by_place.entry((room, atlas.regions.place(tile))).or_default().push(i);
            }
        }
        let others = each(&ins, |&i, _| {
            let mut found = Vec::new();
            let Some((room, tile, goal)) = atlas.leads_from(i) else { return found };
            let Some(plane) = atlas.plane(room) else { return found };
            let [u, v] = atlas.regions.place(tile);
            let around = (-AROUND..=AROUND).flat_map(|du| (-AROUND..=AROUND).map(move |dv| [u + du, v + dv]));
            for &other in around.filter_map(|at| by_place.get(&(room, at))).flatten().filter(|o| **o != i) {
                let Some((_, to, into)) = atlas.leads_from(other) else { continue };
                let most = plane.most(into, atlas.regions.way(tile, to), goal);
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

/// Least cost from where a way out of a district leads to on to a goal on a tile.
fn cost_from_out(atlas: &Atlas, plane: &Plane, out: u32, tile: u32, goal: u32) -> f32 {
    let record = &atlas.outs[out as usize];
    let Some(through) = record.tile else { return f32::INFINITY };
    let [u, v] = atlas.regions.way(through, tile);
    let spots = atlas.shape(record.district).spots(out - atlas.outs_of(record.district).start);
    let cost =
        |([du, dv], cell, part): ([i32; 2], u32, f32)| part + plane.cost(plane.look(goal, [u - du, v - dv]), cell);
    spots.map(cost).fold(f32::INFINITY, f32::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::WorldGraph;
    use crate::world::atlas::Landmarks;
    use crate::world::made_up::{Tile, places, tiles};
    use proptest::prelude::*;

    /// Checks that no way to the best cell of any other costs more than it says; how many there are.
    fn check_others(tile: &Tile, depths: [i32; 3]) -> usize {
        let world = tile.floor(&places(depths));
        let graph = WorldGraph::new(tile.patches(), world.view()).unwrap();
        let atlas = graph.atlas();
        let mut count = 0;
        for way_in in 0..atlas.ins.len() as u32 {
            let Some((room, at, goal)) = atlas.leads_from(way_in) else { continue };
            let (plane, others) = (atlas.plane(room).unwrap(), atlas.roads.others(way_in));
            assert!(others.len() <= MAX_OTHERS && others.iter().all(|o| o.0 != way_in), "{way_in}: {others:?}");
            let found: Vec<_> = plane.cells(goal).iter().map(|&(cell, _)| tile.dijkstra(cell)).collect();
            for &(other, most) in others {
                let (from, to, into) = atlas.leads_from(other).unwrap();
                assert_eq!(from, room, "{way_in} {other}");
                let way = atlas.regions.way(at, to);
                for found in &found {
                    let costs = plane.cells(into).iter().filter_map(|c| found.get(&(way, c.0)));
                    let least = costs.min().expect("a way leads there");
                    assert!(*least <= u32::from(most), "{way_in} to {other}: {least} {most}");
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
    fn doors_beside_each_other_are_others() {
        assert!(check_others(&Tile::crossed_in(20, 16), [3, 4, 2]) > 0);
    }

    #[test]
    fn without_rows_costs_are_the_same_and_landmarks_say_nothing() {
        let tile = Tile::crossed_in(20, 16);
        let world = tile.floor(&places([3, 4, 2]));
        let graph = WorldGraph::new(tile.patches(), world.view()).unwrap();
        let mut atlas = graph.atlas().clone();
        let num_ins = atlas.ins.len() as u32;
        for way_in in 0..num_ins {
            let (room, ..) = atlas.leads_from(way_in).unwrap();
            let costs: Vec<_> = atlas.roads.list(room).map(|p| atlas.roads.cost(&atlas, way_in, p)).collect();
            assert_eq!(atlas.roads.row(way_in, room), Some(&costs[..]));
        }
        let most = |landmarks: &Landmarks| {
            let all = (0..num_ins).flat_map(|from| (0..num_ins).map(move |to| (from, to)));
            let least = |(from, to)| {
                let mut near = Landmarks::none();
                landmarks.meet(&mut near, from, 7.0);
                landmarks.least(&near, to)
            };
            all.map(least).fold(0.0, f32::max)
        };
        assert!(most(&atlas.landmarks) > 0.0);
        atlas.roads.rows.clear();
        assert_eq!(most(&Landmarks::new(&graph, &atlas)), 0.0);
    }
}
