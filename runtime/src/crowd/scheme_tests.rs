//! The three schemes against brute force, by hand, and against each other.

use super::bound::Bound;
use super::occupancy::{Occupancy, WIDEST};
use super::occupied::{CONTACT, REST};
use super::tracing::Trace;
use super::*;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

const SCHEMES: [Scheme; 3] = [Scheme::Registration, Scheme::Occupancy, Scheme::Fixed];

/// Two groups that walk through each other, past a pillar, some of them to a stop before a wall.
fn meeting<V: Space>(scheme: Scheme, rows: usize) -> Setup<V> {
    let mut setup = Setup { config: CrowdConfig { scheme, ..CrowdConfig::default() }, ..Setup::default() };
    for i in 0..8 * rows {
        let (side, row, column) = (i % 2, i / 2 % 4, i / 8);
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let sway = 0.13 * ((i * 7 % 5) as f32 - 2.0);
        let height = 0.8 * (i * 3 % 4) as f32;
        let at = |x: f32| V::from_coordinates([x, 0.9 * row as f32 + sway, height]);
        let start = -sign * (1.6 + 0.8 * column as f32);
        let goal = if i % 3 == 0 { sign * 1.5 } else { sign * 9.0 };
        setup.routes.push(Route { subgoals: vec![at(goal)], arrival_radius: 0.3, at_end: AtEnd::Stay });
        setup.members.push(Member {
            position: at(start),
            route: i,
            radius: 0.2 + 0.02 * row as f32,
            ..Member::default()
        });
    }
    setup.obstacles.push(Obstacle::Ball { centre: V::from_coordinates([0.3, 1.9, 1.0]), radius: 0.3 });
    let corner = |x: f32, y: f32| V::from_coordinates([x, y, 0.0]);
    setup.obstacles.push(Obstacle::Wall { from: corner(-9.0, -1.3), to: corner(9.0, -1.3), radius: 0.1 });
    setup
}

fn pair(scheme: Scheme, gap: f32, speed: f32) -> Setup<Vec2> {
    let x = 0.3 + 0.5 * gap;
    let member = |sign: f32, route| Member {
        position: Vec2::new(sign * x, 0.5),
        velocity: Vec2::new(-sign * speed, 0.0),
        speed,
        route,
        ..Member::default()
    };
    let route = |sign: f32| Route {
        subgoals: vec![Vec2::new(if speed > 0.0 { -sign * 20.0 } else { sign * x }, 0.5)],
        arrival_radius: 0.1,
        at_end: AtEnd::Stay,
    };
    Setup {
        members: vec![member(-1.0, 0), member(1.0, 1)],
        routes: vec![route(-1.0), route(1.0)],
        config: CrowdConfig { scheme, ..CrowdConfig::default() },
        ..Setup::default()
    }
}

/// A field with nothing but driving.
fn driven() -> Field {
    Field {
        following: 0.0,
        repulsion: 0.0,
        braking: 0.0,
        damping: 0.0,
        avoiding: 0.0,
        turning: 0.0,
        safety: 0.0,
        // Nobody is seen.
        perception_m: 1e-3,
        ..Field::default()
    }
}

/// Runs to a time, and calls `check` after every event.
fn at_every_event<V: Space>(crowd: &mut Crowd<V>, until: f64, mut check: impl FnMut(&Crowd<V>)) {
    while let Some((time, _)) = crowd.queue.first(until) {
        crowd.advance(time, &mut |_| ()).unwrap();
        check(crowd);
    }
}

fn occupancy<V: Space>(crowd: &Crowd<V>) -> &Occupancy {
    match &crowd.trace {
        Trace::Occupancy(o) => o,
        other => panic!("another scheme: {other:?}"),
    }
}

fn no_overlap<V: Space>(crowd: &Crowd<V>, most: f32) {
    let ids: Vec<Id> = crowd.ids().collect();
    let members: Vec<Member<V>> = ids.iter().map(|&id| crowd.member(id).unwrap()).collect();
    for (i, a) in members.iter().enumerate() {
        for b in &members[..i] {
            let gap = (a.position - b.position).length() - a.radius - b.radius;
            assert!(gap >= -most, "overlap of {} m at {} s", -gap, crowd.now());
        }
    }
}

