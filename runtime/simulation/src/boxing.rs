//! Characters with policies: each with a target of its own, or in pairs who strike at each other.

use crate::compile::CompiledScene;
use crate::kind::{Kind, Tick, joints, refused};
use crate::scene::{DragPoint, GroupConfig, Motion, PlaceConfig, Scene};
use crate::sparring::{Aim, PracticeConfig, PracticeGoal, Sparring, SparringConfig, SparringGoal, TargetPractice};
use crate::{Event, Happened};
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f32::consts::TAU;
use std::sync::Arc;
use throng_base::{Bytes, Error, Result, SnapshotKind};
use throng_core::characters::{Characters, CharactersConfig, Choice, MotionSet, Start};
use throng_core::policy::{KIND_CYLINDER, KIND_SPACE_TIME, RegionRecord};
use throng_core::{Bundle, Contacts, Mat3x4, NUM_JOINTS, Planar};

/// A group of pairs who spar.
#[derive(Clone, Debug)]
pub struct Bouts {
    setup: Setup,
    sparring: Sparring,
}

/// A group of characters who strike at targets of their own.
#[derive(Clone, Debug)]
pub struct Practice {
    setup: Setup,
    practice: TargetPractice,
    /// Where targets hang when nobody drags them (m).
    homes: Vec<Vec3>,
    /// They are dragged as the scene says.
    is_dragged: bool,
    time_s: f64,
}

/// What a group of either kind is made of.
#[derive(Clone, Debug)]
struct Setup {
    scene: Arc<Scene>,
    /// Its number in the scene.
    group: usize,
    /// What messages call it.
    key: String,
    motion_set: MotionSet,
}

impl Setup {
    fn new(compiled: &CompiledScene, group: usize) -> Result<Self> {
        let motion_set = MotionSet::new(compiled.bundle(group)?);
        Ok(Self { scene: Arc::clone(compiled.shared()), group, key: format!("groups[{group}]"), motion_set })
    }

    fn fault(&self, e: Error) -> Error {
        self.scene.fault(&self.key, e)
    }
}

/// Numbers and weights of a group's policies.
fn policies(compiled: &CompiledScene, group: usize) -> Result<(Vec<usize>, Vec<f32>)> {
    let (bundle, behaviours) = (compiled.bundle(group)?, &compiled.scene().groups[group].behaviours);
    let numbers = behaviours.iter().map(|b| bundle.find_policy(&b.name)).collect::<Result<_>>()?;
    Ok((numbers, behaviours.iter().map(|b| b.weight as f32).collect()))
}

fn characters(compiled: &CompiledScene, group: usize) -> CharactersConfig {
    let choice = Choice::LookAhead { temperature: compiled.scene().groups[group].temperature as f32 };
    CharactersConfig { seed: compiled.seed(group), choice, ..CharactersConfig::default() }
}

/// True for a policy about an opponent's next blow.
fn is_threat(bundle: &Bundle, policy: usize) -> bool {
    bundle.policy_records()[policy].grid.kind == KIND_SPACE_TIME
}

impl Bouts {
    /// Puts everybody in place.
    ///
    /// # Errors
    /// [`Error::Text`] for heads that nobody can reach.
    pub(crate) fn new(compiled: &CompiledScene, group: usize) -> Result<Self> {
        let (setup, bundle) = (Setup::new(compiled, group)?, compiled.bundle(group)?);
        let (numbers, weights) = policies(compiled, group)?;
        let (starts, _) = places(&setup.scene.groups[group], bundle, compiled.seed(group));
        let aim = |policy| if is_threat(bundle, policy) { Aim::OpponentThreat } else { Aim::OpponentHead };
        let goal = |(&policy, weight): (&usize, f32)| SparringGoal { policy, weight, aim: aim(policy) };
        let goals = numbers.iter().zip(weights).map(goal).collect();
        let config = SparringConfig { characters: characters(compiled, group), ..SparringConfig::new(goals) };
        let sparring = Sparring::new(&setup.motion_set, config, &starts).map_err(|e| setup.fault(e))?;
        let regions = hit_regions(bundle, &numbers);
        match sparring.heads().first() {
            Some(first) if !sparring.heads().iter().any(|h| is_reached(&regions, h.y, HALF_HEAD_M)) => {
                let help = "build the bundle from motion with blows at heads, with `grid.bounds` that hold them";
                Err(setup.scene.fault(&setup.key, out_of_reach(&regions, "head", first.y, help)))
            }
            _ => Ok(Self { setup, sparring }),
        }
    }

