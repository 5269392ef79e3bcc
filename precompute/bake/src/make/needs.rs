//! Needs: what a motion graph lacks for going to places and standing there.

use super::gait::{GaitCycle, walking_s};
use crate::graph::{GraphAction, GraphSegment, MotionApart, RawMotionGraph, StateId, played_frames};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::f32::consts::PI;
use throng_base::maths::{self, quantile};
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};
use throng_core::{format::Gait, planar::wrap_angle};
use throng_motion::annotate::classes::{goes_somewhere, named_manner};
use throng_motion::clip::{Clip, ClipSet, FrameId, FrameRange, runs_where};

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
/// Longest time from the end of a segment that goes to a stand, for nine such segments in ten, with which people stop soon enough (s).
const STOP_S: f64 = 1.0;
/// Shortest stand, and longest time from it to walking, of a start; likewise of a stop (s).
const STAND_S: f64 = 0.3;
const START_S: f64 = 2.5;
/// Least distance between a stand and its walk within that time (m): a step of a dance or of a gesture is no start. Chosen, more than
/// one step.
pub const LEAST_START_M: f32 = 0.8;
/// Shortest stand that shows that somebody starts or stops, where clips are cut soon before or after it (s).
const SHORT_STAND_S: f64 = 0.1;
/// Least angle and largest distance between the stands before and after a turn on the spot (rad, m).
const TURN: [f32; 2] = [0.7, 0.7];
/// Mean rate of a quick turn on the spot, and time that it may take beside (rad/s, s).
const QUICK_TURN: (f32, f64) = (PI, 0.4);
/// Least angle of a turn round while going, and the time that it takes at most (rad, s).
const PIVOT: (f32, f64) = (2.2, 1.4);

/// Number of gaits, as [`Gait`] numbers them.
pub(super) const NUM_GAITS: usize = Gait::Other as usize + 1;

/// What the captured motion lacks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lacks {
    /// Starts and stops, of which there are few or none.
    pub starts: bool,
    /// Starts and stops of many gaits, as most walking does not lead to a stand, or not soon.
    pub joins: bool,
    /// Motion to which nothing leads, and which starts and stops of its own may join.
    pub apart: Vec<MotionApart>,
    /// Quick turns on the spot.
    pub turns: bool,
    /// Steps aside and back; they lack where turns on the spot are few.
    pub steps: bool,
    /// Turning to both sides, of each gait that goes.
    pub arcs: [bool; NUM_GAITS],
    /// Sideways acceleration of the captured turning, or one at which people turn where there is none (m/s2).
    pub sideways_mps2: f32,
    /// Turns round while going: few are captured, or who goes is slow to stop.
    pub pivots: bool,
}

impl Lacks {
    /// Everything.
    pub const ALL: Self = Self {
        starts: true,
        joins: true,
        apart: Vec::new(),
        turns: true,
        steps: true,
        arcs: [true; NUM_GAITS],
        sideways_mps2: SIDEWAYS_MPS2,
        pivots: true,
    };

    /// True if there is something to make.
    pub fn any(&self) -> bool {
        let some = self.starts || self.joins || self.turns || self.steps || self.pivots;
        some || !self.apart.is_empty() || self.arcs.contains(&true)
    }

    /// True for a gait of motion to which nothing leads.
    pub(super) fn is_apart(&self, gait: &GaitCycle) -> bool {
        self.apart.iter().any(|a| a.gait == gait.class.gait.name() && a.clips.contains(&gait.clip.name))
    }

    /// What each manner of a graph lacks, each to be gone and stood in alone.
    ///
    /// - `graph`: with the motion that stays out of it; none where there is no graph.
    pub fn of_manners(clips: &ClipSet, graph: Option<(&RawMotionGraph, &[MotionApart])>) -> BTreeMap<String, Self> {
        let manners: BTreeSet<&str> = clips.clips.iter().map(manner_of).collect();
        let lacks = |manner| graph.map_or(Self::ALL, |(graph, apart)| Self::of_manner(manner, clips, graph, apart));
        manners.into_iter().map(|manner| (manner.to_owned(), lacks(manner))).filter(|(_, lacks)| lacks.any()).collect()
    }

