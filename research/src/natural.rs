//! Naturalness of reaches beside those of captured motion.

use crate::reaches::{ReachFigures, captured_reaches};
use schemars::JsonSchema;
use serde::Serialize;
use std::error::Error;
use std::path::PathBuf;
use throng_precompute::config::BuildConfig;
use throng_precompute::import;
use throng_precompute::plans;
use throng_precompute::run::News;

/// Figures of many reaches: 5th percentile, median, 95th percentile of each, as seen from the upper chest.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ReachNaturalness {
    /// Number of reaches.
    reaches: usize,
    /// Share of them whose speed has one main peak.
    one_peak: f64,
    /// Peak speed of the hand (m/s).
    peak_mps: [f64; 3],
    /// Greatest height of the elbow above the middle between shoulder and hand (m).
    elbow_m: [f64; 3],
    /// Root mean square of the hand's jerk, times the cube of the time, over the length of the path; the minimum is 26.8.
    jerk: [f64; 3],
    /// Height of the hand above the shoulder at the end (m).
    hand_up_m: [f64; 3],
    /// Shares of these reaches within the percentiles of captured ones: speed, elbow, jerk.
    within_captured: Option<[f64; 3]>,
    /// Share of these reaches whose elbow is within the percentiles of captured ones that end as high; none if there are too
    /// few of them.
    elbow_within_alike: Option<f64>,
    /// Mean number of captured reaches that end as high.
    alike: Option<f64>,
    #[serde(skip)]
    all: Vec<ReachFigures>,
}

/// Largest height difference of ends of comparable reaches (m), and least number of them.
const SIMILAR_HEIGHT_M: f64 = 0.1;
const MIN_SIMILAR: usize = 8;

fn percentiles(mut all: Vec<f64>) -> Option<[f64; 3]> {
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all.get((share * all.len() as f64) as usize).or(all.last()).copied();
    Some([at(0.05)?, at(0.5)?, at(0.95)?])
}

impl ReachNaturalness {
    /// Figures of reaches; none without any.
    ///
    /// - `measure_captured`: captured reaches for comparison.
    pub fn from_reaches(reaches: &[ReachFigures], captured: Option<&Self>) -> Option<Self> {
        let n = reaches.len();
        let column = |of: &dyn Fn(&ReachFigures) -> f64| percentiles(reaches.iter().map(of).collect());
        let columns: [&dyn Fn(&ReachFigures) -> f64; 3] = [&|r| r.peak_mps, &|r| r.elbow_m, &|r| r.jerk];
        let within = captured.map(|c| {
            let ranges = [c.peak_mps, c.elbow_m, c.jerk];
            std::array::from_fn(|k| {
                let [low, _, high] = ranges[k];
                reaches.iter().filter(|r| (low..=high).contains(&columns[k](r))).count() as f64 / n.max(1) as f64
            })
        });
        // High reaches lift the elbow: each is compared with captured ones that end as high.
        let alike: Vec<(f64, Vec<f64>)> = captured.map_or_else(Vec::new, |c| {
            let near = |r: &ReachFigures| {
                let all = c.all.iter().filter(|k| (k.hand_up_m - r.hand_up_m).abs() <= SIMILAR_HEIGHT_M);
                (r.elbow_m, all.map(|k| k.elbow_m).collect::<Vec<_>>())
            };
            reaches.iter().map(near).collect()
        });
        let enough: Vec<&(f64, Vec<f64>)> = alike.iter().filter(|(_, near)| near.len() >= MIN_SIMILAR).collect();
        let inside = enough.iter().filter(|(elbow_m, near)| {
            percentiles(near.clone()).is_some_and(|[low, _, high]| (low..=high).contains(elbow_m))
        });
        let elbow_within_alike = (!enough.is_empty()).then(|| inside.count() as f64 / enough.len() as f64);
        let near = alike.iter().map(|(_, near)| near.len() as f64).sum::<f64>();
        Some(Self {
            reaches: n,
            elbow_within_alike,
            alike: captured.map(|_| near / n.max(1) as f64),
            hand_up_m: column(&|r| r.hand_up_m)?,
            all: reaches.to_vec(),
            one_peak: reaches.iter().filter(|r| r.peaks == 1).count() as f64 / n.max(1) as f64,
            peak_mps: column(columns[0])?,
            elbow_m: column(columns[1])?,
            jerk: column(columns[2])?,
            within_captured: within,
        })
    }

    /// The figures as text.
    pub fn text(&self) -> String {
        let three = |v: [f64; 3]| format!("{:.2} ({:.2} to {:.2})", v[1], v[0], v[2]);
        let within = self.within_captured.map_or_else(String::new, |w| {
            let percent = w.map(|x| format!("{:.0}", 100.0 * x)).join(", ");
            let alike = self.elbow_within_alike.map_or_else(
                || "too few that end as high".into(),
                |share| format!("elbow {:.0} % within those that end as high", 100.0 * share),
            );
            format!("; {percent} % within captured ones, {alike} ({:.0})", self.alike.unwrap_or_default())
        });
        format!(
            "{} reaches, {:.0} % with one peak; hand {} m/s, {} m above the shoulder; elbow {} m up, jerk {}{within}",
            self.reaches,
            100.0 * self.one_peak,
            three(self.peak_mps),
            three(self.hand_up_m),
            three(self.elbow_m),
            three(self.jerk)
        )
    }
}

/// Reaches of all clips of files and folders; none where there are none.
///
/// - `tell`: is told what was found tolerable in the files.
///
/// # Errors
/// Those of reading a file, with its name.
pub fn measure_captured(
    files: &[PathBuf],
    config: &BuildConfig,
    tell: &dyn Fn(News),
) -> Result<Option<ReachNaturalness>, Box<dyn Error>> {
    let mut all = Vec::new();
    for file in import::expand(files)? {
        let clip = plans::file_clip(&file, config, tell).map_err(|e| format!("{}: {e}", file.display()))?;
        all.extend(captured_reaches(&clip.clip, &clip.skeleton));
    }
    Ok(ReachNaturalness::from_reaches(&all, None))
}
