//! Sensed events of agents, against dense samples and by hand.

use super::drive::crossing;
use crate::*;
use glam::{Vec2, Vec3};
use proptest::prelude::*;

const MEET_M: f32 = 1.5;
const CELL_M: f32 = 2.0;

fn zones() -> Vec<Zone> {
    [(0.0, 0.0, 1.0), (3.0, 2.0, 0.6), (-4.0, -1.0, 2.5), (0.5, -6.0, 0.2)]
        .map(|(x, z, radius)| Zone { centre: Vec3::new(x, 0.0, z), radius })
        .to_vec()
}

/// A crowd whose agents sense everything, and only approaches.
fn sensing(num: usize, spacing: f32, scheme: Scheme) -> Crowd {
    let mut setup = crossing::<Vec2>(num, spacing).map(Space::to_world);
    setup.config.scheme = scheme;
    setup.senses = Senses { meet_m: MEET_M, zones: zones(), cell_m: CELL_M };
    let mut crowd = Crowd::on_ground(setup).unwrap();
    let sense = Sense { sends: 1, receives: 1, once: 1, zones: true, cells: true, arrivals: true };
    crowd.ids().collect::<Vec<_>>().into_iter().for_each(|id| crowd.set_senses(id, sense).unwrap());
    crowd
}

/// Sample of all places: pairs that are near, zones and cells.
#[derive(Clone, PartialEq)]
struct Seen {
    near: Vec<(usize, usize)>,
    zones: Vec<(usize, usize)>,
    cells: Vec<[i32; 2]>,
}

fn seen(crowd: &Crowd, time: f64) -> Seen {
    let at: Vec<Vec3> = crowd.ids().map(|id| crowd.position(id, time).unwrap()).collect();
    let pairs = |a: usize| (a + 1..at.len()).map(move |b| (a, b));
    Seen {
        near: (0..at.len()).flat_map(pairs).filter(|&(a, b)| at[a].distance(at[b]) <= MEET_M).collect(),
        zones: (0..at.len())
            .flat_map(|m| zones().into_iter().enumerate().map(move |(z, zone)| (m, z, zone)))
            .filter(|(m, _, zone)| at[*m].distance(zone.centre) <= zone.radius)
            .map(|(m, z, _)| (m, z))
            .collect(),
        cells: at.iter().map(|p| [(p.x / CELL_M).floor() as i32, (p.z / CELL_M).floor() as i32]).collect(),
    }
}

const STEP_S: f64 = 0.001;

/// Every change between two samples is reported between them, and nothing else is except changes that revert within a
/// sample.
fn told_is_true(num: usize, spacing: f32, scheme: Scheme, seconds: f64) {
    let mut crowd = sensing(num, spacing, scheme);
    let mut before = seen(&crowd, 0.0);
    let mut last = 0.0;
    for k in 1..=(seconds / STEP_S) as usize {
        let time = k as f64 * STEP_S;
        let mut now = before.clone();
        while let Some(signal) = crowd.advance_to_signal(time, &mut |_| {}).unwrap() {
            assert!(
                signal.time >= last && signal.time <= time && crowd.time_s() == signal.time,
                "{signal:?} after {last}"
            );
            last = signal.time;
            let m = signal.agent.index();
            match signal.kind {
                CrowdEventKind::Met { other } => {
                    assert!(m < other.index());
                    now.near.retain(|p| *p != (m, other.index()));
                    now.near.push((m, other.index()));
                }
                CrowdEventKind::CameTo { zone } => now.zones.push((m, zone)),
                CrowdEventKind::WentFrom { zone } => {
                    let count = now.zones.len();
                    now.zones.retain(|z| *z != (m, zone));
                    assert_eq!(now.zones.len() + 1, count, "agent {m} was in zone {zone}");
                }
                CrowdEventKind::Crossed { from, to } => {
                    assert_eq!(now.cells[m], from, "agent {m} at {time}");
                    now.cells[m] = to;
                }
                _ => {}
            }
        }
        let sample = seen(&crowd, time);
        now.zones.sort_unstable();
        // Partings are not reported.
        for pair in &sample.near {
            assert!(now.near.contains(pair), "{scheme:?}: {pair:?} met unnoticed before {time}");
        }
        assert!(now.zones == sample.zones, "{scheme:?} zones at {time}: {:?} {:?}", now.zones, sample.zones);
        assert_eq!(now.cells, sample.cells, "{scheme:?} cells at {time}");
        before = sample;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, ..ProptestConfig::default() })]
    #[test]
    fn all_that_happens_is_told_and_nothing_else(num in 2usize..24, spacing in 4.0f32..12.0) {
        told_is_true(num, spacing, Scheme::Registration, 4.0);
        told_is_true(num, spacing, Scheme::Occupancy, 2.0);
        #[cfg(feature = "fixed-steps")]
        told_is_true(num, spacing, Scheme::Fixed, 2.0);
    }
}

