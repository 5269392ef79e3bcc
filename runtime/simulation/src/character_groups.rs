//! List of all kinds of motion: a new kind gets a line at the end.

use crate::boxing::{Bouts, Practice};
use crate::inhabitant_group::InhabitantGroup;
use crate::motion_kind::{GroupStep, MotionKind};
use crate::{Order, SimulationEvent, agents::SceneAgents, travellers::Travellers, wander::Wanderers};
use glam::{Vec2, Vec3};
use throng_base::{Result, ground::ReservedRegion};
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Defines the enum of all kinds of motion, without dynamic dispatch.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident($kind:ty)),* $(,)?) => {
        /// Characters of a simulation that are moved together, by their kind of motion.
        #[derive(Clone, Debug)]
        pub enum AnyCharacterGroup { $($(#[$doc])* $name($kind)),* }

        impl MotionKind for AnyCharacterGroup {
            fn num_characters(&self) -> usize {
                match self { $(Self::$name(k) => k.num_characters()),* }
            }
            fn step(&mut self, tick: &GroupStep<'_>, events: &mut Vec<SimulationEvent>) -> Result<()> {
                match self { $(Self::$name(k) => k.step(tick, events)),* }
            }
            fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
                match self { $(Self::$name(k) => k.add_reserved_regions(out)),* }
            }
            fn set_external_obstacles<'a>(&mut self, others: impl Iterator<Item = &'a ReservedRegion>) {
                match self { $(Self::$name(k) => k.set_external_obstacles(others)),* }
            }
            fn restart_on_free_ground(&mut self) {
                match self { $(Self::$name(k) => k.restart_on_free_ground()),* }
            }
            fn save(&self, out: &mut Vec<u8>) {
                match self { $(Self::$name(k) => k.save(out)),* }
            }
            fn load(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
                match self { $(Self::$name(k) => k.load(bytes, time_s)),* }
            }
            fn hash(&self) -> u64 {
                match self { $(Self::$name(k) => k.hash()),* }
            }
            fn order(&mut self, number: usize, goal: Option<(Vec3, f32)>, order: &Order) -> Result<()> {
                match self { $(Self::$name(k) => k.order(number, goal, order)),* }
            }
            fn turn_to(&mut self, number: usize, heading: f32) -> Result<()> {
                match self { $(Self::$name(k) => k.turn_to(number, heading)),* }
            }
            fn root(&self, number: usize) -> Option<Planar> {
                match self { $(Self::$name(k) => k.root(number)),* }
            }
            fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
                match self { $(Self::$name(k) => k.pose(number)),* }
            }
            fn contacts(&self, number: usize) -> Contacts {
                match self { $(Self::$name(k) => k.contacts(number)),* }
            }
            fn soles(&self, number: usize) -> Option<[[Vec3; 2]; 2]> {
                match self { $(Self::$name(k) => k.soles(number)),* }
            }
        }
    };
}

kinds! {
    /// Characters with policies, each with a target of its own.
    Policy(Practice),
    /// Characters with policies on the way to goals.
    Travel(Travellers),
    /// Pairs with policies that strike at each other.
    Sparring(Bouts),
    /// Blended bodies on random paths.
    Paths(Wanderers),
    /// Characters in a stitched world.
    Patches(InhabitantGroup),
    /// Agents on the ground, with and without bodies.
    Ground(SceneAgents<Vec2>),
    /// Agents in the air.
    Air(SceneAgents<Vec3>),
}
