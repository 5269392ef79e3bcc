//! Keeping the whole state of a crowd, and telling two states apart.

use super::cells::Cells;
use super::decide::Mind;
use super::queue::Calendar;
use super::spline::Spline;
use super::tracing::Trace;
use super::{Counts, Crowd, CrowdError, NONE, Route, Space};
use serde::{Deserialize, Serialize};

/// First field of a snapshot; grows by one with every change of what follows.
const VERSION: u32 = 1;

/// All that time changes.
#[derive(Serialize, Deserialize)]
#[serde(bound = "V: Space")]
struct State<V> {
    version: u32,
    dimensions: u32,
    now: f64,
    counts: Counts,
    free: Vec<u32>,
    minds: Vec<Mind<V>>,
    routes: Vec<Route<V>>,
    cells: Cells<V>,
    queue: Calendar,
    trace: Trace<V>,
}

impl<V: Space> Crowd<V> {
    /// Keeps the whole state. [Size: about 300 bytes a member, and 4 a cell]
    pub fn snapshot(&self) -> Vec<u8> {
        let state = State {
            version: VERSION,
            dimensions: V::DIMENSIONS as u32,
            now: self.now,
            counts: self.counts,
            free: self.free.clone(),
            minds: self.minds.clone(),
            routes: self.world.splines.iter().map(|s| s.route.clone()).collect(),
            cells: self.cells.clone(),
            queue: self.queue.clone(),
            trace: self.trace.clone(),
        };
        // Writing to memory what can be written cannot fail.
        bincode::serde::encode_to_vec(&state, bincode::config::standard().with_fixed_int_encoding()).unwrap_or_default()
    }

    /// Goes back to a snapshot of a crowd that was made with the same setup. What follows is what followed then, bit by bit.
    ///
    /// # Errors
    /// [`CrowdError::Snapshot`]; nothing has changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CrowdError> {
        let refused = |message: String| Err(CrowdError::Snapshot { message });
        let config = bincode::config::standard().with_fixed_int_encoding().with_limit::<{ 1 << 32 }>();
        let state: State<V> = match bincode::serde::decode_from_slice(bytes, config) {
            Ok((state, read)) if read == bytes.len() => state,
            Ok((_, read)) => return refused(format!("{} bytes follow its end", bytes.len() - read)),
            Err(e) => return refused(e.to_string()),
        };
        if (state.version, state.dimensions) != (VERSION, V::DIMENSIONS as u32) {
            return refused(format!("version {} in {} dimensions", state.version, state.dimensions));
        }
        if state.minds.len() != self.minds.len() {
            return refused(format!("it holds {} members, this crowd {}", state.minds.len(), self.minds.len()));
        }
        if !state.cells.fits(&self.cells) || !state.queue.fits(&self.queue) {
            return refused("its cells or its queue are others, or damaged".to_owned());
        }
        let plan = |m: u32| (state.minds[m as usize].cell != NONE).then(|| state.cells.plan(m));
        if !state.trace.fits(&self.trace, self.cells.side(), state.now, plan) {
            return refused("it is of another scheme, or damaged".to_owned());
        }
        let num_fields = self.world.fields.len();
        let is_good = |m: &Mind<V>| {
            m.cell == NONE
                || (m.cell as usize) < self.cells.num_cells()
                    && (m.route as usize) < state.routes.len()
                    && (m.field as usize) < num_fields
        };
        if !state.minds.iter().all(is_good) || state.free.iter().any(|&f| f as usize >= state.minds.len()) {
            return refused("a member has a route, field or cell that does not exist".to_owned());
        }
        let splines = state.routes.iter().enumerate().map(|(i, r)| Spline::new(i, r)).collect::<Result<_, _>>()?;
        self.world.splines = splines;
        (self.now, self.counts) = (state.now, state.counts);
        (self.free, self.minds) = (state.free, state.minds);
        (self.cells, self.queue, self.trace) = (state.cells, state.queue, state.trace);
        self.reserve();
        Ok(())
    }

    /// A number that differs, but for one chance in 2^64, where the motion of anybody differs.
    pub fn state_hash(&self) -> u64 {
        let mut hash = Mix(self.now.to_bits());
        for (index, mind) in (0u32..).zip(&self.minds).filter(|(_, m)| m.cell != NONE) {
            let plan = self.cells.plan(index);
            hash.add(u64::from(index) << 32 | u64::from(mind.generation));
            hash.add(plan.start.to_bits());
            hash.add(plan.end.to_bits());
            for v in [plan.position, plan.velocity, plan.acceleration] {
                v.coordinates().map(|c| hash.add(u64::from(c.to_bits())));
            }
            hash.add(u64::from(mind.route) << 32 | u64::from(mind.speed.to_bits()));
        }
        hash.0
    }
}

/// Multiplies and shifts as the finaliser of SplitMix64 does.
struct Mix(u64);

impl Mix {
    fn add(&mut self, word: u64) {
        let mut x = (self.0 ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        self.0 = x ^ (x >> 27);
    }
}
