//! Targets that are struck.

use super::*;

const DT: f32 = 1.0 / 120.0;

#[test]
fn a_target_swings_out_by_an_amount_proportional_to_the_blow_and_comes_back() {
    let config = TargetConfig::default();
    for speed in [1.0, 3.0, 6.0] {
        let mut target = StruckTarget::new(Vec3::new(1.0, 1.5, 2.0));
        let direction = Vec3::new(0.6, 0.0, 0.8);
        target.strike(&config, direction, speed);
        let mut furthest = Vec3::ZERO;
        for _ in 0..1200 {
            target.step(&config, DT);
            if target.offset.length() > furthest.length() {
                furthest = target.offset;
            }
        }
        assert!(furthest.distance(direction * speed * config.deflection_m_per_mps) < 1e-3, "{furthest}");
        assert!(target.position().distance(target.home) < 1e-4);
    }
}

#[test]
fn a_target_stops_at_its_limit_however_often_it_is_struck() {
    let config = TargetConfig::default();
    let mut target = StruckTarget::new(Vec3::ZERO);
    for _ in 0..100 {
        target.strike(&config, Vec3::X, 50.0);
        target.step(&config, DT);
        assert!(target.offset.length() < config.max_deflection_m + 1e-5);
    }
    assert!(target.offset.length() > 0.9 * config.max_deflection_m);
}

#[test]
fn how_a_target_moves_does_not_depend_on_the_step() {
    let config = TargetConfig::default();
    let mut coarse = StruckTarget::new(Vec3::ZERO);
    coarse.strike(&config, Vec3::Z, 4.0);
    let mut fine = coarse;
    coarse.step(&config, 0.3);
    (0..300).for_each(|_| fine.step(&config, 0.001));
    assert!(coarse.offset.distance(fine.offset) < 1e-4 && coarse.velocity.distance(fine.velocity) < 1e-3);
}

/// Practice of characters whose targets hang where their blows go, beside those of the odd ones.
fn practice(tables: &Bundle, n: usize) -> TargetPractice {
    let mut practice = TargetPractice::with_capacity(tables, n, PracticeConfig::default()).unwrap();
    for i in 0..n {
        let root = Planar::new(3.0 * i as f32, 1.0, 0.4 * i as f32);
        let id = practice.spawn(Spawn { root, state: Some(0), floor_m: 0.0 }).unwrap();
        practice.order(id, PolicyOrder::towards(0, Vec3::new(0.0, 50.0, 0.0))).unwrap();
    }
    practice.step(0.0, &Inline).unwrap();
    for c in 0..n {
        let (blow, _) = practice.characters().next_blow(practice.boxers().motion_set(), c).unwrap();
        let aside = if c % 2 == 0 { 0.1 } else { 0.3 };
        practice.order(Id::first(c), PolicyOrder::towards(0, blow.point + Vec3::Y * aside)).unwrap();
    }
    practice
}

/// A blow five frames into the segments that start at 20 and 80.
fn practice_tables() -> Bundle {
    tables_with(&[25, 85].map(|f| hit(f, Vec3::new(0.1, 1.5, 0.6), Vec3::Z)))
}

#[test]
fn blows_that_come_near_enough_hit_and_deflect_the_target() {
    let tables = practice_tables();
    let mut practice = practice(&tables, 6);
    let mut hit = [0; 6];
    for _ in 0..12 {
        practice.step(1.0 / 60.0, &Inline).unwrap();
        for (id, h) in practice.events() {
            hit[id.index()] += 1;
            // The radius and the reach, less the tenth of a metre that it hangs too high.
            let config = practice.config();
            let depth = config.target.radius_m + config.reach_m - 0.1;
            assert!((h.depth_m - depth).abs() < 1e-3, "{}", h.depth_m);
            let target = practice.targets()[id.index()];
            assert!(target.velocity.normalize().distance(h.blow.direction) < 1e-4);
        }
    }
    assert_eq!(hit, [1, 0, 1, 0, 1, 0]);
    for c in 0..6 {
        let landed = u32::from(c % 2 == 0);
        assert_eq!(
            practice.tally(Id::first(c)).unwrap(),
            BlowTally { thrown: 1, landed, blocked: 0, missed: 1 - landed }
        );
        assert_eq!(practice.targets()[c].offset.length() > 0.01, landed == 1);
    }
    let blows = practice.figures().blows;
    assert_eq!((blows.thrown, blows.landed, blows.missed, blows.landed_fraction()), (6, 3, 3, 0.5));
    assert!((practice.figures().seconds - 0.2).abs() < 1e-6);
}

#[test]
fn restored_practice_repeats_what_followed() {
    let tables = practice_tables();
    let mut practice = practice(&tables, 5);
    (0..15).for_each(|_| practice.step(1.0 / 60.0, &Inline).unwrap());
    let mut kept = Vec::new();
    practice.save(&mut kept);
    let run = |p: &mut TargetPractice| {
        let step = |_| {
            p.step(1.0 / 60.0, &Inline).unwrap();
            (p.characters().model_matrices().to_vec(), p.targets().to_vec(), p.figures())
        };
        (0..100).map(step).collect::<Vec<_>>()
    };
    let first = run(&mut practice);
    practice.load(&kept).unwrap();
    assert!(first == run(&mut practice));
}

#[test]
fn refuses_what_does_not_fit() {
    let tables = practice_tables();
    let far = PracticeConfig { reach_m: -1.0, ..PracticeConfig::default() };
    let refused = TargetPractice::with_capacity(&tables, 1, far);
    assert!(matches!(refused, Err(Error::Value { what: "reach_m", .. })));
    let mut practice = practice(&tables, 1);
    let (id, before) = (Id::first(0), practice.hash());
    for at in [Vec3::NAN, Vec3::INFINITY] {
        let e = practice.order(id, PolicyOrder::towards(0, at)).unwrap_err();
        assert!(matches!(e, Error::Value { what: "target", who, .. } if who == Some(id)), "{e}");
    }
    assert!(matches!(practice.order(id, PolicyOrder::towards(1, Vec3::Y)), Err(Error::Index { what: "policy", .. })));
    assert!(matches!(practice.order(Id::first(1), PolicyOrder::IDLE), Err(Error::Gone(_))));
    assert_eq!(practice.hash(), before);
}

#[test]
fn boxers_come_and_go_with_their_targets() {
    let tables = practice_tables();
    let mut practice = practice(&tables, 3);
    let ids = practice.bodies().ids.to_vec();
    let last = practice.targets()[2];
    practice.despawn(ids[0]).unwrap();
    assert_eq!((practice.bodies().ids, practice.targets()[0]), (&[ids[2], ids[1]][..], last));
    assert_eq!(practice.order_of(ids[2]).unwrap().target(), last.home);
    // Who has no order has no target, wherever it strikes.
    let new = practice.spawn(Spawn::standing_at(Planar::IDENTITY)).unwrap();
    (0..60).for_each(|_| practice.step(1.0 / 60.0, &Inline).unwrap());
    let tally = practice.tally(new).unwrap();
    assert!(tally.thrown > 0 && tally.landed == 0, "{tally:?}");
}
