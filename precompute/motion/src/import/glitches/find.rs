//! Looks for glitches in the tracks of a body: place of the hips, turns of all joints, lengths of segments.

use super::signal::{Deviation, TrackValue, sharp_moves, spikes, steps};
use super::{Glitch, GlitchKind, GlitchTreatment};
use crate::clip::{FrameRange, runs_where};
use crate::{import::roles::RoleMap, raw::RawClip};
use glam::{Quat, Vec3};
use throng_base::{maths, thresholds::JOINT_MOVES_MPS};
use throng_core::Joint;

/// Time within which a departure that comes back is a fault (s).
const MAX_POP: f64 = 0.1;
/// Time within which a flip has to be taken back to count as one glitch (s).
const MAX_FLIP: f64 = 1.0;
/// Longest part at an end that stands apart from the motion (s).
const MAX_EDGE: f64 = 0.25;
/// Least time for which a body that stops dead is frozen (s).
const MIN_FREEZE: f64 = 0.08;
/// Turn of a single frame between even ones that is a fault (degrees).
const SHARP_TURN: f32 = 25.0;
/// Motion and turn of all joints from frame to frame below which a body is frozen (m, rad).
const FROZEN: (f32, f32) = (1e-5, 3e-4);
/// Speed of a moving body, which does not stop within a frame (m/s, rad/s).
const MOVING: (f32, f32) = (JOINT_MOVES_MPS, 1.2);
/// Share of that speed at the ends of a clip.
const AT_ENDS: f32 = 0.15;

/// The tracks of one clip.
struct BodyTracks {
    /// Joint, its turns relative to the joint that it hangs on, and its position in the frame of that joint. The hips are in
    /// the world.
    joints: Vec<(Joint, Vec<Quat>, Vec<Vec3>)>,
    rate_hz: f64,
    num_frames: usize,
}

/// All glitches, in order, none overlapping.
pub fn find_glitches(clip: &RawClip, roles: &RoleMap) -> Vec<Glitch> {
    if clip.num_frames < 4 {
        return Vec::new();
    }
    let mut tracks = BodyTracks::from_clip(clip, roles);
    let mut all = drop_outs(clip);
    for g in &all {
        tracks.bridge_frames(g.frames.start, g.frames.end);
    }
    all.extend(tracks.freezes());
    all.extend(tracks.edges());
    for g in &all {
        tracks.bridge_frames(g.frames.start, g.frames.end);
    }
    all.extend(tracks.pops(clip, roles));
    all.extend(tracks.jumps(clip, roles));
    merge_glitches(all)
}

/// The least turn that is a fault, given that of limbs (degrees); head, hands and toes shake more.
/// (rad)
fn least_turn(j: Joint, degrees: f32) -> f32 {
    if carries_nothing(j) { degrees.max(75.0) } else { degrees }.to_radians()
}

fn carries_nothing(j: Joint) -> bool {
    use Joint::*;
    matches!(j, Head | LeftHand | RightHand | LeftToe | RightToe)
}

fn glitch(kind: GlitchKind, start: usize, end: usize, what: String) -> Glitch {
    Glitch { kind, frames: start..end, joints: Vec::new(), what, treated: GlitchTreatment::Kept }
}

/// The joints of the file that lead to a role from the one above it.
fn path_to_role(clip: &RawClip, roles: &RoleMap, j: Joint) -> Vec<usize> {
    let above = parent_role_joint(roles, j);
    let up = std::iter::successors(roles.get(j), |&k| clip.joints[k].parent);
    up.take_while(|&k| Some(k) != above).collect()
}

/// The joint of the nearest role above.
fn parent_role_joint(roles: &RoleMap, j: Joint) -> Option<usize> {
    std::iter::successors(j.parent(), |p| p.parent()).find_map(|p| roles.get(p))
}

