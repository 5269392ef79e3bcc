//! A take: motion of several characters on one time line. It is kept in a file, so that length costs no memory.

use super::scratch::TrackScratch;
use crate::clip::Clip;
use glam::{Quat, Vec3};
use std::{io, path::Path};
use throng_base::maths;
use throng_core::{Joint, Mat3x4, NUM_JOINTS, Planar, Skeleton};

/// Distance below which two rest positions of a joint are the same: eight of them in a chain stay below 0.1 mm (m).
const SAME_PLACE_M: f32 = 5e-6;
const NUMBERS: usize = 7 * NUM_JOINTS + 1;
/// The track of the character's presence.
pub const PRESENCE_TRACK: usize = 2 * NUM_JOINTS;

/// The track of a joint's rotations, x, y, z, w.
pub const fn rotation_track(joint: usize) -> usize {
    joint
}

/// The track of a joint's translations (m).
pub const fn translation_track(joint: usize) -> usize {
    NUM_JOINTS + joint
}

/// A pose: every joint relative to its parent, the hips in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActorPose {
    /// (m, NUM_JOINTS)
    pub translations: [Vec3; NUM_JOINTS],
    /// Unit (NUM_JOINTS).
    pub rotations: [Quat; NUM_JOINTS],
}

impl ActorPose {
    /// A pose of joints in model space, which the root places in the world.
    pub fn from_model(root: Planar, model: &[Mat3x4; NUM_JOINTS]) -> Self {
        let turned: [Quat; NUM_JOINTS] = std::array::from_fn(|j| model[j].rotation().normalize());
        let (mut translations, mut rotations) = ([Vec3::ZERO; NUM_JOINTS], turned);
        for j in Joint::ALL {
            let i = j.index();
            let parent = j.parent().map(Joint::index);
            let to_parent = parent.map_or(root.rotation(), |p| turned[p].inverse());
            rotations[i] = maths::compose(to_parent, turned[i]).normalize();
            translations[i] = match parent {
                None => to_parent * model[i].translation() + root.translation(),
                Some(p) => to_parent * (model[i].translation() - model[p].translation()),
            };
        }
        Self { translations, rotations }
    }

    /// A pose of a skeleton whose joints only turn.
    ///
    /// - `root_position`: position of the hips (m).
    pub fn from_rotations(skeleton: &Skeleton, root_position: Vec3, rotations: [Quat; NUM_JOINTS]) -> Self {
        let mut translations = skeleton.offsets;
        translations[0] = root_position;
        Self { translations, rotations }
    }

    /// Position and rotation of all joints in the world.
    pub fn world_transforms(&self) -> [(Vec3, Quat); NUM_JOINTS] {
        let mut out = [(self.translations[0], self.rotations[0]); NUM_JOINTS];
        for j in &Joint::ALL[1..] {
            let (p, r) = out[j.parent().map_or(0, Joint::index)];
            let i = j.index();
            out[i] = (p + r * self.translations[i], maths::compose(r, self.rotations[i]).normalize());
        }
        out
    }

    /// Interpolation from `self` at ratio 0 to `other` at ratio 1.
    pub fn lerp(&self, other: &Self, ratio: f32) -> Self {
        Self {
            translations: std::array::from_fn(|j| self.translations[j].lerp(other.translations[j], ratio)),
            rotations: std::array::from_fn(|j| maths::slerp_f32(self.rotations[j], other.rotations[j], ratio)),
        }
    }

    fn numbers(&self, is_there: bool) -> [f32; NUMBERS] {
        let mut out = [0.0; NUMBERS];
        for j in 0..NUM_JOINTS {
            out[4 * j..4 * j + 4].copy_from_slice(&self.rotations[j].to_array());
            let at = 4 * NUM_JOINTS + 3 * j;
            out[at..at + 3].copy_from_slice(&self.translations[j].to_array());
        }
        out[NUMBERS - 1] = f32::from(u8::from(is_there));
        out
    }

