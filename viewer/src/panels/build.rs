//! A build: its progress, its results and failures, how it ended, and the trial of what was built.

use super::paint::PanelWidget;
use crate::command::{Commands, ViewerCommand};
use crate::document::{BuildEnd, BuildLog, FinishedBuild, ShownBuild};
use crate::model::{Model, name_of};
use crate::theme::ThemePalette;
use eframe::egui::{
    Align, Align2, Area, Frame, Id, Label, Layout, Margin, ProgressBar, Rect, RichText, ScrollArea, Ui, vec2,
};
use throng_precompute::{run::News, verdict::Verdict};

/// Width over the 3-D view (points).
const WIDTH: f32 = 430.0;
/// Height of the lines that are seen at once (points).
const LINES: f32 = 150.0;
/// Size of the letters of lines (points).
const SMALL: f32 = 12.0;
/// Lines that are shown at most; a folder may hold thousands of files.
const MAX_LINES: usize = 200;

/// Descriptions of the stages of a build.
const STAGES: [(&str, &str); 15] = [
    ("hash", "looking at the files"),
    ("import", "reading motion"),
    ("retarget", "fitting it to one skeleton"),
    ("resample", "bringing it to one rate"),
    ("annotate", "finding contacts and blows"),
    ("embed", "finding what clips stand on"),
    ("features", "measuring poses"),
    ("examples", "blend spaces"),
    ("cluster", "pose groups"),
    ("patch", "motion patches"),
    ("graph", "motion graph"),
    ("policy", "policies"),
    ("write", "writing the bundle"),
    ("joints", "joining patches"),
    ("trial", "trying it out"),
];

/// True for a build with something to show: reading files alone has nothing.
pub fn is_shown(build: &ShownBuild) -> bool {
    !matches!(build, ShownBuild::UnderWay { building, .. } if !building.has_begun())
}

/// Shows the build under way, or the last one, in its own frame; shows nothing if there is none.
pub fn show(ui: &mut Ui, model: &Model, commands: &mut Commands) {
    let Some(build) = model.build.as_ref().filter(|b| is_shown(b)) else { return };
    let palette = ThemePalette::for_visuals(ui.visuals());
    let edge = match build {
        ShownBuild::UnderWay { .. } => palette.right,
        ShownBuild::Ended(built) => match built.end {
            BuildEnd::Done => palette.good,
            BuildEnd::Stopped(_) => palette.warning,
            BuildEnd::Failed(_) => ui.visuals().error_fg_color,
        },
    };
    let frame = Frame::group(ui.style()).fill(ui.visuals().extreme_bg_color).stroke((1.0, edge));
    frame.inner_margin(Margin::same(12)).corner_radius(8).show(ui, |ui| {
        ui.set_width(ui.available_width());
        match build {
            ShownBuild::UnderWay { paths, building } => running(ui, &name_of(paths), &building.log().clone(), commands),
            ShownBuild::Ended(built) => ended(ui, built, commands),
        }
    });
}

/// Shows the build as [`show`] does, in the lower left corner of a part of the window.
pub fn show_over(ui: &Ui, within: Rect, model: &Model, commands: &mut Commands) {
    let at = within.left_bottom() + vec2(10.0, -10.0);
    let area = Area::new(Id::unique("build")).fixed_pos(at).pivot(Align2::LEFT_BOTTOM).constrain_to(within);
    area.show(ui.ctx(), |ui| {
        ui.set_max_width((within.width() - 20.0).clamp(160.0, WIDTH));
        show(ui, model, commands);
    });
}

