//! `throng level`: a level of a mesh, a plan or a scene.

use crate::args::{CommandResult, fail};
use crate::{help, keys, output};
use glam::Vec2;
use std::path::{Path, PathBuf};
use throng_core::{base::error::ensure, base::limits};
use throng_level::{LEVEL_MAGIC, Level, LevelPath};
use throng_level_bake::{LevelSettings, LevelSource, bake};
use throng_precompute::{files, inspect::LevelReport, picture};
use throng_simulation::Scene;

/// Make a level, the ground that one can walk on: of a mesh (.glb, .gltf, .obj), a plan in metres (.geojson), or the obstacles
/// of a scene (.toml). Names of nodes, groups and materials mark places (`goal:NAME`, `door:NAME`, `queue:NAME`,
/// `seat:NAME`), closed ground (`no-go`) and links from a node to its child (`ladder:NAME`, `jump:NAME`, `climb:NAME`,
/// `escalator:NAME`, `elevator:NAME`); so does the extra property `throng` of a node.
#[derive(clap::Args)]
#[command(after_long_help = keys::json_keys::<LevelReport>())]
pub struct Args {
    /// Mesh, plan or scene; a level (.level) is only reported and drawn.
    #[arg(value_name = "MESH")]
    file: PathBuf,
    /// File to write; the mesh's name with `.level` where absent.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Draw the plan of each floor (PNG).
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Draw the shortest path between two named places into it, and print its length.
    #[arg(long, num_args = 2, value_names = ["FROM", "TO"])]
    path: Vec<String>,
    /// Radius that paths keep from walls (m).
    #[arg(long, value_name = "M", default_value_t = LevelSettings::default().radius_m, value_parser = limits::number_parser::<f32>(&limits::RADIUS_M))]
    radius: f32,
    /// Height that has to be free (m).
    #[arg(long, value_name = "M", default_value_t = LevelSettings::default().height_m, value_parser = limits::number_parser::<f32>(&limits::HEIGHT_M))]
    height: f32,
    /// Highest step (m).
    #[arg(long, value_name = "M", default_value_t = LevelSettings::default().climb_m, value_parser = limits::number_parser::<f32>(&limits::CLIMB_M))]
    climb: f32,
    /// Steepest slope (degrees).
    #[arg(long, value_name = "DEG", default_value_t = LevelSettings::default().slope_deg, value_parser = limits::number_parser::<f32>(&limits::SLOPE_DEG))]
    slope: f32,
    /// Print one JSON object; `throng help keys` lists its keys.
    #[arg(long)]
    json: bool,
}

/// True for the name of a level.
pub fn is_level(file: &Path) -> bool {
    file.extension().is_some_and(|e| e.eq_ignore_ascii_case("level"))
}

pub fn run(args: &Args) -> CommandResult {
    let out = args.out.clone().unwrap_or_else(|| args.file.with_extension("level"));
    let is_made = is_level(&args.file);
    ensure(is_level(&out), || format!("{}: expected a name that ends with .level", out.display()))?;
    files::check_targets(args.png.iter().chain((!is_made).then_some(&out)), std::slice::from_ref(&args.file))?;
    let file = if is_made { &args.file } else { &out };
    if !is_made {
        make(args, &out)?;
    }
    let level = Level::open(file)?;
    let mut path = LevelPath::default();
    if let [from, to] = &args.path[..] {
        let [from, to] = [level.place(from)?.at, level.place(to)?.at];
        level.path(from, to, &mut path)?;
    }
    let title = file.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    if let Some(png) = &args.png {
        picture::level_sheet(&title, &level, path.corners()).save_png(png)?;
    }
    let report = LevelReport::new(file, &level);
    if args.json {
        return output::json(&report);
    }
    output::text(format_args!("{report}\n"))?;
    if let [from, to] = &args.path[..] {
        output::text(format_args!("path       {:.1} m from \"{from}\" to \"{to}\"\n", path.length_m()))?;
    }
    help::next_step(&["inspect", &file.to_string_lossy()])
}

fn make(args: &Args, out: &Path) -> CommandResult {
    let Args { radius, height, climb, slope, .. } = *args;
    let settings = LevelSettings { radius_m: radius, height_m: height, climb_m: climb, slope_deg: slope };
    files::check_replaced(out, &LEVEL_MAGIC, "a level")?;
    let source = if args.file.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let scene = Scene::load(&args.file)?;
        let obstacles: Vec<_> = scene.environment.obstacles.iter().flat_map(|o| o.obstacles::<Vec2>()).collect();
        LevelSource::around(&obstacles)
    } else {
        LevelSource::read(&args.file)?
    };
    let mut warnings = Vec::new();
    let made = bake(&source, &settings, &mut warnings);
    let data = match made {
        Ok(data) => data,
        Err(why) => return fail(format!("{}: {why}", args.file.display())),
    };
    output::warnings(&[], &warnings);
    Ok(files::write_atomically(out, |to| data.write(&mut std::io::BufWriter::new(to)))?)
}
