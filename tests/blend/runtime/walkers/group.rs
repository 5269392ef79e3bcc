//! Entering, leaving, orders that stay, events.

use super::*;
use throng_core::body::BodyEventKind;
use throng_core::characters::{Detail, MotionSet, SampleJob};

#[test]
fn those_who_stay_do_not_notice_who_enters_and_leaves() {
    let made_up = MadeUp::locomotion();
    let mut alone = Outing::new(&made_up, WalkersConfig::default(), 5);
    let mut walkers =
        Walkers::with_capacity(made_up.space(), &bodies(), WalkersConfig::default(), 20).expect("walkers");
    // Others before, between and behind them, which leave one after the other.
    let mut others = Vec::new();
    let mut ids = Vec::new();
    for c in 0..20 {
        let id = walkers.spawn(start(c / 4)).expect("room");
        if c % 4 == 1 { ids.push(id) } else { others.push(id) }
    }
    for _ in 0..100 {
        alone.step(wandering);
        if let Some(id) = others.pop() {
            walkers.order(id, Control::walk(Vec2::Y)).expect("an order");
            walkers.despawn(id).expect("a walker");
            assert!(matches!(walkers.order(id, Control::default()), Err(Error::Gone(gone)) if gone == id));
        }
        for (c, id) in ids.iter().enumerate() {
            let (velocity, heading) = wandering(c, alone.time_s);
            let control = Control { position: Some(alone.positions[c]), velocity, heading, ..Control::default() };
            walkers.order(*id, control).expect("an order");
        }
        walkers.step(DT_S, &Inline).expect("a step");
        for (c, id) in ids.iter().enumerate() {
            let body = walkers.bodies().get(*id).expect("a walker");
            assert_eq!((body.root, body.model), (alone.walkers.root(c), alone.walkers.pose(c)), "{c}");
        }
    }
    assert_eq!((walkers.len(), walkers.bodies().model.len()), (5, 5));
}

#[test]
fn walkers_beyond_the_capacity_are_refused() {
    let mut outing = Outing::new(&MadeUp::locomotion(), WalkersConfig::default(), 3);
    assert!(matches!(outing.walkers.spawn(start(3)), Err(Error::Full { capacity: 3 })));
    outing.walkers.despawn(outing.ids[0]).expect("a walker");
    let next = outing.walkers.spawn(start(3)).expect("room");
    assert_ne!(next, outing.ids[0]);
    assert!(outing.walkers.status(outing.ids[0]).is_err());
}

#[test]
fn orders_stay_until_the_next_one() {
    let mut outing = Outing::new(&MadeUp::locomotion(), WalkersConfig::default(), 2);
    let [a, b] = [outing.ids[0], outing.ids[1]];
    assert_eq!(outing.walkers.status(a).expect("a walker"), OrderStatus::Idle);
    let walk = |speed: f32| Control { cut: true, ..Control::walk(Vec2::new(0.0, speed)) };
    outing.walkers.order(a, walk(1.5)).expect("an order");
    let arc = Control { turning_rate: Some(0.5), ..walk(1.0) };
    outing.walkers.order(b, arc).expect("an order");
    for _ in 0..120 {
        outing.walkers.step(DT_S, &Inline).expect("a step");
    }
    assert_eq!(outing.walkers.status(a).expect("a walker"), OrderStatus::Arrived);
    let (straight, turned) = (outing.walkers.root(0), outing.walkers.root(1));
    assert!(straight.x.abs() < 1e-3 && (straight.z - 3.0).abs() < 1e-3, "{straight:?}");
    // A radius of 2 m, and 1 rad of it.
    let end = Vec2::new(4.0 + 2.0 * (1.0 - 1f32.cos()), 2.0 * 1f32.sin());
    assert!(Vec2::new(turned.x, turned.z).distance(end) < 0.02, "{turned:?}, expected {end}");
    outing.walkers.order(a, walk(0.0)).expect("an order");
    outing.walkers.step(DT_S, &Inline).expect("a step");
    assert_eq!(outing.walkers.root(0).z, straight.z);
}

