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
use crate::format::{ClassSpan, FormatError, FrameRow, SectionTag};
use crate::planar::{Planar, wrap_angle};
use crate::policy::ActionTable;
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use throng_base::error::ensure;

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

/// Fails with a fault of an element of a section, where one has it.
pub(super) fn refuse(tag: SectionTag, element: Option<usize>, fault: &str) -> Result<(), FormatError> {
    element.map_or(Ok(()), |i| Err(FormatError::value(tag, i, fault)))
}

/// Fails with a fault, and the name, where two names are equal.
fn check_unique<'a>(names: impl Iterator<Item = &'a String>, fault: &str) -> Result<(), FormatError> {
    let mut names: Vec<_> = names.collect();
    names.sort_unstable();
    let twice = names.windows(2).find(|pair| pair[0] == pair[1]);
    twice.map_or(Ok(()), |pair| Err(FormatError::layout(format!("{fault} `{}`", pair[0]))))
}

/// Fails unless the parts of the bundle of some kind use all elements of a section.
pub(super) fn check_used(tag: SectionTag, len: usize, used: u64, parts: &str) -> Result<(), FormatError> {
    let fault = || format!("section {tag} has {len} elements, its {parts} need {used}");
    ensure(len as u64 == used, || FormatError::layout(fault()))
}

/// Planar root of a frame relative to another frame (both < number of frames).
fn root_seen_from(t: &Bundle, from: u32, frame: u32) -> Planar {
    let [from, to] = [from, frame].map(|f| Planar::from_array(t.frames()[f as usize].planar));
    from.to_local(to)
}

/// True where a root is at a place; false where either is not a number.
fn is_near(root: Planar, x: f32, z: f32) -> bool {
    (root.x - x).abs() < ASTRAY && (root.z - z).abs() < ASTRAY
}

/// Offsets are those of a body, and legs have a length.
pub(super) fn skeleton(s: &Skeleton) -> Result<(), FormatError> {
    let error = |fault: String| FormatError::value(tags::SKELETON, 0, fault);
    for (i, o) in s.offsets.iter().chain(&s.tips).enumerate() {
        let good = o.is_finite() && o.abs().max_element() < LONGEST_BONE;
        ensure(good, || error(format!("offset {i} is {o}, not a length in metres")))?;
    }
    [Joint::LeftShin, Joint::LeftFoot, Joint::RightShin, Joint::RightFoot].iter().try_for_each(|j| {
        ensure(s.offsets[j.index()].length() >= 1e-3, || error(format!("{} lies in its parent", j.name())))
    })
}

/// Clips tile the frames; rows are finite, their rotations not zero; contacts have seven bits and a byte a frame.
pub(super) fn motion(t: &Bundle) -> Result<(), FormatError> {
    let (frames, contacts) = (t.frames(), t.contacts());
    let [num_frames, num_contacts] = [frames.len(), contacts.len()];
    let error = || FormatError::layout(format!("{num_contacts} contacts for {num_frames} frames"));
    ensure(num_contacts == num_frames, error)?;
    let [names, clips] = [t.meta().clips.len(), t.clips().len()];
    ensure(names == clips, || FormatError::layout(format!("META names {names} clips, there are {clips}")))?;
    let mut next = 0u64;
    for (i, c) in t.clips().iter().enumerate() {
        let follows = u64::from(c.first_frame) == next && c.num_frames > 0 && c.mirrored <= 1 && c.reserved == 0;
        let fault = || format!("it does not follow the clip before it: {c:?}");
        ensure(follows, || FormatError::value(tags::CLIPS, i, fault()))?;
        next += u64::from(c.num_frames);
    }
    let error = || FormatError::layout(format!("clips hold {next} frames, there are {num_frames}"));
    ensure(next == num_frames as u64, error)?;
    for (i, c) in t.clips().iter().enumerate() {
        let mut from = 0;
        let follows = |s: &ClassSpan| {
            let follows = s.frames.start == from && s.frames.start < s.frames.end;
            from = s.frames.end;
            follows && s.speed_mps.is_finite() && s.travel_deg.is_finite()
        };
        let spans = &t.meta().clips[i].classes;
        let tile = spans.iter().all(follows) && (spans.is_empty() || from == c.num_frames);
        ensure(tile, || FormatError::layout(format!("META's classes of clip {i} do not tile its frames")))?;
    }
    let code = t.rotation_code();
    refuse(tags::ROTATION_CODE, code.joints.iter().position(|c| !c.is_sound()), "its field cannot be")?;
    let is_good = |row: &FrameRow| {
        let moderate = row.planar.iter().chain([&row.height]).all(|v| v.abs() < FARTHEST);
        // Interpolation between neighbours must not meet a zero quaternion; half of unit length is far from that.
        moderate && code.joints.iter().all(|c| (0.5..1.5).contains(&c.coded(row).length()))
    };
    refuse(tags::FRAMES, frames.iter().position(|row| !is_good(row)), "it holds a number that cannot be")?;
    let leaps = |w: &[FrameRow]| [0, 1].iter().any(|&k| (w[0].planar[k] - w[1].planar[k]).abs() > LEAP);
    refuse(tags::FRAMES, find_pair(t, leaps), &format!("its root leaps by more than {LEAP} m to the next one"))?;
    // Rotations are on the same side, so that interpolation never meets zero.
    let breaks = |w: &[FrameRow]| !code.joints.iter().all(|c| c.continues(&w[0], &w[1]));
    refuse(tags::FRAMES, find_pair(t, breaks), "its rotations do not continue in the next")?;
    contacts.iter().enumerate().try_for_each(|(i, c)| {
        ensure(c.0 <= 127, || FormatError::value(tags::CONTACTS, i, format!("{} is not seven bits", c.0)))
    })
}

