//! Arms and kicking legs that stop at the other's body, and feet that stand beside the other's.

use super::*;
use crate::body::hierarchy::{PARENTS, shared, write_locals, write_matrices};
use crate::body::{LocalTransform, Mat3x4};
use crate::planar::Planar;
use crate::skeleton::NUM_JOINTS;
use glam::Quat;
use throng_base::simd::ArrayLanes;

const DT: f32 = 1.0 / 60.0;
const LEFT: [Joint; 3] = [Joint::LeftUpperArm, Joint::LeftForearm, Joint::LeftHand];

/// A skeleton in its rest pose, arms stretched out to the sides.
fn rest_pose() -> [Mat3x4; NUM_JOINTS] {
    Skeleton::default().rest_positions().map(|p| Mat3x4::from_rotation_translation(Quat::IDENTITY, p))
}

fn volume() -> BodyVolume {
    BodyVolume::new(&Skeleton::default())
}

fn config() -> TouchConfig {
    TouchConfig::default()
}

/// World position of a joint of a pose (m).
fn joint_in_world(pose: &[Mat3x4; NUM_JOINTS], root: Planar, joint: Joint) -> Vec3 {
    point_in_world(pose, root, joint, Vec3::ZERO)
}

/// World position of a point in a joint's frame (m).
fn point_in_world(pose: &[Mat3x4; NUM_JOINTS], root: Planar, joint: Joint, offset: Vec3) -> Vec3 {
    let m = pose[joint.index()];
    maths::rotate(root.rotation(), m.rotation() * offset + m.translation()) + root.translation()
}

/// The rest pose with the left arm on its way straight ahead from a guard: 0 with the fist at the shoulder, 1 stretched out.
fn punch(distance: f32) -> [Mat3x4; NUM_JOINTS] {
    let mut pose = rest_pose();
    let shoulder = pose[LEFT[0].index()].translation();
    let lengths = [1, 2].map(|i| Skeleton::default().offsets[LEFT[i].index()].length());
    // The upper arm swings from straight down to straight ahead, the forearm points ahead.
    let (sin, cos) = (distance * std::f32::consts::FRAC_PI_2).sin_cos();
    let elbow = shoulder + Vec3::new(0.0, -cos, sin) * lengths[0];
    let wrist = elbow + Vec3::new(0.0, cos, sin).lerp(Vec3::Z, distance).normalize() * lengths[1];
    let along = |from: Vec3, to: Vec3| Quat::from_rotation_arc(Vec3::X, (to - from).normalize());
    let turns = [along(shoulder, elbow), along(elbow, wrist), along(elbow, wrist)];
    for ((joint, turn), at) in LEFT.into_iter().zip(turns).zip([shoulder, elbow, wrist]) {
        pose[joint.index()] = Mat3x4::from_rotation_translation(turn, at);
    }
    pose
}

const BOTH: Contacts = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);

/// Two partners of a skeleton.
struct Partners {
    touch: PartnerTouch,
    limbs: [LimbTouch; 2],
    locals: Vec<LocalTransform>,
}

impl Partners {
    fn new(config: TouchConfig) -> Self {
        Self::of_skeleton(&Skeleton::default(), config)
    }

    fn of_skeleton(skeleton: &Skeleton, config: TouchConfig) -> Self {
        let touch = PartnerTouch::new(skeleton, BodyVolume::new(skeleton), config);
        Self { touch, limbs: Default::default(), locals: vec![LocalTransform::default(); 2 * NUM_JOINTS] }
    }

    /// One step of two who stand on both feet, and their poses after it.
    fn step(&mut self, poses: [&[Mat3x4; NUM_JOINTS]; 2], roots: [Planar; 2]) -> [[Mat3x4; NUM_JOINTS]; 2] {
        self.step_on(poses, [BOTH; 2], roots)
    }

