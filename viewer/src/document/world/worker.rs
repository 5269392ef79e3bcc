//! Carries out edits and places new inhabitants on its own thread, so that the window keeps drawing.

use super::orders::{EditorOrder, UnitChange, ended_message};
use super::populate;
use super::views::{EditorThread, WalkableWorld};
use crate::run::{SceneChoice, WorldRun};
use glam::Vec3;
use std::{sync::Arc, time::Instant};
use throng_precompute::environment::{Environment, PlacedGeometry};
use throng_precompute::stitch::{Editor, StitchReport};
use throng_world::{WorldGraph, WorldNode};

/// Input of an edit.
pub(super) struct EditJob {
    pub workshop: EditorThread,
    /// Order to the editor.
    pub order: EditorOrder,
    /// Seed of the inhabitants' choices.
    pub seed: u64,
    /// Positions of the inhabitants (m).
    pub places: Vec<Vec3>,
}

/// Result of a job.
pub(super) struct EditResult {
    /// The editor; none if the job did not need it.
    pub workshop: Option<EditorThread>,
    /// The new state of the world; on failure a message with the reason, and the world is unchanged.
    pub result: Result<EditOutcome, String>,
}

/// New state after a job.
pub(super) enum EditOutcome {
    /// Another world.
    Stitched(Box<StitchedWorld>),
    /// New inhabitants in the unchanged world, as far as there was room, at their first step.
    Begun(SceneChoice, Box<WorldRun>),
}

/// A world that was stitched, with its inhabitants.
pub(super) struct StitchedWorld {
    pub ground: WalkableWorld,
    pub environment: Environment,
    pub geometry: PlacedGeometry,
    pub report: StitchReport,
    /// All inhabitants at the nearest rest nodes.
    pub run: WorldRun,
    /// Number that each of them had before.
    pub before: Vec<usize>,
    /// Time of stitching (s).
    pub stitch_s: f64,
    /// Time of all of it (s).
    pub total_s: f64,
}

/// Places new inhabitants in a world.
pub(super) fn place_roamers(ground: &WalkableWorld, mut choice: SceneChoice) -> EditResult {
    let run = populate(&mut choice, ground);
    EditResult { workshop: None, result: run.map(|run| EditOutcome::Begun(choice, Box::new(run))) }
}

impl EditJob {
    /// Edits the world, and puts its inhabitants back.
    pub fn carry_out(self) -> EditResult {
        let begin = Instant::now();
        let stitched = self.change(self.order).and_then(|()| {
            let stitch_s = begin.elapsed().as_secs_f64();
            match self.place_in_new_world() {
                Ok(stitched) => Ok(StitchedWorld { stitch_s, total_s: begin.elapsed().as_secs_f64(), ..stitched }),
                Err(why) => self.revert().and(Err(why)),
            }
        });
        let result = stitched.map(|stitched| EditOutcome::Stitched(Box::new(stitched)));
        EditResult { workshop: Some(self.workshop), result }
    }

    fn change(&self, order: EditorOrder) -> Result<(), String> {
        let made = self.workshop.run(move |editor| match order {
            EditorOrder::Change(UnitChange::Add { unit, at }) => editor.add(unit, at).map(|_| true),
            EditorOrder::Change(UnitChange::Remove { place }) => editor.remove(place).map(|()| true),
            EditorOrder::Change(UnitChange::Move { place, to }) => editor.drag(place, to).map(|()| true),
            EditorOrder::Undo => editor.undo(),
            EditorOrder::Redo => editor.redo(),
        });
        match made {
            None => Err(self.ended().into()),
            Some(Ok(true)) => Ok(()),
            Some(Ok(false)) => Err("that change is no longer there".into()),
            Some(Err(e)) => Err(e.to_string()),
        }
    }

    fn ended(&self) -> &'static str {
        ended_message(Some(self.order))
    }

    /// The world that the editor had before.
    fn revert(&self) -> Result<(), String> {
        let order = self.order;
        let back = move |editor: &mut Editor<'_>| match order {
            EditorOrder::Change(_) => editor.withdraw_last(),
            EditorOrder::Undo => editor.redo(),
            EditorOrder::Redo => editor.undo(),
        };
        self.workshop.run(back).ok_or(self.ended())?.map(|_| ()).map_err(|e| e.to_string())
    }

    /// The new world, with all inhabitants at the nearest rest nodes.
    fn place_in_new_world(&self) -> Result<StitchedWorld, String> {
        let view = |e: &mut Editor<'_>| (e.world().clone(), e.environment().clone(), e.report().clone());
        let (world, environment, report) = self.workshop.run(view).ok_or(self.ended())?;
        let ground = WalkableWorld::new(Arc::clone(&self.workshop.bundle), &world)?;
        let (before, starts): (Vec<_>, Vec<_>) =
            place_inhabitants(ground.world.graph(), &self.places).into_iter().unzip();
        let run = WorldRun::new(&ground.world, self.seed, &starts).map_err(|e| e.to_string())?;
        let geometry = PlacedGeometry::new(&environment, &self.workshop.kit.geometries);
        Ok(StitchedWorld { ground, environment, geometry, report, run, before, stitch_s: 0.0, total_s: 0.0 })
    }
}

/// For each character, the nearest rest node that shares no unit with the nodes of earlier characters.
///
/// - `places`: where they are (m).
/// - returns each one's number with its node; characters without a place are left out.
fn place_inhabitants(graph: &WorldGraph, places: &[Vec3]) -> Vec<(usize, WorldNode)> {
    let mut taken = vec![false; graph.world().units.len()];
    let mut put = |(character, &place): (usize, &Vec3)| {
        let is_free = |i: u32| graph.resources(i).iter().all(|&u| !taken[u as usize]);
        let node = graph.nearest_rest_of(place, is_free)?;
        graph.resources(node.instance).iter().for_each(|&u| taken[u as usize] = true);
        Some((character, node))
    };
    places.iter().enumerate().filter_map(&mut put).collect()
}
