//! Which character, and which of its joints, is under the pointer.

use super::{CharacterInstance, Ray, cull};
use glam::{Vec2, Vec3};
use throng_core::{BodyVolume, Joint, Mat3x4, NUM_JOINTS, Planar, Skeleton};
use throng_geometry::Capsule;

/// Width around a body within which it is picked (m).
const PICK_ROOM_M: f32 = 0.02;

/// Nearest intersection of a ray with a character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedCharacter {
    /// Index of the character.
    pub character: usize,
    /// The joint that is nearer to the place that was met, of the two at the ends of a limb.
    pub joint: Joint,
    /// From the start of the ray (m).
    pub distance: f32,
}

/// The character that a ray meets first.
///
/// Bodies are the capsules of their [`BodyVolume`] with a little room; spheres around whole characters are tested first.
/// Characters with fewer than `num_joints` matrices in the palette are skipped.
///
/// - `poses`: joints in model space (num_characters * num_joints).
pub fn pick(ray: &Ray, body: &Skeleton, poses: &[Mat3x4], instances: &[CharacterInstance]) -> Option<PickedCharacter> {
    let (reach, volume) = (cull::reach(body), BodyVolume::new(body));
    let mut nearest: Option<PickedCharacter> = None;
    for (character, (instance, pose)) in instances.iter().zip(poses.chunks_exact(NUM_JOINTS)).enumerate() {
        let limit = nearest.map_or(f32::INFINITY, |h| h.distance);
        if !may_hit_sphere(ray, world_position(instance.root, pose[0].translation()), reach, limit) {
            continue;
        }
        let found = pick_one(ray, &volume, pose, instance).filter(|(_, d)| *d < limit);
        nearest = found.map(|(joint, distance)| PickedCharacter { character, joint, distance }).or(nearest);
    }
    nearest
}

/// A point in model space, in the world (m).
pub fn world_position(root: Planar, p: Vec3) -> Vec3 {
    let q = root.transform_point(Vec2::new(p.x, p.z));
    Vec3::new(q.x, p.y, q.y)
}

/// False only where the ray passes the sphere by, or enters it beyond `limit`.
fn may_hit_sphere(ray: &Ray, centre: Vec3, radius: f32, limit: f32) -> bool {
    let to = centre - ray.origin;
    let along = to.dot(ray.direction);
    along > -radius && along - radius < limit && (to - ray.direction * along).length_squared() <= radius * radius
}

/// The nearest limb of one character.
fn pick_one(ray: &Ray, volume: &BodyVolume, pose: &[Mat3x4], instance: &CharacterInstance) -> Option<(Joint, f32)> {
    let place =
        |joint: Joint, p: Vec3| world_position(instance.root, pose[joint.index()].to_mat4().transform_point3(p));
    let mut nearest: Option<(Joint, f32)> = None;
    for limb in &volume.capsules {
        let capsule = limb.placed(place);
        let wide = Capsule { radius: capsule.radius + PICK_ROOM_M, ..capsule };
        if let Some(t) = wide.meet_ray(ray.origin, ray.direction).filter(|t| nearest.is_none_or(|n| *t < n.1)) {
            let [a, b] = capsule.ends.map(|end| end.distance_squared(ray.point_at(t)));
            nearest = Some((limb.next.filter(|_| b < a).unwrap_or(limb.joint), t));
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Rgba;
    use glam::Quat;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg32;

    fn rest_pose(skeleton: &Skeleton) -> [Mat3x4; NUM_JOINTS] {
        skeleton.rest_positions().map(|p| Mat3x4::from_rotation_translation(Quat::IDENTITY, p))
    }

    fn crowd(n: usize, rng: &mut Pcg32) -> (Vec<Mat3x4>, Vec<CharacterInstance>) {
        let skeleton = Skeleton::default();
        let palette = (0..n).flat_map(|_| rest_pose(&skeleton)).collect();
        let mut place = || {
            let root =
                Planar::new(rng.random_range(-6.0..6.0), rng.random_range(-6.0..6.0), rng.random_range(-3.0..3.0));
            CharacterInstance { root, colour: Rgba::WHITE, is_selected: false, look: 0 }
        };
        (palette, (0..n).map(|_| place()).collect())
    }

    #[test]
    fn finds_the_same_as_an_exhaustive_search() {
        let (skeleton, mut rng) = (Skeleton::default(), Pcg32::seed_from_u64(11));
        let (palette, instances) = crowd(60, &mut rng);
        let volume = BodyVolume::new(&skeleton);
        let mut hits = 0;
        for _ in 0..600 {
            let origin = Vec3::new(rng.random_range(-9.0..9.0), rng.random_range(0.2..6.0), 12.0);
            let aim = Vec3::new(rng.random_range(-6.0..6.0), rng.random_range(0.0..1.8), rng.random_range(-6.0..6.0));
            let ray = Ray { origin, direction: (aim - origin).normalize() };
            let poses = palette.chunks_exact(NUM_JOINTS);
            let all = poses.zip(&instances).enumerate().filter_map(|(character, (pose, instance))| {
                let (joint, distance) = pick_one(&ray, &volume, pose, instance)?;
                Some(PickedCharacter { character, joint, distance })
            });
            let expected = all.min_by(|a, b| a.distance.total_cmp(&b.distance));
            hits += usize::from(expected.is_some());
            assert_eq!(pick(&ray, &skeleton, &palette, &instances), expected);
        }
        assert!((100..600).contains(&hits), "{hits}");
    }

    #[test]
    fn capsules_are_met_where_marching_meets_them() {
        let mut rng = Pcg32::seed_from_u64(12);
        let (mut met, mut missed) = (0, 0);
        for _ in 0..400 {
            let mut point =
                |r: f32| Vec3::new(rng.random_range(-r..r), rng.random_range(-r..r), rng.random_range(-r..r));
            let (a, b, origin) = (point(0.5), point(0.5), point(2.0));
            let ray = Ray { origin, direction: (point(0.6) - origin).normalize() };
            let distance = |p: Vec3| {
                let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                (p - a.lerp(b, t)).length() - 0.2
            };
            // Sphere tracing: every step is as long as the way is surely free.
            let mut t = 0.0_f32;
            for _ in 0..500 {
                t += distance(ray.point_at(t)).max(0.0);
            }
            match (Capsule { ends: [a, b], radius: 0.2 }).meet_ray(ray.origin, ray.direction) {
                Some(found) => {
                    met += 1;
                    assert!((found - t).abs() < 2e-2, "{found} {t}");
                }
                None => {
                    missed += 1;
                    assert!(t > 4.0, "{t}");
                }
            }
        }
        assert!(met > 50 && missed > 50, "{met} {missed}");
    }

    #[test]
    fn names_the_joint_that_was_met() {
        let (skeleton, mut rng) = (Skeleton::default(), Pcg32::seed_from_u64(13));
        let (palette, mut instances) = crowd(1, &mut rng);
        instances[0].root = Planar::new(1.0, 2.0, 0.0);
        let hand = Vec3::new(1.0, 0.0, 2.0) + skeleton.rest_positions()[Joint::LeftHand.index()];
        let ray = Ray { origin: hand + Vec3::Z * 5.0, direction: -Vec3::Z };
        let hit = pick(&ray, &skeleton, &palette, &instances);
        assert_eq!(hit.map(|h| (h.character, h.joint)), Some((0, Joint::LeftHand)));
        assert_eq!(pick(&ray, &skeleton, &palette[..5], &instances), None);
    }
}
