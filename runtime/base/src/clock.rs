//! CPU times of threads, where the system reports them (Linux). They measure a run and never change its results.

use std::fs::{read_dir, read_to_string};

/// CPU time of this thread so far (s).
pub fn thread_cpu_s() -> Option<f64> {
    parse_cpu_s(&read_to_string("/proc/thread-self/schedstat").ok()?)
}

/// CPU time so far of all threads of this process that have not ended (s).
pub fn process_cpu_s() -> Option<f64> {
    let threads = read_dir("/proc/self/task").ok()?.flatten();
    // A thread may end meanwhile.
    let ran = threads.filter_map(|t| parse_cpu_s(&read_to_string(t.path().join("schedstat")).ok()?));
    Some(ran.sum())
}

/// CPU time of a `schedstat` file, whose first number is in nanoseconds (s).
fn parse_cpu_s(schedstat: &str) -> Option<f64> {
    Some(schedstat.split(' ').next()?.parse::<f64>().ok()? * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_time_of_the_thread_and_of_its_process() {
        let (Some(thread), Some(process)) = (thread_cpu_s(), process_cpu_s()) else { return };
        let mut n = 1u64;
        while thread_cpu_s().unwrap() < thread + 0.02 {
            n = std::hint::black_box(n.wrapping_mul(3));
        }
        assert!(process_cpu_s().unwrap() >= process + 0.02);
        assert!(std::thread::spawn(|| thread_cpu_s().unwrap()).join().unwrap() < 0.02, "another thread's is its own");
    }
}
