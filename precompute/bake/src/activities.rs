//! Activities: frames of clips that begin and end standing, performed by a character that is asked for their tag.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use throng_base::{error::ensure, thresholds::WALKING_MPS};
use throng_core::Contacts;
use throng_core::format::{ActivityMeta, Gait, MotionClass, Posture};
use throng_motion::{BuildError, Clip, ClipSet, ExclusionReason, FrameRange, Result, runs_where};
use throng_motion::{annotate::classes::NO_MANNER, import::matches};

/// Hips lower than this share of their height at the beginning show a body that sits or kneels.
const SEATED: f32 = 0.8;

/// Shortest and longest part of an idle pool (s).
const IDLE_S: [f64; 2] = [2.5, 15.0];
/// Shortest and longest gesture (s).
const GESTURE_S: [f64; 2] = [0.4, 12.0];
/// Calm frames between parts of one gesture, at most (s).
const PAUSE_S: f64 = 0.8;
/// Least share of a clip that shows a gesture in which the person stands.
const STANDING_SHARE: f64 = 0.8;
/// Farthest that a gesture leads (m).
const GESTURE_M: f32 = 0.6;

/// Search for activities by the class of motion, for clips without tags.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActivitySearch {
    /// Long neutral stands, under the tag, with the manner behind it: `idle`, `idle-sad`.
    Idles,
    /// Short gestures of a person who stands, each under the words that its clip's name does not share with all others.
    Gestures,
}

/// Source of the activities of one tag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ActivityConfig {
    /// Clips that show the activity from first to last frame, as patterns with `*`. If empty, the ranges of clips that
    /// carry the tag show it.
    pub clips: Vec<String>,
    /// Search in place of tags and `clips`.
    pub find: Option<ActivitySearch>,
    /// Tag of the inner range that loops until the activity is to end.
    pub looped: String,
    /// Tags of the ranges in which the left hand and the right hand hold a thing. After a range that lasts to the end,
    /// the thing stays in the hand.
    pub held: [String; 2],
}

