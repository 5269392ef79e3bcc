//! Finds the length of a unit and the up axis of a source from the size and pose of its body.

use super::{ADULT_HEIGHT, HEIGHTS, ImportConfig, RoleMap, SourceClip, UpAxis, content_error, rounded};
use crate::error::{ImportError, ensure};
use crate::raw::RawClip;
use glam::{Quat, Vec3};
use throng_core::Joint;

/// Units of files (m), and the rarity of each. It is added to the distance of a body in this unit from the typical height
/// (logarithm of their ratio), and the least sum is taken: a child in centimetres is likelier than a giant in inches.
const UNITS: [(f64, f64, &str); 7] = [
    (1.0, 0.0, "metres"),
    (0.01, 0.0, "centimetres"),
    (0.001, 0.1, "millimetres"),
    (0.0254, 0.15, "inches"),
    (0.0254 / 0.45, 0.15, "units of 1/0.45 inch, as in the CMU database"),
    (0.1, 0.4, "decimetres"),
    (0.3048, 0.4, "feet"),
];
/// Height that the candidates are compared with (m).
const TYPICAL_HEIGHT: f64 = 1.7;
/// Ankle height as a fraction of body height (Winter, *Biomechanics and Motor Control of Human Movement*).
const ANKLE: f32 = 0.039;
/// From the head joint to the crown as a fraction of body height; the proportions of the default skeleton.
const HEAD: f32 = 0.115;
/// From the neck joint to the crown, where there is no head joint.
const NECK_AND_HEAD: f32 = 0.17;
/// Most frames that are examined.
const MAX_SAMPLES: usize = 60;

/// Frames spread evenly over a clip, at most `max`.
pub(super) fn sample_frames(num_frames: usize, max: usize) -> impl Iterator<Item = usize> {
    let n = num_frames.min(max);
    (0..n).map(move |i| i * num_frames / n)
}

/// Body height from the lengths of the segments in the first frame, whatever the pose; in units of the clip.
///
/// Legs, trunk and neck are added up along their chains; the ankle's height above the ground and, where the
/// file has no segment for it, the head are added as fractions of the whole.
pub(super) fn body_height(clip: &RawClip, roles: &RoleMap) -> f32 {
    use Joint::*;
    let world = clip.world(0);
    let at = |role: Joint| roles.get(role).map(|j| world[j].0);
    let mid = |a: Joint, b: Joint| Some((at(a)? + at(b)?) * 0.5);
    let hips_to_legs = at(Hips).zip(mid(LeftThigh, RightThigh)).map_or(0.0, |(h, m)| h.distance(m));
    let leg = |thigh, shin, foot| path_length(clip, roles, thigh, shin) + path_length(clip, roles, shin, foot);
    let legs = 0.5 * (leg(LeftThigh, LeftShin, LeftFoot) + leg(RightThigh, RightShin, RightFoot));
    let top = if roles.get(Head).is_some() { Head } else { Neck };
    let trunk = path_length(clip, roles, Hips, top);
    let known = hips_to_legs + legs + trunk;
    let fraction = if top == Head { HEAD } else { NECK_AND_HEAD };
    let head = roles.get(Head).map_or(0.0, |h| longest_end(clip, h));
    let guessed = known / (1.0 - ANKLE - fraction);
    guessed.max((known + head) / (1.0 - ANKLE))
}

/// Length along the joints from a role to another one, by way of the nearest joint above both, in the first frame.
fn path_length(clip: &RawClip, roles: &RoleMap, from: Joint, to: Joint) -> f32 {
    let (Some(from), Some(to)) = (roles.get(from), roles.get(to)) else { return 0.0 };
    let up = |j: usize| std::iter::successors(Some(j), |&j| clip.joints[j].parent);
    let is_above = |j: &usize, other: usize| up(other).any(|k| k == *j);
    let length = |j: usize, other: usize| -> f32 {
        up(j).take_while(|k| !is_above(k, other)).map(|k| clip.translations[k].length()).sum()
    };
    length(from, to) + length(to, from)
}

/// Length of the longest end of a chain that hangs on a joint.
fn longest_end(clip: &RawClip, joint: usize) -> f32 {
    let ends = clip.joints.iter().enumerate().filter(|(_, j)| j.is_end && j.parent == Some(joint));
    ends.map(|(i, _)| clip.translations[i].length()).fold(0.0, f32::max)
}

