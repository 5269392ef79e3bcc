//! Last stage: writes everything that was baked as one bundle.

use crate::graph::{GraphSegment, RawMotionGraph};
use crate::patch::{RawPatch, RawPatches};
use crate::share::{clip_owners, gather_to_first};
use crate::{cluster::PoseGroups, examples::RawBlendSpace, policy::RawPolicy, stops::StopRows};
use bytemuck::Zeroable;
use glam::{Quat, Vec3};
use rayon::prelude::*;
use std::path::Path;
use throng_base::{Comm, SingleRank, unexpected_message};
use throng_core::blend::BlendRecord;
use throng_core::format::{
    ActivityMeta, AlignedBytes, BlendMeta, BundleWriter, ClipMeta, ClipRecord, FormatError, FrameRow, Meta, PatchMeta,
    RotationCode, SkeletonRecord,
};
use throng_core::graph::{MotionSegment, StateRecord};
use throng_core::patch::{PairRecord, PatchRecord};
use throng_core::{Bundle, Contacts, HitRecord, Planar, bundle::tags, hits::KIND_NAMES, planar::wrap_angle};
use throng_motion::{BuildError, Clip, ClipHit, ClipSet, Result, files::write_atomically, joint_transforms};

/// Contents of a bundle.
#[derive(Clone, Copy, Debug)]
pub struct BundleInputs<'a> {
    /// Motion, annotated.
    pub clips: &'a ClipSet,
    /// Motion graph.
    pub graph: &'a RawMotionGraph,
    /// Stop tables.
    pub stops: &'a StopRows,
    /// Policies, one per behaviour.
    pub policies: &'a [RawPolicy],
    /// Pose groups of the frames, if they were computed.
    pub groups: Option<&'a PoseGroups>,
    /// Motion patches; their cells name pose groups.
    pub patches: Option<&'a RawPatches>,
    /// Blend spaces.
    pub blends: &'a [RawBlendSpace],
    /// Activities of bodies.
    pub activities: &'a [ActivityMeta],
    /// Name, provenance and figures; clips and behaviours are added here.
    pub meta: &'a Meta,
}

/// Summary of a written bundle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WrittenBundle {
    /// Length of the bundle (bytes).
    pub bytes: u64,
    /// Error of joint positions by packed rotations, for the worst joint of each frame: 95th percentile of all frames,
    /// and the largest (mm).
    pub joint_error_mm: [f32; 2],
}

/// Writes everything as one bundle, which replaces an older one only when complete, and opens it again to check it.
///
/// - `comm`: processes that hold the other poses. The first one writes; others get an empty summary.
///
/// # Errors
/// [`BuildError::Io`] if it cannot be written, [`BuildError::Format`] if it would be refused.
pub fn bundle(baked: &BundleInputs<'_>, out: &Path, comm: &dyn Comm) -> Result<WrittenBundle> {
    let format = |e: FormatError| BuildError::Format(e.to_string());
    let (rows, code, off) = frame_rows(baked.clips, comm)?;
    if comm.rank() > 0 {
        return Ok(WrittenBundle::default());
    }
    let layout = sections(baked, rows, &code).map_err(format)?;
    let io = |source| BuildError::Io { path: out.to_path_buf(), source };
    let mut bytes = AlignedBytes::zeros(layout.byte_len()).map_err(io)?;
    layout.write(&mut bytes.as_mut_slice()).map_err(io)?;
    drop(layout);
    let written = Bundle::from_bytes(bytes).map_err(format)?;
    write_atomically(out, |w| w.write_all(written.bytes()))?;
    let joint_error_mm =
        [off.len() * 95 / 100, off.len().saturating_sub(1)].map(|i| off.get(i).copied().unwrap_or(0.0));
    Ok(WrittenBundle { bytes: written.bytes().len() as u64, joint_error_mm })
}

/// Lays everything out as sections.
///
/// # Errors
/// [`FormatError`] if META cannot be encoded, or blend spaces have more rows than 32 bits can count.
pub fn lay_out<'a>(baked: &BundleInputs<'a>) -> Result<BundleWriter<'a>, FormatError> {
    let message = |e: BuildError| FormatError::Layout { message: e.to_string() };
    let (rows, code, _) = frame_rows(baked.clips, &SingleRank).map_err(message)?;
    sections(baked, rows, &code)
}

