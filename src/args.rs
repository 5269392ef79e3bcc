//! Arguments that several subcommands share.

use std::path::{Path, PathBuf};
use throng_precompute::cache::Cache;
use throng_precompute::scene::{RunConfig, Scene};
use throng_precompute::trial::TrialConfig;
use throng_runtime::Tables;
use throng_runtime::troupe::Choice;

/// Below every `--help`.
pub const AFTER_HELP: &str = "Exit codes: 0 done, 1 failed (the message names file, line or joint and the way out), \
2 wrong usage. With --json, a command prints one JSON object on standard output and everything else on standard error.";

/// What a subcommand returns.
pub type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A message as an error.
pub fn fail<T>(message: impl Into<String>) -> Result<T, Box<dyn std::error::Error>> {
    Err(message.into().into())
}

/// True for the name of a bundle, as against that of a motion file.
pub fn is_bundle(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("throng"))
}

/// Opens a bundle; messages name the file.
pub fn open(path: &Path) -> Result<Tables, Box<dyn std::error::Error>> {
    Tables::open(path).map_err(|e| match e {
        throng_runtime::FormatError::Io { .. } => e.to_string().into(),
        e => format!("{}: {e}", path.display()).into(),
    })
}

/// Where stages keep their outputs.
#[derive(clap::Args)]
pub struct CacheArgs {
    /// Folder that keeps the outputs of stages between builds.
    #[arg(long, value_name = "DIR", default_value = ".throng-cache")]
    cache: PathBuf,
    /// Run every stage, and keep nothing.
    #[arg(long)]
    no_cache: bool,
}

impl CacheArgs {
    /// The cache they name.
    pub fn cache(&self) -> Cache {
        if self.no_cache { Cache::none() } else { Cache::in_folder(&self.cache) }
    }
}

/// Simulated time where nothing else is said. [Unit: s]
const SECONDS: f32 = 15.0;

/// Who runs, for how long and how.
#[derive(clap::Args)]
pub struct CrowdArgs {
    /// Number of characters; 1000, or what the scene says, where absent.
    #[arg(long, value_name = "N")]
    characters: Option<usize>,
    /// Simulated time; 15, or of a crowd what its scene says, where absent.
    #[arg(long, value_name = "S")]
    seconds: Option<f32>,
    /// Steps a simulated second.
    #[arg(long, default_value_t = 60.0, value_name = "HZ")]
    step_hz: f32,
    /// Seed of places, targets and choices; 1, or what the scene says, where absent.
    #[arg(long)]
    seed: Option<u64>,
    /// Choose by the stored best action instead of looking ahead; not for scenes.
    #[arg(long)]
    single_load: bool,
    /// Choose at random among the best few actions, 0 for always the best; 0, or what the scene says, where absent.
    #[arg(long, value_name = "T")]
    temperature: Option<f32>,
    /// How far a walked action may be bent towards the target, in radians a metre; 0 plays motion as captured. Not
    /// for scenes.
    #[arg(long, default_value_t = 0.0, value_name = "RAD_PER_M")]
    bend: f32,
    /// Character shown as a strip of poses; not for scenes.
    #[arg(long, default_value_t = 0, value_name = "N")]
    follow: usize,
}

impl CrowdArgs {
    /// The trial they describe.
    pub fn trial(&self) -> TrialConfig {
        let mut trial = TrialConfig {
            seconds: self.seconds.unwrap_or(SECONDS),
            step_hz: self.step_hz,
            recorded: Some(self.follow),
            ..TrialConfig::default()
        };
        trial.characters = self.characters.unwrap_or(trial.characters);
        trial.seed = self.seed.unwrap_or(trial.seed);
        trial.troupe.seed = trial.seed;
        trial.troupe.bend_rad_per_m = self.bend;
        let temperature = self.temperature.unwrap_or(0.0);
        trial.troupe.choice = if self.single_load { Choice::BestAction } else { Choice::LookAhead { temperature } };
        trial
    }

    /// How long a scene runs.
    pub fn scene_run(&self) -> RunConfig {
        RunConfig { seconds: self.seconds.unwrap_or(SECONDS), step_hz: self.step_hz, ..RunConfig::default() }
    }

    /// How long to run, where that is given. [Unit: s]
    pub fn seconds(&self) -> Option<f32> {
        self.seconds
    }

    /// Puts what is given in place of what a scene without behaviours says: of people in a world, of walkers,
    /// of a crowd.
    pub fn change_living(&self, characters: &mut usize, seed: &mut u64) -> Outcome {
        if self.single_load || self.bend != 0.0 || self.follow != 0 || self.temperature.is_some() {
            return fail(
                "--single-load, --bend, --follow and --temperature are for bundles and scenes with behaviours",
            );
        }
        *characters = self.characters.unwrap_or(*characters);
        *seed = self.seed.unwrap_or(*seed);
        Ok(())
    }

    /// Puts what is given in place of what a scene says.
    pub fn change(&self, scene: &mut Scene) -> Outcome {
        if self.single_load || self.bend != 0.0 || self.follow != 0 {
            return fail("--single-load, --bend and --follow are for bundles, not for scenes");
        }
        scene.characters = self.characters.unwrap_or(scene.characters);
        scene.seed = self.seed.unwrap_or(scene.seed);
        scene.temperature = self.temperature.map_or(scene.temperature, f64::from);
        Ok(())
    }
}
