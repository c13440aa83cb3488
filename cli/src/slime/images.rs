//! Textures as PNG, with v upwards as programs expect it, and masks from PNG.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context, Result};
use catamaran::io::Output;
use catamaran::texture::slime::{FREE, GOAL, Mask, OBSTACLE, Simulation};

use crate::input;

/// Above this a channel of a mask counts.
const HALF: u8 = 127;

/// The names of the pictures of a frame, without their ending's dot: species in the channels of one, or one each when there
/// are more than three.
pub fn names(stem: &str, species: usize) -> Vec<String> {
    match species {
        1..=3 => vec![format!("{stem}.png")],
        _ => (0..species).map(|s| format!("{stem}-species{s}.png")).collect(),
    }
}

/// Writes the textures to files of these [`names`].
pub fn write(simulation: &Simulation, outputs: Vec<Output>) -> Result<()> {
    let species = simulation.species();
    if species > 3 {
        for (s, output) in outputs.into_iter().enumerate() {
            write_one(simulation, output, png::ColorType::Grayscale, &[Some(s)])?;
        }
        return Ok(());
    }
    for output in outputs {
        if species == 1 {
            write_one(simulation, output, png::ColorType::Grayscale, &[Some(0)])?;
        } else {
            let channels = [0, 1, 2].map(|s| (s < species).then_some(s));
            write_one(simulation, output, png::ColorType::Rgb, &channels)?;
        }
    }
    Ok(())
}

fn write_one(
    simulation: &Simulation,
    mut output: Output,
    color: png::ColorType,
    channels: &[Option<usize>],
) -> Result<()> {
    let size = simulation.texels().size();
    let mut bytes = Vec::with_capacity(size * size * channels.len());
    for row in (0..size).rev() {
        for texel in row * size..(row + 1) * size {
            bytes.extend(channels.iter().map(|channel| {
                channel.map_or(0, |s| (255.0 * simulation.texture(s)[texel]).round() as u8)
            }));
        }
    }
    let name = output.path().display().to_string();
    let mut encode = || -> Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(&mut output, size as u32, size as u32);
        encoder.set_color(color);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()
    };
    encode().with_context(|| format!("{name}: can't be written"))?;
    Ok(output.commit()?)
}

/// A mask: red where agents start, green where they can't go, blue where they want to be (thesis, figure 3.9). Of any size:
/// texels take the pixel at their centre.
pub fn read_mask(path: &Path, size: usize) -> Result<Mask> {
    let named = || path.display().to_string();
    let file = BufReader::new(File::open(path).with_context(named)?);
    let mut decoder = png::Decoder::new(file);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().with_context(named)?;
    let (width, height) = (reader.info().width, reader.info().height);
    let bytes = reader.output_buffer_size().unwrap_or(usize::MAX);
    let what = format_args!("{width} x {height} pixels");
    input::source().check_memory(path, what, bytes as u64)?;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(bytes).with_context(named)?;
    pixels.resize(bytes, 0);
    let info = reader.next_frame(&mut pixels).with_context(named)?;
    let samples = info.color_type.samples();
    if samples < 3 {
        anyhow::bail!("{}: a mask has red, green and blue; this is grey", named());
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
