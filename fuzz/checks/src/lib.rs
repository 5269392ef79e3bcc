//! Checks for developers: damaged input, soaks, and the self-test of the command line.

pub mod damage;
pub mod selftest;
pub mod soak;
