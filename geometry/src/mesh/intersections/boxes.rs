//! A tree of boxes around triangles that may move.

use crate::mesh::vector::{Vector, middle};
use catamaran::base::Par;

/// A box with sides along the axes; empty when `low` is above `high`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub low: Vector,
    pub high: Vector,
}

impl Bounds {
    const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    /// Returns the box around these points.
    pub fn of(points: &[Vector]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, p| bounds.join(&Self { low: *p, high: *p }))
    }

    /// Returns the box around two boxes.
    pub fn join(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: std::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }

    /// Returns whether two boxes meet.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// Number of items in a leaf.
const LEAF: usize = 4;

/// Number of leaves that one thread takes at a time.
const BLOCK: usize = 64;

/// A complete binary tree of the boxes of items, ordered along a space-filling curve. Items are
/// numbered from 0.
pub(crate) struct BoxTree {
    /// The items in the order of the curve.
    order: Vec<u32>,
    /// For each item, its position in `order`.
    places: Vec<u32>,
    boxes: Vec<Bounds>,
    /// Node 1 is the root, 2 i and 2 i + 1 are below i, and leaf l is node `leaves` + l.
    nodes: Vec<Bounds>,
    leaves: usize,
}

impl BoxTree {
    /// Creates a tree of `items` items; items without a box are never found.
    pub fn new(items: usize, bounds: impl Fn(usize) -> Option<Bounds>) -> Self {
        let boxes: Vec<Bounds> = (0..items).map(|i| bounds(i).unwrap_or(Bounds::EMPTY)).collect();
        let all = boxes.iter().fold(Bounds::EMPTY, |all, one| all.join(one));
        let curve = Curve::through([all.low, all.high]);
        let key = |b: &Bounds| curve.place(middle(b.low, b.high));
        let mut keys: Vec<(u64, u32)> = boxes.iter().map(key).zip(0..).collect();
        keys.sort_unstable();
        let order: Vec<u32> = keys.into_iter().map(|(_, item)| item).collect();
        let mut places = vec![0; items];
        order.iter().zip(0..).for_each(|(&item, place)| places[item as usize] = place);
        let leaves = items.div_ceil(LEAF).next_power_of_two();
        let nodes = vec![Bounds::EMPTY; 2 * leaves];
        let mut tree = Self { order, places, boxes, nodes, leaves };
        (0..items.div_ceil(LEAF)).for_each(|leaf| tree.nodes[leaves + leaf] = tree.leaf(leaf));
        (1..leaves).rev().for_each(|node| tree.nodes[node] = tree.inner(node));
        tree
    }

    /// Returns the pairs of items whose boxes meet and for which `wanted` holds, in an order that
    /// does not depend on `par`.
    pub fn pairs(&self, par: Par, wanted: impl Fn(u32, u32) -> bool + Sync) -> Vec<[u32; 2]> {
        let leaves = self.order.len().div_ceil(LEAF);
        let pairs = par.map_blocks(leaves, BLOCK, |range| {
            let mut pairs = Vec::new();
            for leaf in range {
                self.visit_pairs(leaf, |i, j| {
                    if wanted(i, j) {
                        pairs.push([i, j]);
                    }
                });
            }
            pairs
        });
        pairs.concat()
    }

    /// Calls `found` for every two items whose boxes meet, one of which is in this leaf, and the
    /// other in the same or a later leaf.
    fn visit_pairs(&self, leaf: usize, mut found: impl FnMut(u32, u32)) {
        let own = self.items(leaf);
        let meet = |i: u32, j: u32| self.boxes[i as usize].meets(&self.boxes[j as usize]);
        for (at, &i) in own.iter().enumerate() {
            own[..at].iter().filter(|&&j| meet(i, j)).for_each(|&j| found(i, j));
        }
        self.walk(&self.nodes[self.leaves + leaf], leaf + 1, |other| {
            let bounds = &self.nodes[self.leaves + other];
            for &i in own.iter().filter(|&&i| self.boxes[i as usize].meets(bounds)) {
                self.items(other).iter().filter(|&&j| meet(i, j)).for_each(|&j| found(i, j));
            }
        });
    }

    /// Returns the number of items that the tree has room for.
    pub fn len(&self) -> usize {
        self.order.len()
    }

    /// Gives an item another box, or none.
    pub fn update(&mut self, item: u32, bounds: Option<Bounds>) {
        self.boxes[item as usize] = bounds.unwrap_or(Bounds::EMPTY);
        let leaf = self.places[item as usize] as usize / LEAF;
        let mut node = self.leaves + leaf;
        let mut now = self.leaf(leaf);
        while self.nodes[node] != now {
            self.nodes[node] = now;
            node /= 2;
            if node == 0 {
                break;
            }
            now = self.inner(node);
        }
    }

