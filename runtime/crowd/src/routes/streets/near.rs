//! Search for outlines near a straight line: their edges, in a grid.

use crate::routes::outline::ObstacleOutline;
use glam::Vec2;
use throng_geometry::segment_distance_2d;

/// Most rows and columns.
const MOST_SIDE: usize = 128;
/// Fewer edges than that share one cell.
const FEW: usize = 16;
/// Tolerance of rounding, as a share of the largest coordinate: cells are searched this much farther.
const SLACK: f32 = 1e-5;

/// Edges of outlines, by where they are.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeGrid {
    all: Vec<OutlineEdge>,
    low: Vec2,
    /// Size of a cell (m).
    cell: Vec2,
    /// Rows, and as many columns.
    side: usize,
    /// Largest coordinate of an edge (m).
    farthest: f32,
    /// Edges that reach into each cell.
    edges: CellLists,
    /// Polygons that may hold a place in each cell.
    polygons: CellLists,
}

#[derive(Clone, Debug)]
struct OutlineEdge {
    ends: [Vec2; 2],
    /// (m)
    radius: f32,
    outline: u32,
}

/// A list of numbers for each cell, one after the other.
#[derive(Clone, Debug, Default)]
struct CellLists {
    /// (cells + 1)
    first: Vec<u32>,
    numbers: Vec<u32>,
}

impl CellLists {
    fn new(mut pairs: Vec<(u32, u32)>, cells: usize) -> Self {
        pairs.sort_unstable();
        let first = (0..=cells).map(|c| pairs.partition_point(|p| (p.0 as usize) < c) as u32).collect();
        Self { first, numbers: pairs.into_iter().map(|p| p.1).collect() }
    }

    fn list_of(&self, cell: usize) -> &[u32] {
        &self.numbers[self.first[cell] as usize..self.first[cell + 1] as usize]
    }
}

impl EdgeGrid {
    /// - `bounds`: of each outline.
    pub fn new(outlines: &[ObstacleOutline], bounds: &[(Vec2, Vec2)]) -> Self {
        let mut all = Vec::new();
        for (outline, o) in (0..).zip(outlines) {
            all.extend(o.edges().map(|(ends, radius)| OutlineEdge { ends, radius, outline }));
        }
        let side = if all.len() <= FEW { 1 } else { (all.len() as f32).sqrt().ceil() as usize }.min(MOST_SIDE);
        let (low, high) = bounds.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        let (low, high) = if all.is_empty() { (Vec2::ZERO, Vec2::ZERO) } else { (low, high) };
        let cell = ((high - low) / side as f32).max(Vec2::splat(1e-3));
        let farthest = low.abs().max(high.abs()).max_element();
        let mut edges = Self { low, cell, side, farthest, ..Self::default() };
        let mut pairs = Vec::new();
        for (n, edge) in (0..).zip(&all) {
            edges.cells_along(edge.ends, edge.radius, |cell| {
                pairs.push((cell as u32, n));
                true
            });
        }
        edges.edges = CellLists::new(std::mem::take(&mut pairs), side * side);
        let is_polygon = |n: u32| matches!(outlines[n as usize], ObstacleOutline::Polygon(_));
        for (n, (low, high)) in (0..).zip(bounds).filter(|(n, _)| is_polygon(*n)) {
            let [from, to] = [edges.cell_at(*low), edges.cell_at(*high)];
            let cells = (from[1]..=to[1]).flat_map(|row| (from[0]..=to[0]).map(move |c| row * side + c));
            pairs.extend(cells.map(|cell| (cell as u32, n)));
        }
        edges.polygons = CellLists::new(pairs, side * side);
        edges.all = all;
        edges
    }

    /// Calls `found` for outlines that are nearer to a straight line than a clearance, some more than once, until it returns
    /// false; false then.
    pub fn find_near(
        &self,
        outlines: &[ObstacleOutline],
        [a, b]: [Vec2; 2],
        clearance: f32,
        mut found: impl FnMut(usize) -> bool,
    ) -> bool {
        if self.all.is_empty() {
            return true;
        }
        let [column, row] = self.cell_at(a);
        let mut around = self.polygons.list_of(row * self.side + column).iter().map(|&n| n as usize);
        if !around.all(|n| clearance <= 0.0 || !outlines[n].contains_point(a) || found(n)) {
            return false;
        }
        self.cells_along([a, b], clearance, |cell| {
            self.edges.list_of(cell).iter().all(|&n| {
                let OutlineEdge { ends, radius, outline } = &self.all[n as usize];
                let (low, high) = (a.min(b) - clearance - *radius, a.max(b) + clearance + *radius);
                let is_far = ends[0].max(ends[1]).cmplt(low).any() || ends[0].min(ends[1]).cmpgt(high).any();
                is_far
                    || (segment_distance_2d([a, b], *ends) - radius).max(0.0) >= clearance
                    || found(*outline as usize)
            })
        })
    }

    /// Calls `visit` for all edges that may be nearer to a place than a distance, with their radii (m) and outlines; for some more
    /// than once.
    pub fn visit_near(&self, at: Vec2, within: f32, mut visit: impl FnMut([Vec2; 2], f32, usize)) {
        if !self.all.is_empty() {
            self.cells_along([at, at], within, |cell| {
                let edges = self.edges.list_of(cell).iter().map(|&n| &self.all[n as usize]);
                edges.for_each(|edge| visit(edge.ends, edge.radius, edge.outline as usize));
                true
            });
        }
    }

    /// Column and row of a place, the nearest ones outside.
    fn cell_at(&self, at: Vec2) -> [usize; 2] {
        ((at - self.low) / self.cell).to_array().map(|v| (v as usize).min(self.side - 1))
    }

    /// Calls `visit` for all cells that a line comes into, be it with a radius, until it returns false; false then.
    fn cells_along(&self, [a, b]: [Vec2; 2], radius: f32, mut visit: impl FnMut(usize) -> bool) -> bool {
        if self.side == 1 {
            return visit(0);
        }
        let (low, high) = (a.min(b), a.max(b));
        let reach = radius + SLACK * self.farthest.max(low.abs().max(high.abs()).max_element());
        let (first, last) = (self.cell_at(low - reach), self.cell_at(high + reach));
        for column in first[0]..=last[0] {
            // The part of the line within reach of the column; the outermost ones have no end.
            let left = if column == 0 { f32::NEG_INFINITY } else { self.low.x + self.cell.x * column as f32 - reach };
            let right = self.low.x + self.cell.x * (column + 1) as f32 + reach;
            let right = if column + 1 == self.side { f32::INFINITY } else { right };
            let height = |x: f32| {
                let share = (x - a.x) / (b.x - a.x);
                a.y + (b.y - a.y) * if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }
            };
            let is_steep = high.x - low.x < 1e-6 * self.farthest.max(1.0);
            let [one, other] = if is_steep { [low.y, high.y] } else { [height(left), height(right)] };
            let rows = |y: f32| self.cell_at(Vec2::new(self.low.x, y))[1];
            for row in rows(one.min(other) - reach)..=rows(one.max(other) + reach) {
                if !visit(row * self.side + column) {
                    return false;
                }
            }
        }
        true
    }
}
