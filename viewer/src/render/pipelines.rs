//! Construction of render pipelines, each from a short description.

use wgpu::{
    BindGroup, BindGroupEntry, BindGroupLayout, BindingResource, BlendState, BufferBindingType, CompareFunction,
    Device, RenderPipeline, ShaderStages, TextureFormat, TextureViewDimension, VertexAttribute,
};

/// Colour format of the picture.
pub(super) const COLOUR: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// Depth format of the picture.
pub(super) const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Format of the shadow mask.
pub(super) const MASK: TextureFormat = TextureFormat::Rg8Unorm;
/// Samples of a pixel of the picture.
pub(super) const SAMPLES: u32 = 4;

/// Attributes of [`super::mesh::Vertex`] and, in a second buffer, the character's number.
const VERTEX: [VertexAttribute; 5] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32, 2 => Float32x3, 3 => Uint8x4, 4 => Unorm8x4];
/// Attributes of [`super::worn_mesh::WornVertex`], around the character's number.
const WORN: [VertexAttribute; 7] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Unorm8x4, 2 => Float32x3, 3 => Uint16x4, 4 => Unorm16x4, 6 => Float32x2, 7 => Uint32
];
const CHARACTER: [VertexAttribute; 1] = wgpu::vertex_attr_array![5 => Uint32];
const LINE: [VertexAttribute; 5] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Uint32, 4 => Unorm8x4];
const ROUND_CORNER: [VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32];
const ROUND: [VertexAttribute; 6] = wgpu::vertex_attr_array![
    2 => Float32x3, 3 => Float32, 4 => Float32x3, 5 => Float32, 6 => Uint32, 7 => Unorm8x4
];
const RING: [VertexAttribute; 5] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32, 3 => Uint32, 4 => Unorm8x4];

const SOLID_CORNER: [VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
const SOLID: [VertexAttribute; 3] = wgpu::vertex_attr_array![2 => Float32x3, 3 => Unorm8x4, 4 => Float32x4];

// Each attribute list above ends where its struct does.
const _: () = assert!(size_of::<super::mesh::Vertex>() == 36);
const _: () = assert!(size_of::<super::worn_mesh::WornVertex>() == 56);
const _: () = assert!(size_of::<super::shapes::LineInstance>() == 36);
const _: () = assert!(size_of::<super::shapes::RoundInstance>() == 40);
const _: () = assert!(size_of::<super::shapes::RingInstance>() == 28);
const _: () = assert!(size_of::<super::solids::SolidVertex>() == 24);
const _: () = assert!(size_of::<super::solid_draws::GpuSolid>() == 32);

/// The vertex buffers a pipeline reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PipelineInput {
    /// No buffer: corners come from their number.
    Nothing,
    /// A body, and one character number an instance.
    Body,
    /// A mesh of the user's own, and one character number an instance.
    Worn,
    /// One line an instance.
    Lines,
    /// The corners of a round cone, and one an instance.
    Rounds,
    /// One ring an instance.
    Rings,
    /// The corners of a thing, and one an instance.
    Solids,
}

impl PipelineInput {
    fn buffers(self) -> Vec<Option<wgpu::VertexBufferLayout<'static>>> {
        let layout = |attributes: &'static [VertexAttribute], step_mode| {
            let array_stride = attributes.iter().map(|a| a.format.size()).sum();
            Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
        };
        let (vertex, instance) = (wgpu::VertexStepMode::Vertex, wgpu::VertexStepMode::Instance);
        match self {
            Self::Nothing => Vec::new(),
            Self::Body => vec![layout(&VERTEX, vertex), layout(&CHARACTER, instance)],
            Self::Worn => vec![layout(&WORN, vertex), layout(&CHARACTER, instance)],
            Self::Lines => vec![layout(&LINE, instance)],
            Self::Rounds => vec![layout(&ROUND_CORNER, vertex), layout(&ROUND, instance)],
            Self::Rings => vec![layout(&RING, instance)],
            Self::Solids => vec![layout(&SOLID_CORNER, vertex), layout(&SOLID, instance)],
        }
    }
}

/// Target of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PipelineOutput {
    /// The picture: with blending and depth.
    Picture {
        /// Blending; `None` replaces.
        blend: Option<BlendState>,
        /// Whether depth is written.
        hides: bool,
        /// Which depths pass.
        compare: CompareFunction,
    },
    /// The shadow mask, blended by maximum.
    Mask,
    /// A pass of egui: one sample, no depth.
    Window(TextureFormat),
}

