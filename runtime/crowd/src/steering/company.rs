//! Groups of companions: abreast where there is room, bent to a V in a crowd, and one after the other in narrow
//! passages and where others come (the patterns of Moussaid et al. 2010, PLoS ONE 5(4): e10047; the terms are simpler).
//!
//! Each has a place in the group: beside the group's middle, or ahead of it or behind it. It aims aside of its
//! direction to get there, and walks faster or slower: so members that are ahead wait.

use crate::steering::relationships::MOST_COMPANIONS;
use crate::{Space, space::solid::ConvexSolid, steering::forces::SteeredAgent};

/// Gap of two that walk abreast: more than that within which they repel each other (m).
const BESIDE_M: f32 = 0.25;
/// Gap of two that walk one after the other (m).
const BEHIND_M: f32 = 0.4;
/// Lead of the outer members over those in the middle of a V (m).
const BENT_M: f32 = 0.4;
/// Farther than this they have lost each other (m).
const LOST_M: f32 = 12.0;
/// Densities ahead from which on they bend to a V, and at which they have (1/m2).
const BENDS_AT: [f32; 2] = [0.3, 0.9];
/// Densities ahead from which on they begin to walk one after the other, and at which they do (1/m2).
const FILES_AT: [f32; 2] = [1.0, 2.0];
/// Numbers of oncoming agents from which on they begin to walk one after the other, and at which they do.
const COMING: [f32; 2] = [1.0, 4.0];
/// Places ahead of the group's middle where the way has to be wide (m).
const SAMPLE_DISTANCES_M: [f32; 3] = [0.0, 1.0, 2.0];
/// Densities ahead, or behind, from which on they wait and turn aside less and less for each other, and at which they do not:
/// else they would be in the way of those behind (1/m2). With 0.6 and 1.4, a door of 2 m lets a tenth fewer through.
const PRESSED_AT: [f32; 2] = [0.4, 1.0];
/// Speed towards their places, for each metre off (1/s).
const ASIDE_PER_S: f32 = 0.8;
/// Largest speed aside, as a share of the desired one.
const MOST_ASIDE: f32 = 0.45;
/// Change of speed for each metre that they are behind or ahead (1/m).
const PACE_PER_M: f32 = 0.6;
/// Slowest and fastest speed, as shares of the desired speed. No member stands, as that would count as no progress.
const PACE: [f32; 2] = [0.2, 1.2];
/// Distance to the goal within which places in the group matter less and less (m).
const NEAR_GOAL_M: f32 = 3.0;

/// Companion of an agent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Companion<V> {
    pub index: u32,
    /// Offset from the agent (m).
    pub offset: V,
    /// Unit vector along which it wants to go.
    pub intent: V,
    /// Desired speed (m/s).
    pub speed: f32,
}

/// Surroundings ahead of a group.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupAhead<'a, V> {
    pub solids: &'a [ConvexSolid<V>],
    /// Numbers of the near ones.
    pub near: &'a [u32],
    /// Agents on a square metre, ahead and behind.
    pub density: [f32; 2],
    /// Number of oncoming agents.
    pub coming: f32,
}

