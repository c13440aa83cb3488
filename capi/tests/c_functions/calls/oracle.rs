//! What a product must be: plain loops in twice the precision, and how far a result may be away.

/// Returns the sum of products, as if in twice the precision; with NaN or infinities what a plain
/// loop gives.
pub fn dot(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut plain, mut high, mut low) = (0.0, 0.0, 0.0);
    for (x, y) in pairs {
        let product: f64 = x * y;
        plain += product;
        let sum = high + product;
        let back = sum - high;
        low += (high - (sum - back)) + (product - back) + x.mul_add(y, -product);
        high = sum;
    }
    if plain.is_finite() { high + low } else { plain }
}

pub fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|x| x * x).sum::<f64>().sqrt()
}

/// `alpha sum + beta old`, of which the sum may be wrong by `bound`.
#[derive(Debug, Clone, Copy)]
pub struct Expected {
    pub alpha: f64,
    pub sum: f64,
    pub beta: f64,
    pub old: f64,
    pub bound: f64,
    /// Whether NaN and infinities are those of plain loops; else an entry that has one there has
    /// any, and the others are not compared.
    pub as_loops: bool,
    /// Whether some entry of the inputs is NaN or infinite.
    pub spread: bool,
    /// Half the distance of 1 to the next number.
    pub unit: f64,
    /// What underflow may take from a sum.
    pub tiny: f64,
}

impl Expected {
    /// Returns whether a result is right.
    pub fn allows(&self, got: f64) -> bool {
        let &Self { alpha, sum, beta, old, .. } = self;
        let product = if alpha == 0.0 { 0.0 } else { alpha * sum };
        let rest = if beta == 0.0 { 0.0 } else { beta * old };
        let exact = product + rest;
        if !exact.is_finite() {
            return match self.as_loops || !self.spread {
                true => got == exact || (got.is_nan() && exact.is_nan()),
                false => !got.is_finite(),
            };
        }
        if self.spread && !self.as_loops && alpha != 0.0 {
            return true;
        }
        let rounding = 4.0 * self.unit * (product.abs() + rest.abs());
        let tiny = self.tiny * (1.0 + alpha.abs() + beta.abs());
        let bound = if alpha == 0.0 { 0.0 } else { alpha.abs() * self.bound };
        (got - exact).abs() <= bound + rounding + tiny
    }
}
