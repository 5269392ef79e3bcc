//! Everybody of a scene: one set of walkers for each blend space.

use super::config::{BodiesConfig, WalkersScene};
use super::path::Wander;
use crate::slip::Soles;
use glam::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::path::Path;
use throng_motion::error::BuildError;
use throng_runtime::blend::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::blend::{BlendSpace, HeightField};
use throng_runtime::{Bundle, Cast, Contacts, Error, Id, Inline, Joint, Mat3x4, NUM_JOINTS, Planar, Skeleton};

/// Most heights along a side of the ground, which take 64 MiB: those of a wider one lie farther apart.
const GROUND_KNOTS: f32 = 4000.0;
/// Least distance between two heights of the ground (m).
const GROUND_SPACING_M: f32 = 0.5;
/// Length of a hill (m).
const HILL_M: f32 = 24.0;

/// The walkers of one blend space.
#[derive(Clone, Debug)]
struct Group {
    walkers: Walkers,
    ids: Vec<Id>,
    paths: Vec<Wander>,
    /// Speeds of bodies that move alike, over those of the database skeleton.
    paces: Vec<f32>,
}

/// The walkers of a scene, who go where chance leads.
#[derive(Clone, Debug)]
pub struct Walk {
    scene: WalkersScene,
    groups: Vec<Group>,
    ground: HeightField,
    time_s: f64,
}

impl WalkersScene {
    /// Puts everybody in place.
    ///
    /// # Errors
    /// [`BuildError::Stage`] for a blend space that the bundle does not have, or for bodies out of range.
    pub fn walk(&self, tables: &Bundle, config: WalkersConfig) -> Result<Walk, BuildError> {
        self.check_spaces(tables)?;
        let bodies = self.bodies.make(tables.skeleton(), self.seed);
        let leg = tables.skeleton().leg_length();
        let ground = self.ground().map_err(|e| self.fault(&e))?;
        let mut groups = Vec::with_capacity(self.spaces.len());
        for (g, name) in self.spaces.iter().enumerate() {
            let space = self.space(tables, name)?;
            let members: Vec<u64> = (g..self.characters).step_by(self.spaces.len()).map(|c| c as u64).collect();
            let mut paths: Vec<Wander> = members.iter().map(|&c| Wander::new(&self.paths, self.seed, c)).collect();
            let controls: Vec<Control> = paths.iter_mut().map(|p| p.step(&self.paths, 0.0)).collect();
            let start = |(&c, control): (&u64, &Control)| WalkerStart {
                body: c as usize % bodies.len(),
                root: root_of(control),
                phase: (c as f32 * 0.381_966).fract(),
            };
            let starts = members.iter().zip(&controls).map(start);
            let made = Walkers::with_capacity(space, &bodies, config, members.len()).and_then(|mut walkers| {
                walkers.set_ground(ground.clone());
                let ids = starts.map(|s| walkers.spawn(s)).collect::<Result<_, _>>()?;
                Ok((walkers, ids))
            });
            let (walkers, ids) = made.map_err(|e| self.fault(&e))?;
            let pace = |&c: &u64| (bodies[c as usize % bodies.len()].leg_length() / leg).sqrt();
            let paces = members.iter().map(pace).collect();
            groups.push(Group { walkers, ids, paths, paces });
        }
        Ok(Walk { scene: self.clone(), groups, ground, time_s: 0.0 })
    }

    /// A blend space by its name.
    ///
    /// # Errors
    /// [`BuildError::Stage`] with the names that there are.
    pub fn space(&self, tables: &Bundle, name: &str) -> Result<BlendSpace, BuildError> {
        named_space(tables, "spaces", name, (&self.name, &self.bundle))
    }

    /// Every space that the scene names is there, so that nothing is found missing after a run.
    fn check_spaces(&self, tables: &Bundle) -> Result<(), BuildError> {
        for (i, name) in self.spaces.iter().enumerate() {
            named_space(tables, &format!("spaces[{i}]"), name, (&self.name, &self.bundle))?;
        }
        for (i, shown) in self.shown.iter().enumerate() {
            named_space(tables, &format!("shown[{i}].space"), &shown.space, (&self.name, &self.bundle))?;
        }
        Ok(())
    }

    /// The ground of the scene.
    ///
    /// # Errors
    /// As [`HeightField::new`].
    pub fn ground(&self) -> Result<HeightField, Error> {
        if self.hills_m == 0.0 {
            return Ok(HeightField::flat());
        }
        let half = 0.5 * self.paths.area_m + 20.0;
        let spacing = (2.0 * half / GROUND_KNOTS).max(GROUND_SPACING_M);
        let n = (2.0 * half / spacing).ceil() as usize + 1;
        let wave = |v: f32| (v * std::f32::consts::TAU / HILL_M).sin();
        let at = |i: usize| i as f32 * spacing - half;
        let height = |k: usize| 0.25 * self.hills_m * (2.0 + wave(at(k % n)) + wave(0.7 * at(k / n) + 1.0));
        HeightField::new(Vec2::splat(-half), spacing, [n, n], (0..n * n).map(height).collect())
    }

    pub(super) fn fault(&self, e: &Error) -> BuildError {
        blend_fault(&self.name, e)
    }
}

/// Where a control is.
fn root_of(control: &Control) -> Planar {
    let at = control.position.unwrap_or_default();
    Planar { x: at.x, z: at.y, heading: control.heading.unwrap_or(0.0) }
}

