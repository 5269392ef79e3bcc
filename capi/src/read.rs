//! Roots, poses and events of characters.

use crate::fault::{CallFault, ThrongStatus, catch_fault, check_pointer, copy_records};
use crate::layout::{checked_layout, matrix_floats, root_matrix, write_matrix};
use crate::scene::ThrongId;
use crate::stage::{LiveSimulation, ThrongSimulation};
use throng_base::{Id, error::ensure};
use throng_runtime::body::{BodyEvent, BodyEventKind};
use throng_runtime::simulation::{CharacterEvent, SimulationEvent};
use throng_runtime::{CharacterGroup, Mat3x4, NUM_JOINTS, Planar};

/// Position and heading of a character.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrongRoot {
    /// The character.
    pub id: ThrongId,
    /// 0 if it has left, else 1.
    pub is_there: u32,
    /// Position along X, to the left of heading 0 (m).
    pub x: f32,
    /// Position along Z (m).
    pub z: f32,
    /// Heading about +Y from +Z (rad).
    pub heading: f32,
}

/// Kind of an event of a character.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThrongHappened {
    /// Its blow has landed, or, for characters of a bundle, has reached its point.
    Hit = 0,
    /// Its blow met `other`, its opponent.
    Struck = 1,
    /// Its goal is fulfilled.
    Fulfilled = 2,
    /// Arrival at its goal.
    Arrived = 3,
    /// Departure at its goal.
    Left = 4,
    /// Stuck: no progress towards its goal.
    Stuck = 5,
    /// The moving obstacle `other` ran into it.
    RunInto = 6,
    /// The foot that is joint `other` has come down.
    Footstep = 7,
    /// A part of the body, joint `other`, began to touch the ground or a thing.
    ContactBegan = 8,
    /// A part, joint `other`, has ended to touch.
    ContactEnded = 9,
    /// The motion has come into a named range of a clip: `other` is 256 times the clip, plus the tag.
    Tag = 10,
}

/// Event of the last step.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThrongEvent {
    /// Time of the event (s).
    pub time_s: f64,
    /// The character that it happened to, or that caused it.
    pub id: ThrongId,
    /// Kind of the event.
    pub happened: ThrongHappened,
    /// Number of the other character, obstacle, joint, tag or hit, for the kinds that have one; else 0.
    pub other: u32,
    /// Point of a blow or a footstep; zeros for other events (m).
    pub at: [f32; 3],
    /// Strength of a blow or a footstep (0 to 1); 0 for other events.
    pub strength: f32,
}

/// Copies position and heading of all characters, in the order of rows.
///
/// @param roots room for `capacity` records.
/// @param count number of records; those beyond `capacity` are left out.
///
/// # Safety
/// `roots` has this room, `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_roots(
    simulation: ThrongSimulation,
    roots: *mut ThrongRoot,
    capacity: usize,
    count: *mut usize,
) -> ThrongStatus {
    simulation.call(|stage| {
        let all = (0..stage.num_characters()).map(|row| {
            let (id, root) = stage.root(row);
            let Planar { x, z, heading } = root.unwrap_or_default();
            ThrongRoot { id: id.into(), is_there: u32::from(root.is_some()), x, z, heading }
        });
        // SAFETY: promised by the caller.
        unsafe { copy_records(all, roots, capacity, count) }
    })
}

/// Copies the events of the last step.
///
/// @param events room for `capacity` records.
/// @param count number of records; those beyond `capacity` are left out.
///
/// # Safety
/// `events` has this room, `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_events(
    simulation: ThrongSimulation,
    events: *mut ThrongEvent,
    capacity: usize,
    count: *mut usize,
) -> ThrongStatus {
    simulation.call(|stage| match stage {
        // SAFETY: promised by the caller.
        LiveSimulation::Scene(scene) => unsafe {
            copy_records(scene.events().iter().map(scene_event), events, capacity, count)
        },
        LiveSimulation::Characters { group, time_s } => {
            let all = group.events().iter().map(|(id, event)| body_event(*time_s, *id, event));
            // SAFETY: promised by the caller.
            unsafe { copy_records(all, events, capacity, count) }
        }
    })
}

