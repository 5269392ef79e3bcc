//! The range of every number that applications and command lines give, each in one place.

use crate::{Id, Result, error::check_value};
use std::str::FromStr;

/// Range of a quantity, its ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Counted or measured quantity, in words.
    pub quantity: &'static str,
    /// Least value.
    pub least: f64,
    /// Greatest value.
    pub most: f64,
    /// Both limits in words, with their unit.
    pub range: &'static str,
}

impl Limit {
    /// True for a value in the range; false for NaN.
    pub fn contains(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }

    /// Fails with [`crate::Error::Value`] unless the value is in the range.
    ///
    /// - `what`: name of the parameter, for the message.
    ///
    /// # Errors
    /// As said.
    pub fn check(&self, what: &'static str, who: Option<Id>, value: impl Into<f64>) -> Result<()> {
        let value = value.into();
        check_value(what, who, value, self.contains(value), self.range)
    }

    /// Fails as [`Limit::check`] unless a count is in the range.
    ///
    /// # Errors
    /// As said.
    pub fn check_count(&self, what: &'static str, count: usize) -> Result<()> {
        self.check(what, None, count as f64)
    }
}

macro_rules! limits {
    ($($name:ident = $quantity:literal: $least:literal to $most:literal $unit:literal;)*) => {
        $(
            #[doc = concat!($quantity, ": ", $least, " to ", $most, $unit, ".")]
            pub static $name: Limit = Limit {
                quantity: $quantity,
                least: $least as f64,
                most: $most as f64,
                range: concat!($least, " to ", $most, $unit),
            };
        )*
        /// All ranges.
        pub static ALL: &[&Limit] = &[$(&$name),*];
    };
}

limits! {
    CACHE_GB = "most that a cache keeps": 0 to 1_000_000 " GB";
    CAPACITY = "places for characters or agents": 0 to 1_000_000 "";
    CHARACTERS = "number of characters or agents": 1 to 1_000_000 "";
    COORDINATE = "coordinate": -100_000 to 100_000 " m";
    EXPORT_HZ = "frames a second that are written": 1 to 1000 " Hz";
    FOLLOWED = "number of a character": 0 to 999_999 "";
    CLIMB_M = "highest step": 0 to 10 " m";
    FRAMES = "number of frames": 1 to 1_000_000 "";
    HEIGHT_M = "free height": 0.1 to 100 " m";
    LIVE_SPEED = "simulated seconds a second": 0 to 1000 "";
    MEASURING_S = "time given to a figure": 0.000_1 to 3600 " s";
    METRES_PER_UNIT = "length of a unit": 0.000_001 to 1_000_000 " m";
    MOMENT_S = "moment of a run": 0 to 100_000 " s";
    MOTION_HZ = "frames a second of motion files": 0.1 to 100_000 " Hz";
    RADIUS_M = "radius of who walks": 0.01 to 10 " m";
    PATH_STEPS = "steps of all paths that are kept": 0 to 300_000_000 "";
    PICTURE_SIDE = "side of a picture or a window": 16 to 8192 " pixels";
    RATE_HZ = "frames a second": 20 to 240 " Hz";
    REPEATS = "number of runs": 1 to 100 "";
    SCALE = "scale of what is shown": 0.5 to 3 "";
    SECONDS = "simulated time": 0.001 to 100_000 " s";
    SEED = "seed": 0 to 18_446_744_073_709_551_615u64 "";
    SHOWN_CHARACTERS = "number of characters shown": 1 to 100_000 "";
    SHOWN_FRAME = "frame of a clip": 0 to 4_294_967_295u32 "";
    SLOPE_DEG = "steepest slope": 0 to 89 " degrees";
    STATE = "state of a motion graph": 0 to 4_294_967_295u32 "";
    STEP_HZ = "steps a second": 1 to 10_000 " Hz";
    STEP_S = "time step": 0 to 1 " s";
    SYNTH_HOURS = "length of synthetic motion": 0.001 to 1000 " h";
    SYNTH_MINUTES = "length of synthetic motion": 0.05 to 240 " min";
    TEMPERATURE = "temperature of choices": 0 to 1000 "";
    THREADS = "number of threads": 1 to 1024 "";
    TRAJECTORY_HZ = "points of a trajectory a second": 0.1 to 240 " Hz";
}

/// Number types that people may write in files and commands.
pub trait Number: FromStr + Clone + Send + Sync + 'static {
    /// Value that is compared with a limit.
    fn value(&self) -> f64;
}

macro_rules! numbers {
    ($($t:ty),*) => {
        $(impl Number for $t {
            fn value(&self) -> f64 {
                *self as f64
            }
        })*
    };
}

numbers!(usize, u32, u64, f32, f64);

/// Parser of a number within its limit; other texts are refused with a message that names the range.
pub fn number_parser<T: Number>(
    limit: &'static Limit,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.trim().parse::<T>().ok().filter(|n| limit.contains(n.value()));
        number.ok_or_else(|| format!("expected {} ({})", limit.range, limit.quantity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_in_a_range_is_refused_with_the_range() {
        for limit in ALL {
            assert!(limit.contains(limit.least) && limit.contains(limit.most), "{limit:?}");
            for out in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, limit.least - 1.0] {
                assert!(!limit.contains(out), "{limit:?}: {out}");
                let e = limit.check("x", None, out).unwrap_err().to_string();
                assert!(e.contains(limit.range), "{e}");
            }
        }
        assert!(CAPACITY.check_count("capacity", usize::MAX).is_err());
        assert_eq!((STEP_HZ.range, SECONDS.range), ("1 to 10000 Hz", "0.001 to 100000 s"));
        assert_eq!(SEED.range, format!("0 to {}", u64::MAX));
    }
}
