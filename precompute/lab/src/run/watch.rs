//! Measures some groups of a simulation after every step.

mod agents;
mod partners;
mod world;

use super::figures::{BlowFigures, FollowedPathFigures, SceneFigures, TravelFigures};
use super::groups::agents_crowd;
use super::meter::{AgentSample, ProgressMeter};
use super::report::SAMPLE_HZ;
use crate::overlap::{OverlapMeter, PresentCharacter};
use crate::slip::SlipMeter;
use crate::touch::{TouchFigures, TouchMeter};
use glam::{Vec2, Vec3};
use partners::PartnerMeter;
use throng_core::body::HeightField;
use throng_core::skeleton::LEGS;
use throng_core::stops::BODY_RADIUS_M;
use throng_core::{BodyVolume, Joint, NUM_JOINTS, PosedBody, Skeleton};
use throng_motion::error::Result;
use throng_simulation::scene::{AtEndConfig, engine};
use throng_simulation::sparring::BlowTally;
use throng_simulation::{AnyCharacterGroup, GroupMotion, MotionKind, SceneGroup, Simulation};
use world::WorldWatch;

pub(super) use agents::AgentWatch;
pub use agents::{AgentsMeter, AgentsSummary};
pub use partners::PartnerFigures;

/// Time between samples of overlaps and penetrations (s).
pub(super) const SAMPLE_PERIOD_S: f64 = 0.1;
/// Time that characters have to come together before their greatest distance counts (s).
const APPROACH_S: f64 = 5.0;

/// Measurements of some groups.
pub struct SceneWatch {
    /// Numbers of the groups in the simulation.
    groups: Vec<usize>,
    feet: SlipMeter,
    fights: FightMeter,
    touch: TouchMeter,
    partners: PartnerMeter,
    paths: PathMeter,
    worlds: Vec<WorldWatch>,
    agents: Option<AgentsMeter>,
    travels: ProgressMeter<Vec2>,
    overlaps: OverlapMeter,
    present: Vec<PresentCharacter>,
    volumes: Vec<Option<BodyVolume>>,
}

impl SceneWatch {
    /// A watch without observations.
    pub fn new(sim: &Simulation, groups: &[usize]) -> Result<Self> {
        let volume = |g: &SceneGroup| Some(BodyVolume::new(sim.compiled().find_bundle(g.number)?.skeleton()));
        let mut watch = Self {
            groups: groups.to_vec(),
            feet: SlipMeter::new(sim.num_characters(), &Skeleton::default()),
            fights: FightMeter::default(),
            touch: TouchMeter::default(),
            partners: PartnerMeter::default(),
            paths: PathMeter::default(),
            worlds: Vec::new(),
            agents: AgentsMeter::of_groups(sim, |g| groups.contains(&g)),
            travels: ProgressMeter::default(),
            overlaps: OverlapMeter::default(),
            present: Vec::new(),
            volumes: sim.groups().iter().map(volume).collect(),
        };
        let is_world = |c: &usize| matches!(sim.character_groups()[*c], AnyCharacterGroup::Patches(_));
        for c in (0..sim.character_groups().len()).filter(is_world) {
            let of_character_group = groups.iter().map(|&g| &sim.groups()[g]).filter(|g| g.character_group == c);
            let characters: Vec<usize> = of_character_group.flat_map(|g| g.characters.clone()).collect();
            if !characters.is_empty() {
                watch.worlds.push(WorldWatch::new(sim, c, characters)?);
            }
        }
        Ok(watch)
    }

