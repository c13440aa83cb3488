//! Curves of water over time.

use catamaran::plant::Plant;

use super::Simulation;
use crate::picture::{Chart, Curve, Upwards};

/// Whether a node is in a group.
type Group<'a> = &'a dyn Fn(usize) -> bool;

/// The relative water content of leaves, stem and the whole plant, and that of some nodes; that of
/// the soil as a part of what it holds.
pub fn chart(plant: &Plant, simulation: &Simulation) -> Chart<'static> {
    let leaf = |v: usize| plant.segments()[v].leaf;
    // A few nodes, evenly over their numbers, behind the means.
    let some = (0..12).map(|i| i * plant.len() / 12);
    let some = some.filter_map(|v| curve(simulation, "", "#cbd5e1", &|u| u == v));
    let groups: [(&str, &str, Group<'_>); 3] = [
        ("leaves", "#16a34a", &leaf),
        ("stem", "#b45309", &|v| !leaf(v)),
        ("all", "#1d4ed8", &|_| true),
    ];
    let groups =
        groups.into_iter().filter_map(|(name, color, group)| curve(simulation, name, color, group));
    let soil = simulation.capacity.map(|capacity| Curve {
        name: "soil",
        color: "#7c2d12",
        width: 2.0,
        dashed: true,
        points: simulation
            .hours
            .iter()
            .zip(&simulation.balance)
            .map(|(h, b)| (*h, b.soil / capacity))
            .collect(),
    });
    Chart {
        across: "hours",
        last: simulation.hours.last().copied().unwrap_or(1.0),
        upwards: "relative water content",
        scale: Upwards::To(1.05),
        curves: some.chain(groups).chain(soil).collect(),
    }
}

/// Of a group, if it has members; thin without a name.
fn curve(
    simulation: &Simulation,
    name: &'static str,
    color: &'static str,
    group: Group<'_>,
) -> Option<Curve<'static>> {
    let members: Vec<usize> = (0..simulation.full.len()).filter(|&v| group(v)).collect();
    let sum = |values: &[f64]| members.iter().map(|&v| values[v]).sum::<f64>();
    let full = sum(&simulation.full);
    let moments = simulation.hours.iter().zip(&simulation.water);
    let points = moments.map(|(hours, water)| (*hours, sum(water) / full)).collect();
    let width = if name.is_empty() { 1.0 } else { 2.0 };
    (!members.is_empty()).then_some(Curve { name, color, width, dashed: false, points })
}
