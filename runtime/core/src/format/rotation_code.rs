//! Packing of the rotations of a frame into 80 bytes.
//!
//! Each joint has a field of bits with a number of steps above a lowest value for each of x, y and z of its quaternion,
//! relative to a rotation in the middle of all that the joint does; w follows from unit length. Where no middle keeps w
//! away from zero, w is stored too. Bits go where a step moves joints most: to long bones and wide ranges. A frame is
//! encoded from the hips outwards, and each joint makes up for what its parents are off, so errors do not add up.
//! Ranges for a whole database instead of each clip (as in the animation compression library of Frechette, 2016) keep
//! sampling free of look-ups.

use super::records::{FrameRow, ROTATION_BYTES};
use crate::skeleton::{Joint, NUM_JOINTS, Skeleton};
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3};
use throng_base::maths;
use throng_base::simd::{LANES, Lanes, Q, V};

/// Bits that all joints share.
const BITS: u32 = 8 * ROTATION_BYTES as u32;
/// Most bits of a joint, so that they lie in eight bytes wherever they start.
const MOST_BITS: u32 = 57;
/// Most bits of a component.
const MOST_OF_ONE: u32 = 16;
/// w is derived where it never gets smaller.
const LEAST_W: f32 = 0.3;
/// A rotation in the middle is looked for where the identity leaves w smaller.
const WIDE_W: f32 = 0.5;
/// Neighbours on opposite sides are farther apart than rounding can bring them.
const LEAST_DOT: f32 = -0.25;
/// Curves through rows of unit length come nearer to zero than this by cancelling each other out.
const LEAST_SQUARE: f32 = 1e-12;
/// Distance that a hand, a toe or the head counts for where nothing hangs on the joint (m): small.
const TIP_M: f32 = 0.03;

/// The field of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JointCode {
    /// Unit quaternion that the coded rotation is turned by: the joint's is `centre * coded`.
    pub centre: [f32; 4],
    /// Lowest value of x, y, z and w.
    pub low: [f32; 4],
    /// Step of x, y, z and w (>= 0).
    pub step: [f32; 4],
    /// First bit of the field (0 to 640).
    pub at: u32,
    /// Bits of x, y, z and w, the lowest first (0 to 16, at most 57 together). Without bits, w is derived.
    pub bits: [u8; 4],
}

impl JointCode {
    /// True where w is stored.
    pub(crate) fn stores_w(&self) -> bool {
        self.bits[3] > 0
    }

    fn width(&self) -> u32 {
        self.bits.iter().map(|&b| u32::from(b)).sum()
    }

    /// True where all is as the fields say, with a unit centre and values of a quaternion.
    pub(crate) fn is_sound(&self) -> bool {
        let [x, y, z, w] = self.centre;
        // A w of 1 stands for the identity.
        let unit = (Quat::from_array(self.centre).length() - 1.0).abs() < 1e-3
            && (w != 1.0 || Vec3::new(x, y, z).length() < 1e-3);
        let values = self.low.iter().all(|v| v.abs() <= 1.1) && self.step.iter().all(|v| (0.0..=2.2).contains(v));
        let bits = self.bits.iter().all(|&b| u32::from(b) <= MOST_OF_ONE) && self.width() <= MOST_BITS;
        unit && values && bits && self.at <= BITS - self.width()
    }

    /// First byte that is read, and how far the field starts above its lowest bit.
    #[inline(always)]
    fn word(&self) -> (usize, u32) {
        let byte = (self.at / 8).min(ROTATION_BYTES as u32 - 8);
        (byte as usize, self.at - 8 * byte)
    }

    /// Places of x, y, z, w in eight bytes that are read.
    #[inline(always)]
    fn shifts(&self, first: u32) -> [u32; 4] {
        let [x, y, z, _] = self.bits.map(u32::from);
        [first, first + x, first + x + y, first + x + y + z]
    }

