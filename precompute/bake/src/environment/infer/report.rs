//! How well inferred geometry explains the motion it was inferred from.

use super::super::{GeometryTouchConfig, PlacedGeometry};
use super::places::{InferredTouch, TouchKind};
use super::plates::{InferredPlate, ON_GROUND};
use super::{bars::InferredBar, visit_poses};
use serde::{Deserialize, Serialize};
use std::fmt;
use throng_core::{Contacts, Skeleton};
use throng_motion::Clip;

/// Counts of inferred geometry and its residuals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct InferReport {
    /// Places of heels and toes.
    pub foot_places: usize,
    /// Places of seats.
    pub seat_places: usize,
    /// Places of hands.
    pub hand_places: usize,
    /// Places of hands on no bar: pauses in the air, or unknown things.
    pub hands_unexplained: usize,
    /// Places of feet and seats on the ground.
    pub on_ground: usize,
    /// Plates.
    pub plates: usize,
    /// Plates inferred from a single place.
    pub plates_of_one: usize,
    /// Bars.
    pub bars: usize,
    /// Bars inferred from fewer than three places: their direction is a guess.
    pub bars_guessed: usize,
    /// Plates and bars that were dropped because the body passes through them.
    pub dismissed: usize,
    /// Units.
    pub units: usize,
    /// Root mean square distance of places from their plates and bars (m).
    pub residual_rms_m: f32,
    /// Largest distance of a place (m).
    pub residual_max_m: f32,
    /// Share of usable frames with something planted on the geometry or the ground.
    pub planted_share: f32,
    /// Share of usable frames with the body deeper in the geometry than `penetration` allows.
    pub penetrating_share: f32,
}

impl InferReport {
    /// Counts and residuals.
    pub fn from_places(places: &[InferredTouch], plates: &[InferredPlate], bars: &[InferredBar]) -> Self {
        let count = |kind: TouchKind| places.iter().filter(|t| t.kind == kind).count();
        let others = || places.iter().filter(|t| t.kind != TouchKind::Hand);
        let ground = || others().map(|t| t.point.y.abs()).filter(|y| *y <= ON_GROUND);
        let of_plate = |p: &InferredPlate| p.heights.iter().map(|h| (h - p.height).abs()).collect::<Vec<_>>();
        let off: Vec<f32> =
            ground().chain(plates.iter().flat_map(of_plate)).chain(bars.iter().flat_map(|b| b.off.clone())).collect();
        let square = off.iter().map(|d| d * d).sum::<f32>() / off.len().max(1) as f32;
        Self {
            foot_places: count(TouchKind::Foot),
            seat_places: count(TouchKind::Seat),
            hand_places: count(TouchKind::Hand),
            hands_unexplained: count(TouchKind::Hand) - bars.iter().map(|b| b.off.len()).sum::<usize>(),
            on_ground: ground().count(),
            plates: plates.len(),
            plates_of_one: plates.iter().filter(|p| p.heights.len() == 1).count(),
            bars: bars.len(),
            bars_guessed: bars.iter().filter(|b| b.off.len() < 3).count(),
            residual_rms_m: square.sqrt(),
            residual_max_m: off.into_iter().fold(0.0, f32::max),
            ..Self::default()
        }
    }

    /// Measures how well the clips agree with the geometry.
    pub fn measure(&mut self, clips: &[&Clip], skeleton: &Skeleton, geometry: &PlacedGeometry) {
        let tolerance = GeometryTouchConfig::default().penetration;
        let (mut frames, mut planted, mut deep) = (0usize, 0usize, 0usize);
        visit_poses(clips, skeleton, geometry, |pose, _| {
            frames += 1;
            planted += usize::from(pose.contacts != Contacts::NONE);
            deep += usize::from(pose.penetration_in(geometry, tolerance).is_some());
        });
        let share = |n: usize| n as f32 / frames.max(1) as f32;
        (self.planted_share, self.penetrating_share) = (share(planted), share(deep));
    }
}

impl fmt::Display for InferReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { foot_places, seat_places, hand_places, hands_unexplained, on_ground, plates, plates_of_one, .. } =
            self;
        let Self { bars, bars_guessed, dismissed, units, .. } = self;
        let total = foot_places + seat_places;
        writeln!(f, "{foot_places} places of feet, {seat_places} of seats, {hand_places} of hands")?;
        writeln!(
            f,
            "{on_ground} of {total} on the ground, the others on {plates} plates ({plates_of_one} of one place)"
        )?;
        write!(f, "{bars} bars ({bars_guessed} of fewer than three places, direction guessed), ")?;
        writeln!(f, "{hands_unexplained} places of hands on none")?;
        writeln!(f, "{units} units; {dismissed} plates and bars dismissed, because the body goes through them")?;
        let (rms, max) = (1000.0 * self.residual_rms_m, 1000.0 * self.residual_max_m);
        writeln!(f, "residual {rms:.0} mm rms, {max:.0} mm at most")?;
        let (planted, deep) = (100.0 * self.planted_share, 100.0 * self.penetrating_share);
        write!(f, "{planted:.0} % of frames planted, {deep:.1} % with the body inside the geometry")
    }
}