    /// The pairs: their bodies, blows and figures.
    pub fn sparring(&self) -> &Sparring {
        &self.sparring
    }

    fn characters(&self) -> &Characters {
        self.sparring.characters()
    }

    /// Sets what each behaviour of the group counts from the next step on; 0 switches it off.
    ///
    /// # Errors
    /// [`Error::Text`] where there are not as many weights as behaviours, or one is not finite or too large.
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<()> {
        self.sparring.set_weights(weights).map_err(|e| self.setup.fault(e))
    }

    /// Lets a character play a segment at once, see [`Characters::play`].
    ///
    /// # Errors
    /// [`Error::Text`] for a character or segment that does not exist.
    pub fn play(&mut self, character: usize, segment: u32) -> Result<()> {
        self.sparring.play(&self.setup.motion_set, character, segment).map_err(|e| self.setup.fault(e))
    }
}

impl Practice {
    /// Puts everybody in place.
    ///
    /// # Errors
    /// [`Error::Text`] for a behaviour that targets give no reason for, or a target nobody can reach.
    pub(crate) fn new(compiled: &CompiledScene, group: usize) -> Result<Self> {
        let (setup, bundle) = (Setup::new(compiled, group)?, compiled.bundle(group)?);
        let own = &setup.scene.groups[group];
        let (numbers, weights) = policies(compiled, group)?;
        if let Some(i) = numbers.iter().position(|&p| is_threat(bundle, p)) {
            let why = "it answers an opponent's blows, and targets do not strike; leave it out, or set `motion = \"sparring\"`";
            return Err(setup.scene.fault(&format!("{}.behaviours[{i}]", setup.key), why));
        }
        let regions = hit_regions(bundle, &numbers);
        let drags = own.target.drag.iter().map(|d| d.y_m).chain(Some(0.0));
        if let Some(h) = drags.map(|y| (own.target.height_m + y) as f32).find(|&h| !is_reached(&regions, h, 0.0)) {
            let help = "change `target.height_m` or the `y_m` of `target.drag`";
            let key = format!("{}.target", setup.key);
            return Err(setup.scene.fault(&key, out_of_reach(&regions, "target", h, help)));
        }
        let (starts, homes) = places(own, bundle, compiled.seed(group));
        let goal = |(&policy, weight): (&usize, f32)| PracticeGoal { policy, weight };
        let goals = numbers.iter().zip(weights).map(goal).collect();
        let mut config = PracticeConfig { characters: characters(compiled, group), ..PracticeConfig::new(goals) };
        config.target.radius_m = own.target.radius_m as f32;
        let practice = TargetPractice::new(&setup.motion_set, config, &starts, &homes).map_err(|e| setup.fault(e))?;
        let is_dragged = !own.target.drag.is_empty();
        Ok(Self { practice, homes, is_dragged, time_s: 0.0, setup })
    }

    /// The characters and their targets.
    pub fn practice(&self) -> &TargetPractice {
        &self.practice
    }

    fn characters(&self) -> &Characters {
        self.practice.characters()
    }

