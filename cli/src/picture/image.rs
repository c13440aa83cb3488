use std::io::Write;

use anyhow::{Context, Result};
use catamaran::io::Output;

/// Red, green and blue as screens have them (sRGB).
pub type Rgb = [u8; 3];

/// A rectangle of pixels, the rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl Image {
    /// Returns an image of a single colour.
    pub fn new(width: usize, height: usize, color: Rgb) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// Returns the image whose pixel in column x and row y is `color(x, y)`.
    pub fn from_fn(width: usize, height: usize, color: impl Fn(usize, usize) -> Rgb) -> Self {
        let pixels = (0..width * height).map(|i| color(i % width, i / width)).collect();
        Self { width, height, pixels }
    }

    /// Returns the image of these pixels, rows of `width` from the top.
    pub fn from_pixels(width: usize, pixels: Vec<Rgb>) -> Self {
        Self { width, height: pixels.len() / width.max(1), pixels }
    }

    /// Writes the image as PNG, and completes the file.
    pub fn write_png(&self, mut output: Output) -> Result<()> {
        let name = output.path().display().to_string();
        self.encode(&mut output).with_context(|| format!("{name}: can't be written"))?;
        output.commit()?;
        Ok(())
    }

    fn encode(&self, sink: &mut dyn Write) -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(sink, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()
    }

    /// Returns the number of pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns red, green and blue of the pixels, row by row.
    pub fn bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }

    /// Returns the pixel in column x and row y, if there is one.
    pub fn pixel(&mut self, x: usize, y: usize) -> Option<&mut Rgb> {
        if x < self.width { self.pixels.get_mut(y * self.width + x) } else { None }
    }

    /// Draws another image over this one, its upper left corner at column x and row y; parts
    /// outside are cut.
    pub fn paste(&mut self, other: &Self, x: usize, y: usize) {
        for (row, line) in other.pixels.chunks_exact(other.width.max(1)).enumerate() {
            for (column, &color) in line.iter().enumerate() {
                if let Some(pixel) = self.pixel(x + column, y + row) {
                    *pixel = color;
                }
            }
        }
    }
}

/// Writes numbers as a PNG of 16 bits, black for 0, and completes the file.
pub fn write_gray(mut output: Output, width: usize, height: usize, values: &[u16]) -> Result<()> {
    let name = output.path().display().to_string();
    let encode = |sink: &mut dyn Write| -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(sink, width as u32, height as u32);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        let mut writer = encoder.write_header()?;
        // The larger byte first (PNG, third edition, section 7.1).
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
        writer.write_image_data(&bytes)?;
        writer.finish()
    };
    encode(&mut output).with_context(|| format!("{name}: can't be written"))?;
    output.commit()?;
    Ok(())
}
