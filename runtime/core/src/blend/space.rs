//! A blend space ready to be asked: views on its tables, and what is worked out of them once.

use super::records::{AxisRecord, BlendRecord, ChannelRow, ExampleRecord, MAX_AXES, ReferenceRow};
use super::{ActivitySet, Blends, grid::WeightGrid, rows::ExampleRows, slopes, warp::PhaseTiming};
use crate::format::{ClipRecord, FormatError, Table};
use crate::skeleton::Skeleton;
use std::sync::OnceLock;
use throng_base::error::{check_length, ensure};
use throng_base::simd::{LANES, LaneWork, Lanes, dispatch};
use throng_base::{Hash128, Result};

/// Weights beyond the box grow more slowly along every axis.
const STEEPEST: f32 = 1e4;

/// One blend space of a bundle (Kim, Kim and Shin 2003a, section 4). Owned: it keeps the bundle's file open.
///
/// A query has three steps, each a batch over slices: [`BlendSpace::weights`] maps parameters to the weights of the
/// examples, [`BlendSpace::advance`] moves generic time on by blended rates, and [`BlendSpace::blend_postures`] blends postures.
/// [`crate::walkers::Walkers`] does all of it for characters on trajectories.
///
/// ```no_run
/// use throng_core::Bundle;
/// use throng_core::blend::BlendSpace;
///
/// let bundle = Bundle::open("walkers.throng")?;
/// let space = BlendSpace::new(bundle.blends(), 0)?;
/// println!("{}: {} examples along {} axes", space.name(), space.examples().len(), space.axes().len());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct BlendSpace {
    pub(crate) record: BlendRecord,
    pub(crate) examples: Table<ExampleRecord>,
    pub(crate) grid: WeightGrid,
    pub(crate) references: Table<ReferenceRow>,
    pub(crate) channels: Table<ChannelRow>,
    pub(crate) timing: PhaseTiming,
    /// Gradient of the linear part of each weight; empty if points outside the box are clamped (num_axes * stride).
    slopes: Vec<f32>,
    name: String,
    skeleton: Skeleton,
    hash: OnceLock<u128>,
    activities: ActivitySet,
    /// Rows of the examples in the bundle, where it is known.
    pub(super) rows: Option<ExampleRows>,
}

impl BlendSpace {
    /// Takes the rows of one space.
    ///
    /// # Errors
    /// [`FormatError::Layout`] for a space that does not exist, or whose rows are not within the tables or malformed.
    /// The spaces of an open bundle are sound.
    pub fn new(blends: &Blends, space: usize) -> Result<Self, FormatError> {
        let unknown = || format!("blend space {space} does not exist, there are {}", blends.spaces.len());
        let record = *blends.spaces.get(space).ok_or_else(|| FormatError::layout(unknown()))?;
        let error = |what: &str, limit: usize| {
            let fault = format!("its {what} are malformed or not within the table of {limit}");
            FormatError::layout(format!("blend space {space}: {fault}"))
        };
        let n = record.num_examples as usize;
        let examples = part(&blends.examples, record.first_example, n);
        let examples = examples.filter(|e| !e.is_empty() && e.iter().all(is_sound));
        let examples = examples.ok_or_else(|| error("examples", blends.examples.len()))?;
        let grid = grid(&record, &blends.weights).ok_or_else(|| error("weight rows", blends.weights.len()))?;
        let phases = record.num_phases as usize;
        let references = part(&blends.references, record.first_row, phases).filter(|_| phases >= 2);
        let references = references.ok_or_else(|| error("reference rows", blends.references.len()))?;
        let rows = phases.checked_mul(n).and_then(|rows| part(&blends.channels, record.first_channel_row, rows));
        let channels = rows.ok_or_else(|| error("channel rows", blends.channels.len()))?;
        let timing =
            PhaseTiming::new(&examples, &channels, grid.stride()).ok_or_else(|| error("rates", channels.len()))?;
        let slopes = match record.extrapolate {
            0 => Vec::new(),
            _ => slopes::linear_part(&examples, grid.axes(), grid.stride()),
        };
        let fault = "its examples are so near to each other that weights beyond the box have no bounds";
        let bounded = slopes.iter().all(|s| s.abs() < STEEPEST);
        ensure(bounded, || FormatError::layout(format!("blend space {space}: {fault}")))?;
        Ok(Self {
            record,
            examples,
            grid,
            references,
            channels,
            timing,
            slopes,
            name: blends.names.get(space).cloned().unwrap_or_default(),
            skeleton: blends.skeleton.clone(),
            hash: OnceLock::new(),
            activities: ActivitySet::default(),
            rows: None,
        })
    }

    /// Adds activities that bodies may perform while they stand.
    pub fn with_activities(self, activities: ActivitySet) -> Self {
        Self { activities, ..self }
    }

    /// Adds the clips of the bundle, by whose rows the examples can be shown.
    pub(crate) fn with_clips(self, clips: &[ClipRecord], rate_hz: f32) -> Self {
        let rows = ExampleRows::new(&self.examples, clips, rate_hz);
        Self { rows, ..self }
    }

