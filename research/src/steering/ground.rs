//! Grounds for crowds: corridors, bends, crossings, doors, posts, rooms and rings, made from a few numbers.

use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f32::consts::TAU;
use throng_crowd::{Agent, AtEnd, CrowdSetup, Obstacle, Route, Streets};

/// A rectangle along the axes: lowest and highest x and z (m).
pub type Area = [f32; 4];

/// What the agents of a ground are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct People {
    /// Radii, least and most (m).
    pub radius_m: [f32; 2],
    /// Mean and deviation of desired speeds (m/s).
    pub speed_mps: [f32; 2],
}

impl People {
    /// As wide as in all papers, and alike.
    pub const ALIKE: Self = Self { radius_m: [0.3, 0.3], speed_mps: [1.3, 0.0] };
    /// Sizes and speeds of people (Weidmann 1993: 1.34 +- 0.26 m/s).
    pub const MIXED: Self = Self { radius_m: [0.2, 0.3], speed_mps: [1.34, 0.26] };
}

/// A crowd on its ground, in the making.
#[derive(Clone, Debug)]
pub struct Ground {
    /// What the engine is given.
    pub setup: CrowdSetup,
    /// Where agents start, for what may not be too near (m).
    taken: Vec<(Vec2, f32)>,
    rng: Pcg64Mcg,
    people: People,
}

impl Ground {
    /// Nobody, nowhere.
    pub fn new(seed: u64, people: People) -> Self {
        Self { setup: CrowdSetup::default(), taken: Vec::new(), rng: Pcg64Mcg::seed_from_u64(seed), people }
    }

    /// A share by chance (0 to 1).
    pub fn share(&mut self) -> f32 {
        self.rng.random_range(0.0..1.0)
    }

    /// Walls from each point to the next.
    pub fn wall(&mut self, points: &[[f32; 2]]) {
        let at = |p: [f32; 2]| Vec3::new(p[0], 0.0, p[1]);
        let walls = points.windows(2).map(|w| Obstacle::Wall { from: at(w[0]), to: at(w[1]), radius: 0.0 });
        self.setup.obstacles.extend(walls);
    }

    /// A round post.
    pub fn post(&mut self, [x, z]: [f32; 2], radius: f32) {
        self.setup.obstacles.push(Obstacle::Ball { centre: Vec3::new(x, 0.0, z), radius });
    }

    /// Places in an area that are apart, by chance; in rows with a little chance where that is too dense.
    pub fn places(&mut self, count: usize, [x0, z0, x1, z1]: Area) -> Vec<(Vec2, f32)> {
        let [least, most] = self.people.radius_m;
        let mut out: Vec<(Vec2, f32)> = Vec::new();
        let is_loose = (count as f32) * most * most * 3.5 < 0.33 * (x1 - x0) * (z1 - z0);
        if !is_loose {
            let (w, d) = (x1 - x0, z1 - z0);
            let across = ((count as f32 * d / w).sqrt().round() as usize).max(1);
            let along = count.div_ceil(across);
            let (dx, dz) = (w / along as f32, d / across as f32);
            for i in 0..count {
                let r = least + (most - least) * self.share();
                let slack = Vec2::new(dx, dz) * 0.5 - most - 0.002;
                let off = Vec2::new(2.0 * self.share() - 1.0, 2.0 * self.share() - 1.0) * slack.max(Vec2::ZERO);
                let at = Vec2::new(x0 + ((i / across) as f32 + 0.5) * dx, z0 + ((i % across) as f32 + 0.5) * dz);
                out.push((at + off, r));
            }
            return out;
        }
        let mut tries = 0;
        while out.len() < count && tries < 400 * count {
            tries += 1;
            let r = least + (most - least) * self.share();
            let at =
                Vec2::new(x0 + r + (x1 - x0 - 2.0 * r) * self.share(), z0 + r + (z1 - z0 - 2.0 * r) * self.share());
            let is_free = |(p, s): &(Vec2, f32)| p.distance(at) > r + s + 0.02;
            if out.iter().all(is_free) && self.taken.iter().all(is_free) {
                out.push((at, r));
            }
        }
        out
    }

    /// A desired speed by chance: normal, within two deviations.
    fn speed(&mut self) -> f32 {
        let [mean, deviation] = self.people.speed_mps;
        let sum: f32 = (0..12).map(|_| self.share()).sum::<f32>() - 6.0;
        mean + deviation * sum.clamp(-2.0, 2.0)
    }

