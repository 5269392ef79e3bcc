//! Time that a thread was running.

/// Time that this thread was running so far, where the system tells it (s).
pub fn running_s() -> Option<f64> {
    let ran = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(ran.split(' ').next()?.parse::<f64>().ok()? * 1e-9)
}
