//! Numbers of every node over time, as CSV.

use std::io::Write;

use anyhow::Result;
use catamaran::io::Output;

/// A row for each time: the hours, a number that stands for the row, and the values of all nodes.
pub fn write(
    mut output: Output,
    hours: &[f64],
    name: &str,
    rows: &[Vec<f64>],
    summary: impl Fn(&[f64]) -> f64,
) -> Result<()> {
    let nodes = rows.first().map_or(0, Vec::len);
    let mut text = format!("time_h,{name}");
    text.extend((0..nodes).map(|v| format!(",node_{v}")));
    text.push('\n');
    for (hours, row) in hours.iter().zip(rows) {
        text += &format!("{hours},{}", summary(row));
        text.extend(row.iter().map(|x| format!(",{x}")));
        text.push('\n');
    }
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}
