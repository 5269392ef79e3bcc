//! Compiler from a scene file to flat tables.

mod action_commands;
mod expectations;
mod facts;
mod graphs;

use crate::scenario::action_registry::{ActionOperand, ActionRegistry, Effect};
use crate::scenario::agent_brain::NO_NUMBER;
use crate::scenario::language::{NameKind, NameList, ScenarioVocabulary};
use crate::scenario::tables::{
    BlackboardTable, CompiledAction, EndTable, GroupTable, LearningMode, NONE, Scenario, trigger,
};
use crate::scene::{Scene, check_point};
use glam::Vec3;
use std::collections::{BTreeMap, BTreeSet};
use throng_base::Result;

/// Most events, groups, and places that are entered once, each of which is a bit.
const MOST_BITS: usize = 64;
/// Most events that agents pass on: bits of what agents sense of each other, less the one for meetings.
const MAX_SHARED_EVENTS: usize = 31;
/// Most thresholds, each of which is a bit of 32.
const MOST_THRESHOLDS: usize = 32;
/// Most edges that lead from one state; the open ones are bits of 64.
const MOST_EDGES: usize = 64;
/// Most items of any kind numbered with 16 bits, of which the last number means none.
const MOST_NUMBERS: usize = NO_NUMBER as usize;

/// Most slots of all places, as many as agents.
const MOST_SLOTS: usize = 1_000_000;
/// Most stored times at which agents followed rules with a pause (2 GB).
const MOST_PAUSES: usize = 1 << 28;

/// Distance at which agents hear news that are being told, over that at which telling begins.
const HEARING: f32 = 1.5;

/// Fault of a key's value, with its byte in the text of the value.
struct CompileFault {
    key: String,
    at: Option<usize>,
    why: String,
}

type CompileResult<T> = std::result::Result<T, CompileFault>;

fn compile_fault<T>(key: impl Into<String>, why: impl Into<String>) -> CompileResult<T> {
    Err(CompileFault { key: key.into(), at: None, why: why.into() })
}

/// Point with as many numbers as a space has dimensions.
fn checked_point(at: &[f32], key: &str, dimensions: usize) -> CompileResult<Vec3> {
    check_point(key, at, dimensions).map_err(|(key, why)| CompileFault { key, at: None, why })?;
    Ok(scene_point(at))
}

/// Refuses counts that are too large, given as (count, most, what, key).
fn check_counts(counts: &[(usize, usize, &str, &str)]) -> CompileResult<()> {
    match counts.iter().find(|(count, most, ..)| count > most) {
        Some((count, most, what, key)) => compile_fault(*key, format!("expected at most {most} {what}, found {count}")),
        None => Ok(()),
    }
}

impl Scenario {
    /// Compiles the rules, graphs, events and places of a scene; `None` where the scene has only goals.
    ///
    /// - `primitives`: primitive behaviours that actions may name.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] with file, line, column, and the nearest name that is known.
    pub fn new(scene: &Scene, primitives: &ActionRegistry) -> Result<Option<Self>> {
        if scene.has_story() { Self::compile(scene, primitives).map(Some) } else { Ok(None) }
    }

    /// Compiles a scene, whether it has a story or not.
    pub(crate) fn compile(scene: &Scene, primitives: &ActionRegistry) -> Result<Self> {
        let compiler = ScenarioCompiler::new(scene, primitives.clone());
        let compiled = compiler.and_then(ScenarioCompiler::compile);
        compiled.map_err(|w| scene.fault_within(&w.key, w.at, w.why))
    }
}

struct ScenarioCompiler<'a> {
    scene: &'a Scene,
    out: Scenario,
    /// Compiled named behaviours, by name and kind of event: first action, and whether all actions take no time.
    compiled_behaviours: BTreeMap<(String, bool, bool), (u32, bool)>,
    graph_starts: BTreeMap<String, u32>,
    /// Numbers of states, by names of graph and state.
    state_numbers: BTreeMap<(String, String), u32>,
    /// True where nobody tells or conveys the event whose actions are compiled.
    is_untold: bool,
}

