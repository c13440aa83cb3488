use catamaran::base::{Error, Result, finite, within};

/// The pressure of the atmosphere at sea level, in kPa.
const PRESSURE: f64 = 101.325;

/// The air around drying leaves at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Air {
    /// The time, in seconds.
    pub seconds: f64,
    /// The temperature, in degrees Celsius, from -40 to 60.
    pub celsius: f64,
    /// The relative humidity, from 0 to 1.
    pub humidity: f64,
}

impl Air {
    /// Returns the difference between the vapour of saturated air and that of this air, as a mole
    /// fraction at the pressure of sea level. The pressure of saturated vapour is that of Buck
    /// (1996).
    pub fn deficit(&self) -> f64 {
        let t = self.celsius;
        let saturated = 0.61121 * ((18.678 - t / 234.5) * t / (257.14 + t)).exp();
        saturated * (1.0 - self.humidity) / PRESSURE
    }
}

/// Computes the demand of the air: the integral of [`Air::deficit`], linear between the records,
/// from the first of some ascending times to each of them, in seconds.
///
/// ```
/// use catamaran_simulation::plant::{Air, air_demand};
///
/// let air = [0.0, 900.0].map(|seconds| Air { seconds, celsius: 25.0, humidity: 0.5 });
/// let demand = air_demand(&air, &[100.0, 700.0])?;
/// assert_eq!(demand[0], 0.0);
/// assert!((demand[1] - 600.0 * air[0].deficit()).abs() < 1e-12);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`] for records that do not ascend, or that are out of range, and for times
/// that do not ascend or that no records enclose.
pub fn air_demand(air: &[Air], seconds: &[f64]) -> Result<Vec<f64>> {
    for (i, record) in air.iter().enumerate() {
        finite("time of the air", record.seconds)?;
        within("temperature of the air, in degrees Celsius,", record.celsius, -40.0, 60.0)?;
        within("relative humidity of the air", record.humidity, 0.0, 1.0)?;
        if i > 0 && record.seconds <= air[i - 1].seconds {
            let why = format!("record {i} is not later than the record before it");
            return Err(Error::Argument { what: "air", why });
        }
    }
    let mut whole = vec![0.0; air.len()];
    for i in 1..air.len() {
        let mean = 0.5 * (air[i - 1].deficit() + air[i].deficit());
        whole[i] = whole[i - 1] + mean * (air[i].seconds - air[i - 1].seconds);
    }
    let mut demand = Vec::with_capacity(seconds.len());
    for (i, &time) in seconds.iter().enumerate() {
        let next = air.partition_point(|record| record.seconds < time).max(1);
        let (Some(after), Some(before)) = (air.get(next), air.get(next - 1)) else {
            return Err(outside(i, time));
        };
        if time < before.seconds || time.is_nan() {
            return Err(outside(i, time));
        }
        if i > 0 && time < seconds[i - 1] {
            let why = format!("must ascend, but {time} s follows {} s", seconds[i - 1]);
            return Err(Error::Argument { what: "times", why });
        }
        let part = (time - before.seconds) / (after.seconds - before.seconds);
        let here = before.deficit() + part * (after.deficit() - before.deficit());
        demand.push(whole[next - 1] + 0.5 * (before.deficit() + here) * (time - before.seconds));
    }
    let first = demand.first().copied().unwrap_or(0.0);
    Ok(demand.into_iter().map(|demand| demand - first).collect())
}

fn outside(i: usize, time: f64) -> Error {
    let why = format!("no records of the air enclose time {i}, {time} s");
    Error::Argument { what: "air", why }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deficit_is_that_of_tables_and_its_integral_that_of_trapezoids() {
        // Saturated vapour has 2.339 kPa at 20 and 3.169 kPa at 25 degrees Celsius.
        let at = |celsius, humidity| Air { seconds: 0.0, celsius, humidity }.deficit() * PRESSURE;
        assert!((at(20.0, 0.0) - 2.339).abs() < 2e-3 && (at(25.0, 0.0) - 3.169).abs() < 2e-3);
        assert!((at(25.0, 0.4) - 0.6 * at(25.0, 0.0)).abs() < 1e-12 && at(25.0, 1.0) == 0.0);
        // The deficit falls linearly to 0.
        let air = [(0.0, 0.0), (100.0, 1.0), (200.0, 1.0)].map(|(seconds, humidity)| Air {
            seconds,
            celsius: 20.0,
            humidity,
        });
        let demand = air_demand(&air, &[0.0, 50.0, 100.0, 150.0, 200.0]).unwrap();
        let whole = 50.0 * air[0].deficit();
        for (found, part) in demand.iter().zip([0.0, 0.75, 1.0, 1.0, 1.0]) {
            assert!((found - part * whole).abs() < 1e-12, "{demand:?}");
        }
        for times in [[-1.0, 3.0], [3.0, 201.0], [3.0, 2.0], [3.0, f64::NAN]] {
            assert!(air_demand(&air, &times).is_err(), "{times:?}");
        }
        assert!(air_demand(&air[..1], &[0.0]).is_err() && air_demand(&[], &[0.0]).is_err());
    }
}
