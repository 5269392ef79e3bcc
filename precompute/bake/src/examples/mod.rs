//! Blend spaces: example motions, their cardinal weights and their postures as tables (Kim, Kim and Shin 2003a, section
//! 4).
//!
//! Examples are cycles of two steps of steady locomotion, named by the config or found in clips. Each is placed in a
//! parameter space by the arc that fits its path. Weights are tabulated over a box of that space, and postures over
//! generic time, so that a posture is one small matrix-vector product at run time.

mod alike;
pub mod arc;
pub mod average;
pub mod cardinal;
mod config;
mod cycle;
mod dense;
pub mod grid;
pub mod judge;
mod posture;
mod select;
mod steady;
mod steps;
mod track;
mod twist;

pub use config::{AxisConfig, AxisKind, BlendConfig, ExampleConfig, Extrapolation, FindConfig};

use alike::{Refusals, SpaceClass, UsualCarriage};
use arc::{Arc, wrap_angle};
use average::{displacement, exponential, reference};
use cardinal::{CardinalBasis, CardinalFault};
use cycle::Cycle;
use grid::{ParameterBounds, WeightTable};
use judge::{BLEND_WORDS, BlendQuality};
use posture::Postures;
use select::{ExampleCandidate, ExampleSource};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use steps::StepCycle;
use throng_core::blend::{
    AxisRecord, BlendRecord, BlendSpace, Blends, ChannelRow, ExampleRecord, MAX_AXES, MAX_KNOTS, MAX_WEIGHT,
    ReferenceRow,
};
use throng_core::format::{BlendMeta, FormatError, Table};
use throng_core::{Bundle, Skeleton};
use throng_motion::{BuildError, ClipSet, Progress, Result, Warnings};
use track::{ClipTrack, FractionalPose};
use twist::FacingTwist;

/// Displacement of a joint from its reference beyond which its antipode is near, where the shorter way changes sides
/// (rad).
const FAR_APART: f64 = 2.6;

/// A blend space, as the bundle stores it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RawBlendSpace {
    /// Unique name.
    pub name: String,
    /// Names of the axes.
    pub axes: Vec<String>,
    /// Names of the examples.
    pub example_names: Vec<String>,
    /// The record, as if the space were the only one of its bundle.
    #[serde(with = "throng_motion::pod::one")]
    pub record: BlendRecord,
    /// The examples.
    #[serde(with = "throng_motion::pod")]
    pub examples: Vec<ExampleRecord>,
    /// The weight table.
    #[serde(with = "throng_motion::pod")]
    pub weights: Vec<f32>,
    /// Reference rows, one a phase.
    #[serde(with = "throng_motion::pod")]
    pub references: Vec<ReferenceRow>,
    /// Channel rows, one a phase and example.
    #[serde(with = "throng_motion::pod")]
    pub channels: Vec<ChannelRow>,
}

impl RawBlendSpace {
    /// The space as the runtime reads it.
    ///
    /// # Errors
    /// As [`BlendSpace::new`].
    pub fn open(&self, skeleton: &Skeleton) -> std::result::Result<BlendSpace, FormatError> {
        let blends = Blends {
            spaces: Table::from(vec![self.record]),
            examples: self.examples.clone().into(),
            weights: self.weights.clone().into(),
            references: self.references.clone().into(),
            channels: self.channels.clone().into(),
            names: vec![self.name.clone()],
            skeleton: skeleton.clone(),
        };
        BlendSpace::new(&blends, 0)
    }
}

/// All blend spaces of a build.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlendSpaces {
    /// The spaces, by name.
    pub spaces: Vec<RawBlendSpace>,
    /// Report of each space.
    pub report: Vec<BlendReport>,
    /// Names of spaces of found examples that could not be made, or would be poor, and the reason.
    pub not_made: Vec<(String, String)>,
    /// Warnings.
    pub warnings: Warnings,
}

