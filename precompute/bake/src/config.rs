//! Config of a build: one TOML file, with a table of settings for each stage.

use crate::activities::{ActivityConfig, ActivitySearch};
use crate::policy::{BehaviourKind, PolicyBehaviourConfig, PolicyConfig};
use crate::{cluster::ClusterConfig, examples::BlendConfig, patch::PatchConfig, select::ClipSelection};
use crate::{features::FeaturesConfig, graph::MotionGraphConfig};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use throng_base::text::TomlSource;
use throng_motion::annotate::{AnnotateConfig, Sidecar};
use throng_motion::import::{self, ImportConfig};
use throng_motion::{BuildError, Result, resample::ResampleConfig, retarget::RetargetConfig};
use throng_synth::SynthInput;

/// Config of a build. Every table but `inputs` or `synth` may be left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BuildConfig {
    /// The database's name; the config file's stem where absent.
    pub name: String,
    /// Motion files, folders and `.zip` archives, searched to any depth, or patterns with `*` in names and `**` for any
    /// folders, relative to the config file's folder.
    pub inputs: Vec<PathBuf>,
    /// Synthetic motion in place of files.
    pub synth: Option<SynthInput>,
    /// Seed of all random numbers in a build: the samples in its reports.
    pub seed: u64,
    /// Reading of files.
    pub import: ImportConfig,
    /// Choice of clips by their names.
    #[serde(skip_serializing_if = "is_default")]
    pub select: ClipSelection,
    /// Retargeting onto the database skeleton.
    pub retarget: RetargetConfig,
    /// Rate and mirrored copies.
    pub resample: ResampleConfig,
    /// Contacts, T-poses, still ends.
    pub annotate: AnnotateConfig,
    /// Ranges to leave out and names of ranges by clip, as in a sidecar file beside the clip.
    pub clips: BTreeMap<String, Sidecar>,
    /// How frames are compared.
    pub features: FeaturesConfig,
    /// Pose groups.
    pub cluster: ClusterConfig,
    /// The motion graph.
    pub graph: MotionGraphConfig,
    /// Motion patches.
    pub patches: PatchConfig,
    /// Blend spaces, by name.
    pub blend: BTreeMap<String, BlendConfig>,
    /// Activities by tag, such as greeting or sitting down, which standing bodies of blend spaces perform on request.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub activities: BTreeMap<String, ActivityConfig>,
    /// How policies are solved.
    pub policy: PolicyConfig,
    /// Behaviours of characters.
    pub behaviours: Vec<PolicyBehaviourConfig>,
}

impl Default for BuildConfig {
    fn default() -> Self {
        Self {
            name: String::new(),
            inputs: Vec::new(),
            synth: None,
            seed: 0,
            import: ImportConfig::default(),
            select: ClipSelection::default(),
            retarget: RetargetConfig::default(),
            resample: ResampleConfig::default(),
            annotate: AnnotateConfig::default(),
            clips: BTreeMap::new(),
            features: FeaturesConfig::default(),
            cluster: ClusterConfig::default(),
            graph: MotionGraphConfig::default(),
            patches: PatchConfig::default(),
            blend: BTreeMap::new(),
            activities: BTreeMap::new(),
            policy: PolicyConfig::default(),
            behaviours: vec![PolicyBehaviourConfig::default()],
        }
    }
}

impl BuildConfig {
    /// Config of some files with all other settings at their defaults.
    pub fn new(name: impl Into<String>, inputs: Vec<PathBuf>) -> Self {
        Self { name: name.into(), inputs, ..Self::default() }
    }

    /// Config for any motion: the settings of `data/walk.toml`, blows if there are some, blend spaces of
    /// steady gaits that are alike, and idles and gestures as activities. For [`crate::pipeline::build_possible`].
    ///
    /// # Errors
    /// Never in practice: the text is part of the program.
    pub fn of_motion(name: impl Into<String>, inputs: Vec<PathBuf>) -> Result<Self> {
        let walk = Self::parse(include_str!("../../../data/walk.toml"), Path::new("walk.toml"))?;
        let (mut config, kind) = (Self { name: name.into(), inputs, ..walk }, BehaviourKind::ThrowPunches);
        let blows = PolicyBehaviourConfig { name: "throw-punches".into(), kind, ..PolicyBehaviourConfig::default() };
        config.behaviours.push(blows);
        config.blend.insert("ahead".into(), BlendConfig::for_all_clips());
        for (tag, search) in [("idle", ActivitySearch::Idles), ("gesture", ActivitySearch::Gestures)] {
            config.activities.insert(tag.into(), ActivityConfig { find: Some(search), ..ActivityConfig::default() });
        }
        Ok(config)
    }

