//! Throng in Bevy: bundles are assets, characters are entities.
//!
//! A [`Crowd`] has room for characters of one bundle. An entity with a [`Character`] and a `Transform` enters it as soon
//! as the bundle is there; an [`Aim`] says where it goes. Every update moves all of them, writes their `Transform`s, and
//! gives those near the eye an entity for every joint. Where Bevy draws, they have skinned bodies, and the others are
//! drawn from records of 32 bytes.

mod appearance;
mod bundle;
mod crowd;
mod draw;
mod joints;
mod step;
mod threads;

pub use appearance::CrowdAppearance;
pub use bundle::{BundleError, BundleLoader, ThrongBundle};
pub use crowd::{Aim, Character, Crowd, CrowdEye, CrowdMessage, Entered, Refused};
pub use draw::{FarMaterial, FromRecords};
pub use joints::{CharacterJoint, Joints};
pub use throng_runtime as runtime;

use bevy::pbr::PbrPlugin;
use bevy::prelude::*;

/// Loads bundles, lets characters enter, and moves them in [`Update`]. Add it after Bevy's own plugins: where these draw,
/// it draws.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThrongPlugin;

/// What the plugin does in [`Update`], one after the other.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ThrongSystems {
    /// Bundles are opened or adopted; characters enter and get their orders.
    Enter,
    /// Everybody moves; `Transform`s are written.
    Step,
    /// Joints and drawings follow.
    Show,
}

impl Plugin for ThrongPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<ThrongBundle>().register_asset_loader(BundleLoader).add_message::<CrowdMessage>();
        app.configure_sets(Update, (ThrongSystems::Enter, ThrongSystems::Step, ThrongSystems::Show).chain());
        app.add_systems(
            Update,
            (
                (step::open, step::enter, step::order).chain().in_set(ThrongSystems::Enter),
                step::step.in_set(ThrongSystems::Step),
                joints::follow.in_set(ThrongSystems::Show),
            ),
        );
        app.add_observer(step::leave).add_observer(step::close);
        if app.is_plugin_added::<PbrPlugin>() {
            draw::build(app);
        }
    }
}
