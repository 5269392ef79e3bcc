//! Frequencies, and the same again after a snapshot.

use super::{Lives, Paper, Signal, brains, play, played, scene};
use proptest::prelude::*;

/// The sum of (seen - expected)^2 / expected.
fn chi_squared(seen: &[usize], shares: &[f64]) -> f64 {
    let all = seen.iter().sum::<usize>() as f64;
    seen.iter().zip(shares).map(|(s, p)| (*s as f64 - all * p).powi(2) / (all * p)).sum()
}

#[test]
fn edges_and_rules_are_taken_as_often_as_they_say() {
    let story = "[values.hits]\nlimits = [0.0, 1.0]\n[[rules]]\non = \"bell\"\nprobability = 0.3\ndo = [{ set = \"hits\", to = 1.0 }]\n\
        [graphs.life]\nlevel = \"social\"\nstart = \"a\"\nedges = [\n\
        { from = \"a\", to = \"b\", on = \"bell\", probability = 0.5 }, { from = \"a\", to = \"c\", on = \"bell\", probability = 0.2 },\n\
        { from = \"a\", to = \"a\", on = \"bell\", probability = 0.1 },\n\
        { from = \"a\", to = \"d\", on = \"bell\" }, { from = \"a\", to = \"e\", on = \"bell\" } ]\n[graphs.life.states]\n\
        a = { do = [{ stay = 1000 }] }\nb = { do = [{ stay = 1000 }] }\nc = { do = [{ stay = 1000 }] }\nd = { do = [{ stay = 1000 }] }\n\
        e = { do = [{ stay = 1000 }] }\n[[events]]\nname = \"bell\"\nat_s = 1.0\n";
    let (brains, _) = played(8000, story, &[], 2.0);
    let states = brains.num_in_states();
    let count = |name: &str| states.iter().find(|s| s.0 == name).map_or(0, |s| s.1);
    let seen = ["a", "b", "c", "d", "e"].map(count);
    // Of four degrees of freedom, above 18.5 once in a thousand.
    let chi = chi_squared(&seen, &[0.1, 0.5, 0.2, 0.1, 0.1]);
    assert!(chi < 18.5, "{seen:?}: {chi}");
    let hits = (0..8000).filter(|a| brains.explain(*a, 0.0).values[0].value == 1.0).count();
    let chi = chi_squared(&[hits, 8000 - hits], &[0.3, 0.7]);
    assert!(chi < 10.8, "{hits} of 8000: {chi}");
}

#[test]
fn random_events_come_as_often_as_they_say() {
    let story = "[values.count]\nlimits = [0.0, 100000.0]\n[[rules]]\non = \"bell\"\ndo = [{ add = \"count\", by = 1.0 }]\n\
        [[events]]\nname = \"bell\"\nevery_s = 2.0\n";
    let (brains, _) = played(1, story, &[], 8000.0);
    let count = brains.explain(0, 0.0).values[0].value;
    // 4000 expected; four standard deviations are 253.
    assert!((count - 4000.0).abs() < 253.0, "{count}");
}

/// A lively scene, whose numbers are drawn.
pub(super) fn lively(period: f64, rate: f64, probability: f64) -> String {
    format!(
        "[agents]\ncell_m = 3.0\n[values.anger]\nstart = [0.0, 0.6]\nrate_per_s = {rate}\n[values.joy]\nstart = [0.1, 0.9]\nrest = 0.4\n\
         half_life_s = 2.0\n[[relations]]\nof = \"people\"\nto = \"people\"\nshare = 0.5\nfriendship = 0.7\n\
         [[places]]\nname = \"shop\"\nat = [3.0, 0.0]\nguidepost = true\nslots = [{{ at = [3.0, 1.0] }}, {{ at = [4.0, 1.0] }}]\n\
         [[events]]\nname = \"news\"\nperiod_s = {period}\nwho = \"random < 0.3\"\npassed_on = true\nfresh_s = 3.0\n\
         [[events]]\nname = \"shout\"\n[[rules]]\nname = \"cry\"\non = \"anger > 0.8\"\n\
         do = [{{ convey = \"shout\", within_m = 7.0, friends = true }}, {{ set = \"anger\", to = 0.1 }}, {{ post = \"shout\", cells = 1, for_s = 4 }}]\n\
         [[rules]]\nname = \"greet\"\non = \"meets\"\nwhen = \"friendship(me, other) > 0.5 and not other.busy\"\npause_s = 2.0\n\
         probability = {probability}\ndo = [{{ greet = \"other\", for_s = \"1 + random\" }}, {{ befriend = 0.1 }}, {{ add = \"joy\", by = 0.2 }}]\n\
         [[rules]]\nname = \"startle\"\non = \"shout\"\npriority = 2\ndo = [{{ flee = \"other\", distance_m = 4 }}]\n\
         [graphs.life]\nlevel = \"social\"\nstart = \"idle\"\nedges = [\n\
         {{ from = \"idle\", to = \"shop\", on = \"news\", probability = {probability} }},\n\
         {{ from = \"shop\", to = \"idle\", on = \"full\" }}, {{ from = \"shop\", to = \"idle\" }},\n\
         {{ from = \"idle\", to = \"idle\", on = \"timer\" }}, {{ to = \"idle\", on = \"joy > 0.85\" }} ]\n\
         [graphs.life.states]\nidle = {{ do = [{{ timer = 2 }}, {{ roam = \"home\", within_m = 3 }}, {{ stay = \"random * 3\" }}] }}\n\
         shop = {{ graph = \"buying\" }}\n[graphs.buying]\nlevel = \"spatial\"\nstart = \"go\"\nedges = [{{ from = \"go\", to = \"pay\" }},\n\
         {{ from = \"pay\", to = \"pay\", probability = 0.3 }}]\n\
         [graphs.buying.states]\ngo = {{ do = [{{ go = \"shop\", within_m = 2 }}] }}\n\
         pay = {{ do = [{{ buy = \"shop\", for_s = 2 }}, {{ set = \"anger\", to = 0.0 }}, {{ release = true }}] }}\n"
    )
}

