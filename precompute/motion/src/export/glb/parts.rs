//! A glTF document that is put together, and what its one buffer holds.

use super::{super::scratch::TrackScratch, super::take::Take};
use bytemuck::Pod;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Types of components, by their codes in glTF.
pub(crate) const FLOAT: u32 = 5126;
pub(crate) const UNSIGNED_BYTE: u32 = 5121;
pub(crate) const UNSIGNED_SHORT: u32 = 5123;
/// Target of a view that holds data of corners.
pub const VERTICES: u32 = 34962;
/// Target of a view that holds corners of triangles.
pub const INDICES: u32 = 34963;

/// A run of bytes in the buffer.
enum BufferPiece {
    Bytes(Vec<u8>),
    /// Times of the first frames.
    Times(usize),
    /// A track of an actor.
    Track(usize, usize),
    /// Presence of an actor, as a scale along three axes.
    Presence(usize, usize, f32),
}

/// A document and its buffer.
pub struct GlbParts {
    json: Value,
    pieces: Vec<BufferPiece>,
    num_bytes: u64,
    /// View of all numbers that move something.
    moving: Option<(usize, u64)>,
    /// Accessors of times, by number of frames.
    times: BTreeMap<usize, usize>,
}

impl GlbParts {
    /// Begins with a document, and the bytes of its buffer.
    pub fn new(mut json: Value, buffer: Vec<u8>) -> Self {
        let about = concat!("Throng ", env!("CARGO_PKG_VERSION"));
        json["asset"]["generator"] = about.into();
        let mut parts = Self { json, pieces: Vec::new(), num_bytes: 0, moving: None, times: BTreeMap::new() };
        if !buffer.is_empty() {
            parts.add(buffer.len() as u64, BufferPiece::Bytes(buffer));
        }
        parts
    }

