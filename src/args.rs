//! Arguments that several subcommands share.

use clap::{Arg, Command};
use std::any::TypeId;
use std::path::{Path, PathBuf};
use throng_core::{Bundle, base::error::ensure, base::limits, characters::ActionChoice};
use throng_crowd::Scheme;
use throng_precompute::import::{self, ImportConfig, UpAxis};
use throng_precompute::{cache::Cache, config::BuildConfig, error::Result, run::motion_name, trial::TrialConfig};
use throng_simulation::{Scene, scene::engine};

/// Text that is printed if no command is given.
pub const FIRST_STEPS: &str = "\
Throng makes characters that walk where they are sent out of motion capture. Three commands matter:

  throng inspect FOLDER          what is in your motion files (.bvh, .amc, .npz, .glb, .fbx; .zip of them), what they lack
  throng build FOLDER            bakes them into FOLDER.throng
  throng run FOLDER --png a.png  a thousand characters on them, measured and drawn

No motion at hand? `throng demo` makes some and does all of it. `throng help` lists every command.
";

/// Text below every `--help`.
pub const AFTER_HELP: &str = "Exit codes: 0 done, 1 failed (the message names file, line or joint and the way out), \
2 wrong usage. With --json, a command prints one JSON object on standard output and everything else on standard error.";

/// Result of a subcommand.
pub type CommandResult<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// An error with a message.
pub fn fail<T>(message: impl Into<String>) -> CommandResult<T> {
    Err(message.into().into())
}

/// True for the name of a bundle, false for that of a motion file.
pub fn is_bundle(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("throng"))
}

/// A command whose options of numbers take negative ones too, so that their own parsers refuse those with the range.
pub fn accept_negative_numbers(command: Command) -> Command {
    let numbers =
        [TypeId::of::<f32>(), TypeId::of::<f64>(), TypeId::of::<u32>(), TypeId::of::<u64>(), TypeId::of::<usize>()];
    let is_number = |arg: &Arg| numbers.iter().any(|number| arg.get_value_parser().type_id() == *number);
    command.mut_args(|arg| if is_number(&arg) { arg.allow_negative_numbers(true) } else { arg })
}

/// Opens a bundle; messages name the file.
pub fn open_bundle(path: &Path) -> CommandResult<Bundle> {
    Bundle::open(path).map_err(|e| match e {
        throng_core::FormatError::Io { .. } => e.to_string().into(),
        e => format!("{}: {e}", path.display()).into(),
    })
}

/// Options for reading motion files.
#[derive(clap::Args)]
pub struct ReadArgs {
    /// Skeleton of an AMC file; found beside it by default.
    #[arg(long, help_heading = "Reading motion", value_name = "FILE")]
    asf: Option<PathBuf>,
    /// Skeleton profile: a file (`.toml`), or the name of a built-in one.
    #[arg(long, help_heading = "Reading motion", value_name = "FILE_OR_NAME")]
    profile: Option<PathBuf>,
    /// Config that says how files are read and annotated.
    #[arg(long, help_heading = "Reading motion", value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    units: UnitArgs,
}

fn parse_up(text: &str) -> std::result::Result<UpAxis, String> {
    match text.to_ascii_lowercase().as_str() {
        "y" => Ok(UpAxis::Y),
        "z" => Ok(UpAxis::Z),
        _ => Err("expected y or z".into()),
    }
}

/// Options that say how motion is read, and which clips are used.
pub const MOTION_FLAGS: [&str; 5] = ["--metres-per-unit", "--rate-hz", "--up", "--use", "--leave"];

/// Those of some options that this call has, as they were given, each before its value.
pub fn given_flags(flags: &[&str]) -> Vec<String> {
    let args: Vec<String> = std::env::args().collect();
    let is_flag = |arg: &str| flags.contains(&arg.split('=').next().unwrap_or_default());
    let is_given = |i: usize| is_flag(&args[i]) || i > 0 && flags.contains(&args[i - 1].as_str());
    (0..args.len()).filter(|&i| is_given(i)).map(|i| args[i].clone()).collect()
}

/// Options that say what motion files leave open.
#[derive(Default, clap::Args)]
pub struct UnitArgs {
    /// Length of a unit of the files (m); by default by the body's height.
    #[arg(long, help_heading = "Reading motion", value_name = "M", value_parser = limits::number_parser::<f64>(&limits::METRES_PER_UNIT))]
    metres_per_unit: Option<f64>,
    /// Frames a second of the files, in place of what they say (Hz).
    #[arg(long, help_heading = "Reading motion", value_name = "N", value_parser = limits::number_parser::<f64>(&limits::MOTION_HZ))]
    rate_hz: Option<f64>,
    /// Axis that points up in the files: y or z.
    #[arg(long, help_heading = "Reading motion", value_name = "AXIS", value_parser = parse_up)]
    up: Option<UpAxis>,
}

