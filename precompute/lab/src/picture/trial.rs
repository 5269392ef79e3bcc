//! The picture of a trial: the crowd on its way, some of it from near at three moments, and stretches of one character's path.

use super::text::{Align, TextStyle, draw_text};
use super::{
    BodyColours, BodyFigure, Colour, Picture, WorldCamera, WorldFigure, WorldMoment, WorldSheet, WorldStrip, colour,
    sheet, world_sheet, world_strip,
};
use super::{blends::blend_strips, canvas::Area, furniture::header};
use crate::trial::{TrialConfig, TrialFrame, TrialMoment, TrialRecord, TrialReport};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};
use throng_bake::environment::UnitSolid;
use throng_core::{Bundle, Contacts, Joint};
use throng_motion::clip::runs_where;

/// Time that the strip shows (s).
const STRIP_S: f32 = 2.6;
/// Time that is shown along the path (s).
const PATH_S: f32 = 5.0;
/// Number of poses of a strip, and along the path.
const COLUMNS: usize = 12;
/// Width that a pose of a strip shows (m).
const POSE_M: f32 = 1.7;
/// Width of the view from near (m).
const NEAR_M: f32 = 13.0;
/// Blend spaces that are shown at most.
const BLEND_SPACES: usize = 4;
/// Parts of the feet with the joints above them, and the colours of their sides.
const FEET: [(Contacts, Joint, Colour); 4] = [
    (Contacts::LEFT_HEEL, Joint::LeftFoot, colour::LEFT),
    (Contacts::LEFT_TOE, Joint::LeftToe, colour::LEFT),
    (Contacts::RIGHT_HEEL, Joint::RightFoot, colour::RIGHT),
    (Contacts::RIGHT_TOE, Joint::RightToe, colour::RIGHT),
];

/// Draws a trial: the crowd from above, the middle of it from near, then, halfway to the end and at the end, and the recorded
/// character's poses where it walks most and at the end, side by side, and along its path; below them the blend spaces of
/// the lowest quality.
///
/// # Errors
/// As [`super::blend_sheet`].
pub fn trial_sheet(
    tables: &Bundle,
    config: &TrialConfig,
    report: &TrialReport,
    record: &TrialRecord,
) -> throng_core::Result<Picture> {
    let what = if config.streams { "in two streams that pass each other" } else { "each with a target of its own" };
    let after_s = record.moments.first().map_or(0.0, |first| first.time_s);
    let title = format!("{}: {} characters, {what}, after {after_s:.1} s", tables.meta().name, report.characters);
    let (reached, reach_m) = (100.0 * report.reached_fraction, config.reach_m);
    let after = report.mean_arrival_s.map_or(String::new(), |s| format!(", after {s:.1} s on average"));
    let (overlaps, slip_mmps) = (report.character_overlaps, 1000.0 * report.foot_slip_p95_mps);
    let subtitle = format!(
        "{reached:.1} % came within {reach_m} m of their targets in {:.0} s{after}; {overlaps} pair(s) were in each other; \
         planted feet slip {slip_mmps:.0} mm/s (95th percentile)",
        report.simulated_s
    );
    let mut pictures = Vec::new();
    for (i, moment) in record.moments.iter().enumerate() {
        let near = |title| WorldSheet { title, subtitle: "from near", size: (1600, 720), ..WorldSheet::default() };
        let middle: Vec3 = moment.poses.iter().map(|p| p[Joint::Hips.index()]).sum();
        let camera = WorldCamera { heading: PI, elevation: 0.62, ..WorldCamera::default() };
        let focus = Some((middle / moment.poses.len().max(1) as f32, NEAR_M));
        if i == 0 {
            let camera = WorldCamera { elevation: 1.0, ..camera };
            let view = WorldSheet { subtitle: &subtitle, size: (1600, 1000), camera, ..near(&title) };
            pictures.push(draw_crowd(config, record, moment, &view, true));
        }
        let after = format!("After {:.1} s", moment.time_s);
        let view = WorldSheet { camera: WorldCamera { focus, ..camera }, ..near(&after) };
        pictures.push(draw_crowd(config, record, moment, &view, i == 0));
    }
    let walk = longest_stretch(&record.frames, STRIP_S);
    if !walk.is_empty() {
        pictures.extend(strips("Character A", walk));
        pictures.push(gait_diagram(walk));
        pictures.extend(strips("Character A at the end", last_stretch(&record.frames, STRIP_S)));
        pictures.push(path_sheet(longest_stretch(&record.frames, PATH_S)));
    }
    pictures.extend(blend_strips(tables, BLEND_SPACES)?);
    Ok(sheet(&pictures.iter().collect::<Vec<_>>()))
}

