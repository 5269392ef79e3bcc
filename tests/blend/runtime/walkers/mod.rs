//! Walkers stay on their trajectories with planted feet, for any speed, direction, body and ground.

mod feet;
mod ground;
mod group;
mod inertia;
mod paths;
mod state;

use super::made_up::MadeUp;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use throng_core::body::HeightField;
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{
    CharacterGroup, Contacts, Error, Executor, Id, Inline, Joint, Mat3x4, OrderStatus, Planar, Rayon, Skeleton,
};

const DT_S: f32 = 1.0 / 60.0;

/// The default skeleton, larger or smaller, with longer or shorter legs.
fn body(size: f32, legs: f32) -> Skeleton {
    let mut s = Skeleton::default();
    s.offsets.iter_mut().chain(&mut s.tips).for_each(|o| *o *= size);
    for j in [Joint::LeftShin, Joint::LeftFoot, Joint::RightShin, Joint::RightFoot] {
        let longer = s.offsets[j.index()].y * (legs - 1.0);
        s.offsets[j.index()].y += longer;
        s.offsets[0].y -= 0.5 * longer;
    }
    s
}

fn bodies() -> [Skeleton; 5] {
    [body(1.0, 1.0), body(0.6, 1.0), body(1.25, 1.0), body(1.0, 1.2), body(0.9, 0.85)]
}

/// Velocity and heading of a walker over time: (number, seconds) to (velocity, heading).
type Course = fn(usize, f32) -> (Vec2, Option<f32>);

/// Walkers of all bodies on a course.
#[derive(Clone)]
struct Outing {
    walkers: Walkers,
    ids: Vec<Id>,
    positions: Vec<Vec2>,
    time_s: f32,
}

impl Outing {
    fn new(made_up: &MadeUp, config: WalkersConfig, n: usize) -> Self {
        let mut walkers = Walkers::with_capacity(made_up.space(), &bodies(), config, n).expect("walkers");
        let ids = (0..n).map(|c| walkers.spawn(start(c)).expect("room")).collect();
        Self { walkers, ids, positions: (0..n).map(|c| Vec2::new(4.0 * c as f32, 0.0)).collect(), time_s: 0.0 }
    }

    fn step(&mut self, course: Course) {
        self.step_on(course, &Inline);
    }

    fn step_on(&mut self, course: Course, run: &dyn Executor) {
        self.time_s += DT_S;
        for (c, (id, position)) in self.ids.iter().zip(&mut self.positions).enumerate() {
            let (velocity, heading) = course(c, self.time_s);
            *position += velocity * DT_S;
            let control = Control { position: Some(*position), velocity, heading, ..Control::default() };
            self.walkers.order(*id, control).expect("an order");
        }
        self.walkers.step(DT_S, run).expect("a step");
    }
}

fn start(c: usize) -> WalkerStart {
    WalkerStart { body: c % 5, root: Planar::new(4.0 * c as f32, 0.0, 0.0), phase: 0.37 * c as f32 }
}

/// World positions of the bottom of the heel, and of the ground below the toe joint on a flat foot.
fn sole(walkers: &Walkers, character: usize, side: usize) -> [Vec3; 2] {
    let s = &bodies()[character % 5];
    let (foot, toe) = [(Joint::LeftFoot, Joint::LeftToe), (Joint::RightFoot, Joint::RightToe)][side];
    let rest = s.rest_positions();
    let ball = s.offsets[toe.index()];
    let root = walkers.root(character);
    let pose = walkers.pose(character)[foot.index()];
    let [heel, ball] = [Vec3::new(0.0, -rest[foot.index()].y, -0.3 * ball.z), ball].map(|p| {
        let m = pose.translation() + pose.rotation() * p;
        root.rotation() * m + root.translation()
    });
    [heel, ball - Vec3::Y * rest[toe.index()].y]
}

const FEET: [Contacts; 2] = [Contacts::LEFT, Contacts::RIGHT];

/// Speed over the ground of the slower end of planted feet, 95th percentile (m/s).
fn slip_p95(made_up: &MadeUp, course: Course, seconds: f32) -> f32 {
    let mut outing = Outing::new(made_up, WalkersConfig::default(), 10);
    let mut speeds = Vec::new();
    let mut before: Vec<Option<[Vec3; 2]>> = vec![None; 20];
    while outing.time_s < seconds {
        outing.step(course);
        for c in 0..10 {
            for side in 0..2 {
                let now = sole(&outing.walkers, c, side);
                let down = outing.walkers.contacts(c).any(FEET[side]);
                let was = std::mem::replace(&mut before[2 * c + side], down.then_some(now));
                if let (true, Some(was)) = (down, was) {
                    let moved = |k: usize| Vec2::new(now[k].x - was[k].x, now[k].z - was[k].z).length();
                    speeds.push(moved(0).min(moved(1)) / DT_S);
                }
            }
        }
    }
    speeds.sort_by(f32::total_cmp);
    assert!(speeds.len() > 1000, "{} are too few to prove anything", speeds.len());
    speeds[speeds.len() * 95 / 100]
}

fn wandering(c: usize, t: f32) -> (Vec2, Option<f32>) {
    let speed = 1.2 + 0.9 * (0.9 * t + c as f32).sin();
    let heading = 1.5 * (0.4 * t + 0.7 * c as f32).sin();
    (speed * Vec2::new(heading.sin(), heading.cos()), None)
}

/// Other speeds and directions from one tick to the next.
fn jumping(c: usize, t: f32) -> (Vec2, Option<f32>) {
    let k = ((t / 0.7) as usize + 3 * c) % 7;
    let speed = [0.0, 1.0, 3.5, 0.5, 5.0, 1.5, 2.5][k];
    let heading: f32 = [0.0, 0.5, -0.6, 0.9, 0.2, -0.3, 1.4][(k + c) % 7];
    (speed * Vec2::new(heading.sin(), heading.cos()), None)
}
