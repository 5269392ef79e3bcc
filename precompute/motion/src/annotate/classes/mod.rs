//! Class of motion of every frame: posture, gait, manner, standing neutral or gesturing, carrying.

mod hints;
mod signals;
#[cfg(test)]
mod tests;

pub use hints::{NO_MANNER, NameHints, NamedClass};
pub use throng_core::format::{ClassSpan, Gait, MotionClass, Posture};

use crate::clip::{Clip, FrameRange};
use signals::Signals;
use throng_base::maths::quantile;
use throng_base::thresholds::{NAMED_IDLE_MOVES_MPS, RUNS_MPS, STANDING_MPS, SURELY_RUNS_MPS, WALKING_MPS};
use throng_core::Skeleton;

/// Shortest span of a posture or a gait; shorter ones become part of their neighbours (s).
const SHORTEST_S: f64 = 0.4;
/// Shortest span of carrying (s).
const CARRYING_S: f64 = 0.8;
/// Shortest span of standing neutral, and of a gesture without a bow (s).
const NEUTRAL_S: f64 = 0.5;
/// Distance below which a body that moves stays where it is: it sways, or shifts its weight (m).
const SWAY_M: f32 = 0.45;
/// Angle between travel and front from which a body goes sideways, and backwards (degrees).
const SIDE_DEG: [f32; 2] = [29.0, 120.0];
/// Angle from which a body goes sideways whose name says so (degrees).
const NAMED_SIDE_DEG: f32 = 18.0;
/// Height of the hips over the feet, relative to that of standing, below which a body crouches: standing or walking, running,
/// and where its name says so.
const CROUCHED: [f32; 3] = [0.78, 0.7, 0.88];
/// The height below which a body sits or lies.
const LOW: f32 = 0.72;
/// Way from the feet to the hips over the ground from which the seat carries a low body, not the feet (legs).
const BEHIND: f32 = 0.33;
/// Lean of the trunk from which a low body lies or crawls (degrees).
const LEVEL_DEG: f32 = 50.0;
/// Arms, trunk and hips of neutral standing: angle of the arms from straight down, lean (degrees), speed of the hands
/// relative to the hips (m/s), height of the hips, distance of the feet (m). By names: unknown, idle, gesture.
const NEUTRAL: [[f32; 5]; 3] =
    [[40.0, 30.0, 0.35, 0.88, 0.55], [60.0, 40.0, 0.6, 0.8, 0.7], [30.0, 30.0, 0.3, 0.88, 0.55]];
/// Lean beyond that of upright standing in the clip from which it is a bow (degrees).
const BOW_DEG: f32 = 12.0;
/// Change of the distance between hands below which they hold one load (m).
const HELD_M: f32 = 0.014;
/// Bend of the elbows from which hands hold something, and how far they are ahead of the chest (degrees, m).
const HOLDING: (f32, f32) = (50.0, 0.04);

/// Manners that motion alone tells: trunk, arms and hips of somebody who goes somewhere with a purpose of his own.
pub const HELD_OTHERWISE: [&str; 3] = ["bent", "arms-out", "low"];

/// Manner of motion that its name gives; empty where motion alone tells one.
pub fn named_manner(manner: &str) -> &str {
    if HELD_OTHERWISE.contains(&manner) { "" } else { manner }
}

/// True for a gait that goes somewhere.
pub fn goes_somewhere(class: &MotionClass) -> bool {
    !matches!(class.gait, Gait::Stand | Gait::Other)
}

/// Class of one frame, before its manner is known.
type FrameClass = (Posture, Gait, bool, bool);

