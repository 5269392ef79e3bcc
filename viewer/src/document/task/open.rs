//! Opens a task: its motion, and the meshes of its things.

use super::{StagedTask, TaskDocument};
use crate::render::SolidMesh;
use glam::{Quat, Vec3};
use std::path::Path;
use std::sync::Arc;
use throng_geometry::SolidShape;
use throng_planner::task::{Task, TaskThing};
use throng_precompute::config::BuildConfig;
use throng_precompute::plans::{self, TaskSources};
use throng_precompute::run::BuildContext;

impl StagedTask {
    /// Lets the walkers of a task walk.
    pub(super) fn walk_walkers(sources: &TaskSources, task: Task, seed: Option<u64>) -> Result<Self, String> {
        let (task, clips) = sources.stage_task(task, seed).map_err(|e| e.to_string())?;
        let (scenery, placed) = task.scenery(&clips).map_err(|e| e.to_string())?;
        Ok(Self { task, clips, placed, scenery })
    }
}

impl TaskDocument {
    /// Reads a task and its motion; nothing is planned yet.
    ///
    /// - `with`: how bundles of walkers are made where they are missing.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open(path: &Path, with: &BuildContext<'_>) -> Result<Self, String> {
        let task = Task::read(path).map_err(|e| e.to_string())?;
        let config = BuildConfig::of_motion("", Vec::new()).map_err(|e| e.to_string())?;
        let named = |why: String| format!("{}: {why}", path.display());
        let sources = plans::load_sources(&task, &config, None, with).map_err(|e| named(e.to_string()))?;
        let staged = StagedTask::walk_walkers(&sources, task.clone(), None).map_err(named)?;
        let meshes = task.things.iter().map(mesh).collect();
        Ok(Self {
            path: path.to_path_buf(),
            sources: Arc::new(sources),
            task,
            staged,
            meshes,
            motions: None,
            shown: None,
            planning: None,
            planners: Arc::default(),
            revision: 1,
            planned_revision: 0,
        })
    }
}

/// All shapes of a thing, in its frame.
fn mesh(thing: &TaskThing) -> SolidMesh {
    let mut mesh = SolidMesh::default();
    for shape in &thing.shapes {
        match shape {
            SolidShape::Round { core, radius } => mesh.add_bar(core.a.as_vec3(), core.b.as_vec3(), *radius as f32),
            SolidShape::Cuboid { half } => mesh.add_box(Vec3::ZERO, Quat::IDENTITY, half.as_vec3()),
            SolidShape::Mesh(triangles) => triangles.corners().iter().for_each(|t| mesh.add_triangle(*t)),
        }
    }
    mesh
}
