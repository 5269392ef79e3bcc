//! Nothing allocates while time passes, nor what answers a signal.
#![allow(unsafe_code, reason = "an allocator that counts is an unsafe trait")]

#[path = "../../../tests/common/counting.rs"]
mod counting;

use counting::allocations;
use glam::Vec3;
use throng_crowd::{
    Agent, AgentOrder, Crowd, CrowdEventKind, CrowdSetup, Id, Obstacle, Route, Sense, Senses, Streets, Zone,
};

const NUM: usize = 60;

/// Places apart from each other and from the blocks.
fn place(i: usize) -> Vec3 {
    Vec3::new((i % 10) as f32 * 2.0, 0.0, (i / 10) as f32 * 2.0)
}

fn crowd() -> (Crowd, Vec<Id>) {
    let block = |x: f32, z: f32| Obstacle::Ball { centre: Vec3::new(x, 0.0, z), radius: 0.3 };
    let blocks: Vec<Obstacle> = (0..6).map(|i| block(1.0 + 4.0 * (i % 3) as f32, 1.0 + 4.0 * (i / 3) as f32)).collect();
    let streets = Streets::new(&blocks, 0.4).unwrap();
    let mut setup = CrowdSetup::in_streets(&streets, NUM);
    setup.senses = Senses {
        meet_m: 1.2,
        zones: (0..20).map(|i| Zone { centre: place(3 * i), radius: 0.8 }).collect(),
        cell_m: 1.0,
    };
    setup.routes.push(Route { subgoals: vec![place(0), place(59)], arrival_radius: 0.5, at_end: Default::default() });
    let mut crowd = Crowd::on_ground(setup).unwrap();
    let ids: Vec<Id> = (0..NUM).map(|i| crowd.spawn(Agent::standing_at(place(i))).unwrap()).collect();
    let sense = Sense { sends: 1, receives: 1, once: 1, zones: true, cells: true, arrivals: true };
    ids.iter().for_each(|&id| crowd.set_senses(id, sense).unwrap());
    (crowd, ids)
}

#[test]
fn answers_to_signals_allocate_nothing() {
    let (mut crowd, ids) = crowd();
    // The first order of each; all to one place.
    ids.iter().for_each(|&id| crowd.order(id, AgentOrder::to_goal(place(34))).unwrap());
    let mut num = [0; 4];
    let n = allocations(|| {
        ids.iter().for_each(|&id| crowd.set_timer(id, Some(0.1 + 0.05 * f64::from(id.index))).unwrap());
        while let Some(signal) = crowd.advance_to_signal(40.0, &mut |_| {}).unwrap() {
            let id = signal.agent;
            match signal.kind {
                CrowdEventKind::Timer => {
                    num[0] += 1;
                    let turn = (signal.time * 10.0) as usize + 7 * id.index();
                    let go = if turn.is_multiple_of(5) {
                        AgentOrder::on_route(0)
                    } else {
                        AgentOrder::to_goal(place(turn % NUM))
                    };
                    crowd.order(id, go.at_speed(0.8 + 0.1 * (turn % 9) as f32)).unwrap();
                    crowd.wake(id).unwrap();
                    crowd.set_timer(id, Some(signal.time + 1.3)).unwrap();
                }
                CrowdEventKind::Met { other } => {
                    num[1] += 1;
                    crowd.set_speed(other, 1.1).unwrap();
                }
                CrowdEventKind::CameTo { .. } => num[2] += 1,
                _ => num[3] += 1,
            }
        }
    });
    assert!(num.iter().all(|&n| n > 100), "{num:?} are too few to prove anything");
    assert_eq!(n, 0);
}