/// Report of one blend space.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct BlendReport {
    /// Its name.
    pub name: String,
    /// Names of its axes.
    pub axes: Vec<String>,
    /// Its examples.
    pub examples: Vec<ExampleReport>,
    /// Number of found cycles that were dropped as near duplicates.
    pub left_out: usize,
    /// Clips of which nothing was taken, and the reason.
    pub refused: BTreeMap<String, String>,
    /// Its quality.
    pub quality: BlendQuality,
    /// Rows of its posture table.
    pub phases: usize,
    /// Knots along each axis of its weight table.
    pub knots: Vec<usize>,
    /// Largest allowed error of a weight.
    pub weight_tolerance: f64,
    /// Largest measured error of a weight.
    pub weight_table_max_error: f64,
    /// Its weight table (bytes).
    pub weight_table_bytes: u64,
    /// Its posture tables (bytes).
    pub posture_bytes: u64,
    /// Largest turn of a joint from its reference (rad).
    pub max_displacement_rad: f64,
}

impl BlendReport {
    /// Reports of the spaces of a bundle, which keeps neither seams nor what was left out.
    ///
    /// # Errors
    /// As [`BlendSpace::new`]; the spaces of an open bundle are sound.
    pub fn of_bundle(tables: &Bundle) -> std::result::Result<Vec<Self>, FormatError> {
        let of = |(number, meta): (usize, &BlendMeta)| {
            let space = BlendSpace::new(tables.blends(), number)?;
            let example = |(name, e): (&String, &ExampleRecord)| ExampleReport {
                name: name.clone(),
                parameters: e.parameters[..meta.axes.len()].iter().map(|v| f64::from(*v)).collect(),
                duration_s: e.duration_s.into(),
                speed_mps: e.velocity[1].into(),
                side_mps: e.velocity[0].into(),
                gyration_rad_per_s: e.gyration.into(),
                ..ExampleReport::default()
            };
            Ok(Self {
                name: meta.name.clone(),
                axes: meta.axes.clone(),
                examples: meta.examples.iter().zip(space.examples()).map(example).collect(),
                phases: space.num_phases(),
                quality: judge::judge(&space),
                ..Self::default()
            })
        };
        tables.meta().blends.iter().enumerate().map(of).collect()
    }

    /// Names of the clips of its examples.
    pub fn clips(&self) -> Vec<&str> {
        let clip = |e: &'_ ExampleReport| e.name.split(" [").next().map_or(0, str::len);
        let mut clips: Vec<&str> =
            self.examples.iter().map(|e| e.name[..clip(e)].trim_end_matches("~mirror")).collect();
        clips.sort_unstable();
        clips.dedup();
        clips
    }
}

/// One example of a blend space.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ExampleReport {
    /// Its name.
    pub name: String,
    /// Place in the parameter space, axis by axis.
    pub parameters: Vec<f64>,
    /// Time of its cycle (s).
    pub duration_s: f64,
    /// Speed ahead (m/s).
    pub speed_mps: f64,
    /// Speed to the left (m/s).
    pub side_mps: f64,
    /// Turning rate (rad/s).
    pub gyration_rad_per_s: f64,
    /// Mean turn of a joint over the seam, before it was closed (rad).
    pub closing_rad: f64,
    /// How far the hips were apart at the seam, before it was closed (m).
    pub closing_m: f64,
}

/// Widest seam of a found cycle: distance of the hips (m), and mean turn of a joint (deg). A named cycle beyond it
/// causes a warning.
pub const WIDEST_SEAM: (f64, f64) = (0.1, 6.0);

impl ExampleReport {
    /// Ratio of the seam to the widest allowed for found cycles.
    pub fn seam(&self) -> f64 {
        (self.closing_m / WIDEST_SEAM.0).max(self.closing_rad.to_degrees() / WIDEST_SEAM.1)
    }
}

