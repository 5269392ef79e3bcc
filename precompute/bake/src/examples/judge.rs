//! Quality of a blend space: seams, feet, limits of joints and likeness to the examples, over a grid of its parameters.

use glam::{Quat, Vec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use throng_base::maths::quantile;
use throng_core::blend::{BlendSpace, BlendedPosture, ExampleRecord, MAX_AXES, axis, channel};
use throng_core::{Joint, NUM_JOINTS};
use throng_motion::clip::joint_transforms;
use throng_planner::limits::{BodyLimits, JointLimits};

/// Places along each axis at which postures are measured, its ends among them.
const PLACES: usize = 5;
/// Phases of a cycle that are measured.
const PHASES: usize = 24;
/// Share of contact from which on a foot bears the body.
const PLANTED: f32 = 0.9;
/// Part of an axis by which weights may miss a place that still counts as reached, and lowest weight that no extrapolation has.
const REACHED: f32 = 0.05;
const EXTRAPOLATED: f32 = -0.2;
/// Begin of the reason of spaces that lack other speeds, which are good otherwise.
pub const ONE_SPEED: &str = "its speeds are";
/// Least range of speeds in which people go slower and faster (m/s).
const LEAST_SPEEDS_MPS: f64 = 0.15;
/// Turns below which a joint's range says nothing (rad).
const LEAST_RANGE: f32 = 0.35;

/// Words of a verdict on a blend space, from the best.
pub const BLEND_WORDS: [&str; 3] = ["good", "usable", "poor"];

/// Quality of a blend space, over a grid of its parameters and phases.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BlendQuality {
    /// `good`, `usable` or `poor`.
    pub word: String,
    /// Reason of the word; empty if it is good.
    pub reason: String,
    /// Share of the grid that lies between the examples; elsewhere a space extrapolates, or takes the nearest blend.
    pub reached: f64,
    /// Largest turn of a joint beyond its limits, and beyond those of every example (deg).
    pub beyond_limits_deg: f64,
    /// Largest range of a joint over that of the examples.
    pub range_ratio: f64,
    /// Speed of planted soles before feet are locked, between the examples, 95th percentile (m/s).
    pub slip_p95_mps: f64,
    /// The same of the examples alone (m/s).
    pub example_slip_p95_mps: f64,
    /// Largest mean turn of a joint between a blend and its nearest example (deg).
    pub unlike_deg: f64,
    /// Largest change of the mean pose of a joint between the last and the first frame of a cycle (deg).
    pub seam_deg: f64,
}

/// Postures of one place in the parameter space over a cycle.
struct BlendCycle {
    postures: Vec<BlendedPosture>,
    /// Velocity to the left and ahead, and turning rate, of the body (m/s, rad/s).
    motion: [f32; 3],
    reached: bool,
}

/// Judges a blend space.
pub fn judge(space: &BlendSpace) -> BlendQuality {
    let examples: Vec<BlendCycle> = (0..space.examples().len()).map(|e| example_cycle(space, e)).collect();
    let blends: Vec<BlendCycle> = grid(space.axes().len()).map(|at| blend_cycle(space, &at)).collect();
    let limits = BodyLimits::built_in(space.skeleton());
    let slips = |of: &[BlendCycle]| {
        quantile(of.iter().filter(|c| c.reached).flat_map(|c| slip(space, c)), [95, 100]).unwrap_or_default()
    };
    let (beyond, joint) = beyond_limits(&limits, &examples, &blends);
    let (ratio, widest) = range_ratio(&examples, &blends);
    let unlike = blends.iter().map(|b| examples.iter().map(|e| unlike(b, e)).fold(f64::INFINITY, f64::min));
    let reached = blends.iter().filter(|b| b.reached).count() as f64 / blends.len().max(1) as f64;
    let mut quality = BlendQuality {
        reached,
        beyond_limits_deg: beyond.to_degrees(),
        range_ratio: ratio,
        slip_p95_mps: slips(&blends),
        example_slip_p95_mps: slips(&examples),
        unlike_deg: unlike.fold(0.0, f64::max),
        seam_deg: blends.iter().map(seam).fold(0.0, f64::max),
        ..BlendQuality::default()
    };
    let (slip, own) = (quality.slip_p95_mps, quality.example_slip_p95_mps);
    let speeds = space.axis_of(axis::SPEED).map(|k| space.axes()[k]).map_or([0.0, f32::INFINITY], |a| [a.low, a.high]);
    let [slow, fast] = speeds.map(f64::from);
    let measures = [
        (
            quality.beyond_limits_deg,
            [5.0, 15.0],
            format!("the {} turns {:.0} deg beyond its limits", joint.name(), quality.beyond_limits_deg),
        ),
        (ratio, [1.3, 2.0], format!("the {} moves over {ratio:.1} times its range in the examples", widest.name())),
        (
            slip / own.max(0.1),
            [2.0, 4.0],
            format!("planted soles slip {:.0} mm/s, {:.0} in the examples", 1e3 * slip, 1e3 * own),
        ),
        (
            quality.unlike_deg,
            [14.0, 22.0],
            format!("blends are {:.0} deg a joint from the nearest example", quality.unlike_deg),
        ),
        (
            quality.seam_deg,
            [4.0, 8.0],
            format!("poses jump {:.0} deg a joint where the cycle begins again", quality.seam_deg),
        ),
        (
            LEAST_SPEEDS_MPS - (fast - slow),
            [0.0, LEAST_SPEEDS_MPS],
            format!(
                "{ONE_SPEED} {slow:.2} to {fast:.2} m/s: add such a gait that is {LEAST_SPEEDS_MPS} m/s slower or faster"
            ),
        ),
        (slip, [0.3, f64::INFINITY], format!("planted soles slip {:.0} mm/s", 1e3 * slip)),
    ];
    let rank = |(value, limits, _): &(f64, [f64; 2], String)| limits.iter().filter(|l| value > *l).count();
    let worst = measures.iter().rev().max_by_key(|m| rank(m)).map_or((0, ""), |m| (rank(m), m.2.as_str()));
    quality.word = BLEND_WORDS[worst.0].to_owned();
    quality.reason = if worst.0 == 0 { String::new() } else { worst.1.to_owned() };
    quality
}

