//! Finds the role of each joint: by profile where one fits, else by the shape of the skeleton.

use super::shape::{self, NoPerson, SkeletonTree};
use super::{Profile, content_error};
use crate::ImportError;
use crate::raw::{RawClip, RawJoint};
use std::path::Path;
use throng_core::{Joint, NUM_JOINTS};

/// Source joint of each role of the database skeleton.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RoleMap {
    /// Index into the clip's joints by role; `None` where the source has no such joint.
    /// Hips, thighs, shins, feet, upper arms and one of neck and head are always there.
    pub joints: [Option<usize>; NUM_JOINTS],
    /// Name of the profile, or [`RoleMap::BY_SHAPE`].
    pub profile: String,
    /// Doubts about the mapping, one sentence each.
    pub warnings: Vec<String>,
}

impl RoleMap {
    /// Value of [`RoleMap::profile`] where no profile fitted.
    pub const BY_SHAPE: &str = "found by shape and names";

    /// The source joint of a role.
    pub fn get(&self, role: Joint) -> Option<usize> {
        self.joints[role.index()]
    }

    /// `role=joint` pairs of all roles found, in role order.
    pub fn pairs<'a>(&'a self, joints: &'a [RawJoint]) -> impl Iterator<Item = (Joint, &'a str)> + 'a {
        Joint::ALL.into_iter().filter_map(|r| Some((r, joints[self.get(r)?].name.as_str())))
    }
}

/// Maps the joints of a clip to roles.
///
/// A profile that fits decides by name; without one, the shape of the skeleton does. Either way the body is compared with its
/// motion: a side that is named wrong is reported.
///
/// - `wanted`: name of the profile to use, whatever else would fit.
///
/// # Errors
/// [`ImportError::Content`] for a skeleton that is no person, naming its joints, for a body whose sides are swapped, and for a
/// profile that does not fit.
pub fn assign(clip: &RawClip, profiles: &[Profile], wanted: Option<&str>) -> Result<RoleMap, ImportError> {
    let refuse = |e: NoPerson| content_error(&clip.path, e.message, &e.help);
    let named = match wanted {
        Some(name) => Some(wanted_profile(&clip.joints, profiles, name, &clip.path)?),
        None => best_profile(&clip.joints, profiles),
    };
    let tree = SkeletonTree::new(clip);
    let map = match named {
        Some(map) => {
            let mut map = check_profile(clip, &tree, map, wanted.is_some())?;
            let parted = shape::find_parted_limb(&tree, &map);
            // Another choice of joints may move as a body does; a user who names a profile knows its contents.
            let other = parted.as_ref().filter(|_| wanted.is_none()).and_then(|_| shape::recognise(&tree).ok());
            other.unwrap_or_else(|| {
                map.warnings.extend(parted);
                map
            })
        }
        None => shape::recognise(&tree).map_err(refuse)?,
    };
    shape::check_stance(&tree, &map).map_err(refuse)?;
    Ok(map)
}

/// Checks the roles that a profile has given, and exchanges sides that are named wrong.
fn check_profile(clip: &RawClip, tree: &SkeletonTree, mut map: RoleMap, wanted: bool) -> Result<RoleMap, ImportError> {
    if let Some(role) = missing_role(&map) {
        let names: Vec<_> = clip.joints.iter().filter(|j| !j.is_end).take(80).map(|j| j.name.as_str()).collect();
        let message =
            format!("the profile `{}` names no joint for the role `{role}` among: {}", map.profile, names.join(", "));
        let help = "Complete the profile (data/skeletons/README.md says what is needed)";
        return Err(content_error(&clip.path, message, help));
    }
    match shape::check_role_sides(tree, &map) {
        Ok(wrong) => wrong.correct(&mut map),
        Err(e) if wanted => map.warnings.push(e.message),
        Err(e) => return Err(content_error(&clip.path, e.message, &e.help)),
    }
    Ok(map)
}

fn wanted_profile(joints: &[RawJoint], all: &[Profile], name: &str, path: &Path) -> Result<RoleMap, ImportError> {
    let Some(profile) = all.iter().find(|p| p.name.eq_ignore_ascii_case(name)) else {
        let names: Vec<_> = all.iter().map(|p| p.name.as_str()).collect();
        let message = format!("there is no skeleton profile `{name}`, only: {}", names.join(", "));
        return Err(content_error(path, message, "Correct `profile` in the config"));
    };
    let Some(map) = profile.match_joints(joints) else {
        let (role, names) = profile.first_misfit(joints).map_or_else(Default::default, |(r, n)| (r.name(), n));
        let message = format!("the profile `{name}` does not fit: no joint `{names}` for the role `{role}`");
        return Err(content_error(path, message, "Leave `profile` out of the config to have it chosen"));
    };
    Ok(RoleMap { joints: map, profile: profile.name.clone(), warnings: Vec::new() })
}

fn best_profile(joints: &[RawJoint], profiles: &[Profile]) -> Option<RoleMap> {
    let fitting = profiles.iter().filter_map(|p| Some((p, p.match_joints(joints)?)));
    let best = fitting.reduce(|best, next| if next.0.num_roles() > best.0.num_roles() { next } else { best });
    best.map(|(p, map)| RoleMap { joints: map, profile: p.name.clone(), warnings: Vec::new() })
}

/// The name of the first required role that is missing.
fn missing_role(map: &RoleMap) -> Option<&'static str> {
    use Joint::*;
    const REQUIRED: [Joint; 9] =
        [Hips, LeftThigh, LeftShin, LeftFoot, RightThigh, RightShin, RightFoot, LeftUpperArm, RightUpperArm];
    if let Some(role) = REQUIRED.into_iter().find(|&r| map.get(r).is_none()) {
        return Some(role.name());
    }
    (map.get(Neck).is_none() && map.get(Head).is_none()).then_some("head")
}