    /// One step of two, and their poses after it.
    fn step_on(
        &mut self,
        poses: [&[Mat3x4; NUM_JOINTS]; 2],
        contacts: [Contacts; 2],
        roots: [Planar; 2],
    ) -> [[Mat3x4; NUM_JOINTS]; 2] {
        let mut pose = lane_pose(poses);
        let of_roots = |value: fn(Planar) -> f32| -> ArrayLanes {
            let mut lanes = [0.0; LANES];
            lanes.iter_mut().zip(roots).for_each(|(lane, root)| *lane = value(root));
            ArrayLanes::load(&lanes)
        };
        let place = PlacementLanes {
            x: of_roots(|root| root.x),
            y: ArrayLanes::splat(0.0),
            z: of_roots(|root| root.z),
            sin: of_roots(|root| maths::sin_cos(root.heading).0),
            cos: of_roots(|root| maths::sin_cos(root.heading).1),
        };
        let mut all = [Contacts::NONE; LANES];
        all[..2].copy_from_slice(&contacts);
        let touches = &mut self.limbs[..];
        BlockTouch { partners: &self.touch, touches, contacts: all, dt_s: Some(DT) }.stop_limbs(&place, &mut pose);
        write_locals(shared(&Skeleton::default()), &pose, 2, &mut self.locals);
        matrices(&pose)
    }
}

/// Poses of two in lanes.
fn lane_pose(poses: [&[Mat3x4; NUM_JOINTS]; 2]) -> ModelPose<ArrayLanes> {
    let mut pose = ModelPose::unposed(ArrayLanes::splat(0.0));
    for j in 0..NUM_JOINTS {
        let lanes = |value: &dyn Fn(&Mat3x4) -> f32| {
            let mut lanes = [0.0; LANES];
            lanes.iter_mut().zip(poses).for_each(|(lane, pose)| *lane = value(&pose[j]));
            ArrayLanes::load(&lanes)
        };
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| lanes(&|m| m.rotation().to_array()[i]));
        pose.rotations[j] = Q::new(V::new(x, y, z), w);
        let [x, y, z] = [0, 1, 2].map(|i| lanes(&|m| m.translation()[i]));
        pose.positions[j] = V::new(x, y, z);
    }
    pose
}

fn matrices(pose: &ModelPose<ArrayLanes>) -> [[Mat3x4; NUM_JOINTS]; 2] {
    let mut out = [[Mat3x4::default(); NUM_JOINTS]; 2];
    write_matrices(pose, out.as_flattened_mut());
    out
}

/// A pose as the layer leaves it where nothing is displaced.
fn untouched(pose: &[Mat3x4; NUM_JOINTS]) -> [Mat3x4; NUM_JOINTS] {
    matrices(&lane_pose([pose, pose]))[0]
}

/// Core capsules of a pose in the world.
fn core(pose: &[Mat3x4; NUM_JOINTS], root: Planar) -> BodyCore {
    volume().place_core(|joint, at| point_in_world(pose, root, joint, at))
}

fn radius(joint: Joint) -> f32 {
    volume().capsules[joint.index()].radius
}

/// How deep the axis of any forearm of the first is in the core of the second, beyond what flesh gives (m).
fn depth(poses: &[[Mat3x4; NUM_JOINTS]; 2], roots: [Planar; 2]) -> f32 {
    let obstacles = core(&poses[1], roots[1]);
    let forearms = [[Joint::LeftForearm, Joint::LeftHand], [Joint::RightForearm, Joint::RightHand]];
    let mut deepest = f32::NEG_INFINITY;
    for ends in forearms.map(|f| f.map(|j| joint_in_world(&poses[0], roots[0], j))) {
        for o in &obstacles {
            let [p, q] = nearest_points(ends, o.ends);
            deepest = deepest.max(o.radius + radius(Joint::LeftForearm) - config().give_m - p.distance(q));
        }
    }
    deepest
}

fn lengths(pose: &[Mat3x4; NUM_JOINTS]) -> [f32; 2] {
    let [shoulder, elbow, wrist] = LEFT.map(|j| pose[j.index()].translation());
    [shoulder.distance(elbow), elbow.distance(wrist)]
}

const LEG: [Joint; 3] = [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot];

/// The rest pose with the straight left leg on its way up ahead: 0 hanging, 1 level, the toes beyond the heel.
fn kick(distance: f32) -> [Mat3x4; NUM_JOINTS] {
    let mut pose = rest_pose();
    let hip = pose[LEG[0].index()].translation();
    let turn = Quat::from_rotation_x(-distance * std::f32::consts::FRAC_PI_2);
    for j in [LEG[0], LEG[1], LEG[2], Joint::LeftToe] {
        let at = hip + turn * (pose[j.index()].translation() - hip);
        pose[j.index()] = Mat3x4::from_rotation_translation(turn * pose[j.index()].rotation(), at);
    }
    pose
}

