//! Tables of drying leaves, with the column names of the R package pvldcurve (Raesch 2020).

use std::collections::BTreeMap;
use std::path::Path;

use super::super::fit::{Air, DryingLeaf, Estimate, air_demand, turgor_loss_point};
use catamaran::base::{Error, Result};

/// The name of the group of a table without treatments.
const ALL: &str = "all";

/// A table of comma-separated values, and the name of its file for errors.
#[derive(Debug, Clone, Copy)]
pub struct LeafTable<'a> {
    /// The name.
    pub path: &'a Path,
    /// The content, whose first line has the names of the columns, in any order.
    pub text: &'a str,
}

/// Leaves of one treatment.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct LeafGroup {
    /// The treatment; `all` if the table has none.
    pub name: String,
    /// The leaves, in the order of the table.
    pub leaves: Vec<DryingLeaf>,
    /// The times of the weighings of each leaf, in seconds from the first one on.
    pub seconds: Vec<Vec<f64>>,
    /// The turgor loss points of the pressure-volume curves of this treatment.
    pub turgor_loss: Vec<Estimate>,
    /// Pressure-volume curves without a turgor loss point, and why.
    pub notes: Vec<String>,
}

impl LeafGroup {
    /// Returns the mean and the standard deviation of at least two turgor loss points, for
    /// [`LeafOptions::prior`](super::super::LeafOptions).
    pub fn prior(&self) -> Option<Estimate> {
        let count = self.turgor_loss.len() as f64;
        if count < 2.0 {
            return None;
        }
        let mean = self.turgor_loss.iter().map(|point| point.value).sum::<f64>() / count;
        let squares: f64 = self.turgor_loss.iter().map(|point| (point.value - mean).powi(2)).sum();
        Some(Estimate { value: mean, error: (squares / (count - 1.0)).sqrt() })
            .filter(|prior| prior.error > 0.0)
    }
}

/// Reads leaves that dry on a scale, the air around them, and pressure-volume curves of leaves of
/// the same treatments, as the R package pvldcurve names their columns:
///
/// - `drying`: `sample`, `dry.weight`, `fresh.weight.saturated`, `fresh.weight` in g, `leaf.area`
///   of one side in cm^2, `date.and.time` as `2019-03-26 08:48:00`, and optionally `treatment` and
///   `fw.plateau`; rows with `yes` there, from before the stomata opened, are left out;
/// - `air`: `date.and.time`, `temperature` in degrees Celsius, `humidity` in %;
/// - `curves`: `sample`, `fresh.weight`, `dry.weight`, `fresh.weight.saturated` in g,
///   `water.potential` below 0 in any unit, and optionally `treatment`.
///
/// ```
/// use std::path::Path;
/// use catamaran_simulation::plant::{LeafTable, read_leaves};
///
/// fn table<'a>(path: &'a str, text: &'a str) -> LeafTable<'a> {
///     LeafTable { path: Path::new(path), text }
/// }
/// let drying = table(
///     "leaves.csv",
///     "sample,dry.weight,fresh.weight.saturated,leaf.area,date.and.time,fresh.weight\n\
///      1,0.5,6,120,2019-03-26 08:00:00,5.9\n1,0.5,6,120,2019-03-26 09:00:00,5.7\n",
/// );
/// let air = table(
///     "air.csv",
///     "date.and.time,temperature,humidity\n2019-03-26 00:00:00,20,40\n2019-03-27 00:00:00,24,30\n",
/// );
/// let groups = read_leaves(drying, air, None)?;
/// assert!((groups[0].leaves[0].weights[0] - 5.9e-3).abs() < 1e-15);
/// assert_eq!(groups[0].seconds[0], [0.0, 3600.0]);
/// # Ok::<(), catamaran::Error>(())
/// ```
///
/// # Errors
/// [`Error::Io`] names the table, and the line or the column that is missing or wrong;
/// [`Error::Argument`] for times that the air does not enclose.
pub fn read_leaves(
    drying: LeafTable<'_>,
    air: LeafTable<'_>,
    curves: Option<LeafTable<'_>>,
) -> Result<Vec<LeafGroup>> {
    let air = read_air(air)?;
    let table = Table::new(drying)?;
    let [sample, time] = table.columns(["sample", "date.and.time"])?;
    let [dry, saturated, fresh, area] =
        table.columns(["dry.weight", "fresh.weight.saturated", "fresh.weight", "leaf.area"])?;
    let [treatment, plateau] = ["treatment", "fw.plateau"].map(|name| table.column(name));
    let mut groups: Vec<LeafGroup> = Vec::new();
    for row in &table.rows {
        if plateau.is_some_and(|column| row.cells[column] == "yes") {
            continue;
        }
        let group = group(&mut groups, treatment.map_or(ALL, |column| row.cells[column]));
        let name = row.cells[sample];
        let (grams, square_centimeters) = (1e-3, 1e-4);
        let read = DryingLeaf {
            name: name.into(),
            dry: grams * table.number(row, dry)?,
            saturated: grams * table.number(row, saturated)?,
            area: square_centimeters * table.number(row, area)?,
            ..DryingLeaf::default()
        };
        let at = group.leaves.iter().position(|leaf| leaf.name == name).unwrap_or_else(|| {
            group.leaves.push(read.clone());
            group.seconds.push(vec![]);
            group.leaves.len() - 1
        });
        let leaf = &mut group.leaves[at];
        if [leaf.dry, leaf.saturated, leaf.area] != [read.dry, read.saturated, read.area] {
            let what = format!("leaf {name} has another dry weight, saturated weight or area");
            return Err(table.wrong(row, what));
        }
        let second = table.seconds(row, time)?;
        if group.seconds[at].last().is_some_and(|before| second < *before) {
            return Err(table.wrong(row, format!("the times of leaf {name} must ascend")));
        }
        group.seconds[at].push(second);
        leaf.weights.push(grams * table.number(row, fresh)?);
    }
    for group in &mut groups {
        for (leaf, seconds) in group.leaves.iter_mut().zip(&mut group.seconds) {
            leaf.demand = air_demand(&air, seconds)?;
            let first = seconds[0];
            seconds.iter_mut().for_each(|second| *second -= first);
        }
    }
    if let Some(curves) = curves {
        read_curves(curves, &mut groups)?;
    }
    Ok(groups)
}

