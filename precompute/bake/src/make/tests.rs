use super::*;
use crate::features::FeaturesConfig;
use crate::graph;
use glam::Vec3;
use std::collections::BTreeSet;
use throng_base::{SingleRank, maths};
use throng_core::format::{ClassSpan, MotionClass};
use throng_core::planar::wrap_angle;
use throng_core::skeleton::ARMS;
use throng_core::{Contacts, Joint, NUM_JOINTS, Planar};
use throng_motion::annotate::contacts::FOOT_PARTS;
use throng_motion::clip::FrameId;
use throng_motion::progress::Silent;
use throng_synth::{SynthConfig, SynthSet, make_set};

/// Synthetic gaits and stands whose names begin so, with mirrored copies.
fn library(names: &[&str]) -> ClipSet {
    let mut set = make_set(SynthSet::Locomotion, &SynthConfig::for_set(SynthSet::Locomotion)).unwrap();
    set.clips.retain(|c| names.iter().any(|n| c.name.starts_with(n)));
    for clip in &mut set.clips {
        clip.classes = classify(clip, &set.skeleton, &NameHints::new(&clip.name, ""));
    }
    set.clips = set.clips.into_iter().flat_map(|c| [c.clone(), mirror::mirror_clip(&c)]).collect();
    set
}

fn num_manners(set: &ClipSet) -> usize {
    Lacks::of_manners(set, None).len()
}

fn made_of(set: &ClipSet) -> MadeMotion {
    make_missing(set, &Lacks::of_manners(set, None), &MotionGraphConfig::default(), true, &SingleRank).unwrap()
}

/// Figures of the poses of clips.
#[derive(Debug)]
struct ClipFigures {
    /// 95th percentile of the speed of planted feet (m/s).
    slip: f32,
    /// Largest acceleration of a joint (m/s2).
    jolt: f32,
    /// 99.9th percentile of the turn of knees (rad/s).
    knees: f32,
    /// Lowest part of a foot, and lowest hips (m).
    low: f32,
    hips: f32,
}

fn percentile(all: &mut [f32], share: f32) -> f32 {
    all.sort_by(f32::total_cmp);
    all[((all.len() - 1) as f32 * share) as usize]
}

fn measure_clips(set: &ClipSet, clips: &[Clip]) -> ClipFigures {
    let (mut slip, mut knees, mut jolt, mut low) = (Vec::new(), Vec::new(), 0.0f32, 0.0f32);
    let mut hips = f32::MAX;
    for clip in clips {
        let rate = clip.rate_hz as f32;
        let at: Vec<[Vec3; NUM_JOINTS]> =
            (0..clip.num_frames()).map(|f| clip.joint_positions(&set.skeleton, f)).collect();
        for f in 1..at.len() - 1 {
            hips = hips.min(at[f][0].y);
            for (joint, part) in FOOT_PARTS {
                let j = joint.index();
                if clip.contacts[f].any(part) && clip.contacts[f - 1].any(part) {
                    slip.push(at[f][j].distance(at[f - 1][j]) * rate);
                }
                low = low.min(at[f][j].y);
            }
            for knee in [Joint::LeftShin, Joint::RightShin].map(Joint::index) {
                let angle = |f: usize| clip.frame_rotations(f)[knee].angle_between(glam::Quat::IDENTITY);
                knees.push((angle(f) - angle(f - 1)).abs() * rate);
            }
            let bends = (0..NUM_JOINTS).map(|j| (at[f + 1][j] - 2.0 * at[f][j] + at[f - 1][j]).length() * rate * rate);
            jolt = bends.fold(jolt, f32::max);
        }
    }
    ClipFigures { slip: percentile(&mut slip, 0.95), jolt, knees: percentile(&mut knees, 0.999), low, hips }
}

#[test]
fn made_motion_slips_and_jolts_no_more_than_captured_motion() {
    for names in [&["walk_", "idle_"][..], &["walk_"], &["jog_", "idle_"], &["run_", "idle_"], &["run_"]] {
        let set = library(names);
        let made = made_of(&set);
        let MadeReport { starts, stops, turns, pivots, .. } = made.report;
        assert!(starts > 2 && stops > 0 && turns > 2 && pivots > 1, "{names:?}: {:?}", made.report);
        let captured = measure_clips(&set, &set.clips);
        let steps: Vec<Clip> = set.clips.iter().filter(|c| !c.name.starts_with("idle")).cloned().collect();
        let [captured_steps, made] = [&steps, &made.clips].map(|clips| measure_clips(&set, clips));
        assert!(made.slip < 1.2 * captured.slip + 0.01, "{names:?}: planted feet slip {made:?} of {captured:?}");
        assert!(made.jolt < 1.2 * captured.jolt, "{names:?}: joints jolt {made:?} of {captured:?}");
        assert!(made.knees < 1.2 * captured_steps.knees, "{names:?}: knees turn {made:?} of {captured_steps:?}");
        assert!(made.hips > captured_steps.hips - 0.1, "{names:?}: hips sink {made:?} of {captured_steps:?}");
        assert!(made.low > captured.low - 0.02, "{names:?}: feet go into the ground {made:?} of {captured:?}");
    }
}