/// Lays out sections with packed frames; see [`lay_out`].
fn sections<'a>(baked: &BundleInputs<'a>, rows: Vec<u8>, code: &RotationCode) -> Result<BundleWriter<'a>, FormatError> {
    let mut meta = baked.meta.clone();
    meta.clips = baked.clips.clips.iter().map(clip_meta).collect();
    let kinds = baked.clips.hit_kinds();
    meta.hit_tags = kinds[KIND_NAMES.len()..].iter().map(|k| k.name().to_owned()).collect();
    meta.behaviours = baked.policies.iter().map(|p| p.name.clone()).collect();
    meta.pose_groups = baked.groups.map_or(0, |g| g.num_groups() as u64);
    if let Some(p) = baked.patches {
        meta.patches = p.patches.iter().map(|p| PatchMeta { name: p.name.clone(), units: p.units.clone() }).collect();
        meta.link_tags.clone_from(&p.link_tags);
        meta.units.clone_from(&p.units);
    }
    meta.blends = baked.blends.iter().map(blend_meta).collect();
    meta.activities = baked.activities.to_vec();
    let mut out = BundleWriter::new();
    out.section(tags::META, &meta.encode()?);
    out.section(tags::SKELETON, &[SkeletonRecord::from(&baked.clips.skeleton)]);
    motion(baked.clips, rows, code, &mut out);
    graph(baked, &mut out);
    policies(baked.policies, &mut out);
    patches(baked.patches.map_or(&[], |p| &p.patches), &mut out);
    out.section(tags::POSE_GROUPS, baked.groups.map_or(&[], |g| g.groups.as_slice()));
    blends(baked.blends, &mut out)?;
    Ok(out)
}

fn blend_meta(b: &RawBlendSpace) -> BlendMeta {
    BlendMeta { name: b.name.clone(), axes: b.axes.clone(), examples: b.example_names.clone() }
}

fn blends(spaces: &[RawBlendSpace], out: &mut BundleWriter<'_>) -> Result<(), FormatError> {
    let (mut records, mut next) = (Vec::with_capacity(spaces.len()), [0u32; 4]);
    for s in spaces {
        let [first_example, first_weight, first_row, first_channel_row] = next;
        records.push(BlendRecord { first_example, first_weight, first_row, first_channel_row, ..s.record });
        let sizes = [s.examples.len(), s.weights.len(), s.references.len(), s.channels.len()];
        for (next, size) in next.iter_mut().zip(sizes) {
            let sum = u32::try_from(size).ok().and_then(|size| next.checked_add(size));
            *next = sum.ok_or_else(|| too_many(&s.name))?;
        }
    }
    out.section(tags::BLENDS, &records);
    out.section(tags::BLEND_EXAMPLES, &spaces.iter().flat_map(|s| s.examples.iter().copied()).collect::<Vec<_>>());
    out.section(tags::BLEND_WEIGHTS, &spaces.iter().flat_map(|s| s.weights.iter().copied()).collect::<Vec<_>>());
    out.section(tags::BLEND_REFERENCES, &spaces.iter().flat_map(|s| s.references.iter().copied()).collect::<Vec<_>>());
    out.section(tags::BLEND_CHANNELS, &spaces.iter().flat_map(|s| s.channels.iter().copied()).collect::<Vec<_>>());
    Ok(())
}

fn too_many(space: &str) -> FormatError {
    let message = format!(
        "up to blend space `{space}`, there are more weights or rows than the {} that a bundle counts; build fewer spaces \
         into it, or give them a larger `weight_tolerance`",
        u32::MAX
    );
    FormatError::Layout { message }
}

fn patches(patches: &[RawPatch], out: &mut BundleWriter<'_>) {
    let mut records: Vec<PatchRecord> = Vec::with_capacity(patches.len());
    for p in patches {
        let (first_cell, first_link, first_edge) = records.last().map_or((0, 0, 0), |b| {
            (b.first_cell + b.num_cells, b.first_link + b.num_links, b.first_edge + b.num_edges)
        });
        records.push(PatchRecord {
            kind: p.kind,
            first_cell,
            num_cells: p.cells.len() as u32,
            first_link,
            num_links: p.links.len() as u32,
            first_edge,
            num_edges: p.edges.len() as u32,
            reserved: 0,
            min: p.bounds[0],
            max: p.bounds[1],
        });
    }
    out.section(tags::PATCHES, &records);
    out.section(tags::PATCH_EDGES, &patches.iter().flat_map(|p| p.edges.iter().copied()).collect::<Vec<_>>());
    out.section(tags::PATCH_CELLS, &patches.iter().flat_map(|p| p.cells.iter().copied()).collect::<Vec<_>>());
    out.section(tags::PATCH_LINKS, &patches.iter().flat_map(|p| p.links.iter().copied()).collect::<Vec<_>>());
    let pairs =
        (0u32..).zip(patches).flat_map(|(patch, p)| p.pairs.iter().map(move |&pair| PairRecord { patch, ..pair }));
    out.section(tags::PATCH_PAIRS, &pairs.collect::<Vec<_>>());
}

