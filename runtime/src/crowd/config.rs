//! What a crowd is made of.

use super::{Field, Interest, Member, Obstacle, Route};
use serde::{Deserialize, Serialize};

/// How the crowd finds out when somebody has to act.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Bounds are registered in the cell of their centre (001 section 2.1): resetting and colliding events.
    #[default]
    Registration,
    /// Bounds are listed in every cell they occupy (000 section 2): entering, leaving, resetting, colliding, contacting and
    /// separating events; no collision is looked for within a group of members in contact. The guarantee is the same.
    Occupancy,
    /// Everybody acts at every step of time, and where discs overlap the step is undone and half of it tried (001 section
    /// 4): the baseline. Nothing but the forces keeps members apart; see [`CrowdConfig::halvings`].
    Fixed,
}

impl Scheme {
    /// Most events of one member in a smallest interval: those that make it act, in [`Scheme::Occupancy`] two of them,
    /// after each of which its bound enters and leaves the cells behind every face of a box and meets somebody or not.
    pub(super) fn most_events(self) -> u32 {
        if self == Self::Occupancy { 2 * (1 + 2 * 6 + 2) } else { 1 }
    }
}

/// How a crowd is run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrowdConfig {
    /// How it finds out when somebody has to act.
    pub scheme: Scheme,
    /// Smallest time between two events of one member, and so of a pair. [Unit: s] [Limit: 0.001 to 1]
    pub smallest_interval_s: f32,
    /// Side of the cells that members are registered in; 0 leaves it to the crowd. Who is not in a cell next to one's
    /// own is not seen. [Unit: m] [Limit: enough for everybody to stop within half of it, see
    /// [`super::Crowd::cell_side`]]
    pub cell_side_m: f32,
    /// Step of [`Scheme::Fixed`]. [Unit: s] [Limit: 0.001 to 1]
    pub step_s: f32,
    /// How often a step of [`Scheme::Fixed`] is halved. At the end of the shortest step, who overlaps loses the velocity toward the other;
    /// what overlaps still is let be, and counted. [Limit: <= 16]
    pub halvings: u32,
    /// Most members at a time; memory for them is taken at once. 0 stands for those it starts with.
    pub capacity: usize,
    /// Largest radius of members to come; 0 stands for those it starts with. [Unit: m]
    pub largest_radius_m: f32,
    /// Largest desired speed of members to come and of [`super::Crowd::send`]; 0 stands for those it starts with.
    /// [Unit: m/s]
    pub largest_speed_mps: f32,
}

impl Default for CrowdConfig {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            smallest_interval_s: 0.1,
            cell_side_m: 0.0,
            step_s: 1.0 / 30.0,
            halvings: 4,
            capacity: 0,
            largest_radius_m: 0.0,
            largest_speed_mps: 0.0,
        }
    }
}

/// What a crowd starts with, at time 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup<V> {
    /// Who is there.
    pub members: Vec<Member<V>>,
    /// Where they go. [Size: >= 1 where there are members]
    pub routes: Vec<Route<V>>,
    /// How they feel. [Size: >= 1 where there are members]
    pub fields: Vec<Field>,
    /// What is in their way.
    pub obstacles: Vec<Obstacle<V>>,
    /// What draws them near or drives them away.
    pub interests: Vec<Interest<V>>,
    /// How the crowd is run.
    pub config: CrowdConfig,
}

impl<V> Default for Setup<V> {
    /// Nobody, nowhere, with the default field.
    fn default() -> Self {
        Self {
            members: Vec::new(),
            routes: Vec::new(),
            fields: vec![Field::default()],
            obstacles: Vec::new(),
            interests: Vec::new(),
            config: CrowdConfig::default(),
        }
    }
}