/// Makes all blend spaces of a config.
///
/// - `clips`: annotated; mirrored copies among them are not used, as entries ask for mirrored examples of their own.
/// - returns spaces in the order of their names.
///
/// # Errors
/// [`BuildError::Key`] for a setting out of its limits, for named examples that are not there, have wrong keytimes or
/// coincide, for too few examples, and for a weight table that would be too large.
///
/// # Source
/// Kim, Kim and Shin (2003a), section 4.
pub fn fit(clips: &ClipSet, configs: &BTreeMap<String, BlendConfig>, progress: &dyn Progress) -> Result<BlendSpaces> {
    let num_spaces = spaces(configs)?.len();
    let mut out = BlendSpaces::default();
    progress.begin("examples", num_spaces as u64, "spaces");
    for (table, config) in configs {
        for (name, config) in config.spaces(table) {
            progress.check()?;
            if config.alike {
                alike_spaces(&name, &config, clips, &mut out).map_err(|e| table_error(e, table, &name))?;
            } else {
                let made = space(&name, &config, clips, &mut out.warnings);
                let (space, report) = made.map_err(|e| table_error(e, table, &name))?;
                out.spaces.push(space);
                out.report.push(report);
            }
            progress.advance(1);
        }
    }
    progress.end();
    Ok(out)
}

/// Rephrases a fault of a space for the whole config, as a table that makes several spaces does not name the one.
fn table_error(fault: BuildError, table: &str, space: &str) -> BuildError {
    let fault = match fault {
        BuildError::Key { key, why } if space != table => BuildError::key(key, format!("space `{space}`: {why}")),
        other => other,
    };
    fault.within_key(&format!("blend.{table}"))
}

/// Every space of some tables of a config, by name.
///
/// # Errors
/// [`BuildError::Key`] naming the first key out of its limits.
pub fn spaces(configs: &BTreeMap<String, BlendConfig>) -> Result<Vec<(String, BlendConfig)>> {
    let mut all: Vec<(String, BlendConfig)> = Vec::new();
    for (table, config) in configs {
        let key = format!("blend.{table}");
        for (name, space) in config.spaces(table) {
            if all.iter().any(|(n, _)| *n == name) {
                return Err(BuildError::key(key, format!("two spaces are called `{name}`. Correct the config.")));
            }
            space.check().map_err(|e| table_error(e, table, &name))?;
            all.push((name, space));
        }
    }
    Ok(all)
}

fn space(
    name: &str,
    cfg: &BlendConfig,
    clips: &ClipSet,
    warnings: &mut Warnings,
) -> Result<(RawBlendSpace, BlendReport)> {
    let sources = select::sources(clips, cfg);
    let mut without = Vec::new();
    let mut chosen = select::candidates(cfg, &sources, &mut without)?;
    let lacking = select::describe_without(name, &without);
    warnings.messages.extend(lacking.iter().cloned());
    let left_out = select::thin_out(&mut chosen, cfg.min_distance);
    assemble(name, cfg, &chosen, left_out, &clips.skeleton, &lacking, warnings)
}

/// Makes a space of each posture and manner, of found examples that look alike. Spaces that would be poor are left out.
///
/// # Errors
/// [`BuildError::Key`] if nobody walks or runs ahead steadily.
fn alike_spaces(name: &str, config: &BlendConfig, clips: &ClipSet, out: &mut BlendSpaces) -> Result<()> {
    let sources = select::sources(clips, config);
    let mut without = Vec::new();
    let all = select::candidates(config, &sources, &mut without)?;
    let mut refused: Refusals = without.concat().into_iter().collect();
    let sorted = alike::sort_by_class(all, &mut refused);
    if sorted.is_empty() {
        let some: Vec<String> = refused.iter().take(4).map(|(clip, why)| format!("`{clip}`: {why}")).collect();
        let message = format!("no steady walk or run ahead was found: {}", some.join("; "));
        return Err(space_error("", message, "Add clips of at least four steady steps, with root motion"));
    }
    for (class, of) in sorted {
        let words = class.words();
        let own = format!("{name}-{words}");
        let made_as = if out.spaces.is_empty() || words.is_empty() { name } else { own.as_str() };
        match alike_space(made_as, config, (&class, of), &sources, &clips.skeleton, refused.clone()) {
            Ok((space, report)) => {
                out.spaces.push(space);
                out.report.push(report);
            }
            Err(BuildError::Key { why, .. }) if words.is_empty() => out.not_made.push((name.to_owned(), why)),
            Err(BuildError::Key { why, .. }) => out.not_made.push((own, why)),
            Err(other) => return Err(other),
        }
    }
    Ok(())
}

