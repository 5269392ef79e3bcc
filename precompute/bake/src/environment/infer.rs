//! Geometry inferred from contacts, for motion captured without measured surroundings.
//!
//! Feet, seat and hands that stay in place while the rest of the body moves must be supported: level plates are
//! inferred under feet and seats, bars in hands. Pieces that the body passes through are dropped. Nothing is known
//! about places that were not touched.

mod bars;
mod places;
mod plates;
mod report;
#[cfg(test)]
mod tests;

pub use report::InferReport;

use super::{
    BodySpheres, Environment, EnvironmentFile, GeometryTouchConfig, PlacedGeometry, PlacedUnit, PlacementPattern,
    PosedSpheres, UnitObject, UnitSet, UnitShape, annotate_in, geometries,
};
use bars::InferredBar;
use glam::Vec3;
use places::TouchKind;
use plates::InferredPlate;
use std::path::Path;
use throng_core::{Skeleton, patch::Placement};
use throng_geometry::BoundingBox;
use throng_motion::error::{BuildError, Result};
use throng_motion::{annotate::ContactConfig, clip::Clip};

/// Pieces nearer to each other than this form one unit (m).
const UNIT_GAP: f32 = 0.75;

/// An environment inferred from motion.
#[derive(Clone, Debug, PartialEq)]
pub struct InferredEnvironment {
    /// Units, one for each group of pieces.
    pub units: UnitSet,
    /// Placement of the units.
    pub environment: EnvironmentFile,
    /// Counts of inferred geometry, and how well it explains the motion.
    pub report: InferReport,
}

/// Infers the geometry that clips were captured on; their ground is y = 0 and is not among the units.
///
/// - `clips`: captured in one environment, in the same frame.
/// - `name`: of the environment.
///
/// # Errors
/// [`BuildError::Stage`] if nothing but the ground was touched.
pub fn infer_environment(clips: &[&Clip], skeleton: &Skeleton, name: &str) -> Result<InferredEnvironment> {
    let contacts = ContactConfig::default();
    let places: Vec<_> = clips.iter().flat_map(|c| places::find_touches(c, skeleton, &contacts)).collect();
    let hands: Vec<_> = places.iter().filter(|p| p.kind == TouchKind::Hand).copied().collect();
    let mut plates = plates::find_plates(&places);
    let mut bars = bars::find_bars(&hands);
    // Pieces that a body passes through are dropped.
    let flat = plates.iter().map(|p| (p.piece(), p.held_s));
    let pieces: Vec<(InferredPiece, f32)> = flat.chain(bars.iter().map(|b| (b.piece(), b.held_s))).collect();
    let standing = keep_clear_pieces(&pieces, clips, skeleton)?;
    let mut stands = standing.iter().copied();
    plates.retain(|_| stands.next().unwrap_or(true));
    bars.retain(|_| stands.next().unwrap_or(true));
    if plates.is_empty() && bars.is_empty() {
        return Err(BuildError::Stage {
            stage: "environment",
            message: format!("{name}: of {} places that were touched none is above the ground", places.len()),
            help: "Such motion needs no environment: embed it in tiles.".into(),
        });
    }
    let (units, place) = assemble(&plates, &bars);
    let environment = EnvironmentFile { name: name.to_owned(), place, ..EnvironmentFile::default() };
    let report = InferReport::from_places(&places, &plates, &bars);
    let mut inferred = InferredEnvironment { units, environment, report };
    inferred.report.dismissed = standing.iter().filter(|s| !**s).count();
    inferred.report.units = inferred.units.units.len();
    let geometry = inferred.geometry()?;
    inferred.report.measure(clips, skeleton, &geometry);
    Ok(inferred)
}

impl InferredEnvironment {
    /// Geometry of the placed units, and the ground.
    ///
    /// # Errors
    /// As [`EnvironmentFile::expand`] and [`geometries`], where it was changed by hand.
    pub fn geometry(&self) -> Result<PlacedGeometry> {
        let placed = self.environment.expand(&self.units, Path::new(&self.environment.name))?;
        Ok(PlacedGeometry::new(&placed, &geometries(&self.units)?))
    }
}

/// A shape in the world, and its bounds.
type InferredPiece = (UnitShape, BoundingBox);

/// Groups nearby pieces into units, each with its origin on the ground below its centre.
fn assemble(plates: &[InferredPlate], bars: &[InferredBar]) -> (UnitSet, Vec<PlacementPattern>) {
    let pieces: Vec<InferredPiece> =
        plates.iter().map(InferredPlate::piece).chain(bars.iter().map(InferredBar::piece)).collect();
    let mut set = UnitSet::default();
    let mut place = Vec::new();
    for group in group_pieces(&pieces) {
        let bounds = group.iter().fold(BoundingBox::EMPTY, |b, &i| b.union(pieces[i].1));
        // In whole centimetres.
        let origin = (bounds.centre().with_y(0.0) * 100.0).round() / 100.0;
        let name = format!("structure_{}", set.units.len() + 1);
        let at = origin.to_array();
        place.push(PlacementPattern { unit: name.clone(), at, heading_deg: 0.0, repeat: [1; 3], step: [[0.0; 3]; 3] });
        let shapes = group.iter().map(|&i| move_shape(&pieces[i].0, -origin)).collect();
        set.units.push(UnitObject { name, shapes, region: None, symmetry: 1, tile: None, floor: true });
    }
    (set, place)
}

