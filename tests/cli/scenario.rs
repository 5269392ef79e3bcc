//! `check`, `run --record`, `explain` and `bench scenario` on a scene of agents without bodies.

use super::*;

const STORY: &str = "seconds = 6.0\n[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = 12\n\
    place = { block = { from = [-6.0, -4.0], to = [6.0, 4.0] } }\ngraph = \"life\"\n\
    [[events]]\nname = \"bell\"\nat_s = 1.0\nwho = \"me.number == 0\"\npassed_on = true\n\
    [graphs.life]\nlevel = \"social\"\nstart = \"idle\"\nedges = [{ from = \"idle\", to = \"go\", on = \"bell\" }]\n\
    [graphs.life.states]\nidle = { do = [{ stay = 100 }] }\ngo = { do = [{ go = [0.0, 8.0], within_m = 2.0 }] }\n";

#[test]
fn what_people_did_is_checked_recorded_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, record) = (folder.path().join("story.toml"), folder.path().join("story.rec"));
    std::fs::write(&scene, STORY).unwrap();
    let (scene, record) = (scene.to_str().unwrap(), record.to_str().unwrap());
    let checked: Value = serde_json::from_str(&done(&["check", scene, "--json"])).unwrap();
    assert_eq!(checked["characters"], 12);
    done(&["run", scene, "--record", record, "--json"]);
    let why: Value = serde_json::from_str(&done(&["explain", record, "--agent", "0", "--at", "3", "--json"])).unwrap();
    assert_eq!(
        (&why["states"][0], &why["because"]["event"], &why["because"]["edge_to"]),
        (&"go".into(), &"bell".into(), &"go".into())
    );
    assert_eq!(why["knows"][0]["how"], "happens");
    let message: Value = serde_json::from_str(&done(&["explain", record, "--message", "bell", "--json"])).unwrap();
    let learnt = message["learnt"].as_array().unwrap();
    assert!(learnt.len() > 1 && learnt[1]["how"] == "passed_on" && learnt[1]["from"].is_number(), "{message}");
    let tree = done(&["explain", record, "--message", "bell"]);
    assert_eq!(tree.lines().count(), learnt.len(), "{tree}");
    let bench: Value =
        serde_json::from_str(&done(&["bench", "scenario", "--scene", scene, "--threads", "1,2", "--json"])).unwrap();
    let results = bench["results"].as_array().unwrap();
    assert_eq!(results.len(), 2);
    assert_eq!(results[0]["state_hash"], results[1]["state_hash"], "at any number of threads");
    assert_eq!((&results[0]["queued_twice"], &results[0]["max_overlap_m"]), (&0.into(), &0.0.into()));
    // Expectations are evaluated, with who breaks them; the exit status tells.
    let expects = |that: &str| {
        std::fs::write(scene, format!("{STORY}[[expect]]\nname = \"they hear\"\n{that}\n")).unwrap();
        let out = throng(&["check", scene, "--run", "--seeds", "2", "--json"]);
        (out.status.code(), serde_json::from_str::<Value>(&text(&out.stdout)).unwrap()["expectations"][0].clone())
    };
    let (code, good) = expects("that.passes = [\"me.z > -60\"]");
    assert_eq!((code, &good["holds"], &good["worst"]), (Some(0), &true.into(), &1.0.into()), "{good}");
    let (code, bad) = expects("that.passes = [\"me.z > 60\"]");
    assert_eq!((code, &bad["holds"], bad["broken_seeds"].as_array().unwrap().len()), (Some(1), &false.into(), 2));
    assert!(bad["agents"][0]["why"].as_str().unwrap().contains("of people at"), "{bad}");
    let told = text(&throng(&["check", scene, "--run"]).stdout);
    assert!(told.contains("BROKEN  they hear: 0.000 (expected 1 to ..)"), "{told}");
    std::fs::write(scene, STORY).unwrap();
    // What is refused is refused with the way out.
    for (args, expected) in [
        (vec!["explain", record], "expected `--agent A` or `--message NAME`"),
        (vec!["explain", record, "--agent", "12"], "expected less than 12"),
        (vec!["explain", record, "--message", "bel"], "bell"),
        (vec!["explain", scene, "--agent", "1"], "story.toml"),
    ] {
        let out = throng(&args);
        let told = text(&out.stderr);
        assert!(!out.status.success() && told.contains(expected), "{args:?}: {told}");
    }
    std::fs::write(scene, STORY.replace("[0.0, 8.0]", "\"tonw\"")).unwrap();
    let told = text(&throng(&["check", scene]).stderr);
    assert!(told.contains("story.toml:") && told.contains("there is no place `tonw`"), "{told}");
}

/// The scene of a stranger names files elsewhere: nothing is read there, written or built.
#[test]
fn scenes_of_strangers_reach_no_file_outside_of_their_folder() {
    let outside = tempfile::tempdir().unwrap();
    let folder = outside.path().join("scene");
    std::fs::create_dir(&folder).unwrap();
    let config = outside.path().join("walks.toml");
    std::fs::write(&config, "synth = { set = 'locomotion', seconds = 20 }\n").unwrap();
    let scene = folder.join("story.toml");
    let group = "[[groups]]\nmotion = \"policy\"\ncount = 1\nbehaviours = [{ name = \"approach\" }]\n";
    let write = |bundle: &str| {
        let keys = format!("bundle = \"{bundle}\"\nconfig = \"../walks.toml\"\nseconds = 1.0\n");
        std::fs::write(&scene, format!("{keys}{group}")).unwrap();
    };
    let names = || {
        let files = |at: &std::path::Path| {
            let names = std::fs::read_dir(at).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
            names.collect::<std::collections::BTreeSet<_>>()
        };
        (files(outside.path()), files(&folder))
    };
    let scene_name = scene.to_str().unwrap();
    let absolute = outside.path().join("y.throng");
    for bundle in ["../x.throng", "sub/../../x.throng", absolute.to_str().unwrap()] {
        write(bundle);
        let before = names();
        for args in [
            vec!["check", scene_name],
            vec!["check", scene_name, "--untrusted"],
            vec!["run", scene_name, "--untrusted"],
            vec!["export", scene_name, "--untrusted", "--format", "csv", "--out", "take.csv"],
        ] {
            let out = throng(&args);
            let told = text(&out.stderr);
            let expected = if args.contains(&"--untrusted") { "outside of the folder" } else { "no such bundle" };
            assert!(!out.status.success() && told.contains(expected), "{args:?}: {told}");
            assert_eq!(names(), before, "{args:?} of {bundle} writes");
        }
    }
    // A link out of the folder is as far as what it leads to.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&config, folder.join("in.throng")).unwrap();
        write("in.throng");
        let told = text(&throng(&["run", scene_name, "--untrusted"]).stderr);
        assert!(told.contains("outside of the folder"), "{told}");
    }
}
