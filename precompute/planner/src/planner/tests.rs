use super::*;
use crate::problem::{LimbState, MovingSolid};
use crate::rotation::{Rigid, angle_between};
use crate::testing::{TestCharacter, solid, stuck};
use crate::track::RigidPath;
use glam::DVec3;
use throng_base::maths::slerp;
use throng_geometry::SolidShape;

/// A hand below a table that has to come above it: the straight way leads through the plate.
fn table() -> Problem {
    let s = TestCharacter::standing();
    let ends = [(s.pose(0.0, -1.2, 0.2), 0.0), (s.pose(0.0, 0.1, 0.3), 1.5)];
    let plate = SolidShape::cuboid(DVec3::new(0.9, 0.03, 0.6));
    s.problem(ends, &[solid("table", plate, DVec3::new(0.65, 1.2, 0.55))]).expect("a problem")
}

/// Looks at a motion a thousand times a second.
fn assert_free(problem: &Problem, motion: &LimbMotion<'_>) {
    let mut checker = Checker::default();
    let last = motion.frames.len() - 1;
    assert!((motion.start_s + last as f64 * motion.step_s - problem.goal.time_s).abs() < 1e-9);
    for i in 0..3 {
        assert!(angle_between(motion.frames[0].0[i], problem.init.pose.0[i]) < 1e-9);
        assert!(angle_between(motion.frames[last].0[i], problem.goal.pose.0[i]) < 1e-9);
    }
    let parts = (motion.step_s * 1000.0).ceil();
    for f in 0..last {
        let (a, b) = (&motion.frames[f], &motion.frames[f + 1]);
        for i in 0..3 {
            assert!(angle_between(a.0[i], b.0[i]) / motion.step_s <= problem.limits[i].speed + 1e-6);
        }
        for k in 0..parts as usize {
            let share = k as f64 / parts;
            let mut pose = *a;
            for i in 0..3 {
                pose.0[i] = slerp(a.0[i], b.0[i], share);
                assert!(problem.limits[i].excess(pose.0[i]) < 2e-3);
            }
            let state = LimbState { pose, time_s: motion.start_s + (f as f64 + share) * motion.step_s };
            let hit = checker.deepest_hit(problem, &state);
            assert!(
                hit.is_none_or(|h| h.depth_m < 1e-6),
                "{:?} at {}",
                hit.map(|h| (problem.hit_names(&h), h)),
                state.time_s
            );
        }
    }
}

fn solved(problem: &Problem, seed: u64) -> (LimbPlanner, PlanOutcome) {
    let mut planner = LimbPlanner::new();
    let outcome = planner.plan(problem, &PlanConfig::default(), &Budget { seed, ..Budget::default() });
    assert!(outcome.is_solved(), "seed {seed}: {outcome:?}");
    assert_free(problem, &planner.motion().expect("a motion"));
    (planner, outcome)
}

#[test]
fn an_empty_world_is_crossed_straight() {
    let s = TestCharacter::standing();
    let problem = s.problem([(s.pose(0.3, 0.3, 0.6), 0.0), (s.pose(-0.3, -0.3, 0.9), 1.0)], &[]).expect("a problem");
    let (_, outcome) = solved(&problem, 1);
    assert_eq!(outcome.nodes, 2);
    assert!(outcome.roughness[1].speed_max < 3.0 * outcome.roughness[0].speed_max);
}

#[test]
fn a_hand_comes_round_a_table() {
    let problem = table();
    for seed in 0..30 {
        let (_, outcome) = solved(&problem, seed);
        assert!(outcome.nodes > 2);
        assert!(outcome.roughness[1].jerk_rms < outcome.roughness[0].jerk_rms, "{:?}", outcome.roughness);
    }
}

/// Stops a search when it has asked often enough: after every node, one after the other.
#[test]
fn a_search_cancelled_after_any_node_leaves_what_was() {
    let problem = table();
    let fresh = solved(&problem, 5);
    let motion = |planner: &LimbPlanner| planner.motion().expect("a motion").frames.to_vec();
    let (mut planner, mut asked_most) = (fresh.0.clone(), 0);
    for stop in 1.. {
        let grid = TimeGrid::new(0.0, 1.5, 30.0);
        let config = PlanConfig::default();
        let quest = SearchRequest { problem: &problem, config: &config.search, grid, draws: 20_000, warm: false };
        let mut asked = 0;
        let found = planner.search.run(quest, &mut planner.checker, &mut seeded_rng(5), || {
            asked += 1;
            (asked == stop).then_some(SearchOutcome::Cancelled)
        });
        if found == SearchOutcome::Path {
            break;
        }
        assert_eq!((found, asked), (SearchOutcome::Cancelled, stop));
        asked_most = stop;
        let again = planner.plan(&problem, &PlanConfig::default(), &Budget { seed: 5, ..Budget::default() });
        assert_eq!((motion(&planner), again.nodes), (motion(&fresh.0), fresh.1.nodes));
    }
    assert!(asked_most > 2, "{asked_most}");
    let cancel = AtomicBool::new(true);
    let outcome =
        planner.plan(&problem, &PlanConfig::default(), &Budget { cancel: Some(&cancel), ..Budget::default() });
    assert!(matches!(outcome.why, Some(PlanError::Cancelled { draws: 0 })) && planner.motion().is_none());
}

