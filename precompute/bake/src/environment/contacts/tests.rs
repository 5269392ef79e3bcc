use super::super::placed::tests::placed;
use super::*;
use glam::Quat;
use throng_core::{Joint, NUM_JOINTS};
use throng_motion::clip::Exclusion;

const UNITS: &str = "[[units]]\nname = \"step\"\nshapes = [{ box = { at = [0.0, 0.15, 0.0], size = [1.0, 0.3, 0.6] } }]\n\
    [[units]]\nname = \"bar\"\nshapes = [{ bar = { from = [-1.0, 2.6, 0.0], to = [1.0, 2.6, 0.0], radius = 0.02 } }]\n\
    [[units]]\nname = \"slide\"\nshapes = [{ box = { at = [0.0, 1.0, 0.0], size = [0.8, 0.1, 6.0], pitch_deg = 30.0 } }]\n";

/// A clip of a body that moves as a whole: hips positions by frame, the local rotation of every joint by index.
fn clip(positions: Vec<Vec3>, local: impl Fn(usize) -> Quat) -> Clip {
    let n = positions.len();
    Clip {
        excluded: Vec::<Exclusion>::new(),
        ..Clip::new("c", 30.0, positions, (0..n).flat_map(|_| (0..NUM_JOINTS).map(&local)).collect())
    }
}

fn annotated(mut clip: Clip, environment: &PlacedGeometry) -> Clip {
    let s = Skeleton::default();
    annotate_in(&mut clip, &s, environment, &ContactConfig::default(), &GeometryTouchConfig::default());
    clip
}

fn at_feet(feet: Vec3) -> Vec3 {
    Skeleton::default().offsets[0] + feet
}

const FEET: Contacts = Contacts(15);

#[test]
fn a_step_up_is_supported_by_the_ground_and_then_by_the_step() {
    let environment = placed(UNITS, "{ unit = \"step\", at = [0.0, 0.0, 1.0] }");
    // A second on the ground, a second through the air, a second on the step.
    let way = |f: usize| {
        let t = ((f as f32 - 30.0) / 30.0).clamp(0.0, 1.0);
        let arc = 0.6 * (t * std::f32::consts::PI).sin();
        at_feet(Vec3::new(0.0, 0.3 * t + arc, t))
    };
    let c = annotated(clip((0..90).map(way).collect(), |_| Quat::IDENTITY), &environment);
    assert_eq!((c.contacts[10], c.contacts[45], c.contacts[75]), (FEET, Contacts::NONE, FEET));
    assert_eq!((c.support[10], c.support[45]), (0.0, 0.0), "held through the air");
    assert!((c.support[75] - 0.3).abs() < 1e-3, "{}", c.support[75]);
    assert_eq!(c.support.len(), 90);
}

#[test]
fn feet_in_the_air_beside_a_step_are_not_planted() {
    let environment = placed(UNITS, "{ unit = \"step\", at = [0.0, 0.0, 1.0] }");
    let c = annotated(clip(vec![at_feet(Vec3::new(0.0, 0.3, 0.2)); 60], |_| Quat::IDENTITY), &environment);
    assert!(c.contacts.iter().all(|c| *c == Contacts::NONE));
    assert!(c.support.is_empty());
}

#[test]
fn hanging_from_a_bar_is_holding_it_with_both_hands() {
    let environment = placed(UNITS, "{ unit = \"bar\", at = [0.0, 0.0, 0.0] }");
    // Arms up: the palms are 0.06 m beyond the wrists, which hang 0.05 m below the bar's axis.
    let up = |j: usize| match Joint::ALL[j] {
        Joint::LeftUpperArm => Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
        Joint::RightUpperArm => Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
        _ => Quat::IDENTITY,
    };
    let wrist = {
        let c = clip(vec![Vec3::ZERO], up);
        c.joint_positions(&Skeleton::default(), 0)[Joint::LeftHand.index()]
    };
    let hang = |down: f32| Vec3::new(0.0, 2.6 - wrist.y - down, 0.0);
    let hands = Contacts(Contacts::LEFT_HAND.0 | Contacts::RIGHT_HAND.0);
    let c = annotated(clip(vec![hang(0.05); 60], up), &environment);
    assert!(c.contacts.iter().all(|c| *c == hands), "{:?}", c.contacts[30]);
    assert!(c.support.iter().all(|s| (2.57..=2.63).contains(s)), "{}", c.support[30]);
    let c = annotated(clip(vec![hang(0.3); 60], up), &environment);
    assert!(c.contacts.iter().all(|c| *c == Contacts::NONE));
    // Swinging past at 2 m/s is no grip.
    let past = (0..60).map(|f| hang(0.05) + Vec3::Z * ((f as f32 - 30.0) / 15.0)).collect();
    let c = annotated(clip(past, up), &environment);
    assert!(c.contacts.iter().all(|c| *c == Contacts::NONE));
}

/// Thighs and shins straight ahead, trunk upright.
fn sitting(j: usize) -> Quat {
    match Joint::ALL[j] {
        Joint::LeftThigh | Joint::RightThigh => Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
        _ => Quat::IDENTITY,
    }
}

#[test]
fn the_seat_slides_in_contact_but_does_not_land_in_contact() {
    let environment = placed(UNITS, "{ unit = \"slide\", at = [0.0, 1.0, 0.0] }");
    // Thigh joints 0.092 m above the surface, down a slope of 30 degrees at 2 m/s.
    let (s, c) = 30f32.to_radians().sin_cos();
    let seat = |along: f32, above: f32| {
        let surface = Vec3::new(0.0, 2.0 - s * along + c * 0.05, c * along + s * 0.05);
        let hips = surface + Vec3::new(0.0, c, s) * (0.092 + above);
        hips - Vec3::Y * Skeleton::default().offsets[Joint::LeftThigh.index()].y
    };
    let slid = (0..60).map(|f| seat(-2.0 + 2.0 * f as f32 / 30.0, 0.0)).collect();
    let clip_slid = annotated(clip(slid, sitting), &environment);
    assert!(clip_slid.contacts.iter().all(|c| *c == Contacts::SEAT), "{:?}", clip_slid.contacts[30]);
    let fall = clip_slid.support[10] - clip_slid.support[40];
    assert!((fall - 2.0 * s).abs() < 0.02, "the support goes down with the slide: {fall}");
    // Down onto the surface at 1 m/s: planted only when it has come to rest.
    let landing = (0..60).map(|f| seat(0.0, (1.0 - f as f32 / 30.0).max(0.0))).collect();
    let c = annotated(clip(landing, sitting), &environment);
    assert!(c.contacts[..29].iter().all(|c| !c.any(Contacts::SEAT)));
    assert!(c.contacts[32..].iter().all(|c| c.any(Contacts::SEAT)));
}

#[test]
fn supports_are_held_between_contacts_and_taken_from_the_first() {
    let none = f32::INFINITY;
    assert_eq!(hold_values(&[none, 0.2, none, 0.5, none]), [0.2, 0.2, 0.2, 0.5, 0.5]);
    assert!(hold_values(&[none, 0.0, 1e-4]).is_empty());
    assert!(hold_values(&[none, none]).is_empty());
}