/// Sorts glitches, and merges those that overlap or touch; the words of the first one stay.
fn merge_glitches(mut all: Vec<Glitch>) -> Vec<Glitch> {
    all.retain(|g| !g.frames.is_empty());
    all.sort_by_key(|g| (g.frames.start, g.kind, g.frames.end));
    let mut out: Vec<Glitch> = Vec::new();
    for g in all {
        match out.last_mut() {
            Some(last) if g.frames.start <= last.frames.end => {
                last.frames.end = last.frames.end.max(g.frames.end);
                last.kind = last.kind.max(g.kind);
                // An empty list stands for all joints.
                if last.joints.is_empty() || g.joints.is_empty() {
                    last.joints.clear();
                } else {
                    last.joints.extend(g.joints);
                    last.joints.sort_unstable();
                    last.joints.dedup();
                }
            }
            _ => out.push(g),
        }
    }
    out
}

/// Frames in which every number of the file is zero, in a clip where that is not the rule, between frames in which the body is
/// elsewhere: at the ends, and where the body stays in place, such a frame is a pose of rest.
fn drop_outs(clip: &RawClip) -> Vec<Glitch> {
    let n = clip.joints.len();
    let roots: Vec<usize> = (0..n).filter(|&j| clip.joints[j].parent.is_none()).collect();
    let at_zero = |f: usize| roots.iter().all(|&j| clip.translations[f * n + j].length() < 1e-6);
    let unturned = |f: usize| clip.rotations[f * n..(f + 1) * n].iter().all(|r| r.xyz().length() < 1e-6);
    let zero: Vec<bool> = (0..clip.num_frames).map(|f| at_zero(f) && unturned(f)).collect();
    let count = zero.iter().filter(|z| **z).count();
    if count == 0 || count * 2 > clip.num_frames {
        return Vec::new();
    }
    let is_away = |f: usize| f < clip.num_frames && !at_zero(f);
    let inner = |r: &FrameRange| r.start.checked_sub(1).is_some_and(is_away) && is_away(r.end);
    let all = runs_where(0..clip.num_frames, |f| zero[f]).into_iter().filter(inner);
    all.map(|r| glitch(GlitchKind::DropOut, r.start, r.end, "all numbers are zero".into())).collect()
}

impl BodyTracks {
    fn from_clip(clip: &RawClip, roles: &RoleMap) -> Self {
        let mut joints: Vec<(Joint, Vec<Quat>, Vec<Vec3>)> = Joint::ALL
            .into_iter()
            .filter(|&j| roles.get(j).is_some())
            .map(|j| (j, Vec::with_capacity(clip.num_frames), Vec::with_capacity(clip.num_frames)))
            .collect();
        for f in 0..clip.num_frames {
            let world = clip.world(f);
            for (j, turns, places) in &mut joints {
                let Some((at, turn)) = roles.get(*j).map(|k| world[k]) else { continue };
                let (origin, axes) = parent_role_joint(roles, *j).map_or((Vec3::ZERO, Quat::IDENTITY), |a| world[a]);
                turns.push(maths::compose(axes.inverse(), turn).normalize());
                places.push(axes.inverse() * (at - origin));
            }
        }
        Self { joints, rate_hz: clip.rate_hz, num_frames: clip.num_frames }
    }

    fn frames(&self, seconds: f64) -> usize {
        (seconds * self.rate_hz).round() as usize
    }

    /// Bridges all tracks over some frames, so that these are not found again.
    fn bridge_frames(&mut self, start: usize, end: usize) {
        let n = self.num_frames;
        let (before, after) = (start.checked_sub(1), Some(end).filter(|&f| f < n));
        let (Some(a), Some(b)) = (before.or(after), after.or(before)) else { return };
        for (_, turns, places) in &mut self.joints {
            for f in start..end {
                let ratio = (f + 1 - start) as f32 / (end - start + 1) as f32;
                turns[f] = turns[a].towards(turns[b], ratio);
                places[f] = places[a].towards(places[b], ratio);
            }
        }
    }

