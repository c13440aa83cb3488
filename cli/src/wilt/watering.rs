//! Parses soil and rewatering, and writes the balance of water as a table.

use std::str::FromStr;

use anyhow::Result;
use catamaran::io::Output;
use catamaran_simulation::plant::{Balance, Rewatering, Soil, Stomata};

use super::tables::write_rows;
use crate::parse;

/// Grams in a kilogram.
const GRAMS: f64 = 1e3;

/// Parses `W,STEEPNESS` or `W,STEEPNESS,CUTICULAR`.
pub fn stomata(text: &str) -> Result<Stomata, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| parse::finite(x).ok()).collect();
    let stomata = |half, steepness| Stomata::new().half(half).steepness(steepness);
    let stomata = match numbers.as_deref() {
        Some(&[half, steepness]) if steepness >= 0.0 => Some(stomata(half, steepness)),
        Some(&[half, steepness, share]) if steepness >= 0.0 && (0.0..=1.0).contains(&share) => {
            Some(stomata(half, steepness).cuticular(share))
        }
        _ => None,
    };
    let expected = "expected a relative water content, a steepness of at least 0 and, if there is \
                    one, a cuticular share from 0 to 1, such as 0.8,25 or 0.8,25,0.03";
    // A large product of both overflows.
    stomata.filter(|stomata| stomata.openness(1.0).is_finite()).ok_or_else(|| expected.into())
}

/// Parses `CAPACITY` or `CAPACITY,CONTENT`, in grams.
pub fn soil(text: &str) -> Result<Soil, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| parse::at_least_zero(x).ok()).collect();
    match numbers.as_deref() {
        Some(&[capacity]) if capacity > 0.0 => Ok(Soil::new(capacity / GRAMS)),
        Some(&[capacity, content]) if capacity > 0.0 && content <= capacity => {
            Ok(Soil::new(capacity / GRAMS).content(content / GRAMS))
        }
        _ => Err("expected GRAMS or GRAMS,AT_FIRST, such as 200,50: GRAMS above 0, and AT_FIRST \
                  from 0 to GRAMS"
            .into()),
    }
}

/// The value `HOURS` or `HOURS:GRAMS`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pour(pub Rewatering);

impl FromStr for Pour {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (hours, grams) = match text.split_once(':') {
            Some((hours, grams)) => (hours, Some(grams)),
            None => (text, None),
        };
        let number = |text: &str| parse::at_least_zero(text).ok();
        let amount = grams.map(|grams| number(grams).map(|grams| grams / GRAMS));
        match (number(hours), amount) {
            (Some(hours), None) => Ok(Self(Rewatering { seconds: 3600.0 * hours, amount: None })),
            (Some(hours), Some(Some(amount))) => {
                Ok(Self(Rewatering { seconds: 3600.0 * hours, amount: Some(amount) }))
            }
            _ => Err("expected HOURS or HOURS:GRAMS, such as 120:50, both at least 0".into()),
        }
    }
}

/// Writes where the water is and where it went, a row for each frame.
pub fn write_balance(output: Output, hours: &[f64], balance: &[Balance]) -> Result<()> {
    let head = "time_h,plant_kg,soil_kg,transpired_kg,supplied_kg,drained_kg";
    let row = |b: &Balance| [b.plant, b.soil, b.transpired, b.supplied, b.drained];
    write_rows(output, head, hours.iter().zip(balance).map(|(h, b)| (*h, row(b))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_grams_and_times_hours() {
        assert_eq!(soil("200"), Ok(Soil::new(0.2)));
        assert_eq!(soil("200, 50"), Ok(Soil::new(0.2).content(0.05)));
        assert!(["1,2,3", "x", "0", "-1", "1,2", "1,-1", "inf"].iter().all(|t| soil(t).is_err()));
        let pour = |text: &str| text.parse::<Pour>().map(|pour| (pour.0.seconds, pour.0.amount));
        assert_eq!(pour("2"), Ok((7200.0, None)));
        assert_eq!(pour("0.5:20"), Ok((1800.0, Some(0.02))));
        assert!(["", "x", "1:", "1:x", "-1", "1:-1"].iter().all(|text| pour(text).is_err()));
        assert_eq!(stomata("0.7,20"), Ok(Stomata::new().half(0.7).steepness(20.0)));
        let wrong = ["0.7", "0.7,-1", "nan,1", "100,1000"];
        assert!(wrong.iter().all(|text| stomata(text).is_err()));
    }
}
