//! The same targets for policies and for matching: how soon they are reached, how often they are hit.

use super::MatchingConfig;
use super::movers::{Aim, ByMatching, ByPolicy, Mover, local};
use crate::matching::{BoxSearch, Character, Database, Nearest, Row};
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use std::f32::consts::TAU;
use throng_core::policy::{KIND_CYLINDER, KIND_POLAR, PolicyTable};
use throng_core::{Bundle, Planar};
use throng_lab::measure::timing::fail;
use throng_motion::error::BuildError;

/// Radius of the circle on which the target of hits moves (m).
const CIRCLE_M: f32 = 0.6;

/// When targets were reached; infinite where they were not (s).
pub(super) struct Arrivals(Vec<f32>);

impl Arrivals {
    /// Share of the targets that were reached.
    pub fn reached_fraction(&self) -> f64 {
        self.0.iter().filter(|t| t.is_finite()).count() as f64 / self.0.len().max(1) as f64
    }

    /// Mean time of those, if there are any (s).
    pub fn mean_s(&self) -> Option<f64> {
        let reached: Vec<f64> = self.0.iter().filter(|t| t.is_finite()).map(|&t| f64::from(t)).collect();
        (!reached.is_empty()).then(|| reached.iter().sum::<f64>() / reached.len() as f64)
    }
}

/// A state to start in, and where the target is from there.
struct TrialStart {
    state: u32,
    target: Vec3,
    /// Of the target's circle (rad).
    phase: f32,
}

/// Both sides of the comparison.
pub(super) struct Scene<'a> {
    tables: &'a Bundle,
    pub database: &'a Database,
    pub boxes: &'a BoxSearch<'a>,
    config: &'a MatchingConfig,
    /// Names of the policies.
    pub names: Vec<String>,
    /// The policy that approaches, then the one for hits if there is one.
    goals: Vec<(PolicyTable, f32)>,
    aim: Aim,
}

impl<'a> Scene<'a> {
    /// Takes the policy that approaches on the finest grid, and the finest one for hits.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where none approaches.
    pub fn new(
        tables: &'a Bundle,
        database: &'a Database,
        boxes: &'a BoxSearch<'a>,
        config: &'a MatchingConfig,
    ) -> Result<Self, BuildError> {
        let all = || tables.policies().iter().enumerate();
        let finest =
            |kind: u32| all().filter(|(_, p)| p.grid().record().kind == kind).max_by_key(|(_, p)| p.grid().num_cells());
        let Some((first, approach)) = finest(KIND_POLAR) else {
            return Err(fail("matching is compared with a behaviour of the kind `approach`, and the bundle has none"));
        };
        let mut goals = vec![(approach.clone(), 1.0)];
        let hits = finest(KIND_CYLINDER);
        goals.extend(hits.map(|(_, p)| (p.clone(), config.hit_weight)));
        let numbers = [Some(first), hits.map(|h| h.0)];
        let names = numbers.into_iter().flatten().map(|i| tables.meta().behaviours[i].clone()).collect();
        let stand_off = approach.centre().length();
        let aim = Aim { stand_off, speed_mps: database.speed_quantile(config.speed_share), reach: None };
        Ok(Self { tables, database, boxes, config, goals, names, aim })
    }

    /// The policy that approaches.
    pub fn policy(&self) -> &PolicyTable {
        &self.goals[0].0
    }

    /// Random states, with targets around them at a distance and a height (m).
    fn starts(&self, count: usize, distances: [f32; 2], height: f32) -> Vec<TrialStart> {
        let mut rng = Pcg64Mcg::seed_from_u64(self.config.seed);
        let num_states = self.tables.graph().states.len() as u32;
        let mut start = |_| {
            let (angle, distance) = (rng.random_range(0.0..TAU), rng.random_range(distances[0]..=distances[1]));
            let target = Vec3::new(distance * angle.sin(), height, distance * angle.cos());
            TrialStart { state: rng.random_range(0..num_states), target, phase: rng.random_range(0.0..TAU) }
        };
        (0..count).map(&mut start).collect()
    }

