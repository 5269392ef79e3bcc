//! Numbering of shared values, which are found without comparing their inputs.

use std::hash::{Hash, Hasher};
use std::{collections::HashMap, sync::Arc};

/// Numbers of shared values, in the order of first use.
pub(in crate::stitch) struct SharedNumbers<T> {
    known: HashMap<IdentityArc<T>, u32>,
    /// All used values, by number.
    pub all: Vec<Arc<T>>,
}

impl<T> Default for SharedNumbers<T> {
    fn default() -> Self {
        Self { known: HashMap::new(), all: Vec::new() }
    }
}

impl<T> SharedNumbers<T> {
    /// The number of a shared thing.
    pub fn number_of(&mut self, shared: &Arc<T>) -> u32 {
        let all = &mut self.all;
        *self.known.entry(IdentityArc::new(shared)).or_insert_with(|| {
            all.push(Arc::clone(shared));
            all.len() as u32 - 1
        })
    }
}

/// A shared value, equal only to itself: a key in place of everything it was computed from.
#[derive(Debug)]
pub(in crate::stitch) struct IdentityArc<T>(pub Arc<T>);

impl<T> IdentityArc<T> {
    /// Key of a shared value.
    pub fn new(shared: &Arc<T>) -> Self {
        Self(Arc::clone(shared))
    }
}

impl<T> Clone for IdentityArc<T> {
    fn clone(&self) -> Self {
        Self::new(&self.0)
    }
}

impl<T> PartialEq for IdentityArc<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T> Eq for IdentityArc<T> {}

impl<T> Hash for IdentityArc<T> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        Arc::as_ptr(&self.0).hash(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn shared_values_have_one_number_each_in_the_order_of_their_first_use() {
        let [a, b] = ['a', 'b'].map(Arc::new);
        let mut numbers = SharedNumbers::default();
        assert_eq!([&b, &a, &b, &Arc::new('b'), &a].map(|c| numbers.number_of(c)), [0, 1, 0, 2, 1]);
        assert_eq!(numbers.all.iter().map(|c| **c).collect::<String>(), "bab");
    }

    #[test]
    fn a_shared_thing_is_equal_to_itself_alone() {
        let (a, b) = (Arc::new(1), Arc::new(1));
        let mut known = HashSet::from([IdentityArc::new(&a)]);
        assert!(!known.insert(IdentityArc::new(&a)) && known.insert(IdentityArc::new(&b)));
    }
}
