//! Flat code against a walk over the tree.

use super::super::language::{
    Attribute, ExpressionNode, ExpressionTree, Load, NameList, Perception, ScenarioVocabulary, SpotName, Subject, Type,
    compile_expression, parse_expression, run_program,
};
use proptest::prelude::*;

/// Numbers by what is asked for; `random` counts.
struct World {
    draws: f64,
}

impl Perception for World {
    fn load_value(&mut self, what: Load) -> f64 {
        match what {
            Load::Time => 12.5,
            Load::Random => {
                self.draws += 1.0;
                self.draws * 0.125 % 1.0
            }
            Load::Of(Subject::Me, Attribute::Value(v)) => f64::from(v) + 0.25,
            Load::Of(_, Attribute::Value(v)) => 1.5 - f64::from(v),
            Load::Of(_, Attribute::Group) => 1.0,
            Load::Of(_, Attribute::News) => f64::from_bits(0b101),
            Load::Distance(_, SpotName::Place(p)) => 3.0 + f64::from(p),
            Load::Count(g) => 7.0 + f64::from(g),
            _ => 2.0,
        }
    }
}

fn names() -> ScenarioVocabulary {
    let list = |all: &[&str]| NameList(all.iter().map(|n| (*n).to_string()).collect());
    ScenarioVocabulary {
        groups: list(&["red", "blue"]),
        places: list(&["well", "gate"]),
        events: list(&["fire", "sale", "bell"]),
        values: list(&["anger", "joy"]),
        has_other: true,
        ..ScenarioVocabulary::default()
    }
}

/// What a tree is worth, by the plain meaning of its words.
fn walk(node: &ExpressionNode, world: &mut World) -> f64 {
    let truth = |is: bool| f64::from(u8::from(is));
    match &node.tree {
        ExpressionTree::Number(n) => *n,
        ExpressionTree::Truth(t) => truth(*t),
        ExpressionTree::Word(word) => match word.as_str() {
            "time" => 12.5,
            "random" => world.load_value(Load::Random),
            "me.anger" => 0.25,
            "me.joy" => 1.25,
            "other.anger" => 1.5,
            "other.joy" => 0.5,
            other => panic!("{other}"),
        },
        ExpressionTree::Unary("-", a) => -walk(a, world),
        ExpressionTree::Unary(_, a) => truth(walk(a, world) == 0.0),
        ExpressionTree::Binary("and", a, b) => {
            let a = walk(a, world);
            if a == 0.0 { 0.0 } else { walk(b, world) }
        }
        ExpressionTree::Binary("or", a, b) => {
            let a = walk(a, world);
            if a == 0.0 { walk(b, world) } else { a }
        }
        ExpressionTree::Binary("in", a, b) => match (&a.tree, &b.tree) {
            (ExpressionTree::Word(_), ExpressionTree::Set(all)) => {
                truth(all.iter().any(|n| matches!(&n.tree, ExpressionTree::Text(t) if t == "blue")))
            }
            (ExpressionTree::Text(name), _) => truth(name == "fire" || name == "bell"),
            _ => panic!(),
        },
        // The side that is compared to the right is worked out first where the sign points left.
        ExpressionTree::Binary(op @ (">" | ">="), a, b) => {
            let b = walk(b, world);
            let a = walk(a, world);
            truth(if *op == ">" { a > b } else { a >= b })
        }
        ExpressionTree::Binary(op, a, b) => {
            let (a, b) = (walk(a, world), walk(b, world));
            match *op {
                "+" => a + b,
                "-" => a - b,
                "*" => a * b,
                "/" => {
                    if b == 0.0 {
                        0.0
                    } else {
                        a / b
                    }
                }
                "<" => truth(a < b),
                "<=" => truth(a <= b),
                "==" => truth(a == b),
                _ => truth(a != b),
            }
        }
        ExpressionTree::Call(name, of) => match name.as_str() {
            "distance" => 4.0,
            "count" => 8.0,
            "if" => {
                if walk(&of[0], world) != 0.0 {
                    walk(&of[1], world)
                } else {
                    walk(&of[2], world)
                }
            }
            "clamp" => {
                let (a, most) = (walk(&of[0], world), walk(&of[2], world));
                a.min(most).max(walk(&of[1], world))
            }
            "abs" => walk(&of[0], world).abs(),
            "floor" => walk(&of[0], world).floor(),
            "sqrt" => walk(&of[0], world).max(0.0).sqrt(),
            _ => {
                let (a, b) = (walk(&of[0], world), walk(&of[1], world));
                if name == "min" { a.min(b) } else { a.max(b) }
            }
        },
        other => panic!("{other:?}"),
    }
}

