//! Packing against the poses that went in, and lanes against one at a time.

use super::*;
use bytemuck::Zeroable;
use proptest::prelude::*;
use throng_base::simd::{ArrayLanes, LaneWork, dispatch};

/// Frames of a motion; few for an interpreter.
const FRAMES: usize = if cfg!(miri) { 16 } else { 120 };

/// Positions of all joints, hips first (m).
fn joints(skeleton: &Skeleton, local: &[Quat; NUM_JOINTS]) -> [Vec3; NUM_JOINTS] {
    let (mut turned, mut at) = (*local, skeleton.offsets);
    for j in 1..NUM_JOINTS {
        let p = Joint::ALL[j].parent().map_or(0, Joint::index);
        turned[j] = turned[p] * local[j];
        at[j] = at[p] + turned[p] * skeleton.offsets[j];
    }
    at
}

/// Axes of a hinge and of a swing, and how wide: a quarter of joints hardly moves.
fn motion() -> impl Strategy<Value = Vec<[Quat; NUM_JOINTS]>> {
    let joint = (prop::array::uniform3(-1.0f32..1.0), 0.0f32..1.2, 0.0f32..6.0, 0.2f32..3.0);
    prop::collection::vec(joint, NUM_JOINTS).prop_map(|joints| {
        let pose = |f: usize| {
            std::array::from_fn(|j| {
                let (axis, wide, phase, speed) = joints[j];
                let wide = if j % 4 == 3 { 0.02 * wide } else { wide };
                let t = speed * f as f32 * 0.05 + phase;
                let axis = Vec3::from(axis).try_normalize().unwrap_or(Vec3::X);
                Quat::from_axis_angle(axis, wide * t.sin()) * Quat::from_rotation_y(0.3 * wide * (2.0 * t).cos())
            })
        };
        (0..FRAMES).map(pose).collect()
    })
}

fn pack(skeleton: &Skeleton, poses: &[[Quat; NUM_JOINTS]]) -> (RotationCode, Vec<FrameRow>) {
    let code = RotationCode::fit_frames(skeleton, poses.len(), |f, j| poses[f][j]);
    let mut rows: Vec<FrameRow> = Vec::new();
    for pose in poses {
        let mut row = FrameRow::zeroed();
        code.encode(pose, rows.last(), &mut row);
        rows.push(row);
    }
    (code, rows)
}

fn worst_m(skeleton: &Skeleton, poses: &[[Quat; NUM_JOINTS]]) -> f32 {
    let (code, rows) = pack(skeleton, poses);
    let of = |(pose, row): (&[Quat; NUM_JOINTS], &FrameRow)| {
        let shown = std::array::from_fn(|j| code.rotation(row, j));
        let (a, b) = (joints(skeleton, pose), joints(skeleton, &shown));
        a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
    };
    poses.iter().zip(&rows).map(of).fold(0.0, f32::max)
}

/// Between two rotations, exact for small ones (rad).
fn angle(a: Quat, b: Quat) -> f32 {
    2.0 * (a.conjugate() * b).xyz().length().min(1.0).asin()
}

proptest! {
    #[test]
    fn no_joint_of_free_motion_is_off_by_a_millimetre(poses in motion()) {
        let off = worst_m(&Skeleton::default(), &poses);
        prop_assert!(off < 1e-3, "{off}");
    }

    #[test]
    fn joints_that_turn_by_half_a_turn_each_frame_continue(turns in prop::collection::vec(any::<[f32; 3]>(), if cfg!(miri) { 16 } else { 60 })) {
        let mut poses = vec![[Quat::from_rotation_x(2.0); NUM_JOINTS]];
        for turn in turns {
            let axis = Vec3::from(turn).try_normalize().unwrap_or(Vec3::X);
            poses.push(poses[poses.len() - 1].map(|q| (q * Quat::from_xyzw(axis.x, axis.y, axis.z, 0.0)).normalize()));
        }
        let (code, rows) = pack(&Skeleton::default(), &poses);
        for (j, c) in code.joints.iter().enumerate() {
            prop_assert!(rows.windows(2).all(|r| c.continues(&r[0], &r[1])), "{j}");
        }
    }

    #[test]
    fn all_fields_are_sound_and_lie_beside_each_other(poses in motion()) {
        let (code, _) = pack(&Skeleton::default(), &poses);
        let mut taken = [false; BITS as usize];
        for c in &code.joints {
            prop_assert!(c.is_sound());
            for bit in &mut taken[c.at as usize..(c.at + c.width()) as usize] {
                prop_assert!(!std::mem::replace(bit, true));
            }
        }
        prop_assert!(taken.iter().all(|t| *t), "bits are left over");
    }

    #[test]
    fn between_rows_lies_between_their_rotations(poses in motion(), at in 0..FRAMES - 10, ratio in 0.0f32..1.0) {
        let (code, rows) = pack(&Skeleton::default(), &poses);
        let lanes: [&[FrameRow; 2]; LANES] = std::array::from_fn(|l| rows[at + l..].first_chunk().unwrap());
        for j in 0..NUM_JOINTS {
            let shown = dispatch(Between { code: &code, rows: lanes, ratio, joint: j });
            prop_assert_eq!(shown, Between { code: &code, rows: lanes, ratio, joint: j }.run::<ArrayLanes>());
            for l in 0..LANES {
                let [a, b] = lanes[l].each_ref().map(|r| code.rotation(r, j));
                let shown = Quat::from_array(shown[l]);
                prop_assert!((shown.length() - 1.0).abs() < 1e-4);
                let (off, moved) = (angle(shown, a.slerp(b, ratio)), angle(a, b));
                prop_assert!(off <= 1e-5 + 0.05 * moved, "{off} of {moved}");
            }
        }
    }
}

