//! `throng-viewer`: a window or a picture, depending on the arguments.

use clap::Parser;
use std::{error::Error, io::Write, process::ExitCode};
use throng_core::base::limit_threads;
use throng_core::base::text::{escape_for_terminal, escape_json_for_terminal};
use throng_viewer::{args::Args, headless, window};

fn main() -> ExitCode {
    limit_threads();
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {}", escape_for_terminal(&e.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn run(args: &Args) -> Result<(), Box<dyn Error>> {
    let Some(out) = &args.png else { return Ok(window::run(args)?) };
    let report = headless::draw_picture(args, out)?;
    if args.json {
        return print(&(escape_json_for_terminal(&serde_json::to_string_pretty(&report)?) + "\n"));
    }
    eprintln!("{}: {} x {} pixels, drawn by {}", out.display(), report.width, report.height, report.adapter);
    Ok(())
}

/// Prints; a reader that has gone away is no failure.
fn print(text: &str) -> Result<(), Box<dyn Error>> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(e.into()),
        _ => Ok(()),
    }
}