impl<'a> ScenarioCompiler<'a> {
    fn new(scene: &'a Scene, primitives: ActionRegistry) -> CompileResult<Self> {
        let names = |key: &str, all: Vec<&String>| -> CompileResult<NameList> {
            let mut known = BTreeSet::new();
            for (i, name) in all.iter().enumerate() {
                if name.is_empty() || !known.insert(name) {
                    let why = format!("expected a `name` of its own, found \"{name}\"");
                    return compile_fault(format!("{key}[{i}]"), why);
                }
            }
            Ok(NameList(all.into_iter().cloned().collect()))
        };
        let of_agents: Vec<_> = scene.groups.iter().enumerate().filter(|(_, g)| g.is_of_agents()).collect();
        let kinds: BTreeSet<&String> = scene.places.iter().map(|p| &p.kind).collect();
        let states: BTreeSet<&String> = scene.graphs.values().flat_map(|g| g.states.keys()).collect();
        let mut events: Vec<&String> = scene.events.iter().map(|e| &e.name).collect();
        let happenings: Vec<String> = (0..scene.happenings.len()).map(|i| format!("happening {i}")).collect();
        events.extend(&happenings);
        let words = ScenarioVocabulary {
            groups: NameList(of_agents.iter().map(|(g, group)| group.title(*g)).collect()),
            states: NameList(states.into_iter().cloned().collect()),
            places: names("places", scene.places.iter().map(|p| &p.name).collect())?,
            kinds: NameList(kinds.into_iter().cloned().collect()),
            events: names("events", events)?,
            values: NameList(scene.values.keys().cloned().collect()),
            doors: names("environment.doors", scene.environment.doors.iter().map(|d| &d.name).collect())?,
            things: names("things", scene.things.iter().map(|t| &t.name).collect())?,
            services: names("services", scene.services.iter().map(|s| &s.name).collect())?,
            how: NameList(LearningMode::NAMES.iter().map(|h| (*h).to_string()).collect()),
            has_other: false,
            has_place: false,
            is_of_all: false,
        };
        let num_states = scene.graphs.values().map(|g| g.states.len()).sum();
        let num_edges = scene.graphs.values().map(|g| g.edges.len()).max().unwrap_or(0);
        check_counts(&[
            (words.events.0.len(), MOST_BITS, "events", "events"),
            (words.groups.0.len(), MOST_BITS, "groups of agents", "groups"),
            (scene.places.iter().filter(|p| p.once).count(), MOST_BITS, "places with `once`", "places"),
            (words.values.0.len(), MOST_BITS, "values", "values"),
            (scene.places.len(), MOST_NUMBERS, "places", "places"),
            (scene.things.len(), MOST_NUMBERS, "things", "things"),
            (scene.services.len(), MOST_NUMBERS, "services", "services"),
            (scene.environment.doors.len(), MOST_NUMBERS, "doors", "environment.doors"),
            (num_states, MOST_NUMBERS, "states of all graphs", "graphs"),
            (num_edges, MOST_NUMBERS, "edges of a graph", "graphs"),
        ])?;
        let mut first = 0;
        let groups = of_agents.iter().map(|(g, group)| {
            let agents = [first, first + group.count as u32];
            first = agents[1];
            let there = group.source.as_ref().map_or(group.count, |s| s.start.min(group.count)) as u32;
            let rates = group.source.as_ref().map_or_else(Vec::new, |s| s.rates.clone());
            let period_s = group.source.as_ref().and_then(|s| s.period_s).unwrap_or(f64::INFINITY);
            let reuses = group.source.as_ref().is_some_and(|s| s.reuse);
            GroupTable { number: *g, start: NONE, agents, num_at_start: there, rates, period_s, reuses }
        });
        let out = Scenario {
            groups: groups.collect(),
            names: words,
            primitives,
            things: scene.things.iter().map(|t| Vec3::from_array(t.at)).collect(),
            source: scene.source.clone(),
            graphs: scene.graphs.keys().cloned().collect(),
            ..Scenario::default()
        };
        let (compiled_behaviours, graph_starts, state_numbers) = Default::default();
        Ok(Self { scene, out, compiled_behaviours, graph_starts, state_numbers, is_untold: false })
    }

