//! Cardinal weights and their table.

use proptest::prelude::*;
use throng_precompute::examples::cardinal::{CardinalBasis, CardinalFault};
use throng_precompute::examples::grid::{self, Grid, ParameterBounds};

const REACH: f64 = 2.0;
const MIN_DISTANCE: f64 = 0.05;

/// Scattered examples on one to three axes of different extent.
fn scattered() -> impl Strategy<Value = Vec<Vec<f64>>> {
    (1usize..=3, 5usize..=12)
        .prop_flat_map(|(d, n)| prop::collection::vec(prop::collection::vec(-1.0f64..1.0, d), n))
        .prop_map(|points| {
            points.into_iter().map(|p| p.iter().zip([1.0, 40.0, 0.1]).map(|(v, s)| v * s).collect()).collect()
        })
}

fn basis(points: &[Vec<f64>]) -> Option<CardinalBasis> {
    CardinalBasis::new(points, &[], REACH, MIN_DISTANCE).ok()
}

fn weights(basis: &CardinalBasis, at: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; basis.num_examples()];
    basis.weights(at, &mut out);
    out
}

/// Lowest and highest value on each axis.
fn extent(points: &[Vec<f64>]) -> ParameterBounds {
    let by =
        |f: fn(f64, f64) -> f64| (0..points[0].len()).map(|k| points.iter().map(|p| p[k]).reduce(f).unwrap()).collect();
    ParameterBounds { low: by(f64::min), high: by(f64::max) }
}

proptest! {
    #[test]
    fn each_weight_is_one_at_its_example_and_zero_at_the_others(points in scattered()) {
        let Some(basis) = basis(&points) else { return Ok(()) };
        for (i, p) in points.iter().enumerate() {
            for (j, w) in weights(&basis, p).iter().enumerate() {
                prop_assert!((w - f64::from(u8::from(i == j))).abs() < 1e-9, "weight {j} at example {i} is {w}");
            }
        }
    }

    #[test]
    fn weights_sum_to_one_everywhere(points in scattered(), at in prop::collection::vec(-3.0f64..3.0, 3)) {
        let Some(basis) = basis(&points) else { return Ok(()) };
        let at: Vec<f64> = at.iter().zip([1.0, 40.0, 0.1]).map(|(v, s)| v * s).take(points[0].len()).collect();
        prop_assert!((weights(&basis, &at).iter().sum::<f64>() - 1.0).abs() < 1e-9);
    }

    /// What depends linearly on the parameters is blended exactly: its hyperplane has no residual.
    #[test]
    fn linear_quantities_are_blended_exactly(points in scattered(), slope in -2.0f64..2.0, at in prop::collection::vec(-1.0f64..1.0, 3)) {
        let Some(basis) = basis(&points) else { return Ok(()) };
        let value = |p: &[f64]| 0.5 + slope * p.iter().zip([1.0, 0.025, 10.0]).map(|(v, s)| v * s).sum::<f64>();
        let at: Vec<f64> = at.iter().zip([1.0, 40.0, 0.1]).map(|(v, s)| v * s).take(points[0].len()).collect();
        let blended: f64 = weights(&basis, &at).iter().zip(&points).map(|(w, p)| w * value(p)).sum();
        prop_assert!((blended - value(&at)).abs() < 1e-8, "{blended}, {}", value(&at));
    }

    /// Scaling an axis changes nothing: distances count in spacings.
    #[test]
    fn units_do_not_matter(points in scattered(), at in prop::collection::vec(-1.0f64..1.0, 3)) {
        let Some(basis) = basis(&points) else { return Ok(()) };
        let larger: Vec<Vec<f64>> = points.iter().map(|p| p.iter().map(|v| v * 57.3 - 4.0).collect()).collect();
        let other = CardinalBasis::new(&larger, &[], REACH, MIN_DISTANCE).expect("the same basis");
        let at: Vec<f64> = at.iter().zip([1.0, 40.0, 0.1]).map(|(v, s)| v * s).take(points[0].len()).collect();
        let there: Vec<f64> = at.iter().map(|v| v * 57.3 - 4.0).collect();
        for (a, b) in weights(&basis, &at).iter().zip(weights(&other, &there)) {
            prop_assert!((a - b).abs() < 1e-7);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]
    #[test]
    fn the_table_is_within_its_tolerance(points in scattered(), samples in prop::collection::vec(prop::array::uniform3(0.0f64..1.0), 400)) {
        prop_assume!(points[0].len() < 3);
        let Some(basis) = CardinalBasis::new(&points, &[], REACH, 0.15).ok() else { return Ok(()) };
        let ParameterBounds { low, high } = extent(&points);
        let tolerance = 0.02;
        let table = grid::tabulate(&basis, ParameterBounds { low: low.clone(), high: high.clone() }, tolerance, 1 << 26).expect("a table");
        prop_assert!(table.max_error <= tolerance);
        let mut stored = vec![0.0; points.len()];
        for s in samples {
            let at: Vec<f64> = (0..low.len()).map(|k| low[k] + s[k] * (high[k] - low[k])).collect();
            table.weights(&at, &mut stored);
            let error = weights(&basis, &at).iter().zip(&stored).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Errors are measured where they are largest in each cell, or nearly so.
            prop_assert!(error <= 1.1 * tolerance, "{error}");
            prop_assert!((stored.iter().sum::<f64>() - 1.0).abs() < 1e-5);
        }
        for row in table.weights.chunks(table.stride) {
            prop_assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5 && row[points.len()..].iter().all(|w| *w == 0.0));
        }
    }
}

