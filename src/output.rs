//! Printing: JSON for machines, lines for people.

use crate::args::CommandResult;
use serde::Serialize;
use std::io::Write;
use throng_core::base::text::{escape_for_terminal, escape_json_for_terminal};

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

/// Prints lines of a label and a text, aligned.
pub fn table(rows: &[(&str, String)]) -> CommandResult {
    let rows: Vec<_> =
        rows.iter().map(|(label, text)| (escape_for_terminal(label), escape_for_terminal(text))).collect();
    let width = rows.iter().map(|r| r.0.chars().count()).max().unwrap_or(0);
    let mut out = std::io::stdout().lock();
    for (label, text) in rows {
        writeln!(out, "{label:width$}  {text}")?;
    }
    Ok(())
}

/// Prints rows of three texts below a heading, in columns.
pub fn columns<'a>(heading: [&'a str; 3], rows: impl Iterator<Item = [&'a str; 3]>) -> CommandResult {
    let rows: Vec<_> = std::iter::once(heading).chain(rows).map(|row| row.map(escape_for_terminal)).collect();
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let (first, second) = (width(0), width(1));
    let mut out = std::io::stdout().lock();
    for [a, b, c] in rows {
        writeln!(out, "{a:first$}  {b:second$}  {c}")?;
    }
    Ok(())
}

/// Prints warnings and skipped files on standard error.
pub fn warnings(skipped: &[String], warnings: &[String]) {
    for w in warnings {
        print_to_stderr(format_args!("warning: {w}"));
    }
    for s in skipped {
        print_to_stderr(format_args!("skipped: {s}"));
    }
    if !skipped.is_empty() {
        eprintln!("{} file(s) skipped; --strict stops at the first", skipped.len());
    }
}

/// A number of bytes as text.
pub fn bytes(n: u64) -> String {
    match n {
        0..10_000 => format!("{n} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        _ => format!("{:.1} MB", n as f64 / 1e6),
    }
}

/// True if standard output was closed early, which is not a failure.
pub fn is_broken_pipe(e: &(dyn std::error::Error + 'static)) -> bool {
    e.downcast_ref::<std::io::Error>().is_some_and(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
