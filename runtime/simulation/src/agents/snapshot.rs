//! Snapshots of all agents of a scene: their crowd, paths, brains and bodies.

use super::Agents;
use super::stage::Shown;
use super::things::{Handled, Thing, is_near};
use super::troop::SavedTroop;
use crate::kind::refused;
use crate::scenario::Minds;
use serde::{Deserialize, Serialize};
use throng_base::{Bytes, Id, Result, SnapshotKind};
use throng_crowd::Space;

const KIND: SnapshotKind = SnapshotKind { what: "agents", tag: *b"AGNT", version: 5, setup: 0 };

/// State that changes with time. Names are those of [`super::stage::Outside`] and its layout.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct Saved<V> {
    crowd: Bytes,
    ids: Vec<Option<Id>>,
    agent_of: Vec<u32>,
    sent: Vec<u32>,
    told: Vec<Option<u16>>,
    shown: Vec<Shown>,
    things: Vec<Thing>,
    handled: Handled,
    ways: Vec<Vec<V>>,
    arrivals: Vec<f32>,
    minds: Option<Bytes>,
    /// State of the troops of each group with bodies.
    followers: Vec<Vec<SavedTroop>>,
}

impl<V: Space> Agents<V> {
    /// Appends a snapshot, see [`crate::Kind::save`].
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        let mut crowd = Bytes::default();
        let outside = &self.outside;
        outside.crowd.save(&mut crowd.0);
        let saved = Saved {
            crowd,
            ids: outside.ids.clone(),
            agent_of: outside.agent_of.clone(),
            sent: outside.sent.clone(),
            told: outside.told.clone(),
            shown: outside.shown.clone(),
            things: outside.things.all.clone(),
            handled: outside.things.handled,
            ways: outside.layout.ways.clone(),
            arrivals: outside.layout.arrivals.clone(),
            minds: self.minds.as_ref().map(|minds| {
                let mut bytes = Bytes::default();
                minds.save(&mut bytes.0);
                bytes
            }),
            followers: self.followers.iter().map(|f| f.saved()).collect(),
        };
        KIND.write(&saved, out);
    }

    /// Restores a snapshot, see [`crate::Kind::load`].
    pub(super) fn read(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
        let saved: Saved<V> = KIND.read_all(bytes)?;
        self.check(&saved).map_err(|why| refused(KIND.what, why))?;
        self.outside.crowd.load(&saved.crowd.0).map_err(throng_base::Error::from)?;
        let outside = &mut self.outside;
        if outside.crowd.now() != time_s {
            return Err(refused(KIND.what, "its crowd is at another time"));
        }
        // Each member of the crowd is exactly one agent.
        let is_own = |id: Id| {
            let agent = saved.agent_of.get(id.index()).map(|a| *a as usize);
            agent.is_some_and(|a| saved.ids.get(a) == Some(&Some(id)))
        };
        if !outside.crowd.ids().all(is_own) {
            return Err(refused(KIND.what, "somebody in its crowd is nobody of the scene"));
        }
        if let (Some(minds), Some(bytes)) = (&mut self.minds, &saved.minds) {
            minds.load(&bytes.0, time_s)?;
        }
        let has_entered = |m: usize| self.minds.as_ref().is_none_or(|minds| minds.has_entered(m));
        if saved.ids.iter().enumerate().any(|(m, id)| id.is_some() != has_entered(m)) {
            return Err(refused(KIND.what, "somebody is there who has not entered"));
        }
        for (own, troops) in self.followers.iter_mut().zip(&saved.followers) {
            own.load(troops, &saved.ids, &saved.shown)?;
        }
        (outside.ids, outside.agent_of) = (saved.ids, saved.agent_of);
        outside.agents_told.clone_from(&outside.agent_of);
        (outside.sent, outside.told, outside.shown) = (saved.sent, saved.told, saved.shown);
        (outside.things.all, outside.things.handled) = (saved.things, saved.handled);
        outside.things.reaches = true;
        (outside.layout.ways, outside.layout.arrivals) = (saved.ways, saved.arrivals);
        outside.newcomers.clear();
        Ok(())
    }

    /// Checks that a state can be one of these agents.
    fn check(&self, saved: &Saved<V>) -> std::result::Result<(), &'static str> {
        let n = self.num_agents();
        let lengths = [saved.ids.len(), saved.sent.len(), saved.told.len(), saved.shown.len(), saved.ways.len()];
        let more = [saved.arrivals.len(), saved.agent_of.len()];
        let has_minds = saved.minds.is_some() == self.minds.is_some();
        if lengths != [n; 5] || more != [n; 2] || saved.followers.len() != self.followers.len() || !has_minds {
            return Err("it has other agents");
        }
        let happenings = self.outside.layout.scene.happenings.len();
        if saved.told.iter().flatten().any(|&h| usize::from(h) >= happenings) {
            return Err("somebody knows of what has not happened");
        }
        self.outside.things.check(&saved.things, &saved.handled, n)?;
        let is_way = |way: &Vec<V>| !way.is_empty() && way.iter().all(|at| at.is_finite());
        let has_room = saved.sent.iter().all(|&sent| sent < u32::MAX / 128);
        let num_motions = self.minds.as_ref().map_or(0, Minds::num_motions);
        let is_seen = saved.shown.iter().all(|s| {
            s.motion.is_none_or(|motion| usize::from(motion) < num_motions)
                && [s.faces, s.stands].iter().flatten().all(is_near)
        });
        let are_agents = saved.agent_of.iter().all(|&a| (a as usize) < n);
        match saved.ways.iter().all(is_way)
            && saved.arrivals.iter().all(|a| a.is_finite())
            && has_room
            && is_seen
            && are_agents
        {
            true => Ok(()),
            false => Err("somebody is on no way"),
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
        let agents = Agents::<Vec2>::new(&scene).unwrap();
        let is_refused = |change: fn(&mut Agents<Vec2>)| {
            let (mut forged, mut bytes) = (agents.clone(), Vec::new());
            change(&mut forged);
            forged.write(&mut bytes);
            agents.clone().read(&bytes, 0.0).is_err()
        };
        assert!(!is_refused(|_| ()));
        for (n, change) in [
            |a: &mut Agents<Vec2>| a.outside.shown[0].motion = Some(1),
            |a: &mut Agents<Vec2>| a.outside.shown[0].faces = Some(Vec3::MAX),
            |a: &mut Agents<Vec2>| a.outside.ids[2] = a.outside.ids[1],
            |a: &mut Agents<Vec2>| a.outside.sent[0] = u32::MAX / 64 - 1,
            |a: &mut Agents<Vec2>| a.outside.things.handled.missed = u32::MAX,
            |a: &mut Agents<Vec2>| a.outside.things.all[0].at.x = f32::MAX,
        ]
        .into_iter()
        .enumerate()
        {
            assert!(is_refused(change), "{n}");
        }
    }
}
