//! The motion graph: no dead ends, everything reachable, transitions where a foot is about to leave the ground.

use crate::common::mocap::recording;
use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::f32::consts::{PI, TAU};
use throng_core::Bundle;
use throng_core::base::SingleRank;
use throng_core::format::{AlignedBytes, Meta};
use throng_core::{Contacts, Joint, NUM_JOINTS, Planar, Skeleton};
use throng_precompute::annotate::{self, AnnotateConfig, Sidecars};
use throng_precompute::clip::{Exclusion, ExclusionReason, FrameId};
use throng_precompute::features::{self, Features, FeaturesConfig};
use throng_precompute::graph::{self, GraphReport, MotionGraphConfig, RawMotionGraph, StateId};
use throng_precompute::import::{self, ImportConfig};
use throng_precompute::progress::Silent;
use throng_precompute::resample::{self, ResampleConfig};
use throng_precompute::retarget::{self, RetargetConfig};
use throng_precompute::stops;
use throng_precompute::write::{self, BundleInputs};
use throng_precompute::{BuildError, Clip, ClipSet, Warnings};

const RATE_HZ: f64 = 30.0;

/// A made-up walk: a sine for every limb, feet down 60 % of the cycle.
#[derive(Clone, Copy, Debug)]
struct Gait {
    /// Where in the cycle the clip begins.
    phase: f32,
    /// (rad/s)
    turning: f32,
    /// (m/s)
    speed: f32,
    /// How far the arms swing (rad).
    arms: f32,
    /// How far the spine bends at each joint, which makes gaits unlike (rad).
    style: f32,
    num_frames: usize,
    /// Stands still for this many frames at the beginning and at the end.
    standing: usize,
}

impl Default for Gait {
    fn default() -> Self {
        Self { phase: 0.0, turning: 0.0, speed: 1.2, arms: 0.3, style: 0.0, num_frames: 150, standing: 0 }
    }
}

impl Gait {
    fn clip(&self, name: String) -> Clip {
        let (mut root_positions, mut rotations, mut contacts) = (Vec::new(), Vec::new(), Vec::new());
        let mut root = Planar::new(self.phase, -self.turning, 3.0 * self.phase);
        let mut cycle = self.phase;
        for f in 0..self.num_frames {
            let stands = f < self.standing || f + self.standing >= self.num_frames;
            let pace = if stands { 0.0 } else { 1.0 };
            let step = Planar::new(0.0, pace * self.speed / 30.0, pace * self.turning / 30.0);
            root = root.compose(step);
            cycle += pace / 30.0;
            root_positions.push(root.translation() + Vec3::Y * 0.95);
            rotations.extend(self.pose(cycle, pace, root));
            contacts.push(if pace == 0.0 { Contacts(5) } else { planted(cycle) });
        }
        Clip { contacts, ..Clip::new(name, RATE_HZ, root_positions, rotations) }
    }

    fn pose(&self, cycle: f32, pace: f32, root: Planar) -> [Quat; NUM_JOINTS] {
        let swing = (TAU * cycle).sin() * pace;
        let mut pose = [Quat::IDENTITY; NUM_JOINTS];
        pose[0] = root.rotation();
        for (joint, angle) in [
            (Joint::LeftThigh, 0.4 * swing),
            (Joint::RightThigh, -0.4 * swing),
            (Joint::LeftUpperArm, -self.arms * swing),
            (Joint::RightUpperArm, self.arms * swing),
            (Joint::Spine, self.style),
            (Joint::Chest, self.style),
            (Joint::UpperChest, self.style),
        ] {
            pose[joint.index()] = Quat::from_rotation_x(angle);
        }
        // Arms hang: nobody stands for good who holds one out.
        for (joint, lowered) in [(Joint::LeftUpperArm, -1.4), (Joint::RightUpperArm, 1.4)] {
            pose[joint.index()] *= Quat::from_rotation_z(lowered);
        }
        pose
    }
}

