//! Spaces of found examples: one posture and manner each, nothing that looks otherwise, nothing extrapolated, and judged.

use super::made_up::{Puppet, config, fit, idle, set, six};
use crate::common::build;
use crate::common::mocap::recording;
use glam::Quat;
use throng_core::blend::{ExampleRecord, MAX_AXES};
use throng_core::format::{ClassSpan, Gait, MotionClass, Posture};
use throng_core::{Bundle, Joint, NUM_JOINTS};
use throng_precompute::Clip;
use throng_precompute::activities::{ActivityConfig, ActivitySearch, find_activities};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::examples::{BlendReport, BlendSpaces, ExampleReport, judge};

const ALIKE: &str = "
    alike = true
    axes = [{ kind = 'speed' }, { kind = 'gyration' }]
    find = [{ clips = ['*'], mirror = true }]
    weight_tolerance = 0.05
    phases = 32
";

fn alike(clips: Vec<Clip>) -> BlendSpaces {
    fit(clips, &config(ALIKE)).expect("spaces")
}

/// Turns a joint in all frames.
fn turned(mut clip: Clip, joint: Joint, by: Quat) -> Clip {
    for pose in clip.rotations.chunks_exact_mut(NUM_JOINTS) {
        pose[joint.index()] = by * pose[joint.index()];
    }
    clip
}

/// The clip with its hips lower, or higher (m).
fn lowered(mut clip: Clip, by: f32, frames: std::ops::Range<usize>) -> Clip {
    clip.root_positions[frames].iter_mut().for_each(|p| p.y -= by);
    clip
}

/// The clip with one class for all its frames.
fn of_class(mut clip: Clip, class: MotionClass) -> Clip {
    clip.classes = vec![ClassSpan { frames: 0..clip.num_frames() as u32, class, ..ClassSpan::default() }];
    clip
}

fn walk() -> MotionClass {
    MotionClass { gait: Gait::Walk, ..MotionClass::default() }
}

fn reason<'a>(report: &'a BlendReport, clip: &str) -> &'a str {
    report.refused.get(clip).map_or("", String::as_str)
}

#[test]
fn what_looks_otherwise_is_not_among_upright_walks() {
    let odd = [
        (lowered(Puppet::new("crouch", 1.2, 0.3).clip(), 0.2, 0..270), "hips go down"),
        (lowered(Puppet { seconds: 1.6, ..Puppet::new("duck", 1.2, -0.3) }.clip(), 0.2, 50..70), "hips go down"),
        (Puppet { velocity: [0.7, 0.8], ..Puppet::new("strafe", 0.0, 0.0) }.clip(), "goes aside"),
        (Puppet::new("back", -0.8, 0.0).clip(), "ahead at -0.8 m/s"),
        (turned(Puppet::new("reach", 1.3, 0.1).clip(), Joint::LeftUpperArm, Quat::from_rotation_y(-1.0)), "left arm"),
        (turned(Puppet::new("bent", 1.4, 0.1).clip(), Joint::Spine, Quat::from_rotation_x(0.6)), "trunk"),
        (Puppet { period: 0.4, ..Puppet::new("trip", 1.0, 0.4) }.clip(), "two steps take 0.40 s"),
        (Puppet { right: 0.7, duty: 0.8, ..Puppet::new("limp", 1.0, 0.2) }.clip(), "one of two steps takes 70 %"),
    ];
    let clips = six().into_iter().chain(odd.iter().map(|o| o.0.clone())).collect();
    let spaces = alike(clips);
    let report = &spaces.report[0];
    assert_eq!(spaces.report.len(), 1);
    for (clip, why) in &odd {
        assert!(!report.clips().contains(&clip.name.as_str()), "{} is among {:?}", clip.name, report.clips());
        assert!(reason(report, &clip.name).contains(why), "{}: {:?}", clip.name, report.refused);
    }
    assert!(["fast", "slow_left", "idle"].iter().all(|c| report.clips().contains(c)), "{:?}", report.clips());
}

