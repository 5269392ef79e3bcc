//! Simulations: a scene file, or characters of one bundle that enter, leave and take orders.

use crate::fault::{CallFault, CallResult, ThrongStatus, catch_fault, check_pointer, read_text, write_result};
use crate::stage::{LiveSimulation, ThrongSimulation, register_simulation};
use crate::tables::{BUNDLES, ThrongBundle};
use std::ffi::c_char;
use throng_base::{Id, error::ensure};
use throng_runtime::body::{ArmLayer, BodyLayers};
use throng_runtime::characters::{ActionChoice, AvoidConfig, CharactersConfig, PolicyCharacters, PolicyOrder, Spawn};
use throng_runtime::simulation::{Scene, Simulation};
use throng_runtime::{CharacterGroup, OrderStatus, Planar};

/// Identifies a character; unique in its simulation for all time. In scenes the index is its number, and the generation
/// is 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThrongId {
    /// Place of the character (< capacity).
    pub index: u32,
    /// Number of previous characters at this place.
    pub generation: u32,
}

/// Settings of characters of a bundle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongCharactersConfig {
    /// `sizeof(ThrongCharactersConfig)`, as `throng_characters_config_init` writes it.
    pub struct_size: usize,
    /// Seed of random choices.
    pub seed: u64,
    /// Greatest number of characters at a time.
    pub capacity: u32,
    /// 1: characters avoid each other. 0: they ignore each other.
    pub avoids: u32,
    /// Randomness of choices: 0 takes the best action; above 0, one of the best few at random.
    pub temperature: f32,
    /// Time in which the offset of a transition halves (s).
    pub half_life_s: f32,
    /// 1: steps also write a `ThrongInstance` of every character.
    pub instances: u32,
    /// Reserved; 0.
    pub reserved: u32,
}

const _: () = assert!(size_of::<ThrongCharactersConfig>() == 40);

/// Checks the size of the config, so that a caller of another version is refused before its memory is touched.
pub fn check_size<T>(what: &str, size: usize) -> CallResult {
    let expected = size_of::<T>();
    let why = || format!("`{what}` is {size}, expected {expected}; compile with the header of this library");
    ensure(size == expected, || CallFault::new(ThrongStatus::Value, why()))
}

/// Fills in the defaults: seed 1, 1000 characters that avoid each other.
///
/// @param size `sizeof(ThrongCharactersConfig)`.
///
/// # Safety
/// `config` has room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_config_init(
    config: *mut ThrongCharactersConfig,
    size: usize,
) -> ThrongStatus {
    catch_fault(|| {
        check_size::<ThrongCharactersConfig>("size", size)?;
        let CharactersConfig { seed, half_life_s, .. } = CharactersConfig::default();
        let standard = ThrongCharactersConfig {
            struct_size: size,
            seed,
            capacity: 1000,
            avoids: 1,
            temperature: 0.0,
            half_life_s,
            instances: 0,
            reserved: 0,
        };
        // SAFETY: it has this size; promised by the caller.
        unsafe { write_result("config", config, standard) }
    })
}

/// Makes an empty simulation of characters that are moved by policies of a bundle.
///
/// # Safety
/// `config` points to as many bytes as its `struct_size` says, `simulation` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_new(
    bundle: ThrongBundle,
    config: *const ThrongCharactersConfig,
    simulation: *mut ThrongSimulation,
) -> ThrongStatus {
    catch_fault(|| {
        let bundle = BUNDLES.get("bundle", bundle.handle)?;
        check_pointer("config", config)?;
        check_pointer("simulation", simulation)?;
        // SAFETY: the first field, which every version has.
        check_size::<ThrongCharactersConfig>("config.struct_size", unsafe {
            (&raw const (*config).struct_size).read()
        })?;
        // SAFETY: it has this size.
        let c = unsafe { config.read() };
        let config = CharactersConfig {
            seed: c.seed,
            choice: ActionChoice::LookAhead { temperature: c.temperature },
            half_life_s: c.half_life_s,
            avoid: (c.avoids != 0).then(AvoidConfig::default),
            instances: c.instances != 0,
            ..CharactersConfig::default()
        };
        let characters = PolicyCharacters::with_capacity(&bundle, c.capacity as usize, config)?;
        // SAFETY: promised by the caller.
        unsafe { register_simulation(LiveSimulation::characters(characters), simulation) }
    })
}

