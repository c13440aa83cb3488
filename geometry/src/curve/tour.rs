//! Finds a short tour through samples: greedy edges, then 2-opt and Or-opt moves over lists of
//! neighbours, and random kicks.

use super::proximity::Proximity;
use crate::mesh::vector::{dot, norm, sub};
use catamaran::base::{Result, Rng, spend};

/// Number of neighbours of a sample that moves try.
const NEIGHBOURS: usize = 10;
/// Largest number of samples that an Or-opt move takes along.
const SEGMENT: usize = 3;
/// Largest number of kicks (Martin, Otto and Felten 1991) for each node, and the number of nodes
/// that each kick spans.
const KICKS: usize = 200;
const KICKS_A_NODE: usize = 3;
const KICK_SPAN: usize = 30;
/// Weight of the angle at a sample relative to the lengths of its edges.
const BEND: f64 = 0.1;
/// Exponent of lengths: above 1, even spacing costs less than short edges beside long ones.
const POWER: f64 = 1.0;
/// Number of samples up to which all their distances are kept in a table.
const TABLE: usize = 512;
/// Least gain of a move, relative to the length of the tour.
const GAIN: f64 = 1e-12;

/// Operations for the cost of a node of a tour.
const MEASURED: f64 = 30.0;

/// Operations that looking for a move at a node is equal to.
const TRIED: f64 = 5000.0;

/// The costs of tours. Node `count` stands for no sample, at distance 0 from all: a tour through it
/// is an open curve.
pub(super) struct Costs<'a> {
    proximity: &'a Proximity,
    /// The sample of each node.
    members: &'a [u32],
    open: bool,
    /// Lengths of all edges, if there are few.
    table: Option<Vec<f64>>,
}

impl<'a> Costs<'a> {
    /// Collects the costs of tours through these samples.
    pub fn new(proximity: &'a Proximity, members: &'a [u32], open: bool) -> Self {
        let mut costs = Self { proximity, members, open, table: None };
        let all = 0..members.len() as u32;
        if members.len() <= TABLE {
            let row = |i| all.clone().map(move |j| (i, j));
            costs.table =
                Some(all.clone().flat_map(row).map(|(i, j)| costs.length(i, j)).collect());
        }
        costs
    }

    fn nodes(&self) -> usize {
        self.members.len() + usize::from(self.open)
    }

    fn nowhere(&self, i: u32) -> bool {
        i as usize >= self.members.len()
    }

    fn edge(&self, i: u32, j: u32) -> f64 {
        if self.nowhere(i) || self.nowhere(j) {
            return 0.0;
        }
        if let Some(table) = &self.table {
            return table[i as usize * self.members.len() + j as usize];
        }
        self.length(i, j)
    }

    fn length(&self, i: u32, j: u32) -> f64 {
        let [i, j] = [i, j].map(|i| self.members[i as usize]);
        self.proximity.distance(i, j).powf(POWER)
    }

    /// Returns the cost of the turn at j: 0 straight ahead, most for a reversal.
    fn turn(&self, i: u32, j: u32, k: u32) -> f64 {
        if [i, j, k].into_iter().any(|i| self.nowhere(i)) {
            return 0.0;
        }
        let [a, b, c] = [i, j, k].map(|i| self.proximity.position(self.members[i as usize]));
        let (x, y) = (sub(a, b), sub(c, b));
        let lengths = norm(x) * norm(y);
        let cosine = if lengths > 0.0 { (dot(x, y) / lengths).clamp(-1.0, 1.0) } else { 1.0 };
        BEND * (1.0 + cosine) / 2.0 * self.edge(i, j).min(self.edge(j, k))
    }

    fn tour(&self, tour: &[u32]) -> f64 {
        let n = tour.len();
        (0..n)
            .map(|i| {
                let [a, b, c] = [tour[i], tour[(i + 1) % n], tour[(i + 2) % n]];
                self.edge(a, b) + self.turn(a, b, c)
            })
            .sum()
    }

