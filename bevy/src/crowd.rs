//! Crowds, the characters in them, and what is reported of them.

use crate::appearance::CrowdAppearance;
use crate::bundle::ThrongBundle;
use bevy::prelude::*;
use std::borrow::Cow;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, PolicyCharacters};
use throng_runtime::{AdoptReport, Bundle, Id};

/// Room for characters of one bundle. Those who belong to it are despawned with it.
#[derive(Component, Debug)]
#[require(CrowdAppearance)]
pub struct Crowd {
    bundle: Handle<ThrongBundle>,
    capacity: usize,
    config: CharactersConfig,
    /// Up to this distance from the eye, characters have joints and feet that stay in place (m, >= 0).
    pub near_m: f32,
    pub(crate) live: Option<Live>,
    /// Was found impossible; tried again when the bundle changes.
    pub(crate) is_refused: bool,
    /// Why its file was last refused: Bevy reports it twice.
    pub(crate) fault: String,
}

/// What there is once the bundle is loaded.
#[derive(Debug)]
pub(crate) struct Live {
    pub group: PolicyCharacters,
    pub bundle: Bundle,
    /// How often the bundle was changed.
    pub generation: u32,
    /// Who has each place (capacity).
    pub entities: Vec<Entity>,
}

impl Crowd {
    /// Room for so many characters, who make way for each other.
    pub fn new(bundle: Handle<ThrongBundle>, capacity: usize) -> Self {
        let config = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
        Self { bundle, capacity, config, near_m: 20.0, live: None, is_refused: false, fault: String::new() }
    }

    /// Moves by other settings than the default ones; for a crowd that is not spawned yet.
    pub fn with_config(self, config: CharactersConfig) -> Self {
        Self { config, ..self }
    }

    /// Has another [`Crowd::near_m`] (m, >= 0).
    pub fn with_near_m(self, near_m: f32) -> Self {
        Self { near_m, ..self }
    }

    /// The asset that moves it.
    pub fn bundle(&self) -> &Handle<ThrongBundle> {
        &self.bundle
    }

    /// Most characters.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// What moves the characters, to be asked for status, events, poses, hash and snapshots; none before the bundle is
    /// loaded.
    pub fn character_group(&self) -> Option<&PolicyCharacters> {
        self.live.as_ref().map(|live| &live.group)
    }

    /// The same, to give orders, push, place, or load a snapshot of the same characters. Entities come and go by
    /// [`Character`] alone.
    pub fn character_group_mut(&mut self) -> Option<&mut PolicyCharacters> {
        self.live.as_mut().map(|live| &mut live.group)
    }

    /// The entity of a character.
    pub fn entity(&self, id: Id) -> Option<Entity> {
        let live = self.live.as_ref()?;
        live.group.row(id).ok()?;
        live.entities.get(id.index()).copied()
    }

    /// Begins with a bundle.
    pub(crate) fn begin(&mut self, bundle: &Bundle) -> throng_runtime::Result<()> {
        let config = CharactersConfig { instances: true, ..self.config };
        let group = PolicyCharacters::with_capacity(bundle, self.capacity, config)?;
        let entities = vec![Entity::PLACEHOLDER; self.capacity];
        self.live = Some(Live { group, bundle: bundle.clone(), generation: 0, entities });
        Ok(())
    }
}

/// Belongs to a [`Crowd`]. It enters where its `Transform` says, on the ground; from then on the plugin writes the
/// `Transform`. It leaves when it is despawned.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Transform, Visibility)]
pub struct Character {
    /// The entity of the [`Crowd`].
    pub crowd: Entity,
}

/// Where a [`Character`] goes, until this is changed.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Aim {
    /// A behaviour of the bundle, such as `approach`.
    pub behaviour: Cow<'static, str>,
    /// What it is about, in the world (m).
    pub at: Vec3,
}

impl Aim {
    /// Walks to a place (m).
    pub fn approach(at: Vec3) -> Self {
        Self { behaviour: "approach".into(), at }
    }
}

/// A [`Character`] that is in its crowd.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entered {
    /// The entity of the [`Crowd`].
    pub crowd: Entity,
    /// Names it in [`Crowd::character_group`].
    pub id: Id,
}

/// A [`Character`] that could not enter. It tries again where this is removed.
#[derive(Component, Clone, Debug, PartialEq, Eq)]
pub struct Refused(pub String);

/// Where crowds are looked at from; without one, from the first `Camera3d`.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform)]
pub struct CrowdEye;

/// What happened to a crowd or a character. What failed is logged, too.
#[derive(Message, Clone, Debug, PartialEq)]
pub enum CrowdMessage {
    /// Its bundle is loaded; characters enter.
    Opened {
        /// The entity of the [`Crowd`].
        crowd: Entity,
    },
    /// A bundle that was built anew is in use; everybody went on.
    Adopted {
        /// The entity of the [`Crowd`].
        crowd: Entity,
        /// How far poses were apart.
        adopted: AdoptReport,
    },
    /// A bundle, an order or a look is of no use; what there was goes on.
    Failed {
        /// The entity of the [`Crowd`] or [`Character`].
        entity: Entity,
        /// What is wrong, and the way out.
        why: String,
    },
}
