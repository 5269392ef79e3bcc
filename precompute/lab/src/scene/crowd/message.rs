//! What is wrong with a crowd, in the words of its scene file.

use super::layout::Layout;
use throng_motion::error::BuildError;
use throng_runtime::crowd::{CrowdError, NoWay, Space};

impl<V: Space> Layout<V> {
    /// A way that does not exist, from one point to another.
    pub(super) fn no_way(&self, m: usize, why: NoWay, from: V, to: V) -> BuildError {
        let key = |obstacle: usize| &self.obstacle_keys[obstacle];
        let who = self.who(m);
        let place = |at: V| format!("{:.2?}", &at.coordinates()[..V::DIMENSIONS]);
        let message = match why {
            NoWay::Start(s) => format!("{who} starts in `{}`, at {}", key(s), place(from)),
            NoWay::Goal(s) => {
                let radius = self.scene.groups[self.groups[m]].radius_m[1];
                format!("the goal {} of {who} is in `{}` or nearer than {radius:.2} m to it", place(to), key(s))
            }
            NoWay::Separated => format!("no way leads {who} from {} to {}", place(from), place(to)),
        };
        self.fault(message, "Move it, open a gap in the obstacles that is wide enough, or set `routes = false`")
    }

    /// An agent, for messages.
    pub(super) fn who(&self, m: usize) -> String {
        let Some(&g) = self.groups.get(m) else { return format!("agent {m}") };
        let name = &self.scene.groups[g].name;
        if name.is_empty() { format!("agent {m} of `groups[{g}]`") } else { format!("agent {m} of \"{name}\"") }
    }

    /// What the engine found wrong, in the scene's words.
    pub(super) fn explain(&self, e: &CrowdError) -> BuildError {
        let obstacle = |o: usize| self.obstacle_keys.get(o).cloned().unwrap_or_else(|| format!("obstacle {o}"));
        let message = match *e {
            CrowdError::Overlap { first, second, overlap_m } => {
                let (a, b) = (self.who(first.index()), self.who(second.index()));
                let help = "Give their groups more room (`place`), or smaller radii";
                return self.fault(format!("{a} and {b} overlap by {overlap_m:.3} m at the start"), help);
            }
            CrowdError::Inside { agent, obstacle: o } => {
                format!("{} starts in `{}`", self.who(agent.index()), obstacle(o))
            }
            CrowdError::Goal { route, subgoal, obstacle: o } => {
                let who = self.setup.agents.iter().position(|m| m.route == Some(route)).unwrap_or(usize::MAX);
                format!("subgoal {subgoal} of {} is in `{}`", self.who(who), obstacle(o))
            }
            _ => e.to_string(),
        };
        self.fault(message, "Correct the scene file")
    }

    fn fault(&self, message: String, help: &str) -> BuildError {
        let message = format!("scene \"{}\": {message}", self.scene.name);
        BuildError::Stage { stage: "scene", message, help: help.into() }
    }
}
