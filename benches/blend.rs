//! What do a row of weights, a posture and a walker cost, beside evaluating weights directly and copying postures?
//! `cargo bench --bench blend`.

#[allow(dead_code, reason = "a part of it is enough here")]
#[path = "../tests/blend/runtime/made_up.rs"]
mod made_up;

use glam::Vec2;
use made_up::MadeUp;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::hint::black_box;
use std::time::Instant;
use throng_runtime::blend::{AxisRecord, BlendSpace, MAX_AXES, Posture, WeightGrid, axis};
use throng_runtime::walkers::{Control, WalkerStart, Walkers, WalkersConfig};
use throng_runtime::{Cast, Id, Inline, Planar};

fn main() {
    // `cargo test` runs benches too: a short look is enough there.
    let whole = std::env::args().any(|a| a == "--bench");
    let bench = if whole { Bench { n: 4096, rounds: 200 } } else { Bench { n: 64, rounds: 1 } };
    for examples in [20, 60] {
        for knots in [[13, 5, 7], [25, 9, 13], [49, 17, 25]] {
            bench.weights(examples, &knots);
        }
    }
    bench.weights(20, &[3, 13, 5, 7]);
    bench.weights(20, &[3, 3, 9, 5, 5]);
    let made_up = MadeUp::locomotion();
    bench.postures(&made_up.space());
    bench.walkers(&made_up.space());
}

struct Bench {
    /// Queries or characters of a batch.
    n: usize,
    rounds: usize,
}

impl Bench {
    /// Median time of one of the batch (ns).
    fn ns(&self, mut round: impl FnMut()) -> f64 {
        round();
        let mut times: Vec<f64> = (0..self.rounds)
            .map(|_| {
                let t = Instant::now();
                round();
                t.elapsed().as_secs_f64() * 1e9 / self.n as f64
            })
            .collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    }

    /// Rows of a table over a grid, in three ways: along simplices, between all corners, and worked out directly.
    fn weights(&self, examples: usize, knots: &[u32]) {
        let mut rng = Pcg64Mcg::seed_from_u64(1);
        let axes: Vec<_> =
            knots.iter().map(|&num_knots| AxisRecord { kind: axis::STYLE, num_knots, low: 0.0, high: 1.0 }).collect();
        let stride = examples.next_multiple_of(8);
        let rows: u32 = knots.iter().product();
        let table: Vec<f32> = (0..rows as usize * stride).map(|_| rng.random_range(-0.2..1.0)).collect();
        let queries: Vec<[f32; MAX_AXES]> =
            (0..self.n).map(|_| std::array::from_fn(|_| rng.random_range(0.0..1.0))).collect();
        let mut out = vec![0.0; stride * self.n];
        let grid = WeightGrid::new(&axes, stride, &table).expect("a grid");
        let simplices = self.ns(|| grid.interpolate_all(&queries, black_box(&mut out)));
        let corners = self.ns(|| {
            throng_runtime::simd::vectorize(|| {
                for (q, out) in queries.iter().zip(out.chunks_exact_mut(stride)) {
                    multilinear(&axes, &table, q, out);
                }
            });
            black_box(&mut out);
        });
        let direct = Direct::new(examples, knots.len(), &mut rng);
        let directly = self.ns(|| {
            throng_runtime::simd::vectorize(|| {
                for (q, out) in queries.iter().zip(out.chunks_exact_mut(stride)) {
                    direct.weights(q, out);
                }
            });
            black_box(&mut out);
        });
        let kib = table.len() * 4 / 1024;
        println!(
            "weights of {examples} examples, {knots:?} knots ({kib} KiB): {simplices:.1} ns a query, \
             {corners:.1} ns between all corners, {directly:.1} ns directly"
        );
    }

    fn postures(&self, space: &BlendSpace) {
        let mut rng = Pcg64Mcg::seed_from_u64(2);
        let parameters: Vec<[f32; MAX_AXES]> = (0..self.n)
            .map(|_| {
                [rng.random_range(-1.0..5.0), rng.random_range(-1.0..1.0), rng.random_range(-1.5..1.5), 0.0, 0.0, 0.0]
            })
            .collect();
        let mut weights = vec![0.0; self.n * space.stride()];
        space.weights(&parameters, &mut weights).expect("weights");
        let mut phases: Vec<f32> = (0..self.n).map(|_| rng.random_range(0.0..1.0)).collect();
        let seconds = vec![1.0 / 60.0; self.n];
        let mut postures = vec![Posture::default(); self.n];
        let pose = self.ns(|| space.pose(&weights, &phases, black_box(&mut postures)).expect("postures"));
        let from = postures.clone();
        let copy = self.ns(|| black_box(&mut postures).copy_from_slice(black_box(&from)));
        let advance = self.ns(|| space.advance(&weights, &seconds, black_box(&mut phases)).expect("a tick"));
        println!(
            "postures of {} examples: {pose:.0} ns, {:.2} million a second, {:.1} times a copy ({copy:.1} ns); \
             generic time: {advance:.1} ns",
            space.examples().len(),
            1e3 / pose,
            pose / copy
        );
    }

