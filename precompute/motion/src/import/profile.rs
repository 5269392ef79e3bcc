//! Skeleton profiles: which joint of a known source skeleton plays which role.

use crate::{ImportError, raw::RawJoint};
use std::{collections::BTreeMap, path::Path};
use throng_base::text::{TomlSource, did_you_mean};
use throng_core::{Joint, NUM_JOINTS};

/// The profiles that are built in.
const BUILT_IN: [&str; 8] = [
    include_str!("../../../../data/skeletons/throng.toml"),
    include_str!("../../../../data/skeletons/cmu-asf.toml"),
    include_str!("../../../../data/skeletons/cmu-cgspeed.toml"),
    include_str!("../../../../data/skeletons/snu.toml"),
    include_str!("../../../../data/skeletons/bandai-namco.toml"),
    include_str!("../../../../data/skeletons/mixamo.toml"),
    include_str!("../../../../data/skeletons/lafan1.toml"),
    include_str!("../../../../data/skeletons/smpl.toml"),
];

/// A profile as it is written.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct ProfileFile {
    name: String,
    source: String,
    roles: BTreeMap<String, JointNames>,
}

/// One spelling of a joint's name or several.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(untagged)]
enum JointNames {
    One(String),
    Several(Vec<String>),
}

impl JointNames {
    fn as_slice(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}

/// Roles of a known skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Name in configs and reports.
    pub name: String,
    /// Source of such files.
    pub source: String,
    roles: Vec<(Joint, JointNames)>,
}

impl Profile {
    /// Reads a profile from TOML text; `path` is for errors.
    ///
    /// # Errors
    /// [`ImportError::Content`] for TOML faults, unknown roles, and a file without roles. Missing roles are reported for the
    /// first clip that the profile fits.
    pub fn parse(toml_text: &str, path: &Path) -> Result<Self, ImportError> {
        Self::from_source(&TomlSource::new(toml_text, path))
    }

    fn from_source(source: &TomlSource) -> Result<Self, ImportError> {
        let help = "See data/skeletons/README.md for how a profile is written.";
        let file: ProfileFile = source.parse(help)?;
        if file.roles.is_empty() {
            // A profile without roles would fit every skeleton.
            return Err(source.error_at_key("roles", format!("expected at least one role. {help}")).into());
        }
        let mut roles = Vec::new();
        for (role, names) in file.roles {
            let Some(joint) = Joint::from_name(&role) else {
                let meant = did_you_mean(&role, Joint::ALL.into_iter().map(Joint::name));
                let why = format!("unknown role `{role}`.{meant} {help}");
                return Err(source.error_at_key(&format!("roles.{role}"), why).into());
            };
            roles.push((joint, names));
        }
        roles.sort_by_key(|(joint, _)| joint.index());
        Ok(Self { name: file.name, source: file.source, roles })
    }

    /// The joint of each role, if the skeleton has one for every role of the profile.
    pub(super) fn match_joints(&self, joints: &[RawJoint]) -> Option<[Option<usize>; NUM_JOINTS]> {
        let mut map = [None; NUM_JOINTS];
        for (role, names) in &self.roles {
            map[role.index()] = Some(find_joint(joints, names.as_slice())?);
        }
        Some(map)
    }

    /// The first role for which the skeleton has no joint, and the names that were tried.
    pub(super) fn first_misfit(&self, joints: &[RawJoint]) -> Option<(Joint, String)> {
        let (role, names) = self.roles.iter().find(|(_, names)| find_joint(joints, names.as_slice()).is_none())?;
        Some((*role, names.as_slice().join("` or `")))
    }

    /// Number of roles that it names.
    pub(super) fn num_roles(&self) -> usize {
        self.roles.len()
    }
}

fn find_joint(joints: &[RawJoint], names: &[String]) -> Option<usize> {
    names.iter().find_map(|n| joints.iter().position(|j| !j.is_end && plain(&j.name).eq_ignore_ascii_case(n)))
}

/// A joint's name without its namespace.
pub(super) fn plain(name: &str) -> &str {
    name.rsplit([':', '|']).next().unwrap_or(name).trim()
}

/// The profiles of `files`, then the built-in ones.
///
/// # Errors
/// Errors of [`Profile::parse`], and [`ImportError::Io`].
pub fn load_profiles(files: &[std::path::PathBuf]) -> Result<Vec<Profile>, ImportError> {
    let given = files.iter().map(|path| Profile::from_source(&TomlSource::read(path, "a skeleton profile")?));
    let built_in = BUILT_IN.iter().map(|text| Profile::parse(text, Path::new("built-in skeleton profile")));
    given.chain(built_in).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_profiles_load_and_name_both_sides() {
        for p in load_profiles(&[]).unwrap() {
            let has = |j: Joint| p.roles.iter().any(|(r, _)| *r == j);
            assert!(Joint::ALL.into_iter().all(|j| has(j) == has(j.mirrored())), "{}", p.name);
            assert!(p.num_roles() >= 20, "{}", p.name);
        }
    }

    #[test]
    fn an_unknown_role_is_refused_with_the_nearest_one() {
        let e = Profile::parse("name='a'\nsource='b'\n[roles]\nleft_shn='x'", Path::new("p.toml")).unwrap_err();
        assert!(e.to_string().contains("p.toml:4:1: unknown role `left_shn`. Did you mean `left_shin`?"), "{e}");
    }

    #[test]
    fn a_profile_without_roles_is_refused() {
        let e = Profile::parse("name='a'\nsource='b'\n[roles]\n", Path::new("p.toml")).unwrap_err();
        assert!(e.to_string().contains("p.toml:3:2: expected at least one role"), "{e}");
    }

    #[test]
    fn namespaces_are_dropped() {
        assert_eq!(plain("mixamorig:Hips"), "Hips");
        assert_eq!(plain("a|b:Left Arm "), "Left Arm");
    }
}
