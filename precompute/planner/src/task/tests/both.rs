//! Both hands at one object.

use super::*;
use throng_core::Joint;

/// A crate that both hands take off one table and put onto another.
const CRATE: &str = r#"
clip = "stand.bvh"

[[scene.obstacles]]
name = "table"
shape = { box = { size = [0.4, 0.02, 0.2] } }
at = [0.1, 1.0, 0.5]

[[scene.obstacles]]
name = "shelf"
shape = { box = { size = [0.4, 0.02, 0.2] } }
at = [-0.1, 1.3, 0.52]

[[scene.objects]]
name = "crate"
shape = { box = { size = [0.26, 0.12, 0.16] } }
at = [0.08, 1.071, 0.48]

[[tasks]]
limb = "left_arm"
do = "grab"
object = "crate"
at_s = 1.0
window_s = [0.1, 4.8]
grips = [{ at = [0.14, 0.0, -0.03] }]
second = { limb = "right_arm", grips = [{ at = [-0.14, 0.0, -0.03] }] }

[[tasks]]
limb = "left_arm"
do = "carry"
object = "crate"
to = { at = [0.0, 1.2, 0.3], turn_deg = [0.0, 0.0, 0.0] }
at_s = 2.2
window_s = [1.2, 4.8]

[[tasks]]
limb = "left_arm"
do = "drop"
object = "crate"
to = { on = "shelf", at = [0.08, 0.071, -0.03], turn_deg = [0.0, 0.0, 0.0] }
at_s = 3.6
window_s = [2.6, 4.8]
"#;

#[test]
fn both_hands_carry_a_crate() {
    let s = TestCharacter::standing();
    let outcome = run(CRATE, &s);
    assert!(outcome.is_solved(), "{:?}", outcome.done.iter().map(|d| &d.reason).collect::<Vec<_>>());
    assert_eq!(outcome.recheck.violations, []);
    assert!(outcome.recheck.second_hand_off_m < 2e-3, "{}", outcome.recheck.second_hand_off_m);
    let held: Vec<_> =
        outcome.attachments.iter().map(|a| (a.joint.as_deref(), a.second.as_deref(), a.from_s)).collect();
    assert_eq!(held, [(None, None, 0.0), (Some("left_hand"), Some("right_hand"), 1.0), (None, None, 3.6)]);
    let at = |t: f64| outcome.scenery[1].paths[2].place_at(t).position;
    assert!(at(2.2).distance(glam::DVec3::new(0.0, 1.2, 0.3)) < 1e-4 && at(4.9).y > 1.36);
    // By the clip alone: how far apart the hands are, and how the second one is turned, is the same all along.
    let clip = &outcome.clips[0][1];
    let seen = |f: usize| {
        let all = clip.joint_transforms(&s.skeleton, f);
        let [(a, turn), (b, other)] = [Joint::LeftHand, Joint::RightHand].map(|j| all[j.index()]);
        (turn.inverse() * (b - a), turn.inverse() * other)
    };
    let first = seen(30);
    let turned = |f: usize| 2.0 * (seen(f).1.inverse() * first.1).xyz().length();
    assert!((30..=108).all(|f| seen(f).0.distance(first.0) < 1e-4 && turned(f) < 1e-3));
    assert!(seen(115).0.distance(first.0) > 1e-3);
    // Both arms are where the clip has them before and after.
    assert!([2, 145].into_iter().all(|f| clip.frame_rotations(f) == outcome.clips[0][0].frame_rotations(f)));
}

