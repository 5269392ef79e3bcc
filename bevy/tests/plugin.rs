//! Bundles load, people move, bundles are adopted, bad ones say why: without a screen.

use bevy::asset::AssetPlugin;
use bevy::ecs::message::MessageCursor;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use std::path::{Path, PathBuf};
use std::time::Duration;
use throng_bevy::{
    Aim, Character, CharacterJoint, Crowd, CrowdEye, CrowdMessage, Entered, Joints, Refused, ThrongBundle, ThrongPlugin,
};
use throng_core::characters::made_up;
use throng_runtime::characters::{AvoidConfig, CharactersConfig, PolicyCharacters, Spawn};
use throng_runtime::{Bundle, CharacterGroup, Inline, Joint, Planar, glam};

const FILE: &str = "people.throng";

fn golden() -> PathBuf {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/golden");
    golden.join(format!("tables_v{}.throng", throng_runtime::format::VERSION))
}

/// An application without a window, whose assets are in a folder of its own.
struct Stage {
    app: App,
    folder: tempfile::TempDir,
    read: MessageCursor<CrowdMessage>,
    messages: Vec<CrowdMessage>,
}

impl Stage {
    fn new(bundle: &[u8]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(FILE), bundle).expect("written");
        let mut app = App::new();
        let file_path = folder.path().display().to_string();
        // Files are loaded again when the test says so.
        let assets = AssetPlugin { file_path, watch_for_changes_override: Some(false), ..default() };
        app.add_plugins((MinimalPlugins, TransformPlugin, assets, ThrongPlugin));
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(16_667)));
        app.finish();
        app.cleanup();
        let read = app.world().resource::<Messages<CrowdMessage>>().get_cursor();
        Self { app, folder, read, messages: Vec::new() }
    }

    fn update(&mut self) {
        self.app.update();
        let messages = self.app.world().resource::<Messages<CrowdMessage>>();
        self.messages.extend(self.read.read(messages).cloned());
    }

    /// Until something is told that one waits for.
    fn wait(&mut self, what: &str, is_it: impl Fn(&CrowdMessage) -> bool) -> CrowdMessage {
        for _ in 0..20_000 {
            self.update();
            if let Some(at) = self.messages.iter().position(&is_it) {
                return self.messages.remove(at);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("{what}: {:?}", self.messages);
    }

    fn wait_until_open(&mut self) {
        self.wait("opened", |m| matches!(m, CrowdMessage::Opened { .. }));
    }

    fn wait_for_fault(&mut self) -> String {
        match self.wait("failed", |m| matches!(m, CrowdMessage::Failed { .. })) {
            CrowdMessage::Failed { why, .. } => why,
            other => panic!("{other:?}"),
        }
    }

    /// Another file takes the place of the bundle.
    fn replace(&mut self, bundle: &[u8]) {
        std::fs::write(self.folder.path().join(FILE), bundle).expect("written");
        self.app.world().resource::<AssetServer>().reload(FILE);
    }

    fn crowd(&mut self, capacity: usize) -> Entity {
        let bundle: Handle<ThrongBundle> = self.app.world().resource::<AssetServer>().load(FILE);
        self.app.world_mut().spawn(Crowd::new(bundle, capacity).with_near_m(6.0)).id()
    }

    fn people(&mut self, crowd: Entity, count: usize) -> Vec<Entity> {
        let person = |k: usize| {
            let transform = Transform::from_translation(start(k)).with_rotation(Quat::from_rotation_y(0.1 * k as f32));
            (Character { crowd }, transform, Aim::approach(TARGET))
        };
        (0..count).map(|k| self.app.world_mut().spawn(person(k)).id()).collect()
    }

    fn character_group(&self, crowd: Entity) -> &PolicyCharacters {
        self.app.world().get::<Crowd>(crowd).and_then(Crowd::character_group).expect("it is open")
    }

    fn place(&self, entity: Entity) -> Vec3 {
        self.app.world().get::<Transform>(entity).expect("it is there").translation
    }
}

const TARGET: Vec3 = Vec3::new(10.0, 0.0, 8.0);

fn start(k: usize) -> Vec3 {
    Vec3::new(3.0 * (k % 8) as f32, 0.0, 3.0 * (k / 8) as f32)
}

#[test]
fn people_walk_as_they_do_without_bevy() {
    let mut stage = Stage::new(&std::fs::read(golden()).expect("read"));
    let crowd = stage.crowd(40);
    let people = stage.people(crowd, 40);
    stage.wait_until_open();

    let bundle = Bundle::open(golden()).expect("opened");
    let config =
        CharactersConfig { avoid: Some(AvoidConfig::default()), instances: true, ..CharactersConfig::default() };
    let mut rust = PolicyCharacters::with_capacity(&bundle, 40, config).expect("room");
    rust.hold_entrants();
    for k in 0..40 {
        let at = start(k);
        // As exactly as a quaternion tells it.
        let ahead = Quat::from_rotation_y(0.1 * k as f32) * Vec3::Z;
        rust.spawn(Spawn::standing_at(Planar::new(at.x, at.z, ahead.x.atan2(ahead.z)))).expect("room");
    }
    rust.release_entrants();
    let order = bundle.policy("approach").expect("a policy").order_towards(glam::Vec3::from_array(TARGET.to_array()));
    rust.ids().to_vec().into_iter().for_each(|id| rust.order(id, order).expect("an order"));
    let mut step = |stage: &Stage| {
        rust.step(stage.app.world().resource::<Time>().delta_secs(), &Inline).expect("a step");
        assert_eq!(stage.character_group(crowd).hash(), rust.hash());
    };
    step(&stage);
    for _ in 0..300 {
        stage.update();
        step(&stage);
    }
    let mut came_nearer = 0;
    for (k, entity) in people.iter().enumerate() {
        let entered = *stage.app.world().get::<Entered>(*entity).expect("it is in");
        assert_eq!(stage.app.world().get::<Crowd>(crowd).expect("a crowd").entity(entered.id), Some(*entity));
        let (root, at) = (rust.bodies().get(entered.id).expect("it is there").root, stage.place(*entity));
        assert_eq!([at.x, at.z], [root.x, root.z]);
        let ahead = stage.app.world().get::<Transform>(*entity).expect("it is there").rotation * Vec3::Z;
        let expected = Vec2::new(root.heading.sin(), root.heading.cos());
        assert!(ahead.xz().distance(expected) < 1e-4, "{ahead} {expected}");
        came_nearer += usize::from(at.distance(TARGET) < start(k).distance(TARGET) - 0.5);
    }
    assert!(came_nearer > 20, "{came_nearer} of 40 came nearer");
}

#[test]
fn who_is_near_has_joints_where_its_pose_has_them() {
    let mut stage = Stage::new(&std::fs::read(golden()).expect("read"));
    let crowd = stage.crowd(40);
    let people = stage.people(crowd, 40);
    let eye = stage.app.world_mut().spawn((CrowdEye, Transform::from_xyz(3.0, 9.0, 3.0))).id();
    stage.wait_until_open();
    (0..60).for_each(|_| stage.update());
    let away = |stage: &Stage, entity, from: Vec3| (stage.place(entity) - from).xz().length();
    let mut with_joints = 0;
    for entity in &people {
        let distance = away(&stage, *entity, Vec3::new(3.0, 0.0, 3.0));
        let world = stage.app.world();
        let Some(joints) = world.get::<Joints>(*entity) else {
            assert!(distance > 6.0, "{distance} m away without joints");
            continue;
        };
        assert!(distance < 7.5, "{distance} m away with joints");
        with_joints += 1;
        let id = world.get::<Entered>(*entity).expect("it is in").id;
        let body = stage.character_group(crowd).bodies().get(id).expect("it is there");
        for (j, joint) in joints.joints.iter().enumerate() {
            assert_eq!(world.get::<CharacterJoint>(*joint).map(|j| j.0), Some(Joint::ALL[j]));
            assert_eq!(world.get::<ChildOf>(*joint).map(ChildOf::parent), Some(*entity));
            let found = world.get::<GlobalTransform>(*joint).expect("spatial").affine();
            // Three points tell where a joint is and how it is turned.
            for point in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
                let expected = body.world(Joint::ALL[j]).transform_point3(glam::Vec3::from_array(point));
                let found = found.transform_point3(Vec3::from_array(point));
                assert!(found.distance(Vec3::from_array(expected.to_array())) < 1e-4, "{j}: {found} {expected}");
            }
        }
        let [head, toe] = [Joint::Head, Joint::LeftToe]
            .map(|j| world.get::<GlobalTransform>(joints.joints[j.index()]).expect("spatial").translation().y);
        assert!((1.2..1.9).contains(&head) && (-0.1..0.6).contains(&toe), "head {head}, toe {toe}");
    }
    assert!(with_joints > 5 && with_joints < 40, "{with_joints}");
    // The eye goes: nobody is near.
    stage.app.world_mut().get_mut::<Transform>(eye).expect("it is there").translation.x = 500.0;
    (0..3).for_each(|_| stage.update());
    let mut joints = stage.app.world_mut().query::<&CharacterJoint>();
    assert_eq!(joints.iter(stage.app.world()).count(), 0);
}

