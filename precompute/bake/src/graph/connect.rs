//! The stage: event frames, matches, threshold, component, collapse.

use super::bridge::{self, IncomingLinks, KnownLinks};
use super::component::{EventGraph, largest_component};
use super::config::MotionGraphConfig;
use super::events::{self, EventFrame};
use super::manners::{ConnectedEvents, MannersSearch};
use super::matches::{self, LinkFinder, LinkLimits, TransitionLink};
use super::report::{self, GraphReport};
use super::{RawMotionGraph, apart::motion_apart, choose::MotionOutcome, collapse, take::TakenFrames};
use crate::features::{self, Features, FeaturesConfig};
use crate::stages::stage_error;
use std::borrow::Cow;
use throng_base::{Comm, SingleRank};
use throng_motion::error::{BuildError, Result, ensure};
use throng_motion::{clip::ClipSet, progress::Progress};

/// Points compared for each event (see [`LinkLimits`]). Comparing all gives graphs of 5 to 19 minutes whose transitions
/// are nearer by 0.3 % at most; comparing half as many, graphs farther by up to 1.4 %.
const POINTS_PER_EVENT: usize = 512;
/// Points compared for each kind of outcome of each event; see [`POINTS_PER_EVENT`].
const POINTS_PER_KIND: usize = 48;
/// Ratio by which the result may exceed the wanted branching before the search ends.
const ENOUGH: f64 = 1.003;
/// Most steps of the search for the threshold.
const SEARCH_STEPS: usize = 12;
/// Links of a sample over actions of a state: some lead out of the component, or from frames with a single outgoing
/// edge.
const MORE: f64 = 1.5;
/// Share of the largest error at which the search for links begins.
const LEAST_SHARE: f32 = 1.0 / 64.0;
/// Factor by which the search radius for links grows while there are too few.
const GROWTH: f32 = 1.3;

/// Connects similar frames to a graph of states and actions.
///
/// - `clips`: with contacts; all at the same rate.
/// - `features`: distances between frames.
/// - `comm`: processes that search for similar frames together, each for some of them.
///
/// Transitions join event frames of equal kind: a foot about to leave the ground, with the other foot equally
/// planted or not, or standing. Each manner that can be gone and stood in has what it has alone, and then ways to others.
/// The largest strongly connected component of all transitions up to
/// `config.max_error` is kept. Of its transitions as many are actions as give states `config.branching` of them on
/// average: the nearer ones, those of every kind of outcome, and those that keep the component whole. Frames
/// with one way out are collapsed; motion without a choice for longer than `config.max_action_s` is left out.
///
/// # Errors
/// [`BuildError::Config`] for a number out of range; [`BuildError::Stage`] where clips have no contacts or differ in
/// rate, and where the largest component has less than `config.min_component_s` of motion.
///
/// # Source
/// Lee and Lee 2004, sections 3 and 6. Differs: either foot makes an event, not the left one alone; so does
/// standing; the threshold is searched for; of matches with the same outcome only the best is kept; matches
/// beyond the threshold are kept where the component or the variety of outcomes needs them.
pub fn connect(
    clips: &ClipSet,
    features: &FeaturesConfig,
    config: &MotionGraphConfig,
    progress: &dyn Progress,
    comm: &dyn Comm,
) -> Result<(RawMotionGraph, GraphReport)> {
    config.check()?;
    let rate_hz = check_clips(clips)?;
    let taken = TakenFrames::new(clips, &config.take);
    let events = &events::find_events(clips, &taken.runs, config, comm)?;
    let frames: Vec<_> = events.iter().map(|e| e.frame).collect();
    let features = &features::extract_at(clips, &frames, features, comm)?;
    let outcomes = &matches::motion_outcomes(events, clips, config.outcome_horizon_s);
    let given = GraphInputs { clips, config, events, features, outcomes, rate_hz };
    let limits = LinkLimits {
        error: config.max_error.max(config.threshold.unwrap_or(0.0)) as f32,
        min_jump: (config.min_jump_s * rate_hz).round() as u32,
        points_per_kind: POINTS_PER_KIND,
        points_per_event: POINTS_PER_EVENT,
    };
    let ConnectedEvents { graph, alive, threshold, manners } = MannersSearch { given, limits, progress, comm }.run()?;
    let graph = RawMotionGraph { manners, ..collapse::collapse(&graph, &alive, events, clips) };
    let joined = report::joined_manners(&graph, clips, f64::from(limits.error));
    let apart = motion_apart(&given, &taken, &report::played_frames(&graph, clips));
    let report = GraphReport {
        apart,
        joined,
        left_out: taken.left_out,
        scarce_neutral_s: taken.scarce_neutral_s,
        mostly_carrying_s: taken.mostly_carrying_s,
        ..report::report(&graph, clips, events.len(), threshold)
    };
    if (report.frames_kept as f64) < config.min_component_s * rate_hz || graph.states.is_empty() {
        return Err(too_small(&report, config, rate_hz));
    }
    Ok((graph, report))
}

