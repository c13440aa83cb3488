use std::ops::Range;

use super::{INPUTS, K};
use catamaran::base::{Error, Result};

/// The sizes of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Architecture {
    /// Length of the code of a spectrum, and of the union of parts.
    pub width: usize,
    /// Number of hidden neurons of a layer.
    pub hidden: usize,
    /// Number of layers of the encoder, which reads one spectrum.
    pub first_layers: usize,
    /// Number of layers of the decoder, which reads the sum over the parts.
    pub second_layers: usize,
    /// Number of coefficients of a region on a template.
    pub modes: usize,
}

impl Default for Architecture {
    /// Returns the architecture of the pretrained weights.
    fn default() -> Self {
        Self { width: 256, hidden: 512, first_layers: 2, second_layers: 2, modes: 128 }
    }
}

/// A matrix among the parameters, by rows; a vector has one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameter {
    /// Index of its first element.
    pub start: usize,
    /// Number of rows: inputs.
    pub rows: usize,
    /// Number of columns: outputs.
    pub columns: usize,
}

impl Parameter {
    /// Returns the range of the elements of the parameter.
    pub fn range(&self) -> Range<usize> {
        self.start..self.start + self.rows * self.columns
    }
}

/// The positions of the parameters of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerLayout {
    /// Scale and shift of the normalization before the layer.
    pub norm: [Parameter; 2],
    /// Weights and bias into the hidden neurons, then into their gates.
    pub up: [Parameter; 2],
    /// Weights and bias from the hidden neurons to the output.
    pub down: [Parameter; 2],
}

/// The positions of the parameters of a network in one array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterLayout {
    /// Weights and bias, from the features of a spectrum.
    pub embedding: [Parameter; 2],
    /// The encoder.
    pub first: Vec<LayerLayout>,
    /// The decoder.
    pub second: Vec<LayerLayout>,
    /// Scale and shift of the last normalization.
    pub norm: [Parameter; 2],
    /// Weights and bias of the K outputs.
    pub head: [Parameter; 2],
    /// Weights and bias of the region of the union.
    pub region: [Parameter; 2],
    /// Weights and bias of the out-of-distribution logit ("doubt" in files).
    pub ood_logit: [Parameter; 2],
    /// Scale and shift of the normalization after the encoder.
    pub part_norm: [Parameter; 2],
    /// Weights and bias of the region of each part.
    pub part_region: [Parameter; 2],
    /// Name and position of every matrix, in their order.
    pub named: Vec<(String, Parameter)>,
    /// Number of parameters.
    pub len: usize,
}

impl Architecture {
    /// Returns an error for invalid sizes.
    ///
    /// # Errors
    /// [`Error::Argument`] names the invalid size.
    pub fn check(&self) -> Result<()> {
        let ranges = [
            ("width", self.width, 1, 4096),
            ("hidden", self.hidden, 1, 4096),
            ("first_layers", self.first_layers, 0, 64),
            ("second_layers", self.second_layers, 0, 64),
            ("modes", self.modes, 1, 4096),
        ];
        for (what, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                let why = format!("must be from {least} to {most}, is {value}");
                return Err(Error::Argument { what, why });
            }
        }
        Ok(())
    }

    /// Returns the positions of the parameters.
    pub fn layout(&self) -> ParameterLayout {
        let Self { width, hidden, .. } = *self;
        let mut list = List::default();
        let embedding = list.linear("embedding", K * INPUTS, width);
        let mut layers = |name: &str, count: usize| -> Vec<LayerLayout> {
            (0..count)
                .map(|layer| LayerLayout {
                    norm: list.linear(&format!("{name}.{layer}.norm"), 1, width),
                    up: list.linear(&format!("{name}.{layer}.up"), width, 2 * hidden),
                    down: list.linear(&format!("{name}.{layer}.down"), hidden, width),
                })
                .collect()
        };
        let first = layers("first", self.first_layers);
        let second = layers("second", self.second_layers);
        let norm = list.linear("norm", 1, width);
        let head = list.linear("head", width, K);
        let region = list.linear("region", width, self.modes);
        let ood_logit = list.linear("doubt", width, 1);
        let part_norm = list.linear("part.norm", 1, width);
        let part_region = list.linear("part.region", width, self.modes);
        let List { named, len } = list;
        ParameterLayout {
            embedding,
            first,
            second,
            norm,
            head,
            region,
            ood_logit,
            part_norm,
            part_region,
            named,
            len,
        }
    }
}

#[derive(Default)]
struct List {
    named: Vec<(String, Parameter)>,
    len: usize,
}

impl List {
    /// Appends weights, and a bias for each column. (For a normalization: scale and shift.)
    fn linear(&mut self, name: &str, rows: usize, columns: usize) -> [Parameter; 2] {
        [("weight", rows), ("bias", 1)].map(|(part, rows)| {
            let parameter = Parameter { start: self.len, rows, columns };
            self.len += rows * columns;
            self.named.push((format!("{name}.{part}"), parameter));
            parameter
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_one_another_without_gaps() {
        for (first_layers, second_layers) in [(0, 0), (1, 0), (2, 3)] {
            let sizes = Architecture { width: 8, hidden: 6, first_layers, second_layers, modes: 5 };
            let layout = sizes.layout();
            let mut next = 0;
            for (_, parameter) in &layout.named {
                assert_eq!(parameter.start, next);
                next = parameter.range().end;
            }
            assert_eq!(next, layout.len);
            assert_eq!((layout.first.len(), layout.second.len()), (first_layers, second_layers));
            let layer = 2 * 8 + 8 * 12 + 12 + 6 * 8 + 8;
            let rest = 161 * 8 + 2 * 8 + 9 * 20 + 9 + 2 * 8 + 2 * 9 * 5;
            assert_eq!(layout.len, (first_layers + second_layers) * layer + rest);
        }
    }

    #[test]
    fn sizes_that_are_no_network_are_named() {
        let with = |width, hidden, first_layers| {
            let sizes = Architecture { width, hidden, first_layers, second_layers: 1, modes: 3 };
            sizes.check().map_err(|e| e.to_string())
        };
        assert!(with(32, 64, 0).is_ok());
        assert!(with(0, 64, 1).unwrap_err().starts_with("width"));
        assert!(with(32, 0, 1).unwrap_err().starts_with("hidden"));
        assert!(with(32, 64, 65).unwrap_err().starts_with("first_layers"));
    }
}