/// Draws the crowd at a moment.
///
/// - `has_trails`: with the ways of the roots until then.
fn draw_crowd(
    config: &TrialConfig,
    record: &TrialRecord,
    moment: &TrialMoment,
    view: &WorldSheet<'_>,
    has_trails: bool,
) -> Picture {
    let state = |c: usize| match record.trails[c].first() {
        Some(from) if config.streams && record.targets[c].x < from.x => 2,
        _ if !config.streams && record.arrivals_s[c] <= moment.time_s => 0,
        _ => 1,
    };
    let tint = |c: usize| [colour::REACHED, colour::ON_THE_WAY, colour::RIGHT][state(c)];
    let all = 0..moment.poses.len();
    let body = |c: usize| WorldFigure {
        figure: BodyFigure::from_positions(&moment.poses[c]),
        colours: BodyColours::plain(tint(c)),
    };
    let on_ground = |p: &Vec2| Vec3::new(p.x, 0.0, p.y);
    let trail = |c: usize| (record.trails[c].iter().map(on_ground).collect(), tint(c));
    let mut trails: Vec<(Vec<Vec3>, Colour)> = all.clone().filter(|_| has_trails).map(trail).collect();
    let mut rings = Vec::new();
    for c in all.clone().filter(|_| !config.streams) {
        let is_on_the_way = state(c) > 0;
        rings.push((record.targets[c], config.reach_m, tint(c).alpha(if is_on_the_way { 0.7 } else { 0.3 })));
        let root = moment.poses[c][Joint::Hips.index()].with_y(0.0);
        trails.extend(is_on_the_way.then(|| (vec![root, record.targets[c]], tint(c).alpha(0.4))));
    }
    let shown = config.recorded.filter(|_| view.camera.focus.is_none()).and_then(|c| moment.poses.get(c)).map(|p| p[0]);
    let names = shown.map(|hips| (hips + 1.1 * Vec3::Y, String::from("A"), colour::MARK));
    rings.extend(shown.map(|hips| (hips.with_y(0.0), 0.7, colour::MARK)));
    let words = if config.streams { ["", "to the right", "to the left"] } else { ["at its target", "on its way", ""] };
    let named = words.iter().enumerate().filter(|(_, word)| !word.is_empty());
    let count = |k: usize| all.clone().filter(|c| state(*c) == k).count();
    let tints = [colour::REACHED, colour::ON_THE_WAY, colour::RIGHT];
    let entries: Vec<_> = named.map(|(k, word)| (tints[k], format!("{word}: {}", count(k)))).collect();
    let ring = if config.streams { String::new() } else { format!("ring: target, within {:.2} m   ", config.reach_m) };
    let figures: Vec<WorldFigure> = all.clone().map(body).collect();
    world_sheet(&WorldSheet {
        figures: &figures,
        trails: &trails,
        rings: &rings,
        names: names.as_slice(),
        legend: (&entries, &(ring + "line: where the root went")),
        ..*view
    })
}

/// Draws poses side by side, from their right and from the front, with bars below planted heels and toes.
fn strips(title: &str, frames: &[TrialFrame]) -> [Picture; 2] {
    let moments: Vec<WorldMoment> = spread(frames).map(|i| moment_ahead(frames, i)).collect();
    let views = [
        (FRAC_PI_2, "from its right; bars: heels and toes on the ground; left is orange"),
        (PI, "from the front; bars: heels and toes on the ground; left is orange"),
    ];
    views.map(|(towards, subtitle)| {
        world_strip(&WorldStrip {
            title,
            subtitle,
            moments: &moments,
            columns: COLUMNS,
            width_m: POSE_M,
            view_angles: (towards, 0.1),
            ..WorldStrip::default()
        })
    })
}

