//! Parameters of the force field (001 section 2.2, eq. 15 to 23).

use super::CrowdError;
use serde::{Deserialize, Serialize};

/// What moves a member: parameters of 001 eq. 15 to 23, all per unit of mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Field {
    /// Time in which the desired velocity is approached, tau in eq. 17. [Unit: s] [Limit: 0.05 to 10]
    pub relaxation_s: f32,
    /// How far ahead on the spline of its route it looks. [Unit: m] [Limit: > 0]
    pub look_ahead_m: f32,
    /// How far others are felt; those who are registered in cells that are not next to its own are not felt at all.
    /// [Unit: m] [Limit: > 0]
    pub perception_m: f32,
    /// How strongly it keeps clear of those who are near, a repulsion in eq. 17. [Unit: m/s2] [Limit: >= 0]
    pub repulsion: f32,
    /// Gap at which that begins. [Unit: m] [Limit: > 0]
    pub repulsion_m: f32,
    /// c_1 in eq. 16: how its speed toward others weighs its braking. [Unit: s/m] [Limit: >= 0]
    pub braking: f32,
    /// D in eq. 19: gap from which the driving force toward others is taken back. [Unit: m] [Limit: > 0]
    pub decelerating_m: f32,
    /// w_dam c_dam in eq. 18 and 20: braking for each m/s of approach. [Unit: 1/s] [Limit: >= 0]
    pub damping: f32,
    /// c_2 in eq. 16: how its speed toward others weighs its avoiding. [Unit: s/m] [Limit: >= 0]
    pub avoiding: f32,
    /// c_tur in eq. 22. [Unit: m/s2] [Limit: >= 0]
    pub turning: f32,
    /// A in eq. 22: gap from which it turns away. [Unit: m] [Limit: > 0]
    pub turning_m: f32,
    /// Time to a contact from which it turns away; later ones are left alone. [Unit: s] [Limit: > 0]
    pub horizon_s: f32,
    /// Gap that it wishes to keep to those it passes. [Unit: m] [Limit: >= 0]
    pub comfort_m: f32,
    /// How little it likes detours: 0 takes the direction that leads on fastest wherever it leads, 1 goes straight on. [Limit: 0 to 1]
    pub directness: f32,
    /// How much better it likes the directions it goes in already. [Unit: s/m] [Limit: >= 0]
    pub keeping: f32,
    /// How much better it likes to pass on the right where its way is not free; below 0 on the left. [Limit: -1 to 1]
    pub right: f32,
    /// How little it likes to go where others stand or come toward it, as seen from afar: it then follows those who go
    /// its way, and lanes form. [Limit: >= 0]
    pub crowding: f32,
    /// How much it likes to go where others want to go its way, and dislikes where they want to go against it, for each
    /// of them that it sees from afar, whether they can or not. [Limit: >= 0]
    pub lanes: f32,
    /// How much better it likes to go to the right where many come straight toward it from afar, and there is no wall
    /// beside it (within its own length, and 20 m) that tells it where to go. [Limit: >= 0]
    pub evading: f32,
    /// Time it keeps to stop behind who goes before it. [Unit: s] [Limit: > 0]
    pub headway_s: f32,
    /// Gap that it leaves to who stands before it. [Unit: m] [Limit: >= 0]
    pub headway_m: f32,
    /// w_saf c_saf in eq. 21 and 23: pull to the centre of its bound. [Unit: 1/s2] [Limit: >= 0]
    pub safety: f32,
}

impl Default for Field {
    fn default() -> Self {
        Self {
            relaxation_s: 0.2,
            look_ahead_m: 2.0,
            perception_m: 4.0,
            repulsion: 3.3,
            repulsion_m: 0.25,
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
            lanes: 0.08,
            evading: 0.6,
            headway_s: 0.3,
            headway_m: 0.12,
            safety: 0.28,
        }
    }
}

impl Field {
    /// Every setting within its limits.
    pub(super) fn check(&self, index: usize) -> Result<(), CrowdError> {
        let positive = "above 0 and below 1e6";
        for (field, got) in [
            ("look_ahead_m", self.look_ahead_m),
            ("perception_m", self.perception_m),
            ("repulsion_m", self.repulsion_m),
            ("decelerating_m", self.decelerating_m),
            ("turning_m", self.turning_m),
            ("horizon_s", self.horizon_s),
            ("headway_s", self.headway_s),
        ] {
            if !(got > 0.0 && got < 1e6) {
                return Err(CrowdError::Value { what: "field", index, field, got, expected: positive });
            }
        }
        for (field, got) in [
            ("directness", self.directness),
            ("keeping", self.keeping),
            ("crowding", self.crowding),
            ("lanes", self.lanes),
            ("evading", self.evading),
            ("headway_m", self.headway_m),
            ("repulsion", self.repulsion),
            ("braking", self.braking),
            ("damping", self.damping),
            ("avoiding", self.avoiding),
            ("turning", self.turning),
            ("comfort_m", self.comfort_m),
            ("safety", self.safety),
        ] {
            if !(0.0..1e6).contains(&got) {
                let expected = "between 0 and 1e6";
                return Err(CrowdError::Value { what: "field", index, field, got, expected });
            }
        }
        if !(-1.0..=1.0).contains(&self.right) {
            let expected = "between -1 and 1";
            return Err(CrowdError::Value { what: "field", index, field: "right", got: self.right, expected });
        }
        let got = self.relaxation_s;
        if !(0.05..=10.0).contains(&got) {
            let expected = "between 0.05 and 10";
            return Err(CrowdError::Value { what: "field", index, field: "relaxation_s", got, expected });
        }
        Ok(())
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
    /// To the centre of its bound, eq. 23.
    pub safety: V,
    /// The acceleration that was taken at the last event, after the safety rule.
    pub taken: V,
}
