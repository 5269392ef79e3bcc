//! Steps against a plain reference, one joint after the other, on made-up tables.

use super::*;
use crate::format::{AlignedBytes, BundleWriter, ClipMeta, ClipRecord, FrameRow, Meta, SkeletonRecord};
use crate::graph::{MotionSegment, StateRecord};
use crate::hits::HitRecord;
use crate::policy::{PolicyRecord, RewardRecord, SegmentRecord, TargetGrid};
use crate::skeleton::{Joint, Skeleton};
use crate::tables::{Tables, tags};
use bytemuck::Zeroable;
use glam::Quat;

mod blows;
mod reactions;
mod replay;

const FRAMES: u32 = 60;

/// Two clips of walking-like rotations and planted feet; states at frames 20 and 40 of each; every state may go
/// on or change to the other clip.
pub(crate) fn tables() -> Tables {
    tables_with(&[])
}

/// The same with effective hits.
pub(crate) fn tables_with(hits: &[HitRecord]) -> Tables {
    let mut out = BundleWriter::new();
    let clip = |name: &str| ClipMeta { name: name.into(), ..ClipMeta::default() };
    let meta = Meta {
        rate_hz: 30.0,
        clips: vec![clip("a"), clip("b")],
        behaviours: vec!["approach".into()],
        ..Meta::default()
    };
    out.section(tags::META, &meta.encode().unwrap());
    out.section(tags::SKELETON, &[SkeletonRecord::from(&Skeleton::default())]);
    let record = |first_frame| ClipRecord { first_frame, num_frames: FRAMES, mirrored: 0, reserved: 0 };
    out.section(tags::CLIPS, &[record(0), record(FRAMES)]);
    let rows: Vec<FrameRow> = (0..2 * FRAMES).map(|f| row(f % FRAMES, f / FRAMES)).collect();
    out.section(tags::FRAMES, &rows);
    out.section(tags::CONTACTS, &vec![Contacts::LEFT; rows.len()]);
    out.section(tags::HITS, hits);
    let frames = [20, 40, FRAMES + 20, FRAMES + 40];
    out.section(tags::STATES, &frames.map(|frame| StateRecord { frame, standing: 0 }));
    // Segments: 0 -> 20 and 20 -> 40 in each clip.
    let segments = [(0, 0, 0), (20, 1, 0), (FRAMES, 2, 1), (FRAMES + 20, 3, 1)];
    let planar = |f: u32| {
        let [x, z, h] = rows[f as usize].planar;
        Planar::new(x, z, h)
    };
    let segment = |(start, end, clip): (u32, u32, u32)| {
        let d = planar(start).to_local(planar(start + 20));
        MotionSegment { start, num_frames: 20, end, clip, displacement: [d.x, d.z, d.heading], reserved: 0 }
    };
    let segments = segments.map(segment);
    out.section(tags::SEGMENTS, &segments);
    out.section(tags::ACTION_OFFSETS, &[0u32, 2, 4, 6, 8]);
    out.section(tags::ACTION_SEGMENTS, &[1u32, 3, 0, 2, 3, 1, 2, 0]);
    out.section(tags::ACTION_ERRORS, &[0.0f32; 8]);
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
    out.section(tags::POLICIES, &[policy]);
    let known = segments.map(|s| SegmentRecord {
        displacement: [s.displacement[2].cos(), s.displacement[2].sin(), s.displacement[0], s.displacement[1]],
        weights: [0.0, 0.0, 0.0, 1.0],
        discount: 0.7,
        end: s.end,
        ..SegmentRecord::zeroed()
    });
    out.section(tags::POLICY_SEGMENTS, &known);
    out.section::<crate::policy::PathRecord>(tags::POLICY_PATHS, &[]);
    out.section::<crate::policy::StateGridRecord>(tags::POLICY_STATE_GRIDS, &[]);
    out.section(tags::POLICY_VALUES, &[0.0f32; 4 * 32]);
    let best: Vec<u8> = (0..4 * 32).map(|i| (i / 3 % 2) as u8).collect();
    out.section(tags::POLICY_BEST, &best);
    out.section::<crate::patch::PatchRecord>(tags::PATCHES, &[]);
    out.section::<crate::patch::EdgeRecord>(tags::PATCH_EDGES, &[]);
    out.section::<crate::patch::CellRecord>(tags::PATCH_CELLS, &[]);
    out.section::<crate::patch::LinkRecord>(tags::PATCH_LINKS, &[]);
    out.section::<u32>(tags::POSE_GROUPS, &[]);
    out.section::<crate::blend::BlendRecord>(tags::BLENDS, &[]);
    out.section::<crate::blend::ExampleRecord>(tags::BLEND_EXAMPLES, &[]);
    out.section::<f32>(tags::BLEND_WEIGHTS, &[]);
    out.section::<crate::blend::ReferenceRow>(tags::BLEND_REFERENCES, &[]);
    out.section::<crate::blend::ChannelRow>(tags::BLEND_CHANNELS, &[]);
    let mut bytes = Vec::new();
    out.write(&mut bytes).unwrap();
    Tables::from_bytes(AlignedBytes::from_slice(&bytes)).unwrap()
}

