//! Characters that policies move.

use crate::bundle::{PyBundle, points};
use crate::error;
use crate::simulation::write_pose;
use numpy::{PyArray1, PyArray2, PyArray4, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use throng_runtime::body::BodyLayers;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, Detail, PolicyCharacters, PolicyOrder, Spawn};
use throng_runtime::glam::{Vec2, Vec3};
use throng_runtime::{CharacterGroup, Id, Inline, NUM_JOINTS, Planar};

/// Characters that follow one behaviour of a bundle to targets of their own.
///
/// - `roots`: start positions: x, z, heading (n x 3; m, radians).
/// - `behaviour`: name of the behaviour; the first one by default.
/// - `avoids`: characters avoid each other, and start apart.
/// - `instances`: steps also write records for a GPU, see `instances`.
#[pyclass(name = "Characters", module = "throng", subclass)]
pub struct PyCharacters {
    characters: PolicyCharacters,
    /// Number of the behaviour that they follow.
    policy: usize,
    /// Ids of the characters, in the order of rows, as no character leaves.
    ids: Vec<Id>,
}

#[pymethods]
impl PyCharacters {
    #[new]
    #[pyo3(signature = (bundle, roots, behaviour=None, *, seed=1, avoids=false, instances=false))]
    fn new(
        bundle: &Bound<'_, PyBundle>,
        roots: PyReadonlyArray2<'_, f32>,
        behaviour: Option<&str>,
        seed: u64,
        avoids: bool,
        instances: bool,
    ) -> PyResult<Self> {
        let bundle = &bundle.get().0;
        let first = bundle.meta().behaviours.first().ok_or_else(error::no_policy)?;
        let policy = bundle.policy(behaviour.unwrap_or(first)).map_err(error::runtime_error)?;
        let roots = points(&roots)?;
        let avoid = avoids.then(AvoidConfig::default);
        let config = CharactersConfig { seed, avoid, instances, carriage: 1.0, ..CharactersConfig::default() };
        let mut group = PolicyCharacters::with_capacity(bundle, roots.len(), config).map_err(error::runtime_error)?;
        // Accepts any order of starts, though they stand close.
        group.hold_entrants();
        let enter = |r: &Vec3| {
            let id = group.spawn(Spawn::standing_at(Planar::new(r.x, r.y, r.z)))?;
            group.order(id, policy.order_towards(Vec3::new(r.x, 0.0, r.y)))?;
            Ok(id)
        };
        let ids = roots.iter().map(enter).collect::<Result<_, _>>().map_err(error::runtime_error)?;
        group.release_entrants();
        Ok(Self { characters: group, policy: policy.number(), ids })
    }

    /// Sends every character to a target of its own, from now on (n x 3: x, y, z; m).
    fn aim(&mut self, targets: PyReadonlyArray2<'_, f32>) -> PyResult<()> {
        let targets = points(&targets)?;
        if targets.len() != self.ids.len() || !targets.iter().all(|t| t.is_finite()) {
            // Refused, all of them.
            return self.characters.aim_all(&targets, &targets).map_err(error::runtime_error);
        }
        // Who was told to stop goes, too; layers stay.
        for (id, target) in self.ids.iter().zip(targets) {
            let order = PolicyOrder::towards(self.policy, target);
            self.characters.order_motion(*id, order).map_err(error::runtime_error)?;
        }
        Ok(())
    }

    /// Tells a character to stop as soon as its motion allows, and to stand at ease until it gets another target.
    fn stop(&mut self, who: usize) -> PyResult<()> {
        let id = self.id(who)?;
        self.characters.order_motion(id, PolicyOrder::STOP).map_err(error::runtime_error)
    }

    /// Tells a character to stop, and to turn on the spot (radians).
    fn turn_to(&mut self, who: usize, heading: f32) -> PyResult<()> {
        let id = self.id(who)?;
        self.characters.order_motion(id, PolicyOrder::turn_to(heading)).map_err(error::runtime_error)
    }

    /// Orders a character a manner of motion, such as "sad", which stays until another one is ordered; "normal" is that which nothing
    /// sets apart. Before the first step it stands in it at once.
    fn set_manner(&mut self, who: usize, manner: &str) -> PyResult<()> {
        let id = self.id(who)?;
        self.characters.set_manner(id, manner).map_err(error::runtime_error)
    }

