//! Tables of a level, of the convex parts of its ground.

use crate::ground::{GroundPolygons, find_ground};
use crate::{LevelSettings, LevelSource, MarkedArea};
use glam::{Vec2, Vec3, Vec3Swizzles};
use std::collections::{HashMap, HashSet};
use throng_level::{
    Level, LevelData, LevelEdge, LevelHead, LevelLink, LevelPath, LevelPlace, LevelPolygon, LevelVertex, LevelWall,
    NONE,
};

/// Distance of a link's end from the ground (m).
const LINK_NEAR_M: f32 = 1.5;
/// Parts of the ground that are smaller than this, such as the top of a cupboard, are left out (m^2).
const SMALLEST_PART_M2: f32 = 2.0;
/// Metres of a walk that cost as much as a link, and that each metre of height adds to it.
const LINK_COST_M: f32 = 2.0;
const LINK_COST_UP: f32 = 3.0;
/// A triangle belongs to a floor if it is within this share of the free height of it.
const FLOOR_SHARE: f32 = 0.75;
/// Angle by which walls have to turn for a corner: so little that a ray along a longer wall ends at its vertices (rad).
const CORNER: f32 = 5e-6;

/// Makes a level; warnings go to `warn`.
///
/// # Errors
/// Fault of the source, and the way out.
pub fn bake(source: &LevelSource, settings: &LevelSettings, warn: &mut Vec<String>) -> Result<LevelData, String> {
    if source.areas.len() > 200 {
        return Err(format!("expected at most 200 named areas, found {}", source.areas.len()));
    }
    let mut ground = find_ground(source, settings, settings.radius_m)?;
    keep_parts(&mut ground, |part, ground| {
        let area: f32 = part.iter().map(|&p| 0.5 * ground.double_area(p)).sum();
        let is_marked = part.iter().any(|&p| ground.areas[p].is_some());
        (area >= SMALLEST_PART_M2 || is_marked) && source.is_inside(ground.centre(part[0]))
    });
    if ground.polygons.is_empty() {
        return Err(format!(
            "nowhere can somebody of radius {} m and height {} m stand; give smaller ones, or check its unit",
            settings.radius_m, settings.height_m
        ));
    }
    let mut data = LevelData::default();
    add_polygons(&mut data, &ground, source, settings);
    add_grid(&mut data, &ground, settings);
    add_walls(&mut data, source, settings)?;
    add_places(&mut data, &ground, &source.areas, warn);
    let level = Level::from_data(&data).map_err(|e| e.to_string())?;
    add_links(&mut data, &level, source, warn);
    Ok(data)
}

/// Components of polygons that share edges: the number of each polygon's.
fn components(ground: &GroundPolygons) -> (Vec<u32>, usize) {
    let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
    let ring = |p: usize| {
        let own = &ground.polygons[p];
        (0..own.len()).map(move |k| [own[k], own[(k + 1) % own.len()]])
    };
    for p in 0..ground.polygons.len() {
        edges.extend(ring(p).map(|edge| (edge, p)));
    }
    let (mut of, mut num) = (vec![NONE; ground.polygons.len()], 0);
    for first in 0..of.len() {
        if of[first] != NONE {
            continue;
        }
        let mut open = vec![first];
        of[first] = num;
        while let Some(p) = open.pop() {
            for [a, b] in ring(p) {
                if let Some(&next) = edges.get(&[b, a]).filter(|&&next| of[next] == NONE) {
                    of[next] = num;
                    open.push(next);
                }
            }
        }
        num += 1;
    }
    (of, num as usize)
}

/// Keeps the connected parts of the ground that a condition holds for.
fn keep_parts(ground: &mut GroundPolygons, keeps: impl Fn(&[usize], &GroundPolygons) -> bool) {
    let (of, num) = components(ground);
    let mut parts = vec![Vec::new(); num];
    of.iter().enumerate().for_each(|(p, &part)| parts[part as usize].push(p));
    let kept: HashSet<usize> = parts.into_iter().filter(|part| keeps(part, ground)).flatten().collect();
    let mut numbers = HashMap::new();
    let mut out = GroundPolygons::default();
    for p in (0..of.len()).filter(|p| kept.contains(p)) {
        let own = ground.polygons[p].iter().map(|&v| {
            *numbers.entry(v).or_insert_with(|| {
                out.vertices.push(ground.vertices[v as usize]);
                out.vertices.len() as u32 - 1
            })
        });
        out.polygons.push(own.collect());
        out.areas.push(ground.areas[p]);
    }
    *ground = out;
}

