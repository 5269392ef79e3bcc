use super::*;
use crate::characters::ActionChoice;
use crate::characters::made_up::tables;
use crate::characters::manner::Manners;
use crate::characters::tests::TwoThreads;
use crate::stops::{SLOW_DOWN, StopRecord, WALK_ON};
use throng_base::Inline;

const DT: f32 = 1.0 / 40.0;

fn config() -> CharactersConfig {
    CharactersConfig { choice: ActionChoice::LookAhead { temperature: 0.4 }, ..CharactersConfig::default() }
}

fn root(i: usize) -> Planar {
    Planar::new(i as f32, -2.0, 0.5 * i as f32)
}

fn target(i: usize) -> Vec3 {
    Vec3::new(3.0 - i as f32, 0.0, 1.0 + 0.3 * i as f32)
}

fn spawn(group: &mut PolicyCharacters, i: usize) -> Id {
    let id = group.spawn(Spawn { root: root(i), state: Some(i as u32 % 4), floor_m: 0.0 }).unwrap();
    group.order(id, PolicyOrder::towards(0, target(i))).unwrap();
    id
}

fn group_of(n: usize, capacity: usize) -> PolicyCharacters {
    let mut group = PolicyCharacters::with_capacity(&tables(), capacity, config()).unwrap();
    (0..n).for_each(|i| assert_eq!(spawn(&mut group, i), Id::first(i)));
    group
}

fn step(group: &mut PolicyCharacters, times: usize) {
    (0..times).for_each(|_| group.step(DT, &Inline).unwrap());
}

/// Planar root and pose of a character.
fn seen(group: &PolicyCharacters, id: Id) -> (Planar, [crate::Mat3x4; NUM_JOINTS]) {
    let bodies = group.bodies();
    let body = bodies.get(id).unwrap();
    (body.root, *body.model)
}

#[test]
fn orders_of_each_are_those_of_all_where_they_are_the_same() {
    let n = 150;
    let mut group = group_of(n, 200);
    let motion_set = MotionSet::new(&tables());
    let starts: Vec<CharacterStart> = (0..n).map(|i| CharacterStart { root: root(i), state: i as u32 % 4 }).collect();
    let orders: Vec<PolicyOrder> = (0..n).map(|i| PolicyOrder::towards(0, target(i))).collect();
    let mut batch = Characters::new(&motion_set, config(), &starts).unwrap();
    for _ in 0..100 {
        group.step(DT, &Inline).unwrap();
        batch.step(&motion_set, DT, &orders).unwrap();
    }
    assert!(group.bodies().model.as_flattened() == batch.model_matrices());
    assert!((0..n).all(|c| group.bodies().roots[c] == batch.root(c)) && batch.num_choices(0) > 2);
}

#[test]
fn neither_threads_nor_who_left_before_change_what_others_do() {
    let n = 300;
    let (mut whole, mut split) = (group_of(n, n), group_of(n, n));
    step(&mut whole, 20);
    (0..20).for_each(|_| split.step(DT, &TwoThreads).unwrap());
    assert_eq!(whole.hash(), split.hash());
    // Others move to the rows of those that leave; ids stay.
    for i in [0, 7, 130, 131, 250, 299] {
        split.despawn(Id::first(i)).unwrap();
    }
    step(&mut whole, 60);
    (0..60).for_each(|_| split.step(DT, &TwoThreads).unwrap());
    assert_eq!(split.ids().len(), n - 6);
    for &id in split.ids() {
        assert!(seen(&whole, id) == seen(&split, id), "{id}");
    }
}

#[test]
fn who_has_left_is_gone_and_the_next_one_is_somebody_else() {
    let mut group = group_of(3, 3);
    assert!(matches!(group.spawn(Spawn::standing_at(root(3))), Err(Error::Full { capacity: 3 })));
    let gone = Id::first(1);
    group.despawn(gone).unwrap();
    assert!(group.bodies().get(gone).is_none());
    for result in [
        group.despawn(gone),
        group.place(gone, root(1)),
        group.order(gone, PolicyOrder::IDLE),
        group.play_segment(gone, 0),
    ] {
        assert!(matches!(result, Err(Error::Gone(id)) if id == gone));
    }
    assert!(matches!(group.status(gone), Err(Error::Gone(_))) && group.contacts(gone).is_err());
    step(&mut group, 5);
    let next = group.spawn(Spawn::standing_at(root(9))).unwrap();
    assert_eq!(next, Id { index: 1, generation: 1 });
    assert_eq!((group.bodies().get(next).unwrap().root, group.status(next).unwrap()), (root(9), OrderStatus::Idle));
    step(&mut group, 5);
    assert!(group.bodies().ids.len() == 3 && group.bodies().get(gone).is_none());
}

