//! Chapter 6: why table 6.2 and the bars of H and R differ from ours.

use catamaran_bench::Result;
use catamaran_bench::surface_curves::{
    Distances, LIMITS_HEAD, coarse, density_tables, limit_tables, measure_limits, measure_orders,
    surfaces,
};

use super::{Arguments, Report};

/// Of the generator.
const SEED: u64 = 6;
/// Curves on each mesh.
const CURVES: usize = 10;

/// Columns of the record.
pub const HEADER: &str = LIMITS_HEAD;

/// What limits orders and distances.
pub fn run(report: &mut Report, arguments: &Arguments) -> Result<()> {
    let count = arguments.curves.unwrap_or(CURVES);
    let (mut orders, mut limits) = (Vec::new(), Vec::new());
    for surface in coarse()? {
        orders.extend(measure_orders(&surface, count, SEED)?);
    }
    for surface in surfaces(&arguments.meshes)? {
        let surface = surface?;
        let start = std::time::Instant::now();
        orders.extend(measure_orders(&surface, count, SEED)?);
        limits.extend(measure_limits(&surface, count, SEED)?);
        println!("{}: {:.0} s", surface.name, start.elapsed().as_secs_f64());
    }
    report.say(&format!(
        "# Chapter 6: what limits orders and distances\n\nUp to {count} curves a mesh, 7 numbers of samples, 2 kinds of \
         sampling.\n"
    ));
    report.say(&limit_tables(&limits));
    report.say(&density_tables(&orders));
    report.lines.extend(limits.iter().map(Distances::line));
    Ok(())
}
