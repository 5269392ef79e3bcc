//! The picture of a trial: the crowd from above, one character's poses below.

use super::{
    Arrival, CrowdCharacter, CrowdView, Figure, Picture, PoseStrip, StripFrame, crowd_overview, onion_skin, pose_strip,
    sheet,
};
use crate::trial::{TrialConfig, TrialFrame, TrialRecord, TrialReport};
use glam::Vec2;
use throng_runtime::Tables;

/// Time of the recorded character that the strips show: from the beginning, in which it turns and walks. [Unit: s]
const STRIP_S: f32 = 5.0;

/// Draws a trial: overview, poses side by side, poses along the way.
pub fn trial_sheet(tables: &Tables, config: &TrialConfig, report: &TrialReport, record: &TrialRecord) -> Picture {
    
    let figures = record.poses.iter().map(|p| Figure::from_positions(p));
    let characters: Vec<CrowdCharacter<'_>> = figures
        .enumerate()
        .map(|(c, figure)| CrowdCharacter {
            root: record.roots[c],
            figure: Some(figure),
            trail: &record.trails[c],
            target: Some(Vec2::new(record.targets[c].x, record.targets[c].z)),
            arrival: if record.arrivals_s[c].is_finite() { Arrival::Reached } else { Arrival::OnTheWay },
        })
        .collect();
    let subtitle = format!(
        "{:.1} % came within {} m of their target within {:.0} s, after {:.1} s on average; planted feet slip {:.0} mm/s (95th percentile)",
        100.0 * report.reached_fraction,
        config.reach_m,
        report.simulated_s,
        report.mean_arrival_s,
        1000.0 * report.foot_slip_p95_mps
    );
    let name = format!("character {}", config.recorded);
    let title = format!("{}: {} characters, each with a target of its own", tables.meta().name, report.characters);
    let overview = crowd_overview(&CrowdView {
        title: &title,
        subtitle: &subtitle,
        size: (1600, 1000),
        characters: &characters,
        reach_m: config.reach_m,
        marked: Some((config.recorded, &name)),
    });
    let shown: Vec<StripFrame> =
        record.frames.iter().take_while(|f| f.time_s <= STRIP_S).map(strip_frame).collect();
    let strip = PoseStrip {
        title: &format!("Character {}, the first {STRIP_S} s", config.recorded),
        subtitle: "poses from its right side, facing right; contacts of heels and toes below",
        frames: &shown,
        columns: 16,
        front_row: false,
        width: 1600,
    };
    let path = PoseStrip { title: "The same along its way", subtitle: "", ..strip };
    sheet(&[&overview, &pose_strip(&strip), &onion_skin(&path)])
}

fn strip_frame(f: &TrialFrame) -> StripFrame {
    let figure = Figure::from_positions(&f.positions);
    StripFrame { time_s: f.time_s, root: f.root, figure, contacts: f.contacts }
}
