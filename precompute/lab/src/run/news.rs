//! What is said while something is made.

use std::fmt;
use throng_bake::report::BuildReport;

/// A line about what is made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum News {
    /// What is made now, and from what.
    Making(String),
    /// What was made.
    Made(String),
    /// What could not be made: what, and why with the way out.
    NotMade(String, String),
    /// What is odd but tolerable.
    Warning(String),
    /// A file that is left out, and why.
    Skipped(String),
}

impl News {
    /// What is to be said of a build that has ended.
    pub fn of(report: &BuildReport) -> impl Iterator<Item = Self> {
        let not_made = report.not_made.iter().map(|n| Self::NotMade(n.part.clone(), n.why.clone()));
        let warnings = report.warnings.iter().cloned().map(Self::Warning);
        let skipped = report.skipped.iter().cloned().map(Self::Skipped);
        std::iter::once(Self::Made(report.made())).chain(not_made).chain(warnings).chain(skipped)
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
