//! Messages of a build.

use std::fmt;
use throng_bake::report::BuildReport;

/// A message about something that is built.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum News {
    /// Begin of a step: what is made, and from what.
    Making(String),
    /// Something that was made.
    Made(String),
    /// Something that could not be made, and the reason with a remedy.
    NotMade(String, String),
    /// A tolerated oddity.
    Warning(String),
    /// A skipped file, and the reason.
    Skipped(String),
}

impl News {
    /// Messages on a finished build.
    pub fn from_report(report: &BuildReport) -> impl Iterator<Item = Self> {
        let not_made = report.not_made.iter().map(|n| Self::NotMade(n.part.clone(), n.why.clone()));
        let warnings = report.warnings.iter().cloned().map(Self::Warning);
        let skipped = report.skipped.iter().cloned().map(Self::Skipped);
        std::iter::once(Self::Made(report.summary())).chain(not_made).chain(warnings).chain(skipped)
    }
}

impl fmt::Display for News {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Making(what) => write!(f, "{what} ..."),
            Self::Made(what) => write!(f, "made: {what}"),
            Self::NotMade(part, why) => write!(f, "no {part}: {why}"),
            Self::Warning(what) => write!(f, "warning: {what}"),
            Self::Skipped(what) => write!(f, "skipped: {what}"),
        }
    }
}
