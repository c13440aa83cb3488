//! Coverage and presence over time (thesis, figure 3.8), as CSV and SVG.

use std::fmt::Write as _;
use std::io::Write as _;

use anyhow::Result;
use catamaran::io::Output;
use catamaran_charts::{Axis, Chart, Line, Series};
use catamaran_simulation::texture::slime::Coverage;

/// A moment: seconds of the simulation, and the coverage of each species.
pub type Moment = (f64, Vec<Coverage>);

/// Returns the numbers of moments, as a state keeps them: of each the seconds, then coverage and
/// presence of each species.
pub fn numbers(moments: &[Moment]) -> Vec<f64> {
    let of = |(seconds, all): &Moment| {
        let shares = all.iter().flat_map(|one| [one.coverage, one.presence]);
        [*seconds].into_iter().chain(shares).collect::<Vec<f64>>()
    };
    moments.iter().flat_map(of).collect()
}

/// Returns the moments of which these are the [`numbers`]; none if they are not those of `count`
/// moments.
pub fn moments(numbers: &[f64], species: usize, count: usize) -> Vec<Moment> {
    let width = 1 + 2 * species;
    if numbers.len() != count * width {
        return Vec::new();
    }
    let shares = |pair: &[f64]| Coverage { coverage: pair[0], presence: pair[1] };
    numbers
        .chunks_exact(width)
        .map(|row| (row[0], row[1..].chunks_exact(2).map(shares).collect()))
        .collect()
}

/// The largest share: the areas of texels add up to that of the surface only to rounding.
const WHOLE: f64 = 1.001;

/// Returns whether a run writes such moments: seconds ascend from 0, and shares are from 0 to 1.
pub fn are_of_a_run(moments: &[Moment]) -> bool {
    let is_share = |share: f64| (0.0..=WHOLE).contains(&share);
    moments.first().is_none_or(|first| first.0 == 0.0)
        && moments.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[1].0.is_finite())
        && moments
            .iter()
            .flat_map(|(_, all)| all)
            .all(|one| is_share(one.coverage) && is_share(one.presence))
}

/// Writes a row for each moment.
pub fn write_csv(mut output: Output, moments: &[Moment]) -> Result<()> {
    let mut text = String::from("seconds");
    for s in 0..moments.first().map_or(0, |m| m.1.len()) {
        let _ = write!(text, ",coverage{s},presence{s}");
    }
    text.push('\n');
    for (seconds, all) in moments {
        let _ = write!(text, "{seconds}");
        for one in all {
            let _ = write!(text, ",{},{}", one.coverage, one.presence);
        }
        text.push('\n');
    }
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// Draws coverage as lines and presence as dashes.
pub fn chart(moments: &[Moment]) -> Chart {
    let curve = |color, line, value: &dyn Fn(&[Coverage]) -> f64| {
        let points = moments.iter().map(|(seconds, all)| (*seconds, value(all))).collect();
        Series { line, ..Series::curve("", color, points) }
    };
    let species = 0..moments.first().map_or(0, |moment| moment.1.len());
    let series = species.flat_map(|s| {
        let color = Series::color(s);
        let coverage = curve(color, Line::Solid, &|all| all[s].coverage);
        [coverage, curve(color, Line::Dashed, &|all| all[s].presence)]
    });
    Chart::new(
        Axis::linear("seconds").range(0.0, moments.last().map_or(1.0, |moment| moment.0)),
        Axis::linear("coverage, and presence (dashed)").range(0.0, 1.0),
        series.collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_numbers_and_back() {
        let share = |coverage: f64| Coverage { coverage, presence: 0.5 + coverage / 2.0 };
        let all: Vec<Moment> =
            vec![(0.0, vec![share(0.0), share(0.1)]), (0.02, vec![share(0.3), share(1.0)])];
        let list = numbers(&all);
        assert_eq!(list.len(), 10);
        assert_eq!(moments(&list, 2, 2), all);
        assert!(moments(&list, 2, 3).is_empty() && moments(&list, 1, 2).is_empty());
        assert!(moments(&[], 1, 1).is_empty());
    }

    #[test]
    fn moments_that_no_run_writes_are_told() {
        // Two moments of one species: seconds, coverage and presence of each.
        let run = [0.0, 0.0, 0.5, 0.02, 0.25, 1.0];
        let are = |numbers: &[f64]| are_of_a_run(&moments(numbers, 1, 2));
        assert!(are(&run) && are_of_a_run(&[]));
        for (at, wrong) in [
            (0, 0.01),
            (0, f64::NAN),
            (1, -0.1),
            (2, 2.0),
            (3, 0.0),
            (3, f64::INFINITY),
            (3, f64::NAN),
            (4, f64::NAN),
            (5, f64::INFINITY),
        ] {
            let mut numbers = run;
            numbers[at] = wrong;
            assert!(!are(&numbers), "{wrong} at {at}");
        }
    }
}
