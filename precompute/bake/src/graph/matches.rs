//! Which event frames are alike: all pairs, in parallel.

use super::events::Event;
use crate::features::Features;
use rayon::prelude::*;
use throng_core::Planar;
use throng_core::planar::wrap_angle;
use throng_motion::clip::{ClipSet, FrameId};
use throng_motion::progress::{Progress, Stopped};

/// A transition that is possible: the motion that follows event `event` may be laid after another event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// The event whose motion follows.
    pub event: usize,
    /// Distance between the two frames (rad).
    pub error: f32,
}

/// The event after each one in its run; motion goes on to it (events.len()).
pub(super) fn successors(events: &[Event]) -> Vec<Option<usize>> {
    let mut next: Vec<Option<usize>> =
        events.windows(2).enumerate().map(|(i, w)| (w[0].run == w[1].run).then_some(i + 1)).collect();
    next.resize(events.len(), None);
    next
}

/// For every event the ones like it, best first, up to a distance of `limit` (events.len()).
///
/// Left out are events after which no other event comes, events nearer than `min_jump` frames in the same run,
/// and within one standing run all but the local minima of the distance.
///
/// # Errors
/// [`Stopped`] where the progress says so.
pub(super) fn find(
    events: &[Event],
    features: &Features,
    limit: f32,
    min_jump: u32,
    progress: &dyn Progress,
) -> Result<Vec<Vec<Link>>, Stopped> {
    progress.begin("graph", events.len() as u64, "event frames");
    let next = successors(events);
    let matches = (0..events.len())
        .into_par_iter()
        .map(|i| {
            progress.check()?;
            let mut links = similar(events, features, i, limit);
            keep_local_minima(&mut links, events);
            links.retain(|l| next[l.event].is_some() && !is_near(&events[i], &events[l.event], min_jump));
            links.sort_unstable_by(|a, b| a.error.total_cmp(&b.error).then(a.event.cmp(&b.event)));
            progress.advance(1);
            Ok(links)
        })
        .collect();
    progress.end();
    matches
}

fn similar(events: &[Event], features: &Features, i: usize, limit: f32) -> Vec<Link> {
    let of_kind = events.iter().enumerate().filter(|&(k, e)| k != i && e.kind == events[i].kind);
    of_kind
        .filter_map(|(k, e)| {
            let squared = features.squared_distance_within(events[i].frame, e.frame, limit * limit)?;
            Some(Link { event: k, error: squared.sqrt() })
        })
        .collect()
}

fn is_near(a: &Event, b: &Event, min_jump: u32) -> bool {
    a.run == b.run && a.frame.0.abs_diff(b.frame.0) < min_jump
}

/// Neighbours in a standing run are nearly the same pose: of each descent to a minimum only the bottom stays.
fn keep_local_minima(links: &mut Vec<Link>, events: &[Event]) {
    let neighbour = |a: &Link, b: &Link| {
        events[a.event].standing_run.is_some() && events[a.event].standing_run == events[b.event].standing_run
    };
    let keep: Vec<bool> = (0..links.len())
        .map(|k| {
            let before = k > 0 && neighbour(&links[k - 1], &links[k]) && links[k - 1].error <= links[k].error;
            let after =
                k + 1 < links.len() && neighbour(&links[k], &links[k + 1]) && links[k + 1].error < links[k].error;
            !before && !after
        })
        .collect();
    let mut keep = keep.into_iter();
    links.retain(|_| keep.next().unwrap_or(true));
}

/// Where the motion after an event leads, seen from the event.
pub(super) fn outcomes(events: &[Event], clips: &ClipSet, horizon_s: f64) -> Vec<Planar> {
    let starts = clips.frame_starts();
    let of_event = |e: &Event| {
        let clip = &clips.clips[e.clip];
        let horizon = ((horizon_s * clip.rate_hz).round() as u32).max(1);
        let last = FrameId((e.frame.0 + horizon).min(e.run_end.0 - 1));
        displacement(clips, &starts, e.clip, e.frame, last)
    };
    events.par_iter().map(of_event).collect()
}

/// The planar root of frame `to` as seen from `from`, both of clip `clip`; the heading counts full turns.
pub(super) fn displacement(clips: &ClipSet, starts: &[u32], clip: usize, from: FrameId, to: FrameId) -> Planar {
    let c = &clips.clips[clip];
    let (from, to) = ((from.0 - starts[clip]) as usize, (to.0 - starts[clip]) as usize);
    let (first, mut previous) = (c.planar(from), c.planar(from));
    let mut turned = 0.0;
    for f in from + 1..=to {
        let p = c.planar(f);
        turned += wrap_angle(p.heading - previous.heading);
        previous = p;
    }
    Planar { heading: turned, ..first.to_local(previous) }
}

#[cfg(test)]
mod tests {
    use super::super::events::EventKind;
    use super::*;

    #[test]
    fn only_the_bottom_of_each_descent_stays_within_a_standing_run() {
        let event = |k: u32, standing_run| Event {
            frame: FrameId(k),
            clip: 0,
            kind: EventKind::Standing,
            run: 0,
            standing_run,
            run_end: FrameId(100),
        };
        let events: Vec<Event> = (0..8).map(|k| event(k, if k < 6 { Some(0) } else { Some(1) })).collect();
        let errors = [0.3, 0.2, 0.2, 0.25, 0.1, 0.4, 0.5, 0.6];
        let mut links: Vec<Link> = errors.iter().enumerate().map(|(event, &error)| Link { event, error }).collect();
        keep_local_minima(&mut links, &events);
        assert_eq!(links.iter().map(|l| l.event).collect::<Vec<_>>(), [1, 4, 6]);
    }
}
