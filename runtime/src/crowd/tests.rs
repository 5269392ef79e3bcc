//! Tests of whole crowds.

use super::plan::Plan;
use super::safety::room;
use super::*;
use glam::{Vec2, Vec3};

/// A small seeded generator of shares.
pub(super) struct Shares(pub(super) u64);

impl Shares {
    pub(super) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

fn to<V: Space>(goal: V) -> Route<V> {
    Route { subgoals: vec![goal], arrival_radius: 0.5, at_end: AtEnd::Stay }
}

/// Members on a jittered lattice who want to go to the other side of it.
pub(super) fn crossing<V: Space>(num: usize, spacing: f32) -> Setup<V> {
    let mut shares = Shares(3);
    let across = (num as f32).powf(1.0 / V::DIMENSIONS as f32).ceil() as usize;
    let mut setup = Setup::default();
    for i in 0..num {
        let at = [i % across, i / across % across, i / across / across];
        let c = at.map(|c| (c as f32 - 0.5 * across as f32 + 0.3 * shares.next()) * spacing);
        let position = V::from_coordinates(c);
        setup.routes.push(to(-position));
        setup.members.push(Member { position, route: i, radius: 0.25 + 0.05 * shares.next(), ..Member::default() });
    }
    setup
}

/// The invariant of the safety rule, at one time.
fn check_stop_regions<V: Space>(crowd: &Crowd<V>, time: f64) {
    let plans: Vec<Plan<V>> = crowd
        .ids()
        .map(|id| {
            let plan = crowd.cells.plan(id.index);
            let (position, velocity) = plan.at(time);
            Plan { position, velocity, ..plan }
        })
        .collect();
    for (i, a) in plans.iter().enumerate() {
        for b in &plans[..i] {
            let room = room(a, b);
            assert!(room > 0.0, "stop regions of {} and {} overlap by {} m at {time}", a.index, b.index, -room);
        }
    }
}

fn stop_regions_stay_apart<V: Space>(setup: Setup<V>, seconds: f64) {
    let mut crowd = Crowd::new(setup).unwrap();
    let mut decisions = 0;
    while crowd.now() < seconds {
        crowd.advance(crowd.now() + 0.013, &mut |_| {}).unwrap();
        check_stop_regions(&crowd, crowd.now());
        assert!(crowd.counts().decisions >= decisions);
        decisions = crowd.counts().decisions;
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
fn two_who_meet_head_on_pass_each_other() {
    // From afar, and from where they touch already.
    for apart in [6.0f32, 0.3003] {
        let mut setup = Setup::default();
        for side in [-1.0f32, 1.0] {
            let position = Vec2::new(side * apart, 0.0);
            setup.members.push(Member { position, route: setup.routes.len(), ..Member::default() });
            setup.routes.push(to(Vec2::new(-side * 6.0, 0.0)));
        }
        let mut crowd = Crowd::new(setup).unwrap();
        let mut arrived = 0;
        crowd.advance(14.0, &mut |e| arrived += usize::from(e.kind == EventKind::Arrived)).unwrap();
        assert_eq!(arrived, 2, "{apart} m apart");
    }
}

#[test]
fn events_do_not_depend_on_how_time_is_cut() {
    let mut events = [Vec::new(), Vec::new()];
    let mut crowds = [0, 1].map(|_| Crowd::new(crossing::<Vec2>(150, 1.0)).unwrap());
    crowds[0].advance(5.0, &mut |e| events[0].push(*e)).unwrap();
    for i in 1..=500 {
        crowds[1].advance(f64::from(i) * 0.01, &mut |e| events[1].push(*e)).unwrap();
    }
    assert_eq!(events[0], events[1]);
    assert_eq!(crowds[0].state_hash(), crowds[1].state_hash());
    assert!(events[0].is_sorted_by(|a, b| a.time <= b.time));
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_gives_the_same_events() {
    let mut alone = Vec::new();
    let setup = || {
        let mut setup = crossing::<Vec2>(900, 1.1);
        // Some leave on the way, so that numbers become free.
        setup.routes.iter_mut().step_by(3).for_each(|r| r.at_end = AtEnd::Leave);
        setup.routes.iter_mut().step_by(9).for_each(|r| r.subgoals[0] *= -0.8);
        setup
    };
    let mut crowd = Crowd::new(setup()).unwrap();
    crowd.advance(4.0, &mut |e| alone.push(*e)).unwrap();
    assert!(crowd.counts().left > 3 && crowd.num_members() < 900);
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut together = Vec::new();
        let mut other = Crowd::new(setup()).unwrap();
        pool.install(|| {
            other.par_advance(1.7, &mut |e| together.push(*e)).unwrap();
            other.par_advance(4.0, &mut |e| together.push(*e)).unwrap();
        });
        assert_eq!(alone, together, "{threads} threads");
        assert_eq!(crowd.state_hash(), other.state_hash());
        assert_eq!(crowd.free, other.free);
        assert_eq!(crowd.counts(), other.counts());
    }
}

#[test]
fn a_snapshot_goes_on_as_the_crowd_did() {
    let mut crowd = Crowd::new(crossing::<Vec2>(100, 1.0)).unwrap();
    crowd.advance(2.0, &mut |_| {}).unwrap();
    crowd.add_route(to(Vec2::ZERO)).unwrap();
    let kept = crowd.snapshot();
    let (hash, counts) = (crowd.state_hash(), crowd.counts());
    crowd.advance(5.0, &mut |_| {}).unwrap();
    let later = crowd.state_hash();
    assert_ne!(hash, later);
    let mut other = Crowd::new(crossing::<Vec2>(100, 1.0)).unwrap();
    for crowd in [&mut crowd, &mut other] {
        crowd.restore(&kept).unwrap();
        assert_eq!((crowd.state_hash(), crowd.counts(), crowd.now()), (hash, counts, 2.0));
        crowd.advance(5.0, &mut |_| {}).unwrap();
        assert_eq!(crowd.state_hash(), later);
    }
}

#[test]
fn who_is_sent_again_and_again_takes_no_more_memory() {
    let mut setup = crossing::<Vec2>(9, 2.0);
    (setup.config.capacity, setup.config.largest_radius_m) = (10, 0.3);
    let mut crowd = Crowd::new(setup).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    for i in 0..40 {
        let away = Vec2::from_angle(i as f32) * 12.0;
        crowd.send_along(ids[i % 2], to(away), 1.3).unwrap();
        crowd.advance(0.2 * (i + 1) as f64, &mut |_| {}).unwrap();
        let x = crowd.position(ids[i % 2], crowd.now()).unwrap();
        let desired = crowd.desired_direction(ids[i % 2]).unwrap();
        assert!((desired - (away - x).normalize()).length() < 1e-4, "it goes where it was sent last");
    }
    assert_eq!(crowd.world.splines.len(), 9 + 2);
    // Nor do those who come after one another.
    for _ in 0..5 {
        let position = Vec2::new(40.0, 40.0);
        let id = crowd.enter(Member { position, ..Member::default() }).unwrap();
        crowd.send_along(id, to(Vec2::ZERO), 1.0).unwrap();
        crowd.leave(id).unwrap();
    }
    assert_eq!(crowd.world.splines.len(), 9 + 3);
    let before = crowd.state_hash();
    assert!(crowd.send_along(ids[0], to(Vec2::ZERO), 9.0).is_err());
    assert!(crowd.send_along(ids[0], Route { subgoals: vec![], ..to(Vec2::ZERO) }, 1.0).is_err());
    assert_eq!(crowd.state_hash(), before);
    let kept = crowd.snapshot();
    crowd.restore(&kept).unwrap();
    crowd.send_along(ids[1], to(Vec2::ZERO), 1.0).unwrap();
    assert_eq!(crowd.world.splines.len(), 9 + 3);
}

#[test]
fn what_is_no_snapshot_is_refused() {
    let mut crowd = Crowd::new(crossing::<Vec2>(20, 1.0)).unwrap();
    crowd.advance(1.0, &mut |_| {}).unwrap();
    let kept = crowd.snapshot();
    let hash = crowd.state_hash();
    for len in (0..kept.len()).step_by(kept.len() / 50) {
        assert!(matches!(crowd.restore(&kept[..len]), Err(CrowdError::Snapshot { .. })));
    }
    let mut longer = kept.clone();
    longer.push(0);
    assert!(crowd.restore(&longer).is_err());
    assert!(Crowd::new(crossing::<Vec2>(21, 1.0)).unwrap().restore(&kept).is_err());
    assert!(Crowd::new(crossing::<Vec3>(20, 1.0)).unwrap().restore(&kept).is_err());
    // Any damage is refused or harmless.
    for at in (0..kept.len()).step_by(7) {
        let mut damaged = kept.clone();
        damaged[at] ^= 0x41;
        let mut other = Crowd::new(crossing::<Vec2>(20, 1.0)).unwrap();
        if other.restore(&damaged).is_ok() {
            let until = other.now() + 0.2;
            let _ = other.advance(until, &mut |_| {});
        }
    }
    assert_eq!(crowd.state_hash(), hash);
}

#[test]
fn nobody_acts_twice_within_the_smallest_interval() {
    let mut crowd = Crowd::new(crossing::<Vec2>(100, 0.8)).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    let mut last = vec![-1.0; ids.len()];
    while crowd.now() < 3.0 {
        crowd.advance(crowd.now() + 0.01, &mut |_| {}).unwrap();
        for (id, last) in ids.iter().zip(&mut last) {
            let time = crowd.last_event(*id).unwrap();
            assert!(time == *last || time - *last >= 0.0999, "{last} {time}");
            *last = time;
        }
    }
}

#[test]
fn members_enter_leave_and_come_again() {
    let mut setup = crossing::<Vec2>(9, 2.0);
    setup.config.capacity = 10;
    setup.config.largest_radius_m = 0.3;
    let mut crowd = Crowd::new(setup).unwrap();
    let newcomer = Member { position: Vec2::new(9.0, 9.0), ..Member::default() };
    crowd.advance(0.5, &mut |_| {}).unwrap();
    let id = crowd.enter(newcomer).unwrap();
    assert_eq!((crowd.num_members(), id.index()), (10, 9));
    assert!(matches!(
        crowd.enter(Member { position: Vec2::ONE * 30.0, ..newcomer }),
        Err(CrowdError::Full { capacity: 10 })
    ));
    crowd.advance(1.0, &mut |_| {}).unwrap();
    crowd.leave(id).unwrap();
    assert_eq!(crowd.leave(id), Err(CrowdError::Gone(id)));
    assert_eq!(crowd.position(id, 1.0), None);
    let other = crowd.ids().next().unwrap();
    let taken = crowd.position(other, 1.0).unwrap();
    let refused = crowd.enter(Member { position: taken + Vec2::X * 0.3, ..newcomer });
    assert!(matches!(refused, Err(CrowdError::Overlap { first: 0, second: 9, .. })), "{refused:?}");
    let again = crowd.enter(Member { position: Vec2::new(9.0, 9.0), ..newcomer }).unwrap();
    assert!(again.index() == id.index() && again != id);
    crowd.advance(3.0, &mut |_| {}).unwrap();
    check_stop_regions(&crowd, 3.0);
}

#[test]
fn routes_end_as_they_say() {
    let mut setup = Setup::default();
    for (i, at_end) in [AtEnd::Stay, AtEnd::Leave, AtEnd::Again].into_iter().enumerate() {
        let y = i as f32 * 3.0;
        let subgoals = vec![Vec2::new(0.0, y), Vec2::new(4.0, y)];
        setup.routes.push(Route { subgoals, arrival_radius: 0.4, at_end });
        setup.members.push(Member { position: Vec2::new(0.0, y), route: i, ..Member::default() });
    }
    let mut crowd = Crowd::new(setup).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    let mut arrived = [0; 3];
    crowd
        .advance(15.0, &mut |e| {
            if e.kind == EventKind::Arrived {
                arrived[e.member.index()] += 1;
            }
        })
        .unwrap();
    assert_eq!(arrived[..2], [1, 1]);
    assert!(arrived[2] > 1, "goes round again and again");
    assert_eq!((crowd.num_members(), crowd.counts().left), (2, 1));
    let (x, v) = (crowd.position(ids[0], 15.0).unwrap(), crowd.velocity(ids[0], 15.0).unwrap());
    assert!((x - Vec2::new(4.0, 0.0)).length() < 0.4 && v.length() < 0.05, "{x} {v}");
}

#[test]
fn nobody_goes_through_walls() {
    let mut setup = crossing::<Vec2>(60, 0.9);
    setup.members.iter_mut().for_each(|m| m.position.x -= 6.0);
    for r in &mut setup.routes {
        r.subgoals[0].x += 12.0;
    }
    setup.obstacles = vec![
        Obstacle::Wall { from: Vec2::new(0.0, -30.0), to: Vec2::new(0.0, -0.8), radius: 0.1 },
        Obstacle::Polygon { corners: vec![Vec2::new(0.0, 0.8), Vec2::new(1.0, 30.0), Vec2::new(-1.0, 30.0)] },
        Obstacle::Box { min: Vec2::new(3.0, -1.0), max: Vec2::new(4.0, 1.0) },
    ];
    let mut crowd = Crowd::new(setup).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    while crowd.now() < 15.0 {
        crowd.advance(crowd.now() + 0.05, &mut |_| {}).unwrap();
        for id in &ids {
            let x = crowd.position(*id, crowd.now()).unwrap();
            let r = crowd.member(*id).unwrap().radius;
            for solid in &crowd.world.solids {
                assert!(solid.away(x).1 >= r, "{x} is in {solid:?}");
            }
        }
    }
    let through = ids.iter().filter(|id| crowd.position(**id, 15.0).unwrap().x > 0.5).count();
    assert!(through > 4, "{through} came through the gap");
}

#[test]
fn one_in_the_open_gets_out_of_the_way_of_what_moves() {
    let still = Member { position: Vec2::new(0.0, 0.05), speed: 1.0, ..Member::default() };
    let way = vec![(0.0, Vec2::new(-8.0, 0.0)), (10.0, Vec2::new(8.0, 0.0))];
    let setup = Setup {
        members: vec![still],
        routes: vec![to(Vec2::ZERO)],
        obstacles: vec![Obstacle::Mover { way, radius: 0.8 }],
        ..Setup::default()
    };
    let mut crowd = Crowd::new(setup).unwrap();
    let id = crowd.ids().next().unwrap();
    let mut farthest = 0.0f32;
    while crowd.now() < 14.0 {
        crowd.advance(crowd.now() + 0.05, &mut |_| {}).unwrap();
        let x = crowd.position(id, crowd.now()).unwrap();
        farthest = farthest.max(x.length());
        let obstacle = Vec2::new(-8.0 + 1.6 * crowd.now().min(10.0) as f32, 0.0);
        assert!((x - obstacle).length() > 1.1 - 1e-3, "{x} {obstacle}");
    }
    assert_eq!(crowd.counts().struck, 0);
    assert!(farthest > 0.5, "it moved");
}

#[test]
fn what_cannot_start_is_named() {
    let good = || crossing::<Vec2>(4, 2.0);
    let error = |setup: Setup<Vec2>| Crowd::new(setup).unwrap_err();
    let mut s = good();
    s.members[2].position = s.members[1].position + Vec2::splat(0.1);
    assert!(matches!(error(s), CrowdError::Overlap { first: 1, second: 2, .. }));
    let mut s = good();
    s.obstacles.push(Obstacle::Ball { centre: s.members[3].position, radius: 0.5 });
    assert!(matches!(error(s), CrowdError::Inside { member: 3, obstacle: 0 } | CrowdError::Goal { .. }));
    let mut s = good();
    let g = s.routes[1].subgoals[0] + Vec2::new(40.0, 0.0);
    s.routes[1].subgoals[0] = g;
    let corners = vec![g + Vec2::new(-1.0, -1.0), g + Vec2::new(1.0, -1.0), g + Vec2::new(0.0, 2.0)];
    s.obstacles.push(Obstacle::Polygon { corners });
    assert_eq!(error(s), CrowdError::Goal { route: 1, subgoal: 0, obstacle: 0 });
    let mut s = good();
    s.members[0].route = 9;
    assert_eq!(error(s), CrowdError::Index { what: "route", got: 9, limit: 4 });
    let mut s = good();
    s.members[0].radius = f32::NAN;
    assert!(matches!(error(s), CrowdError::Value { what: "member", index: 0, field: "radius", .. }));
    let mut s = good();
    s.config.smallest_interval_s = 0.0;
    assert!(matches!(error(s), CrowdError::Value { what: "config", .. }));
    let mut s = good();
    s.fields[0].relaxation_s = -1.0;
    assert!(matches!(error(s), CrowdError::Value { what: "field", field: "relaxation_s", .. }));
    let mut crowd = Crowd::new(good()).unwrap();
    crowd.advance(1.0, &mut |_| {}).unwrap();
    assert_eq!(crowd.advance(0.5, &mut |_| {}), Err(CrowdError::Past { got: 0.5, now: 1.0 }));
    assert!(crowd.advance(f64::NAN, &mut |_| {}).is_err());
}

#[test]
fn a_crowd_that_does_not_get_on_names_the_pair() {
    let mut crowd = Crowd::new(crossing::<Vec2>(30, 0.8)).unwrap();
    crowd.advance(2.0, &mut |_| {}).unwrap();
    let met = |c: &Crowd<Vec2>| c.ids().find_map(|id| Some((id, c.partner(c.minds[id.index()].cause)?)));
    let (first, second) = met(&crowd).unwrap();
    // As if its event came again and again, and never a later one.
    let storm = (0..100).find_map(|_| {
        crowd.minds[first.index()].cause = super::decide::Cause::Member(second);
        crowd.happen(first.index, &mut |_| {}).err()
    });
    match storm {
        Some(CrowdError::Storm { first: a, second: b, .. }) => {
            assert_eq!((a, b.map(|b| b.index)), (first, Some(second)))
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn bounds_hold_members_until_their_next_event() {
    let mut crowd = Crowd::new(crossing::<Vec2>(80, 1.0)).unwrap();
    let ids: Vec<_> = crowd.ids().collect();
    while crowd.now() < 4.0 {
        crowd.advance(crowd.now() + 0.03, &mut |_| {}).unwrap();
        for id in &ids {
            let (centre, radius) = crowd.bound(*id, crowd.now()).unwrap();
            let x = crowd.position(*id, crowd.now()).unwrap();
            let r = crowd.member(*id).unwrap().radius;
            assert!((x - centre).length() + r <= radius + 1e-4);
            assert!(crowd.next_event(*id).unwrap() >= crowd.now());
        }
    }
}

#[test]
fn interests_draw_near_and_drive_away() {
    let end = |strength| {
        let mut setup = Setup { members: vec![Member { speed: 0.0, ..Member::default() }], ..Setup::default() };
        setup.routes.push(to(Vec2::ZERO));
        setup.config.largest_speed_mps = 1.0;
        setup.interests.push(Interest { position: Vec2::new(3.0, 0.0), strength, reach: 6.0 });
        let mut crowd = Crowd::new(setup).unwrap();
        crowd.advance(5.0, &mut |_| {}).unwrap();
        crowd.position(crowd.ids().next().unwrap(), 5.0).unwrap().x
    };
    assert!(end(1.0) > 0.2 && end(-1.0) < -0.2 && end(0.0) == 0.0, "{} {} {}", end(1.0), end(-1.0), end(0.0));
}

#[test]
fn forces_add_up_to_the_terms_of_the_field() {
    let mut crowd = Crowd::new(crossing::<Vec2>(40, 0.9)).unwrap();
    crowd.advance(2.0, &mut |_| {}).unwrap();
    let id = crowd.ids().nth(20).unwrap();
    let (f, m) = (crowd.forces(id).unwrap(), crowd.member(id).unwrap());
    let desired = crowd.desired_direction(id).unwrap();
    let driving = (desired * m.speed - m.velocity) / Field::default().relaxation_s;
    assert!((f.driving - driving).length() < 1e-3, "first term of eq. 17: {} {driving}", f.driving);
    assert_eq!(f.taken, crowd.acceleration(id, crowd.last_event(id).unwrap()).unwrap());
    assert!(f.taken.length() <= m.acceleration * 1.0001);
}
