//! Rows of a sparse matrix in domains that do not touch, one for each rank.

use sprs::CsMatView;

/// Rows (ascending) of each domain, and those of the interface, which separates the domains.
pub(super) struct Domains {
    pub inner: Vec<Vec<usize>>,
    pub interface: Vec<usize>,
}

/// Share of the rows by which the size of a half may deviate, so that a cut can be narrow.
const SLACK: f64 = 0.05;

impl Domains {
    /// Divides the graph of symmetric matrices (n x n each) into `count` domains of about equally
    /// many rows, by recursive bisection along breadth-first levels (George and Liu 1981, chapters
    /// 4 and 8).
    pub fn new(matrices: &[CsMatView<'_, f64>], count: usize) -> Self {
        let n = matrices.first().map_or(0, |matrix| matrix.rows());
        let mut graph = Graph { matrices, set: vec![0; n], mark: vec![0; n], marks: 0 };
        let mut inner = vec![vec![]; count];
        let mut interface = vec![];
        let mut open = vec![((0..n).collect::<Vec<_>>(), 0..count)];
        while let Some((rows, domains)) = open.pop() {
            if domains.len() <= 1 {
                inner[domains.start] = rows;
                continue;
            }
            let middle = domains.start + domains.len() / 2;
            let share = (middle - domains.start) as f64 / domains.len() as f64;
            let [left, between, right] = graph.halve(&rows, share, domains.start, middle);
            interface.extend(between);
            open.extend([(left, domains.start..middle), (right, middle..domains.end)]);
        }
        inner.iter_mut().for_each(|rows| rows.sort_unstable());
        interface.sort_unstable();
        Self { inner, interface }
    }
}

/// The rows in numbered sets; rows of the interface are in none.
struct Graph<'a> {
    matrices: &'a [CsMatView<'a, f64>],
    set: Vec<usize>,
    /// The last number of `marks` with which a row was visited.
    mark: Vec<usize>,
    marks: usize,
}

const NONE: usize = usize::MAX;

impl Graph<'_> {
    /// Divides a set into two parts that do not touch, the first with about this share of it, and
    /// the rows between them. The parts become the sets `left` and `right`. `left` is the number of
    /// the set.
    fn halve(&mut self, rows: &[usize], share: f64, left: usize, right: usize) -> [Vec<usize>; 3] {
        let (order, levels) = self.levels(rows);
        let exact = share * rows.len() as f64;
        let near = |start: usize| (start as f64 - exact).abs() <= SLACK * rows.len() as f64;
        // The end of a level is followed by another level, or by another component.
        let narrowest = levels.iter().filter(|level| near(level.start)).min_by_key(|l| l.width);
        let cut = narrowest.map_or(exact as usize, |level| level.start);
        let (first, rest) = order.split_at(cut);
        rest.iter().for_each(|&i| self.set[i] = right);
        let touches = |graph: &Self, i: usize| {
            let mut found = false;
            graph.for_neighbours(i, |j| found |= graph.set[j] == left);
            found
        };
        let (between, rest): (Vec<_>, Vec<_>) = rest.iter().partition(|&&i| touches(self, i));
        between.iter().for_each(|&i| self.set[i] = NONE);
        [first.to_vec(), between, rest]
    }

    /// Returns the rows of a set by breadth-first levels, component by component, each from a row
    /// that is far from most others.
    fn levels(&mut self, rows: &[usize]) -> (Vec<usize>, Vec<Level>) {
        let (mut order, mut levels) = (Vec::with_capacity(rows.len()), vec![]);
        self.marks += 1;
        let done = self.marks;
        for &row in rows {
            if self.mark[row] >= done {
                continue;
            }
            let mut start = row;
            for _ in 0..2 {
                self.marks += 1;
                start = *self.search(start).0.last().expect("the start itself");
            }
            self.marks += 1;
            let (component, starts) = self.search(start);
            let ends = starts.iter().skip(1).copied().chain([component.len()]);
            levels.extend(starts.iter().zip(ends).enumerate().map(|(l, (&start, end))| Level {
                start: order.len() + start,
                width: if l == 0 { 0 } else { end - start },
            }));
            order.extend(component);
        }
        (order, levels)
    }

    /// Returns the component of a row within its set, by levels, and their starts. Marks its rows.
    fn search(&mut self, start: usize) -> (Vec<usize>, Vec<usize>) {
        let (set, marks) = (self.set[start], self.marks);
        let (mut order, mut starts) = (vec![start], vec![]);
        self.mark[start] = marks;
        let mut first = 0;
        while first < order.len() {
            starts.push(first);
            let end = order.len();
            for at in first..end {
                let mut next = vec![];
                self.for_neighbours(order[at], |j| {
                    if self.set[j] == set && self.mark[j] != marks {
                        next.push(j);
                    }
                });
                for j in next {
                    if self.mark[j] != marks {
                        self.mark[j] = marks;
                        order.push(j);
                    }
                }
            }
            first = end;
        }
        (order, starts)
    }

    fn for_neighbours(&self, i: usize, mut found: impl FnMut(usize)) {
        for matrix in self.matrices {
            let row = matrix.outer_view(i).expect("as many rows in each matrix");
            row.indices().iter().for_each(|&j| found(j));
        }
    }
}

