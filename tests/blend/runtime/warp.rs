//! Generic time only moves forward, and takes the time that the blended rates say.

use super::made_up::{MadeUp, PHASES, cycle_s};
use proptest::prelude::*;
use throng_core::blend::channel;

/// Examples whose rates differ from row to row.
fn uneven() -> MadeUp {
    let mut made_up = MadeUp::new(&[[0.0, 1.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 0.0]], [3, 2, 2]);
    for (i, row) in made_up.channels.iter_mut().enumerate() {
        let (k, e) = (i / 3, i % 3);
        let factor = if k < 11 { [0.5, 1.5, 1.0][e] } else { [1.2, 0.7, 1.0][e] };
        row.values[channel::RATE] *= factor;
    }
    made_up
}

/// Seconds from generic time 0 to each row, and of the whole cycle.
fn times(made_up: &MadeUp, weights: &[f32]) -> Vec<f64> {
    let mut t = vec![0.0];
    for k in 0..PHASES {
        let rates = made_up.channels[k * 3..][..3].iter().map(|c| f64::from(c.values[channel::RATE]));
        let least = rates.clone().fold(f64::INFINITY, f64::min);
        let blended: f64 = rates.zip(weights).map(|(r, &w)| r * f64::from(w)).sum();
        t.push(t[k] + blended.max(least) / PHASES as f64);
    }
    t
}

/// Seconds from generic time 0 to a phase.
fn time_at(t: &[f64], phase: f32) -> f64 {
    let at = f64::from(phase) * PHASES as f64;
    let k = (at as usize).min(PHASES - 1);
    t[k] + (t[k + 1] - t[k]) * (at - k as f64)
}

fn any_weight() -> impl Strategy<Value = f32> {
    prop_oneof![
        6 => -3.0f32..3.0,
        1 => prop::sample::select(vec![0.0, 1.0, -1e6, 1e9, f32::MAX, f32::MIN, f32::NAN, f32::INFINITY]),
    ]
}

fn any_tick() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => 1e-3f32..0.1,
        1 => prop::sample::select(vec![0.0, 1e-9, 1e-5, 1.0, 100.0, 1e20, -1.0, f32::NAN, f32::INFINITY]),
    ]
}

proptest! {
    #[test]
    fn generic_time_never_goes_back(
        ticks in prop::collection::vec((prop::array::uniform3(any_weight()), any_tick()), 1..60), start in 0.0f32..1.0
    ) {
        let made_up = uneven();
        let space = made_up.space();
        let quickest = made_up.channels.iter().map(|c| c.values[channel::RATE]).fold(f32::INFINITY, f32::min);
        let mut phase = [start];
        for (w, dt) in ticks {
            let was = phase[0];
            space.advance(&[w[0], w[1], w[2], 0.0, 0.0, 0.0, 0.0, 0.0], &[dt], &mut phase).expect("a tick");
            prop_assert!((0.0..1.0).contains(&phase[0]), "{}", phase[0]);
            let moved = (phase[0] - was).rem_euclid(1.0);
            if !(dt > 0.0 && dt.is_finite()) {
                prop_assert_eq!(phase[0], was);
            } else if dt < 0.9 * quickest {
                // So little time passes that a whole cycle is out of reach: what is moved, is moved forward.
                prop_assert!(moved <= dt / quickest + 1e-4 || moved > 1.0 - 1e-6, "{was} to {} in {dt}", phase[0]);
            }
        }
    }

    #[test]
    fn the_time_taken_is_that_of_the_blended_rates(
        w in prop::array::uniform3(-0.4f32..1.4), start in 0.0f32..1.0, dt in 0.0f32..20.0
    ) {
        let made_up = uneven();
        let space = made_up.space();
        let mut phase = [start];
        space.advance(&[w[0], w[1], w[2], 0.0, 0.0, 0.0, 0.0, 0.0], &[dt], &mut phase).expect("a tick");
        let t = times(&made_up, &w);
        let cycle = t[PHASES];
        let error = (time_at(&t, phase[0]) - time_at(&t, start) - f64::from(dt)).rem_euclid(cycle);
        prop_assert!(error.min(cycle - error) < 2e-5 * cycle.max(1.0), "off by {error} of {cycle}");
    }

    #[test]
    fn many_small_ticks_come_to_where_a_large_one_does(n in 1usize..200) {
        let made_up = uneven();
        let space = made_up.space();
        let weights = [0.3, 0.9, -0.2, 0.0, 0.0, 0.0, 0.0, 0.0];
        let (mut many, mut one) = ([0.2], [0.2]);
        for _ in 0..n {
            space.advance(&weights, &[0.013], &mut many).expect("a tick");
        }
        space.advance(&weights, &[0.013 * n as f32], &mut one).expect("a tick");
        let apart = (many[0] - one[0]).rem_euclid(1.0);
        prop_assert!(apart.min(1.0 - apart) < 1e-4);
    }
}

#[test]
fn an_example_alone_keeps_its_own_time() {
    let stride = [0.0, 1.0, 0.0];
    let made_up = MadeUp::new(&[stride, [0.0, 3.0, 0.0]], [3, 2, 2]);
    let space = made_up.space();
    let mut phase = [0.25];
    space.advance(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], &[0.5 * cycle_s(&stride)], &mut phase).expect("a tick");
    assert!((phase[0] - 0.75).abs() < 1e-5, "{}", phase[0]);
}

#[test]
fn slices_that_do_not_fit_are_refused() {
    let made_up = uneven();
    let space = made_up.space();
    assert!(space.advance(&[0.0; 8], &[0.1], &mut [0.0; 2]).is_err());
    assert!(space.advance(&[0.0; 16], &[0.1], &mut [0.0; 2]).is_err());
    assert!(space.advance(&[0.0; 16], &[0.1; 2], &mut [0.0; 2]).is_ok());
}
