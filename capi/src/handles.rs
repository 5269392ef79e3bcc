//! Tables of handles. Numbers are never reused, so that a freed handle is recognized.

use crate::fault::{CallFault, CallResult, ThrongStatus};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{PoisonError, RwLock};

/// All objects of a kind, by the numbers of their handles.
pub struct HandleTable<T>(RwLock<BTreeMap<u64, T>>);

/// The next number; 0 is no handle.
static NEXT_HANDLE: AtomicU64 = AtomicU64::new(1);

impl<T: Clone> HandleTable<T> {
    pub const fn new() -> Self {
        Self(RwLock::new(BTreeMap::new()))
    }

    pub fn add(&self, value: T) -> u64 {
        let number = NEXT_HANDLE.fetch_add(1, Ordering::Relaxed);
        self.0.write().unwrap_or_else(PoisonError::into_inner).insert(number, value);
        number
    }

    pub fn get(&self, what: &str, number: u64) -> CallResult<T> {
        let all = self.0.read().unwrap_or_else(PoisonError::into_inner);
        all.get(&number).cloned().ok_or_else(|| unknown_handle(what, number))
    }

    pub fn remove(&self, what: &str, number: u64) -> CallResult {
        let removed = self.0.write().unwrap_or_else(PoisonError::into_inner).remove(&number);
        // Dropped here, after the lock is released, as it may take a while.
        removed.map(drop).ok_or_else(|| unknown_handle(what, number))
    }
}

fn unknown_handle(what: &str, number: u64) -> CallFault {
    let why = if number == 0 { "it was never made" } else { "it was freed, or is of another kind" };
    CallFault::new(ThrongStatus::Handle, format!("there is no {what} with handle {number}: {why}"))
}
