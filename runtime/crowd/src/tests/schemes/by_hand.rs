//! Few agents, whose events can be computed by hand.

use super::invariants::{contacts_are_true, lists_are_exact};
use super::*;
use crate::safety::bound::WIDEST;

/// A row of agents that stand and touch; one is sent away after a while.
fn row() -> CrowdSetup<Vec2> {
    let mut setup = pair(Scheme::Occupancy, 0.005, 0.0);
    setup.fields = vec![driven()];
    setup.config.largest_speed_mps = 1.3;
    for i in 2..5 {
        let position = Vec2::new(0.3025 + 0.605 * (i - 1) as f32, 0.5);
        setup.routes.push(Route { subgoals: vec![position], ..setup.routes[0].clone() });
        setup.agents.push(Agent { position, route: Some(i), ..setup.agents[0] });
    }
    setup
}

#[test]
fn group_in_contact_has_no_collisions_until_one_leaves() {
    let mut crowd = Engine::new(row()).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    crowd.advance(1.0, &mut |_| ()).unwrap();
    assert_eq!((crowd.counts.contacting, crowd.counts.separating), (4, 0), "{:?}", crowd.counts);
    let before = crowd.counts;
    at_every_event(&mut crowd, 6.0, |crowd| assert_eq!(contacts_are_true(crowd), 8));
    let counts = crowd.counts;
    assert_eq!(counts.colliding, before.colliding, "none within the group");
    // Nothing but the growth of bounds makes them act: once in sqrt(2 (side / 2 - r) / A).
    let grown = (2.0 * (0.5 * WIDEST * crowd.cells.side - 0.3) / 5.0f32).sqrt();
    let per_agent = (counts.resetting - before.resetting) as f32 / 5.0;
    assert!((per_agent - 5.0 / grown).abs() <= 1.0, "{per_agent} of {}", 5.0 / grown);

    // The third of five leaves upward: the group splits into two of two and one alone.
    let away = Route { subgoals: vec![Vec2::new(0.9, 30.0)], arrival_radius: 0.3, at_end: AtEnd::Stay };
    let route = crowd.add_route(away).unwrap();
    crowd.order(ids[2], &AgentOrder::on_route(route).at_speed(1.3)).unwrap();
    crowd.advance(9.0, &mut |_| ()).unwrap();
    assert_eq!(crowd.counts.separating, 2, "{:?}", crowd.counts);
    let contacts = &occupancy(&crowd).contacts;
    let together = |a: usize, b: usize| contacts.are_together(ids[a].index, ids[b].index);
    assert!(together(0, 1) && together(3, 4) && !together(1, 3) && !together(1, 2));

    // An agent that leaves the crowd leaves its group.
    crowd.despawn(ids[0]).unwrap();
    assert!(occupancy(&crowd).contacts.contacts_of(ids[1].index).next().is_none());
    at_every_event(&mut crowd, 12.0, lists_are_exact);
}

#[test]
fn bounds_of_standing_agents_meet_as_solved_by_hand() {
    // 0.6 = 2 * 5 / 2 t^2
    let exact = (0.6f64 / 5.0).sqrt();
    for scheme in [Scheme::Registration, Scheme::Occupancy] {
        let mut setup = pair(scheme, 0.6, 0.0);
        setup.config.cell_side_m = 4.0;
        let mut crowd = Engine::new(setup).unwrap();
        let mut times = Vec::new();
        let note = &mut |e: &CrowdEvent| {
            if matches!(e.kind, CrowdEventKind::Colliding { .. }) {
                times.push(e.time);
            }
        };
        crowd.advance(3.0, note).unwrap();
        assert_eq!(times.len(), (3.0 / exact) as usize, "{scheme:?}: {times:?}");
        for (n, time) in times.iter().enumerate() {
            let late = time - exact * (n + 1) as f64;
            assert!((-0.02..=1e-4).contains(&late), "{scheme:?}: {late} s late");
        }
    }
}

#[test]
fn bound_enters_and_leaves_cells_as_solved_by_hand() {
    // At 1 m/s from 0.5 m before a face, with radius 0.2 m and acceleration 0.2 m/s2.
    let mut setup = pair(Scheme::Occupancy, 9.0, 0.0);
    setup.agents.truncate(1);
    setup.fields = vec![driven()];
    setup.config.cell_side_m = 10.0;
    setup.routes[0].subgoals = vec![Vec2::new(100.0, 4.0)];
    setup.agents[0] = Agent {
        position: Vec2::new(9.5, 4.0),
        velocity: Vec2::X,
        speed: 1.0,
        radius: 0.2,
        acceleration: 0.2,
        ..setup.agents[0]
    };
    let mut crowd = Engine::new(setup).unwrap();
    let mut times = Vec::new();
    crowd.advance(3.0, &mut |e| times.push((e.kind, e.time))).unwrap();
    // 0.5 - 0.2 = t + 0.1 t^2, and 0.5 + 0.2 = t - 0.1 t^2.
    let (enters, leaves) = ((1.12f64.sqrt() - 1.0) / 0.2, (1.0 - 0.72f64.sqrt()) / 0.2);
    for (kind, want) in [(CrowdEventKind::Entering, enters), (CrowdEventKind::Leaving, leaves)] {
        let got = times.iter().find(|e| e.0 == kind).unwrap();
        assert!((got.1 - want).abs() < 1e-3, "{kind:?} at {want} in {times:?}");
    }
}