#[test]
fn starts_and_stops_begin_and_end_as_their_clips_do() {
    for gait in ["walk_", "jog_", "run_"] {
        let set = library(&[gait, "idle_"]);
        let made = made_of(&set);
        assert!(!made.report.stances.is_empty() && made.report.stands == 0, "{gait}: {:?}", made.report);
        let pose = |clip: &Clip, f: usize| clip.frame_rotations(f)[1..].to_vec();
        let from_captured = |clip: &Clip, f: usize| {
            let wanted = pose(clip, f);
            let apart = |c: &Clip, g: usize| {
                pose(c, g).iter().zip(&wanted).map(|(a, b)| a.angle_between(*b)).fold(0.0, f32::max)
            };
            let nearest = |c: &Clip| (0..c.num_frames()).map(|g| apart(c, g)).fold(f32::MAX, f32::min);
            set.clips.iter().map(nearest).fold(f32::MAX, f32::min)
        };
        for clip in made.clips.iter().filter(|c| !c.mirrored) {
            let range = &clip.tags[0].range;
            assert!(clip.is_made() && range.start > 0 && range.end < clip.num_frames(), "{}: {range:?}", clip.name);
            for f in [range.start - 1, range.end, range.end + 2] {
                let (name, apart) = (&clip.name, from_captured(clip, f));
                assert!(apart < 0.01, "{gait} {name}: frame {f} is {apart} rad from captured ones, made are {range:?}");
            }
        }
    }
}

#[test]
fn who_walks_in_a_manner_stops_in_a_captured_stance_of_that_manner() {
    let set = library(&["walk_", "idle_"]);
    let idles: Vec<&Clip> = set.clips.iter().filter(|c| c.name.starts_with("idle_")).collect();
    let made = made_of(&set);
    let apart =
        |a: &[glam::Quat], b: &[glam::Quat]| a[1..].iter().zip(&b[1..]).map(|(a, b)| a.angle_between(*b)).sum::<f32>();
    let mut stances = std::collections::BTreeSet::new();
    for clip in made.clips.iter().filter(|c| c.name.starts_with("made/stop")) {
        let end = clip.frame_rotations(clip.num_frames() - 1);
        let far = |c: &Clip| (0..c.num_frames()).map(|f| apart(c.frame_rotations(f), end)).fold(f32::MAX, f32::min);
        let near = idles.iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
        let manner = &clip.classes[0].class.manner;
        assert_eq!(manner, &near.classes[0].class.manner, "{} ends as {}", clip.name, near.name);
        stances.insert((manner.clone(), near.name.clone()));
    }
    let manners: std::collections::BTreeSet<_> = stances.iter().map(|s| &s.0).collect();
    assert!(manners.len() > 2 && stances.len() > manners.len(), "{stances:?}");
}

#[test]
fn short_stands_are_held_for_longer() {
    let mut set = library(&["walk_", "idle_"]);
    for clip in set.clips.iter_mut().filter(|c| c.name.starts_with("idle_")) {
        *clip = Clip { classes: clip.classes.clone(), mirrored: clip.mirrored, ..stance::cut(clip, 0..25) };
    }
    let made = made_of(&set);
    let stands: Vec<&Clip> = made.clips.iter().filter(|c| c.name.starts_with("made/stand")).collect();
    assert!(stands.len() >= 6 && made.report.stands * 2 == stands.len(), "{:?}", made.report);
    for clip in stands {
        let at: Vec<_> = (0..clip.num_frames()).map(|f| clip.joint_positions(&set.skeleton, f)).collect();
        let goes = |j: Joint| at.iter().map(|p| p[j.index()].distance(at[0][j.index()])).fold(0.0, f32::max);
        assert!(clip.num_frames() as f64 > 4.0 * clip.rate_hz && clip.classes.iter().all(|s| s.class.neutral));
        assert!(goes(Joint::LeftToe).max(goes(Joint::RightFoot)) < 0.002, "{}: feet move", clip.name);
        assert!((0.01..0.06).contains(&goes(Joint::Hips)), "{}: hips sway by {} m", clip.name, goes(Joint::Hips));
    }
}

