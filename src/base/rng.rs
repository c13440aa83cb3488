use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng as _, SeedableRng};

/// A seeded generator (xoshiro256++, Blackman and Vigna 2021). The same seed gives the same numbers
/// in every version of this crate and on every machine, except that [`Rng::normal`] rounds as the
/// machine's logarithm and cosine do.
///
/// ```
/// use catamaran::base::Rng;
///
/// let (mut a, mut b) = (Rng::new(7), Rng::new(7));
/// assert_eq!(a.bits(), b.bits());
/// assert!((0.0..1.0).contains(&a.uniform()));
/// assert_eq!(a.sign().abs(), 1.0);
/// ```
#[derive(Debug, Clone)]
pub struct Rng(Xoshiro256PlusPlus);

impl Rng {
    /// Creates a generator from `seed`.
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Returns a number from the uniform distribution on `[0, 1)`, a multiple of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Returns a number from the standard normal distribution (Box and Muller 1958).
    ///
    /// ```
    /// use catamaran::base::Rng;
    ///
    /// let mut rng = Rng::new(0);
    /// let mean = (0..10_000).map(|_| rng.normal()).sum::<f64>() / 1e4;
    /// assert!(mean.abs() < 0.05);
    /// ```
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Returns +1 or -1, each with probability 1/2.
    pub fn sign(&mut self) -> f64 {
        if self.bits() >> 63 == 0 { 1.0 } else { -1.0 }
    }
}