    /// Returns for each node the nodes that moves may bring next to it.
    fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut number = vec![None; self.proximity.len()];
        for (i, &sample) in (0..).zip(self.members) {
            number[sample as usize] = Some(i);
        }
        let near = |&sample: &u32| {
            let all = self.proximity.nearest(sample).iter();
            let mut near: Vec<u32> =
                all.filter_map(|&s| number[s as usize]).take(NEIGHBOURS).collect();
            if self.open {
                near.push(self.members.len() as u32);
            }
            near
        };
        let mut lists: Vec<Vec<u32>> = self.members.iter().map(near).collect();
        if self.open {
            lists.push((0..self.members.len() as u32).collect());
        }
        lists
    }
}

/// Returns a short tour through the members, as samples; an open curve goes from one end to the
/// other.
///
/// # Errors
/// [`Error::Cancelled`](catamaran::Error::Cancelled).
pub(super) fn tour(costs: &Costs<'_>, seed: u64) -> Result<Vec<u32>> {
    let neighbours = costs.neighbours();
    let mut state = Tour::new(costs, &neighbours, greedy(costs, &neighbours));
    let all: Vec<u32> = state.order.clone();
    state.improve(all)?;
    let mut cost = costs.tour(&state.order);
    let mut rng = Rng::new(seed);
    let n = state.order.len();
    // With fewer nodes, moves undo every kick.
    let kicks = if n < 8 { 0 } else { KICKS.min(KICKS_A_NODE * n) };
    for _ in 0..kicks {
        // The tour is copied and measured.
        spend(MEASURED * n as f64)?;
        let before = state.order.clone();
        let ends = state.kick(&mut rng);
        state.improve(ends)?;
        let after = costs.tour(&state.order);
        if after < cost - GAIN * cost {
            cost = after;
        } else {
            state.set(before);
        }
    }
    let mut order = state.order;
    if costs.open {
        let nowhere = order.iter().position(|&i| costs.nowhere(i)).unwrap_or_default();
        order.rotate_left(nowhere);
        order.remove(0);
    }
    Ok(order.into_iter().map(|i| costs.members[i as usize]).collect())
}

/// Returns a tour of short edges first, as long as no sample gets three edges and no cycle closes;
/// then the ends of the pieces are joined, the nearest first.
fn greedy(costs: &Costs<'_>, neighbours: &[Vec<u32>]) -> Vec<u32> {
    let n = costs.nodes() as u32;
    let mut edges: Vec<(f64, u32, u32)> = (0..n)
        .flat_map(|i| neighbours[i as usize].iter().map(move |&j| (costs.edge(i, j), i, j)))
        .filter(|e| !costs.nowhere(e.1) && !costs.nowhere(e.2))
        .collect();
    edges.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    let mut links: Vec<Vec<u32>> = vec![Vec::new(); n as usize];
    let mut sets = catamaran::base::Sets::new(n as usize);
    for (_, i, j) in edges {
        let free = |v: u32| links[v as usize].len() < 2;
        if free(i) && free(j) && sets.find(i) != sets.find(j) {
            sets.join(i, j);
            links[i as usize].push(j);
            links[j as usize].push(i);
        }
    }
    // The pieces are joined one after the other, each entered at the end nearest to the exit of the
    // previous one.
    let mut used = vec![false; n as usize];
    let mut order = Vec::new();
    let mut at = (0..n).find(|&v| links[v as usize].len() < 2);
    while let Some(end) = at {
        let mut v = end;
        loop {
            used[v as usize] = true;
            order.push(v);
            match links[v as usize].iter().find(|&&u| !used[u as usize]) {
                Some(&u) => v = u,
                None => break,
            }
        }
        let last = v;
        at = (0..n)
            .filter(|&v| !used[v as usize] && links[v as usize].len() < 2)
            .min_by(|&x, &y| costs.edge(last, x).total_cmp(&costs.edge(last, y)));
    }
    order
}

struct Tour<'a> {
    costs: &'a Costs<'a>,
    neighbours: &'a [Vec<u32>],
    order: Vec<u32>,
    place: Vec<u32>,
    least_gain: f64,
}

/// The edges that a move removes, and those that it adds.
struct Change<'e> {
    removed: &'e [(u32, u32)],
    added: &'e [(u32, u32)],
}

impl<'a> Tour<'a> {
    fn new(costs: &'a Costs<'a>, neighbours: &'a [Vec<u32>], order: Vec<u32>) -> Self {
        let least_gain = GAIN * costs.tour(&order);
        let mut tour = Self { costs, neighbours, order: Vec::new(), place: Vec::new(), least_gain };
        tour.place = vec![0; order.len()];
        tour.set(order);
        tour
    }

