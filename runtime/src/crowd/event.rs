//! What happens.

use super::Id;
use serde::{Deserialize, Serialize};

/// What made a member act, or what it did.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// Its bound touched the side of its region, and is made anew.
    Resetting,
    /// Its bound touched another one's; both are made anew, unless the other one was in the meantime.
    Colliding {
        /// The other one.
        other: Id,
    },
    /// Its bound touched an obstacle.
    Meeting {
        /// Number in [`super::Setup::obstacles`].
        obstacle: usize,
    },
    /// Its bound touched a face, and occupies the cells behind it ([`super::Scheme::Occupancy`]).
    Entering,
    /// Its bound occupies the cells behind a face no more ([`super::Scheme::Occupancy`]).
    Leaving,
    /// It touches another one, and neither moves relative to the other ([`super::Scheme::Occupancy`]).
    Contacting {
        /// The other one.
        other: Id,
    },
    /// It moves relative to another one that it touched ([`super::Scheme::Occupancy`]).
    Separating {
        /// The other one.
        other: Id,
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
    /// See [`EventKind::Entering`].
    pub entering: u64,
    /// See [`EventKind::Leaving`].
    pub leaving: u64,
    /// See [`EventKind::Contacting`].
    pub contacting: u64,
    /// See [`EventKind::Separating`].
    pub separating: u64,
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
    /// Fixed steps that were taken, parts of one each for itself ([`super::Scheme::Fixed`]).
    pub steps: u64,
    /// Fixed steps that were undone, as somebody overlapped.
    pub undone: u64,
    /// Members who overlapped somebody at the end of a step that was as short as can be, and taken nevertheless.
    pub overlaps: u64,
}
