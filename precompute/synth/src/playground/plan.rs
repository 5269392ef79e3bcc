//! Plan of a visitor of the gym: walks to an ascent, goes up, walks about on the deck, comes down, and repeats.

use super::super::deck::Deck as Pile;
use super::super::walk::footsteps::Stance;
use super::course::Course;
use super::gym::{self, CLOSE, DECK_A, DECK_B, Deck, ELBOWS, LEVEL, STAIRS_A, STAIRS_B, Stairs};
use super::route::{Against, Arrival, Route};
use super::{ladder, slide};
use glam::DVec2;
use rand::{Rng, RngExt};
use std::f64::consts::PI;

/// A part of a visit.
pub enum Leg {
    /// Walking, including stairs.
    Walk(Box<Route>),
    /// Climbing up the ladder.
    ClimbUp,
    /// Climbing down the ladder.
    ClimbDown,
    /// Sliding down a slide.
    Slide(Course),
}

/// Kind of ascent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Up {
    StairsA,
    Ladder,
    StairsB,
}

/// Kind of descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Down {
    Slide,
    Curved,
    Ladder,
    Stairs,
}

/// Waypoints from which the ground between obstacles is visible (m).
const LOOKOUTS: [DVec2; 11] = [
    DVec2::new(-2.8, 9.0),
    DVec2::new(-2.8, 1.4),
    DVec2::new(-2.8, -5.6),
    DVec2::new(2.4, 8.8),
    DVec2::new(7.6, 6.0),
    DVec2::new(7.6, -3.2),
    DVec2::new(2.6, 6.2),
    DVec2::new(-11.2, 7.0),
    DVec2::new(-11.2, -5.6),
    DVec2::new(-8.4, 12.0),
    DVec2::new(1.4, -6.0),
];

/// Dealer of visits. One serves all clips of a set, so that everything occurs about equally often.
pub struct Visitor {
    ups: Pile<Up>,
    downs_a: Pile<Down>,
    downs_b: Pile<Down>,
    variation: f64,
}

/// A visit under construction.
struct Visit<'a, R: Rng> {
    legs: Vec<Leg>,
    route: Route,
    variation: f64,
    rng: &'a mut R,
}

impl Visitor {
    /// A dealer of visits whose steps vary by `variation` times the usual amount.
    pub fn new(variation: f64) -> Self {
        Self {
            ups: Pile::new(&[Up::StairsA, Up::Ladder, Up::StairsA, Up::Ladder, Up::StairsB]),
            downs_a: Pile::new(&[Down::Slide, Down::Curved, Down::Slide, Down::Curved, Down::Stairs, Down::Ladder]),
            downs_b: Pile::new(&[Down::Slide, Down::Slide, Down::Slide, Down::Stairs]),
            variation,
        }
    }

    /// Legs of a visit of at least `seconds`, alternately walks and others, from standing to standing.
    pub fn visit(&mut self, seconds: f64, rng: &mut impl Rng) -> Vec<Leg> {
        let at = DVec2::new(rng.random_range(-9.0..6.0), rng.random_range(-8.5..-5.8));
        let start = Stance { at, heading: rng.random_range(-PI..PI) };
        let route = Route::from(start, self.variation, rng);
        let mut visit = Visit { legs: Vec::new(), route, variation: self.variation, rng };
        // A round takes about 40 s.
        while visit.is_fresh() || visit.seconds() < seconds - 32.0 {
            self.round(&mut visit);
        }
        visit.leave()
    }

    /// Adds an ascent and a descent.
    fn round(&mut self, visit: &mut Visit<impl Rng>) {
        let up = self.ups.deal(visit.rng);
        let deck = match up {
            Up::StairsA => visit.climb_stairs(&STAIRS_A),
            Up::StairsB => visit.climb_stairs(&STAIRS_B),
            Up::Ladder => visit.climb_ladder(),
        };
        if up == Up::StairsB {
            match self.downs_b.deal(visit.rng) {
                Down::Stairs => visit.descend_stairs(&STAIRS_B, &deck),
                _ => visit.slide(Course::straight(gym::SLIDE_B, DECK_B.level), &deck),
            }
        } else {
            match self.downs_a.deal(visit.rng) {
                Down::Slide => visit.slide(Course::straight(gym::SLIDE_A, LEVEL), &deck),
                Down::Curved => visit.slide(Course::curved(gym::SLIDE_CURVED, LEVEL), &deck),
                Down::Ladder => visit.descend_ladder(&deck),
                Down::Stairs => visit.descend_stairs(&STAIRS_A, &deck),
            }
        }
    }
}

