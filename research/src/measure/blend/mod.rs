//! Cost of blending, and its quality beside cross-fading the same examples.

mod cross_fade;
mod jumps;

use glam::Vec2;
use jumps::{BlendMethod, measure_jumps};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::Serialize;
use std::hint::black_box;
use std::path::Path;
use throng_bake::config::BuildConfig;
use throng_bake::examples::BlendConfig;
use throng_bake::examples::cardinal::CardinalBasis;
use throng_core::base::limits::MEASURING_S;
use throng_core::blend::{BlendSpace, BlendedPosture, MAX_AXES, axis};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{Bundle, CharacterGroup, Inline, NUM_JOINTS, Planar};
use throng_lab::measure::timing::{fail, median_ns};
use throng_motion::error::BuildError;
use throng_simulation::scene::BodiesConfig;
use throng_simulation::wander::random_skeletons;

/// Characters of a batch.
const CHARACTERS: usize = 1024;
/// Time between steps (s).
const STEP_S: f32 = 1.0 / 60.0;

/// Figures of one blend space, on one thread.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BlendFigures {
    /// Its name.
    pub space: String,
    /// Number of examples.
    pub examples: usize,
    /// Number of axes.
    pub axes: usize,
    /// Joints of a posture.
    pub joints: usize,
    /// Postures a second: weights, generic time, blending.
    pub postures_per_second: f64,
    /// Postures a second with retargeting to bodies of other sizes, up to joint matrices.
    pub retargeted_per_second: f64,
    /// Copying a posture as blending writes it.
    pub memcpy_ns_per_posture: f64,
    /// Time of a posture over that of copying it.
    pub posture_over_memcpy: f64,
    /// A query of the weight table, in a batch.
    pub weights_ns_per_query: f64,
    /// Exact weights of the same examples by the cardinal basis that the table was made from, in a batch.
    pub weights_direct_ns_per_query: f64,
    /// The exact weights over the table's.
    pub weights_direct_over_table: f64,
    /// Largest error of a tabulated weight, as the build measured it.
    pub weight_table_max_error: f64,
    /// Size of the weight table.
    pub weight_table_bytes: u64,
    /// 95th percentile of the slip of planted feet while parameters jump: how fast the slower of heel and ball moves over
    /// the ground (m/s).
    pub foot_slip_p95_mps: f64,
    /// 95th percentile of the slip of planted feet where the nearest examples are cross-faded without time-warping (m/s).
    pub crossfade_foot_slip_p95_mps: f64,
    /// Fastest change of a knee's angle while parameters jump (rad/s).
    pub knee_rate_max_radps: f64,
    /// Fastest change of a knee's angle where examples are cross-faded (rad/s).
    pub crossfade_knee_rate_max_radps: f64,
    /// Largest acceleration of a joint within half a second of a jump (m/s^2).
    pub joint_acceleration_max_mps2: f64,
    /// Largest acceleration of a joint after a jump where examples are cross-faded (m/s^2).
    pub crossfade_joint_acceleration_max_mps2: f64,
}

/// Measures all blend spaces of a bundle.
///
/// - `seconds`: time given to each figure.
///
/// # Errors
/// [`BuildError::Stage`] where there is no blend space, or one is broken.
pub fn blend(tables: &Bundle, seconds: f64) -> Result<Vec<BlendFigures>, BuildError> {
    let blends = tables.blends();
    if blends.spaces.is_empty() {
        return Err(fail("the bundle has no blend space"));
    }
    MEASURING_S.check("seconds", None, seconds).map_err(|e| fail(e.to_string()))?;
    (0..blends.spaces.len()).map(|number| measure(tables, number, seconds)).collect()
}

