use super::super::slots::{self, NONE, next, previous};
use super::complex::Complex;
use super::element::{Element, area};
use catamaran::base::{Error, Result, spend};

/// A sum of two weights that is negative by less than this, relative to 1 and to their sizes, is
/// zero up to rounding.
pub(crate) const ROUNDING: f64 = 1e-10;

/// Number of flips for each edge, on average, after which the algorithm stops with an error. In
/// exact arithmetic it terminates.
const MOST_FLIPS: usize = 1000;

/// Operations to decide about an edge: two triangles from their lengths.
const EXAMINED: f64 = 100.0;

/// Returns whether an edge with these weights from its two sides has a negative weight, beyond
/// rounding.
fn is_negative(v: f64, w: f64) -> bool {
    v + w < -ROUNDING * (1.0 + v.abs() + w.abs())
}

impl Complex {
    /// Replaces edges with a negative weight by the other diagonal of their two triangles, unfolded
    /// into a plane, until none is left (Bobenko and Springborn 2007, section 2.3).
    pub(super) fn flip_to_delaunay(&mut self) -> Result<()> {
        let slots = self.twins.len() as u32;
        let most = MOST_FLIPS.saturating_mul(self.twins.len());
        let mut flips = 0;
        let mut waiting = Vec::new();
        for first in 0..slots {
            waiting.push(first);
            while let Some(slot) = waiting.pop() {
                spend(EXAMINED)?;
                if !self.must_flip(slot) || !self.flip(slot) {
                    continue;
                }
                flips += 1;
                if flips > most {
                    let residual = self.element(slot).weights[slot as usize % 3];
                    return Err(Error::NotConverged { iterations: flips, residual });
                }
                // The flip gave the other sides of the quadrilateral new triangles.
                let f = slot / 3;
                let g = self.twins[3 * f as usize] / 3;
                waiting.extend([3 * f + 1, 3 * f + 2, 3 * g + 1, 3 * g + 2]);
            }
        }
        Ok(())
    }

    fn element(&self, slot: u32) -> Element {
        Element::of_lengths(self.lengths[slot as usize / 3])
    }

    fn must_flip(&self, slot: u32) -> bool {
        let twin = self.twins[slot as usize];
        // An edge with the same triangle on both sides is opposite to two of its angles, whose sum
        // is less than pi.
        if twin == NONE || twin / 3 == slot / 3 {
            return false;
        }
        let weight = |s: u32| self.element(s).weights[s as usize % 3];
        is_negative(weight(slot), weight(twin))
    }

    /// Flips an interior edge; afterwards it is slot 0 of the same two triangles. Returns false,
    /// without a change, where rounding would leave a triangle without area.
    fn flip(&mut self, slot: u32) -> bool {
        let twin = self.twins[slot as usize];
        let (f, g) = (slot / 3, twin / 3);
        // Triangles (i, j, k) and (j, i, l), with the edge i j in common.
        let sides = [next(slot), previous(slot), next(twin), previous(twin)];
        let [a_jk, a_ki, a_il, a_lj] = sides.map(|s| self.length(s));
        let common = self.length(slot);
        // i is at the origin, j on the positive axis, k above it, l below.
        let along = |to_i: f64, to_j: f64| {
            (common * common + (to_i - to_j) * (to_i + to_j)) / (2.0 * common)
        };
        let above = 2.0 * area(self.lengths[f as usize]) / common;
        let below = 2.0 * area(self.lengths[g as usize]) / common;
        let flipped = (along(a_ki, a_jk) - along(a_il, a_lj)).hypot(above + below);
        let (first, second) = ([flipped, a_lj, a_jk], [flipped, a_ki, a_il]);
        if !(area(first) > 0.0 && area(second) > 0.0) {
            return false;
        }
        slots::flip(&mut self.faces, &mut self.twins, slot);
        self.lengths[f as usize] = first;
        self.lengths[g as usize] = second;
        true
    }
}
