//! Meshes of the obstacles of a crowd.

use crate::render::SolidMesh;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;
use throng_crowd::Obstacle;

/// Height of doors (m).
pub const DOOR_M: f32 = 0.35;
/// Radius of walls without thickness (m).
const THIN_M: f32 = 0.04;
/// Corners of a round.
const AROUND: usize = 40;

/// One mesh of all static obstacles; each obstacle comes with its height (m).
pub fn mesh_of<'a>(obstacles: impl IntoIterator<Item = (&'a Obstacle, f32)>, in_the_air: bool) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    for (obstacle, height) in obstacles {
        match obstacle {
            Obstacle::Ball { centre, radius } if in_the_air => mesh.add_bar(*centre, *centre, *radius),
            Obstacle::Ball { centre, radius } => prism(&mut mesh, &round(*centre, *radius), height),
            Obstacle::Wall { from, to, radius } if in_the_air => mesh.add_bar(*from, *to, radius.max(THIN_M)),
            Obstacle::Wall { from, to, radius } => wall(&mut mesh, [*from, *to], radius.max(THIN_M), height),
            Obstacle::Polygon { corners } => prism(&mut mesh, corners, height),
            Obstacle::Box { min: low, max: high } if !in_the_air => {
                let top = Vec3::new(high.x, low.y + height, high.z);
                mesh.add_box(0.5 * (*low + top), Quat::IDENTITY, 0.5 * (top - *low));
            }
            // Boxes in the air may surround all agents: only their edges are drawn. Moving obstacles are drawn each
            // frame.
            _ => {}
        }
    }
    mesh
}

fn round(centre: Vec3, radius: f32) -> Vec<Vec3> {
    let corner = |i: usize| {
        let (s, c) = (TAU * i as f32 / AROUND as f32).sin_cos();
        centre + Vec3::new(c, 0.0, s) * radius
    };
    (0..AROUND).map(corner).collect()
}

/// A wall along a line, with square ends that reach as far as the round ends of its capsule.
fn wall(mesh: &mut SolidMesh, [from, to]: [Vec3; 2], radius: f32, height: f32) {
    let along = to - from;
    let turn = Quat::from_rotation_y(along.x.atan2(along.z));
    let half = Vec3::new(radius, 0.5 * height, 0.5 * along.length() + radius);
    mesh.add_box(0.5 * (from + to) + Vec3::Y * half.y, turn, half);
}

/// Adds a prism on a polygon.
fn prism(mesh: &mut SolidMesh, corners: &[Vec3], height: f32) {
    let up = Vec3::Y * height;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        mesh.add_triangle([a, b, b + up]);
        mesh.add_triangle([a, b + up, a + up]);
    }
    let flat: Vec<Vec2> = corners.iter().map(|c| Vec2::new(c.x, c.z)).collect();
    for [a, b, c] in triangulate(&flat) {
        mesh.add_triangle([a, b, c].map(|i| corners[i] + up));
    }
}

/// Triangles of a simple polygon, ear by ear.
fn triangulate(corners: &[Vec2]) -> Vec<[usize; 3]> {
    let area: f32 = (0..corners.len()).map(|i| corners[i].perp_dot(corners[(i + 1) % corners.len()])).sum();
    let mut left: Vec<usize> = (0..corners.len()).collect();
    if area < 0.0 {
        left.reverse();
    }
    let mut out = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let is_ear = |i: &usize| {
            let [a, b, c] = [left[(i + n - 1) % n], left[*i], left[(i + 1) % n]];
            let side = |p: usize, q: usize, r: usize| (corners[q] - corners[p]).perp_dot(corners[r] - corners[p]);
            let holds = |&k: &usize| side(a, b, k) > 0.0 && side(b, c, k) > 0.0 && side(c, a, k) > 0.0;
            side(a, b, c) > 0.0 && !left.iter().any(|k| ![a, b, c].contains(k) && holds(k))
        };
        // A polygon that crosses itself may have no ear: the first corner is cut off then.
        let i = (0..n).find(is_ear).unwrap_or(0);
        out.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    if let [a, b, c] = left[..] {
        out.push([a, b, c]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ears_fill_a_polygon_with_a_notch_whichever_way_it_turns() {
        let mut corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]].map(Vec2::from_array);
        for _ in 0..2 {
            let all = triangulate(&corners);
            let area = |[a, b, c]: [usize; 3]| 0.5 * (corners[b] - corners[a]).perp_dot(corners[c] - corners[a]);
            assert_eq!(all.len(), 3);
            assert!(all.iter().all(|&t| area(t) > 0.0), "{all:?}");
            assert!((all.iter().map(|&t| area(t)).sum::<f32>() - 10.0).abs() < 1e-4);
            corners.reverse();
        }
    }
}
