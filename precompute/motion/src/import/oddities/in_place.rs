//! Walks on the spot, as on treadmills and in exports "in place": they are found, and get root motion from planted feet.

use crate::{clip::runs_where, import::roles::RoleMap, raw::RawClip};
use glam::{Vec2, Vec3, Vec3Swizzles};
use throng_base::maths::quantile;
use throng_base::thresholds::{FOOT_FREE_MPS, FOOT_LOW_M, FOOT_PLANTED_MPS, TREADMILL_RUNS_MPS};
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
/// Time over which the course of planted feet is taken for that of the lowest ones (s).
const COURSE_S: f64 = 1.2;
/// Difference from that course up to which a low foot is planted: a share of its speed, and beside it (m/s).
const OFF_COURSE: (f32, f32) = (0.5, 0.15);
/// Runners: median speed of the lowest foot (m/s), or share of frames without a low foot, from which feet stand only for the
/// middle of their contact, at this share of the fastest near by, within this time (s).
const RUNNERS: (f32, f32, f32, f64) = (TREADMILL_RUNS_MPS, 0.05, 0.8, 0.6);
/// Height up to which a runner's foot may be planted (m).
const RUNNER_LOW_M: f32 = 0.05;
/// Ratio of the made speed to feet apart times steps a second that is plausible; runners fly beyond that.
const PLAUSIBLE: [f32; 3] = [0.5, 2.0, 4.0];

/// Hips and feet of a clip; the left foot and toe, then the right ones.
struct Tracks {
    rate_hz: f64,
    hips: Vec<Vec2>,
    /// Parts of feet, frame by frame (num_frames).
    parts: Vec<[Option<Vec3>; 4]>,
    /// Height of each part where it stands (m).
    ground: [f32; 4],
}

impl Tracks {
    fn of_clip(clip: &RawClip, roles: &RoleMap) -> Option<Self> {
        let hips = roles.get(Joint::Hips)?;
        let feet = crate::stance::FEET.map(|j| roles.get(j));
        let places = |f: usize| {
            let world = clip.world(f);
            (world[hips].0.xz(), feet.map(|j| j.map(|j| world[j].0)))
        };
        let (hips, parts): (_, Vec<_>) = (0..clip.num_frames).map(places).unzip();
        let lowest = |part: usize| {
            let all = parts.iter().filter_map(|p: &[Option<Vec3>; 4]| p[part].map(|v| v.y));
            quantile(all, [1, 20]).unwrap_or(f32::INFINITY)
        };
        let ground = std::array::from_fn(lowest);
        Some(Self { rate_hz: clip.rate_hz, hips, parts, ground })
    }

    fn frames(&self, seconds: f64) -> usize {
        (seconds * self.rate_hz).round().max(1.0) as usize
    }

    fn velocity(&self, at: impl Fn(usize) -> Option<Vec2>, f: usize, seconds: f64) -> Option<Vec2> {
        let half = self.frames(0.5 * seconds);
        let (a, b) = (f.saturating_sub(half), (f + half).min(self.hips.len() - 1));
        Some((at(b)? - at(a)?) * (self.rate_hz as f32 / (b - a) as f32))
    }

    /// Velocity of a part over the ground (m/s).
    fn part_velocity(&self, part: usize, f: usize) -> Option<Vec2> {
        self.velocity(|f| self.parts[f][part].map(|v| v.xz()), f, SPEED_S)
    }

    /// Height of a part over its ground (m).
    fn height(&self, part: usize, f: usize) -> f32 {
        self.parts[f][part].map_or(f32::INFINITY, |v| v.y - self.ground[part])
    }

    fn is_low(&self, part: usize, f: usize) -> bool {
        self.height(part, f) < FOOT_LOW_M
    }
}

/// A walk on the spot.
struct WalkInPlace {
    /// Median speed of sliding feet (m/s).
    speed_mps: f32,
    /// Share of the time in which they slide.
    share: f32,
}

