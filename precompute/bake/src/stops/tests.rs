use super::*;
use crate::graph::{GraphAction, GraphSegment, StateId};
use glam::Quat;
use proptest::prelude::*;
use throng_base::SingleRank;
use throng_core::Planar;
use throng_core::{NUM_JOINTS, Skeleton};

const FRAMES: usize = 240;

/// A clip that walks on a curve, bows at times, and stands from frame 80 to 160.
fn clips() -> ClipSet {
    let (mut roots, mut rotations, mut at) = (Vec::new(), Vec::new(), Planar::IDENTITY);
    for f in 0..FRAMES {
        let stands = (80..160).contains(&f);
        let step = if stands { 0.0 } else { 0.04 };
        at = at.compose(Planar::new(0.002 * (0.3 * f as f32).sin(), step, if stands { 0.0 } else { 0.02 }));
        roots.push(at.translation() + Vec3::Y * 0.95);
        let bow = if (20..40).contains(&f) { 0.4 } else { 0.05 };
        rotations.extend((0..NUM_JOINTS).map(|j| match j {
            0 => at.rotation(),
            1..=3 => Quat::from_rotation_x(bow),
            _ => Quat::IDENTITY,
        }));
    }
    let contacts = (0..FRAMES).map(|f| if f % 7 < 2 { Contacts(5) } else { Contacts(1) }).collect();
    let clip = Clip { contacts, ..Clip::new("a", 30.0, roots, rotations) };
    ClipSet { skeleton: Skeleton::default(), clips: vec![clip] }
}

