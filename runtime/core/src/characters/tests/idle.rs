//! People who have arrived or are ordered to stand.

use super::*;
use crate::character_group::{CharacterGroup, OrderStatus};
use throng_base::Inline;

const DT: f32 = 1.0 / 60.0;

/// People of a bundle, apart from each other, each with an order.
fn people(
    bundle: &Bundle,
    n: usize,
    config: CharactersConfig,
    order: impl Fn(Planar) -> PolicyOrder,
) -> (PolicyCharacters, Vec<Id>) {
    let mut group = PolicyCharacters::with_capacity(bundle, n, config).unwrap();
    let enter = |i: usize| {
        let root = Planar::new(2.0 * i as f32, 0.0, 0.0);
        let id = group.spawn(Spawn { root, state: Some(0), floor_m: 0.0 }).unwrap();
        group.order(id, order(root)).unwrap();
        id
    };
    let ids = (0..n).map(enter).collect();
    (group, ids)
}

fn here(root: Planar) -> PolicyOrder {
    PolicyOrder::towards(0, root.translation())
}

fn with_avoidance() -> CharactersConfig {
    CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() }
}

#[test]
fn who_has_arrived_idles_out_of_step_with_others_and_its_feet_stay() {
    for config in [CharactersConfig::default(), with_avoidance()] {
        let (mut group, ids) = people(&standing_tables(), 12, config, here);
        (0..60).for_each(|_| group.step(DT, &Inline).unwrap());
        let feet = |group: &PolicyCharacters, id: Id| {
            let bodies = group.bodies();
            let body = bodies.get(id).unwrap();
            [Joint::LeftToe, Joint::RightToe]
                .map(|j| body.root.translation() + body.root.rotation() * body.model[j.index()].translation())
        };
        let at_first: Vec<_> = ids.iter().map(|&id| feet(&group, id)).collect();
        let mut in_step = 0;
        for _ in 0..40 {
            (0..30).for_each(|_| group.step(DT, &Inline).unwrap());
            let played = |c: usize| group.characters.segment(c);
            for a in 0..12 {
                let alike = |b: usize| played(a).0 == played(b).0 && (played(a).1 - played(b).1).abs() < 0.1;
                in_step += usize::from((0..12).any(|b| b != a && alike(b)));
            }
        }
        for (&id, before) in ids.iter().zip(&at_first) {
            for (now, before) in feet(&group, id).iter().zip(before) {
                assert!(now.distance(*before) < 1e-3, "a foot has moved from {before} to {now}");
            }
            assert_eq!(group.status(id).unwrap(), OrderStatus::Arrived);
        }
        // Four segments of 20 frames for 12 people.
        assert!(in_step < 12 * 40 / 10, "{in_step} of 480 times somebody was in step with somebody else");
    }
}

#[test]
fn who_is_told_to_stop_slows_down_and_stands_until_told_to_go() {
    for config in [CharactersConfig::default(), with_avoidance()] {
        let far = |root: Planar| PolicyOrder::towards(0, root.translation() + Vec3::Z * 9.0);
        let (mut group, ids) = people(&tables(), 5, config, far);
        (0..90).for_each(|_| group.step(DT, &Inline).unwrap());
        for &id in &ids {
            group.order(id, PolicyOrder::STOP).unwrap();
            assert!(matches!(group.status(id).unwrap(), OrderStatus::Going { .. }));
        }
        // A segment of 2/3 s goes on to its end, and another is played in twice its time.
        (0..130).for_each(|_| group.step(DT, &Inline).unwrap());
        let stands = group.bodies().roots.to_vec();
        (0..60).for_each(|_| group.step(DT, &Inline).unwrap());
        assert_eq!(stands, group.bodies().roots, "nobody moves");
        let mut kept = Vec::new();
        group.save(&mut kept);
        group.load(&kept).unwrap();
        for (&id, &root) in ids.iter().zip(&stands) {
            assert_eq!(group.status(id).unwrap(), OrderStatus::Arrived);
            group.order(id, far(root)).unwrap();
        }
        // They start in twice the time of a segment.
        (0..120).for_each(|_| group.step(DT, &Inline).unwrap());
        let goes = |(a, b): (&Planar, &Planar)| (a.x - b.x).hypot(a.z - b.z) > 0.3;
        assert!(stands.iter().zip(group.bodies().roots).all(goes), "all go on");
    }
}

#[test]
fn a_heading_that_is_none_is_refused() {
    let (mut group, ids) = people(&tables(), 1, CharactersConfig::default(), here);
    let e = group.order(ids[0], PolicyOrder::turn_to(f32::NAN)).unwrap_err().to_string();
    assert!(e.contains("heading"), "{e}");
    group.order(ids[0], PolicyOrder::turn_to(2.0)).unwrap();
}

#[test]
fn who_nearly_faces_where_it_is_to_has_arrived() {
    let (mut group, ids) = people(&standing_tables(), 2, CharactersConfig::default(), here);
    (0..30).for_each(|_| group.step(DT, &Inline).unwrap());
    for (&id, degrees) in ids.iter().zip([12f32, 20.0]) {
        group.order(id, PolicyOrder::turn_to(degrees.to_radians())).unwrap();
    }
    (0..60).for_each(|_| group.step(DT, &Inline).unwrap());
    // No motion of this bundle turns.
    assert_eq!(group.status(ids[0]).unwrap(), OrderStatus::Arrived);
    assert!(matches!(group.status(ids[1]).unwrap(), OrderStatus::Going { .. }));
}
