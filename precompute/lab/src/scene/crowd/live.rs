//! A crowd that lives through its scene: happenings come, and those who know tell others.

use super::config::CrowdScene;
use super::happening::HappeningConfig;
use super::layout::Layout;
use super::obstacle::point;
use throng_base::Rayon;
use throng_motion::error::BuildError;
use throng_runtime::crowd::{Crowd, Event, EventKind, Go, Id, Route, Space};

/// Time between moments at which news are told on, whatever the times that are looked at (s).
const NEWS_S: f64 = 1.0 / 30.0;

/// A crowd, its layout, and who knows what.
#[derive(Clone, Debug)]
pub struct Live<V> {
    pub(super) crowd: Crowd,
    pub(super) layout: Layout<V>,
    ids: Vec<Id>,
    /// In the order of their times.
    happenings: Vec<HappeningConfig>,
    /// How many of them have happened.
    pub(super) happened: usize,
    /// Of each agent: the last happening that it knows of, from 1; 0 where it knows of none.
    pub(super) knows: Vec<usize>,
    /// Of each agent: how often it was given another way.
    pub(super) sent: Vec<u32>,
    /// (who is told, of which happening), since news were last told on.
    pub(super) told: Vec<(usize, usize)>,
    /// Moments at which news were told on.
    pub(super) ticks: u64,
    on_all_threads: bool,
}

impl<V: Space> Live<V> {
    /// Puts everybody where they start.
    ///
    /// # Errors
    /// As [`Layout::new`], or [`BuildError::Stage`] for an impossible start, which names the agents by their groups.
    pub fn new(scene: &CrowdScene) -> Result<Self, BuildError> {
        let layout = Layout::new(scene)?;
        let setup = layout.setup.clone().map(V::to_world);
        let crowd = if V::DIMENSIONS == 2 { Crowd::on_ground(setup) } else { Crowd::in_air(setup) };
        let crowd = crowd.map_err(|e| layout.explain(&e))?;
        let mut happenings = scene.happenings.clone();
        happenings.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let num = layout.num_agents();
        Ok(Self {
            ids: crowd.ids().collect(),
            crowd,
            happenings,
            happened: 0,
            knows: vec![0; num],
            sent: vec![0; num],
            told: Vec::new(),
            ticks: 0,
            on_all_threads: false,
            layout,
        })
    }

    /// Runs on the threads of the current rayon pool from now on; what happens is the same.
    pub fn on_all_threads(&mut self) {
        self.on_all_threads = true;
    }

    /// Lets time pass until `until_s`. What happens does not depend on how often this is called on the way.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where the engine does not get on, or a happening's goal cannot be reached.
    pub fn advance(&mut self, until_s: f64) -> Result<(), BuildError> {
        self.advance_telling(until_s, &mut |_| {})
    }

    /// As [`Live::advance`]; everything that happens is told to `on_event` in its order.
    ///
    /// # Errors
    /// As [`Live::advance`].
    pub fn advance_telling(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), BuildError> {
        loop {
            let next = self.happenings.get(self.happened).map_or(f64::INFINITY, |h| h.time_s);
            let tick = if self.is_told_on() { (self.ticks + 1) as f64 * NEWS_S } else { f64::INFINITY };
            let stop = until_s.min(next).min(tick);
            self.advance_engine(stop, on_event)?;
            if stop == next {
                self.happen()?;
            } else if stop == tick {
                self.ticks += 1;
                self.tell_on()?;
            } else {
                return Ok(());
            }
        }
    }

    fn is_told_on(&self) -> bool {
        self.happenings[..self.happened].iter().any(|h| h.told_on)
    }