/// Returns the group of this name, which is created if there is none.
fn group<'a>(groups: &'a mut Vec<LeafGroup>, name: &str) -> &'a mut LeafGroup {
    let at = groups.iter().position(|group| group.name == name).unwrap_or_else(|| {
        groups.push(LeafGroup { name: name.into(), ..LeafGroup::default() });
        groups.len() - 1
    });
    &mut groups[at]
}

fn read_air(table: LeafTable<'_>) -> Result<Vec<Air>> {
    const PERCENT: f64 = 0.01;
    let table = Table::new(table)?;
    let [time, celsius, humidity] = table.columns(["date.and.time", "temperature", "humidity"])?;
    let of = |row: &Row<'_>| -> Result<Air> {
        let humidity = PERCENT * table.number(row, humidity)?;
        Ok(Air {
            seconds: table.seconds(row, time)?,
            celsius: table.number(row, celsius)?,
            humidity,
        })
    };
    table.rows.iter().map(of).collect()
}

/// Adds the turgor loss points of pressure-volume curves to the groups of their treatments.
fn read_curves(table: LeafTable<'_>, groups: &mut [LeafGroup]) -> Result<()> {
    let table = Table::new(table)?;
    let [sample, fresh, dry, saturated, potential] = table.columns([
        "sample",
        "fresh.weight",
        "dry.weight",
        "fresh.weight.saturated",
        "water.potential",
    ])?;
    let treatment = table.column("treatment");
    let mut curves: BTreeMap<[&str; 2], Vec<[f64; 2]>> = BTreeMap::new();
    for row in &table.rows {
        let [fresh, dry, saturated, potential] =
            [fresh, dry, saturated, potential].map(|column| table.number(row, column));
        let (fresh, dry, saturated) = (fresh?, dry?, saturated?);
        if dry >= saturated || dry >= fresh {
            let what = "the dry weight must be below the fresh and the saturated weight";
            return Err(table.wrong(row, what.into()));
        }
        let name = [treatment.map_or(ALL, |column| row.cells[column]), row.cells[sample]];
        let point = [(fresh - dry) / (saturated - dry), potential?];
        curves.entry(name).or_default().push(point);
    }
    for ([treatment, sample], curve) in curves {
        let Some(group) = groups.iter_mut().find(|group| group.name == treatment) else { continue };
        match turgor_loss_point(&curve) {
            Ok(point) => group.turgor_loss.push(point),
            Err(Error::NotConverged { .. }) => {
                group.notes.push(format!("curve {sample} does not tell its turgor loss point"));
            }
            Err(error) => group.notes.push(format!("curve {sample} is left out: {error}")),
        }
    }
    Ok(())
}

/// The rows of a table.
struct Table<'a> {
    path: &'a Path,
    header: Vec<&'a str>,
    rows: Vec<Row<'a>>,
}

struct Row<'a> {
    /// The number of its line, from 1.
    line: usize,
    cells: Vec<&'a str>,
}

