//! Every stored index against its table, every number for being finite.

mod activities;
mod blends;
mod patches;
mod stops;

pub(super) use activities::activities;
pub(super) use blends::blends;
pub(super) use patches::{patches, pose_groups};
pub(super) use stops::stops;

use super::{Bundle, tags};
use crate::format::{FormatError, FrameRow};
use crate::planar::{Planar, wrap_angle};
use crate::policy::ActionTable;
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};

/// Roots are nearer to the origin of their clip: so far apart that characters of damaged motion, too, take long to get where
/// numbers are too coarse to be saved (m, rad).
const FARTHEST: f32 = 1e4;

/// Largest distance of a root from one frame to the next, and from one node of a sweep to the next: beyond it, paths
/// that are too far apart cannot be told from paths that touch (m).
const LEAP: f32 = 100.0;

/// Joints are nearer to their parents (m).
const LONGEST_BONE: f32 = 10.0;

/// Largest deviation of segments and sweeps from the frames that they stand for, by rounding (m, rad).
const ASTRAY: f32 = 0.02;

/// Planar root of a frame relative to another frame (both < number of frames).
fn root_seen_from(t: &Bundle, from: u32, frame: u32) -> Planar {
    let [from, to] = [from, frame].map(|f| {
        let [x, z, heading] = t.frames()[f as usize].planar;
        Planar::new(x, z, heading)
    });
    from.to_local(to)
}

/// True where a root is at a place; false where either is not a number.
fn is_near(root: Planar, x: f32, z: f32) -> bool {
    (root.x - x).abs() < ASTRAY && (root.z - z).abs() < ASTRAY
}

/// Offsets are those of a body, and legs have a length.
pub(super) fn skeleton(s: &Skeleton) -> Result<(), FormatError> {
    for (i, o) in s.offsets.iter().chain(&s.tips).enumerate() {
        if !(o.is_finite() && o.abs().max_element() < LONGEST_BONE) {
            return Err(FormatError::value(tags::SKELETON, 0, format!("offset {i} is {o}, not a length in metres")));
        }
    }
    for j in [Joint::LeftShin, Joint::LeftFoot, Joint::RightShin, Joint::RightFoot] {
        if s.offsets[j.index()].length() < 1e-3 {
            return Err(FormatError::value(tags::SKELETON, 0, format!("{} lies in its parent", j.name())));
        }
    }
    Ok(())
}

/// Clips tile the frames; rows are finite, their rotations not zero; contacts have seven bits and a byte a frame.
pub(super) fn motion(t: &Bundle) -> Result<(), FormatError> {
    let (frames, contacts) = (t.frames(), t.contacts());
    if contacts.len() != frames.len() {
        return Err(FormatError::layout(format!("{} contacts for {} frames", contacts.len(), frames.len())));
    }
    if t.meta().clips.len() != t.clips().len() {
        let (names, clips) = (t.meta().clips.len(), t.clips().len());
        return Err(FormatError::layout(format!("META names {names} clips, there are {clips}")));
    }
    let mut next = 0u64;
    for (i, c) in t.clips().iter().enumerate() {
        if u64::from(c.first_frame) != next || c.num_frames == 0 || c.mirrored > 1 || c.reserved != 0 {
            return Err(FormatError::value(tags::CLIPS, i, format!("it does not follow the clip before it: {c:?}")));
        }
        next += u64::from(c.num_frames);
    }
    if next != frames.len() as u64 {
        return Err(FormatError::layout(format!("clips hold {next} frames, there are {}", frames.len())));
    }
    let code = t.rotation_code();
    if let Some(j) = code.joints.iter().position(|c| !c.is_sound()) {
        return Err(FormatError::value(tags::ROTATION_CODE, j, "its field cannot be"));
    }
    for (i, row) in frames.iter().enumerate() {
        let moderate = row.planar.iter().chain([&row.height]).all(|v| v.abs() < FARTHEST);
        // Interpolation between neighbours must not meet a zero quaternion; half of unit length is far from that.
        if !moderate || !code.joints.iter().all(|c| (0.5..1.5).contains(&c.coded(row).length())) {
            return Err(FormatError::value(tags::FRAMES, i, "it holds a number that cannot be"));
        }
    }
    for c in t.clips() {
        let rows = &frames[c.first_frame as usize..][..c.num_frames as usize];
        let leaps = |w: &[FrameRow]| [0, 1].iter().any(|&k| (w[0].planar[k] - w[1].planar[k]).abs() > LEAP);
        if let Some(k) = rows.windows(2).position(leaps) {
            let i = c.first_frame as usize + k;
            return Err(FormatError::value(
                tags::FRAMES,
                i,
                format!("its root leaps by more than {LEAP} m to the next one"),
            ));
        }
    }
    rotations_continue(t)?;
    match contacts.iter().position(|c| c.0 > 127) {
        Some(i) => Err(FormatError::value(tags::CONTACTS, i, format!("{} is not seven bits", contacts[i].0))),
        None => Ok(()),
    }
}

/// Hits ascend by frame, name frames, joints and kinds that exist, and have moderate numbers.
pub(super) fn hits(t: &Bundle) -> Result<(), FormatError> {
    let (hits, num_kinds) = (t.hits(), t.meta().hit_kinds().count());
    for (i, h) in hits.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::HITS, i, format!("{what}: {h:?}")));
        if h.frame as usize >= t.frames().len() || i > 0 && hits[i - 1].frame > h.frame {
            return wrong("its frame does not exist or comes before the last one");
        }
        if h.kind as usize >= num_kinds || h.joint as usize >= NUM_JOINTS || h.reserved != 0 {
            return wrong("no such kind or joint");
        }
        let moderate = h.position.iter().chain([&h.speed_mps]).all(|v| v.abs() < 1e6) && h.speed_mps >= 0.0;
        let unit = (h.direction().length() - 1.0).abs() < 1e-3;
        if !(moderate && unit && h.force > 0.0 && h.force <= 1.0) {
            return wrong("it holds a number that cannot be");
        }
    }
    Ok(())
}

