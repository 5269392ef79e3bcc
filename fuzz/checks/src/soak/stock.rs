//! Scenes that need no file: every example of the project, made small, and made-up ones of what no example has. Their bundles
//! are made from synthetic motion, and their world is stitched.

use std::path::Path;
use throng_lab::run::{BuildContext, ensure_scene};
use throng_motion::error::BuildError;
use throng_motion::files::write_atomically;
use throng_simulation::scene::{InhabitantGoalConfig, PictureConfig, PlaceConfig};
use throng_simulation::{GroupMotion, Scene};

/// Names and texts of files of a folder.
macro_rules! texts {
    ($folder:literal: $($name:literal)*) => {
        [$(($name, include_str!(concat!($folder, $name)))),*]
    };
}

/// Every example of the project.
const EXAMPLES: [(&str, &str); 26] = texts!("../../../../data/scenes/":
    "blend-walkers.toml" "bottleneck.toml" "boxing-30.toml" "boxing-pair.toml" "boxing-target.toml" "circle.toml"
    "concert-exit.toml" "corridor.toml" "flock-000.toml" "flock.toml" "lanes.toml" "logo.toml" "museum.toml" "office.toml"
    "park.toml" "partners.toml" "playground.toml" "plaza-all.toml" "plaza.toml" "race-100.toml" "race.toml" "ring.toml"
    "square.toml" "station.toml" "street.toml" "tea.toml");

/// Made-up scenes.
const MADE: [(&str, &str); 8] = texts!("made/":
    "policy.toml" "inhabited.toml" "sparring.toml" "market.toml" "floors.toml" "floor.toml" "hills.toml" "staggers.toml");

/// What bundles and the world are made from.
const SOURCES: [(&str, &str); 4] = texts!("made/": "people.toml" "walk.toml" "tiles.toml" "floor-of-tiles.toml");

/// Level of two floors: `throng level floors.obj` makes it.
const FLOORS: &[u8] = include_bytes!("made/floors.level");

/// Config of the boxers' bundle.
const BOXERS: &str = concat!(
    "name = \"boxing\"\nsynth = { set = \"boxing\", minutes = 0.6 }\n[policy]\ncompare_samples = 100\n",
    include_str!("boxing.toml")
);

/// Unit objects of the tiles.
const UNITS: &str = include_str!("../../../../data/units/playground.toml");

/// Most people of an example: with bodies, and in a world.
const PEOPLE: usize = 40;
const INHABITANTS: usize = 12;
/// Most agents of an example without bodies.
const AGENTS: usize = 200;
/// Example of which a great crowd is made, and its size: smaller ones, and those with stories, are never shared among threads.
const GREAT: &str = "circle";
const GREAT_CROWD: usize = 2048;
/// Behaviours of the made bundle of boxers.
const BOXING: [&str; 3] = ["approach", "throw-punches", "evade"];

/// The scenes: all kinds of motion, and stories, sources, companions, doors, things and levels.
///
/// - `folder`: takes the bundles and the world, which are made where they are missing.
///
/// # Errors
/// What building and stitching say, and [`BuildError::Io`] where the folder cannot be written.
pub fn scenes(folder: &Path, with: &BuildContext<'_>) -> Result<Vec<Scene>, BuildError> {
    std::fs::create_dir_all(folder).map_err(|source| BuildError::Io { path: folder.to_path_buf(), source })?;
    let texts = MADE.into_iter().chain(SOURCES).chain([("units.toml", UNITS), ("boxing.toml", BOXERS)]);
    let files = texts.map(|(name, text)| (name, text.as_bytes())).chain([("floors.level", FLOORS)]);
    for (name, bytes) in files {
        write_atomically(&folder.join(name), |out| out.write_all(bytes))?;
    }
    let made = MADE.iter().map(|(name, _)| Scene::load(folder.join(name)));
    let small =
        EXAMPLES.iter().map(|(name, text)| Scene::parse(text, &folder.join(name)).map(|scene| shrink(scene, folder)));
    let scenes = made.chain(small).collect::<Result<Vec<Scene>, _>>().map_err(super::fault)?;
    scenes.iter().try_for_each(|scene| ensure_scene(scene, with))?;
    Ok(scenes)
}

