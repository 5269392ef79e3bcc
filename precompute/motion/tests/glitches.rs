//! Faults put into motion are found, and good motion is left alone.

use crate::mocap::recording;
use crate::rigs::{rig, tables};
use glam::{Quat, Vec3};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use throng_core::Joint;
use throng_motion::import::profile::{Profile, load_profiles};
use throng_motion::import::{
    Glitch, GlitchKind, GlitchTreatment, Glitches, ImportConfig, ImportedClip, SourceClip, bvh, expand, interpret,
    read_source,
};
use throng_motion::raw::RawClip;
use throng_motion::retarget::{RetargetConfig, retarget_clips};

/// Numbers by chance, the same for the same seed.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0 >> 33
    }

    fn below(&mut self, n: usize) -> usize {
        self.next() as usize % n
    }

    fn unit(&mut self) -> Vec3 {
        let mut part = || self.below(2001) as f32 / 1000.0 - 1.0;
        Vec3::new(part(), part(), part()).normalize_or(Vec3::X)
    }
}

const KINDS: [&str; 13] = [
    "pop 5 m",
    "pop 1 m",
    "pop 0.3 m",
    "pop 0.5 m, 3 frames",
    "teleport 1 m",
    "teleport 0.5 m",
    "freeze 0.4 s",
    "T-pose first frame",
    "T-pose 3 frames",
    "flip 180",
    "flip 120, 2 frames",
    "drop-out",
    "end frozen 0.5 s",
];

/// Puts a fault into a clip; returns its frames.
fn inject(source: &mut SourceClip, clean: &ImportedClip, kind: &str, chance: &mut Chance) -> Range<usize> {
    let clip = &mut source.clip;
    let (n, frames) = (clip.joints.len(), clip.num_frames);
    let hips = clean.roles.get(Joint::Hips).unwrap();
    let root = std::iter::successors(Some(hips), |&j| clip.joints[j].parent).last().unwrap();
    let at = 8 + chance.below(frames - 30);
    let metres = |m: f32, chance: &mut Chance| chance.unit() * m / clean.metres_per_unit as f32;
    let seconds = |s: f64| (s * clip.rate_hz).round() as usize;
    let copy = |clip: &mut RawClip, from: usize, to: usize| {
        clip.translations.copy_within(from * n..(from + 1) * n, to * n);
        clip.rotations.copy_within(from * n..(from + 1) * n, to * n);
    };
    match kind {
        "pop 5 m" | "pop 1 m" | "pop 0.3 m" | "pop 0.5 m, 3 frames" => {
            let (far, long) = match kind {
                "pop 5 m" => (5.0, 1),
                "pop 1 m" => (1.0, 1),
                "pop 0.3 m" => (0.3, 1),
                _ => (0.5, 3),
            };
            let by = metres(far, chance);
            (at..at + long).for_each(|f| clip.translations[f * n + root] += by);
            at..at + long
        }
        "teleport 1 m" | "teleport 0.5 m" => {
            let by = metres(if kind == "teleport 1 m" { 1.0 } else { 0.5 }, chance);
            (at..frames).for_each(|f| clip.translations[f * n + root] += by);
            at - 1..at + 1
        }
        "freeze 0.4 s" => {
            let long = seconds(0.4).min(frames - at - 8);
            (at..at + long).for_each(|f| copy(clip, at - 1, f));
            at..at + long
        }
        "T-pose first frame" | "T-pose 3 frames" => {
            let long = if kind == "T-pose 3 frames" { 3 } else { 1 };
            (0..long * n).for_each(|k| clip.rotations[k] = Quat::IDENTITY);
            0..long
        }
        "flip 180" | "flip 120, 2 frames" => {
            use Joint::*;
            let limbs = [LeftUpperArm, RightForearm, LeftThigh, RightShin, RightUpperArm, LeftForearm, Spine];
            let j = limbs[chance.below(limbs.len())];
            let j = clean.roles.get(j).or(clean.roles.get(UpperChest)).unwrap();
            let (angle, long) = if kind == "flip 180" { (std::f32::consts::PI, 1) } else { (2.094, 2) };
            let turn = Quat::from_axis_angle(chance.unit(), angle);
            (at..at + long).for_each(|f| clip.rotations[f * n + j] *= turn);
            at..at + long
        }
        "drop-out" => {
            let long = 1 + chance.below(5);
            for f in at..at + long {
                clip.translations[f * n + root] = Vec3::ZERO;
                (0..n).for_each(|j| clip.rotations[f * n + j] = Quat::IDENTITY);
            }
            at..at + long
        }
        _ => {
            let start = frames - seconds(0.5).min(frames / 2);
            (start..frames).for_each(|f| copy(clip, start - 1, f));
            start..frames
        }
    }
}

