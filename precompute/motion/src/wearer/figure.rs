//! A character for drawing: its triangles, and the matrices that move them in a pose.

use super::moved_joints::{MovedJoint, ScaledWearer};
use super::{HELP, Wearer, surface::FigureSurface};
use crate::{error::Result, import::ImportConfig, import::gltf, import::source::content_error};
use glam::{Affine3A, Quat, Vec3, Vec4};
use std::{collections::BTreeSet, path::Path};
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};

/// Weight above which a joint carries a corner.
const LEAST_WEIGHT: f32 = 0.05;

/// The triangles of a character, and the nodes that move them.
pub(super) struct FigureSkin {
    pub surface: FigureSurface,
    /// Nodes of the character, parents first.
    nodes: Vec<FigureNode>,
    /// Index in `nodes` of the node on which each frame of the surface hangs, and the transform to it from the mesh at rest.
    frames: Vec<(usize, Affine3A)>,
}

/// A node of the character.
struct FigureNode {
    /// Index in the document.
    node: usize,
    parent: Option<usize>,
    scale: Vec3,
    rotation: Quat,
    translation: Vec3,
    /// Index of its rotation among the joints that move.
    moved: Option<usize>,
    /// True for the node that carries all that moves.
    is_centre: bool,
}

impl FigureSkin {
    /// Reads the triangles of a character; its joints do not move yet.
    ///
    /// # Errors
    /// The part of the document that is missing or wrong.
    pub fn read(wearer: &Wearer) -> Result<Self, String> {
        let all = wearer.nodes();
        let mut places = vec![None; wearer.document.nodes.len()];
        all.iter().enumerate().for_each(|(at, &n)| places[n] = Some(at));
        let surface = FigureSurface::read(wearer, &places)?;
        let node = |&node: &usize| {
            let local = gltf::local_transform(&wearer.document.nodes[node]);
            FigureNode {
                node,
                parent: None,
                scale: local.scale.as_vec3(),
                rotation: local.rotation.as_quat().normalize(),
                translation: local.translation.as_vec3(),
                moved: None,
                is_centre: false,
            }
        };
        let mut nodes: Vec<FigureNode> = all.iter().map(node).collect();
        for (at, &n) in all.iter().enumerate() {
            for child in wearer.document.nodes[n].children.iter().filter_map(|&c| places[c]) {
                nodes[child].parent = Some(at);
            }
        }
        let frames = surface.frames.iter().map(|(n, inverse)| Some((places[*n]?, Affine3A::from_mat4(*inverse))));
        let frames = frames.collect::<Option<Vec<_>>>().ok_or("a skin hangs on what is no joint")?;
        Ok(Self { surface, nodes, frames })
    }

    /// Says which nodes move.
    ///
    /// - `joints`: nodes of the joints; `centre`: that of the one that carries all that moves.
    pub fn set_moved(&mut self, moved: &[MovedJoint], joints: &[usize], centre: usize) {
        for node in &mut self.nodes {
            node.moved = moved.iter().position(|m| joints[m.joint] == node.node);
            node.is_centre = joints[centre] == node.node;
        }
    }

    /// Nodes that carry corners.
    pub fn carrying_nodes(&self) -> BTreeSet<usize> {
        let corners = self.surface.corners.iter();
        let frames = corners.flat_map(|c| (0..4).filter(|&k| c.weights[k] > LEAST_WEIGHT).map(|k| c.frames[k]));
        frames.map(|f| self.nodes[self.frames[usize::from(f)].0].node).collect()
    }

