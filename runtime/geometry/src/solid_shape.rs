//! Shapes, and their distances to segments.

use crate::{cuboid::segment_cuboid, segment::Segment, triangle_mesh::TriangleMesh};
use glam::DVec3;
use std::sync::Arc;

/// A shape in its own frame.
#[derive(Clone, Debug)]
pub enum SolidShape {
    /// A ball or a capsule: all points within a radius of a segment.
    Round {
        /// From end to end (m).
        core: Segment,
        /// (m, > 0)
        radius: f64,
    },
    /// A box around the origin.
    Cuboid {
        /// Half size (m, > 0).
        half: DVec3,
    },
    /// A surface of triangles, without an inside.
    Mesh(Arc<TriangleMesh>),
}

impl SolidShape {
    /// A ball around the origin (m).
    pub const fn ball(radius: f64) -> Self {
        Self::Round { core: Segment { a: DVec3::ZERO, b: DVec3::ZERO }, radius }
    }

    /// A box around the origin.
    ///
    /// - `size`: (m)
    pub fn cuboid(size: DVec3) -> Self {
        Self::Cuboid { half: 0.5 * size }
    }

    /// Distance to a segment, where it is below `limit`, else infinite; negative within a ball, 0 within a box (m).
    #[inline]
    pub fn distance(&self, s: &Segment, limit: f64) -> f64 {
        let d = match self {
            Self::Round { core, radius } => s.distance(core) - radius,
            Self::Cuboid { half } => segment_cuboid(s, *half),
            Self::Mesh(mesh) => return mesh.distance(s, limit),
        };
        if d < limit { d } else { f64::INFINITY }
    }

    /// True where a segment is nearer than `limit` (m).
    #[inline]
    pub fn is_nearer(&self, s: &Segment, limit: f64) -> bool {
        if let Self::Mesh(mesh) = self { mesh.is_nearer(s, limit) } else { self.distance(s, limit) < limit }
    }

    /// Middle and radius of a bounding ball (m).
    pub fn ball_around(&self) -> (DVec3, f64) {
        match self {
            Self::Round { core, radius } => (core.middle(), core.half_length() + radius),
            Self::Cuboid { half } => (DVec3::ZERO, half.length()),
            Self::Mesh(mesh) => mesh.ball_around(),
        }
    }

    /// True where all numbers are finite and sizes positive.
    pub fn is_valid(&self) -> bool {
        match self {
            Self::Round { core, radius } => {
                core.a.is_finite() && core.b.is_finite() && *radius > 0.0 && radius.is_finite()
            }
            Self::Cuboid { half } => half.is_finite() && half.min_element() > 0.0,
            Self::Mesh(_) => true,
        }
    }
}
