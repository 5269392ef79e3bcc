//! How much less work are events than fixed steps? The birds of Kim, Kim and Shin (2003b)'s first experiment: two flocks fly through each other
//! and around columns, 100 to 1000 of them, in all schemes. `cargo bench --bench birds [-- SCHEME...]`

use glam::Vec3;
use std::time::Instant;
use throng_precompute::run::own_scene;
use throng_runtime::crowd::{Agent, AtEnd, Crowd, CrowdConfig, CrowdError, Field, Id, Obstacle, Route, Scheme, Setup};

/// Metres in an inch.
const INCH: f32 = 0.0254;
/// Kim, Kim and Shin (2003b), section 4: length, height and width of the corridor.
const CORRIDOR: Vec3 = Vec3::new(6000.0 * INCH, 1000.0 * INCH, 1000.0 * INCH);
const RADIUS: f32 = 20.0 * INCH;
const SPEED: f32 = 200.0 * INCH;
const ACCELERATION: f32 = 500.0 * INCH;
const COLUMN: f32 = 50.0 * INCH;
/// From one bird to the next at the start (m).
const SPACING: f32 = 2.9;
/// Everybody is at the other end by then.
const FLIGHT_S: f64 = 32.0;

/// A scheme, and how often a step of it may be halved.
const RIVALS: [(&str, Scheme, f32, u32); 5] = [
    ("events", Scheme::Registration, 30.0, 0),
    ("occupancy", Scheme::Occupancy, 30.0, 0),
    ("fixed", Scheme::Fixed, 30.0, 4),
    ("fixed-never-undone", Scheme::Fixed, 30.0, 0),
    ("fixed-10-a-second", Scheme::Fixed, 10.0, 4),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // That of the scene, which says why.
    let field = own_scene("flock")?.ok_or("there is no scene of this name")?.agents.field;
    // `cargo test` runs benches too: a few birds are enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let chosen: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let sizes: &[usize] = if whole { &[100, 250, 500, 750, 1000] } else { &[24] };
    println!(
        "birds scheme                us/bird-s  ratio  decisions/bird-s  ratio  events/bird-s  undone/s  overlaps>1mm  deepest_m  mps"
    );
    for &n in sizes {
        let mut first = None;
        for (name, scheme, rate, halvings) in RIVALS {
            if chosen.is_empty() || chosen.iter().any(|c| c == name) {
                let config = CrowdConfig { scheme, step_s: 1.0 / rate, halvings, ..CrowdConfig::default() };
                let flight = fly(flocks(n, field, config), if whole { FLIGHT_S } else { 4.0 })?;
                let base = *first.get_or_insert((flight.cost_us, flight.decisions));
                flight.print(n, name, base);
            }
        }
    }
    Ok(())
}

/// Two flocks at opposite ends of the corridor, each of which flies to the other end.
fn flocks(n: usize, field: Field, config: CrowdConfig) -> Setup {
    let mut setup = Setup { fields: vec![field], config, ..Setup::default() };
    let per_row = ((CORRIDOR.y - 2.0) / SPACING) as usize;
    for i in 0..n {
        let (sign, k) = (if i % 2 == 0 { 1.0 } else { -1.0 }, i / 2);
        // Rows are shifted, as birds do not fly on a grid.
        let sway = |k: usize| 0.7 * ((k * 37 % 11) as f32 / 11.0 - 0.5);
        let layer = (k / (per_row * per_row)) as f32;
        let x = -sign * (0.5 * CORRIDOR.x - 3.0 - SPACING * layer + sway(k));
        let y = 1.5 + SPACING * (k % per_row) as f32 + sway(k + 3);
        let z = 1.5 + SPACING * (k / per_row % per_row) as f32 + sway(k + 7);
        let goal = Vec3::new(sign * 0.5 * CORRIDOR.x, y, z);
        setup.routes.push(Route { subgoals: vec![goal], arrival_radius: 3.0, at_end: AtEnd::Leave });
        setup.agents.push(Agent {
            position: Vec3::new(x, y, z),
            velocity: Vec3::X * (sign * SPEED),
            radius: RADIUS,
            acceleration: ACCELERATION,
            speed: SPEED,
            route: Some(i),
            field: 0,
        });
    }
    for k in 0..8 {
        let (x, z) = ((k / 2) as f32 * 18.0 - 27.0, if k % 2 == 0 { 0.3 } else { 0.7 } * CORRIDOR.z);
        let (from, to) = (Vec3::new(x, 0.0, z), Vec3::new(x, CORRIDOR.y, z));
        setup.obstacles.push(Obstacle::Wall { from, to, radius: COLUMN });
    }
    let (far, thick) = (CORRIDOR.x, 1.0);
    for (min, max) in [
        (Vec3::new(-far, -thick, -thick), Vec3::new(far, 0.0, CORRIDOR.z + thick)),
        (Vec3::new(-far, CORRIDOR.y, -thick), Vec3::new(far, CORRIDOR.y + thick, CORRIDOR.z + thick)),
        (Vec3::new(-far, 0.0, -thick), Vec3::new(far, CORRIDOR.y, 0.0)),
        (Vec3::new(-far, 0.0, CORRIDOR.z), Vec3::new(far, CORRIDOR.y, CORRIDOR.z + thick)),
    ] {
        setup.obstacles.push(Obstacle::Box { min, max });
    }
    setup
}