fn row(frame: u32, clip: u32) -> FrameRow {
    let t = frame as f32 / 30.0;
    let mut row = FrameRow {
        planar: [0.1 * t, (1.0 + 0.2 * clip as f32) * t, (0.4 - 0.9 * clip as f32) * t],
        height: 0.9 + 0.02 * (8.0 * t).sin(),
        rotations: [[0; 4]; NUM_JOINTS],
    };
    for (j, code) in row.rotations.iter_mut().enumerate() {
        let a = 0.3 * (3.0 * t + j as f32 + 0.5 * clip as f32).sin();
        *code = FrameRow::encode(Quat::from_euler(glam::EulerRot::XYZ, a, 0.5 * a, -0.3 * a));
    }
    // Knees bent, so that a locked foot stays within reach.
    for (j, angle) in
        [(Joint::LeftThigh, -0.5), (Joint::LeftShin, 0.9), (Joint::RightThigh, -0.5), (Joint::RightShin, 0.9)]
    {
        row.rotations[j.index()] = FrameRow::encode(Quat::from_rotation_x(angle + 0.1 * (4.0 * t).sin()));
    }
    row
}

pub(crate) fn starts(n: usize) -> Vec<Start> {
    (0..n).map(|i| Start { root: Planar::new(i as f32, -2.0, 0.5 * i as f32), state: i as u32 % 4 }).collect()
}

pub(crate) fn targets(n: usize) -> Vec<Vec3> {
    (0..n).map(|i| Vec3::new(3.0 - i as f32, 0.0, 1.0 + 0.3 * i as f32)).collect()
}

/// World positions of all joints, straight from the rows.
fn reference(r: &Repertoire<'_>, troupe: &Troupe, c: usize) -> [Vec3; NUM_JOINTS] {
    let (segment, time) = troupe.segment(c);
    let frame = r.graph.segments[segment as usize].start as usize + time as usize;
    let root = troupe.root(c);
    model(r, frame, frame + 1, time.fract()).map(|p| root.translation() + root.rotation() * p)
}

/// Model-space positions of all joints between two rows, joint after joint.
fn model(r: &Repertoire<'_>, from: usize, to: usize, ratio: f32) -> [Vec3; NUM_JOINTS] {
    let (a, b) = (&r.frames[from], &r.frames[to]);
    let mut out = [(Vec3::ZERO, Quat::IDENTITY); NUM_JOINTS];
    for j in Joint::ALL {
        let q = a.rotation(j.index()).lerp(b.rotation(j.index()), ratio);
        out[j.index()] = match j.parent() {
            None => (Vec3::Y * (a.height + (b.height - a.height) * ratio), q),
            Some(p) => {
                let (position, rotation) = out[p.index()];
                (position + rotation * r.skeleton.offsets[j.index()], rotation * q)
            }
        };
    }
    out.map(|t| t.0)
}

fn plain() -> TroupeConfig {
    let foot_lock = FootLockConfig { enabled: false, ..FootLockConfig::default() };
    TroupeConfig { foot_lock, ..TroupeConfig::default() }
}