/// How deep the axes of the left shin and foot of the first are in the core of the second, beyond what flesh gives (m).
fn leg_depth(poses: &[[Mat3x4; NUM_JOINTS]; 2], roots: [Planar; 2]) -> f32 {
    let mut deepest = f32::NEG_INFINITY;
    for bone in [[LEG[1], LEG[2]], [LEG[2], Joint::LeftToe]] {
        for o in &core(&poses[1], roots[1]) {
            let [p, q] = nearest_points(bone.map(|j| joint_in_world(&poses[0], roots[0], j)), o.ends);
            deepest = deepest.max(o.radius + radius(Joint::LeftShin) - config().give_m - p.distance(q));
        }
    }
    deepest
}

#[test]
fn a_kick_stops_at_the_body_and_comes_back() {
    let rest = rest_pose();
    for distance in [0.5, 0.65, 0.8] {
        let roots = [Planar::IDENTITY, Planar::new(LEG_X, distance, std::f32::consts::PI)];
        let (mut touch, mut deepest, mut goes_through) = (Partners::new(config()), 0.0f32, 0.0f32);
        for i in 0..=60 {
            // Up within a quarter of a second, held, and down again.
            let distance = (i as f32 / 15.0).min((60 - i) as f32 / 15.0).min(1.0);
            let motion = kick(distance);
            let posed = touch.step_on([&motion, &rest], [Contacts::RIGHT, BOTH], roots);
            let off = |j: Joint| posed[0][j.index()].translation() - motion[j.index()].translation();
            let bone = |from: Joint, to: Joint, pose: &[Mat3x4; NUM_JOINTS]| {
                pose[from.index()].translation().distance(pose[to.index()].translation())
            };
            for (from, to) in [(LEG[0], LEG[1]), (LEG[1], LEG[2]), (LEG[2], Joint::LeftToe)] {
                let [before, after] = [&motion, &posed[0]].map(|pose| bone(from, to, pose));
                assert!((before - after).abs() < 1e-4, "{from:?}: {before} {after} at {distance}, step {i}");
            }
            assert_eq!(off(Joint::RightFoot), Vec3::ZERO, "the leg that stands stays");
            let is_raised = motion[LEG[2].index()].translation().y > rest[LEG[2].index()].translation().y + 0.3;
            if is_raised {
                deepest = deepest.max(leg_depth(&posed, roots));
                goes_through = goes_through.max(leg_depth(&[motion, rest], roots));
            }
        }
        assert!(goes_through > 0.1, "{goes_through} at {distance}: it would go through");
        assert!(deepest < 0.05, "{deepest} at {distance}");
        let mut last = rest;
        for _ in 0..120 {
            last = touch.step_on([&rest, &rest], [Contacts::RIGHT, BOTH], roots)[0];
        }
        let far = [Planar::IDENTITY, Planar::new(0.0, 5.0, 0.0)];
        let free = touch.step([&rest, &rest], far)[0];
        let rest = untouched(&rest);
        let leg = |pose: &[Mat3x4; NUM_JOINTS]| LEG.map(|j| pose[j.index()]);
        let off = LEG.map(|j| last[j.index()].translation().distance(rest[j.index()].translation()));
        assert!(
            leg(&last) == leg(&rest) && leg(&free) == leg(&rest),
            "{off:?} at {distance}: it is where its motion has it, to the last bit"
        );
    }
}

/// Distance of the shins and feet of two (m).
fn legs_apart(poses: &[[Mat3x4; NUM_JOINTS]; 2], roots: [Planar; 2]) -> f32 {
    let bones = |k: usize| {
        let sides = [LEG, [Joint::RightThigh, Joint::RightShin, Joint::RightFoot]];
        let toes = [Joint::LeftToe, Joint::RightToe];
        let of_side = |(leg, toe): ([Joint; 3], Joint)| [[leg[1], leg[2]], [leg[2], toe]];
        let bones = sides.into_iter().zip(toes).flat_map(of_side);
        bones.map(|bone| bone.map(|j| joint_in_world(&poses[k], roots[k], j))).collect::<Vec<_>>()
    };
    let (own, other) = (bones(0), bones(1));
    let pairs = own.iter().flat_map(|a| other.iter().map(|b| nearest_points(*a, *b)));
    pairs.map(|[p, q]| p.distance(q)).fold(f32::MAX, f32::min)
}

