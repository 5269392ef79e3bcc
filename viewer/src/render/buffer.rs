//! GPU buffers that grow with their data.

use super::device::Gpu;
use super::{RenderError, Result};
use wgpu::{Buffer, BufferUsages, Device};

/// A buffer that is replaced by a larger one where data does not fit.
#[derive(Debug)]
pub(super) struct GrowingBuffer {
    /// The buffer of the moment.
    pub buffer: Buffer,
    usage: BufferUsages,
    what: &'static str,
}

impl GrowingBuffer {
    /// An empty buffer; `what` names its elements in errors.
    pub fn new(device: &Device, what: &'static str, usage: BufferUsages) -> Self {
        let usage = usage | BufferUsages::COPY_DST;
        Self { buffer: allocate(device, what, usage, 256), usage, what }
    }

    /// Makes room for `count` elements of `size` bytes; true where the buffer was replaced (its content is lost).
    ///
    /// # Errors
    /// [`RenderError::TooMany`] beyond what the device can hold or bind.
    pub fn reserve(&mut self, device: &Device, count: usize, size: usize) -> Result<bool> {
        let limits = device.limits();
        let is_bound = self.usage.contains(BufferUsages::STORAGE);
        let most_bound = if is_bound { limits.max_storage_buffer_binding_size } else { u64::MAX };
        let limit = limits.max_buffer_size.min(most_bound);
        let needed = (count as u64).saturating_mul(size as u64);
        if needed > limit {
            let most = limit / size.max(1) as u64;
            return Err(RenderError::TooMany { what: self.what, count, needed, limit, most });
        }
        if needed <= self.buffer.size() {
            return Ok(false);
        }
        let room = needed.checked_next_power_of_two().unwrap_or(limit).min(limit).max(256) & !3;
        self.buffer = allocate(device, self.what, self.usage, room.max(needed));
        Ok(true)
    }

    /// Replaces the content from the start; true where the buffer was replaced, so that bind groups must be.
    ///
    /// # Errors
    /// As [`Self::reserve`].
    pub fn write<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, data: &[T]) -> Result<bool> {
        let replaced = self.reserve(&gpu.device, data.len(), size_of::<T>())?;
        if !data.is_empty() {
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(data));
        }
        Ok(replaced)
    }
}

fn allocate(device: &Device, label: &str, usage: BufferUsages, size: u64) -> Buffer {
    device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}
