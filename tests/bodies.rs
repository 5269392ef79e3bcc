//! Bodies of policy characters on real motion: feet on uneven ground, heads that look, palms that reach.

use crate::common;
use glam::{Vec2, Vec3};
use throng_core::body::{ArmLayer, BodyEventKind, BodyLayers, HeightField};
use throng_core::characters::{CharactersConfig, PolicyCharacters, PolicyOrder, Spawn};
use throng_core::{Bundle, CharacterGroup, Contacts, Inline, Joint, Planar, Skeleton};

const DT_S: f32 = 1.0 / 60.0;
const PEOPLE: usize = 11;
/// Fastest knee: that of a sprinter, to which the foot lock keeps legs in the air, and what little the hips add (rad/s).
const KNEE_RATE: f32 = 18.6;
const LEGS: [[Joint; 4]; 2] = [
    [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot, Joint::LeftToe],
    [Joint::RightThigh, Joint::RightShin, Joint::RightFoot, Joint::RightToe],
];

fn people(tables: &Bundle, ground: HeightField) -> PolicyCharacters {
    let mut people =
        PolicyCharacters::with_capacity(tables, PEOPLE, CharactersConfig::default()).expect("policy characters");
    people.set_ground(ground);
    for c in 0..PEOPLE {
        let root = Planar::new(3.0 * c as f32, 0.4 * c as f32, 0.7 * c as f32);
        people
            .spawn(Spawn { root, state: Some((37 * c % tables.graph().states.len()) as u32), floor_m: 0.0 })
            .expect("room");
    }
    people
}

/// Orders that lead each about a place of its own.
fn order(c: usize, time_s: f32) -> PolicyOrder {
    let angle = 0.25 * time_s + 0.8 * c as f32;
    PolicyOrder::towards(0, Vec3::new(3.0 * c as f32 + 4.0 * angle.sin(), 0.0, 4.0 * angle.cos()))
}

/// Bottom of the heel, and of the ball where the foot is flat, in the world (m).
fn sole(people: &PolicyCharacters, skeleton: &Skeleton, c: usize, side: usize) -> [Vec3; 2] {
    let body = people.bodies();
    let body = body.get(people.ids()[c]).expect("a body");
    let [_, _, foot, toe] = LEGS[side];
    let heel = body.world(foot).transform_point3(skeleton.heels()[side]);
    let up = Vec3::Y * skeleton.rest_positions()[toe.index()].y;
    [heel, body.position(toe) - up]
}

/// Heels and balls, which of them are planted, angles of the knees (rad), and height of the hips (m).
type Moment = ([[Vec3; 2]; 2], [[bool; 2]; 2], [f32; 2], f32);

struct Seen {
    /// Distances of planted parts from the ground (m), and their speeds (m/s), ascending.
    gaps: Vec<f32>,
    speeds: Vec<f32>,
    /// Deepest that a toe goes below the ground (m), fastest knee (rad/s), fastest hips up or down (m/s).
    deepest: f32,
    knee_rate: f32,
    hips_mps: f32,
}

fn p95(values: &[f32]) -> f32 {
    values[values.len() * 95 / 100]
}