    /// What the motion of a manner lacks in a graph.
    fn of_manner(manner: &str, clips: &ClipSet, graph: &RawMotionGraph, apart: &[MotionApart]) -> Self {
        let frame_starts = clips.frame_starts();
        let is_own = |frame: FrameId| {
            let clip = frame_starts.partition_point(|&s| s <= frame.0) - 1;
            manner_of(&clips.clips[clip]) == manner
        };
        let rate = clips.clips.first().map_or(30.0, |c| c.rate_hz);
        let seconds = |frames: u32| f64::from(frames) / rate;
        let goes = |s: &&GraphSegment| f64::from(s.displacement.z) > f64::from(WALKING_MPS) * seconds(s.num_frames);
        let walked_s: f64 =
            graph.segments.iter().filter(|s| is_own(s.start)).filter(goes).map(|s| seconds(s.num_frames)).sum();
        let own = || clips.clips.iter().zip(&frame_starts).filter(|(clip, _)| manner_of(clip) == manner);
        let all_s: f64 = own().map(|(clip, _)| walking_s(clip)).sum();
        let played = played_frames(graph, clips);
        let (mut starts, mut stops, mut on_the_spot, mut pivots) = (0, 0, [0, 0], 0);
        let mut gaits: [GaitUse; NUM_GAITS] = Default::default();
        for (clip, first) in own() {
            let is_played = |f: usize| played[*first as usize + f];
            for run in clip.usable_ranges() {
                count_turning(clip, &run, &is_played, &mut gaits);
                for run in runs_where(run, is_played) {
                    let [a, b, turns, quick, c] = count_changes(clip, &run, STAND_S);
                    (starts, stops, pivots) = (starts + a, stops + b, pivots + c);
                    on_the_spot = [on_the_spot[0] + turns, on_the_spot[1] + quick];
                }
            }
        }
        let rests = graph.states.iter().zip(&graph.standing).filter(|(frame, s)| **s && is_own(**frame)).count();
        let changes = starts.min(stops);
        let is_slow = stop_frames(graph, is_own, |s| is_own(s.start) && goes(&s)) / rate > STOP_S;
        let turning: Vec<f32> = gaits.iter().flat_map(|g| g.sideways_mps2.iter().copied()).collect();
        let usual = quantile(turning.iter().copied(), [1, 2]);
        let captured = usual.filter(|_| turning.len() as f64 * STEP_S > TURNING_S);
        let goes_straight = |g: usize| gaits[g].is_seen && gaits[g].turns_s.iter().any(|s| *s < TURNING_S);
        Self {
            starts: rests < LEAST_RESTS || changes < ENOUGH_STARTS,
            joins: rests < LEAST_RESTS || changes == 0 || walked_s < LEAST_WALKING_S.max(LEAST_USED * all_s) || is_slow,
            apart: apart.to_vec(),
            turns: on_the_spot[1] < ENOUGH_TURNS,
            steps: on_the_spot[0] < ENOUGH_TURNS,
            arcs: std::array::from_fn(goes_straight),
            sideways_mps2: captured.map_or(SIDEWAYS_MPS2, |a| a.clamp(LEAST_SIDEWAYS_MPS2, 2.0 * SIDEWAYS_MPS2)),
            pivots: pivots < ENOUGH_TURNS || is_slow,
        }
    }
}

/// Least time from the ends of segments to a standing state, 90th percentile; infinite where nothing leads to one (frames).
///
/// - `is_own`: true for the frames of stands that count.
/// - `counts`: true for the segments whose ends are looked at.
pub(super) fn stop_frames(
    graph: &RawMotionGraph,
    is_own: impl Fn(FrameId) -> bool,
    counts: impl Fn(&GraphSegment) -> bool,
) -> f64 {
    let of_state = |(&stands, &frame): (&bool, &FrameId)| if stands && is_own(frame) { 0.0 } else { f64::INFINITY };
    let mut left: Vec<f64> = graph.standing.iter().zip(&graph.states).map(of_state).collect();
    loop {
        let after = |action: &GraphAction| {
            let segment = &graph.segments[action.segment.0 as usize];
            left[segment.end.0 as usize] + f64::from(segment.num_frames)
        };
        let least = |s: usize| graph.actions_of(StateId(s as u32)).iter().map(after).fold(left[s], f64::min);
        let next: Vec<f64> = (0..left.len()).map(least).collect();
        if next == left {
            break;
        }
        left = next;
    }
    let times = graph.segments.iter().filter(|s| counts(s)).map(|s| left[s.end.0 as usize]);
    quantile(times, [9, 10]).unwrap_or(0.0)
}

/// Manner that the name of a clip gives.
fn manner_of(clip: &Clip) -> &str {
    clip.classes.first().map_or("", |span| named_manner(&span.class.manner))
}

