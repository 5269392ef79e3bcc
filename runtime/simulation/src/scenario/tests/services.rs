//! Services: order in line, tills that are taken while people wait, who goes away, and exact figures.

use super::super::ServiceStatistics;
use crate::scene::Scene;
use crate::{ExpectationWatch, Simulation};
use std::path::Path;

/// Ten people who come to two desks with one line.
const TICKETS: &str = "seconds = 120.0\n[[groups]]\nname = \"people\"\nmotion = \"none\"\ncount = 10\ngraph = \"life\"\n\
    place = { block = { from = [-10.0, -22.0], to = [10.0, -14.0] } }\n\
    [[places]]\nname = \"line\"\nat = [0.0, -2.0]\nqueue = { points = [[0.0, -1.6], [0.0, -12.0]], spacing_m = 1.0 }\n\
    [[places]]\nname = \"other line\"\nat = [4.0, -2.0]\nqueue = { points = [[4.0, -1.6], [4.0, -12.0]], spacing_m = 1.0 }\n\
    [[places]]\nname = \"desk\"\nat = [0.0, 1.0]\nslots = [{ at = [-0.7, 0.0] }, { at = [4.0, 0.0] }]\n\
    [[services]]\nname = \"tickets\"\ntills = \"desk\"\nlines = [\"line\"]\ntime_s = { fixed = 8.0 }\n\
    [graphs.life]\nlevel = \"social\"\nstart = \"a\"\nedges = [{ from = \"a\", to = \"had\" }, { from = \"a\", to = \"gone\", \
    on = \"full\" }, { from = \"a\", to = \"gone\", on = \"gives_up\" }]\n[graphs.life.states]\n\
    a = { do = [{ be_served = \"tickets\" }] }\nhad = { do = [{ go = [30.0, 20.0] }, { stay = 1000 }] }\n\
    gone = { do = [{ go = [-30.0, 20.0] }, { stay = 1000 }] }\n";

struct Run {
    of: ServiceStatistics,
    states: Vec<(String, usize)>,
    holds: Vec<bool>,
}

fn compiled(text: &str) -> crate::CompiledScene {
    Scene::parse(text, Path::new("a.toml")).and_then(|s| s.open()).unwrap_or_else(|e| panic!("{e}"))
}

fn states(sim: &Simulation) -> Vec<(String, usize)> {
    let mut states = sim.brains().unwrap().num_in_states();
    states.sort();
    states
}

fn run(text: &str) -> Run {
    let scene = compiled(text);
    let (mut sim, mut watch) = (Simulation::new(&scene).unwrap(), ExpectationWatch::new(&scene));
    while sim.time_s() < scene.scene().seconds {
        sim.step(1.0 / 30.0).unwrap();
        watch.iter_mut().for_each(|w| w.observe(&sim));
    }
    let outcomes = watch.map(|w| w.finish(&sim, |_, _| None).unwrap()).unwrap_or_default();
    let holds = outcomes.iter().map(|o| o.holds && o.values > 0).collect();
    Run { of: sim.statistics().services.remove(0), states: states(&sim), holds }
}

#[test]
fn all_are_served_in_order_and_tills_are_taken_while_anybody_waits() {
    let expect = "[[expect]]\nname = \"in order\"\nthat.queue = \"line\"\n\
        [[expect]]\nname = \"waits\"\nthat.wait = \"tickets\"\nmost = 60.0\n";
    let good = run(&format!("{TICKETS}{expect}"));
    let of = &good.of;
    assert_eq!((of.served, of.balked, of.gave_up, of.line_now), (10, 0, 0, 0), "{of:?}");
    assert_eq!((&good.states[..], &good.holds[..]), (&[("had".to_string(), 10)][..], &[true; 2][..]));
    assert!(of.taken_while_waiting > 0.99 && of.busy_while_waiting > 0.6, "{of:?}");
    assert!(of.tills.iter().all(|t| t.served >= 4 && (t.busy_s - 8.0 * f64::from(t.served)).abs() < 1e-3), "{of:?}");
    let whole = |t: &super::super::TillStatistics| t.busy_s + t.approached_s + t.idle_s;
    assert!(of.tills.iter().all(|t| (whole(t) - 120.0).abs() < 0.05), "{of:?}");
    assert!(of.line_max >= 4 && of.wait_p90_s > of.wait_mean_s && of.wait_max_s < 60.0, "{of:?}");
    // One desk that takes a minute for each keeps them waiting.
    let slow = TICKETS.replace("fixed = 8.0", "fixed = 60.0");
    assert!(!run(&format!("{slow}{expect}")).holds[1]);
}

#[test]
fn who_finds_the_line_too_long_goes_away_and_who_waits_too_long_leaves() {
    let balk = run(&TICKETS.replace("fixed = 8.0 }", "fixed = 30.0 }\nbalk = \"place.held >= 3\""));
    assert!(balk.of.balked > 0 && balk.of.line_max <= 3 && balk.of.gave_up == 0, "{:?}", balk.of);
    assert!(balk.states.contains(&("gone".into(), balk.of.balked as usize)), "{:?}", balk.states);
    let patience = run(&TICKETS.replace("fixed = 8.0 }", "fixed = 30.0 }\npatience_s = { even = [5.0, 6.0] }"));
    let of = &patience.of;
    assert!(of.gave_up > 3 && of.wait_max_s < 10.0 && of.balked == 0, "{of:?}");
    assert!(patience.states.contains(&("gone".into(), of.gave_up as usize)), "{:?}", patience.states);
}

