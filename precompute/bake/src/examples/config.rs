//! Settings of blend spaces.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_core::blend::{MAX_AXES, axis};
use throng_motion::error::{BuildError, Result, check_ranges, ensure};

/// A blend space: example motions in a parameter box, and how they are tabulated (Kim, Kim and Shin 2003a, section 4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BlendConfig {
    /// Makes one space for each of these words, named `NAME-WORD`: `{}` in patterns of clips and tags is the word. If
    /// empty, one space of its own name.
    pub for_each: Vec<String>,
    /// Axes that place examples, in order (1 to 6).
    pub axes: Vec<AxisConfig>,
    /// Named examples; each must exist.
    pub examples: Vec<ExampleConfig>,
    /// Searches for examples: every steady stretch of the clips.
    pub find: Vec<FindConfig>,
    /// Takes only steady gaits ahead that look alike, adds a stand, and never extrapolates: one space of its own name for the
    /// posture and manner of most examples, others named `NAME-MANNER`. One that would be poor is not made.
    pub alike: bool,
    /// Rows of the posture table over one cycle (8 to 1024).
    pub phases: usize,
    /// Largest error of a tabulated weight against the exact one (1e-4 to 0.5).
    pub weight_tolerance: f64,
    /// Most bytes of the weight table (bytes, 1024 to 1e9).
    pub max_weight_bytes: u64,
    /// How far an example's radial basis reaches, in distances to the nearest other example (1 to 10).
    pub kernel_reach: f64,
    /// Treatment of a point outside the box.
    pub extrapolate: Extrapolation,
    /// How much the speed may vary over a steady stretch (m/s, 1e-3 to 100).
    pub speed_tolerance: f64,
    /// How much the turning rate may vary over a steady stretch (rad/s, 1e-3 to 100).
    pub gyration_tolerance: f64,
    /// Examples nearer than this are the same one: an error where both are named, otherwise the better one stays.
    /// Distances count with each axis from 0 to 1 over the examples (>= 1e-6, < 1).
    pub min_distance: f64,
}

impl Default for BlendConfig {
    fn default() -> Self {
        Self {
            for_each: Vec::new(),
            axes: Vec::new(),
            examples: Vec::new(),
            find: Vec::new(),
            alike: false,
            phases: 64,
            weight_tolerance: 0.01,
            max_weight_bytes: 32 << 20,
            kernel_reach: 2.0,
            extrapolate: Extrapolation::default(),
            speed_tolerance: 0.25,
            gyration_tolerance: 0.3,
            min_distance: 0.05,
        }
    }
}

/// An axis of a blend space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisConfig {
    /// Meaning of the axis.
    pub kind: AxisKind,
    /// Its name, unique in the space; that of its kind where empty.
    #[serde(default)]
    pub name: String,
    /// Lowest and highest value of the box; the examples' extent if absent.
    pub range: Option<[f64; 2]>,
    /// Distance between examples that counts as 1; their typical distance if absent (> 0).
    pub spacing: Option<f64>,
    /// A style axis only: the value of an example whose frames carry a tag.
    #[serde(default)]
    pub tags: BTreeMap<String, f64>,
}

/// Meaning of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AxisKind {
    /// A number that is set from outside: a manner, or walk 0, jog 1, run 2.
    Style,
    /// Speed along the direction that the body faces, negative backwards (m/s).
    Speed,
    /// Speed to the body's left (m/s).
    Side,
    /// Turning rate, positive to the left (rad/s).
    Gyration,
}

impl AxisKind {
    /// Code in bundles.
    pub fn code(self) -> u32 {
        [axis::STYLE, axis::SPEED, axis::SIDE, axis::GYRATION][self as usize]
    }

    /// Name in configs.
    pub fn name(self) -> &'static str {
        ["style", "speed", "side", "gyration"][self as usize]
    }
}

/// Treatment of a point outside the parameter box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Extrapolation {
    /// Takes the nearest point of the box.
    #[default]
    Clamp,
    /// Continues the linear part of the weights.
    Linear,
}

/// A named example, or several of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExampleConfig {
    /// Clip by name or pattern, in which `*` stands for any text; every clip that matches gives an example.
    pub clip: String,
    /// Take only frames that carry this tag; each run of them gives an example.
    pub tag: Option<String>,
    /// Take only these frames of the clip, `[first, end)`.
    pub frames: Option<[usize; 2]>,
    /// Values on the style axes, by their names.
    pub style: BTreeMap<String, f64>,
    /// True for a standing character: both feet stay on the ground.
    pub still: bool,
    /// One step and its mirrored image make the cycle: for straight motion that is too short for two steps (neither
    /// with `still` nor with `mirror`).
    pub symmetric: bool,
    /// Adds the mirrored copy.
    pub mirror: bool,
}

