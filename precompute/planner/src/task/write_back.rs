//! Writes moved things back into a task's text: only the numbers that changed.

use super::{Handle, Task};
use glam::DVec3;
use std::ops::Range;
use throng_base::{Error, Result, text::TomlSource};

/// Distance below which a move is not written (m).
const SAME_M: f64 = 5e-5;
/// Fineness of written numbers (1/m).
const DIGITS: f64 = 1e4;

/// A part of a text, and what replaces it.
type Edit = (Range<usize>, String);

impl Task {
    /// The text of a task's file with things and places where they are now; comments, spaces and all other numbers stay.
    ///
    /// - `source`: text from which the task was read.
    ///
    /// # Errors
    /// Errors of [`Task::parse`]; a text about other things, or with numbers in an unsupported notation.
    pub fn write_back(&self, source: &TomlSource) -> Result<String> {
        let before = Self::parse(source.text(), source.path())?;
        if before.handles() != self.handles() {
            return Err(source.error_at_span(0..0, "the file lists other things by now; open it again".into()));
        }
        let mut edits = Vec::new();
        for handle in self.handles() {
            let by = self.written_position(handle) - before.written_position(handle);
            if by.length() >= SAME_M {
                before.edits(source, handle, by, &mut edits)?;
            }
        }
        edits.sort_by_key(|(span, _)| std::cmp::Reverse(span.start));
        let mut text = source.text().to_owned();
        edits.into_iter().for_each(|(span, new)| text.replace_range(span, &new));
        Ok(text)
    }

    fn edits(&self, source: &TomlSource, handle: Handle, by: DVec3, out: &mut Vec<Edit>) -> Result<()> {
        let num_obstacles = self.things.iter().filter(|t| !t.is_object).count();
        let table = match handle {
            Handle::Thing(i) if i < num_obstacles => format!("scene.obstacles[{i}]"),
            Handle::Thing(i) => format!("scene.objects[{}]", i - num_obstacles),
            Handle::Place(i) => format!("tasks[{i}].to"),
        };
        let keys = (0..).map(|i| format!("{table}.keys[{i}].at"));
        let mut places: Vec<String> = keys.take_while(|k| source.value_span(k).is_some()).collect();
        if places.is_empty() {
            places.push(format!("{table}.at"));
        }
        for place in places {
            if source.value_span(&place).is_none() {
                out.push(insert_at_table(source, &table, self.written_position(handle) + by)?);
                continue;
            }
            for axis in (0..3).filter(|k| by[*k].abs() >= SAME_M) {
                let key = format!("{place}[{axis}]");
                let number = source.value_span(&key).and_then(|span| {
                    let old: f64 = source.text()[span.clone()].replace('_', "").parse().ok()?;
                    Some((span, number(old + by[axis])))
                });
                out.push(number.ok_or_else(|| unknown(source, &key))?);
            }
        }
        Ok(())
    }
}

/// `at` before the first key of a table that has none.
fn insert_at_table(source: &TomlSource, table: &str, at: DVec3) -> Result<Edit> {
    let keys = ["name", "shape", "shapes", "on", "turn_deg"].map(|k| source.key_span(&format!("{table}.{k}")));
    let first = keys.into_iter().flatten().min_by_key(|span| span.start).ok_or_else(|| unknown(source, table))?;
    let [x, y, z] = at.to_array().map(number);
    let before = source.text()[..first.start].trim_end_matches([' ', '\t']);
    let end = if before.ends_with(['{', ',']) { ", " } else { "\n" };
    Ok((first.start..first.start, format!("at = [{x}, {y}, {z}]{end}")))
}

fn unknown(source: &TomlSource, key: &str) -> Error {
    source.error_at_key(key, format!("expected `at` as three plain numbers at `{key}`; write it by hand"))
}

fn number(x: f64) -> String {
    // No negative zero.
    format!("{:?}", (x * DIGITS).round() / DIGITS + 0.0)
}
