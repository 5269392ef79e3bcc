//! How far joints turn and how fast: swing and twist with spherical ellipses, flexion and twist, swing alone.

mod file;
mod joint;
mod sample;

pub use file::{BodyLimits, LimitsError};
pub use joint::{AngleInterval, Coordinates, JointLimits, SwingLimit};
pub use sample::{PoseSampler, Style};