/// Neighbouring frames of a clip have rotations on the same side, so that interpolation never meets zero.
fn rotations_continue(t: &Bundle) -> Result<(), FormatError> {
    for c in t.clips() {
        let first = c.first_frame as usize;
        let rows = &t.frames()[first..first + c.num_frames as usize];
        for (i, pair) in rows.windows(2).enumerate() {
            if !t.rotation_code().joints.iter().all(|c| c.continues(&pair[0], &pair[1])) {
                return Err(FormatError::value(tags::FRAMES, first + i, "its rotations do not continue in the next"));
            }
        }
    }
    Ok(())
}

/// States and segments lie in the frames, segments inside their clips and end where their state is, actions exist.
pub(super) fn graph(t: &Bundle) -> Result<(), FormatError> {
    let g = t.graph();
    let num_frames = t.frames().len();
    for (i, s) in g.states.iter().enumerate() {
        if s.frame as usize >= num_frames || s.standing > 1 {
            return Err(FormatError::value(tags::STATES, i, format!("no such frame, there are {num_frames}: {s:?}")));
        }
    }
    for (i, s) in g.segments.iter().enumerate() {
        let wrong = |what: &str| Err(FormatError::value(tags::SEGMENTS, i, format!("{what}: {s:?}")));
        let Some(clip) = t.clips().get(s.clip as usize) else {
            return wrong("no such clip");
        };
        let Some(end) = g.states.get(s.end as usize) else {
            return wrong("no such end state");
        };
        let last = u64::from(s.start) + u64::from(s.num_frames);
        let clip_end = u64::from(clip.first_frame) + u64::from(clip.num_frames);
        if s.num_frames == 0 || s.start < clip.first_frame || last >= clip_end || last != u64::from(end.frame) {
            return wrong("it leaves its clip or does not end at its state");
        }
        let (stored, shown) = (s.displacement(), root_seen_from(t, s.start, last as u32));
        let turned = wrap_angle(stored.heading - shown.heading).abs();
        let is_there = is_near(shown, stored.x, stored.z) && turned < ASTRAY && stored.heading.abs() < FARTHEST;
        if !is_there || s.reserved != 0 {
            return wrong("its displacement is not that of its frames");
        }
    }
    if g.action_offsets.len() != g.states.len() + 1 {
        let (states, offsets) = (g.states.len(), g.action_offsets.len());
        return Err(FormatError::layout(format!("{offsets} action offsets for {states} states")));
    }
    if g.states.is_empty() && t.patches().patches.is_empty() && t.blends().spaces.is_empty() {
        return Err(FormatError::layout(
            "there is neither a motion graph nor a motion patch nor a blend space: nothing can be played",
        ));
    }
    if let Some(i) = g.action_errors.iter().position(|e| !(*e >= 0.0 && *e < 1e9)) {
        return Err(FormatError::value(tags::ACTION_ERRORS, i, format!("{} is no distance", g.action_errors[i])));
    }
    ActionTable::new(&g.action_offsets, &g.action_segments, &g.action_errors, g.segments.len())
        .map_err(|e| FormatError::layout(e.to_string()))?;
    let mut entered = vec![false; g.states.len()];
    g.segments.iter().for_each(|s| entered[s.end as usize] = true);
    if let Some(i) = entered.iter().position(|e| !e) {
        return Err(FormatError::value(tags::STATES, i, "no segment leads to it"));
    }
    let state = g.states.windows(2).position(|w| w[0].frame > w[1].frame).map(|i| (tags::STATES, i));
    let segment = g.segments.windows(2).position(|w| w[0].start > w[1].start).map(|i| (tags::SEGMENTS, i));
    match state.or(segment) {
        Some((tag, i)) => Err(FormatError::value(tag, i + 1, "it does not follow the one before it")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characters::made_up;
    use crate::format::{AlignedBytes, RotationCode, SectionLayout, SectionTag};
    use crate::graph::MotionSegment;

    /// Error message of a bundle whose section has been changed.
    fn refusal<T: bytemuck::Pod>(tag: SectionTag, change: impl FnOnce(&mut [T])) -> String {
        let mut bytes = AlignedBytes::from_slice(&made_up::bytes(&[], false));
        let range = SectionLayout::read(bytes.as_slice(), false).unwrap().section::<T>(tag).unwrap();
        change(bytemuck::cast_slice_mut(&mut bytes.as_mut_slice()[range]));
        Bundle::from_bytes_unverified(bytes).unwrap_err().to_string()
    }

    #[test]
    fn segments_ascend_by_their_starts() {
        let e = refusal::<MotionSegment>(tags::SEGMENTS, |s| s.swap(1, 2));
        assert!(e.contains("section SEGM, element 2: it does not follow the one before it"), "{e}");
    }

    #[test]
    fn a_middle_whose_w_is_one_is_the_identity() {
        let e = refusal::<RotationCode>(tags::ROTATION_CODE, |c| c[0].joints[3].centre = [0.04, 0.0, 0.0, 1.0]);
        assert!(e.contains("section RCOD, element 3: its field cannot be"), "{e}");
    }
}
