//! A small bundle for tests: two clips, four states, one policy.

use crate::bundle::{Bundle, tags};
use crate::contacts::Contacts;
use crate::format::{AlignedBytes, BundleWriter, ClipMeta, ClipRecord, FrameRow, Meta, RotationCode, SkeletonRecord};
use crate::graph::{MotionSegment, StateRecord};
use crate::hits::HitRecord;
use crate::planar::Planar;
use crate::policy::{PolicyRecord, RewardRecord, SegmentRecord, StateGridRecord, TargetGrid};
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use crate::stops::{REST, SLOW_DOWN, StopRecord, SweepNode, SweepRecord};
use bytemuck::Zeroable;
use glam::Quat;
use throng_base::maths;

/// Turn of thighs of people who stand; knees are turned by twice that (rad).
const STANDING_KNEE: f32 = 0.3;

/// Frames of each clip.
pub const FRAMES: u32 = 60;

/// Two clips of walking-like rotations and planted feet; states at frames 20 and 40 of each; every state may go
/// on or change to the other clip.
pub fn tables() -> Bundle {
    tables_with(&[])
}

/// Made-up bundle with effective hits.
pub fn tables_with(hits: &[HitRecord]) -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(&bytes(hits, false))).unwrap()
}

/// Made-up bundle whose actions are bent towards the target.
#[cfg(test)]
pub(crate) fn bent_tables(hits: &[HitRecord]) -> Bundle {
    let mut bytes = bytes(hits, false);
    for record in tables().policies()[0].segments() {
        let [_, _, x, z] = record.displacement;
        let bent = SegmentRecord { heights: [0.2, maths::hypot(x, z).recip()], ..*record };
        let from = bytemuck::bytes_of(record);
        let at = bytes.windows(from.len()).position(|w| w == from).unwrap();
        bytes[at..at + from.len()].copy_from_slice(bytemuck::bytes_of(&bent));
    }
    Bundle::from_bytes_unverified(AlignedBytes::from_slice(&bytes)).unwrap()
}

/// Made-up bundle of people who stand with soft knees, feet flat on the ground, and move their upper bodies.
#[cfg(test)]
pub(crate) fn standing_tables() -> Bundle {
    Bundle::from_bytes(AlignedBytes::from_slice(&bytes_of(&[], false, true))).unwrap()
}

/// The file of the bundle.
///
/// - `adaptive`: a second policy, with a grid for each state.
pub fn bytes(hits: &[HitRecord], adaptive: bool) -> Vec<u8> {
    bytes_of(hits, adaptive, false)
}

