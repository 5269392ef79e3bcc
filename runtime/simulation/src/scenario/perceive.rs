//! Perception of an agent while an expression is evaluated.

use super::language::{Attribute, EventAttribute, Load, Perception, PlaceAttribute, Spot, Who};
use super::mind::{Context, NO};
use super::minds::Minds;
use super::stage::Stage;
use super::tables::{NONE, Party};
use glam::Vec3;

/// View of an agent in the context of an event.
pub(super) struct View<'a, S> {
    pub minds: &'a Minds,
    pub stage: &'a S,
    pub agent: u32,
    pub context: Context,
    /// Number of random numbers that the agent has drawn so far.
    pub draws: &'a mut u32,
}

impl<S: Stage> View<'_, S> {
    fn who(&self, who: Who) -> Option<u32> {
        let other = self.context.other;
        match who {
            Who::Me => Some(self.agent),
            Who::Other => (other != NONE).then_some(other),
        }
    }

    /// Position of a spot; `None` where it does not exist (m).
    pub fn spot(&self, spot: Spot) -> Option<Vec3> {
        match spot {
            Spot::Me => self.stage.position(self.agent),
            Spot::Other => self.stage.position(self.who(Who::Other)?),
            Spot::Home => Some(Vec3::from_array(self.minds.minds[self.agent as usize].home)),
            Spot::Here | Spot::Place(_) => Some(self.minds.scenario.places[self.place(spot)?].at),
        }
    }

    fn place(&self, spot: Spot) -> Option<usize> {
        match spot {
            Spot::Place(place) => Some(usize::from(place)),
            _ => (self.context.place != NO).then(|| usize::from(self.context.place)),
        }
    }

    fn attribute(&self, agent: u32, of: Attribute) -> f64 {
        let (minds, m) = (self.minds, agent as usize);
        let mind = &minds.minds[m];
        let position = || self.stage.position(agent).unwrap_or_default();
        match of {
            Attribute::Value(v) => {
                let tables = &minds.scenario.values;
                f64::from(minds.feelings[m * tables.len() + usize::from(v)].at(&tables[usize::from(v)], minds.now))
            }
            Attribute::X => f64::from(position().x),
            Attribute::Y => f64::from(position().y),
            Attribute::Z => f64::from(position().z),
            Attribute::Speed => f64::from(self.stage.velocity(agent).length()),
            Attribute::DesiredSpeed => f64::from(mind.speed),
            Attribute::Group => f64::from(mind.group),
            Attribute::State(level) => match mind.states[usize::from(level)] {
                NO => -1.0,
                state => f64::from(minds.scenario.states[usize::from(state)].word),
            },
            Attribute::StateSeconds => minds.now - mind.state_since,
            Attribute::News => f64::from_bits(mind.news),
            Attribute::Busy => f64::from(u8::from(mind.is_busy)),
            Attribute::Number => f64::from(agent - minds.scenario.groups[usize::from(mind.group)].agents[0]),
        }
    }

    fn of_place(&self, place: usize, of: PlaceAttribute) -> f64 {
        let table = &self.minds.scenario.places[place];
        let [first, last] = table.slots;
        let held = || self.minds.holders[first as usize..last as usize].iter().filter(|h| **h != NONE).count();
        match of {
            PlaceAttribute::Name => place as f64,
            PlaceAttribute::Kind => f64::from(table.kind),
            PlaceAttribute::Free => (last - first) as f64 - held() as f64,
            PlaceAttribute::Held => held() as f64,
        }
    }
}