struct Between<'a> {
    code: &'a RotationCode,
    rows: [&'a [FrameRow; 2]; LANES],
    ratio: f32,
    joint: usize,
}

impl LaneWork for Between<'_> {
    type Output = [[f32; 4]; LANES];

    fn run<F: Lanes>(self) -> Self::Output {
        let weights = [F::splat(1.0 - self.ratio), F::splat(self.ratio)];
        let q = self.code.rotations_between(&self.rows, &weights, self.joint);
        F::rows([q.v.x, q.v.y, q.v.z, q.w])
    }
}

#[test]
fn a_somersault_keeps_its_side_and_is_exact_all_round() {
    let pose = |f: usize| {
        let mut pose = [Quat::IDENTITY; NUM_JOINTS];
        pose[0] = Quat::from_rotation_x(0.11 * f as f32) * Quat::from_rotation_z(0.4 * (0.3 * f as f32).sin());
        pose[Joint::LeftShin.index()] = Quat::from_rotation_x(1.1 + (0.2 * f as f32).sin());
        pose
    };
    let (poses, skeleton) = ((0..if cfg!(miri) { 70 } else { 200 }).map(pose).collect::<Vec<_>>(), Skeleton::default());
    let (code, rows) = pack(&skeleton, &poses);
    assert!(code.joints[0].stores_w() && !code.joints[Joint::LeftShin.index()].stores_w());
    for pair in rows.windows(2) {
        assert!(code.joints[0].coded(&pair[0]).dot(code.joints[0].coded(&pair[1])) > 0.9);
    }
    assert!(worst_m(&skeleton, &poses) < 2e-4);
}

#[test]
fn an_arm_that_goes_all_round_its_shoulder_has_a_centre() {
    let arm = Joint::RightUpperArm.index();
    let pose = |f: usize| {
        let mut pose = [Quat::IDENTITY; NUM_JOINTS];
        // From far in front of the rest pose to behind it: 170 degrees, the identity at one end.
        pose[arm] = Quat::from_rotation_y(-3.0 * f as f32 / 99.0);
        pose
    };
    let (poses, skeleton) = ((0..100).map(pose).collect::<Vec<_>>(), Skeleton::default());
    let (code, _) = pack(&skeleton, &poses);
    assert!(!code.joints[arm].stores_w() && code.joints[arm].centre[3] < 0.9, "{:?}", code.joints[arm]);
    assert!(worst_m(&skeleton, &poses) < 1e-4);
}

#[test]
fn the_code_of_the_rest_pose_says_that_whatever_is_in_a_row() {
    let (code, row) =
        (RotationCode::of_rest_pose(), FrameRow { rotations: [0xA5; ROTATION_BYTES], ..FrameRow::zeroed() });
    assert!((0..NUM_JOINTS).all(|j| code.rotation(&row, j) == Quat::IDENTITY));
}

#[test]
fn rows_that_cancel_each_other_out_leave_the_middle() {
    let w = JointCode {
        centre: [0.0, 0.0, 0.0, 1.0],
        low: [0.0, 0.0, 0.0, -1.0],
        step: [2.0; 4],
        at: 0,
        bits: [0, 0, 0, 1],
    };
    let code = RotationCode { joints: [w; NUM_JOINTS] };
    let row = |bit| FrameRow { rotations: [bit; ROTATION_BYTES], ..FrameRow::zeroed() };
    let (opposite, same) = ([row(0), row(1)], [row(1), row(1)]);
    let rows = std::array::from_fn(|l| if l == 2 { &opposite } else { &same });
    let shown = dispatch(Between { code: &code, rows, ratio: 0.5, joint: 0 });
    assert_eq!(shown, [Quat::IDENTITY.to_array(); LANES]);
}
