//! Detection of walks on the spot: treadmills, and exports whose root was left in place.

use crate::clip::runs_where;
use crate::import::roles::RoleMap;
use crate::raw::RawClip;
use glam::{Vec2, Vec3};
use throng_base::thresholds::{FOOT_FREE_MPS, FOOT_LOW_M, FOOT_PLANTED_MPS};
use throng_core::Joint;

/// Time over which speeds are measured (s).
const SPEED_S: f64 = 0.1;
/// Time over which the travel of the hips is measured: about a step (s).
const STEP_S: f64 = 0.6;
/// Share of the speed of sliding feet below which the hips stay.
const STAYING: f32 = 0.35;
/// Least duration of a slide (s).
const SLIDE_S: f64 = 0.12;
/// Share of the clip above which it is a walk on the spot.
const MOST: f32 = 0.3;
/// Shortest clip that is conclusive (s).
const SHORTEST_S: f64 = 0.8;

/// A warning of a walk on the spot: each foot that carries weight slides in its turn, while the hips stay and no foot stands.
pub(super) fn find_walk_in_place(clip: &RawClip, roles: &RoleMap) -> Option<String> {
    let hips = roles.get(Joint::Hips)?;
    let feet = [[Joint::LeftFoot, Joint::LeftToe], [Joint::RightFoot, Joint::RightToe]]
        .map(|parts| parts.map(|j| roles.get(j)));
    let frames = |s: f64| (s * clip.rate_hz).round().max(1.0) as usize;
    let n = clip.num_frames;
    if n < frames(SHORTEST_S) {
        return None;
    }
    let places = |f: usize| {
        let (world, flat) = (clip.world(f), |v: Vec3| Vec2::new(v.x, v.z));
        (flat(world[hips].0), feet.map(|foot| foot.map(|j| j.map(|j| world[j].0))))
    };
    let (roots, parts): (Vec<Vec2>, Vec<_>) = (0..n).map(places).unzip();
    let velocity = |at: &dyn Fn(usize) -> Option<Vec2>, f: usize, s: f64| {
        let half = frames(0.5 * s);
        let (a, b) = (f.saturating_sub(half), (f + half).min(n - 1));
        Some((at(b)? - at(a)?) * (clip.rate_hz as f32 / (b - a) as f32))
    };
    // Both feet's lowest places, part by part.
    let lowest = |side: usize, part: usize| {
        let mut all: Vec<f32> = parts.iter().filter_map(|p| p[side][part].map(|v| v.y)).collect();
        all.sort_by(f32::total_cmp);
        all.get(all.len() / 20).copied()
    };
    let ground = [0, 1].map(|side| [0, 1].map(|part| lowest(side, part)));
    let low = |side: usize, part: usize, f: usize| {
        parts[f][side][part].zip(ground[side][part]).is_some_and(|(at, ground)| at.y < ground + FOOT_LOW_M)
    };
    let foot = |side: usize, part: usize, f: usize| {
        velocity(&|f| parts[f][side][part].map(|v| Vec2::new(v.x, v.z)), f, SPEED_S)
    };
    let all_parts = || (0..2).flat_map(|side| (0..2).map(move |part| (side, part)));
    let stands = |f: usize| {
        all_parts().any(|(s, p)| low(s, p, f) && foot(s, p, f).is_some_and(|v| v.length() < FOOT_PLANTED_MPS))
    };
    // Speed of a foot that carries weight and slides, while the hips stay.
    let slide = |side: usize, f: usize| {
        let foot = foot(side, (0..2).find(|&part| low(side, part, f))?, f)?;
        let body = velocity(&|f| Some(roots[f]), f, STEP_S)?;
        let slides = foot.length() > FOOT_FREE_MPS && body.length() < STAYING * foot.length() && !stands(f);
        slides.then(|| foot.length())
    };
    let (mut sliding, mut speeds, mut slides) = (vec![false; n], Vec::new(), [false; 2]);
    for side in 0..2 {
        let all: Vec<Option<f32>> = (0..n).map(|f| slide(side, f)).collect();
        let long = runs_where(0..n, |f| all[f].is_some()).into_iter().filter(|r| r.len() >= frames(SLIDE_S));
        for f in long.flatten() {
            (sliding[f], slides[side]) = (true, true);
            speeds.extend(all[f]);
        }
    }
    speeds.sort_by(f32::total_cmp);
    let share = sliding.iter().filter(|s| **s).count() as f32 / n as f32;
    let is_one = share >= MOST && slides == [true; 2];
    is_one.then(|| {
        format!(
            "walks on the spot: feet on the ground slide, at {:.1} m/s, for {:.0} % of the time, while the hips stay where \
             they are, as on a treadmill. Characters will stand and slide. Export it again with root motion (not \"in \
             place\").",
            speeds[speeds.len() / 2],
            100.0 * share
        )
    })
}
