//! Data of the bundle that stitching uses.

use crate::environment::{Environment, UnitGeometry, UnitSet};
use crate::stages::stage_error;
use std::{f32::consts::TAU, sync::Arc};
use throng_core::format::{FrameRow, PatchMeta, RotationCode};
use throng_core::patch::{KIND_TILE, LinkRecord, PatchTables, Placement};
use throng_core::planar::{Planar, wrap_angle};
use throng_core::{Contacts, Skeleton};
use throng_motion::error::{BuildError, Result};

/// Name of the stage in messages.
pub(super) const STAGE: &str = "stitch";

/// Error for an environment of which no world can be made.
pub(super) fn refusal_error(environment: &Environment, why: String, help: &str) -> BuildError {
    stage_error(STAGE, format!("environment {}: {why}", environment.name), help)
}

/// Data of a bundle beside its patches.
#[derive(Clone, Copy, Debug)]
pub struct Library<'a> {
    /// Name of the bundle.
    pub bundle: &'a str,
    /// Its content hash.
    pub bundle_hash: u128,
    /// Frame rate (Hz).
    pub rate_hz: f64,
    /// The patches' names and units (number of patches).
    pub names: &'a [PatchMeta],
    /// The unit objects.
    pub units: &'a UnitSet,
    /// All frames of motion.
    pub frames: &'a [FrameRow],
    /// Code of their rotations.
    pub rotation_code: &'a RotationCode,
    /// Pose group of every frame (frames.len()).
    pub groups: &'a [u32],
    /// Contacts in every frame (frames.len()).
    pub contacts: &'a [Contacts],
    /// Geometry of the unit objects (units.units.len()).
    pub geometries: &'a [Arc<UnitGeometry>],
    /// Proportions of the body.
    pub skeleton: &'a Skeleton,
}

/// A patch's units, by number instead of name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct UnitPattern {
    /// Number of each unit in the library's set, with its placement in the patch's frame.
    pub units: Vec<(usize, Placement)>,
    /// True for a tile.
    pub is_tile: bool,
}

impl Library<'_> {
    /// Checks that sizes agree, and looks up the units of every patch.
    ///
    /// # Errors
    /// [`BuildError::Stage`] if patches, names, groups and frames do not match.
    pub(super) fn patterns(&self, patches: &PatchTables) -> Result<Vec<UnitPattern>> {
        let damaged = |message: String| stage_error(STAGE, message, "Build the bundle again with `throng build`");
        let frames = [self.frames.len(), self.groups.len(), self.contacts.len()];
        let units = [self.units.units.len(), self.geometries.len()];
        if self.names.len() != patches.patches.len() || frames[1..] != [frames[0]; 2] || units[1] != units[0] {
            let (bundle, count, names) = (self.bundle, patches.patches.len(), self.names.len());
            return Err(damaged(format!(
                "bundle {bundle} has {count} patches with {names} names, {frames:?} frames with pose groups and contacts, \
                 {units:?} units with geometries"
            )));
        }
        let number = |name: &str| self.units.units.iter().position(|u| u.name == name);
        let pattern = |(p, meta): (usize, &PatchMeta)| {
            let units: Result<Vec<_>, String> =
                meta.units.iter().map(|(name, at)| number(name).map(|n| (n, *at)).ok_or(name.clone())).collect();
            let is_tile = patches.patches[p].kind == KIND_TILE;
            match units {
                Ok(units) if !units.is_empty() => Ok(UnitPattern { units, is_tile }),
                Ok(_) => Err(damaged(format!("patch {} of bundle {} has no units", meta.name, self.bundle))),
                Err(unit) => Err(damaged(format!(
                    "patch {} of bundle {} has the unit {unit}, which the bundle does not describe",
                    meta.name, self.bundle
                ))),
            }
        };
        self.names.iter().enumerate().map(pattern).collect()
    }

    /// Angle of rotational symmetry of a unit (rad).
    pub(super) fn period(&self, unit: usize) -> f32 {
        TAU / self.units.units[unit].symmetry.max(1) as f32
    }

    /// Description of a placed unit: its name, number and place.
    pub(super) fn describe(&self, environment: &Environment, index: usize) -> String {
        let placed = &environment.units[index];
        let (name, Placement { x, y, z, heading, .. }) = (&self.units.units[placed.unit].name, placed.placement);
        let deg = wrap_angle(heading).to_degrees();
        format!("unit {name} (place {index}, at {x:.2}, {y:.2}, {z:.2}, heading {deg:.0} deg)")
    }

    /// Root of every frame of a link in its patch's frame; y is the height of the clip's ground.
    ///
    /// (num_frames + 1)
    pub fn link_roots<'s>(&'s self, link: &LinkRecord) -> impl Iterator<Item = Placement> + use<'s> {
        let (link, n) = (*link, f32::from(link.num_frames));
        let planar = move |k: u32| {
            let [x, z, heading] = self.frames[(link.frame + k) as usize].planar;
            Planar::new(x, z, heading)
        };
        let first = planar(0);
        let nominal = move |k: u32| link.start.planar().compose(first.to_local(planar(k)));
        let last = nominal(u32::from(link.num_frames));
        let missing = Placement::new(
            link.end.x - last.x,
            link.end.y - link.start.y,
            link.end.z - last.z,
            link.end.heading - last.heading,
        );
        (0..=u32::from(link.num_frames)).map(move |k| {
            let (at, share) = (nominal(k), k as f32 / n);
            Placement::new(
                at.x + share * missing.x,
                link.start.y + share * missing.y,
                at.z + share * missing.z,
                at.heading + share * missing.heading,
            )
        })
    }
}

