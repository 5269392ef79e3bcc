//! The density grid: how many agents are where, and how they move, seen from afar.

use crate::{Space, space::cells::fold_bits};
use serde::{Deserialize, Serialize};
use throng_base::prefetch;

/// Most squares for each agent that there can be.
const MOST: usize = 16;
/// Bits of a word.
const WORD: usize = u64::BITS as usize;
/// Number that is added so that the last bit of the sum stands for 1 (numbers up to 2^22, up or down; squares farther
/// away are larger or smaller than others).
const INTEGER: f32 = (3 << 22) as f32;

/// More than this cannot be counted one by one.
const MOST_IN: f32 = (1 << 24) as f32;
/// Factor by which rounding may make a sum of vectors longer than all of them together.
const ROUNDING: f32 = 1.001;

/// Density grid: number, motion and intent of the agents in each square, a short time ago.
///
/// An agent that plans its path sees beyond its neighbours where others want to go the same way and where they come
/// toward it: so lanes form before agents meet. The grid is a torus, as that of the cells.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DensityGrid<V> {
    pub per_m: f32,
    bits: [u32; 3],
    squares: Vec<Square<V>>,
    /// A bit for each square, set where it is occupied: so few that they stay in the processor's caches, while of a
    /// large crowd that is spread out hardly any square does. Not kept, see [`DensityGrid::mark_occupied`].
    #[serde(skip)]
    anybody: Vec<u64>,
    /// An empty square.
    #[serde(skip)]
    empty: Square<V>,
}

/// The agents in one square: how many, and the sums of how they move and of the unit vectors along which they want to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Square<V> {
    /// Number of agents.
    pub num: f32,
    velocity: V,
    intent: V,
}

impl<V: Space> Square<V> {
    /// True if the sums can be those of as many agents, each no faster than `fastest`.
    fn is_possible(&self, fastest: f32) -> bool {
        let most = |sum: V, each: f32| sum.is_finite() && sum.length() <= each * self.num * ROUNDING;
        (0.0..=MOST_IN).contains(&self.num) && most(self.velocity, fastest) && most(self.intent, 1.0)
    }

    /// Obstruction by the agents of a square for one that goes along a unit vector, here divided by its speed: the sum
    /// of the speed that each of them lacks in that direction, as a share of its speed: 1 for one that stands, 2 for
    /// one that comes toward it, 0 for one that goes along. One is left out: a few agents are better considered one by
    /// one.
    #[inline]
    pub fn obstruction(&self, along_per_speed: V) -> f32 {
        (self.num - self.velocity.dot(along_per_speed) - 1.0).max(0.0)
    }

    /// Number of agents that want to go against a unit vector; one that wants to cross it, or to stay, counts as half.
    #[inline]
    pub fn num_opposed(&self, along: V) -> f32 {
        0.5 * (self.num - self.intent.dot(along)).max(0.0)
    }

    /// Number of agents that want to go along a unit vector; one that wants to cross it, or to stay, counts as half.
    #[inline]
    pub fn num_agreeing(&self, along: V) -> f32 {
        0.5 * (self.num + self.intent.dot(along)).max(0.0)
    }
}

impl<V: Space> DensityGrid<V> {
    /// Empty grid with squares of a side, most of them within `size`.
    pub fn new(side: f32, size: V, capacity: usize) -> Self {
        let bits = fold_bits(size, side, 8, 0, MOST * capacity.max(64));
        let squares = vec![Square::default(); 1 << bits.iter().sum::<u32>()];
        let anybody = vec![0; squares.len().div_ceil(WORD)];
        Self { per_m: side.recip(), bits, squares, anybody, empty: Square::default() }
    }

    /// Side of a square (m).
    #[cfg(test)]
    pub fn side(&self) -> f32 {
        self.per_m.recip()
    }

    /// The square at a place (squares, see [`DensityGrid::per_m`]).
    #[inline]
    pub fn square(&self, at: V) -> &Square<V> {
        let number = self.number(at);
        if self.is_anybody_in(number) { &self.squares[number] } else { &self.empty }
    }

    /// Agents on a square metre, mean of the squares at places along a direction (squares); none in the air.
    #[inline]
    pub fn density(&self, position: V, along: V, places: &[f32; 3]) -> f32 {
        if V::DIMENSIONS == 3 {
            return 0.0;
        }
        let at = position * self.per_m;
        let num: f32 = places.map(|k| self.square(at + along * k).num).iter().sum();
        num * (self.per_m * self.per_m / places.len() as f32)
    }

    /// Prefetches the squares along a way that hold agents (squares, see [`DensityGrid::per_m`]).
    #[inline]
    pub fn prefetch(&self, ways: impl Iterator<Item = V>) {
        for at in ways {
            let number = self.number(at);
            if self.is_anybody_in(number) {
                prefetch(&self.squares[number]);
            }
        }
    }

    #[inline]
    fn is_anybody_in(&self, number: usize) -> bool {
        self.anybody[number / WORD] >> (number % WORD) & 1 == 1
    }

