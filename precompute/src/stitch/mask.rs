//! What of a patch's motion a unit is in the way of, for every way in which the unit may stand to the patch.

use super::bodies::Bodies;
use super::field::Field;
use super::paths::Paths;
use throng_runtime::patch::Placement;

/// Of a walk at 30 Hz every second frame is looked at: a hand moves some centimetres between them.
const STRIDE: usize = 2;

/// A link on whose way a unit stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hit {
    /// The link.
    pub link: u32,
    /// First frame of it at which the body is in the unit.
    pub first: u16,
    /// Last such frame.
    pub last: u16,
}

/// All links of a patch that collide with a unit which stands at `unit_at` in its frame, ascending.
///
/// - `depth_m`: bodies may be that deep in the unit.
pub(super) fn hits(paths: &Paths, num_links: usize, bodies: &Bodies, unit: &Field, unit_at: Placement, depth_m: f32) -> Vec<Hit> {
    let (sin, cos) = unit_at.heading.sin_cos();
    let in_unit = |p: &Placement| {
        let (x, z) = (p.x - unit_at.x, p.z - unit_at.z);
        Placement::new(cos * x - sin * z, p.y - unit_at.y, sin * x + cos * z, p.heading - unit_at.heading)
    };
    // Links share roots: each is looked at once.
    let mut known: Vec<Option<bool>> = vec![None; paths.roots().len()];
    let mut collides = |at: usize| {
        *known[at].get_or_insert_with(|| {
            bodies.collides(paths.rows()[at] as usize, in_unit(&paths.roots()[at]), unit, depth_m)
        })
    };
    (0..num_links as u32)
        .filter_map(|l| {
            let range = paths.range(l as usize);
            of_link(l, range.len(), |k| collides(range.start + k))
        })
        .collect()
}

/// The frames of a link that are looked at; the last one in any case. [Limit: num_frames > 0]
pub(super) fn looked_at(num_frames: usize) -> impl DoubleEndedIterator<Item = usize> {
    (0..num_frames - 1).step_by(STRIDE).chain([num_frames - 1])
}

/// First and last frame of a link that collide: from both ends, so that what lies between is not looked at.
fn of_link(link: u32, num_frames: usize, mut collides: impl FnMut(usize) -> bool) -> Option<Hit> {
    let first = looked_at(num_frames).find(|&k| collides(k))?;
    let last = looked_at(num_frames).rev().find(|&k| k <= first || collides(k)).unwrap_or(first);
    Some(Hit { link, first: first as u16, last: last as u16 })
}

/// First and last colliding frame of every link of an instance over all that is in its way.
///
/// - `masks`: the hits of each obstacle, ascending by link.
/// - returns hits ascending by link, one for each.
pub(super) fn merged<'m>(masks: impl Iterator<Item = &'m [Hit]>) -> Vec<Hit> {
    let mut all: Vec<Hit> = masks.flatten().copied().collect();
    all.sort_unstable_by_key(|h| (h.link, h.first, h.last));
    all.dedup_by(|next, kept| {
        let same = next.link == kept.link;
        if same {
            kept.last = kept.last.max(next.last);
        }
        same
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_collision_of_a_link_are_found() {
        let hit = |frames: &[usize]| of_link(3, 30, |k| frames.contains(&k));
        assert_eq!(hit(&[]), None);
        assert_eq!(hit(&[4, 6, 20]), Some(Hit { link: 3, first: 4, last: 20 }));
        assert_eq!(hit(&[29]), Some(Hit { link: 3, first: 29, last: 29 }));
        assert_eq!(hit(&[8]), Some(Hit { link: 3, first: 8, last: 8 }));
    }

    #[test]
    fn obstacles_are_put_together() {
        let h = |link, first, last| Hit { link, first, last };
        let (a, b) = ([h(1, 5, 9), h(4, 0, 2)], [h(0, 1, 1), h(1, 2, 3)]);
        assert_eq!(merged([&a[..], &b[..]].into_iter()), [h(0, 1, 1), h(1, 2, 9), h(4, 0, 2)]);
    }
}
