//! Agent brains on a stage of paper, whose agents are moved by hand.

mod courses;
mod expectations;
mod hand;
mod language;
mod plain;
mod random;
mod services;
mod things;

use super::action_registry::ActionRegistry;
use super::agent_brains::{AgentBrains, Signal};
use super::stage::{Handling, ScenarioStage, ShownGesture, StanceError};
use super::{Explanation, Scenario};
use crate::scene::Scene;
use glam::Vec3;
use std::path::Path;
use std::sync::Arc;
use throng_base::Result;

/// Where agents are as told, and all that they are told.
#[derive(Clone, Debug, Default)]
pub(super) struct Paper {
    pub now: f64,
    /// Where each agent started and how it moves; not there where `None`.
    pub at: Vec<Option<(Vec3, Vec3)>>,
    /// What was asked for, with the time and the agent.
    pub log: Vec<String>,
    pub timers: Vec<f64>,
    /// When agents that were sent somewhere arrive.
    pub arrivals: Vec<f64>,
    /// Number of the point of its way that each agent goes to; the first one where absent.
    pub legs: Vec<u32>,
    /// What hands began to do, and what they hold.
    pub handled: Vec<(u32, Handling)>,
    pub in_hand: Vec<(u32, u16)>,
}

/// How long every way takes on paper (s).
pub(super) const WALK_S: f64 = 1.7;

impl Paper {
    pub fn new(num: usize) -> Self {
        let place = |i: usize| Some((Vec3::new(3.0 * i as f32, 0.0, 0.0), Vec3::ZERO));
        let never = vec![f64::INFINITY; num];
        Self {
            now: 0.0,
            at: (0..num).map(place).collect(),
            log: Vec::new(),
            timers: never.clone(),
            arrivals: never,
            legs: Vec::new(),
            handled: Vec::new(),
            in_hand: Vec::new(),
        }
    }

    pub fn note(&mut self, agent: u32, what: String) {
        self.log.push(format!("{:.6} {agent} {what}", self.now));
    }
}

impl ScenarioStage for Paper {
    fn position(&self, agent: u32) -> Option<Vec3> {
        self.at[agent as usize].map(|(at, velocity)| at + velocity * self.now as f32)
    }
    fn companions(&self, agent: u32) -> std::ops::Range<u32> {
        agent..agent + 1
    }
    fn velocity(&self, agent: u32) -> Vec3 {
        self.at[agent as usize].map_or(Vec3::ZERO, |a| a.1)
    }
    fn order_walk(&mut self, agent: u32, at: Vec3, arrival_m: f32, leaves: bool) -> Result<bool> {
        self.note(agent, format!("go {:.3} {:.3} {arrival_m:.2} {leaves}", at.x, at.z));
        self.arrivals[agent as usize] = self.now + WALK_S;
        Ok(true)
    }
    fn order_route(&mut self, agent: u32, points: &[Vec3], again: bool, _: Option<u32>) -> Result<bool> {
        self.note(agent, format!("follow {} {again}", points.len()));
        self.arrivals[agent as usize] = if again { f64::INFINITY } else { self.now + WALK_S };
        Ok(true)
    }
    fn route_leg(&self, agent: u32) -> u32 {
        self.legs.get(agent as usize).copied().unwrap_or(0)
    }
    fn follow_happening(&mut self, agent: u32, happening: u16) -> Result<()> {
        self.note(agent, format!("happening {happening}"));
        Ok(())
    }
    fn resume_route(&mut self, agent: u32) -> Result<()> {
        self.note(agent, "resume".into());
        self.arrivals[agent as usize] = f64::INFINITY;
        Ok(())
    }
    fn order_halt(&mut self, agent: u32) -> Result<()> {
        self.note(agent, "halt".into());
        self.arrivals[agent as usize] = f64::INFINITY;
        Ok(())
    }
    fn set_speed(&mut self, agent: u32, speed_mps: f32) -> Result<()> {
        self.note(agent, format!("speed {speed_mps:.3}"));
        Ok(())
    }
    fn show_gesture(&mut self, _: u32, _: Option<ShownGesture>) {}

