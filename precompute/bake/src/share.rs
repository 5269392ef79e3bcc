//! Work that several processes share: each does a part, and all have the whole.

use bytemuck::Pod;
use serde::{Serialize, de::DeserializeOwned};
use throng_base::{Comm, out_of_step, share};
use throng_motion::error::BuildError;

/// What is made of each of `count` things, in their order. Of N ranks each makes every N-th thing, as those that cost much
/// often lie together.
///
/// - `work`: makes what it is given the numbers of.
///
/// # Errors
/// Those of `work`; [`throng_base::Error::Rank`].
pub(crate) fn dealt<T: Serialize + DeserializeOwned>(
    comm: &dyn Comm,
    count: usize,
    work: impl FnOnce(Vec<usize>) -> Result<Vec<T>, BuildError>,
) -> Result<Vec<T>, BuildError> {
    let (rank, num_ranks) = (comm.rank(), comm.num_ranks());
    let own = work((rank..count).step_by(num_ranks).collect())?;
    if num_ranks == 1 {
        return Ok(own);
    }
    let config = bincode::config::standard().with_fixed_int_encoding();
    let message = bincode::serde::encode_to_vec(&own, config).map_err(|e| BuildError::Format(e.to_string()))?;
    drop(own);
    let mut hands = Vec::with_capacity(num_ranks);
    for (rank, bytes) in comm.all_gather(&message)?.into_iter().enumerate() {
        let hand: Vec<T> = match bincode::serde::decode_from_slice(&bytes, config) {
            Ok((hand, _)) => hand,
            Err(_) => return Err(out_of_step(rank).into()),
        };
        hands.push(hand.into_iter());
    }
    let all: Vec<T> = (0..count).map_while(|n| hands[n % num_ranks].next()).collect();
    if all.len() == count { Ok(all) } else { Err(out_of_step(rank).into()) }
}

/// Makes what each rank has of the next numbers the numbers of all.
///
/// - `own`: rows of this rank: those of its [`Comm::share`] of all rows. What they were before is lost.
/// - `row`: numbers of a row.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn joined<T: Pod>(
    comm: &dyn Comm,
    row: usize,
    own: &mut Vec<T>,
    all: &mut Vec<T>,
) -> Result<(), BuildError> {
    if comm.num_ranks() == 1 {
        std::mem::swap(own, all);
        return Ok(());
    }
    let num_rows = all.len() / row.max(1);
    for (rank, bytes) in comm.all_gather(bytemuck::cast_slice(own))?.iter().enumerate() {
        let rows = share(num_rows, rank, comm.num_ranks());
        let to: &mut [u8] = bytemuck::cast_slice_mut(&mut all[rows.start * row..rows.end * row]);
        if to.len() != bytes.len() {
            return Err(out_of_step(rank).into());
        }
        to.copy_from_slice(bytes);
    }
    Ok(())
}

/// True where something holds in all ranks.
///
/// # Errors
/// [`throng_base::Error::Rank`].
pub(crate) fn is_so_for_all(comm: &dyn Comm, is_so: bool) -> Result<bool, BuildError> {
    if comm.num_ranks() == 1 {
        return Ok(is_so);
    }
    Ok(comm.min(f64::from(u8::from(is_so)))? == 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_base::LocalComm;

    #[test]
    fn everybody_has_what_all_have_made() {
        for (num_ranks, count) in [(1, 5), (2, 5), (3, 0), (4, 3), (5, 100)] {
            let got = LocalComm::run(num_ranks, |comm| {
                let squares = dealt(comm, count, |own| Ok(own.into_iter().map(|n| (n * n) as u64).collect())).unwrap();
                let mut own: Vec<u32> = comm.share(count).flat_map(|n| [n as u32, 7]).collect();
                let mut all = vec![0u32; 2 * count];
                joined(comm, 2, &mut own, &mut all).unwrap();
                (squares, all, is_so_for_all(comm, comm.rank() > 0).unwrap(), is_so_for_all(comm, true).unwrap())
            });
            for (squares, all, some, every) in got {
                assert_eq!(squares, (0..count as u64).map(|n| n * n).collect::<Vec<_>>());
                assert_eq!(all, (0..count as u32).flat_map(|n| [n, 7]).collect::<Vec<_>>());
                assert!(!some && every);
            }
        }
    }
}
