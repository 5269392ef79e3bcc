//! Schedules clips: from a step of the world's graph to the scheduled clip of a character.

use crate::{World, WorldStep};
use throng_core::characters::{MotionSet, ScheduledClip};
use throng_core::patch::Placement;
use throng_core::planar::{Planar, wrap_angle};

/// Planar root in the world of a link's frame, as the patch has it; its heading counts full turns.
fn nominal_root(motion_set: &MotionSet, [start, end]: [Placement; 2], frame: u32, len: u16, offset: u16) -> Planar {
    let first = motion_set.planar_root(frame);
    let at = |k: u16| start.planar().compose(first.to_local(motion_set.planar_root(frame + u32::from(k))));
    let (here, last) = (at(offset), at(len));
    let share = f32::from(offset) / f32::from(len);
    Planar::new(
        here.x + share * (end.x - last.x),
        here.z + share * (end.z - last.z),
        here.heading + share * (end.heading - last.heading),
    )
}

/// Scheduled clip of a step that plays a link, for a character whose root is `root` at its start: it ends exactly at
/// the end that the patch has, and the distance from the link's own start is removed linearly.
///
/// - returns `None` where nothing is played.
pub(super) fn scheduled_clip(world: &World, step: &WorldStep, root: Option<Planar>) -> Option<ScheduledClip> {
    let (graph, motion_set) = (world.graph(), world.motion_set());
    let link = graph.link(step)?;
    let frame = graph.instance(step.instance).placement;
    let ends = [frame.compose(link.start), frame.compose(link.end)];
    let at = |offset| nominal_root(motion_set, ends, link.frame, link.num_frames, offset);
    let height = |offset: u16| ends[0].y + (ends[1].y - ends[0].y) * (f32::from(offset) / f32::from(link.num_frames));
    let (begin, end) = (at(step.from_offset), at(step.to_offset));
    let root = root.unwrap_or(begin);
    let bare = ScheduledClip {
        frame: link.frame,
        num_frames: step.to_offset.into(),
        from_offset: step.from_offset.into(),
        root,
        lift: height(step.from_offset),
        missing: Placement::IDENTITY,
    };
    let reached = bare.root_at_end(motion_set);
    let turned = (end.heading - begin.heading) - (reached.heading - root.heading);
    let heading = turned - wrap_angle(root.heading - begin.heading);
    let y = height(step.to_offset) - bare.lift;
    Some(ScheduledClip { missing: Placement::new(end.x - reached.x, y, end.z - reached.z, heading), ..bare })
}
