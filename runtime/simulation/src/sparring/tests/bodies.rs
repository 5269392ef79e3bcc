//! What a blow meets of a body.

use super::*;

fn met(pose: &[Mat3x4], blow: &Blow) -> Option<(StruckPart, Joint, f32)> {
    let (skeleton, config) = (Skeleton::default(), config());
    let body = SparringBody::new(&skeleton, &config.body);
    // Turned and moved: the blow comes along.
    let root = Planar::new(3.0, -1.0, 2.0);
    let blow = Blow {
        point: root.rotation() * blow.point + root.translation(),
        direction: root.rotation() * blow.direction,
        ..*blow
    };
    let (capsule, depth) = find_struck_capsule(&config, &body, &WorldPose::new(pose, root), &blow)?;
    Some((body.part_of(capsule), body.joint_of(capsule), depth))
}

#[test]
fn blows_meet_the_part_they_come_to() {
    let (pose, skeleton) = (rest_pose(), Skeleton::default());
    let p = skeleton.rest_positions();
    let at = |j: Joint| p[j.index()];
    let face = at(Joint::Head) + Vec3::new(0.0, 0.1, 0.12);
    for (point, part, joint) in [
        (face, StruckPart::Head, Joint::Head),
        (at(Joint::Head) + Vec3::new(0.13, 0.1, 0.0), StruckPart::Head, Joint::Head),
        (at(Joint::UpperChest) + Vec3::new(0.0, 0.05, 0.15), StruckPart::Trunk, Joint::UpperChest),
        (at(Joint::Spine) + Vec3::Z * 0.15, StruckPart::Trunk, Joint::Chest),
        (at(Joint::Hips) + Vec3::new(0.05, -0.03, 0.15), StruckPart::Pelvis, Joint::Hips),
        (at(Joint::LeftForearm) + Vec3::new(0.1, 0.0, 0.05), StruckPart::Arm, Joint::LeftForearm),
        (at(Joint::RightHand) + Vec3::new(-0.05, 0.02, 0.0), StruckPart::Arm, Joint::RightHand),
        (at(Joint::LeftShin) + Vec3::new(0.0, 0.2, 0.1), StruckPart::Leg, Joint::LeftThigh),
    ] {
        let (got, pushed, depth) = met(&pose, &blow(point, -Vec3::Z)).unwrap();
        assert_eq!((got, pushed), (part, joint), "{point}");
        assert!(depth > 0.0);
    }
    // The head is a capsule of 0.1 m, within whose reach of 0.06 m the fist is by 0.04 m.
    let (_, _, depth) = met(&pose, &blow(face, -Vec3::Z)).unwrap();
    assert!((depth - 0.04).abs() < 1e-5, "{depth}");
    assert_eq!(met(&pose, &blow(face + Vec3::Z * 0.05, -Vec3::Z)), None);
    assert_eq!(met(&pose, &blow(Vec3::new(0.0, 1.7, 1.0), -Vec3::Z)), None);
}

#[test]
fn an_arm_in_the_way_catches_a_blow() {
    let (mut pose, skeleton) = (rest_pose(), Skeleton::default());
    let face = skeleton.rest_positions()[Joint::Head.index()] + Vec3::new(0.0, 0.1, 0.12);
    // A forearm held upright before the face.
    let guard = |z: f32| {
        [(Joint::LeftForearm, -0.15), (Joint::LeftHand, 0.1)].map(|(joint, y)| {
            let at = face + Vec3::new(0.0, y, z);
            (joint, Mat3x4::from_rotation_translation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2), at))
        })
    };
    for (joint, m) in guard(0.1) {
        pose[joint.index()] = m;
    }
    assert_eq!(met(&pose, &blow(face, -Vec3::Z)).unwrap().0, StruckPart::Arm);
    for (joint, m) in guard(0.4) {
        pose[joint.index()] = m;
    }
    assert_eq!(met(&pose, &blow(face, -Vec3::Z)).unwrap().0, StruckPart::Head, "what the fist has passed long ago");
    for (joint, m) in guard(-0.3) {
        pose[joint.index()] = m;
    }
    assert_eq!(met(&pose, &blow(face, -Vec3::Z)).unwrap().0, StruckPart::Head, "what is behind the head");
}

#[test]
fn capsules_follow_the_joints_of_a_turned_pose() {
    let (skeleton, mut pose) = (Skeleton::default(), rest_pose());
    let (turn, at) = (Quat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 0.3), Vec3::new(0.3, 1.2, -0.2));
    pose[Joint::LeftHand.index()] = Mat3x4::from_rotation_translation(turn, at);
    let root = Planar::new(-2.0, 0.7, 1.9);
    let body = SparringBody::new(&skeleton, &BodyShape::default());
    let fist = body.capsules(&WorldPose::new(&pose, root))[8];
    let world = |p: Vec3| root.rotation() * p + root.translation();
    assert!(fist.ends[0].distance(world(at)) < 1e-5);
    assert!(fist.ends[1].distance(world(at + turn * striking_offset(&skeleton, Joint::LeftHand))) < 1e-5);
    assert_eq!(body.core_capsules(&WorldPose::new(&pose, root)).len(), NUM_CORE);
}

