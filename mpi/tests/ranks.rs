//! `throng-mpi` as processes that `mpirun` starts.

use std::process::{Command, Output};

/// Runs the program in so many processes.
fn mpirun(ranks: usize, words: &[&str]) -> Output {
    let mut run = Command::new("mpirun");
    run.args(["--oversubscribe", "--allow-run-as-root", "-n", &ranks.to_string(), env!("CARGO_BIN_EXE_throng-mpi")]);
    run.args(words).output().expect("mpirun is there where MPI is")
}

fn json(output: &Output) -> serde_json::Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn crowd_of_several_processes_is_that_of_one() {
    let words = ["crowd", "lanes", "--agents", "300", "--seconds", "30", "--json"];
    let alone = json(&mpirun(1, &words));
    assert_eq!((alone["ranks"].as_u64(), alone["bytes_moved"].as_u64()), (Some(1), Some(0)));
    for ranks in [2, 4] {
        let shared = json(&mpirun(ranks, &words));
        assert_eq!(shared["state_hash"], alone["state_hash"], "{ranks} ranks");
        assert_eq!(shared["agents"], 300);
        assert_eq!(shared["overlaps"], 0);
        assert!(shared["handed_over"].as_u64() > Some(0) && shared["bytes_moved"].as_u64() > Some(0));
        assert!(shared["us_per_agent_second"].as_f64() > Some(0.0));
    }
}

#[test]
fn what_goes_wrong_ends_all_processes_with_one_message() {
    let failed = mpirun(2, &["crowd", "square"]);
    let told = String::from_utf8_lossy(&failed.stderr).into_owned();
    assert_eq!(failed.status.code(), Some(1), "{told}");
    assert_eq!(told.matches("only one process can move such").count(), 1, "{told}");
}
