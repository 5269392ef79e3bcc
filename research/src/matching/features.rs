//! What is compared of two frames, and how much each part counts.

/// Numbers of a row: the features, then zeros up to whole vectors.
pub const WIDTH: usize = 48;
/// Features of a frame or a query, normalised and weighted: the squared distance of two rows is what a match costs.
pub type Row = [f32; WIDTH];

/// Moments ahead at which the trajectory is compared (s).
pub(super) const AHEAD_S: [f32; 3] = [1.0 / 3.0, 2.0 / 3.0, 1.0];

/// Features that are normalised together, and where they stand in a row. What tells frames apart best comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// Root position (x, z) at each moment ahead.
    Path,
    /// Direction (x, z) that the body faces at each moment ahead.
    Facing,
    /// Place of the next effective hit.
    HitPlace,
    /// Time until it lands.
    HitTime,
    /// Velocity of the hips.
    Hips,
    /// Positions of both feet.
    Feet,
    /// Their velocities.
    FeetVelocity,
    /// Positions of both fists.
    Fists,
    /// Their velocities.
    FistsVelocity,
}

impl Group {
    pub const ALL: [Self; 9] = {
        use Group::*;
        [Path, Facing, HitPlace, HitTime, Hips, Feet, FeetVelocity, Fists, FistsVelocity]
    };

    /// Where the group stands in a row.
    pub const fn range(self) -> std::ops::Range<usize> {
        match self {
            Group::Path => 0..6,
            Group::Facing => 6..12,
            Group::HitPlace => 12..15,
            Group::HitTime => 15..16,
            Group::Hips => 16..19,
            Group::Feet => 19..25,
            Group::FeetVelocity => 25..31,
            Group::Fists => 31..37,
            Group::FistsVelocity => 37..43,
        }
    }

    /// True where frames without a hit to come say nothing about what is usual.
    pub const fn is_of_hits(self) -> bool {
        matches!(self, Group::HitPlace | Group::HitTime)
    }
}

/// The part of a row that is the body's pose, which a query takes from the frame that is playing.
pub(super) const POSE: std::ops::Range<usize> = Group::Hips.range().start..Group::FistsVelocity.range().end;

/// How much each group of features counts, on top of its usual spread over the database, which makes them alike.
/// (>= 0)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FeatureWeights {
    /// Root positions ahead.
    pub path: f32,
    /// Facing directions ahead.
    pub facing: f32,
    /// Place of the next effective hit.
    pub hit_place: f32,
    /// Time until it lands.
    pub hit_time: f32,
    /// Velocity of the hips.
    pub hips: f32,
    /// Positions of the feet.
    pub feet: f32,
    /// Velocities of the feet.
    pub feet_velocity: f32,
    /// Positions of the fists.
    pub fists: f32,
    /// Velocities of the fists.
    pub fists_velocity: f32,
}

impl Default for FeatureWeights {
    /// Holden's weights; fists count less than feet, as no ground holds them.
    fn default() -> Self {
        Self {
            path: 1.0,
            facing: 1.5,
            hit_place: 2.0,
            hit_time: 0.5,
            hips: 1.0,
            feet: 0.75,
            feet_velocity: 1.0,
            fists: 0.4,
            fists_velocity: 0.5,
        }
    }
}

impl FeatureWeights {
    pub(super) fn of(&self, group: Group) -> f32 {
        match group {
            Group::Path => self.path,
            Group::Facing => self.facing,
            Group::HitPlace => self.hit_place,
            Group::HitTime => self.hit_time,
            Group::Hips => self.hips,
            Group::Feet => self.feet,
            Group::FeetVelocity => self.feet_velocity,
            Group::Fists => self.fists,
            Group::FistsVelocity => self.fists_velocity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_lie_side_by_side() {
        let mut next = 0;
        for g in Group::ALL {
            assert_eq!(g.range().start, next);
            next = g.range().end;
        }
        assert!(next <= WIDTH && POSE.end == next && POSE.start == 16);
    }
}
