//! Courses: routes with an order, whose laps count, and from which agents may stray.

use super::agent_brain::{EventContext, NO_NUMBER};
use super::{action_registry::ActionArguments, agent_brains::AgentBrains, stage::ScenarioStage, tables::trigger};
use throng_base::Result;
use throng_geometry::distance_to_segment;

impl AgentBrains {
    /// Sends an agent along the points of its action. Where laps are counted, it goes on where it was; true where all laps are done.
    pub(super) fn begin_course(
        &mut self,
        stage: &mut impl ScenarioStage,
        agent: u32,
        route: u16,
        said: &ActionArguments,
    ) -> Result<CourseBegin> {
        let m = agent as usize;
        let scenario = self.scenario.clone();
        let Some(points) = scenario.paths.get(usize::from(route)) else { return Ok(CourseBegin::NoPath) };
        let is_set = |word: usize| said.amount(word, 0.0) > 0.0;
        let (again, nearest, laps) = (is_set(2), is_set(5), said.amounts[3]);
        let own = &mut self.engagements[m];
        let is_same = laps.is_some() && own.course == route;
        if is_same && own.runs_course && is_over(own.legs_done, points.len(), laps) {
            // The last lap ended while the agent did something else on its way.
            own.runs_course = false;
            return Ok(CourseBegin::Over);
        }
        let goes_on = is_same && !is_over(own.legs_done, points.len(), laps);
        let first = if goes_on { own.legs_done % points.len() as u32 } else { 0 };
        let begin = (goes_on || !nearest).then_some(first);
        let leads = stage.order_route(agent, points, again || laps.is_some_and(|laps| laps > 1.0), begin)?;
        if !goes_on {
            self.engagements[m].legs_done = if begin.is_none() { stage.route_leg(agent) } else { 0 };
        }
        let own = &mut self.engagements[m];
        (own.course, own.runs_course) = (route, laps.is_some());
        Ok(if leads { CourseBegin::Goes } else { CourseBegin::NoPath })
    }

    /// Counts the legs that an agent has done, and tells it where it strays.
    pub(super) fn watch_course(&mut self, stage: &impl ScenarioStage, agent: u32, said: &ActionArguments) {
        let own = self.engagements[agent as usize];
        let scenario = self.scenario.clone();
        let Some(points) = scenario.paths.get(usize::from(own.course)) else { return };
        let num = points.len() as u32;
        let leg = stage.route_leg(agent);
        let done = (own.legs_done / num * num + leg).max(own.legs_done);
        self.engagements[agent as usize].legs_done = done;
        let (Some(at), Some(within_m)) = (stage.position(agent), said.amounts[4]) else { return };
        let point = |n: u32| points[(n % num) as usize];
        // Near a corner it may still be on the leg before, or already on the next one.
        let legs = [leg + num - 1, leg, leg + 1].map(|n| [point(n + num - 1), point(n)]);
        let off = legs.into_iter().map(|leg| distance_to_segment(at, leg)).fold(f32::INFINITY, f32::min);
        let strays = done > 0 && f64::from(off) > within_m;
        if strays && !own.has_strayed {
            self.push_stimulus(agent, trigger::STRAYS, EventContext::default());
        }
        self.engagements[agent as usize].has_strayed = strays;
    }

    /// Counts a lap of an agent that has come to the end of its course.
    pub(super) fn count_lap(&mut self, agent: u32) {
        let own = &mut self.engagements[agent as usize];
        let Some(points) = self.scenario.paths.get(usize::from(own.course)).filter(|_| own.runs_course) else { return };
        own.legs_done = (own.legs_done / points.len() as u32 + 1) * points.len() as u32;
        self.push_stimulus(agent, trigger::LAP, EventContext::default());
    }

    /// True where an agent at the end of its course has done all laps; those of a course without laps never end.
    pub(super) fn ends_course(&mut self, agent: u32, said: &ActionArguments) -> bool {
        let own = &mut self.engagements[agent as usize];
        let num = self.scenario.paths.get(usize::from(own.course)).map_or(1, Vec::len);
        let ends = match said.amounts[3] {
            Some(_) => is_over(own.legs_done, num, said.amounts[3]),
            None => said.amount(2, 0.0) == 0.0,
        };
        own.runs_course &= !ends;
        ends
    }

    /// Number of laps that an agent has done.
    pub(super) fn laps_of(&self, agent: u32) -> u32 {
        let own = &self.engagements[agent as usize];
        let course = self.scenario.paths.get(usize::from(own.course));
        course.map_or(0, |points| own.legs_done / points.len() as u32)
    }

    /// Distance that an agent has done along its course, which only grows from leg to leg (m).
    pub(super) fn progress_of(&self, stage: &impl ScenarioStage, agent: u32) -> f32 {
        let own = &self.engagements[agent as usize];
        let Some(points) = self.scenario.paths.get(usize::from(own.course)).filter(|_| own.course != NO_NUMBER) else {
            return 0.0;
        };
        let num = points.len();
        let length = |n: usize| points[(n + num - 1) % num].distance(points[n % num]);
        let round: f32 = (0..num).map(length).sum();
        let (lap, leg) = (own.legs_done as usize / num, own.legs_done as usize % num);
        let before = lap as f32 * round + (1..leg).map(length).sum::<f32>() - if leg == 0 { length(0) } else { 0.0 };
        let leg_m = length(leg);
        let left = stage.position(agent).map_or(leg_m, |at| at.distance(points[leg]));
        (before + (leg_m - left).clamp(0.0, leg_m)).max(0.0)
    }
}

/// Begin of a course.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CourseBegin {
    /// The agent goes.
    Goes,
    /// No path leads there.
    NoPath,
    /// All laps are done.
    Over,
}

fn is_over(legs_done: u32, num: usize, laps: Option<f64>) -> bool {
    laps.is_some_and(|laps| f64::from(legs_done / num as u32) >= laps)
}
