//! Activities: frames of clips that begin and end standing, performed by a character that is asked for their tag.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_base::thresholds::WALKING_MPS;
use throng_core::Contacts;
use throng_core::format::ActivityMeta;
use throng_motion::clip::{Clip, ClipSet, FrameRange};
use throng_motion::error::{BuildError, Result};
use throng_motion::import::matches;

/// Hips lower than this share of their height at the beginning show a body that sits or kneels.
const SEATED: f32 = 0.8;

/// Source of the activities of one tag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ActivityConfig {
    /// Clips that show the activity from first to last frame, as patterns with `*`. If empty, the ranges of clips that
    /// carry the tag show it.
    pub clips: Vec<String>,
    /// Tag of the inner range that loops until the activity is to end.
    pub looped: String,
    /// Tags of the ranges in which the left hand and the right hand hold a thing. After a range that lasts to the end,
    /// the thing stays in the hand.
    pub held: [String; 2],
}

impl Default for ActivityConfig {
    fn default() -> Self {
        Self { clips: Vec::new(), looped: "loop".into(), held: ["left_hand".into(), "right_hand".into()] }
    }
}

/// Summary of one activity.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ActivityReport {
    /// Name: the clip's, with frames if the clip gave several.
    pub name: String,
    /// Tag by which the activity is requested.
    pub tag: String,
    /// Duration (s).
    pub duration_s: f64,
    /// Duration of the part that loops until the activity is to end (s).
    pub looped_s: Option<f64>,
    /// Begin and end of the time in which the left and the right hand hold a thing (s).
    pub held_s: [Option<[f64; 2]>; 2],
    /// True if the body sits or kneels in the middle.
    pub is_seated: bool,
}

impl ActivityReport {
    /// Summary of an activity as a bundle stores it.
    pub fn from_meta(activity: &ActivityMeta, rate_hz: f64) -> Self {
        let seconds = |frames: u32| f64::from(frames) / rate_hz;
        Self {
            name: activity.name.clone(),
            tag: activity.tag.clone(),
            duration_s: seconds(activity.num_frames - 1),
            looped_s: activity.looped.map(|[_, count]| seconds(count)),
            held_s: activity
                .object_frames
                .map(|sides| sides.map(|[first, count]| [seconds(first), seconds(first + count)])),
            is_seated: activity.is_seated,
        }
    }
}

/// Finds the activities of every tag of a config; mirrored copies have none.
///
/// - returns them tag by tag, in the order of the clips.
///
/// # Errors
/// [`BuildError::Key`] where nothing shows what a tag asks for, or something that does not begin and end standing.
pub fn find_activities(clips: &ClipSet, config: &BTreeMap<String, ActivityConfig>) -> Result<Vec<ActivityMeta>> {
    let of_tag = |(tag, config): (&String, &ActivityConfig)| {
        find_of_tag(clips, tag, config).map_err(|why| BuildError::key(format!("activities.{tag}"), why))
    };
    let mut found = config.iter().map(of_tag).collect::<Result<Vec<_>, _>>()?.concat();
    // A clip that shows several things.
    let names: Vec<String> = found.iter().map(|a| a.name.clone()).collect();
    for a in found.iter_mut().filter(|a| names.iter().filter(|n| **n == a.name).count() > 1) {
        a.name = format!("{}:{}", a.tag, a.name);
    }
    Ok(found)
}

fn find_of_tag(clips: &ClipSet, tag: &str, config: &ActivityConfig) -> Result<Vec<ActivityMeta>, String> {
    let mut found = Vec::new();
    for (number, clip) in (0u32..).zip(&clips.clips).filter(|(_, c)| !c.mirrored) {
        let ranges = ranges(clip, tag, config);
        for range in &ranges {
            let alone = ranges.len() == 1;
            let name = if alone { clip.name.clone() } else { format!("{}:{}-{}", clip.name, range.start, range.end) };
            let name = if config.clips.is_empty() { name } else { format!("{tag}:{name}") };
            check(clip, range).map_err(|why| format!("`{name}`: {why}"))?;
            found.push(ActivityMeta { clip: number, ..activity(name, tag, clip, range, config) });
        }
    }
    if found.is_empty() {
        return Err(describe_missing(clips, tag, config));
    }
    Ok(found)
}

