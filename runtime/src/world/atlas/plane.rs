//! Least costs on the endless plane of copies of a tile, without obstacles: found once a patch, looked up ever after.

use super::dial::{Arcs, Dial, UNREACHED};
use crate::patch::{CellRecord, NONE, Patches};
use glam::Vec3;

/// Offsets up to this many copies away are in the table. [Unit: copies]
const RADIUS: i32 = 6;
/// Ways may lead this far around them.
const MARGIN: i32 = 2;
const SIDE: i32 = 2 * RADIUS + 1;
/// Offsets of a table. [Size: copies]
const NUM_OFFSETS: usize = (SIDE * SIDE) as usize;
/// Beyond the table costs grow by what they grow by from here to its rim, a copy. [Unit: copies]
const INNER: i32 = RADIUS / 2;

/// A tile whose copies fill a plane. Its cells are of classes: those that are entered across each edge, and the inside.
#[derive(Clone, Debug)]
pub(crate) struct Plane {
    /// What a metre costs at least, of a long way. [Unit: frames/m]
    pub pace: f32,
    /// Steps across each edge, in copies along two directions.
    pub steps: Vec<[i32; 2]>,
    num_cells: u32,
    /// From each cell back to where links to it begin: how many copies away that leads, and the cell.
    arcs: Arcs<([i32; 2], u32)>,
    /// Least frames from each cell to any cell of a class that many copies away. [Size: classes * offsets * cells]
    costs: Vec<u16>,
    /// The least over cells. [Size: classes * offsets]
    least: Vec<u16>,
    /// What a copy of the longer way costs, by class, direction of the longer way and share of the shorter one.
    /// [Unit: frames] [Size: classes * 4 * SIDE]
    slopes: Vec<f32>,
}

/// Where costs to one offset are found: for a cell, those of `Plane::cost` at `first`, and so much more.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Look {
    /// Number of the class's offset: the next one there is in the table.
    pub row: u32,
    /// [Unit: frames]
    pub more: f32,
}

/// Class of a cell: its edge, past the last one the inside.
pub(crate) fn class(cell: &CellRecord, num_edges: u32) -> u32 {
    if cell.edge == NONE { num_edges } else { cell.edge }
}

impl Plane {
    /// The table of a patch; none for blocks, and for tiles whose copies form a line or no lattice.
    pub fn new(patches: &Patches<'_>, patch: usize) -> Option<Self> {
        let edges = patches.edges_of(patch);
        let vectors: Vec<Vec3> = edges.iter().map(|e| Vec3::from_array(e.step)).collect();
        let steps = lattice(&vectors)?;
        let cells = patches.cells_of(patch);
        let num_classes = edges.len() as u32 + 1;
        let mut out = Self {
            pace: f32::INFINITY,
            steps,
            num_cells: cells.len() as u32,
            arcs: Arcs::new(0, std::iter::empty()),
            costs: Vec::with_capacity(num_classes as usize * NUM_OFFSETS * cells.len()),
            least: Vec::new(),
            slopes: Vec::new(),
        };
        out.arcs = out.arcs_back(patches, patch);
        let mut search = Dial::default();
        for c in 0..num_classes {
            out.add_class(cells, c, &mut search);
            out.add_slopes(c);
            out.pace = out.pace_to(c, &vectors).min(out.pace);
        }
        Some(out)
    }

    /// Calls `visit` for every link that leads to a cell, with how many copies away that leads, the cell that it begins
    /// in, and its frames.
    pub fn for_each_link_to(&self, cell: u32, mut visit: impl FnMut([i32; 2], u32, u16)) {
        self.arcs.of(cell).iter().for_each(|&((way, from), frames)| visit(way, from, frames));
    }

    /// Number of classes of cells.
    pub fn num_classes(&self) -> u32 {
        self.steps.len() as u32 + 1
    }