fn registration_holds<V: Space>() {
    let mut crowd = Crowd::new(meeting::<V>(Scheme::Registration, 4)).unwrap();
    let mut near = 0;
    at_every_event(&mut crowd, 6.0, |crowd| {
        let bounds: Vec<_> = crowd.ids().map(|id| (id, Bound::from(crowd.cells.plan(id.index)))).collect();
        let half = V::from_coordinates([crowd.cells.side(); 3]);
        for (n, (id, bound)) in bounds.iter().enumerate() {
            let at = crowd.cells.coordinates(bound.position);
            assert_eq!(crowd.minds[id.index()].cell, crowd.cells.number(at), "registered where its centre was");
            let (x, radius) = bound.at(crowd.now());
            let room = (x - crowd.cells.centre(at) + half).min(crowd.cells.centre(at) + half - x).coordinates();
            let least = room.iter().take(V::DIMENSIONS).fold(f32::INFINITY, |a, &b| a.min(b));
            assert!(least >= radius - 1e-3, "bound of {id:?} is {} m out of its region", radius - least);
            for (other, b) in &bounds[..n] {
                let (y, s) = b.at(crowd.now());
                let far = crowd.cells.coordinates(b.position);
                let is_near = (0..3).all(|i| (at[i] - far[i]).abs() <= 1);
                let touches = (x - y).length() < radius + s - 1e-3;
                near += usize::from(is_near && (x - y).length() < radius + s + 0.1);
                assert!(is_near || !touches, "bounds of {id:?} and {other:?} touch from cells that are apart");
            }
        }
        no_overlap(crowd, 0.0);
    });
    assert!(near > 100 && crowd.counts().colliding > 100, "the test sees bounds that touch");
}

#[test]
fn bounds_of_discs_stay_in_their_regions() {
    registration_holds::<Vec2>();
}

#[test]
fn bounds_of_balls_stay_in_their_regions() {
    registration_holds::<Vec3>();
}

/// Lists hold exactly those whose bounds reach into a cell.
fn lists_are_exact<V: Space>(crowd: &Crowd<V>) {
    let (o, side) = (occupancy(crowd), crowd.cells.side());
    for id in crowd.ids() {
        let (x, radius) = crowd.bound(id, crowd.now()).unwrap();
        let occupant = &o.occupants[id.index()];
        for axis in 0..V::DIMENSIONS {
            let (x, low, high) = (x.coordinates()[axis], occupant.low[axis], occupant.high[axis]);
            let (from, to) = (low as f32 * side, (high + 1) as f32 * side);
            assert!(high - low <= 1 && 2.0 * radius <= side, "{radius} m wide in {low}..={high}");
            assert!(x - radius >= from - 1e-4 && x + radius <= to + 1e-4, "{id:?} is out of its cells");
            let reaches = x - radius <= (low + 1) as f32 * side + 1e-4 && x + radius >= high as f32 * side - 1e-4;
            assert!(reaches, "{id:?} is listed where it is not: {x} +- {radius} in {low}..={high} of {side} m");
        }
        let mut found = 0;
        for z in occupant.low[2]..=occupant.high[2] {
            for y in occupant.low[1]..=occupant.high[1] {
                for x in occupant.low[0]..=occupant.high[0] {
                    o.each(&crowd.cells, [x, y, z], [x, y, z], |m| found += usize::from(m == id.index));
                }
            }
        }
        let want: i32 = (0..3).map(|i| occupant.high[i] - occupant.low[i] + 1).product();
        assert_eq!(found, want as usize, "once in each of its cells");
    }
}

/// Whose bounds have touched for longer than the smallest interval was asked for another plan, or is in contact.
fn nobody_is_unseen<V: Space>(crowd: &Crowd<V>) -> usize {
    let (o, now) = (occupancy(crowd), crowd.now());
    let ids: Vec<Id> = crowd.ids().collect();
    let mut touching = 0;
    for (n, &a) in ids.iter().enumerate() {
        let (x, r) = crowd.bound(a, now).unwrap();
        for &b in &ids[..n] {
            let (y, s) = crowd.bound(b, now).unwrap();
            if (x - y).length() > r + s - 1e-3 || o.contacts.are_together(a.index, b.index) {
                continue;
            }
            touching += 1;
            let asked = o.occupants[a.index()].asked.max(o.occupants[b.index()].asked);
            assert!(
                now - asked <= f64::from(crowd.world.interval) + 1e-6,
                "{a:?} and {b:?} unseen for {}",
                now - asked
            );
        }
    }
    touching
}