    /// Observes a step.
    pub fn observe(&mut self, sim: &Simulation, dt_s: f32, step: usize, hz: f64) {
        let due = |every_s: f64| step.is_multiple_of(((every_s * hz).round() as usize).max(1));
        self.feet.observe_simulation(sim, self.groups.iter().flat_map(|&g| sim.groups()[g].characters.clone()), dt_s);
        self.fights.time_s += f64::from(dt_s);
        for &g in &self.groups {
            let group = &sim.groups()[g];
            if let AnyCharacterGroup::Sparring(bouts) = &sim.character_groups()[group.character_group] {
                self.touch.observe(bouts.sparring(), group.characters.start, dt_s);
            }
            for who in group.characters.clone() {
                match sim.locate(who) {
                    (AnyCharacterGroup::Policy(_) | AnyCharacterGroup::Sparring(_), _) => self.fights.observe(sim, who),
                    (AnyCharacterGroup::Paths(p), member) => {
                        self.paths.observe(sim, who, p.speed(member), p.ground(), dt_s)
                    }
                    _ => {}
                }
            }
        }
        for world in &self.worlds {
            if let AnyCharacterGroup::Patches(people) = &sim.character_groups()[world.character_group] {
                self.partners.observe(people);
            }
        }
        if due(SAMPLE_PERIOD_S) {
            self.measure_overlaps(sim);
            self.worlds.iter_mut().for_each(|w| w.observe(sim));
        }
        if due(1.0 / SAMPLE_HZ) {
            self.observe_travels(sim);
        }
        if let Some(agents) = &mut self.agents {
            if due(1.0 / SAMPLE_HZ) {
                agents.observe(sim);
            }
            agents.observe_bodies(sim);
        }
    }

    /// Observes the characters with policies that are on the way to goals.
    fn observe_travels(&mut self, sim: &Simulation) {
        let travels = self.groups.iter().flat_map(|&g| sim.groups()[g].characters.clone()).filter_map(|who| {
            let (AnyCharacterGroup::Travel(t), number) = sim.locate(who) else { return None };
            let config = &sim.scene().groups[t.layout().groups[number]];
            Some(AgentSample {
                at: t.root(number).map(|root| Vec2::new(root.x, root.z)),
                path: &t.layout().paths[number],
                path_number: 0,
                remaining_m: t.remaining_m(number),
                arrival_m: config.arrival_m,
                is_loop: config.at_end == AtEndConfig::Again,
                has_settled: t.has_arrived(number),
                waits: t.waits(number),
            })
        });
        self.travels.observe(sim.time_s(), travels);
    }

    /// Figures of opponents, beside the clips of their first group.
    fn touch_figures(&self, sim: &Simulation) -> Option<TouchFigures> {
        let group = self.groups.iter().find(|&&g| sim.groups()[g].motion == GroupMotion::Sparring)?;
        self.touch.figures(sim.compiled().bundle(*group).ok()?)
    }

    /// Measures overlaps of characters; scenes of agents only have a meter of their own.
    fn measure_overlaps(&mut self, sim: &Simulation) {
        let groups = || self.groups.iter().map(|&g| &sim.groups()[g]);
        let is_agents = |group: &AnyCharacterGroup| agents_crowd(group).is_some();
        self.present.clear();
        if groups().all(|g| is_agents(&sim.character_groups()[g.character_group])) {
            return;
        }
        for g in groups() {
            for who in g.characters.clone() {
                let Some(root) = sim.root(who) else { continue };
                let character_group = sim.locate(who).0;
                let mut one = match (sim.pose(who), &self.volumes[g.number]) {
                    (Some(pose), Some(volume)) if !is_agents(character_group) => {
                        PresentCharacter::with_body(who, &PosedBody { root, model: pose }, volume)
                    }
                    _ => {
                        let (place, radius_m) = (Vec2::new(root.x, root.z), BODY_RADIUS_M);
                        PresentCharacter { number: who, place, radius_m, core: None }
                    }
                };
                if let AnyCharacterGroup::Patches(_) = character_group {
                    one.radius_m = 0.0;
                } else if let (AnyCharacterGroup::Ground(_), Some(disc)) = (character_group, sim.disc(who)) {
                    (one.place, one.radius_m) = (Vec2::new(disc.centre.x, disc.centre.z), disc.radius);
                }
                self.present.push(one);
            }
        }
        let are_opponents = |a: usize, b: usize| match (sim.locate(a), sim.locate(b)) {
            ((AnyCharacterGroup::Sparring(_), i), (AnyCharacterGroup::Sparring(_), j)) => {
                a.abs_diff(b) == 1 && i / 2 == j / 2
            }
            _ => false,
        };
        self.overlaps.observe_bodies(&self.present, are_opponents);
    }

