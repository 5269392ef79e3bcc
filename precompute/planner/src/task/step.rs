//! Steps of a task, checked.

use super::entries::{GripEntry, PlaceEntry, SecondEntry, StyleEntry, TaskAction, TaskEntry};
use super::file::{MOST_M, MOST_S, TaskCharacter, TaskThing, is_within_scene, joint_of, not_many, rigid_of_entry};
use crate::limits::{AngleInterval, Style};
use crate::{linkage::Limb, refuse, rotation::Rigid};
use glam::DVec3;
use std::{collections::BTreeMap, fmt::Arguments};
use throng_base::text::did_you_mean;
use throng_core::Joint;

/// A step of a task.
#[derive(Clone, Debug)]
pub(super) struct TaskStep {
    pub name: String,
    pub character: usize,
    pub limb: Limb,
    pub action: TaskAction,
    /// Index of the object.
    pub object: Option<usize>,
    /// Times at which the limb leaves the clip, reaches its target and is back (s); of corrections, the stretch that is
    /// searched.
    pub times_s: [f64; 3],
    pub hold_s: f64,
    pub grips: Vec<ObjectGrip>,
    /// The other hand, which takes the object, too.
    pub second: Option<OtherHand>,
    pub to: Option<TaskPlace>,
    /// Largest tilt of the held object on the way there (rad).
    pub level_rad: Option<f64>,
    pub receiver: Option<OtherHand>,
    pub contacts: Vec<String>,
    pub priority: i32,
    pub style: Style,
}

/// Times of a step before its character has walked there.
const UNTIMED: [f64; 3] = [f64::NAN; 3];

impl TaskStep {
    /// False where the character has to walk there first.
    pub fn is_timed(&self) -> bool {
        !self.times_s[1].is_nan()
    }
}

/// A grip: the place of a hand at an object, relative to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ObjectGrip {
    /// Transform of the wrist.
    Turned(Rigid),
    /// Position of the middle of the hand, with any turn (m).
    Any(DVec3),
}

/// A place relative to something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TaskPlace {
    pub on: Anchor,
    pub offset: Rigid,
    /// True for any turn about the vertical.
    pub any_turn: bool,
}

/// Thing, joint or world from which a place is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    World,
    Thing(usize),
    Joint(usize, Joint),
}

/// Another hand that takes the object: a second one, or that of a receiver.
#[derive(Clone, Debug)]
pub(super) struct OtherHand {
    pub character: usize,
    pub limb: Limb,
    pub grips: Vec<ObjectGrip>,
}

/// Characters and things that tasks name.
pub(super) struct NameTable<'a> {
    pub characters: &'a [TaskCharacter],
    pub things: &'a [TaskThing],
}