/// Steers an agent to its place in its group.
pub(crate) fn companion_force<V: Space>(
    index: u32,
    me: &mut SteeredAgent<V>,
    others: &[Companion<V>],
    ahead: &GroupAhead<'_, V>,
) {
    let own = Companion { index, offset: V::default(), intent: me.desired, speed: me.speed };
    let mut all = [own; MOST_COMPANIONS + 1];
    let mut num = 1;
    for other in others.iter().filter(|o| o.offset.length_squared() < LOST_M * LOST_M) {
        all[num] = *other;
        num += 1;
    }
    let all = &mut all[..num];
    if num < 2 {
        return;
    }
    let sum = all.iter().fold(V::default(), |sum, c| sum + c.intent);
    let along = sum.unit_and_length().0;
    // A member that goes elsewhere, maybe round a corner, keeps its own direction.
    let along = if along.dot(me.desired) > 0.5 { along } else { me.desired };
    let right = along.right();
    let middle = all.iter().fold(V::default(), |sum, c| sum + c.offset) * (num as f32).recip();
    let (beside, behind) = (2.0 * me.radius + BESIDE_M, 2.0 * me.radius + BEHIND_M);
    let needs = beside * (num - 1) as f32;
    let width = free_width(me.position + middle, along, right, ahead);
    let narrow = ((needs + 2.0 * me.radius + 0.2 - width) / (0.5 * needs)).clamp(0.0, 1.0);
    let share = |of: f32, [from, to]: [f32; 2]| ((of - from) / (to - from)).clamp(0.0, 1.0);
    let file = narrow.max(share(ahead.coming, COMING)).max(share(ahead.density[0], FILES_AT));
    let bent = share(ahead.density[0], BENDS_AT) * (1.0 - file);
    // Its place from the left, and from the front: as they walk now, and in the order of numbers where that is
    // ambiguous.
    let place = |along: V, by_number: f32| {
        let at = |c: &Companion<V>| {
            c.offset.dot(along) + by_number * all.iter().filter(|o| o.index < c.index).count() as f32
        };
        let mine = at(&own);
        all.iter().filter(|c| (at(c), c.index) < (mine, index)).count() as f32 - 0.5 * (num - 1) as f32
    };
    let (from_left, from_behind) = (place(right, 0.1), place(along, -0.3));
    let outward = from_left.abs() - 0.25 * num as f32;
    let aside = middle.dot(right) + from_left * beside * (1.0 - file);
    let onward = middle.dot(along) + from_behind * behind * file + bent * BENT_M * outward;
    let pressed = share(ahead.density[0].max(ahead.density[1]), PRESSED_AT);
    let weight = (me.distance_left / NEAR_GOAL_M).clamp(0.0, 1.0) * (1.0 - pressed);
    let speed = all.iter().fold(me.speed, |least, c| if c.speed > 0.0 { least.min(c.speed) } else { least });
    let pace = (1.0 + weight * PACE_PER_M * onward).clamp(1.0 - weight * (1.0 - PACE[0]), PACE[1]);
    let most = weight * MOST_ASIDE * speed;
    let sideways = (weight * ASIDE_PER_S * aside).clamp(-most, most);
    let (desired, speed) = (me.desired * (speed * pace) + right * sideways).unit_and_length();
    if speed > 0.0 {
        (me.desired, me.speed) = (desired, speed);
    }
}

/// Width of the path at the narrowest of some places ahead (m).
fn free_width<V: Space>(middle: V, along: V, right: V, ahead: &GroupAhead<'_, V>) -> f32 {
    let mut narrowest = f32::INFINITY;
    for far in SAMPLE_DISTANCES_M {
        let at = middle + along * far;
        let mut free = [f32::INFINITY; 2];
        for &s in ahead.near {
            let (away, distance) = ahead.solids[s as usize].direction_and_distance(at);
            let side = away.dot(right);
            if side.abs() > 0.7 {
                let free = &mut free[usize::from(side < 0.0)];
                *free = free.min(distance.max(0.0));
            }
        }
        narrowest = narrowest.min(free[0] + free[1]);
    }
    narrowest
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// Speeds of three who walk side by side, each at its place.
    fn speeds(density: f32) -> [f32; 3] {
        let (radius, right) = (0.3, Vec2::X.right());
        let at = |k: u32| right * (k as f32 - 1.0) * (2.0 * radius + BESIDE_M);
        let ahead = GroupAhead { solids: &[], near: &[], density: [density, 0.0], coming: 0.0 };
        [0, 1, 2].map(|index| {
            let desired = Vec2::X;
            let mut me = SteeredAgent { radius, desired, speed: 1.3, distance_left: 50.0, ..SteeredAgent::default() };
            let others = [0, 1, 2].into_iter().filter(|&k| k != index);
            let other = |k: u32| Companion { index: k, offset: at(k) - at(index), intent: Vec2::X, speed: 1.3 };
            companion_force(index, &mut me, &others.map(other).collect::<Vec<_>>(), &ahead);
            assert!((me.desired - Vec2::X).length() < 1e-5, "nobody steps aside");
            me.speed
        })
    }

    #[test]
    fn the_outer_companions_go_ahead_of_the_middle_one_in_a_crowd() {
        assert!(speeds(0.0).iter().all(|v| (v - 1.3).abs() < 1e-5), "{:?}", speeds(0.0));
        // Half way to a V, and before they mind those behind more than each other.
        let [left, middle, right] = speeds(0.6);
        let weight = 1.0 - (0.6 - PRESSED_AT[0]) / (PRESSED_AT[1] - PRESSED_AT[0]);
        let pace = |outward: f32| 1.3 * (1.0 + weight * PACE_PER_M * 0.5 * BENT_M * outward);
        assert!((left - pace(0.25)).abs() < 1e-4 && (right - pace(0.25)).abs() < 1e-4, "{left} {right}");
        assert!((middle - pace(-0.75)).abs() < 1e-4 && middle < 1.25, "{middle}");
    }
}