/// The table is moved a little at a time: what is left of the trees is gone on with.
#[test]
fn a_warm_start_goes_on_with_the_last_trees() {
    let s = TestCharacter::standing();
    let ends = [(s.pose(0.0, -1.2, 0.2), 0.0), (s.pose(0.0, 0.1, 0.3), 1.5)];
    let at = |moved: f64| {
        let plate = SolidShape::cuboid(DVec3::new(0.9, 0.03, 0.6));
        s.problem(ends, &[solid("table", plate, DVec3::new(0.65, 1.2, 0.55 + moved))]).expect("a problem")
    };
    let (mut cold_checks, mut warm_checks) = (0, 0);
    for seed in 0..6 {
        let (mut planner, first) = solved(&at(0.0), seed);
        // Nothing has moved: the same way, without a sample.
        let warm = Budget { seed, warm: true, ..Budget::default() };
        let again = planner.plan(&at(0.0), &PlanConfig::default(), &warm);
        assert_eq!((again.nodes, planner.search().draws), (first.nodes, 0));
        for k in 1..8 {
            let problem = at(0.004 * f64::from(k));
            let outcome = planner.plan(&problem, &PlanConfig::default(), &warm);
            assert!(outcome.is_solved(), "{seed} {k}: {outcome:?}");
            assert_free(&problem, &planner.motion().expect("a motion"));
            warm_checks += planner.search().draws;
            let mut cold = LimbPlanner::new();
            cold.plan(&problem, &PlanConfig::default(), &Budget { seed, ..Budget::default() });
            cold_checks += cold.search().draws;
        }
    }
    assert!(2 * warm_checks < cold_checks, "{warm_checks} samples warm, {cold_checks} cold");
    // Another start and another goal: nothing is left.
    let mut planner = solved(&at(0.0), 1).0;
    let other = s.problem([(s.pose(0.1, -1.1, 0.2), 0.0), (s.pose(0.1, 0.1, 0.4), 1.5)], &[]).expect("a problem");
    let warm = Budget { warm: true, ..Budget::default() };
    assert!(planner.plan(&other, &PlanConfig::default(), &warm).is_solved());
    assert_free(&other, &planner.motion().expect("a motion"));
}

/// A wall before the hand has a hole only from 0.6 to 0.8 s.
#[test]
fn a_gate_that_opens_for_a_moment_is_passed_in_that_moment() {
    let s = TestCharacter::standing();
    // From beside the gate, through where it is, to the other side: the whole sheet moves up for 0.2 s.
    let ends = [(s.pose(0.9, -0.1, 0.1), 0.0), (s.pose(-0.5, -0.1, 0.1), 1.5)];
    let open = s.problem(ends, &[]).expect("a problem");
    let middle = open.place_chain(&LimbState { pose: s.pose(0.2, -0.1, 0.1), time_s: 0.0 });
    let along = (middle[2].position - middle[0].position).normalize();
    let normal = along.cross(DVec3::Y).normalize();
    // The plate stands along the arm, from near the body to far out; nothing gets round it.
    let rotation = crate::rotation::rotation_between(DVec3::X, normal);
    let closed = Rigid { position: middle[0].position + along * 0.8, rotation };
    let up = Rigid { position: closed.position + DVec3::Y * 8.0, rotation };
    let keys = [(0.0, closed), (0.55, closed), (0.6, up), (0.8, up), (0.85, closed), (2.0, closed)];
    let gate = MovingSolid {
        name: "gate".into(),
        shape: SolidShape::cuboid(DVec3::new(0.02, 4.0, 1.2)),
        path: RigidPath::from_keys(&keys),
    };
    let problem = s.problem(ends, &[gate]).expect("a problem");
    let mut config = PlanConfig::default();
    config.search.widen_over = 50;
    for seed in 0..5 {
        let mut planner = LimbPlanner::new();
        let outcome = planner.plan(&problem, &config, &Budget { seed, ..Budget::default() });
        assert!(outcome.is_solved(), "seed {seed}: {outcome:?}");
        let motion = planner.motion().expect("a motion");
        assert_free(&problem, &motion);
        // The hand changes sides while the gate is up, and at no other time.
        let side = |f: usize| {
            let state = LimbState { pose: motion.frames[f], time_s: motion.start_s + f as f64 * motion.step_s };
            (problem.place_chain(&state)[2].position - closed.position).dot(normal) > 0.0
        };
        for f in (1..motion.frames.len()).filter(|&f| side(f) != side(f - 1)) {
            let time_s = motion.start_s + f as f64 * motion.step_s;
            assert!((0.55..0.9).contains(&time_s), "{time_s}");
        }
    }
}

