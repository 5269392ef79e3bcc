//! The stage of a page: people that walk to targets, or agents that cross a square.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use throng_base::limits::{CAPACITY, COORDINATE, STEP_S};
use throng_base::{Inline, Result};
use throng_core::characters::{
    AvoidConfig, CharactersConfig, MotionSet, PolicyCharacters, PolicyOrder, PoseInstance, SampleJob, Spawn,
    uniform_random,
};
use throng_core::{Bundle, CharacterGroup, Joint, Mat3x4, NUM_JOINTS, Planar};
use throng_crowd::{Agent, AtEnd, Crowd, CrowdError, CrowdSetup, Route};

/// Number of targets at which people gather.
const NUM_TARGETS: usize = 6;
/// Approximate distance between people at one target (m).
const GATHER_SPACING_M: f32 = 0.9;
/// Side of each agent's square of ground (m).
const SPACING_M: f32 = 2.2;

/// An open bundle, and the people or agents that move.
#[derive(Debug)]
pub struct PageStage {
    bundle: Bundle,
    /// Joints in model space of every frame row (rows * NUM_JOINTS).
    pub rows: Vec<Mat3x4>,
    crowd: PageCrowd,
    /// Record of each character.
    pub records: Vec<PoseInstance>,
}

/// People or agents that move.
#[derive(Debug)]
pub enum PageCrowd {
    /// No characters.
    Nobody,
    /// People of a policy, each sent beside one of a few targets.
    People {
        /// The characters.
        group: Box<PolicyCharacters>,
        /// Targets at which they gather (m).
        targets: [Vec2; NUM_TARGETS],
        /// Number of the policy.
        policy: usize,
    },
    /// Agents without bodies.
    Agents(Box<Crowd>),
}

impl PageStage {
    /// Opens a bundle that lies in memory.
    ///
    /// # Errors
    /// The fault of the bundle.
    pub fn open(bytes: &[u8]) -> std::result::Result<Self, String> {
        let bytes = throng_core::format::AlignedBytes::from_slice(bytes);
        let bundle = Bundle::from_bytes(bytes).map_err(|e| e.to_string())?;
        let motion_set = &MotionSet::new(&bundle);
        let frames: Vec<u32> = (0..bundle.frames().len() as u32).collect();
        let mut rows = vec![Mat3x4::default(); frames.len() * NUM_JOINTS];
        let (frames, ratios) = (&frames[..], &vec![0.0; frames.len()][..]);
        SampleJob { motion_set, frames, ratios, matrices: &mut rows }.run().map_err(|e| e.to_string())?;
        Ok(Self { bundle, rows, crowd: PageCrowd::Nobody, records: Vec::new() })
    }

    /// Positions of joints at rest, in model space (m).
    pub fn rest_positions(&self) -> [Vec3; NUM_JOINTS] {
        self.bundle.skeleton().rest_positions()
    }

    /// The number of each joint's parent; -1 for the first.
    pub fn joint_parents() -> [i32; NUM_JOINTS] {
        Joint::ALL.map(|j| j.parent().map_or(-1, |p| p.index() as i32))
    }

    /// Places a number of people on a square that walk to targets and avoid each other.
    ///
    /// # Errors
    /// If the bundle has no policy, or a number is out of its range.
    pub fn spawn_people(&mut self, count: usize, seed: u64) -> Result<()> {
        let policy = self.bundle.find_policy("approach")?;
        let avoid = Some(AvoidConfig::default());
        let config = CharactersConfig { seed, avoid, instances: true, ..CharactersConfig::default() };
        let mut group = PolicyCharacters::with_capacity(&self.bundle, count, config)?;
        let side = (count as f32).sqrt().ceil().max(1.0);
        group.hold_entrants();
        for k in 0..count {
            let place = |at: f32| SPACING_M * (at - 0.5 * (side - 1.0));
            let heading = TAU * uniform_random(seed, k as u64, 0);
            let (x, z) = (place(k as f32 % side), place((k as f32 / side).floor()));
            group.spawn(Spawn::standing_at(Planar::new(x, z, heading)))?;
        }
        group.release_entrants();
        let targets = std::array::from_fn(|t| {
            let angle = TAU * t as f32 / NUM_TARGETS as f32;
            0.35 * side * SPACING_M * Vec2::new(throng_base::maths::sin(angle), throng_base::maths::cos(angle))
        });
        self.crowd = PageCrowd::People { group: Box::new(group), targets, policy };
        self.send_people()?;
        self.step(0.0).map_err(|why| throng_base::Error::Unknown { what: "step", name: why, known: Vec::new() })
    }

