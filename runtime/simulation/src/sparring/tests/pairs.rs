//! Pairs that spar.

use super::*;
use throng_base::{Error, Run};

const DT: f32 = 1.0 / 60.0;

/// Tables whose characters strike in the first half of every segment, ever further ahead of them.
fn striking() -> Bundle {
    let starts = [0, 20, 60, 80];
    let at = |k: u32| Vec3::new(0.05 * (k as f32 - 2.0), 1.4, 0.3 + 0.15 * k as f32);
    let hits: Vec<_> = starts.iter().flat_map(|f| (0..5).map(move |k| hit(f + 1 + 2 * k, at(k), Vec3::Z))).collect();
    tables_with(&hits)
}

/// Tables of one blow, ten frames after the start, that is aimed at the head of an opponent at a distance.
fn aimed(distance: f32) -> Bundle {
    let tables = striking();
    let r = MotionSet::new(&tables);
    let mut pair = Sparring::new(&r, config(), &facing(1, distance)).unwrap();
    pair.step(&r, 0.0).unwrap();
    (0..20).for_each(|_| pair.step(&r, DT).unwrap());
    // Both characters play the frames from 20 or from 80: as seen from the first one's root now.
    let root = pair.characters().root(0);
    let local = root.rotation().inverse() * (pair.heads()[0] - root.translation());
    let (segment, _) = pair.characters().segment(0);
    let frame = r.graph().segments[segment as usize].start + 10;
    drop(r);
    tables_with(&[hit(frame, local, Vec3::new(0.8, 0.0, 0.6))])
}

#[test]
fn each_ones_target_is_the_others_head() {
    let tables = striking();
    let r = MotionSet::new(&tables);
    let mut s = Sparring::new(&r, config(), &facing(3, 3.0)).unwrap();
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
    s.step(&r, 0.0).unwrap();
    check(&s, 1e-4);
    for c in 0..6 {
        assert!(s.heads()[c].distance(at_start[c]) < 0.3, "known before the first pose");
    }
    (0..30).for_each(|_| s.step(&r, DT).unwrap());
    check(&s, 1e-4);
}