/// Opens a scene file with its bundles and worlds, and places all characters.
///
/// # Safety
/// `path` ends with a zero, `simulation` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_open(
    path: *const c_char,
    simulation: *mut ThrongSimulation,
) -> ThrongStatus {
    catch_fault(|| {
        check_pointer("simulation", simulation)?;
        // SAFETY: promised by the caller.
        let path = unsafe { read_text("path", path) }?;
        let scene = Simulation::new(&Scene::load(path)?.open()?)?;
        // SAFETY: promised by the caller.
        unsafe { register_simulation(LiveSimulation::Scene(Box::new(scene)), simulation) }
    })
}

/// Raises an event of the scene.
///
/// # Safety
/// `event` ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_raise(simulation: ThrongSimulation, event: *const c_char) -> ThrongStatus {
    catch_fault(|| {
        // SAFETY: promised by the caller.
        let event = unsafe { read_text("event", event) }?;
        simulation.with(|stage| Ok(stage.scene_mut()?.raise_event(event)?))
    })
}

/// Adds a character that stands at (x, z) and faces along the heading. Its pose is available after the next step.
///
/// @param heading heading about +Y from +Z (rad).
///
/// # Safety
/// `id` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_spawn(
    simulation: ThrongSimulation,
    x: f32,
    z: f32,
    heading: f32,
    id: *mut ThrongId,
) -> ThrongStatus {
    catch_fault(|| {
        check_pointer("id", id)?;
        let start = Spawn::standing_at(Planar::new(x, z, heading));
        let new = simulation.with(|stage| Ok(stage.characters_mut()?.spawn(start)?))?;
        // SAFETY: promised by the caller.
        unsafe { write_result("id", id, new.into()) }
    })
}

/// Removes a character. The character of the last row takes its row.
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_despawn(simulation: ThrongSimulation, id: ThrongId) -> ThrongStatus {
    simulation.call(|stage| Ok(stage.characters_mut()?.despawn(id.into())?))
}

/// Moves a character to another place at once.
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_place(
    simulation: ThrongSimulation,
    id: ThrongId,
    x: f32,
    z: f32,
    heading: f32,
) -> ThrongStatus {
    simulation.call(|stage| Ok(stage.characters_mut()?.place(id.into(), Planar::new(x, z, heading))?))
}

/// Orders a character to follow a policy of the bundle from now on, with a target in the world (m); its layers stay.
///
/// @param policy see `throng_bundle_policy`.
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_order(
    simulation: ThrongSimulation,
    id: ThrongId,
    policy: u32,
    x: f32,
    y: f32,
    z: f32,
) -> ThrongStatus {
    let order = PolicyOrder::towards(policy as usize, glam::Vec3::new(x, y, z));
    simulation.call(|stage| Ok(stage.characters_mut()?.order_motion(id.into(), order)?))
}

/// What a body does beside its motion.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongLayers {
    /// `sizeof(ThrongLayers)`; all else may be 0.
    pub struct_size: usize,
    /// 1: head and neck turn to `look_at`.
    pub looks: u32,
    /// A point in the world (m).
    pub look_at: [f32; 3],
    /// What the left and the right arm do. 0: as their motion. 1: points. 2: waves. 3: carries beside the body, 4: before it, 5: on the
    /// shoulder. 6: holds a telephone at the ear. 7: reaches; trunk and hips give way.
    pub arms: [u32; 2],
    /// Where they point or reach, in the world (m).
    pub arms_at: [[f32; 3]; 2],
    /// Bend of the trunk forwards and to the left (radians, -0.6 to 0.6).
    pub lean: [f32; 2],
    /// First frame row of the bundle that joints show.
    pub first_frame: u32,
    /// Number of frames; 0 for none.
    pub num_frames: u32,
    /// A bit for each joint that shows them; those of hips and legs have no effect.
    pub joints: u32,
    /// 1: after the last frame the first follows.
    pub loops: u32,
}

