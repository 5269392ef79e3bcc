//! Work shared by several processes: each does a part, and all get the whole.

use bytemuck::Pod;
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use throng_base::{Comm, error::ensure, rank_range, unexpected_message};
use throng_motion::{BuildError, Clip, ClipSet, Result};

/// Results for each of `count` items, in order. Of N ranks each handles every N-th item, as expensive ones are often
/// adjacent.
///
/// - `work`: makes the results of the items with given indices.
///
/// # Errors
/// Errors of `work`; [`throng_base::Error::Rank`].
pub(crate) fn run_dealt<T: Serialize + DeserializeOwned>(
    comm: &dyn Comm,
    count: usize,
    work: impl FnOnce(Vec<usize>) -> Result<Vec<T>>,
) -> Result<Vec<T>> {
    let own = work(own_numbers(comm, count))?;
    gather_owned(comm, own, (0..count).map(|n| n % comm.num_ranks()))
}

/// Gathers the results for all items, in order, from those of each rank.
fn gather_owned<T: Serialize + DeserializeOwned>(
    comm: &dyn Comm,
    own: Vec<T>,
    owners: impl ExactSizeIterator<Item = usize>,
) -> Result<Vec<T>> {
    if comm.num_ranks() == 1 {
        return Ok(own);
    }
    let config = bincode::config::standard().with_fixed_int_encoding();
    let message = bincode::serde::encode_to_vec(&own, config).map_err(|e| BuildError::Format(e.to_string()))?;
    drop(own);
    let read = |(rank, bytes): (usize, Vec<u8>)| match bincode::serde::decode_from_slice(&bytes, config) {
        Ok((hand, _)) => Ok(Vec::into_iter(hand)),
        Err(_) => Err(unexpected_message(rank)),
    };
    let mut hands = comm.all_gather(&message)?.into_iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
    let count = owners.len();
    let all: Vec<T> = owners.map_while(|rank| hands[rank].next()).collect();
    if all.len() == count { Ok(all) } else { Err(unexpected_message(comm.rank()).into()) }
}

/// Indices of this rank's items, of so many that are dealt out (see [`run_dealt`]).
pub(crate) fn own_numbers(comm: &dyn Comm, count: usize) -> Vec<usize> {
    (comm.rank()..count).step_by(comm.num_ranks()).collect()
}

/// True if a dealt item belongs to this rank.
pub(crate) fn is_own(comm: &dyn Comm, number: usize) -> bool {
    number % comm.num_ranks() == comm.rank()
}

/// Gathers rows of all dealt items, from each rank's own; see [`own_numbers`].
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn gather_rows<T: Pod>(comm: &dyn Comm, count: usize, own: Vec<Vec<T>>) -> Result<Vec<Vec<T>>> {
    let num_ranks = comm.num_ranks();
    if num_ranks == 1 {
        return Ok(own);
    }
    let lengths: Vec<u32> = own.iter().map(|row| row.len() as u32).collect();
    let lengths: Vec<Vec<u32>> = decode_messages(comm.all_gather(bytemuck::cast_slice(&lengths))?)?;
    let rows: Vec<Vec<T>> = decode_messages(comm.all_gather(bytemuck::cast_slice(&own.concat()))?)?;
    let mut rest: Vec<(&[u32], &[T])> = lengths.iter().zip(&rows).map(|(l, r)| (&l[..], &r[..])).collect();
    let mut next = |number: usize| {
        let (lengths, rows) = &mut rest[number % num_ranks];
        let (length, more) = lengths.split_first()?;
        let (row, rest) = rows.split_at_checked(*length as usize)?;
        (*lengths, *rows) = (more, rest);
        Some(row.to_vec())
    };
    let all: Vec<Vec<T>> = (0..count).map_while(&mut next).collect();
    if all.len() == count { Ok(all) } else { Err(unexpected_message(comm.rank()).into()) }
}

/// Gathers one value for each of `count` dealt items; see [`own_numbers`].
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn gather_each<T: Pod>(comm: &dyn Comm, count: usize, own: Vec<T>) -> Result<Vec<T>> {
    let num_ranks = comm.num_ranks();
    if num_ranks == 1 {
        return Ok(own);
    }
    let of_ranks: Vec<Vec<T>> = decode_messages(comm.all_gather(bytemuck::cast_slice(&own))?)?;
    let all: Vec<T> = (0..count).map_while(|n| of_ranks[n % num_ranks].get(n / num_ranks).copied()).collect();
    let sent: usize = of_ranks.iter().map(Vec::len).sum();
    if [all.len(), sent] == [count; 2] { Ok(all) } else { Err(unexpected_message(comm.rank()).into()) }
}

