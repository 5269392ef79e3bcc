//! Checks of the values of a scene file.

use super::group::{GroupConfig, GroupMotion, InhabitantGoalConfig};
use super::{Scene, SpaceConfig, goal::GoalConfig, place::PlaceConfig};
use std::fmt::Display;
use throng_base::limits::{self, Limit};
use throng_base::{Result as Checked, text::TomlSource};
use toml::de::DeValue;

/// Fault of a scene file: a key, and a description of what is wrong with its value.
pub(super) type KeyFault = (String, String);

/// Most behaviours that are weighed against each other.
const MAX_BEHAVIOURS: usize = throng_core::characters::MAX_GOALS;

/// Most blend spaces of a group: each has walkers of its own.
const MAX_SPACES: usize = 64;

/// Most points on the first routes of all agents (2 GB).
const MAX_POINTS: usize = 30_000_000;

/// Most knots of the ground of all groups with paths (2 GB).
const MAX_KNOTS: usize = 1 << 29;

/// Keys of a group that only some kinds of motion have, with these kinds.
const KEYS: [(&str, &[GroupMotion]); 23] = {
    use GroupMotion::{Blend, None as Bare, Patches, Policy, Sparring};
    [
        ("place", &[Bare, Blend, Policy, Sparring]),
        ("goal", &[Bare, Blend, Policy, Patches]),
        ("via", &[Bare, Blend, Policy]),
        ("arrival_m", &[Bare, Blend, Policy]),
        ("at_end", &[Bare, Blend, Policy]),
        ("radius_m", &[Bare, Blend]),
        ("speed_mps", &[Bare, Blend]),
        ("acceleration_mps2", &[Bare, Blend]),
        ("graph", &[Bare, Blend]),
        ("companions", &[Bare, Blend]),
        ("source", &[Bare, Blend]),
        ("spaces", &[Blend]),
        ("paths", &[Blend]),
        ("style_by_speed", &[Blend]),
        ("bodies", &[Blend]),
        ("behaviours", &[Policy, Sparring]),
        ("manners", &[Policy, Sparring]),
        ("temperature", &[Policy, Sparring]),
        ("stagger_force", &[Sparring]),
        ("target", &[Policy]),
        ("world", &[Patches]),
        ("world_config", &[Patches]),
        ("goals", &[Patches]),
    ]
};

/// Refuses a file of tasks, which has no key of a scene.
pub(super) fn other_files(source: &TomlSource) -> Checked<()> {
    let Some(table) = source.table() else { return Ok(()) };
    let Some(key) = table.keys().find(|key| key.get_ref() == "tasks") else { return Ok(()) };
    let why = "`tasks` makes this a file of tasks, not a scene: run `throng plan` on it";
    Err(source.error_at_span(key.span(), why.into()))
}

/// Refuses keys that mean nothing to what moves their group.
pub(super) fn refuse_foreign_keys(scene: &Scene) -> Checked<()> {
    let Some(table) = scene.source.table() else { return Ok(()) };
    let groups = table.iter().find(|(k, _)| k.get_ref() == "groups").map(|(_, v)| v.get_ref());
    let Some(DeValue::Array(groups)) = groups else { return Ok(()) };
    for (group, value) in scene.groups.iter().zip(groups.iter()) {
        let DeValue::Table(keys) = value.get_ref() else { continue };
        for key in keys.keys() {
            if let Some((name, motions)) = KEYS.iter().find(|k| k.0 == key.get_ref())
                && !motions.contains(&group.motion)
            {
                let list: Vec<_> = motions.iter().map(|m| format!("\"{}\"", m.name())).collect();
                let (own, list) = (group.motion.name(), list.join(" or "));
                let why = format!("`{name}` is for groups with motion = {list}, and this one has \"{own}\"");
                return Err(scene.source.error_at_span(key.span(), why));
            }
        }
    }
    Ok(())
}

