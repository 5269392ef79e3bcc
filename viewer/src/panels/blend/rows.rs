//! The examples of the blend: weights as bars, and when their feet stand over generic time.

use super::{BlendPanelInput, BlendPanelState, describe_example, weight_colour};
use crate::{panels::paint::PanelWidget, theme::ThemePalette};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rangef, Rect, Role, Sense, Stroke, StrokeKind, Ui, Visuals, pos2, vec2,
};
use std::ops::Range;
use throng_core::Error;
use throng_core::blend::{BlendSpace, BlendedPosture, ExampleRecord, channel};
use throng_precompute::clip;

/// Height of a row, and of the one of the blend (points).
const ROW: f32 = 19.0;
const BLEND_ROW: f32 = 27.0;
/// Widths of name, bar with its number, and duration as shares of the panel; the rest is generic time.
const NAME: f32 = 0.31;
const BAR: f32 = 0.25;
const SECONDS: f32 = 0.12;
/// Width of the number beside a bar (points).
const NUMBER: f32 = 30.0;

/// Positions of the columns of a row: name, bar, generic time, duration.
fn columns(rect: Rect) -> [Rangef; 4] {
    let at = |share: f32| rect.left() + share * rect.width();
    let (bar, time, seconds) = (at(NAME), at(NAME + BAR), at(1.0 - SECONDS));
    let name = Rangef::new(at(0.0) + 4.0, bar - 4.0);
    [name, Rangef::new(bar, time - 6.0), Rangef::new(time, seconds - 4.0), Rangef::new(seconds, at(1.0) - 2.0)]
}

/// Shows the blend and the examples, the largest weights first; a click on an example shows its weights on the map.
pub fn show(ui: &mut Ui, input: &BlendPanelInput<'_>, state: &mut BlendPanelState) {
    ui.horizontal_wrapped(|ui| {
        ui.strong("Keytimes").on_hover_text("Planted feet, over generic time");
        let palette = ThemePalette::for_visuals(ui.visuals());
        ui.colored_label(palette.left, "left foot");
        ui.colored_label(palette.right, "right foot");
        ui.checkbox(&mut state.all, "all").on_hover_text("Also examples of weight 0");
    });
    let rows = order(&input.moment.weights, state.all);
    let short = short_names(&input.meta.examples);
    blend_row(ui, input);
    let mut hovered = None;
    for e in rows {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::click());
        let response = response.named(Role::Button, input.meta.examples.get(e).map_or("", String::as_str));
        if ui.is_rect_visible(rect) {
            example_row(ui, input, e, &short[e], rect, response.hovered());
        }
        if response.clicked() {
            state.toggle_example(e);
        }
        if response.hovered() {
            hovered = Some(e);
        }
        response.on_hover_ui(|ui| describe_example(ui, input, e));
    }
    // The map highlights it in the next frame.
    state.hovered = state.hovered.or(hovered);
}

/// Names without the words that all of them have.
fn short_names(names: &[String]) -> Vec<String> {
    let all: Vec<Vec<&str>> = names.iter().map(|n| n.split('_').collect()).collect();
    let is_shared = |word: &str| all.len() > 1 && all.iter().all(|n| n.contains(&word));
    let short = |(words, name): (&Vec<&str>, &String)| {
        let own: Vec<&str> = words.iter().copied().filter(|w| !is_shared(w)).collect();
        if own.is_empty() { name.clone() } else { own.join(" ") }
    };
    all.iter().zip(names).map(short).collect()
}

/// Row of the blend: its contacts, and the duration of its cycle.
fn blend_row(ui: &mut Ui, input: &BlendPanelInput<'_>) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), BLEND_ROW), Sense::hover());
    let response = response.named(Role::Label, "Blend");
    let mut weights = input.moment.weights.to_vec();
    weights.resize(input.space.stride(), 0.0);
    let Ok(steps) = CycleContacts::from_blend(input.space, &weights) else { return };
    let (visuals, [name, bar, ..], painter) = (ui.visuals(), columns(rect), ui.painter());
    let font = FontId::proportional(13.0);
    let ink = visuals.strong_text_color();
    painter.text(pos2(name.min, rect.center().y), Align2::LEFT_CENTER, "blend", font.clone(), ink);
    let head = ThemePalette::for_visuals(visuals).head;
    paint_number(painter, pos2(bar.max, rect.center().y), format!("{:.2}", input.moment.phase), head);
    chart(painter, visuals, rect, &steps, input.moment.phase, ink);
    response.on_hover_text("Generic time, and when the feet of the blend stand; its cycle lasts as the examples' do");
}

