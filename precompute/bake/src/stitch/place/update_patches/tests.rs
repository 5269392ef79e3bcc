//! Environments changed at random, laid again near the change and all over.

use super::*;
use crate::environment::{PlacedUnit, UnitSet, geometries};
use crate::stitch::config::StitchConfig;
use crate::stitch::library::Library;
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::path::Path;
use throng_core::Skeleton;
use throng_core::format::PatchMeta;
use throng_core::patch::{EdgeRecord, KIND_BLOCK, KIND_TILE, PatchRecord, PatchTables, Placement};

const UNITS: &str = "[[units]]\nname = \"panel\"\nsymmetry = 4\nfloor = true\nshapes = [{ box = { at = [0.0, -0.05, 0.0], \
                     size = [1.0, 0.1, 1.0] } }]\n[[units]]\nname = \"step\"\nshapes = [{ box = { at = [0.0, 0.2, 0.0], \
                     size = [0.6, 0.4, 0.3] } }]\n[[units]]\nname = \"post\"\nsymmetry = 2\nshapes = [{ box = { at = \
                     [0.0, 0.5, 0.0], size = [0.1, 1.0, 0.1] } }]\n";
const PANEL: usize = 0;
const STEP: usize = 1;
const POST: usize = 2;

/// Patches of a panel, of a step, of two and of three of them, and of a step beside a post.
fn with<T>(look: impl FnOnce(&Placer<'_>) -> T) -> T {
    let units = UnitSet::parse(UNITS, Path::new("u.toml")).expect("units");
    let geometries = geometries(&units).expect("shapes");
    let at = |x: f32, y: f32, z: f32, heading: f32| Placement::new(x, y, z, heading);
    let sets: [&[(&str, Placement)]; 5] = [
        &[("panel", Placement::IDENTITY)],
        &[("step", Placement::IDENTITY)],
        &[("step", Placement::IDENTITY), ("step", at(0.0, 0.2, 0.4, 0.0))],
        &[("step", Placement::IDENTITY), ("step", at(0.0, 0.2, 0.4, 0.0)), ("step", at(0.0, 0.4, 0.8, 0.0))],
        &[("post", Placement::IDENTITY), ("step", at(1.0, 0.0, 0.0, 0.5))],
    ];
    let name = |(k, set): (usize, &&[(&str, Placement)])| PatchMeta {
        name: k.to_string(),
        units: set.iter().map(|(name, at)| ((*name).to_owned(), *at)).collect(),
    };
    let names: Vec<PatchMeta> = sets.iter().enumerate().map(name).collect();
    let patch = |k: usize| PatchRecord {
        kind: if k == 0 { KIND_TILE } else { KIND_BLOCK },
        first_cell: 0,
        num_cells: 0,
        first_link: 0,
        num_links: 0,
        first_edge: 0,
        num_edges: if k == 0 { 4 } else { 0 },
        reserved: 0,
        min: [-0.9, 0.0, -0.8],
        max: [0.9, 1.8, 0.7 + 0.2 * k as f32],
    };
    let records: Vec<PatchRecord> = (0..sets.len()).map(patch).collect();
    let edge = |step, opposite| EdgeRecord { step, opposite };
    let edges =
        [edge([1.0, 0.0, 0.0], 1), edge([-1.0, 0.0, 0.0], 0), edge([0.0, 0.0, 1.0], 3), edge([0.0, 0.0, -1.0], 2)];
    let skeleton = Skeleton::default();
    let library = Library { names: &names, geometries: &geometries, ..Library::without_motion(&units, &skeleton) };
    let patches = PatchTables {
        patches: (&records).into(),
        edges: (&edges).into(),
        cells: [].as_slice().into(),
        links: [].as_slice().into(),
        pairs: [].as_slice().into(),
    };
    let config = StitchConfig { obstacles: vec!["post".into()], ..StitchConfig::default() };
    look(&Placer::new(&patches, library, &config).expect("a placer"))
}

/// What is said to be as it was is.
fn is_kept(before: &PlacedPatches, updated: &UpdatedPlacement) -> Result<(), TestCaseError> {
    let (placed, kept) = (&updated.patches, &updated.kept);
    let pair = |placed: &PlacedPatches, k: usize| {
        let (a, b, relation) = placed.pairs[k];
        ([a, b].map(|i| placed.fitted[i as usize].placement), relation)
    };
    for (k, &was) in kept.previous_pair_of.iter().enumerate().filter(|(_, was)| **was != NONE) {
        prop_assert_eq!(pair(placed, k), pair(before, was as usize));
    }
    let around =
        |placed: &PlacedPatches, i: u32| placed.obstacles.iter().filter(|o| o.0 == i).map(|o| o.2).collect::<Vec<_>>();
    for (i, &was) in (0u32..).zip(&kept.previous_of).filter(|(i, _)| kept.is_alike[*i as usize]) {
        prop_assert_eq!(around(placed, i), around(before, was));
    }
    // All relations that are not there any more are named, and all that are new.
    let relations = |of: &[(u32, u32, RelativePlacement)]| of.iter().map(|p| p.2).collect::<BTreeSet<_>>();
    for (k, [old, new]) in
        [[&before.pairs, &placed.pairs], [&before.obstacles, &placed.obstacles]].into_iter().enumerate()
    {
        let named: BTreeSet<_> = kept.removed[k].iter().copied().collect();
        prop_assert!(relations(old).difference(&relations(new)).all(|r| named.contains(r)));
    }
    let new: BTreeSet<_> = kept.new_obstacles.iter().copied().collect();
    prop_assert!(relations(&placed.obstacles).difference(&relations(&before.obstacles)).all(|r| new.contains(r)));
    Ok(())
}

/// A place where things often fit each other, or nearly.
fn place() -> impl Strategy<Value = Placement> {
    (0i32..5, 0i32..3, 0i32..8, 0i32..4, prop::sample::select(vec![0.0f32, 0.0, 0.0, 0.015, 0.03])).prop_map(
        |(x, y, z, turn, off)| Placement::new(x as f32 + off, 0.2 * y as f32, 0.4 * z as f32 - off, turn as f32 * 0.5),
    )
}

fn unit() -> impl Strategy<Value = PlacedUnit> {
    (prop::sample::select(vec![STEP, STEP, STEP, POST]), place())
        .prop_map(|(unit, placement)| PlacedUnit { unit, placement })
}

proptest! {
    #[test]
    fn what_meets_near_a_change_is_what_meets_all_over(
        units in prop::collection::vec(unit(), 0..12),
        changes in prop::collection::vec((0usize..5, 0usize..99, unit()), 1..12),
    ) {
        let panels = (0..12).map(|k| {
            let at = Placement::new((k % 3) as f32, 0.0, (k / 3) as f32, 0.0);
            PlacedUnit { unit: PANEL, placement: at }
        });
        with(|placer| {
            let mut environment = Environment { name: "e".into(), units: panels.collect() };
            let mut placed = placer.place_patches(&environment).expect("panels");
            // What is refused is left out.
            let grown = units.into_iter().map(|unit| (3, 0, unit));
            for (what, which, unit) in grown.chain(changes) {
                let index = which % environment.units.len();
                let edit = match what {
                    0 => EnvironmentEdit::Remove { index },
                    1 | 2 => EnvironmentEdit::Move { index, placement: unit.placement },
                    _ => EnvironmentEdit::Insert { index, unit },
                };
                let mut changed = environment.clone();
                let back = edit.apply(&mut changed.units);
                match (placer.update_patches(&changed, &placed, &back), placer.place_patches(&changed)) {
                    (Some(updated), Ok(anew)) => {
                        prop_assert_eq!(&updated.patches, &anew);
                        for (f, &was) in anew.fitted.iter().zip(&updated.kept.previous_of).filter(|(_, was)| **was != NONE) {
                            prop_assert_eq!(f.placement, placed.fitted[was as usize].placement);
                        }
                        is_kept(&placed, &updated)?;
                        (environment, placed) = (changed, anew);
                    }
                    // Copies that are near each other, turned another way.
                    (None, Ok(anew)) => (environment, placed) = (changed, anew),
                    (updated, Err(_)) => prop_assert!(updated.is_none()),
                }
            }
            Ok(())
        })?;
    }

    #[test]
    fn only_what_is_changed_is_new(to in 1i32..9) {
        with(|placer| {
            let step = |z: f32| PlacedUnit { unit: STEP, placement: Placement::new(9.0, 0.2 * z, 0.4 * z, 0.0) };
            let mut units: Vec<_> = (0..3).map(|k| step(k as f32)).collect();
            units.push(PlacedUnit { unit: STEP, placement: Placement::new(-9.0, 0.0, 0.0, 0.0) });
            let mut environment = Environment { name: "e".into(), units };
            let placed = placer.place_patches(&environment).expect("steps");
            let placement = Placement::new(-9.0, 0.0, to as f32, 0.0);
            let back = EnvironmentEdit::Move { index: 3, placement }.apply(&mut environment.units);
            let updated = placer.update_patches(&environment, &placed, &back).expect("it is free");
            let new: Vec<_> = (0..placed.fitted.len()).filter(|&i| updated.kept.previous_of[i] == NONE).collect();
            prop_assert_eq!(new, [placed.fitted.len() - 1]);
            Ok(())
        })?;
    }
}
