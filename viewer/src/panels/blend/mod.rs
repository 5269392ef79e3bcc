//! Blend spaces: examples in their parameter box, the weight of one over it, a point that is dragged, and the contacts
//! of the examples and their blend over generic time (Kim, Kim and Shin 2003a, section 4).

mod map;
mod plane;
mod rows;
mod surface;

use super::paint::{PanelWidget, choose, empty, no_bundle};
use crate::command::{Commands, ViewStage, ViewerCommand};
use crate::run::{BlendCompanions, BlendMoment, Blending, LEGS, SIZES};
use crate::{bundle::OpenBundle, document::OpenDocument, model::Model};
use eframe::egui::{Color32, Grid, Slider, Ui, WidgetInfo};
use plane::{MapAxes, unit};
use surface::WeightSurface;
use throng_core::blend::{BlendSpace, ExampleRecord};
use throng_core::format::BlendMeta;

/// View settings of the panel, and cached results.
#[derive(Clone, Debug, Default)]
pub struct BlendPanelState {
    /// Axes of the map, and the document and space that they are of.
    shown: Option<((u64, usize), MapAxes)>,
    /// Example whose weights are shown; without a choice, the strongest one.
    example: Option<usize>,
    surface: Option<WeightSurface>,
    /// Examples that weigh nothing are listed, too.
    all: bool,
    /// Example under the pointer in the frame before.
    hovered: Option<usize>,
    /// The point is moved by the arrow keys.
    focus: bool,
}

impl BlendPanelState {
    /// True where the arrow keys move the point.
    pub fn has_focus(&self) -> bool {
        self.focus
    }

    /// Shows the weights of an example; of the strongest one where they are shown already.
    fn toggle_example(&mut self, example: usize) {
        self.example = Some(example).filter(|e| self.example != Some(*e));
    }
}

/// Input shared by all parts of the panel.
struct BlendPanelInput<'a> {
    space: &'a BlendSpace,
    meta: &'a BlendMeta,
    blending: Blending,
    /// The moment shown: weights of the examples, the point, and generic time.
    moment: &'a BlendMoment,
    /// Selected example.
    example: usize,
    /// Generation of the document.
    document: u64,
}

const NO_SPACES: &str = "A blend space makes bodies from example motions at any speed and turning rate. Build from a \
     config with `[blend.NAME]`; data/locomotion.toml is one.";

/// Shows the panel.
pub fn show(ui: &mut Ui, model: &Model, state: &mut BlendPanelState, commands: &mut Commands) {
    state.focus = false;
    if let (OpenDocument::Scene(_), Some(bundle)) = (&model.document, model.document.bundle()) {
        let bundle = bundle.path.display();
        return empty(ui, "This is a scene", &format!("Open its bundle to see its blend spaces: {bundle}"));
    }
    let Some((bundle, run)) = model.document.blend() else {
        match model.document.bundle() {
            None if model.document.raw_motion().is_none() => return no_bundle(ui, &model.document),
            _ => return empty(ui, "There is no blend space", NO_SPACES),
        }
    };
    let (blending, moment) = (*run.blending(), run.reel.moment());
    let Ok(space) = bundle.blend(blending.space) else { return };
    let key = (model.generation, blending.space);
    let shown = state.shown.filter(|s| s.0 == key).map(|s| s.1);
    if shown.is_none() {
        *state = BlendPanelState { all: state.all, ..BlendPanelState::default() };
    }
    let mut shown = shown.unwrap_or_else(|| MapAxes::default_for(space.axes())).checked(space.axes());
    let strongest = rows::order(&moment.weights, false).first().copied().unwrap_or(0);
    let input = BlendPanelInput {
        space,
        meta: bundle.blend_meta(blending.space),
        blending,
        moment,
        example: state.example.unwrap_or(strongest).min(space.examples().len() - 1),
        document: model.generation,
    };
    let mut wanted = blending;
    choices(ui, bundle, &mut wanted, &mut shown, &input);
    state.shown = Some((key, shown));
    map::show(ui, &input, state, &mut wanted);
    ui.add_space(4.0);
    sliders(ui, &input, &mut wanted);
    ui.separator();
    body(ui, &mut wanted);
    ui.separator();
    rows::show(ui, &input, state);
    if wanted != blending {
        commands.push(ViewerCommand::Blend(wanted));
    } else if !model.shows_blend() {
        ui.add_space(4.0);
        ui.button("Show it walking").request(commands, ViewerCommand::Stage(ViewStage::Blend));
    }
}

/// The space, and the axes of the map.
fn choices(ui: &mut Ui, bundle: &OpenBundle, wanted: &mut Blending, shown: &mut MapAxes, input: &BlendPanelInput<'_>) {
    ui.horizontal_wrapped(|ui| {
        let (spaces, mut number) = (&bundle.blends, input.blending.space);
        let names = (0..spaces.len()).map(|n| (n, bundle.blend_meta(n).name.clone()));
        choose(ui, "Space", Some(80.0), &mut number, names);
        if number != input.blending.space {
            let fresh = Blending::straight_walk(number, &spaces[number]);
            *wanted = carried_over(input, wanted, fresh, &bundle.blend_meta(number).axes);
        }
        if input.space.axes().len() > 2 {
            let (across, up) = (shown.across, shown.up.unwrap_or(0));
            if let Some(axis) = axis_choice(ui, "Across", input, across) {
                *shown = shown.with_across(axis);
            }
            ui.label("×");
            if let Some(axis) = axis_choice(ui, "Upwards", input, up) {
                *shown = shown.with_up(axis);
            }
        }
        let n = input.space.examples().len();
        let error = input.space.record().max_weight_error;
        let knots: u32 = input.space.axes().iter().map(|a| a.num_knots).product();
        ui.weak(format!("{n} examples")).on_hover_text(format!(
            "Weights are tabulated at {knots} knots, with an error of at most {error:.4}; postures at {} phases",
            input.space.num_phases()
        ));
    });
}

