//! World files: what is written is read again; damaged files, and those of another bundle, are refused.

use super::made_up_world;
use bytemuck::Pod;
use std::sync::OnceLock;
use throng_core::Bundle;
use throng_core::format::{AlignedBytes, FileHeader};
use throng_core::patch::NONE;
use throng_precompute::stitch;
use throng_world::{PathCosts, WORLD_MAGIC, WORLD_VERSION, World, WorldData, WorldError, WorldGraph};

fn world(tables: &Bundle) -> WorldData {
    made_up_world::world(tables, &["####", "#b##", "###."])
}

/// The file of a world, or of one that was damaged after its path costs were baked.
fn bytes(damaged: &WorldData) -> Vec<u8> {
    static PATHS: OnceLock<PathCosts> = OnceLock::new();
    let paths = PATHS.get_or_init(|| {
        let tables = made_up_world::tables();
        let graph = WorldGraph::new(tables.patches(), &world(&tables).tables()).expect("a world");
        PathCosts::bake(&graph).expect("path costs")
    });
    let mut out = Vec::new();
    damaged.write(paths, &mut out).expect("memory can be written");
    out
}

fn open(bytes: &[u8], tables: &Bundle) -> Result<World, WorldError> {
    World::from_bytes(AlignedBytes::from_slice(bytes), tables)
}

#[test]
fn what_is_written_is_read_again() {
    let tables = made_up_world::tables();
    let world = world(&tables);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made-up.world");
    std::fs::write(&path, bytes(&world)).unwrap();
    let file = World::open(&path, &tables).unwrap();
    let (a, b) = (file.view(), &world.tables());
    assert_eq!(a, b);
    assert_eq!(*file.meta(), world.meta);
    assert_eq!(file.num_bytes(), bytes(&world).len());
}

