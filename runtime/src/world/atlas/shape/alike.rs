//! Which places at the rim of a district are alike.
//!
//! Motion that goes the same way soon comes to the same poses, whatever it began with: what costs differ by then is when
//! each came there. So a few ways in and out, each of many places with a part of the cost of its own, tell what all the
//! places would.

use super::super::dial::UNREACHED;

/// Costs of places of a way differ by twice that at most, but for their parts. [Unit: frames]
const SPREAD: i32 = 8;

/// Places that may be alike: on the same tile, at the same edge.
pub(super) struct Group {
    /// What lies beyond, as a number in [`super::Plot::beyond`].
    pub beyond: u32,
    /// True for a tile; elsewhere nobody asks for parts.
    pub is_tile: bool,
    /// Numbers of the places.
    pub places: Vec<u32>,
}

/// A way in or out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Way {
    /// What lies beyond.
    pub beyond: u32,
    /// Numbers of its places, and the part of the cost of each that is counted outside. [Unit: frames]
    pub places: Vec<(u32, u16)>,
}

impl Way {
    /// All places of a group, with no parts.
    pub fn of(group: &Group) -> Self {
        Self { beyond: group.beyond, places: group.places.iter().map(|&n| (n, 0)).collect() }
    }

    /// The largest part.
    pub fn most(&self) -> u16 {
        self.places.iter().map(|p| p.1).max().unwrap_or(0)
    }

    /// Lowers the parts of a way in until no way through the district, to any way out, costs less than 0 beyond them.
    pub fn fit<'a>(&mut self, outs: impl Iterator<Item = (&'a [u16], u16)>) {
        let least = outs.map(|(costs, more)| self.across(costs, more)).min().unwrap_or(0);
        let less = least.min(0).unsigned_abs() as u16;
        self.places.iter_mut().for_each(|p| p.1 = p.1.saturating_sub(less));
    }

    /// Least cost to a way out, from the costs of all places and what these have more.
    fn across(&self, costs: &[u16], more: u16) -> i32 {
        let known = self.places.iter().filter(|p| costs[p.0 as usize] != UNREACHED);
        known
            .map(|&(n, part)| i32::from(costs[n as usize]) - i32::from(more) - i32::from(part))
            .min()
            .unwrap_or(i32::MAX)
    }
}

/// Least cost from a way in to a way out, from the costs of all places and what these have more.
pub(super) fn least_across(way: &Way, costs: &[u16], more: u16) -> u16 {
    let least = way.across(costs, more);
    if least == i32::MAX { UNREACHED } else { least.clamp(0, i32::from(UNREACHED) - 1) as u16 }
}

/// Parts groups into ways of places that are alike, by the costs of each place on the other side of the district.
pub(super) fn part(groups: &[Group], costs: &[Vec<u16>]) -> Vec<Way> {
    let mut ways = Vec::new();
    for group in groups {
        if !group.is_tile {
            ways.push(Way::of(group));
            continue;
        }
        let first = ways.len();
        let mut parts: Vec<Vec<(u32, i32)>> = Vec::new();
        for &place in &group.places {
            let fits = |with: &Vec<(u32, i32)>| Some((difference(costs, place, with[0].0)?, ()));
            match parts.iter_mut().find_map(|p| fits(p).map(|d| (p, d.0))) {
                Some((part, more)) => part.push((place, more)),
                None => parts.push(vec![(place, 0)]),
            }
        }
        ways.extend(parts.into_iter().map(|places| Way { beyond: group.beyond, places: lowest(&places, costs) }));
        debug_assert!(ways.len() > first);
    }
    ways
}

/// How much more a place costs than another one; none where they are not alike.
fn difference(costs: &[Vec<u16>], a: u32, b: u32) -> Option<i32> {
    let (mut least, mut most) = (i32::MAX, i32::MIN);
    for costs in costs {
        match (costs[a as usize], costs[b as usize]) {
            (UNREACHED, UNREACHED) => {}
            (UNREACHED, _) | (_, UNREACHED) => return None,
            (a, b) => {
                least = least.min(i32::from(a) - i32::from(b));
                most = most.max(i32::from(a) - i32::from(b));
            }
        }
    }
    (most.saturating_sub(least) <= 2 * SPREAD || least == i32::MAX)
        .then(|| if least == i32::MAX { 0 } else { (least + most) / 2 })
}

/// Parts of places: 0 for the lowest, and no more than any way from there costs.
fn lowest(places: &[(u32, i32)], costs: &[Vec<u16>]) -> Vec<(u32, u16)> {
    let lowest = places.iter().map(|p| p.1).min().unwrap_or(0);
    let all = |n: u32| costs.iter().map(move |c| i32::from(c[n as usize])).min().unwrap_or(0);
    places.iter().map(|&(n, more)| (n, (more - lowest).min(all(n)) as u16)).collect()
}
