//! Relationships of single agents: places and agents that attract or repel them, and companions.

use crate::{Id, NONE, Space, error::Result};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::error::check_value;

/// Most interests of one agent.
const MOST_INTERESTS: usize = 4;
/// Most agents that walk together with one.
pub(crate) const MOST_COMPANIONS: usize = 3;

/// Something that draws one agent near or drives it away: as [`crate::Interest`], of one agent alone (Kim, Kim and Shin 2003b,
/// eq. 17, second term).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PersonalInterest<V = Vec3> {
    /// Location of the interest.
    pub at: InterestLocation<V>,
    /// c_int in eq. 17 at its place, less with the distance: above 0 attracts, below 0 repels (m/s2).
    pub strength: f32,
    /// Distance within which it has an effect (m, > 0).
    pub reach: f32,
}

/// Location of a [`PersonalInterest`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum InterestLocation<V = Vec3> {
    /// (m)
    Place(V),
    /// Wherever another agent is, as long as it is in the crowd.
    Agent(Id),
}

impl<V> PersonalInterest<V> {
    /// Converts it to another space.
    pub fn map<W>(self, f: impl Fn(V) -> W) -> PersonalInterest<W> {
        let at = match self.at {
            InterestLocation::Place(at) => InterestLocation::Place(f(at)),
            InterestLocation::Agent(id) => InterestLocation::Agent(id),
        };
        PersonalInterest { at, strength: self.strength, reach: self.reach }
    }
}

/// Relationships of one agent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "V: Space")]
pub(crate) struct AgentRelationships<V> {
    pub interests: [Option<PersonalInterest<V>>; MOST_INTERESTS],
    /// Companions, in the order of numbers; [`NONE`] after the last.
    pub companions: [u32; MOST_COMPANIONS],
}

impl<V> AgentRelationships<V> {
    /// Cares for nothing.
    pub const NONE: Self = Self { interests: [const { None }; MOST_INTERESTS], companions: [NONE; MOST_COMPANIONS] };

    /// Companions.
    pub fn companions(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.companions.iter().copied().filter(|&c| c != NONE)
    }

    /// Agents at any distance that it looks at.
    pub fn agents(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        let of = |interest: &PersonalInterest<V>| match interest.at {
            InterestLocation::Agent(id) => Some(id.index),
            InterestLocation::Place(_) => None,
        };
        self.companions().chain(self.interests.iter().flatten().filter_map(of))
    }
}

/// Relationships of all agents.
#[derive(Clone, Debug)]
pub(crate) struct RelationshipTable<V> {
    agents: Vec<AgentRelationships<V>>,
    /// True once any agent had a relationship.
    is_any: bool,
}

impl<V: Space> RelationshipTable<V> {
    pub fn new(capacity: usize) -> Self {
        Self { agents: vec![AgentRelationships::NONE; capacity], is_any: false }
    }

    /// Relationships of an agent; none where no agent has any.
    #[inline]
    pub fn relationships_of(&self, agent: u32) -> Option<&AgentRelationships<V>> {
        self.is_any.then(|| &self.agents[agent as usize])
    }

    /// Sets one of the interests of an agent.
    ///
    /// # Errors
    /// [`Error::Value`].
    pub fn set_interest(&mut self, id: Id, n: usize, interest: Option<PersonalInterest<V>>) -> Result<()> {
        throng_base::error::check_index("interest", Some(id), n, MOST_INTERESTS)?;
        if let Some(PersonalInterest { at, strength, reach }) = interest {
            let expected = "above 0 and below 1e6, with a strength and position that are finite, and not itself";
            let somewhere = match at {
                InterestLocation::Place(at) => at.is_finite(),
                InterestLocation::Agent(other) => other.index != id.index,
            };
            let good = strength.is_finite() && somewhere && reach > 0.0 && reach < 1e6;
            check_value("interest.reach", Some(id), reach, good, expected)?;
        }
        self.agents[id.index()].interests[n] = interest;
        self.is_any = true;
        Ok(())
    }

