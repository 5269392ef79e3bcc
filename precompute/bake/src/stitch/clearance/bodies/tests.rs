//! Room for bodies against the exact geometry of every sphere.

use super::*;
use crate::environment::{UnitGeometry, UnitSet};
use crate::stitch::clearance::link_clearance::SLACK_M;
use proptest::prelude::*;
use std::path::Path;
use std::sync::Arc;
use throng_core::Skeleton;
use throng_core::format::ROTATION_BYTES;

/// A small box, one side of it in the x, y plane.
fn crate_behind() -> DistanceField {
    let text = "[[units]]\nname = \"crate\"\nshapes = [{ box = { at = [0.0, 1.2, 0.1], size = [0.2, 0.2, 0.2] } }]\n";
    let units = UnitSet::parse(text, Path::new("u.toml")).expect("units");
    DistanceField::new(&Arc::new(UnitGeometry::new(&units.units[0]).expect("shapes")))
}

/// A body in the T-pose, its arms along x.
fn bodies(contacts: Contacts, depth_m: f32) -> FrameBodies {
    let row = FrameRow { height: 0.95, planar: [0.0; 3], rotations: [0; ROTATION_BYTES] };
    let (units, skeleton) = (UnitSet::default(), Skeleton::default());
    let library = Library::without_motion(&units, &skeleton);
    FrameBodies::new(&Library { frames: &[row], contacts: &[contacts], ..library }, depth_m)
}

/// How far a unit is from what the spheres may be deep in it, below 0 where the body collides (m).
fn exact(bodies: &FrameBodies, root: Placement, unit: &DistanceField) -> f32 {
    let pose = &bodies.frames[0];
    let (centres, limits) = (pose.placed(root), bodies.limits(pose, unit));
    let of = |s: usize| unit.geometry.distance(sphere_position(&centres, s)) - limits[s];
    (0..NUM_SPHERES).map(of).fold(f32::INFINITY, f32::min)
}

proptest! {
    #[test]
    fn bodies_are_no_clearer_than_their_spheres(
        at in prop::array::uniform3(-0.6f32..0.6), heading in -3.2f32..3.2, planted in 0usize..3, depth_m in 0.0f32..0.06
    ) {
        thread_local!(static UNIT: DistanceField = crate_behind());
        let bodies = bodies([Contacts::NONE, Contacts::SEAT, Contacts::LEFT_HAND][planted], depth_m);
        let root = Placement::new(at[0], 0.5 * at[1], at[2], heading);
        UNIT.with(|unit| {
            let exact = exact(&bodies, root, unit);
            match bodies.room(0, root, unit, SLACK_M) {
                UnitRoom::Clear(clear) => {
                    prop_assert!(clear <= exact + 1e-4 && clear >= exact.min(0.2) - 0.08, "{} {}", clear, exact);
                }
                UnitRoom::Taken(ball) => prop_assert!(unit.geometry.distance(ball.centre) < ball.limit + 1e-4),
            }
            // What touches just so is rounded to either side.
            prop_assert!(exact.abs() < 1e-4 || bodies.collides(0, root, unit) == (exact < 0.0), "{}", exact);
            Ok(())
        })?;
    }
}

#[test]
fn beyond_the_grid_a_body_is_no_clearer_than_its_thickest_sphere() {
    let (unit, thick) = (crate_behind(), bodies(Contacts::NONE, 0.0));
    let radius = thick.spheres.iter().map(|s| s.radius).fold(0.0, f32::max);
    assert!((0.1..0.13).contains(&radius), "{radius}");
    // Its back is to the crate, and all spheres of its trunk are a little farther from it than the grid reaches.
    let root = Placement::new(0.0, 0.0, -DistanceField::MARGIN_M - 0.004, std::f32::consts::PI);
    let exact = exact(&thick, root, &unit);
    assert!(exact < SLACK_M - 0.02 && thick.reaches[0].least_distance(root, &unit) < 0.0, "{exact}");
    let UnitRoom::Clear(clear) = thick.room(0, root, &unit, SLACK_M) else { panic!("the body does not collide") };
    assert!(clear <= exact && clear > exact - 0.02, "{clear} {exact}");
    // With the default depth, as far as is asked for.
    let thin = bodies(Contacts::NONE, 0.05);
    assert_eq!(thin.room(0, root, &unit, SLACK_M), UnitRoom::Clear(SLACK_M));
}
