//! Bundles with motion patches: a motion graph may be absent, and patches that cannot be are refused.

use super::made_up_world as made_up;
use super::parts::{Parts, refusal};
use throng_core::characters::{CharacterStart, Characters, CharactersConfig, MotionSet};
use throng_core::patch::{CellRecord, EdgeRecord, KIND_BLOCK, KIND_TILE, LinkRecord, NONE, PairRecord, PatchRecord};
use throng_core::{Planar, bundle::tags};

#[test]
fn patches_need_no_motion_graph() {
    let tables = made_up::tables();
    let patches = tables.patches();
    assert_eq!(patches.patches.len(), 2);
    assert_eq!((patches.patches[0].kind, patches.patches[1].kind), (KIND_TILE, KIND_BLOCK));
    assert_eq!((patches.cells_of(0).len(), patches.links_of(1).len()), (12, 4));
    assert_eq!(tables.pose_groups().len(), tables.frames().len());
    let motion_set = MotionSet::new(&tables);
    let start = CharacterStart { root: Planar::IDENTITY, state: 0 };
    assert!(
        Characters::new(&motion_set, CharactersConfig::default(), &[start]).is_err(),
        "there is no state to start in"
    );
}

#[test]
fn a_bundle_with_neither_graph_nor_patches_is_refused() {
    let mut parts = Parts::of(&made_up::bundle("empty"));
    parts.edit::<PatchRecord>(tags::PATCHES, Vec::clear);
    parts.edit::<EdgeRecord>(tags::PATCH_EDGES, Vec::clear);
    parts.edit::<CellRecord>(tags::PATCH_CELLS, Vec::clear);
    parts.edit::<LinkRecord>(tags::PATCH_LINKS, Vec::clear);
    parts.edit::<PairRecord>(tags::PATCH_PAIRS, Vec::clear);
    parts.edit_meta(|m| m.patches.clear());
    let e = refusal(&parts.join(), "neither");
    assert!(e.to_string().contains("neither a motion graph nor a motion patch"), "{e}");
}

#[test]
fn other_content_has_another_hash() {
    let whole = made_up::bundle("a");
    let mut parts = Parts::of(&whole);
    parts.edit::<LinkRecord>(tags::PATCH_LINKS, |l| l[3].start.x += 1e-3);
    let open = |bytes: &[u8]| super::parts::open(bytes).expect("a sound bundle");
    let first = open(&whole);
    assert!(first.hash() != open(&parts.join()).hash() && !first.is_same(&open(&parts.join())));
    assert!(first.is_same(&open(&made_up::bundle("a"))) && first.is_same(&first.clone()));
}

fn patch(change: fn(&mut PatchRecord)) -> impl Fn(&mut Parts) {
    move |p| p.edit::<PatchRecord>(tags::PATCHES, |v| change(&mut v[1]))
}

fn edge(change: fn(&mut EdgeRecord)) -> impl Fn(&mut Parts) {
    move |p| p.edit::<EdgeRecord>(tags::PATCH_EDGES, |v| change(&mut v[1]))
}

/// Cell 1 is an entry, 5 an exit, 9 a rest cell.
fn cell(index: usize, change: fn(&mut CellRecord)) -> impl Fn(&mut Parts) {
    move |p| p.edit::<CellRecord>(tags::PATCH_CELLS, |v| change(&mut v[index]))
}

fn link(change: fn(&mut LinkRecord)) -> impl Fn(&mut Parts) {
    move |p| p.edit::<LinkRecord>(tags::PATCH_LINKS, |v| change(&mut v[2]))
}

fn pair(change: fn(&mut PairRecord)) -> impl Fn(&mut Parts) {
    move |p| p.edit::<PairRecord>(tags::PATCH_PAIRS, |v| change(&mut v[1]))
}

