//! Numbers that say what a person is and does: from which speed somebody walks, how near the ground a foot stands, how much
//! room a body takes.
//!
//! Each number has one home here, with its unit, its source and who uses it. Where a place still needs another value for
//! the same idea, that value has a name of its own beside it, which says what it will become and what would change then.
//! Thresholds are of the default skeleton (1.75 m, legs of [`REFERENCE_LEG_M`]), unless they say otherwise; "chosen" means
//! that no measurement stands behind a number.
//!
//! Constants whose names end in `_F64` are for computations in double precision, in which the nearest number is another
//! one.

// Speeds over the ground.

/// Speed of the root or the hips over the ground below which a person stands (m/s). Chosen.
///
/// Used where a walker ends a turn in place, as the default of the motion graph's standing frames, for twists of blend
/// examples, and to report which locomotion a clip shows.
pub const STANDING_MPS: f32 = 0.15;
/// [`STANDING_MPS`] in double precision (m/s).
pub const STANDING_MPS_F64: f64 = 0.15;
/// Speed below which a walker keeps its heading, as its direction of movement says nothing (m/s). Chosen.
///
/// Used where walkers are steered. It is to become [`STANDING_MPS`]: bodies of slow agents then turn later, and the states
/// of all scenes with walkers change.
pub const MOVING_DIRECTION_MPS: f32 = 0.1;
/// Largest speed of the root of a frame in which characters of patches rest (m/s). Chosen.
///
/// Used where patches are cut from clips. It is to become [`STANDING_MPS`]: more frames are rests then, and bundles with
/// patches change.
pub const PATCH_STANDING_MPS: f32 = 0.12;
/// Largest speed of the hips in standing still, in double precision (m/s). Chosen, equal to [`PATCH_STANDING_MPS`].
///
/// Used for the tags of the synthetic playground. It is to become [`STANDING_MPS`]: more frames are tagged then, and the
/// playground's bundles change.
pub const PLAYGROUND_STANDING_MPS_F64: f64 = 0.12;
/// Speed below which a character of a trial has stopped on its way (m/s). Chosen.
///
/// Used in reports of trials. It is to become [`STANDING_MPS`]: reported times of standing grow a little then.
pub const TRIAL_STANDING_MPS: f32 = 0.1;
/// Largest speed of the hips, up and down too, in the first and last frames of an activity (m/s). Chosen.
///
/// Used where activities are cut from clips. It is to become [`STRIDING_MPS`]: tags whose ends are a little faster are
/// refused then, and the bundles of sets with activities have to be checked first.
pub const ACTIVITY_STANDING_MPS: f32 = 0.35;

/// Speed from which a body walks in a direction: it leaves an activity, and a blend of its motion has a heading (m/s). Chosen.
///
/// Used by walkers, and by bodies that follow agents.
pub const STRIDING_MPS: f32 = 0.3;
/// Speed of a blend up to which its steps keep their own time (m/s). Chosen.
///
/// Used where walkers place their feet. It is to become [`STRIDING_MPS`]: the tempo of slow steps changes then, so that foot
/// slip has to be measured first.
pub const STEP_TIME_MPS: f32 = 0.4;
/// Mean speed above which a segment of motion counts in the usual speed of a set (m/s). Chosen.
///
/// Used where policy characters avoid each other. It is to become [`STRIDING_MPS`]: the usual speed falls then in sets with
/// slow steps, and with it how far ahead their characters look.
pub const SEGMENT_WALKING_MPS: f32 = 0.4;

/// Speed of the root or the hips from which somebody walks, and takes steps (m/s). Chosen.
///
/// Used to report which locomotion a clip shows, and to find files whose frame rate is wrong.
pub const WALKING_MPS: f32 = 0.5;
/// Mean speed over a second from which motion shows any walking (m/s). Chosen.
///
/// Used in the message on a set that is too small. It is to become [`WALKING_MPS`], which changes its words for slow sets.
pub const ANY_WALKING_MPS: f32 = 0.3;
/// Least speed of a root that crosses the edge of a tile (m/s). Chosen.
///
/// Used where the poses are chosen in which characters enter and leave tiles. It is to become [`WALKING_MPS`]: tiles get
/// other poses at their edges then, and bundles with tiles change.
pub const TILE_WALKING_MPS: f32 = 0.6;
/// Speed of a calm walk, by which inhabitants of a world weigh ways and waiting (m/s). Chosen.
pub const STROLL_MPS: f32 = 1.2;
/// Speed at which a pedestrian likes to walk (m/s). Chosen; Weidmann (1993), *Transporttechnik der Fussgänger*, gives a mean of
/// 1.34 m/s.
///
/// Default of agents and of their groups in scenes, and of characters that are steered by hand.
pub const WALK_SPEED_MPS: f32 = 1.3;
/// Speed that every agent may reach to give way, whatever its desired speed (m/s). Chosen.
///
/// Used by the crowd.
pub const GIVING_WAY_MPS: f32 = 0.5;