impl<'a> Table<'a> {
    fn new(table: LeafTable<'a>) -> Result<Self> {
        let cells = |line: &'a str| -> Vec<&'a str> {
            line.split(',').map(|cell| cell.trim().trim_matches('"')).collect()
        };
        let mut lines = table.text.lines();
        let header = cells(lines.next().unwrap_or_default());
        let mut found = Self { path: table.path, header, rows: vec![] };
        for (i, line) in lines.enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let row = Row { line: i + 2, cells: cells(line) };
            if row.cells.len() != found.header.len() {
                let what = format!("expected {} cells", found.header.len());
                return Err(found.wrong(&row, what));
            }
            found.rows.push(row);
        }
        match found.rows.is_empty() {
            true => Err(Error::file(found.path, "has no rows")),
            false => Ok(found),
        }
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|cell| *cell == name)
    }

    fn columns<const N: usize>(&self, names: [&str; N]) -> Result<[usize; N]> {
        let mut columns = [0; N];
        for (column, name) in columns.iter_mut().zip(names) {
            *column = self
                .column(name)
                .ok_or_else(|| Error::file(self.path, format!("has no column {name:?}")))?;
        }
        Ok(columns)
    }

    fn wrong(&self, row: &Row<'_>, what: String) -> Error {
        Error::Io { path: self.path.into(), line: Some(row.line), what, cause: None }
    }

    fn number(&self, row: &Row<'_>, column: usize) -> Result<f64> {
        let (name, cell) = (self.header[column], row.cells[column]);
        let number = cell.parse().ok().filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.wrong(row, format!("{name} {cell:?} is no finite number")))
    }

    /// Returns the seconds of a day and time since 1970, in the zone of the table.
    fn seconds(&self, row: &Row<'_>, column: usize) -> Result<f64> {
        let cell = row.cells[column];
        seconds(cell).ok_or_else(|| {
            let name = self.header[column];
            self.wrong(row, format!("{name} {cell:?} is no time such as 2019-03-26 08:48:00"))
        })
    }
}

/// Returns the seconds of a day and time of the Gregorian calendar since 1970.
fn seconds(text: &str) -> Option<f64> {
    let (day, time) = text.split_once([' ', 'T'])?;
    let whole = |text: &str| text.parse::<u16>().ok().map(i64::from);
    let day: Vec<i64> = day.split('-').map(whole).collect::<Option<_>>()?;
    let time: Vec<i64> = time.split(':').map(whole).collect::<Option<_>>()?;
    let (&[year, month, day], &[hour, minute, second]) = (&day[..], &time[..]) else { return None };
    let is_date = (1..=12).contains(&month) && (1..=31).contains(&day);
    if !is_date || hour > 23 || minute > 59 || second > 59 {
        return None;
    }
    // Years begin with March, so that the leap day is their last one.
    let (year, month) = if month < 3 { (year - 1, month + 9) } else { (year, month - 3) };
    let days = 365 * year + year.div_euclid(4) - year.div_euclid(100)
        + year.div_euclid(400)
        + (153 * month + 2) / 5
        + day
        - 719_469;
    Some((86_400 * days + 3600 * hour + 60 * minute + second) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_counted_from_1970() {
        assert_eq!(seconds("1970-01-01 00:00:00"), Some(0.0));
        assert_eq!(seconds("2000-03-01 00:00:01"), Some(951_868_801.0));
        assert_eq!(seconds("2019-03-26 08:48:00"), Some(1_553_590_080.0));
        for wrong in ["2019-03-26", "2019-13-26 08:48:00", "26.03.2019 08:48:00", "", "a b"] {
            assert_eq!(seconds(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn wrong_tables_are_refused_with_their_line() {
        let header =
            "sample,dry.weight,fresh.weight.saturated,leaf.area,date.and.time,fresh.weight";
        let air = "date.and.time,temperature,humidity\n\
                   2019-03-26 00:00:00,20,40\n2019-03-27 00:00:00,24,30\n";
        fn table<'a>(path: &'a str, text: &'a str) -> LeafTable<'a> {
            LeafTable { path: Path::new(path), text }
        }
        let says = |rows: &str, part: &str| {
            let text = format!("{header}\n{rows}");
            let refused = read_leaves(table("l.csv", &text), table("a.csv", air), None);
            let refused = refused.unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        };
        let first = "1,0.5,6,120,2019-03-26 08:00:00,5.9\n";
        says("", "has no rows");
        says("1,0.5\n", "expected 6 cells");
        says("1,0.5,6,x,2019-03-26 08:00:00,5.9\n", "leaf.area \"x\" is no finite number");
        says("1,0.5,6,120,8:00,5.9\n", "is no time such as");
        says(&format!("{first}1,0.5,6,119,2019-03-26 09:00:00,5.9\n"), "has another dry weight");
        says(&format!("{first}1,0.5,6,120,2019-03-26 07:00:00,5.9\n"), "must ascend");
        says("1,0.5,6,120,2019-03-28 07:00:00,5.9\n", "no records of the air enclose");
        let refused = read_leaves(table("l.csv", first), table("a.csv", air), None);
        assert!(refused.is_err());
    }
}
