//! What scene files may say, and what is refused.

use super::*;

const BLOCK: &str = "place = { block = { from = [0.0, 0.0], to = [5.0, 5.0] } }\n";
/// The engines that this build knows.
const ENGINES: &str = match cfg!(feature = "fixed-steps") {
    true => "expected one of events, occupancy, fixed, pairs, found",
    false => "expected one of events, occupancy, found",
};
const GOAL: &str = "goal = { shift = { by = [9.0, 0.0] } }\n";

fn load(text: &str) -> Result<Scene, String> {
    Scene::parse(text, Path::new("folder/square.toml")).map_err(|e| e.to_string())
}

fn agents(more: &str) -> String {
    format!("[[groups]]\nmotion = \"none\"\ncount = 10\n{BLOCK}{GOAL}{more}")
}

fn boxers(motion: &str, count: usize, more: &str) -> String {
    format!(
        "bundle = \"b.throng\"\n[[groups]]\nmotion = \"{motion}\"\ncount = {count}\n\
         behaviours = [{{ name = \"approach\" }}]\n{more}"
    )
}

fn walkers(more: &str) -> String {
    format!("bundle = \"b.throng\"\n[[groups]]\nmotion = \"blend\"\ncount = 3\nspaces = [\"a\"]\n{more}")
}

fn children(more: &str) -> String {
    format!(
        "bundle = \"b.throng\"\nenvironment.world = \"w.world\"\n[[groups]]\nmotion = \"patches\"\ncount = 3\n{more}"
    )
}

#[test]
fn a_scene_has_defaults_its_file_s_name_and_paths_from_its_folder() {
    let scene = load(&agents("")).unwrap();
    assert_eq!((scene.name.as_str(), scene.num_characters(), scene.seed, scene.seconds), ("square", 10, 1, 15.0));
    let scene = load(&children("config = \"c.toml\"\nbundle = \"own.throng\"\n")).unwrap();
    let (bundle, config) = scene.bundle_of(0);
    assert_eq!((bundle, config), (Some(Path::new("folder/own.throng")), Some(Path::new("folder/c.toml"))));
    assert_eq!(scene.world_of(0), (Some(Path::new("folder/w.world")), None));
}