    /// Moves the place where a character's target hangs, as a hand does: from now on the scene's own drags it no more.
    ///
    /// # Errors
    /// [`Error::Text`] for a character that does not exist, or a place that is not finite; nothing has changed then.
    pub fn set_home(&mut self, character: usize, home: Vec3) -> Result<()> {
        self.practice.set_home(character, home).map_err(|e| self.setup.fault(e))?;
        if std::mem::take(&mut self.is_dragged) {
            // Everybody's target stays where it has been dragged to.
            self.homes = self.practice.targets().iter().map(|t| t.home).collect();
        }
        self.homes[character] = home;
        Ok(())
    }

    /// As [`Bouts::set_weights`].
    ///
    /// # Errors
    /// As [`Bouts::set_weights`].
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<()> {
        self.practice.set_weights(weights).map_err(|e| self.setup.fault(e))
    }

    /// As [`Bouts::play`].
    ///
    /// # Errors
    /// As [`Bouts::play`].
    pub fn play(&mut self, character: usize, segment: u32) -> Result<()> {
        self.practice.play(&self.setup.motion_set, character, segment).map_err(|e| self.setup.fault(e))
    }
}

/// Where characters start, and where their targets hang: pairs, or characters with targets, on a square grid, each
/// turned its own way.
fn places(group: &GroupConfig, bundle: &Bundle, seed: u64) -> (Vec<Start>, Vec<Vec3>) {
    let (about, spacing, distance) = match group.place {
        Some(PlaceConfig::Grid { centre, spacing_m, distance_m }) => (centre, spacing_m as f32, distance_m as f32),
        _ => ([0.0; 2], 4.0, 1.5),
    };
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let per_place = if group.motion == Motion::Sparring { 2 } else { 1 };
    let num_places = group.count / per_place;
    let side = (num_places as f32).sqrt().ceil() as usize;
    let middle = 0.5 * (side as f32 - 1.0);
    let states = resting_states(bundle);
    let (mut starts, mut homes) = (Vec::new(), Vec::new());
    for i in 0..num_places {
        let place = |k: usize| (k as f32 - middle) * spacing;
        let heading = if num_places == 1 { 0.0 } else { rng.random_range(0.0..TAU) };
        let centre = Planar::new(place(i % side) + about[0], place(i / side) + about[1], heading);
        let half = 0.5 * distance;
        for (z, turn) in [(-half, 0.0), (half, std::f32::consts::PI)].into_iter().take(per_place) {
            let root = centre.compose(Planar::new(0.0, z, turn));
            starts.push(Start { root, state: states[rng.random_range(0..states.len())] });
            let home = centre.compose(Planar::new(0.0, -z, 0.0));
            homes.push(Vec3::new(home.x, group.target.height_m as f32, home.z));
        }
    }
    (starts, homes)
}

fn out_of_reach(regions: &[RegionRecord], what: &str, height: f32, help: &str) -> String {
    let low = regions.iter().map(|r| r.height[0]).fold(f32::INFINITY, f32::min);
    let high = regions.iter().map(|r| r.height[1]).fold(f32::NEG_INFINITY, f32::max);
    format!("nobody can reach a {what} {height:.2} m high: blows land {low:.2} to {high:.2} m high; {help}")
}

/// A blow this far above or below a head's centre meets it (m).
const HALF_HEAD_M: f32 = 0.12;

/// Where the blows of behaviours that strike land.
fn hit_regions(bundle: &Bundle, policies: &[usize]) -> Vec<RegionRecord> {
    let records = policies.iter().map(|&p| &bundle.policy_records()[p]);
    records.filter(|r| r.grid.kind == KIND_CYLINDER).map(|r| r.region).collect()
}

/// Whether blows land at a height, give or take `margin`; so where nobody wants to strike (m).
fn is_reached(regions: &[RegionRecord], height: f32, margin: f32) -> bool {
    let holds = |r: &RegionRecord| height >= r.height[0] - margin && height <= r.height[1] + margin;
    regions.is_empty() || regions.iter().any(holds)
}

