//! What `TASK.toml` may hold, as it is written.

use crate::linkage::Limb;
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::path::PathBuf;

/// A task: a clip, what is around, what limbs have to do.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskFile {
    /// The motion to change: a file, or a table.
    pub clip: ClipEntry,
    /// How messages and `to` call who moves as `clip` says.
    #[serde(default = "main")]
    pub name: String,
    /// The character that it wears, with a skin (GLB or glTF), from the task's folder: as thick as that is, it collides.
    pub body: Option<PathBuf>,
    /// Who else is around.
    #[serde(default)]
    pub characters: Vec<CharacterEntry>,
    /// What is around.
    #[serde(default)]
    pub scene: SceneEntry,
    /// What limbs have to do.
    pub tasks: Vec<TaskEntry>,
    /// How plans are made.
    #[serde(default)]
    pub planner: PlannerEntry,
}

fn main() -> String {
    "main".into()
}

/// A motion file or a synthetic clip, or a part of one.
#[derive(Clone, Debug, Default, PartialEq, JsonSchema)]
#[schemars(with = "ClipForms")]
pub struct ClipEntry {
    /// Motion file, from the task's folder; FILE/CLIP for one of several in it.
    pub file: Option<PathBuf>,
    /// Synthetic set, see `throng synth`.
    pub synth: Option<String>,
    /// Clip of the set; the first one where absent.
    pub clip: Option<String>,
    /// It walks up to what it does.
    pub walk: Option<WalkEntry>,
    /// Where it begins: that is time 0 of everything (s).
    pub from_s: f64,
    /// Where it ends; the clip's end where absent (s).
    pub to_s: Option<f64>,
}

/// Somebody who walks up to what its tasks without `at_s` are about, with a body of a blend space.
#[derive(Clone, Debug, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WalkEntry {
    /// Bundle with the blend space, from the task's folder.
    pub bundle: PathBuf,
    /// Config from which the bundle is built where it is missing.
    pub config: Option<PathBuf>,
    /// Blend space, whose first axis is speed; the bundle's first one where absent.
    pub space: Option<String>,
    /// Where it stands at first, x and z (m).
    #[serde(default)]
    pub from: [f64; 2],
    /// How it looks then: 0 along z, 90 along x (degrees).
    #[serde(default)]
    pub heading_deg: f64,
    /// How fast it walks (m/s, 0.3 to 4).
    #[serde(default = "walking")]
    pub speed_mps: f64,
    /// It goes straight on at these speeds in place of walking up to anything: all its tasks have times.
    #[serde(default)]
    pub pace: Vec<PaceEntry>,
}

/// How fast somebody goes at a time; evenly faster or slower in between.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaceEntry {
    /// (s)
    pub t_s: f64,
    /// (m/s, 0 to 8)
    pub speed_mps: f64,
}

fn walking() -> f64 {
    1.2
}

#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "for the schema")]
enum ClipForms {
    /// Motion file, from the task's folder; FILE/CLIP for one of several in it.
    File(PathBuf),
    Table(ClipTable),
}

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ClipTable {
    /// Motion file, from the task's folder; FILE/CLIP for one of several in it.
    file: Option<PathBuf>,
    /// Synthetic set, see `throng synth`.
    synth: Option<String>,
    /// Clip of the set; the first one where absent.
    clip: Option<String>,
    /// It walks up to what it does, in place of a clip.
    walk: Option<WalkEntry>,
    /// Where it begins: that is time 0 of everything (s).
    #[serde(default)]
    from_s: f64,
    /// Where it ends; the clip's end where absent (s).
    to_s: Option<f64>,
}

impl<'de> Deserialize<'de> for ClipEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = ClipEntry;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a motion file, or a table with `file` or `synth`")
            }
            fn visit_str<E>(self, file: &str) -> Result<ClipEntry, E> {
                Ok(ClipEntry { file: Some(file.into()), ..ClipEntry::default() })
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ClipEntry, A::Error> {
                let ClipTable { file, synth, clip, walk, from_s, to_s } =
                    ClipTable::deserialize(MapAccessDeserializer::new(map))?;
                Ok(ClipEntry { file, synth, clip, walk, from_s, to_s })
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// Another character.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CharacterEntry {
    /// How tasks and messages call it.
    pub name: String,
    /// Its motion.
    pub clip: ClipEntry,
    /// The character that it wears, with a skin (GLB or glTF), from the task's folder: its triangles are in the others' way.
    pub body: Option<PathBuf>,
    /// Its motion is moved by so much (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// And before that turned about the vertical axis (degrees).
    #[serde(default)]
    pub heading_deg: f64,
}

#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    /// What stays, or goes through keys.
    #[serde(default)]
    pub obstacles: Vec<ThingEntry>,
    /// What can be taken.
    #[serde(default)]
    pub objects: Vec<ThingEntry>,
}

#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ThingEntry {
    /// How tasks and messages call it.
    pub name: String,
    /// Its shape, or one of them.
    pub shape: Option<ShapeEntry>,
    /// Several shapes that move as one.
    #[serde(default)]
    pub shapes: Vec<ShapeEntry>,
    /// Where it is (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// How it is turned: a rotation vector (degrees).
    #[serde(default)]
    pub turn_deg: [f64; 3],
    /// Where it is at times; even and straight in between.
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
        /// (m, > 0)
        radius: f64,
        /// Its middle, seen from the object (m).
        #[serde(default)]
        at: [f64; 3],
    },
    /// A box around the object's origin (m).
    Box {
        /// (m, > 0)
        size: [f64; 3],
    },
    /// All within a radius of a line (m).
    Capsule {
        /// One end (m).
        from: [f64; 3],
        /// The other end (m).
        to: [f64; 3],
        /// (m, > 0)
        radius: f64,
    },
    /// Triangles.
    Mesh {
        /// OBJ, glTF or GLB, from the task's folder.
        file: PathBuf,
        /// Metres that a unit of the file is (0.000001 to 1000000).
        #[serde(default = "one")]
        unit_m: f64,
        /// False refuses surfaces with holes, which let nothing through but have no inside.
        #[serde(default)]
        open: bool,
    },
}

