//! Meshes of tasks: OBJ and glTF files.

use glam::Vec3;
use std::collections::{HashMap, HashSet};
use std::{path::Path, sync::Arc};
use throng_base::file::{MAX_TEXT_BYTES, read_file};
use throng_geometry::{SolidShape, TriangleMesh};
use throng_motion::import::{gltf, obj};

/// Reads a mesh.
///
/// - `unit_m`: length of a unit of the file (m).
/// - `open`: true accepts surfaces with holes, too.
///
/// # Errors
/// The file, and the line of a text, with the fault and the way out.
pub(super) fn read_mesh(path: &Path, unit_m: f64, open: bool) -> Result<SolidShape, String> {
    let is = |e: &str| path.extension().is_some_and(|x| x.eq_ignore_ascii_case(e));
    let mut triangles = if is("obj") {
        let bytes = read_file(path, "a mesh", MAX_TEXT_BYTES).map_err(|e| e.to_string())?;
        let text = String::from_utf8_lossy(&bytes);
        obj::triangles(&text).map_err(|(line, why)| format!("{}:{line}: {why}", path.display()))?
    } else if is("gltf") || is("glb") {
        gltf::triangles(path).map_err(|e| e.to_string())?
    } else {
        return Err(format!("{}: expected a mesh as OBJ, glTF or GLB; export it as one of them", path.display()));
    };
    if !(1e-6..=1e6).contains(&unit_m) {
        return Err(format!("{}: expected a positive `unit_m`, 0.000001 to 1000000, found {unit_m}", path.display()));
    }
    triangles.iter_mut().flatten().for_each(|corner| *corner *= unit_m as f32);
    remove_duplicates(&mut triangles);
    let holes = if open { 0 } else { open_edges(&triangles) };
    if holes > 0 {
        return Err(format!(
            "{}: {holes} edges belong to one triangle only: the surface has holes. Close it, or say `open = true`: nothing \
             passes through it, but it has no inside",
            path.display()
        ));
    }
    let mesh = TriangleMesh::new(triangles).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(SolidShape::Mesh(Arc::new(mesh)))
}

/// Keeps the first of triangles that have the same corners in the same order: others would cost time, and hide holes.
pub(super) fn remove_duplicates(triangles: &mut Vec<[Vec3; 3]>) {
    let mut seen = HashSet::new();
    triangles.retain(|t| {
        let corners = t.map(corner_key);
        let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
        seen.insert([0, 1, 2].map(|k| corners[(first + k) % 3]))
    });
}

/// Key of a corner for comparison: zero and minus zero are one place.
fn corner_key(corner: Vec3) -> [u32; 3] {
    (corner + Vec3::ZERO).to_array().map(f32::to_bits)
}

/// Number of edges with an odd number of triangles; corners at the same place are one, triangles without an area do not count.
pub(super) fn open_edges(triangles: &[[Vec3; 3]]) -> usize {
    let mut odd: HashMap<[[u32; 3]; 2], bool> = HashMap::new();
    for t in triangles {
        let corners = t.map(corner_key);
        if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
            continue;
        }
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let edge = if a < b { [a, b] } else { [b, a] };
            let is_odd = odd.entry(edge).or_default();
            *is_odd = !*is_odd;
        }
    }
    odd.values().filter(|is_odd| **is_odd).count()
}
