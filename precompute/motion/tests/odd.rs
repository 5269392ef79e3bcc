//! Motion that is odd as a whole is told before anything is built of it: walks on the spot, noise, two in one file, sizes.

use crate::mocap::recording;
use crate::rigs::{rig, tables};
use glam::{Quat, Vec3};
use std::path::{Path, PathBuf};
use throng_core::Joint;
use throng_motion::error::ImportError;
use throng_motion::import::profile::{Profile, load_profiles};
use throng_motion::import::{ImportConfig, ImportedClip, SourceClip, bvh, expand, interpret, read_clips, read_source};

/// A walking rig.
fn walking() -> SourceClip {
    let table = tables::RIGS.iter().find(|(name, _)| *name == "Mixamo").unwrap().1;
    bvh::parse(rig::bvh(&rig::parse(table), &rig::Style::default()).as_bytes(), Path::new("a.bvh")).unwrap()
}

fn read(source: SourceClip, profiles: &[Profile]) -> ImportedClip {
    interpret(source, &ImportConfig::default(), profiles).unwrap()
}

fn told<'a>(i: &'a ImportedClip, what: &str) -> Option<&'a str> {
    i.warnings.messages.iter().map(String::as_str).find(|w| w.contains(what))
}

/// Takes away how the hips travel over the ground, as exports "in place" do.
///
/// - `sway_s`: keeps what they do beside a mean over so much time (s).
fn put_in_place(source: &mut SourceClip, hips: usize, sway_s: Option<f64>) {
    let clip = &mut source.clip;
    let n = clip.joints.len();
    let path: Vec<Vec3> = (0..clip.num_frames).map(|f| clip.world(f)[hips].0).collect();
    let half = sway_s.map_or(0, |s| (0.5 * s * clip.rate_hz) as usize);
    for f in 0..clip.num_frames {
        let near = &path[f.saturating_sub(half)..(f + half + 1).min(path.len())];
        let mean = near.iter().sum::<Vec3>() / near.len() as f32;
        for j in (0..n).filter(|&j| clip.joints[j].parent.is_none()) {
            clip.translations[f * n + j] -= mean.with_y(0.0);
        }
    }
}

#[test]
fn a_walk_on_the_spot_is_told_and_one_that_goes_is_not() {
    let source = walking();
    let there = read(source.clone(), &[]);
    assert_eq!(told(&there, "on the spot"), None, "{:?}", there.warnings);
    let hips = there.roles.get(Joint::Hips).unwrap();
    for sway in [None, Some(1.0)] {
        let mut treadmill = source.clone();
        put_in_place(&mut treadmill, hips, sway);
        // No foot of this rig stands while it is low: its steps do not agree with any way.
        let kept = read(treadmill.clone(), &[]);
        let said = told(&kept, "on the spot").expect("it walks on the spot");
        assert!(said.starts_with("a.bvh: ") && said.contains("Export it again with root motion"), "{said}");
        assert!(said.contains(" steps a second with the feet "), "{said}");
        let config = ImportConfig { root_motion: false, ..Default::default() };
        let left = interpret(treadmill, &config, &[]).unwrap();
        assert!(told(&left, "`import.root_motion` is false").is_some(), "{:?}", left.warnings);
        assert!(travel(&kept, hips).distance(travel(&left, hips)) < 1e-4, "it stays as it is");
    }
}

/// Way of the hips over the ground from the first frame to the last (m).
fn travel(of: &ImportedClip, hips: usize) -> Vec3 {
    let [from, to] = [0, of.clip.num_frames - 1].map(|f| of.clip.world(f)[hips].0.with_y(0.0));
    to - from
}

