//! Going back, taking a hand in, and asking why.

use super::*;

const DT: f32 = 1.0 / 60.0;

#[test]
fn a_restored_characters_repeats_what_followed_bit_by_bit() {
    let r = MotionSet::new(&tables());
    let n = 21;
    let orders = orders(n);
    let config =
        CharactersConfig { choice: ActionChoice::LookAhead { temperature: 0.5 }, ..CharactersConfig::default() };
    let mut characters = Characters::new(&r, config, &starts(n)).unwrap();
    for _ in 0..37 {
        characters.step(&r, DT, &orders).unwrap();
    }
    let kept = characters.snapshot();
    let seen = characters.model_matrices().to_vec();
    let mut record = Vec::new();
    for _ in 0..100 {
        characters.step(&r, DT, &orders).unwrap();
        record.push(characters.model_matrices().to_vec());
    }
    characters.restore(&r, &kept).unwrap();
    let moved = seen.iter().zip(characters.model_matrices()).map(|(a, b)| (a.translation() - b.translation()).length());
    assert!(moved.fold(0.0, f32::max) < 1e-5, "poses are there at once");
    for poses in &record {
        characters.step(&r, DT, &orders).unwrap();
        assert!(characters.model_matrices() == poses.as_slice());
    }
    let refused = |characters: &mut Characters, r: &MotionSet, kept: &CharactersSnapshot| {
        let before = characters.model_matrices().to_vec();
        let e = characters.restore(r, kept).unwrap_err();
        assert!(matches!(e, throng_base::Error::Snapshot { .. }) && characters.model_matrices() == before, "{e}");
    };
    refused(&mut Characters::new(&r, config, &starts(n - 1)).unwrap(), &r, &kept);
    let other = MotionSet::new(&tables_with(&[blows::hit(5)]));
    refused(&mut Characters::new(&other, config, &starts(n)).unwrap(), &other, &kept);
    refused(&mut characters, &other, &kept);
    let bad: [fn(&mut block::MotionBlock, &mut block::BodyBlock); 15] = [
        |b, _| b.segment[3] = 900,
        |b, _| b.first[3] += 1,
        |b, _| b.time[3] = f32::NAN,
        |b, _| b.name[3] = 9,
        |b, _| b.choice_state[3] = 77,
        |_, b| b.state.reaction.head.place[1][3] = f32::INFINITY,
        |b, _| b.lift[3] = 1.0,
        |b, _| b.turn[3] = 9e6,
        |b, _| b.drift_from[3] = -9e6,
        |b, _| b.drift[0][3] = -9e6,
        |b, _| b.drift[1][3] = 1e-3,
        |b, _| b.bend[3] = 1.0,
        |b, _| b.change[1][3] = 2 * FRAMES,
        |_, b| b.state.reaction.trunk.place[0][3] = 9e6,
        |_, b| b.state.reaction.trunk.velocity[0][3] = 9e6,
    ];
    for spoil in bad {
        let mut kept = kept.clone();
        kept.spoil_first_block(spoil);
        refused(&mut characters, &r, &kept);
    }
}

#[test]
fn the_last_choice_is_the_state_and_place_the_segment_began_at() {
    let (r, mut characters, orders) = moving(&tables(), 9);
    assert!((0..9).all(|c| characters.last_choice(c).is_none()));
    for _ in 0..200 {
        characters.step(&r, DT, &orders).unwrap();
        for c in 0..9 {
            let (segment, frames) = characters.segment(c);
            let choice = characters.last_choice(c).unwrap();
            assert!(r.graph.segments_of(choice.state).contains(&segment));
            // Unbent motion: from the place of the choice, the segment's frames lead to the root.
            let start = r.graph.segments[segment as usize].start;
            let (from, to) = (r.planar_root(start), r.planar_root(start + frames.round() as u32));
            let (root, led) = (characters.root(c), choice.root.compose(from.to_local(to)));
            assert!((root.x - led.x).hypot(root.z - led.z) < 0.04, "{root:?} {led:?}");
        }
    }
}

#[test]
fn a_played_segment_starts_at_once_and_without_a_jump() {
    let (r, mut characters, orders) = moving(&tables(), 3);
    let dt = 1.0 / 240.0;
    for _ in 0..50 {
        characters.step(&r, dt, &orders).unwrap();
    }
    let others = [characters.segment(0).0, characters.segment(2).0];
    let new = (characters.segment(1).0 + 2) % 4;
    let before = characters.joint_positions(1);
    characters.play(&r, 1, new).unwrap();
    assert_eq!(characters.segment(1), (new, 0.0));
    assert!(characters.last_choice(1).is_none());
    assert_eq!(others, [characters.segment(0).0, characters.segment(2).0]);
    characters.step(&r, dt, &orders).unwrap();
    for (a, b) in characters.joint_positions(1).iter().zip(&before) {
        assert!((*a - *b).length() < 6.0 * dt, "faster than 6 m/s");
    }
    for _ in 0..240 {
        characters.step(&r, dt, &orders).unwrap();
    }
    assert!(characters.last_choice(1).is_some(), "it chooses for itself again");
    assert!(matches!(characters.play(&r, 3, 0), Err(Error::Index { what: "character", .. })));
    assert!(matches!(characters.play(&r, 0, 4), Err(Error::Index { what: "segment", .. })));
}
