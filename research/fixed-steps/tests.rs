//! Fixed steps by hand. They are compiled as a module of the tests of `throng-crowd`: `cargo test -p throng-crowd --features
//! fixed-steps`, where they are also tried by the tests of all schemes.

use super::*;

/// Builds without fixed steps have no settings of theirs: `scripts/equal-results.sh engines` compares whole
/// states of both builds.
#[test]
fn settings_of_fixed_steps_are_no_part_of_a_state() {
    let kept = |scheme, step_s| {
        let mut setup = meeting::<Vec2>(Scheme::Registration, 3);
        (setup.config.scheme, setup.config.step_s) = (scheme, step_s);
        Engine::new(setup).unwrap().bytes()
    };
    assert!(kept(Scheme::Registration, 0.01) == kept(Scheme::Registration, 0.02));
    assert!(kept(Scheme::Fixed, 0.01) != kept(Scheme::Fixed, 0.02));
}

#[test]
fn steps_that_cannot_be_are_errors() {
    let mut setup = pair(Scheme::Fixed, 1.0, 0.0);
    setup.config.step_s = 0.0;
    assert!(matches!(
        Engine::new(setup).unwrap_err(),
        CrowdError::Other(throng_base::Error::Value { what: "config.step_s", .. })
    ));
    let mut setup = pair(Scheme::Fixed, 1.0, 0.0);
    setup.config.halvings = 40;
    assert!(matches!(
        Engine::new(setup).unwrap_err(),
        CrowdError::Other(throng_base::Error::Value { what: "config.halvings", .. })
    ));
}

#[test]
fn fixed_step_changes_velocity_as_solved_by_hand() {
    let mut setup = pair(Scheme::Fixed, 30.0, 1.3);
    setup.agents.truncate(1);
    setup.agents[0].velocity = Vec2::ZERO;
    setup.fields = vec![driven()];
    let tau = setup.fields[0].relaxation_s;
    let from = setup.agents[0].position;
    let mut crowd = Engine::new(setup).unwrap();
    let id = crowd.ids().next().unwrap();
    let (mut x, mut v) = (0.0f32, 0.0f32);
    for step in 1..=10 {
        // Eq. 14 with eq. 17.
        let a = (1.3 - v) / tau;
        (x, v) = (x + (v + 0.5 * a / 30.0) / 30.0, v + a / 30.0);
        crowd.advance(f64::from(step) / 30.0 - 1e-6, &mut |_| ()).unwrap();
        let got = (crowd.position(id, crowd.now).unwrap() - from, crowd.velocity(id, crowd.now).unwrap());
        assert!((got.0.x - x).abs() < 1e-4 && (got.1.x - v).abs() < 1e-4, "{got:?} for {x} and {v}");
    }
    assert_eq!((crowd.counts.steps, crowd.counts.undone, crowd.counts.decisions), (10, 0, 10));
}

#[test]
fn fixed_steps_stop_agents_where_they_touch() {
    let mut setup = pair(Scheme::Fixed, 1.0, 1.3);
    setup.fields = vec![driven()];
    setup.config.halvings = 3;
    let mut crowd = Engine::new(setup).unwrap();
    for i in 1..300 {
        crowd.advance(f64::from(i) * 0.01, &mut |_| ()).unwrap();
        no_overlap(&crowd, 1.001e-3);
    }
    let ids: Vec<Id> = crowd.ids().collect();
    let apart = (crowd.position(ids[0], 3.0).unwrap() - crowd.position(ids[1], 3.0).unwrap()).length();
    assert!((apart - 0.6).abs() < 5e-3, "they are {apart} m apart");
    let counts = crowd.counts;
    assert!(counts.undone > 3 && counts.overlaps == 0, "{counts:?}");
}
