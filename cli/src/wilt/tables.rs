//! Writes numbers of every node over time, as CSV.

use std::io::Write;

use anyhow::Result;
use catamaran::io::Output;

/// Writes a row for each time: the hours, a summary of the row, and the values of all nodes.
pub fn write(
    output: Output,
    hours: &[f64],
    name: &str,
    rows: &[Vec<f64>],
    summary: impl Fn(&[f64]) -> f64,
) -> Result<()> {
    let nodes = rows.first().map_or(0, Vec::len);
    let mut head = format!("time_h,{name}");
    head.extend((0..nodes).map(|v| format!(",node_{v}")));
    let row = |row: &Vec<f64>| std::iter::once(summary(row)).chain(row.clone()).collect::<Vec<_>>();
    write_rows(output, &head, hours.iter().zip(rows).map(|(h, r)| (*h, row(r))))
}

/// Writes a row for each time: the hours, and numbers.
pub fn write_rows(
    mut output: Output,
    head: &str,
    rows: impl Iterator<Item = (f64, impl IntoIterator<Item = f64>)>,
) -> Result<()> {
    let mut text = format!("{head}\n");
    for (hours, row) in rows {
        text += &hours.to_string();
        text.extend(row.into_iter().map(cell));
        text.push('\n');
    }
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

/// Formats a number, with an exponent where there would be many zeros.
fn cell(x: f64) -> String {
    const SMALL: f64 = 1e-12;
    if x != 0.0 && x.abs() < SMALL { format!(",{x:e}") } else { format!(",{x}") }
}