/// Gathers the values of all ranks, in the order of ranks.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn gather_all<T: Pod>(comm: &dyn Comm, own: Vec<T>) -> Result<Vec<T>> {
    match comm.num_ranks() {
        1 => Ok(own),
        _ => Ok(decode_messages(comm.all_gather(bytemuck::cast_slice(&own))?)?.concat()),
    }
}

/// Exchanges values: returns those that each rank has for this one, in the order of ranks.
///
/// - `to`: values for each rank.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn exchange_values<T: Pod>(comm: &dyn Comm, mut to: Vec<Vec<T>>) -> Result<Vec<T>> {
    if comm.num_ranks() == 1 {
        return Ok(to.pop().unwrap_or_default());
    }
    let messages = to.into_iter().map(|t| bytemuck::cast_slice(&t).to_vec()).collect();
    Ok(decode_messages(comm.exchange(messages)?)?.concat())
}

/// Decodes the messages of all ranks.
fn decode_messages<T: Pod>(messages: Vec<Vec<u8>>) -> Result<Vec<Vec<T>>> {
    let read = |(rank, bytes): (usize, Vec<u8>)| match bytes.len() % size_of::<T>() {
        0 => Ok(bytemuck::pod_collect_to_vec(&bytes)),
        _ => Err(unexpected_message(rank).into()),
    };
    messages.into_iter().enumerate().map(read).collect()
}

/// Rank with the poses of each clip (clips.len()), which is that of its original. Ranks have about equally many
/// originals, in order.
pub(crate) fn clip_owners(clips: &ClipSet, num_ranks: usize) -> Vec<usize> {
    let count = clips.clips.iter().filter(|c| !c.mirrored && !c.is_made()).count();
    let (mut originals, mut rank) = (0, 0);
    let of_clip = |clip: &Clip| {
        // All ranks make the same motion, after all clips; the last one packs it.
        if clip.is_made() {
            return num_ranks - 1;
        }
        originals += usize::from(!clip.mirrored);
        while rank + 1 < num_ranks && originals > rank_range(count, rank, num_ranks).end {
            rank += 1;
        }
        rank
    };
    clips.clips.iter().map(of_clip).collect()
}

/// Results for each of some items, in order, made by their owners and shared with all.
///
/// - `clip_owners`: rank of each item.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn sort_by_owner<T: Send + Serialize + DeserializeOwned>(
    comm: &dyn Comm,
    owners: &[usize],
    work: impl Fn(usize) -> T + Send + Sync,
) -> Result<Vec<T>> {
    let own: Vec<usize> = (0..owners.len()).filter(|&n| owners[n] == comm.rank()).collect();
    gather_owned(comm, own.into_par_iter().map(work).collect(), owners.iter().copied())
}

/// Most bytes that the first rank receives at once.
const MOST: usize = 256 << 20;

/// Concatenates the values of all ranks, in the order of ranks, on the first one; others get nothing.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn gather_to_first<T: Pod>(comm: &dyn Comm, own: Vec<T>) -> Result<Vec<T>> {
    if comm.num_ranks() == 1 {
        return Ok(own);
    }
    let lengths: Vec<usize> = comm.all_numbers(own.len() as f64)?.into_iter().map(|n| n as usize).collect();
    let (rank, part) = (comm.rank(), (MOST / comm.num_ranks() / size_of::<T>().max(1)).max(1));
    let mut all = vec![T::zeroed(); if rank == 0 { lengths.iter().sum() } else { 0 }];
    for begin in (0..lengths.iter().copied().max().unwrap_or(0)).step_by(part) {
        let of = |length: usize| begin.min(length)..(begin + part).min(length);
        let mut messages = vec![Vec::new(); lengths.len()];
        messages[0] = bytemuck::cast_slice(&own[of(own.len())]).to_vec();
        let mut at = 0;
        for (rank, bytes) in comm.exchange(messages)?.iter().enumerate().filter(|_| rank == 0) {
            let to = of(lengths[rank]);
            let to: &mut [u8] = bytemuck::cast_slice_mut(&mut all[at + to.start..at + to.end]);
            ensure(to.len() == bytes.len(), || unexpected_message(rank))?;
            to.copy_from_slice(bytes);
            at += lengths[rank];
        }
    }
    Ok(all)
}