#[test]
fn every_kind_of_motion_is_read() {
    let all = [
        agents(""),
        boxers("sparring", 2, ""),
        boxers("policy", 1, "target = { height_m = 1.4, drag = [{ time_s = 1.0 }] }\n"),
        walkers("paths = {}\n"),
        walkers(&format!("{BLOCK}{GOAL}")),
        children("goals = [{ goal = { perform = { tag = \"slide\", seconds = [1.0, 2.0] } } }]\n"),
    ];
    for text in all {
        load(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    }
}

#[test]
fn faults_name_line_key_and_what_was_expected() {
    for (text, parts) in [
        ("seconds = 0.0\n".to_owned() + &agents(""), ["square.toml:1:1: key `seconds`", "found 0"]),
        ("seconds = 3.0\n".to_owned(), ["square.toml:1:1", "`groups`"]),
        ("colour = 1\n".to_owned() + &agents(""), ["square.toml:1:1: unknown field `colour`", "throng schema"]),
        ("secnds = 1\n".to_owned() + &agents(""), ["square.toml:1:1", "Did you mean `seconds`?"]),
        (agents("[environment]\nspace = \"air\"\n"), ["square.toml:4:", "3 numbers"]),
        (agents("[agents]\nengine = \"magic\"\n"), ["square.toml:7:10", ENGINES]),
        (agents("").replace("count = 10", "count = 0"), ["square.toml:3:1: key `groups[0].count`", "found 0"]),
        (agents("").replace("count = 10", "count = \"x\""), ["square.toml:3:9", "invalid type"]),
        (agents("").replace("to = [5.0", "to = [-5.0"), ["`groups[0].place.block`", "lowest corner"]),
        (agents("radius_m = [0.5, 0.2]\n"), ["`groups[0].radius_m`", "0.5, 0.2"]),
        (agents("[agents.field]\nmagic = 1.0\n"), ["square.toml:7:1", "unknown field `magic`"]),
        (
            agents("[[environment.obstacles]]\nwall = { points = [[1.0, 2.0]] }\n"),
            ["square.toml:7:", "`environment.obstacles[0].wall.points`"],
        ),
        (agents("[measure.lanes]\nalong = [1.0, 0.0]\n"), ["`measure.lanes`", "two groups"]),
        (agents("[[happenings]]\ntime_s = -1.0\ngoal = { stay = {} }\n"), ["`happenings[0].time_s`", "found -1"]),
        (agents("").replace(GOAL, ""), ["`groups[0].goal`", "stay"]),
        (agents("").replace(BLOCK, ""), ["`groups[0].place`", "block"]),
        (agents("temperature = 1.0\n"), ["square.toml:6:1", "\"policy\" or \"sparring\""]),
        (agents("manners = [\"sad\"]\n"), ["square.toml:6:1", "\"policy\" or \"sparring\""]),
        (boxers("sparring", 3, ""), ["`groups[0].count`", "even"]),
        (boxers("sparring", 2, "target = {}\n"), ["square.toml:6:1", "\"policy\""]),
        (boxers("sparring", 2, "stagger_force = 11.0\n"), ["`groups[0].stagger_force`", "found 11"]),
        (boxers("sparring", 2, "temperature = nan\n"), ["`groups[0].temperature`", "found NaN"]),
        (
            boxers("policy", 2, "place = { grid = { distance_m = -1.0 } }\n"),
            ["`groups[0].place.grid.distance_m`", "-1"],
        ),
        (boxers("policy", 2, "target = { drag = [{ time_s = 0.0 }] }\n"), ["`groups[0].target.drag`", "ascend"]),
        (
            boxers("policy", 2, "").replace("}]", "}, { name = \"approach\" }]"),
            ["`groups[0].behaviours[1].name`", "every behaviour once"],
        ),
        (boxers("policy", 2, "").replace("[{ name = \"approach\" }]", "[]"), ["`groups[0].behaviours`", "1 to 4"]),
        (boxers("policy", 2, "").replace("bundle", "#"), ["`groups[0]`", "needs a `bundle`"]),
        (walkers(""), ["`groups[0].place`", "block"]),
        (walkers("paths = {}\n").replace("[\"a\"]", "[]"), ["`groups[0].spaces`", "1 to 64 blend spaces, found 0"]),
        (
            walkers("paths = {}\n").replace("\"a\"", &"\"a\",".repeat(65)),
            ["`groups[0].spaces`", "1 to 64 blend spaces, found 65"],
        ),
        (
            agents("[[rules]]\non = \"starts\"\npause_s = -1.0\ndo = [{ stay = 1 }]\n"),
            ["square.toml:8:1: key `rules[0].pause_s`", "expected 0 to 1000000, found -1"],
        ),
        (
            agents("")
                .replace("count = 10", "count = 100_000")
                .replace(GOAL, "goal = { wander = { from = [0.0, 0.0], to = [5.0, 5.0], points = 999 } }\n"),
            ["`groups[0].goal.wander.points`", "at most 30000000 points for all agents, found 100100000"],
        ),
        (
            agents("").replace("count = 10", "count = 1_000_000") + &format!("via = [{}]\n", "[1.0, 1.0], ".repeat(29)),
            ["`groups[0].via`", "found 31000000"],
        ),
        (
            agents(
                "[[environment.obstacles]]\nmover = { radius_m = 1.0, path = [{ time_s = 0.0, at = [0.0, 0.0] }, \
                 { time_s = 1e-40, at = [9.0, 0.0] }] }\n",
            ),
            ["mover.path[1].time_s`", "ascend from 0 by 0.0001 s or more"],
        ),
        (
            format!("environment.hills_m = 1.0\n{}", walkers("paths = { area_m = 10000.0 }\n"))
                + &walkers("paths = { area_m = 10000.0 }\n").replace("bundle = \"b.throng\"\n", "").repeat(33),
            ["`groups[33].paths.area_m`", "less ground for all groups"],
        ),
        (walkers("paths = { speeds = [3.0, 1.0] }\n"), ["`groups[0].paths.speeds`", "3, 1"]),
        (walkers("paths = {}\nbodies = { kinds = 0 }\n"), ["`groups[0].bodies.kinds`", "found 0"]),
        (walkers("paths = {}\n[environment]\nhills_m = -1.0\n"), ["`environment.hills_m`", "found -1"]),
        (walkers("paths = {}\nstyle_by_speed = [[2.0, 0.0], [1.0, 1.0]]\n"), ["style_by_speed", "ascend"]),
        (walkers(&format!("paths = {{}}\n{GOAL}")), ["`groups[0].goal`", "either"]),
        (children("").replace("environment.world", "#"), ["`groups[0].world`", "stitched"]),
        (children("goals = [{ share = 0.0, goal = { visit = {} } }]\n"), ["`groups[0].goals[0].share`", "found 0"]),
        (children("goals = [{ goal = { roam = { seconds = [3.0, 2.0] } } }]\n"), ["goals[0].goal.seconds`", "3 and 2"]),
        (children("goals = [{ goal = { dance = {} } }]\n"), ["square.toml:6:", "dance"]),
    ] {
        let message = load(&text).expect_err(&text);
        assert!(parts.iter().all(|p| message.contains(p)), "{parts:?}: {message}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("duel.toml");
    std::fs::write(&file, b"name = \"a\"\n\xff\xfe").unwrap();
    let bytes = Scene::load(&file).unwrap_err().to_string();
    assert!(bytes.contains("duel.toml:2:1: expected a scene as TOML"), "{bytes}");
}

#[test]
fn unknown_keys_and_files_of_another_kind_are_refused_with_the_way_out() {
    let message = load(&format!("name = \"a\"\nspacing_m = 4.0\n{}", agents(""))).unwrap_err();
    assert!(message.starts_with("folder/square.toml:2:1: unknown field `spacing_m`"), "{message}");
    assert!(message.ends_with(HELP), "{message}");
    let message = load(&format!("enviroment.hills_m = 1.0\n{}", agents(""))).unwrap_err();
    assert!(message.ends_with("Did you mean `environment`?"), "{message}");
    let message = load(&agents("").replace("motion = \"none\"\n", "")).unwrap_err();
    assert!(message.starts_with("folder/square.toml:1:1: missing field `motion`"), "{message}");
    let message = load("name = \"a\"\n[[tasks]]\nkind = \"reach\"\n").unwrap_err();
    assert!(message.starts_with("folder/square.toml:2:3: `tasks`") && message.contains("throng plan"), "{message}");
}

#[test]
fn more_agents_keep_their_shares_and_their_density() {
    let two = format!("{}{}", agents(""), agents("").replace("10", "30"));
    let mut scene = load(&format!("measure.grows = true\n{two}")).unwrap();
    let big = scene.resized(4000);
    assert_eq!([big.groups[0].count, big.groups[1].count], [1000, 3000]);
    let Some(PlaceConfig::Block { to, .. }) = &big.groups[0].place else { panic!("a block") };
    assert!((to[0] - 50.0).abs() < 1e-3, "10 times as long: {to:?}");
    scene.measure.grows = false;
    assert_eq!(scene.resized(4000).groups[1].place, scene.groups[1].place);
    assert_eq!(scene.resized(7).num_characters(), 7);
}

#[test]
fn styles_change_linearly_between_the_speeds_that_are_given() {
    let scene = load(&walkers("paths = {}\nstyle_by_speed = [[2.0, 0.0], [3.0, 1.0], [5.0, 2.0]]\n")).unwrap();
    let style = |speed| scene.groups[0].style_at(speed);
    assert_eq!([style(0.0), style(2.0), style(2.5), style(4.0), style(9.0)], [0.0, 0.0, 0.5, 1.5, 2.0]);
}

#[test]
fn every_scene_of_the_project_is_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes");
    let files = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path());
    let scenes: Vec<_> = files.map(|f| Scene::load(&f).unwrap_or_else(|e| panic!("{e}"))).collect();
    assert!(scenes.len() >= 16);
}

/// What only shows when bundles and worlds are opened is told with its place in the file too.
#[test]
fn names_and_files_that_are_not_there_are_told_with_line_and_column() {
    let golden = format!("../../data/golden/tables_v{}.throng", throng_core::format::VERSION);
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join(golden);
    let golden = golden.to_str().expect("a readable path");
    let there = |text: String| text.replace("b.throng", golden);
    let (unknown_behaviour, two_spaces) = (
        there(boxers("policy", 1, ""))
            .replace("[{ name = \"approach\" }]", "[{ name = \"approach\" },\n  { name = \"dance\" }]"),
        there(walkers(GOAL)).replace("[\"a\"]", "[\"walks\",\n  \"runs\"]") + BLOCK,
    );
    for (text, place, parts) in [
        (boxers("policy", 1, ""), ":1:1: key `bundle`", ["b.throng", "throng build"]),
        (
            boxers("policy", 1, "bundle = \"own.throng\"\n"),
            ":6:1: key `groups[0].bundle`",
            ["own.throng", "throng build"],
        ),
        (unknown_behaviour, ":6:5: key `groups[0].behaviours[1].name`", ["no behaviour \"dance\"", "there is"]),
        (two_spaces, ":6:3: key `groups[0].spaces[1]`", ["no blend space \"runs\"", "walks"]),
        (there(children("")), ":2:13: key `environment.world`", ["w.world", "throng stitch"]),
        (there(children("world = \"own.world\"\n")), ":6:1: key `groups[0].world`", ["own.world", "throng stitch"]),
    ] {
        let scene = load(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
        let message = scene.open().unwrap_err().to_string();
        assert!(message.starts_with(&format!("folder/square.toml{place}")), "{place}: {message}");
        assert!(parts.iter().all(|p| message.contains(p)), "{parts:?}: {message}");
    }
}

/// Whoever changes a scene after it was read cannot bring numbers past their ranges.
#[test]
fn numbers_that_are_changed_later_are_checked_too() {
    for count in [0, 1_000_001, usize::MAX] {
        let mut scene = load(&agents("")).unwrap();
        scene.groups[0].count = count;
        let message = scene.open().unwrap_err().to_string();
        assert!(message.contains("groups[0].count") && message.contains("1 to 1000000"), "{message}");
    }
    let message = load(&agents("")).unwrap().resized(usize::MAX).open().unwrap_err().to_string();
    assert!(message.contains("1 to 1000000"), "{message}");
    let mut scene = load(&agents("")).unwrap();
    scene.seconds = f64::INFINITY;
    assert!(scene.open().unwrap_err().to_string().contains("0.001 to 100000 s"));
}