/// Finds a walk on the spot: each foot that carries weight slides in its turn, while the hips stay and no foot stands.
fn find_walk_in_place(t: &Tracks) -> Option<WalkInPlace> {
    let n = t.hips.len();
    if n < t.frames(SHORTEST_S) {
        return None;
    }
    let is_planted = |p: usize, f: usize| t.part_velocity(p, f).is_some_and(|v| v.length() < FOOT_PLANTED_MPS);
    let stands = |f: usize| (0..4).any(|p| t.is_low(p, f) && is_planted(p, f));
    // Speed of a foot that carries weight and slides, while the hips stay.
    let slide = |side: usize, f: usize| {
        let foot = t.part_velocity((2 * side..2 * side + 2).find(|&part| t.is_low(part, f))?, f)?;
        let body = t.velocity(|f| Some(t.hips[f]), f, STEP_S)?;
        let slides = foot.length() > FOOT_FREE_MPS && body.length() < STAYING * foot.length() && !stands(f);
        slides.then(|| foot.length())
    };
    let (mut sliding, mut speeds, mut slides) = (vec![false; n], Vec::new(), [false; 2]);
    for side in 0..2 {
        let all: Vec<Option<f32>> = (0..n).map(|f| slide(side, f)).collect();
        let long = runs_where(0..n, |f| all[f].is_some()).into_iter().filter(|r| r.len() >= t.frames(SLIDE_S));
        for f in long.flatten() {
            (sliding[f], slides[side]) = (true, true);
            speeds.extend(all[f]);
        }
    }
    let share = sliding.iter().filter(|s| **s).count() as f32 / n as f32;
    (share >= MOST && slides == [true; 2]).then(|| WalkInPlace { speed_mps: median(speeds.into_iter()), share })
}

fn median(all: impl Iterator<Item = f32>) -> f32 {
    quantile(all, [1, 2]).unwrap_or_default()
}

/// Gives a walk on the spot the trajectory that its planted feet make the ground move, if it goes with its steps, and tells it.
///
/// - `moves`: false to tell it alone.
pub(super) fn give_root_motion(clip: &mut RawClip, roles: &RoleMap, moves: bool) -> Option<String> {
    let tracks = Tracks::of_clip(clip, roles)?;
    let WalkInPlace { speed_mps, share } = find_walk_in_place(&tracks)?;
    let found = format!(
        "walks on the spot: feet on the ground slide, at {speed_mps:.1} m/s, for {:.0} % of the time, while the hips stay where \
         they are, as on a treadmill",
        100.0 * share
    );
    let stays = "Characters will stand and slide. Export it again with root motion (not \"in place\")";
    if !moves {
        return Some(format!("{found}. {stays}: `import.root_motion` is false."));
    }
    let trajectory = find_trajectory(&tracks);
    let seconds = (trajectory.len() - 1) as f32 / clip.rate_hz as f32;
    let length: f32 = trajectory.windows(2).map(|w| w[0].distance(w[1])).sum();
    let made = format!("{length:.1} m in {seconds:.1} s, {:.2} m/s", length / seconds);
    let Some((steps_hz, apart_m)) = find_steps(&tracks, &trajectory) else {
        return Some(format!("{found}. It takes too few steps to be given root motion. {stays}."));
    };
    let of_steps = steps_hz * apart_m;
    let steps = format!("{steps_hz:.1} steps a second with the feet {apart_m:.2} m apart give {of_steps:.2}");
    let most = if length > RUNNERS.0 * seconds { PLAUSIBLE[2] } else { PLAUSIBLE[1] };
    if !(PLAUSIBLE[0] * of_steps..most * of_steps).contains(&(length / seconds)) {
        return Some(format!("{found}. Its planted feet make {made}, but {steps}. {stays}."));
    }
    let n = clip.joints.len();
    for (f, by) in trajectory.iter().enumerate() {
        for j in (0..n).filter(|&j| clip.joints[j].parent.is_none()) {
            clip.translations[f * n + j] += Vec3::new(by.x, 0.0, by.y);
        }
    }
    Some(format!("{found}. It got root motion from its planted feet: {made}; {steps}."))
}

