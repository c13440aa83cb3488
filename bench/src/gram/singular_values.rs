//! Singular values of tall matrices, compared with the known ones.

use super::Turns;
use super::ours::Task;
use super::turns::columns;
use super::walsh::WalshMatrix;
use crate::Result;
use crate::exchange::get_vector;
use crate::plant::Part;

/// Methods of bench/rivals/gram.py.
const RIVALS: [&str; 3] = ["numpy-gesdd", "scipy-gesdd", "numpy-eigvalsh-of-gram"];

/// Binary logarithms of the condition numbers: 1.3e2 to 1.1e15.
const BITS: [i32; 8] = [7, 13, 20, 27, 33, 40, 46, 50];

/// Returns relative errors of singular values of matrices of 65,536 rows and 208 columns (4,096
/// rows if `quick`), whose entries are not rounded.
///
/// # Errors
/// When a file can't be read or written, or no contender has a result.
pub fn singular_values(turns: &Turns, quick: bool) -> Result<Part> {
    let rows = if quick { 1 << 12 } else { 1 << 16 };
    let mut part = Part {
        figure: "sigma",
        title: format!("singular values, {rows} x 208, {} threads", turns.threads),
        columns: columns(&["error of the least one", "largest error"]),
        ..Part::default()
    };
    for bits in BITS {
        let walsh = WalshMatrix::exact(rows, 208, bits);
        let known = walsh.singular_values();
        let folder = tempfile::tempdir()?;
        walsh.write(folder.path())?;
        for runs in turns.run(Task::Sigma, folder.path(), &RIVALS)? {
            let found = get_vector(folder.path(), &format!("sigma-{}", runs.name))?;
            let errors: Vec<f64> =
                found.iter().zip(&known).map(|(x, known)| ((x - known) / known).abs()).collect();
            let mut values = runs.figures();
            values.push(errors.last().copied().unwrap_or(f64::NAN));
            values.push(errors.iter().copied().fold(0.0, f64::max));
            let condition = 2.0_f64.powi(bits);
            part.rows.push((format!("condition {condition:.1e}, {}", runs.name), values));
        }
    }
    Ok(part)
}
