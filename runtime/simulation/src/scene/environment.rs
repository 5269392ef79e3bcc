//! Environment of a scene, and settings of agents.

use super::{obstacle::ObstacleConfig, story::DoorConfig, to_point};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use throng_base::ground::ReservedRegion;
use throng_crowd::{ForceField, Obstacle, Scheme};
use throng_geometry::Capsule2d;

/// Environment of a scene: space, obstacles, doors, ground and world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentConfig {
    /// Space of agents: points have two numbers on the ground (x, z) and three in the air (x, y, z) (m).
    pub space: SpaceConfig,
    /// Fixed and moving obstacles of agents.
    pub obstacles: Vec<ObstacleConfig>,
    /// Walls that open and close.
    pub doors: Vec<DoorConfig>,
    /// Hills of this height for groups on `paths`; 0 is level ground (m, 0 to 10).
    pub hills_m: f32,
    /// Stitched world of the groups of patches that name none of their own, relative to this file's folder.
    pub world: Option<PathBuf>,
    /// World file (TOML) that the world is stitched from where it is missing or older.
    pub world_config: Option<PathBuf>,
}

impl EnvironmentConfig {
    /// Heights of obstacles on the ground, part by part, as the crowd has them (m).
    pub fn heights_m(&self) -> impl Iterator<Item = f32> + '_ {
        self.on_ground().flat_map(|o| o.obstacles::<Vec2>().into_iter().map(|_| o.height_m))
    }

    /// Fixed obstacles on the ground as capsules (none in the air).
    pub(crate) fn walls(&self) -> Vec<Capsule2d> {
        let capsule = |from, to, radius_m| Capsule2d { from, to, radius_m };
        let around = |corners: &[Vec2]| -> Vec<Capsule2d> {
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            ends.map(|(&from, &to)| capsule(from, to, 0.0)).collect()
        };
        let of = |obstacle: Obstacle<Vec2>| match obstacle {
            Obstacle::Ball { centre, radius } => vec![capsule(centre, centre, radius)],
            Obstacle::Wall { from, to, radius } => vec![capsule(from, to, radius)],
            Obstacle::Polygon { corners } => around(&corners),
            Obstacle::Box { min, max } => around(&[min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)]),
            _ => Vec::new(),
        };
        self.on_ground().flat_map(|o| o.obstacles::<Vec2>()).flat_map(of).collect()
    }

    /// Fixed obstacles on the ground, and closed doors, as capsules (none in the air).
    ///
    /// - `open`: true for each door that is open.
    pub(crate) fn walls_and_closed_doors(&self, open: &[bool]) -> Vec<Capsule2d> {
        let closed = (0..self.doors.len()).filter(|&d| !open[d] && self.space == SpaceConfig::Ground);
        self.walls().into_iter().chain(closed.map(|d| self.door_wall(d))).collect()
    }

    /// Ground that a closed door takes (door < number of doors).
    pub(crate) fn door_wall(&self, door: usize) -> Capsule2d {
        let DoorConfig { from, to, radius_m, .. } = &self.doors[door];
        Capsule2d { from: to_point(from), to: to_point(to), radius_m: *radius_m }
    }

    /// Adds the moving obstacles on the ground at a time, and the ground that they reserve (none in the air).
    pub(crate) fn reserve_movers(&self, time_s: f64, out: &mut ReservedRegion) {
        for mover in self.on_ground().filter_map(|o| o.mover.as_ref()) {
            out.reserve_ahead(mover.obstacle_at(time_s));
        }
    }

    fn on_ground(&self) -> impl Iterator<Item = &ObstacleConfig> {
        self.obstacles.iter().filter(|_| self.space == SpaceConfig::Ground)
    }
}

/// Space in which agents move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum SpaceConfig {
    /// Discs, on the ground.
    #[default]
    Ground,
    /// Balls, in the air.
    Air,
}

impl SpaceConfig {
    /// Number of coordinates of a point.
    pub fn dimensions(self) -> usize {
        if self == Self::Ground { 2 } else { 3 }
    }
}

/// Settings of agents: how they avoid each other, and what they sense.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct AgentsConfig {
    /// Scheme that finds out when an agent has to act: events, occupancy or fixed.
    #[serde(with = "engine")]
    #[cfg_attr(feature = "schema", schemars(with = "String"))]
    pub engine: Scheme,
    /// Distance between the centres of two agents at which they tell each other news, and `meets` happens (m, 0.1 to 100).
    pub meeting_m: f32,
    /// Time that an agent takes to tell another one news; both have to stay near each other, without a wall or closed door between
    /// them; 0 tells at once, and through walls (s, 0 to 1000).
    pub telling_s: f32,
    /// Side of the smallest cells with blackboards; 0 for none (m, 0 to 1000).
    pub cell_m: f32,
    /// Whether paths lead around fixed obstacles; otherwise agents go straight and only avoid them.
    pub routes: bool,
    /// Parameters of the force field; those left out have their defaults.
    #[cfg_attr(feature = "schema", schemars(with = "std::collections::BTreeMap<String, f32>"))]
    pub field: ForceField,
}

impl Default for AgentsConfig {
    fn default() -> Self {
        Self {
            engine: Scheme::default(),
            meeting_m: 2.0,
            telling_s: 1.5,
            cell_m: 0.0,
            routes: true,
            field: ForceField::default(),
        }
    }
}

/// Names of schemes in files and reports.
pub mod engine {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};
    use throng_crowd::Scheme;

    /// All schemes with their names; those for comparison need the feature `baselines`.
    pub const ALL: &[(&str, Scheme)] = &[
        ("events", Scheme::Registration),
        ("occupancy", Scheme::Occupancy),
        #[cfg(feature = "fixed-steps")]
        ("fixed", Scheme::Fixed),
        #[cfg(feature = "fixed-steps")]
        ("pairs", Scheme::Pairs),
    ];

    /// Names of all schemes, for messages.
    pub fn names() -> String {
        ALL.iter().map(|e| e.0).collect::<Vec<_>>().join(", ")
    }

    /// Name of a scheme.
    pub fn name(scheme: Scheme) -> &'static str {
        ALL.iter().find(|e| e.1 == scheme).map_or("", |e| e.0)
    }

    /// Scheme of a name.
    pub fn scheme_named(name: &str) -> Option<Scheme> {
        ALL.iter().find(|e| e.0 == name).map(|e| e.1)
    }

    /// Serializes the name of a scheme.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<S: Serializer>(scheme: &Scheme, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(name(*scheme))
    }

    /// Deserializes a scheme from its name.
    ///
    /// # Errors
    /// A message with all known names.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Scheme, D::Error> {
        let text = String::deserialize(from)?;
        let known = names();
        scheme_named(&text).ok_or_else(|| D::Error::custom(format!("expected one of {known}, found \"{text}\"")))
    }
}
