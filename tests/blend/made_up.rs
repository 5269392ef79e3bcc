//! Puppets that walk evenly on known arcs: every number of them is known at every time.

use glam::{Quat, Vec2, Vec3};
use std::collections::BTreeMap;
use std::f32::consts::TAU;
use throng_core::{Contacts, Joint, NUM_JOINTS, Planar, Skeleton};
use throng_precompute::clip::ClipTag;
use throng_precompute::error::BuildError;
use throng_precompute::examples::{self, BlendConfig, BlendSpaces};
use throng_precompute::progress::Silent;
use throng_precompute::{Clip, ClipSet};

/// Frames a second of the clips.
pub const RATE_HZ: f32 = 60.0;

/// A gait that repeats itself exactly.
#[derive(Clone, Debug)]
pub struct Puppet {
    pub name: &'static str,
    /// To the left, ahead (m/s).
    pub velocity: [f32; 2],
    /// Turning rate (rad/s).
    pub gyration: f32,
    /// Time of two steps (s).
    pub period: f32,
    /// Part of the cycle at which the right foot strikes.
    pub right: f32,
    /// Part of the cycle that a foot stands.
    pub duty: f32,
    /// How far legs and arms swing (rad).
    pub swing: f32,
    /// Length of the clip (s).
    pub seconds: f32,
}

impl Puppet {
    pub fn new(name: &'static str, ahead: f32, gyration: f32) -> Self {
        let velocity = [0.0, ahead];
        Self { name, velocity, gyration, period: 1.0, right: 0.5, duty: 0.6, swing: 0.4, seconds: 4.5 }
    }

    /// Where the facing frame is at a time; the left foot strikes first at a quarter of a cycle.
    pub fn frame(&self, t: f32) -> Planar {
        // Many small steps: no formula is shared with what is tested.
        let n = 2000;
        let (mut p, dt) = (Planar::new(1.0, -2.0, 0.3), t / n as f32);
        for _ in 0..n {
            let middle = p.heading + 0.5 * self.gyration * dt;
            let (s, c) = middle.sin_cos();
            let [left, ahead] = self.velocity;
            p = Planar::new(
                p.x + (c * left + s * ahead) * dt,
                p.z + (c * ahead - s * left) * dt,
                p.heading + self.gyration * dt,
            );
        }
        p
    }

    /// Part of the cycle, from the left foot's strike.
    pub fn phase(&self, t: f32) -> f32 {
        t / self.period - 0.25
    }

    /// Hips and joint rotations in the facing frame at a time; it turns and sways with its steps.
    pub fn pose(&self, t: f32) -> (Vec3, [Quat; NUM_JOINTS]) {
        let a = TAU * self.phase(t);
        let mut local = [Quat::IDENTITY; NUM_JOINTS];
        let mut turn = |j: Joint, angle: f32| local[j.index()] = Quat::from_rotation_x(angle);
        turn(Joint::LeftThigh, -self.swing * a.cos());
        turn(Joint::RightThigh, self.swing * a.cos());
        turn(Joint::LeftShin, 0.3 + 0.3 * a.sin());
        turn(Joint::RightShin, 0.3 - 0.3 * a.sin());
        turn(Joint::LeftUpperArm, self.swing * a.cos());
        turn(Joint::RightUpperArm, -self.swing * a.cos());
        local[0] = Quat::from_rotation_y(0.1 * a.sin()) * Quat::from_rotation_z(0.05 * a.cos());
        local[Joint::UpperChest.index()] = Quat::from_rotation_y(-0.2 * a.sin());
        (Vec3::new(0.02 * a.sin(), 0.9 + 0.02 * (2.0 * a).cos(), 0.01 * (2.0 * a).sin()), local)
    }

    pub fn contacts(&self, t: f32) -> Contacts {
        let mut out = Contacts::NONE;
        let phase = self.phase(t);
        if phase.rem_euclid(1.0) < self.duty {
            out.insert(Contacts::LEFT);
        }
        if (phase - self.right).rem_euclid(1.0) < self.duty {
            out.insert(Contacts::RIGHT);
        }
        out
    }

    pub fn clip(&self) -> Clip {
        let frames = (self.seconds * RATE_HZ) as usize;
        let mut clip = Clip {
            source: "made up".into(),
            tags: vec![ClipTag { name: "steady".into(), range: 0..frames }],
            ..Clip::new(self.name, f64::from(RATE_HZ), Vec::new(), Vec::new())
        };
        for f in 0..frames {
            let t = f as f32 / RATE_HZ;
            let (frame, (hips, mut local)) = (self.frame(t), self.pose(t));
            let ground = frame.transform_point(Vec2::new(hips.x, hips.z));
            local[0] = frame.rotation() * local[0];
            clip.root_positions.push(Vec3::new(ground.x, hips.y, ground.y));
            clip.rotations.extend(local);
            clip.contacts.push(self.contacts(t));
        }
        clip
    }
}

/// A character that stands and breathes.
pub fn idle() -> Clip {
    let mut clip = Puppet { period: 3.0, swing: 0.02, duty: 1.1, seconds: 7.0, ..Puppet::new("idle", 0.0, 0.0) }.clip();
    clip.contacts.iter_mut().for_each(|c| *c = Contacts(15));
    clip
}

pub fn set(clips: Vec<Clip>) -> ClipSet {
    ClipSet { skeleton: Skeleton::default(), clips }
}

/// A config as a file would have it.
pub fn config(text: &str) -> BlendConfig {
    toml::from_str(text).expect("a blend space")
}

/// The space `walk` of some clips.
pub fn fit(clips: Vec<Clip>, config: &BlendConfig) -> Result<BlendSpaces, BuildError> {
    examples::fit(&set(clips), &BTreeMap::from([("walk".to_owned(), config.clone())]), &Silent)
}

/// Two speeds and three turning rates, and standing.
pub fn six() -> Vec<Clip> {
    let mut clips: Vec<Clip> = [
        Puppet::new("slow", 0.8, 0.0),
        Puppet::new("slow_left", 0.8, 0.7),
        Puppet::new("fast", 1.6, 0.0),
        Puppet { period: 0.8, swing: 0.6, ..Puppet::new("fast_left", 1.6, 0.7) },
        Puppet { period: 0.9, ..Puppet::new("fast_right", 1.6, -0.7) },
    ]
    .iter()
    .map(Puppet::clip)
    .collect();
    clips.push(idle());
    clips
}

/// A space of speed and turning rate over [`six`].
pub const SIX: &str = "
    axes = [{ kind = 'speed' }, { kind = 'gyration' }]
    examples = [{ clip = 'slow*' }, { clip = 'fast*' }, { clip = 'idle', still = true }]
    phases = 32
";
