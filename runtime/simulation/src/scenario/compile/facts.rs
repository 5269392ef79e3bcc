//! Compilation of facts: values, places, thresholds, events, relations.

use super::{
    CompileResult, MAX_SHARED_EVENTS, MOST_SLOTS, MOST_THRESHOLDS, ScenarioCompiler, check_counts, compile_fault,
    scene_point,
};
use crate::scenario::language::{NameKind, Type};
use crate::scenario::services::ServiceTable;
use crate::scenario::tables::{
    EventTable, Party, PlaceTable, RelationTable, Scenario, Schedule, SlotTable, Threshold, ValueTable, trigger,
};
use crate::scene::{EventConfig, ServiceConfig, SiteConfig};
use glam::Vec3;
use throng_base::text::did_you_mean;

/// Room between who waits at the head of a line and who is served (m).
const PASSES_M: f32 = 0.1;

impl ScenarioCompiler<'_> {
    pub(super) fn compile_values(&mut self) {
        for value in self.scene.values.values() {
            let pull = value.rest.map_or(0.0, |_| std::f32::consts::LN_2 / value.half_life_s);
            let rest = value.rest.unwrap_or(0.0);
            let (start, rate, limits) = (value.start, value.rate_per_s, value.limits);
            self.out.values.push(ValueTable { start, rate, rest, pull, limits, thresholds: [0; 2] });
        }
    }

    pub(super) fn compile_places(&mut self) -> CompileResult<()> {
        let mut once = 0;
        for (i, site) in self.scene.places.iter().enumerate() {
            let kind = self.out.names.kinds.number_of(&site.kind).unwrap_or(0) as u16;
            let place_number = |to| self.name_number(NameKind::Place, to, &format!("places[{i}].arrow"));
            let arrow = site.arrow.as_deref().map(place_number).transpose()?;
            let first = self.out.slots.len() as u32;
            self.compile_slots(i, site)?;
            let bit = site.once.then_some(once);
            once += u8::from(site.once);
            self.out.places.push(PlaceTable {
                at: scene_point(&site.at),
                radius_m: site.radius_m,
                kind,
                guidepost: site.guidepost || arrow.is_some(),
                once: bit,
                arrow,
                slots: [first, self.out.slots.len() as u32],
                is_queue: site.queue.is_some(),
            });
        }
        Ok(())
    }

    pub(super) fn compile_slots(&mut self, place: usize, site: &SiteConfig) -> CompileResult<()> {
        let (middle, number) = (scene_point(&site.at), place as u16);
        for (n, slot) in site.slots.iter().enumerate() {
            let facing = slot.facing.as_ref().map_or(middle, |f| scene_point(f));
            self.push_slot(SlotTable { at: scene_point(&slot.at), facing, place: number }, &format!("slots[{n}]"))?;
        }
        let Some(queue) = &site.queue else { return Ok(()) };
        if !site.slots.is_empty() {
            return compile_fault(format!("places[{place}].queue"), "expected either `slots` or `queue`, found both");
        }
        let corners: Vec<Vec3> = queue.points.iter().map(|p| scene_point(p)).collect();
        // The first one faces the place, and not those behind it.
        let ahead = corners[0] - corners[1];
        let mut facing = if (middle - corners[0]).dot(ahead) > 0.0 { middle } else { corners[0] + ahead };
        let mut left = 0.0;
        for leg in corners.windows(2) {
            let length = leg[0].distance(leg[1]);
            while left <= length {
                let at = leg[0] + (leg[1] - leg[0]) * (left / length.max(1e-6));
                self.push_slot(SlotTable { at, facing, place: number }, "queue")?;
                facing = at;
                left += queue.spacing_m;
            }
            left -= length;
        }
        Ok(())
    }

    pub(super) fn compile_services(&mut self) -> CompileResult<()> {
        for (i, service) in self.scene.services.iter().enumerate() {
            let key = format!("services[{i}]");
            let tills = self.name_number(NameKind::Place, &service.tills, &format!("{key}.tills"))?;
            let num_slots = |out: &Scenario, place: u16| {
                let [first, last] = out.places[usize::from(place)].slots;
                (last - first) as usize
            };
            let num_tills = num_slots(&self.out, tills);
            if self.out.places[usize::from(tills)].is_queue || num_tills == 0 {
                return compile_fault(format!("{key}.tills"), "expected a place with `slots`, each of which is a till");
            }
            if self.out.services.iter().any(|other| other.tills == tills) {
                return compile_fault(format!("{key}.tills"), "another service has these tills");
            }
            let mut lines = Vec::new();
            for (n, name) in service.lines.iter().enumerate() {
                let key = format!("{key}.lines[{n}]");
                let line = self.name_number(NameKind::Place, name, &key)?;
                if !self.out.places[usize::from(line)].is_queue || lines.contains(&line) {
                    return compile_fault(key, "expected a place with a `queue`, each once");
                }
                lines.push(line);
            }
            if service.apart && lines.len() != num_tills {
                let why = format!("expected a line for each of {num_tills} tills, found {}", lines.len());
                return compile_fault(format!("{key}.lines"), why);
            }
            let widest_m = 2.0 * self.scene.groups.iter().map(|g| g.radius_m[1]).fold(0.0, f32::max) + PASSES_M;
            let slots = |place: u16| self.out.places[usize::from(place)].slots;
            for (n, first) in lines.iter().map(|line| slots(*line)[0]).enumerate() {
                let [head, from] = [first, slots(tills)[0]].map(|s| s as usize);
                let away = |till: &SlotTable| till.at.distance(self.out.slots[head].at);
                let near_m = self.out.slots[from..from + num_tills].iter().map(away).fold(f32::INFINITY, f32::min);
                if near_m < widest_m {
                    let why = format!(
                        "expected a line that begins {widest_m:.1} m from the tills or more, found {near_m:.1} m: who waits would bar the till"
                    );
                    return compile_fault(format!("{key}.lines[{n}]"), why);
                }
            }
            self.set_scope(trigger::STARTS);
            let priority = service.priority.as_deref();
            let priority = priority.map(|of| self.compile_expression(of, Type::Number, &format!("{key}.priority")));
            let priority = priority.transpose()?;
            self.set_scope(trigger::ENTERS);
            let balk = self.compile_condition(service.balk.as_deref(), &format!("{key}.balk"))?;
            let ServiceConfig { join, apart, time_s: time, patience_s: patience, .. } = *service;
            self.out.services.push(ServiceTable { tills, lines, join, apart, priority, time, balk, patience });
        }
        Ok(())
    }

    fn push_slot(&mut self, slot: SlotTable, key: &str) -> CompileResult<()> {
        self.out.slots.push(slot);
        self.out.goals.push((format!("places[{}].{key}", slot.place), slot.at));
        if self.out.slots.len() > MOST_SLOTS {
            let why = format!(
                "expected at most {MOST_SLOTS} slots of all places, found more: take fewer, or set a larger `spacing_m` of a `queue`"
            );
            return compile_fault(format!("places[{}].{key}", slot.place), why);
        }
        Ok(())
    }

    /// Collects all thresholds that rules and edges name, sorted by value.
    pub(super) fn find_thresholds(&mut self) -> CompileResult<()> {
        let scene = self.scene;
        let of_rules = scene.rules.iter().enumerate().map(|(i, r)| (format!("rules[{i}].on"), &r.on));
        let of_graphs = scene.graphs.iter().flat_map(|(name, graph)| {
            graph.edges.iter().enumerate().map(move |(i, e)| (format!("graphs.{name}.edges[{i}].on"), &e.on))
        });
        let mut all: Vec<Threshold> = Vec::new();
        for (key, on) in of_rules.chain(of_graphs) {
            if let Some(threshold) = self.parse_threshold(on, &key)?
                && !all.iter().any(|t| is_same_threshold(t, &threshold))
            {
                all.push(threshold);
            }
        }
        if all.len() > MOST_THRESHOLDS {
            let why = format!("expected at most {MOST_THRESHOLDS} thresholds, found {}", all.len());
            return compile_fault("rules", why);
        }
        all.sort_by(|a, b| (a.value, a.at).partial_cmp(&(b.value, b.at)).unwrap_or(std::cmp::Ordering::Equal));
        for (v, value) in self.out.values.iter_mut().enumerate() {
            let first = all.partition_point(|t| usize::from(t.value) < v);
            let last = all.partition_point(|t| usize::from(t.value) <= v);
            value.thresholds = [first as u16, last as u16];
        }
        self.out.thresholds = all;
        Ok(())
    }

    /// Parses a threshold such as `fatigue > 0.7`; `None` for other triggers.
    pub(super) fn parse_threshold(&self, on: &str, key: &str) -> CompileResult<Option<Threshold>> {
        let Some((name, rises, at)) =
            on.split_once('>').map(|(n, a)| (n, true, a)).or_else(|| on.split_once('<').map(|(n, a)| (n, false, a)))
        else {
            return Ok(None);
        };
        let (name, number) = (name.trim(), at.trim().parse::<f32>());
        let Some(value) = self.out.names.values.number_of(name) else {
            let help = did_you_mean(name, self.out.names.values.0.iter().map(String::as_str));
            return compile_fault(key, format!("there is no value `{name}`: values are declared in `[values]`.{help}"));
        };
        let [low, high] = self.out.values[value].limits;
        match number {
            Ok(at) if low <= at && at <= high => Ok(Some(Threshold { value: value as u16, at, rises })),
            _ => {
                let why = format!("expected a number within the limits of `{name}`, {low} to {high}, found `{at}`");
                compile_fault(key, why)
            }
        }
    }

    pub(super) fn trigger_number(&self, on: &str, key: &str) -> CompileResult<u16> {
        if let Some(built_in) = trigger::NAMES.iter().position(|n| *n == on) {
            return Ok(built_in as u16);
        }
        if let Some(threshold) = self.parse_threshold(on, key)? {
            let number = self.out.thresholds.iter().position(|t| is_same_threshold(t, &threshold)).unwrap_or(0);
            return Ok(trigger::EVENTS + (self.out.names.events.0.len() + number) as u16);
        }
        if let Some(event) = self.out.names.events.number_of(on) {
            return Ok(trigger::EVENTS + event as u16);
        }
        let events = self.out.names.events.0.iter().map(String::as_str);
        let help = did_you_mean(on, trigger::NAMES.into_iter().chain(events));
        let all = trigger::NAMES.join(", ");
        let why = format!("there is no event `{on}`: expected one of `[[events]]`, {all}, or `VALUE > NUMBER`.{help}");
        compile_fault(key, why)
    }

    pub(super) fn compile_events(&mut self) -> CompileResult<()> {
        let mut channel = 0;
        for (i, event) in self.scene.events.iter().enumerate() {
            if trigger::NAMES.contains(&event.name.as_str()) || event.name.contains(['<', '>']) {
                let why = format!("\"{}\" means something else: give the event another name", event.name);
                return compile_fault(format!("events[{i}].name"), why);
            }
            let table = self.compile_event(event, &format!("events[{i}]"))?;
            self.out.events.push(table);
        }
        for (i, happening) in self.scene.happenings.iter().enumerate() {
            let who = match &happening.near {
                None => None,
                Some(near) => {
                    let at = &near.at;
                    let by = |name: &str, v: f32| format!("({name} - {v}) * ({name} - {v})");
                    let far = near.radius_m * near.radius_m;
                    let axes: &[&str] = if at.len() == 3 { &["x", "y", "z"] } else { &["x", "z"] };
                    let sum: Vec<String> = axes.iter().zip(at).map(|(name, v)| by(name, *v)).collect();
                    let text = format!("{} <= {far}", sum.join(" + ")).replace("- -", "+ ");
                    // The scene's values may have the names of axes.
                    let values = std::mem::take(&mut self.out.names.values);
                    self.set_scope(trigger::EVENTS);
                    let who = self.compile_condition(Some(&text), &format!("happenings[{i}].near"));
                    self.out.names.values = values;
                    who?
                }
            };
            let (schedule, channel) = (Schedule::At(happening.time_s), happening.passed_on.then_some(0));
            let table = EventTable { schedule, who, channel, fresh_s: f64::INFINITY, ..EventTable::default() };
            self.out.events.push(table);
        }
        for event in &mut self.out.events {
            if event.channel.is_some() {
                event.channel = Some(channel);
                channel += 1;
            }
        }
        check_counts(&[(channel.into(), MAX_SHARED_EVENTS, "events that are told on", "events")])
    }

    pub(super) fn compile_event(&mut self, event: &EventConfig, key: &str) -> CompileResult<EventTable> {
        let EventConfig { at_s, between_s, every_s, period_s, when, .. } = event;
        let ways = [at_s.is_some(), between_s.is_some(), every_s.is_some(), period_s.is_some(), when.is_some()];
        if ways.iter().filter(|w| **w).count() > 1 {
            let why = "expected one of `at_s`, `between_s`, `every_s`, `period_s` and `when`, found several";
            return compile_fault(key, why);
        }
        let schedule = match event {
            EventConfig { at_s: Some(at), .. } => Schedule::At(*at),
            EventConfig { between_s: Some([from, to]), .. } => Schedule::Between(*from, *to),
            EventConfig { every_s: Some(mean), .. } => Schedule::Poisson(*mean),
            EventConfig { period_s: Some(period), .. } => Schedule::Period(*period),
            _ => Schedule::Never,
        };
        self.set_scope(trigger::EVENTS);
        let who = self.compile_condition(event.who.as_deref(), &format!("{key}.who"))?;
        self.set_scope(trigger::STARTS);
        self.out.names.is_of_all = true;
        let condition = self.compile_condition(event.when.as_deref(), &format!("{key}.when"))?;
        self.out.names.is_of_all = false;
        let mut doors = Vec::new();
        for (names, open, word) in [(&event.opens, true, "opens"), (&event.closes, false, "closes")] {
            for (d, name) in names.iter().enumerate() {
                doors.push((self.name_number(NameKind::Door, name, &format!("{key}.{word}[{d}]"))?, open));
            }
        }
        let (nobody, posted, channel) = (event.nobody, event.posted, event.passed_on.then_some(0));
        let fresh_s = event.fresh_s.unwrap_or(f64::INFINITY);
        Ok(EventTable { schedule, who, nobody, channel, posted, fresh_s, doors, condition })
    }

    pub(super) fn compile_relations(&mut self) -> CompileResult<()> {
        for (i, r) in self.scene.relations.iter().enumerate() {
            let key = format!("relations[{i}]");
            let party = |text: &str, word: &str| self.parse_party(text, &format!("{key}.{word}"));
            let (of, to) = (party(&r.of, "of")?, party(&r.to, "to")?);
            if matches!(of, Party::Place(_)) {
                let why = "expected a group, or an agent such as \"group:3\", found a place";
                return compile_fault(format!("{key}.of"), why);
            }
            if matches!(to, Party::Place(_)) && r.friendship.is_some() {
                let why = "nobody is friends with a place: expected `curiosity`";
                return compile_fault(format!("{key}.friendship"), why);
            }
            let (friendship, curiosity) = (r.friendship.unwrap_or(f32::NAN), r.curiosity.unwrap_or(f32::NAN));
            let one_sided = r.one_sided || matches!(to, Party::Place(_));
            self.out.relations.push(RelationTable { of, to, one_sided, share: r.share, friendship, curiosity });
        }
        Ok(())
    }

    pub(super) fn parse_party(&self, text: &str, key: &str) -> CompileResult<Party> {
        if let Some(place) = self.out.names.places.number_of(text) {
            return Ok(Party::Place(place as u16));
        }
        let split = text.rsplit_once(':').map(|(name, number)| (name, Some(number.parse::<u32>())));
        let (name, number) = split.unwrap_or((text, None));
        let group = self.name_number(NameKind::Group, name, key)?;
        let [first, last] = self.out.groups[usize::from(group)].agents;
        match number {
            None => Ok(Party::Group(group)),
            Some(Ok(n)) if n < last - first => Ok(Party::Agent(first + n)),
            _ => compile_fault(key, format!("expected an agent from 0 to {}, found \"{text}\"", last - first - 1)),
        }
    }
}

fn is_same_threshold(a: &Threshold, b: &Threshold) -> bool {
    (a.value, a.at.to_bits(), a.rises) == (b.value, b.at.to_bits(), b.rises)
}
