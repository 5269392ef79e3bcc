//! Feet that are laid onto the database skeleton slide no more than the source's and stand on the ground.

use crate::mocap::recording;
use crate::rigs::{rig, tables};
use glam::{Quat, Vec3};
use rig::{Rest, Style};
use std::path::Path;
use throng_core::{Contacts, Joint};
use throng_motion::annotate::ContactConfig;
use throng_motion::annotate::contacts::{FOOT_PARTS, detect_contacts};
use throng_motion::clip::ClipSet;
use throng_motion::import::{ImportConfig, ImportedClip, bvh, interpret, read};
use throng_motion::progress::Silent;
use throng_motion::retarget::{Proportions, RetargetConfig, retarget_clips};

/// Clips of a folder of the recordings.
fn clips(folder: &str) -> Option<Vec<ImportedClip>> {
    Some(read(&[recording(folder)?], &ImportConfig::default(), &Silent).unwrap().clips)
}

/// How feet behave while they stand.
#[derive(Default)]
struct Feet {
    /// Speed over the ground (m/s), ascending.
    slip: Vec<f32>,
    /// Height above where the part is when the body stands at rest (m), ascending.
    height: Vec<f32>,
    /// Lowest joint of each clip (m), ascending.
    lowest: Vec<(f32, String)>,
}

impl Feet {
    fn slip_at(&self, share: f64) -> f32 {
        at(&self.slip, share)
    }
}

fn at(sorted: &[f32], share: f64) -> f32 {
    sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0)
}

/// Looks at the parts of the feet that stand by `contacts`.
fn feet(set: &ClipSet, contacts: &[Vec<Contacts>]) -> Feet {
    let mut out = Feet::default();
    let rest = set.skeleton.rest_positions();
    for (clip, contacts) in set.clips.iter().zip(contacts) {
        let mut before: Option<[Vec3; 22]> = None;
        let mut lowest = f32::INFINITY;
        for f in 0..clip.num_frames() {
            let p = clip.joint_positions(&set.skeleton, f);
            lowest = p.iter().map(|p| p.y).fold(lowest, f32::min);
            for (j, part) in FOOT_PARTS {
                let j = j.index();
                if let Some(b) = before.filter(|_| contacts[f].any(part) && contacts[f - 1].any(part)) {
                    let d = p[j] - b[j];
                    out.slip.push(d.x.hypot(d.z) * clip.rate_hz as f32);
                    out.height.push(p[j].y - rest[j].y);
                }
            }
            before = Some(p);
        }
        out.lowest.push((lowest, clip.name.clone()));
    }
    out.slip.sort_by(f32::total_cmp);
    out.height.sort_by(f32::total_cmp);
    out.lowest.sort_by(|a, b| a.0.total_cmp(&b.0));
    out
}

/// Source and retargeted feet of clips, over the same contacts: those of the source.
fn compare(clips: &[ImportedClip]) -> (Feet, Feet) {
    let own = RetargetConfig { proportions: Proportions::Clip, align_ground: true };
    let source = retarget_clips(clips, &own, &mut Default::default()).unwrap();
    let contacts: Vec<Vec<Contacts>> =
        source.clips.iter().map(|c| detect_contacts(c, &source.skeleton, &ContactConfig::default())).collect();
    let retargeted = retarget_clips(clips, &RetargetConfig::default(), &mut Default::default()).unwrap();
    (feet(&source, &contacts), feet(&retargeted, &contacts))
}

fn report(name: &str, source: &Feet, retargeted: &Feet) {
    let times = |share: f64| retargeted.slip_at(share) / source.slip_at(share);
    println!(
        "{name:<22} slip p50 {:.3} to {:.3} m/s ({:.2} times), p95 {:.3} to {:.3} m/s ({:.2} times); height at contacts p1 \
         {:+.3}, median {:+.3}, p99 {:+.3} m, the source's {:+.3}, {:+.3}, {:+.3}; lowest joint {:+.3} m in {}, the source's \
         {:+.3}",
        source.slip_at(0.5),
        retargeted.slip_at(0.5),
        times(0.5),
        source.slip_at(0.95),
        retargeted.slip_at(0.95),
        times(0.95),
        at(&retargeted.height, 0.01),
        at(&retargeted.height, 0.5),
        at(&retargeted.height, 0.99),
        at(&source.height, 0.01),
        at(&source.height, 0.5),
        at(&source.height, 0.99),
        retargeted.lowest[0].0,
        retargeted.lowest[0].1,
        source.lowest[0].0,
    );
}