fn add_polygons(data: &mut LevelData, ground: &GroundPolygons, source: &LevelSource, settings: &LevelSettings) {
    let (components, _) = components(ground);
    let mut number: HashMap<[u32; 2], u32> = HashMap::new();
    for (p, own) in ground.polygons.iter().enumerate() {
        let first_edge = data.edges.len() as u32;
        for k in 0..own.len() {
            let [a, b] = [own[k], own[(k + 1) % own.len()]];
            number.entry([a, b]).or_insert(first_edge + k as u32);
            data.edges.push(LevelEdge { vertex: a, neighbour: NONE, twin: NONE });
        }
        data.polygons.push(LevelPolygon {
            first_edge,
            num_edges: own.len() as u32,
            component: components[p],
            place: ground.areas[p].map_or(NONE, |a| a as u32),
            ..LevelPolygon::default()
        });
    }
    let owner: Vec<u32> =
        data.polygons.iter().zip(0..).flat_map(|(p, n)| std::iter::repeat_n(n, p.num_edges as usize)).collect();
    for (&[a, b], &edge) in &number {
        if let Some(&twin) = number.get(&[b, a]) {
            let one = &mut data.edges[edge as usize];
            (one.twin, one.neighbour) = (twin, owner[twin as usize]);
        }
    }
    // Shortest paths bend at corners of walls that stick out: where the ground around a vertex has more than half a turn.
    let mut turns = vec![0.0f32; ground.vertices.len()];
    let mut borders = vec![0u32; ground.vertices.len()];
    for p in &mut data.polygons {
        let own = &data.edges[p.first_edge as usize..][..p.num_edges as usize];
        p.num_open = own.iter().filter(|e| e.neighbour != NONE).count() as u32;
        let at = |k: usize| ground.vertices[own[k % own.len()].vertex as usize].xz();
        for k in 0..own.len() {
            let [before, here, next] = [at(k + own.len() - 1), at(k), at(k + 1)];
            turns[own[k].vertex as usize] += (next - here).angle_to(before - here).abs();
            if own[k].neighbour == NONE {
                borders[own[k].vertex as usize] += 1;
            }
        }
    }
    data.vertices = (0..ground.vertices.len())
        .map(|v| LevelVertex {
            at: ground.vertices[v].to_array(),
            is_corner: u32::from(borders[v] > 1 || borders[v] > 0 && turns[v] > std::f32::consts::PI + CORNER),
        })
        .collect();
    add_heights(data, ground, source, settings);
}

