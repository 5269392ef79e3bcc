//! The compiled part of the Python package `throng`; names and texts for users are in `python/throng`.

mod bundle;
mod characters;
mod error;
mod precompute;
mod simulation;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _throng(m: &Bound<'_, PyModule>) -> PyResult<()> {
    m.add("__version__", env!("CARGO_PKG_VERSION"))?;
    m.add_class::<bundle::PyBundle>()?;
    m.add_class::<simulation::PySimulation>()?;
    m.add_class::<characters::PyCharacters>()?;
    m.add_function(wrap_pyfunction!(precompute::build, m)?)?;
    m.add_function(wrap_pyfunction!(precompute::load_clip, m)?)?;
    m.add_function(wrap_pyfunction!(precompute::export, m)?)?;
    Ok(())
}
