/// Splits the nodes of a forest into independent subtrees of about equal work, and the nodes above
/// all of them, each in ascending order. Children come before their parents; nodes of other
/// subtrees may be between them.
pub(super) fn split(
    parents: &[Option<usize>],
    work: impl Fn(usize) -> usize,
) -> (Vec<Vec<usize>>, Vec<usize>) {
    /// A subtree has at most one in so many parts of the whole work.
    const LARGEST: usize = 16;
    /// Small subtrees that follow each other are joined until they have one in so many parts.
    const TOGETHER: usize = 64;
    let mut below: Vec<usize> = (0..parents.len()).map(&work).collect();
    let total = below.iter().sum::<usize>();
    for (s, parent) in parents.iter().enumerate() {
        if let Some(parent) = *parent {
            below[parent] += below[s];
        }
    }
    let is_above = |s: usize| below[s] * LARGEST > total;
    let mut above = vec![];
    // For each other node the root of its subtree, and the nodes of each root.
    let mut root: Vec<usize> = (0..parents.len()).collect();
    for (s, parent) in parents.iter().enumerate().rev() {
        if let Some(parent) = parent.filter(|&parent| !is_above(parent)) {
            root[s] = root[parent];
        }
    }
    let mut nodes = vec![vec![]; parents.len()];
    for (s, &root) in root.iter().enumerate() {
        if is_above(s) { above.push(s) } else { nodes[root].push(s) }
    }
    let (mut subtrees, mut current, mut current_work) = (vec![], vec![], 0);
    for nodes in nodes {
        current_work += nodes.iter().map(|&s| work(s)).sum::<usize>();
        current.extend(nodes);
        if !current.is_empty() && current_work * TOGETHER >= total {
            subtrees.push(std::mem::take(&mut current));
            current_work = 0;
        }
    }
    subtrees.extend((!current.is_empty()).then_some(current));
    for nodes in &mut subtrees {
        nodes.sort_unstable();
    }
    (subtrees, above)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the complete binary tree of this many levels, children before parents.
    fn binary(levels: u32) -> Vec<Option<usize>> {
        let n = (1 << levels) - 1;
        let mut parents = vec![None; n];
        // The subtree of `size` nodes that ends at `root`.
        let mut open = vec![(n - 1, n)];
        while let Some((root, size)) = open.pop() {
            let half = size / 2;
            let children = (half > 0).then(|| [root - 1, root - 1 - half]);
            for child in children.into_iter().flatten() {
                parents[child] = Some(root);
                open.push((child, half));
            }
        }
        parents
    }

    /// Returns a random tree, in which the nodes of other subtrees are between those of each.
    fn mixed(n: usize) -> Vec<Option<usize>> {
        let mut rng = crate::base::Rng::new(9);
        let parent = |i: usize| Some(i + 1 + rng.bits() as usize % (n - 1 - i).max(1));
        let mut parents: Vec<_> = (0..n).map(parent).collect();
        parents[n - 1] = None;
        parents
    }

    #[test]
    fn subtrees_are_whole_and_of_about_equal_work() {
        for parents in [vec![], vec![None], vec![None; 1000], binary(11), mixed(700)] {
            let (subtrees, above) = split(&parents, |_| 1);
            let n = parents.len();
            let mut part = vec![usize::MAX; n];
            for (p, nodes) in subtrees.iter().enumerate() {
                assert!(nodes.len() * 8 <= n.max(16), "{} of {n}", nodes.len());
                nodes.iter().for_each(|&s| part[s] = p);
            }
            let mut all: Vec<usize> = subtrees.into_iter().flatten().chain(above.clone()).collect();
            all.sort_unstable();
            assert_eq!(all, (0..n).collect::<Vec<_>>());
            for (s, parent) in parents.iter().enumerate() {
                if let Some(parent) = *parent {
                    assert!(part[s] == part[parent] || above.contains(&parent));
                }
            }
        }
    }
}
