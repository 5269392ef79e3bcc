//! `throng run` of a scene of a crowd.

use super::{Args, make_bundle};
use crate::args::{Outcome, fail};
use crate::output;
use serde::Serialize;
use throng_precompute::picture;
use throng_precompute::scene::crowd::{self, BodiesReport, CrowdReport, CrowdRun, CrowdScene};

/// What is printed.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    crowd: &'a CrowdReport,
    #[serde(flatten)]
    bodies: Option<&'a BodiesReport>,
}

/// Runs a scene of a crowd; the bundle of its bodies is built where it is not there.
pub fn run(args: &Args) -> Outcome {
    let mut scene = CrowdScene::load(&args.file)?;
    if !args.without.is_empty() {
        return fail("--without is for scenes with behaviours");
    }
    let mut members = scene.num_members();
    args.crowd.change_living(&mut members, &mut scene.seed)?;
    if members != scene.num_members() {
        scene = scene.resized(members);
        scene.check(&args.file)?;
    }
    if let Some(bundle) = &args.bundle {
        match &mut scene.bodies {
            Some(bodies) => (bodies.bundle, bodies.config) = (bundle.clone(), None),
            None => return fail("--bundle: the scene has no table `bodies` whose bundle it could replace"),
        }
    }
    let seconds = args.crowd.seconds().map_or(scene.seconds, f64::from);
    let config = CrowdRun { seconds: Some(seconds), recorded: args.png.is_some(), ..CrowdRun::default() };
    let (report, record) = crowd::run(&scene, &config)?;
    let mut pictures = vec![picture::crowd_sheet(&report, &record)];
    let mut walked = None;
    if let Some(bodies) = &scene.bodies {
        make_bundle(&bodies.bundle, bodies.config.as_deref(), &args.cache)?;
        let tables = crate::args::open(&bodies.bundle)?;
        let (poses, report) = crowd::walk_bodies(&scene, bodies, &tables, seconds)?;
        pictures.push(picture::bodies_sheet(&record, &poses));
        walked = Some(report);
    }
    if let Some(png) = &args.png {
        picture::sheet(&pictures.iter().collect::<Vec<_>>()).save_png(png)?;
    }
    if args.json {
        return output::json(&Report { crowd: &report, bodies: walked.as_ref() });
    }
    print(&report)?;
    walked.iter().try_for_each(print_bodies)
}

/// What was measured, for people.
pub fn print(r: &CrowdReport) -> Outcome {
    let mut rows = vec![
        ("scene", format!("{}: {} member(s), {:.0} s, engine {}", r.scene, r.members, r.simulated_s, r.engine)),
        (
            "progress",
            format!(
                "{:.2} m/s towards the goal of {:.2} wanted; {} there, {} stuck",
                r.progress_mps, r.desired_mps, r.arrived, r.stuck
            ),
        ),
        (
            "overlaps",
            format!(
                "{:.3} % of member-frames by more than 1 mm, {:.3} % by more than 1 cm; {:.2} mm at most",
                100.0 * r.overlap_over_1mm_fraction,
                100.0 * r.overlap_over_1cm_fraction,
                1000.0 * r.max_overlap_m
            ),
        ),
    ];
    if let Some(order) = r.lane_order {
        rows.push(("lanes", format!("order {order:.2}: 0 as mixed as by chance, 1 everybody in a lane")));
    }
    if let Some(flow) = &r.flow {
        let [low, high] = flow.human_flow_per_m_s;
        let measured = flow.flow_per_m_s.map_or("too few for a flow".to_owned(), |f| format!("{f:.2} persons/(m s)"));
        rows.push(("gate", format!("{} crossed, {measured}; people: {low} to {high}", flow.crossed)));
    }
    if let Some(informed) = r.informed {
        rows.push(("news", format!("{informed} of {} know", r.members)));
    }
    let crossings =
        r.crossings_per_member_second.map_or(String::new(), |c| format!(" ({c:.1} of them crossings of cells)"));
    rows.push((
        "speed",
        format!(
            "{:.2} us a member and simulated second; {:.1} events{crossings}, {:.1} decisions",
            r.us_per_member_second, r.events_per_member_second, r.decisions_per_member_second
        ),
    ));
    output::table(&rows)
}

fn print_bodies(b: &BodiesReport) -> Outcome {
    output::table(&[(
        "bodies",
        format!(
            "feet slip {:.3} m/s mean, {:.3} m/s 95th percentile, while planted; hips {:.2} m off their discs at most",
            b.foot_slip_mean_mps, b.foot_slip_p95_mps, b.hips_off_max_m
        ),
    )])
}
