//! Small worlds made up in code: a floor of tiles that are crossed straight on or with a turn and stood on, where two give
//! each other something across edges, and benches that are sat on.

use crate::{AdjacencyRecord, InstanceRecord, JointRecord, JointTableRecord, UnitRecord, WorldData, WorldMeta};
use glam::Quat;
use throng_base::maths;
use throng_core::blend::{BlendRecord, ChannelRow, ExampleRecord, ReferenceRow};
use throng_core::format::{
    AlignedBytes, BundleWriter, ClipMeta, ClipRecord, FrameRow, Meta, PatchMeta, ROTATION_BYTES, RotationCode,
    SkeletonRecord,
};
use throng_core::graph::{MotionSegment, StateRecord};
use throng_core::patch::{
    CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PairRecord, PatchRecord, Placement,
};
use throng_core::planar::wrap_angle;
use throng_core::policy::{PathRecord, PolicyRecord, SegmentRecord, StateGridRecord};
use throng_core::{Bundle, Contacts, HitRecord, Joint, NUM_JOINTS, Planar, Skeleton, bundle::tags};

/// Length of a tile's side (m).
pub const SIDE: f32 = 2.0;
/// Number of the patch of a tile.
pub const FLOOR: u32 = 0;
/// Number of the patch of a bench.
pub const BENCH: u32 = 1;
/// Tag of links on which people talk.
pub const CHAT: u16 = 1;
/// Tag of links on which people sit.
pub const SIT: u16 = 2;
/// Tag of what two do together.
pub const GIVE: u16 = 3;

/// Edges: +x, -x, +z, -z.
const HEADINGS: [f32; 4] = [std::f32::consts::FRAC_PI_2, -std::f32::consts::FRAC_PI_2, 0.0, std::f32::consts::PI];
const OPPOSITE: [u32; 4] = [1, 0, 3, 2];
/// Distance of walking people from the middle of an edge, to its right (m).
const RIGHT: f32 = 0.3;
const WALK: u32 = 0;
const STAND: u32 = 1;
const SEATED: u32 = 2;
/// Frame of a straight crossing at which a bench may be turned to, or be left for it.
const AT_BENCH: u32 = 25;
/// Kinds of motion of the person that gives and the one that takes.
const GIVING: [usize; 2] = [9, 10];

/// Kind of motion: from `begin` to `end` relative to it, over a number of frames.
struct FloorMotion {
    name: &'static str,
    begin: Planar,
    /// Amplitude of a sway forward and back on the way (m).
    sway: f32,
    end: Planar,
    frames: u32,
    walking: bool,
}

fn kinds() -> Vec<FloorMotion> {
    let quarter = std::f32::consts::FRAC_PI_2;
    let kind = |name, x, z, heading, frames, walking| {
        let (begin, end) = (Planar::IDENTITY, Planar::new(x, z, heading));
        FloorMotion { name, begin, sway: 0.0, end, frames, walking }
    };
    // Two in one room: the second one faces the first.
    let give = |name, z, heading, sway| FloorMotion {
        begin: Planar::new(0.0, z, heading),
        sway,
        ..kind(name, 0.0, 0.0, 0.0, 60, false)
    };
    vec![
        kind("straight", 0.0, SIDE, 0.0, 50, true),
        // From the edge behind, right of its middle, out of the edge on the left or right, right of its middle.
        kind("left", 1.0 + RIGHT, 1.0 + RIGHT, quarter, 48, true),
        kind("right", -1.0 + RIGHT, 1.0 - RIGHT, -quarter, 36, true),
        kind("stop", RIGHT, 1.0, 0.0, 34, true),
        kind("idle", 0.0, 0.0, 0.0, 30, false),
        kind("chat", 0.0, 0.0, 0.0, 44, false),
        kind("start", -RIGHT, 1.0, 0.0, 32, true),
        kind("sit", 0.0, 0.3, 0.0, 30, false),
        kind("get-up", 0.0, -0.3, 0.0, 28, false),
        give("give", 0.0, 0.0, 0.2),
        give("take", SIDE, std::f32::consts::PI, 0.3),
    ]
}

