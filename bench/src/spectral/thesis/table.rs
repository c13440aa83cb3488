//! A table of the thesis, measured on a set of pairs.

use std::rc::Rc;
use std::time::Instant;

use catamaran::faer::{Mat, MatRef};
use catamaran_geometry::spectral::functional_map::pull_back;

use super::data::{Data, Read, Set};
use super::pipelines::{
    Found, LANDMARKED, SEARCHED, along, distance, from_landmarks, landmarked, searched,
    true_commutativity,
};
use crate::Result;
use crate::spectral::prods::published;
use crate::spectral::shapes::{Pair, Shape};
use crate::spectral::signals::{NAMES, Signals, signals};
use crate::spectral::table::{average, mean};
use crate::spectral::transfer::{Bases, EVALUATED, LANDMARKS, Setting, mean_distance, of_size_1};

/// A table with the errors of both pipelines.
pub struct Table {
    set: Set,
    pairs: Vec<Points>,
    /// A row for each function, a column for each of [`SEARCHED`], and of [`LANDMARKED`].
    errors: [Vec<Vec<f64>>; 2],
}

/// The points that were found for a pair.
struct Points {
    name: String,
    found: Found,
    /// Mean distances from the true points, of the search and from landmarks.
    distances: [f64; 2],
    /// Commutativity of the true map, where it is known.
    truth: Option<f64>,
}

impl Set {
    /// Returns the setting of the table of the thesis.
    fn setting(self) -> Setting {
        match self {
            Self::Tosca => Setting::Isometric,
            Self::Faust => Setting::People,
            Self::Shrec | Self::Remeshed => Setting::Remeshed,
            Self::Animals => Setting::Graded,
            Self::Misc => Setting::Distant,
        }
    }

    /// Returns the name of the table in the record.
    fn table(self) -> String {
        let number = self.setting().table().0;
        match self {
            Self::Remeshed => format!("{number} FAUST"),
            _ => number.into(),
        }
    }

    /// Returns the vertices of the target at which absolute errors are measured; `None` for
    /// relative errors.
    fn evaluated(self, pair: &Pair) -> Option<Vec<u32>> {
        match self {
            Self::Animals => Some(pair.samples(EVALUATED)),
            Self::Misc => Some(pair.known.clone()),
            _ => None,
        }
    }
}

/// Measures a table on at most `most` pairs; `None` without pairs. Tells each pair on stderr when
/// it is done.
///
/// # Errors
/// The errors of the library, and files that can't be read.
pub fn measure(data: &Data, set: Set, most: usize) -> Result<Option<Table>> {
    let k = set.setting().parameters().1[0];
    let listed = set.pairs(data, most)?;
    let mut read = Read::default();
    let mut known: Vec<(Rc<Shape>, Signals)> = Vec::new();
    let (mut pairs, mut tables) = (Vec::new(), [Vec::new(), Vec::new()]);
    for (i, files) in listed.iter().enumerate() {
        let start = Instant::now();
        let pair = read.pair(files)?;
        let place = match known.iter().position(|(shape, _)| Rc::ptr_eq(shape, &pair.source)) {
            Some(place) => place,
            None => {
                known.push((pair.source.clone(), signals(&pair.source, k)?));
                known.len() - 1
            }
        };
        let (points, errors) = errors(&pair, &known[place].1, set)?;
        eprintln!(
            "{set:?} {} of {}: {}, points {:.1} and {:.1} % off, {:.0} s",
            i + 1,
            listed.len(),
            points.name,
            100.0 * points.distances[0],
            100.0 * points.distances[1],
            start.elapsed().as_secs_f64()
        );
        pairs.push(points);
        tables.iter_mut().zip(errors).for_each(|(tables, errors)| tables.push(errors));
    }
    let errors = tables.map(|tables| average(&tables));
    Ok((!pairs.is_empty()).then_some(Table { set, pairs, errors }))
}

/// The errors of a pair: a row for each function, a column for each way.
type Errors = Vec<Vec<f64>>;

