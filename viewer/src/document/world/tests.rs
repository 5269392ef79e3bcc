//! A small world: opened, lived in, edited, saved.

use super::*;
use crate::document::background::Background;
use crate::fixtures::quietly;
use crate::fixtures::square::Square;
use crate::render::Ray;
use std::path::Path;
use std::sync::mpsc::channel;
use throng_core::patch::Placement;
use throng_world::inhabitants::InhabitantActivity;

fn panel(x: i32, z: i32) -> Placement {
    Placement::new(2.8 * x as f32, 0.0, 2.8 * z as f32, 0.0)
}

fn run_for(world: &mut WorldDocument, steps: u32) {
    (0..steps).for_each(|_| world.step().unwrap());
}

/// Carries out an order and waits for it; returns the place that came or was moved.
fn order(world: &mut WorldDocument, order: EditorOrder) -> Result<Option<usize>, String> {
    world.order(order).unwrap();
    match world.adopt_edit(true) {
        Some(EditStatus::Changed(place)) => Ok(place),
        Some(EditStatus::Begun) => panic!("other characters were not asked for"),
        Some(EditStatus::Refused) => Err(world.refused.as_ref().unwrap().reason.clone()),
        None => panic!("nothing came of {order:?}"),
    }
}

fn edit(world: &mut WorldDocument, change: UnitChange) -> Result<Option<usize>, String> {
    order(world, EditorOrder::Change(change))
}

/// Places that many new inhabitants; until then the old ones stay.
fn populate(world: &mut WorldDocument, characters: usize, seed: u64) {
    let (before, now) = (world.run.num_characters(), world.run.reel.head.shown_step());
    world.populate(SceneChoice { characters, seed, ..SceneChoice::default() }).unwrap();
    assert!(world.working.as_ref().is_some_and(|w| w.doing.contains("room for") && w.place().is_none()));
    world.step().unwrap();
    let one = SceneChoice { characters: 1, ..SceneChoice::default() };
    let why = [world.populate(one), world.order(EditorOrder::Change(UnitChange::Remove { place: 0 }))]
        .map(Result::unwrap_err);
    assert!(why.iter().all(|w| w.contains("room for characters") && !w.contains("edit")), "{why:?}");
    assert_eq!((world.run.num_characters(), world.run.reel.head.shown_step()), (before, now));
    assert_eq!(world.adopt_edit(true), Some(EditStatus::Begun));
    assert_eq!((world.choice.characters, world.choice.seed), (world.run.num_characters(), seed));
    assert_eq!(world.run.reel.head.shown_step(), 0);
}

/// All hips lie over a panel.
fn all_are_on_panels(world: &WorldDocument) -> bool {
    (0..world.run.num_characters()).all(|c| {
        let hips = world.run.hips(c);
        let panels = world.placed().iter().filter(|p| world.unit(p.unit).floor);
        panels.map(|p| p.placement.inverse_transform_point(hips)).any(|p| p.x.abs().max(p.z.abs()) < 1.7)
    })
}

#[test]
fn a_world_is_populated_edited_and_saved() {
    let square = Square::new();
    let mut world = quietly(|with| WorldDocument::open(&square.world(3), with)).unwrap();
    assert_eq!((world.placed().len(), world.graph().num_instances()), (10, 9));
    assert!(world.run.num_characters() >= 2);
    lives(&mut world);
    is_picked(&world);
    edits(&mut world);
    takes_back(&mut world);
    works_meanwhile(&mut world);
    saves(&world, square.folder());
    survives_its_threads(&mut world);
    // As many as there is room for.
    let mut world = quietly(|with| WorldDocument::open(&square.world(3), with)).unwrap();
    populate(&mut world, 500, 3);
    assert!((3..=9).contains(&world.run.num_characters()), "{}", world.run.num_characters());
}

