//! Scenes that are solved by hand, and scenes that are refused.

use super::super::TurnKind;
use super::super::tables::NONE;
use super::{ActionRegistry, AgentBrains, Scenario, Signal, explained, played, refused};
use crate::scene::{CarryStyle, Scene, ThingConfig};
use glam::Vec3;
use std::path::Path;

const WAIT: &str =
    "[graphs.life]\nlevel = \"social\"\nstart = \"a\"\n[graphs.life.states]\na = { do = [{ stay = 1000 }] }\n";

#[test]
fn two_tell_a_third_who_learns_it_from_the_first_it_meets() {
    let story = format!("{WAIT}[[events]]\nname = \"fire\"\nat_s = 1.0\nwho = \"me.number < 2\"\npassed_on = true\n");
    let script =
        [(0.5, Signal::Met(0, 2)), (2.0, Signal::Met(1, 2)), (3.0, Signal::Met(0, 2)), (4.0, Signal::Met(2, 3))];
    let (brains, _) = played(4, &story, &script, 5.0);
    let known = |agent: usize| explained(&brains, agent).knows.first().map(|k| (k.how.clone(), k.from, k.time_s));
    assert_eq!(known(0), Some(("happens".into(), None, 1.0)));
    assert_eq!(known(2), Some(("passed_on".into(), Some(1), 2.0)), "at 0.5 s nobody knew, at 3 s it was no news");
    assert_eq!(known(3), Some(("passed_on".into(), Some(2), 4.0)));
    let tree = brains.event_learners("fire").unwrap();
    assert_eq!(tree.iter().map(|(agent, _)| *agent).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert!(brains.event_learners("flood").unwrap_err().to_string().contains("fire"));
}

#[test]
fn old_news_are_told_no_more() {
    let story = format!(
        "{WAIT}[[events]]\nname = \"sale\"\nat_s = 1.0\nwho = \"me.number == 0\"\npassed_on = true\nfresh_s = 2.0\n"
    );
    let (brains, _) = played(3, &story, &[(2.9, Signal::Met(0, 1)), (3.1, Signal::Met(0, 2))], 5.0);
    assert_eq!([0, 1, 2].map(|a| brains.num_known(a)), [1, 1, 0]);
}

#[test]
fn a_threshold_is_reached_between_events_at_the_time_that_is_solved_for() {
    // 0.2 + 0.1 t = 0.7 after 5 s; 1 - 0.8 exp(-t ln 2 / 3) = 0.9 after 3 log2(8) = 9 s.
    let story = "[values.linear]\nstart = [0.2, 0.2]\nrate_per_s = 0.1\n[values.curved]\nstart = [0.2, 0.2]\nrest = 1.0\n\
        half_life_s = 3.0\n[graphs.life]\nlevel = \"social\"\nstart = \"a\"\nedges = [\n\
        { from = \"a\", to = \"b\", on = \"linear > 0.7\" }, { from = \"b\", to = \"c\", on = \"curved > 0.9\" } ]\n\
        [graphs.life.states]\na = { do = [{ stay = 1000 }] }\nb = { do = [{ stay = 1000 }] }\nc = { do = [{ stay = 1000 }] }\n";
    for (until, state, since) in [(4.99, "a", 0.0), (5.01, "b", 5.0), (8.99, "b", 5.0), (9.01, "c", 9.0)] {
        let (brains, _) = played(1, story, &[], until);
        let why = explained(&brains, 0);
        assert_eq!(why.states, [state]);
        assert!((why.because.time_s - since).abs() < 1e-5, "{why:?}");
    }
}

#[test]
fn what_is_done_at_once_is_no_reason_and_values_are_those_of_the_time() {
    let story = "[values.hunger]\nstart = [0.0, 0.0]\nrate_per_s = 0.05\n[values.count]\nlimits = [0.0, 9.0]\n\
        [[rules]]\nname = \"runs\"\non = \"alarm\"\ndo = [{ stay = 100 }]\n\
        [[rules]]\nname = \"counts\"\non = \"bell\"\ndo = [{ add = \"count\", by = 1.0 }]\n\
        [[events]]\nname = \"alarm\"\nat_s = 2.0\n[[events]]\nname = \"bell\"\nat_s = 4.0\n";
    let (brains, _) = played(1, story, &[], 6.0);
    let why = brains.explain(0, 19.0);
    assert_eq!((why.because.rule.as_deref(), why.because.time_s), (Some("runs"), 2.0), "{why:?}");
    let value = |name: &str| why.values.iter().find(|v| v.name == name).unwrap().value;
    assert!(value("count") == 1.0 && (value("hunger") - 0.95).abs() < 1e-6 && why.time_s == 19.0, "{why:?}");
}

#[test]
fn a_threshold_is_passed_again_only_after_it_was_left() {
    let story = "[values.anger]\nstart = [0.0, 0.0]\n[values.count]\nstart = [0.0, 0.0]\nlimits = [0.0, 100.0]\n\
        [[rules]]\non = \"anger > 0.5\"\ndo = [{ add = \"count\", by = 1.0 }]\n\
        [[rules]]\non = \"up\"\ndo = [{ add = \"anger\", by = 0.3 }]\n[[rules]]\non = \"down\"\ndo = [{ set = \"anger\", to = 0.4 }]\n\
        [[events]]\nname = \"up\"\nperiod_s = 1.0\n[[events]]\nname = \"down\"\nat_s = 4.5\n";
    // 0.3 0.6 0.9 1.0 | 0.4 0.7 1.0: twice above 0.5.
    let (brains, _) = played(1, story, &[], 6.9);
    let value = |name: &str| explained(&brains, 0).values.iter().find(|v| v.name == name).unwrap().value;
    assert_eq!((value("count"), value("anger")), (2.0, 1.0));
}

#[test]
fn a_change_above_begins_below_anew_and_an_edge_to_itself_changes_nothing() {
    let story = "[graphs.life]\nlevel = \"social\"\nstart = \"work\"\nedges = [ { from = \"work\", to = \"rest\", on = \"bell\" }, \
        { from = \"rest\", to = \"work\", on = \"bell\" }, { from = \"work\", to = \"work\", on = \"meets\" } ]\n\
        [graphs.life.states]\nwork = { graph = \"tasks\" }\nrest = { do = [{ stay = 1000 }] }\n\
        [graphs.tasks]\nlevel = \"spatial\"\nstart = \"first\"\nedges = [{ from = \"first\", to = \"second\" }]\n\
        [graphs.tasks.states]\nfirst = { do = [{ stay = 2 }] }\nsecond = { do = [{ stay = 1000 }] }\n\
        [[events]]\nname = \"bell\"\nperiod_s = 5.0\n";
    let states = |until: f64, script: &[(f64, Signal)]| explained(&played(2, story, script, until).0, 0).states;
    assert_eq!(states(1.9, &[]), ["work", "first"]);
    assert_eq!(states(2.1, &[]), ["work", "second"]);
    assert_eq!(states(5.1, &[]), ["rest"]);
    assert_eq!(states(11.0, &[]), ["work", "first"], "anew");
    assert_eq!(states(3.0, &[(1.0, Signal::Met(0, 1))]), ["work", "second"], "what is below goes on");
}

#[test]
fn a_rule_interrupts_and_what_it_interrupted_begins_again() {
    let story = "[[rules]]\nname = \"hello\"\non = \"meets\"\ndo = [{ greet = \"other\", for_s = 2.0 }]\npause_s = 10.0\n\
        [graphs.life]\nlevel = \"social\"\nstart = \"a\"\n[graphs.life.states]\na = { do = [{ go = [50.0, 0.0] }, { stay = 1000 }] }\n";
    let (brains, stage) = played(2, story, &[(1.0, Signal::Met(0, 1)), (2.0, Signal::Met(0, 1))], 8.0);
    let own: Vec<&str> = stage.log.iter().filter(|l| l.split(' ').nth(1) == Some("0")).map(|l| l.as_str()).collect();
    let walks: Vec<&&str> = own.iter().filter(|l| l.contains(" go ") || l.contains("halt")).collect();
    assert!(walks[0].starts_with("0.000000 0 go 50") && walks[1].starts_with("1.000000 0 halt"), "{own:#?}");
    assert!(
        walks[2].starts_with("3.000000 0 go 50"),
        "after two seconds, and not interrupted within the pause: {own:#?}"
    );
    assert!(!explained(&brains, 0).interrupted);
}

#[test]
fn what_ends_a_behaviour_is_forgotten_once_another_one_has_begun() {
    // Both orders of the second agent find the till full, and the list is over at once: the first `full` counts.
    let story = "[[places]]\nname = \"till\"\nat = [1.0, 0.0]\nslots = [{ at = [1.0, 0.0] }]\n[graphs.life]\nlevel = \"social\"\n\
        start = \"a\"\nedges = [{ from = \"a\", to = \"b\", on = \"full\" }, { from = \"b\", to = \"a\" }, { from = \"b\", to = \"c\", \
        on = \"full\" }]\n[graphs.life.states]\na = { do = [{ buy = \"till\", for_s = 99 }, { buy = \"till\", for_s = 99 }] }\n\
        b = { do = [{ stay = 2 }] }\nc = { do = [{ stay = 99 }] }\n";
    for (until, state) in [(1.0, "b"), (1.99, "b"), (5.0, "b")] {
        let (brains, _) = played(2, story, &[], until);
        assert_eq!(explained(&brains, 1).states, [state], "{until}");
    }
}

#[test]
fn those_in_a_queue_move_up_and_nobody_holds_two_slots() {
    let story = "[[places]]\nname = \"line\"\nat = [0.0, 0.0]\nqueue = { points = [[0.0, 0.0], [0.0, 5.0]], spacing_m = 1.0 }\n\
        [[places]]\nname = \"till\"\nat = [1.0, 0.0]\nslots = [{ at = [1.0, 0.0] }]\n\
        [graphs.life]\nlevel = \"social\"\nstart = \"a\"\nedges = [{ from = \"a\", to = \"b\" }, { from = \"a\", to = \"c\", on = \"full\" }]\n\
        [graphs.life.states]\na = { do = [{ queue = \"line\", into = \"till\" }, { buy = \"till\", for_s = 10 }, { release = true }] }\n\
        b = { do = [{ stay = 1000 }] }\nc = { do = [{ stay = 1000 }] }\n";
    // The line has six slots. The first of eight stands at its head and goes on to the till at once; others join where the line ends when
    // they come there, one after the other, and the last finds it full.
    let at = |until: f64| {
        let (brains, _) = played(8, story, &[], until);
        assert_eq!(brains.num_holding_twice(), 0);
        let mut states = brains.num_in_states();
        states.sort();
        (states, brains.holders.iter().filter(|h| **h != super::super::tables::NONE).count())
    };
    assert_eq!(at(1.0), (vec![("a".into(), 8)], 1));
    // A walk takes 1.7 s: one into the line, and one to the slot there.
    assert_eq!(at(3.3), (vec![("a".into(), 8)], 1));
    assert_eq!(at(6.9), (vec![("a".into(), 8)], 4), "one in each 1.7 s");
    // One at the till, six in line; it is done 2 * 1.7 + 10 s after it came.
    assert_eq!(at(13.3), (vec![("a".into(), 7), ("c".into(), 1)], 7));
    assert_eq!(at(13.5), (vec![("a".into(), 6), ("b".into(), 1), ("c".into(), 1)], 6));
}

#[test]
fn boards_are_read_where_they_are_and_not_for_ever() {
    let story = "[agents]\ncell_m = 4.0\n[[rules]]\non = \"starts\"\nwhen = \"me.number == 0\"\n\
        do = [{ post = \"way\", cells = 0, for_s = 10 }]\n[[events]]\nname = \"way\"\n[[places]]\nname = \"post\"\nat = [3.0, 0.0]\n\
        guidepost = true\n[[rules]]\non = \"enters\"\ndo = [{ speed = 1.0 }]\n";
    // Agent 0 is at 0 m and posts in the cell up to 4 m; agent 1 is at 3 m, agent 2 at 6 m.
    let (brains, _) = played(3, story, &[(1.0, Signal::CameTo(1, 0)), (1.0, Signal::Crossed(2))], 2.0);
    assert_eq!([0, 1, 2].map(|a| brains.num_known(a)), [0, 1, 0]);
    let (brains, _) = played(3, story, &[(11.0, Signal::CameTo(1, 0))], 12.0);
    assert_eq!(brains.num_known(1), 0, "it was taken down");
}

#[test]
fn boards_say_who_wrote_what_and_until_when() {
    let story = "[agents]\ncell_m = 4.0\n[[rules]]\non = \"starts\"\nwhen = \"me.number == 2\"\n\
        do = [{ post = \"way\", cells = 1, for_s = 10 }]\n[[events]]\nname = \"way\"\n[[events]]\nname = \"bell\"\nat_s = 1.0\n\
        posted = true\nfresh_s = 5.0\n";
    let (brains, _) = played(3, story, &[], 2.0);
    let posts: Vec<_> = brains.posts().collect();
    assert_eq!((posts[0].event, posts[0].cell, posts[0].by, posts[0].until_s), (1, None, None, 6.0));
    let (cell, by) = (posts[1].cell.expect("a cell"), posts[1].by);
    // Agent 2 is at 6 m; cells of level 1 are 8 m wide.
    assert_eq!((cell.level, cell.middle, cell.side_m, by), (1, [4.0, 4.0], 8.0, Some(2)));
    assert_eq!((posts.len(), posts[1].since_s, posts[1].until_s), (2, 0.0, 10.0));
    let (brains, _) = played(3, story, &[(7.0, Signal::Crossed(0))], 8.0);
    assert_eq!(brains.posts().map(|p| p.event).collect::<Vec<_>>(), [0], "the bell is taken down");
    assert_eq!(brains.blackboard_levels(), Some((4.0, 4)));
}

#[test]
fn those_who_watch_are_told_of_every_turn_in_its_order() {
    let story = format!(
        "{GRAPHS}[[events]]\nname = \"bell\"\nat_s = 1.0\nwho = \"me.number == 1\"\n[[rules]]\nname = \"hear\"\non = \"bell\"\ndo = [{{ timer = 9 }}]\n"
    );
    let mut brains = super::brains(&super::scene(2, &story));
    brains.record_turns();
    let mut stage = super::Paper::new(2);
    super::Lives::begin(&mut brains, &mut stage);
    super::play(&mut brains, &mut stage, &[], 1.5);
    let kinds: Vec<_> = brains.turns().iter().map(|t| (t.time_s, t.agent, t.kind)).collect();
    let takes = TurnKind::Takes { level: 0, graph: 1, edge: 0, changes: true };
    assert_eq!(
        kinds,
        [
            (0.0, 0, TurnKind::Starts),
            (0.0, 1, TurnKind::Starts),
            (1.0, 1, TurnKind::Learns("happens")),
            (1.0, 1, TurnKind::Follows(0)),
            (1.0, 1, takes),
        ]
    );
    assert_eq!((brains.rule_name(0), brains.trigger_name(brains.turns()[2].on)), ("hear", "bell".into()));
    let now = |agent: usize| brains.states_of(agent).map(|s| s.map(|s| (s.graph, s.state)));
    assert_eq!(now(0), [Some(("life", "up")), Some(("below", "x")), None]);
    assert_eq!(now(1), [Some(("life", "down")), None, None]);
    let learnt = brains.learnt_event(1, 0).expect("it knows");
    assert_eq!((learnt.source_agent(), learnt.mode_name(), learnt.time_s), (None, "happens", 1.0));
    brains.clear_turns();
    assert!(brains.turns().is_empty() && brains.learnt_event(0, 0).is_none());
}

/// Two levels; a bell leads down, where there is nothing below.
const GRAPHS: &str = "[graphs.life]\nlevel = \"social\"\nstart = \"up\"\n\
    edges = [{ from = \"up\", to = \"down\", on = \"bell\" }]\n[graphs.life.states]\nup = { graph = \"below\" }\n\
    down = { do = [{ stay = 99 }] }\n[graphs.below]\nlevel = \"spatial\"\nstart = \"x\"\n[graphs.below.states]\n\
    x = { do = [{ stay = 99 }] }\n";

#[test]
fn what_is_felt_weakens_with_the_distance() {
    let story = format!(
        "{WAIT}[values.fear]\nstart = [0.0, 0.0]\n[[events]]\nname = \"scare\"\n[[rules]]\non = \"starts\"\n\
         when = \"me.number == 3\"\ndo = [{{ timer = 1 }}]\n[[rules]]\non = \"timer\"\ndo = [{{ convey = \"scare\", within_m = 6.0 }}]\n\
         [[rules]]\non = \"scare\"\ndo = [{{ set = \"fear\", to = \"event.strength\" }}]\n"
    );
    // Agents stand 3 m apart.
    let (brains, _) = played(6, &story, &[], 2.0);
    let fear = |a: usize| explained(&brains, a).values[0].value;
    assert_eq!((fear(0), fear(1), fear(3)), (0.0, 0.0, 0.0), "6 m off, nothing is left; who scares is not scared");
    assert!((fear(2) - 0.5).abs() < 1e-6 && (fear(4) - 0.5).abs() < 1e-6, "{} {}", fear(2), fear(4));
}

#[test]
fn a_circle_within_one_instant_is_told_with_its_rule() {
    let story = "[values.a]\n[[rules]]\nname = \"up\"\non = \"a > 0.5\"\ndo = [{ set = \"a\", to = 0.0 }]\n\
        [[rules]]\nname = \"down\"\non = \"a < 0.2\"\ndo = [{ set = \"a\", to = 1.0 }]\n[[rules]]\non = \"starts\"\ndo = [{ set = \"a\", to = 1.0 }]\n";
    let mut brains = super::brains(&super::scene(1, story));
    let e = brains.begin_scene(&mut super::Paper::new(1), &[1.3]).unwrap_err().to_string();
    assert!(e.contains("circle") && (e.contains("\"up\"") || e.contains("\"down\"")), "{e}");
}

#[test]
fn conditions_that_follow_each_other_in_a_circle_are_told() {
    let door =
        |name: &str, z: u8| format!("[[environment.doors]]\nname = \"{name}\"\nfrom = [20, {z}]\nto = [21, {z}]\n");
    let event = |name: &str, when: &str, does: &str| {
        format!("[[events]]\nname = \"{name}\"\nnobody = true\nwhen = \"{when}\"\n{does}\n")
    };
    let story = [
        door("d1", 1),
        door("d2", 2),
        event("a", "open('d1') and not open('d2')", "closes = [\"d1\"]"),
        event("b", "open('d1') and open('d2')", "closes = [\"d2\"]"),
        event("c", "not open('d1') and open('d2')", "opens = [\"d1\"]"),
        event("d", "not open('d1') and not open('d2')", "opens = [\"d2\"]"),
        event("e", "time > 9", ""),
    ];
    let mut brains = super::brains(&super::scene(1, &story.concat()));
    let e = brains.begin_scene(&mut super::Paper::new(1), &[1.3]).unwrap_err().to_string();
    assert!(e.contains("circle") && e.contains("`a`, `b`, `c`, `d`:"), "{e}");
}

#[test]
fn who_queues_at_slots_that_are_no_queue_goes_on() {
    let story = "[[places]]\nname = \"stalls\"\nat = [50.0, 0.0]\nslots = [{ at = [50.0, 1.0] }, { at = [50.0, 2.0] }]\n\
                 [[rules]]\non = \"enters\"\ndo = [{ queue = \"place\" }, { speed = 0.5 }]\n";
    let (brains, stage) = played(2, story, &[(1.0, Signal::CameTo(0, 0)), (1.0, Signal::CameTo(1, 0))], 4.0);
    assert_eq!([0, 1].map(|m| brains.brains[m].speed), [0.5, 0.5], "{:?}", stage.log);
}

#[test]
fn what_has_no_event_is_in_no_set() {
    let story = "[[events]]\nname = \"bell\"\nat_s = 1.0\n[[rules]]\non = \"starts\"\ndo = [{ timer = 2 }]\n\
                 [[rules]]\non = \"timer\"\nwhen = \"event in me.news\"\ndo = [{ speed = 0.5 }]\n\
                 [[rules]]\non = \"bell\"\nwhen = \"event in me.news\"\ndo = [{ speed = 0.9 }]\n";
    assert_eq!(played(1, story, &[], 4.0).0.brains[0].speed, 0.9);
}

#[test]
fn who_is_near_a_happening_in_the_air_is_near_in_height_too() {
    let text = "environment.space = \"air\"\n[values.x]\n[[happenings]]\ntime_s = 1.0\ngoal = { stay = {} }\n\
                near = { at = [0.0, -4.0, 0.5], radius_m = 5.0 }\n[[groups]]\nmotion = \"none\"\ncount = 2\ngoal = { stay = {} }\n\
                place = { block = { from = [0.0, 0.0, 0.0], to = [9.0, 9.0, 9.0] } }\n";
    let mut brains = super::brains(&Scene::parse(text, Path::new("scene.toml")).unwrap());
    let mut stage = super::Paper::new(2);
    stage.at[1] = Some((Vec3::Y, Vec3::ZERO));
    super::Lives::begin(&mut brains, &mut stage);
    super::play(&mut brains, &mut stage, &[], 2.0);
    assert_eq!([0, 1].map(|m| brains.num_known(m)), [1, 0], "the other is 5.02 m off");
}

#[test]
fn what_is_wrong_is_told_with_its_place_and_the_way_out() {
    let graph = |edges: &str| {
        format!(
            "[graphs.life]\nlevel = \"social\"\nstart = \"a\"\nedges = [{edges}]\n[graphs.life.states]\na = {{ do = [{{ stay = 1 }}] }}\nb = {{ do = [{{ stay = 1 }}] }}\n[[events]]\nname = \"bell\"\n"
        )
    };
    let rule = |rest: &str| {
        format!(
            "[values.anger]\n[[events]]\nname = \"bell\"\n[[places]]\nname = \"bakery\"\nat = [0.0, 0.0]\n[[rules]]\n{rest}\n"
        )
    };
    for (story, expected) in [
        (rule("on = \"bel\"\ndo = [{ stay = 1 }]"), vec!["scene.toml:8:1", "Did you mean `bell`?"]),
        (
            rule("on = \"bell\"\nwhen = \"me.angr > 0.5\"\ndo = [{ stay = 1 }]"),
            vec![":9:9", "unknown word `me.angr`", "me.anger"],
        ),
        (
            rule("on = \"bell\"\nwhen = \"me.anger > 0.5 and place.kind == 'x'\"\ndo = [{ stay = 1 }]"),
            vec![":9:28", "there is no `place`"],
        ),
        (
            rule("on = \"bell\"\nwhen = \"me.anger\"\ndo = [{ stay = 1 }]"),
            vec![":9:9", "expected true or false, found a number"],
        ),
        (rule("on = \"bell\"\nwhen = \"me.anger > \"\ndo = [{ stay = 1 }]"), vec!["expected a value, found the end"]),
        (
            rule("on = \"bell\"\nwhen = \"distance(me) > 2\"\ndo = [{ stay = 1 }]"),
            vec!["expected `distance(me, other)`"],
        ),
        (rule("on = \"bell\"\nwhen = \"event == 'bakery'\"\ndo = [{ stay = 1 }]"), vec!["there is no event `bakery`"]),
        (rule("on = \"bell\"\ndo = [{ gret = \"bakery\" }]"), vec![":9:7", "Did you mean `greet`?"]),
        (rule("on = \"bell\"\ndo = [{ go = \"bakry\" }]"), vec!["Did you mean `bakery`?"]),
        (
            rule("on = \"bell\"\ndo = [{ go = \"bakery\", speeed = 1 }]"),
            vec!["`go` has no word `speeed`", "Did you mean `speed`?"],
        ),
        (rule("on = \"bell\"\ndo = [{ queue = \"bakery\" }]"), vec!["a place with a `queue`"]),
        (rule("on = \"bell\"\ndo = \"sing\""), vec!["there is no behaviour `sing`"]),
        (rule("on = \"bell\"\ndo = []"), vec!["expected at least one action"]),
        (rule("on = \"bell\"\nprobability = 1.5\ndo = [{ stay = 1 }]"), vec!["expected 0 to 1, found 1.5"]),
        (rule("on = \"anger > 7\"\ndo = [{ stay = 1 }]"), vec!["within the limits of `anger`"]),
        (rule("on = \"bell\"\nwho = [\"peopl\"]\ndo = [{ stay = 1 }]"), vec!["Did you mean `people`?"]),
        (graph(""), vec!["no edge leads to `b`"]),
        (graph("{ from = \"a\", to = \"b\" }, { from = \"b\", to = \"c\" }"), vec!["no state `c`"]),
        (
            graph(
                "{ from = \"a\", to = \"b\", on = \"bell\", probability = 0.7 }, { from = \"a\", to = \"a\", on = \"bell\", probability = 0.7 }",
            ),
            vec!["add up to 1.4"],
        ),
        (graph("{ from = \"a\", to = \"b\", on = \"bell\", probability = -0.5 }"), vec!["expected 0 to 1, found -0.5"]),
        (
            "[[events]]\nname = \"meets\"\n[[rules]]\non = \"meets\"\ndo = [{ stay = 1 }]".into(),
            vec!["give the event another name"],
        ),
        ("[[events]]\nname = \"a\"\nwhen = \"random < 0.5\"".into(), vec!["events[0].when", "there is no `random`"]),
        ("[[events]]\nname = \"a\"\nwhen = \"speed < 0.5\"".into(), vec!["events[0].when", "there is no `me`"]),
        (
            "[[events]]\nname = \"a\"\nwhen = \"distance(me, 'x') < 1\"".into(),
            vec!["events[0].when", "there is no `me`: what an event waits for is about nobody in particular"],
        ),
        ("[[events]]\nname = \"a\"\nat_s = 1.0\nperiod_s = 2.0".into(), vec!["expected one of `at_s`"]),
        (
            rule("on = \"bell\"\ndo = [{ follow = \"people:0\" }]"),
            vec!["rules[0].do[0].follow", "expected `other` or a place: `people:0` is neither"],
        ),
        (
            rule("on = \"bell\"\ndo = [{ go = [1.0] }]"),
            vec!["rules[0].do[0].go", "expected 2 numbers (x, z)", "found 1"],
        ),
        (
            rule("on = \"bell\"\ndo = [{ go = [nan, 1.0] }]"),
            vec!["rules[0].do[0].go", "-100000 to 100000 m, found NaN"],
        ),
        (
            rule(&format!("on = \"bell\"\ndo = [{{ follow_route = {:?} }}]", vec![[1.0, 2.0]; 1001])),
            vec!["rules[0].do[0].follow_route", "expected 2 to 1000 points"],
        ),
        (
            rule("on = \"bell\"\ndo = [{ follow_route = [[1.0, 2.0], [1.0, 2.0, 3.0]] }]"),
            vec!["rules[0].do[0].follow_route[1]", "expected 2 numbers (x, z)", "found 3"],
        ),
        (
            "[[places]]\nname = \"line\"\nat = [0.0, 0.0]\n[places.queue]\nspacing_m = 0.3\n\
             points = [[-1e5, -1e5], [1e5, 1e5], [-1e5, -1e5]]\n[[events]]\nname = \"a\""
                .into(),
            vec!["places[0].queue", "at most 1000000 slots", "a larger `spacing_m`"],
        ),
        (
            format!(
                "[[groups]]\nmotion = \"none\"\ncount = 999_998\ngoal = {{ stay = {{}} }}\n\
                 place = {{ block = {{ from = [0.0, 20.0], to = [9e4, 9e4] }} }}\n{}",
                "[[rules]]\non = \"starts\"\npause_s = 1.0\ndo = [{ speed = 1.0 }]\n".repeat(269)
            ),
            vec!["rules[268].pause_s", "at most 268 rules with a pause for 1000000 agents"],
        ),
        (rule("on = \"bell\"\ndo = [{ stay = nan }]"), vec!["rules[0].do[0].stay", "expected a number"]),
        (
            graph(&"{ to = \"b\", on = \"bell\" }, ".repeat(65)),
            vec!["graphs.life.edges", "at most 64 edges", "found 65 from `a`"],
        ),
        (
            "[[groups]]\nmotion = \"none\"\ncount = 2\ngoal = { stay = {} }\n\
             place = { block = { from = [0.0, 20.0], to = [9.0, 29.0] } }\n\
             [[relations]]\nof = \"people:4294967295\"\nto = \"people\"\nfriendship = 1.0\n[[events]]\nname = \"a\""
                .into(),
            vec!["expected an agent from 0 to 1"],
        ),
        (
            "[[relations]]\nof = \"people:9\"\nto = \"people\"\nfriendship = 1.0\n[[events]]\nname = \"a\"".into(),
            vec!["expected an agent from 0 to 1"],
        ),
    ] {
        let e = refused(&story);
        for part in expected {
            assert!(e.contains(part), "expected `{part}` in: {e}\n{story}");
        }
    }
}

#[test]
fn as_much_as_has_a_number_is_taken_and_no_more() {
    let mut graph = "[graphs.life]\nlevel = \"social\"\nstart = \"s0\"\n".to_string();
    let num = 3000;
    let edge = |k: usize| format!("{{ from = \"s{k}\", to = \"s{}\" }}", (k + 1) % num);
    graph += &format!("edges = [{}]\n[graphs.life.states]\n", (0..num).map(edge).collect::<Vec<_>>().join(", "));
    (0..num).for_each(|k| graph += &format!("s{k} = {{ do = [{{ stay = 1 }}] }}\n"));
    let mut scene = super::scene(1, &format!("{graph}[[events]]\nname = \"bell\"\n"));
    assert_eq!(super::brains(&scene).scenario.edges.len(), num);
    let thing =
        |k: usize| ThingConfig { name: format!("t{k}"), at: [0.0; 3], size_m: [0.1; 3], carried: CarryStyle::Level };
    scene.things = (0..65_536).map(thing).collect();
    let e = Scenario::new(&scene, &ActionRegistry::default()).unwrap_err().to_string();
    assert!(e.contains("expected at most 65535 things, found 65536"), "{e}");
}

#[test]
fn actions_that_take_no_time_follow_each_other_however_many() {
    let story = format!("[[rules]]\non = \"starts\"\ndo = [{}]", "{ stay = 0 }, ".repeat(20_000));
    let (_, stage) = played(1, &story, &[], 1.0);
    assert_eq!(stage.log.iter().filter(|line| line.ends_with("halt")).count(), 20_000);
}

#[test]
fn who_queues_where_there_are_no_slots_goes_on() {
    let story = "[[places]]\nname = \"door\"\nat = [50.0, 0.0]\n[[rules]]\non = \"enters\"\n\
                 do = [{ queue = \"place\" }, { speed = 0.5 }]\n";
    let (brains, stage) = played(1, story, &[(1.0, Signal::CameTo(0, 0))], 4.0);
    assert_eq!(brains.brains[0].speed, 0.5, "{:?}", stage.log);
}

#[test]
fn amounts_are_numbers_and_not_too_large() {
    let story = "[values.mood]\n[values.haste]\n[[events]]\nname = \"bell\"\nat_s = 1.0\n[[rules]]\non = \"bell\"\ndo = [\
                 { set = \"mood\", to = \"0 * distance(me, other)\" }, { rate = \"haste\", to = 1e39 },\
                 { stay = \"event.age - event.age * 1\" }]\n";
    let (brains, _) = played(1, story, &[], 2.0);
    assert_eq!(brains.feelings.iter().map(|f| (f.value, f.rate)).collect::<Vec<_>>(), [(0.0, 1e9), (0.0, 0.0)]);
    let mut bytes = Vec::new();
    brains.save(&mut bytes);
    brains.clone().load(&bytes, 2.0).unwrap();
}

#[test]
fn impossible_agent_brains_are_refused() {
    let story =
        "[[events]]\nname = \"bell\"\nperiod_s = 4.0\n[[rules]]\non = \"starts\"\ndo = [{ timer = 9 }, { stay = 9 }]\n";
    let (brains, _) = played(2, story, &[], 2.0);
    let is_refused = |change: fn(&mut AgentBrains)| {
        let (mut forged, mut bytes) = (brains.clone(), Vec::new());
        change(&mut forged);
        forged.save(&mut bytes);
        brains.clone().load(&bytes, 2.0).is_err()
    };
    assert!(!is_refused(|_| ()));
    for (n, change) in [
        // Whoever does nothing, or is at an effect, has no time at which it is over.
        |m: &mut AgentBrains| m.brains[0].action = NONE,
        |m: &mut AgentBrains| m.brains[0].action -= 1,
        |m: &mut AgentBrains| (m.brains[0].action, m.brains[0].stands_until_s) = (NONE, f64::INFINITY),
        |m: &mut AgentBrains| m.enters[0] = 3.0,
        |m: &mut AgentBrains| m.times[0] = u32::MAX,
        |m: &mut AgentBrains| m.due[0] = 1.9,
    ]
    .into_iter()
    .enumerate()
    {
        assert!(is_refused(change), "{n}");
    }
}

#[test]
fn an_agent_brain_is_small() {
    assert!(size_of::<super::super::AgentBrain>() <= 208, "{}", size_of::<super::super::AgentBrain>());
}

#[test]
fn other_is_refused_in_a_state_into_which_nobody_leads() {
    let story = |on: &str| {
        format!(
            "[graphs.life]\nlevel = \"social\"\nstart = \"a\"\nedges = [{{ from = \"a\", to = \"b\"{on} }}]\n\
             [graphs.life.states]\na = {{ do = [{{ stay = 1 }}] }}\nb = {{ do = [{{ chat = \"other\", for_s = 2 }}] }}\n"
        )
    };
    let groups = "[[groups]]\nmotion = \"none\"\ncount = 2\ngraph = \"life\"\n\
                  place = { block = { from = [0.0, 0.0], to = [99.0, 9.0] } }\n";
    let open = |on: &str| {
        let text = format!("{groups}{}", story(on));
        Scene::parse(&text, Path::new("scene.toml")).and_then(|s| s.open()).map(|_| ())
    };
    let told = open("").unwrap_err().to_string();
    assert!(told.contains("graphs.life.states.b") && told.contains("nothing that leads here"), "{told}");
    open(", on = \"meets\"").unwrap();
}
