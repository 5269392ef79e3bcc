//! The schemes against brute force, by hand, and against each other.

mod by_hand;
#[cfg(feature = "fixed-steps")]
#[path = "../../../../../research/fixed-steps/tests.rs"]
mod fixed;
mod invariants;

use self::invariants::lists_are_exact;
use crate::events::engine::Engine;
use crate::events::occupancy::Occupancy;
use crate::tests::drive::Drive;
use crate::*;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

const SCHEMES: &[Scheme] = &[
    Scheme::Registration,
    Scheme::Occupancy,
    #[cfg(feature = "fixed-steps")]
    Scheme::Fixed,
];

/// Two groups that walk through each other, past a pillar, some of them to a stop before a wall.
fn meeting<V: Space>(scheme: Scheme, rows: usize) -> CrowdSetup<V> {
    let mut setup = CrowdSetup { config: CrowdConfig { scheme, ..CrowdConfig::default() }, ..CrowdSetup::default() };
    for i in 0..8 * rows {
        let (side, row, column) = (i % 2, i / 2 % 4, i / 8);
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let sway = 0.13 * ((i * 7 % 5) as f32 - 2.0);
        let height = 0.8 * (i * 3 % 4) as f32;
        let at = |x: f32| V::from_coordinates([x, 0.9 * row as f32 + sway, height]);
        let start = -sign * (1.6 + 0.8 * column as f32);
        let goal = if i % 3 == 0 { sign * 1.5 } else { sign * 9.0 };
        setup.routes.push(Route { subgoals: vec![at(goal)], arrival_radius: 0.3, at_end: AtEnd::Stay });
        setup.agents.push(Agent {
            position: at(start),
            route: Some(i),
            radius: 0.2 + 0.02 * row as f32,
            ..Agent::default()
        });
    }
    setup.obstacles.push(Obstacle::Ball { centre: V::from_coordinates([0.3, 1.9, 1.0]), radius: 0.3 });
    let corner = |x: f32, y: f32| V::from_coordinates([x, y, 0.0]);
    setup.obstacles.push(Obstacle::Wall { from: corner(-9.0, -1.3), to: corner(9.0, -1.3), radius: 0.1 });
    setup
}

fn pair(scheme: Scheme, gap: f32, speed: f32) -> CrowdSetup<Vec2> {
    let x = 0.3 + 0.5 * gap;
    let agent = |sign: f32, route| Agent {
        position: Vec2::new(sign * x, 0.5),
        velocity: Vec2::new(-sign * speed, 0.0),
        speed,
        route: Some(route),
        ..Agent::default()
    };
    let route = |sign: f32| Route {
        subgoals: vec![Vec2::new(if speed > 0.0 { -sign * 20.0 } else { sign * x }, 0.5)],
        arrival_radius: 0.1,
        at_end: AtEnd::Stay,
    };
    CrowdSetup {
        agents: vec![agent(-1.0, 0), agent(1.0, 1)],
        routes: vec![route(-1.0), route(1.0)],
        config: CrowdConfig { scheme, ..CrowdConfig::default() },
        ..CrowdSetup::default()
    }
}

/// A field with nothing but driving.
fn driven() -> ForceField {
    ForceField {
        repulsion: 0.0,
        braking: 0.0,
        damping: 0.0,
        avoiding: 0.0,
        turning: 0.0,
        safety: 0.0,
        relaxation_s: 0.4,
        // No agent is seen.
        perception_m: 1e-3,
        ..ForceField::default()
    }
}

/// Runs to a time, and calls `check` after every event.
fn at_every_event<V: Space>(crowd: &mut Engine<V>, until: f64, mut check: impl FnMut(&Engine<V>)) {
    while let Some((time, _)) = crowd.queue.first(until) {
        crowd.advance(time, &mut |_| ()).unwrap();
        check(crowd);
    }
}

fn occupancy<V: Space>(crowd: &Engine<V>) -> &Occupancy {
    crowd.occupancy.as_ref().expect("the scheme with lists")
}

