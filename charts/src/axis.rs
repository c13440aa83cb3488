//! Axes: which values they show, where, and which of them get a label.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// Most labels of an axis of numbers.
const MOST_LABELS: usize = 9;

/// What an axis shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Its title, with the unit.
    pub title: String,
    /// How values are spread.
    pub scale: Scale,
    /// First and last value; `None`: those of the data, and 0 on a linear vertical axis.
    pub range: Option<[f64; 2]>,
}

/// How an axis spreads values.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly, with labels at whole numbers only.
    Whole,
    /// By decimal logarithms.
    Log10,
    /// By binary logarithms.
    Log2,
    /// These names, at 0, 1, 2, ...
    Names(Vec<String>),
}

impl Axis {
    /// Creates a linear axis over the range of the data.
    pub fn linear(title: impl Into<String>) -> Self {
        Self { title: title.into(), scale: Scale::Linear, range: None }
    }

    /// Creates a linear axis over the range of the data, with labels at whole numbers only.
    pub fn whole(title: impl Into<String>) -> Self {
        Self { scale: Scale::Whole, ..Self::linear(title) }
    }

    /// Creates a logarithmic axis over the range of the data, with labels at powers of ten and
    /// round numbers between them.
    pub fn log10(title: impl Into<String>) -> Self {
        Self { scale: Scale::Log10, ..Self::linear(title) }
    }

    /// Creates a logarithmic axis over the range of the data, with labels at powers of two.
    pub fn log2(title: impl Into<String>) -> Self {
        Self { scale: Scale::Log2, ..Self::linear(title) }
    }

    /// Creates an axis of names.
    pub fn names(names: Vec<String>) -> Self {
        let last = names.len() as f64 - 0.5;
        Self { title: String::new(), scale: Scale::Names(names), range: Some([-0.5, last]) }
    }

    /// Sets the first and the last value.
    #[must_use]
    pub fn range(mut self, first: f64, last: f64) -> Self {
        self.range = Some([first, last]);
        self
    }

    /// Returns whether the axis can show a value: zero has no logarithm.
    pub(crate) fn shows(&self, value: f64) -> bool {
        self.scale.place(value).is_finite()
    }

    /// Returns the coordinates for values that this axis shows. With `from_zero` a linear axis
    /// without a range includes 0, and a logarithmic one begins and ends at powers of ten.
    pub(crate) fn coordinates(
        &self,
        values: impl Iterator<Item = f64>,
        from_zero: bool,
    ) -> Coordinates {
        let scale = self.scale.clone();
        let [mut low, mut high] = match self.range {
            Some(range) => range.map(|value| scale.place(value)),
            None => values
                .map(|value| scale.place(value))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                    [low.min(v), high.max(v)]
                }),
        };
        if low > high {
            [low, high] = [0.0, 1.0];
        }
        if self.range.is_none() {
            match scale {
                Scale::Linear | Scale::Whole if from_zero => {
                    [low, high] = [low.min(0.0), high.max(0.0)]
                }
                Scale::Log10 if from_zero && high - low > 1.0 => {
                    [low, high] = [low.floor(), high.ceil()];
                }
                Scale::Log10 => [low, high] = [low - 0.03, high + 0.03],
                Scale::Log2 => [low, high] = [low - 0.5, high + 0.5],
                Scale::Linear | Scale::Whole | Scale::Names(_) => {}
            }
        }
        if low >= high {
            high = low + 1.0;
        }
        Coordinates { scale, low, high }
    }
}

impl Scale {
    fn place(&self, value: f64) -> f64 {
        match self {
            Self::Linear | Self::Whole | Self::Names(_) => value,
            Self::Log10 => value.log10(),
            Self::Log2 => value.log2(),
        }
    }

    fn value(&self, place: f64) -> f64 {
        match self {
            Self::Linear | Self::Whole | Self::Names(_) => place,
            Self::Log10 => 10_f64.powf(place),
            Self::Log2 => place.exp2(),
        }
    }

    /// Returns the values with labels between two places, at most [`MOST_LABELS`] of numbers.
    fn ticks(&self, low: f64, high: f64) -> Vec<f64> {
        match self {
            Self::Linear => linear_ticks(low, high, 0.0),
            Self::Whole => linear_ticks(low, high, 1.0),
            Self::Names(names) => (0..names.len()).map(|i| i as f64).collect(),
            Self::Log2 => {
                let powers = low.ceil() as i32..=high.floor() as i32;
                let step = powers.clone().count().div_ceil(MOST_LABELS).max(1);
                powers.step_by(step).map(|power| f64::from(power).exp2()).collect()
            }
            Self::Log10 => logarithmic_ticks(low, high),
        }
    }
}

