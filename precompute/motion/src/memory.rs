//! How much memory the program has in use, where the system tells (Linux), and numbers of bytes as text.

/// Most memory that the program has held so far; `None` where the system does not tell (bytes).
pub fn peak_bytes() -> Option<u64> {
    status_bytes("VmHWM:")
}

/// Resident memory of the program; `None` where the system does not tell (bytes).
pub fn resident_bytes() -> Option<u64> {
    status_bytes("VmRSS:")
}

fn status_bytes(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix(key))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| 1024 * kb)
}

/// A number of bytes as text, such as `20.5 kB`.
pub fn bytes_text(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn byte_counts_are_shown_in_fitting_units() {
        assert_eq!([999, 20_480, 30 << 20].map(bytes_text), ["999 bytes", "20.5 kB", "31.5 MB"]);
    }
}
