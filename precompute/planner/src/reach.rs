//! Poses that reach a target among everything around: limits and collisions at once.

use crate::ik::{IkError, LimbIk, Swivel};
use crate::problem::{LimbState, Problem};
use crate::{collide::Checker, linkage::LimbPose, rotation::Rigid};
use glam::DVec3;

impl Problem {
    /// Solves for the pose at a time that brings hand or foot to a target, within limits and free. Knees stay as near as
    /// possible to the present pose's, elbows halfway from there down.
    ///
    /// # Errors
    /// [`IkError`], with the name of the obstacle.
    ///
    /// # Source
    /// Shapiro, Kallmann and Faloutsos 2007, sections 5 and 6.2.
    pub fn solve_reach(
        &self,
        checker: &mut Checker,
        target: &Rigid,
        time_s: f64,
        present: &LimbPose,
    ) -> Result<LimbPose, IkError<String>> {
        let low = Swivel::Low { down: self.base_at(time_s).rotation.inverse() * DVec3::NEG_Y };
        let from = if self.chain.limb.is_arm() { low } else { Swivel::Present };
        self.solve_reach_from(checker, target, time_s, present, from)
    }

    /// Solves as [`Problem::solve_reach`] does, with the swivel as near as possible to `from`.
    pub(crate) fn solve_reach_from(
        &self,
        checker: &mut Checker,
        target: &Rigid,
        time_s: f64,
        present: &LimbPose,
        from: Swivel,
    ) -> Result<LimbPose, IkError<String>> {
        let ik = LimbIk::new(&self.chain, &self.limits);
        ik.solve(&self.base_at(time_s), target, present, from, |pose| {
            let hit = checker.deepest_hit(self, &LimbState { pose: *pose, time_s })?;
            Some(self.target_name(self.pairs[hit.pair].target))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::rotation_about;
    use crate::setup::ProblemSpec;
    use crate::testing::{TestCharacter, solid};
    use throng_geometry::SolidShape;

    #[test]
    fn a_target_is_reached_past_what_is_in_the_way_or_says_what_is() {
        let s = TestCharacter::standing();
        let pose = s.pose(0.0, -0.2, 0.4);
        let target = Rigid { position: DVec3::new(0.2, 1.35, 0.35), rotation: rotation_about(DVec3::Y, -1.4) };
        let with = |shape: SolidShape, at: DVec3| {
            let solids = [solid("box", shape, at)];
            let spec = s.spec([(pose, 0.0), (pose, 1.0)]);
            let problem = Problem::prepare(&ProblemSpec { solids: &solids, ..spec }).expect("a problem");
            let reached = problem.solve_reach(&mut Checker::default(), &target, 0.5, &pose);
            (problem, reached)
        };
        let (problem, reached) = with(SolidShape::ball(0.05), DVec3::splat(9.0));
        let reached = reached.expect("free");
        let placed = problem.place_chain(&LimbState { pose: reached, time_s: 0.5 });
        assert!(placed[2].position.distance(target.position) < 1e-9);
        // Where the elbow would be: it goes elsewhere.
        let (problem, other) = with(SolidShape::ball(0.03), placed[1].position);
        let elbow = problem.place_chain(&LimbState { pose: other.expect("another swivel"), time_s: 0.5 })[1].position;
        assert!(elbow.distance(placed[1].position) > 0.05);
        let (_, blocked) = with(SolidShape::cuboid(DVec3::splat(0.2)), target.position);
        assert_eq!(blocked.unwrap_err().to_string(), "blocked by box");
    }
}
