//! Characters with policies: each with a target of its own, or in pairs that strike at each other.

use crate::motion_kind::{GroupStep, MotionKind, check_snapshot, load_same, saved_bytes};
use crate::scene::{DragPoint, GroupConfig, GroupMotion, PlaceConfig, Scene};
use crate::sparring::{PracticeConfig, Sparring, SparringConfig, TargetPractice};
use crate::{CharacterEvent, SimulationEvent, compile::CompiledScene};
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::{f32::consts::TAU, sync::Arc};
use throng_base::{Bytes, Error, Id, Result, SnapshotKind};
use throng_base::{error::check_index, ground::ReservedRegion, thresholds::HALF_HEAD_M};
use throng_core::characters::{ActionChoice, AvoidConfig, CharactersConfig, Detail, PolicyOrder, Spawn};
use throng_core::policy::{KIND_CYLINDER, KIND_SPACE_TIME, RegionRecord};
use throng_core::{Bundle, CharacterGroup, Contacts, Mat3x4, NUM_JOINTS, Planar, graph::MotionGraph};

/// Group of sparring pairs.
#[derive(Clone, Debug)]
pub struct Bouts {
    setup: BoxingSetup,
    sparring: Sparring,
}

/// Group of characters that strike at targets of their own.
#[derive(Clone, Debug)]
pub struct Practice {
    setup: BoxingSetup,
    practice: TargetPractice,
    /// Positions at which targets hang while no hand drags them (m).
    homes: Vec<Vec3>,
    /// Whether targets are dragged as the scene says.
    is_dragged: bool,
}

/// Scene and group of characters of either kind.
#[derive(Clone, Debug)]
struct BoxingSetup {
    scene: Arc<Scene>,
    /// Number of the group in the scene.
    group: usize,
    /// Key of the group in the scene file, for messages.
    key: String,
}

impl BoxingSetup {
    fn new(compiled: &CompiledScene, group: usize) -> Self {
        Self { scene: Arc::clone(&compiled.scene), group, key: format!("groups[{group}]") }
    }

    fn config(&self) -> &GroupConfig {
        &self.scene.groups[self.group]
    }

    fn fault(&self, e: Error) -> Error {
        match e {
            Error::Occupied { who, .. } => {
                let why = format!(
                    "character {who} starts where another one or an obstacle is, or on the way there; enlarge \
                     `place.grid.spacing_m` or `distance_m`, or move its `centre`"
                );
                self.scene.fault(&self.key, why)
            }
            e => self.scene.fault(&self.key, e),
        }
    }
}

/// Order with the weighted behaviours of a group, and the numbers of their policies; to approach where it names none.
pub(crate) fn weighted_order(compiled: &CompiledScene, group: usize) -> Result<(PolicyOrder, Vec<usize>)> {
    let (bundle, behaviours) = (compiled.bundle(group)?, &compiled.scene().groups[group].behaviours);
    if behaviours.is_empty() {
        let fault = |e: Error| compiled.scene().fault(&format!("groups[{group}]"), format!("in its bundle, {e}"));
        let policy = bundle.find_policy("approach").map_err(fault)?;
        return Ok((PolicyOrder::IDLE.with_policy(policy, 1.0), vec![policy]));
    }
    let numbers: Vec<usize> = behaviours.iter().map(|b| bundle.find_policy(&b.name)).collect::<Result<_>>()?;
    let weighed = |order: PolicyOrder, (&policy, weight)| order.with_policy(policy, weight);
    let weights = behaviours.iter().map(|b| b.weight as f32);
    Ok((numbers.iter().zip(weights).fold(PolicyOrder::IDLE, weighed), numbers))
}

/// The order in the manner of one of a group's characters, where the group names any.
pub(crate) fn in_own_manner(order: PolicyOrder, group: &GroupConfig, number: usize) -> PolicyOrder {
    let own = group.manners.get(number % group.manners.len().max(1));
    own.map_or(order, |manner| order.in_manner(manner))
}

