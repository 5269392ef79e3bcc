//! The picture of a trial: the crowd on its way, some of it from near at three moments, and stretches of one character's path.

use super::{
    ArrivalState, BodyFigure, CrowdCharacter, CrowdView, Focus, Picture, PoseStrip, StripFrame, crowd_overview,
    onion_skin, pose_strip, sheet,
};
use crate::trial::{TrialConfig, TrialFrame, TrialMoment, TrialRecord, TrialReport};
use glam::Vec2;
use throng_core::{Bundle, Planar};

/// Time that the strip shows (s).
const STRIP_S: f32 = 2.6;
/// Time that the onion skin shows (s).
const ONION_S: f32 = 5.0;
/// Width of the view from near (m).
const NEAR_M: f32 = 13.0;

/// Draws a trial: the crowd from above, the middle of it from near, then, halfway to the end and at the end, and the recorded
/// character's poses where it walks most and at the end, side by side, and along its path.
pub fn trial_sheet(tables: &Bundle, config: &TrialConfig, report: &TrialReport, record: &TrialRecord) -> Picture {
    let characters = characters(record, config.streams);
    let what = if config.streams { "in two streams that pass each other" } else { "each with a target of its own" };
    let title =
        format!("{}: {} characters, {what}, after {:.1} s", tables.meta().name, report.characters, record.snapshot_s);
    let (reached, reach_m) = (100.0 * report.reached_fraction, config.reach_m);
    let after = report.mean_arrival_s.map_or(String::new(), |s| format!(", after {s:.1} s on average"));
    let (overlaps, slip_mmps) = (report.character_overlaps, 1000.0 * report.foot_slip_p95_mps);
    let subtitle = format!(
        "{reached:.1} % came within {reach_m} m of their targets in {:.0} s{after}; {overlaps} pair(s) were in each other; \
         planted feet slip {slip_mmps:.0} mm/s (95th percentile)",
        report.simulated_s
    );
    let ring = if config.streams { String::new() } else { format!("ring: target, within {:.2} m   ", config.reach_m) };
    let remark = ring + "line: where the root went";
    let marked = config.recorded.filter(|&c| c < record.roots.len()).map(|c| (c, "A"));
    let overview = CrowdView {
        title: &title,
        subtitle: &subtitle,
        size: (1600, 1000),
        characters: &characters,
        walls: &[],
        reach_m: config.reach_m,
        names: if config.streams { ["", "to the right", "to the left"] } else { ["at its target", "on its way", ""] },
        remark: &remark,
        marked,
        focus: None,
    };
    let (title, subtitle, size) = ("The same from near", "arrows: headings", (1600, 720));
    let sum: Vec2 = record.roots.iter().map(|r| Vec2::new(r.x, r.z)).sum();
    let focus = Some(Focus { centre: sum / record.roots.len().max(1) as f32, width_m: NEAR_M });
    let near = CrowdView { title, subtitle, size, marked: None, focus, ..overview };
    let later: Vec<(String, Vec<CrowdCharacter<'_>>)> = record
        .later
        .iter()
        .map(|moment| (format!("After {:.1} s", moment.time_s), characters_at(record, moment, config.streams)))
        .collect();
    let near_later = later.iter().map(|(title, characters)| CrowdView { title, characters, ..near });
    let frames = strip_frames(record);
    let strip = PoseStrip {
        title: "Character A",
        subtitle: "from its right and from the front; bars: heels and toes on the ground; left is orange",
        frames: longest_stretch(&frames, STRIP_S),
        columns: 12,
        front_row: true,
        width: 1600,
    };
    let (title, subtitle) = ("Character A on its way", "poses where they were, older ones paler");
    let way = PoseStrip { title, subtitle, frames: longest_stretch(&frames, ONION_S), columns: 13, ..strip };
    let end = PoseStrip { title: "Character A at the end", frames: last_stretch(&frames, STRIP_S), ..strip };
    let mut pictures = vec![crowd_overview(&overview), crowd_overview(&near)];
    pictures.extend(near_later.map(|view| crowd_overview(&view)));
    if !frames.is_empty() {
        pictures.extend([pose_strip(&strip), pose_strip(&end), onion_skin(&way)]);
    }
    sheet(&pictures.iter().collect::<Vec<_>>())
}

/// The characters at a later moment, without trails.
fn characters_at<'a>(record: &'a TrialRecord, moment: &'a TrialMoment, streams: bool) -> Vec<CrowdCharacter<'a>> {
    let of_moment = |(c, character): (usize, CrowdCharacter<'a>)| CrowdCharacter {
        root: moment.roots[c],
        figure: moment.poses.get(c).map(BodyFigure::from_positions),
        trail: &[],
        arrival: match character.arrival {
            ArrivalState::OnTheWay if !streams && record.arrivals_s[c] <= moment.time_s => ArrivalState::Reached,
            other => other,
        },
        ..character
    };
    characters(record, streams).into_iter().enumerate().map(of_moment).collect()
}

/// The last frames of `duration_s`; all of a shorter motion.
fn last_stretch(frames: &[StripFrame], duration_s: f32) -> &[StripFrame] {
    let from = frames.last().map_or(0.0, |last| last.time_s - duration_s);
    &frames[frames.partition_point(|f| f.time_s < from)..]
}

fn characters(record: &TrialRecord, streams: bool) -> Vec<CrowdCharacter<'_>> {
    let one = |(c, &root): (usize, &Planar)| CrowdCharacter {
        root,
        figure: record.poses.get(c).map(BodyFigure::from_positions),
        trail: record.trails.get(c).map_or(&[], Vec::as_slice),
        target: record.targets.get(c).map(|t| Vec2::new(t.x, t.z)).filter(|_| !streams),
        arrival: match (record.arrivals_s.get(c), record.targets.get(c), record.trails.get(c).and_then(|t| t.first())) {
            (_, Some(to), Some(from)) if streams && to.x < from.x => ArrivalState::OnTheWayBack,
            (Some(&t), ..) if !streams && t <= record.snapshot_s => ArrivalState::Reached,
            _ => ArrivalState::OnTheWay,
        },
    };
    record.roots.iter().enumerate().map(one).collect()
}