    fn compile(mut self) -> CompileResult<Scenario> {
        self.compile_values();
        self.compile_places()?;
        self.find_thresholds()?;
        self.compile_events()?;
        self.compile_services()?;
        self.compile_relations()?;
        self.compile_states()?;
        self.compile_rules()?;
        self.group_starts()?;
        self.compile_end()?;
        self.compile_expectations()?;
        let agents = &self.scene.agents;
        (self.out.telling_s, self.out.hearing_m) = (agents.telling_s.into(), HEARING * agents.meeting_m);
        check_counts(&[
            (self.out.paths.len(), MOST_NUMBERS, "ways that actions follow", "rules"),
            (self.out.motions.len(), MOST_NUMBERS, "tags of motion", "rules"),
        ])?;
        self.out.blackboards = BlackboardTable { cell_m: self.scene.agents.cell_m, levels: 4 };
        let needs_cells =
            self.out.actions.iter().any(
                |a| matches!(a, CompiledAction::Effect(Effect::Post, words) if words[1] != ActionOperand::Nothing),
            );
        if needs_cells && self.out.blackboards.cell_m == 0.0 {
            return compile_fault("agents.cell_m", "blackboards of cells need cells: set `agents.cell_m`, such as 5.0");
        }
        let has = |t: u16, out: &Scenario| {
            out.rules_of[usize::from(t)][0] < out.rules_of[usize::from(t)][1]
                || out.edges.iter().any(|e| e.trigger == t)
        };
        let out = &mut self.out;
        out.meets = has(trigger::MEETS, out);
        out.senses_zones =
            has(trigger::ENTERS, out) || has(trigger::LEAVES, out) || out.places.iter().any(|p| p.guidepost);
        out.senses_cells = has(trigger::CROSSES, out) || needs_cells;
        Ok(self.out)
    }

    fn group_starts(&mut self) -> CompileResult<()> {
        for g in 0..self.out.groups.len() {
            let number = self.out.groups[g].number;
            let Some(graph) = &self.scene.groups[number].graph else { continue };
            let key = format!("groups[{number}].graph");
            let Some(&start) = self.graph_starts.get(graph) else { return self.no_graph_fault(graph, &key) };
            self.out.groups[g].start = start;
        }
        Ok(())
    }

    fn compile_end(&mut self) -> CompileResult<()> {
        let end = &self.scene.end;
        let mut left = 0;
        for (i, name) in end.left.iter().enumerate() {
            left |= 1u64 << self.name_number(NameKind::Group, name, &format!("end.left[{i}]"))?;
        }
        let event = |name: &Option<String>, key: &str| {
            name.as_ref().map(|name| self.name_number(NameKind::Event, name, key)).transpose()
        };
        let (known, event) = (event(&end.known, "end.known")?, event(&end.event, "end.event")?);
        self.out.end = EndTable { left, known, event };
        Ok(())
    }

    fn name_number(&self, sort: NameKind, name: &str, key: &str) -> CompileResult<u16> {
        let found = self.out.names.number_of(sort, name);
        found.map(|n| n as u16).map_err(|why| CompileFault { key: key.into(), at: None, why })
    }

    /// Sets the names that an expression about a kind of event may use.
    fn set_scope(&mut self, trigger: u16) {
        let is_event = (trigger::EVENTS..trigger::EVENTS + self.out.names.events.0.len() as u16).contains(&trigger);
        // A behaviour of a state goes on through several events: it may name all of them.
        let any = trigger == trigger::DONE;
        self.out.names.has_other = any || is_event || trigger == trigger::MEETS;
        let event = self.scene.events.get(usize::from(trigger.wrapping_sub(trigger::EVENTS)));
        // Actions that convey may be anywhere in the file.
        let tells = self.scene.source.text().is_empty() || self.scene.source.text().contains("convey");
        self.is_untold = event.is_some_and(|event| !event.passed_on && !tells);
        self.out.names.has_place =
            any || [trigger::ENTERS, trigger::LEAVES, trigger::ARRIVES, trigger::FULL].contains(&trigger);
    }
}

/// World position of a point of the scene file (m).
pub(super) fn scene_point(of: &[f32]) -> Vec3 {
    match of {
        [x, y, z] => Vec3::new(*x, *y, *z),
        [x, z] => Vec3::new(*x, 0.0, *z),
        _ => Vec3::ZERO,
    }
}
