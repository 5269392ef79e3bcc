//! Idle stretches: frames in which a body stands at ease, its feet pinned to the ground and its hips over them.

use glam::Vec3;
use throng_core::{Contacts, Joint, Skeleton};
use throng_geometry::distance_to_segment;
use throng_motion::clip::{Clip, runs_where};

/// Largest distance of the hips over the ground from the line between the feet: from the middle of the ankles to that of the toes
/// (m).
const HIPS_OFF_M: f32 = 0.06;
/// Largest way of an ankle over the ground within a stretch, from where it is at first (m).
const FOOT_MOVES_M: f32 = 0.03;
/// Shortest stretch (s).
const SHORTEST_S: f64 = 0.5;

/// Frames of its idle stretch that follow each frame of a clip; 0 for those that are in none (frames).
pub(crate) fn frames_left(clip: &Clip, skeleton: &Skeleton) -> Vec<u32> {
    let pair = |at: &[Vec3], joints: [Joint; 2]| joints.map(|j| at[j.index()].with_y(0.0));
    let is_at_ease = |f: usize| {
        let stands = clip.contacts.get(f).is_some_and(|c| c.any(Contacts::LEFT) && c.any(Contacts::RIGHT));
        stands && clip.is_usable(f) && clip.class_at(f).is_some_and(|class| class.neutral)
    };
    let mut out = vec![0; clip.num_frames()];
    for run in runs_where(0..clip.num_frames(), is_at_ease) {
        let places: Vec<Option<[Vec3; 2]>> = run
            .clone()
            .map(|f| {
                let at = clip.joint_positions(skeleton, f);
                let ankles = pair(&at, [Joint::LeftFoot, Joint::RightFoot]);
                let toes = pair(&at, [Joint::LeftToe, Joint::RightToe]);
                let [heels, balls] = [ankles, toes].map(|[left, right]| 0.5 * (left + right));
                let hips_off_m = distance_to_segment(at[0].with_y(0.0) - heels, [Vec3::ZERO, balls - heels]);
                (hips_off_m < HIPS_OFF_M).then_some(ankles)
            })
            .collect();
        let mut from = 0;
        while from < places.len() {
            let Some(first) = places[from] else {
                from += 1;
                continue;
            };
            let is_pinned = |now: &Option<[Vec3; 2]>| {
                now.is_some_and(|now| (0..2).all(|k| now[k].distance(first[k]) < FOOT_MOVES_M))
            };
            let len = places[from..].iter().take_while(|now| is_pinned(now)).count();
            if len as f64 >= SHORTEST_S * clip.rate_hz {
                let frames = out[run.start + from..].iter_mut().take(len).enumerate();
                frames.for_each(|(k, left)| *left = (len - 1 - k) as u32);
            }
            from += len;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;
    use throng_core::NUM_JOINTS;
    use throng_core::format::{ClassSpan, MotionClass};

    /// Somebody who stands at rest for two seconds.
    fn stand(neutral: bool) -> Clip {
        let (n, hips) = (60, Skeleton::default().rest_positions()[0]);
        let class = MotionClass { neutral, ..MotionClass::default() };
        let contacts = vec![Contacts(Contacts::LEFT.0 | Contacts::RIGHT.0); n];
        let classes = vec![ClassSpan { frames: 0..n as u32, class, ..ClassSpan::default() }];
        Clip { contacts, classes, ..Clip::new("a", 30.0, vec![hips; n], vec![Quat::IDENTITY; n * NUM_JOINTS]) }
    }

    #[test]
    fn who_stands_at_ease_on_both_feet_that_stay_idles() {
        let skeleton = Skeleton::default();
        let count = |clip: &Clip| frames_left(clip, &skeleton);
        let calm = count(&stand(true));
        assert_eq!([calm[0], calm[20], calm[59]], [59, 39, 0]);
        assert!(count(&stand(false)).iter().all(|left| *left == 0), "a gesture");
        let mut lifts = stand(true);
        lifts.contacts[30] = Contacts::LEFT;
        assert_eq!([0, 29, 30, 31].map(|f| count(&lifts)[f]), [29, 0, 0, 28]);
        let mut slides = stand(true);
        slides.root_positions.iter_mut().enumerate().for_each(|(f, p)| p.x += 0.002 * f as f32);
        let left = count(&slides);
        assert!(left[0] < 20 && left[left[0] as usize + 1] > 0, "{left:?}");
        let mut leans = stand(true);
        let lean = Quat::from_rotation_x(0.35);
        (0..60).for_each(|f| {
            [14, 18].into_iter().for_each(|j| leans.rotations[f * NUM_JOINTS + j] = lean);
        });
        assert!(count(&leans).iter().all(|left| *left == 0), "hips that are not over the feet");
    }
}
