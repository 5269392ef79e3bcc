//! The weight of one example over two axes of a parameter box, in colours.

use super::plane::MapPlane;
use crate::theme::rgb;
use eframe::{egui::Color32, egui::epaint::Mesh};
use std::sync::Arc;
use throng_core::blend::{BlendSpace, MAX_AXES};

/// Range of the colours; cardinal weights overshoot 0 and 1 a little.
pub const RANGE: [f32; 2] = [-0.2, 1.2];
/// Pieces of the picture along each axis.
const PIECES: usize = 48;

/// Key of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceKey {
    /// Generation of the document.
    pub document: u64,
    /// Blend space.
    pub space: usize,
    /// Example.
    pub example: usize,
    /// A point that the surface goes through, at the low ends of the shown axes: moving it within the plane does not
    /// change the picture.
    pub through: [f32; MAX_AXES],
    /// Map on the screen.
    pub plane: MapPlane,
    /// In the colours of the dark theme.
    pub dark: bool,
}

/// The picture.
#[derive(Clone, Debug)]
pub struct WeightSurface {
    /// Key that the picture was computed for.
    pub key: SurfaceKey,
    /// Coloured triangles.
    pub mesh: Arc<Mesh>,
    /// Least and largest weight.
    pub range: [f32; 2],
}

impl WeightSurface {
    /// Works the picture out (example < number of examples).
    pub fn new(key: SurfaceKey, space: &BlendSpace) -> Self {
        let rows = if key.plane.shown.up.is_some() { PIECES } else { 1 };
        let ratio = |i: usize, n: usize| i as f32 / n as f32;
        let places = (0..=rows).flat_map(|k| (0..=PIECES).map(move |i| (ratio(i, PIECES), ratio(k, rows))));
        let places: Vec<(f32, f32)> = places.collect();
        let points: Vec<_> = places.iter().map(|&(i, k)| key.plane.point_with(&key.through, i, k)).collect();
        let mut weights = vec![0.0; points.len() * space.stride()];
        let mut mesh = Mesh::default();
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        if space.weights(&points, &mut weights).is_ok() {
            for (&(i, k), row) in places.iter().zip(weights.chunks_exact(space.stride())) {
                let w = row[key.example];
                range = [range[0].min(w), range[1].max(w)];
                mesh.colored_vertex(key.plane.position_at(i, k), colour(w, key.dark));
            }
            let width = PIECES as u32 + 1;
            for below in (0..rows as u32 * width).filter(|v| v % width != width - 1) {
                mesh.add_triangle(below, below + 1, below + width);
                mesh.add_triangle(below + 1, below + width, below + width + 1);
            }
        }
        Self { key, mesh: Arc::new(mesh), range }
    }
}

/// Weights, and their colours in the light and in the dark theme.
const STATIONS: [(f32, [u32; 2]); 5] = [
    (RANGE[0], [0xd22f5a, 0xe84a6f]),
    (0.0, [0xf4f5f6, 0x1c2027]),
    (0.5, [0x8fcfc2, 0x1f6f72]),
    (1.0, [0x1d8a78, 0x3fc99d]),
    (RANGE[1], [0x8a6d00, 0xf6e36b]),
];

/// Colour of a weight: the background at 0, green at 1, yellow beyond, red below 0.
pub fn colour(weight: f32, dark: bool) -> Color32 {
    let w = if weight.is_nan() { 0.0 } else { weight.clamp(RANGE[0], RANGE[1]) };
    let i = STATIONS.partition_point(|s| s.0 <= w).clamp(1, STATIONS.len() - 1);
    let ((from, a), (to, b)) = (STATIONS[i - 1], STATIONS[i]);
    let [a, b] = [a, b].map(|colours| rgb(colours[usize::from(dark)]));
    a.lerp_to_gamma(b, (w - from) / (to - from))
}

#[cfg(test)]
mod tests {
    use super::super::plane::MapAxes;
    use super::*;
    use crate::bundle::OpenBundle;
    use crate::fixtures::paces::Paces;
    use eframe::egui::{Rect, pos2};

    #[test]
    fn the_surface_is_1_at_its_example_and_0_at_all_others() {
        let paces = Paces::new();
        let bundle = OpenBundle::open(&paces.bundle()).unwrap();
        let space = &bundle.blends[0];
        let rect = Rect::from_min_max(pos2(0.0, 0.0), pos2(480.0, 480.0));
        let plane = MapPlane::new(space.axes(), MapAxes::default_for(space.axes()), rect);
        for example in [0, 7, 19] {
            let through = plane.point_with(&[0.0; MAX_AXES], 0.0, 0.0);
            let key = SurfaceKey { document: 1, space: 0, example, through, plane, dark: true };
            let surface = WeightSurface::new(key, space);
            assert_eq!(surface.mesh.vertices.len(), (PIECES + 1) * (PIECES + 1));
            assert!(surface.range[1] > 0.8 && surface.range[0] > -0.5, "{:?}", surface.range);
            let near = |e: usize| {
                let at = plane.screen(&space.examples()[e].parameters);
                let far = |v: &&eframe::egui::epaint::Vertex| (v.pos - at).length();
                surface.mesh.vertices.iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap().color
            };
            let green = |c: Color32| c.g();
            assert!((0..20).filter(|&e| e != example).all(|e| green(near(e)) < green(near(example))));
        }
    }

    #[test]
    fn moving_the_point_within_the_plane_leaves_the_picture_as_it_is() {
        let axes = [0, 1, 3].map(|kind| throng_core::blend::AxisRecord { kind, num_knots: 2, low: 0.0, high: 1.0 });
        let plane = MapPlane::new(&axes, MapAxes { across: 0, up: Some(1) }, Rect::EVERYTHING);
        let key = |p: [f32; 3]| {
            let through = plane.point_with(&std::array::from_fn(|a| p.get(a).copied().unwrap_or(0.0)), 0.0, 0.0);
            SurfaceKey { document: 1, space: 0, example: 0, through, plane, dark: true }
        };
        assert!(key([0.1, 0.2, 0.5]) == key([0.9, 0.8, 0.5]));
        assert!(key([0.1, 0.2, 0.5]) != key([0.1, 0.2, 0.6]));
    }

    #[test]
    fn zero_weight_has_the_colour_of_the_panel_and_signs_differ() {
        for dark in [true, false] {
            let [low, none, one, high] = [-0.2, 0.0, 1.0, 1.2].map(|w| colour(w, dark));
            assert!(none.r().abs_diff(none.b()) < 16, "{none:?}");
            assert!(low.r() > low.g() + 60 && one.g() > one.r() + 60, "{low:?} {one:?}");
            assert_eq!([colour(-9.0, dark), colour(9.0, dark), colour(f32::NAN, dark)], [low, high, none]);
        }
    }
}
