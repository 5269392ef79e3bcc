//! Keeping the whole state of a scene that runs.

use super::live::Live;
use crate::error::BuildError;
use serde::{Deserialize, Serialize};
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
    /// Keeps the whole state. [Size: about 300 bytes a member, and 4 a cell]
    pub fn snapshot(&self) -> Vec<u8> {
        let others = (0..self.num_members()).filter(|&m| self.sent[m] > 0);
        let state = State {
            version: VERSION,
            crowd: self.crowd.snapshot(),
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

    /// Goes back to a snapshot of the same scene, with as many members, the same seed and engine. What follows is what
    /// followed then, bit by bit.
    ///
    /// # Errors
    /// [`BuildError::Stage`]; nothing has changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), BuildError> {
        let config = bincode::config::standard().with_limit::<{ 1 << 32 }>();
        let (state, _): (State<V>, usize) =
            bincode::serde::decode_from_slice(bytes, config).map_err(|e| refused(&e.to_string()))?;
        let n = self.num_members();
        if state.version != VERSION || [state.knows.len(), state.sent.len()] != [n, n] {
            return Err(refused(&format!("version {} with {} members, not {n}", state.version, state.knows.len())));
        }
        let num = self.num_happenings();
        let is_known = |news: usize| news <= num;
        let told_right = state.told.iter().all(|&(m, news)| m < n && (1..=num).contains(&news));
        let ways_right = state.ways.iter().all(|w| w.0 < n && !w.1.is_empty());
        if !is_known(state.happened) || !state.knows.iter().all(|&k| is_known(k)) || !told_right || !ways_right {
            return Err(refused("it names members or happenings that the scene does not have"));
        }
        self.crowd.restore(&state.crowd).map_err(|e| refused(&e.to_string()))?;
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
        help: "Restore it into the scene that it was kept of, with as many members, the same seed and engine".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::crowd::CrowdScene;
    use glam::Vec2;
    use std::path::Path;

    /// Two groups that meet, and news that half of them hear of and tell on.
    const SCENE: &str = r#"
[[groups]]
count = 12
place = { block = { from = [-9.0, -3.0], to = [-3.0, 3.0] } }
goal = { shift = { by = [12.0, 0.0] } }

[[groups]]
count = 12
place = { block = { from = [3.0, -3.0], to = [9.0, 3.0] } }
goal = { shift = { by = [-12.0, 0.0] } }

[[happenings]]
time_s = 1.0
near = { at = [-9.0, 0.0], radius_m = 5.0 }
goal = { point = { at = [0.0, 20.0] } }
arrival_m = 5.0
told_on = true
"#;

    fn live(text: &str) -> Live<Vec2> {
        Live::new(&CrowdScene::from_text(text, Path::new("meeting.toml")).unwrap()).unwrap()
    }

    #[test]
    fn a_scene_that_is_kept_goes_on_as_it_did() {
        let mut first = live(SCENE);
        first.advance(2.5).unwrap();
        let kept = first.snapshot();
        first.advance(6.0).unwrap();
        let mut again = live(SCENE);
        again.restore(&kept).unwrap();
        assert!(again.snapshot() == kept, "what is kept again is the same");
        again.advance(6.0).unwrap();
        assert_eq!(again.crowd().state_hash(), first.crowd().state_hash());
        let state = |l: &Live<Vec2>, m| (l.knows(m), l.times_sent(m), l.layout().ways[m].clone());
        assert!((0..24).all(|m| state(&first, m) == state(&again, m)));
        assert!((0..24).any(|m| again.knows(m) > 0) && again.times_sent(0) > 0);
    }

    #[test]
    fn what_was_kept_of_another_scene_is_refused() {
        let kept = live(SCENE).snapshot();
        let mut other = live(&SCENE.replacen("count = 12", "count = 9", 1));
        let hash = other.crowd().state_hash();
        for bytes in [&kept[..], &kept[..kept.len() / 2], b"", b"something else"] {
            assert!(other.restore(bytes).unwrap_err().to_string().contains("no snapshot of this scene"));
        }
        assert_eq!(other.crowd().state_hash(), hash);
        let mut calm = live(SCENE.split("[[happenings]]").next().unwrap());
        let mut late = live(SCENE);
        late.advance(2.0).unwrap();
        assert!(calm.restore(&late.snapshot()).unwrap_err().to_string().contains("happenings"));
    }
}
