//! Work before anything runs: builds, clips, and files for other programs.

use crate::error;
use crate::work::{self, InterruptFlag};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use throng_core::base::error::ensure;
use throng_precompute::config::BuildConfig;
use throng_precompute::error::BuildError;
use throng_precompute::export::{Glb, bvh, take_csv, usda, write_amass, write_each_actor, write_npz};
use throng_precompute::import::{self, ImportConfig, has_extension};
use throng_precompute::perform::{PerformConfig, PerformSource, perform, record_instances};
use throng_precompute::run::motion_name;
use throng_precompute::trial::TrialConfig;
use throng_precompute::wearer::Wearer;
use throng_precompute::{Warnings, files, pipeline};
use throng_runtime::simulation::Scene;
use throng_runtime::{Bundle, Joint};

/// Bakes motion, or the motion of one config, into a bundle; returns the report as JSON.
#[pyfunction]
pub fn build(py: Python<'_>, what: Vec<PathBuf>, out: PathBuf, cache: Option<PathBuf>) -> PyResult<String> {
    let report = work::run_interruptibly(py, |signals| {
        let cache = work::open_cache(cache)?;
        match what.as_slice() {
            [file] if has_extension(file, "toml") => {
                let config = BuildConfig::load(file)?;
                pipeline::build(&config, &out, &cache, signals).map_err(|e| e.in_file(file))
            }
            motion => {
                let config = BuildConfig::of_motion(motion_name(motion), motion.to_vec())?;
                pipeline::build_possible(&config, &out, &cache, signals)
            }
        }
    })?;
    serde_json::to_string(&report).map_err(error::input_error)
}

/// Loads a motion file on the database skeleton, at the database rate.
#[pyfunction]
pub fn load_clip(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let read = py.detach(|| {
        let config = BuildConfig::of_motion("", Vec::new())?;
        let clip = import::read_clip(&path, &config.import)?;
        pipeline::clips_of(&[clip], &config, &mut Warnings::default())
    });
    let set = read.map_err(error::build_error)?;
    let fault = || error::input_error(format!("{}: no frame can be used", path.display()));
    let clip = set.clips.first().ok_or_else(fault)?;
    let (n, joints) = (clip.num_frames(), Joint::ALL.len());
    let array = |numbers: Vec<f32>| PyArray1::from_vec(py, numbers);
    let out = PyDict::new(py);
    out.set_item("name", &clip.name)?;
    out.set_item("rate_hz", clip.rate_hz)?;
    let positions = clip.root_positions.iter().flat_map(|p| p.to_array()).collect();
    out.set_item("root_positions", array(positions).reshape([n, 3])?)?;
    let rotations = clip.rotations.iter().flat_map(|q| q.to_array()).collect();
    out.set_item("rotations", array(rotations).reshape([n, joints, 4])?)?;
    out.set_item("contacts", PyArray1::from_iter(py, clip.contacts.iter().map(|c| c.0)))?;
    let offsets = set.skeleton.offsets.iter().flat_map(|o| o.to_array()).collect();
    out.set_item("offsets", array(offsets).reshape([joints, 3])?)?;
    Ok(out)
}

/// Part to export: characters, first and last time (s), frames a second, true for clips in place of characters, and the
/// file of the character that wears the motion.
type ExportSelection = (Vec<usize>, Option<f64>, Option<f64>, Option<f64>, bool, Option<PathBuf>);

/// Runs a scene, or characters of a bundle, and writes them in a format of other programs; returns the files.
#[pyfunction]
pub fn export(
    py: Python<'_>,
    what: PathBuf,
    out: PathBuf,
    format: &str,
    part: ExportSelection,
    cache: Option<PathBuf>,
) -> PyResult<Vec<PathBuf>> {
    let is_known = ["glb", "usda", "bvh", "npz", "amass", "csv", "instances"].contains(&format);
    let fault = || format!("format is \"{format}\", expected glb, usda, bvh, npz, amass, csv or instances");
    ensure(is_known, || error::input_error(fault()))?;
    let (characters, from_s, to_s, rate_hz, clips, onto) = part;
    let fault = || format!("`onto` is for glb, which Blender and others turn into {format}");
    ensure(onto.is_none() || format == "glb", || error::input_error(fault()))?;
    // Read before long work, as it may not be a character.
    let wearer = onto.map(|file| Wearer::open(&file, &ImportConfig::default())).transpose();
    let wearer = wearer.map_err(error::build_error)?;
    let characters = characters.into_iter().map(|c| c..=c).collect();
    let config = PerformConfig { characters, from_s, to_s, rate_hz };
    let save =
        |show: PerformSource<'_>, signals: &InterruptFlag| save(show, &config, format, wearer.as_ref(), &out, signals);
    if has_extension(&what, "toml") {
        let fault = "instances are of bundles: which of their clips play on characters";
        ensure(format != "instances", || error::input_error(fault))?;
        return work::run_interruptibly(py, |signals| {
            let scene = work::open_scene(&Scene::load(&what)?, cache, signals)?;
            save(PerformSource::Scene(&scene), signals)
        });
    }
    let (bundle, trial) = (Bundle::open(&what).map_err(|e| error::format_error(&what, e))?, TrialConfig::default());
    if format == "instances" {
        return work::run_interruptibly(py, |signals| {
            let played = record_instances(&bundle, &trial, &config, files::folder_of(&out), signals)?;
            files::write_atomically(&out, |w| played.npz(w))?;
            Ok(vec![out.clone()])
        });
    }
    let show = if clips { PerformSource::Clips(&bundle) } else { PerformSource::Trial(&bundle, &trial) };
    work::run_interruptibly(py, |signals| save(show, signals))
}

fn save(
    show: PerformSource<'_>,
    config: &PerformConfig,
    format: &str,
    wearer: Option<&Wearer>,
    out: &Path,
    signals: &InterruptFlag,
) -> Result<Vec<PathBuf>, BuildError> {
    let take = perform(show, config, files::folder_of(out), signals)?;
    match format {
        "bvh" => return write_each_actor(&take, out, |a, w| bvh::write_actor(&take, a, w)),
        "amass" => return write_each_actor(&take, out, |a, w| write_amass(&take, a, w)),
        "glb" => {
            let outfit = wearer.map(|w| w.dress(&take, files::folder_of(out), signals)).transpose()?;
            let glb = outfit.as_ref().map_or_else(|| Glb::new(&take), |o| o.glb(&take))?;
            files::write_atomically(out, |w| glb.write(w))?;
        }
        "usda" => files::write_atomically(out, |w| usda(&take, false, w))?,
        "npz" => files::write_atomically(out, |w| write_npz(&take, w))?,
        _ => files::write_atomically(out, |w| take_csv(&take, w))?,
    }
    Ok(vec![out.to_path_buf()])
}
