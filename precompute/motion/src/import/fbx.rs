//! Reads FBX, as text or binary, by way of the library ufbx.
//!
//! Units and axes are those that the file names. Rates are, too, unless keys are closer together.

use super::nodes::{
    AnimationSpan, FALLBACK_HZ, NodeAnimation, RigNode, RigScene, Transform, rate_of_keys, without_rounding,
};
use super::{SourceClip, archive, content_error};
use crate::{error::ImportError, raw::SourceFormat};
use glam::{DQuat, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::{path::Path, rc::Rc};
use ufbx::{AllocatorOpts, CoordinateAxes, FileFormat, InheritModeHandling, LoadOpts, SceneRoot};

/// Most levels of nodes.
const MAX_DEPTH: u32 = 512;
/// Memory for each byte of a file, as arrays are compressed (bytes).
const MEMORY_PER_BYTE: usize = 64;
/// Memory for every file (bytes).
const MEMORY: usize = 64 << 20;
/// Most memory for any file (bytes).
const MAX_MEMORY: usize = 4 << 30;
/// Bound of times (s).
const MAX_TIME_S: f64 = 1e6;
/// Bound of rates (Hz).
const MAX_RATE_HZ: f64 = 1e5;
/// Properties that move a node.
const MOVING: [&str; 3] = ["Lcl Translation", "Lcl Rotation", "Lcl Scaling"];

/// Reads the clips of an `.fbx` file: one for each animation stack and each skeleton that it moves.
///
/// # Errors
/// [`ImportError::Content`] with the message of the library, or naming the part of the scene that is missing or wrong.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Vec<SourceClip>, ImportError> {
    let scene = ufbx::load_memory(bytes, options(bytes.len())).map_err(|e| {
        let message = format!("it is no FBX file that can be read: {}", e.description.as_ref());
        content_error(path, message, "Export it again, as binary FBX of 2011 or later")
    })?;
    let skins = scene.skin_deformers.into_iter().map(|skin| {
        let joints = skin.clusters.into_iter().filter_map(|c| c.bone_node.as_ref());
        joints.map(|n| n.element.typed_id as usize).collect()
    });
    let stacks = scene.anim_stacks.into_iter().map(|stack| Stack::new(&scene, stack));
    let stacks = stacks.collect::<Result<Vec<_>, _>>();
    let stacks = stacks.map_err(|what| content_error(path, what, "Export it again"))?;
    RigScene {
        path,
        format: SourceFormat::Fbx,
        num_bytes: archive::counted_bytes(path, bytes.len()),
        nodes: nodes(&scene),
        skins: skins.collect(),
        animations: stacks.into_iter().map(|s| Box::new(s) as Box<dyn NodeAnimation>).collect(),
    }
    .clips()
}

fn options(num_bytes: usize) -> LoadOpts<'static> {
    let memory_limit = num_bytes.saturating_mul(MEMORY_PER_BYTE).saturating_add(MEMORY).min(MAX_MEMORY);
    let allocator = || AllocatorOpts { memory_limit, ..AllocatorOpts::default() };
    LoadOpts {
        temp_allocator: allocator(),
        result_allocator: allocator(),
        ignore_geometry: true,
        ignore_embedded: true,
        skip_skin_vertices: true,
        node_depth_limit: MAX_DEPTH,
        inherit_mode_handling: InheritModeHandling::Compensate,
        target_axes: CoordinateAxes::right_handed_y_up(),
        target_unit_meters: 1.0,
        // The library reads other formats, too.
        file_format: FileFormat::Fbx,
        ..LoadOpts::default()
    }
}

fn nodes(scene: &SceneRoot) -> Vec<RigNode> {
    let mut out = Vec::new();
    for (i, node) in scene.nodes.into_iter().enumerate() {
        let name = node.element.name.as_ref();
        let name = if name.is_empty() { format!("node {i}") } else { name.to_owned() };
        let parent = node.parent.as_ref().map(|p| p.element.typed_id as usize);
        let shows = node.mesh.is_some() || node.light.is_some() || node.camera.is_some();
        out.push(RigNode { name, parent, local: transform(&node.local_transform), bind: None, shows });
    }
    let mut bind = |node: &ufbx::Node, world: &ufbx::Matrix| {
        let rotation = transform(&ufbx::matrix_to_transform(world)).rotation;
        let node = &mut out[node.element.typed_id as usize];
        node.bind = node.bind.or(Some(rotation).filter(|r| r.is_normalized()));
    };
    for pose in scene.poses.into_iter().filter(|p| p.is_bind_pose) {
        pose.bone_poses.into_iter().for_each(|b| bind(&b.bone_node, &b.bone_to_world));
    }
    for cluster in &scene.skin_clusters {
        if let Some(node) = &cluster.bone_node {
            bind(node, &cluster.bind_to_world);
        }
    }
    out
}

