//! Motion that a graph takes: classes that belong together, so that nobody who walks ends in a bow or a crouch.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_core::format::{ClassSpan, Gait, MotionClass, Posture};
use throng_motion::clip::{Clip, ClipSet, FrameRange, runs_where};

/// Time up to which a body that begins or ends to go may stand otherwise than neutral (s).
const TRANSITION_S: f64 = 0.8;
/// Shortest motion that is worth taking (s).
const SHORTEST_S: f64 = 0.3;
/// Share of the motion that goes somewhere from which classes are enough; with less, a graph takes all there is.
const ENOUGH: f64 = 0.2;
/// Share of upright standing that has to be neutral, so that gestures may stay out: else hardly anybody could stand.
const NEUTRAL: f64 = 0.3;
/// Share of the upright motion that goes somewhere from which loads are no exception, but how people go here.
const MOSTLY: f64 = 0.5;
/// Most clips that are named.
pub(super) const MAX_NAMED_CLIPS: usize = 3;

/// Motion that a graph may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TakenMotion {
    /// Upright locomotion and neutral standing.
    Upright,
    /// Crouching and sneaking.
    Crouched,
    /// Sitting.
    Seated,
    /// Lying and crawling.
    Lying,
    /// Going with a load in the hands.
    Carrying,
    /// Standing that is not neutral, and jumps.
    Gestures,
    /// Gestures and jumps of clips that show blows; a behaviour with blows takes them by itself.
    Blows,
}

impl TakenMotion {
    /// All motion.
    pub const ALL: [Self; 6] =
        [Self::Upright, Self::Crouched, Self::Seated, Self::Lying, Self::Carrying, Self::Gestures];

    /// The name, as configs write it.
    fn name(self) -> &'static str {
        ["upright", "crouched", "seated", "lying", "carrying", "gestures", "blows"][self as usize]
    }

    /// Value that takes frames of a class; for gestures, blows or not.
    pub fn of_class(class: &MotionClass) -> Self {
        match (class.posture, class.gait) {
            (Posture::Crouched, _) | (_, Gait::Sneak) => Self::Crouched,
            (Posture::Seated, _) => Self::Seated,
            (Posture::Lying, _) => Self::Lying,
            _ if class.carrying => Self::Carrying,
            (_, Gait::Stand) if class.neutral => Self::Upright,
            (_, Gait::Stand | Gait::Other) => Self::Gestures,
            _ => Self::Upright,
        }
    }

    /// Value that takes frames of a clip.
    fn of_span(span: &ClassSpan, clip: &Clip) -> Self {
        match Self::of_class(&span.class) {
            Self::Gestures if !clip.hits.is_empty() => Self::Blows,
            what => what,
        }
    }
}

/// Motion that a graph leaves out, as it belongs to a class that is not taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MotionLeftOut {
    /// The value of `graph.take` that takes it.
    pub what: TakenMotion,
    /// Its duration, mirrored copies not counted (s).
    pub seconds: f64,
    /// A few clips with most of it.
    pub clips: Vec<String>,
}

impl std::fmt::Display for MotionLeftOut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (what, clips) = (self.what.name(), self.clips.join(", "));
        write!(f, "{what} {:.0} s, most in {clips} (`graph.take` with \"{what}\" takes it)", self.seconds)
    }
}

/// Frames that a graph takes.
pub(super) struct TakenFrames {
    /// Runs of frames of each clip.
    pub runs: Vec<Vec<FrameRange>>,
    pub left_out: Vec<MotionLeftOut>,
    /// Neutral and all upright standing, where so little of it is neutral that gestures are taken as well (s).
    pub scarce_neutral_s: Option<[f64; 2]>,
    /// Upright motion with a load and all that goes, where so much of it carries one that it is taken as well (s).
    pub mostly_carrying_s: Option<[f64; 2]>,
}

