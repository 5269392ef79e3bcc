//! The loop that runs a scene, and its report.

use super::record::{SceneRecord, SceneRecorder};
use super::watch::{AgentWatch, SceneWatch};
use super::{figures::SceneFigures, recording::RunRecording};
use serde::Serialize;
use std::{path::Path, time::Instant};
use throng_bake::environment::{Environment, PlacedGeometry, PlacedUnit};
use throng_bake::stitch::StitchKit;
use throng_base::clock::thread_cpu_s;
use throng_core::base::limits::{SECONDS, STEP_HZ, THREADS};
use throng_core::{Executor, Inline, Rayon};
use throng_crowd::Space;
use throng_motion::error::{BuildError, Result};
use throng_simulation::{AnyCharacterGroup, CompiledScene, ExpectationWatch, MotionKind, SceneStatistics, Simulation};
use throng_simulation::{agents::SceneAgents, scenario::ExpectationOutcome, scene::ExpectedQuantity};
use throng_world::UnitRecord;

/// Samples of agents a simulated second (Hz).
pub(super) const SAMPLE_HZ: f64 = 30.0;
/// Running time of a thread above which the system's ticks do not matter (s).
const MIN_TIMED_S: f64 = 0.05;

/// Settings of a run of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneRunConfig {
    /// Simulated time; that of the scene where `None` (s, 0.001 to 100000).
    pub seconds: Option<f64>,
    /// Steps a simulated second (Hz, 1 to 10000).
    pub step_hz: f64,
    /// Records everything that a picture shows.
    pub recorded: bool,
    /// Records the positions of everybody so many times a simulated second, at most at every step (Hz, 0.1 to 240).
    pub trajectory_hz: Option<f64>,
}

impl Default for SceneRunConfig {
    fn default() -> Self {
        Self { seconds: None, step_hz: 60.0, recorded: false, trajectory_hz: None }
    }
}

/// Figures of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SceneReport {
    /// The scene's name.
    pub scene: String,
    /// Figures of all groups.
    #[serde(flatten)]
    pub total: SceneFigures,
    /// Figures of each group.
    pub groups: Vec<GroupReport>,
    /// Statistics of services and sources, if the scene has any.
    #[serde(skip_serializing_if = "SceneStatistics::is_empty")]
    pub statistics: SceneStatistics,
    /// Outcomes of the scene's expectations, if it has any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<ExpectationOutcome>,
}

/// Figures of a group.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct GroupReport {
    /// Name of the group.
    pub group: String,
    /// Kind of motion.
    pub motion: &'static str,
    /// Figures of its characters.
    #[serde(flatten)]
    pub figures: SceneFigures,
}

impl SceneReport {
    /// Figure of all, of a group, or of the statistics, by its JSON key; `None` where there is none.
    fn figure(&self, group: Option<&str>, key: &str) -> Option<f64> {
        if let Some((list, (name, key))) =
            key.split_once('.').and_then(|(list, rest)| Some((list, rest.rsplit_once('.')?)))
        {
            let all = serde_json::to_value(&self.statistics).ok()?;
            let one = all.get(list)?.as_array()?.iter().find(|one| one["name"] == name)?;
            return one.get(key)?.as_f64();
        }
        let figures = match group {
            Some(name) => &self.groups.iter().find(|g| g.group == name)?.figures,
            None => &self.total,
        };
        serde_json::to_value(figures).ok()?.get(key)?.as_f64()
    }
}

/// Checks that a scene expects no figure that its report cannot have.
///
/// # Errors
/// [`throng_core::Error::Text`] with the key of the expectation.
fn check_figures(sim: &Simulation) -> throng_core::Result<()> {
    let report = SceneReport { statistics: sim.statistics(), ..SceneReport::default() };
    let schema = schemars::schema_for!(SceneFigures).to_value();
    let is_unknown = |key: &str| schema["properties"].get(key).is_none() && report.figure(None, key).is_none();
    for (n, expect) in sim.scene().expect.iter().enumerate() {
        if let ExpectedQuantity::Figure(key) = &expect.that
            && is_unknown(key)
        {
            let why = format!("there is no figure `{key}`: `throng run --json` prints those that there are");
            return Err(sim.scene().fault(&format!("expect[{n}].that.figure"), why));
        }
    }
    Ok(())
}