fn body_event(time_s: f64, id: Id, event: &BodyEvent) -> ThrongEvent {
    let happened = match event.kind {
        BodyEventKind::Footstep => ThrongHappened::Footstep,
        BodyEventKind::ContactBegan => ThrongHappened::ContactBegan,
        BodyEventKind::ContactEnded => ThrongHappened::ContactEnded,
        BodyEventKind::Tag => ThrongHappened::Tag,
        BodyEventKind::Blow => ThrongHappened::Hit,
        BodyEventKind::Performed => ThrongHappened::Fulfilled,
    };
    let BodyEvent { number, at, strength, .. } = *event;
    ThrongEvent { time_s, id: id.into(), happened, other: number, at: at.to_array(), strength }
}

fn scene_event(event: &SimulationEvent) -> ThrongEvent {
    let (happened, other, at) = match event.kind {
        CharacterEvent::Hit { at } => (ThrongHappened::Hit, 0, at.to_array()),
        CharacterEvent::Struck { opponent, at, .. } => (ThrongHappened::Struck, opponent, at.to_array()),
        CharacterEvent::Fulfilled => (ThrongHappened::Fulfilled, 0, [0.0; 3]),
        CharacterEvent::Arrived => (ThrongHappened::Arrived, 0, [0.0; 3]),
        CharacterEvent::Left => (ThrongHappened::Left, 0, [0.0; 3]),
        CharacterEvent::Stuck => (ThrongHappened::Stuck, 0, [0.0; 3]),
        CharacterEvent::RunInto { obstacle } => (ThrongHappened::RunInto, obstacle, [0.0; 3]),
    };
    let id = Id::first(event.who).into();
    ThrongEvent { time_s: event.time_s, id, happened, other: other as u32, at, strength: 0.0 }
}

/// Writes the matrix from each joint to the world, for all characters, in one pass and in the axes of an engine. Matrices
/// of a character that has left or has no body are zero.
///
/// @param matrices room for characters times `THRONG_NUM_JOINTS` matrices, those of a character side by side.
/// @param size its length (bytes).
/// @param stride distance from one character's first matrix to the next one's (bytes, a multiple of 4).
/// @param layout a `ThrongLayout`.
///
/// # Safety
/// `matrices` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_write_matrices(
    simulation: ThrongSimulation,
    matrices: *mut f32,
    size: usize,
    stride: usize,
    layout: u32,
) -> ThrongStatus {
    catch_fault(|| {
        let layout = checked_layout(layout)?;
        simulation.with(|stage| {
            let (n, length) = (stage.num_characters(), NUM_JOINTS * matrix_floats(layout));
            if n == 0 {
                return Ok(());
            }
            check_pointer("matrices", matrices)?;
            let why = || format!("`stride` is {stride} bytes, expected a multiple of 4, {} or more", 4 * length);
            let holds_one = stride.is_multiple_of(4) && stride >= 4 * length;
            ensure(holds_one, || CallFault::new(ThrongStatus::Value, why()))?;
            let needed = stride.checked_mul(n - 1).and_then(|all| all.checked_add(4 * length));
            let expected = || needed.map_or("more than there can be".into(), |n| n.to_string());
            let why = || format!("`matrices` has {size} bytes, expected {} for {n} characters", expected());
            let holds_all = needed.is_some_and(|needed| needed <= size);
            ensure(holds_all, || CallFault::new(ThrongStatus::TooSmall, why()))?;
            for row in 0..n {
                // SAFETY: ends within `size`, for which the caller promises room; every bit pattern is a float.
                let to = unsafe { std::slice::from_raw_parts_mut(matrices.add(row * (stride / 4)), length) };
                match (stage.root(row).1, stage.pose(row)) {
                    (Some(root), Some(pose)) => {
                        let place = root_matrix(root);
                        for (to, joint) in to.chunks_exact_mut(matrix_floats(layout)).zip(pose) {
                            write_matrix(layout, &(place * *joint), to);
                        }
                    }
                    _ => to.fill(0.0),
                }
            }
            Ok(())
        })
    })
}

impl LiveSimulation {
    /// Id and root of the character in a row (row < number of characters).
    fn root(&self, row: usize) -> (Id, Option<Planar>) {
        match self {
            Self::Scene(scene) => (Id::first(row), scene.root(row)),
            Self::Characters { group, .. } => (group.ids()[row], Some(group.bodies().roots[row])),
        }
    }

    /// Joints in model space, if the character has a body (row < number of characters).
    fn pose(&self, row: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        match self {
            Self::Scene(scene) => scene.pose(row),
            Self::Characters { group, .. } => Some(&group.bodies().model[row]),
        }
    }
}
