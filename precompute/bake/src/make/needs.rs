//! Needs: what a motion graph lacks for going to places and standing there.

use super::gait::walking_s;
use crate::graph::{RawMotionGraph, TakenMotion, played_frames};
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};
use throng_core::format::Gait;
use throng_core::planar::wrap_angle;
use throng_motion::clip::{Clip, ClipSet, FrameRange, runs_where};

/// Fewest standing states of a graph in which people can stand.
const LEAST_RESTS: usize = 4;
/// Fewest captured starts, and stops, with which people set off and arrive as they wish.
const ENOUGH_STARTS: usize = 20;
/// Fewest captured turns on the spot.
const ENOUGH_TURNS: usize = 8;
/// Least walking that a graph uses: at all, and as a share of that in the clips (s, 1).
const LEAST_WALKING_S: f64 = 3.0;
const LEAST_USED: f64 = 0.5;
/// Rate of turning of walks with which people steer (rad/s), least time of it to each side, and time between two looks (s).
const TURN_RATE: f32 = 0.6;
const TURNING_S: f64 = 1.0;
const STEP_S: f64 = 0.25;
/// Sideways acceleration at which people turn while they go, least one of captured turning that made turning takes over
/// (m/s2), and share of it from which who goes fast steers.
const SIDEWAYS_MPS2: f32 = 1.5;
const LEAST_SIDEWAYS_MPS2: f32 = 1.0;
const TURNING: f32 = 0.6;
/// Shortest stand, and longest time from it to walking, of a start; likewise of a stop (s).
const STAND_S: f64 = 0.3;
const START_S: f64 = 2.5;
/// Shortest stand that shows that somebody starts or stops, where clips are cut soon before or after it (s).
const SHORT_STAND_S: f64 = 0.1;
/// Least angle and largest distance between the stands before and after a turn on the spot (rad, m).
const TURN: [f32; 2] = [0.7, 0.7];

/// Least angle of a turn round while walking, and the time that it takes at most (rad, s).
const PIVOT: (f32, f64) = (2.2, 1.4);

/// Number of gaits, as [`Gait`] numbers them.
pub(super) const NUM_GAITS: usize = Gait::Other as usize + 1;

/// What the captured motion lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lacks {
    /// Starts and stops, of which there are few or none.
    pub starts: bool,
    /// Starts and stops of each gait of which most motion does not lead to a stand.
    pub joins: [bool; NUM_GAITS],
    /// Turns on the spot, and steps aside and back.
    pub turns: bool,
    /// Turning to both sides, of each gait that goes.
    pub arcs: [bool; NUM_GAITS],
    /// Sideways acceleration of the captured turning, or one at which people turn where there is none (m/s2).
    pub sideways_mps2: f32,
    /// Turns round while walking.
    pub pivots: bool,
}

impl Lacks {
    /// Everything.
    pub const ALL: Self = Self {
        starts: true,
        joins: [true; NUM_GAITS],
        turns: true,
        arcs: [true; NUM_GAITS],
        sideways_mps2: SIDEWAYS_MPS2,
        pivots: true,
    };

    /// True if there is something to make.
    pub fn any(self) -> bool {
        self.starts || self.turns || self.pivots || self.joins.contains(&true) || self.arcs.contains(&true)
    }

    /// What the motion of a graph lacks.
    ///
    /// - `take`: the motion that the graph takes.
    pub fn of_graph(clips: &ClipSet, graph: &RawMotionGraph, take: &[TakenMotion]) -> Self {
        let rate = clips.clips.first().map_or(30.0, |c| c.rate_hz);
        let seconds = |frames: u32| f64::from(frames) / rate;
        let goes = |s: &&crate::graph::GraphSegment| {
            f64::from(s.displacement.z) > f64::from(WALKING_MPS) * seconds(s.num_frames)
        };
        let walked_s: f64 = graph.segments.iter().filter(goes).map(|s| seconds(s.num_frames)).sum();
        let all_s: f64 = clips.clips.iter().map(walking_s).sum();
        let played = played_frames(graph, clips);
        let (mut starts, mut stops, mut on_the_spot, mut pivots) = (0, 0, 0, 0);
        let mut gaits: [GaitUse; NUM_GAITS] = Default::default();
        for (clip, first) in clips.clips.iter().zip(clips.frame_starts()) {
            let is_played = |f: usize| played[first as usize + f];
            for run in clip.usable_ranges() {
                for f in run.clone() {
                    let class = clip.class_at(f).filter(|c| take.contains(&TakenMotion::of_class(c)));
                    if let Some(class) = class {
                        gaits[class.gait as usize].count(is_played(f), rate);
                    }
                }
                for run in runs_where(run, is_played) {
                    let [a, b, c, d] = count_changes(clip, &run, STAND_S);
                    (starts, stops, on_the_spot, pivots) = (starts + a, stops + b, on_the_spot + c, pivots + d);
                    count_turning(clip, &run, &mut gaits);
                }
            }
        }
        let rests = graph.standing.iter().filter(|s| **s).count();
        let changes = starts.min(stops);
        let joins = rests < LEAST_RESTS || changes == 0 || walked_s < LEAST_WALKING_S.max(LEAST_USED * all_s);
        let mut turning: Vec<f32> = gaits.iter().flat_map(|g| g.sideways_mps2.iter().copied()).collect();
        turning.sort_by(f32::total_cmp);
        let captured = turning.get(turning.len() / 2).filter(|_| turning.len() as f64 * STEP_S > TURNING_S);
        let going = |of: fn(&GaitUse) -> bool| {
            let of = |g: usize| g != Gait::Stand as usize && g != Gait::Other as usize && of(&gaits[g]);
            std::array::from_fn(of)
        };
        Self {
            starts: rests < LEAST_RESTS || changes < ENOUGH_STARTS,
            joins: if joins { [true; NUM_GAITS] } else { going(GaitUse::stays_out) },
            turns: on_the_spot < ENOUGH_TURNS,
            arcs: going(GaitUse::goes_straight),
            sideways_mps2: captured.map_or(SIDEWAYS_MPS2, |a| a.clamp(LEAST_SIDEWAYS_MPS2, 2.0 * SIDEWAYS_MPS2)),
            pivots: pivots < ENOUGH_TURNS,
        }
    }
}