    fn show_activity(&mut self, agent: u32, motion: Option<u16>, _: Option<Vec3>) {
        self.note(agent, format!("show {}", motion.is_some()));
    }
    fn face_agent(&mut self, _: u32, _: u32) {}
    fn sees(&self, _: Vec3, _: Vec3, _: f32, _: bool) -> bool {
        true
    }
    fn thing_position(&self, thing: u16) -> Vec3 {
        Vec3::new(f32::from(thing), 1.0, 9.0)
    }
    fn has_in_hand(&self, agent: u32, thing: u16) -> bool {
        self.in_hand.contains(&(agent, thing))
    }
    fn stance(
        &self,
        _: u32,
        _: Option<u16>,
        handling: Handling,
        _: u32,
    ) -> std::result::Result<(Vec3, f32), StanceError> {
        Ok((handling.at.with_y(0.0), 0.15))
    }
    fn count_miss(&mut self) {}
    fn begin_handling(&mut self, agent: u32, _: Option<u16>, handling: Handling) {
        self.note(agent, format!("{} {}", if handling.puts { "puts" } else { "takes" }, handling.thing));
        self.handled.push((agent, handling));
    }
    fn end_handling(&mut self, agent: u32, thing: u16, is_done: bool) -> bool {
        let begun = self.handled.iter().position(|(a, h)| (*a, h.thing) == (agent, thing));
        if let Some((_, handling)) = begun.map(|i| self.handled.remove(i)).filter(|_| is_done) {
            self.in_hand.retain(|h| *h != (agent, thing));
            self.in_hand.extend((!handling.puts).then_some((agent, thing)));
        }
        self.has_in_hand(agent, thing)
    }
    fn is_handling_over(&self, _: u32, _: u16) -> bool {
        false
    }
    fn drop_thing(&mut self, thing: u16) {
        self.in_hand.retain(|h| h.1 != thing);
    }
    fn set_door_open(&mut self, door: u16, open: bool) -> Result<bool> {
        self.note(u32::from(door), format!("door {open}"));
        Ok(true)
    }
    fn enter_agent(&mut self, agent: u32) -> Result<bool> {
        self.at[agent as usize] = Some((Vec3::ZERO, Vec3::ZERO));
        Ok(true)
    }
    fn set_senses(&mut self, _: u32, _: u32, _: u32) -> Result<()> {
        Ok(())
    }
    fn set_timer(&mut self, agent: u32, time_s: Option<f64>) -> Result<()> {
        self.timers[agent as usize] = time_s.unwrap_or(f64::INFINITY);
        Ok(())
    }
    fn set_interest(&mut self, _: u32, _: usize, _: Option<(Vec3, f32, f32)>) -> Result<()> {
        Ok(())
    }
    fn agents_within(&self, at: Vec3, radius_m: f32, out: &mut Vec<u32>) {
        let near = |m: &u32| self.position(*m).is_some_and(|p| p.distance(at) <= radius_m);
        out.extend((0..self.at.len() as u32).filter(near));
    }
}

/// Whatever lives by a scene.
pub(super) trait Lives {
    fn begin(&mut self, stage: &mut Paper);
    fn next_external_s(&self) -> f64;
    fn external(&mut self, stage: &mut Paper, now: f64);
    fn signal(&mut self, stage: &mut Paper, now: f64, signal: Signal);
}

impl Lives for AgentBrains {
    fn begin(&mut self, stage: &mut Paper) {
        let speeds = vec![1.3; stage.at.len()];
        AgentBrains::begin_scene(self, stage, &speeds).expect("it begins");
    }
    fn next_external_s(&self) -> f64 {
        AgentBrains::next_external_s(self)
    }
    fn external(&mut self, stage: &mut Paper, now: f64) {
        AgentBrains::run_external_events(self, stage, now).expect("it goes on");
    }
    fn signal(&mut self, stage: &mut Paper, now: f64, signal: Signal) {
        AgentBrains::handle_signal(self, stage, now, signal).expect("it goes on");
    }
}

