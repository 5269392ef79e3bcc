//! A character of the user's own as the GPU reads it: triangles at every level of detail, and its textures.

use super::mesh::LEVELS;
use bytemuck::{Pod, Zeroable};
use eframe::egui::ecolor::gamma_u8_from_linear_f32;
use glam::Vec3;
use image::{ImageFormat, ImageReader, Limits, RgbaImage, imageops::FilterType};
use std::{collections::HashMap, io::Cursor};
use throng_base::error::ensure;
use throng_precompute::wearer::{Material, SkinnedFigure, SurfaceCorner};

/// Distance below which corners are merged, by level of detail, for a character of height [`HEIGHT_M`] (m).
const CELLS_M: [f32; LEVELS] = [0.0, 0.015, 0.035, 0.08];
const HEIGHT_M: f32 = 1.75;
/// Size of textures (pixels a side).
pub(super) const TEXTURE_PX: u32 = 1024;
/// Most textures of a character.
const MAX_TEXTURES: usize = 64;
/// Longest side of an image that is read (pixels).
const MAX_IMAGE_PX: u32 = 16_384;
/// Largest memory for reading an image (bytes).
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// One corner.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct WornVertex {
    pub position: [f32; 3],
    /// Colour that the texture is multiplied with, sRGB; alpha is the cutoff.
    pub colour: [u8; 4],
    pub normal: [f32; 3],
    pub frames: [u16; 4],
    pub weights: [u16; 4],
    pub texture: [f32; 2],
    pub layer: u32,
}

/// Triangles at one level of detail.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct WornLevel {
    pub vertices: Vec<WornVertex>,
    pub indices: Vec<u32>,
}

/// A character of the user's own, ready to be drawn.
pub struct WornMesh {
    pub(super) levels: [WornLevel; LEVELS],
    /// Pixels of the textures, [`TEXTURE_PX`] a side; the first is white.
    pub(super) layers: Vec<RgbaImage>,
    /// Matrices of a pose.
    pub(super) num_frames: usize,
    /// Reach from the hips, relative to the length of the legs.
    pub(super) reach: f32,
}

impl WornMesh {
    /// Makes the levels of detail of a figure, and reads its textures.
    ///
    /// # Errors
    /// A texture that cannot be read, and the way out.
    pub fn new(figure: &SkinnedFigure) -> Result<Self, String> {
        let surface = figure.surface();
        let (layers, layer_of) = textures(&surface.images, &surface.materials)?;
        let rest = figure.rest_corners();
        let (low, high) = rest.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |b, &p| (b.0.min(p), b.1.max(p)));
        let height = (high.y - low.y).max(1e-3);
        let vertex = |c: &SurfaceCorner| {
            let m = &surface.materials[usize::from(c.material)];
            WornVertex {
                position: c.position.to_array(),
                colour: gpu_colour(m),
                normal: c.normal.to_array(),
                frames: c.frames,
                weights: c.weights.map(|w| (w * f32::from(u16::MAX)).round() as u16),
                texture: c.texture.to_array(),
                layer: m.image.map_or(0, |i| layer_of[&i]),
            }
        };
        let vertices: Vec<WornVertex> = surface.corners.iter().map(vertex).collect();
        let all = WornLevel { vertices, indices: surface.indices.clone() };
        let levels = CELLS_M.map(|cell| match cell {
            0.0 => all.clone(),
            cell => coarser(&all, &surface.corners, &rest, cell * height / HEIGHT_M),
        });
        let reach = (high - low).length() / height;
        Ok(Self { levels, layers, num_frames: figure.num_frames(), reach })
    }

    /// Triangles at the finest level of detail.
    pub fn num_triangles(&self) -> usize {
        self.levels[0].indices.len() / 3
    }
}

/// Merges corners in one cell of a grid that go with one joint; triangles that lose their area are left out.
fn coarser(all: &WornLevel, corners: &[SurfaceCorner], rest: &[Vec3], cell_m: f32) -> WornLevel {
    let mut out = WornLevel::default();
    let mut known: HashMap<([i32; 3], u16, u16), u32> = HashMap::new();
    let mut normals: Vec<Vec3> = Vec::new();
    for t in all.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| rest[t[k] as usize]);
        let area = (b - a).cross(c - a).length();
        let merged = [0, 1, 2].map(|k| {
            let i = t[k] as usize;
            let cell = (rest[i] / cell_m).floor().to_array().map(|v| v as i32);
            let place = *known.entry((cell, corners[i].frames[0], corners[i].material)).or_insert_with(|| {
                out.vertices.push(all.vertices[i]);
                normals.push(Vec3::ZERO);
                out.vertices.len() as u32 - 1
            });
            // Large faces tell more of how the surface lies than small ones.
            normals[place as usize] += corners[i].normal * area;
            place
        });
        let [a, b, c] = merged;
        if a != b && b != c && c != a {
            out.indices.extend(merged);
        }
    }
    for (vertex, normal) in out.vertices.iter_mut().zip(normals) {
        vertex.normal = normal.try_normalize().map_or(vertex.normal, |n| n.to_array());
    }
    out
}

fn gpu_colour(m: &Material) -> [u8; 4] {
    let [r, g, b, _] = m.colour.map(gamma_u8_from_linear_f32);
    [r, g, b, (m.cutoff.clamp(0.0, 1.0) * 255.0).round() as u8]
}

/// Layers of the texture, and which image is on which.
fn textures(images: &[Vec<u8>], materials: &[Material]) -> Result<(Vec<RgbaImage>, HashMap<usize, u32>), String> {
    let white = RgbaImage::from_pixel(TEXTURE_PX, TEXTURE_PX, image::Rgba([255; 4]));
    let (mut layers, mut layer_of) = (vec![white], HashMap::new());
    for image in materials.iter().filter_map(|m| m.image) {
        if layer_of.contains_key(&image) {
            continue;
        }
        if layer_of.len() == MAX_TEXTURES {
            return Err(format!("expected {MAX_TEXTURES} textures at most, found more; bake them into fewer"));
        }
        let read =
            pixels(&images[image]).map_err(|e| format!("images[{image}]: {e}; export textures as PNG or JPEG"))?;
        layer_of.insert(image, layers.len() as u32);
        layers.push(read);
    }
    Ok((layers, layer_of))
}

fn pixels(bytes: &[u8]) -> Result<RgbaImage, String> {
    let format = image::guess_format(bytes).map_err(|e| e.to_string())?;
    ensure(matches!(format, ImageFormat::Png | ImageFormat::Jpeg), || format!("found a picture as {format:?}"))?;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_IMAGE_PX), Some(MAX_IMAGE_PX));
    limits.max_alloc = Some(MAX_IMAGE_BYTES);
    reader.limits(limits);
    let image = reader.decode().map_err(|e| e.to_string())?;
    Ok(image.resize_exact(TEXTURE_PX, TEXTURE_PX, FilterType::Triangle).to_rgba8())
}