impl<R: Rng> Visit<'_, R> {
    /// Ends the walk, adds another leg, and stands at `next`.
    fn act(&mut self, leg: Leg, next: Stance) {
        let walk = std::mem::replace(&mut self.route, Route::from(next, self.variation, self.rng));
        self.legs.push(Leg::Walk(Box::new(walk)));
        self.legs.push(leg);
    }

    /// Walks over the ground to a stance.
    fn cross(&mut self, goal: Stance, arrival: Arrival) {
        let places: Vec<DVec2> = way(self.route.at.at, goal.at).into_iter().map(|p| jittered(p, self.rng)).collect();
        for (i, &at) in places.iter().enumerate() {
            let next = places.get(i + 1).copied().unwrap_or(goal.at) - at;
            let goal = Stance { at, heading: next.x.atan2(next.y) };
            self.walk(goal, Arrival::Pass, &on_ground);
        }
        self.walk(goal, arrival, &on_ground);
    }

    /// Walks on a deck to a stance, occasionally with a stop on the way.
    fn stroll(&mut self, goal: Stance, deck: &Deck, arrival: Arrival) {
        let against = |p: DVec2| against(deck.contains(p, CLOSE), deck.contains(p, ELBOWS));
        let begin = self.route.at.at;
        if (goal.at - begin).length() < 1.5 || self.rng.random_bool(0.35) {
            let size = deck.max - deck.min - 1.6;
            let places = (0..40).map(|_| deck.min + 0.8 + size * DVec2::new(self.rng.random(), self.rng.random()));
            let near = |p: &DVec2| (*p - begin).length().min((*p - goal.at).length()).min(1.6);
            let at = places.max_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(goal.at);
            let heading = self.rng.random_range(-PI..PI);
            self.walk(Stance { at, heading }, Arrival::Stand, &against);
        }
        self.walk(goal, arrival, &against);
    }

    /// Walks to a stance; close to both ends there are no penalties.
    fn walk(&mut self, goal: Stance, arrival: Arrival, against: Against) {
        let begin = self.route.at.at;
        let near = |p: DVec2| (p - goal.at).length() < 0.6 || (p - begin).length() < 0.6;
        self.route.to(goal, arrival, &|p| if near(p) { 0.0 } else { against(p) }, self.rng);
        if self.route.stands() {
            self.route.walk.pause = self.rng.random_range(0.5..1.8);
        }
    }

    /// True at the beginning.
    fn is_fresh(&self) -> bool {
        self.legs.is_empty() && self.route.walk.steps.is_empty()
    }

    /// Approximate duration so far (s).
    fn seconds(&self) -> f64 {
        let leg = |leg: &Leg| match leg {
            Leg::Walk(route) => route.seconds(),
            _ => 8.0,
        };
        self.legs.iter().map(leg).sum::<f64>() + self.route.seconds()
    }

    fn arrival(&mut self) -> Arrival {
        if self.rng.random_bool(0.5) { Arrival::Stand } else { Arrival::Pass }
    }

    fn climb_stairs(&mut self, stairs: &Stairs) -> Deck {
        let aside = self.rng.random_range(-0.25..0.25);
        let arrival = self.arrival();
        self.cross(gym::tread_up(stairs, aside, 0), arrival);
        self.route.climb(stairs, aside, self.rng);
        if self.rng.random_bool(0.5) {
            self.route.rest(self.rng);
        }
        if stairs.num_steps == STAIRS_A.num_steps { DECK_A } else { DECK_B }
    }

    fn descend_stairs(&mut self, stairs: &Stairs, deck: &Deck) {
        let aside = self.rng.random_range(-0.25..0.25);
        let arrival = self.arrival();
        self.stroll(gym::tread_down(stairs, aside, 0), deck, arrival);
        self.route.descend(stairs, aside, self.rng);
        if self.rng.random_bool(0.5) {
            self.route.rest(self.rng);
        }
    }

    fn climb_ladder(&mut self) -> Deck {
        self.cross(ladder::stance(ladder::FOOT), Arrival::Stand);
        self.act(Leg::ClimbUp, ladder::stance(ladder::HEAD));
        DECK_A
    }

    fn descend_ladder(&mut self, deck: &Deck) {
        let goal = ladder::stance(ladder::HEAD);
        self.stroll(Stance { heading: PI, ..goal }, deck, Arrival::Stand);
        self.route.turn_round(self.rng);
        self.act(Leg::ClimbDown, ladder::stance(ladder::FOOT));
    }

    fn slide(&mut self, course: Course, deck: &Deck) {
        self.stroll(slide::before(&course), deck, Arrival::Stand);
        self.act(Leg::Slide(course), slide::beyond(&course));
    }

    /// Walks a few steps further and stops.
    fn leave(mut self) -> Vec<Leg> {
        let at = self.route.at;
        let to_lookout = |p: &DVec2| (*p - at.at).length();
        let nearest = LOOKOUTS.into_iter().min_by(|a, b| to_lookout(a).total_cmp(&to_lookout(b)));
        let way = nearest.map_or(DVec2::Y, |p| (p - at.at).normalize_or(DVec2::Y));
        let goal = Stance { at: at.at + way * 2.4, heading: way.x.atan2(way.y) };
        self.walk(goal, Arrival::Stand, &on_ground);
        self.legs.push(Leg::Walk(Box::new(self.route)));
        self.legs
    }
}

