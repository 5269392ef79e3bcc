//! `throng bake`: shares of a build, in any order, again and at once.

use super::{BundleFolder, at, failed, folder, json, throng};
use proptest::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// A folder with eight files: takes of two lengths of each clip of the shared place, one that is no motion, and a config.
struct Motion {
    _folder: tempfile::TempDir,
    config: String,
}

impl Motion {
    fn new() -> Self {
        let (place, folder) = (BundleFolder::shared(), folder());
        for (i, clip) in place.clips().iter().enumerate() {
            let text = std::fs::read_to_string(clip).expect("a clip");
            let (head, frames) = text.split_once("Frame Time:").expect("a header");
            let frames: Vec<&str> = frames.lines().collect();
            for (j, count) in [300, 200, 100].into_iter().enumerate() {
                let declared = head.lines().next_back().expect("a line");
                let head = head.replace(declared, &format!("Frames: {count}"));
                let from = 1 + 50 * j;
                let text = format!("{head}Frame Time:{}\n{}\n", frames[0], frames[from..from + count].join("\n"));
                std::fs::write(folder.path().join(format!("take {i} {j}.bvh")), text).expect("a file");
            }
        }
        std::fs::write(folder.path().join("broken.bvh"), "HIERARCHY\nROOT\n").expect("a file");
        let config = at(&folder, "all.toml");
        let little = std::fs::read_to_string(place.path("little.toml")).expect("the config");
        let lines = little.lines().map(|l| if l.starts_with("inputs") { "inputs = [\".\"]" } else { l });
        std::fs::write(&config, lines.collect::<Vec<_>>().join("\n")).expect("a config");
        Self { _folder: folder, config }
    }

    fn bake(&self, shard: &str, cache: &str) -> Value {
        let keys = ["files", "own_files", "read", "skipped", "missing", "made", "done", "warnings", "peak_bytes"];
        json(&["bake", &self.config, "--shard", shard, "--cache", cache, "--json"], &keys)
    }

    fn build(&self, out: &str, cache: &str) -> Value {
        json(&["build", &self.config, "--out", out, "--cache", cache, "--json"], &["stage_s"])
    }
}

/// Names and contents of the entries of a cache that single files have.
fn entries(cache: &str) -> BTreeMap<String, Vec<u8>> {
    let all = std::fs::read_dir(cache).expect("a cache").map(|e| e.expect("an entry").path());
    let name = |p: &Path| p.file_name().expect("a name").to_str().expect("a readable name").to_owned();
    let of_files = all.filter(|p| ["import-", "floor-", "clips-", "refused-"].iter().any(|s| name(p).starts_with(s)));
    of_files.map(|p| (name(&p), std::fs::read(&p).expect("an entry"))).collect()
}

#[test]
fn shards_leave_what_a_build_finds() {
    let (motion, elsewhere) = (Motion::new(), folder());
    let (cache, alone) = (at(&elsewhere, "cache"), at(&elsewhere, "alone"));
    let files = 7;
    let first: Vec<Value> = (0..3).map(|i| motion.bake(&format!("{i}/3"), &cache)).collect();
    let sum = |all: &[Value], key: &str| all.iter().map(|r| r[key].as_u64().expect("a number")).sum::<u64>();
    assert!(first.iter().all(|r| r["files"] == files), "{first:?}");
    assert_eq!((sum(&first, "own_files"), sum(&first, "read")), (files, files - 1));
    assert!(first[0]["missing"].as_u64() > Some(0) && first[0]["done"] == false, "{first:?}");
    assert_eq!((&first[2]["missing"], &first[2]["done"]), (&0.into(), &true.into()));
    let skipped: Vec<&Value> = first.iter().flat_map(|r| r["skipped"].as_array().expect("a list")).collect();
    assert!(skipped.len() == 1 && skipped[0].as_str().expect("a text").contains("broken.bvh"), "{skipped:?}");
    let second: Vec<Value> = (0..3).map(|i| motion.bake(&format!("{i}/3"), &cache)).collect();
    assert_eq!((sum(&second, "read"), sum(&second, "missing")), (0, 0));
    assert_eq!(sum(&first, "made") + sum(&second, "made"), files - 1);
    // A build reads and makes nothing of a single file again, and comes to the same bundle as one alone.
    let before = entries(&cache);
    let (a, b) = (at(&elsewhere, "a.throng"), at(&elsewhere, "b.throng"));
    let built = motion.build(&a, &cache);
    assert_eq!((&built["files_kept"], &built["clips_kept"]), (&(files - 1).into(), &(files - 1).into()), "{built}");
    assert_eq!(entries(&cache), before);
    motion.build(&b, &alone);
    assert!(std::fs::read(a).expect("a bundle") == std::fs::read(b).expect("a bundle"));
    let mut of_build = entries(&alone);
    let refused = before.iter().filter(|(name, _)| name.starts_with("refused-"));
    of_build.extend(refused.map(|(name, bytes)| (name.clone(), bytes.clone())));
    assert!(before == of_build, "{:?}, {:?}", before.keys(), of_build.keys());
}

#[test]
fn wrong_shares_are_refused() {
    let motion = Motion::new();
    for bad in ["3/3", "-1/3", "1", "a/b", "0/0", ""] {
        let args = ["bake", &motion.config, "--shard", bad];
        assert_eq!(throng(&args).status.code(), Some(2), "{bad}");
    }
    let told = failed(&["bake", &motion.config, "--shard", "0/2", "--no-cache"]);
    assert!(told.contains("without --no-cache"), "{told}");
    let told = failed(&["bake", concat!(env!("CARGO_MANIFEST_DIR"), "/data/boxing.toml"), "--shard", "0/2"]);
    assert!(told.contains("throng synth") && told.contains("boxing.toml"), "{told}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, ..ProptestConfig::default() })]

    #[test]
    fn order_failures_and_company_change_nothing(
        count in 1usize..6,
        order in prop::collection::vec(0usize..6, 0..6),
        killed in prop::option::of(0usize..6),
    ) {
        let (motion, elsewhere) = (Motion::new(), folder());
        let (cache, plain) = (at(&elsewhere, "cache"), at(&elsewhere, "plain"));
        let all = |cache: &str| (0..2 * count).for_each(|i| _ = motion.bake(&format!("{}/{count}", i % count), cache));
        for i in order {
            // Two at once on the same files, and one that is ended at some moment.
            let shard = format!("{}/{count}", i % count);
            let args = ["bake", &motion.config, "--shard", &shard, "--cache", &cache];
            let start = || std::process::Command::new(env!("CARGO_BIN_EXE_throng"))
                .args(args)
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null())
                .spawn()
                .expect("the command line starts");
            let (mut a, mut b) = (start(), start());
            if killed == Some(i) {
                a.kill().expect("a process that runs");
            }
            _ = a.wait().expect("an end");
            prop_assert!(b.wait().expect("an end").success());
        }
        all(&cache);
        all(&plain);
        prop_assert!(entries(&cache) == entries(&plain));
        prop_assert!(motion.bake("0/1", &cache)["read"] == 0);
    }
}