    /// An agent that goes along subgoals, and leaves at the last one.
    pub fn agent(&mut self, (at, radius): (Vec2, f32), subgoals: Vec<Vec2>, at_end: AtEnd) {
        let speed = self.speed();
        let route = Some(self.setup.routes.len());
        let subgoals = subgoals.into_iter().map(|p| Vec3::new(p.x, 0.0, p.y)).collect();
        self.setup.routes.push(Route { subgoals, arrival_radius: 0.5, at_end });
        let position = Vec3::new(at.x, 0.0, at.y);
        self.setup.agents.push(Agent { position, radius, speed, route, ..Agent::default() });
        self.taken.push((at, radius));
    }

    /// A group from one area to another, in no order.
    pub fn group(&mut self, count: usize, from: Area, to: Area) {
        let starts = self.places(count, from);
        for (at, radius) in starts {
            let share = [self.share(), self.share()];
            let to = Vec2::new(to[0] + (to[2] - to[0]) * share[0], to[1] + (to[3] - to[1]) * share[1]);
            self.agent((at, radius), vec![to], AtEnd::Leave);
        }
    }

    /// Lets agents find their ways round what stands.
    pub fn finish(mut self) -> CrowdSetup {
        self.setup.config.largest_speed_mps = 2.0;
        let radius = self.people.radius_m[1];
        let streets = Streets::with_limits(&self.setup.obstacles, None, radius + 0.15, radius);
        self.setup.streets = streets.ok().filter(|s| !s.is_open());
        self.setup
    }
}

/// Points of routes of agents that go straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// The goal alone.
    One,
    /// Start and goal.
    Two,
    /// One every five metres.
    Many,
}

/// Two groups head-on in a corridor along x, at a density (1/m2), with posts in it.
pub fn corridor(seed: u64, people: People, (width, density, count): (f32, f32, usize), points: Points) -> Ground {
    let mut ground = Ground::new(seed, people);
    let length = count as f32 / (width * density);
    for side in [-1.0f32, 1.0] {
        let (near, far) = (side * 2.0, side * (2.0 + length));
        let starts = ground.places(count, [near.min(far), -0.5 * width + 0.1, near.max(far), 0.5 * width - 0.1]);
        for start in starts {
            let goal = start.0 - Vec2::X * (side * (2.0 * length + 4.0));
            let steps = (start.0.distance(goal) / 5.0).ceil();
            let many = (1..=steps as usize).map(|i| start.0.lerp(goal, i as f32 / steps));
            let subgoals = match points {
                Points::One => vec![goal],
                Points::Two => vec![start.0, goal],
                Points::Many => many.collect(),
            };
            ground.agent(start, subgoals, AtEnd::Leave);
        }
    }
    let end = 3.0 * length + 20.0;
    for z in [-0.5 * width - 0.1, 0.5 * width + 0.1] {
        ground.wall(&[[-end, z], [end, z]]);
    }
    ground
}

/// A bend of a corridor by an angle (rad), both ways.
pub fn bend(seed: u64, people: People, (width, angle, count): (f32, f32, usize)) -> Ground {
    let mut ground = Ground::new(seed, people);
    let length = count as f32 / width + 30.0;
    // The second arm leaves the first one's end at the angle; people are placed along a straight corridor that is bent.
    let (sin, cos) = angle.sin_cos();
    let half = 0.5 * width;
    let tan = (0.5 * angle).tan();
    let turn = |p: Vec2| Vec2::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos);
    for side in [-1.0f32, 1.0] {
        let z = side * (half + 0.1);
        let corner = Vec2::new(-z * tan, z);
        let (from, to) = (Vec2::new(-length - 10.0, z), turn(Vec2::new(length + 10.0, z)));
        ground.wall(&[from.into(), corner.into(), to.into()]);
    }
    let arm = [half * tan + 1.0, half * tan + 1.0 + count as f32 / width];
    let there = [arm[1] - 5.0, arm[1] + 15.0];
    let starts = [0; 2].map(|_| ground.places(count, [-arm[1], -half + 0.1, -arm[0], half - 0.1]));
    for (first, starts) in [true, false].into_iter().zip(starts) {
        for (at, radius) in starts {
            let along = there[0] + (there[1] - there[0]) * ground.share();
            let goal = Vec2::new(along, (2.0 * ground.share() - 1.0) * (half - 0.5));
            let bent = |p: Vec2| if first { p } else { turn(p * Vec2::new(-1.0, 1.0)) };
            let goal = if first { turn(goal) } else { goal * Vec2::new(-1.0, 1.0) };
            ground.agent((bent(at), radius), vec![goal], AtEnd::Leave);
        }
    }
    ground
}