impl Default for ActivityConfig {
    fn default() -> Self {
        Self { clips: Vec::new(), find: None, looped: "loop".into(), held: ["left_hand".into(), "right_hand".into()] }
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
    if let Some(search) = config.find {
        return search.find(clips, tag);
    }
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
    ensure(!found.is_empty(), || describe_missing(clips, tag, config))?;
    Ok(found)
}

impl ActivitySearch {
    /// Activities of all clips.
    fn find(self, clips: &ClipSet, tag: &str) -> Result<Vec<ActivityMeta>, String> {
        let shared = shared_words(clips);
        let mut found = Vec::new();
        for (number, clip) in (0u32..).zip(&clips.clips).filter(|(_, c)| !c.mirrored) {
            let pieces = match self {
                Self::Idles => idles(clip),
                // Nobody asks for a turn or a step that was made.
                Self::Gestures if clip.is_made() => Vec::new(),
                Self::Gestures => gestures(clip),
            };
            let pieces: Vec<FrameRange> = pieces.into_iter().filter(|r| check_ends(clip, r).is_ok()).collect();
            for range in &pieces {
                let alone = pieces.len() == 1;
                let name =
                    if alone { clip.name.clone() } else { format!("{}:{}-{}", clip.name, range.start, range.end) };
                let manner = clip.class_at((range.start + range.end) / 2).map_or("", |c| &c.manner);
                let tag = match self {
                    Self::Idles if manner.is_empty() => tag.to_owned(),
                    Self::Idles => format!("{tag}-{manner}"),
                    Self::Gestures => own_words(&clip.name, manner, &shared),
                };
                // One clip may show several things.
                let name = format!("{tag}:{name}");
                let mut found_here = activity(name, &tag, clip, range, &ActivityConfig::default());
                if self == Self::Idles {
                    // Both ends are for going over from and to other motion.
                    let end = (0.4 * clip.rate_hz) as u32;
                    found_here.looped = Some([end, found_here.num_frames - 2 * end]);
                }
                found.push(ActivityMeta { clip: number, ..found_here });
            }
        }
        found.sort_by(|a: &ActivityMeta, b| (&a.tag, a.clip, a.first_frame).cmp(&(&b.tag, b.clip, b.first_frame)));
        let [least_s, _] = IDLE_S;
        match (found.is_empty(), self) {
            (false, _) => Ok(found),
            (true, Self::Idles) => {
                Err(format!("nobody stands at ease for {least_s} s. Add idles, or tag them and name `activities`"))
            }
            (true, Self::Gestures) => {
                Err("nobody makes a gesture while standing. Add some, such as a bow or a wave".into())
            }
        }
    }
}

/// Runs of at least some seconds in which a person stands, upright and with empty hands; still ends of clips count.
fn find_stands(clip: &Clip, least_s: f64, of_class: impl Fn(&MotionClass) -> bool) -> Vec<FrameRange> {
    let left_out = |f: usize| clip.excluded.iter().any(|e| e.reason != ExclusionReason::Still && e.range.contains(&f));
    let stands = |c: &MotionClass| c.posture == Posture::Upright && c.gait == Gait::Stand && !c.carrying && of_class(c);
    let runs = runs_where(0..clip.num_frames(), |f| clip.class_at(f).is_some_and(stands) && !left_out(f));
    runs.into_iter().filter(|r| r.len() as f64 >= least_s * clip.rate_hz).collect()
}

/// Neutral stands of a clip, in parts of equal length.
fn idles(clip: &Clip) -> Vec<FrameRange> {
    let [least_s, most_s] = IDLE_S;
    let parts = |r: FrameRange| {
        let num = (r.len() as f64 / (most_s * clip.rate_hz)).ceil().max(1.0) as usize;
        (0..num).map(move |k| r.start + r.len() * k / num..r.start + r.len() * (k + 1) / num)
    };
    find_stands(clip, least_s, |c| c.neutral).into_iter().flat_map(parts).collect()
}

/// Gestures of a clip in which a person stands, with a moment of calm at each end where there is one.
fn gestures(clip: &Clip) -> Vec<FrameRange> {
    let standing: usize = find_stands(clip, 0.0, |_| true).iter().map(ExactSizeIterator::len).sum();
    if (standing as f64) < STANDING_SHARE * clip.num_frames() as f64 {
        return Vec::new();
    }
    let frames = |s: f64| (s * clip.rate_hz) as usize;
    let mut all: Vec<FrameRange> = Vec::new();
    for run in find_stands(clip, 0.0, |c| !c.neutral) {
        match all.last_mut() {
            Some(last) if run.start - last.end <= frames(PAUSE_S) => last.end = run.end,
            _ => all.push(run),
        }
    }
    let [least_s, most_s] = GESTURE_S;
    all.retain(|r| (frames(least_s)..=frames(most_s)).contains(&r.len()));
    let calm = |f: usize| clip.class_at(f).is_some_and(|c| c.neutral);
    all.iter_mut().for_each(|r| {
        let (first, last) =
            (r.start.saturating_sub(frames(0.5 * PAUSE_S)), (r.end + frames(0.5 * PAUSE_S)).min(clip.num_frames()));
        r.start = (first..r.start).rev().take_while(|&f| calm(f)).last().unwrap_or(r.start);
        r.end = (r.end..last).take_while(|&f| calm(f)).last().map_or(r.end, |f| f + 1);
    });
    let place = |f: usize| clip.root_positions[f].with_y(0.0);
    all.retain(|r| place(r.start).distance(place(r.end - 1)) < GESTURE_M);
    all
}

/// Words of a clip's name: letters between other signs.
fn words(name: &str) -> impl Iterator<Item = &str> {
    let file = name.rsplit('/').next().unwrap_or(name);
    file.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty() && w.chars().any(char::is_alphabetic))
}

