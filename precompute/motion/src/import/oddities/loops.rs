//! Loops of a cycle or two, as games play them: repeated until there are whole steps between their ends.

use super::{JOINTS, RATE_HZ};
use crate::{import::roles::RoleMap, raw::RawClip, stance::FEET};
use glam::{Quat, Vec2, Vec3, Vec3Swizzles};
use throng_base::maths::{atan2, compose, rotate, rotation_y, slerp_f32};
use throng_core::{Joint, planar::wrap_angle};

/// Shortest and longest loop that is repeated (s).
const LENGTH_S: std::ops::RangeInclusive<f64> = 0.4..=3.2;
/// Times that a loop is played.
const TIMES: usize = 3;
/// Widest seam: mean turn of a joint, largest turn of a joint (deg), change of the height of the hips (m).
const SEAM: [f32; 3] = [2.0, 6.0, 0.03];
/// Most change of a joint's velocity over the seam: over the most elsewhere in the clip, and beside it (1, deg/s).
const JOLT: (f32, f32) = (1.5, 30.0);
/// Steps: least deviation of each foot from its mean place below the hips (m), and greatest correlation of both.
const STEPS: (f32, f32) = (0.04, -0.3);
/// Turn of a cycle below which it goes straight (rad).
const STRAIGHT: f32 = 0.05;

/// A clip whose last frame is the first one again, elsewhere.
struct Cycle {
    clip: RawClip,
    hips: usize,
    /// Mean turn of a joint from the last frame to the first (deg).
    gap_deg: f32,
    /// Turn about +Y and travel over the ground from the first frame to the last.
    heading: f32,
    travel: Vec3,
}

impl Cycle {
    /// Finds the cycle of a clip whose ends meet within [`SEAM`] and [`JOLT`].
    fn find(clip: RawClip, hips: usize, joints: &[usize]) -> Option<Self> {
        let (n, last) = (clip.joints.len(), clip.num_frames - 1);
        let stride = ((clip.rate_hz / RATE_HZ).round() as usize).clamp(1, last / 4);
        let world: Vec<(Vec3, Quat)> = (0..=last).map(|f| clip.world_of(hips, f)).collect();
        let ([a, b], turned) = ([world[0], world[last]], compose(world[last].1, world[0].1.inverse()));
        let heading =
            Some(wrap_angle(2.0 * atan2(turned.y, turned.w))).filter(|by| by.abs() > STRAIGHT).unwrap_or_default();
        let travel = (b.0 - rotate(rotation_y(heading), a.0)).with_y(0.0);
        // The hips turn with the body; all other joints turn below them.
        let rotation = |j: usize, f: usize| if j == hips { world[f].1 } else { clip.rotations[f * n + j] };
        let angle = |from: Quat, to: Quat| from.angle_between(to).to_degrees();
        let (mut sum, mut worst) = (0.0, 0.0f32);
        for &j in joints {
            let onto = if j == hips { rotation_y(heading) } else { Quat::IDENTITY };
            let gap = angle(compose(onto, rotation(j, 0)), rotation(j, last));
            (sum, worst) = (sum + gap, worst.max(gap));
            let velocity = |f: usize| compose(rotation(j, f).inverse(), rotation(j, f + stride));
            let changes = (0..=last - 2 * stride).map(|f| angle(velocity(f), velocity(f + stride)));
            let rate = clip.rate_hz as f32 / stride as f32;
            let most = JOLT.0 * changes.fold(0.0, f32::max) * rate + JOLT.1;
            if angle(velocity(last - stride), velocity(0)) * rate > most {
                return None;
            }
        }
        let gap_deg = sum / joints.len() as f32;
        let meets = gap_deg <= SEAM[0] && worst <= SEAM[1] && (b.0.y - a.0.y).abs() <= SEAM[2];
        meets.then_some(Self { clip, hips, gap_deg, heading, travel })
    }