fn measure(tables: &Bundle, number: usize, seconds: f64) -> Result<BlendFigures, BuildError> {
    let space = BlendSpace::new(tables.blends(), number).map_err(|e| fail(e.to_string()))?;
    let record = space.record();
    let mut out = BlendFigures {
        space: tables.meta().blends[number].name.clone(),
        examples: space.examples().len(),
        axes: space.axes().len(),
        joints: NUM_JOINTS,
        weight_table_max_error: f64::from(record.max_weight_error),
        weight_table_bytes: 4 * table_len(&space),
        ..BlendFigures::default()
    };
    let parameters = random_parameters(&space);
    measure_weights(&space, &config_of(tables, &out.space)?, &parameters, seconds, &mut out)?;
    measure_postures(&space, &parameters, seconds, &mut out)?;
    measure_retargeted(tables, &space, &parameters, seconds, &mut out)?;
    let ours = measure_jumps(tables, &space, BlendMethod::Blended)?;
    let faded = measure_jumps(tables, &space, BlendMethod::CrossFaded)?;
    (out.foot_slip_p95_mps, out.crossfade_foot_slip_p95_mps) = (ours.slip_p95_mps, faded.slip_p95_mps);
    (out.knee_rate_max_radps, out.crossfade_knee_rate_max_radps) = (ours.knee_rate, faded.knee_rate);
    (out.joint_acceleration_max_mps2, out.crossfade_joint_acceleration_max_mps2) =
        (ours.acceleration, faded.acceleration);
    Ok(out)
}

fn table_len(space: &BlendSpace) -> u64 {
    space.axes().iter().map(|a| u64::from(a.num_knots)).product::<u64>() * space.stride() as u64
}

/// Random points of the parameter box.
fn random_parameters(space: &BlendSpace) -> Vec<[f32; MAX_AXES]> {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let mut draw = || {
        let mut p = [0.0; MAX_AXES];
        for (p, a) in p.iter_mut().zip(space.axes()) {
            *p = rng.random_range(a.low..a.high);
        }
        p
    };
    (0..CHARACTERS).map(|_| draw()).collect()
}

/// Settings that a space was built with, from the config in the bundle.
fn config_of(tables: &Bundle, name: &str) -> Result<BlendConfig, BuildError> {
    let config = BuildConfig::parse(&tables.meta().config, Path::new("the config in the bundle"))?;
    let all = throng_bake::examples::spaces(&config.blend)?;
    let of_space = all.into_iter().find(|(space, _)| space == name);
    of_space
        .map(|(_, config)| config)
        .ok_or_else(|| fail(format!("the config in the bundle has no blend space `{name}`")))
}

fn measure_weights(
    space: &BlendSpace,
    config: &BlendConfig,
    parameters: &[[f32; MAX_AXES]],
    seconds: f64,
    out: &mut BlendFigures,
) -> Result<(), BuildError> {
    let n = parameters.len() as f64;
    let mut table = vec![0.0; parameters.len() * space.stride()];
    space.weights(parameters, &mut table).map_err(|e| fail(e.to_string()))?;
    out.weights_ns_per_query = median_ns(seconds, || {
        black_box(space.weights(parameters, black_box(&mut table)).is_ok());
    }) / n;

    let d = space.axes().len();
    let place = |p: &[f32; MAX_AXES]| -> Vec<f64> { p[..d].iter().map(|&v| f64::from(v)).collect() };
    let points: Vec<Vec<f64>> = space.examples().iter().map(|e| place(&e.parameters)).collect();
    let spacings: Vec<Option<f64>> = config.axes.iter().map(|a| a.spacing).collect();
    let basis = CardinalBasis::new(&points, &spacings, config.kernel_reach, 1e-6)
        .map_err(|e| fail(format!("blend space {}: its examples have no cardinal basis: {e:?}", out.space)))?;
    let queries: Vec<Vec<f64>> = parameters.iter().map(place).collect();
    let mut row = vec![0.0; points.len()];
    out.weights_direct_ns_per_query = median_ns(seconds, || {
        throng_core::simd::vectorize(|| queries.iter().for_each(|q| basis.weights(q, black_box(&mut row))));
    }) / n;
    out.weights_direct_over_table = out.weights_direct_ns_per_query / out.weights_ns_per_query;
    Ok(())
}

