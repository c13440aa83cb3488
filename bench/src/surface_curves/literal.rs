//! Algorithm 6.1 by the letter of the text, in which only the curve blocks: a path may run over a
//! sample that is not yet visited. The text does not say what happens to that sample; in the
//! library's faithful mode, paths avoid such samples instead.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::iter::successors;

use catamaran_geometry::mesh::Graph;

/// The treatment of samples that a path runs over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passed {
    /// They stay on the list, behind the curve, which never reaches them: the walk ends.
    Lost,
    /// They are removed from the list, in the order of the path.
    Taken,
}

/// Returns the order in which a curve that starts at sample 0 meets the samples, as far as it gets.
pub fn walk(
    graph: &Graph,
    positions: &[[f64; 3]],
    samples: &[u32],
    candidates: usize,
    passed: Passed,
) -> Vec<u32> {
    let mut waiting = vec![None; graph.len()];
    for (&v, sample) in samples.iter().zip(0..) {
        waiting[v as usize] = Some(sample);
    }
    let mut order = vec![0];
    let mut curve = vec![false; graph.len()];
    waiting[samples[0] as usize] = None;
    curve[samples[0] as usize] = true;
    let mut previous: Option<u32> = None;
    let mut reachable = samples.len() - 1;
    while order.len() < samples.len() {
        let at = samples[order[order.len() - 1] as usize];
        let wanted = candidates.min(reachable);
        let (near, predecessors) = nearest(graph, at, &waiting, &curve, wanted);
        // Vertices that the curve has cut off stay so.
        reachable = if near.len() < wanted { near.len() } else { reachable };
        let angle = |a: u32, c: u32| {
            let [a, b, c] = [a, at, c].map(|v| positions[v as usize]);
            angle(a, b, c)
        };
        let Some(next) = choose(&near, previous, angle) else { break };
        let before = |&v: &u32| Some(predecessors[v as usize]);
        let mut path: Vec<u32> = successors(Some(next), before).take_while(|&v| v != at).collect();
        path.reverse();
        for v in path {
            curve[v as usize] = true;
            let Some(sample) = waiting[v as usize] else { continue };
            if v != next && passed == Passed::Lost {
                // No path leads there any more.
                return order;
            }
            waiting[v as usize] = None;
            reachable = reachable.saturating_sub(1);
            order.push(sample);
        }
        // The previous sample: the last one of those taken in passing.
        previous = order.iter().rev().nth(1).map(|&i| samples[i as usize]);
    }
    order
}

type Near = Vec<(u32, f64)>;

/// Returns the nearest samples that are not yet visited, at most `wanted`, and for each vertex on
/// the way the one before it on a shortest path that avoids the curve.
fn nearest(
    graph: &Graph,
    from: u32,
    waiting: &[Option<u32>],
    curve: &[bool],
    wanted: usize,
) -> (Near, Vec<u32>) {
    let mut best = vec![f64::INFINITY; graph.len()];
    let mut predecessors = vec![from; graph.len()];
    let mut done = vec![false; graph.len()];
    let mut heap = BinaryHeap::from([Reverse((0.0_f64.to_bits(), from))]);
    let mut found = Vec::new();
    while let Some(Reverse((bits, v))) = heap.pop() {
        if std::mem::replace(&mut done[v as usize], true) {
            continue;
        }
        let distance = f64::from_bits(bits);
        if waiting[v as usize].is_some() {
            found.push((v, distance));
            if found.len() == wanted {
                break;
            }
        }
        for (u, length) in graph.neighbours(v) {
            let longer = distance + length;
            if !curve[u as usize] && longer < best[u as usize] {
                best[u as usize] = longer;
                predecessors[u as usize] = v;
                heap.push(Reverse((longer.to_bits(), u)));
            }
        }
    }
    (found, predecessors)
}

fn choose(near: &Near, previous: Option<u32>, angle: impl Fn(u32, u32) -> f64) -> Option<u32> {
    let &(first, _) = near.first()?;
    let Some(previous) = previous else {
        let mut best = (f64::NEG_INFINITY, first);
        for (i, &(a, _)) in near.iter().enumerate() {
            for &(b, _) in &near[i + 1..] {
                if angle(a, b) > best.0 {
                    best = (angle(a, b), a);
                }
            }
        }
        return Some(best.1);
    };
    let value = |&(v, distance): &(u32, f64)| angle(v, previous) / (distance * distance);
    near.iter().rev().max_by(|a, b| value(a).total_cmp(&value(b))).map(|&(v, _)| v)
}

/// Returns the angle at b, in [0, pi].
fn angle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    let [x, y] = [a, c].map(|p| [p[0] - b[0], p[1] - b[1], p[2] - b[2]]);
    let dot: f64 = (0..3).map(|k| x[k] * y[k]).sum();
    let size = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    (dot / (size(x) * size(y))).clamp(-1.0, 1.0).acos()
}