    /// True where both feet step, by turns.
    fn steps(&self, roles: &RoleMap) -> bool {
        let at = |joint: usize, f: usize| self.clip.world_of(joint, f).0.xz();
        let way = |foot: Joint| -> Option<Vec<Vec2>> {
            let foot = roles.get(foot)?;
            let way: Vec<Vec2> = (0..self.clip.num_frames).map(|f| at(foot, f) - at(self.hips, f)).collect();
            let middle = way.iter().sum::<Vec2>() / way.len() as f32;
            Some(way.into_iter().map(|v| v - middle).collect())
        };
        let (Some(left), Some(right)) = (way(FEET[0]), way(FEET[2])) else { return false };
        let mean = |a: &[Vec2], b: &[Vec2]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f32>() / a.len() as f32;
        let reach = [&left, &right].map(|way| mean(way, way).sqrt());
        reach.iter().all(|m| *m > STEPS.0) && mean(&left, &right) < STEPS.1 * reach[0] * reach[1]
    }

    /// The cycle so many times, one after the other, with a last frame that is like the first.
    fn repeat(self, times: usize) -> RawClip {
        let Self { clip, hips, heading, travel, .. } = self;
        let (n, period) = (clip.joints.len(), clip.num_frames - 1);
        let above = |j: usize| std::iter::successors(clip.joints[j].parent, |&p| clip.joints[p].parent);
        let below: Vec<bool> = (0..n).map(|j| above(j).any(|p| p == hips)).collect();
        // What is left at the seam is spread over the cycle.
        let [a, b] = [0, period].map(|f| clip.world_of(hips, f));
        let turn = rotation_y(heading);
        let rise = rotate(turn, a.0) + travel - b.0;
        let closing = |j: usize| match j {
            _ if j == hips => compose(b.1.inverse(), compose(turn, a.1)),
            _ if below[j] => compose(clip.rotations[period * n + j].inverse(), clip.rotations[j]),
            _ => Quat::IDENTITY,
        };
        let closing: Vec<Quat> = (0..n).map(closing).collect();
        let (mut translations, mut rotations, mut turned, mut gone) = (Vec::new(), Vec::new(), 0.0, Vec3::ZERO);
        for i in 0..=times * period {
            if i > 0 && i % period == 0 {
                gone += rotate(rotation_y(turned), travel);
                turned += heading;
            }
            let (first, share) = (i % period * n, (i % period) as f32 / period as f32);
            for j in 0..n {
                let (mut at, turn) = (clip.translations[first + j], rotation_y(turned));
                let mut rotation = compose(clip.rotations[first + j], slerp_f32(Quat::IDENTITY, closing[j], share));
                if below[j] {
                    at += share * (clip.translations[j] - clip.translations[period * n + j]);
                } else if clip.joints[j].parent.is_none() {
                    (at, rotation) = (rotate(turn, at + share * rise) + gone, compose(turn, rotation));
                }
                translations.push(at);
                rotations.push(rotation);
            }
        }
        RawClip { num_frames: times * period + 1, translations, rotations, ..clip }
    }
}

/// A clip with one frame more, in which all go on as in the last one.
fn with_next_frame(clip: &RawClip) -> RawClip {
    let (mut out, n) = (clip.clone(), clip.joints.len());
    let last = (clip.num_frames - 1) * n;
    for at in last..last + n {
        let by = compose(clip.rotations[at - n].inverse(), clip.rotations[at]);
        out.rotations.push(compose(clip.rotations[at], by));
        out.translations.push(2.0 * clip.translations[at] - clip.translations[at - n]);
    }
    out.num_frames += 1;
    out
}

/// Repeats a loop that steps, and tells it: its ends are made to meet, and the body goes on from where it got to.
pub(in crate::import) fn unroll_loop(clip: &mut RawClip, roles: &RoleMap) -> Option<String> {
    if clip.num_frames < 8 || !LENGTH_S.contains(&(clip.num_frames as f64 / clip.rate_hz)) {
        return None;
    }
    let hips = roles.get(Joint::Hips)?;
    let joints: Vec<usize> = JOINTS.into_iter().filter_map(|j| roles.get(j)).collect();
    // The last frame is the first one again, or the one before it.
    let cycles = [clip.clone(), with_next_frame(clip)].into_iter().filter_map(|c| Cycle::find(c, hips, &joints));
    let cycle = cycles.min_by(|a, b| a.gap_deg.total_cmp(&b.gap_deg)).filter(|cycle| cycle.steps(roles))?;
    let (seconds, gap) = ((cycle.clip.num_frames - 1) as f64 / clip.rate_hz, cycle.gap_deg);
    *clip = cycle.repeat(TIMES);
    Some(format!("a loop of {seconds:.1} s, whose ends are {gap:.1} deg a joint apart: it is played {TIMES} times"))
}
