//! List of all kinds of motion: a new kind gets a line at the end.

use crate::Event;
use crate::agents::Agents;
use crate::boxing::{Bouts, Practice};
use crate::inhabited::Inhabited;
use crate::kind::{Kind, Tick};
use crate::wander::Wanderers;
use glam::{Vec2, Vec3};
use throng_base::Result;
use throng_base::ground::Held;
use throng_core::{Contacts, Mat3x4, NUM_JOINTS, Planar};

/// Defines the enum of all kinds of motion, without dynamic dispatch.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident($kind:ty)),* $(,)?) => {
        /// Characters of a simulation that are moved together, by their kind of motion.
        #[derive(Clone, Debug)]
        pub enum GroupCast { $($(#[$doc])* $name($kind)),* }

        impl Kind for GroupCast {
            fn num_characters(&self) -> usize {
                match self { $(Self::$name(k) => k.num_characters()),* }
            }
            fn step(&mut self, tick: &Tick<'_>, events: &mut Vec<Event>) -> Result<()> {
                match self { $(Self::$name(k) => k.step(tick, events)),* }
            }
            fn hold(&mut self, out: &mut Held) {
                match self { $(Self::$name(k) => k.hold(out)),* }
            }
            fn mind<'a>(&mut self, others: impl Iterator<Item = &'a Held>) {
                match self { $(Self::$name(k) => k.mind(others)),* }
            }
            fn settle(&mut self) {
                match self { $(Self::$name(k) => k.settle()),* }
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
    /// Pairs with policies that strike at each other.
    Sparring(Bouts),
    /// Blended bodies on random paths.
    Paths(Wanderers),
    /// Characters in a stitched world.
    Patches(Inhabited),
    /// Agents on the ground, with and without bodies.
    Ground(Agents<Vec2>),
    /// Agents in the air.
    Air(Agents<Vec3>),
}