#[test]
fn an_order_stays_until_it_is_changed() {
    let mut group = group_of(2, 2);
    let [a, b] = [0, 1].map(Id::first);
    group.order(a, PolicyOrder::towards(0, Vec3::new(400.0, 0.0, 0.0))).unwrap();
    step(&mut group, 80);
    assert_eq!(group.order_of(a).unwrap().target().x, 400.0);
    let OrderStatus::Going { left_m } = group.status(a).unwrap() else { panic!("it cannot be there yet") };
    let at = group.bodies().get(a).unwrap().root;
    assert!((left_m - (400.0 - at.x).hypot(at.z)).abs() < 1e-2);
    let here = group.bodies().get(b).unwrap().root;
    group.order(b, PolicyOrder::towards(0, here.translation())).unwrap();
    assert_eq!(group.status(b).unwrap(), OrderStatus::Arrived);
    group.order(b, PolicyOrder::IDLE).unwrap();
    assert_eq!(group.status(b).unwrap(), OrderStatus::Idle);
    let e = group.order(b, PolicyOrder::towards(0, Vec3::new(f32::NAN, 0.0, 0.0))).unwrap_err().to_string();
    assert!(e.contains("target x") && e.starts_with("1: "), "{e}");
    assert_eq!(group.status(b).unwrap(), OrderStatus::Idle);
}

#[test]
fn who_is_placed_elsewhere_is_there_at_once_with_free_feet() {
    let mut group = group_of(9, 9);
    step(&mut group, 30);
    let (id, there) = (Id::first(4), Planar::new(50.0, -30.0, 1.0));
    let (_, before) = seen(&group, id);
    group.place(id, there).unwrap();
    assert_eq!(group.bodies().get(id).unwrap().root, there);
    group.step(0.0, &Inline).unwrap();
    let (root, model) = seen(&group, id);
    assert!((root.x - there.x).hypot(root.z - there.z) < 1e-4 && (root.heading - there.heading).abs() < 1e-4);
    // Feet were held back by no more than the lock allows; nothing is drawn after from where it stood.
    for (a, b) in before.iter().zip(&model) {
        assert!(a.translation().distance(b.translation()) < 0.3);
    }
    assert!(group.place(id, Planar::new(f32::NAN, 0.0, 0.0)).is_err());
}

#[test]
fn what_was_saved_comes_back_and_goes_on_as_it_did() {
    let mut group = group_of(21, 30);
    step(&mut group, 37);
    group.despawn(Id::first(3)).unwrap();
    let mut bytes = Vec::new();
    group.save(&mut bytes);
    let before = group.hash();
    let mut record = Vec::new();
    for k in 0..60 {
        if k == 10 {
            spawn(&mut group, 25);
        }
        group.step(DT, &Inline).unwrap();
        record.push(group.bodies().model.to_vec());
    }
    for target in [&mut group.clone(), &mut group_of(1, 30)] {
        target.load(&bytes).unwrap();
        assert_eq!(target.hash(), before);
        for (k, poses) in record.iter().enumerate() {
            if k == 10 {
                assert_eq!(spawn(target, 25), Id { index: 3, generation: 1 });
            }
            target.step(DT, &Inline).unwrap();
            assert!(target.bodies().model == poses);
        }
    }
    assert_ne!(group.hash(), before);
}

#[test]
fn what_is_only_written_besides_changes_neither_hash_nor_snapshot() {
    let more = CharactersConfig { local_transforms: true, instances: true, ..config() };
    let mut plain = group_of(20, 20);
    let mut other = PolicyCharacters::with_capacity(&tables(), 20, more).unwrap();
    (0..20).for_each(|i| _ = spawn(&mut other, i));
    step(&mut plain, 30);
    step(&mut other, 30);
    assert_eq!(plain.hash(), other.hash());
    let mut bytes = Vec::new();
    other.save(&mut bytes);
    plain.load(&bytes).unwrap();
    let mut third = PolicyCharacters::with_capacity(&tables(), 20, CharactersConfig { seed: 7, ..config() }).unwrap();
    assert!(matches!(third.load(&bytes), Err(Error::Snapshot { .. })));
}

