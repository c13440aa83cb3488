//! Textures as PNG, with v upwards as programs expect it.

use anyhow::Result;
use catamaran::io::Output;
use catamaran_geometry::mesh::io::Picture;

/// The most species that are the channels of one picture.
pub const CHANNELS: usize = 3;

/// Returns the names of the pictures of a frame: species in the channels of one picture, or one
/// picture for each species when there are more than [`CHANNELS`].
pub fn names(stem: &str, species: usize) -> Vec<String> {
    match species {
        1..=CHANNELS => vec![format!("{stem}.png")],
        _ => (0..species).map(|s| format!("{stem}-species{s}.png")).collect(),
    }
}

/// Writes the textures of species, as bytes of `size` texels a row, to files of these [`names`].
pub fn write(frame: &[Vec<u8>], size: usize, outputs: Vec<Output>) -> Result<()> {
    if matches!(frame.len(), 2 | 3) {
        let byte = |s: usize, texel: usize| frame.get(s).map_or(0, |species| species[texel]);
        let pixel = |texel: usize| [0, 1, 2].map(|s| byte(s, texel));
        let pixels: Vec<[u8; 3]> = (0..size * size).map(pixel).collect();
        let picture = Picture::rgb(size, &pixels)?;
        return outputs.into_iter().try_for_each(|output| save(output, picture.clone()));
    }
    let mut pairs = outputs.into_iter().zip(frame);
    pairs.try_for_each(|(output, species)| save(output, Picture::gray(size, species)?))
}

/// Writes a texture, whose rows are from v = 0, and completes the file.
pub fn save(mut output: Output, texture: Picture) -> Result<()> {
    texture.flipped().write_png(&mut output).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}
