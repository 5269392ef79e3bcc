//! Every number on the command line has a range; what is outside of it is refused with the option and the range.

use super::{BundleFolder, at, done, folder, text, throng_soon};
use throng_core::base::limits::{self, Limit};

/// Options that take a number, and their ranges.
type Options = &'static [(&'static str, &'static Limit)];

/// Commands, and their options that are numbers. `BUNDLE` and `OUT` stand for a file and a folder, and what else is given
/// keeps runs short.
const NUMBERS: [(&[&str], Options); 11] = [
    (&["check", "OUT/absent.toml", "--run"], &[("seeds", &limits::REPEATS)]),
    (&["run", "BUNDLE", "--characters", "2", "--seconds", "0.1"], RUN),
    (&["demo", "--characters", "2", "--seconds", "0.1", "--out", "OUT/a.png", "--bundle", "OUT/a.throng"], TRIAL),
    (
        &["synth", "--minutes", "0.05", "--out", "OUT/clips"],
        &[("minutes", &limits::SYNTH_MINUTES), ("seed", &limits::SEED), ("rate-hz", &limits::RATE_HZ)],
    ),
    (
        &["bench", "bundle", "BUNDLE", "--characters", "2", "--threads", "1", "--seconds", "0.001"],
        &[("characters", &limits::CHARACTERS), ("threads", &limits::THREADS), ("seconds", &limits::MEASURING_S)],
    ),
    (
        &["bench", "crowd", "--scene", "ring", "--agents", "2", "--seconds", "0.1"],
        &[
            ("agents", &limits::CHARACTERS),
            ("threads", &limits::THREADS),
            ("seconds", &limits::SECONDS),
            ("repeats", &limits::REPEATS),
            ("seed", &limits::SEED),
        ],
    ),
    (
        &["build", "OUT/absent.toml", "--out", "OUT/b.throng"],
        &[
            ("cache-limit", &limits::CACHE_GB),
            ("metres-per-unit", &limits::METRES_PER_UNIT),
            ("rate-hz", &limits::MOTION_HZ),
        ],
    ),
    (
        &["export", "BUNDLE", "--format", "csv", "--characters", "0", "--from", "0", "--to", "0.1", "--fps", "30"],
        &[
            ("from", &limits::MOMENT_S),
            ("to", &limits::MOMENT_S),
            ("fps", &limits::EXPORT_HZ),
            ("metres-per-unit", &limits::METRES_PER_UNIT),
            ("rate-hz", &limits::MOTION_HZ),
        ],
    ),
    (
        &["query", "action", "BUNDLE", "--state", "0", "--target", "1,1"],
        &[
            ("state", &limits::STATE),
            ("target", &limits::COORDINATE),
            ("height", &limits::COORDINATE),
            ("time-left", &limits::SECONDS),
        ],
    ),
    (
        &["level", LEVEL, "--out", "OUT/a.level"],
        &[
            ("radius", &limits::RADIUS_M),
            ("height", &limits::HEIGHT_M),
            ("climb", &limits::CLIMB_M),
            ("slope", &limits::SLOPE_DEG),
        ],
    ),
    (
        &["query", "path", "BUNDLE", "--from", "1,1", "--to", "1,1"],
        &[("from", &limits::COORDINATE), ("to", &limits::COORDINATE)],
    ),
];

const LEVEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/level.geojson");

const RUN: Options = &[
    ("characters", &limits::CHARACTERS),
    ("seconds", &limits::SECONDS),
    ("step-hz", &limits::STEP_HZ),
    ("trajectory-hz", &limits::TRAJECTORY_HZ),
    ("seed", &limits::SEED),
    ("temperature", &limits::TEMPERATURE),
    ("follow", &limits::FOLLOWED),
    ("metres-per-unit", &limits::METRES_PER_UNIT),
    ("rate-hz", &limits::MOTION_HZ),
];

const TRIAL: Options = &[
    ("characters", &limits::CHARACTERS),
    ("seconds", &limits::SECONDS),
    ("step-hz", &limits::STEP_HZ),
    ("seed", &limits::SEED),
    ("temperature", &limits::TEMPERATURE),
    ("follow", &limits::FOLLOWED),
];

/// What is given to each.
const GIVEN: [&str; 7] = ["0", "-1", "NaN", "inf", "1e308", "4294967296", "18446744073709551615"];

#[test]
fn numbers_out_of_their_range_are_refused_with_option_and_range() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let mut refused = 0;
    for (command, options) in NUMBERS {
        for (option, limit) in options {
            for value in GIVEN {
                let is_point = limit.range == limits::COORDINATE.range;
                let given = if is_point { format!("1,{value}") } else { value.to_owned() };
                let mut args: Vec<String> = Vec::new();
                let mut words = command.iter().peekable();
                while let Some(word) = words.next() {
                    if *word == format!("--{option}") {
                        words.next();
                    } else {
                        args.push(word.replace("BUNDLE", &place.bundle()).replace("OUT", &at(&folder, "")));
                    }
                }
                // What is in range may take long; the ends of ranges are tried below.
                if limit.contains(value.parse().expect("a number")) {
                    continue;
                }
                args.extend([format!("--{option}"), given]);
                let args: Vec<&str> = args.iter().map(String::as_str).collect();
                let out = throng_soon(&args);
                let message = text(&out.stderr);
                assert_eq!(out.status.code(), Some(2), "{args:?}: {message}");
                let says = message.contains(&format!("--{option} <")) && message.contains(limit.range);
                assert!(says, "{args:?}: {message}");
                refused += 1;
            }
        }
    }
    assert!(refused > 150, "{refused}");
}

#[test]
fn numbers_at_the_ends_of_their_ranges_are_taken() {
    let (place, folder) = (BundleFolder::shared(), folder());
    let bundle = place.bundle();
    let run = ["run", &bundle, "--characters", "1", "--seconds", "0.001"];
    for more in [
        ["--seed", "18446744073709551615"],
        ["--seed", "0"],
        ["--step-hz", "1"],
        ["--step-hz", "10000"],
        ["--temperature", "0"],
        ["--temperature", "1000"],
        ["--follow", "0"],
    ] {
        done(&[&run[..], &more].concat());
    }
    done(&["synth", "--minutes", "0.05", "--rate-hz", "240", "--seed", "0", "--out", &at(&folder, "clips")]);
    done(&["query", "action", &bundle, "--state", "0", "--target", "-100000,100000"]);
}

/// Options whose values are named as numbers are in [`NUMBERS`].
#[test]
fn no_option_with_a_number_is_left_out() {
    for (command, options) in NUMBERS {
        let name: Vec<&str> =
            command.iter().copied().take_while(|w| w.chars().all(|c| c.is_ascii_lowercase())).collect();
        let help = done(&[&name[..], &["--help"]].concat());
        for line in help.lines().map(str::trim).filter(|l| l.starts_with("--")) {
            let mut words = line[2..].split_whitespace();
            let (option, value) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            let numbers = [
                "<N>",
                "<N,...>",
                "<S>",
                "<HZ>",
                "<T>",
                "<RAD_PER_M>",
                "<X,Z>",
                "<SEED>",
                "<MINUTES>",
                "<STATE>",
                "<M>",
            ];
            if numbers.contains(&value) {
                assert!(options.iter().any(|(o, _)| *o == option), "{name:?} --{option} {value}");
            }
        }
    }
}
