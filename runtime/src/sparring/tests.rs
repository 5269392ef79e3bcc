//! Sparring on made-up tables.