/// An error of a config, by its message.
pub(super) fn config_error(why: impl std::fmt::Display) -> BuildError {
    BuildError::Config { message: why.to_string() }
}

pub(super) fn scene_error(message: String) -> BuildError {
    BuildError::Stage { stage: "scene", message, help: "`throng run --help` lists what may be given".into() }
}

/// Runs a scene.
///
/// - returns the figures, the record for pictures, and the simulation at its end.
///
/// # Errors
/// As [`Simulation::new`] and [`Simulation::step`], or [`BuildError::Stage`] for a config out of range.
pub fn run(scene: &CompiledScene, config: &SceneRunConfig) -> Result<(SceneReport, SceneRecord, Simulation)> {
    run_recorded(scene, config, None)
}

/// Like [`run`]; also fills a recording.
///
/// # Errors
/// As [`run`].
pub fn run_recorded(
    scene: &CompiledScene,
    config: &SceneRunConfig,
    mut recording: Option<&mut RunRecording>,
) -> Result<(SceneReport, SceneRecord, Simulation)> {
    let (seconds, hz) = (config.seconds.unwrap_or(scene.scene().seconds), config.step_hz);
    SECONDS.check("seconds", None, seconds).map_err(config_error)?;
    STEP_HZ.check("step_hz", None, hz).map_err(config_error)?;
    let mut sim = Simulation::new(scene).map_err(config_error)?;
    check_figures(&sim).map_err(config_error)?;
    sim.set_timed();
    let all: Vec<usize> = (0..sim.groups().len()).collect();
    let mut total = SceneWatch::new(&sim, &all)?;
    // A single group has the figures of all.
    let apart = if all.len() > 1 { &all[..] } else { &[] };
    let mut groups = apart.iter().map(|&g| SceneWatch::new(&sim, &[g])).collect::<Result<Vec<_>>>()?;
    let mut recorder = SceneRecorder::new(config, &sim, seconds);
    let mut expected = ExpectationWatch::new(scene);
    let busy_s = play_scene(&mut sim, seconds, hz, seconds, |sim, moment| {
        let ObservedStep { step, dt_s, is_last } = moment;
        total.observe(sim, dt_s, step, hz);
        groups.iter_mut().for_each(|w| w.observe(sim, dt_s, step, hz));
        recorder.observe(sim, step, hz);
        expected.iter_mut().for_each(|w| w.observe(sim));
        if let Some(recording) = recording.as_mut().filter(|_| step > 0) {
            recording.observe(sim, is_last);
        }
        Ok(())
    })?;
    let seconds = sim.time_s();
    let rate = ((seconds * hz).round() + 1.0) / busy_s.max(1e-9);
    let figures = total.figures(&sim, seconds, Some(rate));
    let groups = sim.groups().iter().enumerate().map(|(g, group)| {
        let figures = groups.get(g).map_or_else(|| figures.clone(), |watch| watch.figures(&sim, seconds, None));
        GroupReport { group: group.name.clone(), motion: group.motion.name(), figures }
    });
    let groups = groups.collect();
    let figures = SceneFigures { state_hash: Some(format!("{:016x}", sim.hash())), ..figures };
    let (scene, expectations) = (scene.scene().name.clone(), Vec::new());
    let statistics = sim.statistics();
    let mut report = SceneReport { scene, total: figures, groups, statistics, expectations };
    let outcomes = expected.map(|w| w.finish(&sim, |group, key| report.figure(group, key))).transpose();
    report.expectations = outcomes.map_err(config_error)?.unwrap_or_default();
    let record = recorder.finish(&sim, &total);
    Ok((report, record, sim))
}

/// A step of a run, as observers see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ObservedStep {
    /// Number of steps so far.
    pub step: usize,
    /// Time since the previous step (s).
    pub dt_s: f32,
    /// True if the run ends here.
    pub is_last: bool,
}

