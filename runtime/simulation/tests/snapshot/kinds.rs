//! Characters of different kinds in one place: nobody is ever in anybody.

use super::scenes;
use glam::Vec2;
use proptest::prelude::*;
use throng_core::Bundle;
use throng_core::format::AlignedBytes;
use throng_core::stops::BODY_RADIUS_M;
use throng_simulation::{AnyCharacterGroup, Simulation};

/// The disc that somebody takes on the ground.
fn disc(sim: &Simulation, who: usize) -> Option<(Vec2, f32)> {
    match sim.disc(who) {
        Some(d) => Some((Vec2::new(d.centre.x, d.centre.z), d.radius)),
        None => sim.root(who).map(|r| (Vec2::new(r.x, r.z), BODY_RADIUS_M)),
    }
}

/// Character group of somebody. Two of one group may be in each other: inhabitants keep what they hold, opponents spar.
fn character_group_of(sim: &Simulation, who: usize) -> usize {
    sim.groups().iter().find(|g| g.characters.contains(&who)).map_or(0, |g| g.character_group)
}

/// Deepest that two of different kinds are in each other (m).
fn deepest(sim: &Simulation) -> f32 {
    let all: Vec<_> =
        (0..sim.num_characters()).filter_map(|who| Some((character_group_of(sim, who), disc(sim, who)?))).collect();
    let mut deepest = f32::NEG_INFINITY;
    for (i, (character_group, (at, radius))) in all.iter().enumerate() {
        for (other, (place, r)) in &all[..i] {
            if character_group != other {
                deepest = deepest.max(radius + r - at.distance(*place));
            }
        }
    }
    deepest
}

/// Tells a boxer to play a segment at once; false where that is refused.
fn play(sim: &mut Simulation, who: usize, segment: u32) -> bool {
    let number = sim.locate(who).1;
    match sim.character_group_mut(character_group_of(sim, who)) {
        AnyCharacterGroup::Policy(p) => p.play(number, segment).is_ok(),
        AnyCharacterGroup::Sparring(s) => s.play(number, segment).is_ok(),
        _ => unreachable!("only those box"),
    }
}

#[test]
fn a_bundle_that_lacks_the_behaviour_of_travel_is_named_with_its_group() {
    let bytes = throng_world::made_up_floor::bundle("made up");
    let floor = Bundle::from_bytes(AlignedBytes::from_slice(&bytes)).expect("a sound bundle");
    let travels = scenes::TRAVELLERS.replace("behaviours = [{ name = \"approach\" }]", "");
    let message = Simulation::new(&scenes::compile(&travels, &floor)).unwrap_err().to_string();
    assert!(message.contains("key `groups[0]`: in its bundle, there is no behaviour \"approach\""), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn nobody_is_in_anybody_of_another_kind(
        seed in any::<u32>(),
        policy in [-4.0f32..14.0, -4.0f32..12.0],
        sparring in [-4.0f32..14.0, -4.0f32..12.0],
        agents in [-14.0f32..2.0, -4.0f32..12.0],
        patches in any::<bool>(),
        dt in 0.01f64..0.1,
        plays in proptest::collection::vec((any::<proptest::sample::Index>(), 0u32..4), 40),
    ) {
        let place = |[x, z]: [f32; 2]| format!("grid = {{ centre = [{x:.2}, {z:.2}], spacing_m = 2.0, distance_m = 0.9 }}");
        let (policy, sparring) = (place(policy), place(sparring));
        let [x, z] = agents;
        let world = if patches { scenes::PATCHES } else { "" };
        let text = format!(
            r#"
seed = {seed}

[[groups]]
motion = "policy"
count = 9
place = {{ {policy} }}
temperature = 0.3
behaviours = [{{ name = "approach" }}]
target = {{ drag = [{{ time_s = 3.0, x_m = 5.0 }}, {{ time_s = 6.0, z_m = 5.0 }}, {{ time_s = 9.0, x_m = -5.0 }}] }}

[[groups]]
motion = "sparring"
count = 6
place = {{ {sparring} }}
temperature = 0.2
behaviours = [{{ name = "approach", weight = 0.5 }}]

[[groups]]
motion = "none"
count = 25
place = {{ block = {{ from = [{x:.2}, {z:.2}], to = [{:.2}, {:.2}] }} }}
goal = {{ shift = {{ by = [14.0, 1.0] }} }}

[[environment.obstacles]]
disc = {{ centre = [30.0, 4.0], radius_m = 0.8 }}
{world}"#,
            x + 5.0,
            z + 6.0
        );
        let compiled = scenes::compile(&text, &scenes::boxing(0.0));
        let sim = Simulation::new(&compiled);
        prop_assume!(sim.is_ok(), "somebody starts in another's place");
        let mut sim = sim.unwrap();
        prop_assert!(deepest(&sim) <= 0.0);
        let (mut plays, mut played_s, mut num_played) = (plays.iter().peekable(), 0.0, 0);
        for _ in 0..(15.0 / dt) as usize {
            sim.step(dt).unwrap();
            let deep = deepest(&sim);
            prop_assert!(deep <= 1e-3, "{deep} m at {} s of {text}", sim.time_s());
            if let Some((who, segment)) = plays.next_if(|_| sim.time_s() > played_s + 0.35) {
                played_s = sim.time_s();
                // Where that is in somebody's way, it is refused.
                num_played += usize::from(play(&mut sim, who.index(15), *segment));
            }
        }
        prop_assert!(num_played > 3, "{num_played} were free to play");
    }
}

#[test]
fn a_group_that_starts_in_another_is_refused_by_name() {
    let group = r#"
[[groups]]
motion = "none"
count = 1
place = { block = { from = [60.9, 0.9], to = [61.1, 1.1] } }
goal = { shift = { by = [9.0, 0.0] } }
"#;
    let refused = |text: &str| {
        let sim = Simulation::new(&scenes::compile(text, &scenes::boxing(0.0)));
        sim.err().map(|e| e.to_string()).unwrap_or_default()
    };
    let in_another = refused(&[&scenes::POLICY.replace("spacing_m = 4.0", "spacing_m = 2.0"), group].concat());
    assert!(in_another.contains("`groups[0]`: somebody starts at "), "{in_another}");
    let too_near = refused(&scenes::POLICY.replace("spacing_m = 4.0", "spacing_m = 1.0"));
    assert!(too_near.contains("`groups[0]`: character ") && too_near.contains("spacing_m"), "{too_near}");
}
