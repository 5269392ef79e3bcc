//! Excess over limits, from where a segment points and how it is turned about itself.

use crate::limits::{JointLimits, SwingLimit};
use glam::{DMat3, DQuat, DVec3, Quat};

/// Excess of a rotation over the limits of its joint; negative inside (rad).
pub(crate) fn limit_excess(limits: &JointLimits, rotation: Quat) -> f64 {
    let q = rotation.as_dquat().normalize();
    // In a mirror at x = 0 a rotation matrix R becomes M R M.
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let r = DMat3::from_quat(q);
    let r = if limits.mirrored { mirror * r * mirror } else { r };
    let r = DMat3::from_quat(limits.centre).transpose() * r;
    // The swing leads from the segment at rest to where it points, straight.
    let to = r * limits.segment;
    let angle = limits.segment.angle_between(to);
    let across = limits.segment.cross(to);
    let swing = across.try_normalize().map_or(DVec3::ZERO, |axis| axis * angle);
    // The rest is twist: the angle of an axis across the segment from where the swing alone would turn it.
    let carried = DQuat::from_rotation_arc(limits.segment, to) * limits.axes[0];
    let found = r * limits.axes[0];
    let twist = carried.cross(found).dot(to).atan2(carried.dot(found));
    let [x, y] = limits.axes.map(|a| swing.dot(a));
    let by_swing = match limits.swing {
        SwingLimit::Ellipse([a, b]) => ((x / a).powi(2) + (y / b).powi(2)).sqrt().mul_add(a.min(b), -a.min(b)),
        SwingLimit::Hinge { flexion, play } => (flexion.least - x).max(x - flexion.most).max(y.abs() - play),
    };
    by_swing.max(limits.twist.least - twist).max(twist - limits.twist.most)
}
