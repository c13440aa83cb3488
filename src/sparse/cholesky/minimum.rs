//! Orders of elimination by approximate minimum degree (Amestoy, Davis and Duff, An approximate
//! minimum degree ordering algorithm, 1996).
//!
//! The graph of what is left to eliminate is kept as a quotient graph: an eliminated vertex becomes
//! an element, whose members are the neighbours of each other. A vertex has a list of elements,
//! followed by neighbours that no element joins it with.

use std::ops::Range;

use super::graph::{Graph, Lists, Looks, NONE};
use crate::base::{Result, repeated, reserved, room};

/// Marks vertices that are not in a list of their degree.
const ABSENT: u32 = u32::MAX - 1;

/// Marks the first place of a list that is moved. Vertices are smaller.
const MOVED: u32 = 1 << 31;

/// Places of the table that finds vertices with equal lists; it stays in the first cache.
const TABLE: usize = 1 << 12;

/// Returns the vertices in groups, in the order of elimination: those of a group have the same
/// later neighbours, and each other as neighbours, except in the last group, of vertices of very
/// high degree.
///
/// Vertices of stage 0 are eliminated before those of stage 1, and so on; without stages, all are
/// in one.
pub(super) fn minimum_degree(graph: &Graph, stages: Option<&Lists>) -> Result<Lists> {
    let mut quotient = Quotient::new(graph, stages)?;
    match stages {
        None => {
            (0..graph.n()).for_each(|v| quotient.enter(v));
            quotient.eliminate_all()?;
        }
        Some(stages) => {
            for k in 0..stages.len() {
                quotient.least = 0;
                for &v in stages.of(k) {
                    quotient.enter(v as usize);
                }
                quotient.eliminate_all()?;
            }
        }
    }
    quotient.groups()
}

/// The list of a vertex or an element.
#[derive(Debug, Clone, Copy)]
struct Head {
    at: usize,
    len: u32,
    /// The first ones of a vertex are elements.
    elements: u32,
}

/// The neighbours in a list of vertices of the same degree.
#[derive(Debug, Clone, Copy)]
struct Link {
    next: u32,
    previous: u32,
}

struct Quotient {
    n: usize,
    /// Members of elements; elements and neighbours of vertices.
    lists: Vec<u32>,
    /// Where free places begin.
    free: usize,
    /// Where the list of each vertex or element is.
    heads: Vec<Head>,
    /// Number of vertices that a vertex stands for, 0 if another stands for it or it is eliminated;
    /// less than 0 while it is a member of the element that is made.
    weight: Vec<i32>,
    /// Upper bound of the number of neighbours; for elements the number of members.
    degree: Vec<u32>,
    /// For elements, `since` and more: members that are not in the element that is made; 0: it is
    /// part of another one.
    mark: Vec<u32>,
    looks: Looks,
    /// More than all marks.
    flag: u32,
    /// The flag of the element that is made.
    since: u32,
    /// The vertices of each degree as doubly linked lists.
    first: Vec<u32>,
    links: Vec<Link>,
    /// No degree is smaller.
    least: usize,
    /// Vertices that are left, except those of very high degree.
    left: usize,
    /// Vertices in lists of their degree, and those that they stand for.
    entered: usize,
    /// The vertex or element that stands for one.
    into: Vec<u32>,
    pivots: Vec<u32>,
    table: Vec<u32>,
    /// Stage of each vertex, if there is more than one.
    stage: Vec<u32>,
}