/// A graph of states at some frames, each with some of the segments that end in others.
fn graph(mut frames: Vec<usize>, picks: &[(usize, usize)]) -> RawMotionGraph {
    frames.sort_unstable();
    frames.dedup();
    let clip = &clips().clips[0];
    let planar = |f: usize| Planar::split(clip.root_positions[f], clip.frame_rotations(f)[0]).0;
    let mut out = RawMotionGraph { action_offsets: vec![0], ..RawMotionGraph::default() };
    for (s, &frame) in frames.iter().enumerate() {
        out.states.push(FrameId(frame as u32));
        out.standing.push((85..155).contains(&frame));
        let num_frames = (5 + s * 7 % 25).min(frame);
        let (start, end) = (FrameId((frame - num_frames) as u32), StateId(s as u32));
        let displacement = planar(frame - num_frames).to_local(planar(frame));
        out.segments.push(GraphSegment { start, num_frames: num_frames as u32, end, displacement });
    }
    let n = frames.len();
    for s in 0..n {
        let of_state = picks.iter().enumerate().filter(|(i, p)| *i < n || p.0 % n == s);
        let mut to: Vec<usize> = of_state.filter(|(i, p)| *i == s || p.0 % n == s).map(|(_, p)| p.1 % n).collect();
        to.push((s + 1) % n);
        to.sort_unstable();
        to.dedup();
        out.actions.extend(to.iter().map(|&t| GraphAction { segment: SegmentId(t as u32), error: 0.1 * t as f32 }));
        out.action_offsets.push(out.actions.len() as u32);
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn stops_are_the_cheapest_ways_to_a_stand_and_sweeps_hold_the_body(
        frames in proptest::collection::vec(30usize..FRAMES, 2..14),
        picks in proptest::collection::vec((0usize..14, 0usize..14), 14..60),
    ) {
        let (clips, graph) = (clips(), graph(frames, &picks));
        let (found, report) = find_stops(&clips, &graph, &SingleRank).unwrap();
        let n = graph.states.len();
        let segment = |a: SegmentId| &graph.segments[a.0 as usize];
        // Every frame is near the line between its nodes, and within the disc.
        let clip = &clips.clips[0];
        for (s, sweep) in graph.segments.iter().zip(&found.sweeps) {
            let nodes = &found.nodes[sweep.first_node as usize..][..sweep.num_nodes as usize];
            for f in 0..=s.num_frames {
                let k = nodes.partition_point(|n| n.frame <= f).clamp(1, nodes.len() - 1);
                let (a, b) = (nodes[k - 1], nodes[k]);
                let share = (f - a.frame) as f32 / (b.frame - a.frame) as f32;
                let on = Vec2::new(a.x, a.z).lerp(Vec2::new(b.x, b.z), share);
                let at = |f: u32| Planar::split(clip.root_positions[f as usize], clip.frame_rotations(f as usize)[0]).0;
                let local = at(s.start.0).to_local(at(s.start.0 + f));
                let off = on.distance(Vec2::new(local.x, local.z));
                prop_assert!(off < SWEEP_TOLERANCE_M + 1e-4, "{off}");
                let joints = clip.joint_transforms(&clips.skeleton, (s.start.0 + f) as usize);
                let (root, neck) = (joints[0].0, joints[Joint::Neck.index()].0);
                let beside = Vec2::new(neck.x - root.x, neck.z - root.z).length() + TRUNK_ROOM_M;
                prop_assert!(beside <= sweep.radius);
            }
        }
        // So is the pose that one comes from.
        for (s, frame) in graph.states.iter().enumerate() {
            let joints = clip.joint_transforms(&clips.skeleton, frame.0 as usize);
            let (root, neck) = (joints[0].0, joints[Joint::Neck.index()].0);
            let beside = Vec2::new(neck.x - root.x, neck.z - root.z).length() + TRUNK_ROOM_M;
            prop_assert!((beside..=found.stops[s].radius).contains(&found.stops[s].pose_radius));
        }
        // By brute force: costs settle after as many rounds as there are states.
        let lean = |a: SegmentId| f64::from(found.sweeps[a.0 as usize].radius - BODY_RADIUS_M);
        let path = |a: SegmentId| f64::from(segment(a).displacement.x.hypot(segment(a).displacement.z));
        let seconds = |a: SegmentId| f64::from(segment(a).num_frames) / 30.0;
        let cost = |a: SegmentId| seconds(a) + METRE_S * path(a) + LEAN_S * lean(a);
        let both = on_both(&clips, &[0], &graph);
        let slow = |a: &GraphAction| {
            cost(a.segment) + seconds(a.segment) + if both[segment(a.segment).end.0 as usize] { SLOWING_S } else { LIFTED_S }
        };
        let mut least: Vec<f64> = (0..n).map(|s| match found.stops[s].kind {
            REST => 0.0,
            _ => graph.actions_of(StateId(s as u32)).iter().map(slow).fold(f64::INFINITY, f64::min),
        }).collect();
        for _ in 0..n {
            for s in 0..n {
                let on = graph.actions_of(StateId(s as u32)).iter().map(|a| cost(a.segment) + least[segment(a.segment).end.0 as usize]);
                least[s] = on.fold(least[s], f64::min);
            }
        }
        for s in 0..n {
            let (mut at, mut frames, mut total) = (s, 0, 0.0);
            // Every way comes to its end.
            for _ in 0..=n {
                let stop = found.stops[at];
                prop_assert!(graph.actions_of(StateId(at as u32)).iter().any(|a| a.segment.0 == stop.segment));
                let a = SegmentId(stop.segment);
                prop_assert!(stop.radius >= found.sweeps[a.0 as usize].radius);
                match stop.kind {
                    REST => {
                        prop_assert!(graph.standing[at] && segment(a).displacement.x.hypot(segment(a).displacement.z) <= REST_PATH_M);
                        prop_assert_eq!(found.stops[segment(a).end.0 as usize].kind, REST);
                        break;
                    }
                    SLOW_DOWN => {
                        frames += 2 * segment(a).num_frames;
                        total += slow(&GraphAction { segment: a, error: 0.0 });
                        break;
                    }
                    _ => {
                        frames += segment(a).num_frames;
                        total += cost(a);
                        at = segment(a).end.0 as usize;
                    }
                }
            }
            prop_assert_eq!(frames, found.stops[s].frames);
            prop_assert!((total - least[s]).abs() < 1e-6, "state {s}: {total} s, {} s are enough", least[s]);
        }
        prop_assert_eq!(report.resting_states, found.stops.iter().filter(|s| s.kind == REST).count());
    }
}

#[test]
fn the_resting_states_are_the_greatest_set_that_leads_into_itself() {
    // 90 rests with itself; 100 stands, but leads only to walking.
    let graph = RawMotionGraph {
        states: [90, 100, 200].map(FrameId).to_vec(),
        standing: vec![true, true, false],
        segments: [(85, 5, 0), (95, 5, 1), (190, 10, 2)]
            .map(|(start, num_frames, end)| GraphSegment {
                start: FrameId(start),
                num_frames,
                end: StateId(end),
                displacement: Planar::IDENTITY,
            })
            .to_vec(),
        action_offsets: vec![0, 2, 3, 5],
        actions: [0, 2, 2, 0, 1].map(|s| GraphAction { segment: SegmentId(s), error: 0.0 }).to_vec(),
        ..RawMotionGraph::default()
    };
    let (found, report) = find_stops(&clips(), &graph, &SingleRank).unwrap();
    assert_eq!(found.stops.iter().map(|s| s.kind).collect::<Vec<_>>(), [REST, WALK_ON, WALK_ON]);
    assert_eq!((report.resting_states, report.slowing_states), (1, 0));
    assert_eq!(found.stops[1].frames, 10 + 5);
}