/// The frames of a clip that show what a tag asks for.
fn ranges(clip: &Clip, tag: &str, config: &ActivityConfig) -> Vec<FrameRange> {
    let whole = config.clips.iter().any(|pattern| matches(pattern, &clip.name)).then_some(0..clip.num_frames());
    let is_of = |name: &str| config.clips.is_empty() && name == tag;
    let tagged = clip.tags.iter().filter(|t| is_of(&t.name)).map(|t| t.range.clone());
    whole.into_iter().chain(tagged).collect()
}

/// Checks that a body stands at both ends of a range, and that all its frames may be used.
fn check(clip: &Clip, range: &FrameRange) -> Result<(), String> {
    const HELP: &str = "Move the ends of the tag to where the person stands, or leave the clip out";
    if range.len() < 4 {
        return Err(format!("expected at least 4 frames, found {}", range.len()));
    }
    if let Some(out) = clip.excluded.iter().find(|e| e.range.start < range.end && range.start < e.range.end) {
        return Err(format!("frames {} to {} are left out ({}). {HELP}", out.range.start, out.range.end, out.reason));
    }
    for (place, frame) in [("beginning", range.start), ("end", range.end - 2)] {
        let step = clip.root_positions[frame + 1] - clip.root_positions[frame];
        let mps = step.length() * clip.rate_hz as f32;
        if mps > WALKING_MPS {
            return Err(format!("expected a person who stands at the {place}, found hips at {mps:.1} m/s. {HELP}"));
        }
        let down = |foot| clip.contacts[frame].any(foot);
        if !down(Contacts::LEFT) && !down(Contacts::RIGHT) {
            return Err(format!("expected a foot on the ground at the {place}, found none. {HELP}"));
        }
    }
    Ok(())
}

/// An activity, but for the number of its clip.
fn activity(name: String, tag: &str, clip: &Clip, range: &FrameRange, config: &ActivityConfig) -> ActivityMeta {
    let is_within = |r: &FrameRange| range.start <= r.start && r.end < range.end && r.len() > 1;
    let looped = clip.tags.iter().find(|t| t.name == config.looped && is_within(&t.range)).map(|t| t.range.clone());
    let object_frames = config.held.each_ref().map(|tag| {
        let parts = clip.tags.iter().filter(|t| t.name == *tag);
        let mut parts = parts.map(|t| t.range.start.max(range.start)..t.range.end.min(range.end));
        parts.find(|part| !part.is_empty()).map(|part| [(part.start - range.start) as u32, part.len() as u32])
    });
    let middle = looped.as_ref().map_or((range.start + range.end) / 2, |l| (l.start + l.end) / 2);
    let height = |frame: usize| clip.root_positions[frame].y;
    ActivityMeta {
        name,
        tag: tag.into(),
        first_frame: range.start as u32,
        num_frames: range.len() as u32,
        looped: looped.map(|l| [(l.start - range.start) as u32, l.len() as u32]),
        object_frames,
        is_seated: height(middle) < SEATED * height(range.start),
        ..ActivityMeta::default()
    }
}

