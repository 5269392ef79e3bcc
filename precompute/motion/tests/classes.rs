//! Classes of captured motion whose names say what it is: a table of what was found against them. Skipped where the recordings
//! are absent.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use throng_motion::annotate::classes::{ClassSpan, Gait, Posture};
use throng_motion::clip::{Clip, ClipSet};
use throng_motion::error::Warnings;
use throng_motion::progress::Silent;
use throng_motion::resample::ResampleConfig;
use throng_motion::{annotate, import, resample, retarget};

/// Clips of a folder of recordings; none where it is absent.
fn clips_of(folder: &str) -> Option<ClipSet> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/mocap").join(folder);
    if !path.is_dir() {
        println!("skipped: {} is absent", path.display());
        return None;
    }
    let set = import::read(&[path], &Default::default(), &Silent).expect("recordings");
    let mut warnings = Warnings::default();
    let clips = retarget::retarget_clips(&set.clips, &Default::default(), &mut warnings).expect("one body");
    let cfg = ResampleConfig { mirror: false, ..Default::default() };
    let clips = resample::resample(&clips, &cfg).expect("one rate");
    Some(annotate::annotate(&clips, &Default::default(), &Default::default()).expect("annotated"))
}

/// Share of the usable frames of clips for whose spans something holds.
fn share<'a>(clips: impl Iterator<Item = &'a Clip>, holds: impl Fn(&ClassSpan) -> bool) -> f64 {
    let (mut all, mut found) = (0, 0);
    for clip in clips {
        for f in clip.usable_ranges().into_iter().flatten() {
            let at = clip.classes.partition_point(|s| s.frames.end as usize <= f);
            all += 1;
            found += usize::from(holds(&clip.classes[at]));
        }
    }
    f64::from(found as u32) / f64::from((all as u32).max(1))
}

const GAITS: [Gait; 7] = [Gait::Stand, Gait::Walk, Gait::Run, Gait::Sneak, Gait::Strafe, Gait::Backwards, Gait::Other];

/// Prints a row for each name: shares of the gaits, of postures other than upright, of neutral standing and of carrying.
fn print_table(set: &ClipSet, name: impl Fn(&Clip) -> String) {
    let mut by = BTreeMap::<String, Vec<&Clip>>::new();
    set.clips.iter().for_each(|c| by.entry(name(c)).or_default().push(c));
    let gaits: Vec<_> = GAITS.iter().map(|g| format!("{:>6}", &g.name()[..g.name().len().min(6)])).collect();
    println!("{:24} {}   crou   seat   lyin   neut   carr  manners", "", gaits.join(" "));
    for (name, clips) in by {
        let of = |holds: &dyn Fn(&ClassSpan) -> bool| share(clips.iter().copied(), holds) * 100.0;
        let mut row: Vec<f64> = GAITS.iter().map(|g| of(&|s| s.class.gait == *g)).collect();
        let postures = [Posture::Crouched, Posture::Seated, Posture::Lying];
        row.extend(postures.iter().map(|p| of(&|s| s.class.posture == *p)));
        row.extend([of(&|s| s.class.neutral), of(&|s| s.class.carrying)]);
        let row: Vec<_> = row.iter().map(|v| format!("{v:6.1}")).collect();
        let mut manners: Vec<&str> =
            clips.iter().flat_map(|c| &c.classes).map(|s| s.class.manner.as_str()).filter(|m| !m.is_empty()).collect();
        manners.sort_unstable();
        manners.dedup();
        println!("{name:24} {}  {}", row.join(" "), manners.join(" "));
    }
}

