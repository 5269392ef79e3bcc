//! The list of a step: what happens to eight bodies between their motion and their matrices.

use super::arms::{ArmLayer, layer_arms};
use super::events::{ClipRows, FootSwing};
use super::ground_plane::{BASE_HALF_LIFE_S, hips_ground_height};
use super::hierarchy::{ModelPose, write_locals, write_matrices};
use super::lane_body::{LEGS, LaneBody};
use super::lanes::{Lane, load};
use super::matrix::{LocalTransform, Mat3x4};
use super::reaction::{Reaction, ReactionConfig, ReactionStep, any_lane_reacts, push, react_lanes};
use super::upper::{BodyLayers, LayerStates, LayerTick};
use super::{gaze::Gaze, ground::HeightField, reach::Hands, sample::LanePose, touch::BlockTouch};
use super::{lanewise::lanewise_fields, placement::PlacementLanes, springs::DampedSpring};
use crate::planar::Planar;
use crate::skeleton::{Joint, NUM_JOINTS};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use throng_base::simd::{LANES, Lanes, V};
use throng_base::{Id, Result, error::check_value};

/// State of eight bodies on which their next pose depends, whatever moves them.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, Zeroable)]
#[repr(C)]
pub(crate) struct BodyState {
    pub reaction: Reaction,
    pub gaze: [Gaze; LANES],
    pub layers: LayerStates,
    pub swing: FootSwing,
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
        layers: LayerStates::ZERO,
        swing: FootSwing::ZERO,
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
            || self.layers.active[lane] != 0.0
            || self.base[lane] != 0.0
            || self.drop[lane] != 0.0
    }

    /// Displaces a part of the body of one lane, where bodies react.
    ///
    /// # Errors
    /// [`throng_base::Error::Value`] for a displacement that is not finite (m).
    pub fn push(&mut self, lane: usize, cfg: &ReactionConfig, who: Option<Id>, joint: Joint, by: Vec3) -> Result<()> {
        let largest = by.abs().max_element();
        let good = by.is_finite() && largest < 1e3;
        check_value("displacement", who, largest, good, "finite and below 1e3 (m)")?;
        if cfg.enabled {
            push(&mut self.reaction, lane, cfg, joint, by);
        }
        Ok(())
    }

    /// Moves the height that the hips are held over on.
    ///
    /// - `speed`: of each lane (m/s).
    /// - `near`: height of each lane to which its floor is the nearest one (m).
    pub fn follow_base(
        &mut self,
        ground: &HeightField,
        spring: &DampedSpring,
        root: impl Fn(usize) -> Planar,
        speed: &Lane,
        near: &Lane,
    ) {
        if ground.is_flat() {
            (self.base, self.base_rate) = ([0.0; LANES], [0.0; LANES]);
            return;
        }
        for lane in 0..LANES {
            let wanted = hips_ground_height(ground, root(lane), speed[lane], near[lane]);
            let (off, rate) = spring.pull_towards_zero(self.base[lane] - wanted, self.base_rate[lane]);
            (self.base[lane], self.base_rate[lane]) = match self.seen[lane] > 0.5 {
                true => (wanted + off, rate),
                false => (wanted, 0.0),
            };
        }
    }
}

lanewise_fields!(BodyState { reaction, gaze, layers, swing, base, base_rate, drop, drop_rate, seen });

/// Inputs of a step that all bodies share.
pub(crate) struct BodyTick<'a> {
    pub ground: &'a HeightField,
    pub reaction: &'a ReactionConfig,
    /// Spring by which the hips follow the ground.
    pub base: DampedSpring,
    reaction_step: ReactionStep,
    layers: LayerTick<'a>,
}

impl<'a> BodyTick<'a> {
    /// - `rows`: frames that layers may show.
    pub fn new(ground: &'a HeightField, reaction: &'a ReactionConfig, rows: &'a ClipRows, dt_s: f32) -> Self {
        let (base, layers) = (DampedSpring::new(dt_s, BASE_HALF_LIFE_S), LayerTick::new(rows, dt_s));
        Self { ground, reaction, base, reaction_step: ReactionStep::new(reaction, dt_s), layers }
    }
}

/// Layers of eight bodies.
pub(crate) struct LayerLanes<'t> {
    /// Places that are looked at and pointed at are in model space; none where nobody has any layer.
    layers: Option<[BodyLayers; LANES]>,
    /// How little the chest may turn, 0 to 1: what the arms do is meant to be where it is.
    still: Lane,
    hands: Option<Hands>,
    /// Limbs that stop at a partner's body.
    pub touch: Option<BlockTouch<'t>>,
}

