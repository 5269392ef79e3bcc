//! Locomotion abilities that motion contains: walking, stopping, turning to both sides.

use crate::frames::{of_classes, runs};
use crate::made::made_frames;
use std::f64::consts::PI;
use throng_bake::make::LEAST_START_M;
use throng_base::thresholds::{STANDING_MPS_F64, WALKING_MPS};
use throng_core::{Bundle, Planar, format::ClipRecord};
use throng_motion::annotate::classes::goes_somewhere;
use throng_motion::clip::{ClipSet, runs_where};

/// Shortest time that counts as standing (s).
const STANDING_S: f64 = 0.3;
/// Time over which a speed is measured (s).
const SPEED_S: f64 = 0.4;
/// Time over which a turn is measured: about two steps, so that the hips' swing does not count (s).
const TURN_S: f64 = 1.0;
/// Longest time from walking to standing that counts as a stop (s).
const STOP_S: f64 = 2.5;
/// Turns below this are slow (deg/s).
const SLOW_TURN: f64 = 45.0;
/// Walking counts as backwards if its direction is more than 135 degrees off the heading: cosine of that angle.
const BACKWARDS: f64 = -0.7;
/// Share of backwards walking above which a set walks mostly backwards.
pub(crate) const MOSTLY_BACKWARDS: f64 = 0.5;
/// Duration of walking below which a set has little of it (s).
pub(crate) const LITTLE_WALKING_S: f64 = 30.0;

/// Abilities that some motion contains, mirrored copies not counted.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Abilities {
    /// Usable motion (s).
    pub usable_s: f64,
    /// Usable motion that moves over ground at half a metre a second or more (s).
    pub walking_s: f64,
    /// Part of the walking that goes backwards (s).
    pub backwards_s: f64,
    /// Usable motion that stands (s).
    pub standing_s: f64,
    /// Fastest speed over ground (m/s).
    pub fastest_mps: f64,
    /// Number of starts from standing to walking.
    pub starts: usize,
    /// Number of stops from walking to standing.
    pub stops: usize,
    /// Fastest turn to the left while walking, over a second (deg/s).
    pub turn_left_deg_per_s: f64,
    /// Fastest turn to the right (deg/s).
    pub turn_right_deg_per_s: f64,
    /// Effective hits.
    pub blows: usize,
}

impl Abilities {
    /// Abilities in annotated clips.
    pub fn of_clips(set: &ClipSet) -> Self {
        let mut out = Self::default();
        for clip in set.clips.iter().filter(|c| !c.mirrored) {
            out.blows += clip.hits.len();
            for run in clip.usable_ranges() {
                let goes: Vec<bool> = run.clone().map(|f| clip.class_at(f).is_none_or(goes_somewhere)).collect();
                out.add(&run.map(|f| clip.planar(f)).collect::<Vec<_>>(), &goes, clip.rate_hz, LEAST_START_M);
            }
        }
        out
    }

    /// Abilities in the frames that the actions of a bundle's motion graph play.
    pub fn of_played_frames(tables: &Bundle) -> Self {
        let played = played_frames(tables);
        Self::of_frames(tables, |f| played[f])
    }

    /// Abilities in the frames of a bundle that count.
    pub(crate) fn of_frames(tables: &Bundle, counts: impl Fn(usize) -> bool) -> Self {
        let (mut out, rate_hz) = (Self::default(), tables.meta().rate_hz);
        let clips = tables.clips();
        let is_original =
            |frame: u32| clips[clips.partition_point(|c| c.first_frame <= frame).saturating_sub(1)].mirrored == 0;
        out.blows = tables.hits().iter().filter(|h| is_original(h.frame) && counts(h.frame as usize)).count();
        let (goes, made) = (of_classes(tables, true, goes_somewhere), made_frames(tables));
        let root = |f: usize| Planar::from_array(tables.frames()[f].planar);
        for run in runs(tables).into_iter().filter(|r| is_original(r.start)) {
            for run in runs_where(run.start as usize..run.end as usize, &counts) {
                // Made starts begin to go, and leave the rest to the gait.
                let least_m = if made[run.start] { 0.0 } else { LEAST_START_M };
                out.add(&run.clone().map(root).collect::<Vec<_>>(), &goes[run], rate_hz, least_m);
            }
        }
        out
    }