pub(crate) fn characters_config(compiled: &CompiledScene, group: usize) -> CharactersConfig {
    let choice = ActionChoice::LookAhead { temperature: compiled.scene().groups[group].temperature as f32 };
    let (seed, first_number) = (compiled.scene().seed, compiled.first_number(group) as u64);
    // Opponents are meant to come near each other, until they touch.
    let spars = compiled.scene().groups[group].motion == GroupMotion::Sparring;
    let avoid = Some(AvoidConfig { pairs_m: spars.then_some(PAIR_DEPTH_M), ..AvoidConfig::default() });
    let instances = compiled.scene().groups[group].count > POSED_CHARACTERS;
    let config = CharactersConfig { seed, first_number, choice, avoid, instances, ..CharactersConfig::default() };
    if spars { config.with_boxers_feet() } else { CharactersConfig { carriage: 1.0, ..config } }
}

/// Largest group in which nobody needs a record for GPUs, since all are posed in full.
const POSED_CHARACTERS: usize = 5000;
/// Depth to which opponents may enter each other's discs. A disc covers the head on all sides of the root, and would keep
/// heads farther apart than blows reach (m).
const PAIR_DEPTH_M: f32 = 0.07;

impl Bouts {
    /// Creates the group with all characters in place.
    ///
    /// # Errors
    /// [`Error::Text`] for heads that no blow can reach.
    pub(crate) fn new(compiled: &CompiledScene, group: usize) -> Result<Self> {
        let (setup, bundle) = (BoxingSetup::new(compiled, group), compiled.bundle(group)?);
        let (order, numbers) = weighted_order(compiled, group)?;
        let (starts, _) = start_placements(compiled, group)?;
        let mut config = SparringConfig { characters: characters_config(compiled, group), ..SparringConfig::default() };
        config.stagger.force = setup.config().stagger_force.map_or(config.stagger.force, |force| force as f32);
        let mut sparring = Sparring::with_capacity(bundle, starts.len() / 2, config).map_err(|e| setup.fault(e))?;
        sparring.boxers_mut().hold_entrants();
        sparring.boxers_mut().set_walls(&compiled.scene().environment.walls());
        for pair in starts.as_chunks().0 {
            let first = sparring.spawn(*pair).map_err(|e| setup.fault(e))?;
            for id in [first, sparring.opponent(first)?] {
                sparring.order(id, in_own_manner(order, setup.config(), id.index())).map_err(|e| setup.fault(e))?;
            }
        }
        sparring.boxers_mut().release_entrants();
        let regions = hit_regions(bundle, &numbers);
        match sparring.heads().first() {
            Some(first) if !sparring.heads().iter().any(|h| is_reached(&regions, h.y, HALF_HEAD_M)) => {
                let help = "build the bundle from motion with blows at heads, with `grid.bounds` that hold them";
                Err(setup.scene.fault(&setup.key, unreachable_message(&regions, "head", first.y, help)))
            }
            _ => Ok(Self { setup, sparring }),
        }
    }

    /// The pairs: their bodies, blows and figures.
    pub fn sparring(&self) -> &Sparring {
        &self.sparring
    }
}

impl Practice {
    /// Creates the group with all characters in place.
    ///
    /// # Errors
    /// [`Error::Text`] for a behaviour that needs an opponent, or a target that no blow can reach.
    pub(crate) fn new(compiled: &CompiledScene, group: usize) -> Result<Self> {
        let (setup, bundle) = (BoxingSetup::new(compiled, group), compiled.bundle(group)?);
        let own = setup.config();
        let (order, numbers) = weighted_order(compiled, group)?;
        if let Some(i) = numbers.iter().position(|&p| bundle.policy_records()[p].grid.kind == KIND_SPACE_TIME) {
            let why = "it answers an opponent's blows, and targets do not strike; leave it out, or set `motion = \"sparring\"`";
            return Err(setup.scene.fault(&format!("{}.behaviours[{i}]", setup.key), why));
        }
        let regions = hit_regions(bundle, &numbers);
        let drags = own.target.drag.iter().map(|d| d.y_m).chain(Some(0.0));
        if let Some(h) = drags.map(|y| (own.target.height_m + y) as f32).find(|&h| !is_reached(&regions, h, 0.0)) {
            let help = "change `target.height_m` or the `y_m` of `target.drag`";
            let key = format!("{}.target", setup.key);
            return Err(setup.scene.fault(&key, unreachable_message(&regions, "target", h, help)));
        }
        let (starts, homes) = start_placements(compiled, group)?;
        let mut config = PracticeConfig { characters: characters_config(compiled, group), ..PracticeConfig::default() };
        config.target.radius_m = own.target.radius_m as f32;
        let made = TargetPractice::with_capacity(bundle, starts.len(), config).and_then(|mut practice| {
            practice.boxers_mut().hold_entrants();
            practice.boxers_mut().set_walls(&compiled.scene().environment.walls());
            for (start, home) in starts.into_iter().zip(&homes) {
                let id = practice.spawn(start)?;
                practice.order(id, in_own_manner(order, own, id.index()).with_target(*home))?;
            }
            practice.boxers_mut().release_entrants();
            Ok(practice)
        });
        let (practice, is_dragged) = (made.map_err(|e| setup.fault(e))?, !own.target.drag.is_empty());
        Ok(Self { practice, homes, is_dragged, setup })
    }

