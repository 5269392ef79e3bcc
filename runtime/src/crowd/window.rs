//! Independent events on several threads.