#[test]
fn stands_over_feet_that_glide_are_held_over_feet_that_stay() {
    let set = library(&["walk_neutral_v110_g00", "idle_neutral"]);
    let named = |name: &str| set.clips.iter().find(|c| c.name.starts_with(name)).unwrap();
    let gait = GaitCycle::find(named("walk"), &set.skeleton).remove(0);
    let chosen = |glides_mps: f32| {
        let mut clip = named("idle").clone();
        for (f, root) in clip.root_positions.iter_mut().enumerate() {
            root.x += glides_mps * f as f32 / clip.rate_hz as f32;
        }
        let found = RestStance::find(&clip, &set.skeleton, &MotionGraphConfig::default());
        RestStance::choose(&found, &[&gait], &set.skeleton).remove(0)
    };
    let [still, gliding] = [0.0, 0.04].map(chosen);
    assert!(!still.made && gliding.made, "{} {}", still.made, gliding.made);
    let ankle = |f: usize| gliding.clip.joint_positions(&set.skeleton, f)[Joint::LeftFoot.index()];
    let glided = (0..gliding.clip.num_frames()).map(|f| ankle(f).distance(ankle(0))).fold(0.0, f32::max);
    assert!(gliding.clip.num_frames() >= 180 && glided < 0.005, "{glided} m");
}

#[test]
fn arms_that_a_gait_holds_out_hang_where_it_stands_unless_they_carry_or_lie_on_the_body() {
    let set = library(&["walk_neutral_v110_g00"]);
    let raised_in = |of: Gait, axis: Vec3, degrees: f32, bent: f32, carrying: bool| {
        let mut clip = set.clips[0].clone();
        for f in 0..clip.num_frames() {
            for ([arm, elbow, _], side) in ARMS.map(|arm| arm.map(Joint::index)).into_iter().zip([1.0, -1.0]) {
                let at = f * NUM_JOINTS;
                clip.rotations[at + arm] = glam::Quat::from_rotation_z(side * (degrees - 90.0).to_radians());
                clip.rotations[at + elbow] = glam::Quat::from_axis_angle(axis, -side * bent.to_radians());
            }
        }
        let mut gait = GaitCycle::find(&clip, &set.skeleton).remove(0);
        (gait.class.carrying, gait.class.gait) = (carrying, of);
        let stance = RestStance::of_gait(&gait, &set.skeleton).unwrap().clip;
        let at = stance.joint_positions(&set.skeleton, 0);
        let down = |[from, to]: [Joint; 2]| (at[to.index()] - at[from.index()]).angle_between(Vec3::NEG_Y).to_degrees();
        let degrees = ARMS.map(|[shoulder, elbow, wrist]| down([shoulder, wrist]).max(down([elbow, wrist])));
        (degrees[0].max(degrees[1]), classify(&stance, &set.skeleton, &NameHints::default())[0].class.neutral)
    };
    let raised_about = |axis, degrees, bent, carrying| raised_in(Gait::Walk, axis, degrees, bent, carrying);
    let raised = |degrees, bent, carrying| raised_about(Vec3::Y, degrees, bent, carrying);
    let (hangs, is_neutral) = raised(85.0, 10.0, false);
    assert!(hangs < 25.0 && is_neutral, "arms hang at {hangs} degrees");
    assert!(raised(12.0, 10.0, false).0 < 16.0, "hanging arms are as they were");
    // Elbows of a jog: forearms are level, hands in the air before the body.
    let (jogs, is_neutral) = raised(15.0, 90.0, false);
    assert!(jogs < 45.0 && is_neutral, "forearms hang at {jogs} degrees");
    let on_hips = raised_about(Vec3::Z, 45.0, 100.0, false).0;
    assert!(on_hips > 50.0, "hands on hips are as they were: {on_hips}");
    // Arms of a run are away from the body, which those of who stands are not.
    let runs = raised_in(Gait::Run, Vec3::Y, 34.0, 10.0, false).0;
    assert!(runs < 20.0 && raised(34.0, 10.0, false).0 > 28.0, "a runner's arms hang at {runs} degrees");
    assert!(raised(60.0, 10.0, true).0 > 50.0 && raised(15.0, 90.0, true).0 > 80.0, "arms that carry are as they were");
}

