//! `throng help`, and the layout of help texts: an option has one row where it fits, and rare options are in groups.

use crate::args::{CommandResult, accept_negative_numbers, fail};
use crate::{Cli, output, view};
use clap::{Arg, ArgAction, Command, CommandFactory, error::ErrorKind};
use std::ffi::OsString;

/// Width of help texts (columns).
const WIDTH: usize = 100;
/// Columns beside the name of an option and its text.
const MARGIN: usize = 8;
/// The command whose help is the viewer's, with its keys at the end.
const VIEWER: &str = "view";
/// Columns beside a text in a list of commands.
const LIST: usize = 15;

/// Print the help of a command, or after `keys` the keys of the JSON object that a command prints.
#[derive(clap::Args)]
pub struct Args {
    /// Command, such as `run`, `query path` or `keys run`; `keys` alone lists the commands that print JSON.
    words: Vec<String>,
}

/// The parser of the command line. Its help has every option in `--help`, and those of no group in `-h`.
pub fn parser(words: impl IntoIterator<Item = OsString>) -> Command {
    let all = words.into_iter().any(|word| word == "--help");
    arranged(Cli::command(), all)
}

/// A command with its help in rows, and so its subcommands.
fn arranged(command: Command, all: bool) -> Command {
    let command = command.disable_help_subcommand(true).mut_subcommands(|c| arranged(c, all));
    let command = accept_negative_numbers(command);
    // One sentence, as it also stands in lists of commands; what follows it comes last.
    let text = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let is_end = |&(i, _): &(usize, &str)| text[i + 1..].starts_with(char::is_whitespace);
    let (about, more) = text.split_at(text.match_indices('.').find(is_end).map_or(text.len(), |(i, _)| i));
    let more = if all { more.trim_start_matches('.').trim() } else { "" };
    let more = command.get_after_help().map_or(more.to_owned(), ToString::to_string);
    let command = command.about(wrapped(about, WIDTH - LIST)).after_help(wrapped(&more, WIDTH));
    // The viewer has its own help.
    if command.is_disable_help_flag_set() {
        return command;
    }
    // Arguments have names once their command is built.
    let mut built = command.clone();
    built.build();
    let is_same =
        |a: &Arg, b: &Arg| a.is_positional() == b.is_positional() && a.get_help_heading() == b.get_help_heading();
    let longest_beside = |a: &Arg| {
        built.get_arguments().filter(|b| is_same(a, b)).map(|b| b.to_string().chars().count()).max().unwrap_or(0)
    };
    let mut seen = std::collections::HashSet::new();
    let headings = command.get_arguments().filter_map(Arg::get_help_heading);
    let groups: Vec<&str> = headings.filter(|heading| seen.insert(*heading)).collect();
    let help = match groups.as_slice() {
        groups if all || groups.is_empty() => "Print help".to_owned(),
        groups => format!("Print help; `--help` has more: {}", groups.join(", ")),
    };
    let flag = Arg::new("help").short('h').long("help").action(ArgAction::HelpShort).help(help);
    let command = command.mut_args(|arg| {
        let name = longest_beside(&arg);
        row(arg, name, all)
    });
    command.disable_help_flag(true).arg(flag)
}

/// An argument whose help stands beside a name of some length; without `all`, in one sentence, and none in groups.
fn row(arg: Arg, name: usize, all: bool) -> Arg {
    let text = if all { arg.get_long_help().or(arg.get_help()) } else { arg.get_help() };
    let text = text.map(ToString::to_string).unwrap_or_default();
    let text = if all { &text } else { text.split(". ").next().unwrap_or_default() };
    let is_rare = !all && arg.get_help_heading().is_some();
    let text = wrapped(text, WIDTH - MARGIN - name);
    arg.help(text).hide_short_help(is_rare)
}

/// A text in lines of at most so many columns.
fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::new();
    for paragraph in text.split("\n\n") {
        let mut column = 0;
        if !out.is_empty() {
            out += "\n\n";
        }
        for word in paragraph.split_whitespace() {
            let len = word.chars().count();
            if column > 0 {
                let breaks = column + 1 + len > width;
                out.push(if breaks { '\n' } else { ' ' });
                column = if breaks { 0 } else { column + 1 };
            }
            out += word;
            column += len;
        }
    }
    out
}

pub fn run(args: &Args) -> CommandResult {
    let mut root = arranged(Cli::command(), true);
    root.build();
    let (keys, words) = match args.words.split_first() {
        Some((first, rest)) if first == "keys" => (true, rest),
        _ => (false, args.words.as_slice()),
    };
    let mut found = root.clone();
    for word in words {
        let Some(next) = found.find_subcommand(word).cloned() else {
            root.error(ErrorKind::InvalidSubcommand, format!("there is no command `{}`", words.join(" "))).exit()
        };
        found = next;
    }
    if !keys {
        return output::text(found.render_help());
    }
    match found.get_after_long_help() {
        Some(list) => output::text(list),
        None if words.is_empty() => output::text(format!(
            "`throng help keys COMMAND` lists the keys that a command prints with --json:\n\n  {}\n\n`name[]` is a list, \
             `name{{}}` an object from names to values; (optional) keys are left out where they do not apply.\n",
            with_keys(&root).join("\n  ")
        )),
        None if words == [VIEWER] => view::print_json_keys(),
        None => {
            fail(format!("`throng {}` has no JSON keys; `throng help keys` lists commands that have", words.join(" ")))
        }
    }
}

/// Names of the commands that print JSON.
fn with_keys(command: &Command) -> Vec<String> {
    let has_keys = |sub: &Command| sub.get_after_long_help().is_some() || sub.get_name() == VIEWER;
    let name = |sub: &Command| has_keys(sub).then(|| sub.get_name().to_owned());
    let below =
        |sub: &Command| with_keys(sub).into_iter().map(|b| format!("{} {b}", sub.get_name())).collect::<Vec<_>>();
    command.get_subcommands().flat_map(|sub| name(sub).into_iter().chain(below(sub))).collect()
}

/// Prints the line that ends the output of a command that made something: a command of `throng` that goes on from it.
pub fn next_step(words: &[&str]) -> CommandResult {
    next_command("throng", words)
}

/// As [`next_step`], with a command of another program.
pub fn next_command(program: &str, words: &[&str]) -> CommandResult {
    let plain = |c: char| c.is_alphanumeric() || "-_./:,=+@%".contains(c);
    let quoted = |word: &&str| match !word.is_empty() && word.chars().all(plain) {
        true => (*word).to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    };
    output::text(format!("next: {program} {}\n", words.iter().map(quoted).collect::<Vec<_>>().join(" ")))
}
