//! Records that point nowhere or hold numbers that cannot be, with right checksums around them.

use super::patch::{Change, Parts};
use crate::common::{bundle, tables};
use throng_core::bundle::tags;
use throng_core::format::{AlignedBytes, ClipRecord, FrameRow, JointCode, RotationCode, SectionTag, SkeletonRecord};
use throng_core::graph::{MotionSegment, StateRecord};
use throng_core::policy::{NO_ACTION, PolicyRecord, SegmentRecord, StateGridRecord};
use throng_core::stops::SweepNode;
use throng_core::{Bundle, Contacts};

fn refuses(tag: Option<SectionTag>, changes: &[Change<'_>]) {
    super::patch::refuses(bundle(), tag, changes);
}

const BAD: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];

fn states(p: &mut Parts, change: impl FnOnce(&mut Vec<StateRecord>)) {
    p.edit(tags::STATES, change);
}

fn segments(p: &mut Parts, change: impl FnOnce(&mut Vec<MotionSegment>)) {
    p.edit(tags::SEGMENTS, change);
}

fn policy(p: &mut Parts, change: impl FnOnce(&mut PolicyRecord)) {
    p.edit::<PolicyRecord>(tags::POLICIES, |all| change(&mut all[0]));
}

#[test]
fn states_lie_in_the_frames_and_are_entered() {
    let num_frames = tables().frames().len() as u32;
    refuses(
        Some(tags::STATES),
        &[
            ("frame after the last", &|p| states(p, |s| s[0].frame = num_frames)),
            ("no frame at all", &|p| states(p, |s| s[3].frame = u32::MAX)),
            ("half standing", &|p| states(p, |s| s[0].standing = 2)),
        ],
    );
    refuses(None, &[("a state without actions", &|p| states(p, |s| s.push(s[0])))]);
    refuses(
        None,
        &[("no state", &|p| {
            states(p, Vec::clear);
            segments(p, Vec::clear);
        })],
    );
    let lonely = |p: &mut Parts| {
        states(p, |s| s.push(s[0]));
        p.edit::<u32>(tags::ACTION_OFFSETS, |o| o.push(o[o.len() - 1] + 1));
        p.edit::<u32>(tags::ACTION_SEGMENTS, |s| s.push(s[0]));
        p.edit::<f32>(tags::ACTION_ERRORS, |e| e.push(e[0]));
    };
    refuses(Some(tags::STATES), &[("a state that nothing leads to", &lonely)]);
}

#[test]
fn segments_lie_in_their_clip_and_end_at_their_state() {
    let (num_states, num_clips) = (tables().graph().states.len() as u32, tables().clips().len() as u32);
    refuses(
        Some(tags::SEGMENTS),
        &[
            ("end after the last state", &|p| segments(p, |s| s[0].end = num_states)),
            ("no end at all", &|p| segments(p, |s| s[0].end = u32::MAX)),
            ("clip after the last", &|p| segments(p, |s| s[0].clip = num_clips)),
            ("another clip", &|p| segments(p, |s| s[0].clip = num_clips - 1)),
            ("starts a frame later", &|p| segments(p, |s| s[0].start += 1)),
            ("starts nowhere", &|p| segments(p, |s| s[0].start = u32::MAX)),
            ("starts in the clip before", &|p| {
                segments(p, |s| {
                    let at = s.iter().position(|s| s.clip == 1).expect("a segment of the second clip");
                    s[at].num_frames += s[at].start;
                    s[at].start = 0;
                });
            }),
            ("plays no frame", &|p| segments(p, |s| s[0].num_frames = 0)),
            ("plays a frame more", &|p| segments(p, |s| s[1].num_frames += 1)),
            ("plays for ever", &|p| segments(p, |s| s[1].num_frames = u32::MAX)),
            ("idles beyond its clip", &|p| segments(p, |s| s[1].idle = u32::MAX)),
            ("idles for less than it lasts", &|p| segments(p, |s| s[1].idle = s[1].num_frames - 1)),
        ],
    );
    for bad in BAD.into_iter().chain([1e9]) {
        for k in 0..3 {
            refuses(Some(tags::SEGMENTS), &[("displacement", &|p| segments(p, |s| s[2].displacement[k] = bad))]);
        }
    }
    // It leads elsewhere than its frames.
    for k in 0..3 {
        refuses(Some(tags::SEGMENTS), &[("displacement", &|p| segments(p, |s| s[2].displacement[k] += 0.1))]);
    }
    let nodes = |p: &mut Parts, by: f32| p.edit::<SweepNode>(tags::SWEEP_NODES, |n| n[5].x += by);
    refuses(Some(tags::SWEEPS), &[("node", &|p| nodes(p, 0.1)), ("node back", &|p| nodes(p, -0.1))]);
}

