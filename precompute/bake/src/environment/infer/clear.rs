//! Removal of inferred pieces that the body passes through.

use super::InferredPiece;
use crate::environment::annotate_in;
use crate::environment::{
    BodySpheres, Environment, GeometryTouchConfig, PlacedGeometry, PlacedUnit, UnitObject, UnitSet, geometries,
};
use throng_core::Skeleton;
use throng_core::patch::Placement;
use throng_motion::annotate::ContactConfig;
use throng_motion::clip::Clip;
use throng_motion::error::Result;

/// Depth in a piece from which a body passes through it; markers and skin are off by less (m).
const THROUGH: f32 = 0.07;
/// Time within a piece from which it is dropped (s).
const SHORTEST: f32 = 0.1;
/// Share of the time of support that this time must also exceed.
const SHARE: f32 = 0.2;

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
    let body = BodySpheres::new(skeleton);
    let mut through_s = vec![0.0f32; pieces.len()];
    for clip in clips {
        let mut annotated = (*clip).clone();
        annotate_in(&mut annotated, skeleton, &all, &ContactConfig::default(), &GeometryTouchConfig::default());
        for f in (0..annotated.num_frames()).filter(|&f| annotated.is_usable(f)) {
            let pose = body.pose(&annotated.joint_transforms(skeleton, f), annotated.contacts[f]);
            all.overlapping(&pose.bounds, |i| {
                if pose.penetration(at, &geometries[i], THROUGH).is_some() {
                    through_s[i] += (1.0 / annotated.rate_hz) as f32;
                }
            });
        }
    }
    let stands = |((_, held_s), through_s): (&(InferredPiece, f32), &f32)| *through_s <= SHORTEST.max(SHARE * held_s);
    Ok(pieces.iter().zip(&through_s).map(stands).collect())
}