fn read(source: &SourceClip, how: Glitches, profiles: &[Profile]) -> ImportedClip {
    interpret(source.clone(), &ImportConfig { glitches: how, ..ImportConfig::default() }, profiles).unwrap()
}

fn touches(g: &Glitch, frames: &Range<usize>) -> bool {
    g.frames.start <= frames.end && frames.start <= g.frames.end
}

/// Folder and path of recordings.
fn recordings() -> Vec<(String, PathBuf)> {
    let folders =
        ["cmu-asfamc/01", "cmu-asfamc/02", "cmu-asfamc/03", "snu/single", "snu/session23", "snu/multi", "bandai-1"];
    let mut out = Vec::new();
    for folder in folders {
        let paths = expand(&Vec::from_iter(recording(folder))).unwrap();
        out.extend(paths.into_iter().map(|path| (folder.to_owned(), path)));
    }
    out
}

#[test]
fn faults_put_into_captured_clips_are_found() {
    let profiles = load_profiles(&[]).unwrap();
    let mut chance = Chance(std::env::var("THRONG_SEED").map_or(11, |s| s.parse().unwrap()));
    let mut files: Vec<PathBuf> = recordings().into_iter().map(|(_, path)| path).collect();
    // Kind: put in, found, false alarms.
    let mut table: BTreeMap<usize, [usize; 3]> = BTreeMap::new();
    let mut missed = Vec::new();
    let mut clips = 0;
    while clips < 30 && !files.is_empty() {
        let path = files.swap_remove(chance.below(files.len()));
        let source = read_source(&path, None).unwrap().swap_remove(0);
        if source.clip.num_frames < 60 {
            continue;
        }
        let clean = read(&source, Glitches::Keep, &profiles);
        // A clip of a single pose has no motion to put faults into.
        if clean.clip.world(20) == clean.clip.world(40) {
            continue;
        }
        clips += 1;
        for (k, kind) in KINDS.iter().enumerate() {
            let own = |frames: &Range<usize>| {
                let near = frames.start.saturating_sub(15)..frames.end + 15;
                clean.glitches.iter().any(|g| touches(g, &near))
            };
            // Not where the recording has faults of its own, if that can be helped.
            let put = (0..20).map(|_| {
                let mut faulty = source.clone();
                let frames = inject(&mut faulty, &clean, kind, &mut chance);
                (faulty, frames)
            });
            let (faulty, frames) = put.reduce(|a, b| if own(&a.1) { b } else { a }).unwrap();
            let found = read(&faulty, Glitches::Keep, &profiles).glitches;
            let row = table.entry(k).or_default();
            row[0] += 1;
            if found.iter().any(|g| touches(g, &frames)) {
                row[1] += 1;
            } else {
                missed.push(format!("{kind}: {} {frames:?}", clean.clip.name));
            }
            row[2] += found
                .iter()
                .filter(|g| !touches(g, &frames) && !clean.glitches.iter().any(|c| touches(c, &g.frames)))
                .count();
        }
    }
    for (k, [put, found, false_alarms]) in &table {
        let precision = *found as f64 / (found + false_alarms).max(1) as f64;
        println!("{:<22} put {put:>3}  recall {:.2}  precision {precision:.2}", KINDS[*k], *found as f64 / *put as f64);
    }
    println!("missed:\n{}", missed.join("\n"));
    for (k, [put, found, false_alarms]) in table {
        assert!(
            found * 10 >= put * 8 && false_alarms * 20 <= put,
            "{}: {found} of {put}, {false_alarms} false",
            KINDS[k]
        );
    }
}