fn clip_meta(c: &Clip) -> ClipMeta {
    ClipMeta {
        name: c.name.clone(),
        source: c.source.clone(),
        tags: c.tags.iter().map(|t| (t.name.clone(), t.range.start as u32, t.range.end as u32)).collect(),
        excluded: c.excluded.iter().map(|e| (e.reason.to_string(), e.range.start as u32, e.range.end as u32)).collect(),
        classes: c.classes.clone(),
    }
}

fn motion(set: &ClipSet, rows: Vec<u8>, code: &RotationCode, out: &mut BundleWriter<'_>) {
    let starts = set.frame_starts();
    let record = |(c, &first_frame): (&Clip, &u32)| {
        let (num_frames, mirrored) = (c.num_frames() as u32, u32::from(c.mirrored));
        ClipRecord { first_frame, num_frames, mirrored, reserved: 0 }
    };
    let records: Vec<_> = set.clips.iter().zip(&starts).map(record).collect();
    let contacts: Vec<Contacts> = set.clips.iter().flat_map(|c| c.contacts.iter().copied()).collect();
    out.section(tags::CLIPS, &records);
    out.section_bytes::<FrameRow>(tags::FRAMES, rows);
    out.section(tags::ROTATION_CODE, &[*code]);
    out.section(tags::CONTACTS, &contacts);
    out.section(tags::HITS, &hit_records(set));
}

/// All hits as stored, ascending by frame.
pub fn hit_records(set: &ClipSet) -> Vec<HitRecord> {
    let kinds = set.hit_kinds();
    let record = |(h, first): (&ClipHit, u32)| HitRecord {
        frame: first + h.frame as u32,
        kind: kinds.iter().position(|k| *k == h.kind).unwrap_or(0) as u32,
        joint: h.joint.index() as u32,
        force: h.force,
        position: h.position.to_array(),
        speed_mps: h.speed_mps,
        direction: h.direction.to_array(),
        reserved: 0,
    };
    let clips = set.clips.iter().zip(set.frame_starts());
    clips.flat_map(|(c, first)| c.hits.iter().map(move |h| (h, first))).map(record).collect()
}

/// All frames as stored ([`FrameRow`], num_frames), the code of their rotations, and the error of the worst joint of
/// each frame (mm, ascending). Each rank packs the clips whose poses it holds; the first one ends up with all of them,
/// others with nothing.
fn frame_rows(set: &ClipSet, comm: &dyn Comm) -> Result<(Vec<u8>, RotationCode, Vec<f32>)> {
    let owners = clip_owners(set, comm.num_ranks());
    let own: Vec<&Clip> = set.clips.iter().zip(&owners).filter(|(_, o)| **o == comm.rank()).map(|(c, _)| c).collect();
    let of_joint = |joint: usize| {
        let rotation = |clip: &Clip, frame: usize| {
            let local = clip.frame_rotations(frame)[joint].normalize();
            if joint == 0 { Planar::split(clip.root_positions[frame], local).1.normalize() } else { local }
        };
        let of_clip = |clip: &&Clip| (0..clip.num_frames()).map(|f| rotation(clip, f)).collect::<Vec<Quat>>();
        gather_to_first(comm, own.par_iter().flat_map_iter(of_clip).collect())
    };
    let code = RotationCode::fit_joints(&set.skeleton, of_joint)?;
    // The code of ranks without frames is ignored.
    let code = comm.all_gather(bytemuck::bytes_of(&code))?.swap_remove(0);
    let code: RotationCode = bytemuck::try_pod_read_unaligned(&code).map_err(|_| unexpected_message(0))?;
    let of_clip = |clip: &&Clip| {
        let rows = clip_rows(clip, &code);
        let off: Vec<f32> = rows.iter().enumerate().map(|(f, row)| off_mm(set, clip, f, row, &code)).collect();
        (rows, off)
    };
    let (rows, off): (Vec<Vec<FrameRow>>, Vec<Vec<f32>>) = own.par_iter().map(of_clip).unzip();
    let mut bytes = Vec::with_capacity(rows.iter().map(|r| size_of_val(&r[..])).sum());
    rows.into_iter().for_each(|rows| bytes.extend_from_slice(bytemuck::cast_slice(&rows)));
    let mut off = gather_to_first(comm, off.concat())?;
    off.par_sort_unstable_by(f32::total_cmp);
    Ok((gather_to_first(comm, bytes)?, code, off))
}

