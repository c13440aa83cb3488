//! The shape of an MTG: from the coordinates of its components, or, without any, from their lengths
//! and angles by a turtle (Prusinkiewicz and Lindenmayer 1990, section 1.5).

use std::ops::Range;

use super::super::super::{Plant, Segment};
use super::super::lines::Lines;
use super::graph::{AZIMUTH, BASE, Component, Graph, INSERTION, LENGTH};
use catamaran::base::Result;
use catamaran_geometry::mesh::vector::{add, cross, distance, scale};

/// The angle between a branch and its bearer where the file gives none, in degrees.
const DEFAULT_INSERTION: f64 = 45.0;

/// The turn around the bearer from one branch to the next where the file gives none, in degrees:
/// the golden angle, the commonest phyllotaxis.
const DEFAULT_AZIMUTH: f64 = 137.507_764;

/// The radius of a plant without diameters, as a fraction of the mean length of its segments.
const SLENDERNESS: f64 = 0.05;

/// The direction of a segment and one at right angles.
type Frame = [[f64; 3]; 2];
const UPRIGHT: Frame = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];

/// The size of a component.
#[derive(Clone, Copy)]
struct Size {
    length: Option<f64>,
    /// The radii at its two ends.
    base: Option<f64>,
    top: Option<f64>,
}

/// The turns between a component and the segment that bears it.
#[derive(Clone, Copy, Default)]
struct Turn {
    branch: bool,
    insertion: Option<f64>,
    azimuth: Option<f64>,
}

/// Makes a plant of the `chosen` components with coordinates, or with lengths if none has
/// coordinates; the others are merged with the component that bears them.
pub(super) fn plant(graph: &Graph, chosen: Range<usize>, lines: &Lines<'_>) -> Result<Plant> {
    let parts = &graph.components;
    let sizes = sizes(parts);
    let positioned = parts[chosen.clone()].iter().any(|c| c.position().is_some());
    let length = |v: usize| sizes[v].length.filter(|&h: &f64| h > 0.0);
    let shaped =
        |v: usize| if positioned { parts[v].position().is_some() } else { length(v).is_some() };
    let finest = chosen.clone().filter(|&v| shaped(v)).map(|v| parts[v].scale).max();
    let Some(finest) = finest else { return Err(lines.fail(without_shape(graph, chosen.len()))) };
    let mut base = (!positioned).then_some([0.0; 3]);
    let (mut segments, mut parents): (Vec<Segment>, Vec<Option<u32>>) = (vec![], vec![]);
    let (mut radii, mut frames) = (Vec::new(), Vec::<Frame>::new());
    // Branches without an insertion angle, and those without an azimuth.
    let (mut total, mut guessed, mut unturned) = (0.0, 0, 0);
    // For each component: the last segment up to it, and the turns since.
    let mut nodes: Vec<Option<u32>> = Vec::with_capacity(parts.len());
    let mut turns: Vec<Turn> = Vec::with_capacity(parts.len());
    for (v, part) in parts.iter().enumerate() {
        let above = part.bearer.and_then(|b| nodes[b]);
        let before = part.bearer.map(|b| turns[b]).unwrap_or_default();
        let turn = Turn {
            branch: part.branch || before.branch,
            insertion: part.features[INSERTION].or(before.insertion),
            azimuth: part.features[AZIMUTH].or(before.azimuth),
        };
        nodes.push(above);
        turns.push(turn);
        if !chosen.contains(&v) {
            continue;
        }
        let head = above.map(|p| segments[p as usize].tail).or(base);
        let (tail, frame) = match (part.position(), length(v)) {
            (Some(tail), _) => (tail, UPRIGHT),
            (None, Some(length)) if !positioned => {
                let frame = above.map_or(UPRIGHT, |p| frames[p as usize]);
                guessed += usize::from(turn.branch && turn.insertion.is_none());
                unturned += usize::from(turn.branch && turn.azimuth.is_none());
                let frame = turned(frame, turn, unturned);
                (add(head.unwrap_or_default(), scale(frame[0], length)), frame)
            }
            _ => continue,
        };
        // The coordinates of a plant or an axis with parts are those of the place where it begins.
        if head.is_none() && part.scale < finest {
            base = Some(tail);
            continue;
        }
        if head == Some(tail) {
            continue;
        }
        if above.is_none() && !segments.is_empty() {
            let what = format!(
                "{} begins a second stem: no component with coordinates or a length joins it to \
                 the first",
                part.name()
            );
            return Err(lines.fail(what));
        }
        total += head.map_or(0.0, |head| distance(head, tail));
        let mut segment = Segment::stem(tail, 0.0);
        segment.leaf = part.class.starts_with(['L', 'l']);
        segment.petiole = part.class.starts_with(['P', 'p']);
        nodes[v] = Some(segments.len() as u32);
        turns[v] = Turn::default();
        segments.push(segment);
        parents.push(above);
        frames.push(frame);
        radii.push(sizes[v].top.or(sizes[v].base).filter(|&r| r != 0.0));
    }
    let count = segments.len();
    let mut notes = graph.notes();
    if count < chosen.len() {
        let (merged, what) =
            (chosen.len() - count, if positioned { "coordinates" } else { "length" });
        notes.push(format!(
            "{merged} of {} components are no segments: they have parts, or no {what}",
            chosen.len()
        ));
    }
    if guessed > 0 {
        notes.push(format!(
            "no insertion angle for {guessed} of the branches: {DEFAULT_INSERTION} degrees"
        ));
    }
    // A segment without a diameter has its bearer's; the first has the largest.
    let largest = radii.iter().flatten().copied().fold(0.0, f64::max);
    let mean = if total > 0.0 { total / count as f64 } else { 0.01 };
    let first = if largest > 0.0 { largest } else { SLENDERNESS * mean };
    for v in 0..count {
        let bearer = parents[v].map_or(first, |p| segments[p as usize].radius);
        segments[v].radius = radii[v].unwrap_or(bearer);
    }
    let has_diameters = parts[chosen].iter().any(Component::has_diameter);
    notes.extend(note_on_radii(&radii, largest, has_diameters));
    Ok(Plant::new(segments, &parents, base)?.noting(notes))
}