    /// Component k: the weighted sum of the values of some words. Weights add up to 1.
    #[inline(always)]
    fn value<F: Lanes, const N: usize>(&self, words: &[[u64; LANES]; N], shift: u32, weights: &[F; N], k: usize) -> F {
        let bits = u32::from(self.bits[k]);
        let mut sum = F::field(words[0], shift, bits) * weights[0];
        for i in 1..N {
            sum = sum + F::field(words[i], shift, bits) * weights[i];
        }
        F::splat(self.low[k]) + F::splat(self.step[k]) * sum
    }

    /// The coded rotation, before it is turned by the centre.
    pub(crate) fn coded(&self, row: &FrameRow) -> Quat {
        let (byte, first) = self.word();
        let (word, shifts) = (word(row, byte), self.shifts(first));
        let value = |k: usize| {
            let steps = word.checked_shr(shifts[k]).unwrap_or(0) & ((1 << self.bits[k]) - 1);
            self.low[k] + self.step[k] * steps as f32
        };
        let v = Vec3::new(value(0), value(1), value(2));
        let w = if self.stores_w() { value(3) } else { (1.0 - v.length_squared()).max(0.0).sqrt() };
        Quat::from_xyzw(v.x, v.y, v.z, w)
    }

    /// True where interpolation from one row to the next never comes near zero. A joint that turns by 180 degrees from one
    /// frame to the next may end up a little on the other side, as values are rounded.
    pub(crate) fn continues(&self, row: &FrameRow, next: &FrameRow) -> bool {
        !self.stores_w() || self.coded(row).dot(self.coded(next)) > LEAST_DOT
    }

    /// Writes a rotation into its field, as exactly as possible.
    ///
    /// - `before`: the rotation of the frame before; this one is put on the same side where w is stored.
    fn write_rotation(&self, rotation: Quat, before: Option<&FrameRow>, row: &mut FrameRow) {
        let mut coded = maths::compose(Quat::from_array(self.centre).conjugate(), rotation);
        let before = before.filter(|_| self.stores_w());
        if before.map_or(coded.w, |row| self.coded(row).dot(coded)) < 0.0 {
            coded = -coded;
        }
        let (byte, first) = self.word();
        let mut word = word(row, byte);
        for ((value, shift), k) in coded.to_array().into_iter().zip(self.shifts(first)).zip(0..) {
            let most = (1u64 << self.bits[k]) - 1;
            if self.bits[k] > 0 {
                let steps = ((value - self.low[k]) / self.step[k].max(f32::MIN_POSITIVE)).round() as u64;
                word = word & !(most << shift) | steps.min(most) << shift;
            }
        }
        row.rotations[byte..byte + 8].copy_from_slice(&word.to_le_bytes());
    }
}

/// The fields of all joints: one record of a bundle.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct RotationCode {
    /// Code of each joint (NUM_JOINTS).
    pub joints: [JointCode; NUM_JOINTS],
}

impl RotationCode {
    /// Code of the rest pose: its rotations are identities for any row.
    pub fn of_rest_pose() -> Self {
        Self::fit_frames(&Skeleton::default(), 0, |_, _| Quat::IDENTITY)
    }

    /// The code that shows some frames best.
    ///
    /// - `skeleton`: lengths of bones say how far a step moves what hangs on a joint.
    /// - `rotation`: of a frame and a joint, relative to the parent, that of the hips to the planar root (unit length).
    pub fn fit_frames(skeleton: &Skeleton, num_frames: usize, rotation: impl Fn(usize, usize) -> Quat) -> Self {
        let of_joint = |j: usize| Ok::<_, std::convert::Infallible>((0..num_frames).map(|f| rotation(f, j)).collect());
        let Ok(code) = Self::fit_joints(skeleton, of_joint);
        code
    }

