//! Weight tables: interpolation against brute force, and what lies outside the box.

use super::made_up::MadeUp;
use proptest::prelude::*;
use throng_core::blend::{AxisRecord, BlendSpace, MAX_AXES, MAX_KNOTS, WeightGrid};

/// Axes of 2, 3, 4, ... knots.
fn axes(num_axes: usize) -> Vec<AxisRecord> {
    let axis = |a: usize| AxisRecord { kind: 0, num_knots: 2 + a as u32 % 3, low: -1.0 - a as f32, high: 0.5 };
    (0..num_axes).map(axis).collect()
}

/// Parameters of every knot, in the order of rows.
fn knots(axes: &[AxisRecord]) -> Vec<[f32; MAX_AXES]> {
    let mut all = vec![[0.0; MAX_AXES]];
    for (a, axis) in axes.iter().enumerate() {
        let value = |i: u32| axis.low + (axis.high - axis.low) * i as f32 / (axis.num_knots - 1) as f32;
        all = all
            .iter()
            .flat_map(|p| {
                (0..axis.num_knots).map(move |i| {
                    let mut p = *p;
                    p[a] = value(i);
                    p
                })
            })
            .collect();
    }
    all
}

/// The path through a cell, written down as the definition says.
fn by_definition(axes: &[AxisRecord], table: &[f32], stride: usize, p: &[f32; MAX_AXES]) -> Vec<f64> {
    let d = axes.len();
    let mut cell = vec![0usize; d];
    let mut fraction = vec![0.0f64; d];
    for (a, axis) in axes.iter().enumerate() {
        let v = f64::from(p[a].clamp(axis.low, axis.high));
        let at = (v - f64::from(axis.low)) / f64::from(axis.high - axis.low) * f64::from(axis.num_knots - 1);
        cell[a] = (at as usize).min(axis.num_knots as usize - 2);
        fraction[a] = at - cell[a] as f64;
    }
    let mut order: Vec<usize> = (0..d).collect();
    order.sort_by(|&a, &b| fraction[b].total_cmp(&fraction[a]));
    let row = |cell: &[usize]| cell.iter().zip(axes).fold(0, |r, (&c, a)| r * a.num_knots as usize + c);
    let mut sum = vec![0.0; stride];
    let mut add = |cell: &[usize], share: f64| {
        let row = &table[row(cell) * stride..][..stride];
        sum.iter_mut().zip(row).for_each(|(s, &w)| *s += f64::from(w) * share);
    };
    add(&cell, 1.0 - fraction[order[0]]);
    for (i, &a) in order.iter().enumerate() {
        cell[a] += 1;
        add(&cell, fraction[a] - order.get(i + 1).map_or(0.0, |&b| fraction[b]));
    }
    sum
}

