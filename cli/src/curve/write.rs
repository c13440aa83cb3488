//! Writes curves to files.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Result, bail};
use catamaran::io::Output;
use catamaran_geometry::curve::Reconstruction;
use catamaran_geometry::mesh::SurfacePoint;

use super::samples::Group;

/// The format of a file of curves.
#[derive(Clone, Copy)]
pub enum Format {
    Obj,
    Json,
}

impl Format {
    /// Returns the format that a name selects.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("obj") => Ok(Self::Obj),
            Some("json") => Ok(Self::Json),
            _ => bail!("{}: the name must end in .obj or .json", path.display()),
        }
    }
}

/// The result for each group of samples.
pub type Found<'a> = [(&'a Group, &'a Reconstruction)];

/// Returns the first group that is not complete, else the first: its outcome is that of all.
pub fn first<'a>(found: &Found<'a>) -> Option<(&'a Group, &'a Reconstruction)> {
    let is_incomplete = |(_, found): &&(&Group, &Reconstruction)| !found.outcome.is_complete();
    found.iter().find(is_incomplete).or(found.first()).copied()
}

/// The points of each curve of each group, on the faces of the mesh of the command line.
pub type Places = [Vec<Vec<SurfacePoint>>];

/// Writes the curves.
pub fn write(mut output: Output, found: &Found<'_>, places: &Places, format: Format) -> Result<()> {
    let text = match format {
        Format::Obj => obj(found),
        Format::Json => json(found, places),
    };
    output.write_all(text.as_bytes()).map_err(|e| output.error(e))?;
    Ok(output.commit()?)
}

fn obj(found: &Found<'_>) -> String {
    let mut text = String::new();
    let mut first = 1;
    for (group, found) in found {
        if let Some(name) = &group.name {
            let _ = writeln!(text, "o {name}");
        }
        for curve in &found.curves {
            text += &line(&curve.points, first, curve.closed);
            first += curve.points.len();
        }
    }
    text
}

/// Returns points and the line through them, for a file that already has `first - 1` points.
pub fn line(points: &[[f64; 3]], first: usize, closed: bool) -> String {
    let mut text: String = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let numbers = (first..first + points.len()).chain(closed.then_some(first));
    if points.len() > 1 {
        let numbers: Vec<String> = numbers.map(|i| i.to_string()).collect();
        let _ = writeln!(text, "l {}", numbers.join(" "));
    }
    text
}

fn list<T: ToString>(all: impl Iterator<Item = T>) -> String {
    let numbers: Vec<String> = all.map(|x| x.to_string()).collect();
    format!("[{}]", numbers.join(", "))
}

/// Returns the curves as JSON. `order` and `path` join those of all curves; `curves` has them one
/// by one, and the face and the barycentric coordinates of each point. Samples are numbered over
/// the whole file.
fn json(found: &Found<'_>, places: &Places) -> String {
    let mut each = Vec::new();
    let (mut order, mut path) = (Vec::new(), Vec::<u32>::new());
    let (mut left_out, mut outliers) = (Vec::new(), Vec::new());
    for ((group, found), places) in found.iter().zip(places) {
        left_out.extend(group.numbers(&found.left_out));
        outliers.extend(group.numbers(&found.outliers));
        let name = group.name.as_ref();
        let name = name.map_or(String::new(), |name| format!("\"name\": \"{name}\", "));
        for (curve, places) in found.curves.iter().zip(places) {
            let weights = places.iter().map(|place| place.weights);
            let weights = weights.map(|[a, b, c]| format!("[{a}, {b}, {c}]"));
            let points = curve.points.iter().map(|[x, y, z]| format!("[{x}, {y}, {z}]"));
            each.push(format!(
                "    {{{name}\"closed\": {}, \"length\": {}, \"order\": {}, \"path\": {}, \
                 \"points\": {}, \"faces\": {}, \"weights\": {}}}",
                curve.closed,
                curve.length,
                list(group.numbers(&curve.order)),
                list(curve.path.iter()),
                list(points),
                list(places.iter().map(|place| place.face)),
                list(weights)
            ));
            order.extend(group.numbers(&curve.order));
            path.extend(&curve.path);
        }
    }
    let length: f64 = found.iter().fold(0.0, |sum, (_, found)| sum + found.length());
    format!(
        "{{\n  \"outcome\": \"{}\",\n  \"length\": {length},\n  \"order\": {},\n  \
         \"left_out\": {},\n  \"outliers\": {},\n  \"path\": {},\n  \"curves\": [\n{}\n  ]\n}}\n",
        first(found).map_or("", |(_, found)| found.outcome.name()),
        list(order.into_iter()),
        list(left_out.into_iter()),
        list(outliers.into_iter()),
        list(path.into_iter()),
        each.join(",\n")
    )
}
