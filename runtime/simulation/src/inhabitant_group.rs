//! Characters that live in a stitched world and pursue one goal after another.

use crate::motion_kind::{GroupStep, MotionKind, check_snapshot, load_same, saved_bytes, single_pose};
use crate::scene::{ANY_PARTNER, GoalConfig, InhabitantGoalConfig, Scene, WeightedGoal};
use crate::{CharacterEvent, SimulationEvent, compile::CompiledScene};
use glam::{Vec2, Vec3};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};
use std::{ops::Range, sync::Arc};
use throng_base::{Bytes, Error, Id, Result, SnapshotKind, ground::ReservedRegion};
use throng_core::{CharacterGroup, Contacts, Mat3x4, NUM_JOINTS, Planar};
use throng_world::inhabitants::{
    InhabitantActivity, InhabitantEvent, InhabitantGoal, InhabitantState, Inhabitants, InhabitantsConfig,
    scatter_rest_nodes,
};
use throng_world::{WorldGraph, WorldNode};

/// Longest time for which a character looks for a partner with the same goal (s).
const SEARCH_S: f64 = 30.0;
/// Largest distance of a partner (m), and factor by which differences in height count more.
const NEAR_M: f32 = 15.0;
const HEIGHT_FACTOR: f32 = 5.0;
/// Time until a character that finds no partner looks again (s).
const SEARCH_AGAIN_S: f64 = 1.0;
/// Longest time for which a character pursues a goal that cannot be reached, before it takes another one (s).
const GIVE_UP_S: f64 = 2.0;

/// Snapshot of goals, around one of [`Inhabitants`].
const GOALS: SnapshotKind = SnapshotKind { what: "inhabitants", tag: *b"WISH", version: 3, setup: 0 };

/// Kind of a goal that can be drawn, with its parameters.
#[derive(Clone, Debug)]
enum GoalChoice {
    Roam([f64; 2]),
    Visit(Vec<WorldNode>),
    /// Goes to one of some places, and stays there.
    Stay(Vec<WorldNode>),
    Perform(u16, [f64; 2]),
    /// Does something with any partner, or with one of a range of characters.
    Meet(u16, [f64; 2], Option<Range<usize>>),
}

/// Search for a partner: the character roams until it has found one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct PartnerRequest {
    tag: u16,
    seconds: f32,
    with: Option<Range<usize>>,
    /// Time of the next search (s).
    look_s: f64,
}

/// State of [`InhabitantGroup`] that a snapshot holds: all fields that do not come from the scene.
type SavedGoals = (Vec<Pcg64Mcg>, Vec<f64>, Vec<bool>, Vec<Option<PartnerRequest>>, Vec<Option<usize>>);

/// Choices of goals with their weights.
type WeightedChoices = Vec<(f64, GoalChoice)>;

/// Characters of one world, which get a new goal whenever the last one is reached.
#[derive(Clone, Debug)]
pub struct InhabitantGroup {
    scene: Arc<Scene>,
    /// Key of their first group in the scene file, for messages.
    key: String,
    inhabitants: Inhabitants,
    /// Weighted choices of goals of each group's characters.
    choices: Vec<(Range<usize>, WeightedChoices)>,
    /// Random numbers of each character, from which its goals are drawn.
    rngs: Vec<Pcg64Mcg>,
    /// Time at which each character takes another goal, whether it has reached the last one or not (s).
    until_s: Vec<f64>,
    /// Whether each character was ordered what to do, and draws no goal of its own.
    ordered: Vec<bool>,
    /// Search for a partner of each character.
    partner_requests: Vec<Option<PartnerRequest>>,
    /// Last partner of each character; others are asked first.
    partners: Vec<Option<usize>>,
}

