//! The picture of blend spaces: figures at the corners and in the middle of the parameter box, at three phases each.

use super::{BodyFigure, Picture, WorldMoment, WorldStrip, sheet, world_strip};
use std::{cmp::Reverse, f32::consts::PI};
use throng_bake::examples::judge::{BLEND_WORDS, BlendQuality, judge, parameters_at, postures_over_cycle};
use throng_core::blend::{BlendSpace, MAX_AXES, axis, channel};
use throng_core::{Bundle, Joint};
use throng_motion::clip::joint_transforms;

/// Phases of a cycle that are shown, evenly.
const PHASES: usize = 3;
/// Most axes whose corners are shown; others are in the middle of their range.
const CORNER_AXES: usize = 2;
/// Width that a figure is shown in (m).
const WIDTH_M: f32 = 1.5;

/// Draws every blend space of a bundle, with its quality.
///
/// # Errors
/// As [`BlendSpace::new`]; the spaces of an open bundle are sound.
pub fn blend_sheet(tables: &Bundle) -> throng_core::Result<Picture> {
    Ok(sheet(&blend_strips(tables, usize::MAX)?.iter().collect::<Vec<_>>()))
}

/// Draws blend spaces of a bundle, those of the lowest quality first.
///
/// - `most`: number of spaces that are drawn at most.
///
/// # Errors
/// As [`blend_sheet`].
pub(super) fn blend_strips(tables: &Bundle, most: usize) -> throng_core::Result<Vec<Picture>> {
    let spaces = tables.meta().blends.iter().map(|b| tables.blend(&b.name)).collect::<throng_core::Result<Vec<_>>>()?;
    let mut judged: Vec<_> = spaces.iter().map(|space| (space, judge(space))).collect();
    judged.sort_by_key(|(_, quality)| Reverse(BLEND_WORDS.iter().position(|word| *word == quality.word)));
    Ok(judged.iter().take(most).map(|(space, quality)| draw_space(space, quality)).collect())
}

fn draw_space(space: &BlendSpace, quality: &BlendQuality) -> Picture {
    let num_axes = space.axes().len();
    let corners = (0..1usize << num_axes.min(CORNER_AXES)).map(|c| {
        let mut at = [0.5; MAX_AXES];
        (0..num_axes.min(CORNER_AXES)).for_each(|k| at[k] = (c >> k & 1) as f32);
        at
    });
    let places: Vec<[f32; MAX_AXES]> = corners.chain([[0.5; MAX_AXES]]).collect();
    let moments: Vec<WorldMoment> = places.iter().flat_map(|at| moments(space, at)).collect();
    let reason = if quality.reason.is_empty() { String::new() } else { format!(": {}", quality.reason) };
    let title = format!("Blend space {}: {}{reason}", space.name(), quality.word);
    let subtitle = format!(
        "corners and middle of its parameters, three phases each; soles slip {:.0} mm/s before feet are locked; blends are within \
         {:.0} deg a joint of an example",
        1000.0 * quality.slip_p95_mps,
        quality.unlike_deg
    );
    world_strip(&WorldStrip {
        title: &title,
        subtitle: &subtitle,
        columns: moments.len(),
        moments: &moments,
        width_m: WIDTH_M,
        view_angles: (0.75 * PI, 0.1),
        ..WorldStrip::default()
    })
}

/// One place of the unit box, at three phases.
fn moments(space: &BlendSpace, at: &[f32; MAX_AXES]) -> Vec<WorldMoment> {
    let parameters = parameters_at(space, at);
    let mut weights = vec![0.0; space.stride()];
    _ = space.weights(&[parameters], &mut weights);
    let words = space.axes().iter().zip(parameters).map(|(a, v)| match a.kind {
        axis::GYRATION => format!("{v:.1} rad/s"),
        axis::STYLE => format!("{v:.1}"),
        _ => format!("{v:.1} m/s"),
    });
    let mut words: Vec<String> = words.take(CORNER_AXES).collect();
    words.resize(PHASES, String::new());
    let postures = postures_over_cycle(space, &weights, PHASES);
    let figure = |p: &throng_core::blend::BlendedPosture| {
        let all = joint_transforms(space.skeleton(), p.vector(channel::HIPS), |j| p.rotation(Joint::ALL[j]));
        BodyFigure::from_transforms(space.skeleton(), &all)
    };
    let one = |(p, label)| WorldMoment { label: Some(label), ..WorldMoment::of_one(0.0, figure(p)) };
    postures.iter().zip(words).map(one).collect()
}
