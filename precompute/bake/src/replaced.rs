//! A config with its motion replaced by other files: settings of its own clips do not apply to them.

use crate::examples::{AxisKind, BlendConfig, FindConfig};
use crate::{config::BuildConfig, patch::TileConfig};
use std::path::PathBuf;
use throng_motion::error::Result;
use throng_motion::import::{self, matches};

impl BuildConfig {
    /// Replaces the config's motion, and drops settings of clips that are no longer there.
    ///
    /// - returns what was dropped, and its substitutes, one sentence each.
    ///
    /// # Errors
    /// As [`import::find_motion_files`].
    pub fn replace_motion(&mut self, inputs: Vec<PathBuf>) -> Result<Vec<String>> {
        let names: Vec<String> = import::find_motion_files(&inputs)?.into_iter().map(|f| f.name).collect();
        let mut warnings = Vec::new();
        self.inputs = inputs;
        self.synth = None;
        // The clips of a file with several are unknown before it is read.
        let may_hold = |file: &str, clip: &str| clip.strip_prefix(file).is_some_and(|rest| rest.starts_with('/'));
        let there = |pattern: &str| names.iter().any(|n| matches(pattern, n) || may_hold(n, pattern));
        let before = self.clips.len();
        self.clips.retain(|name, _| there(name));
        if self.clips.len() < before {
            warnings
                .push(format!("what it says of {} clip(s) is left out: they are not there", before - self.clips.len()));
        }
        self.blend.retain(|name, space| {
            let (kept, what) = replace_examples(space, &there);
            warnings.extend(what.map(|w| format!("blend.{name}: {w}")));
            kept
        });
        self.replace_surroundings(&there, &mut warnings);
        Ok(warnings)
    }

    fn replace_surroundings(&mut self, there: &impl Fn(&str) -> bool, warnings: &mut Vec<String>) {
        if self.patches.units.is_none() {
            return;
        }
        if !self.patches.environments.is_empty() {
            self.patches.environments.clear();
            // The clips stood at the heights of their environment.
            self.retarget.align_ground = true;
            warnings.push("patches.environments: left out, as the clips were not captured in them".into());
        }
        for TileConfig { unit, clips, .. } in &mut self.patches.tiles {
            if !clips.is_empty() && !clips.iter().any(|c| there(c)) {
                warnings.push(format!("patches.tiles: `{unit}` takes all clips, as those it names are not there"));
                clips.clear();
            }
        }
        if self.patches.tiles.is_empty() {
            self.patches.units = None;
            warnings.push("patches: none, as nothing is known of what the clips were captured on".into());
        }
    }
}

/// Keeps the existing examples. If there are none, steady stretches of all clips are used instead, provided that the
/// axes of the space can be measured.
///
/// - returns false for an impossible space, and a description of the change.
fn replace_examples(space: &mut BlendConfig, there: &impl Fn(&str) -> bool) -> (bool, Option<String>) {
    let words = if space.for_each.is_empty() { vec![String::new()] } else { space.for_each.clone() };
    let known = |pattern: &str| words.iter().all(|w| there(&pattern.replace("{}", w)));
    let before = (space.examples.len(), space.find.len());
    space.examples.retain(|e| known(&e.clip));
    space.find.iter_mut().for_each(|f| f.clips.retain(|c| known(c)));
    space.find.retain(|f| !f.clips.is_empty());
    if (space.examples.len(), space.find.len()) == before {
        return (true, None);
    }
    if !(space.examples.is_empty() && space.find.is_empty()) {
        return (true, Some("examples that are not there are left out".into()));
    }
    if space.axes.iter().any(|a| a.kind == AxisKind::Style) {
        return (false, Some("left out, as its examples are not there and nothing else tells their style".into()));
    }
    space.for_each.clear();
    space.find = vec![FindConfig { clips: vec!["*".into()], mirror: true, ..FindConfig::default() }];
    (true, Some("steady stretches of all clips stand in for its examples, which are not there".into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const CONFIG: &str = "inputs = ['old']\n\
        [clips.walk_1]\nexclude = [[0, 1]]\n[clips.\"many/Run\"]\nexclude = [[0, 1]]\n[clips.run]\nexclude = [[0, 1]]\n\
        [patches]\nunits = 'u.toml'\n[[patches.environments]]\nfile = 'e.toml'\nclips = ['walk_*']\n\
        [[patches.tiles]]\nunit = 'ground'\nclips = ['stroll_*']\n\
        [retarget]\nalign_ground = false\n\
        [blend.named]\naxes = [{ kind = 'speed' }]\nexamples = [{ clip = 'walk_*' }, { clip = 'jog' }]\n\
        [blend.all]\naxes = [{ kind = 'speed' }]\nexamples = [{ clip = 'jog' }]\n\
        [blend.manner]\nfor_each = ['sad']\naxes = [{ kind = 'speed' }]\nfind = [{ clips = ['jog_{}'] }]\n\
        [blend.style]\naxes = [{ kind = 'style' }]\nexamples = [{ clip = 'jog', style = { style = 1 } }]\n";

    #[test]
    fn what_is_said_of_clips_that_are_not_there_is_left_out_and_told() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("walk_1.bvh"), "").unwrap();
        std::fs::write(folder.path().join("many.glb"), "").unwrap();
        let mut config = BuildConfig::parse(CONFIG, Path::new("x.toml")).unwrap();
        let warnings = config.replace_motion(vec![folder.path().to_path_buf()]).unwrap();
        assert_eq!(config.clips.keys().collect::<Vec<_>>(), ["many/Run", "walk_1"]);
        assert_eq!(config.blend.keys().collect::<Vec<_>>(), ["all", "manner", "named"]);
        assert_eq!(config.blend["named"].examples.len(), 1);
        for space in ["all", "manner"] {
            assert!(config.blend[space].find[0].clips == ["*"] && config.blend[space].for_each.is_empty());
        }
        assert!(config.patches.environments.is_empty() && config.retarget.align_ground);
        assert!(config.patches.tiles[0].clips.is_empty() && config.patches.units.is_some());
        assert_eq!(warnings.len(), 7, "{warnings:?}");
        assert!(config.check().is_ok());
        // Told once: nothing is left that does not hold.
        assert!(config.replace_motion(vec![folder.path().to_path_buf()]).unwrap().is_empty());
        assert!(config.replace_motion(vec![folder.path().join("nowhere")]).is_err());
    }
}
