//! Fills the texels around the charts of a texture.

use super::slime::{OUTSIDE, Texels};
use catamaran::base::{Result, reserved};

/// Number of rings of texels around charts that are filled. Filters of renderers mix them in at
/// borders, and so do smaller copies of a texture (mipmaps) down to a sixteenth of its side.
const RINGS: usize = 16;

/// Returns for each texel the texel whose value it takes: itself on the surface, otherwise the
/// nearest texel of a chart, up to 16 texels away (diagonal steps count as one), and itself farther
/// away. Without such a margin, filters of renderers mix texels outside of the surface into texels
/// on it.
///
/// ```
/// use catamaran_geometry::mesh::families;
/// use catamaran_simulation::texture::margin;
/// use catamaran_simulation::texture::slime::{OUTSIDE, Surface, Texels, atlas};
///
/// let sphere = families::icosphere(1)?;
/// let texels = Texels::new(&Surface::of_faces(&sphere, atlas(&sphere, 128)?)?, 128)?;
/// let shown = margin(&texels)?;
/// let kind = |t: usize| texels.kinds()[t];
/// assert!((0..128 * 128).all(|t| kind(t) == OUTSIDE || shown[t] as usize == t));
/// assert_ne!(kind(shown[129] as usize), OUTSIDE);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory).
pub fn margin(texels: &Texels) -> Result<Vec<u32>> {
    let (size, kinds) = (texels.size(), texels.kinds());
    let mut shown: Vec<u32> = reserved(kinds.len())?;
    shown.extend(0..kinds.len() as u32);
    let mut reached: Vec<bool> = reserved(kinds.len())?;
    reached.extend(kinds.iter().map(|&kind| kind != OUTSIDE));
    let around = |t: usize| {
        let (i, j) = (t % size, t / size);
        let columns = i.saturating_sub(1)..=(i + 1).min(size - 1);
        let rows = j.saturating_sub(1)..=(j + 1).min(size - 1);
        rows.flat_map(move |j| columns.clone().map(move |i| j * size + i))
    };
    let is_rim = |t: &u32| around(*t as usize).any(|n| kinds[n] == OUTSIDE);
    let mut rim: Vec<u32> =
        (0..kinds.len() as u32).filter(|t| kinds[*t as usize] != OUTSIDE && is_rim(t)).collect();
    for _ in 0..RINGS {
        let mut next = Vec::new();
        for &t in &rim {
            for n in around(t as usize) {
                if !std::mem::replace(&mut reached[n], true) {
                    shown[n] = shown[t as usize];
                    next.push(n as u32);
                }
            }
        }
        rim = next;
    }
    Ok(shown)
}
