//! Steering of a character with keys: by a policy, in a blend space, or on motion patches.

mod lag;

use super::Model;
use crate::command::{SteerCommand, SteerInput};
use crate::document::OpenDocument;
use crate::run::{RunInput, target_home};
use glam::Vec3;
pub use lag::Lags;
use lag::Twin;
use std::f32::consts::PI;
use throng_base::thresholds::{RUN_SPEED_MPS, WALK_SPEED_MPS};
use throng_core::{Mat3x4, NUM_JOINTS, Planar, blend::axis, planar::wrap_angle};
use throng_world::inhabitants::InhabitantGoal;

/// Distance of a policy's target ahead of the steered character, when walking and when running (m).
const AHEAD_M: [f32; 2] = [1.6, 4.5];
/// On patches, and how far from there one may stop (m).
const PATCH_AHEAD_M: [f32; 2] = [2.5, 5.0];
const PATCH_WITHIN_M: f32 = 5.0;
/// Interval between two orders on patches (frames).
const PATCH_EVERY: u32 = 30;
/// Threshold below which a target is not moved (m).
const SAME_M: f32 = 0.02;
/// Speeds for walking and running, limited by the blend space (m/s), and turning rate (rad/s).
const BLEND_MPS: [f32; 2] = [WALK_SPEED_MPS, RUN_SPEED_MPS];
const BLEND_TURN: f32 = 1.2;
/// Camera behind the steered character: half-life of its approach (s), its distance (m), the height that it looks at (m),
/// and its pitch (rad).
const BEHIND_HALF_LIFE_S: f32 = 0.5;
const BEHIND_M: f32 = 4.5;
const LOOK_AT_M: f32 = 1.1;
const PITCH: f32 = 0.24;

/// State of steering by the user.
#[derive(Clone, Default)]
pub struct UserSteering {
    /// Input that is held down.
    pub input: SteerInput,
    /// Delays from key presses to visible changes (frames).
    pub lags: Lags,
    twin: Option<Twin>,
    /// Frames since a place on patches was asked for.
    waited: u32,
}

impl Model {
    /// State of steering, while a character is steered.
    pub fn steering(&self) -> Option<&UserSteering> {
        self.steering.as_ref()
    }

