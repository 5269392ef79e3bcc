//! Tests of whole crowds.

mod doors;
pub(crate) mod drive;
mod forged;
mod interface;
mod jams;
mod navigation;
mod passages;
mod relationships;
mod schemes;
mod senses;
mod shared;
mod wake;

use crate::events::engine::Engine;
use crate::safety::rule::clearance;
use crate::space::plan::MotionPlan;
use crate::*;
use drive::*;
use glam::{Vec2, Vec3};
use throng_base::Error;

/// The invariant of the safety rule, at one time.
fn check_stop_regions<V: Space>(crowd: &Engine<V>, time: f64) {
    let plans: Vec<MotionPlan<V>> = crowd
        .ids()
        .map(|id| {
            let plan = crowd.cells.plan(id.index);
            let (position, velocity) = plan.motion_at(time);
            MotionPlan { position, velocity, ..plan }
        })
        .collect();
    for (i, a) in plans.iter().enumerate() {
        for b in &plans[..i] {
            let clearance = clearance(a, b);
            assert!(
                clearance > 0.0,
                "stop regions of {} and {} overlap by {} m at {time}",
                a.index,
                b.index,
                -clearance
            );
        }
    }
}

fn stop_regions_stay_apart<V: Space>(setup: CrowdSetup<V>, seconds: f64) {
    let mut crowd = Engine::new(setup).unwrap();
    let mut decisions = 0;
    while crowd.now < seconds {
        crowd.advance(crowd.now + 0.013, &mut |_| {}).unwrap();
        check_stop_regions(&crowd, crowd.now);
        assert!(crowd.counts.decisions >= decisions);
        decisions = crowd.counts.decisions;
    }
    assert!(decisions > 100);
}

#[test]
fn stop_regions_of_discs_are_apart_at_all_times() {
    stop_regions_stay_apart(crossing::<Vec2>(90, 0.9), 12.0);
}

#[test]
fn stop_regions_of_balls_are_apart_at_all_times() {
    stop_regions_stay_apart(crossing::<Vec3>(90, 1.0), 8.0);
}

#[test]
fn two_agents_meeting_head_on_pass() {
    // From afar, and from where they touch already.
    for apart in [6.0f32, 0.3003] {
        let mut setup = CrowdSetup::default();
        for side in [-1.0f32, 1.0] {
            let position = Vec2::new(side * apart, 0.0);
            setup.agents.push(Agent { position, route: Some(setup.routes.len()), ..Agent::default() });
            setup.routes.push(to(Vec2::new(-side * 6.0, 0.0)));
        }
        let mut crowd = Engine::new(setup).unwrap();
        let mut arrived = 0;
        crowd.advance(14.0, &mut |e| arrived += usize::from(e.kind == CrowdEventKind::Arrived)).unwrap();
        assert_eq!(arrived, 2, "{apart} m apart");
    }
}

#[test]
fn events_do_not_depend_on_how_time_is_cut() {
    let mut events = [Vec::new(), Vec::new()];
    let mut crowds = [0, 1].map(|_| Engine::new(crossing::<Vec2>(150, 1.0)).unwrap());
    crowds[0].advance(5.0, &mut |e| events[0].push(*e)).unwrap();
    for i in 1..=500 {
        crowds[1].advance(f64::from(i) * 0.01, &mut |e| events[1].push(*e)).unwrap();
    }
    assert_eq!(events[0], events[1]);
    assert_eq!(crowds[0].hash(), crowds[1].hash());
    assert!(events[0].is_sorted_by(|a, b| a.time <= b.time));
}

#[test]
fn any_number_of_threads_gives_the_same_events() {
    let mut alone = Vec::new();
    let setup = || {
        let mut setup = crossing::<Vec2>(900, 1.1);
        // Some leave on the way, so that places become free.
        setup.routes.iter_mut().step_by(3).for_each(|r| r.at_end = AtEnd::Leave);
        setup.routes.iter_mut().step_by(9).for_each(|r| r.subgoals[0] *= -0.8);
        setup
    };
    let mut crowd = Engine::new(setup()).unwrap();
    crowd.advance(4.0, &mut |e| alone.push(*e)).unwrap();
    assert!(crowd.counts.left > 3 && crowd.num_agents() < 900);
    for threads in [1, 2, 8] {
        let mut together = Vec::new();
        let mut other = Engine::new(setup()).unwrap();
        for until_s in [1.7, 4.0] {
            drive(&mut other, &mut |e| together.push(*e), |e| e.run_parallel(until_s, &Threads(threads))).unwrap();
        }
        assert_eq!(alone, together, "{threads} threads");
        assert_eq!(crowd.hash(), other.hash());
        assert_eq!(crowd.free, other.free);
        assert_eq!(crowd.counts, other.counts);
    }
}