    /// The characters and their targets.
    pub fn practice(&self) -> &TargetPractice {
        &self.practice
    }

    /// Moves the place where a character's target hangs; from now on the scene drags no target any more.
    ///
    /// # Errors
    /// [`Error::Text`] for a character that does not exist, or a place that is not finite; nothing has changed then.
    pub fn set_home(&mut self, character: usize, home: Vec3) -> Result<()> {
        self.hang_target(character, home)?;
        if std::mem::take(&mut self.is_dragged) {
            // All targets stay where they have been dragged to.
            self.homes = self.practice.targets().iter().map(|t| t.home).collect();
        }
        self.homes[character] = home;
        Ok(())
    }

    /// Sets the level of detail of a group with more than 5000 characters, see [`PolicyCharacters::set_detail`]; in smaller
    /// groups all are posed in full.
    ///
    /// # Errors
    /// As [`PolicyCharacters::set_detail`].
    ///
    /// [`PolicyCharacters::set_detail`]: throng_core::characters::PolicyCharacters::set_detail
    pub fn set_detail(&mut self, detail: Detail) -> Result<()> {
        if self.practice.boxers().instances().is_empty() {
            return Ok(());
        }
        self.practice.boxers_mut().set_detail(Some(detail))
    }

    fn hang_target(&mut self, character: usize, home: Vec3) -> Result<()> {
        let id = id_of(&self.practice, character);
        let ordered = id.and_then(|id| self.practice.order(id, self.practice.order_of(id)?.with_target(home)));
        ordered.map_err(|e| self.setup.fault(e))
    }
}

/// Id of a character of a group that no character leaves.
///
/// # Errors
/// [`Error::Index`].
fn id_of(character_group: &impl CharacterGroup, character: usize) -> Result<Id> {
    let ids = character_group.bodies().ids;
    check_index("character", None, character, ids.len())?;
    Ok(ids[character])
}

/// Starts of characters and places of their targets: pairs, or characters with targets, on a square grid, each with a random
/// heading.
///
/// Starts of earlier groups of the same kind are drawn first, so that headings are as in one group of all.
fn start_placements(compiled: &CompiledScene, number: usize) -> Result<(Vec<Spawn>, Vec<Vec3>)> {
    let (scene, group) = (compiled.scene(), &compiled.scene().groups[number]);
    let (about, spacing, distance) = match group.place {
        Some(PlaceConfig::Grid { centre, spacing_m, distance_m }) => (centre, spacing_m as f32, distance_m as f32),
        _ => ([0.0; 2], 4.0, 1.5),
    };
    let mut rng = Pcg64Mcg::seed_from_u64(scene.seed);
    let per_place = if group.motion == GroupMotion::Sparring { 2 } else { 1 };
    let num_places = group.count / per_place;
    let side = (num_places as f32).sqrt().ceil() as usize;
    let middle = 0.5 * (side as f32 - 1.0);
    let states = resting_states(compiled.bundle(number)?.graph());
    let num_before = compiled.first_number(number) / per_place;
    let num_alike: usize = scene.groups.iter().filter(|g| g.motion == group.motion).map(|g| g.count).sum();
    let (mut starts, mut homes) = (Vec::new(), Vec::new());
    for drawn in 0..num_before + num_places {
        let place = |k: usize| (k as f32 - middle) * spacing;
        let heading = if num_alike == per_place { 0.0 } else { rng.random_range(0.0..TAU) };
        let i = drawn.saturating_sub(num_before);
        let centre = Planar::new(place(i % side) + about[0], place(i / side) + about[1], heading);
        let half = 0.5 * distance;
        for (z, turn) in [(-half, 0.0), (half, std::f32::consts::PI)].into_iter().take(per_place) {
            let root = centre.compose(Planar::new(0.0, z, turn));
            starts.push(Spawn { root, state: Some(states[rng.random_range(0..states.len())]), floor_m: 0.0 });
            let home = centre.compose(Planar::new(0.0, -z, 0.0));
            homes.push(Vec3::new(home.x, group.target.height_m as f32, home.z));
        }
    }
    let before = num_before * per_place;
    Ok((starts.split_off(before), homes.split_off(before)))
}

