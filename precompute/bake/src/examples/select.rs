//! Selection of examples: those named by a config, and those found in clips.

use super::steady::{self, Tolerance};
use super::{AxisKind, BlendConfig, ClipTrack, Cycle, ExampleConfig, FindConfig, WIDEST_SEAM, steps};
use std::collections::BTreeMap;
use throng_core::Contacts;
use throng_motion::import::matches;
use throng_motion::{BuildError, Clip, ClipSet, Exclusion, ExclusionReason, FrameRange, Result, mirror};

/// Least share of frames of a still example in which its feet stand.
const STANDING: f64 = 0.8;

/// A clip, or its mirrored copy, that examples are taken from.
#[derive(Debug)]
pub struct ExampleSource {
    /// Number of the clip as captured.
    pub number: usize,
    /// The motion.
    pub clip: Clip,
}

/// A motion that may become an example.
#[derive(Clone, Debug)]
pub struct ExampleCandidate<'a> {
    /// Name: the clip's, with frames if the clip gave several.
    pub name: String,
    /// Source clip.
    pub source: &'a ExampleSource,
    /// The motion.
    pub cycle: Cycle<'a>,
    /// Place in the parameter space.
    pub parameters: Vec<f64>,
    /// True if the config names it, so that it must not be dropped.
    pub named: bool,
}

/// Criteria for runs of frames.
struct ExampleQuery<'a> {
    /// Entry of the config, such as `examples[2]`.
    entry: String,
    config: &'a BlendConfig,
    style: &'a BTreeMap<String, f64>,
}

/// All clips that a space may take examples from: original clips named by a pattern, each followed by its mirrored
/// copy.
pub fn sources(set: &ClipSet, config: &BlendConfig) -> Vec<ExampleSource> {
    let patterns = || config.examples.iter().map(|e| &e.clip).chain(config.find.iter().flat_map(|f| &f.clips));
    let asked = |c: &Clip| !c.mirrored && !c.is_made() && patterns().any(|p| matches(p, &c.name));
    let both =
        |(number, c): (usize, &Clip)| [c.clone(), mirror::mirror_clip(c)].map(|clip| ExampleSource { number, clip });
    set.clips.iter().enumerate().filter(|(_, c)| asked(c)).flat_map(both).collect()
}

/// Candidates of a space: named ones, then found ones.
///
/// - `without`: collects clips in which nothing was found, search by search.
///
/// # Errors
/// [`BuildError::Key`] naming entry and clip if an example has no value on a style axis, or if a named one does not
/// exist or has wrong or missing keytimes; a found stretch without them is dropped with a warning.
pub fn candidates<'a>(
    config: &BlendConfig,
    sources: &'a [ExampleSource],
    without: &mut Vec<ClipFaults>,
) -> Result<Vec<ExampleCandidate<'a>>> {
    let mut out = Vec::new();
    for (i, example) in config.examples.iter().enumerate() {
        let query = ExampleQuery { entry: format!("examples[{i}]"), config, style: &example.style };
        named_examples(&query, example, sources, &mut out)?;
    }
    let mut found = Vec::new();
    for (i, find) in config.find.iter().enumerate() {
        let query = ExampleQuery { entry: format!("find[{i}]"), config, style: &find.style };
        let mut faults = Vec::new();
        found.extend(search_clips(&query, find, sources, &mut faults)?);
        without.push(faults);
    }
    out.extend(found);
    disambiguate_names(&mut out);
    Ok(out)
}

/// Examples that one entry of the config names.
fn named_examples<'a>(
    query: &ExampleQuery<'_>,
    example: &ExampleConfig,
    sources: &'a [ExampleSource],
    out: &mut Vec<ExampleCandidate<'a>>,
) -> Result<()> {
    let before = out.len();
    let fault = |source: &ExampleSource, what: String| {
        query.entry_error("", &format!("{}: {what}", source.clip.name), KEYTIMES_HELP)
    };
    let clips = || sources.chunks_exact(2).filter(|pair| matches(&example.clip, &pair[0].clip.name));
    for pair in clips().filter(|_| example.symmetric) {
        let found = half_step_cycle(pair, example.tag.as_deref(), example.frames);
        if let Some((source, cycle)) = found.map_err(|what| fault(&pair[0], what))? {
            out.push(query.candidate(source, cycle, true)?);
        }
    }
    let walkers = clips().filter(|_| !example.symmetric).flatten();
    for source in walkers.filter(|s| example.mirror || !s.clip.mirrored) {
        let longest =
            |r: FrameRange| usable_runs(&source.clip, r, example.still).into_iter().max_by_key(ExactSizeIterator::len);
        for range in spans(&source.clip, example.tag.as_deref(), example.frames).into_iter().filter_map(longest) {
            let track = ClipTrack::new(&source.clip);
            let cycle = match example.still {
                true => still_cycle(track, &range),
                false => steady_cycle(track, &range, query.config),
            };
            out.push(query.candidate(source, cycle.map_err(|what| fault(source, what))?, true)?);
        }
    }
    if out.len() > before {
        return Ok(());
    }
    let tag = example.tag.as_ref().map_or(String::new(), |t| format!(" with tag `{t}`"));
    let frames = example.frames.map_or(String::new(), |f| format!(" with frames {f:?}"));
    let what = format!("no clip `{}`{tag}{frames} is there", example.clip);
    let key = match (clips().next(), &example.tag) {
        (None, _) => ".clip",
        (Some(_), Some(_)) => ".tag",
        (Some(_), None) => ".frames",
    };
    Err(query.entry_error(key, &what, "Name a clip as `throng inspect` lists it; `*` stands for any text"))
}

