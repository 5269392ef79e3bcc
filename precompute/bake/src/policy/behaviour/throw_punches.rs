//! Effective hits on a target in space: punches, kicks, and tagged kinds (Lee and Lee 2004, equations 2 and 6).

use super::super::config::{BehaviourKind, KernelConfig, PolicyBehaviourConfig, RewardForm};
use super::{super::model::SegmentMotion, BehaviourSpec, PolicyBehaviour, joint_named};
use crate::{graph::RawMotionGraph, stages::stage_error};
use glam::Vec3;
use throng_core::Joint;
use throng_core::policy::{RegionRecord, SegmentRecord, TargetGrid};
use throng_motion::{BuildError, ClipHit, ClipSet, Result};

/// An effective hit within a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentHit {
    /// Frame within the segment (1 to num_frames).
    pub frame: u32,
    /// Name of its kind.
    pub kind: String,
    /// The joint that strikes.
    pub joint: Joint,
    /// Place in the frame of the segment's start; Y above the ground (m).
    pub place: Vec3,
    /// Place in the frame of the hit itself (m).
    pub own_place: Vec3,
    /// Force of the hit (> 0, <= 1).
    pub force: f32,
}

/// Effective hits of every segment, after its first frame and up to its last (num_segments).
pub fn segment_hits(clips: &ClipSet, graph: &RawMotionGraph) -> Vec<Vec<SegmentHit>> {
    let starts = clips.frame_starts();
    let of_segment = |s: &crate::graph::GraphSegment| {
        let clip = starts.partition_point(|&f| f <= s.start.0) - 1;
        let first = (s.start.0 - starts[clip]) as usize;
        let clip = &clips.clips[clip];
        let root = clip.planar(first);
        let within = clip.hits.iter().filter(|h| h.frame > first && h.frame <= first + s.num_frames as usize);
        let hit = |h: &ClipHit| {
            let at = root.to_local(clip.planar(h.frame));
            SegmentHit {
                frame: (h.frame - first) as u32,
                kind: h.kind.name().to_owned(),
                joint: h.joint,
                place: at.translation() + at.rotation() * h.position,
                own_place: h.position,
                force: h.force,
            }
        };
        within.map(hit).collect()
    };
    graph.segments.iter().map(of_segment).collect()
}

/// Behaviour of throwing blows that land on the target.
///
/// An action's reward is the largest of `discount^t * force * I` over its effective hits, or their sum, with I = 1 -
/// distance / scale for a hit within `scale` of the target, else 0. In Lee and Lee (2004, equations 2 and 6) I is 1
/// within `scale` (`kernel = "within"`); with few blows, values interpolated between cells then promise rewards that no
/// hit gives. An action keeps its two strongest hits.
///
/// Lee and Lee activate the behaviour in the bounding volume of the hits only. Here its region is wider by `REACH_OUT`,
/// so that a target which leaves the volume for a moment still counts.
#[derive(Clone, Debug)]
pub struct ThrowPunches {
    config: PolicyBehaviourConfig,
    /// Properties, without the name.
    spec: BehaviourSpec<'static>,
    /// Weight and position of the two strongest hits of each segment.
    blows: Vec<[(f32, Vec3); 2]>,
    /// Least and greatest (angle, distance, height) of all hits.
    reach: [Vec3; 2],
}

impl ThrowPunches {
    /// - `rate_hz`: of the database (Hz, > 0).
    /// - `hits`: of every segment, see [`segment_hits`] (num_segments).
    ///
    /// # Errors
    /// [`BuildError::Key`] names the key out of its range, or the one that leaves no hit.
    pub fn new(config: &PolicyBehaviourConfig, rate_hz: f64, hits: &[Vec<SegmentHit>]) -> Result<Self> {
        let c = config;
        debug_assert_eq!(c.kind, BehaviourKind::ThrowPunches);
        c.check()?;
        let form = c.reward.unwrap_or(RewardForm::Max);
        if form == RewardForm::Integral {
            return Err(BuildError::key("reward", "the kind `throw_punches` has `max` and `sum`"));
        }
        let named = |name: &String| joint_named("joints", name, "`left_hand`, `right_foot`");
        let joints: Vec<Joint> = c.joints.iter().map(named).collect::<Result<_>>()?;
        let counts = |h: &&SegmentHit| {
            (c.hits.is_empty() || c.hits.contains(&h.kind)) && (joints.is_empty() || joints.contains(&h.joint))
        };
        let discount = c.discount_at(rate_hz);
        let strongest = |hits: &Vec<SegmentHit>| {
            let mut all: Vec<(f32, Vec3)> =
                hits.iter().filter(counts).map(|h| (h.force * discount.powi(h.frame as i32) as f32, h.place)).collect();
            all.sort_by(|a, b| b.0.total_cmp(&a.0));
            [0, 1].map(|k| all.get(k).copied().unwrap_or_default())
        };
        let reach = bounds_of_hits(hits.iter().flatten().filter(counts)).ok_or_else(|| nothing_counts(hits))?;
        let (reward, costs) = c.make_reward(form, KernelConfig::Linear, SCALE, 1.0)?;
        let scale = reward.record().scale;
        let grid = c.grid.make_cylinder(widen_volume(reach, CELLS[0] * scale), CELLS[1] * scale)?;
        let above = if c.grid.bounds.height_m.is_some() { 0.0 } else { scale };
        let region = c.region.make_region(false, region_of(&grid, reach, above))?;
        let spec = BehaviourSpec::new("", grid, reward, discount);
        let spec = BehaviourSpec { region, costs, adaptive: c.grid.adaptive, ..spec };
        Ok(Self { config: config.clone(), spec, blows: hits.iter().map(strongest).collect(), reach })
    }
}