/// The cycle of a walk whose ends are most alike, made to meet there.
fn cut_cycle(source: &SourceClip, joints: &[usize]) -> SourceClip {
    let (clip, n) = (&source.clip, source.clip.joints.len());
    let step = (clip.rate_hz / 30.0).round() as usize;
    let pose = |f: usize, j: usize| clip.rotations[f * n + j];
    let apart = |a: usize, b: usize| joints.iter().map(|&j| pose(a, j).angle_between(pose(b, j))).sum::<f32>();
    let frames = |s: f64| (s * clip.rate_hz) as usize;
    let (mut best, last) = ((f32::INFINITY, 0, 0), clip.num_frames - 1 - step);
    for from in (frames(0.3)..last).step_by(step) {
        for to in (from + frames(0.8)..(from + frames(1.6)).min(last)).step_by(step) {
            let gap = apart(from, to) + apart(from + step, to + step);
            best = if gap < best.0 { (gap, from, to) } else { best };
        }
    }
    let (_, from, to) = best;
    let mut out = source.clone();
    let closed = |at: usize| {
        let (f, j) = (at / n - from, at % n);
        let onto = if joints.contains(&j) { pose(to, j).inverse() * pose(from, j) } else { Quat::IDENTITY };
        (clip.rotations[at] * Quat::IDENTITY.slerp(onto, f as f32 / (to - from) as f32)).normalize()
    };
    out.clip.num_frames = to - from + 1;
    out.clip.rotations = (from * n..(to + 1) * n).map(closed).collect();
    out.clip.translations = clip.translations[from * n..(to + 1) * n].to_vec();
    out
}

#[test]
fn loops_of_a_cycle_are_played_until_they_hold_whole_steps() {
    let profiles = load_profiles(&[]).unwrap();
    let (mut loops, mut missed, mut still, mut taken, mut ratios) = (0, Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for path in expand(&Vec::from_iter(recording("bandai-1"))).unwrap() {
        let source = read_source(&path, None).unwrap().swap_remove(0);
        let whole = read(source.clone(), &profiles);
        let is_loop = |i: &ImportedClip| i.findings.iter().any(|f| f.contains("a loop of"));
        // Some captured clips are cycles that were cut, and end exactly as they begin.
        let is_exact = whole.findings.iter().any(|f| f.contains("whose ends are 0.0 deg"));
        if is_loop(&whole) && !is_exact {
            taken.push(whole.clip.name.clone());
        }
        let name = &whole.clip.name;
        if !["walk", "run"].iter().any(|w| name.contains(w)) || source.clip.num_frames < 60 {
            continue;
        }
        loops += 1;
        let joints: Vec<usize> =
            (0..source.clip.joints.len()).filter(|&j| source.clip.joints[j].parent.is_some()).collect();
        let cycle = cut_cycle(&source, &joints);
        let hips = whole.roles.get(Joint::Hips).unwrap();
        let goes = read(cycle.clone(), &profiles);
        let as_it_is =
            interpret(cycle.clone(), &ImportConfig { loops: false, ..Default::default() }, &profiles).unwrap();
        let mut treadmill = cycle;
        put_in_place(&mut treadmill, hips, None);
        let stays = read(treadmill, &profiles);
        if !is_loop(&goes) || !is_loop(&stays) {
            missed.push(name.clone());
        } else if told(&stays, "got root motion").is_none() {
            still.push(name.clone());
        } else {
            let mps = |i: &ImportedClip| travel(i, hips).length() / (i.clip.num_frames - 1) as f32;
            ratios.push([mps(&goes) / mps(&as_it_is), mps(&stays) / mps(&as_it_is)]);
        }
    }
    println!("{loops} loops; missed {missed:?}; without root motion {still:?}; taken {taken:?}");
    println!("speeds over those of a cycle: {ratios:.2?}");
    assert!(missed.len() * 5 <= loops && still.len() * 10 <= loops && taken.is_empty());
    assert!(ratios.iter().all(|[goes, _]| (0.97..1.03).contains(goes)), "{ratios:?}");
    let of_planted_feet = ratios.iter().filter(|[_, stays]| (0.8..1.25).contains(stays)).count();
    assert!(of_planted_feet * 10 >= ratios.len() * 9, "{ratios:?}");
}

/// Turns all joints by chance, by so much in each frame.
fn shake(source: &mut SourceClip, deg: f32) {
    let mut state = 7u64;
    let mut one = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5
    };
    for r in &mut source.clip.rotations {
        // Uniform numbers of a unit deviation.
        let by = Vec3::new(one(), one(), one()) * 12f32.sqrt() * deg.to_radians();
        *r *= Quat::from_scaled_axis(by);
    }
}

