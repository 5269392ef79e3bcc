//! Compiled scenes: all that a scene file names is opened and checked.

use crate::scenario::{ActionRegistry, Scenario};
use crate::scene::{ANY_PARTNER, GroupConfig, GroupMotion, InhabitantGoalConfig, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_base::{Hash128, Result};
use throng_core::{Bundle, blend::BlendSpace, patch::LinkRecord};
use throng_world::World;

/// A scene with its bundles and worlds, ready to run. Clones share them.
#[derive(Clone, Debug)]
pub struct CompiledScene {
    pub(crate) scene: Arc<Scene>,
    /// Bundle of each group; `None` for a group without one.
    bundles: Vec<Option<Bundle>>,
    /// Rules, events and graphs of agents, where the scene has any.
    scenario: Option<Arc<Scenario>>,
    /// Expectations, where the scene has any.
    pub(crate) expected: Option<Arc<Scenario>>,
    /// Stitched worlds, each once.
    worlds: Vec<OpenWorld>,
    /// World of each group, by its number; `None` for a group without one.
    world_of: Vec<Option<usize>>,
}

/// A stitched world of a scene.
#[derive(Clone, Debug)]
pub struct OpenWorld {
    /// Path of its file.
    pub path: PathBuf,
    /// The world: file, graph and path costs.
    pub world: World,
}

impl Scene {
    /// Opens every bundle and world that the scene names, and finds all names in them.
    ///
    /// # Errors
    /// As [`Scene::check`], and [`throng_base::Error::Text`] for files that cannot be opened and for names that a bundle does not have, with those that
    /// it has.
    pub fn open(&self) -> Result<CompiledScene> {
        self.compile_with(None, &ActionRegistry::default())
    }

    /// Opens the scene as [`Scene::open`] does, with primitive behaviours of the application.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn open_with(&self, primitives: &ActionRegistry) -> Result<CompiledScene> {
        self.compile_with(None, primitives)
    }

    /// Opens the scene as [`Scene::open`] does, with a bundle in place of its own; groups with bundles of their own keep them.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn compile(&self, bundle: &Bundle) -> Result<CompiledScene> {
        self.compile_with(Some(bundle), &ActionRegistry::default())
    }

    /// Compiles rules, graphs, events and places without keeping them: to check them, or to measure the time that this takes.
    ///
    /// # Errors
    /// As [`Scene::open`], of rules, graphs, events and places.
    pub fn compile_story(&self) -> Result<()> {
        Scenario::new(self, &ActionRegistry::default()).map(|_| ())
    }

    fn compile_with(&self, own: Option<&Bundle>, primitives: &ActionRegistry) -> Result<CompiledScene> {
        // The application may have changed the scene since it was read and checked.
        self.check()?;
        let mut opened: Vec<(PathBuf, Bundle)> = Vec::new();
        let scenario = Scenario::new(self, primitives)?.map(Arc::new);
        let expected = match (&scenario, self.expect.is_empty()) {
            (_, true) => None,
            (Some(scenario), _) => Some(scenario.clone()),
            (None, _) => Some(Arc::new(Scenario::compile(self, primitives)?)),
        };
        let (bundles, worlds, world_of) = Default::default();
        let mut out = CompiledScene { scene: Arc::new(self.clone()), bundles, scenario, expected, worlds, world_of };
        for (g, group) in self.groups.iter().enumerate() {
            let own = own.filter(|_| group.bundle.is_none());
            let bundle = match (self.bundle_of(g).0, own) {
                _ if group.motion == GroupMotion::None => None,
                (_, Some(bundle)) => Some(bundle.clone()),
                (None, None) => None,
                (Some(path), None) => Some(open_bundle(self, g, path, &mut opened)?),
            };
            out.bundles.push(bundle);
            let world = match self.world_of(g).0 {
                Some(path) if group.motion == GroupMotion::Patches => Some(out.open_world(g, path)?),
                _ => None,
            };
            out.world_of.push(world);
            out.check_names(g)?;
        }
        let blended = self.groups.iter().position(|g| !g.spaces.is_empty());
        for (i, shown) in self.picture.shown.iter().enumerate() {
            if let Some(g) = blended {
                let key = format!("picture.shown[{i}].space");
                out.bundle(g)?.find_blend(&shown.space).map_err(|e| self.fault(&key, e))?;
            }
        }
        Ok(out)
    }
}