    fn walkers(&self, space: &BlendSpace) {
        let starts: Vec<_> = (0..self.n)
            .map(|c| WalkerStart { body: 0, root: Planar::new(c as f32, 0.0, 0.0), phase: 0.61 * c as f32 })
            .collect();
        for (what, retarget) in [("retargeted", true), ("blended only", false)] {
            let config = WalkersConfig { retarget, ..WalkersConfig::default() };
            let mut walkers = Walkers::with_capacity(space.clone(), &[], config, self.n).expect("walkers");
            let ids: Vec<Id> = starts.iter().map(|s| walkers.spawn(*s).expect("a walker")).collect();
            let mut t = 0.0f32;
            let step = self.ns(|| {
                t += 1.0 / 60.0;
                for (c, id) in ids.iter().enumerate() {
                    let speed = 2.5 + 2.5 * (0.7 * t + c as f32).sin();
                    let velocity = speed * Vec2::from_angle((0.3 * t + 0.1 * c as f32).sin());
                    walkers.order(*id, Control::walk(velocity)).expect("an order");
                }
                walkers.step(1.0 / 60.0, &Inline).expect("a step");
            });
            println!("walkers, {what}: {step:.0} ns a step, {:.2} million a second", 1e3 / step);
        }
    }
}

/// Interpolation between all corners of a cell.
#[inline(always)]
fn multilinear(axes: &[AxisRecord], table: &[f32], q: &[f32; MAX_AXES], out: &mut [f32]) {
    let d = axes.len();
    let (mut row, mut steps, mut fractions) = (0, [0; MAX_AXES], [0.0; MAX_AXES]);
    let mut step = 1;
    for a in (0..d).rev() {
        let at = q[a] * (axes[a].num_knots - 1) as f32;
        let whole = (at as u32).min(axes[a].num_knots - 2);
        row += whole as usize * step;
        (steps[a], fractions[a]) = (step, at - whole as f32);
        step *= axes[a].num_knots as usize;
    }
    out.fill(0.0);
    for corner in 0..1usize << d {
        let (mut at, mut share) = (row, 1.0);
        for a in 0..d {
            let up = corner >> a & 1;
            at += up * steps[a];
            share *= if up == 1 { fractions[a] } else { 1.0 - fractions[a] };
        }
        let row = &table[at * out.len()..][..out.len()];
        for (o, w) in out.iter_mut().zip(row) {
            *o += w * share;
        }
    }
}

/// Cardinal weights without a table: a linear part, and cubic B-splines around every example.
struct Direct {
    num_axes: usize,
    places: Vec<[f32; MAX_AXES]>,
    /// One over the support of each example's kernel.
    supports: Vec<f32>,
    /// Of each axis and the constant, then of each example: what it adds to every weight.
    rows: Vec<Vec<f32>>,
}

impl Direct {
    fn new(examples: usize, num_axes: usize, rng: &mut Pcg64Mcg) -> Self {
        let stride = examples.next_multiple_of(8);
        Self {
            num_axes,
            places: (0..examples).map(|_| std::array::from_fn(|_| rng.random_range(0.0..1.0))).collect(),
            supports: (0..examples).map(|_| rng.random_range(0.5..2.0)).collect(),
            rows: (0..examples + MAX_AXES + 1)
                .map(|_| (0..stride).map(|_| rng.random_range(-1.0..1.0)).collect())
                .collect(),
        }
    }

    #[inline(always)]
    fn weights(&self, q: &[f32; MAX_AXES], out: &mut [f32]) {
        out.copy_from_slice(&self.rows[MAX_AXES]);
        let mut add = |row: &[f32], share: f32| out.iter_mut().zip(row).for_each(|(o, r)| *o += r * share);
        for a in 0..self.num_axes {
            add(&self.rows[a], q[a]);
        }
        for (e, place) in self.places.iter().enumerate() {
            let d2: f32 = (0..self.num_axes).map(|a| (q[a] - place[a]).powi(2)).sum();
            let r = 2.0 * d2.sqrt() * self.supports[e];
            let near = if r < 1.0 { 2.0 / 3.0 - r * r + 0.5 * r * r * r } else { (2.0 - r).max(0.0).powi(3) / 6.0 };
            if near > 0.0 {
                add(&self.rows[MAX_AXES + 1 + e], near);
            }
        }
    }
}
