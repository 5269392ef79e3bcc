//! Events of bodies: feet that come down, parts that touch, tags of clips that begin.

use super::lane_body::{LEGS, LaneBody};
use super::lanes::{Lane, Lane3, get_lane, load, store};
use super::{lanewise::lanewise_fields, matrix::Mat3x4};
use crate::format::{ClipRecord, FrameRow, Meta, RotationCode, Table};
use crate::skeleton::{Joint, NUM_JOINTS};
use crate::{contacts::Contacts, planar::Planar};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use throng_base::simd::{LANES, Lanes, V};
use throng_base::{Id, maths};

/// Way of a foot in the air from which it has made a step (m).
const STEP_M: f32 = 0.04;
/// Time in which half of what is known of a foot's fall is forgotten (s).
const FALL_HALF_LIFE_S: f32 = 0.03;
/// Downward speed of a foot that is as strong as steps are, and share of the speed of travel that counts as such (m/s).
const STRONGEST_MPS: f32 = 2.0;
const OF_TRAVEL: f32 = 0.4;
/// Events of one character and step for which there is memory, on the average; what exceeds it is dropped.
pub(crate) const EVENTS_EACH: usize = 6;

/// An event of a body in the last step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BodyEvent {
    /// Its kind.
    pub kind: BodyEventKind,
    /// Of the joint, the tag or the blow, as the kind says; else 0.
    pub number: u32,
    /// Place of a footstep or a blow in the world; else zero (m).
    pub at: Vec3,
    /// Strength of a footstep or a blow (0 to 1); else 0.
    pub strength: f32,
}

/// Kind of an event of a body. Events are not saved; policy characters (`note_after`) and walkers report them, C has numbers of its
/// own for them, and Python lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[repr(u32)]
pub enum BodyEventKind {
    /// A foot, a joint, has come down after it was in the air; at the middle of its sole. Strength is that of its fall and of
    /// the speed of travel, about 0.3 for a walk.
    Footstep,
    /// A part began to touch the ground or a thing: a foot for its heel, a toe for its ball, a hand, or the hips for the seat.
    ContactBegan,
    /// A part has ended to touch.
    ContactEnded,
    /// The motion has come into a range of frames that a sidecar names: 256 times the number of the clip, plus that of the tag
    /// in [`crate::format::ClipMeta::tags`].
    Tag,
    /// A blow has reached its effective place; the number is that of its hit.
    Blow,
    /// End of a performance: played, cut short, or given up before it began.
    Performed,
}

impl BodyEvent {
    /// An event without place and strength.
    pub(crate) fn new(kind: BodyEventKind, number: u32) -> Self {
        Self { kind, number, at: Vec3::ZERO, strength: 0.0 }
    }
}

/// Parts that touch, in the order of the bits of [`Contacts`].
const PARTS: [Joint; 7] = {
    use Joint::*;
    [LeftFoot, LeftToe, RightFoot, RightToe, LeftHand, RightHand, Hips]
};

/// Way of eight bodies' feet through the air.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct FootSwing {
    /// Where the balls were at the last step, in the world (m).
    ball: [Lane3; 2],
    /// Way since the foot has left the ground (m), and how fast it falls (m/s).
    way: [Lane; 2],
    fall: [Lane; 2],
    /// Strength of the footstep that each made in the last step; 0 for none.
    pub strength: [Lane; 2],
}

lanewise_fields!(FootSwing { ball, way, fall, strength });

impl FootSwing {
    pub const ZERO: Self = Self {
        ball: [[[0.0; LANES]; 3]; 2],
        way: [[0.0; LANES]; 2],
        fall: [[0.0; LANES]; 2],
        strength: [[0.0; LANES]; 2],
    };

