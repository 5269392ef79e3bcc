//! What is no person is refused with the reason, and sides that are named wrong are told.

use super::rig::{FRAMES, Part, Style, bvh, parse};
use super::{import, tables, wrong};
use throng_core::Joint;
use throng_motion::import::{ImportConfig, UpAxis};

fn table(name: &str) -> Vec<Part> {
    parse(tables::RIGS.iter().find(|(n, _)| *n == name).unwrap().1)
}

fn refusal(parts: &[Part], style: &Style) -> String {
    match import(parts, style) {
        Ok(found) => panic!("taken for a person: {:?}", found.roles.pairs(&found.clip.joints).collect::<Vec<_>>()),
        Err(e) => e.to_string(),
    }
}

/// A dog that stands or walks: trunk level along +Z, four legs down, a neck, a head and a tail.
fn dog(names: [&str; 4]) -> String {
    let [l, r, fore, hind] = names;
    format!(
        "Root;-;0 0.6 0;-
        Back1;Root;0 0 0.2;-
        Back2;Back1;0 0 0.2;-
        Neck;Back2;0 0.1 0.15;-
        Head;Neck;0 0.12 0.1;-
        Tail1;Root;0 0 -0.15;-
        Tail2;Tail1;0 0 -0.15;-
        {{{l},{r}}}{fore}1;Back2;0.08 0 0;-
        {{{l},{r}}}{fore}2;{{{l},{r}}}{fore}1;0 -0.26 0;-
        {{{l},{r}}}{fore}3;{{{l},{r}}}{fore}2;0 -0.26 0;-
        {{{l},{r}}}{hind}1;Root;0.08 0 0;-
        {{{l},{r}}}{hind}2;{{{l},{r}}}{hind}1;0 -0.26 0.04;-
        {{{l},{r}}}{hind}3;{{{l},{r}}}{hind}2;0 -0.26 -0.04;-"
    )
}

#[test]
fn four_legs_are_no_person() {
    for names in [["L_", "R_", "Fore", "Hind"], ["x", "y", "p", "q"], ["Left", "Right", "Arm", "Leg"]] {
        let parts = parse(&dog(names));
        for style in [
            Style { moves: false, ..Style::default() },
            Style { scale: 1.0, heading: 1.0, moves: false, ..Style::default() },
        ] {
            let e = refusal(&parts, &style);
            assert!(e.contains("four legs") || e.contains("left cannot be told from right"), "{e}");
        }
    }
    let e = refusal(&parse(&dog(["L_", "R_", "Fore", "Hind"])), &Style { moves: false, ..Style::default() });
    assert!(e.contains("goes on four legs (`L_Hind1`, `R_Hind1`, `L_Fore1`, `R_Fore1`)"), "{e}");
}

#[test]
fn parts_of_a_body_are_said_to_be_such() {
    let mixamo = table("Mixamo");
    let is_leg = |p: &Part| p.moved_by.index() >= Joint::LeftThigh.index();
    let without = |out: &dyn Fn(&Part) -> bool| {
        let mut parts: Vec<Part> = Vec::new();
        for p in mixamo.iter().filter(|p| !out(p)) {
            let parent = p.parent.map(|q| mixamo[q].name.clone());
            let parent = parent.and_then(|name| parts.iter().position(|p| p.name == name));
            parts.push(Part { parent, ..p.clone() });
        }
        parts
    };
    let upper = without(&is_leg);
    let e = refusal(&upper, &Style::default());
    assert!(e.contains("an upper body alone") && e.contains("no pair of legs"), "{e}");
    let unnamed: Vec<Part> =
        upper.iter().enumerate().map(|(i, p)| Part { name: format!("B{i}"), ..p.clone() }).collect();
    let e = refusal(&unnamed, &Style::default());
    assert!(e.contains("an upper body alone"), "{e}");
    let lower = without(&|p| !is_leg(p) && p.moved_by != Joint::Hips);
    assert!(refusal(&lower, &Style::default()).contains("a lower body alone"));
    let headless = without(&|p| matches!(p.moved_by, Joint::Neck | Joint::Head));
    let e = refusal(&headless, &Style::default());
    assert!(e.contains("no joint for a neck or head goes on from `mixamorig:Spine2`"), "{e}");
}

#[test]
fn hands_and_props_are_said_to_be_such() {
    let mut hand = String::from("wrist;-;0 1 0;-\n");
    for (i, name) in ["a", "b", "c", "d", "e"].iter().enumerate() {
        let x = 0.02 * i as f32;
        hand += &format!("{name}1;wrist;{x} 0 0.09;-\n{name}2;{name}1;0 0 0.04;-\n{name}3;{name}2;0 0 0.03;-\n");
    }
    let e = refusal(&parse(&hand), &Style::default());
    assert!(e.contains("it is a hand alone: fingers hang on `wrist`"), "{e}");
    let e = refusal(&parse("Box;-;0 0 0;-\nLid;Box;0 0.3 0;-\nHandle;Lid;0 0.1 0.2;-"), &Style::default());
    assert!(e.contains("no two limbs of equal length") && e.contains("Box, Lid, Handle"), "{e}");
}