#[test]
fn damaged_and_foreign_snapshots_are_refused_and_change_nothing() {
    let mut group = group_of(3, 4);
    step(&mut group, 10);
    let mut bytes = Vec::new();
    group.save(&mut bytes);
    let hash = group.hash();
    for at in 0..bytes.len() {
        let mut other = bytes.clone();
        other[at] ^= 1 << (at % 8);
        assert!(group.load(&other).is_err(), "byte {at}");
    }
    for len in (0..bytes.len()).step_by(37) {
        assert!(group.load(&bytes[..len]).is_err(), "{len} bytes");
    }
    assert!(group.load(&[&bytes[..], &[0]].concat()).is_err());
    assert_eq!(group.hash(), hash);
    let (mut scheduled, mut kept) = (group.clone(), Vec::new());
    let (block, _, lane) = scheduled.characters.lane_mut(1);
    block.segment[lane] = SCHEDULED;
    scheduled.save(&mut kept);
    let e = group.load(&kept).unwrap_err().to_string();
    assert!(e.contains("character 1 plays what the bundle does not have"), "{e}");
    assert!(group_of(3, 5).load(&bytes).is_err(), "another capacity");
    let seed = CharactersConfig { seed: 2, ..config() };
    let mut other = PolicyCharacters::with_capacity(&tables(), 4, seed).unwrap();
    assert!(other.load(&bytes).is_err(), "another config");
}

#[test]
fn another_bundle_is_taken_over_without_a_jump() {
    let mut group = group_of(12, 16);
    step(&mut group, 33);
    let before: Vec<_> = group.ids().iter().map(|&id| seen(&group, id)).collect();
    let adopted = group.adopt(&tables()).unwrap();
    assert_eq!(adopted.num_characters, 12);
    assert!(adopted.farthest_m > 0.0 && adopted.farthest_m < 1.0, "{adopted:?}");
    group.step(1e-4, &Inline).unwrap();
    for (&id, (root, model)) in group.ids().iter().zip(&before) {
        let (new_root, new_model) = seen(&group, id);
        assert!((new_root.x - root.x).hypot(new_root.z - root.z) < 1e-2, "{root:?} {new_root:?}");
        for (a, b) in model.iter().zip(&new_model) {
            assert!(a.translation().distance(b.translation()) < 0.03, "{}", a.translation().distance(b.translation()));
        }
    }
    step(&mut group, 50);
    assert_eq!(group.order_of(Id::first(2)).unwrap().target(), target(2));
}

/// Layers of a character, of all kinds in turn.
fn layered(i: usize) -> BodyLayers {
    let arm = |number| crate::body::ArmLayer::from_number(number % 7, target(i) + Vec3::Y);
    let arms = [arm(i), arm(i / 7)];
    let layers = BodyLayers { arms, lean: [0.1 * (i % 3) as f32, 0.0], ..BodyLayers::NONE };
    if i.is_multiple_of(4) { layers.with_clip(60..110, !0, true) } else { layers }
}

#[test]
fn layers_and_events_are_the_same_on_threads_and_after_a_snapshot() {
    let n = 300;
    let (mut whole, mut split) = (group_of(n, n), group_of(n, n));
    for group in [&mut whole, &mut split] {
        (0..n).for_each(|i| group.set_layers(Id::first(i), layered(i)).unwrap());
    }
    step(&mut whole, 30);
    (0..30).for_each(|_| split.step(DT, &TwoThreads).unwrap());
    assert_eq!(whole.hash(), split.hash());
    let mut kept = Vec::new();
    whole.save(&mut kept);
    let mut other = group_of(3, n);
    other.load(&kept).unwrap();
    for k in 0..60 {
        if k == 20 {
            for group in [&mut whole, &mut split, &mut other] {
                (0..n).for_each(|i| group.set_layers(Id::first(i), layered(i + k)).unwrap());
            }
        }
        step(&mut whole, 1);
        step(&mut other, 1);
        split.step(DT, &TwoThreads).unwrap();
        assert!(whole.events() == split.events() && whole.events() == other.events(), "step {k}");
        assert!(
            whole.bodies().model == split.bodies().model && whole.bodies().model == other.bodies().model,
            "step {k}"
        );
    }
    assert_eq!(whole.hash(), other.hash());
    let refused = |layers: BodyLayers| whole.order_of(Id::first(0)).unwrap().with_layers(layers);
    for bad in [
        BodyLayers { lean: [f32::NAN, 0.0], ..BodyLayers::NONE },
        BodyLayers::NONE.with_clip(0..1, !0, false),
        BodyLayers::NONE.with_clip(100..121, !0, false),
        BodyLayers { arms: [Some(crate::body::ArmLayer::Point(Vec3::INFINITY)), None], ..BodyLayers::NONE },
    ] {
        assert!(other.order(Id::first(0), refused(bad)).is_err(), "{bad:?}");
    }
}

