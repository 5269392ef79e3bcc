//! Measures the progress of agents towards their goals.

use throng_base::thresholds::STANDING_MPS_F64;
use throng_crowd::Space;

/// An agent that stays within this distance for `STUCK_S` is stuck (m).
const STUCK_M: f32 = 0.5;
/// See [`STUCK_M`] (s).
const STUCK_S: f64 = 10.0;
/// An agent that does not come `STUCK_M` nearer to its goal in this time is stuck, too: it may walk about in a jam (s).
const JAMMED_S: f64 = 20.0;
/// Longest wait for a turn at a passage that is no jam (s).
const MOST_WAIT_S: f64 = 60.0;
/// Time over which a speed is averaged (s).
const WINDOW_S: f64 = 10.0;

/// Progress along paths, and agents that make none.
#[derive(Clone, Debug, Default)]
pub struct ProgressMeter<V> {
    agents: Vec<AgentProgress<V>>,
    /// Distance gained along the paths by all agents (m).
    gained_m: f64,
    /// Time that all agents were on their way (s).
    on_the_way_s: f64,
    /// Part of that time in which they stood (s).
    stood_s: f64,
    /// Distance gained and time on the way in each ten seconds (m, s).
    by_10s: Vec<[f64; 2]>,
}

/// Progress of one agent along its path.
#[derive(Clone, Debug)]
struct AgentProgress<V> {
    /// Number of its path.
    path_number: u32,
    /// Next corner of the path.
    corner: usize,
    /// Remaining length of the path (m).
    remaining_m: f32,
    /// Time of the last sample (s), the place then (m), and whether it had stood since the one before.
    time_s: f64,
    at: V,
    stands: bool,
    /// Place within `STUCK_M` of which it has stayed, and since when (m, s).
    stayed_since: (V, f64),
    /// Shortest remaining path so far, by the agent's own route, and since when (m, s).
    nearest: (f32, f64),
    /// Time at which it did not wait for a turn last (s).
    waits_since_s: f64,
    has_arrived: bool,
    is_stuck: bool,
    /// True before it enters, and after it has left.
    is_absent: bool,
}

/// Sample of an agent at one time.
#[derive(Clone, Copy, Debug)]
pub struct AgentSample<'a, V> {
    /// Position; `None` if it has left (m).
    pub at: Option<V>,
    /// Corners of its path from its start to its goal (m); none on rounds, along which progress is that of `remaining_m`.
    pub path: &'a [V],
    /// How often its path has changed.
    pub path_number: u32,
    /// Remaining length of its own route around obstacles (m).
    pub remaining_m: f32,
    /// Distance from the goal at which it has arrived (m).
    pub arrival_m: f32,
    /// True if it begins its path again at the end.
    pub is_loop: bool,
    /// True if it stands at its goal, be it behind others.
    pub has_settled: bool,
    /// True if it waits for its turn at a passage.
    pub waits: bool,
}

