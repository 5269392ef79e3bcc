//! The features of every usable frame of a bundle.

use super::features::{AHEAD_S, FeatureWeights, Group, POSE, Row, WIDTH};
use super::goal::MatchGoal;
use glam::{Vec2, Vec3};
use std::ops::Range;
use throng_core::characters::{MotionSet, SampleJob};
use throng_core::hits::striking_point;
use throng_core::{Bundle, Joint, Mat3x4, NUM_JOINTS, Planar};
use throng_lab::frames::runs;

/// How far ahead a hit is a feature (s).
pub const HIT_HORIZON_S: f32 = 1.0;
/// What stands for the time until a hit where none comes (s).
const NO_HIT_S: f32 = 2.0 * HIT_HORIZON_S;
/// Frames nearer than this to the end of their run are not found: there is too little left to play.
const LEAST_LEFT: u32 = 20;
/// Frames sampled at a time.
const BATCH: usize = 1024;

/// Positions of the hips, both feet and both fists in the frame of the planar root (m).
type Points = [Vec3; 5];

/// Every usable frame of a bundle as a row of features.
#[derive(Clone, Debug)]
pub struct Database {
    /// Rows that a search may find.
    rows: Vec<Row>,
    /// Frame of each of them.
    frames: Vec<u32>,
    /// Rows of all frames; zeros where a frame is not usable (number of frames).
    all: Vec<Row>,
    /// End of the run of usable frames that each frame lies in; 0 where it is not usable (number of frames).
    run_ends: Vec<u32>,
    /// Planar root of each frame within its clip.
    roots: Vec<Planar>,
    /// Hips, feet and fists of each frame, as its planar root sees them.
    points: Vec<Points>,
    /// Root velocity of each frame, in its own frame: x, z (m/s).
    velocities: Vec<Vec2>,
    mean: Row,
    factor: Row,
    rate_hz: f32,
}

impl Database {
    /// Works out the features of a bundle.
    ///
    /// # Panics
    /// Never for an open bundle: its frames are sampled in range.
    pub fn new(tables: &Bundle, weights: &FeatureWeights) -> Self {
        let roots: Vec<Planar> =
            tables.frames().iter().map(|f| Planar::new(f.planar[0], f.planar[1], f.planar[2])).collect();
        let n = roots.len();
        let mut db = Self {
            rows: Vec::new(),
            frames: Vec::new(),
            all: vec![[0.0; WIDTH]; n],
            run_ends: vec![0; n],
            roots,
            points: points(tables),
            velocities: vec![Vec2::ZERO; n],
            mean: [0.0; WIDTH],
            factor: [0.0; WIDTH],
            rate_hz: tables.meta().rate_hz as f32,
        };
        for run in runs(tables) {
            for frame in run.clone() {
                db.run_ends[frame as usize] = run.end;
                db.all[frame as usize] = db.raw(tables, frame, &run);
                let [x, _, z] = db.all[frame as usize][Group::Hips.range()] else { unreachable!("three numbers") };
                db.velocities[frame as usize] = Vec2::new(x, z);
            }
        }
        db.normalise(weights);
        for frame in 0..n as u32 {
            if frame + LEAST_LEFT < db.run_ends[frame as usize] {
                db.frames.push(frame);
                db.rows.push(db.all[frame as usize]);
            }
        }
        db
    }

    /// Rows that a search may find.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Frame of a row, by its number (row < rows().len()).
    pub fn frame(&self, row: u32) -> u32 {
        self.frames[row as usize]
    }

    /// The features of a frame (frame exists).
    pub fn row_of(&self, frame: u32) -> &Row {
        &self.all[frame as usize]
    }

    /// Frames a second (Hz).
    pub fn rate_hz(&self) -> f32 {
        self.rate_hz
    }

    /// True where the next frame may be played after this one (frame exists).
    pub fn goes_on(&self, frame: u32) -> bool {
        frame + 1 < self.run_ends[frame as usize]
    }

    /// The next frame's planar root as seen from this one's ([`Self::goes_on`]).
    pub fn step(&self, frame: u32) -> Planar {
        self.roots[frame as usize].to_local(self.roots[frame as usize + 1])
    }

    /// How far hips, feet and fists of two frames are apart, mean: what is seen where one takes the other's place.
    /// (m, frames exist)
    pub fn gap(&self, a: u32, b: u32) -> f32 {
        let (a, b) = (&self.points[a as usize], &self.points[b as usize]);
        a.iter().zip(b).map(|(p, q)| p.distance(*q)).sum::<f32>() / a.len() as f32
    }

    /// The root's velocity at a frame, in its own frame: x, z (m/s, frame exists).
    pub fn velocity(&self, frame: u32) -> Vec2 {
        self.velocities[frame as usize]
    }

    /// Speed that a share of all usable frames stays below (m/s, 0 to 1).
    pub fn speed_quantile(&self, share: f32) -> f32 {
        let usable = (0..self.all.len()).filter(|&f| self.run_ends[f] > 0);
        let mut speeds: Vec<f32> = usable.map(|f| self.velocities[f].length()).collect();
        speeds.sort_by(f32::total_cmp);
        let at = (share * speeds.len().saturating_sub(1) as f32) as usize;
        speeds.get(at).copied().unwrap_or(0.0)
    }

    /// The row to look for: the pose of the frame that plays, and the goal.
    pub fn query(&self, frame: u32, goal: &MatchGoal) -> Row {
        let mut row = [0.0; WIDTH];
        let (path, facing) = goal.trajectory(self.velocity(frame));
        store(&mut row, Group::Path, &path.map(|p| [p.x, p.y]));
        store(&mut row, Group::Facing, &facing.map(|p| [p.x, p.y]));
        store_hit(&mut row, goal.hit);
        for k in 0..POSE.start {
            row[k] = (row[k] - self.mean[k]) * self.factor[k];
        }
        row[POSE].copy_from_slice(&self.all[frame as usize][POSE]);
        row
    }

