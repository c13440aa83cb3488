use std::borrow::Cow;
use std::io::Write;

use anyhow::{Context, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use catamaran::io::Output;

use super::format::Format;

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

    /// Writes the image as SVG if the name of the file selects that, else as PNG, and completes the
    /// file.
    pub fn write(&self, output: Output) -> Result<()> {
        self.write_zoomed(output, 1)
    }

    /// Writes the image with squares of `zoom` x `zoom` pixels for its pixels; otherwise like
    /// [`Image::write`].
    pub fn write_zoomed(&self, mut output: Output, zoom: usize) -> Result<()> {
        let name = output.path().display().to_string();
        let written = match Format::of(output.path()) {
            Some(Format::Svg) => self.encode_svg(&mut output, zoom),
            _ => self.zoomed(zoom).encode(&mut output).map_err(anyhow::Error::from),
        };
        written.with_context(|| format!("{name}: can't be written"))?;
        output.commit()?;
        Ok(())
    }

    fn zoomed(&self, zoom: usize) -> Cow<'_, Self> {
        if zoom == 1 {
            return Cow::Borrowed(self);
        }
        let (width, height) = (zoom * self.width, zoom * self.height);
        let pixel = |x: usize, y: usize| self.pixels[y / zoom * self.width + x / zoom];
        Cow::Owned(Self::from_fn(width, height, pixel))
    }

    /// Writes an SVG document that holds the pixels, which stay sharp at any size.
    fn encode_svg(&self, sink: &mut dyn Write, zoom: usize) -> Result<()> {
        let mut pixels = Vec::new();
        self.encode(&mut pixels)?;
        let (width, height) = (self.width, self.height);
        write!(
            sink,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" \
             viewBox=\"0 0 {width} {height}\">\n<image width=\"{width}\" height=\"{height}\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{}\"/>\n</svg>\n",
            zoom * width,
            zoom * height,
            STANDARD.encode(pixels)
        )?;
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
