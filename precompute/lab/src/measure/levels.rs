//! Cost of a character at each level of detail.

use super::BundleMeasureConfig;
use super::timing::{fail, random_order, random_starts, run_in_pool};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::time::Instant;
use throng_base::maths::quantile;
use throng_core::characters::{Characters, CharactersConfig, Detail, MotionSet, PolicyOrder};
use throng_core::{Bundle, Error};
use throng_motion::{error::Result, memory::resident_bytes};

/// Steps of a round, a second of simulated time.
const STEPS: usize = 60;
/// Least number of characters whose memory stands out from the rest of the process.
const MIN_FOR_MEMORY: usize = 10_000;

/// Figures of one group of people at each level, in turns on one thread; medians over rounds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LevelFigures {
    /// Number of characters.
    pub characters: usize,
    /// A step with full poses and records (ns a character).
    pub full_ns: f64,
    /// A step without locked feet (ns a character).
    pub free_feet_ns: f64,
    /// A step that only writes records (ns a character).
    pub record_ns: f64,
    /// Memory of a character that was never posed, its record included; absent below 10 000 characters or where the system
    /// does not report it (bytes a character).
    pub record_bytes: Option<f64>,
}

/// Measures steps at each level of detail.
///
/// # Errors
/// [`throng_motion::error::BuildError::Stage`] where the bundle has no behaviour or a number is out of range.
pub fn levels(tables: &Bundle, config: &BundleMeasureConfig) -> Result<Vec<LevelFigures>> {
    config.check(tables)?;
    let motion_set = MotionSet::new(tables);
    let one = |&n: &usize| run_in_pool(1, || LevelTestCrowd::new(&motion_set, n)?.measure(config.seconds)).flatten();
    config.characters.iter().map(one).collect()
}

/// People who walk to targets that change every second.
struct LevelTestCrowd<'a> {
    motion_set: &'a MotionSet,
    characters: Characters,
    orders: Vec<PolicyOrder>,
    rng: Pcg64Mcg,
    record_bytes: Option<f64>,
}

impl<'a> LevelTestCrowd<'a> {
    fn new(motion_set: &'a MotionSet, n: usize) -> Result<Self> {
        let mut rng = Pcg64Mcg::seed_from_u64(6);
        let side = 2.0 * (n as f32).sqrt();
        let starts = random_starts(motion_set, n, side / 2.0, &mut rng);
        let orders = vec![PolicyOrder::IDLE; n];
        let config = CharactersConfig { instances: true, ..CharactersConfig::default() };
        let before = resident_bytes();
        let characters = Characters::new(motion_set, config, &starts).map_err(|e| fail(e.to_string()))?;
        let mut out = Self { motion_set, characters, orders, rng, record_bytes: None };
        out.time_round(Some(Detail::RECORDS))?;
        if let (Some(before), Some(now), true) = (before, resident_bytes(), n >= MIN_FOR_MEMORY) {
            out.record_bytes = Some(now.saturating_sub(before) as f64 / n as f64);
        }
        Ok(out)
    }

    /// Time of a round (ns a character and step).
    fn time_round(&mut self, detail: Option<Detail>) -> Result<f64> {
        let wrong = |e: Error| fail(e.to_string());
        self.orders.fill_with(|| random_order(&mut self.rng));
        self.characters.set_detail(detail).map_err(wrong)?;
        // Bodies that wake are not counted.
        self.characters.step(self.motion_set, 0.0, &self.orders).map_err(wrong)?;
        let begin = Instant::now();
        for _ in 0..STEPS {
            self.characters.step(self.motion_set, 1.0 / STEPS as f32, &self.orders).map_err(wrong)?;
        }
        Ok(begin.elapsed().as_secs_f64() * 1e9 / (STEPS * self.orders.len()) as f64)
    }

    fn measure(mut self, seconds: f64) -> Result<LevelFigures> {
        let far = Detail { posed_m: 1e5, ..Detail::RECORDS };
        let mut times = [const { Vec::new() }; 3];
        let begin = Instant::now();
        while times[0].len() < 5 || begin.elapsed().as_secs_f64() < 3.0 * seconds {
            for (times, detail) in times.iter_mut().zip([None, Some(far), Some(Detail::RECORDS)]) {
                times.push(self.time_round(detail)?);
            }
        }
        let [full_ns, free_feet_ns, record_ns] = times.map(|t| quantile(t, [1, 2]).unwrap_or_default());
        let (characters, record_bytes) = (self.orders.len(), self.record_bytes);
        Ok(LevelFigures { characters, full_ns, free_feet_ns, record_ns, record_bytes })
    }
}
