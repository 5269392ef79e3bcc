//! Levels of scenes: their borders become walls, and their named places those of the scene.

use super::{GoalConfig, ObstacleConfig, Scene, SiteConfig, SpaceConfig, WallConfig};
use serde::{Deserialize, Serialize};
use std::{collections::HashMap, path::PathBuf};
use throng_base::Result;
use throng_level::Level;

/// Height of walls in pictures (m).
const WALL_M: f32 = 2.5;
/// Radius of a level's places (m).
const PLACE_M: f32 = 2.0;
/// Heights within which walls and places are on a floor (m).
const FLOOR_M: f32 = 1.2;

/// Level of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneLevelConfig {
    /// Level (`.level`), relative to this file's folder; `throng level` makes it of a mesh or a plan.
    pub file: PathBuf,
    /// Height of the floor that people are on (m, -10000 to 10000).
    #[serde(default)]
    pub height_m: f32,
    /// True for people on all floors: groups of `motion = "policy"`, with places of the level to start at and to go to.
    #[serde(default)]
    pub all_floors: bool,
}

impl Scene {
    /// Takes walls and places from the level, if the scene has one.
    pub(super) fn add_level(&mut self) -> Result<()> {
        if let Some(config) = self.level.clone() {
            let key = "level.file";
            if config.file.extension().is_none_or(|e| e != "level") || !config.file.exists() {
                let made = config.file.with_extension("level");
                let why = match (made.exists(), config.file.exists()) {
                    (true, true) => format!("expected a level; name \"{}\"", made.display()),
                    _ => "expected a level (.level) that is there; make it with `throng level MESH --out FILE`".into(),
                };
                return Err(self.fault(key, why));
            }
            if self.environment.space != SpaceConfig::Ground {
                return Err(self.fault("level", "a level is ground, and the scene is in the air"));
            }
            let level = Level::open(&config.file).map_err(|e| self.fault(key, e))?;
            if config.all_floors && config.height_m != 0.0 {
                return Err(self.fault("level", "expected either `height_m` or `all_floors`, found both"));
            }
            match config.all_floors {
                true => self.check_level_places(&level)?,
                false => self.add_walls(&level, config.height_m)?,
            }
        }
        let places = self.places.iter().map(|p| (p.name.clone(), p.at.clone())).collect::<HashMap<_, _>>();
        for group in &mut self.groups {
            if let Some(GoalConfig::Place { name }) = &group.goal
                && let Some(at) = places.get(name)
            {
                group.goal = Some(GoalConfig::Point { at: at.clone() });
            }
        }
        Ok(())
    }

    /// Checks that the level has the places that groups name.
    fn check_level_places(&self, level: &Level) -> Result<()> {
        for (g, group) in self.groups.iter().enumerate() {
            let [starts, goals] = group.level_places();
            for (key, names) in [("place", starts), ("goal", goals)] {
                for name in names.into_iter().flatten() {
                    level.place(name).map_err(|e| self.fault(&format!("groups[{g}].{key}.level.names"), e))?;
                }
            }
        }
        Ok(())
    }

    fn add_walls(&mut self, level: &Level, height_m: f32) -> Result<()> {
        let is_near = |y: f32| (y - height_m).abs() < FLOOR_M;
        for wall in level.walls().iter().filter(|w| is_near(w.from[1]) || is_near(w.to[1])) {
            let points = [wall.from, wall.to].map(|[x, _, z]| vec![x, z]).to_vec();
            self.environment.obstacles.push(ObstacleConfig {
                grows: false,
                height_m: WALL_M,
                disc: None,
                mover: None,
                wall: Some(WallConfig { points, radius_m: 0.0 }),
                polygon: None,
                solid_box: None,
            });
        }
        let known: Vec<String> = self.places.iter().map(|p| p.name.clone()).collect();
        for place in level.places().filter(|p| is_near(p.at.y) && !known.iter().any(|k| k == p.name)) {
            let (at, kind, name) = (vec![place.at.x, place.at.z], place.kind.into(), place.name.into());
            let (radius_m, slots) = (PLACE_M, Vec::new());
            self.places.push(SiteConfig {
                name,
                kind,
                at,
                radius_m,
                guidepost: false,
                once: false,
                arrow: None,
                slots,
                queue: None,
            });
        }
        if !level.vertices().any(|at| is_near(at.y)) {
            let low = level.vertices().map(|at| at.y).fold(f32::INFINITY, f32::min);
            let why = format!("there is no ground at {height_m} m; the lowest is at {low:.1} m");
            return Err(self.fault("level.height_m", why));
        }
        Ok(())
    }
}
