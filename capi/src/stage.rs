//! Steps, states and snapshots of simulations.

use crate::desk::Desk;
use crate::fault::{Fault, ThrongStatus, call, copy_records, slice, write};
use crate::handles::Handles;
use std::sync::{Arc, Mutex, TryLockError};
use throng_base::{Inline, Run};
use throng_runtime::Cast;
use throng_runtime::characters::PolicyCharacters;
use throng_runtime::simulation::Simulation;

/// A simulation of characters. Only one thread at a time may call with it, except for `throng_simulation_help`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongSimulation {
    /// Number of the handle; zero is none.
    pub handle: u64,
}

/// A simulation, and the work queue of its steps.
struct Entry {
    stage: Mutex<Stage>,
    desk: Desk,
}

static SIMULATIONS: Handles<Arc<Entry>> = Handles::new();

/// A simulation behind a handle: a scene, or characters of a bundle.
pub enum Stage {
    Scene(Box<Simulation>),
    Characters {
        cast: Box<PolicyCharacters>,
        /// Simulated time (s).
        time_s: f64,
    },
}

impl Stage {
    pub fn characters(cast: PolicyCharacters) -> Self {
        Self::Characters { cast: Box::new(cast), time_s: 0.0 }
    }

    pub fn scene(&mut self) -> Result<&mut Simulation, Fault> {
        match self {
            Self::Scene(scene) => Ok(scene),
            Self::Characters { .. } => Err(unsupported("these are characters of a bundle; only scenes have events")),
        }
    }

    pub fn cast(&mut self) -> Result<&mut PolicyCharacters, Fault> {
        match self {
            Self::Characters { cast, .. } => Ok(cast),
            Self::Scene(_) => Err(unsupported("the scene file says who is there; use throng_characters_new")),
        }
    }

    fn step(&mut self, dt_s: f64, run: &dyn Run) -> Result<(), Fault> {
        match self {
            Self::Scene(scene) => scene.step_on(dt_s, run)?,
            Self::Characters { cast, time_s } => {
                cast.step(dt_s as f32, run)?;
                *time_s += dt_s;
            }
        }
        Ok(())
    }
}

fn unsupported(why: &str) -> Fault {
    Fault::new(ThrongStatus::Unsupported, why)
}

/// # Safety
/// `to` can be written.
pub unsafe fn keep(stage: Stage, to: *mut ThrongSimulation) -> Result<(), Fault> {
    let entry = Entry { stage: Mutex::new(stage), desk: Desk::default() };
    // SAFETY: promised by the caller.
    unsafe { write("simulation", to, ThrongSimulation { handle: SIMULATIONS.add(Arc::new(entry)) }) }
}

/// Calls `work` with a simulation that no other thread is using.
pub fn with<R>(number: u64, work: impl FnOnce(&mut Stage, &Desk) -> Result<R, Fault>) -> Result<R, Fault> {
    SIMULATIONS.get("simulation", number)?.with(work)
}

impl Entry {
    fn with<R>(&self, work: impl FnOnce(&mut Stage, &Desk) -> Result<R, Fault>) -> Result<R, Fault> {
        let mut stage = self.stage.try_lock().map_err(|e| match e {
            TryLockError::WouldBlock => {
                Fault::new(ThrongStatus::Busy, "another thread is in a call with this simulation; wait for it")
            }
            TryLockError::Poisoned(_) => {
                Fault::new(ThrongStatus::Panic, "a call with this simulation failed half way; free it and make it anew")
            }
        })?;
        work(&mut stage, &self.desk)
    }
}

/// Frees a simulation; a call of another thread ends first.
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_free(simulation: ThrongSimulation) -> ThrongStatus {
    call(|| {
        let entry = SIMULATIONS.get("simulation", simulation.handle)?;
        SIMULATIONS.remove("simulation", simulation.handle)?;
        entry.desk.close();
        Ok(())
    })
}

/// Steps a simulation, on this thread and, if the step was announced, on helper threads.
///
/// @param dt_s duration of the step (s, 0 to 1).
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_step(simulation: ThrongSimulation, dt_s: f64) -> ThrongStatus {
    /// Guard that releases the helpers, however the step ends.
    struct Close<'a>(&'a Desk);
    impl Drop for Close<'_> {
        fn drop(&mut self) {
            self.0.close();
        }
    }
    call(|| {
        let entry = SIMULATIONS.get("simulation", simulation.handle)?;
        let _close = Close(&entry.desk);
        entry.with(|stage, desk| {
            let run: &dyn Run = if desk.is_open() { desk } else { &Inline };
            stage.step(dt_s, run)
        })
    })
}

/// Announces the next step, so that threads that call `throng_simulation_help` wait for it and work in it. Call it before
/// they start. The result of the step does not depend on their number, nor on when they call.
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_announce(simulation: ThrongSimulation) -> ThrongStatus {
    call(|| {
        with(simulation.handle, |_, desk| {
            desk.announce();
            Ok(())
        })
    })
}

/// Helps with an announced step until it is over; returns at once if none is announced. Any number of the application's
/// own threads may call it at a time.
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_help(simulation: ThrongSimulation) -> ThrongStatus {
    call(|| {
        SIMULATIONS.get("simulation", simulation.handle)?.desk.help();
        Ok(())
    })
}