#[test]
fn noise_is_told_with_how_many_times_that_of_captured_motion_it_is() {
    let clean = read(walking(), &[]);
    assert_eq!(told(&clean, "noisy"), None);
    let mut noisy = walking();
    shake(&mut noisy, 3.0);
    let told = told(&read(noisy, &[]), "noisy").map(str::to_owned).expect("it is noisy");
    let times: f32 = told.split(", ").nth(1).unwrap().split(' ').next().unwrap().parse().expect(&told);
    assert!((15.0..40.0).contains(&times), "{told}");
}

#[test]
fn steps_that_nobody_takes_are_told_with_the_rate() {
    assert_eq!(told(&read(walking(), &[]), "steps a second"), None);
    let mut fast = walking();
    fast.clip.rate_hz *= 4.0;
    let read = read(fast, &[]);
    let told = told(&read, "steps a second").expect("too many steps a second");
    assert!(told.contains("the 120 frames a second") && told.contains("`import.rate_hz`"), "{told}");
}

#[test]
fn captured_motion_is_neither_noisy_nor_on_the_spot_and_is_told_where_it_was_made_so() {
    let profiles = load_profiles(&[]).unwrap();
    let (mut walks, mut missed, mut unhurried, mut ratios) = (0, Vec::new(), Vec::new(), Vec::new());
    for path in expand(&Vec::from_iter(recording(""))).unwrap() {
        let source = read_source(&path, None).unwrap().swap_remove(0);
        let clean = read(source.clone(), &profiles);
        let odd = ["on the spot", "noisy", "steps a second"].map(|what| told(&clean, what));
        assert_eq!(odd, [None; 3], "{}", path.display());
        let hips = clean.roles.get(Joint::Hips).unwrap();
        let ends = [0, clean.clip.num_frames - 1].map(|f| clean.clip.world(f)[hips].0);
        let seconds = clean.clip.num_frames as f64 / clean.clip.rate_hz;
        let goes = ends[0].distance(ends[1]) as f64 > 0.5 * seconds && (1.0..10.0).contains(&seconds);
        if !goes || !clean.clip.name.contains("walk") {
            continue;
        }
        walks += 1;
        for sway in [None, Some(1.0)] {
            let mut treadmill = source.clone();
            put_in_place(&mut treadmill, hips, sway);
            let made = read(treadmill, &profiles);
            match told(&made, "got root motion") {
                None => missed.push(clean.clip.name.clone()),
                Some(_) if sway.is_none() => {
                    ratios
                        .push((travel(&made, hips).length() / travel(&clean, hips).length(), clean.clip.name.clone()));
                }
                Some(_) => {}
            }
        }
        let mut fast = source.clone();
        fast.clip.rate_hz *= 4.0;
        // To the side, no foot gets ahead of the other one.
        let is_aside = ["left", "right"].iter().any(|side| clean.clip.name.contains(side));
        if !is_aside && told(&read(fast, &profiles), "steps a second").is_none() {
            unhurried.push(clean.clip.name.clone());
        }
        let mut noisy = source;
        shake(&mut noisy, 1.0);
        assert!(told(&read(noisy, &profiles), "noisy").is_some(), "{}", clean.clip.name);
    }
    println!("{walks} walks, {} in-place versions missed: {missed:?}", missed.len());
    assert!(missed.len() * 20 <= 2 * walks, "{missed:?}");
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of = |share: f32| ratios[((ratios.len() - 1) as f32 * share) as usize].0;
    println!(
        "made over true way: {:?} at worst, {:.3} {:.3} {:.3}",
        (&ratios[0], ratios.last()),
        of(0.05),
        of(0.5),
        of(0.95)
    );
    assert!(of(0.05) > 0.85 && of(0.95) < 1.15 && (0.9..1.1).contains(&of(0.5)), "{ratios:?}");
    println!("{} at four times their rate missed: {unhurried:?}", unhurried.len());
    assert!(unhurried.len() * 10 <= walks, "{unhurried:?}");
}

