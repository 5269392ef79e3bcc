//! Obstacles of a crowd, fixed and moving.

use super::check::{KeyFault, check_corners, check_numbers, check_point, key_fault};
use super::goal::scale_points;
use glam::Vec2;
use serde::{Deserialize, Serialize};
use throng_base::ground::ExternalObstacle;
use throng_crowd::{Obstacle, Space};

/// Least time between two points of a mover's path (s).
const LEAST_S: f64 = 1e-4;

/// Obstacle of agents.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ObstacleConfig {
    /// Whether its lengths are scaled with the layout of a scene that grows.
    #[serde(default = "yes")]
    pub grows: bool,
    /// Height in pictures, on the ground; agents never walk over it, however low it is (m, 0.01 to 20).
    #[serde(default = "height")]
    pub height_m: f32,
    /// Disc on the ground, ball in the air.
    pub disc: Option<DiscConfig>,
    /// Moving disc or ball, which stops for no agent.
    pub mover: Option<MoverConfig>,
    /// Wall along a line; in the air a rod or column.
    pub wall: Option<WallConfig>,
    /// Solid polygon, on the ground only.
    pub polygon: Option<PolygonConfig>,
    /// Solid box along the axes.
    #[serde(default, rename = "box")]
    pub solid_box: Option<BoxConfig>,
}

throng_base::key_defaults! {
    height: f32 = 0.35;
    yes: bool = true;
}

/// A disc or ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DiscConfig {
    /// Centre (m).
    pub centre: Vec<f32>,
    /// Radius (m, 0.01 to 1000).
    pub radius_m: f32,
}

/// Disc or ball that moves through points, at constant speed between two of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MoverConfig {
    /// Radius (m, 0.01 to 1000).
    pub radius_m: f32,
    /// Path: positions with times (>= 1).
    pub path: Vec<PathPoint>,
}

/// Position at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PathPoint {
    /// Time (s, >= 0, ascending by 0.0001 or more).
    pub time_s: f64,
    /// Position (m).
    pub at: Vec<f32>,
}

/// A wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WallConfig {
    /// Points that the wall connects (m, >= 2).
    pub points: Vec<Vec<f32>>,
    /// Radius: half the thickness of a wall, the radius of a column (m, 0 to 1000).
    #[serde(default)]
    pub radius_m: f32,
}

/// A polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PolygonConfig {
    /// Corners in order around it (m, >= 3).
    pub corners: Vec<Vec<f32>>,
}

/// A box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BoxConfig {
    /// Lowest corner (m).
    pub from: Vec<f32>,
    /// Highest corner (m).
    pub to: Vec<f32>,
}

