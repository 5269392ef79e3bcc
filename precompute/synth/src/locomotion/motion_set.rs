//! Contents of the set: gaits at speeds and turning rates.

use super::{Drive, MANNERS, Manner};

/// A gait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GaitKind {
    /// Standing at ease.
    Idle,
    /// Turning on the spot, step by step.
    Turn,
    /// Stepping sideways.
    Side,
    /// Stepping backwards.
    Back,
    /// Walking.
    Walk,
    /// Running slowly.
    Jog,
    /// Running.
    Run,
}

impl GaitKind {
    /// Name in names and tags of clips.
    pub fn name(self) -> &'static str {
        ["idle", "turn", "side", "back", "walk", "jog", "run"][self as usize]
    }

    /// True for gaits with moments at which neither foot is on the ground.
    pub fn flies(self) -> bool {
        matches!(self, Self::Jog | Self::Run)
    }
}

/// Motion of one clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocomotionAct {
    /// Gait.
    pub gait: GaitKind,
    /// Manner.
    pub manner: &'static Manner,
    /// Velocity and turning rate.
    pub drive: Drive,
}

/// Speeds and turning rates of forward gaits (m/s, rad/s).
const AHEAD: [(GaitKind, [f64; 4], [f64; 2]); 3] = [
    (GaitKind::Walk, [0.7, 1.1, 1.5, 1.9], [0.4, 0.8]),
    (GaitKind::Jog, [2.0, 2.35, 2.7, 3.0], [0.4, 0.8]),
    (GaitKind::Run, [3.2, 3.8, 4.4, 5.0], [0.3, 0.6]),
];
/// Turning rates on the spot (rad/s).
const TURNS: [f64; 2] = [0.7, 1.3];
/// Speeds sideways (m/s).
const SIDE: [f64; 2] = [0.3, 0.6];
/// Speeds backwards, and the turning rate (m/s, rad/s).
const BACK: ([f64; 2], f64) = ([0.4, 0.8], 0.4);

impl LocomotionAct {
    /// All acts of the set, one manner after the other.
    pub fn all() -> Vec<Self> {
        MANNERS.iter().flat_map(Self::in_manner).collect()
    }

    fn in_manner(manner: &'static Manner) -> Vec<Self> {
        let mut out = Vec::new();
        let mut add = |gait, left, ahead, gyration| {
            out.push(Self { gait, manner, drive: Drive { left, ahead, gyration } });
        };
        for (gait, speeds, rates) in AHEAD {
            let rates = mirror_rates(&rates);
            for speed in speeds {
                rates.iter().for_each(|rate| add(gait, 0.0, speed, *rate));
            }
        }
        add(GaitKind::Idle, 0.0, 0.0, 0.0);
        TURNS.iter().flat_map(|r| [*r, -r]).for_each(|rate| add(GaitKind::Turn, 0.0, 0.0, rate));
        SIDE.iter().flat_map(|v| [*v, -v]).for_each(|speed| add(GaitKind::Side, speed, 0.0, 0.0));
        let rates = mirror_rates(&[BACK.1]);
        for speed in BACK.0 {
            rates.iter().for_each(|rate| add(GaitKind::Back, 0.0, -speed, *rate));
        }
        out
    }

    /// Name of its clip: gait, manner, speed in cm/s (`v` along, `l` and `r` to a side), turning rate in tenths of a
    /// radian a second (`gl` to the left, `gr` to the right), and the number of the take from the second one on.
    pub fn name(&self, take: usize) -> String {
        let Self { gait, manner, drive } = self;
        let mut name = format!("{}_{}", gait.name(), manner.name);
        let side = |x: f64| if x > 0.0 { "l" } else { "r" };
        let cm = |v: f64| (v.abs() * 100.0).round();
        match gait {
            GaitKind::Idle | GaitKind::Turn => {}
            GaitKind::Side => name += &format!("_{}{:03}", side(drive.left), cm(drive.left)),
            _ => name += &format!("_v{:03}", cm(drive.ahead)),
        }
        match gait {
            GaitKind::Idle | GaitKind::Side => {}
            _ if drive.gyration == 0.0 => name += "_g00",
            _ => name += &format!("_g{}{:02}", side(drive.gyration), (drive.gyration.abs() * 10.0).round()),
        }
        if take > 0 { format!("{name}_t{}", take + 1) } else { name }
    }
}

/// Zero, and each rate to the left and to the right.
fn mirror_rates(rates: &[f64]) -> Vec<f64> {
    std::iter::once(0.0).chain(rates.iter().flat_map(|r| [*r, -r])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_gait_ahead_has_four_speeds_and_five_turning_rates_in_every_manner() {
        let all = LocomotionAct::all();
        for (manner, gait) in MANNERS.iter().flat_map(|m| AHEAD.map(|a| (m, a.0))) {
            let of: Vec<_> = all.iter().filter(|a| a.manner.name == manner.name && a.gait == gait).collect();
            let speeds: BTreeSet<u64> = of.iter().map(|a| a.drive.ahead.to_bits()).collect();
            let rates: BTreeSet<u64> = of.iter().map(|a| a.drive.gyration.to_bits()).collect();
            assert_eq!((of.len(), speeds.len(), rates.len()), (20, 4, 5), "{} {}", gait.name(), manner.name);
        }
    }

    #[test]
    fn names_say_what_is_shown_and_are_all_different() {
        let names: BTreeSet<String> =
            (0..2).flat_map(|take| LocomotionAct::all().into_iter().map(move |a| a.name(take))).collect();
        assert_eq!(names.len(), 2 * LocomotionAct::all().len());
        for name in
            ["walk_neutral_v110_gl08", "turn_tired_gr13", "side_proud_l060", "back_neutral_v040_g00", "idle_proud_t2"]
        {
            assert!(names.contains(name), "{name}");
        }
    }
}
