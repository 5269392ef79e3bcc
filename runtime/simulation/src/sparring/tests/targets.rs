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
    let r = MotionSet::new(tables);
    let starts: Vec<Start> =
        (0..n).map(|i| Start { root: Planar::new(3.0 * i as f32, 1.0, 0.4 * i as f32), state: 0 }).collect();
    let config = PracticeConfig::new(vec![PracticeGoal { policy: 0, weight: 1.0 }]);
    let homes = vec![Vec3::new(0.0, 50.0, 0.0); n];
    let mut practice = TargetPractice::new(&r, config, &starts, &homes).unwrap();
    practice.step(&r, 0.0).unwrap();
    for c in 0..n {
        let (blow, _) = practice.characters().next_blow(&r, c).unwrap();
        let aside = if c % 2 == 0 { 0.1 } else { 0.3 };
        practice.set_home(c, blow.point + Vec3::Y * aside).unwrap();
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
    let r = MotionSet::new(&tables);
    let mut practice = practice(&tables, 6);
    let mut hit = [0; 6];
    for _ in 0..12 {
        practice.step(&r, 1.0 / 60.0).unwrap();
        for h in practice.hits() {
            hit[h.blow.character as usize] += 1;
            // The radius and the reach, less the tenth of a metre that it hangs too high.
            let config = practice.config();
            let depth = config.target.radius_m + config.reach_m - 0.1;
            assert!((h.depth_m - depth).abs() < 1e-3, "{}", h.depth_m);
            let target = practice.targets()[h.blow.character as usize];
            assert!(target.velocity.normalize().distance(h.blow.direction) < 1e-4);
        }
    }
    assert_eq!(hit, [1, 0, 1, 0, 1, 0]);
    for c in 0..6 {
        let landed = u32::from(c % 2 == 0);
        assert_eq!(practice.tally(c), Tally { thrown: 1, landed, blocked: 0, missed: 1 - landed });
        assert_eq!(practice.targets()[c].offset.length() > 0.01, landed == 1);
    }
    let blows = practice.figures().blows;
    assert_eq!((blows.thrown, blows.landed, blows.missed, blows.landed_fraction()), (6, 3, 3, 0.5));
    assert!((practice.figures().seconds - 0.2).abs() < 1e-6);
}

#[test]
fn restored_practice_repeats_what_followed() {
    let tables = practice_tables();
    let r = MotionSet::new(&tables);
    let mut practice = practice(&tables, 5);
    (0..15).for_each(|_| practice.step(&r, 1.0 / 60.0).unwrap());
    let mut kept = Vec::new();
    practice.save(&mut kept);
    let run = |p: &mut TargetPractice| {
        let step = |_| {
            p.step(&r, 1.0 / 60.0).unwrap();
            (p.characters().model_matrices().to_vec(), p.targets().to_vec(), p.figures())
        };
        (0..100).map(step).collect::<Vec<_>>()
    };
    let first = run(&mut practice);
    practice.load(&r, &kept).unwrap();
    assert!(first == run(&mut practice));
}

#[test]
fn refuses_what_does_not_fit() {
    let tables = practice_tables();
    let r = MotionSet::new(&tables);
    let starts = [Start { root: Planar::IDENTITY, state: 0 }];
    let good = PracticeConfig::new(vec![PracticeGoal { policy: 0, weight: 1.0 }]);
    let new = |config: &PracticeConfig, homes: &[Vec3]| TargetPractice::new(&r, config.clone(), &starts, homes);
    assert!(matches!(new(&good, &[]), Err(Error::Length { what: "homes", .. })));
    assert!(matches!(new(&good, &[Vec3::NAN]), Err(Error::Value { what: "home", .. })));
    assert!(matches!(
        new(&PracticeConfig::default(), &[Vec3::Y]),
        Err(Error::Value { what: "the number of goals", .. })
    ));
    let far = PracticeConfig { reach_m: -1.0, ..good.clone() };
    assert!(matches!(new(&far, &[Vec3::Y]), Err(Error::Value { what: "reach_m", .. })));
    let mut practice = new(&good, &[Vec3::Y]).unwrap();
    assert!(matches!(practice.set_home(1, Vec3::Y), Err(Error::Index { what: "character", .. })));
    assert!(matches!(practice.set_home(0, Vec3::INFINITY), Err(Error::Value { what: "home", .. })));
}
