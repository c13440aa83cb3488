//! Draws a table of races, after figure 8.6 of the thesis.

use catamaran_bench::curves::{Plot, svg};

/// A panel: its column, its title, and the corresponding value of the rival.
const PANELS: [(&str, &str, Rival); 4] = [
    ("percent_of_peak", "% of peak", Rival::Speed),
    ("gflops", "GFLOP/s", Rival::Speed),
    ("ours_s", "seconds", Rival::Seconds),
    ("communication_s", "seconds of it in communication", Rival::Unknown),
];

/// The derivation of the rival's value from ours.
#[derive(Clone, Copy)]
enum Rival {
    /// The value is a speed.
    Speed,
    /// The value is a time.
    Seconds,
    /// The rival only reports its wall time.
    Unknown,
}

/// Draws the races of `table`, comma-separated with a header, over cores; four panels for each
/// shape and type.
pub fn of_table(table: &str) -> String {
    let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let columns = lines.next().unwrap_or_default();
    let rows: Vec<_> = lines.map(|fields| Fields { columns: &columns, fields }).collect();
    let mut problems: Vec<String> = Vec::new();
    for problem in rows.iter().map(Fields::problem) {
        if !problems.contains(&problem) {
            problems.push(problem);
        }
    }
    let mut plots = Vec::new();
    for problem in problems {
        let own: Vec<_> = rows.iter().filter(|row| row.problem() == problem).collect();
        let panels = PANELS.iter().map(|(column, title, rival)| Plot {
            title: format!("{problem}: {title}"),
            across: "cores".into(),
            logarithmic: false,
            scattered: false,
            series: series(&own, column, *rival),
        });
        // Older tables lack some columns.
        plots.extend(panels.filter(|panel| !panel.series.is_empty()));
    }
    svg(&plots)
}

/// Returns the values of a column over ranks times threads: a curve for each mode and number of
/// threads, and one for the rival at each placement of A and C.
fn series(rows: &[&Fields<'_>], column: &str, rival: Rival) -> Vec<(String, Vec<(f64, f64)>)> {
    let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    let mut add = |name: String, x: f64, y: Option<f64>| {
        let Some(y) = y else { return };
        let curve = match series.iter().position(|(other, _)| *other == name) {
            Some(curve) => curve,
            None => {
                series.push((name, Vec::new()));
                series.len() - 1
            }
        };
        let points = &mut series[curve].1;
        // Modes from one rank have the same rival; the first mode shows it.
        if points.iter().all(|(other, _)| *other != x) {
            points.push((x, y));
        }
    };
    for row in rows {
        let (Some(ranks), Some(threads)) = (row.number("ranks"), row.number("threads")) else {
            continue;
        };
        let mode = row.text("mode");
        let beside = if threads > 1.0 { format!(", {threads} threads") } else { String::new() };
        let value = row.number(column);
        add(format!("{mode}{beside}"), ranks * threads, value);
        let slower =
            row.number("rival_s").zip(row.number("ours_s")).map(|(rival, ours)| rival / ours);
        let theirs = match rival {
            Rival::Speed => value.zip(slower).map(|(value, slower)| value / slower),
            Rival::Seconds => row.number("rival_s"),
            Rival::Unknown => None,
        };
        let is_from_root = mode.starts_with("tree") || mode.starts_with("deal");
        let place = if is_from_root { " from rank 0" } else { "" };
        add(format!("pdsyrk{place}{beside}"), ranks * threads, theirs);
    }
    for (_, points) in &mut series {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    series
}

/// A line of the table.
struct Fields<'a> {
    columns: &'a [&'a str],
    fields: Vec<&'a str>,
}

impl Fields<'_> {
    fn text(&self, column: &str) -> &str {
        let place = self.columns.iter().position(|name| *name == column);
        place.and_then(|place| self.fields.get(place)).copied().unwrap_or_default()
    }

    fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok()
    }

    fn problem(&self) -> String {
        format!("{} x {}, {}", self.text("m"), self.text("n"), self.text("type"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "\
        mode,ranks,threads,m,n,type,ours_s,communication_s,gflops,percent_of_peak,rival_s\n\
        tree,2,1,64,32,f64,1.0,0.5,10,50,2.0\n\
        tree,1,1,64,32,f64,2.0,0.0,5,60,4.0\n\
        tree,1,2,64,32,f64,1.5,0.0,6,65,\n\
        rows,2,1,64,32,f64,0.5,0.1,20,80,1.0\n";

    #[test]
    fn every_problem_has_four_panels_and_every_way_a_curve() {
        let picture = of_table(TABLE);
        for text in ["64 x 32, f64: % of peak", "tree", "tree, 2 threads", "rows", "pdsyrk"] {
            assert!(picture.contains(&format!("\n{text}\n")), "{text}");
        }
        assert_eq!(picture.matches("64 x 32, f64").count(), PANELS.len());
        assert_eq!(picture.matches("\npdsyrk from rank 0\n").count(), 3);
        assert!(!picture.contains("NaN"));
    }

    #[test]
    fn curves_are_in_the_order_of_cores_and_the_rival_has_its_own_speed() {
        let lines: Vec<_> = TABLE.lines().map(|line| line.split(',').collect::<Vec<_>>()).collect();
        let rows: Vec<_> = lines[1..]
            .iter()
            .map(|fields| Fields { columns: &lines[0], fields: fields.clone() })
            .collect();
        let all = series(&rows.iter().collect::<Vec<_>>(), "gflops", Rival::Speed);
        let curve = |name| all.iter().find(|(other, _)| other == name).unwrap().1.clone();
        assert_eq!(curve("tree"), [(1.0, 5.0), (2.0, 10.0)]);
        assert_eq!(curve("pdsyrk from rank 0"), [(1.0, 2.5), (2.0, 5.0)]);
    }
}
