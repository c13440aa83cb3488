//! Cuts a face along straight chords between points of its sides. The order of the points around
//! the face determines sides and crossings; coordinates only give the positions of crossings.

use crate::mesh::vector::Vector;
use crate::mesh::{interpolate, quality};
use catamaran::base::{Error, Result};

/// Positions on a chord nearer than this are one point.
const SAME: f64 = 1e-9;

/// A point of the face: its barycentric coordinates, and its vertex in the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    pub shares: [f64; 3],
    /// The index of its vertex in the mesh; `None` for crossings of chords.
    pub vertex: Option<u32>,
}

/// A convex part of the face, as its points counter-clockwise, each with the line that leads to the
/// next: sides 0, 1, 2, then chords.
type Cell = Vec<(usize, usize)>;

/// A straight line from one point of the sides to another, and the points on it.
struct Chord {
    ends: [usize; 2],
    /// Positions from the first end, and the points there; sorted.
    stops: Vec<(f64, usize)>,
}

/// A face, cut into cells.
pub(super) struct Cells {
    /// The points of the sides counter-clockwise from corner 0, then crossings.
    pub points: Vec<Point>,
    /// Number of points on the sides.
    around: usize,
    /// The positions of the corners among the points.
    corners: [usize; 3],
    cells: Vec<Cell>,
    chords: Vec<Chord>,
}

impl Cells {
    /// Creates a face with points on its sides. Each side begins with its first corner, followed by
    /// its points.
    pub fn new(sides: [Vec<Point>; 3]) -> Self {
        let corners = [0, sides[0].len(), sides[0].len() + sides[1].len()];
        let cell = (sides.iter().enumerate())
            .flat_map(|(side, points)| std::iter::repeat_n(side, points.len()))
            .enumerate()
            .collect();
        let points = sides.concat();
        Self { around: points.len(), points, corners, cells: vec![cell], chords: Vec::new() }
    }

    /// Returns whether two points of the sides are on a common side.
    fn on_one_side(&self, a: usize, b: usize) -> bool {
        let sides = |p: usize| {
            let [_, second, third] = self.corners;
            let own = usize::from(p >= second) + usize::from(p >= third);
            let corner = self.corners.contains(&p);
            [Some(own), corner.then_some((own + 2) % 3)]
        };
        let others = sides(b);
        sides(a).into_iter().flatten().any(|side| others.contains(&Some(side)))
    }

    /// Cuts along the line between two points of the sides, and returns the points on that line,
    /// both ends included.
    ///
    /// # Errors
    /// [`Error::NotConverged`] when rounding leaves no consistent order of crossings.
    pub fn cut(&mut self, a: usize, b: usize) -> Result<Vec<usize>> {
        if a == b {
            return Ok(vec![a]);
        }
        if self.on_one_side(a, b) {
            return Ok(self.along_side(a, b));
        }
        if let Some(known) = self.chords.iter().find(|c| c.ends == [a, b] || c.ends == [b, a]) {
            let mut stops: Vec<usize> = known.stops.iter().map(|&(_, p)| p).collect();
            if known.ends[0] != a {
                stops.reverse();
            }
            return Ok(stops);
        }
        let mut stops = vec![(0.0, a)];
        for chord in 0..self.chords.len() {
            if let Some(stop) = self.cross([a, b], chord) {
                stops.push(stop);
            }
        }
        stops.push((1.0, b));
        stops.sort_by(|x, y| x.0.total_cmp(&y.0));
        stops.dedup_by_key(|stop| stop.1);
        let line = 3 + self.chords.len();
        for pair in stops.windows(2) {
            self.split(pair[0].1, pair[1].1, line)?;
        }
        let passed = stops.iter().map(|&(_, p)| p).collect();
        self.chords.push(Chord { ends: [a, b], stops });
        Ok(passed)
    }

    /// Returns the points between two points of the same side.
    fn along_side(&self, a: usize, b: usize) -> Vec<usize> {
        let ahead = |from: usize, to: usize| -> Vec<usize> {
            let steps = (to + self.around - from) % self.around;
            (0..=steps).map(|i| (from + i) % self.around).collect()
        };
        let (one, mut other) = (ahead(a, b), ahead(b, a));
        // The path along the side has no corner inside.
        let inside = |way: &[usize]| way[1..way.len() - 1].iter().any(|p| self.corners.contains(p));
        if inside(&one) {
            other.reverse();
            other
        } else {
            one
        }
    }

