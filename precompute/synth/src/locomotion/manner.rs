//! Manners: changes of posture and movement by mood, for any gait.

/// A manner of moving, as changes to the neutral one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// Name in names and tags of clips.
    pub name: &'static str,
    /// Ratio of the cadence to that of a neutral walker of the same speed.
    pub cadence: f64,
    /// Ratio of the stance time to a neutral one.
    pub stance: f64,
    /// Lowering of the hips (m).
    pub crouch: f64,
    /// Forward bend of the upper back (rad).
    pub slouch: f64,
    /// Forward tilt of the head (rad).
    pub nod: f64,
    /// Forward turn of the shoulders (rad).
    pub protraction: f64,
    /// Upward turn of the shoulders (rad).
    pub shrug: f64,
    /// Ratio of the arm swing to neutral.
    pub arm_swing: f64,
    /// Additional flexion of the elbows (rad).
    pub arm_bend: f64,
    /// Abduction of the arms (rad).
    pub abduction: f64,
    /// Ratio of the foot roll at heel strike and toe-off to neutral.
    pub roll: f64,
    /// Ratio of the lift of a runner's knees and heels to neutral.
    pub knee_lift: f64,
    /// Ratio of the distance between the feet across the path to neutral.
    pub width: f64,
    /// Additional outward turn of the feet (rad).
    pub toe_out: f64,
    /// Ratio of the list and turn of the pelvis to neutral.
    pub sway: f64,
}

/// The neutral manner.
pub const NEUTRAL: Manner = Manner {
    name: "neutral",
    cadence: 1.0,
    stance: 1.0,
    crouch: 0.0,
    slouch: 0.0,
    nod: 0.0,
    protraction: 0.0,
    shrug: 0.0,
    arm_swing: 1.0,
    arm_bend: 0.0,
    abduction: 0.0,
    roll: 1.0,
    knee_lift: 1.0,
    width: 1.0,
    toe_out: 0.0,
    sway: 1.0,
};

/// All manners.
pub const MANNERS: [Manner; 3] = [
    NEUTRAL,
    Manner {
        name: "proud",
        cadence: 1.05,
        stance: 0.97,
        slouch: -0.13,
        nod: -0.09,
        protraction: -0.16,
        shrug: 0.05,
        arm_swing: 1.3,
        arm_bend: 0.1,
        abduction: 0.09,
        roll: 1.08,
        knee_lift: 1.1,
        width: 0.85,
        toe_out: 0.05,
        sway: 1.2,
        ..NEUTRAL
    },
    Manner {
        name: "tired",
        cadence: 0.94,
        stance: 1.05,
        crouch: 0.038,
        slouch: 0.34,
        nod: 0.3,
        protraction: 0.2,
        shrug: -0.07,
        arm_swing: 0.5,
        arm_bend: -0.08,
        roll: 0.75,
        knee_lift: 0.82,
        width: 1.25,
        toe_out: 0.04,
        sway: 0.85,
        ..NEUTRAL
    },
];