fn example_row(ui: &Ui, input: &BlendPanelInput<'_>, e: usize, name: &str, rect: Rect, is_hovered: bool) {
    let (visuals, [names, bars, ..]) = (ui.visuals(), columns(rect));
    let painter = ui.painter_at(rect);
    if input.example == e || is_hovered {
        let fill = if input.example == e { visuals.selection.bg_fill } else { visuals.widgets.hovered.bg_fill };
        painter.rect_filled(rect, 2.0, fill.gamma_multiply(0.35));
    }
    let within = Rect::from_x_y_ranges(names, rect.y_range());
    let (at, font) = (within.left_center(), FontId::proportional(12.0));
    ui.painter_at(within).text(at, Align2::LEFT_CENTER, name, font, visuals.text_color());
    let weight = input.moment.weights.get(e).copied().unwrap_or(0.0);
    bar(&painter, visuals, Rect::from_x_y_ranges(bars, rect.y_range()), weight);
    let Some(example) = input.space.examples().get(e) else { return };
    let steps = CycleContacts::from_example(example);
    chart(&painter, visuals, rect, &steps, input.moment.phase, visuals.weak_text_color());
}

/// A weight: to the right from a line, negative ones to the left; the number beside it.
fn bar(painter: &Painter, visuals: &Visuals, all: Rect, weight: f32) {
    const BEFORE: f32 = 0.2 / 1.2;
    let rect = all.with_max_x(all.right() - NUMBER);
    let zero = rect.left() + BEFORE * rect.width();
    let end = (zero + weight.clamp(-0.2, 1.0) * (rect.right() - zero)).clamp(rect.left(), rect.right());
    let filled = Rect::from_x_y_ranges(zero.min(end)..=zero.max(end), rect.shrink2(vec2(0.0, 4.0)).y_range());
    painter.rect_filled(filled, 1.0, weight_colour(weight, visuals.dark_mode));
    painter.vline(zero, rect.shrink2(vec2(0.0, 2.0)).y_range(), Stroke::new(1.0, visuals.weak_text_color()));
    paint_number(painter, pos2(all.right(), rect.center().y), format!("{weight:.2}"), visuals.text_color());
}

fn paint_number(painter: &Painter, right: Pos2, text: String, colour: Color32) {
    painter.text(right, Align2::RIGHT_CENTER, text, FontId::proportional(11.0), colour);
}

/// When the left foot stands above, the right one below it, the generic time that is shown, and the time of the cycle.
fn chart(painter: &Painter, visuals: &Visuals, row: Rect, steps: &CycleContacts, phase: f32, ink: Color32) {
    let (palette, [.., time, seconds]) = (ThemePalette::for_visuals(visuals), columns(row));
    paint_number(painter, pos2(seconds.max, row.center().y), format!("{:.2} s", steps.seconds), ink);
    let rect = Rect::from_x_y_ranges(time, row.y_range()).shrink2(vec2(0.0, 2.0));
    painter.rect_stroke(rect, 0.0, visuals.widgets.noninteractive.bg_stroke, StrokeKind::Inside);
    let x = |t: f32| rect.left() + t * rect.width();
    let half = 0.5 * rect.height();
    for (side, (stands, colour)) in steps.feet.iter().zip([palette.left, palette.right]).enumerate() {
        let top = rect.top() + side as f32 * half;
        for stand in stands {
            let lane = Rect::from_x_y_ranges(x(stand.start)..=x(stand.end), top + 1.5..=top + half - 1.0);
            painter.rect_filled(lane, 1.0, colour);
        }
    }
    painter.vline(x(phase), rect.y_range(), Stroke::new(1.5, palette.head));
}

/// Moments at which a blend is sampled.
const MOMENTS: usize = 96;

/// Contact intervals of a foot, as parts of a cycle; intervals across the end of the cycle are cut there.
pub type StanceIntervals = Vec<Range<f32>>;

/// The steps of a cycle of generic time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CycleContacts {
    /// When the left foot stands, and the right one.
    pub feet: [StanceIntervals; 2],
    /// Time of the cycle (s).
    pub seconds: f32,
}

impl CycleContacts {
    /// Contacts of an example, from its keytimes.
    pub fn from_example(e: &ExampleRecord) -> Self {
        let whole = || vec![0.0..1.0];
        let [left_off, right_strike, right_off] = e.keytimes;
        let feet = match e.flags & ExampleRecord::IS_STILL != 0 {
            true => [whole(), whole()],
            false => [cut(0.0, left_off), cut(right_strike, right_off)],
        };
        Self { feet, seconds: e.duration_s }
    }