#[test]
fn pivots_turn_round_within_two_or_three_steps() {
    for names in [&["walk_", "idle_"][..], &["walk_"], &["walk_tired_v070_g00"], &["jog_"]] {
        let set = library(names);
        let made = made_of(&set);
        let pivots: Vec<&Clip> = made.clips.iter().filter(|c| c.name.starts_with("made/pivot")).collect();
        assert!((4..=8).contains(&(pivots.len() / num_manners(&set))), "{names:?}: {}", pivots.len());
        for clip in pivots {
            let last = clip.num_frames() - 1;
            let mut heading = vec![0.0f32];
            for f in 1..=last {
                let by = throng_core::planar::wrap_angle(clip.planar(f).heading - clip.planar(f - 1).heading);
                heading.push(heading[f - 1] + by);
            }
            let named = clip.name.split('-').rev().nth(1).and_then(|n| n.parse::<f32>().ok()).unwrap().to_radians();
            let turned = heading[last] * heading[last].signum();
            assert!((turned - named.abs()).abs() < 0.3, "{} turns by {turned} rad", clip.name);
            let turns = heading.iter().filter(|h| (0.25..named.abs() - 0.25).contains(&h.abs())).count();
            let seconds = turns as f32 / clip.rate_hz as f32;
            assert!(seconds < 1.2, "{} takes {seconds} s", clip.name);
            // Hips over planted feet.
            for f in 0..=last {
                for foot in [0, 1].into_iter().filter(|&foot| clip.contacts[f].any(gait::FEET[foot])) {
                    let foot_at = feet::foot_point(clip, &set.skeleton, f, foot).planar();
                    let twist = throng_core::planar::wrap_angle(foot_at.heading - clip.planar(f).heading).abs();
                    assert!(twist < 1.3, "{} twists a leg by {twist} rad at frame {f}", clip.name);
                }
            }
        }
    }
}

#[test]
fn who_stands_turns_round_with_quick_steps_over_feet_that_stand_before_and_after() {
    let set = library(&["walk_", "idle_"]);
    let both = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
    for clip in made_of(&set).clips.iter().filter(|c| c.name.starts_with("made/turn")) {
        let last = clip.num_frames() - 1;
        let turned = |f: usize| throng_core::planar::wrap_angle(clip.planar(f).heading - clip.planar(0).heading).abs();
        let until = |angle: f32| (0..=last).find(|&f| turned(f) > angle).unwrap_or(last) as f32 / clip.rate_hz as f32;
        let all: f32 = clip.name.split('-').rev().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0.0);
        let seconds = until(all.abs().to_radians() - 0.52) - until(0.1);
        assert!(seconds < 0.7 * all.abs() / 180.0 + 0.05, "{} takes {seconds} s", clip.name);
        assert!(clip.contacts[0].all(both) && clip.contacts[last].all(both), "{}", clip.name);
        let turned = throng_core::planar::wrap_angle(clip.planar(last).heading - clip.planar(0).heading).abs();
        let named: f32 = clip.name.split('-').rev().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0.0);
        assert!((turned - named.abs().to_radians()).abs() < 0.1, "{} turns by {turned} rad", clip.name);
    }
}

#[test]
fn walks_alone_give_people_who_set_off_and_stand() {
    let mut set = library(&["walk_neutral"]);
    let graph = |set: &ClipSet| {
        graph::connect(set, &FeaturesConfig::default(), &MotionGraphConfig::default(), &Silent, &SingleRank).unwrap().0
    };
    let before = graph(&set);
    let lacks = &Lacks::of_manners(&set, Some((&before, &[])))[""];
    assert!(lacks.starts && lacks.turns && !before.standing.contains(&true));
    let made = made_of(&set);
    assert!(made.report.stances.is_empty() && made.report.stands == 1);
    set.clips.extend(made.clips);
    let after = graph(&set);
    assert!(after.standing.iter().filter(|s| **s).count() > 4);
    let starts = set.frame_starts();
    let played = graph::played_frames(&after, &set);
    for name in ["made/start-0-0", "made/stop-0", "walk_neutral"] {
        let c = set.clips.iter().position(|c| c.name.starts_with(name)).unwrap();
        assert!(played[starts[c] as usize..starts[c + 1] as usize].contains(&true), "{name} is not played");
    }
}

