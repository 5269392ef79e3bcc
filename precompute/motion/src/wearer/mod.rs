//! Motion of a take on the user's own character.
//!
//! The roles of its joints are found as those of motion files are. Each of these joints turns as the motion's does, over the
//! difference of the rest poses; twist joints take their share of the twist of a limb; all others stay at rest. The character
//! is scaled as a whole, until its legs are as long as those of the motion: so feet stand where they stood, and all characters
//! keep their places.

mod copy;
mod figure;
mod moved_joints;
mod surface;
mod worn_fit;

use crate::error::{BuildError, ImportError, Result, ensure};
use crate::export::{Glb, Take};
use crate::import::gltf::{self, AccessorReader, GltfDocument};
use crate::import::source::content_error;
use crate::import::{ImportConfig, MAX_MOTION_BYTES, RoleMap, UpAxis, archive, interpret};
use crate::{export::scratch::TrackScratch, import::nodes::Rig, progress::Progress, retarget::BodyFit};
use figure::FigureSkin;
pub use figure::SkinnedFigure;
use glam::{DAffine3, DQuat};
use moved_joints::{MovedJoint, ScaledWearer};
use serde_json::Value;
use std::path::Path;
pub use surface::{FigureSurface, Material, SurfaceCorner};
use throng_core::Joint;
pub use worn_fit::WornFit;

/// Advice how to get a file that can be worn.
const HELP: &str = "Export the character with mesh, skin and textures as one .glb file";
/// Factor by which nodes above the hips may shrink them: numbers in there are of single precision.
const MOST_SHRUNK: f64 = 1e6;

/// A character that wears motion.
pub struct Wearer {
    document: GltfDocument,
    /// The document as JSON, with the parts that only copies need.
    json: Value,
    buffer: Vec<u8>,
    rig: Rig,
    fit: BodyFit,
    roles: RoleMap,
    /// Length of a unit of the file (m).
    metres_per_unit: f64,
    moved: Vec<MovedJoint>,
    /// Index of the joint that carries all that moves.
    centre: usize,
    /// Its triangles, or the reason why they cannot be read.
    skin: std::result::Result<FigureSkin, String>,
    /// Height in a T-pose (m).
    height_m: f32,
}

/// A character that wears a take.
pub struct DressedTake<'a> {
    wearer: &'a Wearer,
    scratch: TrackScratch,
}

impl Wearer {
    /// Reads a character: a `.glb` file, or a `.gltf` file with one buffer and its textures in it.
    ///
    /// - `config`: profiles that name roles, where names and shape do not tell.
    ///
    /// # Errors
    /// [`BuildError::Import`] for a file without a skin, of several people, of none, or that lies in several files.
    pub fn open(path: &Path, config: &ImportConfig) -> Result<Self> {
        Self::parse(&archive::read_file(path, "a character", MAX_MOTION_BYTES)?, path, config)
    }

    /// Reads a character as [`Wearer::open`] does, from the bytes of a file; `path` is for errors and for its buffer beside it.
    ///
    /// # Errors
    /// Errors of [`Wearer::open`].
    pub fn parse(bytes: &[u8], path: &Path, config: &ImportConfig) -> Result<Self> {
        let fail = |what: String| content_error(path, what, HELP);
        let (document, binary) = gltf::document(bytes).map_err(fail)?;
        let mut rigs = gltf::rigs(bytes, path)?;
        let message = || format!("expected one character, found {} skeletons", rigs.len());
        ensure(rigs.len() <= 1, || content_error(path, message(), "Export one of them alone"))?;
        let Some(rig) = rigs.pop() else { return Err(fail("it has no skeleton".into()).into()) };
        let json = complete_document(bytes, path)?;
        ensure(document.buffers.len() <= 1, || fail(format!("expected one buffer, found {}", document.buffers.len())))?;
        let buffer = AccessorReader::new(&document, binary, path)?.bytes(0).unwrap_or_default().to_vec();
        // Such files have Y up.
        let config = ImportConfig { up: Some(UpAxis::Y), ..config.clone() };
        let body = interpret(rig.clip.clone(), &config, &crate::import::profile::load_profiles(&config.profiles)?)?;
        let fit = BodyFit::new(&body)?;
        let (roles, metres_per_unit, height_m) = (body.roles, body.metres_per_unit, fit.skeleton.height());
        let (moved, centre, skin) = (Vec::new(), 0, Err(String::new()));
        let mut wearer =
            Self { document, json, buffer, rig, fit, roles, metres_per_unit, moved, centre, skin, height_m };
        wearer.check_skin(path)?;
        wearer.put_on_skin();
        let back = wearer.above_centre().0.inverse();
        match back.is_finite() && back.matrix3.to_cols_array().iter().all(|v| v.abs() <= MOST_SHRUNK) {
            true => Ok(wearer),
            false => Err(fail("what is above its hips has a scale of 0, or next to it".into()).into()),
        }
    }

