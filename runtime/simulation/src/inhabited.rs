//! People who live in a stitched world and wish one thing after another.

use crate::compile::CompiledScene;
use crate::kind::{Kind, Tick, joints, load_same, refused};
use crate::scene::{ANY_PARTNER, Scene, WeightedWish, WishConfig};
use crate::{Event, Happened};
use glam::Vec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;
use throng_base::ground::Held;
use throng_base::{Bytes, Error, Id, Result, SnapshotKind};
use throng_core::{Cast, Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_world::inhabitants::{
    Doing, InhabitantEvent, InhabitantState, Inhabitants, InhabitantsConfig, Wish, scatter,
};
use throng_world::{Node, WorldGraph};

/// Longest that somebody looks for another one who wishes the same (s).
const LOOKS_S: f64 = 30.0;
/// Others are asked who are no farther away (m), and heights count so many times.
const NEAR_M: f32 = 15.0;
const FLOOR: f32 = 5.0;
/// Who finds nobody looks again so much later (s).
const AGAIN_S: f64 = 1.0;
/// Longest that somebody looks for what cannot be reached before it wishes something else (s).
const GIVE_UP_S: f64 = 2.0;

/// Wishes, around a snapshot of [`Inhabitants`].
const WISHES: SnapshotKind = SnapshotKind { what: "inhabitants", tag: *b"WISH", version: 3, setup: 0 };

/// A wish as it is drawn: a kind, and what it needs.
#[derive(Clone, Debug)]
enum Choice {
    Roam([f64; 2]),
    Visit(Vec<Node>),
    Perform(u16, [f64; 2]),
    /// With anybody, or with somebody of a range of characters.
    Meet(u16, [f64; 2], Option<Range<usize>>),
}

/// Somebody wishes to do something with another one, and roams until there is one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Want {
    tag: u16,
    seconds: f32,
    with: Option<Range<usize>>,
    /// When it looks again (s).
    look_s: f64,
}

/// What a snapshot has of all: of [`Inhabited`] the fields that are not of the scene.
type Minds = (Vec<Pcg64Mcg>, Vec<f64>, Vec<bool>, Vec<Option<Want>>, Vec<Option<usize>>);

/// What can be wished for, and how often beside the others.
type Shares = Vec<(f64, Choice)>;

/// The characters of one world, who get a new wish whenever the last one is fulfilled.
#[derive(Clone, Debug)]
pub struct Inhabited {
    scene: Arc<Scene>,
    /// What messages call them.
    key: String,
    inhabitants: Inhabitants,
    /// What the characters of each group draw, by their shares.
    choices: Vec<(Range<usize>, Shares)>,
    /// What each character draws its wishes from.
    rngs: Vec<Pcg64Mcg>,
    /// When each character wishes something else, whatever has become of its wish (s).
    until_s: Vec<f64>,
    /// Who was told what to do, and wishes nothing of its own.
    told: Vec<bool>,
    /// Who wishes to do something with another one.
    wants: Vec<Option<Want>>,
    /// With whom each did something last; somebody else is asked first.
    partners: Vec<Option<usize>>,
}

