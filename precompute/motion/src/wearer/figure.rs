//! A character for drawing: its triangles, and the matrices that move them in a pose.

use super::moved_joints::ScaledWearer;
use super::surface::FigureSurface;
use super::{HELP, Wearer};
use crate::error::Result;
use crate::import::ImportConfig;
use crate::import::gltf;
use crate::import::source::content_error;
use glam::{Affine3A, Quat, Vec3};
use std::path::Path;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};

/// A character with its triangles, which wears one pose after another.
pub struct SkinnedFigure {
    wearer: Wearer,
    surface: FigureSurface,
    /// Nodes of the character, parents first.
    nodes: Vec<FigureNode>,
    /// Index in `nodes` of the node on which each frame of the surface hangs, and the transform to it from the mesh at rest.
    frames: Vec<(usize, Affine3A)>,
}

/// A node of the character.
struct FigureNode {
    parent: Option<usize>,
    scale: Vec3,
    rotation: Quat,
    translation: Vec3,
    /// Index of its rotation among the joints that move.
    moved: Option<usize>,
    /// True for the node that carries all that moves.
    is_centre: bool,
}

impl SkinnedFigure {
    /// Reads a character as [`Wearer::open`] does, and its triangles.
    ///
    /// # Errors
    /// As [`Wearer::open`], and for meshes that cannot be read.
    pub fn open(path: &Path, config: &ImportConfig) -> Result<Self> {
        let wearer = Wearer::open(path, config)?;
        let all = wearer.nodes();
        let mut places = vec![None; wearer.document.nodes.len()];
        all.iter().enumerate().for_each(|(at, &n)| places[n] = Some(at));
        let surface = FigureSurface::read(&wearer, &places).map_err(|what| content_error(path, what, HELP))?;
        let node = |&n: &usize| {
            let local = gltf::local_transform(&wearer.document.nodes[n]);
            FigureNode {
                parent: None,
                scale: local.scale.as_vec3(),
                rotation: local.rotation.as_quat().normalize(),
                translation: local.translation.as_vec3(),
                moved: None,
                is_centre: wearer.rig.joints[wearer.centre] == n,
            }
        };
        let mut nodes: Vec<FigureNode> = all.iter().map(node).collect();
        for (at, &n) in all.iter().enumerate() {
            for child in wearer.document.nodes[n].children.iter().filter_map(|&c| places[c]) {
                nodes[child].parent = Some(at);
            }
        }
        for (m, moved) in wearer.moved.iter().enumerate() {
            if let Some(at) = places[wearer.rig.joints[moved.joint]] {
                nodes[at].moved = Some(m);
            }
        }
        let frames = surface.frames.iter().map(|(n, inverse)| Some((places[*n]?, Affine3A::from_mat4(*inverse))));
        let frames = frames.collect::<Option<Vec<_>>>();
        let frames = frames.ok_or_else(|| content_error(path, "a skin hangs on what is no joint", HELP))?;
        Ok(Self { wearer, surface, nodes, frames })
    }

    /// Its triangles.
    pub fn surface(&self) -> &FigureSurface {
        &self.surface
    }

    /// Number of matrices of a pose.
    pub fn num_frames(&self) -> usize {
        self.frames.len()
    }

    /// The joint that each frame of the surface goes with: its own role, or that of the nearest joint above it that has one.
    pub fn carriers(&self) -> Vec<Joint> {
        let carrier = |node: usize| {
            let mut up = std::iter::successors(Some(node), |&n| self.nodes[n].parent);
            up.find_map(|n| Some(self.wearer.moved[self.nodes[n].moved?].carrier())).unwrap_or(Joint::Hips)
        };
        self.frames.iter().map(|(node, _)| carrier(*node)).collect()
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
        let sized = ScaledWearer::new(&self.wearer, own);
        let numbers = sized.numbers(pose, None);
        self.place_frames(sized.scale as f32, Some(&numbers), out);
    }

    /// Positions of corners in the pose of the file, in the size of the file (m, corners).
    pub fn rest_corners(&self) -> Vec<Vec3> {
        let mut matrices = vec![Mat3x4::default(); self.frames.len()];
        self.place_frames(self.wearer.metres_per_unit as f32, None, &mut matrices);
        let matrices: Vec<_> = matrices.iter().map(Mat3x4::to_mat4).collect();
        let at = |c: &super::SurfaceCorner| {
            let of = |k: usize| matrices[usize::from(c.frames[k])].transform_point3(c.position) * c.weights[k];
            (0..4).filter(|&k| c.weights[k] > 0.0).map(of).sum()
        };
        self.surface.corners.iter().map(at).collect()
    }

    fn place_frames(&self, scale: f32, numbers: Option<&[f32]>, out: &mut [Mat3x4]) {
        let all = Affine3A::from_scale(Vec3::splat(scale));
        let mut placed: Vec<Affine3A> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let (mut rotation, mut translation) = (node.rotation, node.translation);
            if let Some(numbers) = numbers {
                if let Some(m) = node.moved {
                    rotation = Quat::from_slice(&numbers[4 * m..4 * m + 4]);
                }
                if node.is_centre {
                    translation = Vec3::from_slice(&numbers[4 * self.wearer.moved.len()..]);
                }
            }
            let local = Affine3A::from_scale_rotation_translation(node.scale, rotation, translation);
            placed.push(node.parent.map_or(all, |p| placed[p]) * local);
        }
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
