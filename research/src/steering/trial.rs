//! Runs a crowd and measures how it gets on: speed over time, who stands, what it costs, who overlaps whom.

use glam::{Vec2, Vec3, Vec3Swizzles};
use serde::Serialize;
use std::time::Instant;
use throng_crowd::{AtEnd, Crowd, CrowdError, CrowdSetup, Id, Obstacle, Streets};

/// Who stays within this distance ... (m)
const STANDS_M: f32 = 0.5;
/// ... for this time stands (s).
const STANDS_S: f64 = 10.0;
/// Between two looks (s).
const LOOK_S: f64 = 0.1;
/// Time over which a speed is told (s).
const WINDOW_S: f64 = 10.0;

/// What was measured of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SteeringFigures {
    /// Number of agents.
    pub agents: usize,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Mean speed along the shortest way of agents on their way, over all of the time (m/s).
    pub speed_mps: f64,
    /// The same in each ten seconds, while there are agents (m/s).
    pub speed_by_10s_mps: Vec<f64>,
    /// Agents that ever stayed within half a metre for 10 s on their way.
    pub stuck: usize,
    /// Those of them that do so at the end.
    pub stuck_at_end: usize,
    /// Agents that are not at their goal at the end.
    pub not_there: usize,
    /// Time of the engine for an agent on its way and a simulated second (us).
    pub us_per_agent_second: f64,
    /// Time to make the crowd: its ways, and its memory (s).
    pub setup_s: f64,
    /// Deepest overlap of two agents, or of an agent and what stands, at any look; below zero where none touched (m).
    pub max_overlap_m: f64,
    /// Hash of the state at the end, and of all events before, those of agents that left included.
    pub state_hash: String,
}

/// An agent under observation.
struct Seen {
    id: Id,
    goal: Vec3,
    radius: f32,
    /// It goes round and round, about the origin.
    is_round: bool,
    at: Vec2,
    left: f32,
    since: f64,
    /// Where and since when it has been about there.
    stays: (Vec2, f64),
    is_there: bool,
    was_stuck: bool,
}

impl Seen {
    fn stands(&self, now: f64) -> bool {
        !self.is_there && now - self.stays.1 >= STANDS_S
    }
}

