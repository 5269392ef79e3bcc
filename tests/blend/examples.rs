//! Clips become examples: their arcs, keytimes and names, and what is wrong with those that cannot.

use super::made_up::{Puppet, SIX, config, fit, idle, set, six};
use throng_core::Contacts;
use throng_core::blend::ExampleRecord;
use throng_precompute::Clip;
use throng_precompute::clip::{Exclusion, ExclusionReason};
use throng_precompute::config::BuildConfig;
use throng_precompute::examples::{self, BlendConfig};
use throng_precompute::progress::Silent;

fn near(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}

/// What goes wrong with some clips.
fn fault(clips: Vec<Clip>, config: &BlendConfig) -> String {
    fit(clips, config).expect_err("no space").to_string()
}

#[test]
fn speed_and_turning_rate_are_those_of_the_arc() {
    for p in [
        Puppet::new("straight", 1.3, 0.0),
        Puppet::new("left", 1.3, 0.9),
        Puppet::new("right", 2.5, -1.2),
        Puppet { velocity: [0.5, 0.0], ..Puppet::new("aside", 0.0, 0.0) },
        Puppet { velocity: [0.0, -0.8], ..Puppet::new("back", 0.0, 0.4) },
        Puppet::new("turn", 0.0, 1.1),
        Puppet { velocity: [0.3, 0.9], right: 0.44, period: 1.13, ..Puppet::new("limp", 0.0, 0.3) },
    ] {
        let config = config(&format!(
            "axes = [{{ kind = 'speed' }}]\nexamples = [{{ clip = '{}' }}, {{ clip = 'far' }}]",
            p.name
        ));
        let far = Puppet { velocity: [0.0, 7.0], ..Puppet::new("far", 0.0, 0.0) };
        let spaces = fit(vec![far.clip(), p.clip()], &config).expect("a space");
        let e = spaces.spaces[0].examples[0];
        assert!(
            near(e.velocity[0], p.velocity[0], 0.02) && near(e.velocity[1], p.velocity[1], 0.02),
            "{}: {e:?}",
            p.name
        );
        assert!(near(e.gyration, p.gyration, 0.02), "{}: {e:?}", p.name);
        assert!(near(e.duration_s, p.period, 0.02 / 3.0), "{}: {e:?}", p.name);
        assert_eq!(e.parameters[0], e.velocity[1]);
        assert_eq!((e.clip, e.flags), (1, 0));
    }
}

/// A walk and a run have toe-offs on either side of the other foot's strike.
#[test]
fn keytimes_are_those_of_the_feet() {
    for duty in [0.6, 0.35] {
        let p = Puppet { duty, right: 0.45, ..Puppet::new("a", 1.0, 0.0) };
        let config = config("axes = [{ kind = 'speed' }]\nexamples = [{ clip = '*' }]");
        let spaces = fit(vec![p.clip(), Puppet::new("b", 2.0, 0.0).clip()], &config).expect("a space");
        let [left_off, right_strike, right_off] = spaces.spaces[0].examples[0].keytimes;
        // Generic time runs evenly between strikes.
        let generic = |phase: f32| {
            let phase = phase.rem_euclid(1.0);
            if phase < 0.45 { 0.5 * phase / 0.45 } else { 0.5 + 0.5 * (phase - 0.45) / 0.55 }
        };
        assert_eq!(right_strike, 0.5);
        assert!(
            near(left_off, generic(duty), 0.02) && near(right_off, generic(0.45 + duty), 0.02),
            "{duty}: {left_off}, {right_off}"
        );
    }
}

#[test]
fn mirrored_examples_turn_the_other_way() {
    let text = "axes = [{ kind = 'speed' }, { kind = 'gyration' }]\nexamples = [{ clip = '*', mirror = true }]";
    let clips = vec![Puppet::new("a", 1.0, 0.6).clip(), Puppet { right: 0.45, ..Puppet::new("b", 2.0, 0.9) }.clip()];
    let spaces = fit(clips, &config(text)).expect("a space");
    let [a, left, b, right] = spaces.spaces[0].examples[..] else { panic!("four examples") };
    assert_eq!(spaces.spaces[0].example_names, ["a", "a~mirror", "b", "b~mirror"]);
    assert!(near(a.gyration, -left.gyration, 1e-3) && near(b.gyration, -right.gyration, 1e-3));
    assert_eq!((left.flags, left.clip, right.clip), (ExampleRecord::IS_MIRRORED, 0, 1));
}

