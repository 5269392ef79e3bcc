//! Edits: units come, go and are moved, and the world is stitched again around them.

use super::WorldDocument;
use super::settle::settle;
use super::views::Ground;
use crate::run::WorldRun;
use glam::Vec3;
use std::path::Path;
use std::time::Instant;
use throng_precompute::environment::PlacedGeometry;
use throng_runtime::patch::Placement;
use throng_runtime::world::inhabitants::Wish;

/// A change of what stands where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// One more unit.
    Add {
        /// Its number in the bundle's set.
        unit: usize,
        /// Where it stands.
        at: Placement,
    },
    /// A placed unit goes; those after it move up.
    Remove {
        /// Number of the place.
        place: usize,
    },
    /// A placed unit is moved.
    Move {
        /// Number of the place.
        place: usize,
        /// Where it stands then.
        to: Placement,
    },
}

/// An edit that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Edited {
    /// What was done, in words.
    pub what: String,
    /// Time of stitching. [Unit: s]
    pub stitch_s: f64,
    /// Time of all of it: stitching, what walks over it, and the characters. [Unit: s]
    pub total_s: f64,
    /// Characters that found no place any more.
    pub lost: usize,
}

impl WorldDocument {
    /// Changes what stands where, stitches the world again, and puts everybody at the nearest place to stay.
    ///
    /// - returns the place of the unit that was added or moved.
    ///
    /// # Errors
    /// A message that says why the world would be none; it stays as it was.
    pub fn edit(&mut self, change: Change) -> Result<Option<usize>, String> {
        let begin = Instant::now();
        let what = self.describe(change);
        let before = self.environment();
        let place = self.stitch(change)?;
        let stitch_s = begin.elapsed().as_secs_f64();
        let made = self.workshop.with(|e| e.world().clone());
        let ground = Ground::new(self.ground.shared_bundle(), made);
        let settled = ground.and_then(|ground| self.resettle(&ground).map(|(run, lost)| (ground, run, lost)));
        let (ground, run, lost) = match settled {
            Ok(settled) => settled,
            Err(why) => {
                self.undo(before)?;
                return Err(why);
            }
        };
        (self.ground, self.run) = (ground, run);
        self.geometry = PlacedGeometry::new(&self.environment(), &self.workshop.kit().geometries);
        self.revision += 1;
        self.edited = Some(Edited { what, stitch_s, total_s: begin.elapsed().as_secs_f64(), lost });
        Ok(place)
    }

    fn stitch(&mut self, change: Change) -> Result<Option<usize>, String> {
        let made = self.workshop.change(|editor| match change {
            Change::Add { unit, at } => editor.add(unit, at).map(Some),
            Change::Remove { place } => editor.remove(place).map(|()| None),
            Change::Move { place, to } => editor.drag(place, to).map(|()| Some(place)),
        });
        made.map_err(|e| e.to_string())
    }

    /// Stitches the world as it was.
    fn undo(&mut self, environment: throng_precompute::environment::Environment) -> Result<(), String> {
        let kit = self.workshop.kit().clone();
        self.workshop =
            super::views::Workshop::new(self.ground.shared_bundle(), kit, environment, &self.source.stitch)?;
        Ok(())
    }

    /// Everybody at the nearest place to stay, with what each was told to do.
    fn resettle(&self, ground: &Ground) -> Result<(WorldRun, usize), String> {
        let (bundle, graph) = (ground.bundle(), ground.graph());
        let n = self.run.num_characters();
        let places: Vec<Vec3> = (0..n).map(|c| self.run.hips(c)).collect();
        let settled = settle(graph, &places);
        let starts: Vec<_> = settled.iter().map(|s| s.1).collect();
        let life = self.scene.live_at(bundle.tables(), bundle.repertoire(), graph, &starts);
        let mut run = WorldRun::new(life.map_err(|e| e.to_string())?, bundle, graph).map_err(|e| e.to_string())?;
        run.play(self.run.is_playing());
        run.set_speed(self.run.speed());
        for (new, &(old, _)) in settled.iter().enumerate() {
            let told = self.run.told(old).filter(|w| !matches!(w, Wish::GoTo { .. }));
            if let Some(wish) = told {
                // What can no longer be done is not wished for any more.
                let _ = run.tell(graph, new, Some(wish));
            }
        }
        Ok((run, n - settled.len()))
    }

    fn describe(&self, change: Change) -> String {
        let name = |place: usize| self.placed().get(place).map_or("a unit", |p| &self.unit(p.unit).name);
        match change {
            Change::Add { unit, .. } => {
                format!("added {}", self.kit().units.units.get(unit).map_or("a unit", |u| &u.name))
            }
            Change::Remove { place } => format!("removed {}", name(place)),
            Change::Move { place, .. } => format!("moved {}", name(place)),
        }
    }

    /// Writes the world as it is to a file of its own: a plain list of places.
    ///
    /// # Errors
    /// A message where it cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), String> {
        let changed = self.source.with_environment(&self.environment(), &self.kit().units);
        changed.save(path).map_err(|e| e.to_string())
    }
}
