use catamaran::base::{Error, Result};
use catamaran_geometry::mesh::Adjacency;
use catamaran_geometry::mesh::vector::distance;

/// Marks the root, which has no parent.
pub(crate) const NONE: u32 = u32::MAX;

/// A plant that spans more, in metres, is not in metres: the tallest tree has 116.
const TALLEST: f64 = 120.0;

/// A plant that spans less, in metres, is not in metres, but for a few duckweeds.
const SMALLEST: f64 = 1e-3;

/// A straight segment of stem, branch or vein. It is identified by the node of the plant at its
/// end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The end of the segment, in metres; it begins at the end of its parent.
    pub tail: [f64; 3],
    /// Its radius, in metres, above 0.
    pub radius: f64,
    /// Whether it is a vein of a leaf, which loses water.
    pub leaf: bool,
    /// Whether it is labelled as the stalk of a leaf; the label is ignored for a vein. See
    /// [`Plant::parts`].
    pub petiole: bool,
    /// The area of leaf that the segment supplies, in square metres; by default (`None`) radius
    /// times length (thesis, section 4.3.2).
    pub leaf_area: Option<f64>,
    /// Whether the segment is fixed in space.
    pub pinned: bool,
}

impl Segment {
    /// Creates a segment of stem: no leaf, not pinned. `tail` and `radius` are in metres.
    pub fn stem(tail: [f64; 3], radius: f64) -> Self {
        Self { tail, radius, leaf: false, petiole: false, leaf_area: None, pinned: false }
    }

    /// Creates a vein of a leaf. `tail` and `radius` are in metres.
    pub fn vein(tail: [f64; 3], radius: f64) -> Self {
        Self { leaf: true, ..Self::stem(tail, radius) }
    }
}

/// A plant: segments that are connected as a tree.
///
/// ```
/// use catamaran_simulation::plant::{Plant, Segment};
///
/// // A stem and two leaves.
/// let segments = vec![
///     Segment::stem([0.0, 0.0, 0.1], 2e-3),
///     Segment::vein([0.1, 0.0, 0.1], 1e-3),
///     Segment::vein([-0.1, 0.0, 0.1], 1e-3),
/// ];
/// let plant = Plant::new(segments, &[None, Some(0), Some(0)], Some([0.0; 3]))?;
/// assert_eq!((plant.root(), plant.parent(2)), (0, Some(0)));
/// assert_eq!(plant.lengths(), [0.1; 3]);
/// # Ok::<(), catamaran::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    segments: Vec<Segment>,
    parents: Vec<u32>,
    /// The length of each segment, in metres.
    lengths: Vec<f64>,
    root: u32,
    base: [f64; 3],
    notes: Vec<String>,
}

fn refused<T>(element: String, what: impl Into<String>) -> Result<T> {
    Err(Error::Mesh { what: what.into(), element })
}

impl Plant {
    /// Creates a plant of n >= 1 segments from the parent of each, `None` for the root. The root
    /// segment begins at `base`. Without `base`, or if the segment ends there, it is as long as its
    /// first child and collinear with it; the only segment of a plant is then upright and 1 cm
    /// long.
    ///
    /// # Errors
    /// [`Error::Mesh`] names a node whose position is not finite, whose radius or length is not
    /// positive, whose leaf area is negative, or whose parent does not exist; a second root; an
    /// isolated node; a node on a cycle. [`Error::Argument`] for no nodes, or for 2^32 - 1 or more;
    /// [`Error::Shape`] when the numbers of parents and segments differ.
    pub fn new(
        segments: Vec<Segment>,
        parents: &[Option<u32>],
        base: Option<[f64; 3]>,
    ) -> Result<Self> {
        let n = segments.len();
        check_segments(&segments)?;
        Error::check_shape("parents", (n, 1), (parents.len(), 1))?;
        let mut has_child = vec![false; n];
        for (v, parent) in parents.iter().enumerate() {
            match *parent {
                Some(p) if p as usize >= n => {
                    return refused(format!("node {v}"), format!("its parent {p} does not exist"));
                }
                Some(p) if p as usize == v => {
                    return refused(format!("node {v}"), "is on a cycle: it is its own parent");
                }
                Some(p) => has_child[p as usize] = true,
                None => {}
            }
        }
        let Some(root) = parents.iter().position(Option::is_none) else {
            return refused(
                "node 0".into(),
                "has no root: every node has a parent, so there is a cycle",
            );
        };
        if let Some(v) = (root + 1..n).find(|&v| parents[v].is_none()) {
            let what = match has_child[v] {
                true => format!("is a second root besides node {root}"),
                false => "is isolated: it has neither a parent nor a child".into(),
            };
            return refused(format!("node {v}"), what);
        }
        let parents: Vec<u32> = parents.iter().map(|p| p.unwrap_or(NONE)).collect();
        check_cycles(&parents, root)?;
        Self::measured(segments, parents, root as u32, base)
    }

