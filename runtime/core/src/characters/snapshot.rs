//! Saves the state of characters and restores it.

use super::block::{BodyBlock, MotionBlock, NO_STATE, SCHEDULED};
use super::step::{self, CharactersTick};
use super::{Characters, motion_set::MotionSet, pace};
use crate::body::{Lanewise, LimbTouch, Mat3x4};
use crate::skeleton::NUM_JOINTS;
use serde::{Deserialize, Serialize};
use throng_base::{Error, Result, error::ensure, simd::LANES};

/// Longest time until a scheduled clip begins (s).
const LONGEST_S: f32 = 1e3;
/// Bound of offsets that are added to a clip (m, rad).
const MOST_ADDED: f32 = 1.1e6;
/// An action is bent by half a turn at most (rad).
const MOST_BENT: f32 = 3.2;

/// State of characters at one instant: all that their next steps depend on, without poses. It can be written and read,
/// and be changed there: [`Characters::restore`] checks it. (about 810 bytes a character)
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct CharactersSnapshot {
    blocks: Vec<MotionBlock>,
    bodies: Vec<BodyBlock>,
    touches: Vec<LimbTouch>,
    num_characters: usize,
    /// Hash of the bundle's content.
    bundle: u128,
}

impl CharactersSnapshot {
    /// Memory that it takes (bytes).
    pub fn num_bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice()) + size_of_val(self.bodies.as_slice()) + size_of_val(self.touches.as_slice())
    }

    /// Changes the first block.
    #[cfg(test)]
    pub(super) fn spoil_first_block(&mut self, spoil: fn(&mut MotionBlock, &mut BodyBlock)) {
        spoil(&mut self.blocks[0], &mut self.bodies[0]);
    }
}

impl Characters {
    /// Saves the state.
    pub fn snapshot(&self) -> CharactersSnapshot {
        let (num_characters, bundle) = (self.num_characters, self.bundle.hash());
        let (blocks, bodies) = self.saved_blocks();
        CharactersSnapshot { blocks, bodies, touches: self.touches.clone(), num_characters, bundle }
    }

    /// Restores a snapshot. Steps from there repeat those of the saved characters bit by bit where config and goals are
    /// the same; poses are those of the snapshot up to rounding. There are no blows until the next step.
    ///
    /// # Errors
    /// [`Error::Snapshot`] where it is of another number of characters or another bundle, or damaged; nothing has
    /// changed then.
    pub fn restore(&mut self, motion_set: &MotionSet, snapshot: &CharactersSnapshot) -> Result<()> {
        let (n, expected) = (snapshot.num_characters, self.num_characters);
        let why = || format!("it has {n} characters, expected {expected}");
        ensure(n == expected, || Error::Snapshot { what: "characters", why: why() })?;
        self.restore_any(motion_set, snapshot)
    }

    /// Restores a snapshot of any number of characters within the capacity, see [`Characters::restore`].
    ///
    /// # Errors
    /// As [`Characters::restore`].
    pub fn restore_any(&mut self, motion_set: &MotionSet, snapshot: &CharactersSnapshot) -> Result<()> {
        let CharactersSnapshot { blocks, bodies, touches, num_characters: n, bundle } = snapshot;
        let refuse = |why: String| Err(Error::Snapshot { what: "characters", why });
        let room = self.matrices.len() / NUM_JOINTS;
        if *n > room {
            return refuse(format!("it has {n} characters, the capacity is {room}; restore it into more room"));
        }
        if [blocks.len(), bodies.len()] != [n.div_ceil(LANES); 2] || !self.is_touch_sound(touches, *n) {
            return refuse(format!("it is damaged: its rows are not those of {n} characters; take a new one"));
        }
        if *bundle != self.bundle.hash() || !self.bundle.is_same(&motion_set.bundle) {
            return refuse("it was taken with another bundle".into());
        }
        if let Some(c) = (0..*n).find(|&c| !is_sound(blocks, bodies, motion_set, c, c as u64)) {
            return refuse(format!("character {c} plays what the bundle does not have, or is nowhere"));
        }
        if let Some(c) = self.find_path_conflict(motion_set, blocks, *n) {
            return refuse(format!("character {c} is in another's way, though they make way"));
        }
        self.set_state(blocks, bodies, touches, *n);
        self.pose_again(motion_set);
        Ok(())
    }

