//! What does each kind of work cost in instructions? `scripts/cost.py` counts them.
//!
//! A case sets up its work, and does it within [`counted_region`], on one thread and without a clock. Every number comes
//! from a fixed seed, so that a case executes the same instructions in every run.
//!
//! ```sh
//! cargo run --profile bench --features cost --bin cost                              # bakes, and runs each case for a moment
//! cargo run --profile bench --features cost --bin cost -- --bake DIR                # bakes the bundles into a folder
//! cargo run --profile bench --features cost --bin cost -- --bundles DIR --case NAME # runs one case on them
//! ```

use glam::{Vec2, Vec3};
use std::error::Error;
use std::path::Path;
use throng_core::characters::{AvoidConfig, CharactersConfig, Detail, PolicyCharacters, PolicyOrder, Spawn};
use throng_core::policy::{BestActionJob, LookAheadGoal, LookAheadJob, RankedActions};
use throng_core::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_core::{Bundle, CharacterGroup, Inline, Planar};
use throng_crowd::{Agent, AgentOrder, AtEnd, Crowd, CrowdConfig, CrowdSetup};
use throng_precompute::cache::Cache;
use throng_precompute::config::BuildConfig;
use throng_precompute::pipeline;
use throng_precompute::progress::Silent;
use throng_simulation::sparring::{Sparring, SparringConfig};
use throng_simulation::{Scene, Simulation};

/// Configs of the bundles: names of files, and what is baked into them.
const BUNDLES: [(&str, &str); 3] = [
    (
        "walk",
        r#"
name = "walk"
[synth]
set = "walk"
minutes = 0.5
[[behaviours]]
name = "approach"
"#,
    ),
    (
        "boxing",
        r#"
name = "boxing"
[synth]
set = "boxing"
minutes = 0.3
[annotate.hits.punches]
swing_speed = 4.0
[[behaviours]]
name = "approach"
kind = "approach"
centre = "hits"
grid = { rings = 5, angles = 13, radius = 2.0, inner_spacing = 0.5 }
[[behaviours]]
name = "throw-punches"
kind = "throw_punches"
[[behaviours]]
name = "evade"
kind = "evade"
"#,
    ),
    (
        "locomotion",
        r#"
name = "locomotion"
synth = { set = "locomotion", minutes = 5.0 }
behaviours = []
[resample]
rate_hz = 60.0
mirror = false
[annotate.ends]
still = false
[graph]
enabled = false
[blend.ahead]
axes = [{ kind = "speed" }, { kind = "gyration" }]
examples = [
  { clip = "idle_neutral", still = true },
  { clip = "walk_neutral_v070_*" },
  { clip = "walk_neutral_v150_*" },
  { clip = "jog_neutral_v270_*" },
]
"#,
    ),
];

/// A scene whose people only think: each has a timer, at which eleven conditions are false and the last one is true.
const RULES: &str = r#"
seconds = 60.0

[[groups]]
name = "thinkers"
motion = "none"
count = 60
place = { block = { from = [-30.0, -30.0], to = [30.0, 30.0] } }
graph = "think"

[values.mood]
start = [0.2, 0.8]

[values.hunger]
start = [0.0, 0.5]

[[places]]
name = "bakery"
kind = "store"
at = [40.0, 40.0]
radius_m = 2.0

[[events]]
name = "sale"

[graphs.think]
level = "social"
start = "stand"
[graphs.think.states]
stand = { do = [{ stay = 1000 }] }

[[rules]]
on = "starts"
do = [{ timer = "0.1 + 0.1 * random" }]

