//! What happens in scenes.

use super::{own, scene};
use glam::Vec2;
use throng_precompute::route::Solid;
use throng_precompute::scene::crowd::{CrowdRun, Live, run};

fn seconds(s: f64) -> CrowdRun {
    CrowdRun { seconds: Some(s), ..CrowdRun::default() }
}

/// One who walks alone through a house of walls, polygons and columns keeps clear of all of them, and gets where it wants.
#[test]
fn ways_around_walls_are_walked_without_touching_them() {
    let text = "[[groups]]\ncount = 4\nplace = { block = { from = [-9.0, -4.0], to = [-7.0, 4.0] } }\n\
        goal = { area = { from = [7.0, -4.0], to = [9.0, 4.0] } }\n\n\
        [[obstacles]]\nwall = { points = [[-5.0, -9.0], [-5.0, 3.0]] }\n\n\
        [[obstacles]]\nwall = { points = [[-2.0, 9.0], [-2.0, -3.0]], radius_m = 0.1 }\n\n\
        [[obstacles]]\npolygon = { corners = [[0.0, -1.0], [3.0, -9.0], [3.0, 4.0]] }\n\n\
        [[obstacles]]\ndisc = { centre = [5.0, 5.0], radius_m = 1.0 }\n\n\
        [[obstacles]]\nwall = { points = [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0], [-10.0, -10.0]] }\n";
    let wall = |from: [f32; 2], to: [f32; 2], radius| Solid::Wall { from: from.into(), to: to.into(), radius };
    let solids = [
        wall([-5.0, -9.0], [-5.0, 3.0], 0.0),
        wall([-2.0, 9.0], [-2.0, -3.0], 0.1),
        Solid::Polygon([[0.0, -1.0], [3.0, -9.0], [3.0, 4.0]].map(Vec2::from).to_vec()),
        wall([5.0, 5.0], [5.0, 5.0], 1.0),
    ];
    let mut live = Live::<Vec2>::new(&scene(text)).expect("a crowd");
    let mut nearest = f32::INFINITY;
    for step in 0..=1800 {
        let t = f64::from(step) / 30.0;
        live.advance(t).expect("it goes on");
        for m in 0..4 {
            let at = live.position(m, t).expect("it is there");
            nearest = solids.iter().map(|s| s.distance(at)).fold(nearest, f32::min);
        }
    }
    assert!(nearest > 0.299, "{nearest} m from a wall with a radius of 0.3 m");
    for m in 0..4 {
        let way = &live.layout().ways[m];
        assert!(way.len() > 4, "it has to go around: {way:?}");
        let left = live.position(m, 60.0).expect("it is there").distance(way[way.len() - 1]);
        assert!(left < 0.6, "member {m} is {left} m from its goal");
    }
}

#[test]
fn nobody_overlaps_and_two_runs_end_alike_however_they_are_looked_at() {
    for name in ["corridor", "circle", "flock"] {
        let scene = own(name, 60);
        // A run that is timed apart is compared with one that is looked at thirty times a second.
        let (report, _) = run(&scene, &CrowdRun { timed_apart: true, ..seconds(8.0) }).expect("it runs");
        assert_eq!(report.members, 60);
        assert!(report.max_overlap_m < 1e-3 && report.overlap_over_1mm_fraction == 0.0, "{name}: {report:?}");
        assert!(report.progress_mps > 0.3 * report.desired_mps, "{name}: {report:?}");
        let threads = CrowdRun { threads: 3, ..seconds(8.0) };
        let (again, _) = run(&scene, &threads).expect("it runs");
        assert_eq!(report.state_hash, again.state_hash, "{name}, three threads");
        let other =
            run(&throng_precompute::scene::crowd::CrowdScene { seed: 2, ..scene }, &seconds(8.0)).expect("it runs").0;
        assert!(name == "circle" || other.state_hash != report.state_hash, "{name}: another seed is another run");
    }
}

#[test]
fn people_leave_through_a_gap_and_their_flow_is_measured() {
    let (report, record) = run(&own("bottleneck", 60), &CrowdRun { recorded: true, ..seconds(60.0) }).expect("it runs");
    let flow = report.flow.expect("the scene has a gate");
    assert!(flow.crossed > 30 && flow.flow_per_m_s.is_some_and(|f| f > 0.3 && f < 4.0), "{flow:?}");
    let last = record.moments.last().expect("moments");
    let gone = last.members.iter().filter(|m| m.is_none()).count();
    assert!(gone > 20 && gone <= report.arrived, "{gone} have left, {} are counted", report.arrived);
}

#[test]
fn news_come_to_those_who_are_near_and_spread_from_them() {
    let mut scene = own("square", 80);
    let informed = |scene: &_, s| run(scene, &seconds(s)).expect("it runs").0.informed.expect("there are news");
    let (before, at_once, later) = (informed(&scene, 4.9), informed(&scene, 5.01), informed(&scene, 25.0));
    assert!(before == 0 && at_once > 0 && later > at_once, "{before} {at_once} {later}");
    scene.happenings[0].told_on = false;
    assert_eq!(informed(&scene, 25.0), at_once, "nobody tells");
}

#[test]
fn those_who_stand_give_way_to_an_obstacle_on_its_way() {
    let text = "[[groups]]\ncount = 12\nplace = { block = { from = [-4.0, -4.0], to = [4.0, 4.0] } }\n\
        goal = { stay = {} }\n\n[[obstacles]]\n\
        mover = { radius_m = 0.5, way = [{ time_s = 0.0, at = [-12.0, 0.3] }, { time_s = 24.0, at = [12.0, 0.3] }] }\n";
    let mut live = Live::<Vec2>::new(&scene(text)).expect("a crowd");
    let mut nearest = f32::INFINITY;
    for step in 0..=720 {
        let t = f64::from(step) / 30.0;
        live.advance(t).expect("it goes on");
        let mover = Vec2::new(-12.0 + t as f32, 0.3);
        for m in 0..12 {
            nearest = nearest.min(live.position(m, t).expect("it is there").distance(mover) - 0.8);
        }
    }
    assert!(nearest > -0.02, "hardly touched: {nearest}");
    assert!(nearest < 1.0, "somebody had to give way: {nearest}");
}
