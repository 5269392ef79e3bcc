//! Messages between processes, by MPI.

use mpi::collective::SystemOperation;
use mpi::datatype::{Partition, PartitionMut};
use mpi::environment::Universe;
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use std::cell::Cell;
use std::time::Instant;
use throng_runtime::base::{Comm, Error, Result, Traffic};

/// All processes that `mpirun` has started. Where one of them ends, MPI ends all.
pub struct MpiComm {
    world: SimpleCommunicator,
    traffic: Cell<Traffic>,
    /// MPI ends with it.
    _universe: Universe,
}

impl MpiComm {
    /// Starts MPI; `None` where it runs already.
    pub fn new() -> Option<Self> {
        let universe = mpi::initialize()?;
        Some(Self { world: universe.world(), traffic: Cell::default(), _universe: universe })
    }

    /// Ends all processes, with the exit code of a failure.
    pub fn abort(&self) -> ! {
        self.world.abort(1)
    }

    /// Counts what a call moves, and how long it takes.
    fn counted<T>(&self, bytes: usize, call: impl FnOnce() -> Result<T>) -> Result<T> {
        let begin = Instant::now();
        let done = call();
        let mut traffic = self.traffic.get();
        traffic.bytes_moved += bytes as u64;
        traffic.waited_s += begin.elapsed().as_secs_f64();
        self.traffic.set(traffic);
        done
    }

    /// Lengths as MPI counts them, and where each part begins.
    fn counts(&self, lengths: impl Iterator<Item = usize>) -> Result<(Vec<i32>, Vec<i32>)> {
        let (mut counts, mut starts, mut all) = (Vec::new(), Vec::new(), 0usize);
        for length in lengths {
            let count = |n: usize| {
                i32::try_from(n).map_err(|_| Error::Rank {
                    rank: self.rank(),
                    why: format!("moves messages of {n} bytes at once, and MPI 2^31 at most; use more ranks"),
                })
            };
            starts.push(count(all)?);
            counts.push(count(length)?);
            all += length;
        }
        Ok((counts, starts))
    }
}

/// Room for messages of some lengths, somewhere in memory even where there is nothing to hold: MPI takes the address of
/// an empty `Vec` for a word of its own.
fn room(counts: &[i32]) -> Vec<u8> {
    let all = counts.iter().map(|&c| c as usize).sum();
    let mut bytes = Vec::with_capacity(all + 1);
    bytes.resize(all, 0);
    bytes
}

/// Parts of bytes that follow each other.
fn parts(bytes: &[u8], counts: &[i32]) -> Vec<Vec<u8>> {
    let mut rest = bytes;
    let part = |&count: &i32| {
        let (part, after) = rest.split_at(count as usize);
        rest = after;
        part.to_vec()
    };
    counts.iter().map(part).collect()
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
        self.counted(all - own, || {
            let (counts, starts) = self.counts(messages.iter().map(Vec::len))?;
            let mut got = vec![0i32; self.num_ranks()];
            self.world.all_to_all_into(&counts, &mut got);
            let (got, got_starts) = self.counts(got.iter().map(|&c| c as usize))?;
            let mut bytes = room(&got);
            let mut sent = Vec::with_capacity(all + 1);
            messages.iter().for_each(|m| sent.extend_from_slice(m));
            self.world.all_to_all_varcount_into(
                &Partition::new(&sent, counts, starts),
                &mut PartitionMut::new(&mut bytes, &got[..], got_starts),
            );
            Ok(parts(&bytes, &got))
        })
    }

    fn all_gather(&self, message: &[u8]) -> Result<Vec<Vec<u8>>> {
        self.counted(message.len() * (self.num_ranks() - 1), || {
            let mut got = vec![0i32; self.num_ranks()];
            let (own, _) = self.counts(std::iter::once(message.len()))?;
            self.world.all_gather_into(&own[..], &mut got[..]);
            let (got, starts) = self.counts(got.iter().map(|&c| c as usize))?;
            let mut bytes = room(&got);
            // See `room`.
            let message = if message.is_empty() { &[0][..0] } else { message };
            self.world.all_gather_varcount_into(message, &mut PartitionMut::new(&mut bytes, &got[..], starts));
            Ok(parts(&bytes, &got))
        })
    }

    fn min(&self, number: f64) -> Result<f64> {
        self.reduced(number, SystemOperation::min())
    }

    fn max(&self, number: f64) -> Result<f64> {
        self.reduced(number, SystemOperation::max())
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}

impl MpiComm {
    fn reduced(&self, number: f64, operation: SystemOperation) -> Result<f64> {
        self.counted(size_of::<f64>() * (self.num_ranks() - 1), || {
            let mut out = 0.0f64;
            self.world.all_reduce_into(&number, &mut out, operation);
            Ok(out)
        })
    }
}
