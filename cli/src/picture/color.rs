//! Colours of numbers, and of light.

use colorous::{Gradient, RED_BLUE, VIRIDIS};

use super::image::Rgb;

/// The colour of NaN.
const MISSING: Rgb = [150, 150, 150];

/// The colours that stand for numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorMap {
    /// Blue, white, red, for numbers on both sides of a middle.
    Diverging,
    /// Dark blue, green, yellow, for numbers from little to much.
    Sequential,
}

/// Numbers and the colours that stand for them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorScale {
    /// The colours.
    pub map: ColorMap,
    /// The number at the low end.
    pub low: f64,
    /// The number at the high end.
    pub high: f64,
}

impl ColorScale {
    /// Returns a scale for these numbers: diverging with zero in the middle when they have both
    /// signs, else sequential from the least to the greatest. Numbers that are not finite are
    /// ignored.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .filter(|x| x.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let most = high.max(-low);
        // Rounding may give tiny numbers of the other sign.
        if low < -1e-6 * most && high > 1e-6 * most {
            return Self { map: ColorMap::Diverging, low: -most, high: most };
        }
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        Self { map: ColorMap::Sequential, low, high }
    }

    /// Returns the colour of a number; numbers beyond the ends have the colours of the ends.
    pub fn color(&self, value: f64) -> Rgb {
        self.place(value).map_or(MISSING, |place| self.color_at(place))
    }

    /// Returns the position of a number between the ends, from 0 to 1; `None` for NaN.
    fn place(&self, value: f64) -> Option<f64> {
        let t =
            if self.high > self.low { (value - self.low) / (self.high - self.low) } else { 0.5 };
        if t.is_nan() { None } else { Some(t.clamp(0.0, 1.0)) }
    }

    fn color_at(&self, place: f64) -> Rgb {
        let (gradient, t): (Gradient, f64) = match self.map {
            // Without the darkest ends, on which no shading shows.
            ColorMap::Diverging => (RED_BLUE, 0.94 - 0.88 * place),
            ColorMap::Sequential => (VIRIDIS, place),
        };
        gradient.eval_continuous(t).into_array()
    }
}

/// A table of the light of the colours of a scale: a picture has many samples and few colours.
pub struct Lights {
    scale: ColorScale,
    lights: Vec<[f64; 3]>,
}

impl Lights {
    /// Entries of the table; neighbours differ by less than a step of a screen.
    const STEPS: usize = 2048;

    pub fn new(scale: ColorScale) -> Self {
        let place = |i: usize| i as f64 / (Self::STEPS - 1) as f64;
        let lights = (0..Self::STEPS).map(|i| to_light(scale.color_at(place(i)))).collect();
        Self { scale, lights }
    }

    /// Returns the light of the colour of a number.
    pub fn of(&self, value: f64) -> [f64; 3] {
        match self.scale.place(value) {
            Some(place) => self.lights[(place * (Self::STEPS - 1) as f64).round() as usize],
            None => to_light(MISSING),
        }
    }
}

/// Converts the numbers of a screen to amounts of light (IEC 61966-2-1).
pub fn to_light(color: Rgb) -> [f64; 3] {
    color.map(|c| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

/// Inverts [`to_light`], with rounding; light beyond 1 is white.
pub fn to_screen(light: [f64; 3]) -> Rgb {
    light.map(|l| {
        let l = l.clamp(0.0, 1.0);
        let c = if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
        (255.0 * c).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_and_screen_are_inverse() {
        for c in 0..=255 {
            assert_eq!(to_screen(to_light([c, 255 - c, 7])), [c, 255 - c, 7]);
        }
    }

    #[test]
    fn a_scale_suits_its_numbers() {
        let scale = ColorScale::of([-1.0, 3.0, f64::NAN, f64::INFINITY].into_iter());
        assert_eq!(scale, ColorScale { map: ColorMap::Diverging, low: -3.0, high: 3.0 });
        let [r, g, b] = scale.color(0.0);
        assert!(r > 235 && g > 235 && b > 235, "the middle is white");
        let ([r, _, b], [s, _, c]) = (scale.color(3.0), scale.color(-3.0));
        assert!(r > b && c > s, "red is high, blue is low");
        let scale = ColorScale::of([2.0, 5.0].into_iter());
        assert_eq!(scale, ColorScale { map: ColorMap::Sequential, low: 2.0, high: 5.0 });
        assert_eq!(scale.color(9.0), scale.color(5.0));
        assert_eq!(scale.color(f64::NAN), MISSING);
        let nothing = ColorScale::of(std::iter::empty());
        assert_eq!((nothing.low, nothing.high), (0.0, 0.0));
        assert_ne!(nothing.color(0.0), MISSING);
    }
    #[test]
    fn looked_up_light_is_that_of_the_colours() {
        for scale in [
            ColorScale { map: ColorMap::Diverging, low: -3.0, high: 3.0 },
            ColorScale { map: ColorMap::Sequential, low: 2.0, high: 2.0 },
        ] {
            let lights = Lights::new(scale);
            for value in [-4.0, -3.0, -1.234, 0.0, 2.0, 2.9, 7.0, f64::NAN] {
                let [found, exact] = [to_screen(lights.of(value)), scale.color(value)];
                assert!((0..3).all(|k| found[k].abs_diff(exact[k]) <= 1), "{value}: {found:?}");
            }
        }
    }
}