/// Checks all values of a scene.
pub(super) fn check_scene(scene: &Scene) -> Result<(), KeyFault> {
    check_limit("seconds", scene.seconds, &limits::SECONDS)?;
    check_numbers(&[("environment.hills_m", scene.environment.hills_m, 0.0, 10.0)])?;
    let dimensions = scene.environment.space.dimensions();
    if scene.groups.is_empty() {
        return key_fault("groups", "expected at least one group, found none");
    }
    scene.groups.iter().enumerate().try_for_each(|(g, group)| check_group(scene, g, group))?;
    check_count("groups", scene.num_characters())?;
    check_totals(scene)?;
    check_each("environment.obstacles", &scene.environment.obstacles, |o, key| o.find_fault(key, dimensions))?;
    check_each("environment.doors", &scene.environment.doors, |door, key| door.find_fault(key, dimensions))?;
    check_each("places", &scene.places, |site, key| site.find_fault(key, dimensions))?;
    check_each("services", &scene.services, |service, key| service.find_fault(key))?;
    check_each("things", &scene.things, |thing, key| thing.find_fault(key, dimensions))?;
    scene.values.iter().try_for_each(|(name, value)| value.find_fault(&format!("values.{name}")))?;
    check_each("relations", &scene.relations, |relation, key| relation.find_fault(key))?;
    check_each("rules", &scene.rules, |r, key| check_numbers(&[(&format!("{key}.pause_s"), r.pause_s, 0.0, 1e6)]))?;
    check_each("events", &scene.events, |event, key| event.find_fault(key))?;
    check_each("expect", &scene.expect, |expect, key| expect.find_fault(key))?;
    check_numbers(&[
        ("agents.meeting_m", scene.agents.meeting_m, 0.1, 100.0),
        ("agents.telling_s", scene.agents.telling_s, 0.0, 1000.0),
        ("agents.cell_m", scene.agents.cell_m, 0.0, 1000.0),
    ])?;
    check_each("happenings", &scene.happenings, |happening, key| happening.find_fault(key, dimensions))?;
    let num_of_agents = scene.groups.iter().filter(|g| g.is_of_agents()).count();
    if scene.measure.lanes.is_some() && num_of_agents < 2 {
        return key_fault("measure.lanes", format!("expected two groups of agents that meet, found {num_of_agents}"));
    }
    let needs_ground =
        [("measure.gate", scene.measure.gate.is_some()), ("measure.lanes", scene.measure.lanes.is_some())];
    if let (SpaceConfig::Air, Some((key, _))) = (scene.environment.space, needs_ground.iter().find(|n| n.1)) {
        return key_fault(key, "expected none in the air: leave it out, or set `environment.space = \"ground\"`");
    }
    scene.measure.find_fault()?;
    scene.picture.find_fault()
}

/// Checks every entry of a list.
fn check_each<T>(list: &str, entries: &[T], check: impl Fn(&T, &str) -> Result<(), KeyFault>) -> Result<(), KeyFault> {
    entries.iter().enumerate().try_for_each(|(i, entry)| check(entry, &format!("{list}[{i}]")))
}

/// Refuses numbers within their ranges whose product takes more memory than there is.
fn check_totals(scene: &Scene) -> Result<(), KeyFault> {
    let (mut points, mut knots) = (0, 0);
    for (g, group) in scene.groups.iter().enumerate() {
        if group.is_of_agents() || group.goal.is_some() {
            let (key, own) = match &group.goal {
                Some(GoalConfig::Wander { points, .. }) => ("goal.wander.points", *points),
                _ => ("via", group.via.len()),
            };
            points = group.count.saturating_mul(own + 2).saturating_add(points);
            if points > MAX_POINTS {
                let why = format!(
                    "expected routes of at most {MAX_POINTS} points for all agents, found {points}: take fewer points or agents"
                );
                return key_fault(&format!("groups[{g}].{key}"), why);
            }
        }
        let has_hills = group.motion == GroupMotion::Blend && scene.environment.hills_m > 0.0;
        if let Some(paths) = group.paths.as_ref().filter(|_| has_hills) {
            knots += paths.ground_grid().2.pow(2);
            if knots > MAX_KNOTS {
                let why = "expected less ground for all groups: take smaller areas, fewer groups, or `environment.hills_m = 0.0`";
                return key_fault(&format!("groups[{g}].paths.area_m"), why);
            }
        }
    }
    Ok(())
}

