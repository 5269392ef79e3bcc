//! Promises of the checks, one module each.

mod commands;
mod fuzz_short;
