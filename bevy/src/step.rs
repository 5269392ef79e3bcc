//! Bundles come, characters enter, go where they are ordered to, and leave.

use crate::bundle::ThrongBundle;
use crate::crowd::{Aim, Character, Crowd, CrowdEye, CrowdMessage, Entered, Refused};
use crate::threads::Pool;
use bevy::asset::AssetLoadFailedEvent;
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPool};
use throng_runtime::characters::{Detail, PolicyOrder, Spawn};
use throng_runtime::{CharacterGroup, Planar, STEP_S, glam};

/// Who is posed, though it has no joints yet: steps move people a little (m).
const MARGIN_M: f32 = 2.0;

fn fail(messages: &mut MessageWriter<CrowdMessage>, entity: Entity, why: String) {
    error!("{entity}: {why}");
    messages.write(CrowdMessage::Failed { entity, why });
}

/// Begins with bundles that are loaded, and adopts those that changed.
pub fn open(
    mut crowds: Query<(Entity, &mut Crowd)>,
    bundles: Res<Assets<ThrongBundle>>,
    mut changes: MessageReader<AssetEvent<ThrongBundle>>,
    mut failures: MessageReader<AssetLoadFailedEvent<ThrongBundle>>,
    mut messages: MessageWriter<CrowdMessage>,
) {
    let modified = |e: &AssetEvent<_>| if let AssetEvent::Modified { id } = e { Some(*id) } else { None };
    let changed: Vec<_> = changes.read().filter_map(modified).collect();
    // Lines after the first are where in Bevy it was noticed.
    let first_line = |text: String| text.lines().next().unwrap_or_default().to_owned();
    let failed: Vec<_> = failures.read().map(|f| (f.id, first_line(f.error.to_string()))).collect();
    for (entity, mut crowd) in &mut crowds {
        let its = crowd.bundle().id();
        for (_, why) in failed.iter().filter(|(id, _)| *id == its) {
            if crowd.fault != *why {
                crowd.fault.clone_from(why);
                fail(&mut messages, entity, why.clone());
            }
        }
        let is_new = changed.contains(&its);
        if (crowd.live.is_some() || crowd.is_refused) && !is_new {
            continue;
        }
        let Some(ThrongBundle(bundle)) = bundles.get(crowd.bundle()) else { continue };
        let done = match &mut crowd.live {
            Some(live) => live.group.adopt(bundle).map(|adopted| {
                live.bundle = bundle.clone();
                live.generation += 1;
                CrowdMessage::Adopted { crowd: entity, adopted }
            }),
            None => crowd.begin(bundle).map(|()| CrowdMessage::Opened { crowd: entity }),
        };
        crowd.is_refused = done.is_err();
        crowd.fault.clear();
        match done {
            Ok(message) => _ = messages.write(message),
            Err(why) => fail(&mut messages, entity, format!("the bundle is of no use here: {why}")),
        }
    }
}

/// Lets those enter who wait. Into an empty crowd all come at once, so that they may stand close.
pub fn enter(
    mut commands: Commands,
    mut crowds: Query<(Entity, &mut Crowd)>,
    waiting: Query<(Entity, &Character, &Transform), (Without<Entered>, Without<Refused>)>,
    mut messages: MessageWriter<CrowdMessage>,
) {
    if waiting.is_empty() {
        return;
    }
    // Those who come first come together.
    let mut gathering = Vec::new();
    for (entity, mut crowd) in &mut crowds {
        if let Some(live) = crowd.live.as_mut().filter(|live| live.group.ids().is_empty()) {
            live.group.hold_entrants();
            gathering.push(entity);
        }
    }
    for (entity, character, transform) in &waiting {
        let done = match crowds.get_mut(character.crowd).map(|(_, crowd)| crowd.into_inner().live.as_mut()) {
            Ok(None) => continue,
            Ok(Some(live)) => live
                .group
                .spawn(Spawn::standing_at(planar(transform)))
                .inspect(|id| live.entities[id.index()] = entity)
                .map_err(|e| e.to_string()),
            Err(_) => Err(format!("{} is no crowd; spawn a Crowd first", character.crowd)),
        };
        match done {
            Ok(id) => _ = commands.entity(entity).insert(Entered { crowd: character.crowd, id }),
            Err(why) => {
                commands.entity(entity).insert(Refused(why.clone()));
                fail(&mut messages, entity, why);
            }
        }
    }
    for entity in gathering {
        if let Ok((_, mut crowd)) = crowds.get_mut(entity)
            && let Some(live) = &mut crowd.live
        {
            live.group.release_entrants();
        }
    }
}