    /// Adds a run of usable frames.
    ///
    /// - `goes`: false in bows and the like, in which the hips swing, but nobody walks (roots.len()).
    /// - `least_m`: way from a stand that a start has (m).
    fn add(&mut self, roots: &[Planar], goes: &[bool], rate_hz: f64, least_m: f32) {
        let frames = |s: f64| (s * rate_hz).round().max(1.0) as usize;
        let velocities = ground_velocities(roots, frames(0.5 * SPEED_S), rate_hz);
        let speeds: Vec<f64> = velocities.iter().map(|[x, z]| x.hypot(*z)).collect();
        let walks = |f: usize| goes[f] && speeds[f] >= f64::from(WALKING_MPS);
        let backwards = |f: usize| {
            let (sin, cos) = f64::from(roots[f].heading).sin_cos();
            velocities[f][0] * sin + velocities[f][1] * cos < BACKWARDS * speeds[f]
        };
        let standing: Vec<_> = runs_where(0..roots.len(), |f| speeds[f] < STANDING_MPS_F64);
        let standing: Vec<_> = standing.into_iter().filter(|r| r.len() >= frames(STANDING_S)).collect();
        let near = frames(STOP_S);
        for r in &standing {
            let leaves = |stand: usize, mut range: std::ops::Range<usize>| {
                let by_m = |f: usize| (roots[f].x - roots[stand].x).hypot(roots[f].z - roots[stand].z);
                range.any(|f| walks(f) && by_m(f) > least_m)
            };
            self.stops += usize::from(leaves(r.start, r.start.saturating_sub(near)..r.start));
            self.starts += usize::from(leaves(r.end - 1, r.end..(r.end + near).min(roots.len())));
        }
        self.usable_s += roots.len() as f64 / rate_hz;
        self.walking_s += (0..roots.len()).filter(|&f| walks(f)).count() as f64 / rate_hz;
        self.backwards_s += (0..roots.len()).filter(|&f| walks(f) && backwards(f)).count() as f64 / rate_hz;
        self.standing_s += standing.iter().map(ExactSizeIterator::len).sum::<usize>() as f64 / rate_hz;
        self.fastest_mps = speeds.iter().copied().fold(self.fastest_mps, f64::max);
        for walk in runs_where(0..roots.len(), walks).into_iter().filter(|r| r.len() > frames(TURN_S)) {
            let mut headings = vec![0.0];
            for f in walk.start + 1..walk.end {
                let by = f64::from(roots[f].heading - roots[f - 1].heading);
                headings.push(headings[headings.len() - 1] + (by + PI).rem_euclid(2.0 * PI) - PI);
            }
            let window = frames(TURN_S);
            for f in 0..headings.len() - window {
                let rate = (headings[f + window] - headings[f]).to_degrees() * rate_hz / window as f64;
                self.turn_left_deg_per_s = self.turn_left_deg_per_s.max(rate);
                self.turn_right_deg_per_s = self.turn_right_deg_per_s.max(-rate);
            }
        }
    }

    /// Share of the walking that goes backwards (0 to 1).
    pub(crate) fn backwards_share(&self) -> f64 {
        self.backwards_s / self.walking_s.max(1.0)
    }

    /// Abilities that a behaviour needs and this motion lacks, each with the clips that would add it.
    ///
    /// - `mirrored`: mirrored copies are made, so that a turn to one side is one to the other side too.
    pub fn missing(&self, mirrored: bool) -> Vec<String> {
        let mut out = Vec::new();
        if self.walking_s < 1.0 {
            let why = "no walking: characters cannot go to a target; add walks of at least a minute, with root motion";
            return vec![why.into()];
        }
        if self.walking_s < LITTLE_WALKING_S {
            let s = self.walking_s;
            out.push(format!("only {s:.0} s of walking: characters have few ways to a target; add a minute of walks"));
        }
        if self.backwards_share() > MOSTLY_BACKWARDS {
            out.push(format!(
                "hardly any walking ahead: {:.0} % of it is backwards; if it is not, the front of the rest pose was misread \
                 (`import.forward` in a config sets it), otherwise add walks ahead",
                100.0 * self.backwards_share()
            ));
        }
        out.extend(self.missing_changes([
            "characters will circle their targets; add a clip that walks, then stands",
            "who stands will stay there; add a clip that stands, then walks",
        ]));
        let [left, right] = [self.turn_left_deg_per_s, self.turn_right_deg_per_s];
        for (side, rate, other) in [("left", left, right), ("right", right, left)] {
            if rate < SLOW_TURN && (!mirrored || other < SLOW_TURN) {
                out.push(format!("turns {side} {rate:.0} deg/s at most: add a {side} turn"));
            } else if rate < SLOW_TURN {
                let side = format!("turns {side} {rate:.0} deg/s at most");
                out.push(format!("{side}; mirrored copies of the other side's {other:.0} deg/s make up for it"));
            }
        }
        out
    }
}