/// Numbers of evenly spaced frames, the first and the last among them.
fn spread(frames: &[TrialFrame]) -> impl Iterator<Item = usize> + use<> {
    let last = frames.len().saturating_sub(1);
    (0..COLUMNS).map(move |k| k * last / (COLUMNS - 1))
}

/// A frame with its root at the origin, and the heading of the motion around it along +Z.
fn moment_ahead(frames: &[TrialFrame], i: usize) -> WorldMoment {
    let frame = &frames[i];
    let near = frames.iter().filter(|f| (f.time_s - frame.time_s).abs() <= 0.25);
    let heading = near.map(|f| Vec2::from_angle(f.root.heading)).sum::<Vec2>().to_angle();
    let (turn, root) = (Quat::from_rotation_y(-heading), frame.root.translation());
    let joints = frame.positions.map(|p| turn * (p - root));
    let planted = FEET.iter().filter(|(part, ..)| frame.contacts.any(*part));
    let bar = |&(_, joint, tint): &(Contacts, Joint, Colour)| {
        let centre = joints[joint.index()].with_y(-0.04);
        (UnitSolid::Box { centre, rotation: Quat::IDENTITY, half: Vec3::new(0.04, 0.012, 0.04) }, tint)
    };
    let label = format!("{:.2} s, {:.1} m/s", frame.time_s, speed_mps(frames, i));
    let one = WorldMoment::of_one(frame.time_s, BodyFigure::from_positions(&joints));
    WorldMoment { solids: planted.map(bar).collect(), label: Some(label), ..one }
}

/// Speed of the root over a fifth of a second around a frame (m/s).
fn speed_mps(frames: &[TrialFrame], i: usize) -> f32 {
    let near = |f: &&TrialFrame| (f.time_s - frames[i].time_s).abs() <= 0.1 + 1e-4;
    let first = frames[..=i].iter().find(near).unwrap_or(&frames[i]);
    let last = frames[i..].iter().rfind(near).unwrap_or(&frames[i]);
    first.root.translation().distance(last.root.translation()) / (last.time_s - first.time_s).max(1e-6)
}

/// Draws a lane for each foot, with bars while its heel (above) and toe (below) are on the ground.
fn gait_diagram(frames: &[TrialFrame]) -> Picture {
    let (edge, top, lane) = (16.0, 84.0, 28.0);
    let mut page = Picture::new(1600, (top + 2.0 * lane + 3.0 * edge) as u32, colour::PAPER);
    header(
        &mut page,
        1.0,
        "Steps",
        "heels above, toes below, while they are on the ground, from the first pose to the last",
    );
    let at = |frame: usize| edge + 34.0 + 1530.0 * frame as f32 / frames.len() as f32;
    for (i, (part, _, tint)) in FEET.into_iter().enumerate() {
        let y = top + (i / 2) as f32 * (lane + 6.0);
        if i % 2 == 0 {
            page.fill_rect(Area::new(edge, y, 1568.0, lane), 4.0, colour::GROUND);
            let style = TextStyle { size: 19.0, colour: tint.mix(colour::INK, 0.2), align: Align::Left, bold: true };
            draw_text(&mut page, Vec2::new(edge + 8.0, y + 20.0), ["L", "R"][i / 2], style);
        }
        for run in runs_where(0..frames.len(), |f| frames[f].contacts.any(part)) {
            let bar = Area::new(at(run.start), y + 4.0 + 11.0 * (i % 2) as f32, at(run.end) - at(run.start), 9.0);
            page.fill_rect(bar, 3.0, tint);
        }
    }
    page
}

/// Draws poses at their places along the path, seen from beside it, older ones paler.
fn path_sheet(frames: &[TrialFrame]) -> Picture {
    let root = |i: usize| frames[i].root.translation();
    let way = root(frames.len() - 1) - root(0);
    let heading = if way.length() > 0.5 { way.x.atan2(way.z) } else { frames[0].root.heading };
    let figure = |(k, i): (usize, usize)| WorldFigure {
        figure: BodyFigure::from_positions(&frames[i].positions),
        colours: BodyColours::default().faded(colour::GROUND, 0.62 * (1.0 - (k + 1) as f32 / COLUMNS as f32)),
    };
    let name = |i: usize| (root(i) + 1.95 * Vec3::Y, format!("{:.2} s", frames[i].time_s), colour::INK_SOFT);
    world_sheet(&WorldSheet {
        title: "Character A on its way",
        subtitle: "poses where they were, older ones paler",
        size: (1600, 620),
        figures: &spread(frames).enumerate().map(figure).collect::<Vec<_>>(),
        trails: &[((0..frames.len()).map(root).collect(), colour::MARK)],
        names: &spread(frames).step_by(3).map(name).collect::<Vec<_>>(),
        camera: WorldCamera { heading: heading + FRAC_PI_2, elevation: 0.3, focus: None },
        ..WorldSheet::default()
    })
}