#[test]
fn every_gait_gets_arcs_no_sharper_than_people_turn_with_the_lean_that_belongs_to_them() {
    let gaits = ["walk_neutral_v110_g00", "walk_neutral_v150_g00", "jog_neutral_v235_g00", "run_neutral_v440_g00"];
    let set = library(&[&gaits[..], &["run_neutral_v320_g00", "idle_neutral"]].concat());
    let made = made_of(&set);
    let arcs: Vec<&Clip> = made.clips.iter().filter(|c| !c.mirrored && c.name.starts_with("made/arc")).collect();
    let fast = |fast: bool| arcs.iter().filter(|c| (speed_of(c) > 2.2) == fast).count();
    assert!(fast(false) == 4 && fast(true) == 8, "{:?}", arcs.iter().map(|c| &c.name).collect::<Vec<_>>());
    let pivots = made.clips.iter().filter(|c| !c.mirrored && c.name.starts_with("made/pivot"));
    let goes_fast = |c: &&Clip| c.root_positions[0].distance(c.root_positions[4]) * c.rate_hz as f32 > 4.0 * 2.2;
    let (runs, walks): (Vec<_>, Vec<_>) = pivots.partition(goes_fast);
    assert_eq!([walks.len(), runs.len()], [2, 4], "who runs turns round, too");
    // Angles by which a body turns and leans, frame by frame.
    let angles = |clip: &Clip| {
        let turned = |f: usize| wrap_angle(clip.planar(f + 1).heading - clip.planar(f).heading);
        let lean = |f: usize| {
            let up = maths::rotate(maths::rotation_y(-clip.planar(f).heading), clip.hips_rotation(f) * Vec3::Y);
            maths::atan2(up.x, up.y)
        };
        let n = clip.num_frames();
        [(0..n - 1).map(turned).sum::<f32>(), (0..n).map(lean).sum()]
    };
    for pair in arcs.chunks(2) {
        let (clip, other) = (pair[0], pair[1]);
        let (name, n, rate, speed) = (&clip.name, clip.num_frames(), clip.rate_hz as f32, speed_of(clip));
        let way = |f: usize| (clip.root_positions[f + 15] - clip.root_positions[f]).with_y(0.0);
        let sideways = |f: usize| way(f).angle_between(way(f + 15)) / 0.5 * speed;
        let most = (0..n - 30).map(sideways).fold(0.0, f32::max);
        assert!((0.6..2.1).contains(&most), "{name}: {most} m/s2 at {speed} m/s");
        // Hips sway, but on average they lean as much as the weight asks, and as much to each side.
        let ([left, leans], [right, leans_too]) = (angles(clip), angles(other));
        let (wanted, leant) = (speed * (left - right) * rate / 9.81, leans - leans_too);
        assert!((0.75..1.25).contains(&(leant / wanted)), "{name}: leans {leant} of {wanted} at {speed} m/s");
    }
    let [captured, made] = [&set.clips, &made.clips].map(|clips| measure_clips(&set, clips));
    assert!(made.slip < 1.2 * captured.slip + 0.01 && made.low > captured.low - 0.02, "{made:?} of {captured:?}");
}

/// Mean speed of the hips over the ground (m/s).
fn speed_of(clip: &Clip) -> f32 {
    let roots = &clip.root_positions;
    let way: f32 = roots.windows(2).map(|w| (w[1] - w[0]).with_y(0.0).length()).sum();
    way * clip.rate_hz as f32 / (roots.len() - 1) as f32
}

/// A graph that plays all frames.
fn graph_of_all(set: &ClipSet) -> graph::RawMotionGraph {
    let segment = |(clip, first): (&Clip, u32)| graph::GraphSegment {
        start: FrameId(first),
        num_frames: clip.num_frames() as u32 - 1,
        end: graph::StateId(0),
        displacement: Planar::IDENTITY,
    };
    let segments = set.clips.iter().zip(set.frame_starts()).map(segment).collect();
    graph::RawMotionGraph { segments, action_offsets: vec![0], ..Default::default() }
}

#[test]
fn arcs_are_lacking_gait_by_gait() {
    let lacks = |names: &[&str]| {
        let set = library(names);
        Lacks::of_manners(&set, Some((&graph_of_all(&set), &[])))[""].clone()
    };
    let arcs = |lacks: Lacks| [Gait::Walk, Gait::Run].map(|g| lacks.arcs[g as usize]);
    let straight = ["walk_neutral_v110_g00", "run_neutral_v320_g00"];
    assert_eq!(arcs(lacks(&straight)), [true, true]);
    assert_eq!(arcs(lacks(&[straight[0], straight[1], "walk_neutral_v110_gl08"])), [false, true]);
    assert_eq!(arcs(lacks(&[straight[0], straight[1], "run_neutral_v380_gl06"])), [true, false]);
    let captured = lacks(&[straight[0], "run_neutral_v380_gl06"]).sideways_mps2;
    assert!((captured - 0.6 * 3.8).abs() < 0.2, "as people turn who were captured: {captured} m/s2");
    assert_eq!(lacks(&straight).sideways_mps2, 1.5);
}

