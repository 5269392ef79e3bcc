//! Long stands, made of short stretches in which somebody stands at ease: played to and fro, ever slower than captured,
//! over feet that stay, with the sway and the breath of people who wait.

use super::feet::{MadeFoot, foot_point};
use super::stance::{RestStance, cut};
use super::stepping::{CoursePose, reach_feet};
use super::{MadeMotion, MotionMaker, smooth};
use crate::share::{clip_owners, sort_by_owner};
use crate::stops::idle_frames_left;
use glam::{Quat, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use std::{cmp::Reverse, f32::consts::TAU};
use throng_base::{Comm, maths};
use throng_core::{Contacts, Joint, NUM_JOINTS, Skeleton, format::MotionClass};
use throng_motion::{Clip, ClipSet, Result};

/// Length of a captured stand that repeats itself seldom enough, and time of such stands that is enough (s).
const LONG_S: f64 = 6.0;
const ENOUGH_S: f64 = 30.0;
/// Shortest stretch that a stand is made of (s).
const SHORTEST_S: f64 = 0.7;
/// Most stands that are made, and the least time of each (s).
const MAX_STANDS: usize = 6;
const STAND_S: f32 = 14.0;
/// Largest share of the captured rate, and least time of a way to or fro (s).
const RATE: f32 = 0.7;
const WAY_S: f32 = 2.6;
/// Time in which the sway begins and ends (s).
const FADE_S: f32 = 1.5;
/// Least and greatest distance of the hips ahead of the balls of the feet, and to a side, at which a body is in balance (m).
const BALANCED_M: [f32; 2] = [-0.14, -0.06];
const BALANCED_ASIDE_M: f32 = 0.06;
/// Sways of the hips aside and ahead, turns of the head, and breaths of the chest: size (m, m, rad, rad) and period (s).
const SWAYS: [(f32, [f32; 2]); 4] =
    [(0.016, [8.0, 12.0]), (0.006, [5.0, 8.0]), (0.07, [9.0, 14.0]), (0.008, [3.4, 4.2])];

/// Makes long stands where clips have short ones alone.
///
/// - `comm`: processes that hold the other poses.
///
/// # Errors
/// Faults of the exchange between processes.
pub fn make_stands(clips: &ClipSet, mirrored: bool, comm: &dyn Comm) -> Result<MadeMotion> {
    let found = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), |c| {
        let clip = &clips.clips[c];
        if clip.mirrored { (None, 0.0) } else { longest_stretch(clip, &clips.skeleton) }
    })?;
    let mut made = MadeMotion::default();
    if found.iter().map(|(_, long_s)| long_s).sum::<f64>() >= ENOUGH_S {
        return Ok(made);
    }
    let mut all: Vec<RestStance> = found.into_iter().filter_map(|(stretch, _)| stretch).collect();
    all.sort_by_key(|s| Reverse(s.clip.num_frames()));
    let prolong = |(k, s): (usize, &RestStance)| s.prolong(&clips.skeleton, STAND_S, k as u64);
    let all: Vec<RestStance> = all.iter().take(MAX_STANDS).enumerate().map(prolong).collect();
    let mut maker = MotionMaker::new(&clips.skeleton, mirrored, &mut made);
    maker.make_stands("idle", &all);
    Ok(made)
}

/// Offset of the hips from where they are to where they balance over the balls of the feet (m).
fn offset_to_balance(hips: Vec3, feet: &[MadeFoot; 2], ahead: Vec3) -> Vec3 {
    let off = hips - 0.5 * (feet[0].toe + feet[1].toe);
    let across = Vec3::Y.cross(ahead);
    let [along, aside] = [ahead, across].map(|axis| off.dot(axis));
    let [back, forth] = BALANCED_M;
    ahead * (along.clamp(back, forth) - along) + across * (aside.clamp(-BALANCED_ASIDE_M, BALANCED_ASIDE_M) - aside)
}

/// The longest idle stretch of a clip, if it is long enough, and the time of those that repeat themselves seldom (s).
fn longest_stretch(clip: &Clip, skeleton: &Skeleton) -> (Option<RestStance>, f64) {
    let left = idle_frames_left(clip, skeleton);
    let frames = |seconds: f64| (seconds * clip.rate_hz) as u32;
    let begins = |f: &usize| left[*f] > 0 && (*f == 0 || left[*f - 1] != left[*f] + 1);
    let starts: Vec<usize> = (0..left.len()).filter(begins).collect();
    let long: u32 = starts.iter().map(|&f| left[f]).filter(|n| *n >= frames(LONG_S)).sum();
    let longest = starts.into_iter().max_by_key(|&f| (left[f], Reverse(f))).filter(|&f| left[f] >= frames(SHORTEST_S));
    let stretch = longest.map(|f| {
        let manner = clip.class_at(f).map_or(String::new(), |class| class.manner.clone());
        let class = MotionClass { neutral: true, manner, ..MotionClass::default() };
        RestStance { clip: cut(clip, f..f + left[f] as usize + 1), class, unrest: 0.0, made: false }
    });
    (stretch, f64::from(long) / clip.rate_hz)
}

