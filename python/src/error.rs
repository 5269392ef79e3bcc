//! Errors of the library as exceptions: the same texts, in subclasses of Python's own exceptions.

use pyo3::prelude::*;
use std::fmt::Display;
use std::path::Path;
use throng_precompute::error::{BuildError, ImportError};
use throng_runtime::base::Error;
use throng_runtime::format::FormatError;

/// An exception of `throng._errors`.
fn raise(class: &str, why: impl Display) -> PyErr {
    Python::attach(|py| {
        let made = py.import("throng._errors").and_then(|m| m.getattr(class)?.call1((why.to_string(),)));
        made.map_or_else(|e| e, PyErr::from_value)
    })
}

/// An error of an input.
pub fn input(why: impl Display) -> PyErr {
    raise("InputError", why)
}

/// An error of reading or writing a file.
pub fn file(why: impl Display) -> PyErr {
    raise("FileError", why)
}

/// Converts an error of the runtime.
pub fn of(e: Error) -> PyErr {
    match e {
        Error::Io { .. } => file(e),
        e => input(e),
    }
}

/// Converts an error of a bundle's file.
pub fn of_format(path: &Path, e: FormatError) -> PyErr {
    match e {
        FormatError::Io { .. } => file(e),
        e => input(format!("{}: {e}", path.display())),
    }
}

/// Converts an error of a build.
pub fn of_build(e: BuildError) -> PyErr {
    match e {
        BuildError::File(e) => of(e),
        BuildError::Io { .. } | BuildError::Import(ImportError::Io { .. }) => file(e),
        e => input(e),
    }
}