    fn set(&mut self, order: Vec<u32>) {
        for (i, &v) in (0..).zip(&order) {
            self.place[v as usize] = i;
        }
        self.order = order;
    }

    fn len(&self) -> usize {
        self.order.len()
    }

    /// Returns the node `by` positions after v.
    fn after(&self, v: u32, by: usize) -> u32 {
        self.order[(self.place[v as usize] as usize + by) % self.len()]
    }

    fn before(&self, v: u32, by: usize) -> u32 {
        self.after(v, self.len() - by % self.len())
    }

    /// Returns the cost of a change, turns included.
    fn cost(&self, change: &Change<'_>) -> f64 {
        let sum =
            |edges: &[(u32, u32)]| edges.iter().map(|&(i, j)| self.costs.edge(i, j)).sum::<f64>();
        let mut cost = sum(change.added) - sum(change.removed);
        let ends = || change.removed.iter().flat_map(|&(i, j)| [i, j]);
        for (i, v) in ends().enumerate() {
            if ends().take(i).any(|u| u == v) {
                continue;
            }
            let sides = [self.before(v, 1), self.after(v, 1)];
            let mut new = sides.map(Some);
            let other = |&(i, j): &(u32, u32)| (i == v).then_some(j).or((j == v).then_some(i));
            for gone in change.removed.iter().filter_map(other) {
                if let Some(slot) = new.iter_mut().find(|slot| **slot == Some(gone)) {
                    *slot = None;
                }
            }
            for come in change.added.iter().filter_map(other) {
                if let Some(slot) = new.iter_mut().find(|slot| slot.is_none()) {
                    *slot = Some(come);
                }
            }
            if let [Some(a), Some(b)] = new {
                cost += self.costs.turn(a, v, b) - self.costs.turn(sides[0], v, sides[1]);
            }
        }
        cost
    }

    /// Returns whether replacing an edge from v to `old` by one to u can be a gain; a move that
    /// gains has such an edge.
    fn is_near(&self, v: u32, u: u32, old: u32) -> bool {
        self.costs.edge(v, u) < (1.0 + 2.0 * BEND) * self.costs.edge(v, old)
    }

    fn gains(&self, removed: &[(u32, u32)], added: &[(u32, u32)]) -> bool {
        self.cost(&Change { removed, added }) < -self.least_gain
    }