#[test]
fn a_goal_that_is_the_start_is_kept_or_left_and_found_again() {
    let s = TestCharacter::standing();
    let pose = s.pose(0.0, -0.2, 0.4);
    let still = s.problem([(pose, 0.0), (pose, 1.0)], &[]).expect("a problem");
    let (planner, _) = solved(&still, 1);
    let motion = planner.motion().expect("a motion");
    assert!(motion.frames.iter().all(|f| angle_between(f.0[0], pose.0[0]) < 1e-6));
    // A ball comes by: the hand gives way and comes back.
    let hand = still.place_chain(&still.init)[2].position;
    let away = DVec3::new(0.0, 0.0, 2.0);
    let keys = [(0.0, hand + away), (0.5, hand), (0.9, hand + away)].map(|(t, p)| (t, Rigid::from_position(p)));
    let ball = MovingSolid { name: "ball".into(), shape: SolidShape::ball(0.08), path: RigidPath::from_keys(&keys) };
    let problem = s.problem([(pose, 0.0), (pose, 1.0)], &[ball]).expect("a problem");
    for seed in 0..5 {
        let (_, outcome) = solved(&problem, seed);
        assert!(outcome.roughness[1].length_rad > 0.1);
    }
}

#[test]
fn the_seed_decides_at_any_number_of_threads() {
    let problem = table();
    let plan = |seed: u64| {
        let mut planner = LimbPlanner::new();
        let outcome = planner.plan(&problem, &PlanConfig::default(), &Budget { seed, ..Budget::default() });
        (outcome.checks, planner.motion().map(|m| m.frames.to_vec()))
    };
    let alone: Vec<_> = (0..4).map(plan).collect();
    assert!(alone[0].1 != alone[1].1);
    for threads in [1, 2, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        use rayon::prelude::*;
        let together: Vec<_> = pool.install(|| (0..4u64).into_par_iter().map(plan).collect());
        assert_eq!(together, alone);
    }
    // A planner that planned something else before plans the same.
    let mut used = LimbPlanner::new();
    let budget = |seed| Budget { seed, ..Budget::default() };
    used.plan(&problem, &PlanConfig::default(), &budget(7));
    used.plan(&problem, &PlanConfig::default(), &budget(0));
    assert_eq!(used.motion().map(|m| m.frames.to_vec()), alone[0].1);
}

#[test]
fn what_cannot_be_done_ends_with_the_budget_and_says_how_near_it_came() {
    let s = TestCharacter::standing();
    let problem = stuck(&s);
    let outcome =
        LimbPlanner::new().plan(&problem, &PlanConfig::default(), &Budget { draws: 300, ..Budget::default() });
    let Some(PlanError::Spent { draws, nearest_m }) = outcome.why else { panic!("{outcome:?}") };
    assert!(draws == 300 && nearest_m > 0.01 && nearest_m < 1.0, "{nearest_m}");
}

#[test]
fn cancelled_or_without_time_it_stops_and_can_go_on_later() {
    let problem = table();
    let cancel = AtomicBool::new(true);
    let mut planner = LimbPlanner::new();
    let outcome =
        planner.plan(&problem, &PlanConfig::default(), &Budget { cancel: Some(&cancel), ..Budget::default() });
    assert_eq!(outcome.why, Some(PlanError::Cancelled { draws: 0 }));
    assert!(planner.motion().is_none());
    let outcome = planner.plan(&problem, &PlanConfig::default(), &Budget { seconds: Some(0.0), ..Budget::default() });
    assert!(matches!(outcome.why, Some(PlanError::Spent { .. })));
    // After any number of samples it leaves nothing behind that matters.
    let whole = solved(&problem, 3).0.motion().map(|m| m.frames.to_vec());
    for draws in [1, 2, 5, 17] {
        planner.plan(&problem, &PlanConfig::default(), &Budget { draws, seed: 9, ..Budget::default() });
        planner.plan(&problem, &PlanConfig::default(), &Budget { seed: 3, ..Budget::default() });
        assert_eq!(planner.motion().map(|m| m.frames.to_vec()), whole);
    }
    let rate = planner.plan(&problem, &PlanConfig::default(), &Budget { rate_hz: f64::NAN, ..Budget::default() });
    assert_eq!(rate.why, Some(PlanError::Rate));
}