/// Lets time pass: what comes from outside, what is scripted, arrivals and timers, in this order at one time.
pub(super) fn play(lives: &mut impl Lives, stage: &mut Paper, script: &[(f64, Signal)], until_s: f64) {
    let mut next = script.iter().peekable();
    loop {
        let external = lives.next_external_s();
        let scripted = next.peek().map_or(f64::INFINITY, |s| s.0);
        let first = |all: &[f64]| {
            let least = all.iter().copied().fold(f64::INFINITY, f64::min);
            (least, all.iter().position(|t| *t == least).unwrap_or(0) as u32)
        };
        let ((arrival, who), (timer, timer_agent)) = (first(&stage.arrivals), first(&stage.timers));
        let now = external.min(scripted).min(arrival).min(timer);
        if now > until_s {
            stage.now = until_s;
            return;
        }
        stage.now = now;
        if external == now {
            lives.external(stage, now);
        } else if scripted == now {
            if let Some((_, signal)) = next.next() {
                lives.signal(stage, now, *signal);
            }
        } else if arrival == now {
            stage.arrivals[who as usize] = f64::INFINITY;
            lives.signal(stage, now, Signal::Arrived(who));
        } else {
            stage.timers[timer_agent as usize] = f64::INFINITY;
            lives.signal(stage, now, Signal::Timer(timer_agent));
        }
    }
}

/// A scene of so many agents, with more, in which news are told at once.
pub(super) fn scene(num: usize, more: &str) -> Scene {
    scene_of_tellers(num, more, 0.0)
}

/// A scene of so many agents, with more, in which telling takes time.
pub(super) fn scene_of_tellers(num: usize, more: &str, telling_s: f32) -> Scene {
    let text = format!(
        "seed = 5\n{more}\n[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = {num}\ngraph = \"life\"\n\
         place = {{ block = {{ from = [0.0, 0.0], to = [99.0, 9.0] }} }}\n"
    );
    let text =
        if more.contains("[graphs.life]") { text } else { text.replace("graph = \"life\"", "goal = { stay = {} }") };
    let mut scene = Scene::parse(&text, Path::new("scene.toml")).unwrap_or_else(|e| panic!("{e}\n{text}"));
    scene.agents.telling_s = telling_s;
    scene
}

pub(super) fn brains(scene: &Scene) -> AgentBrains {
    let scenario = Scenario::new(scene, &ActionRegistry::default()).unwrap_or_else(|e| panic!("{e}")).expect("a story");
    let doors: Vec<bool> = scene.environment.doors.iter().map(|d| d.open).collect();
    AgentBrains::new(Arc::new(scenario), scene.seed, &doors)
}

/// A scene that has run on paper.
pub(super) fn played(num: usize, more: &str, script: &[(f64, Signal)], until_s: f64) -> (AgentBrains, Paper) {
    let mut brains = brains(&scene(num, more));
    let mut stage = Paper::new(num);
    Lives::begin(&mut brains, &mut stage);
    play(&mut brains, &mut stage, script, until_s);
    (brains, stage)
}

pub(super) fn explained(brains: &AgentBrains, agent: usize) -> Explanation {
    brains.explain(agent, 0.0)
}

/// The error of a scene that is refused.
pub(super) fn refused(more: &str) -> String {
    let groups = "[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = 2\ngoal = { stay = {} }\n\
                  place = { block = { from = [0.0, 0.0], to = [99.0, 9.0] } }\n";
    let text = format!("{more}\n{groups}");
    match Scene::parse(&text, Path::new("scene.toml")) {
        Err(e) => e.to_string(),
        Ok(scene) => match Scenario::new(&scene, &ActionRegistry::default()) {
            Err(e) => e.to_string(),
            Ok(_) => panic!("it is accepted:\n{more}"),
        },
    }
}