fn check_group(scene: &Scene, g: usize, group: &GroupConfig) -> Result<(), KeyFault> {
    let at = |name: &str| format!("groups[{g}].{name}");
    let dimensions = scene.environment.space.dimensions();
    check_count(&at("count"), group.count)?;
    if group.motion != GroupMotion::None && scene.bundle_of(g).0.is_none() {
        let kind = group.motion.name();
        let why = format!("\"{kind}\" needs a `bundle`, here or at the top of the file");
        return key_fault(&format!("groups[{g}]"), why);
    }
    let is_on_all_floors = scene.level.as_ref().is_some_and(|level| level.all_floors);
    let [starts, goals] = group.level_places().map(|names| names.is_some());
    let is_captured = group.motion == GroupMotion::Policy;
    if is_on_all_floors && !(starts && goals && is_captured) || !is_on_all_floors && (starts || goals) {
        let why = "people on all floors are `motion = \"policy\"`, with `place = { level = {} }` and \
                   `goal = { level = {} }`, in a scene whose `level` has `all_floors = true`";
        return key_fault(&format!("groups[{g}]"), why);
    }
    let on_ground = scene.environment.space == SpaceConfig::Ground;
    if group.is_of_agents() {
        if group.motion == GroupMotion::Blend && !on_ground {
            let why = "bodies walk on the ground: expected \"none\" in the air, found \"blend\"";
            return key_fault(&at("motion"), why);
        }
        check_agents(&at, group, dimensions)?;
    } else if group.motion == GroupMotion::Policy && group.goal.is_some() {
        if !on_ground {
            let why = "captured people walk on the ground: expected \"none\" in the air, found \"policy\"";
            return key_fault(&at("motion"), why);
        }
        check_route(&at, group, dimensions)?;
        if let ([Some(_), Some(_)], [_, ..]) = (group.level_places(), &group.via[..]) {
            return key_fault(&at("via"), "expected none for people on all floors of a level");
        }
    } else if group.motion == GroupMotion::Patches {
        check_goal_in_world(&at, group)?;
    } else if group.goal.is_some() {
        return key_fault(&at("goal"), "expected either `goal` or `paths`, found both");
    }
    match group.motion {
        GroupMotion::None => Ok(()),
        GroupMotion::Blend => check_blended(&at, group),
        GroupMotion::Policy | GroupMotion::Sparring => check_policies(&at, group),
        GroupMotion::Patches if scene.world_of(g).0.is_none() => {
            key_fault(&at("world"), "\"patches\" needs a stitched `world`, here or in `[environment]`")
        }
        GroupMotion::Patches => check_goals(&at, group),
    }
}

/// Checks the keys of agents: starts, goals, sizes and speeds.
fn check_agents(at: &impl Fn(&str) -> String, group: &GroupConfig, dimensions: usize) -> Result<(), KeyFault> {
    check_route(at, group, dimensions)?;
    let [least, most] = group.companions;
    if !(1 <= least && least <= most && most <= 4) {
        let why = format!("expected two numbers that ascend from 1 to 4, found {least} and {most}");
        return key_fault(&at("companions"), why);
    }
    if group.graph.is_some() && group.goal.is_some() {
        let why = "a group with a `graph` goes where that leads: leave it out, or let an action `go` there";
        return key_fault(&at("goal"), why);
    }
    if let Some(source) = &group.source {
        source.find_fault(&at("source"), group.count, dimensions)?;
        if let Some(PlaceConfig::Block { from, to, .. }) = &source.place {
            let wide = from.iter().zip(to).map(|(from, to)| to - from).fold(0.0, f32::max);
            check_numbers(&[(&at("source.place"), wide, 2.0 * group.radius_m[1], 1e6)])?;
        }
    }
    check_ranges(&[
        (&at("radius_m"), group.radius_m, 0.01, 100.0),
        (&at("speed_mps"), group.speed_mps, 0.0, 100.0),
        (&at("acceleration_mps2"), group.acceleration_mps2, 0.01, 1000.0),
    ])
}

/// Checks starts, subgoals and goals.
fn check_route(at: &impl Fn(&str) -> String, group: &GroupConfig, dimensions: usize) -> Result<(), KeyFault> {
    match &group.place {
        Some(PlaceConfig::Grid { .. }) => {
            return key_fault(&at("place.grid"), "agents start in a `block`, `disc` or `ring`");
        }
        Some(place) => place.find_fault(&at("place"), dimensions)?,
        None => return key_fault(&at("place"), "agents need a place to start: `block`, `disc` or `ring`"),
    }
    match &group.goal {
        Some(goal) => goal.find_fault(&at("goal"), dimensions)?,
        None if group.graph.is_some() => {}
        None if group.motion == GroupMotion::Blend => {
            return key_fault(&at("goal"), "expected `goal` or `paths`, found none");
        }
        None => return key_fault(&at("goal"), "agents need a goal; `{ stay = {} }` lets them stand"),
    }
    group
        .via
        .iter()
        .enumerate()
        .try_for_each(|(i, point)| check_point(&at(&format!("via[{i}]")), point, dimensions))?;
    check_numbers(&[(&at("arrival_m"), group.arrival_m, 0.01, 1000.0)])
}

