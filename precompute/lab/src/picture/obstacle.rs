//! Solids of the obstacles of a crowd.

use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;
use throng_bake::environment::UnitSolid;
use throng_crowd::Obstacle;
use throng_geometry::TriangleMesh;

/// Solid of a static obstacle that stands on the ground, with a height (m); none for obstacles that move.
pub fn obstacle_solid(obstacle: &Obstacle, height: f32) -> Option<UnitSolid> {
    let up = 0.5 * height * Vec3::Y;
    Some(match obstacle {
        // Square ends reach as far as the round ends of its capsule.
        Obstacle::Wall { from, to, radius } => {
            let offset = *to - *from;
            let half = Vec3::new(*radius, 0.5 * height, 0.5 * offset.length() + radius);
            let rotation = Quat::from_rotation_y(offset.x.atan2(offset.z));
            UnitSolid::Box { centre: 0.5 * (*from + *to) + up, rotation, half }
        }
        Obstacle::Box { min: low, max: high } => {
            let half = (0.5 * (*high - *low)).with_y(0.5 * height);
            UnitSolid::Box { centre: 0.5 * (*low + high.with_y(low.y)) + up, rotation: Quat::IDENTITY, half }
        }
        Obstacle::Polygon { corners } => prism(corners, height)?,
        Obstacle::Ball { centre, radius } => prism(&circle(*centre, *radius), height)?,
        _ => return None,
    })
}

/// Prism on a polygon.
fn prism(corners: &[Vec3], height: f32) -> Option<UnitSolid> {
    let up = height * Vec3::Y;
    let next = corners.iter().cycle().skip(1);
    let sides = corners.iter().zip(next).flat_map(|(&a, &b)| [[a, b, b + up], [a, b + up, a + up]]);
    let flat: Vec<Vec2> = corners.iter().map(|c| Vec2::new(c.x, c.z)).collect();
    let top = triangulate(&flat).into_iter().map(|t| t.map(|i| corners[i] + up));
    TriangleMesh::new(sides.chain(top).collect()).ok().map(UnitSolid::Mesh)
}

/// Points of a circle on the ground.
fn circle(centre: Vec3, radius: f32) -> Vec<Vec3> {
    let at = |i: u8| Vec2::from_angle(TAU * f32::from(i) / 40.0) * radius;
    (0..40).map(|i| centre + Vec3::new(at(i).x, 0.0, at(i).y)).collect()
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
