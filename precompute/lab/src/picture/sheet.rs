//! Several pictures on one page.

use super::{Picture, colour};

/// Stacks pictures from top to bottom, each in the middle of the page's width: an overview and its strips.
pub fn sheet(pictures: &[&Picture]) -> Picture {
    let width = pictures.iter().map(|p| p.width()).max().unwrap_or(0);
    let height = pictures.iter().fold(0u32, |h, p| h.saturating_add(p.height()));
    let mut page = Picture::new(width, height, colour::PAPER);
    let mut y = 0;
    for p in pictures {
        page.draw_picture(p, (((width - p.width()) / 2) as i32, y));
        y = y.saturating_add_unsigned(p.height());
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Colour;

    #[test]
    fn pictures_keep_their_pixels_and_their_order() {
        let red = Picture::new(40, 20, Colour::hex(0xff0000));
        let blue = Picture::new(20, 30, Colour::hex(0x0000ff));
        let page = sheet(&[&red, &blue]);
        assert_eq!((page.width(), page.height()), (40, 50));
        assert_eq!(page.pixel(20, 10), red.pixel(0, 0));
        assert_eq!(page.pixel(20, 40), blue.pixel(0, 0));
        assert_ne!(page.pixel(2, 40), blue.pixel(0, 0));
        assert_eq!(sheet(&[]).width(), 16);
    }
}
