//! Motion patches and worlds of them: mathematics against brute force and small cases made up by hand.

mod groups;
mod made_up;
mod stitch;