impl Quotient {
    fn new(graph: &Graph, stages: Option<&Lists>) -> Result<Self> {
        let n = graph.n();
        let entries = graph.neighbours.len();
        let room = entries + entries / 4 + n + 1;
        let mut lists = reserved(room)?;
        lists.extend_from_slice(&graph.neighbours);
        lists.resize(room, 0);
        let mut degree = reserved(n)?;
        degree.extend((0..n).map(|v| graph.degree(v) as u32));
        let mut heads = reserved(n)?;
        let of = |v: usize| Head { at: graph.starts[v], len: graph.degree(v) as u32, elements: 0 };
        heads.extend((0..n).map(of));
        let mut stage = Vec::new();
        if let Some(stages) = stages {
            stage = repeated(0, n)?;
            for k in 0..stages.len() {
                stages.of(k).iter().for_each(|&v| stage[v as usize] = k as u32);
            }
        }
        let mut quotient = Self {
            n,
            free: entries,
            lists,
            heads,
            weight: repeated(1, n)?,
            degree,
            mark: repeated(1, n)?,
            looks: Looks::default(),
            flag: 2,
            since: 2,
            first: repeated(NONE, n.max(1))?,
            links: repeated(Link { next: NONE, previous: ABSENT }, n)?,
            least: 0,
            left: n,
            entered: 0,
            into: repeated(NONE, n)?,
            pivots: reserved(n)?,
            table: repeated(NONE, TABLE)?,
            stage,
        };
        // Rows that nearly all others share entries with are last, whatever the order.
        let high = (10.0 * (n as f64).sqrt()).max(16.0) as u32;
        for v in 0..n {
            if quotient.degree[v] > high {
                quotient.weight[v] = 0;
                quotient.heads[v].len = 0;
                quotient.left -= 1;
            }
        }
        Ok(quotient)
    }

    /// Puts a vertex of the current stage into the list of its degree.
    fn enter(&mut self, v: usize) {
        if self.weight[v] > 0 {
            self.entered += self.weight[v] as usize;
            self.link(v, self.degree[v] as usize);
        }
    }

    fn link(&mut self, v: usize, degree: usize) {
        let next = std::mem::replace(&mut self.first[degree], v as u32);
        if next != NONE {
            self.links[next as usize].previous = v as u32;
        }
        self.links[v].next = next;
        self.links[v].previous = NONE;
        self.least = self.least.min(degree);
    }

    fn unlink(&mut self, v: usize) {
        let (next, previous) = (self.links[v].next, self.links[v].previous);
        if previous == ABSENT {
            return;
        }
        if next != NONE {
            self.links[next as usize].previous = previous;
        }
        match previous {
            NONE => self.first[self.degree[v] as usize] = next,
            previous => self.links[previous as usize].next = next,
        }
        self.links[v].previous = ABSENT;
    }

    fn eliminate_all(&mut self) -> Result<()> {
        while self.entered > 0 {
            while self.first[self.least] == NONE {
                self.least += 1;
            }
            self.eliminate(self.first[self.least] as usize)?;
        }
        Ok(())
    }

    fn eliminate(&mut self, pivot: usize) -> Result<()> {
        self.unlink(pivot);
        let own = self.weight[pivot];
        self.weight[pivot] = -own;
        let (members, size) = self.gather(pivot)?;
        self.heads[pivot].at = members.start;
        self.heads[pivot].len = members.len() as u32;
        self.degree[pivot] = size;
        let looked = self.mark_elements(members.clone());
        let eliminated = self.shorten_lists(pivot, members.clone());
        let size = size - eliminated as u32;
        self.degree[pivot] = size;
        self.left -= (own + eliminated) as usize;
        self.entered -= (own + eliminated) as usize;
        self.merge(members.clone());
        let end = self.enter_again(pivot, members.clone(), size);
        self.heads[pivot].len = (end - members.start) as u32;
        self.weight[pivot] = 0;
        if end == members.start {
            self.mark[pivot] = 0;
        }
        if members.end == self.free {
            self.free = end;
        }
        self.pivots.push(pivot as u32);
        self.looks.add(looked)
    }

    /// Marks the elements of the members of the element that is made with the number of their own
    /// members that are not in it. Returns how many items the lists of its members have.
    fn mark_elements(&mut self, members: Range<usize>) -> usize {
        if self.flag > u32::MAX - 2 * self.n as u32 {
            self.mark.iter_mut().filter(|mark| **mark != 0).for_each(|mark| *mark = 1);
            self.flag = 2;
        }
        let Self { lists, heads, weight, degree, mark, .. } = self;
        let (mark, flag) = (&mut mark[..], self.flag);
        let (mut highest, mut looked) = (flag, members.len());
        for &v in &lists[members] {
            let v = v as usize;
            let weight = -weight[v] as u32;
            let head = heads[v];
            looked += head.len as usize;
            for &e in &lists[head.at..][..head.elements as usize] {
                let mark = &mut mark[e as usize];
                if *mark >= flag {
                    *mark -= weight;
                } else if *mark != 0 {
                    *mark = degree[e as usize] + flag - weight;
                    highest = highest.max(*mark);
                }
            }
        }
        // Until the next element is made, `flag - 1` is the highest mark.
        self.flag = highest + 1;
        self.since = flag;
        looked
    }

