//! The body that a pose is for: lengths of limbs and points of the feet, of the database skeleton or of another size.

use super::lanes::{Lane, Lane3, set_lane};
pub(crate) use crate::skeleton::{ARMS, LEGS};
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use glam::Vec3;
use throng_base::simd::LANES;

/// A leg of eight characters (m).
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneLeg {
    /// Thigh, shin.
    pub lengths: [Lane; 2],
    /// Added to the examples' ankle after scaling, for wider hips and higher ankles.
    pub ankle: Lane3,
    /// Bottom of the heel, and the ball (the toe joint), from the ankle in the foot's frame.
    pub heel: Lane3,
    pub ball: Lane3,
    /// Height of the ball over the ground on a flat foot.
    pub thickness: Lane,
    /// Bottom of the toe's tip from the toe joint, in its frame.
    pub tip: Lane3,
}

/// The bodies of eight characters, relative to the database skeleton.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneBody {
    /// Offset of every joint from its parent (m).
    pub offsets: [Lane3; NUM_JOINTS],
    /// Length of the legs over those of the database skeleton.
    pub scale: Lane,
    /// Square root of the scale: the scale of speeds and times.
    pub pace: Lane,
    /// Added to the examples' height of the hips after scaling (m).
    pub lift: Lane,
    /// Left, right.
    pub legs: [LaneLeg; 2],
    /// Upper arm and forearm of both sides (m).
    pub arms: [[Lane; 2]; 2],
    /// Length of the arms over those of the database skeleton.
    pub arm_scale: Lane,
    /// Middle of the head, in the head joint's frame (m).
    pub head_centre: Lane3,
}

impl LaneBody {
    const ZERO: Self = {
        let (lane, lane3) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let leg = LaneLeg { lengths: [lane; 2], ankle: lane3, heel: lane3, ball: lane3, thickness: lane, tip: lane3 };
        Self {
            offsets: [lane3; NUM_JOINTS],
            scale: lane,
            pace: lane,
            lift: lane,
            legs: [leg; 2],
            arms: [[lane; 2]; 2],
            arm_scale: lane,
            head_centre: lane3,
        }
    };

    /// One body in all lanes.
    pub fn from_skeleton(body: &Skeleton) -> Self {
        let mut out = Self::ZERO;
        (0..LANES).for_each(|lane| out.set_body(lane, body, body));
        out
    }

    /// Writes a body into one lane.
    pub fn set_body(&mut self, lane: usize, body: &Skeleton, database: &Skeleton) {
        let [scale, lift] = body.hips_over(database);
        for (offset, &v) in self.offsets.iter_mut().zip(&body.offsets) {
            set_lane(offset, lane, v);
        }
        self.scale[lane] = scale;
        self.pace[lane] = scale.sqrt();
        self.lift[lane] = lift;
        for (side, leg) in self.legs.iter_mut().enumerate() {
            leg.set_leg(lane, side, scale, body, database);
        }
        let length = |s: &Skeleton, j: Joint| s.offsets[j.index()].length();
        for (arm, [_, forearm, hand]) in self.arms.iter_mut().zip(ARMS) {
            arm[0][lane] = length(body, forearm);
            arm[1][lane] = length(body, hand);
        }
        let arms = |s: &Skeleton| ARMS.iter().map(|a| length(s, a[1]) + length(s, a[2])).sum::<f32>();
        self.arm_scale[lane] = arms(body) / arms(database).max(1e-3);
        set_lane(&mut self.head_centre, lane, head_centre(body));
    }
}

impl LaneLeg {
    fn set_leg(&mut self, lane: usize, side: usize, scale: f32, body: &Skeleton, database: &Skeleton) {
        let [thigh, shin, foot, toe] = LEGS[side].map(Joint::index);
        let (rest, from) = (body.rest_positions(), database.rest_positions());
        self.lengths[0][lane] = body.offsets[shin].length();
        self.lengths[1][lane] = body.offsets[foot].length();
        let wider = body.offsets[thigh].x - scale * database.offsets[thigh].x;
        set_lane(&mut self.ankle, lane, Vec3::new(wider, rest[foot].y - scale * from[foot].y, 0.0));
        set_lane(&mut self.heel, lane, body.heels()[side]);
        set_lane(&mut self.ball, lane, body.offsets[toe]);
        self.thickness[lane] = rest[toe].y;
        let tip = body.tips[1 + side];
        set_lane(&mut self.tip, lane, Vec3::new(tip.x, tip.y - rest[toe].y, tip.z));
    }
}

/// Middle of the head, in the head joint's frame (m).
pub fn head_centre(skeleton: &Skeleton) -> Vec3 {
    skeleton.tips[0] * 0.5
}
