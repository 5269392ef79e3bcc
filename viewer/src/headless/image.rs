//! A picture as pixels, and as a file.

use crate::args::PictureSize;
use std::path::Path;
use throng_precompute::BuildError;
use throng_precompute::files::write_atomically;

/// A picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Size of the picture.
    pub size: PictureSize,
    /// All pixels, row-major, top row first: red, green and blue (3 * width * height).
    pub rgb: Vec<u8>,
}

impl Image {
    /// Writes a PNG file.
    ///
    /// # Errors
    /// [`BuildError::Io`] names the file; what stood there before stays as it was.
    pub fn save_png(&self, path: &Path) -> Result<(), BuildError> {
        let failed = |e: png::EncodingError| BuildError::Io { path: path.to_path_buf(), source: e.into() };
        let png = self.to_png().map_err(failed)?;
        write_atomically(path, |file| file.write_all(&png))
    }

    fn to_png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size.width, self.size.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_written_and_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let rgb: Vec<u8> = (0..5 * 3 * 3).map(|i| i as u8 * 5).collect();
        let image = Image { size: PictureSize { width: 5, height: 3 }, rgb: rgb.clone() };
        image.save_png(&path).expect("written");
        let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).expect("a file")));
        let mut reader = decoder.read_info().expect("a PNG");
        let mut read = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut read).expect("pixels");
        assert_eq!((info.width, info.height, read), (5, 3, rgb));
        assert_eq!(std::fs::read_dir(folder.path()).expect("the folder").count(), 1);
        let error = image.save_png(&folder.path().join("no/a.png")).expect_err("no folder");
        assert!(error.to_string().contains("no"), "{error}");
    }
}