fn one() -> f64 {
    1.0
}

#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyEntry {
    /// (s)
    pub t_s: f64,
    /// (m)
    pub at: [f64; 3],
    /// Rotation vector (degrees).
    #[serde(default)]
    pub turn_deg: [f64; 3],
}

/// Where the hand holds an object.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GripEntry {
    /// Seen from the object: with `turn_deg` the wrist, without it the middle of the hand (m).
    #[serde(default)]
    pub at: [f64; 3],
    /// How the hand is turned, as a rotation vector (degrees); any way that is reached where absent.
    pub turn_deg: Option<[f64; 3]>,
}

/// A place.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct PlaceEntry {
    /// (m)
    #[serde(default)]
    pub at: [f64; 3],
    /// How the object is turned, as a rotation vector (degrees); upright, turned in any way that is reached, where absent.
    pub turn_deg: Option<[f64; 3]>,
    /// Seen from an obstacle, an object or `CHARACTER.JOINT`; from the world where absent.
    pub on: Option<String>,
}

/// Who takes what is handed over.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ReceiverEntry {
    /// Who; the one that gives where absent.
    pub character: Option<String>,
    /// With which arm.
    pub limb: Limb,
    /// Where its hand holds the object.
    #[serde(default)]
    pub grips: Vec<GripEntry>,
}

/// The second hand at an object.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SecondEntry {
    /// The other arm.
    pub limb: Limb,
    /// Where its hand holds the object.
    pub grips: Vec<GripEntry>,
}

/// Something to do.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TaskEntry {
    /// How reports call it.
    pub name: Option<String>,
    /// Who does it.
    pub character: Option<String>,
    /// With which limb.
    pub limb: Limb,
    /// What.
    #[serde(rename = "do")]
    pub deed: Deed,
    /// With what.
    pub object: Option<String>,
    /// When it is reached (s); who walks may leave it out, and goes there first.
    pub at_s: Option<f64>,
    /// From when to when the limb leaves the clip; of `correct`, where it is looked for collisions (s).
    pub window_s: Option<[f64; 2]>,
    /// How long the limb keeps its pose then, as seen from the trunk (s, 0 to 600).
    #[serde(default)]
    pub hold_s: f64,
    /// Where the hand holds the object: tried in this order.
    #[serde(default)]
    pub grips: Vec<GripEntry>,
    /// The other hand that takes the object, too; from then on it follows the first one. For `grab`.
    pub second: Option<SecondEntry>,
    /// Where the object is brought.
    pub to: Option<PlaceEntry>,
    /// How far what is held may tilt on the way there, from upright (degrees, more than 0, less than 180); any way where absent.
    pub level_deg: Option<f64>,
    /// Who takes it over.
    pub receiver: Option<ReceiverEntry>,
    /// What the limb and what it holds may touch a quarter of a second around `at_s`, beside the object.
    #[serde(default)]
    pub contacts: Vec<String>,
    /// Least goes first; as written where equal.
    #[serde(default)]
    pub priority: i32,
    /// Angles that are wanted, by joint.
    #[serde(default)]
    pub style: std::collections::BTreeMap<String, StyleEntry>,
}

/// Angles of a joint that plans are drawn from.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct StyleEntry {
    /// From and to, about each of the two axes across the segment (degrees).
    pub swing_deg: Option<[[f64; 2]; 2]>,
    /// Of elbow and knee (degrees).
    pub flexion_deg: Option<[f64; 2]>,
    /// About the segment (degrees).
    pub twist_deg: Option<[f64; 2]>,
}

/// What a limb has to do.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Deed {
    /// Give way where it collides.
    Correct,
    /// Come to an object without touching it, and back.
    Reach,
    /// Touch an object and come back.
    Touch,
    /// The same, of something that is switched by it.
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

impl Deed {
    /// As tasks write it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::Reach => "reach",
            Self::Touch => "touch",
            Self::Switch => "switch",
            Self::Grab => "grab",
            Self::Carry => "carry",
            Self::Drop => "drop",
            Self::HandOver => "hand_over",
        }
    }

    /// True where the object has to be in the hand before.
    pub(super) const fn holds(self) -> bool {
        matches!(self, Self::Carry | Self::Drop | Self::HandOver)
    }
}

/// How plans are made.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct PlannerEntry {
    /// Same seed, same plans.
    pub seed: u64,
    /// Most samples of a search (0 to 1000000).
    pub draws: u32,
    /// Most time of a plan; results then depend on the machine (s).
    pub budget_s: Option<f64>,
    /// How far trees grow at a time (m).
    pub epsilon_m: f64,
    /// Looks at so many radians in place of proofs, as the paper does.
    pub resolution_rad: Option<f64>,
    /// How far everything stays from obstacles (m).
    pub clearance_m: f64,
    /// Tries to straighten a way (0 to 10000).
    pub straighten: u32,
    /// Time over which corners are rounded (s).
    pub round_s: f64,
    /// Time over which ends are blended (s).
    pub blend_s: f64,
    /// Heads turn to what limbs reach for, and back, as far as necks allow.
    pub gaze: bool,
    /// Trunks bend where an arm does not reach otherwise.
    pub lean: bool,
    /// Hips give way where trunks bend, so that the weight stays over feet that stand; how far it is off them is told.
    pub balance: bool,
    /// Time before and after a collision in which a limb gives way at first (s).
    pub margin_s: f64,
}
