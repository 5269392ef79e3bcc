//! How long does value iteration take on 10.8 million state-action pairs? `cargo bench --bench value_iteration`.

use throng_precompute::policy::made_up::MadeUp;

fn main() {
    // `cargo test` runs benches too: a small problem is enough there.
    let small = MadeUp { states: 20, actions: 8, ..MadeUp::default() };
    let problem = if std::env::args().any(|a| a == "--bench") { MadeUp::default() } else { small };
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads");
        let runs = (0..3).map(|_| pool.install(|| problem.measure(1e-4)).expect("the problem converges"));
        let best = runs.min_by(|a, b| a.seconds.total_cmp(&b.seconds)).expect("three runs");
        println!("{threads} threads: {best:#?}");
    }
}