impl Abilities {
    /// The abilities that files lack, as [`Self::missing`], where a build makes the stops and starts that are missing.
    pub(crate) fn missing_in_files(&self, mirrored: bool) -> Vec<String> {
        let made = "captured ones look better than those that a build makes; add a clip that";
        let [stop, start] = ["walks, then stands", "stands, then walks"].map(|what| format!("{made} {what}"));
        let changes = self.missing_changes([&stop, &start]);
        let is_other = |text: &String| !text.starts_with("no stop") && !text.starts_with("no start");
        let has_walks = self.walking_s >= 1.0;
        self.missing(mirrored).into_iter().filter(is_other).chain(changes.filter(|_| has_walks)).collect()
    }

    /// Whether stops and starts are missing, each with what to say of it.
    fn missing_changes(&self, [stop, start]: [&str; 2]) -> impl Iterator<Item = String> + use<> {
        let stop = (self.stops == 0).then(|| format!("no stop: {stop}"));
        stop.into_iter().chain((self.starts == 0).then(|| format!("no start: {start}")))
    }
}

/// Flags the frames of a bundle that some action plays: the first frame of a segment takes the place of the one that is
/// left, and does not count (number of frames).
pub fn played_frames(tables: &Bundle) -> Vec<bool> {
    let mut played = vec![false; tables.frames().len()];
    for s in tables.graph().segments.iter() {
        let first = s.start as usize + 1;
        played[first..first + s.num_frames as usize].fill(true);
    }
    played
}

/// Names of the clips with walking that no action plays, mirrored and made ones not counted.
pub fn unused_clips(tables: &Bundle) -> Vec<&str> {
    let [played, made, goes] = [played_frames(tables), made_frames(tables), of_classes(tables, true, goes_somewhere)];
    let unused = |c: &ClipRecord| {
        let first = c.first_frame as usize;
        let frames = first..first + c.num_frames as usize;
        let holds = |which: &[bool]| which[frames.clone()].contains(&true);
        c.mirrored == 0 && holds(&goes) && !holds(&made) && !holds(&played)
    };
    let all = tables.clips().iter().zip(&tables.meta().clips);
    all.filter(|(c, _)| unused(c)).map(|(_, meta)| meta.name.as_str()).collect()
}

