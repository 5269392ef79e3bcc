//! What happens.

use super::Id;
use serde::{Deserialize, Serialize};

/// What made a member act, or what it did.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// Its bound touched the side of its region, and is made anew.
    Resetting,
    /// Its bound touched another one's; both are made anew.
    Colliding {
        /// The other one.
        other: Id,
    },
    /// Its bound touched an obstacle.
    Meeting {
        /// Number in [`super::Setup::obstacles`].
        obstacle: usize,
    },
    /// It was at the end of its route.
    Arrived,
    /// It left the crowd at the end of its route, see [`super::AtEnd::Leave`].
    Left,
    /// An obstacle that moves ran into it.
    Struck {
        /// Number in [`super::Setup::obstacles`].
        obstacle: usize,
    },
    /// It has made no way toward its goal for 10 s.
    Stuck,
}

/// Something that happened to a member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When. [Unit: s]
    pub time: f64,
    /// To whom.
    pub member: Id,
    /// What.
    pub kind: EventKind,
}

/// How many events there were so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// See [`EventKind::Resetting`].
    pub resetting: u64,
    /// See [`EventKind::Colliding`]; each counts once.
    pub colliding: u64,
    /// See [`EventKind::Meeting`].
    pub meeting: u64,
    /// See [`EventKind::Arrived`].
    pub arrived: u64,
    /// See [`EventKind::Left`].
    pub left: u64,
    /// See [`EventKind::Struck`].
    pub struck: u64,
    /// See [`EventKind::Stuck`].
    pub stuck: u64,
    /// Times that a member chose what to do: one for each member made anew.
    pub decisions: u64,
}