impl InhabitantGroup {
    /// Creates the characters of the groups of one world.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] where the world has room for fewer, or for a box without a place to stay.
    pub(crate) fn new(compiled: &CompiledScene, groups: &[usize]) -> Result<Self> {
        let (scene, first) = (&compiled.scene, groups[0]);
        let key = format!("groups[{first}]");
        let Some(world) = compiled.world(first).map(|w| &w.world) else {
            return Err(scene.fault(&key, "expected a `world`"));
        };
        let num: usize = groups.iter().map(|&g| scene.groups[g].count).sum();
        let starts = scatter_rest_nodes(world.graph(), num, scene.seed);
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
        let mut range = |&g: &usize| {
            counted += scene.groups[g].count;
            (g, counted - scene.groups[g].count..counted)
        };
        let ranges: Vec<(usize, Range<usize>)> = groups.iter().map(&mut range).collect();
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
            let unoffered =
                |c: &(f64, GoalChoice)| matches!(c.1, GoalChoice::Meet(tag, ..) if !inhabitants.offers_pair(tag));
            if let Some(i) = choices.iter().position(unoffered) {
                let why = "expected motion of two that the world has room for; lay two panels of ground side by side, with nothing between";
                return Err(scene.fault(&format!("groups[{g}].goals[{i}].goal.perform.with"), why));
            }
        }
        let mut life = Self {
            scene: Arc::clone(scene),
            key: key.clone(),
            until_s: vec![0.0; num],
            ordered: vec![false; num],
            partner_requests: vec![None; num],
            partners: vec![None; num],
            inhabitants,
            choices,
            rngs,
        };
        life.draw_goals(0.0).map_err(fault)?;
        Ok(life)
    }

    /// Characters: their actions, reservations and plans.
    pub fn inhabitants(&self) -> &Inhabitants {
        &self.inhabitants
    }

    /// The world that they live in.
    pub fn graph(&self) -> &WorldGraph {
        self.inhabitants.world().graph()
    }

    /// Orders a goal of a character until the next order; `None` lets it draw its own goals again.
    ///
    /// # Errors
    /// A goal that the character cannot pursue; nothing has changed then.
    pub fn order_goal(&mut self, character: usize, goal: Option<InhabitantGoal>) -> Result<()> {
        let result = self.inhabitants.order(self.id(character), goal.unwrap_or_default());
        result.map_err(|e| self.scene.fault(&self.key, e))?;
        self.ordered[character] = goal.is_some();
        self.partner_requests[character] = None;
        // Its next own goal is drawn in the next step.
        self.until_s[character] = 0.0;
        Ok(())
    }

    /// Activity of a character, and its place (character < number of characters).
    pub fn state(&self, character: usize) -> InhabitantState {
        self.inhabitants.state(self.id(character)).unwrap_or_else(|e| unreachable!("nobody leaves: {e}"))
    }

    /// Id of an inhabitant (character < number of characters); inhabitants never leave.
    fn id(&self, character: usize) -> Id {
        self.inhabitants.ids()[character]
    }

    /// True for a character that follows an order (character < number of characters).
    pub fn is_ordered(&self, character: usize) -> bool {
        self.ordered[character]
    }

    /// Draws a new goal for all characters that have reached theirs or whose time is over.
    fn draw_goals(&mut self, now_s: f64) -> Result<()> {
        for c in 0..self.num_characters() {
            if self.ordered[c] {
                continue;
            }
            let doing = self.state(c).activity;
            if doing == InhabitantActivity::Arrived && self.until_s[c] == f64::INFINITY && self.stays(c) {
                continue;
            }
            if doing == InhabitantActivity::Unreachable {
                self.until_s[c] = self.until_s[c].min(now_s + GIVE_UP_S);
            }
            if doing == InhabitantActivity::Arrived || now_s >= self.until_s[c] {
                let (goal, want, until_s) = self.draw_goal(c, now_s);
                (self.until_s[c], self.partner_requests[c]) = (until_s, want);
                match self.inhabitants.order(self.id(c), goal) {
                    // The character draws again at the next step.
                    Err(Error::NoPath { .. }) => self.until_s[c] = now_s,
                    result => result?,
                }
            }
        }
        Ok(())
    }

    /// True for a character that stays at its goal.
    fn stays(&self, character: usize) -> bool {
        let own = self.choices.iter().find(|c| c.0.contains(&character));
        !self.ordered[character] && own.is_some_and(|(_, choices)| matches!(choices[..], [(_, GoalChoice::Stay(_))]))
    }

    /// Matches characters that look for a partner with others that look for the same, or that roam and may draw the same goal.
    fn match_partners(&mut self, now_s: f64) -> Result<()> {
        for c in 0..self.num_characters() {
            let Some(want) = self.partner_requests[c].as_ref().filter(|w| now_s >= w.look_s) else { continue };
            let place = |c: usize| self.graph().place(self.state(c).node).translation();
            // Paths by stairs between floors are long.
            let away = |o: usize| ((place(o) - place(c)) * Vec3::new(1.0, HEIGHT_FACTOR, 1.0)).length();
            let others =
                (0..self.num_characters()).filter(|&o| o != c && self.accepts_partner(o, c, want) && away(o) < NEAR_M);
            let last = |o: usize| self.partners[c] == Some(o);
            let found = others.min_by(|&a, &b| last(a).cmp(&last(b)).then(away(a).total_cmp(&away(b))));
            let (tag, seconds) = (want.tag, want.seconds);
            let met = found.map(|o| (o, self.inhabitants.order_meeting([self.id(c), self.id(o)], tag, seconds)));
            match met {
                Some((o, Ok(()))) => {
                    for (c, o) in [(c, o), (o, c)] {
                        (self.partner_requests[c], self.until_s[c], self.partners[c]) = (None, f64::INFINITY, Some(o));
                    }
                }
                None | Some((_, Err(Error::Occupied { .. }))) => {
                    if let Some(want) = &mut self.partner_requests[c] {
                        want.look_s = now_s + SEARCH_AGAIN_S;
                    }
                }
                Some((_, Err(e))) => return Err(e),
            }
        }
        Ok(())
    }

    /// True where a character accepts the request of another one.
    fn accepts_partner(&self, character: usize, other: usize, want: &PartnerRequest) -> bool {
        if self.ordered[character] || want.with.as_ref().is_some_and(|range| !range.contains(&character)) {
            return false;
        }
        let suits = |with: &Option<Range<usize>>| with.as_ref().is_none_or(|range| range.contains(&other));
        if let Some(own) = &self.partner_requests[character] {
            return own.tag == want.tag && suits(&own.with);
        }
        let would =
            |c: &(f64, GoalChoice)| matches!(&c.1, GoalChoice::Meet(tag, _, with) if *tag == want.tag && suits(with));
        let own = self.choices.iter().find(|c| c.0.contains(&character));
        self.state(character).goal == InhabitantGoal::Roam && own.is_some_and(|(_, choices)| choices.iter().any(would))
    }

    /// Draws a goal, with a search for a partner where it needs one, and the time when it ends at the latest (s).
    fn draw_goal(&mut self, character: usize, now_s: f64) -> (InhabitantGoal, Option<PartnerRequest>, f64) {
        let own = self.choices.iter().find(|c| c.0.contains(&character));
        let Some((_, choices)) = own else { return (InhabitantGoal::Roam, None, f64::INFINITY) };
        let total: f64 = choices.iter().map(|k| k.0).sum();
        let rng = &mut self.rngs[character];
        let mut at = rng.random_range(0.0..total);
        let found = choices.iter().find(|k| {
            at -= k.0;
            at < 0.0
        });
        match &found.unwrap_or(&choices[choices.len() - 1]).1 {
            GoalChoice::Roam(seconds) => (InhabitantGoal::Roam, None, now_s + random_duration(*seconds, rng)),
            GoalChoice::Visit(places) | GoalChoice::Stay(places) => {
                let node = places[rng.random_range(0..places.len())];
                (InhabitantGoal::GoTo { instance: node.instance }, None, f64::INFINITY)
            }
            GoalChoice::Perform(tag, seconds) => {
                let seconds = random_duration(*seconds, rng) as f32;
                (InhabitantGoal::Perform { tag: *tag, seconds }, None, f64::INFINITY)
            }
            GoalChoice::Meet(tag, seconds, with) => {
                let seconds = random_duration(*seconds, rng) as f32;
                let want = PartnerRequest { tag: *tag, seconds, with: with.clone(), look_s: now_s };
                (InhabitantGoal::Roam, Some(want), now_s + SEARCH_S)
            }
        }
    }
}

