//! Communication between several processes, or between threads in their place, that work on one task.

use crate::{Error, Result, clock::process_cpu_s};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::{cell::Cell, panic::resume_unwind, time::Instant};

/// Link of one of several processes, a rank, to the others: it exchanges messages, by any transport.
///
/// All ranks make the same calls in the same order. Results never depend on their speed.
pub trait Comm {
    /// Number of this rank (< [`Comm::num_ranks`]).
    fn rank(&self) -> usize;

    /// Number of ranks (> 0).
    fn num_ranks(&self) -> usize;

    /// Sends a message to each rank, and returns what each sent to this one.
    ///
    /// - `messages`: one for each rank, itself among them; an empty one costs next to nothing.
    ///
    /// # Errors
    /// [`Error::Rank`] where one of them has ended.
    fn exchange(&self, messages: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>>;

    /// Sends one message to all ranks, and returns that of each, in the order of ranks.
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    fn all_gather(&self, message: &[u8]) -> Result<Vec<Vec<u8>>> {
        self.exchange(vec![message.to_vec(); self.num_ranks()])
    }

    /// Bytes that this rank has sent to others so far, and the time for which it waited for them.
    fn traffic(&self) -> Traffic;

    /// CPU time of this rank so far, without waiting for others (s); `None` where it cannot be separated from that of other ranks,
    /// or where the system does not report it.
    fn cpu_s(&self) -> Option<f64> {
        None
    }

    /// The numbers of all ranks, in their order.
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    fn all_numbers(&self, number: f64) -> Result<Vec<f64>> {
        let all = self.all_gather(&number.to_le_bytes())?;
        let number = |(rank, bytes): (usize, Vec<u8>)| {
            bytes.try_into().map(f64::from_le_bytes).map_err(|_| unexpected_message(rank))
        };
        all.into_iter().enumerate().map(number).collect()
    }

    /// The least number of all ranks.
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    fn min(&self, number: f64) -> Result<f64> {
        Ok(self.all_numbers(number)?.into_iter().fold(f64::INFINITY, f64::min))
    }

    /// The largest number of all ranks.
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    fn max(&self, number: f64) -> Result<f64> {
        Ok(self.all_numbers(number)?.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// The sum of a count of all ranks (exact below 2^53).
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    fn sum(&self, count: u64) -> Result<u64> {
        Ok(self.all_numbers(count as f64)?.into_iter().map(|c| c as u64).sum())
    }

    /// Waits until all ranks have called this.
    ///
    /// # Errors
    /// As [`Comm::exchange`].
    fn barrier(&self) -> Result<()> {
        self.all_gather(&[]).map(drop)
    }

    /// Range of this rank among `count` items: ranges of all ranks follow each other, and their lengths differ by at most one.
    fn own_range(&self, count: usize) -> std::ops::Range<usize> {
        rank_range(count, self.rank(), self.num_ranks())
    }
}

/// Bytes that a rank has sent, and the time for which it waited.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Bytes of messages to others; what a rank sends to itself is not moved.
    pub bytes_moved: u64,
    /// Time spent in calls of [`Comm`], including that of moving messages (s).
    pub waited_s: f64,
}

/// Range of one rank among `count` items, see [`Comm::own_range`].
pub fn rank_range(count: usize, rank: usize, num_ranks: usize) -> std::ops::Range<usize> {
    let begin = |rank: usize| (count as u128 * rank as u128 / num_ranks as u128) as usize;
    begin(rank)..begin(rank + 1)
}

/// Error for a message of another kind than this rank expected.
pub fn unexpected_message(rank: usize) -> Error {
    let why = "sent another message than was expected; start all ranks with the same program and words";
    Error::Rank { rank, why: why.into() }
}

/// Ranks that are threads of one process, for tests of distributed algorithms and for runs without other processes.
#[derive(Debug)]
pub struct LocalComm {
    rank: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
    traffic: Cell<Traffic>,
}

impl LocalComm {
    /// Connected ends of `num_ranks` ranks (> 0), in their order.
    pub fn connect_all(num_ranks: usize) -> Vec<Self> {
        let end = |rank| Self { rank, to: Vec::new(), from: Vec::new(), traffic: Cell::default() };
        let mut ends: Vec<Self> = (0..num_ranks).map(end).collect();
        for sender in 0..num_ranks {
            for receiver in 0..num_ranks {
                let (to, from) = channel();
                ends[sender].to.push(to);
                ends[receiver].from.push(from);
            }
        }
        ends
    }

    /// Runs `work` as each of `num_ranks` ranks, each on a thread of its own; returns their results in the order of ranks.
    ///
    /// # Panics
    /// Where `work` does.
    pub fn run<T: Send>(num_ranks: usize, work: impl Fn(&Self) -> T + Sync) -> Vec<T> {
        std::thread::scope(|scope| {
            let work = &work;
            // An end is dropped with its thread, so that no rank waits for one that has ended.
            let threads: Vec<_> =
                Self::connect_all(num_ranks).into_iter().map(|end| scope.spawn(move || work(&end))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic))).collect()
        })
    }
}

