//! Snapshots that no crowd has written, with a right checksum: refused, or no agents ever overlap.

use super::drive::{Drive, Shares, crossing, to};
use crate::error::CrowdError;
use crate::events::engine::Engine;
use crate::space::plan::MotionPlan;
use crate::*;
use glam::{Vec2, Vec3};

/// Bytes before the state in a snapshot; the last four are its checksum.
const HEADER: usize = 44;
/// Tolerance of rounding (m).
const ROUNDING_M: f32 = 2e-4;

/// A dense crowd between two walls and around a pillar.
fn dense<V: Space>(num: usize, spacing: f32) -> CrowdSetup<V> {
    let mut setup = crossing::<V>(num, spacing);
    let corner = |x: f32, y: f32| V::from_coordinates([x, y, 0.0]);
    let high = 20.0;
    setup.obstacles = vec![
        Obstacle::Wall { from: corner(-high, -high), to: corner(high, -high), radius: 0.1 },
        Obstacle::Wall { from: corner(high, -high), to: corner(high, high), radius: 0.1 },
        Obstacle::Ball { centre: setup.agents[0].position + V::from_coordinates([-0.8; 3]), radius: 0.25 },
    ];
    setup
}

/// Deepest overlap of two agents, or of one and an obstacle, now (m).
fn deepest<V: Space>(crowd: &Engine<V>) -> f32 {
    let all: Vec<Agent<V>> = crowd.ids().filter_map(|id| crowd.agent(id)).collect();
    let mut depth = f32::NEG_INFINITY;
    for (i, a) in all.iter().enumerate() {
        assert!(a.position.is_finite() && a.velocity.is_finite());
        let others = all[..i].iter().map(|b| a.radius + b.radius - (a.position - b.position).length());
        let solids = crowd.scenery.solids.iter().map(|s| a.radius - s.direction_and_distance(a.position).1);
        depth = others.chain(solids).fold(depth, f32::max);
    }
    depth
}

fn corrected(mut bytes: Vec<u8>) -> Vec<u8> {
    let sum = throng_base::crc32(&bytes[HEADER..]);
    bytes[HEADER - 4..HEADER].copy_from_slice(&sum.to_le_bytes());
    bytes
}

/// Flips bits, overwrites floats and copies parts of the state over others; returns how many mutants were taken.
fn mutants<V: Space>(setup: &CrowdSetup<V>, num: usize, seed: u64) -> usize {
    let mut crowd = Engine::new(setup.clone()).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    crowd.set_companions(&ids[..3]).unwrap();
    let at = InterestLocation::Agent(ids[1]);
    crowd.set_interest(ids[5], 1, Some(PersonalInterest { at, strength: 1.0, reach: 5.0 })).unwrap();
    crowd.advance(1.3, &mut |_| {}).unwrap();
    let kept = crowd.bytes();
    let mut shares = Shares(seed);
    let mut below = |most: usize| (shares.next() * most as f32) as usize % most;
    let mut taken = 0;
    for mutant in 0..num {
        let mut bytes = kept.clone();
        for _ in 0..1 + below(3) {
            let at = HEADER + below(kept.len() - HEADER - 8);
            match below(4) {
                0 => bytes[at] ^= 1 << below(8),
                1 => bytes[at] = below(256) as u8,
                // Another float, small steps above all.
                2 => {
                    let word: [u8; 4] = bytes[at..at + 4].try_into().unwrap();
                    let value = f32::from_le_bytes(word) * (0.8 + 0.4 * below(1000) as f32 / 1000.0);
                    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
                }
                _ => {
                    let from = HEADER + below(kept.len() - HEADER - 8);
                    bytes.copy_within(from..from + 8, at);
                }
            }
        }
        let Err(e) = crowd.load(&corrected(bytes)) else {
            taken += 1;
            for step in 1..=40 {
                let until_s = crowd.now + 0.05;
                match crowd.advance(until_s, &mut |_| {}) {
                    Ok(()) => (),
                    Err(CrowdError::Stalled { .. }) => break,
                    Err(e) => panic!("mutant {mutant}: {e}"),
                }
                let depth = deepest(&crowd);
                assert!(depth <= ROUNDING_M, "mutant {mutant} of {seed}: an overlap of {depth} m in step {step}");
            }
            continue;
        };
        assert!(matches!(e, CrowdError::Other(throng_base::Error::Snapshot { .. })), "{e}");
    }
    crowd.load(&kept).unwrap();
    taken
}

#[test]
fn a_forged_snapshot_is_refused_or_nobody_overlaps() {
    let mut taken = mutants(&dense::<Vec2>(16, 0.9), 3000, 5);
    taken += mutants(&dense::<Vec3>(27, 0.9), 1500, 6);
    assert!(taken > 500, "{taken} mutants were taken");
    let mut setup = dense::<Vec2>(16, 0.9);
    setup.config.scheme = Scheme::Occupancy;
    mutants(&setup, 1000, 7);
}

/// Result of restoring a snapshot in which an agent is elsewhere.
fn moved(change: impl FnOnce(&Engine<Vec2>, &mut MotionPlan<Vec2>)) -> Result<(), String> {
    let setup = dense::<Vec2>(16, 1.2);
    let mut crowd = Engine::new(setup.clone()).unwrap();
    crowd.advance(0.5, &mut |_| {}).unwrap();
    let (cell, mut plan) = (crowd.states[5].cell, crowd.cells.plan(5));
    change(&crowd, &mut plan);
    let to = crowd.cells.number(crowd.cells.coordinates(plan.position));
    crowd.cells.set(cell, to, &plan);
    crowd.states[5].cell = to;
    Engine::new(setup).unwrap().load(&crowd.bytes()).map_err(|e| e.to_string())
}

