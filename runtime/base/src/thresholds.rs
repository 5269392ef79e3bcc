//! Numbers that say what a person is and does: from which speed somebody walks, how near the ground a foot stands, how much
//! room a disc takes. Radii of bodies are in `throng_core::body`, in its `volume`.
//!
//! Each number has one home here, with its unit, its source and who uses it. Where a place still needs another value for
//! the same idea, that value has a name of its own beside it, which says what it will become and what would change then.
//! Thresholds are of the default skeleton (1.75 m, legs of [`REFERENCE_LEG_M`]), unless they say otherwise; "chosen" means
//! that no measurement stands behind a number. Caches notice a change; defaults of configs stand in
//! `data/throng-config.schema.json`, too.
//!
//! Constants whose names end in `_F64` are for computations in double precision, in which the nearest number is another
//! one.
//!
//! Speeds were measured on the default skeleton at 30 Hz: on recordings of walks, runs and gestures (Bandai-Namco Research
//! Motiondataset-1, the CMU motion capture database's subject 2, and the clips of *Tiling Motion Patches*, 2012) and on the
//! synthetic sets. Those of the hips are means over 0.2 s; a person stands where both feet are planted for half a second before
//! and after, and walks where each foot is lifted within 0.7 s and one of them is always planted.

// Speeds over the ground.

/// Speed of the root or the hips over the ground below which a person stands (m/s).
///
/// Hips of people who stand and talk or gesture sway: the median is 0.03 to 0.09 m/s in three sets of recordings, the 95th
/// percentile 0.19 (Bandai-Namco) to 0.32 (with bows and punches), and 0.16 over all synthetic sets.
///
/// Used where a walker keeps its heading or ends a turn in place, as the default of the motion graph's standing frames, for rests
/// of patches and in the playground, for twists of blend examples, by performances of walkers, needs of made motion, classes of clips, actions
/// of agents, and to report stops, starts and waiting.
pub const STANDING_MPS: f32 = STANDING_MPS_F64 as f32;
/// [`STANDING_MPS`] in double precision (m/s).
pub const STANDING_MPS_F64: f64 = 0.15;
/// Speed of the root or the hips from which a person walks: its movement has a direction, and it takes steps (m/s).
///
/// The 5th percentile over the walks of the Bandai-Namco recordings in 15 styles is 0.30 m/s, their median 0.63.
///
/// Used where bodies leave an activity and turn into their way, where walkers time their steps, for the usual speed of a set, the
/// ends of activities, the poses at edges of tiles, and to report walking and find files whose frame rate is wrong.
pub const WALKING_MPS: f32 = 0.3;
/// Speed from which the movement of an agent is drawn with a direction (m/s). Chosen.
///
/// Used in pictures of crowds, and where the viewer draws agents and lists their forces.
pub const DIRECTION_SHOWN_MPS: f32 = 0.05;
/// Speed below which a body that is to face somebody or something stands (m/s). Chosen, twice [`WALKING_MPS`]: passers-by push the
/// disc of an agent that faces somebody.
///
/// Used by bodies of agents.
pub const FACING_STANDS_MPS: f32 = 0.6;
/// Speed above which a body moves whose clip is named an idle (m/s): those sway and step, but walk nowhere. Chosen.
///
/// Used where clips are classified.
pub const NAMED_IDLE_MOVES_MPS: f32 = 2.0 * WALKING_MPS;
/// Speed of strides from which their time is wholly that of the examples (m/s). Chosen.
///
/// Used where walkers match their steps to their speed. With [`WALKING_MPS`], knees turn faster on stairs of 0.17 m than they may.
pub const STEP_TIME_MPS: f32 = 0.4;
/// Speed at which a pedestrian likes to walk (m/s). Chosen; Weidmann (1993), *Transporttechnik der Fussgänger*, gives a mean of
/// 1.34 m/s.
///
/// Default of agents and of their groups in scenes, and of characters that are steered by hand; inhabitants of a world weigh ways
/// and waiting by it.
pub const WALK_SPEED_MPS: f32 = 1.3;
/// Speed at which a person runs (m/s). Chosen between the medians of the runs and dashes of the Bandai-Namco recordings, 2.5 m/s,
/// and of the synthetic locomotion set, 3.2.
///
/// Used for characters that are steered by hand, and as the speed of what is drawn in the colour of fast characters.
pub const RUN_SPEED_MPS: f32 = 3.0;
/// Speed plus the correlation of hips and stride from which a body runs (m/s; a correlation of 1 counts as 1 m/s): hips of a
/// runner are highest while the feet are farthest apart, those of a walker lowest. Of clips whose names say nothing, walk and run.
/// Chosen.
///
/// Used where clips are classified.
pub const RUNS_MPS: [f32; 3] = [1.85, 2.3, 1.5];
/// Median speed of the lowest foot, over the ground of a treadmill, from which a body on the spot runs (m/s). Chosen.
///
/// Used to give walks on the spot a trajectory.
pub const TREADMILL_RUNS_MPS: f32 = 1.4;
/// Speed of running below which people say that somebody jogs (m/s). Chosen.
///
/// Used for names of classes of motion.
pub const JOG_BELOW_MPS: f32 = 3.0;
/// Speed of a gait from which it is a run, whatever its feet do (m/s). Chosen: the median of the synthetic locomotion
/// set's runs.
///
/// Used where clips are classified.
pub const SURELY_RUNS_MPS: f32 = 3.2;
/// Speed of the gait that is preferred, among gaits that are as steady: slow ones turn and stop among others (m/s). Chosen, about
/// the median of the Bandai-Namco walks.
///
/// Used where motion is made.
pub const USUAL_GAIT_MPS: f32 = 0.6;
/// Speeds of a gait from which starts, and from which stops and pivots, take four steps in place of two (m/s). Chosen.
///
/// Used where motion is made.
pub const FOUR_STEPS_MPS: [f32; 2] = [1.3, 1.9];
/// Desired speed of a character on its way below which it waits (m/s). Chosen.
///
/// Used by characters that navigation leads.
pub const WAITS_BELOW_MPS: f32 = 0.1;
/// Speed that every agent may reach to give way, whatever its desired speed (m/s). Chosen.
///
/// Used by the crowd.
pub const GIVING_WAY_MPS: f32 = 0.5;

