//! Sample predicate of ten operations, for measuring time.

use super::language::{Load, Perception, ScenarioVocabulary, Type, compile_expression, parse_expression, run_program};

/// Evaluates `not (time * 2 + 1 > 5 and time < 100) or time - 3 == 4` so many times; returns the sum.
pub fn evaluate_sample(times: u32) -> f64 {
    struct SampleClock(f64);
    impl Perception for SampleClock {
        fn load_value(&mut self, _: Load) -> f64 {
            self.0
        }
    }
    let mut code = Vec::new();
    let text = "not (time * 2 + 1 > 5 and time < 100) or time - 3 == 4";
    let program = parse_expression(text)
        .and_then(|node| compile_expression(&node, Type::Truth, &ScenarioVocabulary::default(), &mut code));
    let Ok(program) = program else { return f64::NAN };
    let mut sum = 0.0;
    for i in 0..times {
        sum += run_program(&code, program, &mut SampleClock(f64::from(i & 127)));
    }
    sum
}
