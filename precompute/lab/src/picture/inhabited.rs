//! The picture of a world: all characters at the end, and moments of partners, or of a lively character.

use super::{
    BodyColours, BodyFigure, Picture, WorldCamera, WorldFigure, WorldMoment, WorldSheet, WorldStrip, WorldUnit, sheet,
    world_sheet, world_strip, world_units,
};
use super::{discs::group_colour, world::OBLIQUE_VIEW};
use crate::run::{JointPositions, PeopleSample, SceneFigures, WorldRecord};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;
use throng_bake::environment::PlacedGeometry;
use throng_core::Joint;
use throng_simulation::scene::PictureConfig;

/// Number of moments side by side, and of rows.
const COLUMNS: usize = 10;
const ROWS: usize = 2;
/// Number of samples between moments.
const SAMPLE_STRIDE: usize = 5;
/// Width that a moment shows (m).
const WIDTH_M: f32 = 2.6;
/// Greatest number of pairs, each in a row.
const PAIRS: usize = 5;
/// Number of samples shown before a pair begins to act.
const SAMPLES_BEFORE: usize = 10;

/// Draws a world: all its characters at the end, and moments of partners that acted together, or of a followed character.
///
/// - `groups`: names and poses of the groups in the world, at the end; each of several groups has its own colour.
pub(super) fn inhabited_sheet(
    title: &str,
    figures: &SceneFigures,
    picture: &PictureConfig,
    record: &WorldRecord,
    groups: &[(String, Vec<JointPositions>)],
    geometry: &PlacedGeometry,
) -> Picture {
    let units = world_units(geometry);
    let tint = |g: usize| if groups.len() > 1 { BodyColours::plain(group_colour(g)) } else { BodyColours::default() };
    let of_group = |(g, (_, poses)): (usize, &(String, Vec<JointPositions>))| -> Vec<WorldFigure> {
        let one = |p: &JointPositions| WorldFigure { figure: BodyFigure::from_positions(p), colours: tint(g) };
        poses.iter().map(one).collect()
    };
    let bodies: Vec<WorldFigure> = groups.iter().enumerate().flat_map(of_group).collect();
    let f = figures.world.clone().unwrap_or_default();
    let subtitle = format!(
        "{:.0} s: {} overlap(s) of people, {} penetration(s), {} stuck; {:.1} goals fulfilled and {:.0} m travelled a \
         minute and character; planted feet slip {:.0} mm/s (95th percentile)",
        figures.simulated_s,
        figures.character_overlaps.unwrap_or(0),
        f.environment_penetrations,
        figures.stuck.unwrap_or(0),
        f.fulfilled_per_minute,
        f.travelled_m_per_minute,
        1000.0 * figures.foot_slip_p95_mps.unwrap_or_default()
    );
    let focus = picture.width_m.map(|width| (Vec3::from_array(picture.focus.unwrap_or_default()), width));
    let (size, subtitle, camera) = ((1600, 1100), &subtitle, WorldCamera { focus, ..OBLIQUE_VIEW });
    let (figures, units) = (&bodies[..], &units[..]);
    let several = groups.iter().enumerate().filter(|_| groups.len() > 1);
    let entries: Vec<_> = several.map(|(g, (name, _))| (group_colour(g), name.clone())).collect();
    let legend = (&entries[..], "");
    let overview = WorldSheet { title, subtitle, size, figures, units, camera, legend, ..WorldSheet::default() };
    let mut strips = vec![world_sheet(&overview)];
    strips.extend(partner_pairs(record).into_iter().map(|pair| pair_strip(record, &pair, units)));
    if strips.len() == 1 {
        strips.extend(liveliest_character(record).map(|(who, from)| lively_strip(record, who, from, units)));
    }
    sheet(&strips.iter().collect::<Vec<_>>())
}

/// Draws moments of one character.
fn lively_strip(record: &WorldRecord, who: usize, from: usize, units: &[WorldUnit<'_>]) -> Picture {
    let samples = record.samples[from..].iter().step_by(SAMPLE_STRIDE).take(COLUMNS * ROWS);
    let one = |s: &PeopleSample| WorldMoment::of_one(s.time_s, BodyFigure::from_positions(&s.poses[who]));
    world_strip(&WorldStrip {
        title: &format!("Character {}", record.followed[who]),
        subtitle: "one moment every half a second; what stands before the person is left out",
        moments: &samples.map(one).collect::<Vec<_>>(),
        units,
        columns: COLUMNS,
        width_m: WIDTH_M,
        view_angles: (OBLIQUE_VIEW.heading, 0.25),
        ..WorldStrip::default()
    })
}

/// Two characters that act together.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PartnerPair {
    /// Number of the first among the followed characters.
    who: usize,
    /// Number of the partner in the simulation.
    with: usize,
    /// Sample at which they began.
    from: usize,
}