/// Who meets whom, and comes where, by chance.
pub(super) fn script(num: u32, seed: u64, until_s: f64) -> Vec<(f64, Signal)> {
    let mut out = Vec::new();
    let mut at = 0.0;
    let draw = |k: u32, of: u32| (super::super::hashed_chance(seed, k, of) * 1e6) as u32;
    for k in 0.. {
        at += f64::from(1 + draw(k, 0) % 40) * 0.0123;
        if at > until_s {
            return out;
        }
        let a = draw(k, 1) % num;
        let b = (a + 1 + draw(k, 2) % (num - 1)) % num;
        out.push(match draw(k, 3) % 6 {
            0..=2 => (at, Signal::Met(a.min(b), a.max(b))),
            3 => (at, Signal::CameTo(a, 0)),
            4 => (at, Signal::WentFrom(a, 0)),
            _ => (at, Signal::Crossed(a)),
        });
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    /// Nobody holds two slots or knows what nobody told; what follows a snapshot at any event is the same.
    #[test]
    fn what_follows_a_snapshot_is_the_same(period in 0.5f64..4.0, rate in -0.05f64..0.3, probability in 0.0f64..1.0, seed in any::<u64>(), cut in 0usize..60) {
        let scene = scene(6, &lively(period, rate, probability));
        let script = script(6, seed, 15.0);
        let mut whole = (brains(&scene), Paper::new(6));
        Lives::begin(&mut whole.0, &mut whole.1);
        let at = script[cut % script.len()].0;
        play(&mut whole.0, &mut whole.1, &script[..cut % script.len()], at);
        let mut bytes = Vec::new();
        whole.0.save(&mut bytes);
        let mut again = (brains(&scene), whole.1.clone());
        again.0.load(&bytes, at).unwrap();
        for (brains, stage) in [&mut whole, &mut again] {
            play(brains, stage, &script[cut % script.len()..], 15.0);
            prop_assert_eq!(brains.num_holding_twice(), 0);
        }
        prop_assert_eq!(&whole.1.log, &again.1.log);
        let all = |m: &super::AgentBrains| (0..6).map(|a| m.explain(a, 0.0)).collect::<Vec<_>>();
        prop_assert_eq!(all(&whole.0), all(&again.0));
        for agent in 0..6 {
            for known in whole.0.explain(agent, 0.0).knows {
                let Some(from) = known.from else { continue };
                let learnt = whole.0.explain(from, 0.0).knows.into_iter().find(|k| k.event == known.event);
                let felt = known.how == "felt";
                prop_assert!(felt || learnt.is_some_and(|l| l.time_s <= known.time_s), "{} told {} what it did not know", from, agent);
            }
        }
    }

    /// Bytes that were changed are refused, or give brains that go on.
    #[test]
    fn forged_agent_brains_do_no_harm(seed in any::<u64>(), at in any::<prop::sample::Index>(), flip in 1u8..=255) {
        let scene = scene(4, &lively(1.0, 0.1, 0.5));
        let script = script(4, seed, 4.0);
        let mut own = (brains(&scene), Paper::new(4));
        Lives::begin(&mut own.0, &mut own.1);
        play(&mut own.0, &mut own.1, &script, 4.0);
        let mut bytes = Vec::new();
        own.0.save(&mut bytes);
        let at = at.index(bytes.len());
        bytes[at] ^= flip;
        prop_assert!(brains(&scene).load(&bytes, 4.0).is_err(), "the checksum shows it");
    }
}
