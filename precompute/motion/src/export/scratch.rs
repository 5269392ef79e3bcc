//! Numbers over time that are kept in a file, not in memory: written frame by frame, read track by track.

use std::io::{self, Read, Seek, SeekFrom, Write};
use std::{fs::File, ops::Range, path::Path};

/// Memory that all actors together may take while they are recorded (bytes).
const BUDGET_BYTES: usize = 24 << 20;
/// Most frames of an actor that are written at once.
const MAX_BLOCK: usize = 256;

/// Tracks of several actors. A track is a run of numbers a frame; all actors have the same tracks.
pub struct TrackScratch {
    file: File,
    /// Position of the next block (bytes).
    end: u64,
    /// Offset of each track within a frame, and the total behind the last one (numbers, tracks + 1).
    starts: Vec<usize>,
    block_frames: usize,
    actors: Vec<Blocks>,
}

/// Data of an actor on the disk and in memory.
#[derive(Default)]
struct Blocks {
    /// Positions of its blocks (bytes).
    offsets: Vec<u64>,
    num_frames: usize,
    /// The last block, while it is not full: frame by frame.
    open: Vec<f32>,
}

impl TrackScratch {
    /// - `folder`: folder of the file, which has no name and is removed with the program.
    /// - `widths`: numbers a frame of each track.
    /// - `together`: number of actors that are recorded at the same time.
    ///
    /// # Errors
    /// Errors of a folder that takes no file.
    pub fn new(folder: &Path, actors: usize, widths: &[usize], together: usize) -> io::Result<Self> {
        let mut starts = vec![0];
        starts.extend(widths.iter().scan(0, |sum, w| {
            *sum += w;
            Some(*sum)
        }));
        let frame_bytes = size_of::<f32>() * starts[widths.len()] * together.max(1);
        let block_frames = (BUDGET_BYTES / frame_bytes.max(1)).clamp(1, MAX_BLOCK);
        let actors = (0..actors).map(|_| Blocks::default()).collect();
        Ok(Self { file: tempfile::tempfile_in(folder)?, end: 0, starts, block_frames, actors })
    }

    /// Adds a frame of an actor: the numbers of all its tracks (total width).
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn push(&mut self, actor: usize, numbers: &[f32]) -> io::Result<()> {
        let width = self.starts[self.starts.len() - 1];
        let blocks = &mut self.actors[actor];
        blocks.open.extend_from_slice(&numbers[..width]);
        blocks.num_frames += 1;
        if blocks.open.len() == width * self.block_frames { self.flush(actor) } else { Ok(()) }
    }