/// A blend space of a bundle by its name; the key of the scene file that names it, scene and bundle are for messages.
///
/// # Errors
/// [`BuildError::Stage`] with the names that there are.
pub(in crate::scene) fn named_space(
    tables: &Bundle,
    key: &str,
    name: &str,
    (scene, bundle): (&str, &Path),
) -> Result<BlendSpace, BuildError> {
    let known: Vec<&str> = tables.meta().blends.iter().map(|b| b.name.as_str()).collect();
    match known.iter().position(|n| *n == name) {
        Some(_) => tables.blend(name).map_err(|e| blend_fault(scene, &e)),
        None => Err(BuildError::Stage {
            stage: "scene",
            message: format!(
                "scene \"{scene}\": key `{key}`: expected a blend space of {}, found `{name}`; there are: {}",
                bundle.display(),
                known.join(", ")
            ),
            help: "Correct the name, or build the bundle with such a space".into(),
        }),
    }
}

/// What blending found wrong with a scene.
pub(in crate::scene) fn blend_fault(scene: &str, e: &Error) -> BuildError {
    BuildError::Stage {
        stage: "scene",
        message: format!("scene \"{scene}\": {e}"),
        help: "Correct the scene file".into(),
    }
}

impl BodiesConfig {
    /// Skeletons of many sizes and proportions.
    pub fn make(&self, database: &Skeleton, seed: u64) -> Vec<Skeleton> {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut draw = |[low, high]: [f32; 2]| low + (high - low) * rng.random_range(0.0..1.0f32);
        (0..self.kinds).map(|_| body_of(database, draw(self.sizes), draw(self.legs))).collect()
    }
}

/// A skeleton of another size whose legs are longer or shorter than that.
///
/// - `size`: of everything (size of the database skeleton).
/// - `legs`: length of thighs and shins over that.
pub fn body_of(database: &Skeleton, size: f32, legs: f32) -> Skeleton {
    let mut out = database.clone();
    let is_leg = |j: Joint| matches!(j, Joint::LeftShin | Joint::LeftFoot | Joint::RightShin | Joint::RightFoot);
    for j in Joint::ALL {
        out.offsets[j.index()] *= if is_leg(j) { size * legs } else { size };
    }
    out.tips.iter_mut().for_each(|t| *t *= size);
    // The hips are as high as the legs leave them.
    let leg = database.offsets[Joint::LeftShin.index()].length() + database.offsets[Joint::LeftFoot.index()].length();
    let hips = database.offsets[Joint::Hips.index()];
    out.offsets[Joint::Hips.index()] = size * (hips + Vec3::Y * (legs - 1.0) * leg);
    out
}

impl Walk {
    /// Moves everybody on by `dt_s` on this thread.
    ///
    /// # Errors
    /// [`BuildError::Stage`] where `dt_s` is not in `0..=1`.
    pub fn step(&mut self, dt_s: f32) -> Result<(), BuildError> {
        let scene = &self.scene;
        for g in &mut self.groups {
            for ((path, pace), id) in g.paths.iter_mut().zip(&g.paces).zip(&g.ids) {
                let mut control = path.step(&scene.paths, dt_s);
                control.style[0] = scene.style(path.speed() / pace);
                g.walkers.order(*id, control).map_err(|e| scene.fault(&e))?;
            }
            g.walkers.step(dt_s, &Inline).map_err(|e| scene.fault(&e))?;
        }
        self.time_s += f64::from(dt_s);
        Ok(())
    }

    /// Number of characters.
    pub fn num_characters(&self) -> usize {
        self.groups.iter().map(|g| g.walkers.len()).sum()
    }

    /// Time since everybody was put in place (s).
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// The ground they walk on.
    pub fn ground(&self) -> &HeightField {
        &self.ground
    }

    /// Planar root of a character (character < num_characters).
    pub fn root(&self, character: usize) -> Planar {
        let (walkers, member) = self.walkers_of(character);
        walkers.root(member)
    }

    /// Joints of one character in model space, which [`Walk::root`] places in the world; heights contain that of the
    /// ground (NUM_JOINTS, character < num_characters).
    pub fn pose(&self, character: usize) -> &[Mat3x4] {
        let (walkers, member) = self.walkers_of(character);
        walkers.pose(member)
    }

    /// World positions of one character's joints (m, character < num_characters).
    pub fn joint_positions(&self, character: usize) -> [Vec3; NUM_JOINTS] {
        let (walkers, member) = self.walkers_of(character);
        walkers.joint_positions(member)
    }

    /// Bottom of the heel and ball of both feet of a character, in the world (m).
    /// (character < num_characters)
    pub fn soles(&self, character: usize) -> Soles {
        let (walkers, member) = self.walkers_of(character);
        walkers.soles(member)
    }

    /// Planted parts of a character's feet (character < num_characters).
    pub fn contacts(&self, character: usize) -> Contacts {
        let (walkers, member) = self.walkers_of(character);
        walkers.contacts(member)
    }

    /// Speed at which a character's path leads on (m/s, character < num_characters).
    pub fn speed(&self, character: usize) -> f32 {
        self.groups[character % self.groups.len()].paths[character / self.groups.len()].speed()
    }

    /// Characters take the groups in turn.
    fn walkers_of(&self, character: usize) -> (&Walkers, usize) {
        (&self.groups[character % self.groups.len()].walkers, character / self.groups.len())
    }
}
