use super::*;
use crate::driven::DrivenMotion;
use crate::linkage::Limb;
use crate::problem::MovingSolid;
use crate::recheck::Recheck;
use crate::setup::AllowedContact;
use crate::testing::solid;
use crate::{body::BodyCapsules, limits::BodyLimits};
use glam::DVec3;
use throng_core::{Joint, Skeleton};
use throng_geometry::SolidShape;
use throng_synth::{SynthConfig, SynthSet, make_set};

struct Walk {
    skeleton: Skeleton,
    clip: Clip,
    motion: DrivenMotion,
    limits: BodyLimits,
    shape: BodyCapsules,
}

fn walk() -> Walk {
    let config = SynthConfig { minutes: 0.2, clip_seconds: 12.0, ..SynthConfig::default() };
    let set = make_set(SynthSet::Walk, &config).expect("a walk");
    let mut clip = set.clips[0].clone();
    let rate = clip.rate_hz;
    clip.root_positions.truncate((10.0 * rate) as usize + 1);
    clip.rotations.truncate(clip.root_positions.len() * throng_core::NUM_JOINTS);
    clip.contacts.clear();
    let motion = DrivenMotion::from_clip(&clip, &set.skeleton, 0.0, 10.0);
    let limits = BodyLimits::built_in(&set.skeleton);
    let shape = BodyCapsules::fitted(&set.skeleton);
    Walk { skeleton: set.skeleton, clip, motion, limits, shape }
}

impl Walk {
    fn spec(&self, limb: Limb) -> ProblemSpec<'_> {
        let state = LimbState { pose: self.motion.limb_pose(limb, 0.0), time_s: 0.0 };
        ProblemSpec::new(&self.skeleton, limb, &self.limits, &self.motion, &self.shape, [state; 2])
    }

    fn joint(&self, joint: Joint, time_s: f64) -> DVec3 {
        let frame = (time_s * self.clip.rate_hz).round() as usize;
        self.clip.joint_positions(&self.skeleton, frame)[joint.index()].as_dvec3()
    }

    /// Which share of the frames has all joints of all limbs within limits.
    fn within_limits(&self) -> f64 {
        let frames = 0..self.clip.num_frames();
        let good = frames.clone().filter(|f| {
            Limb::ALL.into_iter().all(|limb| {
                let limits = self.limits.limb_limits(limb).expect("limits");
                let pose = self.motion.limb_pose(limb, *f as f64 / self.clip.rate_hz);
                (0..3).all(|i| limits[i].excess(pose.0[i]) < 0.0)
            })
        });
        good.count() as f64 / frames.len() as f64
    }
}

#[test]
fn a_walk_is_within_limits_and_does_not_collide_with_itself() {
    let walk = walk();
    assert!(walk.within_limits() > 0.99, "{}", walk.within_limits());
    for limb in Limb::ALL {
        let (same, report) = correct_clip(&walk.clip, &walk.spec(limb), &CorrectConfig::default()).expect("a problem");
        assert_eq!((same, report), (walk.clip.clone(), Vec::new()), "{limb:?}");
    }
}

/// The limb may not touch; the rest of the body is not asked.
fn only_the(limb: Limb, with: &str) -> Vec<AllowedContact> {
    let others = Joint::ALL.into_iter().filter(|j| {
        let mut at = Some(*j);
        while let Some(k) = at {
            if limb.joints().contains(&k) {
                return false;
            }
            at = k.parent();
        }
        true
    });
    others.map(|j| AllowedContact { part: Some(j.name().into()), other: with.into(), window_s: None }).collect()
}