/// Search for steady stretches in clips.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FindConfig {
    /// Clips by name or pattern, in which `*` stands for any text.
    pub clips: Vec<String>,
    /// Look only at frames that carry this tag.
    pub tag: Option<String>,
    /// Values on the style axes, by their names.
    pub style: BTreeMap<String, f64>,
    /// One step and its mirrored image make a cycle: for straight motion that is too short for two steps (not with
    /// `mirror`).
    pub symmetric: bool,
    /// Adds mirrored copies.
    pub mirror: bool,
    /// Most examples from these clips, chosen to be farthest from one another (>= 1).
    pub most: Option<usize>,
    /// Largest difference of a cycle's ends, as the mean turn of a joint (deg, > 0, <= 180); 6 if absent. Cycles whose
    /// hips are more than 0.1 m apart are not taken either.
    pub closing_deg: Option<f64>,
}

impl BlendConfig {
    /// The spaces that this table of a config makes, by name.
    pub fn spaces(&self, name: &str) -> Vec<(String, Self)> {
        if self.for_each.is_empty() {
            return vec![(name.to_owned(), self.clone())];
        }
        self.for_each.iter().map(|word| (format!("{name}-{word}"), self.with_word(word))).collect()
    }

    fn with_word(&self, word: &str) -> Self {
        let mut space = Self { for_each: Vec::new(), ..self.clone() };
        let fill = |text: &mut String| *text = text.replace("{}", word);
        for e in &mut space.examples {
            fill(&mut e.clip);
            e.tag.iter_mut().for_each(fill);
        }
        for f in &mut space.find {
            f.clips.iter_mut().for_each(fill);
            f.tag.iter_mut().for_each(fill);
        }
        space
    }

    /// Speed and turning rate, from every steady gait ahead of all clips and their mirrored copies, for each posture and
    /// manner.
    pub fn for_all_clips() -> Self {
        let axis = |kind| AxisConfig { kind, name: String::new(), range: None, spacing: None, tags: BTreeMap::new() };
        Self {
            axes: vec![axis(AxisKind::Speed), axis(AxisKind::Gyration)],
            find: vec![FindConfig { clips: vec!["*".into()], mirror: true, ..FindConfig::default() }],
            alike: true,
            weight_tolerance: 0.05,
            min_distance: 0.12,
            ..Self::default()
        }
    }

    /// Names of the axes; unnamed ones have the names of their kinds.
    pub fn axis_names(&self) -> Vec<String> {
        let name = |a: &AxisConfig| if a.name.is_empty() { a.kind.name().to_owned() } else { a.name.clone() };
        self.axes.iter().map(name).collect()
    }

    /// # Errors
    /// [`BuildError::Key`] naming the first key out of its limits.
    pub(super) fn check(&self) -> Result<()> {
        let limits = [
            ("axes", self.axes.len() as f64, 1.0, MAX_AXES as f64),
            ("phases", self.phases as f64, 8.0, 1024.0),
            ("weight_tolerance", self.weight_tolerance, 1e-4, 0.5),
            ("max_weight_bytes", self.max_weight_bytes as f64, 1024.0, 1e9),
            ("kernel_reach", self.kernel_reach, 1.0, 10.0),
            ("speed_tolerance", self.speed_tolerance, 1e-3, 100.0),
            ("gyration_tolerance", self.gyration_tolerance, 1e-3, 100.0),
            ("min_distance", self.min_distance, 1e-6, 0.999),
        ];
        check_ranges(limits)?;
        let names = self.axis_names();
        for (i, (a, name)) in self.axes.iter().zip(&names).enumerate() {
            if names[..i].contains(name) {
                return Err(config_error(
                    format!("axes[{i}]"),
                    &format!("expected names of their own, found two called `{name}`"),
                ));
            }
            if a.kind != AxisKind::Style && !a.tags.is_empty() {
                let found = format!("expected none on axis `{name}`, whose value is measured, found some");
                return Err(config_error(format!("axes[{i}].tags"), &found));
            }
            if a.range.is_some_and(|[low, high]| !(low + 0.001 <= high && low.abs().max(high.abs()) < 1e4)) {
                let found = format!("expected [low, high] of axis `{name}`, 0.001 apart or more, found {:?}", a.range);
                return Err(config_error(format!("axes[{i}].range"), &found));
            }
            if a.spacing.is_some_and(|s| !(s > 0.0 && s < 1e4)) {
                let found = format!("expected a number above 0 on axis `{name}`, found {:?}", a.spacing);
                return Err(config_error(format!("axes[{i}].spacing"), &found));
            }
        }
        if self.examples.is_empty() && self.find.is_empty() {
            return Err(config_error("examples", "expected `examples` or `find`, found neither"));
        }
        self.check_styles(&names)
    }

