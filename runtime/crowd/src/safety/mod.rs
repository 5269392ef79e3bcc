//! Safety, so that no two agents ever overlap: the rule, the bounds on when two can meet, and the pairs that are
//! compared.

pub(crate) mod bound;
pub(crate) mod nearby_plans;
pub(crate) mod reach;
pub(crate) mod rule;
pub(crate) mod saved_plans;