/// An example with fewer people, on the made bundles and the made world.
fn shrink(scene: Scene, folder: &Path) -> Scene {
    let has_bodies = scene.groups.iter().any(|g| g.motion != GroupMotion::None);
    let before: Vec<usize> = scene.groups.iter().map(|g| g.count).collect();
    let size = match scene.name.as_str() {
        GREAT => GREAT_CROWD,
        _ => scene.num_characters().min(if has_bodies { PEOPLE } else { AGENTS }),
    };
    let mut small = scene.resized(size);
    // A soak looks at steps, and draws no picture.
    small.expect.clear();
    small.picture = PictureConfig::default();
    (small.bundle, small.config, small.environment.world, small.environment.world_config) = (None, None, None, None);
    for (group, before) in small.groups.iter_mut().zip(before) {
        group.count = group.count.max(2.min(before));
        // A ring keeps its size.
        if let Some(PlaceConfig::Ring { spacing_m, .. }) = group.place.as_mut().filter(|_| !scene.measure.grows) {
            *spacing_m *= before as f32 / group.count as f32;
        }
        let bundle = match group.motion {
            GroupMotion::None => None,
            GroupMotion::Blend => {
                group.spaces = vec!["walks".into()];
                group.style_by_speed.clear();
                Some("people")
            }
            GroupMotion::Policy | GroupMotion::Sparring => {
                group.count += usize::from(group.motion == GroupMotion::Sparring) * (group.count % 2);
                group.behaviours.retain(|b| BOXING.contains(&b.name.as_str()));
                Some("boxing")
            }
            GroupMotion::Patches => {
                group.count = group.count.min(INHABITANTS);
                group.goals.retain(|g| !matches!(g.goal, InhabitantGoalConfig::Perform { .. }));
                group.world = Some(folder.join("floor.world"));
                group.world_config = Some(folder.join("floor-of-tiles.toml"));
                Some("tiles")
            }
        };
        group.bundle = bundle.map(|name| folder.join(format!("{name}.throng")));
        group.config = bundle.map(|name| folder.join(format!("{name}.toml")));
        if let Some(source) = &mut group.source {
            source.start = source.start * group.count / before;
        }
    }
    small
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;
    use std::collections::BTreeSet;
    use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
    use throng_core::{Executor, Inline};
    use throng_simulation::Simulation;
    use throng_simulation::scenario::ActionRegistry;

    /// Parts of scenes that no run depends on, and words that synthetic motion has no use for.
    const NOT_RUN: [&str; 6] =
        ["PictureConfig.", "PictureStyle.", "Expect", "SceneMeasureConfig.", "LanesConfig.", "GroupConfig.manners"];

    /// Adds every word that a schema knows: keys and variants, each behind the name of its part.
    fn known_words(name: &str, node: &Value, found: &mut BTreeSet<String>) {
        for key in node["properties"].as_object().into_iter().flat_map(|p| p.keys()) {
            found.insert(format!("{name}.{key}"));
        }
        let variants = node["enum"].as_array().into_iter().flatten().chain([&node["const"]]);
        found.extend(variants.filter_map(Value::as_str).map(|word| format!("{name}.{word}")));
        for part in ["oneOf", "anyOf"].iter().flat_map(|of| node[of].as_array()).flatten() {
            known_words(name, part, found);
        }
    }

    /// Adds the words of a schema that a value uses.
    fn used_words(schema: &Value, name: &str, node: &Value, value: &Value, found: &mut BTreeSet<String>) {
        if let Some(part) = node["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
            used_words(schema, part, &schema["$defs"][part], value, found);
        }
        for part in ["oneOf", "anyOf", "allOf"].iter().flat_map(|of| node[of].as_array()).flatten() {
            used_words(schema, name, part, value, found);
        }
        for (key, below) in value.as_object().into_iter().flatten() {
            if !node["properties"][key].is_null() {
                found.insert(format!("{name}.{key}"));
                used_words(schema, name, &node["properties"][key], below, found);
            } else if node["additionalProperties"].is_object() {
                used_words(schema, name, &node["additionalProperties"], below, found);
            }
        }
        for below in value.as_array().into_iter().flatten().filter(|_| node["items"].is_object()) {
            used_words(schema, name, &node["items"], below, found);
        }
        let variants = node["enum"].as_array().into_iter().flatten().chain([&node["const"]]);
        if let Some(word) = value.as_str().filter(|_| variants.into_iter().any(|v| v == value)) {
            found.insert(format!("{name}.{word}"));
        }
    }

    fn documents() -> impl Iterator<Item = Value> {
        let texts = MADE.into_iter().chain(EXAMPLES);
        texts.map(|(name, text)| toml::from_str(text).unwrap_or_else(|e| panic!("{name}: {e}")))
    }

    #[test]
    fn every_example_of_the_project_is_soaked() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes");
        let files = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
        let files: BTreeSet<String> = files.filter(|name| name.ends_with(".toml")).collect();
        assert_eq!(files, EXAMPLES.iter().map(|(name, _)| (*name).to_owned()).collect());
    }

    #[test]
    fn the_scenes_have_every_kind_of_motion_and_every_construct_of_stories() {
        let schema = schemars::schema_for!(Scene).to_value();
        let (mut known, mut used) = (BTreeSet::new(), BTreeSet::new());
        known_words("Scene", &schema, &mut known);
        for (name, part) in schema["$defs"].as_object().unwrap() {
            known_words(name, part, &mut known);
        }
        for document in documents() {
            used_words(&schema, "Scene", &schema, &document, &mut used);
        }
        assert!(known.len() > 200 && known.contains("GroupMotion.patches") && known.contains("SourceConfig.reuse"));
        let missing: Vec<_> = known.difference(&used).filter(|w| !NOT_RUN.iter().any(|n| w.starts_with(n))).collect();
        assert!(missing.is_empty(), "no scene of the soak has {missing:?}: write one in fuzz/checks/src/soak/made");
    }

    #[test]
    fn the_scenes_have_every_action() {
        fn add_keys(value: &Value, keys: &mut BTreeSet<String>) {
            value.as_object().into_iter().flatten().for_each(|(key, below)| {
                keys.insert(key.clone());
                add_keys(below, keys);
            });
            value.as_array().into_iter().flatten().for_each(|below| add_keys(below, keys));
        }
        let mut keys = BTreeSet::new();
        documents().for_each(|document| add_keys(&document, &mut keys));
        let registry = ActionRegistry::default();
        let missing: Vec<_> = registry.action_names().filter(|name| !keys.contains(*name)).collect();
        assert!(missing.is_empty(), "no scene of the soak does {missing:?}: write one in fuzz/checks/src/soak/made");
    }

    /// An executor that counts how often work is shared.
    #[derive(Default)]
    struct Counter(AtomicUsize);

    impl Executor for Counter {
        fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
            self.0.fetch_add(usize::from(num_parts > 1), SeqCst);
            Inline.run(num_parts, part);
        }
    }

    #[test]
    fn threads_share_the_work_of_a_crowd() {
        let (name, text) = EXAMPLES.iter().find(|e| e.0 == "circle.toml").unwrap();
        let scene = shrink(Scene::parse(text, Path::new(name)).unwrap(), Path::new(""));
        let mut sim = Simulation::new(&scene.open().unwrap()).unwrap();
        let counter = Counter::default();
        sim.step_to(0.5, &counter).unwrap();
        assert!(counter.0.load(SeqCst) > 0, "a comparison of threads would compare a run with itself");
    }
}