    /// A character with collision avoidance whose path meets another path, if there is any (blocks: n / 8, rounded up,
    /// sound).
    pub(super) fn find_path_conflict(&self, motion_set: &MotionSet, blocks: &[MotionBlock], n: usize) -> Option<usize> {
        let mut avoiding = self.avoiding.clone()?;
        // External obstacles were at other places at the time of the snapshot.
        avoiding.book.external_obstacles.replace_all(std::iter::empty());
        avoiding.rebuild_paths(blocks, n, motion_set)
    }

    /// State of all characters, eight to a block; unused lanes are zero.
    pub(super) fn saved_blocks(&self) -> (Vec<MotionBlock>, Vec<BodyBlock>) {
        let num = self.num_characters.div_ceil(LANES);
        let (mut blocks, mut bodies) = (self.blocks[..num].to_vec(), self.bodies[..num].to_vec());
        clear_beyond(&mut blocks, &mut bodies, self.num_characters);
        (blocks, bodies)
    }

    /// True for displacements of limbs that so many characters may have: one each; any where no limbs are stopped here.
    pub(super) fn is_touch_sound(&self, touches: &[LimbTouch], num_characters: usize) -> bool {
        self.touch.is_none() || touches.len() == num_characters && touches.iter().all(LimbTouch::is_valid)
    }

    /// Sets the state of `n` characters (blocks, bodies: n / 8, rounded up; there is room).
    pub(super) fn set_state(&mut self, blocks: &[MotionBlock], bodies: &[BodyBlock], touches: &[LimbTouch], n: usize) {
        self.blocks.fill(MotionBlock::ZERO);
        self.blocks[..blocks.len()].copy_from_slice(blocks);
        self.bodies.fill(BodyBlock::ZERO);
        self.bodies[..bodies.len()].copy_from_slice(bodies);
        clear_beyond(&mut self.blocks[..blocks.len()], &mut self.bodies, n);
        self.touches.clear();
        if self.touch.is_some() {
            self.touches.extend_from_slice(touches);
        }
        self.num_characters = n;
        self.mark_paths_stale();
        self.num_choosers = (0..n).filter(|c| self.blocks[c / LANES].segment[c % LANES] != SCHEDULED).count();
    }

    /// Poses all characters as they stand, reserves their paths and forgets the blows of the last step; time stands still.
    pub(super) fn pose_again(&mut self, motion_set: &MotionSet) {
        if let Some(avoiding) = &mut self.avoiding {
            // Navigation reads the velocities of paths before the next step.
            avoiding.rebuild_paths(&self.blocks, self.num_characters, motion_set);
        }
        let kept = (self.blocks.clone(), self.bodies.clone());
        self.matrices.fill(Mat3x4::default());
        let (config, ground, partners) = (self.config, self.ground.clone(), self.touch.take());
        let (config, ground, touch) = (&config, &ground, partners.as_deref());
        let tick = CharactersTick { dt_s: 0.0, motion_set, config, ground, orders: &[], touch, moves: false };
        self.ranges().for_each(|range| step::pose_all(range, &tick));
        self.touch = partners;
        (self.blocks, self.bodies) = kept;
        self.blows.gather_blows(&[], motion_set);
    }
}

/// Clears the lanes after the first `n`.
fn clear_beyond(blocks: &mut [MotionBlock], bodies: &mut [BodyBlock], n: usize) {
    for at in n..blocks.len() * LANES {
        blocks[at / LANES].copy_lane(at % LANES, &MotionBlock::ZERO, 0);
        bodies[at / LANES].copy_lane(at % LANES, &BodyBlock::ZERO, 0);
    }
}

