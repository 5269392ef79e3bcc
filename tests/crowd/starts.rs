//! What cannot be is told with the agents, the goal or the obstacle that it is about, and the way out.

use super::scene;
use throng_precompute::run::{SceneRunConfig, run};
use throng_simulation::Simulation;

/// The message of a scene that cannot be run.
fn refused(text: &str) -> String {
    Simulation::new(&scene(text)).map(|_| ()).expect_err("it cannot be run").to_string()
}

fn group(count: usize, place: &str, goal: &str) -> String {
    format!("[[groups]]\nname = \"guests\"\nmotion = \"none\"\ncount = {count}\nplace = {place}\ngoal = {goal}\n")
}

const PLACE: &str = "{ block = { from = [-6.0, -2.0], to = [-2.0, 2.0] } }";

#[test]
fn agents_without_room_are_named() {
    let tight = group(30, "{ block = { from = [0.0, 0.0], to = [2.0, 2.0] } }", "{ shift = { by = [9.0, 0.0] } }");
    let message = refused(&tight);
    for part in ["made-up", "of \"guests\"", "overlap by", "`place`"] {
        assert!(message.contains(part), "{message}");
    }
    let middle = group(1, &PLACE.replace("to =", "jitter = 0.0, to ="), "{ stay = {} }");
    let two = middle.clone() + &middle.replace("guests", "hosts");
    let message = refused(&two);
    assert!(message.contains("agent 0 of \"guests\"") && message.contains("agent 1 of \"hosts\""), "{message}");
}

#[test]
fn goals_in_obstacles_are_named_with_both_keys() {
    let goal = "{ point = { at = [5.0, 0.0] } }";
    let disc = "[[environment.obstacles]]\ndisc = { centre = [0.0, 9.0], radius_m = 1.0 }\n";
    let solid = "[[environment.obstacles]]\nbox = { from = [4.0, -1.0], to = [6.0, 1.0] }\n";
    let polygon = "[[environment.obstacles]]\npolygon = { corners = [[4.0, -1.0], [6.0, -1.0], [5.0, 1.0]] }\n";
    for obstacle in [solid, polygon] {
        let message = refused(&(group(3, PLACE, goal) + disc + obstacle));
        for part in ["the goal [5.00, 0.00]", "of \"guests\"", "`environment.obstacles[1]`"] {
            assert!(message.contains(part), "{message}");
        }
        // Without routes it is the engine that finds it.
        let message = refused(&("agents.routes = false\n".to_owned() + &group(3, PLACE, goal) + disc + obstacle));
        assert!(message.contains("of \"guests\"") && message.contains("`environment.obstacles[1]`"), "{message}");
    }
}

#[test]
fn starts_in_obstacles_and_goals_behind_walls_are_told() {
    let goal = "{ point = { at = [5.0, 0.0] } }";
    let message = refused(
        &(group(3, PLACE, goal) + "[[environment.obstacles]]\ndisc = { centre = [-4.0, 0.0], radius_m = 3.0 }\n"),
    );
    assert!(message.contains("starts in `environment.obstacles[0]`"), "{message}");
    let room = "[[environment.obstacles]]\nwall = { points = [[3.0, -3.0], [8.0, -3.0], [8.0, 3.0], [3.0, 3.0], [3.0, -3.0]] }\n";
    let message = refused(&(group(3, PLACE, goal) + room));
    for part in ["no way leads agent 0 of \"guests\"", "[5.00, 0.00]", "there is no gap", "routes = false"] {
        assert!(message.contains(part), "{message}");
    }
    // A gap of 0.8 m is too narrow with the usual radius of 0.3 m and what ways keep from walls.
    let narrow = room.replace("[3.0, -3.0]] }", "[3.0, 2.0]] }").replace("[[3.0, -3.0]", "[[3.0, 1.2], [3.0, -3.0]");
    let message = refused(&(group(3, PLACE, goal) + &narrow));
    let width = message.split("the widest gap is about ").nth(1).and_then(|m| m.split(' ').next()).expect(&message);
    assert!((width.parse::<f32>().expect("a number") - 0.8).abs() < 0.03, "{message}");
    assert!(message.contains("and 0.90 m are needed"), "{message}");
    let door = room.replace("[3.0, -3.0]] }", "[3.0, -0.6]] }");
    Simulation::new(&scene(&(group(3, PLACE, goal) + &door))).expect("there is a door");
}

#[test]
fn faults_of_the_field_name_its_line_and_key() {
    let field = "[agents.field]\nhorizon_s = 2.0\nperception_m = 0.0\n";
    let message = refused(&(group(3, PLACE, "{ stay = {} }") + field));
    let line = (group(3, PLACE, "{ stay = {} }") + "x").lines().count() + 2;
    let place = format!("made-up.toml:{line}:1: key `agents.field.perception_m`: expected above 0");
    assert!(message.contains(&place) && message.contains("found 0"), "{message} {place}");
}

#[test]
fn times_out_of_range_are_refused() {
    let text = group(3, PLACE, "{ stay = {} }");
    for seconds in [0.0, -1.0, f64::NAN, 1e9] {
        let config = SceneRunConfig { seconds: Some(seconds), ..SceneRunConfig::default() };
        assert!(run(&scene(&text), &config).is_err(), "{seconds}");
    }
}