    /// Returns where a new line crosses a chord, with a point that is created there; `None` if it
    /// does not cross.
    fn cross(&mut self, [a, b]: [usize; 2], chord: usize) -> Option<(f64, usize)> {
        let [c, d] = self.chords[chord].ends;
        let between = |p: usize| (a.min(b)..a.max(b)).contains(&p);
        if [a, b].contains(&c) || [a, b].contains(&d) || between(c) == between(d) {
            return None;
        }
        let [p, q, r, s] = [a, b, c, d].map(|i| {
            let [_, x, y] = self.points[i].shares;
            [x, y]
        });
        let turn = |u: [f64; 2], v: [f64; 2]| u[0] * v[1] - u[1] * v[0];
        let to = |u: [f64; 2], v: [f64; 2]| [v[0] - u[0], v[1] - u[1]];
        let whole = turn(to(p, q), to(r, s));
        let part = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.5 };
        let along_new = part(turn(to(p, r), to(r, s)) / whole);
        let along_old = part(turn(to(p, r), to(p, q)) / whole);
        let stops = &self.chords[chord].stops;
        let last = stops.len() - 1;
        // The ends of the chord are excluded, because they are not on the new line.
        if let Some(&(_, known)) =
            stops[1..last].iter().find(|stop| (stop.0 - along_old).abs() <= SAME)
        {
            return Some((along_new, known));
        }
        let at = stops[1..last].partition_point(|stop| stop.0 < along_old) + 1;
        let (before, after) = (stops[at - 1].1, stops[at].1);
        let shares = std::array::from_fn(|k| {
            let [from, to] = [c, d].map(|i| self.points[i].shares[k]);
            from + along_old * (to - from)
        });
        let new = self.points.len();
        self.points.push(Point { shares, vertex: None });
        self.chords[chord].stops.insert(at, (along_old, new));
        for cell in &mut self.cells {
            let n = cell.len();
            let edge = (0..n).find(|&i| {
                let ends = [cell[i].0, cell[(i + 1) % n].0];
                ends == [before, after] || ends == [after, before]
            });
            if let Some(i) = edge {
                cell.insert(i + 1, (new, cell[i].1));
            }
        }
        Some((along_new, new))
    }

    /// Cuts the cell that has both points, unless they already share an edge of it.
    fn split(&mut self, a: usize, b: usize, line: usize) -> Result<()> {
        let place = |cell: &Cell, p: usize| cell.iter().position(|&(q, _)| p == q);
        for k in 0..self.cells.len() {
            let cell = &self.cells[k];
            let (Some(i), Some(j)) = (place(cell, a), place(cell, b)) else { continue };
            let (i, j) = (i.min(j), i.max(j));
            if j - i == 1 || j - i == cell.len() - 1 {
                return Ok(());
            }
            let mut one = cell[i..=j].to_vec();
            let mut other: Cell = cell[j..].iter().chain(&cell[..=i]).copied().collect();
            for part in [&mut one, &mut other] {
                if let Some(last) = part.last_mut() {
                    last.1 = line;
                }
            }
            self.cells[k] = one;
            self.cells.push(other);
            return Ok(());
        }
        Err(Error::NotConverged { iterations: self.chords.len(), residual: SAME })
    }

    /// Returns the triangles of all cells, as points. The best shaped triangles are cut off first;
    /// none has its corners on one line.
    pub fn triangles(&self, corners: [Vector; 3]) -> Vec<[usize; 3]> {
        let place = |i: usize| self.place(i, corners);
        let mut all = Vec::new();
        for cell in &self.cells {
            let mut rest: Vec<usize> = cell.iter().map(|&(p, _)| p).collect();
            // For each point the lines that contain it.
            let mut lines: Vec<Vec<usize>> = (0..cell.len())
                .map(|i| vec![cell[(i + cell.len() - 1) % cell.len()].1, cell[i].1])
                .collect();
            let mut new = usize::MAX;
            while rest.len() > 3 {
                let n = rest.len();
                let triple = |i: usize| [(i + n - 1) % n, i, (i + 1) % n];
                let fits = |&i: &usize| {
                    let [before, _, after] = triple(i);
                    !lines[before].iter().any(|line| lines[after].contains(line))
                };
                let shape = |i: usize| quality(triple(i).map(|k| place(rest[k])));
                let best = (0..n).filter(fits).rev().max_by(|&i, &j| shape(i).total_cmp(&shape(j)));
                // A convex cell of more than three points always has such a triangle.
                let i = best.unwrap_or(0);
                let [before, _, after] = triple(i);
                all.push(triple(i).map(|k| rest[k]));
                lines[before].push(new);
                lines[after].push(new);
                new -= 1;
                rest.remove(i);
                lines.remove(i);
            }
            if let [a, b, c] = rest[..] {
                all.push([a, b, c]);
            }
        }
        all
    }

    /// Returns the position of a point, in a face with these corners.
    pub fn place(&self, point: usize, corners: [Vector; 3]) -> Vector {
        interpolate(self.points[point].shares, corners)
    }
}
