//! Errors of the library as exceptions: the same texts, in subclasses of Python's own exceptions.

use pyo3::prelude::*;
use std::fmt::Display;
use std::path::Path;
use throng_precompute::error::{BuildError, ImportError};
use throng_runtime::Error;
use throng_runtime::format::FormatError;

/// An exception of `throng._errors`.
fn python_error(class: &str, why: impl Display) -> PyErr {
    Python::attach(|py| {
        let made = py.import("throng._errors").and_then(|m| m.getattr(class)?.call1((why.to_string(),)));
        made.map_or_else(|e| e, PyErr::from_value)
    })
}

/// An error of an input.
pub fn input_error(why: impl Display) -> PyErr {
    python_error("InputError", why)
}

/// An error of a bundle in which nobody can be moved by a policy.
pub fn no_policy() -> PyErr {
    input_error("the bundle has no policy; build it from motion in which somebody walks")
}

/// An error of reading or writing a file.
pub fn file_error(why: impl Display) -> PyErr {
    python_error("FileError", why)
}

/// Converts an error of the runtime.
pub fn runtime_error(e: Error) -> PyErr {
    match e {
        Error::Io { .. } => file_error(e),
        e => input_error(e),
    }
}

/// Converts an error of a bundle's file.
pub fn format_error(path: &Path, e: FormatError) -> PyErr {
    match e {
        FormatError::Io { .. } => file_error(e),
        e => input_error(format!("{}: {e}", path.display())),
    }
}

/// Converts an error of a build.
pub fn build_error(e: BuildError) -> PyErr {
    match e {
        BuildError::File(e) => runtime_error(e),
        BuildError::Io { .. } | BuildError::Import(ImportError::Io { .. }) => file_error(e),
        e => input_error(e),
    }
}