/// A file of two hierarchies, each a whole body; with `under`, both hang on one root of that name.
fn duo(names: [&str; 2], under: Option<&str>) -> String {
    let table = tables::RIGS.iter().find(|(name, _)| *name == "Mixamo").unwrap().1;
    let text = rig::bvh(&rig::parse(table), &rig::Style::default());
    let (head, motion) = text.split_once("MOTION\n").unwrap();
    let body = head.strip_prefix("HIERARCHY\n").unwrap();
    let rows: Vec<&str> = motion.lines().skip(2).collect();
    let mut out = String::from("HIERARCHY\n");
    if let Some(name) = under {
        out += &format!("ROOT {name}\n{{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n");
    }
    for name in names {
        let one = body.replace("ROOT ", &format!("ROOT {name}")).replace("JOINT ", &format!("JOINT {name}"));
        out += &if under.is_some() { one.replace("ROOT ", "JOINT ") } else { one };
    }
    out += if under.is_some() { "}\n" } else { "" };
    out += "MOTION\n";
    out += &motion.lines().take(2).map(|l| format!("{l}\n")).collect::<String>();
    for (f, row) in rows.iter().enumerate() {
        let back = rows[rows.len() - 1 - f];
        out += &format!("{}{row} {back}\n", if under.is_some() { "0 0 300 " } else { "" });
    }
    out
}

#[test]
fn two_performers_in_one_file_are_two_clips() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("duo.bvh");
    let single = read(walking(), &[]);
    let hips = |i: &ImportedClip, f: usize| i.clip.world(f)[i.roles.get(Joint::Hips).unwrap()].0;
    for (names, under, clips) in [
        (["", ""], None, ["1", "2"]),
        (["A_", "B_"], None, ["A_mixamorig:Hips", "B_mixamorig:Hips"]),
        (["A_", "B_"], Some("World"), ["A_mixamorig:Hips", "B_mixamorig:Hips"]),
    ] {
        std::fs::write(&file, duo(names, under)).unwrap();
        let found = read_clips(&file, &ImportConfig::default()).unwrap();
        let paths: Vec<PathBuf> = found.iter().map(|i| i.clip.path.clone()).collect();
        assert_eq!(paths, clips.map(|c| file.join(c)), "{names:?} {under:?}");
        let moved = if under.is_some() { Vec3::Z * 3.0 } else { Vec3::ZERO };
        let last = single.clip.num_frames - 1;
        for f in [0, 20, last] {
            assert!(hips(&found[0], f).distance(hips(&single, f) + moved) < 1e-3, "{names:?} {under:?} {f}");
            assert!(hips(&found[1], f).distance(hips(&single, last - f) + moved) < 1e-3, "{names:?} {under:?} {f}");
        }
        for i in &found {
            assert_eq!(i.warnings.messages, [""; 0]);
            assert!(i.findings.iter().any(|f| f.contains("holds 2 performers")), "{:?}", i.findings);
        }
        // Either one by its name.
        let one = read_clips(&file.join(clips[1]), &ImportConfig::default()).unwrap();
        assert_eq!((one.len(), &one[0].clip), (1, &found[1].clip));
    }
}