    /// Orders a character a speed on its way (m/s), which stays; it takes the gait whose usual speed is nearest to that.
    fn set_speed(&mut self, who: usize, speed: f32) -> PyResult<()> {
        let id = self.id(who)?;
        self.characters.set_speed(id, speed).map_err(error::runtime_error)
    }

    /// Sets the layers of a character, a JSON object.
    fn _set_layers(&mut self, who: usize, layers: &str) -> PyResult<()> {
        let layers: BodyLayers = serde_json::from_str(layers).map_err(|e| error::input_error(e.to_string()))?;
        let id = self.id(who)?;
        self.characters.set_layers(id, layers).map_err(error::runtime_error)
    }

    /// Events of the last step: a JSON array of pairs.
    fn _events(&self) -> PyResult<String> {
        let number = |id: &Id| self.ids.iter().position(|known| known == id);
        let events: Vec<_> = self.characters.events().iter().map(|(id, event)| (number(id), event)).collect();
        serde_json::to_string(&events).map_err(|e| error::input_error(e.to_string()))
    }

    /// Moves a character to another place at once (m, radians).
    fn place(&mut self, who: usize, x: f32, z: f32, heading: f32) -> PyResult<()> {
        let id = self.id(who)?;
        self.characters.place(id, Planar::new(x, z, heading)).map_err(error::runtime_error)
    }

    /// Steps the simulation by a duration (s).
    #[pyo3(signature = (dt_s=1.0 / 60.0))]
    fn step(&mut self, py: Python<'_>, dt_s: f32) -> PyResult<()> {
        py.detach(|| self.characters.step(dt_s, &Inline)).map_err(error::runtime_error)
    }

    /// Positions and headings of all characters: x, z, heading (n x 3; m, radians); a copy.
    #[getter]
    fn roots<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let roots = self.characters.bodies().roots;
        let rows: Vec<f32> = roots.iter().flat_map(|r| [r.x, r.z, r.heading]).collect();
        PyArray1::from_vec(py, rows).reshape([roots.len(), 3])
    }

    /// Matrices from joints to the character's own frame, row by row (n x 22 x 3 x 4; m); a copy.
    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray4<f32>>> {
        let model = self.characters.bodies().model;
        let mut rows = vec![0.0; model.len() * NUM_JOINTS * 12];
        rows.as_chunks_mut().0.iter_mut().zip(model).for_each(|(to, pose)| write_pose(pose, to));
        PyArray1::from_vec(py, rows).reshape([model.len(), NUM_JOINTS, 3, 4])
    }

    /// Bytes of the records, 32 each.
    fn _instances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        PyArray1::from_slice(py, bytemuck::cast_slice(self.characters.instances()))
    }

    /// Sets which characters are posed from now on, by their distance from an eye (x, z): feet stay in place up to `full_m`,
    /// poses are computed up to `posed_m`, those of others stay as they were (m). Without an eye, all characters are posed.
    /// Their paths do not depend on it.
    #[pyo3(signature = (eye=None, full_m=20.0, posed_m=60.0))]
    fn set_detail(&mut self, eye: Option<[f32; 2]>, full_m: f32, posed_m: f32) -> PyResult<()> {
        let detail = eye.map(|eye| Detail { eye: Vec2::from_array(eye), full_m, posed_m });
        self.characters.set_detail(detail).map_err(error::runtime_error)
    }

    /// The whole state, as bytes: after it is restored anywhere, later steps are the same bit by bit.
    fn snapshot<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let mut out = Vec::new();
        self.characters.save(&mut out);
        PyBytes::new(py, &out)
    }

    /// Restores a snapshot of as many characters of the same bundle.
    fn restore(&mut self, snapshot: &[u8]) -> PyResult<()> {
        self.characters.load(snapshot).map_err(error::runtime_error)
    }

    /// A hash of the state: equal for equal motion of all characters.
    fn hash(&self) -> u64 {
        self.characters.hash()
    }

    fn __len__(&self) -> usize {
        self.ids.len()
    }
}

impl PyCharacters {
    /// Id of a row.
    fn id(&self, who: usize) -> PyResult<Id> {
        let fault = || error::input_error(format!("character {who} does not exist, there are {}", self.ids.len()));
        self.ids.get(who).copied().ok_or_else(fault)
    }
}