/// - `stands`: the motion stays in its place, on both feet.
fn bytes_of(hits: &[HitRecord], adaptive: bool, stands: bool) -> Vec<u8> {
    let mut out = BundleWriter::new();
    let clip = |name: &str| ClipMeta { name: name.into(), ..ClipMeta::default() };
    let meta = Meta {
        rate_hz: 30.0,
        clips: vec![clip("a"), clip("b")],
        behaviours: ["approach", "adaptive"].iter().take(1 + usize::from(adaptive)).map(|&b| b.into()).collect(),
        ..Meta::default()
    };
    out.section(tags::META, &meta.encode().unwrap());
    out.section(tags::SKELETON, &[SkeletonRecord::from(&Skeleton::default())]);
    let record = |first_frame| ClipRecord { first_frame, num_frames: FRAMES, mirrored: 0, reserved: 0 };
    out.section(tags::CLIPS, &[record(0), record(FRAMES)]);
    let poses: Vec<_> = (0..2 * FRAMES).map(|f| pose(f % FRAMES, f / FRAMES, stands)).collect();
    let code = RotationCode::fit_frames(&Skeleton::default(), poses.len(), |f, j| poses[f][j]);
    let rows: Vec<FrameRow> = (0..2 * FRAMES).map(|f| row(f % FRAMES, f / FRAMES, &code, stands)).collect();
    out.section(tags::FRAMES, &rows);
    out.section(tags::ROTATION_CODE, &[code]);
    let mut contacts = Contacts::LEFT;
    if stands {
        contacts.insert(Contacts::RIGHT);
    }
    out.section(tags::CONTACTS, &vec![contacts; rows.len()]);
    out.section(tags::HITS, hits);
    let frames = [20, 40, FRAMES + 20, FRAMES + 40];
    out.section(tags::STATES, &frames.map(|frame| StateRecord { frame, standing: u32::from(stands) }));
    // Segments: 0 -> 20 and 20 -> 40 in each clip.
    let segments = [(0, 0, 0), (20, 1, 0), (FRAMES, 2, 1), (FRAMES + 20, 3, 1)];
    let planar = |f: u32| {
        let [x, z, h] = rows[f as usize].planar;
        Planar::new(x, z, h)
    };
    let segment = |(start, end, clip): (u32, u32, u32)| {
        let d = planar(start).to_local(planar(start + 20));
        let idle = if stands { FRAMES - 1 - start % FRAMES } else { 0 };
        MotionSegment { start, num_frames: 20, end, clip, displacement: [d.x, d.z, d.heading], idle }
    };
    let segments = segments.map(segment);
    out.section(tags::SEGMENTS, &segments);
    out.section(tags::ACTION_OFFSETS, &[0u32, 2, 4, 6, 8]);
    out.section(tags::ACTION_SEGMENTS, &[1u32, 3, 0, 2, 3, 1, 2, 0]);
    out.section(tags::ACTION_ERRORS, &[0.0f32; 8]);
    // A node at every frame; to stop, one plays the first action ever more slowly.
    let node = |s: &MotionSegment, frame: u32| {
        let at = planar(s.start).to_local(planar(s.start + frame));
        SweepNode { frame, x: at.x, z: at.z }
    };
    let sweeps = |i: u32| SweepRecord { first_node: 21 * i, num_nodes: 21, radius: 0.3 };
    out.section(tags::SWEEPS, &[0, 1, 2, 3].map(sweeps));
    let nodes: Vec<SweepNode> = segments.iter().flat_map(|s| (0..=20).map(|f| node(s, f))).collect();
    out.section(tags::SWEEP_NODES, &nodes);
    let [kind, frames] = if stands { [REST, 0] } else { [SLOW_DOWN, 40] };
    let stop = |segment| StopRecord { segment, kind, frames, radius: 0.3, pose_radius: 0.3 };
    out.section(tags::STOPS, &[1, 0, 3, 2].map(stop));
    let grid = TargetGrid::polar(4, 8, 6.0, 1.0, 1.0).unwrap();
    let policy = PolicyRecord {
        grid: *grid.record(),
        reward: RewardRecord::new(0, 0, 1.0),
        num_states: 4,
        num_segments: 4,
        num_choices: 1,
        discount: 0.98,
        epsilon: 1e-3,
        ..PolicyRecord::default()
    };
    let policies = [policy, PolicyRecord { adaptive: 1, ..policy }];
    out.section(tags::POLICIES, &policies[..1 + usize::from(adaptive)]);
    let known = segments.map(|s| SegmentRecord {
        displacement: [
            maths::cos(s.displacement[2]),
            maths::sin(s.displacement[2]),
            s.displacement[0],
            s.displacement[1],
        ],
        weights: [0.0, 0.0, 0.0, 1.0],
        discount: 0.7,
        end: s.end,
        ..SegmentRecord::zeroed()
    });
    out.section(tags::POLICY_SEGMENTS, &if adaptive { [known, known].concat() } else { known.to_vec() });
    out.section::<crate::policy::PathRecord>(tags::POLICY_PATHS, &[]);
    // A grid of 32 cells for each of four states; four grids of their own for the same states.
    let state_grids = [([4, 8, 1], 0), ([2, 8, 1], 32), ([4, 2, 1], 48), ([3, 5, 1], 56)];
    let state_grids = state_grids.map(|(n, at)| StateGridRecord::new(n, at));
    out.section(tags::POLICY_STATE_GRIDS, &state_grids[..if adaptive { 4 } else { 0 }]);
    let cells = 4 * 32 + if adaptive { 71 } else { 0 };
    out.section(tags::POLICY_VALUES, &vec![0.0f32; cells]);
    let best: Vec<u8> = (0..cells).map(|i| (i / 3 % 2) as u8).collect();
    out.section(tags::POLICY_BEST, &best);
    out.section::<crate::patch::PatchRecord>(tags::PATCHES, &[]);
    out.section::<crate::patch::EdgeRecord>(tags::PATCH_EDGES, &[]);
    out.section::<crate::patch::CellRecord>(tags::PATCH_CELLS, &[]);
    out.section::<crate::patch::LinkRecord>(tags::PATCH_LINKS, &[]);
    out.section::<crate::patch::PairRecord>(tags::PATCH_PAIRS, &[]);
    out.section::<u32>(tags::POSE_GROUPS, &[]);
    out.section::<crate::blend::BlendRecord>(tags::BLENDS, &[]);
    out.section::<crate::blend::ExampleRecord>(tags::BLEND_EXAMPLES, &[]);
    out.section::<f32>(tags::BLEND_WEIGHTS, &[]);
    out.section::<crate::blend::ReferenceRow>(tags::BLEND_REFERENCES, &[]);
    out.section::<crate::blend::ChannelRow>(tags::BLEND_CHANNELS, &[]);
    let mut bytes = Vec::new();
    out.write(&mut bytes).unwrap();
    bytes
}