    /// Places a number of agents that cross a square in two streams, again and again.
    ///
    /// # Errors
    /// [`CrowdError`] for numbers out of range.
    pub fn spawn_agents(&mut self, count: usize, seed: u64) -> std::result::Result<(), CrowdError> {
        CAPACITY.check_count("count", count)?;
        let side = ((count as f32).sqrt().ceil().max(4.0) * SPACING_M).ceil();
        let lanes = 24;
        let line = |k: usize| side * ((k as f32 + 0.5) / lanes as f32 - 0.5);
        let half = 0.5 * side + 3.0;
        let between = |a: Vec3, b: Vec3| Route { subgoals: vec![a, b], arrival_radius: 1.5, at_end: AtEnd::Again };
        let across = (0..lanes).map(|k| between(Vec3::new(-half, 0.0, line(k)), Vec3::new(half, 0.0, line(k))));
        let along = (0..lanes).map(|k| between(Vec3::new(line(k), 0.0, -half), Vec3::new(line(k), 0.0, half)));
        let columns = (count as f32).sqrt().ceil() as usize;
        let agent = |k: usize| {
            let place = |at: usize, draw: u64| {
                SPACING_M * (at as f32 - 0.5 * (columns - 1) as f32) + uniform_random(seed, k as u64, draw) - 0.5
            };
            let at = Vec3::new(place(k % columns, 0), 0.0, place(k / columns, 1));
            let route = (uniform_random(seed, k as u64, 2) * 2.0 * lanes as f32) as usize;
            let speed = 1.1 + 0.5 * uniform_random(seed, k as u64, 3);
            Agent { route: Some(route.min(2 * lanes - 1)), speed, ..Agent::standing_at(at) }
        };
        let routes = across.chain(along).collect();
        let setup = CrowdSetup { agents: (0..count).map(agent).collect(), routes, ..CrowdSetup::default() };
        self.crowd = PageCrowd::Agents(Box::new(Crowd::on_ground(setup)?));
        self.records.clear();
        self.records.resize(count, PoseInstance::default());
        self.write_agent_records();
        Ok(())
    }

    /// Targets at which people gather (m).
    pub fn targets(&self) -> &[Vec2] {
        if let PageCrowd::People { targets, .. } = &self.crowd { targets } else { &[] }
    }

    /// Moves a target.
    ///
    /// # Errors
    /// If the place is not finite, or far away.
    pub fn move_target(&mut self, number: usize, to: Vec2) -> Result<()> {
        to.to_array().iter().try_for_each(|&v| COORDINATE.check("target", None, v))?;
        if let PageCrowd::People { targets, .. } = &mut self.crowd
            && let Some(target) = targets.get_mut(number)
        {
            *target = to;
            self.send_people()?;
        }
        Ok(())
    }

    /// Sends each of the people to its own place near a target, on a spiral of the golden angle.
    fn send_people(&mut self) -> Result<()> {
        let PageCrowd::People { group, targets, policy } = &mut self.crowd else { return Ok(()) };
        for (k, id) in group.ids().to_vec().into_iter().enumerate() {
            let (target, ring) = (targets[k % NUM_TARGETS], (k / NUM_TARGETS) as f32);
            let (angle, radius) = (ring * PI * (3.0 - 5.0_f32.sqrt()), GATHER_SPACING_M * ring.sqrt());
            let by = radius * Vec2::new(throng_base::maths::sin(angle), throng_base::maths::cos(angle));
            let place = Vec3::new(target.x + by.x, 0.0, target.y + by.y);
            group.order(id, PolicyOrder::towards(*policy, place))?;
        }
        Ok(())
    }

