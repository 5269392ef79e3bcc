//! Positions of a patch's motion, by frame and by cell, sorted for fast neighbour queries.

use crate::stitch::library::Library;
use throng_core::patch::{KIND_TILE, LinkRecord, NONE, PatchTables, Placement};
use throng_core::planar::wrap_angle;
use throng_geometry::BoundingBox;

/// Roots of all frames of all links of a patch, in its frame; y is the height of the clip's ground.
///
/// Links that play the same motion in the same place share roots, as the overlapping sub-sequences of a block do.
#[derive(Clone, Debug, Default)]
pub(in crate::stitch) struct LinkRoots {
    /// First root of each link (links).
    starts: Vec<u32>,
    /// Number of roots of each link (links).
    counts: Vec<u32>,
    /// The roots.
    pub roots: Vec<Placement>,
    /// Frame row of each root (roots.len()).
    pub rows: Vec<u32>,
    /// Links, sorted by the frames they play: consecutive ones need the same bodies.
    pub play_order: Vec<u32>,
    /// Bounds of the roots of each link (links).
    pub bounds: Vec<BoundingBox>,
    /// Longest step over the ground from one frame to the next (m).
    pub longest_step: f32,
    /// True if links have most of their roots in common.
    pub is_shared: bool,
}

/// Motion in one place: where its frame row 0 would be, in steps; equal for links that share it.
type RootMotion = [i64; 4];

impl LinkRoots {
    /// Computes the roots of all links of a patch.
    pub fn new(patches: &PatchTables, library: &Library<'_>, patch: usize) -> Self {
        let links = patches.links_of(patch);
        let mut order: Vec<(Option<RootMotion>, usize)> =
            links.iter().enumerate().map(|(l, link)| (motion(library, link), l)).collect();
        order.sort_by_key(|&(motion, l)| (motion, links[l].frame, l));
        let mut out = Self {
            starts: vec![0; links.len()],
            counts: links.iter().map(|l| u32::from(l.num_frames) + 1).collect(),
            ..Self::default()
        };
        out.play_order = order.iter().map(|&(_, l)| l as u32).collect();
        let mut before: Option<RootMotion> = None;
        for (motion, l) in order {
            let link = &links[l];
            // The motion continues from the roots of the previous link, or lies within them.
            let shared = match out.rows.last() {
                Some(&last) if motion.is_some() && motion == before && link.frame <= last + 1 => last + 1 - link.frame,
                _ => 0,
            };
            out.starts[l] = out.roots.len() as u32 - shared;
            out.roots.extend(library.link_roots(link).skip(shared as usize));
            out.rows.extend((0..out.counts[l]).skip(shared as usize).map(|k| link.frame + k));
            before = motion;
        }
        let around = |l: usize| BoundingBox::around_points(out.roots_of_link(l).iter().map(|r| r.translation()));
        let longest = |l: usize| {
            out.roots_of_link(l).windows(2).map(|w| (w[1].x - w[0].x).hypot(w[1].z - w[0].z)).fold(0.0, f32::max)
        };
        let bounds = (0..links.len()).map(around).collect();
        let longest_step = (0..links.len()).map(longest).fold(0.0, f32::max);
        let is_shared = 2 * out.roots.len() <= out.counts.iter().map(|&n| n as usize).sum();
        Self { bounds, longest_step, is_shared, ..out }
    }

    /// Number of links.
    pub fn num_links(&self) -> usize {
        self.starts.len()
    }

    /// Roots of one link (num_frames + 1).
    pub fn roots_of_link(&self, link: usize) -> &[Placement] {
        &self.roots[self.root_range(link)]
    }

    /// Frame rows of one link (num_frames + 1).
    pub fn rows_of(&self, link: usize) -> &[u32] {
        &self.rows[self.root_range(link)]
    }

    /// Range of the roots of one link among all.
    pub fn root_range(&self, link: usize) -> std::ops::Range<usize> {
        let first = self.starts[link] as usize;
        first..first + self.counts[link] as usize
    }
}

/// Motion of a link, unless its path is edited.
fn motion(library: &Library<'_>, link: &LinkRecord) -> Option<RootMotion> {
    const STEPS_PER_M: f32 = 1000.0;
    let frames = [link.frame, link.frame + u32::from(link.num_frames)];
    let [first, last] = frames.map(|f| {
        let [x, z, heading] = library.frames[f as usize].planar;
        Placement::new(x, 0.0, z, heading)
    });
    let lies = |end: Placement, at: Placement| {
        let p = end.compose(at.inverse()).with_wrapped_heading();
        [p.x, p.y, p.z, p.heading].map(|v| (v * STEPS_PER_M).round() as i64)
    };
    let (begin, end) = (lies(link.start, first), lies(link.end, last));
    begin.iter().zip(&end).all(|(a, b)| (a - b).abs() <= 1).then_some(begin)
}

