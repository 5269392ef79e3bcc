//! What of a patch's motion a unit is in the way of, for every way in which the unit may stand to the patch.

use super::bodies::{Bodies, beside};
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
pub(super) fn hits(paths: &Paths, bodies: &Bodies, unit: &Field, unit_at: Placement, depth_m: f32) -> Vec<Hit> {
    let shapes = &unit.geometry.bounds;
    if shapes.is_empty() {
        return Vec::new();
    }
    let (sin, cos) = unit_at.heading.sin_cos();
    let in_unit = |p: &Placement| {
        let (x, z) = (p.x - unit_at.x, p.z - unit_at.z);
        Placement::new(cos * x - sin * z, p.y - unit_at.y, sin * x + cos * z, p.heading - unit_at.heading)
    };
    // Links of blocks share roots: each is looked at once.
    let mut known: Vec<Option<bool>> = vec![None; if paths.is_shared() { paths.roots().len() } else { 0 }];
    let mut look = |at: usize| {
        let root = in_unit(&paths.roots()[at]);
        let way = beside(shapes, root) - bodies.radius();
        if way > 0.0 {
            return Some((way / paths.step().max(1e-3)) as usize);
        }
        let collides = || bodies.collides(paths.rows()[at] as usize, root, unit, depth_m);
        let hit = known.get_mut(at).map_or_else(collides, |k| *k.get_or_insert_with(collides));
        (!hit).then_some(0)
    };
    let near = bodies.around(&shapes.placed(unit_at));
    (0..paths.num_links())
        .filter(|&l| near.overlaps(paths.bounds(l)))
        .filter_map(|l| {
            let range = paths.range(l);
            of_link(l as u32, range.len(), |k| look(range.start + k))
        })
        .collect()
}

/// Number of frames of a link that are looked at. [Limit: num_frames > 0]
fn num_looks(num_frames: usize) -> usize {
    (num_frames - 1).div_ceil(STRIDE) + 1
}

/// The frames of a link that are looked at; the last one in any case. [Limit: num_frames > 0]
pub(super) fn looked_at(num_frames: usize) -> impl Iterator<Item = usize> {
    (0..num_looks(num_frames)).map(move |i| (i * STRIDE).min(num_frames - 1))
}

/// First and last frame of a link that collide: from both ends, so that what lies between is not looked at.
///
/// - `look`: none where a frame collides, else how many frames before and after it do not either.
fn of_link(link: u32, num_frames: usize, mut look: impl FnMut(usize) -> Option<usize>) -> Option<Hit> {
    let count = num_looks(num_frames);
    let frame = |i: usize| (i * STRIDE).min(num_frames - 1);
    let mut first = 0;
    while let Some(clear) = look(frame(first)) {
        first += (clear / STRIDE).max(1);
        if first >= count {
            return None;
        }
    }
    let mut last = count - 1;
    while last > first {
        let Some(clear) = look(frame(last)) else { break };
        last = last.saturating_sub((clear / STRIDE).max(1)).max(first);
    }
    Some(Hit { link, first: frame(first) as u16, last: frame(last) as u16 })
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
        let clear = |frames: &[usize], k: usize| {
            frames.iter().map(|&f| f.abs_diff(k)).min().map_or(99, |d| d.saturating_sub(1))
        };
        let hit = |frames: &[usize]| of_link(3, 30, |k| (!frames.contains(&k)).then(|| clear(frames, k)));
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
