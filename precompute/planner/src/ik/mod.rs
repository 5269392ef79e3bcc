//! Analytic inverse kinematics of arms and legs: a place and a rotation for hand or foot, within limits and free.

mod elbow;
mod ik_error;
mod swivel;
mod swivel_limits;
#[cfg(test)]
mod tests;

use crate::limits::JointLimits;
use crate::linkage::{Chain, LIMB_JOINTS, LimbPose};
use crate::rotation::{Rigid, rotation_about, rotation_between, twist_about};
use elbow::Elbow;
use glam::{DQuat, DVec3};
pub use ik_error::IkError;
use swivel::{half_angle, search_finely};
use swivel_limits::{HALVES, LimitFit, QuickLimits, SwivelLimits, TwistBounds, widest_swing_square};
use throng_base::maths;

/// Excess below which a pose counts as within limits (rad).
const ON_LIMIT: f64 = 1e-7;

/// Excess over limits by a quick estimate above which no exact check is needed (rad).
const WELL_OUTSIDE: f64 = 0.05;
/// Excess above which no neighbouring swivel is within limits (rad).
const FAR_OUTSIDE: f64 = 0.3;

/// Solves for the seven degrees of freedom of a limb: three of shoulder or hip, flexion and twist of elbow or knee, swing of
/// wrist or ankle.
///
/// A place and a rotation are six conditions; the seventh is the swivel angle, by which the elbow turns about the line from
/// shoulder to wrist. The search begins at the present pose's swivel, and goes in growing steps to both sides until limits and
/// a predicate hold; a few products classify most swivels as inside or outside of limits. Where that finds nothing, the whole
/// circle is searched finely.
///
/// # Source
/// Tolani and Badler 1996, *Real-Time Inverse Kinematics of the Human Arm*; Shapiro, Kallmann and Faloutsos 2007, section 5.
/// Differs: the wrist need not lie on the elbow's axis, so that any proportions of the skeleton are exact, and the fine
/// search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimbIk {
    chain: Chain,
    /// Limits of shoulder, elbow and wrist.
    limits: [JointLimits; 3],
    elbow: Elbow,
    elbow_twist: TwistBounds,
    /// Quick limits of shoulder and wrist.
    quick: [QuickLimits; 2],
    /// Squares of the least cosine of half a swing, of shoulder and wrist.
    widest: [f64; 2],
}

fn unit([a, b]: [f64; 2]) -> [f64; 2] {
    let length = (a * a + b * b).sqrt();
    [a / length, b / length]
}

/// Parts of a reach that do not depend on the swivel.
struct ReachGeometry {
    /// Direction from shoulder to wrist, in the base's frame (unit).
    line: DVec3,
    /// Rotation that takes the folded arm onto that line.
    onto: DQuat,
    /// Flexion of the elbow, and its rotation.
    flexion: f64,
    bent: DQuat,
    /// Wanted rotation of the hand in the base's frame.
    hand: DQuat,
}

/// Swivel at which the search begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Swivel {
    /// The present pose's swivel.
    Present,
    /// Halfway from the present swivel to the elbow's lowest, as arms hang.
    Low {
        /// Downwards in the frame of the joint that carries the upper arm (unit).
        down: DVec3,
    },
}

/// A pose, and the joint that is farthest outside its limits.
#[derive(Clone, Copy)]
struct SwivelPose {
    pose: [DQuat; 3],
    excess: f64,
    joint: usize,
}

impl LimbIk {
    /// Prepares for a chain and the limits of its joints.
    ///
    /// # Panics
    /// If the second last joint is not a hinge: [`crate::limits::BodyLimits::limb_limits`] gives limits that fit.
    pub fn new(chain: &Chain, limits: &[JointLimits; LIMB_JOINTS]) -> Self {
        let elbow = Elbow::new(chain.offsets[1], chain.offsets[2], &limits[1]).expect("elbows and knees have flexion");
        let elbow_twist = TwistBounds::new(&limits[1], limits[1].mirrored);
        let quick = [QuickLimits::new(&limits[0]), QuickLimits::new(&limits[2])];
        let widest = [widest_swing_square(&limits[0], None), widest_swing_square(&limits[2], Some(elbow.along))];
        Self { chain: *chain, limits: *limits, elbow, elbow_twist, quick, widest }
    }

