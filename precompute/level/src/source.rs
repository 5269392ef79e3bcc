//! Sources of levels, and what the names in them mark.

use glam::{Vec2, Vec3, Vec3Swizzles};
use serde_json::Value;
use std::path::Path;
use throng_base::error::ensure;
use throng_base::file::{MAX_MOTION_BYTES, read_file};
use throng_crowd::Obstacle;
use throng_geometry::polygon_contains;
use throng_motion::import::gltf::TriangleScene;
use throng_motion::import::{gltf, obj};

/// Height of what stands on a plan (m).
const WALL_M: f32 = 3.0;
/// Ground around obstacles of a plan (m).
const AROUND_M: f32 = 5.0;
/// Corners of a round obstacle.
const ROUND: usize = 16;
/// Thickness of a wall that has none (m).
const THIN_M: f32 = 0.01;
/// Areas that are flatter than this are ground themselves, others are volumes around it (m).
const FLAT_M: f32 = 0.2;

/// Kinds of places and of links; of the latter, those that lead both ways come first. Files hold names, and readers
/// take any. `add_links` lays and prices links.
const PLACES: [&str; 4] = ["goal", "door", "queue", "seat"];
const LINKS: [&str; 5] = ["ladder", "climb", "elevator", "jump", "escalator"];
const TWO_WAY: usize = 3;

/// Geometry that a level is made of.
#[derive(Clone, Debug, Default)]
pub struct LevelSource {
    /// Triangles of ground and of what stands there (m).
    pub triangles: Vec<[Vec3; 3]>,
    /// Where nobody goes (m).
    pub closed: Vec<[Vec3; 3]>,
    /// Named areas.
    pub areas: Vec<MarkedArea>,
    /// Links.
    pub links: Vec<MarkedLink>,
    /// Rings of a plan, whose ground is inside of an odd number of them, and outside of all solids (m).
    pub rings: Vec<Vec<Vec2>>,
    /// Rings of what stands on a plan (m).
    pub solids: Vec<Vec<Vec2>>,
}

/// Named area of ground.
#[derive(Clone, Debug)]
pub struct MarkedArea {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Triangles on the ground or around it (m).
    pub triangles: Vec<[Vec3; 3]>,
}

/// Link between two points.
#[derive(Clone, Debug)]
pub struct MarkedLink {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: &'static str,
    /// Start and end (m).
    pub ends: [Vec3; 2],
}

impl MarkedLink {
    /// True for a link that leads back, too.
    pub fn is_two_way(&self) -> bool {
        LINKS[..TWO_WAY].contains(&self.kind)
    }
}