    /// Faults that were observed: time (s), character, description.
    pub fn faults(&self) -> impl Iterator<Item = &(f32, usize, String)> {
        self.worlds.iter().flat_map(|w| &w.seen.faults)
    }

    /// The figures.
    ///
    /// - `rate`: steps of all characters per second, for the total only.
    pub fn figures(&self, sim: &Simulation, seconds: f64, rate: Option<f64>) -> SceneFigures {
        let number = |of: &dyn Fn(GroupMotion, &AnyCharacterGroup) -> bool| {
            let groups = self.groups.iter().map(|&g| &sim.groups()[g]);
            let counted = groups.filter(|g| of(g.motion, &sim.character_groups()[g.character_group]));
            let num: usize = counted.map(|g| g.characters.len()).sum();
            (num > 0).then_some(num)
        };
        let is_agent = |_: GroupMotion, group: &AnyCharacterGroup| agents_crowd(group).is_some();
        let characters = number(&|m, c| !is_agent(m, c));
        let has_feet = self.feet.has_seen_feet();
        let mut figures = SceneFigures {
            characters,
            agents: number(&is_agent),
            simulated_s: seconds,
            steps_per_second: rate.filter(|_| characters.is_some()),
            blows: number(&|_, c| matches!(c, AnyCharacterGroup::Policy(_) | AnyCharacterGroup::Sparring(_)))
                .map(|n| self.fights.figures(sim, &self.groups, n, seconds)),
            touch: self.touch_figures(sim),
            partners: self.partners.figures(),
            world: (!self.worlds.is_empty()).then(|| WorldWatch::figures(&self.worlds, sim, seconds)),
            paths: number(&|_, c| matches!(c, AnyCharacterGroup::Paths(_))).map(|_| self.paths.figures()),
            character_overlaps: characters.map(|_| self.overlaps.pairs()),
            deepest_overlap_m: characters.map(|_| self.overlaps.deepest_m),
            foot_slip_mean_mps: has_feet.then(|| self.feet.mean_mps()),
            foot_slip_p95_mps: has_feet.then(|| self.feet.p95_mps()),
            ..SceneFigures::default()
        };
        let mut stuck = (!self.worlds.is_empty()).then(|| self.worlds.iter().map(|w| w.seen.stuck.len()).sum());
        let of_agents = self.agents.as_ref().and_then(|a| a.figures(sim, seconds, rate.is_some()));
        if let Some((num, crowd)) = of_agents {
            stuck = Some(stuck.unwrap_or(0) + num);
            figures.engine = Some(engine::name(sim.scene().agents.engine).into());
            figures.crowd = Some(crowd);
        }
        if number(&|_, c| matches!(c, AnyCharacterGroup::Travel(_))).is_some() {
            stuck = Some(stuck.unwrap_or(0) + self.travels.stuck());
            let (arrived, stuck_at_end) = (self.travels.arrived(), self.travels.stuck_at(seconds));
            match &mut figures.crowd {
                Some(crowd) => {
                    (crowd.arrived, crowd.stuck_at_end) = (crowd.arrived + arrived, crowd.stuck_at_end + stuck_at_end);
                    let num_travellers = number(&|_, c| matches!(c, AnyCharacterGroup::Travel(_))).unwrap_or(0);
                    let num = figures.agents.unwrap_or(0) + num_travellers;
                    crowd.reached = crowd.arrived as f64 / num.max(1) as f64;
                }
                None => {
                    figures.travel = Some(TravelFigures {
                        progress_mps: self.travels.progress_mps(),
                        stuck_at_end,
                        arrived,
                        reached: self.travels.reached(),
                        stopped_share: self.travels.stopped_share(),
                    });
                }
            }
        }
        figures.stuck = stuck;
        figures
    }
}

/// Distances of characters from the targets of their blows.
#[derive(Default)]
struct FightMeter {
    /// Time by the characters' own clocks (s).
    time_s: f64,
    distance_sum: f64,
    distances: u64,
    distance_max: Option<f32>,
}

