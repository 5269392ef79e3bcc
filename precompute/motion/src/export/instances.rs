//! The clip that plays on each of many characters, for programs that draw a crowd as instances of one figure with a set of
//! clips.

use super::{npz::NpzWriter, scratch::TrackScratch};
use std::io::{self, Write};
use std::path::Path;

/// Tracks: the clip, the time in it, and the place of the figure.
const WIDTHS: [usize; 3] = [1, 1, 3];

/// One character at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrowdInstance {
    /// Number of the clip; none where no clip plays.
    pub clip: Option<u32>,
    /// Time in the clip (s).
    pub time_s: f32,
    /// Place of the figure that plays the clip: x, z, and the heading by which it is turned about +Y before (m, m, rad).
    pub place: [f32; 3],
}

/// Instances over time, kept in a file.
pub struct InstanceRecording {
    rate_hz: f64,
    clips: Vec<String>,
    characters: Vec<usize>,
    scratch: TrackScratch,
}

impl InstanceRecording {
    /// - `folder`: folder of the file, which has no name and is removed with the program.
    /// - `clips`: names; `characters`: numbers.
    ///
    /// # Errors
    /// Errors of a folder that takes no file.
    pub fn new(folder: &Path, clips: Vec<String>, characters: Vec<usize>, rate_hz: f64) -> io::Result<Self> {
        let scratch = TrackScratch::new(folder, characters.len(), &WIDTHS, characters.len())?;
        Ok(Self { rate_hz, clips, characters, scratch })
    }

    /// Adds a frame of a character, by its index in the list of characters.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn push(&mut self, character: usize, instance: CrowdInstance) -> io::Result<()> {
        let clip = instance.clip.map_or(-1.0, |c| c as f32);
        let [x, z, heading] = instance.place;
        self.scratch.push(character, &[clip, instance.time_s, x, z, heading])
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn finish(&mut self) -> io::Result<()> {
        (0..self.characters.len()).try_for_each(|c| self.scratch.finish(c))
    }

    /// Number of frames of each character.
    pub fn num_frames(&self) -> usize {
        if self.characters.is_empty() { 0 } else { self.scratch.num_frames(0) }
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.characters.len()
    }

    /// Frames a second (Hz).
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Writes NumPy arrays: `clip` (characters, frames; -1 for none), `time_s` (characters, frames), `place` (characters,
    /// frames, 3; x, z, heading), `clips`, `characters` and `fps`.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn npz(&self, out: &mut dyn Write) -> io::Result<()> {
        let (n, frames) = (self.characters.len(), self.num_frames());
        let mut arrays = NpzWriter::new(out);
        arrays.number("fps", self.rate_hz)?;
        let numbers: Vec<i64> = self.characters.iter().map(|c| *c as i64).collect();
        arrays.whole("characters", &[n], &numbers)?;
        let clips: Vec<&str> = self.clips.iter().map(String::as_str).collect();
        arrays.words("clips", &[clips.len()], &clips)?;
        arrays.begin("clip", "<i4", &[n, frames])?;
        for c in 0..n {
            self.scratch
                .track(c, 0, |clips| clips.iter().try_for_each(|clip| arrays.write(&(*clip as i32).to_le_bytes())))?;
        }
        arrays.begin("time_s", "<f4", &[n, frames])?;
        (0..n).try_for_each(|c| self.scratch.track(c, 1, |times| arrays.write(bytemuck::cast_slice(times))))?;
        arrays.begin("place", "<f4", &[n, frames, 3])?;
        (0..n).try_for_each(|c| self.scratch.track(c, 2, |places| arrays.write(bytemuck::cast_slice(places))))?;
        arrays.finish()
    }
}
