//! Textures as PNG, with v upwards as programs expect it.

use anyhow::Result;
use catamaran::io::Output;
use catamaran_geometry::mesh::io::Picture;
use catamaran_simulation::texture::slime::Simulation;

/// Returns the names of the pictures of a frame: species in the channels of one picture, or one
/// picture for each species when there are more than three.
pub fn names(stem: &str, species: usize) -> Vec<String> {
    match species {
        1..=3 => vec![format!("{stem}.png")],
        _ => (0..species).map(|s| format!("{stem}-species{s}.png")).collect(),
    }
}

/// Writes the textures to files of these [`names`].
pub fn write(simulation: &Simulation, outputs: Vec<Output>) -> Result<()> {
    let (species, size) = (simulation.species(), simulation.texels().size());
    let byte = |s: usize, texel: usize| (255.0 * simulation.texture(s)[texel]).round() as u8;
    let gray = |s: usize| {
        let pixels: Vec<u8> = (0..size * size).map(|texel| byte(s, texel)).collect();
        Picture::gray(size, &pixels)
    };
    if matches!(species, 2 | 3) {
        let pixel = |texel: usize| [0, 1, 2].map(|s| if s < species { byte(s, texel) } else { 0 });
        let pixels: Vec<[u8; 3]> = (0..size * size).map(pixel).collect();
        let picture = Picture::rgb(size, &pixels)?;
        return outputs.into_iter().try_for_each(|output| save(output, picture.clone()));
    }
    outputs.into_iter().enumerate().try_for_each(|(s, output)| save(output, gray(s)?))
}

/// Writes a texture, whose rows are from v = 0, and completes the file.
pub fn save(mut output: Output, texture: Picture) -> Result<()> {
    texture.flipped().write_png(&mut output).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}