/// True where one plays something that there is, somewhere (at < blocks.len() * LANES).
///
/// - `name`: what its random choices depend on.
pub fn is_sound(blocks: &[MotionBlock], bodies: &[BodyBlock], motion_set: &MotionSet, at: usize, name: u64) -> bool {
    let (mut b, lane) = (blocks[at / LANES], at % LANES);
    let (first, length) = (b.first[lane], b.length[lane]);
    // A character on scheduled clips chooses nothing.
    let named = b.name[lane] == name || b.segment[lane] == SCHEDULED;
    let (exists, earliest) = match b.segment[lane] {
        SCHEDULED => {
            let last = first.saturating_add(length);
            let is_there = length > 0 && (last as usize) < motion_set.num_frames();
            let in_clip = is_there && motion_set.clip_of(first) == motion_set.clip_of(last);
            (in_clip && b.bend[lane] == 0.0, -LONGEST_S * motion_set.rate_hz)
        }
        segment => {
            let segment = motion_set.graph.segments.get(segment as usize);
            (segment.is_some_and(|s| (first, length) == (s.start, s.num_frames)), 0.0)
        }
    };
    let state = b.choice_state[lane];
    let chose = state == NO_STATE || (state as usize) < motion_set.graph.states.len();
    // Endless before the first transition, and below 0 for a clip that is scheduled but has not begun.
    let aged = b.age_s[lane] > -LONGEST_S;
    b.age_s[lane] = 0.0;
    let paced = b.pace[lane] <= pace::IDLING && b.wait[lane].abs() <= 1e3;
    let in_time = (earliest..=length as f32).contains(&b.time[lane]);
    let changed = b.change.iter().all(|row| (row[lane] as usize) < motion_set.num_frames());
    let body = &bodies[at / LANES];
    let feet = body.feet.iter().all(|foot| foot.is_sound(lane));
    let near = b.is_near(lane) && adds_little(&b, lane) && body.is_near(lane) && feet;
    exists && chose && aged && paced && in_time && named && changed && near
}

/// True where what is added to the motion that a lane plays is no more than steps and scheduled clips add.
fn adds_little(b: &MotionBlock, lane: usize) -> bool {
    let (length, drift) = (b.length[lane] as f32, b.drift_per_frame(lane).abs());
    match b.segment[lane] {
        SCHEDULED => {
            let most = drift.max_element().max(b.turn[lane].abs());
            (0.0..length).contains(&b.drift_from[lane]) && most * length < MOST_ADDED
        }
        _ => {
            let on_ground = [b.lift, b.drift[1], b.turn, b.drift_from].iter().all(|v| v[lane] == 0.0);
            on_ground && drift.max_element() * length < MOST_ADDED && b.bend[lane].abs() * length < MOST_BENT
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characters::tests::tables;
    use crate::characters::{CharactersConfig, ScheduledClip};
    use crate::patch::Placement;

    #[test]
    fn who_is_laid_far_beyond_what_it_plays_is_refused() {
        let r = MotionSet::new(&tables());
        let missing = Placement::new(9e5, 0.0, 0.0, 0.0);
        let clip = ScheduledClip { num_frames: 30, from_offset: 5, missing, ..ScheduledClip::default() };
        let mut characters = Characters::new_scheduled(&r, CharactersConfig::default(), &[clip; 4]).unwrap();
        characters.step(&r, 0.8, &[]).unwrap();
        characters.schedule_clip(&r, 3, &clip).unwrap();
        let kept = characters.snapshot();
        assert!(kept.blocks[0].time[3] < 5.0);
        characters.restore(&r, &kept).unwrap();
        let bad: [fn(&mut MotionBlock, &mut BodyBlock); 9] = [
            |b, _| b.time[3] = -1e7 + 1.0,
            |b, _| b.drift_from[3] = -1e6,
            |b, _| b.drift_from[3] = 31.0,
            |b, _| b.drift[0][3] = 1e6,
            |b, _| b.turn[3] = -9e6,
            // Into the next clip, and beyond all counting.
            |b, _| b.first[3] = 45,
            |b, _| (b.first[3], b.length[3]) = (u32::MAX, 2),
            // Shares and cosines that are none: poses would have no end.
            |_, body| body.feet[0].step[3] = -4096.0,
            |_, body| body.feet[1].bent[3] = 30.0,
        ];
        for spoil in bad {
            let mut kept = kept.clone();
            kept.spoil_first_block(spoil);
            let e = characters.restore(&r, &kept).unwrap_err().to_string();
            assert!(e.contains("character 3"), "{e}");
        }
    }
}