    /// Refuses skins that hang on other trees of nodes, too: no copy could hold them.
    fn check_skin(&self, path: &Path) -> Result<(), ImportError> {
        let (own, nodes) = (self.nodes(), &self.document.nodes);
        let skins = self.document.skins.iter().filter(|s| s.joints.iter().any(|j| own.contains(j)));
        let Some(outside) = skins.flat_map(|s| &s.joints).find(|j| !own.contains(j)) else { return Ok(()) };
        let name = nodes.get(*outside).map_or("", |n| &n.name);
        let what = format!("its skin hangs on `{name}`, which is outside of its skeleton");
        Err(content_error(path, what, "Hang that node below the joint it goes with, or take it out of the skin"))
    }

    /// Reads the triangles, finds the joints that move, and measures the body in a T-pose: its height, and its soles.
    fn put_on_skin(&mut self) {
        let mut skin = FigureSkin::read(self);
        let carrying = skin.as_ref().map(FigureSkin::carrying_nodes).unwrap_or_default();
        let joints = &self.rig.joints;
        let skinned: Vec<usize> = (0..joints.len()).filter(|&j| carrying.contains(&joints[j])).collect();
        let clip = &self.rig.clip.clip;
        self.centre = moved_joints::centre_joint(clip, &self.roles, &skinned);
        self.moved = moved_joints::find_moved_joints(clip, &self.roles, &self.fit, self.centre);
        if let Ok(skin) = &mut skin {
            skin.set_moved(&self.moved, joints, self.centre);
            if let Some(stance) = worn_fit::measure_stance(self, skin) {
                self.fit.skeleton.offsets[0].y -= stance.soles_m;
                self.height_m = stance.height_m;
            }
        }
        self.skin = skin;
    }

    /// Measures how the character wears a take: how far its skin is stretched, and where its soles are.
    ///
    /// - returns `None` where its triangles cannot be read.
    ///
    /// # Errors
    /// [`BuildError::Io`] for errors of the disk.
    pub fn measure(&self, take: &Take) -> Result<Option<WornFit>> {
        let io = |source| BuildError::Io { path: self.rig.clip.clip.path.clone(), source };
        self.skin.as_ref().ok().map(|skin| worn_fit::measure(self, skin, take).map_err(io)).transpose()
    }

    /// Roles, and the joints of the character that play them.
    pub fn pairs(&self) -> impl Iterator<Item = (Joint, &str)> {
        self.roles.pairs(&self.rig.clip.clip.joints)
    }

    /// Names of joints that take a share of a twist.
    pub fn twists(&self) -> impl Iterator<Item = &str> {
        let twists = self.moved.iter().filter(|m| m.is_twist());
        twists.map(|m| self.rig.clip.clip.joints[m.joint].name.as_str())
    }

    /// Number of its joints.
    pub fn num_joints(&self) -> usize {
        self.rig.joints.len()
    }