fn no_overlap<V: Space>(crowd: &Engine<V>, most: f32) {
    let ids: Vec<Id> = crowd.ids().collect();
    let agents: Vec<Agent<V>> = ids.iter().map(|&id| crowd.agent(id).unwrap()).collect();
    for (i, a) in agents.iter().enumerate() {
        for b in &agents[..i] {
            let gap = (a.position - b.position).length() - a.radius - b.radius;
            assert!(gap >= -most, "overlap of {} m at {} s", -gap, crowd.now);
        }
    }
}

#[test]
fn no_agent_acts_twice_within_the_smallest_interval() {
    for scheme in [Scheme::Registration, Scheme::Occupancy] {
        let mut crowd = Engine::new(meeting::<Vec2>(scheme, 5)).unwrap();
        let mut last: BTreeMap<Id, f64> = BTreeMap::new();
        let mut of_pair: BTreeMap<(Id, Id), [f64; 2]> = BTreeMap::new();
        let (mut least, mut least_of_pair) = (f64::INFINITY, f64::INFINITY);
        let mut crossings = 0;
        let note = &mut |e: &CrowdEvent| match e.kind {
            CrowdEventKind::Resetting | CrowdEventKind::Colliding { .. } | CrowdEventKind::Meeting { .. } => {
                least = least.min(e.time - last.insert(e.agent, e.time).unwrap_or(-1.0));
                if let CrowdEventKind::Colliding { other } = e.kind {
                    let pair = of_pair.entry((e.agent.min(other), e.agent.max(other))).or_insert([-1.0; 2]);
                    least_of_pair = least_of_pair.min(e.time - pair[0]);
                    *pair = [pair[1], e.time];
                }
            }
            CrowdEventKind::Entering | CrowdEventKind::Leaving => crossings += 1,
            _ => (),
        };
        crowd.advance(10.0, note).unwrap();
        assert!(of_pair.len() > 20 && least >= 0.1 - 1e-6, "{scheme:?}: {least} s between events of an agent");
        assert!(least_of_pair >= 0.1 - 1e-6, "{scheme:?}: {least_of_pair} s for three events of a pair");
        // Each axis of a bound has two faces, each of which it crosses three times at most.
        assert!(crossings <= 12 * crowd.counts.decisions, "{scheme:?}: {:?}", crowd.counts);
    }
}

#[test]
fn runs_repeat_however_they_are_cut() {
    for &scheme in SCHEMES {
        let mut whole = Engine::new(meeting::<Vec2>(scheme, 4)).unwrap();
        let mut cut = whole.clone();
        whole.advance(5.0, &mut |_| ()).unwrap();
        for i in 1..=71 {
            cut.advance(5.0 * f64::from(i) / 71.0, &mut |_| ()).unwrap();
        }
        assert_eq!(whole.hash(), cut.hash(), "{scheme:?}");
        assert_eq!(whole.counts, cut.counts, "{scheme:?}");
    }
}

#[test]
fn run_after_load_repeats() {
    for &scheme in SCHEMES {
        let setup = meeting::<Vec3>(scheme, 4);
        let mut crowd = Engine::new(setup.clone()).unwrap();
        crowd.advance(2.34, &mut |_| ()).unwrap();
        crowd.add_route(setup.routes[0].clone()).unwrap();
        let kept = crowd.bytes();
        crowd.advance(6.0, &mut |_| ()).unwrap();
        let (hash, counts) = (crowd.hash(), crowd.counts);
        let mut other = Engine::new(setup.clone()).unwrap();
        for crowd in [&mut crowd, &mut other] {
            crowd.load(&kept).unwrap();
            assert_eq!(crowd.bytes(), kept, "{scheme:?}");
            crowd.advance(6.0, &mut |_| ()).unwrap();
            assert_eq!((crowd.hash(), crowd.counts), (hash, counts), "{scheme:?}");
        }
        for &scheme in SCHEMES.iter().filter(|s| **s != scheme) {
            let mut setup = setup.clone();
            setup.config.scheme = scheme;
            setup.config.cell_side_m = crowd.cells.side;
            let error = Engine::new(setup).unwrap().load(&kept).unwrap_err();
            assert!(matches!(error, CrowdError::Other(throng_base::Error::Snapshot { .. })), "{error}");
        }
    }
}