const KEYTIMES_HELP: &str = "Name its steady `frames`, exclude it, or adjust `annotate.contacts` so that each step is one \
                             contact of the foot";

/// Best cycle of the longest steady piece of a range; every step in it must be regular.
fn steady_cycle<'a>(track: ClipTrack<'a>, range: &FrameRange, config: &BlendConfig) -> Result<Cycle<'a>, String> {
    let sequence = steps::sequence(&track, range);
    if let Some(fault) = sequence.faults.first() {
        return Err(fault.what.clone());
    }
    let pieces = steady::steady_runs(&track, &sequence.cycles, tolerance(config));
    match pieces.into_iter().rev().max_by_key(Vec::len) {
        Some(piece) => Ok(Cycle::find_best(track, &piece)),
        None => Err("it holds no cycle".to_owned()),
    }
}

/// The step of a clip that meets its mirrored image best: from the left foot's strike to the right one's, or in the
/// mirrored copy if the clip has only the other. `None` if the clip has no such frames.
fn half_step_cycle<'a>(
    pair: &'a [ExampleSource],
    tag: Option<&str>,
    frames: Option<[usize; 2]>,
) -> Result<Option<(&'a ExampleSource, Cycle<'a>)>, String> {
    let ranges = |source: &ExampleSource| all_runs(&source.clip, tag, frames);
    for source in pair {
        let track = ClipTrack::new(&source.clip);
        let halves: Vec<_> = ranges(source).iter().flat_map(|r| steps::find_half_cycles(&track, r)).collect();
        if !halves.is_empty() {
            return Ok(Some((source, Cycle::from_half_cycle(track, &halves))));
        }
    }
    match ranges(&pair[0]).first() {
        None => Ok(None),
        Some(r) => {
            let (first, last) = (r.start, r.end.saturating_sub(1));
            Err(format!("frames {first} to {last} hold no whole step from one foot's strike to the other's"))
        }
    }
}

fn still_cycle<'a>(track: ClipTrack<'a>, range: &FrameRange) -> Result<Cycle<'a>, String> {
    for (foot, name) in [(Contacts::LEFT, "left"), (Contacts::RIGHT, "right")] {
        let standing: usize = track.stances(range, foot).iter().map(ExactSizeIterator::len).sum();
        if (standing as f64) < STANDING * range.len() as f64 {
            let (first, last) = (range.start, range.end.saturating_sub(1));
            let len = range.len();
            return Err(format!(
                "it is not still: its {name} foot stands for {standing} of {len} frames, {first} to {last}"
            ));
        }
    }
    match range.len() {
        0..3 => Err(format!("it has {} frames, expected at least 3", range.len())),
        _ => Ok(Cycle::from_still(track, range)),
    }
}

fn tolerance(config: &BlendConfig) -> Tolerance {
    Tolerance { speed: config.speed_tolerance, gyration: config.gyration_tolerance }
}