    /// Makes two to four agents a group of companions; a single one walks alone.
    ///
    /// # Errors
    /// [`Error::Value`] for more than four, none, or one twice.
    pub fn set_companions(&mut self, ids: &[Id]) -> Result<()> {
        let good = (1..=MOST_COMPANIONS + 1).contains(&ids.len());
        check_value("number of companions", None, ids.len() as f64, good, "one to four")?;
        let twice = (0..ids.len()).find(|&n| ids[..n].contains(&ids[n]));
        let who = twice.map(|n| ids[n]);
        check_value("number of companions", who, ids.len() as f64, twice.is_none(), "each of them once")?;
        ids.iter().for_each(|id| self.leave_group(id.index));
        for id in ids {
            let mut others = [NONE; MOST_COMPANIONS];
            ids.iter().filter(|o| *o != id).zip(&mut others).for_each(|(o, place)| *place = o.index);
            others.sort_unstable();
            self.agents[id.index()].companions = others;
        }
        self.is_any = true;
        Ok(())
    }

    /// Removes an agent from its group.
    fn leave_group(&mut self, agent: u32) {
        let others = std::mem::replace(&mut self.agents[agent as usize].companions, [NONE; MOST_COMPANIONS]);
        for other in others.into_iter().filter(|&o| o != NONE) {
            let its = &mut self.agents[other as usize].companions;
            its.iter_mut().filter(|c| **c == agent).for_each(|c| *c = NONE);
            its.sort_unstable();
        }
    }

    /// Forgets an agent that leaves.
    pub fn forget(&mut self, agent: u32) {
        if self.is_any {
            self.leave_group(agent);
            self.agents[agent as usize] = AgentRelationships::NONE;
        }
    }

    /// The acceleration by the interests of an agent.
    ///
    /// - `place`: where another agent is, as long as it is in the crowd.
    pub fn interest_acceleration(&self, agent: u32, position: V, place: impl Fn(Id) -> Option<V>) -> V {
        let mut pull = V::default();
        for interest in self.relationships_of(agent).iter().flat_map(|own| own.interests.iter().flatten()) {
            let at = match interest.at {
                InterestLocation::Place(at) => Some(at),
                InterestLocation::Agent(id) => place(id),
            };
            let Some(at) = at else { continue };
            let (toward, distance) = (at - position).unit_and_length();
            pull += toward * (interest.strength * (1.0 - distance / interest.reach).max(0.0));
        }
        pull
    }

    /// Relationships of agents that have any, for snapshots.
    pub fn saved(&self) -> Vec<(u32, AgentRelationships<V>)> {
        (0..).zip(self.agents.iter().copied()).filter(|(_, own)| *own != AgentRelationships::NONE).collect()
    }

    /// Restores the relationships of a snapshot.
    pub fn restore_saved(&mut self, saved: &[(u32, AgentRelationships<V>)]) {
        self.agents.fill(AgentRelationships::NONE);
        saved.iter().for_each(|(m, relationship)| self.agents[*m as usize] = *relationship);
        self.is_any = !saved.is_empty();
    }

    /// True for what a snapshot of this crowd may hold.
    pub fn is_possible(&self, saved: &[(u32, AgentRelationships<V>)], is_there: impl Fn(u32) -> bool) -> bool {
        let num = self.agents.len();
        let is_known = |m: u32| (m as usize) < num;
        let relationship = |m: u32| saved.binary_search_by_key(&m, |s| s.0).ok().map(|n| &saved[n].1);
        let is_place = |i: &PersonalInterest<V>| match i.at {
            InterestLocation::Place(at) => at.is_finite(),
            InterestLocation::Agent(_) => true,
        };
        let is_interest = |i: &PersonalInterest<V>| i.strength.is_finite() && i.reach > 0.0 && is_place(i);
        saved.windows(2).all(|w| w[0].0 < w[1].0)
            && saved.iter().all(|(m, own)| {
                is_known(*m)
                    && is_there(*m)
                    && own.agents().all(|o| is_known(o) && o != *m)
                    && own.interests.iter().flatten().all(is_interest)
                    && own
                        .companions()
                        .all(|c| is_there(c) && relationship(c).is_some_and(|b| b.companions.contains(m)))
            })
    }

    /// Adds all to a hash.
    pub fn hash(&self, mut add: impl FnMut(u64)) {
        for (m, relationship) in self.saved() {
            add(u64::from(m));
            relationship.companions().for_each(|c| add(u64::from(c)));
            for (n, interest) in relationship.interests.iter().enumerate().filter_map(|(n, i)| Some((n, (*i)?))) {
                add(n as u64 | u64::from(interest.strength.to_bits()) << 32);
                add(u64::from(interest.reach.to_bits()));
                match interest.at {
                    InterestLocation::Place(at) => at.coordinates().iter().for_each(|c| add(u64::from(c.to_bits()))),
                    InterestLocation::Agent(id) => add(u64::from(id.index) << 32 | u64::from(id.generation)),
                }
            }
        }
    }
}
