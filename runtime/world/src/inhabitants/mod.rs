//! Inhabitants: characters that live in a world, hold the units they need, and go where they wish (Lee, Choi and Lee 2006, section 7).

mod chain;
mod config;
mod decide;
mod error;
mod lay;
mod offers;
mod paths;
mod reservations;
mod scatter;
mod snapshot;

pub use config::{Doing, InhabitantsConfig, Status, Wish};
pub use error::InhabitantsError;
pub use scatter::scatter;

use super::plan::{Plan, Planner, Target};
use super::{Node, Step, World, WorldGraph};
use chain::Chains;
use paths::Paths;
use reservations::Reservations;
use serde::{Deserialize, Serialize};
use throng_base::{Inline, Run};
use throng_core::characters::Characters;

/// What is remembered of an inhabitant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct InhabitantState {
    /// Node that its motion leads to.
    at: Node,
    /// Instances that its motion leads through: where it began, and whose link it plays.
    through: [u32; 2],
    wish: Wish,
    doing: Doing,
    num_fulfilled: u32,
    /// When it was first refused what it needs, since it last got it (s).
    refused_s: Option<f64>,
    /// Random numbers drawn so far.
    draws: u32,
    /// Steps of its path in a row that it was not refused.
    progress: u32,
    /// Times in a row that it lost patience.
    impatience: u32,
    /// Steps of its detour that are left.
    detour: u32,
    /// When it goes on after its detour (s).
    until_s: f64,
    /// How long it has done what it was to perform (frames).
    performed: u32,
}

/// Characters in a world, with what they wish for; all memory is allocated in [`Inhabitants::new`].
///
/// Each holds the units of the instance it is in, and takes all that it needs up to the next node from which a rest
/// cell can be reached without more. Others keep out of them. Who does not get what it needs goes to rest within what it
/// holds, tries again, and after a while makes a random detour, longer each time.
#[derive(Clone, Debug)]
pub struct Inhabitants {
    world: World,
    config: InhabitantsConfig,
    characters: Characters,
    states: Vec<InhabitantState>,
    chains: Chains,
    paths: Paths,
    reservations: Reservations,
    planner: Planner,
    /// Instances that offer each tag, by `tag - 1`.
    offers: Vec<Vec<u32>>,
    rate_hz: f32,
    time_s: f64,
}

impl Inhabitants {
    /// Puts a character at every start, at rest. They roam until they are given a wish.
    ///
    /// # Errors
    /// [`InhabitantsError`] for a start that does not exist, where nobody can stay or whose units another one holds, and
    /// for a setting out of its range.
    pub fn new(world: &World, config: InhabitantsConfig, starts: &[Node]) -> Result<Self, InhabitantsError> {
        config.check()?;
        let (motion_set, graph) = (world.motion_set(), world.graph());
        let mut reservations = Reservations::new(graph.world().units.len(), starts.len());
        let mut scheduled_clips = Vec::with_capacity(starts.len());
        for (c, &node) in starts.iter().enumerate() {
            check_node(graph, node)?;
            let rest = graph.is_rest(node).then(|| graph.step_to_rest(node)).flatten();
            let Some(scheduled_clip) = rest.and_then(|step| lay::scheduled_clip(graph, motion_set, &step, None)) else {
                return Err(InhabitantsError::Start { character: c, node });
            };
            let units = graph.resources(node.instance);
            let held = units.iter().find_map(|&unit| reservations.of(unit).map(|other| (unit, other)));
            if let Some((unit, other)) = held {
                return Err(InhabitantsError::Held { character: c, other: other as usize, unit });
            }
            reservations.take(units, c as u32);
            scheduled_clips.push(scheduled_clip);
        }
        let state = |&at| InhabitantState {
            at,
            through: [at.instance; 2],
            wish: Wish::Roam,
            doing: Doing::Roaming,
            num_fulfilled: 0,
            refused_s: None,
            draws: 0,
            progress: 0,
            impatience: 0,
            detour: 0,
            until_s: 0.0,
            performed: 0,
        };
        Ok(Self {
            world: world.clone(),
            characters: Characters::new_laid(motion_set, config.characters, &scheduled_clips)?,
            states: starts.iter().map(state).collect(),
            chains: Chains::new(starts.len()),
            paths: Paths::new(starts.len(), config.max_path),
            reservations,
            planner: Planner::new(graph),
            offers: offers::by_tag(graph),
            rate_hz: motion_set.rate_hz,
            time_s: 0.0,
            config,
        })
    }

    /// Moves everybody on by `dt_s` on this thread. Allocates nothing.
    ///
    /// # Errors
    /// [`InhabitantsError`] where `dt_s` is not in `0..=1`; nothing has moved then.
    pub fn step(&mut self, dt_s: f32) -> Result<(), InhabitantsError> {
        self.step_on(dt_s, &Inline)
    }

