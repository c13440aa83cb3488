//! The components of an MTG, as its lines list them.

use std::collections::{BTreeSet, HashMap};

use super::super::lines::Lines;
use catamaran::base::Result;

/// The largest number of components of a file with ranges: `E1<<E9` stands for nine components, so
/// that a short file could fill the memory.
const MOST: usize = 1 << 20;

/// The features that are read: what errors call them, the names of their columns in lower case, and
/// the factor from a number of the column to the feature, which also has its unit.
const FEATURES: [(&str, &[&str], f64); 9] = [
    ("coordinate XX", &["xx", "x"], 1.0),
    ("coordinate YY", &["yy", "y"], 1.0),
    ("coordinate ZZ", &["zz", "z"], 1.0),
    ("length", &["length", "longueur", "long", "len"], 1.0),
    ("radius", &["radius"], 1.0),
    ("diameter", &["diameter", "diam", "topdia", "topdiameter", "diasom"], 0.5),
    ("diameter at the base", &["bottomdia", "bottomdiameter", "botdia", "diabase"], 0.5),
    ("insertion angle", &["insertion", "alpha"], 1.0),
    ("azimuth", &["azimuth", "azimut"], 1.0),
];
pub(super) const LENGTH: usize = 3;
const RADIUS: usize = 4;
const TOP: usize = 5;
pub(super) const BASE: usize = 6;
pub(super) const INSERTION: usize = 7;
pub(super) const AZIMUTH: usize = 8;

/// The largest difference of a radius and half of a diameter of one component, as a part of the
/// radius: that of rounded numbers.
const TWO_RADII: f64 = 0.01;

/// A component of the plant, at any scale.
pub(super) struct Component {
    pub class: String,
    pub index: usize,
    /// The number of its scale: larger is finer.
    pub scale: usize,
    /// The component that it follows or grows on; of the first part of a component, that component.
    pub bearer: Option<usize>,
    /// The nearest coarser component that it is a part of.
    pub whole: Option<usize>,
    /// Whether it grows on its bearer as a branch (`+`).
    pub branch: bool,
    /// Whether it lies on the axis of `whole`, not on a branch within.
    pub on_axis: bool,
    /// The last of its parts on its axis.
    pub tip: Option<usize>,
    /// The numbers of the columns of [`FEATURES`].
    pub features: [Option<f64>; FEATURES.len()],
}

impl Component {
    pub fn name(&self) -> String {
        format!("{}{}", self.class, self.index)
    }

    pub fn position(&self) -> Option<[f64; 3]> {
        let [x, y, z, ..] = self.features;
        Some([x?, y?, z?])
    }

    /// Returns whether the file has a radius or a diameter of the component that is not 0.
    pub fn has_diameter(&self) -> bool {
        self.features[RADIUS..=BASE].iter().flatten().any(|&x| x > 0.0)
    }

    /// Returns the radius at its end.
    pub fn radius(&self) -> Option<f64> {
        self.features[RADIUS].or(self.features[TOP])
    }
}

pub(super) struct Graph {
    pub components: Vec<Component>,
    /// The scale of each class; empty without the section `CLASSES`.
    pub scales: HashMap<String, usize>,
    /// The names of all columns, in lower case.
    pub names: Vec<String>,
    /// The column of each of [`FEATURES`], and the factor of its numbers.
    pub columns: [(Option<usize>, f64); FEATURES.len()],
    /// The last component in each column of the code.
    pub last: Vec<Option<usize>>,
    /// The components that begin a plant.
    pub plants: Vec<usize>,
    /// The classes of components that the section `CLASSES` does not list, in alphabetic order.
    unlisted: BTreeSet<String>,
    /// The number of lines with cells beyond the columns, and the first such cell.
    beyond: Option<(usize, String)>,
}