/// What a flight cost, for each bird and second that it was in the air.
struct Flight {
    cost_us: f64,
    decisions: f64,
    events: f64,
    undone_per_s: f64,
    overlaps: f64,
    deepest_m: f32,
    progress_mps: f64,
}

impl Flight {
    fn print(&self, n: usize, name: &str, base: (f64, f64)) {
        println!(
            "{n:5} {name:20} {:10.2} {:6.2} {:17.2} {:6.2} {:14.2} {:9.1} {:13.5} {:10.4} {:4.2}",
            self.cost_us,
            self.cost_us / base.0,
            self.decisions,
            self.decisions / base.1,
            self.events,
            self.undone_per_s,
            self.overlaps,
            self.deepest_m,
            self.progress_mps,
        );
    }
}

/// Flies twice: once on the clock, once watched at 30 Hz. Both end alike.
fn fly(setup: Setup, until: f64) -> Result<Flight, CrowdError> {
    let mut crowd = Crowd::in_air(setup.clone())?;
    let mut watched = crowd.clone();
    let begin = clock_s();
    crowd.advance(until, &mut |_| ())?;
    let cost_s = clock_s() - begin;

    let (mut air_s, mut way, mut overlaps, mut frames, mut deepest) = (0.0, 0.0f64, 0usize, 0usize, 0.0f32);
    let mut before: Vec<Option<f32>> = watched.ids().map(|id| watched.way_left(id)).collect();
    for frame in 1..=(until * 30.0) as usize {
        let time = frame as f64 / 30.0;
        watched.advance(time, &mut |_| ())?;
        let birds: Vec<(Id, Vec3)> = watched.ids().filter_map(|id| Some((id, watched.position(id, time)?))).collect();
        for (n, &(id, x)) in birds.iter().enumerate() {
            let left = watched.way_left(id);
            if let (Some(old), Some(new)) = (before[id.index()], left) {
                way += f64::from(old - new);
            }
            before[id.index()] = left;
            for (_, y) in &birds[..n] {
                let depth = 2.0 * RADIUS - x.distance(*y);
                overlaps += usize::from(depth > 1e-3);
                deepest = deepest.max(depth);
            }
        }
        frames += birds.len();
        air_s += birds.len() as f64 / 30.0;
    }
    watched.advance(until, &mut |_| ())?;
    assert_eq!(crowd.hash(), watched.hash(), "the watched crowd ends in another state");
    let c = crowd.counts();
    let events = c.resetting + c.colliding + c.meeting + c.entering + c.leaving + c.contacting + c.separating;
    Ok(Flight {
        cost_us: cost_s * 1e6 / air_s,
        decisions: c.decisions as f64 / air_s,
        events: events as f64 / air_s,
        undone_per_s: c.undone as f64 / until,
        overlaps: overlaps as f64 / frames as f64,
        deepest_m: deepest,
        progress_mps: way / air_s,
    })
}

/// Time that this thread was running where the system tells it, and otherwise time that passes (s).
fn clock_s() -> f64 {
    let ran = std::fs::read_to_string("/proc/thread-self/schedstat");
    let ns = ran.ok().and_then(|s| s.split(' ').next().and_then(|n| n.parse::<f64>().ok()));
    static BEGIN: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    ns.map_or_else(|| BEGIN.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| ns * 1e-9)
}
