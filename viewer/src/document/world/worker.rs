//! Carries out edits and places new inhabitants on its own thread, so that the window keeps drawing.

use super::Roamers;
use super::open::populate;
use super::orders::{Change, Order, Work};
use super::settle::settle;
use super::views::{Ground, Workshop};
use crate::run::WorldRun;
use glam::Vec3;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Instant;
use throng_precompute::environment::{Environment, PlacedGeometry};
use throng_precompute::stitch::{Editor, StitchReport};

/// Input of an edit.
pub(super) struct Job {
    pub workshop: Workshop,
    /// Order to the editor.
    pub order: Order,
    /// Seed of the inhabitants' choices.
    pub seed: u64,
    /// Positions of the inhabitants (m).
    pub places: Vec<Vec3>,
}

/// Result of a job.
pub(super) struct Done {
    /// The editor; none if the job did not need it.
    pub workshop: Option<Workshop>,
    /// The new state of the world; on failure a message with the reason, and the world is unchanged.
    pub result: Result<Outcome, String>,
}

/// New state after a job.
pub(super) enum Outcome {
    /// Another world.
    Stitched(Box<Stitched>),
    /// New inhabitants in the unchanged world.
    Begun(Box<Begun>),
}

/// New inhabitants of a world.
pub(super) struct Begun {
    /// Number of inhabitants, as far as there was room.
    pub roamers: Roamers,
    /// They at their first step.
    pub run: WorldRun,
}

/// A world that was stitched, with its inhabitants.
pub(super) struct Stitched {
    pub ground: Ground,
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

/// Starts a job; it ends by sending its result.
pub(super) fn begin(job: Job) -> Receiver<Done> {
    spawn(move || job.carry_out())
}

/// Starts to place new inhabitants in a world.
pub(super) fn begin_anew(ground: Arc<Ground>, mut roamers: Roamers) -> Receiver<Done> {
    spawn(move || {
        let run = populate(&mut roamers, &ground);
        Done { workshop: None, result: run.map(|run| Outcome::Begun(Box::new(Begun { roamers, run }))) }
    })
}

fn spawn(work: impl FnOnce() -> Done + Send + 'static) -> Receiver<Done> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        // The receiver is gone if another file was opened meanwhile.
        let _ = send.send(work());
    });
    receive
}

impl Job {
    fn carry_out(self) -> Done {
        let begin = Instant::now();
        let stitched = self.change(self.order).and_then(|()| {
            let stitch_s = begin.elapsed().as_secs_f64();
            match self.settled() {
                Ok(stitched) => Ok(Stitched { stitch_s, total_s: begin.elapsed().as_secs_f64(), ..stitched }),
                Err(why) => self.go_back().and(Err(why)),
            }
        });
        let result = stitched.map(|stitched| Outcome::Stitched(Box::new(stitched)));
        Done { workshop: Some(self.workshop), result }
    }

    fn change(&self, order: Order) -> Result<(), String> {
        let made = self.workshop.with(move |editor| match order {
            Order::Change(Change::Add { unit, at }) => editor.add(unit, at).map(|_| true),
            Order::Change(Change::Remove { place }) => editor.remove(place).map(|()| true),
            Order::Change(Change::Move { place, to }) => editor.drag(place, to).map(|()| true),
            Order::Undo => editor.undo(),
            Order::Redo => editor.redo(),
        });
        match made {
            None => Err(self.ended().into()),
            Some(Ok(true)) => Ok(()),
            Some(Ok(false)) => Err("that change is no longer there".into()),
            Some(Err(e)) => Err(e.to_string()),
        }
    }

    fn ended(&self) -> &'static str {
        Work::Edit(self.order).ended()
    }

    /// The world that the editor had before.
    fn go_back(&self) -> Result<(), String> {
        let order = self.order;
        let back = move |editor: &mut Editor<'_>| match order {
            Order::Change(_) => editor.withdraw(),
            Order::Undo => editor.redo(),
            Order::Redo => editor.undo(),
        };
        self.workshop.with(back).ok_or(self.ended())?.map(|_| ()).map_err(|e| e.to_string())
    }

    /// The new world, with all inhabitants at the nearest rest nodes.
    fn settled(&self) -> Result<Stitched, String> {
        let look = |e: &mut Editor<'_>| (e.world().clone(), e.environment().clone(), e.report().clone());
        let (world, environment, report) = self.workshop.with(look).ok_or(self.ended())?;
        let ground = Ground::new(self.workshop.shared_bundle(), &world)?;
        let (before, starts): (Vec<_>, Vec<_>) = settle(ground.graph(), &self.places).into_iter().unzip();
        let run = WorldRun::new(ground.world(), self.seed, &starts).map_err(|e| e.to_string())?;
        let geometry = PlacedGeometry::new(&environment, &self.workshop.kit().geometries);
        Ok(Stitched { ground, environment, geometry, report, run, before, stitch_s: 0.0, total_s: 0.0 })
    }
}