    /// Reads a config file; paths in it are relative to its folder.
    ///
    /// # Errors
    /// [`BuildError::File`] with file, line and column, and for an unknown key the nearest known one.
    pub fn load(path: &Path) -> Result<Self> {
        let mut config = Self::from_source(&TomlSource::read(path, "a config")?)?;
        if config.name.is_empty() {
            config.name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        config.paths_mut().for_each(|p| *p = folder.join(&p));
        Ok(config)
    }

    /// All files and folders that the config names.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        let (import, patches) = (&self.import, &self.patches);
        let motion = self.inputs.iter().chain(&import.asf).chain(&import.profiles);
        motion.chain(&patches.units).chain(patches.environments.iter().map(|e| &e.file))
    }

    /// Mutable form of [`Self::paths`].
    pub(crate) fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let (import, patches) = (&mut self.import, &mut self.patches);
        let motion = self.inputs.iter_mut().chain(&mut import.asf).chain(&mut import.profiles);
        motion.chain(&mut patches.units).chain(patches.environments.iter_mut().map(|e| &mut e.file))
    }

    /// Parses a config; `path` is used in messages only.
    ///
    /// # Errors
    /// As [`BuildConfig::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        Self::from_source(&TomlSource::new(text, path))
    }

    fn from_source(source: &TomlSource) -> Result<Self> {
        let config: Self = source.parse("`throng schema` prints what a config may hold.")?;
        config.check().map_err(|e| e.with_position(source))?;
        Ok(config)
    }

    /// Checks every number against its range, and settings against each other.
    ///
    /// # Errors
    /// [`BuildError::Key`] for the first fault.
    pub fn check(&self) -> Result<()> {
        match (self.inputs.is_empty(), &self.synth) {
            (true, None) => {
                let why = "expected `inputs = [\"folder\"]` or a table `[synth]`, found neither";
                return Err(BuildError::key("inputs", why));
            }
            (false, Some(_)) => {
                return Err(BuildError::key("synth", "expected `inputs` or `[synth]`, found both; leave one out"));
            }
            _ if !self.graph.enabled && !self.behaviours.is_empty() => {
                let why = "expected `behaviours = []` where `graph.enabled = false`: policies need a motion graph";
                return Err(BuildError::key("graph.enabled", why));
            }
            _ => {}
        }
        if let Some(path) = self.paths().find(|p| p.to_str().is_none()) {
            let why = format!("{}: expected a path in UTF-8; rename the folder or the file", path.display());
            return Err(BuildError::key("inputs", &why));
        }
        self.import.check().map_err(|e| e.within_key("import"))?;
        self.synth.as_ref().map_or(Ok(()), |s| s.check().map_err(|e| e.within_key("synth")))?;
        self.retarget.check()?;
        self.resample.check().map_err(|e| e.within_key("resample"))?;
        self.annotate.check().map_err(|e| e.within_key("annotate"))?;
        let sidecar = |(name, s): (&String, &Sidecar)| s.check().map_err(|e| e.within_key(&format!("clips.{name}")));
        self.clips.iter().try_for_each(sidecar)?;
        self.features.weights()?;
        self.cluster.check()?;
        self.graph.check()?;
        self.patches.check()?;
        crate::examples::spaces(&self.blend)?;
        self.policy.check()?;
        let behaviour =
            |(i, b): (usize, &PolicyBehaviourConfig)| b.check().map_err(|e| e.within_key(&format!("behaviours[{i}]")));
        self.behaviours.iter().enumerate().try_for_each(behaviour)
    }

    /// All settings of the stages from files to annotated clips, for their key.
    pub(crate) fn motion_config(&self) -> impl Serialize {
        let patches = &self.patches;
        let surroundings = (&patches.environments, &patches.touch);
        // Names of clips depend on the given folder, and a path may name one clip of a file.
        let given = (&self.inputs, import::READS_FBX);
        (given, &self.import, &self.select, &self.clips, &self.retarget, &self.resample, &self.annotate, surroundings)
    }

    /// The config as TOML, as the bundle keeps it.
    ///
    /// # Errors
    /// [`BuildError::Config`] where a value cannot be written.
    pub fn to_toml(&self) -> Result<String> {
        to_toml(self)
    }

    /// The JSON schema of config files.
    pub fn json_schema() -> schemars::Schema {
        schemars::schema_for!(BuildConfig)
    }
}

fn is_default(of: &ClipSelection) -> bool {
    *of == ClipSelection::default()
}