#[test]
fn placed_walkers_stand_there_at_once_and_go_on_from_there() {
    let mut outing = Outing::new(&MadeUp::locomotion(), WalkersConfig::default(), 10);
    (0..100).for_each(|_| outing.step(wandering));
    let neighbour = *outing.walkers.pose(6);
    let there = Planar::new(50.0, -20.0, 1.0);
    outing.walkers.place(outing.ids[7], there).expect("a walker");
    assert_eq!(outing.walkers.bodies().get(outing.ids[7]).expect("a walker").root, there);
    assert_eq!(*outing.walkers.pose(6), neighbour, "others are posed anew");
    let feet = |o: &Outing| [Joint::LeftFoot, Joint::RightFoot].map(|j| o.walkers.joint_positions(7)[j.index()]);
    outing.walkers.order(outing.ids[7], Control::default()).expect("an order");
    for _ in 0..10 {
        outing.walkers.step(DT_S, &Inline).expect("a step");
        for foot in feet(&outing) {
            assert!(Vec2::new(foot.x - there.x, foot.z - there.z).length() < 1.2, "{foot}");
        }
    }
}

#[test]
fn each_foot_comes_down_once_a_cycle() {
    let mut outing = Outing::new(&MadeUp::locomotion(), WalkersConfig::default(), 5);
    let straight: Course = |_, _| (Vec2::new(0.0, 1.2), None);
    outing.step(straight);
    assert!(outing.walkers.events().is_empty(), "a first pose is no step");
    let (mut downs, mut cycles) = ([[0usize; 2]; 5], [0.0f32; 5]);
    let mut steps: Vec<(usize, usize, usize, Vec3)> = Vec::new();
    let mut soles = Vec::new();
    for i in 0..900 {
        let before: Vec<f32> = (0..5).map(|c| outing.walkers.phase(c)).collect();
        outing.step(straight);
        for c in (0..5).filter(|_| i >= 100) {
            cycles[c] += (outing.walkers.phase(c) - before[c]).rem_euclid(1.0);
        }
        soles.push((0..5).map(|c| outing.walkers.soles(c)).collect::<Vec<_>>());
        for (id, event) in outing.walkers.events().iter().filter(|(_, e)| i >= 100 && e.kind == BodyEventKind::Footstep)
        {
            let side = usize::from(event.number == Joint::RightFoot as u32);
            assert!((0.02..1.0).contains(&event.strength), "{}", event.strength);
            downs[id.index()][side] += 1;
            steps.push((id.index(), i, side, event.at));
        }
    }
    for c in 0..5 {
        let own: Vec<_> = steps.iter().filter(|step| step.0 == c).collect();
        assert!(own.windows(2).all(|two| two[0].2 != two[1].2), "{c}: sides take turns");
        // A tenth of a second later the foot is flat where the step was.
        for (_, i, side, at) in own.into_iter().filter(|step| step.1 + 6 < 900) {
            let [heel, ball] = soles[i + 6][c][*side];
            let off = (heel + ball) * 0.5 - *at;
            assert!(Vec2::new(off.x, off.z).length() < 0.03 && at.y.abs() < 0.03, "{c}: a step is off by {off}");
        }
    }
    for (c, (downs, cycles)) in downs.iter().zip(cycles).enumerate() {
        for n in downs {
            assert!(cycles > 5.0 && (*n as f32 - cycles).abs() < 2.0, "{c}: {n} steps in {cycles} cycles");
        }
    }
}

#[test]
fn nobody_who_stands_makes_footsteps() {
    let mut outing = Outing::new(&MadeUp::locomotion(), WalkersConfig::default(), 5);
    for i in 0..400 {
        outing.step(|_, _| (Vec2::ZERO, None));
        let steps = outing.walkers.events().iter().filter(|(_, e)| e.kind == BodyEventKind::Footstep);
        assert_eq!(steps.filter(|_| i >= 100).count(), 0);
    }
}

#[test]
fn a_walker_that_is_pushed_gives_way_where_it_is_struck_and_comes_back() {
    let made_up = MadeUp::locomotion();
    let mut struck = Outing::new(&made_up, WalkersConfig::default(), 6);
    (0..90).for_each(|_| struck.step(wandering));
    let mut alone = struck.clone();
    let by = Vec3::new(0.06, 0.0, -0.1);
    for c in (0..6).step_by(2) {
        struck.walkers.push(struck.ids[c], Joint::Head, by).expect("a push");
    }
    let off = |a: &Outing, b: &Outing, c: usize, j: Joint| {
        let [a, b] = [a, b].map(|o| o.walkers.joint_positions(c)[j.index()]);
        a - b
    };
    let mut furthest = [Vec3::ZERO; 6];
    for _ in 0..180 {
        struck.step(wandering);
        alone.step(wandering);
        for (c, furthest) in furthest.iter_mut().enumerate() {
            let head = off(&struck, &alone, c, Joint::Head);
            if head.length() > furthest.length() {
                *furthest = head;
            }
            let foot = off(&struck, &alone, c, Joint::LeftFoot).length();
            assert!(foot < 0.02, "the feet of {c} stay where they are, within {foot} m");
        }
    }
    for (c, furthest) in furthest.into_iter().enumerate() {
        if c % 2 == 1 {
            assert_eq!(furthest, Vec3::ZERO, "{c} was not pushed");
            continue;
        }
        let share = furthest.dot(by) / by.length_squared();
        assert!((0.3..1.1).contains(&share), "the head of {c} goes {furthest}");
        assert!(off(&struck, &alone, c, Joint::Head).length() < 1e-3, "and comes back");
    }
    let refused = struck.walkers.push(struck.ids[0], Joint::Head, Vec3::splat(f32::NAN));
    assert!(matches!(refused, Err(Error::Value { what: "displacement", .. })), "{refused:?}");
}

