//! A character of the user, with a mesh that all characters wear.

use crate::render::WornMesh;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use throng_precompute::{import::ImportConfig, wearer::SkinnedFigure};

/// A character of the user's own.
pub struct UserOutfit {
    /// File of the character.
    pub path: PathBuf,
    /// Figure that converts poses to matrices of the mesh.
    pub figure: SkinnedFigure,
    /// Triangles and textures that are drawn.
    pub mesh: Arc<WornMesh>,
}

impl UserOutfit {
    /// Reads a character with a skin: a `.glb` file, or a `.gltf` file with one buffer.
    ///
    /// # Errors
    /// A message that names the file, what is wrong with it and the way out.
    pub fn open(path: &Path) -> Result<Self, String> {
        let figure = SkinnedFigure::open(path, &ImportConfig::default()).map_err(|e| e.to_string())?;
        let mesh = WornMesh::new(&figure).map_err(|e| format!("{}: {e}", path.display()))?;
        Ok(Self { path: path.to_path_buf(), figure, mesh: Arc::new(mesh) })
    }

    /// Name of the file.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}
