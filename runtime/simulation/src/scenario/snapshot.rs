//! Snapshots of agent brains.

use super::action_commands::MAX_AMOUNT;
use super::agent_brain::{
    ActionPhase, ActionReason, AgentBrain, AgentEngagement, EventContext, Feeling, LearntEvent, NO_NUMBER,
};
use super::agent_brains::AgentBrains;
use super::tables::{CompiledAction, NONE};
use crate::motion_kind::refused_snapshot;
use throng_base::{Result, SnapshotKind};

const KIND: SnapshotKind = SnapshotKind { what: "agent brains", tag: *b"MIND", version: 6, setup: 0 };

impl AgentBrains {
    /// Appends the state that changes with time; between two calls there is no other.
    pub fn save(&self, out: &mut Vec<u8>) {
        KIND.write(self, out);
    }

    /// Restores brains of the same scenario at a time (s).
    ///
    /// # Errors
    /// [`throng_base::Error::Snapshot`]; nothing has changed then.
    pub fn load(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
        let saved: Self = KIND.read_all(bytes)?;
        self.check(&saved, time_s).map_err(|why| refused_snapshot(KIND.what, why))?;
        let old = std::mem::replace(self, saved);
        (self.scenario, self.seed, self.at_once, self.evaluations) =
            (old.scenario, old.seed, old.at_once, old.evaluations);
        (self.queue, self.touched, self.is_touched) = (old.queue, old.touched, old.is_touched);
        (self.nearby, self.turns, self.first_speeds) = (old.nearby, old.turns, old.first_speeds);
        Ok(())
    }

