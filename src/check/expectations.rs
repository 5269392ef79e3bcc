//! Expectations of a scene: whether runs meet them, and who breaks them.

use crate::args::{CommandResult, fail};
use std::fmt::Write;
use throng_precompute::run::{ExpectationReport, SceneRunConfig, check_expectations};
use throng_simulation::Scene;

/// Runs a scene where this is asked for.
pub fn run(scene: &Scene, args: &super::Args) -> CommandResult<Vec<ExpectationReport>> {
    if args.run { Ok(check_expectations(scene, args.seeds, &SceneRunConfig::default())?) } else { Ok(Vec::new()) }
}

/// Outcomes as text: each with its figure, and the agents that break it.
pub fn describe(all: &[ExpectationReport], num_seeds: u64) -> String {
    let number = |value: f64| match value {
        _ if value.is_nan() => "nothing measured".into(),
        _ if value.is_infinite() => "never".into(),
        _ => format!("{value:.3}"),
    };
    let mut text = String::new();
    for one in all {
        let verdict = if one.holds { "holds " } else { "BROKEN" };
        let [least, most] = one.bounds.map(|b| if b.is_finite() { format!("{b}") } else { "..".into() });
        _ = write!(text, "{verdict}  {}: {} (expected {least} to {most})", one.name, number(one.median));
        if num_seeds > 1 {
            _ = write!(text, ", worst {} with seed {}", number(one.worst), one.worst_seed);
        }
        text.push('\n');
        for who in &one.agents {
            let value = if who.value.is_finite() { format!("{:.3}, ", who.value) } else { String::new() };
            _ = writeln!(text, "        {value}at {:.1}, {:.1}: {}", who.at[0], who.at[1], who.why);
        }
    }
    text
}

/// Fails where an expectation is broken.
pub fn verdict(all: &[ExpectationReport]) -> CommandResult {
    let broken = all.iter().filter(|one| !one.holds).count();
    if broken == 0 { Ok(()) } else { fail(format!("{broken} of {} expectations are broken", all.len())) }
}