impl RestStance {
    /// A stand of at least so many seconds.
    ///
    /// - `number`: of its ways and sways, which are drawn.
    pub(super) fn prolong(&self, skeleton: &Skeleton, seconds: f32, number: u64) -> Self {
        let clip = &self.clip;
        let rate = clip.rate_hz as f32;
        let mut rng = Pcg64::seed_from_u64(number);
        let places = draw_places(clip.num_frames() - 1, rate, seconds, &mut rng);
        let sways = SWAYS.map(|(size, [least, most])| {
            (size * rng.random_range(0.7..1.3f32), TAU / rng.random_range(least..most), rng.random_range(0.0..TAU))
        });
        let feet = [0, 1].map(|foot| foot_point(clip, skeleton, 0, foot));
        let across = (feet[0].toe - feet[1].toe).with_y(0.0).normalize_or(Vec3::X);
        let ahead = across.cross(Vec3::Y);
        let balance = offset_to_balance(pose_between(clip, 0.0).hips, &feet, ahead);
        let (mut roots, mut rotations) = (Vec::new(), Vec::new());
        for (f, place) in places.iter().enumerate() {
            let mut pose = pose_between(clip, *place);
            let left = f.min(places.len() - 1 - f) as f32;
            let fade = smooth(left / (FADE_S * rate));
            let [aside, along, turn, breath] =
                sways.map(|(size, per_s, phase)| fade * size * maths::sin(phase + per_s * f as f32 / rate));
            pose.hips += across * aside + ahead * along + fade * balance;
            // The trunk stays upright over hips that go aside; head and chest turn a little.
            let (sin, cos) = maths::sin_cos(-0.3 * aside);
            let lean = Quat::from_xyzw(ahead.x * sin, ahead.y * sin, ahead.z * sin, cos);
            pose.rotations[0] = maths::compose(lean, pose.rotations[0]);
            for (joint, turn) in [
                (Joint::Neck, maths::rotation_y(0.5 * turn)),
                (Joint::Head, maths::rotation_y(0.5 * turn)),
                (Joint::Chest, maths::rotation_x(-breath)),
                (Joint::UpperChest, maths::rotation_x(-0.6 * breath)),
            ] {
                let j = joint.index();
                pose.rotations[j] = maths::compose(pose.rotations[j], turn);
            }
            reach_feet(&mut pose, skeleton, &feet);
            roots.push(pose.hips);
            rotations.extend(pose.rotations);
        }
        let contacts = vec![Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0); roots.len()];
        let clip = Clip { contacts, ..Clip::new(clip.name.clone(), clip.rate_hz, roots, rotations) };
        Self { clip, class: self.class.clone(), unrest: 0.0, made: true }
    }
}

/// Places in a stretch over time, from its first frame to its last one: ways to and fro that end here and there (frames).
fn draw_places(last: usize, rate: f32, seconds: f32, rng: &mut Pcg64) -> Vec<f32> {
    let (length, mut out, mut at, mut to_end) = (last as f32, vec![0.0], 0.0, true);
    loop {
        let inset = length * rng.random_range(0.0..0.3f32);
        let is_last = out.len() as f32 > (seconds - WAY_S) * rate && to_end;
        let to = match (is_last, to_end) {
            (true, _) => length,
            (_, true) => length - inset,
            _ => inset,
        };
        // The middle of a way is half as fast again as it is on average.
        let frames = (1.5 * (to - at).abs() / RATE).max(WAY_S * rate * rng.random_range(0.9..1.3f32)).ceil();
        out.extend((1..=frames as usize).map(|k| at + (to - at) * smooth(k as f32 / frames)));
        if is_last {
            return out;
        }
        (at, to_end) = (to, !to_end);
    }
}

/// Pose of a clip between two frames.
fn pose_between(clip: &Clip, at: f32) -> CoursePose {
    let from = (at as usize).min(clip.num_frames() - 1);
    let (to, share) = ((from + 1).min(clip.num_frames() - 1), at - from as f32);
    let (a, b) = (clip.frame_rotations(from), clip.frame_rotations(to));
    let rotations: [Quat; NUM_JOINTS] = std::array::from_fn(|j| maths::slerp_f32(a[j], b[j], share));
    CoursePose { hips: clip.root_positions[from].lerp(clip.root_positions[to], share), rotations }
}