/// Penalty of a place on the ground.
fn on_ground(p: DVec2) -> f64 {
    against(gym::is_free(p, CLOSE), gym::is_free(p, ELBOWS))
}

/// Penalty of a place that may be impossible, or uncomfortable.
fn against(possible: bool, comfortable: bool) -> f64 {
    match (possible, comfortable) {
        (false, _) => 100.0,
        (true, false) => 0.25,
        (true, true) => 0.0,
    }
}

fn jittered(p: DVec2, rng: &mut impl Rng) -> DVec2 {
    p + DVec2::new(rng.random_range(-0.35..0.35), rng.random_range(-0.35..0.35))
}

/// Shortest path over the ground by waypoints, without its ends.
fn way(from: DVec2, to: DVec2) -> Vec<DVec2> {
    let mut nodes = vec![from, to];
    nodes.extend(LOOKOUTS);
    let mut cost = vec![f64::INFINITY; nodes.len()];
    let mut before = vec![0; nodes.len()];
    let mut done = vec![false; nodes.len()];
    cost[0] = 0.0;
    while let Some(i) =
        (0..nodes.len()).filter(|i| !done[*i] && cost[*i] < 1e9).min_by(|a, b| cost[*a].total_cmp(&cost[*b]))
    {
        done[i] = true;
        for j in 0..nodes.len() {
            let through = cost[i] + (nodes[i] - nodes[j]).length();
            if through < cost[j] && sees(nodes[i], nodes[j]) {
                (cost[j], before[j]) = (through, i);
            }
        }
    }
    let mut out = Vec::new();
    let mut at = before[1];
    while at != 0 {
        out.push(nodes[at]);
        at = before[at];
    }
    out.reverse();
    out
}

/// True if no obstacle is between two places; obstacles close to either end are ignored.
fn sees(a: DVec2, b: DVec2) -> bool {
    let length = (b - a).length();
    (1..(length / 0.15) as usize).all(|k| {
        let at = 0.15 * k as f64;
        at < 0.7 || at > length - 0.7 || gym::is_free(a + (b - a) * (at / length), ELBOWS)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_down_leads_to_every_way_up() {
        let ends = [
            slide::beyond(&Course::straight(gym::SLIDE_A, LEVEL)).at,
            slide::beyond(&Course::curved(gym::SLIDE_CURVED, LEVEL)).at,
            slide::beyond(&Course::straight(gym::SLIDE_B, DECK_B.level)).at,
            gym::tread_down(&STAIRS_A, 0.0, 13).at,
            ladder::stance(ladder::FOOT).at,
        ];
        let starts =
            [gym::tread_up(&STAIRS_A, 0.0, 0).at, gym::tread_up(&STAIRS_B, 0.0, 0).at, ladder::stance(ladder::FOOT).at];
        for from in ends.into_iter().chain(LOOKOUTS) {
            for to in starts {
                let mut at = from;
                for next in way(from, to).into_iter().chain([to]) {
                    assert!(sees(at, next), "{from} to {to}: {at} {next}");
                    at = next;
                }
            }
        }
    }
}
