//! The middles of split edges, which all faces of an edge share.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::hash::BuildHasherDefault;

use super::batches::Multiply;
use crate::mesh::vector::{Vector, distance, middle};
use catamaran::base::{Error, Result, push, spend};

/// Operations that splitting an edge is equal to.
const SPLIT: f64 = 500.0;

/// The stretch of a mesh whose edges are split.
pub(super) struct Stretched {
    /// The factor at each vertex.
    factors: Vec<f64>,
    /// The vertices between which each new one is.
    pub origins: Vec<[u32; 4]>,
}

/// Returns the factor at a new vertex between these.
pub(super) fn mean_of(factors: &[f64], of: [u32; 4]) -> f64 {
    0.25 * of.iter().map(|&v| factors[v as usize]).sum::<f64>()
}

/// The vertices of a mesh whose edges are split in their middle until none is longer than a bound.
pub(super) struct Splits {
    pub vertices: Vec<Vector>,
    /// The longest edge that stays.
    pub longest: f64,
    /// The factors by which lengths are stretched; `None` without a density.
    pub stretched: Option<Stretched>,
    /// By the lower end, shifted by 32 bits, and the upper one.
    middles: HashMap<u64, u32, BuildHasherDefault<Multiply>>,
    /// Whether middles are needed in later rounds: the side of a strip is split to the end at
    /// once, and the other face of that side may be split once a round.
    keeps: bool,
}

impl Splits {
    /// Creates the state before the first round.
    pub fn new(vertices: Vec<Vector>, longest: f64, stretch: Option<&[f64]>) -> Self {
        let stretched =
            stretch.map(|factors| Stretched { factors: factors.to_vec(), origins: Vec::new() });
        Self { vertices, longest, stretched, middles: HashMap::default(), keeps: false }
    }

    /// Forgets the middles of edges that no face has any more.
    pub fn next_round(&mut self) {
        if !self.keeps {
            self.middles.clear();
        }
    }

    /// Returns the position of v.
    pub fn position(&self, v: u32) -> Vector {
        self.vertices[v as usize]
    }

    /// Returns the length of the edge from u to v.
    pub fn length(&self, u: u32, v: u32) -> f64 {
        distance(self.position(u), self.position(v))
    }

    /// Returns whether the edge from u to v has to be split. Ends between which there is no number
    /// stay as they are.
    pub fn is_long(&self, u: u32, v: u32) -> bool {
        let ends = [u, v].map(|w| self.position(w));
        distance(ends[0], ends[1]) * self.stretch_of(&[u, v]) > self.longest
            && !ends.contains(&middle(ends[0], ends[1]))
    }

    /// Returns the mean factor of lengths at these vertices.
    pub fn stretch_of(&self, vertices: &[u32]) -> f64 {
        self.stretched.as_ref().map_or(1.0, |stretched| {
            let sum: f64 = vertices.iter().map(|&v| stretched.factors[v as usize]).sum();
            sum / vertices.len() as f64
        })
    }

    /// Returns whether an edge of the face has to be split.
    pub fn has_long(&self, [a, b, c]: [u32; 3]) -> bool {
        self.is_long(a, b) || self.is_long(b, c) || self.is_long(c, a)
    }

    /// Returns the middles of the edges of a face that have to be split.
    ///
    /// # Errors
    /// As [`Splits::add`].
    pub fn middles_of(&mut self, [a, b, c]: [u32; 3]) -> Result<[Option<u32>; 3]> {
        let mut middles = [None; 3];
        for (middle, (u, v)) in middles.iter_mut().zip([(a, b), (b, c), (c, a)]) {
            if self.is_long(u, v) {
                *middle = Some(self.middle(u, v)?);
            }
        }
        Ok(middles)
    }

    /// Returns the vertices of the edge from u to v when it is split to the end: both ends, and
    /// those between.
    ///
    /// # Errors
    /// As [`Splits::add`].
    pub fn chain(&mut self, u: u32, v: u32) -> Result<Vec<u32>> {
        self.keeps = true;
        let mut chain = vec![u];
        let mut ends = vec![v];
        while let Some(&next) = ends.last() {
            let here = chain[chain.len() - 1];
            if self.is_long(here, next) {
                push(&mut ends, self.middle(here, next)?)?;
            } else {
                push(&mut chain, next)?;
                ends.pop();
            }
        }
        Ok(chain)
    }

    fn middle(&mut self, u: u32, v: u32) -> Result<u32> {
        let edge = u64::from(u.min(v)) << 32 | u64::from(u.max(v));
        let refused = |_| Error::OutOfMemory { bytes: 3 * size_of::<[u32; 3]>() };
        self.middles.try_reserve(1).map_err(refused)?;
        let new = match self.middles.entry(edge) {
            Entry::Occupied(known) => return Ok(*known.get()),
            Entry::Vacant(new) => new,
        };
        let number = add(&mut self.vertices, &mut self.stretched, &[u, v])?;
        Ok(*new.insert(number))
    }

    /// Adds the mean of these vertices, and returns its index.
    ///
    /// # Errors
    /// [`Error::Argument`] when there are too many vertices, [`Error::OutOfMemory`],
    /// [`Error::Cancelled`].
    pub fn add(&mut self, of: &[u32]) -> Result<u32> {
        add(&mut self.vertices, &mut self.stretched, of)
    }
}

fn add(vertices: &mut Vec<Vector>, stretched: &mut Option<Stretched>, of: &[u32]) -> Result<u32> {
    spend(SPLIT)?;
    let number = u32::try_from(vertices.len()).ok().filter(|&number| number < u32::MAX / 8);
    let Some(number) = number else {
        let why = "is too small: there would be 2^29 vertices".into();
        return Err(Error::Argument { what: "longest", why });
    };
    let share = 1.0 / of.len() as f64;
    let mean = |k: usize| of.iter().map(|&v| share * vertices[v as usize][k]).sum::<f64>();
    let mean = std::array::from_fn(mean);
    push(vertices, mean)?;
    if let Some(Stretched { factors, origins }) = stretched {
        // All of four, or both of two twice.
        let of = std::array::from_fn(|k| of[k % of.len()]);
        push(factors, mean_of(factors, of))?;
        push(origins, of)?;
    }
    Ok(number)
}
