//! The lanes of a timeline: contacts, tags, excluded and played frames, states, actions.

use super::track::{NamedRun, StateMark, TimelineTrack};
use super::{strip::PoseSource, timeline::TimelineInput};
use crate::panels::paint::{FrameAxis, hatch};
use crate::{panels::glitches, theme::ThemePalette};
use eframe::egui::{
    Align2, Color32, FontId, Painter, Pos2, Rangef, Rect, Shape, Stroke, StrokeKind, Ui, Visuals,
    epaint::CubicBezierShape, pos2, vec2,
};
use std::ops::Range;

const FOOT: f32 = 8.0;
const TAG: f32 = 17.0;
const USE: f32 = 17.0;
const GLITCHES: f32 = 11.0;
/// A glitch of a frame or two is seen in a long clip, too (points).
const LEAST_GLITCH: f32 = 3.0;
const STATES: f32 = 15.0;
const ACTIONS: f32 = 30.0;
/// Space between lanes (points).
const GAP: f32 = 4.0;

/// Positions of the lanes.
#[derive(Clone, Debug)]
pub struct TimelineLanes {
    labels: Rangef,
    feet: [Rect; 4],
    tags: Vec<Rect>,
    /// Excluded and played frames.
    usage: Rect,
    /// Glitches of the recording; none for a clip without any.
    glitches: Option<Rect>,
    /// States, and below them the actions; none without a motion graph.
    states: Option<[Rect; 2]>,
}

impl TimelineLanes {
    /// Height of all lanes of a clip (points).
    pub fn height(track: &TimelineTrack) -> f32 {
        let glitches = if track.glitches.is_empty() { 0.0 } else { GAP + GLITCHES };
        let states = if track.played.is_some() { GAP + STATES + ACTIONS } else { GAP };
        GAP + 4.0 * (FOOT + 1.0) + GAP + TAG * track.tag_lanes() as f32 + GAP + USE + glitches + states
    }

    /// Lays them out below `top`; `rect` holds the labels too, `plot` only the frames.
    pub fn below(top: f32, rect: Rect, plot: Rect, track: &TimelineTrack) -> Self {
        let mut y = top + GAP;
        let mut lane = |height: f32, space: f32| {
            let rect = Rect::from_x_y_ranges(plot.x_range(), y..=y + height);
            y += height + space;
            rect
        };
        let feet = [lane(FOOT, 1.0), lane(FOOT, 1.0), lane(FOOT, 1.0), lane(FOOT, 1.0 + GAP)];
        let tags: Vec<Rect> = (0..track.tag_lanes()).map(|_| lane(TAG - 1.0, 1.0)).collect();
        lane(0.0, GAP);
        let usage = lane(USE, GAP);
        let glitches = (!track.glitches.is_empty()).then(|| lane(GLITCHES, GAP));
        let states = track.played.is_some().then(|| [lane(STATES, 0.0), lane(ACTIONS, 0.0)]);
        Self { labels: Rangef::new(rect.left(), plot.left()), feet, tags, usage, glitches, states }
    }
}

/// Input shared by all lanes.
struct LanePainter<'a> {
    painter: Painter,
    axis: &'a FrameAxis,
    scene: &'a TimelineInput<'a>,
    palette: ThemePalette,
    visuals: &'a Visuals,
}

