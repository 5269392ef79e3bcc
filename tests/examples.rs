//! Promise: the examples do what they say.

use std::path::PathBuf;
use throng_world::{PathCosts, WorldGraph, made_up_floor as made_up_world};

#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/agents_with_bodies.rs"]
mod agents_with_bodies;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/bake.rs"]
mod bake;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/blended_walkers.rs"]
mod blended_walkers;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/errors.rs"]
mod errors;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/hot_reload.rs"]
mod hot_reload;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/own_threads.rs"]
mod own_threads;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/patch_world.rs"]
mod patch_world;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/policy_characters.rs"]
mod policy_characters;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/query.rs"]
mod query;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/snapshot.rs"]
mod snapshot;
#[allow(dead_code, reason = "started by the tests, not by its own `main`")]
#[path = "../examples/sparring.rs"]
mod sparring;

use crate::common;
/// Blend space of the golden tables.
const SPACE: &str = "walks";

/// The golden tables of the current version: a policy and a blend space.
fn golden() -> PathBuf {
    let name = format!("data/golden/tables_v{}.throng", throng_core::format::VERSION);
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Writes files to a folder that goes when it is dropped.
fn written<const N: usize>(files: [(&str, &[u8]); N]) -> (tempfile::TempDir, [PathBuf; N]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paths = files.map(|(name, bytes)| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    });
    (folder, paths)
}

#[test]
fn bake_writes_a_bundle_that_opens() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("walk.throng");
    bake::run(&out).expect("the example bakes");
    throng_core::Bundle::open(&out).expect("what it baked opens");
}

#[test]
fn policies_are_asked_and_move_characters() {
    query::run(&golden()).expect("the example asks");
    policy_characters::run(&golden()).expect("the example walks");
}

#[test]
fn walkers_come_and_go_and_give_agents_bodies() {
    blended_walkers::run(&golden(), SPACE).expect("the example walks");
    agents_with_bodies::run(&golden(), SPACE).expect("the example goes round the corner");
}

#[test]
fn groups_are_saved_and_stepped_on_any_threads() {
    snapshot::run(&golden(), SPACE).expect("the example saves");
    own_threads::run(&golden(), SPACE).expect("the example agrees");
}

#[test]
fn bundles_are_replaced_and_mistakes_explained() {
    hot_reload::run(&golden(), SPACE).expect("the example adopts");
    errors::run(&golden(), SPACE).expect("the example makes mistakes");
}

#[test]
fn boxers_spar() {
    let (_folder, [bundle]) = written([("boxing.throng", common::boxing_bytes())]);
    sparring::run(&bundle).expect("the example spars");
}

#[test]
fn people_live_in_a_world() {
    let tables = made_up_world::tables();
    let mut world = Vec::new();
    let floor = made_up_world::world(&tables, &["#####"; 5]);
    let graph = WorldGraph::new(tables.patches(), &floor.tables()).expect("a graph");
    floor.write(&PathCosts::bake(&graph).expect("path costs"), &mut world).expect("a world");
    let files = [("floor.throng", &made_up_world::bundle("made up")[..]), ("floor.world", &world[..])];
    let (_folder, [bundle, world]) = written(files);
    patch_world::run(&bundle, &world).expect("the example lives");
}