/// The rest pose with the left foot ahead, as far over the ground and as high above it (m).
fn stride(ahead: f32, up: f32) -> [Mat3x4; NUM_JOINTS] {
    let mut pose = rest_pose();
    // Lower hips, so that the leg reaches.
    pose.iter_mut().for_each(|m| m.rows[1][3] -= 0.12);
    let rest = rest_pose();
    for side in [
        [LEG[0], LEG[1], LEG[2], Joint::LeftToe],
        [Joint::RightThigh, Joint::RightShin, Joint::RightFoot, Joint::RightToe],
    ] {
        let is_left = side[0] == LEG[0];
        let by = if is_left { Vec3::new(0.0, up, ahead) } else { Vec3::ZERO };
        let [hip, _, ankle, toe] = side.map(Joint::index);
        let to = rest[ankle].translation() + by;
        let from = pose[hip].translation();
        let [l1, l2] = [1, 2].map(|i| Skeleton::default().offsets[side[i].index()].length());
        let (distance, d) = ((to - from).normalize(), (to - from).length().min(l1 + l2 - 1e-4));
        let along = (l1 * l1 - l2 * l2 + d * d) / (2.0 * d);
        let bend = (Vec3::Z - distance * distance.z).normalize() * (l1 * l1 - along * along).max(0.0).sqrt();
        let knee = from + distance * along + bend;
        let turn = |from: Vec3, to: Vec3| Quat::from_rotation_arc(Vec3::NEG_Y, (to - from).normalize());
        pose[hip] = Mat3x4::from_rotation_translation(turn(from, knee), from);
        pose[side[1].index()] = Mat3x4::from_rotation_translation(turn(knee, from + distance * d), knee);
        pose[ankle] = Mat3x4::from_rotation_translation(Quat::IDENTITY, from + distance * d);
        pose[toe] = Mat3x4::from_rotation_translation(
            Quat::IDENTITY,
            from + distance * d + rest[toe].translation() - rest[ankle].translation(),
        );
    }
    pose
}

#[test]
fn a_foot_comes_down_beside_the_other_ones_and_stays_there() {
    let rest = rest_pose();
    // Its left foot comes down where the other one's left or right one stands, or between them.
    for beside in [-0.05, 0.0, 0.05, 0.15, 0.2] {
        let roots = [Planar::IDENTITY, Planar::new(beside, 0.62, std::f32::consts::PI)];
        let (mut touch, mut in_it, mut planted) = (Partners::new(config()), false, None::<Vec3>);
        let mut last: Option<[Mat3x4; NUM_JOINTS]> = None;
        for i in 0..120 {
            // A step within 0.4 s, half a second on the ground, and back.
            let distance = (i as f32 / 24.0).min((f32::from(78 - i as i16).max(0.0)) / 24.0).clamp(0.0, 1.0);
            let carries = (24..=54).contains(&i) || i >= 78;
            let motion = stride(0.4 * distance, if carries { 0.0 } else { 0.05 });
            let contacts = [if carries { BOTH } else { Contacts::RIGHT }, BOTH];
            let posed = touch.step_on([&motion, &rest], contacts, roots);
            in_it |= legs_apart(&[motion, rest], roots) < 0.06;
            let apart = legs_apart(&posed, roots);
            assert!(apart > 0.07, "{apart} m at {beside}, step {i}");
            let foot = posed[0][LEG[2].index()].translation();
            assert!((foot.y - motion[LEG[2].index()].translation().y).abs() < 0.01, "it keeps its height");
            if carries && i < 78 {
                let down = *planted.get_or_insert(foot);
                assert!(foot.distance(down) < 1e-3, "a foot that carries stays: {foot} {down} at {beside}, step {i}");
            }
            if let Some(last) = last.replace(posed[0]) {
                let moved = last[LEG[2].index()].translation().distance(foot);
                assert!(moved < 4.0 * DT, "{moved} m at {beside}, step {i}");
            }
        }
        assert!(in_it, "it would come down in it at {beside}");
    }
}

/// How far the left hip is beside the middle (m).
const LEG_X: f32 = 0.1;