fn transform(t: &ufbx::Transform) -> Transform {
    let vector = |v: &ufbx::Vec3| DVec3::new(v.x, v.y, v.z);
    let r = &t.rotation;
    let rotation = DQuat::from_xyzw(r.x, r.y, r.z, r.w);
    Transform { scale: vector(&t.scale), rotation, translation: vector(&t.translation) }
}

/// An animation stack, which other programs call a take or an action.
struct Stack<'a> {
    scene: &'a SceneRoot,
    stack: &'a ufbx::AnimStack,
    moved: BTreeSet<usize>,
    begin: f64,
    end: f64,
    rate_hz: f64,
    why: &'static str,
}

impl<'a> Stack<'a> {
    fn new(scene: &'a SceneRoot, stack: &'a ufbx::AnimStack) -> Result<Self, String> {
        // Nodes may share curves.
        let (mut moved, mut keys) = (BTreeSet::new(), Vec::<Rc<[f64]>>::new());
        let mut known = BTreeMap::<u32, Rc<[f64]>>::new();
        for prop in stack.layers.into_iter().flat_map(|layer| &layer.anim_props) {
            if let Some(node) = ufbx::as_node(&prop.element).filter(|_| MOVING.contains(&prop.prop_name.as_ref())) {
                moved.insert(node.element.typed_id as usize);
                let curves = prop.anim_value.curves.iter().flatten();
                keys.extend(curves.map(|c| {
                    let times = || c.keyframes.iter().map(|k| k.time).collect();
                    known.entry(c.element.typed_id).or_insert_with(times).clone()
                }));
            }
        }
        let name = stack.element.name.as_ref();
        let (mut begin, mut end) = (stack.time_begin, stack.time_end);
        if begin >= end {
            // Where the stack has no times, its keys do.
            begin = known.values().flat_map(|k| k.iter()).copied().fold(f64::INFINITY, f64::min);
            end = known.values().flat_map(|k| k.iter()).copied().fold(f64::NEG_INFINITY, f64::max);
        }
        let known = begin.abs() < MAX_TIME_S && end.abs() < MAX_TIME_S && begin <= end;
        if !known && !moved.is_empty() {
            return Err(format!(
                "animation stack `{name}`: expected times below {MAX_TIME_S} s, found {begin} to {end}"
            ));
        }
        let named = Some(without_rounding(scene.settings.frames_per_second));
        let named = named.filter(|hz| (1.0..MAX_RATE_HZ).contains(hz));
        let of_keys = rate_of_keys(keys.iter().map(|k| &**k));
        let (rate_hz, why) = match (named, of_keys) {
            (Some(hz), Some(keys)) if keys > hz * 1.001 => {
                (keys, "its keys are that far apart, closer than the file says")
            }
            (Some(hz), _) => (hz, "the file says so"),
            (None, Some(keys)) => (keys, "most keys are that far apart"),
            (None, None) => (FALLBACK_HZ, "the file does not tell"),
        };
        Ok(Self { scene, stack, moved, begin, end, rate_hz, why })
    }
}

impl NodeAnimation for Stack<'_> {
    fn name(&self) -> String {
        self.stack.element.name.as_ref().to_owned()
    }

    fn moved(&self) -> &BTreeSet<usize> {
        &self.moved
    }

    fn span(&self, _: &BTreeSet<usize>) -> AnimationSpan {
        let Self { begin, end, rate_hz, why, .. } = *self;
        AnimationSpan { begin, end, rate_hz, finding: format!("{rate_hz} frames a second: {why}.") }
    }

    fn num_layers(&self) -> usize {
        self.stack.layers.len().max(1)
    }

    fn local(&self, node: usize, seconds: f64, _: Transform) -> Transform {
        transform(&ufbx::evaluate_transform(&self.stack.anim, &self.scene.nodes[node], seconds))
    }
}
