//! Each kind of expectation holds in a good run, and is seen to break in one that was spoilt on purpose.

use super::super::agent_brain::ActionPhase;
use super::super::expectations::{AgentsView, ExpectationMeters};
use super::super::tables::NONE;
use super::super::{ExpectationOutcome, Scenario};
use super::{Paper, brains};
use crate::scene::Scene;
use crate::{ExpectationWatch, Simulation};
use std::path::Path;
use std::sync::Arc;

/// Eight people who walk 20 m to the right.
const WALKERS: &str = "seconds = 20.0\n[[groups]]\nname = \"walkers\"\nmotion = \"none\"\ncount = 8\n\
    place = { block = { from = [0.0, 0.0], to = [6.0, 4.0] } }\ngoal = { shift = { by = [20.0, 0.0] } }\n";

/// The outcome of one expectation of a scene.
fn outcome(scene: &str, that: &str) -> ExpectationOutcome {
    let text = format!("{scene}\n[[expect]]\nname = \"it\"\n{that}\n");
    let compiled = Scene::parse(&text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"));
    let mut sim = Simulation::new(&compiled).unwrap();
    let mut watch = ExpectationWatch::new(&compiled).unwrap();
    watch.observe(&sim);
    while sim.time_s() < compiled.scene().seconds {
        sim.step(1.0 / 30.0).unwrap();
        watch.observe(&sim);
    }
    watch.finish(&sim, |group, key| (key == "deep" && group.is_none()).then_some(0.5)).unwrap().remove(0)
}

/// Holds in a good scene, and breaks in a spoilt one.
fn breaks(good: &str, spoilt: &str, that: &str) -> ExpectationOutcome {
    let [good, spoilt] = [good, spoilt].map(|scene| outcome(scene, that));
    assert!(good.holds && good.values > 0 && good.worst.is_empty(), "{that}: {good:?}");
    assert!(!spoilt.holds, "{that}: {spoilt:?}");
    spoilt
}

#[test]
fn who_goes_where_nobody_may_is_named_with_time_and_cause() {
    let spoilt = WALKERS.replace("20.0, 0.0] } }", "20.0, 9.0] } }");
    for that in ["that.never = \"me.z > 5\"", "that.always = \"me.z <= 5\""] {
        let broken = breaks(WALKERS, &spoilt, that);
        assert!(broken.worst.len() == 3 && broken.worst[0].at[1] > 5.0, "{:?}", broken.worst);
        assert!(broken.worst[0].why.contains("of walkers at"), "{:?}", broken.worst);
    }
}

#[test]
fn checkpoints_are_passed_by_all_in_order_and_in_time() {
    let spoilt = WALKERS.replace("20.0, 0.0] } }", "-20.0, 0.0] } }");
    let that = "that.passes = [\"me.x > 8\", \"me.x > 18\"]";
    let broken = breaks(WALKERS, &spoilt, that);
    assert_eq!((broken.figure, broken.worst.len()), (0.0, 3));
    let times = format!("{that}\ntake = \"median\"\nleast = 6.0\nmost = 9.0");
    breaks(WALKERS, &WALKERS.replace("goal =", "speed_mps = [2.5, 2.6]\ngoal ="), &times);
    let early = format!("{that}\nbetween_s = [0.0, 12.0]\nleast = 0.1");
    breaks(WALKERS, &WALKERS.replace("goal =", "speed_mps = [0.4, 0.5]\ngoal ="), &early);
    // Into a region and out again: who begins outside has not been out too early.
    assert!(outcome(WALKERS, "that.passes = [\"me.x > 8\", \"me.x > 12 or me.x < 8\"]").holds);
    // The other way round, the first is passed last.
    let turned = outcome(WALKERS, "that.passes = [\"me.x > 18\", \"me.x > 8\"]");
    assert!(!turned.holds && turned.figure == 0.0, "{turned:?}");
}

#[test]
fn durations_and_amounts_have_bounds() {
    let short = WALKERS.replace("20.0, 0.0] } }", "2.0, 0.0] } }");
    breaks(WALKERS, &short, "that.lasts = \"me.speed > 0.5\"\ntake = \"median\"\nleast = 8.0");
    breaks(WALKERS, &short, "that.amount = \"me.x\"\ntake = \"max\"\nleast = 20.0");
    let left = WALKERS.replace("goal =", "at_end = \"leave\"\ngoal =");
    breaks(WALKERS, &left, "that.amount = \"count('walkers')\"\ntake = \"min\"\nleast = 8");
    let none = outcome(WALKERS, "that.lasts = \"me.speed > 50\"\nmost = 1.0");
    assert!(!none.holds && none.values == 0, "what nothing was measured for is broken");
}

#[test]
fn figures_are_those_of_the_report() {
    assert!(outcome(WALKERS, "that.figure = \"deep\"\nmost = 0.6").holds);
    assert!(!outcome(WALKERS, "that.figure = \"deep\"\nmost = 0.4").holds);
}

#[test]
fn news_that_come_at_once_are_no_wave() {
    let line = "seconds = 40.0\nagents.meeting_m = 3.0\n[[groups]]\nname = \"row\"\nmotion = \"none\"\ncount = 20\n\
        place = { block = { from = [0.0, 0.0], to = [40.0, 1.0], jitter = 0.0 } }\ngoal = { stay = {} }\n\
        [[events]]\nname = \"fire\"\nat_s = 1.0\nwho = \"me.x < 2\"\npassed_on = true\n";
    let spoilt = line.replace("meeting_m = 3.0", "meeting_m = 3.0\nagents.telling_s = 0.0");
    let that = "that.news = \"fire\"\nleast = 0.5\nmost = 3.0";
    breaks(line, &spoilt, that);
    // A wall with nobody round it keeps news back, as a closed door does.
    let walled = format!("{line}[[environment.obstacles]]\nwall = {{ points = [[20.0, -40.0], [20.0, 40.0]] }}\n");
    let reached = "that.passes = [\"'fire' in me.news\"]";
    breaks(line, &walled, reached);
}

#[test]
fn greetings_of_one_are_monologues() {
    let both = "seconds = 12.0\nagents.meeting_m = 2.2\n[values.far]\n[[groups]]\nname = \"a\"\nmotion = \"none\"\ncount = 4\n\
        place = { block = { from = [0.0, 0.0], to = [0.8, 30.0], jitter = 0.0 } }\ngoal = { shift = { by = [20.0, 0.0] } }\n\
        [[groups]]\nname = \"b\"\nmotion = \"none\"\ncount = 4\n\
        place = { block = { from = [14.0, 0.4], to = [14.8, 30.4], jitter = 0.0 } }\ngoal = { shift = { by = [-20.0, 0.0] } }\n\
        [[rules]]\nname = \"greet\"\non = \"meets\"\nwhen = \"not other.busy and me.group != other.group\"\n\
        pause_s = 30\nboth = true\ndo = [{ greet = \"other\", for_s = 2.5 }]\n";
    let broken = breaks(both, &both.replace("both = true\n", ""), "that.mutual = \"greet\"\nleast = 0.9");
    assert!(broken.worst[0].why.contains("by rule \"greet\""), "{:?}", broken.worst);
}

#[test]
fn overtaking_in_a_line_is_seen() {
    let story = "[[places]]\nname = \"line\"\nat = [0.0, 0.0]\nqueue = { points = [[0.0, 0.0], [0.0, 5.0]], spacing_m = 1.0 }\n\
        [[rules]]\non = \"starts\"\ndo = [{ stay = 100 }]\n[[expect]]\nname = \"in order\"\nthat.queue = \"line\"\n";
    let scene = super::scene(3, story);
    let scenario = Arc::new(Scenario::new(&scene, &Default::default()).unwrap().unwrap());
    let (mut brains, mut stage) = (brains(&scene), Paper::new(3));
    brains.begin_scene(&mut stage, &[1.3; 3]).unwrap();
    // Since when each agent stands in line, and when it is let in (s).
    let mut share = |waits: [[f64; 2]; 3]| {
        let mut meters = ExpectationMeters::new(&scenario, &scene.expect);
        let facing = |_: u32| None;
        for step in 0..=100 {
            let now = f64::from(step) * 0.1;
            for (a, [since, until]) in waits.into_iter().enumerate() {
                let stands = (since..until).contains(&now);
                // All that are let in have come to the head.
                brains.brains[a].slot = if stands { if until - now < 0.35 { 0 } else { a as u32 + 1 } } else { NONE };
                brains.brains[a].phase = if stands { ActionPhase::Waiting } else { ActionPhase::Idle };
            }
            let view = AgentsView { brains: Some(&brains), stage: &stage, first: 0, facing: &facing, now };
            meters.observe(view, step == 100);
        }
        meters.finish(|_, _| None).unwrap().remove(0)
    };
    let good = share([[1.0, 3.0], [2.5, 5.0], [4.0, 7.0]]);
    assert!(good.holds && good.values == 3, "{good:?}");
    let overtaken = share([[1.0, 6.0], [2.5, 5.0], [4.0, 7.0]]);
    assert!(!overtaken.holds && (overtaken.figure - 2.0 / 3.0).abs() < 1e-6, "{overtaken:?}");
    assert_eq!(overtaken.worst[0].agent, 1, "it was let in before another one");
    let forgotten = share([[1.0, 99.0], [2.5, 5.0], [4.0, 7.0]]);
    assert!((forgotten.figure - 1.0 / 3.0).abs() < 1e-6, "{forgotten:?}");
}

#[test]
fn waits_are_those_of_the_groups_and_priority_overtakes() {
    let people = |name: &str, x: f32| {
        format!(
            "[[groups]]\nname = \"{name}\"\nmotion = \"none\"\ncount = 3\ngraph = \"life\"\n\
            place = {{ block = {{ from = [{x:?}, 0.0], to = [{:?}, 1.0] }} }}\n",
            x + 3.0
        )
    };
    let scene = format!(
        "seconds = 120.0\n{}{}[[places]]\nname = \"line\"\nat = [0.0, 0.0]\n\
        queue = {{ points = [[0.0, 0.0], [9.0, 0.0]], spacing_m = 1.0 }}\n[[places]]\nname = \"desk\"\nat = [0.0, 0.0]\n\
        slots = [{{ at = [-2.0, 0.0] }}]\n[[services]]\nname = \"s\"\ntills = \"desk\"\nlines = [\"line\"]\n\
        time_s = {{ fixed = 14.0 }}\npriority = \"if(me.group == 'last', 1, 0)\"\n[graphs.life]\nlevel = \"social\"\n\
        start = \"a\"\nedges = [{{ from = \"a\", to = \"b\" }}]\n[graphs.life.states]\na = {{ do = [{{ be_served = \"s\" }}] }}\n\
        b = {{ do = [{{ go = [-20.0, 9.0] }}, {{ stay = 99 }}] }}\n",
        people("first", 4.0),
        people("last", 12.0)
    );
    let waits =
        |who: &str| outcome(&scene, &format!("that.wait = \"s\"\ntake = \"max\"\nmost = 999.0\nwho = [\"{who}\"]"));
    let (first, last) = (waits("first"), waits("last"));
    assert_eq!((first.values, last.values), (3, 3), "{first:?} {last:?}");
    assert!(last.figure < first.figure, "{first:?} {last:?}");
    let order = outcome(&scene, "that.queue = \"line\"\nleast = 0.9");
    assert!(!order.holds, "those with priority overtake: {order:?}");
    let fair = scene.replace("priority = \"if(me.group == 'last', 1, 0)\"\n", "");
    assert!(outcome(&fair, "that.queue = \"line\"\nleast = 0.9").holds);
}

#[test]
fn who_begins_within_range_meets() {
    let near = |x: f32| {
        let group = |x: f32| {
            format!(
                "[[groups]]\nmotion = \"none\"\ncount = 1\ngoal = {{ stay = {{}} }}\n\
            place = {{ block = {{ from = [{x:?}, 0.0], to = [{:?}, 1.0] }} }}\n",
                x + 1.0
            )
        };
        format!(
            "seconds = 3.0\nagents.meeting_m = 5.0\n[values.met]\nlimits = [0.0, 9.0]\n{}{}[[rules]]\non = \"meets\"\ndo = [{{ add = \"met\", by = 1 }}]\n",
            group(0.0),
            group(x)
        )
    };
    let that = "that.amount = \"me.met\"\nbetween_s = [1.0, 3.0]\ntake = \"min\"\nleast = 1\nmost = 1";
    breaks(&near(2.0), &near(7.0), that);
    let enters = near(2.0).replacen(
        "count = 1\n",
        "count = 2\nsource = { start = 0, rates = [[0.0, 1.0]], \
        place = { block = { from = [3.0, 3.0], to = [6.0, 6.0] } } }\n",
        1,
    );
    let met = outcome(&enters, "that.amount = \"me.met\"\ntake = \"max\"\nleast = 2");
    assert!(met.holds, "{met:?}");
}

#[test]
fn faults_of_expectations_name_their_line() {
    let told = |that: &str| {
        let text = format!("{WALKERS}\n[[expect]]\nname = \"it\"\n{that}\n");
        Scene::parse(&text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_err().to_string()
    };
    for (that, wanted) in [
        ("that.never = \"me.q > 5\"", vec!["a.toml:11:", "`me.q`"]),
        ("that.passes = [\"me.x > 5\",\n\"me.x >\"]", vec!["a.toml:12:"]),
        ("that.news = \"fire\"\nmost = 1.0", vec!["a.toml:11:", "event `fire`"]),
        ("that.amount = \"me.x\"", vec!["`least` or `most`"]),
        ("that.amount = \"me.x\"\nleast = 3.0\nmost = 1.0", vec!["a.toml:13:", "at least 3"]),
        ("that.mutual = \"great\"", vec!["a.toml:11:", "`greet`"]),
        ("that.sometimes = \"me.x > 5\"", vec!["a.toml:11:", "sometimes"]),
        ("that.figure = \"stuck\"\nmost = 1.0\nwho = [\"walker\"]", vec!["a.toml:13:", "walkers"]),
    ] {
        let message = told(that);
        assert!(wanted.iter().all(|w| message.contains(w)), "{that}: {message}");
    }
}

/// People of a graph with one state, which begins again.
fn doing(does: &str, more: &str) -> String {
    format!(
        "seconds = 40.0\n{more}\n[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = 6\ngraph = \"life\"\n\
         place = {{ block = {{ from = [-3.0, -3.0], to = [3.0, 3.0] }} }}\n[graphs.life]\nlevel = \"social\"\nstart = \"it\"\n\
         edges = [{{ from = \"it\", to = \"it\" }}]\n[graphs.life.states]\nit = {{ do = [{does}, {{ stay = 0.2 }}] }}\n"
    )
}

#[test]
fn who_roams_stays_on_this_side_of_walls_and_open_doors() {
    let hall = "[[environment.obstacles]]\nwall = { points = [[-1.0, -5.0], [-5.0, -5.0], [-5.0, 5.0], [5.0, 5.0], [5.0, -5.0], [1.0, -5.0]] }\n\
        [[environment.doors]]\nname = \"gate\"\nfrom = [-1.0, -5.0]\nto = [1.0, -5.0]\nopen = true\n";
    let that = "that.never = \"max(abs(me.x), abs(me.z)) > 5\"";
    let roams = doing("{ roam = [0.0, 0.0], within_m = 12 }", hall);
    breaks(&roams, &doing("{ go = [0.0, -12.0] }", hall), that);
    let walked = outcome(&roams, "that.amount = \"me.speed\"\nleast = 0.5");
    assert!(walked.holds, "{walked:?}");
}

#[test]
fn who_flees_never_runs_past_the_threat_and_stays_in_a_dead_end() {
    let room = "[[places]]\nname = \"door\"\nat = [1.0, 4.0]\nradius_m = 1.0\n\
        [[environment.obstacles]]\nwall = { points = [[0.0, 4.0], [-5.0, 4.0], [-5.0, -4.0], [5.0, -4.0], [5.0, 4.0], [2.0, 4.0]] }\n";
    let flees = doing("{ flee = \"door\", distance_m = 12.0 }", room);
    breaks(&flees, &doing("{ go = [1.0, 9.0] }", room), "that.never = \"me.z > 4\"");
    let corner = outcome(
        &flees,
        "that.amount = \"distance(me, 'door')\"\nbetween_s = [20.0, 40.0]\ntake = \"min\"\nleast = 7.0",
    );
    assert!(corner.holds, "{corner:?}");
    let open = flees
        .replace("[[0.0, 4.0], [-5.0, 4.0]", "[[-4.9, 3.9], [-5.0, 4.0]")
        .replace("[5.0, 4.0], [2.0, 4.0]", "[5.0, 4.0]");
    let away =
        outcome(&open, "that.amount = \"distance(me, 'door')\"\nbetween_s = [20.0, 40.0]\ntake = \"min\"\nleast = 7.0");
    assert!(away.holds, "{away:?}");
}

#[test]
fn families_share_places_with_fewer_slots() {
    let family = |size: usize, slots: &str| {
        format!(
            "seconds = 90.0\n[[groups]]\nname = \"family\"\nmotion = \"none\"\ncount = {size}\ncompanions = [{size}, {size}]\ngraph = \"g\"\n\
             place = {{ block = {{ from = [0.0, 0.0], to = [3.0, 1.0] }} }}\n[[places]]\nname = \"bench\"\nat = [12.0, 0.0]\n\
             slots = [{slots}]\n[graphs.g]\nlevel = \"social\"\nstart = \"go\"\nedges = [{{ from = \"go\", to = \"home\" }}, \
             {{ from = \"go\", to = \"wait\", on = \"full\" }}, {{ from = \"wait\", to = \"go\" }}]\n[graphs.g.states]\n\
             go = {{ do = [{{ visit = \"bench\", for_s = 2 }}] }}\nwait = {{ do = [{{ stay = 2 }}] }}\nhome = {{ do = [{{ leave = [-10.0, 0.0] }}] }}\n"
        )
    };
    let two = "{ at = [12.0, 0.0] }, { at = [13.0, 0.0] }";
    for (size, slots) in [(3, two), (4, "{ at = [12.0, 0.0] }"), (4, two), (2, two)] {
        let home = outcome(&family(size, slots), "that.passes = [\"me.state == 'home'\"]\nleast = 1");
        assert!(home.holds, "{size}: {home:?}");
    }
}

#[test]
fn who_roams_among_boxes_is_not_drawn_to_the_middle() {
    let boxes = "[[places]]\nname = \"middle\"\nat = [0.0, 0.0]\n\
        [[environment.obstacles]]\nbox = { from = [-4.0, 1.6], to = [4.0, 2.2] }\n\
        [[environment.obstacles]]\nbox = { from = [-4.0, -2.2], to = [4.0, -1.6] }\n";
    let scene = doing("{ roam = [0.0, 0.0], within_m = 12 }, { stay = 3 }", boxes)
        .replace("seconds = 40.0", "seconds = 90.0")
        .replace("count = 6", "count = 12")
        .replace("from = [-3.0, -3.0], to = [3.0, 3.0]", "from = [6.0, -6.0], to = [12.0, 6.0]");
    let far = outcome(
        &scene,
        "that.amount = \"distance(me, 'middle')\"\nbetween_s = [30.0, 90.0]\ntake = \"median\"\nleast = 5.0",
    );
    assert!(far.holds, "{far:?}");
}

#[test]
fn who_roams_about_an_obstacle_roams_on_free_ground_around_it() {
    let fountain = "[[places]]\nname = \"middle\"\nat = [0.0, 0.0]\n\
        [[environment.obstacles]]\ndisc = { centre = [0.0, 0.0], radius_m = 1.5 }\n";
    let scene = doing("{ roam = [0.0, 0.0], within_m = 6 }", fountain)
        .replace("seconds = 40.0", "seconds = 90.0")
        .replace("from = [-3.0, -3.0], to = [3.0, 3.0]", "from = [3.0, -3.0], to = [5.0, 3.0]");
    let walked = outcome(&scene, "that.amount = \"me.speed\"\ntake = \"median\"\nleast = 0.5");
    assert!(walked.holds, "{walked:?}");
    let near = outcome(&scene, "that.never = \"distance(me, 'middle') > 7\"");
    assert!(near.holds, "{near:?}");
    let beyond = outcome(&scene, "that.amount = \"min(me.x, 0 - abs(me.z))\"\ntake = \"min\"\nmost = -2.0");
    assert!(beyond.holds, "they go round it: {beyond:?}");
}

#[test]
fn sources_admit_everybody_who_finds_room() {
    let source = "seconds = 20.0\n[[groups]]\nname = \"comers\"\nmotion = \"none\"\ncount = 12\nacceleration_mps2 = [3.0, 6.0]\n\
        place = { block = { from = [0.0, 0.0], to = [20.0, 20.0] } }\ngoal = { stay = {} }\n\
        source = { start = 1, rates = [[0.0, 2.0]] }\n[[rules]]\non = \"starts\"\ndo = [{ stay = 1 }]\n";
    let that = "that.amount = \"count('comers')\"\ntake = \"max\"\nleast = 12";
    breaks(source, &source.replace("[[0.0, 2.0]]", "[[0.0, 0.05]]"), that);
}

#[test]
fn expectations_read_the_time_at_which_they_are_measured() {
    let still = "seconds = 20.0\n[values.v]\nrate_per_s = 1.0\nlimits = [0.0, 100.0]\n[[groups]]\nname = \"them\"\n\
        motion = \"none\"\ncount = 4\nplace = { block = { from = [0.0, 0.0], to = [4.0, 4.0] } }\ngraph = \"g\"\n\
        [graphs.g]\nlevel = \"social\"\nstart = \"a\"\nedges = []\n[graphs.g.states]\na = { do = [{ stay = 1000.0 }] }\n";
    for what in ["time", "me.state_s", "me.v"] {
        let late = outcome(still, &format!("that.never = \"{what} > 15\""));
        assert!(!late.holds && (late.worst[0].time_s - 15.0).abs() < 0.1, "{what}: {late:?}");
        assert!(outcome(still, &format!("that.never = \"{what} > 20.1\"")).holds, "{what}");
    }
}

#[test]
fn who_finds_a_line_full_tries_again_and_does_not_go_on_as_if_served() {
    let scene = "seconds = 90.0\n[values.served]\n[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = 12\n\
        place = { block = { from = [-8.0, -4.0], to = [0.0, 4.0] } }\ngraph = \"g\"\n\
        [[places]]\nname = \"shop\"\nat = [5.0, 0.0]\nslots = [{ at = [6.0, 0.0] }]\n\
        [[places]]\nname = \"line\"\nat = [4.0, 0.0]\nqueue = { points = [[4.0, 0.0], [1.0, 0.0]] }\n\
        [[services]]\nname = \"s\"\ntills = \"shop\"\nlines = [\"line\"]\ntime_s = { fixed = 3 }\n\
        [graphs.g]\nlevel = \"social\"\nstart = \"a\"\n\
        edges = [{ from = \"a\", to = \"a\", on = \"full\" }, { from = \"a\", to = \"b\" }]\n[graphs.g.states]\n\
        a = { do = [{ be_served = \"s\" }, { set = \"served\", to = 1 }] }\nb = { do = [{ leave = [9.0, 9.0] }] }\n";
    let unserved = outcome(scene, "that.never = \"me.state == 'b' and me.served < 0.5\"");
    assert!(unserved.holds, "{unserved:?}");
    let all = outcome(scene, "that.passes = [\"me.served > 0.5\"]");
    assert!(all.holds && all.values == 12, "{all:?}");
}

#[test]
fn conditions_of_time_become_true_while_nobody_stirs() {
    let scene = "seconds = 20.0\n[[groups]]\nname = \"them\"\nmotion = \"none\"\ncount = 2\n\
        place = { block = { from = [0.0, 0.0], to = [4.0, 4.0] } }\ngraph = \"g\"\n\
        [[events]]\nname = \"bell\"\nwhen = \"time > 10\"\n\
        [graphs.g]\nlevel = \"social\"\nstart = \"a\"\nedges = [{ from = \"a\", to = \"b\", on = \"bell\" }]\n\
        [graphs.g.states]\na = { do = [{ stay = 1000.0 }] }\nb = { do = [{ stay = 1000.0 }] }\n";
    let early = outcome(scene, "that.never = \"me.state == 'b' and time < 10\"");
    let late = outcome(scene, "that.never = \"me.state == 'a' and time > 10.5\"");
    assert!(early.holds && late.holds, "{early:?} {late:?}");
}

#[test]
fn partners_of_a_rule_for_both_may_be_of_another_group() {
    let group = |name: &str, x: f32, by: f32| {
        format!(
            "[[groups]]\nname = \"{name}\"\nmotion = \"none\"\ncount = 1\nplace = {{ block = {{ from = [{x:.1}, 0.0], \
             to = [{:.1}, 0.1] }} }}\ngoal = {{ shift = {{ by = [{by:.1}, 0.0] }} }}\n",
            x + 0.1
        )
    };
    let scene = format!(
        "seconds = 20.0\n[values.met]\n{}{}[[rules]]\nname = \"greet\"\non = \"meets\"\nwho = [\"left\"]\nboth = true\n\
         pause_s = 100.0\ndo = [{{ stay = 1.0 }}, {{ set = \"met\", to = 1 }}]\n",
        group("left", -6.0, 12.0),
        group("right", 6.0, -12.0)
    );
    let all = outcome(&scene, "that.passes = [\"me.met > 0.5\"]");
    assert!(all.holds && all.values == 2, "{all:?}");
}

#[test]
fn a_line_that_begins_at_its_till_is_refused() {
    let scene = |x: f32| {
        format!(
            "[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = 2\n\
             place = {{ block = {{ from = [-8.0, -4.0], to = [0.0, 4.0] }} }}\ngraph = \"g\"\n\
             [[places]]\nname = \"shop\"\nat = [5.0, 0.0]\nslots = [{{ at = [5.0, 0.0] }}]\n\
             [[places]]\nname = \"line\"\nat = [{x:.1}, 0.0]\nqueue = {{ points = [[{x:.1}, 0.0], [1.0, 0.0]] }}\n\
             [[services]]\nname = \"s\"\ntills = \"shop\"\nlines = [\"line\"]\ntime_s = {{ fixed = 3 }}\n\
             [graphs.g]\nlevel = \"social\"\nstart = \"a\"\nedges = []\n[graphs.g.states]\na = {{ do = [{{ be_served = \"s\" }}] }}\n"
        )
    };
    let open = |x| Scene::parse(&scene(x), Path::new("a.toml")).and_then(|s| s.open());
    assert!(open(4.2).is_ok());
    let told = open(4.7).unwrap_err().to_string();
    assert!(told.contains("a.toml") && told.contains("bar the till"), "{told}");
}

#[test]
fn a_share_counts_exactly_and_names_those_that_lack_alone() {
    let ten = WALKERS.replace("count = 8", "count = 10");
    let that = "that.passes = [\"me.number > 0\"]\nleast = ";
    assert!(outcome(&ten, &format!("{that}0.9")).holds, "nine of ten are 0.9");
    let broken = outcome(&ten, &format!("{that}0.95"));
    let named: Vec<usize> = broken.worst.iter().map(|w| w.agent).collect();
    assert!(!broken.holds && named == [0], "{broken:?}");
}

#[test]
fn a_state_that_has_ended_is_left_when_the_condition_of_an_edge_comes_true() {
    let scene = WALKERS.replace("goal = { shift = { by = [20.0, 0.0] } }", "graph = \"g\"")
        + "[graphs.g]\nlevel = \"social\"\nstart = \"wait\"\n\
           edges = [{ from = \"wait\", to = \"off\", when = \"time > 8\" }]\n\
           [graphs.g.states]\nwait = { do = [{ stay = 1 }] }\noff = { do = [{ go = [30.0, 2.0], within_m = 3.0 }] }\n";
    assert!(outcome(&scene, "that.passes = [\"me.x > 10\"]").holds);
    assert!(outcome(&scene, "that.never = \"me.x > 8 and time < 9\"").holds);
}

#[test]
fn who_finds_a_place_full_of_others_does_not_go_round_it() {
    for count in ["count = 12", "count = 20"] {
        let scene = WALKERS
            .replace("seconds = 20.0", "seconds = 90.0")
            .replace("count = 8", count)
            .replace("6.0, 4.0", "10.0, 8.0")
            .replace("goal = { shift = { by = [20.0, 0.0] } }", "graph = \"g\"")
            + "[[places]]\nname = \"tree\"\nat = [18.0, 4.0]\nradius_m = 1.0\n[graphs.g]\nlevel = \"social\"\n\
               start = \"c\"\n[graphs.g.states]\nc = { do = [{ go = \"tree\" }, { stay = 1000 }] }\n";
        let rest = outcome(&scene, "that.amount = \"me.speed\"\ntake = \"p90\"\nbetween_s = [60, 90]\nmost = 0.5");
        assert!(rest.holds, "{count}: they go on at {:.2} m/s", rest.figure);
    }
}

#[test]
fn an_edge_that_is_open_is_drawn_once_and_shares_name_those_that_break_them() {
    let scene = WALKERS
        .replace("count = 8", "count = 60")
        .replace("6.0, 4.0", "20.0, 12.0")
        .replace("goal = { shift = { by = [20.0, 0.0] } }", "graph = \"g\"")
        + "[graphs.g]\nlevel = \"social\"\nstart = \"a\"\nedges = [{ from = \"a\", to = \"b\", probability = 0.3 }, \
           { from = \"a\", to = \"c\", when = \"time > 60\" }]\n\
           [graphs.g.states]\na = { do = [{ stay = 1 }] }\nb = { do = [{ stay = 100 }] }\nc = { do = [{ stay = 100 }] }\n";
    let that = "that.passes = [\"me.state == 'b'\"]\n";
    let few = outcome(&scene, &format!("{that}most = 0.5"));
    assert!(few.holds && few.figure > 0.1, "{few:?}");
    let broken = outcome(&scene, &format!("{that}most = 0.01"));
    let is_of_b = |why: &str| why.contains(" b, ");
    assert!(!broken.holds && broken.worst.iter().all(|w| is_of_b(&w.why)), "{:?}", broken.worst);
}
