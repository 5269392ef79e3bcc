//! Inhabitants: characters that live in a world, hold the units they need, and go where they wish (004 section 7).

mod chain;
mod config;
mod decide;
mod error;
mod holders;
mod lay;
mod offers;
mod paths;
mod scatter;

pub use config::{Doing, InhabitantsConfig, Status, Wish};
pub use error::InhabitantsError;
pub use scatter::scatter;

use super::plan::{Plan, Planner, Target};
use super::{Node, Step, WorldGraph};
use crate::troupe::{Repertoire, Troupe};
use chain::Chains;
use holders::Holders;
use paths::Paths;

/// What is remembered of an inhabitant.
#[derive(Clone, Copy, Debug)]
struct Mind {
    /// Node that its motion leads to.
    at: Node,
    wish: Wish,
    doing: Doing,
    num_fulfilled: u32,
    /// When it was first refused what it needs, since it last got it. [Unit: s]
    refused_s: Option<f64>,
    /// Random numbers drawn so far.
    draws: u32,
    /// Steps of its path in a row that it was not refused.
    progress: u32,
    /// Times in a row that it lost patience.
    impatience: u32,
    /// Steps of its detour that are left.
    detour: u32,
    /// How long it has done what it was to perform. [Unit: frames]
    performed: u32,
}

/// Characters in a world, with what they wish for; all memory is allocated in [`Inhabitants::new`].
///
/// Each holds the units of the instance it is in, and takes all that it needs up to the next node from which a rest
/// cell can be reached without more. Others keep out of them. Who does not get what it needs goes to rest within what it
/// holds, tries again, and after a while makes a random detour, longer each time.
#[derive(Clone, Debug)]
pub struct Inhabitants {
    config: InhabitantsConfig,
    num_nodes: usize,
    troupe: Troupe,
    minds: Vec<Mind>,
    chains: Chains,
    paths: Paths,
    holders: Holders,
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
    pub fn new(
        repertoire: &Repertoire<'_>,
        graph: &WorldGraph<'_>,
        config: InhabitantsConfig,
        starts: &[Node],
    ) -> Result<Self, InhabitantsError> {
        config.check()?;
        let mut holders = Holders::new(graph.world().units.len(), starts.len());
        let mut courses = Vec::with_capacity(starts.len());
        for (c, &node) in starts.iter().enumerate() {
            check_node(graph, node)?;
            let rest = graph.is_rest(node).then(|| graph.step_to_rest(node)).flatten();
            let Some(course) = rest.and_then(|step| lay::course(graph, repertoire, &step, None)) else {
                return Err(InhabitantsError::Start { character: c, node });
            };
            let units = graph.resources(node.instance);
            let held = units.iter().find_map(|&unit| holders.of(unit).map(|other| (unit, other)));
            if let Some((unit, other)) = held {
                return Err(InhabitantsError::Held { character: c, other: other as usize, unit });
            }
            holders.take(units, c as u32);
            courses.push(course);
        }
        let mind = |&at| Mind {
            at,
            wish: Wish::Roam,
            doing: Doing::Roaming,
            num_fulfilled: 0,
            refused_s: None,
            draws: 0,
            progress: 0,
            impatience: 0,
            detour: 0,
            performed: 0,
        };
        Ok(Self {
            num_nodes: graph.num_nodes(),
            troupe: Troupe::new_laid(repertoire, config.troupe, &courses)?,
            minds: starts.iter().map(mind).collect(),
            chains: Chains::new(starts.len()),
            paths: Paths::new(starts.len(), config.max_path),
            holders,
            planner: Planner::new(graph),
            offers: offers::by_tag(graph),
            rate_hz: repertoire.rate_hz,
            time_s: 0.0,
            config,
        })
    }

    /// Moves everybody on by `dt_s` on this thread. Allocates nothing.
    ///
    /// # Errors
    /// [`InhabitantsError`] where `dt_s` is not in `0..=1`, or the world or repertoire is another one; nothing has moved
    /// then.
    pub fn step(
        &mut self,
        repertoire: &Repertoire<'_>,
        graph: &WorldGraph<'_>,
        dt_s: f32,
    ) -> Result<(), InhabitantsError> {
        self.control(repertoire, graph, dt_s)?;
        Ok(self.troupe.step(repertoire, dt_s, &[])?)
    }

