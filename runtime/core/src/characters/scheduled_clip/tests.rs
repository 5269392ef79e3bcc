//! Courses against the formula of their roots, and transitions between them.

use super::*;
use crate::characters::tests::{curve, orders, plain, starts, tables};
use crate::characters::{AvoidConfig, CharactersConfig};
use crate::reserve::ReservedRegion;
use crate::skeleton::{Joint, NUM_JOINTS};
use throng_base::Error;

const RATE: f32 = 30.0;

fn scheduled_clip(frame: u32, num_frames: u32, root: Planar) -> ScheduledClip {
    ScheduledClip { frame, num_frames, root, ..ScheduledClip::default() }
}

/// Courses in both clips of the made-up tables, some of which begin in the middle and end somewhere else.
fn scheduled_clips(n: u32) -> Vec<ScheduledClip> {
    let scheduled_clip = |i: u32| ScheduledClip {
        frame: 60 * (i % 2) + 3 * i,
        num_frames: 20 + i,
        from_offset: 4 * (i % 3),
        root: Planar::new(i as f32, 2.0, 0.7 * i as f32),
        lift: 0.5 * i as f32,
        missing: Placement::new(0.1, 0.2 * i as f32, -0.3, 0.4),
    };
    (0..n).map(scheduled_clip).collect()
}

fn near(a: Planar, b: Planar) -> bool {
    let turned = crate::planar::wrap_angle(a.heading - b.heading);
    (a.x - b.x).abs() < 1e-4 && (a.z - b.z).abs() < 1e-4 && turned.abs() < 1e-4
}

impl Characters {
    /// Starts characters on scheduled clips, each at the clip's first frame.
    pub(crate) fn new_scheduled(
        motion_set: &MotionSet,
        config: CharactersConfig,
        clips: &[ScheduledClip],
    ) -> Result<Self> {
        let mut out = Self::with_capacity(motion_set, config, clips.len())?;
        clips.iter().try_for_each(|clip| out.enter_scheduled(motion_set, clip))?;
        Ok(out)
    }
}

#[test]
fn roots_are_those_of_the_clip_with_a_linear_share_of_what_is_missing() {
    let r = MotionSet::new(&tables());
    let scheduled_clips = scheduled_clips(9);
    let mut characters = Characters::new_scheduled(&r, CharactersConfig::default(), &scheduled_clips).unwrap();
    characters.step(&r, 0.0, &[]).unwrap();
    for _ in 0..3 {
        for (i, c) in scheduled_clips.iter().enumerate() {
            let (frame, time) = characters.scheduled_clip(i);
            assert_eq!(frame, c.frame);
            let (whole, part) = (time as u32, time.fract());
            let number = |k: usize| curve(&r, (c.frame + whole) as usize, part, |row| row.planar[k]);
            let moved = r.planar_root(c.frame + c.from_offset).to_local(Planar::new(number(0), number(1), number(2)));
            let share = (time - c.from_offset as f32) / (c.num_frames - c.from_offset) as f32;
            let at = c.root.compose(moved);
            let m = c.missing;
            let expected = Planar::new(at.x + share * m.x, at.z + share * m.z, at.heading + share * m.heading);
            assert!(near(characters.root(i), expected), "{:?} {expected:?}", characters.root(i));
            assert!((characters.ground_height(i) - c.lift - share * m.y).abs() < 1e-5);
        }
        characters.step(&r, 0.11, &[]).unwrap();
    }
}

