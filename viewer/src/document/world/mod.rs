//! An open world of motion patches: the units that stand in it, the patches stitched over them, and its inhabitants.

mod edit;
mod orders;
mod views;
mod worker;

pub use edit::{EditInProgress, EditStatus, EditSummary, RefusedEdit};
pub use orders::{EditorOrder, UnitChange};

use crate::bundle::OpenBundle;
use crate::render::{Ray, SolidMesh, upright};
use crate::run::{SceneChoice, WorldRun};
use glam::Vec3;
use orders::EditHistory;
use std::path::{Path, PathBuf};
use std::{ops::RangeInclusive, sync::Arc};
use throng_base::error::ensure;
use throng_core::patch::LinkRecord;
use throng_precompute::environment::{Environment, PlacedGeometry, PlacedUnit, UnitGeometry, UnitObject};
use throng_precompute::run::{BuildContext, ensure_bundle};
use throng_precompute::stitch::{
    InstanceItem, RemovalExplanation, RemovalReason, StitchKit, StitchReport, WorldSource,
};
use throng_world::WorldGraph;
use throng_world::inhabitants::{InhabitantGoal, scatter_rest_nodes};
use views::{EditorThread, WalkableWorld};

/// A world that is open.
pub struct WorldDocument {
    /// The file.
    pub path: PathBuf,
    source: WorldSource,
    /// Number of inhabitants, and their seed.
    pub choice: SceneChoice,
    /// The bundle's units, decoded.
    pub kit: Arc<StitchKit>,
    /// The editor; none while an edit is under way.
    workshop: Option<EditorThread>,
    walkable: Arc<WalkableWorld>,
    environment: Environment,
    geometry: PlacedGeometry,
    /// Report of stitching, or of the last edit.
    pub report: StitchReport,
    /// A mesh of every unit of the bundle.
    pub meshes: Arc<[SolidMesh]>,
    /// The inhabitants now.
    pub run: WorldRun,
    made: EditHistory,
    /// The edit under way. Time stands still meanwhile, since all inhabitants return to their shown positions
    /// afterwards.
    pub working: Option<EditInProgress>,
    /// The last edit and its times.
    pub edited: Option<EditSummary>,
    /// The last edit, if it was refused.
    pub refused: Option<RefusedEdit>,
    /// Number of edits so far.
    pub revision: u64,
}

impl WorldDocument {
    /// Bundle with the patches of the world.
    pub fn bundle(&self) -> &OpenBundle {
        &self.walkable.bundle
    }

    /// A unit object of the bundle (unit < number of units of the bundle).
    pub fn unit(&self, unit: usize) -> &UnitObject {
        &self.kit.units.units[unit]
    }

    /// The world as it can be walked.
    pub fn graph(&self) -> &WorldGraph {
        self.walkable.world.graph()
    }

    /// Units with their placements.
    pub fn placed(&self) -> &[PlacedUnit] {
        &self.geometry.units
    }

    /// Name of an instance's patch (instance < number of instances).
    pub fn patch_name(&self, instance: u32) -> &str {
        let patch = self.graph().instance(instance).patch as usize;
        self.bundle().tables().meta().patches.get(patch).map_or("", |p| &p.name)
    }

    /// Why an item of an instance is disabled, in a word; none for an enabled item, or while an edit is under way.
    pub fn reason(&self, instance: u32, item: InstanceItem) -> Option<RemovalReason> {
        self.workshop.as_ref()?.run(move |editor| editor.reason(instance, item))?
    }

    /// Why an item of an instance is disabled, with the obstacle.
    pub fn full_reason(&self, instance: u32, item: InstanceItem) -> Option<RemovalExplanation> {
        self.workshop.as_ref()?.run(move |editor| editor.explain_removal(instance, item))?
    }

    /// Instances that a placed unit is part of.
    pub fn instances_of(&self, place: usize) -> Vec<u32> {
        let graph = self.graph();
        (0..graph.num_instances() as u32).filter(|&i| graph.resources(i).contains(&(place as u32))).collect()
    }

    /// Path of the root along a link of an instance between two of its frames, raised by `above` (m).
    pub fn link_path(&self, instance: u32, link: &LinkRecord, frames: RangeInclusive<u16>, above: f32) -> Vec<Vec3> {
        let at = self.graph().instance(instance).placement;
        let (first, last) = (usize::from(*frames.start()), usize::from(*frames.end()));
        let library = self.kit.library(self.bundle().tables());
        let raised = |r| at.compose(r).translation() + Vec3::Y * above;
        let roots: Vec<Vec3> = library.link_roots(link).map(raised).collect();
        let last = last.min(roots.len().saturating_sub(1));
        // A few straight pieces are enough to show the path.
        let stride = ((last.saturating_sub(first)) / 6).max(1);
        let mut kept: Vec<Vec3> = (first..last).step_by(stride).filter_map(|k| roots.get(k).copied()).collect();
        kept.extend(roots.get(last));
        kept
    }

