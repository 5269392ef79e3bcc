//! Measures characters of a world: penetrations, progress.

use crate::run::figures::InhabitedFigures;
use crate::run::report::{config_error, world_geometry};
use glam::{Vec2, Vec3, Vec3Swizzles};
use std::collections::BTreeSet;
use throng_bake::environment::{BodySpheres, PlacedGeometry};
use throng_base::maths;
use throng_core::{Joint, NUM_JOINTS};
use throng_motion::error::Result;
use throng_simulation::{AnyCharacterGroup, Simulation};
use throng_world::inhabitants::InhabitantActivity;

/// Penetrations deeper than this into a unit count (m).
const PENETRATION_M: f32 = 0.08;
/// A character that has a goal elsewhere and stays within `STUCK_M` for this long is stuck (s).
const STUCK_S: f64 = 30.0;
/// See [`STUCK_S`] (m).
const STUCK_M: f32 = 0.5;

/// Length over ground of the path stretches between which turning is measured (m).
const STRETCH_M: f32 = 0.5;

/// The last stretch of a character's path over ground.
#[derive(Clone, Copy, Debug)]
struct PathStretch {
    end: Vec2,
    /// Unit vector; zero before the first one.
    direction: Vec2,
}

/// Place and time of a character's last progress.
#[derive(Clone, Copy, Debug)]
struct LastProgress {
    at: Vec3,
    since_s: f64,
}

/// Measures some characters of one world every tenth of a second.
pub(super) struct WorldWatch {
    pub character_group: usize,
    /// Numbers of the characters in the simulation.
    characters: Vec<usize>,
    body: BodySpheres,
    geometry: PlacedGeometry,
    progress: Vec<LastProgress>,
    pub seen: WorldSightings,
}

/// Observations of a world so far.
#[derive(Default)]
pub(super) struct WorldSightings {
    /// Penetrations: time (s), character, description.
    pub faults: Vec<(f32, usize, String)>,
    /// Current pairs of a character and a unit that it penetrates.
    inside: BTreeSet<(usize, usize)>,
    penetrations: u64,
    deepest_m: f32,
    pub stuck: BTreeSet<usize>,
    last: Vec<Vec3>,
    travelled_m: f64,
    stretches: Vec<PathStretch>,
    /// Sum of turning angles, and of lengths, over all stretches (deg, m).
    turned_deg: f64,
    along_m: f64,
    num_samples: u64,
    waiting: u64,
}

impl WorldWatch {
    pub fn new(sim: &Simulation, character_group: usize, characters: Vec<usize>) -> Result<Self> {
        let group = sim.groups().iter().find(|g| g.character_group == character_group).map_or(0, |g| g.number);
        let bundle = sim.compiled().bundle(group).map_err(config_error)?;
        Ok(Self {
            character_group,
            body: BodySpheres::new(bundle.skeleton()),
            geometry: world_geometry(sim.compiled(), group)?,
            progress: vec![LastProgress { at: Vec3::splat(f32::MAX), since_s: 0.0 }; characters.len()],
            seen: WorldSightings::default(),
            characters,
        })
    }

