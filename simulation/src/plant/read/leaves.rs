//! Tables of drying leaves, with the column names of the R package pvldcurve (Raesch 2020).

use std::collections::BTreeMap;
use std::path::Path;

use super::super::fit::{Air, DryingLeaf, Estimate, air_demand, turgor_loss_point};
use catamaran::base::{Error, Result};

/// The name of the group of a table without treatments.
const ALL: &str = "all";

/// The longest time between two records of the air without a note, in seconds: within three hours
/// the deficit of a day changes about linearly.
const LONGEST_GAP: f64 = 3.0 * 3600.0;

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
    /// What was left out or assumed: pressure-volume curves without a turgor loss point, and long
    /// times without a record of the air.
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
///   `fw.plateau` (`yes` or `no`); rows with `yes` there, from before the stomata opened, are left
///   out;
/// - `air`: `date.and.time`, `temperature` in degrees Celsius, `humidity` in %, linear between the
///   records;
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
/// [`Error::Io`] names the table, and the line or the column that is missing or wrong, also where
/// the records of the air do not enclose the time of a weight.
pub fn read_leaves(
    drying: LeafTable<'_>,
    air: LeafTable<'_>,
    curves: Option<LeafTable<'_>>,
) -> Result<Vec<LeafGroup>> {
    let recorded = air.path;
    let air = read_air(air)?;
    let table = Table::new(drying)?;
    let [sample, time] = table.columns(["sample", "date.and.time"])?;
    let [dry, saturated, fresh, area] =
        table.columns(["dry.weight", "fresh.weight.saturated", "fresh.weight", "leaf.area"])?;
    let [treatment, plateau] = ["treatment", "fw.plateau"].map(|name| table.column(name));
    let mut groups: Vec<LeafGroup> = Vec::new();
    for row in &table.rows {
        if let Some(column) = plateau
            && table.is_yes(row, column)?
        {
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
        if !(air[0].seconds..=air[air.len() - 1].seconds).contains(&second) {
            let what = format!(
                "the records of the air in {} do not enclose {}",
                recorded.display(),
                row.cells[time]
            );
            return Err(table.wrong(row, what));
        }
        group.seconds[at].push(second);
        leaf.weights.push(grams * table.number(row, fresh)?);
    }
    if groups.is_empty() {
        return Err(Error::file(table.path, "has no rows but those with yes in fw.plateau"));
    }
    for group in &mut groups {
        let gap = group.seconds.iter().map(|seconds| longest_gap(&air, seconds));
        let gap = gap.fold(0.0, f64::max);
        if gap > LONGEST_GAP {
            let hours = gap / 3600.0;
            group.notes.push(format!(
                "the air was not recorded for {hours:.1} hours while leaves dried, and is taken \
                 as linear between the records"
            ));
        }
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

/// Returns the longest time between two records of the air that includes a part of these times.
fn longest_gap(air: &[Air], seconds: &[f64]) -> f64 {
    let (Some(&first), Some(&last)) = (seconds.first(), seconds.last()) else { return 0.0 };
    let during = air.windows(2).filter(|pair| pair[0].seconds < last && pair[1].seconds > first);
    during.map(|pair| pair[1].seconds - pair[0].seconds).fold(0.0, f64::max)
}

/// Reads at least one record of the air, in ascending times.
fn read_air(table: LeafTable<'_>) -> Result<Vec<Air>> {
    const PERCENT: f64 = 0.01;
    let table = Table::new(table)?;
    let [time, celsius, humidity] = table.columns(["date.and.time", "temperature", "humidity"])?;
    let mut air: Vec<Air> = Vec::new();
    for row in &table.rows {
        let record = Air {
            seconds: table.seconds(row, time)?,
            celsius: table.number(row, celsius)?,
            humidity: PERCENT * table.number(row, humidity)?,
        };
        if !(-40.0..=60.0).contains(&record.celsius) {
            let what = "must be from -40 to 60 degrees Celsius";
            return Err(table.wrong(row, format!("temperature {}: {what}", row.cells[celsius])));
        }
        if !(0.0..=1.0).contains(&record.humidity) {
            let what = format!("humidity {}: must be from 0 to 100 %", row.cells[humidity]);
            return Err(table.wrong(row, what));
        }
        if air.last().is_some_and(|before| record.seconds <= before.seconds) {
            let what = format!("{} is not later than the record before it", row.cells[time]);
            return Err(table.wrong(row, what));
        }
        air.push(record);
    }
    // No air is that dry.
    if air.iter().all(|record| record.humidity <= PERCENT) {
        let what = "no humidity is above 1 %: it must be in %, not a fraction";
        return Err(Error::file(table.path, what));
    }
    Ok(air)
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
        let Some(group) = groups.iter_mut().find(|group| group.name == treatment) else {
            if let Some(first) = groups.first_mut() {
                first.notes.push(format!(
                    "curve {sample} is left out: no leaf has its treatment, {treatment:?}"
                ));
            }
            continue;
        };
        match turgor_loss_point(&curve) {
            Ok(point) => group.turgor_loss.push(point),
            Err(Error::NotConverged { .. }) => {
                group.notes.push(format!("curve {sample} does not tell its turgor loss point"));
            }
            Err(error) => group.notes.push(format!("curve {sample} is left out: {error}")),
        }
    }
    for group in groups.iter_mut().filter(|group| group.turgor_loss.len() == 1) {
        group.notes.push(format!(
            "the only turgor loss point of {} is not used: its deviation between leaves is not \
             known",
            group.name
        ));
    }
    Ok(())
}

/// Separators of columns that are not read, as spreadsheets write them.
const SEPARATORS: [(char, &str); 2] = [(';', "semicolons"), ('\t', "tabs")];

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
        // Spreadsheets begin text with a byte order mark.
        let mut lines = table.text.trim_start_matches('\u{feff}').lines();
        let header = cells(lines.next().unwrap_or_default());
        if let [only] = header[..]
            && let Some((_, what)) = SEPARATORS.into_iter().find(|(other, _)| only.contains(*other))
        {
            let what = format!("{what} separate the columns {only:?}: commas must");
            return Err(Error::file(table.path, what));
        }
        for (i, name) in header.iter().enumerate() {
            if header[..i].iter().any(|other| !name.is_empty() && name.eq_ignore_ascii_case(other))
            {
                return Err(Error::file(table.path, format!("has two columns {name:?}")));
            }
        }
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
        self.header.iter().position(|cell| cell.eq_ignore_ascii_case(name))
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

    /// Returns whether a cell says yes; `TRUE` and `FALSE` are those of R.
    fn is_yes(&self, row: &Row<'_>, column: usize) -> Result<bool> {
        let (name, cell) = (self.header[column], row.cells[column]);
        match cell.to_ascii_lowercase().as_str() {
            "yes" | "true" => Ok(true),
            "no" | "false" => Ok(false),
            _ => Err(self.wrong(row, format!("{name} {cell:?} is neither yes nor no"))),
        }
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
    let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let length = match month {
        2 => 28 + i64::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    let is_date = (1..=12).contains(&month) && (1..=length).contains(&day);
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
        assert!(seconds("2020-02-29 00:00:00").is_some() && seconds("2019-02-29 0:0:0").is_none());
        assert!(seconds("2019-04-30 00:00:00").is_some() && seconds("2019-04-31 0:0:0").is_none());
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
        says("1,0.5,6,120,2019-02-30 08:00:00,5.9\n", "is no time such as");
        says(&format!("{first}1,0.5,6,119,2019-03-26 09:00:00,5.9\n"), "has another dry weight");
        says(&format!("{first}1,0.5,6,120,2019-03-26 07:00:00,5.9\n"), "must ascend");
        let enclose = "l.csv:2: the records of the air in a.csv do not enclose 2019-03-28 07:00:00";
        says("1,0.5,6,120,2019-03-28 07:00:00,5.9\n", enclose);
        let refused = read_leaves(table("l.csv", first), table("a.csv", air), None);
        assert!(refused.is_err());
        let plateau = format!("{header},fw.plateau\n{}", first.replace('\n', ",perhaps\n"));
        let says_of = |drying: &str, air: &str, part: &str| {
            let refused = read_leaves(table("l.csv", drying), table("a.csv", air), None);
            let refused = refused.unwrap_err().to_string();
            assert!(refused.contains(part), "{refused}");
        };
        says_of(&plateau, air, "l.csv:2: fw.plateau \"perhaps\" is neither yes nor no");
        let none = "has no rows but those with yes in fw.plateau";
        says_of(&plateau.replace("perhaps", "Yes"), air, none);
        let drying = format!("{header}\n{first}");
        let kelvins = air.replace(",24,", ",297,");
        says_of(&drying, &kelvins, "a.csv:3: temperature 297: must be from -40 to 60 degrees");
        says_of(&drying, &air.replace(",30", ",300"), "a.csv:3: humidity 300: must be from 0 to");
        let fractions = air.replace(",40", ",0.4").replace(",30", ",0.3");
        says_of(&drying, &fractions, "a.csv: no humidity is above 1 %: it must be in %");
        for (separator, what) in [(";", "semicolons"), ("\t", "tabs")] {
            let says = format!("l.csv: {what} separate the columns \"sample{separator}dry.weight");
            let says = says.replace('\t', "\\t");
            says_of(&drying.replace(',', separator), air, &says);
        }
        let twice = drying.replace("leaf.area", "Sample");
        says_of(&twice, air, "l.csv: has two columns \"Sample\"");
        let backwards = air.replace("2019-03-27 00", "2019-03-25 00");
        says_of(&drying, &backwards, "a.csv:3: 2019-03-25 00:00:00 is not later");
    }

    #[test]
    fn what_tables_leave_out_is_noted() {
        fn table<'a>(path: &'a str, text: &'a str) -> LeafTable<'a> {
            LeafTable { path: Path::new(path), text }
        }
        // A byte order mark is no part of the first column's name.
        let drying = "\u{feff}Treatment,sample,dry.weight,fresh.weight.saturated,leaf.area,\
                      date.and.time,fresh.weight,fw.plateau\n\
                      dry,1,0.5,6,120,2019-03-26 08:00:00,5.9,TRUE\n\
                      dry,1,0.5,6,120,2019-03-26 09:00:00,5.8,FALSE\n\
                      dry,1,0.5,6,120,2019-03-26 10:00:00,5.7,No\n";
        let hourly: String =
            (0..24).map(|hour| format!("2019-03-26 {hour:02}:00:00,20,40\n")).collect();
        let air = |rows: &str| format!("date.and.time,temperature,humidity\n{rows}");
        let mut curves = "treatment,sample,fresh.weight,dry.weight,fresh.weight.saturated,\
                          water.potential\nwet,7,5,0.5,6,-3\n"
            .to_string();
        for i in 0..10 {
            let w = 0.7 + 0.03 * f64::from(i);
            let potential = -1.2 * 0.8 / (w - 0.2) + 5.0 * f64::max(w - 0.86, 0.0);
            curves += &format!("dry,8,{},0.5,6,{potential}\n", 0.5 + 5.5 * w);
        }
        let read = |air: &str, curves: Option<&str>| {
            let curves = curves.map(|text| table("c.csv", text));
            read_leaves(table("l.csv", drying), table("a.csv", air), curves).unwrap()
        };
        let groups = read(&air(&hourly), None);
        assert_eq!((groups[0].name.as_str(), groups[0].leaves[0].weights.len()), ("dry", 2));
        assert!(groups[0].notes.is_empty(), "{:?}", groups[0].notes);
        let notes = read(&air(&hourly), Some(&curves))[0].notes.join("; ");
        assert!(notes.contains("the only turgor loss point of dry is not used"), "{notes}");
        assert!(
            notes.contains("curve 7 is left out: no leaf has its treatment, \"wet\""),
            "{notes}"
        );
        let ends = "2019-03-26 08:30:00,20,40\n2019-03-26 14:00:00,20,40\n";
        let notes = read(&air(ends), None)[0].notes.join("; ");
        assert!(notes.contains("not recorded for 5.5 hours"), "{notes}");
    }
}