/// Gives polygons the triangles of the mesh that they lie on, the highest first, and vertices their heights.
fn add_heights(data: &mut LevelData, ground: &GroundPolygons, source: &LevelSource, settings: &LevelSettings) {
    let steepest = settings.slope_deg.to_radians().cos();
    let is_ground = |t: &&[Vec3; 3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero().y > steepest;
    let triangles: Vec<[Vec3; 3]> = source.triangles.iter().filter(is_ground).copied().collect();
    let boxes: Vec<[Vec2; 2]> = triangles.iter().map(|t| bounds(t.iter().map(|c| c.xz()))).collect();
    let grid = Squares::new(&boxes, 2.0);
    for p in 0..ground.polygons.len() {
        let (flat, centre) = (ground.flat(p), ground.centre(p));
        let [low, high] = bounds(flat.iter().copied());
        let mut own: Vec<(bool, f32, u32)> = Vec::new();
        let mut seen = HashSet::new();
        for &t in grid.between(low, high).iter().filter(|&&t| seen.insert(t)) {
            let clipped = clip(triangles[t as usize].map(|c| c.xz()), &flat);
            if clipped.is_empty() {
                continue;
            }
            let middle = clipped.iter().sum::<Vec2>() / clipped.len() as f32;
            let up = height_on(&triangles[t as usize], middle) - ground_height(ground, p, middle, centre.y);
            if up.abs() < FLOOR_SHARE * settings.height_m {
                own.push((up.abs() > settings.climb_m.max(0.2), -height_on(&triangles[t as usize], middle), t));
            }
        }
        own.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let first = data.triangles.len();
        data.triangles.extend(own.iter().map(|&(.., t)| triangles[t as usize].map(|c| c.to_array())));
        if own.is_empty() {
            let corners: Vec<[f32; 3]> =
                ground.polygons[p].iter().map(|&v| ground.vertices[v as usize].to_array()).collect();
            data.triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
        }
        let polygon = &mut data.polygons[p];
        (polygon.first_triangle, polygon.num_triangles) = (first as u32, (data.triangles.len() - first) as u32);
        for &v in &ground.polygons[p] {
            let at = ground.vertices[v as usize];
            let on = own.iter().map(|&(.., t)| &triangles[t as usize]).find(|t| holds(t, at.xz()));
            if let Some(triangle) = on {
                data.vertices[v as usize].at[1] = height_on(triangle, at.xz());
            }
        }
    }
}

/// Height of the plane of a polygon's nearest three corners (m).
fn ground_height(ground: &GroundPolygons, polygon: usize, p: Vec2, otherwise: f32) -> f32 {
    let own: Vec<Vec3> = ground.polygons[polygon].iter().map(|&v| ground.vertices[v as usize]).collect();
    let fan = (2..own.len()).map(|k| [own[0], own[k - 1], own[k]]);
    fan.clone().find(|t| holds(t, p)).map_or(otherwise, |t| height_on(&t, p))
}

fn shares(t: &[Vec3; 3], p: Vec2) -> Option<[f32; 2]> {
    let (ab, ac, ap) = ((t[1] - t[0]).xz(), (t[2] - t[0]).xz(), p - t[0].xz());
    let area = ab.perp_dot(ac);
    (area.abs() > 1e-9).then(|| [ap.perp_dot(ac) / area, ab.perp_dot(ap) / area])
}

fn holds(t: &[Vec3; 3], p: Vec2) -> bool {
    shares(t, p).is_some_and(|[v, w]| v.min(w).min(1.0 - v - w) >= -1e-4)
}

fn height_on(t: &[Vec3; 3], p: Vec2) -> f32 {
    shares(t, p).map_or(t[0].y, |[v, w]| t[0].y + v * (t[1].y - t[0].y) + w * (t[2].y - t[0].y))
}

fn bounds(points: impl Iterator<Item = Vec2>) -> [Vec2; 2] {
    points.fold([Vec2::INFINITY, Vec2::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// Part of a triangle within a convex polygon that goes round counter-clockwise (Sutherland and Hodgman 1974); none without an
/// area.
fn clip(triangle: [Vec2; 3], by: &[Vec2]) -> Vec<Vec2> {
    let mut part = triangle.to_vec();
    for (k, &a) in by.iter().enumerate() {
        let along = by[(k + 1) % by.len()] - a;
        let side = |p: Vec2| along.perp_dot(p - a);
        let before = std::mem::take(&mut part);
        for (i, &p) in before.iter().enumerate() {
            let q = before[(i + 1) % before.len()];
            let (from, to) = (side(p), side(q));
            if from >= 0.0 {
                part.push(p);
            }
            if (from < 0.0) != (to < 0.0) {
                part.push(p + (q - p) * (from / (from - to)));
            }
        }
    }
    let area: f32 = (0..part.len()).map(|i| part[i].perp_dot(part[(i + 1) % part.len()])).sum();
    if area.abs() < 1e-5 { Vec::new() } else { part }
}

/// Items by the squares that their boxes touch.
struct Squares {
    low: Vec2,
    square_m: f32,
    num: [u32; 2],
    items: Vec<Vec<u32>>,
}

impl Squares {
    fn new(boxes: &[[Vec2; 2]], least_m: f32) -> Self {
        let [low, high] = bounds(boxes.iter().flatten().copied());
        let size = (high - low).max(Vec2::ONE);
        let square_m = (size.x * size.y / boxes.len().max(1) as f32).sqrt().clamp(least_m, 50.0);
        let num = [size.x, size.y].map(|m| (m / square_m) as u32 + 1);
        let mut out = Self { low, square_m, num, items: vec![Vec::new(); (num[0] * num[1]) as usize] };
        for (i, [low, high]) in boxes.iter().enumerate() {
            out.range(*low, *high).for_each(|k| out.items[k].push(i as u32));
        }
        out
    }

    fn range(&self, low: Vec2, high: Vec2) -> impl Iterator<Item = usize> + use<> {
        let square = |p: Vec2| {
            let k = ((p - self.low) / self.square_m).floor().max(Vec2::ZERO).as_uvec2();
            [k.x.min(self.num[0] - 1), k.y.min(self.num[1] - 1)]
        };
        let (from, to, width) = (square(low - 1e-3), square(high + 1e-3), self.num[0]);
        (from[1]..=to[1]).flat_map(move |z| (from[0]..=to[0]).map(move |x| (z * width + x) as usize))
    }

    fn between(&self, low: Vec2, high: Vec2) -> Vec<u32> {
        self.range(low, high).flat_map(|k| self.items[k].iter().copied()).collect()
    }
}

fn add_grid(data: &mut LevelData, ground: &GroundPolygons, settings: &LevelSettings) {
    let boxes: Vec<[Vec2; 2]> = (0..ground.polygons.len()).map(|p| bounds(ground.flat(p).into_iter())).collect();
    let grid = Squares::new(&boxes, 1.0);
    data.head = vec![LevelHead {
        radius_m: settings.radius_m,
        height_m: settings.height_m,
        climb_m: settings.climb_m,
        slope: settings.slope_deg.to_radians(),
        low: grid.low.to_array(),
        square_m: grid.square_m,
        squares: grid.num,
    }];
    data.squares.push(0);
    for items in &grid.items {
        data.listed.extend(items);
        data.squares.push(data.listed.len() as u32);
    }
}

/// Borders of the ground for somebody without a radius, which bodies keep their own radius from.
fn add_walls(data: &mut LevelData, source: &LevelSource, settings: &LevelSettings) -> Result<(), String> {
    let mut ground = find_ground(source, settings, 0.0)?;
    keep_parts(&mut ground, |part, ground| {
        let area: f32 = part.iter().map(|&p| 0.5 * ground.double_area(p)).sum();
        area >= SMALLEST_PART_M2 && part.iter().any(|&p| source.is_inside(ground.centre(p)))
    });
    let ring =
        |own: &Vec<u32>| -> Vec<[u32; 2]> { (0..own.len()).map(|k| [own[k], own[(k + 1) % own.len()]]).collect() };
    let edges: HashSet<[u32; 2]> = ground.polygons.iter().flat_map(ring).collect();
    let walls = ground.polygons.iter().flat_map(ring).filter(|[a, b]| !edges.contains(&[*b, *a]));
    let at = |v: u32| ground.vertices[v as usize].to_array();
    data.walls = walls.map(|[a, b]| LevelWall { from: at(a), to: at(b) }).collect();
    Ok(())
}

fn add_name(data: &mut LevelData, name: &str) -> [u32; 2] {
    let from = data.names.len() as u32;
    data.names.extend(name.as_bytes());
    [from, data.names.len() as u32]
}

fn add_places(data: &mut LevelData, ground: &GroundPolygons, areas: &[MarkedArea], warn: &mut Vec<String>) {
    for (a, area) in areas.iter().enumerate() {
        let own = (0..ground.polygons.len()).filter(|&p| ground.areas[p] == Some(a));
        let largest = own.max_by(|&p, &q| ground.double_area(p).total_cmp(&ground.double_area(q)));
        let at = match largest {
            Some(p) => {
                let at = ground.centre(p);
                let triangles = &data.triangles[data.polygons[p].first_triangle as usize..];
                let triangles = triangles.iter().take(data.polygons[p].num_triangles as usize);
                let on = triangles.map(|t| t.map(Vec3::from)).find(|t| holds(t, at.xz()));
                on.map_or(at, |t| Vec3::new(at.x, height_on(&t, at.xz()), at.z))
            }
            None => {
                warn.push(format!("{} \"{}\": nobody can stand there; it counts as cut off", area.kind, area.name));
                let corners = area.triangles.iter().flatten();
                corners.sum::<Vec3>() / (3 * area.triangles.len()).max(1) as f32
            }
        };
        let [kind, name] = [area.kind, &area.name].map(|text| add_name(data, text));
        data.places.push(LevelPlace { at: at.to_array(), kind, name });
    }
}

fn add_links(data: &mut LevelData, level: &Level, source: &LevelSource, warn: &mut Vec<String>) {
    for link in &source.links {
        let ground = link.ends.map(|end| level.nearest(end, LINK_NEAR_M));
        let [Some(from), Some(to)] = ground else {
            let end = usize::from(ground[0].is_some());
            let (kind, at) = (link.kind, link.ends[end]);
            warn.push(format!(
                "{kind} \"{}\": its end at {at} is more than 1.5 m from the ground; left out",
                link.name
            ));
            continue;
        };
        let [kind, name] = [link.kind, &link.name].map(|text| add_name(data, text));
        let up = (to.at.y - from.at.y).abs();
        let cost_m = LINK_COST_M + LINK_COST_UP * up + from.at.xz().distance(to.at.xz());
        let num_directions = if link.is_two_way() { 2 } else { 1 };
        for [from, to] in [[from, to], [to, from]].into_iter().take(num_directions) {
            let (ends, polygons) = ([from, to].map(|end| end.at.to_array()), [from, to].map(|end| end.polygon));
            data.links.push(LevelLink { ends, polygons, kind, cost_m, name });
        }
    }
    let num = data.links.len();
    let mut path = LevelPath::default();
    let mut cost = vec![f32::INFINITY; num * num];
    let mut next = vec![0u32; num * num];
    for (i, a) in data.links.iter().enumerate() {
        for (j, b) in data.links.iter().enumerate() {
            next[i * num + j] = j as u32;
            if i == j {
                cost[i * num + j] = 0.0;
            } else if level.path(a.ends[1].into(), b.ends[0].into(), &mut path).is_ok() {
                cost[i * num + j] = path.length_m() as f32 + b.cost_m;
            }
        }
    }
    // Floyd (1962).
    for k in 0..num {
        for i in 0..num {
            for j in 0..num {
                let by = cost[i * num + k] + cost[k * num + j];
                if by < cost[i * num + j] {
                    (cost[i * num + j], next[i * num + j]) = (by, next[i * num + k]);
                }
            }
        }
    }
    (data.link_costs, data.link_next) = (cost, next);
}
