//! The joints of SMPL bodies in the order of the files.

use glam::DQuat;
use throng_core::{Joint, NUM_JOINTS};

/// The joints of a body without hands, in the order of the files, and the role of each.
pub const JOINTS: [(&str, Joint); NUM_JOINTS] = {
    use Joint::*;
    [
        ("Pelvis", Hips),
        ("L_Hip", LeftThigh),
        ("R_Hip", RightThigh),
        ("Spine1", Spine),
        ("L_Knee", LeftShin),
        ("R_Knee", RightShin),
        ("Spine2", Chest),
        ("L_Ankle", LeftFoot),
        ("R_Ankle", RightFoot),
        ("Spine3", UpperChest),
        ("L_Foot", LeftToe),
        ("R_Foot", RightToe),
        ("Neck", Neck),
        ("L_Collar", LeftClavicle),
        ("R_Collar", RightClavicle),
        ("Head", Head),
        ("L_Shoulder", LeftUpperArm),
        ("R_Shoulder", RightUpperArm),
        ("L_Elbow", LeftForearm),
        ("R_Elbow", RightForearm),
        ("L_Wrist", LeftHand),
        ("R_Wrist", RightHand),
    ]
};
/// Rotation from a world with Z up to one with Y up.
pub const UPRIGHT: DQuat =
    DQuat::from_xyzw(-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2);