impl TakenFrames {
    /// Frames of the classes in `take`; all usable ones where these have hardly any motion that goes somewhere.
    pub fn new(clips: &ClipSet, take: &[TakenMotion]) -> Self {
        let [standing_s, carrying_s] = standing_and_carrying(clips);
        let leaves_loads = !take.contains(&TakenMotion::Carrying);
        let mostly_carrying_s = Some(carrying_s).filter(|[some, all]| leaves_loads && *some > MOSTLY * all);
        let is_scarce = !take.contains(&TakenMotion::Gestures) && standing_s[0] < NEUTRAL * standing_s[1];
        let scarce_neutral_s = is_scarce.then_some(standing_s);
        let more = [is_scarce.then_some(TakenMotion::Gestures), mostly_carrying_s.map(|_| TakenMotion::Carrying)];
        let take: &[TakenMotion] = &take.iter().copied().chain(more.into_iter().flatten()).collect::<Vec<_>>();
        let (mut going, mut taken_going) = (0, 0);
        let mut left = BTreeMap::<TakenMotion, BTreeMap<&str, f64>>::new();
        let mut runs = Vec::with_capacity(clips.clips.len());
        for clip in &clips.clips {
            let is_taken = taken_frames(clip, take);
            let mut of_clip = Vec::new();
            for run in clip.usable_ranges() {
                for f in run.clone() {
                    let Some(span) = clip.span_at(f) else { continue };
                    let goes = usize::from(!matches!(span.class.gait, Gait::Stand | Gait::Other));
                    going += goes;
                    taken_going += goes * usize::from(is_taken[f]);
                    if !is_taken[f] && !clip.mirrored {
                        let of = left.entry(TakenMotion::of_span(span, clip)).or_default();
                        *of.entry(&clip.name).or_default() += 1.0 / clip.rate_hz;
                    }
                }
                let least = (SHORTEST_S * clip.rate_hz).round() as usize;
                of_clip.extend(runs_where(run, |f| is_taken[f]).into_iter().filter(|r| r.len() >= least));
            }
            runs.push(of_clip);
        }
        if (taken_going as f64) < ENOUGH * going as f64 || going == 0 {
            let runs = clips.clips.iter().map(Clip::usable_ranges).collect();
            return Self { runs, left_out: Vec::new(), scarce_neutral_s: None, mostly_carrying_s: None };
        }
        let described = |(what, clips): (TakenMotion, BTreeMap<&str, f64>)| {
            let seconds = clips.values().sum();
            let mut most: Vec<(&str, f64)> = clips.into_iter().collect();
            most.sort_by(|a, b| b.1.total_cmp(&a.1));
            let clips = most.iter().take(MAX_NAMED_CLIPS).map(|(name, _)| (*name).to_owned()).collect();
            MotionLeftOut { what, seconds, clips }
        };
        Self { runs, left_out: left.into_iter().map(described).collect(), scarce_neutral_s, mostly_carrying_s }
    }
}

/// Neutral and all upright standing, then upright motion that carries and all that goes; mirrored copies not counted (s).
fn standing_and_carrying(clips: &ClipSet) -> [[f64; 2]; 2] {
    let mut out = [[0.0; 2]; 2];
    for clip in clips.clips.iter().filter(|c| !c.mirrored && !c.is_made()) {
        for span in clip.usable_ranges().into_iter().flatten().filter_map(|f| clip.span_at(f)) {
            let class = &span.class;
            if class.posture == Posture::Upright && class.gait != Gait::Other {
                let (of, counts) = if class.gait == Gait::Stand { (0, class.neutral) } else { (1, class.carrying) };
                out[of][0] += f64::from(u8::from(counts)) / clip.rate_hz;
                out[of][1] += 1.0 / clip.rate_hz;
            }
        }
    }
    out
}

