//! Measures how a character wears motion: how far its skin is stretched, where its soles are, and what is below the ground.

use super::{Wearer, figure::FigureSkin, moved_joints::ScaledWearer};
use crate::export::Take;
use glam::{Quat, Vec3};
use std::{collections::BTreeSet, io};
use throng_base::thresholds::FOOT_PLANTED_MPS;
use throng_core::skeleton::{ARMS, LEGS};
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Skeleton};

/// Most characters, and frames of each, that are measured.
const MAX_ACTORS: usize = 4;
const MAX_FRAMES: usize = 40;
/// Most edges, and most corners of feet and of all the body, that are measured.
const MAX_PARTS: usize = 40_000;
/// Growth of an edge above which skin is torn (m).
const TORN_M: f32 = 0.5;
/// Growth of an edge above which it is torn if it is so many times as long then (m, 1), and the share of such edges that is
/// no accident.
const PULLED: (f32, f32) = (0.1, 3.0);
const MOST_PULLED: f32 = 0.004;
/// Depth of soles in the ground, and height over it, above which feet do not stand on it (median, m).
const SUNK_M: f32 = 0.03;
const FLOATING_M: f32 = 0.06;
/// Depth of any part below the ground above which a body is sunk (median of the frames, m).
const BURIED_M: f32 = 0.15;
/// Share of the length of the legs above which soles are no soles.
const HIGHEST_SOLE: f32 = 0.4;
/// Reach of the skin around the end of a limb (lengths of the legs), and change of its distance from there, median, above
/// which it is not that limb's (m).
const END_REACH: f32 = 0.3;
const LEFT_BEHIND_M: f32 = 0.12;
/// Foot and toe of both sides.
const FEET: [[Joint; 2]; 2] = [[Joint::LeftFoot, Joint::LeftToe], [Joint::RightFoot, Joint::RightToe]];

/// How a character wears motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WornFit {
    /// Height of the character as it is written (m).
    pub height_m: f32,
    /// Largest growth of an edge of its skin (m).
    pub stretch_m: f32,
    /// Share of the edges that are pulled apart in the worst frame.
    pub pulled_share: f32,
    /// Names of the joints that move the ends of this edge, and the frame.
    pub stretched: ([String; 2], usize),
    /// Largest change of the distance between the end of a limb and the skin around it, median of that skin (m).
    pub left_behind_m: f32,
    /// Names of the joint at that end, and of the one that moves the skin, and the frame.
    pub left_behind: ([String; 2], usize),
    /// Height of soles over the ground where feet stand, median; below 0 they sink in (m).
    pub soles_m: f32,
    /// Largest distance of soles from the ground where feet stand, 95th percentile (m).
    pub soles_off_m: f32,
    /// Depth of the lowest part of the body below the ground, median of the frames (m).
    pub buried_m: f32,
}

impl WornFit {
    /// The reason why nobody would take the result for a person, and the way out.
    pub fn fault(&self) -> Option<String> {
        let profile = "check the roles with `throng inspect`, and name them in a profile (--profile)";
        let cm = |m: f32| 100.0 * m.abs();
        if self.stretch_m > TORN_M || self.pulled_share > MOST_PULLED {
            let ([a, b], frame) = &self.stretched;
            let stretch = self.stretch_m;
            return Some(format!(
                "its skin is torn: in frame {frame} it is stretched by {stretch:.2} m between what `{a}` and `{b}` move; \
                 hang the joints that carry skin below one another, as a body does, or {profile}"
            ));
        }
        if self.left_behind_m > LEFT_BEHIND_M {
            let ([end, carrier], frame) = &self.left_behind;
            return Some(format!(
                "the skin around `{end}` is moved by `{carrier}` and comes off, by {:.2} m in frame {frame}; weight it to \
                 `{end}`, or to what hangs below that, or {profile}",
                self.left_behind_m
            ));
        }
        if self.soles_m < -SUNK_M || self.soles_m > FLOATING_M {
            let side = if self.soles_m < 0.0 { "below" } else { "above" };
            let off = cm(self.soles_m);
            return Some(format!("its soles are {off:.1} cm {side} the ground where its feet stand; {profile}"));
        }
        let what = "has parts that hang below its feet; leave them out of the file";
        (self.buried_m > BURIED_M).then(|| format!("it {what}: {:.1} cm deep in the ground", cm(self.buried_m)))
    }
}

/// A character that stands in a T-pose on the ground of its own skeleton.
pub struct WornStance {
    /// Height (m).
    pub height_m: f32,
    /// Height of its soles over the ground (m).
    pub soles_m: f32,
}

