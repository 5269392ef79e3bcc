use super::*;
use std::ops::Range;
use std::path::Path;
use throng_bake::environment::UnitSet;
use throng_core::Skeleton;

fn wall() -> UnitGeometry {
    let text = "[[units]]\nname = \"wall\"\nshapes = [{ box = { at = [0.0, 0.6, 0.0], size = [2.0, 1.2, 0.1] } }]\n";
    UnitGeometry::new(&UnitSet::parse(text, Path::new("u.toml")).unwrap().units[0]).unwrap()
}

const GREEN: Colour = Colour::hex(0x20c020);
const RED: Colour = Colour::hex(0xd02020);

/// Someone at the origin and a wall at `z`, seen along +Z; the middle of the picture is 0.7 m up.
fn seen(z: f32, elevation: f32) -> Picture {
    let geometry = wall();
    let figure = BodyFigure::from_positions(&Skeleton::default().rest_positions());
    let unit = WorldUnit { geometry: &geometry, placement: Placement::new(0.0, 0.0, z, 0.0), colour: GREEN };
    world_sheet(&WorldSheet {
        title: "",
        subtitle: "",
        size: (400, 400),
        figures: &[WorldFigure { figure, colours: BodyColours::plain(RED) }],
        units: &[unit],
        camera: WorldCamera { heading: 0.0, elevation, focus: Some((Vec3::Y, 3.0)) },
        ..WorldSheet::default()
    })
}

fn is_green(c: [u8; 4]) -> bool {
    c[1] > c[0].max(c[2]) + 30
}

#[test]
fn a_wall_hides_the_figure_behind_it_and_not_the_one_in_front() {
    // The hips: 4 cm below the middle of the panel, which begins at (4, 21) and is 392 by 375 pixels large.
    let hips = |z: f32| seen(z, 0.1).pixel(200, 21 + 187 + 6).unwrap();
    assert!(is_green(hips(-1.0)), "{:?}", hips(-1.0));
    assert!(hips(1.0)[0] > hips(1.0)[1] + 30, "{:?}", hips(1.0));
    // The head is above the wall either way.
    let head = seen(-1.0, 0.1).pixel(200, 21 + 187 - 90).unwrap();
    assert!(!is_green(head), "{head:?}");
}

#[test]
fn a_body_throws_a_shadow_on_the_ground_away_from_the_light() {
    let picture = seen(2.0, 0.6);
    assert_eq!(picture, seen(2.0, 0.6), "the same input gives the same picture");
    let foot = 200;
    let is_shadow = |x: u32, y: u32| {
        let [r, g, b, _] = picture.pixel(x, y).unwrap().map(i32::from);
        (r - g).abs() < 16 && (g - b).abs() < 16 && (140..215).contains(&g)
    };
    let count = |columns: Range<u32>| {
        columns.flat_map(|x| (250..380).map(move |y| (x, y))).filter(|p| is_shadow(p.0, p.1)).count()
    };
    let (right, left) = (count(foot + 30..390), count(10..foot - 30));
    assert!(right > 200 && left < right / 4, "{left} {right}: the light comes from the left");
}

#[test]
fn broken_figures_and_empty_worlds_are_drawn_without_a_panic() {
    let figure = BodyFigure::from_positions(&[Vec3::NAN; 22]);
    let view = WorldSheet {
        title: "a",
        subtitle: "b",
        size: (64, 200),
        figures: &[WorldFigure { figure, colours: BodyColours::default() }],
        trails: &[(vec![Vec3::ZERO, Vec3::NAN, Vec3::splat(1e30)], RED)],
        rings: &[(Vec3::INFINITY, 1.0, RED)],
        names: &[(Vec3::ZERO, "n".into(), GREEN)],
        camera: WorldCamera { heading: 0.3, elevation: 9.0, focus: None },
        ..WorldSheet::default()
    };
    assert_eq!(world_sheet(&view).width(), 64);
    let strip = WorldStrip {
        title: "a",
        subtitle: "b",
        moments: &[
            WorldMoment::of_one(0.0, figure),
            WorldMoment::of_one(0.1, BodyFigure::from_positions(&Skeleton::default().rest_positions())),
        ],
        columns: 2,
        width_m: 2.0,
        view_angles: (0.0, 0.1),
        ..WorldStrip::default()
    };
    assert!(world_strip(&strip).height() > 300);
}

/// Somebody who stands at a place (m).
fn standing_at(x: f32, z: f32) -> WorldFigure {
    let joints = Skeleton::default().rest_positions().map(|p| p + Vec3::new(x, 0.0, z));
    WorldFigure { figure: BodyFigure::from_positions(&joints), colours: BodyColours::plain(RED) }
}

#[test]
fn everything_is_inside_the_view_of_everything() {
    let size = Vec2::new(800.0, 500.0);
    let figures = [standing_at(-30.0, 4.0), standing_at(12.0, -9.0), standing_at(3.0, 25.0)];
    let target = Vec3::new(40.0, 0.0, 0.0);
    let camera = world_camera(&OBLIQUE_VIEW, size, &world_pieces(&[], &figures), [target].iter());
    for p in figures.iter().flat_map(|f| f.figure.joints).chain([target]) {
        let s = camera.project(p);
        assert!(s.cmpge(Vec2::ZERO).all() && s.cmple(size).all(), "{p} is seen at {s}");
    }
}

#[test]
fn same_input_same_bytes_at_any_thread_count() {
    let figures: Vec<WorldFigure> = (0..60).map(|i| standing_at((i % 10) as f32, (i / 10) as f32)).collect();
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let sheet = WorldSheet { size: (320, 200), figures: &figures, ..WorldSheet::default() };
        pool.install(|| world_sheet(&sheet).to_png().expect("encodes"))
    };
    assert_eq!(draw(1), draw(4));
}