/// Slides no more than 1.2 times as fast, and is no more than 2 cm off where the source's feet are.
fn check(name: &str, clips: &[ImportedClip]) {
    let (source, retargeted) = compare(clips);
    report(name, &source, &retargeted);
    let p95 = [&source, &retargeted].map(|f| f.slip_at(0.95));
    assert!(p95[1] < 1.2 * p95[0], "{name}: {p95:?} m/s");
    for share in [0.01, 0.5, 0.99] {
        let off = at(&retargeted.height, share) - at(&source.height, share);
        assert!(off.abs() < 0.02, "{name}: feet are {off} m higher than the source's at {share}");
    }
}

/// The clips with some roles left out, as of a rig that lacks the joints.
fn without(clips: &[ImportedClip], roles: &[Joint]) -> Vec<ImportedClip> {
    let mut out = clips.to_vec();
    for clip in &mut out {
        roles.iter().for_each(|j| clip.roles.joints[j.index()] = None);
    }
    out
}

#[test]
fn retargeted_feet_slide_no_more_than_the_sources() {
    for folder in
        ["cmu-asfamc/01", "cmu-asfamc/02", "cmu-asfamc/03", "snu/single", "snu/session23", "snu/multi", "bandai-1"]
    {
        let Some(clips) = clips(folder) else { continue };
        check(folder, &clips);
        check(&format!("{folder} no toes"), &without(&clips, &[Joint::LeftToe, Joint::RightToe]));
    }
}

#[test]
fn a_crawl_stays_above_the_ground() {
    let Some(clips) = clips("snu/single") else { return };
    let crawls: Vec<ImportedClip> = clips.into_iter().filter(|c| c.clip.name.contains("crawl")).collect();
    let (_, retargeted) = compare(&crawls);
    assert!(retargeted.lowest[0].0 > -0.02, "{:?}", retargeted.lowest);
}

#[test]
fn every_rig_stands_and_turns_as_it_was_written() {
    for (name, table) in tables::RIGS {
        let parts = rig::parse(table);
        for (rest, moves) in
            [Rest::TPose, Rest::APose, Rest::AlongX, Rest::AlongY].into_iter().flat_map(|r| [(r, false), (r, true)])
        {
            let text = rig::bvh(&parts, &Style { rest, moves, ..Style::default() });
            let source = bvh::parse(text.as_bytes(), Path::new("a.bvh")).unwrap();
            let imported = interpret(source, &ImportConfig::default(), &[])
                .unwrap_or_else(|e| panic!("{name} {rest:?} {moves}: {e}"));
            let has = |j: Joint| imported.roles.get(j).is_some();
            let set =
                retarget_clips(std::slice::from_ref(&imported), &RetargetConfig::default(), &mut Default::default())
                    .unwrap();
            let still = set.skeleton.rest_positions();
            for f in 0..set.clips[0].num_frames() {
                let turns = rig::turns(f);
                let pose = set.clips[0].joint_transforms(&set.skeleton, f);
                for j in Joint::ALL.into_iter().filter(|&j| has(j) && j.index() >= Joint::LeftThigh.index()) {
                    let want = if moves { turns[&j] } else { Quat::IDENTITY };
                    let off = pose[j.index()].1.angle_between(want);
                    assert!(off < 0.06, "{name} {rest:?}, frame {f}: {} is {off} rad off", j.name());
                }
                for (j, _) in FOOT_PARTS.iter().filter(|_| !moves) {
                    let height = pose[j.index()].0.y - still[j.index()].y;
                    assert!(height.abs() < 0.002, "{name} {rest:?}: {} is {height} m too high", j.name());
                }
            }
        }
    }
}
