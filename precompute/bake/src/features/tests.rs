//! The distance against a naive one in double precision.

use super::*;
use glam::{DQuat, DVec3, Vec2};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use throng_core::Skeleton;
use throng_motion::clip::{Exclusion, ExclusionReason};

/// A clip of unrelated tame poses: every joint within about 1.5 rad of rest, the root anywhere.
fn random_clip(seed: u64, num_frames: usize) -> Clip {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut vector = |size: f32| Vec3::from_array([0; 3].map(|_| rng.random_range(-size..size)));
    let mut rotations = Vec::new();
    let mut root_positions = Vec::new();
    for _ in 0..num_frames {
        root_positions.push(vector(2.0));
        rotations.extend((0..NUM_JOINTS).map(|_| Quat::from_scaled_axis(vector(0.9))));
    }
    Clip::new(format!("random {seed}"), 30.0, root_positions, rotations)
}

fn moved(clip: &Clip, by: Planar) -> Clip {
    let mut out = clip.clone();
    for f in 0..clip.num_frames() {
        let p = clip.root_positions[f];
        let g = by.transform_point(Vec2::new(p.x, p.z));
        out.root_positions[f] = Vec3::new(g.x, p.y, g.y);
        out.rotations[f * NUM_JOINTS] = by.rotation() * clip.rotations[f * NUM_JOINTS];
    }
    out
}

fn set(clips: Vec<Clip>) -> ClipSet {
    ClipSet { skeleton: Skeleton::default(), clips }
}

/// Rotation vector of the shorter way round, by acos.
fn log(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let axis = DVec3::new(q.x, q.y, q.z);
    if axis.length() < 1e-12 { DVec3::ZERO } else { axis.normalize() * 2.0 * q.w.min(1.0).acos() }
}

/// The root's orientation distance as Lee, Choi and Lee (2006) state it: the least angle over turns about the vertical, by search.
fn least_angle_over_turns(a: DQuat, b: DQuat) -> f64 {
    let angle = |t: f64| log((DQuat::from_rotation_y(t) * a).inverse() * b).length();
    let mut best = (0..720)
        .map(|k| f64::from(k) * std::f64::consts::PI / 360.0)
        .min_by(|s, t| angle(*s).total_cmp(&angle(*t)))
        .unwrap();
    let mut step = 0.01;
    while step > 1e-9 {
        best = [best - step, best, best + step].into_iter().min_by(|s, t| angle(*s).total_cmp(&angle(*t))).unwrap();
        step *= 0.7;
    }
    angle(best)
}

/// Everything of one frame in double precision: rotations, joint velocities, height, root velocities.
type Naive = (Vec<DQuat>, Vec<DVec3>, f64, DVec3, DVec3);

fn naive_features(clip: &Clip, prev: usize, frame: usize, next: usize) -> Naive {
    let pose = |f: usize| clip.frame_rotations(f).iter().map(|q| q.as_dquat().normalize()).collect::<Vec<_>>();
    let (before, now, after) = (pose(prev), pose(frame), pose(next));
    let dt = (next - prev) as f64 / clip.rate_hz;
    let velocities = (0..NUM_JOINTS).map(|j| log(before[j].inverse() * after[j]) / dt).collect();
    let heading = f64::from(clip.planar(frame).heading);
    let local = DQuat::from_rotation_y(-heading);
    let travel = (clip.root_positions[next].as_dvec3() - clip.root_positions[prev].as_dvec3()) / dt;
    let turning = log(after[0] * before[0].inverse()) / dt;
    (now, velocities, f64::from(clip.root_positions[frame].y), local * travel, local * turning)
}

fn naive_distance(a: &Naive, b: &Naive, config: &FeaturesConfig) -> f64 {
    let w = config.weights().unwrap();
    let (t2, m2) = (config.horizon_s.powi(2), config.angle_per_metre.powi(2));
    let mut sum = 0.0;
    for j in 1..NUM_JOINTS {
        sum += w.joints[j] * log(a.0[j].inverse() * b.0[j]).length_squared();
        sum += w.joints[j] * t2 * (a.1[j] - b.1[j]).length_squared();
    }
    sum += config.orientation_weight * least_angle_over_turns(a.0[0], b.0[0]).powi(2);
    sum += m2 * (a.2 - b.2).powi(2) + m2 * t2 * (a.3 - b.3).length_squared();
    (sum + config.orientation_weight * t2 * (a.4 - b.4).length_squared()).sqrt()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn distance_is_the_definition(seed in any::<u64>(), flip in any::<bool>()) {
        let mut clip = random_clip(seed, 8);
        if flip {
            clip.rotations.iter_mut().for_each(|q| *q = -*q);
        }
        let set = set(vec![random_clip(seed ^ 1, 5), clip]);
        let config = FeaturesConfig::default();
        let features = extract(&set, &config).unwrap();
        let expected = naive_distance(&naive_features(&set.clips[0], 1, 2, 3), &naive_features(&set.clips[1], 4, 5, 6), &config);
        let got = f64::from(features.distance(FrameId(2), FrameId(10)));
        prop_assert!((got - expected).abs() < 2e-5 * expected, "{got} {expected}");
    }

    #[test]
    fn moving_a_clip_on_the_ground_changes_nothing(seed in any::<u64>(), x in -9.0f32..9.0, z in -9.0f32..9.0, heading in -7.0f32..7.0) {
        let clip = random_clip(seed, 4);
        let set = set(vec![clip.clone(), moved(&clip, Planar::new(x, z, heading)), random_clip(seed ^ 1, 4)]);
        let features = extract(&set, &FeaturesConfig::default()).unwrap();
        for f in 0..4 {
            prop_assert!(features.distance(FrameId(f), FrameId(4 + f)) < 2e-3);
            let (a, b) = (features.distance(FrameId(f), FrameId(9)), features.distance(FrameId(4 + f), FrameId(9)));
            prop_assert!((a - b).abs() < 1e-3 * a);
        }
    }

    #[test]
    fn distance_is_symmetric_and_the_limit_only_hides(seed in any::<u64>(), limit in 0.0f32..20.0) {
        let features = extract(&set(vec![random_clip(seed, 6)]), &FeaturesConfig::default()).unwrap();
        for i in 0..6 {
            prop_assert_eq!(features.distance(FrameId(i), FrameId(i)), 0.0);
            for j in 0..6 {
                let d = features.squared_distance(FrameId(i), FrameId(j));
                prop_assert_eq!(d, features.squared_distance(FrameId(j), FrameId(i)));
                prop_assert_eq!(features.squared_distance_within(FrameId(i), FrameId(j), limit), (d <= limit).then_some(d));
            }
        }
    }
}

