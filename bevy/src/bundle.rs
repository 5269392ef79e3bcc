//! Bundles as assets.

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use throng_runtime::Bundle;
use throng_runtime::format::{AlignedBytes, FormatError};

/// A bundle (`*.throng`), as `throng build` writes it.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct ThrongBundle(pub Bundle);

/// Reads bundles.
#[derive(TypePath, Clone, Copy, Debug, Default)]
pub struct BundleLoader;

/// Why a bundle was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// The file cannot be read.
    #[error("the bundle cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// It is no bundle, or a damaged one.
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl AssetLoader for BundleLoader {
    type Asset = ThrongBundle;
    type Settings = ();
    type Error = BundleError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        _: &mut LoadContext<'_>,
    ) -> Result<ThrongBundle, BundleError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        Ok(ThrongBundle(Bundle::from_bytes(AlignedBytes::from_slice(&bytes))?))
    }

    fn extensions(&self) -> &[&str] {
        &["throng"]
    }
}
