//! What the whole set promises.

use super::*;

fn short(seed: u64) -> ClipSet {
    walk(&SynthConfig { seed, minutes: 0.5, ..SynthConfig::default() }).unwrap()
}

#[test]
fn same_seed_same_motion_and_another_seed_another() {
    assert_eq!(short(1), short(1));
    assert_ne!(short(1).clips[0].rotations, short(2).clips[0].rotations);
}
