//! Keys by identity: a shared value in place of everything it was computed from.

use std::hash::{Hash, Hasher};
use std::sync::Arc;

/// A shared value, equal only to itself.
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
    fn a_shared_thing_is_equal_to_itself_alone() {
        let (a, b) = (Arc::new(1), Arc::new(1));
        let mut known = HashSet::from([IdentityArc::new(&a)]);
        assert!(!known.insert(IdentityArc::new(&a)) && known.insert(IdentityArc::new(&b)));
    }
}
