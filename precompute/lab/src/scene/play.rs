//! A scene that runs.

use super::config::{DragPoint, Scene, SceneGoal, SceneKind};
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f32::consts::TAU;
use throng_motion::error::BuildError;
use throng_runtime::characters::{Characters, CharactersConfig, CharactersError, Choice, MotionSet, Start};
use throng_runtime::policy::{KIND_CYLINDER, KIND_SPACE_TIME, RegionRecord};
use throng_runtime::sparring::{
    Aim, PracticeConfig, PracticeGoal, Sparring, SparringConfig, SparringGoal, Tally, TargetPractice,
};
use throng_runtime::{Bundle, Planar};

/// The characters of a scene, by its kind.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a scene has one, for as long as it runs")]
pub enum Cast {
    /// Pairs that spar.
    Pairs(Sparring),
    /// Characters with targets.
    Targets(TargetPractice),
}

/// A scene that runs.
#[derive(Clone, Debug)]
pub struct Play {
    /// The characters.
    pub cast: Cast,
    /// Where targets hang when nobody drags them (m, number of characters, 0 for pairs).
    pub homes: Vec<Vec3>,
    pub(super) drag: Vec<DragPoint>,
    pub(super) time_s: f64,
}

impl Scene {
    /// Puts everybody in place.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a behaviour that the bundle does not have or that targets give no reason for, a
    /// target or head nobody can reach, or a bundle without effective hits.
    pub fn play(&self, tables: &Bundle, motion_set: &MotionSet) -> Result<Play, BuildError> {
        let policies = self.goals.iter().map(|g| self.policy(tables, g)).collect::<Result<Vec<_>, _>>()?;
        let weights = self.goals.iter().map(|g| g.weight as f32);
        let (starts, homes) = self.places(tables);
        let choice = Choice::LookAhead { temperature: self.temperature as f32 };
        let characters = CharactersConfig { seed: self.seed, choice, ..CharactersConfig::default() };
        let is_threat = |policy: usize| tables.policy_records()[policy].grid.kind == KIND_SPACE_TIME;
        let cast = match self.kind {
            SceneKind::Pairs => {
                let aim = |policy| if is_threat(policy) { Aim::OpponentThreat } else { Aim::OpponentHead };
                let goal = |(&policy, weight): (&usize, f32)| SparringGoal { policy, weight, aim: aim(policy) };
                let goals = policies.iter().zip(weights).map(goal).collect();
                let config = SparringConfig { characters, ..SparringConfig::new(goals) };
                let pairs = Sparring::new(motion_set, config, &starts).map_err(|e| self.fault(&e))?;
                self.check_heads(tables, &policies, pairs.heads())?;
                Cast::Pairs(pairs)
            }
            SceneKind::Targets => {
                if let Some(i) = policies.iter().position(|&p| is_threat(p)) {
                    return Err(self.idle(&self.goals[i]));
                }
                self.check_targets(tables, &policies)?;
                let goal = |(&policy, weight): (&usize, f32)| PracticeGoal { policy, weight };
                let goals = policies.iter().zip(weights).map(goal).collect();
                let mut config = PracticeConfig { characters, ..PracticeConfig::new(goals) };
                config.target.radius_m = self.target.radius_m as f32;
                Cast::Targets(TargetPractice::new(motion_set, config, &starts, &homes).map_err(|e| self.fault(&e))?)
            }
        };
        let homes = if self.kind == SceneKind::Pairs { Vec::new() } else { homes };
        Ok(Play { cast, homes, drag: self.target.drag.clone(), time_s: 0.0 })
    }

    fn fault(&self, e: &CharactersError) -> BuildError {
        BuildError::Stage {
            stage: "scene",
            message: format!("scene \"{}\": {e}", self.name),
            help: "Correct the scene file.".into(),
        }
    }