/// - `pushes`: every 0.6 s, each is pushed by up to 0.1 m.
fn walk(ground: &HeightField, pushes: bool) -> Seen {
    let tables = common::tables();
    let skeleton = tables.skeleton().clone();
    let mut people = people(&tables, ground.clone());
    let mut seen = Seen { gaps: Vec::new(), speeds: Vec::new(), deepest: 0.0, knee_rate: 0.0, hips_mps: 0.0 };
    let mut before: Vec<Option<Moment>> = vec![None; PEOPLE];
    for k in 0..900 {
        for c in 0..PEOPLE {
            people.order(people.ids()[c], order(c, k as f32 * DT_S)).expect("an order");
        }
        if pushes && k % 36 == 20 {
            for c in 0..PEOPLE {
                let angle = (k + 29 * c) as f32;
                let to = Vec3::new(0.1 * angle.sin(), 0.0, 0.1 * angle.cos());
                let joint = [Joint::UpperChest, Joint::Head, Joint::Hips, Joint::Chest][(k / 36 + c) % 4];
                people.push(people.ids()[c], joint, to).expect("a push");
            }
        }
        people.step(DT_S, &Inline).expect("a step");
        if k < 30 {
            continue;
        }
        for (c, before) in before.iter_mut().enumerate() {
            let id = people.ids()[c];
            let contacts = people.contacts(id).expect("contacts");
            let soles = [0, 1].map(|side| sole(&people, &skeleton, c, side));
            let down = [0, 1].map(|side| [0, 1].map(|part| contacts.any(Contacts::FEET[side][part])));
            let bodies = people.bodies();
            let body = bodies.get(id).expect("a body");
            let knees = LEGS.map(|[thigh, shin, foot, _]| {
                let [a, b, d] = [thigh, shin, foot].map(|j| body.position(j));
                (b - a).angle_between(d - b)
            });
            let hips = body.position(Joint::Hips).y;
            for side in 0..2 {
                for part in 0..2 {
                    let p = soles[side][part];
                    let over = p.y - ground.ground_at(Vec2::new(p.x, p.z), 0.0).height;
                    if down[side][part] {
                        seen.gaps.push(over.abs());
                    }
                    if part == 1 {
                        seen.deepest = seen.deepest.max(-over);
                    }
                }
            }
            let now = (soles, down, knees, hips);
            let Some((was, was_down, was_knees, was_hips)) = before.replace(now) else { continue };
            seen.hips_mps = seen.hips_mps.max((hips - was_hips).abs() / DT_S);
            for side in 0..2 {
                seen.knee_rate = seen.knee_rate.max((knees[side] - was_knees[side]).abs() / DT_S);
                for part in 0..2 {
                    if down[side][part] && was_down[side][part] {
                        seen.speeds.push((soles[side][part] - was[side][part]).length() / DT_S);
                    }
                }
            }
        }
    }
    seen.gaps.sort_by(f32::total_cmp);
    seen.speeds.sort_by(f32::total_cmp);
    seen
}

/// Ground of a height (m) at knots so far apart (m).
fn field(spacing: f32, height: impl Fn(Vec2) -> f32) -> HeightField {
    let n = (70.0 / spacing) as usize + 1;
    let origin = Vec2::new(-20.0, -30.0);
    let at = |i: usize| origin + spacing * Vec2::new((i % n) as f32, (i / n) as f32);
    HeightField::new(origin, spacing, [n, n], (0..n * n).map(|i| height(at(i))).collect()).expect("a field")
}

#[test]
fn feet_of_policy_characters_stand_on_uneven_ground() {
    let flat = walk(&HeightField::flat(), false);
    println!("flat: off {} m, slip {} m/s, knees {} rad/s", p95(&flat.gaps), p95(&flat.speeds), flat.knee_rate);
    for (name, ground) in [
        ("slope of 0.15", field(2.0, |p| 0.15 * p.y)),
        ("side slope of 0.2", field(2.0, |p| 0.2 * p.x)),
        ("hills", field(0.25, |p| 0.3 * (0.7 * p.x).sin() * (0.8 * p.y).cos())),
        ("stairs of 0.1 m", field(0.05, |p| 0.1 * (p.y / 0.4 + 1e-3).floor())),
    ] {
        let seen = walk(&ground, false);
        let (gap, slip) = (p95(&seen.gaps), p95(&seen.speeds));
        let worst = seen.speeds.last().expect("planted feet");
        let Seen { deepest, knee_rate, hips_mps, .. } = seen;
        println!(
            "{name}: off {gap} m, {deepest} m deep, slip {slip} {worst} m/s, knees {knee_rate} rad/s, hips {hips_mps} m/s"
        );
        assert!(gap < p95(&flat.gaps) + 0.015, "{name}: {gap} m off the ground, {} on flat ground", p95(&flat.gaps));
        assert!(deepest < flat.deepest + 0.04, "{name}: a toe is {deepest} m deep");
        assert!(slip < p95(&flat.speeds) + 0.08, "{name}: slips at {slip} m/s, {} on flat ground", p95(&flat.speeds));
        assert!(knee_rate < KNEE_RATE, "{name}: a knee turns at {knee_rate} rad/s");
        assert!(hips_mps < flat.hips_mps + 1.2, "{name}: hips go up or down at {hips_mps} m/s");
    }
}

