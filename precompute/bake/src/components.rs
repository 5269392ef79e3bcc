//! Largest strongly connected component of an implicit graph (Tarjan 1972, as Pearce 2016 stores it).

/// A graph that enumerates the successors of each node.
pub(crate) trait SuccessorGraph {
    /// Position in the enumeration of a node's successors.
    type Cursor: Copy + Default;

    /// Number of nodes (< u32::MAX).
    fn num_nodes(&self) -> usize;

    /// Next successor of a node after those already enumerated with the cursor.
    fn next(&self, node: u32, cursor: &mut Self::Cursor) -> Option<u32>;

    /// All successors of a node.
    fn successors(&self, node: u32) -> impl Iterator<Item = u32> {
        let mut cursor = Self::Cursor::default();
        std::iter::from_fn(move || self.next(node, &mut cursor))
    }
}

/// Number of the strongly connected component of every node.
///
/// Components are numbered downwards from `num_nodes` in the order of completion: every edge leads to a component of
/// the same number or a higher one. Memory: one number a node beside the depth of the search.
pub(crate) fn components<G: SuccessorGraph>(graph: &G) -> Vec<u32> {
    let (num, pending, path) = (graph.num_nodes(), Vec::new(), Vec::new());
    let number = vec![0; num];
    let mut search = ComponentSearch::<G> { graph, number, pending, path, index: 1, component: num as u32 };
    for node in 0..num as u32 {
        if search.number[node as usize] == 0 {
            search.search_from(node);
        }
    }
    search.number
}

struct SearchFrame<C> {
    node: u32,
    is_root: bool,
    cursor: C,
}

struct ComponentSearch<'a, G: SuccessorGraph> {
    graph: &'a G,
    /// State of each node: 0 if unseen; on the current path the lowest index it leads back to; then its component.
    number: Vec<u32>,
    /// Finished nodes without a component yet.
    pending: Vec<u32>,
    path: Vec<SearchFrame<G::Cursor>>,
    index: u32,
    component: u32,
}

impl<G: SuccessorGraph> ComponentSearch<'_, G> {
    fn search_from(&mut self, start: u32) {
        self.enter(start);
        while let Some(step) = self.path.last_mut() {
            let node = step.node;
            match self.graph.next(node, &mut step.cursor) {
                Some(to) if self.number[to as usize] == 0 => self.enter(to),
                Some(to) => {
                    if self.number[to as usize] < self.number[node as usize] {
                        self.number[node as usize] = self.number[to as usize];
                        step.is_root = false;
                    }
                }
                None => self.leave(),
            }
        }
    }

    fn enter(&mut self, node: u32) {
        self.number[node as usize] = self.index;
        self.index += 1;
        self.path.push(SearchFrame { node, is_root: true, cursor: G::Cursor::default() });
    }

    fn leave(&mut self) {
        let Some(step) = self.path.pop() else { return };
        let own = self.number[step.node as usize];
        if step.is_root {
            self.index -= 1;
            while let Some(top) = self.pending.pop_if(|top| own <= self.number[*top as usize]) {
                self.number[top as usize] = self.component;
                self.index -= 1;
            }
            self.number[step.node as usize] = self.component;
            self.component -= 1;
        } else {
            self.pending.push(step.node);
        }
        if let Some(before) = self.path.last_mut() {
            let lowest = self.number[step.node as usize];
            if lowest < self.number[before.node as usize] {
                self.number[before.node as usize] = lowest;
                before.is_root = false;
            }
        }
    }
}

/// First node of the component with most nodes; on a tie of the one with the first node.
///
/// - returns `None` if no node leads back to itself.
pub(crate) fn largest<G: SuccessorGraph>(graph: &G) -> Option<u32> {
    let component = components(graph);
    let lowest = *component.iter().min()?;
    let mut sizes = vec![0u32; graph.num_nodes() + 1 - lowest as usize];
    for c in &component {
        sizes[(c - lowest) as usize] += 1;
    }
    let most = *sizes.iter().max()?;
    let lead_back = |n: u32| most > 1 || graph.successors(n).any(|w| w == n);
    (0..component.len() as u32).find(|&n| sizes[(component[n as usize] - lowest) as usize] == most && lead_back(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug)]
    struct Explicit(Vec<Vec<u32>>);

    impl SuccessorGraph for Explicit {
        type Cursor = usize;

        fn num_nodes(&self) -> usize {
            self.0.len()
        }

        fn next(&self, node: u32, cursor: &mut usize) -> Option<u32> {
            *cursor += 1;
            self.0[node as usize].get(*cursor - 1).copied()
        }
    }

    /// Which node gets to which, by Warshall's method; each to itself.
    fn reach(graph: &Explicit) -> Vec<Vec<bool>> {
        let n = graph.0.len();
        let mut r: Vec<Vec<bool>> =
            (0..n).map(|i| (0..n).map(|j| i == j || graph.0[i].contains(&(j as u32))).collect()).collect();
        for k in 0..n {
            for i in 0..n {
                for j in 0..n {
                    r[i][j] |= r[i][k] && r[k][j];
                }
            }
        }
        r
    }

    fn graphs() -> impl Strategy<Value = Explicit> {
        (1usize..16)
            .prop_flat_map(|n| prop::collection::vec(prop::collection::vec(0..n as u32, 0..3), n).prop_map(Explicit))
    }

    proptest! {
        #[test]
        fn components_are_those_that_reach_each_other(graph in graphs()) {
            let (r, c) = (reach(&graph), components(&graph));
            for i in 0..c.len() {
                for j in 0..c.len() {
                    prop_assert_eq!(c[i] == c[j], r[i][j] && r[j][i]);
                    prop_assert!(!r[i][j] || c[i] <= c[j]);
                }
            }
        }

        #[test]
        fn the_largest_is_the_one_of_most_nodes_and_of_those_the_first(graph in graphs()) {
            let r = reach(&graph);
            let n = graph.0.len();
            let size = |i: usize| {
                let all = (0..n).filter(|&j| r[i][j] && r[j][i]).count();
                if all > 1 || graph.0[i].contains(&(i as u32)) { all } else { 0 }
            };
            let best = (0..n).rev().max_by_key(|&i| size(i)).filter(|&i| size(i) > 0);
            prop_assert_eq!(largest(&graph), best.map(|b| b as u32));
        }
    }

    #[test]
    fn a_long_way_does_not_end_the_stack() {
        let n = 300_000;
        let ring = Explicit((0..n).map(|i| vec![(i + 1) % n]).collect());
        assert_eq!(largest(&ring), Some(0));
        assert!(components(&ring).iter().all(|c| *c == n));
    }
}
