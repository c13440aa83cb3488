//! Principal components of a file.

use super::Turns;
use super::ours::Task;
use super::turns::columns;
use super::walsh::WalshMatrix;
use crate::Result;
use crate::exchange::get_vector;
use crate::plant::Part;

/// Methods of bench/rivals/gram.py.
const RIVALS: [&str; 2] = ["sklearn-covariance-eigh", "sklearn-incremental"];

/// Returns times of the principal components of a .npy file of 1,048,576 rows and 304 columns
/// (16,384 rows and 48 columns if `quick`), reading included, and relative errors of the explained
/// variances. Standard deviations fall from 1 to 2^-10, about a mean of 1 in each column; the known
/// ones have errors of about 1e-13.
///
/// # Errors
/// When a file can't be read or written, or no contender has a result.
pub fn principal_components(turns: &Turns, quick: bool) -> Result<Part> {
    let (m, n) = if quick { (1 << 14, 48) } else { (1 << 20, 304) };
    let walsh = WalshMatrix::rounded(m, n, 10, 1.0);
    let known = walsh.variances();
    // In target, as for `stream`, because the folder for temporary files may be in memory.
    let folder = tempfile::tempdir_in("target")?;
    walsh.write(folder.path())?;
    let mut part = Part {
        figure: "pca",
        title: format!("principal components of a file, {m} x {n}, {} threads", turns.threads),
        columns: columns(&["error of the least variance", "largest error"]),
        ..Part::default()
    };
    for runs in turns.run(Task::Pca, folder.path(), &RIVALS)? {
        let found = get_vector(folder.path(), &format!("variances-{}", runs.name))?;
        let errors: Vec<f64> =
            found.iter().zip(&known).map(|(x, known)| ((x - known) / known).abs()).collect();
        let mut values = runs.figures();
        values.push(errors.last().copied().unwrap_or(f64::NAN));
        values.push(errors.iter().copied().fold(0.0, f64::max));
        part.rows.push((runs.name.to_owned(), values));
    }
    Ok(part)
}