#[test]
fn where_one_is_put_is_its_ground_at_once_among_those_who_make_way() {
    let r = MotionSet::new(&tables());
    let config = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
    let clips = scheduled_clips(3);
    let mut characters = Characters::with_capacity(&r, config, 2).unwrap();
    let assert_held = |characters: &mut Characters, expected: &[ScheduledClip]| {
        let mut held = ReservedRegion::default();
        characters.add_reserved_regions(&r, &mut held);
        let place = |c: &ScheduledClip| Vec2::new(c.root.x, c.root.z);
        assert!(held.bodies.iter().map(|b| b.place).eq(expected.iter().map(place)));
        let book = characters.reservations().unwrap();
        assert!(expected.iter().enumerate().all(|(at, c)| book.path(at).position_now() == place(c)));
    };
    characters.enter_scheduled(&r, &clips[0]).unwrap();
    assert_held(&mut characters, &clips[..1]);
    characters.enter_scheduled(&r, &clips[1]).unwrap();
    assert_held(&mut characters, &clips[..2]);
    characters.start_scheduled(&r, 0, &clips[2]).unwrap();
    assert_held(&mut characters, &[clips[2], clips[1]]);
}

#[test]
fn without_another_course_a_character_stays_exactly_at_the_end() {
    let r = MotionSet::new(&tables());
    let scheduled_clips = scheduled_clips(5);
    let mut characters = Characters::new_scheduled(&r, CharactersConfig::default(), &scheduled_clips).unwrap();
    for _ in 0..4 {
        characters.step(&r, 0.5, &[]).unwrap();
    }
    for (i, c) in scheduled_clips.iter().enumerate() {
        assert!(
            near(characters.root(i), c.root_at_end(&r)) && near(characters.scheduled_end(&r, i), c.root_at_end(&r))
        );
        assert!((characters.ground_height(i) - c.lift - c.missing.y).abs() < 1e-5);
        assert_eq!(characters.frames_left(i), 0.0);
    }
}

#[test]
fn time_left_goes_to_the_next_scheduled_clip_even_within_a_tick() {
    let r = MotionSet::new(&tables());
    let mut characters =
        Characters::new_scheduled(&r, CharactersConfig::default(), &[scheduled_clip(3, 4, Planar::IDENTITY)]).unwrap();
    // 2.5 frames, then 10 frames more: 1.5 end the first, 3 are the second, 5.5 are spent on the third.
    characters.step(&r, 2.5 / RATE, &[]).unwrap();
    characters.schedule_clip(&r, 0, &scheduled_clip(70, 3, characters.scheduled_end(&r, 0))).unwrap();
    let third = scheduled_clip(12, 20, characters.scheduled_end(&r, 0));
    characters.schedule_clip(&r, 0, &third).unwrap();
    characters.step(&r, 10.0 / RATE, &[]).unwrap();
    let (frame, time) = characters.scheduled_clip(0);
    assert_eq!(frame, 12);
    assert!((time - 5.5).abs() < 1e-4, "{time}");
    assert!(near(
        Planar::IDENTITY
            .compose(r.planar_root(3).to_local(r.planar_root(7)))
            .compose(r.planar_root(70).to_local(r.planar_root(73))),
        third.root
    ));
}

#[test]
fn poses_do_not_jump_where_scheduled_clips_change() {
    let r = MotionSet::new(&tables());
    let mut characters = Characters::new_scheduled(&r, plain(), &scheduled_clips(9)).unwrap();
    let dt = 1.0 / 240.0;
    characters.step(&r, 0.0, &[]).unwrap();
    let mut before: Vec<_> = (0..9).map(|c| characters.joint_positions(c)).collect();
    let mut changes = 0;
    for step in 0..700u32 {
        for c in 0..9 {
            while characters.frames_left(c) <= dt * RATE {
                changes += 1;
                let i = changes;
                let lift = characters.ground_height(c) + 0.02 * (i % 3) as f32;
                let root = characters.scheduled_end(&r, c);
                let missing = Placement::new(0.02, 0.01, 0.03, 0.05);
                let next = ScheduledClip {
                    frame: 60 * (i % 2) + 7 * (i % 5),
                    num_frames: 11 + i % 9,
                    from_offset: i % 4,
                    root,
                    lift,
                    missing,
                };
                characters.schedule_clip(&r, c, &next).unwrap();
            }
        }
        characters.step(&r, dt, &[]).unwrap();
        for c in 0..9 {
            let now = characters.joint_positions(c);
            for (a, b) in now.iter().zip(&before[c]) {
                assert!((*a - *b).length() < 7.0 * dt, "step {step}: {} m/s", (*a - *b).length() / dt);
            }
            before[c] = now;
        }
    }
    assert!(changes > 40, "{changes}");
}

