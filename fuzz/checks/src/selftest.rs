//! A short self-test on this machine: equal bytes, harmless damage, a short soak, equal hashes.

use crate::damage::{READERS, said};
use crate::soak::{self, SoakConfig};
use serde::Serialize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;
use throng_bake::cache::{Cache, content_hash};
use throng_bake::config::BuildConfig;
use throng_bake::pipeline;
use throng_lab::run::BuildContext;
use throng_motion::error::BuildError;
use throng_motion::progress::Silent;

/// Numbers of threads whose results are compared.
const THREADS: [usize; 3] = [1, 2, 8];

/// Config of a build that takes a second.
const SMALL_CONFIG: &str = "name = \"small\"\nsynth = { set = \"walk\", minutes = 0.5 }\n[resample]\nmirror = true\n[policy]\n\
                     compare_samples = 100\n[[behaviours]]\nname = \"approach\"\ngrid = { rings = 6, angles = 8, \
                     radius = 6.0, inner_spacing = 0.5 }\n";

/// Extent of the self-test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelftestConfig {
    /// Mutants for every reader.
    pub mutants: u64,
    /// Wall time of the soak; every scene runs at least once (s).
    pub soak_s: f64,
    /// Simulated time of each run (s).
    pub run_s: f64,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for SelftestConfig {
    fn default() -> Self {
        Self { mutants: 200, soak_s: 10.0, run_s: 3.0, seed: 1 }
    }
}

/// Results of the self-test.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SelftestReport {
    /// Number of checks.
    pub checked: usize,
    /// Number of failed checks.
    pub failed: usize,
    /// Wall time (s).
    pub seconds: f64,
    /// All checks.
    pub checks: Vec<SelftestCheck>,
}

/// One check.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SelftestCheck {
    /// Description of the check.
    pub name: String,
    /// True if it passed.
    pub ok: bool,
    /// Findings, in words.
    pub found: String,
    /// Wall time (s).
    pub seconds: f64,
}

/// Result of a check: passed or not, and the findings in words.
type CheckResult = Result<(bool, String), BuildError>;

impl SelftestReport {
    fn add(&mut self, name: impl Into<String>, check: impl FnOnce() -> CheckResult) {
        let begin = Instant::now();
        // A panic fails one check; the others go on.
        let found = catch_unwind(AssertUnwindSafe(check)).map_err(|panic| said(&*panic));
        let (ok, found) = match found {
            Ok(Ok(found)) => found,
            Ok(Err(e)) => (false, e.to_string()),
            Err(panic) => (false, panic),
        };
        self.checks.push(SelftestCheck { name: name.into(), ok, found, seconds: begin.elapsed().as_secs_f64() });
        self.checked += 1;
        self.failed += usize::from(!ok);
    }
}

/// Runs all checks.
///
/// - `folder`: folder for small bundles and a world.
pub fn selftest(config: &SelftestConfig, folder: &Path, with: &BuildContext<'_>) -> SelftestReport {
    let begin = Instant::now();
    let mut report = SelftestReport::default();
    report.add("a bundle has the same bytes at 1, 2 and 8 threads", || check_same_bytes(folder));
    for reader in READERS {
        report.add(format!("damaged input: {}", reader.name), || {
            let tried = reader.try_mutants(config.mutants, config.seed);
            let mut found = format!(
                "{} mutants: {} refused, {} accepted and harmless",
                tried.mutants,
                tried.mutants - tried.accepted - tried.faults.len() as u64,
                tried.accepted
            );
            if let Some((number, what)) = tried.faults.first() {
                found += &format!("; {} do harm, first number {number}: {what}", tried.faults.len());
            }
            if tried.bad_seeds > 0 {
                found += &format!("; {} whole files are refused", tried.bad_seeds);
            }
            Ok((tried.faults.is_empty() && tried.bad_seeds == 0, found))
        });
    }
    let mut scenes = Vec::new();
    report.add("scenes of every kind are built and stitched", || {
        scenes = soak::scenes(folder, with)?;
        Ok((!scenes.is_empty(), format!("{} scenes", scenes.len())))
    });
    let soaked = SoakConfig { seconds: config.soak_s, run_s: config.run_s, seed: config.seed, ..SoakConfig::default() };
    report.add("soak", || {
        let r = soak::soak(&scenes, &soaked)?;
        let first = r.faults.first().map_or(String::new(), |f| format!(": {f}"));
        let found = format!(
            "{} runs, {} character steps, {} checks, {} failed{first}",
            r.runs, r.character_steps, r.checks, r.failed
        );
        Ok((r.failed == 0, found))
    });
    for scene in &scenes {
        report.add(format!("equal states at 1, 2 and 8 threads: {}", scene.name), || {
            let hashes = THREADS.map(|n| soak::hash_at_end(scene, &soaked, n));
            let hashes = hashes.into_iter().collect::<Result<Vec<u64>, _>>()?;
            let equal = hashes.iter().all(|h| *h == hashes[0]);
            Ok((equal, hashes.iter().map(|h| format!("{h:016x}")).collect::<Vec<_>>().join(" ")))
        });
    }
    report.seconds = begin.elapsed().as_secs_f64();
    report
}

/// Builds a small bundle on several numbers of threads.
fn check_same_bytes(folder: &Path) -> CheckResult {
    let config = BuildConfig::parse(SMALL_CONFIG, Path::new("small.toml"))?;
    let out = folder.join("small.throng");
    let mut hashes = Vec::new();
    for threads in THREADS {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| BuildError::Config { message: e.to_string() })?;
        pool.install(|| pipeline::build(&config, &out, &Cache::disabled(), &Silent))?;
        let bytes = std::fs::read(&out).map_err(|source| BuildError::Io { path: out.clone(), source })?;
        hashes.push((bytes.len(), content_hash(&bytes)));
    }
    let equal = hashes.iter().all(|h| *h == hashes[0]);
    Ok((equal, hashes.iter().map(|(n, h)| format!("{n} bytes {h:032x}")).collect::<Vec<_>>().join(", ")))
}