    /// Makes moves at these nodes, and at those that moves touch, until none gains.
    fn improve(&mut self, mut waiting: Vec<u32>) -> Result<()> {
        if self.len() < 5 {
            self.best_of_few();
            return Ok(());
        }
        let mut is_waiting = vec![false; self.len()];
        for &v in &waiting {
            is_waiting[v as usize] = true;
        }
        while let Some(v) = waiting.pop() {
            is_waiting[v as usize] = false;
            spend(TRIED)?;
            while let Some(touched) = self.exchange(v).or_else(|| self.displace(v)) {
                // A move reverses or shifts a part of the tour.
                spend(TRIED + self.len() as f64)?;
                for u in touched {
                    for w in [self.before(u, 1), u, self.after(u, 1)] {
                        if !is_waiting[w as usize] {
                            is_waiting[w as usize] = true;
                            waiting.push(w);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Tries all tours: four nodes have three.
    fn best_of_few(&mut self) {
        if let &[a, b, c, d] = &self.order[..] {
            let tours = [[a, b, c, d], [a, c, b, d], [a, b, d, c]];
            let cost = |tour: &[u32; 4]| self.costs.tour(tour);
            let best = tours.into_iter().min_by(|x, y| cost(x).total_cmp(&cost(y)));
            self.set(best.unwrap_or(tours[0]).to_vec());
        }
    }

    /// Tries 2-opt (Croes 1958): v and one of its neighbours become adjacent, and so do the nodes
    /// after them, or before them.
    fn exchange(&mut self, v: u32) -> Option<Vec<u32>> {
        let neighbours = self.neighbours;
        for &u in &neighbours[v as usize] {
            for ahead in [true, false] {
                let next = |x: u32| if ahead { self.after(x, 1) } else { self.before(x, 1) };
                let (v_next, u_next) = (next(v), next(u));
                if u == v_next || v == u_next || !self.is_near(v, u, v_next) {
                    continue;
                }
                if self.gains(&[(v, v_next), (u, u_next)], &[(v, u), (v_next, u_next)]) {
                    match ahead {
                        true => self.reverse(v_next, u),
                        false => self.reverse(v, u_next),
                    }
                    return Some(vec![v, u, v_next, u_next]);
                }
            }
        }
        None
    }

    /// Reverses the tour from node a to node b.
    fn reverse(&mut self, a: u32, b: u32) {
        let n = self.len();
        let (mut i, mut j) = (self.place[a as usize] as usize, self.place[b as usize] as usize);
        let mut inside = (j + n - i) % n + 1;
        if 2 * inside > n {
            // Reversing the other part gives the same cycle.
            (i, j) = ((j + 1) % n, (i + n - 1) % n);
            inside = n - inside;
        }
        for _ in 0..inside / 2 {
            let (x, y) = (self.order[i], self.order[j]);
            (self.order[i], self.order[j]) = (y, x);
            (self.place[x as usize], self.place[y as usize]) = (j as u32, i as u32);
            (i, j) = ((i + 1) % n, (j + n - 1) % n);
        }
    }

    /// Tries Or-opt (Or 1976): up to three nodes from v on move between a neighbour of v and a node
    /// next to it, in either direction.
    fn displace(&mut self, v: u32) -> Option<Vec<u32>> {
        for count in 1..=SEGMENT.min(self.len() - 3) {
            for ahead in [true, false] {
                // The segment from v to w, and the nodes around it.
                let step = |x: u32, by| if ahead { self.after(x, by) } else { self.before(x, by) };
                let back = |x: u32| if ahead { self.before(x, 1) } else { self.after(x, 1) };
                let w = step(v, count - 1);
                let (out_v, out_w) = (back(v), step(w, 1));
                let neighbours = self.neighbours;
                for &u in &neighbours[v as usize] {
                    let inside = (0..count).any(|i| step(v, i) == u);
                    if inside || !self.is_near(v, u, out_v) {
                        continue;
                    }
                    for beside in [self.after(u, 1), self.before(u, 1)] {
                        if (0..count).any(|i| step(v, i) == beside) {
                            continue;
                        }
                        // v becomes adjacent to u, and w to the node next to u.
                        let removed = [(out_v, v), (w, out_w), (u, beside)];
                        let added = [(out_v, out_w), (v, u), (w, beside)];
                        if self.gains(&removed, &added) {
                            let mut segment: Vec<u32> = (0..count).map(|i| step(v, i)).collect();
                            if self.after(u, 1) != beside {
                                segment.reverse();
                            }
                            let first = if self.after(u, 1) == beside { u } else { beside };
                            self.put_after(first, &segment);
                            return Some(vec![out_v, out_w, v, w, u, beside]);
                        }
                    }
                }
            }
        }
        None
    }

    fn put_after(&mut self, node: u32, segment: &[u32]) {
        let mut order: Vec<u32> = Vec::with_capacity(self.len());
        for &v in &self.order {
            if !segment.contains(&v) {
                order.push(v);
            }
            if v == node {
                order.extend(segment);
            }
        }
        self.set(order);
    }

    /// Exchanges two adjacent short segments (double bridge), and returns the nodes at their ends.
    fn kick(&mut self, rng: &mut Rng) -> Vec<u32> {
        let n = self.len();
        let mut below = |n: usize| (rng.bits() % n as u64) as usize;
        let span = KICK_SPAN.min(n - 1);
        let start = below(n);
        self.order.rotate_left(start);
        let first = 1 + below(span - 2);
        let second = first + 1 + below(span - 1 - first);
        // [0, first] [first + 1, second] [second + 1, span] rest
        let third = second + 1 + below(span - second);
        let third = third.min(n - 1);
        self.order[first..third].rotate_left(second - first);
        let order = std::mem::take(&mut self.order);
        self.set(order);
        [first - 1, first, first + third - second - 1, first + third - second, third - 1, third % n]
            .iter()
            .map(|&i| self.order[i % n])
            .collect()
    }
}
