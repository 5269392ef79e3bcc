//! Entries of `TASK.toml`, as they are written.

use crate::linkage::Limb;
use schemars::JsonSchema;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, de::value::MapAccessDeserializer};
use std::path::PathBuf;

/// A task: a clip, its surroundings, and the tasks of limbs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskFile {
    /// The motion to change: a file, or a table.
    #[serde(deserialize_with = "file_or_table")]
    #[schemars(with = "ClipForms")]
    pub clip: ClipEntry,
    /// Name in messages and in `to` of the character that moves as `clip` says.
    #[serde(default = "main")]
    pub name: String,
    /// File of the character's figure, with a skin (GLB or glTF), from the task's folder; its capsules are as thick as the
    /// figure.
    pub body: Option<PathBuf>,
    /// Other characters.
    #[serde(default)]
    pub characters: Vec<CharacterEntry>,
    /// Obstacles and objects.
    #[serde(default)]
    pub scene: SceneEntry,
    /// Tasks of limbs.
    pub tasks: Vec<TaskEntry>,
    /// Settings of plans.
    #[serde(default)]
    pub planner: PlannerEntry,
}

throng_base::key_defaults! {
    main: String = "main".into();
    walking: f64 = 1.2;
    one: f64 = 1.0;
}

/// A motion file or a synthetic clip, or a part of one.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "ClipTable", description = "")]
pub struct ClipEntry {
    /// Motion file, from the task's folder; FILE/CLIP for one of several in it.
    pub file: Option<PathBuf>,
    /// Synthetic set, see `throng synth`.
    pub synth: Option<String>,
    /// Clip of the set; the first one where absent.
    pub clip: Option<String>,
    /// Walking in place of a clip: the character walks up to its tasks.
    pub walk: Option<WalkEntry>,
    /// Begin of the part of the clip that is used, which is time 0 of everything (s).
    #[serde(default)]
    pub from_s: f64,
    /// End of that part; the clip's end where absent (s).
    pub to_s: Option<f64>,
}

/// A character that walks up to its tasks without `at_s`, with a body of a blend space.
#[derive(Clone, Debug, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkEntry {
    /// Bundle with the blend space, from the task's folder.
    pub bundle: PathBuf,
    /// Config from which the bundle is built where it is missing.
    pub config: Option<PathBuf>,
    /// Blend space, whose first axis is speed; the bundle's first one where absent.
    pub space: Option<String>,
    /// Place at which the character stands at first, x and z (m).
    #[serde(default)]
    pub from: [f64; 2],
    /// Heading of the character at first: 0 along z, 90 along x (degrees).
    #[serde(default)]
    pub heading_deg: f64,
    /// Walking speed (m/s, 0.3 to 4).
    #[serde(default = "walking")]
    pub speed_mps: f64,
    /// Speeds of a walk straight on, in place of walking up to anything: all tasks then need times.
    #[serde(default)]
    pub pace: Vec<PaceEntry>,
}

/// Speed of a character at a time, with even changes in between.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaceEntry {
    /// Time (s).
    pub t_s: f64,
    /// Speed (m/s, 0 to 8).
    pub speed_mps: f64,
}

/// A motion file or a synthetic clip, or a part of one.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "ClipEntry")]
#[expect(dead_code, reason = "for the schema")]
enum ClipForms {
    /// Motion file, from the task's folder; FILE/CLIP for one of several in it.
    File(PathBuf),
    Table(ClipEntry),
}

/// Reads a clip from a file name or a table.
fn file_or_table<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ClipEntry, D::Error> {
    struct ClipEntryVisitor;
    impl<'de> Visitor<'de> for ClipEntryVisitor {
        type Value = ClipEntry;
        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a motion file, or a table with `file` or `synth`")
        }
        fn visit_str<E>(self, file: &str) -> Result<ClipEntry, E> {
            Ok(ClipEntry { file: Some(file.into()), ..ClipEntry::default() })
        }
        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ClipEntry, A::Error> {
            ClipEntry::deserialize(MapAccessDeserializer::new(map))
        }
    }
    deserializer.deserialize_any(ClipEntryVisitor)
}