fn unreachable_message(regions: &[RegionRecord], what: &str, height: f32, help: &str) -> String {
    let low = regions.iter().map(|r| r.height[0]).fold(f32::INFINITY, f32::min);
    let high = regions.iter().map(|r| r.height[1]).fold(f32::NEG_INFINITY, f32::max);
    format!("nobody can reach a {what} {height:.2} m high: blows land {low:.2} to {high:.2} m high; {help}")
}

/// Regions in which blows of the striking behaviours land.
fn hit_regions(bundle: &Bundle, policies: &[usize]) -> Vec<RegionRecord> {
    let records = policies.iter().map(|&p| &bundle.policy_records()[p]);
    records.filter(|r| r.grid.kind == KIND_CYLINDER).map(|r| r.region).collect()
}

/// True where blows land within `margin` of a height, or where there are no striking behaviours (m).
fn is_reached(regions: &[RegionRecord], height: f32, margin: f32) -> bool {
    let holds = |r: &RegionRecord| height >= r.height[0] - margin && height <= r.height[1] + margin;
    regions.is_empty() || regions.iter().any(holds)
}

/// States in which characters stand; all states where there are none.
pub(crate) fn resting_states(graph: &MotionGraph) -> Vec<u32> {
    let all = &graph.states;
    let standing: Vec<u32> = (0..all.len() as u32).filter(|&s| all[s as usize].standing == 1).collect();
    if standing.is_empty() { (0..all.len() as u32).collect() } else { standing }
}

/// Orders that both kinds of groups take.
macro_rules! impl_orders {
    ($kind:ident, $group:ident) => {
        impl $kind {
            /// Sets the weights of the group's behaviours from the next step on; 0 switches a behaviour off.
            ///
            /// # Errors
            /// [`Error::Text`] where there are not as many weights as behaviours, or one is not finite or too large;
            /// nothing has changed then.
            pub fn set_weights(&mut self, weights: &[f32]) -> Result<()> {
                for id in self.$group.bodies().ids.to_vec() {
                    let order = self.$group.order_of(id).and_then(|order| order.with_weights(weights));
                    order.and_then(|order| self.$group.order(id, order)).map_err(|e| self.setup.fault(e))?;
                }
                Ok(())
            }

            /// Makes a character play a segment at once, see [`throng_core::characters::PolicyCharacters::play_segment`].
            ///
            /// # Errors
            /// [`Error::Text`] for a character or segment that does not exist.
            pub fn play(&mut self, character: usize, segment: u32) -> Result<()> {
                let id = id_of(&self.$group, character);
                id.and_then(|id| self.$group.play(id, segment)).map_err(|e| self.setup.fault(e))
            }
        }
    };
}

impl_orders!(Bouts, sparring);
impl_orders!(Practice, practice);

/// Methods of [`MotionKind`] that are alike for both kinds of groups.
macro_rules! group_motion_methods {
    ($group:ident) => {
        fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
            self.$group.boxers_mut().add_reserved_regions(out);
        }

        fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
            self.$group.boxers_mut().set_external_obstacles(others);
        }

        fn restart_on_free_ground(&mut self) {
            self.$group.boxers_mut().release_entrants();
        }

        fn num_characters(&self) -> usize {
            self.$group.bodies().ids.len()
        }

        fn root(&self, number: usize) -> Option<Planar> {
            Some(self.$group.bodies().roots[number])
        }

        fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
            Some(&self.$group.bodies().model[number])
        }

        fn contacts(&self, number: usize) -> Contacts {
            self.$group.characters().contacts(number)
        }
    };
}

