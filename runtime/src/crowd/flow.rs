//! Where the crowd as a whole goes: how many are where, and how they move, seen from afar.

use super::Space;
use serde::{Deserialize, Serialize};

/// Time between two looks at everybody. [Unit: s]
pub(crate) const LOOK_S: f64 = 0.25;
/// Side of a square or cube of the grid, in radii of the largest member.
const SIDE: f32 = 4.0;
/// Most squares for each member that there can be.
const MOST: usize = 16;

/// Number and sum of velocities of the members in each square of a grid, as they were a short time ago.
///
/// A member that looks for its way sees beyond its neighbours where others go the same way and where they come
/// toward it: so lanes form before it meets anybody. The grid is a torus, as that of the cells.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Flow<V> {
    per_m: f32,
    bits: [u32; 3],
    squares: Vec<Square<V>>,
}

#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Square<V> {
    num: f32,
    velocity: V,
}

impl<V: Space> Flow<V> {
    /// Nobody anywhere; for members up to a radius, most of them within `size`.
    pub fn new(radius: f32, size: V, capacity: usize) -> Self {
        let side = SIDE * radius.max(1e-3);
        let mut bits = [0; 3];
        for (axis, &length) in size.coordinates().iter().take(V::DIMENSIONS).enumerate() {
            bits[axis] = ((length / side).min(1e6) as usize + 8).next_power_of_two().trailing_zeros();
        }
        while 1usize << bits.iter().sum::<u32>() > MOST * capacity.max(64) {
            let longest = (0..3).max_by_key(|&axis| (bits[axis], axis)).unwrap_or(0);
            bits[longest] -= 1;
        }
        Self { per_m: side.recip(), bits, squares: vec![Square::default(); 1 << bits.iter().sum::<u32>()] }
    }

    /// Side of a square. [Unit: m]
    pub fn side(&self) -> f32 {
        self.per_m.recip()
    }

    #[inline]
    fn number(&self, x: V) -> usize {
        let at = (x * self.per_m).floor();
        let fold = |axis: usize| at[axis] as u32 & ((1 << self.bits[axis]) - 1);
        ((((fold(2) << self.bits[1]) | fold(1)) << self.bits[0]) | fold(0)) as usize
    }

    /// Forgets everybody.
    pub fn clear(&mut self) {
        self.squares.fill(Square::default());
    }

    /// Adds a member.
    #[inline]
    pub fn add(&mut self, position: V, velocity: V) {
        let number = self.number(position);
        let square = &mut self.squares[number];
        square.num += 1.0;
        square.velocity += velocity;
    }

    /// How much those who are at `x` are in the way of one who goes there along a unit vector at a speed: the sum of
    /// how much slower than it each of them goes its way, as a share of its speed: 1 for somebody who stands, 2 for one
    /// who comes toward it, 0 for one who goes along. One who stands is left out: a few are seen better one by one.
    #[inline]
    pub fn against(&self, x: V, along: V, speed: f32) -> f32 {
        let square = &self.squares[self.number(x)];
        (square.num - square.velocity.dot(along) / speed - 1.0).max(0.0)
    }

    /// True where it is as large as another one.
    pub fn fits(&self, other: &Self) -> bool {
        (self.per_m, self.bits, self.squares.len()) == (other.per_m, other.bits, other.squares.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    #[test]
    fn tells_those_who_come_from_those_who_go_along() {
        let mut flow = Flow::new(0.3, Vec2::splat(20.0), 10);
        let at = Vec2::new(5.0, -3.0);
        for _ in 0..3 {
            flow.add(at, Vec2::new(1.3, 0.0));
        }
        assert!(flow.against(at, Vec2::X, 1.3) == 0.0);
        assert!((flow.against(at, Vec2::NEG_X, 1.3) - 5.0).abs() < 1e-5, "2 each, less one who stands");
        assert!((flow.against(at, Vec2::Y, 1.3) - 2.0).abs() < 1e-5, "1 each for those who cross, less one");
        assert_eq!(flow.against(at + Vec2::X * flow.side(), Vec2::NEG_X, 1.3), 0.0);
        flow.clear();
        assert_eq!(flow.against(at, Vec2::NEG_X, 1.3), 0.0);
    }
}
