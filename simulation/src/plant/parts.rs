use super::Plant;

/// The part of a plant to which a segment belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    /// A vein of a leaf ([`Segment::leaf`](super::Segment::leaf)).
    Leaf,
    /// The stalk of a leaf.
    Petiole,
    /// Everything else: stem and branches.
    Stem,
}

impl Plant {
    /// Returns the part to which each segment belongs. Leaves are the segments that the plant marks
    /// as such. Petioles are the segments that the plant labels
    /// ([`Segment::petiole`](super::Segment::petiole), class `P...` of MTG files); in a plant
    /// without such labels they are the unbranched sequences of segments that end where only veins
    /// of leaves continue, and that do not reach the root.
    ///
    /// ```
    /// use catamaran_simulation::plant::{Part, Plant, Segment};
    ///
    /// // A stem, a side branch of one segment, and a leaf at its end.
    /// let segments = vec![
    ///     Segment::stem([0.0, 0.0, 0.1], 2e-3),
    ///     Segment::stem([0.0, 0.0, 0.2], 2e-3),
    ///     Segment::stem([0.1, 0.0, 0.1], 1e-3),
    ///     Segment::vein([0.2, 0.0, 0.1], 1e-3),
    /// ];
    /// let plant = Plant::new(segments, &[None, Some(0), Some(0), Some(2)], Some([0.0; 3]))?;
    /// assert_eq!(plant.parts(), [Part::Stem, Part::Stem, Part::Petiole, Part::Leaf]);
    /// # Ok::<(), catamaran::Error>(())
    /// ```
    pub fn parts(&self) -> Vec<Part> {
        let segments = self.segments();
        let is_labelled = segments.iter().any(|s| s.petiole && !s.leaf);
        let mut parts: Vec<Part> = segments
            .iter()
            .map(|s| match (s.leaf, s.petiole) {
                (true, _) => Part::Leaf,
                (false, true) => Part::Petiole,
                (false, false) => Part::Stem,
            })
            .collect();
        if !is_labelled {
            self.find_stalks(&mut parts);
        }
        parts
    }

    fn find_stalks(&self, parts: &mut [Part]) {
        let mut children = vec![0_u32; self.len()];
        let mut veins = vec![0_u32; self.len()];
        for v in 0..self.len() {
            if let Some(p) = self.parent(v) {
                children[p] += 1;
                veins[p] += u32::from(self.segments()[v].leaf);
            }
        }
        for end in 0..self.len() {
            let bears_leaves = children[end] > 0 && veins[end] == children[end];
            if self.segments()[end].leaf || !bears_leaves {
                continue;
            }
            let mut stalk = vec![end];
            let mut above = self.parent(end);
            while let Some(p) = above.filter(|&p| children[p] == 1) {
                stalk.push(p);
                above = self.parent(p);
            }
            if above.is_some() {
                stalk.into_iter().for_each(|v| parts[v] = Part::Petiole);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Segment;
    use crate::plant::families::chain;

    #[test]
    fn labels_of_petioles_stand_before_stalks() {
        let at = |x: f64, z: f64| Segment::stem([x, 0.0, z], 1e-3);
        let vein = |x: f64, z: f64| Segment::vein([x, 0.0, z], 1e-3);
        let segments = vec![at(0.0, 0.1), at(0.0, 0.2), at(0.1, 0.1), at(0.2, 0.1), vein(0.3, 0.1)];
        let parents = [None, Some(0), Some(0), Some(2), Some(3)];
        let plant = Plant::new(segments.clone(), &parents, Some([0.0; 3])).unwrap();
        use Part::{Leaf, Petiole, Stem};
        assert_eq!(plant.parts(), [Stem, Stem, Petiole, Petiole, Leaf]);
        let mut labelled = segments;
        labelled[3].petiole = true;
        let plant = Plant::new(labelled, &parents, Some([0.0; 3])).unwrap();
        assert_eq!(plant.parts(), [Stem, Stem, Stem, Petiole, Leaf]);
    }

    #[test]
    fn a_stem_that_ends_in_a_leaf_is_no_stalk() {
        let parts = chain(5, 0.1, 1e-3).unwrap().parts();
        assert_eq!(parts[..4], [Part::Stem; 4]);
        assert_eq!(parts[4], Part::Leaf);
    }
}
