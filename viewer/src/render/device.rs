//! The device to ask an adapter for.

use std::time::Duration;
use wgpu::{DeviceDescriptor, Limits};

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
