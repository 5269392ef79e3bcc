//! Captured people on all floors of a level: they get there, stand on its ground, and are in nobody.

#[path = "../precompute/level/tests/common/shapes.rs"]
#[allow(dead_code, reason = "other shapes are those of the tests of levels")]
mod shapes;

use crate::common;
use glam::{Vec3, Vec3Swizzles};
use shapes::Shape;
use std::fs::File;
use std::path::Path;
use throng_core::{Contacts, Joint};
use throng_level::Level;
use throng_level_bake::{LevelSettings, MarkedArea, bake};
use throng_simulation::{CharacterEvent, Scene, Simulation};

/// A square of 3 m around a point.
fn square(at: [f32; 3]) -> Vec<[Vec3; 3]> {
    let corner = |x: f32, z: f32| Vec3::from(at) + Vec3::new(x, 0.0, z);
    let [a, b, c, d] = [corner(-1.5, -1.5), corner(-1.5, 1.5), corner(1.5, 1.5), corner(1.5, -1.5)];
    vec![[a, b, c], [a, c, d]]
}

/// Level of a shape with two places, and people who go from one to the other and back.
fn simulation(folder: &Path, shape: Shape, places: [[f32; 3]; 2], count: usize, seed: u64) -> (Level, Simulation) {
    let mut source = shapes::source(shape);
    for (name, at) in ["low", "high"].into_iter().zip(places) {
        source.areas.push(MarkedArea { name: name.into(), kind: "goal", triangles: square(at) });
    }
    let data = bake(&source, &LevelSettings::default(), &mut Vec::new()).expect("a level");
    let file = folder.join("floors.level");
    data.write(&mut File::create(&file).expect("a file")).expect("it can be written");
    let text = format!(
        r#"
seed = {seed}
bundle = "people.throng"
level = {{ file = "floors.level", all_floors = true }}
[[groups]]
motion = "policy"
count = {count}
place = {{ level = {{ names = ["low", "high"] }} }}
goal = {{ level = {{ names = ["low", "high"] }} }}
arrival_m = 1.0
behaviours = [{{ name = "approach" }}]
"#
    );
    let scene = Scene::parse(&text, &folder.join("floors.toml")).expect("a scene");
    let sim = Simulation::new(&scene.compile(&common::tables()).expect("it compiles")).expect("a simulation");
    (Level::from_data(&data).expect("a level"), sim)
}

#[test]
fn people_get_to_other_floors_and_stand_on_them() {
    let cases: [(&str, Shape, [[f32; 3]; 2]); 4] = [
        ("ramp", shapes::ramp, [[-1.0, 0.0, 2.0], [12.0, 1.5, 0.0]]),
        ("stairs", shapes::stairs, [[-1.0, 0.0, 2.0], [10.0, 2.04, 2.0]]),
        ("two floors", shapes::two_floors, [[17.0, 0.0, 9.0], [17.0, 3.5, 9.0]]),
        ("spiral", shapes::SHAPES[8].1, [[3.5, 0.0, 4.0], [-6.5, 5.4, 0.0]]),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (seed, (name, shape, places)) in (1..).zip(cases) {
        let (level, mut sim) = simulation(folder.path(), shape, places, 8, seed);
        let toe_m = common::tables().skeleton().rest_positions()[Joint::LeftToe.index()].y;
        let (mut arrived, mut deepest, mut off) = (0, 0.0f32, Vec::new());
        while sim.time_s() < 90.0 {
            sim.step(1.0 / 30.0).unwrap();
            arrived += sim.events().iter().filter(|e| matches!(e.kind, CharacterEvent::Arrived)).count();
            let discs: Vec<_> = (0..8).filter_map(|who| sim.disc(who)).collect();
            for (who, disc) in discs.iter().enumerate() {
                let ground = level.nearest(disc.centre, 1.0).expect("ground below everybody").at;
                assert!(
                    ground.xz().distance(disc.centre.xz()) < 0.35,
                    "{name}: {who} is beside the ground at {ground}"
                );
                for other in &discs[..who] {
                    deepest = deepest.max(disc.radius + other.radius - disc.centre.distance(other.centre));
                }
                let (joints, contacts) = (sim.joint_positions(who).expect("a body"), sim.contacts(who));
                for (toe, [_, ball]) in [Joint::LeftToe, Joint::RightToe].into_iter().zip(Contacts::FEET) {
                    let at = joints[toe.index()];
                    if contacts.any(ball)
                        && let Some(ground) = level.height_at(at)
                    {
                        off.push((at.y - ground - toe_m).abs());
                    }
                }
            }
        }
        off.sort_by(f32::total_cmp);
        let [middle, most] = [0.5, 0.95].map(|share| off[(share * off.len() as f32) as usize]);
        println!("{name}: {arrived} arrived, {deepest} m deep, planted feet {middle} and {most} m off the ground");
        assert!(arrived == 8 && deepest < 5e-3, "{name}: {arrived} of 8, {deepest} m deep");
        assert!(most < 0.03, "{name}: of planted feet, 5 % are over {most} m off the ground");
    }
}

#[test]
fn a_restored_run_goes_on_as_it_was_on_every_floor() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let places = [[17.0, 0.0, 9.0], [17.0, 3.5, 9.0]];
    let make = || simulation(folder.path(), shapes::two_floors, places, 6, 5).1;
    let (mut sim, mut again) = (make(), make());
    (0..600).for_each(|_| sim.step(1.0 / 30.0).unwrap());
    let high = |sim: &Simulation| (0..6).filter(|&who| sim.disc(who).is_some_and(|d| d.centre.y > 1.0)).count();
    assert!((1..6).contains(&high(&sim)), "{} people are up there", high(&sim));
    again.restore(&sim.snapshot()).unwrap();
    for _ in 0..90 {
        sim.step(1.0 / 30.0).unwrap();
        again.step(1.0 / 30.0).unwrap();
    }
    assert_eq!(sim.hash(), again.hash());
}

#[test]
fn what_people_on_all_floors_need_is_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    drop(simulation(folder.path(), shapes::two_floors, [[17.0, 0.0, 9.0], [17.0, 3.5, 9.0]], 1, 1));
    let group = |level: &str, motion: &str, name: &str| {
        format!(
            "bundle = \"people.throng\"\n{level}\n[[groups]]\nmotion = \"{motion}\"\ncount = 3\nspaces = []\n\
             place = {{ level = {{}} }}\ngoal = {{ level = {{ names = [\"{name}\"] }} }}\n"
        )
    };
    let floors = "level = { file = \"floors.level\", all_floors = true }";
    let one_floor = "level = { file = \"floors.level\" }";
    for (level, motion, name, told) in [
        ("", "policy", "low", "`level` has `all_floors = true`"),
        (one_floor, "policy", "low", "`level` has `all_floors = true`"),
        ("level = { file = \"floors.level\", height_m = 3.5, all_floors = true }", "policy", "low", "found both"),
        (floors, "blend", "low", "people on all floors are `motion = \"policy\"`"),
        (floors, "policy", "roof", "\"low\", \"high\""),
    ] {
        let text = group(level, motion, name);
        let text = if motion == "policy" { text.replace("spaces = []\n", "") } else { text };
        let refused = Scene::parse(&text, &folder.path().join("floors.toml")).expect_err(told).to_string();
        assert!(refused.contains(told), "{refused}");
    }
}
