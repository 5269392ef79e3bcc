//! Made-up meshes: corridors, ramps, stairs, floors, holes, bridges, spirals.

use glam::Vec3;
use throng_level::LevelData;
use throng_level_bake::{LevelSettings, LevelSource, MarkedLink, bake};

/// Adds a plate with its top at some height, between two corners in the plane.
pub struct Mesh(pub Vec<[Vec3; 3]>);

impl Mesh {
    /// A plate whose height goes from `y[0]` at the smallest x to `y[1]` at the largest.
    fn plate(&mut self, x: [f32; 2], z: [f32; 2], y: [f32; 2]) {
        let at = |i: usize, k: usize| Vec3::new(x[i], y[i], z[k]);
        self.quad([at(0, 0), at(0, 1), at(1, 1), at(1, 0)]);
    }

    /// A plate whose height goes from `y[0]` at the smallest z to `y[1]` at the largest.
    fn ramp_z(&mut self, x: [f32; 2], z: [f32; 2], y: [f32; 2]) {
        let at = |i: usize, k: usize| Vec3::new(x[i], y[k], z[k]);
        self.quad([at(0, 0), at(0, 1), at(1, 1), at(1, 0)]);
    }

    fn quad(&mut self, [a, b, c, d]: [Vec3; 4]) {
        self.0.extend([[a, b, c], [a, c, d]]);
    }

    /// A block from the floor up.
    fn block(&mut self, x: [f32; 2], z: [f32; 2], y: [f32; 2]) {
        self.plate(x, z, [y[1]; 2]);
        let at = |i: usize, j: usize, k: usize| Vec3::new(x[i], y[j], z[k]);
        for [[a, b], [c, d]] in [[[0, 0], [0, 1]], [[0, 1], [1, 1]], [[1, 1], [1, 0]], [[1, 0], [0, 0]]] {
            self.quad([at(a, 0, b), at(c, 0, d), at(c, 1, d), at(a, 1, b)]);
        }
    }
}

/// A kind of level.
pub type Shape = fn(&mut Mesh);

/// Ten kinds of levels.
pub const SHAPES: [(&str, Shape); 10] = [
    ("rooms", rooms),
    ("ramp", ramp),
    ("stairs", stairs),
    ("two floors", two_floors),
    ("holes", holes),
    ("bridge", bridge),
    ("L", l_shape),
    ("T", t_shape),
    ("spiral", spiral),
    ("islands", islands),
];

/// The mesh of a shape.
pub fn source(shape: Shape) -> LevelSource {
    let mut mesh = Mesh(Vec::new());
    shape(&mut mesh);
    LevelSource { triangles: mesh.0, ..LevelSource::default() }
}

/// Tables of two floors with a ladder.
pub fn baked() -> LevelData {
    static MADE: std::sync::OnceLock<LevelData> = std::sync::OnceLock::new();
    let make = || {
        let mut source = source(two_floors);
        let ends = [Vec3::new(9.0, 0.0, 1.5), Vec3::new(9.0, 3.5, 2.5)];
        source.links.push(MarkedLink { name: "ladder".into(), kind: "ladder", ends });
        bake(&source, &LevelSettings::default(), &mut Vec::new()).expect("a level")
    };
    MADE.get_or_init(make).clone()
}

fn rooms(m: &mut Mesh) {
    m.plate([0.0, 24.0], [0.0, 18.0], [0.0; 2]);
    for k in 1..3 {
        let x = 8.0 * k as f32;
        m.block([x - 0.1, x + 0.1], [0.0, 2.0 + 5.0 * (k - 1) as f32], [0.0, 2.5]);
        m.block([x - 0.1, x + 0.1], [3.2 + 5.0 * (k - 1) as f32, 18.0], [0.0, 2.5]);
    }
    m.block([0.0, 6.0], [8.9, 9.1], [0.0, 2.5]);
    m.block([9.0, 16.0], [10.9, 11.1], [0.0, 2.5]);
    m.block([18.0, 24.0], [6.9, 7.1], [0.0, 2.5]);
}

/// Flat, then up by a quarter, then flat.
pub fn ramp(m: &mut Mesh) {
    m.plate([-4.0, 2.0], [0.0, 4.0], [0.0; 2]);
    m.plate([2.0, 8.0], [0.0, 4.0], [0.0, 1.5]);
    m.plate([8.0, 14.0], [-3.0, 4.0], [1.5; 2]);
}