    /// Dresses the character with a take.
    ///
    /// - `folder`: folder of the file that holds the motion of its joints until it is dropped.
    ///
    /// # Errors
    /// [`BuildError::Io`] for errors of the disk.
    pub fn dress(&self, take: &Take, folder: &Path, progress: &dyn Progress) -> Result<DressedTake<'_>> {
        let io = |source| BuildError::Io { path: folder.to_path_buf(), source };
        let mut widths = vec![4; self.moved.len()];
        widths.push(3);
        let mut scratch = TrackScratch::new(folder, take.actors().len(), &widths, 1).map_err(io)?;
        let frames: usize = (0..take.actors().len()).map(|a| take.num_frames(a)).sum();
        progress.begin("dress", frames as u64, "frames");
        for a in 0..take.actors().len() {
            progress.check()?;
            moved_joints::record_worn_motion(self, take, a, &mut scratch).map_err(io)?;
            progress.advance(take.num_frames(a) as u64);
        }
        progress.end();
        Ok(DressedTake { wearer: self, scratch })
    }

    /// Nodes of the character, parents first.
    fn nodes(&self) -> Vec<usize> {
        let mut nodes = vec![self.rig.above.first().copied().unwrap_or(self.rig.joints[0])];
        let mut at = 0;
        while at < nodes.len() {
            nodes.extend(&self.document.nodes[nodes[at]].children);
            at += 1;
        }
        nodes
    }

    /// Scale of the character for an actor: as tall as the motion's legs ask for, in metres.
    fn scale(&self, take: &Take, actor: usize) -> f64 {
        ScaledWearer::new(self, &take.actors()[actor].skeleton).scale
    }

    /// Frame of the joint that carries the body, and its rotation, in the file's units.
    fn above_centre(&self) -> (DAffine3, DQuat) {
        let mut nodes = self.rig.above.clone();
        let joints = &self.rig.clip.clip.joints;
        let up = std::iter::successors(joints[self.centre].parent, |&j| joints[j].parent);
        let mut chain: Vec<usize> = up.map(|j| self.rig.joints[j]).collect();
        chain.reverse();
        nodes.extend(chain);
        let mut frame = (DAffine3::IDENTITY, DQuat::IDENTITY);
        for node in nodes {
            let local = gltf::local_transform(&self.document.nodes[node]);
            let turn = local.rotation.normalize();
            let inner = DAffine3::from_scale_rotation_translation(local.scale, turn, local.translation);
            frame = (frame.0 * inner, frame.1 * turn);
        }
        frame
    }
}

impl DressedTake<'_> {
    /// Passes all numbers by which the character moves to `look`.
    pub fn numbers(&self, mut look: impl FnMut(&[f32])) {
        for actor in 0..self.scratch.num_actors() {
            // Reading back fails only where the disk does: then there is nothing to pass on.
            _ = self.scratch.frames(actor, |_, numbers| {
                look(numbers);
                Ok(())
            });
        }
    }

    /// The document of the take that it was made for.
    ///
    /// # Errors
    /// Errors of [`Glb::new`].
    pub fn glb<'a>(&'a self, take: &'a Take) -> Result<Glb<'a>> {
        Glb::from_parts(take, copy::copied_parts(self.wearer, take), &self.scratch)
    }
}

/// The complete document as JSON.
fn complete_document(bytes: &[u8], path: &Path) -> Result<Value, ImportError> {
    let fail = |what: String| content_error(path, what, HELP);
    let (text, _) = gltf::split(bytes).map_err(fail)?;
    let json: Value = serde_json::from_slice(text).map_err(|e| fail(e.to_string()))?;
    // Parts that are written must follow the format.
    let mut entries = ["nodes", "skins"].iter().flat_map(|list| json[list].as_array().into_iter().flatten());
    if !json["asset"].is_object() || !entries.all(Value::is_object) {
        return Err(fail("expected objects as `asset`, nodes and skins".into()));
    }
    let mut uris = json["images"].as_array().into_iter().flatten().filter_map(|i| i["uri"].as_str());
    match uris.find(|uri| !uri.starts_with("data:")) {
        Some(uri) => Err(fail(format!("its texture `{uri}` lies in a file of its own"))),
        None => Ok(json),
    }
}
