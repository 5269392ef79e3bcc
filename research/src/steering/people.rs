//! Crowds beside people: the fundamental diagram, lanes, flow through gaps, stripes where streams cross.

use super::ground::{self, People};
use super::trial::{SteeringFigures, run};
use glam::Vec2;
use serde::Serialize;
use throng_crowd::{CrowdError, CrowdSetup, ForceField};

/// Speed of people at a density (m/s), Weidmann 1993, Transporttechnik der Fussgaenger, eq. 6: free 1.34 m/s, none at 5.4 1/m2.
pub fn weidmann_mps(density: f64) -> f64 {
    1.34 * (1.0 - (-1.913 * (1.0 / density - 1.0 / 5.4)).exp())
}

/// All that is compared with people.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct PeopleFigures {
    /// Closed rings, one-way and two-way.
    pub results: Vec<RingFigures>,
    /// Crowds before gaps.
    pub gaps: Vec<GapFigures>,
    /// Where two streams cross at 90 degrees: how much likelier a neighbour along a stripe is of one's own stream than one
    /// across; people form stripes at 45 degrees (0 none, 1 all).
    pub stripe_order: f64,
}

/// A closed ring 4 m wide; for lanes, 5 m.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct RingFigures {
    /// Agents on a square metre.
    pub density_per_m2: f64,
    /// 1 where all go round one way, 2 where every second one goes the other way.
    pub ways: usize,
    /// Mean speed along the ring from 10 s on (m/s).
    pub speed_mps: f64,
    /// Agents that pass a line across the ring, for each metre of it (1/(m s)).
    pub flow_per_m_s: f64,
    /// Speed of people at this density, one way (m/s).
    pub weidmann_mps: f64,
    /// Agents that ever stood for 10 s.
    pub stuck: usize,
    /// Lanes across 5 m after 30 s where no side is told to keep right; two-way alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lanes_counted: Option<f64>,
    /// Width of those lanes (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lane_width_m: Option<f64>,
}

/// A crowd of 150 that leaves through a gap in a wall.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct GapFigures {
    /// Width of the gap (m).
    pub width_m: f64,
    /// Flow from the tenth agent to the last but thirty; people 1.2 to 1.9 (Seyfried et al. 2009) (1/(m s)).
    pub flow_per_m_s: f64,
    /// Longest time between two who pass, while more than thirty wait (s).
    pub longest_wait_s: f64,
}

/// Densities of the rings (1/m2).
pub const DENSITIES: [f32; 8] = [0.2, 0.5, 1.0, 1.5, 2.0, 2.3, 2.5, 3.0];
/// Widths of the gaps (m).
pub const GAPS_M: [f32; 6] = [0.9, 1.2, 1.5, 2.0, 2.5, 3.0];
/// As wide as people where it is dense: shoulders are 0.46 m (Weidmann 1993).
const PEOPLE: People = People { radius_m: [0.21, 0.25], speed_mps: [1.34, 0.26] };

/// Compares crowds with people.
///
/// # Errors
/// As [`run`].
pub fn people(seed: u64, change: &dyn Fn(&mut CrowdSetup)) -> Result<PeopleFigures, CrowdError> {
    let change = &|setup: &mut CrowdSetup| {
        setup.fields = vec![ForceField { crowd_speed: 1.12, ..ForceField::COMMUTER }];
        change(setup);
    };
    let mut out = PeopleFigures::default();
    for ways in [1, 2] {
        for density in DENSITIES {
            out.results.push(ring((seed, density, ways), change)?);
        }
    }
    for width in GAPS_M {
        out.gaps.push(gap((seed, width), change)?);
    }
    out.stripe_order = stripes(seed, change)?;
    Ok(out)
}

fn ring((seed, density, ways): (u64, f32, usize), change: &dyn Fn(&mut CrowdSetup)) -> Result<RingFigures, CrowdError> {
    let mut setup = ground::ring(seed, PEOPLE, (density, 4.0), ways).finish();
    change(&mut setup);
    let figures = run(setup, 60.0, &mut |_, _, _, _| {})?;
    let later = &figures.speed_by_10s_mps[1..];
    let speed_mps = later.iter().sum::<f64>() / later.len() as f64;
    let lanes = match ways {
        2 => Some(lanes((seed, density), change)?),
        _ => None,
    };
    Ok(RingFigures {
        density_per_m2: f64::from(density),
        ways,
        speed_mps,
        flow_per_m_s: speed_mps * f64::from(density),
        weidmann_mps: weidmann_mps(f64::from(density)),
        stuck: figures.stuck,
        lanes_counted: lanes,
        lane_width_m: lanes.map(|n| 5.0 / n),
    })
}