#[test]
fn arms_leave_the_body_that_they_are_in_and_nothing_else_moves() {
    let rest = rest_pose();
    // Side by side: arms that stretch to the sides are in the other's trunk.
    let roots = [Planar::new(1.0, 2.0, 0.8), Planar::new(1.0, 2.0, 0.8).compose(Planar::new(0.65, 0.1, 0.4))];
    assert!(depth(&[rest; 2], roots) > 0.03, "{}", depth(&[rest; 2], roots));
    let mut touch = Partners::new(config());
    let mut posed = [rest; 2];
    for _ in 0..60 {
        posed = touch.step([&rest; 2], roots);
    }
    assert!(depth(&posed, roots) < 0.01, "{}", depth(&posed, roots));
    for (a, b) in lengths(&posed[0]).into_iter().zip(lengths(&rest)) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
    let fist = |pose: &[Mat3x4; NUM_JOINTS]| {
        pose[Joint::LeftForearm.index()].rotation().inverse() * pose[Joint::LeftHand.index()].rotation()
    };
    assert!(fist(&posed[0]).angle_between(fist(&rest)) < 1e-3, "the hand follows the forearm");
    let arms = [
        Joint::LeftUpperArm,
        Joint::LeftForearm,
        Joint::LeftHand,
        Joint::RightUpperArm,
        Joint::RightForearm,
        Joint::RightHand,
    ];
    for j in Joint::ALL.into_iter().filter(|j| !arms.contains(j)) {
        assert_eq!(posed[0][j.index()], untouched(&rest)[j.index()], "{j:?}");
    }
    let off = TouchConfig { enabled: false, ..config() };
    assert!(Partners::new(off).step([&rest; 2], roots) == [untouched(&rest); 2]);
}

#[test]
fn a_fast_fist_stops_on_its_side_of_the_head() {
    let rest = rest_pose();
    // The other one's head is before the left shoulder, nearer than the arm is long; the fist is there within five steps.
    let shoulder = rest[LEFT[0].index()].translation();
    for distance in [0.35, 0.4, 0.45] {
        let roots = [Planar::IDENTITY, Planar::new(shoulder.x, distance, std::f32::consts::PI)];
        let raised = |mut pose: [Mat3x4; NUM_JOINTS]| {
            // Heads as high as shoulders, so that a level fist meets one.
            pose.iter_mut().for_each(|m| m.rows[1][3] -= 0.25);
            pose
        };
        let (low, mut touch) = (raised(rest), Partners::new(config()));
        let mut most = 0.0f32;
        for i in 0..=40 {
            let posed = touch.step([&punch((i as f32 / 5.0).min(1.0)), &low], roots);
            let wrist = posed[0][LEFT[2].index()].translation();
            assert!(wrist.z < distance, "{wrist} at {distance}");
            most = most.max(depth(&posed, roots));
        }
        assert!(most < 0.06, "{most} at {distance}");
        assert!(depth(&[punch(1.0), low], roots) > 0.1, "it would go through");
    }
}

#[test]
fn arms_that_come_back_from_a_body_stay_out_of_it() {
    let rest = rest_pose();
    let mut goes_through = 0;
    for i in 0..400u32 {
        let share = |salt: u32| {
            (i.wrapping_mul(2_654_435_761).wrapping_add(salt).wrapping_mul(2_246_822_519) >> 8) as f32
                / (1 << 24) as f32
        };
        let (x, z) = (-0.2 + 0.6 * share(1), 0.3 + 0.4 * share(2));
        let other = Planar::new(x, z, std::f32::consts::TAU * share(3));
        let (mut touch, mut deepest, mut worst) = (Partners::new(config()), 0.0f32, 0.0f32);
        for step_no in 0..60 {
            // Out within 0.1 s, back within 0.2 s, and the whole body turns into the blow and back.
            let distance = (step_no as f32 / 6.0).min((24.0 - step_no as f32).max(0.0) / 12.0).min(1.0);
            let roots = [Planar::new(0.0, 0.1 * distance, (0.6 * share(4) - 0.9) * distance), other];
            let motion = punch(distance);
            let posed = touch.step([&motion, &rest], roots);
            worst = worst.max(depth(&[motion, rest], roots));
            // Whoever stands in the other to begin with has to come out first.
            if step_no > 3 {
                deepest = deepest.max(depth(&posed, roots));
            }
        }
        goes_through += u32::from(worst > 0.1);
        assert!(deepest < 0.06, "{deepest} in place of {worst} at {x}, {z}, number {i}");
    }
    assert!(goes_through > 100, "{goes_through} would go through");
}