impl Comm for LocalComm {
    fn rank(&self) -> usize {
        self.rank
    }

    fn num_ranks(&self) -> usize {
        self.to.len()
    }

    fn exchange(&self, messages: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        let (begin, mut traffic) = (Instant::now(), self.traffic.get());
        let gone = |rank| Error::Rank { rank, why: "has ended".into() };
        for (rank, message) in messages.into_iter().enumerate() {
            if rank != self.rank {
                traffic.bytes_moved += message.len() as u64;
            }
            self.to[rank].send(message).map_err(|_| gone(rank))?;
        }
        let got = self.from.iter().enumerate().map(|(rank, from)| from.recv().map_err(|_| gone(rank))).collect();
        traffic.waited_s += begin.elapsed().as_secs_f64();
        self.traffic.set(traffic);
        got
    }

    fn traffic(&self) -> Traffic {
        self.traffic.get()
    }
}

/// Single rank of a run without others: nothing is sent.
#[derive(Clone, Copy, Debug, Default)]
pub struct SingleRank;

impl Comm for SingleRank {
    fn rank(&self) -> usize {
        0
    }

    fn num_ranks(&self) -> usize {
        1
    }

    fn exchange(&self, messages: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>> {
        Ok(messages)
    }

    fn traffic(&self) -> Traffic {
        Traffic::default()
    }

    fn cpu_s(&self) -> Option<f64> {
        process_cpu_s()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_reach_whom_they_are_for() {
        let got = LocalComm::run(3, |comm| {
            let me = comm.rank() as u8;
            let got = comm.exchange((0..3).map(|to| vec![me, to]).collect()).unwrap();
            (
                got,
                comm.max(f64::from(me)).unwrap(),
                comm.min(f64::from(me)).unwrap(),
                comm.sum(2).unwrap(),
                comm.traffic().bytes_moved,
            )
        });
        for (rank, (got, max, min, sum, bytes)) in (0u8..).zip(got) {
            assert_eq!(got, [[0, rank], [1, rank], [2, rank]].map(Vec::from));
            assert_eq!((max, min, sum), (2.0, 0.0, 6));
            assert_eq!(bytes, 2 * 2 + 3 * 2 * 8, "what stays is not moved");
        }
    }

    #[test]
    fn rank_that_ends_ends_all() {
        let got = LocalComm::run(3, |comm| match comm.rank() {
            1 => Ok(()),
            _ => comm.barrier().and_then(|()| comm.barrier()),
        });
        assert!(got[1].is_ok());
        for rank in [0, 2] {
            assert!(matches!(got[rank], Err(Error::Rank { .. })), "{:?}", got[rank]);
        }
    }

    #[test]
    fn shares_follow_each_other() {
        for (count, num_ranks) in [(0, 1), (1, 3), (10, 3), (7, 8), (usize::MAX, 5)] {
            let mut next = 0;
            for rank in 0..num_ranks {
                let part = rank_range(count, rank, num_ranks);
                assert_eq!(part.start, next);
                assert!(part.len() >= count / num_ranks && part.len() <= count / num_ranks + 1);
                next = part.end;
            }
            assert_eq!(next, count);
        }
    }
}
