//! Decides whether samples belong to several curves: whether a tour uses two edges that are far
//! longer than all edges on both sides of them, and each side closes with a short edge.

use super::proximity::Proximity;

/// Least ratio of the edges that join two tours to every edge of the tours.
const GAP: f64 = 2.5;
/// Least number of samples of a curve.
const LEAST: usize = 3;

/// Returns the tours into which a closed tour splits; the tour itself when it does not split.
pub(super) fn split(proximity: &Proximity, tour: Vec<u32>) -> Vec<Vec<u32>> {
    let mut waiting = vec![tour];
    let mut done = Vec::new();
    while let Some(tour) = waiting.pop() {
        match halves(proximity, &tour) {
            Some(halves) => waiting.extend(halves),
            None => done.push(tour),
        }
    }
    done.sort_unstable_by_key(|tour| tour.iter().copied().min());
    done
}

fn halves(proximity: &Proximity, tour: &[u32]) -> Option<[Vec<u32>; 2]> {
    let n = tour.len();
    let length = |i: usize| proximity.distance(tour[i], tour[(i + 1) % n]);
    let lengths: Vec<f64> = (0..n).map(length).collect();
    // Only the two longest edges can be longer than all others.
    let mut by_length: Vec<usize> = (0..n).collect();
    by_length.sort_by(|&i, &j| lengths[j].total_cmp(&lengths[i]));
    let &[first, second, ..] = &by_length[..] else { return None };
    let (i, j) = (first.min(second), first.max(second));
    let inside = tour[i + 1..=j].to_vec();
    let outside: Vec<u32> = tour[j + 1..].iter().chain(&tour[..=i]).copied().collect();
    let halves = [inside, outside];
    let longest = |half: &Vec<u32>| {
        let m = half.len();
        let edges = (0..m).map(|i| proximity.distance(half[i], half[(i + 1) % m]));
        edges.fold(0.0, f64::max)
    };
    let bridges = lengths[first].min(lengths[second]);
    let apart = halves.iter().all(|half| half.len() >= LEAST && GAP * longest(half) < bridges);
    apart.then_some(halves)
}