#[test]
fn repeated_orders_take_no_more_memory() {
    let mut setup = crossing::<Vec2>(9, 2.0);
    (setup.config.capacity, setup.config.largest_radius_m) = (10, 0.3);
    let mut crowd = Engine::new(setup).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    for i in 0..40 {
        let away = Vec2::from_angle(i as f32) * 12.0;
        crowd.order(ids[i % 2], &along(to(away), 1.3)).unwrap();
        crowd.advance(0.2 * (i + 1) as f64, &mut |_| {}).unwrap();
        let x = crowd.position(ids[i % 2], crowd.now).unwrap();
        let desired = crowd.desired_direction(ids[i % 2]).unwrap();
        assert!((desired - (away - x).normalize()).length() < 1e-4, "it goes where it was sent last");
    }
    assert_eq!(crowd.scenery.paths.len(), 9 + 2);
    // Nor do agents that follow each other in one place.
    for _ in 0..5 {
        let position = Vec2::new(40.0, 40.0);
        let id = crowd.spawn(Agent { position, ..Agent::default() }).unwrap();
        crowd.order(id, &along(to(Vec2::ZERO), 1.0)).unwrap();
        crowd.despawn(id).unwrap();
    }
    assert_eq!(crowd.scenery.paths.len(), 9 + 3);
    let before = crowd.hash();
    assert!(crowd.order(ids[0], &along(to(Vec2::ZERO), 9.0)).is_err());
    assert!(crowd.order(ids[0], &along(Route { subgoals: vec![], ..to(Vec2::ZERO) }, 1.0)).is_err());
    assert_eq!(crowd.hash(), before);
    let kept = crowd.bytes();
    crowd.load(&kept).unwrap();
    crowd.order(ids[1], &along(to(Vec2::ZERO), 1.0)).unwrap();
    assert_eq!(crowd.scenery.paths.len(), 9 + 3);
}

#[test]
fn damaged_snapshot_is_refused() {
    let mut crowd = Engine::new(crossing::<Vec2>(20, 1.0)).unwrap();
    crowd.advance(1.0, &mut |_| {}).unwrap();
    let kept = crowd.bytes();
    let hash = crowd.hash();
    for len in (0..kept.len()).step_by(kept.len() / 50) {
        assert!(matches!(crowd.load(&kept[..len]), Err(CrowdError::Other(Error::Snapshot { .. }))));
    }
    let mut longer = kept.clone();
    longer.push(0);
    assert!(crowd.load(&longer).is_err());
    assert!(Engine::new(crossing::<Vec2>(21, 1.0)).unwrap().load(&kept).is_err());
    assert!(Engine::new(crossing::<Vec3>(20, 1.0)).unwrap().load(&kept).is_err());
    assert_eq!(crowd.hash(), hash);
}

#[test]
fn agents_enter_leave_and_come_again() {
    let mut setup = crossing::<Vec2>(9, 2.0);
    setup.config.capacity = 10;
    setup.config.largest_radius_m = 0.3;
    let mut crowd = Engine::new(setup).unwrap();
    let newcomer = Agent { position: Vec2::new(9.0, 9.0), ..Agent::default() };
    crowd.advance(0.5, &mut |_| {}).unwrap();
    let id = crowd.spawn(newcomer).unwrap();
    assert_eq!((crowd.num_agents(), id.index()), (10, 9));
    assert!(matches!(
        crowd.spawn(Agent { position: Vec2::ONE * 30.0, ..newcomer }),
        Err(CrowdError::Other(Error::Full { capacity: 10 }))
    ));
    crowd.advance(1.0, &mut |_| {}).unwrap();
    crowd.despawn(id).unwrap();
    assert!(matches!(crowd.despawn(id), Err(CrowdError::Other(Error::Gone(gone))) if gone == id));
    assert_eq!(crowd.position(id, 1.0), None);
    let other = crowd.ids().next().unwrap();
    let taken = crowd.position(other, 1.0).unwrap();
    let refused = crowd.spawn(Agent { position: taken + Vec2::X * 0.3, ..newcomer });
    let first = Id::first(0);
    assert!(
        matches!(refused, Err(CrowdError::Overlap { first: f, second, .. }) if f == first && second.index == 9),
        "{refused:?}"
    );
    let again = crowd.spawn(Agent { position: Vec2::new(9.0, 9.0), ..newcomer }).unwrap();
    assert!(again.index() == id.index() && again != id);
    crowd.advance(3.0, &mut |_| {}).unwrap();
    check_stop_regions(&crowd, 3.0);
}