#[test]
fn a_world_of_another_file_is_not_replaced() {
    let (tables, folder) = (made_up_world::tables(), tempfile::tempdir().unwrap());
    let at = |name: &str| folder.path().join(name);
    let (one, other, out) = (at("square.toml"), at("more/square.toml"), at("tables/square.world"));
    for (path, text) in [(&one, "one"), (&other, "other")] {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    std::fs::create_dir(at("tables")).unwrap();
    stitch::check_replaced(&other, &out).unwrap();
    stitch::save(&mut world(&tables), &one, tables.patches(), &out).unwrap();
    assert_eq!(World::open(&out, &tables).unwrap().meta().source, "../square.toml");
    stitch::check_replaced(&one, &out).unwrap();
    let e = stitch::check_replaced(&other, &out).unwrap_err().to_string();
    assert!(e.contains("was stitched from ../square.toml") && e.contains("more/square.toml"), "{e}");
    assert!(e.contains("another `name`") && e.contains("--out"), "{e}");
    // What is damaged is nobody's; what is no world may be somebody's.
    std::fs::write(&out, WORLD_MAGIC).unwrap();
    stitch::check_replaced(&other, &out).unwrap();
    std::fs::write(&out, "no world").unwrap();
    let e = stitch::check_replaced(&other, &out).unwrap_err().to_string();
    assert!(e.contains("square.world: it is there and is not a world"), "{e}");
}

#[test]
#[allow(unsafe_code)]
fn a_world_that_is_open_does_not_see_what_happens_to_its_file() {
    let tables = made_up_world::tables();
    let world = world(&tables);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made-up.world");
    std::fs::write(&path, bytes(&world)).unwrap();
    // SAFETY: the file is replaced only after the map is gone.
    let mapped = unsafe { World::map(&path, &tables) }.unwrap().hash();
    let file = World::open(&path, &tables).unwrap();
    std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(64).unwrap();
    assert_eq!(file.view(), &world.tables());
    assert_eq!(file.hash(), mapped);
}

#[test]
fn another_bundle_is_refused_by_name() {
    let (tables, other) = (made_up_world::tables(), made_up_world::named("other"));
    assert_ne!(tables.hash(), other.hash());
    let e = open(&bytes(&world(&tables)), &other).unwrap_err();
    assert!(matches!(e, WorldError::OtherBundle { .. }));
    let message = e.to_string();
    assert!(
        message.contains("`made up`") && message.contains("`other`") && message.contains("throng stitch"),
        "{message}"
    );
}

#[test]
fn bundles_and_worlds_are_told_apart() {
    let tables = made_up_world::tables();
    let e = open(&made_up_world::bundle("made up"), &tables).unwrap_err();
    assert!(e.to_string().contains("not a Throng world"), "{e}");
    let e = Bundle::from_bytes(AlignedBytes::from_slice(&bytes(&world(&tables)))).unwrap_err();
    assert!(e.to_string().contains("not a Throng bundle"), "{e}");
}

#[test]
fn truncated_extended_and_flipped_files_are_refused() {
    let tables = made_up_world::tables();
    let whole = bytes(&world(&tables));
    for len in (0..whole.len()).step_by(whole.len() / 150 + 1) {
        assert!(open(&whole[..len], &tables).is_err(), "cut to {len}");
    }
    assert!(open(&[whole.as_slice(), &[0]].concat(), &tables).is_err());
    for at in (0..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x20;
        assert!(open(&bytes, &tables).is_err(), "flipped at {at}");
    }
    let mut header: FileHeader = bytemuck::pod_read_unaligned(&whole[..64]);
    header.version = WORLD_VERSION + 1;
    header.header_crc32 = header.checksum();
    let e = open(&[bytemuck::bytes_of(&header), &whole[64..]].concat(), &tables).unwrap_err();
    assert!(
        e.to_string().contains(&format!("version {}", WORLD_VERSION + 1)) && e.to_string().contains("stitch"),
        "{e}"
    );
}

type Damage = fn(&mut WorldData);

/// Records that cannot be, by what is wrong with them.
const DAMAGES: [(&str, Damage); 27] = [
    ("no such patch", |w| w.instances[3].patch = 2),
    ("an instance nowhere", |w| w.instances[3].placement.y = f32::NAN),
    ("an instance without units", |w| w.instances[3].num_resources = 0),
    ("cells' bits elsewhere", |w| w.instances[3].first_cell_word += 1),
    ("links' bits elsewhere", |w| w.instances[3].first_link_word += 1),
    ("adjacencies elsewhere", |w| w.instances[0].first_adjacency = 1),
    ("adjacencies past the end", |w| w.instances.last_mut().unwrap().num_adjacencies = 9),
    ("neighbours elsewhere", |w| w.instances[3].first_neighbour = 0),
    ("resources past the end", |w| w.instances.last_mut().unwrap().num_resources = u32::MAX),
    ("an instance less", |w| w.instances.truncate(w.instances.len() - 1)),
    ("bits left over", |w| w.link_words.push(0)),
    ("a neighbour that is none", |w| w.neighbours[0] = 2),
    ("a neighbour past the end", |w| w.neighbours[0] = 1000),
    ("a neighbour that does not know", |w| w.neighbours[0] = NONE),
    ("no such unit", |w| w.resources[2] = 1000),
    ("a unit nowhere", |w| w.units[2].placement.x = f32::INFINITY),
    ("an adjacency to no instance", |w| w.adjacencies[0].other = 1000),
    ("no such table", |w| w.adjacencies[0].table = 1),
    ("no such side", |w| w.adjacencies[0].side = 2),
    ("the wrong side", |w| w.adjacencies[0].side = 1),
    ("joints' bits past the end", |w| w.adjacencies.iter_mut().for_each(|a| a.first_word = 7)),
    ("an adjacency that only one has", |w| w.adjacencies[0].other = 0),
    ("a table of no patch", |w| w.tables[0].patch_a = 7),
    ("a tile on side b", |w| w.tables[0].patch_b = 0),
    ("no such link", |w| w.joints[1].a = 10_000),
    ("an offset past the link", |w| w.joints[1].a_offset = 50),
    ("joints by b twice", |w| w.joints_by_b[1] = 0),
];

#[test]
fn records_that_cannot_be_are_refused() {
    let tables = made_up_world::tables();
    for (what, damage) in DAMAGES {
        let mut world = world(&tables);
        damage(&mut world);
        let e = open(&bytes(&world), &tables).err().unwrap_or_else(|| panic!("{what}: opened"));
        assert!(e.to_string().contains("throng stitch"), "{what}: {e}");
    }
}

/// Changes one value of a section at a time.
fn scramble<T: Pod>(name: &str, tables: &Bundle, of: impl Fn(&mut WorldData) -> &mut Vec<T>) {
    let len = bytemuck::cast_slice::<T, u8>(of(&mut world(tables))).len();
    for at in (0..len).step_by(3) {
        for value in [0u8, 0xff, 0x80] {
            let mut world = world(tables);
            bytemuck::cast_slice_mut::<T, u8>(of(&mut world))[at] = value;
            // Refused, or as sound as any: walking all of it meets nothing that is not there.
            let bytes = bytes(&world);
            if let Ok(file) = open(&bytes, tables) {
                walk(&file, tables, name);
            }
        }
    }
}

fn walk(file: &World, tables: &Bundle, name: &str) {
    use throng_world::{WorldGraph, WorldNode};
    let graph = WorldGraph::new(tables.patches(), file.view()).unwrap();
    for instance in 0..graph.num_instances() as u32 {
        for cell in 0..graph.cells(instance).len() as u32 {
            graph.for_each_step(WorldNode { instance, cell }, |s| {
                assert!((s.to.instance as usize) < graph.num_instances(), "{name}: {s:?}");
                assert!(graph.place(s.to).is_moderate(1e6), "{name}: {s:?}");
            });
        }
    }
}

#[test]
fn no_damage_to_records_leads_out_of_their_tables() {
    let tables = made_up_world::tables();
    scramble("instances", &tables, |w| &mut w.instances);
    scramble("neighbours", &tables, |w| &mut w.neighbours);
    scramble("adjacencies", &tables, |w| &mut w.adjacencies);
    scramble("tables", &tables, |w| &mut w.tables);
    scramble("joints", &tables, |w| &mut w.joints);
    scramble("joints by b", &tables, |w| &mut w.joints_by_b);
    scramble("bits", &tables, |w| &mut w.cell_words);
    scramble("links", &tables, |w| &mut w.link_words);
    scramble("resources", &tables, |w| &mut w.resources);
    assert!(open(&bytes(&world(&tables)), &tables).is_ok());
}
