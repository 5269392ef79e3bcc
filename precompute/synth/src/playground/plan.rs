//! Plan of a visitor of the gym: walks to an ascent, goes up, walks about on the deck, comes down, and repeats.

use super::gym::{self, CLOSE, DECK_A, DECK_B, ELBOWS, GymDeck, LEVEL, STAIRS_A, STAIRS_B, Stairs};
use super::route::{PathPenalty, WalkEnding, WalkRoute};
use super::{course::SlideCourse, ladder, slide};
use crate::{deck::CardDeck, walk::footsteps::FeetStance};
use glam::DVec2;
use rand::{Rng, RngExt};
use std::{f64::consts::PI, iter::successors};

/// A part of a visit.
pub enum VisitLeg {
    /// Walking, including stairs.
    Walk(Box<WalkRoute>),
    /// Climbing up the ladder.
    ClimbUp,
    /// Climbing down the ladder.
    ClimbDown,
    /// Sliding down a slide.
    Slide(SlideCourse),
}

/// Kind of ascent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AscentKind {
    StairsA,
    Ladder,
    StairsB,
}

/// Kind of descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DescentKind {
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
pub struct GymVisitor {
    ups: CardDeck<AscentKind>,
    downs_a: CardDeck<DescentKind>,
    downs_b: CardDeck<DescentKind>,
    variation: f64,
}

/// A visit under construction.
struct GymVisit<'a, R: Rng> {
    legs: Vec<VisitLeg>,
    route: WalkRoute,
    rng: &'a mut R,
}

impl GymVisitor {
    /// A dealer of visits whose steps vary by `variation` times the usual amount.
    pub fn new(variation: f64) -> Self {
        use AscentKind::{Ladder, StairsA, StairsB};
        use DescentKind::{Curved, Slide, Stairs};
        Self {
            ups: CardDeck::new(&[StairsA, Ladder, StairsA, Ladder, StairsB]),
            downs_a: CardDeck::new(&[Slide, Curved, Slide, Curved, Stairs, DescentKind::Ladder]),
            downs_b: CardDeck::new(&[Slide, Slide, Slide, Stairs]),
            variation,
        }
    }

    /// Legs of a visit of at least `seconds`, alternately walks and others, from standing to standing.
    pub fn visit(&mut self, seconds: f64, rng: &mut impl Rng) -> Vec<VisitLeg> {
        let at = DVec2::new(rng.random_range(-9.0..6.0), rng.random_range(-8.5..-5.8));
        let start = FeetStance { at, heading: rng.random_range(-PI..PI) };
        let route = WalkRoute::standing_at(start, self.variation, rng);
        let mut visit = GymVisit { legs: Vec::new(), route, rng };
        // A round takes about 40 s.
        while visit.legs.is_empty() && visit.route.walk.steps.is_empty() || visit.seconds() < seconds - 32.0 {
            self.add_round(&mut visit);
        }
        visit.finish()
    }

    /// Adds an ascent and a descent.
    fn add_round(&mut self, visit: &mut GymVisit<impl Rng>) {
        let up = self.ups.deal(visit.rng);
        let deck = match up {
            AscentKind::StairsA => visit.climb_stairs(&STAIRS_A),
            AscentKind::StairsB => visit.climb_stairs(&STAIRS_B),
            AscentKind::Ladder => visit.climb_ladder(),
        };
        if up == AscentKind::StairsB {
            match self.downs_b.deal(visit.rng) {
                DescentKind::Stairs => visit.descend_stairs(&STAIRS_B, &deck),
                _ => visit.slide(SlideCourse::straight(gym::SLIDE_B, DECK_B.level), &deck),
            }
        } else {
            match self.downs_a.deal(visit.rng) {
                DescentKind::Slide => visit.slide(SlideCourse::straight(gym::SLIDE_A, LEVEL), &deck),
                DescentKind::Curved => visit.slide(SlideCourse::curved(gym::SLIDE_CURVED, LEVEL), &deck),
                DescentKind::Ladder => visit.descend_ladder(&deck),
                DescentKind::Stairs => visit.descend_stairs(&STAIRS_A, &deck),
            }
        }
    }
}