fn strip_frames(record: &TrialRecord) -> Vec<StripFrame> {
    let one = |&TrialFrame { time_s, root, ref positions, contacts, .. }: &TrialFrame| StripFrame {
        time_s,
        root,
        figure: BodyFigure::from_positions(positions),
        contacts,
    };
    record.frames.iter().map(one).collect()
}

/// The frames of `duration_s` in which the root travels farthest; all frames of a shorter motion.
fn longest_stretch(frames: &[StripFrame], duration_s: f32) -> &[StripFrame] {
    let mut gone = vec![0.0f32];
    for pair in frames.windows(2) {
        gone.push(gone[gone.len() - 1] + (pair[1].root.translation() - pair[0].root.translation()).length());
    }
    let num = frames.iter().take_while(|f| f.time_s - frames[0].time_s <= duration_s).count();
    let last_start = frames.len() - num;
    let way = |s: usize| gone[s + num.max(1) - 1] - gone[s];
    let best = (0..=last_start).rev().max_by(|&a, &b| way(a).total_cmp(&way(b))).unwrap_or(0);
    frames.get(best..best + num).unwrap_or(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::{Contacts, Skeleton};

    #[test]
    fn the_stretch_is_where_the_root_goes_farthest() {
        let figure = BodyFigure::from_positions(&Skeleton::default().rest_positions());
        let mut x = 0.0;
        let frames: Vec<StripFrame> = (0..300)
            .map(|i| {
                x += if (100..160).contains(&i) { 0.05 } else { 0.001 };
                let root = Planar::new(x, 0.0, 0.0);
                StripFrame { time_s: i as f32 / 30.0, root, figure, contacts: Contacts::NONE }
            })
            .collect();
        let found = longest_stretch(&frames, 2.0);
        let first = (found[0].time_s * 30.0).round() as usize;
        assert_eq!(found.len(), 61);
        assert!((99..=100).contains(&first), "{first}");
        assert_eq!(longest_stretch(&frames[..10], 2.0).len(), 10);
        assert!(longest_stretch(&[], 2.0).is_empty());
    }
}
