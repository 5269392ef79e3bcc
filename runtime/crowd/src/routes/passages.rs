//! Passages: doors, gaps and corridors that are too narrow for two who meet.
//!
//! They are found from what stands. Each is granted to one direction at a time: who goes the other way waits beside the
//! mouth and leaves those who come out a lane. Where people wait on both sides, directions take turns, and nobody enters
//! until the last one is out. Turns change only when the density grid is filled: so all who decide in between know the same.

use super::streets::{ALL_HEIGHTS, Streets};
use glam::Vec2;
use serde::{Deserialize, Serialize};
use throng_base::ground::is_one_floor;
use throng_geometry::{Bounds2d, BoxGrid, nearest_on_segment};

/// Widths below which two people, and streams of them, block each other, in radii.
const NARROW_RADII: [f32; 2] = [4.4, 5.3];
/// Rise of a part of a wall from which it stands beside stairs, or a ramp (m).
const STAIRS_M: f32 = 0.3;
/// Width of stairs that a level's walls, on the edges of voxels, may leave out (m).
const RAGGED_M: f32 = 0.2;
/// Widest door of a cabin: one side waits there until the other has come out (m).
const CABIN_DOOR_M: f32 = 2.2;
/// Largest free distance in a cabin, less the clearance (m).
const CABIN_M: f32 = 2.0;
/// Half of the length of the passage through its door (m).
const IN_DOOR_M: f32 = 0.3;
/// Distance between the points of a middle line (m).
const STEP_M: f32 = 0.1;
/// Most points of a middle line.
const MOST_POINTS: usize = 2000;
/// Largest cosine between the path and the direction to a wall for the wall to be beside it.
const BESIDE: f32 = 0.8;
/// Distance of mouths between which nobody can wait, in radii: two passages are one there.
const JOINED_RADII: f32 = 4.0;
/// Distance from a mouth within which those who want in wait (m).
const NEAR_M: f32 = 6.0;
/// Distance within which they stand; behind, they queue (m).
const STAND_M: f32 = 3.0;
/// Distance within which they gather before they enter, and how many may: more would wedge each other there (m).
pub(crate) const GATHER_M: f32 = 1.5;
const MOST_GATHERED: u32 = 5;
/// Distance from a mouth that those who wait for others keep (m).
const KEPT_FREE_M: f32 = 2.1;
/// Length of the lane that they leave to those who come out (m).
const LANE_M: f32 = 5.0;
/// Room beside those who come out (m).
const LANE_ROOM_M: f32 = 0.15;
/// Least and largest distance from a closed door at which people wait (m).
const DOOR_M: [f32; 2] = [0.8, 2.2];
/// Share of that range by which one stands before the next: the golden ratio.
const GOLDEN: f32 = 0.618_034;
/// Distance from the middle of the lane within which those who stand make room for others who leave it (m).
const SPREAD_M: f32 = 1.6;
/// Distance of places at the corners of a mouth from its edge: who goes round one of them goes in (m).
const CORNER_M: f32 = 0.6;
/// Duration of a turn of agents, and what a metre of the passage adds to it (s).
pub(crate) const TURN_S: f64 = 10.0;
const TURN_PER_M_S: f64 = 0.8;

/// A passage.
#[derive(Clone, Debug)]
struct Passage {
    /// Middle line from one mouth to the other (at least two points).
    line: Vec<LinePoint>,
    /// Length of the line (m).
    length: f32,
    /// Largest distance of a wall from the line (m).
    half_width: f32,
    /// Least width (m).
    narrowest: f32,
    /// End to which people go who come out of a cabin: a lift, a booth.
    out_first: Option<bool>,
}

/// Point of a middle line.
#[derive(Clone, Copy, Debug)]
struct LinePoint {
    at: Vec2,
    /// Lowest and highest ground at the walls beside it (m).
    floor: [f32; 2],
}

/// All passages of some streets.
#[derive(Clone, Debug, Default)]
pub(crate) struct Passages {
    all: Vec<Passage>,
    /// Boxes around all places from which each may be used.
    boxes: Option<BoxGrid>,
}

/// Turns of a passage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PassageTurn {
    /// End to which it is granted: the first or the second.
    towards: Option<bool>,
    /// True where nobody enters until it is empty.
    closes: bool,
    /// Time at which the turn began (s).
    since_s: f64,
    /// People who gather before either mouth, by the end to which they go.
    gathered: [u32; 2],
}