impl<R: Rng> GymVisit<'_, R> {
    /// Ends the walk, adds another leg, and stands at `next`.
    fn add_act(&mut self, leg: VisitLeg, next: FeetStance) {
        let next = WalkRoute::standing_at(next, self.route.walk.variation, self.rng);
        let walk = std::mem::replace(&mut self.route, next);
        self.legs.push(VisitLeg::Walk(Box::new(walk)));
        self.legs.push(leg);
    }

    /// Walks over the ground to a stance.
    fn walk_to(&mut self, goal: FeetStance, arrival: WalkEnding) {
        let mut jitter = || self.rng.random_range(-0.35..0.35);
        let places: Vec<DVec2> =
            lookout_path(self.route.at.at, goal.at).into_iter().map(|p| p + DVec2::new(jitter(), jitter())).collect();
        for (i, &at) in places.iter().enumerate() {
            let next = places.get(i + 1).copied().unwrap_or(goal.at) - at;
            let goal = FeetStance { at, heading: next.x.atan2(next.y) };
            self.walk(goal, WalkEnding::Pass, &ground_penalty);
        }
        self.walk(goal, arrival, &ground_penalty);
    }

    /// Walks on a deck to a stance, occasionally with a stop on the way.
    fn stroll(&mut self, goal: FeetStance, deck: &GymDeck, arrival: WalkEnding) {
        let against = |p: DVec2| place_penalty(deck.contains(p, CLOSE), deck.contains(p, ELBOWS));
        let begin = self.route.at.at;
        if (goal.at - begin).length() < 1.5 || self.rng.random_bool(0.35) {
            let size = deck.max - deck.min - 1.6;
            let places = (0..40).map(|_| deck.min + 0.8 + size * DVec2::new(self.rng.random(), self.rng.random()));
            let near = |p: &DVec2| (*p - begin).length().min((*p - goal.at).length()).min(1.6);
            let at = places.max_by(|a, b| near(a).total_cmp(&near(b))).unwrap_or(goal.at);
            let heading = self.rng.random_range(-PI..PI);
            self.walk(FeetStance { at, heading }, WalkEnding::Stand, &against);
        }
        self.walk(goal, arrival, &against);
    }

    /// Walks to a stance; close to both ends there are no penalties.
    fn walk(&mut self, goal: FeetStance, arrival: WalkEnding, against: PathPenalty) {
        let begin = self.route.at.at;
        let near = |p: DVec2| (p - goal.at).length() < 0.6 || (p - begin).length() < 0.6;
        self.route.walk_to(goal, arrival, &|p| if near(p) { 0.0 } else { against(p) }, self.rng);
        if self.route.is_standing() {
            self.route.walk.pause = self.rng.random_range(0.5..1.8);
        }
    }

    /// Approximate duration so far (s).
    fn seconds(&self) -> f64 {
        let leg = |leg: &VisitLeg| if let VisitLeg::Walk(route) = leg { route.seconds() } else { 8.0 };
        self.legs.iter().map(leg).sum::<f64>() + self.route.seconds()
    }

    fn arrival(&mut self) -> WalkEnding {
        if self.rng.random_bool(0.5) { WalkEnding::Stand } else { WalkEnding::Pass }
    }

    fn climb_stairs(&mut self, stairs: &Stairs) -> GymDeck {
        let aside = self.rng.random_range(-0.25..0.25);
        let arrival = self.arrival();
        self.walk_to(gym::tread_up(stairs, aside, 0), arrival);
        self.route.climb(stairs, aside, self.rng);
        if stairs.num_steps == STAIRS_A.num_steps { DECK_A } else { DECK_B }
    }

    fn descend_stairs(&mut self, stairs: &Stairs, deck: &GymDeck) {
        let aside = self.rng.random_range(-0.25..0.25);
        let arrival = self.arrival();
        self.stroll(gym::tread_down(stairs, aside, 0), deck, arrival);
        self.route.descend(stairs, aside, self.rng);
    }

    fn climb_ladder(&mut self) -> GymDeck {
        self.walk_to(ladder::stance(ladder::FOOT), WalkEnding::Stand);
        self.add_act(VisitLeg::ClimbUp, ladder::stance(ladder::HEAD));
        DECK_A
    }

    fn descend_ladder(&mut self, deck: &GymDeck) {
        let goal = ladder::stance(ladder::HEAD);
        self.stroll(FeetStance { heading: PI, ..goal }, deck, WalkEnding::Stand);
        self.route.turn_round(self.rng);
        self.add_act(VisitLeg::ClimbDown, ladder::stance(ladder::FOOT));
    }

    fn slide(&mut self, course: SlideCourse, deck: &GymDeck) {
        self.stroll(course.ground_stance(slide::BEFORE), deck, WalkEnding::Stand);
        self.add_act(VisitLeg::Slide(course), slide::stance_beyond(&course));
    }

    /// Walks a few steps further and stops.
    fn finish(mut self) -> Vec<VisitLeg> {
        let at = self.route.at;
        let to_lookout = |p: &DVec2| (*p - at.at).length();
        let nearest = LOOKOUTS.into_iter().min_by(|a, b| to_lookout(a).total_cmp(&to_lookout(b)));
        let direction = nearest.map_or(DVec2::Y, |p| (p - at.at).normalize_or(DVec2::Y));
        let goal = FeetStance { at: at.at + direction * 2.4, heading: direction.x.atan2(direction.y) };
        self.walk(goal, WalkEnding::Stand, &ground_penalty);
        self.legs.push(VisitLeg::Walk(Box::new(self.route)));
        self.legs
    }
}