impl ObstacleConfig {
    pub(super) fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        let Self { disc, mover, wall, polygon, solid_box, .. } = self;
        let kinds = [disc.is_some(), mover.is_some(), wall.is_some(), polygon.is_some(), solid_box.is_some()];
        let num = kinds.iter().filter(|k| **k).count();
        if num != 1 {
            return key_fault(key, format!("expected one of disc, mover, wall, polygon and box, found {num}"));
        }
        check_numbers(&[(&format!("{key}.height_m"), self.height_m, 0.01, 20.0)])?;
        if let Some(d) = &self.disc {
            check_point(&format!("{key}.disc.centre"), &d.centre, dimensions)?;
            check_numbers(&[(&format!("{key}.disc.radius_m"), d.radius_m, 0.01, 1000.0)])?;
        }
        if let Some(m) = &self.mover {
            m.find_fault(&format!("{key}.mover"), dimensions)?;
        }
        if let Some(w) = &self.wall {
            check_points(&format!("{key}.wall.points"), &w.points, 2, dimensions)?;
            check_numbers(&[(&format!("{key}.wall.radius_m"), w.radius_m, 0.0, 1000.0)])?;
        }
        if let Some(p) = &self.polygon {
            if dimensions != 2 {
                return key_fault(&format!("{key}.polygon"), "expected none in the air: use boxes, walls or discs");
            }
            check_points(&format!("{key}.polygon.corners"), &p.corners, 3, dimensions)?;
        }
        if let Some(b) = &self.solid_box {
            check_corners(&format!("{key}.box"), &b.from, &b.to, dimensions)?;
        }
        Ok(())
    }

    pub(super) fn stretch(&mut self, by: f32) {
        let Self { disc, mover, wall, polygon, solid_box, .. } = self;
        let centres = disc.iter_mut().map(|d| &mut d.centre);
        let paths = mover.iter_mut().flat_map(|m| &mut m.path).map(|w| &mut w.at);
        let walls = wall.iter_mut().flat_map(|w| &mut w.points);
        let corners = polygon.iter_mut().flat_map(|p| &mut p.corners);
        let ends = solid_box.iter_mut().flat_map(|b| [&mut b.from, &mut b.to]);
        centres.chain(paths).chain(walls).chain(corners).chain(ends).for_each(|p| scale_points(&mut [p], by));
    }

    /// Obstacles for the crowd; a wall of several lines is several obstacles.
    pub fn obstacles<V: Space>(&self) -> Vec<Obstacle<V>> {
        let mut out = Vec::new();
        if let Some(d) = &self.disc {
            out.push(Obstacle::Ball { centre: to_point(&d.centre), radius: d.radius_m });
        }
        if let Some(m) = &self.mover {
            let path = m.path.iter().map(|w| (w.time_s, to_point(&w.at))).collect();
            out.push(Obstacle::Mover { path, radius: m.radius_m });
        }
        if let Some(w) = &self.wall {
            let corners: Vec<V> = w.points.iter().map(|p| to_point(p)).collect();
            out.extend(corners.windows(2).map(|l| Obstacle::Wall { from: l[0], to: l[1], radius: w.radius_m }));
        }
        if let Some(p) = &self.polygon {
            out.push(Obstacle::Polygon { corners: p.corners.iter().map(|c| to_point(c)).collect() });
        }
        if let Some(b) = &self.solid_box {
            out.push(Obstacle::Box { min: to_point(&b.from), max: to_point(&b.to) });
        }
        out
    }
}

impl MoverConfig {
    /// Position and velocity at a time, as an external obstacle.
    pub(crate) fn obstacle_at(&self, time_s: f64) -> ExternalObstacle {
        let next = self.path.partition_point(|w| w.time_s <= time_s);
        let place = |k: usize| to_point::<Vec2>(&self.path[k].at);
        let (before, after) = (next.saturating_sub(1), next.min(self.path.len() - 1));
        let whole_s = self.path[after].time_s - self.path[before].time_s;
        let (mut at, mut velocity) = (place(before), Vec2::ZERO);
        if whole_s > 0.0 {
            velocity = (place(after) - at) / whole_s as f32;
            at += velocity * (time_s - self.path[before].time_s) as f32;
        }
        ExternalObstacle { place: at, velocity, radius_m: self.radius_m }
    }

    fn find_fault(&self, key: &str, dimensions: usize) -> Result<(), KeyFault> {
        check_numbers(&[(&format!("{key}.radius_m"), self.radius_m, 0.01, 1000.0)])?;
        if self.path.is_empty() {
            return key_fault(&format!("{key}.path"), "expected at least 1 point, found none");
        }
        for (i, w) in self.path.iter().enumerate() {
            check_point(&format!("{key}.path[{i}].at"), &w.at, dimensions)?;
            if !(0.0..1e6).contains(&w.time_s) || i > 0 && w.time_s - self.path[i - 1].time_s < LEAST_S {
                let why = format!("expected times that ascend from 0 by {LEAST_S} s or more, found {}", w.time_s);
                return key_fault(&format!("{key}.path[{i}].time_s"), why);
            }
        }
        Ok(())
    }
}

fn check_points(key: &str, points: &[Vec<f32>], least: usize, dimensions: usize) -> Result<(), KeyFault> {
    if points.len() < least {
        return key_fault(key, format!("expected at least {least} points, found {}", points.len()));
    }
    points.iter().enumerate().try_for_each(|(i, p)| check_point(&format!("{key}[{i}]"), p, dimensions))
}

/// Point of a checked scene.
pub(crate) fn to_point<V: Space>(of: &[f32]) -> V {
    V::from_coordinates([of[0], of[1], of.get(2).copied().unwrap_or(0.0)])
}