#[test]
fn ground_at_any_height_is_stood_on_as_the_ground_at_none() {
    let r = MotionSet::new(&tables());
    let low = [scheduled_clip(0, 40, Planar::new(1.0, 2.0, 0.3)), scheduled_clip(65, 40, Planar::IDENTITY)];
    let high = low.map(|c| ScheduledClip { lift: 3.0, ..c });
    let mut low = Characters::new_scheduled(&r, CharactersConfig::default(), &low).unwrap();
    let mut high = Characters::new_scheduled(&r, CharactersConfig::default(), &high).unwrap();
    for _ in 0..60 {
        low.step(&r, 1.0 / 60.0, &[]).unwrap();
        high.step(&r, 1.0 / 60.0, &[]).unwrap();
        for c in 0..2 {
            let (a, b) = (low.joint_positions(c), high.joint_positions(c));
            assert!((0..NUM_JOINTS).all(|j| (b[j] - a[j] - Vec3::Y * 3.0).length() < 1e-4));
        }
    }
    assert!(low.joint_positions(0)[Joint::Hips.index()].y < 2.0);
}

#[test]
fn laid_characters_may_play_segments_again_and_choosers_may_be_laid() {
    let r = MotionSet::new(&tables());
    let orders = orders(2);
    let mut characters = Characters::new(&r, CharactersConfig::default(), &starts(2)).unwrap();
    characters.step(&r, 0.1, &orders).unwrap();
    for c in 0..2 {
        assert!(characters.step(&r, 0.1, &[]).is_err(), "a character chooses");
        let root = characters.scheduled_end(&r, c);
        characters.schedule_clip(&r, c, &ScheduledClip { lift: 1.0, ..scheduled_clip(5, 30, root) }).unwrap();
    }
    characters.step(&r, 0.7, &[]).unwrap();
    assert_eq!(
        (characters.segment(0).0, characters.last_choice(0), characters.ground_height(0)),
        (u32::MAX, None, 1.0)
    );
    assert_eq!(characters.next_blow(&r, 0), None);
    characters.play(&r, 0, 1).unwrap();
    assert!(characters.step(&r, 0.1, &[]).is_err());
    characters.step(&r, 1.0, &orders).unwrap();
    assert!(characters.last_choice(0).is_some() && characters.ground_height(0) == 0.0);
    assert_eq!(characters.segment(1).0, u32::MAX);
}

#[test]
fn scheduled_clips_beyond_their_clip_or_not_finite_are_refused() {
    let r = MotionSet::new(&tables());
    let good = scheduled_clip(0, 20, Planar::IDENTITY);
    let bad = [
        ScheduledClip { frame: 50, ..good },
        ScheduledClip { frame: 110, ..good },
        ScheduledClip { num_frames: 0, ..good },
        ScheduledClip { from_offset: 20, ..good },
        ScheduledClip { frame: u32::MAX, ..good },
        ScheduledClip { lift: f32::NAN, ..good },
        ScheduledClip { root: Planar::new(f32::INFINITY, 0.0, 0.0), ..good },
        ScheduledClip { missing: Placement::new(0.0, 0.0, 0.0, f32::NAN), ..good },
    ];
    let mut characters = Characters::new_scheduled(&r, CharactersConfig::default(), &[good]).unwrap();
    for c in bad {
        assert!(Characters::new_scheduled(&r, CharactersConfig::default(), &[c]).is_err(), "{c:?}");
        assert!(characters.schedule_clip(&r, 0, &c).is_err(), "{c:?}");
    }
    assert!(matches!(characters.schedule_clip(&r, 1, &good), Err(Error::Index { .. })));
}
