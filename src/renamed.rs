//! Old names on the command line are refused with the new ones.

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Flags that have another name now.
const FLAGS: [(&str, &str); 1] = [("--members", "--agents")];

/// The error to show: where a flag has another name now, one that says so.
pub fn explain(e: clap::Error) -> clap::Error {
    let Some(ContextValue::String(given)) = e.get(ContextKind::InvalidArg) else { return e };
    let flag = given.split('=').next().unwrap_or(given);
    match FLAGS.iter().find(|(old, _)| e.kind() == ErrorKind::UnknownArgument && *old == flag) {
        Some((old, new)) => clap::Error::raw(e.kind(), format!("`{old}` is now `{new}`\n")),
        None => e,
    }
}

/// Refuses a word that is no subcommand, where a file or a word once stood, and ends with exit code 2.
pub fn refuse_form(command: &str, given: &[std::ffi::OsString], new: &[(&str, &str)], all: &str) -> ! {
    let word = given.first().map_or_else(String::new, |w| w.to_string_lossy().into_owned());
    let message = match new.iter().find(|(end, _)| word.ends_with(end)) {
        Some((_, sub)) => format!(
            "`throng {command} FILE` is now `throng {command} {sub} FILE`: write `throng {command} {sub} {word}`\n"
        ),
        None => format!("`throng {command} {word}`: expected one of {all}\n"),
    };
    clap::Error::raw(ErrorKind::InvalidSubcommand, message).exit()
}