#[test]
fn names_that_are_used_twice_are_one_line() {
    let text = rig::bvh(&rig::parse(tables::RIGS[0].1), &rig::Style::default());
    // A further root with joints of the same names, too few for a body.
    let prop = "ROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\nJOINT Hips\n{\nOFFSET 0 1 0\n\
                CHANNELS 0\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n}\nMOTION";
    let (head, motion) = text.split_once("MOTION\n").unwrap();
    let rows: String = motion.lines().skip(2).map(|l| format!("{l} 0 0 0\n")).collect();
    let first: String = motion.lines().take(2).map(|l| format!("{l}\n")).collect();
    let clip = bvh::parse(format!("{head}{prop}\n{first}{rows}").as_bytes(), Path::new("a.bvh")).unwrap();
    let names: Vec<&String> = clip.warnings.messages.iter().collect();
    assert!(names.len() == 1 && names[0].contains("more than one joint is called"), "{names:?}");
}

/// A rig that is so many units tall.
fn of_height(units: f32, declared: Option<f64>, config: &ImportConfig) -> Result<ImportedClip, ImportError> {
    let table = tables::RIGS.iter().find(|(name, _)| *name == "Mixamo").unwrap().1;
    let style = rig::Style { scale: units / read(walking(), &[]).height, ..rig::Style::default() };
    let source = bvh::parse(rig::bvh(&rig::parse(table), &style).as_bytes(), Path::new("a.bvh")).unwrap();
    interpret(SourceClip { declared_metres_per_unit: declared, ..source }, config, &[])
}

#[test]
fn bodies_of_no_usual_unit_are_taken_as_adults_and_the_unit_is_told() {
    let plain = ImportConfig::default();
    for (units, declared, metres) in [
        (175.0, None, 1.75),
        (120.0, None, 1.2),
        // A child in centimetres, and none of 2.5 m in inches; an adult in inches.
        (100.0, None, 1.0),
        (67.0, None, 1.702),
        (90.0, Some(0.01), 0.9),
        (2.3, Some(1.0), 2.3),
    ] {
        let i = of_height(units, declared, &plain).unwrap();
        assert!((i.height - metres).abs() < 0.01, "{units}: {}", i.height);
        assert_eq!(i.warnings.messages, [""; 0], "{units}");
    }
    // No known unit is near.
    let taken = of_height(660.0, None, &plain).unwrap();
    assert!((taken.height - 1.75).abs() < 0.01 && taken.metres_per_unit == 0.00265, "{}", taken.metres_per_unit);
    let told = &taken.warnings.messages;
    assert!(told.len() == 1 && told[0].contains("0.00265 m a unit: no usual unit fits"), "{told:?}");
    assert!(told[0].contains("taken as 1.75 m tall (`--metres-per-unit`"), "{told:?}");
    let unit = ImportConfig { metres_per_unit: Some(0.00265), ..plain.clone() };
    assert!((of_height(660.0, None, &unit).unwrap().height - 1.75).abs() < 0.01);
    // Who names the unit means it, within reason.
    let meant = ImportConfig { metres_per_unit: Some(0.001), ..plain };
    assert!((of_height(660.0, None, &meant).unwrap().height - 0.66).abs() < 0.01);
    let refused = of_height(300.0, None, &meant).unwrap_err().to_string();
    for part in ["the body is 0.30 m tall, which no person is", "`--metres-per-unit 0.00583`", "makes it 1.75 m tall"] {
        assert!(refused.contains(part), "{refused}");
    }
}

#[test]
fn bodies_are_as_tall_as_they_are_whatever_their_hips_hang_on() {
    for (name, table) in tables::RIGS {
        let text = rig::bvh(&rig::parse(table), &rig::Style::default());
        let i = read(bvh::parse(text.as_bytes(), Path::new("a.bvh")).unwrap(), &[]);
        assert!((1.55..1.95).contains(&i.height), "{name}: {} m", i.height);
    }
}
