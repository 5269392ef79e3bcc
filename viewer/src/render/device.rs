//! The device to ask an adapter for.

use super::{RenderError, Result};
use std::time::Duration;
use wgpu::{Buffer, BufferUsages, Device, DeviceDescriptor, Limits};

/// The device that draws, and its queue.
pub(super) struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
}

/// Longest time for drawing a frame; a longer one counts as a hang.
const WAIT: Duration = Duration::from_secs(120);

/// A device for the view and for egui: the limits that WebGPU promises, less where the adapter falls short of them, and
/// as much memory for crowds and pictures as it has.
///
/// egui itself asks OpenGL for no more than WebGL has, which has no storage buffers for [`super::SceneRenderer`].
pub fn device_descriptor(adapter: &wgpu::Adapter) -> DeviceDescriptor<'static> {
    DeviceDescriptor { label: Some("viewer"), required_limits: limits(&adapter.limits()), ..Default::default() }
}

fn limits(offered: &Limits) -> Limits {
    Limits {
        max_texture_dimension_2d: offered.max_texture_dimension_2d,
        max_buffer_size: offered.max_buffer_size,
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
        ..Limits::default().or_worse_values_from(offered)
    }
}

/// Waits until all that was submitted is done.
///
/// # Errors
/// The device is lost, or takes longer than two minutes.
pub fn wait(device: &wgpu::Device) -> Result<(), wgpu::PollError> {
    device.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(WAIT) }).map(|_| ())
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_is_asked_for_than_the_adapter_has() {
        let large = Limits { max_texture_dimension_2d: 32768, max_buffer_size: 1 << 40, ..Limits::default() };
        let without = Limits::downlevel_webgl2_defaults();
        for offered in [Limits::default(), Limits::downlevel_defaults(), without.clone(), large] {
            assert!(limits(&offered).check_limits(&offered), "{offered:?}");
            assert_eq!(limits(&offered).max_texture_dimension_2d, offered.max_texture_dimension_2d);
            assert_eq!(limits(&offered).max_buffer_size, offered.max_buffer_size);
        }
        assert_eq!(limits(&without).max_storage_buffers_per_shader_stage, 0);
        assert!(limits(&Limits::downlevel_defaults()).max_storage_buffers_per_shader_stage >= 2);
    }
}
