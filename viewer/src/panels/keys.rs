//! The list of keys, which docs/viewer.md repeats. Keys of units are in `viewport/world.rs`.

use super::PANELS;
use crate::command::{SteerCommand, ViewerCommand, WorldCommand};
use crate::{model::Model, run::STEP_HZ, settings::ViewerSettings};
use KeyAction::{Ask, Change, Help, Open};
use ViewerCommand::{FrameAll, Play, Reload, Restart, Seek, SelectCharacter, Speed, Stage, Steer, Step, World};
use eframe::egui::{self, Grid, Key, Modal, Modifiers, RichText, ThemePreference, Ui};

/// Action of a key.
#[derive(Clone, Copy)]
pub enum KeyAction {
    /// Asks the model for something.
    Ask(fn(&Model) -> ViewerCommand),
    /// Changes settings; the last argument is true in a dark window.
    Change(fn(&mut ViewerSettings, &Model, bool)),
    /// Opens a file.
    Open,
    /// Shows this list.
    Help,
}

/// A key and its action.
#[derive(Clone, Copy)]
pub struct Shortcut {
    /// Held with it.
    pub modifiers: Modifiers,
    /// The key.
    pub key: Key,
    /// Description of the action; keys with the same description have the same action.
    pub text: &'static str,
    /// Action of the key.
    pub action: KeyAction,
}

const fn plain(key: Key, text: &'static str, action: KeyAction) -> Shortcut {
    with_modifiers(Modifiers::NONE, key, text, action)
}

const fn with_modifiers(modifiers: Modifiers, key: Key, text: &'static str, action: KeyAction) -> Shortcut {
    Shortcut { modifiers, key, text, action }
}

const COMMAND_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// All keys but those of the panels, which are in [`PANELS`]. Keys with modifiers come before the same keys without,
/// since the first match counts.
pub const SHORTCUTS: &[Shortcut] = &[
    plain(Key::Space, "play or pause", Ask(|m| Play(!m.is_playing()))),
    with_modifiers(Modifiers::SHIFT, Key::ArrowLeft, "a second back", Ask(|m| Step(-steps_a_second(m)))),
    with_modifiers(Modifiers::SHIFT, Key::ArrowRight, "a second forward", Ask(|m| Step(steps_a_second(m)))),
    plain(Key::ArrowLeft, "one step back", Ask(|_| Step(-1))),
    plain(Key::ArrowRight, "one step forward", Ask(|_| Step(1))),
    plain(Key::Home, "start of the recording", Ask(|_| Seek(0))),
    plain(Key::End, "end of the recording", Ask(|_| Seek(u32::MAX))),
    plain(Key::OpenBracket, "half as fast", Ask(|m| Speed(speed(m) * 0.5))),
    plain(Key::CloseBracket, "twice as fast", Ask(|m| Speed(speed(m) * 2.0))),
    with_modifiers(Modifiers::COMMAND, Key::R, "reload the file", Ask(|_| Reload)),
    plain(Key::R, "restart the run", Ask(|_| Restart)),
    plain(Key::C, "crowd, blend or clip", Ask(|m| Stage(m.next_stage()))),
    plain(Key::F, "camera follows the selected character", Change(|s, _, _| s.follow = !s.follow)),
    plain(Key::G, "steer the selected one: W A S D, Shift, X", Ask(|_| Steer(SteerCommand::Toggle))),
    plain(Key::A, "show everything", Ask(|_| FrameAll)),
    plain(Key::B, "next body", Change(|s, m, _| s.body = m.next_body())),
    plain(Key::J, "joint axes", Change(|s, _, _| s.overlays.joint_axes = !s.overlays.joint_axes)),
    plain(Key::Escape, "select nothing", Ask(|_| SelectCharacter(None))),
    plain(
        Key::T,
        "dark or light",
        Change(|s, _, is_dark| s.theme = if is_dark { ThemePreference::Light } else { ThemePreference::Dark }),
    ),
    with_modifiers(Modifiers::COMMAND, Key::O, "open a file", Open),
    with_modifiers(COMMAND_SHIFT, Key::Z, "redo", Ask(|_| World(WorldCommand::Redo))),
    with_modifiers(Modifiers::COMMAND, Key::Y, "redo", Ask(|_| World(WorldCommand::Redo))),
    with_modifiers(Modifiers::COMMAND, Key::Z, "undo the last edit of a world", Ask(|_| World(WorldCommand::Undo))),
    plain(Key::H, "this list", Help),
];

/// Steps of the run, or frames of the clip, in a second.
fn steps_a_second(model: &Model) -> i32 {
    (if model.shows_clip() { model.shown_clip().map_or(30.0, |c| c.1) } else { STEP_HZ }) as i32
}

