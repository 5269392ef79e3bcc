//! Steps of the feet in each gait.

use super::motion_set::{GaitKind, LocomotionAct};
use crate::walk::gait::step_at;
use crate::walk::wander::{STANDING_WIDTH, TOE_OUT, WALKING_WIDTH};

/// Steps of a steady gait, equal for both feet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride {
    /// Time from landing to landing of the other foot (s).
    pub period: f64,
    /// Time for which a foot is on the ground (s, < 2 period).
    pub stance: f64,
    /// Distance between the feet across the path, measured under the body (m).
    pub width: f64,
    /// Position of the ankle in front of the body at that moment (m).
    pub ahead: f64,
    /// Time from landing to standing flat (s).
    pub landing: f64,
    /// Time from the heel's rise to the ball's (s).
    pub rise: f64,
    /// Pitch at heel strike, toes up; negative if the ball lands first (rad).
    pub strike: f64,
    /// Pitch as the ball rises, heel up (rad).
    pub push: f64,
    /// Outward turn of the foot (rad).
    pub toe_out: f64,
}

impl Stride {
    /// Stride of an act that travels or turns.
    pub fn for_act(act: &LocomotionAct) -> Self {
        let speed = act.drive.speed();
        let neutral = match act.gait {
            GaitKind::Idle | GaitKind::Turn => pivot_stride(),
            GaitKind::Side => side_stride(speed),
            GaitKind::Back => back_stride(speed),
            GaitKind::Walk => walk_stride(speed),
            GaitKind::Jog | GaitKind::Run => run_stride(speed),
        };
        let m = act.manner;
        // Runners vary less.
        let part = |factor: f64| if act.gait.flies() { 1.0 + 0.4 * (factor - 1.0) } else { factor };
        let (cadence, roll) = (part(m.cadence), part(m.roll));
        let period = neutral.period / cadence;
        let scale = part(m.stance) / cadence;
        // A runner is never on both feet, a walker always is for a moment.
        let stance = neutral.stance * scale;
        let stance = if act.gait.flies() { stance.min(0.9 * period) } else { stance.max(1.08 * period) };
        Self {
            period,
            stance,
            width: neutral.width * if act.gait == GaitKind::Side { 1.0 } else { m.width },
            landing: neutral.landing * scale,
            rise: neutral.rise * scale,
            strike: neutral.strike * roll,
            push: neutral.push * roll,
            toe_out: neutral.toe_out + m.toe_out,
            ..neutral
        }
    }
}

fn walk_stride(speed: f64) -> Stride {
    let step = step_at(speed);
    Stride {
        period: step.period,
        stance: step.period + step.double_support,
        width: WALKING_WIDTH,
        ahead: 0.0,
        landing: (0.15 * step.period).clamp(0.07, 0.1),
        rise: 0.46 * step.period,
        strike: 0.36 * (step.length / 0.75).min(1.0),
        push: 0.2 + 0.5 * (2.0 * step.length / 1.45).min(1.0),
        toe_out: TOE_OUT,
    }
}

fn pivot_stride() -> Stride {
    Stride {
        period: 0.58,
        stance: 0.74,
        width: STANDING_WIDTH,
        ahead: 0.0,
        landing: 0.08,
        rise: 0.2,
        strike: 0.02,
        push: 0.26,
        toe_out: TOE_OUT,
    }
}

fn side_stride(speed: f64) -> Stride {
    let period = 0.64 - 0.25 * speed;
    Stride { period, stance: period + 0.14, width: 0.15 + speed * period, push: 0.24, ..pivot_stride() }
}

fn back_stride(speed: f64) -> Stride {
    let period = 0.72 - 0.17 * speed;
    Stride {
        period,
        stance: period + 0.15,
        width: 0.15,
        landing: 0.14,
        strike: -0.1 - 0.25 * speed,
        push: 0.2,
        ..pivot_stride()
    }
}

/// # Source
/// Cadence, contact times and the angles of the swing (see `swing`) follow Novacheck 1998, *The biomechanics of
/// running*. Differs: a contact ends here when the ball of the foot leaves the ground, some 20 ms before the toes.
fn run_stride(speed: f64) -> Stride {
    let faster = speed - 2.0;
    let period = 0.385 - 0.0175 * faster - 0.0015 * faster * faster;
    let travel = 0.64 + 0.12 * faster - 0.011 * faster * faster;
    let stance = travel / speed;
    Stride {
        period,
        stance,
        width: 0.1,
        ahead: -0.175 + 0.009 * faster,
        landing: 0.22 * stance,
        rise: 0.64 * stance,
        strike: (0.2 - 0.04 * faster).max(0.06),
        push: 1.03 + 0.04 * faster,
        toe_out: 0.06,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walkers_are_always_on_the_ground_and_runners_fly_longer_the_faster_they_are() {
        for act in LocomotionAct::all().iter().filter(|a| a.gait != GaitKind::Idle) {
            let s = Stride::for_act(act);
            assert_eq!(s.stance < s.period, act.gait.flies(), "{}", act.name(0));
            assert!(s.landing + s.rise < s.stance && s.stance < 1.9 * s.period, "{}: {s:?}", act.name(0));
        }
        let flight = |speed| run_stride(speed).period - run_stride(speed).stance;
        assert!((0.04..0.08).contains(&flight(2.0)) && flight(3.5) > flight(2.5) && flight(5.0) > 0.1);
    }

    #[test]
    fn the_toes_of_runners_leave_at_about_a_third_of_the_cycle() {
        for speed in [3.2, 3.8, 4.4, 5.0] {
            let s = run_stride(speed);
            assert!((0.28..0.37).contains(&(s.stance / (2.0 * s.period))), "{speed}: {s:?}");
        }
    }
}