#[test]
fn routes_end_as_they_say() {
    let mut setup = CrowdSetup::default();
    for (i, at_end) in [AtEnd::Stay, AtEnd::Leave, AtEnd::Again].into_iter().enumerate() {
        let y = i as f32 * 3.0;
        let subgoals = vec![Vec2::new(0.0, y), Vec2::new(4.0, y)];
        setup.routes.push(Route { subgoals, arrival_radius: 0.4, at_end });
        setup.agents.push(Agent { position: Vec2::new(0.0, y), route: Some(i), ..Agent::default() });
    }
    let mut crowd = Engine::new(setup).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    let mut arrived = [0; 3];
    crowd
        .advance(15.0, &mut |e| {
            if e.kind == CrowdEventKind::Arrived {
                arrived[e.agent.index()] += 1;
            }
        })
        .unwrap();
    assert_eq!(arrived[..2], [1, 1]);
    assert!(arrived[2] > 1, "goes round again and again");
    assert_eq!((crowd.num_agents(), crowd.counts.left), (2, 1));
    let (x, v) = (crowd.position(ids[0], 15.0).unwrap(), crowd.velocity(ids[0], 15.0).unwrap());
    assert!((x - Vec2::new(4.0, 0.0)).length() < 0.4 && v.length() < 0.05, "{x} {v}");
}

#[test]
fn nobody_goes_through_walls() {
    let mut setup = crossing::<Vec2>(60, 0.9);
    setup.agents.iter_mut().for_each(|m| m.position.x -= 6.0);
    for r in &mut setup.routes {
        r.subgoals[0].x += 12.0;
    }
    setup.obstacles = vec![
        Obstacle::Wall { from: Vec2::new(0.0, -30.0), to: Vec2::new(0.0, -0.8), radius: 0.1 },
        Obstacle::Polygon { corners: vec![Vec2::new(0.0, 0.8), Vec2::new(1.0, 30.0), Vec2::new(-1.0, 30.0)] },
        Obstacle::Box { min: Vec2::new(3.0, -1.0), max: Vec2::new(4.0, 1.0) },
    ];
    let mut crowd = Engine::new(setup).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    while crowd.now < 15.0 {
        crowd.advance(crowd.now + 0.05, &mut |_| {}).unwrap();
        for id in &ids {
            let x = crowd.position(*id, crowd.now).unwrap();
            let r = crowd.agent(*id).unwrap().radius;
            for solid in &crowd.scenery.solids {
                assert!(solid.direction_and_distance(x).1 >= r, "{x} is in {solid:?}");
            }
        }
    }
    let through = ids.iter().filter(|id| crowd.position(**id, 15.0).unwrap().x > 0.5).count();
    assert!(through > 4, "{through} came through the gap");
}

#[test]
fn agent_in_the_open_avoids_moving_obstacle() {
    let still = Agent { position: Vec2::new(0.0, 0.05), speed: 1.0, ..Agent::default() };
    let path = vec![(0.0, Vec2::new(-8.0, 0.0)), (10.0, Vec2::new(8.0, 0.0))];
    let setup = CrowdSetup {
        agents: vec![still],
        routes: vec![to(Vec2::ZERO)],
        obstacles: vec![Obstacle::Mover { path, radius: 0.8 }],
        ..CrowdSetup::default()
    };
    let mut crowd = Engine::new(setup).unwrap();
    let id = crowd.ids().next().unwrap();
    let mut farthest = 0.0f32;
    while crowd.now < 14.0 {
        crowd.advance(crowd.now + 0.05, &mut |_| {}).unwrap();
        let x = crowd.position(id, crowd.now).unwrap();
        farthest = farthest.max(x.length());
        let obstacle = Vec2::new(-8.0 + 1.6 * crowd.now.min(10.0) as f32, 0.0);
        assert!((x - obstacle).length() > 1.1 - 1e-3, "{x} {obstacle}");
    }
    assert_eq!(crowd.counts.struck, 0);
    assert!(farthest > 0.5, "it moved");
}