    fn check_styles(&self, names: &[String]) -> Result<()> {
        let examples = self.examples.iter().enumerate().map(|(i, e)| (format!("examples[{i}]"), &e.style));
        let found = self.find.iter().enumerate().map(|(i, f)| (format!("find[{i}]"), &f.style));
        for (entry, style) in examples.chain(found) {
            for (name, value) in style {
                let known = names.iter().zip(&self.axes).any(|(n, a)| n == name && a.kind == AxisKind::Style);
                if !known || !(-1e4..=1e4).contains(value) {
                    let found = format!("expected a number on a style axis, found `{name} = {value}`");
                    return Err(config_error(format!("{entry}.style.{name}"), &found));
                }
            }
        }
        let named =
            |(i, e): (usize, &ExampleConfig)| e.check().map_err(|fault| fault.within_key(&format!("examples[{i}]")));
        self.examples.iter().enumerate().try_for_each(named)?;
        let found = |(i, f): (usize, &FindConfig)| f.check().map_err(|fault| fault.within_key(&format!("find[{i}]")));
        self.find.iter().enumerate().try_for_each(found)
    }
}

/// Message about settings that exclude `symmetric`.
const SYMMETRIC: &str = "`symmetric` makes the cycle of one step and its mirrored image, of what moves; expected neither \
                         `mirror` nor `still` with it, found";

impl ExampleConfig {
    fn check(&self) -> Result<()> {
        ensure(!self.clip.is_empty(), || config_error("clip", "expected a clip by name or pattern, found none"))?;
        if let Some([first, end]) = self.frames.filter(|[first, end]| first >= end) {
            return Err(config_error(
                "frames",
                &format!("expected [first, end) of some frames, found [{first}, {end}]"),
            ));
        }
        match [("still", self.still), ("mirror", self.mirror)].into_iter().find(|(_, on)| self.symmetric && *on) {
            Some((key, _)) => Err(config_error(key, &format!("`{}`: {SYMMETRIC} `{key}`", self.clip))),
            None => Ok(()),
        }
    }
}

impl FindConfig {
    fn check(&self) -> Result<()> {
        ensure(!self.clips.is_empty(), || config_error("clips", "expected clips by name or pattern, found none"))?;
        ensure(self.most != Some(0), || config_error("most", "expected 1 or more, found 0"))?;
        if let Some(deg) = self.closing_deg.filter(|d| !(*d > 0.0 && *d <= 180.0)) {
            return Err(config_error("closing_deg", &format!("expected more than 0, 180 at most, found {deg}")));
        }
        match self.symmetric && self.mirror {
            true => Err(config_error("mirror", &format!("{:?}: {SYMMETRIC} `mirror`", self.clips))),
            false => Ok(()),
        }
    }
}

fn config_error(key: impl Into<String>, what: &str) -> BuildError {
    BuildError::key(key, format!("{what}. Correct the config."))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain() -> BlendConfig {
        toml::from_str("axes = [{ kind = 'style', name = 'gait' }, { kind = 'speed' }]\nexamples = [{ clip = 'a_{}' }]")
            .unwrap()
    }

    #[test]
    fn a_template_gives_a_space_for_every_word() {
        let config = BlendConfig { for_each: vec!["sad".into(), "proud".into()], ..plain() };
        let spaces = config.spaces("walk");
        assert_eq!(spaces[1].0, "walk-proud");
        assert_eq!(spaces[1].1.examples[0].clip, "a_proud");
        assert_eq!(plain().spaces("walk"), [("walk".to_owned(), plain())]);
    }

    #[test]
    fn what_is_out_of_its_limits_is_named() {
        assert!(plain().check().is_ok());
        let same_axis = vec![plain().axes[1].clone(), plain().axes[1].clone()];
        let mut unknown = plain();
        unknown.examples[0].style.insert("mood".into(), 1.0);
        let (mut twofold, mut standing) = (plain(), plain());
        (twofold.examples[0].symmetric, twofold.examples[0].mirror) = (true, true);
        (standing.examples[0].symmetric, standing.examples[0].still) = (true, true);
        let mut found = plain();
        found.find = vec![FindConfig { clips: vec!["a".into()], symmetric: true, mirror: true, ..Default::default() }];
        let mut backwards = plain();
        backwards.axes[1].range = Some([1.0, -1.0]);
        for (config, key) in [
            (BlendConfig { phases: 3, ..plain() }, "phases"),
            (BlendConfig { axes: same_axis, ..plain() }, "axes[1]"),
            (BlendConfig { examples: Vec::new(), ..plain() }, "examples"),
            (BlendConfig { weight_tolerance: 0.0, ..plain() }, "weight_tolerance"),
            (unknown, "examples[0].style.mood"),
            (twofold, "examples[0].mirror"),
            (standing, "examples[0].still"),
            (found, "find[0].mirror"),
            (backwards, "axes[1].range"),
        ] {
            let e = config.check().unwrap_err().to_string();
            assert!(e.starts_with(&format!("{key}:")), "{e}");
        }
    }
}
