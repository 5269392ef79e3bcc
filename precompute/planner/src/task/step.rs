//! Steps of a task, checked.

use super::entries::{GripEntry, PlaceEntry, SecondEntry, StyleEntry, TaskAction, TaskEntry};
use super::file::{MOST_M, MOST_S, TaskCharacter, TaskThing, is_within_scene, joint_of, not_many, rigid_of_entry};
use crate::limits::{AngleInterval, Style};
use crate::linkage::{Limb, Linkage};
use crate::rotation::Rigid;
use glam::DVec3;
use std::collections::BTreeMap;
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
    pub second: Option<SecondGrip>,
    pub to: Option<TaskPlace>,
    /// Largest tilt of the held object on the way there (rad).
    pub level_rad: Option<f64>,
    pub receiver: Option<Receiver>,
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

/// The other hand, which takes the object, too.
#[derive(Clone, Debug)]
pub(super) struct SecondGrip {
    pub limb: Limb,
    pub grips: Vec<ObjectGrip>,
}

/// Receiver of an object.
#[derive(Clone, Debug)]
pub(super) struct Receiver {
    pub character: usize,
    pub limb: Limb,
    pub grips: Vec<ObjectGrip>,
}

/// Checks all tasks of a file; an error has the index of the task.
pub(super) fn steps(
    tasks: &[TaskEntry],
    characters: &[TaskCharacter],
    things: &[TaskThing],
) -> Result<Vec<TaskStep>, (usize, String)> {
    let scene = NameTable { characters, things };
    tasks.iter().enumerate().map(|(i, t)| scene.step(t).map_err(|why| (i, why))).collect()
}

struct NameTable<'a> {
    characters: &'a [TaskCharacter],
    things: &'a [TaskThing],
}

impl NameTable<'_> {
    fn step(&self, t: &TaskEntry) -> Result<TaskStep, String> {
        let object = t.object.as_ref().map(|name| self.thing(name)).transpose()?;
        let needs_object = t.action != TaskAction::Correct;
        let (is_grab, is_brought) = (t.action == TaskAction::Grab, t.action.needs_held_object());
        let is_object = object.is_some_and(|o| self.things[o].is_object);
        if needs_object != object.is_some() {
            let expected = if needs_object { "expected `object`" } else { "`correct` needs no `object`" };
            return Err(format!("{expected}; `{}` has `limb` and {expected}", t.action.name()));
        }
        if (is_grab || is_brought) && !is_object {
            let name = t.object.as_deref().unwrap_or_default();
            return Err(format!("`{name}` is an obstacle, which stays; list it in `scene.objects`"));
        }
        if (is_grab || is_brought) && !t.limb.is_arm() {
            return Err("feet hold nothing; expected `left_arm` or `right_arm`".into());
        }
        if is_brought != t.to.is_some() {
            let need = if is_brought { "expected `to`, where the object is brought" } else { "needs no `to`" };
            return Err(format!("`{}`: {need}", t.action.name()));
        }
        if (t.action == TaskAction::HandOver) != t.receiver.is_some() {
            return Err("`hand_over`, and nothing else, has a `receiver`".into());
        }
        if is_brought || t.action == TaskAction::Correct {
            if !t.grips.is_empty() {
                return Err(format!("`{}` needs no `grips`: the limb keeps the one it has", t.action.name()));
            }
        } else if t.grips.is_empty() {
            return Err("expected `grips`, where the hand is as seen from the object".into());
        }
        if !(0.0..=MOST_S).contains(&t.hold_s) {
            return Err(format!("hold_s: expected 0 to {MOST_S}, found {}", t.hold_s));
        }
        not_many("contacts", t.contacts.len())?;
        let walks = self.walks_up(t.character.as_deref())?;
        let contacts = t.contacts.iter().map(|c| self.contact(c)).collect::<Result<_, _>>()?;
        let receiver = t.receiver.as_ref().map(|r| {
            let who = r.character.as_deref().or(t.character.as_deref());
            let receiver = Receiver { character: self.character(who)?, limb: r.limb, grips: grips(&r.grips)? };
            if !r.limb.is_arm() || receiver.grips.is_empty() {
                return Err("receiver: expected an arm and `grips`".to_owned());
            }
            Ok(receiver)
        });
        Ok(TaskStep {
            name: t.name.clone().unwrap_or_else(|| name_of(t)),
            character: self.character(t.character.as_deref())?,
            limb: t.limb,
            action: t.action,
            object,
            times_s: times(t, walks)?,
            hold_s: t.hold_s,
            grips: grips(&t.grips)?,
            second: t.second.as_ref().map(|s| second(t, s, walks)).transpose()?,
            to: t.to.as_ref().map(|p| self.place(p)).transpose()?,
            level_rad: level(t)?,
            receiver: receiver.transpose()?,
            contacts,
            priority: t.priority,
            style: style(&t.style, t.limb)?,
        })
    }

    fn thing(&self, name: &str) -> Result<usize, String> {
        self.things.iter().position(|t| t.name == name).ok_or_else(|| {
            let meant = did_you_mean(name, self.things.iter().map(|t| t.name.as_str()));
            format!("there is no object `{name}` in the scene.{meant}")
        })
    }

    fn character(&self, name: Option<&str>) -> Result<usize, String> {
        let Some(name) = name else { return Ok(0) };
        self.characters.iter().position(|c| c.name == name).ok_or_else(|| {
            let meant = did_you_mean(name, self.characters.iter().map(|c| c.name.as_str()));
            format!("there is no character `{name}`.{meant}")
        })
    }

    /// True for a character that walks up to its tasks.
    fn walks_up(&self, name: Option<&str>) -> Result<bool, String> {
        let walk = self.characters[self.character(name)?].clip.walk.as_ref();
        Ok(walk.is_some_and(|w| w.pace.is_empty()))
    }

    fn contact(&self, name: &String) -> Result<String, String> {
        let others = self.characters.iter().map(|c| c.name.as_str());
        let all: Vec<&str> =
            self.things.iter().map(|t| t.name.as_str()).chain(others).chain(Joint::ALL.map(Joint::name)).collect();
        if all.contains(&name.as_str()) {
            return Ok(name.clone());
        }
        Err(format!("contacts: there is no `{name}`.{}", did_you_mean(name, all)))
    }

    fn place(&self, p: &PlaceEntry) -> Result<TaskPlace, String> {
        let offset = rigid_of_entry(p.at, p.turn_deg.unwrap_or_default());
        if !is_within_scene(&offset) {
            return Err(format!("to: expected a finite place within {MOST_M} m"));
        }
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

fn second(t: &TaskEntry, second: &SecondEntry, walks: bool) -> Result<SecondGrip, String> {
    if t.action != TaskAction::Grab {
        return Err(format!(
            "`{}`: expected `second` in `grab` alone: it goes along with what it holds",
            t.action.name()
        ));
    }
    if !second.limb.is_arm() || second.limb == t.limb || second.grips.is_empty() {
        return Err("second: expected the other arm and `grips`".into());
    }
    if walks {
        return Err("second: who walks up to something takes it with one hand; give it a clip".into());
    }
    Ok(SecondGrip { limb: second.limb, grips: grips(&second.grips)? })
}

fn style(entries: &BTreeMap<String, StyleEntry>, limb: Limb) -> Result<Style, String> {
    let (mut out, linkage) = (Style::default(), Linkage::limb(limb));
    for (name, s) in entries {
        let joints = limb.joints().map(Joint::name);
        let i = Joint::from_name(name)
            .and_then(|j| linkage.index_of(j))
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