/// Exchanges the rows of all ranks, so that each has all of them.
///
/// - `own_numbers`: rows of this rank: those of its share of all rows. Their previous values are lost.
/// - `row`: numbers of a row.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn share_rows<T: Pod>(comm: &dyn Comm, row: usize, own: &mut Vec<T>, all: &mut Vec<T>) -> Result<()> {
    if comm.num_ranks() == 1 {
        std::mem::swap(own, all);
        return Ok(());
    }
    let num_rows = all.len() / row.max(1);
    for (rank, bytes) in comm.all_gather(bytemuck::cast_slice(own))?.iter().enumerate() {
        let rows = rank_range(num_rows, rank, comm.num_ranks());
        let to: &mut [u8] = bytemuck::cast_slice_mut(&mut all[rows.start * row..rows.end * row]);
        ensure(to.len() == bytes.len(), || unexpected_message(rank))?;
        to.copy_from_slice(bytes);
    }
    Ok(())
}

/// True if a condition holds in all ranks.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn all_ranks_agree(comm: &dyn Comm, is_so: bool) -> Result<bool> {
    if comm.num_ranks() == 1 { Ok(is_so) } else { Ok(comm.min(f64::from(u8::from(is_so)))? == 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_base::LocalComm;

    #[test]
    fn mirrored_copies_are_where_their_originals_are() {
        let clip = |mirrored: bool| Clip { mirrored, ..Clip::new("c", 30.0, Vec::new(), Vec::new()) };
        let clips = [false, true].repeat(5).into_iter().map(clip).collect();
        let set = ClipSet { skeleton: throng_core::Skeleton::default(), clips };
        assert_eq!(clip_owners(&set, 1), [0; 10]);
        assert_eq!(clip_owners(&set, 2), [0, 0, 0, 0, 1, 1, 1, 1, 1, 1]);
        for num_ranks in [2, 3, 4, 5, 8] {
            let of_originals: Vec<usize> = clip_owners(&set, num_ranks).into_iter().step_by(2).collect();
            for (original, &rank) in of_originals.iter().enumerate() {
                assert!(rank_range(5, rank, num_ranks).contains(&original), "{num_ranks}: {of_originals:?}");
            }
        }
    }

    #[test]
    fn everybody_has_what_all_have_made() {
        for (num_ranks, count) in [(1, 5), (2, 5), (3, 0), (4, 3), (5, 100)] {
            let got = LocalComm::run(num_ranks, |comm| {
                let squares =
                    run_dealt(comm, count, |own| Ok(own.into_iter().map(|n| (n * n) as u64).collect())).unwrap();
                let mut rows: Vec<u32> = comm.own_range(count).flat_map(|n| [n as u32, 7]).collect();
                let mut all = vec![0u32; 2 * count];
                share_rows(comm, 2, &mut rows, &mut all).unwrap();
                let owners: Vec<usize> = (0..count).map(|n| n * n % num_ranks).collect();
                assert_eq!(sort_by_owner(comm, &owners, |n| n as u64).unwrap(), (0..count as u64).collect::<Vec<_>>());
                let own = own_numbers(comm, count);
                assert!(own.iter().all(|&n| is_own(comm, n)));
                assert_eq!(gather_each(comm, count, own.clone()).unwrap(), (0..count).collect::<Vec<_>>());
                let row = |n: usize| vec![n as u32; n % 3];
                let rows = gather_rows(comm, count, own.iter().map(|&n| row(n)).collect()).unwrap();
                assert_eq!(rows, (0..count).map(row).collect::<Vec<_>>());
                let mut gathered = gather_all(comm, own).unwrap();
                gathered.sort_unstable();
                assert_eq!(gathered, (0..count).collect::<Vec<_>>());
                let to = (0..num_ranks).map(|to| vec![[comm.rank(), to]; to]).collect();
                let wanted: Vec<_> = (0..num_ranks).flat_map(|from| vec![[from, comm.rank()]; comm.rank()]).collect();
                assert_eq!(exchange_values(comm, to).unwrap(), wanted);
                let parts = gather_to_first(comm, vec![comm.rank() as u16; 3 * comm.rank()]).unwrap();
                let wanted: Vec<u16> = (0..num_ranks as u16).flat_map(|r| vec![r; 3 * usize::from(r)]).collect();
                assert!(if comm.rank() == 0 { parts == wanted } else { num_ranks > 1 && parts.is_empty() });
                (squares, all, all_ranks_agree(comm, comm.rank() > 0).unwrap(), all_ranks_agree(comm, true).unwrap())
            });
            for (squares, all, some, every) in got {
                assert_eq!(squares, (0..count as u64).map(|n| n * n).collect::<Vec<_>>());
                assert_eq!(all, (0..count as u32).flat_map(|n| [n, 7]).collect::<Vec<_>>());
                assert!(!some && every);
            }
        }
    }
}