/// Poses of one kind, with limbs that swing.
fn poses(kind: &FloorMotion, number: usize) -> Vec<[Quat; NUM_JOINTS]> {
    let swing = if kind.walking { 0.35 } else { 0.05 };
    (0..=kind.frames)
        .map(|f| {
            let s = f as f32 / kind.frames as f32;
            let mut pose = std::array::from_fn(|j: usize| {
                let a = swing * maths::sin(std::f32::consts::TAU * s * 2.0 + j as f32 * 0.7 + number as f32) * 0.4;
                maths::compose(
                    maths::compose(maths::rotation_x(a), maths::rotation_y(0.3 * a)),
                    maths::rotation_z(-0.2 * a),
                )
            });
            for (j, angle) in
                [(Joint::LeftThigh, -0.2), (Joint::LeftShin, 0.4), (Joint::RightThigh, -0.2), (Joint::RightShin, 0.4)]
            {
                pose[j.index()] = maths::rotation_x(angle);
            }
            pose
        })
        .collect()
}

/// Rows of one kind: an ease from start to end.
fn rows(kind: &FloorMotion, poses: &[[Quat; NUM_JOINTS]], code: &RotationCode) -> Vec<FrameRow> {
    let row = |(f, pose): (usize, &[Quat; NUM_JOINTS])| {
        let s = f as f32 / kind.frames as f32;
        let there = maths::sin(std::f32::consts::PI * s);
        let moved = Planar::new(kind.end.x * s, kind.end.z * s + kind.sway * there * there, kind.end.heading * s);
        let at = kind.begin.compose(moved);
        let mut row = FrameRow { planar: [at.x, at.z, at.heading], height: 0.93, rotations: [0; ROTATION_BYTES] };
        code.encode(pose, None, &mut row);
        row
    };
    poses.iter().enumerate().map(row).collect()
}

/// A bundle of motion patches alone.
pub fn tables() -> Bundle {
    named("made up")
}

/// Made-up bundle under another name, so that it is another bundle.
pub fn named(name: &str) -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(&bundle(name))).expect("the made-up bundle opens")
}

/// The bytes of the bundle.
pub fn bundle(name: &str) -> Vec<u8> {
    of_patches(name, &[floor(), bench()])
}

