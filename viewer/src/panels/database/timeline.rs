//! The timeline of a clip: a ruler, poses, and lanes for all data of its frames.

use super::lanes::{self, TimelineLanes};
use super::strip::{PoseSource, TimelineStrip};
use super::track::{FEET, StateMark, TimelineTrack};
use crate::panels::paint::{FrameAxis, FrameSpan, PanelWidget, RULER_HEIGHT, ruler};
use crate::theme::ThemePalette;
use eframe::egui::{CursorIcon, PointerButton, Pos2, Rect, Response, Role, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Width of the labels left of the lanes (points).
const GUTTER: f32 = 88.0;
/// Zoom of a point of the scroll wheel, as an exponent.
const ZOOM_PER_POINT: f32 = 0.004;

/// Input of a timeline.
#[derive(Clone, Copy, Debug)]
pub struct TimelineInput<'a> {
    /// Number of the shown version.
    pub document: u64,
    /// Data of the clip.
    pub track: &'a TimelineTrack,
    /// Source of the poses.
    pub source: PoseSource<'a>,
    /// State at the play head, or the next one after it.
    pub next_state: Option<StateMark>,
    /// Segment of an action to highlight.
    pub highlighted: Option<u32>,
    /// Frame of the play head.
    pub head: u32,
}

impl TimelineInput<'_> {
    /// Number of the shown version, and of the clip.
    pub fn key(&self) -> (u64, usize) {
        (self.document, if let PoseSource::Bundle(_, clip) = self.source { clip } else { 0 })
    }
}

/// Visible part of a clip.
#[derive(Clone, Debug, Default)]
pub struct TimelineView {
    /// Document and clip that the part belongs to.
    shown: Option<(u64, usize)>,
    /// The part; none for all of the clip.
    pub span: Option<FrameSpan>,
    head: u32,
    strip: TimelineStrip,
}

impl TimelineView {
    /// The part that is seen: all of a clip that was not shown before, else with the play head in sight.
    fn span(&mut self, scene: &TimelineInput<'_>) -> FrameSpan {
        let n = scene.track.num_frames;
        if self.shown != Some(scene.key()) {
            (self.shown, self.span, self.head) = (Some(scene.key()), None, scene.head);
        }
        let mut span = self.span.unwrap_or(FrameSpan::whole(n));
        if self.head != scene.head {
            self.head = scene.head;
            span = span.followed(scene.head as f32, n);
        }
        span
    }
}

/// Shows a timeline, and chooses its height.
///
/// - returns the frame that the user went to.
pub fn show(ui: &mut Ui, scene: &TimelineInput<'_>, view: &mut TimelineView) -> Option<u32> {
    let rest = TimelineLanes::height(scene.track);
    let poses = (ui.available_height() - rest - RULER_HEIGHT).clamp(56.0, 150.0);
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), RULER_HEIGHT + poses + rest), Sense::hover());
    let plot = rect.with_min_x((rect.left() + GUTTER).min(rect.right() - 1.0));
    let response = ui.interact(plot, ui.scope_id().with("timeline"), Sense::click_and_drag());
    let response = response.named(Role::Slider, "Timeline");
    let (rate_hz, num_frames) = (scene.track.rate_hz, scene.track.num_frames);
    let mut axis = FrameAxis { span: view.span(scene), x: plot.x_range(), rate_hz, num_frames };
    axis.span = moved_span(ui, &response, &axis);
    view.span = Some(axis.span).filter(|s| !s.is_whole(num_frames));

    let ruler_rect = plot.with_max_y(plot.top() + RULER_HEIGHT);
    let poses_rect = Rect::from_x_y_ranges(plot.x_range(), ruler_rect.bottom()..=ruler_rect.bottom() + poses);
    ui.painter().rect_filled(plot, 2.0, ui.visuals().extreme_bg_color);
    ruler(ui, ruler_rect, &axis);
    view.strip.show(ui, poses_rect, &axis, scene);
    let lanes = TimelineLanes::below(poses_rect.bottom(), rect, plot, scene.track);
    lanes::paint(ui, &lanes, &axis, scene);
    paint_head(ui, plot, &axis, scene.head);
    hover(ui, &response, plot, &axis, scene);
    let goes_to = scrubbed_frame(&response, &axis).filter(|f| *f != scene.head);
    // The view follows the play head on its own accord, not while the user holds it.
    view.head = goes_to.unwrap_or(view.head);
    goes_to
}