    /// Poses the limb so that hand or foot is at `goal`.
    ///
    /// - `base`: world transform of the joint that carries the chain.
    /// - `goal`: world transform wanted for the last joint.
    /// - `present`, `from`: where the search over swivels begins.
    /// - `blocked`: the obstacle of a pose, if it collides.
    ///
    /// # Errors
    /// [`IkError`]: distance out of reach, excess over which joint's limits at the best swivel, or the obstacle of the first
    /// swivel within limits.
    pub fn solve<B>(
        &self,
        base: &Rigid,
        goal: &Rigid,
        present: &LimbPose,
        from: Swivel,
        mut blocked: impl FnMut(&LimbPose) -> Option<B>,
    ) -> Result<LimbPose, IkError<B>> {
        let reach = self.reach_geometry(&base.to_local(*goal)).map_err(|by_m| IkError::OutOfReach { by_m })?;
        let [c, s] = self.first_swivel(&reach, present.0[0], from);
        // The swivel with the least excess over limits.
        let mut best = (f64::INFINITY, [c, s]);
        let mut in_the_way = None;
        // Within limits: is it free?
        let mut free = |turns: &[DQuat; 3]| {
            let pose = LimbPose(*turns);
            let Some(by) = blocked(&pose) else { return Some(pose) };
            in_the_way.get_or_insert(by);
            None
        };
        let exactly = |half: [f64; 2]| {
            let tried = self.pose_at_half_swivel(&reach, half);
            (tried.excess, (tried.excess <= ON_LIMIT).then_some(tried.pose))
        };
        let swivels = SwivelLimits::new(self, &reach);
        let from_present = |[cos, sin]: [f64; 2]| [c * cos - s * sin, s * cos + c * sin];
        for offset in HALVES.iter() {
            let half = from_present(*offset);
            let turns = match swivels.check_swivel(half) {
                (LimitFit::Outside, _) => None,
                (LimitFit::Inside, turns) => Some(turns),
                (LimitFit::OnEdge, _) => exactly(half).1,
            };
            if let Some(pose) = turns.and_then(|t| free(&t)) {
                return Ok(pose);
            }
        }
        let found = search_finely(|offset| {
            let half = from_present(offset);
            let about = swivels.excess(half, f64::max(best.0, FAR_OUTSIDE));
            let (excess, turns) = if about > WELL_OUTSIDE { (about, None) } else { exactly(half) };
            if excess < best.0 {
                best = (excess, half);
            }
            (excess, turns.and_then(|t| free(&t)))
        });
        if let Some(pose) = found {
            return Ok(pose);
        }
        Err(match in_the_way {
            Some(by) => IkError::Blocked { by },
            None => {
                let nearest = self.pose_at_half_swivel(&reach, best.1);
                let joint = self.chain.limb.joints()[nearest.joint];
                IkError::OutOfLimits { joint, by_rad: nearest.excess.max(0.0) }
            }
        })
    }

    /// The pose with a given swivel, if it is within reach and limits.
    ///
    /// - `swivel`: as [`LimbIk::swivel_of`] defines it (rad).
    pub(crate) fn solve_at_swivel(&self, base: &Rigid, goal: &Rigid, swivel: f64) -> Option<LimbPose> {
        let tried = self.pose_at_half_swivel(&self.reach_geometry(&base.to_local(*goal)).ok()?, half_angle(swivel));
        (tried.excess <= ON_LIMIT).then_some(LimbPose(tried.pose))
    }

    /// The swivel of a pose on its path to a goal: it changes evenly where the pose moves evenly (rad).
    pub(crate) fn swivel_of(&self, base: &Rigid, goal: &Rigid, pose: &LimbPose) -> Option<f64> {
        let reach = self.reach_geometry(&base.to_local(*goal)).ok()?;
        let [cos, sin] = self.first_swivel(&reach, pose.0[0], Swivel::Present);
        Some(2.0 * maths::atan2(sin, cos))
    }

