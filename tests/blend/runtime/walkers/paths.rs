//! How bodies follow trajectories.

use super::*;

#[test]
fn root_follows_the_trajectory_with_the_hips_above_it() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 10);
    for _ in 0..300 {
        outing.step(wandering);
        for c in 0..10 {
            let (root, want) = (outing.walkers.root(c), outing.positions[c]);
            assert_eq!(Vec2::new(root.x, root.z), want);
            let size = bodies()[c % 5].leg_length() / Skeleton::default().leg_length();
            let hips = outing.walkers.pose(c)[0].translation();
            assert!(hips.x.hypot(hips.z) < 0.1 && (0.6..1.05).contains(&(hips.y / size)), "{c}: {hips}");
        }
    }
}

#[test]
fn feet_of_a_standing_walker_do_not_move() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    let stop: Course = |_, t| (Vec2::new(0.0, if t < 2.0 { 1.5 } else { 0.0 }), None);
    for _ in 0..300 {
        outing.step(stop);
    }
    let soles = |o: &Outing| (0..10).map(|i| sole(&o.walkers, i / 2, i % 2)).collect::<Vec<_>>();
    let before = soles(&outing);
    for _ in 0..120 {
        outing.step(stop);
        for c in 0..5 {
            assert!(outing.walkers.contacts(c).any(Contacts::LEFT) && outing.walkers.contacts(c).any(Contacts::RIGHT));
        }
    }
    for (a, b) in before.iter().zip(soles(&outing)) {
        assert!(a[0].distance(b[0]) < 2e-3 && a[1].distance(b[1]) < 2e-3, "{a:?} {b:?}");
    }
}

#[test]
fn turning_on_the_spot_takes_steps_and_ends_at_the_heading() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 5);
    let turn: Course = |_, t| (Vec2::ZERO, Some(if t < 1.0 { 0.0 } else { 2.5 }));
    let mut lifted = [false; 5];
    for _ in 0..360 {
        outing.step(turn);
        for (c, lifted) in lifted.iter_mut().enumerate() {
            *lifted |= FEET.iter().any(|f| !outing.walkers.contacts(c).any(*f));
        }
    }
    assert_eq!(lifted, [true; 5], "turning takes steps");
    for c in 0..5 {
        let root = outing.walkers.root(c);
        assert!((root.heading - 2.5).abs() < 0.02, "{}", root.heading);
        for (side, foot) in [Joint::LeftFoot, Joint::RightFoot].into_iter().enumerate() {
            let at = outing.walkers.pose(c)[foot.index()].translation();
            assert!(at.x * [1.0, -1.0][side] > 0.02 && at.z.abs() < 0.2, "{c}: {at}");
        }
    }
}

#[test]
fn side_and_back_steps_keep_the_given_heading() {
    let made_up = MadeUp::locomotion();
    for (velocity, axis, sign) in [(Vec2::new(0.7, 0.0), 1, 1.0), (Vec2::new(0.0, -0.8), 0, -1.0)] {
        let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
        let control = Control { velocity, heading: Some(0.0), ..Control::default() };
        outing.walkers.order(outing.ids[0], control).expect("an order");
        for _ in 0..120 {
            outing.walkers.step(DT_S, &Inline).expect("a step");
        }
        assert!(outing.walkers.root(0).heading.abs() < 1e-3);
        let p = outing.walkers.parameters(0);
        assert!((p[axis] - sign * velocity.length()).abs() < 0.01, "{p:?}");
    }
}

#[test]
fn heading_follows_a_circle() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    let circle: Course = |_, t| (1.5 * Vec2::new(t.sin(), t.cos()), None);
    for _ in 0..600 {
        outing.step(circle);
    }
    let off = (outing.walkers.root(0).heading - outing.time_s + PI).rem_euclid(TAU) - PI;
    assert!(off.abs() < 0.1, "{off}");
    assert!((outing.walkers.parameters(0)[2] - 1.0).abs() < 0.05);
}

#[test]
fn larger_bodies_walk_at_the_same_froude_number() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 3);
    let straight: Course = |_, _| (Vec2::new(0.0, 1.2), None);
    for _ in 0..120 {
        outing.step(straight);
    }
    for (c, size) in [1.0f32, 0.6, 1.25].into_iter().enumerate() {
        let p = outing.walkers.parameters(c)[0];
        assert!((p - 1.2 / size.sqrt()).abs() < 1e-3, "{c}: {p}");
    }
}

#[test]
fn steady_changes_are_followed_without_delay() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    let faster: Course = |_, t| (Vec2::new(0.0, 0.5 + t.min(3.0)), None);
    for i in 0..170 {
        outing.step(faster);
        let (got, asked) = (outing.walkers.parameters(0)[0], 0.5 + outing.time_s);
        assert!(i < 60 || (got - asked).abs() < 0.02, "{got} where {asked} was asked for, {} s", outing.time_s);
    }
    // A jump is eased.
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    outing.step(|_, _| (Vec2::Y, None));
    outing.step(|_, _| (Vec2::Y * 4.0, None));
    assert!(outing.walkers.parameters(0)[0] < 1.2);
}

#[test]
fn sharp_corners_are_limited_by_the_turning_rate() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 1);
    let corner: Course = |_, t| (1.5 * if t < 1.0 { Vec2::Y } else { Vec2::X }, None);
    let mut before = 0.0;
    for _ in 0..180 {
        outing.step(corner);
        let heading = outing.walkers.root(0).heading;
        assert!((heading - before).abs() < WalkersConfig::default().max_turning_rate * DT_S + 1e-4);
        before = heading;
    }
    assert!((before - FRAC_PI_2).abs() < 0.02, "{before}");
}
