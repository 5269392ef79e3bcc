//! Demonstrations: scenes that come with the project, a card each.

use super::heading;
use crate::command::{Commands, ViewerCommand};
use crate::panels::paint::PanelWidget;
use eframe::egui::{
    Align, ColorImage, Context, CornerRadius, CursorIcon, Image, Label, Layout, Rect, Response, RichText, Role, Sense,
    StrokeKind, TextureHandle, TextureOptions, Ui, UiBuilder, pos2, vec2,
};
use std::path::{Path, PathBuf};
use throng_precompute::run::is_complete;
use throng_simulation::Scene;

/// A demonstration.
struct Demo {
    /// File in the folder of scenes.
    file: &'static str,
    title: &'static str,
    /// Description, in plain words.
    line: &'static str,
    /// A picture of it (PNG, RGB).
    picture: &'static [u8],
}

macro_rules! demos {
    ($($name:literal $title:literal $line:literal;)*) => {
        const DEMOS: &[Demo] = &[$(Demo {
            file: concat!($name, ".toml"),
            title: $title,
            line: $line,
            picture: include_bytes!(concat!("../../../assets/", $name, ".png")),
        }),*];
    };
}

demos! {
    "plaza" "Plaza" "Two streams of people cross around a fountain. All bodies are blended from a few examples.";
    "boxing-30" "Boxers" "Thirty boxers, two by two: they come near, strike, and evade what they see coming.";
    "office" "Office" "People sit down to work, stand up, meet, talk and present.";
    "playground" "Playground" "Children climb a jungle gym by stairs and ladder, and come down its slides.";
    "corridor" "Corridor" "A thousand people meet head-on, and lanes form by themselves. No two overlap.";
    "flock" "Flock" "Two flocks of 500 birds fly through each other between columns.";
}

/// Folder of scenes, relative to the project.
const SCENES: &str = "data/scenes";
/// Width of a card at least (points).
const LEAST_WIDTH: f32 = 215.0;
/// Cards in a row at most.
const MAX_COLUMNS: f32 = 3.0;
/// Space between cards (points).
const GAP: f32 = 14.0;
/// Height of a picture over its width.
const PICTURE: f32 = 9.0 / 16.0;
/// Height of the text below the picture (points).
const TEXT: f32 = 106.0;

/// State of the demonstrations.
#[derive(Clone, Default)]
pub struct DemosState {
    /// The folder of scenes; none if it does not exist.
    folder: Option<PathBuf>,
    /// True for a scene with all its files; none if the scene does not exist.
    complete: Vec<Option<bool>>,
    pictures: Vec<Option<TextureHandle>>,
}

impl DemosState {
    /// Checks which scenes exist, and whether their files do.
    pub fn check_files(&mut self) {
        self.folder = self.folder.take().filter(|f| f.is_dir()).or_else(folder);
        let Some(folder) = &self.folder else { return };
        let complete = |d: &Demo| Scene::load(folder.join(d.file)).ok().map(|scene| is_complete(&scene));
        self.complete = DEMOS.iter().map(complete).collect();
    }
}

/// The folder of scenes: of the project in or above the current folder, or that in which this executable was built.
fn folder() -> Option<PathBuf> {
    let places = [std::env::current_dir(), std::env::current_exe()];
    let above = |place: &Path| place.ancestors().map(|a| a.join(SCENES)).find(|f| f.join(DEMOS[0].file).is_file());
    places.iter().flatten().find_map(|p| above(p))
}