/// Writes the number of characters, including those of a scene that have left.
///
/// # Safety
/// `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_count(simulation: ThrongSimulation, count: *mut usize) -> ThrongStatus {
    call(|| {
        let found = with(simulation.handle, |stage, _| Ok(stage.num_characters()))?;
        // SAFETY: promised by the caller.
        unsafe { write("count", count, found) }
    })
}

/// Writes the simulated time (s).
///
/// # Safety
/// `time_s` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_time(simulation: ThrongSimulation, time_s: *mut f64) -> ThrongStatus {
    call(|| {
        let found = with(simulation.handle, |stage, _| Ok(stage.time_s()))?;
        // SAFETY: promised by the caller.
        unsafe { write("time_s", time_s, found) }
    })
}

/// Writes a hash of the state: the same for the same motion, on every machine and from every language.
///
/// # Safety
/// `hash` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_hash(simulation: ThrongSimulation, hash: *mut u64) -> ThrongStatus {
    call(|| {
        let found = with(simulation.handle, |stage, _| Ok(stage.hash()))?;
        // SAFETY: promised by the caller.
        unsafe { write("hash", hash, found) }
    })
}

/// Copies the whole state that the next steps depend on, with a checksum.
///
/// @param buffer room for `capacity` bytes; if it is null and `capacity` is 0, only `size` is written.
/// @param size length of the state (bytes). With less room nothing is copied, and `THRONG_STATUS_TOO_SMALL` is returned.
///
/// # Safety
/// `buffer` has this room, `size` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_save(
    simulation: ThrongSimulation,
    buffer: *mut u8,
    capacity: usize,
    size: *mut usize,
) -> ThrongStatus {
    call(|| {
        let bytes = with(simulation.handle, |stage, _| Ok(stage.save()))?;
        if capacity < bytes.len() {
            // SAFETY: promised by the caller.
            unsafe { write("size", size, bytes.len()) }?;
            if capacity == 0 && buffer.is_null() {
                return Ok(());
            }
            let why = format!("`buffer` has {capacity} bytes, expected {}", bytes.len());
            return Err(Fault::new(ThrongStatus::TooSmall, why));
        }
        // SAFETY: promised by the caller.
        unsafe { copy_records(bytes.into_iter(), buffer, capacity, size) }
    })
}

/// Restores a state that was saved with the same bundle or scene; a refused state changes nothing.
///
/// # Safety
/// `bytes` points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_restore(
    simulation: ThrongSimulation,
    bytes: *const u8,
    size: usize,
) -> ThrongStatus {
    call(|| {
        // SAFETY: promised by the caller.
        let bytes = unsafe { slice("bytes", bytes, size) }?;
        with(simulation.handle, |stage, _| stage.restore(bytes))
    })
}

impl Stage {
    pub fn num_characters(&self) -> usize {
        match self {
            Self::Scene(scene) => scene.num_characters(),
            Self::Characters { cast, .. } => cast.ids().len(),
        }
    }

    pub fn time_s(&self) -> f64 {
        match self {
            Self::Scene(scene) => scene.time_s(),
            Self::Characters { time_s, .. } => *time_s,
        }
    }

    fn hash(&self) -> u64 {
        match self {
            Self::Scene(scene) => scene.hash(),
            Self::Characters { cast, .. } => cast.hash(),
        }
    }

    fn save(&self) -> Vec<u8> {
        match self {
            Self::Scene(scene) => scene.snapshot(),
            Self::Characters { cast, time_s } => {
                let mut out = time_s.to_le_bytes().to_vec();
                cast.save(&mut out);
                out
            }
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        match self {
            Self::Scene(scene) => scene.restore(bytes)?,
            Self::Characters { cast, time_s } => {
                let short =
                    || Fault::new(ThrongStatus::Format, "this is no snapshot of these characters: it is cut short");
                let (time, rest) = bytes.split_first_chunk().ok_or_else(short)?;
                let time = f64::from_le_bytes(*time);
                if !(0.0..=1e12).contains(&time) {
                    return Err(Fault::new(
                        ThrongStatus::Format,
                        format!("the snapshot's time is {time} s, expected 0 to 1e12"),
                    ));
                }
                cast.load(rest)?;
                *time_s = time;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;
    use throng_runtime::Bundle;
    use throng_runtime::characters::CharactersConfig;

    #[test]
    fn helpers_go_where_a_step_is_refused_and_where_the_simulation_is_freed() {
        let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/golden/tables_v");
        let bundle =
            Bundle::open(format!("{golden}{}.throng", throng_runtime::format::VERSION)).expect("the golden bundle");
        let cast = PolicyCharacters::with_capacity(&bundle, 1, CharactersConfig::default()).expect("one character");
        let mut sim = ThrongSimulation { handle: 0 };
        // SAFETY: `sim` can be written.
        unsafe { keep(Stage::characters(cast), &raw mut sim) }.ok().expect("a handle");
        let helper = || {
            throng_simulation_announce(sim);
            let (tell, told) = mpsc::channel();
            std::thread::spawn(move || tell.send(throng_simulation_help(sim)));
            std::thread::sleep(Duration::from_millis(50));
            told
        };
        let has_gone = |told: mpsc::Receiver<ThrongStatus>| told.recv_timeout(Duration::from_secs(20)).is_ok();
        let told = helper();
        let busy = with(sim.handle, |_, _| Ok(throng_simulation_step(sim, 0.1)));
        assert!(busy.ok() == Some(ThrongStatus::Busy) && has_gone(told));
        let told = helper();
        assert!(throng_simulation_free(sim) == ThrongStatus::Ok && has_gone(told));
    }
}