/// First frame that `found` is true for together with the next frame of its clip.
fn find_pair(t: &Bundle, found: impl Fn(&[FrameRow]) -> bool) -> Option<usize> {
    let mut clips = t.clips().iter().map(|c| c.first_frame as usize..(c.first_frame + c.num_frames) as usize);
    clips.find_map(|clip| Some(clip.start + t.frames()[clip].windows(2).position(&found)?))
}

/// Hits ascend by frame, name frames, joints and kinds that exist, and have moderate numbers.
pub(super) fn hits(t: &Bundle) -> Result<(), FormatError> {
    let (hits, num_kinds) = (t.hits(), t.meta().hit_kinds().count());
    for (i, h) in hits.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::HITS, i, format!("{fault}: {h:?}"));
        let follows = (h.frame as usize) < t.frames().len() && (i == 0 || hits[i - 1].frame <= h.frame);
        ensure(follows, || error("its frame does not exist or comes before the last one"))?;
        let known = (h.kind as usize) < num_kinds && (h.joint as usize) < NUM_JOINTS && h.reserved == 0;
        ensure(known, || error("no such kind or joint"))?;
        let moderate = h.position.iter().chain([&h.speed_mps]).all(|v| v.abs() < 1e6) && h.speed_mps >= 0.0;
        let unit = (h.direction().length() - 1.0).abs() < 1e-3;
        let good = moderate && unit && h.force > 0.0 && h.force <= 1.0;
        ensure(good, || error("it holds a number that cannot be"))?;
    }
    Ok(())
}

/// States and segments lie in the frames, segments inside their clips and end where their state is, actions exist.
pub(super) fn graph(t: &Bundle) -> Result<(), FormatError> {
    let g = t.graph();
    let num_frames = t.frames().len();
    for (i, s) in g.states.iter().enumerate() {
        let fault = || format!("no such frame, there are {num_frames}: {s:?}");
        let good = (s.frame as usize) < num_frames && s.standing <= 1;
        ensure(good, || FormatError::value(tags::STATES, i, fault()))?;
    }
    for (i, s) in g.segments.iter().enumerate() {
        let error = |fault: &str| FormatError::value(tags::SEGMENTS, i, format!("{fault}: {s:?}"));
        let clip = t.clips().get(s.clip as usize).ok_or_else(|| error("no such clip"))?;
        let end = g.states.get(s.end as usize).ok_or_else(|| error("no such end state"))?;
        let last = u64::from(s.start) + u64::from(s.num_frames);
        let clip_end = u64::from(clip.first_frame) + u64::from(clip.num_frames);
        let within = s.num_frames > 0 && s.start >= clip.first_frame && last < clip_end;
        let ends = last == u64::from(end.frame);
        ensure(within && ends, || error("it leaves its clip or does not end at its state"))?;
        let (stored, shown) = (s.displacement(), root_seen_from(t, s.start, last as u32));
        let turned = wrap_angle(stored.heading - shown.heading).abs();
        let is_there = is_near(shown, stored.x, stored.z) && turned < ASTRAY && stored.heading.abs() < FARTHEST;
        ensure(is_there, || error("its displacement is not that of its frames"))?;
        let idles = s.idle >= s.num_frames && u64::from(s.start) + u64::from(s.idle) < clip_end;
        ensure(s.idle == 0 || idles, || error("it idles for a time that its clip does not have"))?;
    }
    let [states, offsets] = [g.states.len(), g.action_offsets.len()];
    let error = || FormatError::layout(format!("{offsets} action offsets for {states} states"));
    ensure(offsets == states + 1, error)?;
    let has_motion = states > 0 || !t.patches().patches.is_empty() || !t.blends().spaces.is_empty();
    let fault = "there is neither a motion graph nor a motion patch nor a blend space: nothing can be played";
    ensure(has_motion, || FormatError::layout(fault))?;
    for (i, e) in g.action_errors.iter().enumerate() {
        ensure((0.0..1e9).contains(e), || FormatError::value(tags::ACTION_ERRORS, i, format!("{e} is no distance")))?;
    }
    ActionTable::new(&g.action_offsets, &g.action_segments, &g.action_errors, g.segments.len())
        .map_err(|e| FormatError::layout(e.to_string()))?;
    let mut entered = vec![false; states];
    g.segments.iter().for_each(|s| entered[s.end as usize] = true);
    refuse(tags::STATES, entered.iter().position(|e| !e), "no segment leads to it")?;
    let state = g.states.windows(2).position(|w| w[0].frame > w[1].frame).map(|i| i + 1);
    refuse(tags::STATES, state, "it does not follow the one before it")?;
    let segment = g.segments.windows(2).position(|w| w[0].start > w[1].start).map(|i| i + 1);
    refuse(tags::SEGMENTS, segment, "it does not follow the one before it")
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
