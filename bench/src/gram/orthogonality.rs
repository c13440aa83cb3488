//! The orthogonality of bases from QR decompositions.

use catamaran::faer::MatRef;
use catamaran::{AtaOptions, Uplo, ata_into};
use faer::Mat;

use super::Turns;
use super::ours::Task;
use super::turns::columns;
use super::walsh::WalshMatrix;
use crate::Result;
use crate::exchange::get;
use crate::plant::Part;

/// Methods of bench/rivals/gram.py.
const RIVALS: [&str; 1] = ["numpy-qr"];

/// Returns times of an orthonormal basis of 208 columns of 65,536 rows (4,096 if `quick`), of
/// condition 7e13, and the largest entry of `|Q^T Q - I|`.
///
/// # Errors
/// When a file can't be read or written, or no contender has a result.
pub fn orthogonality(turns: &Turns, quick: bool) -> Result<Part> {
    let rows = if quick { 1 << 12 } else { 1 << 16 };
    let folder = tempfile::tempdir()?;
    WalshMatrix::exact(rows, 208, 46).write(folder.path())?;
    let mut part = Part {
        figure: "orthogonality",
        title: format!(
            "orthonormal bases, {rows} x 208, condition 7e13, {} threads",
            turns.threads
        ),
        columns: columns(&["largest entry of abs(Q^T Q - I)"]),
        ..Part::default()
    };
    for runs in turns.run(Task::Qr, folder.path(), &RIVALS)? {
        let q = get(folder.path(), &format!("q-{}", runs.name))?;
        let mut values = runs.figures();
        values.push(defect(q.as_ref())?);
        part.rows.push((runs.name.to_owned(), values));
    }
    Ok(part)
}

/// Returns the largest entry of `|Q^T Q - I|`, by the exact path.
fn defect(q: MatRef<'_, f64>) -> Result<f64> {
    let n = q.ncols();
    let mut gram = Mat::zeros(n, n);
    let options = AtaOptions::new().scheme(catamaran::SchemeChoice::Exact).uplo(Uplo::Both);
    ata_into(1.0, q, 0.0, gram.as_mut(), &options)?;
    let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    Ok(places.map(|at| (gram[at] - f64::from(at.0 == at.1)).abs()).fold(0.0, f64::max))
}