/// Weighted choices of goals of a group's characters.
///
/// - `ranges`: the characters of each group of the world.
fn choices_of(
    compiled: &CompiledScene,
    group: usize,
    graph: &WorldGraph,
    ranges: &[(usize, Range<usize>)],
) -> Result<WeightedChoices> {
    let scene = compiled.scene();
    if let Some(goal) = &scene.groups[group].goal {
        let choice = choice_of_goal(goal, graph, scene.groups[group].count);
        let fault = || scene.fault(&format!("groups[{group}].goal"), "expected a place to stay there, found none");
        return Ok(vec![(1.0, choice.ok_or_else(fault)?)]);
    }
    let roaming = [WeightedGoal::roaming()];
    let goals: &[WeightedGoal] = match &scene.groups[group].goals[..] {
        [] => &roaming,
        own => own,
    };
    let choice = |(i, w): (usize, &WeightedGoal)| match &w.goal {
        InhabitantGoalConfig::Roam { seconds } => Ok((w.share, GoalChoice::Roam(*seconds))),
        InhabitantGoalConfig::Perform { tag, seconds, with } => {
            let tags = &compiled.bundle(group)?.meta().link_tags;
            let number = tags.iter().position(|t| t == tag).unwrap_or(0) as u16 + 1;
            let Some(with) = with else { return Ok((w.share, GoalChoice::Perform(number, *seconds))) };
            let whom = ranges.iter().find(|(g, _)| scene.groups[*g].name == *with).map(|(_, range)| range.clone());
            if whom.is_none() && with != ANY_PARTNER {
                let key = format!("groups[{group}].goals[{i}].goal.perform.with");
                return Err(scene.fault(&key, format!("expected a group that lives in the same world, found `{with}`")));
            }
            Ok((w.share, GoalChoice::Meet(number, *seconds, whom)))
        }
        InhabitantGoalConfig::Visit { within } => {
            let all = (0..graph.num_instances() as u32).flat_map(|i| graph.rest_cells(i));
            let is_in = |n: &WorldNode| {
                let p = graph.place(*n);
                within.is_none_or(|[x0, z0, x1, z1]| {
                    (x0..=x1).contains(&f64::from(p.x)) && (z0..=z1).contains(&f64::from(p.z))
                })
            };
            let places: Vec<WorldNode> = all.filter(is_in).collect();
            if places.is_empty() {
                let within = within.map_or_else(String::new, |area| format!(" within {area:?}"));
                let why = format!("expected a place to stay{within}, found none; enlarge it");
                return Err(scene.fault(&format!("groups[{group}].goals[{i}].goal.visit.within"), why));
            }
            Ok((w.share, GoalChoice::Visit(places)))
        }
    };
    goals.iter().enumerate().map(choice).collect()
}

