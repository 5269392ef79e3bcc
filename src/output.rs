//! Printing: JSON for machines, lines for people.

use crate::args::CommandResult;
use serde::Serialize;
use std::io::Write;
use throng_core::base::text::{escape_for_terminal, escape_json_for_terminal};
pub use throng_precompute::memory::bytes_text as bytes;

/// Prints one JSON object on standard output, without control characters for a terminal.
pub fn json(value: &impl Serialize) -> CommandResult {
    writeln!(std::io::stdout().lock(), "{}", escape_json_for_terminal(&serde_json::to_string_pretty(value)?))?;
    Ok(())
}

/// Prints text, without control characters for a terminal. Unlike `print!`, a closed output is an error here, not a panic.
pub fn text(text: impl std::fmt::Display) -> CommandResult {
    write!(std::io::stdout().lock(), "{}", escape_for_terminal(&text.to_string()))?;
    Ok(())
}

/// Prints a line on standard error, without control characters for a terminal.
pub fn print_to_stderr(line: impl std::fmt::Display) {
    eprintln!("{}", escape_for_terminal(&line.to_string()));
}

/// Prints a report as JSON, or as text.
pub fn report<T: Serialize>(report: &T, as_json: bool, print: impl FnOnce(&T) -> CommandResult) -> CommandResult {
    if as_json { json(report) } else { print(report) }
}

/// Prints lines of a label and a text, aligned.
pub fn table(rows: &[(&str, String)]) -> CommandResult {
    columns(rows.iter().map(|(label, text)| [*label, text]))
}

/// Prints rows of texts in columns.
pub fn columns<'a, const N: usize>(rows: impl Iterator<Item = [&'a str; N]>) -> CommandResult {
    let rows: Vec<_> = rows.map(|row| row.map(escape_for_terminal)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let mut out = std::io::stdout().lock();
    for row in rows {
        let padded = row[..N - 1].iter().zip(widths).map(|(text, width)| format!("{text:width$}  "));
        writeln!(out, "{}{}", padded.collect::<String>(), row[N - 1])?;
    }
    Ok(())
}

/// Prints warnings and skipped files on standard error.
pub fn warnings(skipped: &[String], warnings: &[String]) {
    warnings.iter().for_each(|w| print_to_stderr(format_args!("warning: {w}")));
    skipped.iter().for_each(|s| print_to_stderr(format_args!("skipped: {s}")));
    if !skipped.is_empty() {
        eprintln!("{} file(s) skipped; --strict stops at the first", skipped.len());
    }
}

/// True if standard output was closed early, which is not a failure.
pub fn is_broken_pipe(e: &(dyn std::error::Error + 'static)) -> bool {
    e.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