    /// Fits a code as [`RotationCode::fit_frames`] does, with the rotations of no more than one joint in memory.
    ///
    /// - `of_joint`: its rotations in all frames; called once for every joint, in their order.
    ///
    /// # Errors
    /// Those of `of_joint`.
    pub fn fit_joints<E>(skeleton: &Skeleton, mut joint: impl FnMut(usize) -> Result<Vec<Quat>, E>) -> Result<Self, E> {
        let mut ranges = [(JointCode::zeroed(), 1.0); NUM_JOINTS];
        for (j, range) in ranges.iter_mut().enumerate() {
            *range = ranges_of(&joint(j)?);
        }
        let mut joints = ranges.map(|r| r.0);
        // An error of x, y and z makes one of w that is the larger, the smaller w is.
        let reach = reaches(skeleton);
        let reach: [f32; NUM_JOINTS] = std::array::from_fn(|j| reach[j] / ranges[j].1);
        let mut left = BITS;
        // The next bit goes where a step is worth the longest way.
        let way = |c: &JointCode, j: usize, k: usize| {
            let step = c.step[k] / ((1u32 << c.bits[k]) as f32);
            if c.step[k] <= 1e-6 || u32::from(c.bits[k]) >= MOST_OF_ONE { 0.0 } else { step * reach[j] }
        };
        while left > 0 {
            let all =
                (0..NUM_JOINTS).filter(|&j| joints[j].width() < MOST_BITS).flat_map(|j| (0..4).map(move |k| (j, k)));
            let worst = all.map(|(j, k)| (way(&joints[j], j, k), j, k)).max_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, j, k)) = worst.filter(|w| w.0 > 0.0) else { break };
            joints[j].bits[k] += 1;
            left -= 1;
        }
        let mut at = 0;
        for c in &mut joints {
            c.at = at;
            at += c.width();
            for k in 0..4 {
                let most = ((1u32 << c.bits[k]) - 1) as f32;
                (c.low[k], c.step[k]) =
                    if most > 0.0 { (c.low[k], c.step[k] / most) } else { (c.low[k] + 0.5 * c.step[k], 0.0) };
            }
        }
        Ok(Self { joints })
    }

    /// Packs the rotations of a frame.
    ///
    /// - `before`: the frame before it in the clip.
    /// - `row`: the row that receives the rotations.
    pub fn encode(&self, local: &[Quat; NUM_JOINTS], before: Option<&FrameRow>, row: &mut FrameRow) {
        let (mut wanted, mut shown) = (*local, *local);
        for (j, code) in self.joints.iter().enumerate() {
            let (mut target, mut above) = (local[j], Quat::IDENTITY);
            if let Some(p) = Joint::ALL[j].parent() {
                wanted[j] = maths::compose(wanted[p.index()], local[j]).normalize();
                above = shown[p.index()];
                target = maths::compose(above.conjugate(), wanted[j]);
            }
            code.write_rotation(target, before, row);
            shown[j] = maths::compose(above, self.rotation(row, j)).normalize();
        }
    }

    /// The rotation of a joint in a row: relative to its parent, that of the hips to the planar root. Unit length.
    pub fn rotation(&self, row: &FrameRow, joint: usize) -> Quat {
        let code = &self.joints[joint];
        maths::normalize_or_identity(maths::compose(Quat::from_array(code.centre), code.coded(row)))
    }

    /// The rotation of a joint between some rows of each of eight characters. Unit length.
    ///
    /// - `weights`: of the rows; they add up to 1.
    #[inline(always)]
    pub(crate) fn rotations_between<F: Lanes, const N: usize>(
        &self,
        rows: &[&[FrameRow; N]; LANES],
        weights: &[F; N],
        joint: usize,
    ) -> Q<F> {
        let code = &self.joints[joint];
        let (byte, first) = code.word();
        let mut there = [[0; LANES]; N];
        for (l, rows) in rows.iter().enumerate() {
            for (there, row) in there.iter_mut().zip(*rows) {
                there[l] = word(row, byte);
            }
        }
        let [x, y, z, w] = code.shifts(first);
        let (x, y) = (code.value(&there, x, weights, 0), code.value(&there, y, weights, 1));
        let mut v = V::new(x, y, code.value(&there, z, weights, 2));
        let coded = if code.stores_w() {
            // Of rows that cancel each other out nothing is left: the middle. Other lanes keep their bits.
            let (w, least) = (code.value(&there, w, weights, 3), F::splat(LEAST_SQUARE));
            let square = v.dot(v) + w * w;
            let w = if least.any_gt(square) { F::select_lt(square, least, F::splat(1.0), w) } else { w };
            Q::new(v, w).normalize()
        } else {
            let (one, square) = (F::splat(1.0), v.dot(v));
            // A point between two of the unit ball lies in it; a curve may swing out of it a little. Other lanes keep their bits.
            if square.any_gt(one) {
                v = V::select_lt(one, square, v * (one / square.sqrt()), v);
            }
            Q::new(v, (one - square).max(F::splat(0.0)).sqrt())
        };
        let [x, y, z, w] = code.centre;
        if w == 1.0 { coded } else { Q::new(V::splat(Vec3::new(x, y, z)), F::splat(w)) * coded }
    }

    /// The rotation of a joint in a row of each of eight characters. Unit length.
    #[inline(always)]
    pub(crate) fn of_rows<F: Lanes>(&self, rows: &[&FrameRow; LANES], joint: usize) -> Q<F> {
        let mut one = [std::array::from_ref(rows[0]); LANES];
        for (one, row) in one.iter_mut().zip(rows) {
            *one = std::array::from_ref(*row);
        }
        self.rotations_between(&one, &[F::splat(1.0)], joint)
    }
}