/// Returns round numbers one, two or five times a power of ten apart, and at least `least`.
fn linear_ticks(low: f64, high: f64, least: f64) -> Vec<f64> {
    let rough = f64::max(least, (high - low) / MOST_LABELS as f64);
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * power).find(|s| *s >= rough);
    let step = step.unwrap_or(10.0 * power);
    // Products of whole numbers and a power of ten, rounded to what is printed.
    let tick = |k: i64| format!("{:.9e}", k as f64 * step).parse().unwrap_or(0.0);
    let first = (low / step - 1e-9).ceil() as i64;
    (first..).map(tick).take_while(|value| *value <= high + 1e-9 * step).collect()
}

/// Returns the densest of some sets of round numbers that has at most [`MOST_LABELS`] between two
/// decimal logarithms, or every n-th power of ten if all sets are too dense.
fn logarithmic_ticks(low: f64, high: f64) -> Vec<f64> {
    const DIGITS: [&[f64]; 4] = [
        &[1.0, 1.1, 1.2, 1.3, 1.5, 1.7, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
        &[1.0, 2.0, 5.0],
        &[1.0],
    ];
    let decades = (low.floor() as i32)..=(high.ceil() as i32);
    let within = |value: &f64| (low - 1e-9..=high + 1e-9).contains(&value.log10());
    let ticks = |digits: &[f64]| -> Vec<f64> {
        // Decimal literals, for the closest number to each.
        let tick = |d: i32, k: f64| format!("{k}e{d}").parse().unwrap_or(1.0);
        let of_decade = |d: i32| digits.iter().map(move |&k| tick(d, k));
        decades.clone().flat_map(of_decade).filter(within).collect()
    };
    let sets = DIGITS.map(ticks);
    let powers = &sets[DIGITS.len() - 1];
    let step = powers.len().div_ceil(MOST_LABELS).max(1);
    let sparse = || powers.iter().copied().step_by(step).collect();
    sets.iter().find(|set| set.len() <= MOST_LABELS).cloned().unwrap_or_else(sparse)
}

/// An axis and the range that it shows.
#[derive(Clone)]
pub(crate) struct Coordinates {
    scale: Scale,
    /// Places of the first and the last value.
    low: f64,
    high: f64,
}

impl Ranged for Coordinates {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (self.scale.place(*value) - self.low) / (self.high - self.low);
        from + (f64::from(to - from) * share.clamp(0.0, 1.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.scale.ticks(self.low, self.high)
    }

    fn range(&self) -> Range<f64> {
        self.scale.value(self.low)..self.scale.value(self.high)
    }
}

impl ValueFormatter<f64> for Coordinates {
    fn format_ext(&self, value: &f64) -> String {
        match &self.scale {
            Scale::Names(names) => names.get(*value as usize).cloned().unwrap_or_default(),
            _ if *value == 0.0 || (1e-3..1e6).contains(&value.abs()) => value.to_string(),
            _ => format!("{value:e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_ticks_are_round_and_cover_the_range() {
        let tenths = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
        assert_eq!(linear_ticks(0.0, 1.0, 0.0), tenths);
        assert_eq!(linear_ticks(-3.0, 2.0, 0.0), [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0]);
        assert_eq!(linear_ticks(0.5, 3.5, 1.0), [1.0, 2.0, 3.0]);
        assert_eq!(
            linear_ticks(7.0, 93.0, 0.0),
            [10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0]
        );
    }

    #[test]
    fn logarithmic_ticks_get_sparser_as_the_range_grows() {
        let ticks = |low: f64, high: f64| logarithmic_ticks(low.log10(), high.log10());
        assert_eq!(ticks(0.8, 1.3), [0.8, 0.9, 1.0, 1.1, 1.2, 1.3]);
        assert_eq!(ticks(0.5, 20.0), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(1e-4, 1e2), [1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0]);
        assert_eq!(ticks(1e-16, 1.0), [1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0]);
    }

    #[test]
    fn labels_are_short() {
        let axis = Axis::log10("x").coordinates([1e-9, 1e9].into_iter(), true);
        for (value, label) in [(1e-9, "1e-9"), (0.02, "0.02"), (65536.0, "65536"), (2e6, "2e6")] {
            assert_eq!(axis.format_ext(&value), label);
        }
        let names = Axis::names(vec!["a".into(), "b".into()]);
        let names = names.coordinates([].into_iter(), false);
        assert_eq!(names.format_ext(&1.0), "b");
        assert_eq!(names.map(&0.0, (0, 100)), 25);
    }

    #[test]
    fn a_range_of_one_value_or_none_has_an_extent() {
        for axis in [Axis::linear("x"), Axis::log10("x"), Axis::log2("x")] {
            for values in [vec![], vec![1.0], vec![7.0, 7.0]] {
                let found = axis.coordinates(values.into_iter(), true);
                assert!(found.low < found.high, "{:?}", axis.scale);
            }
        }
    }
}