/// Contacts are those of members that touch and do not move relative to each other.
fn contacts_are_true<V: Space>(crowd: &Crowd<V>) -> usize {
    let o = occupancy(crowd);
    let mut num_contacts = 0;
    for a in crowd.ids() {
        for b in o.contacts.of(a.index) {
            let (p, q) = (crowd.cells.plan(a.index), crowd.cells.plan(b));
            let ((x, v), (y, w)) = (p.at(crowd.now()), q.at(crowd.now()));
            let gap = (x - y).length() - p.radius - q.radius;
            assert!(gap <= CONTACT + 0.01 && (v - w).length() <= 2.0 * REST, "{gap} m, {} m/s", (v - w).length());
            num_contacts += 1;
        }
    }
    num_contacts
}

fn occupancy_holds<V: Space>() {
    let mut crowd = Crowd::new(meeting::<V>(Scheme::Occupancy, 4)).unwrap();
    let mut touching = 0;
    at_every_event(&mut crowd, 6.0, |crowd| {
        lists_are_exact(crowd);
        contacts_are_true(crowd);
        touching += nobody_is_unseen(crowd);
        no_overlap(crowd, 0.0);
    });
    let counts = crowd.counts();
    assert!(touching > 0 && counts.entering > 0 && counts.leaving > 0 && counts.colliding > 0, "{counts:?}");
}

#[test]
fn discs_are_listed_where_they_are_and_meet_nobody_unseen() {
    occupancy_holds::<Vec2>();
}

#[test]
fn balls_are_listed_where_they_are_and_meet_nobody_unseen() {
    occupancy_holds::<Vec3>();
}

#[test]
fn between_events_nobody_is_unseen_either() {
    let mut crowd = Crowd::new(meeting::<Vec2>(Scheme::Occupancy, 4)).unwrap();
    let touching: usize = (1..1200)
        .map(|i| {
            crowd.advance(f64::from(i) * 0.005, &mut |_| ()).unwrap();
            lists_are_exact(&crowd);
            nobody_is_unseen(&crowd)
        })
        .sum();
    assert!(touching > 0);
}

/// A row of members who stand and touch, the last of whom is sent away after a while.
fn row() -> Setup<Vec2> {
    let mut setup = pair(Scheme::Occupancy, 0.005, 0.0);
    setup.fields = vec![driven()];
    setup.config.largest_speed_mps = 1.3;
    for i in 2..5 {
        let position = Vec2::new(0.3025 + 0.605 * (i - 1) as f32, 0.5);
        setup.routes.push(Route { subgoals: vec![position], ..setup.routes[0].clone() });
        setup.members.push(Member { position, route: i, ..setup.members[0] });
    }
    setup
}

#[test]
fn who_stands_in_contact_is_left_alone_until_somebody_goes() {
    let mut crowd = Crowd::new(row()).unwrap();
    let ids: Vec<Id> = crowd.ids().collect();
    crowd.advance(1.0, &mut |_| ()).unwrap();
    assert_eq!((crowd.counts().contacting, crowd.counts().separating), (4, 0), "{:?}", crowd.counts());
    let before = crowd.counts();
    at_every_event(&mut crowd, 6.0, |crowd| assert_eq!(contacts_are_true(crowd), 8));
    let counts = crowd.counts();
    assert_eq!(counts.colliding, before.colliding, "none within the group");
    // Nothing but the growth of bounds makes them act: once in sqrt(2 (side / 2 - r) / A).
    let grown = (2.0 * (0.5 * WIDEST * crowd.cell_side() - 0.3) / 5.0f32).sqrt();
    let per_member = (counts.resetting - before.resetting) as f32 / 5.0;
    assert!((per_member - 5.0 / grown).abs() <= 1.0, "{per_member} of {}", 5.0 / grown);

    // The third of five leaves upward: the group splits into two of two and one alone.
    let away = Route { subgoals: vec![Vec2::new(0.9, 30.0)], arrival_radius: 0.3, at_end: AtEnd::Stay };
    let route = crowd.add_route(away).unwrap();
    crowd.send(ids[2], route, 1.3).unwrap();
    crowd.advance(9.0, &mut |_| ()).unwrap();
    assert_eq!(crowd.counts().separating, 2, "{:?}", crowd.counts());
    let contacts = &occupancy(&crowd).contacts;
    let together = |a: usize, b: usize| contacts.are_together(ids[a].index, ids[b].index);
    assert!(together(0, 1) && together(3, 4) && !together(1, 3) && !together(1, 2));

    // Who leaves the crowd leaves its group.
    crowd.leave(ids[0]).unwrap();
    assert!(occupancy(&crowd).contacts.of(ids[1].index).next().is_none());
    at_every_event(&mut crowd, 12.0, lists_are_exact);
}