/// Default `scale`: distance of a hit from the target beyond which it has no reward (m).
pub(super) const SCALE: f64 = 0.3;

/// Distance of the outermost cells of the grid beyond the hits over ground, and between its layers, which lie at the heights of
/// hits, as shares of `scale`. Cells farther away or apart promise what no blow gives between them.
const CELLS: [f32; 2] = [0.5, 0.4];
/// Extent of the active region beyond the grid (m).
const REACH_OUT: f32 = 1.0;

/// Bounding volume of hits, each in the character's frame at that moment: (angle, distance, height).
fn bounds_of_hits<'a>(hits: impl Iterator<Item = &'a SegmentHit>) -> Option<[Vec3; 2]> {
    let coordinates = |h: &SegmentHit| {
        let p = h.own_place;
        Vec3::new(p.x.atan2(p.z), p.x.hypot(p.z), p.y)
    };
    hits.map(coordinates)
        .fold(None, |bounds: Option<[Vec3; 2]>, p| Some(bounds.map_or([p, p], |[low, high]| [low.min(p), high.max(p)])))
}

fn nothing_counts(hits: &[Vec<SegmentHit>]) -> BuildError {
    let total = hits.iter().flatten().count();
    if total == 0 {
        let why = "the motion graph plays no effective hit. Add clips with punches or kicks, lower the thresholds in \
                   `annotate.hits`, mark hits in sidecar files, or leave this behaviour out";
        return BuildError::key("kind", why);
    }
    let mut kinds: Vec<&str> = hits.iter().flatten().map(|h| h.kind.as_str()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let found = kinds.join(", ");
    let why = format!("none of the {total} effective hits is of these kinds and joints; there are {found}");
    BuildError::key("hits", why)
}

/// Volume widened in every direction over ground, so that its cells include hits slightly outside.
fn widen_volume([low, high]: [Vec3; 2], by: f32) -> [Vec3; 2] {
    /// Largest angle that is added (rad).
    const WIDEST: f32 = 0.5;
    let angle = (by / (0.5 * (low.y + high.y)).max(by)).min(WIDEST);
    let by = Vec3::new(angle, by, 0.0);
    [low - by, high + by]
}

/// Active region: all around, up to [`REACH_OUT`] beyond the grid, at its heights and `above` and below them; for a single
/// height, at those of the hits (m).
fn region_of(grid: &TargetGrid, reach: [Vec3; 2], above: f32) -> RegionRecord {
    let [first, last] = [0, grid.num_cells() - 1].map(|cell| grid.cell_coordinates(cell));
    RegionRecord {
        distance: [0.0, last.y + REACH_OUT],
        height: if last.z > first.z { [first.z - above, last.z + above] } else { reach.map(|r| r.z) },
        ..RegionRecord::EVERYWHERE
    }
}

impl PolicyBehaviour for ThrowPunches {
    fn spec(&self) -> BehaviourSpec<'_> {
        BehaviourSpec { name: &self.config.name, ..self.spec }
    }

    fn sample(&self, segment: usize, _: &SegmentMotion, record: &mut SegmentRecord) {
        for (k, (weight, place)) in self.blows[segment].into_iter().enumerate() {
            (record.inner[2 * k], record.inner[2 * k + 1], record.heights[k]) = (place.x, place.z, place.y);
            record.weights[1 + k] = weight;
        }
    }

    fn check_values(&self, values: &[f32]) -> Result<()> {
        if values.iter().any(|&v| v != 0.0) {
            return Ok(());
        }
        let [low, high] = self.reach;
        let grid = &self.spec.grid;
        let (first, last) = (grid.cell_coordinates(0), grid.cell_coordinates(grid.num_cells() - 1));
        let volume = |a: Vec3, b: Vec3| {
            format!("{:.2} to {:.2} rad, {:.2} to {:.2} m, {:.2} to {:.2} m high", a.x, b.x, a.y, b.y, a.z, b.z)
        };
        let (name, covered, hits) = (&self.config.name, volume(first, last), volume(low, high));
        let message = format!(
            "behaviour \"{name}\": no hit comes near any cell of its grid. The grid covers {covered}; hits land at {hits}"
        );
        Err(stage_error("policy", message, "Change `grid.bounds` so that it covers the hits, or raise `scale`."))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_core::Planar;

    fn hit(frame: u32, place: Vec3, force: f32) -> SegmentHit {
        SegmentHit { frame, kind: "punch".into(), joint: Joint::LeftHand, place, own_place: place, force }
    }

    fn config() -> PolicyBehaviourConfig {
        PolicyBehaviourConfig {
            name: "p".into(),
            kind: BehaviourKind::ThrowPunches,
            ..PolicyBehaviourConfig::default()
        }
    }

    #[test]
    fn keeps_the_two_strongest_hits_discounted() {
        let hits = [vec![
            hit(2, Vec3::new(0.0, 1.4, 0.6), 0.5),
            hit(6, Vec3::new(0.2, 1.5, 0.8), 1.0),
            hit(9, Vec3::new(0.3, 1.2, 1.0), 0.9),
        ]];
        let b = ThrowPunches::new(&config(), 30.0, &hits).expect("a valid behaviour");
        let motion =
            SegmentMotion { end: 0, num_frames: 9, displacement: Planar::IDENTITY, path: vec![Planar::IDENTITY; 10] };
        let r = super::super::segment_records(&b, &[motion])[0];
        let weight = |force: f32, frame: i32| force * 0.985f64.powi(frame) as f32;
        assert_eq!(r.weights, [0.0, weight(1.0, 6), weight(0.9, 9), 0.0]);
        assert_eq!((r.inner, r.heights), ([0.2, 0.8, 0.3, 1.0], [1.5, 1.2]));
        // The region covers all three and what is around them.
        let region = b.spec().region;
        assert!(hits[0].iter().all(|h| region.contains(h.place)), "{region:?}");
        for (place, inside) in
            [((0.0, 1.4, -0.4), true), ((0.0, 1.7, 1.9), true), ((0.0, 1.9, 0.7), false), ((0.0, 1.4, 2.6), false)]
        {
            assert_eq!(region.contains(place.into()), inside, "{place:?}");
        }
        // Layers are where some blow lands.
        let layers = [0, b.spec.grid.num_cells() - 1].map(|cell| b.spec.grid.cell_coordinates(cell).z);
        assert!((layers[0] - 1.2).abs() < 1e-3 && (layers[1] - 1.5).abs() < 1e-3, "{layers:?}");
        // With one height, heights are those of the hits all the same.
        let mut flat = config();
        flat.grid.heights = Some(1);
        let flat = ThrowPunches::new(&flat, 30.0, &hits).expect("a valid behaviour");
        assert_eq!(flat.spec.region.height, [1.2, 1.5]);
    }

    #[test]
    fn says_what_to_change_where_nothing_can_be_hit() {
        let message = |c: &PolicyBehaviourConfig, hits: &[Vec<SegmentHit>]| {
            ThrowPunches::new(c, 30.0, hits).expect_err("no hits").to_string()
        };
        assert!(message(&config(), &[vec![]]).contains("annotate.hits"));
        let hits = [vec![hit(3, Vec3::new(0.0, 1.4, 0.6), 1.0)]];
        let kicks = PolicyBehaviourConfig { hits: vec!["kick".into()], ..config() };
        assert!(message(&kicks, &hits).contains("there are punch"));
        let joints = PolicyBehaviourConfig { joints: vec!["tail".into()], ..config() };
        assert!(message(&joints, &hits).contains("`tail`"));
        let mut far = config();
        far.grid.bounds.distance_m = Some([5.0, 6.0]);
        let b = ThrowPunches::new(&far, 30.0, &hits).expect("a valid grid");
        let fault = b.check_values(&[0.0; 8]).expect_err("out of reach").to_string();
        assert!(fault.contains("5.00 to 6.00 m") && fault.contains("grid.bounds"), "{fault}");
        assert!(b.check_values(&[0.0, 0.1]).is_ok());
    }
}
