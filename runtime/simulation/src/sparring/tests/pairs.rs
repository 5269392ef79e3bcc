//! Pairs that spar.

use super::*;
use throng_base::Executor;

const DT: f32 = 1.0 / 60.0;

/// Tables whose characters strike in the first half of every segment, ever further ahead of them.
fn striking() -> Bundle {
    let starts = [0, 20, 60, 80];
    let at = |k: u32| Vec3::new(0.05 * (k as f32 - 2.0), 1.4, 0.3 + 0.15 * k as f32);
    let hits: Vec<_> = starts.iter().flat_map(|f| (0..5).map(move |k| hit(f + 1 + 2 * k, at(k), Vec3::Z))).collect();
    tables_with(&hits)
}

/// Tables of one blow, ten frames after the start, that is aimed at the head of an opponent at a distance.
fn aimed(distance: f32, direction: Vec3) -> Bundle {
    let tables = striking();
    let mut pair = spar(&tables, config(), &facing(1, distance)).unwrap();
    pair.step(0.0, &Inline).unwrap();
    (0..20).for_each(|_| pair.step(DT, &Inline).unwrap());
    // Both characters play the frames from 20 or from 80: as seen from the first one's root now.
    let root = pair.characters().root(0);
    let local = root.rotation().inverse() * (pair.heads()[0] - root.translation());
    let (segment, _) = pair.characters().segment(0);
    let frame = tables.graph().segments[segment as usize].start + 10;
    tables_with(&[hit(frame, local, direction)])
}

#[test]
fn each_ones_target_is_the_others_head() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(3, 3.0)).unwrap();
    let check = |s: &Sparring, tolerance: f32| {
        for c in 0..6 {
            let joints = s.characters().joint_positions(c ^ 1);
            let off = s.heads()[c].distance(joints[Joint::Head.index()]);
            assert!(
                (off - 0.1).abs() < tolerance,
                "the middle of the head is a tenth of a metre from its joint: {off}"
            );
        }
    };
    let at_start = s.heads().to_vec();
    s.step(0.0, &Inline).unwrap();
    check(&s, 1e-4);
    for c in 0..6 {
        assert!(s.heads()[c].distance(at_start[c]) < 0.3, "known before the first pose");
    }
    (0..30).for_each(|_| s.step(DT, &Inline).unwrap());
    check(&s, 1e-4);
}

#[test]
fn threats_are_the_opponents_next_blow() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(2, 3.0)).unwrap();
    let (mut coming, mut none) = (0, 0);
    for _ in 0..100 {
        s.step(DT, &Inline).unwrap();
        for c in 0..4 {
            match s.characters().next_blow(s.boxers().motion_set(), c ^ 1) {
                Some((b, due_s)) => {
                    let off = s.threats()[c] - Vec3::new(b.point.x, due_s, b.point.z);
                    // Bodies may have parted since.
                    assert!(off.length() < 0.01, "{off}");
                    coming += 1;
                }
                None => {
                    assert_eq!(s.threats()[c].y, NO_THREAT_S);
                    none += 1;
                }
            }
        }
    }
    assert!(coming > 50 && none > 50, "{coming} {none}");
}

#[test]
fn an_opponent_on_the_way_of_a_blow_is_struck() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(1, 3.0)).unwrap();
    s.step(0.0, &Inline).unwrap();
    let (head, way) = (s.heads()[0], s.config().strike_path_m);
    let pose = WorldPose::new(s.characters().pose(1), s.characters().root(1));
    let met = |beyond: f32| {
        let blow = Blow { point: head + Vec3::Y * beyond, direction: Vec3::Y, ..Blow::NONE };
        find_struck_capsule(s.config(), s.body(), &pose, &blow).map(|(i, depth)| (s.body().part_of(i), depth))
    };
    let (part, depth) = met(0.0).expect("in the middle of the head");
    assert_eq!(part, StruckPart::Head);
    // Up to the whole way beyond it, it went through the middle.
    assert!(met(way).is_some_and(|(p, d)| p == StruckPart::Head && (d - depth).abs() < 0.02), "{:?}", met(way));
    assert!(met(way + 0.4).is_none());
}

#[test]
fn aims_lead_the_head_by_what_its_owner_is_about_to_do() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(2, 3.0)).unwrap();
    s.step(0.0, &Inline).unwrap();
    let (mut nearer, mut further) = (0, 0);
    for _ in 0..60 {
        s.step(DT, &Inline).unwrap();
        let mut later = s.clone();
        (0..(s.lead_s / DT).round() as usize).for_each(|_| later.step(DT, &Inline).unwrap());
        for c in 0..4 {
            let (aim, head, then) = (s.aims()[c], s.heads()[c], later.heads()[c]);
            if then.distance(head) > 0.02 {
                *(if aim.distance(then) < head.distance(then) { &mut nearer } else { &mut further }) += 1;
            }
        }
    }
    assert!(nearer > 4 * further && nearer > 20, "{nearer} {further}");
}