/// Turning of a gait.
#[derive(Default)]
struct GaitUse {
    /// True if clips show it.
    is_seen: bool,
    /// Time of played turning to the left and to the right (s).
    turns_s: [f64; 2],
    /// Sideways acceleration of all turning (m/s2).
    sideways_mps2: Vec<f32>,
}

/// Counts the turning of a run, second by second, for its gaits.
fn count_turning(clip: &Clip, run: &FrameRange, is_played: &impl Fn(usize) -> bool, gaits: &mut [GaitUse; NUM_GAITS]) {
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
        gait.is_seen = true;
        if rate.abs() > TURN_RATE.min(TURNING * SIDEWAYS_MPS2 / speed) {
            gait.turns_s[usize::from(rate < 0.0)] += if is_played(f) && is_played(f + second) { STEP_S } else { 0.0 };
            gait.sideways_mps2.push(rate.abs() * speed);
        }
    }
}

/// Captured starts of clips, or stops if these are fewer.
pub(super) fn count_starts(clips: &ClipSet) -> usize {
    let captured = clips.clips.iter().filter(|c| !c.mirrored && !c.is_made());
    let of_clip =
        |c: &Clip| c.usable_ranges().iter().map(|run| count_changes(c, run, SHORT_STAND_S)).collect::<Vec<_>>();
    let all: Vec<[usize; 5]> = captured.flat_map(of_clip).collect();
    [0, 1].map(|what| all.iter().map(|counts| counts[what]).sum()).into_iter().min().unwrap_or(0)
}

/// Starts, stops, turns on the spot, quick ones among them, and turns round while going, within a run.
///
/// - `stand_s`: shortest time of a stand (s).
fn count_changes(clip: &Clip, run: &FrameRange, stand_s: f64) -> [usize; 5] {
    let frames = |s: f64| ((s * clip.rate_hz) as usize).max(1);
    let half = frames(0.2);
    let speed = |f: usize| {
        let (a, b) = (f.saturating_sub(half).max(run.start), (f + half).min(run.end - 1));
        let by = (clip.root_positions[b] - clip.root_positions[a]).with_y(0.0).length();
        by * clip.rate_hz as f32 / (b - a).max(1) as f32
    };
    let mut stands = runs_where(run.clone(), |f| speed(f) < STANDING_MPS);
    stands.retain(|r| r.len() >= frames(stand_s));
    // Hips swing in bows.
    let goes = |f: usize| speed(f) > WALKING_MPS && clip.class_at(f).is_none_or(goes_somewhere);
    let at = |f: usize| clip.root_positions[f].with_y(0.0);
    // Made starts begin to go, and leave the rest to the gait.
    let least_m = if clip.is_made() { 0.0 } else { LEAST_START_M };
    let walks = |stand: usize, mut range: FrameRange| range.any(|f| goes(f) && at(f).distance(at(stand)) > least_m);
    let near = frames(START_S);
    let starts = stands.iter().filter(|r| walks(r.end - 1, r.end..(r.end + near).min(run.end))).count();
    let stops = stands.iter().filter(|r| walks(r.start, r.start.saturating_sub(near).max(run.start)..r.start)).count();
    // Angle by which it turns on the spot between two stands (rad), and the time that it takes (frames).
    let turn = |w: &[FrameRange]| {
        let (a, b) = (clip.planar(w[0].end - 1), clip.planar(w[1].start));
        let (turned, over) = (wrap_angle(b.heading - a.heading).abs(), w[1].start - w[0].end);
        (turned > TURN[0] && (a.x - b.x).hypot(a.z - b.z) < TURN[1] && over < 2 * near).then_some((turned, over))
    };
    let turns: Vec<(f32, usize)> = stands.windows(2).filter_map(turn).collect();
    let is_quick = |&&(angle, over): &&(f32, usize)| over < frames(f64::from(angle / QUICK_TURN.0) + QUICK_TURN.1);
    let over = frames(PIVOT.1);
    let heading = |f: usize| clip.planar(f).heading;
    let (mut pivots, mut f) = (0, run.start);
    while f + over < run.end {
        let is_pivot = goes(f) && goes(f + over) && wrap_angle(heading(f + over) - heading(f)).abs() > PIVOT.0;
        pivots += usize::from(is_pivot);
        f += if is_pivot { over } else { 1 };
    }
    [starts, stops, turns.len(), turns.iter().filter(is_quick).count(), pivots]
}