/// People in a passage and before it, by the end to which they go.
#[derive(Clone, Copy, Debug, Default)]
struct PassageCount {
    inside: [u32; 2],
    near: [u32; 2],
    gathered: [u32; 2],
}

/// Turns of all passages.
#[derive(Clone, Debug, Default)]
pub(crate) struct PassageTurns {
    turns: Vec<PassageTurn>,
    counts: Vec<PassageCount>,
    /// Duration of a turn in a short passage (s).
    turn_s: f64,
}

/// A passage on somebody's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PassageUse {
    number: usize,
    /// True for one who goes to the second end.
    towards: bool,
    pub is_inside: bool,
    /// Distance from the mouth by which it enters; 0 inside (m).
    pub distance: f32,
    /// Least width of the passage (m).
    pub narrowest: f32,
    /// That mouth (m), or inside the nearest place of the middle line, and the unit vector out of the passage there.
    mouth: Vec2,
    out: Vec2,
}

impl PassageUse {
    /// True for somebody outside of the passage who enters it by the same mouth as another.
    pub fn is_before(&self, other: &Self) -> bool {
        (self.number, self.towards, self.is_inside) == (other.number, other.towards, false)
    }

    /// Advice to leave the ground before the mouth to others.
    pub fn give_way_from_mouth(&self, at: Vec2) -> PassageAdvice {
        PassageAdvice::GiveWay((at - self.mouth).normalize_or(self.out), 0.5)
    }
}

/// Advice to somebody on whose way a passage is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PassageAdvice {
    /// The passage is granted.
    Enter,
    /// Go on as far as others let one.
    Queue,
    /// Wait here.
    Stand,
    /// Give way, along a unit vector and with a share of the usual speed.
    GiveWay(Vec2, f32),
}

/// Ends of a closed door before which people wait (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClosedDoor(pub [Vec2; 2]);

impl ClosedDoor {
    /// Distance of a place from it (m).
    pub fn distance(&self, at: Vec2) -> f32 {
        nearest_on_segment(at, self.0).distance(at)
    }

    /// Middle (m).
    pub fn middle(&self) -> Vec2 {
        self.0[0].midpoint(self.0[1])
    }

    /// Advice to somebody of a number and a radius (m) who waits for it to open: each stands at a distance of its own, and beside
    /// the lane of those who will come out.
    ///
    /// - `is_free`: true for a place to which it can step aside.
    pub fn advise(&self, number: usize, at: Vec2, radius: f32, is_free: impl Fn(Vec2) -> bool) -> PassageAdvice {
        let (distance, share) = (self.distance(at), (number as f32 * GOLDEN).fract());
        let half = 0.5 * (self.0[1] - self.0[0]);
        let (along, half_width) = (half.normalize_or(Vec2::X), half.length());
        let aside = (at - self.middle()).dot(along);
        let missing = half_width.min(SPREAD_M) + radius + LANE_ROOM_M - aside.abs();
        let away = if aside < 0.0 { -along } else { along };
        if missing > 0.0 && distance < STAND_M && is_free(at + away * missing) {
            PassageAdvice::GiveWay(away, 0.5)
        } else if distance > DOOR_M[0] + (DOOR_M[1] - DOOR_M[0]) * share {
            PassageAdvice::Queue
        } else {
            PassageAdvice::Stand
        }
    }
}

/// Nearest walls on both sides of a way (m).
#[derive(Clone, Copy)]
struct WallsBeside {
    left_m: f32,
    right_m: f32,
    /// Direction from the right wall to the left one.
    across: Vec2,
    /// Lowest and highest ground beside them (m).
    floor: [f32; 2],
    /// True where stairs, or a ramp, are beside it or begin there.
    has_stairs: bool,
}

impl Passages {
    /// Finds the passages for people of a radius, in which two cannot meet (m).
    pub fn find(streets: &Streets, radius_m: f32) -> Self {
        Self::find_below(streets, radius_m, &NARROW_RADII.map(|radii| radii * radius_m), 0.0)
    }

