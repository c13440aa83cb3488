/// Disjoint sets of the numbers 0..n (Tarjan 1975), each known by its lowest number.
pub(crate) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// Creates `count` sets of one number each.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Returns the lowest number of the set of i.
    pub fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            // Halves the path on the way.
            let above = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = above;
            i = above;
        }
        i
    }

    /// Joins the sets of i and j.
    pub fn join(&mut self, i: u32, j: u32) {
        let (i, j) = (self.find(i), self.find(j));
        // The root is the lowest number, so that results have an order of their own.
        self.parent[i.max(j) as usize] = i.min(j);
    }
}