/// Placement with a heading within one period, so that copies of a unit that look alike have nearly equal headings.
///
/// The range begins at an unusual angle for placed things, so that headings on either side of a usual one stay
/// together.
pub(super) fn normalised(placement: Placement, period: f32) -> Placement {
    const FROM: f32 = -0.371;
    let turns = placement.heading / period - FROM;
    Placement { heading: (turns - turns.floor() + FROM) * period, ..placement }
}

/// Absolute angle between `a` and `b`, modulo `period` (rad).
pub(super) fn turn_difference(a: f32, b: f32, period: f32) -> f32 {
    let r = (a - b) / period;
    (r - r.round()).abs() * period
}

#[cfg(test)]
impl<'a> Library<'a> {
    /// Library of a bundle without motion.
    pub(super) fn without_motion(units: &'a UnitSet, skeleton: &'a Skeleton) -> Self {
        static REST: std::sync::LazyLock<RotationCode> = std::sync::LazyLock::new(RotationCode::of_rest_pose);
        let (names, frames, groups, contacts, geometries) = (&[], &[], &[], &[], &[]);
        let (bundle, bundle_hash, rate_hz, rotation_code) = ("b", 0, 30.0, &*REST);
        Self {
            bundle,
            bundle_hash,
            rate_hz,
            names,
            units,
            frames,
            rotation_code,
            groups,
            contacts,
            geometries,
            skeleton,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use std::f32::consts::{FRAC_PI_2, PI};

    #[test]
    fn headings_that_look_the_same_are_normalised_to_the_same() {
        let at = |heading| normalised(Placement::new(1.0, 2.0, 3.0, heading), FRAC_PI_2).heading;
        for k in -5..5 {
            let h = k as f32 * FRAC_PI_2;
            assert!(at(h).abs() < 1e-5 && (at(h + 0.01) - 0.01).abs() < 1e-5 && (at(h - 0.01) + 0.01).abs() < 1e-5);
        }
        assert!((normalised(Placement::new(0.0, 0.0, 0.0, PI), TAU).heading - PI).abs() < 1e-5);
        assert!(turn_difference(3.2, 0.05, FRAC_PI_2) < 0.02 && turn_difference(0.8, 0.0, FRAC_PI_2) > 0.7);
    }

    #[test]
    fn a_link_begins_and_ends_where_it_says() {
        let mut frames = vec![FrameRow::zeroed(); 5];
        for (k, f) in frames.iter_mut().enumerate() {
            f.planar = [k as f32, 2.0 * k as f32, 0.1 * k as f32];
        }
        let (units, skeleton) = (UnitSet::default(), Skeleton::default());
        let library = Library { frames: &frames, ..Library::without_motion(&units, &skeleton) };
        let (start, end) = (Placement::new(1.0, 0.5, 2.0, 0.7), Placement::new(-1.0, 0.9, 3.0, 7.0));
        let link = LinkRecord { from: 0, to: 1, frame: 1, num_frames: 3, tag: 0, start, end };
        let roots: Vec<_> = library.link_roots(&link).collect();
        assert_eq!(roots.len(), 4);
        for (root, expected) in [(roots[0], start), (roots[3], end)] {
            assert!((root.translation() - expected.translation()).length() < 1e-5);
            assert!((root.heading - expected.heading).abs() < 1e-5);
        }
        assert!((roots[1].y - (0.5 + 0.4 / 3.0)).abs() < 1e-5);
    }
}
