//! Writes NumPy arrays in zip files, stored and not compressed: they can be mapped, since numbers begin at multiples of 64.

use super::take::{ActorPose, PRESENCE_TRACK, Take};
use crate::smpl::{JOINTS, UPRIGHT};
use glam::{Quat, Vec3};
use std::io::{self, Write};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS};
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipWriter};

/// Alignment of the numbers of an array in the file (bytes).
const ALIGNED: u16 = 64;
/// Numbers of a pose in AMASS files: those of hands, which do not turn, included.
const AMASS_WIDTH: usize = 156;
/// Numbers of a body's shape; all 0 is the mean body.
const SHAPE_WIDTH: usize = 16;

/// Writer of arrays, one after the other.
pub(super) struct NpzWriter<W: Write> {
    zip: ZipWriter<StreamWriter<W>>,
}

impl<W: Write> NpzWriter<W> {
    pub fn new(out: W) -> Self {
        Self { zip: ZipWriter::new_stream(out) }
    }

    /// Begins an array: `kind` is the type of its numbers as NumPy writes it.
    pub fn begin(&mut self, name: &str, kind: &str, shape: &[usize]) -> io::Result<()> {
        let list: String = shape.iter().map(|n| format!("{n}, ")).collect();
        let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({list}), }}");
        while !(10 + header.len() + 1).is_multiple_of(usize::from(ALIGNED)) {
            header.push(' ');
        }
        header.push('\n');
        let bytes = shape.iter().fold(8u64, |all, n| all.saturating_mul(*n as u64));
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(bytes >= u64::from(u32::MAX))
            .with_alignment(ALIGNED);
        self.zip.start_file(format!("{name}.npy"), options).map_err(io::Error::other)?;
        self.zip.write_all(b"\x93NUMPY\x01\x00")?;
        self.zip.write_all(&(header.len() as u16).to_le_bytes())?;
        self.zip.write_all(header.as_bytes())
    }

    fn floats(&mut self, name: &str, shape: &[usize], numbers: &[f32]) -> io::Result<()> {
        self.begin(name, "<f4", shape)?;
        self.zip.write_all(bytemuck::cast_slice(numbers))
    }

    pub fn whole(&mut self, name: &str, shape: &[usize], numbers: &[i64]) -> io::Result<()> {
        self.begin(name, "<i8", shape)?;
        self.zip.write_all(bytemuck::cast_slice(numbers))
    }

    pub fn number(&mut self, name: &str, number: f64) -> io::Result<()> {
        self.begin(name, "<f8", &[])?;
        self.zip.write_all(&number.to_le_bytes())
    }

    /// Words, as UTF-32 of equal length.
    pub fn words(&mut self, name: &str, shape: &[usize], words: &[&str]) -> io::Result<()> {
        let longest = words.iter().map(|w| w.chars().count()).max().unwrap_or(0).max(1);
        self.begin(name, &format!("<U{longest}"), shape)?;
        for word in words {
            let letters = word.chars().map(u32::from).chain(std::iter::repeat(0));
            letters.take(longest).try_for_each(|c| self.zip.write_all(&c.to_le_bytes()))?;
        }
        Ok(())
    }

    /// Adds numbers to the array that was begun last.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.zip.write_all(bytes)
    }

    pub fn finish(self) -> io::Result<()> {
        self.zip.finish().map_err(io::Error::other)?;
        Ok(())
    }
}

