//! Blended bodies of many sizes on random paths.

use crate::motion_kind::{GroupStep, MotionKind, PART, check_snapshot, load_same, saved_bytes, single_pose};
use crate::scene::{BodiesConfig, Scene};
use crate::{SimulationEvent, compile::CompiledScene, paths::RandomPath};
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::sync::Arc;
use throng_base::ground::{ExternalObstacle, ReservedRegion};
use throng_base::{Bytes, Error, Id, Result, SnapshotKind, maths, run_each};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{CharacterGroup, Contacts, Joint, Mat3x4, NUM_JOINTS, Planar, Skeleton};
use throng_core::{body::HeightField, stops::BODY_RADIUS_M};

/// Length of a hill (m).
const HILL_M: f32 = 24.0;

/// Walkers of one blend space on their paths.
#[derive(Clone, Debug)]
struct PathWalkers {
    walkers: Walkers,
    ids: Vec<Id>,
    paths: Vec<RandomPath>,
    /// Speed of each body relative to that of the database skeleton in the same motion (1).
    paces: Vec<f32>,
    /// Controls at the end of the step, from the paths.
    controls: Vec<Control>,
}

/// Snapshot of paths and of the walkers on them, troop by troop.
const PATHS: SnapshotKind = SnapshotKind { what: "wanderers", tag: *b"WAND", version: 1, setup: 0 };

/// Group on random paths, which avoids nobody.
#[derive(Clone, Debug)]
pub struct Wanderers {
    scene: Arc<Scene>,
    group: usize,
    /// Troops; characters take them in turn, by their numbers among all groups on paths.
    troops: Vec<PathWalkers>,
    /// Number of the first character among all groups on paths.
    first: usize,
    ground: HeightField,
}

impl Wanderers {
    /// Creates the group with all characters in place.
    ///
    /// # Errors
    /// [`throng_base::Error::Text`] for a blend space that the bundle does not have.
    pub(crate) fn new(compiled: &CompiledScene, group: usize) -> Result<Self> {
        let (scene, bundle) = (&compiled.scene, compiled.bundle(group)?);
        let (config, seed) = (&scene.groups[group], scene.seed);
        let first = compiled.first_number(group);
        let paths = config.paths.clone().unwrap_or_default();
        let fault = |e: Error| scene.fault(&format!("groups[{group}]"), e);
        let bodies = random_skeletons(&config.bodies(), bundle.skeleton(), seed);
        let leg = bundle.skeleton().leg_length();
        let ground = ground(scene.environment.hills_m, &paths).map_err(fault)?;
        let mut troops = Vec::with_capacity(config.spaces.len());
        for t in 0..config.spaces.len() {
            let space = compiled.blend_space(group, t)?;
            let numbers: Vec<u64> =
                (first..first + config.count).filter(|c| c % config.spaces.len() == t).map(|c| c as u64).collect();
            let mut wanders: Vec<RandomPath> = numbers.iter().map(|&c| RandomPath::new(&paths, seed, c)).collect();
            let controls: Vec<Control> = wanders.iter_mut().map(|p| p.step(&paths, 0.0)).collect();
            let start = |(&c, control): (&u64, &Control)| {
                let (at, heading) = (control.position.unwrap_or_default(), control.heading.unwrap_or(0.0));
                let (body, phase) = (c as usize % bodies.len(), (c as f32 * 0.381_966).fract());
                WalkerStart { body, root: Planar { x: at.x, z: at.y, heading }, phase }
            };
            let starts = numbers.iter().zip(&controls).map(start);
            let made = Walkers::with_capacity(space, &bodies, WalkersConfig::default(), numbers.len());
            let made = made.and_then(|mut walkers| {
                walkers.set_ground(ground.clone());
                let ids = starts.map(|s| walkers.spawn(s)).collect::<Result<Vec<Id>>>()?;
                Ok((walkers, ids))
            });
            let (walkers, ids) = made.map_err(fault)?;
            let pace = |&c: &u64| (bodies[c as usize % bodies.len()].leg_length() / leg).sqrt();
            let paces = numbers.iter().map(pace).collect();
            troops.push(PathWalkers { walkers, ids, paths: wanders, paces, controls });
        }
        Ok(Self { scene: Arc::clone(scene), group, troops, first, ground })
    }

    /// Ground that they walk on.
    pub fn ground(&self) -> &HeightField {
        &self.ground
    }

    /// Speed of a character's path (m/s, number < num_characters).
    pub fn speed(&self, number: usize) -> f32 {
        let (troop, w) = self.troop_of(number);
        troop.paths[w].speed
    }

    /// Walkers of a character's troop, and its number among them (number < num_characters).
    pub fn walkers_of(&self, number: usize) -> (&Walkers, usize) {
        let (troop, w) = self.troop_of(number);
        (&troop.walkers, w)
    }

    fn troop_of(&self, number: usize) -> (&PathWalkers, usize) {
        let num = self.troops.len();
        (&self.troops[(self.first + number) % num], number / num)
    }
}

impl MotionKind for Wanderers {
    fn num_characters(&self) -> usize {
        self.troops.iter().map(|t| t.walkers.len()).sum()
    }