    /// Finds the passages for people of a radius (m): those below the first width, then others below the next.
    ///
    /// - `below_m`: widths below which gaps are passages (m).
    /// - `stairs_m`: width below which stairs belong to the passage that they lead to (m).
    pub fn find_below(streets: &Streets, radius_m: f32, below_m: &[f32], stairs_m: f32) -> Self {
        let (mut all, num_classes): (Vec<Passage>, _) = (Vec::new(), below_m.len());
        for (class, &below_m) in below_m.iter().chain(&[CABIN_DOOR_M]).enumerate() {
            let gap = NarrowGap { streets, narrowest_m: 2.0 * radius_m, below_m, stairs_m: stairs_m.max(below_m) };
            let widths = |floor| [gap.narrowest_m, if is_stairs(floor) { below_m - RAGGED_M } else { below_m }];
            streets.visit_narrow_gaps(widths, |middle, across, floor| {
                let [first, second] = [across.perp(), -across.perp()].map(|out| streets.is_cabin(middle, out, CABIN_M));
                let out_first = (first != second).then_some(first);
                let is_used = class < num_classes || out_first.is_some();
                if is_used && !all.iter().any(|passage| passage.holds(middle, floor)) {
                    let walls = out_first.and_then(|_| gap.walls_beside(middle, across.perp(), CABIN_DOOR_M, floor));
                    let found = match walls {
                        // A cabin may be as narrow as its door: its passage is no longer than a wall is thick.
                        Some(walls) => {
                            let place = |out: f32| LinePoint { at: middle + across.perp() * out, floor };
                            let line = [IN_DOOR_M, 0.0, -IN_DOOR_M].map(place).to_vec();
                            Some(Passage::from_line(line, [walls.left_m + walls.right_m; 2]))
                        }
                        None => Passage::trace(&gap, LinePoint { at: middle, floor }, across),
                    };
                    all.extend(found.map(|passage| Passage { out_first, ..passage }));
                }
            });
        }
        join_passages(&mut all, JOINED_RADII * radius_m);
        let mut boxes = BoxGrid::with_capacity(all.len());
        for (number, passage) in all.iter().enumerate() {
            let around = passage.line.iter().fold(Bounds2d::EMPTY, |b, p| b.union(Bounds2d::around_disc(p.at, NEAR_M)));
            boxes.set(number, around);
        }
        Self { boxes: Some(boxes).filter(|_| !all.is_empty()), all }
    }

    /// The next passage on the way of somebody at a place, with an aim.
    ///
    /// - `height_m`: height of the ground below (m; any where the ground has one floor).
    pub fn find_use(&self, at: Vec2, aim: Vec2, height_m: f32) -> Option<PassageUse> {
        let mut best: Option<PassageUse> = None;
        self.boxes.as_ref()?.visit_intersecting(&Bounds2d { min: at, max: at }, |number| {
            if let Some(found) = self.all[number].find_use(number, at, aim, [height_m; 2])
                && best.is_none_or(|b| (found.distance, found.number) < (b.distance, b.number))
            {
                best = Some(found);
            }
            true
        });
        best
    }

    /// Number of passages.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.all.len()
    }
}

impl Passage {
    /// The passage through a narrow place; none where it leads nowhere.
    ///
    /// - `across`: unit vector from wall to wall.
    fn trace(gap: &NarrowGap<'_>, middle: LinePoint, across: Vec2) -> Option<Self> {
        let mut range = [gap.stairs_m, gap.narrowest_m];
        let mut line = gap.trace_to_mouth(middle, across.perp(), &mut range)?;
        line.reverse();
        line.push(middle);
        line.extend(gap.trace_to_mouth(middle, -across.perp(), &mut range)?);
        Some(Self::from_line(line, range))
    }

    /// - `widths`: least and largest width (m).
    fn from_line(line: Vec<LinePoint>, [narrowest, widest]: [f32; 2]) -> Self {
        let length = line.windows(2).map(|w| w[0].at.distance(w[1].at)).sum();
        Self { line, length, half_width: 0.5 * widest, narrowest, out_first: None }
    }

    /// Mouth at an end, and the unit vector out of it.
    fn mouth(&self, is_second: bool) -> (LinePoint, Vec2) {
        let last = self.line.len() - 1;
        // The direction of the last half metre or so, as walls end raggedly.
        let back = 5.min(last);
        let (end, before) =
            if is_second { (self.line[last], self.line[last - back]) } else { (self.line[0], self.line[back]) };
        (end, (end.at - before.at).normalize_or_zero())
    }

