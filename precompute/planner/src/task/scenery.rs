//! Places of everything in a task, for drawing and for moving things.

use super::{ActorClip, Anchor, ClipMismatch, Task, TaskStage, TaskStep, ThingStart};
use crate::{rotation::Rigid, track::RigidPath};
use glam::DVec3;
use throng_motion::Clip;

/// Places of everything in a task.
#[derive(Clone, Debug, Default)]
pub struct TaskScenery {
    /// Motion of every thing, by its index in the task.
    pub paths: Vec<RigidPath>,
    /// Frame from which the place (`to`) of each step is seen when it is reached; `None` where there is no such place.
    pub bases: Vec<Option<Rigid>>,
}

/// Something of a task that can be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// An obstacle or an object, by its index.
    Thing(usize),
    /// The place to which a step brings an object, by the index of the step.
    Place(usize),
}

impl TaskScenery {
    /// Follows a move by [`Task::move_by`].
    pub fn move_by(&mut self, task: &Task, handle: Handle, by: DVec3) {
        let Handle::Thing(thing) = handle else { return };
        if !matches!(task.things[thing].start, ThingStart::Path(_)) {
            return;
        }
        self.paths.iter_mut().skip(thing).take(1).for_each(|path| *path = path.moved_by(by));
        let is_on_it = |step: &TaskStep| step.to.is_some_and(|to| to.on == Anchor::Thing(thing));
        let moved = self.bases.iter_mut().zip(&task.steps).filter(|(_, step)| is_on_it(step));
        moved.filter_map(|(base, _)| base.as_mut()).for_each(|base| base.position += by);
    }

    pub(super) fn from_stage(stage: &TaskStage<'_>) -> Self {
        let base = |step: &TaskStep| Some(stage.base_of(&step.to.filter(|_| step.is_timed())?, step.times_s[1]));
        let paths = (0..stage.task.things.len()).map(|i| stage.thing_path(i)).collect();
        Self { paths, bases: stage.task.steps.iter().map(base).collect() }
    }
}

impl Task {
    /// Places of everything before anything was planned, and the clips placed in the scene.
    ///
    /// # Errors
    /// [`ClipMismatch`].
    pub fn scenery(&self, clips: &[ActorClip]) -> Result<(TaskScenery, Vec<Clip>), ClipMismatch> {
        self.check_clips(clips)?;
        let stage = TaskStage::new(self, clips);
        let scenery = TaskScenery::from_stage(&stage);
        Ok((scenery, stage.actors.into_iter().map(|a| a.clip).collect()))
    }

    /// Times at which the limb of each step leaves the clip, reaches its target and is back; for corrections, the stretch that
    /// is searched for collisions, which may reach to the end of time (s). `None` for steps without a time.
    pub fn windows_s(&self) -> Vec<Option<[f64; 3]>> {
        self.steps.iter().map(|s| s.is_timed().then_some(s.times_s)).collect()
    }

    /// Everything that can be moved: all things that no character carries from the beginning, and all places that things are
    /// brought to.
    pub fn handles(&self) -> Vec<Handle> {
        let is_free = |i: &usize| matches!(self.things[*i].start, ThingStart::Path(_));
        let things = (0..self.things.len()).filter(is_free).map(Handle::Thing);
        let places = (0..self.steps.len()).filter(|i| self.steps[*i].to.is_some()).map(Handle::Place);
        things.chain(places).collect()
    }

    /// Name of a handle.
    pub fn handle_name(&self, handle: Handle) -> String {
        match handle {
            Handle::Thing(i) => self.things[i].name.clone(),
            Handle::Place(i) => format!("place of {}", self.steps[i].name),
        }
    }

    /// Transform of a handle before anything was planned.
    ///
    /// - `scenery`: of this task, before anything was planned.
    pub fn handle_place(&self, handle: Handle, scenery: &TaskScenery, time_s: f64) -> Option<Rigid> {
        match handle {
            Handle::Thing(i) => Some(scenery.paths.get(i)?.place_at(time_s)),
            Handle::Place(i) => Some((*scenery.bases.get(i)?)?.compose(self.steps.get(i)?.to?.offset)),
        }
    }

    /// Moves something; keys, and objects that are brought to it, move along.
    ///
    /// - `by`: offset in the world (m).
    /// - `scenery`: of this task, before anything was planned.
    pub fn move_by(&mut self, handle: Handle, by: DVec3, scenery: &TaskScenery) {
        match handle {
            Handle::Thing(i) => {
                if let ThingStart::Path(path) = &mut self.things[i].start {
                    *path = path.moved_by(by);
                }
            }
            Handle::Place(i) => {
                let base = scenery.bases.get(i).copied().flatten().unwrap_or(Rigid::IDENTITY);
                if let Some(to) = &mut self.steps[i].to {
                    to.offset.position += base.rotation.inverse() * by;
                }
            }
        }
    }

    /// Position of a handle as the file has it, relative to what it stands on: `at` of its table; the first key's for a thing
    /// that moves through keys (m).
    pub fn written_position(&self, handle: Handle) -> DVec3 {
        match handle {
            Handle::Thing(i) => match &self.things[i].start {
                ThingStart::Path(path) => path.place_at(f64::NEG_INFINITY).position,
                ThingStart::OnJoint { offset, .. } => offset.position,
            },
            Handle::Place(i) => self.steps[i].to.map_or(DVec3::ZERO, |to| to.offset.position),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::task::tests::{ERRANDS, TASK, parse, stand};
    use crate::testing::TestCharacter;

    #[test]
    fn things_and_places_move_by_what_is_asked_for() {
        let s = TestCharacter::standing();
        let clips = [ActorClip { clip: stand(&s), skeleton: s.skeleton.clone() }];
        for text in [TASK, ERRANDS] {
            let mut task = parse(text).expect("a task");
            let handles = task.handles();
            let places = handles.iter().filter(|h| matches!(h, Handle::Place(_))).count();
            assert_eq!((handles.len() > places, places > 0), (true, text == ERRANDS));
            for handle in handles {
                let (mut before, _) = task.scenery(&clips).expect("clips");
                let at = |task: &Task, s: &TaskScenery| task.handle_place(handle, s, 0.7).expect("a place").position;
                let (was, by) = (at(&task, &before), DVec3::new(0.1, -0.02, 0.3));
                let first = task.written_position(handle);
                task.move_by(handle, by, &before);
                before.move_by(&task, handle, by);
                let (after, _) = task.scenery(&clips).expect("clips");
                assert!(at(&task, &after).distance(was + by) < 1e-9, "{}", task.handle_name(handle));
                for other in task.handles() {
                    let [a, b] = [&before, &after].map(|s| task.handle_place(other, s, 0.7));
                    assert_eq!(a, b, "{}", task.handle_name(other));
                }
                assert!((task.written_position(handle).distance(first) - by.length()).abs() < 1e-9);
            }
        }
    }
}