#[test]
fn a_blow_at_the_head_lands_there_and_pushes_it() {
    let tables = aimed(3.0, Vec3::new(0.8, 0.0, 0.6));
    let separation = SeparationConfig { enabled: false, ..SeparationConfig::default() };
    let config = SparringConfig { separation, ..config() };
    let mut s = spar(&tables, config, &facing(1, 3.0)).unwrap();
    let soft = SparringConfig { push_m_per_mps: 0.0, ..config };
    let mut twin = spar(&tables, soft, &facing(1, 3.0)).unwrap();
    let mut landed = Vec::new();
    let mut pushed = 0.0f32;
    s.step(0.0, &Inline).unwrap();
    twin.step(0.0, &Inline).unwrap();
    for _ in 0..30 {
        s.step(DT, &Inline).unwrap();
        twin.step(DT, &Inline).unwrap();
        landed.extend(s.events().iter().map(|e| e.1));
        if let Some(l) = landed.first() {
            // The head of the struck one, against one that was not pushed.
            let c = l.blow.character as usize;
            pushed = pushed.max((s.heads()[c] - twin.heads()[c]).dot(l.blow.direction));
        }
    }
    let first = landed.iter().find(|l| l.blow.character == 0).unwrap();
    assert_eq!((first.opponent, first.part, first.joint), (Id::first(1), StruckPart::Head, Joint::Head));
    assert!(!first.is_blocked() && first.depth_m > 0.1, "right in the middle: {}", first.depth_m);
    let asked = 6.0 * s.config().push_m_per_mps;
    assert!(pushed > 0.6 * asked && pushed < 1.3 * asked, "{pushed} of {asked}");
}

#[test]
fn who_is_struck_hard_steps_away_with_the_blow() {
    // A blow from behind, as all motion leads ahead.
    let tables = aimed(3.0, -Vec3::Z);
    let struck = |force: f32| {
        let config = SparringConfig { stagger: StaggerConfig { force, alike_m: 1.0 }, ..config() };
        let mut s = spar(&tables, config, &facing(1, 3.0)).unwrap();
        s.step(0.0, &Inline).unwrap();
        for _ in 0..60 {
            let before = s.characters().segment(1);
            s.step(DT, &Inline).unwrap();
            let landed = s.events().iter().find(|(id, l)| *id == Id::first(0) && !l.is_blocked());
            if let Some((_, landing)) = landed {
                let to = Planar::new(landing.blow.direction.x, landing.blow.direction.z, 0.0);
                return Some((before, s.characters().segment(1), to, s.characters().root(1)));
            }
        }
        None
    };
    let (before, after, along, root) = struck(0.5).expect("a blow lands");
    assert_eq!(after.1, 0.0, "it begins an action: {before:?} {after:?}");
    let way = tables.graph().segments[after.0 as usize].displacement();
    let way = root.rotation() * Vec3::new(way.x, 0.0, way.z);
    assert!(way.normalize().dot(along.translation()) > 0.5, "{way} along {along:?}");
    let (before, after, ..) = struck(1.1).expect("the same blow");
    assert!(after.0 == before.0 && after.1 > before.1, "it goes on: {before:?} {after:?}");
}

#[test]
fn every_blow_is_counted_once() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(20, 1.2)).unwrap();
    let (mut thrown, mut landed, mut blocked) = (0, 0, 0);
    for _ in 0..200 {
        s.step(DT, &Inline).unwrap();
        thrown += s.characters().blows().len();
        blocked += s.events().iter().filter(|(_, l)| l.is_blocked()).count();
        landed += s.events().iter().filter(|(_, l)| !l.is_blocked()).count();
        for (id, l) in s.events() {
            assert!(s.characters().blows().contains(&l.blow));
            assert_eq!((l.opponent, l.blow.character), (s.opponent(*id).unwrap(), id.index));
            assert!(l.depth_m >= 0.0);
        }
    }
    let all = s.figures().blows;
    assert_eq!((all.thrown as usize, all.landed as usize, all.blocked as usize), (thrown, landed, blocked));
    assert_eq!(all.thrown, all.landed + all.blocked + all.missed);
    assert!(landed + blocked > 10 && all.missed > 10 && thrown > 500, "{all:?}");
    let mut sum = BlowTally::default();
    (0..40).for_each(|c| sum += s.tally(Id::first(c)).unwrap());
    assert_eq!(sum, all);
}