/// States in which characters stand; all where nobody does.
fn resting_states(bundle: &Bundle) -> Vec<u32> {
    let all = &bundle.graph().states;
    let standing: Vec<u32> = (0..all.len() as u32).filter(|&s| all[s as usize].standing == 1).collect();
    if standing.is_empty() { (0..all.len() as u32).collect() } else { standing }
}

/// What both kinds have in common.
macro_rules! of_characters {
    () => {
        fn num_characters(&self) -> usize {
            self.characters().num_characters()
        }

        fn root(&self, member: usize) -> Option<Planar> {
            Some(self.characters().root(member))
        }

        fn pose(&self, member: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
            Some(joints(self.characters().pose(member)))
        }

        fn contacts(&self, member: usize) -> Contacts {
            self.characters().contacts(member)
        }
    };
}
impl Kind for Bouts {
    of_characters!();

    fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()> {
        let done = self.sparring.step_on(&self.setup.motion_set, tick.dt_s, tick.run);
        done.map_err(|e| self.setup.fault(e))?;
        events.extend(self.sparring.landed().iter().map(|l| Event {
            time_s: tick.until_s,
            who: tick.first + l.blow.character as usize,
            happened: Happened::Struck { opponent: tick.first + l.opponent as usize, part: l.part, at: l.blow.point },
        }));
        Ok(())
    }

    fn save(&self, out: &mut Vec<u8>) {
        self.sparring.save(out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        self.sparring.load(&self.setup.motion_set, bytes)
    }
}

/// Targets that are dragged, around a snapshot of [`TargetPractice`].
const DRAGGED: SnapshotKind = SnapshotKind { what: "practice", tag: *b"DRAG", version: 1, setup: 0 };

impl Kind for Practice {
    of_characters!();

    fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()> {
        self.time_s += f64::from(tick.dt_s);
        let by = dragged(&self.setup.scene.groups[self.setup.group].target.drag, self.time_s);
        for (c, home) in self.homes.iter().enumerate().filter(|_| self.is_dragged) {
            self.practice.set_home(c, *home + by).map_err(|e| self.setup.fault(e))?;
        }
        let done = self.practice.step_on(&self.setup.motion_set, tick.dt_s, tick.run);
        done.map_err(|e| self.setup.fault(e))?;
        events.extend(self.practice.hits().iter().map(|h| Event {
            time_s: tick.until_s,
            who: tick.first + h.blow.character as usize,
            happened: Happened::Hit { at: h.blow.point },
        }));
        Ok(())
    }

    fn save(&self, out: &mut Vec<u8>) {
        let mut practice = Bytes::default();
        self.practice.save(&mut practice.0);
        DRAGGED.write(&(&self.homes, self.is_dragged, self.time_s, practice), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let (homes, is_dragged, time_s, practice): (Vec<Vec3>, bool, f64, Bytes) = DRAGGED.read_all(bytes)?;
        let near = |home: &Vec3| home.is_finite() && home.abs().max_element() <= 1e5;
        let may_be_dragged = !self.setup.scene.groups[self.setup.group].target.drag.is_empty();
        let good = homes.len() == self.homes.len() && homes.iter().all(near) && (0.0..1e9).contains(&time_s);
        if !good || is_dragged && !may_be_dragged {
            return Err(refused(DRAGGED.what, "its targets hang nowhere"));
        }
        self.practice.load(&self.setup.motion_set, &practice.0)?;
        (self.homes, self.is_dragged, self.time_s) = (homes, is_dragged, time_s);
        Ok(())
    }
}

/// Where a hand has dragged a target at a time, on a way that begins anew when it is over (m).
fn dragged(drag: &[DragPoint], time_s: f64) -> Vec3 {
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
            assert!((dragged(&drag, time).x - x).abs() < 1e-6, "{time}");
        }
        assert_eq!(dragged(&[], 3.0), Vec3::ZERO);
    }
}