fn of_patches(name: &str, patches: &[FloorPatch; 2]) -> Vec<u8> {
    let kinds = kinds();
    let unit = |name: &str| vec![(name.to_owned(), Placement::IDENTITY)];
    let clip = |k: &FloorMotion| ClipMeta { name: k.name.into(), ..ClipMeta::default() };
    let meta = Meta {
        name: name.into(),
        rate_hz: 30.0,
        clips: kinds.iter().map(clip).collect(),
        patches: vec![
            PatchMeta { name: "floor".into(), units: unit("floor") },
            PatchMeta { name: "bench".into(), units: unit("bench") },
        ],
        link_tags: vec!["chat".into(), "sit".into(), "give".into()],
        pose_groups: 3,
        ..Meta::default()
    };
    let mut out = BundleWriter::new();
    out.section(tags::META, &meta.encode().expect("META encodes"));
    out.section(tags::SKELETON, &[SkeletonRecord::from(&Skeleton::default())]);
    let records: Vec<_> = (0..kinds.len()).map(|k| record(&kinds, k)).collect();
    out.section(tags::CLIPS, &records);
    let poses: Vec<_> = kinds.iter().enumerate().map(|(i, k)| poses(k, i)).collect();
    let all = poses.concat();
    let code = RotationCode::fit_frames(&Skeleton::default(), all.len(), |f, j| all[f][j]);
    let rows: Vec<FrameRow> = kinds.iter().zip(&poses).flat_map(|(k, p)| rows(k, p, &code)).collect();
    out.section(tags::FRAMES, &rows);
    out.section(tags::ROTATION_CODE, &[code]);
    let feet = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
    let contacts = |k: &FloorMotion| {
        vec![if k.sway > 0.0 || k.name == "idle" { feet } else { Contacts::NONE }; k.frames as usize + 1]
    };
    out.section(tags::CONTACTS, &kinds.iter().flat_map(contacts).collect::<Vec<_>>());
    out.section::<HitRecord>(tags::HITS, &[]);
    out.section::<StateRecord>(tags::STATES, &[]);
    out.section::<MotionSegment>(tags::SEGMENTS, &[]);
    out.section(tags::ACTION_OFFSETS, &[0u32]);
    out.section::<u32>(tags::ACTION_SEGMENTS, &[]);
    out.section::<f32>(tags::ACTION_ERRORS, &[]);
    out.section::<throng_core::stops::SweepRecord>(tags::SWEEPS, &[]);
    out.section::<throng_core::stops::SweepNode>(tags::SWEEP_NODES, &[]);
    out.section::<throng_core::stops::StopRecord>(tags::STOPS, &[]);
    out.section::<PolicyRecord>(tags::POLICIES, &[]);
    out.section::<SegmentRecord>(tags::POLICY_SEGMENTS, &[]);
    out.section::<PathRecord>(tags::POLICY_PATHS, &[]);
    out.section::<StateGridRecord>(tags::POLICY_STATE_GRIDS, &[]);
    out.section::<f32>(tags::POLICY_VALUES, &[]);
    out.section::<u8>(tags::POLICY_BEST, &[]);
    let (mut records, mut edges) = (Vec::new(), Vec::<EdgeRecord>::new());
    let (mut cells, mut links) = (Vec::<CellRecord>::new(), Vec::<LinkRecord>::new());
    for p in patches {
        records.push(PatchRecord {
            kind: p.kind,
            first_cell: cells.len() as u32,
            num_cells: p.cells.len() as u32,
            first_link: links.len() as u32,
            num_links: p.links.len() as u32,
            first_edge: edges.len() as u32,
            num_edges: p.edges.len() as u32,
            reserved: 0,
            min: [-1.0, 0.0, -1.0],
            max: [1.0, 1.8, 1.0],
        });
        edges.extend(&p.edges);
        cells.extend(&p.cells);
        links.extend(&p.links);
    }
    out.section(tags::PATCHES, &records);
    out.section(tags::PATCH_EDGES, &edges);
    out.section(tags::PATCH_CELLS, &cells);
    out.section(tags::PATCH_LINKS, &links);
    out.section(tags::PATCH_PAIRS, &pairs(&patches[FLOOR as usize]));
    out.section(tags::POSE_GROUPS, &vec![WALK; rows.len()]);
    out.section::<BlendRecord>(tags::BLENDS, &[]);
    out.section::<ExampleRecord>(tags::BLEND_EXAMPLES, &[]);
    out.section::<f32>(tags::BLEND_WEIGHTS, &[]);
    out.section::<ReferenceRow>(tags::BLEND_REFERENCES, &[]);
    out.section::<ChannelRow>(tags::BLEND_CHANNELS, &[]);
    let mut bytes = Vec::new();
    out.write(&mut bytes).expect("memory can be written");
    bytes
}

fn record(kinds: &[FloorMotion], k: usize) -> ClipRecord {
    let first_frame = kinds[..k].iter().map(|k| k.frames + 1).sum();
    ClipRecord { first_frame, num_frames: kinds[k].frames + 1, mirrored: 0, reserved: 0 }
}

struct FloorPatch {
    kind: u32,
    edges: Vec<EdgeRecord>,
    cells: Vec<CellRecord>,
    links: Vec<LinkRecord>,
}

/// Sorts links by their first cell, and assigns each cell its links.
fn patch(kind: u32, edges: Vec<EdgeRecord>, mut cells: Vec<CellRecord>, mut links: Vec<LinkRecord>) -> FloorPatch {
    links.sort_by_key(|l| l.from);
    for (i, c) in cells.iter_mut().enumerate() {
        c.first_link = links.partition_point(|l| l.from < i as u32) as u32;
        c.num_links = links.iter().filter(|l| l.from == i as u32).count() as u32;
    }
    FloorPatch { kind, edges, cells, links }
}

