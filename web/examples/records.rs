//! Writes the records of people and agents after some steps to standard output: what `scripts/web.sh --compare` compares
//! with the module's.
//!
//! `cargo run -p throng-web --example records -- BUNDLE COUNT STEPS`

use std::io::Write;
use throng_web::PageStage;

fn main() -> Result<(), String> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [bundle, count, steps] = args.as_slice() else { return Err("expected BUNDLE COUNT STEPS".into()) };
    let number = |text: &String| text.parse::<usize>().map_err(|e| format!("{text}: {e}"));
    let (count, steps) = (number(count)?, number(steps)?);
    let bytes = std::fs::read(bundle).map_err(|e| format!("{bundle}: {e}"))?;
    let mut stage = PageStage::open(&bytes)?;
    let mut out = std::io::stdout().lock();
    stage.spawn_people(count, 1).map_err(|e| e.to_string())?;
    run(&mut stage, steps, &mut out)?;
    stage.spawn_agents(count, 1).map_err(|e| e.to_string())?;
    run(&mut stage, steps, &mut out)
}

fn run(stage: &mut PageStage, steps: usize, out: &mut impl Write) -> Result<(), String> {
    (0..steps).try_for_each(|_| stage.step(1.0 / 60.0))?;
    out.write_all(bytemuck::cast_slice(&stage.records)).map_err(|e| e.to_string())
}