    /// Why no character can be steered in the present view; none if one can.
    pub fn why_not_steered(&self) -> Option<&'static str> {
        match &self.document {
            _ if self.shows_clip() => Some("A clip is played as it is; show the crowd to steer somebody."),
            OpenDocument::World(_) => None,
            OpenDocument::Bundle(_) if self.shows_blend() => None,
            document => match document.scene().map(|s| s.run.simulation()) {
                Some(simulation) => target_home(simulation, self.selection.character.unwrap_or(0)).is_none().then_some(
                    "In scenes only who has a target of its own is steered; open its bundle or a world to steer others.",
                ),
                None => Some("Open a bundle with behaviours or a blend space, or a world, to steer somebody."),
            },
        }
    }

    /// Carries out a steering command.
    pub(super) fn apply_to_steering(&mut self, command: SteerCommand) {
        match command {
            SteerCommand::Toggle if self.steering.is_some() => self.steering = None,
            SteerCommand::Toggle => self.take_over(),
            SteerCommand::Hold(held) => self.hold(held),
            SteerCommand::Strike => {
                if let Err(why) = self.strike() {
                    self.say(why);
                }
            }
        }
    }

    fn take_over(&mut self) {
        if let Some(why) = self.why_not_steered() {
            return self.say(why);
        }
        if !self.shows_blend() && self.selection.character.is_none() {
            self.selection.character = Some(0);
        }
        self.steering = Some(UserSteering::default());
        self.settings.follow = true;
        let heading = self.steered_place().map_or(0.0, |s| s.1);
        let camera = &mut self.settings.camera;
        (camera.distance, camera.pitch, camera.target.y) = (BEHIND_M, PITCH, LOOK_AT_M);
        camera.yaw = wrap_angle(heading + PI);
        if let Some(head) = self.head_mut() {
            head.play(true);
        }
    }

    /// Position and heading of the steered character (m, rad).
    fn steered_place(&self) -> Option<(Vec3, f32)> {
        let root = match &self.document {
            OpenDocument::World(w) => *w.run.reel.moment().roots.get(self.selection.character?)?,
            OpenDocument::Bundle(b) if self.shows_blend() => *b.blend.as_ref()?.reel.moment().roots.first()?,
            document => document.scene()?.run.simulation().root(self.selection.character?)?,
        };
        Some((root.translation(), root.heading))
    }

    fn hold(&mut self, held: SteerInput) {
        let Some(before) = self.steering.as_ref().map(|s| s.input).filter(|h| *h != held) else { return };
        let twin = match (&self.document, self.selection.character) {
            (OpenDocument::Bundle(b), _) if self.shows_blend() => b.blend.as_ref().and_then(Twin::copy_blend),
            (document, Some(c)) => document.scene().and_then(|s| Twin::fork_scene(&s.run, c, before)),
            _ => None,
        };
        if let Some(s) = &mut self.steering {
            // A measurement under way is finished before a new one starts.
            s.twin = s.twin.take().or(twin);
            (s.input, s.waited) = (held, PATCH_EVERY);
        }
        if self.shows_blend() {
            self.blend_as(held);
        } else {
            self.send(held);
        }
    }

    /// Sends the steered character on its way, before the steps of a frame.
    pub(super) fn steer(&mut self) {
        let Some(held) = self.steering.as_ref().map(|s| s.input) else { return };
        if self.steered_place().is_none() || self.why_not_steered().is_some() {
            self.steering = None;
        } else if held.moves() {
            self.send(held);
        }
    }

    /// Sends the steered character in the direction of the keys, or lets it stay if no direction is held down.
    fn send(&mut self, held: SteerInput) {
        let Some((at, _)) = self.steered_place().filter(|_| !self.shows_blend()) else { return };
        let Some(character) = self.selection.character else { return };
        let direction = self.steer_direction(held).unwrap_or_default();
        if let OpenDocument::World(world) = &mut self.document {
            let Some(s) = &mut self.steering else { return };
            s.waited += 1;
            if s.waited >= PATCH_EVERY {
                s.waited = 0;
                let place = at + direction * distance_ahead(PATCH_AHEAD_M, held);
                let goal = Some(InhabitantGoal::GoNear { place, within_m: PATCH_WITHIN_M });
                // Where no place is near, at an edge of the world, it goes on as it did.
                _ = world.give_order(character, goal);
            }
        } else if let Some(scene) = self.document.scene_mut()
            && let Some(home) = target_home(scene.run.simulation(), character)
        {
            let to = (at + direction * distance_ahead(AHEAD_M, held)).with_y(home.y);
            if home.distance(to) > SAME_M {
                // A target that cannot be moved stays.
                _ = scene.run.input(RunInput::Target { character: Some(character), to });
            }
        }
    }

    /// Direction that is held down, in the world. Unit.
    fn steer_direction(&self, held: SteerInput) -> Option<Vec3> {
        let [right, _, back] = self.settings.camera.axes();
        let ahead = -back.with_y(0.0).normalize_or_zero();
        (ahead * held.ahead + right * held.aside).try_normalize()
    }

    /// Blends the walk that is held down: straight ahead and back by speed, aside by turning.
    fn blend_as(&mut self, held: SteerInput) {
        let Some((bundle, run)) = self.document.blend() else { return };
        let Ok(space) = bundle.blend(run.blending().space) else { return };
        let (mut wanted, ahead) = (*run.blending(), if held.ahead < 0.0 { -1.0 } else { 1.0 });
        for (p, a) in wanted.point.iter_mut().zip(space.axes()) {
            let asked = match a.kind {
                axis::SPEED if held.moves() => BLEND_MPS[usize::from(held.runs)] * ahead,
                axis::SPEED | axis::SIDE => 0.0,
                axis::GYRATION => -BLEND_TURN * held.aside,
                _ => continue,
            };
            *p = asked.clamp(a.low, a.high);
        }
        self.blend(wanted);
    }

    /// Lets the steered character play the blow nearest to its pose.
    fn strike(&mut self) -> Result<(), String> {
        let none = "No blow is there to strike with: build the bundle with `hits`, from clips with blows.";
        let Some(character) = self.selection.character.filter(|_| self.steering.is_some()) else { return Ok(()) };
        let scene = self.document.scene().zip(self.document.bundle()).filter(|s| !s.1.motion_set.hits().is_empty());
        let (scene, bundle) = scene.ok_or(none)?;
        let Some(pose) = scene.run.simulation().pose(character) else { return Ok(()) };
        let rows = bundle.row_poses();
        let apart = |segment: u32| {
            let row = bundle.tables().graph().segments[segment as usize].start as usize;
            let there = &rows[row * NUM_JOINTS..(row + 1) * NUM_JOINTS];
            pose.iter().zip(there).map(|(a, b)| a.translation().distance_squared(b.translation())).sum::<f32>()
        };
        let all = 0..bundle.tables().graph().segments.len() as u32;
        let blows = all.filter(|&s| !bundle.motion_set.hits_of(s).is_empty());
        let segment = blows.min_by(|&a, &b| apart(a).total_cmp(&apart(b))).ok_or(none)?;
        let input = RunInput::Play { character, segment };
        self.document.scene_mut().map_or(Ok(()), |scene| scene.run.input(input)).map_err(|e| e.to_string())
    }

    /// Measures, after the steps of a frame, and brings the camera behind.
    pub(super) fn update_steered(&mut self, steps: u32, wall_s: f32) {
        let Some(mut s) = self.steering.take() else { return };
        if let Some(mut twin) = s.twin.take_if(|_| steps > 0)
            && let Some(bundle) = self.document.bundle()
            && let Some(seen) = self.steered_pose()
        {
            let to = |held: SteerInput, at: Vec3| {
                self.steer_direction(held).map(|direction| at + direction * distance_ahead(AHEAD_M, held))
            };
            if twin.compare(bundle, steps, seen, to, &mut s.lags) {
                s.twin = Some(twin);
            }
        }
        if s.input.ahead >= 0.0
            && s.input.moves()
            && let Some((_, heading)) = self.steered_place()
        {
            let share = 1.0 - (-wall_s / BEHIND_HALF_LIFE_S).exp2();
            let yaw = &mut self.settings.camera.yaw;
            *yaw = wrap_angle(*yaw + wrap_angle(heading + PI - *yaw) * share);
        }
        self.steering = Some(s);
    }

    /// Root and joints of the steered character, of a scene or a blend.
    fn steered_pose(&self) -> Option<(Planar, &[Mat3x4])> {
        if let Some((_, blend)) = self.document.blend().filter(|_| self.shows_blend()) {
            let moment = blend.reel.moment();
            return Some((*moment.roots.first()?, moment.poses.get(..NUM_JOINTS)?));
        }
        let (simulation, c) = (self.document.scene()?.run.simulation(), self.selection.character?);
        Some((simulation.root(c)?, simulation.pose(c)?))
    }
}

fn distance_ahead([walks, runs]: [f32; 2], held: SteerInput) -> f32 {
    if held.runs { runs } else { walks }
}