/// An empty graph, for a config that disables it.
///
/// # Errors
/// As [`connect`].
pub fn empty_graph(clips: &ClipSet, config: &MotionGraphConfig) -> Result<(RawMotionGraph, GraphReport)> {
    config.check()?;
    check_clips(clips)?;
    let empty = RawMotionGraph { action_offsets: vec![0], ..RawMotionGraph::default() };
    let report = report::report(&empty, clips, 0, 0.0);
    Ok((empty, GraphReport { unused_clips: Vec::new(), ..report }))
}

/// Links of every event; if ranks share them, only those of this rank's events.
pub(super) type EventLinks = Vec<Vec<TransitionLink>>;

/// Inputs of the search for a graph.
#[derive(Clone, Copy)]
pub(super) struct GraphInputs<'a> {
    pub clips: &'a ClipSet,
    pub config: &'a MotionGraphConfig,
    pub events: &'a [EventFrame],
    /// Features of the events (events.len()).
    pub features: &'a Features,
    /// Outcomes of the motion after each event (events.len()).
    pub outcomes: &'a [MotionOutcome],
    pub rate_hz: f64,
}

impl GraphInputs<'_> {
    /// Longest action (frames).
    pub fn most_frames(&self) -> u32 {
        (self.config.max_action_s * self.rate_hz).round() as u32
    }
}

fn check_clips(clips: &ClipSet) -> Result<f64> {
    let Some(first) = clips.clips.first() else {
        return Err(stage_error("graph", "there are no clips", "Check the paths of the config"));
    };
    for c in &clips.clips {
        let message = || format!("clip {}: expected {} contacts, found {}", c.name, c.num_frames(), c.contacts.len());
        ensure(c.contacts.len() == c.num_frames(), || stage_error("graph", message(), "Annotate the clips first"))?;
        if c.rate_hz != first.rate_hz {
            let (name, rate, wanted) = (&c.name, c.rate_hz, first.rate_hz);
            let message = format!("clip {name}: expected {wanted} Hz as clip {}, found {rate} Hz", first.name);
            return Err(stage_error("graph", message, "Resample the clips to one rate first"));
        }
    }
    Ok(first.rate_hz)
}

fn too_small(report: &GraphReport, config: &MotionGraphConfig, rate_hz: f64) -> BuildError {
    let seconds = |frames: usize| frames as f64 / rate_hz;
    let GraphReport { frames_kept, frames_in, states, event_frames, .. } = report;
    let [kept_s, in_s] = [*frames_kept, *frames_in].map(seconds);
    let message = format!(
        "the largest strongly connected part of the motion has {kept_s:.1} s ({frames_kept} of {frames_in} usable frames, \
         {states} of {event_frames} event frames as states, transitions up to {:.3} rad), less than graph.min_component_s \
         = {} s",
        config.max_error, config.min_component_s
    );
    let help = format!(
        "Add longer clips that return to similar poses ({in_s:.1} s are usable now), check that feet touch the ground \
         (throng inspect CLIP), add mirrored copies, or raise graph.max_error or graph.max_action_s"
    );
    stage_error("graph", message, help)
}

/// Branching measured at a threshold.
#[derive(Clone, Copy, Debug)]
struct BranchingProbe {
    threshold: f32,
    /// Mean number of actions of a state over the wanted number.
    share: f64,
}

impl BranchingProbe {
    /// Threshold at which the wanted branching is expected, by linear interpolation between two probes.
    fn interpolate_threshold(&self, other: &Self) -> f32 {
        let slope = (self.threshold - other.threshold) / (self.share - other.share) as f32;
        self.threshold + (0.5 * (1.0 + ENOUGH) - self.share) as f32 * slope
    }
}

/// The search for a graph of the wanted branching.
pub(super) struct GraphSearch<'a> {
    given: GraphInputs<'a>,
    finder: LinkFinder<'a>,
    comm: &'a dyn Comm,
    /// All event frames, with those links of this rank's events, within the component, that the finder keeps.
    whole: EventGraph,
    /// The largest component of `whole`.
    alive: Vec<bool>,
    /// Links of `whole` by target.
    arrivals: IncomingLinks,
    /// Longest action (frames).
    most_frames: u32,
}