/// Another character.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CharacterEntry {
    /// Name in tasks and messages.
    pub name: String,
    /// Motion.
    #[serde(deserialize_with = "file_or_table")]
    #[schemars(with = "ClipForms")]
    pub clip: ClipEntry,
    /// File of the character's figure, with a skin (GLB or glTF), from the task's folder; its triangles are obstacles of the
    /// others.
    pub body: Option<PathBuf>,
    /// Offset of its motion (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// Turn of its motion about the vertical axis, before the offset (degrees).
    #[serde(default)]
    pub heading_deg: f64,
}

#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    /// Things that stay, or move through keys.
    #[serde(default)]
    pub obstacles: Vec<ThingEntry>,
    /// Things that can be taken.
    #[serde(default)]
    pub objects: Vec<ThingEntry>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ThingEntry {
    /// Name in tasks and messages.
    pub name: String,
    /// Its shape, or one of them.
    pub shape: Option<ShapeEntry>,
    /// Several shapes that move as one.
    #[serde(default)]
    pub shapes: Vec<ShapeEntry>,
    /// Position (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// Rotation vector (degrees).
    #[serde(default)]
    pub turn_deg: [f64; 3],
    /// Places at times, with even motion in straight lines in between.
    #[serde(default)]
    pub keys: Vec<KeyEntry>,
    /// `CHARACTER.JOINT` that carries it from the beginning; `at` and `turn_deg` are seen from there. Objects only.
    pub attached_to: Option<String>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum ShapeEntry {
    /// A ball (m).
    Ball {
        /// Radius (m, > 0).
        radius: f64,
        /// Middle, seen from the object (m).
        #[serde(default)]
        at: [f64; 3],
    },
    /// A box around the object's origin (m).
    Box {
        /// Size (m, > 0).
        size: [f64; 3],
    },
    /// All points within a radius of a line (m).
    Capsule {
        /// One end (m).
        from: [f64; 3],
        /// The other end (m).
        to: [f64; 3],
        /// Radius (m, > 0).
        radius: f64,
    },
    /// Triangles.
    Mesh {
        /// OBJ, glTF or GLB, from the task's folder.
        file: PathBuf,
        /// Length of one unit of the file (m, 0.000001 to 1000000).
        #[serde(default = "one")]
        unit_m: f64,
        /// False refuses surfaces with holes, which let nothing through but have no inside.
        #[serde(default)]
        open: bool,
    },
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyEntry {
    /// Time (s).
    pub t_s: f64,
    /// Position (m).
    pub at: [f64; 3],
    /// Rotation vector (degrees).
    #[serde(default)]
    pub turn_deg: [f64; 3],
}

/// A grip: the place of the hand at an object.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GripEntry {
    /// Position seen from the object: with `turn_deg` of the wrist, without it of the middle of the hand (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// Rotation vector of the hand (degrees); any turn that is reached where absent.
    pub turn_deg: Option<[f64; 3]>,
}

/// A place.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaceEntry {
    /// Position (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// Rotation vector of the object (degrees); upright, with any turn about the vertical that is reached, where absent.
    pub turn_deg: Option<[f64; 3]>,
    /// Obstacle, object or `CHARACTER.JOINT` from which the place is seen; the world where absent.
    pub on: Option<String>,
}

/// Receiver of an object that is handed over.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ReceiverEntry {
    /// Character that receives; the one that gives where absent.
    pub character: Option<String>,
    /// Receiving arm.
    pub limb: Limb,
    /// Grips of the receiving hand.
    #[serde(default)]
    pub grips: Vec<GripEntry>,
}

/// The second hand at an object.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SecondEntry {
    /// The other arm.
    pub limb: Limb,
    /// Grips of the second hand.
    pub grips: Vec<GripEntry>,
}

