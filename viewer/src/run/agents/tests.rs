use super::*;
use crate::fixtures::meeting::Meeting;
use crate::fixtures::paces::Paces;
use std::path::Path;

fn run(path: &Path) -> CrowdRun {
    CrowdRun::new(&CrowdScene::load(path).unwrap(), None, None).unwrap()
}

fn steps(run: &mut CrowdRun, steps: u32) {
    run.want(steps);
    assert_eq!(run.advance(0.0, None).unwrap(), steps);
}

#[test]
fn a_step_taken_in_pieces_equals_a_whole_step() {
    let meeting = Meeting::new();
    let path = meeting.scene(12);
    let (mut whole, mut cut) = (run(&path), run(&path));
    steps(&mut whole, 40);
    cut.want(40);
    let (mut frames, mut shown) = (0, 0);
    while cut.is_busy() {
        // As if every step took long.
        cut.spent_s[1] = 6.0 * PIECE_S;
        shown += cut.advance(0.0, Some(Instant::now())).unwrap();
        frames += 1;
        assert!(frames <= 400, "it does not get on");
    }
    assert!(shown == 40 && frames > 150, "{shown} steps in {frames} frames");
    assert_eq!(cut.state_hash(), whole.state_hash());
    assert!(cut.moment() == whole.moment());
    let all = [true; What::COUNT];
    assert!(cut.log().last(&all, 9.0, 500) == whole.log().last(&all, 9.0, 500));
}

#[test]
fn bodies_go_with_their_agents_and_leave_with_them() {
    let paces = Paces::new();
    let scene = CrowdScene::load(&paces.crowd(6)).unwrap();
    let bundle = Arc::new(OpenBundle::open(&paces.bundle()).unwrap());
    let of = |kept: Option<&[u8]>| CrowdRun::new(&scene, kept, Some(Arc::clone(&bundle))).unwrap();
    let mut run = of(None);
    let farthest = |run: &CrowdRun| {
        let (moment, bodies) = (run.moment(), run.moment().bodies.as_ref().unwrap());
        let off = |(i, &m): (usize, &u32)| {
            let hips = bodies.poses[i * NUM_JOINTS].translation();
            let hips = bodies.roots[i].transform_point(Vec2::new(hips.x, hips.z));
            moment.agents[m as usize].unwrap().at.distance(Vec3::new(hips.x, 0.0, hips.y))
        };
        bodies.agents.iter().enumerate().map(off).fold(0.0, f32::max)
    };
    let there = |run: &CrowdRun| run.moment().agents.iter().flatten().count();
    assert_eq!((run.cast().skeletons.is_empty(), there(&run)), (false, 12));
    let mut off: f32 = 0.0;
    for _ in 0..40 {
        steps(&mut run, 9);
        let bodies = run.moment().bodies.as_ref().unwrap();
        assert_eq!((bodies.agents.len(), bodies.poses.len()), (there(&run), there(&run) * NUM_JOINTS));
        off = off.max(farthest(&run));
    }
    assert!(off < 0.35, "{off} m from the disc");
    assert!((6..12).contains(&there(&run)), "{} are there", there(&run));
    // They are kept with what was seen, and restart where a state is restored.
    let (seen, kept) = (run.moment().clone(), run.snapshot());
    run.reel.head.seek(60);
    assert!(run.moment().bodies != seen.bodies);
    run.reel.head.seek(u32::MAX);
    assert!(*run.moment() == seen);
    let again = of(Some(&kept));
    assert!(there(&again) == there(&run) && farthest(&again) < 0.35, "{}", farthest(&again));
    let discs = CrowdRun::new(&scene, None, None).unwrap();
    assert!(discs.moment().bodies.is_none() && discs.cast().skeletons.is_empty());
}

#[test]
fn a_rewound_scene_continues_where_it_was() {
    let meeting = Meeting::new();
    for path in [meeting.scene(12), meeting.flock(12)] {
        let mut run = run(&path);
        run.watch(Some(3));
        steps(&mut run, 90);
        let seen = run.moment().clone();
        assert!((seen.time_s - 1.5).abs() < 1e-9 && seen.agents.len() == 24);
        assert_eq!((seen.figures.present, seen.figures.overlaps, seen.figures.stuck), (24, 0, 0));
        assert!(seen.figures.deepest_m <= 1e-3 && seen.figures.progress_mps > 0.3, "{:?}", seen.figures);
        run.reel.head.seek(20);
        assert!(run.moment().agents != seen.agents);
        steps(&mut run, 70);
        assert!(*run.moment() == seen);
        assert!(run.trail(3, 1.0).count() > 8);
        let way = run.way(3);
        assert!(way[0].distance(run.trail(3, 9.0).next().unwrap()) < 1e-3);
    }
}

#[test]
fn events_are_recorded_with_their_place_and_counted() {
    let meeting = Meeting::new();
    let mut run = run(&meeting.scene(12));
    steps(&mut run, 120);
    let totals = run.log().rates().totals(f64::INFINITY);
    let all = run.log().last(&[true; What::COUNT], f64::INFINITY, 100_000);
    assert_eq!(totals.iter().sum::<u64>(), all.len() as u64);
    assert!(totals[What::Resetting.number()] > 0 && totals[What::Colliding.number()] > 0, "{totals:?}");
    for h in &all {
        let near = |m: usize, at: Vec3| {
            let trail = run.reel.before(9.0, 1).filter_map(|s| Some(s.agents[m].as_ref()?.at.distance(at)));
            trail.fold(f32::INFINITY, f32::min) < 0.05
        };
        assert!(near(h.agent, h.at), "{h:?}");
        match (h.with, h.other_at) {
            (With::Agent(other), Some(at)) => assert!(near(other, at), "{h:?}"),
            (With::Agent(_), None) => panic!("{h:?}"),
            (_, other_at) => assert_eq!(other_at, None),
        }
    }
}

#[test]
fn the_selected_agent_has_forces_and_a_bound() {
    let meeting = Meeting::new();
    let mut run = run(&meeting.scene(12));
    steps(&mut run, 60);
    assert_eq!(run.moment().details, None);
    run.watch(Some(7));
    let (seen, d) = (run.moment().agents[7].unwrap(), run.moment().details.clone().unwrap());
    assert_eq!(d.agent, 7);
    assert!(d.forces[0].length() > 0.0 && d.taken.length() <= d.limit * 1.001, "{d:?}");
    assert!(d.events[0] <= 1.0 && d.events[1] >= 1.0, "{:?}", d.events);
    assert!(seen.at.distance(seen.bound) + run.cast().radii[7] <= seen.bound_radius + 1e-4);
    // It is registered in a cell that it cannot have left by far.
    let centre = d.cell + Vec3::new(0.5, 0.0, 0.5) * d.cell_side;
    let off = (seen.at - centre).with_y(0.0).abs().max_element();
    assert!(off <= d.cell_side, "{off} m off the centre of a cell of {} m", d.cell_side);
    steps(&mut run, 10);
    assert_eq!(run.moment().details.as_ref().map(|d| d.agent), Some(7));
    run.watch(None);
    assert_eq!(run.moment().details, None);
}
