//! Equality of sets of placed units: blocks are equal if their units are placed alike relative to each other.

use crate::environment::{PlacedUnit, UnitSet};
use std::f32::consts::TAU;
use throng_core::{patch::Placement, planar::wrap_angle};

/// Largest distance of units in the same place (m).
const PLACE_M: f32 = 0.05;
/// Largest heading difference of equal placements (rad).
const HEADING_RAD: f32 = 0.0524;

/// Units in the frame of the first one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BlockShape {
    /// The units; the first one at the identity.
    pub units: Vec<PlacedUnit>,
}

impl BlockShape {
    /// Shape of placed units, and the placement of their world in the shape's frame.
    ///
    /// Units of one set are sorted by number, so that blocks of one arrangement get one name.
    pub fn new(placed: &[PlacedUnit]) -> (Self, Placement) {
        let mut units = placed.to_vec();
        units.sort_by_key(|u| u.unit);
        let to_block = units[0].placement.inverse();
        units.iter_mut().for_each(|u| u.placement = to_block.compose(u.placement).with_wrapped_heading());
        (Self { units }, to_block)
    }

    /// Placement of the world of `placed` in the shape's frame, if the two are the same block.
    ///
    /// For a symmetric block the first fit is taken: the unit that comes first in `placed`, turned as little as
    /// possible.
    pub fn fit(&self, placed: &[PlacedUnit], set: &UnitSet) -> Option<Placement> {
        if placed.len() != self.units.len() {
            return None;
        }
        let first = self.units[0].unit;
        let symmetry = set.units[first].symmetry.max(1);
        placed.iter().filter(|p| p.unit == first).find_map(|p| {
            (0..symmetry).find_map(|turn| {
                let turned = Placement::new(0.0, 0.0, 0.0, turn as f32 * TAU / symmetry as f32);
                let to_block = p.placement.compose(turned).inverse();
                self.matches(placed, to_block, set).then_some(to_block)
            })
        })
    }

    /// True if every unit has an equal one of `placed` in its place.
    fn matches(&self, placed: &[PlacedUnit], to_block: Placement, set: &UnitSet) -> bool {
        let mut taken = vec![false; placed.len()];
        self.units.iter().all(|u| {
            let stands = |p: &PlacedUnit| stands_alike(u, p.unit, to_block.compose(p.placement), set);
            let found = (0..placed.len()).find(|&i| !taken[i] && stands(&placed[i]));
            found.inspect(|&i| taken[i] = true).is_some()
        })
    }
}

fn stands_alike(unit: &PlacedUnit, other: usize, at: Placement, set: &UnitSet) -> bool {
    let step = TAU / set.units[unit.unit].symmetry.max(1) as f32;
    let off = wrap_angle(at.heading - unit.placement.heading);
    unit.unit == other
        && (at.translation() - unit.placement.translation()).length() <= PLACE_M
        && (off - step * (off / step).round()).abs() <= HEADING_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environment::UnitObject;

    fn set() -> UnitSet {
        let unit = |name: &str, symmetry| UnitObject {
            name: name.into(),
            shapes: Vec::new(),
            region: None,
            symmetry,
            tile: None,
            floor: false,
        };
        UnitSet { units: vec![unit("stairs", 1), unit("table", 4)] }
    }

    fn at(unit: usize, x: f32, z: f32, heading_deg: f32) -> PlacedUnit {
        PlacedUnit { unit, placement: Placement::new(x, 0.5, z, heading_deg.to_radians()) }
    }

    fn moved(units: &[PlacedUnit], by: Placement) -> Vec<PlacedUnit> {
        units.iter().map(|u| PlacedUnit { placement: by.compose(u.placement), ..u.clone() }).collect()
    }

    #[test]
    fn the_same_arrangement_elsewhere_is_the_same_block_in_any_order() {
        let here = [at(0, 1.0, 2.0, 30.0), at(1, 2.0, 2.0, 10.0)];
        let (shape, to_block) = BlockShape::new(&here);
        let by = Placement::new(-4.0, 1.0, 3.0, 2.5);
        let mut there = moved(&here, by);
        there.reverse();
        let found = shape.fit(&there, &set()).unwrap();
        let p = glam::Vec3::new(0.3, 0.4, 0.5);
        let wanted = to_block.transform_point(p);
        assert!((found.transform_point(by.transform_point(p)) - wanted).length() < 1e-5);
    }

    #[test]
    fn a_table_turned_by_its_symmetry_is_the_same_and_stairs_are_not() {
        let (shape, _) = BlockShape::new(&[at(0, 0.0, 0.0, 0.0), at(1, 1.0, 0.0, 0.0)]);
        assert!(shape.fit(&[at(0, 0.0, 0.0, 0.0), at(1, 1.0, 0.0, 270.0)], &set()).is_some());
        assert!(shape.fit(&[at(0, 0.0, 0.0, 0.0), at(1, 1.0, 0.0, 45.0)], &set()).is_none());
        assert!(shape.fit(&[at(0, 0.0, 0.0, 90.0), at(1, 1.0, 0.0, 0.0)], &set()).is_none());
        assert!(shape.fit(&[at(0, 0.0, 0.0, 2.0), at(1, 1.02, 0.0, 0.0)], &set()).is_some(), "within the thresholds");
        assert!(shape.fit(&[at(0, 0.0, 0.0, 0.0), at(1, 1.06, 0.0, 0.0)], &set()).is_none());
        assert!(shape.fit(&[at(0, 0.0, 0.0, 0.0)], &set()).is_none());
    }

    #[test]
    fn two_tables_are_found_from_any_side() {
        let set = set();
        let (shape, _) = BlockShape::new(&[at(1, 0.0, 0.0, 0.0), at(1, 0.0, 1.0, 0.0)]);
        for turn in [0.0f32, 90.0, 180.0, 270.0] {
            let across = Placement::new(3.0, 0.0, 1.0, turn.to_radians());
            assert!(shape.fit(&moved(&[at(1, 0.0, 0.0, 0.0), at(1, 1.0, 0.0, 0.0)], across), &set).is_some());
        }
    }
}
