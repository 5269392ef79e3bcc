//! Appearance of bodies: meshes, and the materials that they are given.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, MeshVertexAttribute, VertexAttributeValues, VertexFormat};
use bevy::prelude::*;
use bevy::render::render_resource::PrimitiveTopology;
use throng_runtime::characters::{MotionSet, SampleJob};
use throng_runtime::{Bundle, Mat3x4, NUM_JOINTS, PlainBody};

/// Joints of a vertex of a far body. Bevy's own attribute would make it a skinned mesh.
pub const FAR_JOINTS: MeshVertexAttribute =
    MeshVertexAttribute::new("ThrongJoints", 0x7468_726f, VertexFormat::Uint16x4);
/// Their weights.
pub const FAR_WEIGHTS: MeshVertexAttribute =
    MeshVertexAttribute::new("ThrongWeights", 0x7468_7270, VertexFormat::Float32x4);

/// How a [`crate::Crowd`] looks where Bevy draws it; read when its bundle is opened or changes.
#[derive(Component, Clone, Debug)]
pub struct CrowdAppearance {
    /// Body of those who are near, skinned to joints in the order of [`throng_runtime::Joint::ALL`], in the bundle's rest
    /// pose: a T-pose that faces +Z, joints not turned. None for a plain one of capsules.
    pub near: Option<Mesh>,
    /// Body of those who are far, likewise; none for `near`, or a plain one.
    pub far: Option<Mesh>,
    /// Given to characters in turn (not empty).
    pub materials: Vec<StandardMaterial>,
}

impl Default for CrowdAppearance {
    fn default() -> Self {
        let colours =
            [[0.62, 0.28, 0.22], [0.25, 0.40, 0.58], [0.75, 0.62, 0.33], [0.33, 0.48, 0.36], [0.50, 0.37, 0.55]];
        let material = |[r, g, b]: [f32; 3]| StandardMaterial {
            base_color: Color::srgb(r, g, b),
            perceptual_roughness: 0.9,
            ..default()
        };
        Self { near: None, far: None, materials: colours.map(material).into() }
    }
}

impl CrowdAppearance {
    /// Bodies of those who are near and far.
    pub fn meshes(&self, bundle: &Bundle) -> Result<(Mesh, Mesh), String> {
        let near = self.near.clone().unwrap_or_else(|| plain(&PlainBody::fine(bundle.skeleton())));
        let far = self.far.as_ref().or(self.near.as_ref());
        let far = far.cloned().unwrap_or_else(|| plain(&PlainBody::coarse(bundle.skeleton())));
        Ok((check(near)?, from_records(check(far)?)?))
    }
}

fn plain(body: &PlainBody) -> Mesh {
    let floats = |all: &[throng_runtime::glam::Vec3]| all.iter().map(|p| p.to_array()).collect::<Vec<_>>();
    let joints = body.joints.iter().map(|j| [u16::from(*j), 0, 0, 0]).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, floats(&body.positions))
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, floats(&body.normals))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints))
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0.0, 0.0, 0.0]; body.joints.len()])
        .with_inserted_indices(Indices::U16(body.triangles.as_flattened().to_vec()))
}

/// Every vertex is carried by joints that there are.
fn check(mesh: Mesh) -> Result<Mesh, String> {
    let why = "a CrowdAppearance's mesh is skinned";
    let Some(VertexAttributeValues::Uint16x4(joints)) = mesh.attribute(Mesh::ATTRIBUTE_JOINT_INDEX) else {
        return Err(format!("{why}: expected the attribute Mesh::ATTRIBUTE_JOINT_INDEX (Uint16x4)"));
    };
    if !matches!(mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT), Some(VertexAttributeValues::Float32x4(_))) {
        return Err(format!("{why}: expected the attribute Mesh::ATTRIBUTE_JOINT_WEIGHT (Float32x4)"));
    }
    match joints.as_flattened().iter().max() {
        Some(&most) if usize::from(most) >= NUM_JOINTS => {
            Err(format!("{why} to joint {most}, expected 0 to {}, in the order of Joint::ALL", NUM_JOINTS - 1))
        }
        _ => Ok(mesh),
    }
}

fn from_records(mut mesh: Mesh) -> Result<Mesh, String> {
    for (bevy, ours) in [(Mesh::ATTRIBUTE_JOINT_INDEX, FAR_JOINTS), (Mesh::ATTRIBUTE_JOINT_WEIGHT, FAR_WEIGHTS)] {
        let values = mesh.remove_attribute(bevy.id).ok_or("checked before")?;
        mesh.insert_attribute(ours, values);
    }
    Ok(mesh)
}

/// From a body at rest to its pose in every frame row: three rows of a matrix a joint, 1056 bytes a frame row.
pub fn rows(bundle: &Bundle) -> throng_runtime::Result<Vec<u8>> {
    let motion_set = &MotionSet::new(bundle);
    let frames: Vec<u32> = (0..bundle.frames().len() as u32).collect();
    let mut matrices = vec![Mat3x4::default(); frames.len() * NUM_JOINTS];
    SampleJob { motion_set, ratios: &vec![0.0; frames.len()], frames: &frames, matrices: &mut matrices }.run()?;
    let rest = bundle.skeleton().rest_positions();
    for pose in matrices.as_chunks_mut::<NUM_JOINTS>().0 {
        for (matrix, rest) in pose.iter_mut().zip(rest) {
            for row in &mut matrix.rows {
                row[3] -= row[0] * rest.x + row[1] * rest.y + row[2] * rest.z;
            }
        }
    }
    Ok(bytemuck::cast_slice(&matrices).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_that_joints_do_not_carry_are_refused() {
        let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/golden/tables_v");
        let path = format!("{golden}{}.throng", throng_runtime::format::VERSION);
        let bundle = Bundle::open(path).expect("the golden bundle");
        let cube = Mesh::from(Cuboid::default());
        let look = CrowdAppearance { near: Some(cube.clone()), ..default() };
        assert!(look.meshes(&bundle).is_err_and(|why| why.contains("ATTRIBUTE_JOINT_INDEX")));
        let joints = VertexAttributeValues::Uint16x4(vec![[22, 0, 0, 0]; cube.count_vertices()]);
        let weights = vec![[1.0_f32, 0.0, 0.0, 0.0]; cube.count_vertices()];
        let cube = cube.with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
        let look = CrowdAppearance {
            far: Some(cube.with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights)),
            ..default()
        };
        assert!(look.meshes(&bundle).is_err_and(|why| why.contains("joint 22")));
        let (near, far) = CrowdAppearance::default().meshes(&bundle).expect("plain bodies");
        assert!(near.contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX) && far.contains_attribute(FAR_JOINTS));
        assert!(!far.contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX));
    }
}
