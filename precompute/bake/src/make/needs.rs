//! Needs: what a motion graph lacks for going to places and standing there.

use super::gait::walking_s;
use crate::graph::{RawMotionGraph, played_frames};
use serde::{Deserialize, Serialize};
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};
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
/// Rate of turning of walks with which people steer (rad/s).
const TURN_RATE: f32 = 0.6;
/// Shortest stand, and longest time from it to walking, of a start; likewise of a stop (s).
const STAND_S: f64 = 0.3;
const START_S: f64 = 2.5;
/// Shortest stand that shows that somebody starts or stops, where clips are cut soon before or after it (s).
const SHORT_STAND_S: f64 = 0.1;
/// Least angle and largest distance between the stands before and after a turn on the spot (rad, m).
const TURN: [f32; 2] = [0.7, 0.7];

/// Least angle of a turn round while walking, and the time that it takes at most (rad, s).
const PIVOT: (f32, f64) = (2.2, 1.4);

/// What the captured motion lacks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lacks {
    /// Starts and stops, of which there are few or none.
    pub starts: bool,
    /// Starts and stops of many gaits, as most walking does not lead to a stand.
    pub joins: bool,
    /// Turns on the spot, and steps aside and back.
    pub turns: bool,
    /// Walks that turn to both sides.
    pub arcs: bool,
    /// Turns round while walking.
    pub pivots: bool,
}

impl Lacks {
    /// Everything.
    pub const ALL: Self = Self { starts: true, joins: true, turns: true, arcs: true, pivots: true };

    /// True if there is something to make.
    pub fn any(self) -> bool {
        self.starts || self.joins || self.turns || self.arcs || self.pivots
    }

    /// What the motion of a graph lacks.
    pub fn of_graph(clips: &ClipSet, graph: &RawMotionGraph) -> Self {
        let rate = clips.clips.first().map_or(30.0, |c| c.rate_hz);
        let seconds = |frames: u32| f64::from(frames) / rate;
        let goes = |s: &&crate::graph::GraphSegment| {
            f64::from(s.displacement.z) > f64::from(WALKING_MPS) * seconds(s.num_frames)
        };
        let walking: Vec<_> = graph.segments.iter().filter(goes).collect();
        let walked_s: f64 = walking.iter().map(|s| seconds(s.num_frames)).sum();
        let all_s: f64 = clips.clips.iter().map(walking_s).sum();
        let turns = |side: f32| {
            walking
                .iter()
                .any(|s| f64::from(side * s.displacement.heading) > f64::from(TURN_RATE) * seconds(s.num_frames))
        };
        let played = played_frames(graph, clips);
        let (mut starts, mut stops, mut on_the_spot, mut pivots) = (0, 0, 0, 0);
        for (clip, first) in clips.clips.iter().zip(clips.frame_starts()) {
            for run in clip.usable_ranges() {
                for run in runs_where(run, |f| played[first as usize + f]) {
                    let [a, b, c, d] = count_changes(clip, &run, STAND_S);
                    (starts, stops, on_the_spot, pivots) = (starts + a, stops + b, on_the_spot + c, pivots + d);
                }
            }
        }
        let rests = graph.standing.iter().filter(|s| **s).count();
        let changes = starts.min(stops);
        Self {
            starts: rests < LEAST_RESTS || changes < ENOUGH_STARTS,
            joins: rests < LEAST_RESTS || changes == 0 || walked_s < LEAST_WALKING_S.max(LEAST_USED * all_s),
            turns: on_the_spot < ENOUGH_TURNS,
            arcs: !(turns(1.0) && turns(-1.0)),
            pivots: pivots < ENOUGH_TURNS,
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
