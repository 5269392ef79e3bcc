//! Joint tables: places at which motion of one patch may continue as motion of another in a given relative placement
//! (Lee, Choi and Lee 2006, section 5).

use crate::stitch::place::paths::{JoinSpots, JoinTolerance};
use crate::{stitch::config::StitchConfig, stitch::place::relation::RelativePlacement};
use rayon::prelude::*;
use throng_core::patch::{PatchTables, Placement};
use throng_geometry::BoundingBox;
use throng_world::JointRecord;

/// Joints of all pairs of instances in one relation, indexed from either side.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::stitch) struct JointTable {
    /// Joints, sorted by (a, a_offset, b).
    pub joints: Vec<JointRecord>,
    /// Numbers of the joints, sorted by (b, a, a_offset).
    pub by_b: Vec<u32>,
    /// True if motion of b takes place on the panel of tile a: characters in b obstruct those on a.
    pub shares_floor: bool,
}

/// Cells of side b that are processed together.
const CELLS: usize = 32;

impl JointTable {
    /// Finds the joints between patch `relation.a`, whose spots are given, and the block `relation.b`.
    ///
    /// Takes the nearest of a link's frames near a cell, and the nearest ones of all joints of a cell of b.
    ///
    /// - `floor`: the panel, if a is a tile.
    pub fn new(
        patches: &PatchTables,
        spots: &JoinSpots,
        floor: Option<&BoundingBox>,
        relation: &RelativePlacement,
        config: &StitchConfig,
    ) -> Self {
        let (b, at, most) = (relation.b as usize, relation.placement(), config.joints_per_cell);
        let (position, height, heading) = (config.position_m, config.height_m, config.heading_deg.to_radians());
        let tolerance = JoinTolerance { position, height, heading };
        let cells = patches.cells_of(b);
        let nearer = |p: &NearSpot, q: &NearSpot| p.distance.total_cmp(&q.distance);
        let of_cells = |numbers: &[u32]| {
            let (mut joints, mut near) = (Vec::new(), Vec::new());
            for &c in numbers {
                // Nearest spots of side a, one an item, in no order.
                let cell = &cells[c as usize];
                near.clear();
                let found = spots.spots_near(cell.group, at.compose(cell.placement), tolerance);
                near.extend(found.map(|(s, distance)| NearSpot { item: s.item, offset: s.offset, distance }));
                near.sort_unstable_by(|p, q| p.item.cmp(&q.item).then(nearer(p, q)).then(p.offset.cmp(&q.offset)));
                near.dedup_by_key(|n| n.item);
                if near.len() > most {
                    near.select_nth_unstable_by(most, |p, q| nearer(p, q).then(p.item.cmp(&q.item)));
                    near.truncate(most);
                }
                let joint = |n: &NearSpot| JointRecord { a: n.item, a_offset: n.offset, b: c, reserved: 0 };
                joints.extend(near.iter().map(joint));
            }
            joints
        };
        // Cells of one group are processed together, so that its spots stay in the processor's cache.
        let mut order: Vec<u32> = (0..cells.len() as u32).collect();
        order.sort_unstable_by_key(|&c| (cells[c as usize].group, c));
        let mut joints: Vec<JointRecord> = order.par_chunks(CELLS).flat_map_iter(of_cells).collect();
        joints.sort_unstable();
        let mut by_b: Vec<u32> = (0..joints.len() as u32).collect();
        by_b.sort_by_key(|&j| joints[j as usize].b);
        let on_floor = |f: &BoundingBox| patches.cells_of(b).iter().any(|c| stands_on(f, at.compose(c.placement)));
        Self { joints, by_b, shares_floor: floor.is_some_and(on_floor) }
    }
}

/// True for hips above a panel and near enough for feet or a seat on it. Within a hand's width of its edge the
/// neighbour is responsible: on tiles, roots keep away from edges that are not crossed.
fn stands_on(floor: &BoundingBox, hips: Placement) -> bool {
    const BESIDE_M: f32 = -0.05;
    const HIPS_M: [f32; 2] = [0.2, 1.3];
    let (low, high) = (floor.min - BESIDE_M, floor.max + BESIDE_M);
    let above = low.x <= hips.x && hips.x <= high.x && low.z <= hips.z && hips.z <= high.z;
    above && floor.min.y + HIPS_M[0] <= hips.y && hips.y <= floor.max.y + HIPS_M[1]
}

/// A spot of side a that is near a cell of side b.
#[derive(Clone, Copy, Debug)]
struct NearSpot {
    item: u32,
    offset: u32,
    distance: f32,
}
