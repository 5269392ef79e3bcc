//! Courses, sources, parties and followers in runs of small scenes.

use super::{brains, scene};
use crate::scene::Scene;
use crate::{ExpectationWatch, Simulation};
use std::path::Path;

/// Runs a scene; returns it at its end, and whether each expectation holds.
fn run(text: &str) -> (Simulation, Vec<(bool, f64)>) {
    let scene = Scene::parse(text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"));
    let (mut sim, mut watch) = (Simulation::new(&scene).unwrap(), ExpectationWatch::new(&scene));
    while sim.time_s() < scene.scene().seconds {
        sim.step(1.0 / 30.0).unwrap();
        watch.iter_mut().for_each(|w| w.observe(&sim));
    }
    let outcomes = watch.map(|w| w.finish(&sim, |_, _| None).unwrap()).unwrap_or_default();
    let holds = outcomes.iter().map(|o| (o.holds && o.values > 0, o.figure)).collect();
    (sim, holds)
}

fn states(sim: &Simulation) -> Vec<(String, usize)> {
    let mut states = sim.brains().unwrap().num_in_states();
    states.sort();
    states
}

/// Five runners, three rounds of a square of 20 m; at every lap they stop, and every other one rests for a while on the way.
const ROUNDS: &str = "seconds = 260.0\n[[groups]]\nname = \"runners\"\nmotion = \"none\"\ncount = 5\ngraph = \"run\"\n\
    speed_mps = [2.0, 2.4]\nplace = { block = { from = [-9.0, -12.0], to = [-1.0, -8.0] } }\n\
    [graphs.run]\nlevel = \"social\"\nstart = \"go\"\nedges = [{ from = \"go\", to = \"rest\", on = \"timer\" }, \
    { from = \"rest\", to = \"go\" }, { from = \"go\", to = \"home\" }]\n[graphs.run.states]\n\
    go = { do = [{ timer = \"if(me.number / 2 == floor(me.number / 2), 20, 1000)\" }, { follow_route = [[10.0, -10.0], [10.0, 10.0], \
    [-10.0, 10.0], [-10.0, -10.0]], laps = 3, within_m = 4.0 }] }\n\
    rest = { do = [{ go = [0.0, 0.0], within_m = 2.0 }] }\nhome = { do = [{ stay = 1000 }] }\n";

#[test]
fn laps_count_and_are_run_in_order_whatever_comes_in_between() {
    let expect = "[[expect]]\nname = \"laps\"\nthat.passes = [\"me.laps >= 1\", \"me.laps >= 2\", \"me.laps >= 3\"]\n\
        [[expect]]\nname = \"first leg first\"\nthat.passes = [\"me.x > 8 and me.z < 0\", \"me.z > 8\", \"me.x < -8 and me.z > 0\"]\n\
        [[expect]]\nname = \"far\"\nthat.amount = \"me.progress\"\ntake = \"max\"\nleast = 215.0\nmost = 241.0\n";
    let (sim, holds) = run(&format!("{ROUNDS}{expect}"));
    assert!(holds.iter().all(|h| h.0), "{holds:?}");
    assert_eq!(states(&sim), [("home".into(), 5)]);
    // Five rounds take longer than there is.
    let (_, spoilt) = run(&format!("{}{expect}", ROUNDS.replace("laps = 3", "laps = 2")));
    assert!(!spoilt[0].0);
}

#[test]
fn a_round_begins_at_its_first_leg_unless_told_the_nearest() {
    // They start on the way back, near the last leg.
    let start = ROUNDS.replace("[-9.0, -12.0], to = [-1.0, -8.0]", "[-12.0, 1.0], to = [-9.0, 9.0]");
    let start = start.replace("seconds = 260.0", "seconds = 12.0");
    let east = "[[expect]]\nname = \"e\"\nthat.amount = \"me.x\"\nbetween_s = [10.0, 12.0]\nleast = 0.0\n";
    let south = "[[expect]]\nname = \"e\"\nthat.amount = \"me.z\"\nbetween_s = [4.0, 6.0]\nmost = -2.0\n";
    let (_, in_order) = run(&format!("{start}{east}"));
    assert!(in_order[0].0, "{in_order:?}");
    let near = start.replace("laps = 3", "laps = 3, nearest = true");
    let (_, told) = run(&format!("{near}{south}"));
    assert!(told[0].0, "{told:?}");
}

#[test]
fn who_leaves_a_course_is_told() {
    // A wall leads them round, 8 m off the leg; those who stray first do not stand at its end.
    let text = ROUNDS.replace("{ from = \"go\", to = \"home\" }", "{ from = \"go\", to = \"home\", on = \"strays\" }");
    let text = text.replace("20, 1000)", "1000, 1000)");
    let wall = "[[environment.obstacles]]\nwall = { points = [[18.0, 0.0], [2.0, 0.0]] }\n";
    let (sim, _) = run(&format!("{text}{wall}").replace("seconds = 260.0", "seconds = 40.0"));
    assert_eq!(states(&sim), [("home".into(), 5)], "they strayed");
    let (sim, _) = run(&text.replace("seconds = 260.0", "seconds = 40.0"));
    assert_eq!(states(&sim), [("go".into(), 5)], "nothing leads them astray");
}

/// People who come by chance, walk 30 m and leave.
const PASSERS: &str = "seconds = 600.0\n[[groups]]\nname = \"passers\"\nmotion = \"none\"\ncount = 40\ngraph = \"pass\"\n\
    acceleration_mps2 = [1.0, 6.0]\nplace = { block = { from = [0.0, 0.0], to = [2.0, 20.0] } }\n\
    source = { start = 2, rates = [[0.0, 0.6], [120.0, 0.0], [180.0, 0.6]], reuse = true, period_s = 240.0 }\n\
    [graphs.pass]\nlevel = \"social\"\nstart = \"walk\"\nedges = []\n[graphs.pass.states]\nwalk = { do = [{ leave = [30.0, 10.0] }] }\n";

#[test]
fn sources_reuse_who_has_left_and_follow_the_time_of_day() {
    let expect = "[[expect]]\nname = \"later\"\nthat.amount = \"count('passers')\"\nbetween_s = [500.0, 590.0]\nleast = 6.0\n\
        [[expect]]\nname = \"each comes through\"\nthat.passes = [\"me.x < 5\", \"me.x > 20\"]\nleast = 0.9\n";
    let (sim, holds) = run(&format!("{PASSERS}{expect}"));
    assert!(holds.iter().all(|h| h.0), "{holds:?}");
    let source = sim.statistics().sources.remove(0);
    assert!((180..360).contains(&source.entered) && source.refused < 5, "{source:?}");
    let (by_night, _) = run(&PASSERS.replace("seconds = 600.0", "seconds = 178.0"));
    assert!(by_night.statistics().sources[0].present <= 1, "nobody comes by night");
    let (_, once) = run(&format!("{}{expect}", PASSERS.replace("reuse = true, ", "")));
    assert!(!once[0].0, "forty come once: {once:?}");
}

#[test]
fn a_source_without_room_says_so() {
    let walls = "[[environment.obstacles]]\nbox = { from = [-1.0, -1.0], to = [3.0, 21.0] }\n";
    let text = PASSERS
        .replace("start = 2, ", "")
        .replace("reuse = true", "place = { block = { from = [0.0, 0.0], to = [2.0, 20.0] } }");
    let scene = Scene::parse(&format!("{text}{walls}"), Path::new("a.toml")).and_then(|s| s.open()).unwrap();
    let told = Simulation::new(&scene).unwrap_err().to_string();
    assert!(told.contains("groups[0]"), "{told}");
}

#[test]
fn who_follows_somebody_who_stands_arrives_and_stands() {
    let text = "seconds = 30.0\n[[groups]]\nname = \"guide\"\nmotion = \"none\"\ncount = 1\ngoal = { stay = {} }\n\
        place = { block = { from = [0.0, 0.0], to = [1.0, 1.0] } }\n[[groups]]\nname = \"guests\"\nmotion = \"none\"\ncount = 6\n\
        goal = { stay = {} }\nplace = { block = { from = [-6.0, -8.0], to = [6.0, -4.0] } }\n\
        [[rules]]\non = \"starts\"\nwho = [\"guests\"]\ndo = [{ follow = [0.5, 0.5], for_s = 1000, within_m = 2.5 }]\n\
        [[expect]]\nname = \"come\"\nthat.passes = [\"sqrt((me.x - 0.5) * (me.x - 0.5) + (me.z - 0.5) * (me.z - 0.5)) < 3.3\"]\nwho = [\"guests\"]\n\
        [[expect]]\nname = \"stand\"\nthat.amount = \"me.speed\"\nwho = [\"guests\"]\nbetween_s = [15.0, 30.0]\nmost = 0.03\n";
    let (_, holds) = run(text);
    assert!(holds.iter().all(|h| h.0), "{holds:?}");
}

/// Families of three who choose one of two places again and again.
const FAMILIES: &str = "seconds = 90.0\n[[groups]]\nname = \"families\"\nmotion = \"none\"\ncount = 30\ncompanions = [3, 3]\ngraph = \"day\"\n\
    place = { block = { from = [-12.0, -8.0], to = [12.0, 8.0], jitter = 0.2 } }\n[graphs.day]\nlevel = \"social\"\nstart = \"rest\"\n\
    edges = [{ from = \"rest\", to = \"east\" }, { from = \"rest\", to = \"west\" }, { from = \"east\", to = \"rest\" }, \
    { from = \"west\", to = \"rest\" }]\n[graphs.day.states]\nrest = { do = [{ stay = \"1 + 3 * random\" }] }\n\
    east = { do = [{ go = [25.0, 0.0], within_m = 6.0 }] }\nwest = { do = [{ go = [-25.0, 0.0], within_m = 6.0 }] }\n";

#[test]
fn a_family_decides_once_and_splits_only_where_told() {
    let apart = |text: &str| {
        let scene = Scene::parse(text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"));
        let mut sim = Simulation::new(&scene).unwrap();
        let (mut differ, mut changes, mut last) = (0, 0, Vec::new());
        while sim.time_s() < 90.0 {
            sim.step(1.0 / 30.0).unwrap();
            let brains = sim.brains().unwrap();
            let states: Vec<&str> = (0..30).map(|a| brains.states_of(a)[0].unwrap().state).collect();
            differ += states.chunks(3).filter(|family| family.iter().any(|s| *s != family[0])).count();
            let states: Vec<String> = states.into_iter().map(String::from).collect();
            changes += usize::from(states != last);
            last = states;
        }
        assert!(changes > 20, "they choose: {changes}");
        differ
    };
    assert_eq!(apart(FAMILIES), 0);
    assert!(
        apart(&FAMILIES.replace(" }, {", ", alone = true }, {").replace("\"rest\" }]", "\"rest\", alone = true }]"))
            > 100
    );
}

/// A couple at a table with two glasses, who look for the second one where the first is taken.
const COUPLE: &str = "seconds = 40.0\n[[groups]]\nname = \"couple\"\nmotion = \"none\"\ncount = 2\ncompanions = [2, 2]\nradius_m = [0.2, 0.22]\n\
    place = { block = { from = [-1.0, 0.0], to = [1.0, 0.6] } }\ngraph = \"g\"\n[[environment.obstacles]]\n\
    polygon = { corners = [[-1.5, 4.0], [1.5, 4.0], [1.5, 4.5], [-1.5, 4.5]] }\nheight_m = 0.85\n\
    [[things]]\nname = \"glass 1\"\nat = [-0.6, 0.9, 4.07]\n[[things]]\nname = \"glass 2\"\nat = [0.6, 0.9, 4.07]\n\
    [graphs.g]\nlevel = \"social\"\nstart = \"choose\"\nedges = [{ from = \"choose\", to = \"first\", when = \"not taken('glass 1')\" }, \
    { from = \"choose\", to = \"second\", when = \"taken('glass 1') and not taken('glass 2')\" }, \
    { from = \"first\", to = \"choose\", on = \"full\" }, { from = \"second\", to = \"choose\", on = \"full\" }, \
    { from = \"first\", to = \"drink\" }, { from = \"second\", to = \"drink\" }]\n[graphs.g.states]\n\
    choose = { do = [{ stay = 0.5 }] }\nfirst = { do = [{ take = \"glass 1\" }] }\nsecond = { do = [{ take = \"glass 2\" }] }\n\
    drink = { do = [{ stay = 1000 }] }\n";

#[test]
fn who_has_what_another_one_found_taken_keeps_it() {
    let scene = Scene::parse(COUPLE, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"));
    let mut sim = Simulation::new(&scene).unwrap();
    while sim.time_s() < 40.0 {
        sim.step(1.0 / 30.0).unwrap();
    }
    assert_eq!(sim.handling_counts().taken, 2);
}

#[test]
fn the_first_in_line_faces_on_and_not_those_behind() {
    let facing = |at: &str| {
        let line = format!(
            "[[places]]\nname = \"line\"\nat = {at}\nqueue = {{ points = [[0.0, 0.0], [0.0, 5.0]], spacing_m = 1.0 }}\n\
             [[rules]]\non = \"starts\"\ndo = [{{ stay = 1 }}]\n"
        );
        let slots = &brains(&scene(1, &line)).scenario.slots;
        [slots[0].facing, slots[1].facing].map(|at| (at.x, at.z))
    };
    assert_eq!(facing("[1.0, -3.0]"), [(1.0, -3.0), (0.0, 0.0)], "what the line leads to");
    for behind in ["[0.0, 0.0]", "[0.0, 2.5]"] {
        let [first, second] = facing(behind);
        assert!(first.1 < -0.5 && second == (0.0, 0.0), "{behind}: {first:?} {second:?}");
    }
}