    /// Solves as [`LimbIk::solve`] does, without obstacles.
    ///
    /// # Errors
    /// [`IkError::OutOfReach`] and [`IkError::OutOfLimits`].
    pub fn solve_free(&self, base: &Rigid, goal: &Rigid, present: &LimbPose) -> Result<LimbPose, IkError<String>> {
        self.solve(base, goal, present, Swivel::Present, |_| None)
    }

    /// Nearest and farthest distances from shoulder to wrist that the elbow allows (m).
    pub fn reach_distances(&self) -> [f64; 2] {
        self.elbow.distances
    }

    fn reach_geometry(&self, local: &Rigid) -> Result<ReachGeometry, f64> {
        let to_wrist = local.position - self.chain.offsets[0];
        let distance = to_wrist.length();
        let flexion = self.elbow.flexion(distance)?;
        let bent = rotation_about(self.elbow.axis, flexion);
        let folded = (self.elbow.upper + bent * self.elbow.fore).normalize_or(DVec3::X);
        let line = to_wrist.try_normalize().unwrap_or(folded);
        Ok(ReachGeometry { line, onto: rotation_between(folded, line), flexion, bent, hand: local.rotation })
    }

    /// The swivel that keeps the elbow's axis as near as possible to the present pose's, or to that turned down: cosine and
    /// sine of half of it.
    fn first_swivel(&self, reach: &ReachGeometry, shoulder: DQuat, first: Swivel) -> [f64; 2] {
        let across = |v: DVec3| v - reach.line * v.dot(reach.line);
        let from = across(reach.onto * self.elbow.axis);
        let to = across(shoulder * self.elbow.axis);
        let to = match first {
            Swivel::Present => to,
            // The axis is at right angles to where the elbow points.
            Swivel::Low { down } => {
                let [folded, bent] = [reach.onto * self.elbow.upper, reach.onto * self.elbow.axis].map(across);
                let side = if folded.cross(bent).dot(reach.line) < 0.0 { -1.0 } else { 1.0 };
                to.normalize_or_zero() + reach.line.cross(across(down)) * side
            }
        };
        // Where the arm points along that axis, every swivel is equally good.
        let to = if to.length_squared() > 1e-6 { to } else { across(shoulder * self.elbow.upper) };
        let (sin, cos) = (from.cross(to).dot(reach.line), from.dot(to));
        let length = (sin * sin + cos * cos).sqrt();
        if length < 1e-12 {
            return [1.0, 0.0];
        }
        let (sin, cos) = (sin / length, cos / length);
        // The half that is not small comes first: the other one follows from it exactly.
        if cos >= 0.0 {
            let half = (0.5 * (1.0 + cos)).sqrt();
            return unit([half, 0.5 * sin / half]);
        }
        let half = (0.5 * (1.0 - cos)).sqrt().copysign(sin);
        unit([0.5 * sin / half, half])
    }

    /// - `half_angle`: cosine and sine of half the swivel.
    fn pose_at_half_swivel(&self, reach: &ReachGeometry, [cos, sin]: [f64; 2]) -> SwivelPose {
        let v = reach.line * sin;
        let shoulder = DQuat::from_xyzw(v.x, v.y, v.z, cos) * reach.onto;
        // The remainder is for twist and wrist: twist about the forearm first, then the hand's swing.
        let rest = (shoulder * reach.bent).inverse() * reach.hand;
        let twisted = twist_about(if rest.w < 0.0 { -rest } else { rest }, self.elbow.along);
        let twist = 2.0 * maths::atan2(twisted.xyz().dot(self.elbow.along), twisted.w);
        let pose = [shoulder, reach.bent * twisted, twisted.inverse() * rest];
        let excess =
            [self.limits[0].excess(pose[0]), self.elbow.excess(reach.flexion, twist), self.limits[2].excess(pose[2])];
        let joint = (0..3).max_by(|a, b| excess[*a].total_cmp(&excess[*b])).unwrap_or(0);
        SwivelPose { pose, excess: excess[joint], joint }
    }
}
