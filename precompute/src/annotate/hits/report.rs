//! How many hits there are and where they land, as the paper reports it.

use crate::clip::{Clip, ClipSet};
use glam::Vec3;
use serde::Serialize;
use std::collections::BTreeMap;
use throng_runtime::Tables;

/// Effective hitting points as seen from the planar root: number, kinds and extent. The names of the fields are keys
/// of JSON reports.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HitReport {
    /// How many there are.
    pub count: usize,
    /// Smallest and largest angle from straight ahead, positive to the left; absent where there is no hit. [Unit: rad]
    pub angle_rad: Option<[f32; 2]>,
    /// Smallest and largest distance over the ground; absent where there is no hit. [Unit: m]
    pub distance_m: Option<[f32; 2]>,
    /// Lowest and highest above the ground; absent where there is no hit. [Unit: m]
    pub height_m: Option<[f32; 2]>,
    /// How many there are of each kind.
    pub kinds: BTreeMap<String, usize>,
}

impl HitReport {
    /// Of all clips, mirrored copies included.
    pub fn of_set(set: &ClipSet) -> Self {
        set.clips.iter().flat_map(points_of_clip).collect()
    }

    /// Of one clip.
    pub fn of_clip(clip: &Clip) -> Self {
        points_of_clip(clip).collect()
    }

    /// Of a bundle.
    pub fn of_tables(tables: &Tables) -> Self {
        let kinds: Vec<&str> = tables.meta().hit_kinds().collect();
        tables.hits().iter().map(|h| (kinds[h.kind as usize], h.position())).collect()
    }
}

fn points_of_clip(clip: &Clip) -> impl Iterator<Item = (&str, Vec3)> {
    clip.hits.iter().map(|h| (h.kind.name(), h.position))
}

impl<'a> FromIterator<(&'a str, Vec3)> for HitReport {
    /// Of kinds and points as seen from the planar root.
    fn from_iter<I: IntoIterator<Item = (&'a str, Vec3)>>(points: I) -> Self {
        let mut out = Self::default();
        for (kind, p) in points {
            out.count += 1;
            *out.kinds.entry(kind.to_owned()).or_insert(0) += 1;
            widen(&mut out.angle_rad, p.x.atan2(p.z));
            widen(&mut out.distance_m, p.x.hypot(p.z));
            widen(&mut out.height_m, p.y);
        }
        out
    }
}

fn widen(range: &mut Option<[f32; 2]>, value: f32) {
    let [low, high] = range.unwrap_or([value; 2]);
    *range = Some([low.min(value), high.max(value)]);
}

impl std::fmt::Display for HitReport {
    /// In the paper's words.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (Some(angle), Some(distance), Some(height)) = (self.angle_rad, self.distance_m, self.height_m) else {
            return f.write_str("no effective hitting points");
        };
        let kinds: Vec<String> = self.kinds.iter().map(|(kind, n)| format!("{kind} {n}")).collect();
        write!(
            f,
            "{} effective hitting points ({}): angle {:.3} to {:.3} rad, distance {:.1} to {:.1} cm, \
             height {:.1} to {:.1} cm",
            self.count,
            kinds.join(", "),
            angle[0],
            angle[1],
            100.0 * distance[0],
            100.0 * distance[1],
            100.0 * height[0],
            100.0 * height[1]
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_PI_2;

    #[test]
    fn ranges_hold_every_point_and_kinds_are_counted() {
        let points = [("punch", Vec3::new(0.0, 1.4, 0.6)), ("kick", Vec3::new(-0.8, 1.0, 0.0)), ("punch", Vec3::Y)];
        let r: HitReport = points.into_iter().collect();
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
