//! Promises of the library for C, one module each.

mod clients;
mod header;