impl PipelineOutput {
    /// Opaque things.
    pub const SOLID: Self = Self::Picture { blend: None, hides: true, compare: CompareFunction::Greater };
    /// Bodies one can see through: of each only the nearest surface.
    pub const GHOST: Self =
        Self::Picture { blend: Some(BlendState::ALPHA_BLENDING), hides: true, compare: CompareFunction::Greater };
    /// Flat shapes drawn onto others.
    pub const OVERLAY: Self =
        Self::Picture { blend: Some(BlendState::ALPHA_BLENDING), hides: false, compare: CompareFunction::Greater };
    /// Background, visible only where nothing else is drawn.
    pub const BACKDROP: Self = Self::Picture { blend: None, hides: false, compare: CompareFunction::GreaterEqual };

    fn target(self) -> wgpu::ColorTargetState {
        let maximum = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Max,
        };
        let (format, blend) = match self {
            Self::Picture { blend, .. } => (COLOUR, blend),
            Self::Mask => (MASK, Some(BlendState { color: maximum, alpha: maximum })),
            Self::Window(format) => (format, None),
        };
        wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
    }

    fn depth(self) -> Option<wgpu::DepthStencilState> {
        let Self::Picture { hides, compare, .. } = self else { return None };
        Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(hides),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        })
    }

    fn samples(self) -> u32 {
        if matches!(self, Self::Picture { .. }) { SAMPLES } else { 1 }
    }
}

/// Layer of bodies, drawn at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layer {
    /// Opaque bodies.
    Solid,
    /// Transparent bodies.
    Ghosts,
    /// The sun's shadow.
    Sun,
    /// The shadow of parts that touch the ground.
    Contact,
}

impl Layer {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Solid, Self::Ghosts, Self::Sun, Self::Contact];

    /// True for layers that are drawn into the mask.
    pub fn is_shadow(self) -> bool {
        matches!(self, Self::Sun | Self::Contact)
    }

    /// Entry points of the layer's shader, and target of the layer.
    pub fn stages_and_output(self) -> ([&'static str; 2], PipelineOutput) {
        match self {
            Self::Solid => (["vertex", "fragment"], PipelineOutput::SOLID),
            Self::Ghosts => (["vertex", "fragment"], PipelineOutput::GHOST),
            Self::Sun => (["sun_vertex", "sun_fragment"], PipelineOutput::Mask),
            Self::Contact => (["contact_vertex", "contact_fragment"], PipelineOutput::Mask),
        }
    }
}

/// Description of a pipeline.
pub(super) struct PipelineRecipe<'a> {
    pub label: &'a str,
    pub shader: &'a wgpu::ShaderModule,
    /// Entry points of the vertex and the fragment stage.
    pub stages: [&'a str; 2],
    pub groups: &'a [&'a BindGroupLayout],
    pub input: PipelineInput,
    pub output: PipelineOutput,
    /// Triangles of four corners in a strip instead of three each.
    pub strip: bool,
    /// Faces that are culled: front or back.
    pub hidden: Option<wgpu::Face>,
}

impl PipelineRecipe<'_> {
    /// The pipeline.
    pub fn build(&self, device: &Device) -> RenderPipeline {
        let groups: Vec<Option<&BindGroupLayout>> = self.groups.iter().copied().map(Some).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let topology =
            if self.strip { wgpu::PrimitiveTopology::TriangleStrip } else { wgpu::PrimitiveTopology::TriangleList };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.shader,
                entry_point: Some(self.stages[0]),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &self.input.buffers(),
            },
            primitive: wgpu::PrimitiveState { topology, cull_mode: self.hidden, ..Default::default() },
            depth_stencil: self.output.depth(),
            multisample: wgpu::MultisampleState { count: self.output.samples(), ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: self.shader,
                entry_point: Some(self.stages[1]),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(self.output.target())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A shader from its pieces.
pub(super) fn shader(device: &Device, label: &str, pieces: &[&str]) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(pieces.concat().into());
    device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
}

/// A layout of buffers that both stages read, in binding order.
pub(super) fn buffer_layout(device: &Device, label: &str, types: &[BufferBindingType]) -> BindGroupLayout {
    let entry = |(i, &ty): (usize, &BufferBindingType)| wgpu::BindGroupLayoutEntry {
        binding: i as u32,
        visibility: if ty == BufferBindingType::Uniform { ShaderStages::VERTEX_FRAGMENT } else { ShaderStages::VERTEX },
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A layout of one texture and its sampler.
pub(super) fn texture_layout(device: &Device, label: &str, view_dimension: TextureViewDimension) -> BindGroupLayout {
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::FRAGMENT, ty, count: None };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let entries = [entry(0, texture), entry(1, sampler)];
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A group of resources, in binding order.
pub fn bind_group(device: &Device, label: &str, layout: &BindGroupLayout, all: &[BindingResource<'_>]) -> BindGroup {
    let all = (0..).zip(all).map(|(binding, resource)| BindGroupEntry { binding, resource: resource.clone() });
    let entries: Vec<_> = all.collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
