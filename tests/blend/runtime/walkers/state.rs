//! What is kept, split, refused.

use super::*;

#[test]
fn threads_and_splits_change_nothing() {
    let made_up = MadeUp::locomotion();
    let run = |threads: usize, n: usize| -> Vec<Mat3x4> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut outing = Outing::new(&made_up, WalkersConfig { local_transforms: true, ..WalkersConfig::default() }, n);
        pool.install(|| {
            for i in 0..40 {
                for (c, control) in outing.controls.iter_mut().enumerate() {
                    control.velocity = wandering(c, i as f32 * DT_S).0;
                    control.position += control.velocity * DT_S;
                }
                let flat = HeightField::flat();
                if threads == 0 {
                    outing.walkers.step(&made_up.space(), DT_S, &outing.controls, &flat).expect("a step");
                } else {
                    outing.walkers.par_step(&made_up.space(), DT_S, &outing.controls, &flat).expect("a step");
                }
            }
        });
        outing.walkers.model_matrices().to_vec()
    };
    let one = run(1, 300);
    assert_eq!(one, run(2, 300));
    assert_eq!(one, run(8, 300));
    assert_eq!(one[..100 * 22], run(2, 100), "the others do not matter");
}

#[test]
fn a_snapshot_leads_to_the_same_steps() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), 9);
    let flat = HeightField::flat();
    for _ in 0..50 {
        outing.step(&made_up, jumping, &flat);
    }
    let (snapshot, controls, time_s) = (outing.walkers.snapshot(), outing.controls.clone(), outing.time_s);
    for _ in 0..50 {
        outing.step(&made_up, jumping, &flat);
    }
    let want = outing.walkers.model_matrices().to_vec();
    outing.walkers.restore(&snapshot).expect("a snapshot");
    (outing.controls, outing.time_s) = (controls, time_s);
    for _ in 0..50 {
        outing.step(&made_up, jumping, &flat);
    }
    assert_eq!(outing.walkers.model_matrices(), want);
    assert!(snapshot.num_bytes() > 9 * 100);
    let other = Outing::new(&made_up, WalkersConfig::default(), 8);
    assert!(outing.walkers.restore(&other.walkers.snapshot()).is_err());
}

#[test]
fn local_transforms_build_the_same_pose() {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig { local_transforms: true, ..WalkersConfig::default() }, 10);
    for _ in 0..30 {
        outing.step(&made_up, wandering, &HeightField::flat());
    }
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
    outing.step(&made_up, |_, _| (Vec2::new(0.0, 0.8), None), &HeightField::flat());
    outing.step(&made_up, |_, _| (Vec2::new(0.0, 4.0), None), &HeightField::flat());
    assert_eq!(outing.walkers.parameters(0)[0], 4.0);
    let sum: f32 = outing.walkers.weights(0).iter().sum();
    assert!((sum - 1.0).abs() < 1e-5);
}

#[test]
fn what_makes_no_sense_is_refused() {
    let made_up = MadeUp::locomotion();
    let space = made_up.space();
    let new = |bodies: &[Skeleton], config: WalkersConfig, start: WalkerStart| {
        Walkers::new(&space, &Skeleton::default(), bodies, config, &[start]).map(|_| ())
    };
    let start = WalkerStart::default();
    let default = WalkersConfig::default();
    assert!(new(&bodies(), default, start).is_ok());
    assert!(matches!(new(&[], default, start), Err(BlendError::Index { what: "body", .. })));
    let nowhere = WalkerStart { root: Planar::new(f32::NAN, 0.0, 0.0), ..start };
    assert!(matches!(new(&bodies(), default, nowhere), Err(BlendError::Value { what: "start x", .. })));
    let mut crippled = Skeleton::default();
    crippled.offsets[Joint::LeftShin.index()] = Vec3::ZERO;
    assert!(matches!(new(&[crippled], default, start), Err(BlendError::Value { .. })));
    let config = WalkersConfig { tempo: [1.1, 1.2], ..default };
    assert!(matches!(new(&bodies(), config, start), Err(BlendError::Value { what: "tempo[0]", .. })));

    let mut outing = Outing::new(&made_up, default, 2);
    let flat = HeightField::flat();
    let good = Control::default();
    let before = outing.walkers.clone();
    for (dt_s, controls) in [
        (-1.0, vec![good; 2]),
        (f32::NAN, vec![good; 2]),
        (DT_S, vec![good; 3]),
        (DT_S, vec![good, Control { position: Vec2::new(f32::NAN, 0.0), ..good }]),
        (DT_S, vec![good, Control { heading: Some(f32::INFINITY), ..good }]),
    ] {
        assert!(outing.walkers.step(&space, dt_s, &controls, &flat).is_err());
        assert_eq!(outing.walkers.root(1), before.root(1));
    }
    let other = MadeUp::new(&[[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]], [2, 2, 2]);
    let e = outing.walkers.step(&other.space(), DT_S, &[good; 2], &flat).expect_err("another space");
    assert!(matches!(e, BlendError::OtherSpace { expected: 20, got: 2, .. }), "{e}");
}
