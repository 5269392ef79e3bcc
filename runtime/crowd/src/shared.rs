//! A crowd that several processes move together.

use crate::crowd::{Crowd, SpaceEngine, each};
use crate::{error::Result, events::shared::SharedEngine};
use glam::{Vec2, Vec3};
use throng_base::Comm;

/// The part of a crowd that one of several processes moves: a region of its own, and around it ghosts of the agents of
/// others. Agents that cross a border are handed over. The motion is that of [`Crowd::advance`], bit by bit, at any number
/// of processes, and no two agents ever overlap.
///
/// Regions are stripes of cells that hold as many agents each when the crowd is shared; they stay as they are. Every
/// process has room for all agents, and moves only its own.
///
/// ```
/// # fn main() -> throng_base::Result<()> {
/// use throng_base::LocalComm;
/// use throng_crowd::{Agent, Crowd, CrowdSetup};
/// use glam::Vec3;
///
/// let agents = (0..50).map(|n| Agent::standing_at(Vec3::new(2.0 * n as f32, 0.0, 0.0))).collect();
/// let crowd = Crowd::on_ground(CrowdSetup { agents, ..CrowdSetup::default() })?;
/// let mut alone = crowd.clone();
/// alone.advance(10.0, &mut |_| {})?;
/// let whole = LocalComm::run(2, |comm| {
///     let mut part = crowd.clone().share(comm)?;
///     part.advance(10.0, comm)?;
///     part.gather(comm)
/// });
/// let whole = whole.into_iter().next().expect("two ranks")?.expect("rank 0 has all");
/// assert_eq!(whole.hash(), alone.hash());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct SharedCrowd {
    engine: SpaceEngine<SharedEngine<Vec2>, SharedEngine<Vec3>>,
}

impl Crowd {
    /// The part of this process of a crowd that all processes have made alike.
    ///
    /// # Errors
    /// [`crate::CrowdError::Other`] for a crowd in which agents sense, have timers or companions, or care for others.
    pub fn share(self, comm: &dyn Comm) -> Result<SharedCrowd> {
        let engine = match self.engine {
            SpaceEngine::Ground(engine) => SpaceEngine::Ground(SharedEngine::new(engine, comm)?),
            SpaceEngine::Air(engine) => SpaceEngine::Air(SharedEngine::new(engine, comm)?),
        };
        Ok(SharedCrowd { engine })
    }
}

impl SharedCrowd {
    /// Advances time to `until_s`, the same one in all processes.
    ///
    /// # Errors
    /// As [`Crowd::advance`], and [`throng_base::Error::Rank`] where another process has ended.
    pub fn advance(&mut self, until_s: f64, comm: &dyn Comm) -> Result<()> {
        each!(&mut self.engine, e => e.advance(until_s, comm))
    }

    /// Number of agents that this process moves.
    pub fn num_agents(&self) -> usize {
        each!(&self.engine, e => e.num_own())
    }

    /// Number of times that this process moved an agent over a border, to another one's region or to its own.
    pub fn num_handed_over(&self) -> u64 {
        each!(&self.engine, e => e.handed_over)
    }

    /// Number of agents of this process that overlap any other one now. Tests positions alone, independently of how
    /// overlaps are prevented.
    pub fn num_overlapping(&self) -> u64 {
        each!(&self.engine, e => e.num_overlapping())
    }

    /// The whole crowd, as if one process had moved it; `None` but on rank 0.
    ///
    /// # Errors
    /// [`throng_base::Error::Rank`].
    pub fn gather(self, comm: &dyn Comm) -> Result<Option<Crowd>> {
        let engine = match self.engine {
            SpaceEngine::Ground(engine) => engine.gather_crowd(comm)?.map(SpaceEngine::Ground),
            SpaceEngine::Air(engine) => engine.gather_crowd(comm)?.map(SpaceEngine::Air),
        };
        Ok(engine.map(|engine| Crowd { engine }))
    }
}
