//! Words in the names of files and folders that say how somebody moves.

use crate::import::split_words;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use throng_core::format::{Gait, Posture};

/// Manners that names give, as they are written.
const MANNERS: &str = "\
    active afraid aggressive angry bored catwalk chicken childish childlike chimpira cool confident depressed drunk \
    elated elderly excited exhausted feminine giant happy heavy injured joyful lazy limping macho masculine \
    masculinity monk musical nervous old proud robot sad scared sexy shy strutting stylish surprised swagger tired \
    wild young youthful zombie";
/// Manners that are none.
pub const NO_MANNER: [&str; 4] = ["normal", "neutral", "natural", "regular"];

/// Parts of a class that people name for a whole clip; the rest is found in its motion.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NamedClass {
    /// `upright`, `crouched`, `seated` or `lying`.
    #[schemars(with = "Option<String>")]
    pub posture: Option<Posture>,
    /// `stand`, `walk`, `run`, `jog`, `sneak`, `strafe`, `backwards` or `other`.
    #[schemars(with = "Option<String>")]
    pub gait: Option<Gait>,
    /// True for standing at ease, false for a gesture.
    pub neutral: Option<bool>,
    /// True where hands hold a load.
    pub carrying: Option<bool>,
    /// Manner, such as `angry`; empty for none.
    pub manner: Option<String>,
}

/// Hints of a name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NameHints {
    /// Walks.
    pub walk: bool,
    /// Runs, jogs or dashes.
    pub run: bool,
    /// Goes by stealth.
    pub sneak: bool,
    /// Goes sideways.
    pub side: bool,
    /// Crouches, squats or kneels.
    pub crouch: bool,
    /// Sits.
    pub seat: bool,
    /// Carries a load.
    pub carry: bool,
    /// Idles or stands.
    pub idle: bool,
    /// Bows, waves or shows something.
    pub gesture: bool,
    /// The manner: empty where the name says that it is none, `None` where it says nothing.
    pub manner: Option<String>,
    /// Parts of the class that hold whatever the motion shows.
    pub named: NamedClass,
}

impl NameHints {
    /// Hints of a clip's name, and of its file and the folder in which it lies.
    pub fn new(name: &str, source: &str) -> Self {
        let parts: Vec<_> = Path::new(source).iter().rev().take(2).map(|p| p.to_string_lossy().into_owned()).collect();
        // The last word of a file is its extension.
        let file = parts.first().map_or("", |p| p.rsplit_once('.').map_or(&**p, |(stem, _)| stem));
        let folder = parts.get(1).map_or("", String::as_str);
        let words = split_words(&[folder, file, name].join("/"));
        let any = |stems: &[&str]| words.iter().any(|w| stems.iter().any(|s| w.starts_with(s)));
        let exactly = |all: &[&str]| words.iter().any(|w| all.contains(&w.as_str()));
        Self {
            walk: any(&["walk", "stroll", "march"]),
            run: any(&["run", "jog", "dash", "sprint"]),
            sneak: any(&["sneak", "stealth", "tiptoe", "creep"]),
            side: any(&["strafe", "strafing", "sideways", "sidestep", "crab"]),
            crouch: any(&["crouch", "squat", "kneel", "duck"]),
            seat: any(&["sit", "seat", "chair"]),
            carry: any(&["carry", "carries", "carried"]) || exactly(&["hold", "holding"]),
            idle: any(&["idle", "idling", "stand"]) || exactly(&["rest", "wait", "waiting"]),
            gesture: any(&["bow", "wav", "bye", "call", "clap", "point", "guid", "greet"]),
            manner: manner(&words),
            named: NamedClass::default(),
        }
    }
}

/// The last manner of the words: names go from the general to the particular.
fn manner(words: &[String]) -> Option<String> {
    let at = words.iter().rposition(|w| MANNERS.split(' ').any(|m| m == w) || NO_MANNER.contains(&w.as_str()))?;
    let is_not = at > 0 && words[at - 1] == "not";
    match &words[at] {
        word if NO_MANNER.contains(&word.as_str()) => Some(String::new()),
        word if is_not => Some(format!("not-{word}")),
        word => Some(word.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_and_folders_say_how_somebody_moves() {
        let hints = |source: &str| NameHints::new("", source);
        assert!(hints("/home/runner/library/walks/03.bvh").walk && !hints("/home/runner/library/walks/03.bvh").run);
        assert!(hints("Idle_03.fbx").idle && hints("a/CarryBox.fbx").carry && hints("x/jog-02.bvh").run);
        assert!(hints("strafe_left.bvh").side && hints("sit/12.bvh").seat && !hints("position.bvh").seat);
        let manner = |source: &str| hints(source).manner;
        assert_eq!(manner("dataset-1_walk_not-confident_001.bvh").as_deref(), Some("not-confident"));
        assert_eq!(manner("happy/walk_sad2.bvh").as_deref(), Some("sad"));
        assert_eq!((manner("walk_normal.bvh").as_deref(), manner("walk.bvh")), (Some(""), None));
    }
}
