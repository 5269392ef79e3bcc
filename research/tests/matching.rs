//! Motion matching on a small bundle: its features are those of the frames, its searches find them, and characters that
//! are moved by it come to their targets.

#[path = "../../tests/common/mod.rs"]
mod common;

use glam::{Vec2, Vec3};
use throng_core::Planar;
use throng_research::matching::{
    BoxSearch, Character, Database, FeatureWeights, KdTree, MatchGoal, Nearest, SEARCH_FRAMES, WIDTH, brute_force,
};
use throng_research::measure::{self, MatchingConfig};

fn squared(a: &[f32; WIDTH], b: &[f32; WIDTH]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[test]
fn searches_find_frames_by_their_own_features() {
    let tables = common::tables();
    let db = Database::new(&tables, &FeatureWeights::default());
    assert!(db.rows().len() > 1000 && db.rows().len() < tables.frames().len());
    let (boxes, tree) = (BoxSearch::new(db.rows()), KdTree::new(db.rows()));
    for i in (0..db.rows().len()).step_by(97) {
        let row = db.rows()[i];
        assert_eq!(&row, db.row_of(db.frame(i as u32)));
        for found in [
            boxes.find(&row, Nearest::within(f32::INFINITY)),
            tree.find(&row, Nearest::within(f32::INFINITY)),
            brute_force(db.rows(), &row, Nearest::within(f32::INFINITY)),
        ] {
            assert_eq!((found.row, found.distance), (Some(i as u32), 0.0));
        }
    }
}

#[test]
fn features_are_alike_in_spread_and_follow_their_weights() {
    let tables = common::tables();
    let spread = |weights: &FeatureWeights, at: std::ops::Range<usize>| {
        let db = Database::new(&tables, weights);
        let n = db.rows().len() as f32;
        let of = |k: usize| {
            let mean = db.rows().iter().map(|r| r[k]).sum::<f32>() / n;
            (db.rows().iter().map(|r| (r[k] - mean).powi(2)).sum::<f32>() / n).sqrt()
        };
        at.clone().map(of).sum::<f32>() / at.len() as f32
    };
    let plain = FeatureWeights::default();
    // Feet stand at 19 to 25, hips' velocity at 16 to 19. The frames at the ends of runs are left out here.
    assert!((spread(&plain, 19..25) / plain.feet - 1.0).abs() < 0.1);
    assert!((spread(&plain, 16..19) / plain.hips - 1.0).abs() < 0.1);
    let heavy = FeatureWeights { feet: 3.0, ..plain };
    assert!((spread(&heavy, 19..25) / spread(&plain, 19..25) - 3.0 / plain.feet).abs() < 1e-3);
    // There are no hits in walks, so that they tell nothing.
    assert_eq!(spread(&plain, 12..16), 0.0);
}

#[test]
fn a_query_is_the_pose_that_plays_and_the_way_that_is_wanted() {
    let tables = common::tables();
    let db = Database::new(&tables, &FeatureWeights::default());
    let frame = db.frame(500);
    let goal = |z: f32| MatchGoal { place: Vec2::new(0.0, z), look: Vec2::new(0.0, z), speed_mps: 1.3, hit: None };
    let (ahead, behind) = (db.query(frame, &goal(5.0)), db.query(frame, &goal(-5.0)));
    assert_eq!(ahead[16..], db.row_of(frame)[16..]);
    assert_eq!(ahead[16..], behind[16..]);
    assert!(squared(&ahead, &behind) > 1.0);
}

#[test]
fn characters_play_on_between_searches_and_never_leave_a_run() {
    let tables = common::tables();
    let db = Database::new(&tables, &FeatureWeights::default());
    let boxes = BoxSearch::new(db.rows());
    let mut c = Character::new(Planar::IDENTITY, db.frame(0));
    let target = Vec2::new(3.0, 4.0);
    let (mut searches, mut nearest) = (0, f32::INFINITY);
    for _ in 0..600 {
        if c.wants_search(&db, false) {
            let local = c.root.inverse_transform_point(target);
            let goal = MatchGoal { place: local, look: local, speed_mps: db.speed_quantile(0.9), hit: None };
            c.search(&db, &boxes, &goal);
            searches += 1;
        }
        let (before, frame) = (c.root, c.frame);
        assert!(db.goes_on(frame), "a search leaves something to play");
        c.advance(&db);
        assert_eq!(c.frame, frame + 1);
        assert!(before.translation().distance(c.root.translation()) < 0.15);
        nearest = nearest.min(c.root.translation().distance(Vec3::new(target.x, 0.0, target.y)));
    }
    assert!((600 / SEARCH_FRAMES..300).contains(&searches), "{searches}");
    assert!(nearest < 1.0, "{nearest}");
}

#[test]
fn figures_are_of_the_same_bundle_and_targets() {
    let config =
        MatchingConfig { characters: 24, queries: 50, batch: 100, seconds: 0.001, ..MatchingConfig::default() };
    let tables = common::tables();
    let figures = measure::matching(&tables, &config).expect("the bundle approaches");
    assert!(figures.policy_reached_fraction > 0.5 && figures.matching_reached_fraction > 0.3, "{figures:?}");
    assert!(figures.query_ns > figures.lookahead_ns && figures.policy_hits_per_minute.is_none(), "{figures:?}");
    let again = measure::matching(&tables, &config).expect("the bundle approaches");
    assert_eq!(again.policy_time_to_reach_s, figures.policy_time_to_reach_s);
    assert_eq!(again.matching_time_to_reach_s, figures.matching_time_to_reach_s);
    let none = MatchingConfig { characters: 0, ..config };
    assert!(measure::matching(&tables, &none).is_err());
}

#[test]
fn the_time_of_a_figure_has_a_range() {
    let tables = common::tables();
    for seconds in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        let config = MatchingConfig { seconds, ..MatchingConfig::default() };
        let e = measure::matching(&tables, &config).unwrap_err().to_string();
        assert!(e.contains("seconds") && e.contains("0.0001 to 3600 s"), "{seconds}: {e}");
    }
}