/// True for every frame whose class is taken; all where classes are not known, and where motion was made as it is needed.
fn taken_frames(clip: &Clip, take: &[TakenMotion]) -> Vec<bool> {
    let mut out = vec![true; clip.num_frames()];
    if clip.is_made() {
        return out;
    }
    let has = |what| take.contains(&what);
    let goes = |span: Option<&ClassSpan>| {
        span.is_some_and(|s| TakenMotion::of_span(s, clip) == TakenMotion::Upright && s.class.gait != Gait::Stand)
    };
    for (i, span) in clip.classes.iter().enumerate() {
        let frames = span.frames.start as usize..span.frames.end as usize;
        let what = TakenMotion::of_span(span, clip);
        let stands = matches!(what, TakenMotion::Gestures | TakenMotion::Blows);
        let is_short = (frames.len() as f64) < TRANSITION_S * clip.rate_hz;
        let beside = [i.checked_sub(1), Some(i + 1)].map(|k| goes(k.and_then(|k| clip.classes.get(k))));
        let is_transition = stands && is_short && has(TakenMotion::Upright) && beside.contains(&true);
        let is_taken = has(what) || what == TakenMotion::Blows && has(TakenMotion::Gestures) || is_transition;
        out[frames].fill(is_taken);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};
    use throng_core::{NUM_JOINTS, Skeleton};

    /// A clip of spans of these lengths (frames at 30 Hz).
    fn set(spans: &[(usize, Posture, Gait, bool)]) -> ClipSet {
        let n = spans.iter().map(|s| s.0).sum();
        let mut clip = Clip::new("a", 30.0, vec![Vec3::Y; n], vec![Quat::IDENTITY; n * NUM_JOINTS]);
        let mut at = 0;
        for &(frames, posture, gait, neutral) in spans {
            let class = MotionClass { posture, gait, neutral, ..MotionClass::default() };
            clip.classes.push(ClassSpan { frames: at..at + frames as u32, class, ..ClassSpan::default() });
            at += frames as u32;
        }
        ClipSet { skeleton: Skeleton::default(), clips: vec![clip] }
    }

    /// All frames of a clip.
    fn whole(num_frames: usize) -> Vec<FrameRange> {
        std::iter::once(0..num_frames).collect()
    }

    #[test]
    fn gestures_and_other_postures_stay_out_and_short_ones_beside_steps_stay() {
        use Gait::{Stand, Walk};
        use Posture::{Crouched, Upright};
        let set = set(&[
            (60, Upright, Stand, true),
            (60, Upright, Stand, false),
            (30, Upright, Stand, true),
            (10, Upright, Stand, false),
            (90, Upright, Walk, false),
            (60, Crouched, Walk, false),
        ]);
        let taken = TakenFrames::new(&set, &[TakenMotion::Upright]);
        assert_eq!(taken.runs, [vec![0..60, 120..250]]);
        let left: Vec<(TakenMotion, f64)> = taken.left_out.iter().map(|l| (l.what, l.seconds.round())).collect();
        assert_eq!(left, [(TakenMotion::Crouched, 2.0), (TakenMotion::Gestures, 2.0)]);
        assert!(taken.left_out[0].to_string().contains("`graph.take` with \"crouched\""));
        let more = TakenFrames::new(&set, &[TakenMotion::Upright, TakenMotion::Gestures, TakenMotion::Crouched]);
        assert_eq!((more.runs, more.left_out), (vec![whole(310)], vec![]));
    }

    #[test]
    fn gestures_are_taken_where_hardly_any_standing_is_neutral() {
        use Posture::Upright;
        let spans =
            [(30, Upright, Gait::Stand, true), (150, Upright, Gait::Stand, false), (90, Upright, Gait::Walk, false)];
        let taken = TakenFrames::new(&set(&spans), &[TakenMotion::Upright]);
        assert_eq!(taken.runs, [whole(270)]);
        let [neutral, all] = taken.scarce_neutral_s.unwrap();
        assert!((neutral - 1.0).abs() < 1e-6 && (all - 6.0).abs() < 1e-6 && taken.left_out.is_empty());
    }

    #[test]
    fn loads_are_taken_where_most_walking_carries_one() {
        use Posture::Upright;
        let mut set = set(&[
            (60, Upright, Gait::Stand, true),
            (120, Upright, Gait::Walk, false),
            (90, Upright, Gait::Walk, false),
        ]);
        set.clips[0].classes[1].class.carrying = true;
        let taken = TakenFrames::new(&set, &[TakenMotion::Upright]);
        assert_eq!((taken.runs, taken.left_out.len()), (vec![whole(270)], 0));
        assert_eq!(taken.mostly_carrying_s.map(|s| s.map(f64::round)), Some([4.0, 7.0]));
        set.clips[0].classes[1].frames.end = 120;
        set.clips[0].classes[2].frames.start = 120;
        let taken = TakenFrames::new(&set, &[TakenMotion::Upright]);
        assert_eq!((taken.left_out.len(), taken.mostly_carrying_s), (1, None));
    }

    #[test]
    fn a_set_that_only_crouches_is_taken_whole() {
        let set = set(&[(60, Posture::Upright, Gait::Stand, true), (300, Posture::Crouched, Gait::Sneak, false)]);
        assert_eq!(TakenFrames::new(&set, &[TakenMotion::Upright]).runs, [whole(360)]);
    }
}
