//! Finds the role of each joint: by profile where one fits, else by name and topology.

use super::guess;
use super::profile::Profile;
use super::source::content_error;
use crate::ImportError;
use crate::raw::RawJoint;
use std::path::Path;
use throng_core::{Joint, NUM_JOINTS};

/// Which source joint plays which role of the database skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleMap {
    /// Index into the clip's joints by role; `None` where the source has no such joint.
    /// Hips, thighs, shins, feet, upper arms and one of neck and head are always there.
    pub joints: [Option<usize>; NUM_JOINTS],
    /// Name of the profile, or [`RoleMap::GUESSED`].
    pub profile: String,
    /// What the mapping is unsure of, one sentence each.
    pub warnings: Vec<String>,
}

impl RoleMap {
    /// What [`RoleMap::profile`] says where no profile fitted.
    pub const GUESSED: &str = "guessed from names and topology";

    /// The source joint of a role.
    pub fn get(&self, role: Joint) -> Option<usize> {
        self.joints[role.index()]
    }

    /// `role=joint` pairs of all roles found, in role order.
    pub fn pairs<'a>(&'a self, joints: &'a [RawJoint]) -> impl Iterator<Item = (Joint, &'a str)> + 'a {
        Joint::ALL.into_iter().filter_map(|r| Some((r, joints[self.get(r)?].name.as_str())))
    }
}

/// Maps the joints of a skeleton to roles.
///
/// - `wanted`: name of the profile to use, whatever else would fit.
/// - `path`: the file, as errors name it.
///
/// # Errors
/// [`ImportError::Content`] naming the missing role and the joints there are, or the profile that does not fit.
pub fn assign(
    joints: &[RawJoint],
    profiles: &[Profile],
    wanted: Option<&str>,
    path: &Path,
) -> Result<RoleMap, ImportError> {
    let map = match wanted {
        Some(name) => wanted_profile(joints, profiles, name, path)?,
        None => best_profile(joints, profiles).unwrap_or_else(|| guess::guess(joints)),
    };
    match missing_role(&map) {
        None => Ok(map),
        Some(role) => {
            let names: Vec<_> = joints.iter().filter(|j| !j.is_end).take(80).map(|j| j.name.as_str()).collect();
            let message = format!("no joint was found for the role `{role}` among: {}", names.join(", "));
            let help = "Write a skeleton profile that names it (data/skeletons/README.md says how) and add it to \
                        `profiles` in the config";
            Err(content_error(path, message, help))
        }
    }
}

fn wanted_profile(joints: &[RawJoint], all: &[Profile], name: &str, path: &Path) -> Result<RoleMap, ImportError> {
    let Some(profile) = all.iter().find(|p| p.name.eq_ignore_ascii_case(name)) else {
        let names: Vec<_> = all.iter().map(|p| p.name.as_str()).collect();
        let message = format!("there is no skeleton profile `{name}`, only: {}", names.join(", "));
        return Err(content_error(path, message, "Correct `profile` in the config"));
    };
    let Some(map) = profile.fit(joints) else {
        let (role, names) = profile.first_misfit(joints).map_or_else(Default::default, |(r, n)| (r.name(), n));
        let message = format!("the profile `{name}` does not fit: no joint `{names}` for the role `{role}`");
        return Err(content_error(path, message, "Leave `profile` out of the config to have it chosen"));
    };
    Ok(RoleMap { joints: map, profile: profile.name.clone(), warnings: Vec::new() })
}

fn best_profile(joints: &[RawJoint], profiles: &[Profile]) -> Option<RoleMap> {
    let mut best: Option<(&Profile, [Option<usize>; NUM_JOINTS])> = None;
    for profile in profiles {
        if best.is_some_and(|(b, _)| b.num_roles() >= profile.num_roles()) {
            continue;
        }
        if let Some(map) = profile.fit(joints) {
            best = Some((profile, map));
        }
    }
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