#[test]
fn a_walking_arm_gives_way_to_a_post_and_all_else_stays() {
    let walk = walk();
    let limb = Limb::LeftArm;
    let hand = walk.joint(Joint::LeftHand, 5.0);
    let hips = walk.joint(Joint::Hips, 5.0);
    let aside = (hand - hips).with_y(0.0).normalize();
    let post = SolidShape::Round { core: throng_geometry::Segment::new(DVec3::ZERO, DVec3::Y * 2.0), radius: 0.03 };
    let solids = [solid("post", post, (hand + aside * 0.04).with_y(0.0))];
    let allowed = only_the(limb, "post");
    let spec = ProblemSpec { solids: &solids, allowed: &allowed, ..walk.spec(limb) };
    for seed in 0..5 {
        let budget = Budget { seed, ..CorrectConfig::default().budget };
        let config = CorrectConfig { budget, ..CorrectConfig::default() };
        let (after, report) = correct_clip(&walk.clip, &spec, &config).expect("a problem");
        assert_eq!(report.len(), 1, "{report:?}");
        let done = &report[0];
        assert!(done.outcome.is_ok() && done.span.with == "post" && done.span.depth_m > 0.01, "{done:?}");
        assert!((done.span.from_s..done.span.to_s).contains(&5.0) && done.window_s[1] - done.window_s[0] < 3.0);
        let ends = spec.between_times(done.window_s);
        let problem = Problem::new(&ends).expect("a problem");
        let planned: Vec<_> = limb.joints().into_iter().zip(problem.limits).collect();
        let recheck = Recheck {
            skeleton: &walk.skeleton,
            before: &walk.clip,
            after: &after,
            span_s: done.window_s,
            planned: &planned,
            capsules: &walk.shape.capsules,
            held: &[],
            solids: &solids,
            others: &[],
            allowed: &allowed,
            penetration_m: 1e-3,
            self_press_m: crate::setup::SELF_PRESS_M,
        };
        let found = recheck.run();
        assert_eq!(found.violations, []);
        assert!(found.clearance_min_m > 0.0 && found.clearance_min_m < 0.2);
        let again = correct_clip(
            &after,
            &ProblemSpec { motion: &DrivenMotion::from_clip(&after, &walk.skeleton, 0.0, 10.0), ..spec.clone() },
            &config,
        );
        assert!(again.expect("a problem").1.is_empty());
    }
}

#[test]
fn planted_feet_never_move_and_ends_have_to_be_free() {
    let mut walk = walk();
    let limb = Limb::RightLeg;
    let foot = walk.joint(Joint::RightFoot, 5.0);
    let solids = [solid("stone", SolidShape::ball(0.06), foot)];
    let allowed = only_the(limb, "stone");
    walk.clip.contacts = vec![throng_core::Contacts::RIGHT; walk.clip.num_frames()];
    let spec = ProblemSpec { solids: &solids, allowed: &allowed, ..walk.spec(limb) };
    let (same, report) = correct_clip(&walk.clip, &spec, &CorrectConfig::default()).expect("a problem");
    assert_eq!(same, walk.clip);
    let reason = |c: &CorrectedSpan| c.outcome.as_ref().map_or_else(ToString::to_string, |_| String::new());
    assert!(report.iter().all(|c| reason(c).contains("planted feet never move")) && !report.is_empty());
    // Around the whole of the clip there is no free end.
    let limb = Limb::LeftArm;
    let everywhere: Vec<MovingSolid> = vec![solid("fog", SolidShape::ball(50.0), DVec3::ZERO)];
    let allowed = only_the(limb, "fog");
    let spec = ProblemSpec { solids: &everywhere, allowed: &allowed, ..walk.spec(limb) };
    let (_, report) = correct_clip(&walk.clip, &spec, &CorrectConfig::default()).expect("a problem");
    assert!(reason(&report[0]).contains("is in fog up to the clip's start"), "{}", reason(&report[0]));
}

/// A bar across the way at the height of a swinging foot: the leg steps over it.
#[test]
fn a_leg_steps_over_a_bar() {
    let walk = walk();
    let limb = Limb::LeftLeg;
    // The moment in the walk at which the left foot is fastest, half way through a step.
    let speed = |t: f64| (walk.joint(Joint::LeftFoot, t + 0.04) - walk.joint(Joint::LeftFoot, t - 0.04)).length();
    let times = (90..210).map(|f| f64::from(f) / 30.0);
    let time_s = times.max_by(|a, b| speed(*a).total_cmp(&speed(*b))).expect("a time");
    let foot = walk.joint(Joint::LeftFoot, time_s);
    let ahead = (walk.joint(Joint::LeftFoot, time_s + 0.04) - foot).with_y(0.0).normalize();
    let across = ahead.cross(DVec3::Y) * 0.12;
    let bar = SolidShape::Round { core: throng_geometry::Segment::new(-across, across), radius: 0.015 };
    let solids = [solid("bar", bar, foot.with_y(foot.y - 0.05))];
    let allowed = only_the(limb, "bar");
    let spec = ProblemSpec { solids: &solids, allowed: &allowed, ..walk.spec(limb) };
    let (after, report) = correct_clip(&walk.clip, &spec, &CorrectConfig { margin_s: 0.2, ..CorrectConfig::default() })
        .expect("a problem");
    assert!(!report.is_empty() && report.iter().all(|c| c.outcome.is_ok()), "{report:?}");
    assert_ne!(after, walk.clip);
}
