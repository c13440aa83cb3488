use std::io::{self, Write};

use png::{BitDepth, ColorType};

use catamaran::base::{Error, Result, reserved};

/// A rectangle of pixels. Rows run from the top, where the texture coordinate v is 1, downwards.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    color: ColorType,
    depth: BitDepth,
    bytes: Vec<u8>,
}

impl Picture {
    /// Creates a picture from red, green and blue, 8 bits each, `width` pixels a row.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::Picture;
    ///
    /// let picture = Picture::rgb(2, &[[255, 0, 0], [0, 255, 0]])?;
    /// assert_eq!(picture.to_png()?[1..4], *b"PNG");
    /// assert!(Picture::rgb(2, &[[0; 3]]).is_err());
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] when pixels are not whole rows of `width`, or there are none;
    /// [`Error::OutOfMemory`].
    pub fn rgb(width: usize, pixels: &[[u8; 3]]) -> Result<Self> {
        Self::new(width, pixels.len(), ColorType::Rgb, BitDepth::Eight, pixels.as_flattened())
    }

    /// Creates a picture from red, green, blue and opacity, 8 bits each, `width` pixels a row.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::Picture;
    ///
    /// let picture = Picture::rgba(1, &[[255, 0, 0, 128], [0, 255, 0, 255]])?;
    /// assert_eq!((picture.width(), picture.height()), (1, 2));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Picture::rgb`].
    pub fn rgba(width: usize, pixels: &[[u8; 4]]) -> Result<Self> {
        Self::new(width, pixels.len(), ColorType::Rgba, BitDepth::Eight, pixels.as_flattened())
    }

    /// Creates a picture from grey values of 8 bits, `width` pixels a row.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::Picture;
    ///
    /// assert_eq!(Picture::gray(2, &[0, 85, 170, 255])?.height(), 2);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Picture::rgb`].
    pub fn gray(width: usize, pixels: &[u8]) -> Result<Self> {
        Self::new(width, pixels.len(), ColorType::Grayscale, BitDepth::Eight, pixels)
    }

    /// Creates a picture from grey values of 16 bits, `width` pixels a row.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::Picture;
    ///
    /// let ramp: Vec<u16> = (0..256).map(|i| 257 * i).collect();
    /// assert_eq!(Picture::gray16(16, &ramp)?.height(), 16);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Picture::rgb`].
    pub fn gray16(width: usize, pixels: &[u16]) -> Result<Self> {
        let mut bytes: Vec<u8> = reserved(2 * pixels.len())?;
        // The higher byte first (PNG, third edition, section 7.1).
        bytes.extend(pixels.iter().flat_map(|x| x.to_be_bytes()));
        Self::new(width, pixels.len(), ColorType::Grayscale, BitDepth::Sixteen, &bytes)
    }

    fn new(
        width: usize,
        pixels: usize,
        color: ColorType,
        depth: BitDepth,
        bytes: &[u8],
    ) -> Result<Self> {
        let height = pixels / width.max(1);
        let expected = (height.max(1), width.max(1));
        Error::check_shape("picture", expected, (pixels.div_ceil(width.max(1)), width))?;
        Error::check_shape("picture", (height * width, 1), (pixels, 1))?;
        let mut own = reserved(bytes.len())?;
        own.extend_from_slice(bytes);
        let side = |side: usize| {
            u32::try_from(side).map_err(|_| Error::Argument {
                what: "picture",
                why: format!("each side must be less than 2^32 pixels, is {side}"),
            })
        };
        Ok(Self { width: side(width)?, height: side(height)?, color, depth, bytes: own })
    }

    /// Returns the picture with its rows in reverse order, for textures, whose first row is at v =
    /// 0.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::Picture;
    ///
    /// let picture = Picture::gray(1, &[0, 255])?;
    /// assert_eq!(picture.flipped(), Picture::gray(1, &[255, 0])?);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn flipped(mut self) -> Self {
        let row = self.bytes.len() / self.height as usize;
        let half = self.height as usize / 2;
        let (above, below) = self.bytes.split_at_mut(half * row);
        for (a, b) in above.chunks_exact_mut(row).zip(below.chunks_exact_mut(row).rev()) {
            a.swap_with_slice(b);
        }
        self
    }

    /// Returns whether the picture has an opacity.
    pub(super) fn has_opacity(&self) -> bool {
        self.color == ColorType::Rgba
    }

    /// Returns the number of pixels of a row.
    pub fn width(&self) -> usize {
        self.width as usize
    }

    /// Returns the number of rows.
    pub fn height(&self) -> usize {
        self.height as usize
    }

    /// Writes the picture as PNG.
    ///
    /// ```
    /// use catamaran_geometry::mesh::io::Picture;
    ///
    /// let mut bytes = Vec::new();
    /// Picture::gray(1, &[7])?.write_png(&mut bytes).unwrap();
    /// assert_eq!(bytes[1..4], *b"PNG");
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of the sink.
    pub fn write_png(&self, sink: &mut dyn Write) -> io::Result<()> {
        let encode = || -> std::result::Result<(), png::EncodingError> {
            let mut encoder = png::Encoder::new(sink, self.width, self.height);
            encoder.set_color(self.color);
            encoder.set_depth(self.depth);
            encoder.set_compression(png::Compression::Fast);
            let mut writer = encoder.write_header()?;
            writer.write_image_data(&self.bytes)?;
            writer.finish()
        };
        encode().map_err(|error| match error {
            png::EncodingError::IoError(error) => error,
            other => io::Error::other(other.to_string()),
        })
    }

    /// Returns the bytes of the picture as PNG.
    ///
    /// # Errors
    /// [`Error::Argument`] when PNG can't store the picture.
    pub fn to_png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let failed = |e: io::Error| Error::Argument { what: "picture", why: e.to_string() };
        self.write_png(&mut bytes).map_err(failed)?;
        Ok(bytes)
    }
}
