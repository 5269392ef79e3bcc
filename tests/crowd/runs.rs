//! What happens in scenes.

use super::{own, scene};
use glam::Vec2;
use throng_core::Inline;
use throng_precompute::run::{SceneFigures, SceneRunConfig, run, run_agents};
use throng_simulation::AnyCharacterGroup;
use throng_simulation::Scene;
use throng_simulation::agents::SceneAgents;

fn agents(scene: &Scene, seconds: f64, threads: usize) -> SceneFigures {
    run_agents(&scene.open().expect("it names no files"), Some(seconds), threads).expect("it runs")
}

/// Distance of a place from a wall (m).
fn gap(at: Vec2, (from, to, radius): (Vec2, Vec2, f32)) -> f32 {
    let along = to - from;
    let share = ((at - from).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
    at.distance(from + share * along) - radius
}

/// A lone agent reaches its goal in a house of walls, polygons and columns without touching them.
#[test]
fn ways_around_walls_are_walked_without_touching_them() {
    let text = "[[groups]]\nmotion = \"none\"\ncount = 4\nplace = { block = { from = [-9.0, -4.0], to = [-7.0, 4.0] } }\n\
        goal = { area = { from = [7.0, -4.0], to = [9.0, 4.0] } }\n\n\
        [[environment.obstacles]]\nwall = { points = [[-5.0, -9.0], [-5.0, 3.0]] }\n\n\
        [[environment.obstacles]]\nwall = { points = [[-2.0, 9.0], [-2.0, -3.0]], radius_m = 0.1 }\n\n\
        [[environment.obstacles]]\npolygon = { corners = [[0.0, -1.0], [3.0, -9.0], [3.0, 4.0]] }\n\n\
        [[environment.obstacles]]\ndisc = { centre = [5.0, 5.0], radius_m = 1.0 }\n\n\
        [[environment.obstacles]]\nwall = { points = [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0], [-10.0, -10.0]] }\n";
    let wall = |from: [f32; 2], to: [f32; 2], radius: f32| (Vec2::from(from), Vec2::from(to), radius);
    let solids = [
        wall([-5.0, -9.0], [-5.0, 3.0], 0.0),
        wall([-2.0, 9.0], [-2.0, -3.0], 0.1),
        wall([0.0, -1.0], [3.0, -9.0], 0.0),
        wall([3.0, -9.0], [3.0, 4.0], 0.0),
        wall([3.0, 4.0], [0.0, -1.0], 0.0),
        wall([5.0, 5.0], [5.0, 5.0], 1.0),
    ];
    let mut live = SceneAgents::<Vec2>::new(&scene(text)).expect("a crowd");
    let mut nearest = f32::INFINITY;
    for step in 0..=1800 {
        let t = f64::from(step) / 30.0;
        live.advance(t, &Inline, &mut |_| {}).expect("it goes on");
        for m in 0..4 {
            let at = live.position(m, t).expect("it is there");
            nearest = solids.iter().map(|s| gap(at, *s)).fold(nearest, f32::min);
        }
    }
    assert!(nearest > 0.299, "{nearest} m from a wall with a radius of 0.3 m");
    for m in 0..4 {
        let path = &live.layout().paths[m];
        assert!(path.len() > 4, "it has to go around: {path:?}");
        let left = live.position(m, 60.0).expect("it is there").distance(path[path.len() - 1]);
        assert!(left < 0.6, "agent {m} is {left} m from its goal");
    }
}

#[test]
fn nobody_overlaps_and_two_runs_end_alike_however_they_are_looked_at() {
    for name in ["corridor", "circle", "flock"] {
        let scene = own(name, 60);
        // A run that is timed apart is compared with one that is looked at thirty times a second.
        let figures = agents(&scene, 8.0, 1);
        let crowd = figures.crowd.clone().expect("agents");
        assert_eq!(figures.agents, Some(60));
        assert!(crowd.max_overlap_m < 1e-3 && crowd.overlap_over_1mm_fraction == 0.0, "{name}: {crowd:?}");
        assert!(crowd.progress_mps > 0.3 * crowd.desired_mps, "{name}: {crowd:?}");
        assert_eq!(figures.state_hash, agents(&scene, 8.0, 3).state_hash, "{name}, three threads");
        let config = SceneRunConfig { seconds: Some(8.0), ..SceneRunConfig::default() };
        let (_, _, sim) = run(&scene.open().expect("no files"), &config).expect("it runs");
        let hash = match &sim.character_groups()[0] {
            AnyCharacterGroup::Ground(whole) => whole.crowd().hash(),
            AnyCharacterGroup::Air(whole) => whole.crowd().hash(),
            _ => panic!("{name} has agents"),
        };
        assert_eq!(figures.state_hash, Some(format!("{hash:016x}")), "{name}, as a simulation");
        let mut other = scene;
        other.seed = 2;
        assert_ne!(agents(&other, 8.0, 1).state_hash, figures.state_hash, "{name}: another seed is another run");
    }
}

#[test]
fn people_leave_through_a_gap_and_their_flow_is_measured() {
    let config = SceneRunConfig { seconds: Some(60.0), recorded: true, ..SceneRunConfig::default() };
    let (report, record, _) = run(&own("bottleneck", 60).open().expect("no files"), &config).expect("it runs");
    let crowd = report.total.crowd.expect("agents");
    let flow = crowd.flow.expect("the scene has a gate");
    assert!(flow.crossed > 30 && flow.flow_per_m_s.is_some_and(|f| f > 0.3 && f < 4.0), "{flow:?}");
    let agents = record.agents.expect("a record");
    let last = agents.moments.last().expect("moments");
    let gone = last.agents.iter().filter(|m| m.is_none()).count();
    assert!(gone > 20 && gone <= crowd.arrived, "{gone} have left, {} are counted", crowd.arrived);
}

#[test]
fn news_come_to_those_who_are_near_and_spread_from_them() {
    let mut scene = own("square", 80);
    let informed = |scene: &_, s| agents(scene, s, 1).crowd.and_then(|c| c.informed).expect("there are news");
    let (before, at_once, later) = (informed(&scene, 4.9), informed(&scene, 5.01), informed(&scene, 25.0));
    assert!(before == 0 && at_once > 0 && later > at_once, "{before} {at_once} {later}");
    scene.happenings[0].passed_on = false;
    let untold = informed(&scene, 5.01);
    assert!(untold > 0 && untold <= at_once && informed(&scene, 25.0) == untold, "nothing is reported: {untold}");
}

#[test]
fn those_who_stand_give_way_to_an_obstacle_on_its_way() {
    let text = "[[groups]]\nmotion = \"none\"\ncount = 12\nplace = { block = { from = [-4.0, -4.0], to = [4.0, 4.0] } }\n\
        goal = { stay = {} }\n\n[[environment.obstacles]]\n\
        mover = { radius_m = 0.5, path = [{ time_s = 0.0, at = [-12.0, 0.3] }, { time_s = 24.0, at = [12.0, 0.3] }] }\n";
    let mut live = SceneAgents::<Vec2>::new(&scene(text)).expect("a crowd");
    let mut nearest = f32::INFINITY;
    for step in 0..=720 {
        let t = f64::from(step) / 30.0;
        live.advance(t, &Inline, &mut |_| {}).expect("it goes on");
        let mover = Vec2::new(-12.0 + t as f32, 0.3);
        for m in 0..12 {
            nearest = nearest.min(live.position(m, t).expect("it is there").distance(mover) - 0.8);
        }
    }
    assert!(nearest > -0.02, "hardly touched: {nearest}");
    assert!(nearest < 1.0, "an agent had to give way: {nearest}");
}

/// Runners follow the track: from wherever they start, they go by the first subgoal and not over the field to a later one.
#[test]
fn runners_stay_on_the_track_and_pass_its_corners_in_order() {
    let of_bodies = ["bundle", "config", "spaces", "style_by_speed"];
    let lines =
        include_str!("../../data/scenes/race-100.toml").lines().filter(|l| !of_bodies.iter().any(|k| l.starts_with(k)));
    let text = lines.collect::<Vec<_>>().join("\n").replace("motion = \"blend\"", "motion = \"none\"");
    let mut live = SceneAgents::<Vec2>::new(&scene(&text)).expect("runners");
    let corners = [[90.0, 0.0], [116.0, 26.0], [90.0, 52.0]].map(Vec2::from);
    let mut passed = vec![Vec::new(); 100];
    for step in 0..=3600 {
        let t = f64::from(step) / 30.0;
        live.advance(t, &Inline, &mut |_| {}).expect("it goes on");
        for (m, passed) in passed.iter_mut().enumerate() {
            let Some(at) = live.position(m, t) else { continue };
            let next = (0..corners.len()).find(|c| at.distance(corners[*c]) < 8.0);
            passed.extend(next.filter(|c| passed.last() != Some(c)));
            assert!(at.x > -25.0, "runner {m} leaves the track by its end: {at} at {t} s");
        }
    }
    let in_order = passed.iter().filter(|p| [0, 1, 2].starts_with(p)).count();
    let finished = passed.iter().filter(|p| **p == [0, 1, 2]).count();
    assert!(in_order == 100 && finished >= 90, "{finished} pass all corners, {in_order} in order: {passed:?}");
}