    fn from_numbers(n: &[f32]) -> Self {
        Self {
            rotations: std::array::from_fn(|j| Quat::from_slice(&n[4 * j..4 * j + 4])),
            translations: std::array::from_fn(|j| Vec3::from_slice(&n[4 * NUM_JOINTS + 3 * j..][..3])),
        }
    }
}

/// A character of a take.
#[derive(Clone, Debug)]
pub struct TakeActor {
    /// Name, unique in the take.
    pub name: String,
    /// Number in the source.
    pub number: usize,
    /// Rest offsets that its joints keep.
    pub skeleton: Skeleton,
    /// Joints that leave their rest offsets, the hips among them (NUM_JOINTS).
    pub moves: [bool; NUM_JOINTS],
    /// Frames from the first to past the last one in which it is present; it may be absent in between.
    pub present_frames: std::ops::Range<usize>,
    /// True where it is absent in any frame.
    pub is_ever_away: bool,
}

/// Motion of several characters, frame by frame.
pub struct Take {
    actors: Vec<TakeActor>,
    rate_hz: f64,
    scratch: TrackScratch,
    /// True where actors are one figure that plays one after the other, as the clips of a bundle do.
    is_library: bool,
}

/// Records a take.
pub struct TakeWriter {
    take: Take,
    before: Vec<Option<ActorPose>>,
}

impl TakeWriter {
    /// A take of characters who are recorded at the same time.
    ///
    /// - `folder`: folder of the file of the frames, which has no name and is removed with the program.
    /// - `actors`: numbers, names and skeletons.
    ///
    /// # Errors
    /// Errors of a folder that takes no file.
    pub fn new(folder: &Path, actors: Vec<(usize, String, Skeleton)>, rate_hz: f64) -> io::Result<Self> {
        Self::with_layout(folder, actors, rate_hz, false)
    }

    /// A take of clips of one figure, which are recorded one after the other and ended by [`TakeWriter::finish`].
    ///
    /// # Errors
    /// Errors of [`TakeWriter::new`].
    pub fn library(folder: &Path, clips: Vec<(usize, String, Skeleton)>, rate_hz: f64) -> io::Result<Self> {
        Self::with_layout(folder, clips, rate_hz, true)
    }

    fn with_layout(
        folder: &Path,
        actors: Vec<(usize, String, Skeleton)>,
        rate_hz: f64,
        is_library: bool,
    ) -> io::Result<Self> {
        let together = if is_library { 1 } else { actors.len() };
        // Rotations, translations and the presence.
        let widths: Vec<usize> = [vec![4; NUM_JOINTS], vec![3; NUM_JOINTS], vec![1]].concat();
        let scratch = TrackScratch::new(folder, actors.len(), &widths, together)?;
        let actor = |(number, name, skeleton)| {
            let mut moves = [false; NUM_JOINTS];
            moves[0] = true;
            TakeActor { name, number, skeleton, moves, present_frames: 0..0, is_ever_away: false }
        };
        let before = vec![None; actors.len()];
        let take = Take { actors: actors.into_iter().map(actor).collect(), rate_hz, scratch, is_library };
        Ok(Self { take, before })
    }

    /// Adds a frame of an actor; `None` where it is absent.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn push(&mut self, actor: usize, pose: Option<ActorPose>) -> io::Result<()> {
        let Self { take, before } = self;
        let frame = take.scratch.num_frames(actor);
        let who = &mut take.actors[actor];
        who.is_ever_away |= pose.is_none();
        let Some(mut pose) = pose else {
            // An absent actor keeps its last pose.
            let kept = before[actor].unwrap_or_else(|| {
                ActorPose::from_rotations(&who.skeleton, who.skeleton.offsets[0], [Quat::IDENTITY; NUM_JOINTS])
            });
            return take.scratch.push(actor, &kept.numbers(false));
        };
        match &before[actor] {
            None => who.adopt_offsets(&pose, frame),
            Some(before) => {
                for (now, then) in pose.rotations.iter_mut().zip(&before.rotations) {
                    *now = if now.dot(*then) < 0.0 { -*now } else { *now };
                }
            }
        }
        who.present_frames.end = frame + 1;
        for j in 1..NUM_JOINTS {
            who.moves[j] |= pose.translations[j].distance(who.skeleton.offsets[j]) > SAME_PLACE_M;
        }
        before[actor] = Some(pose);
        take.scratch.push(actor, &pose.numbers(true))
    }

    /// Ends an actor, which frees its memory.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn finish(&mut self, actor: usize) -> io::Result<()> {
        self.take.scratch.finish(actor)
    }

    /// The whole take.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn into_take(mut self) -> io::Result<Take> {
        (0..self.take.actors.len()).try_for_each(|a| self.finish(a))?;
        Ok(self.take)
    }
}