#[test]
fn styles_come_from_the_config_or_from_tags() {
    let text = "
        axes = [{ kind = 'style', name = 'mood', tags = { steady = 0.25 } }, { kind = 'speed' }]
        examples = [{ clip = 'slow' }, { clip = 'fast', style = { mood = 1 } }, { clip = 'slow_left', style = { mood = 2 } }]";
    let spaces = fit(six(), &config(text)).expect("a space");
    let moods: Vec<f32> = spaces.spaces[0].examples.iter().map(|e| e.parameters[0]).collect();
    assert_eq!(moods, [0.25, 1.0, 2.0]);
    let text = text.replace("steady", "sad");
    let e = fault(six(), &config(&text));
    assert!(e.contains("slow: it has no value on the style axis `mood`"), "{e}");
}

#[test]
fn who_stands_is_an_example_without_steps() {
    let spaces = fit(six(), &config(SIX)).expect("a space");
    let e = spaces.spaces[0].examples[5];
    assert_eq!((e.flags, e.keytimes, e.velocity, e.gyration), (ExampleRecord::IS_STILL, [0.0; 3], [0.0; 2], 0.0));
    // It breathes every three seconds.
    assert!(near(e.duration_s % 3.0, 0.0, 0.2) || near(e.duration_s % 3.0, 3.0, 0.2), "{e:?}");
    let e = fault(six(), &config(&SIX.replace("'idle'", "'slow'").replace("'slow*'", "'slow_left'")));
    assert!(e.contains("slow: it is not still"), "{e}");
}

#[test]
fn wrong_keytimes_are_named_with_the_clip_and_frames() {
    let steps = |change: &dyn Fn(&mut Clip)| {
        let mut clips = six();
        change(&mut clips[1]);
        fault(clips, &config(SIX))
    };
    // The left foot strikes at frames 15, 75, 135, ..., the right one at 45, 105, ....
    let e = steps(&|c| c.contacts[95..160].iter_mut().for_each(|c| c.0 &= Contacts::LEFT.0));
    assert!(e.contains("slow_left") && e.contains("left foot strikes at frame 75 and again at frame 135"), "{e}");
    let e = steps(&|c| c.contacts[85..90].iter_mut().for_each(|c| c.0 &= Contacts::RIGHT.0));
    assert!(e.contains("left foot strikes at frame 75 and again at frame 90"), "{e}");
    let e = steps(&|c| c.contacts.iter_mut().for_each(|c| *c = Contacts::RIGHT));
    assert!(e.contains("hold no two whole steps: 0 strikes"), "{e}");
    assert!(e.contains("annotate.contacts"), "the way out: {e}");
    // Hopping on both feet.
    let e = steps(&|c| c.contacts.iter_mut().for_each(|c| c.0 = if c.any(Contacts::LEFT) { 15 } else { 0 }));
    assert!(e.contains("both feet strike at frame 15"), "{e}");
    // Both feet stand after the right strike, neither before the left one: a gallop.
    let gallop = Puppet { right: 0.3, duty: 0.45, ..Puppet::new("slow_left", 0.8, 0.7) };
    let e = steps(&|c| *c = gallop.clip());
    assert!(e.contains("neither a walk nor a run"), "{e}");
}

#[test]
fn what_is_named_must_be_there() {
    let e = fault(six(), &config("axes = [{ kind = 'speed' }]\nexamples = [{ clip = 'jog*' }]"));
    assert!(e.contains("no clip `jog*` is there"), "{e}");
    let e = fault(six(), &config("axes = [{ kind = 'speed' }]\nexamples = [{ clip = 'slow', tag = 'sad' }]"));
    assert!(e.contains("no clip `slow` with tag `sad` is there"), "{e}");
}