#[test]
fn who_does_not_come_to_a_stand_soon_lacks_stops_and_turns_round() {
    // A stand, from which a walk sets off, and its three segments, of which the last one leads back.
    let segment = |(start, num_frames, end)| graph::GraphSegment {
        start: FrameId(start),
        num_frames,
        end: graph::StateId(end),
        displacement: Planar::IDENTITY,
    };
    let action = |segment| graph::GraphAction { segment: graph::SegmentId(segment), error: 0.0 };
    let mut hand = graph::RawMotionGraph {
        states: [0, 10, 20, 30].map(FrameId).to_vec(),
        standing: vec![true, false, false, false],
        segments: [(0, 15, 1), (20, 10, 2), (40, 10, 3), (60, 10, 1), (80, 20, 0)].map(segment).to_vec(),
        action_offsets: vec![0, 1, 2, 3, 5],
        actions: [0, 1, 2, 3, 4].map(action).to_vec(),
        ..Default::default()
    };
    assert_eq!(needs::stop_frames(&hand, |_| true, |_| true), 40.0);
    assert_eq!(needs::stop_frames(&hand, |_| true, |s| s.start == FrameId(40)), 20.0, "the last one alone");
    assert_eq!(needs::stop_frames(&hand, |f| f.0 > 0, |_| true), f64::INFINITY, "a stand in another manner");
    hand.actions[4] = action(3);
    assert_eq!(needs::stop_frames(&hand, |_| true, |_| true), f64::INFINITY);

    let mut set = library(&["walk_neutral_v110_g00", "walk_neutral_v150_g00", "idle_neutral"]);
    set.clips.extend(made_of(&set).clips);
    let (features, cfg) = (FeaturesConfig::default(), MotionGraphConfig::default());
    let (mut graph, _) = graph::connect(&set, &features, &cfg, &Silent, &SingleRank).unwrap();
    let joins = |graph: &graph::RawMotionGraph| {
        let lacks = Lacks::of_manners(&set, Some((graph, &[])));
        lacks.get("").is_some_and(|lacks| lacks.joins)
    };
    assert!(!joins(&graph), "who stops within a second needs no other stops");
    let stands = |g: &graph::RawMotionGraph, segment: u32| g.standing[g.segments[segment as usize].end.0 as usize];
    let on = (0..graph.segments.len() as u32).find(|&s| !stands(&graph, s)).unwrap();
    for k in 0..graph.actions.len() {
        if stands(&graph, graph.actions[k].segment.0) {
            graph.actions[k].segment = graph::SegmentId(on);
        }
    }
    assert!(joins(&graph), "nobody comes to a stand any more");
}

#[test]
fn motion_of_another_gait_is_joined_by_starts_and_stops_of_its_own_or_told() {
    let mut set = library(&["walk_neutral_v110", "idle_neutral", "back_neutral"]);
    let graph = |set: &ClipSet| {
        graph::connect(set, &FeaturesConfig::default(), &MotionGraphConfig::default(), &Silent, &SingleRank).unwrap()
    };
    let backwards_s = |report: &graph::GraphReport| -> f64 {
        report.apart.iter().filter(|a| a.gait == "backwards").map(|a| a.seconds).sum()
    };
    let (before, report) = graph(&set);
    let all_s = backwards_s(&report);
    assert!(all_s > 5.0, "{:?}", report.apart);
    let apart = report.apart.iter().find(|a| a.gait == "backwards").unwrap();
    let told = apart.to_string();
    assert!(
        apart.error > Some(apart.limit) && told.contains("back_neutral") && told.contains("`graph.max_error` is 0.5")
    );
    let lacks = Lacks::of_manners(&set, Some((&before, &report.apart)));
    let made = make_missing(&set, &lacks, &MotionGraphConfig::default(), true, &SingleRank).unwrap();
    set.clips.extend(made.clips);
    let (_, report) = graph(&set);
    assert!(backwards_s(&report) < 0.2 * all_s, "{:?}", report.apart);
}

#[test]
fn a_foot_at_its_place_is_where_it_was() {
    let set = library(&["walk_neutral"]);
    let clip = &set.clips[0];
    for (frame, foot) in [(10, 0), (25, 1)] {
        let at = feet::foot_point(clip, &set.skeleton, frame, foot);
        let place = throng_core::Planar::new(0.4, -1.2, 2.0);
        let back = at.seen_from(place).laid_at(place);
        assert!(back.toe.distance(at.toe) < 1e-5 && back.turn.angle_between(at.turn) < 1e-3);
        let toe = [Joint::LeftToe, Joint::RightToe][foot];
        assert!(at.toe.distance(clip.joint_positions(&set.skeleton, frame)[toe.index()]) < 1e-6);
    }
}

#[test]
fn what_was_made_is_told_in_a_sentence() {
    let report = MadeReport { clips: 12, starts: 4, stops: 4, turns: 3, stands: 1, ..MadeReport::default() };
    assert_eq!(report.summary(), "12 clips made: 4 starts, 4 stops, 3 turns, 1 stand");
    assert_eq!(MadeReport::default().summary(), "");
}

