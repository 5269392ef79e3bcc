//! Simulations of scenes.

use crate::bundle::PyBundle;
use crate::error;
use crate::work;
use numpy::{
    PyArray1, PyArray2, PyArray4, PyArrayMethods, PyReadwriteArray2, PyReadwriteArray4, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use throng_runtime::simulation::{CharacterEvent, Order, Scene, Simulation};
use throng_runtime::{Executor, Inline, Mat3x4, NUM_JOINTS, Rayon};

/// A simulation of a scene, see `throng.Simulation`.
#[pyclass(subclass, name = "Simulation", module = "throng._throng")]
pub struct PySimulation {
    sim: Simulation,
    /// Requested arrays of the current step.
    roots: Option<Py<PyArray2<f32>>>,
    poses: Option<Py<PyArray4<f32>>>,
}

/// Threads for a step.
fn threads(parallel: bool) -> &'static dyn Executor {
    if parallel { &Rayon } else { &Inline }
}

#[pymethods]
impl PySimulation {
    /// - `text`: text of a scene in place of the file's content; `cache`: folder of stage outputs for builds of missing bundles;
    ///   `untrusted`: only files beside the scene or below are read, and nothing is built.
    #[new]
    #[pyo3(signature = (scene, bundle=None, *, text=None, cache=None, untrusted=false))]
    fn new(
        py: Python<'_>,
        scene: PathBuf,
        bundle: Option<&Bound<'_, PyBundle>>,
        text: Option<&str>,
        cache: Option<PathBuf>,
        untrusted: bool,
    ) -> PyResult<Self> {
        let bundle = bundle.map(|b| b.get().0.clone());
        let sim = work::run_interruptibly(py, |signals| {
            let scene = match text {
                Some(text) if untrusted => Scene::parse_untrusted(text, &scene)?,
                Some(text) => Scene::parse(text, &scene)?,
                None if untrusted => Scene::load_untrusted(&scene)?,
                None => Scene::load(&scene)?,
            };
            let compiled = match &bundle {
                Some(bundle) => scene.compile(bundle)?,
                None => work::open_scene(&scene, cache, signals)?,
            };
            Ok(Simulation::new(&compiled)?)
        })?;
        Ok(Self { sim, roots: None, poses: None })
    }

    /// Steps the simulation by a duration (s, at most 1), on all cores if `parallel`. Results do not depend on it.
    #[pyo3(signature = (dt_s=1.0 / 60.0, *, parallel=false))]
    fn step(&mut self, py: Python<'_>, dt_s: f64, parallel: bool) -> PyResult<()> {
        self.forget_arrays();
        py.detach(|| self.sim.step_on(dt_s, threads(parallel))).map_err(error::runtime_error)
    }

    /// Steps the simulation to a time (s), in steps of allowed duration.
    #[pyo3(signature = (until_s, *, parallel=false))]
    fn step_to(&mut self, py: Python<'_>, until_s: f64, parallel: bool) -> PyResult<()> {
        self.forget_arrays();
        py.detach(|| self.sim.step_to(until_s, threads(parallel))).map_err(error::runtime_error)
    }