/// Penalty of a place on the ground.
fn ground_penalty(p: DVec2) -> f64 {
    place_penalty(gym::is_free(p, CLOSE), gym::is_free(p, ELBOWS))
}

/// Penalty of a place that may be impossible, or uncomfortable.
fn place_penalty(possible: bool, comfortable: bool) -> f64 {
    match (possible, comfortable) {
        (false, _) => 100.0,
        (true, false) => 0.25,
        (true, true) => 0.0,
    }
}

/// Shortest path over the ground by waypoints, without its ends.
fn lookout_path(from: DVec2, to: DVec2) -> Vec<DVec2> {
    let nodes = [&[from, to], LOOKOUTS.as_slice()].concat();
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
            if through < cost[j] && is_line_clear(nodes[i], nodes[j]) {
                (cost[j], before[j]) = (through, i);
            }
        }
    }
    let mut out: Vec<DVec2> =
        successors(Some(before[1]), |at| Some(before[*at])).take_while(|at| *at != 0).map(|at| nodes[at]).collect();
    out.reverse();
    out
}

/// True if no obstacle is between two places; obstacles close to either end are ignored.
fn is_line_clear(a: DVec2, b: DVec2) -> bool {
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
            slide::stance_beyond(&SlideCourse::straight(gym::SLIDE_A, LEVEL)).at,
            slide::stance_beyond(&SlideCourse::curved(gym::SLIDE_CURVED, LEVEL)).at,
            slide::stance_beyond(&SlideCourse::straight(gym::SLIDE_B, DECK_B.level)).at,
            gym::tread_down(&STAIRS_A, 0.0, 13).at,
            ladder::stance(ladder::FOOT).at,
        ];
        let starts =
            [gym::tread_up(&STAIRS_A, 0.0, 0).at, gym::tread_up(&STAIRS_B, 0.0, 0).at, ladder::stance(ladder::FOOT).at];
        for from in ends.into_iter().chain(LOOKOUTS) {
            for to in starts {
                let mut at = from;
                for next in lookout_path(from, to).into_iter().chain([to]) {
                    assert!(is_line_clear(at, next), "{from} to {to}: {at} {next}");
                    at = next;
                }
            }
        }
    }
}
