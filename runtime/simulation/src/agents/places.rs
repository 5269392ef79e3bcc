//! Start positions of the agents of a group.

use crate::scene::{PlaceConfig, to_point};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use std::f32::consts::{PI, TAU};
use throng_base::maths;
use throng_crowd::Space;

/// Turn between neighbours of a sunflower's seeds, (3 - sqrt 5) pi (rad).
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Start positions of a group's agents (m).
///
/// - `radius`: largest radius of the agents, so that random displacements never make two touch (m).
/// - returns `count` positions, equal for equal states of the generator.
pub(super) fn start_positions<V: Space>(place: &PlaceConfig, count: usize, radius: f32, rng: &mut Pcg64Mcg) -> Vec<V> {
    match place {
        PlaceConfig::Block { from, to, jitter } => {
            block_positions(to_point(from), to_point(to), *jitter, count, radius, rng)
        }
        PlaceConfig::Disc { centre, density } => {
            let centre = to_point::<V>(centre);
            let around: Vec<V> =
                if V::DIMENSIONS == 2 { sunflower_positions(count, *density) } else { lattice_ball(count, *density) };
            // Neighbours are three quarters as far apart as they were on a square grid, or as in a cubic one.
            let apart = if V::DIMENSIONS == 2 { 0.75 / density.sqrt() } else { maths::cbrt(density.recip()) };
            jitter_positions(around.into_iter().map(|p| centre + p).collect(), apart, radius, rng)
        }
        PlaceConfig::Ring { centre, spacing_m, rings } => {
            jitter_positions(ring_positions(to_point(centre), *spacing_m, *rings, count), 0.9 * *spacing_m, radius, rng)
        }
        PlaceConfig::Level { .. } => Vec::new(),
        // The check of scenes refuses such a place for agents.
        PlaceConfig::Grid { centre, .. } => vec![to_point(centre); count],
    }
}

/// Cells of equal size, as near to squares (or cubes) as they can be; each holds one.
fn block_positions<V: Space>(from: V, to: V, jitter: f32, count: usize, radius: f32, rng: &mut Pcg64Mcg) -> Vec<V> {
    let (low, size) = (from.coordinates(), (to - from).coordinates());
    let d = V::DIMENSIONS;
    let volume: f32 = size[..d].iter().product();
    let side = maths::pow(volume / count as f32, 1.0 / d as f32);
    let mut cells: [usize; 3] =
        std::array::from_fn(|i| if i < d { ((size[i] / side).round() as usize).max(1) } else { 1 });
    // Rounding may leave too few: the longest side gets more.
    let longest = (0..d).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let across = (0..3).filter(|&i| i != longest).fold(1, |all: usize, i| all.saturating_mul(cells[i]));
    cells[longest] = count.div_ceil(across);
    let cell: [f32; 3] = std::array::from_fn(|i| size[i] / cells[i] as f32);
    let free = cell.map(|c| jitter * (0.5 * c - radius - 1e-3).max(0.0));
    // The longest side counts slowest, so that empty cells are at its end.
    let order: Vec<usize> = (0..3).filter(|&i| i != longest).chain([longest]).collect();
    let place = |n: usize| {
        let mut rest = n;
        let mut at = [0.0; 3];
        for &i in &order {
            let (step, next) = (rest % cells[i], rest / cells[i]);
            rest = next;
            let off = if i < d { rng.random_range(-1.0..1.0f32) * free[i] } else { 0.0 };
            at[i] = low[i] + (step as f32 + 0.5) * cell[i] + off;
        }
        V::from_coordinates(at)
    };
    (0..count).map(place).collect()
}

/// Moves all positions a little at random, so little that no two agents can touch.
///
/// - `apart`: least distance of two neighbours (m).
fn jitter_positions<V: Space>(mut places: Vec<V>, apart: f32, radius: f32, rng: &mut Pcg64Mcg) -> Vec<V> {
    // Along each axis: at most half of the room along the diagonal.
    let most = ((0.5 * apart - radius - 1e-3) / (V::DIMENSIONS as f32).sqrt()).max(0.0);
    for place in &mut places {
        *place += V::from_coordinates(std::array::from_fn(|i| {
            if i < V::DIMENSIONS { most * rng.random_range(-1.0..1.0f32) } else { 0.0 }
        }));
    }
    places
}

/// The seeds of a sunflower fill a disc evenly, and no two are opposite each other (density in 1/m^2).
fn sunflower_positions<V: Space>(count: usize, density: f32) -> Vec<V> {
    let seed = |i: usize| {
        let out = ((i as f32 + 0.5) / (PI * density)).sqrt();
        // In f64: the angle of the 100 000th is still exact.
        let (sin, cos) = maths::sin_cos((i as f64 * GOLDEN_ANGLE).rem_euclid(f64::from(TAU)));
        V::from_coordinates([out * cos as f32, out * sin as f32, 0.0])
    };
    (0..count).map(seed).collect()
}