/// Paints the lanes.
pub fn paint(ui: &Ui, lanes: &TimelineLanes, axis: &FrameAxis, scene: &TimelineInput<'_>) {
    let (visuals, palette) = (ui.visuals(), ThemePalette::for_visuals(ui.visuals()));
    let clip = Rect::from_x_y_ranges(axis.x, ui.clip_rect().y_range());
    let painter = ui.painter().with_clip_rect(clip.intersect(ui.clip_rect()));
    let lane = LanePainter { painter, axis, scene, palette, visuals };
    let (track, label) = (scene.track, |rect: Rect, text| label(ui, lanes.labels, rect, text));
    label(lanes.feet[0].union(lanes.feet[1]), "left heel, toe");
    label(lanes.feet[2].union(lanes.feet[3]), "right heel, toe");
    lane.feet(&lanes.feet);
    if let [first, ..] = lanes.tags.as_slice() {
        label(*first, "tags");
        track.tags.iter().for_each(|tag| lane.named_run(lanes.tags[tag.lane], tag));
    }
    label(lanes.usage, if track.played.is_some() { "played" } else { "left out" });
    lane.usage(lanes.usage);
    if let Some(rect) = lanes.glitches {
        label(rect, "glitches");
        lane.glitches(rect);
    }
    if let Some([states, actions]) = lanes.states {
        label(states, "states");
        label(actions, "actions");
        lane.state_marks(states);
        if let Some(from) = scene.next_state {
            lane.arcs(actions, from);
        }
    }
}

fn label(ui: &Ui, x: Rangef, lane: Rect, text: &str) {
    let at = pos2(x.max - 6.0, lane.center().y);
    ui.painter().text(at, Align2::RIGHT_CENTER, text, FontId::proportional(11.0), ui.visuals().weak_text_color());
}