/// Checks the keys of blended bodies and their paths.
fn check_blended(at: &impl Fn(&str) -> String, group: &GroupConfig) -> Result<(), KeyFault> {
    let num = group.spaces.len();
    if !(1..=MAX_SPACES).contains(&num) {
        let why =
            format!("expected 1 to {MAX_SPACES} blend spaces, found {num}; `throng inspect` lists those of a bundle");
        return key_fault(&at("spaces"), why);
    }
    let b = group.bodies();
    check_ranges(&[(&at("bodies.sizes"), b.sizes, 0.3, 3.0), (&at("bodies.legs"), b.legs, 0.5, 2.0)])?;
    check_numbers(&[(&at("bodies.kinds"), b.kinds, 1, 10_000)])?;
    if !group.style_by_speed.windows(2).all(|w| w[0][0] < w[1][0])
        || !group.style_by_speed.iter().flatten().all(|v| v.abs() < 1e3)
    {
        return key_fault(&at("style_by_speed"), "expected (speed, value) that ascend by speed");
    }
    let Some(p) = &group.paths else { return Ok(()) };
    if group.place.is_some() {
        return key_fault(&at("place"), "paths start anywhere on their square: expected none beside `paths`");
    }
    check_ranges(&[(&at("paths.speeds"), p.speeds, 0.0, 20.0), (&at("paths.seconds"), p.seconds, 0.1, 1000.0)])?;
    check_point(&at("paths.centre"), &p.centre, 2)?;
    check_numbers(&[
        (&at("paths.standing"), p.standing, 0.0, 1.0),
        (&at("paths.acceleration"), p.acceleration, 0.01, 1000.0),
        (&at("paths.max_gyration"), p.max_gyration, 0.0, 20.0),
        (&at("paths.sideways"), p.sideways, 0.01, 1000.0),
        (&at("paths.area_m"), p.area_m, 4.0, 10_000.0),
    ])
}

/// Checks the keys of characters with policies: behaviours and targets.
fn check_policies(at: &impl Fn(&str) -> String, group: &GroupConfig) -> Result<(), KeyFault> {
    if group.motion == GroupMotion::Sparring && !group.count.is_multiple_of(2) {
        return key_fault(&at("count"), format!("expected an even number for pairs, found {}", group.count));
    }
    match &group.place {
        _ if group.goal.is_some() => {}
        None => {}
        Some(place @ PlaceConfig::Grid { .. }) => place.find_fault(&at("place"), 2)?,
        Some(_) => return key_fault(&at("place"), "expected a `grid`, found another place"),
    }
    check_limit(&at("temperature"), group.temperature, &limits::TEMPERATURE)?;
    check_numbers(&[
        (&at("stagger_force"), group.stagger_force.unwrap_or_default(), 0.0, 10.0),
        (&at("target.height_m"), group.target.height_m, -10.0, 10.0),
        (&at("target.radius_m"), group.target.radius_m, 0.01, 1.0),
    ])?;
    let all = &group.behaviours;
    if all.is_empty() && group.goal.is_none() || all.len() > MAX_BEHAVIOURS {
        return key_fault(&at("behaviours"), format!("expected 1 to {MAX_BEHAVIOURS} behaviours, found {}", all.len()));
    }
    for (i, one) in all.iter().enumerate() {
        check_numbers(&[(&at(&format!("behaviours[{i}].weight")), one.weight, -1e6, 1e6)])?;
        if let Some(first) = all[..i].iter().position(|g| g.name == one.name) {
            let why = format!("expected every behaviour once, found \"{}\" as in `behaviours[{first}]`", one.name);
            return key_fault(&at(&format!("behaviours[{i}].name")), why);
        }
    }
    let mut before = 0.0;
    for p in &group.target.drag {
        let moderate = [p.x_m, p.y_m, p.z_m].iter().all(|v| v.abs() < 1e3);
        if !(p.time_s > before && p.time_s < 1e5 && moderate) {
            let why = format!("expected times that ascend from above 0, and places, found {p:?}");
            return key_fault(&at("target.drag"), why);
        }
        before = p.time_s;
    }
    Ok(())
}