#[test]
fn faults_of_examples_stand_where_the_config_names_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("x.toml");
    let axes = "[blend.walk]\naxes = [{ kind = 'style', name = 'mood' }, { kind = 'speed' }]\n";
    for (text, expected) in [
        (
            "examples = [{ clip = 'slow', style = { mood = 1 } }, { clip = 'jog' }]",
            "4:56: blend.walk.examples[1].clip: no clip `jog`",
        ),
        (
            "examples = [{ clip = 'slow', tag = 'sad' }]",
            "4:30: blend.walk.examples[0].tag: no clip `slow` with tag `sad`",
        ),
        (
            "examples = [{ clip = 'slow', frames = [9000, 9001] }]",
            "4:30: blend.walk.examples[0].frames: no clip `slow`",
        ),
        ("[[blend.walk.examples]]\nclip = 'slow'\nstyle.bad = 1", "6:7: blend.walk.examples[0].style.bad: expected"),
        (
            "[[blend.walk.examples]]\nclip = 'slow'\nstyle = {}",
            "6:1: blend.walk.examples[0].style: slow: it has no value",
        ),
        ("[[blend.walk.examples]]\nclip = 'slow'\nstill = true", "4:1: blend.walk.examples[0]: slow: it is not still"),
        ("[[blend.walk.examples]]\nclip = 'slow'\nsymmetric = true\nstill = true", "7:1: blend.walk.examples[0].still"),
        ("examples = [{ clip = '' }]", "4:15: blend.walk.examples[0].clip: expected a clip"),
        ("[[blend.walk.find]]\nclips = ['jog*']", "5:1: blend.walk.find[0].clips: no clip is there that matches"),
        ("[[blend.walk.find]]\nclips = ['*']\nclosing_deg = 200", "6:1: blend.walk.find[0].closing_deg: expected"),
        ("examples = [{ clip = 'slow', style = { mood = 1 } }]", "2:8: blend.walk: 2 axes need 3 examples"),
        (
            "for_each = ['jog', 'slow']\nexamples = [{ clip = '{}', style = { mood = 1 } }]",
            "5:15: blend.walk.examples[0].clip: space `walk-jog`: no clip `jog`",
        ),
    ] {
        std::fs::write(&path, format!("inputs = ['a']\n{axes}{text}\n")).expect("a config");
        let made = BuildConfig::load(&path).and_then(|config| examples::fit(&set(six()), &config.blend, &Silent));
        let e = made.expect_err(text).in_file(&path).to_string();
        assert!(e.contains(&format!("x.toml:{expected}")), "{e}, expected {expected}");
    }
}

#[test]
fn too_few_flat_and_coincident_examples_are_named() {
    let two_axes = "axes = [{ kind = 'speed' }, { kind = 'gyration' }]\n";
    let e = fault(six(), &config(&format!("{two_axes}examples = [{{ clip = 'slow*' }}]")));
    assert!(e.contains("2 axes need 3 examples at least, found 2: `slow`, `slow_left`"), "{e}");
    let mut clips = six();
    clips.push(Puppet::new("medium", 1.2, 0.0).clip());
    let straight = "examples = [{ clip = 'slow' }, { clip = 'medium' }, { clip = 'fast' }]";
    let e = fault(clips.clone(), &config(&format!("axes = [{{ kind = 'speed' }}, {{ kind = 'side' }}]\n{straight}")));
    assert!(e.contains("axis `side`"), "{e}");
    clips.push(Puppet::new("again", 1.2, 0.01).clip());
    let e = fault(
        clips,
        &config(&format!("{two_axes}examples = [{{ clip = 'slow*' }}, {{ clip = 'medium' }}, {{ clip = 'again' }}]")),
    );
    assert!(e.contains("examples `medium` and `again` lie at the same place"), "{e}");
}

/// Walks straight, then to the left, in one clip.
#[test]
fn long_clips_are_split_into_steady_pieces() {
    let (first, second) = (Puppet::new("a", 1.0, 0.0), Puppet::new("a", 1.0, 0.9));
    let (mut clip, then) = (first.clip(), second.clip());
    // The second one goes on where the first one is after four whole cycles.
    let n = 240;
    let join = first.frame(4.0).compose(second.frame(0.0).inverse());
    clip.root_positions.truncate(n);
    clip.rotations.truncate(n * throng_core::NUM_JOINTS);
    clip.contacts.truncate(n);
    for f in 0..then.num_frames() {
        let (p, mut local) = (then.root_positions[f], then.frame_rotations(f).to_vec());
        let ground = join.transform_point(glam::Vec2::new(p.x, p.z));
        local[0] = join.rotation() * local[0];
        clip.root_positions.push(glam::Vec3::new(ground.x, p.y, ground.y));
        clip.rotations.extend(local);
        clip.contacts.push(then.contacts[f]);
    }
    clip.name = "both".into();
    let text = "axes = [{ kind = 'speed' }, { kind = 'gyration' }]\nfind = [{ clips = ['both', 'fast*'] }]\ngyration_tolerance = 0.15";
    let spaces = fit([vec![clip], six()].concat(), &config(text)).expect("a space");
    let space = &spaces.spaces[0];
    let of: Vec<(&str, f32)> =
        space.example_names.iter().map(String::as_str).zip(space.examples.iter().map(|e| e.gyration)).collect();
    let has = |w: f32| of.iter().any(|(name, g)| name.starts_with("both [") && near(*g, w, 0.03));
    assert!(has(0.0) && has(0.9), "{of:?}");
    assert!(of.iter().filter(|(name, _)| name.starts_with("both")).count() <= 3, "{of:?}");
}