/// The span after scrolling, zooming and panning. The consumed scroll input is removed.
fn moved_span(ui: &Ui, response: &Response, axis: &FrameAxis) -> FrameSpan {
    let (mut span, n) = (axis.span, axis.num_frames);
    if response.dragged_by(PointerButton::Middle) || response.dragged_by(PointerButton::Secondary) {
        span = span.panned(-response.drag_delta().x / axis.points_per_frame(), n);
    }
    let Some(pointer) = response.hover_pos() else { return span };
    let (scroll, zoom) = ui.input_mut(|i| (std::mem::take(&mut i.smooth_scroll_delta), i.zoom_delta()));
    let factor = zoom * (scroll.y * ZOOM_PER_POINT).exp();
    if factor != 1.0 {
        span = span.zoomed(axis.instant_at(pointer.x), factor, n);
    }
    if scroll.x != 0.0 {
        span = span.panned(-scroll.x / axis.points_per_frame(), n);
    }
    span
}

/// The frame that the user points at while the primary button is down, or was clicked.
fn scrubbed_frame(response: &Response, axis: &FrameAxis) -> Option<u32> {
    let scrubs = response.clicked() || response.dragged_by(PointerButton::Primary);
    let held = response.is_pointer_button_down_on() && response.ctx.input(|i| i.pointer.primary_down());
    let pointer = response.interact_pointer_pos().filter(|_| scrubs || held)?;
    Some(axis.frame_at(pointer.x))
}

fn paint_head(ui: &Ui, plot: Rect, axis: &FrameAxis, head: u32) {
    let colour = ThemePalette::for_visuals(ui.visuals()).head;
    let x = axis.x_of(head as f32);
    let painter = ui.painter().with_clip_rect(plot.expand2(vec2(5.0, 0.0)).intersect(ui.clip_rect()));
    if !plot.x_range().contains(x) {
        return;
    }
    painter.vline(x, plot.y_range(), Stroke::new(1.5, colour));
    let top: Pos2 = pos2(x, plot.top());
    let points = vec![top + vec2(-5.0, 0.0), top + vec2(5.0, 0.0), top + vec2(0.0, 8.0)];
    painter.add(Shape::convex_polygon(points, colour, Stroke::NONE));
}

fn hover(ui: &Ui, response: &Response, plot: Rect, axis: &FrameAxis, scene: &TimelineInput<'_>) {
    let Some(pointer) = response.hover_pos() else { return };
    let frame = axis.frame_at(pointer.x);
    let x = axis.x_of(frame as f32);
    ui.painter().with_clip_rect(plot).vline(x, plot.y_range(), Stroke::new(1.0, ui.visuals().weak_text_color()));
    response.clone().on_hover_cursor(CursorIcon::ResizeHorizontal).on_hover_ui_at_pointer(|ui| {
        let mut lines = describe(scene.track, frame).into_iter();
        lines.next().map(|line| ui.strong(line));
        lines.for_each(|line| _ = ui.label(line));
    });
}

/// Description of a frame, one line for each fact.
pub fn describe(track: &TimelineTrack, frame: u32) -> Vec<String> {
    let mut out = vec![format!("{:.3} s, frame {frame}", frame as f32 / track.rate_hz)];
    let contacts = track.contacts.get(frame as usize).copied().unwrap_or_default();
    let planted: Vec<&str> = FEET.iter().filter(|(part, _)| contacts.any(*part)).map(|f| f.1).collect();
    out.push(if planted.is_empty() { "no foot planted".into() } else { format!("planted: {}", planted.join(", ")) });
    let tags: Vec<&str> = track.tags.iter().filter(|t| t.frames.contains(&frame)).map(|t| t.name.as_str()).collect();
    if !tags.is_empty() {
        out.push(format!("tags: {}", tags.join(", ")));
    }
    out.extend(track.glitches.iter().filter(|g| g.frames.contains(&frame)).map(|g| g.words.clone()));
    let excluded = track.excluded.iter().filter(|e| e.frames.contains(&frame));
    out.extend(excluded.map(|e| format!("left out: {}", e.name)));
    if let Some(played) = &track.played {
        let kept = played.iter().any(|r| r.contains(&frame));
        out.push(if kept { "played by the motion graph".into() } else { "not played by the motion graph".into() });
    }
    let states = track.states.iter().filter(|s| s.frame == frame);
    out.extend(states.map(|s| format!("state {}{}", s.state, if s.standing { ", standing" } else { "" })));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::golden;

    #[test]
    fn a_frame_is_described_by_all_that_is_known_of_it() {
        let bundle = golden();
        let clip = (0..bundle.tables().clips().len())
            .find(|c| TimelineTrack::from_bundle(&bundle, *c).is_some_and(|t| !t.states.is_empty()))
            .unwrap();
        let mut track = TimelineTrack::from_bundle(&bundle, clip).unwrap();
        let state = track.states[0];
        track.tags = vec![super::super::track::NamedRun { name: "walk".into(), frames: 0..track.num_frames, lane: 0 }];
        let lines = describe(&track, state.frame);
        assert!(lines[0].ends_with(&format!("frame {}", state.frame)));
        assert!(lines.contains(&"tags: walk".to_owned()));
        assert!(lines.iter().any(|l| l.starts_with(&format!("state {}", state.state))));
        assert!(lines.iter().any(|l| l.contains("played by the motion graph")));
    }
}
