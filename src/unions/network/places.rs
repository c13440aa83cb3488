use std::ops::Range;

use super::{FEATURES, K};
use crate::base::{Error, Result};

/// The sizes of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Architecture {
    /// Numbers that stand for a token; thesis: 32.
    pub width: usize,
    /// Attention heads, a divisor of the width; thesis: 8.
    pub heads: usize,
    /// Neurons of the feed-forward part of a layer; thesis: 64.
    pub hidden: usize,
    /// Layers of the first transformer, which sees one spectrum informed about the other; thesis: 6.
    pub first_layers: usize,
    /// Layers of the second transformer, which sees the sum of both; thesis: 3.
    pub second_layers: usize,
}

impl Default for Architecture {
    /// That of the thesis.
    fn default() -> Self {
        Self { width: 32, heads: 8, hidden: 64, first_layers: 6, second_layers: 3 }
    }
}

/// A matrix among the parameters, by rows; a vector is one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Its first element.
    pub start: usize,
    /// Its rows: inputs.
    pub rows: usize,
    /// Its columns: outputs.
    pub columns: usize,
}

impl Place {
    /// Its elements.
    pub fn range(&self) -> Range<usize> {
        self.start..self.start + self.rows * self.columns
    }
}

/// Where the parameters of a layer are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerPlaces {
    /// Scale and shift of the normalisation before attention.
    pub attention_norm: [Place; 2],
    /// Weights and bias of queries, keys and values, in this order.
    pub queries_keys_values: [Place; 2],
    /// Weights and bias after attention.
    pub mix: [Place; 2],
    /// Scale and shift of the normalisation before the feed-forward part.
    pub forward_norm: [Place; 2],
    /// Weights and bias into the hidden neurons.
    pub up: [Place; 2],
    /// Weights and bias out of them.
    pub down: [Place; 2],
}

/// Where the parameters of a network are in one array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places {
    /// One row for each position in the sequence.
    pub position: Place,
    /// From the features of a token.
    pub embedding: Place,
    /// The first transformer.
    pub first: Vec<LayerPlaces>,
    /// The second one.
    pub second: Vec<LayerPlaces>,
    /// Scale and shift of the last normalisation.
    pub norm: [Place; 2],
    /// Weights and bias of the one output of a token.
    pub head: [Place; 2],
    /// Name and place of every matrix, in their order.
    pub named: Vec<(String, Place)>,
    /// Number of parameters.
    pub len: usize,
}

impl Architecture {
    /// Refuses sizes that are no network.
    ///
    /// # Errors
    /// [`Error::Argument`] names the size.
    pub fn check(&self) -> Result<()> {
        let refuse = |what, why: &str| Err(Error::Argument { what, why: why.into() });
        if !(1..=1024).contains(&self.width) {
            return refuse("width", "must be from 1 to 1024");
        }
        if self.heads == 0 || !self.width.is_multiple_of(self.heads) {
            return refuse("heads", "must divide the width");
        }
        if !(1..=4096).contains(&self.hidden) {
            return refuse("hidden", "must be from 1 to 4096");
        }
        if self.first_layers > 64 || self.second_layers > 64 {
            return refuse("layers", "must be at most 64");
        }
        Ok(())
    }

    /// Where the parameters are.
    pub fn places(&self) -> Places {
        let Self { width, hidden, .. } = *self;
        let mut list = List::default();
        let position = list.add("position", K, width);
        let embedding = list.add("embedding", FEATURES, width);
        let mut layers = |name: &str, count: usize| -> Vec<LayerPlaces> {
            (0..count)
                .map(|layer| {
                    let mut linear = |part: &str, rows, columns| {
                        list.linear(&format!("{name}.{layer}.{part}"), rows, columns)
                    };
                    LayerPlaces {
                        attention_norm: linear("attention_norm", 1, width),
                        queries_keys_values: linear("queries_keys_values", width, 3 * width),
                        mix: linear("mix", width, width),
                        forward_norm: linear("forward_norm", 1, width),
                        up: linear("up", width, hidden),
                        down: linear("down", hidden, width),
                    }
                })
                .collect()
        };
        let first = layers("first", self.first_layers);
        let second = layers("second", self.second_layers);
        let norm = list.linear("norm", 1, width);
        let head = list.linear("head", width, 1);
        let List { named, len } = list;
        Places { position, embedding, first, second, norm, head, named, len }
    }
}

#[derive(Default)]
struct List {
    named: Vec<(String, Place)>,
    len: usize,
}

impl List {
    fn add(&mut self, name: &str, rows: usize, columns: usize) -> Place {
        let place = Place { start: self.len, rows, columns };
        self.len += rows * columns;
        self.named.push((name.to_owned(), place));
        place
    }

    /// Weights, and a bias for each column. (Of a normalisation: scale and shift.)
    fn linear(&mut self, name: &str, rows: usize, columns: usize) -> [Place; 2] {
        [
            self.add(&format!("{name}.weight"), rows, columns),
            self.add(&format!("{name}.bias"), 1, columns),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_one_another_without_gaps() {
        for (first_layers, second_layers) in [(0, 0), (1, 0), (2, 3)] {
            let sizes = Architecture { first_layers, second_layers, ..Architecture::default() };
            let places = sizes.places();
            let mut next = 0;
            for (_, place) in &places.named {
                assert_eq!(place.start, next);
                next = place.range().end;
            }
            assert_eq!(next, places.len);
            assert_eq!((places.first.len(), places.second.len()), (first_layers, second_layers));
        }
        // 24 of 32 + 9 layers of 4 32^2 + 2 32 64 + biases and norms + the last norm and the head.
        let layer = 4 * 32 * 32 + 2 * 32 * 64 + 4 * 32 + 64 + 32 + 4 * 32;
        assert_eq!(Architecture::default().places().len, 24 * 32 + 9 * layer + 64 + 33);
    }

    #[test]
    fn sizes_that_are_no_network_are_named() {
        let with = |width, heads, hidden| {
            let sizes = Architecture { width, heads, hidden, ..Architecture::default() };
            sizes.check().map_err(|e| e.to_string())
        };
        assert!(with(32, 8, 64).is_ok());
        assert!(with(0, 1, 64).unwrap_err().starts_with("width"));
        assert!(with(32, 5, 64).unwrap_err().starts_with("heads"));
        assert!(with(32, 0, 64).unwrap_err().starts_with("heads"));
        assert!(with(32, 8, 0).unwrap_err().starts_with("hidden"));
    }
}
