//! Levels of made-up meshes: paths are shortest, heights those of the mesh, floors apart, and damaged tables are refused.

#[path = "common/shapes.rs"]
mod shapes;

use glam::{Vec2, Vec3, Vec3Swizzles};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use shapes::{SHAPES, baked, source};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::time::Instant;
use throng_crowd::Obstacle;
use throng_level::{Level, LevelData, LevelPath, NONE};
use throng_level_bake::{LevelSettings, LevelSource, MarkedArea, MarkedLink, bake};

/// Distance between points on edges in the graph that paths are compared with (m).
const DENSE_M: f32 = 0.25;

fn level_of(source: &LevelSource) -> (Level, LevelData) {
    let mut warnings = Vec::new();
    let data = bake(source, &LevelSettings::default(), &mut warnings).expect("a level");
    (Level::from_data(&data).expect("a level"), data)
}

/// Points on the edges between polygons, joined within each polygon: its shortest paths are a little longer than the shortest.
struct DenseGraph {
    points: Vec<Vec3>,
    of_polygon: Vec<Vec<u32>>,
    polygons: Vec<[u32; 2]>,
}

impl DenseGraph {
    fn new(data: &LevelData) -> Self {
        let mut out =
            Self { points: Vec::new(), of_polygon: vec![Vec::new(); data.polygons.len()], polygons: Vec::new() };
        for (p, polygon) in data.polygons.iter().enumerate() {
            for k in 0..polygon.num_edges {
                let edge = data.edges[(polygon.first_edge + k) as usize];
                let next = data.edges[(polygon.first_edge + (k + 1) % polygon.num_edges) as usize];
                if edge.neighbour == NONE || edge.neighbour < p as u32 {
                    continue;
                }
                let [a, b] = [edge, next].map(|e| Vec3::from(data.vertices[e.vertex as usize].at));
                let num = ((b - a).xz().length() / DENSE_M).ceil().max(1.0) as usize;
                for i in 0..=num {
                    let number = out.points.len() as u32;
                    out.points.push(a + (b - a) * (i as f32 / num as f32));
                    out.polygons.push([p as u32, edge.neighbour]);
                    out.of_polygon[p].push(number);
                    out.of_polygon[edge.neighbour as usize].push(number);
                }
            }
        }
        out
    }

    fn shortest(&self, level: &Level, from: Vec3, to: Vec3) -> f64 {
        let [start, end] = [from, to].map(|at| level.nearest(at, 1.5).expect("ground").polygon);
        let flat = |a: Vec3, b: Vec3| f64::from((a.xz() - b.xz()).length());
        if start == end {
            return flat(from, to);
        }
        let mut best: HashMap<u32, f64> = HashMap::new();
        let mut open = BinaryHeap::new();
        let mut shortest = f64::INFINITY;
        let mut reach = |open: &mut BinaryHeap<_>, n: u32, length: f64| {
            let known = best.entry(n).or_insert(f64::INFINITY);
            if length < *known {
                *known = length;
                open.push((Reverse((length * 1e9) as u64), n));
            }
        };
        self.of_polygon[start as usize].iter().for_each(|&n| reach(&mut open, n, flat(from, self.points[n as usize])));
        while let Some((Reverse(length), n)) = open.pop() {
            let length = length as f64 / 1e9;
            if length > shortest {
                break;
            }
            for polygon in self.polygons[n as usize] {
                if polygon == end {
                    shortest = shortest.min(length + flat(self.points[n as usize], to));
                }
                for &next in &self.of_polygon[polygon as usize] {
                    reach(&mut open, next, length + flat(self.points[n as usize], self.points[next as usize]) + 1e-9);
                }
            }
        }
        shortest
    }
}

fn random_point(level: &Level, rng: &mut Pcg64Mcg) -> Vec3 {
    let corners: Vec<Vec3> = level.vertices().collect();
    let polygon = rng.random_range(0..level.num_polygons() as u32);
    let own: Vec<Vec3> = level.vertices_of(polygon).map(|v| corners[v as usize]).collect();
    let shares: Vec<f32> = own.iter().map(|_| rng.random_range(0.01..1.0f32)).collect();
    let sum: f32 = shares.iter().sum();
    own.iter().zip(&shares).map(|(c, s)| *c * (s / sum)).sum()
}

