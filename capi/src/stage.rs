//! Steps, states and snapshots of simulations.

use crate::fault::{CallFault, CallResult, ThrongStatus, catch_fault, copy_records, read_slice, write_result};
use crate::{handles::HandleTable, work_queue::WorkQueue};
use std::sync::{Arc, Mutex, TryLockError};
use throng_base::{Bytes, Executor, Inline, SnapshotKind, error::ensure};
use throng_runtime::{CharacterGroup, characters::PolicyCharacters, simulation::Simulation};

/// A simulation of characters. Only one thread at a time may call with it, except for `throng_simulation_help`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ThrongSimulation {
    /// Number of the handle; zero is none.
    pub handle: u64,
}

/// A simulation, and the work queue of its steps.
struct SimulationEntry {
    simulation: Mutex<LiveSimulation>,
    work_queue: WorkQueue,
}

static SIMULATIONS: HandleTable<Arc<SimulationEntry>> = HandleTable::new();

/// A simulation behind a handle: a scene, or characters of a bundle.
pub enum LiveSimulation {
    Scene(Box<Simulation>),
    Characters {
        group: Box<PolicyCharacters>,
        /// Simulated time (s).
        time_s: f64,
    },
}

impl LiveSimulation {
    pub fn characters(group: PolicyCharacters) -> Self {
        Self::Characters { group: Box::new(group), time_s: 0.0 }
    }

    pub fn scene_mut(&mut self) -> CallResult<&mut Simulation> {
        match self {
            Self::Scene(scene) => Ok(scene),
            Self::Characters { .. } => Err(unsupported(
                "these are characters of a bundle; only scenes have orders to people, events and values",
            )),
        }
    }

    pub fn characters_mut(&mut self) -> CallResult<&mut PolicyCharacters> {
        match self {
            Self::Characters { group, .. } => Ok(group),
            Self::Scene(_) => Err(unsupported("the scene file says who is there; use throng_characters_new")),
        }
    }

    fn step(&mut self, dt_s: f64, run: &dyn Executor) -> CallResult {
        match self {
            Self::Scene(scene) => scene.step_on(dt_s, run)?,
            Self::Characters { group, time_s } => {
                group.step(dt_s as f32, run)?;
                *time_s += dt_s;
            }
        }
        Ok(())
    }
}

fn unsupported(why: &str) -> CallFault {
    CallFault::new(ThrongStatus::Unsupported, why)
}

/// # Safety
/// `to` can be written.
pub unsafe fn register_simulation(stage: LiveSimulation, to: *mut ThrongSimulation) -> CallResult {
    let entry = SimulationEntry { simulation: Mutex::new(stage), work_queue: WorkQueue::default() };
    // SAFETY: promised by the caller.
    unsafe { write_result("simulation", to, ThrongSimulation { handle: SIMULATIONS.add(Arc::new(entry)) }) }
}

impl ThrongSimulation {
    fn entry(self) -> CallResult<Arc<SimulationEntry>> {
        SIMULATIONS.get("simulation", self.handle)
    }

    /// Calls `work` with the simulation, which no other thread may be using.
    pub fn with<R>(self, work: impl FnOnce(&mut LiveSimulation) -> CallResult<R>) -> CallResult<R> {
        self.entry()?.with_simulation(work)
    }

    /// Runs a call as [`ThrongSimulation::with`] does, and stores its fault for this thread.
    pub fn call(self, work: impl FnOnce(&mut LiveSimulation) -> CallResult) -> ThrongStatus {
        catch_fault(|| self.with(work))
    }
}

impl SimulationEntry {
    fn with_simulation<R>(&self, work: impl FnOnce(&mut LiveSimulation) -> CallResult<R>) -> CallResult<R> {
        let busy = "another thread is in a call with this simulation; wait for it";
        let broken = "a call with this simulation failed half way; free it and make it anew";
        let mut stage = self.simulation.try_lock().map_err(|e| match e {
            TryLockError::WouldBlock => CallFault::new(ThrongStatus::Busy, busy),
            TryLockError::Poisoned(_) => CallFault::new(ThrongStatus::Panic, broken),
        })?;
        work(&mut stage)
    }
}

/// Frees a simulation; a call of another thread ends first.
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_free(simulation: ThrongSimulation) -> ThrongStatus {
    catch_fault(|| {
        let entry = simulation.entry()?;
        SIMULATIONS.remove("simulation", simulation.handle)?;
        entry.work_queue.close_step();
        Ok(())
    })
}

/// Steps a simulation, on this thread and, if the step was announced, on helper threads.
///
/// @param dt_s duration of the step (s, 0 to 1).
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_step(simulation: ThrongSimulation, dt_s: f64) -> ThrongStatus {
    /// Guard that releases the helpers, however the step ends.
    struct Close<'a>(&'a WorkQueue);
    impl Drop for Close<'_> {
        fn drop(&mut self) {
            self.0.close_step();
        }
    }
    catch_fault(|| {
        let entry = simulation.entry()?;
        let queue = &entry.work_queue;
        let _close = Close(queue);
        entry.with_simulation(|stage| stage.step(dt_s, if queue.is_open() { queue } else { &Inline }))
    })
}

/// Announces the next step, so that threads that call `throng_simulation_help` wait for it and work in it. Call it before
/// they start. The result of the step does not depend on their number, nor on when they call.
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_announce(simulation: ThrongSimulation) -> ThrongStatus {
    catch_fault(|| {
        let entry = simulation.entry()?;
        entry.with_simulation(|_| {
            entry.work_queue.announce_step();
            Ok(())
        })
    })
}

