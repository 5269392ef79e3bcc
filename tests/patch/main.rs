//! Worlds are put together from motion: groups of poses that may follow each other, and what is built on them.

mod groups;
