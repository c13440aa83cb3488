//! The linear regression data of NIST's Statistical Reference Datasets, as least-squares problems
//! in f64.
//!
//! `nist/verify.py` proves rows and certified values, and says how the problems are rounded.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

use catamaran::faer::Mat;

/// A data set: a least-squares problem, and its solutions.
#[derive(Debug, Clone)]
pub struct NistSet {
    /// Its name.
    pub name: String,
    /// The design matrix: a column of ones if the model has an intercept, then the columns of the
    /// data, or the powers of x, each the one before times x in f64.
    pub design: Mat<f64>,
    /// The responses y.
    pub response: Vec<f64>,
    /// Whether the first column is the intercept.
    pub intercept: bool,
    /// The certified solution: of the decimal numbers of the data.
    pub certified: Solution,
    /// The exact solution for the design matrix and the responses as they are, in f64.
    pub rounded: Solution,
    /// The certified standard deviation of the residuals.
    pub residual_deviation: f64,
    /// The certified R^2; about zero when there is no intercept.
    pub r_squared: f64,
}

/// Coefficients, and their standard deviations.
#[derive(Debug, Clone, Default)]
pub struct Solution {
    /// One for each column of the design matrix.
    pub coefficients: Vec<f64>,
    /// As many.
    pub deviations: Vec<f64>,
}

impl NistSet {
    /// All 11 sets.
    ///
    /// # Errors
    /// When a file of `tests/common/nist` is missing or is not a table of the expected columns.
    pub fn all() -> Result<Vec<Self>> {
        let [certified, rounded] = [table("certified")?, table("rounded")?];
        let sets = table("sets")?;
        sets.iter().map(|set| Self::new(set, &certified, &rounded)).collect()
    }

    fn new(set: &[String], certified: &[Vec<String>], rounded: &[Vec<String>]) -> Result<Self> {
        let [name, _, degree, intercept, residual_deviation, r_squared] = set else {
            return Err(Error::new(ErrorKind::InvalidData, "sets: lines have six fields"));
        };
        let degree = number(degree)? as usize;
        let intercept = intercept == "1";
        let rows: Vec<Vec<f64>> = table(name)?
            .iter()
            .map(|row| row.iter().map(|field| number(field)).collect())
            .collect::<Result<_>>()?;
        let design: Vec<Vec<f64>> =
            rows.iter().map(|row| design_row(&row[1..], degree, intercept)).collect();
        let columns = design.first().map_or(0, Vec::len);
        Ok(Self {
            name: name.clone(),
            design: Mat::from_fn(rows.len(), columns, |i, j| design[i][j]),
            response: rows.iter().map(|row| row[0]).collect(),
            intercept,
            certified: solution(certified, name)?,
            rounded: solution(rounded, name)?,
            residual_deviation: number(residual_deviation)?,
            r_squared: number(r_squared)?,
        })
    }
}

fn design_row(data: &[f64], degree: usize, intercept: bool) -> Vec<f64> {
    let mut row = vec![1.0; usize::from(intercept)];
    if degree == 0 {
        row.extend(data);
        return row;
    }
    let mut power = 1.0;
    for _ in 0..degree {
        power *= data[0];
        row.push(power);
    }
    row
}

fn solution(lines: &[Vec<String>], name: &str) -> Result<Solution> {
    let mut solution = Solution::default();
    for line in lines.iter().filter(|line| line[0] == name) {
        solution.coefficients.push(number(&line[2])?);
        solution.deviations.push(number(&line[3])?);
    }
    Ok(solution)
}

fn number(text: &str) -> Result<f64> {
    text.parse().map_err(|_| Error::new(ErrorKind::InvalidData, format!("{text}: not a number")))
}

/// The lines of `NAME.csv` after comments and the header.
fn table(name: &str) -> Result<Vec<Vec<String>>> {
    // In the package of the library, or in one beside it.
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = [package.join("tests/common/nist"), package.join("../tests/common/nist")]
        .into_iter()
        .map(|folder| folder.join(format!("{name}.csv")))
        .find(|path| path.exists())
        .ok_or_else(|| Error::new(ErrorKind::NotFound, format!("{name}.csv: not found")))?;
    let text = std::fs::read_to_string(path)?;
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    Ok(lines.skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect())
}