/// The points of a cubic lattice that are nearest to the origin (density in 1/m^3).
fn lattice_ball<V: Space>(count: usize, density: f32) -> Vec<V> {
    let half = (0.63 * maths::cbrt(count as f32)).ceil() as i32 + 1;
    // Off the origin, so that few are equally far from it.
    let off = |c: &[i32; 3]| [c[0] as f32 + 0.11, c[1] as f32 + 0.23, c[2] as f32 + 0.37];
    let square = |c: &[i32; 3]| off(c).iter().map(|x| x * x).sum::<f32>();
    let side = || -half..=half;
    let mut all: Vec<[i32; 3]> =
        side().flat_map(|x| side().flat_map(move |y| side().map(move |z| [x, y, z]))).collect();
    all.sort_by(|a, b| square(a).total_cmp(&square(b)).then(a.cmp(b)));
    let spacing = maths::cbrt(density.recip());
    all.iter().take(count).map(|c| V::from_coordinates(off(c).map(|x| x * spacing))).collect()
}

/// Concentric rings, as large as `count` agents at that spacing need.
fn ring_positions<V: Space>(centre: V, spacing: f32, rings: usize, count: usize) -> Vec<V> {
    let (k, n) = (rings as f32, count as f32);
    let inner = (spacing * (n / TAU - 0.5 * k * (k - 1.0)) / k).max(spacing);
    let radius = |ring: usize| inner + ring as f32 * spacing;
    let all: f32 = (0..rings).map(radius).sum();
    let (mut out, mut upto) = (Vec::with_capacity(count), 0.0);
    for ring in 0..rings {
        upto += radius(ring);
        let num = (n * upto / all).round() as usize - out.len();
        let turn = |i: usize| TAU * (i as f32 + 0.5 * (ring % 2) as f32) / num as f32;
        let place = |i: usize| V::from_coordinates([maths::cos(turn(i)), maths::sin(turn(i)), 0.0]) * radius(ring);
        out.extend((0..num).map(|i| centre + place(i)));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use rand::SeedableRng;

    fn nearest<V: Space>(places: &[V]) -> f32 {
        let pairs = (0..places.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| (places[i] - places[j]).length()).fold(f32::INFINITY, f32::min)
    }

    fn rng() -> Pcg64Mcg {
        Pcg64Mcg::seed_from_u64(3)
    }

    #[test]
    fn a_block_is_filled_and_nobody_touches_another() {
        for count in [1, 2, 7, 100, 997] {
            let place = PlaceConfig::Block { from: vec![-20.0, 0.0], to: vec![20.0, 25.0], jitter: 1.0 };
            let places: Vec<Vec2> = start_positions(&place, count, 0.3, &mut rng());
            assert_eq!(places.len(), count);
            assert!(places.iter().all(|p| p.x.abs() <= 19.7 && p.y >= 0.3 && p.y <= 24.7), "{count}");
            assert!(nearest(&places) > 0.6, "{count}: {}", nearest(&places));
        }
        let place = PlaceConfig::Block { from: vec![0.0; 3], to: vec![20.0, 10.0, 10.0], jitter: 0.5 };
        let places: Vec<Vec3> = start_positions(&place, 500, 0.5, &mut rng());
        assert!(places.len() == 500 && nearest(&places) > 1.0);
        let far = places.iter().fold(Vec3::ZERO, |a, p| a.max(*p));
        assert!(far.x > 18.0 && far.y > 9.0 && far.z > 9.0, "all of the box is used: {far}");
    }

    #[test]
    fn a_block_as_small_as_nothing_holds_all() {
        let place = PlaceConfig::Block { from: vec![0.0; 3], to: vec![1e-16; 3], jitter: 1.0 };
        let places: Vec<Vec3> = start_positions(&place, 3, 0.3, &mut rng());
        assert!(places.len() == 3 && places.iter().all(|p| p.length() < 1e-15), "{places:?}");
    }

    #[test]
    fn a_disc_and_a_ball_have_their_density() {
        let disc = |centre| PlaceConfig::Disc { centre, density: 0.7 };
        let flat: Vec<Vec2> = start_positions(&disc(vec![5.0, 1.0]), 1000, 0.3, &mut rng());
        let radius = flat.iter().map(|p| p.distance(Vec2::new(5.0, 1.0))).fold(0.0, f32::max);
        assert!((1000.0 / (PI * radius * radius) - 0.7).abs() < 0.01 && nearest(&flat) > 0.6);
        let round: Vec<Vec3> = start_positions(&disc(vec![0.0; 3]), 1000, 0.3, &mut rng());
        let radius = round.iter().map(|p| p.length()).fold(0.0, f32::max);
        let density = 1000.0 / (4.0 / 3.0 * PI * radius.powi(3));
        assert!((density - 0.7).abs() < 0.1 && nearest(&round) > 0.6, "{density}");
    }

    #[test]
    fn rings_are_as_large_as_their_spacing_asks_for() {
        for (rings, count) in [(1, 200), (4, 1000), (3, 5)] {
            let place = PlaceConfig::Ring { centre: vec![0.0, 0.0], spacing_m: 1.0, rings };
            let places: Vec<Vec2> = start_positions(&place, count, 0.3, &mut rng());
            assert_eq!(places.len(), count);
            assert!(nearest(&places) > 0.6, "{rings} {count}: {}", nearest(&places));
        }
    }
}