impl MotionKind for Bouts {
    group_motion_methods!(sparring);

    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
        self.sparring.step(tick.dt_s, tick.run).map_err(|e| self.setup.fault(e))?;
        events.extend(self.sparring.events().iter().map(|(id, l)| {
            let opponent = tick.first + l.opponent.index();
            tick.event(id.index(), CharacterEvent::Struck { opponent, part: l.part, at: l.blow.point })
        }));
        Ok(())
    }

    fn save(&self, out: &mut Vec<u8>) {
        self.sparring.save(out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        load_same(&mut self.sparring, bytes)
    }
}

/// Snapshot of dragged targets, around one of [`TargetPractice`].
const DRAGGED: SnapshotKind = SnapshotKind { what: "practice", tag: *b"DRAG", version: 2, setup: 0 };

impl MotionKind for Practice {
    group_motion_methods!(practice);

    fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
        let by = drag_offset(&self.setup.config().target.drag, tick.until_s);
        if self.is_dragged {
            (0..self.homes.len()).try_for_each(|c| self.hang_target(c, self.homes[c] + by))?;
        }
        self.practice.step(tick.dt_s, tick.run).map_err(|e| self.setup.fault(e))?;
        let hits = self.practice.events().iter();
        events.extend(hits.map(|(id, h)| tick.event(id.index(), CharacterEvent::Hit { at: h.blow.point })));
        Ok(())
    }

    fn save(&self, out: &mut Vec<u8>) {
        let practice = saved_bytes(|out| self.practice.save(out));
        DRAGGED.write(&(&self.homes, self.is_dragged, practice), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let (homes, is_dragged, practice): (Vec<Vec3>, bool, Bytes) = DRAGGED.read_all(bytes)?;
        let near = |home: &Vec3| home.is_finite() && home.abs().max_element() <= 1e5;
        let may_be_dragged = !self.setup.config().target.drag.is_empty();
        let good = homes.len() == self.homes.len() && homes.iter().all(near);
        check_snapshot(good && (!is_dragged || may_be_dragged), DRAGGED.what, "its targets hang nowhere")?;
        load_same(&mut self.practice, &practice.0)?;
        (self.homes, self.is_dragged) = (homes, is_dragged);
        Ok(())
    }
}

/// Displacement of a dragged target at a time, on a path that begins anew after its last point (m).
fn drag_offset(drag: &[DragPoint], time_s: f64) -> Vec3 {
    let Some(last) = drag.last() else { return Vec3::ZERO };
    let place = |p: &DragPoint| Vec3::new(p.x_m as f32, p.y_m as f32, p.z_m as f32);
    let t = time_s % last.time_s;
    let next = drag.iter().position(|p| t < p.time_s).unwrap_or(drag.len() - 1);
    let (from, begin) = if next == 0 { (place(last), 0.0) } else { (place(&drag[next - 1]), drag[next - 1].time_s) };
    let ratio = ((t - begin) / (drag[next].time_s - begin)) as f32;
    // Hands start and stop gently.
    from.lerp(place(&drag[next]), ratio * ratio * (3.0 - 2.0 * ratio))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_reached_inside_a_region_or_where_nobody_strikes() {
        let at = |low, high| RegionRecord { height: [low, high], ..RegionRecord::EVERYWHERE };
        let regions = [at(0.8, 1.0), at(1.4, 1.6)];
        for (height, margin, reached) in [(0.9, 0.0, true), (1.2, 0.0, false), (1.7, 0.0, false), (1.7, 0.12, true)] {
            assert_eq!(is_reached(&regions, height, margin), reached, "{height} {margin}");
        }
        assert!(is_reached(&[], 9.0, 0.0));
    }

    #[test]
    fn a_hand_goes_from_place_to_place_and_begins_anew() {
        let point = |time_s, x_m| DragPoint { time_s, x_m, y_m: 0.0, z_m: 0.0 };
        let drag = [point(2.0, 1.0), point(4.0, 1.0), point(6.0, 0.0)];
        for (time, x) in [(0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (3.0, 1.0), (5.0, 0.5), (6.0, 0.0), (7.0, 0.5)] {
            assert!((drag_offset(&drag, time).x - x).abs() < 1e-6, "{time}");
        }
        assert_eq!(drag_offset(&[], 3.0), Vec3::ZERO);
    }
}