#[test]
fn what_is_level_stays_upright_on_its_way() {
    let s = TestCharacter::standing();
    let level = |text: &str| {
        text.replace("\nat_s = 2.2", "\nlevel_deg = 8.0\nat_s = 2.2")
            .replace("\nat_s = 3.6", "\nlevel_deg = 8.0\nat_s = 3.6")
    };
    // How far it tilts in both hands, by the thing's path.
    let tilt = |outcome: &TaskOutcome| {
        let path = &outcome.scenery[1].paths[2];
        (0..130)
            .map(|i| (path.place_at(1.0 + 0.02 * f64::from(i)).rotation * glam::DVec3::Y).angle_between(glam::DVec3::Y))
            .fold(0.0, f64::max)
    };
    for seed in 1..6 {
        let seeded = |text: &str| format!("{text}\n[planner]\nseed = {seed}\n");
        let outcome = run(&seeded(&level(CRATE)), &s);
        assert!(outcome.is_solved(), "{:?}", outcome.done.iter().map(|d| &d.reason).collect::<Vec<_>>());
        assert_eq!(outcome.recheck.violations, []);
        assert!(tilt(&outcome) < 8.1f64.to_radians(), "{seed}: {}", tilt(&outcome).to_degrees());
    }
    for (from, to, says) in [
        ("level_deg = 8.0", "level_deg = 0.0", "expected 0 to 180"),
        ("do = \"grab\"", "do = \"grab\"\nlevel_deg = 8.0", "needs no `level_deg`"),
    ] {
        let e = parse(&level(CRATE).replace(from, to)).unwrap_err();
        assert!(e.contains(says), "{e}");
    }
}

#[test]
fn what_the_second_hand_cannot_do_is_said() {
    let s = TestCharacter::standing();
    let far = run(&CRATE.replace("[{ at = [-0.14, 0.0, -0.03] }]", "[{ at = [-0.64, 0.0, 0.4] }]"), &s);
    assert!(why(&far, 0).starts_with("right arm: ") && why(&far, 0).contains("out of reach by 0."), "{}", why(&far, 0));
    assert!(why(&far, 1).contains("does not hold `crate`") && far.recheck.violations.is_empty());
    // It is known before any search, too.
    let ahead = |text: &str| {
        let task = parse(text).expect("a task");
        task.preview_steps(&[ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }]).expect("clips")[0]
            .faults
            .clone()
    };
    let far = ahead(&CRATE.replace("[{ at = [-0.14, 0.0, -0.03] }]", "[{ at = [-0.64, 0.0, 0.4] }]"));
    assert!(far.len() == 1 && far[0].starts_with("right arm: not reached") && ahead(CRATE).is_empty(), "{far:?}");
    // What cannot be put down stays in both hands.
    let kept = run(&CRATE.replace("to = { on = \"shelf\", at = [0.08,", "to = { on = \"shelf\", at = [0.98,"), &s);
    assert!(
        why(&kept, 2).contains("not reached at 3.60 s") && kept.recheck.violations.is_empty(),
        "{:?}",
        kept.recheck
    );
    assert_eq!(kept.attachments.last().and_then(|a| a.second.as_deref()), Some("right_hand"));
    // And where nothing came of the first task with it, on the table.
    let mut lies = CRATE[..CRATE.find("[[tasks]]\nlimb = \"left_arm\"\ndo = \"carry\"").expect("a task")].to_owned();
    lies += &CRATE[CRATE.rfind("[[tasks]]").expect("a task")..];
    let lies = run(&lies.replace("to = { on = \"shelf\", at = [0.08,", "to = { on = \"shelf\", at = [0.98,"), &s);
    assert!(
        why(&lies, 1).contains("not reached at 3.60 s") && lies.recheck.violations.is_empty(),
        "{:?}",
        lies.recheck
    );
    // One hand alone does nothing else as long as both hold something.
    let bell = "[[scene.obstacles]]\nname = \"bell\"\nshape = { ball = { radius = 0.03 } }\nat = [-0.3, 1.2, 0.4]\n";
    let touch = "[[tasks]]\nlimb = \"right_arm\"\ndo = \"touch\"\nobject = \"bell\"\nat_s = 2.4\nwindow_s = [2.3, 2.5]\ngrips = [{}]\n";
    let busy = run(&format!("{}{touch}", CRATE.replace("[[scene.objects]]", &format!("{bell}[[scene.objects]]"))), &s);
    assert!(why(&busy, 3).contains("and the other one hold `crate`"), "{}", why(&busy, 3));
    for (from, to, says) in [
        ("limb = \"right_arm\", grips", "limb = \"left_arm\", grips", "expected the other arm"),
        ("limb = \"right_arm\", grips", "limb = \"right_leg\", grips", "expected the other arm"),
        ("do = \"grab\"", "do = \"reach\"", "expected `second` in `grab` alone"),
    ] {
        let e = parse(&CRATE.replace(from, to)).unwrap_err();
        assert!(e.contains(says) && e.contains("t.toml:"), "{e}");
    }
}