#[test]
fn bodies_that_overlap_part() {
    let tables = tables_with(&[]);
    // Side by side and into each other, on paths that cross.
    let roots = [Planar::IDENTITY, Planar::new(0.25, 0.0, 0.0)];
    let starts = [roots.map(|root| Spawn { root, state: Some(0), floor_m: 0.0 })];
    let run = |enabled: bool| {
        let separation = SeparationConfig { enabled, ..SeparationConfig::default() };
        let mut s = spar(&tables, SparringConfig { separation, ..config() }, &starts).unwrap();
        s.step(0.0, &Inline).unwrap();
        let mut path = Vec::new();
        for _ in 0..20 {
            s.step(DT, &Inline).unwrap();
            path.push((
                s.overlap_m(0),
                s.characters().root(0).translation().distance(s.characters().root(1).translation()),
            ));
        }
        (path, s.figures())
    };
    let ((with, figures), (without, _)) = (run(true), run(false));
    let most = SeparationConfig::default().max_speed_mps;
    let mut last = 0.0;
    for (k, (a, b)) in with.iter().zip(&without).enumerate() {
        let further = a.1 - b.1;
        assert!(further - last < most * DT * 1.01 && further > last - 1e-6, "step {k}: {further} after {last}");
        last = further;
    }
    assert!(last > 0.05, "{last}");
    assert!((figures.max_penetration_m - with.iter().map(|p| p.0).fold(0.0, f32::max)).abs() < 1e-6);
    let deep_s = with.iter().filter(|p| p.0 > SeparationConfig::default().deep_m).count() as f32 * DT;
    assert!((figures.deep_s - deep_s).abs() < DT * 1.1 && deep_s > 0.0, "{} {deep_s}", figures.deep_s);
    assert_eq!(figures.penetration_m, with[19].0);
}

#[test]
fn restored_pairs_repeat_what_followed_bit_by_bit() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(7, 1.2)).unwrap();
    (0..4).for_each(|_| s.step(DT, &Inline).unwrap());
    let mut kept = Vec::new();
    s.save(&mut kept);
    // Bodies keep the planes of their feet, knees and gaze, and the height of their hips, 150 bytes, and arms and clips that are laid
    // over their motion, 180 bytes, beside motion, offsets, reactions, the floor, and orders with a manner and the velocity of their
    // target, of now and of the step before.
    assert!(kept.len() < 14 * 1610, "{}", kept.len());
    let posed = s.characters().model_matrices().to_vec();
    let run = |s: &mut Sparring| {
        let step = |_| {
            s.step(DT, &Inline).unwrap();
            (s.characters().model_matrices().to_vec(), s.events().to_vec(), s.heads().to_vec(), s.figures())
        };
        (0..120).map(step).collect::<Vec<_>>()
    };
    let first = run(&mut s);
    assert!(first.iter().any(|f| !f.1.is_empty()));
    s.load(&kept).unwrap();
    assert!(s.events().is_empty());
    let off = |(a, b): (&Mat3x4, &Mat3x4)| a.translation().distance(b.translation());
    let shown = s.characters().model_matrices();
    assert!(shown.iter().zip(&posed).map(off).all(|m| m < 1e-4), "arms are shown where they were");
    assert!(first == run(&mut s));
    let refused = |config, n| spar(&tables, config, &facing(n, 1.2)).unwrap().load(&kept).unwrap_err();
    assert!(matches!(refused(config(), 6), Error::Snapshot { .. }), "other pairs");
    assert!(
        matches!(refused(SparringConfig { reach_m: 0.1, ..config() }, 7), Error::Snapshot { .. }),
        "another config"
    );
}

/// Two parts at once, the later one first.
struct Two;

impl Executor for Two {
    fn run(&self, num_parts: usize, part: &(dyn Fn(usize) + Sync)) {
        std::thread::scope(|scope| {
            scope.spawn(|| (num_parts / 2..num_parts).for_each(part));
            (0..num_parts / 2).rev().for_each(part);
        });
    }
}

#[test]
fn pairs_spar_the_same_on_several_threads() {
    let tables = striking();
    let mut alone = spar(&tables, config(), &facing(300, 1.2)).unwrap();
    let mut together = alone.clone();
    for _ in 0..60 {
        alone.step(DT, &Inline).unwrap();
        together.step(DT, &Two).unwrap();
        assert!(alone.characters().model_matrices() == together.characters().model_matrices());
        assert_eq!(alone.events(), together.events());
    }
    assert_eq!(alone.figures(), together.figures());
    assert!(alone.figures().blows.landed > 0);
}

