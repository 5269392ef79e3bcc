//! Parts of a bundle that the motion may not allow: reported and left out, or refused.

use schemars::JsonSchema;
use serde::Serialize;
use throng_motion::error::{BuildError, Result};

/// Parts of a config that a build must make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RequiredParts {
    /// All parts: a failure ends the build.
    All,
    /// Parts that the motion allows, each by itself: a failure is reported.
    Possible,
}

/// A part that a build could not make.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SkippedPart {
    /// Name of the part, such as `policy throw-punches` or `blend space ahead`.
    pub part: String,
    /// Reason, and the way out.
    pub why: String,
}

/// Collects parts that could not be made.
pub(crate) struct Attempts {
    pub parts: RequiredParts,
    pub not_made: Vec<SkippedPart>,
}

impl Attempts {
    pub fn new(parts: RequiredParts) -> Self {
        Self { parts, not_made: Vec::new() }
    }

    /// Parts of a list that are made together: all of them, or each by itself.
    pub fn units_of_work<'a, T>(&self, list: &'a [T]) -> impl Iterator<Item = &'a [T]> + use<'a, T> {
        let together = match self.parts {
            RequiredParts::All => list.len(),
            RequiredParts::Possible => 1,
        };
        list.chunks(together.max(1))
    }

    /// A finished part; `None` if the motion did not allow it and it may be missing.
    ///
    /// # Errors
    /// The fault, if the part must be made or if the motion is not the cause.
    pub fn accept<T>(&mut self, part: impl Into<String>, made: Result<T>) -> Result<Option<T>> {
        let why = match made {
            Ok(made) => return Ok(Some(made)),
            Err(e) if self.parts == RequiredParts::All || !is_of_motion(&e) => return Err(e),
            Err(BuildError::Key { why, .. }) => why.trim_end_matches('.').to_owned(),
            Err(BuildError::Stage { message, help, .. }) => format!("{message}. {}", help.trim_end_matches('.')),
            Err(BuildError::Config { message }) => message.trim_end_matches('.').to_owned(),
            Err(e) => return Err(e),
        };
        self.not_made.push(SkippedPart { part: part.into(), why });
        Ok(None)
    }
}

/// True for faults of which motion or settings are the cause; others, such as a stop, end a build.
pub fn is_of_motion(e: &BuildError) -> bool {
    matches!(e, BuildError::Key { .. } | BuildError::Stage { .. } | BuildError::Config { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_motion_does_not_allow_is_told_and_what_else_goes_wrong_ends_the_build() {
        let bad = || Err::<u8, _>(BuildError::key("a", "too little motion."));
        assert!(Attempts::new(RequiredParts::All).accept("policy a", bad()).is_err());
        let mut attempts = Attempts::new(RequiredParts::Possible);
        assert_eq!(attempts.accept("policy a", bad()).unwrap(), None);
        assert_eq!(attempts.accept("policy b", Ok(3)).unwrap(), Some(3));
        assert!(attempts.accept::<u8>("policy c", Err(BuildError::Format("torn".into()))).is_err());
        assert_eq!(attempts.not_made, [SkippedPart { part: "policy a".into(), why: "too little motion".into() }]);
        assert_eq!(attempts.units_of_work(&[1, 2, 3]).count(), 3);
        assert_eq!(Attempts::new(RequiredParts::All).units_of_work(&[1, 2, 3]).collect::<Vec<_>>(), [[1, 2, 3]]);
        assert_eq!(Attempts::new(RequiredParts::All).units_of_work::<u8>(&[]).count(), 0);
    }
}
