//! Bodies that follow agents of a crowd.

use crate::motion_kind::{PART, check_snapshot, refused_snapshot, saved_bytes};
use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::{Deserialize, Serialize};
use throng_base::thresholds::{EYES_M, FACING_STANDS_MPS, WALKING_MPS};
use throng_base::{Bytes, Error, Executor, Result, maths, run_each};
use throng_core::walkers::{Control, Performance, WalkerStart, Walkers};
use throng_core::{CharacterGroup, Planar, PosedBodies, blend::ActivityId, body::ArmLayer};
use throng_crowd::{Crowd, Id};

/// Half-life of the distance of a body from the place where it stands still, or from its disc when it returns (s).
const ASIDE_HALF_LIFE_S: f32 = 0.15;

/// Height above the ground of what an arm points at (m).
const POINTED_M: f32 = 1.2;

/// Largest distance of a body that faces somebody or something from its disc (m).
const HELD_M: f32 = 0.2;

/// Speed below which people step aside without turning (m/s). Chosen: side-steps and back-steps are slower.
const STEPS_ASIDE_MPS: f32 = 0.7;
/// Half-life of the way that a slow body went (s), and length of it from which on the body faces where it went (m).
const WENT_HALF_LIFE_S: f32 = 0.5;
const WENT_M: f32 = 0.22;

/// Bodies of one blend space, row by row as their walkers.
#[derive(Clone, Debug)]
pub(crate) struct Troop {
    pub walkers: Walkers,
    /// Agent of each body.
    pub agents: Vec<Id>,
    controls: Vec<Control>,
    /// Standing offset of each body from its disc.
    still: Vec<StandingOffset>,
}

/// Offset of a body that stands still while its disc is pushed about, or that returns to its disc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct StandingOffset {
    /// Position at which it stands, x and z; `None` where it follows its disc (m).
    at: Option<Vec2>,
    /// Offset from the centre of its disc (m).
    off: Vec2,
    /// Way that the disc went of late, half of which is forgotten after [`WENT_HALF_LIFE_S`] (m).
    went: Vec2,
}

/// State that the next steps of a troop depend on, beside the crowd and the agents of the bodies.
#[derive(Serialize, Deserialize)]
pub(crate) struct SavedTroop {
    /// Last orders of the bodies.
    controls: Vec<Control>,
    still: Vec<StandingOffset>,
    walkers: Bytes,
}

impl Troop {
    /// Empty troop; allocates all memory that walkers of this capacity need.
    pub fn new(walkers: Walkers) -> Self {
        let room = walkers.capacity();
        let (controls, still) = (Vec::with_capacity(room), Vec::with_capacity(room));
        Self { walkers, agents: Vec::with_capacity(room), controls, still }
    }

    /// Gives an agent a body at its current position. It faces the direction of movement, or `ahead` where the agent is slow.
    ///
    /// - `num_bodies`: agents take the walkers' skeletons in turn, by their numbers in the crowd.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Full`].
    pub fn add_body(&mut self, crowd: &Crowd, agent: Id, ahead: Vec2, num_bodies: usize) -> Result<()> {
        let now = crowd.time_s();
        let motion = crowd.position(agent, now).zip(crowd.velocity(agent, now));
        let (at, velocity) = motion.map(|(at, v)| (at.xz(), v.xz())).ok_or(Error::Gone(agent))?;
        let ahead = if velocity.length() > WALKING_MPS { velocity } else { ahead };
        let heading = maths::atan2(ahead.x, ahead.y);
        let phase = (agent.index as f32 * 0.381_966).fract();
        let body = agent.index() % num_bodies;
        self.walkers.spawn(WalkerStart { body, root: Planar { x: at.x, z: at.y, heading }, phase })?;
        self.agents.push(agent);
        self.controls.push(standing_control(at, heading));
        self.still.push(StandingOffset::default());
        Ok(())
    }

    /// Gives the body of a row to another agent, at its current position (row < number of bodies).
    ///
    /// # Errors
    /// [`Error::Gone`].
    pub fn give_body(&mut self, row: usize, crowd: &Crowd, agent: Id) -> Result<()> {
        let at = crowd.position(agent, crowd.time_s()).ok_or(Error::Gone(agent))?.xz();
        self.agents[row] = agent;
        self.move_body(row, Planar { x: at.x, z: at.y, heading: self.walkers.bodies().roots[row].heading })
    }

    /// Removes the body of a row; the last body takes its row (row < number of bodies).
    pub fn remove_body(&mut self, row: usize) -> Result<()> {
        self.walkers.despawn(self.walkers.bodies().ids[row])?;
        self.agents.swap_remove(row);
        self.controls.swap_remove(row);
        self.still.swap_remove(row);
        Ok(())
    }

