//! Timeline of a clip: the keys, steps and blows of a plan.

use super::{BoxerFoot, BoxingHandPose, BoxingPosture, HandPunch, Shuffle};
use crate::side::{LateralSide, forward, leftward};
use crate::{foot::FootShape, track::KeyTrack};
use glam::DVec2;
use throng_core::Skeleton;

/// Ankles in the stance, left and right: to the left and forward (m).
pub const ANKLES: [DVec2; 2] = [DVec2::new(0.14, 0.205), DVec2::new(-0.13, -0.215)];
/// Headings of the feet in the stance, left and right (rad).
pub const YAWS: [f64; 2] = [-0.3, -0.86];
/// Time with both feet on the ground between two steps (s).
const BETWEEN: f64 = 0.035;

/// A blow with its time and target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScriptedBlow {
    /// Kind of the blow.
    pub blow: HandPunch,
    /// The hand leaves the guard (s).
    pub start: f64,
    /// The fist hits (s).
    pub hit: f64,
    /// The arm is at its longest (s).
    pub longest: f64,
    /// The hand is back on guard (s).
    pub back: f64,
    /// Direction from the shoulder, to the left of the facing (rad).
    pub azimuth: f64,
    /// Height of the wrist at the hit, if the arm gets there (m).
    pub height: f64,
    /// Distance from shoulder to wrist at the hit, as a share of the arm's length.
    pub stretch: f64,
    /// Speed of the wrist at the hit (m/s).
    pub speed: f64,
}

/// Timeline of a clip, as planned.
pub struct BoxingScript {
    /// Keys of the body.
    pub body: KeyTrack<BoxingPosture>,
    /// Keys of the left and right hand, without blows.
    pub hands: [KeyTrack<BoxingHandPose>; 2],
    /// Heading towards the opponent (rad).
    pub facing: KeyTrack<f64>,
    /// Left and right foot.
    pub feet: [BoxerFoot; 2],
    /// Blows in the order of their hits.
    pub strikes: Vec<ScriptedBlow>,
    /// Names of ranges: name, beginning, end (s).
    pub tags: Vec<(&'static str, f64, f64)>,
    /// Length (s).
    pub duration: f64,
    /// Time at which both feet have landed (s).
    pub feet_free: f64,
    centre: DVec2,
}

impl BoxingScript {
    /// A timeline that begins on guard at the origin, facing +Z.
    pub fn new(skeleton: &Skeleton) -> Self {
        let shape = FootShape::from_skeleton(skeleton);
        Self {
            body: KeyTrack::new(BoxingPosture::GUARD),
            hands: BoxingHandPose::GUARD.map(KeyTrack::new),
            facing: KeyTrack::new(0.0),
            feet: [0, 1].map(|i: usize| BoxerFoot::new(shape, place_in_stance(DVec2::ZERO, 0.0, ANKLES[i]), YAWS[i])),
            strikes: Vec::new(),
            tags: Vec::new(),
            duration: 0.0,
            feet_free: 0.0,
            centre: DVec2::ZERO,
        }
    }

    /// Moves both feet one after the other, the one on the side of the move first, so that they never cross.
    ///
    /// - `quickness`: time of a flight as a share of the usual.
    /// - `error`: offset of each foot from its place, to the left and forward (m).
    /// - returns the landing of the second foot (s).
    pub fn shuffle(&mut self, at: f64, shuffle: &Shuffle, quickness: f64, error: [DVec2; 2]) -> f64 {
        let at = at.max(self.feet_free);
        let travel = shuffle.forward.hypot(shuffle.aside);
        let heading = self.facing.last().1;
        let turned = heading + shuffle.turn;
        let middle = heading + 0.5 * shuffle.turn;
        let flight = quickness * (0.17 + 0.24 * travel + 0.07 * shuffle.turn.abs());
        self.facing.hold(at);
        let end = if travel < 0.02 {
            self.pivot(at, turned, flight)
        } else {
            self.centre += forward(middle) * shuffle.forward + leftward(middle) * shuffle.aside;
            let first = first_foot(shuffle);
            let then = self.step(first, at, at + flight, turned, error[first.index()]) + BETWEEN;
            let second = first.other();
            self.step(second, then, then + flight, turned, error[second.index()])
        };
        self.facing.push(end, turned);
        self.tags.extend(shuffle.tag.map(|tag| (tag, at, end)));
        self.feet_free = end + BETWEEN;
        end
    }

    fn step(&mut self, side: LateralSide, lift: f64, land: f64, heading: f64, error: DVec2) -> f64 {
        let i = side.index();
        self.feet[i].step(lift, land, place_in_stance(self.centre, heading, ANKLES[i] + error), heading + YAWS[i]);
        land
    }

    /// Turns on the ball of the lead foot while the rear foot steps around.
    fn pivot(&mut self, at: f64, heading: f64, flight: f64) -> f64 {
        let land = at + flight + 0.05;
        let turned = heading + YAWS[0];
        self.feet[0].turn(at, land, turned);
        let ankle = self.feet[0].last().0;
        self.centre = ankle - place_in_stance(DVec2::ZERO, heading, ANKLES[0]);
        self.step(LateralSide::Right, at + 0.05, land, heading, DVec2::ZERO)
    }
}

/// The foot that moves first: the lead one forward and to its side, the rear one back and to its own.
fn first_foot(shuffle: &Shuffle) -> LateralSide {
    let towards_lead = if shuffle.aside.abs() > shuffle.forward.abs() { shuffle.aside } else { shuffle.forward };
    if towards_lead >= 0.0 { LateralSide::Left } else { LateralSide::Right }
}

/// Position in the stance, on the ground plane (m).
fn place_in_stance(centre: DVec2, heading: f64, offset: DVec2) -> DVec2 {
    centre + leftward(heading) * offset.x + forward(heading) * offset.y
}

#[cfg(test)]
mod tests {
    use super::super::moves::FOOTWORK;
    use super::*;

    #[test]
    fn feet_never_cross_and_one_always_stands() {
        let mut script = BoxingScript::new(&Skeleton::default());
        let mut t = 0.5;
        for shuffle in FOOTWORK.iter().chain(FOOTWORK.iter().rev()) {
            let heading = script.facing.last().1;
            t = script.shuffle(t, shuffle, 1.0, [DVec2::ZERO; 2]) + 0.1;
            let turned = script.facing.last().1;
            let [left, right] = [0, 1].map(|i| script.feet[i].last().0);
            let apart = left - right;
            assert!(
                (apart.dot(leftward(turned)) - 0.27).abs() < 1e-9 && (apart.dot(forward(turned)) - 0.42).abs() < 1e-9
            );
            assert!((turned - heading - shuffle.turn).abs() < 1e-9);
        }
        for k in 0..(t * 200.0) as usize {
            let flights = [0, 1].map(|i| script.feet[i].flight(k as f64 / 200.0).is_some());
            assert!(!(flights[0] && flights[1]));
        }
    }

    #[test]
    fn the_foot_on_the_side_of_the_move_goes_first() {
        let first = |forward, aside| {
            let mut script = BoxingScript::new(&Skeleton::default());
            script.shuffle(1.0, &Shuffle { forward, aside, turn: 0.0, tag: None }, 1.0, [DVec2::ZERO; 2]);
            if script.feet[0].flight(1.1).is_some() { LateralSide::Left } else { LateralSide::Right }
        };
        assert_eq!([first(0.3, 0.0), first(0.0, 0.3)], [LateralSide::Left; 2]);
        assert_eq!([first(-0.3, 0.0), first(0.05, -0.3)], [LateralSide::Right; 2]);
    }
}
