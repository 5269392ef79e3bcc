//! Tables of made-up tiles against plain Dijkstra on a wide plane.

use super::*;
use crate::made_up::{Tile, tiles};
use proptest::prelude::*;
use std::collections::BTreeMap;

fn plane(tile: &Tile) -> Option<TilePlane> {
    TilePlane::new(&tile.patches(), 0, &mut Dial::default())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn costs_are_those_of_plain_dijkstra(tile in tiles()) {
        let plane = plane(&tile).unwrap();
        for from in [0, 1, 2, 3, 8, 9] {
            let found = tile.dijkstra(from);
            let near = |o: &([i32; 2], f32)| o.0[0].abs().max(o.0[1].abs()) <= 2;
            for (offset, around) in offsets(RADIUS).zip(plane.around(RADIUS)).filter(near) {
                for c in 0..5 {
                    let ends = |cell: u32| cell < 4 && cell == c || cell >= 8 && c == 4;
                    let costs = found.iter().filter(|((at, cell), _)| *at == offset && ends(*cell)).map(|(_, f)| *f);
                    let best = costs.min().map_or(f32::INFINITY, |f| f as f32);
                    let cost = plane.cost(plane.lookup(c, offset), from);
                    // A path costlier than the bound might lead beyond the rim and back: its cost is then at most what is known.
                    let fits = if best < around { cost == best } else { cost <= best };
                    prop_assert!(fits, "{} to {} {:?}: {} {}", from, c, offset, cost, best);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn far_ways_cost_no_less_than_their_bounds(tile in tiles()) {
        let mut plane = plane(&tile).unwrap();
        let parts = [1, 9].map(|cell| plane.rows_to(cell, &mut Dial::default()));
        let rows = plane.join_costs(&[(&parts[0], 13), (&parts[1], 0)]);
        plane.add_goal(rows);
        for from in [0, 2, 8] {
            let found = tile.dijkstra(from);
            for offset in offsets(8) {
                for goal in 0..6u32 {
                    let part = |cell: u32| plane.cells(goal).iter().find(|c| c.0 == cell).map(|c| u32::from(c.1));
                    let there = found.iter().filter(|((at, _), _)| *at == offset);
                    let costs = there.filter_map(|((_, cell), f)| Some(*f + part(*cell)?));
                    let best = costs.min().map_or(f32::INFINITY, |f| f as f32);
                    let bound = plane.cost(plane.lookup(goal, offset), from);
                    prop_assert!(bound <= best, "{} to goal {} {:?}: {} {}", from, goal, offset, bound, best);
                }
            }
        }
    }
}

#[test]
fn far_ways_go_on_as_near_ones_do() {
    let plane = plane(&Tile::crossed_in(50, 40)).unwrap();
    // Cell 1 was entered from -x and goes on to +x.
    let cost = plane.cost(plane.lookup(1, [30, 0]), 1);
    assert!((1485.0..=1500.0).contains(&cost), "{cost}");
    // All the entrance zigzag.
    let cost = plane.least_of_all(plane.lookup(1, [20, 20]));
    assert!((1560.0..=1600.0).contains(&cost), "{cost}");
}

#[test]
fn paths_around_the_rim_cost_what_their_copies_take() {
    let plane = plane(&Tile::crossed_in(50, 40)).unwrap();
    let around: Vec<f32> = plane.around(RADIUS);
    // Straight on, a copy takes 50 frames: out to the rim, and back from there.
    for (offset, copies) in [([0, 0], 18), ([2, 0], 16), ([0, -2], 16), ([6, 0], 12)] {
        let (cost, straight) = (around[offset_number(offset, RADIUS) as usize], 50.0 * copies as f32);
        assert!((straight - 60.0..=straight).contains(&cost), "{offset:?}: {cost} of {straight}");
    }
}

#[test]
fn the_most_from_a_goal_is_at_least_what_its_cells_cost() {
    let plane = plane(&Tile::crossed_in(50, 40)).unwrap();
    for offset in [[2, 1], [0, 0], [9, -4]] {
        let most = plane.most(1, offset, 2);
        assert!(
            plane.cells(2).iter().all(|&(c, _)| plane.cost(plane.lookup(1, offset), c) <= most),
            "{offset:?}: {most}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn no_way_to_the_best_cell_costs_more_than_the_most(tile in tiles()) {
        let plane = plane(&tile).unwrap();
        for from in 0..5 {
            let found: Vec<_> = plane.cells(from).iter().map(|&(c, _)| tile.dijkstra(c)).collect();
            for (to, offset) in (0..5).flat_map(|to| offsets(2).map(move |offset| (to, offset))) {
                let least = |f: &BTreeMap<([i32; 2], u32), u32>| {
                    let ends = f.iter().filter(|((at, cell), _)| *at == offset && plane.cells(to).contains(&(*cell, 0)));
                    ends.map(|(_, frames)| *frames).min().map_or(f32::INFINITY, |f| f as f32)
                };
                let worst = found.iter().map(least).fold(0.0, f32::max);
                prop_assert!(plane.most(to, offset, from) >= worst, "{} to {} {:?}: {}", from, to, offset, worst);
            }
        }
        prop_assert_eq!(plane.most(0, [RADIUS + 1, 0], 1), f32::INFINITY);
    }
}

/// More links one after another than searches for prices follow, in the order that these follow them slowest in.
fn chain() -> impl Iterator<Item = (u32, u32, u16)> {
    (8..LAST).map(|cell| (cell, cell + 1, 1))
}

const LAST: u32 = 258;
const NUM_INSIDE: usize = (LAST - 8) as usize + 1;

/// No bound on the costs from some cells to the goals is above what paths cost.
fn check_bounds(tile: &Tile, plane: &TilePlane, goals: &[u32]) {
    for from in [0, 2, 8, LAST] {
        let found = tile.dijkstra(from);
        for (&(offset, cell), &frames) in &found {
            for &goal in goals.iter().filter(|&&g| plane.cells(g).iter().any(|c| c.0 == cell)) {
                let bound = plane.cost(plane.lookup(goal, offset), from);
                assert!(bound <= frames as f32, "{from} to goal {goal} {offset:?}: {bound} {frames}");
            }
        }
    }
}

#[test]
fn a_long_chain_of_links_to_a_goal_has_bounds() {
    let crossing = (0..4).flat_map(|from| (0..4).map(move |to| (from, 4 + to, 40)));
    let tile = Tile::new(NUM_INSIDE, &crossing.chain([(0, 8, 40)]).chain(chain()).collect::<Vec<_>>());
    let mut plane = plane(&tile).unwrap();
    assert!(plane.prices.iter().any(|p| p[0] > 30.0), "{:?}", plane.prices);
    assert!(far::rest_costs(&plane.back, plane.prices[0], [(LAST, 0)].into_iter(), plane.num_cells).is_none());
    let rows = plane.rows_to(LAST, &mut Dial::default());
    plane.add_goal(rows);
    check_bounds(&tile, &plane, &[0, 1, 2, 3, 4, 5]);
    let far = plane.cost(plane.lookup(5, [20, 0]), 0);
    assert!(far >= 600.0, "copies between still have their price: {far}");
}

#[test]
fn tiles_that_no_price_is_found_for_have_bounds() {
    let entrances = (0..4).map(|entry| (entry, 8, 1));
    let exits = (4..8).map(|exit| (LAST, exit, 1));
    let tile = Tile::new(NUM_INSIDE, &entrances.chain(chain()).chain(exits).collect::<Vec<_>>());
    let plane = plane(&tile).unwrap();
    assert_eq!(plane.prices, [[0.0, 0.0]]);
    check_bounds(&tile, &plane, &[0, 1, 2, 3, 4]);
}

#[test]
fn tiles_in_a_line_fill_no_plane() {
    assert!(lattice(&[Vec3::X, -Vec3::X]).is_none());
    assert_eq!(lattice(&[Vec3::X, Vec3::new(-1.0, 0.0, 0.5)]), Some(vec![[1, 0], [0, 1]]));
    assert!(lattice(&[Vec3::X, Vec3::Z, Vec3::new(0.5, 0.0, 0.0)]).is_none());
}

#[test]
fn costs_that_are_no_numbers_are_refused() {
    let good = plane(&Tile::crossed_in(20, 16)).unwrap();
    let is_sound = |forge: &dyn Fn(&mut TilePlane)| {
        let mut plane = good.clone();
        forge(&mut plane);
        plane.is_sound(good.num_cells, 4)
    };
    assert!(is_sound(&|_| ()));
    for wrong in [f32::NAN, f32::INFINITY, -f32::INFINITY, 3e9, -3e9] {
        assert!(!is_sound(&|p| p.prices[0][1] = wrong));
        assert!(!is_sound(&|p| p.leasts[0] = wrong));
        assert!(!is_sound(&|p| *p.least.last_mut().unwrap() = wrong));
    }
}
