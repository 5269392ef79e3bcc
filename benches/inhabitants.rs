//! What does a world with 1000 characters on tiles cost, motion, control and poses, and what a path across a floor?
//! `cargo bench --bench inhabitants`.

use std::time::Instant;
use throng_runtime::world::inhabitants::{Inhabitants, InhabitantsConfig, Wish, scatter};
use throng_runtime::world::plan::{Planner, Target};
use throng_runtime::world::{Step, World, WorldGraph, made_up_floor as made_up};
use throng_runtime::{Cast, Inline};

const DT: f32 = 1.0 / 60.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test` runs benches too: a small crowd is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let (side, characters, steps) = if whole { (60, 1000, 6000) } else { (8, 20, 20) };
    let rows = vec!["#".repeat(side); side];
    let tables = made_up::tables();
    let world = made_up::world(&tables, &rows.iter().map(String::as_str).collect::<Vec<_>>());
    let world = World::from_data(&world, &tables)?;
    let graph = world.graph();
    let starts = scatter(graph, characters, 1);
    for commuting in [false, true] {
        let mut people = Inhabitants::new(&world, starts.len(), InhabitantsConfig::default())?;
        for (c, &start) in starts.iter().enumerate() {
            let (id, instance) = (people.spawn(start)?, (c * 7919 % graph.num_instances()) as u32);
            people.order(id, if commuting { Wish::GoTo { instance } } else { Wish::Roam })?;
        }
        let begin = Instant::now();
        for _ in 0..steps {
            people.step(DT, &Inline)?;
        }
        let per_second = steps as f64 / begin.elapsed().as_secs_f64();
        let what = if commuting { "go somewhere" } else { "roam" };
        println!("{characters} characters on {side} x {side} tiles {what}: {per_second:.0} steps/s on one core");
    }
    across(graph);
    Ok(())
}

/// A path from one corner to the other.
fn across(graph: &WorldGraph) {
    let mut planner = Planner::new(graph);
    let from = graph.rest_cells(0).next().expect("a place to stand");
    let target = Target::Rest { instance: graph.num_instances() as u32 - 1 };
    let mut steps = vec![Step::NONE; 1024];
    // The first one touches memory that later ones find.
    for _ in 0..2 {
        let begin = Instant::now();
        let plan = planner.plan(graph, from, target, &mut steps);
        println!("across: {:.3} ms, {plan:?}", begin.elapsed().as_secs_f64() * 1e3);
    }
}