/// The point in another space, as far as axes of the same names exist.
///
/// - `fresh`: a walk in that space, whose axes have the names `axes`.
fn carried_over(input: &BlendPanelInput<'_>, from: &Blending, fresh: Blending, axes: &[String]) -> Blending {
    let mut to = Blending { space: fresh.space, point: fresh.point, ..*from };
    for (axis, name) in axes.iter().enumerate() {
        if let Some(same) = input.meta.axes.iter().position(|a| a == name) {
            to.point[axis] = from.point[same];
        }
    }
    to
}

fn axis_choice(ui: &mut Ui, name: &str, input: &BlendPanelInput<'_>, now: usize) -> Option<usize> {
    let mut chosen = now;
    choose(ui, name, Some(64.0), &mut chosen, input.meta.axes.iter().cloned().enumerate());
    (chosen != now).then_some(chosen)
}

/// One for every axis.
fn sliders(ui: &mut Ui, input: &BlendPanelInput<'_>, wanted: &mut Blending) {
    Grid::new("axes").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
        for (axis, record) in input.space.axes().iter().enumerate() {
            let range = [record.low, record.high];
            slider(ui, &input.meta.axes[axis], "", &mut wanted.point[axis], range, unit(record.kind));
        }
    });
}

/// Shows size, legs, retargeting and the companion.
fn body(ui: &mut Ui, wanted: &mut Blending) {
    Grid::new("body").num_columns(2).spacing([8.0, 3.0]).show(ui, |ui| {
        slider(ui, "size", "Size of the walking body; the examples have 1", &mut wanted.size, SIZES, "");
        slider(ui, "legs", "Length of its legs, relative to its size", &mut wanted.legs, LEGS, "");
    });
    ui.horizontal_wrapped(|ui| {
        let tip =
            "Planted feet stay, legs and touching arms reach; without it, joint angles are taken as they are blended";
        ui.checkbox(&mut wanted.retarget, "retarget").on_hover_text(tip);
        if (wanted.size, wanted.legs) != (1.0, 1.0) && ui.small_button("size of the examples").clicked() {
            (wanted.size, wanted.legs) = (1.0, 1.0);
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.label("beside");
        let other = if wanted.retarget { "not retargeted" } else { "retargeted" };
        for (beside, name, tip) in [
            (BlendCompanions::None, "nobody", "It walks alone"),
            (BlendCompanions::Retargeting, other, "The same body with the other setting"),
            (BlendCompanions::Sizes, "sizes", "The smallest and the largest body, on the same path"),
        ] {
            ui.selectable_value(&mut wanted.companions, beside, name).on_hover_text(tip);
        }
    });
}

/// A row with a name, a hint about it that may be empty, and a slider that is found by its name.
fn slider(ui: &mut Ui, name: &str, hint: &str, value: &mut f32, [low, high]: [f32; 2], unit: &str) {
    /// Room for the number (points).
    const NUMBER: f32 = 96.0;
    let label = ui.label(name);
    if !hint.is_empty() {
        label.on_hover_text(hint);
    }
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER).max(80.0);
    // A limit of decimals would round a point that was dragged on the map.
    let slider = Slider::new(value, low..=high).suffix(unit).custom_formatter(|v, _| format!("{v:.2}"));
    let response = ui.add(slider);
    response.widget_info(|| WidgetInfo::slider(true, f64::from(*value), name));
    ui.end_row();
}

/// An example in words, over several lines.
fn describe_example(ui: &mut Ui, input: &BlendPanelInput<'_>, example: usize) {
    let Some(e) = input.space.examples().get(example) else { return };
    ui.strong(input.meta.examples.get(example).map_or("", String::as_str));
    let [left, ahead] = e.velocity;
    ui.label(format!("{ahead:.2} m/s ahead, {left:.2} m/s to the left"));
    ui.label(match e.gyration {
        g if g.abs() < 0.02 => "straight".to_owned(),
        g => format!("turns {} at {:.2} rad/s", if g > 0.0 { "left" } else { "right" }, g.abs()),
    });
    let kind = if e.flags & ExampleRecord::IS_STILL != 0 { "of standing" } else { "of two steps" };
    let mirrored = if e.flags & ExampleRecord::IS_MIRRORED != 0 { ", mirrored" } else { "" };
    ui.label(format!("{:.2} s {kind}, {} frames from {}{mirrored}", e.duration_s, e.num_frames, e.first_frame));
    let values = input.meta.axes.iter().zip(e.parameters).zip(input.space.axes());
    let values = values.map(|((name, v), axis)| format!("{name} {v:.2}{}", unit(axis.kind)));
    ui.weak(values.collect::<Vec<_>>().join(", "));
    ui.label(format!("weight {:.3}", input.moment.weights.get(example).copied().unwrap_or(0.0)));
}

/// Colour of an example's weight, for dots and bars.
fn weight_colour(weight: f32, dark: bool) -> Color32 {
    surface::colour(if weight < 0.0 { surface::RANGE[0] } else { 1.0 }, dark)
}

#[cfg(test)]
mod tests;