#[test]
fn a_finer_tolerance_takes_more_knots_and_coarse_ones_are_few() {
    let points: Vec<Vec<f64>> =
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.4, 0.6]].map(|p| p.to_vec()).to_vec();
    let basis = basis(&points).expect("a basis");
    let knots = |tolerance| {
        let table = grid::tabulate(&basis, extent(&points), tolerance, 1 << 26).expect("a table");
        table.grid.num_knots()
    };
    let (fine, coarse) = (knots(0.003), knots(0.1));
    assert!(coarse < 200 && fine > 2 * coarse, "{coarse}, {fine}");
}

/// Along an axis on which the weights are linear, two knots are exact.
#[test]
fn an_axis_without_bends_keeps_two_knots() {
    let basis = CardinalBasis::new(&[vec![0.0], vec![3.0]], &[], REACH, MIN_DISTANCE).expect("a basis");
    let table =
        grid::tabulate(&basis, ParameterBounds { low: vec![0.0], high: vec![3.0] }, 0.01, 1 << 20).expect("a table");
    assert_eq!(table.grid, Grid { low: vec![0.0], high: vec![3.0], knots: vec![2] });
    let mut w = [0.0; 2];
    table.weights(&[0.75], &mut w);
    assert!((w[0] - 0.75).abs() < 1e-6 && (w[1] - 0.25).abs() < 1e-6, "{w:?}");
    table.weights(&[-9.0], &mut w);
    assert_eq!(w, [1.0, 0.0], "outside the box: its nearest point");
}

#[test]
fn a_table_that_would_be_too_large_says_what_it_needs() {
    let points: Vec<Vec<f64>> = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.06, 0.5]].map(|p| p.to_vec()).to_vec();
    let basis = basis(&points).expect("a basis");
    let e = grid::tabulate(&basis, extent(&points), 1e-3, 4096).expect_err("too large");
    assert!(e.bytes > 4096 && e.knots.iter().product::<usize>() * 32 == e.bytes as usize, "{e:?}");
}

#[test]
fn examples_that_have_no_basis_are_told_apart() {
    let fault = |points: &[&[f64]]| {
        let points: Vec<Vec<f64>> = points.iter().map(|p| p.to_vec()).collect();
        CardinalBasis::new(&points, &[], REACH, MIN_DISTANCE).expect_err("no basis")
    };
    assert_eq!(fault(&[&[0.0, 1.0], &[1.0, 0.0]]), CardinalFault::TooFew);
    assert_eq!(fault(&[&[0.0, 1.0], &[1.0, 1.0], &[2.0, 1.0]]), CardinalFault::NoExtent(1));
    assert_eq!(fault(&[&[0.0, 1.0], &[1.0, 2.0], &[2.0, 3.0], &[5.0, 6.0]]), CardinalFault::NoSpread(1));
    match fault(&[&[0.0, 0.0], &[1.0, 2.0], &[2.0, 0.0], &[1.001, 2.0]]) {
        CardinalFault::Coincident(1, 3, d) => assert!((d - 0.0005).abs() < 1e-9, "{d}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_box_far_wider_than_its_examples_is_refused() {
    let points: Vec<Vec<f64>> = (0..4).map(|k| vec![0.5 + 0.4 * f64::from(k)]).collect();
    let basis = basis(&points).expect("a basis");
    let large = grid::tabulate(&basis, ParameterBounds { low: vec![0.0], high: vec![5000.0] }, 0.01, 32 << 20)
        .expect_err("no grid is fine enough");
    assert!(large.errors[0] > 0.0 && large.knots[0] > 1000, "{large:?}");
}
