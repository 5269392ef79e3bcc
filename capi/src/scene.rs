//! Simulations: a scene file, or characters of one bundle who come, go and are told what to do.

use crate::fault::{Fault, ThrongStatus, call, check_pointer, text, write};
use crate::stage::{Stage, ThrongSimulation, keep, with};
use crate::tables::{BUNDLES, ThrongBundle};
use std::ffi::c_char;
use throng_base::Id;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, Choice, Order, PolicyCharacters, Spawn};
use throng_runtime::simulation::{Scene, Simulation};
use throng_runtime::{Cast, Planar, Status};

/// Names a character. Nobody else of its simulation ever has the same one. In scenes the index is its number, and the
/// generation 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThrongId {
    /// Its place (< capacity).
    pub index: u32,
    /// How many had this place before.
    pub generation: u32,
}

/// How characters of a bundle move.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongCharactersConfig {
    /// `sizeof(ThrongCharactersConfig)`, as `throng_characters_config_init` writes it.
    pub struct_size: usize,
    /// Seed of random choices.
    pub seed: u64,
    /// Most characters at a time.
    pub capacity: u32,
    /// 1: they make way for each other. 0: they take no notice of anybody.
    pub makes_way: u32,
    /// 0 takes the best action; above, one of the best few at random.
    pub temperature: f32,
    /// Time in which the offset of a transition halves (s).
    pub half_life_s: f32,
    /// 1: steps also leave a `ThrongInstance` of everybody.
    pub instances: u32,
    /// 0.
    pub reserved: u32,
}

const _: () = assert!(size_of::<ThrongCharactersConfig>() == 40);

impl ThrongCharactersConfig {
    fn standard() -> Self {
        let standard = CharactersConfig::default();
        Self {
            struct_size: size_of::<Self>(),
            seed: standard.seed,
            capacity: 1000,
            makes_way: 1,
            temperature: 0.0,
            half_life_s: standard.half_life_s,
            instances: 0,
            reserved: 0,
        }
    }
}

/// This version's size, so that a caller of another one is refused before anything of it is touched.
fn check_size(what: &str, size: usize) -> Result<(), Fault> {
    let expected = size_of::<ThrongCharactersConfig>();
    if size == expected {
        return Ok(());
    }
    let why = format!("`{what}` is {size}, expected {expected}; compile with the header of this library");
    Err(Fault::new(ThrongStatus::Value, why))
}

/// Fills in the defaults: seed 1, 1000 characters who make way.
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
    call(|| {
        check_size("size", size)?;
        // SAFETY: it has this size; promised by the caller.
        unsafe { write("config", config, ThrongCharactersConfig::standard()) }
    })
}

/// Room for characters that policies of a bundle move; nobody is there yet.
///
/// # Safety
/// `config` points to as many bytes as its `struct_size` says, `simulation` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_characters_new(
    bundle: ThrongBundle,
    config: *const ThrongCharactersConfig,
    simulation: *mut ThrongSimulation,
) -> ThrongStatus {
    call(|| {
        let bundle = BUNDLES.get("bundle", bundle.handle)?;
        check_pointer("config", config)?;
        check_pointer("simulation", simulation)?;
        // SAFETY: the first field, which every version has.
        check_size("config.struct_size", unsafe { (&raw const (*config).struct_size).read() })?;
        // SAFETY: it has this size.
        let c = unsafe { config.read() };
        let config = CharactersConfig {
            seed: c.seed,
            choice: Choice::LookAhead { temperature: c.temperature },
            half_life_s: c.half_life_s,
            avoid: (c.makes_way != 0).then(AvoidConfig::default),
            instances: c.instances != 0,
            ..CharactersConfig::default()
        };
        let characters = PolicyCharacters::with_capacity(&bundle, c.capacity as usize, config)?;
        // SAFETY: promised by the caller.
        unsafe { keep(Stage::characters(characters), simulation) }
    })
}

/// Opens a scene file with its bundles and worlds, and puts everybody in place.
///
/// # Safety
/// `path` ends with a zero, `simulation` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_open(
    path: *const c_char,
    simulation: *mut ThrongSimulation,
) -> ThrongStatus {
    call(|| {
        check_pointer("simulation", simulation)?;
        // SAFETY: promised by the caller.
        let path = unsafe { text("path", path) }?;
        let scene = Simulation::new(&Scene::load(path)?.open()?)?;
        // SAFETY: promised by the caller.
        unsafe { keep(Stage::Scene(Box::new(scene)), simulation) }
    })
}

/// Lets an event of the scene happen now.
///
/// # Safety
/// `event` ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_raise(simulation: ThrongSimulation, event: *const c_char) -> ThrongStatus {
    call(|| {
        // SAFETY: promised by the caller.
        let event = unsafe { text("event", event) }?;
        with(simulation.handle, |stage, _| stage.scene()?.raise(event).map_err(Fault::from))
    })
}

/// Lets a character enter; it stands at (x, z) and looks along the heading. Its pose is there after the next step.
///
/// @param heading about +Y from +Z (rad).
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
    call(|| {
        check_pointer("id", id)?;
        let root = Planar::new(x, z, heading);
        let new = with(simulation.handle, |stage, _| Ok(stage.cast()?.spawn(Spawn::standing(root))?))?;
        // SAFETY: promised by the caller.
        unsafe { write("id", id, new.into()) }
    })
}

/// Lets a character leave. The last one takes its row.
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_despawn(simulation: ThrongSimulation, id: ThrongId) -> ThrongStatus {
    call(|| with(simulation.handle, |stage, _| stage.cast()?.despawn(id.into()).map_err(Fault::from)))
}

/// Puts a character elsewhere at once.
#[unsafe(no_mangle)]
pub extern "C" fn throng_characters_place(
    simulation: ThrongSimulation,
    id: ThrongId,
    x: f32,
    z: f32,
    heading: f32,
) -> ThrongStatus {
    call(|| {
        with(simulation.handle, |stage, _| {
            stage.cast()?.place(id.into(), Planar::new(x, z, heading)).map_err(Fault::from)
        })
    })
}

/// Tells a character what to do from now on: a policy of the bundle, and the target in the world that it is about.
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
    let order = Order::aim(policy as usize, glam::Vec3::new(x, y, z));
    call(|| with(simulation.handle, |stage, _| stage.cast()?.order(id.into(), order).map_err(Fault::from)))
}

/// How far a character has come with its order.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThrongProgress {
    /// It has none.
    Idle = 0,
    /// On its way.
    Going = 1,
    /// It is where it was sent.
    There = 2,
    /// It makes no progress.
    Blocked = 3,
    /// No way leads there.
    NoWay = 4,
}

/// How far a character has come with its order.
///
/// @param left_m what is left of its way where it is going, else 0 (m).
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
    call(|| {
        let status = with(simulation.handle, |stage, _| Ok(stage.cast()?.status(id.into())?))?;
        let (now, left) = match status {
            Status::Idle => (ThrongProgress::Idle, 0.0),
            Status::Going { left_m } => (ThrongProgress::Going, left_m),
            Status::There => (ThrongProgress::There, 0.0),
            Status::Blocked { .. } => (ThrongProgress::Blocked, 0.0),
            Status::NoWay => (ThrongProgress::NoWay, 0.0),
        };
        check_pointer("left_m", left_m)?;
        // SAFETY: promised by the caller.
        unsafe { write("progress", progress, now) }?;
        // SAFETY: promised by the caller.
        unsafe { write("left_m", left_m, left) }
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