    /// Adds to a list of the document; returns the place in it.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        if !self.json[list].is_array() {
            self.json[list] = json!([]);
        }
        match self.json[list].as_array_mut() {
            Some(list) => {
                list.push(value);
                list.len() - 1
            }
            None => 0,
        }
    }

    /// Sets a key of an entry of a list.
    pub fn set(&mut self, list: &str, place: usize, key: &str, value: Value) {
        self.json[list][place][key] = value;
    }

    /// Adds a node to the roots of the scene.
    pub fn add_scene_root(&mut self, node: usize) {
        if let Some(roots) = self.json["scenes"][0]["nodes"].as_array_mut() {
            roots.push(node.into());
        }
    }

    /// Adds a piece to the buffer, which begins at a multiple of four; returns its position.
    fn add(&mut self, length: u64, piece: BufferPiece) -> u64 {
        let at = self.num_bytes;
        self.pieces.push(piece);
        self.num_bytes = at + length;
        let rest = (4 - self.num_bytes % 4) % 4;
        if rest > 0 {
            self.pieces.push(BufferPiece::Bytes(vec![0; rest as usize]));
            self.num_bytes += rest;
        }
        at
    }

    /// Adds numbers that do not change over time; returns their accessor.
    ///
    /// - `target`: purpose of the numbers, where they are vertices or indices.
    pub fn add_static<T: Pod>(&mut self, numbers: &[T], kind: u32, shape: &str, target: Option<u32>) -> usize {
        let (length, count) = (size_of_val(numbers), numbers.len());
        let at = self.add(length as u64, BufferPiece::Bytes(bytemuck::cast_slice(numbers).to_vec()));
        let mut view = json!({ "buffer": 0, "byteOffset": at, "byteLength": length });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        let view = self.push("bufferViews", view);
        self.push("accessors", json!({ "bufferView": view, "componentType": kind, "count": count, "type": shape }))
    }

    /// Sets the bounds of an accessor's numbers.
    pub fn set_bounds(&mut self, accessor: usize, min: &[f32], max: &[f32]) {
        self.json["accessors"][accessor]["min"] = json!(min);
        self.json["accessors"][accessor]["max"] = json!(max);
    }

    /// Adds an accessor of numbers that move something.
    fn add_moving(&mut self, length: u64, piece: BufferPiece, shape: &str, count: usize) -> usize {
        let at = self.add(length, piece);
        let (view, begin) = match self.moving {
            Some(known) => known,
            None => {
                let view = self.push("bufferViews", json!({ "buffer": 0, "byteOffset": at, "byteLength": 0 }));
                *self.moving.insert((view, at))
            }
        };
        self.json["bufferViews"][view]["byteLength"] = (self.num_bytes - begin).into();
        let accessor = json!({ "bufferView": view, "byteOffset": at - begin, "componentType": FLOAT, "count": count,
            "type": shape });
        self.push("accessors", accessor)
    }

    /// Adds the times of a number of frames (> 0).
    pub fn add_times(&mut self, frames: usize, rate_hz: f64) -> usize {
        if let Some(known) = self.times.get(&frames) {
            return *known;
        }
        let accessor = self.add_moving(4 * frames as u64, BufferPiece::Times(frames), "SCALAR", frames);
        self.set_bounds(accessor, &[0.0], &[time_s(frames - 1, rate_hz)]);
        self.times.insert(frames, accessor);
        accessor
    }

    /// Adds a track of an actor.
    pub fn add_track(&mut self, actor: usize, track: usize, width: usize, frames: usize) -> usize {
        let shape = if width == 4 { "VEC4" } else { "VEC3" };
        self.add_moving((4 * width * frames) as u64, BufferPiece::Track(actor, track), shape, frames)
    }

    /// Adds the scale of an actor who is absent now and then: 0 where it is absent.
    pub fn add_presence(&mut self, actor: usize, track: usize, scale: f32, frames: usize) -> usize {
        self.add_moving(12 * frames as u64, BufferPiece::Presence(actor, track, scale), "VEC3", frames)
    }

    /// Adds a sampler and a channel.
    pub fn add_channel(&self, animation: &mut Value, [times, values]: [usize; 2], node: usize, path: &str) {
        let interpolation = if path == "scale" { "STEP" } else { "LINEAR" };
        let sampler = json!({ "input": times, "output": values, "interpolation": interpolation });
        let Some(samplers) = animation["samplers"].as_array_mut() else { return };
        let place = samplers.len();
        samplers.push(sampler);
        let channel = json!({ "sampler": place, "target": { "node": node, "path": path } });
        animation["channels"].as_array_mut().into_iter().for_each(|c| c.push(channel.clone()));
    }

    /// Length of the buffer (bytes).
    pub fn num_bytes(&self) -> u64 {
        self.num_bytes
    }

    /// The document, padded to a multiple of four bytes.
    pub fn document(&self) -> String {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.num_bytes }]);
        let mut text = json.to_string();
        text.extend(std::iter::repeat_n(' ', (4 - text.len() % 4) % 4));
        text
    }

    /// Writes the buffer.
    ///
    /// - `scratch`: file that holds tracks; `take`: holds the presence of actors.
    pub fn write(&self, take: &Take, scratch: &TrackScratch, out: &mut dyn Write) -> io::Result<()> {
        for piece in &self.pieces {
            match piece {
                BufferPiece::Bytes(bytes) => out.write_all(bytes)?,
                BufferPiece::Times(frames) => {
                    (0..*frames).try_for_each(|f| out.write_all(&time_s(f, take.rate_hz()).to_le_bytes()))?;
                }
                BufferPiece::Track(actor, track) => {
                    scratch.track(*actor, *track, |n| out.write_all(bytemuck::cast_slice(n)))?;
                }
                BufferPiece::Presence(actor, track, scale) => take.scratch().track(*actor, *track, |n| {
                    n.iter().try_for_each(|v| out.write_all(bytemuck::cast_slice(&[v * scale; 3])))
                })?,
            }
        }
        Ok(())
    }
}

/// The time of a frame (s).
fn time_s(frame: usize, rate_hz: f64) -> f32 {
    (frame as f64 / rate_hz) as f32
}
