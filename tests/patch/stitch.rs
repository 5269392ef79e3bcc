//! Worlds of made-up patches: joints and obstacles against plain scans, connectedness against a graph that is built.

use super::made_up::{BENCH, GROUND, MadeUp, PANEL_M, WALL, panels, with};
use proptest::prelude::*;
use std::collections::BTreeSet;
use throng_core::patch::{CellRecord, NONE, Placement};
use throng_core::planar::wrap_angle;
use throng_precompute::clip::joint_transforms;
use throng_precompute::environment::{BodySpheres, Environment, PlacedGeometry, PlacedUnit};
use throng_precompute::progress::Silent;
use throng_precompute::stitch::{Editor, InstanceItem, RemovalReason, StitchConfig, StitchReport, stitch};
use throng_world::{InstanceRecord, WorldData, is_set};

fn config() -> StitchConfig {
    StitchConfig {
        obstacles: vec!["wall".into()],
        joints_per_cell: 99,
        allow_unreachable: true,
        ..StitchConfig::default()
    }
}

fn stitched(library: &MadeUp, environment: &Environment, config: &StitchConfig) -> (WorldData, StitchReport) {
    let (world, report) =
        stitch(&library.patches(), &library.library(), environment, config, &Silent).expect("a world");
    world.check(&library.patches()).expect("a whole world");
    (world, report)
}

fn refusal(library: &MadeUp, environment: &Environment, config: &StitchConfig) -> String {
    stitch(&library.patches(), &library.library(), environment, config, &Silent).expect_err("a refusal").to_string()
}

/// What is left of a world as a graph: nodes are (instance, cell).
struct Graph {
    nodes: BTreeSet<(u32, u32)>,
    ways: BTreeSet<((u32, u32), (u32, u32))>,
}

/// The node of a cell: exits are the entry across the edge.
fn node(m: &MadeUp, w: &WorldData, i: u32, cell: u32) -> Option<(u32, u32)> {
    let instance = &w.instances[i as usize];
    let patches = m.patches();
    let c = &patches.cells_of(instance.patch as usize)[cell as usize];
    if !c.has_flags(CellRecord::IS_EXIT) {
        return Some((i, cell));
    }
    let other = w.neighbours[(instance.first_neighbour + c.edge) as usize];
    (other != NONE).then_some((other, c.twin))
}

impl Graph {
    fn new(m: &MadeUp, w: &WorldData) -> Self {
        let patches = m.patches();
        let mut out = Self { nodes: BTreeSet::new(), ways: BTreeSet::new() };
        for (i, r) in (0u32..).zip(&w.instances) {
            for c in 0..patches.cells_of(r.patch as usize).len() as u32 {
                if is_set(&w.cell_words, r.first_cell_word, c) {
                    out.nodes.insert(node(m, w, i, c).expect("an enabled exit leads to a neighbour"));
                }
            }
            for (l, link) in (0u32..).zip(patches.links_of(r.patch as usize)) {
                if is_set(&w.link_words, r.first_link_word, l) {
                    out.ways.insert(((i, link.from), node(m, w, i, link.to).expect("an enabled link leads on")));
                }
            }
            out.joints(m, w, i, r);
        }
        out
    }

    fn joints(&mut self, m: &MadeUp, w: &WorldData, i: u32, r: &InstanceRecord) {
        let patches = m.patches();
        let links = patches.links_of(r.patch as usize);
        for a in &w.adjacencies[r.first_adjacency as usize..][..r.num_adjacencies as usize] {
            let t = &w.tables[a.table as usize];
            for k in (0..t.num_joints).filter(|_| a.side == 0) {
                let j = &w.joints[(t.first_joint + k) as usize];
                let link = (j.a_offset != NONE).then(|| &links[j.a as usize]);
                let Some(link) = link else {
                    self.cells_joined(m, w, (i, j.a), (a.other, j.b), a.first_word, k);
                    continue;
                };
                let (from, to) = (link.from, link.to);
                if is_set(&w.joint_words, a.first_word, 2 * k) {
                    self.ways.insert(((i, from), (a.other, j.b)));
                }
                if is_set(&w.joint_words, a.first_word, 2 * k + 1) {
                    self.ways.insert(((a.other, j.b), node(m, w, i, to).expect("an enabled joint leads on")));
                }
            }
        }
    }

