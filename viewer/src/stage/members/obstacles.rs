//! What stands or moves in a crowd's way.

use super::Brush;
use crate::document::CrowdDocument;
use crate::render::{Rgba, Shapes, SolidInstance, SolidMesh};
use crate::run::members::Cast;
use crate::stage::Layout;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;
use throng_precompute::scene::crowd::SeenObstacle;
use throng_runtime::patch::Placement;

/// Height of what stands on the ground, which has none of its own. [Unit: m]
const HEIGHT_M: f32 = 0.35;
/// Half the thickness of walls without any. [Unit: m]
const THIN_M: f32 = 0.04;
/// Corners of a round.
const AROUND: usize = 40;

/// Meshes of all that stands: one of what hides what is behind it.
pub fn meshes(cast: &Cast) -> Arc<[SolidMesh]> {
    let mut mesh = SolidMesh::default();
    for obstacle in &cast.obstacles {
        match obstacle {
            SeenObstacle::Ball { centre, radius } if cast.in_the_air => mesh.add_bar(*centre, *centre, *radius),
            SeenObstacle::Ball { centre, radius } => prism(&mut mesh, &round(*centre, *radius)),
            SeenObstacle::Wall { from, to, radius } if cast.in_the_air => {
                mesh.add_bar(*from, *to, radius.max(THIN_M));
            }
            SeenObstacle::Wall { from, to, radius } => wall(&mut mesh, *from, *to, radius.max(THIN_M)),
            SeenObstacle::Polygon(corners) => prism(&mut mesh, corners),
            SeenObstacle::Box(low, high) if !cast.in_the_air => {
                let top = Vec3::new(high.x, low.y + HEIGHT_M, high.z);
                mesh.add_box(0.5 * (*low + top), Quat::IDENTITY, 0.5 * (top - *low));
            }
            // Boxes in the air may be around everybody: their edges are drawn. What moves is drawn where it is.
            _ => {}
        }
    }
    Arc::from([mesh])
}

fn round(centre: Vec3, radius: f32) -> Vec<Vec3> {
    let corner = |i: usize| {
        let (s, c) = (TAU * i as f32 / AROUND as f32).sin_cos();
        centre + Vec3::new(c, 0.0, s) * radius
    };
    (0..AROUND).map(corner).collect()
}

/// A wall along a line, with square ends that reach as far as its round ones.
fn wall(mesh: &mut SolidMesh, from: Vec3, to: Vec3, radius: f32) {
    let along = to - from;
    let turn = Quat::from_rotation_y(along.x.atan2(along.z));
    let half = Vec3::new(radius, 0.5 * HEIGHT_M, 0.5 * along.length() + radius);
    mesh.add_box(0.5 * (from + to) + Vec3::Y * half.y, turn, half);
}

/// What stands on a polygon.
fn prism(mesh: &mut SolidMesh, corners: &[Vec3]) {
    let up = Vec3::Y * HEIGHT_M;
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        mesh.add_triangle([a, b, b + up]);
        mesh.add_triangle([a, b + up, a + up]);
    }
    let flat: Vec<Vec2> = corners.iter().map(|c| Vec2::new(c.x, c.z)).collect();
    for [a, b, c] in ears(&flat) {
        mesh.add_triangle([a, b, c].map(|i| corners[i] + up));
    }
}

/// Triangles of a simple polygon, ear by ear.
fn ears(corners: &[Vec2]) -> Vec<[usize; 3]> {
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
        // A polygon that crosses itself has none: something is cut off all the same.
        let i = (0..n).find(is_ear).unwrap_or(0);
        out.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    if let [a, b, c] = left[..] {
        out.push([a, b, c]);
    }
    out
}

pub(super) fn lay_out(out: &mut Layout, crowd: &CrowdDocument, time_s: f64, brush: &Brush<'_>) {
    out.solids.meshes = Arc::clone(crowd.meshes());
    let colour = Rgba::hex(if brush.dark { 0x77808d } else { 0x9aa1ab });
    let placement = Placement::new(0.0, 0.0, 0.0, 0.0);
    out.solids.instances.push(SolidInstance { mesh: 0, placement, colour });
    for obstacle in &brush.cast.obstacles {
        match obstacle {
            SeenObstacle::Box(low, high) if brush.cast.in_the_air => edges(&mut out.shapes, *low, *high, colour),
            SeenObstacle::Mover { way, radius } => mover(&mut out.shapes, brush, way, *radius, time_s),
            _ => {}
        }
    }
}

fn edges(shapes: &mut Shapes, low: Vec3, high: Vec3, colour: Rgba) {
    let corner = |i: usize| {
        let pick = |axis: usize, bit: usize| if i & bit == 0 { low[axis] } else { high[axis] };
        Vec3::new(pick(0, 1), pick(1, 2), pick(2, 4))
    };
    for i in 0..8usize {
        for bit in [1, 2, 4].into_iter().filter(|bit| i & bit == 0) {
            shapes.line(corner(i), corner(i | bit), 1.0, colour.alpha(0.7));
        }
    }
}

/// What moves, where it is now, and the way that it takes.
fn mover(shapes: &mut Shapes, brush: &Brush<'_>, way: &[(f64, Vec3)], radius: f32, time_s: f64) {
    let at = place(way, time_s);
    let lift = Vec3::Y * if brush.cast.in_the_air { 0.0 } else { super::DISC_Y };
    let points: Vec<Vec3> = way.iter().map(|w| w.1 + lift).collect();
    shapes.polyline(&points, 1.5, brush.palette.target.alpha(0.5));
    if brush.cast.in_the_air {
        shapes.sphere(at, radius, brush.palette.target);
    } else {
        shapes.disc(at + lift, radius, brush.palette.target);
    }
}

/// Where something is on its way. [Unit: s, m]
fn place(way: &[(f64, Vec3)], time_s: f64) -> Vec3 {
    let next = way.partition_point(|w| w.0 <= time_s);
    match (next.checked_sub(1).map(|i| way[i]), way.get(next)) {
        (Some((from_s, from)), Some(&(to_s, to))) => from.lerp(to, ((time_s - from_s) / (to_s - from_s)) as f32),
        (Some((_, last)), None) => last,
        (None, first) => first.map_or(Vec3::ZERO, |f| f.1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ears_fill_a_polygon_with_a_notch_whichever_way_it_turns() {
        let mut corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]].map(Vec2::from_array);
        for _ in 0..2 {
            let all = ears(&corners);
            let area = |[a, b, c]: [usize; 3]| 0.5 * (corners[b] - corners[a]).perp_dot(corners[c] - corners[a]);
            assert_eq!(all.len(), 3);
            assert!(all.iter().all(|&t| area(t) > 0.0), "{all:?}");
            assert!((all.iter().map(|&t| area(t)).sum::<f32>() - 10.0).abs() < 1e-4);
            corners.reverse();
        }
    }

    #[test]
    fn what_moves_waits_at_both_ends_of_its_way() {
        let way = [(1.0, Vec3::ZERO), (3.0, Vec3::X), (4.0, Vec3::Z)];
        for (time_s, at) in [(0.0, Vec3::ZERO), (2.0, Vec3::X * 0.5), (3.5, (Vec3::X + Vec3::Z) * 0.5), (9.0, Vec3::Z)]
        {
            assert!(place(&way, time_s).distance(at) < 1e-6, "{time_s}");
        }
    }
}
