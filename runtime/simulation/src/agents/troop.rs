//! Bodies that follow agents of a crowd.

use crate::kind::{PART, refused};
use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::{Deserialize, Serialize};
use throng_base::maths;
use throng_base::{Bytes, Error, Result, Run, run_each};
use throng_core::blend::ActivityId;
use throng_core::walkers::{Control, Performance, Reach, WalkerStart, Walkers};
use throng_core::{Bodies, Cast, Planar};
use throng_crowd::{Crowd, Id};

/// Slower agents keep their heading (m/s).
const SLOW_MPS: f32 = 0.3;
/// Height at which people look at each other and at pictures (m).
const EYES_M: f32 = 1.55;
/// Time in which half of the way is made by a body that goes to where it stands still, or back to its disc (s).
const ASIDE_HALF_LIFE_S: f32 = 0.15;

/// Bodies of one blend space, row by row as their walkers.
#[derive(Clone, Debug)]
pub(crate) struct Troop {
    walkers: Walkers,
    /// Whose bodies they are.
    pub agents: Vec<Id>,
    controls: Vec<Control>,
    /// Where bodies stand that do not follow their discs.
    still: Vec<Still>,
}

/// A body that stands beside the middle of its disc, which is moved about a little meanwhile, or comes back to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Still {
    /// Where it stands, x and z (m).
    at: Option<Vec2>,
    /// How far it is from the middle of its disc (m).
    off: Vec2,
}

/// What the next steps of a troop depend on, beside the crowd and whose bodies they are.
#[derive(Serialize, Deserialize)]
pub(crate) struct SavedTroop {
    /// What bodies were told last.
    controls: Vec<Control>,
    still: Vec<Still>,
    walkers: Bytes,
}

impl Troop {
    /// Nobody yet; takes all memory that walkers of this capacity need.
    pub fn new(walkers: Walkers) -> Self {
        let room = walkers.capacity();
        Self {
            walkers,
            agents: Vec::with_capacity(room),
            controls: Vec::with_capacity(room),
            still: Vec::with_capacity(room),
        }
    }

    /// Gives an agent a body where it is now. It faces the way that the agent moves, or `ahead` where it is slow.
    ///
    /// - `num_bodies`: agents take the walkers' skeletons in turn, by their numbers in the crowd.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Full`].
    pub fn enter(&mut self, crowd: &Crowd, agent: Id, ahead: Vec2, num_bodies: usize) -> Result<()> {
        let now = crowd.now();
        let motion = crowd.position(agent, now).zip(crowd.velocity(agent, now));
        let (at, velocity) = motion.map(|(at, v)| (at.xz(), v.xz())).ok_or(Error::Gone(agent))?;
        let ahead = if velocity.length() > SLOW_MPS { velocity } else { ahead };
        let heading = maths::atan2(ahead.x, ahead.y);
        let phase = (agent.index as f32 * 0.381_966).fract();
        let body = agent.index() % num_bodies;
        self.walkers.spawn(WalkerStart { body, root: Planar { x: at.x, z: at.y, heading }, phase })?;
        self.agents.push(agent);
        self.controls.push(standing(at, heading));
        self.still.push(Still::default());
        Ok(())
    }

    /// Takes the body of a row away; the last one takes its row (row < number of bodies).
    pub fn leave(&mut self, row: usize) -> Result<()> {
        self.walkers.despawn(self.walkers.bodies().ids[row])?;
        self.agents.swap_remove(row);
        self.controls.swap_remove(row);
        self.still.swap_remove(row);
        Ok(())
    }

    /// Puts the body of a row elsewhere (row < number of bodies).
    pub fn place(&mut self, row: usize, root: Planar) -> Result<()> {
        self.controls[row] = standing(Vec2::new(root.x, root.z), root.heading);
        self.still[row] = Still::default();
        self.walkers.place(self.walkers.bodies().ids[row], root)
    }

    /// Lets the body of a row turn to a direction, while its agent stands, and look at a place of the ground as at a face; `None`
    /// where it looks ahead (row < number of bodies).
    pub fn look(&mut self, row: usize, ahead: Option<Vec2>, at: Option<Vec3>) {
        if let Some(ahead) = ahead.filter(|a| a.length_squared() > 1e-4) {
            self.controls[row].heading = Some(maths::atan2(ahead.x, ahead.y));
        }
        self.controls[row].look_at = at.map(|at| at + Vec3::Y * EYES_M);
    }

    /// Lets the body of a row stand still at a place (x, z), or follow its disc again (row < number of bodies).
    pub fn stand(&mut self, row: usize, at: Option<Vec2>) {
        self.still[row].at = at;
    }

    /// Hands reach for nothing any more.
    pub fn free_hands(&mut self) {
        self.controls.iter_mut().for_each(|c| c.hands = [None; 2]);
    }

