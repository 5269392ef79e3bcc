//! Content of a level: its ground, what is reachable from where, and how long path queries take.

use crate::picture::level_floors;
use glam::{Vec3, Vec3Swizzles};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::fmt;
use std::path::Path;
use std::time::Instant;
use throng_level::{Level, LevelPath, NamedPlace};

/// Path queries that are timed.
const QUERIES: usize = 2000;

/// Content of a level. The names of the fields are keys of the JSON report.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LevelReport {
    /// The file.
    pub file: String,
    /// Convex parts of the ground.
    pub polygons: usize,
    /// Area of the ground (m^2).
    pub area_m2: f64,
    /// Heights of the floors (m).
    pub floors_m: Vec<f32>,
    /// Areas of the parts of the ground that no walk connects, the largest first (m^2).
    pub parts_m2: Vec<f64>,
    /// Size of its tables (bytes).
    pub bytes: usize,
    /// Borders.
    pub walls: usize,
    /// Links, each direction counted.
    pub links: Vec<LevelLinkLine>,
    /// Named places.
    pub places: Vec<LevelPlaceLine>,
    /// Random paths that were found.
    pub paths: usize,
    /// Time of a path query: median, 95th percentile and longest (us).
    pub path_us: [f64; 3],
}

/// A named place, and what leads there.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LevelPlaceLine {
    /// Name.
    pub name: String,
    /// `goal`, `door`, `queue` or `seat`.
    pub kind: String,
    /// Position (m).
    pub at: [f32; 3],
    /// True where nothing leads there from the largest part of the ground.
    pub is_cut_off: bool,
    /// Names of the places that it is reached from.
    pub reached_from: Vec<String>,
}

/// A link.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LevelLinkLine {
    /// Name.
    pub name: String,
    /// `ladder`, `jump`, `climb`, `escalator` or `elevator`.
    pub kind: String,
    /// Start and end (m).
    pub ends: [[f32; 3]; 2],
}

impl LevelReport {
    /// Report of an open level.
    pub fn new(file: &Path, level: &Level) -> Self {
        let polygons = 0..level.num_polygons() as u32;
        let corners: Vec<Vec3> = level.vertices().collect();
        let centre = |p: u32| {
            let own: Vec<u32> = level.vertices_of(p).collect();
            own.iter().map(|&v| corners[v as usize]).sum::<Vec3>() / own.len() as f32
        };
        let area = |p: u32| {
            let own: Vec<Vec3> = level.vertices_of(p).map(|v| corners[v as usize]).collect();
            let twice = |k: usize| own[k].xz().perp_dot(own[(k + 1) % own.len()].xz());
            0.5 * f64::from((0..own.len()).map(twice).sum::<f32>())
        };
        let mut parts: Vec<(f64, u32)> = Vec::new();
        for p in polygons.clone() {
            let part = level.component(p) as usize;
            parts.resize(parts.len().max(part + 1), (0.0, p));
            parts[part].0 += area(p);
        }
        let largest = parts.iter().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(Vec3::ZERO, |part| centre(part.1));
        let mut parts_m2: Vec<f64> = parts.iter().map(|p| p.0).collect();
        parts_m2.sort_by(|a, b| b.total_cmp(a));

        let mut path = LevelPath::default();
        let mut leads = |from: Vec3, to: Vec3| level.path(from, to, &mut path).is_ok();
        let mut line = |place: NamedPlace<'_>| LevelPlaceLine {
            name: place.name.into(),
            kind: place.kind.into(),
            at: place.at.to_array(),
            is_cut_off: !leads(largest, place.at),
            reached_from: level
                .places()
                .filter(|from| from.name != place.name && leads(from.at, place.at))
                .map(|from| from.name.into())
                .collect(),
        };
        let places = level.places().map(&mut line).collect();
        let link = |l: &throng_level::LevelLink| LevelLinkLine {
            name: level.name(l.name).into(),
            kind: level.name(l.kind).into(),
            ends: l.ends,
        };
        let (paths, path_us) = time_paths(level, centre);
        Self {
            file: file.display().to_string(),
            polygons: level.num_polygons(),
            area_m2: parts_m2.iter().sum(),
            floors_m: level_floors(level),
            parts_m2,
            bytes: level.num_bytes(),
            walls: level.walls().len(),
            links: level.links().iter().map(link).collect(),
            places,
            paths,
            path_us,
        }
    }
}

/// Times queries between the centres of random polygons.
fn time_paths(level: &Level, centre: impl Fn(u32) -> Vec3) -> (usize, [f64; 3]) {
    let (mut rng, mut path) = (Pcg64Mcg::seed_from_u64(1), LevelPath::default());
    let mut times = Vec::with_capacity(QUERIES);
    for query in 0..QUERIES + QUERIES / 10 {
        let [from, to] = [0; 2].map(|_| centre(rng.random_range(0..level.num_polygons() as u32)));
        let start = Instant::now();
        let found = level.path(from, to, &mut path).is_ok();
        let us = 1e6 * start.elapsed().as_secs_f64();
        // The first ones take memory.
        if found && query >= QUERIES / 10 {
            times.push(us);
        }
    }
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times.get(((times.len() as f64 - 1.0) * share) as usize).copied().unwrap_or_default();
    (times.len(), [at(0.5), at(0.95), at(1.0)])
}

impl fmt::Display for LevelReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let floors: Vec<String> = self.floors_m.iter().map(|y| format!("{y:.1}")).collect();
        writeln!(
            f,
            "ground     {:.0} m2 in {} polygons; floors at {} m",
            self.area_m2,
            self.polygons,
            floors.join(", ")
        )?;
        let parts: Vec<String> = self.parts_m2.iter().take(5).map(|a| format!("{a:.0}")).collect();
        writeln!(f, "parts      {} that no walk connects: {} m2", self.parts_m2.len(), parts.join(", "))?;
        writeln!(f, "tables     {:.1} MB, {} walls", self.bytes as f64 / 1e6, self.walls)?;
        for link in &self.links {
            let [from, to] = link.ends.map(Vec3::from);
            writeln!(f, "{:10} \"{}\" from {from:.1} to {to:.1}", link.kind, link.name)?;
        }
        for place in &self.places {
            let end = if place.is_cut_off { ". CUT OFF: nothing leads there from the largest part" } else { "" };
            let from =
                if place.reached_from.is_empty() { "no other place".into() } else { place.reached_from.join(", ") };
            writeln!(f, "{:10} \"{}\" reached from {from}{end}", place.kind, place.name)?;
        }
        let [median, p95, longest] = self.path_us;
        write!(f, "paths      {} random ones: {median:.1} us, p95 {p95:.1} us, longest {longest:.1} us", self.paths)
    }
}
