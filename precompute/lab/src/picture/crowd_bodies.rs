//! The picture of a crowd with bodies.

use super::canvas::Picture;
use super::discs::{SOLID, WIDTH, group_colour};
use super::figure::{BodyColours, Figure};
use super::world::{WorldFigure, WorldLook, WorldView, world_sheet};
use crate::run::{AgentsRecord, Pose, SeenObstacle};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use throng_runtime::Joint;

/// Width of the picture of bodies (m).
const BODIES_M: f32 = 24.0;
/// Draws the bodies of a crowd at the end of its run.
///
/// - `poses`: world positions of all joints of each agent, `None` where one has left (m).
pub(super) fn bodies_sheet(record: &AgentsRecord, poses: &[Option<Pose>]) -> Picture {
    let one = |(m, p): (usize, &Option<Pose>)| {
        let tint = group_colour(record.groups.get(m).copied().unwrap_or(0));
        Some(WorldFigure { figure: Figure::from_positions(p.as_ref()?), colours: BodyColours::plain(tint) })
    };
    let figures: Vec<WorldFigure> = poses.iter().enumerate().filter_map(one).collect();
    let lines = |o: &SeenObstacle| match o {
        SeenObstacle::Wall { from, to, .. } => Some(vec![*from, *to]),
        SeenObstacle::Polygon(corners) => Some(corners.iter().chain(corners.first()).copied().collect()),
        SeenObstacle::Ball { centre, radius } => Some(circle(*centre, *radius)),
        _ => None,
    };
    let trails: Vec<_> = record.obstacles.iter().filter_map(lines).map(|l| (l, SOLID)).collect();
    let places: Vec<Vec3> = figures.iter().map(|f| f.figure.joint(Joint::Hips)).collect();
    let focus = most_crowded(&places).map(|at| (at, BODIES_M));
    world_sheet(&WorldView {
        title: "Bodies",
        subtitle: "blended from example motions, where the agents are at the end",
        size: (WIDTH as u32, 900),
        figures: &figures,
        units: &[],
        trails: &trails,
        names: &[],
        look: WorldLook { heading: 0.8 * PI, elevation: 0.6, focus },
    })
}

/// The middle of those around the one who has the most others near; of a few at least, where there are many.
fn most_crowded(places: &[Vec3]) -> Option<Vec3> {
    const NEAR_M: f32 = 0.4 * BODIES_M;
    const LOOKED_AT: usize = 200;
    let near = |at: Vec3| places.iter().filter(move |p| p.distance_squared(at) < NEAR_M * NEAR_M);
    let some = places.iter().step_by(places.len().div_ceil(LOOKED_AT).max(1));
    let at = some.max_by_key(|at| near(**at).count())?;
    Some(near(*at).sum::<Vec3>() / near(*at).count() as f32)
}

/// A circle on the ground.
fn circle(centre: Vec3, radius: f32) -> Vec<Vec3> {
    let at = |i: u8| Vec2::from_angle(TAU * f32::from(i) / 40.0) * radius;
    (0..=40).map(|i| centre + Vec3::new(at(i).x, 0.0, at(i).y)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_runtime::Skeleton;

    #[test]
    fn bodies_and_outlines_are_drawn_and_an_empty_crowd_is_no_panic() {
        let record = AgentsRecord {
            groups: vec![0, 1],
            doors: Vec::new(),
            places: Vec::new(),
            obstacles: vec![SeenObstacle::Ball { centre: Vec3::X, radius: 1.0 }],
            ..AgentsRecord::default()
        };
        let pose = Skeleton::default().rest_positions();
        let one = bodies_sheet(&record, &[Some(pose), None]);
        assert_ne!(one, bodies_sheet(&record, &[None, None]));
        assert_eq!(one, bodies_sheet(&record, &[Some(pose), None]));
    }
}