    /// Where costs to cells of a class are found, that many copies away.
    pub fn look(&self, class: u32, [du, dv]: [i32; 2]) -> Look {
        let far = du.abs().max(dv.abs());
        if far <= RADIUS {
            return Look { row: class * NUM_OFFSETS as u32 + offset([du, dv]), more: 0.0 };
        }
        let rim = [du, dv].map(|d| (d as f32 * RADIUS as f32 / far as f32).round() as i32);
        let more = self.norm(class, [du, dv]) - self.norm(class, rim);
        Look { row: class * NUM_OFFSETS as u32 + offset(rim), more: more.max(0.0) }
    }

    /// Cost from a cell; infinite where there is no way. [Unit: frames]
    pub fn cost(&self, look: Look, cell: u32) -> f32 {
        frames(self.costs[(look.row * self.num_cells + cell) as usize]) + look.more
    }

    /// The least cost from any cell. [Unit: frames]
    pub fn least(&self, look: Look) -> f32 {
        frames(self.least[look.row as usize]) + look.more
    }

    /// What far ways cost: as many times the cost of a copy as the longer of the two ways has copies.
    fn norm(&self, class: u32, way: [i32; 2]) -> f32 {
        let far = way[0].abs().max(way[1].abs());
        let axis = usize::from(way[1].abs() == far && way[0].abs() != far);
        let side = 2 * axis + usize::from(way[axis] < 0);
        let at = (way[1 - axis] as f32 / far as f32 + 1.0) * RADIUS as f32;
        let first = (at as usize).min(SIDE as usize - 2);
        let slopes = &self.slopes[(class as usize * 4 + side) * SIDE as usize..][..SIDE as usize];
        let share = at - first as f32;
        far as f32 * (slopes[first] * (1.0 - share) + slopes[first + 1] * share)
    }

    fn pace_to(&self, class: u32, vectors: &[Vec3]) -> f32 {
        let along = |way| self.steps.iter().position(|s| *s == way).map_or(Vec3::ZERO, |e| vectors[e]);
        let [u, v] = [along([1, 0]), along([0, 1])];
        // Some classes are come to from nowhere.
        let known = |o: &[i32; 2]| self.least(self.look(class, *o)) < f32::INFINITY;
        let rim = offsets().filter(|o| o[0].abs().max(o[1].abs()) == RADIUS && known(o));
        rim.map(|o| self.norm(class, o) / (u * o[0] as f32 + v * o[1] as f32).length()).fold(f32::INFINITY, f32::min)
    }

    /// Arcs from each cell back to where links to it begin: the cell, and how many copies away, as one number.
    fn arcs_back(&self, patches: &Patches<'_>, patch: usize) -> Arcs<([i32; 2], u32)> {
        let cells = patches.cells_of(patch);
        let list = patches.links_of(patch).iter().map(|l| {
            let to = &cells[l.to as usize];
            let exit = to.is(CellRecord::IS_EXIT);
            let (cell, step) = if exit { (to.twin, self.steps[to.edge as usize]) } else { (l.to, [0, 0]) };
            (cell, (step, l.from), l.num_frames)
        });
        Arcs::new(cells.len(), list)
    }

    fn add_class(&mut self, cells: &[CellRecord], class_: u32, search: &mut Dial) {
        let (wide, n) = (RADIUS + MARGIN, cells.len() as u32);
        let across = 2 * wide + 1;
        let number = |[x, z]: [i32; 2], cell: u32| ((x + wide) * across + z + wide) as u32 * n + cell;
        let num_edges = self.steps.len() as u32;
        let ends = |c: &CellRecord| !c.is(CellRecord::IS_EXIT) && class(c, num_edges) == class_;
        let targets = cells.iter().enumerate().filter(|(_, c)| ends(c)).map(|(c, _)| (number([0, 0], c as u32), 0, 0));
        search.run((across * across) as usize * cells.len(), targets, |search, state| {
            let (tile, cell) = ((state / n) as i32, state % n);
            let [x, z] = [tile / across - wide, tile % across - wide];
            for &(([dx, dz], from), frames) in self.arcs.of(cell) {
                let at = [x - dx, z - dz];
                if at[0].abs() <= wide && at[1].abs() <= wide {
                    search.reach(number(at, from), frames);
                }
            }
        });
        for [du, dv] in offsets() {
            // The target lies there as seen from where this is.
            let first = self.costs.len();
            self.costs.extend((0..n).map(|cell| search.cost(number([-du, -dv], cell))));
            self.least.push(self.costs[first..].iter().copied().min().unwrap_or(UNREACHED));
        }
    }

