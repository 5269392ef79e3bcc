//! Who is near has an entity for every joint.

use crate::crowd::{Crowd, Entered};
use crate::step::Eye;
use bevy::prelude::*;
use throng_runtime::{CharacterGroup, Joint, Mat3x4, NUM_JOINTS};

/// Who has joints keeps them this much farther away, so that they do not come and go at a border (m).
const KEPT_M: f32 = 1.0;

/// The joints of a character that is near, children of its entity: hats and tools are children of one.
#[derive(Component, Clone, Debug)]
pub struct Joints {
    /// In the order of [`Joint::ALL`].
    pub joints: [Entity; NUM_JOINTS],
}

/// Which joint an entity is. Its `Transform` goes from the joint to the character.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct CharacterJoint(pub Joint);

/// Joints come, follow the poses, and go.
pub fn follow(
    mut commands: Commands,
    eye: Eye,
    crowds: Query<&Crowd>,
    characters: Query<(Entity, &Entered, &Joints)>,
    mut joints: Query<&mut Transform, With<CharacterJoint>>,
) {
    let Some(eye) = eye.at() else { return };
    let away = |x: f32, z: f32| Vec2::new(x, z).distance(eye);
    for (entity, entered, its) in &characters {
        let Ok(crowd) = crowds.get(entered.crowd) else { continue };
        let Some(group) = crowd.character_group() else { continue };
        let Ok(row) = group.row(entered.id) else { continue };
        let record = group.instances()[row];
        if away(record.x, record.z) > crowd.near_m + KEPT_M {
            its.joints.iter().for_each(|joint| commands.entity(*joint).try_despawn());
            commands.entity(entity).remove::<Joints>();
            continue;
        }
        for (joint, matrix) in its.joints.iter().zip(&group.bodies().model[row]) {
            if let Ok(mut transform) = joints.get_mut(*joint) {
                *transform = above(record.y, matrix);
            }
        }
    }
    for live in crowds.iter().filter_map(|crowd| crowd.live.as_ref().map(|live| (live, crowd.near_m))) {
        let (live, near_m) = live;
        let all = live.group.ids().iter().zip(live.group.instances()).zip(live.group.bodies().model);
        for ((id, record), model) in all.filter(|((_, r), _)| away(r.x, r.z) <= near_m) {
            let entity = live.entities[id.index()];
            // Nobody is the entity of who came with a snapshot.
            if entity == Entity::PLACEHOLDER || characters.contains(entity) {
                continue;
            }
            let joints = std::array::from_fn(|j| {
                let joint = (CharacterJoint(Joint::ALL[j]), above(record.y, &model[j]), ChildOf(entity));
                commands.spawn(joint).id()
            });
            commands.entity(entity).insert(Joints { joints });
        }
    }
}

/// A matrix to the character's frame, as a transform to its entity, which stands on the ground (m).
fn above(ground: f32, matrix: &Mat3x4) -> Transform {
    let [x, y, z] = matrix.translation().to_array();
    let rotation = Quat::from_array(matrix.rotation().normalize().to_array());
    Transform { translation: Vec3::new(x, y - ground, z), rotation, scale: Vec3::ONE }
}