/// Opens a bundle, or returns it where it is open already.
fn open_bundle(scene: &Scene, g: usize, path: &Path, opened: &mut Vec<(PathBuf, Bundle)>) -> Result<Bundle> {
    if let Some((_, bundle)) = opened.iter().find(|o| o.0 == path) {
        return Ok(bundle.clone());
    }
    let key = if scene.groups[g].bundle.is_some() { format!("groups[{g}].bundle") } else { "bundle".into() };
    let help = "build it with `throng build`, or let `throng run` build it from `config`";
    let bundle = Bundle::open(path).map_err(|e| scene.fault(&key, format!("{}: {e}; {help}", path.display())))?;
    opened.push((path.to_path_buf(), bundle.clone()));
    Ok(bundle)
}

impl CompiledScene {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Rules, events and graphs of agents; `None` where the scene has only goals.
    pub fn scenario(&self) -> Option<&Arc<Scenario>> {
        self.scenario.as_ref()
    }

    /// Motion tags of actions that some bundle of agents with bodies lacks, in words.
    pub fn missing_motion(&self) -> Vec<String> {
        let motions = self.scenario.as_ref().map_or(&[] as &[String], |s| s.motion_tags());
        let groups = self.scene.groups.iter().enumerate().filter(|(_, g)| g.is_of_agents());
        let bundles: Vec<&Bundle> = groups.filter_map(|(g, _)| self.bundles[g].as_ref()).collect();
        let has = |bundle: &Bundle, tag: &str| bundle.meta().activities.iter().any(|a| a.tag == tag);
        let is_missing = |tag: &&String| !bundles.is_empty() && !bundles.iter().all(|b| has(b, tag));
        motions.iter().filter(is_missing).map(|tag| format!("`{tag}`: those who do it stand meanwhile")).collect()
    }

    /// Content hash of the scene, its bundles and its worlds; their paths do not count.
    pub fn hash(&self) -> u128 {
        let mut hash = Hash128::default();
        hash.add_bytes(self.scene.content().as_bytes());
        let bundles = self.bundles.iter().map(|b| b.as_ref().map_or(0, Bundle::hash));
        let worlds = self.world_of.iter().map(|w| w.map_or(0, |w| self.worlds[w].world.hash()));
        bundles.chain(worlds).for_each(|of| hash.add_bytes(&of.to_le_bytes()));
        hash.finish()
    }

    /// The bundle of a group.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] where the group has none.
    pub fn bundle(&self, group: usize) -> Result<&Bundle> {
        self.find_bundle(group)
            .ok_or_else(|| self.scene.fault(&format!("groups[{group}]"), "expected a `bundle`, found none"))
    }

    /// The bundle of a group, if it has one.
    pub fn find_bundle(&self, group: usize) -> Option<&Bundle> {
        self.bundles.get(group).and_then(Option::as_ref)
    }

    /// The world of a group of patches.
    pub fn world(&self, group: usize) -> Option<&OpenWorld> {
        self.world_number(group).map(|w| &self.worlds[w])
    }

    /// Groups in the same world have the same number.
    pub(crate) fn world_number(&self, group: usize) -> Option<usize> {
        self.world_of.get(group).copied().flatten()
    }

    /// Number of a group's first character, counted over all groups with the same kind of motion; random choices depend on
    /// it and on the seed.
    pub(crate) fn first_number(&self, group: usize) -> usize {
        let groups = &self.scene.groups;
        let is_alike =
            |g: &&GroupConfig| (g.motion, g.paths.is_some()) == (groups[group].motion, groups[group].paths.is_some());
        groups[..group].iter().filter(is_alike).map(|g| g.count).sum()
    }