/// Velocity over ground at every frame, along X and Z, as the mean over `half` frames before and after (m/s).
fn ground_velocities(roots: &[Planar], half: usize, rate_hz: f64) -> Vec<[f64; 2]> {
    let velocity = |f: usize| {
        let (from, to) = (f.saturating_sub(half), (f + half).min(roots.len() - 1));
        let [a, b] = [roots[from], roots[to]];
        [b.x - a.x, b.z - a.z].map(|by| f64::from(by) * rate_hz / (to - from).max(1) as f64)
    };
    (0..roots.len()).map(velocity).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walks at 1 m/s, turning by so much a second, for some seconds; stands where the speed is 0.
    fn course(parts: &[(f32, f32, f32)]) -> Vec<Planar> {
        let (mut at, mut out) = (Planar::default(), Vec::new());
        for &(seconds, mps, deg_per_s) in parts {
            for _ in 0..(seconds * 30.0) as usize {
                at.heading += deg_per_s.to_radians() / 30.0;
                at.x += mps / 30.0 * at.heading.sin();
                at.z += mps / 30.0 * at.heading.cos();
                out.push(at);
            }
        }
        out
    }

    fn of(parts: &[(f32, f32, f32)]) -> Abilities {
        let (mut out, course) = (Abilities::default(), course(parts));
        out.add(&course, &vec![true; course.len()], 30.0, LEAST_START_M);
        out
    }

    #[test]
    fn a_step_of_a_gesture_is_neither_a_start_nor_a_stop() {
        let a = of(&[(2.0, 0.0, 0.0), (0.5, 1.0, 0.0), (2.0, 0.0, 0.0), (0.5, 1.0, 0.0), (3.0, 0.0, 0.0)]);
        assert_eq!((a.starts, a.stops), (0, 0));
        let a = of(&[(2.0, 0.0, 0.0), (1.2, 1.0, 0.0), (2.0, 0.0, 0.0)]);
        assert_eq!((a.starts, a.stops), (1, 1));
    }

    #[test]
    fn a_walk_that_stops_and_turns_lacks_nothing() {
        let a = of(&[(20.0, 1.0, 0.0), (2.0, 0.0, 0.0), (10.0, 1.2, 60.0), (10.0, 1.0, -70.0)]);
        assert_eq!((a.stops, a.starts), (1, 1));
        assert!((a.walking_s - 40.0).abs() < 0.5 && (a.standing_s - 2.0).abs() < 0.5, "{a:?}");
        assert!((a.turn_left_deg_per_s - 60.0).abs() < 1.0 && (a.turn_right_deg_per_s - 70.0).abs() < 1.0, "{a:?}");
        assert!((a.fastest_mps - 1.2).abs() < 0.02);
        assert!(a.missing(false).is_empty(), "{:?}", a.missing(false));
    }

    #[test]
    fn hips_that_swing_in_a_bow_neither_start_nor_stop() {
        let course = course(&[(1.0, 0.0, 0.0), (0.5, -0.9, 0.0), (1.0, 0.0, 0.0), (0.5, 0.9, 0.0), (1.0, 0.0, 0.0)]);
        let counted = |goes| {
            let mut out = Abilities::default();
            out.add(&course, &vec![goes; course.len()], 30.0, 0.0);
            (out.starts, out.stops, out.walking_s > 0.5)
        };
        assert_eq!((counted(true), counted(false)), ((2, 2, true), (0, 0, false)));
    }

    #[test]
    fn what_is_missing_is_said_with_the_clip_that_mends_it() {
        let straight = of(&[(40.0, 1.0, 0.0), (5.0, 1.0, 50.0)]);
        let missing = straight.missing(false);
        for what in ["no stop", "no start"] {
            assert!(missing.iter().any(|t| t.starts_with(what)), "{missing:?}");
        }
        assert!(missing.iter().any(|t| t == "turns right 0 deg/s at most: add a right turn"), "{missing:?}");
        let in_files = straight.missing_in_files(false);
        assert_eq!(in_files.len(), missing.len());
        assert!(in_files.iter().any(|t| t.contains("captured ones look better")), "{in_files:?}");
        let mirrored = straight.missing(true);
        assert!(mirrored.iter().any(|t| t.contains("mirrored copies of the other side's 50 deg/s")), "{mirrored:?}");
        assert!(of(&[(60.0, 0.1, 0.0)]).missing(true)[0].starts_with("no walking"));
        assert!(of(&[(40.0, 1.0, 0.0), (2.0, 0.0, 0.0)]).missing(true)[0].starts_with("no start"));
        assert!(of(&[(10.0, 1.0, 0.0)]).missing(true)[0].starts_with("only 10 s of walking"));
        assert_eq!(of(&[]), Abilities::default());
        let back = of(&[(10.0, 1.0, 0.0), (40.0, -1.0, 0.0), (2.0, 0.0, 0.0), (9.0, -1.0, 50.0), (9.0, -1.0, -50.0)]);
        assert!((back.backwards_s - 58.0).abs() < 1.0 && (back.walking_s - 68.0).abs() < 1.0, "{back:?}");
        let missing = back.missing(true);
        assert!(missing.len() == 1 && missing[0].starts_with("hardly any walking ahead: 85 %"), "{missing:?}");
    }
}