    fn add_slopes(&mut self, class: u32) {
        for side in 0..4 {
            let at = |far: i32, beside: i32| {
                let far = if side % 2 == 1 { -far } else { far };
                let way = if side < 2 { [far, beside] } else { [beside, far] };
                frames(self.least[class as usize * NUM_OFFSETS + offset(way) as usize])
            };
            // Every other place on the rim lies on a line from the middle through one on the inner ring.
            let even = |beside: i32| (at(RADIUS, beside) - at(INNER, beside / 2)) / (RADIUS - INNER) as f32;
            let slope = |beside: i32| match beside % 2 {
                0 => even(beside),
                _ => 0.5 * (even(beside - 1) + even(beside + 1)),
            };
            let row: Vec<f32> = (-RADIUS..=RADIUS).map(slope).map(|s| if s > 0.0 { s } else { 0.0 }).collect();
            self.slopes.extend(row);
        }
    }
}

/// The offsets of a table, in their order. [Unit: copies]
pub(super) fn offsets() -> impl Iterator<Item = [i32; 2]> {
    (0..SIDE * SIDE).map(|n| [n / SIDE - RADIUS, n % SIDE - RADIUS])
}

/// Number of an offset within the table.
fn offset([du, dv]: [i32; 2]) -> u32 {
    ((du + RADIUS) * SIDE + dv + RADIUS) as u32
}

fn frames(cost: u16) -> f32 {
    if cost == UNREACHED { f32::INFINITY } else { f32::from(cost) }
}

