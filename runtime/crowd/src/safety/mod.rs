//! Why nobody ever overlaps anybody: the rule, the bounds that say when two can meet, and who has to be compared.

pub(crate) mod bound;
pub(crate) mod others;
pub(crate) mod reach;
pub(crate) mod rule;
