//! Positions of what the 3-D view shows: for framing and following by the camera.

use super::Model;
use crate::document::{OpenDocument, SceneDocument, TaskDocument, WorldDocument};
use crate::run::agents::agent_path;
use glam::Vec3;
use throng_crowd::Obstacle;

impl Model {
    /// A box around all that is shown (m).
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let points: Vec<Vec3> = match &self.document {
            OpenDocument::Nothing => Vec::new(),
            OpenDocument::Task(t) => task_points(t).collect(),
            _ if self.shows_clip() || self.shows_blend() => self.corners_around().collect(),
            OpenDocument::Clip(_) => self.corners_around().collect(),
            OpenDocument::World(w) => world_points(w).collect(),
            document => document.scene().map_or(Vec::new(), |s| scene_points(s).collect()),
        };
        let Some(&first) = points.first() else { return (Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 1.8, 2.0)) };
        let (low, high) = points.iter().fold((first, first), |(l, h), &p| (l.min(p), h.max(p)));
        let is_high = self.shown_world().is_some() || self.shown_scene().is_some();
        let top = if is_high { high.y.max(1.8) } else { 1.8 };
        (low.with_y(0.0) - Vec3::new(0.6, 0.0, 0.6), high.with_y(top) + Vec3::new(0.6, 0.0, 0.6))
    }

    /// The corners of a place for a clip's character and its next steps, which the camera follows (m).
    fn corners_around(&self) -> impl Iterator<Item = Vec3> {
        // Room for characters walking beside it.
        let is_wide = self.document.blend().is_some_and(|b| self.shows_blend() && b.1.bodies().len() > 1);
        let half = if is_wide { 1.7 } else { 0.9 };
        let corners = [Vec3::new(-half, 0.0, -0.9), Vec3::new(half, 0.0, 0.9)];
        self.place_followed().into_iter().flat_map(move |at| corners.map(|c| at + c))
    }

    /// Place of the character that the camera follows (m).
    pub fn place_followed(&self) -> Option<Vec3> {
        let selected = self.selection.character;
        match &self.document {
            OpenDocument::Clip(motion) => motion.place(self.player.frame),
            OpenDocument::Task(t) => t.clip(0).root_positions.get(self.player.frame as usize).map(|p| p.with_y(0.0)),
            document if self.shows_clip() => Some(document.bundle()?.planar(self.shown_row()?).translation()),
            OpenDocument::Nothing => None,
            OpenDocument::World(w) => {
                let c = selected.filter(|&c| c < w.run.num_characters())?;
                Some(w.run.hips(c).with_y(0.0))
            }
            OpenDocument::Bundle(b) if self.shows_blend() => {
                Some(b.blend.as_ref()?.reel.moment().roots.first()?.translation())
            }
            document => document.scene()?.run.place(selected.filter(|&c| c < self.num_characters())?),
        }
    }
}

/// Positions of all characters during the steps of a task, and of movable things and places (m).
fn task_points(task: &TaskDocument) -> impl Iterator<Item = Vec3> {
    let windows: Vec<[f64; 3]> = task.task().windows_s().into_iter().flatten().collect();
    let is_during = move |t: f64| windows.is_empty() || windows.iter().any(|w| w[0] <= t && t <= w[2]);
    let roots = task.clips_before().iter().flat_map(move |clip| {
        let (rate_hz, is_during) = (clip.rate_hz, is_during.clone());
        let all = clip.root_positions.iter().enumerate().step_by(6);
        all.filter(move |(f, _)| is_during(*f as f64 / rate_hz)).map(|(_, p)| *p)
    });
    let handles = task.task().handles().into_iter().filter_map(|h| Some(task.place_of(h, 0.0)?.position.as_vec3()));
    roots.chain(handles).filter(|p| p.is_finite())
}

/// Corners of boxes around the units of a world, and its characters (m).
fn world_points(world: &WorldDocument) -> impl Iterator<Item = Vec3> {
    let of_units = world.placed().iter().flat_map(|p| {
        let b = world.kit.geometries[p.unit].bounds.mapped(|c| p.placement.transform_point(c));
        [b.min, b.max]
    });
    of_units.filter(|p| p.is_finite()).chain((0..world.run.num_characters()).map(|c| world.run.hips(c)))
}

/// Positions of the characters of a scene, their targets, and both ends of the agents' routes; for agents with rules,
/// also places, doors and surroundings, since they may be sent there (m).
fn scene_points(scene: &SceneDocument) -> impl Iterator<Item = Vec3> {
    let (run, all) = (&scene.run, 0..scene.run.simulation().num_characters());
    let points = all.flat_map(|who| {
        let route = agent_path(run.simulation(), who);
        [run.place(who), run.simulation().target(who), route.first().copied(), route.last().copied()]
    });
    let standing = Some(&scene.surroundings).filter(|s| run.simulation().brains().is_some() && !s.in_the_air);
    let ends = standing.into_iter().flat_map(|s| {
        let obstacles = s.obstacles.iter().flat_map(|o| match o {
            Obstacle::Wall { from, to, .. } => vec![*from, *to],
            Obstacle::Ball { centre, .. } => vec![*centre],
            Obstacle::Polygon { corners } => corners.clone(),
            Obstacle::Box { min, max } => vec![*min, *max],
            _ => Vec::new(),
        });
        s.doors.iter().flat_map(|d| d.ends).chain(obstacles)
    });
    let places = scene.scene.places.iter().flat_map(|place| {
        let at = |p: &[f32]| Vec3::new(p[0], if p.len() > 2 { p[1] } else { 0.0 }, p[p.len() - 1]);
        let slots = place.slots.iter().map(|s| s.at.as_slice());
        let queue = place.queue.iter().flat_map(|q| q.points.iter().map(|p| p.as_slice()));
        std::iter::once(place.at.as_slice()).chain(slots).chain(queue).map(at).collect::<Vec<_>>()
    });
    points.flatten().chain(ends).chain(places).filter(|p| p.is_finite())
}
