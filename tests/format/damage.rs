//! Damaged content with valid checksums: it is refused, or characters move through it with finite poses.

use super::patch::{Frame, Parts, open_unverified};
use crate::common::{bundle, orders, starts};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use throng_core::Bundle;
use throng_core::characters::{ActionChoice, Characters, CharactersConfig, MotionSet};
use throng_core::format::SectionEntry;
use throng_core::policy::MAX_ACTIONS;

/// Characters of a step.
const N: usize = 8;

/// Steps some characters with every way to choose, and looks at everything that is left to be read.
fn stays_steppable(tables: &Bundle, what: &str) {
    let motion_set = MotionSet::new(tables);
    let (starts, orders) = (starts(tables, N), orders(N));
    for choice in [ActionChoice::LookAhead { temperature: 0.1 }, ActionChoice::BestAction] {
        let config = CharactersConfig { choice, local_transforms: true, ..CharactersConfig::default() };
        let mut characters = Characters::new(&motion_set, config, &starts).expect("states exist");
        for step in 0..15 {
            characters.step(&motion_set, 0.1, &orders).expect("a step");
            let finite =
                characters.model_matrices().iter().all(|m| m.rows.as_flattened().iter().all(|v| v.is_finite()));
            assert!(finite, "{what}: step {step}, {choice:?}: a matrix is not finite");
            let finite = characters.local_transforms().iter().all(|l| l.rotation.iter().all(|v| v.is_finite()));
            assert!(finite, "{what}: step {step}, {choice:?}: a local rotation is not finite");
            for c in 0..N {
                let root = characters.root(c);
                assert!(root.x.is_finite() && root.z.is_finite() && root.heading.is_finite(), "{what}: root {root:?}");
            }
        }
    }
    let mut scores = [0.0; MAX_ACTIONS];
    let n = tables.policies()[0].action_scores(0, orders[0].target(), &mut scores).expect("state 0 exists");
    assert!(scores[..n].iter().all(|s| s.is_finite()), "{what}: a score is not finite");
}

#[test]
fn the_whole_bundle_is_steppable() {
    stays_steppable(&open_unverified(bundle()).expect("a whole bundle"), "undamaged");
}

/// Changes one to four neighbouring bytes of a section.
fn damage(bytes: &mut [u8], section: &SectionEntry, rng: &mut impl Rng) -> usize {
    let range = section.range(bytes.len() as u64).expect("a section of a whole bundle");
    let at = rng.random_range(range.clone());
    let run = if rng.random_bool(0.5) { 1 } else { 4 };
    for b in &mut bytes[at..(at + run).min(range.end)] {
        *b = match rng.random_range(0..4) {
            0 => 0,
            1 => 0xff,
            2 => *b ^ (1 << rng.random_range(0..8)),
            _ => rng.random_range(0..=255),
        };
    }
    at
}

#[test]
fn damaged_content_is_refused_or_stays_steppable() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    // This bundle has no hits and no adaptive policy, whose sections are empty.
    let rows: Vec<SectionEntry> = Frame::of(bundle()).rows.into_iter().filter(|row| row.count > 0).collect();
    let (mut refused, mut opened) = (0, 0);
    for round in 0..300 {
        let mut bytes = bundle().to_vec();
        let section = &rows[round % rows.len()];
        let at = damage(&mut bytes, section, &mut rng);
        match open_unverified(&bytes) {
            Err(_) => refused += 1,
            Ok(tables) => {
                opened += 1;
                stays_steppable(&tables, &format!("section {}, byte {at}", section.tag));
            }
        }
    }
    assert!(refused > 30 && opened > 30, "{refused} refused, {opened} opened: one side was hardly tried");
}

#[test]
fn values_as_large_as_the_checks_allow_stay_steppable() {
    use throng_core::bundle::tags;
    use throng_core::format::{FrameRow, SkeletonRecord};
    use throng_core::policy::SegmentRecord;
    let mut parts = Parts::of(bundle());
    // As far away, and turned as often: segments and sweeps lead where their frames do.
    parts.edit::<FrameRow>(tags::FRAMES, |rows| {
        for row in rows {
            let [x, z, heading] = row.planar;
            row.planar = [x + 9.9e3, z - 9.9e3, heading + 1590.0 * std::f32::consts::TAU];
            row.height = 900.0;
        }
    });
    parts.edit::<SkeletonRecord>(tags::SKELETON, |s| s[0].offsets.iter_mut().for_each(|o| *o = [9.9; 3]));
    parts.edit::<f32>(tags::POLICY_VALUES, |v| v.fill(-9e5));
    parts.edit::<SegmentRecord>(tags::POLICY_SEGMENTS, |s| s.iter_mut().for_each(|s| s.inner = [9e5; 4]));
    let tables = open_unverified(&parts.join()).expect("every number is within its limit");
    stays_steppable(&tables, "large numbers");
}