fn running(ui: &mut Ui, name: &str, log: &BuildLog, commands: &mut Commands) {
    heading(ui, &format!("Building {name}"), |ui| {
        let tip = "Stop it; what is finished is kept, and opening it again goes on there";
        ui.button("Cancel").on_hover_text(tip).request(commands, ViewerCommand::Stop);
    });
    let (status, stage) = (&log.status, log.status.stage());
    let what = STAGES.iter().find(|s| s.0 == stage).map_or(stage, |s| s.1);
    ui.horizontal_wrapped(|ui| {
        ui.label(what);
        ui.label(RichText::new(status.progress_text().unwrap_or_default()).weak());
    });
    let bar = ProgressBar::new(status.share().unwrap_or(0.0) as f32).desired_height(8.0).corner_radius(4);
    ui.add(bar.animate(status.share().is_none()));
    if !status.stages_kept().is_empty() {
        let kept = format!("done and kept: {}", status.stages_kept().join(", "));
        ui.add(Label::new(RichText::new(kept).weak().size(SMALL)).wrap());
    }
    lines(ui, &log.news);
}

fn ended(ui: &mut Ui, built: &FinishedBuild, commands: &mut Commands) {
    let name = name_of(&built.paths);
    let title = match built.end {
        BuildEnd::Done => format!("Built {name}"),
        BuildEnd::Stopped(_) => format!("Stopped building {name}"),
        BuildEnd::Failed(_) => format!("{name} could not be built"),
    };
    heading(ui, &title, |ui| {
        ui.button("✖").on_hover_text("Close").request(commands, ViewerCommand::DismissBuild);
        if built.end != BuildEnd::Done {
            ui.button("Try again").request(commands, ViewerCommand::Open(built.paths.clone()));
        }
    });
    match &built.end {
        BuildEnd::Done => {}
        BuildEnd::Stopped(what) => text(ui, RichText::new(what)),
        BuildEnd::Failed(why) => {
            let colour = ui.visuals().error_fg_color;
            let area = ScrollArea::vertical().id_salt("fault").max_height(LINES).min_scrolled_height(LINES);
            area.show(ui, |ui| text(ui, RichText::new(why).color(colour)));
        }
    }
    built.log.verdict.iter().for_each(|v| verdict(ui, v));
    lines(ui, &built.log.news);
}

/// A title, and buttons at the right of it.
fn heading(ui: &mut Ui, title: &str, buttons: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            buttons(ui);
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                ui.add(Label::new(RichText::new(title).strong().size(16.0)).truncate());
            });
        });
    });
    ui.add_space(2.0);
}

fn text(ui: &mut Ui, text: RichText) {
    ui.add(Label::new(text).selectable(true).wrap());
}

/// A mark, and a text beside it.
pub fn marked(ui: &mut Ui, mark: RichText, words: RichText) {
    ui.horizontal_top(|ui| {
        ui.label(mark);
        text(ui, words);
    });
}

fn verdict(ui: &mut Ui, verdict: &Verdict) {
    let palette = ThemePalette::for_visuals(ui.visuals());
    let (mark, colour) = if verdict.word == "good" { ("✔", palette.good) } else { ("⚠", palette.warning) };
    let sentences = verdict.sentences.join("; ");
    marked(ui, RichText::new(mark).color(colour), RichText::new(format!("{sentences}.")));
    for advice in &verdict.advice {
        marked(ui, RichText::new("•").color(colour), RichText::new(format!("{advice}.")));
    }
}

fn lines(ui: &mut Ui, news: &[News]) {
    if news.is_empty() {
        return;
    }
    ui.separator();
    let palette = ThemePalette::for_visuals(ui.visuals());
    // An area that grows upwards offers no more room than it had.
    let area = ScrollArea::vertical().id_salt("news").max_height(LINES).min_scrolled_height(LINES);
    area.show(ui, |ui| {
        for one in news.iter().take(MAX_LINES) {
            let (mark, colour, words) = match one {
                News::Making(what) => ("…", ui.visuals().weak_text_color(), what.clone()),
                News::Made(what) => ("✔", palette.good, what.clone()),
                News::NotMade(part, why) => ("✖", palette.warning, format!("no {part}: {why}")),
                News::Warning(what) => ("⚠", palette.warning, what.clone()),
                News::Skipped(what) => ("⚠", palette.warning, format!("left out: {what}")),
            };
            marked(ui, RichText::new(mark).size(SMALL).color(colour), RichText::new(words).size(SMALL));
        }
        if news.len() > MAX_LINES {
            ui.weak(format!("and {} more", news.len() - MAX_LINES));
        }
    });
}