#[test]
fn agents_that_overlap_or_stand_in_obstacles_are_refused() {
    assert_eq!(moved(|_, _| ()), Ok(()));
    // On top of another agent, which moves: at the present, not at the start of its plan.
    let onto = moved(|crowd, p| *p = MotionPlan { index: 5, ..crowd.cells.plan(6) });
    assert!(onto.as_ref().is_err_and(|e| e.contains("overlap")), "{onto:?}");
    let pillar = |crowd: &Engine<Vec2>| match crowd.scenery.obstacles[2] {
        Obstacle::Ball { centre, .. } => centre,
        _ => unreachable!("the pillar is a ball"),
    };
    let into = moved(|crowd, p| (p.position, p.velocity, p.acceleration) = (pillar(crowd), Vec2::ZERO, Vec2::ZERO));
    assert!(into.as_ref().is_err_and(|e| e.contains("in obstacle 2")), "{into:?}");
    // Clear now, but too fast to stop before the pillar.
    let against = moved(|crowd, p| {
        p.position = pillar(crowd) + Vec2::new(0.0, -0.7);
        (p.velocity, p.acceleration, p.moving) = (Vec2::new(0.0, 1.3), Vec2::ZERO, f32::INFINITY);
        (p.start, p.end) = (crowd.now, crowd.now + 0.3);
    });
    assert!(against.is_err(), "{against:?}");
    // It says that it brakes, and does not.
    let far = |crowd: &Engine<Vec2>, p: &mut MotionPlan<Vec2>| {
        (p.position, p.velocity, p.acceleration) = (Vec2::new(12.0, 12.0), Vec2::new(1.0, 0.0), Vec2::new(1.0, 0.0));
        (p.start, p.end) = (crowd.now, crowd.now + 0.1);
    };
    assert!(moved(|crowd, p| (far(crowd, p), p.moving = f32::INFINITY).0).is_ok());
    assert!(moved(|crowd, p| (far(crowd, p), p.moving = 0.5).0).is_err());
    // It leaves its region before it acts again.
    assert!(moved(|crowd, p| (far(crowd, p), p.moving = f32::INFINITY, p.end = 100.0).0).is_err());
}

/// Every snapshot of a crowd itself is accepted, dense or not.
#[test]
fn no_true_snapshot_is_refused() {
    fn check<V: Space>(mut setup: CrowdSetup<V>, far: f32) {
        // Far from the origin, rounding is coarser.
        let by = V::from_coordinates([far; 3]);
        setup.agents.iter_mut().for_each(|a| a.position += by);
        setup.routes.iter_mut().flat_map(|r| &mut r.subgoals).for_each(|s| *s += by);
        setup.obstacles.clear();
        setup.obstacles.push(Obstacle::Ball { centre: by + V::from_coordinates([0.1; 3]) * -90.0, radius: 2.0 });
        let mut crowd = Engine::new(setup.clone()).unwrap();
        let mut other = Engine::new(setup).unwrap();
        for i in 0..40 {
            crowd.advance(0.037 + 0.271 * f64::from(i), &mut |_| {}).unwrap();
            other.load(&crowd.bytes()).unwrap_or_else(|e| panic!("after {} s: {e}", crowd.now));
        }
    }
    for far in [0.0, 400.0] {
        check::<Vec2>(crossing(150, 0.9), far);
        check::<Vec3>(crossing(150, 0.9), far);
    }
    let walled = dense::<Vec2>(100, 0.9);
    let mut crowd = Engine::new(walled.clone()).unwrap();
    for i in 0..60 {
        crowd.advance(0.211 * f64::from(i), &mut |_| {}).unwrap();
        Engine::new(walled.clone()).unwrap().load(&crowd.bytes()).unwrap();
    }
    let mut setup = crossing::<Vec2>(100, 0.9);
    setup.config.scheme = Scheme::Occupancy;
    check(setup, 0.0);
}

/// Going back to before the first order takes the later routes back too.
#[test]
fn orders_after_a_snapshot_are_forgotten_in_the_same_crowd() {
    let mut setup = crossing::<Vec2>(200, 1.4);
    (setup.config.capacity, setup.config.largest_speed_mps) = (220, 2.0);
    let mut crowd = Engine::new(setup).unwrap();
    crowd.advance(1.0, &mut |_| {}).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    // Some agents have an order already, some will get their first, and all get another.
    for &id in ids.iter().step_by(3) {
        crowd.order(id, &super::drive::along(to(Vec2::new(0.0, 14.0)), 1.2)).unwrap();
    }
    crowd.advance(1.5, &mut |_| {}).unwrap();
    let seen = |crowd: &Engine<Vec2>| {
        let one = |&id: &Id| (crowd.distance_left(id), crowd.desired_direction(id), crowd.status(id));
        (crowd.hash(), ids.iter().map(one).collect::<Vec<_>>(), crowd.bytes())
    };
    let (kept, before) = (crowd.bytes(), seen(&crowd));
    crowd.advance(6.5, &mut |_| {}).unwrap();
    let later = seen(&crowd);
    crowd.load(&kept).unwrap();
    for &id in &ids {
        crowd.order(id, &super::drive::along(to(Vec2::new(-20.0, 3.0)), 1.9)).unwrap();
    }
    crowd.advance(3.0, &mut |_| {}).unwrap();
    crowd.load(&kept).unwrap();
    assert!(seen(&crowd) == before, "it is what it was");
    crowd.advance(6.5, &mut |_| {}).unwrap();
    assert!(seen(&crowd) == later, "it goes on as it did");
}