impl LayerLanes<'_> {
    /// The layers of the characters of a block.
    ///
    /// - `root`: planar root of a lane.
    /// - `ground`: height of the ground below the hips (m).
    pub fn new<'a>(
        orders: impl Iterator<Item = &'a BodyLayers> + Clone,
        still: Lane,
        root: impl Fn(usize) -> Planar,
        ground: &Lane,
    ) -> Self {
        if orders.clone().all(BodyLayers::is_none) {
            return Self { layers: None, still, hands: None, touch: None };
        }
        let to_model = |lane: usize, point: Vec3| {
            let flat = root(lane).inverse_transform_point(Vec2::new(point.x, point.z));
            Vec3::new(flat.x, point.y, flat.y)
        };
        let mut layers = [BodyLayers::NONE; LANES];
        for (lane, order) in orders.clone().enumerate() {
            layers[lane] = BodyLayers { look_at: order.look_at.map(|point| to_model(lane, point)), ..*order };
            for arm in layers[lane].arms.iter_mut().flatten() {
                if let ArmLayer::Point(at) = arm {
                    *at = to_model(lane, *at);
                }
            }
        }
        let hands = Hands::from_orders(orders.map(|layers| layers.arms), root, ground);
        Self { layers: Some(layers), still, hands, touch: None }
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
    fn plant(&mut self, layers: &LayerLanes<'_>, at: &PlacementLanes<F>, own: &mut BodyState, pose: &mut ModelPose<F>);
}

/// Poses a block from what its motion is, transitions included: clips -> gaze -> reactions -> feet -> reach -> arms -> touch ->
/// write.
/// Returns where the balls of the feet are in the world (left, right).
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "what the list has from each of its callers")]
pub(crate) fn pose_block<F: Lanes>(
    body: &LaneBody,
    motion: &mut LanePose<F>,
    place: &PlacementLanes<F>,
    layers: &mut LayerLanes<'_>,
    tick: &BodyTick<'_>,
    state: &mut BodyState,
    feet: &mut impl PlantFeet<F>,
    to: PoseOutput<'_>,
) -> [V<F>; 2] {
    let orders = layers.layers.as_ref().unwrap_or(&const { [BodyLayers::NONE; LANES] });
    let is_ordered = layers.layers.is_some();
    let shows =
        F::load(&state.layers.active).any_gt(F::splat(0.5)) || is_ordered && !orders.iter().all(BodyLayers::is_plain);
    if shows {
        for (lane, (layers, order)) in state.layers.lanes.iter_mut().zip(orders).enumerate() {
            layers.turn_trunk(&tick.layers, order, lane, motion);
        }
    }
    if is_ordered || !state.gaze.iter().all(Gaze::is_off) {
        for (lane, (gaze, order)) in state.gaze.iter_mut().zip(orders).enumerate() {
            if order.look_at.is_some() || !gaze.is_off() {
                gaze.turn_pose(&tick.layers, order.look_at, body, lane, layers.still[lane], motion);
            }
        }
    }
    let mut pose = ModelPose::unposed(F::splat(0.0));
    pose.set_local(|j| load(&body.offsets[j]), motion);
    if tick.reaction.enabled && any_lane_reacts::<F>(&state.reaction) {
        react_lanes(body, tick.reaction, &tick.reaction_step, place, &mut state.reaction, &mut pose);
    }
    feet.plant(layers, place, state, &mut pose);
    state.seen = [1.0; LANES];
    if let Some(hands) = &layers.hands {
        hands.reach_places(body, &mut pose);
    }
    if shows {
        layer_arms(body, &tick.layers, orders, &mut state.layers, &mut pose);
    }
    if let Some(touch) = &mut layers.touch {
        touch.stop_limbs(place, &mut pose);
    }
    write_matrices(&pose, to.matrices);
    if !to.locals.is_empty() {
        write_locals(|j| load(&body.offsets[j]), &pose, to.locals.len() / NUM_JOINTS, to.locals);
    }
    // No closure: those are compiled without the processor's vectors.
    let [left, right] = [LEGS[0][3].index(), LEGS[1][3].index()];
    [place.to_world(pose.positions[left]), place.to_world(pose.positions[right])]
}