fn number() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        (0u32..1000).prop_map(|n| format!("{}", f64::from(n) / 8.0)),
        prop::sample::select(vec![
            "time",
            "random",
            "me.anger",
            "me.joy",
            "other.anger",
            "other.joy",
            "distance(me, 'gate')",
            "count('blue')"
        ])
        .prop_map(String::from),
    ];
    leaf.prop_recursive(5, 40, 3, |inner| {
        let two = (inner.clone(), inner.clone(), prop::sample::select(vec!["+", "-", "*", "/"]));
        let truth = (inner.clone(), inner.clone(), prop::sample::select(vec!["<", "<=", ">", ">=", "==", "!="]))
            .prop_map(|(a, b, op)| format!("{a} {op} {b}"));
        prop_oneof![
            two.prop_map(|(a, b, op)| format!("({a} {op} {b})")),
            inner.clone().prop_map(|a| format!("-({a})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("min({a}, {b})")),
            (inner.clone(), inner.clone(), inner.clone()).prop_map(|(a, b, c)| format!("clamp({a}, {b}, {c})")),
            inner.clone().prop_map(|a| format!("floor(abs({a}))")),
            (truth, inner.clone(), inner).prop_map(|(t, a, b)| format!("if({t}, {a}, {b})")),
        ]
    })
}

fn predicate() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        (number(), number(), prop::sample::select(vec!["<", "<=", ">", ">=", "==", "!="]))
            .prop_map(|(a, b, op)| format!("{a} {op} {b}")),
        Just("'sale' in me.news".to_string()),
        Just("'bell' in me.news".to_string()),
        Just("me.group in { 'red' }".to_string()),
        Just("me.group in { 'red', 'blue' }".to_string()),
        Just("true".to_string()),
    ];
    leaf.prop_recursive(4, 24, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone(), any::<bool>())
                .prop_map(|(a, b, and)| format!("({a}) {} ({b})", if and { "and" } else { "or" })),
            inner.prop_map(|a| format!("not ({a})")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]
    #[test]
    fn flat_code_is_worth_what_its_tree_is(text in predicate()) {
        let tree = parse_expression(&text).unwrap();
        let mut code = Vec::new();
        let program = match compile_expression(&tree, Type::Truth, &names(), &mut code) {
            Ok(program) => program,
            Err(fault) => {
                // Only what is too deep for the stack, or divides by 0, is refused.
                prop_assert!(text.len() > 200 || fault.why.contains("divide by"), "{}", text);
                return Ok(());
            }
        };
        let (mut a, mut b) = (World { draws: 0.0 }, World { draws: 0.0 });
        prop_assert_eq!(run_program(&code, program, &mut a), walk(&tree, &mut b), "{}", text);
        prop_assert_eq!(a.draws, b.draws, "as many numbers by chance: {}", text);
    }

    #[test]
    fn no_text_panics(text in "\\PC{0,60}") {
        if let Ok(tree) = parse_expression(&text) {
            _ = compile_expression(&tree, Type::Truth, &names(), &mut Vec::new());
        }
    }

    #[test]
    fn no_text_of_words_panics(words in prop::collection::vec(prop::sample::select(vec!["me", ".", "(", ")", "{", "}", ",", "and", "or", "not", "<", "==", "in", "'red'", "1", "random", "distance", "if", "me.group", "me.news", "-", "other"]), 0..24)) {
        if let Ok(tree) = parse_expression(&words.join(" ")) {
            _ = compile_expression(&tree, Type::Truth, &names(), &mut Vec::new());
        }
    }
}

#[test]
fn deep_brackets_are_refused_and_do_not_overflow() {
    let text = format!("{}1{}", "(".repeat(100_000), ")".repeat(100_000));
    assert!(parse_expression(&text).unwrap_err().why.contains("levels"));
    let text = format!("{}true", "not ".repeat(100_000));
    assert!(parse_expression(&text).is_err());
}

#[test]
fn places_are_no_values_to_choose_among() {
    let fault =
        compile_expression(&parse_expression("if(true, me, me)").unwrap(), Type::Truth, &names(), &mut Vec::new())
            .unwrap_err();
    assert!(fault.why.contains("expected a value, found somebody or somewhere"), "{}", fault.why);
}

#[test]
fn long_expressions_are_refused_and_do_not_overflow() {
    let text = |operators: usize| format!("1{} > 0", "+1".repeat(operators - 1));
    assert!(compile_expression(&parse_expression(&text(500)).unwrap(), Type::Truth, &names(), &mut Vec::new()).is_ok());
    assert!(parse_expression(&text(200_000)).unwrap_err().why.contains("at most 500 operators"));
}

#[test]
fn amounts_below_zero_and_divisions_by_zero_are_refused() {
    let told = |does: &str| super::refused(&format!("[[rules]]\non = \"starts\"\ndo = [{does}]\n"));
    for (does, why) in [
        ("{ stay = -1 }", "expected 0 or more, found -1"),
        ("{ go = [3.0, 0.0], within_m = -0.5 }", "expected 0 or more, found -0.5"),
        ("{ stay = \"1 / 0\" }", "expected another number to divide by than 0"),
    ] {
        assert!(told(does).contains(why), "{does}: {}", told(does));
    }
}
