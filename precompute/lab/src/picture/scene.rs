//! The picture of a scene: a sheet for each group with policies, each group on paths, each world, and all agents.

use super::discs::{crowd_sheet, travel_sheet};
use super::{Picture, sheet};
use super::{crowd_bodies::bodies_sheet, fights::fight_sheet, inhabited::inhabited_sheet, walkers::walkers_sheet};
use crate::run::{GroupReport, JointPositions, SceneRecord, SceneReport, walk_styles, world_geometry};
use std::ops::Range;
use throng_bake::environment::UnitSolid;
use throng_motion::error::Result;
use throng_simulation::{CompiledScene, SceneGroup, Simulation};

/// Length of the path of style figures, and distance between figures on it (m).
const PATH_M: f32 = 16.0;
const APART_M: f32 = 0.9;

/// Draws a scene that was run with [`crate::run::SceneRunConfig::recorded`].
///
/// # Errors
/// [`throng_motion::error::BuildError`] for a style or a world that cannot be shown.
pub fn scene_sheet(
    compiled: &CompiledScene,
    sim: &Simulation,
    report: &SceneReport,
    record: &SceneRecord,
) -> Result<Picture> {
    let scene = compiled.scene();
    let poses = |who: Range<usize>| record.poses[who].iter().flatten().copied().collect::<Vec<JointPositions>>();
    let title = |g: &GroupReport, num: usize| {
        let name =
            if report.groups.len() == 1 { report.scene.clone() } else { format!("{}, {}", report.scene, g.group) };
        format!("{name}: {num} character{}", if num == 1 { "" } else { "s" })
    };
    let mut sheets = Vec::new();
    for fight in &record.fights {
        let (g, group) = (&report.groups[fight.group], &sim.groups()[fight.group]);
        let all = group.characters.clone();
        let title = title(g, all.len());
        sheets.push(fight_sheet(&title, &g.figures, &scene.groups[group.number], fight, &poses(all)));
    }
    for world in &record.worlds {
        let is_here = |(_, g): &(usize, &SceneGroup)| g.character_group == world.character_group;
        let groups: Vec<(usize, &SceneGroup)> = sim.groups().iter().enumerate().filter(is_here).collect();
        let (Some((number, first)), Some((_, last))) = (groups.first(), groups.last()) else { continue };
        let stands = world_geometry(compiled, world.group)?;
        let (g, num) = (&report.groups[*number], last.characters.end - first.characters.start);
        // If several groups are drawn, the title has the figures of all of them, as they are printed first.
        let (title, figures) = match groups.len() {
            1 => (title(g, num), &g.figures),
            _ => (format!("{}: {num} characters", report.scene), &report.total),
        };
        let of = |(_, g): &(usize, &SceneGroup)| (scene.groups[g.number].name.clone(), poses(g.characters.clone()));
        let groups: Vec<_> = groups.iter().map(of).collect();
        sheets.push(inhabited_sheet(&title, figures, &scene.picture, world, &groups, &stands));
    }
    for paths in &record.paths {
        let (g, group) = (&report.groups[paths.group], &sim.groups()[paths.group]);
        let all = group.characters.clone();
        let title = title(g, all.len());
        let centre = scene.groups[group.number].paths.as_ref().map_or([0.0; 2], |p| p.centre);
        let styles = walk_styles(compiled, PATH_M, APART_M)?;
        sheets.push(walkers_sheet(&title, centre, &g.figures, paths, &poses(all), &styles, PATH_M));
    }
    let things = sim.things().map(|t| UnitSolid::Box { centre: t.at, rotation: t.turn, half: 0.5 * t.size });
    let things: Vec<UnitSolid> = things.collect();
    for travel in &record.travels {
        let all = travel.first..travel.first + travel.groups.len();
        let figures = report.groups.iter().zip(sim.groups()).filter(|(_, g)| all.contains(&g.characters.start));
        let figures: Vec<&GroupReport> = figures.map(|(report, _)| report).collect();
        // Several groups have the figures of all.
        let (name, of) = match figures[..] {
            [one] => (title(one, all.len()), &one.figures),
            _ => (format!("{}: {} characters", report.scene, all.len()), &report.total),
        };
        sheets.push(travel_sheet(&name, of, travel));
        sheets.push(bodies_sheet(travel, &record.poses[all], scene.environment.heights_m(), &things));
    }
    if let Some(agents) = &record.agents {
        sheets.push(crowd_sheet(&report.scene, &report.total, agents));
        let of_agents: Vec<_> = sim.groups().iter().filter(|g| scene.groups[g.number].is_of_agents()).collect();
        let all: Vec<Option<JointPositions>> =
            of_agents.iter().flat_map(|g| record.poses[g.characters.clone()].to_vec()).collect();
        if all.iter().any(Option::is_some) {
            sheets.push(bodies_sheet(agents, &all, scene.environment.heights_m(), &things));
        }
    }
    Ok(sheet(&sheets.iter().collect::<Vec<_>>()))
}