    /// Writes the rest of an actor and frees its memory: it gets no more frames.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn finish(&mut self, actor: usize) -> io::Result<()> {
        if !self.actors[actor].open.is_empty() {
            self.flush(actor)?;
        }
        self.actors[actor].open = Vec::new();
        Ok(())
    }

    /// Writes the open block, track by track.
    fn flush(&mut self, actor: usize) -> io::Result<()> {
        let width = self.starts[self.starts.len() - 1];
        let open = &self.actors[actor].open;
        let mut turned = Vec::with_capacity(open.len());
        for track in self.starts.windows(2) {
            open.chunks_exact(width).for_each(|frame| turned.extend_from_slice(&frame[track[0]..track[1]]));
        }
        let bytes: &[u8] = bytemuck::cast_slice(&turned);
        self.file.seek(SeekFrom::Start(self.end))?;
        self.file.write_all(bytes)?;
        let blocks = &mut self.actors[actor];
        blocks.offsets.push(self.end);
        blocks.open.clear();
        self.end += bytes.len() as u64;
        Ok(())
    }

    /// Number of actors.
    pub fn num_actors(&self) -> usize {
        self.actors.len()
    }

    /// Number of frames of an actor.
    pub fn num_frames(&self, actor: usize) -> usize {
        self.actors[actor].num_frames
    }

    /// Numbers a frame of a track.
    pub fn width(&self, track: usize) -> usize {
        self.starts[track + 1] - self.starts[track]
    }

    /// Frames of each block of an actor.
    fn blocks(&self, actor: usize) -> impl Iterator<Item = (u64, usize)> + '_ {
        let Blocks { offsets, num_frames, .. } = &self.actors[actor];
        let block = self.block_frames;
        offsets.iter().enumerate().map(move |(b, at)| (*at, block.min(num_frames - b * block)))
    }

    fn read(&self, at: u64, numbers: &mut [f32]) -> io::Result<()> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(bytemuck::cast_slice_mut(numbers))
    }

    /// Passes a track of an actor to `take`, some frames at a time.
    ///
    /// # Errors
    /// Errors of the disk, and of `take`.
    pub fn track(&self, actor: usize, track: usize, mut take: impl FnMut(&[f32]) -> io::Result<()>) -> io::Result<()> {
        let mut numbers = Vec::new();
        for (at, frames) in self.blocks(actor) {
            numbers.resize(frames * self.width(track), 0.0);
            self.read(at + (size_of::<f32>() * self.starts[track] * frames) as u64, &mut numbers)?;
            take(&numbers)?;
        }
        Ok(())
    }

    /// Passes every frame of an actor to `take`: its number, and the numbers of all tracks (total width).
    ///
    /// # Errors
    /// Errors of [`TrackScratch::track`].
    pub fn frames(&self, actor: usize, mut take: impl FnMut(usize, &[f32]) -> io::Result<()>) -> io::Result<()> {
        let width = self.starts[self.starts.len() - 1];
        let (mut turned, mut frame, mut number) = (Vec::new(), vec![0.0; width], 0);
        for (at, frames) in self.blocks(actor) {
            turned.resize(frames * width, 0.0);
            self.read(at, &mut turned)?;
            for f in 0..frames {
                for track in self.starts.windows(2) {
                    let Range { start, end } = track[0]..track[1];
                    let from = start * frames + f * (end - start);
                    frame[start..end].copy_from_slice(&turned[from..from + end - start]);
                }
                take(number, &frame)?;
                number += 1;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_and_frames_are_what_was_pushed() {
        let widths = [3, 1, 4];
        // So many at once that a block holds few frames.
        let together = BUDGET_BYTES / 32 / 7;
        let mut scratch = TrackScratch::new(&std::env::temp_dir(), 3, &widths, together).unwrap();
        assert_eq!(scratch.block_frames, 7);
        let number = |actor: usize, frame: usize, k: usize| (actor * 10_000 + frame * 10 + k) as f32;
        let lengths = [0, 21, 40];
        for frame in 0..40 {
            for actor in (0..3).filter(|a| frame < lengths[*a]) {
                let numbers: Vec<f32> = (0..8).map(|k| number(actor, frame, k)).collect();
                scratch.push(actor, &numbers).unwrap();
            }
        }
        for actor in 0..3 {
            scratch.finish(actor).unwrap();
            assert_eq!(scratch.num_frames(actor), lengths[actor]);
            let mut seen = 0;
            scratch
                .frames(actor, |frame, numbers| {
                    assert_eq!(frame, seen);
                    (0..8).for_each(|k| assert_eq!(numbers[k], number(actor, frame, k)));
                    seen += 1;
                    Ok(())
                })
                .unwrap();
            assert_eq!(seen, lengths[actor]);
            for (track, range) in [0..3, 3..4, 4..8].into_iter().enumerate() {
                let mut all = Vec::new();
                let mut take = |some: &[f32]| {
                    all.extend_from_slice(some);
                    Ok(())
                };
                scratch.track(actor, track, &mut take).unwrap();
                let expected = (0..lengths[actor]).flat_map(|f| range.clone().map(move |k| number(actor, f, k)));
                assert!(all.iter().copied().eq(expected), "actor {actor}, track {track}");
            }
        }
    }

    #[test]
    fn memory_does_not_grow_with_length() {
        let mut scratch = TrackScratch::new(&std::env::temp_dir(), 2, &[4, 3], 2).unwrap();
        let mut most = 0;
        for frame in 0..20 * MAX_BLOCK {
            scratch.push(frame % 2, &[frame as f32; 7]).unwrap();
            most = most.max(scratch.actors.iter().map(|a| a.open.capacity()).sum());
        }
        // A vector that grows has up to twice what it holds.
        assert!(most <= 2 * 2 * 7 * MAX_BLOCK, "{most} numbers are in memory");
        assert!(scratch.file.metadata().unwrap().len() >= (4 * 7 * 18 * MAX_BLOCK) as u64);
    }
}