#[test]
fn radii_grow_with_the_skeleton() {
    let mut skeleton = Skeleton::default();
    skeleton.offsets.iter_mut().chain(&mut skeleton.tips).for_each(|o| *o *= 1.2);
    let pose = skeleton.rest_positions().map(|p| Mat3x4::from_rotation_translation(Quat::IDENTITY, p));
    let body = SparringBody::new(&skeleton, &BodyShape::default());
    for c in body.capsules(&WorldPose::new(&pose, Planar::IDENTITY)).iter().take(1) {
        assert!((c.radius - 0.12).abs() < 1e-5, "{}", c.radius);
    }
}

#[test]
fn overlapping_bodies_part_at_a_speed_that_grows_to_the_allowed_one() {
    let (skeleton, pose) = (Skeleton::default(), rest_pose());
    let body = SparringBody::new(&skeleton, &BodyShape::default());
    let poses = [Planar::IDENTITY, Planar::new(0.0, 0.1, 0.0)].map(|r| WorldPose::new(&pose, r));
    let (config, dt) = (SeparationConfig::default(), 1.0 / 60.0);
    let (lifted, stands) = (Contacts::LEFT, Contacts(Contacts::LEFT.0 | Contacts::RIGHT_TOE.0));
    let mut pair = pair::OpponentPair::default();
    let mut last = 0.0;
    for _ in 0..90 {
        pair.measure_overlap(&body, [&poses[0], &poses[1]], [lifted; 2], &config, dt);
        // Both are moved alike, away from each other.
        let [first, second] = pair.parting_displacements(dt).unwrap();
        let speed = (second.y - first.y) / dt;
        assert!((first + second).length() < 1e-7 && second.x.abs() < 1e-6);
        assert!(speed > last && speed < config.max_speed_mps);
        last = speed;
    }
    assert!(last > 0.95 * config.max_speed_mps, "{last}");
    (0..90).for_each(|_| pair.measure_overlap(&body, [&poses[0], &poses[1]], [stands, lifted], &config, dt));
    let [first, second] = pair.parting_displacements(dt).unwrap();
    assert!((first.length() / second.length() - 0.25).abs() < 0.01, "who stands on both feet is moved less");
    let off = SeparationConfig { enabled: false, ..config };
    (0..600).for_each(|_| pair.measure_overlap(&body, [&poses[0], &poses[1]], [lifted; 2], &off, dt));
    assert_eq!(pair.parting_displacements(dt), None);
}

#[test]
fn bodies_overlap_as_far_as_their_capsules_do() {
    let (skeleton, pose) = (Skeleton::default(), rest_pose());
    let body = SparringBody::new(&skeleton, &BodyShape::default());
    let overlap = |x: f32, z: f32| {
        let mut pair = pair::OpponentPair::default();
        let poses = [Planar::IDENTITY, Planar::new(x, z, std::f32::consts::PI)].map(|r| WorldPose::new(&pose, r));
        let config = SeparationConfig::default();
        pair.measure_overlap(&body, [&poses[0], &poses[1]], [Contacts::NONE; 2], &config, 1.0 / 60.0);
        pair.overlap_m
    };
    // Chest to chest, 0.12 m thick each, parallel from side to side.
    assert!((overlap(0.0, 0.2) - 0.04).abs() < 1e-5, "{}", overlap(0.0, 0.2));
    assert_eq!(overlap(0.0, 0.25), 0.0);
    // Side by side: chests reach out by two fifths of the shoulders' 0.185 m and their radius.
    let chest = 2.0 * (0.4 * 0.185 + 0.12);
    assert!((overlap(chest - 0.03, 0.0) - 0.03).abs() < 1e-5, "{}", overlap(chest - 0.03, 0.0));
    assert_eq!(overlap(chest + 0.01, 0.0), 0.0);
    assert_eq!(overlap(0.0, 9.0), 0.0);
}

#[test]
fn heads_that_are_too_near_part_and_lean_away() {
    let (skeleton, pose) = (Skeleton::default(), rest_pose());
    let body = SparringBody::new(&skeleton, &BodyShape::default());
    let (config, dt) = (SeparationConfig::default(), 1.0 / 60.0);
    let speed = |distance: f32, config: &SeparationConfig| {
        let poses = [Planar::IDENTITY, Planar::new(0.0, distance, 0.0)].map(|r| WorldPose::new(&pose, r));
        let mut pair = pair::OpponentPair::default();
        (0..60).for_each(|_| pair.measure_overlap(&body, [&poses[0], &poses[1]], [Contacts::LEFT; 2], config, dt));
        pair.parting_displacements(dt).map_or(0.0, |[first, second]| (second.y - first.y) / dt)
    };
    // Bodies are apart, heads nearer than they should be by 5 cm: gone within a quarter of a second.
    assert!((speed(config.heads_m - 0.05, &config) - 0.2).abs() < 0.02, "{}", speed(config.heads_m - 0.05, &config));
    assert_eq!(speed(config.heads_m + 0.05, &config), 0.0);
    assert_eq!(speed(config.heads_m - 0.05, &SeparationConfig { heads_m: 0.0, ..config }), 0.0);

    let heads = |distance: f32| [Vec3::Y * 1.6, Vec3::new(distance, 1.5, 0.0)];
    let by = config.lean_displacement(heads(0.4), dt).unwrap();
    let nearer = config.heads_m - 0.4f32.hypot(0.1);
    assert!(
        by.distance(Vec3::X * (nearer * config.lean_per_s * dt)) < 1e-6,
        "over the ground, away from the other: {by}"
    );
    assert_eq!(config.lean_displacement(heads(config.heads_m), dt), None);
    assert_eq!(config.lean_displacement(heads(0.4), 0.0), None);
}
