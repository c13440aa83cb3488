//! Least squares of tall matrices, compared with a refined solution.

use std::path::Path;

use catamaran::base::Rng;
use catamaran::faer::{Mat, MatRef};
use catamaran::io::{Output, Overwrite, write};

use super::Turns;
use super::ours::Task;
use super::turns::columns;
use crate::Result;
use crate::exchange::{get_vector, put_vector};
use crate::input::Shape;
use crate::plant::Part;

/// Methods of bench/rivals/gram.py.
const RIVALS: [&str; 2] = ["scipy-gelsy", "numpy-normal-equations"];

/// Mean that is added to uniform entries, as columns of data have a mean. Condition numbers are
/// about `sqrt(12 columns)` times this.
const MEAN: f64 = 64.0;

/// Returns times of least squares, and relative errors of the solutions: the largest difference
/// over the largest entry.
///
/// # Errors
/// When a file can't be read or written, or no contender has a result.
pub fn least_squares(turns: &Turns, quick: bool) -> Result<Part> {
    let shapes =
        if quick { [(20_000, 50), (4_000, 100)] } else { [(1_000_000, 100), (200_000, 1000)] };
    let mut part = Part {
        figure: "lstsq",
        title: format!("least squares, {} threads", turns.threads),
        columns: columns(&["error"]),
        ..Part::default()
    };
    for (m, n) in shapes {
        let folder = tempfile::tempdir()?;
        prepare(folder.path(), Shape { m, n })?;
        turns.reference(folder.path())?;
        let truth = get_vector(folder.path(), "x")?;
        for runs in turns.run(Task::Lstsq, folder.path(), &RIVALS)? {
            let x = get_vector(folder.path(), &format!("x-{}", runs.name))?;
            let mut values = runs.figures();
            values.push(relative_error(&x, &truth));
            part.rows.push((format!("{m} x {n}, {}", runs.name), values));
        }
    }
    Ok(part)
}

/// Writes A, uniform about its mean, and `b = A x + noise` with x of alternating signs.
fn prepare(folder: &Path, Shape { m, n }: Shape) -> Result<()> {
    let mut rng = Rng::new(1);
    let mut transposed = Mat::<f64>::zeros(n, m);
    let mut b = vec![0.0; m];
    for (i, b) in b.iter_mut().enumerate() {
        let row = transposed.col_mut(i);
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = MEAN + rng.uniform() - 0.5;
            *b += *entry * if j % 2 == 0 { 1.0 } else { -1.0 };
        }
        *b += 1e-3 * rng.normal();
    }
    put_rows(folder, transposed.as_ref())?;
    put_vector(folder, "b", &b)
}

fn put_rows(folder: &Path, transposed: MatRef<'_, f64>) -> Result<()> {
    let output = Output::create(&folder.join("a.npy"), Overwrite::Replace)?;
    Ok(write(output, transposed.transpose())?)
}

fn relative_error(x: &[f64], truth: &[f64]) -> f64 {
    let largest = truth.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
    x.iter().zip(truth).map(|(x, t)| (x - t).abs()).fold(0.0, f64::max) / largest
}