    /// Positions and headings of all characters: x, z, heading (n x 3; m, radians), read-only; NaN for those that have left.
    #[getter]
    fn roots<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        if let Some(roots) = &self.roots {
            return Ok(roots.bind(py).clone());
        }
        let mut rows = vec![0.0; self.sim.num_characters() * 3];
        self.write_roots(&mut rows);
        let array = PyArray1::from_vec(py, rows).reshape([self.sim.num_characters(), 3])?;
        array.call_method1("setflags", (false,))?;
        self.roots = Some(array.clone().unbind());
        Ok(array)
    }

    /// Matrices from joints to the character's own frame, row by row (n x 22 x 3 x 4; m), read-only; NaN without a body.
    #[getter]
    fn poses<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray4<f32>>> {
        if let Some(poses) = &self.poses {
            return Ok(poses.bind(py).clone());
        }
        let mut rows = vec![0.0; self.sim.num_characters() * POSE_LEN];
        self.write_poses(&mut rows);
        let array = PyArray1::from_vec(py, rows).reshape([self.sim.num_characters(), NUM_JOINTS, 3, 4])?;
        array.call_method1("setflags", (false,))?;
        self.poses = Some(array.clone().unbind());
        Ok(array)
    }

    /// Writes the roots into an array (n x 3).
    fn _roots_into(&self, mut out: PyReadwriteArray2<'_, f32>) -> PyResult<()> {
        let expected = [self.sim.num_characters(), 3];
        let (shape, in_order) = (out.shape().to_vec(), out.is_c_contiguous());
        self.write_roots(checked_output(&shape, &expected, out.as_slice_mut().ok().filter(|_| in_order))?);
        Ok(())
    }

    /// Writes the poses into an array (n x 22 x 3 x 4).
    fn _poses_into(&self, mut out: PyReadwriteArray4<'_, f32>) -> PyResult<()> {
        let expected = [self.sim.num_characters(), NUM_JOINTS, 3, 4];
        let (shape, in_order) = (out.shape().to_vec(), out.is_c_contiguous());
        self.write_poses(checked_output(&shape, &expected, out.as_slice_mut().ok().filter(|_| in_order))?);
        Ok(())
    }

    /// Simulated time (s).
    #[getter]
    fn time_s(&self) -> f64 {
        self.sim.time_s()
    }

    /// Duration of the scene (s).
    #[getter]
    fn seconds(&self) -> f64 {
        self.sim.scene().seconds
    }

    /// Number of characters, including those that have left.
    #[getter]
    fn num_characters(&self) -> usize {
        self.sim.num_characters()
    }

    /// True if the scene has ended by its own rules.
    #[getter]
    fn has_ended(&self) -> bool {
        self.sim.has_ended()
    }

    /// Groups of the scene: name, motion, number of the first character, number of characters.
    #[getter]
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let group = |g: &throng_simulation::SceneGroup| {
            let out = PyDict::new(py);
            out.set_item("name", &g.name)?;
            out.set_item("motion", format!("{:?}", g.motion).to_lowercase())?;
            out.set_item("first", g.characters.start)?;
            out.set_item("count", g.characters.len())?;
            Ok(out)
        };
        self.sim.groups().iter().map(group).collect()
    }

    /// Events of the last step: time_s, who, what, and further keys of the kind of event.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let event = |e: &throng_runtime::simulation::SimulationEvent| {
            let out = PyDict::new(py);
            out.set_item("time_s", e.time_s)?;
            out.set_item("who", e.who)?;
            let what = match e.kind {
                CharacterEvent::Hit { at } => {
                    out.set_item("at", at.to_array())?;
                    "hit"
                }
                CharacterEvent::Struck { opponent, at, .. } => {
                    out.set_item("opponent", opponent)?;
                    out.set_item("at", at.to_array())?;
                    "struck"
                }
                CharacterEvent::Fulfilled => "fulfilled",
                CharacterEvent::Arrived => "arrived",
                CharacterEvent::Left => "left",
                CharacterEvent::Stuck => "stuck",
                CharacterEvent::RunInto { obstacle } => {
                    out.set_item("obstacle", obstacle)?;
                    "run_into"
                }
            };
            out.set_item("what", what)?;
            Ok(out)
        };
        self.sim.events().iter().map(event).collect()
    }

    /// Raises an event of the scene, for one agent alone if `who` is given.
    #[pyo3(name = "raise_event", signature = (event, who=None))]
    fn raise(&mut self, event: &str, who: Option<usize>) -> PyResult<()> {
        let raised = match who {
            Some(who) => self.sim.raise_event_for(who, event),
            None => self.sim.raise_event(event),
        };
        raised.map_err(error::runtime_error)
    }

    /// Sets a value of an agent's brain, within the limits of the scene.
    fn set_value(&mut self, who: usize, name: &str, value: f32) -> PyResult<()> {
        self.sim.set_value(who, name, value).map_err(error::runtime_error)
    }

    /// What an agent does and why, its states and values, in words.
    fn explain(&self, who: usize) -> PyResult<String> {
        self.sim.explain(who).map(|why| why.to_string()).map_err(error::runtime_error)
    }

    /// Sends a person to a place (x, y, z; m), at a speed from then on (m/s); there it faces a heading (radians).
    #[pyo3(signature = (who, place, *, speed=None, facing=None))]
    fn go(&mut self, who: usize, place: [f32; 3], speed: Option<f32>, facing: Option<f32>) -> PyResult<()> {
        let order = speed.map_or(Order::go(place.into()), |speed| Order::go(place.into()).at_speed(speed));
        self.order(who, facing.map_or(order, |heading| order.arrive_facing(heading)))
    }

    /// Lets a person follow another one, and stand near it where it stands (m).
    #[pyo3(signature = (who, whom, *, keeping=1.5))]
    fn follow(&mut self, who: usize, whom: usize, keeping: f32) -> PyResult<()> {
        self.order(who, Order::follow(whom).keeping(keeping))
    }

    /// Lets a person walk on at a velocity (x, z; m/s), as a player steers.
    fn steer(&mut self, who: usize, velocity: [f32; 2]) -> PyResult<()> {
        self.order(who, Order::steer(velocity.into()))
    }

    /// Lets a person stop, and turn to a heading if one is given (radians).
    #[pyo3(signature = (who, *, facing=None))]
    fn stop(&mut self, who: usize, facing: Option<f32>) -> PyResult<()> {
        self.order(who, facing.map_or(Order::stop(), Order::turn_to))
    }

    /// The whole state, as bytes: after it is restored anywhere, later steps are the same bit by bit.
    fn snapshot<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.sim.snapshot())
    }

    /// Restores a snapshot of the same scene.
    fn restore(&mut self, snapshot: &[u8]) -> PyResult<()> {
        self.sim.restore(snapshot).map_err(error::runtime_error)?;
        self.forget_arrays();
        Ok(())
    }

    /// A hash of the state: equal for equal motion of all characters.
    fn hash(&self) -> u64 {
        self.sim.hash()
    }

    fn __repr__(&self) -> String {
        format!("Simulation({} characters, {:.3} s)", self.sim.num_characters(), self.sim.time_s())
    }
}

