//! What cannot be is told with the members, the goal or the obstacle that it is about, and the way out.

use super::scene;
use throng_precompute::scene::crowd::{CrowdRun, run};

/// The message of a scene that cannot be run.
fn refused(text: &str) -> String {
    let config = CrowdRun { seconds: Some(0.1), ..CrowdRun::default() };
    run(&scene(text), &config).expect_err("it cannot be run").to_string()
}

fn group(count: usize, place: &str, goal: &str) -> String {
    format!("[[groups]]\nname = \"guests\"\ncount = {count}\nplace = {place}\ngoal = {goal}\n")
}

const PLACE: &str = "{ block = { from = [-6.0, -2.0], to = [-2.0, 2.0] } }";

#[test]
fn members_without_room_are_named() {
    let tight = group(30, "{ block = { from = [0.0, 0.0], to = [2.0, 2.0] } }", "{ shift = { by = [9.0, 0.0] } }");
    let message = refused(&tight);
    for part in ["made-up", "of \"guests\"", "overlap by", "`place`"] {
        assert!(message.contains(part), "{message}");
    }
    let two = group(1, PLACE, "{ stay = {} }") + &group(1, PLACE, "{ stay = {} }").replace("guests", "hosts");
    let message = refused(&two);
    assert!(message.contains("member 0 of \"guests\"") && message.contains("member 1 of \"hosts\""), "{message}");
}

#[test]
fn goals_in_obstacles_are_named_with_both_keys() {
    let goal = "{ point = { at = [5.0, 0.0] } }";
    let disc = "[[obstacles]]\ndisc = { centre = [0.0, 9.0], radius_m = 1.0 }\n";
    let solid = "[[obstacles]]\nbox = { from = [4.0, -1.0], to = [6.0, 1.0] }\n";
    let polygon = "[[obstacles]]\npolygon = { corners = [[4.0, -1.0], [6.0, -1.0], [5.0, 1.0]] }\n";
    for obstacle in [solid, polygon] {
        let message = refused(&(group(3, PLACE, goal) + disc + obstacle));
        for part in ["the goal [5.00, 0.00]", "of \"guests\"", "`obstacles[1]`"] {
            assert!(message.contains(part), "{message}");
        }
        // Without routes it is the engine that finds it.
        let message = refused(&("routes = false\n".to_owned() + &group(3, PLACE, goal) + disc + obstacle));
        assert!(message.contains("of \"guests\"") && message.contains("`obstacles[1]`"), "{message}");
    }
}

#[test]
fn starts_in_obstacles_and_goals_behind_walls_are_told() {
    let goal = "{ point = { at = [5.0, 0.0] } }";
    let message =
        refused(&(group(3, PLACE, goal) + "[[obstacles]]\ndisc = { centre = [-4.0, 0.0], radius_m = 3.0 }\n"));
    assert!(message.contains("starts in `obstacles[0]`"), "{message}");
    let room = "[[obstacles]]\nwall = { points = [[3.0, -3.0], [8.0, -3.0], [8.0, 3.0], [3.0, 3.0], [3.0, -3.0]] }\n";
    let message = refused(&(group(3, PLACE, goal) + room));
    for part in ["no way leads member 0 of \"guests\"", "[5.00, 0.00]", "gap", "routes = false"] {
        assert!(message.contains(part), "{message}");
    }
    let door = room.replace("[3.0, -3.0]] }", "[3.0, -0.6]] }");
    let config = CrowdRun { seconds: Some(0.1), ..CrowdRun::default() };
    run(&scene(&(group(3, PLACE, goal) + &door)), &config).expect("there is a door");
}

#[test]
fn times_out_of_range_are_refused() {
    let text = group(3, PLACE, "{ stay = {} }");
    for seconds in [0.0, -1.0, f64::NAN, 1e9] {
        let config = CrowdRun { seconds: Some(seconds), ..CrowdRun::default() };
        assert!(run(&scene(&text), &config).is_err(), "{seconds}");
    }
}
