//! Parameters of the force field (Kim, Kim and Shin 2003b, section 2.2, eq. 15 to 23).

use crate::error::check;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::Result;

/// Force field that moves an agent: parameters of Kim, Kim and Shin (2003b), eq. 15 to 23, all per unit of mass.
///
/// ```
/// use throng_crowd::{CrowdConfig, ForceField};
///
/// // People who look farther ahead.
/// let field = ForceField { perception_m: 8.0, ..ForceField::default() };
/// assert!(field.perception_m > ForceField::default().perception_m);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ForceField {
    /// Time in which the desired velocity is approached, tau in eq. 17 (s, 0.05 to 10).
    pub relaxation_s: f32,
    /// Distance within which it reacts to others; agents beyond the neighbouring cells are not seen at all (m, > 0).
    pub perception_m: f32,
    /// Repulsion from near neighbours in eq. 17 (m/s2, >= 0).
    pub repulsion: f32,
    /// Gap at which that begins (m, > 0).
    pub repulsion_m: f32,
    /// c_1 in eq. 16: how its speed toward others weighs its braking (s/m, >= 0).
    pub braking: f32,
    /// D in eq. 19: gap from which the driving force toward others is taken back (m, > 0).
    pub decelerating_m: f32,
    /// w_dam c_dam in eq. 18 and 20: braking for each m/s of approach (1/s, >= 0).
    pub damping: f32,
    /// c_2 in eq. 16: how its speed toward others weighs its avoiding (s/m, >= 0).
    pub avoiding: f32,
    /// c_tur in eq. 22 (m/s2, >= 0).
    pub turning: f32,
    /// A in eq. 22: gap from which it turns away (m, > 0).
    pub turning_m: f32,
    /// Time to a contact from which it turns away; later ones are left alone (s, > 0).
    pub horizon_s: f32,
    /// Gap that it keeps to others it passes (m, >= 0).
    pub comfort_m: f32,
    /// Weight against detours: 0 takes the direction that allows the largest speed, 1 goes straight on (0 to 1).
    pub directness: f32,
    /// Weight for the present direction (s/m, >= 0).
    pub keeping: f32,
    /// Weight for passing on the right where its way is not free; below 0 on the left (-1 to 1).
    pub right: f32,
    /// Weight against places where others stand or come toward it, seen from afar: it then follows agents that go its
    /// way, and lanes form (>= 0).
    pub crowding: f32,
    /// Weight for places where others want to go its way, and against those where they want to come toward it, for each of
    /// them seen from afar, whether they move or not (>= 0).
    pub lanes: f32,
    /// Weight for the right where many come straight toward it from afar and no wall is beside it (>= 0).
    pub evading: f32,
    /// Largest speed at a density, relative to people there (Weidmann 1993); 0 for an agent in a hurry, which walks as
    /// fast as there is room (0 to 10).
    pub crowd_speed: f32,
    /// Time that it keeps to stop behind an agent in front (s, > 0).
    pub headway_s: f32,
    /// Gap that it leaves to an agent that stands in front (m, >= 0).
    pub headway_m: f32,
    /// w_saf c_saf in eq. 21 and 23: pull to the centre of its bound (1/s2, >= 0).
    pub safety: f32,
}

impl Default for ForceField {
    /// [`ForceField::COMMUTER`].
    fn default() -> Self {
        Self::COMMUTER
    }
}

impl ForceField {
    /// A pedestrian of about 0.3 m radius and 1.3 m/s on its way.
    pub const COMMUTER: Self = Self {
        relaxation_s: 0.2,
        perception_m: 4.0,
        repulsion: 3.3,
        repulsion_m: 0.2,
        braking: 0.28,
        decelerating_m: 0.2,
        damping: 0.16,
        avoiding: 0.71,
        turning: 0.31,
        turning_m: 0.65,
        horizon_s: 2.0,
        comfort_m: 0.02,
        directness: 0.55,
        keeping: 0.125,
        right: 0.15,
        crowding: 0.05,
        lanes: 0.02,
        evading: 0.6,
        crowd_speed: 0.0,
        headway_s: 0.3,
        headway_m: 0.12,
        safety: 0.28,
    };

    /// A bird of about 0.5 m radius and 5 m/s: lengths grow with its radius, and it needs no lanes, as it has room above
    /// and below.
    #[cfg(test)]
    pub const BIRD: Self = Self {
        relaxation_s: 0.3,
        perception_m: 6.8,
        repulsion_m: 0.42,
        decelerating_m: 0.34,
        turning_m: 1.1,
        comfort_m: 0.034,
        headway_m: 0.2,
        crowding: 0.0,
        lanes: 0.0,
        evading: 0.0,
        ..Self::COMMUTER
    };

    /// Every setting within its limits.
    pub(crate) fn check(&self, n: usize) -> Result<()> {
        let check = |what, got: f32, good, expected| check(what, n, got, good, expected);
        for (what, got) in [
            ("field.perception_m", self.perception_m),
            ("field.repulsion_m", self.repulsion_m),
            ("field.decelerating_m", self.decelerating_m),
            ("field.turning_m", self.turning_m),
            ("field.horizon_s", self.horizon_s),
            ("field.headway_s", self.headway_s),
        ] {
            check(what, got, got > 0.0 && got < 1e6, "above 0 and below 1e6")?;
        }
        for (what, got) in [
            ("field.directness", self.directness),
            ("field.keeping", self.keeping),
            ("field.crowding", self.crowding),
            ("field.lanes", self.lanes),
            ("field.evading", self.evading),
            ("field.crowd_speed", self.crowd_speed),
            ("field.headway_m", self.headway_m),
            ("field.repulsion", self.repulsion),
            ("field.braking", self.braking),
            ("field.damping", self.damping),
            ("field.avoiding", self.avoiding),
            ("field.turning", self.turning),
            ("field.comfort_m", self.comfort_m),
            ("field.safety", self.safety),
        ] {
            check(what, got, (0.0..1e6).contains(&got), "between 0 and 1e6")?;
        }
        check("field.right", self.right, (-1.0..=1.0).contains(&self.right), "between -1 and 1")?;
        let got = self.relaxation_s;
        check("field.relaxation_s", got, (0.05..=10.0).contains(&got), "between 0.05 and 10")
    }
}

/// Forces on an agent at one instant, term by term (m/s2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forces<V = Vec3> {
    /// Toward the desired velocity along the route, first term of eq. 17.
    pub driving: V,
    /// Attraction and repulsion, second term of eq. 17.
    pub interaction: V,
    /// Term that reduces the driving force toward near obstacles, eq. 19.
    pub decelerating: V,
    /// Against approach, eq. 20.
    pub damping: V,
    /// Sideways, eq. 22.
    pub turning: V,
    /// Term toward the centre of its bound, eq. 23.
    pub safety: V,
    /// The acceleration that was taken at the last event, after the safety rule.
    pub taken: V,
}

impl<V> Forces<V> {
    /// Converts it to another space.
    pub(crate) fn map<W>(self, f: impl Fn(V) -> W) -> Forces<W> {
        Forces {
            driving: f(self.driving),
            interaction: f(self.interaction),
            decelerating: f(self.decelerating),
            damping: f(self.damping),
            turning: f(self.turning),
            safety: f(self.safety),
            taken: f(self.taken),
        }
    }
}
