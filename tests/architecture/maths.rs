//! Promise: the runtime gives the same bits on every machine, because it calls no library of the platform.

use super::workspace::{code, crates, sources};

/// Functions of floats, and those of glam that call them, whose last bits are the platform's.
const OF_THE_PLATFORM: &[&str] = &[
    "acos",
    "acosh",
    "acos_approx",
    "angle_between",
    "angle_to",
    "asin",
    "asinh",
    "atan",
    "atan2",
    "atanh",
    "cbrt",
    "cos",
    "cosh",
    "exp",
    "exp2",
    "exp_m1",
    "from_angle",
    "from_axis_angle",
    "from_euler",
    "from_rotation_axes",
    "from_rotation_x",
    "from_rotation_y",
    "from_rotation_z",
    "from_scaled_axis",
    "hypot",
    "lerp_angle",
    "ln",
    "ln_1p",
    "log",
    "log10",
    "log2",
    "mul_add",
    "powf",
    "powi",
    "rotate_axis",
    "rotate_towards",
    "rotate_x",
    "rotate_y",
    "rotate_z",
    "sin",
    "sin_cos",
    "sinh",
    "slerp",
    "tan",
    "tanh",
    "to_angle",
    "to_axis_angle",
    "to_euler",
    "to_scaled_axis",
];
/// Where these names stand for functions of the runtime's own.
const OURS: [&str; 1] = ["maths"];

/// Calls in a code: methods, and functions by their path.
fn calls(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    let words = code.match_indices(|c: char| c.is_alphanumeric() || c == '_').map(|(at, _)| at);
    let starts = words.filter(|&at| at == 0 || !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'));
    for at in starts {
        let word = code[at..].split(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
        if !OF_THE_PLATFORM.contains(&word) {
            continue;
        }
        let before = &code[..at];
        let called = if let Some(path) = before.strip_suffix("::") {
            let of = path.rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or_default();
            !OURS.contains(&of)
        } else {
            // A field may have such a name, too.
            before.ends_with('.') && code[at + word.len()..].starts_with('(')
        };
        if called {
            let line = before.matches('\n').count() + 1;
            found.push(format!("{line}: {word}"));
        }
    }
    found
}

/// Products of rotations by glam, which adds in another order on each kind of processor. Types are not known here: products
/// are told by the names of what is multiplied.
fn products(code: &str) -> Vec<String> {
    let of_a_rotation = |line: &str| {
        ["rotation() * ", "rotation * ", "inverse() * "].iter().any(|product| line.contains(product))
            || line.match_indices("translation()").any(|(at, _)| {
                let joint = |c: char| c.is_alphanumeric() || "_.[]()".contains(c);
                line[..at].trim_end_matches(joint).ends_with(" * ")
            })
            || ["mul_quat", "mul_vec3", "rotation_between", "rotation_arc"].iter().any(|call| line.contains(call))
    };
    let lines = code.lines().enumerate().filter(|(_, line)| of_a_rotation(line));
    lines.map(|(k, line)| format!("{}: {}", k + 1, line.trim())).collect()
}

#[test]
fn the_runtime_calls_no_mathematics_of_the_platform() {
    let mut files = 0;
    for c in crates().iter().filter(|c| c.is_in("runtime")) {
        for path in sources(&c.folder.join("src")) {
            let text = std::fs::read_to_string(&path).expect("a source file");
            // The module that stands in for them defines their names.
            let own = c.name == "throng-base" && path.ends_with("maths.rs");
            let code = code(&text);
            let found = if own { Vec::new() } else { [calls(&code), products(&code)].concat() };
            assert!(found.is_empty(), "{}: {found:?}; take those of throng_base::maths", path.display());
            files += 1;
        }
    }
    assert!(files > 100, "the sources were read: {files}");
}

/// Closures of lanes that have a name: called twice, they are functions of their own, which the compiler makes without the
/// processor's vectors, three times as slow.
fn closures_of_lanes(code: &str) -> Vec<String> {
    let is_one = |line: &str| {
        let Some((_, arguments)) = line.split_once("= |") else { return false };
        let arguments = arguments.split('|').next().unwrap_or_default();
        line.trim_start().starts_with("let ") && [": F", "<F>", "[F;"].iter().any(|lanes| arguments.contains(lanes))
    };
    let lines = code.lines().enumerate().filter(|(_, line)| is_one(line));
    lines.map(|(k, line)| format!("{}: {}", k + 1, line.trim())).collect()
}

#[test]
fn closures_of_lanes_have_no_names() {
    for c in crates().iter().filter(|c| c.is_in("runtime")) {
        for path in sources(&c.folder.join("src")) {
            let text = std::fs::read_to_string(&path).expect("a source file");
            let found = closures_of_lanes(&code(&text));
            assert!(found.is_empty(), "{}: {found:?}; write a function that is always inlined", path.display());
        }
    }
    let text = "let a = |v: V<F>, k: f32| v * k;\nlet b = |x: f32| x;\nlet c = v.map(|x: F| x);\nlet d = |[x, z]: [F; 2]| x + z;\n";
    assert_eq!(closures_of_lanes(text).len(), 2);
}

#[test]
fn calls_are_found_where_there_are_some() {
    let text = "let a = x.sin();\nlet b = f32::exp(y) + maths::exp(y);\nlet q = Quat::from_rotation_y(a);\n\
                fn sin() {}\nlet c = v.map(f32::cos).sinks();\nx.exp8() + place.sin; // x.tan()\n";
    assert_eq!(calls(&code(text)), ["1: sin", "2: exp", "3: from_rotation_y", "5: cos"]);
    let text = "let a = root.rotation() * v;\nlet b = maths::rotate(q, v) * 2.0;\nlet c = turn * pose[j].translation();\n\
                let d = 2.0 * angle; // rotation() * v\nlet e = -a.translation();\n";
    assert_eq!(products(&code(text)).len(), 2);
}
