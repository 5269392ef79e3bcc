//! Perception of an agent while an expression is evaluated.

use super::agent_brain::{EventContext, NO_NUMBER};
use super::language::{Attribute, EventAttribute, Load, Perception, PlaceAttribute, SpotName, Subject};
use super::tables::{NONE, Party};
use super::{agent_brains::AgentBrains, stage::ScenarioStage};
use glam::Vec3;

/// View of an agent in the context of an event.
pub(super) struct AgentView<'a, S> {
    pub brains: &'a AgentBrains,
    pub stage: &'a S,
    pub agent: u32,
    pub context: EventContext,
    /// Time (s).
    pub now: f64,
    /// Number of random numbers that the agent has drawn so far.
    pub draws: &'a mut u32,
}

impl<S: ScenarioStage> AgentView<'_, S> {
    fn agent_of(&self, who: Subject) -> Option<u32> {
        let other = self.context.other;
        match who {
            Subject::Me => Some(self.agent),
            Subject::Other => (other != NONE).then_some(other),
        }
    }

    /// Position of a spot; `None` where it does not exist (m).
    pub fn spot_position(&self, spot: SpotName) -> Option<Vec3> {
        match spot {
            SpotName::Me => self.stage.position(self.agent),
            SpotName::Other => self.stage.position(self.agent_of(Subject::Other)?),
            SpotName::Home => Some(Vec3::from_array(self.brains.brains[self.agent as usize].home)),
            SpotName::Here | SpotName::Place(_) => Some(self.brains.scenario.places[self.place_number(spot)?].at),
        }
    }

    fn place_number(&self, spot: SpotName) -> Option<usize> {
        match spot {
            SpotName::Place(place) => Some(usize::from(place)),
            _ => (self.context.place != NO_NUMBER).then(|| usize::from(self.context.place)),
        }
    }

    fn attribute_value(&self, agent: u32, of: Attribute) -> f64 {
        let (brains, m) = (self.brains, agent as usize);
        let brain = &brains.brains[m];
        let position = || self.stage.position(agent).unwrap_or_default();
        match of {
            Attribute::Value(v) => {
                let (v, tables) = (usize::from(v), &brains.scenario.values);
                f64::from(brains.feelings[m * tables.len() + v].value_at(&tables[v], self.now))
            }
            Attribute::X => f64::from(position().x),
            Attribute::Y => f64::from(position().y),
            Attribute::Z => f64::from(position().z),
            Attribute::Speed => f64::from(self.stage.velocity(agent).length()),
            Attribute::DesiredSpeed => f64::from(brain.speed),
            Attribute::Group => f64::from(brain.group),
            Attribute::State(level) => match brain.states[usize::from(level)] {
                NO_NUMBER => -1.0,
                state => f64::from(brains.scenario.states[usize::from(state)].word),
            },
            Attribute::StateSeconds => self.now - brain.state_since,
            Attribute::News => f64::from_bits(brain.news),
            Attribute::Waits => {
                let slot = brains.scenario.slots.get(brain.slot as usize);
                f64::from(u8::from(slot.is_some_and(|s| brains.scenario.places[usize::from(s.place)].is_queue)))
            }
            Attribute::Laps => f64::from(brains.laps_of(agent)),
            Attribute::Progress => f64::from(brains.progress_of(self.stage, agent)),
            Attribute::Busy => f64::from(u8::from(brain.is_busy)),
            Attribute::Number => f64::from(agent - brains.scenario.groups[usize::from(brain.group)].agents[0]),
        }
    }

    fn place_value(&self, place: usize, of: PlaceAttribute) -> f64 {
        let table = &self.brains.scenario.places[place];
        let [first, last] = table.slots;
        let held = || self.brains.holders[first as usize..last as usize].iter().filter(|h| **h != NONE).count();
        match of {
            PlaceAttribute::Name => place as f64,
            PlaceAttribute::Kind => f64::from(table.kind),
            PlaceAttribute::Free => (last - first) as f64 - held() as f64,
            PlaceAttribute::Held => held() as f64,
        }
    }
}