    /// Steps the simulation by a duration (s).
    ///
    /// # Errors
    /// The message of the runtime.
    pub fn step(&mut self, dt_s: f32) -> std::result::Result<(), String> {
        match &mut self.crowd {
            PageCrowd::Nobody => self.records.clear(),
            PageCrowd::People { group, .. } => {
                group.step(dt_s, &Inline).map_err(|e| e.to_string())?;
                self.records.clear();
                self.records.extend(group.instances());
            }
            PageCrowd::Agents(crowd) => {
                STEP_S.check("dt_s", None, dt_s).map_err(|e| e.to_string())?;
                let until = crowd.time_s() + f64::from(dt_s);
                crowd.advance(until, &mut |_| ()).map_err(|e| e.to_string())?;
                self.write_agent_records();
            }
        }
        Ok(())
    }

    /// Writes positions and headings of agents to the records; a standing agent keeps its heading.
    fn write_agent_records(&mut self) {
        let PageCrowd::Agents(crowd) = &self.crowd else { return };
        let now = crowd.time_s();
        for (record, id) in self.records.iter_mut().zip(crowd.ids()) {
            let at = crowd.position(id, now).unwrap_or_default();
            let ahead = crowd.smooth_velocity(id).unwrap_or_default();
            (record.x, record.z, record.variant) = (at.x, at.z, id.index);
            if ahead.length() > 0.1 {
                record.heading = throng_base::maths::atan2(ahead.x, ahead.z);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage() -> PageStage {
        let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/golden/tables_v");
        let path = format!("{golden}{}.throng", throng_core::format::VERSION);
        PageStage::open(&std::fs::read(path).expect("the golden bundle")).expect("opened")
    }

    #[test]
    fn people_come_nearer_to_a_target_that_is_moved() {
        let mut stage = stage();
        stage.spawn_people(60, 3).expect("people");
        let to = Vec2::new(9.0, -14.0);
        stage.move_target(2, to).expect("moved");
        let far = |stage: &PageStage| -> f32 {
            let of_target = stage.records.iter().skip(2).step_by(NUM_TARGETS);
            of_target.map(|r| Vec2::new(r.x, r.z).distance(to)).sum::<f32>() / 10.0
        };
        let before = far(&stage);
        (0..300).for_each(|_| stage.step(1.0 / 60.0).expect("a step"));
        assert!(far(&stage) < before - 2.0, "{before} {}", far(&stage));
        let targets = stage.targets().to_vec();
        assert!(stage.move_target(0, Vec2::NAN).is_err() && stage.targets() == targets);
        stage.move_target(1, to).expect("what is refused changes nothing");
    }

    #[test]
    fn agents_cross_and_look_where_they_go() {
        let mut stage = stage();
        stage.spawn_agents(200, 5).expect("agents");
        let before = stage.records.clone();
        (0..120).for_each(|_| stage.step(1.0 / 30.0).expect("a step"));
        let moved = stage.records.iter().zip(&before).filter(|(a, b)| Vec2::new(a.x - b.x, a.z - b.z).length() > 1.0);
        assert!(moved.count() > 150);
        assert!(stage.targets().is_empty());
        assert!(stage.step(1e8).is_err() && stage.step(f32::NAN).is_err());
        assert!(stage.spawn_agents(usize::MAX, 5).is_err() && stage.step(0.1).is_ok());
    }

    #[test]
    fn what_is_no_bundle_is_told() {
        let fault = PageStage::open(b"no bundle").expect_err("nine bytes");
        assert!(fault.contains("Throng"), "{fault}");
    }
}