/// Use of a gait by a graph.
#[derive(Default)]
struct GaitUse {
    /// Time of the clips, and of what the graph plays (s).
    all_s: f64,
    played_s: f64,
    /// Time of played turning to the left and to the right (s).
    turns_s: [f64; 2],
    /// Sideways acceleration of turning (m/s2).
    sideways_mps2: Vec<f32>,
}

impl GaitUse {
    fn count(&mut self, is_played: bool, rate_hz: f64) {
        self.all_s += 1.0 / rate_hz;
        self.played_s += if is_played { 1.0 / rate_hz } else { 0.0 };
    }

    fn stays_out(&self) -> bool {
        self.all_s > LEAST_WALKING_S && self.played_s < LEAST_USED * self.all_s
    }

    fn goes_straight(&self) -> bool {
        self.all_s > 0.0 && self.turns_s.iter().any(|s| *s < TURNING_S)
    }
}

/// Counts the turning of a run, second by second, for its gaits.
fn count_turning(clip: &Clip, run: &FrameRange, gaits: &mut [GaitUse; NUM_GAITS]) {
    let half = (0.5 * clip.rate_hz).round().max(1.0) as usize;
    let second = 2 * half;
    // Hips twist with every step, but hardly leave the way.
    let way = |from: usize, to: usize| (clip.root_positions[to] - clip.root_positions[from]).with_y(0.0);
    for f in run.clone().step_by(((STEP_S * clip.rate_hz) as usize).max(1)).take_while(|f| f + second < run.end) {
        let gait = |f: usize| clip.class_at(f).map(|c| c.gait);
        let speed = way(f, f + second).length();
        let Some(of) = gait(f).filter(|g| gait(f + second) == Some(*g) && speed > WALKING_MPS) else { continue };
        let [a, b] = [way(f, f + half), way(f + half, f + second)].map(|way| maths::atan2(way.x, way.z));
        let rate = 2.0 * wrap_angle(b - a);
        let gait = &mut gaits[of as usize];
        if rate.abs() > TURN_RATE.min(TURNING * SIDEWAYS_MPS2 / speed) {
            gait.turns_s[usize::from(rate < 0.0)] += STEP_S;
            gait.sideways_mps2.push(rate.abs() * speed);
        }
    }
}

/// Captured starts of clips, or stops if these are fewer.
pub(super) fn count_starts(clips: &ClipSet) -> usize {
    let captured = clips.clips.iter().filter(|c| !c.mirrored && !c.is_made());
    let of_clip =
        |c: &Clip| c.usable_ranges().iter().map(|run| count_changes(c, run, SHORT_STAND_S)).collect::<Vec<_>>();
    let all: Vec<[usize; 4]> = captured.flat_map(of_clip).collect();
    [0, 1].map(|what| all.iter().map(|counts| counts[what]).sum()).into_iter().min().unwrap_or(0)
}

/// Starts, stops, turns on the spot, and turns round while walking within a run.
///
/// - `stand_s`: shortest time of a stand (s).
fn count_changes(clip: &Clip, run: &FrameRange, stand_s: f64) -> [usize; 4] {
    let frames = |s: f64| ((s * clip.rate_hz) as usize).max(1);
    let half = frames(0.2);
    let speed = |f: usize| {
        let (a, b) = (f.saturating_sub(half).max(run.start), (f + half).min(run.end - 1));
        let by = (clip.root_positions[b] - clip.root_positions[a]).with_y(0.0).length();
        by * clip.rate_hz as f32 / (b - a).max(1) as f32
    };
    let mut stands = runs_where(run.clone(), |f| speed(f) < STANDING_MPS);
    stands.retain(|r| r.len() >= frames(stand_s));
    let walks = |mut range: FrameRange| range.any(|f| speed(f) > WALKING_MPS);
    let near = frames(START_S);
    let starts = stands.iter().filter(|r| walks(r.end..(r.end + near).min(run.end))).count();
    let stops = stands.iter().filter(|r| walks(r.start.saturating_sub(near).max(run.start)..r.start)).count();
    let turns = |w: &&[FrameRange]| {
        let (a, b) = (clip.planar(w[0].end - 1), clip.planar(w[1].start));
        let turned = wrap_angle(b.heading - a.heading).abs() > TURN[0];
        turned && (a.x - b.x).hypot(a.z - b.z) < TURN[1] && w[1].start - w[0].end < 2 * near
    };
    let over = frames(PIVOT.1);
    let heading = |f: usize| clip.planar(f).heading;
    let goes = |f: usize| speed(f) > WALKING_MPS;
    let (mut pivots, mut f) = (0, run.start);
    while f + over < run.end {
        let is_pivot = goes(f) && goes(f + over) && wrap_angle(heading(f + over) - heading(f)).abs() > PIVOT.0;
        pivots += usize::from(is_pivot);
        f += if is_pivot { over } else { 1 };
    }
    [starts, stops, stands.windows(2).filter(turns).count(), pivots]
}
