//! What stands or moves in the way.

/// Something that nobody enters.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq)]
pub enum Obstacle<V> {
    /// A disc or ball that stays where it is.
    Ball {
        /// Centre. [Unit: m]
        centre: V,
        /// [Unit: m] [Limit: > 0]
        radius: f32,
    },
    /// A disc or ball on its way through points, at constant speed between two of them; it stops for nobody. Members
    /// get out of its way as far as they can: who is shut in is hit, and a [`super::EventKind::Struck`] tells so.
    Mover {
        /// Where it is at which time. Before the first and after the last it stands still.
        /// [Unit: s, m] [Size: >= 1] [Limit: times rise]
        way: Vec<(f64, V)>,
        /// [Unit: m] [Limit: > 0]
        radius: f32,
    },
    /// A wall, or in 3-D a rod or column: all that is within `radius` of a line from `from` to `to`.
    Wall {
        /// One end. [Unit: m]
        from: V,
        /// The other end. [Unit: m]
        to: V,
        /// Half its thickness. [Unit: m] [Limit: >= 0]
        radius: f32,
    },
    /// A solid polygon in 2-D, its corners in order around it.
    Polygon {
        /// [Unit: m] [Size: >= 3]
        corners: Vec<V>,
    },
    /// A solid box along the axes, a rectangle in 2-D.
    Box {
        /// Smallest coordinates. [Unit: m]
        min: V,
        /// Largest coordinates. [Unit: m] [Limit: > min]
        max: V,
    },
}

/// Something that draws members near or drives them away: a window display, a puddle (001 eq. 17, second term).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interest<V> {
    /// Where it is. [Unit: m]
    pub position: V,
    /// c_int in eq. 17 at its place, less with the distance: above 0 attracts, below 0 repels. [Unit: m/s2]
    pub strength: f32,
    /// How far it is felt. [Unit: m] [Limit: > 0]
    pub reach: f32,
}