#[test]
fn actions_exist() {
    let num_segments = tables().graph().segments.len() as u32;
    let offsets = |p: &mut Parts, f: &dyn Fn(&mut Vec<u32>)| p.edit(tags::ACTION_OFFSETS, f);
    refuses(
        None,
        &[
            ("first offset", &|p| offsets(p, &|o| o[0] = 1)),
            ("a state without actions", &|p| offsets(p, &|o| o[2] = o[1])),
            ("offsets that fall", &|p| offsets(p, &|o| o[1] = o[2] + 1)),
            ("an offset past the actions", &|p| offsets(p, &|o| o[1] = u32::MAX)),
            ("a last offset past the actions", &|p| {
                offsets(p, &|o| {
                    let last = o.len() - 1;
                    o[last] += 1;
                });
            }),
            ("an offset too few", &|p| offsets(p, &|o| o.truncate(o.len() - 1))),
            ("an offset too many", &|p| offsets(p, &|o| o.push(o[o.len() - 1]))),
            ("no offsets", &|p| offsets(p, &Vec::clear)),
            ("segment after the last", &|p| p.edit::<u32>(tags::ACTION_SEGMENTS, |s| s[0] = num_segments)),
            ("no segment at all", &|p| p.edit::<u32>(tags::ACTION_SEGMENTS, |s| s[7] = u32::MAX)),
            ("an action too few", &|p| p.edit::<u32>(tags::ACTION_SEGMENTS, |s| s.truncate(s.len() - 1))),
        ],
    );
    // Errors with the costs of a policy follow those of the graph.
    let fewer: &dyn Fn(&mut Parts) = &|p| p.edit::<f32>(tags::ACTION_ERRORS, |e| e.truncate(e.len() - 1));
    refuses(Some(tags::POLICIES), &[("an error too few", fewer)]);
    for bad in BAD.into_iter().chain([-1.0]) {
        let change = |p: &mut Parts| p.edit::<f32>(tags::ACTION_ERRORS, |e| e[1] = bad);
        refuses(Some(tags::ACTION_ERRORS), &[("action error", &change)]);
    }
}

#[test]
fn clips_tile_the_frames() {
    let clips = |p: &mut Parts, f: &dyn Fn(&mut Vec<ClipRecord>)| p.edit(tags::CLIPS, f);
    refuses(
        Some(tags::CLIPS),
        &[
            ("starts late", &|p| clips(p, &|c| c[0].first_frame = 1)),
            ("a frame longer", &|p| clips(p, &|c| c[0].num_frames += 1)),
            ("a frame shorter", &|p| clips(p, &|c| c[0].num_frames -= 1)),
            ("empty", &|p| clips(p, &|c| c[0].num_frames = 0)),
            ("out of order", &|p| clips(p, &|c| c.swap(0, 1))),
            ("half mirrored", &|p| clips(p, &|c| c[1].mirrored = 2)),
            ("reserved field", &|p| clips(p, &|c| c[1].reserved = 9)),
        ],
    );
    refuses(
        None,
        &[
            ("a clip too few", &|p| clips(p, &|c| c.truncate(c.len() - 1))),
            ("no clips", &|p| clips(p, &Vec::clear)),
            ("a last clip past the frames", &|p| {
                clips(p, &|c| {
                    let last = c.len() - 1;
                    c[last].num_frames += 1;
                });
            }),
            ("a frame too few", &|p| p.edit::<FrameRow>(tags::FRAMES, |f| f.truncate(f.len() - 1))),
            ("contacts too few", &|p| p.edit::<Contacts>(tags::CONTACTS, |c| c.truncate(c.len() - 1))),
        ],
    );
    for bits in [128, 129, 255] {
        let change = |p: &mut Parts| p.edit::<Contacts>(tags::CONTACTS, |c| c[5] = Contacts(bits));
        refuses(Some(tags::CONTACTS), &[("more than seven bits", &change)]);
    }
}

