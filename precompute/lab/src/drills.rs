//! Drills: how soon, and on how much ground, characters answer an order to turn, to stop or to follow.

use crate::{quality::median, trial::start_states};
use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::Serialize;
use std::f32::consts::PI;
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};
use throng_core::characters::{CharactersConfig, PolicyCharacters, PolicyOrder, Spawn};
use throng_core::{Bundle, CharacterGroup, Id, Inline, Joint, NUM_JOINTS, Planar, Result};

/// Number of characters, steps a second, and distance between neighbours (m).
const DRILLED: (usize, f32, f32) = (24, 30.0, 200.0);
/// Time to get going, and from the order to the end (s).
const SECONDS: [f32; 2] = [4.0, 8.0];
/// Distance of targets (m).
const FAR_M: f32 = 8.0;
/// Half of the time over which a velocity is measured (s).
const HALF_S: f32 = 0.25;
/// Angle to the new target within which a turn is done (rad).
const TURNED: f32 = PI / 6.0;
/// Distance of a joint from where it would be without an order, from which the answer is seen (m).
const SEEN_M: f32 = 0.01;
/// Speed of a target that is followed (m/s).
const FOLLOWED_MPS: f32 = 0.5;

/// Answers to orders, medians of walking characters; one that does not answer counts with the time of the drill, 8 s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct DrillFigures {
    /// Time until travel is within 30 degrees of a target to the side (s).
    pub turn_90_s: f64,
    /// Way until then (m).
    pub turn_90_m: f64,
    /// Time until travel is within 30 degrees of a target behind (s).
    pub turn_180_s: f64,
    /// Way until then (m).
    pub turn_180_m: f64,
    /// Time until who stands faces the other way, with an order to turn (s).
    pub turn_standing_s: f64,
    /// Time until they stand, with an order to stop (s).
    pub stop_s: f64,
    /// Way until then (m).
    pub stop_m: f64,
    /// Time from the order to go back until a joint is 1 cm from where it would be without (s).
    pub answer_s: f64,
    /// Distance from a target that goes away at 0.5 m/s, after 4 s (m).
    pub lag_m: f64,
    /// Time from an order for another manner until its motion is played, and the longest one; none where all motion is alike (s).
    pub manner_s: Option<[f64; 2]>,
}

/// Positions of all joints, step by step, of every character.
type Course = Vec<Vec<[Vec3; NUM_JOINTS]>>;