/// Where a transform stands and looks.
fn planar(transform: &Transform) -> Planar {
    let ahead = transform.rotation * Vec3::Z;
    Planar::new(transform.translation.x, transform.translation.z, ahead.x.atan2(ahead.z))
}

/// Gives orders that changed.
pub fn order(
    mut crowds: Query<&mut Crowd>,
    aims: Query<(Entity, &Entered, &Aim), Or<(Changed<Aim>, Added<Entered>)>>,
    mut messages: MessageWriter<CrowdMessage>,
) {
    for (entity, entered, aim) in &aims {
        let Ok(mut crowd) = crowds.get_mut(entered.crowd) else { continue };
        let Some(live) = &mut crowd.live else { continue };
        let at = glam::Vec3::from_array(aim.at.to_array());
        let ordered = live
            .bundle
            .find_policy(&aim.behaviour)
            .and_then(|policy| live.group.order(entered.id, PolicyOrder::towards(policy, at)));
        if let Err(why) = ordered {
            fail(&mut messages, entity, why.to_string());
        }
    }
}

/// Where crowds are looked at from.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Eye<'w, 's> {
    eyes: Query<'w, 's, &'static GlobalTransform, With<CrowdEye>>,
    cameras: Query<'w, 's, &'static GlobalTransform, With<Camera3d>>,
}

impl Eye<'_, '_> {
    /// X and z (m).
    pub fn at(&self) -> Option<Vec2> {
        self.eyes.iter().chain(&self.cameras).next().map(|eye| eye.translation().xz())
    }
}

/// Moves everybody, and writes where they are.
pub fn step(
    time: Res<Time>,
    eye: Eye,
    mut crowds: Query<(Entity, &mut Crowd)>,
    mut transforms: Query<&mut Transform, With<Entered>>,
    mut messages: MessageWriter<CrowdMessage>,
) {
    let dt_s = time.delta_secs().min(STEP_S.most as f32);
    let run = Pool(ComputeTaskPool::get_or_init(TaskPool::default));
    let eye = eye.at();
    for (entity, mut crowd) in &mut crowds {
        let near_m = crowd.near_m;
        let Some(live) = &mut crowd.live else { continue };
        let detail = eye.map(|at| Detail {
            eye: glam::Vec2::from_array(at.to_array()),
            full_m: near_m,
            posed_m: near_m + MARGIN_M,
        });
        if let Err(why) = live.group.set_detail(detail).and_then(|()| live.group.step(dt_s, &run)) {
            fail(&mut messages, entity, why.to_string());
            continue;
        }
        for (id, record) in live.group.ids().iter().zip(live.group.instances()) {
            if let Ok(mut transform) = transforms.get_mut(live.entities[id.index()]) {
                transform.translation = Vec3::new(record.x, record.y, record.z);
                transform.rotation = Quat::from_rotation_y(record.heading);
            }
        }
    }
}

/// Who is despawned, or no character any more, leaves its crowd.
pub fn leave(event: On<Remove, Entered>, entered: Query<&Entered>, mut crowds: Query<&mut Crowd>) {
    let Ok(entered) = entered.get(event.entity) else { return };
    if let Ok(mut crowd) = crowds.get_mut(entered.crowd)
        && let Some(live) = &mut crowd.live
    {
        // It is there: ids are given here alone, and taken here once.
        _ = live.group.despawn(entered.id);
    }
}

/// Despawns those who belong to a crowd that goes.
pub fn close(event: On<Remove, Crowd>, mut commands: Commands, characters: Query<(Entity, &Character)>) {
    for (entity, _) in characters.iter().filter(|(_, character)| character.crowd == event.entity) {
        commands.entity(entity).try_despawn();
    }
}
