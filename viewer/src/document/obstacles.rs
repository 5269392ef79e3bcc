//! Meshes of the obstacles of a crowd.

use crate::render::SolidMesh;
use throng_crowd::Obstacle;
use throng_precompute::picture::obstacle_solid;

/// Height of doors (m).
pub const DOOR_M: f32 = 0.35;
/// Radius of walls without thickness (m).
const THIN_M: f32 = 0.04;

/// One mesh of all static obstacles; each obstacle comes with its height (m).
///
/// Boxes in the air may surround all agents: only their edges are drawn. Moving obstacles are drawn each frame.
pub fn mesh_of<'a>(obstacles: impl IntoIterator<Item = (&'a Obstacle, f32)>, in_the_air: bool) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    for (obstacle, height) in obstacles {
        match obstacle {
            Obstacle::Ball { centre, radius } if in_the_air => mesh.add_bar(*centre, *centre, *radius),
            Obstacle::Wall { from, to, radius } if in_the_air => mesh.add_bar(*from, *to, radius.max(THIN_M)),
            Obstacle::Box { .. } if in_the_air => {}
            &Obstacle::Wall { from, to, radius } => {
                let wall = Obstacle::Wall { from, to, radius: radius.max(THIN_M) };
                obstacle_solid(&wall, height).iter().for_each(|solid| mesh.add_solid(solid));
            }
            other => obstacle_solid(other, height).iter().for_each(|solid| mesh.add_solid(solid)),
        }
    }
    mesh
}
