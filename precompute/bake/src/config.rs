//! What a build is told: one TOML file, each stage's settings in a table of its own.

use crate::cluster::ClusterConfig;
use crate::examples::BlendConfig;
use crate::features::FeaturesConfig;
use crate::graph::GraphConfig;
use crate::patch::PatchConfig;
use crate::policy::{BehaviourConfig, PolicyConfig};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use throng_base::text::Source;
use throng_motion::annotate::{AnnotateConfig, Sidecar};
use throng_motion::error::BuildError;
use throng_motion::import::ImportConfig;
use throng_motion::resample::ResampleConfig;
use throng_motion::retarget::RetargetConfig;
use throng_synth::SynthInput;

/// A build. Every table but `inputs` or `synth` may be left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BuildConfig {
    /// The database's name; the config file's stem where absent.
    pub name: String,
    /// Motion files, folders, or patterns with `*` in the file name, relative to the config file's folder.
    pub inputs: Vec<PathBuf>,
    /// Motion that the project makes itself, in place of files.
    pub synth: Option<SynthInput>,
    /// Seed of everything random in a build: the samples in its reports.
    pub seed: u64,
    /// Reading of files.
    pub import: ImportConfig,
    /// Retargeting onto the database skeleton.
    pub retarget: RetargetConfig,
    /// Rate and mirrored copies.
    pub resample: ResampleConfig,
    /// Contacts, T-poses, still ends.
    pub annotate: AnnotateConfig,
    /// Ranges to leave out and names of ranges by clip, as a sidecar file beside the clip has them.
    pub clips: BTreeMap<String, Sidecar>,
    /// How frames are compared.
    pub features: FeaturesConfig,
    /// Pose groups.
    pub cluster: ClusterConfig,
    /// The motion graph.
    pub graph: GraphConfig,
    /// Motion patches.
    pub patches: PatchConfig,
    /// Blend spaces, by name.
    pub blend: BTreeMap<String, BlendConfig>,
    /// How policies are solved.
    pub policy: PolicyConfig,
    /// What characters can be asked to do.
    pub behaviours: Vec<BehaviourConfig>,
}

impl Default for BuildConfig {
    fn default() -> Self {
        Self {
            name: String::new(),
            inputs: Vec::new(),
            synth: None,
            seed: 0,
            import: ImportConfig::default(),
            retarget: RetargetConfig::default(),
            resample: ResampleConfig::default(),
            annotate: AnnotateConfig::default(),
            clips: BTreeMap::new(),
            features: FeaturesConfig::default(),
            cluster: ClusterConfig::default(),
            graph: GraphConfig::default(),
            patches: PatchConfig::default(),
            blend: BTreeMap::new(),
            policy: PolicyConfig::default(),
            behaviours: vec![BehaviourConfig::default()],
        }
    }
}

impl BuildConfig {
    /// A build of some files with everything else as it comes.
    pub fn new(name: impl Into<String>, inputs: Vec<PathBuf>) -> Self {
        Self { name: name.into(), inputs, ..Self::default() }
    }

    /// Reads a config file; paths in it are taken from its folder.
    ///
    /// # Errors
    /// [`BuildError::Io`], or [`BuildError::Config`] with file, line and column, and for an unknown key the nearest
    /// known one.
    pub fn load(path: &Path) -> Result<Self, BuildError> {
        let mut config = Self::of(&Source::read(path, "a config")?)?;
        if config.name.is_empty() {
            config.name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let places = config.inputs.iter_mut().chain(&mut config.import.asf).chain(&mut config.import.profiles);
        let patches = &mut config.patches;
        let places = places.chain(&mut patches.units).chain(patches.environments.iter_mut().map(|e| &mut e.file));
        places.for_each(|p| *p = folder.join(&p));
        Ok(config)
    }

    /// Reads a config's text; `path` is for messages alone.
    ///
    /// # Errors
    /// [`BuildError::Config`] as [`BuildConfig::load`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, BuildError> {
        Self::of(&Source::new(text, path))
    }

    fn of(source: &Source) -> Result<Self, BuildError> {
        let config: Self = source.parse("`throng schema` prints what a config may hold.")?;
        config.check(source.path())?;
        Ok(config)
    }

    fn check(&self, path: &Path) -> Result<(), BuildError> {
        let fault = match (self.inputs.is_empty(), &self.synth) {
            (true, None) => "expected `inputs = [\"folder\"]` or a table `[synth]`, found neither".to_owned(),
            (false, Some(_)) => "expected `inputs` or `[synth]`, found both; leave one out".to_owned(),
            _ if !self.graph.enabled && !self.behaviours.is_empty() => {
                "expected `behaviours = []` where `graph.enabled = false`: policies need a motion graph".to_owned()
            }
            _ => match crate::examples::spaces(&self.blend) {
                Ok(_) => return Ok(()),
                Err(BuildError::Config { message }) => message,
                Err(other) => return Err(other),
            },
        };
        Err(BuildError::Config { message: format!("{}: {fault}", path.display()) })
    }

    /// All that the stages from files to annotated clips take, for their key.
    pub(crate) fn motion(&self) -> impl Serialize {
        let patches = &self.patches;
        let surroundings = (&patches.environments, &patches.touch);
        (&self.import, &self.clips, &self.retarget, &self.resample, &self.annotate, surroundings)
    }

    /// The config as TOML, as the bundle keeps it.
    ///
    /// # Errors
    /// [`BuildError::Config`] where a value cannot be written.
    pub fn to_toml(&self) -> Result<String, BuildError> {
        toml::to_string(self).map_err(|e| BuildError::Config { message: e.to_string() })
    }

    /// The JSON schema of config files.
    pub fn json_schema() -> schemars::Schema {
        schemars::schema_for!(BuildConfig)
    }
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
        assert!(e.starts_with("x.toml: blend.walk.phases: expected 8 to 1024, found 3"), "{e}");
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