    /// Place on the middle line that is nearest, where one on a floor is beside the line and within the walls, and the unit
    /// vector along it.
    fn place_within(&self, at: Vec2, floor: [f32; 2]) -> Option<(Vec2, Vec2)> {
        let mut best = (self.half_width * self.half_width, None);
        for ends in self.line.windows(2) {
            let nearest = nearest_on_segment(at, [ends[0].at, ends[1].at]);
            let square = at.distance_squared(nearest);
            if square < best.0 && is_one_floor(ends[0].floor, floor) {
                best = (square, Some((nearest, [ends[0].at, ends[1].at])));
            }
        }
        let (nearest, [a, b]) = best.1?;
        let along = (b - a).normalize_or_zero();
        // Beyond the ends one is outside.
        let is_beyond = |is_second| {
            let (mouth, out) = self.mouth(is_second);
            nearest == mouth.at && (at - mouth.at).dot(out) > 0.0
        };
        (!is_beyond(false) && !is_beyond(true)).then_some((nearest, along))
    }

    fn holds(&self, at: Vec2, floor: [f32; 2]) -> bool {
        self.place_within(at, floor).is_some()
    }

    fn find_use(&self, number: usize, at: Vec2, aim: Vec2, floor: [f32; 2]) -> Option<PassageUse> {
        let way = aim - at;
        if way.length_squared() < 1e-6 {
            return None;
        }
        let narrowest = self.narrowest;
        if let Some((mouth, along)) = self.place_within(at, floor) {
            let towards = way.dot(along) >= 0.0;
            let out = if towards { -along } else { along };
            return Some(PassageUse { number, towards, is_inside: true, distance: 0.0, narrowest, mouth, out });
        }
        let is_aimed_at = self.holds(aim, ALL_HEIGHTS);
        let mut best: Option<PassageUse> = None;
        for by_second in [false, true] {
            let (LinePoint { at: mouth, floor: ground }, out) = self.mouth(by_second);
            let (off, toward) = (at - mouth, -way.dot(out));
            let (before, distance) = (off.dot(out), off.length());
            if before <= 0.0
                || distance > NEAR_M
                || best.is_some_and(|b| b.distance <= distance)
                || !is_one_floor(ground, floor)
            {
                continue;
            }
            // The straight way leads in, or the aim is there.
            let crosses = toward > 0.0 && before <= toward && {
                let aside = (off + way * (before / toward)).dot(out.perp());
                aside.abs() < self.half_width
            };
            if crosses || is_aimed_at || aim.distance(mouth) < self.half_width + CORNER_M {
                let (towards, is_inside) = (!by_second, false);
                best = Some(PassageUse { number, towards, is_inside, distance, narrowest, mouth, out });
            }
        }
        best
    }
}

/// Narrow places of some widths, through which passages are traced.
struct NarrowGap<'a> {
    streets: &'a Streets,
    /// Least width (m).
    narrowest_m: f32,
    /// Widths from which on there is room, and on stairs (m).
    below_m: f32,
    stairs_m: f32,
}

