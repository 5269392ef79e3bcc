//! Geometry inferred from contacts, for captured motion whose surroundings nobody measured.
//!
//! What a body stands, sits and hangs on must be where its feet, seat and hands stay in the world while the rest of it
//! moves: level plates under feet and seats, bars in hands. Nothing is known about where nobody touched.

mod bars;
mod places;
mod plates;
mod report;

use super::placed::PlacedGeometry;
use super::{Bounds, EnvironmentFile, Place, Shape, TouchConfig, Unit, UnitSet, geometries};
use crate::annotate::ContactConfig;
use crate::clip::Clip;
use crate::error::BuildError;
use crate::files::write_atomically;
use bars::Bar;
use glam::Vec3;
use places::Kind;
use plates::Plate;
pub use report::InferReport;
use std::path::{Path, PathBuf};
use throng_runtime::Skeleton;

/// Pieces nearer to each other than this are one unit. [Unit: m]
const UNIT_GAP: f32 = 0.75;

/// An environment inferred from motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Inferred {
    /// A unit for each group of pieces.
    pub units: UnitSet,
    /// Where they stand.
    pub environment: EnvironmentFile,
    /// What was found and how well it explains the motion.
    pub report: InferReport,
}

/// Infers what clips were captured on; their ground is y = 0 and is not among the units.
///
/// - `clips`: captured in one environment, in the same frame.
/// - `name`: of the environment.
///
/// # Errors
/// [`BuildError::Stage`] where no place but the ground was touched.
pub fn infer(clips: &[&Clip], skeleton: &Skeleton, name: &str) -> Result<Inferred, BuildError> {
    let contacts = ContactConfig::default();
    let places: Vec<_> = clips.iter().flat_map(|c| places::find(c, skeleton, &contacts)).collect();
    let hands: Vec<_> = places.iter().filter(|p| p.kind == Kind::Hand).copied().collect();
    let others: Vec<_> = places.iter().filter(|p| p.kind != Kind::Hand).copied().collect();
    let plates = plates::under(&others);
    let bars = bars::through(&hands);
    if plates.is_empty() && bars.is_empty() {
        return Err(BuildError::Stage {
            stage: "environment",
            message: format!("{name}: of {} places that were touched none is above the ground", places.len()),
            help: "Such motion needs no environment: embed it in tiles.".into(),
        });
    }
    let (units, place) = assemble(&plates, &bars);
    let environment = EnvironmentFile { name: name.to_owned(), place, ..EnvironmentFile::default() };
    let placed = environment.expand(&units, Path::new(name))?;
    let geometry = PlacedGeometry::new(&placed, &geometries(&units)?);
    let mut report = InferReport::of_places(&others, &hands, &plates, &bars);
    report.units = units.units.len();
    report.measure(clips, skeleton, &geometry, &contacts, &TouchConfig::default());
    Ok(Inferred { units, environment, report })
}

impl Inferred {
    /// Writes the environment and, beside it, its unit file, named after it with `-units` at the end.
    ///
    /// - returns the path of the unit file.
    ///
    /// # Errors
    /// [`BuildError::Io`] names the file.
    pub fn save(&self, path: &Path) -> Result<PathBuf, BuildError> {
        let stem = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let file = PathBuf::from(format!("{stem}-units.toml"));
        let units = path.with_file_name(&file);
        let environment = EnvironmentFile { units: file, ..self.environment.clone() };
        let text = toml::to_string(&environment).map_err(|e| BuildError::Config { message: e.to_string() })?;
        let head = format!("Inferred from contacts.\n{}", self.report);
        let head: String = head.lines().map(|l| format!("# {l}\n")).collect();
        let unit_text = self.units.to_toml()?;
        write_atomically(&units, |w| w.write_all(unit_text.as_bytes()))?;
        write_atomically(path, |w| w.write_all(format!("{head}{text}").as_bytes()))?;
        Ok(units)
    }
}

/// A shape in the world, and the box around it.
type Piece = (Shape, Bounds);

/// Groups pieces that are near each other into units, each with its origin on the ground below its middle.
fn assemble(plates: &[Plate], bars: &[Bar]) -> (UnitSet, Vec<Place>) {
    let pieces: Vec<Piece> = plates.iter().map(Plate::piece).chain(bars.iter().map(Bar::piece)).collect();
    let mut set = UnitSet::default();
    let mut place = Vec::new();
    for group in groups(&pieces) {
        let bounds = group.iter().fold(Bounds::EMPTY, |b, &i| b.union(pieces[i].1));
        let origin = centimetres(bounds.centre().with_y(0.0));
        let name = format!("structure_{}", set.units.len() + 1);
        let at = origin.to_array();
        place.push(Place { unit: name.clone(), at, heading_deg: 0.0, repeat: [1; 3], step: [[0.0; 3]; 3] });
        let shapes = group.iter().map(|&i| moved(&pieces[i].0, -origin)).collect();
        set.units.push(Unit { name, shapes, region: None, symmetry: 1, tile: None, floor: true });
    }
    (set, place)
}

/// Numbers of the pieces of each group, in the order of their first pieces.
fn groups(pieces: &[Piece]) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..pieces.len()).collect();
    for i in 0..pieces.len() {
        for j in 0..i {
            let (a, b) = (group[i], group[j]);
            if a != b && pieces[i].1.grown(UNIT_GAP).overlaps(&pieces[j].1) {
                group.iter_mut().filter(|g| **g == a.max(b)).for_each(|g| *g = a.min(b));
            }
        }
    }
    let members = |g: usize| (0..pieces.len()).filter(|&i| group[i] == g).collect::<Vec<_>>();
    (0..pieces.len()).map(members).filter(|m| !m.is_empty()).collect()
}

fn moved(shape: &Shape, by: Vec3) -> Shape {
    let add = |p: &[f32; 3]| millimetres(Vec3::from(*p) + by).to_array();
    match shape {
        Shape::Box { at, size, heading_deg, pitch_deg } => {
            Shape::Box { at: add(at), size: *size, heading_deg: *heading_deg, pitch_deg: *pitch_deg }
        }
        Shape::Bar { from, to, radius } => Shape::Bar { from: add(from), to: add(to), radius: *radius },
        Shape::Mesh { file } => Shape::Mesh { file: file.clone() },
    }
}

/// Files are read by people: no more digits than were measured.
fn millimetres(p: Vec3) -> Vec3 {
    (p * 1000.0).round() / 1000.0
}

fn centimetres(p: Vec3) -> Vec3 {
    (p * 100.0).round() / 100.0
}

#[cfg(test)]
mod tests;