/// Makes the space of one class, with a stand if it is as good with it.
fn alike_space<'a>(
    name: &str,
    config: &BlendConfig,
    (class, mut of): (&SpaceClass, Vec<ExampleCandidate<'a>>),
    sources: &'a [ExampleSource],
    skeleton: &Skeleton,
    mut refused: Refusals,
) -> Result<(RawBlendSpace, BlendReport)> {
    let usual = UsualCarriage::keep_usual(&mut of, skeleton, &mut refused);
    let mut config = config.clone();
    config.axes = alike::keep_wide_axes(&config.axes, &mut of);
    let stand = usual.and_then(|usual| usual.standing(sources, class, skeleton)).map(|(source, cycle)| {
        let (name, parameters) = (source.clip.name.clone(), vec![0.0; config.axes.len()]);
        ExampleCandidate { name, source, cycle, parameters, named: true }
    });
    let with = |stand: Option<ExampleCandidate<'a>>| {
        thinned_space(name, &config, stand.into_iter().chain(of.clone()).collect(), skeleton, &refused)
    };
    let is_good = |made: &Result<(_, BlendReport)>| made.as_ref().is_ok_and(|m| m.1.quality.word == BLEND_WORDS[0]);
    let [first, second] = [stand.clone(), None].map(with);
    Ok(if is_good(&first) || first.is_ok() && !is_good(&second) { first? } else { second? })
}

/// Makes a space of alike examples; while it is poor, the least usual one is left out.
fn thinned_space(
    name: &str,
    config: &BlendConfig,
    mut of: Vec<ExampleCandidate<'_>>,
    skeleton: &Skeleton,
    refused: &Refusals,
) -> Result<(RawBlendSpace, BlendReport)> {
    loop {
        let mut chosen = of.clone();
        let left_out = select::thin_out(&mut chosen, config.min_distance);
        let mut warnings = Warnings::default();
        let (space, report) = assemble(name, config, &chosen, left_out, skeleton, &[], &mut warnings)?;
        if report.quality.word != BLEND_WORDS[2] {
            let mut refused = refused.clone();
            refused.retain(|clip, _| !chosen.iter().any(|c| c.original() == clip));
            return Ok((space, BlendReport { refused, ..report }));
        }
        // Candidates are in the order of how usual they are.
        let oddest = of.iter().rposition(|c| !c.named && chosen.iter().any(|o| o.name == c.name));
        match oddest.filter(|_| chosen.len() > config.axes.len() + 2) {
            Some(oddest) => _ = of.remove(oddest),
            None => {
                let message = format!("it would be poor: {}", report.quality.reason);
                return Err(space_error(
                    "",
                    message,
                    "Add steady gaits of this kind at other speeds, turns of it, and a stand",
                ));
            }
        }
    }
}