fn cell(at: Planar, group: u32, flags: u32) -> CellRecord {
    let placement = Placement::from_planar(at, 0.93);
    CellRecord { placement, group, edge: NONE, twin: NONE, flags, first_link: 0, num_links: 0, reserved: [0; 2] }
}

fn link(cells: &[CellRecord], from: u32, to: u32, kind: usize, tag: u16) -> LinkRecord {
    let kinds = kinds();
    let on_ground = |c: u32| Placement { y: 0.0, ..cells[c as usize].placement };
    let (start, mut end) = (on_ground(from), on_ground(to));
    let turned = start.heading + kinds[kind].end.heading;
    end.heading = turned + wrap_angle(end.heading - turned);
    let r = record(&kinds, kind);
    LinkRecord { from, to, frame: r.first_frame, num_frames: kinds[kind].frames as u16, tag, start, end }
}

/// Cells 0..4 are entries by edge, 4..8 exits by edge, 8..12 rest cells by heading.
fn floor() -> FloorPatch {
    let step = |e: usize| {
        let h = HEADINGS[e];
        EdgeRecord { step: [SIDE * maths::sin(h).round(), 0.0, SIDE * maths::cos(h).round()], opposite: OPPOSITE[e] }
    };
    let edges: Vec<_> = (0..4).map(step).collect();
    // Where someone with that heading crosses the edge behind or ahead: on the right, which is -x at heading 0.
    let at = |heading: f32, ahead: f32| {
        let p = Planar::new(0.0, 0.0, heading).compose(Planar::new(-RIGHT, ahead, 0.0));
        Planar::new(p.x, p.z, wrap_angle(heading))
    };
    let mut cells = Vec::new();
    for e in 0..4 {
        let inwards = HEADINGS[OPPOSITE[e] as usize];
        let twin = 4 + OPPOSITE[e];
        cells.push(CellRecord { edge: e as u32, twin, ..cell(at(inwards, -1.0), WALK, CellRecord::IS_ENTRY) });
    }
    for e in 0..4 {
        let twin = OPPOSITE[e];
        cells.push(CellRecord { edge: e as u32, twin, ..cell(at(HEADINGS[e], 1.0), WALK, CellRecord::IS_EXIT) });
    }
    cells.extend(HEADINGS.map(|h| cell(Planar::new(0.0, 0.0, h), STAND, CellRecord::IS_REST)));
    let mut links = Vec::new();
    for e in 0..4u32 {
        let heading = HEADINGS[OPPOSITE[e as usize] as usize];
        for f in (0..4u32).filter(|&f| f != e) {
            let turn = wrap_angle(HEADINGS[f as usize] - heading);
            let kind = if turn.abs() < 0.1 {
                0
            } else if turn > 0.0 {
                1
            } else {
                2
            };
            links.push(link(&cells, e, 4 + f, kind, 0));
        }
        links.push(link(&cells, e, 8 + OPPOSITE[e as usize], 3, 0));
        for f in 0..4 {
            links.push(link(&cells, 8 + e, 4 + f, 6, 0));
        }
        links.push(link(&cells, 8 + e, 8 + e, 4, 0));
        links.push(link(&cells, 8 + e, 8 + e, 5, CHAT));
        for kind in GIVING {
            links.push(link(&cells, 8 + e, 8 + e, kind, GIVE | LinkRecord::FOR_TWO));
        }
    }
    patch(KIND_TILE, edges, cells, links)
}

/// Action of two across each edge: the first person in the tile, the second one beyond the edge, facing back.
fn pairs(floor: &FloorPatch) -> Vec<PairRecord> {
    let kinds = kinds();
    let plays = |l: &LinkRecord, cell: u32, kind: usize| l.from == cell && l.frame == record(&kinds, kind).first_frame;
    let number = |cell: u32, kind: usize| floor.links.iter().position(|l| plays(l, cell, kind)).expect("a link") as u32;
    let pair = |edge: u32| PairRecord {
        patch: FLOOR,
        edge,
        link: number(8 + edge, GIVING[0]),
        partner_link: number(8 + OPPOSITE[edge as usize], GIVING[1]),
    };
    (0..4).map(pair).collect()
}

