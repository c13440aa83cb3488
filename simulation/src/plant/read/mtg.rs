//! MTG, the multiscale tree graphs of AMAPmod and OpenAlea (Godin and Caraglio 1998); reads the
//! finest scale with coordinates.

use super::super::{Plant, Segment};
use super::lines::Lines;
use catamaran::base::Result;

/// The columns of features, by name.
struct Columns {
    /// Number of columns of the code before the first feature.
    code: usize,
    position: [usize; 3],
    radius: usize,
    /// Factor from a number of that column to a radius.
    scale: f64,
}

pub(super) fn read(lines: &mut Lines<'_>) -> Result<Plant> {
    let columns = header(lines)?;
    let (mut segments, mut parents) = (Vec::new(), Vec::<Option<u32>>::new());
    // The last node of the axis in each column of the code.
    let mut last: Vec<Option<u32>> = vec![None; columns.code];
    // `lines` removes comments and blank lines, but not tabs at the beginning of a line.
    while let Some(line) = lines.next_row()? {
        let cells: Vec<&str> = line.split('\t').map(str::trim).collect();
        let Some(place) = cells.iter().take(columns.code).position(|cell| !cell.is_empty()) else {
            continue;
        };
        let code = cells[place];
        let cell = |column: usize| cells.get(column).copied().filter(|cell| !cell.is_empty());
        if columns.position.iter().any(|&column| cell(column).is_none()) {
            continue; // a coarser scale, such as a plant or an axis, has no coordinates
        }
        // "^<I3" continues from the last node of its column, "+I3" branches off from it, "/I3"
        // begins an axis.
        let code = code.trim_start_matches('^');
        let link = code.rfind(['/', '<', '+']).map(|i| (code.as_bytes()[i], &code[i + 1..]));
        let Some((link, name)) = link else {
            return Err(lines.fail(format!("{code:?} has none of the relations /, < and +")));
        };
        let known = last[..=place].iter().rev().find_map(|v| *v);
        let parent = if link == b'/' && segments.is_empty() { None } else { known };
        let mut tail = [0.0; 3];
        for (x, &column) in tail.iter_mut().zip(&columns.position) {
            *x = lines.number("coordinate", cell(column))?;
        }
        let radius = columns.scale * lines.number("radius", cell(columns.radius))?;
        let mut segment = Segment::stem(tail, radius);
        segment.leaf = name.starts_with(['L', 'l']);
        segment.petiole = name.starts_with(['P', 'p']);
        last[place] = Some(segments.len() as u32);
        last[place + 1..].fill(None);
        parents.push(parent);
        segments.push(segment);
    }
    Plant::new(segments, &parents, None)
}

/// Reads up to the line of column names after `MTG:`.
fn header(lines: &mut Lines<'_>) -> Result<Columns> {
    while !lines.expect("`MTG:`")?.starts_with("MTG") {}
    let Some(line) = lines.next_row()? else {
        return Err(lines.fail("no line of column names after `MTG:`"));
    };
    let names: Vec<String> =
        line.split('\t').map(|name| name.trim().to_ascii_lowercase()).collect();
    let find = |names_of: &[&str]| names.iter().position(|name| names_of.contains(&name.as_str()));
    let (x, y, z) = (find(&["xx", "x"]), find(&["yy", "y"]), find(&["zz", "z"]));
    let (Some(x), Some(y), Some(z)) = (x, y, z) else {
        return Err(lines.fail("no columns XX, YY and ZZ: a plant needs positions"));
    };
    let (radius, scale) = match (find(&["radius"]), find(&["diameter"])) {
        (Some(radius), _) => (radius, 1.0),
        (None, Some(diameter)) => (diameter, 0.5),
        (None, None) => return Err(lines.fail("no column Radius or Diameter")),
    };
    // The code takes the columns up to the first name after ENTITY-CODE.
    let code = (1..names.len()).find(|&i| !names[i].is_empty()).unwrap_or(1);
    Ok(Columns { code, position: [x, y, z], radius, scale })
}