/// Spot at which motion of a patch may be left and entered: a cell of a block, a frame of a tile's link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct JoinSpot {
    /// Cell or link.
    pub item: u32,
    /// Frames into the link; [`NONE`] for a cell.
    pub offset: u32,
    /// Root on the ground, hips' height and heading.
    pub at: Placement,
}

/// The spots of a patch by pose group and place.
#[derive(Clone, Debug)]
pub(in crate::stitch) struct JoinSpots {
    /// Index of the first spot of each strip of each group (groups * num_strips + 1).
    starts: Vec<u32>,
    /// Spots by group, then by strip along x, then along z.
    spots: Vec<JoinSpot>,
    /// Number of the lowest strip, and count of strips.
    first_strip: i32,
    num_strips: usize,
    /// Bounds of all spots.
    bounds: BoundingBox,
}

/// Largest distances of two spots at which motion continues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::stitch) struct JoinTolerance {
    /// Distance on the ground (m).
    pub position: f32,
    /// Difference of the hips' height (m).
    pub height: f32,
    /// Heading difference (rad).
    pub heading: f32,
}

impl JoinTolerance {
    /// Relative distance of two placements, 1 at the largest of any of the three; `None` if too far apart.
    pub fn distance(&self, a: Placement, b: Placement) -> Option<f32> {
        let (x, z) = (a.x - b.x, a.z - b.z);
        let on_ground = (x * x + z * z).sqrt() / self.position;
        let height = (a.y - b.y).abs() / self.height;
        // Most are rejected by position, which is cheaper.
        if on_ground > 1.0 || height > 1.0 {
            return None;
        }
        let heading = wrap_angle(a.heading - b.heading).abs() / self.heading;
        (heading <= 1.0).then_some(on_ground * on_ground + height * height + heading * heading)
    }
}

/// Width of the strips that spots are sorted into (m).
const STRIP_M: f32 = 0.1;

/// Number of the strip of a coordinate.
fn strip(x: f32) -> i32 {
    (x / STRIP_M).floor() as i32
}