/// Cell 0 is walked into, 1 sat on, 2 walked out of. The bench is turned to where a straight crossing in +z passes.
fn bench() -> FloorPatch {
    let cells = vec![
        cell(Planar::new(-RIGHT, 0.0, 0.0), WALK, 0),
        cell(Planar::new(0.4, 0.3, 0.0), SEATED, CellRecord::IS_REST),
        cell(Planar::new(-RIGHT, 0.0, 0.0), WALK, 0),
    ];
    let links =
        vec![link(&cells, 0, 1, 7, 0), link(&cells, 1, 1, 4, 0), link(&cells, 1, 1, 5, SIT), link(&cells, 1, 2, 8, 0)];
    patch(KIND_BLOCK, Vec::new(), cells, links)
}

/// A world of tiles where `rows` have `#` or `b`, which has a bench too; what cannot be left anywhere is disabled.
/// The first row is that of the lowest z.
pub fn world(tables: &Bundle, rows: &[&str]) -> WorldData {
    let patches = tables.patches();
    let mut w = WorldData::default();
    let mut tiles = Vec::new();
    let mut number = std::collections::BTreeMap::new();
    for (z, row) in rows.iter().enumerate() {
        for (x, c) in row.chars().enumerate().filter(|(_, c)| *c != '.') {
            number.insert((x as i32, z as i32), tiles.len() as u32);
            tiles.push((x as i32, z as i32, c == 'b'));
        }
    }
    let place = |x: i32, z: i32| Placement::new(x as f32 * SIDE, 0.0, z as f32 * SIDE, 0.0);
    for &(x, z, _) in &tiles {
        let around = [(x + 1, z), (x - 1, z), (x, z + 1), (x, z - 1)].map(|at| *number.get(&at).unwrap_or(&NONE));
        add(&mut w, tables, FLOOR, place(x, z));
        w.neighbours.extend(around);
        let r = *w.instances.last().expect("the tile");
        for (e, _) in around.iter().enumerate().filter(|(_, n)| **n == NONE) {
            for cell in [e as u32, 4 + e as u32] {
                clear(&mut w.cell_words, r.first_cell_word, cell);
            }
        }
        let dead = |c: u32| c < 8 && around[c as usize % 4] == NONE;
        for (k, l) in patches.links_of(FLOOR as usize).iter().enumerate() {
            if dead(l.from) || dead(l.to) || l.tag == CHAT {
                clear(&mut w.link_words, r.first_link_word, k as u32);
            }
        }
    }
    benches(&mut w, tables, &tiles);
    w.meta = WorldMeta {
        name: "made up".into(),
        bundle: tables.meta().name.clone(),
        bundle_hash: tables.hash(),
        ..WorldMeta::default()
    };
    w.check(patches).expect("the made-up world is sound");
    w
}

