//! Classes of motion, with the time of each.

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use throng_core::format::{ClassSpan, Gait, MotionClass};

/// Motion of one class. The names of the fields are keys of the JSON report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ClassTime {
    /// `upright`, `crouched`, `seated` or `lying`.
    pub posture: &'static str,
    /// `stand`, `walk`, `run`, `jog`, `sneak`, `strafe`, `backwards` or `other`.
    pub gait: &'static str,
    /// True for standing at ease, without a gesture.
    pub neutral: bool,
    /// True where hands hold a load.
    pub carrying: bool,
    /// Manner; empty where nothing sets it apart.
    pub manner: String,
    /// Its duration (s).
    pub seconds: f64,
}

/// A run of frames of one class.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ClassLine {
    /// Begin (s).
    pub from_s: f64,
    /// End (s).
    pub to_s: f64,
    /// Mean speed over the ground (m/s).
    pub speed_mps: f32,
    /// Direction of travel relative to the front, left positive (degrees).
    pub travel_deg: f32,
    /// Class.
    #[serde(flatten)]
    pub class: ClassTime,
}

impl ClassTime {
    fn new(span: &ClassSpan, rate_hz: f64) -> Self {
        let MotionClass { posture, neutral, carrying, manner, .. } = span.class.clone();
        let seconds = span.frames.len() as f64 / rate_hz;
        Self { posture: posture.name(), gait: span.gait_name(), neutral, carrying, manner, seconds }
    }
}

impl fmt::Display for ClassTime {
    /// Writes the words that set it apart, without its manner.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let posture = if self.posture == "upright" { "" } else { self.posture };
        let is_gesture = self.gait == Gait::Stand.name() && !self.neutral && self.posture == "upright";
        let gait = if is_gesture { "gesture" } else { self.gait };
        let [neutral, load] =
            [(self.neutral, "neutral"), (self.carrying, "with a load")].map(|(is, w)| if is { w } else { "" });
        let words: Vec<&str> = [neutral, posture, gait, load].into_iter().filter(|w| !w.is_empty()).collect();
        f.write_str(&words.join(" "))
    }
}

impl ClassLine {
    /// The spans of a clip, in order.
    pub fn of_spans(spans: &[ClassSpan], rate_hz: f64) -> Vec<Self> {
        let line = |s: &ClassSpan| Self {
            from_s: f64::from(s.frames.start) / rate_hz,
            to_s: f64::from(s.frames.end) / rate_hz,
            speed_mps: s.speed_mps,
            travel_deg: s.travel_deg,
            class: ClassTime::new(s, rate_hz),
        };
        spans.iter().map(line).collect()
    }
}

/// Times of all classes of some spans, the longest first.
pub fn sum_classes<'a>(spans: impl Iterator<Item = &'a ClassLine>) -> Vec<ClassTime> {
    let mut all = BTreeMap::<_, ClassTime>::new();
    for ClassLine { class, .. } in spans {
        let key = (class.posture, class.gait, class.neutral, class.carrying, class.manner.as_str());
        let of = all.entry(key).or_insert_with(|| ClassTime { seconds: 0.0, ..class.clone() });
        of.seconds += class.seconds;
    }
    let mut all: Vec<ClassTime> = all.into_values().collect();
    all.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    all
}

/// Times by some word of a class, in words, the longest first: `walk 3.2 s, neutral stand 1.0 s`.
pub fn describe(classes: &[ClassTime], word: impl Fn(&ClassTime) -> String) -> String {
    let mut by = BTreeMap::<String, f64>::new();
    classes.iter().for_each(|c| *by.entry(word(c)).or_default() += c.seconds);
    let mut by: Vec<(String, f64)> = by.into_iter().filter(|(word, _)| !word.is_empty()).collect();
    by.sort_by(|a, b| b.1.total_cmp(&a.1));
    by.iter().map(|(word, s)| format!("{word} {s:.1} s")).collect::<Vec<_>>().join(", ")
}