/// Finds the class of every frame of a clip, from its motion; names tip the balance where motion says little.
pub fn classify(clip: &Clip, skeleton: &Skeleton, hints: &NameHints) -> Vec<ClassSpan> {
    let s = Signals::of_clip(clip, skeleton);
    let frames = |seconds: f64| ((seconds * clip.rate_hz).round() as usize).max(1);
    let n = clip.num_frames();
    let mut moves = moving(&s, frames(0.2));
    // Who idles may sway and step, but walks nowhere.
    if hints.idle && !hints.walk && !hints.run {
        moves.iter_mut().zip(&s.speed).for_each(|(moves, speed)| *moves &= *speed > NAMED_IDLE_MOVES_MPS);
    }
    let mut gaits: Vec<Gait> = (0..n).map(|f| gait(&s, f, moves[f], hints)).collect();
    let mut postures: Vec<Posture> = (0..n).map(|f| posture(&s, f, gaits[f], hints)).collect();
    absorb_short_runs(&mut gaits, frames(SHORTEST_S));
    absorb_short_runs(&mut postures, frames(SHORTEST_S));
    let named = &hints.named;
    named.posture.iter().for_each(|named| postures.fill(*named));
    for (gait, posture) in gaits.iter_mut().zip(&postures) {
        let is_low = *posture == Posture::Crouched || hints.sneak && *posture == Posture::Upright;
        if *gait == Gait::Walk && is_low {
            *gait = Gait::Sneak;
        } else if *posture == Posture::Seated && *gait != Gait::Other {
            *gait = Gait::Stand;
        }
    }
    named.gait.iter().for_each(|named| gaits.fill(*named));
    let stands = |f: &usize| gaits[*f] == Gait::Stand && postures[*f] == Posture::Upright;
    // Old and tired people stand bent all the time.
    let usual_deg = quantile((0..n).filter(stands).map(|f| s.lean_deg[f]), [1, 8]).unwrap_or_default();
    let limits = NEUTRAL[if hints.gesture { 2 } else { usize::from(hints.idle) }];
    // A walk on the spot is no rest, whatever its hips do.
    let steps = (hints.walk || hints.run) && !hints.idle && !moves.contains(&true);
    let mut neutral: Vec<bool> = (0..n).map(|f| stands(&f) && !steps && s.is_at_rest(f, limits)).collect();
    let mut carrying: Vec<bool> = (0..n).map(|f| carries(&s, f, hints)).collect();
    absorb_short_runs(&mut neutral, frames(NEUTRAL_S));
    neutral.iter_mut().zip(&s.lean_deg).for_each(|(neutral, deg)| *neutral &= hints.idle || deg - usual_deg < BOW_DEG);
    for run in runs_of(n, |f| neutral[f]).into_iter().filter(|r| r.len() < frames(NEUTRAL_S).min(n)) {
        neutral[run].fill(false);
    }
    absorb_short_runs(&mut carrying, frames(CARRYING_S));
    named.neutral.iter().for_each(|named| neutral.fill(*named));
    named.carrying.iter().for_each(|named| carrying.fill(*named));
    let class = |f: usize| -> FrameClass {
        let stands = gaits[f] == Gait::Stand && postures[f] == Posture::Upright;
        (postures[f], gaits[f], neutral[f] && stands && !carrying[f], carrying[f])
    };
    let mut out: Vec<ClassSpan> = Vec::new();
    for run in runs_of(n, |f| (postures[f], gaits[f])) {
        let manner = match named.manner.as_ref().or(hints.manner.as_ref()) {
            Some(manner) => manner.clone(),
            None => s.manner(run.clone(), gaits[run.start]).to_owned(),
        };
        for part in runs_of(run.len(), |f| class(run.start + f)) {
            let part = run.start + part.start..run.start + part.end;
            let (posture, gait, neutral, carrying) = class(part.start);
            let manner = manner.clone();
            out.push(s.span(part, MotionClass { posture, gait, neutral, carrying, manner }));
        }
    }
    out
}

/// True for the frames in which a body goes somewhere.
fn moving(s: &Signals, half: usize) -> Vec<bool> {
    let n = s.speed.len();
    let mut out = vec![false; n];
    for run in crate::clip::runs_where(0..n, |f| s.speed[f] > 0.5 * (STANDING_MPS + WALKING_MPS)) {
        let is_fast = run.clone().any(|f| s.speed[f] > WALKING_MPS);
        let (first, last) = (run.start.saturating_sub(half), (run.end + half).min(n - 1));
        if is_fast && run.clone().any(|f| s.distance_between(first, f).max(s.distance_between(f, last)) > SWAY_M) {
            out[run].fill(true);
        }
    }
    out
}

