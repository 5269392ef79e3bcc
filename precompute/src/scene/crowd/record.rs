//! What a run of a crowd leaves to be drawn.

use super::config::{CrowdScene, CrowdSpace};
use super::live::Live;
use glam::Vec3;
use throng_runtime::crowd::{Obstacle, Space};

/// Moments that are kept, the first and the last included.
const MOMENTS: usize = 4;
/// Time between points of a trail. [Unit: s]
pub const TRAIL_S: f64 = 0.4;
/// Members whose trails and ways are kept, spread over everybody.
const TRAILED: usize = 2000;

/// What is seen of a member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenMember {
    /// Its centre in the world; y is 0 on the ground. [Unit: m]
    pub at: Vec3,
    /// How it moves. [Unit: m/s]
    pub velocity: Vec3,
    /// It knows of a happening.
    pub knows: bool,
}

/// Everybody at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrowdMoment {
    /// When. [Unit: s]
    pub time_s: f64,
    /// Everybody; `None` where one has left. [Size: members]
    pub members: Vec<Option<SeenMember>>,
}

/// An obstacle in the world.
#[derive(Clone, Debug, PartialEq)]
pub enum SeenObstacle {
    /// Disc or ball.
    Ball {
        /// [Unit: m]
        centre: Vec3,
        /// [Unit: m]
        radius: f32,
    },
    /// All within `radius` of a line.
    Wall {
        /// [Unit: m]
        from: Vec3,
        /// [Unit: m]
        to: Vec3,
        /// [Unit: m]
        radius: f32,
    },
    /// On the ground. [Unit: m]
    Polygon(Vec<Vec3>),
    /// Along the axes, between two corners. [Unit: m]
    Box(Vec3, Vec3),
    /// On its way through points, as (time, place). [Unit: s, m]
    Mover {
        /// In order of time.
        way: Vec<(f64, Vec3)>,
        /// [Unit: m]
        radius: f32,
    },
}

/// What a run leaves to be drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CrowdRecord {
    /// True in the air.
    pub in_the_air: bool,
    /// Names of groups.
    pub names: Vec<String>,
    /// Of each member: its group.
    pub groups: Vec<usize>,
    /// Of each member. [Unit: m]
    pub radii: Vec<f32>,
    /// Moments, in order of time.
    pub moments: Vec<CrowdMoment>,
    /// Of some members: its number, and where it was, every 0.4 s. [Unit: m]
    pub trails: Vec<(usize, Vec<Vec3>)>,
    /// Of the same members: corners of their ways. [Unit: m]
    pub ways: Vec<Vec<Vec3>>,
    /// What stands or moves in the way.
    pub obstacles: Vec<SeenObstacle>,
}

/// Fills a record.
#[derive(Clone, Debug)]
pub(super) struct Recorder {
    is_on: bool,
    record: CrowdRecord,
}

impl Recorder {
    pub fn new(is_on: bool, num_members: usize) -> Self {
        let every = num_members.div_ceil(TRAILED).max(1);
        let trails = (0..num_members).step_by(every).map(|m| (m, Vec::new())).collect();
        Self { is_on, record: CrowdRecord { trails, ..CrowdRecord::default() } }
    }

    pub fn observe<V: Space>(&mut self, live: &Live<V>, time_s: f64, seconds: f64) {
        if !self.is_on {
            return;
        }
        let (record, is_last) = (&mut self.record, time_s >= seconds);
        let due = seconds * record.moments.len() as f64 / (MOMENTS - 1) as f64;
        if is_last || time_s >= due && record.moments.len() < MOMENTS - 1 {
            let members = (0..live.num_members()).map(|m| seen(live, m, time_s)).collect();
            record.moments.push(CrowdMoment { time_s, members });
        }
        for (m, trail) in &mut record.trails {
            if is_last || time_s >= trail.len() as f64 * TRAIL_S {
                trail.extend(live.position(*m, time_s).map(in_world));
            }
        }
    }

    /// The record, with what does not change.
    pub fn finish<V: Space>(mut self, scene: &CrowdScene, live: &Live<V>) -> CrowdRecord {
        if !self.is_on {
            return CrowdRecord::default();
        }
        let layout = live.layout();
        let name = |(g, c): (usize, &super::GroupConfig)| match c.name.as_str() {
            "" => format!("group {g}"),
            name => name.into(),
        };
        self.record.in_the_air = scene.space == CrowdSpace::Air;
        self.record.names = scene.groups.iter().enumerate().map(name).collect();
        self.record.groups.clone_from(&layout.groups);
        self.record.radii = layout.setup.members.iter().map(|m| m.radius).collect();
        self.record.obstacles = layout.setup.obstacles.iter().filter_map(seen_obstacle).collect();
        let way = |(m, _): &(usize, Vec<Vec3>)| layout.ways[*m].iter().map(|&p| in_world(p)).collect();
        self.record.ways = self.record.trails.iter().map(way).collect();
        self.record
    }
}

fn seen<V: Space>(live: &Live<V>, m: usize, time_s: f64) -> Option<SeenMember> {
    let at = in_world(live.position(m, time_s)?);
    Some(SeenMember { at, velocity: in_world(live.velocity(m, time_s)?), knows: live.knows(m) > 0 })
}

/// A vector of a crowd as one of the world.
pub fn in_world<V: Space>(v: V) -> Vec3 {
    let [a, b, c] = v.coordinates();
    if V::DIMENSIONS == 2 { Vec3::new(a, 0.0, b) } else { Vec3::new(a, b, c) }
}

/// An obstacle as one of the world; none of a kind that is not known.
pub fn seen_obstacle<V: Space>(obstacle: &Obstacle<V>) -> Option<SeenObstacle> {
    Some(match obstacle {
        &Obstacle::Ball { centre, radius } => SeenObstacle::Ball { centre: in_world(centre), radius },
        &Obstacle::Wall { from, to, radius } => SeenObstacle::Wall { from: in_world(from), to: in_world(to), radius },
        Obstacle::Polygon { corners } => SeenObstacle::Polygon(corners.iter().map(|&c| in_world(c)).collect()),
        &Obstacle::Box { min, max } => SeenObstacle::Box(in_world(min), in_world(max)),
        Obstacle::Mover { way, radius } => {
            SeenObstacle::Mover { way: way.iter().map(|&(t, p)| (t, in_world(p))).collect(), radius: *radius }
        }
        _ => return None,
    })
}