impl<V: Space> ProgressMeter<V> {
    /// Observes all agents, in the same order each time.
    pub fn observe<'a>(&mut self, time_s: f64, agents: impl Iterator<Item = AgentSample<'a, V>>) {
        for (m, sight) in agents.enumerate() {
            if m == self.agents.len() {
                self.agents.push(AgentProgress::start(&sight, time_s));
            } else {
                let (gained, spent) = self.agents[m].advance(&sight, time_s);
                self.gained_m += f64::from(gained);
                self.on_the_way_s += spent;
                self.stood_s += if self.agents[m].stands { spent } else { 0.0 };
                let window = (time_s / WINDOW_S - 1e-9).max(0.0) as usize;
                if self.by_10s.len() <= window {
                    self.by_10s.resize(window + 1, [0.0; 2]);
                }
                let [all_gained, all_spent] = &mut self.by_10s[window];
                (*all_gained, *all_spent) = (*all_gained + f64::from(gained), *all_spent + spent);
            }
        }
    }

    /// Mean speed along their paths of agents that have not arrived (m/s).
    pub fn progress_mps(&self) -> f64 {
        self.gained_m / self.on_the_way_s.max(1e-9)
    }

    /// Share of the time on their way in which agents stand.
    pub fn stopped_share(&self) -> f64 {
        self.stood_s / self.on_the_way_s.max(1e-9)
    }

    /// Share of the agents that have reached their goal, or left there.
    pub fn reached(&self) -> f64 {
        self.arrived() as f64 / self.agents.len().max(1) as f64
    }

    /// Mean speed along their paths in each ten seconds in which agents were on their way (m/s).
    pub fn progress_by_10s_mps(&self) -> Vec<f64> {
        self.by_10s.iter().filter(|w| w[1] > 0.0).map(|w| w[0] / w[1]).collect()
    }

    /// Agents on their way that by now have stayed within half a metre for 10 s, or come no nearer for 20 s.
    pub fn stuck_at(&self, time_s: f64) -> usize {
        self.agents.iter().filter(|m| !m.has_arrived && !m.is_absent && m.makes_no_progress(time_s)).count()
    }

    /// Agents that have reached their goal, stand around it behind others, or left there.
    pub fn arrived(&self) -> usize {
        self.agents.iter().filter(|m| m.has_arrived).count()
    }

    /// Agents that at any time stayed within half a metre for 10 s away from their goal, or did not come half a metre nearer in
    /// 20 s; time for which they wait for a turn is left out, up to 60 s.
    pub fn stuck(&self) -> usize {
        self.agents.iter().filter(|m| m.is_stuck).count()
    }
}

impl<V: Space> AgentProgress<V> {
    fn start(sight: &AgentSample<'_, V>, time_s: f64) -> Self {
        let at = sight.at.unwrap_or_default();
        let mut one = Self {
            path_number: sight.path_number,
            corner: 1,
            remaining_m: 0.0,
            time_s,
            at,
            stands: false,
            stayed_since: (at, time_s),
            nearest: (sight.remaining_m, time_s),
            waits_since_s: time_s,
            has_arrived: false,
            is_stuck: false,
            is_absent: sight.at.is_none(),
        };
        one.remaining_m = one.remaining_length(sight, at);
        one.has_arrived = !one.is_absent && one.has_reached_goal(sight, at);
        one
    }

    /// Advances to a sample; returns the distance gained and the time spent on the way (m, s).
    fn advance(&mut self, sight: &AgentSample<'_, V>, time_s: f64) -> (f32, f64) {
        if sight.at.is_some() && (self.path_number != sight.path_number || self.is_absent) {
            *self = Self { is_stuck: self.is_stuck, ..Self::start(sight, time_s) };
            return (0.0, 0.0);
        }
        let spent = time_s - std::mem::replace(&mut self.time_s, time_s);
        let was_there = !std::mem::replace(&mut self.is_absent, sight.at.is_none());
        if self.has_arrived || self.is_absent && !was_there {
            return (0.0, 0.0);
        }
        let Some(at) = sight.at else {
            // It has left at its goal.
            self.has_arrived = true;
            self.stands = false;
            // Who is away from its goal when it leaves has not come there.
            let gained = self.remaining_m.min(sight.arrival_m + STUCK_M);
            return (if sight.path.is_empty() { 0.0 } else { gained }, spent);
        };
        let step_m = (at - std::mem::replace(&mut self.at, at)).length();
        self.stands = f64::from(step_m) < STANDING_MPS_F64 * spent;
        while self.has_passed_corner(sight.path, at, sight.arrival_m) {
            self.corner += 1;
        }
        // A round begins again where the way that is left grows by most of it, however far beside the goal.
        let laps = sight.is_loop && sight.remaining_m > self.nearest.0 + 0.5 * path_length(sight.path);
        let is_there = laps || sight.has_settled && !sight.is_loop || self.has_reached_goal(sight, at);
        let left = self.remaining_length(sight, at);
        // A loop may have begun again; a route by other corners may be longer than the path.
        let left = if is_there { left.min(sight.remaining_m) } else { left };
        let mut gained = std::mem::replace(&mut self.remaining_m, left) - left;
        if sight.path.is_empty() && gained.abs() > 1.01 * step_m {
            // Nobody gains more than it walks: another round or leg has begun.
            gained = 0.0;
            self.nearest = (sight.remaining_m, time_s);
        }
        if (at - self.stayed_since.0).length() > STUCK_M {
            self.stayed_since = (at, time_s);
        }
        if sight.remaining_m < self.nearest.0 - STUCK_M {
            (self.nearest, self.waits_since_s) = ((sight.remaining_m, time_s), time_s);
        }
        if sight.waits && time_s - self.waits_since_s <= MOST_WAIT_S {
            // It gives way while it waits, and regains that ground later.
            self.stayed_since = (at, time_s);
            self.nearest = (self.nearest.0.max(sight.remaining_m), time_s);
        }
        self.is_stuck |= self.makes_no_progress(time_s);
        if is_there {
            if sight.is_loop {
                *self = Self { is_stuck: self.is_stuck, ..Self::start(sight, time_s) };
            } else {
                self.has_arrived = true;
            }
        }
        (gained, spent)
    }

