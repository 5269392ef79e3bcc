//! The list of a step: what happens to eight bodies between their motion and their matrices.

use super::gaze::{Eyes, Gaze};
use super::ground::HeightField;
use super::ground_plane::{BASE_HALF_LIFE_S, hips_ground_height};
use super::hierarchy::{ModelPose, to_model, write_locals, write_matrices};
use super::lane_body::LaneBody;
use super::lanes::{Lane, load};
use super::lanewise::Lanewise;
use super::matrix::{LocalTransform, Mat3x4};
use super::placement::PlacementLanes;
use super::reach::{HandReach, Hands};
use super::reaction::{Reaction, ReactionConfig, ReactionStep, any_lane_reacts, push, react_lanes};
use super::sample::LanePose;
use super::springs::DampedSpring;
use super::times::{Laps, StepPhase};
use crate::planar::Planar;
use crate::skeleton::{Joint, NUM_JOINTS};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::error::check_value;
use throng_base::simd::{LANES, Lanes};
use throng_base::{Id, Result};

/// What a body does beside its motion: a point that it looks at, and places that its palms reach for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyLayers {
    /// A point in the world that head and neck turn to, and the chest a little, while it lies within 70 degrees to the
    /// sides and 35 degrees up and down of where the body faces (m).
    pub look_at: Option<Vec3>,
    /// Targets of the left and the right hand.
    pub hands: [Option<HandReach>; 2],
}

impl BodyLayers {
    /// Checks all numbers.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for one that is not finite, or 1e6 and more.
    pub(crate) fn check(&self, who: Option<Id>) -> Result<()> {
        for got in self.look_at.unwrap_or_default().to_array() {
            check_value("look_at", who, got, got.abs() < 1e6, "a finite number below 1e6 (m)")?;
        }
        self.hands.iter().flatten().try_for_each(|reach| reach.check(who))
    }
}

/// State of eight bodies on which their next pose depends, whatever moves them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct BodyState {
    pub reaction: Reaction,
    pub gaze: [Gaze; LANES],
    /// Height of the ground that the hips are held over (m), and how fast it changes (m/s).
    pub base: Lane,
    pub base_rate: Lane,
    /// Distance by which the hips are lowered so that both legs reach (m), and how fast it changes (m/s).
    pub drop: Lane,
    pub drop_rate: Lane,
    /// 1 where the body has been posed before, else 0.
    pub seen: Lane,
}

impl BodyState {
    pub const ZERO: Self = Self {
        reaction: Reaction::ZERO,
        gaze: [Gaze::ZERO; LANES],
        base: [0.0; LANES],
        base_rate: [0.0; LANES],
        drop: [0.0; LANES],
        drop_rate: [0.0; LANES],
        seen: [0.0; LANES],
    };

    /// True where a lane has state that one that was never posed nor pushed lacks.
    pub fn is_used(&self, lane: usize) -> bool {
        self.seen[lane] != 0.0
            || self.reaction.active[lane] != 0.0
            || !self.gaze[lane].is_off()
            || self.base[lane] != 0.0
            || self.drop[lane] != 0.0
    }

    /// Displaces a part of the body of one lane, where bodies react.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a displacement that is not finite (m).
    pub fn push(
        &mut self,
        lane: usize,
        config: &ReactionConfig,
        who: Option<Id>,
        joint: Joint,
        displacement: Vec3,
    ) -> Result<()> {
        let largest = displacement.abs().max_element();
        let good = displacement.is_finite() && largest < 1e3;
        check_value("displacement", who, largest, good, "finite and below 1e3 (m)")?;
        if config.enabled {
            push(&mut self.reaction, lane, config, joint, displacement);
        }
        Ok(())
    }

    /// Moves the height that the hips are held over on.
    ///
    /// - `speed`: of each lane (m/s).
    pub fn follow_base(
        &mut self,
        ground: &HeightField,
        spring: &DampedSpring,
        root: impl Fn(usize) -> Planar,
        speed: &Lane,
    ) {
        if ground.is_flat() {
            (self.base, self.base_rate) = ([0.0; LANES], [0.0; LANES]);
            return;
        }
        for lane in 0..LANES {
            let wanted = hips_ground_height(ground, root(lane), speed[lane]);
            let (off, rate) = spring.pull_towards_zero(self.base[lane] - wanted, self.base_rate[lane]);
            (self.base[lane], self.base_rate[lane]) = match self.seen[lane] > 0.5 {
                true => (wanted + off, rate),
                false => (wanted, 0.0),
            };
        }
    }
}

impl Lanewise for BodyState {
    fn copy_lane(&mut self, lane: usize, from: &Self, from_lane: usize) {
        let Self { reaction, gaze, base, base_rate, drop, drop_rate, seen } = self;
        reaction.copy_lane(lane, &from.reaction, from_lane);
        gaze[lane] = from.gaze[from_lane];
        base.copy_lane(lane, &from.base, from_lane);
        base_rate.copy_lane(lane, &from.base_rate, from_lane);
        drop.copy_lane(lane, &from.drop, from_lane);
        drop_rate.copy_lane(lane, &from.drop_rate, from_lane);
        seen.copy_lane(lane, &from.seen, from_lane);
    }