impl<'a> GraphSearch<'a> {
    pub fn new(given: GraphInputs<'a>, finder: LinkFinder<'a>, comm: &'a dyn Comm) -> Result<Self> {
        let (whole, most_frames) = (EventGraph::of_events(&given), given.most_frames());
        let (alive, arrivals) = (Vec::new(), IncomingLinks::new(&[], &SingleRank)?);
        Ok(Self { given, finder, comm, whole, alive, arrivals, most_frames })
    }

    /// Graph at the given threshold, or at the least one that reaches the wanted branching, or at the largest error.
    pub fn run(mut self) -> Result<(EventGraph, Vec<bool>, f32)> {
        let threshold = match self.given.config.threshold {
            Some(threshold) => {
                self.find_links_to(threshold as f32)?;
                threshold as f32
            }
            None => self.find_threshold()?,
        };
        let (graph, alive) = self.event_frames(threshold)?;
        Ok((graph, alive, threshold))
    }

    /// Finds the links for thresholds up to `threshold`, and their largest component.
    fn find_links_to(&mut self, threshold: f32) -> Result<()> {
        self.whole.links = self.finder.links(threshold, self.comm)?;
        self.alive = largest_component(&self.whole, self.most_frames, self.comm)?;
        self.whole.restrict(&self.alive);
        self.arrivals = IncomingLinks::new(&self.whole.links, self.comm)?;
        Ok(())
    }

    /// Mean number of actions of a state at a threshold, over the wanted number.
    fn probe(&self, threshold: f32) -> Result<BranchingProbe> {
        let (graph, alive) = self.event_frames(threshold)?;
        Ok(BranchingProbe { threshold, share: collapse::branching(&graph, &alive) / self.given.config.branching })
    }

    /// Much motion has enough choices among near frames, so the search begins with small radii.
    fn find_threshold(&mut self) -> Result<f32> {
        let most = self.given.config.max_error as f32;
        let first = self.finder.threshold_for(MORE * self.given.config.branching, self.comm)?;
        let (mut low, mut threshold) = (None, first.clamp(LEAST_SHARE * most, most));
        let mut high = loop {
            self.find_links_to(threshold)?;
            let probe = self.probe(threshold)?;
            if probe.share >= 1.0 {
                break probe;
            }
            if threshold >= most {
                return Ok(most);
            }
            (low, threshold) = (Some(probe), (threshold * GROWTH).min(most));
        };
        // Steps since the last probe on the other side of the wanted branching.
        let (mut beyond, mut in_a_row, mut was_low) = (None, 0, false);
        for _ in 0..SEARCH_STEPS {
            if high.share < ENOUGH {
                break;
            }
            let least = low.map_or(0.0, |l: BranchingProbe| l.threshold);
            // Branching is nearly linear in the threshold; if one end stays fixed, bisection helps.
            let other = low.or(beyond).filter(|_| in_a_row < 3);
            let aimed =
                other.map(|other| high.interpolate_threshold(&other)).filter(|&t| t > least && t < high.threshold);
            let probe = self.probe(aimed.unwrap_or(0.5 * (least + high.threshold)))?;
            let is_low = probe.share < 1.0;
            in_a_row = if other.is_some() && is_low == was_low { in_a_row + 1 } else { 1 };
            was_low = is_low;
            if is_low {
                low = Some(probe);
            } else {
                (beyond, high) = (Some(high), probe);
            }
        }
        Ok(high.threshold)
    }

    /// Event graph with the links chosen at a threshold, and its component.
    fn event_frames(&self, threshold: f32) -> Result<(EventGraph, Vec<bool>)> {
        let Self { whole, arrivals, alive, given, .. } = self;
        let most = given.config.max_error.max(given.config.threshold.unwrap_or(0.0)) as f32;
        // Farther links join what would be lost, and are no choices.
        let is_near = |links: &Vec<TransitionLink>| links[..links.partition_point(|l| l.error <= most)].to_vec();
        let near = self.finder.reach() > most;
        let near: Cow<'_, EventLinks> =
            if near { Cow::Owned(whole.links.iter().map(is_near).collect()) } else { Cow::Borrowed(&whole.links) };
        let links = given.choose(&near, threshold, self.comm)?;
        let mut graph = whole.with_links(links);
        let known = KnownLinks { matches: &whole.links, arrivals, alive };
        bridge::bridge(&mut graph, known, given.config.max_actions - 1, self.comm)?;
        // Without room for a bridge because of max_actions, a part may still be lost.
        let alive = largest_component(&graph, self.most_frames, &SingleRank)?;
        Ok((graph, alive))
    }
}
