//! Convex parts of the ground, by `rerecast`.

use crate::{LevelSettings, LevelSource};
use glam::{UVec3, Vec2, Vec3, Vec3A, Vec3Swizzles};
use rerecast::{Aabb3d, AreaType, BuildContoursFlags, CompactHeightfield, ConvexVolume, HeightfieldBuilder};
use rerecast::{PolygonNavmesh, TriMesh};
use std::collections::HashMap;

/// Cells of a radius.
const CELLS: f32 = 3.0;
/// Most cells of a level: where it is larger, cells are (a radius may then have fewer of them).
const MOST_CELLS: f32 = 8e6;
/// Height of a cell (m).
const CELL_HEIGHT_M: f32 = 0.04;
/// Largest deviations of a border from its cells; a smaller one where the border of a larger one crosses itself (cells).
const BORDER_ERRORS: [f32; 5] = [1.1, 0.9, 0.6, 0.3, 0.0];
/// Longest border of a polygon (m).
const LONGEST_M: f32 = 12.0;
/// Most corners of a polygon.
const MOST_CORNERS: u16 = 6;
/// Largest height of a polygon's corners above its plane (m).
const FLAT_M: f32 = 0.15;
/// Height above and below an area in which ground belongs to it (m).
const AREA_M: f32 = 0.3;

/// Convex polygons of ground, which go round counter-clockwise in the plane of x and z.
#[derive(Clone, Debug, Default)]
pub(crate) struct GroundPolygons {
    /// Vertices (m).
    pub vertices: Vec<Vec3>,
    /// Vertices of each polygon.
    pub polygons: Vec<Vec<u32>>,
    /// Number of the area that each polygon is of.
    pub areas: Vec<Option<usize>>,
}

/// Finds the ground of a source.
///
/// - `radius_m`: distance that is kept from walls (m, >= 0).
pub fn find_ground(source: &LevelSource, settings: &LevelSettings, radius_m: f32) -> Result<GroundPolygons, String> {
    let corners = || source.triangles.iter().flatten();
    let low = corners().fold(Vec3::INFINITY, |low, &c| low.min(c));
    let high = corners().fold(Vec3::NEG_INFINITY, |high, &c| high.max(c));
    let size = (high - low).xz();
    if source.triangles.is_empty() || size.max_element() > 5e3 {
        return Err(format!(
            "expected ground of 5000 m at most along each side, found {} triangles over {} m x {} m; check its unit",
            source.triangles.len(),
            size.x,
            size.y
        ));
    }
    let cell_m = (settings.radius_m / CELLS).max((size.x * size.y / MOST_CELLS).sqrt());
    let low = low - Vec3::new(2.0 * cell_m, CELL_HEIGHT_M, 2.0 * cell_m);
    let aabb = Aabb3d { min: low, max: high + Vec3::new(2.0 * cell_m, settings.height_m, 2.0 * cell_m) };
    let [height, climb] = [(settings.height_m / CELL_HEIGHT_M).ceil(), settings.climb_m / CELL_HEIGHT_M];
    let (height, climb) = (height as u16, climb as u16);

    let mut mesh = TriMesh {
        vertices: corners().map(|&c| Vec3A::from(c)).collect(),
        indices: (0..source.triangles.len() as u32).map(|t| UVec3::new(3 * t, 3 * t + 1, 3 * t + 2)).collect(),
        area_types: vec![AreaType::NOT_WALKABLE; source.triangles.len()],
    };
    mesh.mark_walkable_triangles(settings.slope_deg.to_radians());
    if mesh.area_types.iter().all(|area| !area.is_walkable()) {
        return Err(format!(
            "none of {} triangles faces up with a slope of {} degrees at most; is y its axis up, and do its faces look outwards?",
            source.triangles.len(),
            settings.slope_deg
        ));
    }
    let fail = |e: &dyn std::fmt::Display| format!("its ground cannot be found: {e}; export a simpler mesh");
    let field = HeightfieldBuilder { aabb, cell_size: cell_m, cell_height: CELL_HEIGHT_M }.build();
    let mut field = field.map_err(|e| fail(&e))?;
    field.rasterize_triangles(&mesh, climb).map_err(|e| fail(&e))?;
    field.filter_low_hanging_walkable_obstacles(climb);
    field.filter_ledge_spans(height, climb);
    field.filter_walkable_low_height_spans(height);
    let mut field = field.into_compact(height, climb).map_err(|e| fail(&e))?;
    mark(&mut field, &source.closed, AreaType::NOT_WALKABLE);
    let cells = (radius_m / cell_m).ceil() as u16;
    if cells > 0 {
        field.erode_walkable_area(cells);
    }
    for (area, number) in source.areas.iter().zip(1..) {
        mark(&mut field, &area.triangles, AreaType(number));
    }
    partition(&mut field);
    let longest = (LONGEST_M / cell_m) as u16;
    let mut made = Err(String::new());
    for error in BORDER_ERRORS {
        let contours = field.build_contours(error, longest, BuildContoursFlags::default());
        made = contours.into_polygon_mesh(MOST_CORNERS).map_err(|e| fail(&e));
        if made.is_ok() {
            break;
        }
    }
    let mesh = made?;
    let mut out = polygons_of(&mesh);
    while out.merge() {}
    Ok(out)
}

