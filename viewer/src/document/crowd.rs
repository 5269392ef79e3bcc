//! The crowd of a bundle: a scene of one group that walks about on a plain.

use crate::{bundle::OpenBundle, run::SceneRun};
use std::sync::Arc;
use throng_core::policy::{KIND_CYLINDER, KIND_SPACE_TIME};
use throng_core::{Error, Result};
use throng_simulation::Scene;
use throng_simulation::scene::{PlaceConfig, WeightedBehaviour};

/// Most behaviours that are weighed.
const MAX_BEHAVIOURS: usize = 4;
/// Distance between neighbours at the start, and largest distance where motion that takes long to stop needs more room
/// (m).
const SPACING_M: f64 = 2.0;
const MOST_SPACING_M: f64 = 20.0;
/// The scene; its bundle is in memory, and targets lie on the ground.
const TEXT: &str = "
    bundle = \"bundle\"
    [[groups]]
    name = \"crowd\"
    motion = \"policy\"
    count = 1
    behaviours = [{ name = \"approach\" }]
    target = { height_m = 0.0 }
";

/// The scene of a bundle's crowd. Of several behaviours only the first counts, until others are requested.
///
/// # Errors
/// A message where the bundle has no behaviour.
pub(super) fn scene_of(bundle: &OpenBundle) -> Result<Scene, String> {
    let tables = bundle.tables();
    let named = tables.meta().behaviours.iter().zip(tables.policy_records());
    // Nobody strikes, so that nobody has to answer blows.
    let weighed: Vec<_> = named.filter(|b| b.1.grid.kind != KIND_SPACE_TIME).take(MAX_BEHAVIOURS).collect();
    if weighed.is_empty() {
        return Err("This bundle has no behaviour to run: build it from a config with `behaviours`.".into());
    }
    let mut scene = Scene::parse(TEXT, &bundle.path).map_err(|e| e.to_string())?;
    let group = &mut scene.groups[0];
    // Targets of blows hang where blows land.
    if let Some((_, blows)) = weighed.iter().find(|b| b.1.grid.kind == KIND_CYLINDER) {
        group.target.height_m = 0.5 * f64::from(blows.region.height[0] + blows.region.height[1]);
    }
    let weigh =
        |(i, b): (usize, &(&String, _))| WeightedBehaviour { name: b.0.clone(), weight: f64::from(u8::from(i == 0)) };
    group.behaviours = weighed.iter().enumerate().map(weigh).collect();
    Ok(scene)
}

/// Starts a run of a crowd.
///
/// # Errors
/// [`Error`] where there is no room, or the state does not belong to the crowd.
pub(super) fn start_run(scene: &Scene, bundle: &Arc<OpenBundle>, kept: Option<&[u8]>) -> Result<SceneRun, Error> {
    let (mut scene, mut spacing_m) = (scene.clone(), SPACING_M);
    loop {
        // Characters stand apart whichever way they look.
        scene.groups[0].place = Some(PlaceConfig::Grid { centre: [0.0; 2], spacing_m, distance_m: 0.5 * spacing_m });
        let run = scene.compile(bundle.tables()).and_then(|compiled| SceneRun::new(&compiled, kept, true));
        if run.is_ok() || spacing_m >= MOST_SPACING_M {
            return run;
        }
        spacing_m = (1.5 * spacing_m).min(MOST_SPACING_M);
    }
}

#[cfg(test)]
mod tests;