/// Runs a crowd, and tells where everybody is at every look: number, place, velocity (m, m/s).
///
/// # Errors
/// As [`Crowd::on_ground`] and [`Crowd::advance`].
pub fn run(
    setup: CrowdSetup,
    seconds: f64,
    look: &mut impl FnMut(f64, usize, Vec2, Vec2),
) -> Result<SteeringFigures, CrowdError> {
    let (routes, streets, obstacles) = (setup.routes.clone(), setup.streets.clone(), setup.obstacles.clone());
    let agents = setup.agents.clone();
    let begin = Instant::now();
    let mut crowd = Crowd::on_ground(setup)?;
    let setup_s = begin.elapsed().as_secs_f64();
    let mut hash = 0u64;
    let mut seen: Vec<Seen> = crowd
        .ids()
        .zip(&agents)
        .filter_map(|(id, agent)| {
            let route = routes.get(agent.route?)?;
            let (goal, is_round) = (*route.subgoals.last()?, route.at_end == AtEnd::Again);
            let at = agent.position.xz();
            let left = way(streets.as_ref(), at, goal);
            let one = Seen {
                id,
                goal,
                radius: agent.radius,
                is_round,
                at,
                left,
                since: 0.0,
                stays: (at, 0.0),
                is_there: false,
                was_stuck: false,
            };
            Some(one)
        })
        .collect();
    let (mut busy_s, mut deepest) = (0.0, f64::NEG_INFINITY);
    let (mut gained, mut spent) = (vec![0.0f64], vec![0.0f64]);
    let steps = (seconds / LOOK_S).round() as usize;
    for step in 1..=steps {
        let now = step as f64 * LOOK_S;
        let begin = Instant::now();
        crowd.advance(now, &mut |e| {
            hash =
                (hash ^ e.time.to_bits() ^ e.agent.index() as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29);
        })?;
        busy_s += begin.elapsed().as_secs_f64();
        let is_window = step % (WINDOW_S / LOOK_S) as usize == 0 || step == steps;
        let mut here = Vec::new();
        for (number, one) in seen.iter_mut().enumerate().filter(|(_, s)| !s.is_there) {
            let window = gained.len() - 1;
            let Some(at) = crowd.position(one.id, now).map(|p| p.xz()) else {
                one.is_there = true;
                gained[window] += f64::from(one.left);
                spent[window] += now - one.since;
                continue;
            };
            look(now, number, at, crowd.velocity(one.id, now).unwrap_or_default().xz());
            here.push((at, one.radius));
            if at.distance(one.stays.0) > STANDS_M {
                one.stays = (at, now);
            }
            one.was_stuck |= one.stands(now);
            if one.is_round {
                let along = one.at.perp().dot(at - one.at) / one.at.length();
                gained[window] += f64::from(along.abs());
                spent[window] += now - one.since;
                (one.at, one.since) = (at, now);
            } else if is_window {
                let left = way(streets.as_ref(), at, one.goal);
                gained[window] += f64::from(one.left - left);
                spent[window] += now - one.since;
                (one.left, one.since) = (left, now);
            }
        }
        deepest = deepest.max(overlap(&here, &obstacles));
        if is_window && step < steps {
            gained.push(0.0);
            spent.push(0.0);
        }
    }
    let all: f64 = spent.iter().sum();
    let by_10s = gained.iter().zip(&spent).filter(|(_, s)| **s > 0.0).map(|(g, s)| g / s);
    Ok(SteeringFigures {
        agents: agents.len(),
        simulated_s: seconds,
        speed_mps: gained.iter().sum::<f64>() / all.max(1e-9),
        speed_by_10s_mps: by_10s.collect(),
        stuck: seen.iter().filter(|s| s.was_stuck).count(),
        stuck_at_end: seen.iter().filter(|s| s.stands(seconds)).count(),
        not_there: seen.iter().filter(|s| !s.is_there).count(),
        us_per_agent_second: 1e6 * busy_s / all.max(1e-9),
        setup_s,
        max_overlap_m: deepest,
        state_hash: format!("{:016x}", hash ^ crowd.hash()),
    })
}

/// Length of the shortest way to a goal (m).
fn way(streets: Option<&Streets>, at: Vec2, goal: Vec3) -> f32 {
    let from = Vec3::new(at.x, 0.0, at.y);
    let corners = streets.and_then(|s| s.corners(from, goal).ok()).unwrap_or(vec![from, goal]);
    corners.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// Deepest overlap of two discs, or of a disc and what stands (m).
fn overlap(here: &[(Vec2, f32)], obstacles: &[Obstacle]) -> f64 {
    let mut order: Vec<usize> = (0..here.len()).collect();
    order.sort_unstable_by(|&a, &b| here[a].0.x.total_cmp(&here[b].0.x));
    let mut deepest = f32::NEG_INFINITY;
    for (k, &i) in order.iter().enumerate() {
        let (p, r) = here[i];
        for &j in &order[k + 1..] {
            let (q, s) = here[j];
            if q.x - p.x > 1.0 {
                break;
            }
            deepest = deepest.max(r + s - p.distance(q));
        }
        for obstacle in obstacles {
            let (from, to, radius) = match obstacle {
                Obstacle::Wall { from, to, radius } => (from.xz(), to.xz(), *radius),
                Obstacle::Ball { centre, radius } => (centre.xz(), centre.xz(), *radius),
                _ => continue,
            };
            let along = to - from;
            let share = ((p - from).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
            deepest = deepest.max(r + radius - p.distance(from + along * share));
        }
    }
    f64::from(deepest)
}