#[test]
fn arms_come_and_go_without_a_jump() {
    let (arm, rest) = (punch(0.6), punch(0.0));
    let mut touch = Partners::new(config());
    let mut last: Option<[Mat3x4; NUM_JOINTS]> = None;
    let mut touched = false;
    for i in 0..240 {
        // The other one comes at 1 m/s and goes again.
        let z = 1.4 - 0.9 * (1.0 - (i as f32 / 120.0 - 1.0).abs()).clamp(0.0, 1.0);
        let roots = [Planar::IDENTITY, Planar::new(0.15, z, std::f32::consts::PI)];
        let posed = touch.step([&arm, &rest], roots)[0];
        touched |= posed != untouched(&arm);
        if let Some(last) = last {
            for j in LEFT {
                let moved = posed[j.index()].translation().distance(last[j.index()].translation());
                assert!(moved < 6.0 * DT, "{j:?} {moved} at {i}");
            }
            let angle = |pose: &[Mat3x4; NUM_JOINTS]| {
                let [shoulder, elbow, wrist] = LEFT.map(|j| pose[j.index()].translation());
                (shoulder - elbow).angle_between(wrist - elbow)
            };
            assert!((angle(&posed) - angle(&last)).abs() < config().elbow_radps * DT + 1e-3);
        }
        last = Some(posed);
    }
    assert!(touched);
    for _ in 0..120 {
        last = Some(touch.step([&arm, &rest], [Planar::IDENTITY, Planar::new(0.0, 1.4, 3.1)])[0]);
    }
    assert!(last == Some(untouched(&arm)), "free arms are where their motion has them, to the last bit");
}

#[test]
fn two_guards_meet_half_way() {
    let arm = punch(0.5);
    let roots = [Planar::IDENTITY, Planar::new(0.0, 0.75, std::f32::consts::PI)];
    // Left arms of two who face each other pass each other; shift the second so that they meet.
    let shoulder = arm[LEFT[0].index()].translation().x;
    let roots = [roots[0], Planar::new(2.0 * shoulder, roots[1].z, roots[1].heading)];
    let mut touch = Partners::new(config());
    let posed = (0..30).map(|_| touch.step([&arm, &arm], roots)).last().unwrap();
    let ends = |k: usize| [LEFT[1], LEFT[2]].map(|j| joint_in_world(&posed[k], roots[k], j));
    let [p, q] = nearest_points(ends(0), ends(1));
    assert!(p.distance(q) > 0.06, "{}", p.distance(q));
    let moved = |k: usize| posed[k][LEFT[2].index()].translation().distance(arm[LEFT[2].index()].translation());
    assert!(moved(0) > 0.01 && (moved(0) - moved(1)).abs() < 0.05, "{} {}", moved(0), moved(1));
}

#[test]
fn local_transforms_build_the_displaced_pose() {
    let rest = rest_pose();
    let mut touch = Partners::new(config());
    let posed = touch.step([&rest; 2], [Planar::IDENTITY, Planar::new(0.65, 0.1, 0.4)])[0];
    assert!(posed != untouched(&rest));
    let local = |j: Joint| Quat::from_array(touch.locals[j.index()].rotation);
    for j in LEFT {
        let turned = posed[PARENTS[j.index()]].rotation() * local(j);
        assert!(turned.angle_between(posed[j.index()].rotation()) < 1e-3, "{j:?}");
    }
    assert!(local(LEFT[2]).angle_between(Quat::IDENTITY) < 1e-3, "the hand keeps its turn against the forearm");
}

#[test]
fn rotations_of_displaced_arms_lead_to_where_the_joints_are() {
    let rest = rest_pose();
    // From hardly touched to far in.
    for x in (0..60).map(|i| 0.5 + 0.005 * i as f32) {
        let posed = Partners::new(config()).step([&rest; 2], [Planar::IDENTITY, Planar::new(x, 0.1, 0.4)])[0];
        for pair in LEFT.windows(2) {
            let [parent, child] = [0, 1].map(|i| pair[i].index());
            let turned = posed[parent].translation() + posed[parent].rotation() * Skeleton::default().offsets[child];
            let off = turned.distance(posed[child].translation());
            assert!(off < 2e-5, "{:?} is {off} m off at {x}", pair[1]);
        }
    }
}

#[test]
fn arms_without_length_do_no_harm() {
    let mut skeleton = Skeleton::default();
    for (upper, lower) in [(0.0, 0.0), (0.0, 0.3), (0.3, 0.0), (1e-5, 1e-5), (1e-3, 900.0)] {
        for (joint, length) in [(LEFT[1], upper), (LEFT[2], lower)] {
            skeleton.offsets[joint.index()] = Vec3::X * length;
        }
        let (pose, roots) = (punch(0.7), [Planar::IDENTITY, Planar::new(0.0, 0.4, std::f32::consts::PI)]);
        let mut touch = Partners::of_skeleton(&skeleton, config());
        for _ in 0..3 {
            let posed = touch.step([&pose; 2], roots)[0];
            assert!(posed.iter().all(|m| m.translation().is_finite()), "{upper} {lower}");
        }
    }
}
