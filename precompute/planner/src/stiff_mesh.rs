//! The mesh that a character wears, in rigid pieces: each triangle goes with the joint that carries most of it.

use crate::body::{BodyCapsule, BodyCapsules};
use glam::{DVec3, Mat4, Quat, Vec3};
use std::sync::Arc;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};
use throng_geometry::{MeshError, Segment, TriangleMesh};
use throng_motion::wearer::SkinnedFigure;

/// Share of a piece's corners that a capsule holds across, and the shares between which it lies along.
const THICK: f64 = 0.95;
const ENDS: [f64; 2] = [0.02, 0.98];
/// Least radius of a capsule (m).
const THINNEST_M: f64 = 0.01;

/// A worn mesh, on the skeleton that wears it.
#[derive(Clone, Debug)]
pub struct StiffMesh {
    /// Joints, and the pieces that they carry, in the joints' frames (m).
    pub pieces: Vec<(Joint, Arc<TriangleMesh>)>,
}

impl StiffMesh {
    /// Fits a figure onto a skeleton, and cuts it at its joints.
    ///
    /// Skins that bend are rigid here: a triangle at an elbow goes with the upper arm or with the forearm, and nothing fills
    /// the gap between both where the arm bends.
    ///
    /// # Errors
    /// [`MeshError`]: no triangles, invalid positions of corners.
    pub fn from_figure(figure: &SkinnedFigure, skeleton: &Skeleton) -> Result<Self, MeshError> {
        let rest = skeleton.rest_positions();
        let pose: [(Vec3, Quat); NUM_JOINTS] = std::array::from_fn(|j| (rest[j], Quat::IDENTITY));
        let mut matrices = vec![Mat3x4::default(); figure.num_frames()];
        figure.pose_matrices(skeleton, &pose, &mut matrices);
        let matrices: Vec<Mat4> = matrices.iter().map(Mat3x4::to_mat4).collect();
        let (surface, carriers) = (figure.surface(), figure.carriers());
        let mut pieces: Vec<Vec<[Vec3; 3]>> = vec![Vec::new(); NUM_JOINTS];
        for triangle in surface.indices.chunks_exact(3) {
            let corners = [0, 1, 2].map(|k| &surface.corners[triangle[k] as usize]);
            let mut shares = [0.0f32; NUM_JOINTS];
            let places = corners.map(|c| {
                let carried = (0..4).filter(|k| c.weights[*k] > 0.0).map(|k| (usize::from(c.frames[k]), c.weights[k]));
                carried.fold(Vec3::ZERO, |sum, (frame, weight)| {
                    shares[carriers[frame].index()] += weight;
                    sum + matrices[frame].transform_point3(c.position) * weight
                })
            });
            // The first of equal carriers.
            let most = (0..NUM_JOINTS).rev().max_by(|a, b| shares[*a].total_cmp(&shares[*b])).unwrap_or(0);
            pieces[most].push(places.map(|p| p - rest[most]));
        }
        let pieces = Joint::ALL.into_iter().zip(pieces).filter(|(_, p)| !p.is_empty());
        let pieces =
            pieces.map(|(joint, p)| Ok((joint, Arc::new(TriangleMesh::new(p)?)))).collect::<Result<Vec<_>, _>>()?;
        if pieces.is_empty() { Err(MeshError::Empty) } else { Ok(Self { pieces }) }
    }

    /// Capsules as thick and as long as the pieces are, along the usual ones; those of joints without a piece stay as they are.
    ///
    /// A capsule holds all but the outermost twentieth of a piece's corners across, and fiftieth along: hair and
    /// finger tips stick out.
    pub fn capsules(&self, skeleton: &Skeleton) -> BodyCapsules {
        let mut shape = BodyCapsules::fitted(skeleton);
        for capsule in &mut shape.capsules {
            if let Some((_, mesh)) = self.pieces.iter().find(|(joint, _)| *joint == capsule.joint) {
                *capsule = fit_capsule(capsule, mesh);
            }
        }
        shape
    }
}

