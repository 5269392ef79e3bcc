//! Masks against scans over all frames.

use super::*;
use crate::environment::{BodySpheres, NUM_SPHERES, Sphere, UnitSet, geometries};
use crate::stitch::clearance::collision_span::nearest_sampled;
use crate::stitch::library::Library;
use bytemuck::Zeroable;
use glam::{Quat, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::path::Path;
use throng_core::format::{FrameRow, RotationCode};
use throng_core::patch::{LinkRecord, PatchRecord, PatchTables};
use throng_core::{Contacts, Skeleton};
use throng_motion::clip::joint_transforms;
use throng_world::is_set;

/// A tile whose links are random curves, on which bodies swing their limbs.
struct Walks {
    units: UnitSet,
    frames: Vec<FrameRow>,
    rotation_code: RotationCode,
    contacts: Vec<Contacts>,
    links: Vec<LinkRecord>,
    skeleton: Skeleton,
}

/// Bodies may be that deep in a unit (m).
const DEPTH_M: f32 = 0.05;

/// Of the frames, one after the other (rad).
const SWING: f32 = 0.12;

impl Walks {
    fn new(rng: &mut Pcg64Mcg) -> Self {
        let swing = |k: usize, j: usize| Quat::from_rotation_x(0.7 * (k as f32 * SWING + j as f32).sin());
        let rotation = |k: usize, j: usize| if j == 0 { Quat::IDENTITY } else { swing(k, j) };
        let rotation_code = RotationCode::fit_frames(&Skeleton::default(), 130, rotation);
        let row = |k: usize| {
            let planar = [0.0, 0.04 * k as f32, 0.01 * k as f32];
            let mut row = FrameRow { planar, height: 0.85, ..FrameRow::zeroed() };
            rotation_code.encode(&std::array::from_fn(|j| rotation(k, j)), None, &mut row);
            row
        };
        let mut place = |r: f32| {
            let heading = rng.random_range(-3.0f32..3.0);
            Placement::new(rng.random_range(-r..r), 0.0, rng.random_range(-r..r), heading)
        };
        let link = |k: u32| {
            let (start, end) = (place(1.4), place(1.4));
            let num_frames = 20 + (k % 41) as u16;
            LinkRecord { from: 0, to: 0, frame: 7 * (k % 9), num_frames, tag: 0, start, end }
        };
        let links = (0..150).map(link).collect();
        let contacts = (0..130).map(|k| Contacts([0, 1, 2, 16, 64][k / 9 % 5])).collect();
        let text = "[[units]]\nname = \"desk\"\nshapes = [\n{ box = { at = [0.0, 0.7, 0.3], size = [1.2, 0.04, 0.6] } },\n\
                    { box = { at = [0.3, 0.35, 0.4], size = [0.05, 0.7, 0.05], heading_deg = 20.0 } },\n\
                    { bar = { from = [0.0, 0.1, -0.2], to = [0.1, 1.1, -0.2], radius = 0.04 } }]\n\
                    [[units]]\nname = \"deck\"\nfloor = true\nshapes = [{ box = { at = [0.0, 0.1, 0.0], size = [1.0, \
                    0.3, 0.5], pitch_deg = 10.0 } }]\n";
        let units = UnitSet::parse(text, Path::new("u.toml")).expect("units");
        let frames = (0..130).map(row).collect();
        Self { units, frames, rotation_code, contacts, links, skeleton: Skeleton::default() }
    }

    fn with<T>(&self, sample: impl FnOnce(&LinkRoots, &FrameBodies, &[DistanceField]) -> T) -> T {
        let geometries = geometries(&self.units).expect("shapes");
        let library = Library {
            frames: &self.frames,
            rotation_code: &self.rotation_code,
            groups: &[0; 130],
            contacts: &self.contacts,
            geometries: &geometries,
            ..Library::without_motion(&self.units, &self.skeleton)
        };
        let record = PatchRecord { num_links: self.links.len() as u32, ..PatchRecord::zeroed() };
        let patches = PatchTables {
            patches: (&[record]).into(),
            edges: [].as_slice().into(),
            cells: [].as_slice().into(),
            links: (&self.links).into(),
            pairs: [].as_slice().into(),
        };
        let paths = LinkRoots::new(&patches, &library, 0);
        let bodies = FrameBodies::new(&library, DEPTH_M);
        sample(&paths, &bodies, &geometries.iter().map(DistanceField::new).collect::<Vec<_>>())
    }

    /// The body of one frame of a link.
    fn body(&self, paths: &LinkRoots, link: usize, k: usize) -> [Sphere; NUM_SPHERES] {
        let (root, frame) = (paths.roots_of_link(link)[k], &self.frames[self.links[link].frame as usize + k]);
        let turn = root.planar().rotation();
        let joints = joint_transforms(&self.skeleton, root.translation() + Vec3::Y * frame.height, |j| {
            let local = self.rotation_code.rotation(frame, j);
            if j == 0 { turn * local } else { local }
        });
        BodySpheres::new(&self.skeleton).spheres(&joints)
    }

    /// How much deeper than it may a body of a link is in a unit, below 0 where it is clear of it.
    fn excess(&self, body: &[Sphere; NUM_SPHERES], contacts: Contacts, unit: &DistanceField, at: Placement) -> f32 {
        let feet = Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0);
        let of_sphere = |s: &Sphere| {
            let near = unit.geometry.distance(at.inverse_transform_point(s.centre));
            let allowed = if contacts.any(s.contact) { s.radius + DEPTH_M } else { DEPTH_M };
            s.radius - near - allowed
        };
        let counts = |s: &&Sphere| !(unit.geometry.floor && feet.any(s.contact));
        body.iter().filter(counts).map(of_sphere).fold(f32::NEG_INFINITY, f32::max)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Every sphere of every frame against every shape, while the unit is moved about a little and far.
    #[test]
    fn masks_are_those_of_a_scan_over_all_frames(seed in any::<u64>(), kind in 0usize..2) {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let walks = Walks::new(&mut rng);
        walks.with(|paths, bodies, units| {
            let (swept, unit) = (SweptSquares::new(paths, bodies), &units[kind]);
            let mut at = Placement::new(rng.random_range(-1.0f32..1.0), 0.0, rng.random_range(-1.0f32..1.0), 0.3);
            let mut earlier: Option<(ObstacleMask, ObstacleMask, Placement)> = None;
            for step in [0.0f32, 0.01, 0.04, 0.08, 1.0] {
                let mut shift = || step * rng.random_range(-1.0f32..1.0);
                at = Placement::new(at.x + shift(), at.y + 0.1 * shift(), at.z + shift(), at.heading + shift());
                let before = earlier.as_ref().map(|(mask, _, was)| EarlierMask {
                    mask,
                    moved: MotionObstacle::greatest_shift(&unit.geometry.bounds, *was, at),
                });
                let obstacle = MotionObstacle::new(paths, bodies, unit, at);
                let (mask, anew) = (obstacle.mask(Some(&swept), before), obstacle.mask(Some(&swept), None));
                prop_assert_eq!(&mask.words, &anew.words);
                // The same root by root, as for links that have them in common.
                let before = earlier.as_ref().zip(before).map(|((_, by_roots, _), b)| EarlierMask { mask: by_roots, ..b });
                let by_roots = obstacle.mask(None, before);
                prop_assert_eq!(&by_roots.words, &anew.words);
                for (l, link) in walks.links.iter().enumerate() {
                    let contacts = |k: usize| walks.contacts[link.frame as usize + k];
                    let bodies: Vec<_> =
                        (0..=usize::from(link.num_frames)).map(|k| walks.body(paths, l, k)).collect();
                    let all: Vec<f32> =
                        bodies.iter().enumerate().map(|(k, b)| walks.excess(b, contacts(k), unit, at)).collect();
                    let deepest = nearest_sampled(all.len()).map(|k| all[k]).fold(f32::NEG_INFINITY, f32::max);
                    let hit = !mask.words.is_empty() && is_set(&mask.words, 0, l as u32);
                    // What touches just so is rounded to either side.
                    prop_assert!(deepest.abs() < 1e-4 || hit == (deepest > 0.0), "link {}: {}", l, deepest);
                    // Between the frames that are looked at, nothing gets deeper than it moves, or than it is planted.
                    for k in (1..all.len()).filter(|_| !hit) {
                        let moves = bodies[k].iter().zip(&bodies[k - 1]).map(|(a, b)| a.centre.distance(b.centre));
                        let most = moves.fold(0.0, f32::max) + if contacts(k) == contacts(k - 1) { 1e-4 } else { 0.15 };
                        prop_assert!(all[k] <= all[k - 1].max(0.0) + most, "link {}, frame {}: {}", l, k, all[k]);
                    }
                    match mask.samples.clearance_of[l] {
                        LinkClearance::Collides(touch) => prop_assert!(all[usize::from(touch.frame)] > -1e-4),
                        LinkClearance::Clear(first) => {
                            for (sample, k) in nearest_sampled(all.len()).enumerate() {
                                let clear = mask.samples.clear[first as usize + sample].least();
                                prop_assert!(clear <= (-all[k]).max(0.0) + 1e-4, "link {}, frame {}: {}", l, k, clear);
                            }
                        }
                        LinkClearance::Nothing => {}
                    }
                }
                earlier = Some((mask, by_roots, at));
            }
            Ok(())
        })?;
    }
}