    /// The error for a goal that answers blows, where nobody strikes.
    fn idle(&self, goal: &SceneGoal) -> BuildError {
        BuildError::Stage {
            stage: "scene",
            message: format!(
                "scene \"{}\": goal \"{}\" answers an opponent's blows, and targets do not strike",
                self.name, goal.behaviour
            ),
            help: "Leave the goal out, or make it a scene of pairs.".into(),
        }
    }

    fn policy(&self, tables: &Bundle, goal: &SceneGoal) -> Result<usize, BuildError> {
        tables.find_policy(&goal.behaviour).map_err(|_| BuildError::Stage {
            stage: "scene",
            message: format!("scene \"{}\": the bundle has no behaviour \"{}\"", self.name, goal.behaviour),
            help: format!("It has {}; or build it from a config with that one.", tables.meta().behaviours.join(", ")),
        })
    }

    /// Refuses targets at heights that no blow of the scene's behaviours reaches.
    fn check_targets(&self, tables: &Bundle, policies: &[usize]) -> Result<(), BuildError> {
        let regions = hit_regions(tables, policies);
        let drags = self.target.drag.iter().map(|d| d.y_m).chain(Some(0.0));
        match drags.map(|y| (self.target.height_m + y) as f32).find(|&h| !is_reached(&regions, h, 0.0)) {
            None => Ok(()),
            Some(h) => {
                Err(self.out_of_reach(&regions, "target", h, "Change `target.height_m` or the `y_m` of `target.drag`."))
            }
        }
    }

    /// Refuses pairs where no blow reaches the head of anybody as they stand at the start.
    fn check_heads(&self, tables: &Bundle, policies: &[usize], heads: &[Vec3]) -> Result<(), BuildError> {
        let regions = hit_regions(tables, policies);
        match heads.first() {
            Some(first) if !heads.iter().any(|h| is_reached(&regions, h.y, HALF_HEAD_M)) => {
                let help = "Build the bundle from motion with blows at heads, with `grid.bounds` that hold them.";
                Err(self.out_of_reach(&regions, "head", first.y, help))
            }
            _ => Ok(()),
        }
    }

    fn out_of_reach(&self, regions: &[RegionRecord], what: &str, height: f32, help: &str) -> BuildError {
        let low = regions.iter().map(|r| r.height[0]).fold(f32::INFINITY, f32::min);
        let high = regions.iter().map(|r| r.height[1]).fold(f32::NEG_INFINITY, f32::max);
        BuildError::Stage {
            stage: "scene",
            message: format!(
                "scene \"{}\": nobody can reach a {what} {height:.2} m high: blows land {low:.2} to {high:.2} m high",
                self.name
            ),
            help: help.into(),
        }
    }

    /// Where characters start, and where their targets hang: pairs, or characters with targets, on a square of
    /// places, each turned its own way.
    fn places(&self, tables: &Bundle) -> (Vec<Start>, Vec<Vec3>) {
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed);
        let per_place = if self.kind == SceneKind::Pairs { 2 } else { 1 };
        let num_places = self.characters / per_place;
        let side = (num_places as f32).sqrt().ceil() as usize;
        let middle = 0.5 * (side as f32 - 1.0);
        let states = resting_states(tables);
        let (mut starts, mut homes) = (Vec::new(), Vec::new());
        for i in 0..num_places {
            let place = |k: usize| (k as f32 - middle) * self.spacing_m as f32;
            let heading = if num_places == 1 { 0.0 } else { rng.random_range(0.0..TAU) };
            let centre = Planar::new(place(i % side), place(i / side), heading);
            let half = 0.5 * self.distance_m as f32;
            for (z, turn) in [(-half, 0.0), (half, std::f32::consts::PI)].into_iter().take(per_place) {
                let root = centre.compose(Planar::new(0.0, z, turn));
                starts.push(Start { root, state: states[rng.random_range(0..states.len())] });
                let home = centre.compose(Planar::new(0.0, -z, 0.0));
                homes.push(Vec3::new(home.x, self.target.height_m as f32, home.z));
            }
        }
        (starts, homes)
    }
}

