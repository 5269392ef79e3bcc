//! Agents in lasting contact: the contact graph of Kim, Kim and Shin (2003a), section 2.3.

use crate::NONE;
use serde::{Deserialize, Serialize};

/// Most others that one is known to touch; further ones are taken for strangers. As many as balls of equal size can.
pub(crate) const MOST: usize = 12;

/// A graph of agents that are in contact, and its connected components: the contact groups.
///
/// A group is named by the smallest number in it. Agents of a group do not move relative to each other, so that nobody has
/// to look whether they meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactGraph {
    touched: Vec<[u32; MOST]>,
    group: Vec<u32>,
    /// Agents of the group that was changed last.
    changed: Vec<u32>,
}

impl ContactGraph {
    /// No contacts among agents with numbers below `capacity`.
    pub fn new(capacity: usize) -> Self {
        let changed = Vec::with_capacity(capacity);
        Self { touched: vec![[NONE; MOST]; capacity], group: (0..capacity as u32).collect(), changed }
    }

    /// Memory that a copy did not bring along.
    pub fn reserve(&mut self) {
        self.changed.reserve(self.group.len() - self.changed.len());
    }

    /// True if it is as large as another one, and consistent: contacts are mutual, groups are those of the graph.
    pub fn fits(&self, other: &Self) -> bool {
        let n = other.group.len();
        if self.touched.len() != n || self.group.len() != n || self.changed.len() > n {
            return false;
        }
        let is_mutual = |m: u32| {
            self.contacts_of(m)
                .all(|o| o != m && (o as usize) < n && self.contacts_of(o).filter(|&p| p == m).count() == 1)
        };
        if !(0..n as u32).all(is_mutual) {
            return false;
        }
        let mut again = Self { group: vec![NONE; n], changed: Vec::new(), touched: self.touched.clone() };
        for m in 0..n as u32 {
            if again.group[m as usize] == NONE {
                again.flood(m, m);
            }
        }
        again.group == self.group
    }

    /// Those that an agent touches.
    pub fn contacts_of(&self, agent: u32) -> impl Iterator<Item = u32> + '_ {
        self.touched[agent as usize].iter().copied().take_while(|&o| o != NONE)
    }

    /// One of those that an agent touches.
    pub fn nth(&self, agent: u32, n: usize) -> Option<u32> {
        self.touched[agent as usize].get(n).copied().filter(|&o| o != NONE)
    }

    /// True where two are in the same group.
    #[inline]
    pub fn are_together(&self, a: u32, b: u32) -> bool {
        self.group[a as usize] == self.group[b as usize]
    }

    /// Notes a contact; false where it is known, or one of them touches as many as can be noted.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let is_full = |m: u32| self.nth(m, MOST - 1).is_some();
        if a == b || is_full(a) || is_full(b) || self.contacts_of(a).any(|o| o == b) {
            return false;
        }
        for (m, o) in [(a, b), (b, a)] {
            let len = self.contacts_of(m).count();
            self.touched[m as usize][len] = o;
        }
        let (p, q) = (self.group[a as usize], self.group[b as usize]);
        if p < q {
            self.flood(b, p);
        } else if q < p {
            self.flood(a, q);
        }
        true
    }

    /// Forgets a contact. Where that splits a group, its two parts become groups, and the agents of the one that `b` is
    /// in are given by [`ContactGraph::changed`]; otherwise that is empty.
    pub fn part(&mut self, a: u32, b: u32) {
        self.changed.clear();
        if !self.contacts_of(a).any(|o| o == b) {
            return;
        }
        for (m, o) in [(a, b), (b, a)] {
            let touched = &mut self.touched[m as usize];
            let at = touched.iter().position(|&x| x == o).unwrap_or(MOST - 1);
            touched.copy_within(at + 1.., at);
            touched[MOST - 1] = NONE;
        }
        // An unused name marks the part of `b`.
        self.flood(b, NONE);
        if self.group[a as usize] == NONE {
            self.name_group(b);
            self.changed.clear();
            return;
        }
        self.name_group(a);
        self.name_group(b);
    }

    /// Names the group of an agent after its first agent.
    fn name_group(&mut self, agent: u32) {
        self.flood(agent, NONE - 1);
        let name = self.changed.iter().copied().min().unwrap_or(agent);
        self.flood(agent, name);
    }

    /// See [`ContactGraph::part`].
    pub fn changed(&self, n: usize) -> Option<u32> {
        self.changed.get(n).copied()
    }

    /// Gives the part of a group that can be reached from an agent another name, and lists it.
    fn flood(&mut self, from: u32, name: u32) {
        let old = self.group[from as usize];
        self.changed.clear();
        self.changed.push(from);
        self.group[from as usize] = name;
        let mut next = 0;
        while let Some(&agent) = self.changed.get(next) {
            next += 1;
            for other in self.touched[agent as usize].into_iter().take_while(|&o| o != NONE) {
                if self.group[other as usize] == old {
                    self.group[other as usize] = name;
                    self.changed.push(other);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Smallest number that can be reached from each agent.
    fn by_force(edges: &[(u32, u32)], n: u32) -> Vec<u32> {
        let mut name: Vec<u32> = (0..n).collect();
        for _ in 0..n {
            for &(a, b) in edges {
                let least = name[a as usize].min(name[b as usize]);
                (name[a as usize], name[b as usize]) = (least, least);
            }
        }
        name
    }

    proptest! {
        #[test]
        fn groups_are_connected_components(work in proptest::collection::vec((0u32..20, 0u32..20, any::<bool>()), 1..200)) {
            let mut contacts = ContactGraph::new(20);
            let empty = contacts.clone();
            let mut edges: Vec<(u32, u32)> = Vec::new();
            for (a, b, joins) in work {
                let (a, b) = (a.min(b), a.max(b));
                let is_known = edges.contains(&(a, b));
                let before = contacts.group.clone();
                if joins {
                    let degree = |m: u32| edges.iter().filter(|e| e.0 == m || e.1 == m).count();
                    let may = a != b && !is_known && degree(a) < MOST && degree(b) < MOST;
                    prop_assert_eq!(contacts.join(a, b), may);
                    if may {
                        edges.push((a, b));
                    }
                } else {
                    edges.retain(|&e| e != (a, b));
                    contacts.part(a, b);
                    let splits = is_known && by_force(&edges, 20)[a as usize] != by_force(&edges, 20)[b as usize];
                    let mut got: Vec<u32> = (0..20).map_while(|n| contacts.changed(n)).collect();
                    got.sort_unstable();
                    let want: Vec<u32> = (0..20).filter(|&m| splits && contacts.are_together(m, b)).collect();
                    prop_assert_eq!(got, want, "part that splits off, from {:?}", before);
                }
                prop_assert_eq!(&contacts.group, &by_force(&edges, 20));
                prop_assert!(contacts.fits(&empty));
            }
        }
    }

    #[test]
    fn damaged_graph_is_refused() {
        let empty = ContactGraph::new(4);
        let mut whole = empty.clone();
        whole.join(0, 1);
        assert!(whole.fits(&empty) && !whole.fits(&ContactGraph::new(5)));
        let damage: [fn(&mut ContactGraph); 4] =
            [|c| c.touched[0][0] = 9, |c| c.touched[0][0] = 0, |c| c.touched[2][0] = 3, |c| c.group[1] = 1];
        for f in damage {
            let mut damaged = whole.clone();
            f(&mut damaged);
            assert!(!damaged.fits(&empty), "{damaged:?}");
        }
    }
}
