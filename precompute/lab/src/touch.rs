//! Contact of opponents: arms and legs in bodies, arms in heads, heads too near each other, rates of elbows.

use crate::{frames::runs, histogram::Histogram, quality::clip_joints};
use glam::Vec3;
use serde::Serialize;
use throng_core::skeleton::{ARMS, LEGS};
use throng_core::{BodyVolume, Bundle, CharacterGroup, Joint, NUM_JOINTS};
use throng_geometry::segment_distance;
use throng_simulation::sparring::{Sparring, StruckPart};

/// Figures of opponents: whether their limbs stop at each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TouchFigures {
    /// Times that a forearm came within 10 cm of the opponent's spine, a minute and boxer.
    pub arms_in_bodies_per_minute: f64,
    /// Times that a shin or a foot came within 10 cm of the opponent's spine, a minute and boxer.
    pub legs_in_bodies_per_minute: f64,
    /// Times that a shin or a foot came within 8 cm of a shin or a foot of the opponent, a minute and boxer.
    pub legs_in_legs_per_minute: f64,
    /// Share of the time in which legs were that near each other.
    pub legs_in_legs_fraction: f64,
    /// Times that a wrist came within 8 cm of the middle of the opponent's head, a minute and boxer; not within 0.1 s after
    /// its blow landed there.
    pub wrists_in_heads_per_minute: f64,
    /// Share of the time in which heads of opponents were less than 0.45 m apart.
    pub heads_close_fraction: f64,
    /// Distance between heads of opponents, mean over time and pairs (m).
    pub head_distance_mean_m: f64,
    /// Largest angular rate of an elbow over that of the clips.
    pub elbow_rate_max_ratio: f64,
    /// 99.9th percentile of the angular rate of elbows over that of the clips.
    pub elbow_rate_p999_ratio: f64,
}

/// Depth of a forearm or a hand from which it is in a body or a head (m). Chosen.
const DEEP_TOUCH_M: f32 = 0.062;
/// Depth of legs from which they are in each other (m). Chosen.
const DEEP_LEGS_M: f32 = 0.03;
/// Distance from a spine below which forearms, shins and feet are in the body (m).
const IN_BODY_M: f32 = BodyVolume::radius_m(Joint::Chest) + BodyVolume::radius_m(Joint::LeftForearm) - DEEP_TOUCH_M;
/// Distance from the middle of a head below which wrists are in it (m).
const IN_HEAD_M: f32 = BodyVolume::radius_m(Joint::Head) + BodyVolume::radius_m(Joint::LeftHand) - DEEP_TOUCH_M;
/// Distance from the opponent's shins and feet below which shins and feet are in them (m).
const IN_LEG_M: f32 = 2.0 * BodyVolume::radius_m(Joint::LeftShin) - DEEP_LEGS_M;
/// Distance of heads below which opponents are too near to strike (m).
const CLOSE_M: f32 = 0.45;
/// Time after its blow has landed in which a wrist may be in the head (s).
const LANDING_S: f32 = 0.1;
/// Histogram of angular rates of elbows up to 80 rad/s.
type ElbowRateHistogram = Histogram<50, 4000>;

const SPINE: [Joint; 5] = [Joint::Hips, Joint::Spine, Joint::Chest, Joint::UpperChest, Joint::Neck];

/// Measures the contact of opponents from step to step.
#[derive(Default)]
pub struct TouchMeter {
    /// States by the character's number.
    boxers: Vec<Option<BoxerState>>,
    arms_in_bodies: u64,
    legs_in_bodies: u64,
    legs_in_legs: u64,
    wrists_in_heads: u64,
    /// Time that legs of pairs were in each other (s).
    legs_in_legs_s: f64,
    close_s: f64,
    head_distance_sum: f64,
    /// Time of all pairs (s).
    pair_s: f64,
    elbows: ElbowRateHistogram,
}