/// Seconds that pass in one.
fn speed(model: &Model) -> f32 {
    model.head().map_or(model.player.speed, |h| h.speed())
}

/// Width of the list, where the window has room for it (points).
const WIDTH: f32 = 900.0;

/// Actions of the mouse in the 3-D view.
const MOUSE: [(&str, &str); 11] = [
    ("click", "select a character, or a unit of a world"),
    ("drag a target", "move it; with Shift, all targets"),
    ("Ctrl + click the ground", "put the selected character's target there"),
    ("drag a thing of a task", "move it; up and down with Alt"),
    ("drag a unit", "move it, where Patches says Move"),
    ("Q, E, Delete", "turn or remove it"),
    ("drag", "turn the camera"),
    ("middle or Shift + drag", "move the camera"),
    ("right drag, scroll", "nearer and farther"),
    ("double click", "turn the camera about that place"),
    ("Ctrl + plus, minus, 0", "size of everything in the window"),
];

/// The keys pressed since the last frame; removes them from the input.
///
/// - `leaves_arrows`: something that has the focus is moved by the arrow keys.
pub fn take_pressed(ctx: &egui::Context, leaves_arrows: bool) -> Vec<&'static Shortcut> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    let is_left = |s: &Shortcut| leaves_arrows && [Key::ArrowLeft, Key::ArrowRight].contains(&s.key);
    let hit = |s: &&Shortcut| !is_left(s) && ctx.input_mut(|i| i.consume_key(s.modifiers, s.key));
    SHORTCUTS.iter().filter(hit).collect()
}

/// Shows the list until it is closed.
pub fn show(ui: &Ui, open: &mut bool) {
    if !*open {
        return;
    }
    let shown = Modal::new(egui::Id::unique("keys")).show(ui.ctx(), |ui| {
        ui.heading("Keys");
        ui.add_space(6.0);
        let room = ui.ctx().content_rect().size() - egui::vec2(60.0, 140.0);
        ui.set_width(room.x.min(WIDTH));
        egui::ScrollArea::both().max_height(room.y).show(ui, tables);
        ui.add_space(6.0);
        ui.button("Close").clicked()
    });
    *open = !(shown.should_close() || shown.inner);
}

fn tables(ui: &mut Ui) {
    ui.horizontal_top(|ui| {
        table(ui, "keys", rows(ui.ctx()));
        ui.add_space(24.0);
        ui.vertical(|ui| {
            table(ui, "panels", PANELS.iter().map(|p| (p.key.name().to_owned(), p.title)).collect());
            ui.add_space(12.0);
            ui.strong("Mouse in the 3-D view");
            table(ui, "mouse", MOUSE.map(|m| (m.0.to_owned(), m.1)).to_vec());
        });
    });
}

/// Keys with their actions; keys with the same action share a row.
fn rows(ctx: &egui::Context) -> Vec<(String, &'static str)> {
    let of = |s: &Shortcut| {
        let same = SHORTCUTS.iter().filter(|o| o.text == s.text);
        let name = |s: &Shortcut| match s.modifiers.is_none() {
            true => s.key.symbol_or_name().to_owned(),
            false => ctx.format_shortcut(&egui::KeyboardShortcut::new(s.modifiers, s.key)),
        };
        let keys: Vec<String> = same.map(name).collect();
        (keys.join(", "), s.text)
    };
    let mut rows: Vec<_> = SHORTCUTS.iter().map(of).collect();
    rows.dedup();
    rows
}

fn table(ui: &mut Ui, id: &str, rows: Vec<(String, &str)>) {
    Grid::new(id).num_columns(2).spacing([16.0, 0.0]).show(ui, |ui| {
        for (key, text) in rows {
            ui.label(RichText::new(key).monospace().strong());
            ui.label(text);
            ui.end_row();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_things_share_a_key() {
        let mut keys: Vec<_> = SHORTCUTS.iter().map(|s| (s.modifiers, s.key)).collect();
        keys.extend(PANELS.iter().map(|p| (Modifiers::NONE, p.key)));
        for (i, a) in keys.iter().enumerate() {
            assert!(!keys[..i].contains(a), "{a:?}");
        }
    }

    #[test]
    fn keys_with_the_same_action_are_listed_together() {
        let rows = rows(&egui::Context::default());
        let actions = SHORTCUTS.iter().enumerate().filter(|(i, s)| SHORTCUTS[..*i].iter().all(|e| e.text != s.text));
        assert_eq!(rows.len(), actions.count());
    }

    #[test]
    fn a_key_with_shift_or_ctrl_is_looked_for_before_the_plain_one() {
        for (i, s) in SHORTCUTS.iter().enumerate() {
            let hidden = SHORTCUTS[..i].iter().any(|e| e.key == s.key && e.modifiers.is_none());
            assert!(!hidden, "{} would never be reached", s.text);
        }
    }
}
