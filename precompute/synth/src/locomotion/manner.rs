//! Manners: how a mood changes posture and movement, whatever the gait.

/// A manner of moving, as changes to the neutral one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manner {
    /// As names and tags of clips write it.
    pub name: &'static str,
    /// Steps a second over those of a neutral walker of the same speed.
    pub cadence: f64,
    /// Time a foot stands over that of a neutral one.
    pub stance: f64,
    /// How far the hips sink (m).
    pub crouch: f64,
    /// The upper back bends forward (rad).
    pub slouch: f64,
    /// The head hangs (rad).
    pub nod: f64,
    /// The shoulders come forward (rad).
    pub protraction: f64,
    /// The shoulders go up (rad).
    pub shrug: f64,
    /// How far the arms swing, over neutral.
    pub arm_swing: f64,
    /// The elbows bend more (rad).
    pub arm_bend: f64,
    /// The arms are held away from the body (rad).
    pub abduction: f64,
    /// How far the feet roll at heel strike and toe-off, over neutral.
    pub roll: f64,
    /// How high runners lift knees and heels, over neutral.
    pub knee_lift: f64,
    /// Distance between the feet across the path, over neutral.
    pub width: f64,
    /// The feet turn out more (rad).
    pub toe_out: f64,
    /// How far the pelvis lists and turns with the steps, over neutral.
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

/// Every manner.
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