fn errors(pair: &Pair, signals: &Signals, set: Set) -> Result<(Points, [Errors; 2])> {
    let parameters = set.setting().parameters();
    let bases = Bases::new(pair, parameters.0, parameters.1)?;
    let evaluated = set.evaluated(pair);
    let scaled: Vec<Mat<f64>> = signals
        .iter()
        .map(|f| if evaluated.is_some() { of_size_1(f.as_ref()) } else { f.clone() })
        .collect();
    let error = |f: MatRef<'_, f64>, g: &Mat<f64>| -> Result<f64> {
        let truth = pull_back(&pair.truth, f)?;
        Ok(match &evaluated {
            Some(vertices) => mean_distance(truth.as_ref(), g.as_ref(), vertices),
            None => mean(&relative(pair, &truth, g)),
        })
    };
    let found = searched(pair)?;
    let zoomed = landmarked(pair, parameters.1)?;
    let errors = [
        along(pair, &bases, parameters, &found.points, (&scaled, &error))?,
        from_landmarks(pair, &bases, parameters, &zoomed, (&scaled, &error))?,
    ];
    let points = Points {
        name: format!("{} to {}", pair.source.name, pair.target.name),
        distances: [distance(pair, &found.points), distance(pair, &zoomed)],
        found,
        truth: true_commutativity(pair)?,
    };
    Ok((points, errors))
}

/// Returns the relative errors of functions on the target, over the vertices that have a
/// counterpart.
fn relative(pair: &Pair, truth: &Mat<f64>, g: &Mat<f64>) -> Vec<f64> {
    let mass = pair.target.eigenbasis.basis().mass();
    let error = |j: usize| {
        let (mut apart, mut size) = (0.0, 0.0);
        for &y in &pair.known {
            let y = y as usize;
            apart += mass.diagonal(y) * (truth[(y, j)] - g[(y, j)]).powi(2);
            size += mass.diagonal(y) * truth[(y, j)].powi(2);
        }
        if apart == 0.0 { 0.0 } else { (apart / size).sqrt() }
    };
    (0..truth.ncols()).map(error).collect()
}

/// Headings of the two tables, and their columns.
const WAYS: [(&str, &[&str]); 2] = [
    ("without landmarks, along the points of `transfer A B`", &SEARCHED),
    ("from seven landmarks", &LANDMARKED),
];

/// How the columns are called in the record.
const RECORDED: [&str; 2] = ["searched", "landmarks"];

impl Table {
    /// Returns both tables as Markdown, in per cent, the thesis' errors in brackets; in how many
    /// rows each column is least; then what is known of the points of each pair.
    pub fn markdown(&self) -> String {
        let setting = self.set.setting();
        let (order, [k, l]) = setting.parameters();
        let mut out = format!(
            "## Table {}: {} pairs, N = {order}, K = {k} and {l}\n\n{}; prods from {:.3} of the \
             largest singular value, as published.\n",
            self.set.table(),
            self.pairs.len(),
            self.set.rule(),
            published(k)
        );
        for ((heading, columns), errors) in WAYS.iter().zip(&self.errors) {
            out += &format!("\n**{heading}**\n\n|  | {} |\n", columns.join(" | "));
            out += &format!("|{}\n", "---|".repeat(columns.len() + 1));
            for ((name, row), thesis) in NAMES.iter().zip(errors).zip(setting.thesis()) {
                let cell = |(c, error): (usize, &f64)| match thesis.get(c) {
                    Some(thesis) => format!("{:.1} [{thesis:.1}]", 100.0 * error),
                    None => format!("{:.1}", 100.0 * error),
                };
                let cells: Vec<_> = row.iter().enumerate().map(cell).collect();
                out += &format!("| {name} | {} |\n", cells.join(" | "));
            }
            let wins = least(errors);
            let wins: Vec<_> =
                columns.iter().zip(wins).map(|(name, wins)| format!("{name} {wins}")).collect();
            out += &format!("\nLeast in rows: {}.\n", wins.join(", "));
        }
        out + &self.points()
    }

