//! People who live in a world and wish one thing after another.

use super::config::{WishConfig, WorldScene};
use glam::Vec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use throng_motion::error::BuildError;
use throng_runtime::characters::{CharactersConfig, MotionSet};
use throng_runtime::world::inhabitants::{Doing, Inhabitants, InhabitantsConfig, Wish, scatter};
use throng_runtime::world::{Node, World, WorldGraph};
use throng_runtime::{Bundle, Cast, Error, Id, Inline};

/// Longest that somebody looks for what cannot be reached before it wishes something else (s).
const GIVE_UP_S: f64 = 2.0;

/// A wish as it is drawn: a kind, and what it needs.
#[derive(Clone, Debug)]
enum Kind {
    Roam([f64; 2]),
    Visit(Vec<Node>),
    Perform(u16, [f64; 2]),
}

/// The inhabitants of a scene, who get a new wish whenever the last one is fulfilled.
#[derive(Clone, Debug)]
pub struct Life {
    inhabitants: Inhabitants,
    kinds: Vec<(f64, Kind)>,
    rng: Pcg64Mcg,
    /// When each character wishes something else, whatever has become of its wish (s).
    until_s: Vec<f64>,
    /// Who was told what to do, and wishes nothing of its own.
    told: Vec<bool>,
    time_s: f64,
}

impl WorldScene {
    /// Puts everybody in place.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where the world has room for fewer, for a tag that no motion shows, or for a box in which
    /// nobody can stay.
    pub fn live(&self, tables: &Bundle, motion_set: &MotionSet, graph: &WorldGraph) -> Result<Life, BuildError> {
        let starts = scatter(graph, self.characters, self.seed);
        if starts.len() < self.characters {
            let message = format!(
                "scene \"{}\": expected room for {} characters, found room for {}: each needs units of its own to stand on",
                self.name,
                self.characters,
                starts.len()
            );
            return Err(self.wrong(message, "Ask for fewer characters, or enlarge the world"));
        }
        self.live_at(tables, motion_set, graph, &starts)
    }

    /// Puts characters at starts of their own, whatever their number.
    ///
    /// # Errors
    /// As [`WorldScene::live`], or where nobody can stay at a start or two would share a unit.
    pub fn live_at(
        &self,
        tables: &Bundle,
        _: &MotionSet,
        graph: &WorldGraph,
        starts: &[Node],
    ) -> Result<Life, BuildError> {
        let kinds = self.wishes.iter().map(|w| Ok((w.share, self.kind(&w.wish, tables, graph)?)));
        let kinds = kinds.collect::<Result<Vec<_>, BuildError>>()?;
        let characters = CharactersConfig { seed: self.seed, ..CharactersConfig::default() };
        let config = InhabitantsConfig { characters, ..InhabitantsConfig::default() };
        let world = World::from_graph(graph, tables);
        let mut inhabitants = Inhabitants::new(&world, starts.len(), config).map_err(|e| self.fault(&e))?;
        starts.iter().try_for_each(|&s| inhabitants.spawn(s).map(|_| ())).map_err(|e| self.fault(&e))?;
        let mut life = Life {
            until_s: vec![0.0; inhabitants.ids().len()],
            told: vec![false; inhabitants.ids().len()],
            inhabitants,
            kinds,
            rng: Pcg64Mcg::seed_from_u64(self.seed),
            time_s: 0.0,
        };
        life.wish(graph).map_err(|e| self.fault(&e))?;
        Ok(life)
    }

    fn kind(&self, wish: &WishConfig, tables: &Bundle, graph: &WorldGraph) -> Result<Kind, BuildError> {
        match wish {
            WishConfig::Roam { seconds } => Ok(Kind::Roam(*seconds)),
            WishConfig::Visit { within } => {
                let all = (0..graph.num_instances() as u32).flat_map(|i| graph.rest_cells(i));
                let is_in = |n: &Node| {
                    let p = graph.place(*n);
                    within.is_none_or(|[x0, z0, x1, z1]| {
                        (x0..=x1).contains(&f64::from(p.x)) && (z0..=z1).contains(&f64::from(p.z))
                    })
                };
                let places: Vec<Node> = all.filter(is_in).collect();
                if places.is_empty() {
                    let message =
                        format!("scene \"{}\": expected a place to stay within {within:?}, found none", self.name);
                    return Err(self.wrong(message, "Enlarge `within`"));
                }
                Ok(Kind::Visit(places))
            }
            WishConfig::Perform { tag, seconds } => {
                let tags = &tables.meta().link_tags;
                match tags.iter().position(|t| t == tag) {
                    Some(t) => Ok(Kind::Perform(t as u16 + 1, *seconds)),
                    None => {
                        let message =
                            format!("scene \"{}\": expected one of {}, found `{tag}`", self.name, tags.join(", "));
                        Err(self.wrong(message, "Correct `perform.tag`"))
                    }
                }
            }
        }
    }