[[rules]]
on = "timer"
when = "me.mood > 2"
do = [{ add = "mood", by = 0.1 }]
[[rules]]
on = "timer"
when = "me.hunger > 0.9 and distance(me, 'bakery') < 30"
do = [{ go = "bakery" }]
[[rules]]
on = "timer"
when = "'sale' in me.news and me.hunger > 0.1"
do = [{ go = "bakery" }]
[[rules]]
on = "timer"
when = "distance(me, 'bakery') < 2 + 3 * me.mood"
do = [{ go = "bakery" }]
[[rules]]
on = "timer"
when = "me.state != 'stand' or me.speed > 1 + me.hunger"
do = [{ stay = 1 }]
[[rules]]
on = "timer"
when = "free('bakery') > 2 and me.mood < 0.5"
do = [{ stay = 1 }]
[[rules]]
on = "timer"
when = "min(me.mood, me.hunger) + max(me.mood, me.hunger) > 3"
do = [{ stay = 1 }]
[[rules]]
on = "timer"
when = "sqrt(me.x * me.x + me.z * me.z) > 100"
do = [{ stay = 1 }]
[[rules]]
on = "timer"
when = "curiosity(me, 'bakery') > 0.5 and time > 10"
do = [{ go = "bakery" }]
[[rules]]
on = "timer"
when = "me.group in { 'thinkers' } and me.mood > 3"
do = [{ stay = 1 }]
[[rules]]
on = "timer"
when = "abs(me.mood - me.hunger) > 1 and not me.busy"
do = [{ stay = 1 }]
[[rules]]
on = "timer"
when = "me.mood >= 0"
do = [
    { set = "mood", to = "clamp(me.mood + 0.1 * (random - 0.5), 0, 1)" },
    { timer = "0.1 + 0.1 * random" },
]
"#;

/// A simulated step (s).
const DT_S: f32 = 1.0 / 60.0;
/// Characters and walkers of a case.
const NUM_PEOPLE: usize = 64;

/// A value, or any error.
type Outcome<T> = Result<T, Box<dyn Error>>;

/// Work that is counted.
struct Case {
    name: &'static str,
    /// What its instructions are divided by.
    unit: &'static str,
    /// Sets up, does the work within [`counted_region`], and returns the number of units that were done.
    run: fn(&Input<'_>) -> Outcome<u64>,
}

/// Where a case finds its bundles, and how long it lasts.
struct Input<'a> {
    bundles: &'a Path,
    /// Steps of bodies that are counted; other work grows with it. Before them, half as many again are done.
    num_steps: usize,
}

impl Input<'_> {
    fn open(&self, name: &str) -> Outcome<Bundle> {
        Ok(Bundle::open(self.bundles.join(name).with_extension("throng"))?)
    }

    /// Steps until everybody is at it (at least 1).
    fn num_before(&self) -> usize {
        self.num_steps / 2 + 1
    }
}

const CASES: [Case; 8] = [
    Case { name: "characters", unit: "character and step", run: characters },
    Case { name: "best_action", unit: "query", run: best_action },
    Case { name: "look_ahead", unit: "query", run: look_ahead },
    Case { name: "avoid", unit: "choice", run: avoid },
    Case { name: "walkers", unit: "walker and step", run: walkers },
    Case { name: "crowd", unit: "event", run: crowd },
    Case { name: "rules", unit: "evaluation", run: rules },
    Case { name: "sparring", unit: "boxer and step", run: sparring },
];

/// The work whose instructions are counted. `scripts/cost.py` knows this function by its name.
#[inline(never)]
fn counted_region(work: &mut dyn FnMut() -> Outcome<()>) -> Outcome<()> {
    std::hint::black_box(work)()
}

fn main() -> Outcome<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match &args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => {
            let folder = tempfile::tempdir()?;
            bake(folder.path())?;
            let input = Input { bundles: folder.path(), num_steps: 30 };
            CASES.iter().try_for_each(|case| report(case, &input))
        }
        ["--bake", folder] => bake(folder.as_ref()),
        ["--bundles", folder, "--case", name] => {
            let case = CASES.iter().find(|case| case.name == *name).ok_or("no case of this name; `--list` has them")?;
            report(case, &Input { bundles: folder.as_ref(), num_steps: 120 })
        }
        ["--list"] => {
            CASES.iter().for_each(|case| println!("{}", case.name));
            Ok(())
        }
        _ => Err("expected nothing, `--list`, `--bake DIR`, or `--bundles DIR --case NAME`".into()),
    }
}

/// Runs a case and prints one line: its name, the number of units and what they are.
fn report(case: &Case, input: &Input<'_>) -> Outcome<()> {
    let num_units = (case.run)(input)?;
    if num_units == 0 {
        return Err(format!("{}: nothing was done", case.name).into());
    }
    println!("{}\t{num_units}\t{}", case.name, case.unit);
    Ok(())
}

fn bake(folder: &Path) -> Outcome<()> {
    for (name, config) in BUNDLES {
        let config = BuildConfig::parse(config, &folder.join(name).with_extension("toml"))?;
        pipeline::build(&config, &folder.join(name).with_extension("throng"), &Cache::disabled(), &Silent)?;
    }
    Ok(())
}