/// State of one boxer that is kept from step to step.
#[derive(Clone, Copy, Default)]
struct BoxerState {
    in_body: [bool; 2],
    legs_in_body: [bool; 2],
    /// Flags of the legs that are in a leg of the opponent.
    in_legs: [bool; 2],
    in_head: [bool; 2],
    /// Time since a blow of each hand landed on the other's head (s).
    landed_s: [f32; 2],
    elbows: [f32; 2],
}

impl TouchMeter {
    /// Observes all pairs after a step.
    ///
    /// - `first_number`: number of the first boxer, if several sparring groups are measured.
    pub fn observe(&mut self, sparring: &Sparring, first_number: usize, dt_s: f32) {
        let num = 2 * sparring.num_pairs();
        self.boxers.resize(self.boxers.len().max(first_number + num), None);
        let landed = |row: usize, hand: Joint| {
            let on_head = |part: StruckPart| matches!(part, StruckPart::Head | StruckPart::Neck);
            let mut landings = sparring.events().iter().map(|(_, landing)| landing);
            landings.any(|l| l.blow.character as usize == row && l.blow.joint == hand && on_head(l.part))
        };
        for first in (0..num).step_by(2) {
            let rows = [first, first + 1];
            let joints = rows.map(|row| sparring.characters().joint_positions(row));
            let heads = rows.map(|row| sparring.heads()[row ^ 1]);
            let apart = heads[0].distance(heads[1]);
            self.pair_s += f64::from(dt_s);
            self.head_distance_sum += f64::from(apart * dt_s);
            self.close_s += if apart < CLOSE_M { f64::from(dt_s) } else { 0.0 };
            for k in 0..2 {
                let before = self.boxers[first_number + rows[k]];
                let mut now = BoxerState { landed_s: [f32::MAX; 2], ..before.unwrap_or_default() };
                for (a, arm) in ARMS.into_iter().enumerate() {
                    let [shoulder, elbow, wrist] = arm.map(|j| joints[k][j.index()]);
                    now.landed_s[a] = match before {
                        _ if landed(rows[k], arm[2]) => 0.0,
                        Some(b) => b.landed_s[a] + dt_s,
                        None => f32::MAX,
                    };
                    now.in_body[a] = spine_distance([elbow, wrist], &joints[k ^ 1]) < IN_BODY_M;
                    let in_head = wrist.distance(heads[k ^ 1]) < IN_HEAD_M;
                    now.in_head[a] = in_head && now.landed_s[a] > LANDING_S;
                    now.elbows[a] = (shoulder - elbow).angle_between(wrist - elbow);
                    if let Some(b) = before.filter(|_| dt_s > 0.0) {
                        self.arms_in_bodies += u64::from(now.in_body[a] && !b.in_body[a]);
                        self.wrists_in_heads += u64::from(now.in_head[a] && !b.in_head[a]);
                        self.elbows.add((now.elbows[a] - b.elbows[a]).abs() / dt_s);
                    }
                }
                for (l, leg) in LEGS.into_iter().enumerate() {
                    let bones = lower_leg(leg, &joints[k]);
                    let others = LEGS.into_iter().flat_map(|leg| lower_leg(leg, &joints[k ^ 1]));
                    let to_legs = others.flat_map(|other| bones.map(|bone| segment_distance(bone, other)));
                    now.in_legs[l] = to_legs.fold(f32::MAX, f32::min) < IN_LEG_M;
                    now.legs_in_body[l] = bones.iter().any(|b| spine_distance(*b, &joints[k ^ 1]) < IN_BODY_M);
                    if let Some(b) = before.filter(|_| dt_s > 0.0) {
                        self.legs_in_bodies += u64::from(now.legs_in_body[l] && !b.legs_in_body[l]);
                        self.legs_in_legs += u64::from(now.in_legs[l] && !b.in_legs[l]);
                    }
                }
                self.legs_in_legs_s += if k == 0 && now.in_legs.contains(&true) { f64::from(dt_s) } else { 0.0 };
                self.boxers[first_number + rows[k]] = Some(now);
            }
        }
    }

