//! Event frames, at which a transition may leave or enter a clip.

use super::config::MotionGraphConfig;
use crate::share::{clip_owners, sort_by_owner};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use throng_base::Comm;
use throng_core::{Contacts, Joint, NUM_JOINTS, skeleton::ARMS};
use throng_motion::clip::{Clip, ClipSet, FrameId, FrameRange, runs_where};
use throng_motion::error::Result;

/// Kind of an event frame. Transitions join events of equal kind only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum EventFrameKind {
    /// The last frame of the left foot's contact.
    LeavesLeft {
        /// True while the right foot is on the ground: a step, not a stride of a run.
        other_planted: bool,
    },
    /// The last frame of the right foot's contact.
    LeavesRight {
        /// True while the left foot is on the ground.
        other_planted: bool,
    },
    /// The last frame before a jump off both feet.
    LeavesBoth,
    /// Both feet planted and the root slow for a while.
    Standing,
    /// A hand or foot that is about to strike or has just come back: most folded before and after a blow.
    OnGuard {
        /// True while the left foot is on the ground.
        left_planted: bool,
        /// True while the right foot is on the ground.
        right_planted: bool,
    },
}

/// Longest time from the begin of a blow to its landing, and from there to its end (s).
const BLOW_S: [f64; 2] = [0.5, 0.75];

/// A frame at which transitions may leave and enter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EventFrame {
    /// The frame.
    pub frame: FrameId,
    /// Index of its clip.
    pub clip: usize,
    /// Kind of the event.
    pub kind: EventFrameKind,
    /// Number of its run of usable frames, counted over all clips: motion continues from an event to the next one of
    /// the same run.
    pub run: usize,
    /// Number of the standing run, counted over all clips.
    pub standing_run: Option<usize>,
    /// True if a character may stand for long: it stands, and holds no arm out.
    pub is_rest: bool,
    /// End of the run of usable frames, exclusive.
    pub run_end: FrameId,
}

/// The event frames of all clips, ascending.
///
/// - `taken`: runs of frames of each clip that the graph takes.
/// - `comm`: processes that hold the other poses; poses are needed in strikes and stands.
///
/// # Errors
/// As [`sort_by_owner`].
pub(super) fn find_events(
    clips: &ClipSet,
    taken: &[Vec<FrameRange>],
    config: &MotionGraphConfig,
    comm: &dyn Comm,
) -> Result<Vec<EventFrame>> {
    let starts = clips.frame_starts();
    let posed = sort_by_owner(comm, &clip_owners(clips, comm.num_ranks()), |index| {
        let (clip, mut found) = (&clips.clips[index], PoseEvents::default());
        for run in &taken[index] {
            found.guards.extend(guard_frames(clips, clip, run));
            let standing = standing_runs_of(clip, run, config).into_iter().flat_map(|r| places_in(clip, r, config));
            found.rests.extend(standing.filter(|&f| !holds_arm_out(&clip.joint_positions(&clips.skeleton, f))));
        }
        found
    })?;
    let (mut events, mut runs, mut standing_runs) = (Vec::new(), 0, 0);
    for (index, clip) in clips.clips.iter().enumerate() {
        for run in taken[index].iter().cloned() {
            let mut found: Vec<(usize, EventFrameKind, Option<usize>)> = departure_frames(clip, &run, config)
                .into_iter()
                .chain(posed[index].guards.iter().copied().filter(|(f, _)| run.contains(f)))
                .map(|(f, kind)| (f, kind, None))
                .collect();
            for standing in standing_runs_of(clip, &run, config) {
                let places = places_in(clip, standing, config);
                found.extend(places.map(|f| (f, EventFrameKind::Standing, Some(standing_runs))));
                standing_runs += 1;
            }
            // A foot that leaves while standing is the stronger event, so it sorts first and the other is dropped.
            found.sort_unstable();
            found.dedup_by_key(|e| e.0);
            let frame = |f: usize| FrameId(starts[index] + f as u32);
            events.extend(found.into_iter().map(|(f, kind, standing_run)| EventFrame {
                frame: frame(f),
                clip: index,
                kind,
                run: runs,
                standing_run,
                is_rest: kind == EventFrameKind::Standing && posed[index].rests.binary_search(&f).is_ok(),
                run_end: frame(run.end),
            }));
            runs += 1;
        }
    }
    Ok(events)
}