/// Words that the names of all captured clips share; none of a single clip.
fn shared_words(clips: &ClipSet) -> Vec<String> {
    let mut names = clips.clips.iter().filter(|c| !c.mirrored && !c.is_made()).map(|c| &c.name);
    let (Some(first), Some(second)) = (names.next(), names.next()) else { return Vec::new() };
    let rest: Vec<&String> = std::iter::once(second).chain(names).collect();
    words(first).filter(|w| rest.iter().all(|n| words(n).any(|o| o == *w))).map(str::to_owned).collect()
}

/// Words of a clip's name but for shared ones, its manner, and words for none; the name where nothing is left.
fn own_words(name: &str, manner: &str, shared: &[String]) -> String {
    let own = |w: &&str| !shared.iter().any(|s| s == w) && !words(manner).any(|m| m == *w) && !NO_MANNER.contains(w);
    let own: Vec<&str> = words(name).filter(own).collect();
    if own.is_empty() { name.to_owned() } else { own.join("_") }
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
    ensure(range.len() >= 4, || format!("expected at least 4 frames, found {}", range.len()))?;
    if let Some(out) = clip.excluded.iter().find(|e| e.range.start < range.end && range.start < e.range.end) {
        return Err(format!("frames {} to {} are left out ({}). {HELP}", out.range.start, out.range.end, out.reason));
    }
    check_ends(clip, range).map_err(|why| format!("{why}. {HELP}"))
}

/// Checks that a body stands at both ends of a range of at least 2 frames.
fn check_ends(clip: &Clip, range: &FrameRange) -> Result<(), String> {
    for (place, frame) in [("beginning", range.start), ("end", range.end - 2)] {
        let step = clip.root_positions[frame + 1] - clip.root_positions[frame];
        let mps = step.length() * clip.rate_hz as f32;
        if mps > WALKING_MPS {
            return Err(format!("expected a person who stands at the {place}, found hips at {mps:.1} m/s"));
        }
        let down = |foot| clip.contacts[frame].any(foot);
        if !down(Contacts::LEFT) && !down(Contacts::RIGHT) {
            return Err(format!("expected a foot on the ground at the {place}, found none"));
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
    use throng_core::format::{ClassSpan, MADE_TAG};
    use throng_motion::clip::ClipTag;
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

    /// Two gestures of a library, and a turn that a build has made: that is nothing to ask for, and its name says nothing of the
    /// others'.
    #[test]
    fn gestures_are_named_by_what_captured_clips_do_not_share() {
        let mut clips = make_set(SynthSet::Locomotion, &SynthConfig::for_set(SynthSet::Locomotion)).unwrap();
        let idle = clips.clips.iter().find(|c| c.name.starts_with("idle")).expect("an idle").clone();
        let (n, second) = (idle.num_frames() as u32, idle.rate_hz as u32);
        let gesture = |name: &str, manner: &str, tags: Vec<ClipTag>| {
            let class =
                |neutral| MotionClass { gait: Gait::Stand, neutral, manner: manner.into(), ..MotionClass::default() };
            let spans = [(0..second, true), (second..2 * second, false), (2 * second..n, true)];
            let classes =
                spans.map(|(frames, neutral)| ClassSpan { frames, class: class(neutral), ..ClassSpan::default() });
            Clip { name: name.into(), classes: classes.to_vec(), tags, ..idle.clone() }
        };
        let made = ClipTag { name: MADE_TAG.into(), range: 0..n as usize };
        clips.clips = vec![
            gesture("dataset-1_bow_normal_001", "", Vec::new()),
            gesture("dataset-1_wave_sad_001", "sad", Vec::new()),
            gesture("made/turn-45-0", "", vec![made]),
        ];
        let found = find_activities(
            &clips,
            &asked("x", ActivityConfig { find: Some(ActivitySearch::Gestures), ..ActivityConfig::default() }),
        );
        let tags: Vec<String> = found.unwrap().into_iter().map(|a| a.tag).collect();
        assert_eq!(tags, ["bow", "wave"]);
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
