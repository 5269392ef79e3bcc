//! Keeping all agents of a scene: their crowd, who knows of what, their ways and bodies.

use super::troop::SavedTroop;
use super::{Agents, NEWS_S};
use crate::kind::refused;
use serde::{Deserialize, Serialize};
use throng_base::{Bytes, Result, SnapshotKind};
use throng_crowd::Space;

const KIND: SnapshotKind = SnapshotKind { what: "agents", tag: *b"AGNT", version: 1, setup: 0 };

/// Errors of the clock that rounding makes (s).
const ROUNDING_S: f64 = 1e-6;

/// All that time changes. Names are those of [`Agents`] and its layout.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct Saved<V> {
    crowd: Bytes,
    happened: usize,
    knows: Vec<usize>,
    sent: Vec<u32>,
    told: Vec<(usize, usize)>,
    ticks: u64,
    ways: Vec<Vec<V>>,
    arrivals: Vec<f32>,
    /// Of each group with bodies.
    followers: Vec<Vec<SavedTroop>>,
}

impl<V: Space> Agents<V> {
    /// See [`crate::Kind::save`].
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        let mut crowd = Bytes::default();
        self.crowd.save(&mut crowd.0);
        let saved = Saved {
            crowd,
            happened: self.happened,
            knows: self.knows.clone(),
            sent: self.sent.clone(),
            told: self.told.clone(),
            ticks: self.ticks,
            ways: self.layout.ways.clone(),
            arrivals: self.layout.arrivals.clone(),
            followers: self.followers.iter().map(|f| f.saved()).collect(),
        };
        KIND.write(&saved, out);
    }

    /// See [`crate::Kind::load`].
    pub(super) fn read(&mut self, bytes: &[u8], time_s: f64) -> Result<()> {
        let saved: Saved<V> = KIND.read_all(bytes)?;
        self.check(&saved, time_s).map_err(|why| refused(KIND.what, why))?;
        self.crowd.load(&saved.crowd.0).map_err(throng_base::Error::from)?;
        if self.crowd.now() != time_s {
            return Err(refused(KIND.what, "its crowd is at another time"));
        }
        for (own, troops) in self.followers.iter_mut().zip(&saved.followers) {
            own.load(troops)?;
        }
        (self.happened, self.ticks) = (saved.happened, saved.ticks);
        (self.knows, self.sent) = (saved.knows, saved.sent);
        (self.layout.ways, self.layout.arrivals) = (saved.ways, saved.arrivals);
        // The vector keeps its capacity.
        self.told.clone_from(&saved.told);
        Ok(())
    }

    /// Why a state cannot be one of these agents.
    fn check(&self, saved: &Saved<V>, time_s: f64) -> std::result::Result<(), &'static str> {
        let n = self.num_agents();
        let lengths = [saved.knows.len(), saved.sent.len(), saved.ways.len(), saved.arrivals.len()];
        if lengths != [n; 4] || saved.followers.len() != self.followers.len() {
            return Err("it has other agents");
        }
        let happened = self.happenings.partition_point(|h| h.time_s <= time_s);
        let is_known = |news: usize| news <= happened;
        let may_be_told = |&(who, news): &(usize, usize)| who < n && news > 0 && is_known(news);
        if saved.happened != happened
            || !saved.knows.iter().all(|&k| is_known(k))
            || !saved.told.iter().all(may_be_told)
        {
            return Err("somebody knows of what has not happened");
        }
        let next_s = (saved.ticks as f64 + 1.0) * NEWS_S;
        let is_told_on = self.happenings[..happened].iter().any(|h| h.told_on);
        if next_s > time_s + NEWS_S + ROUNDING_S || is_told_on && next_s < time_s - ROUNDING_S {
            return Err("news are told at another time");
        }
        let is_way = |way: &Vec<V>| !way.is_empty() && way.iter().all(|at| at.is_finite());
        let has_room = saved.sent.iter().all(|&sent| sent < u32::MAX / 2);
        match saved.ways.iter().all(is_way) && saved.arrivals.iter().all(|a| a.is_finite()) && has_room {
            true => Ok(()),
            false => Err("somebody is on no way"),
        }
    }
}
