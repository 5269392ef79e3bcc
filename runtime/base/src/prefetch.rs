//! Fetching memory before it is needed.

/// Bytes that are fetched together.
const LINE: usize = 64;

/// Asks the processor to fetch a value from memory while it goes on with something else. Changes nothing but the time that
/// the first access to the value takes, and does nothing on processors without such an instruction.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let fetch = |byte: usize| {
            let at = std::ptr::from_ref(value).cast::<i8>().wrapping_add(byte);
            #[allow(unsafe_code)]
            // SAFETY: this reads and writes nothing, wherever it points, and every x86-64 processor knows it.
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(at);
            }
        };
        (0..size_of::<T>()).step_by(LINE).for_each(fetch);
        if align_of::<T>() < LINE.min(size_of::<T>()) {
            // It may begin in the middle of a line, and end in one more.
            fetch(size_of::<T>().saturating_sub(1));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (value, LINE);
}