/// Lanes across a ring 5 m wide after 30 s, without rules of sides: those who go one way, then the other, from inside out,
/// mean over all sectors.
fn lanes((seed, density): (u64, f32), change: &dyn Fn(&mut CrowdSetup)) -> Result<f64, CrowdError> {
    const SECTORS: usize = 24;
    const BINS: usize = 10;
    let mut setup = ground::ring(seed, PEOPLE, (density, 5.0), 2).finish();
    change(&mut setup);
    setup.config.steering.keep_right = 0.0;
    setup.fields.iter_mut().for_each(|f| (f.right, f.evading) = (0.0, 0.0));
    let mut sums = vec![[0i32; BINS]; SECTORS];
    run(setup, 30.0, &mut |now, number, at: Vec2, _| {
        if now > 29.95 {
            let sector = ((at.to_angle() / std::f32::consts::TAU + 0.5) * SECTORS as f32) as usize % SECTORS;
            let bin = ((at.length() - 12.0) / 0.5).clamp(0.0, BINS as f32 - 1.0) as usize;
            sums[sector][bin] += if number % 2 == 0 { 1 } else { -1 };
        }
    })?;
    let counted = sums.iter().map(|bins| {
        let signs: Vec<i32> = bins.iter().map(|b| b.signum()).filter(|s| *s != 0).collect();
        1 + signs.windows(2).filter(|w| w[0] != w[1]).count()
    });
    let counted: Vec<usize> = counted.collect();
    Ok(counted.iter().sum::<usize>() as f64 / counted.len() as f64)
}

fn gap((seed, width): (u64, f32), change: &dyn Fn(&mut CrowdSetup)) -> Result<GapFigures, CrowdError> {
    let mut setup = ground::gap(seed, PEOPLE, width, 150).finish();
    change(&mut setup);
    let mut passed = vec![f64::INFINITY; setup.agents.len()];
    run(setup, 180.0, &mut |now, number, at: Vec2, _| {
        if at.x > 0.0 && passed[number] == f64::INFINITY {
            passed[number] = now;
        }
    })?;
    passed.sort_unstable_by(f64::total_cmp);
    let (first, last) = (10, passed.len().saturating_sub(30));
    let waits = passed[first..last].windows(2).map(|w| w[1] - w[0]);
    Ok(GapFigures {
        width_m: f64::from(width),
        flow_per_m_s: (last - 1 - first) as f64 / (passed[last - 1] - passed[first]) / f64::from(width),
        longest_wait_s: waits.fold(0.0, f64::max),
    })
}

/// See [`PeopleFigures::stripe_order`].
fn stripes(seed: u64, change: &dyn Fn(&mut CrowdSetup)) -> Result<f64, CrowdError> {
    let mut setup = ground::streams(seed, PEOPLE, 150).finish();
    change(&mut setup);
    let half = setup.agents.len() / 2;
    let mut now_here: (f64, Vec<(usize, Vec2)>) = (0.0, Vec::new());
    let mut pairs = [[0usize; 2]; 2];
    run(setup, 30.0, &mut |now, number, at: Vec2, _| {
        if now != now_here.0 {
            count_pairs(&now_here.1, half, &mut pairs);
            now_here = (now, Vec::new());
        }
        // Where both streams are, once they have met.
        if now > 8.0 && at.x.abs() < 5.0 && at.y.abs() < 5.0 {
            now_here.1.push((number, at));
        }
    })?;
    let share = |[same, other]: [usize; 2]| same as f64 / (same + other).max(1) as f64;
    Ok(share(pairs[0]) - share(pairs[1]))
}

/// Pairs of neighbours along stripes and across them: of one stream, of both.
fn count_pairs(here: &[(usize, Vec2)], half: usize, pairs: &mut [[usize; 2]; 2]) {
    for (i, (a, p)) in here.iter().enumerate() {
        for (b, q) in &here[..i] {
            let off = *q - *p;
            if off.length() < 2.0 {
                // Both go on along (1, 1) together: stripes lie across that.
                let along = (off.x - off.y).abs();
                let across = (off.x + off.y).abs();
                let is_other = usize::from((*a < half) != (*b < half));
                if along > 2.0 * across {
                    pairs[0][is_other] += 1;
                } else if across > 2.0 * along {
                    pairs[1][is_other] += 1;
                }
            }
        }
    }
}

/// What is said of a run in one line.
pub fn row(name: &str, f: &SteeringFigures) -> String {
    let by_10s: Vec<String> = f.speed_by_10s_mps.iter().map(|v| format!("{v:.2}")).collect();
    format!(
        "{name:21} {:5} {:5.2} {:6} {:6} {:6} {:8.2} {:7.3} {:8.2}  {}",
        f.agents,
        f.speed_mps,
        f.stuck,
        f.stuck_at_end,
        f.not_there,
        f.us_per_agent_second,
        f.setup_s,
        1000.0 * f.max_overlap_m,
        by_10s.join(" ")
    )
}

/// What stands above the columns of [`row`].
pub const HEADINGS: &str =
    "scene                agents   m/s  stuck at end   left us/agent/s setup s deepest mm  m/s by 10 s";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_of_people_are_those_of_the_diagram() {
        for (density, speed) in [(0.5, 1.30), (1.0, 1.06), (1.5, 0.81), (2.0, 0.61), (2.5, 0.45)] {
            assert!((weidmann_mps(density) - speed).abs() < 0.02, "{density}: {}", weidmann_mps(density));
        }
    }
}
