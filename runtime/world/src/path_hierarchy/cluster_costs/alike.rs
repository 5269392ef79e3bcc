//! Alike places at the rim of a cluster.
//!
//! Motions along one path soon come to the same poses, whatever they began with: from then on, costs differ only by the
//! time of arrival there. So a few entrances and exits, each of many places with an additional cost of their own, stand
//! for all places.

use super::super::dial::UNREACHED;

/// Costs of places of a way differ by twice that at most, but for their parts: the wider, the fewer ways to search, and
/// the lower the bounds, by up to twice that a cluster (frames).
const SPREAD: i32 = 8;

/// Places that may be alike: on the same tile, at the same edge.
pub(super) struct PlaceGroup {
    /// Part of the world beyond, as a number in `adjacent_parts` of the outline.
    pub beyond: u32,
    /// True for a tile; only tiles have parts.
    pub is_tile: bool,
    /// Numbers of the places.
    pub places: Vec<u32>,
}

/// An entrance or out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct AlikePlaces {
    /// Part of the world beyond.
    pub beyond: u32,
    /// Numbers of its places, and the part of the cost of each that is counted outside (frames).
    pub places: Vec<(u32, u16)>,
}

impl AlikePlaces {
    /// All places of a group, without additional costs.
    pub fn from_group(group: &PlaceGroup) -> Self {
        Self { beyond: group.beyond, places: group.places.iter().map(|&n| (n, 0)).collect() }
    }

    /// The largest part.
    pub fn max_part(&self) -> u16 {
        self.places.iter().map(|p| p.1).max().unwrap_or(0)
    }

    /// Lowers the parts of an entrance until no path through the cluster, to any exit, costs less than 0 beyond them.
    pub fn fit_parts<'a>(&mut self, exits: impl Iterator<Item = (&'a [u16], u16)>) {
        let least = exits.map(|(costs, more)| self.least_to_exit(costs, more)).min().unwrap_or(0);
        let less = least.min(0).unsigned_abs() as u16;
        self.places.iter_mut().for_each(|p| p.1 = p.1.saturating_sub(less));
    }

    /// Least cost to an exit, from the costs of all places and what these have more.
    fn least_to_exit(&self, costs: &[u16], more: u16) -> i32 {
        let known = self.places.iter().filter(|p| costs[p.0 as usize] != UNREACHED);
        let beyond = known.map(|&(n, part)| i32::from(costs[n as usize]) - i32::from(more) - i32::from(part));
        beyond.min().unwrap_or(i32::MAX)
    }
}

/// Least cost from an entrance to an exit, from the costs of all places and what these have more.
pub(super) fn least_across(alike: &AlikePlaces, costs: &[u16], more: u16) -> u16 {
    let least = alike.least_to_exit(costs, more);
    if least == i32::MAX { UNREACHED } else { least.clamp(0, i32::from(UNREACHED) - 1) as u16 }
}

/// Parts groups into ways of places that are alike, by the costs of each place on the other side of the cluster.
pub(super) fn part_groups(groups: &[PlaceGroup], costs: &[Vec<u16>]) -> Vec<AlikePlaces> {
    let mut all = Vec::new();
    for group in groups {
        if !group.is_tile {
            all.push(AlikePlaces::from_group(group));
            continue;
        }
        // Each with how much more it costs than the first of its way.
        let mut parts: Vec<Vec<(u32, i32)>> = Vec::new();
        for &place in &group.places {
            let fits = parts.iter_mut().find_map(|p| Some((difference(costs, place, p[0].0)?, p)));
            match fits {
                Some((more, part)) => part.push((place, more)),
                None => parts.push(vec![(place, 0)]),
            }
        }
        all.extend(parts.iter().map(|places| AlikePlaces { beyond: group.beyond, places: lowest(places, costs) }));
    }
    all
}

/// Difference of the costs of two places; none where they are not alike.
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
    match least {
        // Neither leads anywhere.
        i32::MAX => Some(0),
        _ => (most - least <= 2 * SPREAD).then_some((least + most) / 2),
    }
}

/// Parts of places: 0 for the lowest, and no more than any way from there costs.
fn lowest(places: &[(u32, i32)], costs: &[Vec<u16>]) -> Vec<(u32, u16)> {
    let lowest = places.iter().map(|p| p.1).min().unwrap_or(0);
    let all = |n: u32| costs.iter().map(move |c| i32::from(c[n as usize])).min().unwrap_or(0);
    places.iter().map(|&(n, more)| (n, (more - lowest).min(all(n)) as u16)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Costs from places to places that hardly depend on which of a few routes is taken.
    fn costs() -> impl Strategy<Value = Vec<Vec<u16>>> {
        let step = || prop::collection::vec(0u16..60, 6);
        (step(), step(), prop::collection::vec(prop_oneof![8 => 20u16..30, 1 => Just(UNREACHED), 1 => 0u16..200], 36))
            .prop_map(|(on, off, between)| {
                let cost = |i: usize, o: usize| between[6 * i + o].saturating_add(on[i] + off[o]);
                (0..6).map(|o| (0..6).map(|i| cost(i, o)).collect()).collect()
            })
    }

    proptest! {
        #[test]
        fn costs_between_ways_with_the_parts_of_places_are_bounds(costs in costs()) {
            let group = PlaceGroup { beyond: 0, is_tile: true, places: (0..6).collect() };
            let turned: Vec<Vec<u16>> = (0..6).map(|i| costs.iter().map(|c| c[i]).collect()).collect();
            let groups = [group];
            let (mut entrances, exits) = (part_groups(&groups, &costs), part_groups(&groups, &turned));
            // Costs to each exit from all places, raised by its largest additional cost, as the search for it finds
            // them.
            let to = |alike: &AlikePlaces| (0..6).map(|i| {
                let cost = |&(o, part): &(u32, u16)| match costs[o as usize][i] {
                    UNREACHED => UNREACHED,
                    cost => cost + alike.max_part() - part,
                };
                alike.places.iter().map(cost).min().unwrap_or(UNREACHED)
            }).collect();
            let across: Vec<(Vec<u16>, u16)> = exits.iter().map(|alike| (to(alike), alike.max_part())).collect();
            entrances.iter_mut().for_each(|alike| alike.fit_parts(across.iter().map(|(a, more)| (&a[..], *more))));
            for alike in &entrances {
                for (out, (costs_out, more)) in exits.iter().zip(&across) {
                    prop_assert!(alike.least_to_exit(costs_out, *more) >= 0, "{:?} {:?}", alike, out);
                    let least = u32::from(least_across(alike, costs_out, *more));
                    for (i, before) in &alike.places {
                        for (o, after) in &out.places {
                            let cost = u32::from(costs[*o as usize][*i as usize]);
                            let bound = least + u32::from(before + after);
                            prop_assert!(cost == u32::from(UNREACHED) || bound <= cost, "{} {}", bound, cost);
                        }
                    }
                }
            }
            let all: usize = entrances.iter().map(|w| w.places.len()).sum();
            prop_assert_eq!(all, 6);
        }
    }

    #[test]
    fn places_that_differ_by_when_one_is_there_are_one_way() {
        let group = PlaceGroup { beyond: 3, is_tile: true, places: vec![0, 1, 2] };
        let costs = [vec![100, 130, 115], vec![200, 231, 300]];
        let all = part_groups(&[group], &costs);
        let places: Vec<_> = all.into_iter().map(|w| w.places).collect();
        assert_eq!(places, [vec![(0, 0), (1, 30)], vec![(2, 0)]]);
    }
}
