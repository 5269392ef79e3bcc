//! The colour map of numbers, in the dark and in the light theme.

use super::rgb;
use eframe::egui::Color32;

/// Stations of viridis, at equal distances: perceptually uniform, distinguished by colour-blind people too (0xRRGGBB).
const VIRIDIS: [u32; 10] =
    [0x440154, 0x482878, 0x3e4a89, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6dcd59, 0xb4de2c, 0xfde725];

/// Colour of a ratio, from dark violet to light yellow (0 to 1, clamped).
pub fn map(ratio: f32) -> Color32 {
    let t = if ratio.is_nan() { 0.0 } else { ratio.clamp(0.0, 1.0) } * (VIRIDIS.len() - 1) as f32;
    let i = (t as usize).min(VIRIDIS.len() - 2);
    rgb(VIRIDIS[i]).lerp_to_gamma(rgb(VIRIDIS[i + 1]), t - i as f32)
}

/// The part of the colour map that lines can be drawn with on a panel of the theme.
pub fn line(ratio: f32, dark: bool) -> Color32 {
    let t = if ratio.is_nan() { 0.0 } else { ratio.clamp(0.0, 1.0) };
    map(if dark { 0.35 + 0.65 * t } else { 0.75 * t })
}

/// A number between two others as a ratio; 1 if they are equal.
pub fn ratio(v: f32, [low, high]: [f32; 2]) -> f32 {
    if high > low { (v - low) / (high - low) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness (0 to 100).
    fn lightness(c: Color32) -> f32 {
        let linear = |v: u8| {
            let v = f32::from(v) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(c.r()) + 0.7152 * linear(c.g()) + 0.0722 * linear(c.b());
        if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn lightness_rises_evenly_along_the_map() {
        let steps: Vec<f32> = (0..=100).map(|i| lightness(map(i as f32 / 100.0))).collect();
        assert!(steps.is_sorted_by(|a, b| a < b));
        // Tenths of the map are alike within a factor of two.
        let tenths: Vec<f32> =
            steps.iter().step_by(10).zip(steps.iter().skip(10).step_by(10)).map(|s| s.1 - s.0).collect();
        assert_eq!(tenths.len(), 10);
        assert!(tenths.iter().all(|t| (4.0..16.0).contains(t)), "{tenths:?}");
    }

    #[test]
    fn lines_stand_out_from_the_panel_of_either_theme() {
        for i in 0..=20 {
            let t = i as f32 / 20.0;
            assert!(lightness(line(t, true)) > 35.0);
            assert!(lightness(line(t, false)) < 75.0);
        }
    }

    #[test]
    fn a_ratio_is_within_its_bounds_whatever_they_are() {
        assert_eq!(ratio(2.0, [1.0, 3.0]), 0.5);
        assert_eq!(ratio(2.0, [2.0, 2.0]), 1.0);
        assert_eq!(map(f32::NAN), map(0.0));
        assert_eq!(map(7.0), map(1.0));
    }
}