/// Characters that walk to targets of their own and take no notice of each other: choice, motion, feet and poses.
fn characters(input: &Input<'_>) -> Outcome<u64> {
    let mut people = policy_characters(input, CharactersConfig::default())?;
    step(&mut people, input.num_before())?;
    counted_region(&mut || step(&mut people, input.num_steps))?;
    Ok((NUM_PEOPLE * input.num_steps) as u64)
}

/// Characters that avoid each other, without poses: what is left is mostly their choices.
fn avoid(input: &Input<'_>) -> Outcome<u64> {
    let config = CharactersConfig { avoid: Some(AvoidConfig::default()), ..CharactersConfig::default() };
    let mut people = policy_characters(input, config)?;
    people.set_detail(Some(Detail::RECORDS))?;
    step(&mut people, input.num_before())?;
    let count = |people: &PolicyCharacters| {
        (0..NUM_PEOPLE).map(|row| u64::from(people.characters().num_choices(row))).sum::<u64>()
    };
    let before = count(&people);
    // Each chooses about once a second.
    counted_region(&mut || step(&mut people, 8 * input.num_steps))?;
    Ok(count(&people) - before)
}

/// Characters on a square, two metres apart, each of whom is sent through the middle to the other side.
fn policy_characters(input: &Input<'_>, config: CharactersConfig) -> Outcome<PolicyCharacters> {
    let bundle = input.open("walk")?;
    let approach = bundle.policy("approach")?;
    let mut random = Random(1);
    let mut people = PolicyCharacters::with_capacity(&bundle, NUM_PEOPLE, config)?;
    for i in 0..NUM_PEOPLE {
        let place = on_square(i, NUM_PEOPLE, 2.0);
        let heading = random.between(-3.0, 3.0);
        let id = people.spawn(Spawn::standing_at(Planar::new(place.x, place.y, heading)))?;
        people.order(id, approach.order_towards(Vec3::new(-place.x, 0.0, -place.y)))?;
    }
    Ok(people)
}

/// The stored best action of a state and a target.
fn best_action(input: &Input<'_>) -> Outcome<u64> {
    let bundle = input.open("walk")?;
    let (states, targets) = queries(&bundle, 64 * input.num_steps);
    let mut actions = vec![0; states.len()];
    counted_region(&mut || {
        let policy = &bundle.policies()[0];
        let actions = &mut actions;
        Ok(BestActionJob { policy, states: &states, targets: &targets, choice: 0, actions }.run()?)
    })?;
    Ok(states.len() as u64)
}

/// All actions of a state, weighed for a target.
fn look_ahead(input: &Input<'_>) -> Outcome<u64> {
    let bundle = input.open("walk")?;
    let (states, targets) = queries(&bundle, 16 * input.num_steps);
    let mut ranked = vec![RankedActions::NONE; states.len()];
    let weights = vec![1.0; states.len()];
    counted_region(&mut || {
        let goals = [LookAheadGoal { policy: &bundle.policies()[0], weights: &weights, targets: &targets }];
        Ok(LookAheadJob { goals: &goals, states: &states, ranked: &mut ranked }.run()?)
    })?;
    Ok(states.len() as u64)
}

/// States and targets at random: no query follows from the one before.
fn queries(bundle: &Bundle, count: usize) -> (Vec<u32>, Vec<Vec3>) {
    let mut random = Random(2);
    let num_states = bundle.graph().states.len();
    (0..count)
        .map(|_| {
            let state = (random.next() % num_states as u64) as u32;
            (state, Vec3::new(random.between(-6.0, 6.0), 0.0, random.between(-6.0, 6.0)))
        })
        .unzip()
}

/// Walkers whose bodies are blended, and who turn while they walk.
fn walkers(input: &Input<'_>) -> Outcome<u64> {
    let bundle = input.open("locomotion")?;
    let mut random = Random(3);
    let mut walkers = Walkers::with_capacity(bundle.blend("ahead")?, &[], WalkersConfig::default(), NUM_PEOPLE)?;
    for i in 0..NUM_PEOPLE {
        let place = on_square(i, NUM_PEOPLE, 3.0);
        let start = WalkerStart { phase: random.between(0.0, 1.0), root: Planar::new(place.x, place.y, 0.0), body: 0 };
        let id = walkers.spawn(start)?;
        let turning_rate = Some(random.between(-0.5, 0.5));
        let control = Control::walk(Vec2::new(0.0, random.between(0.5, 2.5)));
        walkers.order(id, Control { turning_rate, ..control })?;
    }
    step(&mut walkers, input.num_before())?;
    counted_region(&mut || step(&mut walkers, input.num_steps))?;
    Ok((NUM_PEOPLE * input.num_steps) as u64)
}