    /// Takes what the element that is made joins out of the lists of its members, bounds their
    /// degrees, and puts them into the table of equal lists. Those with nothing else in their lists
    /// are eliminated with the pivot; returns how many vertices they stand for.
    fn shorten_lists(&mut self, pivot: usize, members: Range<usize>) -> i32 {
        let Self { lists, heads, weight, mark, table, stage, since: flag, .. } = self;
        let (lists, mark, weight) = (&mut lists[..], &mut mark[..], &mut weight[..]);
        let mut eliminated = 0;
        for place in members {
            let v = lists[place] as usize;
            let head = &mut heads[v];
            let begin = head.at;
            let (middle, end) = (begin + head.elements as usize, begin + head.len as usize);
            let (mut degree, mut hash, mut to) = (0u32, 0u32, begin);
            for k in begin..middle {
                let e = lists[k];
                let mark = &mut mark[e as usize];
                if *mark > *flag {
                    degree = degree.saturating_add(*mark - *flag);
                    lists[to] = e;
                    to += 1;
                    hash = hash.wrapping_add(e);
                } else {
                    // All its members are in the element that is made.
                    *mark = 0;
                }
            }
            let others = to;
            for k in middle..end {
                let other = lists[k];
                let weight = weight[other as usize];
                if weight > 0 {
                    degree = degree.saturating_add(weight as u32);
                    lists[to] = other;
                    to += 1;
                    hash = hash.wrapping_add(other);
                }
            }
            if to == begin && (stage.is_empty() || stage[v] == stage[pivot]) {
                self.into[v] = pivot as u32;
                eliminated -= std::mem::replace(&mut weight[v], 0);
                continue;
            }
            self.degree[v] = self.degree[v].min(degree);
            head.elements = (others - begin) as u32 + 1;
            head.len = (to - begin) as u32 + 1;
            // There is room where the pivot was, or one of its elements.
            lists[to] = lists[others];
            lists[others] = lists[begin];
            lists[begin] = pivot as u32;
            // Until degrees are known, the lists of a place of the table.
            self.links[v].previous = hash;
            self.links[v].next = std::mem::replace(&mut table[hash as usize % TABLE], v as u32);
        }
        eliminated
    }

    /// Puts the members of an element, that stand for `size` vertices, into the lists of their new
    /// degrees. Returns where its list ends without those that others stand for.
    fn enter_again(&mut self, pivot: usize, members: Range<usize>, size: u32) -> usize {
        let mut to = members.start;
        for place in members {
            let v = self.lists[place] as usize;
            let weight = -self.weight[v];
            if weight == 0 {
                continue;
            }
            self.weight[v] = weight;
            let most = self.left as u32 - weight as u32;
            let degree = self.degree[v].saturating_add(size - weight as u32).min(most);
            self.degree[v] = degree;
            self.lists[to] = v as u32;
            to += 1;
            match self.is_same_stage(v, pivot) {
                true => self.link(v, degree as usize),
                false => self.links[v].previous = ABSENT,
            }
        }
        to
    }

    fn is_same_stage(&self, v: usize, other: usize) -> bool {
        self.stage.is_empty() || self.stage[v] == self.stage[other]
    }

    /// Lists the members of the element of a pivot, and takes them out of the lists of their
    /// degrees. Returns where they are, and the number of vertices that they stand for.
    fn gather(&mut self, pivot: usize) -> Result<(Range<usize>, u32)> {
        let elements = self.heads[pivot].elements as usize;
        let own = self.heads[pivot].len as usize;
        let mut size = 0;
        if elements == 0 {
            let start = self.heads[pivot].at;
            let mut to = start;
            for place in start..start + own {
                let v = self.lists[place];
                to += usize::from(self.take(v as usize, to, &mut size));
            }
            return Ok((start..to, size));
        }
        let joined = &self.lists[self.heads[pivot].at..][..elements];
        let most = joined.iter().map(|&e| self.heads[e as usize].len as usize).sum::<usize>();
        let most = most + own - elements;
        if self.free + most > self.lists.len() {
            self.compact(most)?;
        }
        let (begin, start) = (self.heads[pivot].at, self.free);
        let mut to = start;
        for k in begin..begin + elements {
            let e = self.lists[k] as usize;
            for place in self.heads[e].at..self.heads[e].at + self.heads[e].len as usize {
                let v = self.lists[place];
                to += usize::from(self.take(v as usize, to, &mut size));
            }
            self.heads[e].len = 0;
            self.mark[e] = 0;
        }
        for place in begin + elements..begin + own {
            let v = self.lists[place];
            to += usize::from(self.take(v as usize, to, &mut size));
        }
        self.free = to;
        Ok((start..to, size))
    }