/// Choice of a goal that all characters of a group have; none where nobody can stay.
///
/// - `num`: number of these characters.
fn choice_of_goal(goal: &GoalConfig, graph: &WorldGraph, num: usize) -> Option<GoalChoice> {
    let place = |node: &WorldNode| graph.place(*node).translation();
    let mut nodes: Vec<WorldNode> = (0..graph.num_instances() as u32).flat_map(|i| graph.rest_cells(i)).collect();
    match goal {
        GoalConfig::Area { from, to } | GoalConfig::Wander { from, to, .. } => nodes.retain(|node| {
            let at = place(node);
            (from[0]..=to[0]).contains(&at.x) && (from[1]..=to[1]).contains(&at.z)
        }),
        GoalConfig::Point { at } => {
            // The nearest places to stay, one for each.
            let far = |node: &WorldNode| Vec2::new(place(node).x, place(node).z).distance_squared(Vec2::from_slice(at));
            nodes.sort_by(|a, b| far(a).total_cmp(&far(b)));
            let mut taken = Vec::new();
            nodes.retain(|node| {
                let is_new = taken.len() < num && !taken.contains(&node.instance);
                taken.extend(is_new.then_some(node.instance));
                is_new
            });
        }
        _ => return None,
    }
    let stays = !matches!(goal, GoalConfig::Wander { .. });
    (!nodes.is_empty()).then_some(if stays { GoalChoice::Stay(nodes) } else { GoalChoice::Visit(nodes) })
}

