//! Threads, snapshots and refusals.

use super::*;

#[test]
fn threads_and_splits_do_not_change_results() {
    let made_up = MadeUp::locomotion();
    let config = WalkersConfig { local_transforms: true, ..WalkersConfig::default() };
    let run = |run: &(dyn Executor + Sync), threads: usize, n: usize| -> Vec<[Mat3x4; 22]> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut outing = Outing::new(&made_up, config, n);
        pool.install(|| (0..40).for_each(|_| outing.step_on(wandering, run)));
        outing.walkers.bodies().model.to_vec()
    };
    let one = run(&Inline, 1, 300);
    assert_eq!(one, run(&Rayon, 2, 300));
    assert_eq!(one, run(&Rayon, 8, 300));
    assert_eq!(one[..100], run(&Rayon, 2, 100), "results depend on the number of walkers");
}

#[test]
fn snapshots_lead_to_the_same_steps() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 9);
    (0..50).for_each(|_| outing.step(jumping));
    let (mut bytes, kept) = (Vec::new(), outing.clone());
    outing.walkers.save(&mut bytes);
    let go_on = |outing: &mut Outing| {
        (0..50).for_each(|_| outing.step(jumping));
        outing.walkers.despawn(outing.ids[3]).expect("a walker");
        let next = outing.walkers.spawn(start(3)).expect("room");
        (next, outing.walkers.bodies().model.to_vec(), outing.walkers.hash())
    };
    let want = go_on(&mut outing);
    outing.walkers.load(&bytes).expect("a snapshot");
    assert_eq!(outing.walkers.hash(), kept.walkers.hash());
    assert_eq!(outing.walkers.bodies().roots, kept.walkers.bodies().roots);
    for (a, b) in outing.walkers.bodies().model.iter().zip(kept.walkers.bodies().model) {
        assert!(a[0].translation().distance(b[0].translation()) < 0.01, "poses are there after loading");
    }
    outing = Outing { walkers: outing.walkers, ..kept };
    assert_eq!(go_on(&mut outing), want);
}

#[test]
fn snapshots_of_other_walkers_and_damaged_ones_are_refused() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 9);
    (0..10).for_each(|_| outing.step(jumping));
    let mut bytes = Vec::new();
    outing.walkers.save(&mut bytes);
    let before = outing.walkers.hash();
    for at in (0..bytes.len()).step_by(97) {
        let mut other = bytes.clone();
        other[at] ^= 4;
        assert!(outing.walkers.load(&other).is_err(), "byte {at}");
        assert!(outing.walkers.load(&bytes[..at]).is_err(), "{at} bytes");
    }
    assert!(outing.walkers.load(&[&bytes[..], &[0]].concat()).is_err());
    assert_eq!(outing.walkers.hash(), before);
    let eased = WalkersConfig { heading_half_life_s: 0.5, ..WalkersConfig::default() };
    let small = MadeUp::new(&[[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]], [2, 2, 2]);
    for mut other in [
        Outing::new(&made_up, WalkersConfig::default(), 8),
        Outing::new(&made_up, eased, 9),
        Outing::new(&small, WalkersConfig::default(), 9),
    ] {
        assert!(matches!(other.walkers.load(&bytes), Err(Error::Snapshot { what: "walkers", .. })));
    }
}

#[test]
fn local_transforms_build_the_same_pose() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig { local_transforms: true, ..WalkersConfig::default() }, 10);
    (0..30).for_each(|_| outing.step(wandering));
    for c in 0..10 {
        let mut world = [glam::Mat4::IDENTITY; 22];
        for joint in Joint::ALL {
            let l = outing.walkers.local_transforms()[c * 22 + joint.index()];
            let local = glam::Mat4::from_rotation_translation(
                glam::Quat::from_array(l.rotation),
                Vec3::from_array(l.translation),
            );
            world[joint.index()] = joint.parent().map_or(local, |p| world[p.index()] * local);
            let want = outing.walkers.pose(c)[joint.index()].to_mat4();
            assert!(world[joint.index()].abs_diff_eq(want, 2e-4), "{c} {joint:?}");
        }
    }
}

#[test]
fn without_smoothing_parameters_are_those_asked_for() {
    let made_up = MadeUp::locomotion();
    let config = WalkersConfig { parameter_half_life_s: 0.0, ..WalkersConfig::default() };
    let mut outing = Outing::new(&made_up, config, 1);
    outing.step(|_, _| (Vec2::new(0.0, 0.8), None));
    outing.step(|_, _| (Vec2::new(0.0, 4.0), None));
    assert_eq!(outing.walkers.parameters(0)[0], 4.0);
    let sum: f32 = outing.walkers.weights(0).iter().sum();
    assert!((sum - 1.0).abs() < 1e-5);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let made_up = MadeUp::locomotion();
    let new = |bodies: &[Skeleton], config: WalkersConfig, start: WalkerStart| {
        Walkers::with_capacity(made_up.space(), bodies, config, 1)?.spawn(start).map(|_| ())
    };
    let start = WalkerStart::default();
    let default = WalkersConfig::default();
    assert!(new(&bodies(), default, start).is_ok());
    let other_body = WalkerStart { body: 1, ..start };
    assert!(matches!(new(&[], default, other_body), Err(Error::Index { what: "body", got: 1, limit: 1, .. })));
    let nowhere = WalkerStart { root: Planar::new(f32::NAN, 0.0, 0.0), ..start };
    assert!(matches!(new(&bodies(), default, nowhere), Err(Error::Value { what: "root x", .. })));
    let mut crippled = Skeleton::default();
    crippled.offsets[Joint::LeftShin.index()] = Vec3::ZERO;
    assert!(matches!(new(&[crippled], default, start), Err(Error::Value { .. })));
    let config = WalkersConfig { tempo: [1.1, 1.2], ..default };
    assert!(matches!(new(&bodies(), config, start), Err(Error::Value { what: "tempo[0]", .. })));

    let mut outing = Outing::new(&made_up, default, 2);
    let (id, before) = (outing.ids[1], outing.walkers.hash());
    for dt_s in [-1.0, f32::NAN, 1.5] {
        assert!(matches!(outing.walkers.step(dt_s, &Inline), Err(Error::Value { what: "dt_s", .. })));
    }
    let nowhere = Control { position: Some(Vec2::new(f32::NAN, 0.0)), ..Control::default() };
    let turned = Control { heading: Some(f32::INFINITY), ..Control::default() };
    for (order, what) in [(nowhere, "position x"), (turned, "heading")] {
        let e = outing.walkers.order(id, order).expect_err(what).to_string();
        assert!(e.starts_with(&format!("1: {what} is")), "{e}");
    }
    assert!(outing.walkers.place(id, Planar::new(0.0, f32::NAN, 0.0)).is_err());
    assert_eq!(outing.walkers.hash(), before);
}