/// Every steady stretch of the clips that one entry of the config names.
///
/// - `without`: collects names of clips in which none was found, with the reason.
fn search_clips<'a>(
    query: &ExampleQuery<'_>,
    find: &FindConfig,
    sources: &'a [ExampleSource],
    without: &mut ClipFaults,
) -> Result<Vec<ExampleCandidate<'a>>> {
    let mut out = Vec::new();
    let wanted = |pair: &&[ExampleSource]| find.clips.iter().any(|p| matches(p, &pair[0].clip.name));
    let clips = || sources.chunks_exact(2).filter(wanted);
    if clips().next().is_none() {
        let what = format!("no clip is there that matches {:?}", find.clips);
        return Err(query.entry_error(
            ".clips",
            &what,
            "Name clips as `throng inspect` lists them; `*` stands for any text",
        ));
    }
    let mut warn = |clip: &Clip, why: &str| without.push((clip.name.clone(), why.to_owned()));
    let most = find.closing_deg.unwrap_or(WIDEST_SEAM.1).to_radians();
    let closes = |cycle: &Cycle<'_>| cycle.closing <= most && cycle.closing_m <= WIDEST_SEAM.0;
    for pair in clips().filter(|_| find.symmetric) {
        match half_step_cycle(pair, find.tag.as_deref(), None) {
            Ok(Some((source, cycle))) if closes(&cycle) => out.push(query.candidate(source, cycle, false)?),
            Ok(Some(_)) => warn(&pair[0].clip, "none of its steps meets its mirrored image"),
            Ok(None) => warn(&pair[0].clip, "it has no such frames"),
            Err(what) => warn(&pair[0].clip, &what),
        }
    }
    let sources = clips().filter(|_| !find.symmetric).flatten();
    for source in sources.filter(|s| find.mirror || !s.clip.mirrored) {
        let (before, mut faults) = (out.len(), Vec::new());
        for range in all_runs(&source.clip, find.tag.as_deref(), None) {
            let track = ClipTrack::new(&source.clip);
            let sequence = steps::sequence(&track, &range);
            faults.extend(sequence.faults);
            for piece in steady::steady_runs(&track, &sequence.cycles, tolerance(query.config)) {
                out.push(query.candidate(source, Cycle::find_best(track.clone(), &piece), false)?);
            }
        }
        out.retain(|c: &ExampleCandidate<'_>| closes(&c.cycle));
        if out.len() == before && !source.clip.mirrored {
            warn(&source.clip, faults.first().map_or("none of its cycles closes", |f| &f.what));
        }
    }
    out.retain(|c| query.is_in_range(&c.parameters));
    out.sort_by(|a, b| a.cycle.closing.total_cmp(&b.cycle.closing));
    if let Some(most) = find.most {
        keep_farthest(&mut out, most);
    }
    Ok(out)
}

/// Names of clips, and reasons why no example was found in them.
pub type ClipFaults = Vec<(String, String)>;

/// Most clips without an example that get a message each; of more, only this many are named.
const NAMED: usize = 4;

/// Messages about clips in which no example was found, with the reason, for each search.
pub fn describe_without(space: &str, searches: &[ClipFaults]) -> Vec<String> {
    let begin = format!("blend.{space}: no example was found in");
    let of_search = |clips: &ClipFaults| {
        if clips.len() <= NAMED {
            return clips.iter().map(|(clip, why)| format!("{begin} clip `{clip}`: {why}.")).collect::<Vec<_>>();
        }
        let some: Vec<String> = clips.iter().take(NAMED).map(|(clip, why)| format!("`{clip}`: {why}")).collect();
        vec![format!("{begin} {} clips: {}; ...", clips.len(), some.join("; "))]
    };
    searches.iter().flat_map(of_search).collect()
}

/// Keeps the `most` that are farthest from one another, beginning with the first.
fn keep_farthest(all: &mut Vec<ExampleCandidate<'_>>, most: usize) {
    let points: Vec<Vec<f64>> = all.iter().map(|c| c.parameters.clone()).collect();
    let scale = axis_scales(&points);
    let mut nearest = vec![f64::INFINITY; points.len()];
    let mut kept = Vec::new();
    while kept.len() < most.min(points.len()) {
        let Some(next) = (0..points.len()).rev().max_by(|&a, &b| nearest[a].total_cmp(&nearest[b])) else { break };
        kept.push(next);
        nearest.iter_mut().enumerate().for_each(|(i, d)| *d = d.min(distance(&points[i], &points[next], &scale)));
    }
    let mut number = 0..;
    all.retain(|_| number.next().is_some_and(|i| kept.contains(&i)));
}

/// Drops found candidates nearer to an earlier one than the config allows, then sorts found ones in the order of the
/// clips.
///
/// - returns the number of dropped ones.
pub fn thin_out(all: &mut Vec<ExampleCandidate<'_>>, min_distance: f64) -> usize {
    let before = all.len();
    let points: Vec<Vec<f64>> = all.iter().map(|c| c.parameters.clone()).collect();
    let scale = axis_scales(&points);
    let mut kept: Vec<Vec<f64>> = Vec::new();
    all.retain(|c| {
        let keep = c.named || kept.iter().all(|k| distance(k, &c.parameters, &scale) >= min_distance);
        if keep {
            kept.push(c.parameters.clone());
        }
        keep
    });
    let found = all.iter().position(|c| !c.named).unwrap_or(all.len());
    all[found..].sort_by(|a, b| a.sort_key().partial_cmp(&b.sort_key()).unwrap_or(std::cmp::Ordering::Equal));
    before - all.len()
}

