//! What sidecars say, and what is wrong with some.

use super::*;
use crate::clip::HitKind;
use glam::{Quat, Vec3};
use throng_core::{Joint, NUM_JOINTS};

fn clip(name: &str, num_frames: usize) -> Clip {
    Clip::new(name, 30.0, vec![Vec3::ZERO; num_frames], vec![Quat::IDENTITY; num_frames * NUM_JOINTS])
}

fn message(r: Result<impl std::fmt::Debug, BuildError>) -> String {
    r.unwrap_err().to_string()
}

#[test]
fn reads_ranges_and_tags_in_seconds_and_frames() {
    let text = "exclude = [[0, 0.5], [2.0, inf]]\n[[tags]]\nname = \"punch\"\nstart = 1\nend = 1.5\n";
    let mut all = Sidecars::default();
    all.insert("a", Sidecar::parse(text, "a.toml").unwrap(), 120.0, Some(Path::new("a.toml"))).unwrap();
    let frames = "unit = \"frames\"\nexclude = [[4, 8]]";
    all.insert("b", Sidecar::parse(frames, "b.toml").unwrap(), 120.0, Some(Path::new("b.toml"))).unwrap();
    let a = all.annotations_of(&Clip { mirrored: true, ..clip("a~mirror", 90) }).unwrap();
    assert_eq!(a.excluded.iter().map(|e| e.range.clone()).collect::<Vec<_>>(), [0..15, 60..90]);
    assert_eq!(a.tags, [ClipTag { name: "punch".into(), range: 30..45 }]);
    assert_eq!(all.annotations_of(&clip("b", 90)).unwrap().excluded[0].range, 1..2);
    assert_eq!(all.annotations_of(&clip("c", 90)).unwrap(), SidecarAnnotations::default());
    // A file may be called as a copy is.
    assert_eq!(all.annotations_of(&clip("a~mirror", 90)).unwrap(), SidecarAnnotations::default());
}

#[test]
fn errors_name_file_line_and_key() {
    let m = message(Sidecar::parse("\nexcludes = []", "x.toml"));
    assert!(m.contains("x.toml:2:") && m.contains("excludes"), "{m}");
    let m = message(Sidecar::parse("exclude = [\n  [0, 1],\n  [3, 2],\n]", "x.toml"));
    assert!(m.contains("x.toml:3:") && m.contains("exclude[1]") && m.contains("[3, 2]"), "{m}");
    let m = message(Sidecar::parse("[[tags]]\nname = \"a\"\nstart = 1\n", "x.toml"));
    assert!(m.contains("x.toml:1:") && m.contains("end"), "{m}");
    let m = message(Sidecar::parse("[[tags]]\nname = \"a\"\nstart = 1\nend = nan", "x.toml"));
    assert!(m.contains("tags[0]") && m.contains("`a`"), "{m}");
}

#[test]
fn refuses_unknown_clips_and_ranges_outside() {
    let mut all = Sidecars::default();
    all.insert("walks", Sidecar { exclude: vec![[9.0, 10.0]], ..Sidecar::default() }, 30.0, Some(Path::new("c.toml")))
        .unwrap();
    let m = message(all.check_names(["walk", "run"].into_iter()));
    assert!(m.contains("`walks`") && m.contains("`walk`"), "{m}");
    let m = message(all.annotations_of(&clip("walks", 30)));
    assert!(m.contains("c.toml") && m.contains("exclude[0]") && m.contains("1.00"), "{m}");
}