/// Events of a clip that depend on its poses.
#[derive(Default, Serialize, Deserialize)]
struct PoseEvents {
    /// Frames and kinds of events on guard; see [`guard_frames`].
    guards: Vec<(usize, EventFrameKind)>,
    /// Frames of events in standing runs at which no arm is held out, ascending.
    rests: Vec<usize>,
}

/// True for a gesture, such as an offered or a waving hand, however long it is held: an arm with an elbow opened wider
/// than a right angle points more than [`HANGING`] off straight down. Hands on hips, crossed arms and guards are none.
pub(crate) fn holds_arm_out(joints: &[Vec3; NUM_JOINTS]) -> bool {
    ARMS.iter().any(|&arm| is_held_out(joints, arm))
}

/// True for an arm (shoulder, elbow, wrist) that [`holds_arm_out`] counts.
pub(crate) fn is_held_out(joints: &[Vec3; NUM_JOINTS], arm: [Joint; 3]) -> bool {
    let [shoulder, elbow, wrist] = arm.map(|j| joints[j.index()]);
    let reach = wrist - shoulder;
    (shoulder - elbow).dot(wrist - elbow) < 0.0 && -reach.y < HANGING * reach.length()
}

/// Cosine of the largest angle off straight down, from shoulder to wrist, of a hanging arm: half a right angle.
const HANGING: f32 = std::f32::consts::FRAC_1_SQRT_2;

fn frames(clip: &Clip, seconds: f64) -> usize {
    (seconds * clip.rate_hz).round() as usize
}

/// Frames of the events of a standing run.
fn places_in(clip: &Clip, standing: FrameRange, config: &MotionGraphConfig) -> impl Iterator<Item = usize> {
    standing.step_by(frames(clip, config.standing_interval_s).max(1))
}

/// Last contact frames of each foot within a run of usable frames.
fn departure_frames(clip: &Clip, run: &FrameRange, config: &MotionGraphConfig) -> Vec<(usize, EventFrameKind)> {
    let swing = frames(clip, config.min_swing_s).max(1);
    let planted = |f: usize, foot| clip.contacts[f].any(foot);
    let leaves = |f: usize, foot| planted(f, foot) && !(f + 1..(f + 1 + swing).min(run.end)).any(|g| planted(g, foot));
    let kind = |f: usize| match (leaves(f, Contacts::LEFT), leaves(f, Contacts::RIGHT)) {
        (true, true) => Some(EventFrameKind::LeavesBoth),
        (true, false) => Some(EventFrameKind::LeavesLeft { other_planted: planted(f, Contacts::RIGHT) }),
        (false, true) => Some(EventFrameKind::LeavesRight { other_planted: planted(f, Contacts::LEFT) }),
        (false, false) => None,
    };
    (run.start..run.end.saturating_sub(1)).filter_map(|f| Some((f, kind(f)?))).collect()
}