#[test]
fn short_stands_become_long_ones_over_feet_that_stay() {
    let mut set = library(&["walk_neutral", "idle_"]);
    let frames = 40u32;
    for clip in &mut set.clips {
        let neutral = clip.name.starts_with("idle_");
        if neutral {
            *clip = Clip { mirrored: clip.mirrored, ..stance::cut(clip, 0..frames as usize) };
        }
        let class = MotionClass { neutral, manner: "calm".into(), ..MotionClass::default() };
        clip.classes = vec![ClassSpan { frames: 0..clip.num_frames() as u32, class, ..ClassSpan::default() }];
    }
    let made = make_stands(&set, true, &SingleRank).unwrap();
    assert!(made.report.stands > 0 && made.clips.len() == 2 * made.report.stands, "{:?}", made.report);
    for clip in &made.clips {
        let seconds = clip.num_frames() as f64 / clip.rate_hz;
        assert!((11.0..20.0).contains(&seconds), "{} lasts {seconds} s", clip.name);
        let class = &clip.classes[0].class;
        assert!(class.neutral && class.manner == "calm");
        let at: Vec<[Vec3; NUM_JOINTS]> =
            (0..clip.num_frames()).map(|f| clip.joint_positions(&set.skeleton, f)).collect();
        for j in [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe].map(Joint::index) {
            let far = at.iter().map(|p| p[j].distance(at[0][j])).fold(0.0, f32::max);
            assert!(far < 2e-3, "{}: a foot moves by {far} m", clip.name);
        }
        let hips = at.iter().map(|p| p[0].distance(at[0][0])).fold(0.0, f32::max);
        assert!(hips > 0.01, "{}: the body sways by {hips} m", clip.name);
    }
    let [captured, made] = [&set.clips, &made.clips].map(|clips| measure_clips(&set, clips));
    assert!(made.jolt < captured.jolt && made.low > captured.low - 0.02, "{made:?} of {captured:?}");
    // Who was captured off balance, about to walk, comes over the feet, and goes back for what follows.
    let mut leaning = set.clone();
    leaning.clips.retain(|clip| clip.name.starts_with("idle_") && !clip.mirrored);
    for clip in &mut leaning.clips {
        let ankle = clip.joint_positions(&set.skeleton, 0)[Joint::LeftFoot.index()];
        let heading = maths::rotation_y(clip.planar(0).heading);
        let lean = maths::compose(maths::compose(heading, maths::rotation_x(0.15)), heading.conjugate());
        for f in 0..clip.num_frames() {
            clip.root_positions[f] = ankle + lean * (clip.root_positions[f] - ankle);
            clip.rotations[f * NUM_JOINTS] = maths::compose(lean, clip.rotations[f * NUM_JOINTS]);
        }
    }
    for clip in &make_stands(&leaning, false, &SingleRank).unwrap().clips {
        let ahead = |f: usize| {
            let at = clip.joint_positions(&set.skeleton, f);
            let balls = 0.5 * (at[Joint::LeftToe.index()] + at[Joint::RightToe.index()]);
            maths::rotate(maths::rotation_y(-clip.planar(f).heading), at[0] - balls).z
        };
        let middle = ahead(clip.num_frames() / 2);
        assert!(ahead(0) > -0.05 && (-0.16..-0.04).contains(&middle), "{}: {} to {middle} m", clip.name, ahead(0));
    }
    // Who has long stands needs none that are made.
    let long = Clip { classes: Vec::new(), ..set.clips[0].clone() };
    assert!(make_stands(&ClipSet { clips: vec![long], ..set }, true, &SingleRank).unwrap().clips.is_empty());
}

/// A walk whose hips leap, and one whose hips climb, half of its time: nobody starts into either.
#[test]
fn jumps_and_stairs_are_no_gaits() {
    let set = library(&["walk_"]);
    let walk = set.clips.iter().find(|c| GaitCycle::find(c, &set.skeleton).len() == 2).expect("a walk");
    let spoilt = |height: fn(f32) -> f32| {
        let mut clip = walk.clone();
        let n = clip.num_frames() as f32;
        let at = |f: usize| height(f as f32 / clip.rate_hz as f32);
        let rises: Vec<f32> = (0..clip.num_frames()).map(at).collect();
        assert!(n > 60.0);
        clip.root_positions.iter_mut().zip(rises).for_each(|(p, rise)| p.y += rise);
        GaitCycle::find(&clip, &set.skeleton).len()
    };
    assert_eq!(spoilt(|_| 0.0), 2);
    assert_eq!(spoilt(|t| 0.01 * (6.0 * t).sin()), 2, "hips that sway are a walk's");
    assert_eq!(spoilt(|t| 0.3 * (4.0 * t).sin().max(0.0)), 0, "it leaps");
    assert_eq!(spoilt(|t| 0.3 * t), 0, "it climbs");
}

#[test]
fn each_manner_gets_what_it_gets_alone() {
    let names = |of: &[&str]| {
        let report = made_of(&library(of)).report;
        [report.starts, report.stops, report.turns, report.arcs, report.pivots, report.steps]
    };
    let [proud, tired] = [["walk_proud", "idle_proud"], ["walk_tired", "idle_tired"]];
    let alone = [names(&proud), names(&tired)];
    assert!(alone.as_flattened().iter().all(|n| *n > 0), "{alone:?}");
    let together = names(&[proud, tired].concat());
    assert_eq!(together, std::array::from_fn(|what| alone[0][what] + alone[1][what]));
}

/// A moment of motion: its manner, its clip, and the frame within it.
type Moment = (String, String, u32);