fn benches(w: &mut WorldData, tables: &Bundle, tiles: &[(i32, i32, bool)]) {
    if !tiles.iter().any(|t| t.2) {
        return;
    }
    let links = tables.patches().links_of(FLOOR as usize);
    // The straight crossing from the edge behind (-z) to the one ahead (+z).
    let straight = links.iter().position(|l| (l.from, l.to) == (3, 4 + 2)).expect("a straight link") as u32;
    let joint = |b| JointRecord { a: straight, a_offset: AT_BENCH, b, reserved: 0 };
    w.joints = vec![joint(0), joint(2)];
    w.joints_by_b = vec![0, 1];
    w.tables = vec![JointTableRecord {
        patch_a: FLOOR,
        patch_b: BENCH,
        first_joint: 0,
        num_joints: 2,
        placement: Placement::IDENTITY,
    }];
    for (t, &(x, z, _)) in tiles.iter().enumerate().filter(|(_, t)| t.2) {
        // Only where the crossing itself is there.
        let around = &w.neighbours[4 * t..][..4];
        assert!(around[2] != NONE && around[3] != NONE, "a bench at {x}, {z} cannot be come to");
        let first_word = w.joint_words.len() as u32;
        // From the tile over joint 0, back over joint 1.
        w.joint_words.push(0b1001);
        let bench = w.instances.len() as u32;
        add(w, tables, BENCH, Placement::new(x as f32 * SIDE, 0.0, z as f32 * SIDE, 0.0));
        w.adjacencies.push(AdjacencyRecord { other: bench, table: 0, side: 0, first_word });
    }
    let num_tiles = tiles.len();
    let mut next = 0;
    for i in 0..w.instances.len() {
        w.instances[i].first_adjacency = next;
        let has = i >= num_tiles || tiles[i].2;
        w.instances[i].num_adjacencies = u32::from(has);
        next += u32::from(has);
    }
    let of_tiles = w.adjacencies.clone();
    for a in &of_tiles {
        let tile =
            w.instances.iter().position(|i| i.num_adjacencies == 1 && of_tiles[i.first_adjacency as usize] == *a);
        w.adjacencies.push(AdjacencyRecord { other: tile.expect("the tile") as u32, side: 1, ..*a });
    }
}

/// An instance with everything enabled, and a unit of its own.
fn add(w: &mut WorldData, tables: &Bundle, patch: u32, placement: Placement) {
    let p = &tables.patches().patches[patch as usize];
    w.instances.push(InstanceRecord {
        patch,
        first_neighbour: w.neighbours.len() as u32,
        placement,
        first_cell_word: w.cell_words.len() as u32,
        first_link_word: w.link_words.len() as u32,
        first_adjacency: 0,
        num_adjacencies: 0,
        first_resource: w.resources.len() as u32,
        num_resources: 1,
    });
    w.cell_words.extend(set_bits(p.num_cells));
    w.link_words.extend(set_bits(p.num_links));
    w.resources.push(w.units.len() as u32);
    w.units.push(UnitRecord { unit: patch, placement });
}

fn set_bits(n: u32) -> Vec<u64> {
    let word = |w: u32| if n - 64 * w >= 64 { u64::MAX } else { (1 << (n - 64 * w)) - 1 };
    (0..n.div_ceil(64)).map(word).collect()
}

fn clear(words: &mut [u64], first: u32, index: u32) {
    words[first as usize + index as usize / 64] &= !(1 << (index % 64));
}

/// Number of joints of a pose.
pub const JOINTS: usize = NUM_JOINTS;

#[cfg(test)]
mod tests {
    use super::*;

    /// Error message of a bundle whose floor has been changed.
    fn refused(change: impl FnOnce(&mut FloorPatch)) -> String {
        let mut patches = [floor(), bench()];
        change(&mut patches[0]);
        let bytes = AlignedBytes::from_slice(&of_patches("changed", &patches));
        Bundle::from_bytes(bytes).map_or_else(|e| e.to_string(), |_| String::new())
    }

    #[test]
    fn tiles_with_more_edges_than_a_set_has_bits_are_refused() {
        let with = |num: u32| {
            refused(|p| {
                let step = |e: u32| [4.0 + (e / 2) as f32, 0.0, 1.0].map(|v| if e.is_multiple_of(2) { v } else { -v });
                p.edges.extend((4..num).map(|e| EdgeRecord { step: step(e), opposite: e ^ 1 }));
            })
        };
        assert_eq!(with(30), "");
        assert!(with(32).contains("it has 32 edges, expected 31 at most"), "{}", with(32));
    }

    #[test]
    fn what_two_do_has_frames_to_begin_and_to_do_it() {
        let with = |num_frames: u16| {
            refused(|p| p.links.iter_mut().filter(|l| l.is_for_two()).for_each(|l| l.num_frames = num_frames))
        };
        assert_eq!(with(2), "");
        assert!(with(1).contains("expected 2 or more"), "{}", with(1));
    }
}