// Speeds of feet.

/// Speed of a heel or toe near the ground below which it comes to stand (m/s). Chosen.
///
/// Default of the detection of contacts; also used to find walks on the spot, and to judge how much planted feet slide.
pub const FOOT_PLANTED_MPS: f32 = 0.15;
/// Speed of a heel or toe above which it no longer stands (m/s). Chosen.
///
/// Default of the detection of contacts; also used to find the floor under feet, and walks on the spot.
pub const FOOT_FREE_MPS: f32 = 0.3;
/// Speed of ankle and toe below which a foot of an unknown rig may be planted (m/s). Chosen.
///
/// Used where rigs are measured. It is to become [`FOOT_PLANTED_MPS`]: every rig would have to be imported anew.
pub const RIG_FOOT_PLANTED_MPS: f32 = 0.12;
/// Speed of the lowest part of the feet, which may roll, below which it may be standing (m/s). Chosen.
///
/// Used to find the ground of clips. It is to become [`FOOT_FREE_MPS`]: imported heights would move.
pub const LOWEST_FOOT_MPS: f32 = 0.4;
/// Speed of the fastest planted feet above which they visibly slide (m/s). Chosen.
///
/// Used where the viewer judges contacts.
pub const FOOT_SLIDES_MPS: f32 = 0.5;
/// Mean slip of planted feet below which they look still, in double precision (m/s). Chosen.
///
/// Used where trials are judged.
pub const SLIP_UNSEEN_MPS_F64: f64 = 0.03;
/// Speed of low toes in the air that does not catch the eye, in double precision (m/s). Chosen.
///
/// Used where trials are judged.
pub const TOES_SLOW_MPS_F64: f64 = 0.8;
/// Speeds over the ground at which a toe in the air begins to clear the ground, and at which it clears it wholly (m/s). Chosen.
///
/// Used by the foot lock.
pub const TOE_SWING_MPS: [f32; 2] = [0.2, 0.5];
/// Largest speed over the ground at which the correction of a foot in the air fades (m/s). Chosen.
///
/// Used by the foot lock.
pub const FOOT_RELEASED_MPS: f32 = 1.2;
/// Largest speed at which a toe is raised to clear the ground (m/s). Chosen.
///
/// Used by the foot lock.
pub const TOE_RAISED_MPS: f32 = 0.8;

// Lengths of bodies.

/// Length of the legs of the default skeleton, from hip to ankle, for which lengths are given (m). Segments after Winter,
/// *Biomechanics and Motor Control of Human Movement*.
///
/// Used to scale contacts and bodies to other skeletons.
pub const REFERENCE_LEG_M: f32 = 0.83;
/// Radius of the disc that a standing body takes on the ground (m). Chosen, about half of the breadth of the shoulders.
///
/// Used in stop tables, where characters avoid each other, and for other people in planned tasks.
pub const BODY_RADIUS_M: f32 = 0.25;
/// Radius of the disc that nobody else enters, of an agent of average size (m). Chosen: a body with a little room.
///
/// Default of agents and of their groups in scenes; also used where characters without a disc are picked.
pub const AGENT_RADIUS_M: f32 = 0.3;
/// Height of faces and of what hangs on walls, at which people look (m). Chosen.
///
/// Used where bodies of agents look at each other and at things.
pub const EYES_M: f32 = 1.55;
/// Largest height of a blow above or below the centre of the head that it meets (m): the radius of the head, 0.1, and half of
/// the length of its capsule's axis.
///
/// Used to find whether boxers can reach each other's heads.
pub const HALF_HEAD_M: f32 = 0.12;
/// Distance from the wrist to the tip of the fist, as a share of the forearm's length (1). Chosen.
///
/// Used for blows, hands that reach, and palms.
pub const FIST_PER_FOREARM: f32 = 0.35;
/// Distance from an arm at which it catches a fist (m). Chosen, about the radius of a fist.
///
/// Used for blows.
pub const FIST_REACH_M: f32 = 0.05;
/// Distance of the heel behind the ankle, as a share of that of the ball before it (1). Chosen.
///
/// Used for heels of skeletons, and for the skin of feet.
pub const HEEL_PER_BALL: f32 = 0.3;
/// Length of a foot behind its ankle, as a share of that from the ankle to the ball, in double precision (1). Chosen.
///
/// Used for the balance of planned poses. It is to become [`HEEL_PER_BALL`]: reported distances of the centre of mass from
/// the feet grow by up to 1.4 cm then.
pub const BALANCE_HEEL_PER_BALL_F64: f64 = 0.4;
/// Depth to which flesh gives way where limbs touch (m). Chosen.
///
/// Default of the touch of boxers.
pub const FLESH_GIVES_M: f32 = 0.015;

