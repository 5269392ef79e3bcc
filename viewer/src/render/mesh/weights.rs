//! Which joints move a vertex, and how much.

use throng_core::Joint;

/// Up to four joints with weights that sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence([(Joint, f32); 4]);

impl Influence {
    /// Moved by one joint alone.
    pub fn rigid(joint: Joint) -> Self {
        Self([(joint, 1.0), (joint, 0.0), (joint, 0.0), (joint, 0.0)])
    }

    /// `self` at `t = 0`, `other` at `t = 1`. If that makes more than four joints, the weakest are left out.
    pub fn mix(self, other: Self, t: f32) -> Self {
        let t = t.clamp(0.0, 1.0);
        let mut all: Vec<(Joint, f32)> = Vec::with_capacity(8);
        let scaled = |from: Self, by: f32| from.0.into_iter().map(move |(j, w)| (j, w * by));
        for (joint, weight) in scaled(self, 1.0 - t).chain(scaled(other, t)) {
            match all.iter_mut().find(|(j, _)| *j == joint) {
                Some(known) => known.1 += weight,
                None => all.push((joint, weight)),
            }
        }
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        all.truncate(4);
        let first = all[0].0;
        all.resize(4, (first, 0.0));
        let sum: f32 = all.iter().map(|(_, w)| w).sum();
        Self(std::array::from_fn(|i| (all[i].0, all[i].1 / sum)))
    }

    /// A chain of joints along a coordinate `x`: each takes over where `x` passes its start, softly over `half_width`
    /// to both sides.
    pub fn chain(links: &[(Joint, f32, f32)], x: f32) -> Self {
        let mut influence = Self::rigid(links[0].0);
        for &(joint, start, half_width) in &links[1..] {
            influence = influence.mix(Self::rigid(joint), smooth(start - half_width, start + half_width, x));
        }
        influence
    }

    /// Joints and weights in bytes that sum to 255.
    pub fn to_bytes(self) -> ([u8; 4], [u8; 4]) {
        let mut weights = self.0.map(|(_, w)| (w * 255.0).round() as i32);
        weights[0] += 255 - weights.iter().sum::<i32>();
        (self.0.map(|(j, _)| j.index() as u8), weights.map(|w| w.clamp(0, 255) as u8))
    }
}

/// 0 below `low`, 1 above `high`, a cubic between (low <= high).
pub(super) fn smooth(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low).max(1e-6)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_in_bytes() {
        let links =
            [(Joint::Hips, 0.0, 0.1), (Joint::Spine, 1.0, 0.5), (Joint::Chest, 1.2, 0.5), (Joint::Neck, 1.4, 0.5)];
        for i in 0..100 {
            let (_, w) = Influence::chain(&links, i as f32 * 0.03).to_bytes();
            assert_eq!(w.iter().map(|&w| u32::from(w)).sum::<u32>(), 255);
        }
        assert_eq!(Influence::chain(&links, 0.0).0[0], (Joint::Hips, 1.0));
        assert_eq!(Influence::chain(&links, 9.0).to_bytes().1[0], 255);
        assert_eq!(Influence::chain(&links[..2], 1.0).to_bytes().1[..2], [127, 128]);
    }
}
