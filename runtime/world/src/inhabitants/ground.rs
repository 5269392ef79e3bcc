//! External obstacles: inhabitants do not enter their regions, and report the regions that they reserve themselves.

use super::{Inhabitants, reservations::InstanceGround};
use crate::WorldGraph;
use glam::{Vec2, Vec3};
use std::sync::Arc;
use throng_base::ground::{ExternalObstacle, ReservedRegion};
use throng_geometry::{BoxGrid, Capsule2d};

/// Radius of an inhabitant's disc, as others see it (m).
const BODY_RADIUS_M: f32 = throng_core::stops::BODY_RADIUS_M;

/// Capsules of the instances, over the ground.
#[derive(Clone, Debug)]
pub(super) struct InstanceCapsules {
    capsules: Vec<Capsule2d>,
    grid: BoxGrid,
}

impl InstanceCapsules {
    fn new(graph: &WorldGraph) -> Self {
        let capsules: Vec<Capsule2d> = (0..graph.num_instances() as u32).map(|i| instance_capsule(graph, i)).collect();
        let mut grid = BoxGrid::with_capacity(capsules.len());
        capsules.iter().enumerate().for_each(|(i, capsule)| grid.set(i, capsule.bounds()));
        Self { capsules, grid }
    }
}

/// Capsule around the reach of all bodies in an instance, over the ground.
fn instance_capsule(graph: &WorldGraph, instance: u32) -> Capsule2d {
    let placement = graph.instance(instance).placement;
    let [min, max] = graph.reach_bounds(instance);
    let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
    let along = if half.x > half.z { Vec3::X * half.x } else { Vec3::Z * half.z };
    let place = |at: Vec3| {
        let at = placement.transform_point(at);
        Vec2::new(at.x, at.z)
    };
    Capsule2d { from: place(middle - along), to: place(middle + along), radius_m: half.x.min(half.z) }
}

