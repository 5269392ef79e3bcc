//! Orders that an application gives to people of a scene, whatever moves them.

use crate::agents::Disc;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::error::{check_index, check_value};
use throng_base::thresholds::{DIRECTION_SHOWN_MPS, STANDING_MPS};
use throng_base::{Id, Result, maths};

/// Distance from a goal at which a person has arrived, and usual distance to whom it follows (m).
const ARRIVAL_M: f32 = 0.5;
const KEEP_M: f32 = 1.5;
/// Distance from whom it follows at which a person who stands goes on, over that at which it stops.
const LEFT_BEHIND: f32 = 1.3;
/// Time for which a steered person is sent ahead (s), and the least distance (m).
const STEERS_S: f32 = 2.0;
const STEERS_M: f32 = 1.5;

/// Order to a person, see [`crate::Simulation::order`].
///
/// ```
/// use throng_simulation::Order;
///
/// let to_platform = Order::go(glam::Vec3::new(4.0, 0.0, 9.0)).at_speed(1.4).arrive_facing(0.5);
/// let after_the_first = Order::follow(0).keeping(2.0);
/// assert_ne!(to_platform, after_the_first);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    task: OrderTask,
    keep_m: f32,
    pub(crate) speed_mps: Option<f32>,
    pub(crate) heading: Option<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum OrderTask {
    Go(Vec3),
    Follow(usize),
    Steer(Vec2),
    Stop,
}

impl Order {
    fn new(task: OrderTask) -> Self {
        Self { task, keep_m: KEEP_M, speed_mps: None, heading: None }
    }

    /// To go to a place (m), round what is in the way.
    pub fn go(place: Vec3) -> Self {
        Self::new(OrderTask::Go(place))
    }

    /// To follow the person of a number, and to stand near it where it stands.
    pub fn follow(whom: usize) -> Self {
        Self::new(OrderTask::Follow(whom))
    }

    /// To walk on at a velocity along x and z (m/s), as a player steers.
    pub fn steer(velocity: Vec2) -> Self {
        Self::new(OrderTask::Steer(velocity))
    }

    /// To stop, and to stand there.
    pub fn stop() -> Self {
        Self::new(OrderTask::Stop)
    }

    /// To stop, and to turn to a heading about +Y from +Z (rad).
    pub fn turn_to(heading: f32) -> Self {
        Self::stop().arrive_facing(heading)
    }

    /// Sets the distance that is kept to whom it follows (m); by default 1.5 m.
    pub fn keeping(self, keep_m: f32) -> Self {
        Self { keep_m, ..self }
    }

    /// Sets the desired speed from now on (0.01 to 100 m/s). Captured people walk or run, whichever is usually nearer to it.
    pub fn at_speed(self, speed_mps: f32) -> Self {
        Self { speed_mps: Some(speed_mps), ..self }
    }

    /// Sets the heading at the goal, about +Y from +Z (rad).
    pub fn arrive_facing(self, heading: f32) -> Self {
        Self { heading: Some(heading), ..self }
    }

    pub(crate) fn check(&self, who: usize, num: usize) -> Result<()> {
        check_index("person", None, who, num)?;
        let id = Some(Id::first(who));
        let along = match self.task {
            OrderTask::Go(place) => place,
            OrderTask::Steer(velocity) => {
                let good = velocity.is_finite() && velocity.length() < 100.0;
                check_value("velocity", id, velocity.length(), good, "finite, below 100 m/s")?;
                Vec3::ZERO
            }
            OrderTask::Follow(whom) => {
                check_index("whom it follows,", id, whom, num)?;
                check_value("whom it follows", id, whom as f64, whom != who, "somebody else")?;
                Vec3::ZERO
            }
            OrderTask::Stop => Vec3::ZERO,
        };
        let good = |v: f32| v.abs() < 1e6;
        let worst = along.to_array().into_iter().find(|&v| !good(v));
        check_value("place", id, worst.unwrap_or(0.0), worst.is_none(), "finite, within 1e6 m")?;
        let [keep_m, speed] = [self.keep_m, self.speed_mps.unwrap_or(1.0)];
        check_value("keep_m", id, keep_m, (0.1..1e3).contains(&keep_m), "0.1 to 1000 m")?;
        check_value("speed_mps", id, speed, (0.01..100.0).contains(&speed), "0.01 to 100 m/s")?;
        let heading = self.heading.unwrap_or(0.0);
        check_value("heading", id, heading, heading.abs() < 1e6, "finite and within 1e6 rad")
    }

    /// Speed of this order (m/s), none for the person's own.
    pub(crate) fn speed_mps(&self) -> Option<f32> {
        match self.task {
            OrderTask::Steer(velocity) => Some(velocity.length()).filter(|speed| *speed > DIRECTION_SHOWN_MPS),
            _ => self.speed_mps,
        }
    }

    /// True for one that leads straight on.
    pub(crate) fn is_steered(&self) -> bool {
        matches!(self.task, OrderTask::Steer(_))
    }

    /// The order of who stands near another one, and faces it.
    pub(crate) fn facing(self, own: &Disc, other: Option<Vec3>) -> Self {
        let ahead = other.map(|at| maths::atan2(at.x - own.centre.x, at.z - own.centre.z));
        Self { heading: self.heading.or(ahead), ..self }
    }

    /// Number of the person that it is about.
    pub(crate) fn whom(&self) -> Option<usize> {
        if let OrderTask::Follow(whom) = self.task { Some(whom) } else { None }
    }

    /// True for an order whose goal moves.
    pub(crate) fn is_renewed(&self) -> bool {
        matches!(self.task, OrderTask::Follow(_) | OrderTask::Steer(_))
    }

    /// Goals to try in turn, and the distance from them at which it has arrived (m); none where it should stand.
    ///
    /// - `other`: whom it is about (m); none who has left.
    pub(crate) fn goals(&self, own: &Disc, other: Option<Vec3>) -> ([Option<Vec3>; 3], f32) {
        match self.task {
            OrderTask::Stop => ([None; 3], ARRIVAL_M),
            OrderTask::Go(place) => ([Some(place), None, None], ARRIVAL_M),
            OrderTask::Follow(_) => {
                let stands = own.velocity.length() < STANDING_MPS;
                let near_m = if stands { LEFT_BEHIND * self.keep_m } else { self.keep_m };
                ([other.filter(|at| at.distance(own.centre) > near_m), None, None], self.keep_m)
            }
            OrderTask::Steer(velocity) => {
                let speed = velocity.length();
                let by = Vec3::new(velocity.x, 0.0, velocity.y) * (STEERS_S.max(STEERS_M / speed.max(1e-3)));
                let ahead = |share| Some(own.centre + by * share).filter(|_| speed > DIRECTION_SHOWN_MPS);
                ([ahead(1.0), ahead(0.5), ahead(0.25)], 0.1)
            }
        }
    }
}