fn lives(world: &mut WorldDocument) {
    populate(world, 2, 1);
    let mut seen = vec![world.run.reel.moment().poses.clone()];
    for _ in 0..200 {
        world.step().unwrap();
        seen.push(world.run.reel.moment().poses.clone());
    }
    for step in [200, 0, 77, 199] {
        world.run.reel.head.seek(step);
        assert_eq!(world.run.reel.head.shown_step(), step);
        assert!(world.run.reel.moment().poses == seen[step as usize]);
    }
    assert!(!world.run.reel.head.is_live() && all_are_on_panels(world));
    // An order is given at the last step.
    let place = panel(2, 2).translation();
    let goal = InhabitantGoal::GoNear { place, within_m: 5.0 };
    world.give_order(0, Some(goal)).unwrap();
    assert!(world.run.reel.head.is_live() && world.run.reel.head.shown_step() == 200);
    for _ in 0..180 {
        run_for(world, 60);
        if world.run.reel.moment().states[0].activity == InhabitantActivity::Arrived {
            break;
        }
    }
    let (state, hips) = (world.run.reel.moment().states[0], world.run.hips(0));
    let plan = world.run.inhabitants.last_plan(world.run.id(0));
    assert_eq!(state.activity, InhabitantActivity::Arrived, "{state:?} at {hips}: {plan:?}");
    assert!((hips - place).with_y(0.0).length() < 1.4, "{hips}");
    assert_eq!(world.run.order_of(0), Some(goal));
    world.give_order(0, None).unwrap();
    assert_eq!(world.run.order_of(0), None);
    assert!(world.give_order(7, None).is_err());
    assert!(world.give_order(0, Some(InhabitantGoal::Perform { tag: 900, seconds: 1.0 })).is_err());
}

fn is_picked(world: &WorldDocument) {
    let down = |x: f32, z: f32| Ray { origin: Vec3::new(x, 9.0, z), direction: -Vec3::Y };
    let found = |x, z| world.pick(&down(x, z)).unwrap();
    let (place, met) = found(2.8, 5.6);
    assert_eq!(world.placed()[place.unwrap()].placement, panel(1, 2));
    assert!(met.y.abs() < 1e-4);
    let (place, met) = found(-2.2, 0.0);
    assert_eq!(world.unit(world.placed()[place.unwrap()].unit).name, "post");
    assert!(met.y > 1.0, "{met}");
    assert_eq!(found(-9.0, -9.0).0, None);
    assert_eq!(world.pick(&Ray { direction: Vec3::Y, ..down(0.0, 0.0) }), None);
}

fn edits(world: &mut WorldDocument) {
    let left = |world: &WorldDocument| world.report.transitions;
    let before = left(world);
    // One more panel at the side.
    let place = edit(world, UnitChange::Add { unit: 0, at: panel(3, 1) }).unwrap().unwrap();
    assert_eq!((world.placed()[place].placement, world.revision), (panel(3, 1), 1));
    assert!(left(world) > before && all_are_on_panels(world) && world.run.num_characters() == 2);
    let edited = world.edited.as_ref().unwrap();
    assert!(
        edited.description == "added ground" && edited.total_s >= edited.stitch_s && edited.num_lost == 0,
        "{edited:?}"
    );
    // A post in its middle takes motion away, which is said of its links; moved away, it gives them back.
    let with_panel = left(world);
    edit(world, UnitChange::Move { place: 9, to: panel(3, 1) }).unwrap();
    assert!(left(world) < with_panel);
    let instance = world.instances_of(place)[0];
    let links = 0..world.graph().links(instance).len() as u32;
    let hit = |l: &u32| world.reason(instance, InstanceItem::Link(*l)) == Some(RemovalReason::Obstacle);
    let link = links.clone().find(hit).unwrap();
    let why = world.full_reason(instance, InstanceItem::Link(link)).unwrap();
    assert!(why.message.contains("post") && why.reason == RemovalReason::Obstacle, "{}", why.message);
    edit(world, UnitChange::Move { place: 9, to: Placement::new(-2.2, 0.0, 0.0, 0.35) }).unwrap();
    assert_eq!(left(world), with_panel);
    // What cannot be leaves the world alone.
    let same = |world: &WorldDocument| (world.environment.clone(), left(world), world.revision);
    let kept = same(world);
    let why = edit(world, UnitChange::Move { place, to: Placement::new(50.0, 0.0, 50.0, 0.0) }).unwrap_err();
    assert!(why.contains("ground") && same(world) == kept, "{why}");
    assert!(edit(world, UnitChange::Remove { place: 99 }).is_err() && same(world) == kept);
    edit(world, UnitChange::Remove { place }).unwrap();
    assert_eq!(left(world), before);
    run_for(world, 60);
    assert!(all_are_on_panels(world));
}

