//! Plots that cannot be moved.

use egui_plot::{HoverPosition, Plot};

/// A plot that shows all of its values from 0 on, and tells what is under the pointer.
///
/// - `tip`: text of a point: the name of its line, and its two values.
pub fn fixed_plot(id: &str, height: f32, tip: impl Fn(&str, f64, f64) -> String + 'static) -> Plot<'static> {
    Plot::new(id.to_owned())
        .height(height)
        .include_y(0.0)
        .allow_scroll(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_boxed_zoom(false)
        .label_formatter(move |hit| match hit {
            HoverPosition::NearDataPoint { plot_name, position, .. } => Some(tip(plot_name, position.x, position.y)),
            HoverPosition::Elsewhere { .. } => None,
        })
}
