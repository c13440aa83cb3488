use super::texels::Texels;
use crate::base::Par;

/// How much of the surface a species covers (equation 3.2 of the thesis), each texel counted by
/// what it covers of it: to 1e-5.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coverage {
    /// The mean of the pheromone, from 0 to 1.
    pub coverage: f64,
    /// The part of the surface with any, from 0 to 1.
    pub presence: f64,
}

/// Sums are of whole numbers, so that they are the same in any order: so many units are the area of
/// the surface.
pub(crate) const AREA_UNIT: f32 = (1_u64 << 46) as f32;
/// So many are a pheromone of 1; the product of both has room in 64 bits.
pub(crate) const PHEROMONE_UNIT: f32 = (1_u64 << 16) as f32;

/// Texels summed by one thread at a time.
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

/// Returns the sum of sums.
pub(crate) fn sum_of(parts: impl IntoIterator<Item = Sums>) -> Sums {
    parts.into_iter().fold([0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]])
}

/// Computes the coverage of one species.
pub(super) fn coverage(texels: &Texels, texture: &[f32], par: Par) -> Coverage {
    let parts = par.map_blocks(texture.len(), BLOCK, |range| {
        let both = texture[range.clone()].iter().zip(&texels.areas()[range]);
        sum_of(both.map(|(&pheromone, &area)| {
            // Processors have conversions to signed numbers.
            let area = (area * AREA_UNIT) as i64 as u64;
            let present = if pheromone > 0.0 { area } else { 0 };
            [area * (pheromone * PHEROMONE_UNIT + 0.5) as i32 as u64, present]
        }))
    });
    sum_of(parts).into()
}
