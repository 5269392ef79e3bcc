//! Promise: gestures at places are shown towards them, by people who stand and by people who walk.

use glam::Vec3;
use std::path::Path;
use throng_core::Joint;
use throng_simulation::{Scene, Simulation};

/// Somebody at the origin, who faces +Z and does something.
fn person(does: &str) -> Simulation {
    let golden =
        format!("{}/../../data/golden/tables_v{}.throng", env!("CARGO_MANIFEST_DIR"), throng_core::format::VERSION);
    let text = format!(
        "seconds = 30.0\nbundle = \"{golden}\"\n[[groups]]\nname = \"guide\"\nmotion = \"blend\"\nspaces = [\"walks\"]\n\
         count = 1\nplace = {{ block = {{ from = [-0.1, -0.1], to = [0.1, 0.1] }} }}\ngraph = \"g\"\n[graphs.g]\n\
         level = \"social\"\nstart = \"it\"\n[graphs.g.states]\nit = {{ do = [{does}, {{ stay = 99 }}] }}\n"
    );
    let scene = Scene::parse(&text, Path::new("scene.toml")).and_then(|scene| scene.open());
    Simulation::new(&scene.unwrap_or_else(|e| panic!("{e}"))).expect("it begins")
}

/// Direction of the better forearm towards a place, as a cosine, and the height of the higher hand above its elbow (m), in
/// each step.
fn arms(sim: &mut Simulation, at: Vec3, seconds: f64) -> Vec<[f32; 2]> {
    let mut out = Vec::new();
    while sim.time_s() < seconds {
        sim.step(1.0 / 30.0).expect("it goes on");
        let joints = sim.joint_positions(0).expect("a body");
        let sides = [(Joint::LeftForearm, Joint::LeftHand), (Joint::RightForearm, Joint::RightHand)];
        let each = sides.map(|(elbow, hand)| {
            let (elbow, hand) = (joints[elbow.index()], joints[hand.index()]);
            let along = (hand - elbow).with_y(0.0).normalize_or_zero();
            [along.dot((at - elbow).with_y(0.0).normalize_or_zero()), hand.y - elbow.y]
        });
        let best = |k: usize| each[0][k].max(each[1][k]);
        out.push([best(0), best(1)]);
    }
    out
}

/// Time for which arms point along a direction (s).
fn shown_s(arms: &[[f32; 2]]) -> f32 {
    // Hanging forearms are not level, and point nowhere.
    arms.iter().filter(|[along, above]| *along > 0.97 && *above > -0.1).count() as f32 / 30.0
}

#[test]
fn who_stands_turns_to_what_it_points_or_waves_at() {
    for at in [[0.0, 8.0], [8.0, 0.5], [-6.0, -5.0], [0.3, -8.0], [7.0, -6.0]] {
        let to = Vec3::new(at[0], 0.0, at[1]);
        let mut sim = person(&format!("{{ gesture = \"point\", at = {at:?}, for_s = 3 }}"));
        let shown = arms(&mut sim, to, 9.0);
        assert!(shown_s(&shown) > 1.5, "{at:?}: pointed at for {} s", shown_s(&shown));
        assert!(shown_s(&shown[210..]) < 0.1, "{at:?}: it ends");
        let mut sim = person(&format!("{{ gesture = \"wave\", at = {at:?}, for_s = 3 }}"));
        let waves: Vec<[f32; 2]> = arms(&mut sim, to, 9.0).into_iter().filter(|arm| arm[1] > 0.1).collect();
        assert!(waves.len() > 45, "{at:?}: waves for {} steps", waves.len());
        let root = sim.root(0).expect("a person");
        let front = root.rotation() * Vec3::Z;
        assert!(front.dot(to.normalize()) > -0.3, "{at:?}: waves away from it, towards {front}");
    }
}

#[test]
fn who_walks_away_points_on_at_what_is_behind_once_it_comes_back() {
    let does = "{ gesture = \"point\", at = [0.0, -8.0], for_s = 2 }, { go = [0.0, 8.0] }, { go = [0.0, 0.0] }";
    let mut sim = person(does);
    let shown = arms(&mut sim, Vec3::new(0.0, 0.0, -8.0), 30.0);
    // It sets off within 2 s, and turns round after 7 s.
    let (away, back) = (shown_s(&shown[60..200]), shown_s(&shown[200..]));
    assert!(away == 0.0 && back > 0.3, "{away} s on the way, then {back} s");
}