    fn fault(&self, e: &Error) -> BuildError {
        self.wrong(format!("scene \"{}\": {e}", self.name), "Correct the scene file, or stitch the world again")
    }

    fn wrong(&self, message: String, help: &str) -> BuildError {
        BuildError::Stage { stage: "scene", message, help: help.into() }
    }
}

impl Life {
    /// Moves everybody on by `dt_s` on this thread.
    ///
    /// # Errors
    /// [`Error`] where `dt_s` is not in `0..=1`, or for another world or motion set.
    pub fn step(&mut self, _: &MotionSet, graph: &WorldGraph, dt_s: f32) -> Result<(), Error> {
        self.wish(graph)?;
        self.inhabitants.step(dt_s, &Inline)?;
        self.time_s += f64::from(dt_s);
        Ok(())
    }

    /// The characters.
    pub fn inhabitants(&self) -> &Inhabitants {
        &self.inhabitants
    }

    /// The characters, to be given other wishes; a wish given so is kept until it is fulfilled.
    pub fn inhabitants_mut(&mut self) -> &mut Inhabitants {
        &mut self.inhabitants
    }

    /// Tells a character what to do, until it is told something else; none lets it wish by itself again.
    ///
    /// # Errors
    /// As [`Cast::order`]; nothing has changed then.
    pub fn tell(&mut self, graph: &WorldGraph, character: usize, wish: Option<Wish>) -> Result<(), Error> {
        self.inhabitants.order(Id::first(character), wish.unwrap_or_default())?;
        self.told[character] = wish.is_some();
        // Its next own wish comes with the next step.
        self.until_s[character] = self.time_s;
        Ok(())
    }

    /// True for who was told what to do (character < number of characters).
    pub fn is_told(&self, character: usize) -> bool {
        self.told[character]
    }

    /// Time since everybody was put in place (s).
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Gives a new wish to all whose time has come or who have what they wished for.
    fn wish(&mut self, graph: &WorldGraph) -> Result<(), Error> {
        for c in 0..self.inhabitants.ids().len() {
            if self.told[c] {
                continue;
            }
            let doing = self.inhabitants.state(Id::first(c))?.doing;
            if doing == Doing::Unreachable {
                self.until_s[c] = self.until_s[c].min(self.time_s + GIVE_UP_S);
            }
            if doing == Doing::Arrived || self.time_s >= self.until_s[c] {
                let (wish, until_s) = self.draw();
                self.until_s[c] = until_s;
                self.inhabitants.order(Id::first(c), wish)?;
            }
        }
        Ok(())
    }

    /// Something to wish, and when it is over at the latest (s).
    fn draw(&mut self) -> (Wish, f64) {
        let total: f64 = self.kinds.iter().map(|k| k.0).sum();
        let mut at = self.rng.random_range(0.0..total);
        let found = self.kinds.iter().find(|k| {
            at -= k.0;
            at < 0.0
        });
        match &found.unwrap_or(&self.kinds[self.kinds.len() - 1]).1 {
            Kind::Roam(seconds) => (Wish::Roam, self.time_s + within(*seconds, &mut self.rng)),
            Kind::Visit(places) => {
                let node = places[self.rng.random_range(0..places.len())];
                (Wish::GoTo { instance: node.instance }, f64::INFINITY)
            }
            Kind::Perform(tag, seconds) => {
                let seconds = within(*seconds, &mut self.rng) as f32;
                (Wish::Perform { tag: *tag, seconds }, f64::INFINITY)
            }
        }
    }
}

/// A time between two.
fn within([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    low + (high - low) * rng.random_range(0.0..1.0)
}

/// Hips and neck of everybody in the world (m).
pub fn trunks(life: &Life) -> Vec<[Vec3; 2]> {
    use throng_runtime::Joint::{Hips, Neck};
    let characters = life.inhabitants().characters();
    let of = |c: usize| {
        let p = characters.joint_positions(c);
        [p[Hips.index()], p[Neck.index()]]
    };
    (0..characters.num_characters()).map(of).collect()
}