/// Indices of the pieces of each group, in the order of their first pieces.
fn group_pieces(pieces: &[InferredPiece]) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..pieces.len()).collect();
    for i in 0..pieces.len() {
        for j in 0..i {
            let (a, b) = (group[i], group[j]);
            if a != b && pieces[i].1.expanded(UNIT_GAP).overlaps(&pieces[j].1) {
                group.iter_mut().filter(|g| **g == a.max(b)).for_each(|g| *g = a.min(b));
            }
        }
    }
    let of_group = |g: usize| (0..pieces.len()).filter(|&i| group[i] == g).collect::<Vec<_>>();
    (0..pieces.len()).map(of_group).filter(|m| !m.is_empty()).collect()
}

fn move_shape(shape: &UnitShape, by: Vec3) -> UnitShape {
    let add = |p: &[f32; 3]| round_to_mm(Vec3::from(*p) + by).to_array();
    match shape {
        UnitShape::Box { at, size, heading_deg, pitch_deg } => {
            UnitShape::Box { at: add(at), size: *size, heading_deg: *heading_deg, pitch_deg: *pitch_deg }
        }
        UnitShape::Bar { from, to, radius } => UnitShape::Bar { from: add(from), to: add(to), radius: *radius },
        UnitShape::Mesh { file } => UnitShape::Mesh { file: file.clone() },
    }
}

/// Files are read by people, so they hold no more digits than were measured.
fn round_to_mm(p: Vec3) -> Vec3 {
    (p * 1000.0).round() / 1000.0
}

/// Depth in a piece from which a body passes through it; markers and skin are off by less (m).
const THROUGH: f32 = 0.07;
/// Time within a piece from which it is dropped (s).
const SHORTEST: f32 = 0.1;
/// Share of the time of support that this time must also exceed.
const SHARE: f32 = 0.2;

/// Passes the body of every usable frame to `visit`, with contacts as the geometry has them, and the time of a frame (s).
fn visit_poses(
    clips: &[&Clip],
    skeleton: &Skeleton,
    geometry: &PlacedGeometry,
    mut visit: impl FnMut(&PosedSpheres, f64),
) {
    let (body, touch) = (BodySpheres::new(skeleton), GeometryTouchConfig::default());
    for clip in clips {
        let mut annotated = (*clip).clone();
        annotate_in(&mut annotated, skeleton, geometry, &ContactConfig::default(), &touch);
        for f in (0..annotated.num_frames()).filter(|&f| annotated.is_usable(f)) {
            visit(&body.pose(&annotated.joint_transforms(skeleton, f), annotated.contacts[f]), 1.0 / annotated.rate_hz);
        }
    }
}

/// For each piece, true if no clip passes through it.
///
/// - `pieces`: in the frame of the clips, each with the time for which something was planted on it (s).
///
/// # Errors
/// As [`geometries`].
pub fn keep_clear_pieces(pieces: &[(InferredPiece, f32)], clips: &[&Clip], skeleton: &Skeleton) -> Result<Vec<bool>> {
    let unit = |(i, ((shape, _), _)): (usize, &(InferredPiece, f32))| {
        let (name, shapes) = (format!("piece_{i}"), vec![shape.clone()]);
        UnitObject { name, shapes, region: None, symmetry: 1, tile: None, floor: true }
    };
    let set = UnitSet { units: pieces.iter().enumerate().map(unit).collect() };
    let geometries = geometries(&set)?;
    let at = Placement::new(0.0, 0.0, 0.0, 0.0);
    let units = (0..pieces.len()).map(|unit| PlacedUnit { unit, placement: at }).collect();
    let all = PlacedGeometry::new(&Environment { name: String::new(), units }, &geometries);
    let mut through_s = vec![0.0f32; pieces.len()];
    visit_poses(clips, skeleton, &all, |pose, frame_s| {
        all.overlapping(&pose.bounds, |i| {
            if pose.penetration(at, &geometries[i], THROUGH).is_some() {
                through_s[i] += frame_s as f32;
            }
        });
    });
    let stands = |((_, held_s), through_s): (&(InferredPiece, f32), &f32)| *through_s <= SHORTEST.max(SHARE * held_s);
    Ok(pieces.iter().zip(&through_s).map(stands).collect())
}
