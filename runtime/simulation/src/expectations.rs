//! Expectations of a scene, measured while a simulation runs.

use crate::scenario::{AgentsView, ExpectationMeters, ExpectationOutcome, ScenarioStage};
use crate::{AnyCharacterGroup, CompiledScene, MotionKind, Simulation, agents::SceneAgents};
use glam::Vec3;
use throng_base::{Result, maths};
use throng_crowd::Space;

/// Time between two measurements (s).
const PERIOD_S: f64 = 0.1;

/// Measurements of all expectations of a scene in one run.
#[derive(Clone, Debug)]
pub struct ExpectationWatch {
    meters: ExpectationMeters,
    due_s: f64,
}

impl ExpectationWatch {
    /// A watch without measurements; `None` where the scene expects nothing.
    pub fn new(compiled: &CompiledScene) -> Option<Self> {
        let scenario = compiled.expected.as_ref()?;
        Some(Self { meters: ExpectationMeters::new(scenario, &compiled.scene().expect), due_s: 0.0 })
    }

    /// Observes a simulation before the first step and after every step.
    pub fn observe(&mut self, sim: &Simulation) {
        if sim.time_s() + 1e-6 >= self.due_s {
            self.due_s += PERIOD_S;
            self.visit(sim, false);
        }
    }

    /// Outcomes of all expectations at the end of a run.
    ///
    /// - `figure`: figure of that key, of all or of a group.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] for a figure that there is not.
    pub fn finish(
        mut self,
        sim: &Simulation,
        figure: impl Fn(Option<&str>, &str) -> Option<f64>,
    ) -> Result<Vec<ExpectationOutcome>> {
        self.visit(sim, true);
        self.meters.finish(figure).map_err(|(n, key)| {
            let why = format!("there is no figure `{key}` here: `throng run --json` prints those that there are");
            sim.scene().fault(&format!("expect[{n}].that.figure"), why)
        })
    }

    fn visit(&mut self, sim: &Simulation, is_end: bool) {
        let Some(group) = sim.groups().iter().find(|g| sim.scene().groups[g.number].is_of_agents()) else { return };
        let first = group.characters.start;
        match &sim.character_groups()[group.character_group] {
            AnyCharacterGroup::Ground(agents) => self.visit_agents(sim.time_s(), agents, first, is_end),
            AnyCharacterGroup::Air(agents) => self.visit_agents(sim.time_s(), agents, first, is_end),
            _ => {}
        }
    }

    fn visit_agents<V: Space>(&mut self, now: f64, agents: &SceneAgents<V>, first: usize, is_end: bool) {
        let facing = |a: u32| {
            // Agents without a body are taken to face what their action is about.
            let to = agents.stage.faced_position(a as usize).filter(|_| agents.pose(a as usize).is_none());
            match to {
                Some(to) => (to - agents.stage.position(a)?).with_y(0.0).try_normalize(),
                None => agents.root(a as usize).map(|root| maths::rotate(root.rotation(), Vec3::Z)),
            }
        };
        let view = AgentsView { brains: agents.brains(), stage: &agents.stage, first, facing: &facing, now };
        self.meters.observe(view, is_end);
    }
}