fn takes_back(world: &mut WorldDocument) {
    let stands = |world: &WorldDocument| world.placed().to_vec();
    let (before, seven) = (stands(world), Placement::new(-2.2, 0.0, 7.0, 0.0));
    assert_eq!(world.to_undo(), Some("removed ground"));
    edit(world, UnitChange::Move { place: 9, to: seven }).unwrap();
    let moved = stands(world);
    // The place of an undone change is reported; with nothing to undo, nothing happens.
    assert_eq!(order(world, EditorOrder::Undo), Ok(Some(9)));
    assert!(stands(world) == before && world.edited.as_ref().unwrap().description == "undid: moved post");
    assert_eq!((world.to_undo(), world.to_redo()), (Some("removed ground"), Some("moved post")));
    assert_eq!(order(world, EditorOrder::Redo), Ok(Some(9)));
    assert!(stands(world) == moved && world.to_redo().is_none());
    // A refused edit is dropped and leaves the earlier ones as they are.
    order(world, EditorOrder::Undo).unwrap();
    edit(world, UnitChange::Move { place: 0, to: Placement::new(50.0, 0.0, 50.0, 0.0) }).unwrap_err();
    assert_eq!((world.to_undo(), world.to_redo()), (Some("removed ground"), Some("moved post")));
    let mut count = 0;
    while world.to_undo().is_some() {
        order(world, EditorOrder::Undo).unwrap();
        count += 1;
    }
    assert_eq!(count, 4, "edits of before");
    world.order(EditorOrder::Undo).unwrap();
    assert!(world.adopt_edit(true).is_none() && world.working.is_none());
    (0..4).for_each(|_| _ = order(world, EditorOrder::Redo).unwrap());
    assert!(stands(world) == before);
}

/// While a unit is moved, time stands still and what follows waits.
fn works_meanwhile(world: &mut WorldDocument) {
    let at = |z: f32| Placement::new(-2.2, 0.0, z, 0.0);
    let (revision, now) = (world.revision, world.run.reel.head.shown_step());
    world.run.reel.head.play(true);
    world.order(EditorOrder::Change(UnitChange::Move { place: 9, to: at(1.0) })).unwrap();
    assert!(world.working.as_ref().is_some_and(|w| w.place() == Some(9) && w.doing.contains("post")));
    assert_eq!(world.placed()[9].placement.z, 0.0);
    world.step().unwrap();
    assert_eq!(world.run.reel.head.shown_step(), now);
    // It can be moved on, and only where it comes to stand counts; anything else waits for the new world.
    for z in [2.0, 3.0, 4.0] {
        world.order(EditorOrder::Change(UnitChange::Move { place: 9, to: at(z) })).unwrap();
    }
    assert_eq!(world.ordered_placement(9), at(4.0));
    assert_eq!(world.ordered_placement(1), world.placed()[1].placement);
    for other in [UnitChange::Remove { place: 9 }, UnitChange::Move { place: 1, to: at(9.0) }] {
        assert!(world.order(EditorOrder::Change(other)).unwrap_err().contains("under way"));
    }
    assert!(world.populate(world.choice).unwrap_err().contains("when the last edit is done"));
    world.order(EditorOrder::Undo).unwrap();
    assert_eq!(world.adopt_edit(true), Some(EditStatus::Changed(Some(9))));
    assert_eq!((world.placed()[9].placement, world.revision), (at(1.0), revision + 3));
    // What is refused takes with it what waits.
    world.order(EditorOrder::Change(UnitChange::Move { place: 0, to: Placement::new(70.0, 0.0, 70.0, 0.0) })).unwrap();
    world.order(EditorOrder::Undo).unwrap();
    assert_eq!(world.adopt_edit(true), Some(EditStatus::Refused));
    assert!(world.refused.as_ref().is_some_and(|r| r.at.as_ref().is_some_and(|u| u.placement.x == 70.0)));
    assert_eq!((world.placed()[9].placement, world.revision), (at(1.0), revision + 3));
    world.run.reel.head.play(false);
    order(world, EditorOrder::Undo).unwrap();
    assert!(world.refused.is_none());
}