impl LanePainter<'_> {
    fn run_rect(&self, lane: Rect, frames: &Range<u32>) -> Option<Rect> {
        let x = self.axis.place(frames)?;
        // A short run stays visible when a long clip is shown as a whole.
        Some(Rect::from_x_y_ranges(x.min..=x.max.max(x.min + 1.0), lane.y_range()))
    }

    /// Heels and toes; the two parts of a foot differ in strength.
    fn feet(&self, lanes: &[Rect; 4]) {
        for (i, (lane, runs)) in lanes.iter().zip(&self.scene.track.planted).enumerate() {
            self.painter.rect_filled(*lane, 0.0, self.visuals.faint_bg_color);
            let side = if i < 2 { self.palette.left } else { self.palette.right };
            let colour = if i % 2 == 0 { side } else { side.gamma_multiply(0.6) };
            for rect in runs.iter().filter_map(|r| self.run_rect(*lane, r)) {
                self.painter.rect_filled(rect, 1.0, colour);
            }
        }
    }

    fn named_run(&self, lane: Rect, run: &NamedRun) {
        let Some(rect) = self.run_rect(lane, &run.frames) else { return };
        self.painter.rect_filled(rect, 3.0, self.palette.of_name(&run.name));
        if rect.width() > 24.0 {
            let text = self.painter.with_clip_rect(rect.shrink(2.0).intersect(self.painter.clip_rect()));
            let (at, font) = (rect.left_center() + vec2(5.0, 0.0), FontId::proportional(11.5));
            text.text(at, Align2::LEFT_CENTER, &run.name, font, self.visuals.strong_text_color());
        }
    }

    /// Paints the frames that the motion graph plays, and the excluded ones over them, hatched, with the reason.
    fn usage(&self, lane: Rect) {
        let (painter, palette, visuals) = (&self.painter, &self.palette, self.visuals);
        painter.rect_filled(lane, 0.0, visuals.faint_bg_color);
        for rect in self.scene.track.played.iter().flatten().filter_map(|r| self.run_rect(lane, r)) {
            painter.rect_filled(rect, 0.0, palette.kept);
        }
        for run in &self.scene.track.excluded {
            let Some(rect) = self.run_rect(lane, &run.frames) else { continue };
            painter.rect_filled(rect, 0.0, visuals.extreme_bg_color);
            hatch(painter, rect, Stroke::new(1.0, palette.excluded.gamma_multiply(0.8)));
            painter.rect_stroke(rect, 0.0, Stroke::new(1.0, palette.excluded), StrokeKind::Inside);
            let (font, ink) = (FontId::proportional(11.0), visuals.strong_text_color());
            let text = painter.layout_no_wrap(run.name.clone(), font, ink);
            if rect.width() > text.size().x + 8.0 {
                let place = Align2::CENTER_CENTER.align_size_within_rect(text.size(), rect);
                painter.rect_filled(place.expand2(vec2(3.0, 0.0)), 2.0, visuals.extreme_bg_color);
                painter.galley(place.min, text, ink);
            }
        }
    }

    fn glitches(&self, lane: Rect) {
        self.painter.rect_filled(lane, 0.0, self.visuals.faint_bg_color);
        for mark in &self.scene.track.glitches {
            let Some(rect) = self.run_rect(lane, &mark.frames) else { continue };
            let wide = rect.with_max_x(rect.max.x.max(rect.min.x + LEAST_GLITCH));
            self.painter.rect_filled(wide, 1.0, glitches::colour(&self.palette, mark.treated));
        }
    }

    /// A tick for every state; standing ones have a dot, the one that is next is longer.
    fn state_marks(&self, lane: Rect) {
        let (seen, states) = (self.axis.seen(), &self.scene.track.states);
        let from = states.partition_point(|s| s.frame < seen.start);
        let mut last_x = f32::NEG_INFINITY;
        for mark in states[from..].iter().take_while(|s| s.frame < seen.end) {
            let x = self.axis.x_of(mark.frame as f32);
            let is_next = self.scene.next_state == Some(*mark);
            // More ticks than points cannot be distinguished.
            if x - last_x < 1.0 && !is_next && !mark.standing {
                continue;
            }
            last_x = x;
            let colour = if mark.standing { self.palette.standing } else { self.palette.state };
            let (top, width) = if is_next { (lane.top(), 2.5) } else { (lane.top() + 4.0, 1.0) };
            self.painter.vline(x, top..=lane.bottom() - 1.0, Stroke::new(width, colour));
            if mark.standing {
                self.painter.circle_filled(pos2(x, lane.top() + 4.0), 2.5, colour);
            }
        }
    }

    /// Curves from the state to the start of each of its actions within the clip.
    fn arcs(&self, lane: Rect, state: StateMark) {
        let PoseSource::Bundle(bundle, clip) = self.scene.source else { return };
        let (painter, axis, graph) = (&self.painter, self.axis, bundle.tables().graph());
        let from = pos2(axis.x_of(state.frame as f32), lane.top());
        for &number in graph.segments_of(state.state) {
            let segment = &graph.segments[number as usize];
            if segment.clip as usize != clip {
                continue;
            }
            let is_strong = self.scene.highlighted == Some(number);
            let (width, strength) = if is_strong { (2.5, 1.0) } else { (1.2, 0.7) };
            let stroke = Stroke::new(width, self.palette.state.gamma_multiply(strength));
            let start = segment.start - bundle.tables().clips()[clip].first_frame;
            let end = axis.x_of((start + segment.num_frames) as f32);
            if start == state.frame {
                // The clip goes on: a straight arrow to the next state.
                painter.line_segment([from, pos2(end, lane.top())], stroke);
                arrow_head(painter, pos2(end, lane.top()), vec2(1.0, 0.0), stroke.color);
                continue;
            }
            let to = pos2(axis.x_of(start as f32), lane.top());
            let depth = (4.0 + 1.4 * (to.x - from.x).abs().sqrt()).min(lane.height() * 1.25);
            let points = [from, from + vec2(0.0, depth), to + vec2(0.0, depth), to];
            painter.add(CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke));
            arrow_head(painter, to, vec2(0.0, -1.0), stroke.color);
        }
    }
}

/// A small triangle that ends at `tip`, pointing along the unit vector `along`.
fn arrow_head(painter: &Painter, tip: Pos2, along: eframe::egui::Vec2, colour: Color32) {
    let (back, side) = (tip - along * 6.0, along.rot90() * 3.0);
    painter.add(Shape::convex_polygon(vec![tip, back + side, back - side], colour, Stroke::NONE));
}
