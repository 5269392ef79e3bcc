//! The list of synthetic sets.

use super::{SynthConfig, boxing, files, locomotion, office, people, playground, walk};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use throng_motion::clip::ClipSet;
use throng_motion::error::{BuildError, Result};

/// A set of synthetic motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SynthSet {
    /// Wandering with turns, stops and starts.
    #[default]
    Walk,
    /// Shadow-boxing with footwork, combinations and defences.
    Boxing,
    /// People in an office, at the desk and standing about.
    Office,
    /// Stairs, a ladder and slides of a gym, and walking between them.
    Playground,
    /// Steady walking, jogging, running, turning, side and back steps and standing, in several manners.
    Locomotion,
    /// Greeting, shaking hands, looking at things, buying, chatting, sitting, waiting and cheering, one clip each.
    People,
}

impl SynthSet {
    /// All sets.
    pub const ALL: [Self; 6] =
        [Self::Walk, Self::Boxing, Self::Office, Self::Playground, Self::Locomotion, Self::People];

    /// Name on the command line, in configs and in clips.
    pub fn name(self) -> &'static str {
        ["walk", "boxing", "office", "playground", "locomotion", "people"][self as usize]
    }

    /// Set with a given name.
    ///
    /// # Errors
    /// [`BuildError::Config`] with the existing names.
    pub fn from_name(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(|s| format!("`{}`", s.name())).join(" or ");
            BuildError::Config { message: format!("synthetic set: expected {names}, found `{name}`") }
        })
    }
}

/// Makes a set, on the default skeleton, with the true foot contacts.
///
/// - returns clips `SET_00`, `SET_01`, ... that begin and end at rest: standing, or on guard; those of the locomotion
///   set have descriptive names, such as `walk_neutral_v110_gl08`, and move throughout.
///
/// # Errors
/// [`BuildError::Config`] for a value outside its limits.
pub fn make_set(set: SynthSet, cfg: &SynthConfig) -> Result<ClipSet> {
    cfg.check()?;
    Ok(match set {
        SynthSet::Walk => walk::walk(cfg),
        SynthSet::Boxing => boxing::boxing(cfg),
        SynthSet::Office => office::office(cfg),
        SynthSet::Playground => playground::playground(cfg),
        SynthSet::Locomotion => locomotion::locomotion(cfg),
        SynthSet::People => people::people(cfg),
    })
}

/// Makes a set and writes each clip as `NAME.bvh`, and its tags as `NAME.toml`, into a folder, which is created if
/// missing.
///
/// - returns the set.
///
/// # Errors
/// As [`make_set`] and [`files::save`].
pub fn write_set(set: SynthSet, cfg: &SynthConfig, folder: &Path) -> Result<ClipSet> {
    let made = make_set(set, cfg)?;
    files::save(&made, folder)?;
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_has_a_name_that_finds_it() {
        for set in SynthSet::ALL {
            assert_eq!(SynthSet::from_name(set.name()).unwrap(), set);
            assert_eq!(serde_json::to_value(set).unwrap(), set.name());
        }
        let error = SynthSet::from_name("dance").unwrap_err().to_string();
        assert!(
            error.contains("`walk` or `boxing` or `office` or `playground` or `locomotion` or `people`")
                && error.contains("`dance`"),
            "{error}"
        );
    }

    #[test]
    fn refuses_a_value_outside_its_limits() {
        for set in SynthSet::ALL {
            let error = make_set(set, &SynthConfig { rate_hz: 0.0, ..SynthConfig::default() }).unwrap_err().to_string();
            assert!(error.contains("synth.rate_hz") && error.contains("20 to 240"), "{error}");
            assert!(make_set(set, &SynthConfig { minutes: f64::NAN, ..SynthConfig::default() }).is_err());
        }
    }

    #[test]
    fn same_seed_same_motion_and_another_seed_another() {
        for set in SynthSet::ALL {
            let of = |seed| make_set(set, &SynthConfig { seed, minutes: 0.4, ..SynthConfig::default() }).unwrap();
            assert_eq!(of(1), of(1));
            assert_ne!(of(1).clips[0].rotations, of(2).clips[0].rotations);
        }
    }

    #[test]
    fn a_higher_rate_only_samples_the_same_motion_more_often() {
        for (set, minutes) in [(SynthSet::Walk, 0.5), (SynthSet::Boxing, 0.3), (SynthSet::Playground, 0.2)] {
            let of = |rate_hz| make_set(set, &SynthConfig { rate_hz, minutes, ..SynthConfig::default() }).unwrap();
            let [slow, fast] = [of(30.0), of(60.0)].map(|mut set| set.clips.remove(0).root_positions);
            for (f, slow) in slow.iter().enumerate() {
                assert!(slow.distance(fast[2 * f]) < 1e-3, "{set:?} frame {f}: {slow} and {}", fast[2 * f]);
            }
        }
    }

    #[test]
    fn clips_may_be_as_short_as_the_limit_says() {
        for set in SynthSet::ALL {
            let made =
                make_set(set, &SynthConfig { clip_seconds: 3.0, minutes: 0.2, ..SynthConfig::default() }).unwrap();
            assert!(made.clips.iter().all(|c| c.num_frames() > 60), "{set:?}");
        }
    }

    #[test]
    fn sets_last_as_long_as_asked() {
        for set in SynthSet::ALL {
            let cfg = SynthConfig::for_set(set);
            let made = make_set(set, &cfg).unwrap();
            // What two do together comes on top.
            let alone = made.clips.iter().filter(|c| !c.name.starts_with("office_pair"));
            let minutes = alone.map(|c| c.num_frames()).sum::<usize>() as f64 / cfg.rate_hz / 60.0;
            assert!((cfg.minutes..cfg.minutes + 1.0).contains(&minutes), "{set:?}: {minutes}");
            for clip in &made.clips {
                let least = match set {
                    SynthSet::People => 3.0,
                    SynthSet::Locomotion => 4.0,
                    _ => 6.0,
                };
                assert!((least..95.0).contains(&(clip.num_frames() as f64 / clip.rate_hz)), "{}", clip.name);
            }
        }
    }
}