impl Inhabited {
    /// Puts the characters of the groups of one world in place.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] where the world has room for fewer, or for a box in which nobody can stay.
    pub(crate) fn new(compiled: &CompiledScene, groups: &[usize]) -> Result<Self> {
        let (scene, first) = (compiled.shared(), groups[0]);
        let key = format!("groups[{first}]");
        let Some(world) = compiled.world(first).map(|w| &w.world) else {
            return Err(scene.fault(&key, "expected a `world`"));
        };
        let num: usize = groups.iter().map(|&g| scene.groups[g].count).sum();
        let starts = scatter(world.graph(), num, scene.seed);
        if starts.len() < num {
            let help = match starts.len() {
                0 => {
                    "nobody can stay anywhere in the world, as none of its motion rests in place; add clips that stand still \
                      on it for a second and go on, and stitch it again"
                }
                _ => "each needs units of its own to stand on; ask for fewer characters, or enlarge the world",
            };
            let why = format!("expected room for {num} characters, found room for {}: {help}", starts.len());
            return Err(scene.fault(&format!("{key}.count"), why));
        }
        let (mut choices, mut rngs, mut counted) = (Vec::new(), Vec::with_capacity(num), 0);
        let mut ranges: Vec<(usize, Range<usize>)> = Vec::new();
        for &g in groups {
            ranges.push((g, counted..counted + scene.groups[g].count));
            counted += scene.groups[g].count;
        }
        for (g, range) in ranges.iter().cloned() {
            let numbers = compiled.first_number(g) as u64..;
            let rng = |number: u64| Pcg64Mcg::seed_from_u64(scene.seed ^ number.wrapping_mul(0x9E37_79B9_7F4A_7C15));
            rngs.extend(numbers.map(rng).take(scene.groups[g].count));
            choices.push((range, choices_of(compiled, g, world.graph(), &ranges)?));
        }
        let fault = |e: Error| scene.fault(&key, format!("{e}; correct the scene file, or stitch the world again"));
        let mut config = InhabitantsConfig::default();
        config.characters.first_number = compiled.first_number(first) as u64;
        let mut inhabitants = Inhabitants::new(world, num, config).map_err(fault)?;
        starts.into_iter().try_for_each(|start| inhabitants.spawn(start).map(|_| ())).map_err(fault)?;
        for (choices, (g, _)) in choices.iter().map(|(_, c)| c).zip(&ranges) {
            let unoffered = |c: &(f64, Choice)| matches!(c.1, Choice::Meet(tag, ..) if !inhabitants.offers_pair(tag));
            if let Some(i) = choices.iter().position(unoffered) {
                let why = "expected motion of two that the world has room for; lay two panels of ground side by side, with nothing between";
                return Err(scene.fault(&format!("groups[{g}].wishes[{i}].wish.perform.with"), why));
            }
        }
        let mut life = Self {
            scene: Arc::clone(scene),
            key: key.clone(),
            until_s: vec![0.0; num],
            told: vec![false; num],
            wants: vec![None; num],
            partners: vec![None; num],
            inhabitants,
            choices,
            rngs,
        };
        life.wish(0.0).map_err(fault)?;
        Ok(life)
    }

    /// The characters: what they do, hold and plan.
    pub fn inhabitants(&self) -> &Inhabitants {
        &self.inhabitants
    }

    /// The world that they live in.
    pub fn graph(&self) -> &WorldGraph {
        self.inhabitants.world().graph()
    }

    /// Tells a character what to do, until it is told something else; none lets it wish by itself again.
    ///
    /// # Errors
    /// What the character cannot do; nothing has changed then.
    pub fn tell(&mut self, character: usize, wish: Option<Wish>) -> Result<()> {
        let told = self.inhabitants.order(self.id(character), wish.unwrap_or_default());
        told.map_err(|e| self.scene.fault(&self.key, e))?;
        self.told[character] = wish.is_some();
        self.wants[character] = None;
        // Its next own wish comes with the next step.
        self.until_s[character] = 0.0;
        Ok(())
    }

    /// What a character does, and where (character < number of characters).
    pub fn state(&self, character: usize) -> InhabitantState {
        self.inhabitants.state(self.id(character)).unwrap_or_else(|e| unreachable!("nobody leaves: {e}"))
    }

    /// The inhabitant of a number (character < number of characters); nobody leaves.
    fn id(&self, character: usize) -> Id {
        self.inhabitants.ids()[character]
    }

    /// True for who was told what to do (character < number of characters).
    pub fn is_told(&self, character: usize) -> bool {
        self.told[character]
    }

    /// Gives a new wish to all whose time has come or who have what they wished for.
    fn wish(&mut self, now_s: f64) -> Result<()> {
        for c in 0..self.num_characters() {
            if self.told[c] {
                continue;
            }
            let doing = self.state(c).doing;
            if doing == Doing::Unreachable {
                self.until_s[c] = self.until_s[c].min(now_s + GIVE_UP_S);
            }
            if doing == Doing::Arrived || now_s >= self.until_s[c] {
                let (wish, want, until_s) = self.draw(c, now_s);
                (self.until_s[c], self.wants[c]) = (until_s, want);
                match self.inhabitants.order(self.id(c), wish) {
                    // It draws again at the next step.
                    Err(Error::NoWay { .. }) => self.until_s[c] = now_s,
                    told => told?,
                }
            }
        }
        Ok(())
    }

