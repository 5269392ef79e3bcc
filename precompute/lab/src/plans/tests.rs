//! Tasks whose characters walk: one bundle is built for all of it.

use super::*;
use crate::run::{BuildContext, News};
use std::path::PathBuf;
use throng_bake::cache::Cache;
use throng_bake::config::BuildConfig;
use throng_motion::progress::Silent;

const TABLE: &str = r#"
[[scene.obstacles]]
name = "table"
shape = { box = { size = [0.7, 0.04, 0.5] } }
at = [0.3, 0.78, 0.6]

[[scene.objects]]
name = "bottle"
shape = { capsule = { from = [0.0, -0.08, 0.0], to = [0.0, 0.08, 0.0], radius = 0.035 } }
at = [0.25, 0.916, 0.45]

[[tasks]]
limb = "right_arm"
do = "touch"
object = "bottle"
grips = [{ at = [0.0, 0.02, -0.07] }]
"#;

/// A task file beside which the walker's bundle is built when it is first asked for.
fn sources_of(folder: &Path, walk: &str, rest: &str) -> Result<(Task, TaskSources), String> {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/walker.toml");
    let clip = format!("[clip]\nwalk = {{ bundle = \"w.throng\", config = \"{}\", {walk} }}\n{rest}", config.display());
    let task = Task::parse(&clip, &folder.join("t.toml")).map_err(|e| e.to_string())?;
    let tell = |news| assert!(!matches!(news, News::NotMade(..)), "{news}");
    let with = BuildContext { cache: &Cache::disabled(), progress: &Silent, report_news: &tell };
    let config = BuildConfig::of_motion("", Vec::new()).map_err(|e| e.to_string())?;
    let sources = load_sources(&task, &config, None, &with).map_err(|e| e.to_string())?;
    Ok((task, sources))
}

#[test]
fn who_walks_comes_to_where_its_hand_reaches_and_keeps_to_its_pace() {
    let folder = tempfile::tempdir().expect("a folder");
    let (task, sources) = sources_of(folder.path(), "from = [-0.4, -2.4]", TABLE).expect("a walker");
    assert!(task.needs_walking() && task.times_s() == [None]);
    assert_eq!(sources.files, [folder.path().join("w.throng")]);
    let (walked, clips) = sources.stage_task(task.clone(), None).expect("a place to stand");
    let [Some([from_s, at_s, to_s])] = walked.windows_s()[..] else { panic!("{:?}", walked.windows_s()) };
    let clip = &clips[0].clip;
    let place = |t: f64| clip.root_positions[(t * clip.rate_hz).round() as usize].as_dvec3();
    assert!(from_s < at_s && at_s < to_s && to_s <= (clip.num_frames() - 1) as f64 / clip.rate_hz);
    let far = |t: f64| (place(t) - glam::DVec3::new(0.25, place(t).y, 0.45)).length();
    assert!(far(0.0) > 2.5 && far(at_s) < 0.75, "{} {}", far(0.0), far(at_s));
    // It stands there while the hand is at the bottle, beside the table.
    assert!((place(at_s) - place(at_s + 0.2)).length() < 0.02);
    let on_table = |p: glam::DVec3| (p.x - 0.3).abs() < 0.35 + 0.1 && (p.z - 0.6).abs() < 0.25 + 0.1;
    assert!(clip.root_positions.iter().all(|p| !on_table(p.as_dvec3())));
    let found = variants(&walked, &clips, 1, &RunOptions::default()).expect("clips");
    let report = plan_report(&walked, &found).expect("an outcome");
    assert!(report.solved && report.recheck_violations == 0, "{:?}", report.tasks);
    assert_eq!(report.tasks[0].at_s, Some(at_s));
    // The same again, and elsewhere where the bottle is.
    let (again, same) = sources.stage_task(task.clone(), None).expect("a place to stand");
    assert!(again.windows_s() == walked.windows_s() && same == clips);
    let out = folder.path().join("out.bvh");
    let files = write_plan(&walked, &clips, &found[0].1, &out, 1).expect("files");
    let names = ["out-2.bvh", "out-2.objects.json"].map(|n| folder.path().join(n));
    assert_eq!(files, names.map(PathBuf::from));

    let far_away = TABLE.replace("at = [0.25, 0.916, 0.45]", "at = [0.25, 3.2, 0.45]");
    let (task, sources) = sources_of(folder.path(), "from = [-0.4, -2.4]", &far_away).expect("a walker");
    let why = sources.stage_task(task, None).expect_err("out of reach").to_string();
    assert!(why.contains("right_arm touch bottle"), "{why}");
    let (task, sources) = sources_of(folder.path(), "from = [9999.0, 0.0]", TABLE).expect("a walker");
    let why = sources.stage_task(task, None).expect_err("a walk of hours").to_string();
    assert!(why.contains("m away, expected 200 m at most"), "{why}");

    let timed = format!("{TABLE}at_s = 3.0\nwindow_s = [2.0, 4.0]\n");
    let pace = "space = \"walk_to_run\", from = [3.0, 0.0], heading_deg = 90.0, \
                pace = [{ t_s = 0.0, speed_mps = 1.2 }, { t_s = 1.0, speed_mps = 1.2 }, { t_s = 3.0, speed_mps = 3.2 }, \
                { t_s = 5.0, speed_mps = 3.2 }]";
    let (task, sources) = sources_of(folder.path(), pace, &timed).expect("a runner");
    let (_, clips) = sources.stage_task(task, None).expect("a run");
    let clip = &clips[0].clip;
    assert!(((clip.num_frames() - 1) as f64 / clip.rate_hz - 5.0).abs() < 1e-6);
    let at = |t: f64| clip.root_positions[(t * clip.rate_hz).round() as usize].as_dvec3();
    // 1.2 m in the first second, 4.4 m in the next two, 6.4 m in the last two; hips sway.
    for (t, x) in [(0.0, 3.0), (1.0, 4.2), (3.0, 8.6), (5.0, 15.0)] {
        assert!((at(t).x - x).abs() < 0.12 && at(t).z.abs() < 0.1, "{t}: {}", at(t));
    }
    let why = sources_of(folder.path(), pace, TABLE).expect_err("no times");
    assert!(why.contains("expected `at_s` and `window_s`"), "{why}");
    let wrong = sources_of(folder.path(), "space = \"swim\"", TABLE).expect_err("no such space");
    assert!(wrong.contains("`main`") && wrong.contains("swim"), "{wrong}");
}