    /// Moves the body of a row to another place (row < number of bodies).
    pub fn move_body(&mut self, row: usize, root: Planar) -> Result<()> {
        self.controls[row] = standing_control(Vec2::new(root.x, root.z), root.heading);
        self.still[row] = StandingOffset::default();
        self.walkers.place(self.walkers.bodies().ids[row], root)
    }

    /// Orders the body of a row to turn to a direction, while its agent stands, and to look at eye height above a place; `None` to
    /// look ahead (row < number of bodies).
    pub fn order_gaze(&mut self, row: usize, ahead: Option<Vec2>, at: Option<Vec3>) {
        if let Some(ahead) = ahead.filter(|a| a.length_squared() > 1e-4) {
            self.controls[row].heading = Some(maths::atan2(ahead.x, ahead.y));
        }
        self.controls[row].layers.look_at = at.map(|at| at + Vec3::Y * EYES_M);
    }

    /// Position at which the body of a row stands while its agent faces somebody or something, once it has stopped: passers-by push
    /// its disc about, and do not turn the body away (m, row < number of bodies).
    ///
    /// - `disc`: centre of the agent's disc (m).
    pub fn held_position(&self, row: usize, disc: Vec2, speed_mps: f32) -> Option<Vec2> {
        let stands = self.still[row].at.is_some() || speed_mps < FACING_STANDS_MPS;
        let root = self.walkers.bodies().roots[row];
        stands.then(|| disc + (Vec2::new(root.x, root.z) - disc).clamp_length_max(HELD_M))
    }

    /// Orders the body of a row to stand still at a place (x, z), or to follow its disc again (m, row < number of bodies).
    pub fn order_stand(&mut self, row: usize, at: Option<Vec2>) {
        self.still[row].at = at;
    }

    /// Ends the reaching of all hands.
    pub fn free_hands(&mut self) {
        self.controls.iter_mut().for_each(|c| c.layers.arms = [None; 2]);
    }

    /// Orders a gesture of the arms that do not reach for something, aimed at a position, or none (m, row < number of bodies).
    pub fn order_gesture(&mut self, row: usize, gesture: Option<(ArmLayer, Option<Vec3>)>) {
        let arms = &mut self.controls[row].layers.arms;
        arms.iter_mut().filter(|arm| !matches!(arm, Some(ArmLayer::Reach { .. }))).for_each(|arm| *arm = None);
        let Some((arm, at)) = gesture else { return };
        let is_left = |at: Vec3| self.walkers.bodies().roots[row].inverse_transform_point(at.xz()).x > 0.0;
        let (arm, sides) = match (arm, at) {
            (ArmLayer::Point(_), Some(at)) => {
                (ArmLayer::Point(at + Vec3::Y * POINTED_M), if is_left(at) { 0..1 } else { 1..2 })
            }
            (ArmLayer::CarryBefore, _) => (arm, 0..2),
            _ => (arm, 1..2),
        };
        for side in sides {
            arms[side].get_or_insert(arm);
        }
    }

    /// Orders a hand of the body of a row (0 left, 1 right) to reach for something (row < number of bodies).
    pub fn order_reach(&mut self, row: usize, side: usize, reach: ArmLayer) {
        self.controls[row].layers.arms[side] = Some(reach);
    }

    /// Orders the body of a row to perform an activity (row < number of bodies).
    pub fn order_activity(&mut self, row: usize, performance: Option<Performance>) -> Result<()> {
        self.walkers.perform(self.walkers.bodies().ids[row], performance)
    }

    /// True for an activity that is performed once and not repeatedly: a greeting.
    pub fn is_played_once(&self, activity: ActivityId) -> bool {
        let tag = self.walkers.space().activities().get(activity).map_or("", |a| a.tag.as_str());
        tag.starts_with("greet") || tag.starts_with("handshake")
    }

    /// Advances all bodies to the current positions of their agents.
    pub fn step(&mut self, crowd: &Crowd, dt_s: f32, run: &dyn Executor) -> Result<()> {
        let now = crowd.time_s();
        let controls = self.controls.chunks_mut(PART).zip(self.still.chunks_mut(PART));
        let [keep, recall] = [ASIDE_HALF_LIFE_S, WENT_HALF_LIFE_S].map(|half_life| maths::exp2(-dt_s / half_life));
        run_each(run, self.agents.chunks(PART).zip(controls), |(agents, (controls, still))| {
            for ((&agent, control), still) in agents.iter().zip(controls).zip(still) {
                still.follow_agent(crowd, agent, now, control, [dt_s, recall]);
                still.displace_control(control, keep);
            }
        });
        for (row, &control) in self.controls.iter().enumerate() {
            self.walkers.order(self.walkers.bodies().ids[row], control)?;
        }
        self.walkers.step(dt_s, run)
    }