    /// True if it makes no progress.
    fn makes_no_progress(&self, time_s: f64) -> bool {
        time_s - self.stayed_since.1 > STUCK_S || time_s - self.nearest.1 > JAMMED_S
    }

    /// True if the corner is behind: near, or beyond the plane through it across the next leg.
    fn has_passed_corner(&self, path: &[V], at: V, near_m: f32) -> bool {
        let (Some(&corner), Some(&next)) = (path.get(self.corner), path.get(self.corner + 1)) else { return false };
        let off = at - corner;
        off.length() <= near_m || off.dot(next - corner) > 0.0 && off.dot(corner - path[self.corner - 1]) > 0.0
    }

    /// True if it has arrived; it may have come by other corners than those of the path.
    fn has_reached_goal(&self, sight: &AgentSample<'_, V>, at: V) -> bool {
        let is_on_last =
            self.corner >= sight.path.len().saturating_sub(1) || !sight.is_loop && sight.remaining_m <= sight.arrival_m;
        is_on_last && sight.path.last().is_some_and(|&goal| (at - goal).length() <= sight.arrival_m)
    }

    /// Remaining length: to the corner, and from there along the path; on rounds that of the route (m).
    fn remaining_length(&self, sight: &AgentSample<'_, V>, at: V) -> f32 {
        match sight.path.get(self.corner) {
            Some(&corner) => (at - corner).length() + path_length(&sight.path[self.corner..]),
            None if sight.path.is_empty() => sight.remaining_m,
            None => 0.0,
        }
    }
}