#[test]
fn styles_give_low_and_high_arms() {
    let problem = table();
    let highest = |low: f64, high: f64| {
        let mut config = PlanConfig::default();
        config.search.style.swing[0][1] = Some(crate::limits::AngleInterval::new(low, high));
        config.smooth.straighten = 0;
        let mut most = f64::NEG_INFINITY;
        for seed in 0..5 {
            let mut planner = LimbPlanner::new();
            assert!(planner.plan(&problem, &config, &Budget { seed, ..Budget::default() }).is_solved());
            let motion = planner.motion().expect("a motion");
            for pose in motion.frames {
                let elbow = problem.place_chain(&LimbState { pose: *pose, time_s: 0.5 })[1].position.y;
                most = f64::max(most, elbow);
            }
        }
        most
    };
    let (low, high) = (highest(-1.5, -0.3), highest(0.4, 1.5));
    assert!(high > low + 0.05, "{low} {high}");
}

/// Two plates with a slit between them that a hand is too thick for: the way leads below both.
#[test]
fn a_slit_too_narrow_is_gone_round() {
    let s = TestCharacter::standing();
    let ends = [(s.pose(0.9, -0.1, 0.1), 0.0), (s.pose(-0.5, -0.1, 0.1), 1.5)];
    let open = s.problem(ends, &[]).expect("a problem");
    let middle = open.place_chain(&LimbState { pose: s.pose(0.2, -0.1, 0.1), time_s: 0.0 });
    let along = (middle[2].position - middle[0].position).with_y(0.0).normalize();
    let normal = along.cross(DVec3::Y).normalize();
    let rotation = crate::rotation::rotation_between(DVec3::X, normal);
    let at = middle[0].position + along * 0.85;
    let plate = |name: &str, low: f64, high: f64| MovingSolid {
        name: name.into(),
        shape: SolidShape::cuboid(DVec3::new(0.02, high - low, 1.3)),
        path: RigidPath::Still(Rigid { position: at.with_y(0.5 * (low + high)), rotation }),
    };
    // Slit at the height at which the hand swings across, 4 cm wide.
    let height = middle[2].position.y;
    let solids = [plate("lower", height - 0.25, height - 0.02), plate("upper", height + 0.02, 4.0)];
    let problem = s.problem(ends, &solids).expect("a problem");
    for seed in 0..5 {
        let (planner, _) = solved(&problem, seed);
        let motion = planner.motion().expect("a motion");
        let hands = motion.frames.iter().map(|p| problem.place_chain(&LimbState { pose: *p, time_s: 0.0 })[2].position);
        let hands: Vec<DVec3> = hands.collect();
        let side = |p: DVec3| (p - at).dot(normal) > 0.0;
        for w in hands.windows(2).filter(|w| side(w[0]) != side(w[1])) {
            let near_body = (w[0] - middle[0].position).dot(along) < 0.2;
            assert!(w[0].y < height - 0.25 || near_body, "{w:?}");
        }
    }
}

#[test]
fn a_reach_from_rest_to_rest_has_one_peak_of_speed() {
    let s = TestCharacter::standing();
    let problem = s.problem([(s.pose(0.5, -0.6, 1.2), 0.0), (s.pose(-0.3, 0.2, 0.4), 1.2)], &[]).expect("a problem");
    let mut planner = LimbPlanner::new();
    let budget = Budget { rate_hz: 60.0, ..Budget::default() };
    assert!(planner.plan(&problem, &PlanConfig::default(), &budget).is_solved());
    let motion = planner.motion().expect("a motion");
    let hand = |f: usize| problem.place_chain(&LimbState { pose: motion.frames[f], time_s: 0.0 })[2].position;
    let speeds: Vec<f64> = (1..motion.frames.len()).map(|f| hand(f).distance(hand(f - 1))).collect();
    let peak = speeds.iter().copied().fold(0.0, f64::max);
    // Starting and stopping gently, and never slow in between.
    assert!(speeds[0] < 0.05 * peak && speeds[speeds.len() - 1] < 0.05 * peak, "{speeds:?}");
    let moving: Vec<usize> = (0..speeds.len()).filter(|i| speeds[*i] > 0.5 * peak).collect();
    assert!(moving.windows(2).all(|w| w[1] == w[0] + 1), "{speeds:?}");
}

#[test]
fn variants_differ_by_what_is_said() {
    let problem = table();
    let motions: Vec<LimbPlanner> = (0..3).map(|seed| solved(&problem, seed).0).collect();
    let apart =
        |a: &LimbPlanner, b: &LimbPlanner| a.motion().expect("a motion").distance_rad(&b.motion().expect("a motion"));
    assert_eq!(apart(&motions[0], &motions[0]), 0.0);
    assert!(apart(&motions[0], &motions[1]) > 0.05 && apart(&motions[1], &motions[2]) > 0.05);
    assert_eq!(apart(&motions[0], &motions[1]), apart(&motions[1], &motions[0]));
}