impl NameTable<'_> {
    /// Checks all tasks of a file; an error has the index of the task.
    pub fn steps(&self, tasks: &[TaskEntry]) -> Result<Vec<TaskStep>, (usize, String)> {
        tasks.iter().enumerate().map(|(i, t)| self.step(t).map_err(|why| (i, why))).collect()
    }

    fn step(&self, t: &TaskEntry) -> Result<TaskStep, String> {
        let object = t.object.as_ref().map(|name| self.thing(name)).transpose()?;
        let needs_object = t.action != TaskAction::Correct;
        let (is_grab, is_brought) = (t.action == TaskAction::Grab, t.action.needs_held_object());
        let is_object = object.is_some_and(|o| self.things[o].is_object);
        let (action, is_held) = (t.action.name(), is_grab || is_brought);
        let expected = if needs_object { "expected `object`" } else { "`correct` needs no `object`" };
        refuse(needs_object != object.is_some(), format_args!("{expected}; `{action}` has `limb` and {expected}"))?;
        let name = t.object.as_deref().unwrap_or_default();
        let is_fixed = is_held && !is_object;
        refuse(is_fixed, format_args!("`{name}` is an obstacle, which stays; list it in `scene.objects`"))?;
        refuse(is_held && !t.limb.is_arm(), format_args!("feet hold nothing; expected `left_arm` or `right_arm`"))?;
        let need = if is_brought { "expected `to`, where the object is brought" } else { "needs no `to`" };
        refuse(is_brought != t.to.is_some(), format_args!("`{action}`: {need}"))?;
        let is_wrong = (t.action == TaskAction::HandOver) != t.receiver.is_some();
        refuse(is_wrong, format_args!("`hand_over`, and nothing else, has a `receiver`"))?;
        let (has_grips, needs_none) = (!t.grips.is_empty(), is_brought || !needs_object);
        refuse(needs_none && has_grips, format_args!("`{action}` needs no `grips`: the limb keeps the one it has"))?;
        refuse(!needs_none && !has_grips, format_args!("expected `grips`, where the hand is as seen from the object"))?;
        let hold_s = t.hold_s;
        refuse(!(0.0..=MOST_S).contains(&hold_s), format_args!("hold_s: expected 0 to {MOST_S}, found {hold_s}"))?;
        not_many("contacts", t.contacts.len())?;
        let character = self.character(t.character.as_deref())?;
        // A character that walks up to its tasks.
        let walks = self.characters[character].clip.walk.as_ref().is_some_and(|w| w.pace.is_empty());
        let contacts = t.contacts.iter().map(|c| self.contact(c)).collect::<Result<_, _>>()?;
        let receiver = t.receiver.as_ref().map(|r| {
            let who = r.character.as_deref().or(t.character.as_deref());
            let receiver = OtherHand { character: self.character(who)?, limb: r.limb, grips: grips(&r.grips)? };
            let is_wrong = !r.limb.is_arm() || receiver.grips.is_empty();
            refuse(is_wrong, format_args!("receiver: expected an arm and `grips`")).map(|()| receiver)
        });
        Ok(TaskStep {
            name: t.name.clone().unwrap_or_else(|| name_of(t)),
            character,
            limb: t.limb,
            action: t.action,
            object,
            times_s: times(t, walks)?,
            hold_s: t.hold_s,
            grips: grips(&t.grips)?,
            second: t.second.as_ref().map(|s| second(t, s, character, walks)).transpose()?,
            to: t.to.as_ref().map(|p| self.place(p)).transpose()?,
            level_rad: level(t)?,
            receiver: receiver.transpose()?,
            contacts,
            priority: t.priority,
            style: style(&t.style, t.limb)?,
        })
    }

    fn thing(&self, name: &str) -> Result<usize, String> {
        let names = self.things.iter().map(|t| t.name.as_str());
        find_name(name, names, format_args!("there is no object `{name}` in the scene"))
    }

    fn character(&self, name: Option<&str>) -> Result<usize, String> {
        let Some(name) = name else { return Ok(0) };
        let names = self.characters.iter().map(|c| c.name.as_str());
        find_name(name, names, format_args!("there is no character `{name}`"))
    }

    fn contact(&self, name: &String) -> Result<String, String> {
        let others = self.characters.iter().map(|c| c.name.as_str());
        let all = self.things.iter().map(|t| t.name.as_str()).chain(others).chain(Joint::ALL.map(Joint::name));
        find_name(name, all, format_args!("contacts: there is no `{name}`")).map(|_| name.clone())
    }

    fn place(&self, p: &PlaceEntry) -> Result<TaskPlace, String> {
        let offset = rigid_of_entry(p.at, p.turn_deg.unwrap_or_default());
        refuse(!is_within_scene(&offset), format_args!("to: expected a finite place within {MOST_M} m"))?;
        let on = match &p.on {
            None => Anchor::World,
            Some(name) if name.contains('.') => {
                let (character, joint) = joint_of(name, self.characters)?;
                Anchor::Joint(character, joint)
            }
            Some(name) => Anchor::Thing(self.thing(name)?),
        };
        Ok(TaskPlace { on, offset, any_turn: p.turn_deg.is_none() })
    }
}

/// Index of a name among known ones; an error begins with `missing`.
fn find_name<'a>(
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    missing: Arguments<'_>,
) -> Result<usize, String> {
    known.clone().position(|k| k == name).ok_or_else(|| format!("{missing}.{}", did_you_mean(name, known)))
}