    /// Name of the node that moves a corner most.
    pub fn carrier_name<'a>(&self, wearer: &'a Wearer, corner: u32) -> &'a str {
        let frame = usize::from(self.surface.corners[corner as usize].frames[0]);
        &wearer.document.nodes[self.nodes[self.frames[frame].0].node].name
    }

    /// The joint that each frame of the surface goes with: its own role, or that of the nearest joint above it that has one.
    pub fn carriers(&self, wearer: &Wearer) -> Vec<Joint> {
        let carrier = |node: usize| {
            let mut up = std::iter::successors(Some(node), |&n| self.nodes[n].parent);
            up.find_map(|n| Some(wearer.moved[self.nodes[n].moved?].carrier())).unwrap_or(Joint::Hips)
        };
        self.frames.iter().map(|(node, _)| carrier(*node)).collect()
    }

    /// The matrices in the pose of the file, in a scale.
    pub fn rest_matrices(&self, scale: f32) -> Vec<Mat3x4> {
        let mut matrices = vec![Mat3x4::default(); self.frames.len()];
        self.place_frames(&self.place_nodes(scale, None), &mut matrices);
        matrices
    }

    /// Frames of the nodes in a pose.
    pub fn pose_nodes(&self, sized: &ScaledWearer<'_>, pose: &[(Vec3, Quat); NUM_JOINTS]) -> Vec<Affine3A> {
        self.place_nodes(sized.scale as f32, Some((&sized.numbers(pose, None), sized.num_moved())))
    }

    /// Index of a node of the document among the nodes.
    pub fn place_of(&self, node: usize) -> Option<usize> {
        self.nodes.iter().position(|n| n.node == node)
    }

    /// The matrices in a pose.
    pub fn pose_matrices(&self, sized: &ScaledWearer<'_>, pose: &[(Vec3, Quat); NUM_JOINTS], out: &mut [Mat3x4]) {
        self.place_frames(&self.pose_nodes(sized, pose), out);
    }

    /// Position of a corner, moved by the matrices of frames.
    pub fn corner(&self, matrices: &[Mat3x4], corner: u32) -> Vec3 {
        let c = &self.surface.corners[corner as usize];
        let at = c.position.extend(1.0);
        let of = |k: usize| {
            let rows = matrices[usize::from(c.frames[k])].rows;
            Vec3::from_array(rows.map(|row| Vec4::from_array(row).dot(at))) * c.weights[k]
        };
        (0..4).filter(|&k| c.weights[k] > 0.0).map(of).sum()
    }

    /// Frames of the nodes.
    ///
    /// - `numbers`: those by which joints move, and the number of these; the pose of the file where absent.
    pub fn place_nodes(&self, scale: f32, numbers: Option<(&[f32], usize)>) -> Vec<Affine3A> {
        let all = Affine3A::from_scale(Vec3::splat(scale));
        let mut placed: Vec<Affine3A> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let (mut rotation, mut translation) = (node.rotation, node.translation);
            if let Some((numbers, num_moved)) = numbers {
                if let Some(m) = node.moved {
                    rotation = Quat::from_slice(&numbers[4 * m..4 * m + 4]);
                }
                if node.is_centre {
                    translation = Vec3::from_slice(&numbers[4 * num_moved..]);
                }
            }
            let local = Affine3A::from_scale_rotation_translation(node.scale, rotation, translation);
            placed.push(node.parent.map_or(all, |p| placed[p]) * local);
        }
        placed
    }

    /// - `placed`: frames of the nodes.
    pub fn place_frames(&self, placed: &[Affine3A], out: &mut [Mat3x4]) {
        for (out, (node, inverse)) in out.iter_mut().zip(&self.frames) {
            let m = placed[*node] * *inverse;
            let row = |i: usize| {
                let [x, y, z] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(|axis| axis[i]);
                [x, y, z, m.translation[i]]
            };
            *out = Mat3x4 { rows: [row(0), row(1), row(2)] };
        }
    }
}

/// A character with its triangles, which wears one pose after another.
pub struct SkinnedFigure {
    wearer: Wearer,
    skin: FigureSkin,
}

impl SkinnedFigure {
    /// Reads a character as [`Wearer::open`] does, and its triangles.
    ///
    /// # Errors
    /// As [`Wearer::open`], and for meshes that cannot be read.
    pub fn open(path: &Path, config: &ImportConfig) -> Result<Self> {
        let mut wearer = Wearer::open(path, config)?;
        let skin = std::mem::replace(&mut wearer.skin, Err(String::new()));
        let skin = skin.map_err(|what| content_error(path, what, HELP))?;
        Ok(Self { wearer, skin })
    }

    /// Its triangles.
    pub fn surface(&self) -> &FigureSurface {
        &self.skin.surface
    }

    /// Number of matrices of a pose.
    pub fn num_frames(&self) -> usize {
        self.skin.frames.len()
    }

    /// The joint that each frame of the surface goes with: its own role, or that of the nearest joint above it that has one.
    pub fn carriers(&self) -> Vec<Joint> {
        self.skin.carriers(&self.wearer)
    }

    /// The character that wears the motion.
    pub fn wearer(&self) -> &Wearer {
        &self.wearer
    }

    /// The matrices of a pose: from the space of the mesh to that of the pose (m), one for each frame of the surface.
    ///
    /// - `own`: skeleton of the pose; `pose`: transforms of its joints.
    /// - `out`: (num_frames); entries beyond stay as they are.
    pub fn pose_matrices(&self, own: &Skeleton, pose: &[(Vec3, Quat); NUM_JOINTS], out: &mut [Mat3x4]) {
        self.skin.pose_matrices(&ScaledWearer::new(&self.wearer, own), pose, out);
    }

    /// Positions of corners in the pose of the file, in the size of the file (m, corners).
    pub fn rest_corners(&self) -> Vec<Vec3> {
        let matrices = self.skin.rest_matrices(self.wearer.metres_per_unit as f32);
        (0..self.skin.surface.corners.len() as u32).map(|c| self.skin.corner(&matrices, c)).collect()
    }
}
