//! Choice of clips by their names.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_motion::{BuildError, Result, import::matches};

/// Most names in a message.
const MAX_NAMED_CLIPS: usize = 6;

/// Choice of clips by their names, or the last parts of these; `*` stands for any text.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ClipSelection {
    /// Clips to use: these alone, and all their motion, whatever its class. Empty for all clips.
    #[serde(rename = "use")]
    pub wanted: Vec<String>,
    /// Clips to leave out.
    pub leave: Vec<String>,
}

impl ClipSelection {
    /// True for a clip that is used.
    pub fn takes(&self, name: &str) -> bool {
        let is_named = |patterns: &[String]| patterns.iter().any(|p| is_named(p, name));
        (self.wanted.is_empty() || is_named(&self.wanted)) && !is_named(&self.leave)
    }

    /// Checks that every pattern names a clip, and that one is left.
    ///
    /// # Errors
    /// [`BuildError::Key`] naming the pattern and a few clips.
    pub fn check(&self, names: &[&str]) -> Result<()> {
        let there_are = || {
            let more = if names.len() > MAX_NAMED_CLIPS { ", ..." } else { "" };
            names.iter().take(MAX_NAMED_CLIPS).map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ") + more
        };
        for (key, patterns) in [("select.use", &self.wanted), ("select.leave", &self.leave)] {
            if let Some(pattern) = patterns.iter().find(|p| !names.iter().any(|n| is_named(p, n))) {
                let within = format!("*{}", pattern.trim_start_matches('*'));
                let or = names.iter().any(|n| is_named(&within, n)).then(|| format!(", but `{within}` names some"));
                let message =
                    format!("no clip is named `{pattern}`{}; there are {}", or.unwrap_or_default(), there_are());
                return Err(BuildError::key(key, message));
            }
        }
        match names.is_empty() || names.iter().any(|n| self.takes(n)) {
            true => Ok(()),
            false => Err(BuildError::key("select.leave", format!("every clip is left out; there are {}", there_are()))),
        }
    }
}

fn is_named(pattern: &str, name: &str) -> bool {
    matches(pattern, name) || name.rsplit_once('/').is_some_and(|(_, last)| matches(pattern, last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_are_chosen_by_the_whole_name_or_its_last_part() {
        let of = |wanted: &[&str], leave: &[&str]| ClipSelection {
            wanted: wanted.iter().map(|s| (*s).to_owned()).collect(),
            leave: leave.iter().map(|s| (*s).to_owned()).collect(),
        };
        let names = ["walks/walk_1", "walks/carry", "run_1"];
        let taken = |s: &ClipSelection| names.map(|n| s.takes(n));
        assert_eq!(taken(&of(&[], &[])), [true; 3]);
        assert_eq!(taken(&of(&["walk*"], &["carry*"])), [true, false, false]);
        assert_eq!(taken(&of(&["walks/*"], &[])), [true, true, false]);
        let e = of(&["jog*"], &[]).check(&names).unwrap_err().to_string();
        assert!(e.contains("select.use: no clip is named `jog*`; there are `walks/walk_1`"), "{e}");
        let e = of(&["alk*"], &[]).check(&names).unwrap_err().to_string();
        assert!(e.contains("no clip is named `alk*`, but `*alk*` names some; there are"), "{e}");
        assert!(of(&[], &["*"]).check(&names).unwrap_err().to_string().contains("every clip is left out"));
    }
}
