//! Difficult command lines, for the tests and for libFuzzer: each is parsed or refused, and nothing is run.

use crate::Cli;
use clap::{Command, FromArgMatches};
use std::ffi::OsString;

/// Parses arguments as the program does; true if they are accepted. Refused ones need a message.
fn try_command_line(parser: &mut Command, words: &[OsString]) -> bool {
    let name = OsString::from("throng");
    // As `Cli::try_parse_from`, which would make the parser anew for each line.
    let parsed = parser.try_get_matches_from_mut(std::iter::once(&name).chain(words));
    match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(_) => true,
        Err(e) => {
            assert!(!e.render().to_string().is_empty(), "{words:?} are refused without a word");
            false
        }
    }
}

/// Decodes arguments, one for each line. The bytes 1 and n stand for subcommand n of the preceding command, 2 and n for its
/// flag n, with the rest of the line as its value, so that the fuzzer finds subcommands and flags without guessing.
#[cfg(fuzzing)]
fn decode_words(root: &Command, data: &[u8]) -> Vec<OsString> {
    use std::os::unix::ffi::OsStringExt;
    let mut command = root;
    let mut words = Vec::new();
    for line in data.split(|b| *b == b'\n') {
        let flags: Vec<&str> = command.get_arguments().filter_map(|a| a.get_long()).collect();
        words.push(match *line {
            [1, n, ..] if command.has_subcommands() => {
                let all: Vec<&Command> = command.get_subcommands().collect();
                command = all[usize::from(n) % all.len()];
                command.get_name().into()
            }
            [2, n, ref value @ ..] if !flags.is_empty() => {
                let flag = format!("--{}", flags[usize::from(n) % flags.len()]);
                OsString::from_vec([flag.as_bytes(), value].concat())
            }
            ref word => OsString::from_vec(word.to_vec()),
        });
    }
    words
}

#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    use clap::CommandFactory;
    thread_local!(static PARSER: std::cell::RefCell<(Command, Command)> = {
        let mut built = Cli::command();
        built.build();
        std::cell::RefCell::new((Cli::command(), built))
    });
    PARSER.with_borrow_mut(|(parser, built)| try_command_line(parser, &decode_words(built, data)));
});

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    /// Words that are hard to take.
    const WORDS: [&str; 14] = [
        "",
        "-",
        "--",
        "-1",
        "0",
        "nan",
        "inf",
        "1e999",
        "18446744073709551616",
        "a,b",
        ",",
        "=",
        "\u{0}",
        "\u{1f980}",
    ];

    /// Command lines of every command with every flag of it, each with every hard word.
    #[test]
    fn no_command_line_panics() {
        fn lines(command: &Command, before: &[OsString], out: &mut Vec<Vec<OsString>>) {
            for arg in command.get_arguments() {
                for word in WORDS {
                    let flag = arg.get_long().map(|long| format!("--{long}"));
                    let joined = flag.iter().map(|f| format!("{f}={word}").into());
                    let apart =
                        flag.clone().into_iter().chain([word.to_owned(), "file".to_owned()]).map(OsString::from);
                    out.push(before.iter().cloned().chain(joined).collect());
                    out.push(before.iter().cloned().chain(apart).collect());
                }
            }
            for sub in command.get_subcommands() {
                lines(sub, &[before, &[sub.get_name().into()]].concat(), out);
            }
        }
        let (mut parser, mut all) = (Cli::command(), Vec::new());
        lines(&parser, &[], &mut all);
        assert!(all.len() > 2000, "{} command lines", all.len());
        let parsed = all.iter().filter(|line| try_command_line(&mut parser, line)).count();
        assert!(parsed > 50 && parsed < all.len() / 2, "{parsed} of {} are accepted", all.len());
    }
}