#[test]
fn captured_motion_is_left_alone_but_for_its_own_faults() {
    let profiles = load_profiles(&[]).unwrap();
    // Folder: clips, frames, glitches, frames of them, frames that are cut.
    let mut table: BTreeMap<String, [usize; 5]> = BTreeMap::new();
    for (folder, path) in recordings() {
        let i = read(&read_source(&path, None).unwrap()[0], Glitches::Bridge, &profiles);
        let row = table.entry(folder).or_default();
        row[0] += 1;
        row[1] += i.clip.num_frames;
        for g in &i.glitches {
            println!("{} {:?} {:?} {} {}", i.clip.name, g.frames, g.kind, g.treated.name(), g.what);
            row[2] += 1;
            row[3] += g.frames.len();
            row[4] += if g.treated == GlitchTreatment::Cut { g.frames.len() } else { 0 };
        }
    }
    for (folder, [clips, frames, glitches, wrong, cut]) in table {
        println!(
            "{folder:<15} {clips:>3} clips {frames:>6} frames: {glitches} glitches, {wrong} frames, {cut} cut out"
        );
        assert!(cut * 200 < frames, "{folder}: {cut} of {frames} frames are cut out");
    }
}

/// A walking rig, clean.
fn walking() -> SourceClip {
    let table = tables::RIGS.iter().find(|(name, _)| *name == "Mixamo").unwrap().1;
    bvh::parse(rig::bvh(&rig::parse(table), &rig::Style::default()).as_bytes(), Path::new("a.bvh")).unwrap()
}

#[test]
fn faults_put_into_a_walking_rig_are_found_told_and_mended() {
    let source = walking();
    let clean = read(&source, Glitches::Keep, &[]);
    assert_eq!(clean.glitches, []);
    let mut chance = Chance(5);
    for kind in KINDS {
        let mut faulty = source.clone();
        let frames = inject(&mut faulty, &clean, kind, &mut chance);
        for how in [Glitches::Keep, Glitches::Bridge, Glitches::Cut] {
            let found = read(&faulty, how, &[]);
            let is_told = |g: &Glitch| touches(g, &frames) && (kind != "drop-out" || g.kind == GlitchKind::DropOut);
            assert!(found.glitches.iter().any(is_told), "{kind} {frames:?}: {:?}", found.glitches);
            assert!(
                found.warnings.messages.iter().any(|w| w.contains("a.bvh") && w.contains("`import.glitches`")),
                "{kind}"
            );
            let cut = found.glitches.iter().filter(|g| g.treated == GlitchTreatment::Cut).count();
            assert!(if how == Glitches::Keep {
                cut == 0
            } else {
                how == Glitches::Bridge || cut == found.glitches.len()
            });
            let set = retarget_clips(std::slice::from_ref(&found), &RetargetConfig::default(), &mut Default::default())
                .unwrap();
            assert_eq!(set.clips[0].excluded.len(), cut, "{kind}");
            // What is used moves as a body does.
            if how != Glitches::Keep {
                let clip = &set.clips[0];
                for range in clip.usable_ranges() {
                    for f in range.start + 1..range.end {
                        let speed = clip.root_positions[f].distance(clip.root_positions[f - 1]) * 30.0;
                        assert!(speed < 4.0, "{kind}, {how:?}, frame {f}: {speed} m/s");
                    }
                }
            }
        }
    }
}

#[test]
fn a_pop_is_bridged_by_what_the_clip_was() {
    let source = walking();
    let clean = read(&source, Glitches::Keep, &[]);
    let mut faulty = source.clone();
    let frames = inject(&mut faulty, &clean, "pop 5 m", &mut Chance(3));
    let mended = read(&faulty, Glitches::Bridge, &[]);
    assert!(
        mended.glitches[0].treated == GlitchTreatment::Bridged && mended.glitches[0].frames == frames,
        "{:?}",
        mended.glitches
    );
    for f in 0..clean.clip.num_frames {
        for (a, b) in clean.clip.world(f).iter().zip(mended.clip.world(f)) {
            assert!(a.0.distance(b.0) < 1e-3, "frame {f}");
        }
    }
}

