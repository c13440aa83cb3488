//! Parses the steepness kappa of each part of a plant.

use std::str::FromStr;

use anyhow::{Result, bail};
use catamaran_simulation::plant::{Elasticity, Part, Plant, Tissue};

use crate::parse;

/// Names of parts.
const PARTS: [(&str, Part); 3] =
    [("leaf", Part::Leaf), ("petiole", Part::Petiole), ("stem", Part::Stem)];

/// The value `K`, `leaf=K,stem=K` or `K,leaf=K`: the steepness of all other parts, and of named
/// parts.
#[derive(Debug, Clone, PartialEq)]
pub struct Kappa {
    others: Option<f64>,
    parts: Vec<(Part, f64)>,
}

impl FromStr for Kappa {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            "expected K, or leaf=K, petiole=K and stem=K separated by commas, with a steepness K \
             above 0"
                .into()
        };
        let mut kappa = Self { others: None, parts: vec![] };
        for item in text.split(',') {
            let (name, number) = item.split_once('=').unwrap_or(("", item));
            let number = parse::positive(number).map_err(|_| expected())?;
            let part = PARTS.iter().find(|(part, _)| *part == name.trim()).map(|(_, part)| *part);
            match part {
                None if name.is_empty() && kappa.others.is_none() => kappa.others = Some(number),
                Some(part) if kappa.parts.iter().all(|(other, _)| *other != part) => {
                    kappa.parts.push((part, number));
                }
                Some(_) => return Err(format!("{} is there twice", name.trim())),
                None => return Err(expected()),
            }
        }
        Ok(kappa)
    }
}

/// The value `MM=K,MM=K`: the steepness of segments whose radius is at least MM millimetres.
#[derive(Debug, Clone, PartialEq)]
pub struct ByRadius(Vec<(f64, f64)>);

impl FromStr for ByRadius {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let class = |item: &str| {
            let (radius, kappa) = item.split_once('=')?;
            Some((parse::positive(radius).ok()?, parse::positive(kappa).ok()?))
        };
        let classes: Option<Vec<(f64, f64)>> = text.split(',').map(class).collect();
        let ascends = |all: &Vec<(f64, f64)>| all.windows(2).all(|pair| pair[0].0 < pair[1].0);
        classes.filter(ascends).map(Self).ok_or_else(|| {
            "expected MM=K, or several separated by commas, above 0 and with radii MM that ascend"
                .into()
        })
    }
}

/// The name that each class of segments has in results, and the option that asks for it.
pub type Classes = Vec<(String, String)>;

/// Returns the tissue of a plant. `of` returns the elasticity of a steepness, and `usual` is the
/// default steepness.
pub fn tissue(
    plant: &Plant,
    kappa: Option<&Kappa>,
    by_radius: Option<&ByRadius>,
    usual: f64,
    of: impl Fn(f64) -> Elasticity,
) -> Result<(Tissue, Classes)> {
    let others = of(kappa.and_then(|kappa| kappa.others).unwrap_or(usual));
    let parts = kappa.map_or(&[][..], |kappa| &kappa.parts);
    Ok(match by_radius {
        Some(_) if !parts.is_empty() => {
            bail!("--kappa-by-radius: --kappa must be a single number, that of thinner segments");
        }
        Some(ByRadius(classes)) => {
            let metres: Vec<_> = classes.iter().map(|(mm, k)| (1e-3 * mm, of(*k))).collect();
            let class = |(mm, k): &(f64, f64)| {
                (format!("kappa_from_{mm}_mm"), format!("--kappa-by-radius {mm}={k}"))
            };
            let thinner = ("kappa_thinner".into(), "--kappa".into());
            let tissue = Tissue::by_radius(plant, others, &metres)?;
            (tissue, std::iter::once(thinner).chain(classes.iter().map(class)).collect())
        }
        None => {
            let named: Vec<_> = parts.iter().map(|(part, k)| (*part, of(*k))).collect();
            let of_part = |part: &Part| PARTS.iter().find(|(_, other)| other == part);
            let class = |(part, k): &(Part, f64)| {
                let name = of_part(part).map_or("", |(name, _)| name);
                (format!("kappa_{name}"), format!("--kappa {name}={k}"))
            };
            let first = if parts.is_empty() { "kappa" } else { "kappa_others" };
            let first = (first.into(), "--kappa".into());
            let tissue = Tissue::by_part(plant, others, &named);
            (tissue, std::iter::once(first).chain(parts.iter().map(class)).collect())
        }
    })
}

/// Removes the class of the other parts if it is empty, and returns the names of the classes;
/// refuses a requested class that no segment has.
pub fn used(plant: &Plant, tissue: &Tissue, classes: Classes) -> Result<(Tissue, Vec<String>)> {
    let (names, options): (Vec<String>, Vec<String>) = classes.into_iter().unzip();
    let members: Vec<usize> = (0..plant.len()).map(|v| tissue.class(v)).collect();
    let is_empty = |class: usize| members.iter().all(|&member| member != class);
    if let Some(class) = (1..names.len()).find(|&class| is_empty(class)) {
        bail!("the plant has no segment for {}", options[class]);
    }
    if names.len() == 1 || !is_empty(0) {
        return Ok((tissue.clone(), names));
    }
    let members = members.into_iter().map(|class| class as u32 - 1).collect();
    let rest = Tissue::new(tissue.classes()[1..].to_vec(), members)?;
    Ok((rest, names[1..].to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steepnesses_are_numbers_and_names() {
        let kappa = |text: &str| text.parse::<Kappa>().map(|k| (k.others, k.parts));
        assert_eq!(kappa("12"), Ok((Some(12.0), vec![])));
        let both = vec![(Part::Leaf, 8.0), (Part::Stem, 20.0)];
        assert_eq!(kappa("leaf=8,stem=20"), Ok((None, both.clone())));
        assert_eq!(kappa("10,leaf=8, stem=20"), Ok((Some(10.0), both)));
        for wrong in ["", "x", "leaf=", "root=3", "1,2", "leaf=1,leaf=2", "1,", "0", "leaf=-1"] {
            assert!(kappa(wrong).is_err(), "{wrong}");
        }
        assert_eq!(kappa("leaf=1, leaf=2"), Err("leaf is there twice".into()));
        assert_eq!("0.5=12,2=30".parse(), Ok(ByRadius(vec![(0.5, 12.0), (2.0, 30.0)])));
        let wrong = ["", "1", "1=x", "1=2,", "0=2", "1=-2", "2=3,1=4", "1=2,1=3"];
        assert!(wrong.iter().all(|text| text.parse::<ByRadius>().is_err()));
    }
}