/// All signals of a run that stops at given times, with their bits.
fn signals(stops: &[f64], restored: bool) -> Vec<(u64, String)> {
    let mut crowd = sensing(20, 6.0, Scheme::Registration);
    let mut all = Vec::new();
    for &stop in stops {
        while let Some(signal) = crowd.advance_to_signal(stop, &mut |_| {}).unwrap() {
            all.push((signal.time.to_bits(), format!("{:?} {:?}", signal.agent, signal.kind)));
            if restored && all.len() % 5 == 0 {
                let mut bytes = Vec::new();
                crowd.save(&mut bytes);
                let mut other = sensing(20, 6.0, Scheme::Registration);
                other.load(&bytes).unwrap();
                // Signals that were noted but not read yet are no part of a snapshot.
                while let Some(left) = crowd.advance_to_signal(signal.time, &mut |_| {}).unwrap() {
                    all.push((left.time.to_bits(), format!("{:?} {:?}", left.agent, left.kind)));
                }
                while other.advance_to_signal(signal.time, &mut |_| {}).unwrap().is_some() {}
                crowd = other;
            }
        }
    }
    all
}

#[test]
fn signals_do_not_depend_on_stops_nor_on_snapshots() {
    let whole = signals(&[6.0], false);
    assert!(whole.len() > 60, "{}", whole.len());
    let often: Vec<f64> = (1..=60).map(|k| k as f64 * 0.1).collect();
    assert_eq!(whole, signals(&often, false));
    assert_eq!(whole, signals(&[6.0], true));
}

fn standing(places: &[f32]) -> Crowd {
    let agents = places.iter().map(|&x| Agent::standing_at(Vec3::new(x, 0.0, 0.0))).collect();
    let senses = Senses { meet_m: 2.0, ..Senses::default() };
    Crowd::on_ground(CrowdSetup { agents, senses, ..CrowdSetup::default() }).unwrap()
}

#[test]
fn news_go_along_a_row_at_one_instant() {
    let mut crowd = standing(&[0.0, 1.5, 3.0, 4.5, 8.0]);
    let ids: Vec<Id> = crowd.ids().collect();
    let mut knows = [false; 5];
    let sense = |knows: bool| Sense { sends: u32::from(knows), receives: u32::from(!knows), ..Sense::default() };
    for &id in &ids {
        crowd.set_senses(id, sense(false)).unwrap();
    }
    assert_eq!(crowd.advance_to_signal(1.0, &mut |_| {}).unwrap(), None);
    knows[1] = true;
    crowd.set_senses(ids[1], sense(true)).unwrap();
    while let Some(CrowdEvent { time, agent, kind }) = crowd.advance_to_signal(9.0, &mut |_| {}).unwrap() {
        let CrowdEventKind::Met { other } = kind else { panic!("{kind:?}") };
        assert_eq!(time, 1.0, "at once");
        assert_ne!(knows[agent.index()], knows[other.index()]);
        for id in [agent, other] {
            knows[id.index()] = true;
            crowd.set_senses(id, sense(true)).unwrap();
        }
    }
    assert_eq!(knows, [true, true, true, true, false], "3.5 m is too far");
}