    /// Returns a row for each pair.
    fn points(&self) -> String {
        let mut out = format!(
            "\n| pair | commutativity | of the true map | next over found | orientation | warning \
             | points off, % | from landmarks, % |\n|{}\n",
            "---|".repeat(8)
        );
        for Points { name, found, distances, truth } in &self.pairs {
            let truth = truth.map_or("unknown".into(), |truth| format!("{truth:.4}"));
            let ratio = |next: f64| format!("{:.2}", next / found.commutativity);
            out += &format!(
                "| {name} | {:.4} | {truth} | {} | {:.2} | {} | {:.1} | {:.1} |\n",
                found.commutativity,
                found.next.map_or("none".into(), ratio),
                found.orientation,
                if found.is_ambiguous { "yes" } else { "no" },
                100.0 * distances[0],
                100.0 * distances[1]
            );
        }
        let means = [0, 1].map(|i| {
            100.0 * self.pairs.iter().map(|pair| pair.distances[i]).sum::<f64>()
                / self.pairs.len() as f64
        });
        out += &format!(
            "\nPoints are off by {:.1} % of the root of the area on average, {:.1} % from \
             {LANDMARKS} landmarks.\n",
            means[0], means[1]
        );
        out
    }

    /// Returns the lines of the record: table, function, method, our error, the thesis'.
    pub fn lines(&self) -> Vec<String> {
        let (number, thesis) = (self.set.table(), self.set.setting().thesis());
        let mut lines = Vec::new();
        for (((_, columns), way), errors) in WAYS.iter().zip(RECORDED).zip(&self.errors) {
            for ((name, row), thesis) in NAMES.iter().zip(errors).zip(thesis) {
                for (c, (column, error)) in columns.iter().zip(row).enumerate() {
                    let column = column.replace(',', "");
                    let thesis = thesis
                        .get(c)
                        .map(|error| format!("{:.4}", error / 100.0))
                        .unwrap_or_default();
                    lines.push(format!("{number},{name},{way} {column},{error:.4},{thesis}"));
                }
            }
        }
        for Points { name, found, distances, truth } in &self.pairs {
            let mut line = |what: &str, value: f64| {
                lines.push(format!("{number} points,{name},{what},{value:.6},"));
            };
            line("searched", distances[0]);
            line("landmarks", distances[1]);
            line("commutativity", found.commutativity);
            line("orientation", found.orientation);
            line("warning", f64::from(u8::from(found.is_ambiguous)));
            found.next.into_iter().for_each(|next| line("next", next));
            truth.iter().for_each(|&truth| line("true commutativity", truth));
        }
        lines
    }
}

/// Returns for each column the number of rows in which it is least.
fn least(errors: &[Vec<f64>]) -> Vec<usize> {
    let mut wins = vec![0; errors.first().map_or(0, Vec::len)];
    for row in errors {
        let best = (0..row.len()).min_by(|&a, &b| row[a].total_cmp(&row[b]));
        best.into_iter().for_each(|best| wins[best] += 1);
    }
    wins
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran_geometry::mesh::families;

    #[test]
    fn the_least_column_of_each_row_is_counted() {
        let rows = [vec![3.0, 1.0, 2.0], vec![1.0, 2.0, 3.0], vec![5.0, 4.0, 9.0]];
        assert_eq!(least(&rows), [1, 2, 0]);
    }

    #[test]
    fn relative_errors_are_over_the_vertices_that_are_known() {
        let shape = Rc::new(Shape::new("sphere", &families::icosphere(1).unwrap(), 3).unwrap());
        let n = shape.mesh.vertices().len();
        let truth = Mat::from_fn(n, 1, |_, _| 2.0);
        // Wrong by half at the first vertex, and by far more at unknown ones.
        let g = Mat::from_fn(n, 1, |y, _| if y == 0 { 3.0 } else { 99.0 });
        let pair = Pair { source: shape.clone(), target: shape, truth: vec![0; n], known: vec![0] };
        let found = relative(&pair, &truth, &g);
        assert!((found[0] - 0.5).abs() < 1e-12);
    }
}