/// A value as TOML.
pub(crate) fn to_toml(value: &impl Serialize) -> Result<String> {
    toml::to_string(value).map_err(|e| BuildError::Config { message: e.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_names_its_line_and_the_nearest_known_one() {
        let text = "inputs = [\"a\"]\n\n[graph]\nbranshing = 3.0\n";
        let e = BuildConfig::parse(text, Path::new("x.toml")).unwrap_err().to_string();
        assert!(e.starts_with("x.toml:4:1: unknown field `branshing`"), "{e}");
        assert!(e.ends_with("Did you mean `branching`?"), "{e}");
    }

    #[test]
    fn bytes_that_are_no_text_are_named_by_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.toml");
        std::fs::write(&path, b"name = \"a\"\n\xff\xfe").unwrap();
        let e = BuildConfig::load(&path).unwrap_err().to_string();
        assert!(e.contains("x.toml:2:1: expected a config as TOML"), "{e}");
    }

    #[test]
    fn faults_of_blend_spaces_name_the_file() {
        let text = "inputs = [\"a\"]\n[blend.walk]\naxes = [{ kind = \"speed\" }]\nphases = 3\n";
        let e = BuildConfig::parse(text, Path::new("x.toml")).unwrap_err().to_string();
        assert!(e.starts_with("x.toml:4:1: blend.walk.phases: expected 8 to 1024, found 3"), "{e}");
    }

    #[test]
    fn every_number_has_a_range_and_a_fault_its_place() {
        for (text, expected) in [
            ("[import]\nrate_hz = 0.0\n", "x.toml:3:1: import.rate_hz: expected 0.1 to 100000, found 0"),
            ("[import]\nmetres_per_unit = nan\n", "x.toml:3:1: import.metres_per_unit: expected"),
            (
                "[resample]\nmirror = true\nrate_hz = 1000\n",
                "x.toml:4:1: resample.rate_hz: expected 1 to 240, found 1000",
            ),
            (
                "[retarget.proportions.explicit.offsets]\nhead = [0, 1e9, 0]\n",
                "x.toml:3:1: retarget.proportions.explicit",
            ),
            ("[annotate.contacts]\nheight_on = inf\n", "x.toml:3:1: annotate.contacts.height_on: expected 0 to 0.045"),
            (
                "[annotate.ends]\nstill_keep = -1\n",
                "x.toml:3:1: annotate.ends.still_keep: expected 0 to 10000, found -1",
            ),
            ("[annotate.hits]\nkicks.height = 1e30\n", "x.toml:3:7: annotate.hits.kicks.height: expected 0 to 10"),
            (
                "[clips.walk]\nexclude = [[0, 1], [3, 2]]\n",
                "x.toml:3:20: clips.walk.exclude[1]: expected 0 <= start < end",
            ),
            (
                "[clips.walk]\n\nclass = { gait = 'wlak' }\n",
                "x.toml:4:18: unknown variant `wlak`, expected one of `stand`, `walk`",
            ),
            (
                "[clips.walk]\nclass = { posture = 'low' }\n",
                "x.toml:3:21: unknown variant `low`, expected one of `upright`",
            ),
            ("[features]\nhorizon_s = 1e300\n", "x.toml:3:1: features.horizon_s: expected 0 to 1000000"),
            ("[features.joint_weights]\nhaed = 1\n", "x.toml:3:1: features.joint_weights.haed: no such joint."),
            ("[cluster]\nthreshold = 0.0\n", "x.toml:3:1: cluster.threshold: expected 0.000001 to 1000, found 0"),
            ("[graph]\nmin_jump_s = 1e9\n", "x.toml:3:1: graph.min_jump_s: expected 0 to 10000, found 1000000000"),
            ("[patches]\ncell_m = 9\n", "x.toml:3:1: patches.cell_m: expected 0.02 to 0.5, found 9"),
            ("[patches.touch]\npenetration = 2\n", "x.toml:3:1: patches.touch.penetration: expected 0 to 1, found 2"),
            (
                "[[patches.tiles]]\nunit = 'a'\n[[patches.tiles]]\nunit = 'b'\nslots = 0\n",
                "x.toml:6:1: patches.tiles[1].slots",
            ),
            ("[policy]\nmax_sweeps = 0\n", "x.toml:3:1: policy.max_sweeps: expected 1 to 1000000, found 0"),
            ("[[behaviours]]\n[[behaviours]]\ngrid.rings = 1\n", "x.toml:4:6: behaviours[1].grid.rings: expected 2 to"),
            ("[[behaviours]]\ngain = 1e9\n", "x.toml:3:1: behaviours[0].gain: expected -100 to 100"),
        ] {
            let e =
                BuildConfig::parse(&format!("inputs = [\"a\"]\n{text}"), Path::new("x.toml")).unwrap_err().to_string();
            assert!(e.starts_with(expected), "{e}, expected {expected}");
        }
        let e =
            BuildConfig::parse("[synth]\nset = 'walk'\nminutes = 1e9\n", Path::new("x.toml")).unwrap_err().to_string();
        assert!(e.starts_with("x.toml:3:1: synth.minutes: expected 0.05 to 240"), "{e}");
    }

    #[test]
    fn a_wrong_type_names_its_line() {
        let e = BuildConfig::parse("inputs = 3\n", Path::new("x.toml")).unwrap_err().to_string();
        assert!(e.starts_with("x.toml:1:10:"), "{e}");
        let e = BuildConfig::parse("name = \"a\"\n", Path::new("x.toml")).unwrap_err().to_string();
        assert!(e.contains("inputs"), "{e}");
    }

    #[test]
    fn what_is_written_reads_back() {
        let config = BuildConfig::new("a", vec!["b".into()]);
        let text = config.to_toml().unwrap();
        assert_eq!(BuildConfig::parse(&text, Path::new("x.toml")).unwrap(), config);
    }
}
