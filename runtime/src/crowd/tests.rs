//! Tests of whole crowds.
