use super::Plant;
use super::elasticity::Elasticity;
use super::parts::Part;
use catamaran::base::{Error, Result, positive};

/// The elasticity of every segment: one for the whole plant, or one for each class of segments.
/// Woody parts keep their shape longer than leaves do (thesis, section 4.6: "varying kappa values
/// for different plant parts").
///
/// ```
/// use catamaran_simulation::plant::{Elasticity, Part, Tissue, families};
///
/// let plant = families::chain(3, 0.3, 1e-3)?; // the last segment is on a leaf
/// let of = |steepness| Elasticity::Relative { dry: 3e5, full: 5e7, steepness, shift: 0.75 };
/// let tissue = Tissue::by_part(&plant, of(20.0), &[(Part::Leaf, of(5.0))]);
/// let moduli = tissue.moduli(&[0.5; 3], &[1.0; 3])?;
/// assert!(moduli[2] > 2.0 * moduli[0] && moduli[0] == moduli[1]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Tissue {
    /// The elasticity of each class, at least one.
    classes: Vec<Elasticity>,
    /// The class of each segment; empty if all belong to the first one.
    members: Vec<u32>,
}

impl From<Elasticity> for Tissue {
    /// Returns a tissue with the same elasticity everywhere.
    fn from(elasticity: Elasticity) -> Self {
        Self { classes: vec![elasticity], members: vec![] }
    }
}

impl Default for Tissue {
    fn default() -> Self {
        Elasticity::default().into()
    }
}

impl Tissue {
    /// Creates classes of segments from the elasticity of each class, and the number (from 0) of
    /// the class of each segment.
    ///
    /// # Errors
    /// [`Error::Argument`] for no class, or when the class of a segment does not exist.
    pub fn new(classes: Vec<Elasticity>, members: Vec<u32>) -> Result<Self> {
        if classes.is_empty() {
            return Err(Error::Argument { what: "classes", why: "must not be empty".into() });
        }
        if let Some(v) = members.iter().position(|&class| class as usize >= classes.len()) {
            let (class, count) = (members[v], classes.len());
            let why = format!("segment {v}: class {class} is out of range: {count} classes");
            return Err(Error::Argument { what: "classes", why });
        }
        Ok(Self { classes, members })
    }

    /// Creates classes by the part of the plant ([`Plant::parts`]): class 0 holds all parts that
    /// are not named, class i the part `named[i - 1]`.
    pub fn by_part(plant: &Plant, others: Elasticity, named: &[(Part, Elasticity)]) -> Self {
        let class = |part: Part| named.iter().position(|(p, _)| *p == part).map_or(0, |i| i + 1);
        let members = plant.parts().into_iter().map(|part| class(part) as u32).collect();
        let classes = std::iter::once(others).chain(named.iter().map(|(_, e)| *e)).collect();
        Self { classes, members }
    }

    /// Creates classes by radius: class 0 holds segments thinner than all of `thicker`, class i
    /// segments whose radius is at least `thicker[i - 1].0` metres.
    ///
    /// ```
    /// use catamaran_simulation::plant::{Elasticity, Tissue, families};
    ///
    /// let plant = families::chain(3, 0.3, 1e-3)?;
    /// let (soft, woody) = (Elasticity::default(), Elasticity::default());
    /// let tissue = Tissue::by_radius(&plant, soft, &[(5e-4, woody)])?;
    /// assert_eq!(tissue.class(0), 1);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Argument`] unless the radii are positive and ascend.
    pub fn by_radius(
        plant: &Plant,
        thinnest: Elasticity,
        thicker: &[(f64, Elasticity)],
    ) -> Result<Self> {
        for (i, &(radius, _)) in thicker.iter().enumerate() {
            positive("radius of a class", radius)?;
            if i > 0 && radius <= thicker[i - 1].0 {
                let why = format!("must ascend, but {radius} m follows {} m", thicker[i - 1].0);
                return Err(Error::Argument { what: "radius of a class", why });
            }
        }
        let class = |radius: f64| thicker.partition_point(|(from, _)| *from <= radius) as u32;
        let members = plant.segments().iter().map(|s| class(s.radius)).collect();
        let classes = std::iter::once(thinnest).chain(thicker.iter().map(|(_, e)| *e)).collect();
        Ok(Self { classes, members })
    }

    /// Returns the elasticity of each class.
    pub fn classes(&self) -> &[Elasticity] {
        &self.classes
    }

    /// Returns the class of segment `v`.
    pub fn class(&self, v: usize) -> usize {
        self.members.get(v).map_or(0, |&class| class as usize)
    }