/// Compares random paths of a level with those of the dense graph, and returns the largest and smallest ratio.
fn compare(name: &str, level: &Level, data: &LevelData, num: usize) {
    let (graph, mut rng, mut path) = (DenseGraph::new(data), Pcg64Mcg::seed_from_u64(7), LevelPath::default());
    let (mut worst, mut least, mut found, mut us) = (0.0f64, f64::INFINITY, 0, Vec::new());
    for _ in 0..num {
        let [from, to] = [0; 2].map(|_| level.nearest(random_point(level, &mut rng), 1.5).expect("ground").at);
        let best = graph.shortest(level, from, to);
        let start = Instant::now();
        let is_found = level.path(from, to, &mut path).is_ok();
        us.push(1e6 * start.elapsed().as_secs_f64());
        assert_eq!(is_found, best.is_finite(), "{name}: from {from} to {to}");
        if !is_found {
            continue;
        }
        found += 1;
        let along: f64 = path.corners().windows(2).map(|w| f64::from((w[1] - w[0]).xz().length())).sum();
        assert!((along - path.length_m()).abs() < 1e-3 * (1.0 + along), "{name}: {along} {}", path.length_m());
        // The graph's paths bend at its points, and are a little longer.
        let ratio = path.length_m() / best.max(1e-3);
        let good = path.length_m() < 1.021 * best + 1e-3 && path.length_m() > 0.97 * best - 0.1;
        assert!(good, "{name}: {} m, {best} m by the graph: from {from} to {to}", path.length_m());
        if best > 2.0 {
            (worst, least) = (worst.max(ratio), least.min(ratio));
        }
        // Nothing leads beside the ground.
        for leg in path.corners().windows(2) {
            for k in 0..=20 {
                let at = leg[0] + (leg[1] - leg[0]) * (k as f32 / 20.0);
                let mut near = (-6..=6).filter_map(|k| level.nearest(at + Vec3::Y * (0.4 * k as f32), 0.5));
                assert!(near.any(|on| (on.at - at).xz().length() < 2e-3), "{name}: {at} is beside the ground");
            }
        }
    }
    us.sort_by(f64::total_cmp);
    let p95 = us[us.len() * 95 / 100];
    println!(
        "{name:12} {:5} polygons, {found:4} paths: {least:.4} to {worst:.4} of the graph's; p95 {p95:.1} us",
        level.num_polygons()
    );
    assert!(found >= num / 5, "{name}: {found} of {num}");
}

#[test]
fn walls_beside_ramps_are_of_one_floor_each() {
    let mut rises = 0;
    for (name, shape) in SHAPES {
        let (level, _) = level_of(&source(shape));
        let mut length = 0.0;
        for [from, to] in level.walls_of_floors() {
            let rise = (to.y - from.y).abs();
            assert!(rise < 0.51, "{name}: {from} to {to}");
            rises += u32::from(rise > 0.1);
            length += from.distance(to);
        }
        let whole: f32 = level.walls().iter().map(|w| Vec3::from(w.from).distance(w.to.into())).sum();
        assert!((length - whole).abs() < 1e-3 * whole, "{name}: {length} m of {whole} m");
    }
    assert!(rises > 10, "{rises} walls are beside ramps");
}

#[test]
fn paths_are_the_shortest_in_ten_kinds_of_levels() {
    for (name, make) in SHAPES {
        let (level, data) = level_of(&source(make));
        compare(name, &level, &data, 40);
    }
}

#[test]
fn paths_are_the_shortest_among_random_boxes() {
    for seed in 0..4 {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let boxes: Vec<Obstacle<Vec2>> = (0..25)
            .map(|_| {
                let min = Vec2::new(rng.random_range(-10.0..10.0f32), rng.random_range(-10.0..10.0f32));
                let size = Vec2::new(rng.random_range(0.3..5.0f32), rng.random_range(0.3..5.0f32));
                Obstacle::Box { min, max: min + size }
            })
            .collect();
        let (level, data) = level_of(&LevelSource::around(&boxes));
        compare(&format!("boxes {seed}"), &level, &data, 25);
    }
}