#[test]
fn frames_hold_poses() {
    let row = |p: &mut Parts, f: &dyn Fn(&mut FrameRow)| p.edit::<FrameRow>(tags::FRAMES, |rows| f(&mut rows[30]));
    for bad in BAD.into_iter().chain([1e9]) {
        for k in 0..3 {
            refuses(Some(tags::FRAMES), &[("planar root", &|p| row(p, &|r| r.planar[k] = bad))]);
        }
        refuses(Some(tags::FRAMES), &[("height", &|p| row(p, &|r| r.height = bad))]);
    }
    let field = |p: &mut Parts, j: usize, f: &dyn Fn(&mut JointCode)| {
        p.edit::<RotationCode>(tags::ROTATION_CODE, |code| f(&mut code[0].joints[j]));
    };
    let only_w = |c: &mut JointCode, low: [f32; 4], step: f32| {
        (c.bits, c.low, c.step) = ([0, 0, 0, 1], low, [0.0, 0.0, 0.0, step]);
    };
    refuses(
        Some(tags::FRAMES),
        &[
            ("rotations of length 0", &|p| field(p, 21, &|c| only_w(c, [0.0; 4], 0.0))),
            ("rotations far too short", &|p| field(p, 3, &|c| only_w(c, [0.1, 0.0, 0.1, 0.2], 0.0))),
            ("rotations far too long", &|p| field(p, 3, &|c| (c.low, c.step) = ([1.0; 4], [0.0; 4]))),
            ("rotations that change sides", &|p| field(p, 8, &|c| only_w(c, [0.6, 0.0, 0.0, -0.8], 1.6))),
        ],
    );
}

#[test]
fn fields_of_rotations_lie_in_their_rows() {
    let field = |p: &mut Parts, f: &dyn Fn(&mut JointCode)| {
        p.edit::<RotationCode>(tags::ROTATION_CODE, |code| f(&mut code[0].joints[11]));
    };
    refuses(
        Some(tags::ROTATION_CODE),
        &[
            ("a field behind the row", &|p| field(p, &|c| c.at = 640)),
            ("a field that overlaps its end", &|p| field(p, &|c| c.at = 639)),
            ("far behind", &|p| field(p, &|c| c.at = u32::MAX)),
            ("seventeen bits", &|p| field(p, &|c| c.bits = [17, 1, 1, 0])),
            ("58 bits", &|p| field(p, &|c| (c.at, c.bits) = (0, [15, 15, 14, 14]))),
            ("a centre of length 2", &|p| field(p, &|c| c.centre = [0.0, 0.0, 0.0, 2.0])),
            ("a lowest value of no rotation", &|p| field(p, &|c| c.low[0] = -3.0)),
            ("no step", &|p| field(p, &|c| c.step[1] = f32::NAN)),
            ("a step backwards", &|p| field(p, &|c| c.step[1] = -0.1)),
        ],
    );
    refuses(
        None,
        &[
            ("no code", &|p| p.edit::<RotationCode>(tags::ROTATION_CODE, Vec::clear)),
            ("two codes", &|p| p.edit::<RotationCode>(tags::ROTATION_CODE, |c| c.push(c[0]))),
        ],
    );
}

#[test]
fn skeletons_have_lengths() {
    let skeleton = |p: &mut Parts, f: &dyn Fn(&mut SkeletonRecord)| {
        p.edit::<SkeletonRecord>(tags::SKELETON, |s| f(&mut s[0]));
    };
    for bad in BAD.into_iter().chain([1e6]) {
        let changes: [Change<'_>; 2] = [
            ("offset", &|p| skeleton(p, &|s| s.offsets[9][1] = bad)),
            ("tip", &|p| skeleton(p, &|s| s.tips[2][0] = bad)),
        ];
        refuses(Some(tags::SKELETON), &changes);
    }
    let shin = throng_core::Joint::LeftShin.index();
    refuses(Some(tags::SKELETON), &[("no thigh", &|p| skeleton(p, &|s| s.offsets[shin] = [0.0; 3]))]);
    refuses(
        None,
        &[
            ("two skeletons", &|p| p.edit::<SkeletonRecord>(tags::SKELETON, |s| s.push(s[0]))),
            ("no skeleton", &|p| p.edit::<SkeletonRecord>(tags::SKELETON, Vec::clear)),
        ],
    );
}