fn planted(cycle: f32) -> Contacts {
    let mut out = Contacts::NONE;
    if cycle.rem_euclid(1.0) < 0.6 {
        out.insert(Contacts::LEFT_HEEL);
    }
    if (cycle + 0.5).rem_euclid(1.0) < 0.6 {
        out.insert(Contacts::RIGHT_TOE);
    }
    out
}

fn set(gaits: &[Gait]) -> ClipSet {
    let clips = gaits.iter().enumerate().map(|(k, g)| g.clip(format!("gait {k}"))).collect();
    ClipSet { skeleton: Skeleton::default(), clips }
}

/// Walks straight, to both sides, and out of standing, each a little different.
fn wandering(num_clips: usize) -> ClipSet {
    let gaits: Vec<Gait> = (0..num_clips)
        .map(|k| Gait {
            phase: 0.137 * k as f32,
            turning: 0.3 * ((k % 5) as f32 - 2.0),
            speed: 1.1 + 0.02 * (k % 7) as f32,
            arms: 0.3 + 0.01 * (k % 11) as f32,
            num_frames: 160 + 13 * (k % 4),
            style: 0.01 * ((7 * k) % 61) as f32,
            standing: if k % 3 == 0 { 40 } else { 0 },
        })
        .collect();
    set(&gaits)
}

fn connect(clips: &ClipSet, config: &MotionGraphConfig) -> Result<(RawMotionGraph, GraphReport, Features), BuildError> {
    let features = features::extract(clips, &FeaturesConfig::default())?;
    let (graph, report) = graph::connect(clips, &FeaturesConfig::default(), config, &Silent, &SingleRank)?;
    Ok((graph, report, features))
}

fn failure(clips: &ClipSet) -> String {
    connect(clips, &MotionGraphConfig::default()).map(|_| ()).unwrap_err().to_string()
}

fn clip_of(clips: &ClipSet, frame: FrameId) -> (usize, usize) {
    let starts = clips.frame_starts();
    let clip = starts.iter().rposition(|&s| s <= frame.0).unwrap();
    (clip, (frame.0 - starts[clip]) as usize)
}

/// Everything that must hold of any graph, whatever the motion.
fn check(graph: &RawMotionGraph, clips: &ClipSet, features: &Features, config: &MotionGraphConfig) {
    let n = graph.states.len();
    assert!(n > 0 && graph.action_offsets.len() == n + 1);
    assert!(graph.states.is_sorted() && graph.segments.is_sorted_by_key(|s| s.start));
    for s in 0..n {
        let actions = graph.actions_of(StateId(s as u32));
        assert!((2..=config.max_actions).contains(&actions.len()), "state {s} has {} actions", actions.len());
        assert!(actions.is_sorted_by(|a, b| a.error <= b.error));
        for a in actions {
            let start = graph.segments[a.segment.0 as usize].start;
            assert_eq!(a.error, features.distance(graph.states[s], start));
            assert!(a.error <= config.max_error as f32);
        }
    }
    for s in &graph.segments {
        assert!(s.num_frames > 0);
        let (first, last) = (clip_of(clips, s.start), clip_of(clips, FrameId(s.start.0 + s.num_frames)));
        assert_eq!(first.0, last.0, "a segment leaves its clip");
        assert_eq!(graph.states[s.end.0 as usize].0, s.start.0 + s.num_frames);
        let inside = |f: &&FrameId| f.0 > s.start.0 && f.0 < s.start.0 + s.num_frames;
        assert_eq!(graph.states.iter().find(inside), None, "a segment runs over a state");
        assert!((first.1..=last.1).all(|f| clips.clips[first.0].is_usable(f)));
    }
    for s in 0..n {
        assert_eq!(reachable(graph, s).iter().filter(|r| **r).count(), n, "from state {s}");
    }
}

