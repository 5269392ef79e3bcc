//! Settings of the point that a behaviour brings to its target.

use schemars::JsonSchema;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Point that is to reach the target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CentreConfig {
    /// The character's planar root.
    #[default]
    Root,
    /// Centre of the effective hits: at their median distance, in the middle of their directions. Lee and Lee (2004,
    /// section 6) take the centroid of the hitting points, which is too near for hits to both sides.
    Hits,
    /// A place in the character's frame: to the left and ahead (m).
    #[serde(untagged)]
    Place([f64; 2]),
}

/// Written by hand for an error message with the value found.
impl<'de> Deserialize<'de> for CentreConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(CentreVisitor)
    }
}

struct CentreVisitor;

impl<'de> Visitor<'de> for CentreVisitor {
    type Value = CentreConfig;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("`root`, `hits` or [x, z]")
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<CentreConfig, E> {
        match word {
            "root" => Ok(CentreConfig::Root),
            "hits" => Ok(CentreConfig::Hits),
            _ => Err(E::custom(format!("expected `root`, `hits` or [x, z], found `{word}`"))),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<CentreConfig, A::Error> {
        let mut place = [0.0; 2];
        for (at, to) in place.iter_mut().enumerate() {
            *to = numbers.next_element()?.ok_or_else(|| A::Error::invalid_length(at, &self))?;
        }
        match numbers.next_element::<f64>()? {
            None => Ok(CentreConfig::Place(place)),
            Some(_) => Err(A::Error::invalid_length(3, &self)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::PolicyBehaviourConfig;
    use super::*;

    #[test]
    fn centres_are_words_or_places() {
        let read = |text: &str| toml::from_str::<PolicyBehaviourConfig>(text).map(|b| b.centre);
        assert_eq!(read("centre = \"hits\"").unwrap(), CentreConfig::Hits);
        assert_eq!(read("centre = \"root\"").unwrap(), CentreConfig::Root);
        assert_eq!(read("centre = [0.1, 0.7]").unwrap(), CentreConfig::Place([0.1, 0.7]));
        assert_eq!(read("centre = [0, 1]").unwrap(), CentreConfig::Place([0.0, 1.0]));
        for (text, expected) in [
            ("centre = \"hitz\"", "expected `root`, `hits` or [x, z], found `hitz`"),
            ("centre = [0.1]", "expected `root`, `hits` or [x, z]"),
            ("centre = [0.1, 0.2, 0.3]", "expected `root`, `hits` or [x, z]"),
            ("centre = true", "expected `root`, `hits` or [x, z]"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    #[test]
    fn centres_are_written_as_they_are_read() {
        for centre in [CentreConfig::Root, CentreConfig::Hits, CentreConfig::Place([0.1, -0.7])] {
            let config = PolicyBehaviourConfig { centre, ..PolicyBehaviourConfig::default() };
            let text = toml::to_string(&config).unwrap();
            assert_eq!(toml::from_str::<PolicyBehaviourConfig>(&text).unwrap(), config);
        }
    }
}