/// Eight bytes of a row's rotations (byte <= 72).
#[inline(always)]
fn word(row: &FrameRow, byte: usize) -> u64 {
    let bytes = row.rotations[byte..].first_chunk().unwrap_or(&[0; 8]);
    u64::from_le_bytes(*bytes)
}

/// Centre, lowest value and range of each component, as a code without bits whose steps are whole ranges; and the
/// smallest w that is derived (1 where w is stored).
fn ranges_of(rotations: &[Quat]) -> (JointCode, f32) {
    let (centre, least) = centre(rotations);
    let stores_w = least < LEAST_W;
    let (centre, least) = if stores_w { (Quat::IDENTITY, 1.0) } else { (centre, least) };
    let (mut low, mut high) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for &rotation in rotations {
        let coded = maths::compose(centre.conjugate(), rotation);
        let coded = if coded.w < 0.0 { -coded } else { coded };
        for (k, v) in coded.to_array().into_iter().enumerate() {
            (low[k], high[k]) = (low[k].min(v), high[k].max(v));
        }
    }
    if stores_w {
        // Signs follow the frame before, so either may come.
        (low, high) = ([-1.0; 4], [1.0; 4]);
    } else if rotations.is_empty() {
        (low, high) = ([0.0; 4], [0.0; 4]);
    } else {
        (low[3], high[3]) = (0.0, 0.0);
    }
    let step = std::array::from_fn(|k| high[k] - low[k]);
    (JointCode { centre: centre.to_array(), low, step, at: 0, bits: [0; 4] }, least)
}

/// A rotation in the middle of all, and the cosine of half the angle to the farthest. The identity if it will do.
fn centre(rotations: &[Quat]) -> (Quat, f32) {
    let farthest = |centre: Quat| {
        let all = rotations.iter().map(|&q| (centre.dot(q).abs(), q));
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((1.0, centre))
    };
    let (least, mut far) = farthest(Quat::IDENTITY);
    if least >= WIDE_W {
        return (Quat::IDENTITY, least);
    }
    // Towards what lies farthest, in ever shorter steps: the middle of the smallest cap around all.
    let mut best = (Quat::IDENTITY, least);
    let mut centre = Quat::IDENTITY;
    for step in 2..64 {
        let towards = if centre.dot(far) < 0.0 { -far } else { far };
        centre = (centre + towards * (1.0 / step as f32)).normalize();
        let (near, next) = farthest(centre);
        far = next;
        if near > best.1 {
            best = (centre, near);
        }
    }
    best
}

/// Largest distance of the parts that a joint turns: its longest segment (m).
fn reaches(skeleton: &Skeleton) -> [f32; NUM_JOINTS] {
    let mut reach = [TIP_M; NUM_JOINTS];
    for j in Joint::ALL {
        if let Some(p) = j.parent() {
            let bone = &mut reach[p.index()];
            *bone = bone.max(skeleton.offsets[j.index()].length());
        }
    }
    reach
}

#[cfg(test)]
mod tests;