    /// Contacts of a blend as shown: where more than half of it has a foot on the ground.
    ///
    /// - `weights`: a row of the space's weights.
    ///
    /// # Errors
    /// [`Error`] where the weights are not a row of the space.
    pub fn from_blend(space: &BlendSpace, weights: &[f32]) -> Result<Self, Error> {
        let phases: Vec<f32> = (0..MOMENTS).map(|i| (i as f32 + 0.5) / MOMENTS as f32).collect();
        let rows = weights.repeat(MOMENTS);
        let mut postures = vec![BlendedPosture::default(); MOMENTS];
        space.blend_postures(&rows, &phases, &mut postures)?;
        let feet = [channel::LEFT_CONTACT, channel::RIGHT_CONTACT].map(|c| {
            let down: Vec<bool> = postures.iter().map(|p| p.channel(c) > 0.5).collect();
            runs(&down)
        });
        let seconds = postures.iter().map(|p| p.channel(channel::RATE)).sum::<f32>() / MOMENTS as f32;
        Ok(Self { feet, seconds })
    }
}

/// From a strike to a lift, cut where the cycle ends.
fn cut(strike: f32, off: f32) -> StanceIntervals {
    match off > strike {
        true => vec![strike..off],
        false => [strike..1.0, 0.0..off].into_iter().filter(|r| r.end > r.start).collect(),
    }
}

/// Intervals of samples that are true, as parts of the whole.
fn runs(down: &[bool]) -> StanceIntervals {
    let part = |i: usize| i as f32 / down.len() as f32;
    clip::runs_where(0..down.len(), |i| down[i]).into_iter().map(|r| part(r.start)..part(r.end)).collect()
}

/// The examples of a blend in the order of how much they matter.
///
/// - `all`: also includes negligible examples; otherwise only the others, and at least one.
pub fn order(weights: &[f32], all: bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by(|&a, &b| weights[b].abs().total_cmp(&weights[a].abs()));
    let shown = order.iter().take_while(|&&e| weights[e].abs() >= LEAST).count().max(1);
    if !all {
        order.truncate(shown);
    }
    order
}

/// Smaller weights are not seen.
const LEAST: f32 = 0.005;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bundle::OpenBundle;
    use crate::fixtures::paces::Paces;

    #[test]
    fn names_are_shown_without_the_words_that_all_have() {
        let short = |names: &[&str]| short_names(&names.iter().map(|&n| n.to_owned()).collect::<Vec<_>>());
        assert_eq!(short(&["walk_proud_v070", "idle_proud", "walk_proud_v110"]), ["walk v070", "idle", "walk v110"]);
        assert_eq!(short(&["a_b"]), ["a b"]);
        assert_eq!(short(&["a_b", "b_a"]), ["a_b", "b_a"]);
    }

    #[test]
    fn a_contact_across_the_end_of_the_cycle_shows_at_both_ends() {
        assert_eq!(cut(0.5, 0.9), vec![0.5..0.9]);
        assert_eq!(cut(0.5, 0.1), vec![0.5..1.0, 0.0..0.1]);
        assert_eq!(cut(0.5, 0.0), vec![0.5..1.0]);
        assert_eq!(runs(&[true, false, true, true]), vec![0.0..0.25, 0.5..1.0]);
        assert_eq!(runs(&[false; 3]), StanceIntervals::new());
    }

    #[test]
    fn the_blend_at_an_example_steps_as_the_example_does() {
        let paces = Paces::new();
        let bundle = OpenBundle::open(&paces.bundle()).unwrap();
        let space = &bundle.blends[0];
        for e in [0, 6, 13] {
            let mut weights = vec![0.0; space.stride()];
            weights[e] = 1.0;
            let (blend, own) = (
                CycleContacts::from_blend(space, &weights).unwrap(),
                CycleContacts::from_example(&space.examples()[e]),
            );
            assert!((blend.seconds / own.seconds - 1.0).abs() < 0.03, "{} {}", blend.seconds, own.seconds);
            for (a, b) in blend.feet.iter().zip(&own.feet) {
                let length = |s: &StanceIntervals| s.iter().map(|r| r.end - r.start).sum::<f32>();
                assert!((length(a) - length(b)).abs() < 0.08, "{a:?} {b:?}");
            }
        }
        assert!(CycleContacts::from_blend(space, &[1.0]).is_err());
    }

    #[test]
    fn the_largest_weights_come_first_of_either_sign() {
        assert_eq!(order(&[0.3, -0.4, 0.001, 0.9], false), [3, 1, 0]);
        assert_eq!(order(&[0.3, -0.4, 0.001, 0.9], true), [3, 1, 0, 2]);
        assert_eq!(order(&[0.0, 0.0], false).len(), 1);
    }
}
