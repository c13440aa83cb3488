//! Textures as PNG, with v upwards as programs expect it.

use anyhow::{Context, Result};
use catamaran::io::Output;
use catamaran::texture::slime::Simulation;

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