#[test]
fn who_is_told_to_turn_by_any_angle_turns_and_stands() {
    let tables = common::tables();
    let mut people = people(&tables, HeightField::flat());
    let ids = people.ids().to_vec();
    let order_all = |people: &mut PolicyCharacters, order: &dyn Fn(usize, f32) -> PolicyOrder, seconds: f32| {
        for (c, id) in ids.iter().enumerate() {
            let heading = people.bodies().get(*id).expect("a body").root.heading;
            people.order(*id, order(c, heading)).expect("an order");
        }
        (0..(seconds / DT_S) as usize).for_each(|_| people.step(DT_S, &Inline).expect("a step"));
    };
    order_all(&mut people, &|_, _| PolicyOrder::STOP, 4.0);
    let stood: Vec<f32> = ids.iter().map(|id| people.bodies().get(*id).expect("a body").root.heading).collect();
    // From a quarter of a turn to nearly half a turn, to both sides.
    let turn = |c: usize| if c.is_multiple_of(2) { 1.5 + 0.15 * c as f32 } else { -1.5 - 0.15 * c as f32 };
    order_all(&mut people, &|c, heading| PolicyOrder::turn_to(heading + turn(c)), 6.0);
    for (c, id) in ids.iter().enumerate() {
        let left = stood[c] + turn(c) - people.bodies().get(*id).expect("a body").root.heading;
        let left = left.sin().atan2(left.cos()).abs();
        assert!(left < 0.5, "{c} was told to turn by {} rad, and {left} are left", turn(c));
    }
}

#[test]
fn walking_feet_stay_planted_while_bodies_are_pushed() {
    let ground = HeightField::flat();
    let [calm, pushed] = [false, true].map(|pushes| walk(&ground, pushes));
    for (name, seen) in [("calm", &calm), ("pushed", &pushed)] {
        let Seen { gaps, speeds, deepest, knee_rate, hips_mps } = seen;
        let worst = speeds.last().expect("planted feet");
        println!(
            "{name}: off {} m, {deepest} m deep, slip {} {worst} m/s, knees {knee_rate} rad/s, hips {hips_mps} m/s",
            p95(gaps),
            p95(speeds)
        );
    }
    assert!(p95(&pushed.speeds) < p95(&calm.speeds) + 0.02, "planted feet slip");
    assert!(p95(&pushed.gaps) < p95(&calm.gaps) + 0.01, "planted feet leave the ground");
    assert!(pushed.deepest < calm.deepest + 0.005, "toes go into the ground");
    assert!(pushed.knee_rate < 1.4 * calm.knee_rate, "a knee snaps");
    assert!(pushed.hips_mps < calm.hips_mps + 1.0, "hips jump");
}

/// Characters that walk for a time, each with layers that depend on its root.
fn walk_with(layers: impl Fn(usize, Planar) -> BodyLayers, seconds: f32) -> (PolicyCharacters, Skeleton) {
    walk_ordered(|c, t, _| order(c, t), layers, seconds)
}

/// Characters with orders that depend on their number, the time (s) and their root.
fn walk_ordered(
    order: impl Fn(usize, f32, Planar) -> PolicyOrder,
    layers: impl Fn(usize, Planar) -> BodyLayers,
    seconds: f32,
) -> (PolicyCharacters, Skeleton) {
    let tables = common::tables();
    let mut people = people(&tables, HeightField::flat());
    for k in 0..(seconds / DT_S) as usize {
        for c in 0..PEOPLE {
            let id = people.ids()[c];
            let root = people.bodies().roots[c];
            people.order(id, order(c, k as f32 * DT_S, root).with_layers(layers(c, root))).expect("an order");
        }
        people.step(DT_S, &Inline).expect("a step");
    }
    (people, tables.skeleton().clone())
}

