//! Writes text in pictures.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::color::{to_light, to_screen};
use super::image::{Image, Rgb};

/// The height of letters, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// 16.
    Small,
    /// 20.
    Large,
}

impl Size {
    /// Returns the height of a line, in pixels.
    pub fn height(self) -> usize {
        self.raster().val()
    }

    /// Returns the width of a text, in pixels.
    pub fn width(self, text: &str) -> usize {
        text.chars().count() * get_raster_width(FontWeight::Regular, self.raster())
    }

    fn raster(self) -> RasterHeight {
        match self {
            Self::Small => RasterHeight::Size16,
            Self::Large => RasterHeight::Size20,
        }
    }
}

/// Writes ASCII text, its upper left corner at column x and row y; other characters become question
/// marks, and text outside of the image is cut.
pub fn write_text(image: &mut Image, text: &str, size: Size, x: usize, y: usize, color: Rgb) {
    let ink = to_light(color);
    let mut x = x;
    for letter in text.chars() {
        let shape = |c| get_raster(c, FontWeight::Regular, size.raster());
        let Some(shape) = shape(letter).or_else(|| shape('?')) else { continue };
        for (row, line) in shape.rows().enumerate() {
            for (column, &cover) in line.iter().enumerate() {
                let Some(pixel) = image.pixel(x + column, y + row) else { continue };
                let (cover, paper) = (f64::from(cover) / 255.0, to_light(*pixel));
                let mixed = std::array::from_fn(|k| cover * ink[k] + (1.0 - cover) * paper[k]);
                *pixel = to_screen(mixed);
            }
        }
        x += shape.width();
    }
}

/// Formats a number in few letters: three digits, and a power of ten where that is shorter.
pub fn number(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let size = x.abs().log10().floor();
    if !(-3.0..5.0).contains(&size) {
        return format!("{x:.2e}");
    }
    let decimals = (2.0 - size).max(0.0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (-0.5, "-0.5"),
            (std::f64::consts::PI, "3.14"),
            (0.001_234_5, "0.00123"),
            (12_345.6, "12346"),
            (1e-7, "1.00e-7"),
            (-2.5e9, "-2.50e9"),
        ];
        for (x, text) in cases {
            assert_eq!(number(x), text);
        }
    }

    #[test]
    fn letters_leave_ink_where_they_are_and_nowhere_else() {
        let mut image = Image::new(60, 30, [255; 3]);
        write_text(&mut image, "H\u{fffd}", Size::Large, 5, 5, [0; 3]);
        let width = Size::Large.width("H\u{fffd}");
        let mut ink = 0;
        for y in 0..30 {
            for x in 0..60 {
                let dark = image.pixel(x, y).is_some_and(|p| p[0] < 128);
                ink += usize::from(dark);
                assert!(!dark || ((5..5 + width).contains(&x) && (5..25).contains(&y)));
            }
        }
        assert!(ink > 20);
        // Over the edge is nothing.
        write_text(&mut image, "WWWWWWWWWWWWW", Size::Small, 50, 28, [0; 3]);
    }
}
