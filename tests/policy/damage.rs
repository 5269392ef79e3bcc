//! Spoilt tables are refused, and no bytes make a query panic.

use super::naive::{approach, random_model, solved};
use glam::Vec3;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use throng_core::policy::{
    ActionTable, BestActionJob, LookAheadGoal, LookAheadJob, NO_ACTION, PolicyRecord, PolicySlices, PolicyTable,
    RankedActions, SegmentRecord,
};
use throng_precompute::policy::{PolicyConfig, RewardForm};

/// Sound tables, to be spoilt.
fn sound() -> Parts {
    let mut rng = Pcg64::seed_from_u64(8);
    let tables = solved(&random_model(&mut rng, 3), &approach(4, 5, RewardForm::Max, 0.9), &PolicyConfig::default());
    let mut p = tables.policies.into_iter().next().expect("one policy");
    p.record.reward.own_errors = 0;
    (p.record, tables.action_offsets, tables.action_segments, p.segments, p.values, p.best, tables.action_errors)
}

/// What is spoilt, and how.
type Change<'a> = (&'a str, &'a dyn Fn(&mut Parts));
type Parts = (PolicyRecord, Vec<u32>, Vec<u32>, Vec<SegmentRecord>, Vec<f32>, Vec<u8>, Vec<f32>);

fn opens(parts: &Parts) -> bool {
    let (record, offsets, actions, segments, values, best, errors) = parts;
    let Ok(actions) = ActionTable::new(offsets, actions, errors, segments.len()) else { return false };
    PolicyTable::new(record, actions, slices(segments, values, best)).is_ok()
}

fn slices(segments: &[SegmentRecord], values: &[f32], best: &[u8]) -> PolicySlices {
    PolicySlices { segments: segments.into(), values: values.into(), best: best.into(), ..PolicySlices::default() }
}

#[test]
fn spoilt_tables_are_refused() {
    let good = sound();
    assert!(opens(&good));
    let spoilt = |f: &dyn Fn(&mut Parts)| {
        let mut parts = good.clone();
        f(&mut parts);
        !opens(&parts)
    };
    let changes: [Change; 23] = [
        ("value missing", &|p| p.4.truncate(1)),
        ("value too many", &|p| p.4.push(0.0)),
        ("value not finite", &|p| p.4[7] = f32::NAN),
        ("best missing", &|p| p.5.truncate(1)),
        ("best beyond the actions", &|p| p.5[0] = 200),
        ("no best at all", &|p| p.5[0] = NO_ACTION),
        ("segment missing", &|p| p.3.truncate(1)),
        ("end beyond the states", &|p| p.3[0].end = 3),
        ("weight negative", &|p| p.3[1].weights[2] = -1.0),
        ("discount one", &|p| p.3[1].discount = 1.0),
        ("action beyond the segments", &|p| p.2[0] = 7),
        ("offset descending", &|p| p.1[1] = 0),
        ("offsets empty", &|p| p.1.clear()),
        ("first offset not zero", &|p| p.1[0] = 1),
        ("states", &|p| p.0.num_states = 4),
        ("choices", &|p| p.0.num_choices = 0),
        ("own errors missing", &|p| p.0.reward.own_errors = 1),
        ("own errors unknown", &|p| p.0.reward.own_errors = 2),
        ("transition cost negative", &|p| p.0.reward.transition_cost = -0.1),
        ("transition cost where the gain is negative", &|p| p.0.reward.gain = -1.0),
        ("error missing", &|p| p.6.truncate(1)),
        ("error negative", &|p| p.6[1] = -0.1),
        ("error not finite", &|p| p.6[1] = f32::NAN),
    ];
    for (what, change) in changes {
        assert!(spoilt(change), "{what}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_bytes_are_refused_or_answer_without_a_panic(
        at in 0usize..96, byte in any::<u8>(), in_segment in any::<bool>(), target in any::<[f32; 3]>(), state in 0u32..5,
    ) {
        let mut parts = sound();
        if in_segment {
            bytemuck::cast_slice_mut::<SegmentRecord, u8>(&mut parts.3)[at] = byte;
        } else {
            bytemuck::bytes_of_mut(&mut parts.0)[at] = byte;
        }
        let (record, offsets, actions, segments, values, best, errors) = &parts;
        let actions = ActionTable::new(offsets, actions, errors, segments.len()).expect("untouched");
        if let Ok(policy) = PolicyTable::new(record, actions.clone(), slices(segments, values, best)) {
            let (states, targets) = ([state], [Vec3::from_array(target)]);
            let mut ranked = [RankedActions::NONE];
            let goals = [LookAheadGoal { policy: &policy, weights: &[1.0], targets: &targets }];
            let looked = LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run();
            let mut action = [0];
            let job = BestActionJob { policy: &policy, states: &states, targets: &targets, choice: 3, actions: &mut action };
            let loaded = job.run();
            prop_assert_eq!(looked.is_ok(), loaded.is_ok());
            if looked.is_ok() {
                let n = actions.segments_of(state).len();
                prop_assert!(usize::from(ranked[0].best()) < n && usize::from(action[0]) < n);
            }
        }
    }
}