#[test]
fn hits_are_read_at_a_moment_or_over_a_range_and_change_sides_in_the_mirror() {
    let text = "automatic_hits = false\n[[hits]]\nname = \"punch\"\njoint = \"right_hand\"\nat = 1.01\n\
        [[hits]]\nname = \"head butt\"\njoint = \"head\"\nstart = 2.0\nend = 2.5\n";
    let mut all = Sidecars::default();
    all.insert("a", Sidecar::parse(text, "a.toml").unwrap(), 120.0, Some(Path::new("a.toml"))).unwrap();
    let marked = all.annotations_of(&clip("a", 90)).unwrap();
    assert!(!marked.automatic_hits);
    let found: Vec<_> = marked.hits.iter().map(|h| (h.kind.clone(), h.joint, h.range.clone())).collect();
    let butt = HitKind::Tag("head butt".into());
    assert_eq!(found, [(HitKind::Punch, Joint::RightHand, 30..31), (butt, Joint::Head, 60..75)]);
    assert_eq!(marked.hits[1].place, SidecarPlace { file: Some("a.toml".into()), key: "hits[1]".into() });
    let mirrored = all.annotations_of(&Clip { mirrored: true, ..clip("a~mirror", 90) }).unwrap();
    assert_eq!(mirrored.hits[0].joint, Joint::LeftHand);
    assert!(all.annotations_of(&clip("b", 90)).unwrap().automatic_hits);
}

#[test]
fn what_is_wrong_with_a_hit_is_named_by_line() {
    let hit = |rest: &str| {
        Sidecar::parse(&format!("[[tags]]\nname = \"a\"\nstart = 0\nend = 1\n\n[[hits]]\n{rest}"), "x.toml")
    };
    let head = "name = \"jab\"\njoint = \"left_hand\"\n";
    let cases = [
        ("name = \"jab\"\njoint = \"left_hnd\"\nat = 1", "there is no joint `left_hnd`. Did you mean `left_hand`?"),
        ("name = \" \"\njoint = \"left_hand\"\nat = 1", "expected a name"),
        (&format!("{head}at = -1"), "`jab`: expected at >= 0, found -1"),
        (&format!("{head}start = 3\nend = 2"), "`jab`: expected 0 <= start < end, found start = 3, end = 2"),
        (&format!("{head}at = 1\nstart = 2\nend = 3"), "expected `at`, or `start` and `end`"),
        (&format!("{head}start = 2"), "expected `at`, or `start` and `end`"),
        (head, "expected `at`, or `start` and `end`"),
    ];
    for (rest, say) in cases {
        let m = message(hit(rest));
        assert!(m.starts_with("x.toml:6:1: hits[0]: ") && m.contains(say), "{m}");
    }
    let m = message(hit("name = \"jab\"\nat = 1"));
    assert!(m.contains("x.toml:6:") && m.contains("joint"), "{m}");
}

#[test]
fn hits_after_the_end_of_the_clip_are_refused() {
    let text = "unit = \"frames\"\n[[hits]]\nname = \"punch\"\njoint = \"left_hand\"\nat = 30";
    let mut all = Sidecars::default();
    all.insert("a", Sidecar::parse(text, "a.toml").unwrap(), 30.0, Some(Path::new("a.toml"))).unwrap();
    let m = message(all.annotations_of(&clip("a", 30)));
    assert!(m.contains("a.toml: hits[0]: starts at 30") && m.contains("after the end of clip `a`"), "{m}");
    assert_eq!(all.annotations_of(&clip("a", 31)).unwrap().hits[0].range, 30..31);
}

#[test]
fn ranges_after_the_end_are_told_with_the_line_of_the_sidecar_or_the_key_of_the_config() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.toml");
    let text = "\n\n[[hits]]\nname = \"punch\"\njoint = \"left_hand\"\nat = 9.0\n";
    std::fs::write(&path, text).unwrap();
    let mut all = Sidecars::default();
    assert!(all.insert_beside("a", &path.with_extension("bvh"), 30.0).unwrap());
    let m = message(all.annotations_of(&clip("a", 30)));
    assert!(m.contains("a.toml:3:1: hits[0]: starts at 9"), "{m}");
    let sidecar = Sidecar::parse(text, "config").unwrap();
    all.insert("a", sidecar.clone(), 30.0, None).unwrap();
    assert!(message(all.annotations_of(&clip("a", 30))).starts_with("clips.a.hits[0]: starts at 9"));
    all.insert("c", sidecar, 30.0, None).unwrap();
    assert!(message(all.check_names(["a"].into_iter())).starts_with("clips.c: there is no clip `c`"));
    let backwards = Sidecar { exclude: vec![[2.0, 1.0]], ..Sidecar::default() };
    assert!(message(all.insert("a", backwards, 30.0, None)).starts_with("clips.a.exclude[0]: expected 0 <= start"));
}
