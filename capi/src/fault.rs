//! Status of calls, and the message of the last failed call of a thread.

use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use throng_base::{Error, error::ensure};
use throng_runtime::format::FormatError;

/// Status of a call. `throng_last_error` has the reason in words.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThrongStatus {
    /// Done.
    Ok = 0,
    /// A pointer is null or not aligned, or a text is not UTF-8.
    Pointer = 1,
    /// The handle was freed, or never existed.
    Handle = 2,
    /// Another thread is in a call with this handle.
    Busy = 3,
    /// A number, name or length is out of its range.
    Value = 4,
    /// The memory given is too small.
    TooSmall = 5,
    /// A file cannot be read.
    Io = 6,
    /// A file or snapshot is damaged, or not what it should be.
    Format = 7,
    /// The character has left.
    Gone = 8,
    /// All places are taken.
    Full = 9,
    /// The place is taken, or no path leads there.
    Place = 10,
    /// This kind of simulation cannot do that.
    Unsupported = 11,
    /// A fault of this library; the simulation has to be freed.
    Panic = 12,
}

/// Result of a call, or the reason why it failed.
pub type CallResult<T = ()> = Result<T, CallFault>;

/// Reason of a failed call.
pub struct CallFault {
    pub status: ThrongStatus,
    pub why: String,
}

impl CallFault {
    pub fn new(status: ThrongStatus, why: impl Into<String>) -> Self {
        Self { status, why: why.into() }
    }

    /// Adds the path of the file to the reason, unless it is there.
    pub fn with_path(mut self, path: &str) -> Self {
        if !self.why.contains(path) {
            self.why = format!("{path}: {}", self.why);
        }
        self
    }
}

impl From<Error> for CallFault {
    fn from(e: Error) -> Self {
        let status = match &e {
            Error::Io { .. } => ThrongStatus::Io,
            Error::Format { .. } | Error::Text { .. } | Error::Snapshot { .. } | Error::OtherBundle { .. } => {
                ThrongStatus::Format
            }
            Error::Gone(_) => ThrongStatus::Gone,
            Error::Full { .. } => ThrongStatus::Full,
            Error::NoPath { .. } | Error::Occupied { .. } => ThrongStatus::Place,
            _ => ThrongStatus::Value,
        };
        Self::new(status, e.to_string())
    }
}

impl From<FormatError> for CallFault {
    fn from(e: FormatError) -> Self {
        let status = if let FormatError::Io { .. } = e { ThrongStatus::Io } else { ThrongStatus::Format };
        Self::new(status, e.to_string())
    }
}

thread_local! {
    static LAST_ERROR: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs a call: stores its fault for this thread, and catches panics.
pub fn catch_fault(work: impl FnOnce() -> CallResult) -> ThrongStatus {
    let fault = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return ThrongStatus::Ok,
        Ok(Err(fault)) => fault,
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
            CallFault::new(ThrongStatus::Panic, format!("a fault of Throng, please report it: {text}"))
        }
    };
    LAST_ERROR.with_borrow_mut(|last| *last = fault.why);
    fault.status
}

/// Copies the message of the last failed call of this thread, in UTF-8 and with a zero at its end; cut if it is too long.
///
/// @param buffer memory for the text; may be null where `size` is 0.
/// @param size its length (bytes).
/// @return the length of the whole text, without the zero (bytes).
///
/// # Safety
/// `buffer` must have room for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn throng_last_error(buffer: *mut c_char, size: usize) -> usize {
    LAST_ERROR.with_borrow(|last| {
        // SAFETY: the caller promises room for `size` bytes.
        unsafe { copy_text(last, buffer, size) }
    })
}

/// Copies a text with a zero at its end, cut at a character's border; returns its whole length (bytes).
///
/// # Safety
/// `buffer` must have room for `size` bytes.
pub unsafe fn copy_text(text: &str, buffer: *mut c_char, size: usize) -> usize {
    if !buffer.is_null() && size > 0 {
        let end = text.floor_char_boundary(size - 1);
        // SAFETY: `end < size`, and the caller promises room for `size` bytes.
        unsafe {
            std::ptr::copy_nonoverlapping(text.as_ptr().cast(), buffer, end);
            buffer.add(end).write(0);
        }
    }
    text.len()
}

/// Reads a text of the caller.
///
/// # Safety
/// `read_text` must be null or end with a zero.
pub unsafe fn read_text<'a>(what: &str, text: *const c_char) -> CallResult<&'a str> {
    ensure(!text.is_null(), || null_fault(what))?;
    // SAFETY: the caller promises a zero at its end.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| CallFault::new(ThrongStatus::Pointer, format!("`{what}` is not UTF-8")))
}

/// Writes a result to memory of the caller.
///
/// # Safety
/// `to` must be null or point to a `T` that may be written.
pub unsafe fn write_result<T>(what: &str, to: *mut T, value: T) -> CallResult {
    check_pointer(what, to)?;
    // SAFETY: neither null nor out of line; the caller promises that it may be written.
    unsafe { to.write(value) };
    Ok(())
}

/// Borrows bytes or records of the caller.
///
/// # Safety
/// `from` must be null or point to `len` records.
pub unsafe fn read_slice<'a, T>(what: &str, from: *const T, len: usize) -> CallResult<&'a [T]> {
    if len == 0 {
        return Ok(&[]);
    }
    check_pointer(what, from)?;
    let fits = len.checked_mul(size_of::<T>()).is_some_and(|bytes| bytes <= isize::MAX as usize);
    ensure(fits, || CallFault::new(ThrongStatus::Value, format!("`{what}` cannot have {len} elements")))?;
    // SAFETY: neither null, out of line nor too long; the caller promises `len` records.
    Ok(unsafe { std::slice::from_raw_parts(from, len) })
}

/// Copies as many records as there is room for, and writes the number of all records.
///
/// # Safety
/// `to` must be null or have room for `capacity` records, `count` must be null or writable.
pub unsafe fn copy_records<T: Copy>(
    records: impl ExactSizeIterator<Item = T>,
    to: *mut T,
    capacity: usize,
    count: *mut usize,
) -> CallResult {
    let len = records.len();
    if capacity > 0 {
        check_pointer("records", to)?;
    }
    for (k, record) in records.take(capacity).enumerate() {
        // SAFETY: `k < capacity`, for which the caller promises room.
        unsafe { to.add(k).write(record) };
    }
    // SAFETY: promised by the caller.
    unsafe { write_result("count", count, len) }
}

pub fn check_pointer<T>(what: &str, pointer: *const T) -> CallResult {
    ensure(!pointer.is_null(), || null_fault(what))?;
    let why = || format!("`{what}` is not aligned, expected a multiple of {} bytes", align_of::<T>());
    ensure(pointer.is_aligned(), || CallFault::new(ThrongStatus::Pointer, why()))
}

fn null_fault(what: &str) -> CallFault {
    CallFault::new(ThrongStatus::Pointer, format!("`{what}` is null"))
}