    /// Creates a plant of n >= 1 segments from edges between them (node numbers from 0, in either
    /// direction). The root is the node whose tail is nearest to `base` (default: the origin),
    /// where the root segment begins, as in [`Plant::new`].
    ///
    /// ```
    /// use catamaran_simulation::plant::{Plant, Segment};
    ///
    /// let tails = [[0.0, 0.0, 0.2], [0.0, 0.0, 0.1]];
    /// let segments = tails.map(|tail| Segment::stem(tail, 1e-3)).to_vec();
    /// let plant = Plant::from_edges(segments, &[[0, 1]], None)?;
    /// assert_eq!((plant.root(), plant.parent(0)), (1, Some(1)));
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Plant::new`]; [`Error::Mesh`] also names an edge that closes a cycle, and a node that
    /// is not connected to the root.
    pub fn from_edges(
        segments: Vec<Segment>,
        edges: &[[u32; 2]],
        base: Option<[f64; 3]>,
    ) -> Result<Self> {
        let n = segments.len();
        check_segments(&segments)?;
        let mut sets: Vec<u32> = (0..n as u32).collect();
        let mut degrees = vec![0_u32; n];
        for (e, &[a, b]) in edges.iter().enumerate() {
            let name = || format!("edge {e} ({a}, {b})");
            if let Some(v) = [a, b].into_iter().find(|&v| v as usize >= n) {
                return refused(
                    name(),
                    format!("node {v} is out of range: {n} nodes, numbered from 0"),
                );
            }
            let [x, y] = [a, b].map(|v| find(&mut sets, v));
            if x == y {
                return refused(name(), "closes a cycle");
            }
            sets[x as usize] = y;
            degrees[a as usize] += 1;
            degrees[b as usize] += 1;
        }
        if let Some(v) = (0..n).find(|&v| n > 1 && degrees[v] == 0) {
            return refused(format!("node {v}"), "is isolated: it has no edge");
        }
        let origin = base.unwrap_or_default();
        let away = |v: &usize| distance(segments[*v].tail, origin);
        let root = (0..n).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or_default();
        let set = find(&mut sets, root as u32);
        if let Some(v) = (0..n).find(|&v| find(&mut sets, v as u32) != set) {
            let what = format!("is not connected to the root, node {root}");
            return refused(format!("node {v}"), what);
        }
        let parents = away_from(root as u32, n, edges);
        Self::measured(segments, parents, root as u32, Some(origin))
    }

    fn measured(
        segments: Vec<Segment>,
        parents: Vec<u32>,
        root: u32,
        base: Option<[f64; 3]>,
    ) -> Result<Self> {
        let tail = segments[root as usize].tail;
        if let Some(base) = base
            && base.iter().any(|x| !x.is_finite())
        {
            return refused("base".into(), format!("position {base:?} is not finite"));
        }
        let given = base.filter(|&b| distance(b, tail) > 0.0);
        let base = given.unwrap_or_else(|| {
            let child = parents.iter().position(|&p| p == root);
            match child.map(|c| segments[c].tail) {
                Some(next) => [0, 1, 2].map(|i| 2.0 * tail[i] - next[i]),
                None => [tail[0], tail[1], tail[2] - 0.01],
            }
        });
        let (lengths, notes) = (vec![], vec![]);
        let mut plant = Self { segments, parents, lengths, root, base, notes };
        plant.lengths =
            (0..plant.len()).map(|v| distance(plant.head(v), plant.segments[v].tail)).collect();
        let wrong = |&h: &f64| h.is_nan() || h <= 0.0 || h.is_infinite();
        if let Some(v) = plant.lengths.iter().position(wrong) {
            let what =
                format!("the length of its segment must be positive, is {}", plant.lengths[v]);
            return refused(format!("node {v}"), what);
        }
        if given.is_none() {
            let length = metres(plant.lengths[root as usize]);
            plant.notes.push(format!(
                "no segment leads to the root, node {root}: one of {length} m is added below it"
            ));
        }
        Ok(plant)
    }

    /// Returns the number of segments, at least 1.
    #[allow(clippy::len_without_is_empty)] // there is no empty plant
    pub fn len(&self) -> usize {
        self.segments.len()
    }

    /// Returns the segments.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns the parent of node `v`; `None` for the root.
    pub fn parent(&self, v: usize) -> Option<usize> {
        self.parents.get(v).filter(|&&p| p != NONE).map(|&p| p as usize)
    }

    /// Returns the parents in their stored form.
    pub(crate) fn parents(&self) -> &[u32] {
        &self.parents
    }

    /// Returns the node without a parent.
    pub fn root(&self) -> usize {
        self.root as usize
    }

    /// Returns the point where the root segment begins, in metres.
    pub fn base(&self) -> [f64; 3] {
        self.base
    }

    /// Returns the point where segment `v` begins, in metres.
    pub fn head(&self, v: usize) -> [f64; 3] {
        self.parent(v).map_or(self.base, |p| self.segments[p].tail)
    }

    /// Returns the lengths of the segments, in metres.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Returns the volume of segment `v`, a cylinder, in cubic metres.
    pub fn volume(&self, v: usize) -> f64 {
        std::f64::consts::PI * self.segments[v].radius.powi(2) * self.lengths[v]
    }

    /// Returns the area of leaf that node `v` supplies, in square metres; 0 for a node that is not
    /// on a leaf.
    pub fn leaf_area(&self, v: usize) -> f64 {
        let segment = &self.segments[v];
        match segment.leaf {
            true => segment.leaf_area.unwrap_or(segment.radius * self.lengths[v]),
            false => 0.0,
        }
    }

    /// Returns what the reader of the file had to assume, such as radii that the file does not
    /// have, or the segment of the root; one sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    pub(crate) fn noting(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// Notes the extent of the plant, base included, and its largest radius if they are those of no
    /// plant in metres.
    pub(crate) fn noting_span(mut self) -> Self {
        let span = |i: usize| {
            let tails = self.segments.iter().map(|s| s.tail[i]);
            let [low, high] = tails.fold([self.base[i]; 2], |[a, b], x| [a.min(x), b.max(x)]);
            high - low
        };
        let span = (0..3).map(span).fold(0.0, f64::max);
        if span > TALLEST {
            self.notes.push(format!(
                "the plant spans {span:.0} metres, more than any tree: files do not state their \
                 units"
            ));
        }
        if span < SMALLEST {
            self.notes.push(format!(
                "the plant spans {} metres, less than any stem: files do not state their units",
                metres(span)
            ));
        }
        let radius = |v: &usize| self.segments[*v].radius;
        let thickest = (0..self.len()).max_by(|a, b| radius(a).total_cmp(&radius(b)));
        if let Some(v) = thickest.filter(|v| radius(v) > span) {
            self.notes.push(format!(
                "node {v} has a radius of {} metres, but the plant spans {}: files do not state \
                 their units",
                metres(radius(&v)),
                metres(span)
            ));
        }
        self
    }

    /// Returns the nodes in depth-first order: every parent before its children, children in
    /// ascending order, each followed by its subtree.
    pub(crate) fn preorder(&self) -> Vec<u32> {
        let n = self.len();
        // Children are linked lists, so that a node with thousands of them costs no more than
        // others.
        let (mut first, mut next) = (vec![NONE; n], vec![NONE; n]);
        for v in (0..n).rev() {
            if let Some(p) = self.parent(v) {
                next[v] = first[p];
                first[p] = v as u32;
            }
        }
        let mut order = Vec::with_capacity(n);
        let mut waiting = vec![self.root];
        while let Some(v) = waiting.pop() {
            order.push(v);
            let before = waiting.len();
            let mut child = first[v as usize];
            while child != NONE {
                waiting.push(child);
                child = next[child as usize];
            }
            waiting[before..].reverse();
        }
        order
    }
}

/// Formats a length in metres, with three digits or more.
fn metres(length: f64) -> String {
    const SHORT: f64 = 0.1;
    if length < SHORT { format!("{length:.2e}") } else { format!("{length:.3}") }
}

fn check_segments(segments: &[Segment]) -> Result<()> {
    if segments.is_empty() || segments.len() >= NONE as usize {
        let why = format!("must have 1 to 2^32 - 2 nodes, has {}", segments.len());
        return Err(Error::Argument { what: "plant", why });
    }
    for (v, segment) in segments.iter().enumerate() {
        let name = || format!("node {v}");
        if segment.tail.iter().any(|x| !x.is_finite()) {
            return refused(name(), format!("position {:?} is not finite", segment.tail));
        }
        if !(segment.radius > 0.0 && segment.radius.is_finite()) {
            let r = segment.radius;
            return refused(name(), format!("radius must be positive and finite, is {r}"));
        }
        if let Some(area) = segment.leaf_area
            && !(area >= 0.0 && area.is_finite())
        {
            return refused(name(), format!("leaf area must be at least 0, is {area}"));
        }
    }
    Ok(())
}

/// Returns an error unless every node leads to the root.
fn check_cycles(parents: &[u32], root: usize) -> Result<()> {
    // 0: unknown, 1: on the current path, 2: leads to the root.
    let mut states = vec![0_u8; parents.len()];
    states[root] = 2;
    for start in 0..parents.len() {
        let mut v = start;
        while states[v] == 0 {
            states[v] = 1;
            v = parents[v] as usize;
        }
        if states[v] == 1 {
            return refused(format!("node {v}"), "is on a cycle: its ancestors lead back to it");
        }
        let mut v = start;
        while states[v] == 1 {
            states[v] = 2;
            v = parents[v] as usize;
        }
    }
    Ok(())
}

/// Returns the parent of each node in the tree of these edges, rooted at `root`.
fn away_from(root: u32, n: usize, edges: &[[u32; 2]]) -> Vec<u32> {
    let both = || edges.iter().flat_map(|&[a, b]| [(a, b), (b, a)]);
    let neighbours = Adjacency::from_pairs(n, both);
    let mut parents = vec![NONE; n];
    let mut waiting = vec![root];
    while let Some(v) = waiting.pop() {
        for &u in neighbours.row(v as usize) {
            if u != parents[v as usize] {
                parents[u as usize] = v;
                waiting.push(u);
            }
        }
    }
    parents
}

fn find(sets: &mut [u32], mut v: u32) -> u32 {
    while sets[v as usize] != v {
        sets[v as usize] = sets[sets[v as usize] as usize];
        v = sets[v as usize];
    }
    v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(n: usize) -> Vec<Segment> {
        (0..n).map(|v| Segment::stem([0.0, 0.0, 0.1 * (v + 1) as f64], 1e-3)).collect()
    }

    fn named(result: Result<Plant>, element: &str, what: &str) {
        match result.unwrap_err() {
            Error::Mesh { what: w, element: e } => {
                assert!(e == element && w.contains(what), "{e}: {w}");
            }
            other => panic!("{other}"),
        }
    }

    #[test]
    fn edges_and_parents_make_the_same_plant() {
        for n in [1, 2, 3, 7, 31] {
            let edges: Vec<_> = (1..n as u32).rev().map(|v| [v, v - 1]).collect();
            let parents: Vec<_> = (0..n as u32).map(|v| v.checked_sub(1)).collect();
            let a = Plant::from_edges(line(n), &edges, None).unwrap();
            let b = Plant::new(line(n), &parents, Some([0.0; 3])).unwrap();
            assert_eq!(a, b);
            assert_eq!(a.preorder(), (0..n as u32).collect::<Vec<_>>());
            assert!(a.lengths().iter().all(|h| (h - 0.1).abs() < 1e-12));
        }
    }

    #[test]
    fn a_root_at_the_base_goes_on_into_its_child() {
        let mut segments = line(3);
        segments[0].tail = [0.0; 3];
        let plant = Plant::from_edges(segments, &[[0, 1], [1, 2]], None).unwrap();
        assert_eq!(plant.base(), [0.0, 0.0, -0.2]);
        let note = "no segment leads to the root, node 0: one of 0.200 m is added below it";
        assert_eq!(plant.notes(), [note]);
        let given = Plant::from_edges(line(2), &[[0, 1]], None).unwrap();
        assert!(given.notes().is_empty(), "{:?}", given.notes());
    }

    #[test]
    fn what_is_no_plant_is_named() {
        let edges = |edges: &[[u32; 2]], n| Plant::from_edges(line(n), edges, None);
        named(edges(&[[0, 1], [1, 2], [2, 0]], 3), "edge 2 (2, 0)", "closes a cycle");
        named(edges(&[[0, 1], [1, 1]], 3), "edge 1 (1, 1)", "closes a cycle");
        named(edges(&[[0, 1], [1, 5]], 3), "edge 1 (1, 5)", "node 5 is out of");
        named(edges(&[[0, 1]], 3), "node 2", "isolated");
        named(edges(&[[0, 1], [2, 3]], 4), "node 2", "not connected to the root");
        let parents = |parents: &[Option<u32>]| Plant::new(line(parents.len()), parents, None);
        named(parents(&[None, None, Some(1)]), "node 1", "a second root");
        named(parents(&[None, Some(0), None]), "node 2", "isolated");
        named(parents(&[None, Some(2), Some(1)]), "node 1", "cycle");
        named(parents(&[Some(1), Some(0)]), "node 0", "no root");
        named(parents(&[None, Some(7)]), "node 1", "parent 7");
        let mut thin = line(3);
        thin[1].radius = 0.0;
        named(
            Plant::from_edges(thin, &[[0, 1], [1, 2]], None),
            "node 1",
            "radius must be positive and finite, is ",
        );
        let mut short = line(3);
        short[2].tail = short[1].tail;
        named(Plant::from_edges(short, &[[0, 1], [1, 2]], None), "node 2", "positive, is 0");
        assert!(matches!(Plant::new(vec![], &[], None), Err(Error::Argument { .. })));
    }
}