/// All pairs that acted together, in order of time, each once.
fn partner_pairs(record: &WorldRecord) -> Vec<PartnerPair> {
    let mut out: Vec<PartnerPair> = Vec::new();
    for (from, sample) in record.samples.iter().enumerate() {
        for (who, with) in sample.partners.iter().enumerate().filter_map(|(who, p)| Some((who, p.as_ref()?.0))) {
            let numbers = [record.followed[who], with];
            let is_known = out.iter().any(|p| [record.followed[p.who], p.with].iter().all(|n| numbers.contains(n)));
            if !is_known {
                out.push(PartnerPair { who, with, from });
            }
        }
    }
    out.truncate(PAIRS);
    out
}

/// Draws moments of two characters, from a little before they act together, seen from beside both.
fn pair_strip(record: &WorldRecord, pair: &PartnerPair, units: &[WorldUnit<'_>]) -> Picture {
    let other = |sample: &PeopleSample| {
        let of_pair = sample.partners[pair.who].as_ref().filter(|p| p.0 == pair.with).map(|p| p.1);
        of_pair.or_else(|| sample.poses.get(record.followed.iter().position(|n| *n == pair.with)?).copied())
    };
    let moment = |sample: &PeopleSample| {
        let one = BodyFigure::from_positions(&sample.poses[pair.who]);
        WorldMoment::of_pair(sample.time_s, one, other(sample).map(|pose| BodyFigure::from_positions(&pose)))
    };
    let began = &record.samples[pair.from];
    let offset = other(began).map_or(Vec3::Z, |p| p[0] - began.poses[pair.who][0]);
    let first = pair.from.saturating_sub(SAMPLES_BEFORE);
    let samples = record.samples[first..].iter().step_by(SAMPLE_STRIDE).take(COLUMNS);
    world_strip(&WorldStrip {
        title: &format!("Characters {} and {}", record.followed[pair.who], pair.with),
        subtitle: &format!(
            "from {:.1} s on they act together; one moment every half a second; what stands before them is left out",
            began.time_s
        ),
        moments: &samples.map(moment).collect::<Vec<_>>(),
        units,
        columns: COLUMNS,
        width_m: WIDTH_M,
        view_angles: (offset.x.atan2(offset.z) + FRAC_PI_2, 0.15),
        ..WorldStrip::default()
    })
}

/// Recorded character and first sample with the greatest vertical movement of the hips.
fn liveliest_character(record: &WorldRecord) -> Option<(usize, usize)> {
    let span = SAMPLE_STRIDE * COLUMNS * ROWS;
    let starts: Vec<usize> = (0..record.samples.len().saturating_sub(span).max(1)).step_by(SAMPLE_STRIDE).collect();
    let range = |who: usize, from: usize| {
        let samples = record.samples[from..].iter().take(span);
        let heights = samples.map(|sample| sample.poses[who][Joint::Hips.index()].y);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        high - low
    };
    let all = (0..record.followed.len()).flat_map(|w| starts.iter().map(move |&s| (w, s)));
    let all = all.filter(|_| !record.samples.is_empty());
    all.max_by(|a, b| range(a.0, a.1).total_cmp(&range(b.0, b.1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Skeleton;

    /// Two characters 1 m apart act together from the third sample on; a third is not followed and joins the second later.
    fn record() -> WorldRecord {
        let at = |x: f32| Skeleton::default().rest_positions().map(|p| p + Vec3::X * x);
        let sample = |i: usize| PeopleSample {
            time_s: 0.1 * i as f32,
            poses: vec![at(0.0), at(1.0)],
            partners: match i {
                0..3 => vec![None, None],
                3..20 => vec![Some((8, at(1.0))), Some((7, at(0.0)))],
                _ => vec![None, Some((9, at(2.0)))],
            },
        };
        WorldRecord { character_group: 0, group: 0, followed: vec![7, 8], samples: (0..40).map(sample).collect() }
    }

    #[test]
    fn each_pair_is_shown_once_from_when_it_began() {
        let found = partner_pairs(&record());
        assert_eq!(found, [PartnerPair { who: 0, with: 8, from: 3 }, PartnerPair { who: 1, with: 9, from: 20 }]);
        assert!(partner_pairs(&WorldRecord::default()).is_empty());
    }

    #[test]
    fn both_partners_are_in_the_frame() {
        let record = record();
        let strip = pair_strip(&record, &partner_pairs(&record)[0], &[]);
        // The other one is green.
        let green = |x: std::ops::Range<u32>| {
            let at = x.flat_map(|x| (90..280).map(move |y| (x, y)));
            at.filter_map(|(x, y)| strip.pixel(x, y)).filter(|c| c[1].saturating_sub(c[0].max(c[2])) > 25).count()
        };
        let cell = 156;
        let (left, right) = (green(16..16 + cell / 2), green(16 + cell / 2..16 + cell));
        assert!(
            left.max(right) > 100 && 20 * left.min(right) < left.max(right),
            "{left} {right}: the other one is beside it"
        );
    }
}