    /// Brings those together who wish to do the same with each other, or who roam and sometimes wish it.
    fn match_partners(&mut self, now_s: f64) -> Result<()> {
        for c in 0..self.num_characters() {
            let Some(want) = self.wants[c].as_ref().filter(|w| now_s >= w.look_s) else { continue };
            let place = |c: usize| self.graph().place(self.state(c).node).translation();
            // Stairs between floors are a long way.
            let away = |o: usize| ((place(o) - place(c)) * Vec3::new(1.0, FLOOR, 1.0)).length();
            let others = (0..self.num_characters()).filter(|&o| o != c && self.accepts(o, c, want) && away(o) < NEAR_M);
            let last = |o: usize| self.partners[c] == Some(o);
            let found = others.min_by(|&a, &b| last(a).cmp(&last(b)).then(away(a).total_cmp(&away(b))));
            let (tag, seconds) = (want.tag, want.seconds);
            let met = found.map(|o| (o, self.inhabitants.meet([self.id(c), self.id(o)], tag, seconds)));
            match met {
                Some((o, Ok(()))) => {
                    for (c, o) in [(c, o), (o, c)] {
                        (self.wants[c], self.until_s[c], self.partners[c]) = (None, f64::INFINITY, Some(o));
                    }
                }
                None | Some((_, Err(Error::Occupied { .. }))) => {
                    if let Some(want) = &mut self.wants[c] {
                        want.look_s = now_s + AGAIN_S;
                    }
                }
                Some((_, Err(e))) => return Err(e),
            }
        }
        Ok(())
    }

    /// True where a character does with another one what that one wants, if that one wants it with such a character.
    fn accepts(&self, character: usize, other: usize, want: &Want) -> bool {
        if self.told[character] || want.with.as_ref().is_some_and(|range| !range.contains(&character)) {
            return false;
        }
        let suits = |with: &Option<Range<usize>>| with.as_ref().is_none_or(|range| range.contains(&other));
        if let Some(own) = &self.wants[character] {
            return own.tag == want.tag && suits(&own.with);
        }
        let would = |c: &(f64, Choice)| matches!(&c.1, Choice::Meet(tag, _, with) if *tag == want.tag && suits(with));
        let own = self.choices.iter().find(|c| c.0.contains(&character));
        self.state(character).wish == Wish::Roam && own.is_some_and(|(_, choices)| choices.iter().any(would))
    }

    /// Something to wish, alone or with another one, and when it is over at the latest (s).
    fn draw(&mut self, character: usize, now_s: f64) -> (Wish, Option<Want>, f64) {
        let own = self.choices.iter().find(|c| c.0.contains(&character));
        let Some((_, choices)) = own else { return (Wish::Roam, None, f64::INFINITY) };
        let total: f64 = choices.iter().map(|k| k.0).sum();
        let rng = &mut self.rngs[character];
        let mut at = rng.random_range(0.0..total);
        let found = choices.iter().find(|k| {
            at -= k.0;
            at < 0.0
        });
        match &found.unwrap_or(&choices[choices.len() - 1]).1 {
            Choice::Roam(seconds) => (Wish::Roam, None, now_s + within(*seconds, rng)),
            Choice::Visit(places) => {
                let node = places[rng.random_range(0..places.len())];
                (Wish::GoTo { instance: node.instance }, None, f64::INFINITY)
            }
            Choice::Perform(tag, seconds) => {
                let seconds = within(*seconds, rng) as f32;
                (Wish::Perform { tag: *tag, seconds }, None, f64::INFINITY)
            }
            Choice::Meet(tag, seconds, with) => {
                let seconds = within(*seconds, rng) as f32;
                let want = Want { tag: *tag, seconds, with: with.clone(), look_s: now_s };
                (Wish::Roam, Some(want), now_s + LOOKS_S)
            }
        }
    }
}