/// Steps as whole multiples of two of them; none where they all lie on a line, or are no such multiples.
fn lattice(steps: &[Vec3]) -> Option<Vec<[i32; 2]>> {
    let u = *steps.first()?;
    let v = *steps.iter().find(|s| s.cross(u).length() > 1e-3 * u.length_squared())?;
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let area = uu * vv - uv * uv;
    let multiple = |s: &Vec3| {
        let (su, sv) = (s.dot(u), s.dot(v));
        let at = [(su * vv - sv * uv) / area, (sv * uu - su * uv) / area].map(f32::round);
        let there = u * at[0] + v * at[1];
        (there.distance(*s) <= 1e-2 * u.length() && at.iter().all(|a| a.abs() <= 2.0)).then_some(at.map(|a| a as i32))
    };
    steps.iter().map(multiple).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::{EdgeRecord, KIND_TILE, LinkRecord, PatchRecord, Placement};
    use proptest::prelude::*;
    use std::collections::{BTreeMap, BTreeSet};

    /// A tile with an entry and an exit an edge (cells 0 to 3 and 4 to 7) and two cells inside, and its links.
    struct Tile {
        patch: PatchRecord,
        edges: Vec<EdgeRecord>,
        cells: Vec<CellRecord>,
        links: Vec<LinkRecord>,
    }

    const STEPS: [[i32; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

    impl Tile {
        fn new(links: &[(u32, u32, u16)]) -> Self {
            let cell = |edge, twin, flags| CellRecord {
                placement: Placement::IDENTITY,
                group: 0,
                edge,
                twin,
                flags,
                first_link: 0,
                num_links: 0,
                reserved: [0; 2],
            };
            let mut cells: Vec<_> = (0..4).map(|e| cell(e, 4 + (e ^ 1), CellRecord::IS_ENTRY)).collect();
            cells.extend((0..4).map(|e| cell(e, e ^ 1, CellRecord::IS_EXIT)));
            cells.extend([cell(NONE, NONE, 0); 2]);
            let link = |&(from, to, num_frames): &(u32, u32, u16)| LinkRecord {
                from,
                to,
                frame: 0,
                num_frames,
                tag: 0,
                start: Placement::IDENTITY,
                end: Placement::IDENTITY,
            };
            let edge = |e: usize| EdgeRecord {
                step: [2.0 * STEPS[e][0] as f32, 0.0, 2.0 * STEPS[e][1] as f32],
                opposite: e as u32 ^ 1,
            };
            let patch = PatchRecord {
                kind: KIND_TILE,
                first_cell: 0,
                num_cells: 10,
                first_link: 0,
                num_links: links.len() as u32,
                first_edge: 0,
                num_edges: 4,
                reserved: 0,
                min: [-1.0; 3],
                max: [1.0; 3],
            };
            Self { patch, edges: (0..4).map(edge).collect(), cells, links: links.iter().map(link).collect() }
        }

        fn plane(&self) -> Option<Plane> {
            let patches = Patches {
                patches: std::slice::from_ref(&self.patch),
                edges: &self.edges,
                cells: &self.cells,
                links: &self.links,
            };
            Plane::new(&patches, 0)
        }

        /// Least frames from a cell to all others, on a wide plane.
        fn dijkstra(&self, from: u32) -> BTreeMap<([i32; 2], u32), u32> {
            let (mut queue, mut found) = (BTreeSet::from([(0, ([0, 0], from))]), BTreeMap::new());
            while let Some((frames, (at, cell))) = queue.pop_first() {
                if at.iter().any(|a: &i32| a.abs() > 8) || found.contains_key(&(at, cell)) {
                    continue;
                }
                found.insert((at, cell), frames);
                for l in self.links.iter().filter(|l| l.from == cell) {
                    let to = &self.cells[l.to as usize];
                    let next = match to.edge {
                        NONE => (at, l.to),
                        e => ([at[0] + STEPS[e as usize][0], at[1] + STEPS[e as usize][1]], to.twin),
                    };
                    queue.insert((frames + u32::from(l.num_frames), next));
                }
            }
            found
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn costs_are_those_of_plain_dijkstra(links in proptest::collection::vec((0usize..6, 0u32..6, 20u16..60), 8..24)) {
            // From entries and the inside, to exits and the inside.
            let links: Vec<_> = links.iter().map(|&(f, t, n)| ([0, 1, 2, 3, 8, 9][f], 4 + t, n)).collect();
            let tile = Tile::new(&links);
            let plane = tile.plane().unwrap();
            for from in [0, 1, 2, 3, 8, 9] {
                let found = tile.dijkstra(from);
                for way in offsets().filter(|o| o[0].abs().max(o[1].abs()) <= 2) {
                    for c in 0..5 {
                        let ends = |cell: u32| cell < 4 && cell == c || cell >= 8 && c == 4;
                        let costs = found.iter().filter(|((at, cell), _)| *at == way && ends(*cell)).map(|(_, f)| *f);
                        let best = costs.min().map_or(f32::INFINITY, |f| f as f32);
                        prop_assert_eq!(plane.cost(plane.look(c, way), from), best, "{} to {} {:?}", from, c, way);
                    }
                }
            }
        }
    }

    #[test]
    fn far_ways_go_on_as_near_ones_do() {
        // Straight on in 50 frames, around a corner in 40.
        let mut links = Vec::new();
        for from in 0..4u32 {
            for to in (0..4u32).filter(|&to| to != from) {
                links.push((from, 4 + to, if to == from ^ 1 { 50 } else { 40 }));
            }
        }
        let tile = Tile::new(&links);
        let plane = tile.plane().unwrap();
        // Cell 1 was entered from -x and goes on to +x.
        assert_eq!(plane.cost(plane.look(1, [30, 0]), 1), 30.0 * 50.0);
        // All the way in zigzag.
        let cost = plane.least(plane.look(1, [20, 20]));
        assert!((cost - 40.0 * 40.0).abs() <= 50.0, "{cost}");
        // Nothing is faster a metre than straight on; a tile is 2 m long.
        assert!((plane.pace - 25.0).abs() < 1.0, "{}", plane.pace);
    }

    #[test]
    fn tiles_in_a_line_fill_no_plane() {
        assert!(lattice(&[Vec3::X, -Vec3::X]).is_none());
        assert_eq!(lattice(&[Vec3::X, Vec3::new(-1.0, 0.0, 0.5)]), Some(vec![[1, 0], [0, 1]]));
        assert!(lattice(&[Vec3::X, Vec3::Z, Vec3::new(0.5, 0.0, 0.0)]).is_none());
    }
}