#[test]
fn impossible_starts_are_named() {
    let good = || crossing::<Vec2>(4, 2.0);
    let error = |setup: CrowdSetup<Vec2>| Engine::new(setup).unwrap_err();
    let mut s = good();
    s.agents[2].position = s.agents[1].position + Vec2::splat(0.1);
    assert!(matches!(error(s), CrowdError::Overlap { first, second, .. } if (first.index, second.index) == (1, 2)));
    let mut s = good();
    s.obstacles.push(Obstacle::Ball { centre: s.agents[3].position, radius: 0.5 });
    assert!(matches!(error(s), CrowdError::Inside { obstacle: 0, .. } | CrowdError::Goal { .. }));
    let mut s = good();
    let g = s.routes[1].subgoals[0] + Vec2::new(40.0, 0.0);
    s.routes[1].subgoals[0] = g;
    let corners = vec![g + Vec2::new(-1.0, -1.0), g + Vec2::new(1.0, -1.0), g + Vec2::new(0.0, 2.0)];
    s.obstacles.push(Obstacle::Polygon { corners });
    assert!(matches!(error(s), CrowdError::Goal { route: 1, subgoal: 0, obstacle: 0 }));
    let mut s = good();
    s.agents[0].route = Some(9);
    assert!(matches!(error(s), CrowdError::Other(Error::Index { what: "route", got: 9, limit: 4, .. })));
    let mut s = good();
    s.agents[0].radius = f32::NAN;
    assert!(matches!(error(s), CrowdError::Other(Error::Value { what: "agent.radius", .. })));
    let mut s = good();
    s.config.smallest_interval_s = 0.0;
    assert!(matches!(error(s), CrowdError::Other(Error::Value { what: "config.smallest_interval_s", .. })));
    let mut s = good();
    s.fields[0].relaxation_s = -1.0;
    assert!(matches!(error(s), CrowdError::Other(Error::Value { what: "field.relaxation_s", .. })));
    let mut crowd = Engine::new(good()).unwrap();
    crowd.advance(1.0, &mut |_| {}).unwrap();
    let past = crowd.advance(0.5, &mut |_| {});
    assert!(matches!(past, Err(CrowdError::Other(Error::Value { what: "time", .. }))), "{past:?}");
    assert!(crowd.advance(f64::NAN, &mut |_| {}).is_err());
}

#[test]
fn stalled_crowd_names_the_pair() {
    let mut crowd = Engine::new(crossing::<Vec2>(30, 0.8)).unwrap();
    crowd.advance(2.0, &mut |_| {}).unwrap();
    let met = |c: &Engine<Vec2>| c.ids().find_map(|id| Some((id, c.partner(c.states[id.index()].cause)?)));
    let (first, second) = met(&crowd).unwrap();
    // As if its event came again and again, and never a later one.
    let storm = (0..100).find_map(|_| {
        crowd.states[first.index()].cause = crate::events::decide::Cause::Agent(second);
        crowd.process_event(first.index).err()
    });
    match storm {
        Some(CrowdError::Stalled { first: a, second: b, .. }) => {
            assert_eq!((a, b.map(|b| b.index)), (first, Some(second)))
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn bounds_hold_agents_until_their_next_event() {
    let mut crowd = Engine::new(crossing::<Vec2>(80, 1.0)).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    while crowd.now < 4.0 {
        crowd.advance(crowd.now + 0.03, &mut |_| {}).unwrap();
        for id in &ids {
            let (centre, radius) = crowd.bound(*id, crowd.now).unwrap();
            let x = crowd.position(*id, crowd.now).unwrap();
            let r = crowd.agent(*id).unwrap().radius;
            assert!((x - centre).length() + r <= radius + 1e-4);
            assert!(crowd.next_event(*id).unwrap() >= crowd.now);
        }
    }
}

#[test]
fn interests_attract_and_repel() {
    let end = |strength| {
        let mut setup = CrowdSetup { agents: vec![Agent { speed: 0.0, ..Agent::default() }], ..CrowdSetup::default() };
        setup.routes.push(to(Vec2::ZERO));
        setup.config.largest_speed_mps = 1.0;
        setup.interests.push(Interest { position: Vec2::new(3.0, 0.0), strength, reach: 6.0 });
        let mut crowd = Engine::new(setup).unwrap();
        crowd.advance(5.0, &mut |_| {}).unwrap();
        crowd.position(crowd.ids().next().unwrap(), 5.0).unwrap().x
    };
    assert!(end(1.0) > 0.2 && end(-1.0) < -0.2 && end(0.0) == 0.0, "{} {} {}", end(1.0), end(-1.0), end(0.0));
}

#[test]
fn forces_add_up_to_the_terms_of_the_field() {
    let mut crowd = Engine::new(crossing::<Vec2>(40, 0.9)).unwrap();
    crowd.advance(2.0, &mut |_| {}).unwrap();
    let id = crowd.ids().nth(20).unwrap();
    let (f, m) = (crowd.forces(id).unwrap(), crowd.agent(id).unwrap());
    let desired = crowd.desired_direction(id).unwrap();
    let driving = (desired * m.speed - m.velocity) / ForceField::default().relaxation_s;
    assert!((f.driving - driving).length() < 1e-3, "first term of eq. 17: {} {driving}", f.driving);
    assert_eq!(f.taken, crowd.acceleration(id, crowd.last_event(id).unwrap()).unwrap());
    assert!(f.taken.length() <= m.acceleration * 1.0001);
}
