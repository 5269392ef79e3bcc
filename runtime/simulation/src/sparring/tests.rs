//! Landing, parting and practising, on made-up poses and tables.

use super::body::{BodyShape, NUM_CORE, SparringBody, StruckPart, WorldPose};
use super::landing::find_struck_capsule;
use super::*;
use glam::{Quat, Vec3};
use throng_base::{Error, Id, Inline, Result};
use throng_core::CharacterGroup;
use throng_core::body::Mat3x4;
use throng_core::bundle::Bundle;
use throng_core::characters::made_up::tables_with;
use throng_core::characters::{Blow, CharactersConfig, PolicyOrder, Spawn};
use throng_core::contacts::Contacts;
use throng_core::hits::{HitRecord, striking_offset};
use throng_core::planar::Planar;
use throng_core::skeleton::{Joint, NUM_JOINTS, Skeleton};

mod bodies;
mod pairs;
mod targets;

/// A skeleton in its rest pose, arms stretched out to the sides.
fn rest_pose() -> [Mat3x4; NUM_JOINTS] {
    Skeleton::default().rest_positions().map(|p| Mat3x4::from_rotation_translation(Quat::IDENTITY, p))
}

/// A blow with the left fist.
fn blow(point: Vec3, direction: Vec3) -> Blow {
    Blow { joint: Joint::LeftHand, point, direction, speed_mps: 5.0, force: 0.5, ..Blow::NONE }
}

/// A hit at a frame of the made-up tables.
fn hit(frame: u32, position: Vec3, direction: Vec3) -> HitRecord {
    HitRecord {
        frame,
        kind: 0,
        joint: Joint::LeftHand as u32,
        force: 1.0,
        position: position.to_array(),
        speed_mps: 6.0,
        direction: direction.to_array(),
        reserved: 0,
    }
}

/// Pairs, some way apart and face to face.
fn facing(num_pairs: usize, distance: f32) -> Vec<[Spawn; 2]> {
    let pair = |i: usize| {
        let (x, heading) = (5.0 * i as f32, 0.3 * i as f32);
        let first = Planar::new(x, -2.0, heading);
        let second = first.compose(Planar::new(0.0, distance, std::f32::consts::PI));
        [first, second].map(|root| Spawn { root, state: Some((i % 4) as u32), floor_m: 0.0 })
    };
    (0..num_pairs).map(pair).collect()
}

/// Pairs that follow the first policy.
fn spar(tables: &Bundle, config: SparringConfig, pairs: &[[Spawn; 2]]) -> Result<Sparring> {
    let mut sparring = Sparring::with_capacity(tables, pairs.len(), config)?;
    for pair in pairs {
        let first = sparring.spawn(*pair)?;
        for id in [first, sparring.opponent(first)?] {
            sparring.order(id, PolicyOrder::towards(0, Vec3::ZERO))?;
        }
    }
    Ok(sparring)
}

fn config() -> SparringConfig {
    SparringConfig::default()
}