    /// Notes where feet are, and which have come down.
    ///
    /// - `balls`: in the world (m).
    /// - `seen`: 1 where the body was posed before.
    /// - `speed`: of travel (m/s).
    #[inline(always)]
    pub fn follow<F: Lanes>(
        &mut self,
        balls: [V<F>; 2],
        contacts: &[Contacts; LANES],
        seen: &Lane,
        speed: &Lane,
        dt_s: f32,
    ) {
        if dt_s == 0.0 {
            return;
        }
        let (zero, half, one) = (F::splat(0.0), F::splat(0.5), F::splat(1.0));
        let keep = F::splat(maths::exp2(-dt_s / FALL_HALF_LIFE_S));
        let (seen, travel) = (F::load(seen), F::load(speed).abs() * F::splat(OF_TRAVEL));
        for (side, ball) in balls.into_iter().enumerate() {
            let moved = ball - load(&self.ball[side]);
            let mut is_down = [0.0; LANES];
            for (is_down, contacts) in is_down.iter_mut().zip(contacts) {
                *is_down = f32::from(u8::from(contacts.any([Contacts::LEFT, Contacts::RIGHT][side])));
            }
            let (is_down, way) = (F::load(&is_down), F::load(&self.way[side]));
            let fall = (zero - moved.y / F::splat(dt_s)).max(F::load(&self.fall[side]) * keep).min(F::splat(10.0));
            let strength = (fall.max(travel) / F::splat(STRONGEST_MPS)).max(F::splat(0.02)).min(one);
            let strength = F::select_lt(F::splat(STEP_M), way, F::select_lt(half, is_down, strength, zero), zero);
            let way = F::select_lt(half, is_down, zero, (way + moved.length()).min(one));
            store(&mut self.ball[side], ball);
            F::select_lt(seen, half, zero, way).store(&mut self.way[side]);
            F::select_lt(seen, half, zero, fall).store(&mut self.fall[side]);
            F::select_lt(seen, half, zero, strength).store(&mut self.strength[side]);
        }
    }
}

/// World positions of the bottom of the heel and of the ball (the toe's joint), left foot first (m).
pub(crate) fn find_soles(body: &LaneBody, lane: usize, root: Planar, model: &[Mat3x4; NUM_JOINTS]) -> [[Vec3; 2]; 2] {
    let to_world = |p: Vec3| maths::rotate(root.rotation(), p) + root.translation();
    std::array::from_fn(|side| {
        let [_, _, foot, toe] = LEGS[side].map(|j| model[j.index()]);
        let heel = maths::rotate(foot.rotation(), get_lane(&body.legs[side].heel, lane));
        [foot.translation() + heel, toe.translation()].map(to_world)
    })
}

/// A named range of frame rows.
#[derive(Clone, Copy, Debug)]
struct TagRows {
    /// First row, and the row after the last.
    rows: [u32; 2],
    /// See [`BodyEventKind::Tag`].
    number: u32,
}

/// Frames of a bundle that layers may show, and the named ranges of its clips.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClipRows {
    pub frames: Table<FrameRow>,
    /// Rotation code of the frames: one element, or none without a bundle.
    pub code: Table<RotationCode>,
    /// Frames a second (Hz).
    pub rate_hz: f32,
    /// In the order of their first rows.
    tags: Arc<[TagRows]>,
}

impl ClipRows {
    /// Frames and their rotation code, with the tags of all clips.
    pub fn new(frames: Table<FrameRow>, code: Table<RotationCode>, clips: &[ClipRecord], meta: &Meta) -> Self {
        let mut all = Vec::new();
        for (clip, (record, meta)) in (0..).zip(clips.iter().zip(&meta.clips)) {
            for (tag, (_, from, to)) in (0..).zip(&meta.tags) {
                let rows = [from, to].map(|frame| record.first_frame.saturating_add(*frame));
                all.push(TagRows { rows, number: clip << 8 | u32::min(tag, 255) });
            }
        }
        all.sort_by_key(|tag| tag.rows);
        Self { frames, code, rate_hz: meta.rate_hz as f32, tags: all.into() }
    }

    /// True where clips name no ranges.
    pub fn has_no_tags(&self) -> bool {
        self.tags.is_empty()
    }