/// Divides the ground into regions without holes: rows of cells that follow each other one by one (the monotone partition of
/// Recast, which `rerecast` lacks as it lacks holes of regions).
fn partition(field: &mut CompactHeightfield) {
    let mut last = 0u16;
    for z in 0..i32::from(field.height) {
        // Rows of this line: the region before it of each, and the number of its cells there.
        let mut rows: Vec<(Option<u16>, u32)> = Vec::new();
        let mut row_of: Vec<(usize, usize)> = Vec::new();
        let mut touched = HashMap::<u16, u32>::new();
        for x in 0..i32::from(field.width) {
            for i in field.cells[(x + z * i32::from(field.width)) as usize].index_range() {
                if !field.areas[i].is_walkable() {
                    continue;
                }
                let beside = |dir: u8| {
                    let con = field.spans[i].con(dir)?;
                    let other = field.con_indices(x, z, dir, con).2;
                    (field.areas[other] == field.areas[i]).then_some(other)
                };
                let left = beside(0).and_then(|other| row_of.iter().rfind(|(span, _)| *span == other));
                let row = left.map_or(rows.len(), |(_, row)| *row);
                if row == rows.len() {
                    rows.push((Some(0), 0));
                }
                row_of.push((i, row));
                if let Some(other) = beside(3) {
                    let region = field.spans[other].region.bits();
                    *touched.entry(region).or_default() += 1;
                    let (before, num) = &mut rows[row];
                    *before = before.filter(|&b| b == 0 || b == region).map(|_| region);
                    *num += 1;
                }
            }
        }
        let regions: Vec<u16> = rows
            .iter()
            .map(|(before, num)| match before {
                Some(region) if *region > 0 && touched.get(region) == Some(num) => *region,
                _ => {
                    last = last.saturating_add(1);
                    last
                }
            })
            .collect();
        row_of.iter().for_each(|&(i, row)| field.spans[i].region = regions[row].into());
    }
    field.max_region = last.into();
}

/// Marks the ground near triangles.
fn mark(field: &mut CompactHeightfield, triangles: &[[Vec3; 3]], area: AreaType) {
    for t in triangles {
        let heights = t.map(|c| c.y);
        field.mark_convex_poly_area(&ConvexVolume {
            vertices: t.map(|c| c.xz()).to_vec(),
            min_y: heights[0].min(heights[1]).min(heights[2]) - AREA_M,
            max_y: heights[0].max(heights[1]).max(heights[2]) + AREA_M,
            area,
        });
    }
}

fn polygons_of(mesh: &PolygonNavmesh) -> GroundPolygons {
    let scale = Vec3::new(mesh.cell_size, mesh.cell_height, mesh.cell_size);
    let vertices: Vec<Vec3> = mesh.vertices.iter().map(|v| mesh.aabb.min + v.as_vec3() * scale).collect();
    let mut out = GroundPolygons { vertices, ..GroundPolygons::default() };
    let most = usize::from(mesh.max_vertices_per_polygon);
    for (polygon, area) in mesh.polygons.chunks_exact(most).zip(&mesh.areas) {
        let own = polygon.iter().take_while(|v| **v != PolygonNavmesh::NO_INDEX);
        let own: Vec<u32> = own.map(|&v| v.into()).collect();
        if own.len() < 3 {
            continue;
        }
        out.polygons.push(own);
        out.areas.push(Some(usize::from(area.0)).filter(|&a| a != usize::from(u8::MAX)).map(|a| a - 1));
    }
    // All go round the same way; flat ones are no ground, and those that go round the other way are folds.
    if (0..out.polygons.len()).map(|p| out.double_area(p)).sum::<f32>() < 0.0 {
        out.polygons.iter_mut().for_each(|own| own.reverse());
    }
    let good: Vec<bool> = (0..out.polygons.len()).map(|p| out.double_area(p) > 1e-6).collect();
    let mut at = good.iter();
    out.polygons.retain(|_| at.next() == Some(&true));
    let mut at = good.iter();
    out.areas.retain(|_| at.next() == Some(&true));
    out
}