#[test]
fn who_is_despawned_leaves_and_who_has_no_room_waits() {
    let mut stage = Stage::new(&std::fs::read(golden()).expect("read"));
    let crowd = stage.crowd(3);
    let people = stage.people(crowd, 4);
    stage.wait_until_open();
    assert!(stage.wait_for_fault().contains('3'));
    assert!(stage.app.world().get::<Refused>(people[3]).is_some());
    assert_eq!(stage.character_group(crowd).ids().len(), 3);
    let gone = stage.app.world().get::<Entered>(people[1]).expect("it is in").id;
    stage.app.world_mut().despawn(people[1]);
    assert!(stage.character_group(crowd).status(gone).is_err());
    stage.app.world_mut().entity_mut(people[3]).remove::<Refused>();
    stage.update();
    let id = stage.app.world().get::<Entered>(people[3]).expect("there is room now").id;
    assert_eq!((id.index, id.generation), (1, 1));
    assert_eq!(stage.character_group(crowd).ids().len(), 3);
    // A behaviour that the bundle does not have.
    stage.app.world_mut().get_mut::<Aim>(people[0]).expect("it has one").behaviour = "fly".into();
    assert!(stage.wait_for_fault().contains("approach"));
    // A crowd goes with its people.
    stage.app.world_mut().despawn(crowd);
    stage.update();
    assert!(people.iter().all(|p| stage.app.world().get_entity(*p).is_err()));
    let alone = stage.app.world_mut().spawn(Character { crowd }).id();
    assert!(stage.wait_for_fault().contains("no crowd"));
    assert!(stage.app.world().get::<Refused>(alone).is_some());
}

