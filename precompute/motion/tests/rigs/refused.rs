//! What is no person is refused with the reason, and sides that are named wrong are told.

use super::rig::{FRAMES, RigPart, Style, bvh, parse};
use super::{import, tables, wrong};
use throng_core::Joint;
use throng_motion::import::{ImportConfig, UpAxis};

fn table(name: &str) -> Vec<RigPart> {
    parse(tables::RIGS.iter().find(|(n, _)| *n == name).unwrap().1)
}

fn refusal(parts: &[RigPart], style: &Style) -> String {
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

/// An elephant: ears and tusks are pairs too, the back slopes, and its forelegs are longer than its hind legs.
const ELEPHANT: &str = "
    root;-;0 0 0;-
    pelvis;root;0 1.9 -0.9;hips
    spine1;pelvis;0 0.15 0.6;-
    spine2;spine1;0 0.15 0.6;-
    neck;spine2;0 0.25 0.4;-
    head;neck;0 0.2 0.4;-
    trunk1;head;0 -0.3 0.4;-
    trunk2;trunk1;0 -0.5 0.1;-
    trunk3;trunk2;0 -0.5 0;-
    trunk4;trunk3;0 -0.4 0;-
    ear{A,B}1;head;0.3 0 -0.1;-
    ear{A,B}2;ear{A,B}1;0.4 -0.1 -0.1;-
    ear{A,B}3;ear{A,B}2;0.4 -0.3 -0.1;-
    tusk{A,B}1;head;0.2 -0.3 0.3;-
    tusk{A,B}2;tusk{A,B}1;0.05 -0.3 0.4;-
    tusk{A,B}3;tusk{A,B}2;0 0 0.3;-
    tail1;pelvis;0 0 -0.2;-
    tail2;tail1;0 -0.4 -0.1;-
    {l,r}Scapula;spine2;0.3 -0.1 0.1;-
    {l,r}Fore1;{l,r}Scapula;0.05 -0.5 0.1;-
    {l,r}Fore2;{l,r}Fore1;0 -0.7 -0.1;-
    {l,r}Fore3;{l,r}Fore2;0 -0.7 0.05;-
    {l,r}Hind1;pelvis;0.3 -0.1 0;left_thigh
    {l,r}Hind2;{l,r}Hind1;0 -0.8 0.15;left_shin
    {l,r}Hind3;{l,r}Hind2;0 -0.8 -0.1;left_foot
    {l,r}Hind4;{l,r}Hind3;0 -0.1 0.15;-";

/// A horse: five joints in each leg, long cannon bones, named as arms and legs.
const HORSE: &str = "
    Root;-;0 0 0;-
    Pelvis;Root;0 1.5 -0.6;hips
    Spine;Pelvis;0 0 0.5;-
    Chest;Spine;0 0 0.6;-
    Neck1;Chest;0 0.3 0.3;-
    Neck2;Neck1;0 0.35 0.25;-
    Head;Neck2;0 0.1 0.2;-
    Ear{L,R};Head;0.05 0.15 0;-
    EarTip{L,R};Ear{L,R};0 0.1 0;-
    Tail;Pelvis;0 -0.2 -0.3;-
    {Left,Right}Shoulder;Chest;0.2 -0.1 0.1;-
    {Left,Right}UpperArm;{Left,Right}Shoulder;0 -0.35 0.1;-
    {Left,Right}LowerArm;{Left,Right}UpperArm;0 -0.35 -0.15;-
    {Left,Right}Hand;{Left,Right}LowerArm;0 -0.4 0.03;-
    {Left,Right}Fingers;{Left,Right}Hand;0 -0.22 0.05;-
    {Left,Right}UpperLeg;Pelvis;0.2 -0.1 0;left_thigh
    {Left,Right}LowerLeg;{Left,Right}UpperLeg;0 -0.4 0.2;left_shin
    {Left,Right}Foot;{Left,Right}LowerLeg;0 -0.45 -0.35;left_foot
    {Left,Right}Toes;{Left,Right}Foot;0 -0.45 0.05;-";

#[test]
fn animals_of_any_size_are_refused_even_in_the_unit_that_was_offered() {
    let dog = dog(["L_", "R_", "Arm", "Leg"]);
    let tables = [("elephant", ELEPHANT), ("horse", HORSE), ("dog", dog.as_str())];
    let mut bad = Vec::new();
    for (name, table) in tables {
        for (scale, unnamed) in [(1.0, false), (100.0, false), (37.0, false), (0.2, false), (1.0, true)] {
            for rest in [super::Rest::TPose, super::Rest::AlongX] {
                let mut parts = parse(table);
                if unnamed {
                    parts.iter_mut().enumerate().for_each(|(i, p)| p.name = format!("B{i}"));
                }
                let style = Style { scale, rest, moves: false, ..Style::default() };
                for metres_per_unit in [None, Some(f64::from(0.6 / scale)), Some(f64::from(1.0 / scale))] {
                    let config = ImportConfig { metres_per_unit, ..ImportConfig::default() };
                    match super::import_with(&parts, &style, &config) {
                        Ok(found) => {
                            let pairs: Vec<_> = found.roles.pairs(&found.clip.joints).collect();
                            bad.push(format!("{name}, {scale}, {rest:?}, {metres_per_unit:?}: {pairs:?}"));
                        }
                        Err(e) if !e.to_string().contains("no person") && !e.to_string().contains("left cannot") => {
                            bad.push(format!("{name}, {scale}, {rest:?}: {e}"));
                        }
                        Err(_) => {}
                    }
                }
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn people_of_any_size_are_taken_with_a_warning() {
    for name in ["Mixamo", "Unreal", "CMU BVH", "Bone00"] {
        // 17 cm and 3 m by every unit that files use, and sizes of no unit at all.
        for scale in [0.1, 1.73, 7.3, 0.003, 5e4] {
            let parts = table(name);
            let found = import(&parts, &Style { scale, ..Style::default() }).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert!(wrong(&parts, &found).iter().all(|w| w.contains("toe")), "{name}");
            assert!((0.85..2.5).contains(&found.height), "{name}, {scale}: {} m", found.height);
            let told = |w: &String| w.contains("taken as 1.75 m tall") && w.contains("--metres-per-unit");
            let is_odd = found.findings.iter().any(|f| f.contains("no usual unit"));
            assert_eq!(found.warnings.messages.iter().any(told), is_odd, "{name}, {scale}: {:?}", found.warnings);
        }
    }
}

/// Error of a rig whose chains have no ends, as glTF has it.
fn refusal_without_ends(text: &str) -> String {
    let source = bvh(&parse(text), &Style::default());
    let mut source = throng_motion::import::bvh::parse(source.as_bytes(), std::path::Path::new("a.bvh")).unwrap();
    let gone: Vec<usize> = (0..source.clip.joints.len()).filter(|&j| source.clip.joints[j].is_end).collect();
    let (n, all) = (source.clip.joints.len(), source.clip.num_frames);
    let new = |j: usize| j - gone.iter().filter(|&&g| g < j).count();
    let keep = |k: usize| !gone.contains(&(k % n));
    source.clip.translations = (0..n * all).filter(|&k| keep(k)).map(|k| source.clip.translations[k]).collect();
    source.clip.rotations = (0..n * all).filter(|&k| keep(k)).map(|k| source.clip.rotations[k]).collect();
    source.clip.joints.iter_mut().for_each(|j| j.parent = j.parent.map(new));
    source.clip.joints.retain(|j| !j.is_end);
    throng_motion::import::interpret(source, &ImportConfig::default(), &[]).unwrap_err().to_string()
}

#[test]
fn limbs_that_end_too_early_are_said_to_do_so() {
    let body = "
        Root;-;0 0 0;-
        Hips;Root;hips
        Torso;Hips;0 0.3 0;upper_chest
        Neck;Torso;neck
        Head;Neck;head
        UpperArm.{L,R};Torso;left_upper_arm
        LowerArm.{L,R};UpperArm.{L,R};left_forearm";
    let hands = "\nHand.{L,R};LowerArm.{L,R};left_hand";
    let legs = "\nUpperLeg.{L,R};Hips;left_thigh\nLowerLeg.{L,R};UpperLeg.{L,R};left_shin";
    let feet = "\nFoot.{L,R};LowerLeg.{L,R};left_foot\nToe.{L,R};Foot.{L,R};left_toe";
    let names = |text: String| {
        let names = [("LowerLeg.{L,R}", "{Left,Right}Leg"), ("UpperLeg.{L,R}", "{Left,Right}UpLeg")];
        names.iter().fold(text, |text, (from, to)| text.replace(from, to))
    };
    let mixamo_legs = names(legs.to_owned());
    for (parts, expected) in [
        (
            [hands, legs, "\nFoot.{L,R};Root;left_foot\nToe.{L,R};Foot.{L,R};left_toe"],
            "its legs have no feet: nothing hangs on `LowerLeg.L`; `Foot.L` hangs on `Root`",
        ),
        ([hands, &mixamo_legs, ""], "its legs have no feet: nothing hangs on `LeftLeg`"),
        ([hands, "\nUpperLeg.{L,R};Hips;left_thigh", ""], "its legs have no feet: nothing hangs on `UpperLeg.L`"),
        // The hands hang on twist joints that lie beside the forearms.
        (
            ["\nForeTwist.{L,R};UpperArm.{L,R};left_forearm\nHand.{L,R};ForeTwist.{L,R};left_hand", legs, feet],
            "its arms have no hands: nothing hangs on `LowerArm.L`; `Hand.L` hangs on `ForeTwist.L`",
        ),
    ] {
        let e = refusal_without_ends(&(body.to_owned() + &parts.concat()));
        assert!(e.contains(expected), "{e}");
    }
}

#[test]
fn parts_of_a_body_are_said_to_be_such() {
    let mixamo = table("Mixamo");
    let is_leg = |p: &RigPart| p.moved_by.index() >= Joint::LeftThigh.index();
    let without = |out: &dyn Fn(&RigPart) -> bool| {
        let mut parts: Vec<RigPart> = Vec::new();
        for p in mixamo.iter().filter(|p| !out(p)) {
            let parent = p.parent.map(|q| mixamo[q].name.clone());
            let parent = parent.and_then(|name| parts.iter().position(|p| p.name == name));
            parts.push(RigPart { parent, ..p.clone() });
        }
        parts
    };
    let upper = without(&is_leg);
    let e = refusal(&upper, &Style::default());
    assert!(e.contains("an upper body alone") && e.contains("no pair of legs"), "{e}");
    let unnamed: Vec<RigPart> =
        upper.iter().enumerate().map(|(i, p)| RigPart { name: format!("B{i}"), ..p.clone() }).collect();
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
    let unnamed: Vec<RigPart> =
        parts.iter().enumerate().map(|(i, p)| RigPart { name: format!("B{i}"), ..p.clone() }).collect();
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
    assert!(e.contains("m tall, which no person is") && e.contains("`--metres-per-unit 0.9"), "{e}");
    let offered: f64 = e.split("--metres-per-unit ").nth(1).unwrap().split('`').next().unwrap().parse().unwrap();
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
