//! Effective hits that are passed as motion plays.

use super::*;

/// A hit at a frame; its position identifies it.
pub(crate) fn hit(frame: u32) -> HitRecord {
    HitRecord {
        frame,
        kind: 0,
        joint: Joint::LeftHand as u32,
        force: 0.5,
        position: [0.2, 1.3, 0.4 + 0.001 * frame as f32],
        speed_mps: 5.0,
        direction: [0.6, 0.0, 0.8],
        reserved: 0,
    }
}

/// Segments start at 0, 20 and, in the other clip, 60, 80; each plays 20 frames.
fn hits() -> Vec<HitRecord> {
    [0, 5, 20, 25, 33, 39, 40, 60, 66, 79, 80, 81, 90, 100].map(hit).to_vec()
}

/// Blows of all characters, from the segments they play: a plain replay of every character, frame by frame.
fn expected(r: &MotionSet, before: &[(u32, f32)], after: &[(u32, f32)]) -> Vec<(u32, u32)> {
    let mut out = Vec::new();
    let offset = |s: u32, h: &HitRecord| h.frame as f32 - r.graph.segments[s as usize].start as f32;
    for (c, (&(s0, t0), &(s1, t1))) in before.iter().zip(after).enumerate() {
        let length = r.graph.segments[s0 as usize].num_frames as f32;
        let mut add = |s: u32, from: f32, to: f32| {
            for (i, h) in r.hits.iter().enumerate() {
                let at = offset(s, h);
                if at > from && at <= to && at <= 20.0 {
                    out.push((c as u32, i as u32));
                }
            }
        };
        let changed = s0 != s1 || t1 < t0;
        if changed {
            add(s0, t0, length);
            add(s1, 0.0, t1);
        } else {
            add(s0, t0, t1);
        }
    }
    out
}

#[test]
fn characters_strike_where_they_pass_the_frames_of_hits() {
    let r = MotionSet::new(&tables_with(&hits()));
    let n = 150;
    let orders = orders(n);
    // 20 frames are no whole number of steps: segments change within steps and at their ends.
    for dt in [1.0 / 60.0, 1.0 / 37.0, 1.0 / 30.0, 0.2] {
        let mut characters = Characters::new(&r, plain(), &starts(n)).unwrap();
        let playing = |t: &Characters| (0..n).map(|c| t.segment(c)).collect::<Vec<_>>();
        characters.step(&r, 0.0, &orders).unwrap();
        assert!(characters.blows().is_empty());
        let mut struck = 0;
        for _ in 0..90 {
            let before = playing(&characters);
            characters.step(&r, dt, &orders).unwrap();
            let got: Vec<_> = characters.blows().iter().map(|b| (b.character, b.hit)).collect();
            assert_eq!(got, expected(&r, &before, &playing(&characters)), "{dt}");
            struck += got.len();
        }
        assert!(struck > n, "{struck}");
    }
}

#[test]
fn a_blow_is_where_the_clip_lies_in_the_world() {
    let orders = orders(9);
    for tables in [tables_with(&hits()), crate::characters::made_up::bent_tables(&hits())] {
        let r = MotionSet::new(&tables);
        let mut characters = Characters::new(&r, plain(), &starts(9)).unwrap();
        let mut seen = 0;
        for _ in 0..200 {
            // A step a frame: a blow lies where the root is, then.
            characters.step(&r, 1.0 / 30.0, &orders).unwrap();
            for b in characters.blows() {
                let (root, h) = (characters.root(b.character as usize), &r.hits[b.hit as usize]);
                let want = root.rotation() * h.position() + root.translation();
                assert!(b.point.distance(want) < 1e-4, "{} {want}", b.point);
                assert!(b.direction.distance(root.rotation() * h.direction()) < 1e-5);
                assert_eq!((b.joint, b.speed_mps, b.force), (Joint::LeftHand, 5.0, 0.5));
                seen += 1;
            }
        }
        assert!(seen > 20);
    }
}