impl UnitArgs {
    /// Puts the given options in place of those of a config.
    pub fn apply(&self, import: &mut ImportConfig) {
        import.metres_per_unit = self.metres_per_unit.or(import.metres_per_unit);
        import.rate_hz = self.rate_hz.or(import.rate_hz);
        import.up = self.up.or(import.up);
    }

    /// Config of a build of everything that some motion allows.
    pub fn motion_config(&self, motion: &[PathBuf]) -> CommandResult<BuildConfig> {
        let mut config = BuildConfig::of_motion(motion_name(motion), motion.to_vec())?;
        self.apply(&mut config.import);
        Ok(config)
    }
}

impl ReadArgs {
    /// Build config of these options.
    pub fn config(&self) -> CommandResult<BuildConfig> {
        let mut config = match &self.config {
            Some(path) => BuildConfig::load(path)?,
            None => BuildConfig::of_motion("", Vec::new())?,
        };
        config.import.asf = self.asf.clone().or(config.import.asf);
        self.units.apply(&mut config.import);
        match &self.profile {
            Some(file) if is_toml(file) => config.import.profiles.insert(0, file.clone()),
            Some(name) => config.import.profile = Some(name.to_string_lossy().into_owned()),
            None => {}
        }
        Ok(config)
    }

    /// Build config for some files; a skeleton that none of them can use is an error.
    pub fn config_for(&self, files: &[PathBuf]) -> CommandResult<BuildConfig> {
        let is_amc = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("amc"));
        if let (Some(asf), [file, ..]) = (&self.asf, files)
            && import::expand(files).is_ok_and(|all| !all.iter().any(is_amc))
        {
            let (file, asf) = (file.display(), asf.display());
            return fail(format!(
                "{file}: --asf gives AMC files a skeleton ({asf}), and here is none; leave --asf out"
            ));
        }
        self.config()
    }
}

/// Choice of clips by their names.
#[derive(clap::Args)]
pub struct SelectArgs {
    /// Use only clips of such a name (`*walk*`), and all their motion.
    #[arg(long = "use", help_heading = "Reading motion", value_name = "NAME")]
    wanted: Vec<String>,
    /// Leave out clips of such a name (`*carry*`).
    #[arg(long, help_heading = "Reading motion", value_name = "NAME")]
    leave: Vec<String>,
}

impl SelectArgs {
    /// Adds the choice to that of a config.
    pub fn add_to(&self, config: &mut BuildConfig) {
        config.select.wanted.extend(self.wanted.iter().cloned());
        config.select.leave.extend(self.leave.iter().cloned());
    }

    /// True where something is chosen.
    pub fn is_given(&self) -> bool {
        !self.wanted.is_empty() || !self.leave.is_empty()
    }
}

/// The engine of a name.
pub fn named_engine(name: &str) -> CommandResult<Scheme> {
    let unknown = || format!("--engine {name}: expected one of {}", engine::names());
    Ok(engine::scheme_named(name).ok_or_else(unknown)?)
}

/// True for the name of a config or a scene.
pub fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}

/// Options of the cache of stage outputs.
#[derive(clap::Args)]
pub struct CacheArgs {
    /// Folder that keeps the outputs of stages between builds, or s3://BUCKET/PREFIX in programs built for it.
    #[arg(long, help_heading = "Cache", value_name = "DIR", default_value = Cache::FOLDER)]
    cache: PathBuf,
    /// Greatest size of the folder, in GB; the least recently used entries are removed first.
    #[arg(long, help_heading = "Cache", value_name = "GB", default_value_t = Cache::LIMIT_BYTES as f64 / 1e9, value_parser = limits::number_parser::<f64>(&limits::CACHE_GB))]
    cache_limit: f64,
    /// Run every stage, and keep nothing.
    #[arg(long, help_heading = "Cache")]
    no_cache: bool,
}

impl CacheArgs {
    /// Folder of the cache; none if nothing is kept.
    pub fn folder(&self) -> Option<PathBuf> {
        (!self.no_cache).then(|| self.cache.clone())
    }

    /// Opens the cache of these options.
    pub fn cache(&self) -> Result<Cache> {
        match self.no_cache {
            true => Ok(Cache::disabled()),
            false => Cache::at_address(&self.cache, (self.cache_limit * 1e9) as u64),
        }
    }
}