    /// Activities that bodies may perform while they stand.
    pub fn activities(&self) -> &ActivitySet {
        &self.activities
    }

    /// Name of the space in the bundle.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The skeleton that the examples move.
    pub fn skeleton(&self) -> &Skeleton {
        &self.skeleton
    }

    /// A hash of its tables and skeleton. All of them are read when it is asked for the first time.
    pub fn hash(&self) -> u128 {
        *self.hash.get_or_init(|| {
            let mut hash = Hash128::default();
            hash.add_bytes(bytemuck::bytes_of(&self.record));
            hash.add_bytes(bytemuck::cast_slice(&self.examples));
            hash.add_bytes(bytemuck::cast_slice(self.grid.axes()));
            hash.add_bytes(bytemuck::cast_slice(&self.grid.table));
            hash.add_bytes(bytemuck::cast_slice(&self.references));
            hash.add_bytes(bytemuck::cast_slice(&self.channels));
            hash.add_bytes(format!("{:?}", self.skeleton).as_bytes());
            hash.finish()
        })
    }

    /// The axes of the parameter box.
    pub fn axes(&self) -> &[AxisRecord] {
        self.grid.axes()
    }

    /// The examples.
    pub fn examples(&self) -> &[ExampleRecord] {
        &self.examples
    }

    /// The space's record.
    pub fn record(&self) -> &BlendRecord {
        &self.record
    }

    /// Length of a row of weights, a multiple of 8; padding beyond the last example is 0.
    pub fn stride(&self) -> usize {
        self.grid.stride()
    }

    /// Rows of the posture tables over a cycle of generic time.
    pub fn num_phases(&self) -> usize {
        self.references.len()
    }

    /// Number of the first axis of a kind of [`crate::blend::axis`].
    pub fn axis_of(&self, kind: u32) -> Option<usize> {
        self.axes().iter().position(|a| a.kind == kind)
    }

    /// The weights of the examples at each point of the parameter box (Kim, Kim and Shin 2003a, section 4.2.1), as
    /// [`WeightGrid`] reads them. Points outside the box are clamped to it; if the space says so, the linear part of the
    /// weights is extrapolated from there. Allocates nothing.
    ///
    /// - `parameters`: axis by axis, of each query; entries beyond the last axis are ignored.
    /// - `weights`: output (parameters.len() * stride).
    ///
    /// # Errors
    /// [`Error::Length`](throng_base::Error::Length) if the output has another size.
    pub fn weights(&self, parameters: &[[f32; MAX_AXES]], weights: &mut [f32]) -> Result<()> {
        check_length("weights", weights.len(), parameters.len() * self.stride())?;
        dispatch(WeighJob { space: self, parameters, weights });
        Ok(())
    }

    #[inline(always)]
    pub(crate) fn weigh_batch<F: Lanes>(&self, parameters: &[[f32; MAX_AXES]], weights: &mut [f32]) {
        self.grid.read_all::<F>(parameters, weights);
        if !self.slopes.is_empty() {
            for (parameters, row) in parameters.iter().zip(weights.chunks_exact_mut(self.stride())) {
                self.extrapolate::<F>(parameters, row);
            }
        }
    }

    /// Extrapolates the linear part of the weights from the box to a point outside.
    #[inline(always)]
    fn extrapolate<F: Lanes>(&self, parameters: &[f32; MAX_AXES], row: &mut [f32]) {
        let within = self.grid.clamp(parameters);
        for (a, slopes) in self.slopes.chunks_exact(self.stride()).enumerate() {
            let beyond = parameters[a] - within[a];
            if beyond != 0.0 && beyond.is_finite() {
                let beyond = F::splat(beyond);
                for (w, s) in row.as_chunks_mut::<LANES>().0.iter_mut().zip(slopes.as_chunks::<LANES>().0) {
                    (F::load(w) + F::load(s) * beyond).store(w);
                }
            }
        }
    }
}

struct WeighJob<'a> {
    space: &'a BlendSpace,
    parameters: &'a [[f32; MAX_AXES]],
    weights: &'a mut [f32],
}

impl LaneWork for WeighJob<'_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        self.space.weigh_batch::<F>(self.parameters, self.weights);
    }
}

fn is_sound(e: &ExampleRecord) -> bool {
    let numbers = e.parameters.iter().chain(&e.velocity).chain([&e.gyration]);
    e.duration_s.is_finite() && e.duration_s > 0.0 && numbers.copied().all(f32::is_finite)
}

fn part<T>(all: &Table<T>, first: u32, len: usize) -> Option<Table<T>> {
    let first = first as usize;
    all.part(first..first.checked_add(len)?)
}

fn grid(record: &BlendRecord, weights: &Table<f32>) -> Option<WeightGrid> {
    let axes = record.axes.get(..record.num_axes as usize)?;
    let stride = record.weight_stride as usize;
    let rows = axes.iter().try_fold(1usize, |n, a| n.checked_mul(a.num_knots as usize))?;
    let table = part(weights, record.first_weight, rows.checked_mul(stride)?)?;
    WeightGrid::new(axes, stride, table).filter(|_| stride >= record.num_examples as usize)
}