/// Measures a character in a T-pose; `None` where no skin hangs on its feet.
pub fn measure_stance(wearer: &Wearer, skin: &FigureSkin) -> Option<WornStance> {
    let own = &wearer.fit.skeleton;
    let mut matrices = vec![Mat3x4::default(); skin.surface.frames.len()];
    let pose = own.rest_positions().map(|p| (p, Quat::IDENTITY));
    skin.pose_matrices(&ScaledWearer::with_growth(wearer, own, 1.0), &pose, &mut matrices);
    let parts = MeasuredParts::new(wearer, skin);
    let lowest = |corners: &[u32]| corners.iter().map(|&c| skin.corner(&matrices, c).y).min_by(f32::total_cmp);
    let soles_m = 0.5 * (lowest(&parts.feet[0])? + lowest(&parts.feet[1])?);
    let top = parts.body.iter().map(|&c| skin.corner(&matrices, c).y).max_by(f32::total_cmp)?;
    (soles_m.abs() < HIGHEST_SOLE * own.leg_length()).then_some(WornStance { height_m: top - soles_m, soles_m })
}

/// Edges and corners that are measured.
struct MeasuredParts {
    edges: Vec<[u32; 2]>,
    /// Corners that the left, and the right foot move.
    feet: [Vec<u32>; 2],
    body: Vec<u32>,
}

impl MeasuredParts {
    fn new(wearer: &Wearer, skin: &FigureSkin) -> Self {
        let (surface, carriers) = (&skin.surface, skin.carriers(wearer));
        let thinned = |all: Vec<u32>| {
            let step = all.len().div_ceil(MAX_PARTS).max(1);
            all.into_iter().step_by(step).collect::<Vec<u32>>()
        };
        let triangles = surface.indices.chunks_exact(3).step_by((surface.indices.len() / 3).div_ceil(MAX_PARTS).max(1));
        let edges = triangles.flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
        let drawn: BTreeSet<u32> = surface.indices.iter().copied().collect();
        let moved_by = |c: u32| carriers[usize::from(surface.corners[c as usize].frames[0])];
        let of_foot =
            |foot: [Joint; 2]| thinned(drawn.iter().copied().filter(|&c| foot.contains(&moved_by(c))).collect());
        Self { edges: edges.collect(), feet: FEET.map(of_foot), body: thinned(drawn.iter().copied().collect()) }
    }
}

/// The end of a limb, and the skin around it.
struct LimbEnd<'a> {
    name: &'a str,
    /// Index of its joint among the nodes.
    node: usize,
    /// Corners, and the distance of each from the joint at rest (m).
    corners: Vec<(u32, f32)>,
}

/// Finds the ends of limbs, and the corners beyond each of them to which no other joint with a role is nearer.
fn find_limb_ends<'a>(
    wearer: &'a Wearer,
    skin: &FigureSkin,
    parts: &MeasuredParts,
    sized: &ScaledWearer<'_>,
) -> Vec<LimbEnd<'a>> {
    let (placed, matrices) = (skin.place_nodes(sized.scale as f32, None), skin.rest_matrices(sized.scale as f32));
    let place = |j: Joint| skin.place_of(wearer.rig.joints[wearer.roles.get(j)?]);
    let at = |j: Joint| place(j).map(|n| Vec3::from(placed[n].translation));
    let reach = END_REACH * sized.own.leg_length();
    let end = |[end, before]: [Joint; 2]| {
        let (node, from, before) = (place(end)?, at(end)?, at(before)?);
        let others: Vec<Vec3> =
            Joint::ALL.into_iter().filter(|&j| j != end && j.parent() != Some(end)).filter_map(at).collect();
        let around = |&c: &u32| {
            let (corner, length) = (skin.corner(&matrices, c), skin.corner(&matrices, c).distance(from));
            let is_beyond = (corner - from).dot(from - before) > 0.0;
            let is_nearest = || others.iter().all(|o| corner.distance(*o) > length);
            (length < reach && is_beyond && is_nearest()).then_some((c, length))
        };
        let corners: Vec<(u32, f32)> = parts.body.iter().filter_map(around).collect();
        let name = &wearer.rig.clip.clip.joints[wearer.roles.get(end)?].name;
        (!corners.is_empty()).then_some(LimbEnd { name, node, corners })
    };
    let limbs =
        LEGS.map(|[_, shin, foot, _]| [foot, shin]).into_iter().chain(ARMS.map(|[_, elbow, hand]| [hand, elbow]));
    limbs.chain([[Joint::Head, Joint::Neck]]).filter_map(end).collect()
}