/// A bend to one side and one back.
pub fn s_bend(seed: u64, people: People, count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let far = count as f32 / 8.0 + 20.0;
    g.wall(&[[-far, -0.1], [8.1, -0.1], [8.1, 11.9], [far + 8.0, 11.9]]);
    g.wall(&[[-far, 8.1], [-0.1, 8.1], [-0.1, 20.1], [far + 8.0, 20.1]]);
    let length = count as f32 / 8.0;
    g.group(count, [-1.0 - length, 0.1, -1.0, 7.9], [length, 12.5, length + 15.0, 19.5]);
    g.group(count, [9.0, 12.1, 9.0 + length, 19.9], [-length - 12.0, 0.5, -length + 3.0, 7.5]);
    g
}

/// Three arms or four, each 10 m wide; everybody from one arm to the next (to the opposite one, of four).
pub fn crossing(seed: u64, people: People, arms: usize, count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let (a, far) = (5.1, count as f32 / 10.0 + 30.0);
    for (x, z) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        if arms == 4 || z > 0.0 {
            g.wall(&[[x * far, z * a], [x * a, z * a], [x * a, z * far]]);
        }
    }
    if arms == 3 {
        g.wall(&[[-far, -a], [far, -a]]);
    }
    let near = |n: f32, f: f32| [[-f, -4.7, -n, 4.7], [n, -4.7, f, 4.7], [-4.7, n, 4.7, f], [-4.7, -f, 4.7, -n]];
    let length = count as f32 / 10.0;
    let (starts, goals) = (near(6.0, 6.0 + length), near(length, length + 20.0));
    let pairs: &[(usize, usize)] =
        if arms == 3 { &[(0, 1), (1, 2), (2, 0)] } else { &[(0, 1), (1, 0), (2, 3), (3, 2)] };
    for &(from, to) in pairs {
        g.group(count, starts[from], goals[to]);
    }
    g
}

/// A wall with doors across a street 20 m wide, both ways.
pub fn doors(seed: u64, people: People, (num, wide): (usize, f32), count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let far = count as f32 / 20.0 + 30.0;
    for z in [-10.1, 10.1] {
        g.wall(&[[-far, z], [far, z]]);
    }
    let pitch = 20.2 / num as f32;
    let mut from = -10.1;
    for i in 0..=num {
        let middle = -10.1 + (i as f32 + 0.5) * pitch;
        let to = if i == num { 10.1 } else { middle - 0.5 * wide };
        g.wall(&[[0.0, from], [0.0, to]]);
        from = middle + 0.5 * wide;
    }
    let length = count as f32 / 20.0;
    g.group(count, [-2.0 - length, -9.9, -2.0, 9.9], [length, -9.5, length + 15.0, 9.5]);
    g.group(count, [2.0, -9.9, 2.0 + length, 9.9], [-length - 15.0, -9.5, -length, 9.5]);
    g
}

/// Rooms in rows with doors by chance, all of which can be reached; everybody to another room.
pub fn rooms(seed: u64, people: People, count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let (n, side) = (3usize, 8.0f32);
    let size = n as f32 * side;
    g.wall(&[[0.0, 0.0], [size, 0.0], [size, size], [0.0, size], [0.0, 0.0]]);
    // Sides between rooms: those of a tree by chance have a door, and a third of the others.
    let mut group: Vec<usize> = (0..n * n).collect();
    let mut sides: Vec<(usize, usize)> = Vec::new();
    for i in 0..n * n {
        sides.extend((i % n + 1 < n).then_some((i, i + 1)));
        sides.extend((i / n + 1 < n).then_some((i, i + n)));
    }
    for k in (1..sides.len()).rev() {
        let other = (g.share() * (k + 1) as f32) as usize;
        sides.swap(k, other.min(k));
    }
    for (a, b) in sides {
        let joins = group[a] != group[b];
        let is_open = joins || g.share() < 0.4;
        if joins {
            let (old, new) = (group[b], group[a]);
            group.iter_mut().filter(|x| **x == old).for_each(|x| *x = new);
        }
        let low = Vec2::new((b % n) as f32, (b / n) as f32) * side;
        let along = if b == a + 1 { Vec2::Y } else { Vec2::X };
        let (wide, at) = (1.2 + 1.2 * g.share(), 1.0 + (side - 4.4) * g.share());
        if is_open {
            g.wall(&[low.into(), (low + along * at).into()]);
            g.wall(&[(low + along * (at + wide)).into(), (low + along * side).into()]);
        } else {
            g.wall(&[low.into(), (low + along * side).into()]);
        }
    }
    let area = |room: usize| {
        let (x, z) = ((room % n) as f32 * side, (room / n) as f32 * side);
        [x + 0.6, z + 0.6, x + side - 0.6, z + side - 0.6]
    };
    for room in 0..n * n {
        for _ in 0..count {
            let to = (room + 1 + (g.share() * (n * n - 1) as f32) as usize) % (n * n);
            g.group(1, area(room), area(to));
        }
    }
    g
}