impl NarrowGap<'_> {
    /// Middle line from a narrow place on to the mouth; none where it ends before.
    fn trace_to_mouth(&self, from: LinePoint, along: Vec2, range: &mut [f32; 2]) -> Option<Vec<LinePoint>> {
        let (narrowest, farthest) = (self.narrowest_m, self.stairs_m);
        let (LinePoint { mut at, mut floor }, mut along, mut line) = (from, along, Vec::new());
        while line.len() < MOST_POINTS {
            at += along * STEP_M;
            let walls = self.walls_beside(at, along, farthest, floor);
            let mut ahead_m = farthest;
            self.streets.visit_walls_near(at, narrowest, floor, |ends, radius, _| {
                ahead_m = ahead_m.min(nearest_on_segment(at, ends).distance(at) - radius);
            });
            if ahead_m < 0.4 * narrowest {
                return None;
            }
            let Some(walls) = walls else {
                line.push(LinePoint { at, floor });
                return Some(line);
            };
            floor = walls.floor;
            let width = walls.left_m + walls.right_m;
            if width < narrowest {
                return None;
            }
            if width >= if walls.has_stairs { self.stairs_m } else { self.below_m } {
                line.push(LinePoint { at, floor });
                return Some(line);
            }
            *range = [range[0].min(width), range[1].max(width)];
            let left = along.perp();
            at += left * (0.5 * (walls.left_m - walls.right_m)).clamp(-STEP_M, STEP_M);
            line.push(LinePoint { at, floor });
            let turned = -walls.across.perp();
            along = (along + if turned.dot(along) < 0.0 { -turned } else { turned }).normalize_or(along);
        }
        None
    }

    /// Walls on both sides of a way, within a distance; none where one is missing.
    fn walls_beside(&self, at: Vec2, along: Vec2, within: f32, floor: [f32; 2]) -> Option<WallsBeside> {
        let left = along.perp();
        let (mut sides, mut has_stairs) = ([(within, None); 2], false);
        self.streets.visit_walls_near(at, within, floor, |[a, b], radius, floor| {
            let off = nearest_on_segment(at, [a, b]) - at;
            let distance = off.length();
            if off.dot(along).abs() <= BESIDE * distance {
                has_stairs |= is_stairs(floor);
                let side = &mut sides[usize::from(off.dot(left) < 0.0)];
                if distance - radius < side.0 {
                    *side = (distance - radius, Some((off, floor)));
                }
            }
        });
        let [(left_m, Some((to_left, one))), (right_m, Some((to_right, other)))] = sides else { return None };
        let floor = [one[0].min(other[0]), one[1].max(other[1])];
        Some(WallsBeside { left_m, right_m, across: (to_left - to_right).normalize_or(left), floor, has_stairs })
    }
}

/// True between the lowest and highest ground beside stairs, or a ramp (m).
fn is_stairs([low, high]: [f32; 2]) -> bool {
    // It is infinite on ground of one floor, without heights.
    let rise_m = high - low;
    rise_m > STAIRS_M && rise_m.is_finite()
}

/// Joins passages at mouths so near to each other that nobody can wait in between; where more than two meet, none are joined.
fn join_passages(all: &mut Vec<Passage>, near_m: f32) {
    while let Some(junction) = find_junction(all, near_m) {
        let [(first, first_end), (other, other_end)] = junction;
        let next = all.remove(other);
        let Passage { mut line, half_width, narrowest, .. } = all[first].clone();
        if !first_end {
            line.reverse();
        }
        let ahead = next.line.iter().copied();
        if other_end {
            line.extend(ahead.rev())
        } else {
            line.extend(ahead)
        }
        let widths = [narrowest.min(next.narrowest), 2.0 * half_width.max(next.half_width)];
        all[first] = Passage::from_line(line, widths);
    }
}

/// Two passages with the ends at which they meet; the first one has the smaller number.
fn find_junction(all: &[Passage], near_m: f32) -> Option<[(usize, bool); 2]> {
    let mouth = |(number, end): (usize, bool)| all[number].mouth(end).0;
    let gap = |[one, two]: &[(usize, bool); 2]| {
        let [one, two] = [mouth(*one), mouth(*two)];
        if is_one_floor(one.floor, two.floor) { one.at.distance(two.at) } else { f32::INFINITY }
    };
    let ends = |number: usize| [(number, false), (number, true)];
    for other in 0..all.len() {
        for first in 0..other {
            let pairs = ends(first).into_iter().flat_map(|one| ends(other).map(|two| [one, two]));
            let Some(pair) = pairs.min_by(|a, b| gap(a).total_cmp(&gap(b))) else { continue };
            let is_near = |number: usize| ends(number).iter().any(|end| gap(&[pair[0], *end]) < near_m);
            let mut others = (0..all.len()).filter(|&third| third != first && third != other);
            if gap(&pair) < near_m && !others.any(is_near) {
                return Some(pair);
            }
        }
    }
    None
}

impl PassageTurns {
    /// No passage is granted yet.
    ///
    /// - `turn_s`: duration of a turn in a short passage (s).
    pub fn new(passages: &Passages, turn_s: f64) -> Self {
        let num = passages.all.len();
        Self { turns: vec![PassageTurn::default(); num], counts: vec![PassageCount::default(); num], turn_s }
    }

    /// Turns, for a snapshot.
    pub fn saved(&self) -> &[PassageTurn] {
        &self.turns
    }