fn gait(s: &Signals, f: usize, moves: bool, hints: &NameHints) -> Gait {
    if s.airborne[f] {
        return Gait::Other;
    }
    if !moves {
        return Gait::Stand;
    }
    let (turn, side) = (s.travel_deg[f].abs(), if hints.side { NAMED_SIDE_DEG } else { SIDE_DEG[0] });
    let kind = if hints.walk == hints.run { 0 } else { 1 + usize::from(hints.run) };
    match s.speed[f] {
        _ if turn > SIDE_DEG[1] => Gait::Backwards,
        speed if speed > SURELY_RUNS_MPS || speed + s.bounce[f] > RUNS_MPS[kind] && turn < 2.0 * SIDE_DEG[0] => {
            Gait::Run
        }
        _ if turn > side => Gait::Strafe,
        _ => Gait::Walk,
    }
}

fn posture(s: &Signals, f: usize, gait: Gait, hints: &NameHints) -> Posture {
    let height = s.height[f];
    let crouched = match gait {
        _ if hints.crouch || hints.sneak => CROUCHED[2],
        Gait::Run | Gait::Other => CROUCHED[1],
        _ => CROUCHED[0],
    };
    if height < LOW && s.lean_deg[f] > LEVEL_DEG {
        return Posture::Lying;
    }
    let is_behind = s.behind[f] > BEHIND || hints.seat && s.behind[f] > 0.6 * BEHIND;
    match height < LOW && is_behind && s.speed[f] < WALKING_MPS {
        true => Posture::Seated,
        false if height < crouched => Posture::Crouched,
        false => Posture::Upright,
    }
}

/// True where both hands hold a load, or one does by its name.
fn carries(s: &Signals, f: usize, hints: &NameHints) -> bool {
    let [left, right] = s.elbow_deg[f];
    let goes = s.speed[f] > WALKING_MPS;
    let (bend, ahead) = HOLDING;
    let both = goes && s.gap_change[f] < HELD_M && 0.5 * (left + right) > bend && s.hands_ahead[f] > ahead;
    both && s.arm_deg[f].iter().all(|a| *a < 75.0) || hints.carry && goes && left.max(right) > 0.8 * bend
}

/// The longest runs of frames with one value, in order.
fn runs_of<T: PartialEq>(num_frames: usize, value: impl Fn(usize) -> T) -> Vec<FrameRange> {
    let mut out: Vec<FrameRange> = Vec::new();
    for f in 0..num_frames {
        match out.last_mut() {
            Some(run) if value(run.start) == value(f) => run.end = f + 1,
            _ => out.push(f..f + 1),
        }
    }
    out
}

/// Gives runs that are shorter than `least` the value of their longer neighbour, the shortest first.
fn absorb_short_runs<T: PartialEq + Copy>(values: &mut [T], least: usize) {
    let mut runs: Vec<(T, usize)> =
        runs_of(values.len(), |f| values[f]).into_iter().map(|r| (values[r.start], r.len())).collect();
    while let Some(i) = (0..runs.len()).filter(|&i| runs[i].1 < least).min_by_key(|&i| runs[i].1) {
        let beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten().filter(|&k| k < runs.len());
        let Some(longest) = beside.max_by_key(|&k| runs[k].1) else { break };
        runs[i].0 = runs[longest].0;
        runs.dedup_by(|b, a| {
            let same = a.0 == b.0;
            a.1 += if same { b.1 } else { 0 };
            same
        });
    }
    let absorbed = runs.into_iter().flat_map(|(value, len)| std::iter::repeat_n(value, len));
    values.iter_mut().zip(absorbed).for_each(|(value, absorbed)| *value = absorbed);
}
