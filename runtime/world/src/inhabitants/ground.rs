//! Those who do not live in the world: their ground is not entered, and that of inhabitants is told.

use super::Inhabitants;
use super::decide::needs;
use crate::WorldGraph;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_base::ground::{BoxGrid, Held, Outsider, Rod};

/// Radius of an inhabitant's disc, as others see it (m).
const BODY_RADIUS_M: f32 = throng_core::stops::BODY_RADIUS_M;

/// Where instances are on the ground.
#[derive(Clone, Debug)]
pub(super) struct Grounds {
    rods: Vec<Rod>,
    grid: BoxGrid,
}

impl Grounds {
    fn new(graph: &WorldGraph) -> Self {
        let rods: Vec<Rod> = (0..graph.num_instances() as u32).map(|i| ground(graph, i)).collect();
        let mut grid = BoxGrid::with_capacity(rods.len());
        rods.iter().enumerate().for_each(|(i, rod)| grid.set(i, rod.bounds()));
        Self { rods, grid }
    }
}

/// All that bodies reach in an instance, over the ground.
fn ground(graph: &WorldGraph, instance: u32) -> Rod {
    let placement = graph.instance(instance).placement;
    let [min, max] = graph.reach(instance);
    let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let along = if half.x > half.z { Vec3::X * half.x } else { Vec3::Z * half.z };
    let place = |at: Vec3| {
        let at = placement.transform_point(at);
        Vec2::new(at.x, at.z)
    };
    Rod { from: place(middle - along), to: place(middle + along), radius_m: half.x.min(half.z) }
}

impl Inhabitants {
    /// Those who do not live here: nobody takes units on ground that they hold. Who holds such units already keeps them
    /// until it has left them.
    pub fn mind<'a>(&mut self, others: impl Iterator<Item = &'a Held>) {
        let graph = self.world.graph();
        let grounds = self.grounds.get_or_insert_with(|| Arc::new(Grounds::new(graph)));
        self.reservations.open_all();
        for held in others.flat_map(|h| &h.ground) {
            grounds.grid.near(&held.bounds(), |instance| {
                if grounds.rods[instance].meets(held) {
                    self.reservations.bar(graph.resources(instance as u32));
                }
                true
            });
        }
    }

    /// Adds all bodies, and the ground of the instances that they need for what they do until they may rest.
    pub fn hold_ground(&mut self, out: &mut Held) {
        let graph = self.world.graph();
        let grounds = self.grounds.get_or_insert_with(|| Arc::new(Grounds::new(graph)));
        for (c, root) in self.roots.iter().enumerate() {
            let place = Vec2::new(root.x, root.z);
            out.bodies.push(Outsider { place, velocity: Vec2::ZERO, radius_m: BODY_RADIUS_M });
            let first = out.ground.len();
            needs(graph, &self.states[c], self.chains.of(c), |instance| {
                let rod = grounds.rods[instance as usize];
                if !out.ground[first..].contains(&rod) {
                    out.ground.push(rod);
                }
            });
        }
    }
}