    /// Tags into which motion has come that goes from one row to another, of another clip or not.
    ///
    /// - `most`: rows that a step plays at most; what goes further has changed its clip.
    fn begun(&self, [from, to]: [u32; 2], most: u32) -> impl Iterator<Item = u32> + '_ {
        let goes_on = (1..=most).contains(&to.wrapping_sub(from));
        let since = if goes_on { self.tags.partition_point(|tag| tag.rows[0] <= from) } else { 0 };
        let begins = move |tag: &&TagRows| tag.rows[0] <= to && from != to;
        let begun = move |tag: &&TagRows| goes_on || tag.rows[1] > to && !(tag.rows[0]..tag.rows[1]).contains(&from);
        self.tags[since..].iter().take_while(begins).filter(begun).map(|tag| tag.number)
    }
}

/// The row of motion that has none.
pub(crate) const NO_ROW: u32 = u32::MAX;

/// A body after a step.
pub(crate) struct MovedBody<'a> {
    pub body: &'a LaneBody,
    pub root: Planar,
    pub model: &'a [Mat3x4; NUM_JOINTS],
    pub swing: &'a FootSwing,
}

/// Eight characters before a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockBefore {
    pub contacts: [Contacts; LANES],
    /// Above 0.5 where the body was posed.
    pub seen: Lane,
    /// Frame rows of their motion; [`NO_ROW`] for none.
    pub rows: [u32; LANES],
}

/// The state of all characters before a step, and the events since.
#[derive(Clone, Debug)]
pub(crate) struct BodyEvents {
    /// (blocks)
    before: Vec<BlockBefore>,
    /// Rows that the step plays at most.
    most_rows: u32,
    events: Vec<(Id, BodyEvent)>,
}

impl BodyEvents {
    /// Room for a number of characters, and for so many further events.
    pub fn with_capacity(characters: usize, more: usize) -> Self {
        let events = Vec::with_capacity(characters * EVENTS_EACH + more);
        Self { before: Vec::with_capacity(characters.div_ceil(LANES)), most_rows: 0, events }
    }

    /// Forgets the last step; before one of so many frames.
    pub fn clear(&mut self, frames: f32) {
        self.most_rows = frames as u32 + 1;
        self.before.clear();
        self.events.clear();
    }

    /// Notes the next block before a step.
    pub fn note_before(&mut self, block: BlockBefore) {
        self.before.push(block);
    }

    /// True where feet, hands or seat of a character are not as they were before the step, or a foot came down.
    pub fn has_changed(&self, row: usize, now: Contacts, swing: &FootSwing) -> bool {
        let (before, lane) = (&self.before[row / LANES], row % LANES);
        before.contacts[lane] != now || swing.strength[0][lane] + swing.strength[1][lane] != 0.0
    }

    /// Adds an event, as long as there is room.
    pub fn add(&mut self, id: Id, event: BodyEvent) {
        if self.events.len() < self.events.capacity() {
            self.events.push((id, event));
        }
    }

    /// Adds what feet, hands and seat have done since the character of a row was noted.
    pub fn add_contacts(&mut self, row: usize, id: Id, now: Contacts, of: &MovedBody<'_>) {
        let (before, lane) = (&self.before[row / LANES], row % LANES);
        let stood = before.contacts[lane];
        if before.seen[lane] <= 0.5 {
            return;
        }
        for (side, leg) in LEGS.into_iter().enumerate() {
            let strength = of.swing.strength[side][lane];
            if strength > 0.0 {
                let [heel, ball] = find_soles(of.body, lane, of.root, of.model)[side];
                let middle = heel.lerp(ball, 0.5);
                let at = middle.with_y(heel.y.min(ball.y - of.body.legs[side].thickness[lane]));
                let step = BodyEvent::new(BodyEventKind::Footstep, leg[2] as u32);
                self.add(id, BodyEvent { at, strength, ..step });
            }
        }
        let mut changed = stood.0 ^ now.0;
        while changed != 0 {
            let bit = changed.trailing_zeros();
            changed &= changed - 1;
            let Some(part) = PARTS.get(bit as usize) else { return };
            let began = now.0 >> bit & 1 == 1;
            let kind = if began { BodyEventKind::ContactBegan } else { BodyEventKind::ContactEnded };
            self.add(id, BodyEvent::new(kind, *part as u32));
        }
    }