#[test]
fn refuses_what_does_not_fit() {
    let tables = striking();
    let new = |config: SparringConfig| spar(&tables, config, &facing(2, 2.0));
    let body = BodyShape { head_m: 0.0, ..BodyShape::default() };
    assert!(matches!(new(SparringConfig { body, ..config() }), Err(Error::Value { what: "body.head_m", .. })));
    let characters = CharactersConfig { half_life_s: -1.0, ..CharactersConfig::default() };
    assert!(matches!(new(SparringConfig { characters, ..config() }), Err(Error::Value { .. })));
    let mut none = spar(&tables, config(), &[]).unwrap();
    none.step(DT, &Inline).unwrap();
    assert_eq!(none.figures().blows, BlowTally::default());
    assert!(matches!(none.spawn(facing(1, 2.0)[0]), Err(Error::Full { capacity: 0 })));
    let mut two = new(config()).unwrap();
    let last = two.bodies().ids[3];
    let refused = [(1, 1.0), (0, f32::NAN)]
        .map(|(policy, weight)| two.order(last, PolicyOrder::IDLE.with_policy(policy, weight)));
    let [Err(Error::Index { who: a, .. }), Err(Error::Value { who: b, .. })] = refused else { panic!("{refused:?}") };
    assert_eq!([a, b], [Some(last); 2]);
    let mut pair = facing(1, 2.0)[0];
    pair[1].state = Some(99);
    two.despawn(last).unwrap();
    assert!(matches!(two.spawn(pair), Err(Error::Index { what: "state", .. })));
    assert_eq!((two.bodies().ids.len(), two.num_pairs()), (2, 1), "half a pair does not enter");
}

#[test]
fn a_pair_leaves_together_and_the_others_go_on_as_before() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(3, 1.2)).unwrap();
    (0..40).for_each(|_| s.step(DT, &Inline).unwrap());
    let mut all = s.clone();
    let ids = s.bodies().ids.to_vec();
    // Either of the two takes the other one along; the last pair takes their rows.
    s.despawn(ids[1]).unwrap();
    assert_eq!(s.bodies().ids, [ids[4], ids[5], ids[2], ids[3]]);
    assert_eq!((s.opponent(ids[5]).unwrap(), s.opponent(ids[2]).unwrap()), (ids[4], ids[3]));
    for gone in &ids[..2] {
        assert!(matches!(s.status(*gone), Err(Error::Gone(id)) if id == *gone));
    }
    for _ in 0..60 {
        s.step(DT, &Inline).unwrap();
        all.step(DT, &Inline).unwrap();
        for id in &ids[2..] {
            let [a, b] = [&s, &all].map(|of| of.bodies().get(*id).map(|body| (body.root, *body.model)));
            assert!(a == b && s.tally(*id).unwrap() == all.tally(*id).unwrap());
        }
    }
    let again = s.spawn(facing(1, 1.2)[0]).unwrap();
    assert!((again.index(), again.generation) == (0, 1) && s.num_pairs() == 3);
    assert_eq!(s.tally(again).unwrap(), BlowTally::default());
}

#[test]
fn who_is_placed_elsewhere_is_aimed_at_there() {
    let tables = striking();
    let mut s = spar(&tables, config(), &facing(1, 3.0)).unwrap();
    (0..10).for_each(|_| s.step(DT, &Inline).unwrap());
    let id = s.bodies().ids[1];
    s.place(id, Planar::new(8.0, 9.0, 1.0)).unwrap();
    let told = s.heads()[0];
    s.step(0.0, &Inline).unwrap();
    assert!(told.distance(s.heads()[0]) < 1e-3 && s.heads()[0].distance(Vec3::new(8.0, told.y, 9.0)) < 0.5);
}

#[test]
fn another_bundle_is_adopted() {
    let (tables, other) = (striking(), tables_with(&[]));
    let mut s = spar(&tables, config(), &facing(2, 1.2)).unwrap();
    (0..30).for_each(|_| s.step(DT, &Inline).unwrap());
    assert_eq!(s.adopt(&other).unwrap().num_characters, 4);
    let thrown = s.figures().blows.thrown;
    (0..60).for_each(|_| s.step(DT, &Inline).unwrap());
    assert!(thrown > 0 && s.figures().blows.thrown == thrown, "nobody strikes in the new one");
}
