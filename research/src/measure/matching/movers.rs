//! Characters of a policy and of matching, moved by root motion frame by frame.

use crate::matching::{BoxSearch, Character, Database, MatchGoal, Nearest, Row};
use glam::{Vec2, Vec3};
use throng_core::policy::{LookAheadGoal, LookAheadJob, PolicyTable, RankedActions, RegionRecord};
use throng_core::{Bundle, Planar};

/// A character that can be told where its target is.
pub(super) trait Mover {
    /// Planar root in the world.
    fn root(&self) -> Planar;
    /// Frame row that plays.
    fn frame(&self) -> u32;
    /// Plays one frame, after having chosen what to play where that is due.
    ///
    /// - `target`: in the world (m).
    /// - `is_hit`: the frame that plays is that of an effective hit.
    /// - returns the frame that took the place of the one that played, where motion does not simply go on.
    fn step(&mut self, target: Vec3, is_hit: bool) -> Option<u32>;
}

/// A target as a root sees it.
pub(super) fn local(root: Planar, target: Vec3) -> Vec3 {
    let p = root.inverse_transform_point(Vec2::new(target.x, target.z));
    Vec3::new(p.x, target.y, p.y)
}

/// Moved by policies: looks ahead at the end of every segment.
pub(super) struct ByPolicy<'a> {
    tables: &'a Bundle,
    /// Policies and what they count; where their regions do not hold the target, nothing.
    goals: &'a [(PolicyTable, f32)],
    /// Root at the start of the segment.
    start: Planar,
    segment: u32,
    played: u32,
}

impl<'a> ByPolicy<'a> {
    /// Begins with a choice in a state (the state exists).
    pub fn new(tables: &'a Bundle, goals: &'a [(PolicyTable, f32)], root: Planar, state: u32, to: Vec3) -> Self {
        let mut mover = Self { tables, goals, start: root, segment: 0, played: 0 };
        mover.choose(state, root, to);
        mover
    }

    fn choose(&mut self, state: u32, root: Planar, target: Vec3) {
        let target = [local(root, target)];
        let weights: Vec<[f32; 1]> = self
            .goals
            .iter()
            .map(|(policy, weight)| [if policy.region().contains(target[0]) { *weight } else { 0.0 }])
            .collect();
        let goals: Vec<LookAheadGoal<'_>> = self
            .goals
            .iter()
            .zip(&weights)
            .map(|((policy, _), weights)| LookAheadGoal { policy, weights, targets: &target })
            .collect();
        let mut ranked = [RankedActions::NONE];
        let job = LookAheadJob { goals: &goals, states: &[state], ranked: &mut ranked };
        job.run().unwrap_or_else(|e| unreachable!("states come from the tables, targets are near: {e}"));
        let segments = self.tables.graph().segments_of(state);
        (self.segment, self.start, self.played) = (segments[usize::from(ranked[0].best())], root, 0);
    }

    fn planar(&self, frame: u32) -> Planar {
        let [x, z, heading] = self.tables.frames()[frame as usize].planar;
        Planar::new(x, z, heading)
    }
}

impl Mover for ByPolicy<'_> {
    fn root(&self) -> Planar {
        let first = self.tables.graph().segments[self.segment as usize].start;
        self.start.compose(self.planar(first).to_local(self.planar(first + self.played)))
    }

    fn frame(&self) -> u32 {
        self.tables.graph().segments[self.segment as usize].start + self.played
    }

    fn step(&mut self, target: Vec3, _is_hit: bool) -> Option<u32> {
        let (segment, before) = (self.tables.graph().segments[self.segment as usize], self.frame());
        if self.played == segment.num_frames {
            self.choose(segment.end, self.root(), target);
        }
        let now = self.frame();
        self.played += 1;
        (now != before).then_some(now)
    }
}

/// What matching wants of its target.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aim {
    /// How far from the target to stand (m).
    pub stand_off: f32,
    /// How fast to go at most (m/s).
    pub speed_mps: f32,
    /// Where targets are to be struck, if they are.
    pub reach: Option<RegionRecord>,
}

/// Time in which a target within reach is to be struck (s).
const STRIKE_S: f32 = 0.3;
/// A target nearer than this has no direction to look in (m).
const LEAST_LOOK_M: f32 = 0.3;

impl Aim {
    fn goal(&self, target: Vec3) -> MatchGoal {
        let at = Vec2::new(target.x, target.z);
        let distance = at.length();
        MatchGoal {
            place: at.normalize_or_zero() * (distance - self.stand_off),
            look: if distance > LEAST_LOOK_M { at } else { Vec2::Y },
            speed_mps: self.speed_mps,
            hit: self.reach.filter(|r| r.contains(target)).map(|_| (target, STRIKE_S)),
        }
    }
}

/// Moved by matching.
pub(super) struct ByMatching<'a> {
    pub database: &'a Database,
    pub boxes: &'a BoxSearch<'a>,
    pub aim: Aim,
    pub character: Character,
    /// Queries and where they began, if they are kept.
    pub asked: Option<Vec<(Row, Nearest)>>,
}

impl Mover for ByMatching<'_> {
    fn root(&self) -> Planar {
        self.character.root
    }

    fn frame(&self) -> u32 {
        self.character.frame
    }

    fn step(&mut self, target: Vec3, is_hit: bool) -> Option<u32> {
        let before = self.frame();
        if self.character.wants_search(self.database, is_hit) {
            let goal = self.aim.goal(local(self.character.root, target));
            if let Some(asked) = &mut self.asked {
                asked.push(self.character.query(self.database, &goal));
            }
            self.character.search(self.database, self.boxes, &goal);
        }
        let now = self.frame();
        self.character.advance(self.database);
        (now != before).then_some(now)
    }
}
