use super::texels::Texels;
use crate::base::Par;

/// How much of the surface a species covers (equation 3.2 of the thesis), each texel counted by what it covers of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coverage {
    /// The mean of the pheromone, from 0 to 1.
    pub coverage: f64,
    /// The part of the surface with any, from 0 to 1.
    pub presence: f64,
}

/// Texels summed by one thread at a time.
const BLOCK: usize = 1 << 16;

/// That of one species.
pub(super) fn coverage(texels: &Texels, texture: &[f32], par: Par) -> Coverage {
    let sums = par.map_blocks(texture.len(), BLOCK, |range| {
        let mut sum = Coverage::default();
        for (&p, &area) in texture[range.clone()].iter().zip(&texels.areas()[range]) {
            let area = f64::from(area);
            sum.coverage += f64::from(p) * area;
            sum.presence += if p > 0.0 { area } else { 0.0 };
        }
        sum
    });
    sums.into_iter().fold(Coverage::default(), |a, b| Coverage {
        coverage: a.coverage + b.coverage,
        presence: a.presence + b.presence,
    })
}