    fn is_near(&self, lane: usize) -> bool {
        let Self { reaction, gaze, base, base_rate, drop, drop_rate, seen } = self;
        reaction.is_near(lane)
            && reaction.is_moderate(lane)
            && gaze[lane].is_sound()
            && [base, base_rate, drop, drop_rate, seen].iter().all(|of| of.is_near(lane))
    }
}

/// Inputs of a step that all bodies share.
pub(crate) struct BodyTick<'a> {
    pub ground: &'a HeightField,
    pub reaction: &'a ReactionConfig,
    /// Spring by which the hips follow the ground.
    pub base: DampedSpring,
    reaction_step: ReactionStep,
    eyes: Eyes,
}

impl<'a> BodyTick<'a> {
    pub fn new(ground: &'a HeightField, reaction: &'a ReactionConfig, dt_s: f32) -> Self {
        Self {
            ground,
            reaction,
            base: DampedSpring::new(dt_s, BASE_HALF_LIFE_S),
            reaction_step: ReactionStep::new(reaction, dt_s),
            eyes: Eyes::new(dt_s),
        }
    }
}

/// Layers of eight bodies.
pub(crate) struct LayerLanes {
    /// Points in model space that are looked at (m).
    look_at: [Option<Vec3>; LANES],
    /// How little the chest may turn, 0 to 1: what the arms do is meant to be where it is.
    still: Lane,
    hands: Option<Hands>,
}

impl LayerLanes {
    /// The layers of the characters of a block.
    ///
    /// - `root`: planar root of a lane.
    /// - `ground`: height of the ground below the hips (m).
    pub fn new(
        layers: impl Iterator<Item = BodyLayers> + Clone,
        still: Lane,
        root: impl Fn(usize) -> Planar,
        ground: &Lane,
    ) -> Self {
        let mut look_at = [None; LANES];
        for (lane, layers) in layers.clone().enumerate() {
            look_at[lane] = layers.look_at.map(|point| {
                let flat = root(lane).inverse_transform_point(Vec2::new(point.x, point.z));
                Vec3::new(flat.x, point.y, flat.y)
            });
        }
        let hands = Hands::from_orders(layers.map(|layers| layers.hands), root, ground);
        Self { look_at, still, hands }
    }

    /// Distance by which hips sink so that hands reach low targets; none where no hand reaches (m).
    #[inline(always)]
    pub fn hips_sink<F: Lanes>(&self, body: &LaneBody, pose: &ModelPose<F>) -> Option<F> {
        self.hands.as_ref().map(|hands| hands.hips_sink(body, pose))
    }
}

/// Outputs of a block.
pub(crate) struct PoseOutput<'a> {
    /// (characters * NUM_JOINTS)
    pub matrices: &'a mut [Mat3x4],
    /// (characters * NUM_JOINTS, or 0)
    pub locals: &'a mut [LocalTransform],
}

/// Puts the feet of eight bodies where they belong. A trait and no closure: those are compiled without the processor's vectors.
pub(crate) trait PlantFeet<F: Lanes> {
    fn plant(&mut self, layers: &LayerLanes, place: &PlacementLanes<F>, state: &mut BodyState, pose: &mut ModelPose<F>);
}

/// Poses a block from what its motion is, transitions included: gaze -> reactions -> feet -> reach -> write.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "what the list has from each of its callers")]
pub(crate) fn pose_block<F: Lanes>(
    body: &LaneBody,
    mut motion: LanePose<F>,
    place: &PlacementLanes<F>,
    layers: &LayerLanes,
    tick: &BodyTick<'_>,
    state: &mut BodyState,
    feet: &mut impl PlantFeet<F>,
    to: PoseOutput<'_>,
    laps: &mut Laps<'_>,
) {
    for (lane, gaze) in state.gaze.iter_mut().enumerate() {
        if layers.look_at[lane].is_some() || !gaze.is_off() {
            gaze.turn_pose(&tick.eyes, layers.look_at[lane], body, lane, layers.still[lane], &mut motion);
        }
    }
    let mut pose = to_model(|j| load(&body.offsets[j]), motion);
    laps.end(StepPhase::Sample);
    if tick.reaction.enabled && any_lane_reacts::<F>(&state.reaction) {
        react_lanes(body, tick.reaction, &tick.reaction_step, place, &mut state.reaction, &mut pose);
    }
    laps.end(StepPhase::Reaction);
    feet.plant(layers, place, state, &mut pose);
    state.seen = [1.0; LANES];
    laps.end(StepPhase::FootLock);
    if let Some(hands) = &layers.hands {
        hands.reach_places(body, &mut pose);
    }
    write_matrices(&pose, to.matrices);
    if !to.locals.is_empty() {
        write_locals(|j| load(&body.offsets[j]), &pose, to.locals.len() / NUM_JOINTS, to.locals);
    }
    laps.end(StepPhase::Poses);
}