/// Steps a simulation through a scene from its start; calls `look` before the first step and after every step.
///
/// - `seconds`: duration of the run (s); `until_s`: time at which it is left, between two steps (s).
/// - returns the wall time of the steps (s).
///
/// # Errors
/// As [`Simulation::step`], and errors of `look`.
pub(crate) fn play_scene(
    sim: &mut Simulation,
    seconds: f64,
    hz: f64,
    until_s: f64,
    mut observe: impl FnMut(&Simulation, ObservedStep) -> Result<()>,
) -> Result<f64> {
    let steps = (seconds * hz).round().max(1.0) as usize;
    let mut busy_s = 0.0;
    for step in 0..=steps {
        let begin = Instant::now();
        let time_s = if step == steps { seconds } else { step as f64 / hz };
        if time_s > until_s + 1e-9 {
            break;
        }
        let dt_s = (time_s - sim.time_s()) as f32;
        // All characters are posed already: a second step without time would change where feet are planted.
        if step > 0 {
            sim.step_to(time_s, &Inline).map_err(config_error)?;
        }
        busy_s += begin.elapsed().as_secs_f64();
        let is_last = step == steps || sim.has_ended();
        observe(sim, ObservedStep { step, dt_s, is_last })?;
        if is_last {
            break;
        }
    }
    Ok(busy_s)
}

/// Runs the agents of a scene, and times their engine in a separate run without measurements, so that neither the time
/// of measuring all agents 30 times a second counts nor its effect on processor caches.
///
/// # Errors
/// As [`run`], and [`BuildError::Stage`] for a scene of other characters, or two runs that differ.
pub fn run_agents(scene: &CompiledScene, seconds: Option<f64>, threads: usize) -> Result<SceneFigures> {
    let seconds = seconds.unwrap_or(scene.scene().seconds);
    SECONDS.check("seconds", None, seconds).map_err(config_error)?;
    THREADS.check_count("threads", threads).map_err(config_error)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| scene_error(e.to_string()))?;
    let begin = Instant::now();
    let mut sim = Simulation::new(scene).map_err(config_error)?;
    let setup_s = begin.elapsed().as_secs_f64();
    let mut figures = pool.install(|| match sim.character_group_mut(0) {
        AnyCharacterGroup::Ground(agents) => measure_agents(agents, scene, seconds, threads),
        AnyCharacterGroup::Air(agents) => measure_agents(agents, scene, seconds, threads),
        _ => Err(scene_error("expected a scene of agents, with `motion = \"none\"`".into())),
    })?;
    figures.crowd.iter_mut().for_each(|c| c.setup_s = Some(setup_s));
    Ok(figures)
}

fn measure_agents<V: Space>(
    live: &mut SceneAgents<V>,
    scene: &CompiledScene,
    seconds: f64,
    threads: usize,
) -> Result<SceneFigures> {
    let run: &dyn Executor = if threads > 1 { &Rayon } else { &Inline };
    let mut alone = live.clone();
    let (begin, running) = (Instant::now(), (threads == 1).then(thread_cpu_s).flatten());
    alone.advance(seconds, run, &mut |_| {}).map_err(config_error)?;
    let wall_s = begin.elapsed().as_secs_f64();
    let ran = running.and_then(|begin| Some(thread_cpu_s()? - begin)).filter(|s| *s > MIN_TIMED_S);
    let all: Vec<usize> = (0..live.num_characters()).collect();
    let mut watch = AgentWatch::new(live, &scene.scene().measure, all);
    for frame in 0..=(seconds * SAMPLE_HZ).ceil() as u64 {
        live.advance((frame as f64 / SAMPLE_HZ).min(seconds), run, &mut |_| {}).map_err(config_error)?;
        watch.observe(live);
    }
    let (timed, hash) = (alone.crowd().hash(), live.crowd().hash());
    if timed != hash {
        return Err(BuildError::Stage {
            stage: "scene",
            message: format!("two runs of \"{}\" ended in the states {timed:016x} and {hash:016x}", scene.scene().name),
            help: "This must never happen; please report it with the scene".into(),
        });
    }
    Ok(SceneFigures {
        agents: Some(live.num_agents()),
        engine: Some(throng_simulation::scene::engine::name(scene.scene().agents.engine).into()),
        simulated_s: seconds,
        stuck: Some(watch.progress.stuck()),
        crowd: Some(watch.figures(live, seconds, Some((wall_s, ran.unwrap_or(wall_s))))),
        state_hash: Some(format!("{hash:016x}")),
        ..SceneFigures::default()
    })
}