/// Checks the goal that all characters of a group in a world have, in place of goals that they draw.
fn check_goal_in_world(at: &impl Fn(&str) -> String, group: &GroupConfig) -> Result<(), KeyFault> {
    let Some(goal) = &group.goal else { return Ok(()) };
    if !matches!(goal, GoalConfig::Point { .. } | GoalConfig::Area { .. } | GoalConfig::Wander { .. }) {
        goal.find_fault(&at("goal"), 2)?;
        return key_fault(&at("goal"), "in a world, expected a `point`, `place`, `area` or `wander`");
    }
    if !group.goals.is_empty() {
        return key_fault(&at("goals"), "expected either `goal` or `goals`, found both");
    }
    goal.find_fault(&at("goal"), 2)
}

/// Checks the goals of characters in a world.
fn check_goals(at: &impl Fn(&str) -> String, group: &GroupConfig) -> Result<(), KeyFault> {
    for (i, w) in group.goals.iter().enumerate() {
        if !(w.share > 0.0 && w.share < 1e6) {
            return key_fault(&at(&format!("goals[{i}].share")), format!("expected more than 0, found {}", w.share));
        }
        if let Some([low, high]) = w.goal.seconds()
            && !(0.0 < low && low <= high && high < 1e6)
        {
            let found = format!("expected two times that ascend from above 0, found {low} and {high}");
            return key_fault(&at(&format!("goals[{i}].goal.seconds")), found);
        }
        if let InhabitantGoalConfig::Visit { within: Some(b) } = &w.goal
            && !(b.iter().all(|v| v.abs() < 1e6) && b[0] <= b[2] && b[1] <= b[3])
        {
            let why = format!("expected lowest x and z, then highest x and z, found {b:?}");
            return key_fault(&at(&format!("goals[{i}].goal.within")), why);
        }
    }
    Ok(())
}

/// Returns a fault of a key.
pub(super) fn key_fault<T>(key: &str, why: impl Into<String>) -> Result<T, KeyFault> {
    Err((key.into(), why.into()))
}

fn check_count(key: &str, count: usize) -> Result<(), KeyFault> {
    check_limit(key, count as f64, &limits::CHARACTERS)
}

/// Checks that a number is within its limit.
fn check_limit(key: &str, value: f64, limit: &Limit) -> Result<(), KeyFault> {
    if limit.contains(value) { Ok(()) } else { key_fault(key, format!("expected {}, found {value}", limit.range)) }
}

/// Checks that numbers are between bounds, given as (key, value, lowest, highest); NaN never is.
pub(super) fn check_numbers<N: PartialOrd + Display>(numbers: &[(&str, N, N, N)]) -> Result<(), KeyFault> {
    match numbers.iter().find(|(_, value, low, high)| !(low <= value && value <= high)) {
        Some((key, value, low, high)) => key_fault(key, format!("expected {low} to {high}, found {value}")),
        None => Ok(()),
    }
}

/// Checks that ranges are between bounds, given as (key, range, lowest, highest).
pub(super) fn check_ranges(ranges: &[(&str, [f32; 2], f32, f32)]) -> Result<(), KeyFault> {
    match ranges.iter().find(|(_, [from, to], low, high)| !(low <= from && from <= to && to <= high)) {
        Some((key, [from, to], low, high)) => {
            key_fault(key, format!("expected two numbers that ascend from {low} to {high}, found {from}, {to}"))
        }
        None => Ok(()),
    }
}

/// Checks that a point has as many numbers as the scene's space has dimensions.
pub(crate) fn check_point(key: &str, point: &[f32], dimensions: usize) -> Result<(), KeyFault> {
    if point.len() != dimensions {
        let what = if dimensions == 2 { "2 numbers (x, z) on the ground" } else { "3 numbers (x, y, z) in the air" };
        return key_fault(key, format!("expected {what}, found {}", point.len()));
    }
    point.iter().try_for_each(|v| check_limit(key, f64::from(*v), &limits::COORDINATE))
}

/// Checks two opposite corners, the lowest first.
pub(super) fn check_corners(key: &str, from: &[f32], to: &[f32], dimensions: usize) -> Result<(), KeyFault> {
    check_point(&format!("{key}.from"), from, dimensions)?;
    check_point(&format!("{key}.to"), to, dimensions)?;
    if from.iter().zip(to).any(|(a, b)| a >= b) {
        return key_fault(
            key,
            format!("expected the lowest corner, then the highest, apart along every axis, found {from:?} and {to:?}"),
        );
    }
    Ok(())
}