/// Scale that makes the extent of the points 1 on each axis.
fn axis_scales(points: &[Vec<f64>]) -> Vec<f64> {
    let extent = |k: usize| {
        let values = || points.iter().map(move |p| p[k]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    (0..points.first().map_or(0, Vec::len)).map(|k| 1.0 / extent(k).max(1e-9)).collect()
}

fn distance(a: &[f64], b: &[f64], scale: &[f64]) -> f64 {
    a.iter().zip(b).zip(scale).map(|((a, b), s)| ((a - b) * s).powi(2)).sum::<f64>().sqrt()
}

/// Adds frames to the names of examples of one clip.
fn disambiguate_names(all: &mut [ExampleCandidate<'_>]) {
    let mut uses = BTreeMap::<String, usize>::new();
    all.iter().for_each(|c| *uses.entry(c.name.clone()).or_default() += 1);
    for c in all.iter_mut().filter(|c| uses[&c.name] > 1) {
        let (first, count) = c.cycle.frames();
        c.name = format!("{} [{first}, {})", c.name, first + count);
    }
}

/// Frames of a clip that a config refers to: those within some frames, split into runs that carry a tag.
fn spans(clip: &Clip, tag: Option<&str>, frames: Option<[usize; 2]>) -> Vec<FrameRange> {
    let [first, end] = frames.unwrap_or([0, clip.num_frames()]);
    let within = |r: &FrameRange| r.start.max(first)..r.end.min(end).min(clip.num_frames());
    let mut spans: Vec<FrameRange> = match tag {
        Some(tag) => clip.tags.iter().filter(|t| t.name == tag).map(|t| within(&t.range)).collect(),
        None => vec![within(&(0..clip.num_frames()))],
    };
    spans.retain(|r| r.start < r.end);
    spans
}

/// Usable runs of a span. Still ends of clips are excluded from motion, but not from still examples.
fn usable_runs(clip: &Clip, span: FrameRange, still: bool) -> Vec<FrameRange> {
    let left_out = |e: &Exclusion| !(still && e.reason == ExclusionReason::Still);
    throng_motion::clip::runs_where(span, |f| !clip.excluded.iter().any(|e| e.range.contains(&f) && left_out(e)))
}

/// Usable runs of all spans, for motion.
fn all_runs(clip: &Clip, tag: Option<&str>, frames: Option<[usize; 2]>) -> Vec<FrameRange> {
    spans(clip, tag, frames).into_iter().flat_map(|span| usable_runs(clip, span, false)).collect()
}

impl ExampleCandidate<'_> {
    /// Name of its clip as captured.
    pub fn original(&self) -> &str {
        self.source.clip.name.trim_end_matches(mirror::SUFFIX)
    }

    /// Sort key among the clips: clip, mirrored copy, time.
    fn sort_key(&self) -> (usize, bool, f64) {
        (self.source.number, self.source.clip.mirrored, self.cycle.steps.start)
    }
}

impl ExampleQuery<'_> {
    fn candidate<'a>(&self, source: &'a ExampleSource, cycle: Cycle<'a>, named: bool) -> Result<ExampleCandidate<'a>> {
        let twist = cycle.course.twist;
        let value = |(axis, name): (&super::config::AxisConfig, String)| match axis.kind {
            AxisKind::Speed => Ok(twist.velocity.y),
            AxisKind::Side => Ok(twist.velocity.x),
            AxisKind::Gyration => Ok(twist.gyration),
            AxisKind::Style => {
                let tagged = || style_parameters(&source.clip, &cycle, &axis.tags);
                self.style.get(&name).copied().or_else(tagged).ok_or_else(|| {
                    let what = format!("{}: it has no value on the style axis `{name}`", source.clip.name);
                    self.entry_error(".style", &what, "Give it by `style`, or name its tags in the axis's `tags`")
                })
            }
        };
        let parameters = self.config.axes.iter().zip(self.config.axis_names()).map(value).collect::<Result<_, _>>()?;
        Ok(ExampleCandidate { name: source.clip.name.clone(), source, cycle, parameters, named })
    }

    /// True if a point lies in the ranges of the config.
    fn is_in_range(&self, parameters: &[f64]) -> bool {
        let inside = |(p, a): (&f64, &super::config::AxisConfig)| {
            a.range.is_none_or(|[low, high]| {
                let margin = 0.05 * (high - low);
                (low - margin..=high + margin).contains(p)
            })
        };
        parameters.iter().zip(&self.config.axes).all(inside)
    }

    /// - `key`: of the entry, with its dot; empty for the whole entry.
    fn entry_error(&self, key: &str, what: &str, help: &str) -> BuildError {
        BuildError::key(format!("{}{key}", self.entry), format!("{what}. {help}."))
    }
}

/// Style value of the tags at the middle of a cycle.
fn style_parameters(clip: &Clip, cycle: &Cycle<'_>, values: &BTreeMap<String, f64>) -> Option<f64> {
    let middle = (0.5 * (cycle.steps.start + cycle.steps.end)) as usize;
    let here = clip.tags.iter().filter(|t| t.range.contains(&middle));
    here.filter_map(|t| values.get(&t.name)).copied().next()
}