/// Agents without bodies who go round in each other's way, event by event.
fn crowd(input: &Input<'_>) -> Outcome<u64> {
    let capacity = 4 * NUM_PEOPLE;
    let config = CrowdConfig { capacity, largest_radius_m: 0.3, largest_speed_mps: 2.0, ..CrowdConfig::default() };
    let mut crowd = Crowd::on_ground(CrowdSetup { config, ..CrowdSetup::default() })?;
    let mut random = Random(4);
    for i in 0..capacity {
        let place = on_square(i, capacity, 1.5);
        let at = |place: Vec2| Vec3::new(place.x, 0.0, place.y);
        let speed = random.between(0.9, 1.5);
        let id = crowd.spawn(Agent { speed, ..Agent::standing_at(at(place)) })?;
        crowd.order(id, AgentOrder::along_subgoals(vec![at(-place), at(place)]).then_at_end(AtEnd::Again))?;
    }
    let step_s = f64::from(DT_S);
    let begin_s = input.num_before() as f64 * step_s;
    crowd.advance(begin_s, &mut |_| ())?;
    let before = crowd.counts().decisions;
    counted_region(&mut || Ok(crowd.advance(begin_s + input.num_steps as f64 * step_s, &mut |_| ())?))?;
    Ok(crowd.counts().decisions - before)
}

/// Conditions and amounts of rules, with the events that ask for them.
fn rules(input: &Input<'_>) -> Outcome<u64> {
    let scene = Scene::parse(RULES, &input.bundles.join("rules.toml"))?.open()?;
    let mut simulation = Simulation::new(&scene)?;
    let step = |simulation: &mut Simulation, num_steps: usize| -> Outcome<()> {
        Ok((0..num_steps).try_for_each(|_| simulation.step(f64::from(DT_S)))?)
    };
    step(&mut simulation, input.num_before())?;
    let count = |simulation: &Simulation| simulation.brains().map_or(0, |brains| brains.evaluations());
    let before = count(&simulation);
    counted_region(&mut || step(&mut simulation, input.num_steps))?;
    Ok(count(&simulation) - before)
}

/// Pairs that strike at each other: choice, poses, blows, reactions, touch and parting.
fn sparring(input: &Input<'_>) -> Outcome<u64> {
    let num_pairs = 8;
    let mut sparring = Sparring::with_capacity(&input.open("boxing")?, num_pairs, SparringConfig::default())?;
    let order = (0..3).fold(PolicyOrder::IDLE, |order, policy| order.with_policy(policy, 1.0));
    for pair in 0..num_pairs {
        let middle = Planar::new(4.0 * pair as f32, 0.0, pair as f32);
        let sides = [Planar::new(0.0, -0.6, 0.0), Planar::new(0.0, 0.6, std::f32::consts::PI)];
        let first = sparring.spawn(sides.map(|side| Spawn::standing_at(middle.compose(side))))?;
        for id in [first, sparring.opponent(first)?] {
            sparring.order(id, order)?;
        }
    }
    step(&mut sparring, input.num_before())?;
    counted_region(&mut || step(&mut sparring, input.num_steps))?;
    Ok((2 * num_pairs * input.num_steps) as u64)
}

fn step(character_group: &mut impl CharacterGroup, num_steps: usize) -> Outcome<()> {
    Ok((0..num_steps).try_for_each(|_| character_group.step(DT_S, &Inline))?)
}

/// A point of a square grid around the origin: number and count of points, and the distance of neighbours.
fn on_square(number: usize, count: usize, spacing_m: f32) -> Vec2 {
    let columns = count.isqrt();
    let middle = 0.5 * (columns - 1) as f32;
    spacing_m * Vec2::new((number % columns) as f32 - middle, (number / columns) as f32 - middle)
}

/// Numbers at random: SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn between(&mut self, least: f32, most: f32) -> f32 {
        least + (most - least) * ((self.next() >> 40) as f32 / (1u64 << 24) as f32)
    }
}
