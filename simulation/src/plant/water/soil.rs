use catamaran::base::{Error, Result, at_least_zero, builder, positive};

/// The soil of a pot: a reservoir at the root.
///
/// From a content of c kg, with x = c / capacity, the root takes up `conductance a(x) (1 - w)` kg /
/// s, where w is the relative water content of its segment: wet soil holds water at the potential
/// of full cells. The supply decreases as the soil dries, `a(x) = (1 + h) x / (h + x)`: a smooth
/// form of the threshold of Feddes, Kowalik and Zaradny (1978). The content does not include water
/// that roots can't take up, and a plant returns no water.
///
/// ```
/// use catamaran_simulation::plant::Soil;
///
/// let soil = Soil::new(0.2).content(0.05); // 200 g of water at most, 50 g at first
/// assert!(soil.content < soil.capacity);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Soil {
    /// The largest content, in kg, at least 1e-15: below it the flows of a plant are rounded.
    pub capacity: f64,
    /// The water in it at time 0, in kg, from 0 to the capacity. Default: the capacity.
    pub content: f64,
    /// Conductance into the root, in kg / s at a difference of 1 in relative water content, at
    /// least 0. Default (`None`): that of half of the root segment.
    pub conductance: Option<f64>,
    /// h: the fraction of the capacity at which uptake has halved, above 0. Default 0.1.
    pub half: f64,
}

impl Soil {
    /// Creates wet soil with this capacity in kg.
    pub fn new(capacity: f64) -> Self {
        Self { capacity, content: capacity, conductance: None, half: 0.1 }
    }

    pub(super) fn check(&self) -> Result<()> {
        const LEAST: f64 = 1e-15;
        positive("capacity of the soil", self.capacity)?;
        if self.capacity < LEAST {
            let why = format!("must be at least {LEAST:e} kg, is {:e} kg", self.capacity);
            return Err(Error::Argument { what: "capacity of the soil", why });
        }
        positive("half of the soil", self.half)?;
        self.conductance.map_or(Ok(()), |g| at_least_zero("conductance of the soil", g))?;
        if (0.0..=self.capacity).contains(&self.content) {
            return Ok(());
        }
        let why = format!("must be from 0 to {} kg, is {} kg", self.capacity, self.content);
        Err(Error::Argument { what: "content of the soil", why })
    }

    /// Returns a for a content in kg; below 0, which only rounding reaches, returns the tangent
    /// at 0.
    pub(super) fn supply(&self, content: f64) -> f64 {
        let x = content / self.capacity;
        if x > 0.0 {
            (1.0 + self.half) * x / (self.half + x)
        } else {
            (1.0 + self.half) / self.half * x
        }
    }

    /// Returns the derivative of a with respect to the content, in 1 / kg.
    pub(super) fn supply_slope(&self, content: f64) -> f64 {
        let x = (content / self.capacity).max(0.0);
        (1.0 + self.half) * self.half / (self.half + x).powi(2) / self.capacity
    }
}

builder! { Soil {
    content: f64,
    conductance: Option<f64>,
    half: f64,
}}

/// A single watering of the soil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rewatering {
    /// Time in seconds from time 0.
    pub seconds: f64,
    /// Amount in kg, at least 0; the excess over the capacity drains. `None` fills the soil.
    pub amount: Option<f64>,
}

/// The water of a plant and its soil, and its losses since time 0, in kg:
/// `plant + soil + transpired` equals the water at time 0 plus `supplied`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Balance {
    /// Water in the plant.
    pub plant: f64,
    /// Water in the soil; 0 without soil.
    pub soil: f64,
    /// Water that leaves have lost.
    pub transpired: f64,
    /// Water from outside: rewatering that the soil could hold, and the
    /// [intake](super::WaterOptions::intake) of the root.
    pub supplied: f64,
    /// Water that was poured on the soil, but drained.
    pub drained: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn supply_is_that_of_wet_soil_at_capacity_and_none_of_dry_soil() {
        let soil = Soil::new(0.3).half(0.2);
        assert_eq!((soil.supply(0.3), soil.supply(0.0)), (1.0, 0.0));
        assert!((soil.supply(0.06) - 0.6).abs() < 1e-15);
        for content in [-1e-3, 1e-3, 0.1, 0.3] {
            let h = 1e-7;
            let slope = (soil.supply(content + h) - soil.supply(content - h)) / (2.0 * h);
            assert!((slope / soil.supply_slope(content) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn constants_out_of_range_are_named() {
        let says = |soil: Soil, part: &str| {
            assert!(soil.check().unwrap_err().to_string().contains(part));
        };
        says(Soil::new(0.0), "capacity");
        says(Soil::new(1e-16), "capacity of the soil: must be at least 1e-15 kg, is 1e-16 kg");
        says(Soil::new(1.0).content(1.5), "from 0 to 1 kg, is 1.5 kg");
        says(Soil::new(1.0).content(-0.5), "from 0 to 1 kg, is -0.5 kg");
        says(Soil::new(1.0).half(0.0), "half");
        says(Soil::new(1.0).conductance(Some(-1.0)), "conductance");
    }
}
