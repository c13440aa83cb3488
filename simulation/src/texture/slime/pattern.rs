use catamaran::base::Sets;
use catamaran::base::{Error, Result};

/// Measures of the pattern in a square texture, in texels. Texels with more pheromone than a
/// threshold are covered; texels are connected over sides. The measures apply to a surface where
/// its texture has little distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pattern {
    /// The share of the texture that is covered.
    pub covered: f64,
    /// The mean width of covered regions: twice their area divided by their perimeter.
    pub thickness: f64,
    /// The mean width of the uncovered regions: the scale of the pattern.
    pub gap: f64,
    /// The mean area of the covered patches, weighted by area: the mean size of the patch of a
    /// covered texel.
    pub cluster: f64,
    /// The mean area of the uncovered cells, with the same weights.
    pub cell: f64,
    /// The number of cells of more than 20 texels.
    pub cells: usize,
}

/// Cells of at most this number of texels are noise.
const SMALLEST_CELL: usize = 20;

impl Pattern {
    /// Computes the measures of a texture with `size` rows and columns.
    ///
    /// ```
    /// use catamaran_simulation::texture::slime::Pattern;
    ///
    /// // Stripes of 8 texels, of which every other one is covered.
    /// let texture: Vec<f32> = (0..64 * 64).map(|t| (t / 8 % 2) as f32).collect();
    /// let pattern = Pattern::of(&texture, 64, 0.5)?;
    /// assert_eq!((pattern.covered, pattern.cells), (0.5, 4));
    /// assert_eq!((pattern.cluster, pattern.cell), (512.0, 512.0));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Shape`] unless the texture has `size` times `size` values.
    pub fn of(texture: &[f32], size: usize, threshold: f32) -> Result<Self> {
        Error::check_shape("texture", (size.saturating_mul(size), 1), (texture.len(), 1))?;
        let covered: Vec<bool> = texture.iter().map(|&p| p > threshold).collect();
        let mut sets = Sets::new(covered.len());
        let mut perimeter = 0_usize;
        for t in 0..covered.len() {
            let right = (t % size + 1 < size).then_some(t + 1);
            let below = (t + size < covered.len()).then_some(t + size);
            for other in [right, below].into_iter().flatten() {
                if covered[t] == covered[other] {
                    sets.join(t as u32, other as u32);
                } else {
                    perimeter += 1;
                }
            }
        }
        let mut areas = vec![0_usize; covered.len()];
        for t in 0..covered.len() as u32 {
            areas[sets.find(t) as usize] += 1;
        }
        let count = covered.iter().filter(|&&c| c).count();
        let mean = |wanted: bool, total: usize| {
            let own = areas.iter().zip(&covered).filter(|(_, c)| **c == wanted);
            own.map(|(&a, _)| (a * a) as f64).sum::<f64>() / total.max(1) as f64
        };
        let rest = covered.len() - count;
        let width = |area: usize| 2.0 * area as f64 / perimeter.max(1) as f64;
        let is_cell = |(area, covered): &(&usize, &bool)| !**covered && **area > SMALLEST_CELL;
        Ok(Self {
            covered: count as f64 / covered.len().max(1) as f64,
            thickness: width(count),
            gap: width(rest),
            cluster: mean(true, count),
            cell: mean(false, rest),
            cells: areas.iter().zip(&covered).filter(is_cell).count(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripes_have_their_widths() {
        // Stripes of 3 covered rows and 5 others.
        let size = 32;
        let texture: Vec<f32> =
            (0..size * size).map(|t| if t / size % 8 < 3 { 0.5 } else { 0.0 }).collect();
        let p = Pattern::of(&texture, size, 0.1).unwrap();
        assert_eq!((p.covered, p.cluster, p.cell, p.cells), (0.375, 96.0, 160.0, 4));
        // The perimeter is seven sides of 32 texels, because one stripe ends at the border.
        assert_eq!((p.thickness, p.gap), (768.0 / 224.0, 1280.0 / 224.0));
        let empty = Pattern::of(&[], 0, 0.1).unwrap();
        assert_eq!((empty.covered, empty.cells), (0.0, 0));
    }

    #[test]
    fn a_texture_of_another_size_is_refused() {
        for count in [0, 15, 17, 19, 20] {
            let refused = Pattern::of(&vec![0.0; count], 4, 0.1).unwrap_err();
            let expected = Error::Shape { what: "texture", expected: (16, 1), got: (count, 1) };
            assert_eq!(refused, expected);
        }
        assert!(Pattern::of(&[0.0], 0, 0.1).is_err());
    }
}