/// The length of a unit, and a sentence with the reason.
///
/// # Errors
/// [`ImportError::Content`] for a skeleton without size and for an override that is not above 0.
pub(super) fn find_unit(source: &mut SourceClip, roles: &RoleMap, config: &ImportConfig) -> Result<f64, ImportError> {
    let height = f64::from(body_height(&source.clip, roles));
    let path = source.clip.path.clone();
    let (has_size, help) = (height.is_finite() && height > 1e-6, "Check the offsets or lengths of its joints");
    ensure(has_size, || content_error(&path, "the skeleton has no size", help))?;
    let in_metres = |unit: f64| format!("the body is {height:.4} units or {:.2} m tall", height * unit);
    if let Some(unit) = config.metres_per_unit {
        let is_unit = unit.is_finite() && unit > 0.0;
        ensure(is_unit, || content_error(&path, "`metres_per_unit` must be above 0", "Correct it"))?;
        source.findings.push(format!("{unit} m a unit: as given; {}.", in_metres(unit)));
        return Ok(unit);
    }
    if let Some(unit) = source.declared_metres_per_unit {
        if HEIGHTS.contains(&((height * unit) as f32)) {
            source.findings.push(format!("{unit:.6} m a unit: the file says so, and {}.", in_metres(unit)));
            return Ok(unit);
        }
        source.warnings.push(format!("{}: by the units that it names {}: ignored.", path.display(), in_metres(unit)));
    }
    let unlikely = |(unit, rare, _): (f64, f64, _)| (height * unit / TYPICAL_HEIGHT).ln().abs() + rare;
    let likeliest = UNITS.into_iter().min_by(|a, b| unlikely(*a).total_cmp(&unlikely(*b)));
    let (unit, _, name) = likeliest.unwrap_or(UNITS[0]);
    if !HEIGHTS.contains(&((height * unit) as f32)) {
        // A rig of a person, in a size of its own: motion is laid onto one body anyway.
        let unit = rounded(f64::from(ADULT_HEIGHT) / height);
        let sentence = format!(
            "{unit} m a unit: no usual unit fits {height:.4} units, so the body is taken as {ADULT_HEIGHT} m tall"
        );
        let warning = format!("{sentence} (`--metres-per-unit`, or `import.metres_per_unit`, says otherwise).");
        source.warnings.push(format!("{}: {warning}", path.display()));
        source.findings.push(format!("{sentence}."));
        return Ok(unit);
    }
    source.findings.push(format!("{unit:.6} m a unit ({name}): then {}.", in_metres(unit)));
    Ok(unit)
}

/// The up axis, and a sentence with the reason.
pub(super) fn find_up(source: &mut SourceClip, roles: &RoleMap, config: &ImportConfig) -> UpAxis {
    if let Some(up) = config.up {
        source.findings.push(format!("{} is up: as given.", up.letter()));
        return up;
    }
    let clip = &source.clip;
    let frames: Vec<_> = sample_frames(clip.num_frames, MAX_SAMPLES).collect();
    let sum: Vec3 = frames.iter().map(|&f| feet_to_head(&clip.world(f), roles)).sum();
    let mean = sum / frames.len().max(1) as f32;
    let of_motion = clear_axis(mean).map(|up| {
        let share = 100.0 * mean.dot(axis_vector(up));
        (up, format!("from the feet to the head the motion points {share:.0} % along it"))
    });
    let of_rest = || clear_axis(feet_to_head(&rest_world(clip), roles));
    let rest = "the rest pose stands along it; the motion does not tell";
    if let Some((up, why)) = of_motion.or_else(|| Some((of_rest()?, rest.into()))) {
        source.findings.push(format!("{} is up: {why}.", up.letter()));
        return up;
    }
    let path = clip.path.display().to_string();
    source.warnings.push(format!("{path}: neither motion nor rest pose stands upright along +Y or +Z; Y is taken as up (`--up`, or `import.up`, overrides it)."));
    source.findings.push("Y is up: nothing tells otherwise.".into());
    UpAxis::Y
}

/// The axis that a mean direction of a body points along, where that is clear.
fn clear_axis(mean: Vec3) -> Option<UpAxis> {
    [UpAxis::Y, UpAxis::Z].into_iter().find(|&up| mean.dot(axis_vector(up)) > 0.7)
}

fn axis_vector(up: UpAxis) -> Vec3 {
    [Vec3::Y, Vec3::Z][up as usize]
}

/// Unit vector from between the feet to the head.
pub(super) fn feet_to_head(world: &[(Vec3, Quat)], roles: &RoleMap) -> Vec3 {
    use Joint::*;
    let at = |role: Joint| roles.get(role).map(|j| world[j].0);
    let feet = at(LeftFoot).zip(at(RightFoot)).map(|(l, r)| (l + r) * 0.5);
    at(Head).or(at(Neck)).zip(feet).map_or(Vec3::ZERO, |(h, f)| (h - f).normalize_or_zero())
}

/// World transforms of all joints when every rotation is zero.
pub(super) fn rest_world(clip: &RawClip) -> Vec<(Vec3, Quat)> {
    let mut out: Vec<(Vec3, Quat)> = Vec::with_capacity(clip.joints.len());
    for joint in &clip.joints {
        let base = joint.parent.map_or(Vec3::ZERO, |p| out[p].0);
        out.push((base + joint.offset, Quat::IDENTITY));
    }
    out
}

/// Brings a clip into metres and Y up. Rest rotations stay the identity: offsets and motion turn together.
pub(super) fn normalise(clip: &mut RawClip, metres_per_unit: f64, up: UpAxis) {
    let scale = metres_per_unit as f32;
    let turn = |v: Vec3| match up {
        UpAxis::Y => v,
        UpAxis::Z => Vec3::new(v.x, v.z, -v.y),
    };
    clip.joints.iter_mut().for_each(|joint| joint.offset = turn(joint.offset) * scale);
    clip.translations.iter_mut().for_each(|t| *t = turn(*t) * scale);
    if up == UpAxis::Z {
        for r in &mut clip.rotations {
            let axis = turn(r.xyz());
            *r = Quat::from_xyzw(axis.x, axis.y, axis.z, r.w);
        }
    }
}
