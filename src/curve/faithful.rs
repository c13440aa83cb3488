//! Algorithm 6.1 of the thesis with the maximum-angle heuristic of section 6.3.2.

use super::result::Outcome;
use super::search::Search;
use super::surface::Surface;
use crate::base::{Progress, Result};
use crate::mesh::vector::{cross, dot, norm, sub};

/// What was found: the order of samples, and the vertices of the curve.
pub(super) struct Walk {
    pub outcome: Outcome,
    pub order: Vec<u32>,
    pub path: Vec<u32>,
}

/// A sample that could be next.
#[derive(Clone, Copy)]
struct Candidate {
    sample: u32,
    distance: f64,
}

/// State of a vertex: nothing is there, a sample that waits, or the curve.
const FREE: u8 = 0;
const WAITING: u8 = 1;
const CURVE: u8 = 2;

/// Who walks: the surface, and marks of its vertices, all [`FREE`] before and after.
pub(super) struct Walker<'a, 'm> {
    pub surface: &'a Surface<'m>,
    pub search: &'a mut Search,
    pub marks: &'a mut Vec<u8>,
    pub samples: &'a [u32],
}

impl Walker<'_, '_> {
    /// Walks from sample number `start` to one of the `candidates` nearest, and so on, and back;
    /// reports each sample.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled).
    pub fn walk(
        &mut self,
        start: u32,
        candidates: usize,
        open: bool,
        progress: Progress<'_>,
    ) -> Result<Walk> {
        for &v in self.samples {
            self.marks[v as usize] = WAITING;
        }
        let mut walk = Walk {
            outcome: Outcome::Closed,
            order: vec![start],
            path: vec![self.samples[start as usize]],
        };
        self.marks[walk.path[0] as usize] = CURVE;
        let done = self.grow(&mut walk, candidates, open, progress);
        for &v in self.samples.iter().chain(&walk.path) {
            self.marks[v as usize] = FREE;
        }
        done.map(|outcome| Walk { outcome, ..walk })
    }

    fn grow(
        &mut self,
        walk: &mut Walk,
        candidates: usize,
        open: bool,
        progress: Progress<'_>,
    ) -> Result<Outcome> {
        let count = self.samples.len();
        let mut previous = None;
        // What the curve has shut off stays so, as the curve only grows: no search looks for it
        // twice.
        let mut reachable = count - 1;
        while walk.order.len() < count {
            progress.report(walk.order.len() as f64 / count as f64)?;
            let at = walk.order[walk.order.len() - 1];
            let blocked = Outcome::Blocked { at, remaining: count - walk.order.len() };
            let wanted = candidates.min(reachable);
            let near = self.nearest(at, wanted);
            if near.len() < wanted {
                reachable = near.len();
            }
            let Some(next) = self.choose(previous, at, &near) else { return Ok(blocked) };
            let Some(path) = self.route(at, next) else { return Ok(blocked) };
            for &v in &path {
                self.marks[v as usize] = CURVE;
            }
            walk.path.extend(&path[1..]);
            walk.order.push(next);
            previous = Some(at);
            reachable -= 1;
        }
        if open {
            return Ok(Outcome::Open);
        }
        let (first, last) = (walk.order[0], walk.order[count - 1]);
        // The first sample alone is free again.
        self.marks[self.samples[first as usize] as usize] = WAITING;
        match self.route(last, first) {
            Some(path) => {
                walk.path.extend(&path[1..path.len() - 1]);
                Ok(Outcome::Closed)
            }
            None => Ok(Outcome::CloseBlocked),
        }
    }

    /// The nearest waiting samples, the nearest first; ways lead over other waiting samples, but
    /// not over the curve.
    fn nearest(&mut self, at: u32, wanted: usize) -> Vec<Candidate> {
        let mut found = Vec::new();
        if wanted == 0 {
            return found;
        }
        self.search.start(&[self.samples[at as usize]]);
        while let Some((v, from)) = self.search.next() {
            if self.marks[v as usize] == WAITING {
                let sample = self.samples.iter().position(|&s| s == v).unwrap_or_default() as u32;
                found.push(Candidate { sample, distance: from });
                if found.len() == wanted {
                    break;
                }
            }
            for (u, length) in self.surface.neighbours(v) {
                if self.marks[u as usize] != CURVE {
                    self.search.relax(v, u, from + length, 0.0);
                }
            }
        }
        found
    }

    /// The next sample.
    fn choose(&self, previous: Option<u32>, at: u32, near: &[Candidate]) -> Option<u32> {
        let [first, _, ..] = near else { return near.first().map(|c| c.sample) };
        let Some(previous) = previous else {
            let mut best = (f64::NEG_INFINITY, 0.0, first.sample);
            for (i, a) in near.iter().enumerate() {
                for b in &near[i + 1..] {
                    let (angle, sum) =
                        (self.angle(a.sample, at, b.sample), a.distance + b.distance);
                    if angle > best.0 || angle == best.0 && sum < best.1 {
                        best = (angle, sum, a.sample);
                    }
                }
            }
            return Some(best.2);
        };
        let mut best = (f64::NEG_INFINITY, first.sample);
        for c in near {
            // At no distance it is the same point.
            let value = match c.distance > 0.0 {
                true => self.angle(c.sample, at, previous) / (c.distance * c.distance),
                false => f64::INFINITY,
            };
            if value > best.0 {
                best = (value, c.sample);
            }
        }
        Some(best.1)
    }

    /// The angle at sample b between a and c in space, in [0, pi].
    fn angle(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|s| self.surface.position(self.samples[s as usize]));
        let (x, y) = (sub(a, b), sub(c, b));
        norm(cross(x, y)).atan2(dot(x, y))
    }

    /// The shortest path between two samples that meets neither the curve nor other waiting
    /// samples.
    fn route(&mut self, from: u32, to: u32) -> Option<Vec<u32>> {
        let [from, to] = [from, to].map(|s| self.samples[s as usize]);
        self.search.start(&[from]);
        while let Some((v, length)) = self.search.next() {
            if v == to {
                return Some(self.search.path(v));
            }
            for (u, edge) in self.surface.neighbours(v) {
                if u == to || self.marks[u as usize] == FREE {
                    self.search.relax(v, u, length + edge, 0.0);
                }
            }
        }
        None
    }
}
