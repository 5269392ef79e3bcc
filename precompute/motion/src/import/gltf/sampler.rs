//! Keys of glTF animations, and their interpolation.

use super::accessor::AccessorReader;
use super::document::{GltfSampler, Interpolation};
use crate::error::ensure;
use glam::{DQuat, DVec3, DVec4};
use std::{collections::BTreeMap, rc::Rc};

/// Bound of the times of keys (s).
const MAX_TIME_S: f64 = 1e6;
/// Distance from a key within which a time is the key's: times have single precision (s).
const NEAR_S: f64 = 5e-5;

/// Reader of samplers. Samplers that share accessors share their numbers.
pub struct Samplers<'a> {
    reader: &'a AccessorReader<'a>,
    times: BTreeMap<usize, Rc<[f64]>>,
    values: BTreeMap<usize, Rc<[f32]>>,
    /// Number of numbers that may still be read.
    left: usize,
}

/// Values at times.
pub struct Keys {
    times: Rc<[f64]>,
    values: Rc<[f32]>,
    /// Numbers of a value.
    width: usize,
    interpolation: Interpolation,
}

impl<'a> Samplers<'a> {
    /// - `num_bytes`: length of the file and its buffers; accessors may share bytes, so numbers are counted.
    pub fn new(reader: &'a AccessorReader<'a>, num_bytes: usize) -> Self {
        let left = num_bytes.saturating_add(1 << 20);
        Self { reader, times: BTreeMap::new(), values: BTreeMap::new(), left }
    }

    /// The keys of a sampler of rotations or of vectors.
    pub fn keys(&mut self, sampler: &GltfSampler, rotation: bool) -> Result<Keys, String> {
        let (kind, width) = if rotation { ("VEC4", 4) } else { ("VEC3", 3) };
        let times = match self.times.get(&sampler.input) {
            Some(times) => times.clone(),
            None => {
                self.take_numbers(sampler.input, 1)?;
                let times = seconds(&self.reader.floats(sampler.input, "SCALAR")?);
                let times: Rc<[f64]> = times.map_err(|e| format!("accessors[{}]: {e}", sampler.input))?.into();
                self.times.insert(sampler.input, times.clone());
                times
            }
        };
        let values = match self.values.get(&sampler.output) {
            Some(values) => values.clone(),
            None => {
                self.take_numbers(sampler.output, width)?;
                let values: Rc<[f32]> = self.reader.floats(sampler.output, kind)?.into();
                self.values.insert(sampler.output, values.clone());
                values
            }
        };
        let each = if sampler.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if values.len() != times.len() * each * width {
            let expected = times.len() * each;
            return Err(format!("expected {expected} values as {kind} for {} keys, found others", times.len()));
        }
        Ok(Keys { times, values, width, interpolation: sampler.interpolation })
    }

    fn take_numbers(&mut self, accessor: usize, width: usize) -> Result<(), String> {
        let numbers = self.reader.count(accessor)?.checked_mul(width);
        let left = numbers.and_then(|n| self.left.checked_sub(n));
        self.left = left.ok_or_else(|| format!("accessors[{accessor}]: more numbers than its file can hold"))?;
        Ok(())
    }
}

fn seconds(times: &[f32]) -> Result<Vec<f64>, String> {
    let times: Vec<f64> = times.iter().map(|&t| f64::from(t)).collect();
    ensure(!times.is_empty(), || "expected times, found none".to_owned())?;
    if let Some(t) = times.iter().find(|t| t.is_nan() || t.abs() >= MAX_TIME_S) {
        return Err(format!("expected seconds below {MAX_TIME_S}, found {t}"));
    }
    match times.windows(2).find(|w| w[1] < w[0]) {
        Some(w) => Err(format!("expected times in order, found {} after {}", w[1], w[0])),
        None => Ok(times),
    }
}

impl Keys {
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    pub fn vector(&self, seconds: f64) -> DVec3 {
        self.sample(seconds, DVec4::truncate, DVec3::lerp)
    }

    pub fn rotation(&self, seconds: f64) -> DQuat {
        self.sample(seconds, |v| DQuat::from_vec4(v).normalize(), DQuat::slerp)
    }

    /// The value at a time, made of numbers by `value` and mixed by `mix` where keys are connected by straight lines.
    fn sample<V>(&self, seconds: f64, value: impl Fn(DVec4) -> V, mix: impl FnOnce(V, V, f64) -> V) -> V {
        let at = self.key_position(seconds);
        let of_key = |key: usize| value(self.number(key));
        match self.interpolation {
            _ if at.share == 0.0 => of_key(at.key),
            Interpolation::Step => of_key(at.key),
            Interpolation::Linear => mix(of_key(at.key), of_key(at.key + 1), at.share),
            Interpolation::CubicSpline => value(self.spline(&at)),
        }
    }

    /// The last key at or before a time, and the share of the way to the next one.
    fn key_position(&self, seconds: f64) -> KeyPosition {
        let after = self.times.partition_point(|&t| t <= seconds + NEAR_S);
        let key = after.saturating_sub(1);
        let span = self.times.get(after).map_or(0.0, |next| next - self.times[key]);
        let passed = seconds - self.times[key];
        let share = if passed <= NEAR_S || span <= 0.0 { 0.0 } else { (passed / span).min(1.0) };
        KeyPosition { key, share, span }
    }

    /// The value of a key.
    fn number(&self, key: usize) -> DVec4 {
        match self.interpolation {
            Interpolation::CubicSpline => self.vector_at(3 * key + 1),
            _ => self.vector_at(key),
        }
    }

    fn vector_at(&self, place: usize) -> DVec4 {
        let at = place * self.width;
        DVec4::from_array(std::array::from_fn(|k| if k < self.width { f64::from(self.values[at + k]) } else { 0.0 }))
    }

    /// Hermite's cubic between two keys: their values, and their tangents times the seconds between them.
    fn spline(&self, at: &KeyPosition) -> DVec4 {
        let (s, s2, s3) = (at.share, at.share.powi(2), at.share.powi(3));
        let [from, to] = [at.key, at.key + 1];
        let (leaving, arriving) = (self.vector_at(3 * from + 2) * at.span, self.vector_at(3 * to) * at.span);
        self.number(from) * (2.0 * s3 - 3.0 * s2 + 1.0)
            + leaving * (s3 - 2.0 * s2 + s)
            + self.number(to) * (3.0 * s2 - 2.0 * s3)
            + arriving * (s3 - s2)
    }
}

/// Position of a time among keys.
struct KeyPosition {
    key: usize,
    /// Share of the way to the next key (0 to less than 1).
    share: f64,
    /// Time from the key to the next one (s).
    span: f64,
}