/// A task of a limb.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskEntry {
    /// Name in reports.
    pub name: Option<String>,
    /// Character that does it.
    pub character: Option<String>,
    /// Limb that does it.
    pub limb: Limb,
    /// Action.
    #[serde(rename = "do")]
    pub action: TaskAction,
    /// Object of the action.
    pub object: Option<String>,
    /// Time at which the target is reached (s); a walking character may leave it out, and goes there first.
    pub at_s: Option<f64>,
    /// Times from and to which the limb leaves the clip; for `correct`, the stretch that is searched for collisions (s).
    pub window_s: Option<[f64; 2]>,
    /// Time for which the limb then keeps its pose, relative to the trunk (s, 0 to 600).
    #[serde(default)]
    pub hold_s: f64,
    /// Grips of the hand on the object, tried in this order.
    #[serde(default)]
    pub grips: Vec<GripEntry>,
    /// The other hand, which takes the object, too; from then on it follows the first one. For `grab`.
    pub second: Option<SecondEntry>,
    /// Place to which the object is brought.
    pub to: Option<PlaceEntry>,
    /// Largest tilt of a held object from upright on the way there (degrees, more than 0, less than 180); any tilt where
    /// absent.
    pub level_deg: Option<f64>,
    /// Receiver of the object.
    pub receiver: Option<ReceiverEntry>,
    /// Names of things that the limb and its object may touch a quarter of a second around `at_s`, beside the object itself.
    #[serde(default)]
    pub contacts: Vec<String>,
    /// Order of tasks: the least goes first; equal ones as written.
    #[serde(default)]
    pub priority: i32,
    /// Preferred angles, by joint.
    #[serde(default)]
    pub style: std::collections::BTreeMap<String, StyleEntry>,
}

/// Preferred angles of a joint, from which plans are sampled.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct StyleEntry {
    /// Least and greatest swing about each of the two axes across the segment (degrees).
    pub swing_deg: Option<[[f64; 2]; 2]>,
    /// Least and greatest flexion of elbow or knee (degrees).
    pub flexion_deg: Option<[f64; 2]>,
    /// Least and greatest twist about the segment (degrees).
    pub twist_deg: Option<[f64; 2]>,
}

/// Action of a limb.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TaskAction {
    /// Give way where it collides.
    Correct,
    /// Come to an object without touching it, and back.
    Reach,
    /// Touch an object and come back.
    Touch,
    /// Touch an object that is switched by it, and come back.
    Switch,
    /// Take an object along.
    Grab,
    /// Bring what is held to a place, and keep it.
    Carry,
    /// Bring what is held to a place and let it go.
    Drop,
    /// Give what is held to another hand.
    HandOver,
}

impl TaskAction {
    /// Name in tasks.
    pub const fn name(self) -> &'static str {
        ["correct", "reach", "touch", "switch", "grab", "carry", "drop", "hand_over"][self as usize]
    }

    /// True where the object has to be in the hand before.
    pub(super) const fn needs_held_object(self) -> bool {
        matches!(self, Self::Carry | Self::Drop | Self::HandOver)
    }
}

/// Settings of plans.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct PlannerEntry {
    /// Random seed: the same seed gives the same plans.
    pub seed: u64,
    /// Most samples of a search (0 to 1000000).
    pub draws: u32,
    /// Most time of a plan; results then depend on the machine (s).
    pub budget_s: Option<f64>,
    /// Step by which trees grow (m).
    pub epsilon_m: f64,
    /// Least distance of everything from obstacles (m).
    pub clearance_m: f64,
    /// Number of tries to straighten a path (0 to 10000).
    pub straighten: u32,
    /// Time over which corners are rounded (s).
    pub round_s: f64,
    /// Time over which ends are blended (s).
    pub blend_s: f64,
    /// True turns heads to the targets of limbs, and back, as far as necks allow.
    pub gaze: bool,
    /// True bends trunks where an arm does not reach otherwise.
    pub lean: bool,
    /// True moves hips where trunks bend, so that the weight stays over planted feet, and reports how far it is off them.
    pub balance: bool,
    /// Time before and after a collision in which a limb gives way at first (s).
    pub margin_s: f64,
}
