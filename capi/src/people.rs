//! Orders to people of scenes, and changes of their brains.

use crate::fault::{CallResult, ThrongStatus, catch_fault, check_pointer, read_text};
use crate::scene::{ThrongId, check_size};
use crate::stage::ThrongSimulation;
use glam::{Vec2, Vec3};
use std::ffi::c_char;
use throng_base::error::{check_value, ensure};
use throng_base::{Error, Id};
use throng_runtime::simulation::Order;

/// Order to a person of a scene: an agent, or a captured person on the way to a goal.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongOrder {
    /// `sizeof(ThrongOrder)`; all else may be 0, which lets it stop.
    pub struct_size: usize,
    /// 0: stops. 1: goes to `at`. 2: follows `whom`. 3: walks on at the velocity `at`.
    pub task: u32,
    /// Number of the person that it follows.
    pub whom: u32,
    /// Place in the world, or velocity along x and z (m, m/s).
    pub at: [f32; 3],
    /// Distance that is kept to `whom` (m); 0 for 1.5 m.
    pub keep_m: f32,
    /// Desired speed from now on (m/s); 0 leaves it as it is. Captured people take the gait that is nearest to it.
    pub speed_mps: f32,
    /// 1: it faces `heading` at its goal, or turns to it where it stops.
    pub faces: u32,
    /// Heading about +Y from +Z (rad).
    pub heading: f32,
}

/// Number of a person of a scene.
fn person(id: ThrongId) -> CallResult<usize> {
    ensure(id.generation == 0, || Error::Gone(Id::from(id)))?;
    Ok(id.index as usize)
}

/// Gives a person of a scene an order, which holds until the next one, or until a rule of its brain lets it act.
///
/// # Safety
/// `order` points to as many bytes as its `struct_size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_people_order(
    simulation: ThrongSimulation,
    id: ThrongId,
    order: *const ThrongOrder,
) -> ThrongStatus {
    catch_fault(|| {
        check_pointer("order", order)?;
        // SAFETY: the first field, which every version has.
        check_size::<ThrongOrder>("order.struct_size", unsafe { (&raw const (*order).struct_size).read() })?;
        // SAFETY: it has this size.
        let o = unsafe { order.read() };
        let at = Vec3::from_array(o.at);
        let mut order = match o.task {
            1 => Order::go(at),
            2 => Order::follow(o.whom as usize),
            3 => Order::steer(Vec2::new(at.x, at.z)),
            _ => Order::stop(),
        };
        if o.keep_m != 0.0 {
            order = order.keeping(o.keep_m);
        }
        if o.speed_mps != 0.0 {
            order = order.at_speed(o.speed_mps);
        }
        if o.faces != 0 {
            order = order.arrive_facing(o.heading);
        }
        check_value("order.task", None, o.task, o.task <= 3, "0 to 3")?;
        simulation.with(|stage| Ok(stage.scene_mut()?.order(person(id)?, order)?))
    })
}

/// Raises an event of the scene for one agent alone, which learns of it.
///
/// # Safety
/// `event` ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_people_raise(
    simulation: ThrongSimulation,
    id: ThrongId,
    event: *const c_char,
) -> ThrongStatus {
    catch_fault(|| {
        // SAFETY: promised by the caller.
        let event = unsafe { read_text("event", event) }?;
        simulation.with(|stage| Ok(stage.scene_mut()?.raise_event_for(person(id)?, event)?))
    })
}

/// Sets a value of an agent's brain, within the limits of the scene.
///
/// # Safety
/// `name` ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_people_set_value(
    simulation: ThrongSimulation,
    id: ThrongId,
    name: *const c_char,
    value: f32,
) -> ThrongStatus {
    catch_fault(|| {
        // SAFETY: promised by the caller.
        let name = unsafe { read_text("name", name) }?;
        simulation.with(|stage| Ok(stage.scene_mut()?.set_value(person(id)?, name, value)?))
    })
}
