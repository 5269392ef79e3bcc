//! The one builder of surfaces: rings of points, joined to a closed tube.

use super::{BodyMesh, BodySide, Influence, SurfacePart, Vertex};
use glam::Vec3;
use std::{collections::BTreeMap, f32::consts::TAU};

/// A closed curve around a centre: an ellipse, or squarer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ring {
    /// Middle of the ring (m).
    pub centre: Vec3,
    /// First half axis (m).
    pub u: Vec3,
    /// Second half axis (m).
    pub v: Vec3,
    /// Exponents of the superellipse on the `+v` and `-v` halves: 2 is an ellipse, more is squarer.
    pub square: [f32; 2],
}

impl Ring {
    /// An ellipse.
    pub fn ellipse(centre: Vec3, u: Vec3, v: Vec3) -> Self {
        Self { centre, u, v, square: [2.0; 2] }
    }

    fn point(&self, angle: f32) -> Vec3 {
        let (s, c) = angle.sin_cos();
        let exponent = 2.0 / self.square[usize::from(s < 0.0)];
        let bend = |x: f32| x.signum() * x.abs().powf(exponent);
        self.centre + self.u * bend(c) + self.v * bend(s)
    }
}

/// Ratio of a regular polygon's radius to that of a circle of the same area: coarse levels of detail look as stout as
/// fine ones (segments >= 3).
pub(super) fn equal_area(segments: usize) -> f32 {
    let corner = TAU / segments as f32;
    (corner / corner.sin()).sqrt()
}

/// A closed tube through rings, from pole to pole.
pub(super) struct Loft<'a> {
    /// At least one, in order along the tube.
    pub rings: &'a [Ring],
    /// Points of a ring (>= 3).
    pub segments: usize,
    /// Tips before the first and after the last ring (m).
    pub poles: [Vec3; 2],
}

impl Loft<'_> {
    /// Adds the surface to a mesh.
    ///
    /// - `weigh`: joints that move a rest position.
    /// - `part`: part and side of a face, from its middle.
    pub fn build(
        &self,
        mesh: &mut BodyMesh,
        weigh: impl Fn(Vec3) -> Influence,
        part: impl Fn(Vec3) -> (SurfacePart, BodySide),
    ) {
        let points = self.points();
        let faces = self.faces();
        let normals = normals(&points, &faces);
        let mut known: BTreeMap<(usize, SurfacePart, BodySide), u32> = BTreeMap::new();
        for face in faces {
            let middle = face.iter().map(|&i| points[i]).sum::<Vec3>() / face.len() as f32;
            let (part, side) = part(middle);
            let corners: Vec<u32> = face
                .iter()
                .map(|&i| {
                    *known.entry((i, part, side)).or_insert_with(|| {
                        let (joints, weights) = weigh(points[i]).to_bytes();
                        let part = part as u32 + side as u32;
                        let (position, normal) = (points[i].to_array(), normals[i].to_array());
                        mesh.vertices.push(Vertex { position, part, normal, joints, weights });
                        mesh.vertices.len() as u32 - 1
                    })
                })
                .collect();
            mesh.indices.extend(triangles(&corners));
        }
    }

    /// Ring points, then the two poles.
    fn points(&self) -> Vec<Vec3> {
        let around = |s: usize| TAU * (s as f32 + 0.5) / self.segments as f32;
        let ring = |r: &Ring| -> Vec<Vec3> { (0..self.segments).map(|s| r.point(around(s))).collect() };
        self.rings.iter().flat_map(ring).chain(self.poles).collect()
    }

    /// Quads along the tube and triangles around the poles, anticlockwise from outside.
    fn faces(&self) -> Vec<Vec<usize>> {
        let (n, m) = (self.segments, self.rings.len());
        let at = |ring: usize, s: usize| ring * n + s % n;
        let mut faces = Vec::with_capacity(n * (m + 1));
        for s in 0..n {
            faces.push(vec![m * n, at(0, s + 1), at(0, s)]);
            faces.extend((1..m).map(|r| vec![at(r - 1, s), at(r - 1, s + 1), at(r, s + 1), at(r, s)]));
            faces.push(vec![m * n + 1, at(m - 1, s), at(m - 1, s + 1)]);
        }
        let along = self.poles[1] - self.poles[0];
        if self.rings[0].u.cross(self.rings[0].v).dot(along) < 0.0 {
            faces.iter_mut().for_each(|f| f.reverse());
        }
        faces
    }
}

/// One triangle, or two along a diagonal of a quad.
fn triangles(corners: &[u32]) -> Vec<u32> {
    if let [a, b, c, d] = *corners { vec![a, b, c, a, c, d] } else { corners.to_vec() }
}

/// Area-weighted directions of the faces around every point. Unit.
fn normals(points: &[Vec3], faces: &[Vec<usize>]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; points.len()];
    for face in faces {
        let [a, b, c] = [points[face[0]], points[face[1]], points[face[2]]];
        let d = face.get(3).map_or(a, |&i| points[i]);
        let area = (c - a).cross(d - b);
        face.iter().for_each(|&i| normals[i] += area);
    }
    normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect()
}