#[test]
fn records_show_walkers_about_where_poses_do() {
    let tables = crate::common::blend_tables();
    let space = tables.blend(&tables.meta().blends[0].name).expect("a space");
    let config = WalkersConfig { instances: true, ..WalkersConfig::default() };
    let mut walkers = Walkers::with_capacity(space, &[], config, 12).expect("walkers");
    let ids: Vec<_> = (0..12)
        .map(|c| {
            let root = Planar::new(2.0 * c as f32, 0.0, 0.3 * c as f32);
            walkers.spawn(WalkerStart { root, phase: 0.31 * c as f32, ..WalkerStart::default() }).expect("room")
        })
        .collect();
    for (c, id) in ids.iter().enumerate() {
        let heading = 0.3 * c as f32;
        let velocity = (0.8 + 0.1 * c as f32) * Vec2::new(heading.sin(), heading.cos());
        walkers.order(*id, Control::walk(velocity)).expect("an order");
    }
    let set = MotionSet::new(&tables);
    let (mut offs, mut levels) = (Vec::new(), 0);
    for k in 0..240 {
        walkers.step(DT_S, &Inline).expect("a step");
        if k < 60 {
            continue;
        }
        for (row, record) in walkers.instances().iter().enumerate() {
            assert_eq!(record.variant, row as u32);
            let root = walkers.root(row);
            assert_eq!([record.x, record.z, record.heading], [root.x, root.z, root.heading]);
            let sample = |at: u32| {
                let mut pose = [Mat3x4::default(); 22];
                let ratios = [f32::from(record.frac_blend[0]) / 65535.0];
                let job = SampleJob { motion_set: &set, frames: &[at], ratios: &ratios, matrices: &mut pose };
                job.run().expect("rows of the bundle");
                pose
            };
            let (a, b) = (sample(record.row_a), sample(record.row_b));
            let share = f32::from(record.frac_blend[1]) / 65535.0;
            for joint in [Joint::Head, Joint::LeftHand, Joint::RightHand, Joint::LeftFoot, Joint::RightFoot] {
                let [a, b] = [a, b].map(|pose| pose[joint.index()].translation());
                offs.push(a.lerp(b, share).distance(walkers.pose(row)[joint.index()].translation()));
            }
        }
        levels += 1;
    }
    offs.sort_by(f32::total_cmp);
    let (p50, p95) = (offs[offs.len() / 2], offs[offs.len() * 95 / 100]);
    println!("records are {p50} m off, {p95} m at the 95th percentile, over {levels} steps");
    assert!(p50 < 0.06 && p95 < 0.2, "records show joints {p50} and {p95} m away from their poses");

    // Far walkers leave records alone: they go on as they would, and are posed again when somebody comes near.
    let mut near = walkers.clone();
    walkers.set_detail(Some(Detail::RECORDS)).expect("distances");
    let before = *walkers.pose(0);
    for _ in 0..30 {
        walkers.step(DT_S, &Inline).expect("a step");
        near.step(DT_S, &Inline).expect("a step");
        assert_eq!(walkers.instances(), near.instances());
    }
    assert_eq!(*walkers.pose(0), before, "nobody is posed");
    walkers.set_detail(None).expect("all");
    for _ in 0..60 {
        walkers.step(DT_S, &Inline).expect("a step");
        near.step(DT_S, &Inline).expect("a step");
    }
    let off = |j: Joint| walkers.pose(5)[j.index()].translation().distance(near.pose(5)[j.index()].translation());
    assert!(off(Joint::Head) < 0.02 && off(Joint::LeftFoot) < 0.12, "{} {}", off(Joint::Head), off(Joint::LeftFoot));
}
