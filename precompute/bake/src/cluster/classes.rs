//! Classes of frames that may share a group as far as contacts go.

use std::collections::BTreeMap;
use throng_motion::clip::ClipSet;

/// Contact states of a frame with its neighbours: previous, this, next.
pub(super) type ContactStates = [u8; 3];

/// Usable frames by contact states, ascending.
///
/// At the ends of a run of usable frames, the frame itself stands in for the missing neighbour, as for velocities.
pub(super) fn classes_of_contacts(clips: &ClipSet) -> BTreeMap<ContactStates, Vec<u32>> {
    let mut classes = BTreeMap::<_, Vec<u32>>::new();
    for (clip, start) in clips.clips.iter().zip(clips.frame_starts()) {
        for run in clip.usable_ranges() {
            for f in run.clone() {
                let neighbours = [f.max(run.start + 1) - 1, f, (f + 1).min(run.end - 1)];
                classes.entry(neighbours.map(|f| clip.contacts[f].0)).or_default().push(start + f as u32);
            }
        }
    }
    classes
}