/// Geometry of the world of a group of patches.
///
/// # Errors
/// As [`StitchKit::new`], or [`BuildError::Stage`] for a group without a world.
pub fn world_geometry(scene: &CompiledScene, group: usize) -> Result<PlacedGeometry> {
    let bundle = scene.bundle(group).map_err(config_error)?;
    let (Some(world), (Some(path), _)) = (scene.world(group), scene.scene().bundle_of(group)) else {
        return Err(scene_error(format!("group {group} is in no world")));
    };
    let kit = StitchKit::new(bundle, path)?;
    let units = placed_units(&world.world.view().units, kit.geometries.len(), &world.path)?;
    Ok(PlacedGeometry::new(&Environment { name: scene.scene().name.clone(), units }, &kit.geometries))
}

/// Units of a world, each of which is one of the bundle's.
fn placed_units(units: &[UnitRecord], num_kinds: usize, world: &Path) -> Result<Vec<PlacedUnit>> {
    let one = |u: &UnitRecord| match u.unit as usize {
        unit if unit < num_kinds => Ok(PlacedUnit { unit, placement: u.placement }),
        unit => Err(BuildError::Stage {
            stage: "scene",
            message: format!("{}: it names unit {unit}, and its bundle has {num_kinds}", world.display()),
            help: "The file is damaged: stitch the world again with `throng stitch`".into(),
        }),
    };
    units.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::patch::Placement;
    use throng_simulation::Scene;

    #[test]
    fn a_unit_that_the_bundle_lacks_is_refused_by_number_and_file() {
        let unit = |unit| UnitRecord { unit, placement: Placement::IDENTITY };
        assert_eq!(placed_units(&[unit(0), unit(2)], 3, Path::new("a.world")).unwrap().len(), 2);
        let told = placed_units(&[unit(0), unit(3)], 3, Path::new("a.world")).unwrap_err().to_string();
        assert!(told.contains("a.world") && told.contains("unit 3"), "{told}");
    }

    #[test]
    fn figures_that_no_report_has_are_refused_before_a_run() {
        let told = |figure: &str| {
            let text = format!(
                "[[groups]]\nmotion = \"none\"\ncount = 2\nplace = {{ block = {{ from = [0.0, 0.0], to = [5.0, 5.0] }} }}\n\
                 graph = \"g\"\n[graphs.g]\nlevel = \"social\"\nstart = \"a\"\n[graphs.g.states]\na = {{ do = [{{ stay = 1 }}] }}\n\
                 [[places]]\nname = \"l\"\nat = [9.0, 0.0]\nqueue = {{ points = [[9.0, 0.0], [15.0, 0.0]] }}\n\
                 [[places]]\nname = \"t\"\nat = [8.0, 0.0]\nslots = [{{ at = [8.0, 0.0] }}]\n\
                 [[services]]\nname = \"bread\"\ntills = \"t\"\nlines = [\"l\"]\ntime_s = {{ fixed = 5.0 }}\n\
                 [[expect]]\nname = \"x\"\nthat.figure = \"{figure}\"\nmost = 1\n"
            );
            let scene =
                Scene::parse(&text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"));
            check_figures(&Simulation::new(&scene).unwrap()).err().map(|e| e.to_string())
        };
        for good in ["stuck_at_end", "max_overlap_m", "services.bread.wait_p90_s", "arrived", "things_taken"] {
            assert_eq!(told(good), None);
        }
        for bad in ["stuk_at_end", "services.bred.served", "services.bread.serves"] {
            let why = told(bad).unwrap();
            assert!(why.contains("a.toml:26:") && why.contains(bad) && why.contains("`throng run --json`"), "{why}");
        }
    }
}
