//! Error messages about agents, in the terms of their scene file.

use super::layout::CrowdLayout;
use throng_base::Error;
use throng_crowd::{CrowdError, Id, NoPath, Space};

/// Advice where there is no path.
pub(super) const NO_PATH_HELP: &str =
    "move it, open a gap in the obstacles that is wide enough, or set `agents.routes = false`";

impl<V: Space> CrowdLayout<V> {
    /// Error for two points without a path between them.
    pub(super) fn no_path_error(&self, m: usize, why: NoPath, from: V, to: V) -> Error {
        self.group_fault(Some(m), self.no_path_message(m, why, from, to), NO_PATH_HELP)
    }

    /// Description of why there is no path between two points.
    pub(super) fn no_path_message(&self, m: usize, why: NoPath, from: V, to: V) -> String {
        let key = |obstacle: usize| self.obstacle_label(obstacle);
        let who = self.agent_label(m);
        let place = |at: V| format!("{:.2?}", &at.coordinates()[..V::DIMENSIONS]);
        match why {
            NoPath::Start(s) => format!("{who} starts in {}, at {}", key(s), place(from)),
            NoPath::Goal(s) => {
                let radius = self.scene.groups[self.groups[m]].radius_m[1];
                format!("the goal {} of {who} is in {} or nearer than {radius:.2} m to it", place(to), key(s))
            }
            NoPath::Separated => {
                let gap = self.map.widest_gap(from, to);
                let gap = gap.map_or("there is no gap in the obstacles".to_owned(), |[wide, needed]| {
                    format!("the widest gap is about {wide:.2} m, and {needed:.2} m are needed for the largest `radius_m` and 0.15 m at each side")
                });
                format!("no way leads {who} from {} to {}: {gap}", place(from), place(to))
            }
        }
    }

    /// Description of an agent for messages.
    pub(super) fn agent_label(&self, m: usize) -> String {
        let Some(&g) = self.groups.get(m) else { return format!("agent {m}") };
        let name = &self.scene.groups[g].name;
        if name.is_empty() { format!("agent {m} of `groups[{g}]`") } else { format!("agent {m} of \"{name}\"") }
    }

    /// Description of an obstacle for messages: its key, where the file has it.
    fn obstacle_label(&self, obstacle: usize) -> String {
        let Some(key) = self.obstacle_keys.get(obstacle) else { return format!("obstacle {obstacle}") };
        let is_of_level = self.scene.level.is_some() && self.scene.source.value_span(key).is_none();
        if is_of_level { "a wall of the level".into() } else { format!("`{key}`") }
    }