    /// Checks that brains can be those of this scenario.
    fn check(&self, saved: &Self, time_s: f64) -> std::result::Result<(), &'static str> {
        let scenario = &self.scenario;
        let lengths = |b: &Self| {
            let of_agents = [b.brains.len(), b.feelings.len(), b.learnt.len(), b.followed.len(), b.relationships.len()];
            let of_things = [b.holders.len(), b.keepers.len(), b.is_open.len(), b.closing.len()];
            let of_events = [b.due.len(), b.times.len(), b.happened.len(), b.was_true.len()];
            let of_groups = [
                b.enters.len(),
                b.entered.len(),
                b.reused.len(),
                b.refused.len(),
                b.services.len(),
                b.engagements.len(),
            ];
            (of_agents, of_things, of_events, of_groups)
        };
        let num = self.brains.len() as u32;
        if lengths(saved) != lengths(self) || !saved.blackboards.is_compatible(&self.blackboards, num) {
            return Err("they are of another scenario");
        }
        let is_agent = |agent: u32| agent == NONE || agent < num;
        let is_time = |t: f64| !t.is_nan() && t <= time_s;
        let is_later = |t: f64| !t.is_nan();
        // All that was due has been done.
        let times = [&saved.closing, &saved.due, &saved.enters].into_iter().flatten().all(|t| *t >= time_s);
        let past = saved.followed.iter().chain(&saved.happened).all(|t| is_time(*t));
        if !is_time(saved.now) || !times || !past {
            return Err("its times cannot be");
        }
        let is_context = |c: &EventContext| {
            is_agent(c.other)
                && (c.place == NO_NUMBER || usize::from(c.place) < scenario.places.len())
                && (c.event == NO_NUMBER || usize::from(c.event) < scenario.events.len())
                && c.strength.is_finite()
        };
        // Between two calls, only primitive behaviours go on.
        let is_doing = |brain: &AgentBrain| match scenario.actions.get(brain.action as usize) {
            Some(CompiledAction::Primitive { .. }) => true,
            // Who tries again has an action to begin with.
            first => {
                let again_at_s = if first.is_some() { f64::INFINITY } else { brain.acts_again_at_s };
                let times = [brain.stands_until_s, brain.gives_up_at_s, again_at_s];
                brain.phase == ActionPhase::Idle && times == [f64::INFINITY; 3]
            }
        };
        let is_action = |a: u32| a == NONE || (a as usize) < scenario.actions.len();
        let is_reason = |r: &ActionReason| {
            (r.rule == NONE || (r.rule as usize) < scenario.rules.len())
                && (r.edge == NONE || (r.edge as usize) < scenario.edges.len())
                && usize::from(r.trigger) < scenario.rules_of.len()
                && is_agent(r.other)
                && (r.place == NO_NUMBER || usize::from(r.place) < scenario.places.len())
        };
        let is_state = |(level, s): (usize, &u16)| {
            *s == NO_NUMBER
                || scenario.states.get(usize::from(*s)).is_some_and(|state| usize::from(state.level) == level)
        };
        let is_good = |(agent, own, brain): (u32, &AgentBrain, &AgentBrain)| {
            brain.group == own.group
                && brain.states.iter().enumerate().all(is_state)
                && is_action(brain.action)
                && is_doing(brain)
                && is_action(brain.resumed)
                && [brain.context, brain.resumed_context].iter().all(is_context)
                && brain.wake_times().iter().all(|t| is_later(*t))
                && is_agent(brain.told_by)
                && (brain.aim == NONE || (brain.aim as usize) < scenario.slots.len())
                && (brain.crossing == NO_NUMBER && brain.crossing_at == f64::INFINITY
                    || usize::from(brain.crossing) < scenario.thresholds.len())
                && (brain.slot == NONE || saved.holders.get(brain.slot as usize) == Some(&agent))
                && brain.home.iter().all(|x| x.is_finite())
                && (0.0..=1e3).contains(&brain.speed)
                && is_reason(&brain.reason)
                && brain.draws < u32::MAX / 2
                && brain.handled < u32::MAX / 2
        };
        let all = (0..num).zip(self.brains.iter().zip(&saved.brains));
        if !all.map(|(agent, (own, brain))| (agent, own, brain)).all(is_good) {
            return Err("an agent brain holds an impossible value");
        }
        let is_held = |(slot, holder): (u32, &u32)| {
            *holder == NONE || saved.brains.get(*holder as usize).is_some_and(|m| m.slot == slot)
        };
        let is_learnt = |l: &LearntEvent| is_agent(l.from) && is_time(l.time_s) && l.at.iter().all(|x| x.is_finite());
        let learnt = saved.learnt.iter().flatten().all(is_learnt);
        let relationships = saved.relationships.iter().flatten().all(|b| is_agent(b.0) && b.1.is_finite());
        let is_felt = |f: &Feeling| f.value.is_finite() && f64::from(f.rate.abs()) <= MAX_AMOUNT && is_time(f.since);
        let feelings = saved.feelings.iter().all(is_felt);
        let has_room = saved.times.iter().all(|n| *n < u32::MAX / 128);
        let entered = scenario.groups.iter().zip(saved.entered.iter().zip(&saved.enters)).all(|(g, (e, next))| {
            let all = g.agents[1] - g.agents[0];
            g.num_at_start <= *e && (*e < all || *e == all && (g.reuses || *next == f64::INFINITY))
        });
        let kept = saved.keepers.iter().all(|k| is_agent(*k));
        let held = (0u32..).zip(&saved.holders).all(is_held);
        let num_tills = scenario.services.iter().map(|s| {
            let [first, last] = scenario.places[usize::from(s.tills)].slots;
            (last - first) as usize
        });
        let services = saved.services.iter().zip(num_tills).all(|(record, tills)| record.is_sound(tills));
        let is_engaged = |own: &AgentEngagement| {
            !own.joined.is_nan()
                && is_time(own.led_at)
                && (0.0..=1e12).contains(&own.waited)
                && [own.served, own.legs_done, own.entries].iter().all(|n| *n < u32::MAX / 2)
                && (own.served_by == NO_NUMBER || usize::from(own.served_by) < scenario.services.len())
                && (own.course == NO_NUMBER || usize::from(own.course) < scenario.paths.len())
        };
        let services = services && saved.engagements.iter().all(is_engaged);
        let counted = saved.reused.iter().chain(&saved.refused).all(|n| *n < u32::MAX / 2);
        let is_good = services && counted && held && kept && learnt && relationships && feelings && has_room && entered;
        if is_good { Ok(()) } else { Err("somebody holds, feels or has learnt what cannot be") }
    }
}