/// Layers fade in, show, and are gone without a trace.
#[test]
fn who_has_had_layers_moves_as_who_has_had_none() {
    let (mut group, mut plain) = (group_of(20, 20), group_of(20, 20));
    (0..20).for_each(|i| group.set_layers(Id::first(i), layered(i)).unwrap());
    step(&mut group, 60);
    step(&mut plain, 60);
    let moved = (0..20).filter(|&i| seen(&group, Id::first(i)).1 != seen(&plain, Id::first(i)).1).count();
    assert!(moved >= 18, "{moved} show their layers");
    // Orders of motion leave them.
    let own = group.order_of(Id::first(1)).unwrap().layers();
    for order in [PolicyOrder::STOP, PolicyOrder::turn_to(1.0), PolicyOrder::towards(0, target(1))] {
        let mut other = group.clone();
        other.order_motion(Id::first(1), order).unwrap();
        assert_eq!(other.order_of(Id::first(1)).unwrap(), &order.with_layers(own));
    }
    (0..20).for_each(|i| group.set_layers(Id::first(i), BodyLayers::NONE).unwrap());
    step(&mut group, 100);
    step(&mut plain, 100);
    assert_eq!(group.hash(), plain.hash());
}

/// Characters of motion that is calm or sad.
fn moody_group(config: CharactersConfig) -> (PolicyCharacters, Vec<Id>) {
    let mut group = PolicyCharacters::with_capacity(&tables(), 4, config).unwrap();
    group.motion_set.manners = Manners::made_up(&group.motion_set.graph).into();
    let enter = |i: u32| {
        group.spawn(Spawn { root: Planar::new(20.0 * i as f32, 0.0, 0.0), state: Some(i), floor_m: 0.0 }).unwrap()
    };
    let ids = (0..4).map(enter).collect();
    (group, ids)
}

#[test]
fn a_manner_that_is_ordered_is_entered_and_kept_until_another_one_is() {
    let avoids = CharactersConfig { avoid: Some(crate::characters::AvoidConfig::default()), ..config() };
    for config in [config(), avoids] {
        let (mut group, ids) = moody_group(config);
        let are_all = |group: &PolicyCharacters, name| ids.iter().all(|id| group.manner(*id).unwrap() == name);
        step(&mut group, 30);
        assert!(!are_all(&group, "calm") && !are_all(&group, "sad"), "each goes on as it began");
        for (k, name) in ["sad", "calm", "sad"].into_iter().enumerate() {
            let orders = [PolicyOrder::towards(0, target(k)), PolicyOrder::IDLE];
            for (id, order) in ids.iter().zip(orders.into_iter().cycle()) {
                group.order(*id, order.in_manner(name)).unwrap();
            }
            let begun = (0..80).position(|_| {
                step(&mut group, 1);
                are_all(&group, name)
            });
            assert!(begun.is_some(), "within 2 s: {:?}", ids.iter().map(|id| group.manner(*id)).collect::<Vec<_>>());
            // Orders that name no manner leave it.
            for step_number in 0..400 {
                if step_number % 50 == 0 {
                    for (i, id) in ids.iter().enumerate() {
                        let to = 3.0 * target(step_number / 50 % 4) + 20.0 * i as f32 * Vec3::X;
                        group.order(*id, PolicyOrder::towards(0, to)).unwrap();
                    }
                }
                step(&mut group, 1);
                assert!(are_all(&group, name));
            }
        }
        let e = group.set_manner(ids[0], "merry").unwrap_err().to_string();
        assert!(["merry", "calm", "sad"].iter().all(|name| e.contains(name)), "{e}");
        group.set_manner(ids[0], "calm").unwrap();
        let mut kept = Vec::new();
        group.save(&mut kept);
        step(&mut group, 60);
        assert_eq!(group.manner(ids[0]).unwrap(), "calm");
        let after = seen(&group, ids[0]);
        group.load(&kept).unwrap();
        step(&mut group, 60);
        assert_eq!(seen(&group, ids[0]).0, after.0);
    }
}