#[test]
fn lines_of_their_own_are_joined_evenly_and_priority_goes_first() {
    let apart = TICKETS.replace("lines = [\"line\"]", "lines = [\"line\", \"other line\"]\napart = true");
    let apart = run(&apart).of;
    assert!(apart.served == 10 && apart.tills.iter().all(|t| t.served >= 4), "{apart:?}");
    let ranked = TICKETS.replace("fixed = 8.0 }", "fixed = 12.0 }\npriority = \"if(me.number >= 8, 1, 0)\"");
    let scene = compiled(&ranked);
    let mut sim = Simulation::new(&scene).unwrap();
    let mut had = Vec::new();
    while sim.time_s() < 90.0 {
        sim.step(1.0 / 30.0).unwrap();
        for (a, own) in sim.brains().unwrap().engagements.iter().enumerate() {
            if own.served > 0 && !had.contains(&a) {
                had.push(a);
            }
        }
    }
    let place = |a: usize| had.iter().position(|b| *b == a).unwrap();
    assert!(place(8) < 6 && place(9) < 6, "those with priority are served before most others: {had:?}");
}

#[test]
fn times_are_drawn_from_their_distributions_and_snapshots_keep_all() {
    for (time, mean, spread) in [
        ("{ even = [4.0, 12.0] }", 8.0, 2.31),
        ("{ exponential = 8.0 }", 8.0, 8.0),
        ("{ normal = [8.0, 2.0] }", 8.0, 2.0),
    ] {
        let scene = Scene::parse(&TICKETS.replace("{ fixed = 8.0 }", time), Path::new("a.toml")).unwrap();
        let chance = |side: u64, k: u32| crate::scenario::hashed_chance(side, k, 7);
        let drawn: Vec<f64> =
            (0..4000).map(|k| scene.services[0].time_s.time_at([chance(1, k), chance(2, k)])).collect();
        let average = drawn.iter().sum::<f64>() / 4000.0;
        let off = (drawn.iter().map(|t| (t - average).powi(2)).sum::<f64>() / 4000.0).sqrt();
        assert!((average - mean).abs() < 0.3 && (off - spread).abs() < 0.3, "{time}: {average} {off}");
    }
    let scene = compiled(&TICKETS.replace("fixed = 8.0 }", "exponential = 8.0 }\npatience_s = { exponential = 20.0 }"));
    let mut sim = Simulation::new(&scene).unwrap();
    (0..900).for_each(|_| sim.step(1.0 / 30.0).unwrap());
    let bytes = sim.snapshot();
    let mut other = Simulation::new(&scene).unwrap();
    other.restore(&bytes).unwrap();
    for sim in [&mut sim, &mut other] {
        (0..900).for_each(|_| sim.step(1.0 / 30.0).unwrap());
    }
    assert_eq!(sim.statistics(), other.statistics());
    assert_eq!(sim.snapshot(), other.snapshot());
    assert!(sim.statistics().services[0].served > 2);
}

#[test]
fn faults_of_services_name_their_key() {
    for (from, to, wanted) in [
        ("tills = \"desk\"", "tills = \"line\"", "services[0].tills"),
        ("lines = [\"line\"]", "lines = [\"desk\"]", "services[0].lines[0]"),
        ("lines = [\"line\"]", "lines = [\"lime\"]", "services[0].lines[0]"),
        ("lines = [\"line\"]", "lines = [\"line\"]\napart = true", "services[0].lines"),
        ("fixed = 8.0", "even = [8.0, 2.0]", "services[0].time_s.even"),
        ("fixed = 8.0 }", "fixed = 8.0 }\nbalk = \"place.hold > 1\"", "services[0].balk"),
        ("be_served = \"tickets\"", "be_served = \"ticket\"", "`tickets`"),
    ] {
        let scene = Scene::parse(&TICKETS.replacen(from, to, 1), Path::new("a.toml"));
        let told = scene.and_then(|s| s.open()).unwrap_err().to_string();
        assert!(told.contains(wanted), "{to}: {told}");
    }
}

#[test]
fn who_waits_for_its_family_leaves_the_till_to_the_next() {
    let families = |sizes: &str, gap_m: f32, time_s: f32| {
        let text = TICKETS.replace("count = 10\n", &format!("count = 10\ncompanions = {sizes}\n"));
        let text = text
            .replace("seconds = 120.0", "seconds = 300.0")
            .replace("at = [4.0, 0.0]", &format!("at = [{gap_m}, 0.0]"));
        run(&text.replace("fixed = 8.0", &format!("fixed = {time_s:?}")))
    };
    for (sizes, gap_m, time_s) in
        [("[3, 4]", 4.0, 8.0), ("[3, 4]", 1.3, 8.0), ("[2, 3]", 1.3, 12.0), ("[4, 4]", 2.0, 5.0), ("[2, 2]", 0.7, 6.0)]
    {
        let Run { of, states, .. } = families(sizes, gap_m, time_s);
        assert_eq!((of.served, states), (10, vec![("had".to_string(), 10)]), "{sizes} {gap_m} {time_s}: {of:?}");
        assert!(of.busy_while_waiting > 0.5, "{sizes} {gap_m} {time_s}: {of:?}");
    }
}
