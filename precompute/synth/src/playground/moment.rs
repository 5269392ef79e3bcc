//! A body at one instant in the gym, and the blending of motions.

use crate::foot::FootPose;
use crate::frame::{ArmPose, BodyPose};
use crate::signal::{PieceEnd, quintic};
use throng_core::{Contacts, planar::wrap_angle};

/// A body at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMoment {
    /// The pose.
    pub body: BodyPose,
    /// Contacts other than those of the feet.
    pub hand_contacts: Contacts,
    /// Height of the seat's contact, while it carries (m).
    pub seat: Option<f64>,
}

impl BodyMoment {
    /// Moment of a body on its feet.
    pub fn upright(body: BodyPose) -> Self {
        Self { body, hand_contacts: Contacts::NONE, seat: None }
    }

    /// Height of the lowest contact of a foot or the seat (m).
    pub fn support(&self) -> Option<f64> {
        let feet = self.body.feet.iter().filter(|f| f.heel_down || f.toe_down).map(|f| f.ground);
        feet.chain(self.seat).reduce(f64::min)
    }

    /// Interpolates between this moment and another one.
    pub fn mixed(&self, to: &Self, share: f64) -> Self {
        let (a, b) = (&self.body, &to.body);
        let near = if share < 0.5 { self } else { to };
        let body = BodyPose {
            root: a.root.lerp(b.root, share),
            hips: a.hips.slerp(b.hips, share),
            trunk: std::array::from_fn(|i| a.trunk[i].slerp(b.trunk[i], share)),
            arms: [0, 1].map(|i: usize| mix_arms(&a.arms[i], &b.arms[i], share)),
            feet: [0, 1].map(|i: usize| mix_feet(&a.feet[i], &b.feet[i], share)),
            knees: [0, 1].map(|i: usize| a.knees[i].lerp(b.knees[i], share)),
        };
        Self { body, hand_contacts: near.hand_contacts, seat: near.seat }
    }
}

/// Interpolates between two poses of an arm.
pub fn mix_arms(a: &ArmPose, b: &ArmPose, share: f64) -> ArmPose {
    ArmPose {
        clavicle: a.clavicle.slerp(b.clavicle, share),
        upper_arm: a.upper_arm.slerp(b.upper_arm, share),
        forearm: a.forearm.slerp(b.forearm, share),
        hand: a.hand.slerp(b.hand, share),
    }
}

/// Interpolates between two poses of a foot; a part carries if it carries in both.
pub fn mix_feet(a: &FootPose, b: &FootPose, share: f64) -> FootPose {
    let mix = |a: f64, b: f64| a + (b - a) * share;
    FootPose {
        ankle: a.ankle.lerp(b.ankle, share),
        ball: a.ball.lerp(b.ball, share),
        yaw: mix_turn(a.yaw, b.yaw, share),
        heading: mix_turn(a.heading, b.heading, share),
        pitch: mix(a.pitch, b.pitch),
        toe_pitch: mix(a.toe_pitch, b.toe_pitch),
        ground: mix(a.ground, b.ground),
        heel_down: a.heel_down && b.heel_down,
        toe_down: a.toe_down && b.toe_down,
    }
}

/// Appends `next` to `first`, crossfading over `overlap` moments.
pub fn crossfade(first: &mut Vec<BodyMoment>, next: Vec<BodyMoment>, overlap: usize) {
    let overlap = overlap.min(first.len()).min(next.len());
    let start = first.len() - overlap;
    for (k, moment) in next.iter().take(overlap).enumerate() {
        let share = ease_in_out((k as f64 + 0.5) / overlap as f64);
        first[start + k] = first[start + k].mixed(moment, share);
    }
    first.extend(next.into_iter().skip(overlap));
}

/// Interpolates between two headings, the shorter way round.
pub fn mix_turn(a: f64, b: f64, share: f64) -> f64 {
    a + f64::from(wrap_angle((b - a) as f32)) * share
}

/// Smooth step from 0 to 1 over `u` in `[0, 1]`, at rest at both ends.
pub fn ease_in_out(u: f64) -> f64 {
    quintic(PieceEnd::at_rest(0.0), PieceEnd::at_rest(1.0), 1.0, u.clamp(0.0, 1.0))
}