    /// Number of a square.
    #[inline]
    fn number(&self, at: V) -> usize {
        let at = at.coordinates();
        let fold = |axis: usize| {
            // The last bits of such a float are an integer: the nearest one, if not the one below.
            let nearest = at[axis] + INTEGER;
            let above = u32::from(nearest - INTEGER > at[axis]);
            nearest.to_bits().wrapping_sub(above) & ((1 << self.bits[axis]) - 1)
        };
        let deep = if V::DIMENSIONS == 3 { fold(2) << self.bits[1] } else { 0 };
        (((deep | fold(1)) << self.bits[0]) | fold(0)) as usize
    }

    /// Empties the grid.
    pub fn clear(&mut self) {
        for (word, squares) in self.anybody.iter_mut().zip(self.squares.chunks_mut(WORD)) {
            let mut left = std::mem::take(word);
            while left != 0 {
                squares[left.trailing_zeros() as usize] = Square::default();
                left &= left - 1;
            }
        }
    }

    /// Adds an agent that wants to go along a unit vector, or nowhere.
    #[inline]
    pub fn add(&mut self, position: V, velocity: V, intent: V) {
        let number = self.number(position * self.per_m);
        self.anybody[number / WORD] |= 1 << (number % WORD);
        let square = &mut self.squares[number];
        square.num += 1.0;
        square.velocity += velocity;
        square.intent += intent;
    }

    #[cfg(test)]
    pub fn num_squares(&self) -> usize {
        self.squares.len()
    }

    /// True where it has the size of another one.
    pub fn has_same_size(&self, other: &Self) -> bool {
        (self.per_m, self.bits, self.squares.len()) == (other.per_m, other.bits, other.squares.len())
    }

    /// True where agents that are no faster than `fastest` may have been added to it.
    pub fn is_possible(&self, fastest: f32) -> bool {
        self.squares.iter().all(|s| s.is_possible(fastest))
    }

    /// Marks the occupied squares of a restored grid.
    pub fn mark_occupied(&mut self) {
        let word = |some: &[Square<V>]| (0..).zip(some).fold(0, |word, (i, s)| word | u64::from(s.num > 0.0) << i);
        self.anybody = self.squares.chunks(WORD).map(word).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use proptest::prelude::*;

    /// Shares between one whole number and the next.
    fn share() -> impl Strategy<Value = f32> {
        prop_oneof![Just(0.0f32), 0.0f32..0.99]
    }

    proptest! {
        #[test]
        fn squares_begin_at_whole_numbers(
            corner in [-3000i16..3000, -3000i16..3000], inside in [share(), share()],
        ) {
            let mut grid = DensityGrid::new(1.0, Vec2::splat(20.0), 10);
            prop_assert_eq!(grid.per_m, 1.0);
            let corner = Vec2::from_array(corner.map(f32::from));
            grid.add(corner + Vec2::from_array(inside), Vec2::ZERO, Vec2::ZERO);
            let middle = corner + 0.5;
            for at in [middle, middle + 0.49, middle - 0.49, middle + Vec2::new(0.49, -0.49)] {
                prop_assert_eq!(grid.square(at).num, 1.0);
            }
            for beside in [Vec2::X, Vec2::Y, -Vec2::X, -Vec2::Y, Vec2::splat(7.0)] {
                prop_assert_eq!(grid.square(middle + beside).num, 0.0);
            }
        }
    }

    #[test]
    fn tells_oncoming_from_following_agents() {
        let mut grid = DensityGrid::new(1.2, Vec2::splat(20.0), 10);
        let at = Vec2::new(5.0, -3.0);
        for _ in 0..3 {
            grid.add(at, Vec2::new(1.3, 0.0), Vec2::X);
        }
        grid.add(at, Vec2::ZERO, Vec2::NEG_X);
        let there = at * grid.per_m;
        let square = *grid.square(there);
        assert_eq!(square.num, 4.0);
        assert!(square.obstruction(Vec2::X / 1.3).abs() < 1e-5, "a standing agent is left out");
        assert!((square.obstruction(Vec2::NEG_X / 1.3) - 6.0).abs() < 1e-5, "2 each");
        assert!((square.obstruction(Vec2::Y / 1.3) - 3.0).abs() < 1e-5, "1 for each crossing agent, less one");
        assert_eq!((square.num_agreeing(Vec2::X), square.num_opposed(Vec2::X)), (3.0, 1.0));
        assert_eq!((square.num_agreeing(Vec2::Y), square.num_opposed(Vec2::Y)), (2.0, 2.0));
        assert_eq!(grid.square(there + Vec2::X).num, 0.0);
        let mut kept = DensityGrid { anybody: Vec::new(), ..grid.clone() };
        kept.mark_occupied();
        assert_eq!(kept.anybody, grid.anybody);
        grid.clear();
        assert!(grid.squares.iter().all(|s| *s == Square::default()) && grid.anybody.iter().all(|w| *w == 0));
        assert_eq!(grid.square(there).num, 0.0);
    }
}
