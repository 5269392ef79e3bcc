//! Taking and putting down, worked out by hand. On paper every way takes [`WAY_S`], and hands are done when their time is over.

use super::*;

/// Two people and one cup. Both want it at once: one goes and takes it, the other hears that it is taken.
const CUP: &str = r#"
[[things]]
name = "cup"
at = [0.0, 1.0, 9.0]

[values.thirst]
start = [0.0, 0.0]

[[events]]
name = "tea"
at_s = 1.0

[[events]]
name = "fire"
at_s = 3.5

[[rules]]
on = "tea"
do = [{ take = "cup", for_s = 2.0 }, { put = "cup", on = [4.0, 0.8, 9.0], for_s = 2.0 }]

[[rules]]
on = "full"
do = [{ set = "thirst", to = 0.7 }]
"#;

fn lines(stage: &Paper, what: &str) -> Vec<String> {
    stage.log.iter().filter(|line| line.contains(what)).cloned().collect()
}

#[test]
fn one_takes_a_thing_and_the_other_hears_that_it_is_taken() {
    let (brains, stage) = played(2, CUP, &[], 20.0);
    // One second, the way, two seconds of taking, the way.
    let takes = format!("{:.6} 0 takes 0", 1.0 + WALK_S);
    let puts = format!("{:.6} 0 puts 0", 1.0 + WALK_S + 2.0 + WALK_S);
    assert_eq!((lines(&stage, "takes"), lines(&stage, "puts")), (vec![takes], vec![puts]));
    assert_eq!(stage.in_hand, []);
    assert!(!brains.has_claimed(0, 0) && !brains.has_claimed(1, 0));
    let thirst = |agent: u32| brains.feelings[agent as usize].value;
    assert_eq!([thirst(0), thirst(1)], [0.0, 0.7]);
}

#[test]
fn who_is_interrupted_before_the_grasp_has_no_claim() {
    // The fire interrupts at 3.5 s: between the arrival (2.7 s) and the end of taking (4.7 s).
    let flees = "\n[[rules]]\non = \"fire\"\npriority = 1\ndo = [{ stay = 1.0 }]\n";
    let text = format!("{}{flees}", CUP.replace(", { put = \"cup\", on = [4.0, 0.8, 9.0], for_s = 2.0 }", ""));
    let (brains, stage) = played(1, &text, &[], 4.0);
    assert!(!brains.has_claimed(0, 0) && stage.in_hand.is_empty(), "the hand had not closed");
    // Who was interrupted before by nothing takes it.
    let (brains, stage) = played(1, &text.replace(flees, ""), &[], 4.8);
    assert!(brains.has_claimed(0, 0) && stage.in_hand == [(0, 0)]);
}

#[test]
fn rules_ask_who_has_a_thing_and_who_leaves_lets_it_go() {
    let asks = r#"
[[rules]]
on = "fire"
when = "holds(me, 'cup') and taken('cup')"
do = [{ set = "thirst", to = 0.3 }]
"#;
    let text = format!("{}{asks}", CUP.replace("at_s = 3.5", "at_s = 4.9"));
    let (mut brains, mut stage) = played(2, &text, &[], 5.0);
    assert_eq!([brains.feelings[0].value, brains.feelings[1].value], [0.3, 0.7]);
    assert_eq!(stage.in_hand, [(0, 0)]);
    AgentBrains::handle_signal(&mut brains, &mut stage, 5.0, Signal::Left(0)).expect("it leaves");
    assert!(stage.in_hand.is_empty() && !brains.has_claimed(0, 0));
}

#[test]
fn what_cannot_be_taken_is_told_with_what_there_is() {
    let with = |rule: &str| refused(&format!("{CUP}\n[[rules]]\non = \"tea\"\ndo = [{rule}]\n"));
    let text = with("{ take = \"cub\" }");
    assert!(text.contains("there is no thing `cub`") && text.contains("cup"), "{text}");
    assert!(with("{ put = \"cup\", on = [1.0, 2.0] }").contains("x, y up, z"));
    assert!(refused("[[things]]\nname = \"cup\"\nat = [0.0, 11.0, 0.0]").contains("things[0].at[1]"));
    let twice = format!("{CUP}\n[[things]]\nname = \"cup\"\nat = [0.0, 1.0, 0.0]\n");
    assert!(refused(&twice).contains("expected a `name` of its own"));
}