    /// As [`Inhabitants::step`], on the threads of the current rayon pool. The result is the same, bit by bit.
    ///
    /// # Errors
    /// As [`Inhabitants::step`].
    #[cfg(feature = "rayon")]
    pub fn par_step(
        &mut self,
        repertoire: &Repertoire<'_>,
        graph: &WorldGraph<'_>,
        dt_s: f32,
    ) -> Result<(), InhabitantsError> {
        self.control(repertoire, graph, dt_s)?;
        Ok(self.troupe.par_step(repertoire, dt_s, &[])?)
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.minds.len()
    }

    /// Their bodies: roots, poses, contacts.
    pub fn troupe(&self) -> &Troupe {
        &self.troupe
    }

    /// What can be told of a character. [Limit: character < num_characters]
    pub fn status(&self, character: usize) -> Status {
        let m = &self.minds[character];
        let waited_s = m.refused_s.map_or(0.0, |since| (self.time_s - since) as f32);
        Status { node: m.at, wish: m.wish, doing: m.doing, num_fulfilled: m.num_fulfilled, waited_s }
    }

    /// Steps that a character is sure to take after the present one: what they need is held.
    /// [Limit: character < num_characters]
    pub fn reserved(&self, character: usize) -> &[Step] {
        self.chains.of(character)
    }

    /// Steps of its path that a character has not begun yet, as far as they are kept; empty where it has none.
    /// [Limit: character < num_characters]
    pub fn path(&self, character: usize) -> &[Step] {
        self.paths.of(character)
    }

    /// What was found when a character's path was planned last. [Limit: character < num_characters]
    pub fn plan(&self, character: usize) -> Option<&Plan> {
        self.paths.plan(character)
    }

    /// Who holds a unit. [Limit: unit < number of units]
    pub fn holder(&self, unit: u32) -> Option<u32> {
        self.holders.of(unit)
    }

    /// Units that a character holds. [Limit: character < num_characters]
    pub fn held(&self, character: usize) -> impl Iterator<Item = u32> + '_ {
        self.holders.units(character as u32)
    }

    /// Gives a character something else to do, from the end of what it is sure to do on.
    ///
    /// # Errors
    /// [`InhabitantsError`] for a character, instance or tag that does not exist, or a place where nobody can stay;
    /// nothing has changed then.
    pub fn set_wish(&mut self, graph: &WorldGraph<'_>, character: usize, wish: Wish) -> Result<(), InhabitantsError> {
        self.check_world(graph)?;
        check_index("character", character, self.minds.len())?;
        let target = self.target_of(graph, character, wish)?;
        self.paths.forget(character, target);
        let mind = &mut self.minds[character];
        mind.wish = wish;
        mind.doing = if wish == Wish::Roam { Doing::Roaming } else { Doing::Planning };
        (mind.detour, mind.impatience, mind.performed, mind.refused_s) = (0, 0, 0, None);
        if wish != Wish::Roam {
            self.paths.ask(character);
        }
        Ok(())
    }

    fn check_world(&self, graph: &WorldGraph<'_>) -> Result<(), InhabitantsError> {
        match graph.num_nodes() == self.num_nodes {
            true => Ok(()),
            false => Err(InhabitantsError::OtherWorld { expected: self.num_nodes, got: graph.num_nodes() }),
        }
    }

    /// Where a wish leads; none for roaming.
    fn target_of(
        &self,
        graph: &WorldGraph<'_>,
        character: usize,
        wish: Wish,
    ) -> Result<Option<Target>, InhabitantsError> {
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

fn check_node(graph: &WorldGraph<'_>, node: Node) -> Result<(), InhabitantsError> {
    check_index("instance", node.instance as usize, graph.num_instances())?;
    check_index("cell", node.cell as usize, graph.num_cells(node.instance) as usize)
}

fn check_index(what: &'static str, got: usize, limit: usize) -> Result<(), InhabitantsError> {
    if got < limit { Ok(()) } else { Err(InhabitantsError::Index { what, got, limit }) }
}