    /// Features before they are normalised.
    fn raw(&self, tables: &Bundle, frame: u32, run: &Range<u32>) -> Row {
        let mut row = [0.0; WIDTH];
        let root = self.roots[frame as usize];
        let ahead = AHEAD_S.map(|s| {
            let at = (frame + (s * self.rate_hz).round() as u32).min(run.end - 1);
            root.to_local(self.roots[at as usize])
        });
        store(&mut row, Group::Path, &ahead.map(|p| [p.x, p.z]));
        store(&mut row, Group::Facing, &ahead.map(|p| [p.heading.sin(), p.heading.cos()]));
        store_hit(&mut row, self.next_hit(tables, frame, run));
        // Velocities over the frames before and after, one of them at the ends of a run.
        let (before, after) = (frame.saturating_sub(1).max(run.start), (frame + 1).min(run.end - 1));
        let duration = (after - before).max(1) as f32 / self.rate_hz;
        let seen = |f: u32| {
            let r = root.to_local(self.roots[f as usize]);
            self.points[f as usize].map(|p| r.translation() + r.rotation() * p)
        };
        let (from, to, now) = (seen(before), seen(after), self.points[frame as usize]);
        let velocity = |k: usize| ((to[k] - from[k]) / duration).to_array();
        let [_, left_foot, right_foot, left_fist, right_fist] = now.map(|p| p.to_array());
        store(&mut row, Group::Hips, &[velocity(0)]);
        store(&mut row, Group::Feet, &[left_foot, right_foot]);
        store(&mut row, Group::FeetVelocity, &[velocity(1), velocity(2)]);
        store(&mut row, Group::Fists, &[left_fist, right_fist]);
        store(&mut row, Group::FistsVelocity, &[velocity(3), velocity(4)]);
        row
    }

    /// Place, as seen from a frame, and time of the next effective hit of its run, if there is one within the horizon.
    fn next_hit(&self, tables: &Bundle, frame: u32, run: &Range<u32>) -> Option<(Vec3, f32)> {
        let hits = tables.hits();
        let hit = hits.get(hits.partition_point(|h| h.frame <= frame))?;
        let time = (hit.frame - frame) as f32 / self.rate_hz;
        if hit.frame >= run.end || time > HIT_HORIZON_S {
            return None;
        }
        let r = self.roots[frame as usize].to_local(self.roots[hit.frame as usize]);
        Some((r.translation() + r.rotation() * hit.position(), time))
    }

    /// Makes groups of features alike: each is divided by its usual spread and multiplied by its weight.
    fn normalise(&mut self, weights: &FeatureWeights) {
        for group in Group::ALL {
            let range = group.range();
            let counts = |f: &usize| {
                let has_hit = self.all[*f][Group::HitTime.range().start] < NO_HIT_S;
                self.run_ends[*f] > 0 && (has_hit || !group.is_of_hits())
            };
            let counted: Vec<usize> = (0..self.all.len()).filter(counts).collect();
            let n = counted.len().max(1) as f64;
            let mut spread = 0.0;
            for k in range.clone() {
                let mean = counted.iter().map(|&f| f64::from(self.all[f][k])).sum::<f64>() / n;
                let squares: f64 = counted.iter().map(|&f| (f64::from(self.all[f][k]) - mean).powi(2)).sum();
                self.mean[k] = mean as f32;
                spread += (squares / n).sqrt() / range.len() as f64;
            }
            // What never differs tells nothing.
            let factor = if spread > 1e-6 { weights.of(group) / spread as f32 } else { 0.0 };
            self.factor[range].fill(factor);
        }
        for (row, &end) in self.all.iter_mut().zip(&self.run_ends) {
            if end > 0 {
                for k in 0..WIDTH {
                    row[k] = (row[k] - self.mean[k]) * self.factor[k];
                }
            }
        }
    }
}

/// Puts the numbers of a group in their place.
fn store<const N: usize>(row: &mut Row, group: Group, parts: &[[f32; N]]) {
    row[group.range()].copy_from_slice(parts.as_flattened());
}

/// The hit's place and time, or what stands for none.
fn store_hit(row: &mut Row, hit: Option<(Vec3, f32)>) {
    let (place, time) = hit.unwrap_or((Vec3::ZERO, NO_HIT_S));
    store(row, Group::HitPlace, &[place.to_array()]);
    store(row, Group::HitTime, &[[time]]);
}

/// Hips, feet and fists of every frame.
fn points(tables: &Bundle) -> Vec<Points> {
    let motion_set = MotionSet::new(tables);
    let skeleton = tables.skeleton();
    let all: Vec<u32> = (0..tables.frames().len() as u32).collect();
    let (ratios, mut matrices) = (vec![0.0; BATCH], vec![Mat3x4::default(); BATCH * NUM_JOINTS]);
    let mut out = Vec::with_capacity(all.len());
    for frames in all.chunks(BATCH) {
        let matrices = &mut matrices[..frames.len() * NUM_JOINTS];
        let job = SampleJob { motion_set: &motion_set, frames, ratios: &ratios[..frames.len()], matrices };
        job.run().expect("frames exist and slices have one length");
        out.extend(matrices.chunks_exact(NUM_JOINTS).map(|pose| {
            let at = |j: Joint| pose[j.index()].translation();
            let fist = |j: Joint| striking_point(skeleton, j, at(j), pose[j.index()].rotation());
            [at(Joint::Hips), at(Joint::LeftFoot), at(Joint::RightFoot), fist(Joint::LeftHand), fist(Joint::RightHand)]
        }));
    }
    out
}