#[test]
fn each_posture_and_manner_has_a_space_of_its_own() {
    let manner = |clip: Clip, manner: &str| {
        let sad = turned(clip, Joint::Spine, Quat::from_rotation_x(0.5));
        of_class(
            Clip { name: format!("{manner}_{}", sad.name), ..sad },
            MotionClass { manner: manner.into(), ..walk() },
        )
    };
    let crouched = |clip: Clip| {
        let low = lowered(Clip { name: format!("low_{}", clip.name), ..clip }, 0.2, 0..270);
        of_class(low, MotionClass { posture: Posture::Crouched, ..walk() })
    };
    let carried = of_class(Puppet::new("box", 1.2, 0.5).clip(), MotionClass { carrying: true, ..walk() });
    let five = || six().into_iter().take(5);
    let plain = five().map(|c| of_class(c, walk()));
    let stands = of_class(idle(), MotionClass { neutral: true, ..MotionClass::default() });
    let all = plain.chain([stands, carried]).chain(five().map(|c| manner(c, "sad"))).chain(five().map(crouched));
    let spaces = alike(all.collect());
    let mut names: Vec<&str> = spaces.spaces.iter().map(|s| s.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["walk", "walk-crouched", "walk-sad"]);
    for r in &spaces.report {
        let of = |word: &str| r.clips().iter().all(|c| c.starts_with(word));
        let stands = r.clips().contains(&"idle");
        match r.name.as_str() {
            "walk" => {
                assert!(stands && !r.clips().iter().any(|c| c.starts_with("sad_") || c.starts_with("low_")), "{r:?}")
            }
            "walk-sad" => assert!(of("sad_") && !stands, "nobody stands in this manner: {r:?}"),
            _ => assert!(of("low_") && !stands, "{r:?}"),
        }
    }
    assert!(
        spaces.not_made.iter().any(|(name, why)| name == "walk-carrying" && why.contains("need 3 examples")),
        "{:?}",
        spaces.not_made
    );
}

#[test]
fn a_squat_is_no_standing_and_nor_is_an_arm_held_out() {
    let named = |name: &str, clip: Clip| Clip { name: name.into(), ..clip };
    let squat = named("squat", lowered(idle(), 0.3, 0..420));
    let reaching = named("reaching", turned(idle(), Joint::RightUpperArm, Quat::from_rotation_y(1.2)));
    let walks = || six().into_iter().take(5);
    let still = |spaces: &BlendSpaces| {
        let space = &spaces.spaces[0];
        let stands =
            space.examples.iter().zip(&space.example_names).filter(|(e, _)| e.flags & ExampleRecord::IS_STILL != 0);
        stands.map(|(_, name)| name.clone()).collect::<Vec<_>>()
    };
    assert!(still(&alike(walks().chain([squat.clone(), reaching.clone()]).collect())).is_empty());
    assert_eq!(still(&alike(walks().chain([squat, reaching, idle()]).collect())), ["idle"]);
}

#[test]
fn weights_are_never_negative_and_joints_stay_within_the_examples() {
    let spaces = alike(six());
    let space = spaces.spaces[0].open(&set(Vec::new()).skeleton).expect("a space");
    let mut weights = vec![0.0; space.stride()];
    for (x, y) in (0..=20).flat_map(|x| (0..=20).map(move |y| (x, y))) {
        let mut at = [0.0; MAX_AXES];
        (at[0], at[1]) = (x as f32 / 20.0, y as f32 / 20.0);
        space.weights(&[judge::parameters_at(&space, &at)], &mut weights).expect("weights");
        assert!(weights.iter().all(|w| (-1e-3..=1.001).contains(w)), "{at:?}: {weights:?}");
    }
    let quality = judge::judge(&space);
    assert!(quality.range_ratio < 1.05 && quality.beyond_limits_deg < 1.0, "{quality:?}");
}

/// A box far wider than its examples, as a config may ask for.
#[test]
fn extrapolation_that_doubles_ranges_is_poor_and_says_why() {
    let wide = "
        axes = [{ kind = 'speed', range = [0.0, 9.0] }, { kind = 'gyration', range = [-4.0, 4.0] }]
        examples = [{ clip = 'slow*' }, { clip = 'fast*' }]
        weight_tolerance = 0.1
        phases = 32";
    let quality = fit(six(), &config(wide)).expect("a space").report[0].quality.clone();
    assert_eq!(quality.word, "poor");
    assert!(quality.range_ratio > 2.0 && !quality.reason.is_empty(), "{quality:?}");
}

#[test]
fn walks_of_one_speed_are_not_good_and_say_what_is_missing() {
    let quality = |speeds: [f32; 2]| {
        let clips = [("slow", 0.0), ("fast", 0.02)].into_iter().zip(speeds);
        let clips = clips.map(|((name, phase), speed)| Puppet::new(name, speed, phase).clip()).collect();
        alike(clips).report[0].quality.clone()
    };
    let one = quality([1.2, 1.25]);
    assert!(
        one.word == "usable" && one.reason.contains("its speeds are 1.2") && one.reason.contains("0.15 m/s slower"),
        "{one:?}"
    );
    assert!(!quality([1.2, 1.5]).reason.contains("its speeds"));
}

