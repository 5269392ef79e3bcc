//! Steering: from a trajectory to a position in the parameter box, with heading, speeds and turning rate eased.

use super::{Control, InertiaConfig, WalkersConfig, block::WalkerBlock};
use crate::blend::{AxisRecord, MAX_AXES, axis};
use crate::{blend::BlendSpace, body::DampedSpring, body::LaneBody, planar::wrap_angle};
use glam::Vec2;
use std::f32::consts::{FRAC_PI_2, PI};
use throng_base::maths;
use throng_base::thresholds::{STANDING_MPS, WALKING_MPS};

/// Fastest change of a parameter that is followed without delay, in widths of the box per second.
const STEADY_PER_S: f32 = 0.8;
/// Change of the turning rate at the end of a turn of the trajectory (rad/s^2).
const TURN_ENDS: f32 = 12.0;
/// Speed below which a body without side steps may face elsewhere than where it goes: its steps are too short to be seen
/// (m/s). Chosen: those whom others push to and fro would spin like tops.
const SHUFFLES_MPS: f32 = 0.5;
/// Speed below which a trajectory has no direction (m/s).
const AT_REST_MPS: f32 = 1e-4;

/// Constants of one step, shared by all walkers.
pub(crate) struct WalkerSteering<'a> {
    pub axes: &'a [AxisRecord],
    /// Parameters are clamped to the box.
    clamped: bool,
    /// True where there are examples of side steps.
    sideways: bool,
    /// True where there are examples of back steps.
    backward: bool,
    dt_s: f32,
    /// Share of a difference that is left after the step.
    keep_heading: f32,
    spring: DampedSpring,
    max_turning_rate: f32,
    inertia: InertiaConfig,
}

impl<'a> WalkerSteering<'a> {
    pub fn new(space: &'a BlendSpace, config: &WalkersConfig, dt_s: f32) -> Self {
        let (axes, half_life_s) = (space.axes(), config.heading_half_life_s);
        Self {
            axes,
            clamped: space.record().extrapolate == 0,
            sideways: space.axis_of(axis::SIDE).is_some(),
            backward: axes.iter().any(|a| a.kind == axis::SPEED && a.low < 0.0),
            dt_s,
            keep_heading: if half_life_s > 0.0 { maths::exp2(-dt_s / half_life_s) } else { 0.0 },
            spring: DampedSpring::new(dt_s, config.parameter_half_life_s),
            max_turning_rate: config.max_turning_rate,
            inertia: config.inertia,
        }
    }

    /// Moves the root of one lane along its trajectory, turns it, and eases its parameters.
    pub fn steer(&self, block: &mut WalkerBlock, body: &LaneBody, lane: usize, order: &mut Control) {
        let given = order.position.take();
        let (position, mut control) = match given {
            Some(position) => (position, *order),
            None => self.advance_trajectory(block, lane, order),
        };
        let speed = control.velocity.length();
        let placed = block.placed[lane] != 0.0;
        if given.is_some() && speed > AT_REST_MPS {
            let course = maths::atan2(control.velocity.x, control.velocity.y);
            let faces_travel = control.heading.is_none() || !self.sideways;
            if placed && faces_travel && self.dt_s > 0.0 && speed.min(block.speed[lane]) > STANDING_MPS {
                // The blend turns as the path does, however the body leans about it.
                let rate = wrap_angle(course - block.course[lane]) / self.dt_s;
                let most = self.max_turning_rate;
                control.turning_rate = control.turning_rate.or(Some(rate.clamp(-most, most)));
            }
            block.course[lane] = course;
        }
        let control = &control;
        let heading = block.root[2][lane];
        let aim = self.aim_heading(block, lane, control, speed);
        let turned = if placed { self.ease_heading(heading, block.aim[lane], aim) } else { wrap_angle(aim) };
        if self.dt_s > 0.0 && placed {
            block.turning[lane] = wrap_angle(turned - heading) / self.dt_s;
        }
        block.aim[lane] = aim;
        block.root[0][lane] = position.x;
        block.root[1][lane] = position.y;
        block.root[2][lane] = turned;
        block.speed[lane] = speed;
        let asked = self.parameters(block, body, lane, control);
        if placed {
            self.ease_parameters(block, lane, &asked);
        } else {
            (block.parameters[lane], block.parameter_rates[lane]) = (asked, [0.0; MAX_AXES]);
        }
        block.asked[lane] = asked;
        block.placed[lane] = 1.0;
    }