// Heights of feet, and distances at which bodies touch things.

/// Heights of a heel or toe over its floor below which a contact begins, and above which it ends (m). Chosen.
///
/// Defaults of the detection of contacts, on flat ground and on units of an environment.
pub const FOOT_CONTACT_M: [f32; 2] = [0.025, 0.045];
/// Distances of the skin of a hand from a unit at which a contact begins and ends (m). Chosen.
///
/// Defaults of contacts with units of an environment.
pub const HAND_CONTACT_M: [f32; 2] = [0.03, 0.05];
/// Distances of the seat from a unit at which a contact begins and ends (m). Chosen.
///
/// Defaults of contacts with units of an environment.
pub const SEAT_CONTACT_M: [f32; 2] = [0.03, 0.06];
/// Largest depth of a body in a unit of an environment, where the clip touches it (m). Chosen: thickness of flesh and clothes,
/// and errors of capture.
///
/// Default of the check of clips with units.
pub const BODY_IN_UNIT_M: f32 = 0.06;
/// Largest depth of bodies in units of a stitched world (m). Chosen, a little stricter than [`BODY_IN_UNIT_M`].
///
/// Default of stitching.
pub const BODY_IN_WORLD_M: f32 = 0.05;
/// Height over the ground up to which a foot is planted (m). Chosen.
///
/// Used where walkers place their feet.
pub const FOOT_NEAR_M: f32 = 0.06;
/// Height over the ground from which a planted foot counts as standing (m). Chosen.
///
/// Used where walkers place their feet.
pub const FOOT_SETTLED_M: f32 = 0.002;
/// Distance between a foot's plane and the ground below which the plane is at rest (m). Chosen.
///
/// Used where walkers find the ground under their feet. It is to become [`FOOT_SETTLED_M`]: feet on hills move a little then.
pub const FOOT_PLANE_SETTLED_M: f32 = 0.0015;
/// Distance from the ground up to which a part of a foot stands (m). Chosen.
///
/// Used where walkers find the ground under their feet.
pub const FOOT_STANDS_M: f32 = 0.005;
/// Height of a foot above its lowest place below which it carries weight (m). Chosen.
///
/// Used to find walks on the spot.
pub const FOOT_LOW_M: f32 = 0.04;
/// Height of a toe above its lowest place below which it is low (m). Chosen.
///
/// Used to measure the quality of motion.
pub const TOE_LOW_M: f32 = 0.015;
/// Smallest height over the ground of the toe of a fast foot in the air (m). Chosen.
///
/// Default of the foot lock.
pub const TOE_CLEARANCE_M: f32 = 0.02;
/// [`TOE_CLEARANCE_M`] in double precision, the least height of the sole in steps of the synthetic locomotion sets (m).
pub const TOE_CLEARANCE_M_F64: f64 = 0.02;
/// Least height of the sole in the middle of a step of the synthetic walk set, in double precision (m). Chosen.
///
/// It is to become [`TOE_CLEARANCE_M_F64`]: the walk set, and all that is baked from it, changes then.
pub const WALK_CLEARANCE_M_F64: f64 = 0.015;
/// Height of an ankle above the other one from which its leg kicks (m). Chosen.
///
/// Used where limbs of boxers touch.
pub const LEG_RAISED_M: f32 = 0.25;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_double_precision_are_the_same_numbers() {
        for (single, double) in [
            (STANDING_MPS, STANDING_MPS_F64),
            (PATCH_STANDING_MPS, PLAYGROUND_STANDING_MPS_F64),
            (TOE_CLEARANCE_M, TOE_CLEARANCE_M_F64),
        ] {
            assert_eq!(single, double as f32);
        }
    }
}