/// Sets what the body of a character does beside its motion, from now on. Changes fade in and out.
///
/// # Safety
/// `layers` points to as many bytes as its `struct_size` says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_set_layers(
    simulation: ThrongSimulation,
    id: ThrongId,
    layers: *const ThrongLayers,
) -> ThrongStatus {
    catch_fault(|| {
        check_pointer("layers", layers)?;
        // SAFETY: the first field, which every version has.
        check_size::<ThrongLayers>("layers.struct_size", unsafe { (&raw const (*layers).struct_size).read() })?;
        // SAFETY: it has this size.
        let l = unsafe { layers.read() };
        let why = || format!("`layers.arms` are {:?}, expected 0 to 7", l.arms);
        ensure(l.arms.iter().all(|arm| *arm <= 7), || CallFault::new(ThrongStatus::Value, why()))?;
        let arm = |side: usize| ArmLayer::from_number(l.arms[side] as usize, l.arms_at[side].into());
        let look_at = (l.looks != 0).then_some(l.look_at.into());
        let mut body = BodyLayers { look_at, arms: [arm(0), arm(1)], lean: l.lean, ..BodyLayers::default() };
        if l.num_frames > 0 {
            let frames = l.first_frame..l.first_frame.saturating_add(l.num_frames);
            body = body.with_clip(frames, l.joints, l.loops != 0);
        }
        simulation.with(|stage| Ok(stage.characters_mut()?.set_layers(id.into(), body)?))
    })
}

/// Orders a character to stop as soon as its motion allows, and to stand at ease; its layers stay.
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_stop(simulation: ThrongSimulation, id: ThrongId) -> ThrongStatus {
    simulation.call(|stage| Ok(stage.characters_mut()?.order_motion(id.into(), PolicyOrder::STOP)?))
}

/// Orders a character to stop, and to turn on the spot; its layers stay.
///
/// @param heading heading about +Y from +Z (rad).
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_turn_to(simulation: ThrongSimulation, id: ThrongId, heading: f32) -> ThrongStatus {
    simulation.call(|stage| Ok(stage.characters_mut()?.order_motion(id.into(), PolicyOrder::turn_to(heading))?))
}

/// Orders a character a manner of motion, which stays until another one is ordered; its other order goes on. The error message
/// lists the manners there are.
///
/// @param manner such as "sad"; "normal" is that which nothing sets apart.
///
/// # Safety
/// `manner` ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_set_manner(
    simulation: ThrongSimulation,
    id: ThrongId,
    manner: *const c_char,
) -> ThrongStatus {
    catch_fault(|| {
        // SAFETY: promised by the caller.
        let manner = unsafe { read_text("manner", manner) }?;
        simulation.with(|stage| Ok(stage.characters_mut()?.set_manner(id.into(), manner)?))
    })
}

/// Orders a character a speed on its way, which stays; it takes the gait whose usual speed is nearest to that.
///
/// @param speed_mps 0 for that which its policy prefers (m/s).
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_set_speed(
    simulation: ThrongSimulation,
    id: ThrongId,
    speed_mps: f32,
) -> ThrongStatus {
    simulation.call(|stage| Ok(stage.characters_mut()?.set_speed(id.into(), speed_mps)?))
}

/// Progress of a character's order.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThrongProgress {
    /// No order.
    Idle = 0,
    /// On its way.
    Going = 1,
    /// Arrived at its target.
    There = 2,
    /// Blocked: no progress.
    Blocked = 3,
    /// No path leads to its target.
    NoPath = 4,
}

/// Progress of a character's order.
///
/// @param left_m remaining length of its path while it is on its way, else 0 (m).
///
/// # Safety
/// `progress` and `left_m` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_progress(
    simulation: ThrongSimulation,
    id: ThrongId,
    progress: *mut ThrongProgress,
    left_m: *mut f32,
) -> ThrongStatus {
    catch_fault(|| {
        let status = simulation.with(|stage| Ok(stage.characters_mut()?.status(id.into())?))?;
        let (now, left) = match status {
            OrderStatus::Idle => (ThrongProgress::Idle, 0.0),
            OrderStatus::Going { left_m } => (ThrongProgress::Going, left_m),
            OrderStatus::Arrived => (ThrongProgress::There, 0.0),
            OrderStatus::Blocked { .. } => (ThrongProgress::Blocked, 0.0),
            OrderStatus::NoPath => (ThrongProgress::NoPath, 0.0),
        };
        check_pointer("left_m", left_m)?;
        // SAFETY: promised by the caller.
        unsafe { write_result("progress", progress, now) }?;
        // SAFETY: promised by the caller.
        unsafe { write_result("left_m", left_m, left) }
    })
}

impl From<Id> for ThrongId {
    fn from(id: Id) -> Self {
        Self { index: id.index, generation: id.generation }
    }
}

impl From<ThrongId> for Id {
    fn from(id: ThrongId) -> Self {
        Self { index: id.index, generation: id.generation }
    }
}
