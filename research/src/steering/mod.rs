//! How crowds get on: grounds that steering was tuned on, and others that it was judged on.

pub mod ground;
mod people;
mod trial;

pub use people::{GapFigures, HEADINGS, PeopleFigures, RingFigures, people, row};
pub use trial::{SteeringFigures, run};

use ground::{Ground, People, Points};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
use throng_crowd::CrowdSetup;

/// A ground with a crowd on it.
#[derive(Clone, Copy)]
pub struct Case {
    /// What it is called.
    pub name: &'static str,
    /// Not looked at while steering was tuned.
    pub held_out: bool,
    /// Simulated time (s).
    pub seconds: f64,
    make: fn(u64) -> Ground,
}

impl Case {
    /// The crowd at its start.
    pub fn setup(&self, seed: u64) -> CrowdSetup {
        (self.make)(seed).finish()
    }
}

const fn case(name: &'static str, held_out: bool, seconds: f64, make: fn(u64) -> Ground) -> Case {
    Case { name, held_out, seconds, make }
}

const ALIKE: People = People::ALIKE;
const MIXED: People = People::MIXED;

/// All of them, those for tuning first.
pub const CASES: &[Case] = &[
    case("corridor", false, 120.0, |s| ground::corridor(s, ALIKE, (10.0, 1.0, 500), Points::One)),
    case("corridor_two_points", false, 120.0, |s| ground::corridor(s, ALIKE, (10.0, 1.0, 500), Points::Two)),
    case("post", false, 120.0, |s| {
        let mut g = ground::corridor(s, ALIKE, (10.0, 1.0, 500), Points::One);
        g.post([0.0, 0.0], 1.0);
        g
    }),
    case("l", false, 120.0, |s| ground::bend(s, ALIKE, (10.0, FRAC_PI_2, 200))),
    case("x", false, 120.0, |s| ground::crossing(s, ALIKE, 4, 100)),
    case("doors_4x2", false, 120.0, |s| ground::doors(s, ALIKE, (4, 2.0), 150)),
    case("door_1.2", false, 180.0, |s| ground::doors(s, ALIKE, (1, 1.2), 20)),
    case("narrow_2m", false, 180.0, |s| ground::corridor(s, ALIKE, (2.0, 1.0, 150), Points::One)),
    case("one_way_2.5", false, 120.0, |s| one_way(s, ALIKE)),
    case("rooms_1", false, 120.0, |s| ground::rooms(s + 1000, ALIKE, 12)),
    case("rooms_2", false, 120.0, |s| ground::rooms(s + 2000, ALIKE, 12)),
    case("circle", false, 120.0, |s| ground::circle(s, ALIKE, 1000)),
    case("ring_2_ways_1.0", false, 60.0, |s| ground::ring(s, ALIKE, (1.0, 4.0), 2)),
    case("corridor_many_points", true, 120.0, |s| ground::corridor(s, ALIKE, (10.0, 1.0, 500), Points::Many)),
    case("corridor_10000", true, 240.0, |s| ground::corridor(s, ALIKE, (33.0, 1.0, 5000), Points::One)),
    case("corridor_mixed", true, 120.0, |s| ground::corridor(s, MIXED, (10.0, 1.0, 500), Points::One)),
    case("corridor_4m", true, 120.0, |s| ground::corridor(s, MIXED, (4.0, 1.0, 150), Points::One)),
    case("t", true, 120.0, |s| ground::crossing(s, ALIKE, 3, 130)),
    case("s", true, 120.0, |s| ground::s_bend(s, ALIKE, 160)),
    case("bend_45", true, 120.0, |s| ground::bend(s, MIXED, (6.0, FRAC_PI_4, 120))),
    case("bend_120", true, 120.0, |s| ground::bend(s, ALIKE, (8.0, 2.0944, 160))),
    case("posts", true, 120.0, |s| posts(s, MIXED)),
    case("doors_6x1.5", true, 120.0, |s| ground::doors(s, MIXED, (6, 1.5), 150)),
    case("streams_90", true, 120.0, |s| ground::streams(s, MIXED, 150)),
    case("gap_1.2", true, 180.0, |s| ground::gap(s, ALIKE, 1.2, 150)),
    case("door_1.1", true, 180.0, |s| ground::doors(s, ALIKE, (1, 1.1), 15)),
    case("ring_1_way_1.5", true, 60.0, |s| ground::ring(s, ALIKE, (1.5, 4.0), 1)),
    case("ring_2_ways_0.5", true, 60.0, |s| ground::ring(s, ALIKE, (0.5, 4.0), 2)),
    case("rooms_3", true, 120.0, |s| ground::rooms(s + 3000, MIXED, 12)),
    case("rooms_4", true, 120.0, |s| ground::rooms(s + 4000, MIXED, 16)),
    case("rooms_5", true, 120.0, |s| ground::rooms(s + 5000, ALIKE, 8)),
];

/// A block of 2.5 persons/m2 walks one way.
fn one_way(seed: u64, people: People) -> Ground {
    let mut g = Ground::new(seed, people);
    for z in [-5.1, 5.1] {
        g.wall(&[[-60.0, z], [160.0, z]]);
    }
    let starts = g.places(750, [-30.0, -5.0, 0.0, 5.0]);
    for start in starts {
        g.agent(start, vec![start.0 + glam::Vec2::X * 110.0], throng_crowd::AtEnd::Leave);
    }
    g
}

/// Posts by chance in a corridor.
fn posts(seed: u64, people: People) -> Ground {
    let mut g = ground::corridor(seed, people, (10.0, 0.7, 250), Points::One);
    let mut posts: Vec<(glam::Vec2, f32)> = Vec::new();
    while posts.len() < 20 {
        let at = glam::Vec2::new(50.0 * (g.share() - 0.5), 8.0 * (g.share() - 0.5));
        let radius = 0.2 + 0.5 * g.share();
        let is_free = |p: glam::Vec2, r: f32| p.distance(at) > r + radius + 0.1;
        if g.setup.agents.iter().all(|a| is_free(glam::Vec2::new(a.position.x, a.position.z), a.radius))
            && posts.iter().all(|(p, r)| is_free(*p, r + 1.0))
        {
            posts.push((at, radius));
            g.post(at.into(), radius);
        }
    }
    g
}
