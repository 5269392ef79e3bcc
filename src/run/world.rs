//! `throng run` of a scene in a world of patches.

use super::Args;
use crate::args::{Outcome, fail};
use crate::{output, stitch};
use throng_precompute::environment::{Environment, PlacedGeometry, PlacedUnit};
use throng_precompute::picture;
use throng_precompute::scene::RunConfig;
use throng_precompute::scene::world::{self, WorldReport, WorldScene};
use throng_precompute::stitch::{Kit, WorldSource};
use throng_runtime::world::{WorldGraph, WorldView};

/// Characters that are recorded for the picture, from the first: one of them is shown.
const RECORDED: usize = 48;

/// Runs a scene in a world, which is stitched where that has not been done.
pub fn run(args: &Args) -> Outcome {
    let mut scene = WorldScene::load(&args.file)?;
    if !args.without.is_empty() {
        return fail("--without is for scenes on bundles; take wishes out of the scene file");
    }
    args.crowd.change_living(&mut scene.characters, &mut scene.seed)?;
    scene.check(&args.file)?;
    let mut source = WorldSource::load(&scene.world)?;
    if let Some(bundle) = &args.bundle {
        (source.bundle, source.config) = (bundle.clone(), None);
    }
    let tables = stitch::bundle(&source, &args.cache)?;
    let file = stitch::open(&source, &scene.world, &tables)?;
    let graph = WorldGraph::new(tables.patches(), file.view())?;
    let geometry = geometry(&Kit::new(&tables, &source.bundle)?, &file.view(), &scene.name);
    let followed = match (&args.png, scene.picture.follow) {
        (None, _) => Vec::new(),
        (Some(_), Some(one)) if one < scene.characters => vec![one],
        (Some(_), Some(one)) => {
            return fail(format!("picture.follow: expected a character below {}, found {one}", scene.characters));
        }
        (Some(_), None) => (0..scene.characters.min(RECORDED)).collect(),
    };
    let config = RunConfig { recorded: args.png.is_some(), ..args.crowd.scene_run() };
    let (report, record) = world::run(&scene, &tables, &graph, &geometry, &config, &followed)?;
    if let Some(png) = &args.png {
        picture::inhabited_sheet(&scene, &report, &record, &geometry, &followed).save_png(png)?;
    }
    for (time_s, character, what) in record.faults.iter().take(5) {
        eprintln!("at {time_s:.1} s, character {character}: {what}");
    }
    if args.json { output::json(&report) } else { print(&report) }
}

/// What stands in a world.
pub fn geometry(kit: &Kit, world: &WorldView<'_>, name: &str) -> PlacedGeometry {
    let units = world.units.iter().map(|u| PlacedUnit { unit: u.unit as usize, placement: u.placement }).collect();
    PlacedGeometry::new(&Environment { name: name.to_owned(), units }, &kit.geometries)
}

fn print(r: &WorldReport) -> Outcome {
    output::table(&[
        ("scene", format!("{}: {} character(s), {:.0} s", r.scene, r.characters, r.simulated_s)),
        (
            "people",
            format!(
                "{} time(s) in each other, {:.2} m at most; {} stuck",
                r.character_overlaps, r.deepest_overlap_m, r.stuck
            ),
        ),
        (
            "surroundings",
            format!("{} time(s) in a unit, {:.2} m at most", r.environment_penetrations, r.deepest_penetration_m),
        ),
        (
            "wishes",
            format!(
                "{:.2} fulfilled and {:.0} m travelled a minute and character; waiting {:.1} % of the time",
                r.fulfilled_per_minute,
                r.travelled_m_per_minute,
                100.0 * r.waiting_fraction
            ),
        ),
        (
            "foot slip",
            format!(
                "{:.3} m/s mean, {:.3} m/s 95th percentile, while planted",
                r.foot_slip_mean_mps, r.foot_slip_p95_mps
            ),
        ),
        ("speed", format!("{:.0} steps a second of everybody, on one thread", r.steps_per_second)),
    ])
}