/// Meaning of a name.
enum Mark {
    Place(&'static str),
    Link(&'static str),
    Closed,
}

/// Mark of a text such as `goal:platform 2` or `no-go`, and the name that it gives.
fn read_mark(text: &str) -> Option<(Mark, &str)> {
    let (word, name) = text.split_once(':').unwrap_or((text, text));
    let (word, name) = (word.trim().to_lowercase().replace('_', "-"), name.trim());
    let place = PLACES.into_iter().find(|kind| *kind == word).map(Mark::Place);
    let link = LINKS.into_iter().find(|kind| *kind == word).map(Mark::Link);
    place.or(link).or((word == "no-go").then_some(Mark::Closed)).map(|mark| (mark, name))
}

impl LevelSource {
    /// Reads a mesh (`.obj`, `.gltf`, `.glb`) or a plan (`.geojson`, `.json`).
    ///
    /// # Errors
    /// The file, the fault in it, and the way out.
    pub fn read(path: &Path) -> Result<Self, String> {
        let is = |e: &str| path.extension().is_some_and(|x| x.eq_ignore_ascii_case(e));
        let fail = |why: String| format!("{}: {why}", path.display());
        if is("gltf") || is("glb") {
            return Self::from_scene(gltf::scene(path).map_err(|e| e.to_string())?).map_err(fail);
        }
        let is_plan = is("geojson") || is("json");
        if !is_plan && !is("obj") {
            return Err(fail(
                "expected a mesh (.obj, .gltf, .glb), a plan (.geojson) or a scene (.toml); export it as one of them"
                    .into(),
            ));
        }
        let bytes = read_file(path, "a level", MAX_MOTION_BYTES).map_err(|e| e.to_string())?;
        if is_plan {
            let plan = serde_json::from_slice(&bytes).map_err(|e| fail(format!("{e}; expected GeoJSON")))?;
            return Self::from_geojson(&plan).map_err(fail);
        }
        let scene = obj::scene(&String::from_utf8_lossy(&bytes));
        let scene = scene.map_err(|(line, why)| format!("{}:{line}: {why}", path.display()))?;
        Self::from_scene(scene).map_err(fail)
    }

    /// Sorts the parts of a scene by what the names of nodes and materials mark.
    fn from_scene(scene: TriangleScene) -> Result<Self, String> {
        let TriangleScene { triangles, parts, nodes } = scene;
        let mut out = Self::default();
        out.triangles.extend(&triangles[..parts.first().map_or(triangles.len(), |p| p.first)]);
        for (i, part) in parts.iter().enumerate() {
            let own = &triangles[part.first..parts.get(i + 1).map_or(triangles.len(), |p| p.first)];
            // A node's mark holds for those below it.
            let above = |n: &usize| nodes[*n].parent;
            let line = nodes.get(part.node).map(|_| part.node);
            let names = std::iter::successors(line, above).map(|n| nodes[n].name.as_str());
            match std::iter::once(part.material.as_str()).chain(names).find_map(read_mark) {
                Some((Mark::Place(kind), name)) => out.add_area(name, kind, own),
                Some((Mark::Closed, _)) => out.closed.extend(own),
                Some((Mark::Link(_), _)) | None => out.triangles.extend(own),
            }
        }
        for (n, node) in nodes.iter().enumerate() {
            if let Some((Mark::Link(kind), name)) = read_mark(&node.name) {
                let end = nodes.iter().find(|other| other.parent == Some(n));
                let end = end.ok_or_else(|| {
                    format!("node \"{}\": a link ends at its child: add an empty node below it", node.name)
                })?;
                out.links.push(MarkedLink { name: name.into(), kind, ends: [node.at, end.at] });
            }
        }
        Ok(out)
    }

    fn add_area(&mut self, name: &str, kind: &'static str, triangles: &[[Vec3; 3]]) {
        let heights = || triangles.iter().flatten().map(|c| c.y);
        let [low, high] = [heights().fold(f32::INFINITY, f32::min), heights().fold(f32::NEG_INFINITY, f32::max)];
        if high - low < FLAT_M {
            self.triangles.extend(triangles);
        }
        match self.areas.iter_mut().find(|a| a.name == name && a.kind == kind) {
            Some(area) => area.triangles.extend(triangles),
            None => self.areas.push(MarkedArea { name: name.into(), kind, triangles: triangles.to_vec() }),
        }
    }

    /// Ground of the polygons of a GeoJSON text, in metres (x and z): lines are walls; polygons with a property `throng`, such as
    /// `goal:exit`, are areas, which have to be convex.
    fn from_geojson(plan: &Value) -> Result<Self, String> {
        let mut out = Self::default();
        let one = [plan.clone()];
        let features = plan["features"].as_array().map_or(&one[..], Vec::as_slice);
        for (n, feature) in features.iter().enumerate() {
            let geometry = if feature["geometry"].is_object() { &feature["geometry"] } else { feature };
            let fail = |why: &str| format!("features[{n}]: {why}");
            let ring = |value: &Value| -> Result<Vec<Vec2>, String> {
                let points = value.as_array().ok_or_else(|| fail("expected a list of points"))?;
                let point = |p: &Value| Some(Vec2::new(p[0].as_f64()? as f32, p[1].as_f64()? as f32));
                let points: Option<Vec<Vec2>> =
                    points.iter().map(|p| point(p).filter(|p| p.abs().max_element() < 1e5)).collect();
                points.filter(|p| p.len() > 1).ok_or_else(|| fail("expected points of two numbers in metres"))
            };
            let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
            let coordinates = &geometry["coordinates"];
            let polygons = match geometry["type"].as_str() {
                Some("Polygon") => vec![list(coordinates)],
                Some("MultiPolygon") => list(coordinates).iter().map(list).collect(),
                Some("LineString") => {
                    let line = ring(coordinates)?;
                    out.solids.extend(line.windows(2).map(|w| capsule_ring(w[0], w[1], THIN_M)));
                    continue;
                }
                _ => return Err(fail("expected a Polygon, a MultiPolygon or a LineString")),
            };
            let mark = feature["properties"]["throng"].as_str().and_then(read_mark);
            for ring_of in polygons.iter().flatten() {
                let mut corners = ring(ring_of)?;
                if corners.first() == corners.last() {
                    corners.pop();
                }
                ensure(corners.len() >= 3, || fail("expected three corners at least"))?;
                let fan = || -> Vec<[Vec3; 3]> {
                    let at = |p: Vec2| Vec3::new(p.x, 0.0, p.y);
                    (2..corners.len()).map(|k| [at(corners[0]), at(corners[k - 1]), at(corners[k])]).collect()
                };
                match mark {
                    Some((Mark::Place(kind), name)) => {
                        out.areas.push(MarkedArea { name: name.into(), kind, triangles: fan() });
                    }
                    Some((Mark::Closed, _)) => out.closed.extend(fan()),
                    _ => out.rings.push(corners),
                }
            }
        }
        ensure(!out.rings.is_empty(), || "expected a polygon of ground, found none".to_owned())?;
        out.raise();
        Ok(out)
    }

    /// Ground around obstacles, as a scene has them; those that move are left out.
    pub fn around(obstacles: &[Obstacle<Vec2>]) -> Self {
        let mut out = Self::default();
        for obstacle in obstacles {
            let ring = match obstacle {
                Obstacle::Ball { centre, radius } => capsule_ring(*centre, *centre, *radius),
                Obstacle::Wall { from, to, radius } => capsule_ring(*from, *to, radius.max(THIN_M)),
                Obstacle::Polygon { corners } => corners.clone(),
                Obstacle::Box { min, max } => vec![*min, Vec2::new(max.x, min.y), *max, Vec2::new(min.x, max.y)],
                _ => continue,
            };
            out.solids.push(ring);
        }
        let around = bounds_of(out.solids.iter().flatten());
        let [low, high] =
            around.map_or([Vec2::splat(-10.0), Vec2::splat(10.0)], |[low, high]| [low - AROUND_M, high + AROUND_M]);
        out.rings.push(vec![low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)]);
        out.raise();
        out
    }

    /// Lays a floor under the rings, and makes them walls.
    fn raise(&mut self) {
        let Some([low, high]) = bounds_of(self.rings.iter().flatten()) else { return };
        let floor = |x, z| Vec3::new(x, 0.0, z);
        let corners = [floor(low.x, low.y), floor(low.x, high.y), floor(high.x, high.y), floor(high.x, low.y)];
        self.triangles.extend([[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]);
        for ring in self.rings.iter().chain(&self.solids) {
            for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [a, b] = [a, b].map(|p| Vec3::new(p.x, -0.1, p.y));
                let up = Vec3::Y * WALL_M;
                self.triangles.extend([[a, b, b + up], [a, b + up, a + up]]);
            }
        }
    }

    /// True for a point of the ground of a plan; everywhere in a mesh.
    pub(crate) fn is_inside(&self, at: Vec3) -> bool {
        let holds = |ring: &&Vec<Vec2>| polygon_contains(ring.iter().copied(), at.xz());
        let is_ground = self.rings.is_empty() || self.rings.iter().filter(holds).count() % 2 == 1;
        is_ground && !self.solids.iter().any(|ring| holds(&ring))
    }
}

fn bounds_of<'a>(points: impl Iterator<Item = &'a Vec2>) -> Option<[Vec2; 2]> {
    points.fold(None, |all, &p| Some(all.map_or([p, p], |[low, high]: [Vec2; 2]| [low.min(p), high.max(p)])))
}

/// Ring around a capsule; a circle where its ends are one.
fn capsule_ring(from: Vec2, to: Vec2, radius: f32) -> Vec<Vec2> {
    let along = (to - from).try_normalize().unwrap_or(Vec2::X);
    let point = |k: usize| {
        let angle = std::f32::consts::TAU * (k as f32 + 0.5) / ROUND as f32;
        let off = along.rotate(Vec2::new(angle.cos(), angle.sin())) * radius;
        if angle.cos() > 0.0 { to + off } else { from + off }
    };
    (0..ROUND).map(point).collect()
}
