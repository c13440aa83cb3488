//! Reads masks from PNG.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context, Result};
use catamaran::io::SourceOptions;
use catamaran_simulation::texture::slime::{FREE, GOAL, Mask, OBSTACLE};

/// A channel of a mask counts above this value.
const HALF: u8 = 127;

/// Reads a mask of `size` x `size` texels from a picture of any size: red where agents start, green
/// where obstacles are, blue where attractors are (thesis, figure 3.9). Texels take the pixel at
/// their centre.
pub fn read(path: &Path, size: usize, options: &SourceOptions<'_>) -> Result<Mask> {
    let named = || path.display().to_string();
    let file = File::open(path).map_err(|e| catamaran::Error::io(path, e))?;
    let file = BufReader::new(file);
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().with_context(named)?;
    let (width, height) = (reader.info().width, reader.info().height);
    let bytes = reader.output_buffer_size().unwrap_or(usize::MAX);
    let what = format_args!("{width} x {height} pixels");
    options.check_memory(path, what, bytes as u64)?;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(bytes).with_context(named)?;
    pixels.resize(bytes, 0);
    let info = reader.next_frame(&mut pixels).with_context(named)?;
    let samples = info.color_type.samples();
    if samples < 3 {
        anyhow::bail!("{}: a mask needs red, green and blue; this picture is grey", named());
    }
    let (width, height) = (info.width as usize, info.height as usize);
    let mut mask = Mask::default();
    for row in 0..size {
        let y = (2 * (size - 1 - row) + 1) * height / (2 * size);
        for column in 0..size {
            let x = (2 * column + 1) * width / (2 * size);
            let at = (y * width + x) * samples;
            let [red, green, blue] = [0, 1, 2].map(|c| pixels[at + c] > HALF);
            mask.start.push(red);
            mask.ground.push(match (green, blue) {
                (true, _) => OBSTACLE,
                (false, true) => GOAL,
                (false, false) => FREE,
            });
        }
    }
    if !mask.start.contains(&true) {
        mask.start.clear();
    }
    Ok(mask)
}