fn stem(clip: &Clip) -> String {
    PathBuf::from(&clip.source).file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

#[test]
fn gaits_of_bandai_are_those_of_their_names() {
    let Some(set) = clips_of("bandai-1") else { return };
    let action = |c: &Clip| stem(c).split('_').nth(1).unwrap_or_default().to_owned();
    print_table(&set, action);
    let of =
        |name: &str, holds: &dyn Fn(&ClassSpan) -> bool| share(set.clips.iter().filter(|c| action(c) == name), holds);
    for (names, gait, least) in [
        (&["walk"][..], Gait::Walk, 0.9),
        (&["run", "dash"], Gait::Run, 0.9),
        (&["walk-back"], Gait::Backwards, 0.95),
        (&["walk-left", "walk-right"], Gait::Strafe, 0.8),
        (&["bow", "bye", "byebye", "guide", "call", "respond"], Gait::Stand, 0.85),
        (&["punch", "kick"], Gait::Stand, 0.6),
    ] {
        for name in names {
            let found = of(name, &|s| s.class.gait == gait);
            assert!(found >= least, "{name}: {found:.3} is {}, expected {least}", gait.name());
        }
    }
    for name in ["walk", "walk-back", "run", "bye", "bow"] {
        assert!(of(name, &|s| s.class.posture == Posture::Upright) > 0.97, "{name} is upright");
    }
    // Most clips of waving begin and end with raised arms, those of bows at ease.
    let [waves, bows] = ["byebye", "bow"].map(|name| of(name, &|s| !s.class.neutral));
    assert!(waves > 0.8 && (0.2..0.8).contains(&bows), "gestures: {waves:.3} of waving, {bows:.3} of bows");
    assert!(share(set.clips.iter(), |s| s.class.carrying) < 0.03, "nobody carries anything");
    for c in &set.clips {
        let name = stem(c).split('_').nth(2).unwrap_or_default().to_owned();
        let expected = if name == "normal" { "" } else { &name };
        assert!(c.classes.iter().all(|s| s.class.manner == expected), "{}: its manner is {name}", c.name);
    }
}

#[test]
fn classes_of_other_studios_are_those_of_their_names() {
    let (Some(snu), Some(cmu)) = (clips_of("snu/single"), clips_of("cmu-asfamc")) else { return };
    print_table(&snu, stem);
    print_table(&cmu, stem);
    let of = |set: &ClipSet, start: &str, holds: &dyn Fn(&ClassSpan) -> bool| {
        share(set.clips.iter().filter(|c| stem(c).starts_with(start)), holds)
    };
    let goes = |s: &ClassSpan| !matches!(s.class.gait, Gait::Stand | Gait::Other);
    for (start, holds, least) in [
        ("chair", &(|s: &ClassSpan| s.class.posture == Posture::Seated) as &dyn Fn(&ClassSpan) -> bool, 0.15),
        ("walk_crawl", &|s| s.class.posture == Posture::Lying, 0.2),
        ("walk_straight", &|s| s.class.gait == Gait::Walk, 0.6),
        ("walk_left_90", &|s| s.class.gait == Gait::Walk, 0.6),
        ("run_straight", &|s| s.class.gait == Gait::Run, 0.3),
        ("jump_high", &|s| s.class.gait == Gait::Other, 0.1),
        ("move_two", &|s| s.class.carrying, 0.1),
    ] {
        let found = of(&snu, start, holds);
        assert!(found >= least, "{start}: {found:.3}, expected {least}");
    }
    assert!(of(&snu, "walk_straight", &|s| s.class.carrying) < 0.03);
    let of_going = |set: &ClipSet, start: &str, gait: Gait| {
        of(set, start, &|s| s.class.gait == gait) / of(set, start, &goes).max(1e-9)
    };
    for (start, gait, least) in
        [("02_01", Gait::Walk, 0.9), ("02_02", Gait::Walk, 0.9), ("02_03", Gait::Run, 0.8), ("03_", Gait::Walk, 0.8)]
    {
        let found = of_going(&cmu, start, gait);
        assert!(found >= least, "{start}: {found:.3} of its going is {}, expected {least}", gait.name());
    }
    assert!(of(&cmu, "02_04", &|s| s.class.gait == Gait::Other) > 0.1, "it jumps");
}
