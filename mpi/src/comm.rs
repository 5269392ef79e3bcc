//! Messages between processes, by MPI.

use crate::progress::{LocalRankStatuses, RankStatus, RankStatuses};
use mpi::datatype::{Partition, PartitionMut};
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use mpi::{Threading, collective::SystemOperation, environment::Universe, point_to_point::MatchedReceiveVec};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::{cell::Cell, time::Instant};
use throng_core::base::clock::{process_cpu_s, thread_cpu_s};
use throng_core::base::{Comm, Error, Result, Traffic};

/// Communication between all processes that `mpirun` has started. If one of them ends, MPI ends all.
pub struct MpiComm {
    world: SimpleCommunicator,
    traffic: Cell<Traffic>,
    /// Processor time of this thread while it waited, as MPI polls (s).
    waited_ran_s: Cell<f64>,
    /// True if other threads may send messages, too.
    may_send_status: bool,
    /// The MPI environment, which ends when this is dropped.
    _universe: Universe,
}

impl MpiComm {
    /// Starts MPI; `None` if it runs already.
    pub fn new() -> Option<Self> {
        let (universe, threading) = mpi::initialize_with_threading(Threading::Multiple)?;
        let (traffic, waited_ran_s) = (Cell::default(), Cell::default());
        let may_send_status = threading == Threading::Multiple;
        Some(Self { world: universe.world(), traffic, waited_ran_s, may_send_status, _universe: universe })
    }

    /// Ends all processes, with the exit code of a failure.
    pub fn abort(&self) -> ! {
        self.world.abort(1)
    }

    /// Statuses that this rank sends; the first rank receives those of all.
    pub fn rank_statuses(&self) -> Arc<MpiRankStatuses> {
        let (sent, received) = (AtomicU64::default(), Mutex::default());
        Arc::new(MpiRankStatuses { may_send_status: self.may_send_status, sent, received })
    }

    /// Waits until the first rank has received all statuses, as MPI must not end before.
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    pub fn wait_for_statuses(&self, statuses: &MpiRankStatuses) -> Result<()> {
        let sent = self.sum(statuses.sent.load(Ordering::Relaxed))?;
        while self.rank() == 0 && statuses.receive_statuses() < sent {
            std::thread::yield_now();
        }
        self.barrier()
    }

    /// Counts the bytes that a call moves, and its time.
    fn count_traffic<T>(&self, bytes: usize, call: impl FnOnce() -> Result<T>) -> Result<T> {
        let (begin, ran) = (Instant::now(), thread_cpu_s());
        let done = call();
        self.waited_ran_s.update(|s| s + thread_cpu_s().zip(ran).map_or(0.0, |(after, before)| after - before));
        let mut traffic = self.traffic.get();
        traffic.bytes_moved += bytes as u64;
        traffic.waited_s += begin.elapsed().as_secs_f64();
        self.traffic.set(traffic);
        done
    }

    /// Lengths and offsets of parts, in the integers of MPI.
    fn message_counts(&self, lengths: impl Iterator<Item = usize>) -> Result<(Vec<i32>, Vec<i32>)> {
        let (mut message_counts, mut starts, mut all) = (Vec::new(), Vec::new(), 0usize);
        let why = |n: usize| format!("moves messages of {n} bytes at once, and MPI 2^31 at most; use more ranks");
        let count = |n: usize| i32::try_from(n).map_err(|_| Error::Rank { rank: self.rank(), why: why(n) });
        for length in lengths {
            starts.push(count(all)?);
            message_counts.push(count(length)?);
            all += length;
        }
        Ok((message_counts, starts))
    }
}

/// Most bytes that all ranks gather at once: MPI counts to 2^31.
const MAX_GATHER_BYTES: usize = 1 << 30;

/// Buffer for messages of some lengths, with an allocation even if it is empty, as MPI takes the address of an empty `Vec`
/// for a special value.
fn receive_buffer(message_counts: &[i32]) -> Vec<u8> {
    let all = message_counts.iter().map(|&c| c as usize).sum();
    let mut bytes = Vec::with_capacity(all + 1);
    bytes.resize(all, 0);
    bytes
}

/// Splits bytes into parts of some lengths.
fn split_messages(bytes: &[u8], message_counts: &[i32]) -> Vec<Vec<u8>> {
    let mut rest = bytes;
    let part = |&count: &i32| {
        let (part, after) = rest.split_at(count as usize);
        rest = after;
        part.to_vec()
    };
    message_counts.iter().map(part).collect()
}

/// Tag of status messages.
const STATUS_TAG: i32 = 1;