/// Tables of some examples, with a report that judges them.
///
/// - `lacking`: messages about clips in which no example was found.
fn assemble(
    name: &str,
    config: &BlendConfig,
    chosen: &[ExampleCandidate<'_>],
    left_out: usize,
    skeleton: &Skeleton,
    lacking: &[String],
    warnings: &mut Warnings,
) -> Result<(RawBlendSpace, BlendReport)> {
    let points: Vec<Vec<f64>> = chosen.iter().map(|c| c.parameters.clone()).collect();
    let spacings: Vec<Option<f64>> = config.axes.iter().map(|a| a.spacing).collect();
    let basis = CardinalBasis::new(&points, &spacings, config.kernel_reach, config.min_distance)
        .map_err(|fault| cardinal_fault(name, config, chosen, &fault, lacking))?;
    let basis = if config.alike { basis.within_hull() } else { basis };
    let table =
        grid::tabulate(&basis, parameter_bounds(config, &points), config.weight_tolerance, config.max_weight_bytes)
            .map_err(|large| too_large(config, &large))?;
    check_weights(config, &points, &table)?;
    let cycles: Vec<&Cycle<'_>> = chosen.iter().map(|c| &c.cycle).collect();
    let postures = posture::tabulate(&cycles, skeleton, config.phases).map_err(|t| {
        let message = format!(
            "the examples hold their {} so differently that no reference orientation continues from phase \
             {} to the next",
            t.joint.name(),
            t.phase
        );
        space_error("", message, "Take examples that are more alike into one space, or more phases")
    })?;
    let (joint, worst, turn) = postures.largest;
    if turn > FAR_APART {
        warnings.push(format!(
            "blend.{name}: `{}` turns its {} {:.0} deg from the other examples' reference: blends may jump there.",
            chosen[worst].name,
            joint.name(),
            turn.to_degrees()
        ));
    }
    let mut report = report(name, config, chosen, left_out, &table, &postures);
    for e in report.examples.iter().zip(chosen).filter(|(e, c)| c.named && e.seam() > 1.0).map(|(e, _)| e) {
        warnings.push(format!(
            "blend.{name}: `{}` is {:.0} cm and {:.0} deg a joint apart at the seam of its cycle: it will sway there. Name other \
             `frames` of it.",
            e.name,
            100.0 * e.closing_m,
            e.closing_rad.to_degrees()
        ));
    }
    let space = RawBlendSpace {
        name: name.to_owned(),
        axes: config.axis_names(),
        example_names: chosen.iter().map(|c| c.name.clone()).collect(),
        record: blend_record(config, &table, chosen.len()),
        examples: chosen.iter().map(example).collect(),
        weights: table.weights.to_vec(),
        references: postures.references,
        channels: postures.channels,
    };
    let opened = space.open(skeleton).map_err(|e| BuildError::Format(format!("blend.{name}: {e}")))?;
    report.quality = judge::judge(&opened);
    Ok((space, report))
}

/// Parameter box: that of the config, otherwise the examples' extent.
fn parameter_bounds(config: &BlendConfig, points: &[Vec<f64>]) -> ParameterBounds {
    let along = |(k, a): (usize, &AxisConfig)| {
        let values = || points.iter().map(move |p| p[k]);
        let [low, high] =
            a.range.unwrap_or([values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]);
        // Rounded as in the bundle.
        (f64::from(low as f32), f64::from(high as f32))
    };
    let (low, high) = config.axes.iter().enumerate().map(along).unzip();
    ParameterBounds { low, high }
}

/// Checks that weights can be stored: far from all examples, hyperplanes rise without bound.
fn check_weights(config: &BlendConfig, points: &[Vec<f64>], table: &WeightTable) -> Result<()> {
    let largest = table.weights.iter().fold(0.0f32, |l, w| l.max(w.abs()));
    if largest < MAX_WEIGHT {
        return Ok(());
    }
    let along = |k: usize| {
        let values = || points.iter().map(move |p| p[k]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    // Distance of the box beyond the examples, in their extents.
    let beyond = |k: usize| {
        let (low, high) = along(k);
        (low - table.grid.low[k]).max(table.grid.high[k] - high) / (high - low)
    };
    let widest = (0..config.axes.len()).max_by(|&a, &b| beyond(a).total_cmp(&beyond(b))).unwrap_or(0);
    let (low, high) = along(widest);
    let message = format!(
        "[{}, {}] of axis `{}` is so far beyond the examples, {low:.3} to {high:.3}, that \
         weights reach {largest:.0}; expected below {MAX_WEIGHT}",
        table.grid.low[widest],
        table.grid.high[widest],
        config.axis_names()[widest]
    );
    Err(space_error(
        &format!("axes[{widest}].range"),
        message,
        "Narrow the `range` of this axis, or add examples nearer to its ends",
    ))
}

fn blend_record(config: &BlendConfig, table: &WeightTable, num_examples: usize) -> BlendRecord {
    let mut axes = [AxisRecord::default(); MAX_AXES];
    for (k, a) in config.axes.iter().enumerate() {
        axes[k] = AxisRecord {
            kind: a.kind.code(),
            num_knots: table.grid.knots[k] as u32,
            low: table.grid.low[k] as f32,
            high: table.grid.high[k] as f32,
        };
    }
    BlendRecord {
        first_example: 0,
        num_examples: num_examples as u32,
        num_axes: config.axes.len() as u32,
        num_phases: config.phases as u32,
        first_weight: 0,
        weight_stride: table.stride as u32,
        first_row: 0,
        first_channel_row: 0,
        max_weight_error: table.max_error as f32,
        extrapolate: u32::from(config.extrapolate == Extrapolation::Linear),
        axes,
    }
}

fn example(c: &ExampleCandidate<'_>) -> ExampleRecord {
    let twist = c.cycle.course.twist;
    let mut parameters = [0.0; MAX_AXES];
    parameters.iter_mut().zip(&c.parameters).for_each(|(out, p)| *out = *p as f32);
    let (first_frame, num_frames) = c.cycle.frames();
    let flag = |on: bool, bit: u32| if on { bit } else { 0 };
    ExampleRecord {
        parameters,
        duration_s: c.cycle.duration_s() as f32,
        velocity: [twist.velocity.x as f32, twist.velocity.y as f32],
        gyration: twist.gyration as f32,
        keytimes: if c.cycle.is_still() { [0.0; 3] } else { c.cycle.steps.keytimes().map(|k| k as f32) },
        flags: flag(c.cycle.is_still(), ExampleRecord::IS_STILL)
            | flag(c.source.clip.mirrored, ExampleRecord::IS_MIRRORED),
        clip: c.source.number as u32,
        first_frame: first_frame as u32,
        num_frames: num_frames as u32,
        reserved: 0,
    }
}

fn report(
    name: &str,
    config: &BlendConfig,
    chosen: &[ExampleCandidate<'_>],
    left_out: usize,
    table: &WeightTable,
    postures: &Postures,
) -> BlendReport {
    let example = |c: &ExampleCandidate<'_>| {
        let twist = c.cycle.course.twist;
        ExampleReport {
            name: c.name.clone(),
            parameters: c.parameters.clone(),
            duration_s: c.cycle.duration_s(),
            speed_mps: twist.velocity.y,
            side_mps: twist.velocity.x,
            gyration_rad_per_s: twist.gyration,
            closing_rad: c.cycle.closing,
            closing_m: c.cycle.closing_m,
        }
    };
    BlendReport {
        name: name.to_owned(),
        axes: config.axis_names(),
        examples: chosen.iter().map(example).collect(),
        left_out,
        refused: BTreeMap::new(),
        quality: BlendQuality::default(),
        phases: config.phases,
        knots: table.grid.knots.clone(),
        weight_tolerance: config.weight_tolerance,
        weight_table_max_error: table.max_error,
        weight_table_bytes: table.num_bytes(),
        posture_bytes: (size_of_val(&*postures.references) + size_of_val(&*postures.channels)) as u64,
        max_displacement_rad: postures.largest.2,
    }
}

/// A fault of a key of a space's table.
fn space_error(key: &str, message: String, help: &str) -> BuildError {
    BuildError::key(key, format!("{message}. {help}."))
}

/// Fault for missing weights, with the names of examples.
/// - `lacking`: messages about clips in which no example was found.
fn cardinal_fault(
    space: &str,
    config: &BlendConfig,
    chosen: &[ExampleCandidate<'_>],
    why: &CardinalFault,
    lacking: &[String],
) -> BuildError {
    let axes = config.axis_names();
    let values = |k: usize| {
        let all: Vec<_> = chosen.iter().take(8).map(|c| format!("`{}` {:.3}", c.name, c.parameters[k])).collect();
        let more = if chosen.len() > 8 { ", ..." } else { "" };
        format!("{}{more}", all.join(", "))
    };
    let names = || {
        let found: Vec<String> = chosen.iter().map(|c| format!("`{}`", c.name)).collect();
        let lacking = lacking.iter().map(|l| within_sentence(l, space));
        let parts = std::iter::once(found.join(", ")).chain(lacking.map(str::to_owned));
        parts
            .filter(|p| !p.is_empty())
            .fold(String::new(), |all, p| format!("{all}{}{p}", if all.is_empty() { ": " } else { "; " }))
    };
    let (key, what, help) = match why {
        CardinalFault::TooFew => (
            String::new(),
            format!("{} axes need {} examples at least, found {}{}", axes.len(), axes.len() + 1, chosen.len(), names()),
            "Add examples, or leave axes out".to_owned(),
        ),
        CardinalFault::NoExtent(k) => (
            format!("axes[{k}]"),
            format!("all examples have the same value on axis `{}`: {}", axes[*k], values(*k)),
            format!("Add an example with another value of `{}`, or leave the axis out", axes[*k]),
        ),
        CardinalFault::NoSpread(k) => (
            format!("axes[{k}]"),
            format!(
                "all examples lie in one hyperplane: their values on axis `{}` ({}) follow from those on `{}`",
                axes[*k],
                values(*k),
                axes[..*k].join("`, `")
            ),
            format!("Add an example that differs in `{}` alone, or leave the axis out", axes[*k]),
        ),
        CardinalFault::Coincident(a, b, distance) => (
            "min_distance".to_owned(),
            format!(
                "examples `{}` and `{}` lie at the same place: {distance:.4} apart, with each axis from 0 to 1, where \
                 min_distance is {}",
                chosen[*a].name, chosen[*b].name, config.min_distance
            ),
            "Leave one of them out, add an axis that tells them apart, or lower `min_distance`".to_owned(),
        ),
        CardinalFault::Overlap => (
            "kernel_reach".to_owned(),
            format!("the radial bases of the examples overlap too much with kernel_reach {}", config.kernel_reach),
            "Lower `kernel_reach`, or leave out examples that lie close together".to_owned(),
        ),
    };
    space_error(&key, what, &help)
}

/// A warning about a space, phrased as part of a sentence about it.
fn within_sentence<'a>(warning: &'a str, space: &str) -> &'a str {
    warning.trim_start_matches(&format!("blend.{space}: ")).trim_end_matches("; ...").trim_end_matches('.')
}

fn too_large(config: &BlendConfig, large: &grid::TableTooLarge) -> BuildError {
    let axis = |((name, knots), error): ((&String, &usize), &f64)| format!("{knots} along `{name}` (error {error:.4})");
    let axes: Vec<_> = config.axis_names().iter().zip(&large.knots).zip(&large.errors).map(axis).collect();
    let message = format!(
        "for a weight_tolerance of {}, the weight table needs at least {} knots and {} bytes; \
         max_weight_bytes is {}, and a table has at most {MAX_KNOTS} knots",
        config.weight_tolerance,
        axes.join(", "),
        large.bytes,
        config.max_weight_bytes
    );
    let help = "Raise `max_weight_bytes` or `weight_tolerance`, leave out examples that lie close together, or narrow the \
                `range` of an axis that is much wider than its examples";
    space_error("max_weight_bytes", message, help)
}

#[cfg(test)]
mod tests {
    use super::within_sentence;

    #[test]
    fn warnings_end_within_a_sentence_as_words_do() {
        assert_eq!(
            within_sentence("blend.a: no steady walk in 9 clips: `b`; ...", "a"),
            "no steady walk in 9 clips: `b`"
        );
        assert_eq!(within_sentence("blend.a: `b` stands.", "a"), "`b` stands");
    }
}
