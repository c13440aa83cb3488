use super::texels::Texels;
use catamaran::base::Par;

/// The coverage of the surface by a species (equation 3.2 of the thesis). Each texel is weighted by
/// the area that it covers, to 1e-5.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coverage {
    /// The mean of the pheromone, from 0 to 1.
    pub coverage: f64,
    /// The share of the surface with any pheromone, from 0 to 1.
    pub presence: f64,
}

/// The area of the surface in units of the sums. Sums are of whole numbers, so that they do not
/// depend on the order.
pub(crate) const AREA_UNIT: f32 = (1_u64 << 46) as f32;
/// A pheromone of 1 in units of the sums; the product of both fits 64 bits.
pub(crate) const PHEROMONE_UNIT: f32 = (1_u64 << 16) as f32;

/// Number of texels that one thread sums at a time.
const BLOCK: usize = 1 << 16;

/// Pheromone and presence in whole units.
pub(crate) type Sums = [u64; 2];

impl From<Sums> for Coverage {
    fn from([pheromone, presence]: Sums) -> Self {
        let area = f64::from(AREA_UNIT);
        Self {
            coverage: pheromone as f64 / (area * f64::from(PHEROMONE_UNIT)),
            presence: presence as f64 / area,
        }
    }
}

/// Adds up partial sums.
pub(crate) fn sum_of(parts: impl IntoIterator<Item = Sums>) -> Sums {
    parts.into_iter().fold([0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]])
}

/// Computes the coverage of one species.
pub(super) fn coverage(texels: &Texels, texture: &[f32], par: Par) -> Coverage {
    let parts = par.map_blocks(texture.len(), BLOCK, |range| {
        let both = texture[range.clone()].iter().zip(&texels.areas()[range]);
        sum_of(both.map(|(&pheromone, &area)| {
            // Processors have instructions for conversions to signed integers.
            let area = (area * AREA_UNIT) as i64 as u64;
            let present = if pheromone > 0.0 { area } else { 0 };
            [area * (pheromone * PHEROMONE_UNIT + 0.5) as i32 as u64, present]
        }))
    });
    sum_of(parts).into()
}
