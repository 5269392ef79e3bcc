//! Help fits the screen, and each command that makes something says how to go on.

use super::{BundleFolder, COMMANDS, at, done, folder, json, refused, text, throng};
use std::path::Path;

/// Columns of a screen.
const COLUMNS: usize = 100;
/// Rows of half a screen and of one and a half.
const ROWS: [(&str, usize); 2] = [("-h", 24), ("--help", 60)];

/// Rows that a text takes on a screen.
fn num_rows(text: &str) -> usize {
    text.lines().map(|line| line.chars().count().div_ceil(COLUMNS).max(1)).sum()
}

/// Every command that has options, those below others included.
fn commands() -> Vec<Vec<&'static str>> {
    let below = [("query", &["action", "path"][..]), ("bench", &["bundle", "motion", "crowd", "plan", "scenario"][..])];
    let below = below.into_iter().flat_map(|(above, all)| all.iter().map(move |name| vec![above, *name]));
    // The viewer answers for itself.
    COMMANDS.iter().filter(|c| **c != "view").map(|c| vec![*c]).chain(below).chain([Vec::new()]).collect()
}

#[test]
fn help_fits_the_screen() {
    for command in commands() {
        for (flag, most) in ROWS {
            let help = done(&[&command[..], &[flag]].concat());
            let rows = num_rows(&help);
            // The list of all commands is a screen of its own.
            let most = if command.is_empty() { 50 } else { most };
            assert!(rows <= most, "throng {command:?} {flag}: {rows} rows, at most {most}:\n{help}");
            let widest = help.lines().map(|l| l.chars().count()).max().unwrap_or(0);
            assert!(widest <= 130, "throng {command:?} {flag}: a line of {widest} columns:\n{help}");
            assert!(!help.contains("JSON keys"), "keys have a page of their own: {help}");
        }
    }
}

#[test]
fn rare_options_are_in_groups_of_the_long_help() {
    let (short, long) = (done(&["run", "-h"]), done(&["run", "--help"]));
    for group in ["Scenes:", "Live:", "Characters:", "Cache:"] {
        assert!(long.contains(group) && !short.contains(group), "{group} {short}\n{long}");
    }
    assert!(
        short.contains("--png") && !short.contains("--cache-limit") && short.contains("`--help` has more"),
        "{short}"
    );
    let (_, named) = short.split_once("`--help` has more:").expect("groups of options");
    let groups: Vec<&str> = named.split(',').map(str::trim).collect();
    let is_once = |group: &&&str| groups.iter().filter(|other| other == group).count() == 1;
    assert!(groups.len() > 3 && groups.iter().all(|group| is_once(&group)), "a group is named twice: {short}");
    assert_eq!(done(&["help", "run"]), long);
    assert_eq!(done(&["help", "query", "path"]), done(&["query", "path", "--help"]));
    assert!(refused(&["help", "fly"]).contains("fly"));
}

#[test]
fn a_page_lists_the_commands_that_have_keys() {
    let page = done(&["help", "keys"]);
    for command in commands().iter().filter(|c| !c.is_empty()) {
        let has_keys = throng(&[&["help", "keys"], &command[..]].concat()).status.success();
        let is_listed = page.lines().any(|line| line.trim() == command.join(" "));
        assert_eq!(has_keys, is_listed, "{command:?}: {page}");
    }
}

/// The command that the last line names, as words; its options are known to the parser.
fn next_words(args: &[&str]) -> Vec<String> {
    let printed = done(args);
    let last = printed.lines().last().unwrap_or_default();
    let next =
        last.strip_prefix("next: throng ").unwrap_or_else(|| panic!("{args:?} says not what is next: {printed}"));
    let words: Vec<String> = next.split(' ').map(str::to_owned).collect();
    assert!(COMMANDS.contains(&words[0].as_str()), "{last}");
    if words[0] != "view" {
        let known = throng(&[&words.iter().map(String::as_str).collect::<Vec<_>>()[..], &["--help"]].concat());
        assert!(known.status.success(), "{last}: {}", text(&known.stderr));
    }
    let made = words[1..].iter().filter(|w| w.starts_with('/')).collect::<Vec<_>>();
    assert!(Path::new(made[0]).exists(), "{last} begins with a file that is not there");
    words
}