#[test]
fn a_bundle_that_is_built_anew_is_adopted_and_a_bad_one_says_why() {
    let golden = std::fs::read(golden()).expect("read");
    let mut stage = Stage::new(&made_up::bytes(&[], true));
    let crowd = stage.crowd(12);
    let people = stage.people(crowd, 12);
    stage.wait_until_open();
    (0..30).for_each(|_| stage.update());

    // Cut short: the reason is told, and everybody goes on.
    stage.replace(&golden[..1000]);
    let why = stage.wait_for_fault();
    assert!(why.contains(FILE) && why.contains("1000"), "{why}");
    let before = stage.character_group(crowd).hash();
    stage.update();
    assert_ne!(stage.character_group(crowd).hash(), before);

    // A bundle without a behaviour that somebody follows.
    let first = people[0];
    stage.app.world_mut().get_mut::<Aim>(first).expect("it has one").behaviour = "adaptive".into();
    stage.update();
    stage.replace(&golden);
    let why = stage.wait_for_fault();
    assert!(why.contains("adaptive"), "{why}");

    // Nobody does now.
    stage.app.world_mut().get_mut::<Aim>(first).expect("it has one").behaviour = "approach".into();
    stage.update();
    let places: Vec<Vec3> = people.iter().map(|p| stage.place(*p)).collect();
    stage.replace(&golden);
    let adopted = stage.wait("adopted", |m| matches!(m, CrowdMessage::Adopted { .. }));
    let CrowdMessage::Adopted { adopted, .. } = adopted else { panic!("{adopted:?}") };
    assert_eq!(adopted.num_characters, 12);
    let new = Bundle::open(self::golden()).expect("opened");
    assert_eq!(stage.character_group(crowd).motion_set().graph().states.len(), new.graph().states.len());
    // Nobody jumped: half a second of walking at most while files were read.
    for (person, place) in people.iter().zip(places) {
        assert!(stage.place(*person).distance(place) < 3.0, "{} {place}", stage.place(*person));
    }
}

#[test]
fn a_bundle_that_was_bad_from_the_start_is_taken_when_it_is_mended() {
    let mut stage = Stage::new(b"this is no bundle");
    let crowd = stage.crowd(5);
    let people = stage.people(crowd, 5);
    let why = stage.wait_for_fault();
    assert!(why.contains(FILE) && why.contains("Throng"), "{why}");
    assert!(stage.app.world().get::<Entered>(people[0]).is_none());
    stage.replace(&std::fs::read(golden()).expect("read"));
    stage.wait_until_open();
    assert_eq!(stage.character_group(crowd).ids().len(), 5);
}