#[test]
fn frames_that_are_there_twice_are_filled_with_what_is_between_their_neighbours() {
    let source = walking();
    let clean = read(&source, Glitches::Keep, &[]);
    let (n, frames) = (source.clip.joints.len(), source.clip.num_frames);
    // Every frame twice, at twice the rate; each third one twice; one alone.
    let cases: [(&str, &dyn Fn(usize) -> usize); 3] =
        [("all", &|_| 2), ("third", &|f| 1 + usize::from(f % 3 == 1)), ("one", &|f| 1 + usize::from(f == 20))];
    for (name, times) in cases {
        let mut faulty = source.clone();
        let played: Vec<usize> = (0..frames).flat_map(|f| std::iter::repeat_n(f, times(f))).collect();
        let of = |f: &usize| f * n..(f + 1) * n;
        faulty.clip.translations = played.iter().flat_map(|f| source.clip.translations[of(f)].to_vec()).collect();
        faulty.clip.rotations = played.iter().flat_map(|f| source.clip.rotations[of(f)].to_vec()).collect();
        faulty.clip.num_frames = played.len();
        if name == "all" {
            faulty.clip.rate_hz *= 2.0;
        }
        let put: Vec<usize> = (1..played.len()).filter(|&f| played[f] == played[f - 1]).collect();
        let mended = read(&faulty, Glitches::Bridge, &[]);
        let inner = put.iter().filter(|&&f| f + 1 < played.len());
        assert!(mended.glitches.iter().map(|g| &g.frames.start).eq(inner), "{name}: {:?}", mended.glitches);
        assert!(mended.glitches.iter().all(|g| g.kind == GlitchKind::Repeat && g.treated == GlitchTreatment::Bridged));
        let told = &mended.warnings.messages;
        assert!(told.len() == 1 && told[0].contains("the one before"), "{name}: {told:?}");
        assert_eq!(told[0].contains("a take of 30 Hz in a file of 60 Hz"), name == "all", "{told:?}");
        assert!(told[0].contains("are bridged (`import.glitches`)"), "{told:?}");
        // The hips go on at every frame, half way where they stood.
        for &f in put.iter().filter(|&&f| f + 1 < played.len()) {
            let at = |clip: &RawClip, f: usize| clip.world(f)[clean.roles.get(Joint::Hips).unwrap()].0;
            let between = at(&clean.clip, played[f]).midpoint(at(&clean.clip, played[f + 1]));
            assert!(at(&mended.clip, f).distance(between) < 1e-4, "{name}, frame {f}");
        }
    }
    // Who stands still repeats nothing.
    let mut still = source.clone();
    let pose = (source.clip.translations[..n].to_vec(), source.clip.rotations[..n].to_vec());
    (still.clip.translations, still.clip.rotations) = (pose.0.repeat(frames), pose.1.repeat(frames));
    assert_eq!(read(&still, Glitches::Bridge, &[]).glitches, []);
}

#[test]
fn a_frame_in_which_an_elbow_is_turned_by_40_degrees_is_found_and_mended() {
    let source = walking();
    let clean = read(&source, Glitches::Keep, &[]);
    let n = source.clip.joints.len();
    for role in [Joint::LeftForearm, Joint::RightForearm, Joint::LeftUpperArm, Joint::RightShin, Joint::LeftThigh] {
        let j = clean.roles.get(role).unwrap();
        for f in [9, 23, 40, 51] {
            let mut faulty = source.clone();
            faulty.clip.rotations[f * n + j] *= Quat::from_rotation_x(40f32.to_radians());
            let mended = read(&faulty, Glitches::Bridge, &[]);
            let found: Vec<_> = mended.glitches.iter().map(|g| (g.frames.clone(), g.treated)).collect();
            assert_eq!(found, [(f..f + 1, GlitchTreatment::Bridged)], "{} {f}", role.name());
            let apart = mended.clip.rotations[f * n + j].angle_between(clean.clip.rotations[f * n + j]);
            assert!(apart < 0.05, "{} {f}: {apart}", role.name());
        }
    }
}