#[test]
fn bounds_of_two_who_stand_meet_when_they_have_grown_into_the_gap() {
    // 0.6 = 2 * 5 / 2 t^2
    let exact = (0.6f64 / 5.0).sqrt();
    for scheme in [Scheme::Registration, Scheme::Occupancy] {
        let mut setup = pair(scheme, 0.6, 0.0);
        setup.config.cell_side_m = 4.0;
        let mut crowd = Crowd::new(setup).unwrap();
        let mut times = Vec::new();
        let note = &mut |e: &Event| {
            if matches!(e.kind, EventKind::Colliding { .. }) {
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
fn a_bound_enters_and_leaves_cells_as_solved_by_hand() {
    // At 1 m/s from 0.5 m before a face, with radius 0.2 m and acceleration 0.2 m/s2.
    let mut setup = pair(Scheme::Occupancy, 9.0, 0.0);
    setup.members.truncate(1);
    setup.fields = vec![driven()];
    setup.config.cell_side_m = 10.0;
    setup.routes[0].subgoals = vec![Vec2::new(100.0, 4.0)];
    setup.members[0] = Member {
        position: Vec2::new(9.5, 4.0),
        velocity: Vec2::X,
        speed: 1.0,
        radius: 0.2,
        acceleration: 0.2,
        ..setup.members[0]
    };
    let mut crowd = Crowd::new(setup).unwrap();
    let mut times = Vec::new();
    crowd.advance(3.0, &mut |e| times.push((e.kind, e.time))).unwrap();
    // 0.5 - 0.2 = t + 0.1 t^2, and 0.5 + 0.2 = t - 0.1 t^2.
    let (enters, leaves) = ((1.12f64.sqrt() - 1.0) / 0.2, (1.0 - 0.72f64.sqrt()) / 0.2);
    for (kind, want) in [(EventKind::Entering, enters), (EventKind::Leaving, leaves)] {
        let got = times.iter().find(|e| e.0 == kind).unwrap();
        assert!((got.1 - want).abs() < 1e-3, "{kind:?} at {want} in {times:?}");
    }
}

#[test]
fn no_member_acts_twice_within_the_smallest_interval() {
    for scheme in [Scheme::Registration, Scheme::Occupancy] {
        let mut crowd = Crowd::new(meeting::<Vec2>(scheme, 5)).unwrap();
        let (mut last, mut of_pair): (BTreeMap<Id, f64>, BTreeMap<(Id, Id), [f64; 2]>) = Default::default();
        let (mut least, mut least_of_pair) = (f64::INFINITY, f64::INFINITY);
        let mut crossings = 0;
        let note = &mut |e: &Event| match e.kind {
            EventKind::Resetting | EventKind::Colliding { .. } | EventKind::Meeting { .. } => {
                least = least.min(e.time - last.insert(e.member, e.time).unwrap_or(-1.0));
                if let EventKind::Colliding { other } = e.kind {
                    let pair = of_pair.entry((e.member.min(other), e.member.max(other))).or_insert([-1.0; 2]);
                    least_of_pair = least_of_pair.min(e.time - pair[0]);
                    *pair = [pair[1], e.time];
                }
            }
            EventKind::Entering | EventKind::Leaving => crossings += 1,
            _ => (),
        };
        crowd.advance(10.0, note).unwrap();
        assert!(of_pair.len() > 20 && least >= 0.1 - 1e-6, "{scheme:?}: {least} s between events of a member");
        assert!(least_of_pair >= 0.1 - 1e-6, "{scheme:?}: {least_of_pair} s for three events of a pair");
        // Each axis of a bound has two faces, each of which it crosses three times at most.
        assert!(crossings <= 12 * crowd.counts().decisions, "{scheme:?}: {:?}", crowd.counts());
    }
}

#[test]
fn runs_are_repeated_bit_by_bit_however_they_are_cut() {
    for scheme in SCHEMES {
        let mut whole = Crowd::new(meeting::<Vec2>(scheme, 4)).unwrap();
        let mut cut = whole.clone();
        whole.advance(5.0, &mut |_| ()).unwrap();
        for i in 1..=71 {
            cut.advance(5.0 * f64::from(i) / 71.0, &mut |_| ()).unwrap();
        }
        assert_eq!(whole.state_hash(), cut.state_hash(), "{scheme:?}");
        assert_eq!(whole.counts(), cut.counts(), "{scheme:?}");
    }
}

#[test]
fn what_follows_a_snapshot_follows_it_again() {
    for scheme in SCHEMES {
        let setup = meeting::<Vec3>(scheme, 4);
        let mut crowd = Crowd::new(setup.clone()).unwrap();
        crowd.advance(2.34, &mut |_| ()).unwrap();
        let kept = crowd.snapshot();
        crowd.advance(6.0, &mut |_| ()).unwrap();
        let (hash, counts) = (crowd.state_hash(), crowd.counts());
        let mut other = Crowd::new(setup.clone()).unwrap();
        for crowd in [&mut crowd, &mut other] {
            crowd.restore(&kept).unwrap();
            assert_eq!(crowd.snapshot(), kept, "{scheme:?}");
            crowd.advance(6.0, &mut |_| ()).unwrap();
            assert_eq!((crowd.state_hash(), crowd.counts()), (hash, counts), "{scheme:?}");
        }
        for scheme in SCHEMES.into_iter().filter(|&s| s != scheme) {
            let mut setup = setup.clone();
            setup.config.scheme = scheme;
            setup.config.cell_side_m = crowd.cell_side();
            let error = Crowd::new(setup).unwrap().restore(&kept).unwrap_err();
            assert!(matches!(error, CrowdError::Snapshot { .. }), "{error}");
        }
    }
}

/// What a scheme remembers is refused where it is damaged, or does no harm.
#[test]
fn a_damaged_memory_is_refused_or_runs() {
    for scheme in [Scheme::Occupancy, Scheme::Fixed] {
        let mut crowd = Crowd::new(meeting::<Vec2>(scheme, 2)).unwrap();
        crowd.advance(2.0, &mut |_| ()).unwrap();
        let kept = crowd.snapshot();
        let config = bincode::config::standard().with_fixed_int_encoding();
        let memory = bincode::serde::encode_to_vec(&crowd.trace, config).unwrap();
        let first = kept.windows(memory.len()).position(|w| w == memory).unwrap();
        for at in (first..first + memory.len()).step_by(3) {
            let mut bytes = kept.clone();
            bytes[at] ^= 1 << (at % 8);
            if crowd.restore(&bytes).is_ok() {
                // Whatever it says; that it ends is enough.
                let _ = crowd.advance(crowd.now() + 0.2, &mut |_| ());
            }
        }
    }
}

#[test]
fn who_comes_and_goes_is_listed_and_unlisted() {
    for scheme in SCHEMES {
        let mut setup = meeting::<Vec2>(scheme, 3);
        setup.config.capacity = 40;
        for route in &mut setup.routes {
            route.at_end = AtEnd::Leave;
        }
        let mut crowd = Crowd::new(setup.clone()).unwrap();
        let mut entered = 0;
        for i in 1..200 {
            crowd.advance(0.07 * f64::from(i), &mut |_| ()).unwrap();
            entered += usize::from(crowd.enter(setup.members[i as usize % 24]).is_ok());
            if i % 20 == 0 {
                let id = crowd.ids().next().unwrap();
                crowd.leave(id).unwrap();
            }
            no_overlap(&crowd, if scheme == Scheme::Fixed { 2e-3 } else { 0.0 });
            if scheme == Scheme::Occupancy {
                lists_are_exact(&crowd);
                let listed = occupancy(&crowd).occupants.iter().filter(|o| o.is_listed).count();
                assert_eq!(listed, crowd.num_members());
            }
        }
        assert!(entered > 3 && crowd.counts().left > 3, "{scheme:?}: {entered} entered, {:?}", crowd.counts());
    }
}

#[test]
fn impossible_starts_are_errors_in_every_scheme() {
    for scheme in SCHEMES {
        let overlapping = pair(scheme, -0.05, 0.0);
        assert!(matches!(Crowd::new(overlapping).unwrap_err(), CrowdError::Overlap { first: 0, second: 1, .. }));
        let mut walled = pair(scheme, 1.0, 0.0);
        walled.obstacles.push(Obstacle::Ball { centre: walled.members[0].position + Vec2::Y * 0.4, radius: 0.2 });
        walled.routes[0].subgoals[0] += Vec2::NEG_Y;
        assert!(matches!(Crowd::new(walled).unwrap_err(), CrowdError::Inside { member: 0, obstacle: 0 }));
    }
    let mut setup = pair(Scheme::Fixed, 1.0, 0.0);
    setup.config.step_s = 0.0;
    assert!(matches!(Crowd::new(setup).unwrap_err(), CrowdError::Value { field: "step_s", .. }));
    let mut setup = pair(Scheme::Fixed, 1.0, 0.0);
    setup.config.halvings = 40;
    assert!(matches!(Crowd::new(setup).unwrap_err(), CrowdError::Value { field: "halvings", .. }));
    // A bound that is wider than a cell before anybody may act.
    let mut setup = pair(Scheme::Occupancy, 1.0, 0.0);
    setup.config.capacity = 3;
    let strong = Member { acceleration: 900.0, position: Vec2::new(0.0, 9.0), ..setup.members[0] };
    let mut crowd = Crowd::new(setup).unwrap();
    assert!(matches!(crowd.enter(strong).unwrap_err(), CrowdError::Value { field: "acceleration", .. }));
}

#[test]
fn a_fixed_step_changes_the_velocity_as_solved_by_hand() {
    let mut setup = pair(Scheme::Fixed, 30.0, 1.3);
    setup.members.truncate(1);
    setup.members[0].velocity = Vec2::ZERO;
    setup.fields = vec![driven()];
    let tau = setup.fields[0].relaxation_s;
    let from = setup.members[0].position;
    let mut crowd = Crowd::new(setup).unwrap();
    let id = crowd.ids().next().unwrap();
    let (mut x, mut v) = (0.0f32, 0.0f32);
    for step in 1..=10 {
        // Eq. 14 with eq. 17.
        let a = (1.3 - v) / tau;
        (x, v) = (x + (v + 0.5 * a / 30.0) / 30.0, v + a / 30.0);
        crowd.advance(f64::from(step) / 30.0 - 1e-6, &mut |_| ()).unwrap();
        let got = (crowd.position(id, crowd.now()).unwrap() - from, crowd.velocity(id, crowd.now()).unwrap());
        assert!((got.0.x - x).abs() < 1e-4 && (got.1.x - v).abs() < 1e-4, "{got:?} for {x} and {v}");
    }
    assert_eq!((crowd.counts().steps, crowd.counts().undone, crowd.counts().decisions), (10, 0, 10));
}

#[test]
fn two_who_run_into_each_other_in_fixed_steps_are_stopped_where_they_touch() {
    let mut setup = pair(Scheme::Fixed, 1.0, 1.3);
    setup.fields = vec![driven()];
    setup.config.halvings = 3;
    let mut crowd = Crowd::new(setup).unwrap();
    for i in 1..300 {
        crowd.advance(f64::from(i) * 0.01, &mut |_| ()).unwrap();
        no_overlap(&crowd, 1.001e-3);
    }
    let ids: Vec<Id> = crowd.ids().collect();
    let apart = (crowd.position(ids[0], 3.0).unwrap() - crowd.position(ids[1], 3.0).unwrap()).length();
    assert!((apart - 0.6).abs() < 5e-3, "they are {apart} m apart");
    let counts = crowd.counts();
    assert!(counts.undone > 3 && counts.overlaps == 0, "{counts:?}");
}

#[test]
fn events_and_steps_bring_members_to_the_same_goals() {
    let left = |scheme| {
        let mut crowd = Crowd::new(meeting::<Vec2>(scheme, 2)).unwrap();
        crowd.advance(15.0, &mut |_| ()).unwrap();
        let ids: Vec<Id> = crowd.ids().collect();
        ids.iter().map(|&id| crowd.way_left(id).unwrap()).sum::<f32>() / ids.len() as f32
    };
    let left = SCHEMES.map(left);
    assert!(left.iter().all(|&l| l < 1.5), "way left in each scheme: {left:?}");
}