#[test]
fn straight_walks_alone_have_no_axis_of_turns() {
    let clips = vec![Puppet::new("slow", 0.8, 0.0).clip(), Puppet::new("fast", 1.6, 0.02).clip(), idle()];
    let spaces = alike(clips);
    assert_eq!(spaces.report[0].axes, ["speed"]);
    assert_eq!(spaces.report[0].clips(), ["fast", "idle", "slow"]);
}

#[test]
fn nothing_steady_is_told_clip_by_clip() {
    let e = fit(vec![Puppet::new("back", -0.8, 0.0).clip(), idle()], &config(ALIKE)).expect_err("none").to_string();
    assert!(e.contains("no steady walk or run ahead") && e.contains("`back`: it goes ahead at -0.8 m/s"), "{e}");
}

#[test]
fn stands_become_a_pool_and_gestures_are_named_by_their_clips() {
    let stand = |manner: &str, neutral| MotionClass { neutral, manner: manner.into(), ..MotionClass::default() };
    let named = |name: &str, spans: &[(u32, MotionClass)]| {
        let (mut clip, mut at) = (Clip { name: name.into(), ..idle() }, 0);
        for (len, class) in spans {
            clip.classes.push(ClassSpan { frames: at..at + len, class: class.clone(), ..ClassSpan::default() });
            at += len;
        }
        clip
    };
    let bow = [(60, stand("", true)), (120, stand("", false)), (240, stand("", true))];
    let going = [(300, walk()), (120, stand("", false))];
    let clips = set(vec![
        named("set1_idle_01", &[(420, stand("", true))]),
        named("set1_wait_sad_02", &[(420, stand("sad", true))]),
        named("set1_bow_deep_01", &bow),
        named("set1_stroll_01", &going),
        named("set1_squat_01", &[(420, MotionClass { posture: Posture::Crouched, ..stand("", true) })]),
    ]);
    let of = |tag: &str, find| (tag.to_owned(), ActivityConfig { find: Some(find), ..ActivityConfig::default() });
    let config = [of("idle", ActivitySearch::Idles), of("gesture", ActivitySearch::Gestures)].into();
    let found = find_activities(&clips, &config).expect("activities");
    let tags: Vec<(&str, u32)> = found.iter().map(|a| (a.tag.as_str(), a.clip)).collect();
    assert_eq!(tags, [("bow_deep", 2), ("idle", 0), ("idle", 2), ("idle-sad", 1)]);
    let bow = &found[0];
    // A moment of calm before and after it, at 60 frames a second.
    assert_eq!((bow.first_frame, bow.num_frames), (36, 168));
    assert!(found[1].looped.is_some() && bow.looped.is_none());
    // Builds of all that is possible look for one tag after the other, and each activity has a name of its own.
    let parts = [of("idle", ActivitySearch::Idles), of("gesture", ActivitySearch::Gestures)];
    let each = parts.map(|part| find_activities(&clips, &[part].into()).expect("activities"));
    let mut names: Vec<String> = each.into_iter().flatten().map(|a| a.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 4, "{names:?}");
    let none = find_activities(&set(vec![named("stroll", &going)]), &config).expect_err("none").to_string();
    assert!(none.contains("nobody makes a gesture"), "{none}");
}

/// Recordings in which people also pull things, carry, crawl, sit and jump, where they are.
#[test]
fn captured_spaces_hold_steady_walks_and_runs_alone() {
    let Some(mocap) = recording("snu/single") else { return };
    let config = BuildConfig::of_motion("snu", vec![mocap]).expect("a config");
    let config = BuildConfig { behaviours: Vec::new(), activities: Default::default(), ..config };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("snu.throng");
    build(&config, &out, &Cache::disabled());
    let reports = BlendReport::of_bundle(&Bundle::open(&out).expect("the bundle opens")).expect("reports");
    assert!(!reports.is_empty());
    for r in reports {
        assert_ne!(r.quality.word, "poor", "{r:?}");
        let odd = ["pull", "crawl", "chair", "side", "throw", "jump"];
        assert!(!r.clips().iter().any(|c| odd.iter().any(|o| c.contains(o))), "{}: {:?}", r.name, r.clips());
        // Hips of who turns lag behind the path.
        let most = |e: &ExampleReport| (0.3 + 0.2 * e.gyration_rad_per_s.abs()) * e.speed_mps + 1e-6;
        assert!(r.examples.iter().all(|e| e.side_mps.abs() <= most(e)), "{r:?}");
    }
}