impl Inhabitants {
    /// Sets the external obstacles: no character enters an instance on a region that they reserve. A character that
    /// needs such an instance already goes on, as [`Inhabitants::add_reserved_regions`] has reported.
    pub fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
        let graph = self.world.graph();
        let grounds = self.grounds.get_or_insert_with(|| Arc::new(InstanceCapsules::new(graph)));
        self.reservations.ground_mut().fill(InstanceGround::Free);
        for held in others.flat_map(|h| &h.ground) {
            grounds.grid.visit_intersecting(&held.bounds(), |instance| {
                if grounds.capsules[instance].intersects(held) {
                    self.reservations.ground_mut()[instance] = InstanceGround::Barred;
                }
                true
            });
        }
        for (c, state) in self.states.iter().enumerate() {
            state.visit_needed_instances(graph, self.chains.steps_of(c), |instance| {
                let ground = &mut self.reservations.ground_mut()[instance as usize];
                if *ground == InstanceGround::Barred {
                    *ground = InstanceGround::Shared;
                }
            });
        }
    }

    /// Adds all bodies, and the ground of the instances that they need for what they do until they may rest.
    pub fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        let graph = self.world.graph();
        let grounds = self.grounds.get_or_insert_with(|| Arc::new(InstanceCapsules::new(graph)));
        for (c, root) in self.roots.iter().enumerate() {
            let place = Vec2::new(root.x, root.z);
            out.bodies.push(ExternalObstacle { place, velocity: Vec2::ZERO, radius_m: BODY_RADIUS_M });
            let first = out.ground.len();
            self.states[c].visit_needed_instances(graph, self.chains.steps_of(c), |instance| {
                let capsule = grounds.capsules[instance as usize];
                if !out.ground[first..].contains(&capsule) {
                    out.ground.push(capsule);
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inhabitants::{InhabitantGoal, InhabitantsConfig};
    use crate::made_up_floor::{SIDE, tables, world};
    use crate::{World, WorldNode};
    use throng_base::{Error, Inline};
    use throng_core::{CharacterGroup, OrderStatus, Planar};

    const DT: f32 = 1.0 / 30.0;

    /// Row of tiles, some of which share the unit of the first one, with an inhabitant on the first one.
    fn row(sharing: &[u32]) -> (World, Inhabitants, [WorldNode; 4]) {
        let tables = tables();
        let mut data = world(&tables, &["####"]);
        let tile_at = |x: u32| {
            let is_there = |i: &crate::InstanceRecord| i.placement.x == x as f32 * SIDE;
            data.instances.iter().position(is_there).unwrap()
        };
        let tiles = [0, 1, 2, 3].map(tile_at);
        let unit = data.resources[data.instances[tiles[0]].first_resource as usize];
        for &x in sharing {
            let resource = data.instances[tiles[x as usize]].first_resource;
            data.resources[resource as usize] = unit;
        }
        let world = World::from_data(&data, &tables).unwrap();
        let mut people = Inhabitants::new(&world, 2, InhabitantsConfig::default()).unwrap();
        let rests = tiles.map(|t| world.graph().rest_cells(t as u32).next().unwrap());
        people.spawn(rests[0]).unwrap();
        (world, people, rests)
    }

    /// An external obstacle that stands on a tile.
    fn standing_on(x: u32) -> [ReservedRegion; 1] {
        let at = Vec2::new(x as f32 * SIDE, 0.0);
        [ReservedRegion { bodies: Vec::new(), ground: vec![Capsule2d { from: at, to: at, radius_m: 0.3 }] }]
    }

    #[test]
    fn who_holds_a_unit_that_places_share_does_not_enter_the_ground_of_others() {
        for sharing in [&[][..], &[1], &[1, 2]] {
            let (_, mut people, rests) = row(sharing);
            let id = people.ids()[0];
            let others = standing_on(1);
            people.set_external_obstacles(others.iter());
            let refused = people.place(id, Planar::new(SIDE, 0.0, 0.0));
            assert!(matches!(refused, Err(Error::Occupied { .. })), "{refused:?}");
            people.order(id, InhabitantGoal::GoTo { instance: rests[3].instance }).unwrap();
            let mut was_blocked = false;
            for step in 0..600 {
                people.set_external_obstacles(others.iter());
                people.step(DT, &Inline).unwrap();
                let x = people.roots[0].x;
                assert!(!(0.55 * SIDE..1.45 * SIDE).contains(&x), "at {x} m after {step} steps, {sharing:?}");
                // The obstacle has no id here.
                was_blocked |= matches!(people.status(id), Ok(OrderStatus::Blocked { by: None }));
            }
            assert!(was_blocked);
            // An obstacle that is gone blocks no inhabitant.
            (0..3000).for_each(|_| {
                people.set_external_obstacles([].iter());
                people.step(DT, &Inline).unwrap();
            });
            assert!(matches!(people.status(id), Ok(OrderStatus::Arrived)), "{:?}", people.status(id));
        }
    }

    #[test]
    fn who_is_on_ground_that_somebody_comes_to_leaves_it() {
        let (_, mut people, rests) = row(&[1]);
        let id = people.ids()[0];
        let others = standing_on(0);
        people.order(id, InhabitantGoal::GoTo { instance: rests[3].instance }).unwrap();
        for _ in 0..1500 {
            people.set_external_obstacles(others.iter());
            people.step(DT, &Inline).unwrap();
        }
        assert!(matches!(people.status(id), Ok(OrderStatus::Arrived)), "{:?}", people.status(id));
    }

    #[test]
    fn going_back_does_not_forget_others() {
        let (_, mut people, _) = row(&[]);
        let id = people.ids()[0];
        let mut kept = Vec::new();
        people.save(&mut kept);
        people.set_external_obstacles(standing_on(2).iter());
        for _ in 0..2 {
            let put = |x: f32| people.clone().place(id, Planar::new(x * SIDE, 0.0, 0.0));
            assert!(matches!(put(2.0), Err(Error::Occupied { .. })), "{:?}", put(2.0));
            assert!(put(3.0).is_ok());
            people.load(&kept).unwrap();
        }
    }
}
