//! Puts characters back into a world that has changed under them.

use glam::Vec3;
use throng_world::{WorldGraph, WorldNode};

/// For each character, the nearest rest node that shares no unit with the nodes of earlier characters.
///
/// - `places`: where they are (m).
/// - returns each one's number with its node; characters without a place are left out.
pub(super) fn place_inhabitants(graph: &WorldGraph, places: &[Vec3]) -> Vec<(usize, WorldNode)> {
    let mut taken = vec![false; graph.world().units.len()];
    let mut put = |(character, &place): (usize, &Vec3)| {
        let node = nearest(graph, place, &taken)?;
        graph.resources(node.instance).iter().for_each(|&u| taken[u as usize] = true);
        Some((character, node))
    };
    places.iter().enumerate().filter_map(&mut put).collect()
}

fn nearest(graph: &WorldGraph, place: Vec3, taken: &[bool]) -> Option<WorldNode> {
    let mut best: (f32, Option<WorldNode>) = (f32::INFINITY, None);
    for instance in 0..graph.num_instances() as u32 {
        if graph.resources(instance).iter().any(|&u| taken[u as usize]) {
            continue;
        }
        let record = graph.instance(instance);
        let patch = &graph.patches().patches[record.patch as usize];
        let local = record.placement.inverse_transform_point(place);
        let inside = local.clamp(Vec3::from_array(patch.min), Vec3::from_array(patch.max));
        // All cells lie in the patch's bounds.
        if local.distance_squared(inside) >= best.0 {
            continue;
        }
        for node in graph.rest_cells(instance) {
            let far = graph.place(node).translation().distance_squared(place);
            if far < best.0 {
                best = (far, Some(node));
            }
        }
    }
    best.1
}