impl GroundPolygons {
    /// Merges pairs of polygons of one area that are convex together and nearly in a plane, the longest edges first; false where
    /// there are none.
    fn merge(&mut self) -> bool {
        let mut owners = HashMap::new();
        for (p, own) in self.polygons.iter().enumerate() {
            owners.extend((0..own.len()).map(|k| ([own[k], own[(k + 1) % own.len()]], p)));
        }
        let at = |v: u32| self.vertices[v as usize];
        let inner = owners.iter().filter(|([a, b], p)| owners.get(&[*b, *a]).is_some_and(|q| *p < q));
        let mut edges: Vec<(f32, [u32; 2])> =
            inner.map(|(&[a, b], _)| (at(a).distance_squared(at(b)), [a, b])).collect();
        edges.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
        let mut is_taken = vec![false; self.polygons.len()];
        let mut made = Vec::new();
        for (_, [a, b]) in edges {
            let [p, q] = [owners[&[a, b]], owners[&[b, a]]];
            if is_taken[p] || is_taken[q] || self.areas[p] != self.areas[q] {
                continue;
            }
            if let Some(ring) = self.joined([p, q], [a, b]) {
                (is_taken[p], is_taken[q]) = (true, true);
                made.push((ring, self.areas[p]));
            }
        }
        let kept = (0..is_taken.len()).filter(|p| !is_taken[*p]).map(|p| (self.polygons[p].clone(), self.areas[p]));
        let all: Vec<_> = kept.chain(made.iter().cloned()).collect();
        (self.polygons, self.areas) = all.into_iter().unzip();
        !made.is_empty()
    }

    /// Ring round two polygons that share an edge, if it is convex and nearly flat.
    fn joined(&self, [p, q]: [usize; 2], [a, b]: [u32; 2]) -> Option<Vec<u32>> {
        let from = |p: usize, v: u32| {
            let first = self.polygons[p].iter().position(|&u| u == v).unwrap_or_default();
            self.polygons[p].iter().cycle().skip(first).take(self.polygons[p].len()).copied()
        };
        // From b round to a, and on from there, without what both have.
        let second = from(q, a).skip(1).take(self.polygons[q].len() - 2);
        let mut ring: Vec<u32> = from(p, b).chain(second).collect();
        while let Some(k) = (0..ring.len()).find(|&k| ring[k] == ring[(k + 2) % ring.len()]) {
            let spike = ring[(k + 1) % ring.len()];
            ring.remove(k);
            ring.retain(|&v| v != spike);
        }
        let at = |k: usize| self.vertices[ring[k % ring.len()] as usize];
        let is_convex = |k: usize| (at(k + 1) - at(k)).xz().perp_dot((at(k + 2) - at(k + 1)).xz()) >= -1e-5;
        let own = self.polygons[p].iter().map(|&v| self.vertices[v as usize]).collect::<Vec<_>>();
        let normal: Vec3 = (2..own.len()).map(|k| (own[k - 1] - own[0]).cross(own[k] - own[0])).sum();
        let up = |v: Vec3| normal.dot(v - own[0]) / normal.y;
        let good = ring.len() > 2 && (0..ring.len()).all(|k| is_convex(k) && up(at(k)).abs() < FLAT_M);
        good.then_some(ring)
    }

    /// Mean of a polygon's corners (m).
    pub fn centre(&self, polygon: usize) -> Vec3 {
        let own = &self.polygons[polygon];
        own.iter().map(|&v| self.vertices[v as usize]).sum::<Vec3>() / own.len() as f32
    }

    /// Twice the area of a polygon (m^2).
    pub fn double_area(&self, polygon: usize) -> f32 {
        let own = &self.polygons[polygon];
        let at = |k: usize| self.vertices[own[k % own.len()] as usize].xz();
        (0..own.len()).map(|k| at(k).perp_dot(at(k + 1))).sum()
    }

    /// Corners of a polygon on the plane (m).
    pub fn flat(&self, polygon: usize) -> Vec<Vec2> {
        self.polygons[polygon].iter().map(|&v| self.vertices[v as usize].xz()).collect()
    }
}