#[test]
fn velocities_are_one_sided_at_the_ends_of_usable_runs() {
    let mut clip = random_clip(3, 6);
    clip.excluded.push(Exclusion { range: 4..6, reason: ExclusionReason::TPose });
    let cut = random_clip(3, 4);
    let set = set(vec![clip.clone(), cut]);
    let config = FeaturesConfig::default();
    let features = extract(&set, &config).unwrap();
    for f in 0..4 {
        assert_eq!(features.distance(FrameId(f), FrameId(6 + f)), 0.0, "frame {f}");
    }
    let ends = naive_distance(&naive_features(&clip, 0, 0, 1), &naive_features(&clip, 2, 3, 3), &config);
    assert!((f64::from(features.distance(FrameId(0), FrameId(3))) - ends).abs() < 1e-4 * ends);
}

#[test]
fn a_joint_turned_by_an_angle_is_that_far_away() {
    let mut clip = random_clip(5, 1);
    let other = clip.clone();
    for j in 1..NUM_JOINTS {
        clip.rotations[j] *= Quat::from_scaled_axis(Vec3::new(0.0, 0.06, 0.08));
    }
    let features = extract(&set(vec![clip, other]), &FeaturesConfig::default()).unwrap();
    assert!((features.distance(FrameId(0), FrameId(1)) - 0.1).abs() < 1e-5);
}

#[test]
fn height_counts_above_what_holds_the_character_up() {
    let clip = random_clip(7, 4);
    let mut lifted = clip.clone();
    lifted.root_positions.iter_mut().for_each(|p| p.y += 2.0);
    let unaware = lifted.clone();
    lifted.support = vec![2.0; 4];
    let features = extract(&set(vec![clip, lifted, unaware]), &FeaturesConfig::default()).unwrap();
    for f in 0..4 {
        assert!(features.distance(FrameId(f), FrameId(4 + f)) < 1e-5, "frame {f}");
        assert!((features.distance(FrameId(f), FrameId(8 + f)) - 5.0).abs() < 1e-4, "2 m at 2.5 rad/m");
    }
}

#[test]
fn a_support_that_rises_leaves_the_velocity_that_of_the_world() {
    let mut clip = random_clip(7, 3);
    for (f, p) in clip.root_positions.iter_mut().enumerate() {
        p.y = 1.0 + 0.1 * f as f32;
    }
    let mut stairs = clip.clone();
    stairs.support = vec![0.0, 0.1, 0.2];
    let config = FeaturesConfig::default();
    let features = extract(&set(vec![clip, stairs]), &config).unwrap();
    for (f, rise) in [0.0, 0.1, 0.2].into_iter().enumerate() {
        let d = f64::from(features.distance(FrameId(f as u32), FrameId(3 + f as u32)));
        assert!((d - rise * config.angle_per_metre).abs() < 1e-5, "frame {f}: only the height differs, by {d}");
    }
}

proptest! {
    #[test]
    fn points_of_the_embedding_are_never_farther_apart_than_the_frames(seed in any::<u64>(), scale in 0.001f32..1.0) {
        let mut clip = random_clip(seed, 8);
        let first = clip.frame_rotations(0).to_vec();
        for (k, q) in clip.rotations.iter_mut().enumerate() {
            // Near and far poses; every other joint with its sign turned round, which is the same rotation.
            *q = first[k % NUM_JOINTS].slerp(*q, scale) * if k % 2 == 0 { 1.0 } else { -1.0 };
        }
        let features = extract(&set(vec![clip]), &FeaturesConfig::default()).unwrap();
        for i in 0..8 {
            let a = features.embed(FrameId(i));
            for j in 0..i {
                let b = features.embed(FrameId(j));
                let chord = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt();
                let distance = features.distance(FrameId(i), FrameId(j));
                prop_assert!(chord <= distance * (1.0 + 1e-5) + 1e-6, "{} above {}", chord, distance);
                prop_assert!(chord >= distance * 0.3, "{} far below {}", chord, distance);
            }
        }
    }
}
