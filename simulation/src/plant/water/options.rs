use super::soil::{Rewatering, Soil};
use super::stomata::Stomata;
use catamaran::base::{Par, Progress, options};

/// The method by which the water is computed at many times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The fastest of the other methods that is accurate to about 1e-12 of the water of a full
    /// plant, according to the rates of the model and the times. With [`CurveOptions::stomata`] or
    /// [`CurveOptions::soil`], where the problem is not linear: an implicit Runge-Kutta method of
    /// order 4 that chooses its steps (SDIRK, Hairer and Wanner 1996), to about 1e-8; the other
    /// methods then return an error.
    Auto,
    /// From one time to the next by the rational approximation of the exponential, for any times
    /// and any stiffness.
    Rational,
    /// By eigenvalues ([`SpectralSolution`](super::SpectralSolution)), for small plants that are
    /// not stiff, and many times.
    Spectral,
    /// By [`Bdf6`](super::Bdf6) with steps of at most `step` seconds, shortened so that they end
    /// at the requested times.
    Bdf6 {
        /// Length of a step, in seconds.
        step: f64,
    },
}

/// A part of a cycle of losses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Its length in seconds, above 0.
    pub seconds: f64,
    /// Loss of leaves in this time, in kg / (s m^2).
    pub loss: f64,
}

impl Interval {
    /// Returns a cycle of 16 hours of light, in which leaves lose `loss`, in kg / (s m^2), and 8
    /// hours of darkness, in which they lose a twelfth of it.
    ///
    /// ```
    /// use catamaran_simulation::plant::Interval;
    ///
    /// let day = Interval::day_and_night(1.2e-5);
    /// assert_eq!(day.iter().map(|part| part.seconds).sum::<f64>(), 24.0 * 3600.0);
    /// ```
    pub fn day_and_night(loss: f64) -> Vec<Self> {
        const NIGHT_LOSS: f64 = 1.0 / 12.0;
        let [light, dark] = [16.0, 8.0].map(|hours| 3600.0 * hours);
        vec![Self { seconds: light, loss }, Self { seconds: dark, loss: loss * NIGHT_LOSS }]
    }
}

options! {
    /// Options of [`water_curve`](super::water_curve).
    ///
    /// ```
    /// use catamaran_simulation::plant::{CurveOptions, Interval, WaterModel, WaterOptions};
    /// use catamaran_simulation::plant::{families, water_curve};
    ///
    /// let model = WaterModel::new(&families::chain(10, 0.3, 1e-3)?, &WaterOptions::new())?;
    /// let options = CurveOptions::new().cycle(Interval::day_and_night(1.5e-5));
    /// let curve = water_curve(&model, &model.full(), &[0.0, 86_400.0], &options)?;
    /// assert!(curve[1][0] < curve[0][0]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    #[derive(Debug, Clone)]
    pub struct CurveOptions<'a> {
        /// The method.
        method: Method = Method::Auto;
        /// Losses of a cycle that repeats from time 0, such as a day and a night. Without a cycle,
        /// leaves lose the loss of the model.
        cycle: Vec<Interval> = Vec::new();
        /// The response of stomata to drought; `None` keeps them open.
        stomata: Option<Stomata> = None;
        /// The soil; `None` leaves only [`WaterOptions::intake`](super::WaterOptions).
        soil: Option<Soil> = None;
        /// When the soil is watered, in any order; requires a soil.
        rewatering: Vec<Rewatering> = Vec::new();
        /// Threads. Their number does not change the result.
        par: Par = Par::all();
        /// Callback for progress, which may cancel.
        progress: Progress<'a> = Progress::none(), setter into;
    }
}
