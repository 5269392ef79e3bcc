//! Number of hits, and where they land, as Lee and Lee (2004) report it.

use super::HitPoint;
use serde::Serialize;
use std::collections::BTreeMap;

/// Effective hitting points relative to the planar root: number, kinds and extent. The names of the fields are keys
/// of JSON reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct HitReport {
    /// Number of hits.
    pub count: usize,
    /// Smallest and largest angle from straight ahead, positive to the left; absent where there is no hit (rad).
    pub angle_rad: Option<[f32; 2]>,
    /// Smallest and largest distance over the ground; absent where there is no hit (m).
    pub distance_m: Option<[f32; 2]>,
    /// Least and greatest height above the ground; absent where there is no hit (m).
    pub height_m: Option<[f32; 2]>,
    /// Number of hits of each kind.
    pub kinds: BTreeMap<String, usize>,
}

impl HitReport {
    /// Summarises hits.
    pub fn new(points: &[HitPoint]) -> Self {
        let mut out = Self { count: points.len(), ..Self::default() };
        for h in points {
            *out.kinds.entry(h.kind.clone()).or_insert(0) += 1;
            widen(&mut out.angle_rad, h.angle());
            widen(&mut out.distance_m, h.distance());
            widen(&mut out.height_m, h.position.y);
        }
        out
    }
}

fn widen(range: &mut Option<[f32; 2]>, value: f32) {
    let [low, high] = range.unwrap_or([value; 2]);
    *range = Some([low.min(value), high.max(value)]);
}

impl std::fmt::Display for HitReport {
    /// Writes the report in the words of Lee and Lee (2004), section 6.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Some([right, left]), Some(distance), Some(height)) = (self.angle_rad, self.distance_m, self.height_m)
        else {
            return f.write_str("no effective hitting points");
        };
        let [[near, far], [low, high]] = [distance, height].map(|range| range.map(|metres| 100.0 * metres));
        let kinds: Vec<String> = self.kinds.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
        write!(
            f,
            "{} effective hitting points ({}): angle {right:.3} to {left:.3} rad, distance {near:.1} to {far:.1} cm, \
             height {low:.1} to {high:.1} cm",
            self.count,
            kinds.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::f32::consts::FRAC_PI_2;
    use throng_core::Joint;

    fn point(kind: &str, position: Vec3) -> HitPoint {
        HitPoint {
            clip: "a".into(),
            frame: 0,
            time_s: 0.0,
            kind: kind.into(),
            joint: Joint::LeftHand,
            position,
            direction: Vec3::Z,
            speed_mps: 1.0,
            force: 1.0,
        }
    }

    #[test]
    fn ranges_hold_every_point_and_kinds_are_counted() {
        let points = [
            point("punch", Vec3::new(0.0, 1.4, 0.6)),
            point("kick", Vec3::new(-0.8, 1.0, 0.0)),
            point("punch", Vec3::Y),
        ];
        let r = HitReport::new(&points);
        assert_eq!((r.count, r.kinds["punch"], r.kinds["kick"]), (3, 2, 1));
        assert_eq!(r.angle_rad, Some([-FRAC_PI_2, 0.0]));
        assert_eq!((r.distance_m, r.height_m), (Some([0.0, 0.8]), Some([1.0, 1.4])));
        let text = r.to_string();
        assert!(text.starts_with("3 effective hitting points (kick 1, punch 2): angle -1.571 to 0.000 rad"), "{text}");
    }

    #[test]
    fn without_hits_ranges_are_null() {
        let none = HitReport::default();
        let json = serde_json::to_value(&none).unwrap();
        let empty = serde_json::json!({
            "count": 0, "angle_rad": null, "distance_m": null, "height_m": null, "kinds": {}
        });
        assert_eq!(json, empty);
        assert_eq!(none.to_string(), "no effective hitting points");
    }
}
