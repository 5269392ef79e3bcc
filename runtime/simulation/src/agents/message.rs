//! Error messages about agents, in the terms of their scene file.

use super::layout::CrowdLayout;
use throng_base::Error;
use throng_crowd::{CrowdError, NoPath, Space};

impl<V: Space> CrowdLayout<V> {
    /// Error for two points without a path between them.
    pub(super) fn no_path_error(&self, m: usize, why: NoPath, from: V, to: V) -> Error {
        let key = |obstacle: usize| &self.obstacle_keys[obstacle];
        let who = self.agent_label(m);
        let place = |at: V| format!("{:.2?}", &at.coordinates()[..V::DIMENSIONS]);
        let message = match why {
            NoPath::Start(s) => format!("{who} starts in `{}`, at {}", key(s), place(from)),
            NoPath::Goal(s) => {
                let radius = self.scene.groups[self.groups[m]].radius_m[1];
                format!("the goal {} of {who} is in `{}` or nearer than {radius:.2} m to it", place(to), key(s))
            }
            NoPath::Separated => {
                let gap = self.map.widest_gap(from, to);
                let gap = gap.map_or("there is no gap in the obstacles".to_owned(), |[wide, needed]| {
                    format!("the widest gap is about {wide:.2} m, and {needed:.2} m are needed for the largest `radius_m` and 0.15 m at each side")
                });
                format!("no way leads {who} from {} to {}: {gap}", place(from), place(to))
            }
        };
        let help = "move it, open a gap in the obstacles that is wide enough, or set `agents.routes = false`";
        self.group_fault(Some(m), message, help)
    }

    /// Description of an agent for messages.
    pub(super) fn agent_label(&self, m: usize) -> String {
        let Some(&g) = self.groups.get(m) else { return format!("agent {m}") };
        let name = &self.scene.groups[g].name;
        if name.is_empty() { format!("agent {m} of `groups[{g}]`") } else { format!("agent {m} of \"{name}\"") }
    }

    /// Error of the crowd engine, in the terms of the scene file.
    pub(super) fn explain_crowd_error(&self, e: &CrowdError) -> Error {
        let obstacle = |o: usize| self.obstacle_keys.get(o).cloned().unwrap_or_else(|| format!("obstacle {o}"));
        let message = match *e {
            CrowdError::Overlap { first, second, overlap_m } => {
                let (a, b) = (self.agent_label(first.index()), self.agent_label(second.index()));
                let help = "give their groups more room (`place`), or smaller radii";
                let message = format!("{a} and {b} overlap by {overlap_m:.3} m at the start");
                return self.group_fault(Some(first.index()), message, help);
            }
            CrowdError::Inside { agent, obstacle: o } => {
                format!("{} starts in `{}`", self.agent_label(agent.index()), obstacle(o))
            }
            CrowdError::Goal { route, subgoal, obstacle: o } => {
                let who = self.setup.agents.iter().position(|m| m.route == Some(route)).unwrap_or(usize::MAX);
                format!("subgoal {subgoal} of {} is in `{}`", self.agent_label(who), obstacle(o))
            }
            // All agents have the field of the scene.
            CrowdError::Other(Error::Value { what, got, expected, .. }) if what.starts_with("field.") => {
                return self.scene.fault(&format!("agents.{what}"), format!("expected {expected}, found {got}"));
            }
            _ => e.to_string(),
        };
        self.group_fault(None, message, "correct the scene file")
    }

    /// Error about an agent's group, or about all groups.
    fn group_fault(&self, m: Option<usize>, message: String, help: &str) -> Error {
        let group = m.and_then(|m| self.groups.get(m));
        self.scene.fault(&group.map_or("groups".into(), |g| format!("groups[{g}]")), format!("{message}; {help}"))
    }
}
