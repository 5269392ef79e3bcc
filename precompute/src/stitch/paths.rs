//! Where motion of a patch is, frame by frame and cell by cell, so that what is near is found without a search.

use super::library::Library;
use throng_runtime::patch::{KIND_TILE, NONE, Patches, Placement};
use throng_runtime::planar::wrap_angle;

/// Roots of all frames of all links of a patch, in its frame; y is the height of the clip's ground.
#[derive(Clone, Debug, Default)]
pub(super) struct Paths {
    /// First root of each link. [Size: links + 1]
    pub starts: Vec<u32>,
    /// The roots.
    pub roots: Vec<Placement>,
}

impl Paths {
    /// Follows all links of a patch.
    pub fn new(patches: &Patches<'_>, library: &Library<'_>, patch: usize) -> Self {
        let links = patches.links_of(patch);
        let total: usize = links.iter().map(|l| usize::from(l.num_frames) + 1).sum();
        let (mut starts, mut roots) = (Vec::with_capacity(links.len() + 1), Vec::with_capacity(total));
        for link in links {
            starts.push(roots.len() as u32);
            roots.extend(library.link_roots(link));
        }
        starts.push(roots.len() as u32);
        Self { starts, roots }
    }

    /// Roots of one link. [Size: num_frames + 1]
    pub fn of(&self, link: usize) -> &[Placement] {
        &self.roots[self.starts[link] as usize..self.starts[link + 1] as usize]
    }
}

/// Where motion of a patch may be left and entered: a cell of a block, a frame of a tile's link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    /// Cell or link.
    pub item: u32,
    /// Frames into the link; [`NONE`] for a cell.
    pub offset: u32,
    /// Root on the ground, hips' height and heading.
    pub at: Placement,
}

/// The spots of a patch by pose group and place.
#[derive(Clone, Debug, Default)]
pub(super) struct Spots {
    /// First spot of each group. [Size: groups + 1]
    starts: Vec<u32>,
    /// By group, then along x.
    spots: Vec<Spot>,
}

/// How near two spots are for motion to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Nearness {
    /// On the ground. [Unit: m]
    pub position: f32,
    /// Of the hips' height. [Unit: m]
    pub height: f32,
    /// [Unit: rad]
    pub heading: f32,
}

impl Nearness {
    /// How far apart two places are, 1 being the farthest for each of the three; none where they are too far apart.
    pub fn distance(&self, a: Placement, b: Placement) -> Option<f32> {
        let (x, z) = (a.x - b.x, a.z - b.z);
        let on_ground = (x * x + z * z).sqrt() / self.position;
        let height = (a.y - b.y).abs() / self.height;
        let heading = wrap_angle(a.heading - b.heading).abs() / self.heading;
        let near = on_ground <= 1.0 && height <= 1.0 && heading <= 1.0;
        near.then_some(on_ground * on_ground + height * height + heading * heading)
    }
}

impl Spots {
    /// Collects the spots of a patch: all cells of a block, and of a tile's links the frames that are at least
    /// `min_frames` from both ends.
    pub fn new(patches: &Patches<'_>, library: &Library<'_>, paths: &Paths, patch: usize, min_frames: u32) -> Self {
        let mut of_groups: Vec<(u32, Spot)> = Vec::new();
        if patches.patches[patch].kind == KIND_TILE {
            for (l, link) in patches.links_of(patch).iter().enumerate() {
                let last = u32::from(link.num_frames).saturating_sub(min_frames);
                for offset in min_frames..=last {
                    let row = (link.frame + offset) as usize;
                    let root = paths.of(l)[offset as usize];
                    let at = Placement { y: root.y + library.frames[row].height, ..root };
                    of_groups.push((library.groups[row], Spot { item: l as u32, offset, at }));
                }
            }
        } else {
            let spot = |(c, cell): (usize, &throng_runtime::patch::CellRecord)| {
                (cell.group, Spot { item: c as u32, offset: NONE, at: cell.placement })
            };
            of_groups.extend(patches.cells_of(patch).iter().enumerate().map(spot));
        }
        // Frames that are left out of the motion belong to no group.
        of_groups.retain(|(group, _)| *group != NONE);
        of_groups.sort_unstable_by(|(g, s), (h, t)| {
            g.cmp(h).then(s.at.x.total_cmp(&t.at.x)).then((s.item, s.offset).cmp(&(t.item, t.offset)))
        });
        let groups = of_groups.last().map_or(0, |(g, _)| *g + 1);
        let mut starts = vec![0u32; groups as usize + 1];
        for (g, _) in &of_groups {
            starts[*g as usize + 1] += 1;
        }
        for g in 0..groups as usize {
            starts[g + 1] += starts[g];
        }
        Self { starts, spots: of_groups.into_iter().map(|(_, s)| s).collect() }
    }

    /// Spots of a group that are near a place, and how far they are.
    pub fn near(&self, group: u32, at: Placement, nearness: Nearness) -> impl Iterator<Item = (&Spot, f32)> {
        let range = match self.starts.get(group as usize..group as usize + 2) {
            Some(&[first, end]) => first as usize..end as usize,
            _ => 0..0,
        };
        let spots = &self.spots[range];
        let first = spots.partition_point(|s| s.at.x < at.x - nearness.position);
        spots[first..]
            .iter()
            .take_while(move |s| s.at.x <= at.x + nearness.position)
            .filter_map(move |s| nearness.distance(s.at, at).map(|d| (s, d)))
    }
}