impl JoinSpots {
    /// Collects the spots of a patch: all cells of a block, and of a tile's links the frames that are at least
    /// `min_frames` from both ends, or a quarter of short links.
    pub fn new(patches: &PatchTables, library: &Library<'_>, paths: &LinkRoots, patch: usize, min_frames: u32) -> Self {
        let mut of_groups: Vec<(u32, JoinSpot)> = Vec::new();
        if patches.patches[patch].kind == KIND_TILE {
            // Interactions are not left midway.
            for (l, link) in patches.links_of(patch).iter().enumerate().filter(|(_, link)| !link.is_for_two()) {
                let frames = u32::from(link.num_frames);
                // Slides cross a tile in a few frames: for short links, a quarter suffices.
                let margin = min_frames.min(frames / 4).max(1);
                for offset in margin..=frames.saturating_sub(margin) {
                    let row = (link.frame + offset) as usize;
                    let root = paths.roots_of_link(l)[offset as usize];
                    let at = Placement { y: root.y + library.frames[row].height, ..root };
                    of_groups.push((library.groups[row], JoinSpot { item: l as u32, offset, at }));
                }
            }
        } else {
            let spot = |(c, cell): (usize, &throng_core::patch::CellRecord)| {
                (cell.group, JoinSpot { item: c as u32, offset: NONE, at: cell.placement })
            };
            of_groups.extend(patches.cells_of(patch).iter().enumerate().map(spot));
        }
        // Excluded frames belong to no group.
        of_groups.retain(|(group, _)| *group != NONE);
        of_groups.sort_unstable_by(|(g, s), (h, t)| {
            let strips = strip(s.at.x).cmp(&strip(t.at.x));
            g.cmp(h).then(strips).then(s.at.z.total_cmp(&t.at.z)).then((s.item, s.offset).cmp(&(t.item, t.offset)))
        });
        let bounds = BoundingBox::around_points(of_groups.iter().map(|(_, s)| s.at.translation()));
        let (first_strip, num_strips) = match of_groups.is_empty() {
            true => (0, 0),
            false => (strip(bounds.min.x), (strip(bounds.max.x) - strip(bounds.min.x)) as usize + 1),
        };
        let groups = of_groups.last().map_or(0, |(g, _)| *g as usize + 1);
        let mut starts = vec![0u32; groups * num_strips + 1];
        for (g, s) in &of_groups {
            starts[*g as usize * num_strips + (strip(s.at.x) - first_strip) as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let spots = of_groups.into_iter().map(|(_, s)| s).collect();
        Self { starts, spots, first_strip, num_strips, bounds }
    }

    /// Spots of a group near a placement, with their relative distance.
    pub fn spots_near(&self, group: u32, at: Placement, near: JoinTolerance) -> impl Iterator<Item = (&JoinSpot, f32)> {
        // A margin against rounding.
        let reach = near.position + 1e-4;
        let around = self.bounds.expanded(reach.max(near.height + 1e-4));
        let first_of_group = group as usize * self.num_strips;
        let is_here = first_of_group + self.num_strips < self.starts.len() && around.contains(at.translation());
        let last = self.num_strips as i32 - 1;
        let [low, high] = [at.x - reach, at.x + reach].map(|x| strip(x) - self.first_strip);
        let strips = if is_here { low.max(0)..high.min(last) + 1 } else { 0..0 };
        strips.flat_map(move |here| {
            let k = first_of_group + here as usize;
            let spots = &self.spots[self.starts[k] as usize..self.starts[k + 1] as usize];
            let first = spots.partition_point(|s| s.at.z < at.z - reach);
            spots[first..]
                .iter()
                .take_while(move |s| s.at.z <= at.z + reach)
                .filter_map(move |s| near.distance(s.at, at).map(|d| (s, d)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::UnitSet;
    use throng_core::Skeleton;
    use throng_core::format::FrameRow;
    use throng_core::patch::{KIND_BLOCK, PatchRecord};

    #[test]
    fn links_that_play_the_same_motion_share_their_roots() {
        let row = |k: usize| FrameRow {
            planar: [0.1 * k as f32, 0.02 * (k * k) as f32, 0.3 * k as f32],
            height: 1.0,
            rotations: [0; throng_core::format::ROTATION_BYTES],
        };
        let frames: Vec<FrameRow> = (0..20).map(row).collect();
        let (units, skeleton, groups) = (UnitSet::default(), Skeleton::default(), [0; 20]);
        let library = Library { frames: &frames, groups: &groups, ..Library::without_motion(&units, &skeleton) };
        let here = Placement::new(1.0, 0.0, -2.0, 0.4);
        let at = |k: u32| {
            let [x, z, heading] = frames[k as usize].planar;
            here.compose(Placement::new(x, 0.0, z, heading))
        };
        let link = |frame: u32, n: u16, shift: f32| {
            let (start, mut end) = (at(frame), at(frame + u32::from(n)));
            end.x += shift;
            LinkRecord { from: 0, to: 0, frame, num_frames: n, tag: 0, start, end }
        };
        let links = [link(4, 6, 0.0), link(2, 5, 0.0), link(4, 3, 0.0), link(4, 3, 0.2), link(15, 3, 0.0)];
        let patch = PatchRecord {
            kind: KIND_BLOCK,
            first_cell: 0,
            num_cells: 0,
            first_link: 0,
            num_links: 5,
            first_edge: 0,
            num_edges: 0,
            reserved: 0,
            min: [0.0; 3],
            max: [0.0; 3],
        };
        let patches = PatchTables {
            patches: (&[patch]).into(),
            edges: [].as_slice().into(),
            cells: [].as_slice().into(),
            links: (&links).into(),
            pairs: [].as_slice().into(),
        };
        let paths = LinkRoots::new(&patches, &library, 0);
        // Frames 2 to 10 and 15 to 18 once, and the edited link's own four.
        assert_eq!(paths.roots.len(), 9 + 4 + 4);
        for (l, link) in links.iter().enumerate() {
            let expected: Vec<Placement> = library.link_roots(link).collect();
            assert_eq!(paths.roots_of_link(l).len(), expected.len());
            for (k, (a, b)) in paths.roots_of_link(l).iter().zip(&expected).enumerate() {
                assert!((a.translation() - b.translation()).length() < 0.003 && (a.heading - b.heading).abs() < 0.003);
                assert_eq!(paths.rows[paths.root_range(l).start + k], link.frame + k as u32);
            }
        }
    }
}
