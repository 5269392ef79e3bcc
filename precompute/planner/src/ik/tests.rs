use super::*;
use crate::limits::{BodyLimits, Coordinates, PoseSampler, Style};
use crate::linkage::Limb;
use crate::rotation::{angle_between, exp};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::PI;
use throng_core::{Joint, Skeleton};

struct Setup {
    chain: Chain,
    limits: [JointLimits; LIMB_JOINTS],
    ik: LimbIk,
    sampler: PoseSampler,
}

fn setup(limb: Limb, skeleton: &Skeleton) -> Setup {
    let chain = Chain::new(limb, skeleton);
    let limits = BodyLimits::built_in(skeleton).limb_limits(limb).expect("limits");
    let sampler = PoseSampler::new(limits, &LimbPose::REST, Style::default(), 1);
    Setup { chain, limits, ik: LimbIk::new(&chain, &limits), sampler }
}

/// Proportions of nobody: nothing lies along an axis.
fn crooked() -> Skeleton {
    let mut s = Skeleton::default();
    for j in [Joint::LeftForearm, Joint::LeftHand, Joint::RightShin, Joint::RightFoot] {
        let o = &mut s.offsets[j.index()];
        *o += glam::Vec3::new(0.011, -0.017, 0.023);
    }
    s
}

fn base(rng: &mut Pcg64Mcg) -> Rigid {
    let v = std::array::from_fn(|_| rng.random_range(-2.0..2.0));
    Rigid { position: glam::DVec3::new(0.4, 1.3, -2.0), rotation: exp(glam::DVec3::from_array(v)) }
}

fn error(chain: &Chain, base: &Rigid, pose: &LimbPose, goal: &Rigid) -> (f64, f64) {
    let hand = chain.place_joints(base, pose)[LIMB_JOINTS - 1];
    ((hand.position - goal.position).length(), angle_between(hand.rotation, goal.rotation))
}

/// Forward, then back: what a pose within limits reaches is reached, within limits, exactly.
#[test]
fn what_forward_kinematics_reaches_is_reached() {
    // A quick look here; `throng bench plan` has more.
    for skeleton in [Skeleton::default(), crooked()] {
        for limb in Limb::ALL {
            let s = setup(limb, &skeleton);
            let mut rng = Pcg64Mcg::seed_from_u64(7);
            for i in 0..12_500 {
                let base = base(&mut rng);
                let wanted = s.sampler.draw_pose(&mut rng, 1);
                let present = s.sampler.draw_pose(&mut rng, 1);
                let goal = s.chain.place_joints(&base, &wanted)[2];
                let found = s.ik.solve_free(&base, &goal, &present).unwrap_or_else(|e| panic!("{limb:?} {i}: {e}"));
                let (far, turned) = error(&s.chain, &base, &found, &goal);
                assert!(far < 1e-9 && turned < 1e-7, "{limb:?} {i}: {far} m, {turned} rad");
                for k in 0..3 {
                    assert!(s.limits[k].excess(found.0[k]) <= 1e-6, "{limb:?} {i} {k}");
                }
            }
        }
    }
}

/// On the very edge of limits the window of swivels has no width, and at full stretch nor has the elbow's circle.
#[test]
fn poses_at_limits_and_at_full_stretch_are_reached() {
    for limb in Limb::ALL {
        let s = setup(limb, &Skeleton::default());
        let mut rng = Pcg64Mcg::seed_from_u64(8);
        for i in 0..300 {
            let mut wanted = s.sampler.draw_pose(&mut rng, 1);
            let flexion = if i % 2 == 0 { 0.0 } else { s.limits[1].coordinates(wanted.0[1]).swing[0] };
            let twist = s.limits[1].twist;
            let twist = if i % 3 == 0 { twist.most } else { twist.least };
            wanted.0[1] = s.limits[1].rotation(Coordinates { swing: [flexion, 0.0], twist });
            let base = base(&mut rng);
            let goal = s.chain.place_joints(&base, &wanted)[2];
            let present = s.sampler.draw_pose(&mut rng, 1);
            let found = s.ik.solve_free(&base, &goal, &present).unwrap_or_else(|e| panic!("{limb:?} {i}: {e}"));
            let (far, turned) = error(&s.chain, &base, &found, &goal);
            assert!(far < 1e-5 && turned < 1e-4, "{limb:?} {i}: {far} {turned}");
        }
    }
}