/// Error of the worst joint of a frame by packed rotations (mm).
fn off_mm(set: &ClipSet, clip: &Clip, frame: usize, row: &FrameRow, code: &RotationCode) -> f32 {
    let local = clip.frame_rotations(frame);
    let (_, root) = Planar::split(clip.root_positions[frame], local[0]);
    let wanted = joint_transforms(&set.skeleton, Vec3::ZERO, |j| if j == 0 { root } else { local[j] });
    let shown = joint_transforms(&set.skeleton, Vec3::ZERO, |j| code.rotation(row, j));
    wanted.iter().zip(&shown).map(|(a, b)| a.0.distance(b.0)).fold(0.0, f32::max) * 1e3
}

/// Rows of a clip's frames: headings unwrapped, unpacked quaternions on the side of the previous frame.
fn clip_rows(clip: &Clip, code: &RotationCode) -> Vec<FrameRow> {
    let mut rows: Vec<FrameRow> = Vec::with_capacity(clip.num_frames());
    for frame in 0..clip.num_frames() {
        let local = clip.frame_rotations(frame);
        let (planar, tilt) = Planar::split(clip.root_positions[frame], local[0]);
        let before = rows.last();
        let heading = before.map_or(planar.heading, |b| b.planar[2] + wrap_angle(planar.heading - b.planar[2]));
        let height = clip.root_positions[frame].y;
        let mut row = FrameRow { planar: [planar.x, planar.z, heading], height, ..FrameRow::zeroed() };
        let local = std::array::from_fn(|j| if j == 0 { tilt } else { local[j] }.normalize());
        code.encode(&local, before, &mut row);
        rows.push(row);
    }
    rows
}

fn graph(baked: &BundleInputs<'_>, out: &mut BundleWriter<'_>) {
    let (g, starts) = (baked.graph, baked.clips.frame_starts());
    let states = g.states.iter().zip(&g.standing);
    let states: Vec<_> =
        states.map(|(s, &standing)| StateRecord { frame: s.0, standing: u32::from(standing) }).collect();
    let segment = |(i, s): (usize, &GraphSegment)| MotionSegment {
        start: s.start.0,
        num_frames: s.num_frames,
        end: s.end.0,
        clip: (starts.partition_point(|&f| f <= s.start.0) - 1) as u32,
        displacement: [s.displacement.x, s.displacement.z, s.displacement.heading],
        idle: baked.stops.idle.get(i).copied().unwrap_or(0),
    };
    let segments: Vec<_> = g.segments.iter().enumerate().map(segment).collect();
    out.section(tags::STATES, &states);
    out.section(tags::SEGMENTS, &segments);
    // A graph without states still stores the end of its empty actions.
    out.section(tags::ACTION_OFFSETS, if g.action_offsets.is_empty() { &[0] } else { g.action_offsets.as_slice() });
    out.section(tags::ACTION_SEGMENTS, &g.actions.iter().map(|a| a.segment.0).collect::<Vec<_>>());
    let own = baked.policies.iter().flat_map(|p| p.errors.iter().copied());
    out.section(tags::ACTION_ERRORS, &g.actions.iter().map(|a| a.error).chain(own).collect::<Vec<_>>());
    out.section(tags::SWEEPS, &baked.stops.sweeps);
    out.section(tags::SWEEP_NODES, &baked.stops.nodes);
    out.section(tags::STOPS, &baked.stops.stops);
}

fn policies<'a>(policies: &'a [RawPolicy], out: &mut BundleWriter<'a>) {
    out.section(tags::POLICIES, &policies.iter().map(|p| p.record).collect::<Vec<_>>());
    out.section_of(tags::POLICY_SEGMENTS, policies.iter().map(|p| &*p.segments));
    out.section_of(tags::POLICY_PATHS, policies.iter().map(|p| &*p.paths));
    out.section_of(tags::POLICY_STATE_GRIDS, policies.iter().map(|p| &*p.state_grids));
    out.section_of(tags::POLICY_VALUES, policies.iter().map(|p| &*p.values));
    out.section_of(tags::POLICY_BEST, policies.iter().map(|p| &*p.best));
}