/// Runs all drills with the first behaviour of a bundle.
///
/// # Errors
/// [`throng_core::Error`] where it has none.
pub fn run(tables: &Bundle) -> Result<DrillFigures> {
    let ahead = |at: Vec3, to: Vec2, angle: f32| at + FAR_M * Vec2::from_angle(angle).rotate(to).extend(0.0).xzy();
    let go = |to: Vec3| PolicyOrder::towards(0, to);
    let on_way = |from: Vec3| go(from + 4.0 * FAR_M * Vec3::Z);
    let turn = |angle: f32| play(tables, on_way, |from, to, _| go(ahead(from, to, angle)));
    let (on, left, back) = (turn(0.0)?, turn(0.5 * PI)?, turn(PI)?);
    let stop = play(tables, on_way, |_, _, _| PolicyOrder::STOP)?;
    let follow = play(tables, on_way, |from, to, s| go(from + (FOLLOWED_MPS * s * to).extend(0.0).xzy()))?;
    let spin = play(tables, |_| PolicyOrder::turn_to(0.0), |_, _, _| PolicyOrder::turn_to(PI))?;
    let ordered = (SECONDS[0] * DRILLED.1) as usize;
    // Seconds and metres from the order until something is so.
    let until = |course: &Course, is_done: &dyn Fn(&[[Vec3; NUM_JOINTS]], usize) -> bool| {
        let one = |track: &Vec<[Vec3; NUM_JOINTS]>| {
            let end = (ordered..track.len()).find(|&f| is_done(track, f)).unwrap_or(track.len() - 1);
            let way = (ordered..end).map(|f| hips(track, f).distance(hips(track, f + 1))).sum::<f32>();
            [(end - ordered) as f32 / DRILLED.1, way]
        };
        let (mut s, mut m): (Vec<f32>, Vec<f32>) = course.iter().map(one).map(|[s, m]| (s, m)).unzip();
        [&mut s, &mut m].map(|values| median(values).unwrap_or(0.0))
    };
    let turned = |angle: f32| {
        move |track: &[[Vec3; NUM_JOINTS]], f: usize| {
            let to = ahead(track[ordered][0], travel(track, ordered), angle).xz();
            let (now, wanted) = (velocity(track, f), to - hips(track, f));
            now.length() > WALKING_MPS && now.angle_to(wanted).abs() < TURNED
        }
    };
    let is_behind = |track: &[[Vec3; NUM_JOINTS]], f: usize| front(&track[f]).angle_to(Vec2::NEG_Y).abs() < TURNED;
    let stands = |track: &[[Vec3; NUM_JOINTS]], f: usize| velocity(track, f).length() < STANDING_MPS;
    let [turn_90_s, turn_90_m] = until(&left, &turned(0.5 * PI));
    let [turn_180_s, turn_180_m] = until(&back, &turned(PI));
    let [turn_standing_s, _] = until(&spin, &is_behind);
    let [stop_s, stop_m] = until(&stop, &stands);
    let answer = |(track, other): (&Vec<[Vec3; NUM_JOINTS]>, &Vec<[Vec3; NUM_JOINTS]>)| {
        let is_seen = |f: &usize| (0..NUM_JOINTS).any(|j| track[*f][j].distance(other[*f][j]) > SEEN_M);
        ((ordered..track.len()).find(is_seen).unwrap_or(track.len() - 1) - ordered) as f32 / DRILLED.1
    };
    let mut answers: Vec<f32> = back.iter().zip(&on).map(answer).collect();
    let lag = |track: &Vec<[Vec3; NUM_JOINTS]>| {
        let (from, to) = (hips(track, ordered), travel(track, ordered));
        let late = ordered + (4.0 * DRILLED.1) as usize..track.len();
        let behind = |f: usize| hips(track, f).distance(from + to * (FOLLOWED_MPS * (f - ordered) as f32 / DRILLED.1));
        late.clone().map(behind).sum::<f32>() / late.len() as f32
    };
    let mut lags: Vec<f32> = follow.iter().map(lag).collect();
    let [answer_s, lag_m] = [&mut answers, &mut lags].map(|values| median(values).unwrap_or(0.0));
    let manner_s = time_manners(tables, on_way)?;
    let turns = DrillFigures { turn_90_s, turn_90_m, turn_180_s, turn_180_m, turn_standing_s, ..Default::default() };
    Ok(DrillFigures { stop_s, stop_m, answer_s, lag_m, manner_s, ..turns })
}

/// Median and longest time from an order for another manner until its motion is played (s).
fn time_manners(tables: &Bundle, first: impl Fn(Vec3) -> PolicyOrder) -> Result<Option<[f64; 2]>> {
    let (mut group, ids) = start(tables, first)?;
    let known: Vec<String> = group.motion_set().manners().map(str::to_owned).collect();
    (0..(SECONDS[0] * DRILLED.1) as usize).try_for_each(|_| group.step(1.0 / DRILLED.1, &Inline))?;
    let mut times = Vec::new();
    for (i, &id) in ids.iter().enumerate() {
        let own = group.manner(id)?.to_owned();
        let others: Vec<_> = known.iter().filter(|name| **name != own).collect();
        let Some(wanted) = others.get(i % others.len().max(1)) else { return Ok(None) };
        group.set_manner(id, wanted)?;
        times.push((id, *wanted, SECONDS[1]));
    }
    for step in 1..=(SECONDS[1] * DRILLED.1) as usize {
        group.step(1.0 / DRILLED.1, &Inline)?;
        for (id, wanted, time_s) in &mut times {
            if *time_s == SECONDS[1] && group.manner(*id)? == *wanted {
                *time_s = step as f32 / DRILLED.1;
            }
        }
    }
    let mut times: Vec<f32> = times.into_iter().map(|(_, _, time_s)| time_s).collect();
    let longest = times.iter().copied().fold(0.0, f32::max);
    Ok(median(&mut times).map(|middle| [middle, f64::from(longest)]))
}