#[test]
fn commands_that_make_something_say_what_is_next() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let (bundle, clip, config) = (place.bundle(), place.first_clip(), place.path("little.toml"));
    let (clips, out, glb, png) =
        (at(&folder, "clips"), at(&folder, "a.throng"), at(&folder, "a.glb"), at(&folder, "a.png"));
    let name = |words: Vec<String>| words[0].clone();
    assert_eq!(name(next_words(&["synth", "--out", &clips, "--minutes", "0.5"])), "build");
    assert_eq!(name(next_words(&["inspect", &clips])), "build");
    assert_eq!(name(next_words(&["inspect", &bundle, "--hits-png", &png])), "run");
    assert_eq!(name(next_words(&["build", &config, "--out", &out, "--no-cache"])), "run");
    // One file, so that one shard has all of it, and the other waits.
    for shard in ["0/2", "1/2"] {
        let cache = at(&folder, &shard.replace('/', "-"));
        let words = next_words(&["bake", &config, "--shard", shard, "--cache", &cache]);
        let again = ["bake", &config, "--shard", shard, "--cache", &cache];
        assert!(words == again || words == ["build", &config, "--cache", &cache], "{words:?}");
        assert_eq!(next_words(&["bake", &config, "--shard", "0/1", "--cache", &cache])[0], "build");
    }
    let run = ["run", &bundle, "--characters", "4", "--seconds", "1", "--png", &png];
    assert_eq!(name(next_words(&run)), "view");
    let (plan, level) = (concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/level.geojson"), at(&folder, "a.level"));
    assert_eq!(next_words(&["level", plan, "--out", &level]), ["inspect", &level]);
    done(&["inspect", &level]);
    let demo = ["demo", "--characters", "4", "--seconds", "1", "--out", &png, "--bundle", &out];
    assert_eq!(name(next_words(&demo)), "export");
    let taken = next_words(&["export", &bundle, "--format", "glb", "--to", "1", "--characters", "0", "--out", &glb]);
    assert_eq!(taken, ["inspect", &glb]);
    done(&["inspect", &glb]);
    let task = concat!(env!("CARGO_MANIFEST_DIR"), "/data/tasks/arm-low.toml");
    let planned = next_words(&["plan", task, "--out", &at(&folder, "arm.bvh")]);
    done(&planned.iter().map(String::as_str).collect::<Vec<_>>());
    let ground = at(&folder, "ground.toml");
    assert_eq!(name(next_words(&["inspect", &clip, "--environment-out", &ground])), "inspect");
    let csv = at(&folder, "a.csv");
    let printed = done(&["export", &bundle, "--format", "policy-csv", "--out", &csv]);
    assert_eq!(printed, format!("next: head {csv}\n"));
    json(&["synth", "--out", &clips, "--minutes", "0.5", "--json"], &["clips"]);
}

#[test]
fn runs_that_are_recorded_say_what_is_next() {
    let folder = folder();
    let (scene, recording) = (at(&folder, "a.toml"), at(&folder, "a.recording"));
    let run = ["run", &scene, "--seconds", "1", "--record", &recording];
    // Only agents with a story have reasons to explain.
    let plain = "[[groups]]\nmotion = \"none\"\ncount = 4\nplace = { block = { from = [0, 0], to = [4, 4] } }\n\
                 goal = { stay = {} }\n";
    std::fs::write(&scene, plain).expect("a scene");
    assert_eq!(next_words(&run), ["view", &scene]);
    let story = "[[rules]]\non = \"starts\"\ndo = [{ stay = 1 }]\n";
    std::fs::write(&scene, format!("{plain}{story}")).expect("a scene");
    let next = next_words(&run);
    assert_eq!(next, ["explain", &recording, "--agent", "0"]);
    done(&next.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn worlds_that_are_stitched_say_what_is_next() {
    let folder = folder();
    let (config, world) = (at(&folder, "tiles.toml"), at(&folder, "square.toml"));
    let units = concat!(env!("CARGO_MANIFEST_DIR"), "/data/units/playground.toml").replace('\\', "/");
    let little = format!(
        "behaviours = []\nsynth = {{ set = \"walk\", minutes = 0.3 }}\ngraph = {{ enabled = false }}\n\n\
         [patches]\nunits = \"{units}\"\ntiles = [{{ unit = \"ground\", edge_groups = 2 }}]\n"
    );
    std::fs::write(&config, little).expect("a config");
    let square = "bundle = \"tiles.throng\"\n[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\nrepeat = [2, 1, 2]\n\
                  step = [[2.8, 0, 0], [0, 0, 0], [0, 0, 2.8]]\n";
    std::fs::write(&world, square).expect("a world");
    done(&["build", &config, "--out", &at(&folder, "tiles.throng"), "--no-cache"]);
    assert_eq!(next_words(&["stitch", &world]), ["view", &world]);
}