/// Writes all actors of a take: world positions, and rotations against the parent.
///
/// Arrays: `positions` (characters, frames, joints, 3; m), `rotations` (characters, frames, joints, 4; x, y, z, w; the
/// hips' in the world), `present` (characters, frames; 0 or 1), `characters`, `names`, `joints`, `parents`, `offsets`
/// (characters, joints, 3; m) and `fps`. Y is up. Clips shorter than the longest are filled with where they end, and are
/// not present there.
///
/// # Errors
/// Errors of `out`.
pub fn write_npz(take: &Take, out: &mut dyn Write) -> io::Result<()> {
    let (n, frames) = (take.actors().len(), take.longest());
    let mut arrays = NpzWriter::new(out);
    let names: Vec<&str> = take.actors().iter().map(|a| a.name.as_str()).collect();
    let numbers: Vec<i64> = take.actors().iter().map(|a| a.number as i64).collect();
    arrays.number("fps", take.rate_hz())?;
    arrays.whole("characters", &[n], &numbers)?;
    arrays.words("names", &[n], &names)?;
    arrays.words("joints", &[NUM_JOINTS], &Joint::ALL.map(Joint::name))?;
    let parents = Joint::ALL.map(|j| j.parent().map_or(-1, |p| p.index() as i64));
    arrays.whole("parents", &[NUM_JOINTS], &parents)?;
    let offsets: Vec<f32> = take.actors().iter().flat_map(|a| a.skeleton.offsets).flat_map(|o| o.to_array()).collect();
    arrays.floats("offsets", &[n, NUM_JOINTS, 3], &offsets)?;
    arrays.begin("present", "|u1", &[n, frames])?;
    for a in 0..n {
        take.scratch()
            .track(a, PRESENCE_TRACK, |there| there.iter().try_for_each(|t| arrays.write(&[u8::from(*t > 0.5)])))?;
        arrays.write(&vec![0; frames - take.num_frames(a)])?;
    }
    arrays.begin("positions", "<f4", &[n, frames, NUM_JOINTS, 3])?;
    write_rows(take, frames, |pose| {
        arrays.write(bytemuck::cast_slice(&pose.world_transforms().map(|(p, _)| p.to_array())))
    })?;
    arrays.begin("rotations", "<f4", &[n, frames, NUM_JOINTS, 4])?;
    write_rows(take, frames, |pose| arrays.write(bytemuck::cast_slice(&pose.rotations.map(|r| r.to_array()))))?;
    arrays.finish()
}

/// Passes the same number of poses of every actor to `row`.
fn write_rows(take: &Take, frames: usize, mut row: impl FnMut(&ActorPose) -> io::Result<()>) -> io::Result<()> {
    for (a, actor) in take.actors().iter().enumerate() {
        let mut last =
            ActorPose::from_rotations(&actor.skeleton, actor.skeleton.offsets[0], [Quat::IDENTITY; NUM_JOINTS]);
        take.poses(a, |_, pose, _| {
            last = *pose;
            row(pose)
        })?;
        (take.num_frames(a)..frames).try_for_each(|_| row(&last))?;
    }
    Ok(())
}

/// Writes one actor, while it is present, as AMASS has motion: SMPL's joints in SMPL's order, turns as axis times angle,
/// the pelvis in a world with Z up. Hands do not turn and the body is the mean one: turns are the actor's, lengths are not.
///
/// # Errors
/// Errors of `out`.
pub fn write_amass(take: &Take, actor: usize, out: &mut dyn Write) -> io::Result<()> {
    let there = take.actors()[actor].present_frames.clone();
    let mut arrays = NpzWriter::new(out);
    arrays.number("mocap_framerate", take.rate_hz())?;
    arrays.words("gender", &[], &["neutral"])?;
    arrays.floats("betas", &[SHAPE_WIDTH], &[0.0; SHAPE_WIDTH])?;
    let back = UPRIGHT.inverse().as_quat();
    arrays.begin("trans", "<f4", &[there.len(), 3])?;
    take.poses(actor, |frame, pose, _| {
        let offset: Vec3 = back * pose.translations[0];
        if there.contains(&frame) { arrays.write(bytemuck::cast_slice(&offset.to_array())) } else { Ok(()) }
    })?;
    arrays.begin("poses", "<f4", &[there.len(), AMASS_WIDTH])?;
    take.poses(actor, |frame, pose, _| {
        if !there.contains(&frame) {
            return Ok(());
        }
        let mut row = [0f32; AMASS_WIDTH];
        for (i, (_, role)) in JOINTS.iter().enumerate() {
            let turn = pose.rotations[role.index()];
            let turn = if i == 0 { maths::compose(back, turn) } else { turn };
            // The shorter way round.
            let turn = if turn.w < 0.0 { -turn } else { turn };
            row[3 * i..3 * i + 3].copy_from_slice(&turn.to_scaled_axis().to_array());
        }
        arrays.write(bytemuck::cast_slice(&row))
    })?;
    arrays.finish()
}