/// Reads up to the line of column names after `MTG:`. `unit` has the metres in a unit of lengths,
/// and in one of diameters.
pub(super) fn header(lines: &mut Lines<'_>, unit: [f64; 2]) -> Result<Graph> {
    let mut scales = HashMap::new();
    let mut classes = false;
    loop {
        let Some(line) = lines.next_row()? else {
            return Err(lines.fail("the file ends before `MTG:`"));
        };
        let mut words = line.split_whitespace();
        let first = words.next().unwrap_or_default();
        if first.starts_with("MTG") {
            break;
        }
        if first.starts_with("CODE") && line.contains("FORM-B") {
            return Err(lines.fail("the code is FORM-B: only FORM-A is read"));
        }
        if first.starts_with("CLASSES") {
            classes = true;
        } else if first.starts_with("DESCRIPTION") || first.starts_with("FEATURES") {
            classes = false;
        } else if classes && first != "SYMBOL" {
            scales.insert(first.to_owned(), lines.count("scale", words.next())?);
        }
    }
    let Some(line) = lines.next_row()? else {
        return Err(lines.fail("no line of column names after `MTG:`"));
    };
    let names: Vec<String> =
        line.split('\t').map(|name| name.trim().to_ascii_lowercase()).collect();
    if names.len() < 2 && names[0].contains(char::is_whitespace) {
        let what = "the columns are separated by spaces: tabs must separate them";
        return Err(lines.fail(what));
    }
    let mut columns = [(None, 1.0); FEATURES.len()];
    for (kind, (what, known, factor)) in FEATURES.into_iter().enumerate() {
        let found = (0..names.len()).filter(|&i| known.contains(&names[i].as_str()));
        let found: Vec<usize> = found.collect();
        if let [first, second, ..] = found[..] {
            let (first, second) = (&names[first], &names[second]);
            let what = format!("two columns of one {what}, {first:?} and {second:?}: remove one");
            return Err(lines.fail(what));
        }
        let unit = match kind {
            ..=LENGTH => unit[0],
            RADIUS..=BASE => unit[1],
            _ => 1.0,
        };
        columns[kind] = (found.first().copied(), factor * unit);
    }
    // The code takes the columns up to the first name after ENTITY-CODE or TOPO.
    let code = (1..names.len()).find(|&i| !names[i].is_empty()).unwrap_or(names.len());
    let (last, components, plants) = (vec![None; code], Vec::new(), Vec::new());
    let (unlisted, beyond) = (BTreeSet::new(), None);
    Ok(Graph { components, scales, names, columns, last, plants, unlisted, beyond })
}

