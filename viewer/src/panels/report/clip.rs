//! The report on a motion file.

use super::{facts, section};
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::{PanelWidget, time_text};
use crate::theme::ThemePalette;
use crate::{document::RawMotion, panels::build::marked, panels::glitches, panels::words::counted};
use eframe::egui::{Color32, Frame, Grid, Label, RichText, Sense, Stroke, TextStyle, Ui, vec2};
use throng_base::thresholds::{FOOT_PLANTED_MPS, FOOT_SLIDES_MPS};
use throng_core::Joint;
use throng_precompute::{annotate::ContactSanity, inspect::ClipReport, stance::Grade};

/// Shows all that import found.
pub fn show(ui: &mut Ui, raw: &RawMotion, commands: &mut Commands) {
    let report = &raw.report;
    warnings(ui, report);
    motion(ui, report);
    contacts(ui, report);
    excluded(ui, report, commands);
    recorded(ui, raw, commands);
    section(ui, "What was found and why");
    report.findings.iter().for_each(|finding| bullet(ui, finding));
    roles(ui, report);
}

fn warnings(ui: &mut Ui, report: &ClipReport) {
    if report.warnings.is_empty() {
        return;
    }
    let colour = ThemePalette::for_visuals(ui.visuals()).warning;
    let frame = Frame::group(ui.style()).stroke(Stroke::new(1.5, colour)).fill(colour.gamma_multiply(0.08));
    frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.label(RichText::new(counted(report.warnings.len(), "warning")).strong().color(colour));
        report.warnings.iter().for_each(|warning| bullet(ui, warning));
    });
}

fn bullet(ui: &mut Ui, text: &str) {
    marked(ui, RichText::new("•").weak(), RichText::new(text));
}

fn motion(ui: &mut Ui, r: &ClipReport) {
    section(ui, "Motion and body");
    let rest = match r.rest_pose {
        "t_pose" => "T-pose",
        "a_pose" => "A-pose",
        "other" => "neither a T-pose nor an A-pose",
        other => other,
    };
    let all = [
        ("File", r.file.clone()),
        ("Format", format!("{}, {} joints", r.format.replace('_', "/").to_uppercase(), r.joints)),
        ("Motion", format!("{} frames at {} Hz, {}", r.frames, rounded(r.rate_hz, 4), time_text(r.duration_s))),
        ("Unit", format!("{} m", rounded(r.metres_per_unit, 6))),
        ("Up axis", r.up.to_string()),
        ("Rest pose", format!("{rest}, faces {:.0}°", r.facing_deg)),
        ("Height", format!("{:.2} m", r.height_m)),
        ("Profile", r.profile.clone()),
    ];
    facts(ui, "motion", all);
}

/// A number rounded to some digits after the point, which is shown without superfluous ones.
fn rounded(number: f64, digits: i32) -> f64 {
    let unit = 10f64.powi(digits);
    (number * unit).round() / unit
}

fn contacts(ui: &mut Ui, r: &ClipReport) {
    section(ui, "Feet");
    let palette = ThemePalette::for_visuals(ui.visuals());
    for (mood, text) in verdict(&r.contact) {
        let colour = if mood == Mood::Good { palette.good } else { palette.warning };
        ui.horizontal_top(|ui| {
            dot(ui, colour);
            ui.add(Label::new(text).selectable(true).wrap());
        });
    }
    let c = &r.contact;
    let share = |v: f32| format!("{:.0} % of the frames that are used", 100.0 * v);
    let speed = format!("{:.3} m/s on average, {:.3} m/s at the 95th percentile", c.mean_speed_mps, c.p95_speed_mps);
    let shares = [("Left foot planted", share(c.left_share)), ("Right foot planted", share(c.right_share))];
    facts(ui, "contacts", shares.into_iter().chain([("Speed while planted", speed)]));
}

/// Ranges that a build would leave out; a click goes there.
fn excluded(ui: &mut Ui, r: &ClipReport, commands: &mut Commands) {
    section(ui, "Left out by a build");
    if r.excluded.is_empty() {
        ui.weak("Nothing: every frame is used.");
    }
    for (reason, start, end) in &r.excluded {
        let seconds = end.saturating_sub(*start) as f64 / r.rate_hz;
        let text = format!("{reason}: frames {start} to {end}, {}", time_text(seconds));
        ui.link(text).on_hover_text("Go there").request(commands, ViewerCommand::Seek(*start as u32));
    }
}

/// Glitches of the recording; a click goes there.
fn recorded(ui: &mut Ui, raw: &RawMotion, commands: &mut Commands) {
    let marks = glitches::raw_glitches(raw);
    if marks.is_empty() {
        return;
    }
    section(ui, "Glitches of the recording");
    let palette = ThemePalette::for_visuals(ui.visuals());
    for mark in marks {
        ui.horizontal_top(|ui| {
            dot(ui, glitches::colour(&palette, mark.treated));
            let link = ui.link(&mark.words).on_hover_text("Go there");
            link.request(commands, ViewerCommand::Seek(mark.frames.start));
        });
    }
}