    /// True if these can be the turns of as many passages at a time.
    pub fn is_possible(&self, saved: &[PassageTurn], now_s: f64) -> bool {
        saved.len() == self.turns.len() && saved.iter().all(|turn| (0.0..=now_s).contains(&turn.since_s))
    }

    /// Restores turns that are possible.
    pub fn restore(&mut self, saved: &[PassageTurn]) {
        self.turns.copy_from_slice(saved);
    }

    /// Counts somebody on whose way a passage is.
    pub fn count(&mut self, found: &PassageUse) {
        let count = &mut self.counts[found.number];
        let of = if found.is_inside { &mut count.inside } else { &mut count.near };
        let to = usize::from(found.towards);
        of[to] += 1;
        count.gathered[to] += u32::from(!found.is_inside && found.distance < GATHER_M);
    }

    /// Takes turns, once all are counted; then counts begin anew.
    pub fn update(&mut self, passages: &Passages, now_s: f64) {
        for ((turn, count), passage) in self.turns.iter_mut().zip(&mut self.counts).zip(&passages.all) {
            let turn_s = self.turn_s + TURN_PER_M_S * f64::from(passage.length);
            turn.update(&std::mem::take(count), turn_s, passage.out_first, now_s);
        }
    }

    /// Advice to somebody with a radius (m) at a place, on whose way a passage is.
    pub fn advise(&self, found: &PassageUse, at: Vec2, radius: f32) -> PassageAdvice {
        let turn = &self.turns[found.number];
        let is_own = turn.towards.is_none_or(|towards| towards == found.towards);
        let waits = if found.distance < STAND_M { PassageAdvice::Stand } else { PassageAdvice::Queue };
        if is_own && (found.is_inside || !turn.closes) {
            let is_full = turn.gathered[usize::from(found.towards)] >= MOST_GATHERED;
            let enters = found.is_inside || found.distance < GATHER_M || !is_full;
            return if enters { PassageAdvice::Enter } else { waits };
        }
        if found.is_inside {
            return PassageAdvice::GiveWay(found.out, 1.0);
        }
        let (off, side) = (at - found.mouth, found.out.perp());
        let (before, aside) = (off.dot(found.out), off.dot(side));
        let away = if aside < 0.0 { -side } else { side };
        if before < LANE_M && aside.abs() < 2.0 * radius + LANE_ROOM_M {
            return PassageAdvice::GiveWay((away + found.out * 0.4).normalize_or_zero(), 1.0);
        }
        if before < LANE_M && aside.abs() < SPREAD_M {
            return PassageAdvice::GiveWay((away + found.out * 0.2).normalize_or_zero(), 0.3);
        }
        if found.distance < KEPT_FREE_M {
            return found.give_way_from_mouth(at);
        }
        waits
    }
}

impl PassageTurn {
    fn update(&mut self, count: &PassageCount, turn_s: f64, out_first: Option<bool>, now_s: f64) {
        let PassageCount { inside, near, gathered } = *count;
        self.gathered = gathered;
        let begin = |towards: Option<bool>| Self { towards, closes: false, since_s: now_s, gathered };
        let comes_out = |of: usize| near[of] > 0 && out_first == Some(of == 1);
        let Some(towards) = self.towards else {
            // The first who come have it; of those who wait on both sides, who comes out of a cabin.
            if inside != [0; 2] || near != [0; 2] {
                let key = |of: usize| (inside[of], comes_out(of), near[of]);
                *self = begin(Some(key(1) > key(0)));
            }
            return;
        };
        let (own, other) = (usize::from(towards), usize::from(!towards));
        if inside == [0; 2] && (self.closes || near[own] == 0) {
            let next = [(other, !towards), (own, towards)].into_iter().find(|(of, _)| near[*of] > 0);
            *self = begin(next.map(|(_, towards)| towards));
        } else if inside[own] == 0 && gathered[own] == 0 && inside[other] > 0 {
            // None of those who have it are in it or before it: those who are in it leave first.
            *self = Self { closes: near[own] > 0, ..begin(Some(!towards)) };
        } else if comes_out(other) || near[other] > 0 && now_s - self.since_s >= turn_s && !comes_out(own) {
            self.closes = true;
        }
    }
}
