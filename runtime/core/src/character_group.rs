//! The interface of all kinds of motion.

use crate::skeleton::{Joint, NUM_JOINTS};
use crate::{body::Mat3x4, bundle::Bundle, planar::Planar};
use glam::{Mat4, Vec3};
use throng_base::{Error, Executor, Hash128, Id, Result, error::ensure, maths};

/// Characters of one kind of motion: characters, walkers, agents, inhabitants, sparring pairs.
///
/// Orders stay until they are changed. Each is named by its [`Id`].
///
/// ```
/// use throng_core::{CharacterGroup, Inline, Joint};
///
/// /// Moves any kind of people, and returns the highest head (m).
/// fn highest_head(people: &mut impl CharacterGroup) -> throng_core::Result<f32> {
///     people.step(1.0 / 60.0, &Inline)?;
///     let bodies = people.bodies();
///     let heads = bodies.ids.iter().filter_map(|id| Some(bodies.get(*id)?.position(Joint::Head).y));
///     Ok(heads.fold(0.0, f32::max))
/// }
/// ```
pub trait CharacterGroup {
    /// Start of a character: place and manner of its entry.
    type Start;
    /// Order for a character.
    type Order;
    /// Event of a character.
    type Event;

    /// Lets a character enter; allocates nothing within the capacity.
    ///
    /// # Errors
    /// [`Error::Full`], [`Error::Occupied`], or what is wrong with the start.
    fn spawn(&mut self, start: Self::Start) -> Result<Id>;

    /// Lets a character leave.
    ///
    /// # Errors
    /// [`Error::Gone`].
    fn despawn(&mut self, id: Id) -> Result<()>;

    /// Moves a character to another place at once; its feet are unlocked.
    ///
    /// # Errors
    /// [`Error::Gone`], [`Error::Occupied`], [`Error::Value`].
    fn place(&mut self, id: Id, root: Planar) -> Result<()>;

    /// Gives a character a new order.
    ///
    /// # Errors
    /// [`Error::Gone`], or why the order is impossible: [`Error::NoPath`], [`Error::Value`], [`Error::Index`].
    fn order(&mut self, id: Id, order: Self::Order) -> Result<()>;

    /// Moves time on (s). Results do not depend on `run`.
    ///
    /// # Errors
    /// [`Error::Value`] for a time out of range; nothing has changed then.
    fn step(&mut self, dt_s: f32, run: &dyn Executor) -> Result<()>;

    /// Progress of a character with its order.
    ///
    /// # Errors
    /// [`Error::Gone`].
    fn status(&self, id: Id) -> Result<OrderStatus>;

    /// Events of the last step.
    fn events(&self) -> &[(Id, Self::Event)];

    /// Places and poses of all.
    fn bodies(&self) -> PosedBodies<'_>;

    /// Appends all that the next steps depend on: versioned, with a checksum and a hash of bundle and setup.
    fn save(&self, out: &mut Vec<u8>);

    /// Restores a saved state.
    ///
    /// # Errors
    /// [`Error::Snapshot`]; nothing has changed then.
    fn load(&mut self, bytes: &[u8]) -> Result<()>;

    /// A hash of the state (64 bits): equal for equal motion of all.
    fn hash(&self) -> u64 {
        let mut bytes = Vec::new();
        self.save(&mut bytes);
        Hash128::hash_bytes(&bytes) as u64
    }

    /// Changes to another bundle: each takes the nearest pose in it, and eases over.
    ///
    /// # Errors
    /// [`Error::Unknown`] where the new bundle has no policy or space of a name in use; nothing has changed then.
    fn adopt(&mut self, new: &Bundle) -> Result<AdoptReport>;
}

/// Progress with an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OrderStatus {
    /// No order.
    Idle,
    /// Moving towards the goal.
    Going {
        /// Remaining distance, along a straight line where no route is known (m).
        left_m: f32,
    },
    /// At the goal, or performing the ordered action.
    Arrived,
    /// No progress.
    Blocked {
        /// Character in front that blocks it, if it is known.
        by: Option<Id>,
    },
    /// No path leads to the goal.
    NoPath,
}

/// Result of a change of the bundle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdoptReport {
    /// Number of characters that took a state of the new bundle.
    pub num_characters: usize,
    /// Largest distance of a joint between the old pose and the new one (m).
    pub farthest_m: f32,
}

/// Positions and poses of characters. Slices have one element each, in the same order.
#[derive(Clone, Copy, Debug)]
pub struct PosedBodies<'a> {
    /// Ids of the characters.
    pub ids: &'a [Id],
    /// Planar roots in the world.
    pub roots: &'a [Planar],
    /// Joint to the character's own frame (num_bodies * [`NUM_JOINTS`], row by row).
    pub model: &'a [[Mat3x4; NUM_JOINTS]],
}

/// Position and pose of one character.
#[derive(Clone, Copy, Debug)]
pub struct PosedBody<'a> {
    /// Planar root in the world.
    pub root: Planar,
    /// Joint to the body's own frame.
    pub model: &'a [Mat3x4; NUM_JOINTS],
}

impl<'a> PosedBodies<'a> {
    /// The row of one.
    pub fn row(&self, id: Id) -> Option<usize> {
        // Ids ascend until one leaves, so that most are found at once.
        match self.ids.get(id.index()) {
            Some(found) if *found == id => Some(id.index()),
            _ => self.ids.iter().position(|&other| other == id),
        }
    }

    /// The body of one.
    pub fn get(&self, id: Id) -> Option<PosedBody<'a>> {
        let row = self.row(id)?;
        Some(PosedBody { root: self.roots[row], model: &self.model[row] })
    }

    /// Writes the matrices from joint to world (num_bodies).
    ///
    /// # Errors
    /// [`Error::Length`] where `out` has another number of elements than there are bodies.
    pub fn write_world(&self, out: &mut [[Mat3x4; NUM_JOINTS]]) -> Result<()> {
        let expected = || format!("{}, one for each body", self.ids.len());
        ensure(out.len() == self.ids.len(), || Error::Length { what: "out", got: out.len(), expected: expected() })?;
        for ((to, root), model) in out.iter_mut().zip(self.roots).zip(self.model) {
            let place = Mat3x4::from_rotation_translation(root.rotation(), root.translation());
            to.iter_mut().zip(model).for_each(|(to, joint)| *to = place * *joint);
        }
        Ok(())
    }
}

impl PosedBody<'_> {
    /// Transform from a joint's frame to the world.
    pub fn world(&self, joint: Joint) -> Mat4 {
        Mat4::from_rotation_translation(self.root.rotation(), self.root.translation())
            * self.model[joint.index()].to_mat4()
    }

    /// Position of a joint in the world (m).
    pub fn position(&self, joint: Joint) -> Vec3 {
        maths::rotate(self.root.rotation(), self.model[joint.index()].translation()) + self.root.translation()
    }
}