/// A closed ring of a density (1/m2) and width (m), everybody around it, or every second one the other way.
pub fn ring(seed: u64, people: People, (density, width): (f32, f32), ways: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let (inner, outer, sides) = (12.0f32, 12.0 + width, 48);
    let middle = 0.5 * (inner + outer);
    let at = |i: usize, r: f32| Vec2::from_angle(TAU * (i % sides) as f32 / sides as f32) * r;
    for radius in [inner - 0.1, outer + 0.1] {
        let points: Vec<[f32; 2]> = (0..=sides).map(|i| at(i, radius).into()).collect();
        g.wall(&points);
    }
    let count = (density * std::f32::consts::PI * (outer * outer - inner * inner)) as usize;
    // Rings of agents one in the other, each with as many as it is long.
    let rows = ((outer - inner - 0.05) * density.sqrt().max(1.0)).round() as usize;
    let row = |k: usize| inner + 0.05 + (outer - inner - 0.1) * (k as f32 + 0.5) / rows as f32;
    let all: f32 = (0..rows).map(row).sum();
    let mut num = 0;
    for k in 0..rows {
        let in_row = (count as f32 * row(k) / all).round() as usize;
        let slack = (TAU * row(k) / in_row as f32 - 2.0 * people.radius_m[1] - 0.004).max(0.0) / row(k);
        let shift = g.share();
        for i in 0..in_row {
            let angle = TAU * (i as f32 + shift) / in_row as f32 + slack * (g.share() - 0.5);
            let first = (angle / TAU * sides as f32).ceil() as usize;
            let way =
                |i: usize| if num % ways == 0 { at(first + i, middle) } else { at(first + 2 * sides - 1 - i, middle) };
            let radius = people.radius_m[0] + (people.radius_m[1] - people.radius_m[0]) * g.share();
            g.agent((Vec2::from_angle(angle) * row(k), radius), (0..sides).map(way).collect(), AtEnd::Again);
            num += 1;
        }
    }
    g
}

/// Everybody on a disc to the opposite point.
pub fn circle(seed: u64, people: People, count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let radius = (count as f32 / (0.7 * std::f32::consts::PI)).sqrt();
    let mut out = 0;
    while out < count {
        let [(at, r)] = g.places(1, [-radius, -radius, radius, radius])[..] else { break };
        if at.length() < radius {
            g.agent((at, r), vec![-at], AtEnd::Leave);
            out += 1;
        }
    }
    g
}

/// Two streams cross at 90 degrees without walls.
pub fn streams(seed: u64, people: People, count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    let length = count as f32 / 10.0;
    g.group(count, [-7.0 - length, -5.0, -7.0, 5.0], [length, -5.0, length + 10.0, 5.0]);
    g.group(count, [-5.0, -7.0 - length, 5.0, -7.0], [-5.0, length, 5.0, length + 10.0]);
    g
}

/// A crowd before a gap in a wall.
pub fn gap(seed: u64, people: People, wide: f32, count: usize) -> Ground {
    let mut g = Ground::new(seed, people);
    g.wall(&[[0.0, 0.5 * wide], [0.0, 60.0]]);
    g.wall(&[[0.0, -0.5 * wide], [0.0, -60.0]]);
    let half = (0.5 * count as f32 / 1.2).sqrt();
    g.group(count, [-2.0 - half, -half, -2.0, half], [8.0, -5.0, 16.0, 5.0]);
    g
}