    /// Adds the tags into which the motion of a row has come.
    ///
    /// - `frame`: its frame row now; [`NO_ROW`] for none.
    pub fn add_tags(&mut self, row: usize, id: Id, rows: &ClipRows, frame: u32) {
        let was = self.before[row / LANES].rows[row % LANES];
        if was != frame && ![was, frame].contains(&NO_ROW) {
            let begun = rows.begun([was, frame], self.most_rows);
            begun.for_each(|tag| self.add(id, BodyEvent::new(BodyEventKind::Tag, tag)));
        }
    }

    pub fn get(&self) -> &[(Id, BodyEvent)] {
        &self.events
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::ClipMeta;
    use crate::skeleton::Skeleton;
    use throng_base::simd::ArrayLanes;

    /// Feet that walk: each swings for 0.4 of a cycle, the right one half a cycle after the left one.
    struct Gait {
        cycle_s: f32,
        stride_m: f32,
        lift_m: f32,
    }

    impl Gait {
        /// Ball of a foot and whether it stands (m).
        fn ball(&self, side: usize, time_s: f32) -> (Vec3, bool) {
            let cycles = time_s / self.cycle_s + 0.5 * side as f32;
            let (whole, part) = (cycles.floor(), cycles.fract());
            let swing = ((part - 0.6) / 0.4).max(0.0);
            let eased = swing * swing * (3.0 - 2.0 * swing);
            let up = self.lift_m * 4.0 * swing * (1.0 - swing);
            (Vec3::new([0.1, -0.1][side], 0.02 + up, (whole + eased) * self.stride_m), swing == 0.0)
        }
    }

    /// Times (s), sides and strengths of the footsteps of a gait.
    fn walk(gait: &Gait, dt_s: f32, seconds: f32, flicker: bool) -> Vec<(f32, usize, f32)> {
        let (mut swing, mut found) = (FootSwing::ZERO, Vec::new());
        let speed = [gait.stride_m / gait.cycle_s; LANES];
        for k in 0..(seconds / dt_s) as usize {
            let time_s = k as f32 * dt_s;
            let feet = [0, 1].map(|side| gait.ball(side, time_s));
            let mut contacts = Contacts::NONE;
            for (side, (_, down)) in feet.iter().enumerate() {
                if *down && !(flicker && k % 7 == 3) {
                    contacts.insert([Contacts::LEFT_HEEL, Contacts::RIGHT_TOE][side]);
                }
            }
            let balls = feet.map(|(ball, _)| V::<ArrayLanes>::splat(ball));
            swing.follow(balls, &[contacts; LANES], &[f32::from(u8::from(k > 0)); LANES], &speed, dt_s);
            for side in 0..2 {
                let [first, others @ ..] = swing.strength[side];
                assert_eq!(others, [first; LANES - 1]);
                if first > 0.0 {
                    found.push((time_s, side, first));
                }
            }
        }
        found
    }

    #[test]
    fn a_walk_of_known_steps_has_these_steps() {
        for (cycle_s, stride_m, lift_m) in [(1.1, 1.4, 0.08), (0.7, 2.6, 0.15), (1.6, 0.5, 0.05), (1.0, 0.0, 0.12)] {
            for dt_s in [1.0 / 30.0, 1.0 / 60.0, 1.0 / 144.0] {
                let gait = Gait { cycle_s, stride_m, lift_m };
                let steps = walk(&gait, dt_s, 10.0 * cycle_s + 0.02, true);
                // The left foot comes down at the end of each cycle, the right one in the middle of each.
                assert!((19..=20).contains(&steps.len()), "{} steps of {cycle_s} s at {dt_s} s", steps.len());
                for (k, (time_s, side, strength)) in steps.iter().enumerate() {
                    let due = 0.5 * cycle_s * (k + 1) as f32;
                    assert_eq!(*side, (k + 1) % 2, "sides take turns");
                    assert!((0.0..2.5 * dt_s).contains(&(time_s - due + 1e-4)), "{time_s} s, due at {due} s");
                    assert!((0.02..=1.0).contains(strength));
                }
            }
        }
        let mean = |g: &Gait| walk(g, 1.0 / 60.0, 10.0, false).iter().map(|s| s.2).sum::<f32>();
        let [slow, run] = [(0.6, 0.06), (2.6, 0.15)].map(|(stride_m, lift_m)| Gait { cycle_s: 0.8, stride_m, lift_m });
        assert!(mean(&run) > 1.5 * mean(&slow), "runs are stronger: {} {}", mean(&run), mean(&slow));
        assert!(walk(&Gait { cycle_s: 1.0, stride_m: 0.0, lift_m: 0.004 }, 1.0 / 60.0, 20.0, true).is_empty());
    }

    #[test]
    fn tags_begin_where_motion_comes_into_their_frames() {
        let clip = |first_frame| ClipRecord { first_frame, num_frames: 50, mirrored: 0, reserved: 0 };
        let tags = |tags: &[(&str, u32, u32)]| ClipMeta {
            tags: tags.iter().map(|(name, from, to)| ((*name).into(), *from, *to)).collect(),
            ..ClipMeta::default()
        };
        let clips = vec![tags(&[("b", 20, 30), ("a", 10, 11)]), tags(&[("c", 0, 5)])];
        let meta = Meta { clips, ..Meta::default() };
        let rows = ClipRows::new(Table::default(), Table::default(), &[clip(0), clip(50)], &meta);
        let begun = |from, to| rows.begun([from, to], 5).map(|n| (n >> 8, n & 255)).collect::<Vec<_>>();
        assert_eq!(begun(8, 9), []);
        assert_eq!(begun(9, 10), [(0, 1)]);
        assert_eq!(begun(8, 13), [(0, 1)], "what is shorter than a step");
        assert_eq!(begun(10, 10), []);
        assert_eq!(begun(10, 11), []);
        assert_eq!(begun(19, 20), [(0, 0)]);
        assert_eq!(begun(24, 25), []);
        assert_eq!(begun(40, 25), [(0, 0)], "by a change into its middle");
        assert_eq!(begun(12, 52), [(1, 0)], "a clip that is changed to begins anew: what lies between was not played");
    }

    #[test]
    fn logs_have_what_has_changed_in_the_order_of_bodies_and_no_more_than_fits() {
        let skeleton = Skeleton::default();
        let body = LaneBody::from_skeleton(&skeleton);
        let pose = skeleton.rest_positions().map(|p| Mat3x4::from_rotation_translation(glam::Quat::IDENTITY, p));
        let mut swing = FootSwing::ZERO;
        swing.strength[1][2] = 0.4;
        let mut log = BodyEvents::with_capacity(4, 0);
        let mut before = BlockBefore { contacts: [Contacts::NONE; LANES], seen: [0.0; LANES], rows: [NO_ROW; LANES] };
        (before.contacts[2], before.seen[2], before.rows[3]) = (Contacts::LEFT, 1.0, 3);
        log.note_before(before);
        assert!((0..4).all(|row| log.has_changed(row, before.contacts[row], &swing) == (row == 2)));
        assert!(log.has_changed(1, Contacts::LEFT, &FootSwing::ZERO));
        let root = Planar::new(3.0, -1.0, 0.0);
        let of = MovedBody { body: &body, root, model: &pose, swing: &swing };
        for row in 2..4 {
            log.add_contacts(row, Id::first(row), Contacts::RIGHT_HEEL, &of);
            log.add_tags(row, Id::first(row), &ClipRows::default(), 4);
        }
        let who: Vec<_> = log.get().iter().map(|e| e.0.index()).collect();
        assert_eq!(who, [2; 4], "who was not posed before has no events of feet");
        let BodyEvent { kind, number, at, strength } = log.get()[0].1;
        assert_eq!((kind, number, strength), (BodyEventKind::Footstep, Joint::RightFoot as u32, 0.4));
        assert!((at.x - 2.908).abs() < 1e-3 && at.y.abs() < 1e-3 && (-1.0..-0.9).contains(&at.z), "{at}");
        let last = log.get()[3].1;
        assert_eq!((last.kind, last.number), (BodyEventKind::ContactBegan, Joint::RightFoot as u32));
        (0..50).for_each(|_| log.add(Id::first(1), BodyEvent::new(BodyEventKind::Performed, 0)));
        assert_eq!(log.get().len(), 4 * EVENTS_EACH);
    }
}