fn hips(track: &[[Vec3; NUM_JOINTS]], f: usize) -> Vec2 {
    track[f][Joint::Hips.index()].xz()
}

/// Where the hips face: x, z.
fn front(joints: &[Vec3; NUM_JOINTS]) -> Vec2 {
    let left = joints[Joint::LeftThigh.index()] - joints[Joint::RightThigh.index()];
    Vec2::new(-left.z, left.x).normalize_or_zero()
}

/// Direction over ground in the time before.
fn travel(track: &[[Vec3; NUM_JOINTS]], f: usize) -> Vec2 {
    (hips(track, f) - hips(track, f - (HALF_S * DRILLED.1) as usize)).normalize_or_zero()
}

/// Velocity over ground, over [`HALF_S`] before and after (m/s).
fn velocity(track: &[[Vec3; NUM_JOINTS]], f: usize) -> Vec2 {
    let half = (HALF_S * DRILLED.1) as usize;
    let (from, to) = (f.saturating_sub(half), (f + half).min(track.len() - 1));
    (hips(track, to) - hips(track, from)) * DRILLED.1 / (to - from) as f32
}

/// Gives characters an order, then each another one.
///
/// - `first`: the order, of the place at the start (m).
/// - `then`: the other, of the place when it is given, the direction of travel there, and the time since (m, s).
fn play(
    tables: &Bundle,
    first: impl Fn(Vec3) -> PolicyOrder,
    then: impl Fn(Vec3, Vec2, f32) -> PolicyOrder,
) -> Result<Course> {
    let (n, hz, _) = DRILLED;
    let (mut group, ids) = start(tables, first)?;
    let mut course: Course = vec![Vec::new(); n];
    let ordered = (SECONDS[0] * hz) as usize;
    for step in 0..((SECONDS[0] + SECONDS[1]) * hz) as usize {
        if let Some(since) = step.checked_sub(ordered + 1) {
            for (id, track) in ids.iter().zip(&course) {
                let from = track[ordered][0].with_y(0.0);
                group.order(*id, then(from, travel(track, ordered), since as f32 / hz))?;
            }
        }
        group.step(1.0 / hz, &Inline)?;
        (0..n).for_each(|c| course[c].push(group.characters().joint_positions(c)));
    }
    Ok(course)
}

/// Characters apart from each other, each with an order of its place (m).
fn start(tables: &Bundle, first: impl Fn(Vec3) -> PolicyOrder) -> Result<(PolicyCharacters, Vec<Id>)> {
    let (n, _, apart) = DRILLED;
    let config = CharactersConfig::default();
    let mut group = PolicyCharacters::with_capacity(tables, n, config)?;
    let states = start_states(tables, &config);
    let mut ids = Vec::with_capacity(n);
    for i in 0..n {
        let root = Planar::new(apart * i as f32, 0.0, 0.0);
        let id = group.spawn(Spawn { root, state: Some(states[i * states.len() / n]), floor_m: 0.0 })?;
        group.order(id, first(Vec3::new(root.x, 0.0, 0.0)))?;
        ids.push(id);
    }
    Ok((group, ids))
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::characters::made_up;

    #[test]
    fn all_drills_are_measured() {
        let figures = run(&made_up::tables()).expect("a behaviour");
        let times = [figures.turn_90_s, figures.turn_180_s, figures.turn_standing_s, figures.stop_s, figures.answer_s];
        assert!(times.iter().all(|s| (0.0..=8.0).contains(s)), "{figures:?}");
        assert!(figures.answer_s < figures.turn_180_s && figures.lag_m > 0.0, "{figures:?}");
    }
}
