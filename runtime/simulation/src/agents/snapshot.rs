//! Snapshots of all agents of a scene: their crowd, paths, brains and bodies.

use super::things::{HandlingCounts, ThingState, is_near};
use super::{SceneAgents, stage::BodyActivity, troop::SavedTroop};
use crate::motion_kind::{check_snapshot, refused_snapshot, saved_bytes};
use crate::scenario::{AgentBrains, GESTURES, ShownGesture};
use serde::{Deserialize, Serialize};
use throng_base::{Bytes, Id, Result, SnapshotKind};
use throng_crowd::Space;

const KIND: SnapshotKind = SnapshotKind { what: "agents", tag: *b"AGNT", version: 9, setup: 0 };

/// State that changes with time. Names are those of [`super::stage::Outside`] and its layout.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct SavedAgents<V> {
    crowd: Bytes,
    ids: Vec<Option<Id>>,
    agent_of: Vec<u32>,
    sent: Vec<u32>,
    ordered_happenings: Vec<Option<u16>>,
    shown: Vec<BodyActivity>,
    gestures: Vec<Option<ShownGesture>>,
    things: Vec<ThingState>,
    handled: HandlingCounts,
    paths: Vec<Vec<V>>,
    arrivals: Vec<f32>,
    brains: Option<Bytes>,
    /// State of the troops of each group with bodies.
    followers: Vec<Vec<SavedTroop>>,
    /// What the bodies of each of these groups were ordered last.
    ordered: Vec<Vec<BodyActivity>>,
}

impl<V: Space> SceneAgents<V> {
    /// Appends a snapshot, see [`crate::MotionKind::save`].
    pub(super) fn write_snapshot(&self, out: &mut Vec<u8>) {
        let outside = &self.stage;
        let saved = SavedAgents {
            crowd: saved_bytes(|out| outside.crowd.save(out)),
            ids: outside.ids.clone(),
            agent_of: outside.agent_of.clone(),
            sent: outside.sent.clone(),
            ordered_happenings: outside.ordered_happenings.clone(),
            shown: outside.shown.clone(),
            gestures: outside.gestures.clone(),
            things: outside.things.all.clone(),
            handled: outside.things.counts,
            paths: outside.layout.paths.clone(),
            arrivals: outside.layout.arrivals.clone(),
            brains: self.brains.as_ref().map(|brains| saved_bytes(|out| brains.save(out))),
            followers: self.followers.iter().map(|f| f.to_saved()).collect(),
            ordered: self.followers.iter().map(|f| f.ordered.clone()).collect(),
        };
        KIND.write(&saved, out);
    }

    /// Restores a snapshot, see [`crate::MotionKind::load`].
    pub(super) fn read_snapshot(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
        let saved: SavedAgents<V> = KIND.read_all(bytes)?;
        self.check(&saved).map_err(|why| refused_snapshot(KIND.what, why))?;
        self.stage.crowd.load(&saved.crowd.0).map_err(throng_base::Error::from)?;
        let outside = &mut self.stage;
        check_snapshot(outside.crowd.time_s() == time_s, KIND.what, "its crowd is at another time")?;
        // Each member of the crowd is exactly one agent.
        let is_own = |id: Id| {
            let agent = saved.agent_of.get(id.index()).map(|a| *a as usize);
            agent.is_some_and(|a| saved.ids.get(a) == Some(&Some(id)))
        };
        check_snapshot(outside.crowd.ids().all(is_own), KIND.what, "somebody in its crowd is nobody of the scene")?;
        if let (Some(brains), Some(bytes)) = (&mut self.brains, &saved.brains) {
            brains.load(&bytes.0, time_s)?;
        }
        let has_entered = |m: usize| self.brains.as_ref().is_none_or(|brains| brains.has_entered(m));
        let is_same = saved.ids.iter().enumerate().all(|(m, id)| id.is_some() == has_entered(m));
        check_snapshot(is_same, KIND.what, "somebody is there who has not entered")?;
        for ((own, troops), ordered) in self.followers.iter_mut().zip(&saved.followers).zip(&saved.ordered) {
            own.load(troops, &saved.ids, ordered)?;
        }
        (outside.ids, outside.agent_of) = (saved.ids, saved.agent_of);
        outside.agents_reported.clone_from(&outside.agent_of);
        (outside.sent, outside.ordered_happenings, outside.shown) = (saved.sent, saved.ordered_happenings, saved.shown);
        (outside.things.all, outside.things.counts) = (saved.things, saved.handled);
        outside.gestures = saved.gestures;
        outside.things.reaches = true;
        (outside.layout.paths, outside.layout.arrivals) = (saved.paths, saved.arrivals);
        outside.newcomers.clear();
        Ok(())
    }