#[test]
fn policies_fit_the_graph() {
    refuses(
        Some(tags::POLICIES),
        &[
            ("other states", &|p| policy(p, |r| r.num_states += 1)),
            ("other segments", &|p| policy(p, |r| r.num_segments -= 1)),
            ("no choices", &|p| policy(p, |r| r.num_choices = 0)),
            ("five choices", &|p| policy(p, |r| r.num_choices = 5)),
            ("fewer choices", &|p| policy(p, |r| r.num_choices -= 1)),
            ("no rings", &|p| policy(p, |r| r.grid.num_rings = 0)),
            ("countless rings", &|p| policy(p, |r| r.grid.num_rings = u32::MAX)),
            ("a ring more", &|p| policy(p, |r| r.grid.num_rings += 1)),
            ("countless angles", &|p| policy(p, |r| r.grid.num_angles = u32::MAX)),
            ("heights of a polar grid", &|p| policy(p, |r| r.grid.num_heights = 0)),
            ("an unknown grid", &|p| policy(p, |r| r.grid.kind = 7)),
            ("an unknown kernel", &|p| policy(p, |r| r.reward.kernel = 99)),
            ("an unknown combination", &|p| policy(p, |r| r.reward.combine = 99)),
            ("no scale", &|p| policy(p, |r| r.reward.scale = 0.0)),
            ("discount 1", &|p| policy(p, |r| r.discount = 1.0)),
            ("discount 0", &|p| policy(p, |r| r.discount = 0.0)),
        ],
    );
    for bad in BAD {
        let changes: [Change<'_>; 7] = [
            ("ring spacing", &|p| policy(p, |r| r.grid.ring_spacing = bad)),
            ("ring growth", &|p| policy(p, |r| r.grid.ring_growth = bad)),
            ("falloff", &|p| policy(p, |r| r.grid.falloff = bad)),
            ("scale", &|p| policy(p, |r| r.reward.scale = bad)),
            ("discount", &|p| policy(p, |r| r.discount = bad)),
            ("epsilon", &|p| policy(p, |r| r.epsilon = bad)),
            ("residual", &|p| policy(p, |r| r.residual = bad)),
        ];
        refuses(Some(tags::POLICIES), &changes);
    }
}

#[test]
fn policy_tables_hold_actions_and_numbers() {
    let (num_states, actions) = (tables().graph().states.len() as u32, tables().graph().segments_of(0).len() as u8);
    let segment = |p: &mut Parts, f: &dyn Fn(&mut SegmentRecord)| {
        p.edit::<SegmentRecord>(tags::POLICY_SEGMENTS, |s| f(&mut s[1]));
    };
    let best = |p: &mut Parts, at: usize, action: u8| p.edit::<u8>(tags::POLICY_BEST, |b| b[at] = action);
    refuses(
        Some(tags::POLICIES),
        &[
            ("end after the last state", &|p| segment(p, &|s| s.end = num_states)),
            ("no end at all", &|p| segment(p, &|s| s.end = u32::MAX)),
            ("action after the last", &|p| best(p, 0, actions)),
            ("second choice after the last", &|p| best(p, 1, actions)),
            ("no first choice", &|p| best(p, 0, NO_ACTION)),
            ("values too few", &|p| p.edit::<f32>(tags::POLICY_VALUES, |v| v.truncate(v.len() - 1))),
            ("best actions too few", &|p| p.edit::<u8>(tags::POLICY_BEST, |b| b.truncate(b.len() - 1))),
            ("segments too few", &|p| p.edit::<SegmentRecord>(tags::POLICY_SEGMENTS, |s| s.truncate(s.len() - 1))),
        ],
    );
    refuses(
        None,
        &[
            ("values too many", &|p| p.edit::<f32>(tags::POLICY_VALUES, |v| v.push(0.0))),
            ("best actions too many", &|p| p.edit::<u8>(tags::POLICY_BEST, |b| b.push(0))),
            ("segments too many", &|p| p.edit::<SegmentRecord>(tags::POLICY_SEGMENTS, |s| s.push(s[0]))),
        ],
    );
    for bad in BAD {
        let changes: [Change<'_>; 5] = [
            ("displacement", &|p| segment(p, &|s| s.displacement[0] = bad)),
            ("inner sample", &|p| segment(p, &|s| s.inner[3] = bad)),
            ("weight", &|p| segment(p, &|s| s.weights[2] = bad)),
            ("discount of a segment", &|p| segment(p, &|s| s.discount = bad)),
            ("value", &|p| p.edit::<f32>(tags::POLICY_VALUES, |v| v[11] = bad)),
        ];
        refuses(Some(tags::POLICIES), &changes);
    }
}

