/// Disjoint sets of the numbers from 0 to `count - 1` (Tarjan 1975), each identified by its lowest
/// number.
pub struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// Creates `count` sets of one number each; `count` is below 2^32.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Returns the lowest number of the set of `i`.
    pub fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            // Halves the path on the way.
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    /// Unites the sets of `i` and `j`.
    pub fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        // The root is the lowest number, so that results do not depend on the order of the calls.
        self.parent[i.max(j) as usize] = i.min(j);
    }
}