/// Measures a character in some frames of some characters of a take.
///
/// # Errors
/// Errors of the disk.
pub fn measure(wearer: &Wearer, skin: &FigureSkin, take: &Take) -> io::Result<WornFit> {
    let parts = MeasuredParts::new(wearer, skin);
    let (mut soles, mut depths) = (Vec::new(), Vec::new());
    let mut fit = WornFit::default();
    let num_actors = take.actors().len();
    for actor in (0..num_actors).step_by(num_actors.div_ceil(MAX_ACTORS).max(1)) {
        let own = &take.actors()[actor].skeleton;
        let sized = ScaledWearer::new(wearer, own);
        fit.height_m = fit.height_m.max(wearer.height_m * (sized.scale / wearer.metres_per_unit) as f32);
        let rest = skin.rest_matrices(sized.scale as f32);
        let ends = find_limb_ends(wearer, skin, &parts, &sized);
        let lengths: Vec<f32> =
            parts.edges.iter().map(|e| skin.corner(&rest, e[0]).distance(skin.corner(&rest, e[1]))).collect();
        let mut matrices = rest;
        let step = take.num_frames(actor).div_ceil(MAX_FRAMES).max(1);
        let mut before: Option<[(Vec3, Quat); NUM_JOINTS]> = None;
        take.poses(actor, |frame, pose, is_there| {
            let pose = pose.world_transforms();
            let is_measured = frame % step == step / 2 && is_there;
            let then = before.replace(pose);
            let (true, Some(then)) = (is_measured, then) else { return Ok(()) };
            let placed = skin.pose_nodes(&sized, &pose);
            skin.place_frames(&placed, &mut matrices);
            for end in &ends {
                let joint = Vec3::from(placed[end.node].translation);
                let grown = |&(c, length): &(u32, f32)| ((skin.corner(&matrices, c).distance(joint) - length).abs(), c);
                let mut grown: Vec<(f32, u32)> = end.corners.iter().map(grown).collect();
                grown.sort_by(|a, b| a.0.total_cmp(&b.0));
                let carrier = grown.last().map_or("", |farthest| skin.carrier_name(wearer, farthest.1));
                if grown[grown.len() / 2].0 > fit.left_behind_m {
                    fit.left_behind_m = grown[grown.len() / 2].0;
                    fit.left_behind = ([end.name, carrier].map(str::to_owned), frame);
                }
            }
            let mut pulled = 0;
            for (edge, length) in parts.edges.iter().zip(&lengths) {
                let grown = skin.corner(&matrices, edge[0]).distance(skin.corner(&matrices, edge[1])) - length;
                if grown > fit.stretch_m || grown.is_nan() {
                    fit.stretch_m = grown;
                    fit.stretched = (edge.map(|c| skin.carrier_name(wearer, c).to_owned()), frame);
                }
                pulled += usize::from(grown > PULLED.0 && grown + length > PULLED.1 * length);
            }
            fit.pulled_share = fit.pulled_share.max(pulled as f32 / parts.edges.len().max(1) as f32);
            let lowest = |corners: &[u32]| corners.iter().map(|&c| skin.corner(&matrices, c).y).min_by(f32::total_cmp);
            let ground = FEET.map(|foot| ground_under(own, foot, &pose));
            for side in 0..2 {
                let speed = |j: Joint| pose[j.index()].0.distance(then[j.index()].0) * take.rate_hz() as f32;
                let stands = FEET[side].iter().all(|&j| speed(j) < FOOT_PLANTED_MPS);
                soles.extend(lowest(&parts.feet[side]).filter(|_| stands).map(|y| y - ground[side]));
            }
            depths.extend(lowest(&parts.body).map(|y| (ground[0].min(ground[1]) - y).max(0.0)));
            Ok(())
        })?;
    }
    let off = soles.iter().map(|s| s.abs()).collect();
    (fit.soles_m, fit.soles_off_m) = (percentile(soles, 0.5), percentile(off, 0.95));
    Ok(WornFit { buried_m: percentile(depths, 0.5), ..fit })
}

/// Height of the ground under a foot of the motion that stands there (m).
fn ground_under(own: &Skeleton, foot: [Joint; 2], pose: &[(Vec3, Quat); NUM_JOINTS]) -> f32 {
    let rest = own.rest_positions();
    foot.map(|j| pose[j.index()].0.y - rest[j.index()].y).into_iter().fold(f32::INFINITY, f32::min)
}

/// The value below which a share of all is; 0 of none.
fn percentile(mut all: Vec<f32>, share: f32) -> f32 {
    all.sort_by(f32::total_cmp);
    all.get((share * all.len().saturating_sub(1) as f32).round() as usize).copied().unwrap_or(0.0)
}
