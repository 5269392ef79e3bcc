//! A blend space ready to be asked: views on its tables, and what is worked out of them once.

use super::error::{BlendError, check_length};
use super::grid::WeightGrid;
use super::records::{AxisRecord, BlendRecord, ChannelRow, ExampleRecord, MAX_AXES, ReferenceRow, axis};
use super::warp::Timing;
use super::{Blends, slopes};
use crate::lanes::{LANES, Lanes, Work, dispatch};

/// One blend space of a bundle (000 section 4). Make it once and keep it as long as the tables.
///
/// A query goes in three steps, each of them a batch over slices: [`BlendSpace::weights`] takes parameters to the
/// weights of the examples, [`BlendSpace::advance`] moves generic time on by blended rates, and
/// [`BlendSpace::pose`] blends postures. [`super::walkers::Walkers`] does all of it for characters on trajectories.
#[derive(Clone, Debug)]
pub struct BlendSpace<'a> {
    pub(crate) record: &'a BlendRecord,
    pub(crate) examples: &'a [ExampleRecord],
    pub(crate) grid: WeightGrid<'a>,
    pub(crate) references: &'a [ReferenceRow],
    pub(crate) channels: &'a [ChannelRow],
    pub(crate) timing: Timing,
    /// What the linear part of each weight changes by along each axis; empty where the box is not left.
    /// [Size: num_axes * stride]
    slopes: Vec<f32>,
}

impl<'a> BlendSpace<'a> {
    /// Takes the views of one space.
    ///
    /// # Errors
    /// [`BlendError::Index`] for a space that does not exist, [`BlendError::Table`] where its rows do not lie within
    /// the tables or its numbers make no sense.
    pub fn new(blends: Blends<'a>, space: usize) -> Result<Self, BlendError> {
        let limit = blends.spaces.len();
        let record = blends.spaces.get(space).ok_or(BlendError::Index { what: "blend space", got: space, limit })?;
        let error = |what, limit| BlendError::Table { space, what, limit };
        let n = record.num_examples as usize;
        let examples = part(blends.examples, record.first_example, n);
        let examples = examples.filter(|e| !e.is_empty() && e.iter().all(is_sound));
        let examples = examples.ok_or(error("examples", blends.examples.len()))?;
        let grid = grid(record, blends.weights).ok_or(error("weight rows", blends.weights.len()))?;
        let phases = record.num_phases as usize;
        let references = part(blends.references, record.first_row, phases).filter(|_| phases >= 2);
        let references = references.ok_or(error("reference rows", blends.references.len()))?;
        let rows = phases.checked_mul(n).and_then(|rows| part(blends.channels, record.first_channel_row, rows));
        let channels = rows.ok_or(error("channel rows", blends.channels.len()))?;
        let timing = Timing::new(examples, channels, grid.stride()).ok_or(error("rates", channels.len()))?;
        let slopes = match record.extrapolate {
            0 => Vec::new(),
            _ => slopes::linear_part(examples, grid.axes(), grid.stride()),
        };
        Ok(Self { record, examples, grid, references, channels, timing, slopes })
    }

    /// The axes of the parameter box.
    pub fn axes(&self) -> &'a [AxisRecord] {
        self.grid.axes()
    }

    /// The examples.
    pub fn examples(&self) -> &'a [ExampleRecord] {
        self.examples
    }

    /// The space's record.
    pub fn record(&self) -> &'a BlendRecord {
        self.record
    }

    /// Numbers of a row of weights: those beyond the examples there are, are 0. A multiple of 8.
    pub fn stride(&self) -> usize {
        self.grid.stride()
    }

    /// Rows of the posture tables over a cycle of generic time.
    pub fn num_phases(&self) -> usize {
        self.references.len()
    }

    /// Number of the first axis of a kind of [`axis`].
    pub fn axis_of(&self, kind: u32) -> Option<usize> {
        self.axes().iter().position(|a| a.kind == kind)
    }

    /// Number of style axes.
    pub fn num_styles(&self) -> usize {
        self.axes().iter().filter(|a| a.kind == axis::STYLE).count()
    }

    /// The weights of the examples at each point of the parameter box (000 section 4.2.1), as [`WeightGrid`] reads
    /// them. Outside the box they are those of the nearest point within, and where the space says so, the linear part
    /// is continued from there. Allocates nothing.
    ///
    /// - `parameters`: axis by axis, of each query; what is beyond the axes there are is not looked at.
    /// - `weights`: output. [Size: parameters.len() * stride]
    ///
    /// # Errors
    /// [`BlendError::Length`] where the output has another size.
    pub fn weights(&self, parameters: &[[f32; MAX_AXES]], weights: &mut [f32]) -> Result<(), BlendError> {
        check_length("weights", weights.len(), parameters.len() * self.stride())?;
        dispatch(Weigh { space: self, parameters, weights });
        Ok(())
    }

    #[inline(always)]
    pub(crate) fn weigh<F: Lanes>(&self, parameters: &[[f32; MAX_AXES]], weights: &mut [f32]) {
        self.grid.read_all::<F>(parameters, weights);
        if !self.slopes.is_empty() {
            for (parameters, row) in parameters.iter().zip(weights.chunks_exact_mut(self.stride())) {
                self.extrapolate::<F>(parameters, row);
            }
        }
    }

    /// Continues the linear part of the weights from the box to a point outside.
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

struct Weigh<'a, 's> {
    space: &'a BlendSpace<'s>,
    parameters: &'a [[f32; MAX_AXES]],
    weights: &'a mut [f32],
}

impl Work for Weigh<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<F: Lanes>(self) {
        self.space.weigh::<F>(self.parameters, self.weights);
    }
}

fn is_sound(e: &ExampleRecord) -> bool {
    let numbers = e.parameters.iter().chain(&e.velocity).chain([&e.gyration]);
    e.duration_s.is_finite() && e.duration_s > 0.0 && numbers.copied().all(f32::is_finite)
}

fn part<T>(all: &[T], first: u32, len: usize) -> Option<&[T]> {
    let first = first as usize;
    all.get(first..first.checked_add(len)?)
}

fn grid<'a>(record: &'a BlendRecord, weights: &'a [f32]) -> Option<WeightGrid<'a>> {
    let axes = record.axes.get(..record.num_axes as usize)?;
    let stride = record.weight_stride as usize;
    let rows = axes.iter().try_fold(1usize, |n, a| n.checked_mul(a.num_knots as usize))?;
    let table = part(weights, record.first_weight, rows.checked_mul(stride)?)?;
    WeightGrid::new(axes, stride, table).filter(|_| stride >= record.num_examples as usize)
}