#[test]
fn paths_over_a_town_take_microseconds() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let side = 110.0f32;
    let boxes: Vec<Obstacle<Vec2>> = (0..1500)
        .map(|_| {
            let min = Vec2::new(rng.random_range(-side..side), rng.random_range(-side..side));
            let size = Vec2::new(rng.random_range(0.5..6.0f32), rng.random_range(0.5..6.0f32));
            Obstacle::Box { min, max: min + size }
        })
        .collect();
    let (level, _) = level_of(&LevelSource::around(&boxes));
    let (mut path, mut us) = (LevelPath::default(), Vec::new());
    for k in 0..2200 {
        let [from, to] = [0; 2].map(|_| random_point(&level, &mut rng));
        let start = Instant::now();
        let is_found = level.path(from, to, &mut path).is_ok();
        if k >= 200 && is_found {
            us.push(1e6 * start.elapsed().as_secs_f64());
        }
    }
    us.sort_by(f64::total_cmp);
    let at = |share: f64| us[(us.len() as f64 * share) as usize];
    println!(
        "town: {} polygons, {} paths, {:.1} us, p95 {:.1} us, {:.1} MB",
        level.num_polygons(),
        us.len(),
        at(0.5),
        at(0.95),
        level.num_bytes() as f64 / 1e6
    );
    assert!(us.len() > 1000, "{} of 2000 paths were found", us.len());
}

#[test]
fn heights_are_those_of_the_mesh() {
    let (level, _) = level_of(&source(shapes::ramp));
    for x in [0.5f32, 3.0, 5.0, 7.9] {
        let height = level.height_at(Vec3::new(x, 1.0, 2.0));
        let expected = ((x - 2.0) * 0.25).clamp(0.0, 1.5);
        assert!(height.is_some_and(|y| (y - expected).abs() < 0.005), "{x}: {height:?} {expected}");
    }
    let (level, _) = level_of(&source(shapes::stairs));
    let on_step = level.height_at(Vec3::new(2.15 + 0.3 * 4.0, 0.8, 2.0)).expect("a step");
    assert!((on_step - 0.17 * 5.0).abs() < 0.005, "{on_step}");
    assert_eq!(level.height_at(Vec3::new(-30.0, 0.0, 0.0)), None);
}

#[test]
fn floors_above_each_other_are_two_places() {
    let (level, _) = level_of(&source(shapes::two_floors));
    let [low, high] = [0.0, 3.5].map(|y| level.nearest(Vec3::new(9.0, y, 9.0), 1.0).expect("a floor"));
    assert!(low.polygon != high.polygon && high.at.y - low.at.y > 3.0, "{low:?} {high:?}");
    let mut path = LevelPath::default();
    level.path(low.at, high.at, &mut path).expect("by the stairs");
    assert!(path.length_m() > 8.0, "{}", path.length_m());
    level.path(low.at, low.at + Vec3::X, &mut path).expect("beside");
    assert!((path.length_m() - 1.0).abs() < 1e-3);
}

#[test]
fn links_lead_where_no_walk_does() {
    let mut source = source(shapes::islands);
    let ends = [Vec3::new(3.0, 0.0, 3.0), Vec3::new(3.0, 3.0, 13.0)];
    source.links.push(MarkedLink { name: "up".into(), kind: "ladder", ends });
    let down = [Vec3::new(5.0, 3.0, 12.0), Vec3::new(5.0, 0.0, 5.0)];
    source.links.push(MarkedLink { name: "down".into(), kind: "jump", ends: down });
    let square = |x: f32, y: f32, z: f32| {
        let at = |dx, dz| Vec3::new(x + dx, y, z + dz);
        vec![[at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0)], [at(0.0, 0.0), at(1.0, 1.0), at(1.0, 0.0)]]
    };
    let area = |name: &str, triangles| MarkedArea { name: name.into(), kind: "goal", triangles };
    source.areas.push(area("roof", square(6.0, 3.0, 16.0)));
    source.areas.push(area("nowhere", square(90.0, 0.0, 0.0)));
    let mut warnings = Vec::new();
    let data = bake(&source, &LevelSettings::default(), &mut warnings).expect("a level");
    assert!(warnings.len() == 1 && warnings[0].contains("nowhere"), "{warnings:?}");
    let level = Level::from_data(&data).expect("a level");
    let (roof, ground) = (level.place("roof").expect("a place").at, Vec3::new(6.5, 0.0, 1.0));
    assert!((roof.y - 3.0).abs() < 0.01 && level.place("cellar").is_err(), "{roof}");
    let on = level.nearest(roof, 0.5).expect("ground");
    assert_eq!(level.place_of(on.polygon), Some(0));
    let mut path = LevelPath::default();
    level.path(ground, roof, &mut path).expect("by the ladder");
    let kinds = |path: &LevelPath| -> Vec<&str> {
        path.links().iter().map(|l| level.name(level.links()[l.link].kind)).collect()
    };
    assert_eq!(kinds(&path), ["ladder"]);
    assert!(path.corners().len() >= 4 && path.length_m() > 20.0, "{path:?}");
    level.path(roof, ground, &mut path).expect("by the jump");
    assert_eq!(kinds(&path), ["jump"]);
    let one_way = level.path(Vec3::new(40.0, 0.0, 3.0), ground, &mut path);
    assert!(one_way.is_err() && path.corners().is_empty());
}