    /// Checks that a state can be one of these agents.
    fn check(&self, saved: &SavedAgents<V>) -> std::result::Result<(), &'static str> {
        let n = self.num_agents();
        let lengths =
            [saved.ids.len(), saved.sent.len(), saved.ordered_happenings.len(), saved.shown.len(), saved.paths.len()];
        let more = [saved.arrivals.len(), saved.agent_of.len(), saved.gestures.len()];
        let has_brains = saved.brains.is_some() == self.brains.is_some();
        if lengths != [n; 5]
            || more != [n; 3]
            || saved.followers.len() != self.followers.len()
            || saved.ordered.len() != self.followers.len()
            || !has_brains
        {
            return Err("it has other agents");
        }
        let happenings = self.stage.layout.scene.happenings.len();
        if saved.ordered_happenings.iter().flatten().any(|&h| usize::from(h) >= happenings) {
            return Err("somebody knows of what has not happened");
        }
        self.stage.things.check(&saved.things, &saved.handled, n)?;
        let is_path = |path: &Vec<V>| path.iter().all(|at| at.is_finite());
        let has_room = saved.sent.iter().all(|&sent| sent < u32::MAX / 128);
        let num_motions = self.brains.as_ref().map_or(0, AgentBrains::num_motions);
        let is_seen = saved.shown.iter().chain(saved.ordered.iter().flatten()).all(|s| {
            s.motion.is_none_or(|motion| usize::from(motion) < num_motions)
                && s.other.is_none_or(|other| (other as usize) < n)
                && [s.faces, s.stands].iter().flatten().all(is_near)
        });
        let are_gestures = saved.gestures.iter().flatten().all(|g| {
            g.at.iter().all(is_near)
                && g.other.is_none_or(|other| (other as usize) < n)
                && GESTURES.iter().any(|known| known.1 == g.arm)
                && g.until_s >= 0.0
        });
        let are_agents = saved.agent_of.iter().all(|&a| (a as usize) < n);
        let are_paths = saved.paths.iter().all(is_path) && saved.arrivals.iter().all(|a| a.is_finite());
        if are_paths && has_room && is_seen && are_gestures && are_agents {
            Ok(())
        } else {
            Err("somebody is on no path")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};
    use std::path::Path;

    #[test]
    fn agents_that_cannot_be_are_refused() {
        let text = "[[things]]\nname = \"cup\"\nat = [0.0, 1.0, 0.0]\n[[rules]]\non = \"starts\"\ndo = [{ stay = 9, motion = \"wave\" }]\n\
                    [[groups]]\nmotion = \"none\"\ncount = 3\nplace = { block = { from = [0.0, 0.0], to = [9.0, 9.0] } }\n\
                    goal = { stay = {} }\nsource = { start = 2, rates = [[0.0, 0.001]] }\n";
        let scene = crate::scene::Scene::parse(text, Path::new("a.toml")).unwrap().open().unwrap();
        let agents = SceneAgents::<Vec2>::new(&scene).unwrap();
        let is_refused = |change: fn(&mut SceneAgents<Vec2>)| {
            let (mut forged, mut bytes) = (agents.clone(), Vec::new());
            change(&mut forged);
            forged.write_snapshot(&mut bytes);
            agents.clone().read_snapshot(&bytes, 0.0).is_err()
        };
        assert!(!is_refused(|_| ()));
        for (n, change) in [
            |a: &mut SceneAgents<Vec2>| a.stage.shown[0].motion = Some(1),
            |a: &mut SceneAgents<Vec2>| a.stage.shown[0].faces = Some(Vec3::MAX),
            |a: &mut SceneAgents<Vec2>| {
                let arm = throng_core::body::ArmLayer::Point(Vec3::MAX);
                a.stage.gestures[0] = Some(ShownGesture { arm, at: None, other: None, until_s: 1.0 });
            },
            |a: &mut SceneAgents<Vec2>| a.stage.ids[2] = a.stage.ids[1],
            |a: &mut SceneAgents<Vec2>| a.stage.sent[0] = u32::MAX / 64 - 1,
            |a: &mut SceneAgents<Vec2>| a.stage.things.counts.missed = u32::MAX,
            |a: &mut SceneAgents<Vec2>| a.stage.things.all[0].at.x = f32::MAX,
        ]
        .into_iter()
        .enumerate()
        {
            assert!(is_refused(change), "{n}");
        }
    }
}