    /// The figures; none without sparring.
    ///
    /// - `bundle`: bundle with the clips of the boxers.
    pub fn figures(&self, bundle: &Bundle) -> Option<TouchFigures> {
        let boxer_minutes = 2.0 * self.pair_s / 60.0;
        let source = source_elbows(bundle);
        let over = |here: f64, source: f64| here / source.max(1e-6);
        (self.pair_s > 0.0).then(|| TouchFigures {
            arms_in_bodies_per_minute: self.arms_in_bodies as f64 / boxer_minutes,
            legs_in_bodies_per_minute: self.legs_in_bodies as f64 / boxer_minutes,
            legs_in_legs_per_minute: self.legs_in_legs as f64 / boxer_minutes,
            legs_in_legs_fraction: self.legs_in_legs_s / self.pair_s,
            wrists_in_heads_per_minute: self.wrists_in_heads as f64 / boxer_minutes,
            heads_close_fraction: self.close_s / self.pair_s,
            head_distance_mean_m: self.head_distance_sum / self.pair_s,
            elbow_rate_max_ratio: over(self.elbows.quantile(1.0), source.quantile(1.0)),
            elbow_rate_p999_ratio: over(self.elbows.quantile(0.999), source.quantile(0.999)),
        })
    }
}

/// Angular rates of the elbows in a bundle's clips.
fn source_elbows(bundle: &Bundle) -> ElbowRateHistogram {
    let (mut rates, rate_hz) = (ElbowRateHistogram::default(), bundle.meta().rate_hz as f32);
    for run in runs(bundle) {
        let mut before: Option<[f32; 2]> = None;
        for frame in run {
            let joints = clip_joints(bundle, frame).map(|joint| joint.0);
            let now = ARMS.map(|arm| {
                let [shoulder, elbow, wrist] = arm.map(|j| joints[j.index()]);
                (shoulder - elbow).angle_between(wrist - elbow)
            });
            if let Some(before) = before.replace(now) {
                (0..2).for_each(|a| rates.add((now[a] - before[a]).abs() * rate_hz));
            }
        }
    }
    rates
}

/// Distance between a bone and a spine (m).
fn spine_distance(bone: [Vec3; 2], joints: &[Vec3; NUM_JOINTS]) -> f32 {
    let link = |w: &[Joint]| [joints[w[0].index()], joints[w[1].index()]];
    SPINE.windows(2).map(|w| segment_distance(bone, link(w))).fold(f32::INFINITY, f32::min)
}

/// Shin and foot of a leg (m).
fn lower_leg(leg: [Joint; 4], joints: &[Vec3; NUM_JOINTS]) -> [[Vec3; 2]; 2] {
    let [_, knee, ankle, toes] = leg.map(|j| joints[j.index()]);
    [[knee, ankle], [ankle, toes]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feet_of_two_are_as_far_from_each_other_as_they_stand() {
        let joints = throng_core::skeleton::Skeleton::default().rest_positions();
        let [near, ahead] = LEGS.map(|leg| lower_leg(leg, &joints));
        let apart = near[0][1].distance(ahead[0][1]);
        let least = |by: Vec3| {
            let moved = ahead.map(|bone| bone.map(|p| p + by));
            near.iter().flat_map(|a| moved.map(|b| segment_distance(*a, b))).fold(f32::MAX, f32::min)
        };
        assert!((least(Vec3::ZERO) - apart).abs() < 0.02, "{} {apart}", least(Vec3::ZERO));
        // The right foot steps to where the left one stands.
        assert!(least(near[0][1] - ahead[0][1]) < 1e-3);
    }

    #[test]
    fn forearms_are_as_far_from_a_spine_as_they_are() {
        let joints = throng_core::skeleton::Skeleton::default().rest_positions();
        let chest = joints[Joint::Chest.index()];
        let [a, b] = [chest + Vec3::new(-0.2, 0.0, 0.3), chest + Vec3::new(0.2, 0.0, 0.3)];
        let off = spine_distance([a, b], &joints);
        assert!((off - 0.3).abs() < 0.02, "{off}");
        assert!(spine_distance([chest, b], &joints) < 1e-6);
    }
}