impl<S: Stage> Perception for View<'_, S> {
    fn load(&mut self, what: Load) -> f64 {
        let minds = self.minds;
        match what {
            Load::Time => minds.now,
            Load::Random => {
                *self.draws += 1;
                hashed(minds.seed, self.agent, *self.draws)
            }
            Load::Of(who, of) => self.who(who).map_or(0.0, |agent| self.attribute(agent, of)),
            Load::Event(of) => match (of, self.context.event) {
                (EventAttribute::Strength, _) => f64::from(self.context.strength),
                (EventAttribute::How, _) => f64::from(self.context.how as u8),
                (_, NO) => -1.0,
                (EventAttribute::Name, event) => f64::from(event),
                (EventAttribute::Age, event) => minds.now - minds.happened[usize::from(event)],
            },
            Load::Place(spot, of) => self.place(spot).map_or(-1.0, |place| self.of_place(place, of)),
            Load::Board(false) => f64::from_bits(minds.boards.global(minds.now)),
            Load::Board(true) => {
                let at = self.stage.position(self.agent).unwrap_or_default();
                f64::from_bits(minds.boards.at(at, minds.now))
            }
            Load::Distance(a, b) => match (self.spot(a), self.spot(b)) {
                (Some(a), Some(b)) => f64::from(a.distance(b)),
                _ => f64::INFINITY,
            },
            Load::Friendship(a, b) => match (self.who(a), self.who(b)) {
                (Some(a), Some(b)) => f64::from(minds.friendship(a, b)),
                _ => 0.0,
            },
            Load::Curiosity(who, spot) => {
                let Some(agent) = self.who(who) else { return 0.0 };
                let to = match spot {
                    Spot::Here | Spot::Place(_) => self.place(spot).map(|p| Party::Place(p as u16)),
                    Spot::Other => self.who(Who::Other).map(Party::Agent),
                    _ => None,
                };
                to.map_or(0.0, |to| f64::from(minds.curiosity(agent, to)))
            }
            Load::Count(group) => {
                let [first, last] = minds.scenario.groups[usize::from(group)].agents;
                minds.minds[first as usize..last as usize].iter().filter(|m| m.is_there).count() as f64
            }
            Load::Taken(thing) => f64::from(u8::from(minds.keepers[usize::from(thing)] != NONE)),
            Load::Holds(who, thing) => {
                let keeper = minds.keepers[usize::from(thing)];
                f64::from(u8::from(keeper != NONE && self.who(who) == Some(keeper)))
            }
            Load::Open(door) => f64::from(u8::from(minds.is_open[usize::from(door)])),
        }
    }
}

impl Minds {
    /// Friendship of one agent for another (-1 to 1).
    pub(super) fn friendship(&self, of: u32, to: u32) -> f32 {
        let bonds = self.bonds.get(of as usize).map_or(&[] as &[(u32, f32)], |b| b);
        let bond = bonds.iter().find(|b| b.0 == to).map_or(0.0, |b| b.1);
        (self.relation(of, Party::Agent(to), |r| r.friendship) + bond).clamp(-1.0, 1.0)
    }

    /// Curiosity of an agent about another one, or about a place (-1 to 1).
    pub(super) fn curiosity(&self, of: u32, to: Party) -> f32 {
        self.relation(of, to, |r| r.curiosity)
    }

    /// Value of the last relation that holds for both.
    fn relation(&self, of: u32, to: Party, what: fn(&super::tables::Relation) -> f32) -> f32 {
        let group = |agent: u32| Party::Group(self.minds[agent as usize].group);
        let is = |party: Party, who: Party| match who {
            Party::Agent(agent) => party == who || party == group(agent),
            _ => party == who,
        };
        for (number, r) in self.scenario.relations.iter().enumerate().rev() {
            let value = what(r);
            if value.is_nan() || !is(r.of, Party::Agent(of)) || !is(r.to, to) {
                continue;
            }
            // The draw is the same from both sides.
            let (a, b) = match to {
                Party::Agent(other) => (of.min(other), of.max(other)),
                Party::Place(place) | Party::Group(place) => (of, NONE - u32::from(place)),
            };
            if r.share >= 1.0 || hashed(self.seed ^ number as u64, a, b) < f64::from(r.share) {
                return value;
            }
        }
        0.0
    }
}

/// Hash of three numbers as a random number, from 0 up to 1 (Steele, Lea and Flood 2014, the mixing of SplitMix64).
pub(crate) fn hashed(seed: u64, a: u32, b: u32) -> f64 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let first = mix(seed.wrapping_add(0x9E37_79B9_7F4A_7C15));
    let second = mix(first ^ (u64::from(a) << 32 | u64::from(b)).wrapping_add(0x9E37_79B9_7F4A_7C15));
    (second >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}