    /// From a cell, the links of the one it is joined to lead on.
    fn cells_joined(&mut self, m: &MadeUp, w: &WorldData, a: (u32, u32), b: (u32, u32), first_word: u32, joint: u32) {
        for (bit, from, via) in [(2 * joint, a, b), (2 * joint + 1, b, a)] {
            let r = &w.instances[via.0 as usize];
            let patches = m.patches();
            let links = (0u32..).zip(patches.links_of(r.patch as usize));
            for (l, link) in links.filter(|_| is_set(&w.joint_words, first_word, bit)) {
                if link.from == via.1 && is_set(&w.link_words, r.first_link_word, l) {
                    self.ways.insert((from, node(m, w, via.0, link.to).expect("an enabled link leads on")));
                }
            }
        }
    }

    /// Nodes that a node leads to, or that lead to it.
    fn reach(&self, from: (u32, u32), back: bool) -> BTreeSet<(u32, u32)> {
        let mut seen = BTreeSet::from([from]);
        let mut open = vec![from];
        while let Some(n) = open.pop() {
            for (a, b) in &self.ways {
                let (a, b) = if back { (b, a) } else { (a, b) };
                if *a == n && seen.insert(*b) {
                    open.push(*b);
                }
            }
        }
        seen
    }
}

fn assert_strongly_connected(m: &MadeUp, w: &WorldData) -> Graph {
    let graph = Graph::new(m, w);
    let first = *graph.nodes.first().expect("a world has nodes");
    assert_eq!(graph.reach(first, false), graph.nodes);
    assert_eq!(graph.reach(first, true), graph.nodes);
    assert_eq!(w.meta.cells, graph.nodes.len() as u64);
    graph
}