/// Frames at which striking limbs are most folded before and after a blow, within a run of usable frames. A boxer with
/// planted feet could not choose between two blows otherwise.
fn guard_frames(clips: &ClipSet, clip: &Clip, run: &FrameRange) -> Vec<(usize, EventFrameKind)> {
    const LIMBS: [Joint; 4] = [Joint::LeftHand, Joint::RightHand, Joint::LeftFoot, Joint::RightFoot];
    let [before, after] = BLOW_S.map(|s| frames(clip, s));
    let mut out = Vec::new();
    for hit in clip.hits.iter().filter(|h| LIMBS.contains(&h.joint) && run.contains(&h.frame)) {
        let Some(root) = hit.joint.parent().and_then(Joint::parent) else { continue };
        let length = |f: usize| {
            let p = clip.joint_positions(&clips.skeleton, f);
            p[hit.joint.index()].distance(p[root.index()])
        };
        let folded = |range: FrameRange| range.min_by(|&a, &b| length(a).total_cmp(&length(b)));
        let around = [
            hit.frame.saturating_sub(before).max(run.start)..hit.frame,
            hit.frame + 1..(hit.frame + after).min(run.end - 1),
        ];
        out.extend(around.into_iter().filter_map(folded).map(|f| {
            let planted = |foot| clip.contacts[f].any(foot);
            let (left_planted, right_planted) = (planted(Contacts::LEFT), planted(Contacts::RIGHT));
            (f, EventFrameKind::OnGuard { left_planted, right_planted })
        }));
    }
    out
}

