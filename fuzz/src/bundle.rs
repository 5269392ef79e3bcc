//! A small bundle that opens: two clips, four states, a policy with one grid and an adaptive one.

use bytemuck::Zeroable;
use glam::Quat;
use throng_runtime::format::{BundleWriter, ClipMeta, ClipRecord, FrameRow, Meta, SkeletonRecord};
use throng_runtime::graph::{MotionSegment, StateRecord};
use throng_runtime::policy::{PathRecord, PolicyRecord, RewardRecord, SegmentRecord, StateGridRecord, TargetGrid};
use throng_runtime::{Contacts, HitRecord, NUM_JOINTS, Planar, Skeleton, bundle::tags};

/// Frames of each clip.
const FRAMES: u32 = 12;

/// The bundle's bytes.
pub fn small() -> Vec<u8> {
    let mut out = BundleWriter::new();
    let rows: Vec<FrameRow> = (0..2 * FRAMES).map(|f| row(f % FRAMES, f / FRAMES)).collect();
    head(&mut out);
    out.section(tags::FRAMES, &rows);
    out.section(tags::CONTACTS, &vec![Contacts::LEFT; rows.len()]);
    out.section::<HitRecord>(tags::HITS, &[]);
    let segments = graph(&mut out, &rows);
    policies(&mut out, &segments);
    let mut bytes = Vec::new();
    out.write(&mut bytes).expect("memory takes all bytes");
    bytes
}

fn head(out: &mut BundleWriter) {
    let clip = |name: &str| ClipMeta { name: name.into(), ..ClipMeta::default() };
    let clips = vec![clip("a"), clip("b")];
    let meta = Meta { rate_hz: 30.0, clips, behaviours: vec!["approach".into(), "adaptive".into()], ..Meta::default() };
    out.section(tags::META, &meta.encode().expect("META can be encoded"));
    out.section(tags::SKELETON, &[SkeletonRecord::from(&Skeleton::default())]);
    let record = |first_frame| ClipRecord { first_frame, num_frames: FRAMES, mirrored: 0, reserved: 0 };
    out.section(tags::CLIPS, &[record(0), record(FRAMES)]);
}

/// States at frames 4 and 8 of each clip, segments that lead there, and two actions each.
fn graph(out: &mut BundleWriter, rows: &[FrameRow]) -> [MotionSegment; 4] {
    let frames = [4, 8, FRAMES + 4, FRAMES + 8];
    out.section(tags::STATES, &frames.map(|frame| StateRecord { frame, standing: 0 }));
    let planar = |f: u32| {
        let [x, z, heading] = rows[f as usize].planar;
        Planar::new(x, z, heading)
    };
    let segments = [(0, 0, 0), (4, 1, 0), (FRAMES, 2, 1), (FRAMES + 4, 3, 1)].map(|(start, end, clip)| {
        let d = planar(start).to_local(planar(start + 4));
        MotionSegment { start, num_frames: 4, end, clip, displacement: [d.x, d.z, d.heading], reserved: 0 }
    });
    out.section(tags::SEGMENTS, &segments);
    out.section(tags::ACTION_OFFSETS, &[0u32, 2, 4, 6, 8]);
    out.section(tags::ACTION_SEGMENTS, &[1u32, 3, 0, 2, 3, 1, 2, 0]);
    out.section(tags::ACTION_ERRORS, &[0.0f32; 8]);
    segments
}

/// The same behaviour twice: with one grid for all states, and with one for each.
fn policies(out: &mut BundleWriter, segments: &[MotionSegment; 4]) {
    let grid = TargetGrid::polar(4, 8, 6.0, 1.0, 1.0).expect("a grid");
    let uniform = PolicyRecord {
        grid: *grid.record(),
        reward: RewardRecord::new(0, 0, 1.0),
        num_states: 4,
        num_segments: 4,
        num_choices: 1,
        discount: 0.98,
        epsilon: 1e-3,
        ..PolicyRecord::default()
    };
    out.section(tags::POLICIES, &[uniform, PolicyRecord { adaptive: 1, ..uniform }]);
    let known = segments.map(|s| SegmentRecord {
        displacement: [s.displacement[2].cos(), s.displacement[2].sin(), s.displacement[0], s.displacement[1]],
        weights: [0.0, 0.0, 0.0, 1.0],
        discount: 0.7,
        end: s.end,
        ..SegmentRecord::zeroed()
    });
    out.section(tags::POLICY_SEGMENTS, &[known, known].concat());
    out.section::<PathRecord>(tags::POLICY_PATHS, &[]);
    let state_grids =
        [([4, 8, 1], 0), ([2, 8, 1], 32), ([4, 2, 1], 48), ([3, 5, 1], 56)].map(|(n, at)| StateGridRecord::new(n, at));
    out.section(tags::POLICY_STATE_GRIDS, &state_grids);
    let cells = grid.num_cells() * 4 + 71;
    out.section(tags::POLICY_VALUES, &vec![0.0f32; cells]);
    let best: Vec<u8> = (0..cells).map(|i| (i / 3 % 2) as u8).collect();
    out.section(tags::POLICY_BEST, &best);
    out.section::<throng_runtime::patch::PatchRecord>(tags::PATCHES, &[]);
    out.section::<throng_runtime::patch::EdgeRecord>(tags::PATCH_EDGES, &[]);
    out.section::<throng_runtime::patch::CellRecord>(tags::PATCH_CELLS, &[]);
    out.section::<throng_runtime::patch::LinkRecord>(tags::PATCH_LINKS, &[]);
    out.section::<u32>(tags::POSE_GROUPS, &[]);
    out.section::<throng_runtime::blend::BlendRecord>(tags::BLENDS, &[]);
    out.section::<throng_runtime::blend::ExampleRecord>(tags::BLEND_EXAMPLES, &[]);
    out.section::<f32>(tags::BLEND_WEIGHTS, &[]);
    out.section::<throng_runtime::blend::ReferenceRow>(tags::BLEND_REFERENCES, &[]);
    out.section::<throng_runtime::blend::ChannelRow>(tags::BLEND_CHANNELS, &[]);
}

fn row(frame: u32, clip: u32) -> FrameRow {
    let t = frame as f32 / 30.0;
    let rotations = std::array::from_fn::<_, NUM_JOINTS, _>(|j| {
        let a = 0.2 * (3.0 * t + j as f32 + 0.5 * clip as f32).sin();
        FrameRow::encode(Quat::from_euler(glam::EulerRot::XYZ, a, 0.5 * a, -0.3 * a))
    });
    FrameRow { planar: [0.1 * t, t, 0.4 * t], height: 0.9, rotations }
}
