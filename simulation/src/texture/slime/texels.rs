use super::kinds::OUTSIDE;
use super::links::{Links, beyond, links};
use super::raster::{Raster, raster};
use super::surface::{NO_TRIANGLE, Surface};
use super::walk::Walker;
use catamaran::base::{Result, reserved};

/// The relation of the texels of a texture to the surface.
///
/// Memory: 9 bytes for each texel, 8.25 bytes for each texel and species for the textures, and
/// about 32 bytes for each texel at a seam. For one species this is 72 MiB at 2048 x 2048 and 4.6
/// GB at 16384 x 16384.
#[derive(Debug, Clone)]
pub struct Texels {
    size: usize,
    owners: Vec<u32>,
    areas: Vec<f32>,
    kinds: Vec<u8>,
    links: Links,
    overlapping: Vec<u32>,
}

impl Texels {
    /// Finds the texels of a texture of `size` x `size` texels, at least 2, on a surface.
    ///
    /// ```
    /// use catamaran_simulation::texture::slime::{Surface, Texels};
    ///
    /// let texels = Texels::new(&Surface::tile()?, 32)?;
    /// assert!((texels.areas().iter().sum::<f32>() - 1.0).abs() < 1e-3);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfMemory`](catamaran::Error::OutOfMemory).
    pub fn new(surface: &Surface, size: usize) -> Result<Self> {
        let Raster { owners, areas, overlapping } = raster(surface, size)?;
        let mut kinds = zeros_of_kind(size)?;
        let links = links(surface, size, &owners, &mut kinds)?;
        Ok(Self { size, owners, areas, kinds, links, overlapping })
    }

    /// Returns the number of texels of a side.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Returns the triangle of each texel: the triangle that contains the centre of the texel,
    /// otherwise the lowest triangle that touches it; [`NO_TRIANGLE`] outside.
    pub fn owners(&self) -> &[u32] {
        &self.owners
    }

    /// Returns the share of the surface that each texel covers; the sum is 1.
    pub fn areas(&self) -> &[f32] {
        &self.areas
    }

    /// Returns the triangles that overlap others in the texture, ascending: the centre of a texel
    /// is in both. They share the trails of agents.
    pub fn overlapping(&self) -> &[u32] {
        &self.overlapping
    }

    /// Returns [`OUTSIDE`], [`INSIDE`](super::INSIDE) or [`BORDER`](super::BORDER) for each texel.
    pub fn kinds(&self) -> &[u8] {
        &self.kinds
    }

    /// Returns the texels of kind [`BORDER`](super::BORDER), ascending.
    pub fn border(&self) -> &[u32] {
        &self.links.texels
    }

    /// Returns for each of [`Texels::border`] the index of its first link, and at last the end of
    /// the last link.
    pub fn link_starts(&self) -> &[u32] {
        &self.links.starts
    }

    /// Returns the texels with which border texels exchange pheromone, link by link.
    pub fn links(&self) -> &[u32] {
        &self.links.links
    }

    /// Returns the weight of each link, the same in both directions.
    pub fn link_weights(&self) -> &[f32] {
        &self.links.weights
    }

    /// Returns the position at the end of a step of `step` texels along u and v from the centre of
    /// a texel (or from the point of its triangle nearest to the centre). The step is taken on the
    /// surface, across seams if needed; `None` for a texel outside. Boundary edges reflect.
    ///
    /// # Panics
    /// When the texel does not exist.
    pub fn beside(&self, surface: &Surface, texel: usize, step: [i32; 2]) -> Option<Walker> {
        let owner = self.owners[texel];
        (owner != NO_TRIANGLE).then(|| beyond(surface, self.size, owner, texel, step))
    }

    /// Returns the memory of the texels, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let links = &self.links;
        self.size * self.size * (size_of::<u32>() + size_of::<f32>() + size_of::<u8>())
            + 4 * (links.texels.len() + links.starts.len() + 2 * links.links.len())
    }

    /// Returns whether a texel is on the surface.
    pub(super) fn is_owned(&self, texel: usize) -> bool {
        self.owners[texel] != NO_TRIANGLE
    }
}

fn zeros_of_kind(size: usize) -> Result<Vec<u8>> {
    let mut kinds = reserved(size * size)?;
    kinds.resize(size * size, OUTSIDE);
    Ok(kinds)
}
