//! Attributes by which the entries of a dataset stand for other numbers: those of netCDF and its
//! CF conventions (cfconventions.org, section 8.1 and section 2.5.1).

use std::fmt;

use ::hdf5::types::{FixedAscii, FixedUnicode, VarLenAscii, VarLenUnicode};
use ::hdf5::{Attribute, Dataset};

use super::entry::Entry;

/// Attributes that bound the entries, and that are not applied.
const BOUNDS: [&str; 3] = ["valid_range", "valid_min", "valid_max"];

/// The meaning of an entry x: NaN if x is one of `missing`, else `scale` x + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Packing {
    scale: f64,
    offset: f64,
    /// Stored values that stand for missing ones.
    missing: Vec<f64>,
    /// What is added to negative integers that stand for unsigned ones; else 0.
    wrap: f64,
    /// Attributes that were found and are not applied.
    ignored: Vec<String>,
}

impl Packing {
    /// Reads the attributes of a dataset with these entries.
    ///
    /// # Errors
    /// The end of a sentence about the dataset: a factor or an offset that is no number.
    pub fn of(dataset: &Dataset, entry: &Entry) -> Result<Self, String> {
        let found = dataset.attr_names().unwrap_or_default();
        let has = |name: &str| found.iter().any(|other| other == name);
        let numbers = |name: &str| -> Option<Vec<f64>> {
            let attribute = dataset.attr(name).ok()?;
            attribute.read_raw::<f64>().ok()
        };
        let one = |name: &str, default: f64| match has(name).then(|| numbers(name)) {
            None => Ok(default),
            Some(Some(values)) if values.len() == 1 && values[0].is_finite() => Ok(values[0]),
            Some(_) => Err(format!("has an attribute {name} that is not one finite number")),
        };
        let (scale, offset) = (one("scale_factor", 1.0)?, one("add_offset", 0.0)?);
        let is_unsigned = has("_Unsigned")
            && dataset.attr("_Unsigned").ok().and_then(|a| text(&a)).is_some_and(|t| t == "true");
        let wrap = match entry.signed_bits {
            Some(bits) if is_unsigned => 2.0_f64.powi(bits as i32),
            _ => 0.0,
        };
        // The attribute may be in another precision than the entries that equal it.
        let stored = |x: f64| if entry.is_single { f64::from(x as f32) } else { x };
        let (mut missing, mut ignored) = (Vec::new(), Vec::new());
        for name in ["_FillValue", "missing_value"].into_iter().filter(|name| has(name)) {
            match numbers(name) {
                Some(values) => {
                    missing.extend(values.into_iter().map(stored).filter(|x| !x.is_nan()));
                }
                None => ignored.push(name.to_owned()),
            }
        }
        missing.sort_by(f64::total_cmp);
        missing.dedup();
        ignored.extend(BOUNDS.iter().filter(|name| has(name)).map(|&name| name.to_owned()));
        Ok(Self { scale, offset, missing, wrap, ignored })
    }

    /// Returns whether every entry stands for itself.
    pub fn is_none(&self) -> bool {
        !self.has_scale() && self.missing.is_empty() && self.wrap == 0.0
    }

    /// Returns whether entries that are not missing stand for other numbers.
    pub fn has_scale(&self) -> bool {
        self.scale != 1.0 || self.offset != 0.0
    }

    /// Returns the meaning of an entry.
    pub fn value(&self, stored: f64) -> f64 {
        if self.missing.contains(&stored) {
            return f64::NAN;
        }
        let stored = if stored < 0.0 { stored + self.wrap } else { stored };
        if self.has_scale() { self.scale * stored + self.offset } else { stored }
    }

    /// Returns what a user may not expect.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.is_none() {
            notes.push(format!("read by its attributes of netCDF: {self}"));
        }
        if !self.ignored.is_empty() {
            notes.push(format!("its attributes {} are not applied", self.ignored.join(", ")));
        }
        notes
    }
}

/// Says what is applied, as in `scale_factor 0.01, add_offset 273.15, missing -32767 (read as
/// NaN)`.
impl fmt::Display for Packing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if self.wrap > 0.0 {
            parts.push("unsigned".into());
        }
        if self.has_scale() {
            parts.push(format!("scale_factor {}, add_offset {}", self.scale, self.offset));
        }
        if !self.missing.is_empty() {
            let all: Vec<String> = self.missing.iter().map(f64::to_string).collect();
            parts.push(format!("missing {} (read as NaN)", all.join(" and ")));
        }
        f.write_str(&parts.join(", "))
    }
}

/// Returns the text of an attribute, of any type of strings.
pub(super) fn text(attribute: &Attribute) -> Option<String> {
    let fixed = || attribute.read_raw::<FixedAscii<64>>().ok()?.first().map(ToString::to_string);
    let wide = || attribute.read_raw::<FixedUnicode<64>>().ok()?.first().map(ToString::to_string);
    let long = || attribute.read_raw::<VarLenUnicode>().ok()?.first().map(ToString::to_string);
    let plain = || attribute.read_raw::<VarLenAscii>().ok()?.first().map(ToString::to_string);
    fixed().or_else(wide).or_else(long).or_else(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_missing_before_they_are_scaled() {
        let mut packing = Packing {
            scale: 0.5,
            offset: 10.0,
            missing: vec![-1.0, 4.0],
            wrap: 0.0,
            ignored: Vec::new(),
        };
        assert_eq!([2.0, 0.0, -2.0].map(|x| packing.value(x)), [11.0, 10.0, 9.0]);
        assert!(packing.value(-1.0).is_nan() && packing.value(4.0).is_nan());
        packing.wrap = 256.0;
        assert_eq!(packing.value(-2.0), 0.5 * 254.0 + 10.0);
        let said = "unsigned, scale_factor 0.5, add_offset 10, missing -1 and 4 (read as NaN)";
        assert_eq!(packing.to_string(), said);
    }
}