    /// Lets a hand of the body of a row reach for something: 0 left, 1 right (row < number of bodies).
    pub fn reach(&mut self, row: usize, side: usize, reach: Reach) {
        self.controls[row].hands[side] = Some(reach);
    }

    /// Lets the body of a row perform an activity (row < number of bodies).
    pub fn perform(&mut self, row: usize, performance: Option<Performance>) -> Result<()> {
        self.walkers.perform(self.walkers.bodies().ids[row], performance)
    }

    /// True while the body of a row performs one (row < number of bodies).
    pub fn is_performing(&self, row: usize) -> bool {
        self.walkers.performing(row).is_some()
    }

    /// True for an activity that is not performed again and again: a greeting.
    pub fn is_once(&self, activity: ActivityId) -> bool {
        let tag = self.walkers.space().activities().get(activity).map_or("", |a| a.tag.as_str());
        tag.starts_with("greet") || tag.starts_with("handshake")
    }

    /// Moves all bodies on, to where their agents are now.
    pub fn step(&mut self, crowd: &Crowd, dt_s: f32, run: &dyn Run) -> Result<()> {
        let now = crowd.now();
        let told = self.controls.chunks_mut(PART).zip(self.still.chunks_mut(PART));
        let keep = maths::exp2(-dt_s / ASIDE_HALF_LIFE_S);
        run_each(run, self.agents.chunks(PART).zip(told), |(agents, (controls, still))| {
            for ((&agent, control), still) in agents.iter().zip(controls).zip(still) {
                steer(crowd, agent, now, control);
                still.lead(control, keep);
            }
        });
        for (row, &control) in self.controls.iter().enumerate() {
            self.walkers.order(self.walkers.bodies().ids[row], control)?;
        }
        self.walkers.step(dt_s, run)
    }

    /// The walkers.
    pub fn walkers(&self) -> &Walkers {
        &self.walkers
    }

    /// The walkers, to move them to another bundle.
    pub fn walkers_mut(&mut self) -> &mut Walkers {
        &mut self.walkers
    }

    /// The bodies, by the names of their agents.
    pub fn bodies(&self) -> Bodies<'_> {
        Bodies { ids: &self.agents, ..self.walkers.bodies() }
    }

    /// What the next steps depend on.
    pub fn saved(&self) -> SavedTroop {
        let mut walkers = Bytes::default();
        self.walkers.save(&mut walkers.0);
        SavedTroop { controls: self.controls.clone(), still: self.still.clone(), walkers }
    }

    /// Goes back to what was saved, of the agents that it has.
    ///
    /// # Errors
    /// [`Error::Snapshot`]; a part may have been loaded then.
    pub fn load(&mut self, saved: &SavedTroop) -> Result<()> {
        let SavedTroop { controls, still, walkers } = saved;
        let mut told = self.agents.iter().zip(controls);
        let is_finite = |s: &Still| s.off.is_finite() && s.at.is_none_or(Vec2::is_finite);
        if still.len() != controls.len() || !still.iter().all(is_finite) {
            return Err(refused("bodies", "they stand where none can"));
        }
        if controls.len() != self.agents.len() || !told.all(|(&id, c)| c.check(id).is_ok()) {
            return Err(refused("bodies", "they are told what cannot be"));
        }
        self.walkers.load(&walkers.0)?;
        if self.walkers.len() != self.agents.len() {
            return Err(refused("bodies", "they are others"));
        }
        // The vector keeps its capacity.
        self.controls.clone_from(controls);
        self.still.clone_from(still);
        Ok(())
    }
}

impl Still {
    /// Displaces what a body is told.
    ///
    /// - `keep`: share of the way that is left after a step.
    fn lead(&mut self, control: &mut Control, keep: f32) {
        let Some(disc) = control.position else { return };
        let aim = match self.at {
            Some(at) => {
                control.velocity = Vec2::ZERO;
                at - disc
            }
            None => Vec2::ZERO,
        };
        let left = self.off - aim;
        self.off = aim + left * if left.length_squared() < 1e-8 { 0.0 } else { keep };
        control.position = Some(disc + self.off);
    }
}

/// What a body is told that stands.
fn standing(at: Vec2, heading: f32) -> Control {
    Control { position: Some(at), heading: Some(heading), ..Control::default() }
}

/// What a body is asked: to be where its agent is, and to move as it does. Those who stand keep their heading, those who
/// have left stay where they were.
fn steer(crowd: &Crowd, agent: Id, time_s: f64, control: &mut Control) {
    let (Some(at), Some(velocity)) = (crowd.position(agent, time_s), crowd.smooth_velocity(agent)) else {
        control.velocity = Vec2::ZERO;
        return;
    };
    (control.position, control.velocity) = (Some(at.xz()), velocity.xz());
    if control.velocity.length() > SLOW_MPS {
        control.heading = Some(maths::atan2(control.velocity.x, control.velocity.y));
    }
}
