//! Finishes for materials over a fractal.

use super::palette::root_color;
use crate::texture::material::Finish;
use catamaran::base::{Error, Result, builder, within};

/// The finishes of the basins of a fractal on a surface, and of the joints between them.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Inlay {
    /// The finishes of the roots, by number; they repeat when there are more roots.
    pub basins: Vec<Finish>,
    /// The finish of the joints, where points converge slowly.
    pub joint: Finish,
    /// The shares of texels, ordered by the speed of convergence, at which joints begin and at
    /// which they are complete; from 0 to 1. Default 0.75, 0.95.
    pub range: [f64; 2],
    /// The height that a value of 1 stands for, in hundredths of the square root of the area of the
    /// surface, from 0 to 100. Default 0.4.
    pub depth: f64,
}

impl Default for Inlay {
    /// Returns the stones of [`Inlay::stones`].
    fn default() -> Self {
        Self::stones()
    }
}

builder! { Inlay {
    #[into]
    basins: Vec<Finish>,
    joint: Finish,
    range: [f64; 2],
    depth: f64,
}}

impl Inlay {
    /// Returns enamel in the colours of the roots of a polynomial with `roots` roots in C, between
    /// raised lines of gold (figure 7.1c).
    ///
    /// ```
    /// use catamaran_simulation::texture::newton::Inlay;
    ///
    /// assert_eq!(Inlay::enamel(3).basins.len(), 9);
    /// ```
    pub fn enamel(roots: usize) -> Self {
        let enamel = |root: usize| {
            Finish::new().color(root_color(root as u16, roots)).roughness(0.16).height(0.0)
        };
        let gold = Finish::new().color([255, 202, 96]).roughness(0.3).metalness(1.0).height(0.6);
        let basins = (0..roots * roots).map(enamel).collect();
        Self { basins, joint: gold, range: [0.75, 0.95], depth: 0.4 }
    }

    /// Returns marble, steel, wood, slate, copper and chalk, with dark rough joints between (figure
    /// 7.3).
    pub fn stones() -> Self {
        let finish = |color, roughness, metalness, height| {
            Finish::new().color(color).roughness(roughness).metalness(metalness).height(height)
        };
        let basins = vec![
            finish([236, 233, 226], 0.15, 0.0, 0.5),
            finish([180, 184, 192], 0.35, 1.0, 0.2),
            finish([142, 92, 52], 0.6, 0.0, 0.3),
            finish([62, 70, 82], 0.7, 0.0, 0.4),
            finish([236, 150, 108], 0.25, 1.0, 0.2),
            finish([208, 196, 170], 0.9, 0.0, 0.5),
        ];
        Self {
            basins,
            joint: finish([30, 28, 28], 1.0, 0.0, -0.8),
            range: [0.75, 0.95],
            depth: 0.4,
        }
    }

    /// Returns an error unless every number is in its range.
    pub(super) fn check(&self) -> Result<()> {
        for finish in self.basins.iter().chain([&self.joint]) {
            finish.check(0.0)?;
        }
        if self.basins.is_empty() {
            let why = "must have at least one finish".into();
            return Err(Error::Argument { what: "basins", why });
        }
        within("depth", self.depth, 0.0, 100.0)?;
        let [low, high] = self.range;
        within("range", low, 0.0, 1.0)?;
        within("range", high, low, 1.0)
    }
}
