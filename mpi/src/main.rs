//! The command line of Throng in several processes: one file per subcommand, as in `throng`.

mod build;
mod comm;
mod crowd;
mod progress;

use clap::{Parser, Subcommand};
use comm::MpiComm;
use progress::{LocalRankStatuses, RankStatuses};
use std::{process::ExitCode, sync::Arc, time::Duration};
use throng_core::base::text::{escape_for_terminal, escape_json_for_terminal};
use throng_core::base::{Comm, LocalComm, limit_threads, limits};

/// Moves crowds in several processes: `mpirun -n RANKS throng-mpi ...`.
///
/// Every process is started with the same arguments and sees the same files.
#[derive(Parser)]
#[command(
    name = "throng-mpi",
    version,
    after_help = "Exit codes: 0 done, 1 failed, 2 wrong usage; mpirun has its own for a process that was killed. The first \
                  process prints; with --json, one JSON object on standard output, and JSON lines of its progress on standard error."
)]
struct MpiCli {
    #[command(subcommand)]
    command: MpiCommand,
    /// Without MPI: number of threads of this process in place of processes.
    #[arg(long, global = true, value_name = "N", value_parser = limits::number_parser::<usize>(&limits::THREADS))]
    local: Option<usize>,
}

#[derive(Subcommand)]
enum MpiCommand {
    Build(build::Args),
    Crowd(crowd::Args),
}

/// Result of a subcommand.
type MpiResult = Result<(), Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    limit_threads();
    let cli = MpiCli::parse();
    if let Some(ranks) = cli.local {
        let statuses: Arc<dyn RankStatuses> = Arc::new(LocalRankStatuses::default());
        let done = LocalComm::run(ranks, |comm| run(&cli.command, comm, &statuses).map_err(|e| e.to_string()));
        let failed = done.into_iter().filter_map(Result::err);
        // Ranks that waited for a failed rank fail too.
        let Some(e) = failed.min_by_key(|e| e.ends_with("has ended")) else { return ExitCode::SUCCESS };
        eprintln!("error: {}", escape_for_terminal(&e));
        return ExitCode::FAILURE;
    }
    let Some(comm) = MpiComm::new() else {
        eprintln!("error: MPI does not start; run it with `mpirun -n RANKS throng-mpi ...`");
        return ExitCode::FAILURE;
    };
    let statuses = comm.rank_statuses();
    let done = run(&cli.command, &comm, &(statuses.clone() as Arc<dyn RankStatuses>));
    let done = done.and_then(|()| Ok(comm.wait_for_statuses(&statuses)?));
    let Err(e) = done else { return ExitCode::SUCCESS };
    // An error of all ranks is printed once: by the first, which ends the others.
    if comm.rank() > 0 {
        std::thread::sleep(Duration::from_millis(500));
    }
    eprintln!("error: rank {}: {}", comm.rank(), escape_for_terminal(&e.to_string()));
    comm.abort()
}

/// Runs a command as one of the ranks.
fn run(command: &MpiCommand, comm: &dyn Comm, statuses: &Arc<dyn RankStatuses>) -> MpiResult {
    match command {
        MpiCommand::Build(a) => build::run(a, comm, statuses),
        MpiCommand::Crowd(a) => crowd::run(a, comm, statuses),
    }
}

/// Prints one JSON object on standard output.
fn print_json(value: &impl serde::Serialize) -> MpiResult {
    println!("{}", escape_json_for_terminal(&serde_json::to_string_pretty(value)?));
    Ok(())
}