    /// Travel of the hips, and the largest turn of a joint, from the frame before to this one.
    fn largest_step(&self, f: usize) -> (f32, f32) {
        let turn = |(_, turns, _): &(Joint, Vec<Quat>, Vec<Vec3>)| turns[f].apart(turns[f - 1]);
        let travel = self.joints.first().map_or(0.0, |(_, _, p)| p[f].apart(p[f - 1]));
        (travel, self.joints.iter().map(turn).fold(0.0, f32::max))
    }

    /// Finds stretches in the middle of motion in which nothing moves from one frame to the next.
    fn freezes(&self) -> Vec<Glitch> {
        let steps: Vec<(f32, f32)> =
            (0..self.num_frames).map(|f| if f == 0 { (1.0, 1.0) } else { self.largest_step(f) }).collect();
        let rate = self.rate_hz as f32;
        let still = |f: usize| steps[f].0 < FROZEN.0 && steps[f].1 < FROZEN.1;
        let moves = |f: usize, share: f32| {
            steps.get(f).is_some_and(|s| s.0 * rate > share * MOVING.0 || s.1 * rate > share * MOVING.1)
        };
        let long = self.frames(MIN_FREEZE).max(3);
        let found = |r: FrameRange| {
            // Where the data stop at an end, even a standing body swayed a little before.
            let share = if r.start == 1 || r.end == self.num_frames { AT_ENDS } else { 1.0 };
            let (before, after) = (r.start > 1 && moves(r.start - 1, share), moves(r.end, share));
            let (kind, what) = match r {
                _ if r.len() < long && moves(r.start - 1, 1.0) && moves(r.end, 1.0) => {
                    (GlitchKind::Repeat, "repeats the one before")
                }
                _ if r.len() < long || !(before || after) => return None,
                _ if r.start == 1 => (GlitchKind::Freeze, "a pose is held before the motion begins"),
                _ if r.end == self.num_frames => (GlitchKind::Freeze, "nothing moves any more"),
                _ => (GlitchKind::Freeze, "nothing moves in the middle of motion"),
            };
            Some(glitch(kind, r.start, r.end, what.into()))
        };
        runs_where(1..self.num_frames, still).into_iter().filter_map(found).collect()
    }

    /// Finds poses at the start or end that the motion does not lead to.
    fn edges(&self) -> Vec<Glitch> {
        let n = self.num_frames;
        // Sum of the turns of all joints, and the largest.
        let total = |f: usize| self.joints.iter().map(|(_, turns, _)| turns[f].apart(turns[f - 1])).sum::<f32>();
        let edge = self.frames(MAX_EDGE).max(1);
        let leaps = |k: usize, next_to_it: FrameRange| {
            let pace = next_to_it.map(total).fold(0.0, f32::max);
            total(k) > 4.0 * pace + 1.0 && self.largest_step(k).1 > 0.45
        };
        let apart =
            |start: usize, end: usize| glitch(GlitchKind::Apart, start, end, "a pose apart from the motion".into());
        let first = (1..=edge.min(n.saturating_sub(6))).rev().find(|&k| leaps(k, k + 1..k + 5)).map(|k| apart(0, k));
        let last = (n.saturating_sub(edge).max(6)..n).find(|&k| leaps(k, k - 4..k)).map(|k| apart(k, n));
        first.into_iter().chain(last).collect()
    }

    /// Finds joints that leave their paths for a few frames, and bridges them.
    fn pops(&mut self, clip: &RawClip, roles: &RoleMap) -> Vec<Glitch> {
        let longest = self.frames(MAX_POP).clamp(1, 12);
        let rate = self.rate_hz as f32;
        let (far, turned) = (0.03 + 1.5 / rate, 20.0 + 1200.0 / rate);
        let mut out = Vec::new();
        for (j, turns, places) in &mut self.joints {
            let name = roles.get(*j).map_or("", |k| clip.joints[k].name.as_str());
            let joints = path_to_role(clip, roles, *j);
            let mut add = |kind, away: Deviation, what| {
                out.push(Glitch { joints: joints.clone(), ..glitch(kind, away.start, away.end, what) });
            };
            for away in spikes(places, longest, far) {
                add(GlitchKind::Pop, away, format!("`{name}` is {:.2} m away and back again", away.distance));
            }
            let mut flips = spikes(turns, longest, least_turn(*j, turned));
            if !carries_nothing(*j) {
                flips.extend(sharp_moves(turns, SHARP_TURN.to_radians()));
            }
            for away in flips {
                let what = format!("`{name}` turns by {:.0} degrees and back", away.distance.to_degrees());
                add(GlitchKind::Flip, away, what);
            }
        }
        out
    }

