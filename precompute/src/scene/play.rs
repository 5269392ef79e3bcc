//! A scene that runs.

use super::config::{DragPoint, Scene, SceneGoal, SceneKind};
use crate::error::BuildError;
use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f32::consts::TAU;
use throng_runtime::policy::{KIND_CYLINDER, KIND_MOMENTS, RegionRecord};
use throng_runtime::sparring::{
    Aim, PracticeConfig, PracticeGoal, Sparring, SparringConfig, SparringGoal, Tally, TargetPractice,
};
use throng_runtime::troupe::{Choice, Repertoire, Start, Troupe, TroupeConfig, TroupeError};
use throng_runtime::{Planar, Tables};

/// The characters of a scene, by its kind.
#[derive(Clone, Debug)]
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
    /// Where targets hang when nobody drags them. [Unit: m] [Size: number of characters, 0 for pairs]
    pub homes: Vec<Vec3>,
    pub(super) drag: Vec<DragPoint>,
    pub(super) time_s: f64,
}

impl Scene {
    /// Puts everybody in place.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a behaviour that the bundle does not have, a target nobody can reach, or a bundle
    /// without effective hits.
    pub fn play(&self, tables: &Tables, repertoire: &Repertoire<'_>) -> Result<Play, BuildError> {
        let policies = self.goals.iter().map(|g| self.policy(tables, g)).collect::<Result<Vec<_>, _>>()?;
        let weights = self.goals.iter().map(|g| g.weight as f32);
        let (starts, homes) = self.places(tables);
        let choice = Choice::LookAhead { temperature: self.temperature as f32 };
        let troupe = TroupeConfig { seed: self.seed, choice, ..TroupeConfig::default() };
        let is_threat = |policy: usize| tables.policy_records()[policy].grid.kind == KIND_MOMENTS;
        let cast = match self.kind {
            SceneKind::Pairs => {
                let aim = |policy| if is_threat(policy) { Aim::OpponentThreat } else { Aim::OpponentHead };
                let goal = |(&policy, weight): (&usize, f32)| SparringGoal { policy, weight, aim: aim(policy) };
                let goals = policies.iter().zip(weights).map(goal).collect();
                let config = SparringConfig { troupe, ..SparringConfig::new(goals) };
                Cast::Pairs(Sparring::new(repertoire, config, &starts).map_err(|e| self.fault(&e))?)
            }
            SceneKind::Targets => {
                self.check_reach(tables, &policies)?;
                let goal = |(&policy, weight): (&usize, f32)| PracticeGoal { policy, weight };
                let goals = policies.iter().zip(weights).filter(|(p, _)| !is_threat(**p)).map(goal).collect();
                let mut config = PracticeConfig { troupe, ..PracticeConfig::new(goals) };
                config.target.radius_m = self.target.radius_m as f32;
                Cast::Targets(TargetPractice::new(repertoire, config, &starts, &homes).map_err(|e| self.fault(&e))?)
            }
        };
        let homes = if self.kind == SceneKind::Pairs { Vec::new() } else { homes };
        Ok(Play { cast, homes, drag: self.target.drag.clone(), time_s: 0.0 })
    }

    fn fault(&self, e: &TroupeError) -> BuildError {
        BuildError::Stage {
            stage: "scene",
            message: format!("scene \"{}\": {e}", self.name),
            help: "Correct the scene file.".into(),
        }
    }

    fn policy(&self, tables: &Tables, goal: &SceneGoal) -> Result<usize, BuildError> {
        tables.find_policy(&goal.behaviour).ok_or_else(|| BuildError::Stage {
            stage: "scene",
            message: format!("scene \"{}\": the bundle has no behaviour \"{}\"", self.name, goal.behaviour),
            help: format!("It has {}; or build it from a config with that one.", tables.meta().behaviours.join(", ")),
        })
    }