/// A dot at the start of a line.
fn dot(ui: &mut Ui, colour: Color32) {
    let (dot, _) = ui.allocate_exact_size(vec2(10.0, ui.text_style_height(&TextStyle::Body)), Sense::hover());
    ui.painter().circle_filled(dot.center(), 4.0, colour);
}

fn roles(ui: &mut Ui, r: &ClipReport) {
    section(ui, "Roles of the joints");
    let missing = Joint::ALL.iter().filter(|j| !r.roles.contains_key(j.name())).count();
    if missing > 0 {
        ui.weak(format!("Roles without a joint of their own: {missing} of {}.", Joint::ALL.len()));
    }
    let warning = ThemePalette::for_visuals(ui.visuals()).warning;
    Grid::new("roles").num_columns(2).striped(true).spacing([16.0, 3.0]).show(ui, |ui| {
        for role in Joint::ALL {
            ui.label(role.name().replace('_', " "));
            match r.roles.get(role.name()) {
                Some(joint) => ui.add(Label::new(RichText::new(joint).monospace()).selectable(true)),
                None => ui.label(RichText::new("missing").color(warning)),
            };
            ui.end_row();
        }
    });
}

/// Difference of the contact shares of the two feet above which a limp, a turn, or a wrong floor is likely.
const UNEVEN: f32 = 0.25;

/// Whether something is as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    /// All is well.
    Good,
    /// Something may be wrong.
    Odd,
}

/// Judges how the feet behave: how often they stand, how alike they are, whether they slide.
pub fn verdict(c: &ContactSanity) -> Vec<(Mood, String)> {
    let mut out = vec![stance(c)];
    if (c.left_share - c.right_share).abs() > UNEVEN {
        let more = if c.left_share > c.right_share { "left" } else { "right" };
        let text = format!("The {more} foot stands much more often than the other: a limp, or one side is wrong.");
        out.push((Mood::Odd, text));
    }
    if c.left_share.max(c.right_share) > 0.0 {
        out.push(sliding(c));
    }
    if c.stance.grade != Grade::Good {
        out.push((Mood::Odd, format!("Feet stand {}. Is the floor level?", c.stance)));
    }
    out
}

/// Walking has about 0.6 of each foot, running about 0.35.
fn stance(c: &ContactSanity) -> (Mood, String) {
    let mean = 0.5 * (c.left_share + c.right_share);
    let (mood, text) = match mean {
        m if m <= 0.0 => (Mood::Odd, "The feet never stand: wrong unit, wrong up axis, or no ground under the motion."),
        m if m < 0.2 => (Mood::Odd, "The feet stand rarely: a fast run or jumps, or the ground lies too low."),
        m if m < 0.45 => (Mood::Good, "The feet stand about as often as in running."),
        m if m < 0.8 => (Mood::Good, "The feet stand about as often as in walking."),
        _ => (Mood::Good, "The feet stand nearly all the time, as in standing or gestures on the spot."),
    };
    (mood, text.to_owned())
}

fn sliding(c: &ContactSanity) -> (Mood, String) {
    if c.p95_speed_mps > FOOT_SLIDES_MPS {
        (Mood::Odd, "Planted feet slide at times: expect foot skate, or set the contact thresholds lower.".to_owned())
    } else if c.mean_speed_mps > FOOT_PLANTED_MPS {
        (Mood::Odd, "Planted feet move a little: foot lock will have some work to do.".to_owned())
    } else {
        (Mood::Good, "Planted feet stay where they are.".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::{rounded, *};

    #[test]
    fn numbers_have_no_needless_digits() {
        assert_eq!(rounded(30.000_003, 4).to_string(), "30");
        assert_eq!(rounded(119.88, 4).to_string(), "119.88");
    }

    fn moods(left_share: f32, right_share: f32, mean_speed_mps: f32, p95_speed_mps: f32) -> Vec<Mood> {
        let c = ContactSanity { left_share, right_share, mean_speed_mps, p95_speed_mps, ..Default::default() };
        verdict(&c).into_iter().map(|v| v.0).collect()
    }

    #[test]
    fn plausible_contacts_pass_and_implausible_ones_are_flagged() {
        use Mood::{Good, Odd};
        assert_eq!(moods(0.6, 0.58, 0.05, 0.2), [Good, Good]);
        assert_eq!(moods(0.35, 0.36, 0.1, 0.3), [Good, Good]);
        assert_eq!(moods(0.0, 0.0, 0.0, 0.0), [Odd]);
        assert_eq!(moods(0.9, 0.4, 0.05, 0.2), [Good, Odd, Good]);
        assert_eq!(moods(0.6, 0.6, 0.3, 0.9), [Good, Odd]);
        assert_eq!(moods(0.1, 0.05, 0.2, 0.3), [Odd, Odd]);
    }
}