/// Shows a card for each demonstration.
pub fn show(ui: &mut Ui, state: &mut DemosState, commands: &mut Commands) {
    heading(ui, "Demonstrations");
    let Some(folder) = state.folder.clone() else {
        let text = format!("The scenes of the project ({SCENES}) are not here: start the viewer in its folder.");
        return drop(ui.add(Label::new(text).wrap()));
    };
    if state.pictures.is_empty() {
        state.pictures = DEMOS.iter().map(|d| texture(ui.ctx(), d)).collect();
    }
    let there: Vec<usize> = (0..DEMOS.len()).filter(|&i| state.complete[i].is_some()).collect();
    let room = ui.available_width();
    let columns = ((room + GAP) / (LEAST_WIDTH + GAP)).floor().clamp(1.0, MAX_COLUMNS);
    let width = ((room - GAP * (columns - 1.0)) / columns).floor();
    ui.spacing_mut().item_spacing = vec2(GAP, GAP);
    for row in there.chunks(columns as usize) {
        ui.horizontal_top(|ui| {
            for &i in row {
                let (demo, is_complete) = (&DEMOS[i], state.complete[i].unwrap_or(false));
                let card = card(ui, demo, is_complete, state.pictures[i].as_ref(), width);
                card.request(commands, ViewerCommand::Open(vec![folder.join(demo.file)]));
            }
        });
    }
}

/// Shows a card.
fn card(ui: &mut Ui, demo: &Demo, is_complete: bool, picture: Option<&TextureHandle>, width: f32) -> Response {
    let height = (PICTURE * width).round();
    let (rect, response) = ui.allocate_exact_size(vec2(width, height + TEXT), Sense::click());
    let response = response.named(Role::Button, demo.title);
    let visuals = ui.visuals();
    let is_lit = response.hovered() || response.has_focus();
    let edge = if is_lit { visuals.selection.stroke.color } else { visuals.widgets.noninteractive.bg_stroke.color };
    let fill = if is_lit { visuals.widgets.hovered.weak_bg_fill } else { visuals.extreme_bg_color };
    ui.painter().rect(rect, 8.0, fill, (1.0, edge), StrokeKind::Inside);
    if let Some(picture) = picture {
        let at = Rect::from_min_size(rect.min, vec2(width, height)).shrink(1.0);
        let radius = CornerRadius { nw: 7, ne: 7, sw: 0, se: 0 };
        Image::new((picture.id(), at.size())).corner_radius(radius).paint_at(ui, at);
    }
    let within = Rect::from_min_max(pos2(rect.left(), rect.top() + height), rect.max).shrink2(vec2(12.0, 8.0));
    // Texts have fixed positions: they take no further room.
    let child = |ui: &mut Ui, layout| ui.new_child(UiBuilder::new().max_rect(within).layout(layout));
    let plain = |text: RichText| Label::new(text).selectable(false).wrap();
    let mut above = child(ui, Layout::top_down(Align::Min));
    above.spacing_mut().item_spacing.y = 3.0;
    above.add(plain(RichText::new(demo.title).size(15.0).strong()));
    above.add(plain(RichText::new(demo.line)));
    let state = if is_complete { "opens at once" } else { "is built first, once" };
    child(ui, Layout::bottom_up(Align::Min)).add(plain(RichText::new(state).size(11.5).weak()));
    response.on_hover_cursor(CursorIcon::PointingHand)
}

/// The picture of a demonstration, for the graphics device.
fn texture(ctx: &Context, demo: &Demo) -> Option<TextureHandle> {
    let picture = image::load_from_memory(demo.picture).ok()?.into_rgb8();
    let size = [picture.width() as usize, picture.height() as usize];
    let image = ColorImage::from_rgb(size, &picture);
    Some(ctx.load_texture(demo.file, image, TextureOptions::LINEAR))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_demonstration_is_there_with_a_picture() {
        let (mut state, ctx) = (DemosState::default(), Context::default());
        state.check_files();
        for (demo, complete) in DEMOS.iter().zip(&state.complete) {
            assert!(complete.is_some(), "{}", demo.file);
            let size = texture(&ctx, demo).map(|t| t.size_vec2());
            assert!(size.is_some_and(|s| (s.y / s.x - PICTURE).abs() < 0.01), "{}: {size:?}", demo.file);
        }
    }
}