/// A breadth-first level in an order of rows.
struct Level {
    /// Its first row.
    start: usize,
    /// Rows of it that touch earlier ones: none of the first level of a component, else all.
    width: usize,
}

#[cfg(test)]
mod tests {
    use sprs::{CsMat, TriMat};

    use super::*;

    /// Returns a grid of a x b nodes, each joined to its neighbours in rows, columns and one
    /// diagonal.
    fn grid(a: usize, b: usize) -> CsMat<f64> {
        let mut entries = TriMat::new((a * b, a * b));
        for i in 0..a * b {
            for j in 0..a * b {
                let step = [i / b, i % b, j / b, j % b].map(|x| x as isize);
                let step = (step[2] - step[0], step[3] - step[1]);
                if [(0, 0), (0, 1), (1, 0), (1, 1), (0, -1), (-1, 0), (-1, -1)].contains(&step) {
                    entries.add_triplet(i, j, 1.0);
                }
            }
        }
        entries.to_csr()
    }

    #[test]
    fn domains_do_not_touch_are_of_about_equal_size_and_the_interface_is_small() {
        let mut apart = TriMat::new((50, 50));
        (0..50).for_each(|i| apart.add_triplet(i, i, 1.0));
        let mut full = TriMat::new((9, 9));
        (0..81).for_each(|i| full.add_triplet(i / 9, i % 9, 1.0));
        // Each with the largest allowed interface and the largest allowed domain.
        for (matrix, count, interface, largest) in [
            (grid(0, 0), 3, 0, 0),
            (grid(1, 1), 2, 1, 1),
            (grid(24, 40), 1, 0, 960),
            (grid(24, 40), 2, 26, 520),
            (grid(24, 40), 7, 150, 180),
            (grid(24, 40), 8, 170, 150),
            (apart.to_csr(), 8, 0, 7),
            (full.to_csr(), 4, 9, 9),
        ] {
            let n: usize = matrix.rows();
            let domains = Domains::new(&[matrix.view()], count);
            assert_eq!(domains.inner.len(), count);
            let mut domain = vec![NONE; n];
            for (d, rows) in domains.inner.iter().enumerate() {
                assert!(rows.is_sorted() && rows.len() <= largest, "{} of {n}", rows.len());
                rows.iter().for_each(|&i| domain[i] = d);
            }
            let len = domains.interface.len();
            assert!(len <= interface, "{len} of {n} in the interface of {count}");
            assert_eq!(domain.iter().filter(|&&d| d == NONE).count(), len);
            for (i, row) in matrix.outer_iterator().enumerate() {
                for &j in row.indices().iter().filter(|&&j| domain[i] != NONE && domain[j] != NONE)
                {
                    assert_eq!(domain[i], domain[j], "rows {i} and {j}");
                }
            }
        }
    }
}