#[test]
fn poses_are_those_of_the_rows_once_a_transition_has_settled() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let config = TroupeConfig { half_life_s: 0.005, ..plain() };
    let mut troupe = Troupe::new(&r, config, &starts(7)).unwrap();
    let targets = targets(7);
    for _ in 0..14 {
        troupe.step(&r, 1.0 / 25.0, &[Goal { policy: 0, weight: 1.0, targets: &targets }]).unwrap();
    }
    for c in 0..7 {
        assert!(troupe.segment(c).1 > 2.0, "the transition has settled");
        for (got, want) in troupe.joint_positions(c).iter().zip(reference(&r, &troupe, c)) {
            assert!((*got - want).length() < 1e-4, "{got} {want}");
        }
    }
}

#[test]
fn sampled_frames_are_those_of_the_rows() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let (frames, ratios) = ([0, 33, 119, 60, 7], [0.0, 0.25, 0.0, 1.0, 0.5]);
    let mut matrices = vec![Mat3x4::default(); 5 * NUM_JOINTS];
    SampleJob { repertoire: &r, frames: &frames, ratios: &ratios, matrices: &mut matrices }.run().unwrap();
    for (i, (&f, &ratio)) in frames.iter().zip(&ratios).enumerate() {
        let want = model(&r, f as usize, (f as usize + 1).min(119), ratio);
        for (got, want) in matrices[i * NUM_JOINTS..].iter().zip(want) {
            assert!((got.translation() - want).length() < 1e-5);
        }
    }
    let job = SampleJob { repertoire: &r, frames: &[120], ratios: &[0.0], matrices: &mut matrices[..NUM_JOINTS] };
    assert!(matches!(job.run(), Err(TroupeError::Index { .. })));
}

#[test]
fn nothing_jumps_where_segments_change() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let mut troupe = Troupe::new(&r, plain(), &starts(9)).unwrap();
    let targets = targets(9);
    let goals = [Goal { policy: 0, weight: 1.0, targets: &targets }];
    troupe.step(&r, 0.0, &goals).unwrap();
    let dt = 1.0 / 240.0;
    let mut before: Vec<_> = (0..9).map(|c| troupe.joint_positions(c)).collect();
    let mut changes = 0;
    for _ in 0..480 {
        let old: Vec<_> = (0..9).map(|c| troupe.segment(c).0).collect();
        troupe.step(&r, dt, &goals).unwrap();
        for c in 0..9 {
            changes += usize::from(troupe.segment(c).0 != old[c]);
            let now = troupe.joint_positions(c);
            for (a, b) in now.iter().zip(&before[c]) {
                assert!((*a - *b).length() < 6.0 * dt, "faster than 6 m/s");
            }
            before[c] = now;
        }
    }
    assert!(changes > 20, "{changes}");
}

#[test]
fn roots_are_continuous_and_follow_the_segments() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let mut troupe = Troupe::new(&r, plain(), &starts(4)).unwrap();
    let targets = targets(4);
    let goals = [Goal { policy: 0, weight: 1.0, targets: &targets }];
    troupe.step(&r, 0.0, &goals).unwrap();
    let mut at: Vec<Planar> = (0..4).map(|c| troupe.root(c)).collect();
    for (c, s) in starts(4).iter().enumerate() {
        assert!((at[c].x - s.root.x).abs() < 1e-5 && (at[c].z - s.root.z).abs() < 1e-5);
    }
    for _ in 0..5 {
        let segments: Vec<_> = (0..4).map(|c| troupe.segment(c).0).collect();
        for _ in 0..20 {
            troupe.step(&r, 1.0 / 30.0, &goals).unwrap();
        }
        for c in 0..4 {
            at[c] = at[c].compose(r.graph.segments[segments[c] as usize].displacement());
            let got = troupe.root(c);
            assert!((got.x - at[c].x).abs() < 1e-3 && (got.z - at[c].z).abs() < 1e-3, "{got:?} {:?}", at[c]);
        }
    }
}

#[test]
fn planted_feet_stay_where_they_are() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let foot_lock = FootLockConfig { max_correction_m: 0.3, ..FootLockConfig::default() };
    let mut troupe = Troupe::new(&r, TroupeConfig { foot_lock, ..TroupeConfig::default() }, &starts(5)).unwrap();
    let targets = targets(5);
    let goals = [Goal { policy: 0, weight: 1.0, targets: &targets }];
    for _ in 0..2 {
        troupe.step(&r, 1.0 / 60.0, &goals).unwrap();
    }
    let feet = |t: &Troupe, c| {
        let p = t.joint_positions(c);
        (p[Joint::LeftFoot.index()] + p[Joint::LeftToe.index()]) * 0.5
    };
    let before: Vec<_> = (0..5).map(|c| feet(&troupe, c)).collect();
    for _ in 0..6 {
        troupe.step(&r, 1.0 / 60.0, &goals).unwrap();
    }
    for (c, b) in before.iter().enumerate() {
        let moved = feet(&troupe, c) - *b;
        assert!(moved.x.hypot(moved.z) < 0.01, "{moved}");
    }
}