/// States reachable from one, by following every action.
fn reachable(graph: &RawMotionGraph, from: usize) -> Vec<bool> {
    let mut seen = vec![false; graph.states.len()];
    let mut open = vec![from];
    while let Some(s) = open.pop() {
        for a in graph.actions_of(StateId(s as u32)) {
            let end = graph.segments[a.segment.0 as usize].end.0 as usize;
            if !seen[end] {
                seen[end] = true;
                open.push(end);
            }
        }
    }
    seen
}

#[test]
fn no_dead_ends_and_every_state_reaches_every_other() {
    let clips = wandering(24);
    let config = MotionGraphConfig::default();
    let (graph, report, features) = connect(&clips, &config).unwrap();
    check(&graph, &clips, &features, &config);
    assert!(report.frames_kept * 10 > report.frames_in * 8, "{report:?}");
    assert_eq!((report.states, report.actions), (graph.states.len(), graph.actions.len()));
    assert!(report.standing_states > 0);
}

#[test]
fn displacement_is_the_composition_of_the_frames_of_a_segment() {
    let clips = wandering(16);
    let (graph, ..) = connect(&clips, &MotionGraphConfig::default()).unwrap();
    for s in &graph.segments {
        let (clip, first) = clip_of(&clips, s.start);
        let steps = (first..first + s.num_frames as usize).map(|f| {
            let step = clips.clips[clip].planar(f).to_local(clips.clips[clip].planar(f + 1));
            Planar { heading: throng_core::planar::wrap_angle(step.heading), ..step }
        });
        let whole = steps.fold(Planar::IDENTITY, Planar::compose);
        assert!((whole.x - s.displacement.x).hypot(whole.z - s.displacement.z) < 1e-4);
        assert!((whole.heading - s.displacement.heading).abs() < 1e-4);
    }
}

#[test]
fn a_segment_that_spins_counts_its_full_turns() {
    let spin = |phase| Gait { phase, turning: 7.0 * PI, ..Gait::default() };
    let clips = set(&[spin(0.0), spin(0.3), spin(0.6)]);
    let (graph, ..) = connect(&clips, &MotionGraphConfig { min_component_s: 1.0, ..Default::default() }).unwrap();
    for s in &graph.segments {
        let expected = 7.0 * PI * s.num_frames as f32 / RATE_HZ as f32;
        assert!((s.displacement.heading - expected).abs() < 1e-3, "{expected} {:?}", s.displacement);
    }
}

#[test]
fn transitions_join_frames_where_the_same_foot_is_about_to_leave_or_both_stand() {
    let clips = wandering(24);
    let config = MotionGraphConfig::default();
    let (graph, ..) = connect(&clips, &config).unwrap();
    let contacts = |f: FrameId, ahead: usize| {
        let (clip, frame) = clip_of(&clips, f);
        clips.clips[clip].contacts[frame + ahead]
    };
    let leaves = |f: FrameId, foot: Contacts| contacts(f, 0).any(foot) && !contacts(f, 1).any(foot);
    // Speeds are measured over the frames before and after; over one frame alone they may be twice as high.
    let stands = |f: FrameId| {
        let (clip, frame) = clip_of(&clips, f);
        let roots = &clips.clips[clip].root_positions;
        let mps = f64::from(roots[frame].distance(roots[frame + 1])) * RATE_HZ;
        let both = contacts(f, 0).any(Contacts::LEFT) && contacts(f, 0).any(Contacts::RIGHT);
        both && mps <= 2.0 * config.standing_speed_mps
    };
    let mut jumps = 0;
    for (s, &state) in graph.states.iter().enumerate() {
        for a in graph.actions_of(StateId(s as u32)) {
            let start = graph.segments[a.segment.0 as usize].start;
            if start == state {
                continue;
            }
            jumps += 1;
            let same = |foot, other| {
                leaves(state, foot)
                    && leaves(start, foot)
                    && contacts(state, 0).any(other) == contacts(start, 0).any(other)
            };
            let both_stand = stands(state) && stands(start);
            assert!(same(Contacts::LEFT, Contacts::RIGHT) || same(Contacts::RIGHT, Contacts::LEFT) || both_stand);
        }
    }
    assert!(jumps > graph.states.len());
}