/// Reads a scene; that of a stranger names files below its folder alone, and nothing is built for it.
pub fn load_scene(file: &Path, is_untrusted: bool) -> throng_core::Result<Scene> {
    if is_untrusted { Scene::load_untrusted(file) } else { Scene::load(file) }
}

/// Reads a point of the ground plane, X,Z (m).
pub fn parse_point(text: &str) -> Result<[f32; 2], String> {
    let limit = &limits::COORDINATE;
    let number = |t: &str| t.trim().parse().ok().filter(|v: &f32| limit.contains(f64::from(*v)));
    let both = text.split_once(',').and_then(|(x, z)| Some([number(x)?, number(z)?]));
    both.ok_or_else(|| format!("expected X,Z in metres, such as 1.5,4; each is {}", limit.range))
}

/// Default of the simulated time (s).
const SECONDS: f32 = 20.0;

/// Group of options that few runs need.
const CHARACTERS: &str = "Characters";

/// Options of a run: number of characters, time, seed and choice of actions.
#[derive(clap::Args)]
pub struct CrowdArgs {
    /// Number of characters; 1000, or what the scene says, where absent.
    #[arg(long, value_name = "N", value_parser = limits::number_parser::<usize>(&limits::CHARACTERS))]
    characters: Option<usize>,
    /// Simulated time; 20, or what the scene says, where absent.
    #[arg(long, value_name = "S", value_parser = limits::number_parser::<f32>(&limits::SECONDS))]
    pub seconds: Option<f32>,
    /// Steps a simulated second.
    #[arg(long, help_heading = CHARACTERS, default_value_t = 60.0, value_name = "HZ", value_parser = limits::number_parser::<f32>(&limits::STEP_HZ))]
    pub step_hz: f32,
    /// Seed of places, targets and choices; 1, or what the scene says, where absent.
    #[arg(long, value_parser = limits::number_parser::<u64>(&limits::SEED))]
    seed: Option<u64>,
    /// Choose by the stored best action instead of looking ahead; not for scenes.
    #[arg(long, help_heading = CHARACTERS)]
    single_load: bool,
    /// Choose at random among the best few actions, 0 for always the best; 0, or what the scene says, where absent.
    #[arg(long, help_heading = CHARACTERS, value_name = "T", value_parser = limits::number_parser::<f32>(&limits::TEMPERATURE))]
    temperature: Option<f32>,
    /// Let characters take no notice of each other; not for scenes.
    #[arg(long, help_heading = CHARACTERS)]
    no_avoid: bool,
    /// Character shown as a strip of poses; not for scenes.
    #[arg(long, help_heading = CHARACTERS, default_value_t = 0, value_name = "N", value_parser = limits::number_parser::<usize>(&limits::FOLLOWED))]
    follow: usize,
}

impl CrowdArgs {
    /// Trial config of these options.
    pub fn trial(&self) -> TrialConfig {
        let mut trial = TrialConfig {
            seconds: self.seconds.unwrap_or(SECONDS),
            step_hz: self.step_hz,
            recorded: Some(self.follow),
            ..TrialConfig::default()
        };
        trial.characters = self.characters.unwrap_or(trial.characters);
        trial.seed = self.seed.unwrap_or(trial.seed);
        trial.motion.seed = trial.seed;
        trial.motion.avoid = trial.motion.avoid.filter(|_| !self.no_avoid);
        let temperature = self.temperature.unwrap_or(0.0);
        trial.motion.choice =
            if self.single_load { ActionChoice::BestAction } else { ActionChoice::LookAhead { temperature } };
        trial
    }

    /// Overrides settings of a scene by the given options.
    pub fn override_scene(&self, scene: &mut Scene) -> CommandResult {
        let is_of_bundle = self.single_load || self.follow != 0;
        ensure(!is_of_bundle, || "--single-load and --follow are for bundles, not for scenes")?;
        if let Some(temperature) = self.temperature {
            let mut with_behaviours = scene.groups.iter_mut().filter(|g| !g.behaviours.is_empty()).peekable();
            let fault = "--temperature is for bundles and scenes with behaviours";
            ensure(with_behaviours.peek().is_some(), || fault)?;
            with_behaviours.for_each(|g| g.temperature = f64::from(temperature));
        }
        if let Some(characters) = self.characters {
            *scene = scene.resized(characters);
        }
        scene.seed = self.seed.unwrap_or(scene.seed);
        Ok(())
    }
}
