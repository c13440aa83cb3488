/// Nodes of a forest in subtrees that do not need each other, of about equal work, and the nodes
/// above all of them. Children come before their parents, and a subtree's nodes one after the other.
pub(super) fn split(
    parents: &[Option<usize>],
    work: impl Fn(usize) -> usize,
) -> (Vec<Vec<usize>>, Vec<usize>) {
    /// A subtree has at most one in so many parts of all work.
    const LARGEST: usize = 16;
    /// Small ones that follow each other are put together until they have one in so many.
    const TOGETHER: usize = 64;
    let mut below: Vec<usize> = (0..parents.len()).map(&work).collect();
    let total = below.iter().sum::<usize>();
    for (s, parent) in parents.iter().enumerate() {
        if let Some(parent) = *parent {
            below[parent] += below[s];
        }
    }
    let is_above = |s: usize| below[s] * LARGEST > total;
    let (mut subtrees, mut above) = (vec![], vec![]);
    let (mut current, mut current_work) = (vec![], 0);
    for (s, parent) in parents.iter().enumerate() {
        if is_above(s) {
            above.push(s);
            continue;
        }
        current.push(s);
        current_work += work(s);
        let ends = parent.is_none_or(is_above);
        if ends && current_work * TOGETHER >= total {
            subtrees.push(std::mem::take(&mut current));
            current_work = 0;
        }
    }
    subtrees.extend((!current.is_empty()).then_some(current));
    (subtrees, above)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The complete binary tree of this many nodes, children before parents.
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

    #[test]
    fn subtrees_are_whole_and_of_about_equal_work() {
        for parents in [vec![], vec![None], vec![None; 1000], binary(11)] {
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