/// A capsule around a piece, in the direction of another one.
fn fit_capsule(capsule: &BodyCapsule, mesh: &TriangleMesh) -> BodyCapsule {
    let corners: Vec<DVec3> = mesh.corners().iter().flatten().map(|c| c.as_dvec3()).collect();
    let along = (capsule.core.b - capsule.core.a).try_normalize().unwrap_or(DVec3::Y);
    let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let middle = 0.5 * (low + high);
    let sorted = |of: &dyn Fn(DVec3) -> f64| {
        let mut all: Vec<f64> = corners.iter().map(|c| of(*c - middle)).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let at = |all: &[f64], share: f64| all[((share * all.len() as f64) as usize).min(all.len() - 1)];
    let aside = sorted(&|v| (v - along * v.dot(along)).length());
    let radius = at(&aside, THICK).max(THINNEST_M);
    let ways = sorted(&|v| v.dot(along));
    let [from, to] = ENDS.map(|share| at(&ways, share));
    let (from, to) =
        if to - from > 2.0 * radius { (from + radius, to - radius) } else { (0.5 * (from + to), 0.5 * (from + to)) };
    BodyCapsule { core: Segment::new(middle + along * from, middle + along * to), radius, ..*capsule }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::path::{Path, PathBuf};
    use throng_motion::export::{ActorPose, Glb, TakeWriter};
    use throng_motion::import::ImportConfig;

    /// A file with a plain body, as the exporter writes it.
    pub fn figure_file(folder: &Path, skeleton: &Skeleton) -> PathBuf {
        let mut writer = TakeWriter::new(folder, vec![(0, "one".into(), skeleton.clone())], 30.0).expect("a take");
        let pose = ActorPose { translations: skeleton.offsets, rotations: [Quat::IDENTITY; NUM_JOINTS] };
        (0..2).for_each(|_| writer.push(0, Some(pose)).expect("a frame"));
        let take = writer.into_take().expect("a take");
        let mut bytes = Vec::new();
        Glb::new(&take).expect("a body").write(&mut bytes).expect("bytes");
        let path = folder.join("body.glb");
        std::fs::write(&path, bytes).expect("a file");
        path
    }

    #[test]
    fn pieces_are_where_the_figure_is_and_capsules_hold_them() {
        let folder = tempfile::tempdir().expect("a folder");
        let skeleton = Skeleton::default();
        let path = figure_file(folder.path(), &skeleton);
        let figure = SkinnedFigure::open(&path, &ImportConfig::default()).expect("a figure");
        let worn = StiffMesh::from_figure(&figure, &skeleton).expect("a mesh");
        let all: usize = worn.pieces.iter().map(|(_, mesh)| mesh.corners().len()).sum();
        assert_eq!(all, figure.surface().indices.len() / 3);
        // At rest every corner is one of the figure's, whose soles are laid onto the ground.
        let (rest, corners) = (skeleton.rest_positions(), figure.rest_corners());
        let lowest = |heights: &mut dyn Iterator<Item = f32>| heights.fold(f32::INFINITY, f32::min);
        let worn_heights = worn
            .pieces
            .iter()
            .map(|(joint, mesh)| lowest(&mut mesh.corners().iter().flatten().map(|c| c.y + rest[joint.index()].y)));
        let lift = lowest(&mut worn_heights.into_iter()) - lowest(&mut corners.iter().map(|c| c.y));
        assert!(lift.abs() < 0.01, "{lift}");
        for (joint, mesh) in &worn.pieces {
            for corner in mesh.corners().iter().flatten().step_by(17) {
                let at = *corner + rest[joint.index()] - glam::Vec3::Y * lift;
                let nearest = corners.iter().map(|c| c.distance(at)).fold(f32::INFINITY, f32::min);
                assert!(nearest < 1e-4, "{} {nearest}", joint.name());
            }
        }
        assert!(worn.pieces.len() > 15, "{}", worn.pieces.len());
        let shape = worn.capsules(&skeleton);
        for c in &shape.capsules {
            let Some((_, mesh)) = worn.pieces.iter().find(|(j, _)| *j == c.joint) else { continue };
            let corners: Vec<DVec3> = mesh.corners().iter().flatten().map(|c| c.as_dvec3()).collect();
            let held = corners.iter().filter(|p| Segment::new(**p, **p).distance(&c.core) <= c.radius + 0.015);
            let share = held.count() as f64 / corners.len() as f64;
            assert!(share > 0.8, "{}: {share}", c.joint.name());
        }
    }
}
