//! Tables of handles. Numbers are never reused, so that a freed handle is recognized.

use crate::fault::{Fault, ThrongStatus};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{PoisonError, RwLock};

/// All objects of a kind, by the numbers of their handles.
pub struct Handles<T>(RwLock<BTreeMap<u64, T>>);

/// The next number; 0 is no handle.
static NEXT: AtomicU64 = AtomicU64::new(1);

impl<T: Clone> Handles<T> {
    pub const fn new() -> Self {
        Self(RwLock::new(BTreeMap::new()))
    }

    pub fn add(&self, value: T) -> u64 {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        self.0.write().unwrap_or_else(PoisonError::into_inner).insert(number, value);
        number
    }

    pub fn get(&self, what: &str, number: u64) -> Result<T, Fault> {
        let all = self.0.read().unwrap_or_else(PoisonError::into_inner);
        all.get(&number).cloned().ok_or_else(|| gone(what, number))
    }

    pub fn remove(&self, what: &str, number: u64) -> Result<(), Fault> {
        let removed = self.0.write().unwrap_or_else(PoisonError::into_inner).remove(&number);
        // Dropped here, after the lock is released, as it may take a while.
        removed.map(drop).ok_or_else(|| gone(what, number))
    }
}

fn gone(what: &str, number: u64) -> Fault {
    let why = if number == 0 { "it was never made" } else { "it was freed, or is of another kind" };
    Fault::new(ThrongStatus::Handle, format!("there is no {what} with handle {number}: {why}"))
}