    /// Writes a vertex to a place of the lists and marks it, unless it is marked, or another stands
    /// for it.
    #[inline(always)]
    fn take(&mut self, v: usize, to: usize, size: &mut u32) -> bool {
        let weight = self.weight[v];
        if weight <= 0 {
            return false;
        }
        *size += weight as u32;
        self.weight[v] = -weight;
        self.lists[to] = v as u32;
        self.unlink(v);
        true
    }

    /// Moves all lists to the start of their memory, and makes room for `more` items.
    fn compact(&mut self, more: usize) -> Result<()> {
        for v in 0..self.n {
            if self.is_listed(v) {
                let at = self.heads[v].at;
                self.heads[v].at = self.lists[at] as usize;
                self.lists[at] = MOVED | v as u32;
            }
        }
        let (mut from, mut to) = (0, 0);
        while from < self.free {
            let item = self.lists[from];
            if item & MOVED == 0 {
                from += 1;
                continue;
            }
            let v = (item & !MOVED) as usize;
            let len = self.heads[v].len as usize;
            self.lists[from] = self.heads[v].at as u32;
            self.lists.copy_within(from..from + len, to);
            self.heads[v].at = to;
            (from, to) = (from + len, to + len);
        }
        self.free = to;
        let missing = (to + more).saturating_sub(self.lists.len());
        room(&mut self.lists, missing)?;
        self.lists.resize(self.lists.len() + missing, 0);
        Ok(())
    }

    /// Returns whether a list of a vertex or an element is still read.
    fn is_listed(&self, v: usize) -> bool {
        self.heads[v].len > 0
            && (self.weight[v] != 0 || (self.into[v] == NONE && self.mark[v] != 0))
    }

    /// Merges members of an element, which are in the table, that have the same neighbours.
    fn merge(&mut self, members: Range<usize>) {
        for place in members {
            let v = self.lists[place] as usize;
            if self.weight[v] == 0 {
                continue;
            }
            // All others of the same place of the table.
            let mut one =
                std::mem::replace(&mut self.table[self.links[v].previous as usize % TABLE], NONE);
            while one != NONE && self.links[one as usize].next != NONE {
                self.merge_into(one as usize);
                one = self.links[one as usize].next;
            }
        }
    }

    /// Merges into a vertex those after it in the list of its place of the table that have the same
    /// elements and neighbours.
    fn merge_into(&mut self, v: usize) {
        let (len, elements, hash) =
            (self.heads[v].len, self.heads[v].elements, self.links[v].previous);
        let mut is_marked = false;
        let (mut before, mut other) = (v, self.links[v].next);
        while other != NONE {
            let o = other as usize;
            let is_like = self.links[o].previous == hash
                && self.heads[o].len == len
                && self.heads[o].elements == elements
                && self.is_same_stage(o, v);
            // All have the element that is made as their first.
            let mut is_same = is_like;
            if is_like {
                if !is_marked {
                    for &item in &self.lists[self.heads[v].at + 1..self.heads[v].at + len as usize]
                    {
                        self.mark[item as usize] = self.flag;
                    }
                    is_marked = true;
                }
                let items = &self.lists[self.heads[o].at + 1..self.heads[o].at + len as usize];
                is_same = items.iter().all(|&item| self.mark[item as usize] == self.flag);
            }
            other = self.links[o].next;
            if is_same {
                self.into[o] = v as u32;
                self.weight[v] += self.weight[o];
                self.weight[o] = 0;
                self.links[before].next = other;
            } else {
                before = o;
            }
        }
        self.flag += u32::from(is_marked);
    }

