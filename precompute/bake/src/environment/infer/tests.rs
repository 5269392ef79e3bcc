use super::super::{Environment, PlacedUnit};
use super::*;
use glam::Quat;
use throng_core::NUM_JOINTS;
use throng_core::patch::Placement;

fn clip(positions: Vec<Vec3>) -> Clip {
    let rotations = vec![Quat::IDENTITY; positions.len() * NUM_JOINTS];
    Clip::new("c", 30.0, positions, rotations)
}

/// A stiff body that stands for a second at each place and sways over it: feet fixed, hips not.
fn standing_at(heights: &[f32]) -> Clip {
    let s = Skeleton::default();
    let mut positions = Vec::new();
    let mut leans = Vec::new();
    for (i, h) in heights.iter().enumerate() {
        for f in 0..30 {
            positions.push(s.offsets[0] + Vec3::new(0.0, *h, 0.8 * i as f32));
            leans.push(0.15 * (f as f32 / 29.0 * std::f32::consts::PI).sin());
        }
        for f in 1..10 {
            let t = f as f32 / 10.0;
            let next = heights.get(i + 1).copied().unwrap_or(*h);
            let arc = 0.5 * (t * std::f32::consts::PI).sin();
            positions.push(s.offsets[0] + Vec3::new(0.0, h + (next - h) * t + arc, 0.8 * (i as f32 + t)));
            leans.push(0.0);
        }
    }
    let mut clip = clip(positions);
    let ankle = s.rest_positions()[throng_core::Joint::LeftFoot.index()].y;
    for (f, lean) in leans.iter().enumerate() {
        // The whole body turns about its ankles, and the feet turn back.
        let turn = Quat::from_rotation_x(*lean);
        let pivot = Vec3::Y * (ankle - s.offsets[0].y);
        clip.root_positions[f] += pivot - turn * pivot;
        clip.rotations[f * NUM_JOINTS] = turn;
        for foot in [throng_core::Joint::LeftFoot, throng_core::Joint::RightFoot] {
            clip.rotations[f * NUM_JOINTS + foot.index()] = turn.conjugate();
        }
    }
    clip
}

#[test]
fn plates_lie_where_feet_stood() {
    let clip = standing_at(&[0.0, 0.25, 0.5, 0.5, 0.0]);
    let found = infer_environment(&[&clip], &Skeleton::default(), "steps").unwrap();
    let r = &found.report;
    assert_eq!((r.plates, r.bars, r.seat_places, r.units), (3, 0, 0, 1), "{r}");
    assert!(r.residual_max_m < 0.01 && r.on_ground * 5 == r.foot_places * 2, "{r}");
    let tops: Vec<f32> = found.units.units[0]
        .shapes
        .iter()
        .map(|s| match s {
            UnitShape::Box { at, size, .. } => at[1] + 0.5 * size[1],
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(tops.iter().zip([0.25, 0.5, 0.5]).all(|(a, b)| (a - b).abs() < 0.01), "{tops:?}");
    let mut annotated = clip.clone();
    let at = found.environment.place[0].at;
    let unit = PlacedUnit { unit: 0, placement: Placement::new(at[0], at[1], at[2], 0.0) };
    let environment = Environment { name: String::new(), units: vec![unit] };
    let geometry = PlacedGeometry::new(&environment, &geometries(&found.units).unwrap());
    let cfg = (ContactConfig::default(), crate::environment::GeometryTouchConfig::default());
    super::super::annotate_in(&mut annotated, &Skeleton::default(), &geometry, &cfg.0, &cfg.1);
    for (k, height) in [0.0, 0.25, 0.5, 0.5, 0.0].into_iter().enumerate() {
        assert!((annotated.support[39 * k + 15] - height).abs() < 0.01, "{k}: {}", annotated.support[39 * k + 15]);
    }
}

#[test]
fn what_the_body_goes_through_is_not_there() {
    let s = Skeleton::default();
    let chest = s.rest_positions()[throng_core::Joint::Chest.index()];
    let bar = |z: f32| {
        let (from, to) = ([-0.5, chest.y, chest.z + z], [0.5, chest.y, chest.z + z]);
        let bounds = BoundingBox::around_points([Vec3::from(from), Vec3::from(to)]).expanded(0.02);
        ((UnitShape::Bar { from, to, radius: 0.02 }, bounds), 1.0)
    };
    let clip = clip(vec![s.offsets[0]; 30]);
    let standing = keep_clear_pieces(&[bar(0.0), bar(-1.0)], &[&clip], &s).unwrap();
    assert_eq!(standing, [false, true], "the first bar is in the chest of the character, the second behind it");
}

#[test]
fn motion_on_the_ground_needs_no_environment() {
    let e = infer_environment(&[&standing_at(&[0.0, 0.0])], &Skeleton::default(), "flat").unwrap_err().to_string();
    assert!(e.contains("flat: of") && e.contains("none is above the ground"), "{e}");
}

#[test]
fn what_is_saved_loads_again() {
    let found = infer_environment(&[&standing_at(&[0.0, 0.3])], &Skeleton::default(), "step").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("yard.toml");
    let saved = found.save(&path).unwrap();
    let units = saved.units_out;
    assert_eq!((&saved.environment_out, &units), (&path, &folder.path().join("yard-units.toml")));
    let file = EnvironmentFile::load(&path).unwrap();
    assert_eq!((file.units.clone(), file.place.clone()), (units.clone(), found.environment.place.clone()));
    assert_eq!(UnitSet::load(&units).unwrap(), found.units);
    let geometry = found.geometry().unwrap();
    assert_eq!(file.expand(&found.units, &path).unwrap().units, geometry.units);
    let world = crate::stitch::WorldSource::load(&saved.world_out).unwrap();
    assert_eq!(world.environment(&found.units, &path).unwrap().units, geometry.units);
    assert_eq!((world.bundle, world.stitch.allow_unreachable), (folder.path().join("yard.throng"), true));
}