impl FightMeter {
    fn observe(&mut self, sim: &Simulation, who: usize) {
        let (Some(root), Some(target)) = (sim.root(who), sim.target(who)) else { return };
        let distance = (root.x - target.x).hypot(root.z - target.z);
        self.distance_sum += f64::from(distance);
        self.distances += 1;
        if self.time_s > APPROACH_S {
            self.distance_max = Some(self.distance_max.map_or(distance, |most| most.max(distance)));
        }
    }

    fn figures(&self, sim: &Simulation, groups: &[usize], n: usize, seconds: f64) -> BlowFigures {
        let (mut blows, mut penetration, mut deep_s, mut num_pairs) = (BlowTally::default(), 0.0f32, 0.0, 0);
        for &g in groups {
            match &sim.character_groups()[sim.groups()[g].character_group] {
                AnyCharacterGroup::Sparring(s) => {
                    let f = s.sparring().figures();
                    blows += f.blows;
                    penetration = penetration.max(f.max_penetration_m);
                    deep_s += f64::from(f.deep_s);
                    num_pairs += s.sparring().num_pairs();
                }
                AnyCharacterGroup::Policy(p) => blows += p.practice().figures().blows,
                _ => {}
            }
        }
        let share = |count: u32| f64::from(count) / f64::from(blows.thrown.max(1));
        BlowFigures {
            hits_per_minute: f64::from(blows.landed) * 60.0 / seconds / n as f64,
            landed_fraction: share(blows.landed),
            blocked_fraction: share(blows.blocked),
            thrown: blows.thrown,
            max_penetration_m: f64::from(penetration),
            deep_fraction: deep_s / (seconds * num_pairs.max(1) as f64),
            distance_mean_m: self.distance_sum / self.distances.max(1) as f64,
            distance_max_m: self.distance_max.map(f64::from),
        }
    }
}

/// Speeds, knees and feet of characters on random paths.
#[derive(Default)]
struct PathMeter {
    speed_sum: f64,
    num_samples: u64,
    figures: FollowedPathFigures,
    /// Angles at the knees at the last step, by the character's number.
    knees: Vec<[f32; 2]>,
}

impl PathMeter {
    fn observe(&mut self, sim: &Simulation, who: usize, speed: f32, ground: &HeightField, dt_s: f32) {
        let Some(pose) = sim.joint_positions(who) else { return };
        self.knees.resize(self.knees.len().max(who + 1), [0.0; 2]);
        let f = &mut self.figures;
        let now = knee_angles(&pose);
        let before = std::mem::replace(&mut self.knees[who], now);
        if dt_s > 0.0 {
            let rate = (0..2).map(|k| (now[k] - before[k]).abs() / dt_s).fold(0.0, f32::max);
            f.knee_rate_max_radps = f.knee_rate_max_radps.max(f64::from(rate));
        }
        let feet = [Joint::LeftFoot, Joint::LeftToe, Joint::RightFoot, Joint::RightToe].map(|j| pose[j.index()]);
        let below =
            feet.map(|p| ground.ground_at(Vec2::new(p.x, p.z), p.y).height - p.y).into_iter().fold(0.0, f32::max);
        f.below_ground_max_m = f.below_ground_max_m.max(f64::from(below));
        f.speed_max_mps = f.speed_max_mps.max(f64::from(speed));
        self.speed_sum += f64::from(speed);
        self.num_samples += 1;
    }

    fn figures(&self) -> FollowedPathFigures {
        FollowedPathFigures { speed_mean_mps: self.speed_sum / self.num_samples.max(1) as f64, ..self.figures.clone() }
    }
}

/// Angles at the knees; pi where a leg is straight (rad).
pub fn knee_angles(pose: &[Vec3; NUM_JOINTS]) -> [f32; 2] {
    LEGS.map(|leg| {
        let [hip, knee, ankle, _] = leg.map(|j| pose[j.index()]);
        (hip - knee).angle_between(ankle - knee)
    })
}