    /// Computes the modulus of every segment, in Pa, from its water and its water when full, both
    /// in kg.
    ///
    /// # Errors
    /// As [`Elasticity::moduli`]; [`Error::Shape`] for classes of another plant.
    pub fn moduli(&self, water: &[f64], full: &[f64]) -> Result<Vec<f64>> {
        self.classes.iter().try_for_each(Elasticity::check)?;
        Error::check_shape("water", (full.len(), 1), (water.len(), 1))?;
        if !self.members.is_empty() {
            Error::check_shape("classes", (full.len(), 1), (self.members.len(), 1))?;
        }
        let modulus = |v: usize| self.classes[self.class(v)].modulus(water[v], full[v]);
        Ok((0..water.len()).map(modulus).collect())
    }

    /// Returns the same classes with another steepness for each.
    pub(super) fn with_steepness(&self, values: &[f64]) -> Self {
        let classes = self.classes.iter().zip(values).map(|(e, &k)| e.with_steepness(k)).collect();
        Self { classes, members: self.members.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::families::{GrowthOptions, grow};

    fn of(steepness: f64) -> Elasticity {
        Elasticity::Relative { dry: 3e5, full: 5e7, steepness, shift: 0.75 }
    }

    #[test]
    fn one_class_is_the_elasticity_itself_bit_for_bit() {
        let plant = grow(&GrowthOptions::new().nodes(200)).unwrap();
        let water: Vec<f64> = (0..200).map(|i| f64::from(i) / 200.0).collect();
        let expected = of(7.0).moduli(&water, &[1.0; 200]).unwrap();
        let parts = [(Part::Leaf, of(7.0)), (Part::Stem, of(7.0))];
        for tissue in [
            Tissue::from(of(7.0)),
            Tissue::by_part(&plant, of(7.0), &parts),
            Tissue::by_radius(&plant, of(7.0), &[(1e-3, of(7.0))]).unwrap(),
        ] {
            assert_eq!(tissue.moduli(&water, &[1.0; 200]).unwrap(), expected);
        }
    }

    #[test]
    fn segments_have_the_elasticity_of_their_class() {
        let plant = grow(&GrowthOptions::new().nodes(200)).unwrap();
        let by_part = Tissue::by_part(&plant, of(9.0), &[(Part::Leaf, of(4.0))]);
        let steps = [(6e-4, of(8.0)), (1e-3, of(16.0))];
        let by_radius = Tissue::by_radius(&plant, of(4.0), &steps).unwrap();
        let mut seen = [[0; 3]; 2];
        let modulus = |e: Elasticity| e.moduli(&[0.5], &[1.0]).unwrap()[0];
        let moduli = [&by_part, &by_radius].map(|t| t.moduli(&[0.5; 200], &[1.0; 200]).unwrap());
        for (v, segment) in plant.segments().iter().enumerate() {
            let class = usize::from(segment.leaf);
            assert_eq!(
                (by_part.class(v), moduli[0][v]),
                (class, modulus(by_part.classes()[class]))
            );
            let class = usize::from(segment.radius >= 6e-4) + usize::from(segment.radius >= 1e-3);
            assert_eq!(by_radius.class(v), class);
            assert_eq!(moduli[1][v], modulus(by_radius.classes()[class]));
            seen[0][by_part.class(v)] += 1;
            seen[1][class] += 1;
        }
        assert!(seen[0][..2].iter().chain(&seen[1]).all(|&count| count > 0), "{seen:?}");
    }

    #[test]
    fn classes_that_are_none_are_named() {
        let plant = grow(&GrowthOptions::new().nodes(5)).unwrap();
        let says = |result: Result<Tissue>, part: &str| {
            assert!(result.unwrap_err().to_string().contains(part));
        };
        says(Tissue::new(vec![], vec![]), "must not be empty");
        says(Tissue::new(vec![of(1.0)], vec![0, 1]), "segment 1: class 1 is out of");
        let steps = [(2e-3, of(1.0)), (1e-3, of(1.0))];
        says(Tissue::by_radius(&plant, of(1.0), &steps), "ascend");
        says(Tissue::by_radius(&plant, of(1.0), &[(0.0, of(1.0))]), "radius");
        let other = Tissue::new(vec![of(1.0)], vec![0; 3]).unwrap();
        assert!(matches!(other.moduli(&[1.0; 5], &[1.0; 5]), Err(Error::Shape { .. })));
    }
}