impl Graph {
    /// Returns what the lines leave open, one sentence each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.unlisted.is_empty() {
            let classes: Vec<&str> = self.unlisted.iter().map(String::as_str).collect();
            notes.push(format!(
                "CLASSES does not list {}: components of the finest scale",
                classes.join(", ")
            ));
        }
        if let Some((count, first)) = &self.beyond {
            let lines = if *count == 1 { "line" } else { "lines" };
            let columns = self.names.len();
            notes.push(format!(
                "cells beyond the {columns} columns are not read: those of {count} {lines}, such \
                 as {first:?}"
            ));
        }
        notes
    }

    /// Adds the components of a line.
    pub fn row(&mut self, lines: &Lines<'_>, line: &str) -> Result<()> {
        let cells: Vec<&str> = line.split('\t').map(str::trim).collect();
        let code = cells.iter().take(self.last.len()).position(|cell| !cell.is_empty());
        let mut beyond = cells.iter().skip(self.names.len());
        if let Some(cell) = beyond.find(|cell| !cell.is_empty()) {
            self.beyond.get_or_insert_with(|| (0, (*cell).to_owned())).0 += 1;
        }
        let Some(place) = code else { return Ok(()) };
        // "^<I3" relates to the last component in its column, "+I3" to the last in the column to
        // the left.
        let rest = cells[place].trim_start_matches('^');
        let same = rest.len() < cells[place].len() || rest == "*";
        let left = self.last[..place].iter().rev().find_map(|v| *v);
        let own = self.last[place];
        let before = if same { own.or(left) } else { left.or(own) };
        let v = match (rest, before) {
            // A later observation of the same component.
            ("*", Some(v)) => v,
            _ => self.code(lines, rest, before, same)?,
        };
        for (kind, &(column, factor)) in self.columns.iter().enumerate() {
            let cell = column.and_then(|column| cells.get(column)).filter(|cell| !cell.is_empty());
            if let Some(&cell) = cell {
                let what = FEATURES[kind].0;
                let number = factor * lines.number(what, Some(cell))?;
                if (LENGTH..=BASE).contains(&kind) && number < 0.0 {
                    return Err(lines.fail(format!("{what}: must be at least 0, is {cell}")));
                }
                self.components[v].features[kind] = Some(number);
            }
        }
        let component = &self.components[v];
        let missing = (0..LENGTH).filter(|&kind| component.features[kind].is_none());
        let missing: Vec<&str> = missing.map(|kind| FEATURES[kind].0).collect();
        if !missing.is_empty() && missing.len() < LENGTH {
            let what = format!("{} has no {}", component.name(), missing.join(" and no "));
            return Err(lines.fail(what));
        }
        if let [Some(radius), Some(other)] = [RADIUS, TOP].map(|kind| component.features[kind])
            && (radius - other).abs() > TWO_RADII * radius.abs()
        {
            let what = format!(
                "{} has a radius of {radius} m, but half of its diameter is {other} m",
                component.name()
            );
            return Err(lines.fail(what));
        }
        if rest != "*" {
            self.last[place] = Some(v);
            self.last[place + 1..].fill(None);
        }
        Ok(())
    }

    /// Adds the components of a code such as `/U1/E1<<E9+B1` and returns the last of them.
    fn code(
        &mut self,
        lines: &Lines<'_>,
        code: &str,
        before: Option<usize>,
        same: bool,
    ) -> Result<usize> {
        let (mut rest, mut last, mut same) = (code, before, same);
        while let Some(link) = rest.chars().next() {
            let after = rest.trim_start_matches(link);
            let range = rest.len() > after.len() + 1;
            let (name, next) = after.split_at(after.find(['/', '<', '+']).unwrap_or(after.len()));
            let name = name.trim();
            if !['/', '<', '+'].contains(&link) || name.is_empty() {
                break;
            }
            rest = next;
            let class = name.trim_end_matches(|c: char| c.is_ascii_digit());
            let index: usize = name[class.len()..].parse().unwrap_or_default();
            let mut first = index;
            if range
                && let Some(from) = last.map(|v| &self.components[v])
                && from.class == class
                && from.index < index
            {
                first = from.index + 1;
                if index - first > MOST.saturating_sub(self.components.len()) {
                    let what = format!("{code:?}: more than {MOST} components by ranges");
                    return Err(lines.fail(what));
                }
            }
            for index in first..=index {
                last = Some(self.add(link, class, index, last, same));
                same = true;
            }
        }
        match last {
            Some(v) if rest.is_empty() && !code.is_empty() => Ok(v),
            _ => {
                let what = format!("{code:?} is not a chain of /, < or +, a class and an index");
                Err(lines.fail(what))
            }
        }
    }

    /// Adds a component that relates to `last`; `same` says that they are in one column or code.
    fn add(
        &mut self,
        link: char,
        class: &str,
        index: usize,
        last: Option<usize>,
        same: bool,
    ) -> usize {
        // The first class of the file is that of plants.
        let first = self.components.first();
        let begins = link == '/' && !same && first.is_none_or(|c| c.class == class);
        let last = last.filter(|_| !begins);
        let finest = || self.scales.values().max().copied().unwrap_or_default();
        let initial = class.chars().next().map(String::from).unwrap_or_default();
        let listed = self.scales.get(class).or_else(|| self.scales.get(&initial)).copied();
        if listed.is_none() && !self.scales.is_empty() {
            self.unlisted.insert(class.to_owned());
        }
        let scale = listed.unwrap_or_else(finest);
        let bearer = last.map(|v| if link == '/' { v } else { self.bearer(v, scale, same) });
        let mut whole = bearer;
        while let Some(w) = whole.filter(|&w| self.components[w].scale >= scale) {
            whole = self.components[w].whole;
        }
        let beside = bearer.map(|v| &self.components[v]).filter(|b| b.whole == whole);
        let on_axis = link != '+' && beside.is_none_or(|b| b.on_axis);
        let v = self.components.len();
        if let Some(w) = whole.filter(|_| on_axis) {
            self.components[w].tip = Some(v);
        }
        if begins {
            self.plants.push(v);
        }
        self.components.push(Component {
            class: class.to_owned(),
            index,
            scale,
            bearer,
            whole,
            branch: link == '+',
            on_axis,
            tip: None,
            features: [None; FEATURES.len()],
        });
        v
    }

    /// Returns the component that bears one of `scale`, which relates to `last`.
    fn bearer(&self, last: usize, scale: usize, same: bool) -> usize {
        // In a column, S4 follows S3 although the branch B2 of S3 stands between them, and so does
        // B3 where the parts of B2 are in columns to the right, as in OpenAlea.
        let passed = |v: &usize| {
            let c = &self.components[*v];
            let finer = c.bearer.is_some_and(|b| self.components[b].scale > c.scale);
            c.scale < scale || (c.tip.is_some() && finer)
        };
        let mut above = Some(last).filter(|_| same);
        while let Some(v) = above.filter(passed) {
            above = self.components[v].bearer;
        }
        let mut v = above.unwrap_or(last);
        while let Some(tip) = self.components[v].tip {
            v = tip;
        }
        v
    }
}