/// Bytes before the state in a snapshot; the last four are its checksum.
const HEADER: usize = 44;

/// A state that no crowd has written is refused, or does no harm.
#[test]
fn damaged_state_is_refused_or_runs() {
    for &scheme in SCHEMES {
        let mut crowd = Engine::new(meeting::<Vec2>(scheme, 2)).unwrap();
        crowd.advance(2.0, &mut |_| ()).unwrap();
        let kept = crowd.bytes();
        for at in HEADER..kept.len() {
            for bit in [at % 8, 6] {
                let mut bytes = kept.clone();
                bytes[at] ^= 1 << bit;
                // As if it had been written so.
                let sum = throng_base::crc32(&bytes[HEADER..]);
                bytes[HEADER - 4..HEADER].copy_from_slice(&sum.to_le_bytes());
                if crowd.load(&bytes).is_ok() {
                    // Only the end of the run matters here.
                    let _ = crowd.advance(crowd.now + 0.2, &mut |_| ());
                }
            }
        }
    }
}

#[test]
fn spawned_and_despawned_agents_are_listed_and_unlisted() {
    for &scheme in SCHEMES {
        let mut setup = meeting::<Vec2>(scheme, 3);
        setup.config.capacity = 40;
        for route in &mut setup.routes {
            route.at_end = AtEnd::Leave;
        }
        let mut crowd = Engine::new(setup.clone()).unwrap();
        let mut entered = 0;
        for i in 1..200 {
            crowd.advance(0.07 * f64::from(i), &mut |_| ()).unwrap();
            entered += usize::from(crowd.spawn(setup.agents[i as usize % 24]).is_ok());
            if i % 20 == 0 {
                let id = crowd.ids().next().unwrap();
                crowd.despawn(id).unwrap();
            }
            no_overlap(&crowd, if crowd.is_of_registration() || crowd.occupancy.is_some() { 0.0 } else { 2e-3 });
            if scheme == Scheme::Occupancy {
                lists_are_exact(&crowd);
                let listed = occupancy(&crowd).occupants.iter().filter(|o| o.is_listed).count();
                assert_eq!(listed, crowd.num_agents());
            }
        }
        assert!(entered > 3 && crowd.counts.left > 3, "{scheme:?}: {entered} entered, {:?}", crowd.counts);
    }
}

#[test]
fn impossible_starts_are_errors_in_every_scheme() {
    for &scheme in SCHEMES {
        let overlapping = pair(scheme, -0.05, 0.0);
        assert!(matches!(Engine::new(overlapping).unwrap_err(), CrowdError::Overlap { .. }));
        let mut walled = pair(scheme, 1.0, 0.0);
        walled.obstacles.push(Obstacle::Ball { centre: walled.agents[0].position + Vec2::Y * 0.4, radius: 0.2 });
        walled.routes[0].subgoals[0] += Vec2::NEG_Y;
        assert!(matches!(Engine::new(walled).unwrap_err(), CrowdError::Inside { obstacle: 0, .. }));
    }
    // A bound that is wider than a cell before the first event.
    let mut setup = pair(Scheme::Occupancy, 1.0, 0.0);
    setup.config.capacity = 3;
    let strong = Agent { acceleration: 900.0, position: Vec2::new(0.0, 9.0), ..setup.agents[0] };
    let mut crowd = Engine::new(setup).unwrap();
    assert!(matches!(
        crowd.spawn(strong).unwrap_err(),
        CrowdError::Other(throng_base::Error::Value { what: "agent.acceleration", .. })
    ));
}

#[test]
fn every_scheme_brings_agents_to_their_goals() {
    let left = |scheme| {
        let mut crowd = Engine::new(meeting::<Vec2>(scheme, 2)).unwrap();
        crowd.advance(15.0, &mut |_| ()).unwrap();
        let ids: Vec<Id> = crowd.ids().collect();
        ids.iter().map(|&id| crowd.distance_left(id).unwrap()).sum::<f32>() / ids.len() as f32
    };
    let left: Vec<f32> = SCHEMES.iter().map(|&s| left(s)).collect();
    assert!(left.iter().all(|&l| l < 1.5), "way left in each scheme: {left:?}");
}