    /// The placed unit that a ray meets first, and where; the ground, where it meets no unit before.
    pub fn pick(&self, ray: &Ray) -> Option<(Option<usize>, Vec3)> {
        let units = self.placed().iter().enumerate().filter_map(|(place, p)| {
            let bounds = self.geometry.geometry(place).bounds;
            let near = ray
                .passes_within(p.placement.transform_point(bounds.centre()), 0.5 * (bounds.max - bounds.min).length());
            let met = near.then(|| self.meshes.get(p.unit)?.intersect(ray, upright(p.placement))).flatten();
            met.map(|distance| (distance, Some(place)))
        });
        let unit = units.min_by(|a, b| a.0.total_cmp(&b.0));
        let ground = ray.intersect_ground().map(|p| (p.distance(ray.origin), None));
        // A floor panel at ground level is picked before the ground.
        let nearest = match (unit, ground) {
            (Some(u), Some(g)) => Some(if u.0 <= g.0 + 1e-3 { u } else { g }),
            (u, g) => u.or(g),
        };
        nearest.map(|(distance, place)| (place, ray.point_at(distance)))
    }

    /// One step forward, recorded or new, unless an edit is under way.
    ///
    /// # Errors
    /// [`throng_core::Error`] where a step cannot be taken.
    pub fn step(&mut self) -> throng_core::Result<()> {
        if self.working.is_some() { Ok(()) } else { self.run.step() }
    }

    /// Gives a character an order; none lets it decide for itself.
    ///
    /// # Errors
    /// A message for a place or a tag that is not there.
    pub fn give_order(&mut self, character: usize, goal: Option<InhabitantGoal>) -> Result<(), String> {
        ensure(character < self.run.num_characters(), || format!("there is no character {character}"))?;
        self.run.give_order(character, goal).map_err(|e| e.to_string())
    }
}

/// Number of characters that roam in a world.
const ROAMERS: usize = 20;

impl WorldDocument {
    /// Reads a world file and stitches the world; some characters roam in it.
    ///
    /// # Errors
    /// A message that names the file and line or key, why the bundle cannot be opened, or the units that do not go
    /// together, and the way out.
    pub fn open(path: &Path, with: &BuildContext<'_>) -> Result<Self, String> {
        let source = WorldSource::load(path).map_err(|e| e.to_string())?;
        let fail = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        ensure_bundle(&source.bundle, source.config.as_deref(), with).map_err(|e| fail(&e))?;
        let bundle = Arc::new(OpenBundle::open(&source.bundle).map_err(|e| fail(&format!("its bundle: {e}")))?);
        let kit = Arc::new(StitchKit::new(bundle.tables(), &source.bundle).map_err(|e| e.to_string())?);
        let environment = source.environment(&kit.units, path).map_err(|e| e.to_string())?;
        let geometry = PlacedGeometry::new(&environment, &kit.geometries);
        let meshes = kit.geometries.iter().map(|g| unit_mesh(g)).collect();
        let workshop = EditorThread::new(Arc::clone(&bundle), Arc::clone(&kit), environment.clone(), &source.stitch)
            .map_err(|e| fail(&e))?;
        let stitched = workshop.run(|editor| (editor.world().clone(), editor.report().clone()));
        let (world, report) = stitched.ok_or("stitching the world ended unexpectedly")?;
        let ground = Arc::new(WalkableWorld::new(bundle, &world)?);
        let mut choice = SceneChoice { characters: ROAMERS, ..SceneChoice::default() };
        let run = populate(&mut choice, &ground)?;
        Ok(Self {
            path: path.to_path_buf(),
            source,
            choice,
            kit,
            workshop: Some(workshop),
            walkable: ground,
            environment,
            geometry,
            report,
            meshes,
            run,
            made: EditHistory::default(),
            working: None,
            edited: None,
            refused: None,
            revision: 0,
        })
    }
}

/// Places the requested number of characters, as far as there is room.
fn populate(choice: &mut SceneChoice, ground: &WalkableWorld) -> Result<WorldRun, String> {
    let starts = scatter_rest_nodes(ground.world.graph(), choice.characters, choice.seed);
    choice.characters = starts.len();
    WorldRun::new(&ground.world, choice.seed, &starts).map_err(|e| e.to_string())
}

/// Triangles of a unit.
pub fn unit_mesh(geometry: &UnitGeometry) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    geometry.solids.iter().for_each(|solid| mesh.add_solid(solid));
    mesh
}

#[cfg(test)]
mod tests;
