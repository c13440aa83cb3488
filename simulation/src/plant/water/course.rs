use super::diffusion::WaterModel;
use super::options::CurveOptions;
use super::soil::Balance;
use super::walk::{Times, Walk};
use catamaran::base::{Error, Result, at_least_zero, check_request};

/// Computes the water of every node, in kg, at each of `times` (seconds from 0, ascending), from
/// `water` at time 0. Where the loss changes, one solution ends and the next one begins, without
/// interpolation.
///
/// ```
/// use catamaran_simulation::plant::{CurveOptions, WaterModel, WaterOptions, families, water_curve};
///
/// let model = WaterModel::new(&families::chain(20, 0.3, 1e-3)?, &WaterOptions::new())?;
/// let hours = [0.0, 3600.0, 7200.0];
/// let curve = water_curve(&model, &model.full(), &hours, &CurveOptions::new())?;
/// let total = curve.iter().map(|water| water.iter().sum()).collect::<Vec<f64>>();
/// assert!(total[0] > total[1] && total[1] > total[2]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Argument`], [`Error::Shape`] and [`Error::NonFinite`] name the argument at fault;
/// [`Error::OutOfMemory`]; [`Error::Cancelled`]; [`Error::NotConverged`] for stomata or soil whose
/// constants admit no step.
pub fn water_curve(
    model: &WaterModel,
    water: &[f64],
    times: &[f64],
    options: &CurveOptions<'_>,
) -> Result<Vec<Vec<f64>>> {
    Ok(water_course(model, water, times, options)?.water)
}

/// The result of [`water_course`], with an entry for each time.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct WaterCourse {
    /// Water of every node, in kg.
    pub water: Vec<Vec<f64>>,
    /// Balance of the water of plant and soil.
    pub balance: Vec<Balance>,
}

/// Computes the same as [`water_curve`], and the balance of the water: the water of the soil, the
/// water that leaves have lost, and the water that was poured.
///
/// ```
/// use catamaran_simulation::plant::{CurveOptions, Rewatering, Soil, WaterModel, WaterOptions, families};
/// use catamaran_simulation::plant::{Stomata, grams_per_hour, water_course};
///
/// // A plant in 2 g of wet soil, watered once after 20 days.
/// let options = WaterOptions::new().loss(grams_per_hour(2000.0));
/// let model = WaterModel::new(&families::chain(20, 0.3, 1e-3)?, &options)?;
/// let days: Vec<f64> = (0..=30).map(|day| 86_400.0 * f64::from(day)).collect();
/// let again = Rewatering { seconds: days[20], amount: None };
/// let options = CurveOptions::new()
///     .stomata(Some(Stomata::new()))
///     .soil(Some(Soil::new(2e-3)))
///     .rewatering(vec![again]);
/// let course = water_course(&model, &model.full(), &days, &options)?;
/// let (dry, wet) = (course.balance[20], course.balance[30]);
/// assert!(dry.plant < wet.plant);
/// let there = |b: &catamaran_simulation::plant::Balance| b.plant + b.soil + b.transpired - b.supplied;
/// let first = there(&course.balance[0]);
/// assert!(course.balance.iter().all(|b| (there(b) / first - 1.0).abs() < 1e-12));
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// As those of [`water_curve`].
pub fn water_course(
    model: &WaterModel,
    water: &[f64],
    times: &[f64],
    options: &CurveOptions<'_>,
) -> Result<WaterCourse> {
    for (i, &time) in times.iter().enumerate() {
        at_least_zero("times", time)?;
        if i > 0 && time < times[i - 1] {
            let why = format!("must ascend, but {time} s follows {} s", times[i - 1]);
            return Err(Error::Argument { what: "times", why });
        }
    }
    let request = format_args!("{} times of {} nodes", times.len(), water.len());
    let bytes = times.len() as f64 * size_of_val(water) as f64;
    check_request("times", request, bytes)?;
    let mut walk = Walk::new(model, water, Times::of(times), options)?;
    let mut course = WaterCourse { water: Vec::with_capacity(times.len()), balance: vec![] };
    for (i, &time) in times.iter().enumerate() {
        course.water.push(walk.to(time)?);
        course.balance.push(walk.balance());
        let fraction = (i + 1) as f64 / times.len() as f64;
        options.progress.report(fraction)?;
    }
    Ok(course)
}