    fn advance_engine(&mut self, until_s: f64, on_event: &mut impl FnMut(&Event)) -> Result<(), BuildError> {
        let (knows, told, happenings) = (&self.knows, &mut self.told, &self.happenings);
        let mut hear = |e: &Event| {
            on_event(e);
            let EventKind::Colliding { other } = e.kind else { return };
            let (a, b) = (e.agent.index(), other.index());
            let (who, news) = if knows[a] < knows[b] { (a, knows[b]) } else { (b, knows[a]) };
            if knows[who] < news && happenings[news - 1].told_on {
                told.push((who, news));
            }
        };
        let done = if self.on_all_threads {
            self.crowd.par_advance(until_s, &Rayon, &mut hear)
        } else {
            self.crowd.advance(until_s, &mut hear)
        };
        done.map_err(|e| self.layout.explain(&e))
    }

    /// The next happening: those who are near hear of it.
    fn happen(&mut self) -> Result<(), BuildError> {
        let happening = self.happenings[self.happened].clone();
        self.happened += 1;
        self.ticks = (happening.time_s / NEWS_S).floor() as u64;
        for m in 0..self.num_agents() {
            let Some(at) = self.position(m, happening.time_s) else { continue };
            let is_near = |n: &super::NearConfig| (at - point(&n.at)).length() <= n.radius_m;
            if happening.near.as_ref().is_none_or(is_near) {
                self.learn(m, self.happened, happening.time_s)?;
            }
        }
        Ok(())
    }

    /// Those who met somebody that knows more know it too.
    fn tell_on(&mut self) -> Result<(), BuildError> {
        for (m, news) in std::mem::take(&mut self.told) {
            if self.knows[m] < news {
                self.learn(m, news, self.crowd.now())?;
            }
        }
        Ok(())
    }

    /// An agent knows of a happening, and takes the way to its goal.
    fn learn(&mut self, m: usize, news: usize, time_s: f64) -> Result<(), BuildError> {
        self.knows[m] = news;
        let Some(at) = self.position(m, time_s) else { return Ok(()) };
        let h = &self.happenings[news - 1];
        let route = self.layout.new_way(m, at, &h.goal, (h.arrival_m, h.at_end))?;
        let speed = h.speed_mps.unwrap_or(self.layout.setup.agents[m].speed);
        let Route { subgoals, arrival_radius, at_end } = route.map(V::to_world);
        let order = Go::along(subgoals).within(arrival_radius).then(at_end).at_speed(speed);
        let sent = self.crowd.order(self.ids[m], order);
        self.sent[m] += 1;
        sent.map_err(|e| self.layout.explain(&e))
    }

    /// The engine.
    pub fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// Who is there.
    pub fn layout(&self) -> &Layout<V> {
        &self.layout
    }

    /// Number of agents that started.
    pub fn num_agents(&self) -> usize {
        self.ids.len()
    }

    /// Name of an agent in the engine (agent < num_agents).
    pub fn id(&self, agent: usize) -> Id {
        self.ids[agent]
    }

    /// Where an agent is at a time that the engine knows; `None` where it has left (agent < num_agents).
    pub fn position(&self, agent: usize, time_s: f64) -> Option<V> {
        self.crowd.position(self.ids[agent], time_s).map(V::from_world)
    }

    /// How an agent moves (m/s, agent < num_agents).
    pub fn velocity(&self, agent: usize, time_s: f64) -> Option<V> {
        self.crowd.velocity(self.ids[agent], time_s).map(V::from_world)
    }

    /// How an agent moves as a Kalman filter sees it (m/s, agent < num_agents).
    pub fn smooth_velocity(&self, agent: usize) -> Option<V> {
        self.crowd.smooth_velocity(self.ids[agent]).map(V::from_world)
    }

    /// True for a scene in which something happens from outside.
    pub fn has_happenings(&self) -> bool {
        !self.happenings.is_empty()
    }

    /// Number of happenings of the scene.
    pub(super) fn num_happenings(&self) -> usize {
        self.happenings.len()
    }

    /// Number of happenings of which an agent knows, itself or from others (agent < num_agents).
    pub fn knows(&self, agent: usize) -> usize {
        self.knows[agent]
    }

    /// How often an agent was given another way (agent < num_agents).
    pub fn times_sent(&self, agent: usize) -> u32 {
        self.sent[agent]
    }
}
