//! Time: play, pause, step, speed, and the last minute to be scrubbed through.

use super::glitches::{self, GlitchMark};
use super::paint::PanelWidget;
use crate::command::{Commands, ViewerCommand};
use crate::{model::Model, run::STEP_HZ, theme::ThemePalette};
use eframe::egui::{self, Button, Label, Rangef, Rect, Response, RichText, Role, Slider, Ui, remap, vec2};

/// Input of the bar: from the run or from the clip.
struct TransportTime {
    playing: bool,
    speed: f32,
    now: u32,
    first: u32,
    last: u32,
    rate_hz: f32,
    live: bool,
}

fn time_of(model: &Model) -> Option<TransportTime> {
    if model.shows_clip() {
        let (num_frames, rate_hz) = model.shown_clip()?;
        let p = &model.player;
        let (now, last) = (p.frame as u32, num_frames.saturating_sub(1));
        return Some(TransportTime { playing: p.playing, speed: p.speed, now, first: 0, last, rate_hz, live: false });
    }
    let head = model.head()?;
    let (first, last) = head.recorded().into_inner();
    let (playing, speed, now, live) = (head.is_playing(), head.speed(), head.shown_step(), head.is_live());
    Some(TransportTime { playing, speed, now, first, last, rate_hz: STEP_HZ, live })
}

/// Shows the bar.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let Some(t) = time_of(model) else { return drop(ui.weak("Open a file to play it.")) };
    let marks = if model.shows_clip() { glitches::shown_glitches(model) } else { Vec::new() };
    scrubber(ui, &t, &marks, commands);
    ui.horizontal_wrapped(|ui| {
        buttons(ui, &t, model.shows_clip(), commands);
        ui.separator();
        speed(ui, &t, commands);
        ui.separator();
        let seconds = |frame: u32| frame as f32 / t.rate_hz;
        let what = if model.shows_clip() { "frame" } else { "step" };
        let text = format!("{:>6.2} s  {what} {:<5}", seconds(t.now), t.now);
        // Each control moves to the next row as a whole if there is no room.
        ui.add(Label::new(RichText::new(text).monospace()).extend());
        let note = match (model.shows_clip(), t.live) {
            (true, _) => format!("of {:.2} s", seconds(t.last)),
            (_, true) => format!("live · {:.0} s recorded", seconds(t.last - t.first)),
            _ => format!("{:.1} s ago", seconds(t.last - t.now)),
        };
        ui.add(Label::new(RichText::new(note).weak()).extend());
    });
}

/// The time line over the whole width.
///
/// - `marks`: glitches of the clip, below the line.
fn scrubber(ui: &mut Ui, t: &TransportTime, marks: &[GlitchMark], commands: &mut Commands) {
    ui.spacing_mut().slider_width = ui.available_width().max(60.0);
    let mut now = t.now;
    let slider = Slider::new(&mut now, t.first..=t.last.max(t.first + 1)).show_value(false).trailing_fill(true);
    let scrubber = ui.add(slider);
    let hint = pointed(ui, &scrubber, t, marks);
    let scrubber = scrubber.on_hover_text(hint);
    scrubber.widget_info(|| egui::WidgetInfo::slider(true, f64::from(now), "Time"));
    if scrubber.drag_started() || scrubber.clicked() {
        commands.push(ViewerCommand::Play(false));
    }
    if now != t.now {
        commands.push(ViewerCommand::Seek(now));
    }
}

/// Paints the marks below the line; returns a tooltip about the mark under the pointer, or about the line.
fn pointed(ui: &Ui, scrubber: &Response, t: &TransportTime, marks: &[GlitchMark]) -> String {
    // The handle of the slider stays within these ends.
    let (rect, palette) = (scrubber.rect, ThemePalette::for_visuals(ui.visuals()));
    let line = rect.x_range().shrink(rect.height() / 2.5);
    let x = |frame: u32| remap(frame as f32, t.first as f32..=t.last as f32, line.min..=line.max);
    let mut pointed_at = Vec::new();
    for mark in marks {
        let (from, to) = (x(mark.frames.start), x(mark.frames.end.min(t.last)));
        let at = Rangef::new(from, to.max(from + 3.0));
        let place = Rect::from_x_y_ranges(at, rect.bottom() - 4.0..=rect.bottom());
        ui.painter().rect_filled(place, 1.0, glitches::colour(&palette, mark.treated));
        if scrubber.hover_pos().is_some_and(|p| at.expand(2.0).contains(p.x)) {
            pointed_at.push(mark.words.as_str());
        }
    }
    match pointed_at.is_empty() {
        true => "Drag to move through the recording, which holds the last minute".into(),
        false => pointed_at.join("\n"),
    }
}

fn buttons(ui: &mut Ui, t: &TransportTime, is_clip: bool, commands: &mut Commands) {
    let mut button = |text: &str, name: &str, tip: &str, command: ViewerCommand| {
        let button = ui.add(Button::new(text).min_size(vec2(26.0, 22.0))).on_hover_text(tip);
        button.named(Role::Button, name).request(commands, command);
    };
    button("⏮", "First", "Start of the recording (Home)", ViewerCommand::Seek(t.first));
    button("⏪", "Step back", "One step back (Left; Shift+Left a second)", ViewerCommand::Step(-1));
    match t.playing {
        true => button("⏸", "Pause", "Pause (Space)", ViewerCommand::Play(false)),
        false => button("▶", "Play", "Play (Space)", ViewerCommand::Play(true)),
    }
    button("⏩", "Step", "One step forward (Right; Shift+Right a second)", ViewerCommand::Step(1));
    button("⏭", "Last", "End of the recording (End)", ViewerCommand::Seek(t.last));
    if !is_clip {
        button("⟲", "Restart", "Restart with the same seed (R)", ViewerCommand::Restart);
    }
}

fn speed(ui: &mut Ui, t: &TransportTime, commands: &mut Commands) {
    let name = |s: f32| format!("{s} ×");
    let combo = egui::ComboBox::from_id_salt("speed").width(64.0).selected_text(name(t.speed)).show_ui(ui, |ui| {
        for s in [0.1, 0.25, 0.5, 1.0, 2.0, 4.0] {
            ui.selectable_label(t.speed == s, name(s)).request(commands, ViewerCommand::Speed(s));
        }
    });
    combo.response.named(Role::ComboBox, "Speed");
}