/// Length of a path (m).
fn path_length<V: Space>(path: &[V]) -> f32 {
    path.windows(2).map(|l| (l[1] - l[0]).length()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    const WAY: [Vec2; 3] = [Vec2::ZERO, Vec2::new(10.0, 0.0), Vec2::new(10.0, 10.0)];

    fn sight(at: Option<Vec2>, again: bool) -> AgentSample<'static, Vec2> {
        let left_m = at.map_or(0.0, |p| (10.0 - p.x).max(0.0) + 10.0 - p.y);
        AgentSample {
            at,
            path: &WAY,
            path_number: 0,
            remaining_m: left_m,
            arrival_m: 0.5,
            is_loop: again,
            has_settled: false,
            waits: false,
        }
    }

    /// Position after a distance along the path (m).
    fn along(s: f32) -> Vec2 {
        if s < 10.0 { Vec2::new(s, 0.0) } else { Vec2::new(10.0, (s - 10.0).min(10.0)) }
    }

    #[test]
    fn rounds_that_pass_beside_their_end_are_no_standstill() {
        let mut meter = ProgressMeter::default();
        for i in 0..=1800 {
            let t = f64::from(i) / 30.0;
            // It walks rounds of 20 m, two metres beside the path.
            let s = (1.3 * t as f32) % 20.0;
            let round = AgentSample { remaining_m: 20.0 - s, ..sight(Some(along(s) + Vec2::new(2.0, -2.0)), true) };
            meter.observe(t, std::iter::once(round));
        }
        assert_eq!((meter.stuck(), meter.arrived()), (0, 0));
    }

    #[test]
    fn an_agent_progresses_at_its_speed_until_it_arrives() {
        for leaves in [false, true] {
            let mut meter = ProgressMeter::default();
            for i in 0..=600 {
                let t = f64::from(i) / 30.0;
                let at = along(1.3 * t as f32);
                let gone = leaves && at.y > 9.9;
                meter.observe(t, [sight((!gone).then_some(at), false)].into_iter());
            }
            assert!((meter.progress_mps() - 1.3).abs() < 0.02, "{}", meter.progress_mps());
            assert_eq!((meter.arrived(), meter.stuck(), meter.reached(), meter.stopped_share()), (1, 0, 1.0, 0.0));
        }
    }

    #[test]
    fn who_enters_later_has_neither_arrived_nor_gained_anything_before() {
        let mut meter = ProgressMeter::default();
        for i in 0..=480 {
            let t = f64::from(i) / 30.0 - 8.0;
            let at = (t >= 0.0).then(|| along(1.3 * t as f32));
            let enters = AgentSample { path_number: u32::from(t >= 0.5), ..sight(at, false) };
            meter.observe(t + 8.0, [enters, sight(None, false)].into_iter());
            assert_eq!((meter.arrived(), meter.stuck()), (0, 0), "after {t} s");
        }
        let by_10s = meter.progress_by_10s_mps();
        assert!(by_10s.iter().all(|mps| (mps - 1.3).abs() < 0.05), "{by_10s:?}");
    }

    #[test]
    fn an_agent_that_stays_or_trembles_is_stuck_after_ten_seconds() {
        for seconds in [9, 11] {
            let mut meter = ProgressMeter::default();
            for i in 0..=seconds * 30 {
                let t = f64::from(i) / 30.0;
                let still = sight(Some(Vec2::new(4.0, 0.0)), false);
                let trembles = sight(Some(Vec2::new(4.0, 0.2 * (i % 3) as f32)), false);
                let walks = sight(Some(Vec2::new(0.1 * t as f32, 0.0)), false);
                meter.observe(t, [still, trembles, walks].into_iter());
            }
            assert_eq!(meter.stuck(), if seconds > 10 { 2 } else { 0 });
            assert_eq!((meter.arrived(), meter.reached()), (0, 0.0));
            // One stands, one creeps, and one trembles.
            assert!((meter.stopped_share() - 2.0 / 3.0).abs() < 0.01, "{}", meter.stopped_share());
        }
    }

    #[test]
    fn who_has_settled_or_waits_for_a_turn_of_usual_length_is_not_stuck() {
        let still = sight(Some(Vec2::new(4.0, 0.0)), false);
        for (seconds, num) in [(50, 1), (75, 2)] {
            let mut meter = ProgressMeter::default();
            for i in 0..=seconds * 30 {
                let all = [AgentSample { has_settled: true, ..still }, AgentSample { waits: true, ..still }, still];
                meter.observe(f64::from(i) / 30.0, all.into_iter());
            }
            let stuck = [meter.stuck(), meter.stuck_at(f64::from(seconds)), meter.arrived()];
            assert_eq!(stuck, [num, num, 1], "after {seconds} s");
        }
    }

    #[test]
    fn who_waits_on_and_off_for_minutes_is_stuck_and_who_leaves_elsewhere_has_not_come_there() {
        let mut meter = ProgressMeter::default();
        for i in 0..=100 * 30 {
            let waits = AgentSample { waits: i / 30 % 50 != 0, ..sight(Some(Vec2::new(4.0, 0.0)), false) };
            meter.observe(f64::from(i) / 30.0, std::iter::once(waits));
        }
        assert_eq!(meter.stuck(), 1);
        let mut meter = ProgressMeter::default();
        let path = [Vec2::ZERO, Vec2::new(30.0, 0.0)];
        for i in 0..=30 {
            let at = (i < 30).then(|| Vec2::new(0.1, 0.0));
            let leaves = AgentSample { path: &path, remaining_m: 29.9, ..sight(at, false) };
            meter.observe(f64::from(i) / 30.0, std::iter::once(leaves));
        }
        assert!(meter.progress_mps() < 1.4, "{} m/s of one that never walked", meter.progress_mps());
    }

    #[test]
    fn an_agent_that_walks_about_without_coming_nearer_is_stuck_after_twenty_seconds() {
        for seconds in [19, 21] {
            let mut meter = ProgressMeter::default();
            for i in 0..=seconds * 30 {
                let t = f64::from(i) / 30.0;
                let walks = sight(Some(Vec2::new(4.0 + 0.4 * (t as f32).sin(), 2.0 * (0.3 * t as f32).cos())), false);
                // Around a wall on its own route, away from the goal at first.
                let round = AgentSample {
                    remaining_m: 60.0 - t as f32,
                    ..sight(Some(Vec2::new(4.0 - 0.2 * t as f32, 0.0)), false)
                };
                meter.observe(t, [walks, round].into_iter());
            }
            let num = usize::from(seconds > 20);
            assert_eq!((meter.stuck(), meter.stuck_at(f64::from(seconds))), (num, num), "after {seconds} s");
        }
    }

    #[test]
    fn an_agent_that_takes_other_corners_arrives() {
        let mut meter = ProgressMeter::default();
        let off = |p: Vec2| Vec2::new(p.y, p.x);
        for i in 0..=1000 {
            let t = f64::from(i) / 30.0;
            let at = off(along(1.3 * t as f32));
            let left_m = (10.0 - at.y).max(0.0) + 10.0 - at.x;
            meter.observe(t, [AgentSample { remaining_m: left_m, ..sight(Some(at), false) }].into_iter());
        }
        assert!((meter.progress_mps() - 1.3).abs() < 0.02, "{}", meter.progress_mps());
        assert_eq!((meter.arrived(), meter.stuck()), (1, 0));
    }

    #[test]
    fn progress_on_rounds_is_that_along_them_and_people_without_a_goal_are_left_out() {
        let mut meter = ProgressMeter::default();
        for i in 0..=1800 {
            let t = f64::from(i) / 30.0;
            let round = |speed: f64, radius: f32| {
                let s = (speed * t) as f32;
                let at = radius * Vec2::new((s / radius).cos(), (s / radius).sin());
                // A round of 30 m, begun anew whenever it is over.
                AgentSample { path: &[], remaining_m: 30.0 - s % 30.0, ..sight(Some(at), false) }
            };
            let still = Vec2::new(5.0, 5.0);
            let idle =
                AgentSample { path: std::slice::from_ref(&still), remaining_m: 0.0, ..sight(Some(still), false) };
            meter.observe(t, [round(1.2, 4.8), round(0.8, 4.8), idle].into_iter());
        }
        // 1.2 and 0.8 m/s; the sample in which a round begins gains nothing: 2 and 1 of them in 1800.
        assert!((meter.progress_mps() - 1.0).abs() < 0.002, "{}", meter.progress_mps());
        assert_eq!((meter.arrived(), meter.stuck(), meter.stopped_share()), (1, 0, 0.0));
    }

    #[test]
    fn who_stands_on_a_round_is_stuck() {
        let mut meter = ProgressMeter::default();
        for i in 0..=330 {
            let still = AgentSample { path: &[], remaining_m: 12.0, ..sight(Some(Vec2::new(4.0, 0.0)), false) };
            meter.observe(f64::from(i) / 30.0, std::iter::once(still));
        }
        assert_eq!((meter.stuck(), meter.progress_mps()), (1, 0.0));
    }

    #[test]
    fn a_way_that_begins_again_goes_on_counting() {
        let mut meter = ProgressMeter::default();
        for i in 0..=900 {
            let t = f64::from(i) / 30.0;
            meter.observe(t, [sight(Some(along(1.0 * t as f32 % 19.6)), true)].into_iter());
        }
        assert!(meter.arrived() == 0 && (meter.progress_mps() - 1.0).abs() < 0.05, "{}", meter.progress_mps());
    }
}