#[test]
fn scenes_take_walls_and_places_from_their_level() {
    let folder = tempfile::tempdir().expect("a folder");
    let (plan, file) = (folder.path().join("plan.geojson"), folder.path().join("a.level"));
    let ring = |low: [f32; 2], high: [f32; 2]| {
        let [[a, b], [c, d]] = [low, high];
        format!("[[{a}, {b}], [{c}, {b}], [{c}, {d}], [{a}, {d}]]")
    };
    let feature = |rings: &str, mark: &str| {
        format!(
            r#"{{"geometry": {{"type": "Polygon", "coordinates": [{rings}]}}, "properties": {{"throng": "{mark}"}}}}"#
        )
    };
    let ground = feature(&format!("{}, {}", ring([0.0, 0.0], [20.0, 12.0]), ring([8.0, 4.0], [12.0, 8.0])), "");
    let goal = feature(&ring([16.0, 8.0], [19.0, 11.0]), "goal:exit");
    std::fs::write(&plan, format!(r#"{{"features": [{ground}, {goal}]}}"#)).expect("a plan");
    let source = LevelSource::read(&plan).expect("a plan");
    let (level, data) = level_of(&source);
    assert!(level.walls().len() >= 8, "{:?}", level.walls());
    let mut bytes = Vec::new();
    data.write(&mut bytes).expect("bytes");
    std::fs::write(&file, bytes).expect("a level");
    let parse = |level: &str, goal: &str| {
        let text = format!(
            "level = {{ file = \"{level}\" }}\n[[groups]]\nmotion = \"none\"\ncount = 8\narrival_m = 2.0\n\
             place = {{ block = {{ from = [1.5, 1.5], to = [6.0, 4.0] }} }}\ngoal = {{ place = {{ name = \"{goal}\" }} }}\n"
        );
        throng_simulation::Scene::parse(&text, &folder.path().join("a.toml"))
    };
    let scene = parse("a.level", "exit").expect("a scene");
    assert_eq!(scene.environment.obstacles.len(), level.walls().len());
    let compiled = scene.open().expect("a scene");
    let mut simulation = throng_simulation::Simulation::new(&compiled).expect("a simulation");
    for _ in 0..400 {
        simulation.step(0.1).expect("a step");
        for who in 0..8 {
            let at = simulation.disc(who).expect("an agent").centre;
            let is_in_hole = at.x > 7.9 && at.x < 12.1 && at.z > 3.9 && at.z < 8.1;
            assert!(level.nearest(at, 0.4).is_some() && !is_in_hole, "{at}");
        }
    }
    for who in 0..8 {
        let at = simulation.disc(who).expect("an agent").centre;
        assert!((at.xz() - Vec2::new(17.5, 9.5)).length() < 4.0, "{who} is at {at}");
    }
    let unknown = parse("a.level", "moon").expect_err("no such place").to_string();
    assert!(unknown.contains("there is no place \"moon\""), "{unknown}");
    let absent = parse("b.level", "exit").expect_err("no such file").to_string();
    assert!(absent.contains("throng level"), "{absent}");
}

#[test]
fn sources_that_are_no_ground_are_refused_with_the_way_out() {
    let refused = |source: &LevelSource| bake(source, &LevelSettings::default(), &mut Vec::new()).unwrap_err();
    let triangle = [Vec3::ZERO, Vec3::X * 9.0, Vec3::Z * 9.0];
    let down = refused(&LevelSource { triangles: vec![triangle], ..LevelSource::default() });
    assert!(down.contains("faces up"), "{down}");
    assert!(refused(&LevelSource::default()).contains("check its unit"));
    let [a, b, c] = triangle.map(|p| p * 0.01);
    assert!(refused(&LevelSource { triangles: vec![[a, c, b]], ..LevelSource::default() }).contains("check its unit"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Tables with right checksums and wrong numbers: refused, or they do no harm.
    #[test]
    fn damaged_tables_are_refused_or_do_no_harm(
        table in 0usize..12,
        place in any::<prop::sample::Index>(),
        word in any::<prop::sample::Index>(),
        value in prop_oneof![Just(u32::MAX), Just(0), 0u32..400, any::<u32>()],
    ) {
        let mut data = baked();
        fn put<T: bytemuck::Pod>(rows: &mut [T], place: &prop::sample::Index, word: &prop::sample::Index, value: u32) {
            if rows.is_empty() { return; }
            let words: &mut [u32] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut rows[place.index(rows.len())]));
            words[word.index(words.len())] = value;
        }
        match table {
            0 => put(&mut data.head, &place, &word, value),
            1 => put(&mut data.vertices, &place, &word, value),
            2 => put(&mut data.walls, &place, &word, value),
            3 => put(&mut data.polygons, &place, &word, value),
            4 => put(&mut data.edges, &place, &word, value),
            5 => put(&mut data.triangles, &place, &word, value),
            6 => put(&mut data.squares, &place, &word, value),
            7 => put(&mut data.listed, &place, &word, value),
            8 => put(&mut data.places, &place, &word, value),
            9 => put(&mut data.links, &place, &word, value),
            10 => put(&mut data.link_costs, &place, &word, value),
            _ => put(&mut data.link_next, &place, &word, value),
        }
        if let Ok(level) = Level::from_data(&data) {
            let (mut path, mut rng) = (LevelPath::default(), Pcg64Mcg::seed_from_u64(u64::from(value)));
            for _ in 0..20 {
                let at = |rng: &mut Pcg64Mcg| {
                    Vec3::new(rng.random_range(-1.0..21.0f32), rng.random_range(-1.0..4.0f32), rng.random_range(-1.0..21.0f32))
                };
                let _ = level.path(at(&mut rng), at(&mut rng), &mut path);
                let _ = level.height_at(at(&mut rng));
            }
            level.places().for_each(|p| drop(level.place(p.name)));
        }
    }
}

#[test]
fn files_cut_short_or_changed_are_refused() {
    let mut bytes = Vec::new();
    baked().write(&mut bytes).expect("bytes");
    for cut in [0, 7, 63, 64, 500, bytes.len() - 1] {
        assert!(Level::from_bytes(&bytes[..cut]).is_err(), "{cut}");
    }
    for at in (0..bytes.len()).step_by(97) {
        let mut other = bytes.clone();
        other[at] ^= 0x10;
        assert!(Level::from_bytes(&other).is_err(), "{at}");
    }
    let e = Level::from_bytes(b"\x89THRONG\nxxxx").unwrap_err().to_string();
    assert!(e.contains("throng level"), "{e}");
}

/// Corners that the radius of people cuts off have vertices that are nearly on one line.
#[test]
fn who_can_walk_there_can_walk_back() {
    let (level, _) = level_of(&source(shapes::halls));
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let mut heights = Vec::new();
    let mut draw = || loop {
        let at = Vec2::new(rng.random_range(0.0..128.0), rng.random_range(0.0..24.0));
        heights.clear();
        level.add_heights(at, &mut heights);
        if let [height] = heights[..] {
            return Vec3::new(at.x, height, at.y);
        }
    };
    let (mut there, mut back) = (LevelPath::default(), LevelPath::default());
    for _ in 0..4000 {
        let [a, b] = [draw(), draw()];
        level.path_on_foot(a, b, &mut there).unwrap_or_else(|e| panic!("{e}"));
        level.path_on_foot(b, a, &mut back).unwrap_or_else(|e| panic!("{e}"));
        let [longer, shorter] = [there.length_m().max(back.length_m()), there.length_m().min(back.length_m())];
        assert!(longer < 1.0201 * shorter + 1e-3, "{a} to {b}: {longer} and {shorter} m");
    }
}