/// Displacement of the body over the ground at every frame, from its first: against that of planted feet (m).
fn find_trajectory(t: &Tracks) -> Vec<Vec2> {
    let n = t.hips.len();
    let velocities: Vec<[Option<Vec2>; 4]> = (0..n).map(|f| std::array::from_fn(|p| t.part_velocity(p, f))).collect();
    let lowest = |f: &usize| {
        let part = (0..4).min_by(|&a, &b| t.height(a, *f).total_cmp(&t.height(b, *f))).unwrap_or(0);
        velocities[*f][part].unwrap_or_default()
    };
    let of_lowest: Vec<Vec2> = (0..n).map(|f| lowest(&f)).collect();
    let near = |f: usize, s: f64| f.saturating_sub(t.frames(0.5 * s))..(f + t.frames(0.5 * s) + 1).min(n);
    let course = |f: usize| {
        let of = |v: fn(&Vec2) -> f32| median(of_lowest[near(f, COURSE_S)].iter().map(v));
        Vec2::new(of(|v| v.x), of(|v| v.y))
    };
    let in_air = (0..n).filter(|&f| (0..4).all(|p| t.height(p, f) > 0.75 * FOOT_LOW_M)).count() as f32 / n as f32;
    let runs = in_air > RUNNERS.1 || median(of_lowest.iter().map(|v| v.length())) > RUNNERS.0;
    let planted: Vec<Option<Vec2>> = match runs {
        false => {
            let mean = |f: usize| {
                let (course, mut sum, mut weights) = (course(f), Vec2::ZERO, 0.0);
                for (p, v) in velocities[f].iter().enumerate().filter_map(|(p, v)| Some((p, (*v)?))) {
                    let weight = (1.0 - t.height(p, f) / FOOT_LOW_M).clamp(0.0, 1.0);
                    if v.distance(course) < OFF_COURSE.0 * course.length() + OFF_COURSE.1 {
                        (sum, weights) = (sum + weight * v, weights + weight);
                    }
                }
                (weights > 0.05).then(|| sum / weights)
            };
            (0..n).map(mean).collect()
        }
        true => {
            // The low part that goes back fastest, and by how much.
            let fastest = |f: usize| {
                let ahead = course(f).normalize_or_zero();
                let low = (0..4).filter(|&p| t.height(p, f) < RUNNER_LOW_M).filter_map(|p| velocities[f][p]);
                low.map(|v| (v.dot(ahead), v)).max_by(|a, b| a.0.total_cmp(&b.0))
            };
            let all: Vec<Option<(f32, Vec2)>> = (0..n).map(fastest).collect();
            let mid_stance = |f: usize| {
                let (speed, v) = all[f]?;
                let top = quantile(all[near(f, RUNNERS.3)].iter().flatten().map(|a| a.0), [9, 10])?;
                (speed > 0.0 && speed > RUNNERS.2 * top).then_some(v)
            };
            (0..n).map(mid_stance).collect()
        }
    };
    let known: Vec<usize> = (0..n).filter(|&f| planted[f].is_some()).collect();
    let at = |k: usize| planted[known[k]].unwrap_or_default();
    let between = |f: usize| {
        if known.is_empty() {
            return -course(f);
        }
        let next = known.partition_point(|&k| k < f);
        let [a, b] = [next.saturating_sub(1), next.min(known.len() - 1)];
        let share = (f as f32 - known[a] as f32) / (known[b] as f32 - known[a] as f32).max(1.0);
        -at(a).lerp(at(b), share.clamp(0.0, 1.0))
    };
    let rough: Vec<Vec2> = (0..n).map(between).collect();
    let mut way = vec![Vec2::ZERO];
    for f in 1..n {
        let window = &rough[near(f, 2.0 * SPEED_S)];
        way.push(way[f - 1] + window.iter().sum::<Vec2>() / (window.len() as f64 * t.rate_hz) as f32);
    }
    way
}

/// Steps a second, and how far apart the feet are along the way at each; `None` for few steps.
fn find_steps(t: &Tracks, way: &[Vec2]) -> Option<(f32, f32)> {
    let n = way.len();
    let ahead = |f: usize| {
        let half = t.frames(0.5 * COURSE_S);
        let by = (way[(f + half).min(n - 1)] - way[f.saturating_sub(half)]).normalize_or_zero();
        let [left, right] = [t.parts[f][0]?, t.parts[f][2]?].map(|v| v.xz().dot(by));
        Some(left - right)
    };
    let apart: Vec<f32> = (0..n).map(ahead).collect::<Option<_>>()?;
    // Each foot is ahead in its turn; a step is done where the other one is.
    let turns: Vec<_> =
        [false, true].into_iter().flat_map(|left| runs_where(0..n, |f| (apart[f] > 0.0) == left)).collect();
    let mut whole: Vec<_> =
        turns.into_iter().filter(|r| r.start > 0 && r.end < n && r.len() > t.frames(SPEED_S)).collect();
    whole.sort_by_key(|r| r.start);
    let widest = whole.iter().map(|r| apart[r.clone()].iter().fold(0.0f32, |most, a| most.max(a.abs())));
    let widest = median(widest);
    let lengths = median(whole.iter().map(|r| r.len() as f32));
    (whole.len() >= 2).then(|| (t.rate_hz as f32 / lengths, widest))
}