#[test]
fn timers_wake_once_and_in_their_order() {
    let mut crowd = standing(&[0.0, 5.0]);
    let ids: Vec<Id> = crowd.ids().collect();
    crowd.set_timer(ids[1], Some(0.75)).unwrap();
    crowd.set_timer(ids[0], Some(0.75)).unwrap();
    assert!(crowd.set_timer(ids[0], Some(-1.0)).is_err() && crowd.set_timer(ids[0], Some(f64::NAN)).is_err());
    let mut woken = Vec::new();
    while let Some(event) = crowd.advance_to_signal(3.0, &mut |_| {}).unwrap() {
        assert_eq!((event.time, event.kind), (0.75, CrowdEventKind::Timer));
        woken.push(event.agent);
    }
    assert_eq!(woken, ids);
    assert_eq!(crowd.counts().timers, 2);
}

#[test]
fn two_who_walk_towards_each_other_meet_when_they_have_to() {
    let mut crowd = standing(&[0.0, 20.0]);
    let ids: Vec<Id> = crowd.ids().collect();
    for (k, &id) in ids.iter().enumerate() {
        crowd.set_senses(id, Sense { sends: 2, receives: 2, once: 2, ..Sense::default() }).unwrap();
        let to = Vec3::new(if k == 0 { 20.0 } else { 0.0 }, 0.0, 0.6 * k as f32 - 0.3);
        crowd.order(id, AgentOrder::to_goal(to)).unwrap();
    }
    let event = crowd.advance_to_signal(30.0, &mut |_| {}).unwrap().unwrap();
    let at = |id| crowd.position(id, event.time).unwrap();
    assert!((at(ids[0]).distance(at(ids[1])) - 2.0).abs() < 1e-4, "{event:?}");
    assert_eq!(event.kind, CrowdEventKind::Met { other: ids[1] });
    assert_eq!(crowd.advance_to_signal(30.0, &mut |_| {}).unwrap(), None, "once");
}

#[test]
fn senses_out_of_range_are_refused() {
    for senses in [
        Senses { meet_m: -1.0, ..Senses::default() },
        Senses { meet_m: f32::NAN, ..Senses::default() },
        Senses { cell_m: 0.01, ..Senses::default() },
        Senses { zones: vec![Zone { centre: Vec3::NAN, radius: 1.0 }], ..Senses::default() },
        Senses { zones: vec![Zone { centre: Vec3::ZERO, radius: 0.0 }], ..Senses::default() },
    ] {
        let e = Crowd::on_ground(CrowdSetup { senses, ..CrowdSetup::default() }).unwrap_err().to_string();
        assert!(e.contains("senses"), "{e}");
    }
}

/// An agent that begins to send is met by all near agents at once, each once, though none answers.
#[test]
fn level_channels_reach_all_who_are_near_though_masks_stay() {
    let mut crowd = standing(&[0.0, 1.5, -1.5, 8.0]);
    let ids: Vec<Id> = crowd.ids().collect();
    let told = |crowd: &mut Crowd, until: f64| {
        let mut all = Vec::new();
        while let Some(CrowdEvent { time, agent, kind }) = crowd.advance_to_signal(until, &mut |_| {}).unwrap() {
            let CrowdEventKind::Met { other } = kind else { panic!("{kind:?}") };
            all.push((time, agent.index(), other.index()));
        }
        all
    };
    let sense = |sends: u32, receives: u32| Sense { sends, receives, ..Sense::default() };
    for &id in &ids[1..] {
        crowd.set_senses(id, sense(0, 1)).unwrap();
    }
    assert!(told(&mut crowd, 1.0).is_empty());
    crowd.set_senses(ids[0], sense(1, 0)).unwrap();
    assert_eq!(told(&mut crowd, 2.0), [(1.0, 0, 1), (1.0, 0, 2)]);
    crowd.set_senses(ids[0], sense(1, 0)).unwrap();
    assert!(told(&mut crowd, 3.0).is_empty(), "nothing has changed");
    // All begin at one time, in any order.
    ids.iter().for_each(|&id| crowd.set_senses(id, sense(0, 0)).unwrap());
    [2, 0, 1].iter().for_each(|&i| crowd.set_senses(ids[i], sense(1, 1)).unwrap());
    let all = told(&mut crowd, 4.0);
    let mut pairs: Vec<_> = all.iter().map(|a| (a.1, a.2)).collect();
    pairs.sort_unstable();
    assert_eq!(pairs, [(0, 1), (0, 2)], "1 and 2 are 3 m apart: {all:?}");
}
