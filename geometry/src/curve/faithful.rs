//! Algorithm 6.1 of the thesis with the maximum-angle heuristic of section 6.3.2.

use super::result::Outcome;
use super::surface::Surface;
use crate::mesh::Search;
use crate::mesh::vector::{cross, dot, norm, sub};
use catamaran::base::{Progress, Result};

/// The result of a walk: the order of samples, and the vertices of the curve.
pub(super) struct Walk {
    pub outcome: Outcome,
    pub order: Vec<u32>,
    pub path: Vec<u32>,
}

/// A candidate for the next sample.
#[derive(Clone, Copy)]
struct Candidate {
    sample: u32,
    distance: f64,
}

/// States of a vertex: free, a sample that is not yet visited, or on the curve.
const FREE: u8 = 0;
const WAITING: u8 = 1;
const CURVE: u8 = 2;

/// A walker on a surface, with a state for each vertex, all [`FREE`] before and after.
pub(super) struct Walker<'a, 'm> {
    pub surface: &'a Surface<'m>,
    pub search: &'a mut Search,
    pub marks: &'a mut Vec<u8>,
    pub samples: &'a [u32],
}

impl Walker<'_, '_> {
    /// Walks from sample number `start` to one of the `candidates` nearest samples, and so on, and
    /// back to the start; reports each sample to `progress`.
    ///
    /// # Errors
    /// [`Error::Cancelled`](catamaran::Error::Cancelled).
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
        // Samples that the curve has cut off stay so, because the curve only grows: no search looks
        // for them again.
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
        // The first sample becomes a free target again, to close the curve.
        self.marks[self.samples[first as usize] as usize] = WAITING;
        match self.route(last, first) {
            Some(path) => {
                walk.path.extend(&path[1..path.len() - 1]);
                Ok(Outcome::Closed)
            }
            None => Ok(Outcome::CloseBlocked),
        }
    }

    /// Returns the nearest samples that are not yet visited, the nearest first. Paths may cross
    /// other such samples, but not the curve.
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

    /// Chooses the next sample.
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
            // At distance 0 it is the same point.
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

    /// Returns the angle at sample b between a and c in space, in [0, pi].
    fn angle(&self, a: u32, b: u32, c: u32) -> f64 {
        let [a, b, c] = [a, b, c].map(|s| self.surface.position(self.samples[s as usize]));
        let (x, y) = (sub(a, b), sub(c, b));
        norm(cross(x, y)).atan2(dot(x, y))
    }

    /// Returns the shortest path between two samples that avoids the curve and the other samples.
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