impl TakeActor {
    /// Adopts the offsets of the first pose: bodies may be fitted to skeletons of their own.
    fn adopt_offsets(&mut self, pose: &ActorPose, frame: usize) {
        self.present_frames = frame..frame + 1;
        let before = self.skeleton.clone();
        for j in 1..NUM_JOINTS {
            let offset = &mut self.skeleton.offsets[j];
            if pose.translations[j].distance(*offset) > SAME_PLACE_M {
                *offset = pose.translations[j];
            }
        }
        if self.skeleton == before {
            return;
        }
        // Feet stand as far above the ground as those of a body of that height do.
        let taller = self.skeleton.leg_length() / before.leg_length().max(SAME_PLACE_M);
        self.skeleton.tips.iter_mut().for_each(|tip| *tip *= taller);
        let toes = |s: &Skeleton| s.rest_positions()[Joint::LeftToe.index()].y;
        self.skeleton.offsets[0].y += taller * toes(&before) - toes(&self.skeleton);
    }
}

impl Take {
    /// Clips of one set, one after the other.
    ///
    /// # Errors
    /// Errors of the disk.
    pub fn from_clips(folder: &Path, clips: &[Clip], skeleton: &Skeleton) -> io::Result<Self> {
        let actors = clips.iter().enumerate().map(|(i, c)| (i, c.name.clone(), skeleton.clone())).collect();
        let mut writer = TakeWriter::library(folder, actors, clips.first().map_or(30.0, |c| c.rate_hz))?;
        for (i, clip) in clips.iter().enumerate() {
            for frame in 0..clip.num_frames() {
                let rotations = clip.frame_rotations(frame);
                let rotations = std::array::from_fn(|j| rotations[j]);
                writer.push(i, Some(ActorPose::from_rotations(skeleton, clip.root_positions[frame], rotations)))?;
            }
            writer.finish(i)?;
        }
        writer.into_take()
    }

    /// The characters of the take.
    pub fn actors(&self) -> &[TakeActor] {
        &self.actors
    }

    /// Frames a second (Hz).
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// True where actors are clips of one figure, each with a length of its own, rather than characters at the same time.
    pub fn is_library(&self) -> bool {
        self.is_library
    }

    /// Number of frames of an actor (actor < number of actors).
    pub fn num_frames(&self, actor: usize) -> usize {
        self.scratch.num_frames(actor)
    }

    /// Number of frames of the longest.
    pub fn longest(&self) -> usize {
        (0..self.actors.len()).map(|a| self.num_frames(a)).max().unwrap_or(0)
    }

    /// Passes every frame of an actor to `take`: its number, the pose, and whether the actor is present; absent, it keeps its
    /// pose.
    ///
    /// # Errors
    /// Errors of the disk, and of `take`.
    pub fn poses(&self, who: usize, mut take: impl FnMut(usize, &ActorPose, bool) -> io::Result<()>) -> io::Result<()> {
        self.scratch.frames(who, |frame, n| take(frame, &ActorPose::from_numbers(n), n[NUMBERS - 1] > 0.5))
    }

    /// The numbers as they are kept, track by track.
    pub(crate) fn scratch(&self) -> &TrackScratch {
        &self.scratch
    }
}