    fn step(&mut self, tick: &GroupStep<'_>, _: &mut Vec<SimulationEvent>) -> Result<()> {
        let config = &self.scene.groups[self.group];
        let Some(paths) = &config.paths else { return Ok(()) };
        for t in &mut self.troops {
            let fault = |e: Error| self.scene.fault(&format!("groups[{}]", self.group), e);
            let parts = t.paths.chunks_mut(PART).zip(t.paces.chunks(PART)).zip(t.controls.chunks_mut(PART));
            run_each(tick.run, parts, |((own, paces), controls)| {
                for ((path, pace), control) in own.iter_mut().zip(paces).zip(controls) {
                    *control = path.step(paths, tick.dt_s);
                    control.style[0] = config.style_at(path.speed / pace);
                }
            });
            let mut orders = t.ids.iter().zip(&t.controls);
            orders.try_for_each(|(&id, &control)| t.walkers.order(id, control)).map_err(fault)?;
            t.walkers.step(tick.dt_s, tick.run).map_err(fault)?;
        }
        Ok(())
    }

    /// Reserves the ground that they may reach within a second, since they stop for nobody.
    fn add_reserved_regions(&mut self, out: &mut ReservedRegion) {
        for number in 0..self.num_characters() {
            let Some(root) = self.root(number) else { continue };
            let velocity = maths::direction_at_angle(std::f32::consts::FRAC_PI_2 - root.heading) * self.speed(number);
            out.reserve_ahead(ExternalObstacle { place: Vec2::new(root.x, root.z), velocity, radius_m: BODY_RADIUS_M });
        }
    }

    fn save(&self, out: &mut Vec<u8>) {
        let troop = |t: &PathWalkers| (t.paths.clone(), saved_bytes(|out| t.walkers.save(out)));
        PATHS.write(&self.troops.iter().map(troop).collect::<Vec<_>>(), out);
    }

    fn load(&mut self, bytes: &[u8], _: f64) -> Result<()> {
        let troops: Vec<(Vec<RandomPath>, Bytes)> = PATHS.read_all(bytes)?;
        check_snapshot(troops.len() == self.troops.len(), PATHS.what, "it has other blend spaces")?;
        for (own, (paths, walkers)) in self.troops.iter_mut().zip(troops) {
            let are_valid = paths.len() == own.paths.len() && paths.iter().all(RandomPath::is_valid);
            check_snapshot(are_valid, PATHS.what, "its paths lead nowhere")?;
            load_same(&mut own.walkers, &walkers.0)?;
            own.paths = paths;
        }
        Ok(())
    }

    fn root(&self, number: usize) -> Option<Planar> {
        let (walkers, w) = self.walkers_of(number);
        Some(walkers.root(w))
    }

    fn pose(&self, number: usize) -> Option<&[Mat3x4; NUM_JOINTS]> {
        let (walkers, w) = self.walkers_of(number);
        Some(single_pose(walkers.pose(w)))
    }

    fn contacts(&self, number: usize) -> Contacts {
        let (walkers, w) = self.walkers_of(number);
        walkers.contacts(w)
    }

    fn soles(&self, number: usize) -> Option<[[Vec3; 2]; 2]> {
        let (walkers, w) = self.walkers_of(number);
        Some(walkers.soles(w))
    }
}

/// Hills under a square of paths; level ground where `hills_m` is 0.
fn ground(hills_m: f32, paths: &crate::scene::PathsConfig) -> Result<HeightField> {
    if hills_m == 0.0 {
        return Ok(HeightField::flat());
    }
    let (half, spacing, n) = paths.ground_grid();
    let wave = |v: f32| maths::sin(v * std::f32::consts::TAU / HILL_M);
    let at = |i: usize| i as f32 * spacing - half;
    let height = |k: usize| 0.25 * hills_m * (2.0 + wave(at(k % n)) + wave(0.7 * at(k / n) + 1.0));
    let corner = Vec2::from(paths.centre) - Vec2::splat(half);
    HeightField::new(corner, spacing, [n, n], (0..n * n).map(height).collect())
}

/// Skeletons of many sizes and proportions.
pub fn random_skeletons(bodies: &BodiesConfig, database: &Skeleton, seed: u64) -> Vec<Skeleton> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut draw = |[low, high]: [f32; 2]| low + (high - low) * rng.random_range(0.0..1.0f32);
    (0..bodies.kinds).map(|_| scaled_skeleton(database, draw(bodies.sizes), draw(bodies.legs))).collect()
}

/// Skeleton of another size and with other proportions of legs.
///
/// - `size`: factor of all lengths (1).
/// - `legs`: further factor of the lengths of thighs and shins (1).
pub fn scaled_skeleton(database: &Skeleton, size: f32, legs: f32) -> Skeleton {
    let mut out = database.clone();
    let is_leg = |j: Joint| matches!(j, Joint::LeftShin | Joint::LeftFoot | Joint::RightShin | Joint::RightFoot);
    for j in Joint::ALL {
        out.offsets[j.index()] *= if is_leg(j) { size * legs } else { size };
    }
    out.tips.iter_mut().for_each(|t| *t *= size);
    // The hips are as high as the legs are long.
    let leg = database.offsets[Joint::LeftShin.index()].length() + database.offsets[Joint::LeftFoot.index()].length();
    let hips = database.offsets[Joint::Hips.index()];
    out.offsets[Joint::Hips.index()] = size * (hips + Vec3::Y * (legs - 1.0) * leg);
    out
}