fn in_world(root: Planar, point: Vec3) -> Vec3 {
    root.rotation() * point + root.translation()
}

#[test]
fn heads_of_policy_characters_turn_to_what_they_look_at() {
    // Every second one looks at a point to its left.
    let aside = Vec3::new(1.6, 1.6, 1.9);
    let layers = |c: usize, root| BodyLayers {
        look_at: c.is_multiple_of(2).then(|| in_world(root, aside)),
        ..BodyLayers::default()
    };
    // Straight on: who walks an arc turns away from what it looks at all the time.
    let ahead = |_, _, root| PolicyOrder::towards(0, in_world(root, 5.0 * Vec3::Z));
    let (people, _) = walk_ordered(ahead, layers, 3.0);
    let (plain, _) = walk_ordered(ahead, |_, _| BodyLayers::default(), 3.0);
    for c in 0..PEOPLE {
        let [body, same] = [&people, &plain].map(|p| *p.bodies().model.get(c).expect("a pose"));
        if c % 2 == 1 {
            assert!(body == same, "character {c} looks at nothing");
            continue;
        }
        let head = body[Joint::Head.index()];
        let forward = head.rotation() * Vec3::Z;
        let off = forward.angle_between(aside - head.translation()).to_degrees();
        let before = (same[Joint::Head.index()].rotation() * Vec3::Z).angle_between(aside - head.translation());
        // The point moves with the root, which turns and sways as it walks.
        assert!(off < 12.0, "character {c} looks {off} degrees past it; {} without", before.to_degrees());
        assert!(before.to_degrees() > 20.0, "it would not have looked there by itself");
    }
}

#[test]
fn palms_of_policy_characters_reach_high_and_low() {
    for (height, ahead, near) in [(1.2, 0.4, 0.02), (0.95, 0.55, 0.03), (0.35, 0.45, 0.05)] {
        let at = Vec3::new(0.2, height, ahead);
        let reach = |root| ArmLayer::Reach { place: (in_world(root, at), 1.0), level: (Vec3::ZERO, 0.0) };
        let layers = |c: usize, root| BodyLayers {
            arms: if c.is_multiple_of(2) { [Some(reach(root)), None] } else { [None; 2] },
            ..BodyLayers::default()
        };
        let (people, skeleton) = walk_with(layers, 2.0);
        let (plain, _) = walk_with(|_, _| BodyLayers::default(), 2.0);
        for c in 0..PEOPLE {
            let [body, same] = [&people, &plain].map(|p| *p.bodies().model.get(c).expect("a pose"));
            if c % 2 == 1 {
                let moved = body.iter().zip(&same).map(|(a, b)| a.translation().distance(b.translation()));
                assert!(moved.fold(0.0, f32::max) < 1e-4, "character {c} reaches for nothing");
                continue;
            }
            let hand = body[Joint::LeftHand.index()];
            let palm = hand.translation() + hand.rotation() * (skeleton.offsets[Joint::LeftHand.index()] * 0.35);
            // The place is of the root before the step, which has gone on by a few centimetres.
            let off = palm.distance(at) - 1.8 * DT_S;
            assert!(off < near, "character {c} is {off} m from a place {height} m high");
            for (side, [.., foot, _]) in LEGS.into_iter().enumerate() {
                let [a, b] = [body, same].map(|pose| pose[foot.index()].translation());
                assert!(a.distance(b) < 0.03, "character {c}: reaching moves foot {side} by {} m", a.distance(b));
            }
        }
    }
}

/// Joints that no layer but a reach may move.
const LOWER: [Joint; 9] = [
    Joint::Hips,
    Joint::LeftThigh,
    Joint::LeftShin,
    Joint::LeftFoot,
    Joint::LeftToe,
    Joint::RightThigh,
    Joint::RightShin,
    Joint::RightFoot,
    Joint::RightToe,
];