/// Helps with an announced step until it is over; returns at once if none is announced. Any number of the application's
/// own threads may call it at a time.
#[unsafe(no_mangle)]
pub extern "C" fn throng_simulation_help(simulation: ThrongSimulation) -> ThrongStatus {
    catch_fault(|| {
        simulation.entry()?.work_queue.run_parts();
        Ok(())
    })
}

/// Writes the number of characters, including those of a scene that have left.
///
/// # Safety
/// `count` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_count(simulation: ThrongSimulation, count: *mut usize) -> ThrongStatus {
    // SAFETY: promised by the caller.
    simulation.call(|stage| unsafe { write_result("count", count, stage.num_characters()) })
}

/// Writes the simulated time (s).
///
/// # Safety
/// `time_s` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_time(simulation: ThrongSimulation, time_s: *mut f64) -> ThrongStatus {
    // SAFETY: promised by the caller.
    simulation.call(|stage| unsafe { write_result("time_s", time_s, stage.time_s()) })
}

/// Writes a hash of the state: the same for the same motion, on every machine and from every language.
///
/// # Safety
/// `hash` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_simulation_hash(simulation: ThrongSimulation, hash: *mut u64) -> ThrongStatus {
    // SAFETY: promised by the caller.
    simulation.call(|stage| unsafe { write_result("hash", hash, stage.hash()) })
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
    catch_fault(|| {
        let bytes = simulation.with(|stage| Ok(stage.save()))?;
        if capacity < bytes.len() {
            // SAFETY: promised by the caller.
            unsafe { write_result("size", size, bytes.len()) }?;
            let why = || format!("`buffer` has {capacity} bytes, expected {}", bytes.len());
            return ensure(capacity == 0 && buffer.is_null(), || CallFault::new(ThrongStatus::TooSmall, why()));
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
    catch_fault(|| {
        // SAFETY: promised by the caller.
        let bytes = unsafe { read_slice("bytes", bytes, size) }?;
        simulation.with(|stage| stage.restore(bytes))
    })
}

impl LiveSimulation {
    pub fn num_characters(&self) -> usize {
        match self {
            Self::Scene(scene) => scene.num_characters(),
            Self::Characters { group, .. } => group.ids().len(),
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
            Self::Characters { group, .. } => group.hash(),
        }
    }

    fn save(&self) -> Vec<u8> {
        match self {
            Self::Scene(scene) => scene.snapshot(),
            Self::Characters { group, time_s } => {
                let (mut saved, mut out) = (Bytes::default(), Vec::new());
                group.save(&mut saved.0);
                CHARACTERS.write(&(time_s, saved), &mut out);
                out
            }
        }
    }

    fn restore(&mut self, bytes: &[u8]) -> CallResult {
        match self {
            Self::Scene(scene) => scene.restore(bytes)?,
            Self::Characters { group, time_s } => {
                let fault = |why: &str| CallFault::new(ThrongStatus::Format, why);
                let (time, saved): (f64, Bytes) = CHARACTERS.read_all(bytes)?;
                let why = || format!("the snapshot's time is {time} s, expected 0 to 1e12");
                ensure((0.0..=1e12).contains(&time), || fault(&why()))?;
                group.load(&saved.0)?;
                *time_s = time;
            }
        }
        Ok(())
    }
}

/// Time, and the snapshot of the group.
const CHARACTERS: SnapshotKind = SnapshotKind { what: "simulated characters", tag: *b"SIMC", version: 1, setup: 0 };

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;
    use throng_runtime::Bundle;
    use throng_runtime::characters::CharactersConfig;

    fn one_character() -> PolicyCharacters {
        let golden = concat!(env!("CARGO_MANIFEST_DIR"), "/../data/golden/tables_v");
        let bundle = format!("{golden}{}.throng", throng_runtime::format::VERSION);
        let bundle = Bundle::open(bundle).expect("the golden bundle");
        PolicyCharacters::with_capacity(&bundle, 1, CharactersConfig::default()).expect("one character")
    }

    #[test]
    fn each_damaged_byte_of_a_snapshot_is_noticed() {
        let mut stage = LiveSimulation::characters(one_character());
        stage.step(0.5, &Inline).ok().expect("a step");
        let saved = stage.save();
        for at in 0..saved.len().min(200) {
            let mut bad = saved.clone();
            bad[at] ^= 1;
            assert!(stage.restore(&bad).is_err(), "byte {at} of {}", saved.len());
        }
        assert!(stage.restore(&saved).is_ok() && stage.time_s() == 0.5);
    }

    #[test]
    fn helpers_go_where_a_step_is_refused_and_where_the_simulation_is_freed() {
        let mut sim = ThrongSimulation { handle: 0 };
        // SAFETY: `sim` can be written.
        unsafe { register_simulation(LiveSimulation::characters(one_character()), &raw mut sim) }
            .ok()
            .expect("a handle");
        let helper = || {
            throng_simulation_announce(sim);
            let (tell, status) = mpsc::channel();
            std::thread::spawn(move || tell.send(throng_simulation_help(sim)));
            std::thread::sleep(Duration::from_millis(50));
            status
        };
        let has_gone = |status: mpsc::Receiver<ThrongStatus>| status.recv_timeout(Duration::from_secs(20)).is_ok();
        let status = helper();
        let busy = sim.with(|_| Ok(throng_simulation_step(sim, 0.1)));
        assert!(busy.ok() == Some(ThrongStatus::Busy) && has_gone(status));
        let status = helper();
        assert!(throng_simulation_free(sim) == ThrongStatus::Ok && has_gone(status));
    }
}