/// Transitions of the graph of some motion, and the manners that it cannot keep.
fn transitions(set: &ClipSet) -> (BTreeSet<[Moment; 2]>, Vec<String>) {
    let (features, config) = (FeaturesConfig::default(), MotionGraphConfig::default());
    let (graph, report) = graph::connect(set, &features, &config, &Silent, &SingleRank).unwrap();
    let starts = set.frame_starts();
    let moment = |frame: FrameId| {
        let number = starts.partition_point(|&s| s <= frame.0) - 1;
        let clip = &set.clips[number];
        (clip.classes[0].class.manner.clone(), clip.name.clone(), frame.0 - starts[number])
    };
    let of_state = |s: usize| {
        let from = graph.states[s];
        let starts =
            graph.actions_of(graph::StateId(s as u32)).iter().map(|a| graph.segments[a.segment.0 as usize].start);
        starts.filter(move |to| *to != from).map(move |to| [from, to].map(moment)).collect::<Vec<_>>()
    };
    ((0..graph.states.len()).flat_map(of_state).collect(), report.thin_manners)
}

#[test]
fn links_within_a_manner_are_those_that_a_bake_of_it_alone_finds() {
    let mut set = library(&["walk_proud_v110", "idle_proud", "walk_tired_v110", "idle_tired"]);
    set.clips.extend(made_of(&set).clips);
    let only = |keep: &dyn Fn(&Clip) -> bool| {
        let clips = set.clips.iter().filter(|c| keep(c)).cloned().collect();
        transitions(&ClipSet { clips, ..set.clone() })
    };
    let (all, thin) = transitions(&set);
    assert_eq!(thin, [""; 0]);
    for manner in ["proud", "tired"] {
        let within = all.iter().filter(|ends| ends.iter().all(|end| end.0 == manner)).cloned();
        assert_eq!(within.collect::<BTreeSet<_>>(), only(&|c| c.classes[0].class.manner == manner).0, "{manner}");
        assert!(all.iter().filter(|[from, to]| from.0 == manner && to.0 != manner).count() > 10, "out of {manner}");
    }
    // Who walks tired and cannot stand so stands otherwise.
    let stands_proud = |c: &Clip| c.classes[0].class.manner == "proud" || c.name.starts_with("walk_tired");
    assert_eq!(only(&stands_proud).1, ["tired"]);
}

#[test]
fn a_manner_that_would_be_lost_is_joined_by_farther_transitions_and_told() {
    let mut set = library(&["walk_proud_v110", "idle_proud", "walk_tired_v110", "idle_tired"]);
    set.clips.extend(made_of(&set).clips);
    let features = FeaturesConfig::default();
    let graph = |join_error: f64| {
        let config = MotionGraphConfig { max_error: 0.15, join_error, ..Default::default() };
        let (graph, report) = graph::connect(&set, &features, &config, &Silent, &SingleRank).unwrap();
        let starts = set.frame_starts();
        let manner = |f: &FrameId| set.clips[starts.partition_point(|&s| s <= f.0) - 1].classes[0].class.manner.clone();
        let manners: BTreeSet<String> = graph.states.iter().map(manner).collect();
        (manners.len(), graph.actions.iter().filter(|a| a.error > 0.15).count(), report)
    };
    let (manners, farther, report) = graph(0.15);
    assert_eq!((manners, farther, report.joined.len()), (1, 0, 0));
    assert!(!report.apart.is_empty(), "what is lost is told");
    let (manners, farther, report) = graph(1.0);
    assert_eq!((manners, report.joined.len()), (2, 1), "{:?}", report.joined);
    assert!((1..=16).contains(&farther), "{farther}");
    assert!(report.joined.values().all(|e| (0.15..1.0).contains(e)), "{:?}", report.joined);
}

#[test]
fn a_start_goes_from_a_stand_to_a_walk_and_not_one_step_of_a_dance() {
    let starts = |parts: &[(usize, f32)]| {
        let (mut z, mut roots) = (0.0, Vec::new());
        for (frames, mps) in parts {
            for _ in 0..*frames {
                z += mps / 30.0;
                roots.push(Vec3::new(0.0, 0.9, z));
            }
        }
        let rotations = vec![glam::Quat::IDENTITY; roots.len() * NUM_JOINTS];
        needs::count_starts(&ClipSet {
            skeleton: Skeleton::default(),
            clips: vec![Clip::new("a", 30.0, roots, rotations)],
        })
    };
    assert_eq!(starts(&[(60, 0.0), (15, 1.0), (60, 0.0), (15, -1.0), (60, 0.0)]), 0, "a step to and fro");
    assert_eq!(starts(&[(60, 0.0), (90, 1.0), (60, 0.0)]), 1);
    assert_eq!(starts(&[(10, 0.0), (40, 3.0), (10, 0.0)]), 1, "a dash whose stands are cut short");
}