/// Largest accelerations of people who walk and run: while they gain speed, while they lose it, and to their sides (m/s^2).
///
/// The largest of 40 captured walks, runs, stops and turns (CMU 02 and 03, snumrl/TillingPatch), of paths that are averaged over a
/// step; the 95th percentiles of the largest of each clip are 1.8, 1.6 and 2.6.
///
/// Default of the inertia of walkers.
pub const PACE_CHANGES_MPS2: [f32; 3] = [2.2, 1.85, 2.7];

// Speeds of the whole body.

/// Speed of the fastest joint below which a body is still (m/s). Chosen.
///
/// Default of the search for still ends of clips.
pub const BODY_STILL_MPS: f32 = 0.1;
/// Speed of a joint of a moving body, which does not stop within a frame (m/s). Chosen.
///
/// Used to find frozen frames of clips.
pub const JOINT_MOVES_MPS: f32 = 0.15;
/// Speed of the fastest joint below which a body holds a pose that it may be on the way out of (m/s). Chosen.
///
/// Used to find T-poses at the ends of clips.
pub const POSE_HELD_MPS: f32 = 0.5;
/// Speeds of a hand that begins to hold something, and that no longer holds it (m/s). Chosen.
///
/// Used to infer units of an environment from clips.
pub const HAND_HOLDS_MPS: [f32; 2] = [0.12, 0.25];
/// Speeds of the hips of a body that begins to sit, and that no longer sits (m/s). Chosen.
///
/// Used to infer units of an environment from clips.
pub const SEATED_MPS: [f32; 2] = [0.1, 0.2];

// Speeds of feet.

/// Speed of a heel or toe near the ground below which it comes to stand (m/s).
///
/// The 95th percentile of the speeds of heels and toes of people who stand is 0.03 to 0.16 m/s in the sets of recordings.
///
/// Default of the detection of contacts; also used to find walks on the spot, and to judge how much planted feet slide.
pub const FOOT_PLANTED_MPS: f32 = 0.15;
/// Speed of a heel or toe above which it no longer stands (m/s).
///
/// The lowest part of the feet of who walks is slower in 95 of 100 frames (0.09 to 0.28 m/s in the sets of recordings); the faster
/// part of a foot that swings is faster (5th percentile 0.41 to 0.63).
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
/// Largest speed at which a toe is raised to clear the ground (m/s). Chosen.
///
/// Used by the foot lock.
pub const TOE_RAISED_MPS: f32 = 0.8;

// Turns of knees.

/// Fastest turn of the knee of a leg in the air, of somebody whose motion is captured (rad/s). Chosen, a little less than a
/// sprinter's, about 20: frames turn knees as they were captured, and the limit cuts what the foot lock adds.
///
/// Used where policy characters place their feet.
pub const KNEE_RADPS: f32 = 18.0;
/// Fastest turn of the knee of a leg in the air, of a walker that stands (rad/s, of the database skeleton). Chosen, less than
/// [`KNEE_RADPS`]: blends swing legs as fast as the walker goes, which [`WALKER_KNEE_RADPM`] adds.
///
/// Used where walkers place their feet.
pub const WALKER_KNEE_RADPS: f32 = 10.0;
/// Growth of [`WALKER_KNEE_RADPS`] with the speed of the walker (rad/m, of the database skeleton). Chosen, so that a sprinter's knee
/// turns at about 20 rad/s.
///
/// Used where walkers place their feet.
pub const WALKER_KNEE_RADPM: f32 = 1.8;

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
/// the length of its capsule's axis. It is written out, as their sum differs in the last bit.
///
/// Used to find whether boxers can reach each other's heads.
pub const HALF_HEAD_M: f32 = 0.12;
/// Room that a disc leaves beside the axis of the trunk (m). The whole breadth of the trunk keeps people further apart: of recorded
/// walkers that avoid each other, 84 % reach their targets then, where over 90 % do with this and [`HEAD_ROOM_M`].
///
/// Used for the discs of stop tables.
pub const TRUNK_ROOM_M: f32 = 0.14;
/// Room that a disc leaves beside the middle of the head, as [`TRUNK_ROOM_M`] beside the trunk (m).
///
/// Used for the discs of stop tables.
pub const HEAD_ROOM_M: f32 = 0.11;
/// Depth of the skin of buttocks below the axis of a thigh (m). Chosen, more than the radius of a thigh.
///
/// Used for contacts with units of an environment.
pub const BUTTOCK_M: f32 = 0.092;
/// Depths of the skin of the palm, and of the fingers, below the axis of a hand (m). Chosen.
///
/// Used for contacts with units of an environment.
pub const HAND_SKIN_M: [f32; 2] = [0.03, 0.022];
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
/// Smallest height over the ground of the toe of a fast foot in the air (m).
///
/// The lowest height of the toe between the first third and the last sixth of a step is 0.017 to 0.028 m in the middle of the steps
/// of each set of recordings.
///
/// Default of the foot lock.
pub const TOE_CLEARANCE_M: f32 = TOE_CLEARANCE_M_F64 as f32;
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
