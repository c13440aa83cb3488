//! Chapter 6: why the bars of H and R, and table 6.2, differ from ours.

use catamaran_bench::Result;
use catamaran_bench::surface_curves::{
    Distances, LIMITS_HEAD, ORDERS_HEAD, Ordered, limit_tables, measure_limits, measure_orders,
    order_tables, surfaces,
};

use super::{Arguments, Report};

/// Seed of the generator.
const SEED: u64 = 6;
/// Number of curves on each mesh: for distances, and of each kind for orders.
const CURVES: usize = 10;
const KINDRED: usize = 30;

/// Columns of the records.
pub const LIMITS: &str = LIMITS_HEAD;
pub const ORDERS: &str = ORDERS_HEAD;

/// Reports what limits distances.
pub fn limits(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let count = arguments.curves.unwrap_or(CURVES);
    let mut runs = Vec::new();
    for surface in surfaces(&arguments.meshes)? {
        let surface = surface?;
        let start = std::time::Instant::now();
        runs.extend(measure_limits(&surface, count, SEED)?);
        println!("{}: {:.0} s", surface.name, start.elapsed().as_secs_f64());
    }
    report.say(&format!(
        "# Chapter 6: what limits distances\n\nUp to {count} curves a mesh, 7 numbers of \
         samples, 2 kinds of sampling.\n"
    ));
    report.say(&limit_tables(&runs));
    report.lines.extend(runs.iter().map(Distances::line));
    Ok(())
}

/// Reports what limits orders.
pub fn orders(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let count = arguments.curves.unwrap_or(KINDRED);
    let mut runs = Vec::new();
    for surface in surfaces(&arguments.meshes)? {
        let surface = surface?;
        let start = std::time::Instant::now();
        runs.extend(measure_orders(&surface, count, SEED)?);
        println!("{}: {:.0} s", surface.name, start.elapsed().as_secs_f64());
    }
    report.say(&format!(
        "# Chapter 6: what limits orders\n\nUp to {count} curves of each kind a mesh, 7 \
         numbers of samples.\n"
    ));
    report.say(&order_tables(&runs));
    report.lines.extend(runs.iter().map(Ordered::line));
    Ok(())
}
