//! Going on with another bundle.

use super::block::{ROTATION_CODES, encode};
use super::policy_characters::{PolicyCharacters, no_graph};
use super::{CharacterStart, Characters, SampleJob, motion_set::MotionSet, segments_into_states};
use crate::body::{Mat3x4, PARENTS, hips_ground_height, set_lane};
use crate::{bundle::Bundle, character_group::AdoptReport, skeleton::NUM_JOINTS};
use glam::{Quat, Vec3};
use throng_base::{Result, error::ensure, maths, simd::LANES};

/// Gives every character the state of the new bundle with the nearest pose; the difference of the poses decays as after
/// a transition. Nothing has changed after an error.
pub(super) fn adopt(group: &mut PolicyCharacters, new: &Bundle) -> Result<AdoptReport> {
    let motion_set = MotionSet::new(new);
    let names = &group.bundle.meta().behaviours;
    let number = |policy: u32| Ok(new.find_policy(&names[policy as usize])? as u32);
    let orders = group.orders.iter().map(|o| o.with_policy_numbers(number)).collect::<Result<Vec<_>>>()?;
    orders.iter().try_for_each(|o| motion_set.manners.check(o.manner))?;
    ensure(!motion_set.graph().states.is_empty(), no_graph)?;
    let poses = state_poses(&motion_set);
    let arrivals = segments_into_states(&motion_set);
    let mut characters = Characters::with_capacity(&motion_set, group.characters.config, group.capacity())?;
    let mut out = AdoptReport { num_characters: group.characters.num_characters(), farthest_m: 0.0 };
    for at in 0..out.num_characters {
        let old = &group.characters;
        let root = old.root(at);
        // Poses of states stand on flat ground.
        let floor_m = old.blocks[at / LANES].floor[at % LANES];
        let height = hips_ground_height(&old.ground, root, 0.0, floor_m);
        let shown = old.last_pose(at).map(|pose| {
            let mut pose = *pose;
            pose.iter_mut().for_each(|joint| joint.rows[1][3] -= height);
            pose
        });
        let (state, farthest_m) = nearest_state(shown.as_ref(), &poses);
        out.farthest_m = out.farthest_m.max(farthest_m);
        let name = old.blocks[at / LANES].name[at % LANES];
        characters.add_character(&motion_set, CharacterStart { root, state: state as u32 }, &arrivals, name);
        characters.set_floor(at, floor_m);
        characters.carry_over(old, at);
        if let Some(shown) = &shown {
            ease_to_pose(&mut characters, at, shown, &poses[state]);
        }
    }
    characters.copy_surroundings(&group.characters);
    characters.detail = group.characters.detail;
    characters.ground = group.characters.ground.clone();
    characters.reserve_all(&motion_set);
    group.bundle = new.clone();
    group.motion_set = motion_set;
    group.arrivals = arrivals;
    group.characters = characters;
    group.orders.clone_from(&orders);
    group.obeyed.clone_from(&orders);
    Ok(out)
}

/// Poses of all states (num_states).
fn state_poses(motion_set: &MotionSet) -> Vec<[Mat3x4; NUM_JOINTS]> {
    let frames: Vec<u32> = motion_set.graph().states.iter().map(|s| s.frame).collect();
    let mut poses = vec![[Mat3x4::default(); NUM_JOINTS]; frames.len()];
    let matrices = poses.as_flattened_mut();
    let job = SampleJob { motion_set, frames: &frames, ratios: &vec![0.0; frames.len()], matrices };
    job.run().unwrap_or_else(|e| unreachable!("frames of states exist: {e}"));
    poses
}

/// State whose joints are nearest to a pose, and the largest distance of a joint (m); without a pose, the first state.
fn nearest_state(shown: Option<&[Mat3x4; NUM_JOINTS]>, poses: &[[Mat3x4; NUM_JOINTS]]) -> (usize, f32) {
    let Some(shown) = shown else { return (0, 0.0) };
    let squares = |pose: &[Mat3x4; NUM_JOINTS]| -> [f32; NUM_JOINTS] {
        std::array::from_fn(|j| pose[j].translation().distance_squared(shown[j].translation()))
    };
    let distance = |pose| squares(pose).iter().sum::<f32>();
    let state = (0..poses.len()).min_by(|&a, &b| distance(&poses[a]).total_cmp(&distance(&poses[b]))).unwrap_or(0);
    (state, squares(&poses[state]).into_iter().fold(0.0, f32::max).sqrt())
}

/// Stores the difference between the visible pose and the new one as offsets, which decay.
fn ease_to_pose(characters: &mut Characters, at: usize, shown: &[Mat3x4; NUM_JOINTS], pose: &[Mat3x4; NUM_JOINTS]) {
    let (block, body, lane) = characters.lane_mut(at);
    body.awake = 1;
    let local = |pose: &[Mat3x4; NUM_JOINTS], j: usize| match j {
        0 => pose[0].rotation(),
        _ => maths::compose(pose[PARENTS[j]].rotation().conjugate(), pose[j].rotation()),
    };
    for j in 0..NUM_JOINTS {
        let offset = maths::normalize_or_identity(maths::compose(local(shown, j), local(pose, j).conjugate()));
        encode(&mut body.offsets.rotation[j], lane, ROTATION_CODES, parameters(offset));
        encode(&mut body.offsets.rotation_velocity[j], lane, 1.0, Vec3::ZERO);
    }
    set_lane(&mut body.offsets.root, lane, shown[0].translation() - pose[0].translation());
    set_lane(&mut body.offsets.root_velocity, lane, Vec3::ZERO);
    block.age_s[lane] = 0.0;
}

/// Modified Rodrigues parameters of the shorter of the two turns that a quaternion stands for.
fn parameters(q: Quat) -> Vec3 {
    let q = if q.w < 0.0 { -q } else { q };
    Vec3::new(q.x, q.y, q.z) / (1.0 + q.w)
}
