//! Keeping the whole state of a scene that runs.

use super::live::Live;
use serde::{Deserialize, Serialize};
use throng_motion::error::BuildError;
use throng_runtime::crowd::Space;

/// First field of what is kept; grows by one with every change of what follows.
const VERSION: u32 = 1;

/// All that time changes.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct State<V> {
    version: u32,
    crowd: Vec<u8>,
    happened: usize,
    knows: Vec<usize>,
    sent: Vec<u32>,
    told: Vec<(usize, usize)>,
    ticks: u64,
    /// Of those who were sent elsewhere: number, way, and how near to its end is there.
    ways: Vec<(usize, Vec<V>, f32)>,
}

impl<V: Space> Live<V> {
    /// Keeps the whole state (about 300 bytes an agent, and 4 a cell).
    pub fn snapshot(&self) -> Vec<u8> {
        let others = (0..self.num_agents()).filter(|&m| self.sent[m] > 0);
        let mut crowd = Vec::new();
        self.crowd.save(&mut crowd);
        let state = State {
            version: VERSION,
            crowd,
            happened: self.happened,
            knows: self.knows.clone(),
            sent: self.sent.clone(),
            told: self.told.clone(),
            ticks: self.ticks,
            ways: others.map(|m| (m, self.layout.ways[m].clone(), self.layout.arrivals[m])).collect(),
        };
        // Writing to memory what can be written cannot fail.
        bincode::serde::encode_to_vec(&state, bincode::config::standard()).unwrap_or_default()
    }

    /// Goes back to a snapshot of the same scene, with as many agents, the same seed and engine. What follows is what
    /// followed then, bit by bit.
    ///
    /// # Errors
    /// [`BuildError::Stage`]; nothing has changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), BuildError> {
        let config = bincode::config::standard().with_limit::<{ 1 << 32 }>();
        let (state, _): (State<V>, usize) =
            bincode::serde::decode_from_slice(bytes, config).map_err(|e| refused(&e.to_string()))?;
        let n = self.num_agents();
        if state.version != VERSION || [state.knows.len(), state.sent.len()] != [n, n] {
            return Err(refused(&format!("version {} with {} agents, not {n}", state.version, state.knows.len())));
        }
        let num = self.num_happenings();
        let is_known = |news: usize| news <= num;
        let told_right = state.told.iter().all(|&(m, news)| m < n && (1..=num).contains(&news));
        let ways_right = state.ways.iter().all(|w| w.0 < n && !w.1.is_empty());
        if !is_known(state.happened) || !state.knows.iter().all(|&k| is_known(k)) || !told_right || !ways_right {
            return Err(refused("it names agents or happenings that the scene does not have"));
        }
        self.crowd.load(&state.crowd).map_err(|e| refused(&e.to_string()))?;
        (self.happened, self.knows, self.sent) = (state.happened, state.knows, state.sent);
        (self.told, self.ticks) = (state.told, state.ticks);
        for (m, way, arrival) in state.ways {
            (self.layout.ways[m], self.layout.arrivals[m]) = (way, arrival);
        }
        Ok(())
    }
}

fn refused(why: &str) -> BuildError {
    BuildError::Stage {
        stage: "scene",
        message: format!("this is no snapshot of this scene: {why}"),
        help: "Restore it into the scene that it was kept of, with as many agents, the same seed and engine".into(),
    }
}