#[test]
fn the_next_blow_is_the_one_that_comes_when_it_is_due() {
    let (r, mut characters, orders) = moving(&tables_with(&[5, 12, 33, 66, 90].map(hit)), 9);
    let dt = 1.0 / 60.0;
    let mut announced: Vec<Option<(Blow, f32)>> = vec![None; 9];
    let (mut came, mut none) = (0, 0);
    for _ in 0..300 {
        characters.step(&r, dt, &orders).unwrap();
        for c in 0..9 {
            let struck = characters.blows().iter().find(|b| b.character == c as u32);
            if let (Some((blow, due_s)), Some(struck)) = (announced[c], struck) {
                assert_eq!(blow.hit, struck.hit);
                assert!(due_s > -1e-4 && due_s < dt + 1e-4 && blow.point.distance(struck.point) < 1e-4);
                came += 1;
            }
            announced[c] = characters.next_blow(&r, c);
            none += u32::from(announced[c].is_none());
        }
    }
    assert!(came > 30 && none > 30, "{came} {none}");
}

#[test]
fn travel_is_where_the_motion_leads_until_its_action_ends() {
    let (r, mut characters, orders) = moving(&tables(), 9);
    // A frame of the database a step, so that poses are its own.
    let dt = 1.0 / r.rate_hz;
    let head = |characters: &Characters, c: usize| characters.joint_positions(c)[Joint::Head.index()];
    let (mut checked, mut known) = (0, [TravelPoints::default(); 9]);
    for _ in 0..120 {
        characters.step(&r, dt, &orders).unwrap();
        let now = |c: usize| (characters.segment(c), head(&characters, c));
        let ahead: Vec<_> = (0..9).map(now).collect();
        let travel = |c: usize, known: &mut TravelPoints| {
            characters.travel_of_point(&r, c, Joint::Head, Vec3::ZERO, 3.0 * dt, known)
        };
        let anew = |c: usize| travel(c, &mut TravelPoints::default());
        let travel: Vec<_> = known.iter_mut().enumerate().map(|(c, known)| travel(c, known)).collect();
        assert_eq!(travel, (0..9).map(anew).collect::<Vec<_>>());
        let mut later = characters.clone();
        (0..3).for_each(|_| later.step(&r, dt, &orders).unwrap());
        for (c, &((segment, time), at)) in ahead.iter().enumerate() {
            let settled = time > 15.0 && later.segment(c).0 == segment && later.segment(c).1 > time;
            if settled {
                let off = (at + travel[c]).distance(head(&later, c));
                assert!(off < 0.02, "{off}");
                checked += 1;
            }
        }
        let whole = (0..9)
            .map(|c| characters.travel_of_point(&r, c, Joint::Head, Vec3::ZERO, 1e3, &mut TravelPoints::default()));
        assert!(whole.into_iter().all(|t| t.is_finite() && t.length() < 10.0));
    }
    assert!(checked > 20, "{checked}");
}

#[test]
fn no_more_blows_of_a_character_in_a_step_than_there_is_room_for() {
    let every: Vec<_> = (0..2 * FRAMES).map(hit).collect();
    let (r, mut characters, orders) = moving(&tables_with(&every), 3);
    for _ in 0..5 {
        characters.step(&r, 1.0, &orders).unwrap();
        let of: Vec<_> = characters.blows().iter().map(|b| b.character).collect();
        assert_eq!(of, [[0; MAX_BLOWS], [1; MAX_BLOWS], [2; MAX_BLOWS]].concat());
    }
}

#[test]
fn a_bundle_without_hits_has_no_blows() {
    let (r, mut characters, orders) = moving(&tables(), 3);
    for _ in 0..50 {
        characters.step(&r, 0.1, &orders).unwrap();
        assert!(characters.blows().is_empty() && characters.next_blow(&r, 0).is_none());
    }
}

#[test]
fn motion_and_blows_are_the_same_on_several_threads() {
    let r = MotionSet::new(&tables_with(&hits()));
    let n = 300;
    let orders = orders(n);
    for choice in [ActionChoice::BestAction, ActionChoice::LookAhead { temperature: 0.3 }] {
        let config = CharactersConfig { choice, ..CharactersConfig::default() };
        let mut whole = Characters::new(&r, config, &starts(n)).unwrap();
        let mut split = whole.clone();
        for step in 0..100 {
            whole.step(&r, 1.0 / 40.0, &orders).unwrap();
            split.step_on(&r, 1.0 / 40.0, &orders, &TwoThreads).unwrap();
            assert_eq!(whole.blows(), split.blows());
            for t in [&mut whole, &mut split] {
                t.push(step % n, Joint::Head, Vec3::new(0.0, 0.02, 0.05)).unwrap();
            }
            assert!(whole.model_matrices() == split.model_matrices());
        }
        assert!(whole.num_choices(0) > 2);
    }
}