#[test]
fn legs_keep_their_lengths_and_locals_rebuild_the_pose() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let config = TroupeConfig { local_transforms: true, ..TroupeConfig::default() };
    let mut troupe = Troupe::new(&r, config, &starts(6)).unwrap();
    let targets = targets(6);
    for _ in 0..50 {
        troupe.step(&r, 1.0 / 60.0, &[Goal { policy: 0, weight: 1.0, targets: &targets }]).unwrap();
        for c in 0..6 {
            let (pose, locals) = (troupe.pose(c), &troupe.local_transforms()[c * NUM_JOINTS..][..NUM_JOINTS]);
            let mut built = [(Vec3::ZERO, Quat::IDENTITY); NUM_JOINTS];
            for j in Joint::ALL {
                let (p, q) = j.parent().map_or((Vec3::ZERO, Quat::IDENTITY), |p| built[p.index()]);
                let l = locals[j.index()];
                built[j.index()] = (p + q * Vec3::from_array(l.translation), q * Quat::from_array(l.rotation));
                let shown = pose[j.index()].translation();
                assert!((built[j.index()].0 - shown).length() < 2e-3, "{j:?} {} {shown}", built[j.index()].0);
                if let Some(parent) = j.parent() {
                    let length = (shown - pose[parent.index()].translation()).length();
                    assert!((length - r.skeleton.offsets[j.index()].length()).abs() < 2e-3, "{j:?}");
                }
            }
        }
    }
}

#[test]
fn the_split_and_the_way_of_choosing_are_free() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let n = 300;
    let targets = targets(n);
    let goals = [Goal { policy: 0, weight: 1.0, targets: &targets }];
    for choice in [Choice::BestAction, Choice::LookAhead { temperature: 0.3 }] {
        let config = TroupeConfig { choice, ..TroupeConfig::default() };
        let mut whole = Troupe::new(&r, config, &starts(n)).unwrap();
        let mut split = whole.clone();
        for _ in 0..100 {
            whole.step(&r, 1.0 / 40.0, &goals).unwrap();
            #[cfg(feature = "rayon")]
            split.par_step(&r, 1.0 / 40.0, &goals).unwrap();
            #[cfg(not(feature = "rayon"))]
            split.step(&r, 1.0 / 40.0, &goals).unwrap();
        }
        assert_eq!(whole.model_matrices(), split.model_matrices());
        assert!(whole.num_choices(0) > 2);
    }
}

#[test]
fn refuses_what_does_not_fit() {
    let tables = tables();
    let r = Repertoire::new(&tables);
    let bad_state = [Start { root: Planar::IDENTITY, state: 4 }];
    assert!(matches!(Troupe::new(&r, plain(), &bad_state), Err(TroupeError::Index { .. })));
    let mut troupe = Troupe::new(&r, plain(), &starts(2)).unwrap();
    let targets = targets(2);
    let goal = |policy, targets| [Goal { policy, weight: 1.0, targets }];
    assert!(matches!(troupe.step(&r, 0.1, &goal(0, &targets[..1])), Err(TroupeError::Length { .. })));
    assert!(matches!(troupe.step(&r, 0.1, &goal(1, &targets)), Err(TroupeError::Index { .. })));
    assert!(matches!(troupe.step(&r, f32::NAN, &goal(0, &targets)), Err(TroupeError::Value { .. })));
    let far = [Vec3::NAN; 2];
    assert!(matches!(troupe.step(&r, 0.1, &goal(0, &far)), Err(TroupeError::Value { .. })));
    assert!(matches!(troupe.step(&r, 0.1, &[]), Err(TroupeError::Length { .. })));
    // The same clips, another graph.
    let mut other = r.clone();
    other.graph.segments = &other.graph.segments[..3];
    assert!(matches!(troupe.step(&other, 0.1, &goal(0, &targets)), Err(TroupeError::OtherBundle { .. })));
}
