//! Tests of the three schemes against each other and against brute force.
