//! Bytes that are cut, flipped, forged or of something else.

use super::scenes;
use super::{DT, new};
use glam::Vec3;
use proptest::prelude::*;
use std::sync::OnceLock;
use throng_base::{Error, crc32};
use throng_core::Bundle;
use throng_simulation::Simulation;

/// First bytes of each frame, and where its length, checksum and content lie after them.
const MAGIC: &[u8] = b"THRGSNAP";
const LENGTH: usize = 32;
const SUM: usize = 40;
const BODY: usize = 44;

/// A simulation of each scene in the middle of things, and its snapshot.
fn running() -> &'static [(&'static str, Simulation, Vec<u8>)] {
    static RUNNING: OnceLock<Vec<(&'static str, Simulation, Vec<u8>)>> = OnceLock::new();
    RUNNING.get_or_init(|| {
        let start = |(name, scene)| {
            let mut sim = new(&scene);
            (0..40).for_each(|_| sim.step(DT).unwrap());
            let bytes = sim.snapshot();
            (name, sim, bytes)
        };
        scenes::all().into_iter().map(start).collect()
    })
}

fn is_refused(sim: &mut Simulation, bytes: &[u8]) -> bool {
    let before = sim.hash();
    let refused = matches!(sim.restore(bytes), Err(Error::Snapshot { .. }));
    assert!(!refused || sim.hash() == before, "nothing has changed");
    refused
}

/// Corrects the checksums of all frames, the inner ones first.
fn forge(bytes: &mut [u8]) {
    let starts = bytes.windows(MAGIC.len()).enumerate().filter(|(_, w)| *w == MAGIC).map(|(at, _)| at);
    for at in starts.collect::<Vec<_>>().into_iter().rev() {
        let Some(length) = bytes.get(at + LENGTH..at + LENGTH + 8) else { continue };
        let length = u64::from_le_bytes(std::array::from_fn(|i| length[i]));
        let end = usize::try_from(length).ok().and_then(|n| n.checked_add(at + BODY));
        let Some(body) = end.and_then(|end| bytes.get(at + BODY..end)) else { continue };
        let sum = crc32(body).to_le_bytes();
        bytes[at + SUM..at + BODY].copy_from_slice(&sum);
    }
}

#[test]
fn cut_and_flipped_bytes_are_refused() {
    for (name, sim, bytes) in running() {
        let mut sim = sim.clone();
        for k in 0..60 {
            let at = bytes.len() * k / 60;
            assert!(is_refused(&mut sim, &bytes[..at]), "{name}: {at} bytes");
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (k % 8);
            assert!(is_refused(&mut sim, &flipped), "{name}: byte {at}");
        }
        assert!(is_refused(&mut sim, &[&bytes[..], &[0]].concat()), "{name}: a byte follows");
    }
}

#[test]
fn what_was_taken_elsewhere_is_refused() {
    let boxing = scenes::boxing(0.0);
    let texts = [scenes::POLICY, scenes::SPARRING, scenes::PATCHES];
    let bytes = new(&scenes::compile(&texts.concat(), &boxing)).snapshot();
    let refused = |text: &str, bundle: &Bundle| is_refused(&mut new(&scenes::compile(text, bundle)), &bytes);
    assert!(!refused(&texts.concat(), &boxing), "the same scene");
    assert!(refused(&texts[..2].concat(), &boxing), "other groups");
    assert!(refused(&texts.concat(), &scenes::boxing(0.01)), "another bundle");
    for (from, to) in
        [("count = 11", "count = 12"), ("0.2", "0.21"), ("floor.world", "other.world"), ("[[", "seed = 5\n[[")]
    {
        assert!(refused(&texts.concat().replacen(from, to, 1), &boxing), "{to}");
    }
}

/// Bytes that hold extreme numbers, as little-endian words of four or eight bytes.
fn words() -> impl Strategy<Value = Vec<u8>> {
    let floats = [f32::NAN, f32::INFINITY, f32::MAX, -1.0, 1e6, 0.0].map(|v| v.to_le_bytes().to_vec());
    let integers = [u64::MAX, u64::MAX / 2, 1 << 40, 77, 1, 0].map(|v| v.to_le_bytes().to_vec());
    let short = [u32::MAX, 1 << 31, 5].map(|v| v.to_le_bytes().to_vec());
    let doubles = [f64::NAN, f64::INFINITY, 1e300, -1.0, 3.5].map(|v| v.to_le_bytes().to_vec());
    let all = [&floats[..], &integers[..], &short[..], &doubles[..]].concat();
    prop_oneof![prop::sample::select(all), prop::collection::vec(any::<u8>(), 1..9)]
}

/// A body that is nowhere, or two agents in one place.
fn what_is_wrong(sim: &Simulation) -> Option<String> {
    let mut discs: Vec<(usize, Vec3, f32)> = Vec::new();
    for who in 0..sim.num_characters() {
        if sim.root(who).is_some_and(|r| !(r.translation().is_finite() && r.heading.is_finite())) {
            return Some(format!("{who} is nowhere"));
        }
        if sim.joint_positions(who).is_some_and(|all| all.iter().any(|p| !p.is_finite())) {
            return Some(format!("{who} has a joint that is nowhere"));
        }
        if let Some(disc) = sim.disc(who) {
            for (other, at, radius) in &discs {
                let depth = radius + disc.radius - at.distance(disc.centre);
                if depth > 2e-4 {
                    return Some(format!("{other} and {who} overlap by {depth} m"));
                }
            }
            discs.push((who, disc.centre, disc.radius));
        }
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    /// Whoever corrects the checksum may be refused, or gets a state from which everything goes on without a panic, with
    /// finite bodies and with agents that do not overlap.
    #[test]
    fn forged_bytes_do_no_harm(which in 0..7usize, places in prop::collection::vec((0.0..1.0f64, words()), 1..3)) {
        let (_, sim, bytes) = &running()[which];
        let (mut sim, mut forged) = (sim.clone(), bytes.clone());
        for (place, word) in &places {
            let at = BODY + (place * (forged.len() - BODY) as f64) as usize;
            let word = &word[..word.len().min(forged.len() - at)];
            forged[at..at + word.len()].copy_from_slice(word);
        }
        forge(&mut forged);
        if !is_refused(&mut sim, &forged) {
            // It may be impossible to go on, such as from a place that cannot be left; that is told.
            prop_assert_eq!(what_is_wrong(&sim), None);
            for _ in 0..20 {
                if sim.step(DT).is_err() {
                    break;
                }
                prop_assert_eq!(what_is_wrong(&sim), None);
            }
            let kept = sim.snapshot();
            let _ = sim.restore(&kept);
        }
    }
}