    /// Refuses targets at heights that no blow of the scene's behaviours reaches.
    fn check_reach(&self, tables: &Tables, policies: &[usize]) -> Result<(), BuildError> {
        let records = || policies.iter().map(|&p| &tables.policy_records()[p]).filter(|r| r.grid.kind == KIND_CYLINDER);
        if records().next().is_none() {
            return Ok(());
        }
        let drags = self.target.drag.iter().map(|d| d.y_m).chain(Some(0.0));
        for height in drags.map(|y| (self.target.height_m + y) as f32) {
            let within = |r: &RegionRecord| height >= r.height[0] && height <= r.height[1];
            if records().any(|r| within(&r.region)) {
                continue;
            }
            let low = records().map(|r| r.region.height[0]).fold(f32::INFINITY, f32::min);
            let high = records().map(|r| r.region.height[1]).fold(f32::NEG_INFINITY, f32::max);
            return Err(BuildError::Stage {
                stage: "scene",
                message: format!(
                    "scene \"{}\": nobody can reach a target {height:.2} m high: blows land {low:.2} to {high:.2} m high",
                    self.name
                ),
                help: "Change `target.height_m` or the `y_m` of `target.drag`.".into(),
            });
        }
        Ok(())
    }

    /// Where characters start, and where their targets hang: pairs, or characters with targets, on a square of
    /// places, each turned its own way.
    fn places(&self, tables: &Tables) -> (Vec<Start>, Vec<Vec3>) {
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

/// States in which characters stand; all where nobody does.
fn resting_states(tables: &Tables) -> Vec<u32> {
    let all = tables.graph().states;
    let standing: Vec<u32> = (0..all.len() as u32).filter(|&s| all[s as usize].standing == 1).collect();
    if standing.is_empty() { (0..all.len() as u32).collect() } else { standing }
}

impl Play {
    /// Moves the scene on.
    ///
    /// # Errors
    /// As [`Troupe::step`].
    pub fn step(&mut self, repertoire: &Repertoire<'_>, dt_s: f32) -> Result<(), TroupeError> {
        self.time_s += f64::from(dt_s);
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.step(repertoire, dt_s),
            Cast::Targets(practice) => {
                if !self.drag.is_empty() {
                    let by = dragged(&self.drag, self.time_s);
                    for (c, home) in self.homes.iter().enumerate() {
                        practice.set_home(c, *home + by)?;
                    }
                }
                practice.step(repertoire, dt_s)
            }
        }
    }

    /// Moves the place where a character's target hangs, as a hand does: from now on the scene's own drags it no more.
    ///
    /// # Errors
    /// [`TroupeError::Index`] in a scene of pairs or for a character that does not exist, [`TroupeError::Value`] for a
    /// place that is not finite; nothing has changed then.
    pub fn set_home(&mut self, character: usize, home: Vec3) -> Result<(), TroupeError> {
        match &mut self.cast {
            Cast::Pairs(_) => Err(TroupeError::Index { what: "target", got: character, limit: 0 }),
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
    /// [`TroupeError::Length`] where there are not as many weights as goals, [`TroupeError::Value`] for one that is
    /// not finite or too large.
    pub fn set_weights(&mut self, weights: &[f32]) -> Result<(), TroupeError> {
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.set_weights(weights),
            Cast::Targets(practice) => practice.set_weights(weights),
        }
    }

    /// Lets a character play a segment at once, see [`Troupe::play`].
    ///
    /// # Errors
    /// As [`Troupe::play`].
    pub fn play(&mut self, repertoire: &Repertoire<'_>, character: usize, segment: u32) -> Result<(), TroupeError> {
        match &mut self.cast {
            Cast::Pairs(pairs) => pairs.play(repertoire, character, segment),
            Cast::Targets(practice) => practice.play(repertoire, character, segment),
        }
    }

    /// The characters.
    pub fn troupe(&self) -> &Troupe {
        match &self.cast {
            Cast::Pairs(pairs) => pairs.troupe(),
            Cast::Targets(practice) => practice.troupe(),
        }
    }

    /// What became of all blows so far.
    pub fn blows(&self) -> Tally {
        match &self.cast {
            Cast::Pairs(pairs) => pairs.figures().blows,
            Cast::Targets(practice) => practice.figures().blows,
        }
    }

    /// Simulated time. [Unit: s]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }
}

/// Where a hand has dragged a target at a time, on a way that begins anew when it is over. [Unit: m]
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
    fn a_hand_goes_from_place_to_place_and_begins_anew() {
        let point = |time_s, x_m| DragPoint { time_s, x_m, y_m: 0.0, z_m: 0.0 };
        let drag = [point(2.0, 1.0), point(4.0, 1.0), point(6.0, 0.0)];
        for (time, x) in [(0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (3.0, 1.0), (5.0, 0.5), (6.0, 0.0), (7.0, 0.5)] {
            assert!((dragged(&drag, time).x - x).abs() < 1e-6, "{time}");
        }
        assert_eq!(dragged(&[], 3.0), Vec3::ZERO);
    }
}