#[test]
fn what_is_found_but_irregular_is_left_out_with_a_warning() {
    let mut clips = six();
    let hop = &mut clips[1];
    hop.contacts.iter_mut().for_each(|c| c.0 = if c.any(Contacts::LEFT) { 15 } else { 0 });
    clips.push(idle());
    let text = "axes = [{ kind = 'speed' }]\nfind = [{ clips = ['slow*', 'fast'] }]";
    let spaces = fit(clips, &config(text)).expect("a space");
    assert_eq!(spaces.spaces[0].example_names, ["slow", "fast"]);
    let warnings = &spaces.warnings.messages;
    assert!(
        warnings.len() == 1 && warnings[0].contains("`slow_left`") && warnings[0].contains("both feet"),
        "{warnings:?}"
    );
}

/// Nearly always on both feet, which strike at once: neither walk nor run, but not seen by how long they stand.
#[test]
fn feet_that_strike_together_make_no_cycle() {
    let shuffle = Puppet { right: 0.0, duty: 0.95, ..Puppet::new("shuffle", 0.5, 0.0) };
    let clips = [vec![shuffle.clip()], six()].concat();
    let axes = "axes = [{ kind = 'speed' }]\n";
    let spaces = fit(clips.clone(), &config(&format!("{axes}find = [{{ clips = ['*'] }}]"))).expect("a space");
    assert!(spaces.spaces[0].example_names.iter().all(|n| !n.starts_with("shuffle")));
    let why = |m: &String| m.contains("`shuffle`") && m.contains("both feet strike at frame 15");
    assert!(spaces.warnings.messages.iter().any(why), "{:?}", spaces.warnings.messages);
    let e = fault(clips, &config(&format!("{axes}examples = [{{ clip = 'shuffle' }}, {{ clip = 'fast' }}]")));
    assert!(e.contains("shuffle: both feet strike at frame 15"), "{e}");
}

#[test]
fn every_usable_run_of_a_clip_is_searched() {
    // Slow, then what may not be used, then fast: two stretches of one clip.
    let (slow, fast) = (Puppet::new("both", 1.0, 0.0).clip(), Puppet::new("both", 2.0, 0.0).clip());
    let mut clip = slow.clone();
    clip.root_positions.extend(&fast.root_positions);
    clip.rotations.extend(&fast.rotations);
    clip.contacts.extend(&fast.contacts);
    let (n, gap) = (slow.num_frames(), 3);
    clip.excluded = vec![Exclusion { range: n - gap..n + gap, reason: ExclusionReason::Sidecar }];
    let text = "axes = [{ kind = 'speed' }]\nfind = [{ clips = ['both'] }]";
    let spaces = fit(vec![clip], &config(text)).expect("a space");
    let speeds: Vec<f32> = spaces.spaces[0].examples.iter().map(|e| e.velocity[1]).collect();
    assert!(matches!(speeds[..], [a, b] if near(a, 1.0, 0.02) && near(b, 2.0, 0.02)), "{speeds:?}");
}

#[test]
fn a_box_so_wide_that_weights_run_away_is_refused_by_its_axis() {
    let text = "
        axes = [{ kind = 'speed' }, { kind = 'gyration', range = [-900.0, 1.0] }]
        examples = [{ clip = 'slow' }, { clip = 'slow_left' }, { clip = 'fast' }]
        weight_tolerance = 0.5";
    let e = fault(six(), &config(text));
    assert!(e.starts_with("blend.walk.axes[1].range: [-900, 1] of axis `gyration`") && e.contains("below 1000"), "{e}");
}