#[test]
fn the_search_reaches_the_wanted_branching() {
    let clips = wandering(60);
    let loose = MotionGraphConfig { outcome_distance: 0.0, outcome_angle: 0.0, ..Default::default() };
    for wanted in [6.0, 10.0, 16.0] {
        let config = MotionGraphConfig { branching: wanted, ..loose.clone() };
        let (_, report, _) = connect(&clips, &config).unwrap();
        assert!((report.branching.mean - wanted).abs() < 0.05 * wanted, "{wanted}: {report:?}");
        assert!(report.threshold < config.max_error);
        let given = MotionGraphConfig { threshold: Some(report.threshold), ..loose.clone() };
        assert_eq!(connect(&clips, &given).unwrap().1.actions, report.actions);
    }
}

#[test]
fn too_little_or_too_unlike_motion_is_an_error_that_says_so() {
    let tiny = failure(&wandering(1));
    assert!(tiny.contains("less than graph.min_component_s = 10 s") && tiny.contains("Add longer clips"), "{tiny}");
    let unlike: Vec<Gait> =
        (0..10).map(|k| Gait { style: 0.3 * k as f32 - 1.5, phase: 0.3, num_frames: 33, ..Gait::default() }).collect();
    let message = failure(&set(&unlike));
    assert!(message.contains("11.0 s are usable"), "{message}");
    assert!(failure(&set(&[])).contains("no clips"));
}

#[test]
fn clips_that_differ_in_rate_or_lack_contacts_are_named() {
    let mut clips = wandering(3);
    clips.clips[2].rate_hz = 60.0;
    assert!(failure(&clips).contains("gait 2"));
    let mut clips = wandering(3);
    clips.clips[1].contacts.clear();
    assert!(failure(&clips).contains("gait 1"));
}

#[test]
fn a_clip_unlike_the_rest_is_reported_as_unused() {
    let mut clips = wandering(16);
    clips.clips.push(Gait { style: 2.0, ..Gait::default() }.clip("stranger".into()));
    let (_, report, _) = connect(&clips, &MotionGraphConfig::default()).unwrap();
    assert_eq!(report.unused_clips, ["stranger"]);
}

#[test]
fn the_graph_does_not_depend_on_the_number_of_threads() {
    let clips = wandering(20);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (graph, report, _) = pool.install(|| connect(&clips, &MotionGraphConfig::default())).unwrap();
        (graph, report)
    };
    assert_eq!(on(1), on(2));
    assert_eq!(on(1), on(8));
}

#[test]
fn json_lists_states_and_actions() {
    let clips = wandering(16);
    let (graph, ..) = connect(&clips, &MotionGraphConfig::default()).unwrap();
    let meta = Meta { rate_hz: RATE_HZ, ..Meta::default() };
    let baked = BundleInputs {
        clips: &clips,
        graph: &graph,
        stops: &stops::find_stops(&clips, &graph, &throng_core::base::SingleRank).unwrap().0,
        policies: &[],
        groups: None,
        patches: None,
        blends: &[],
        activities: &[],
        meta: &meta,
    };
    let mut bytes = Vec::new();
    write::lay_out(&baked).unwrap().write(&mut bytes).unwrap();
    let tables = Bundle::from_bytes(AlignedBytes::from_slice(&bytes)).unwrap();
    let mut text = Vec::new();
    graph::write_graph_json(&graph::graph_rows(&tables), &mut text).unwrap();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(json["rate_hz"], 30.0);
    assert_eq!(json["states"].as_array().unwrap().len(), graph.states.len());
    let actions = json["actions"].as_array().unwrap();
    assert_eq!(actions.len(), graph.actions.len());
    let (first, action) = (&actions[0], graph.actions[0]);
    let segment = &graph.segments[action.segment.0 as usize];
    assert_eq!((first["from"].as_u64(), first["to"].as_u64()), (Some(0), Some(u64::from(segment.end.0))));
    assert_eq!(first["frames"], segment.num_frames);
    assert!((first["duration_s"].as_f64().unwrap() - f64::from(segment.num_frames) / RATE_HZ).abs() < 1e-12);
    assert!((first["displacement"]["z_m"].as_f64().unwrap() - f64::from(segment.displacement.z)).abs() < 1e-6);
    let (clip, frame) = clip_of(&clips, segment.start);
    assert_eq!(first["clip"], clips.clips[clip].name);
    assert_eq!(first["start_frame"], frame);
}

