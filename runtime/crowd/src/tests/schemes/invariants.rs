//! Invariants at every event.

use super::*;
use crate::events::occupancy::events::{CONTACT, REST};
use crate::safety::bound::Bound;

fn registration_holds<V: Space>() {
    let mut crowd = Engine::new(meeting::<V>(Scheme::Registration, 4)).unwrap();
    let mut near = 0;
    at_every_event(&mut crowd, 6.0, |crowd| {
        let bounds: Vec<_> = crowd.ids().map(|id| (id, Bound::from(&crowd.cells.plan(id.index)))).collect();
        let half = V::from_coordinates([crowd.cells.side; 3]);
        for (n, (id, bound)) in bounds.iter().enumerate() {
            let at = crowd.cells.coordinates(bound.position);
            assert_eq!(crowd.states[id.index()].cell, crowd.cells.number(at), "registered where its centre was");
            let (x, radius) = bound.disc_at(crowd.now);
            let room = (x - crowd.cells.centre(at) + half).min(crowd.cells.centre(at) + half - x).coordinates();
            let least = room.iter().take(V::DIMENSIONS).fold(f32::INFINITY, |a, &b| a.min(b));
            assert!(least >= radius - 1e-3, "bound of {id:?} is {} m out of its region", radius - least);
            for (other, b) in &bounds[..n] {
                let (y, s) = b.disc_at(crowd.now);
                let far = crowd.cells.coordinates(b.position);
                let is_near = (0..3).all(|i| (at[i] - far[i]).abs() <= 1);
                let touches = (x - y).length() < radius + s - 1e-3;
                near += usize::from(is_near && (x - y).length() < radius + s + 0.1);
                assert!(is_near || !touches, "bounds of {id:?} and {other:?} touch from cells that are apart");
            }
        }
        no_overlap(crowd, 0.0);
    });
    assert!(near > 100 && crowd.counts.colliding > 100, "the test sees bounds that touch");
}

#[test]
fn bounds_of_discs_stay_in_their_regions() {
    registration_holds::<Vec2>();
}

#[test]
fn bounds_of_balls_stay_in_their_regions() {
    registration_holds::<Vec3>();
}

/// Lists hold exactly the agents whose bounds reach into a cell.
pub(super) fn lists_are_exact<V: Space>(crowd: &Engine<V>) {
    let (o, side) = (occupancy(crowd), crowd.cells.side);
    for id in crowd.ids() {
        let (x, radius) = crowd.bound(id, crowd.now).unwrap();
        let occupant = &o.occupants[id.index()];
        for axis in 0..V::DIMENSIONS {
            let (x, low, high) = (x.coordinates()[axis], occupant.low[axis], occupant.high[axis]);
            let (from, to) = (low as f32 * side, (high + 1) as f32 * side);
            assert!(high - low <= 1 && 2.0 * radius <= side, "{radius} m wide in {low}..={high}");
            assert!(x - radius >= from - 1e-4 && x + radius <= to + 1e-4, "{id:?} is out of its cells");
            let reaches = x - radius <= (low + 1) as f32 * side + 1e-4 && x + radius >= high as f32 * side - 1e-4;
            assert!(reaches, "{id:?} is listed where it is not: {x} +- {radius} in {low}..={high} of {side} m");
        }
        let mut found = 0;
        for z in occupant.low[2]..=occupant.high[2] {
            for y in occupant.low[1]..=occupant.high[1] {
                for x in occupant.low[0]..=occupant.high[0] {
                    o.each(&crowd.cells, [x, y, z], [x, y, z], |m| found += usize::from(m == id.index));
                }
            }
        }
        let want: i32 = (0..3).map(|i| occupant.high[i] - occupant.low[i] + 1).product();
        assert_eq!(found, want as usize, "once in each of its cells");
    }
}

/// Agents whose bounds have touched for longer than the smallest interval were asked for another plan, or are in
/// contact.
fn nobody_is_unseen<V: Space>(crowd: &Engine<V>) -> usize {
    let (o, now) = (occupancy(crowd), crowd.now);
    let ids: Vec<Id> = crowd.ids().collect();
    let mut touching = 0;
    for (n, &a) in ids.iter().enumerate() {
        let (x, r) = crowd.bound(a, now).unwrap();
        for &b in &ids[..n] {
            let (y, s) = crowd.bound(b, now).unwrap();
            if (x - y).length() > r + s - 1e-3 || o.contacts.are_together(a.index, b.index) {
                continue;
            }
            touching += 1;
            let asked = o.occupants[a.index()].asked.max(o.occupants[b.index()].asked);
            assert!(
                now - asked <= f64::from(crowd.scenery.interval) + 1e-6,
                "{a:?} and {b:?} unseen for {}",
                now - asked
            );
        }
    }
    touching
}

/// Contacts are those of agents that touch and do not move relative to each other.
pub(super) fn contacts_are_true<V: Space>(crowd: &Engine<V>) -> usize {
    let o = occupancy(crowd);
    let mut num_contacts = 0;
    for a in crowd.ids() {
        for b in o.contacts.contacts_of(a.index) {
            let (p, q) = (crowd.cells.plan(a.index), crowd.cells.plan(b));
            let ((x, v), (y, w)) = (p.motion_at(crowd.now), q.motion_at(crowd.now));
            let gap = (x - y).length() - p.radius - q.radius;
            assert!(gap <= CONTACT + 0.01 && (v - w).length() <= 2.0 * REST, "{gap} m, {} m/s", (v - w).length());
            num_contacts += 1;
        }
    }
    num_contacts
}

fn occupancy_holds<V: Space>() {
    let mut crowd = Engine::new(meeting::<V>(Scheme::Occupancy, 10)).unwrap();
    let mut touching = 0;
    at_every_event(&mut crowd, 9.0, |crowd| {
        lists_are_exact(crowd);
        contacts_are_true(crowd);
        touching += nobody_is_unseen(crowd);
        no_overlap(crowd, 0.0);
    });
    let counts = crowd.counts;
    assert!(touching > 0 && counts.entering > 0 && counts.leaving > 0 && counts.colliding > 0, "{counts:?}");
}

#[test]
fn discs_are_listed_and_contacts_found() {
    occupancy_holds::<Vec2>();
}

#[test]
fn balls_are_listed_and_contacts_found() {
    occupancy_holds::<Vec3>();
}

#[test]
fn contacts_are_found_between_events_too() {
    let mut crowd = Engine::new(meeting::<Vec2>(Scheme::Occupancy, 6)).unwrap();
    let touching: usize = (1..1200)
        .map(|i| {
            crowd.advance(f64::from(i) * 0.005, &mut |_| ()).unwrap();
            lists_are_exact(&crowd);
            nobody_is_unseen(&crowd)
        })
        .sum();
    assert!(touching > 0);
}
