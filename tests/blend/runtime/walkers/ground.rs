//! Feet on ground that is not a plane: every part that is flagged as planted counts, heel and ball each by itself.

use super::*;

/// Walkers, and the side of the ground, which lies around them (m).
const WALKERS: usize = 10;
const SIDE_M: f32 = 64.0;
/// Nothing counts before they walk (s).
const FIRST_S: f32 = 1.0;

/// Ground of a height (m) at knots so far apart (m).
fn field(spacing: f32, height: impl Fn(Vec2) -> f32) -> HeightField {
    let n = (SIDE_M / spacing) as usize + 1;
    let origin = Vec2::new(-8.0, -12.0);
    let at = |i: usize| origin + spacing * Vec2::new((i % n) as f32, (i / n) as f32);
    HeightField::new(origin, spacing, [n, n], (0..n * n).map(|i| height(at(i))).collect()).expect("a field")
}

/// A number between -1 and 1 that depends on a cell of a grid.
fn random(cell: Vec2) -> f32 {
    let key = (cell.x as i32 as u32).wrapping_mul(0x9E37_79B9) ^ (cell.y as i32 as u32).wrapping_mul(0x85EB_CA6B);
    let mixed = (key ^ (key >> 15)).wrapping_mul(0x2C1B_3C6D);
    let mixed = (mixed ^ (mixed >> 12)).wrapping_mul(0x297A_2D39);
    ((mixed ^ (mixed >> 15)) & 0xffff) as f32 / 32767.5 - 1.0
}

fn grounds() -> [(&'static str, HeightField); 6] {
    [
        ("sine", field(0.25, |p| 0.15 * (1.6 * p.x).sin() * (1.9 * p.y).cos())),
        ("knots of 0.1 m", field(1.0, |p| 0.1 * random(p))),
        ("stairs of 0.1 m", field(0.05, |p| 0.1 * (p.y / 0.4 + 1e-3).floor())),
        ("stairs of 0.17 m", field(0.05, |p| 0.17 * (p.y / 0.35 + 1e-3).floor())),
        ("plateaus of 0.1 m", field(0.05, |p| 0.05 * random((p / 1.3 + Vec2::splat(1e-3)).floor()))),
        ("rubble", field(0.3, |p| 0.03 * random(p / 0.3))),
    ]
}

/// One walker at one moment: its hips, the planted parts of its feet, and how far its knees are bent (rad).
type Moment = (Vec3, [[Option<Vec3>; 2]; 2], [f32; 2]);

/// Distances of planted parts from the ground (m), and their speeds (m/s), ascending.
struct Seen {
    gaps: Vec<f32>,
    speeds: Vec<f32>,
    /// Fastest change of the height of the hips (m/s), and share of feet that are planted.
    hips_mps: f32,
    planted: f32,
    knee_rate: f32,
}

impl Seen {
    fn p95(values: &[f32]) -> f32 {
        values[values.len() * 95 / 100]
    }
}

fn walk(ground: &HeightField, course: Course, seconds: f32) -> Seen {
    let made_up = MadeUp::locomotion();
    let mut outing = Outing::new(&made_up, WalkersConfig::default(), WALKERS);
    outing.walkers.set_ground(ground.clone());
    let (mut gaps, mut speeds) = (Vec::new(), Vec::new());
    let mut before: Vec<Option<Moment>> = vec![None; WALKERS];
    let (mut hips_mps, mut knee_rate, mut planted, mut steps) = (0.0f32, 0.0f32, 0, 0);
    while outing.time_s < seconds {
        outing.step(course);
        if outing.time_s < FIRST_S {
            continue;
        }
        for (c, before) in before.iter_mut().enumerate() {
            let contacts = outing.walkers.contacts(c);
            let soles = [0, 1].map(|side| sole(&outing.walkers, c, side));
            let down =
                [0, 1].map(|side| [0, 1].map(|k| contacts.any(Contacts::FEET[side][k]).then_some(soles[side][k])));
            let hips = outing.walkers.pose(c)[0].translation();
            let knees = [0, 1].map(|side: usize| {
                let leg = [
                    [Joint::LeftThigh, Joint::LeftShin, Joint::LeftFoot],
                    [Joint::RightThigh, Joint::RightShin, Joint::RightFoot],
                ][side];
                let [a, b, d] = leg.map(|j| outing.walkers.pose(c)[j.index()].translation());
                (b - a).angle_between(d - b)
            });
            for part in down.iter().flatten().flatten() {
                gaps.push((part.y - ground.ground_at(Vec2::new(part.x, part.z), 0.0).height).abs());
            }
            steps += 2;
            planted += down.iter().filter(|foot| foot.iter().any(Option::is_some)).count();
            if let Some((was_hips, was_down, was_knees)) = before.replace((hips, down, knees)) {
                hips_mps = hips_mps.max((hips.y - was_hips.y).abs() / DT_S);
                for side in 0..2 {
                    knee_rate = knee_rate.max((knees[side] - was_knees[side]).abs() / DT_S);
                    for k in 0..2 {
                        if let (Some(now), Some(was)) = (down[side][k], was_down[side][k]) {
                            speeds.push((now - was).length() / DT_S);
                        }
                    }
                }
            }
        }
    }
    gaps.sort_by(f32::total_cmp);
    speeds.sort_by(f32::total_cmp);
    Seen { gaps, speeds, hips_mps, planted: planted as f32 / steps as f32, knee_rate }
}

/// Straight on, at other speeds.
fn ahead(c: usize, _: f32) -> (Vec2, Option<f32>) {
    (Vec2::new(0.0, 0.6 + 0.12 * c as f32), None)
}

#[test]
fn planted_parts_stay_on_broken_ground() {
    let on = |ground: &HeightField, course: Course| walk(ground, course, 16.0);
    let flat = [ahead as Course, wandering].map(|course| on(&HeightField::flat(), course).planted);
    for (name, ground) in grounds() {
        for (course, flat) in [ahead as Course, wandering].into_iter().zip(flat) {
            let seen = on(&ground, course);
            let (gap, speed) = (Seen::p95(&seen.gaps), Seen::p95(&seen.speeds));
            let (worst_gap, worst_speed) = (seen.gaps[seen.gaps.len() - 1], seen.speeds[seen.speeds.len() - 1]);
            let Seen { hips_mps, planted, knee_rate, .. } = seen;
            println!("{name}: off {gap} {worst_gap} m, slip {speed} {worst_speed} m/s, hips {hips_mps} m/s");
            println!("    planted {planted} of the time, on flat ground {flat}; knees {knee_rate} rad/s");
            assert!(gap < 0.005 && worst_gap < 0.015, "{name}: {gap} and {worst_gap} m off the ground");
            assert!(speed < 0.08 && worst_speed < 0.55, "{name}: slips at {speed} and {worst_speed} m/s");
            assert!(hips_mps < 1.6, "{name}: hips go up or down at {hips_mps} m/s");
            assert!(planted > 0.75 * flat, "{name}: planted for {planted} of the time, on flat ground for {flat}");
            assert!(knee_rate < 24.0, "{name}: a knee turns at {knee_rate} rad/s");
        }
    }
}