    fn by_matching(&self, start: &TrialStart, aim: Aim, keep: bool) -> ByMatching<'a> {
        let frame = self.tables.graph().states[start.state as usize].frame;
        let character = Character::new(Planar::IDENTITY, frame);
        let asked = keep.then(Vec::new);
        ByMatching { database: self.database, boxes: self.boxes, aim, character, asked }
    }

    /// How soon standing targets are reached by the policy that approaches and by matching, and what matching asked.
    pub fn reach(&self) -> (Arrivals, Arrivals, Vec<(Row, Nearest)>) {
        let starts = self.starts(self.config.characters, self.config.distances, 0.0);
        let goals = &self.goals[..1];
        let by_policy = starts.par_iter().map(|s| {
            self.arrival(&mut ByPolicy::new(self.tables, goals, Planar::IDENTITY, s.state, s.target), s.target)
        });
        let by_matching = starts.par_iter().map(|s| {
            let mut mover = self.by_matching(s, self.aim, true);
            (self.arrival(&mut mover, s.target), mover.asked.unwrap_or_default())
        });
        let (arrivals, asked): (Vec<f32>, Vec<Vec<_>>) = by_matching.unzip();
        (Arrivals(by_policy.collect()), Arrivals(arrivals), asked.concat())
    }

    /// When the place that is to be brought to the target comes near it (s).
    fn arrival(&self, mover: &mut dyn Mover, target: Vec3) -> f32 {
        let centre = self.policy().centre();
        let rate = self.database.rate_hz();
        for frame in 0..=(self.config.reach_s * rate) as u32 {
            if local(mover.root(), target).with_y(0.0).distance(centre) < self.config.reach_m {
                return frame as f32 / rate;
            }
            mover.step(target, false);
        }
        f32::INFINITY
    }

    /// What the policies and matching do with a moving target in a while; nothing without a policy for hits.
    pub fn spar(&self) -> Option<[Sparring; 2]> {
        let (punches, _) = self.goals.get(1)?;
        let r = punches.grid().record();
        let [low, high] = [r.height_start, r.height_start + r.height_spacing * (r.num_heights - 1) as f32];
        let head = self.tables.skeleton().rest_positions()[throng_core::Joint::Head.index()].y;
        let distance = 0.5 * (r.ring_start + punches.grid().radius());
        let starts = self.starts(self.config.characters.div_ceil(4), [distance; 2], head.clamp(low, high));
        let aim = Aim { reach: Some(*punches.region()), ..self.aim };
        let within = punches.reward().record().scale;
        let by_policy = starts.par_iter().map(|s| {
            let mut mover = ByPolicy::new(self.tables, &self.goals, Planar::IDENTITY, s.state, s.target);
            self.watch(&mut mover, s, within)
        });
        let by_matching = starts.par_iter().map(|s| self.watch(&mut self.by_matching(s, aim, false), s, within));
        Some([by_policy.collect::<Vec<_>>(), by_matching.collect()].map(|all| all.iter().sum()))
    }

    /// Counts the effective hits that land within a distance of the target, which moves on a circle.
    fn watch(&self, mover: &mut dyn Mover, start: &TrialStart, within: f32) -> Sparring {
        let rate = self.database.rate_hz();
        let hits = self.tables.hits();
        let mut out = Sparring { minutes: f64::from(self.config.hits_s) / 60.0, ..Sparring::default() };
        let mut is_hit = false;
        let on_circle = |angle: f32| CIRCLE_M * Vec3::new(angle.sin(), 0.0, angle.cos());
        for frame in 1..=(self.config.hits_s * rate) as u32 {
            let angle = start.phase + self.config.target_mps / CIRCLE_M * frame as f32 / rate;
            let target = start.target + on_circle(angle) - on_circle(start.phase);
            let before = mover.frame();
            if let Some(now) = mover.step(target, is_hit) {
                out.jumps += 1;
                out.gap_sum_m += f64::from(self.database.gap(before, now));
            }
            let first = hits.partition_point(|h| h.frame < mover.frame());
            let here = hits[first..].iter().take_while(|h| h.frame == mover.frame());
            is_hit = false;
            for hit in here {
                is_hit = true;
                let place = hit.position();
                let ground = mover.root().transform_point(Vec2::new(place.x, place.z));
                out.thrown += 1;
                out.landed += u32::from(Vec3::new(ground.x, place.y, ground.y).distance(target) < within);
            }
        }
        out
    }
}

/// What was done with a moving target.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sparring {
    minutes: f64,
    thrown: u32,
    landed: u32,
    jumps: u32,
    gap_sum_m: f64,
}

impl Sparring {
    /// Hits a minute that land.
    pub fn landed_per_minute(&self) -> f64 {
        f64::from(self.landed) / self.minutes
    }

    /// Share of the hits that land; none where nothing is thrown.
    pub fn landed_fraction(&self) -> Option<f64> {
        (self.thrown > 0).then(|| f64::from(self.landed) / f64::from(self.thrown))
    }

    /// Distance of hips, feet and fists where another frame takes the place of the one that plays, mean; none where
    /// that never happens (m).
    pub fn gap_m(&self) -> Option<f64> {
        (self.jumps > 0).then(|| self.gap_sum_m / f64::from(self.jumps))
    }
}

impl<'a> std::iter::Sum<&'a Sparring> for Sparring {
    fn sum<I: Iterator<Item = &'a Sparring>>(all: I) -> Self {
        all.fold(Self::default(), |a, b| Self {
            minutes: a.minutes + b.minutes,
            thrown: a.thrown + b.thrown,
            landed: a.landed + b.landed,
            jumps: a.jumps + b.jumps,
            gap_sum_m: a.gap_sum_m + b.gap_sum_m,
        })
    }
}
