//! Contacts with the geometry of an environment, and height of the support (Lee, Choi and Lee 2006, section 3).

use super::touch::{GeometryTouchConfig, PARTS, SkinPoint, SkinPoints};
use super::{PlacedGeometry, placed::TouchedSurface};
use glam::Vec3;
use throng_core::{Contacts, Skeleton};
use throng_motion::annotate::contacts::{hysteresis, speeds, trim};
use throng_motion::{Clip, annotate::ContactConfig};

/// Part number of the seat.
const SEAT: usize = 6;

/// Largest height of a support that counts as the ground (m).
const ON_GROUND: f32 = 1e-3;

/// Sets `contacts` and `support` of a clip that was captured in an environment.
///
/// A part is planted while a point of its skin is slow and near the geometry or the ground; for the seat only the speed
/// along the surface normal counts, so that it may slide in contact. `contacts` gives speeds, shortest contacts and
/// pauses, `touch` gives distances.
///
/// # Source
/// Lee, Choi and Lee (2006), section 3. Differs: points of the skin in place of joints, with hysteresis.
pub fn annotate_in(
    clip: &mut Clip,
    skeleton: &Skeleton,
    environment: &PlacedGeometry,
    contacts: &ContactConfig,
    touch: &GeometryTouchConfig,
) {
    let probes = SkinPoints::new(skeleton);
    let transforms: Vec<_> = (0..clip.num_frames()).map(|f| clip.joint_transforms(skeleton, f)).collect();
    let path: Vec<Vec3> = clip.root_positions.iter().map(|p| p.with_y(0.0)).collect();
    let pace = speeds(&path, clip.rate_hz);
    let frames = |s: f32| (f64::from(s) * clip.rate_hz).round() as usize;
    clip.contacts = vec![Contacts::NONE; transforms.len()];
    let mut lowest = vec![f32::INFINITY; transforms.len()];
    for (part, bit) in PARTS.into_iter().enumerate() {
        let [on, off] = probes.limits(part, touch);
        let moments = sample_part(&probes, part, &transforms, clip.rate_hz, environment, off);
        let below = |f: usize, distance: f32, speed: f32| {
            let limit = speed * probes.scale + if part == SEAT { 0.0 } else { contacts.speed_share * pace[f] };
            moments[f].is_some_and(|m| m.distance < distance && m.speed < limit)
        };
        let weak: Vec<bool> = (0..transforms.len()).map(|f| below(f, off, contacts.speed_off)).collect();
        let strong: Vec<bool> = (0..transforms.len()).map(|f| below(f, on, contacts.speed_on)).collect();
        let mut planted = hysteresis(&weak, &strong, frames(contacts.min_duration), frames(contacts.max_gap));
        let vertical = contacts.vertical_speed_off * probes.scale;
        trim(&mut planted, |f| part >= 4 || moments[f].is_some_and(|m| m.vertical_speed < vertical));
        for f in (0..planted.len()).filter(|&f| planted[f]) {
            clip.contacts[f].insert(bit);
            if let Some(m) = moments[f] {
                lowest[f] = lowest[f].min(m.height);
            }
        }
    }
    clip.support = hold_values(&lowest);
}

/// Finite values, each held until the next one, and the first also before it. Empty if all are the ground.
fn hold_values(lowest: &[f32]) -> Vec<f32> {
    let mut now = lowest.iter().copied().find(|h| h.is_finite()).unwrap_or(0.0);
    let all: Vec<f32> = lowest
        .iter()
        .map(|h| {
            now = if h.is_finite() { *h } else { now };
            if now.abs() < ON_GROUND { 0.0 } else { now }
        })
        .collect();
    if all.iter().all(|h| *h == 0.0) { Vec::new() } else { all }
}

/// Sample of a part near a surface.
#[derive(Clone, Copy)]
struct PartSample {
    /// Distance of the nearest point of the part's skin (m).
    distance: f32,
    /// Speed of that point; for the seat along the surface normal only (m/s).
    speed: f32,
    /// Vertical speed (m/s).
    vertical_speed: f32,
    /// Height of the surface there (m).
    height: f32,
}

/// Motion of one part relative to nearby surfaces; `None` with no surface near (num_frames).
fn sample_part(
    probes: &SkinPoints,
    part: usize,
    transforms: &[[(Vec3, glam::Quat); throng_core::NUM_JOINTS]],
    rate_hz: f64,
    environment: &PlacedGeometry,
    limit: f32,
) -> Vec<Option<PartSample>> {
    let points = probes.points_of(part);
    let positions = |p: &SkinPoint| transforms.iter().map(|t| p.position(t)).collect();
    let tracks: Vec<Vec<Vec3>> = points.iter().map(positions).collect();
    let velocities: Vec<Vec<Vec3>> = tracks.iter().map(|t| velocities(t, rate_hz)).collect();
    let at = |f: usize| {
        let mut near: Option<(usize, TouchedSurface)> = None;
        for (k, probe) in points.iter().enumerate() {
            let within = near.map_or(limit, |n| n.1.distance);
            let Some(t) = environment.nearest(tracks[k][f], within + probe.radius) else { continue };
            near = Some((k, TouchedSurface { distance: t.distance - probe.radius, ..t }));
        }
        let (k, touched) = near?;
        let v = velocities[k][f];
        let speed = if part == SEAT { v.dot(touched.normal).abs() } else { v.length() };
        Some(PartSample { distance: touched.distance, speed, vertical_speed: v.y.abs(), height: touched.point.y })
    };
    (0..transforms.len()).map(at).collect()
}

/// Velocity at each frame by central differences, one-sided at the ends (m/s).
fn velocities(positions: &[Vec3], rate_hz: f64) -> Vec<Vec3> {
    let last = positions.len().saturating_sub(1);
    let at = |f: usize| {
        let (a, b) = (f.saturating_sub(1), (f + 1).min(last));
        (positions[b] - positions[a]) * (rate_hz as f32 / (b - a).max(1) as f32)
    };
    (0..positions.len()).map(at).collect()
}

#[cfg(test)]
mod tests;