/// What the characters of a group draw.
///
/// - `ranges`: the characters of each group of the world.
fn choices_of(
    compiled: &CompiledScene,
    group: usize,
    graph: &WorldGraph,
    ranges: &[(usize, Range<usize>)],
) -> Result<Shares> {
    let scene = compiled.scene();
    let roaming = [WeightedWish::roaming()];
    let wishes: &[WeightedWish] = match &scene.groups[group].wishes[..] {
        [] => &roaming,
        own => own,
    };
    let choice = |(i, w): (usize, &WeightedWish)| match &w.wish {
        WishConfig::Roam { seconds } => Ok((w.share, Choice::Roam(*seconds))),
        WishConfig::Perform { tag, seconds, with } => {
            let tags = &compiled.bundle(group)?.meta().link_tags;
            let number = tags.iter().position(|t| t == tag).unwrap_or(0) as u16 + 1;
            let Some(with) = with else { return Ok((w.share, Choice::Perform(number, *seconds))) };
            let whom = ranges.iter().find(|(g, _)| scene.groups[*g].name == *with).map(|(_, range)| range.clone());
            if whom.is_none() && with != ANY_PARTNER {
                let key = format!("groups[{group}].wishes[{i}].wish.perform.with");
                return Err(scene.fault(&key, format!("expected a group that lives in the same world, found `{with}`")));
            }
            Ok((w.share, Choice::Meet(number, *seconds, whom)))
        }
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
                let within = within.map_or_else(String::new, |area| format!(" within {area:?}"));
                let why = format!("expected a place to stay{within}, found none; enlarge it");
                return Err(scene.fault(&format!("groups[{group}].wishes[{i}].wish.visit.within"), why));
            }
            Ok((w.share, Choice::Visit(places)))
        }
    };
    wishes.iter().enumerate().map(choice).collect()
}

/// A time between two.
fn within([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    low + (high - low) * rng.random_range(0.0..1.0)
}

impl Kind for Inhabited {
    fn num_characters(&self) -> usize {
        self.inhabitants.ids().len()
    }

    fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()> {
        let moved = self
            .wish(tick.until_s)
            .and_then(|()| self.match_partners(tick.until_s))
            .and_then(|()| self.inhabitants.step(tick.dt_s, tick.run));
        moved.map_err(|e| self.scene.fault(&self.key, e))?;
        for (id, _) in self.inhabitants.events().iter().filter(|(_, event)| *event == InhabitantEvent::Fulfilled) {
            events.push(Event { time_s: tick.until_s, who: tick.first + id.index(), happened: Happened::Fulfilled });
        }
        Ok(())
    }

    fn hold(&mut self, out: &mut Held) {
        self.inhabitants.hold_ground(out);
    }

    fn mind<'a>(&mut self, others: impl Iterator<Item = &'a Held>) {
        self.inhabitants.mind(others);
    }

    fn save(&self, out: &mut Vec<u8>) {
        let mut inhabitants = Bytes::default();
        self.inhabitants.save(&mut inhabitants.0);
        let minds = (&self.rngs, &self.until_s, &self.told, &self.wants, &self.partners);
        WISHES.write(&(minds, inhabitants), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let (minds, inhabitants): (_, Bytes) = WISHES.read_all(bytes)?;
        let (rngs, until_s, told, wants, partners): Minds = minds;
        let num = self.until_s.len();
        let is_sound = |w: &Want| {
            let in_range = w.with.as_ref().is_none_or(|r| r.start <= r.end && r.end <= num);
            in_range && w.look_s.is_finite() && (0.0..1e9).contains(&w.seconds) && self.inhabitants.offers_pair(w.tag)
        };
        let are_sound = until_s.iter().all(|t| !t.is_nan()) && wants.iter().flatten().all(is_sound);
        let lengths = [rngs.len(), until_s.len(), told.len(), wants.len(), partners.len()];
        if lengths != [num; 5] || !are_sound || partners.iter().flatten().any(|&o| o >= num) {
            return Err(refused(WISHES.what, "somebody wishes what nobody can"));
        }
        load_same(&mut self.inhabitants, &inhabitants.0)?;
        (self.rngs, self.until_s, self.told, self.wants, self.partners) = (rngs, until_s, told, wants, partners);
        Ok(())
    }

    fn root(&self, number: usize) -> Option<Planar> {
        Some(self.inhabitants.characters().root(number))
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        Some(joints(self.inhabitants.characters().pose(number)))
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.inhabitants.characters().contacts(number)
    }
}