fn measure_postures(
    space: &BlendSpace,
    parameters: &[[f32; MAX_AXES]],
    seconds: f64,
    out: &mut BlendFigures,
) -> Result<(), BuildError> {
    let n = parameters.len();
    let mut weights = vec![0.0; n * space.stride()];
    let mut phases: Vec<f32> = (0..n).map(|c| (c as f32 * 0.381_966).fract()).collect();
    let (ticks, mut postures) = (vec![STEP_S; n], vec![BlendedPosture::default(); n]);
    let mut step = || -> Result<(), throng_core::Error> {
        space.weights(parameters, &mut weights)?;
        space.advance(&weights, &ticks, &mut phases)?;
        space.blend_postures(&weights, &phases, black_box(&mut postures))
    };
    step().map_err(|e| fail(e.to_string()))?;
    let ns = median_ns(seconds, || {
        black_box(step().is_ok());
    }) / n as f64;
    let from = postures.clone();
    out.memcpy_ns_per_posture =
        median_ns(seconds, || black_box(&mut postures).copy_from_slice(black_box(&from))) / n as f64;
    out.postures_per_second = 1e9 / ns;
    out.posture_over_memcpy = ns / out.memcpy_ns_per_posture;
    Ok(())
}

fn measure_retargeted(
    tables: &Bundle,
    space: &BlendSpace,
    parameters: &[[f32; MAX_AXES]],
    seconds: f64,
    out: &mut BlendFigures,
) -> Result<(), BuildError> {
    let n = parameters.len();
    let bodies = random_skeletons(&BodiesConfig::default(), tables.skeleton(), 1);
    let start = |c: usize| WalkerStart {
        body: c % bodies.len(),
        root: Planar::new((c % 32) as f32 * 3.0, (c / 32) as f32 * 3.0, 0.0),
        phase: (c as f32 * 0.381_966).fract(),
    };
    let starts: Vec<WalkerStart> = (0..n).map(start).collect();
    let mut walkers =
        Walkers::with_capacity(space.clone(), &bodies, WalkersConfig::default(), n).map_err(|e| fail(e.to_string()))?;
    let ids = starts.iter().map(|s| walkers.spawn(*s)).collect::<Result<Vec<_>, _>>();
    let ids = ids.map_err(|e| fail(e.to_string()))?;
    let mut controls: Vec<Control> = (0..n).map(|c| start_control(space, &parameters[c], starts[c].root)).collect();
    let mut step = || {
        for ((id, control), p) in ids.iter().zip(&mut controls).zip(parameters) {
            advance_control(space, control, p, STEP_S);
            walkers.order(*id, *control)?;
        }
        walkers.step(STEP_S, &Inline)
    };
    step().map_err(|e| fail(e.to_string()))?;
    let ns = median_ns(seconds, || {
        black_box(step().is_ok());
    }) / n as f64;
    out.retargeted_per_second = 1e9 / ns;
    Ok(())
}

/// Control at the start that gives a walker these parameters.
fn start_control(space: &BlendSpace, parameters: &[f32; MAX_AXES], at: Planar) -> Control {
    let mut out = Control { position: Some(Vec2::new(at.x, at.z)), heading: Some(at.heading), ..Control::default() };
    advance_control(space, &mut out, parameters, 0.0);
    out
}

/// Advances a control along its path.
fn advance_control(space: &BlendSpace, control: &mut Control, parameters: &[f32; MAX_AXES], dt_s: f32) {
    let value = |kind| space.axis_of(kind).map_or(0.0, |a| parameters[a]);
    let (ahead, left, turning) = (value(axis::SPEED), value(axis::SIDE), value(axis::GYRATION));
    let heading = control.heading.unwrap_or(0.0) + turning * dt_s;
    let (sin, cos) = heading.sin_cos();
    control.velocity = Vec2::new(sin, cos) * ahead + Vec2::new(cos, -sin) * left;
    control.position = control.position.map(|position| position + control.velocity * dt_s);
    (control.heading, control.turning_rate) = (Some(heading), Some(turning));
    let styles = (0..space.axes().len()).filter(|&a| space.axes()[a].kind == axis::STYLE);
    for (style, a) in control.style.iter_mut().zip(styles) {
        *style = parameters[a];
    }
}