/// Places of a grid over the unit box.
fn grid(num_axes: usize) -> impl Iterator<Item = [f32; MAX_AXES]> {
    // Fewer places along each of many axes.
    let places = if num_axes > 3 { 2 } else { PLACES };
    (0..places.pow(num_axes as u32)).map(move |mut n| {
        let mut at = [0.0; MAX_AXES];
        for v in &mut at[..num_axes] {
            (*v, n) = ((n % places) as f32 / (places - 1) as f32, n / places);
        }
        at
    })
}

/// Parameters of a place of the unit box.
pub fn parameters_at(space: &BlendSpace, at: &[f32; MAX_AXES]) -> [f32; MAX_AXES] {
    let mut out = [0.0; MAX_AXES];
    for ((out, axis), at) in out.iter_mut().zip(space.axes()).zip(at) {
        *out = axis.low + at * (axis.high - axis.low);
    }
    out
}

/// Postures over a cycle, evenly in generic time.
///
/// - `weights`: of the examples (stride).
pub fn postures_over_cycle(space: &BlendSpace, weights: &[f32], num: usize) -> Vec<BlendedPosture> {
    let phases: Vec<f32> = (0..num).map(|p| p as f32 / num as f32).collect();
    let mut postures = vec![BlendedPosture::default(); num];
    // The lengths fit.
    _ = space.blend_postures(&weights.repeat(num), &phases, &mut postures);
    postures
}

fn example_cycle(space: &BlendSpace, example: usize) -> BlendCycle {
    let mut weights = vec![0.0; space.stride()];
    weights[example] = 1.0;
    let e: &ExampleRecord = &space.examples()[example];
    let motion = [e.velocity[0], e.velocity[1], e.gyration];
    BlendCycle { postures: postures_over_cycle(space, &weights, PHASES), motion, reached: true }
}

fn blend_cycle(space: &BlendSpace, at: &[f32; MAX_AXES]) -> BlendCycle {
    let parameters = parameters_at(space, at);
    let mut weights = vec![0.0; space.stride()];
    _ = space.weights(&[parameters], &mut weights);
    let blended = |k: usize| space.examples().iter().zip(&weights).map(|(e, w)| w * e.parameters[k]).sum::<f32>();
    let misses = |(k, a): (usize, &throng_core::blend::AxisRecord)| {
        (blended(k) - parameters[k]).abs() > REACHED * (a.high - a.low)
    };
    let reached = !space.axes().iter().enumerate().any(misses) && !weights.iter().any(|w| *w < EXTRAPOLATED);
    let postures = postures_over_cycle(space, &weights, PHASES);
    let first = &postures[0];
    let mut motion = [channel::VELOCITY, channel::VELOCITY + 1, channel::GYRATION].map(|c| first.channel(c));
    for (kind, v) in [axis::SIDE, axis::SPEED, axis::GYRATION].into_iter().zip(&mut motion).filter(|_| reached) {
        *v = space.axis_of(kind).map_or(*v, |k| parameters[k]);
    }
    BlendCycle { postures, motion, reached }
}

