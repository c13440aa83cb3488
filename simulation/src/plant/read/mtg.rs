//! MTG, the multiscale tree graphs of AMAPmod and OpenAlea (Godin and Caraglio 1998): the codes of
//! components and their features; `shape` makes a plant of them.

mod graph;
mod shape;

use super::super::Plant;
use super::lines::Lines;
use catamaran::base::Result;

/// Reads the plant with a name, such as `P3`, or the only one. `unit` has the metres in a unit of
/// lengths, and in one of diameters.
pub(super) fn read(lines: &mut Lines<'_>, unit: [f64; 2], name: Option<&str>) -> Result<Plant> {
    let mut graph = graph::header(lines, unit)?;
    while let Some(line) = lines.next_row()? {
        graph.row(lines, &line)?;
    }
    let names: Vec<String> = graph.plants.iter().map(|&v| graph.components[v].name()).collect();
    let end = |k: usize| graph.plants.get(k).copied().unwrap_or(graph.components.len());
    let found = name.map(|name| names.iter().position(|n| n == name));
    let chosen = match found {
        None if names.len() < 2 => 0..graph.components.len(),
        Some(Some(k)) => end(k)..end(k + 1),
        _ => {
            let (count, all) = (names.len(), names.join(", "));
            let why = name.map_or("choose one by its name".into(), |n| format!("{n:?} is not one"));
            let plants = if count == 1 { "plant" } else { "plants" };
            return Err(lines.fail(format!("the file has {count} {plants} ({all}): {why}")));
        }
    };
    shape::plant(&graph, chosen, lines)
}
