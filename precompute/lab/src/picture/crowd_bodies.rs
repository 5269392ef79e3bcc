//! The picture of a crowd with bodies.

use super::discs::{OBSTACLE_COLOUR, group_colour};
use super::{BodyColours, BodyFigure, Colour, Picture, WorldCamera, WorldFigure, WorldSheet, world_sheet};
use super::{obstacle_solid, world::OBLIQUE_VIEW};
use crate::run::{AgentsRecord, JointPositions};
use glam::Vec3;
use throng_bake::environment::UnitSolid;
use throng_core::Joint;

/// Width of the picture of bodies (m).
const PICTURE_WIDTH_M: f32 = 24.0;
/// Colour of things that lie or are carried.
const THING_COLOUR: Colour = Colour::hex(0xd62728);

/// Draws the bodies of a crowd at the end of its run.
///
/// - `poses`: world positions of all joints of each agent, `None` where one has left (m).
/// - `heights`: heights of the obstacles, in the order of the record (m).
/// - `things`: things that lie or are carried.
pub(super) fn bodies_sheet(
    record: &AgentsRecord,
    poses: &[Option<JointPositions>],
    heights: impl Iterator<Item = f32>,
    things: &[UnitSolid],
) -> Picture {
    let one = |(m, p): (usize, &Option<JointPositions>)| {
        let tint = group_colour(record.groups.get(m).copied().unwrap_or(0));
        Some(WorldFigure { figure: BodyFigure::from_positions(p.as_ref()?), colours: BodyColours::plain(tint) })
    };
    let figures: Vec<WorldFigure> = poses.iter().enumerate().filter_map(one).collect();
    let obstacles = record.obstacles.iter().zip(heights);
    let standing = obstacles.filter_map(|(o, height)| Some((obstacle_solid(o, height)?, OBSTACLE_COLOUR)));
    let solids: Vec<(UnitSolid, Colour)> = standing.chain(things.iter().map(|t| (t.clone(), THING_COLOUR))).collect();
    let places: Vec<Vec3> = figures.iter().map(|f| f.figure.joint(Joint::Hips)).collect();
    let focus = densest_place(&places).map(|at| (at, PICTURE_WIDTH_M));
    world_sheet(&WorldSheet {
        title: "Bodies",
        subtitle: "where they are at the end",
        size: (1600, 900),
        figures: &figures,
        solids: &solids,
        camera: WorldCamera { focus, ..OBLIQUE_VIEW },
        ..WorldSheet::default()
    })
}

/// Mean position of the densest neighbourhood; in large crowds, only some agents are candidates for its centre.
fn densest_place(places: &[Vec3]) -> Option<Vec3> {
    const NEAR_M: f32 = 0.4 * PICTURE_WIDTH_M;
    const LOOKED_AT: usize = 200;
    let near = |at: Vec3| places.iter().filter(move |p| p.distance_squared(at) < NEAR_M * NEAR_M);
    let some = places.iter().step_by(places.len().div_ceil(LOOKED_AT).max(1));
    let at = some.max_by_key(|at| near(**at).count())?;
    Some(near(*at).sum::<Vec3>() / near(*at).count() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use throng_core::Skeleton;
    use throng_crowd::Obstacle;

    #[test]
    fn bodies_and_outlines_are_drawn_and_an_empty_crowd_is_no_panic() {
        let record = AgentsRecord {
            groups: vec![0, 1],
            doors: Vec::new(),
            places: Vec::new(),
            obstacles: vec![Obstacle::Ball { centre: Vec3::X, radius: 1.0 }],
            ..AgentsRecord::default()
        };
        let pose = Skeleton::default().rest_positions();
        let draw = |poses: &[Option<JointPositions>], height: f32, things: &[UnitSolid]| {
            bodies_sheet(&record, poses, [height].into_iter(), things)
        };
        let centre = Vec3::new(-1.0, 0.5, 0.0);
        let cup = UnitSolid::Box { centre, rotation: Quat::IDENTITY, half: Vec3::splat(0.15) };
        let one = draw(&[Some(pose), None], 0.5, &[]);
        assert_ne!(one, draw(&[None, None], 0.5, &[]));
        assert_eq!(one, draw(&[Some(pose), None], 0.5, &[]));
        assert_ne!(one, draw(&[Some(pose), None], 1.5, &[]), "it is as high as it says");
        assert_ne!(one, draw(&[Some(pose), None], 0.5, &[cup]), "things are drawn");
    }
}