/// Speeds of planted soles over the ground; of heel and ball, that of the slower one (m/s).
fn slip(space: &BlendSpace, cycle: &BlendCycle) -> Vec<f64> {
    let [left, ahead, gyration] = cycle.motion;
    let n = cycle.postures.len();
    let quickest_s = space.examples().iter().map(|e| 0.5 * e.duration_s).fold(f32::INFINITY, f32::min);
    let feet = [[Joint::LeftFoot, Joint::LeftToe], [Joint::RightFoot, Joint::RightToe]];
    let at = |p: &BlendedPosture| {
        let all = joint_transforms(space.skeleton(), p.vector(channel::HIPS), |j| p.rotation(Joint::ALL[j]));
        feet.map(|foot| foot.map(|j| all[j.index()].0))
    };
    let places: Vec<_> = cycle.postures.iter().map(at).collect();
    let mut out = Vec::new();
    for (i, (here, posture)) in places.iter().zip(&cycle.postures).enumerate() {
        let (next, after) = (&places[(i + 1) % n], &cycle.postures[(i + 1) % n]);
        let dt_s = posture.channel(channel::RATE).max(quickest_s) / n as f32;
        for (side, contact) in [channel::LEFT_CONTACT, channel::RIGHT_CONTACT].into_iter().enumerate() {
            if posture.channel(contact).min(after.channel(contact)) < PLANTED {
                continue;
            }
            let speed = |part: usize| {
                let (a, b) = (here[side][part], next[side][part]);
                let carried = Vec3::new(left + gyration * a.z, 0.0, ahead - gyration * a.x);
                ((b - a) / dt_s + carried).with_y(0.0).length()
            };
            out.push(f64::from(speed(0).min(speed(1))));
        }
    }
    out
}

/// Largest turn of a joint of a blend beyond its limits, which are widened to those of the examples (rad).
fn beyond_limits(limits: &BodyLimits, examples: &[BlendCycle], blends: &[BlendCycle]) -> (f64, Joint) {
    let mut worst = (0.0, Joint::Hips);
    for joint in Joint::ALL {
        let Some(own) = limits.joints[joint.index()] else { continue };
        let turns = |of: &BlendCycle| of.postures.iter().map(|p| p.rotation(joint).as_dquat()).collect::<Vec<_>>();
        let admitted = examples.iter().flat_map(turns).fold(own, |l: JointLimits, q| l.widened_to_admit(q));
        let excess = blends.iter().flat_map(turns).map(|q| admitted.excess(q)).fold(0.0, f64::max);
        worst = if excess > worst.0 { (excess, joint) } else { worst };
    }
    worst
}

/// Largest range of a joint over that of the examples: its farthest turns from the examples' first pose.
fn range_ratio(examples: &[BlendCycle], blends: &[BlendCycle]) -> (f64, Joint) {
    let range = |of: &[BlendCycle], joint: Joint, middle: Quat| {
        let turns = of.iter().flat_map(|c| &c.postures).map(|p| angle(middle, p.rotation(joint)));
        turns.fold(0.0f32, f32::max)
    };
    let ratio = |joint: Joint| {
        let all = examples.iter().flat_map(|c| &c.postures).map(|p| p.rotation(joint));
        let sum = all.fold(glam::Vec4::ZERO, |sum, q| {
            let v = glam::Vec4::from(q);
            if sum.dot(v) < 0.0 { sum - v } else { sum + v }
        });
        let middle = Quat::from_vec4(sum.normalize_or(glam::Vec4::W));
        let [own, here] = [range(examples, joint, middle), range(blends, joint, middle)];
        f64::from(here / own.max(LEAST_RANGE))
    };
    let all = Joint::ALL.map(|j| (ratio(j), j));
    all.into_iter().fold((0.0, Joint::Hips), |a, b| if b.0 > a.0 { b } else { a })
}

/// Mean turn of a joint between two cycles, phase by phase; headings do not count (deg).
fn unlike(a: &BlendCycle, b: &BlendCycle) -> f64 {
    let sum: f64 = a.postures.iter().zip(&b.postures).map(|(p, q)| pose_turn(p, q)).sum();
    sum / a.postures.len().max(1) as f64
}

/// Change from the last phase to the first beyond that between other phases, as a mean of all joints (deg).
fn seam(cycle: &BlendCycle) -> f64 {
    let n = cycle.postures.len();
    let step = |i: usize| pose_turn(&cycle.postures[i], &cycle.postures[(i + 1) % n]);
    step(n - 1) - (0..n - 1).map(step).fold(0.0, f64::max)
}

fn pose_turn(p: &BlendedPosture, q: &BlendedPosture) -> f64 {
    let turn = |j: Joint| f64::from(angle(p.rotation(j), q.rotation(j)).to_degrees());
    Joint::ALL[1..].iter().map(|j| turn(*j)).sum::<f64>() / (NUM_JOINTS - 1) as f64
}

fn angle(p: Quat, q: Quat) -> f32 {
    2.0 * p.dot(q).abs().min(1.0).acos()
}