proptest! {
    #[test]
    fn rows_between_knots_follow_the_definition(
        d in 1usize..=MAX_AXES, p in prop::array::uniform6(-8.0f32..2.0), seed in 0u32..1000
    ) {
        let axes = axes(d);
        let rows = knots(&axes).len();
        let table: Vec<f32> = (0..rows * 16).map(|i| ((i as u32 * 7919 + seed) % 101) as f32 * 0.02 - 1.0).collect();
        let grid = WeightGrid::new(&axes, 16, &table).expect("a grid");
        let mut got = [0.0; 16];
        grid.interpolate(&p, &mut got);
        for (got, want) in got.iter().zip(by_definition(&axes, &table, 16, &p)) {
            prop_assert!((f64::from(*got) - want).abs() < 1e-5, "{got} {want}");
        }
    }

    #[test]
    fn points_of_a_batch_are_read_as_if_alone(
        d in 1usize..=MAX_AXES, points in prop::collection::vec(prop::array::uniform6(-8.0f32..2.0), 0..20), more in 0usize..10
    ) {
        let axes = axes(d);
        let table: Vec<f32> = (0..knots(&axes).len() * 8).map(|i| (i as f32 * 0.7).sin()).collect();
        let grid = WeightGrid::new(&axes, 8, &table).expect("a grid");
        let mut all = vec![7.0; 8 * (points.len() + more)];
        grid.interpolate_all(&points, &mut all);
        let (rows, rest) = all.split_at(8 * points.len());
        for (p, row) in points.iter().zip(rows.chunks(8)) {
            let mut alone = [0.0; 8];
            grid.interpolate(p, &mut alone);
            prop_assert_eq!(&alone[..], row);
        }
        prop_assert!(rest.iter().all(|v| *v == 7.0), "rows that are over are left");
    }

    #[test]
    fn a_linear_function_is_kept(p in prop::array::uniform6(-3.0f32..0.5)) {
        let axes = axes(4);
        let value = |p: &[f32; MAX_AXES]| 0.3 * p[0] - 0.7 * p[1] + 0.2 * p[2] + 1.1 * p[3] + 0.5;
        let table: Vec<f32> = knots(&axes).iter().flat_map(|p| [value(p), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).collect();
        let grid = WeightGrid::new(&axes, 8, &table).expect("a grid");
        let mut got = [0.0; 8];
        grid.interpolate(&p, &mut got);
        prop_assert!((got[0] - value(&grid.clamp(&p))).abs() < 1e-5 && (got[1] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn neighbouring_points_have_neighbouring_weights(
        p in prop::array::uniform3(-1.5f32..5.5), step in prop::array::uniform3(-1e-3f32..1e-3)
    ) {
        let made_up = MadeUp::locomotion();
        let space = made_up.space();
        let query = |p: [f32; 3]| [p[0], p[1], p[2], 0.0, 0.0, 0.0];
        let next = [p[0] + step[0], p[1] + step[1], p[2] + step[2]];
        let mut rows = vec![0.0; 2 * space.stride()];
        space.weights(&[query(p), query(next)], &mut rows).expect("weights");
        let (a, b) = rows.split_at(space.stride());
        prop_assert!((a.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        prop_assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02));
    }
}

#[test]
fn rows_at_knots_are_those_of_the_table() {
    for d in 1..=MAX_AXES {
        let axes = axes(d);
        let knots = knots(&axes);
        let table: Vec<f32> = (0..knots.len() * 8).map(|i| (i as f32 * 0.7).sin()).collect();
        let grid = WeightGrid::new(&axes, 8, &table).expect("a grid");
        for (i, p) in knots.iter().enumerate() {
            let mut got = [0.0; 8];
            grid.interpolate(p, &mut got);
            let want = &table[8 * i..][..8];
            assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-5), "{d} axes, knot {i}");
        }
    }
}

#[test]
fn what_is_outside_the_box_is_clamped_and_what_is_no_number_is_low() {
    let axes = axes(2);
    let table: Vec<f32> = (0..6 * 8).map(|i| i as f32).collect();
    let grid = WeightGrid::new(&axes, 8, &table).expect("a grid");
    let at = |x: f32, y: f32| {
        let mut row = [0.0; 8];
        grid.interpolate(&[x, y, 0.0, 0.0, 0.0, 0.0], &mut row);
        row[0]
    };
    assert_eq!(at(-50.0, -50.0), 0.0);
    assert_eq!(at(9.0, f32::INFINITY), 40.0);
    assert_eq!(at(f32::NAN, f32::NEG_INFINITY), 0.0);
    let mut short = [7.0; 7];
    grid.interpolate(&[0.0; MAX_AXES], &mut short);
    assert_eq!(short, [7.0; 7], "a row that is too short is left alone");
}

#[test]
fn extrapolation_continues_the_linear_part() {
    let mut made_up = MadeUp::locomotion();
    made_up.spaces[0].extrapolate = 1;
    let space = made_up.space();
    let mut rows = vec![0.0; 3 * space.stride()];
    let at = |speed: f32| [speed, 0.0, 0.0, 0.0, 0.0, 0.0];
    space.weights(&[at(5.0), at(6.0), at(8.0)], &mut rows).expect("weights");
    let row = |i: usize| &rows[i * space.stride()..][..space.stride()];
    for e in 0..space.stride() {
        let (one, three) = (row(1)[e] - row(0)[e], row(2)[e] - row(0)[e]);
        assert!((three - 3.0 * one).abs() < 1e-5, "example {e}");
    }
    let speed = |i: usize| row(i).iter().zip(space.examples()).map(|(w, e)| w * e.parameters[0]).sum::<f32>();
    assert!((speed(2) - speed(0) - 3.0).abs() < 1e-4, "{}", speed(2) - speed(0));
    assert!((row(2).iter().sum::<f32>() - 1.0).abs() < 1e-4);
}

#[test]
fn what_does_not_fit_is_refused() {
    let axes = axes(2);
    assert!(WeightGrid::new(&axes, 8, &[0.0; 48]).is_some());
    assert!(WeightGrid::new(&axes, 8, &[0.0; 47]).is_none());
    assert!(WeightGrid::new(&axes, 7, &[0.0; 42]).is_none());
    assert!(WeightGrid::new(&[], 8, &[0.0; 8]).is_none());
    let wide = AxisRecord { num_knots: MAX_KNOTS + 1, ..axes[0] };
    assert!(WeightGrid::new(&[wide], 8, &vec![0.0; 8 * (MAX_KNOTS as usize + 1)][..]).is_none());
    let made_up = MadeUp::locomotion();
    let space = made_up.space();
    let e = space.weights(&[[0.0; MAX_AXES]; 2], &mut [0.0; 24]).expect_err("one row for two queries");
    assert_eq!(e.to_string(), "`weights` has 24 elements, expected 48");
}

#[test]
fn broken_tables_are_refused_and_named() {
    let refuse = |change: fn(&mut MadeUp), what: &str| {
        let mut made_up = MadeUp::locomotion();
        change(&mut made_up);
        let e = BlendSpace::new(&made_up.view(), 0).expect_err(what);
        assert!(e.to_string().contains(what), "{e}");
    };
    refuse(|m| m.spaces.clear(), "blend space 0 does not exist");
    refuse(|m| m.spaces[0].first_example = u32::MAX, "examples");
    refuse(|m| m.spaces[0].num_examples = 0, "examples");
    refuse(|m| m.examples[3].duration_s = 0.0, "examples");
    refuse(|m| m.spaces[0].num_axes = 7, "weight rows");
    refuse(|m| m.spaces[0].axes[1].num_knots = u32::MAX, "weight rows");
    refuse(|m| m.spaces[0].weight_stride = 16, "weight rows");
    refuse(|m| m.spaces[0].axes[0].high = -2.0, "weight rows");
    refuse(|m| m.spaces[0].num_phases = 1, "reference rows");
    refuse(|m| m.spaces[0].first_row = 1, "reference rows");
    refuse(|m| m.spaces[0].first_channel_row = 1, "channel rows");
    refuse(|m| m.channels[7].values[throng_core::blend::channel::RATE] = 0.0, "rates");
}