fn name_of(t: &TaskEntry) -> String {
    let words = [t.limb.name(), t.action.name(), t.object.as_deref().unwrap_or_default()];
    words.join(" ").trim_end().to_owned()
}

fn times(t: &TaskEntry, walks: bool) -> Result<[f64; 3], String> {
    match (t.action, t.at_s, t.window_s) {
        (TaskAction::Correct, None, None) => Ok([0.0, 0.0, f64::INFINITY]),
        (TaskAction::Correct, None, Some([from, to])) if from < to => Ok([from, from, to]),
        (TaskAction::Correct, ..) => Err("`correct` finds collisions by itself: expected no `at_s`, and an ascending \
                                    `window_s` or none"
            .into()),
        (_, None, None) if walks => Ok(UNTIMED),
        (_, Some(at_s), Some([from, to])) if from < at_s && at_s < to => Ok([from, at_s, to]),
        (_, Some(_), Some(_)) => Err("expected `at_s` within `window_s`".into()),
        _ => Err("expected `at_s` and `window_s`, from when to when the limb leaves the clip".into()),
    }
}

fn level(t: &TaskEntry) -> Result<Option<f64>, String> {
    match t.level_deg {
        Some(_) if !t.action.needs_held_object() => {
            Err(format!("`{}` needs no `level_deg`: it brings nothing", t.action.name()))
        }
        Some(deg) if !(deg > 0.0 && deg < 180.0) => Err(format!("level_deg: expected 0 to 180, found {deg}")),
        deg => Ok(deg.map(f64::to_radians)),
    }
}

fn grips(entries: &[GripEntry]) -> Result<Vec<ObjectGrip>, String> {
    not_many("grips", entries.len())?;
    let one = |g: &GripEntry| match g.turn_deg {
        Some(turn) => ObjectGrip::Turned(rigid_of_entry(g.at, turn)),
        None => ObjectGrip::Any(DVec3::from(g.at)),
    };
    let all: Vec<ObjectGrip> = entries.iter().map(one).collect();
    let is_valid = |g: &ObjectGrip| match g {
        ObjectGrip::Turned(at) => at.is_valid(),
        ObjectGrip::Any(at) => at.is_finite(),
    };
    if all.iter().all(is_valid) { Ok(all) } else { Err("grips: expected finite numbers".into()) }
}

fn second(t: &TaskEntry, second: &SecondEntry, character: usize, walks: bool) -> Result<OtherHand, String> {
    let (action, limb) = (t.action.name(), second.limb);
    let is_other = t.action != TaskAction::Grab;
    refuse(is_other, format_args!("`{action}`: expected `second` in `grab` alone: it goes along with what it holds"))?;
    let is_wrong = !limb.is_arm() || limb == t.limb || second.grips.is_empty();
    refuse(is_wrong, format_args!("second: expected the other arm and `grips`"))?;
    refuse(walks, format_args!("second: who walks up to something takes it with one hand; give it a clip"))?;
    Ok(OtherHand { character, limb, grips: grips(&second.grips)? })
}

fn style(entries: &BTreeMap<String, StyleEntry>, limb: Limb) -> Result<Style, String> {
    let mut out = Style::default();
    for (name, s) in entries {
        let joints = limb.joints().map(Joint::name);
        let i = Joint::from_name(name)
            .and_then(|j| limb.index_of(j))
            .ok_or_else(|| format!("style: `{}` has no joint `{name}`; it has {}", limb.name(), joints.join(", ")))?;
        let radians = |[from, to]: [f64; 2]| {
            let is_range = from.is_finite() && to.is_finite() && from <= to;
            let wrong = || format!("style: {name}: expected two ascending angles (degrees), found {from} and {to}");
            is_range.then(|| AngleInterval::new(from.to_radians(), to.to_radians())).ok_or_else(wrong)
        };
        if let Some([first, second]) = s.swing_deg {
            out.swing[i] = [Some(radians(first)?), Some(radians(second)?)];
        }
        if let Some(flexion) = s.flexion_deg {
            out.swing[i][0] = Some(radians(flexion)?);
        }
        out.twist[i] = s.twist_deg.map(radians).transpose()?;
    }
    Ok(out)
}