#[test]
fn who_has_not_begun_stands_in_its_manner_from_the_start() {
    let (mut group, ids) = moody_group(config());
    let roots = group.bodies().roots.to_vec();
    ids.iter().for_each(|id| group.set_manner(*id, "sad").unwrap());
    assert!(ids.iter().all(|id| group.manner(*id).unwrap() == "sad"));
    assert_eq!(ids.iter().map(|id| group.characters.root(group.row(*id).unwrap())).collect::<Vec<_>>(), roots);
    group.step(0.0, &Inline).unwrap();
    assert_eq!(group.bodies().roots, roots);
}

/// Characters that walk calmly, and can stand in sad motion only.
fn calm_walkers(config: CharactersConfig) -> (PolicyCharacters, Vec<Id>) {
    let (mut group, ids) = moody_group(config);
    let stop = |(segment, kind)| StopRecord { segment, kind, frames: 60, radius: 0.3, pose_radius: 0.3 };
    group.motion_set.stops.stops =
        [(3, WALK_ON), (2, WALK_ON), (3, SLOW_DOWN), (2, SLOW_DOWN)].map(stop).to_vec().into();
    for (i, id) in ids.iter().enumerate() {
        let order = PolicyOrder::towards(0, Vec3::new(20.0 * i as f32, 0.0, 90.0));
        group.order(*id, order.in_manner("calm")).unwrap();
    }
    step(&mut group, 240);
    assert!(ids.iter().all(|id| group.manner(*id).unwrap() == "calm"));
    (group, ids)
}

#[test]
fn who_is_ordered_to_stand_stands_in_whatever_manner_that_takes() {
    let avoids = CharactersConfig { avoid: Some(crate::characters::AvoidConfig::default()), ..config() };
    for config in [config(), avoids] {
        for order in [PolicyOrder::STOP, PolicyOrder::turn_to(0.0)] {
            let (mut group, ids) = calm_walkers(config);
            ids.iter().for_each(|id| group.order(*id, order).unwrap());
            step(&mut group, 200);
            let stood = group.bodies().roots.to_vec();
            step(&mut group, 120);
            assert_eq!(group.bodies().roots, stood, "they stand");
            // A manner in which nobody stands moves nobody who does.
            ids.iter().for_each(|id| group.set_manner(*id, "sad").unwrap());
            step(&mut group, 60);
            ids.iter().for_each(|id| group.set_manner(*id, "calm").unwrap());
            step(&mut group, 240);
            assert_eq!(group.bodies().roots, stood, "they stand on");
        }
    }
}

#[test]
fn the_last_order_of_a_step_is_the_one_that_is_obeyed() {
    let (mut once, ids) = calm_walkers(config());
    let (mut often, mut kept) = (once.clone(), Vec::new());
    ids.iter().for_each(|id| once.order(*id, PolicyOrder::STOP).unwrap());
    for step_number in 0..200 {
        for (i, id) in ids.iter().enumerate() {
            // Two orders of one step, between which a snapshot is taken at times.
            often.order(*id, PolicyOrder::towards(0, Vec3::new(20.0 * i as f32, 0.0, -90.0))).unwrap();
            if step_number % 20 == 3 {
                kept.clear();
                often.save(&mut kept);
                often.load(&kept).unwrap();
            }
            often.order(*id, PolicyOrder::STOP).unwrap();
        }
        step(&mut once, 1);
        step(&mut often, 1);
        assert_eq!(once.bodies().roots, often.bodies().roots, "step {step_number}");
    }
}

#[test]
fn names_that_are_no_manner_and_eyes_that_are_nowhere_are_refused() {
    let (mut group, ids) = moody_group(config());
    for name in ["", "sad\0", "sad\0calm"] {
        let e = group.set_manner(ids[0], name).unwrap_err().to_string();
        assert!(e.contains("calm") && e.contains("sad"), "{name:?}: {e}");
    }
    for eye in [Vec2::NAN, Vec2::new(0.0, f32::NAN), Vec2::new(f32::NAN, 1.0)] {
        let e = group.set_detail(Some(Detail { eye, full_m: 20.0, posed_m: 60.0 })).unwrap_err().to_string();
        assert!(e.contains("eye"), "{e}");
    }
}
