//! Triangles of Wavefront OBJ files.

use super::gltf::{SceneNode, ScenePart, TriangleScene};
use crate::error::ensure;
use glam::Vec3;

/// Most corners of a file.
const MAX_CORNERS: usize = 15_000_000;

/// Triangles of a text, see [`scene`].
///
/// # Errors
/// As [`scene`].
pub fn triangles(text: &str) -> Result<Vec<[Vec3; 3]>, (usize, String)> {
    Ok(scene(text)?.triangles)
}

/// Positions, faces and the names of objects, groups and materials of a text; polygons become fans of triangles, all else is left
/// out.
///
/// # Errors
/// Number of the line (from 1), and the fault in it.
pub fn scene(text: &str) -> Result<TriangleScene, (usize, String)> {
    let (mut points, mut out) = (Vec::new(), Vec::new());
    let (mut parts, mut nodes, mut material) = (Vec::new(), Vec::new(), String::new());
    for (i, line) in text.lines().enumerate() {
        let fail = |why: String| (i + 1, why);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> =
                    words.take(3).map_while(|w| w.parse().ok()).filter(|x: &f32| x.is_finite()).collect();
                let [x, y, z] = numbers[..] else {
                    return Err(fail(format!("expected `v x y z` with finite numbers, found `{line}`")));
                };
                points.push(Vec3::new(x, y, z));
            }
            Some("f") => {
                let corners: Vec<Vec3> = words.map(|w| corner(w, &points)).collect::<Result<_, _>>().map_err(fail)?;
                let what = || fail(format!("expected a face of three corners at least, found `{line}`"));
                ensure(corners.len() >= 3, what)?;
                out.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
            }
            Some(key @ ("o" | "g" | "usemtl")) => {
                let name = line.trim_start()[key.len()..].trim().to_owned();
                if key == "usemtl" {
                    material = name;
                } else {
                    nodes.push(SceneNode { name, at: Vec3::ZERO, parent: None });
                }
                let node = nodes.len().saturating_sub(1);
                parts.push(ScenePart { first: out.len(), node, material: material.clone() });
            }
            _ => {}
        }
        let num_corners = points.len().max(3 * out.len());
        ensure(num_corners <= MAX_CORNERS, || fail(format!("expected at most {MAX_CORNERS} corners, found more")))?;
    }
    Ok(TriangleScene { triangles: out, parts, nodes })
}

/// A corner such as `7`, `7/1/2` or `-1`: numbers count from 1, or from the last one backwards.
fn corner(word: &str, points: &[Vec3]) -> Result<Vec3, String> {
    let number = word.split('/').next().unwrap_or_default();
    let index = match number.parse::<i64>() {
        Ok(n) if n > 0 => usize::try_from(n - 1).ok(),
        Ok(n) if n < 0 => points.len().checked_sub(n.unsigned_abs() as usize),
        _ => None,
    };
    let wrong = || format!("expected a corner from 1 to {}, found `{word}`", points.len());
    index.and_then(|i| points.get(i)).copied().ok_or_else(wrong)
}