/// Largest turns to the left and to the right from every state within `frames` frames, by dynamic programming.
fn turns_within(graph: &RawMotionGraph, frames: usize) -> Vec<(f32, f32)> {
    let mut table = vec![vec![(0.0f32, 0.0f32); graph.states.len()]; frames + 1];
    for t in 1..=frames {
        for s in 0..graph.states.len() {
            for a in graph.actions_of(StateId(s as u32)) {
                let segment = &graph.segments[a.segment.0 as usize];
                if let Some(left_over) = t.checked_sub(segment.num_frames as usize) {
                    let (left, right) = table[left_over][segment.end.0 as usize];
                    let turned = segment.displacement.heading;
                    table[t][s] = (table[t][s].0.max(left + turned), table[t][s].1.min(right + turned));
                }
            }
        }
    }
    table.swap_remove(frames)
}

#[test]
fn captured_walks_and_runs_turn_both_ways_everywhere() {
    let Some(root) = recording("") else { return };
    let paths = ["walk_*.amc", "run_*.amc"].map(|p| root.join("snu/single").join(p));
    let imported = import::read(&paths, &ImportConfig::default(), &Silent).unwrap();
    let clips =
        retarget::retarget_clips(&imported.clips, &RetargetConfig::default(), &mut Warnings::default()).unwrap();
    let clips = resample::resample(&clips, &ResampleConfig::default()).unwrap();
    let clips = annotate::annotate(&clips, &AnnotateConfig::default(), &Sidecars::default()).unwrap();
    let config = MotionGraphConfig::default();
    let (graph, report, features) = connect(&clips, &config).unwrap();
    check(&graph, &clips, &features, &config);
    assert!(report.frames_kept * 10 > report.frames_in * 8, "{report:?}");
    assert!((report.branching.mean - config.branching).abs() < 0.5, "{report:?}");
    let turns = turns_within(&graph, 90);
    let able = turns.iter().filter(|t| t.0 > 1.0 && t.1 < -1.0).count();
    assert!(able * 100 > 95 * turns.len(), "{able} of {} states turn by 1 rad to either side in 3 s", turns.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn holds_for_random_databases(
        seeds in prop::collection::vec((0.0f32..1.0, -1.0f32..1.0, 0.2f32..0.6, 20usize..160, 0usize..60, 0usize..160), 4..14),
        wanted in 2.0f64..12.0,
        apart in 0.0f64..0.3,
    ) {
        let gaits: Vec<Gait> = seeds.iter()
            .map(|&(phase, turning, arms, num_frames, standing, _)| Gait { phase, turning, arms, num_frames, standing, ..Gait::default() })
            .collect();
        let mut clips = set(&gaits);
        for (clip, seed) in clips.clips.iter_mut().zip(&seeds) {
            if seed.5 + 10 < clip.num_frames() {
                clip.excluded.push(Exclusion { range: seed.5..seed.5 + 10, reason: ExclusionReason::Sidecar });
            }
        }
        let config = MotionGraphConfig { branching: wanted, outcome_distance: apart, min_component_s: 0.0, ..Default::default() };
        match connect(&clips, &config) {
            Ok((graph, _, features)) => check(&graph, &clips, &features, &config),
            Err(e) => prop_assert!(e.to_string().contains("largest strongly connected part of the motion has 0.0 s"), "{}", e),
        }
    }
}