/// Newton steps on seven angles from many starts, knowing nothing of swivels.
fn by_numbers(s: &Setup, base: &Rigid, goal: &Rigid, rng: &mut Pcg64Mcg) -> bool {
    let pose = |x: &[f64; 7]| {
        let shoulder = Coordinates { swing: [x[0], x[1]], twist: x[2] };
        let elbow = Coordinates { swing: [x[3], 0.0], twist: x[4] };
        let wrist = Coordinates { swing: [x[5], x[6]], twist: 0.0 };
        let mut out = LimbPose::REST;
        for (i, c) in [shoulder, elbow, wrist].into_iter().enumerate() {
            out.0[i] = s.limits[i].rotation(c);
        }
        out
    };
    let cost = |x: &[f64; 7]| {
        let p = pose(x);
        let (far, turned) = error(&s.chain, base, &p, goal);
        let outside: f64 = (0..3).map(|i| s.limits[i].excess(p.0[i]).max(0.0)).sum();
        far + 0.3 * turned + outside
    };
    (0..60).any(|_| {
        let start = s.sampler.draw_pose(rng, 1);
        let c: [Coordinates; 3] = std::array::from_fn(|i| s.limits[i].coordinates(start.0[i]));
        let mut x = [c[0].swing[0], c[0].swing[1], c[0].twist, c[1].swing[0], c[1].twist, c[2].swing[0], c[2].swing[1]];
        // Pattern search: each angle up or down, with steps that halve where nothing helps.
        let (mut step, mut best) = (0.3, cost(&x));
        while step > 1e-4 {
            let mut moved = false;
            for k in 0..7 {
                for d in [step, -step] {
                    let mut y = x;
                    y[k] += d;
                    let c = cost(&y);
                    if c < best {
                        (x, best, moved) = (y, c, true);
                    }
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        best < 2e-3
    })
}

/// Goals at random: where a numerical search finds a pose within limits, so does the analytic one.
#[test]
fn no_goal_is_missed_that_a_numerical_search_reaches() {
    let s = setup(Limb::LeftArm, &Skeleton::default());
    let mut rng = Pcg64Mcg::seed_from_u64(9);
    let (mut reached, mut refused) = (0, 0);
    for i in 0..40 {
        let base = base(&mut rng);
        let v = |rng: &mut Pcg64Mcg| glam::DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let at = v(&mut rng).normalize() * rng.random_range(0.2..0.545) + s.chain.offsets[0];
        let goal = base.compose(Rigid { position: at, rotation: exp(v(&mut rng) * PI * 0.6) });
        match s.ik.solve_free(&base, &goal, &LimbPose::REST) {
            Ok(_) => reached += 1,
            // Within a tenth of a radian the coarse search may find what is just outside.
            Err(IkError::OutOfLimits { by_rad, .. }) if by_rad < 0.02 => {}
            Err(e) => {
                refused += 1;
                assert!(!by_numbers(&s, &base, &goal, &mut rng), "{i}: {e}, but a search reaches it");
            }
        }
    }
    assert!(reached > 5 && refused > 5, "{reached} {refused}");
}

#[test]
fn the_swivel_of_the_present_pose_is_kept_where_it_can_be() {
    let s = setup(Limb::RightArm, &Skeleton::default());
    let mut rng = Pcg64Mcg::seed_from_u64(10);
    for _ in 0..500 {
        let present = s.sampler.draw_pose(&mut rng, 1);
        let base = base(&mut rng);
        let here = s.chain.place_joints(&base, &present);
        let found = s.ik.solve_free(&base, &here[2], &present).expect("where it already is");
        let elbow = s.chain.place_joints(&base, &found)[1].position;
        assert!((elbow - here[1].position).length() < 1e-6);
    }
}

#[test]
fn reasons_say_how_far_and_what() {
    let s = setup(Limb::LeftArm, &Skeleton::default());
    let base = Rigid::IDENTITY;
    let at = |x: f64, y: f64, z: f64| Rigid::from_position(s.chain.offsets[0] + glam::DVec3::new(x, y, z));
    let far = s.ik.solve_free(&base, &at(0.29 + 0.255 + 0.12, 0.0, 0.0), &LimbPose::REST).unwrap_err();
    assert_eq!(far.to_string(), "out of reach by 0.12 m");
    let near = s.ik.solve_free(&base, &at(0.0, 0.0, 0.02), &LimbPose::REST).unwrap_err();
    assert!(matches!(near, IkError::OutOfReach { by_m } if (0.1..0.2).contains(&by_m)), "{near}");
    // Straight behind the back, fingers forwards.
    let behind = s.ik.solve_free(&base, &at(-0.3, 0.1, -0.4), &LimbPose::REST).unwrap_err();
    assert!(behind.to_string().starts_with("out of limits of the "), "{behind}");
    // By as much as the best of all swivels is.
    for [x, y, z] in [[-0.3, 0.1, -0.4], [0.2, 0.3, -0.3], [-0.4, 0.0, 0.1]] {
        let reach = s.ik.reach_geometry(&at(x, y, z)).expect("within reach");
        let excess = |i: i32| {
            let half = f64::from(i) * PI / 7200.0;
            s.ik.pose_at_half_swivel(&reach, [half.cos(), half.sin()]).excess
        };
        let least = (0..7200).map(excess).fold(f64::INFINITY, f64::min);
        match s.ik.solve_free(&base, &at(x, y, z), &LimbPose::REST).unwrap_err() {
            IkError::OutOfLimits { by_rad, .. } => assert!((by_rad - least).abs() < 1e-3, "{x}: {by_rad} {least}"),
            other => panic!("{x}: {other}"),
        }
    }
    let mut ahead = at(0.1, -0.1, 0.35);
    ahead.rotation = crate::rotation::rotation_about(glam::DVec3::Y, -PI / 2.0);
    let wall = s.ik.solve(&base, &ahead, &LimbPose::REST, Swivel::Present, |_| Some("box")).unwrap_err();
    assert_eq!(wall.to_string(), "blocked by box");
    let nan = s.ik.solve_free(&base, &at(f64::NAN, 0.0, 0.0), &LimbPose::REST).unwrap_err();
    assert!(matches!(nan, IkError::OutOfReach { .. }));
}

#[test]
fn a_predicate_moves_the_elbow_elsewhere() {
    let s = setup(Limb::LeftArm, &Skeleton::default());
    let goal = Rigid {
        position: s.chain.offsets[0] + glam::DVec3::new(0.1, -0.1, 0.35),
        rotation: crate::rotation::rotation_about(glam::DVec3::Y, -PI / 2.0),
    };
    let elbow = |p: &LimbPose| s.chain.place_joints(&Rigid::IDENTITY, p)[1].position;
    let free = s.ik.solve_free(&Rigid::IDENTITY, &goal, &LimbPose::REST).expect("free");
    let away = elbow(&free);
    let other = s.ik.solve(&Rigid::IDENTITY, &goal, &LimbPose::REST, Swivel::Present, |p| {
        ((elbow(p) - away).length() < 0.05).then_some("post")
    });
    let other = other.expect("another swivel");
    let (far, _) = error(&s.chain, &Rigid::IDENTITY, &other, &goal);
    assert!((elbow(&other) - away).length() >= 0.05 && far < 1e-9);
}

/// What quick looks have inside or outside of limits is so by the angles, too, with the same pose; little is left on the edge.
#[test]
fn quick_looks_at_swivels_say_what_exact_ones_do() {
    let (mut on_edge, mut all) = (0, 0);
    for skeleton in [Skeleton::default(), crooked()] {
        for limb in Limb::ALL {
            let s = setup(limb, &skeleton);
            let mut rng = Pcg64Mcg::seed_from_u64(11);
            for _ in 0..300 {
                let base = base(&mut rng);
                let wanted = s.sampler.draw_pose(&mut rng, 1);
                let goal = s.chain.place_joints(&base, &wanted)[2];
                let reach = s.ik.reach_geometry(&base.to_local(goal)).expect("within reach");
                let swivels = SwivelLimits::new(&s.ik, &reach);
                for half in HALVES.iter() {
                    let tried = s.ik.pose_at_half_swivel(&reach, *half);
                    let (fit, pose) = swivels.check_swivel(*half);
                    all += 1;
                    match fit {
                        LimitFit::Outside => assert!(tried.excess > ON_LIMIT, "{limb:?}: {}", tried.excess),
                        LimitFit::Inside => {
                            // At the very ends of the elbow's range there is nothing inside.
                            assert!(tried.excess <= ON_LIMIT, "{limb:?}: {}", tried.excess);
                            assert!((0..3).all(|i| angle_between(pose[i], tried.pose[i]) < 1e-12), "{limb:?}");
                        }
                        LimitFit::OnEdge => on_edge += 1,
                    }
                }
            }
        }
    }
    assert!(all > 60_000 && 500 * on_edge < all, "{on_edge} of {all}");
}

#[test]
fn half_a_swivel_is_exact_all_around() {
    let s = setup(Limb::LeftArm, &Skeleton::default());
    let goal = Rigid { position: glam::DVec3::new(0.4, 0.1, 0.3), rotation: exp(glam::DVec3::new(0.1, -1.3, 0.2)) };
    let reach = s.ik.reach_geometry(&goal).expect("within reach");
    for i in 0..720 {
        let swivel = (f64::from(i) - 360.0) * PI / 360.0;
        let shoulder = crate::rotation::rotation_about(reach.line, swivel) * reach.onto;
        let [cos, sin] = s.ik.first_swivel(&reach, shoulder, Swivel::Present);
        let found = 2.0 * sin.atan2(cos);
        let off = (found - swivel + PI).rem_euclid(2.0 * PI) - PI;
        assert!(off.abs() < 1e-9 && (cos.hypot(sin) - 1.0).abs() < 1e-12, "{swivel} {found}");
    }
}

#[test]
fn elbows_begin_half_way_down() {
    let s = setup(Limb::LeftArm, &Skeleton::default());
    let mut rng = Pcg64Mcg::seed_from_u64(9);
    let (mut lower, mut tried) = (0, 0);
    for _ in 0..500 {
        let pose = s.sampler.draw_pose(&mut rng, 1);
        let goal = s.chain.place_joints(&Rigid::IDENTITY, &pose)[2];
        let Ok(reach) = s.ik.reach_geometry(&goal) else { continue };
        // Where the elbow is, across the line from shoulder to wrist.
        let elbow = |[cos, sin]: [f64; 2]| {
            let at = s.ik.pose_at_half_swivel(&reach, [cos, sin]).pose[0] * s.ik.elbow.upper;
            at - reach.line * at.dot(reach.line)
        };
        let down = DVec3::NEG_Y - reach.line * DVec3::NEG_Y.dot(reach.line);
        let [was, is] = [Swivel::Present, Swivel::Low { down: DVec3::NEG_Y }]
            .map(|f| elbow(s.ik.first_swivel(&reach, pose.0[0], f)));
        if was.length() < 0.02 || down.length() < 0.1 || was.angle_between(down) > 3.0 {
            continue;
        }
        tried += 1;
        // Between where it was and straight down.
        lower += usize::from(
            is.angle_between(down) <= was.angle_between(down) + 1e-9
                && is.angle_between(was) <= down.angle_between(was) + 1e-9,
        );
    }
    assert!(tried > 300 && lower == tried, "{lower} of {tried}");
}
