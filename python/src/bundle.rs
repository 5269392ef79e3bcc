//! Bundles: sections as arrays that share the file's memory, and policy queries.

use crate::error;
use numpy::ndarray::ArrayView1;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use throng_core::base::error::ensure;
use throng_core::format::SectionTag;
use throng_runtime::glam::Vec3;
use throng_runtime::policy::{BestActionJob, LookAheadGoal, LookAheadJob, RankedActions};
use throng_runtime::{Bundle, Joint};

/// An open bundle (`*.throng`), see `throng.Bundle`.
#[pyclass(frozen, subclass, name = "Bundle", module = "throng._throng")]
pub struct PyBundle(pub Bundle);

#[pymethods]
impl PyBundle {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let opened = py.detach(|| Bundle::open(&path));
        Ok(Self(opened.map_err(|e| error::format_error(&path, e))?))
    }

    /// Tag, number of elements and length of an element of each section (bytes).
    fn _sections(&self) -> Vec<(String, usize, usize)> {
        let tags = self.0.section_sizes().filter_map(|(tag, bytes)| {
            let (_, element) = self.0.section_bytes(tag)?;
            Some((tag.to_string(), bytes / element.max(1), element))
        });
        tags.collect()
    }

    /// Bytes of a section, as an array that shares the bundle's memory and keeps it alive.
    fn _bytes<'py>(this: &Bound<'py, Self>, tag: &str) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let bundle = &this.get().0;
        let found = <[u8; 4]>::try_from(tag.as_bytes()).ok().and_then(|tag| bundle.section_bytes(SectionTag(tag)));
        let known = || bundle.section_sizes().map(|s| s.0.to_string()).collect::<Vec<_>>().join(", ");
        let fault = || error::input_error(format!("there is no section \"{tag}\"; there is {}", known()));
        let view = ArrayView1::from(found.ok_or_else(fault)?.0);
        // SAFETY: the bytes never change nor move while a clone of the bundle lives, and `this`, which owns one for its whole
        // life, is the array's base. The array is read-only from the next line on, and numpy does not allow to undo that if
        // the base is not writable.
        #[allow(unsafe_code)]
        let array = unsafe { PyArray1::borrow_from_array(&view, this.clone().into_any()) };
        array.call_method1("setflags", (false,))?;
        Ok(array)
    }

    /// Names of the behaviours, each with a policy.
    #[getter]
    fn behaviours(&self) -> Vec<String> {
        self.0.meta().behaviours.clone()
    }

    /// Names of the blend spaces.
    #[getter]
    fn blend_spaces(&self) -> Vec<String> {
        self.0.meta().blends.iter().map(|b| b.name.clone()).collect()
    }

    /// Frames a second (Hz).
    #[getter]
    fn rate_hz(&self) -> f64 {
        self.0.meta().rate_hz
    }

    /// States of the motion graph.
    #[getter]
    fn num_states(&self) -> usize {
        self.0.graph().states.len()
    }

    /// Length of the bundle (bytes).
    #[getter]
    fn num_bytes(&self) -> usize {
        self.0.num_bytes()
    }

    /// Names of the joints, in the order of all arrays of joints.
    #[getter]
    fn joints(&self) -> Vec<&'static str> {
        Joint::ALL.iter().map(|j| j.name()).collect()
    }

    /// Actions of a policy in states, with targets in each character's own frame (X left, Y up, Z ahead; m).
    #[pyo3(signature = (states, targets, behaviour=None))]
    fn _query<'py>(
        &self,
        py: Python<'py>,
        states: PyReadonlyArray1<'py, u32>,
        targets: PyReadonlyArray2<'py, f32>,
        behaviour: Option<&str>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let number = behaviour.map_or(Ok(0), |name| self.0.find_policy(name)).map_err(error::runtime_error)?;
        let policy = self.0.policies().get(number).ok_or_else(error::no_policy)?;
        let (states, targets) = (states.as_array().to_vec(), points(&targets)?);
        let (got, n) = (targets.len(), states.len());
        let fault = || format!("`targets` has {got} rows, expected {n}, one for each state");
        ensure(got == n, || error::input_error(fault()))?;
        let (mut best, mut ranked, weights) = (vec![0u8; n], vec![RankedActions::NONE; n], vec![1.0; n]);
        let asked = py.detach(|| {
            BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions: &mut best }.run()?;
            let goals = [LookAheadGoal { policy, weights: &weights, targets: &targets }];
            LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run()
        });
        asked.map_err(error::runtime_error)?;
        let out = PyDict::new(py);
        let segments: Vec<u32> =
            (states.iter().zip(&ranked)).map(|(&s, r)| self.0.graph().segments_of(s)[usize::from(r.best())]).collect();
        let rows = |of: &dyn Fn(&RankedActions) -> Vec<f32>| ranked.iter().map(of).collect::<Vec<_>>();
        out.set_item("stored", PyArray1::from_vec(py, best))?;
        out.set_item("best", PyArray1::from_iter(py, ranked.iter().map(RankedActions::best)))?;
        out.set_item("segment", PyArray1::from_vec(py, segments))?;
        out.set_item("scores", PyArray2::from_vec2(py, &rows(&|r| r.scores.to_vec()))?)?;
        Ok(out)
    }

    fn __repr__(&self) -> String {
        let (states, bytes) = (self.num_states(), self.num_bytes());
        format!("Bundle({states} states, behaviours {:?}, {bytes} bytes)", self.behaviours())
    }
}

/// Points from an array with rows of three numbers.
pub fn points(array: &PyReadonlyArray2<'_, f32>) -> PyResult<Vec<Vec3>> {
    let array = array.as_array();
    let fault = || format!("expected rows of 3 numbers (x, y, z), found {}", array.ncols());
    ensure(array.ncols() == 3, || error::input_error(fault()))?;
    Ok(array.rows().into_iter().map(|r| Vec3::new(r[0], r[1], r[2])).collect())
}
