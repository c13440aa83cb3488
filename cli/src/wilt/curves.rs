//! Draws curves of water over time.

use catamaran_charts::{Axis, Chart, Line, Rgb, Series};
use catamaran_simulation::plant::Plant;

use super::Simulation;

/// Whether a node is in a group.
type Group<'a> = &'a dyn Fn(usize) -> bool;

/// Draws the relative water content of leaves, stem and the whole plant, and of some nodes, and the
/// water of the soil as a fraction of its capacity.
pub fn chart(plant: &Plant, simulation: &Simulation) -> Chart {
    let leaf = |v: usize| plant.segments()[v].leaf;
    // A few nodes, evenly over their numbers, behind the means.
    let some = (0..12).map(|i| i * plant.len() / 12);
    let some = some.filter_map(|v| curve(simulation, "", [0xcb, 0xd5, 0xe1], &|u| u == v));
    let groups: [(&str, Rgb, Group<'_>); 3] = [
        ("leaves", [0x16, 0xa3, 0x4a], &leaf),
        ("stem", [0xb4, 0x53, 0x09], &|v| !leaf(v)),
        ("all", [0x1d, 0x4e, 0xd8], &|_| true),
    ];
    let groups =
        groups.into_iter().filter_map(|(name, color, group)| curve(simulation, name, color, group));
    let soil = simulation.capacity.map(|capacity| {
        let moments = simulation.hours.iter().zip(&simulation.balance);
        let points = moments.map(|(hours, balance)| (*hours, balance.soil / capacity)).collect();
        Series { line: Line::Dashed, ..Series::curve("soil", [0x7c, 0x2d, 0x12], points) }
    });
    Chart::new(
        Axis::linear("hours").range(0.0, simulation.hours.last().copied().unwrap_or(1.0)),
        Axis::linear("relative water content").range(0.0, 1.05),
        some.chain(groups).chain(soil).collect(),
    )
}

/// Returns the curve of a group, if the group has members; thin without a name.
fn curve(
    simulation: &Simulation,
    name: &'static str,
    color: Rgb,
    group: Group<'_>,
) -> Option<Series> {
    let members: Vec<usize> = (0..simulation.full.len()).filter(|&v| group(v)).collect();
    let sum = |values: &[f64]| members.iter().map(|&v| values[v]).sum::<f64>();
    let full = sum(&simulation.full);
    let moments = simulation.hours.iter().zip(&simulation.water);
    let points = moments.map(|(hours, water)| (*hours, sum(water) / full)).collect();
    let line = if name.is_empty() { Line::Thin } else { Line::Solid };
    (!members.is_empty()).then(|| Series { line, ..Series::curve(name, color, points) })
}