#[test]
fn tiles_lead_to_their_neighbours_and_nowhere_else() {
    let m = MadeUp::new();
    let (world, report) = stitched(&m, &panels(3, 2), &config());
    assert_eq!((report.instances, report.patches["ground"]), (6, 6));
    let graph = assert_strongly_connected(&m, &world);
    // 14 of the 24 edges have a neighbour: an entry each, and from it links to the other edges that have one.
    assert_eq!(graph.nodes.len(), 14);
    let degree = [2usize, 3, 2, 2, 3, 2];
    assert_eq!(report.transitions, degree.map(|d| (d * d) as u64).iter().sum::<u64>());
    assert_eq!(report.disabled["obstacle"], 0);
    assert!(report.disabled["no_neighbour"] > 0);
    assert_eq!(report.motion_hours, report.transitions as f64 * 56.0 / 30.0 / 3600.0);
    let units: Vec<u32> = world.resources.clone();
    assert_eq!(units, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn tiles_turned_by_their_symmetry_make_the_same_world() {
    let m = MadeUp::new();
    let mut turned = panels(3, 3);
    for (i, u) in turned.units.iter_mut().enumerate() {
        u.placement.heading = (i % 4) as f32 * std::f32::consts::FRAC_PI_2;
    }
    let (world, _) = stitched(&m, &turned, &config());
    assert_eq!(world.neighbours, stitched(&m, &panels(3, 3), &config()).0.neighbours);
}

#[test]
fn a_bench_is_sat_down_on_from_the_tile_beneath() {
    let m = MadeUp::new();
    // The way across the tile from -z to +z comes by the place before the bench half-way.
    let (world, report) = stitched(&m, &with(panels(3, 3), BENCH, PANEL_M, PANEL_M + 0.8, 0.0), &config());
    let graph = assert_strongly_connected(&m, &world);
    assert_eq!(report.patches["bench"], 1);
    assert!((0..3).all(|c| graph.nodes.contains(&(9, c))), "the bench is part of the world");
    assert!(report.disabled["obstacle"] > 0, "no way leads through the bench");
    let bench = &world.instances[9];
    let held = &world.resources[bench.first_resource as usize..][..bench.num_resources as usize];
    assert!(held.contains(&4) && held.contains(&9), "the bench and the panel beneath: {held:?}");
}

/// All joints of a table by a scan over everything.
fn scanned(m: &MadeUp, a: usize, b: usize, at: Placement, c: &StitchConfig) -> BTreeSet<(u32, u32, u32)> {
    let patches = m.patches();
    let distance = |p: Placement, q: Placement| {
        let q = at.compose(q);
        let ground = (p.x - q.x).hypot(p.z - q.z) / c.position_m;
        let turn = wrap_angle(p.heading - q.heading).abs().to_degrees() / c.heading_deg;
        let height = (p.y - q.y).abs() / c.height_m;
        (ground <= 1.0 && turn <= 1.0 && height <= 1.0).then_some(ground * ground + turn * turn + height * height)
    };
    let mut out = BTreeSet::new();
    for (k, cell) in (0u32..).zip(patches.cells_of(b)) {
        if a == 1 {
            for (j, other) in (0u32..).zip(patches.cells_of(a)) {
                if other.group == cell.group && distance(other.placement, cell.placement).is_some() {
                    out.insert((j, NONE, k));
                }
            }
            continue;
        }
        for (l, link) in (0u32..).zip(patches.links_of(a)) {
            let offsets = c.min_frames..=u32::from(link.num_frames) - c.min_frames;
            let near = offsets.filter(|o| m.groups[(link.frame + o) as usize] == cell.group);
            let best = near.filter_map(|o| distance(m.hips(link, o), cell.placement).map(|d| (d, o)));
            if let Some((_, o)) = best.min_by(|p, q| p.0.total_cmp(&q.0)) {
                out.insert((l, o, k));
            }
        }
    }
    out
}

/// Links of an instance on which a body is in a unit that does not belong to it, with first and last such frame among
/// those that the stitcher looks at.
fn colliding(m: &MadeUp, w: &WorldData, e: &Environment, i: usize, depth: f32) -> BTreeSet<u32> {
    let geometry = PlacedGeometry::new(e, &m.geometries);
    let body = BodySpheres::new(&m.skeleton);
    let r = &w.instances[i];
    // Every instance of these patches consists of the unit that stands where it does.
    let own = |u: usize| {
        let p = e.units[u].placement;
        let unit = if r.patch == 0 { GROUND } else { BENCH };
        e.units[u].unit == unit && (p.translation() - r.placement.translation()).length() < 0.02
    };
    let collides = |link: &throng_core::patch::LinkRecord, k: u32| {
        let row = &m.frames[(link.frame + k) as usize];
        let at = r.placement.compose(m.hips(link, k));
        let turn = at.planar().rotation();
        let joints = joint_transforms(&m.skeleton, at.translation(), |j| {
            if j == 0 { turn * m.rotation_code.rotation(row, 0) } else { m.rotation_code.rotation(row, j) }
        });
        let pose = body.pose(&joints, m.contacts[(link.frame + k) as usize]);
        (0..e.units.len())
            .filter(|&u| !own(u))
            .any(|u| pose.penetration(geometry.placement(u), geometry.geometry(u), depth).is_some())
    };
    let patches = m.patches();
    let links = patches.links_of(r.patch as usize);
    (0u32..)
        .zip(links)
        .filter(|(_, l)| (0..=u32::from(l.num_frames)).step_by(2).any(|k| collides(l, k)))
        .map(|(l, _)| l)
        .collect()
}

/// As [`stitched`]; none where no motion goes on for ever, or copies of a unit stand in one place.
fn maybe_stitched(m: &MadeUp, e: &Environment, c: &StitchConfig) -> Option<(WorldData, StitchReport)> {
    match stitch(&m.patches(), &m.library(), e, c, &Silent) {
        Ok(_) => Some(stitched(m, e, c)),
        Err(error) => {
            let error = error.to_string();
            assert!(error.contains("no motion leads on") || error.contains("in the same place"), "{error}");
            None
        }
    }
}

/// In steps in which units are told apart, so that what touches just so is not rounded to the other side.
fn in_steps(x: f32, z: f32, heading: f32) -> (f32, f32, f32) {
    let metres = |v: f32| (v * 1e3).round() / 1e3;
    (metres(x), metres(z), (heading.to_degrees() * 10.0).round().to_radians() / 10.0)
}

/// Environments of a few panels with benches and walls anywhere.
fn environments() -> impl Strategy<Value = Environment> {
    let bench = (-1.0f32..5.0, -1.0f32..5.0, 0u32..8)
        .prop_map(|(x, z, h)| (BENCH, x, z, h as f32 * std::f32::consts::FRAC_PI_4));
    let near = (0u32..4, 0u32..4).prop_map(|(k, h)| {
        let heading = h as f32 * std::f32::consts::FRAC_PI_2;
        let at = Placement::new((k % 2) as f32 * PANEL_M, 0.0, (k / 2) as f32 * PANEL_M, heading);
        let p = at.compose(Placement::new(0.03, 0.0, 0.77, 0.05));
        (BENCH, p.x, p.z, p.heading)
    });
    let wall = (-1.0f32..5.0, -1.0f32..5.0, -3.0f32..3.0).prop_map(|(x, z, h)| (WALL, x, z, h));
    let stepped = |(unit, x, z, h)| {
        let (x, z, h) = in_steps(x, z, h);
        (unit, x, z, h)
    };
    let units = prop::collection::vec(prop_oneof![near, bench, wall].prop_map(stepped), 0..5);
    (2usize..4, 2usize..4, units).prop_map(|(across, along, units)| {
        units.into_iter().fold(panels(across, along), |e, (unit, x, z, h)| with(e, unit, x, z, h))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn worlds_are_strongly_connected_and_joined_wherever_they_may_be(e in environments()) {
        let (m, c) = (MadeUp::new(), StitchConfig { overlap_m: 99.0, ..config() });
        let Some((world, report)) = maybe_stitched(&m, &e, &c) else { return Ok(()) };
        let graph = assert_strongly_connected(&m, &world);
        let joints: usize = world.joints.len();
        prop_assert_eq!(joints, report.joints);
        for t in &world.tables {
            let joints = &world.joints[t.first_joint as usize..][..t.num_joints as usize];
            let found: BTreeSet<_> = joints.iter().map(|j| (j.a, j.a_offset, j.b)).collect();
            prop_assert_eq!(found, scanned(&m, t.patch_a as usize, t.patch_b as usize, t.placement, &c));
        }
        // A link is left where nothing is in its way and both of its ends are left.
        for (i, r) in world.instances.iter().enumerate() {
            let hit = colliding(&m, &world, &e, i, c.penetration_m);
            for (l, link) in (0u32..).zip(m.patches().links_of(r.patch as usize)) {
                let end = node(&m, &world, i as u32, link.to);
                let ends = graph.nodes.contains(&(i as u32, link.from)) && end.is_some_and(|n| graph.nodes.contains(&n));
                prop_assert_eq!(is_set(&world.link_words, r.first_link_word, l), ends && !hit.contains(&l));
            }
        }
    }

    #[test]
    fn a_changed_world_is_the_one_that_stitching_anew_gives(
        e in environments(), moves in prop::collection::vec((0usize..3, 0usize..9, -1.0f32..4.0, -1.0f32..4.0), 1..5)
    ) {
        let (m, c) = (MadeUp::new(), StitchConfig { overlap_m: 99.0, ..config() });
        prop_assume!(maybe_stitched(&m, &e, &c).is_some());
        let mut editor = Editor::new(&m.patches(), m.library(), e, &c, &Silent).unwrap();
        let (first, mut changes) = (editor.world().clone(), 0);
        for (what, which, x, z) in moves {
            let to = Placement::new(x, 0.0, z, x);
            let which = which % editor.environment().units.len();
            let before = editor.environment().clone();
            let changed = match what {
                0 => editor.add(BENCH, to).map(|_| ()),
                1 => editor.remove(which),
                _ => editor.drag(which, to),
            };
            match changed {
                Ok(()) => changes += 1,
                Err(_) => prop_assert_eq!(editor.environment(), &before),
            }
            let anew = stitched(&m, editor.environment(), &c).0;
            prop_assert_eq!(editor.world(), &anew);
        }
        let last = editor.world().clone();
        let undone = std::iter::from_fn(|| editor.undo().unwrap().then_some(())).count();
        prop_assert_eq!((undone, editor.world()), (changes, &first));
        let redone = std::iter::from_fn(|| editor.redo().unwrap().then_some(())).count();
        prop_assert_eq!((redone, editor.world()), (changes, &last));
    }
}

#[test]
fn what_cannot_be_a_world_is_refused_by_name() {
    let m = MadeUp::new();
    let c = StitchConfig { allow_unreachable: false, ..config() };
    let none = StitchConfig::default();
    let cases = [
        (refusal(&m, &Environment::default(), &c), "no block of bundle made-up fits environment"),
        (
            refusal(&m, &with(panels(2, 2), WALL, 0.0, 0.0, 0.0), &none),
            "no block fits unit wall (place 4, at 0.00, 0.00",
        ),
        (
            refusal(&m, &with(panels(2, 2), GROUND, 0.03, 0.0, 0.0), &c),
            "unit ground (place 4, at 0.03, 0.00, 0.00, heading 0 deg) stand in the same place",
        ),
        (
            refusal(
                &m,
                &with(panels(2, 2), WALL, 0.0, 0.0, 0.0),
                &StitchConfig { obstacles: vec!["wal".into()], ..c.clone() },
            ),
            "names the unit wal,",
        ),
        (refusal(&m, &with(panels(2, 2), BENCH, 9.0, 9.0, 0.0), &c), "unit bench (place 4, at 9.00, 0.00, 9.00"),
        (refusal(&m, &panels(1, 1), &c), "no motion leads on for ever"),
        (refusal(&m, &with(with(panels(2, 2), BENCH, 0.0, 0.8, 0.0), BENCH, 0.1, 0.8, 0.0), &c), "in each other"),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{message}\nexpected: {expected}");
    }
    let unknown =
        Environment { name: "e".into(), units: vec![PlacedUnit { unit: 77, placement: Placement::IDENTITY }] };
    assert!(refusal(&m, &unknown, &c).contains("unit number 77"));
}

#[test]
fn whatever_is_taken_out_can_say_why() {
    let m = MadeUp::new();
    let e = with(panels(3, 3), BENCH, PANEL_M, PANEL_M + 0.8, 0.0);
    let editor = Editor::new(&m.patches(), m.library(), e, &config(), &Silent).unwrap();
    let world = editor.world();
    let mut counted = std::collections::BTreeMap::new();
    for (i, r) in (0u32..).zip(&world.instances) {
        let patch = &m.patches[r.patch as usize];
        let cells =
            (0..patch.num_cells).map(|c| (InstanceItem::Cell(c), is_set(&world.cell_words, r.first_cell_word, c)));
        let links =
            (0..patch.num_links).map(|l| (InstanceItem::Link(l), is_set(&world.link_words, r.first_link_word, l)));
        for (item, enabled) in cells.chain(links) {
            let why = editor.explain_removal(i, item);
            assert_eq!(why.is_none(), enabled, "{i} {item:?}");
            let Some(why) = why else { continue };
            *counted.entry(why.reason.name().to_owned()).or_insert(0u64) += 1;
            assert_eq!(why.collision.is_some(), why.reason == RemovalReason::Obstacle);
            if let Some(c) = &why.collision {
                assert!(c.unit == 9 && c.depth_m > 0.05 && why.message.contains("m in unit bench (place 9"), "{why:?}");
            }
        }
    }
    let mut reported = editor.report().disabled.clone();
    reported.retain(|_, n| *n > 0);
    assert_eq!(counted, reported);
}

#[test]
fn the_same_world_comes_of_any_number_of_threads() {
    let m = MadeUp::new();
    let e = with(with(panels(3, 3), BENCH, 0.0, 0.8, 0.0), WALL, 3.0, 3.0, 0.4);
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| stitched(&m, &e, &config()).0)
    };
    assert_eq!(with_threads(1), with_threads(3));
}