    /// Moves a trajectory on whose positions are not given: speed and direction follow the order within the limits of
    /// inertia.
    ///
    /// - returns the position at the end of the step, and the order as far as it is followed.
    fn advance_trajectory(&self, block: &mut WalkerBlock, lane: usize, order: &mut Control) -> (Vec2, Control) {
        let (root, dt_s, inertia) = (block.root(lane), self.dt_s, &self.inertia);
        let (was, mut course) = (block.speed[lane], block.course[lane]);
        let wanted_mps = order.velocity.length();
        let ordered = |order: &Control| maths::atan2(order.velocity.x, order.velocity.y);
        let keeps_heading = order.heading.is_some() && (self.sideways || self.backward);
        if was < AT_REST_MPS {
            // A body that faces where it goes sets off ahead, and turns on its way.
            course = if keeps_heading || order.cut { ordered(order) } else { root.heading };
        }
        let off = wrap_angle(ordered(order) - course);
        order.continue_turn(dt_s);
        let (mut speed, mut turn) = (wanted_mps, order.turning_rate.unwrap_or(0.0));
        if order.cut || dt_s == 0.0 {
            course += if wanted_mps > AT_REST_MPS { off } else { 0.0 };
        } else {
            let closing = (2.0 * TURN_ENDS * off.abs()).sqrt().min(off.abs() / dt_s);
            turn = (turn + closing.copysign(off)).clamp(-self.max_turning_rate, self.max_turning_rate);
            // Who keeps facing elsewhere goes back through a stand.
            let reverses = keeps_heading && off.abs() > FRAC_PI_2;
            let wanted_mps = match wanted_mps < AT_REST_MPS || reverses {
                true => 0.0,
                false => wanted_mps.min(inertia.sideways_mps2 / turn.abs().max(1e-6)),
            };
            speed = wanted_mps.clamp(was - inertia.slowing_down_mps2 * dt_s, was + inertia.speeding_up_mps2 * dt_s);
            let most = if wanted_mps > 0.0 { inertia.sideways_mps2 / speed.max(AT_REST_MPS) } else { 0.0 };
            turn = turn.clamp(-most, most);
        }
        course += turn * dt_s;
        let along = |angle: f32| {
            let (sin, cos) = maths::sin_cos(angle);
            Vec2::new(sin, cos)
        };
        // Exact for a constant acceleration, and of second order on an arc.
        let moved = along(course - 0.5 * turn * dt_s) * (if order.cut { speed } else { 0.5 * (was + speed) } * dt_s);
        block.course[lane] = wrap_angle(course);
        let turning_rate = (speed > STANDING_MPS && wanted_mps > AT_REST_MPS).then_some(turn).or(order.turning_rate);
        let followed = Control { velocity: along(course) * speed, turning_rate, ..*order };
        (Vec2::new(root.x, root.z) + moved, followed)
    }

    /// Follows parameters that change steadily without delay, and eases to those that jump.
    fn ease_parameters(&self, block: &mut WalkerBlock, lane: usize, asked: &[f32; MAX_AXES]) {
        for (k, axis) in self.axes.iter().enumerate() {
            let most = STEADY_PER_S * (axis.high - axis.low);
            let change = asked[k] - block.asked[lane][k];
            let steady = if self.dt_s > 0.0 { (change / self.dt_s).clamp(-most, most) } else { 0.0 };
            let (p, rate) = (&mut block.parameters[lane][k], &mut block.parameter_rates[lane][k]);
            let (left, left_rate) = self.spring.pull_towards_zero(*p - (asked[k] - steady * self.dt_s), *rate - steady);
            (*p, *rate) = (asked[k] + left, steady + left_rate);
        }
    }

    /// Heading to turn to (rad).
    fn aim_heading(&self, block: &WalkerBlock, lane: usize, control: &Control, speed: f32) -> f32 {
        let travel = block.course[lane];
        match control.heading {
            Some(heading) if self.sideways || speed < SHUFFLES_MPS => heading,
            // Without side steps, the body has to face along or against the movement.
            Some(heading) if self.backward && wrap_angle(travel - heading).abs() > FRAC_PI_2 => travel + PI,
            None if speed < STANDING_MPS => block.aim[lane],
            // The forward direction of the blend is aligned with the trajectory's tangent (Kim, Kim and Shin 2003a,
            // section 4.2.3).
            _ => travel - lean(block.travel, lane),
        }
    }

    /// Follows a heading that turns steadily without delay, and eases to one that jumps.
    fn ease_heading(&self, heading: f32, was: f32, aim: f32) -> f32 {
        let most = self.max_turning_rate * self.dt_s;
        let change = wrap_angle(aim - was);
        let steady = if change.abs() <= most { change } else { 0.0 };
        let left = wrap_angle(aim - heading - steady);
        let turn = steady + left * (1.0 - self.keep_heading);
        wrap_angle(heading + turn.clamp(-most, most))
    }

    /// Position in the parameter box for the movement, scaled to the body.
    ///
    /// Bodies of other sizes move alike at equal Froude numbers v^2 / (g l) (Alexander, *The gaits of bipedal and
    /// quadrupedal animals*, 1984): speeds scale with the square root of the leg's length l, and so do times.
    fn parameters(&self, block: &WalkerBlock, body: &LaneBody, lane: usize, control: &Control) -> [f32; MAX_AXES] {
        let (pace, speed) = (body.pace[lane], block.speed[lane]);
        let (sin, cos) = maths::sin_cos(block.root[2][lane]);
        let v = control.velocity / pace;
        let (left, ahead) = (cos * v.x - sin * v.y, sin * v.x + cos * v.y);
        // Without side steps, all movement is ahead or back.
        let ahead = match (self.sideways, ahead < 0.0 && self.backward) {
            (true, _) => ahead,
            (false, true) => -speed / pace,
            (false, false) => speed / pace,
        };
        let turning = control.turning_rate.unwrap_or(block.turning[lane]) * pace;
        let mut styles = control.style.iter();
        let mut p = [0.0; MAX_AXES];
        for (p, axis) in p.iter_mut().zip(self.axes) {
            *p = match axis.kind {
                axis::SPEED => ahead,
                axis::SIDE => left,
                axis::GYRATION => turning,
                _ => styles.next().copied().unwrap_or(0.0),
            };
            // Easing to a point beyond the box would take less time.
            if self.clamped {
                *p = p.clamp(axis.low, axis.high);
            }
        }
        p
    }
}

/// Angle between heading and movement of a blend; 0 if it stands or does not move ahead (rad).
fn lean([left, ahead]: [[f32; 8]; 2], lane: usize) -> f32 {
    let v = Vec2::new(left[lane], ahead[lane]);
    if v.y > WALKING_MPS { maths::atan2(v.x, v.y) } else { 0.0 }
}