/// Random duration in a range (s).
fn random_duration([low, high]: [f64; 2], rng: &mut impl Rng) -> f64 {
    low + (high - low) * rng.random_range(0.0..1.0)
}

impl MotionKind for InhabitantGroup {
    fn num_characters(&self) -> usize {
        self.inhabitants.ids().len()
    }

    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
        let moved = self
            .draw_goals(tick.until_s)
            .and_then(|()| self.match_partners(tick.until_s))
            .and_then(|()| self.inhabitants.step(tick.dt_s, tick.run));
        moved.map_err(|e| self.scene.fault(&self.key, e))?;
        let fulfilled = self.inhabitants.events().iter().filter(|(_, event)| *event == InhabitantEvent::Fulfilled);
        events.extend(fulfilled.map(|(id, _)| {
            let kind = if self.stays(id.index()) { CharacterEvent::Arrived } else { CharacterEvent::Fulfilled };
            tick.event(id.index(), kind)
        }));
        Ok(())
    }

    fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        self.inhabitants.add_reserved_regions(out);
    }

    fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        self.inhabitants.set_external_obstacles(others);
    }

    fn save(&self, out: &mut Vec<u8>) {
        let inhabitants = saved_bytes(|out| self.inhabitants.save(out));
        let saved_goals = (&self.rngs, &self.until_s, &self.ordered, &self.partner_requests, &self.partners);
        GOALS.write(&(saved_goals, inhabitants), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let (saved_goals, inhabitants): (_, Bytes) = GOALS.read_all(bytes)?;
        let (rngs, until_s, ordered, requests, partners): SavedGoals = saved_goals;
        let num = self.until_s.len();
        let is_sound = |w: &PartnerRequest| {
            let in_range = w.with.as_ref().is_none_or(|r| r.start <= r.end && r.end <= num);
            in_range && w.look_s.is_finite() && (0.0..1e9).contains(&w.seconds) && self.inhabitants.offers_pair(w.tag)
        };
        let are_sound = until_s.iter().all(|t| !t.is_nan()) && requests.iter().flatten().all(is_sound);
        let lengths = [rngs.len(), until_s.len(), ordered.len(), requests.len(), partners.len()];
        let good = lengths == [num; 5] && are_sound && partners.iter().flatten().all(|&o| o < num);
        check_snapshot(good, GOALS.what, "a goal that no character can have")?;
        load_same(&mut self.inhabitants, &inhabitants.0)?;
        (self.rngs, self.until_s, self.ordered, self.partner_requests, self.partners) =
            (rngs, until_s, ordered, requests, partners);
        Ok(())
    }

    fn root(&self, number: usize) -> Option<Planar> {
        Some(self.inhabitants.characters().root(number))
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        Some(single_pose(self.inhabitants.characters().pose(number)))
    }

    fn contacts(&self, number: usize) -> Contacts {
        self.inhabitants.characters().contacts(number)
    }
}