fn row(frame: u32, clip: u32, code: &RotationCode, stands: bool) -> FrameRow {
    let t = frame as f32 / 30.0;
    let mut row = FrameRow {
        planar: [0.1 * t, (1.0 + 0.2 * clip as f32) * t, (0.4 - 0.9 * clip as f32) * t],
        height: 0.9 + 0.02 * maths::sin(8.0 * t),
        ..FrameRow::zeroed()
    };
    if stands {
        let skeleton = Skeleton::default();
        let leg = [Joint::LeftShin, Joint::LeftFoot].map(|j| skeleton.offsets[j.index()].length());
        let bent = (leg[0] + leg[1]) * (1.0 - maths::cos(STANDING_KNEE));
        (row.planar, row.height) = ([0.0; 3], skeleton.rest_positions()[0].y - bent);
    }
    code.encode(&pose(frame, clip, stands), None, &mut row);
    row
}

fn pose(frame: u32, clip: u32, stands: bool) -> [Quat; NUM_JOINTS] {
    let t = frame as f32 / 30.0;
    let mut pose = std::array::from_fn(|j| {
        let a = 0.3 * maths::sin(3.0 * t + j as f32 + 0.5 * clip as f32);
        maths::compose(maths::compose(maths::rotation_x(a), maths::rotation_y(0.5 * a)), maths::rotation_z(-0.3 * a))
    });
    // Knees bent, so that a locked foot stays within reach.
    for (j, angle) in
        [(Joint::LeftThigh, -0.5), (Joint::LeftShin, 0.9), (Joint::RightThigh, -0.5), (Joint::RightShin, 0.9)]
    {
        pose[j.index()] = maths::rotation_x(angle + 0.1 * maths::sin(4.0 * t));
    }
    if stands {
        pose[Joint::Hips.index()] = Quat::IDENTITY;
        for leg in crate::body::LEGS {
            for (j, turn) in leg.into_iter().zip([-1.0, 2.0, -1.0, 0.0]) {
                pose[j.index()] = maths::rotation_x(turn * STANDING_KNEE);
            }
        }
    }
    pose
}

#[cfg(test)]
/// A number of the rows between one and the next, by Hermite's cubic: tangents are half the way between the neighbours,
/// and at an end of a clip the way to the only one.
pub(crate) fn curve(r: &super::MotionSet, from: usize, ratio: f32, number: impl Fn(&FrameRow) -> f32) -> f32 {
    let clip =
        r.clips.iter().find(|c| (c.first_frame as usize..(c.first_frame + c.num_frames) as usize).contains(&from));
    let clip = clip.expect("the clip of a frame");
    let (first, end) = (clip.first_frame as usize, (clip.first_frame + clip.num_frames) as usize);
    let at = |frame: usize| number(&r.frames[frame]);
    let (a, b) = (at(from), at((from + 1).min(end - 1)));
    let leaves = if from > first { 0.5 * (b - at(from - 1)) } else { b - a };
    let arrives = if from + 2 < end { 0.5 * (at(from + 2) - a) } else { b - a };
    let t = ratio;
    let (t2, t3) = (t * t, t * t * t);
    (2.0 * t3 - 3.0 * t2 + 1.0) * a + (t3 - 2.0 * t2 + t) * leaves + (3.0 * t2 - 2.0 * t3) * b + (t3 - t2) * arrives
}