#[test]
fn what_two_cannot_do_together_is_refused() {
    #[expect(clippy::type_complexity, reason = "what it is, and what is done")]
    let damages: [(&str, &dyn Fn(&mut Parts)); 8] = [
        ("no such patch", &pair(|p| p.patch = 7)),
        ("a patch without edges", &pair(|p| p.patch = 1)),
        ("no such edge", &pair(|p| p.edge = 4)),
        ("no such link", &pair(|p| p.link = 999)),
        ("a link of one alone", &pair(|p| p.partner_link = 0)),
        ("the same twice", &|p| p.edit::<PairRecord>(tags::PATCH_PAIRS, |v| v[1] = v[0])),
        ("links that show nothing", &|p| {
            p.edit::<LinkRecord>(tags::PATCH_LINKS, |v| {
                v.iter_mut().filter(|l| l.is_for_two()).for_each(|l| l.tag = LinkRecord::FOR_TWO);
            });
        }),
        ("links of unequal length", &|p| {
            p.edit::<LinkRecord>(tags::PATCH_LINKS, |v| {
                v.iter_mut().filter(|l| l.is_for_two()).take(1).for_each(|l| l.num_frames -= 1);
            });
        }),
    ];
    for (what, damage) in damages {
        let mut parts = Parts::of(&made_up::bundle("made up"));
        damage(&mut parts);
        refusal(&parts.join(), what);
    }
}

#[test]
fn patches_that_cannot_be_are_refused() {
    #[expect(clippy::type_complexity, reason = "what it is, and what is done")]
    let damages: [(&str, &dyn Fn(&mut Parts)); 31] = [
        ("no such kind", &patch(|p| p.kind = 2)),
        ("a block with edges", &patch(|p| p.num_edges = 1)),
        ("cells elsewhere", &patch(|p| p.first_cell += 1)),
        ("cells past the end", &patch(|p| p.num_cells += 1)),
        ("cells left over", &patch(|p| p.num_cells -= 1)),
        ("links past the end", &patch(|p| p.num_links = u32::MAX)),
        ("reserved", &patch(|p| p.reserved = 1)),
        ("bounds upside down", &patch(|p| p.min[1] = 5.0)),
        ("bounds that are not numbers", &patch(|p| p.max[0] = f32::NAN)),
        ("no such opposite", &edge(|e| e.opposite = 9)),
        ("its own opposite", &edge(|e| e.opposite = 1)),
        ("a step that does not come back", &edge(|e| e.step[0] += 0.1)),
        ("a cell nowhere", &cell(9, |c| c.placement.z = f32::INFINITY)),
        ("no such group", &cell(9, |c| c.group = 3)),
        ("flags that are not known", &cell(9, |c| c.flags |= 8)),
        ("rest on an edge", &cell(1, |c| c.flags |= CellRecord::IS_REST)),
        ("entry and exit", &cell(1, |c| c.flags |= CellRecord::IS_EXIT)),
        ("no such edge", &cell(1, |c| c.edge = 4)),
        ("no such twin", &cell(1, |c| c.twin = 99)),
        ("a twin on another edge", &cell(1, |c| c.twin = 5)),
        ("an edge inside", &cell(9, |c| c.edge = 0)),
        ("links that do not follow", &cell(9, |c| c.first_link += 1)),
        ("rest that cannot be kept", &cell(10, |c| c.num_links = 0)),
        ("a link of another cell", &link(|l| l.from = 1)),
        ("a link to no cell", &link(|l| l.to = 12)),
        ("a link without frames", &link(|l| l.num_frames = 0)),
        ("a link past its clip", &link(|l| l.num_frames = 60)),
        ("a link past all clips", &link(|l| l.frame = u32::MAX)),
        ("no such tag", &link(|l| l.tag = 4)),
        ("a link nowhere", &link(|l| l.end.heading = f32::NAN)),
        ("no such group of a frame", &|p: &mut Parts| p.edit::<u32>(tags::POSE_GROUPS, |g| g[5] = 3)),
    ];
    for (what, damage) in damages {
        let mut parts = Parts::of(&made_up::bundle("damaged"));
        damage(&mut parts);
        refusal(&parts.join(), what);
    }
    let mut parts = Parts::of(&made_up::bundle("damaged"));
    parts.edit::<u32>(tags::POSE_GROUPS, |g| g[5] = NONE);
    assert!(super::parts::open(&parts.join()).is_ok(), "a frame without a group");
    for (what, change) in [
        ("a name less", (|m| drop(m.patches.pop())) as fn(&mut throng_core::format::Meta)),
        ("a name twice", |m| m.patches[1].name = m.patches[0].name.clone()),
        ("a patch without units", |m| m.patches[0].units.clear()),
        ("fewer groups", |m| m.pose_groups = 1),
    ] {
        let mut parts = Parts::of(&made_up::bundle("damaged"));
        parts.edit_meta(change);
        refusal(&parts.join(), what);
    }
}
