//! Leaps: from a cell of a district to where its fastest ways out end, in place of all steps between (their costs are
//! known beforehand).

use crate::patch::NONE;
use crate::world::atlas::{Atlas, Beyond};
use crate::world::{Node, Step, WorldGraph};

/// Most steps of a leap.
const MAX_STEPS: usize = 1024;

/// Calls `visit` with one step that plays no link for each way out of a district.
pub(super) fn for_each(graph: &WorldGraph<'_>, atlas: &Atlas, district: u32, cell: u32, mut visit: impl FnMut(Step)) {
    for out in atlas.outs_of(district) {
        if let Some((to, to_offset)) = atlas.leap(graph, out, cell) {
            visit(Step { to, to_offset, ..Step::NONE });
        }
    }
}

/// Calls `add` with the steps that a leap stands for.
///
/// - returns none where they are not there; the world is not what its tables say.
pub(super) fn walk(
    graph: &WorldGraph<'_>,
    atlas: &Atlas,
    from: Node,
    leap: &Step,
    mut add: impl FnMut(Step),
) -> Option<()> {
    let (district, first) = atlas.district(from.instance)?;
    let same = |out: &u32| atlas.leap(graph, *out, first + from.cell) == Some((leap.to, leap.to_offset));
    let out = atlas.outs_of(district).find(same)?;
    let (shape, number) = (atlas.shape(district), out - atlas.outs_of(district).start);
    let way = match atlas.outs[out as usize].beyond {
        Beyond::Tile(tile) => atlas.regions.way(tile, leap.to.instance),
        Beyond::District(d) => [atlas.districts.number(d, leap.to.instance) as i32, 0],
    };
    let handicap = shape.handicap(number, way, leap.to.cell)?;
    let mut node = from;
    for _ in 0..MAX_STEPS {
        let (mut best, mut least) = (None, f32::INFINITY);
        graph.for_each_step(node, |step| {
            let left = match atlas.district(step.to.instance) {
                Some((d, first)) if d == district => shape.to_out(number, first + step.to.cell),
                _ if step.to == leap.to => f32::from(handicap),
                _ => f32::INFINITY,
            };
            let total = left + step.num_frames() as f32;
            if total < least {
                (best, least) = (Some(step), total);
            }
        });
        let step = best?;
        debug_assert!(step.link != NONE);
        add(step);
        if step.to == leap.to {
            return Some(());
        }
        node = step.to;
    }
    None
}