/// Statuses that are sent as messages to the first rank, apart from the messages of the ranks' work.
pub struct MpiRankStatuses {
    may_send_status: bool,
    /// Number of messages that this rank has sent.
    sent: AtomicU64,
    /// Number of messages that this rank has received, and the last status of each rank.
    received: Mutex<(u64, LocalRankStatuses)>,
}

impl MpiRankStatuses {
    /// Receives pending messages; returns the number of messages received so far.
    fn receive_statuses(&self) -> u64 {
        let mut received = self.received.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(message) = SimpleCommunicator::world().any_process().immediate_matched_probe_with_tag(STATUS_TAG)
        {
            let (bytes, status): (Vec<u8>, _) = message.matched_receive_vec();
            received.0 += 1;
            if let Ok(of_rank) = serde_json::from_slice(&bytes) {
                received.1.post_status(status.source_rank() as usize, of_rank);
            }
        }
        received.0
    }
}

impl RankStatuses for MpiRankStatuses {
    fn post_status(&self, rank: usize, of_rank: RankStatus) {
        match serde_json::to_vec(&of_rank) {
            _ if rank == 0 => self.received.lock().unwrap_or_else(PoisonError::into_inner).1.post_status(rank, of_rank),
            Ok(bytes) if self.may_send_status => {
                SimpleCommunicator::world().process_at_rank(0).send_with_tag(&bytes[..], STATUS_TAG);
                self.sent.fetch_add(1, Ordering::Relaxed);
            }
            _ => (),
        }
    }

    fn last_known(&self) -> Vec<Option<RankStatus>> {
        if self.may_send_status {
            self.receive_statuses();
        }
        self.received.lock().unwrap_or_else(PoisonError::into_inner).1.last_known()
    }
}

impl Comm for MpiComm {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn num_ranks(&self) -> usize {
        self.world.size() as usize
    }

    fn exchange(&self, messages: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        let own = messages.get(self.rank()).map_or(0, Vec::len);
        let all: usize = messages.iter().map(Vec::len).sum();
        self.count_traffic(all - own, || {
            let (message_counts, starts) = self.message_counts(messages.iter().map(Vec::len))?;
            let mut got = vec![0i32; self.num_ranks()];
            self.world.all_to_all_into(&message_counts, &mut got);
            let (got, got_starts) = self.message_counts(got.iter().map(|&c| c as usize))?;
            let mut bytes = receive_buffer(&got);
            let mut sent = Vec::with_capacity(all + 1);
            messages.iter().for_each(|m| sent.extend_from_slice(m));
            self.world.all_to_all_varcount_into(
                &Partition::new(&sent, message_counts, starts),
                &mut PartitionMut::new(&mut bytes, &got[..], got_starts),
            );
            Ok(split_messages(&bytes, &got))
        })
    }

    fn all_gather(&self, message: &[u8]) -> Result<Vec<Vec<u8>>> {
        self.count_traffic(message.len() * (self.num_ranks() - 1), || {
            let mut lengths = vec![0u64; self.num_ranks()];
            self.world.all_gather_into(&[message.len() as u64][..], &mut lengths[..]);
            let longest = lengths.iter().copied().max().unwrap_or(0) as usize;
            let part = (MAX_GATHER_BYTES / self.num_ranks()).max(1);
            let mut all: Vec<Vec<u8>> = vec![Vec::new(); self.num_ranks()];
            // A single round unless a message is long.
            for begin in (0..longest.max(1)).step_by(part) {
                let of = |length: usize| begin.min(length)..begin.saturating_add(part).min(length);
                let (got, starts) = self.message_counts(lengths.iter().map(|&n| of(n as usize).len()))?;
                let mut bytes = receive_buffer(&got);
                let own = &message[of(message.len())];
                // See `receive_buffer`.
                let own = if own.is_empty() { &[0][..0] } else { own };
                self.world.all_gather_varcount_into(own, &mut PartitionMut::new(&mut bytes, &got[..], starts));
                match longest <= part {
                    true => all = split_messages(&bytes, &got),
                    false => all.iter_mut().zip(split_messages(&bytes, &got)).for_each(|(all, part)| all.extend(part)),
                }
            }
            Ok(all)
        })
    }

    fn min(&self, number: f64) -> Result<f64> {
        self.reduce_all(number, SystemOperation::min())
    }

    fn max(&self, number: f64) -> Result<f64> {
        self.reduce_all(number, SystemOperation::max())
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    fn cpu_s(&self) -> Option<f64> {
        process_cpu_s().map(|s| s - self.waited_ran_s.get())
    }
}

impl MpiComm {
    fn reduce_all(&self, number: f64, operation: SystemOperation) -> Result<f64> {
        self.count_traffic(size_of::<f64>() * (self.num_ranks() - 1), || {
            let mut out = 0.0f64;
            self.world.all_reduce_into(&number, &mut out, operation);
            Ok(out)
        })
    }
}