/// The last frames of `duration_s`; all of a shorter motion.
fn last_stretch(frames: &[TrialFrame], duration_s: f32) -> &[TrialFrame] {
    let from = frames.last().map_or(0.0, |last| last.time_s - duration_s);
    &frames[frames.partition_point(|f| f.time_s < from)..]
}

/// The frames of `duration_s` in which the root travels farthest; all frames of a shorter motion.
fn longest_stretch(frames: &[TrialFrame], duration_s: f32) -> &[TrialFrame] {
    let mut gone = vec![0.0f32];
    for pair in frames.windows(2) {
        gone.push(gone[gone.len() - 1] + (pair[1].root.translation() - pair[0].root.translation()).length());
    }
    let num = frames.iter().take_while(|f| f.time_s - frames[0].time_s <= duration_s).count();
    let last_start = frames.len() - num;
    let way = |s: usize| gone[s + num.max(1) - 1] - gone[s];
    // The first of equally long ones, as figures that are not numbers compare equal.
    let best = (0..=last_start).rev().max_by(|&a, &b| way(a).total_cmp(&way(b))).unwrap_or(0);
    frames.get(best..best + num).unwrap_or(frames)
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::{NUM_JOINTS, Planar};

    /// A character that goes ahead along +Z and turns there, one frame a tenth of a second.
    fn frames(num: usize) -> Vec<TrialFrame> {
        let frame = |i: usize| {
            let root = Planar::new(0.0, 0.1 * i as f32, 0.02 * i as f32);
            let positions = [Vec3::Y + root.translation(); NUM_JOINTS];
            let contacts = if i % 10 < 5 { Contacts::LEFT_HEEL } else { Contacts::RIGHT_TOE };
            TrialFrame { time_s: 0.1 * i as f32, root, positions, contacts }
        };
        (0..num).map(frame).collect()
    }

    #[test]
    fn poses_of_a_strip_go_ahead_and_show_what_is_planted() {
        let frames = frames(40);
        let moment = moment_ahead(&frames, 20);
        assert!(moment.figures[0].figure.joint(Joint::Hips).distance(Vec3::Y) < 1e-5);
        assert_eq!(moment.solids.len(), 1);
        assert_eq!(moment.label.as_deref(), Some("2.00 s, 1.0 m/s"));
        assert_eq!(spread(&frames).collect::<Vec<_>>()[11], 39);
    }

    #[test]
    fn the_stretch_is_where_the_root_goes_farthest() {
        let mut x = 0.0;
        let mut all = frames(300);
        for (i, frame) in all.iter_mut().enumerate() {
            x += if (100..160).contains(&i) { 0.05 } else { 0.001 };
            (frame.time_s, frame.root) = (i as f32 / 30.0, Planar::new(x, 0.0, 0.0));
        }
        let found = longest_stretch(&all, 2.0);
        let first = (found[0].time_s * 30.0).round() as usize;
        assert_eq!(found.len(), 61);
        assert!((99..=100).contains(&first), "{first}");
        assert_eq!(longest_stretch(&all[..10], 2.0).len(), 10);
        assert!(longest_stretch(&[], 2.0).is_empty());
    }

    #[test]
    fn short_and_broken_motion_is_drawn_without_a_panic() {
        for mut frames in [frames(1), frames(2), frames(9)] {
            frames[0].positions = [Vec3::NAN; NUM_JOINTS];
            frames[0].root = Planar::new(f32::NAN, 0.0, f32::NAN);
            assert!(strips("t", &frames).iter().all(|p| p.height() > 100));
            assert!(gait_diagram(&frames).height() > 100 && path_sheet(&frames).height() > 100);
        }
        assert!(longest_stretch(&[], 1.0).is_empty() && last_stretch(&[], 1.0).is_empty());
    }
}