/// The small bundle with its one policy made adaptive, the finest grid in every state: the same values.
fn adaptive() -> Parts {
    let mut parts = Parts::of(bundle());
    let (grid, num_states) = (*tables().policies()[0].grid(), tables().graph().states.len() as u32);
    let record = |s| StateGridRecord::new(grid.counts(), s * grid.num_cells() as u32);
    parts.edit::<StateGridRecord>(tags::POLICY_STATE_GRIDS, |g| g.extend((0..num_states).map(record)));
    policy(&mut parts, |r| r.adaptive = 1);
    parts
}

#[test]
fn state_grids_tile_the_values() {
    let bytes = adaptive().join();
    let opened = Bundle::from_bytes(AlignedBytes::from_slice(&bytes)).expect("an adaptive policy opens");
    assert!(opened.policies()[0].is_adaptive());
    let (from, to) = (tables(), opened);
    assert_eq!(from.policies()[0].values_of(3), to.policies()[0].values_of(3));
    let grids = |p: &mut Parts, f: &dyn Fn(&mut Vec<StateGridRecord>)| p.edit(tags::POLICY_STATE_GRIDS, f);
    let changes: [(Option<SectionTag>, Change<'_>); 10] = [
        (Some(tags::POLICIES), ("a ring less", &|p| grids(p, &|g| g[0].counts[0] -= 1))),
        (Some(tags::POLICIES), ("an angle more", &|p| grids(p, &|g| g[1].counts[1] += 1))),
        (Some(tags::POLICIES), ("no height", &|p| grids(p, &|g| g[1].counts[2] = 0))),
        (Some(tags::POLICIES), ("counts below zero", &|p| grids(p, &|g| g[1].counts = [-1, -1, 1, 0]))),
        (Some(tags::POLICIES), ("a gap", &|p| grids(p, &|g| g[2].first += 1))),
        (Some(tags::POLICIES), ("reserved field", &|p| grids(p, &|g| g[2].reserved = 1))),
        (Some(tags::POLICIES), ("a state grid too few", &|p| grids(p, &|g| g.truncate(g.len() - 1)))),
        (Some(tags::POLICIES), ("no state grids", &|p| grids(p, &Vec::clear))),
        (Some(tags::POLICIES), ("twice adaptive", &|p| policy(p, |r| r.adaptive = 2))),
        (None, ("a state grid too many", &|p| grids(p, &|g| g.push(g[0])))),
    ];
    let whole = adaptive().join();
    for (tag, change) in changes {
        super::patch::refuses(&whole, tag, &[change]);
    }
    refuses(None, &[("state grids of a policy that has none", &|p| *p = adaptive_in_part())]);
}

/// State grids without a policy that says so.
fn adaptive_in_part() -> Parts {
    let mut parts = adaptive();
    policy(&mut parts, |r| r.adaptive = 0);
    parts
}

#[test]
fn what_a_bundle_says_of_itself_fits_its_tables() {
    let meta = |p: &mut Parts, f: &dyn Fn(&mut throng_core::format::Meta)| p.edit_meta(f);
    refuses(
        None,
        &[
            ("a clip more", &|p| meta(p, &|m| m.clips.push(m.clips[0].clone()))),
            ("no behaviours", &|p| meta(p, &|m| m.behaviours.clear())),
            ("a behaviour more", &|p| meta(p, &|m| m.behaviours.push("flee".into()))),
            ("cut META", &|p| p.edit::<u8>(tags::META, |b| b.truncate(b.len() - 1))),
            ("longer META", &|p| p.edit::<u8>(tags::META, |b| b.push(0))),
            ("no META", &|p| p.edit::<u8>(tags::META, Vec::clear)),
            ("a name of endless length", &|p| p.edit::<u8>(tags::META, |b| b[..9].fill(0xfd))),
            ("nonsense", &|p| p.edit::<u8>(tags::META, |b| b.fill(0xff))),
        ],
    );
    for rate in [0.0, -30.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        refuses(None, &[("rate", &|p| meta(p, &|m| m.rate_hz = rate))]);
    }
}
