//! Looking ahead: how long each of several directions is free, and which one to take.

use super::solid::Solid;
use super::{Field, Space};

/// Number of directions that are looked in.
pub(crate) const DIRECTIONS: usize = 8;
/// A time that stands for never. [Unit: s]
const NEVER: f32 = 1e3;

/// Another one as it is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<V> {
    /// From the one who sees to the one who is seen. [Unit: m]
    pub offset: V,
    /// [Unit: m/s]
    pub velocity: V,
    /// Distance of the centres. [Unit: m]
    pub distance: f32,
    /// Sum of the radii. [Unit: m]
    pub radii: f32,
}

/// What a member sees in each direction of [`Space::fan`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight<V> {
    directions: [V; DIRECTIONS],
    /// Time until something is in the way at the desired speed. [Unit: s]
    free: [f32; DIRECTIONS],
}

impl<V: Space> Sight<V> {
    /// Looks along a unit vector.
    pub fn along(ahead: V) -> Self {
        Self { directions: ahead.fan(), free: [NEVER; DIRECTIONS] }
    }

    /// Takes in somebody: the time of the first contact in each direction, at a speed, if that one goes on as it does.
    #[inline]
    pub fn see(&mut self, other: &Seen<V>, speed: f32, comfort: f32) {
        let radii = (other.radii + comfort).min(other.distance - 1e-3);
        let gap = other.offset.length_squared() - radii * radii;
        for (direction, free) in self.directions.iter().zip(&mut self.free) {
            let velocity = *direction * speed - other.velocity;
            let toward = other.offset.dot(velocity);
            let root = toward * toward - velocity.length_squared() * gap;
            let time = gap / (toward + root.max(0.0).sqrt());
            let meets = toward > 0.0 && root > 0.0;
            *free = free.min(if meets { time } else { NEVER });
        }
    }

    /// Takes in a solid that stands, by steps of its distance.
    pub fn see_solid(&mut self, solid: &Solid<V>, x: V, radius: f32, speed: f32, horizon: f32) {
        let reach = speed * horizon;
        for (direction, free) in self.directions.iter().zip(&mut self.free) {
            let mut way = 0.0;
            let mut hit = false;
            for _ in 0..6 {
                let (away, distance) = solid.away(x + *direction * way);
                let gap = distance - radius;
                if gap < 0.02 {
                    hit = direction.dot(away) < -0.02;
                    break;
                }
                way += gap;
                if way > reach {
                    break;
                }
            }
            if hit {
                *free = free.min(way / speed.max(1e-3));
            }
        }
    }

    /// Direction to take and how long it is free. `keep` is the velocity now: who has begun to pass goes on.
    pub fn choose(&self, field: &Field, keep: V) -> (V, f32) {
        let mut score = [0.0; DIRECTIONS];
        for i in 0..DIRECTIONS {
            let free = (self.free[i] / field.horizon_s).min(1.0);
            let straight = self.directions[0].dot(self.directions[i]);
            score[i] = (0.25 + 0.75 * straight) * free.sqrt() + 0.12 * self.directions[i].dot(keep);
        }
        let mut best = 0;
        for i in 1..DIRECTIONS {
            if score[i] > score[best] + 1e-4 {
                best = i;
            }
        }
        (self.directions[best], self.free[best])
    }
}