/// A thread that ends unexpectedly is reported; if it placed characters, the old ones stay and the world can be edited.
fn survives_its_threads(world: &mut WorldDocument) {
    let (characters, stands) = (world.run.num_characters(), world.placed().to_vec());
    let gone = |world: &mut WorldDocument| {
        world.working.as_mut().unwrap().done = Background(channel().1);
        assert_eq!(world.adopt_edit(true), Some(EditStatus::Refused));
        world.refused.as_ref().unwrap().reason.clone()
    };
    world.populate(SceneChoice { characters: 1, ..world.choice }).unwrap();
    let why = gone(world);
    assert!(why.contains("room for characters") && !why.contains("editor"), "{why}");
    assert_eq!(world.run.num_characters(), characters);
    edit(world, UnitChange::Add { unit: 0, at: panel(3, 1) }).unwrap();
    order(world, EditorOrder::Undo).unwrap();
    assert!(world.placed() == stands);
    // Where it was the editor's, it is gone, and what stands there can be saved.
    world.order(EditorOrder::Redo).unwrap();
    let why = gone(world);
    assert!(why.contains("the editor ended") && why.contains("save"), "{why}");
    world.order(EditorOrder::Redo).unwrap();
    assert!(world.working.is_none() && world.refused.as_ref().is_some_and(|r| r.reason == why));
    assert!(world.placed() == stands);
}

fn saves(world: &WorldDocument, folder: &Path) {
    let file = folder.join("saved.toml");
    world.save(&file).unwrap();
    let again = quietly(|with| WorldDocument::open(&file, with)).unwrap();
    assert_eq!(again.report.transitions, world.report.transitions);
    for (a, b) in again.placed().iter().zip(world.placed()) {
        assert!(
            a.unit == b.unit && a.placement.to_local(b.placement).with_wrapped_heading().is_moderate(1e-4),
            "{a:?} {b:?}"
        );
    }
    assert!(world.save(&folder.join("no/such/folder/w.toml")).is_err());
}

fn refused_file(name: &str, text: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    assert!(WorldSource::is_one(&path));
    quietly(|with| WorldDocument::open(&path, with)).map(|_| ()).unwrap_err()
}

#[test]
fn a_world_whose_bundle_cannot_be_opened_is_refused_with_the_way_out() {
    let place = "[[place]]\nunit = \"ground\"\nat = [0, 0, 0]\n";
    let e = refused_file("square.toml", &format!("bundle = \"no.throng\"\nconfig = \"tiles.toml\"\n{place}"));
    assert!(e.contains("square.toml") && e.contains("no.throng") && e.contains("tiles.toml"), "{e}");
    let e = refused_file("square.toml", &format!("bundle = \"no.throng\"\n{place}"));
    assert!(e.contains("no.throng: there is no such bundle") && e.contains("`throng build`"), "{e}");
}
