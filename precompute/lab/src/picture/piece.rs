//! Pieces of a picture of a world: parts of bodies, bars and flat faces.

use super::{Colour, PictureCamera, solid::RoundCone};
use glam::{Vec2, Vec3};
use throng_bake::environment::{UnitGeometry, UnitSolid};
use throng_core::patch::Placement;
use throng_geometry::{BoundingBox, RayCrossing, SurfaceHit, ray_crossing};

/// Tolerance at the edges of faces, so that neighbours leave no gap.
const EDGE: f32 = 1e-5;

/// A piece of a world.
#[derive(Clone, Copy, Debug)]
pub(super) struct PicturePiece {
    form: PieceShape,
    /// Its colour in full light.
    pub colour: Colour,
}

#[derive(Clone, Copy, Debug)]
enum PieceShape {
    Round(RoundCone),
    Face([Vec3; 3]),
}

impl PicturePiece {
    /// A limb or a bar.
    pub fn round(solid: RoundCone, colour: Colour) -> Self {
        Self { form: PieceShape::Round(solid), colour }
    }

    /// A triangle, seen from both sides.
    pub fn face(corners: [Vec3; 3], colour: Colour) -> Self {
        Self { form: PieceShape::Face(corners), colour }
    }

    /// Bounding box in the world.
    pub fn bounds(&self) -> BoundingBox {
        match &self.form {
            PieceShape::Round(solid) => {
                let (a, b, reach) = solid.bounds();
                BoundingBox::around_points([a, b]).expanded(reach)
            }
            PieceShape::Face(corners) => BoundingBox::around_points(*corners),
        }
    }

    /// Bounding box in the picture (px).
    pub fn screen_box(&self, camera: &PictureCamera) -> (Vec2, Vec2) {
        match &self.form {
            PieceShape::Round(solid) => {
                let (a, b, reach) = solid.bounds();
                let (a, b) = (camera.project(a), camera.project(b));
                let r = Vec2::splat(reach * camera.px_per_m + 1.0);
                (a.min(b) - r, a.max(b) + r)
            }
            PieceShape::Face(corners) => {
                let [a, b, c] = corners.map(|p| camera.project(p));
                (a.min(b).min(c) - 1.0, a.max(b).max(c) + 1.0)
            }
        }
    }

    /// First hit of the line of sight through a point of the picture: depth, and normal of the surface.
    pub fn intersect(&self, camera: &PictureCamera, screen: Vec2) -> Option<SurfaceHit> {
        // Rays begin near the piece: far ones would lose the digits that round cones need.
        let through = camera.unproject(screen);
        match &self.form {
            PieceShape::Round(solid) => {
                let (a, b, reach) = solid.bounds();
                let start = camera.depth(a).min(camera.depth(b)) - 2.0 * reach - 1.0;
                let hit = solid.intersect(through + camera.forward * start, camera.forward)?;
                Some(SurfaceHit { distance: hit.distance + start, ..hit })
            }
            PieceShape::Face(corners) => intersect_face(corners, through, camera.forward),
        }
    }
}

/// Distance along a line to a triangle, and the normal that faces against the line's direction.
fn intersect_face(corners: &[Vec3; 3], origin: Vec3, direction: Vec3) -> Option<SurfaceHit> {
    let RayCrossing { det, u, v, t: distance } = ray_crossing(origin, direction, corners);
    if det.abs() < 1e-12 || u < -EDGE || v < -EDGE || u + v > 1.0 + EDGE {
        return None;
    }
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    Some(SurfaceHit { distance, normal: if normal.dot(direction) > 0.0 { -normal } else { normal } })
}

/// Adds the pieces of a placed unit.
pub(super) fn add_unit(unit: &UnitGeometry, at: Placement, colour: Colour, out: &mut Vec<PicturePiece>) {
    unit.solids.iter().for_each(|solid| add_solid(solid, |p| at.transform_point(p), colour, out));
}

/// Adds the pieces of a solid; `at` transforms its points to the world.
pub(super) fn add_solid(solid: &UnitSolid, at: impl Fn(Vec3) -> Vec3, colour: Colour, out: &mut Vec<PicturePiece>) {
    match solid {
        UnitSolid::Box { centre, rotation, half } => {
            let corners = BoundingBox { min: -*half, max: *half }.corners();
            add_box(&corners.map(|c| at(*centre + *rotation * c)), colour, out);
        }
        UnitSolid::Bar { from, to, radius } => {
            out.push(PicturePiece::round(RoundCone::limb(at(*from), at(*to), *radius, *radius), colour));
        }
        UnitSolid::Mesh(triangles) => {
            out.extend(triangles.corners().iter().map(|t| PicturePiece::face(t.map(&at), colour)));
        }
    }
}

/// Adds two triangles for each side of a box; corners as of [`BoundingBox::corners`].
fn add_box(corners: &[Vec3; 8], colour: Colour, out: &mut Vec<PicturePiece>) {
    const SIDES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];
    for s in SIDES {
        let [a, b, c, d] = s.map(|i| corners[i]);
        out.extend([[a, b, c], [a, c, d]].map(|corners| PicturePiece::face(corners, colour)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;
    use throng_bake::environment::UnitSet;

    #[test]
    fn a_box_is_seen_where_its_distance_says_it_is() {
        let text = "[[units]]\nname = \"a\"\nshapes = [{ box = { at = [0.3, 0.5, 0.0], size = [1.0, 0.6, 2.0], \
                    heading_deg = 20.0, pitch_deg = 25.0 } }, { bar = { from = [0.0, 1.0, 0.0], to = [1.0, 2.0, 0.0], \
                    radius = 0.1 } }]\n";
        let unit = UnitGeometry::new(&UnitSet::parse(text, Path::new("u.toml")).unwrap().units[0]).unwrap();
        let at = Placement::new(3.0, 0.5, -2.0, 0.7);
        let mut pieces = Vec::new();
        add_unit(&unit, at, Colour::hex(0), &mut pieces);
        assert_eq!(pieces.len(), 13);
        let camera = PictureCamera::looking_along(0.4, 0.5).framed(Vec3::new(3.0, 1.0, -2.0), Vec2::splat(50.0), 25.0);
        let (mut hits, mut misses) = (0, 0);
        for i in 0..60 {
            for j in 0..60 {
                let screen = Vec2::new(20.0 + i as f32, 20.0 + j as f32);
                let ray = |t: f32| at.inverse_transform_point(camera.unproject(screen) + camera.forward * t);
                let seen = pieces.iter().filter_map(|p| p.intersect(&camera, screen)).map(|h| h.distance);
                match seen.reduce(f32::min) {
                    Some(t) => {
                        hits += 1;
                        assert!(unit.distance(ray(t)).abs() < 1e-3, "{screen}");
                        assert!(unit.distance(ray(t - 0.01)) > 0.0);
                    }
                    None => {
                        misses += 1;
                        assert!((-60..60).all(|k| unit.distance(ray(0.05 * k as f32)) > -1e-3), "{screen}");
                    }
                }
            }
        }
        assert!(hits > 300 && misses > 300, "{hits} {misses}");
        for p in &pieces {
            let (a, b) = p.screen_box(&camera);
            let corners = p.bounds().corners().map(|c| camera.project(c));
            assert!(a.cmple(b).all() && corners.iter().any(|c| c.cmpge(a - 30.0).all() && c.cmple(b + 30.0).all()));
        }
    }
}
