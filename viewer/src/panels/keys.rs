//! The list of keys, which docs/viewer.md repeats. Keys of units are in `viewport/world.rs`.

use super::PANELS;
use eframe::egui::{self, Grid, Key, Modal, Modifiers, RichText, Ui};

/// Action of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyAction {
    /// Start or stop time.
    PlayPause,
    /// One step back.
    Back,
    /// One step forward.
    On,
    /// A second back.
    BackSecond,
    /// A second on.
    OnSecond,
    /// To the start of the recording.
    First,
    /// To the end of the recording.
    Last,
    /// Slower.
    Slower,
    /// Faster.
    Faster,
    /// Restart the run.
    Restart,
    /// Crowd, blend or clip: the next available stage.
    Stage,
    /// Camera follows.
    Follow,
    /// Move the camera so that everything is in view.
    FrameAll,
    /// Next body.
    Body,
    /// Joint axes.
    JointAxes,
    /// Steer the selected character, or release it.
    Steer,
    /// Select nothing.
    SelectNone,
    /// Next theme.
    Theme,
    /// Open a file.
    Open,
    /// Read the file again.
    Reload,
    /// Take the last change of a world back.
    Undo,
    /// Make it again.
    Redo,
    /// This list.
    Help,
}

/// A key and its action.
#[derive(Clone, Copy, Debug)]
pub struct Shortcut {
    /// Held with it.
    pub modifiers: Modifiers,
    /// The key.
    pub key: Key,
    /// Action of the key.
    pub action: KeyAction,
    /// Description of the action.
    pub text: &'static str,
}

const fn plain(key: Key, action: KeyAction, text: &'static str) -> Shortcut {
    Shortcut { modifiers: Modifiers::NONE, key, action, text }
}

const fn with_modifiers(modifiers: Modifiers, key: Key, action: KeyAction, text: &'static str) -> Shortcut {
    Shortcut { modifiers, key, action, text }
}

const COMMAND_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

/// All keys but those of the panels, which are in [`PANELS`]. Keys with modifiers come before the same keys without,
/// since the first match counts.
pub const SHORTCUTS: &[Shortcut] = &[
    plain(Key::Space, KeyAction::PlayPause, "play or pause"),
    with_modifiers(Modifiers::SHIFT, Key::ArrowLeft, KeyAction::BackSecond, "a second back"),
    with_modifiers(Modifiers::SHIFT, Key::ArrowRight, KeyAction::OnSecond, "a second forward"),
    plain(Key::ArrowLeft, KeyAction::Back, "one step back"),
    plain(Key::ArrowRight, KeyAction::On, "one step forward"),
    plain(Key::Home, KeyAction::First, "start of the recording"),
    plain(Key::End, KeyAction::Last, "end of the recording"),
    plain(Key::OpenBracket, KeyAction::Slower, "half as fast"),
    plain(Key::CloseBracket, KeyAction::Faster, "twice as fast"),
    with_modifiers(Modifiers::COMMAND, Key::R, KeyAction::Reload, "reload the file"),
    plain(Key::R, KeyAction::Restart, "restart the run"),
    plain(Key::C, KeyAction::Stage, "crowd, blend or clip"),
    plain(Key::F, KeyAction::Follow, "camera follows the selected character"),
    plain(Key::G, KeyAction::Steer, "steer the selected one: W A S D, Shift, X"),
    plain(Key::A, KeyAction::FrameAll, "show everything"),
    plain(Key::B, KeyAction::Body, "next body"),
    plain(Key::J, KeyAction::JointAxes, "joint axes"),
    plain(Key::Escape, KeyAction::SelectNone, "select nothing"),
    plain(Key::T, KeyAction::Theme, "dark or light"),
    with_modifiers(Modifiers::COMMAND, Key::O, KeyAction::Open, "open a file"),
    with_modifiers(COMMAND_SHIFT, Key::Z, KeyAction::Redo, "redo"),
    with_modifiers(Modifiers::COMMAND, Key::Y, KeyAction::Redo, "redo"),
    with_modifiers(Modifiers::COMMAND, Key::Z, KeyAction::Undo, "undo the last edit of a world"),
    plain(Key::H, KeyAction::Help, "this list"),
];

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

/// The actions of the keys pressed since the last frame; removes these keys from the input.
///
/// - `leaves_arrows`: something that has the focus is moved by the arrow keys.
pub fn take_pressed(ctx: &egui::Context, leaves_arrows: bool) -> Vec<KeyAction> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    let is_left = |s: &Shortcut| leaves_arrows && [Key::ArrowLeft, Key::ArrowRight].contains(&s.key);
    let hit = |s: &&Shortcut| !is_left(s) && ctx.input_mut(|i| i.consume_key(s.modifiers, s.key));
    SHORTCUTS.iter().filter(hit).map(|s| s.action).collect()
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
        let same = SHORTCUTS.iter().filter(|o| o.action == s.action);
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
        let actions =
            SHORTCUTS.iter().enumerate().filter(|(i, s)| SHORTCUTS[..*i].iter().all(|e| e.action != s.action));
        assert_eq!(rows.len(), actions.count());
    }

    #[test]
    fn a_key_with_shift_or_ctrl_is_looked_for_before_the_plain_one() {
        for (i, s) in SHORTCUTS.iter().enumerate() {
            let hidden = SHORTCUTS[..i].iter().any(|e| e.key == s.key && e.modifiers.is_none());
            assert!(!hidden, "{:?} would never be reached", s.action);
        }
    }
}