/// Twelve steps of 0.17 m.
pub fn stairs(m: &mut Mesh) {
    m.plate([-4.0, 2.0], [0.0, 4.0], [0.0; 2]);
    for k in 0..12 {
        let (x, y) = (2.0 + 0.3 * k as f32, 0.17 * (k + 1) as f32);
        m.block([x, x + 0.3], [0.0, 4.0], [0.0, y]);
    }
    m.plate([5.6, 12.0], [-4.0, 8.0], [2.04; 2]);
}

/// A floor, another one above its right half, and a ramp between them.
pub fn two_floors(m: &mut Mesh) {
    m.plate([0.0, 20.0], [0.0, 12.0], [0.0; 2]);
    m.plate([8.0, 20.0], [2.0, 12.0], [3.5; 2]);
    m.plate([8.0, 20.0], [-2.0, 0.0], [3.5; 2]);
    m.plate([8.0, 20.0], [0.0, 2.0], [3.5; 2]);
    m.plate([1.0, 8.0], [4.0, 6.5], [0.0, 3.5]);
}

fn holes(m: &mut Mesh) {
    for i in 0..5 {
        for k in 0..5 {
            if (i + 2 * k) % 3 != 1 {
                m.plate([3.0 * i as f32, 3.0 * (i + 1) as f32], [3.0 * k as f32, 3.0 * (k + 1) as f32], [0.0; 2]);
            }
        }
    }
    m.plate([0.0, 15.0], [15.0, 17.0], [0.0; 2]);
    m.plate([-2.0, 0.0], [0.0, 17.0], [0.0; 2]);
    m.plate([15.0, 17.0], [0.0, 17.0], [0.0; 2]);
}

/// Two squares and a bridge as wide as two people.
fn bridge(m: &mut Mesh) {
    m.plate([0.0, 8.0], [0.0, 8.0], [0.0; 2]);
    m.plate([8.0, 22.0], [3.4, 4.8], [0.0; 2]);
    m.plate([22.0, 30.0], [-4.0, 8.0], [0.0; 2]);
}

fn l_shape(m: &mut Mesh) {
    m.plate([0.0, 20.0], [0.0, 4.0], [0.0; 2]);
    m.plate([16.0, 20.0], [4.0, 20.0], [0.0; 2]);
}

fn t_shape(m: &mut Mesh) {
    m.plate([0.0, 24.0], [0.0, 3.0], [0.0; 2]);
    m.ramp_z([10.0, 13.0], [3.0, 20.0], [0.0, -2.0]);
}

/// A ramp that turns once and a half round a post, over itself.
fn spiral(m: &mut Mesh) {
    let num = 54;
    let at = |k: usize, r: f32| {
        let angle = k as f32 * std::f32::consts::TAU / 36.0;
        Vec3::new(r * angle.cos(), 0.1 * k as f32, -r * angle.sin())
    };
    for k in 0..num {
        m.quad([at(k, 2.0), at(k, 5.0), at(k + 1, 5.0), at(k + 1, 2.0)]);
    }
    let (low, high) = (at(0, 3.5), at(num, 3.5));
    m.plate([low.x - 1.5, low.x + 1.5], [low.z - 0.05, low.z + 6.0], [low.y; 2]);
    m.plate([high.x - 6.0, high.x + 0.05], [high.z - 1.5, high.z + 1.5], [high.y; 2]);
}

/// Two grounds at different heights, and one that is far away.
pub fn islands(m: &mut Mesh) {
    m.plate([0.0, 10.0], [0.0, 8.0], [0.0; 2]);
    m.plate([0.0, 10.0], [10.0, 18.0], [3.0; 2]);
    m.plate([36.0, 44.0], [0.0, 8.0], [0.0; 2]);
}

/// Three halls in a row, joined by passages of 4 m, each with pillars.
pub fn halls(m: &mut Mesh) {
    for k in 0..3 {
        let x = 44.0 * k as f32;
        m.plate([x, x + 40.0], [0.0, 24.0], [0.0; 2]);
        for pillar in 0..4 {
            let at = x + 6.0 + 9.0 * pillar as f32;
            m.block([at, at + 1.0], [9.0, 10.0], [0.0, 3.0]);
            m.block([at, at + 5.0], [14.5, 14.8], [0.0, 3.0]);
        }
        if k < 2 {
            m.plate([x + 40.0, x + 44.0], [8.0, 12.0], [0.0; 2]);
        }
    }
}
