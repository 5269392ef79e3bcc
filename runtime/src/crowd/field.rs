//! Parameters of the force field (001 section 2.2, eq. 15 to 23).

use serde::{Deserialize, Serialize};

/// What moves a member: parameters of 001 eq. 15 to 23, all per unit of mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Field {
    /// Time in which the desired velocity is approached, tau in eq. 17. [Unit: s] [Limit: > 0]
    pub relaxation_s: f32,
    /// How far ahead on the spline of its route it looks. [Unit: m] [Limit: > 0]
    pub look_ahead_m: f32,
    /// How far others are felt. [Unit: m] [Limit: > 0]
    pub perception_m: f32,
}

impl Default for Field {
    fn default() -> Self {
        Self { relaxation_s: 0.5, look_ahead_m: 2.0, perception_m: 3.0 }
    }
}

/// What moves a member at one instant, term by term. [Unit: m/s2]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forces<V> {
    /// Toward the desired velocity along the route, first term of eq. 17.
    pub driving: V,
    /// Attraction and repulsion, second term of eq. 17.
    pub interaction: V,
    /// Takes back the driving force toward what is near, eq. 19.
    pub decelerating: V,
    /// Against approach, eq. 20.
    pub damping: V,
    /// Sideways, eq. 22.
    pub turning: V,
    /// What the safety rule added at the last event, eq. 23.
    pub safety: V,
    /// The acceleration that was taken.
    pub taken: V,
}
