//! The start page and builds in the window, driven as people drive them: motion is dropped, built, stopped, refused.

mod common;

use crate::common::paces::Paces;
use crate::common::{Viewing, bvh, drop_files, golden};
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use throng_precompute::run::News;
use throng_viewer::command::ViewerCommand;
use throng_viewer::document::{BuildEnd, FinishedBuild, OpenDocument, ShownBuild};

/// The viewer on its start page, in a folder of its own for the cache, and a file that is there whatever the folder.
fn start() -> (Viewing, PathBuf) {
    static GOLDEN: OnceLock<PathBuf> = OnceLock::new();
    let golden = GOLDEN.get_or_init(|| {
        let golden = golden().canonicalize().expect("the golden bundle");
        let folder = tempfile::tempdir().expect("a folder").keep();
        std::env::set_current_dir(folder).expect("a folder to be in");
        golden
    });
    (Viewing::empty(), golden.clone())
}

fn ended(v: &Viewing) -> Option<&FinishedBuild> {
    match &v.model().build {
        Some(ShownBuild::Ended(built)) => Some(built.as_ref()),
        _ => None,
    }
}

/// A folder with so many minutes of walking.
fn walks(minutes: f64) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let clips = folder.path().join("walks");
    std::fs::create_dir(&clips).expect("a folder in it");
    common::walk(&clips, minutes);
    (folder, clips)
}

#[test]
fn a_dropped_folder_is_built_told_judged_and_run() {
    let (mut v, _) = start();
    let (_folder, clips) = walks(1.0);
    drop_files(&mut v, &[&clips]);
    v.until("the build", |v| v.model().building().is_some());
    v.harness.step();
    v.harness.get_by_label("Building walks");
    v.harness.get_by_label("Cancel");
    v.until("the bundle", |v| v.model().document.bundle().is_some());
    let built = ended(&v).expect("a record").clone();
    assert_eq!((&built.end, &*built.paths), (&BuildEnd::Done, &[clips.clone()][..]));
    let made = built.log.news.iter().any(|n| matches!(n, News::Made(what) if what.contains("policies")));
    assert!(made, "{:?}", built.log.news);
    let verdict = built.log.verdict.expect("characters go to targets");
    let is_reach = |s: &String| s.contains("of the targets were reached");
    assert!(verdict.sentences.iter().any(is_reach), "{verdict:?}");
    v.harness.run_steps(3);
    v.harness.get_by_label("Built walks");
    v.harness.get_by_label_contains("of the targets were reached");
    assert!(v.model().num_characters() > 0 && v.model().is_playing());
    assert_eq!((&*v.model().asked, &v.model().settings.opened[0]), (&[clips.clone()][..], &vec![clips.clone()]));

    // It is there at once when it is opened again; what is not reached any more is told anew.
    v.apply(ViewerCommand::Close);
    v.harness.run_steps(2);
    v.harness.get_by_label("Demonstrations");
    v.apply(ViewerCommand::Open(vec![clips]));
    v.until("the bundle again", |v| v.model().document.bundle().is_some());
    let again = ended(&v).expect("a record");
    let is_built = again.log.news.iter().any(|n| matches!(n, News::Made(_) | News::Making(_)));
    assert!(!is_built && again.log.verdict.is_some(), "{again:?}");
    v.apply(ViewerCommand::DismissBuild);
    v.harness.run_steps(2);
    assert!(v.harness.query_by_label("Built walks").is_none());
}

#[test]
fn a_build_that_is_stopped_says_what_is_kept_and_goes_on_when_it_is_asked_for_again() {
    let (mut v, _) = start();
    let (_folder, clips) = walks(3.0);
    drop_files(&mut v, &[&clips]);
    v.until("the build", |v| v.model().building().is_some());
    v.harness.step();
    v.harness.get_by_label("Cancel").click();
    v.until("its end", |v| ended(v).is_some());
    let built = ended(&v).expect("a record").clone();
    let BuildEnd::Stopped(why) = built.end else { panic!("{built:?}") };
    assert!(why.contains(".throng-cache keeps") && why.contains("opening it again"), "{why}");
    assert!(matches!(v.model().document, OpenDocument::Nothing));
    v.harness.run_steps(2);
    v.harness.get_by_label("Stopped building walks");
    v.harness.get_by_label("Try again").click();
    v.until("the bundle", |v| v.model().document.bundle().is_some());
}

#[test]
fn what_cannot_be_built_is_said_in_whole_and_the_page_stays_usable() {
    let (mut v, golden) = start();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("notes.txt"), "no motion").expect("a file");
    drop_files(&mut v, &[folder.path()]);
    v.until("its end", |v| ended(v).is_some());
    let BuildEnd::Failed(why) = ended(&v).expect("a record").end.clone() else { panic!("{:?}", v.model().build) };
    assert!(why.contains(&*folder.path().to_string_lossy()), "{why}");
    v.harness.run_steps(2);
    v.harness.get_by_label(&why);
    v.harness.get_by_label("Try again");
    // Torn motion is left out with file and line, and nothing is left.
    std::fs::write(folder.path().join("torn.bvh"), "HIERARCHY\nROOT").expect("a file");
    drop_files(&mut v, &[folder.path()]);
    v.until(
        "its end",
        |v| matches!(ended(v), Some(FinishedBuild { end: BuildEnd::Failed(why), .. }) if why.contains("torn.bvh")),
    );
    // Scenes and motion do not go together.
    drop_files(&mut v, &[&golden, folder.path()]);
    v.until("a message", |v| v.model().messages.iter().any(|m| m.text.contains("open them one by one")));
    drop_files(&mut v, &[&golden]);
    v.until("the bundle", |v| v.model().document.bundle().is_some());
}

#[test]
fn several_files_are_built_together_and_a_single_clip_is_only_opened() {
    let (mut v, _) = start();
    let (_folder, clips) = walks(1.0);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&clips).expect("clips").map(|e| e.expect("one").path()).collect();
    files.sort();
    let paths: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    assert!(paths.len() > 1);
    drop_files(&mut v, &paths);
    v.until("the bundle", |v| v.model().document.bundle().is_some());
    assert_eq!(v.model().settings.opened[0], files);
    let single = tempfile::tempdir().expect("a folder");
    drop_files(&mut v, &[&bvh(single.path())]);
    v.until("the clip", |v| v.model().document.raw_motion().is_some());
    assert!(v.model().build.is_none(), "{:?}", v.model().build);
}

#[test]
fn a_scene_whose_bundle_is_missing_is_built_from_its_config_in_the_window() {
    let (mut v, _) = start();
    let paces = Paces::new();
    let scene = paces.crowd(4);
    let bundle = paces.bundle();
    std::fs::remove_file(&bundle).expect("the bundle goes");
    drop_files(&mut v, &[&scene]);
    v.until("its end", |v| ended(v).is_some());
    let built = ended(&v).expect("a record");
    let told = built.log.news.iter().any(|n| matches!(n, News::Making(what) if what.contains("paces.throng")));
    assert!(told, "{built:?}");
    assert_eq!(built.end, BuildEnd::Done, "{built:?}");
    assert!(v.model().document.scene().is_some() && bundle.is_file());
}