/// Returns a note on segments without a radius; `has_diameters` says whether any component of the
/// plant has one.
fn note_on_radii(radii: &[Option<f64>], largest: f64, has_diameters: bool) -> Option<String> {
    let (count, missing) = (radii.len(), radii.iter().filter(|r| r.is_none()).count());
    let radius = format!("the radius is {SLENDERNESS} times the mean length");
    match missing {
        0 => None,
        _ if largest > 0.0 => {
            let first = match radii[0] {
                None => ", and the first one the largest",
                Some(_) => "",
            };
            Some(format!(
                "{missing} of {count} segments have no diameter: they take that of their \
                 bearers{first}"
            ))
        }
        _ if has_diameters => {
            Some(format!("diameters only of components that are no segments: {radius}"))
        }
        _ => Some(format!("no diameters: {radius}")),
    }
}

/// Returns why no component has a shape.
fn without_shape(graph: &Graph, count: usize) -> String {
    if count == 0 {
        return "no component after the column names".into();
    }
    if ["l1", "l2", "l3"].iter().all(|&name| graph.names.iter().any(|n| n == name)) {
        return "the positions are distances to three points (columns L1, L2, L3): compute \
                coordinates XX, YY and ZZ from them first"
            .into();
    }
    format!(
        "no component has coordinates (columns XX, YY, ZZ) or a length (column Length): the file \
         says how {count} components are connected, not where they are"
    )
}

/// Returns the sizes of the components. A component passes its length on to the parts on its axis,
/// in equal shares, unless one of them is measured, and its radii to parts without.
fn sizes(components: &[Component]) -> Vec<Size> {
    let whole = |c: &Component| c.whole.filter(|_| c.on_axis);
    let mut counts = vec![0_u32; components.len()];
    let mut measured = vec![false; components.len()];
    for c in components {
        if let Some(w) = whole(c) {
            counts[w] += 1;
            measured[w] |= c.features[LENGTH].is_some();
        }
    }
    let mut sizes: Vec<Size> = Vec::with_capacity(components.len());
    let mut seen = vec![0; components.len()];
    for c in components {
        let mut size = Size { length: c.features[LENGTH], base: c.features[BASE], top: c.radius() };
        if let Some(w) = whole(c) {
            let (of, share) = (sizes[w], 1.0 / f64::from(counts[w]));
            if !measured[w] {
                size.length = of.length.map(|length| length * share);
            }
            if size.top.is_none()
                && let Some(top) = of.top.or(of.base)
            {
                let from = of.base.unwrap_or(top);
                let at = |k: u32| Some(from + (top - from) * f64::from(k) * share);
                size.base = at(seen[w]);
                size.top = at(seen[w] + 1);
            }
            seen[w] += 1;
        }
        sizes.push(size);
    }
    for (size, _) in sizes.iter_mut().zip(counts).filter(|(_, count)| *count > 0) {
        size.length = None;
    }
    sizes
}

/// Returns the frame after a turn; `number` counts the branches without an azimuth.
fn turned([along, side]: Frame, turn: Turn, number: usize) -> Frame {
    let default = if turn.branch { DEFAULT_INSERTION } else { 0.0 };
    let insertion = turn.insertion.unwrap_or(default);
    let azimuth = turn.azimuth.unwrap_or(match turn.branch {
        true => DEFAULT_AZIMUTH * number as f64,
        false => 0.0,
    });
    let (sine, cosine) = azimuth.to_radians().sin_cos();
    let side = add(scale(side, cosine), scale(cross(along, side), sine));
    let (sine, cosine) = insertion.to_radians().sin_cos();
    let across = add(scale(side, cosine), scale(along, -sine));
    [add(scale(along, cosine), scale(side, sine)), across]
}