    /// True for two groups of characters with policies that are on the way to goals, and choose on one bundle alike.
    pub(crate) fn travel_together(&self, a: usize, b: usize) -> bool {
        let groups = &self.scene.groups;
        let travels = |g: usize| groups[g].motion == GroupMotion::Policy && groups[g].goal.is_some();
        let hash = |g: usize| self.find_bundle(g).map(Bundle::hash);
        travels(a) && travels(b) && hash(a) == hash(b) && groups[a].temperature == groups[b].temperature
    }

    /// One of the blend spaces that a group names.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] with the names that there are.
    pub(crate) fn blend_space(&self, group: usize, number: usize) -> Result<BlendSpace> {
        let name = &self.scene.groups[group].spaces[number];
        let space = self.bundle(group)?.blend(name);
        space.map_err(|e| self.scene.fault(&format!("groups[{group}].spaces[{number}]"), e))
    }

    fn open_world(&mut self, g: usize, path: &Path) -> Result<usize> {
        if let Some(known) = self.worlds.iter().position(|w| w.path == path) {
            return Ok(known);
        }
        let bundle = self.bundle(g)?;
        let is_own = self.scene.groups[g].world.is_some();
        let key = if is_own { format!("groups[{g}].world") } else { "environment.world".into() };
        let help = "stitch it with `throng stitch`, or let `throng run` stitch it from `world_config`";
        let fault = |e: throng_base::Error| self.scene.fault(&key, format!("{e}; {help}"));
        let world = World::open(path, bundle).map_err(fault)?;
        self.worlds.push(OpenWorld { path: path.to_path_buf(), world });
        Ok(self.worlds.len() - 1)
    }

    /// Finds all names of a group in its bundle.
    fn check_names(&self, g: usize) -> Result<()> {
        let group = &self.scene.groups[g];
        for (i, behaviour) in group.behaviours.iter().enumerate() {
            let found = self.bundle(g)?.find_policy(&behaviour.name);
            found.map_err(|e| self.scene.fault(&format!("groups[{g}].behaviours[{i}].name"), e))?;
        }
        for t in 0..group.spaces.len() {
            self.blend_space(g, t)?;
        }
        for (i, w) in group.goals.iter().enumerate() {
            let InhabitantGoalConfig::Perform { tag, with, .. } = &w.goal else { continue };
            let key = |name: &str| format!("groups[{g}].goals[{i}].goal.perform.{name}");
            let [alone, together] = self.performable_tags(g)?;
            let (tags, others, hint) = match with {
                Some(_) => (&together, &alone, "; one person does that alone: leave out `with`"),
                None => (&alone, &together, "; two do that together: add `with = \"partner\"`"),
            };
            if !tags.contains(&tag.as_str()) {
                let hint = if others.contains(&tag.as_str()) { hint } else { "" };
                let why = format!("expected one of {}, found `{tag}`{hint}", tags.join(", "));
                return Err(self.scene.fault(&key("tag"), why));
            }
            if let Some(with) = with.as_deref().filter(|w| *w != ANY_PARTNER) {
                let groups =
                    self.scene.groups.iter().filter(|o| o.motion == GroupMotion::Patches && !o.name.is_empty());
                let names: Vec<&str> = groups.map(|o| o.name.as_str()).collect();
                if !names.contains(&with) {
                    let names = names.join(", ");
                    let why = format!(
                        "expected `{ANY_PARTNER}` or a group with `motion = \"patches\"` ({names}), found `{with}`"
                    );
                    return Err(self.scene.fault(&key("with"), why));
                }
            }
        }
        Ok(())
    }

    /// Tags of a group's motion: those for one character alone, and those for two together.
    fn performable_tags(&self, g: usize) -> Result<[Vec<&str>; 2]> {
        let bundle = self.bundle(g)?;
        let tags = &bundle.meta().link_tags;
        let mut are_shown = [vec![false; tags.len()], vec![false; tags.len()]];
        for link in bundle.patches().links.iter().filter(|l| l.tag != 0) {
            let number = usize::from(link.tag & !LinkRecord::FOR_TWO) - 1;
            are_shown[usize::from(link.is_for_two())][number] = true;
        }
        Ok(are_shown.map(|shown| tags.iter().zip(shown).filter(|(_, s)| *s).map(|(t, _)| t.as_str()).collect()))
    }
}