    pub fn observe(&mut self, sim: &Simulation) {
        let AnyCharacterGroup::Patches(people) = &sim.character_groups()[self.character_group] else { return };
        let trunk = |p: [Vec3; NUM_JOINTS]| [p[Joint::Hips.index()], p[Joint::Neck.index()]];
        let trunks: Vec<[Vec3; 2]> =
            self.characters.iter().filter_map(|&c| sim.joint_positions(c)).map(trunk).collect();
        self.find_penetrations(sim);
        for (k, trunk) in trunks.iter().enumerate() {
            let (_, number) = sim.locate(self.characters[k]);
            let (doing, progress) = (people.state(number).activity, &mut self.progress[k]);
            self.seen.num_samples += 1;
            self.seen.waiting += u64::from(matches!(doing, InhabitantActivity::Waiting | InhabitantActivity::Meeting));
            let at_will = matches!(
                doing,
                InhabitantActivity::Performing | InhabitantActivity::Meeting | InhabitantActivity::Arrived
            );
            if at_will || (trunk[0] - progress.at).length() > STUCK_M {
                *progress = LastProgress { at: trunk[0], since_s: sim.time_s() };
            } else if sim.time_s() - progress.since_s > STUCK_S {
                self.seen.stuck.insert(k);
            }
        }
        if !self.seen.last.is_empty() {
            let distance = trunks.iter().zip(&self.seen.last).map(|(t, l)| f64::from((t[0] - *l).length()));
            self.seen.travelled_m += distance.sum::<f64>();
        }
        self.seen.last = trunks.iter().map(|t| t[0]).collect();
        let begins = |hips: &Vec3| PathStretch { end: hips.xz(), direction: Vec2::ZERO };
        if self.seen.stretches.is_empty() {
            self.seen.stretches = self.seen.last.iter().map(begins).collect();
        }
        for (stretch, hips) in self.seen.stretches.iter_mut().zip(&self.seen.last) {
            let along = hips.xz() - stretch.end;
            if along.length() >= STRETCH_M {
                let direction = along.normalize();
                if stretch.direction != Vec2::ZERO {
                    self.seen.turned_deg += f64::from(stretch.direction.angle_to(direction).abs().to_degrees());
                    self.seen.along_m += f64::from(along.length());
                }
                *stretch = PathStretch { end: hips.xz(), direction };
            }
        }
    }

    /// Finds the characters that penetrate units.
    fn find_penetrations(&mut self, sim: &Simulation) {
        let mut inside = BTreeSet::new();
        for &c in &self.characters {
            let (Some(root), Some(pose)) = (sim.root(c), sim.pose(c)) else { continue };
            let (turn, by) = (root.rotation(), root.translation());
            let transforms =
                std::array::from_fn(|j| (turn * pose[j].translation() + by, maths::compose(turn, pose[j].rotation())));
            let body = self.body.pose(&transforms, sim.contacts(c));
            let Some((unit, p)) = body.penetration_in(&self.geometry, PENETRATION_M) else { continue };
            self.seen.deepest_m = self.seen.deepest_m.max(p.depth);
            inside.insert((c, unit));
            if !self.seen.inside.contains(&(c, unit)) {
                self.seen.penetrations += 1;
                let what = format!("{} {:.2} m in unit {unit}", p.joint.name(), p.depth);
                self.seen.faults.push((sim.time_s() as f32, c, what));
            }
        }
        self.seen.inside = inside;
    }

    pub fn figures(all: &[Self], sim: &Simulation, seconds: f64) -> InhabitedFigures {
        let n: usize = all.iter().map(|w| w.characters.len()).sum();
        let character_minutes = f64::from(seconds as f32) / 60.0 * n as f64;
        let mut f = InhabitedFigures::default();
        let (mut fulfilled, mut travelled_m, mut waiting, mut looks) = (0u32, 0.0, 0u64, 0u64);
        let along_m = all.iter().map(|w| w.seen.along_m).sum::<f64>();
        f.turned_deg_per_m = all.iter().map(|w| w.seen.turned_deg).sum::<f64>() / along_m.max(f64::MIN_POSITIVE);
        for w in all {
            let AnyCharacterGroup::Patches(people) = &sim.character_groups()[w.character_group] else { continue };
            let of = |c: &usize| people.state(sim.locate(*c).1).num_fulfilled;
            fulfilled += w.characters.iter().map(of).sum::<u32>();
            (travelled_m, waiting, looks) =
                (travelled_m + w.seen.travelled_m, waiting + w.seen.waiting, looks + w.seen.num_samples);
            f.environment_penetrations += w.seen.penetrations;
            f.deepest_penetration_m = f.deepest_penetration_m.max(f64::from(w.seen.deepest_m));
        }
        f.fulfilled_per_minute = f64::from(fulfilled) / character_minutes;
        f.travelled_m_per_minute = travelled_m / character_minutes;
        f.waiting_fraction = waiting as f64 / looks.max(1) as f64;
        f
    }
}