#[test]
fn a_body_whose_sides_are_swapped_is_refused_and_one_limb_that_is_named_wrong_is_told() {
    for name in ["Mixamo", "Unreal", "3ds Max Biped", "Japanese"] {
        let e = refusal(&table(name), &Style { mirrored: true, ..Style::default() });
        assert!(e.contains("left and right are swapped") && e.contains("export it right-handed"), "{name}: {e}");
    }
    // The arms alone: their names are exchanged.
    let mut parts = table("Xsens");
    let arms = ["Collar", "Shoulder", "Elbow", "Wrist"];
    for p in parts.iter_mut().filter(|p| arms.iter().any(|a| p.name.ends_with(a))) {
        p.name = match p.name.strip_prefix("Left") {
            Some(rest) => format!("Right{rest}"),
            None => p.name.replace("Right", "Left"),
        };
    }
    let found = import(&parts, &Style::default()).unwrap();
    assert_eq!(wrong(&parts, &found), Vec::<String>::new(), "the place decides");
    let told = |w: &String| w.contains("`LeftShoulder` is named left, but is to the right of the spine");
    assert!(found.warnings.messages.iter().any(told), "{:?}", found.warnings);
}

#[test]
fn names_decide_where_the_shape_tells_no_side_and_else_it_is_refused() {
    // No toes, straight knees, nothing moves.
    let still = Style { moves: false, ..Style::default() };
    let parts = table("two roots");
    assert!(wrong(&parts, &import(&parts, &still).unwrap()).is_empty());
    let unnamed: Vec<Part> =
        parts.iter().enumerate().map(|(i, p)| Part { name: format!("B{i}"), ..p.clone() }).collect();
    let e = refusal(&unnamed, &still);
    assert!(e.contains("left cannot be told from right") && e.contains("Write a profile"), "{e}");
}

#[test]
fn a_giant_by_its_unit_is_refused_and_the_unit_offered() {
    let parts = table("Mixamo");
    let text = bvh(&parts, &Style { scale: 1.0, ..Style::default() });
    let read = |metres_per_unit| {
        let config = ImportConfig { metres_per_unit, up: Some(UpAxis::Y), ..ImportConfig::default() };
        let source = throng_motion::import::bvh::parse(text.as_bytes(), std::path::Path::new("a.bvh")).unwrap();
        throng_motion::import::interpret(source, &config, &[])
    };
    let e = read(Some(100.0)).unwrap_err().to_string();
    assert!(e.contains("m tall, which no person is") && e.contains("metres_per_unit = 0.9"), "{e}");
    let offered: f64 = e.split("metres_per_unit = ").nth(1).unwrap().split('`').next().unwrap().parse().unwrap();
    let height = read(Some(offered)).unwrap().height;
    assert!((1.6..1.9).contains(&height), "{height}");
    assert_eq!(read(None).unwrap().clip.num_frames, FRAMES);
}

#[test]
fn motion_far_from_the_origin_is_refused_with_the_frame() {
    let text = bvh(&table("Mixamo"), &Style::default());
    let read_at = |frames: std::ops::Range<usize>, axis: usize, away_m: f32| {
        let mut source = throng_motion::import::bvh::parse(text.as_bytes(), std::path::Path::new("a.bvh")).unwrap();
        let metres = throng_motion::import::interpret(source.clone(), &ImportConfig::default(), &[]).unwrap();
        for f in frames {
            source.clip.translations[f * source.clip.joints.len()][axis] += away_m / metres.metres_per_unit as f32;
        }
        throng_motion::import::interpret(source, &ImportConfig::default(), &[])
    };
    let read = |away_m: f32| read_at(FRAMES - 1..FRAMES, 0, away_m);
    assert!(read(4900.0).is_ok());
    let e = read(10_000.0).unwrap_err().to_string();
    assert!(e.contains(&format!("in frame {} the hips are", FRAMES - 1)) && e.contains("from the origin"), "{e}");
    // High above it, and away and back again; a glitch may be anywhere.
    assert!(read_at(0..FRAMES, 1, 10_000.0).unwrap_err().to_string().contains("in frame 0 the hips are"));
    assert!(read_at(20..40, 0, 1e6).unwrap_err().to_string().contains("the hips are"));
    assert!(read_at(20..21, 0, 1e6).is_ok());
}