    /// Returns the vertices of each pivot.
    fn groups(self) -> Result<Lists> {
        let count = self.pivots.len();
        let mut group = repeated(NONE, self.n)?;
        for (k, &pivot) in (0..).zip(&self.pivots) {
            group[pivot as usize] = k;
        }
        let mut has_last = false;
        for v in 0..self.n {
            let mut root = v;
            while group[root] == NONE && self.into[root] != NONE {
                root = self.into[root] as usize;
            }
            // Of very high degree.
            if group[root] == NONE {
                has_last = true;
                group[root] = count as u32;
            }
            let found = group[root];
            let mut one = v;
            while group[one] == NONE {
                group[one] = found;
                one = self.into[one] as usize;
            }
        }
        Lists::sorted(&group, count + usize::from(has_last))
    }
}

#[cfg(test)]
mod tests {
    use super::super::graph::tests::{eliminated, graphs, grid, of_edges};
    use super::*;

    #[test]
    fn groups_have_the_same_later_neighbours() {
        for (name, graph) in graphs() {
            let groups = minimum_degree(&graph, None).unwrap();
            let mut sorted = groups.items.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..graph.n() as u32).collect::<Vec<_>>(), "{name}");
            let later = eliminated(&graph, &groups.items);
            for k in 0..groups.len() {
                for pair in groups.of(k).windows(2) {
                    let mut rest = later[pair[0] as usize].clone();
                    rest.retain(|&v| v != pair[1]);
                    assert_eq!(rest, later[pair[1] as usize], "{name}");
                    assert_eq!(rest.len() + 1, later[pair[0] as usize].len(), "{name}");
                }
            }
        }
    }

    #[test]
    fn trees_fill_in_nothing_and_grids_little() {
        let tree = of_edges(300, (1..300).map(|v| ((v - 1) / 3, v)));
        let star = of_edges(501, (1..501).map(|v| (0, v)));
        for (graph, most) in [(tree, 299), (star, 500), (grid(20, 20), 5000)] {
            let groups = minimum_degree(&graph, None).unwrap();
            let entries: usize = eliminated(&graph, &groups.items).iter().map(Vec::len).sum();
            assert!(entries <= most, "{entries} of {most}");
        }
    }

    #[test]
    fn stages_follow_each_other() {
        for (name, graph) in graphs() {
            let of: Vec<u32> = (0..graph.n() as u32).map(|v| v * 7 % 3).collect();
            let stages = Lists::sorted(&of, 3).unwrap();
            let groups = minimum_degree(&graph, Some(&stages)).unwrap();
            assert_eq!(groups.items.len(), graph.n(), "{name}");
            // Except of vertices of high degree, which are last.
            let count =
                groups.len() - usize::from(["star", "full, of high degree"].contains(&name));
            let found = (0..count).flat_map(|k| groups.of(k)).map(|&v| of[v as usize]);
            assert!(found.is_sorted(), "{name}");
        }
    }

    #[test]
    fn lists_that_move_are_the_same() {
        // Without room, they move again and again.
        for (name, graph) in graphs() {
            let expected = minimum_degree(&graph, None).unwrap();
            let mut quotient = Quotient::new(&graph, None).unwrap();
            quotient.lists.truncate(graph.neighbours.len());
            (0..graph.n()).for_each(|v| quotient.enter(v));
            while quotient.entered > 0 {
                quotient.compact(0).unwrap();
                while quotient.first[quotient.least] == NONE {
                    quotient.least += 1;
                }
                quotient.eliminate(quotient.first[quotient.least] as usize).unwrap();
            }
            let found = quotient.groups().unwrap();
            assert_eq!(found.items, expected.items, "{name}");
        }
    }

    #[test]
    fn marks_start_again_before_they_overflow() {
        let graph = grid(13, 17);
        let mut quotient = Quotient::new(&graph, None).unwrap();
        quotient.flag = u32::MAX - 2 * 13 * 17 - 200;
        (0..graph.n()).for_each(|v| quotient.enter(v));
        quotient.eliminate_all().unwrap();
        assert!(quotient.flag < 1 << 20);
        let expected = minimum_degree(&graph, None).unwrap();
        assert_eq!(quotient.groups().unwrap().items, expected.items);
    }
}