/// Runs within `run` with both feet planted and the root slow for long enough.
pub(crate) fn standing_runs_of(clip: &Clip, run: &FrameRange, config: &MotionGraphConfig) -> Vec<FrameRange> {
    let stands = |f: usize| {
        let (prev, next) = (f.saturating_sub(1).max(run.start), (f + 1).min(run.end - 1));
        let seconds = (next - prev).max(1) as f64 / clip.rate_hz;
        let travel = clip.root_positions[next] - clip.root_positions[prev];
        clip.contacts[f].any(Contacts::LEFT)
            && clip.contacts[f].any(Contacts::RIGHT)
            && f64::from(travel.length()) / seconds <= config.standing_speed_mps
    };
    let least = frames(clip, config.standing_min_s).max(1);
    let mut out = runs_where(run.clone(), stands);
    out.retain(|r| r.len() >= least);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};
    use throng_base::SingleRank;
    use throng_core::{NUM_JOINTS, Skeleton};
    use throng_motion::clip::{Exclusion, ExclusionReason};

    /// A clip whose contacts are written `.` none, `L`, `R`, `B` both, moving at `speed` m/s.
    fn clip(contacts: &str, speed: f32) -> Clip {
        let bits = |c| match c {
            'L' => Contacts::LEFT_TOE,
            'R' => Contacts::RIGHT_HEEL,
            'B' => Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0),
            _ => Contacts::NONE,
        };
        let contacts: Vec<Contacts> = contacts.chars().map(bits).collect();
        let n = contacts.len();
        Clip {
            contacts,
            ..Clip::new(
                "c",
                30.0,
                (0..n).map(|f| Vec3::new(0.0, 0.9, speed * f as f32 / 30.0)).collect(),
                vec![Quat::IDENTITY; n * NUM_JOINTS],
            )
        }
    }

    fn usable(set: &ClipSet) -> Vec<Vec<FrameRange>> {
        set.clips.iter().map(Clip::usable_ranges).collect()
    }

    fn kinds(clip: Clip) -> Vec<(u32, EventFrameKind)> {
        let set = ClipSet { skeleton: Skeleton::default(), clips: vec![clip] };
        find_events(&set, &usable(&set), &MotionGraphConfig::default(), &SingleRank)
            .unwrap()
            .iter()
            .map(|e| (e.frame.0, e.kind))
            .collect()
    }

    #[test]
    fn walking_running_and_jumping_leave_the_ground() {
        use EventFrameKind::*;
        let walk = kinds(clip("BBLLLLBBRRRRBBLLLL", 1.0));
        assert_eq!(
            walk,
            [
                (1, LeavesRight { other_planted: true }),
                (7, LeavesLeft { other_planted: true }),
                (13, LeavesRight { other_planted: true })
            ]
        );
        assert_eq!(
            kinds(clip("LL....RR....", 3.0)),
            [(1, LeavesLeft { other_planted: false }), (7, LeavesRight { other_planted: false })]
        );
        assert_eq!(kinds(clip("BBBB.....", 3.0)), [(3, LeavesBoth)]);
    }

    #[test]
    fn a_flicker_of_contact_is_no_departure() {
        assert_eq!(kinds(clip("BBLLBBBBLLLL", 1.0)), [(7, EventFrameKind::LeavesRight { other_planted: true })]);
    }

    #[test]
    fn standing_gives_an_event_every_interval_and_excluded_frames_none() {
        let mut c = clip(&"B".repeat(60), 0.0);
        assert_eq!(kinds(c.clone()).iter().map(|k| k.0).collect::<Vec<_>>(), [0, 8, 16, 24, 32, 40, 48, 56]);
        c.excluded.push(Exclusion { range: 0..50, reason: ExclusionReason::TPose });
        assert_eq!(kinds(c.clone()), [(50, EventFrameKind::Standing), (58, EventFrameKind::Standing)]);
        c.excluded[0].range = 0..55;
        assert_eq!(kinds(c), []);
        assert_eq!(kinds(clip(&"B".repeat(60), 0.5)), []);
    }

    #[test]
    fn blows_give_an_event_before_and_after_each() {
        use throng_motion::clip::{ClipHit, HitKind};
        let mut c = clip(&"B".repeat(60), 0.3);
        // The forearm folds back but for an instant around frame 30: a blow, and guard until 24 and from 36 on.
        for f in 0..60usize {
            let bent = (f.abs_diff(30) as f32 / 6.0).min(1.0) + 0.01 * (f.abs_diff(30) as f32 / 6.0 - 1.0).max(0.0);
            c.rotations[f * NUM_JOINTS + Joint::RightForearm.index()] =
                Quat::from_rotation_y(2.0 * bent.min(1.0) - 0.1 * (bent - 1.0).max(0.0));
        }
        assert!(kinds(c.clone()).is_empty());
        let hit = ClipHit {
            frame: 29,
            kind: HitKind::Punch,
            joint: Joint::RightHand,
            position: Vec3::Y,
            direction: Vec3::Z,
            speed_mps: 3.0,
            force: 1.0,
        };
        c.hits = vec![hit];
        let on_guard = EventFrameKind::OnGuard { left_planted: true, right_planted: true };
        assert_eq!(kinds(c), [(24, on_guard), (36, on_guard)]);
    }

    #[test]
    fn an_arm_held_out_is_a_gesture_and_no_place_to_rest() {
        // Everybody stands; the right arm is lifted by an angle to the side, its elbow bent by another.
        let rests = |lift: f32, bend: f32| {
            let mut c = clip(&"B".repeat(20), 0.0);
            for f in 0..20 {
                let q = &mut c.rotations[f * NUM_JOINTS..][..NUM_JOINTS];
                q[Joint::LeftUpperArm.index()] = Quat::from_rotation_z(-1.4);
                q[Joint::RightUpperArm.index()] = Quat::from_rotation_z(1.5 - lift.to_radians());
                q[Joint::RightForearm.index()] = Quat::from_rotation_z(-bend.to_radians());
            }
            let set = ClipSet { skeleton: Skeleton::default(), clips: vec![c] };
            let events = find_events(&set, &usable(&set), &MotionGraphConfig::default(), &SingleRank).unwrap();
            assert!(events.iter().all(|e| e.kind == EventFrameKind::Standing));
            events.iter().map(|e| e.is_rest).collect::<Vec<_>>()
        };
        for (lift, bend, rest) in [
            (0.0, 0.0, true),
            (30.0, 0.0, true),
            (60.0, 0.0, false),
            (90.0, 20.0, false),
            (160.0, 60.0, false),
            // A guard: the elbow is bent by more than a right angle.
            (60.0, 130.0, true),
        ] {
            assert_eq!(rests(lift, bend), [rest; 3], "lifted by {lift}, bent by {bend} degrees");
        }
    }
}