    /// Finds jumps from one frame to the next: the two frames, or all up to the frame at which the joint is back.
    fn jumps(&self, clip: &RawClip, roles: &RoleMap) -> Vec<Glitch> {
        let rate = self.rate_hz as f32;
        let (far, turned) = (0.1 + 3.0 / rate, 20.0 + 2100.0 / rate);
        let mut out = Vec::new();
        for (j, turns, places) in &self.joints {
            let name = roles.get(*j).map_or("", |k| clip.joints[k].name.as_str());
            for step in steps(places, far) {
                let what = format!("`{name}` jumps by {:.2} m", step.distance);
                out.push(self.at_step(step.start, GlitchKind::Jump, what));
            }
            let mut leaps = steps(turns, least_turn(*j, turned)).into_iter().peekable();
            while let Some(step) = leaps.next() {
                let what = format!("`{name}` turns by {:.0} degrees in a frame", step.distance.to_degrees());
                let back = leaps.peek().filter(|b| {
                    let near = turns[step.start - 1].apart(turns[b.start]) < 0.5 * step.distance;
                    near && b.start - step.start <= self.frames(MAX_FLIP)
                });
                let joints = path_to_role(clip, roles, *j);
                out.push(match back {
                    Some(back) => Glitch { joints, ..glitch(GlitchKind::Flip, step.start, back.start, what) },
                    // No other joint hangs on it: its turn can be spread over a few frames.
                    None if carries_nothing(*j) => {
                        Glitch { joints, ..self.at_step(step.start, GlitchKind::Flip, what) }
                    }
                    None => self.at_step(step.start, GlitchKind::Jump, what),
                });
                if back.is_some() {
                    leaps.next();
                }
            }
        }
        out
    }

    /// The two frames around a step, or all up to the end of the clip where that is near.
    fn at_step(&self, f: usize, kind: GlitchKind, what: String) -> Glitch {
        let edge = self.frames(MAX_EDGE);
        if f <= edge {
            glitch(GlitchKind::Apart, 0, f, what)
        } else if f + edge >= self.num_frames {
            glitch(GlitchKind::Apart, f, self.num_frames, what)
        } else {
            glitch(kind, f - 1, f + 1, what)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_at_an_end_is_not_in_the_middle() {
        let told = |held: std::ops::Range<usize>| {
            let places =
                (0..60usize).map(|f| Vec3::X * (0.03 * (f.min(held.start) + f.saturating_sub(held.end)) as f32));
            let joints = vec![(Joint::Hips, vec![Quat::IDENTITY; 60], places.collect())];
            let found = BodyTracks { joints, rate_hz: 30.0, num_frames: 60 }.freezes();
            assert_eq!(found.len(), 1);
            found[0].what.clone()
        };
        assert_eq!(told(0..20), "a pose is held before the motion begins");
        assert_eq!(told(20..40), "nothing moves in the middle of motion");
        assert_eq!(told(40..60), "nothing moves any more");
    }

    #[test]
    fn glitches_that_touch_are_one_that_has_each_joint_once() {
        let of = |f: usize| Glitch { joints: vec![3, 2], ..glitch(GlitchKind::Pop, f, f + 1, String::new()) };
        let one = merge_glitches((0..5).map(of).collect());
        assert_eq!((one.len(), &one[0].frames, &one[0].joints[..]), (1, &(0..5), &[2, 3][..]));
    }
}