/// Number of floats of a pose.
const POSE_LEN: usize = NUM_JOINTS * 12;

impl PySimulation {
    fn order(&mut self, who: usize, order: Order) -> PyResult<()> {
        self.sim.order(who, order).map_err(error::runtime_error)
    }

    /// Drops the arrays of the previous step; Python code that still holds them keeps them.
    fn forget_arrays(&mut self) {
        (self.roots, self.poses) = (None, None);
    }

    fn write_roots(&self, out: &mut [f32]) {
        for (to, root) in out.as_chunks_mut::<3>().0.iter_mut().zip(self.sim.roots()) {
            *to = root.map_or([f32::NAN; 3], |r| [r.x, r.z, r.heading]);
        }
    }

    fn write_poses(&self, out: &mut [f32]) {
        for (to, pose) in out.as_chunks_mut::<POSE_LEN>().0.iter_mut().zip(self.sim.poses()) {
            match pose {
                Some(pose) => write_pose(pose, to),
                None => to.fill(f32::NAN),
            }
        }
    }
}

/// Writes a pose, joint by joint and row by row.
pub fn write_pose(pose: &[Mat3x4; NUM_JOINTS], out: &mut [f32; POSE_LEN]) {
    for (to, joint) in out.as_chunks_mut::<12>().0.iter_mut().zip(pose) {
        to.copy_from_slice(joint.rows.as_flattened());
    }
}

/// The numbers of an output array, if it has the expected shape.
fn checked_output<'a>(shape: &[usize], expected: &[usize], out: Option<&'a mut [f32]>) -> PyResult<&'a mut [f32]> {
    let fault = || format!("`out` has shape {shape:?}, expected {expected:?}, float32 in C order");
    out.filter(|_| shape == expected).ok_or_else(|| error::input_error(fault()))
}