#[test]
fn threats_are_the_opponents_next_blow() {
    let tables = striking();
    let r = MotionSet::new(&tables);
    let mut s = Sparring::new(&r, config(), &facing(2, 3.0)).unwrap();
    let (mut coming, mut none) = (0, 0);
    for _ in 0..100 {
        s.step(&r, DT).unwrap();
        for c in 0..4 {
            match s.characters().next_blow(&r, c ^ 1) {
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
fn a_blow_at_the_head_lands_there_and_pushes_it() {
    let tables = aimed(3.0);
    let r = MotionSet::new(&tables);
    let separation = SeparationConfig { enabled: false, ..SeparationConfig::default() };
    let config = SparringConfig { separation, ..config() };
    let mut s = Sparring::new(&r, config.clone(), &facing(1, 3.0)).unwrap();
    let soft = SparringConfig { push_m_per_mps: 0.0, ..config };
    let mut twin = Sparring::new(&r, soft, &facing(1, 3.0)).unwrap();
    let mut landed = Vec::new();
    let mut pushed = 0.0f32;
    s.step(&r, 0.0).unwrap();
    twin.step(&r, 0.0).unwrap();
    for _ in 0..30 {
        s.step(&r, DT).unwrap();
        twin.step(&r, DT).unwrap();
        landed.extend_from_slice(s.landed());
        if let Some(l) = landed.first() {
            // The head of the struck one, against one that was not pushed.
            let c = l.blow.character as usize;
            pushed = pushed.max((s.heads()[c] - twin.heads()[c]).dot(l.blow.direction));
        }
    }
    let first = landed.iter().find(|l| l.blow.character == 0).unwrap();
    assert_eq!((first.opponent, first.part, first.joint), (1, Part::Head, Joint::Head));
    assert!(!first.is_blocked() && first.depth_m > 0.1, "right in the middle: {}", first.depth_m);
    let asked = 6.0 * s.config().push_m_per_mps;
    assert!(pushed > 0.6 * asked && pushed < 1.3 * asked, "{pushed} of {asked}");
}

#[test]
fn every_blow_is_counted_once() {
    let tables = striking();
    let r = MotionSet::new(&tables);
    let mut s = Sparring::new(&r, config(), &facing(20, 1.2)).unwrap();
    let (mut thrown, mut landed, mut blocked) = (0, 0, 0);
    for _ in 0..200 {
        s.step(&r, DT).unwrap();
        thrown += s.characters().blows().len();
        blocked += s.landed().iter().filter(|l| l.is_blocked()).count();
        landed += s.landed().iter().filter(|l| !l.is_blocked()).count();
        for l in s.landed() {
            assert!(s.characters().blows().contains(&l.blow));
            assert_eq!(l.opponent, l.blow.character ^ 1);
            assert!(l.depth_m >= 0.0);
        }
    }
    let all = s.figures().blows;
    assert_eq!((all.thrown as usize, all.landed as usize, all.blocked as usize), (thrown, landed, blocked));
    assert_eq!(all.thrown, all.landed + all.blocked + all.missed);
    assert!(landed + blocked > 10 && all.missed > 10 && thrown > 500, "{all:?}");
    let mut sum = Tally::default();
    (0..40).for_each(|c| sum += s.tally(c));
    assert_eq!(sum, all);
}

#[test]
fn bodies_that_overlap_part() {
    let tables = tables_with(&[]);
    let r = MotionSet::new(&tables);
    // Side by side and into each other, on paths that cross.
    let roots = [Planar::IDENTITY, Planar::new(0.25, 0.0, 0.0)];
    let starts = roots.map(|root| Start { root, state: 0 });
    let run = |enabled: bool| {
        let separation = SeparationConfig { enabled, ..SeparationConfig::default() };
        let mut s = Sparring::new(&r, SparringConfig { separation, ..config() }, &starts).unwrap();
        s.step(&r, 0.0).unwrap();
        let mut path = Vec::new();
        for _ in 0..20 {
            s.step(&r, DT).unwrap();
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
    let r = MotionSet::new(&tables);
    let mut s = Sparring::new(&r, config(), &facing(7, 1.2)).unwrap();
    (0..4).for_each(|_| s.step(&r, DT).unwrap());
    let mut kept = Vec::new();
    s.save(&mut kept);
    assert!(kept.len() < 14 * 700, "{}", kept.len());
    let run = |s: &mut Sparring| {
        let step = |_| {
            s.step(&r, DT).unwrap();
            (s.characters().model_matrices().to_vec(), s.landed().to_vec(), s.heads().to_vec(), s.figures())
        };
        (0..120).map(step).collect::<Vec<_>>()
    };
    let first = run(&mut s);
    assert!(first.iter().any(|f| !f.1.is_empty()));
    s.load(&r, &kept).unwrap();
    assert!(s.landed().is_empty());
    assert!(first == run(&mut s));
    let refused = |config, n| Sparring::new(&r, config, &facing(n, 1.2)).unwrap().load(&r, &kept).unwrap_err();
    assert!(matches!(refused(config(), 6), Error::Snapshot { .. }), "other pairs");
    assert!(
        matches!(refused(SparringConfig { reach_m: 0.1, ..config() }, 7), Error::Snapshot { .. }),
        "another config"
    );
}

/// Two parts at once, the later one first.
struct Two;

impl Run for Two {
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
    let r = MotionSet::new(&tables);
    let mut alone = Sparring::new(&r, config(), &facing(300, 1.2)).unwrap();
    let mut together = alone.clone();
    for _ in 0..60 {
        alone.step(&r, DT).unwrap();
        together.step_on(&r, DT, &Two).unwrap();
        assert!(alone.characters().model_matrices() == together.characters().model_matrices());
        assert_eq!(alone.landed(), together.landed());
    }
    assert_eq!(alone.figures(), together.figures());
    assert!(alone.figures().blows.landed > 0);
}

#[test]
fn refuses_what_does_not_fit() {
    let tables = striking();
    let r = MotionSet::new(&tables);
    let new = |config: SparringConfig, n: usize| Sparring::new(&r, config, &facing(2, 2.0)[..n]);
    assert!(matches!(new(config(), 3), Err(Error::Length { what: "starts", got: 3, .. })));
    assert!(matches!(new(SparringConfig::default(), 2), Err(Error::Value { what: "the number of goals", .. })));
    let goal = SparringGoal { policy: 1, weight: 1.0, aim: Aim::OpponentHead };
    assert!(matches!(new(SparringConfig::new(vec![goal]), 2), Err(Error::Index { what: "policy", .. })));
    let goal = SparringGoal { policy: 0, weight: f32::NAN, aim: Aim::OpponentHead };
    assert!(matches!(new(SparringConfig::new(vec![goal]), 2), Err(Error::Value { what: "weight", .. })));
    let body = BodyShape { head_m: 0.0, ..BodyShape::default() };
    let thin = SparringConfig { body, ..config() };
    assert!(matches!(new(thin, 2), Err(Error::Value { what: "body.head_m", .. })));
    let characters = CharactersConfig { half_life_s: -1.0, ..CharactersConfig::default() };
    assert!(matches!(new(SparringConfig { characters, ..config() }, 2), Err(Error::Value { .. })));
    let mut none = new(config(), 0).unwrap();
    none.step(&r, DT).unwrap();
    assert_eq!(none.figures().blows, Tally::default());
}