impl<S: ScenarioStage> Perception for AgentView<'_, S> {
    fn load_value(&mut self, what: Load) -> f64 {
        let brains = self.brains;
        match what {
            Load::Time => self.now,
            Load::Random => {
                *self.draws += 1;
                hashed_chance(brains.seed, self.agent, *self.draws)
            }
            Load::Of(who, of) => self.agent_of(who).map_or(0.0, |agent| self.attribute_value(agent, of)),
            Load::Event(of) => match (of, self.context.event) {
                (EventAttribute::Strength, _) => f64::from(self.context.strength),
                (EventAttribute::How, _) => f64::from(self.context.how as u8),
                (_, NO_NUMBER) => -1.0,
                (EventAttribute::Name, event) => f64::from(event),
                (EventAttribute::Age, event) => self.now - brains.happened[usize::from(event)],
            },
            Load::Place(spot, of) => self.place_number(spot).map_or(-1.0, |place| self.place_value(place, of)),
            Load::Blackboard(false) => f64::from_bits(brains.blackboards.global_events(self.now)),
            Load::Blackboard(true) => {
                let at = self.stage.position(self.agent).unwrap_or_default();
                f64::from_bits(brains.blackboards.events_at(at, self.now))
            }
            Load::Distance(a, b) => match (self.spot_position(a), self.spot_position(b)) {
                (Some(a), Some(b)) => f64::from(a.distance(b)),
                _ => f64::INFINITY,
            },
            Load::Friendship(a, b) => match (self.agent_of(a), self.agent_of(b)) {
                (Some(a), Some(b)) => f64::from(brains.friendship(a, b)),
                _ => 0.0,
            },
            Load::Curiosity(who, spot) => {
                let Some(agent) = self.agent_of(who) else { return 0.0 };
                let to = match spot {
                    SpotName::Here | SpotName::Place(_) => self.place_number(spot).map(|p| Party::Place(p as u16)),
                    SpotName::Other => self.agent_of(Subject::Other).map(Party::Agent),
                    _ => None,
                };
                to.map_or(0.0, |to| f64::from(brains.curiosity(agent, to)))
            }
            Load::Count(group) => {
                let [first, last] = brains.scenario.groups[usize::from(group)].agents;
                brains.brains[first as usize..last as usize].iter().filter(|m| m.is_there).count() as f64
            }
            Load::Taken(thing) => f64::from(u8::from(brains.keepers[usize::from(thing)] != NONE)),
            Load::Holds(who, thing) => {
                let keeper = brains.keepers[usize::from(thing)];
                f64::from(u8::from(keeper != NONE && self.agent_of(who) == Some(keeper)))
            }
            Load::Open(door) => f64::from(u8::from(brains.is_open[usize::from(door)])),
        }
    }
}

impl AgentBrains {
    /// Friendship of one agent for another (-1 to 1).
    pub(super) fn friendship(&self, of: u32, to: u32) -> f32 {
        let relationships = self.relationships.get(of as usize).map_or(&[] as &[(u32, f32)], |b| b);
        let relationship = relationships.iter().find(|b| b.0 == to).map_or(0.0, |b| b.1);
        (self.relation_value(of, Party::Agent(to), |r| r.friendship) + relationship).clamp(-1.0, 1.0)
    }

    /// Curiosity of an agent about another one, or about a place (-1 to 1).
    pub(super) fn curiosity(&self, of: u32, to: Party) -> f32 {
        self.relation_value(of, to, |r| r.curiosity)
    }

    /// Value of the last relation that holds for both.
    fn relation_value(&self, of: u32, to: Party, what: fn(&super::tables::RelationTable) -> f32) -> f32 {
        let group = |agent: u32| Party::Group(self.brains[agent as usize].group);
        let is = |party: Party, who: Party| match who {
            Party::Agent(agent) => party == who || party == group(agent),
            _ => party == who,
        };
        for (number, r) in self.scenario.relations.iter().enumerate().rev() {
            let value = what(r);
            let holds = is(r.of, Party::Agent(of)) && is(r.to, to);
            let is_turned = !r.one_sided && is(r.of, to) && is(r.to, Party::Agent(of));
            if value.is_nan() || !holds && !is_turned {
                continue;
            }
            // The draw is the same from both sides.
            let (a, b) = match to {
                Party::Agent(other) => (of.min(other), of.max(other)),
                Party::Place(place) | Party::Group(place) => (of, NONE - u32::from(place)),
            };
            if r.share >= 1.0 || hashed_chance(self.seed ^ number as u64, a, b) < f64::from(r.share) {
                return value;
            }
        }
        0.0
    }
}

/// Hash of three numbers as a random number, from 0 up to 1 (Steele, Lea and Flood 2014, the mixing of SplitMix64).
pub(crate) fn hashed_chance(seed: u64, a: u32, b: u32) -> f64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let first = mix(seed.wrapping_add(0x9E37_79B9_7F4A_7C15));
    let second = mix(first ^ (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9E37_79B9_7F4A_7C15));
    (second >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}