/// Explains why a tag has no activity.
fn describe_missing(clips: &ClipSet, tag: &str, config: &ActivityConfig) -> String {
    if !config.clips.is_empty() {
        return format!("expected clips named {}, found none among {}", config.clips.join(" or "), clips.clips.len());
    }
    let mut tags: Vec<&str> = clips.clips.iter().flat_map(|c| &c.tags).map(|t| &*t.name).collect();
    tags.sort_unstable();
    tags.dedup();
    let known = if tags.is_empty() { "no clip has a tag".into() } else { format!("the tags are {}", tags.join(", ")) };
    format!(
        "expected clips with the tag `{tag}`, found none: {known}. Tag them in a file beside the clip, or name `clips`"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use throng_synth::{SynthConfig, SynthSet, make_set};

    fn people() -> ClipSet {
        make_set(SynthSet::People, &SynthConfig { minutes: 1.2, ..SynthConfig::default() }).unwrap()
    }

    fn asked(tag: &str, config: ActivityConfig) -> BTreeMap<String, ActivityConfig> {
        BTreeMap::from([(tag.to_owned(), config)])
    }

    #[test]
    fn tagged_ranges_become_actions_with_their_looped_part() {
        let (clips, default) = (people(), ActivityConfig::default());
        let config = ["sit", "chat", "greet"].map(|t| (t.to_owned(), default.clone())).into();
        let found = find_activities(&clips, &config).unwrap();
        for activity in &found {
            let clip = &clips.clips[activity.clip as usize];
            let tag = clip.tags.iter().find(|t| t.name == activity.tag).unwrap();
            assert_eq!(
                (activity.first_frame as usize, activity.num_frames as usize),
                (tag.range.start, tag.range.len())
            );
            assert_eq!(activity.is_seated, activity.tag == "sit", "{}", activity.name);
            let looped = clip.tags.iter().find(|t| t.name == "loop").map(|t| t.range.start);
            assert_eq!(activity.looped.map(|l| (l[0] + activity.first_frame) as usize), looped);
        }
        assert!(["chat", "greet", "sit"].iter().all(|t| found.iter().any(|a| a.tag == *t)));
    }

    #[test]
    fn tagged_hands_hold_a_thing_from_the_grasp_on_or_until_it_is_let_go() {
        let all = SynthConfig::for_set(SynthSet::People);
        let (clips, default) = (make_set(SynthSet::People, &all).unwrap(), ActivityConfig::default());
        let config = ["take", "put"].map(|t| (t.to_owned(), default.clone())).into();
        let found = find_activities(&clips, &config).unwrap();
        for (tag, stays) in [("take", true), ("put", false)] {
            let of_tag: Vec<_> = found.iter().filter(|a| a.tag == tag).collect();
            assert!((0..2).all(|side| of_tag.iter().any(|a| a.object_frames[side].is_some())), "{tag}: both hands");
            for a in of_tag {
                let held = a.object_frames.iter().flatten().collect::<Vec<_>>();
                let [first, count] = *held[0];
                assert_eq!((held.len(), first + count == a.num_frames, first == 0), (1, stays, !stays), "{}", a.name);
            }
        }
        let own = ActivityConfig { held: ["none".into(), "other".into()], ..default };
        assert!(find_activities(&clips, &asked("take", own)).unwrap().iter().all(|a| a.object_frames == [None; 2]));
    }

    #[test]
    fn whole_clips_become_actions_by_name() {
        let clips = people();
        let config = ActivityConfig { clips: vec!["people_chat_*".into()], ..ActivityConfig::default() };
        let found = find_activities(&clips, &asked("talk", config)).unwrap();
        assert!(found.iter().all(|a| a.tag == "talk" && a.first_frame == 0 && a.looped.is_some()));
    }

    #[test]
    fn what_is_not_there_or_does_not_stand_is_told() {
        let mut clips = people();
        let error =
            |clips: &ClipSet, tag: &str, config| find_activities(clips, &asked(tag, config)).unwrap_err().to_string();
        let text = error(&clips, "dance", ActivityConfig::default());
        assert!(text.contains("activities.dance") && text.contains("the tags are buy, chat"), "{text}");
        let none = ActivityConfig { clips: vec!["x*".into()], ..ActivityConfig::default() };
        assert!(error(&clips, "dance", none).contains("expected clips named x*"));
        for (i, p) in clips.clips[0].root_positions.iter_mut().enumerate() {
            p.z += 0.05 * i as f32;
        }
        let text = error(&clips, "greet", ActivityConfig::default());
        assert!(text.contains("people_greet_00") && text.contains("stands at the beginning"), "{text}");
    }
}