    /// Error of the crowd engine, in the terms of the scene file. Its agents are those that are there at the start.
    pub(super) fn explain_crowd_error(&self, e: &CrowdError) -> Error {
        let number = |id: Id| (0..self.num_agents()).filter(|m| self.is_there_at_start(*m)).nth(id.index());
        let number = |id: Id| number(id).unwrap_or(usize::MAX);
        let message = match *e {
            CrowdError::Overlap { first, second, overlap_m } => {
                let (a, b) = (self.agent_label(number(first)), self.agent_label(number(second)));
                let help = "give their groups more room (`place`), or smaller radii";
                let message = format!("{a} and {b} overlap by {overlap_m:.3} m at the start");
                return self.group_fault(Some(number(first)), message, help);
            }
            CrowdError::Inside { agent, obstacle: o } => {
                let m = number(agent);
                let at = self.setup.agents.get(m).map_or(V::default(), |a| a.position);
                let message = self.no_path_message(m, NoPath::Start(o), at, at);
                return self.group_fault(Some(m), message, "move its `place`");
            }
            CrowdError::Goal { route, subgoal, obstacle: o } => {
                let who = self.setup.agents.iter().position(|m| m.route == Some(route)).unwrap_or(usize::MAX);
                format!("subgoal {subgoal} of {} is in {}", self.agent_label(who), self.obstacle_label(o))
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

#[cfg(test)]
mod tests {
    use crate::Simulation;
    use crate::scene::Scene;
    use std::path::Path;

    /// Error of a scene of two groups, of which the first has two agents that enter later.
    fn told(place: [f32; 2], more: &str) -> String {
        let text = format!(
            "[[groups]]\nname = \"a\"\nmotion = \"none\"\ncount = 3\ngoal = {{ stay = {{}} }}\n\
             place = {{ block = {{ from = [0.0, 0.0], to = [1.0, 1.0] }} }}\nsource = {{ start = 1, rates = [[0.0, 1.0]] }}\n\
             [[groups]]\nname = \"b\"\nmotion = \"none\"\ncount = 1\ngoal = {{ shift = {{ by = [20.0, 20.0] }} }}\n\
             place = {{ block = {{ from = {place:?}, to = [{}, {}] }} }}\n{more}",
            place[0] + 1.0,
            place[1] + 1.0
        );
        refused(&text)
    }

    /// Error of a scene that is refused.
    fn refused(text: &str) -> String {
        let scene = Scene::parse(text, Path::new("a.toml")).and_then(|s| s.open());
        let told = scene.and_then(|scene| Simulation::new(&scene).map(|_| ()));
        told.expect_err(text).to_string()
    }

    #[test]
    fn what_nobody_can_reach_and_what_means_nothing_is_refused_with_its_line() {
        let scene = |does: &str, more: &str| {
            format!(
                "{more}[[groups]]\nname = \"a\"\nmotion = \"none\"\ncount = 1\ngraph = \"g\"\n\
                 place = {{ block = {{ from = [0.0, 0.0], to = [2.0, 2.0] }} }}\n[graphs.g]\nlevel = \"social\"\nstart = \"a\"\n\
                 [graphs.g.states]\na = {{ do = [{does}, {{ stay = 1 }}] }}\n"
            )
        };
        let solid = "[[environment.obstacles]]\nbox = { from = [8.0, 8.0], to = [10.0, 10.0] }\n";
        let closed = "[[environment.obstacles]]\nwall = { points = [[8.0, 8.0], [12.0, 8.0], [12.0, 12.0], [8.0, 12.0], [8.0, 8.0]] }\n";
        let place = |of: &str| format!("{solid}[[places]]\nname = \"p\"\nat = [9.0, 5.0]\n{of}\n");
        let slots = place("slots = [{ at = [5.0, 5.0] }, { at = [9.0, 9.0] }]");
        let queue = place("queue = { points = [[9.0, 9.0], [9.0, 2.0]] }");
        let stays = scene("{ stay = 1 }", "");
        let goal = stays.replace("graph = \"g\"", "graph = \"g\"\ngoal = { stay = {} }");
        let door = stays.replace(
            "graph = \"g\"",
            "graph = \"g\"\nsource = { start = 0, rates = [[0.0, 1.0]], place = { block = { from = [9.0, 0.0], to = [9.1, 0.1] } } }",
        );
        let boo = "[[events]]\nname = \"boo\"\nat_s = 2.0\n[[rules]]\non = \"boo\"\ndo = [{ follow = \"other\", for_s = 3 }]\n";
        for (text, wanted) in [
            (scene("{ visit = \"p\" }", &slots), vec!["a.toml:6:", "places[0].slots[1]", "move it"]),
            (scene("{ queue = \"p\" }", &queue), vec!["a.toml:6:", "places[0].queue", "move it"]),
            (scene("{ go = [9.0, 9.0] }", solid), vec!["a.toml:13:", "do[0].go", "`environment.obstacles[0]`"]),
            (scene("{ go = [10.0, 10.0] }", closed), vec!["do[0].go", "no way leads"]),
            (goal, vec!["a.toml:6:", "groups[0].goal", "leave it out"]),
            (door, vec!["groups[0].source.place", "0.1"]),
            (scene("{ go = \"arrow\" }", ""), vec!["do[0].go", "`arrow`"]),
            (scene("{ stay = 1 }", boo), vec!["rules[0].do[0].follow", "`other`", "passed_on"]),
        ] {
            let told = refused(&text);
            assert!(wanted.iter().all(|w| told.contains(w)), "{wanted:?}: {told}");
        }
        // What is near enough, or open, is no fault.
        let open = closed.replace(", [8.0, 8.0]] }", "] }");
        let near = place("slots = [{ at = [9.0, 7.5] }]");
        let told = boo.replace("at_s = 2.0", "at_s = 2.0\npassed_on = true");
        for text in
            [scene("{ go = [10.0, 10.0] }", &open), scene("{ visit = \"p\" }", &near), scene("{ stay = 1 }", &told)]
        {
            let scene =
                Scene::parse(&text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"));
            Simulation::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        }
    }

    #[test]
    fn errors_name_the_group_of_each_agent_and_where_it_starts() {
        let overlap = told([0.0, 0.0], "");
        assert!(overlap.contains("agent 0 of \"a\" and agent 3 of \"b\" overlap"), "{overlap}");
        let wall =
            "[agents]\nroutes = false\n[[environment.obstacles]]\nbox = { from = [8.0, 8.0], to = [12.0, 12.0] }\n";
        let inside = told([9.5, 9.5], wall);
        assert!(inside.contains("agent 3 of \"b\" starts in `environment.obstacles[0]`, at ["), "{inside}");
    }
}