    /// As [`Inhabitants::step`], on threads of the caller's choice. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Inhabitants::step`].
    pub fn step_on(&mut self, dt_s: f32, run: &dyn Run) -> Result<(), InhabitantsError> {
        let world = self.world.clone();
        self.control(&world, dt_s)?;
        Ok(self.characters.step_on(world.motion_set(), dt_s, &[], run)?)
    }

    /// The world that they live in.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.states.len()
    }

    /// Their bodies: roots, poses, contacts.
    pub fn characters(&self) -> &Characters {
        &self.characters
    }

    /// What can be told of a character (character < num_characters).
    pub fn status(&self, character: usize) -> Status {
        let m = &self.states[character];
        let waited_s = m.refused_s.map_or(0.0, |since| (self.time_s - since) as f32);
        Status { node: m.at, wish: m.wish, doing: m.doing, num_fulfilled: m.num_fulfilled, waited_s }
    }

    /// Steps that a character is sure to take after the present one: what they need is held.
    /// (character < num_characters)
    pub fn reserved(&self, character: usize) -> &[Step] {
        self.chains.of(character)
    }

    /// Steps of its path that a character has not begun yet, as far as they are kept; empty where it has none.
    /// (character < num_characters)
    pub fn path(&self, character: usize) -> &[Step] {
        self.paths.of(character)
    }

    /// What was found when a character's path was planned last (character < num_characters).
    pub fn plan(&self, character: usize) -> Option<&Plan> {
        self.paths.plan(character)
    }

    /// Who holds a unit (unit < number of units).
    pub fn holder(&self, unit: u32) -> Option<u32> {
        self.reservations.of(unit)
    }

    /// Units that a character holds (character < num_characters).
    pub fn held(&self, character: usize) -> impl Iterator<Item = u32> + '_ {
        self.reservations.units(character as u32)
    }

    /// Gives a character something else to do, from the end of what it is sure to do on.
    ///
    /// # Errors
    /// [`InhabitantsError`] for a character, instance or tag that does not exist, or a place where nobody can stay;
    /// nothing has changed then.
    pub fn set_wish(&mut self, character: usize, wish: Wish) -> Result<(), InhabitantsError> {
        check_index("character", character, self.states.len())?;
        let target = self.target_of(self.world.graph(), character, wish)?;
        self.paths.forget(character, target);
        let state = &mut self.states[character];
        state.wish = wish;
        state.doing = if wish == Wish::Roam { Doing::Roaming } else { Doing::Planning };
        (state.detour, state.until_s, state.impatience) = (0, 0.0, 0);
        (state.performed, state.refused_s) = (0, None);
        if wish != Wish::Roam {
            self.paths.ask(character);
        }
        Ok(())
    }

    /// Where a wish leads; none for roaming.
    fn target_of(&self, graph: &WorldGraph, character: usize, wish: Wish) -> Result<Option<Target>, InhabitantsError> {
        match wish {
            Wish::Roam => Ok(None),
            Wish::GoTo { instance } => {
                check_index("instance", instance as usize, graph.num_instances())?;
                match graph.rest_cells(instance).next() {
                    Some(_) => Ok(Some(Target::Rest { instance })),
                    None => Err(InhabitantsError::Nowhere { what: "stay", instance }),
                }
            }
            Wish::GoToPlace { place } => {
                let nearest = place.is_finite().then(|| graph.nearest_rest(place)).flatten();
                let value =
                    InhabitantsError::Value { what: "place", got: f32::NAN, expected: "finite, in a world to stay in" };
                nearest.map(|node| Some(Target::Node(node))).ok_or(value)
            }
            Wish::Perform { tag, seconds } => {
                if !(0.0..1e9).contains(&seconds) {
                    let expected = "not negative and below 1e9";
                    return Err(InhabitantsError::Value { what: "seconds", got: seconds, expected });
                }
                let instance = self.nearest_offer(graph, character, tag).ok_or(InhabitantsError::NoTag { tag })?;
                Ok(Some(Target::Tag { instance, tag }))
            }
        }
    }
}

fn check_node(graph: &WorldGraph, node: Node) -> Result<(), InhabitantsError> {
    check_index("instance", node.instance as usize, graph.num_instances())?;
    check_index("cell", node.cell as usize, graph.num_cells(node.instance) as usize)
}

fn check_index(what: &'static str, got: usize, limit: usize) -> Result<(), InhabitantsError> {
    if got < limit { Ok(()) } else { Err(InhabitantsError::Index { what, got, limit }) }
}