    /// Calls `found` for every item whose box meets `bounds`.
    pub fn visit(&self, bounds: &Bounds, mut found: impl FnMut(u32)) {
        self.walk(bounds, 0, |leaf| {
            let items = self.items(leaf).iter().copied();
            items.filter(|&i| self.boxes[i as usize].meets(bounds)).for_each(&mut found);
        });
    }

    /// Calls `found` for every leaf, from `from` on, whose box meets `bounds`.
    fn walk(&self, bounds: &Bounds, from: usize, mut found: impl FnMut(usize)) {
        // One node waits at each level below the root, and two at the lowest.
        let mut waiting = [0; 66];
        let mut count = 1;
        waiting[0] = 1;
        while count > 0 {
            count -= 1;
            let node: usize = waiting[count];
            // The leaves below a node are those whose numbers start as its own does.
            let height = self.leaves.ilog2() - node.ilog2();
            let ended = (node + 1) << height <= self.leaves + from;
            if ended || !self.nodes[node].meets(bounds) {
                continue;
            }
            if height == 0 {
                found(node - self.leaves);
            } else {
                waiting[count] = 2 * node;
                waiting[count + 1] = 2 * node + 1;
                count += 2;
            }
        }
    }

    fn items(&self, leaf: usize) -> &[u32] {
        let start = (LEAF * leaf).min(self.order.len());
        &self.order[start..(start + LEAF).min(self.order.len())]
    }

    fn leaf(&self, leaf: usize) -> Bounds {
        let boxes = self.items(leaf).iter().map(|&item| &self.boxes[item as usize]);
        boxes.fold(Bounds::EMPTY, |all, one| all.join(one))
    }

    fn inner(&self, node: usize) -> Bounds {
        self.nodes[2 * node].join(&self.nodes[2 * node + 1])
    }
}

/// A curve that fills a box, along which near points are mostly near each other.
pub(crate) struct Curve {
    low: Vector,
    /// Steps along each axis for a unit of length.
    steps: f64,
}

impl Curve {
    /// Creates the curve through the box between two corners, the lower one first.
    pub fn through([low, high]: [Vector; 2]) -> Self {
        let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        Self { low, steps: if longest > 0.0 { f64::from(1 << 20) / longest } else { 0.0 } }
    }

    /// Returns where on the curve a point is.
    pub fn place(&self, p: Vector) -> u64 {
        let [x, y, z] = [0, 1, 2].map(|k| spread((self.steps * (p[k] - self.low[k])) as u64));
        x | y << 1 | z << 2
    }
}

/// Returns the lowest 21 bits, each followed by two zeros (Morton, 1966).
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x1f_0000_0000_ffff),
        (16, 0x1f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use catamaran::base::Rng;

    fn random_box(rng: &mut Rng) -> Bounds {
        let p: Vector = std::array::from_fn(|_| rng.uniform());
        let q: Vector = std::array::from_fn(|k| p[k] + 0.1 * rng.uniform());
        Bounds::of(&[p, q])
    }

    fn found(tree: &BoxTree, bounds: &Bounds) -> Vec<u32> {
        let mut items = Vec::new();
        tree.visit(bounds, |item| items.push(item));
        items.sort_unstable();
        items
    }

    #[test]
    fn boxes_that_meet_are_found_after_moves_too() {
        let mut rng = Rng::new(3);
        for items in [0, 1, 4, 5, 113] {
            let mut boxes: Vec<_> = (0..items).map(|_| Some(random_box(&mut rng))).collect();
            let mut tree = BoxTree::new(items, |i| boxes[i]);
            for round in 0..50 {
                if items > 0 {
                    let item = (rng.uniform() * items as f64) as usize;
                    boxes[item] = if round % 3 == 0 { None } else { Some(random_box(&mut rng)) };
                    tree.update(item as u32, boxes[item]);
                }
                let wanted = random_box(&mut rng);
                let meeting: Vec<u32> = (0..items as u32)
                    .filter(|&i| boxes[i as usize].is_some_and(|b| b.meets(&wanted)))
                    .collect();
                assert_eq!(found(&tree, &wanted), meeting, "{items} items, round {round}");
            }
            let mut pairs = tree.pairs(Par::Threads(3), |_, _| true);
            pairs.iter_mut().for_each(|pair| pair.sort_unstable());
            pairs.sort_unstable();
            let meet =
                |i: usize, j: usize| boxes[i].zip(boxes[j]).is_some_and(|(a, b)| a.meets(&b));
            let all = (0..items).flat_map(|i| (i + 1..items).map(move |j| [i, j]));
            let meeting: Vec<_> =
                all.filter(|&[i, j]| meet(i, j)).map(|p| p.map(|i| i as u32)).collect();
            assert_eq!(pairs, meeting, "{items} items");
        }
    }
}
