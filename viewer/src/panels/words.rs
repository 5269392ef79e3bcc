//! Places, directions and numbers in plain words.

use crate::stage::world::kind_of;
use glam::{Vec2, Vec3};
use throng_core::Planar;
use throng_simulation::{AnyCharacterGroup, Simulation};
use throng_world::inhabitants::{InhabitantActivity, InhabitantGoal, InhabitantState};

/// Turns smaller than this are not worth a word (degrees).
const STRAIGHT_DEG: f32 = 3.0;
/// Displacements shorter than this count as none (m).
const STAYS_M: f32 = 0.05;

/// A direction from straight ahead, positive to the left (rad).
pub fn direction(angle: f32) -> String {
    let degrees = angle.to_degrees().round();
    match degrees.abs() {
        d if d < STRAIGHT_DEG => "straight ahead".into(),
        d if d > 180.0 - STRAIGHT_DEG => "straight behind".into(),
        d => format!("{d:.0}° to the {}", side(degrees)),
    }
}

/// Distance and direction of a place in a character's frame (x to the left, z ahead) (m).
pub fn place(p: Vec2) -> String {
    if p.length() < STAYS_M {
        return "where it stood".into();
    }
    format!("{:.1} m away, {}", p.length(), direction(p.x.atan2(p.y)))
}

/// Displacement of an action as a short text: distance, direction, turn.
pub fn displacement(d: Planar) -> String {
    let p = Vec2::new(d.x, d.z);
    let turn = d.heading.to_degrees();
    let turns = match turn {
        t if t.abs() < STRAIGHT_DEG => String::new(),
        t => format!(", turns {:.0}° {}", t.abs(), side(t)),
    };
    if p.length() < STAYS_M {
        return if turns.is_empty() { "stays".into() } else { format!("stays{turns}") };
    }
    let angle = p.x.atan2(p.y).to_degrees().round();
    let towards = match angle.abs() {
        a if a < STRAIGHT_DEG => "ahead".into(),
        a if a > 180.0 - STRAIGHT_DEG => "back".into(),
        a => format!("{a:.0}° {}", side(angle)),
    };
    format!("{:.2} m {towards}{turns}", p.length())
}

/// A number of things, such as `1 warning` or `2 warnings`.
pub fn counted(n: usize, thing: &str) -> String {
    format!("{n} {thing}{}", if n == 1 { "" } else { "s" })
}

/// A number with a suitable number of digits.
pub fn number(v: f32) -> String {
    match v.abs() {
        a if a >= 100.0 || a.fract() == 0.0 => format!("{v:.0}"),
        a if a >= 1.0 => format!("{v:.2}"),
        _ => format!("{v:.3}"),
    }
}

/// The side that a turn or a place lies at, positive to the left.
pub fn side(degrees: f32) -> &'static str {
    if degrees > 0.0 { "left" } else { "right" }
}

/// Activity of an inhabitant of a world, and how long it has waited.
pub fn inhabitant_activity(state: &InhabitantState) -> String {
    match state.activity {
        InhabitantActivity::Planning => "plans a path".to_owned(),
        InhabitantActivity::Waiting => format!("has waited {:.1} s for others", state.waited_s),
        activity => kind_of(activity).0.to_owned(),
    }
}

/// A character of a scene: its number, its group, and its activity.
pub fn character(simulation: &Simulation, who: usize) -> Option<String> {
    let group = simulation.groups().iter().find(|g| g.characters.contains(&who))?;
    let name = &group.name;
    if simulation.root(who).is_none() {
        return Some(format!("{who} · {name} · has left"));
    }
    let (character_group, member) = simulation.locate(who);
    let away = |target: Vec3| {
        let root = simulation.root(who)?.translation();
        Some(format!("{:.1}\u{a0}m\u{a0}away", (root - target).with_y(0.0).length()))
    };
    let what = match character_group {
        AnyCharacterGroup::Policy(_) => format!("target {}", simulation.target(who).and_then(away)?),
        AnyCharacterGroup::Sparring(_) => format!("opponent {}", simulation.target(who).and_then(away)?),
        AnyCharacterGroup::Patches(inhabited) => inhabitant_activity(&inhabited.state(member)),
        AnyCharacterGroup::Paths(wanderers) => format!("{:.1} m/s", wanderers.speed(member)),
        AnyCharacterGroup::Travel(travellers) if travellers.has_arrived(member) => "is there".to_owned(),
        AnyCharacterGroup::Travel(_) | AnyCharacterGroup::Ground(_) | AnyCharacterGroup::Air(_) => {
            format!("{:.2} m/s", simulation.disc(who)?.velocity.length())
        }
    };
    Some(format!("{who} · {name} · {what}"))
}

/// Goal of an inhabitant, as text.
///
/// - `tags`: names of the link tags of the bundle.
pub fn goal(goal: InhabitantGoal, tags: &[String]) -> String {
    let name = |tag: u16| tags.get(usize::from(tag).wrapping_sub(1)).map_or("something", String::as_str);
    match goal {
        InhabitantGoal::Roam => "roam".to_owned(),
        InhabitantGoal::GoTo { instance } => format!("go to patch {instance}"),
        InhabitantGoal::GoToPlace { place } => {
            format!("go to {:.1}, {:.1}, {:.1} m", place.at.x, place.at.y, place.at.z)
        }
        InhabitantGoal::GoNear { place, .. } => format!("go near {:.1}, {:.1}, {:.1} m", place.x, place.y, place.z),
        InhabitantGoal::Perform { tag, seconds } => format!("{} for {seconds:.0} s", name(tag)),
        InhabitantGoal::Meet { tag, seconds } => format!("{} with a partner for {seconds:.0} s", name(tag)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_is_where_x_grows() {
        assert_eq!(place(Vec2::new(2.0, 2.0)), "2.8 m away, 45° to the left");
        assert_eq!(place(Vec2::new(-1.0, 0.0)), "1.0 m away, 90° to the right");
        assert_eq!(place(Vec2::new(0.0, -3.0)), "3.0 m away, straight behind");
        assert_eq!(place(Vec2::ZERO), "where it stood");
    }

    #[test]
    fn a_displacement_names_distance_direction_and_turn() {
        assert_eq!(displacement(Planar::new(0.0, 0.61, 0.0)), "0.61 m ahead");
        assert_eq!(displacement(Planar::new(0.5, 0.5, -0.35)), "0.71 m 45° left, turns 20° right");
        assert_eq!(displacement(Planar::new(0.01, 0.0, 1.0)), "stays, turns 57° left");
        assert_eq!(displacement(Planar::IDENTITY), "stays");
    }
}