/// A blow this far above or below a head's centre meets it (m).
const HALF_HEAD_M: f32 = 0.12;

/// Where the blows of behaviours that strike land.
fn hit_regions(tables: &Bundle, policies: &[usize]) -> Vec<RegionRecord> {
    let records = policies.iter().map(|&p| &tables.policy_records()[p]);
    records.filter(|r| r.grid.kind == KIND_CYLINDER).map(|r| r.region).collect()
}

/// Whether blows land at a height, give or take `margin`; so where nobody wants to strike (m).
fn is_reached(regions: &[RegionRecord], height: f32, margin: f32) -> bool {
    let holds = |r: &RegionRecord| height >= r.height[0] - margin && height <= r.height[1] + margin;
    regions.is_empty() || regions.iter().any(holds)
}

/// States in which characters stand; all where nobody does.
fn resting_states(tables: &Bundle) -> Vec<u32> {
    let all = &tables.graph().states;
    let standing: Vec<u32> = (0..all.len() as u32).filter(|&s| all[s as usize].standing == 1).collect();
    if standing.is_empty() { (0..all.len() as u32).collect() } else { standing }
}

impl Play {
    /// Moves the scene on.
    ///
    /// # Errors
    /// As [`Characters::step`].
    pub fn step(&mut self, motion_set: &MotionSet, dt_s: f32) -> Result<(), CharactersError> {
        self.time_s += f64::from(dt_s);
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.step(motion_set, dt_s),
            Cast::Targets(practice) => {
                if !self.drag.is_empty() {
                    let by = dragged(&self.drag, self.time_s);
                    for (c, home) in self.homes.iter().enumerate() {
                        practice.set_home(c, *home + by)?;
                    }
                }
                practice.step(motion_set, dt_s)
            }
        }
    }

    /// Moves the place where a character's target hangs, as a hand does: from now on the scene's own drags it no more.
    ///
    /// # Errors
    /// [`CharactersError::Index`] in a scene of pairs or for a character that does not exist,
    /// [`CharactersError::Value`] for a place that is not finite; nothing has changed then.
    pub fn set_home(&mut self, character: usize, home: Vec3) -> Result<(), CharactersError> {
        match &mut self.cast {
            Cast::Pairs(_) => Err(CharactersError::Index { what: "target", got: character, limit: 0 }),
            Cast::Targets(practice) => {
                practice.set_home(character, home)?;
                if !self.drag.is_empty() {
                    // Everybody's target stays where it has been dragged to.
                    self.drag.clear();
                    self.homes = practice.targets().iter().map(|t| t.home).collect();
                }
                self.homes[character] = home;
                Ok(())
            }
        }
    }

    /// Sets what each goal of the scene counts from the next step on; 0 switches it off.
    ///
    /// # Errors
    /// [`CharactersError::Length`] where there are not as many weights as goals, [`CharactersError::Value`] for one
    /// that is not finite or too large.
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<(), CharactersError> {
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.set_weights(weights),
            Cast::Targets(practice) => practice.set_weights(weights),
        }
    }

    /// Lets a character play a segment at once, see [`Characters::play`].
    ///
    /// # Errors
    /// As [`Characters::play`].
    pub fn play(&mut self, motion_set: &MotionSet, character: usize, segment: u32) -> Result<(), CharactersError> {
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.play(motion_set, character, segment),
            Cast::Targets(practice) => practice.play(motion_set, character, segment),
        }
    }

    /// The characters.
    pub fn characters(&self) -> &Characters {
        match &self.cast {
            Cast::Pairs(pairs) => pairs.characters(),
            Cast::Targets(practice) => practice.characters(),
        }
    }

    /// What became of all blows so far.
    pub fn blows(&self) -> Tally {
        match &self.cast {
            Cast::Pairs(pairs) => pairs.figures().blows,
            Cast::Targets(practice) => practice.figures().blows,
        }
    }

    /// Simulated time (s).
    pub fn time_s(&self) -> f64 {
        self.time_s
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