#[test]
fn layers_over_walking_leave_hips_legs_and_neighbours_as_they_are() {
    let tables = common::tables();
    let clip = tables.clips()[0];
    let of = |c: usize, root: Planar| {
        let arm = |number| ArmLayer::from_number(number, in_world(root, Vec3::new(1.0, 1.5, 3.0)));
        match c {
            0..=5 => BodyLayers { arms: [arm(1 + c), arm(6 - c)], ..BodyLayers::NONE },
            6 => BodyLayers {
                lean: [0.4, -0.2],
                look_at: Some(in_world(root, Vec3::new(2.0, 1.0, 2.0))),
                ..BodyLayers::NONE
            },
            7 => BodyLayers::NONE.with_clip(clip.first_frame..clip.first_frame + 60, !0, true),
            _ => BodyLayers::NONE,
        }
    };
    let ((people, _), (plain, _)) = (walk_with(of, 3.0), walk_with(|_, _| BodyLayers::NONE, 3.0));
    for c in 0..PEOPLE {
        let [body, same] = [&people, &plain].map(|p| *p.bodies().model.get(c).expect("a pose"));
        assert!(LOWER.iter().all(|j| body[j.index()] == same[j.index()]), "{c}: a layer moves hips or legs");
        assert_eq!(body == same, c >= 8, "{c}");
    }
    let events = |p: &PolicyCharacters| p.events().iter().map(|(id, e)| (*id, format!("{e:?}"))).collect::<Vec<_>>();
    assert_eq!(events(&people), events(&plain), "feet come down where they did");
}

#[test]
fn steps_of_policy_characters_take_turns_and_lie_below_their_soles() {
    let tables = common::tables();
    let skeleton = tables.skeleton().clone();
    let mut people = people(&tables, HeightField::flat());
    let mut steps: Vec<Vec<(usize, usize, Vec3)>> = vec![Vec::new(); PEOPLE];
    let mut seen = Vec::new();
    let mut way = [0.0f32; PEOPLE];
    for k in 0..1200 {
        for c in 0..PEOPLE {
            people.order(people.ids()[c], order(c, k as f32 * DT_S)).expect("an order");
        }
        let before = people.bodies().roots.to_vec();
        people.step(DT_S, &Inline).expect("a step");
        for (way, (a, b)) in way.iter_mut().zip(before.iter().zip(people.bodies().roots)) {
            *way += Vec2::new(b.x - a.x, b.z - a.z).length();
        }
        seen.push((0..PEOPLE).map(|c| [0, 1].map(|side| sole(&people, &skeleton, c, side))).collect::<Vec<_>>());
        for (id, e) in people.events().iter().filter(|(_, e)| e.kind == BodyEventKind::Footstep) {
            steps[id.index()].push((k, usize::from(e.number == Joint::RightFoot as u32), e.at));
        }
    }
    for (c, steps) in steps.iter().enumerate() {
        let turns = steps.windows(2).filter(|two| two[0].1 != two[1].1).count();
        let lengths = way[c] / steps.len() as f32;
        println!("{c}: {} steps, {turns} turns, {lengths} m a step", steps.len());
        assert!(steps.len() > 10 && turns * 10 >= (steps.len() - 1) * 9, "{c}: sides take turns");
        assert!((0.2..1.0).contains(&lengths), "{c}: {lengths} m a step");
        let mut off: Vec<f32> = steps
            .iter()
            .filter(|step| step.0 + 6 < seen.len())
            .map(|(k, side, at)| {
                let [heel, ball] = seen[k + 6][c][*side];
                let off = (heel + ball) * 0.5 - *at;
                Vec2::new(off.x, off.z).length()
            })
            .collect();
        off.sort_by(f32::total_cmp);
        assert!(p95(&off) < 0.03, "{c}: steps are off by {} m", p95(&off));
    }
}
