//! Finds a graphics adapter.

use super::HeadlessError;
use crate::args::AdapterChoice;
use crate::render::device_descriptor;
use eframe::egui_wgpu::{RenderState, RendererOptions, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew, wgpu};
use std::sync::Arc;
use wgpu::{Backend, DeviceType};

/// Opens a graphics adapter without a window.
pub(super) fn open(choice: AdapterChoice) -> Result<RenderState, HeadlessError> {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.native_adapter_selector = Some(Arc::new(move |adapters, _| {
        let best = adapters.iter().min_by_key(|a| rank(choice, &a.get_info()));
        best.cloned().ok_or_else(|| "the system has none".to_owned())
    }));
    setup.device_descriptor = Arc::new(device_descriptor);
    let setup = WgpuSetup::CreateNew(setup);
    let instance = pollster::block_on(setup.new_instance());
    let config = WgpuConfiguration { wgpu_setup: setup, ..WgpuConfiguration::default() };
    let state = pollster::block_on(RenderState::create(&config, &instance, None, RendererOptions::PREDICTABLE));
    state.map_err(|e| HeadlessError::NoAdapter { reason: e.to_string() })
}

/// The lower, the better: first the kind of adapter, then the interface to it.
fn rank(choice: AdapterChoice, info: &wgpu::AdapterInfo) -> (u8, u8) {
    let by_speed = match info.device_type {
        DeviceType::DiscreteGpu => 1,
        DeviceType::IntegratedGpu => 2,
        DeviceType::VirtualGpu | DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    };
    let kind = match (choice, info.device_type) {
        (AdapterChoice::Software, DeviceType::Cpu) => 0,
        _ => by_speed,
    };
    let backend = match info.backend {
        Backend::Vulkan | Backend::Metal | Backend::Dx12 => 0,
        Backend::Gl => 1,
        Backend::BrowserWebGpu | Backend::Noop => 2,
    };
    // A backend that draws nothing is the last resort, whatever its device.
    if backend == 2 { (5, backend) } else { (kind, backend) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(device_type: DeviceType, backend: Backend) -> wgpu::AdapterInfo {
        wgpu::AdapterInfo::new(device_type, backend)
    }

    #[test]
    fn software_comes_first_where_pictures_are_to_be_alike() {
        let lavapipe = info(DeviceType::Cpu, Backend::Vulkan);
        let llvmpipe = info(DeviceType::Cpu, Backend::Gl);
        let card = info(DeviceType::DiscreteGpu, Backend::Vulkan);
        let none = info(DeviceType::Cpu, Backend::Noop);
        let order = |choice, all: [&wgpu::AdapterInfo; 4]| {
            let mut ranks = all.map(|i| rank(choice, i));
            let given = ranks;
            ranks.sort();
            given == ranks
        };
        assert!(order(AdapterChoice::Software, [&lavapipe, &llvmpipe, &card, &none]));
        assert!(order(AdapterChoice::Any, [&card, &lavapipe, &llvmpipe, &none]));
    }
}