    /// Bodies of the walkers, with the ids of their agents.
    pub fn bodies(&self) -> PosedBodies<'_> {
        PosedBodies { ids: &self.agents, ..self.walkers.bodies() }
    }

    /// State that the next steps depend on.
    pub fn to_saved(&self) -> SavedTroop {
        let walkers = saved_bytes(|out| self.walkers.save(out));
        SavedTroop { controls: self.controls.clone(), still: self.still.clone(), walkers }
    }

    /// Restores a saved state of the same agents.
    ///
    /// # Errors
    /// [`Error::Snapshot`]; a part may have been loaded then.
    pub fn load(&mut self, saved: &SavedTroop) -> Result<()> {
        let SavedTroop { controls, still, walkers } = saved;
        let mut pairs = self.agents.iter().zip(controls);
        let is_finite =
            |s: &StandingOffset| s.off.is_finite() && s.went.is_finite() && s.at.is_none_or(Vec2::is_finite);
        let may_stand = still.len() == controls.len() && still.iter().all(is_finite);
        check_snapshot(may_stand, "bodies", "they stand where none can")?;
        if controls.len() != self.agents.len() || !pairs.all(|(&id, c)| self.walkers.check_order(id, c).is_ok()) {
            return Err(refused_snapshot("bodies", "their controls are impossible"));
        }
        self.walkers.load(&walkers.0)?;
        check_snapshot(self.walkers.len() == self.agents.len(), "bodies", "they are others")?;
        // The vector keeps its capacity.
        self.controls.clone_from(controls);
        self.still.clone_from(still);
        Ok(())
    }
}

impl StandingOffset {
    /// Updates the control of a body: to be at its agent's position and to move with it. Bodies of standing agents, and those that
    /// are held, keep their heading, those of agents that have left stay where they were.
    ///
    /// - `dt_s`, `recall`: duration of the step (s), and share of the way of late that is remembered after it.
    fn follow_agent(&mut self, crowd: &Crowd, agent: Id, time_s: f64, control: &mut Control, [dt_s, recall]: [f32; 2]) {
        let (Some(at), Some(velocity)) = (crowd.position(agent, time_s), crowd.smooth_velocity(agent)) else {
            control.velocity = Vec2::ZERO;
            return;
        };
        (control.position, control.velocity) = (Some(at.xz()), velocity.xz());
        self.went = self.went * recall + control.velocity * dt_s;
        if let Some(ahead) = self.facing(control.velocity).filter(|_| self.at.is_none()) {
            control.heading = Some(maths::atan2(ahead.x, ahead.y));
        }
    }

    /// Direction that a body faces: the one of its velocity, or where it is slow, of the way that it went; the same as before while
    /// others push it to and fro.
    fn facing(&self, velocity: Vec2) -> Option<Vec2> {
        match velocity.length() >= STEPS_ASIDE_MPS {
            true => Some(velocity),
            false => Some(self.went).filter(|went| went.length() > WENT_M),
        }
    }

    /// Displaces the position that a body is ordered to take.
    ///
    /// - `keep`: share of the distance that is left after a step.
    fn displace_control(&mut self, control: &mut Control, keep: f32) {
        let Some(disc) = control.position else { return };
        if self.at.is_some() {
            control.velocity = Vec2::ZERO;
        }
        let aim = self.at.map_or(Vec2::ZERO, |at| at - disc);
        let left = self.off - aim;
        self.off = aim + left * if left.length_squared() < 1e-8 { 0.0 } else { keep };
        control.position = Some(disc + self.off);
    }
}

/// Control of a body that stands at a place.
fn standing_control(at: Vec2, heading: f32) -> Control {
    Control { position: Some(at), heading: Some(heading), ..Control::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::TAU;

    #[test]
    fn who_is_pushed_to_and_fro_does_not_turn_and_who_walks_slowly_does() {
        let dt_s = 1.0 / 30.0;
        let turned = |velocity: &dyn Fn(f32) -> Vec2| {
            let (mut body, mut turned) = (StandingOffset::default(), Vec::new());
            for step in 0..90 {
                let velocity = velocity(step as f32 * dt_s);
                body.went = body.went * maths::exp2(-dt_s / WENT_HALF_LIFE_S) + velocity * dt_s;
                turned.extend(body.facing(velocity));
            }
            turned
        };
        let round = |time_s: f32| maths::direction_at_angle(TAU * time_s) * 0.5;
        assert!(turned(&round).is_empty(), "on a circle of 8 cm");
        assert!(turned(&|_| Vec2::X * 0.2).is_empty(), "as slow as a shuffle");
        let slow = turned(&|_| Vec2::X * 0.4);
        assert!(slow.len() > 45 && slow.iter().all(|ahead| ahead.dot(Vec2::X) > 0.2), "{slow:?}");
        assert_eq!(turned(&|_| Vec2::X)[0], Vec2::X, "at once");
    }
}
